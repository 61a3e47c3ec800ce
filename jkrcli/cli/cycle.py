"""``jkr cycle``: the trace that a device of given stiffness records."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import click

from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
from ..adhesion.device_path import Course, Program
from ..adhesion.finite_range import RangeRequest
from ..adhesion.from_rest import LoadingHistory, Rest
from ..adhesion.rate import RateContact, parameters_of, rate_law_of
from ..adhesion.relaxation import RelaxingContact
from ..adhesion.relaxing_adhesion import RelaxingAdhesion
from ..base.errors import InputError
from ..base.files import together
from ..base.registry import Result
from ..methods.protocol import Limits
from ..report.forward import Cycled, CycledByProgram
from ..report.rate import CycledAtSpeed, CycledInLimits, CycledRelaxing, followed_with_limits, traced_histories
from ..report.result import PICTURES, Output
from ..resolve.analysis import analyse, with_solved_points
from ..resolve.histories import curves_from_rest, pull_off_in_limits, rest_of
from ..series import Solution
from ..tables import rows_of_text
from . import inputs, options
from .options import flag, typed
from .printing import give

# --------------------------------------------------------------------------------------------------
# ``jkr cycle`` over time: what the device does, while adhesion depends on the edge's speed or the body relaxes.

# What a table of the instrument's positions costs.
TABLE_CYCLE_PER_ROW = 0.012  # CPU seconds of `jkr cycle --program`; tuned on 100 and 1,000 rows, by `make guards`
TABLE_CYCLE_MIB_PER_ROW = 0.05  # of memory; tuned on the same, by `make guards`
TABLE_CYCLE_PER_POINT = 1.2e-5  # CPU seconds of what is written for each; tuned on the same, by `make guards`
ALONE = ("speed", "speed_approach", "hold", "dwell", "dwell_time")  # what a program says by itself


@dataclass(frozen=True)
class RateOptions:
    """What the command line says the device does, as text where it depends on the control; None: not given."""

    to_load: float | None = typed(
        options.LOAD, "Reverse at this load [default: at the end of the solution, later creep included]."
    )
    to_depth: float | None = typed(options.LENGTH, "Reverse at this displacement delta.")
    rate: Mapping[str, str] | None = typed(
        options.PAIRS, 'w0 (1 + (v/v0)^n) on retraction: v0="1 um/s",n=0.6; law=log,v0=...,b="5 mJ/m^2": '
        "w0 + b log(1 + v/v0). w0 is --w-retract.")  # fmt: skip
    rate_advance: Mapping[str, str] | None = typed(
        options.PAIRS, "The same for approach [default: no dependence on speed]."
    )
    speed: str | None = typed(str, 'Of the instrument, "10 um/s"; of the load under load control, "1 mN/s".')
    speed_approach: str | None = typed(str, "The same on approach [default: --speed].")
    hold: str | None = typed(str, 'Time to wait at the reversal, "10 s".')
    dwell: str | None = typed(str, "Retract to this position (load under load control) and dwell there.")
    dwell_time: str | None = typed(str, "Duration of the dwell.")
    program: Path | None = typed(  # noqa: RUF009  # a field
        options.FileType(), "Table t, x of the instrument instead: times [s] and positions (loads) between which "
        "it moves evenly; equal times are steps.")  # fmt: skip
    stress: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None and (self.speed is None) == (self.program is None):
            raise InputError('cycle: --rate needs the motion of the instrument: --speed "10 um/s", or --program TABLE')
        if self.rate_advance is not None and self.rate is None:
            raise InputError("cycle: --rate-advance needs --rate: leave it out, or give both")
        self._course.refuse_idle(flag)

    @property
    def named(self) -> list[str]:
        """The fields that were given, but the rate and the turn."""
        beside = ("rate", "to_load", "to_depth")
        return [name for name, value in vars(self).items() if value is not None and name not in beside]

    def refuse_without_time(self) -> None:
        """InputError where options of time are given for what does not depend on it."""
        if self.rate is None and (timed := [name for name in self.named if name != "program"]):
            raise InputError(f"cycle: {flag(timed[0])} needs --rate: without it nothing depends on time")

    @property
    def timed(self) -> bool:
        """Whether they say what the device does over time, to a body that relaxes."""
        return self.rate is None and (self.speed is not None or self.program is not None)

    def refuse_in_limits(self, ranged: bool) -> None:
        """InputError where they say what a body does over time that relaxes and adheres, but not all of it."""
        if self.rate is None and self.named and not (ranged and self.timed):
            raise InputError(
                f"cycle: {flag(self.named[0])}: adhesion of a viscoelastic specimen at a given speed needs a cohesive "
                "stress or range: add --stress or --range; without --speed the limits are computed (very fast, very "
                "slow, from rest); without adhesion: --w-approach 0"
            )

    def program_of(self, contact: RateContact | RelaxingContact | RelaxingAdhesion) -> Program:
        """What the device does, of the table or of the speeds."""
        if self.program is not None:
            return read_program(self.program, contact.stiffness)
        return self._course.program(contact, flag)

    def pulled(self, x: float, stiffness: float) -> Program:
        """What the device does from rest at its position ``x`` on: back at once, to a dwell where there is one."""
        self._course.refuse_before_rest(flag)
        moves = self._course.moves(stiffness == LOAD_CONTROL, flag)
        whole = Program.on(x, -moves.back)
        return whole if moves.dwell is None else whole.dwelling(moves.dwell, moves.dwell_time)

    def refuse_wrong(self, stiffness: float) -> None:
        """InputError where a speed, time or place is none, before anything is solved."""
        if self.speed is not None:
            self._course.moves(stiffness == LOAD_CONTROL, flag)

    def suffix(self, stiffness: float) -> str:
        """What distinguishes names of files, of the options that were given: ``-to-load0.0005-speed1e-05``, SI."""
        si: dict[str, float | None] = {"to_load": self.to_load, "to_depth": self.to_depth}
        parts = list[str]()
        for name, pairs in (("rate", self.rate), ("rate_advance", self.rate_advance)):
            if pairs is not None:
                law, values = parameters_of(rate_law_of(pairs, flag(name)))
                parts.append("-".join([f"{flag(name)[1:]}-{law}", *(f"{value:g}" for value in values.values())]))
        if self.speed is not None:
            moves = self._course.moves(stiffness == LOAD_CONTROL, flag)
            told = (moves.back, moves.there, moves.hold, moves.dwell, moves.dwell_time)
            si |= {name: x for name, x in zip(ALONE, told, strict=True) if getattr(self, name) is not None}
        parts += [f"{flag(name)[1:]}{x:g}" for name, x in si.items() if x is not None]
        return "".join([*parts, "" if self.program is None else f"-program-{self.program.stem}"])

    @property
    def _course(self) -> Course:
        named = {name: getattr(self, name) for name in ("to_load", "to_depth", *ALONE)}
        return Course(**named, tabulated=self.program)


rate_options = options.as_one("rates", RateOptions)


def cycled(
    solution: Solution, works: tuple[float, float], stiffness: float, points: int, how: options.CurveOptions,
    rates: RateOptions, ranged: RangeRequest, history: LoadingHistory | None = None,
) -> Result:  # fmt: skip
    """The cycle with the ``works`` of adhesion [J/m^2] on approach and retraction by a device of a ``stiffness`` [N/m];
    that of a viscoelastic specimen at the moduli after a loading ``history``."""
    share, words = (1.0, "") if history is None else (history.moduli, history.words)
    curves = analyse(solution, works, how.slopes, how.modulus_factor * share, ranged)
    inwards, outwards = results = [with_solved_points(curve, stiffness) for curve in curves]

    # A body that relaxes over time, without adhesion
    if (law := solution.problem.specimen.relaxation) is not None and history is None:
        if rates.rate is not None:
            raise InputError("cycle: --rate needs adhesion: give --w-approach, or leave it out")
        if rates.speed is None and rates.program is None:
            raise InputError('cycle: viscoelastic specimen: give the motion, --speed "10 um/s" or --program TABLE')
        relaxing = RelaxingContact(inwards.jkr.nonadhesive, law, stiffness)
        return CycledRelaxing.of(relaxing, rates.program_of(relaxing), inwards.path, points)

    # A body that does not: with a w that depends on the speed of the edge, by a table, or there and back
    if rates.rate is not None:
        outwards_law = rate_law_of(rates.rate, "--rate")
        advance = None if rates.rate_advance is None else rate_law_of(rates.rate_advance, "--rate-advance")
        contact = RateContact(outwards.jkr.nonadhesive, outwards_law, outwards.w, inwards.w, stiffness, advance)
        program = rates.program_of(contact)
        return CycledAtSpeed.of(contact, program, outwards, stress=rates.stress, points=points, history=words)
    if rates.program is not None:
        return CycledByProgram.of(results, stiffness, read_program(rates.program, stiffness), points)
    return Cycled.of(results, stiffness, rates.to_load, rates.to_depth, points, words)


def followed(
    solution: Solution, works: tuple[float, float], stiffness: float, points: int, how: options.CurveOptions,
    rates: RateOptions, ranged: RangeRequest, rest: Rest | None, compare_rate: bool,
) -> Result:  # fmt: skip
    """Adhesion of a viscoelastic specimen over time, from ``rest`` on where there is one, with its limits."""
    law, slopes, factor, w = solution.problem.specimen.relaxation, how.slopes, how.modulus_factor, works[1]
    assert law is not None
    contact = RelaxingAdhesion.of(solution.scaled(factor), ranged.law(w), law, stiffness)
    if rest is None:
        program = rates.program_of(contact)
    else:
        contact = replace(contact, rests=True)
        program = rates.pulled(contact.pulled_from(rest), stiffness)
    histories = traced_histories(solution, rest, rates.to_load, rates.to_depth)
    at_rest = next((one for one in histories if one.rest is not None), None)
    limits = pull_off_in_limits(solution, w, ranged, at_rest, slopes, factor)
    return followed_with_limits(solution, contact, program, limits, slopes, factor, points, compare_rate=compare_rate)


def read_program(path: Path, stiffness: float) -> Program:
    """What the table at ``path`` says that a device of ``stiffness`` [N/m] does."""
    from ..data import foreign

    dimension = "load" if stiffness == LOAD_CONTROL else "length"
    return Program(*foreign.read_program(path, dimension))


@options.verb("file")
@click.option("--w-approach", type=options.WORK, help="On approach [default: the case's first w].")
@click.option("--w-retract", type=options.WORK, help="On retraction, not smaller [default: that of approach].")
@click.option("--stiffness", type=options.CONTROL, default="rigid", show_default=True,
              help='"0.2 N/m", "rigid" or "load".')  # fmt: skip
@rate_options
@click.option("--rest-load", type=options.LOAD, help="Viscoelastic specimens: at rest under this load, then pulled "
              "instantly, with --stress at --speed [default: at the reversal of --to-load or "
              "--to-depth, or P = 0].")  # fmt: skip
@click.option("--rest-depth", type=options.LENGTH, help="The same at this displacement delta.")
@click.option("--compare-rate", is_flag=True, help="Viscoelastic specimens, with --stress and --speed: result of a law "
              "w(v) of the same material, with the relaxed modulus.")  # fmt: skip
@click.option("--points", type=click.IntRange(2, 100_000), default=200, show_default=True, help="Rows per branch.")
@options.curve_options
@options.limits_options
@options.into_folder()
@options.output_options(plots="Write the CSV only.", json="Print the figures as JSON.")
def cycle(
    file: Path, w_approach: float | None, w_retract: float | None, stiffness: float, points: int,
    how: options.CurveOptions, rates: RateOptions, rest_load: float | None, rest_depth: float | None,
    compare_rate: bool, limits: Limits, output: Output,
) -> None:  # fmt: skip
    """Compute the cycle of approach and retraction on FILE, a case or a solution file: load, displacement and contact
    radius, jumps, energy lost.

    Without --speed the cycle is quasi-static: jump-in at delta = 0, loss of contact where d(delta + P/stiffness)/da =
    0. With --stress or --range the surfaces attract each other before contact (Maugis-Dugdale). With --rate and --speed
    w depends on the speed of the contact line (--stress is then the cohesive stress of the dissipating zone). A
    viscoelastic specimen needs --speed, and with adhesion --stress or --range; without --speed its limits are computed:
    very fast, very slow, and pulled instantly from rest. Writes <stem>-cycle.csv, .png and .svg, the given options in
    the name in SI, as in <stem>-cycle-w-retract0.045-to-load0.0005.csv.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    jkr cycle gel.h5 --rate v0="1 um/s",n=0.6 --speed "10 um/s"
    jkr cycle relaxing-gel.h5 --w-approach 0 --speed "10 um/s" --hold "30 s"
    jkr cycle relaxing-gel.h5 --w-approach 0.02 --stress "2 kPa" --speed "10 um/s"
    """
    rates.refuse_wrong(stiffness)
    output.folder(Path())
    file = inputs.series_file(file)
    solution = inputs.read_series(file)
    law = solution.problem.specimen.relaxation
    if law is None:
        rates.refuse_without_time()
    if w_approach is not None:
        approach = w_approach
    elif law is not None and not solution.record.w:  # of a specimen that relaxes 0 where none is named
        approach = 0.0
    else:
        approach = inputs.works_of(solution, "--w-approach")[0]
    works = approach, approach if w_retract is None else w_retract
    adhering = law is not None and any(works)
    if adhering:
        rates.refuse_in_limits(bool(how.of(solution)))
    in_limits = adhering and not rates.timed
    if compare_rate and (in_limits or not adhering):
        raise InputError("cycle: --compare-rate is for adhesion on a viscoelastic specimen: give --stress and --speed")
    if rates.rate is not None:  # there the stress is that of the zone in which energy is lost
        rates, how = replace(rates, stress=how.stress), replace(how, stress=None)
    ranged = how.of(solution)
    if ranged and rates.rate is not None:
        raise InputError("cycle: --rate has no adhesion of finite range: leave --range and the case's out")
    ranged.refuse_two(*works)
    if rates.program is not None:
        per_row = TABLE_CYCLE_PER_ROW + TABLE_CYCLE_PER_POINT * points
        inputs.begin_tables("cycle --program", rows_of_text(rates.program), limits,
                            "fewer rows of the program, or fewer --points", per_row=per_row,
                            mib_per_row=TABLE_CYCLE_MIB_PER_ROW)  # fmt: skip
    rest, known = rest_of(rest_load, rest_depth, flag), tuple[LoadingHistory, ...]()
    if in_limits:
        rests = rates.rate is None and not ranged
        known = traced_histories(solution, rest, rates.to_load, rates.to_depth, rests)
    elif rest is not None and not adhering:
        raise InputError(
            "cycle: --rest-load and --rest-depth are for adhesion on a viscoelastic specimen: leave them out"
        )

    names = [one.name for one in known] or [""]
    ends = _told(w_approach, w_retract, stiffness, rates, rest, ranged, how.modulus_factor)
    stem = output.folder(file.parent) / f"{file.stem}-cycle{ends}"
    named = [stem.with_name("-".join([stem.name, *name.split()])) for name in names]
    targets = [output.files(one, (".csv", *PICTURES), [file]) for one in named]
    inputs.begin_curves("cycle", [solution], [works], limits, [ranged])

    asked = solution, works, stiffness, points, how, rates, ranged

    def after(history: LoadingHistory) -> Result:
        if history.rest is None:
            return cycled(*asked, history)
        curves = curves_from_rest(solution, works, history, how.slopes, how.modulus_factor, stiffness)
        return Cycled.from_rest(solution.record.path, *curves, stiffness, points, history.words)

    if known:
        result: Result = CycledInLimits.of(file, known, after)
    else:
        result = followed(*asked, rest, compare_rate) if adhering else cycled(*asked)
    cycles = [one for _, one in result.limits.values()] if isinstance(result, CycledInLimits) else [result]
    with together():
        for one, files in zip(cycles, targets, strict=True):
            files.write(one.columns, figure=files.draw(one.figure))
    give(result, output.json, f"  written {', '.join(map(str, targets))}", file)


def _told(
    approach: float | None, retraction: float | None, stiffness: float, rates: RateOptions, rest: Rest | None,
    ranged: RangeRequest, factor: float,
) -> str:  # fmt: skip
    """What distinguishes names of files, of what was given: works of adhesion [J/m^2], a ``stiffness`` [N/m], speeds, a
    rest, a range and a ``factor`` of the moduli."""
    works = (("approach", approach), ("retract", retraction))
    parts = [f"-w-{name}{w:g}" for name, w in works if w is not None]
    if stiffness == LOAD_CONTROL:
        parts.append("-stiffness-load")
    elif stiffness != DISPLACEMENT_CONTROL:
        parts.append(f"-stiffness{stiffness:g}")
    parts.append(rates.suffix(stiffness))
    if rest is not None:
        parts.append(f"-rest-load{rest.load:g}" if rest.depth is None else f"-rest-depth{rest.depth:g}")
    parts.append(ranged.suffix)
    if rates.stress is not None:
        parts.append(f"-stress{rates.stress:g}")
    return "".join(parts if factor == 1 else [*parts, f"-modulus{factor:g}"])

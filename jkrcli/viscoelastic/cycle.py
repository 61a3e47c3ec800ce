"""``jkr cycle``: the trace that a device of given stiffness records, over time too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import click

from ..base.errors import InputError
from ..base.registry import Result
from ..cli import inputs, options
from ..cli.cycle import (
    PROGRAM,
    TO_DEPTH,
    TO_LOAD,
    begin_program,
    end_options,
    name_suffix,
    read_program,
    works_of,
    works_options,
    write_cycle,
)
from ..cli.options import flag, typed
from ..methods.protocol import Limits
from ..report.result import Output

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..adhesion.device_path import Program
    from ..report.forward import AskedCycle
    from .course import Course
    from .from_rest import LoadingHistory, Rest
    from .rate import RateContact
    from .relaxation import RelaxingContact
    from .relaxing_adhesion import RelaxingAdhesion

# --------------------------------------------------------------------------------------------------
# ``jkr cycle`` over time: what the device does, while adhesion depends on the edge's speed or the body relaxes.

ALONE = ("speed", "speed_approach", "hold", "dwell", "dwell_time")  # what a program says by itself


@dataclass(frozen=True)
class RateOptions:
    """What the command line says the device does, as text where it depends on the control; None: not given."""

    to_load: float | None = typed(options.LOAD, TO_LOAD)
    to_depth: float | None = typed(options.LENGTH, TO_DEPTH)
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
    program: Path | None = typed(options.FileType(), PROGRAM)  # noqa: RUF009  # a field
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

    @property
    def timed(self) -> bool:
        """Whether they say what the device does over time, to a viscoelastic body."""
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
        return read_program(self.program, contact.stiffness) or self._course.program(contact, flag)

    def pulled(self, x: float, stiffness: float) -> Program:
        """What the device does from rest at its position ``x`` on: back at once, to a dwell where there is one."""
        from ..adhesion.curve import LOAD_CONTROL
        from ..adhesion.device_path import Program

        self._course.refuse_before_rest(flag)
        moves = self._course.moves(stiffness == LOAD_CONTROL, flag)
        whole = Program.on(x, -moves.back)
        return whole if moves.dwell is None else whole.dwelling(moves.dwell, moves.dwell_time)

    def refuse_wrong(self, stiffness: float) -> None:
        """InputError where a speed, time or place is none, before anything is solved."""
        from ..adhesion.curve import LOAD_CONTROL

        if self.speed is not None:
            self._course.moves(stiffness == LOAD_CONTROL, flag)

    def suffix(self, stiffness: float) -> str:
        """What distinguishes names of files, of the options that were given: ``-to-load0.0005-speed1e-05``, SI."""
        from ..adhesion.curve import LOAD_CONTROL
        from .rate import parameters_of, rate_law_of

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
        from .course import Course

        named = {name: getattr(self, name) for name in ("to_load", "to_depth", *ALONE)}
        return Course(**named, tabulated=self.program)


rate_options = options.as_one("rates", RateOptions)
rest_options = options.several(
    click.option("--rest-load", type=options.LOAD, help="Viscoelastic specimens: at rest under this load, then pulled "
                 "instantly, with --stress at --speed [default: at the reversal of --to-load or "
                 "--to-depth, or P = 0]."),
    click.option("--rest-depth", type=options.LENGTH, help="The same at this displacement delta."),
)  # fmt: skip


def cycled(asked: AskedCycle, rates: RateOptions, history: LoadingHistory | None = None) -> Result:
    """The cycle without adhesion on a viscoelastic body; else with a w that depends on the speed of the edge where the
    ``rates`` say so, of a viscoelastic specimen at the moduli after a loading ``history``, or quasi-static."""
    from ..resolve.analysis import analyse, nonadhesive, with_solved_points
    from .by_history import cycle_after
    from .rate import RateContact, rate_law_of
    from .relaxation import RelaxingContact
    from .report import CycledAtSpeed, CycledRelaxing

    law, stiffness = asked.solution.problem.specimen.relaxation, asked.stiffness
    if law is not None and history is None:
        if rates.rate is not None:
            raise InputError("cycle: --rate needs adhesion: give --w-approach, or leave it out")
        if rates.speed is None and rates.program is None:
            raise InputError('cycle: viscoelastic specimen: give the motion, --speed "10 um/s" or --program TABLE')
        body = nonadhesive(asked.solution, asked.slopes).scaled(asked.modulus_factor)
        relaxing = RelaxingContact(body, law, stiffness)
        return CycledRelaxing.of(relaxing, rates.program_of(relaxing), asked.solution.record.path, asked.points)
    if rates.rate is None:
        return asked.quasi_static() if history is None else cycle_after(asked, history)
    share, words = (1.0, "") if history is None else (history.moduli, history.words)
    outwards_law = rate_law_of(rates.rate, "--rate")
    advance = None if rates.rate_advance is None else rate_law_of(rates.rate_advance, "--rate-advance")
    result = analyse(asked.solution, asked.works[1:], asked.slopes, asked.modulus_factor * share, asked.ranged)[0]
    outwards = with_solved_points(result, stiffness)
    contact = RateContact(outwards.jkr.nonadhesive, outwards_law, *asked.works[::-1], stiffness, advance)
    program = rates.program_of(contact)
    return CycledAtSpeed.of(contact, program, outwards, stress=rates.stress, points=asked.points, history=words)


def followed(asked: AskedCycle, rates: RateOptions, rest: Rest | None, compare_rate: bool) -> Result:
    """Adhesion of a viscoelastic specimen over time, from ``rest`` on where there is one, with its limits."""
    from .by_history import traced_histories
    from .relaxing_adhesion import RelaxingAdhesion
    from .report import followed_with_limits, pull_off_in_limits

    solution, w, ranged, stiffness = asked.solution, asked.works[1], asked.ranged, asked.stiffness
    law, slopes, factor = solution.problem.specimen.relaxation, asked.slopes, asked.modulus_factor
    assert law is not None
    contact = RelaxingAdhesion.of(solution.scaled(factor), ranged.law(w), law, stiffness)
    if rest is None:
        program = rates.program_of(contact)
    else:
        contact = replace(contact, rests=True)
        program = rates.pulled(contact.pulled_from(rest), stiffness)
    histories = traced_histories(solution, rest, asked.to_load, asked.to_depth)
    at_rest = next((one for one in histories if one.rest is not None), None)
    limits = pull_off_in_limits(solution, w, ranged, at_rest, slopes, factor)
    points = asked.points
    return followed_with_limits(solution, contact, program, limits, slopes, factor, points, compare_rate=compare_rate)


@options.verb("file")
@works_options
@rate_options
@rest_options
@click.option("--compare-rate", is_flag=True, help="Viscoelastic specimens, with --stress and --speed: result of a law "
              "w(v) of the same material, with the relaxed modulus.")  # fmt: skip
@end_options
def cycle(
    file: Path, w_approach: float | None, w_retract: float | None, stiffness: float, points: int,
    how: options.CurveOptions, rates: RateOptions, rest_load: float | None, rest_depth: float | None,
    compare_rate: bool, limits: Limits, output: Output,
) -> None:  # fmt: skip
    """Compute the cycle of approach and retraction on FILE, a case or a solution file: load, displacement and contact
    radius, jumps, energy lost.

    Without --speed the cycle is quasi-static: contact begins at delta = 0 and is lost where d(delta + P/stiffness)/da
    is zero. With --stress or --range, the surfaces attract each other before contact (Maugis-Dugdale). With --rate and
    --speed, w depends on the speed of the contact line, and --stress is the cohesive stress of the dissipating zone. A
    viscoelastic specimen needs --speed, and with adhesion --stress or --range. Without --speed, jkr computes three
    limits: very fast, very slow, and pulled instantly from rest. The results are <stem>-cycle.csv, .png and .svg; the
    options given add their values in SI units to the names, as in <stem>-cycle-w-retract0.045.csv.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    jkr cycle gel.h5 --rate v0="1 um/s",n=0.6 --speed "10 um/s"
    jkr cycle relaxing-gel.h5 --w-approach 0 --speed "10 um/s" --hold "30 s"
    jkr cycle relaxing-gel.h5 --w-approach 0.02 --stress "2 kPa" --speed "10 um/s"
    """
    from ..report.forward import AskedCycle
    from .by_history import CycledInLimits, traced_histories
    from .from_rest import Rest

    rates.refuse_wrong(stiffness)
    output.folder(Path())
    file = inputs.series_file(file)
    solution = inputs.read_series(file)
    relaxes = solution.problem.specimen.relaxation is not None
    if not relaxes and rates.rate is None and (timed := [name for name in rates.named if name != "program"]):
        raise InputError(f"cycle: {flag(timed[0])} needs --rate: without it nothing depends on time")
    silent = relaxes and w_approach is None and not solution.record.w  # of a specimen that relaxes: no adhesion
    works = works_of(solution, 0.0 if silent else w_approach, w_retract)
    adhering = relaxes and any(works)
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
    begin_program(rates.program, points, limits)
    rest = Rest.of(rest_load, rest_depth, flag)
    known: tuple[LoadingHistory, ...] = ()
    if in_limits:
        rests = rates.rate is None and not ranged
        known = traced_histories(solution, rest, rates.to_load, rates.to_depth, rests)
    elif rest is not None and not adhering:
        raise InputError(
            "cycle: --rest-load and --rest-depth are for adhesion on a viscoelastic specimen: leave them out"
        )

    def one() -> Result:
        return followed(asked, rates, rest, compare_rate) if adhering else cycled(asked, rates)

    program, ways = read_program(rates.program, stiffness), (how.slopes, how.modulus_factor)
    asked = AskedCycle(solution, works, stiffness, ranged, *ways, rates.to_load, rates.to_depth, program, points)
    turn, zone = rates.suffix(stiffness), "" if rates.stress is None else f"-stress{rates.stress:g}"
    turn += "" if rest is None else rest.suffix
    ends = name_suffix(w_approach, w_retract, stiffness, turn, ranged, zone, how.modulus_factor)
    cycles = {history.name: partial(cycled, asked, rates, history) for history in known}
    of_all = partial(CycledInLimits.of, file, known) if known else None
    write_cycle(file, ends, cycles or {"": one}, asked, limits, output, of_all)

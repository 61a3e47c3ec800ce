"""``jkr cycle``: the trace that a device of given stiffness records, quasi-statically."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from ..base.errors import InputError
from ..base.files import together
from ..base.registry import Result
from ..base.wings import absent
from ..methods.protocol import Limits
from ..report.result import PICTURES, Output
from . import inputs, options
from .options import flag, typed
from .printing import give

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..adhesion.device_path import Program
    from ..adhesion.finite_range import RangeRequest
    from ..adhesion.from_rest import LoadingHistory, Rest
    from ..report.forward import AskedCycle
    from ..series import Solution

# What a table of the instrument's positions costs.
TABLE_CYCLE_PER_ROW = 0.012  # CPU seconds of `jkr cycle --program`; tuned on 100 and 1,000 rows, by `make guards`
TABLE_CYCLE_MIB_PER_ROW = 0.05  # of memory; tuned on the same, by `make guards`
TABLE_CYCLE_PER_POINT = 1.2e-5  # CPU seconds of what is written for each; tuned on the same, by `make guards`

TO_LOAD = "Reverse at this load [default: at the end of the solution, later creep included]."
TO_DEPTH = "Reverse at this displacement delta."
PROGRAM = ("Table t, x of the instrument instead: times [s] and positions (loads) between which it moves evenly; equal "
           "times are steps.")  # fmt: skip
NO_REST = "cycle: --rest-load and --rest-depth are for adhesion on a viscoelastic specimen: leave them out"


@dataclass(frozen=True)
class Turn:
    """Where the command line says the device turns, or its whole way as a table; None: not given."""

    to_load: float | None = typed(options.LOAD, TO_LOAD)
    to_depth: float | None = typed(options.LENGTH, TO_DEPTH)
    program: Path | None = typed(options.FileType(), PROGRAM)  # noqa: RUF009  # a field

    def __post_init__(self) -> None:
        from ..adhesion.device_path import Course

        Course(to_load=self.to_load, to_depth=self.to_depth, tabulated=self.program).refuse_idle(flag)

    def suffix(self) -> str:
        """What distinguishes names of files, of the options that were given: ``-to-load0.0005``, SI."""
        places = {"to_load": self.to_load, "to_depth": self.to_depth}
        parts = [f"{flag(name)[1:]}{x:g}" for name, x in places.items() if x is not None]
        return "".join([*parts, "" if self.program is None else f"-program-{self.program.stem}"])


turn_options = options.as_one("turn", Turn)
end_options = options.several(
    click.option("--points", type=click.IntRange(2, 100_000), default=200, show_default=True, help="Rows per branch."),
    options.curve_options,
    options.limits_options,
    options.into_folder(),
    options.output_options(plots="Write the CSV only.", json="Print the figures as JSON."),
)
works_options = options.several(
    click.option("--w-approach", type=options.WORK, help="On approach [default: the case's first w]."),
    click.option("--w-retract", type=options.WORK, help="On retraction, not smaller [default: that of approach]."),
    click.option("--stiffness", type=options.CONTROL, default="rigid", show_default=True,
                 help='"0.2 N/m", "rigid" or "load".'),
)  # fmt: skip
rest_options = options.several(
    click.option("--rest-load", type=options.LOAD, help="Viscoelastic specimens: at rest under this load, then pulled "
                 "instantly, with --stress at --speed [default: at the reversal of --to-load or "
                 "--to-depth, or P = 0]."),
    click.option("--rest-depth", type=options.LENGTH, help="The same at this displacement delta."),
)  # fmt: skip


def read_program(path: Path | None, stiffness: float) -> Program | None:
    """What the table at ``path`` says that a device of ``stiffness`` [N/m] does, where there is one."""
    if path is None:
        return None
    from ..adhesion.curve import LOAD_CONTROL
    from ..adhesion.device_path import Program
    from ..resolve import foreign

    return Program(*foreign.read_program(path, "load" if stiffness == LOAD_CONTROL else "length"))


def works_of(solution: Solution, approach: float | None, retraction: float | None) -> tuple[float, float]:
    """The works of adhesion [J/m^2] on approach and retraction: what was given, else the case's; of a specimen that
    relaxes 0 where none is named."""
    if approach is None:
        relaxes = solution.problem.specimen.relaxation is not None
        approach = 0.0 if relaxes and not solution.record.w else inputs.works_of(solution, "--w-approach")[0]
    return approach, approach if retraction is None else retraction


def begin_program(program: Path | None, points: int, limits: Limits) -> None:
    """Say what a table of the instrument's positions will cost, where that is much; Refusal beyond the ``limits``."""
    if program is not None:
        from ..tables.text import rows_of_text

        per_row = TABLE_CYCLE_PER_ROW + TABLE_CYCLE_PER_POINT * points
        inputs.begin_tables("cycle --program", rows_of_text(program), limits,
                            "fewer rows of the program, or fewer --points", per_row=per_row,
                            mib_per_row=TABLE_CYCLE_MIB_PER_ROW)  # fmt: skip


def name_suffix(
    approach: float | None, retraction: float | None, stiffness: float, turn: str, rest: Rest | None,
    ranged: RangeRequest, more: str = "", factor: float = 1.0,
) -> str:  # fmt: skip
    """What distinguishes names of files, of what was given: works of adhesion [J/m^2], a ``stiffness`` [N/m], the words
    of a ``turn``, a rest, a range, ``more`` and a ``factor`` of the moduli."""
    from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL

    works = (("approach", approach), ("retract", retraction))
    parts = [f"-w-{name}{w:g}" for name, w in works if w is not None]
    if stiffness == LOAD_CONTROL:
        parts.append("-stiffness-load")
    elif stiffness != DISPLACEMENT_CONTROL:
        parts.append(f"-stiffness{stiffness:g}")
    parts.append(turn)
    if rest is not None:
        parts.append(f"-rest-load{rest.load:g}" if rest.depth is None else f"-rest-depth{rest.depth:g}")
    parts += [ranged.suffix, more]
    return "".join(parts if factor == 1 else [*parts, f"-modulus{factor:g}"])


def write_cycle(
    file: Path, ends: str, known: tuple[LoadingHistory, ...], asked: AskedCycle, limits: Limits, output: Output,
    one: Callable[[], Result], after: Callable[[LoadingHistory], Result],
) -> None:  # fmt: skip
    """Compute and write what was ``asked``, the ``one`` cycle or those ``after`` each history that is ``known``."""
    from ..report.forward import CycledInLimits

    names = [one.name for one in known] or [""]
    stem = output.folder(file.parent) / f"{file.stem}-cycle{ends}"
    named = [stem.with_name("-".join([stem.name, *name.split()])) for name in names]
    targets = [output.files(each, (".csv", *PICTURES), [file]) for each in named]
    inputs.begin_curves("cycle", [asked.solution], [asked.works], limits, [asked.ranged])

    result = CycledInLimits.of(file, known, after) if known else one()
    cycles = [each for _, each in result.limits.values()] if isinstance(result, CycledInLimits) else [result]
    with together():
        for each, files in zip(cycles, targets, strict=True):
            files.write(each.columns, figure=files.draw(each.figure))
    give(result, output.json, f"  written {', '.join(map(str, targets))}", file)


@options.verb("file")
@works_options
@turn_options
@rest_options
@end_options
def cycle(
    file: Path, w_approach: float | None, w_retract: float | None, stiffness: float, turn: Turn,
    rest_load: float | None, rest_depth: float | None, points: int, how: options.CurveOptions, limits: Limits,
    output: Output,
) -> None:  # fmt: skip
    """Compute the cycle of approach and retraction on FILE, a case or a solution file: load, displacement and contact
    radius, jumps, energy lost.

    The cycle is quasi-static: contact begins at delta = 0 and is lost where d(delta + P/stiffness)/da is zero. With
    --stress or --range, the surfaces attract each other before contact (Maugis-Dugdale). For a viscoelastic specimen
    with adhesion, jkr computes three limits: very fast, very slow, and pulled instantly from rest. The results are
    <stem>-cycle.csv, .png and .svg; the options given add their values in SI units, as in
    <stem>-cycle-w-retract0.045.csv.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    """
    from ..report.forward import AskedCycle, traced_histories
    from ..resolve.histories import rest_of

    output.folder(Path())
    file = inputs.series_file(file)
    solution = inputs.read_series(file)
    works, ranged = works_of(solution, w_approach, w_retract), how.of(solution)
    relaxes = solution.problem.specimen.relaxation is not None
    if relaxes and (not any(works) or turn.program is not None):
        raise InputError(f"cycle: contact of a viscoelastic specimen over time {absent('contact over time')}")
    ranged.refuse_two(*works)
    begin_program(turn.program, points, limits)
    rest = rest_of(rest_load, rest_depth, flag)
    if rest is not None and not relaxes:
        raise InputError(NO_REST)
    known = traced_histories(solution, rest, turn.to_load, turn.to_depth, not ranged) if relaxes else ()
    program, ways = read_program(turn.program, stiffness), (how.slopes, how.modulus_factor)
    asked = AskedCycle(solution, works, stiffness, ranged, *ways, turn.to_load, turn.to_depth, program, points)
    ends = name_suffix(w_approach, w_retract, stiffness, turn.suffix(), rest, ranged, factor=how.modulus_factor)
    write_cycle(file, ends, known, asked, limits, output, asked.quasi_static, asked.quasi_static)

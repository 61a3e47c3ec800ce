"""``jkr cycle``: the trace that a device of given stiffness records, quasi-statically."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from ..base.files import together
from ..base.registry import Result
from ..methods.protocol import Limits
from ..report.result import PICTURES, Output
from . import inputs, options
from .options import flag, typed
from .printing import give

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..adhesion.device_path import Program
    from ..adhesion.finite_range import RangeRequest
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


def read_program(path: Path | None, stiffness: float) -> Program | None:
    """What the table at ``path`` says that a device of ``stiffness`` [N/m] does, where there is one."""
    if path is None:
        return None
    from ..adhesion.curve import LOAD_CONTROL
    from ..adhesion.device_path import Program
    from ..resolve import foreign

    return Program(*foreign.read_program(path, "load" if stiffness == LOAD_CONTROL else "length"))


def works_of(solution: Solution, approach: float | None, retraction: float | None) -> tuple[float, float]:
    """The works of adhesion [J/m^2] on approach and retraction: what was given, else the case's."""
    if approach is None:
        approach = inputs.works_of(solution, "--w-approach")[0]
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
    approach: float | None, retraction: float | None, stiffness: float, turn: str, ranged: RangeRequest,
    more: str = "", factor: float = 1.0,
) -> str:  # fmt: skip
    """What distinguishes names of files, of what was given: works of adhesion [J/m^2], a ``stiffness`` [N/m], the words
    of a ``turn``, a range, ``more`` and a ``factor`` of the moduli."""
    from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL

    works = (("approach", approach), ("retract", retraction))
    parts = [f"-w-{name}{w:g}" for name, w in works if w is not None]
    if stiffness == LOAD_CONTROL:
        parts.append("-stiffness-load")
    elif stiffness != DISPLACEMENT_CONTROL:
        parts.append(f"-stiffness{stiffness:g}")
    parts.append(turn)
    parts += [ranged.suffix, more]
    return "".join(parts if factor == 1 else [*parts, f"-modulus{factor:g}"])


def write_cycle(
    file: Path, ends: str, cycles: Mapping[str, Callable[[], Result]], asked: AskedCycle, limits: Limits,
    output: Output, of_all: Callable[[Sequence[Result]], Result] | None = None,
) -> None:  # fmt: skip
    """Compute and write the ``cycles`` of what was ``asked``, by what their files are called; what is told is the
    result ``of_all``, or of the only one."""
    stem = output.folder(file.parent) / f"{file.stem}-cycle{ends}"
    named = [stem.with_name("-".join([stem.name, *name.split()])) for name in cycles]
    targets = [output.files(each, (".csv", *PICTURES), [file]) for each in named]
    inputs.begin_curves("cycle", [asked.solution], [asked.works], limits, [asked.ranged])

    results = [computed() for computed in cycles.values()]
    with together():
        for each, files in zip(results, targets, strict=True):
            files.write(each.columns, figure=files.draw(each.figure))
    told = results[0] if of_all is None else of_all(results)
    give(told, output.json, f"  written {', '.join(map(str, targets))}", file)


@options.verb("file")
@works_options
@turn_options
@end_options
def cycle(
    file: Path, w_approach: float | None, w_retract: float | None, stiffness: float, turn: Turn, points: int,
    how: options.CurveOptions, limits: Limits, output: Output,
) -> None:  # fmt: skip
    """Compute the cycle of approach and retraction on FILE, a case or a solution file: load, displacement and contact
    radius, jumps, energy lost.

    The cycle is quasi-static: contact begins at delta = 0 and is lost where d(delta + P/stiffness)/da is zero. With
    --stress or --range, the surfaces attract each other before contact (Maugis-Dugdale). The results are
    <stem>-cycle.csv, .png and .svg; the options given add their values in SI units, as in
    <stem>-cycle-w-retract0.045.csv.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    """
    from ..report.forward import AskedCycle, by_history

    output.folder(Path())
    file = inputs.series_file(file)
    solution = inputs.read_series(file)
    by_history(solution)  # refuses what needs a wing, which has a verb of its own
    works, ranged = works_of(solution, w_approach, w_retract), how.of(solution)
    ranged.refuse_two(*works)
    begin_program(turn.program, points, limits)
    program, ways = read_program(turn.program, stiffness), (how.slopes, how.modulus_factor)
    asked = AskedCycle(solution, works, stiffness, ranged, *ways, turn.to_load, turn.to_depth, program, points)
    ends = name_suffix(w_approach, w_retract, stiffness, turn.suffix(), ranged, factor=how.modulus_factor)
    write_cycle(file, ends, {"": asked.quasi_static}, asked, limits, output)

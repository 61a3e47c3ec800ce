"""Verbs of many problems: ``study`` (maps and meshes), ``sweep``, ``bench`` and ``explore``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import click

from ..base.errors import InputError
from ..base.files import write_text
from ..base.wings import absent, offered
from ..cli import LateGroup, inputs, options
from ..cli.printing import announce, answer, give, note, progress
from ..methods.protocol import METHODS, Limits
from ..report.result import PICTURES, Output
from .wing import maps

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .maps import Axis, Map
    from .sweep_plan import Plan

# --------------------------------------------------------------------------------------------------
# ``jkr study``: maps and meshes.

STUDIES = {f"{name}-map": words for name, words in maps().items()} | {
    "converge": "The same case on a sequence of meshes."
}
# Studies of the methods, and the targets of make that run them.
MAKE = {"chart": "chart", "failures": "failures", "figures": "paper", "noise": "noise-study"}


class Studies(LateGroup):
    """The studies: of maps each is made of its row."""

    titles: ClassVar = {"Studies": STUDIES}

    def made(self, name: str) -> click.Command:
        if name == "converge":
            return study_converge
        from .maps import map_of

        return _command(map_of(name.removesuffix("-map")))

    def unknown(self, name: str) -> str:
        if name in MAKE:
            return f'"{name}" is now run as make {MAKE[name]}'
        return f'unknown study "{name}" (studies: {", ".join(STUDIES)})'


@click.group(cls=Studies)
def study() -> None:
    """Maps and studies over many bodies.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.499
    """


def _command(row: Map) -> click.Command:
    """The verb of a map: an option for each axis."""

    @options.parallel_options
    @options.into_folder("Folder [default: .].", default=Path())
    @options.output_options(plots="Write the CSV only.", json="Print the table as JSON.")
    def study_map(output: Output, parallel: options.Parallel, **axes: Any) -> None:
        from ..base.executors import executor

        chosen = {name: value for name, value in axes.items() if value not in (None, ())}
        files = output.files(output.folder(Path()) / f"{row.name}-map", (".csv", *PICTURES))
        with executor(*parallel, progress, row.forecast(**chosen)) as pool:
            result = row.over(pool, **chosen)
        files.write(result.columns, figure=files.draw(result.figure))
        give(result, output.json, f"  written {files}")

    axes = options.several(*(_option(name, axis) for name, axis in row.axes.items()))
    return click.command(f"{row.name}-map", cls=options.Verb, help=row.help)(axes(study_map))


def _option(name: str, axis: Axis) -> Any:
    kind: Any = float if axis.read is None else str
    default = axis.default if axis.several else (axis.default,)
    if isinstance(axis.default, dict):
        kind = options.PAIRS
        default = [f"{key}={value}" for key, value in axis.default.items()]
    elif isinstance(axis.allowed, tuple):
        kind = click.Choice(axis.allowed)
    shown = axis.shown or ", ".join(map(str, default))
    return click.option(f"--{name}", type=kind, multiple=axis.several, help=f"{axis.help}  [default: {shown}]".strip())


@options.verb("case", "converge")
@click.option("--levels", type=click.IntRange(2, 8), default=4, show_default=True, help="Meshes; the last: the case's.")
@click.option("--contact", type=click.Choice(["nested", "incremental"]), help="Instead of the case's.")
@click.option("--w", "work", type=options.WORK, help="Work of adhesion [default: the case's first].")
@options.parallel_options
@options.into_folder("Folder.", default=Path())
@options.output_options(plots="Write CSV and JSON only.", json="Print as JSON.")
def study_converge(
    case: Path, levels: int, contact: str | None, work: float | None, parallel: options.Parallel, output: Output
) -> None:
    """Solve CASE by finite elements on a sequence of meshes, each with elements half as large as before (Appendix C).

    For each mesh jkr prints contact radius and load at the common depth, pull-off force, points kept and time; then the
    observed order of convergence and the extrapolated value. The results are <case>-convergence.csv, .json, .png and
    .svg.

    \b
    jkr study converge cases/thin-layer.toml --levels 5
    jkr study converge cases/halfspace.toml --contact incremental -o results
    """
    from ..base.executors import executor
    from ..case.models import load_case, method_of
    from .studies import converge

    loaded = load_case(case)
    w = work if work is not None else next(iter(loaded.model.adhesion.w), None)
    if not w:
        raise InputError(f"{case}: names no work of adhesion > 0: give --w")
    folder = output.folder(Path())
    files = output.files(folder / f"{case.stem}-convergence", (".csv", ".json", *PICTURES), [case])
    method: Any = method_of(loaded.model, "fem")
    if contact is not None:
        method = replace(method, contact=contact)
    problem = loaded.model.problem()
    with executor(*parallel, progress, method.forecast(problem).seconds) as pool:
        study = converge(problem, method, w, levels, pool=pool)
    files.write(study.columns, study.summary(), files.draw(study.figure))
    give(study, output.json, f"  written   {files}")


# --------------------------------------------------------------------------------------------------
# ``jkr sweep``: many cases from one file, to one table.


@options.verb("sweep")
@options.into_folder("Folder [default: <sweep>-results here].")
@options.parallel_options
@click.option(
    "--hours", type=options.NumberRange(min=0), default=10.0, show_default=True, help="Most core hours to begin."
)
@click.option("--retry-failed", is_flag=True, help="Try the failed cases of an earlier run again.")
@click.option("--only", type=click.IntRange(min=0), metavar="CASE", help="Solve this case alone and print its row.")
@click.option("--show-case", type=click.IntRange(min=0), metavar="CASE", help="Print this case as a case file.")
@options.output_options(plots="Draw nothing.", json="Print the summary (or the row) as JSON.")
def sweep(
    sweep: Path, output: Output, parallel: options.Parallel, hours: float, retry_failed: bool, only: int | None,
    show_case: int | None,
) -> None:  # fmt: skip
    """Solve all cases that SWEEP (TOML) makes of a base case, and write a table with a row per case (CSV, HDF5,
    Parquet).

    The picture (table.png, table.svg) plots the forces, or the first results if the table has no forces, over the swept
    key with the most values. A curve stands for each value of the key with the second most values. After an
    interruption the same command goes on where it stopped. Cases that differ only in w share one solution.

    \b
    jkr sweep cases/sweeps/gel.toml -o results
    jkr sweep my-sweep.toml -o results --scheduler tcp://node1:8786
    jkr sweep my-sweep.toml --only 17
    jkr sweep my-sweep.toml --show-case 17 > case-17.toml
    """
    from ..case.models import plain_toml
    from . import sweep as running
    from . import sweep_plan as plans

    for alone, name, also in (("show_case", "--show-case", ()), ("only", "--only", ("json",))):
        typed = options.typed_options()
        if alone in typed and (idle := [one for one in typed if one not in ("sweep", alone, *also)]):
            raise InputError(f"sweep: {name} writes nothing, {options.flag(idle[0])} has no effect: leave it out")
    plan = plans.load_plan(sweep)
    if show_case is not None:
        click.echo(plain_toml(plan.case(_number(plan, show_case, "--show-case")).to_toml()), nl=False)
    elif only is not None:
        row = running.alone(plan, _number(plan, only, "--only"))
        answer(row.summary()) if output.json else click.echo(str(row))
    else:
        folder = replace(output, where=output.where or Path(f"{sweep.stem}-results")).folder(Path())
        pictures = output.files(folder / running.STEM, PICTURES)
        means = running.Means(*parallel, hours, retry_failed, progress)
        result = running.sweep(plan, folder, means, output.force, note, pictures)
        give(result, output.json, f"  written   {', '.join(map(str, result.files))}")


def _number(plan: Plan, number: int, option: str) -> int:
    if number >= plan.count:
        raise InputError(f"{option}: the cases of {plan.source} are numbered 0 to {plan.count - 1}, got {number}")
    return number


# --------------------------------------------------------------------------------------------------
# ``jkr bench``: where the time of a run goes.


@options.verb("case")
@click.option("--method", type=options.MethodType(METHODS), help="Method, instead of the case's.")
@click.option("--repeat", type=click.IntRange(1, 1000), default=5, show_default=True, help="Runs.")
@options.limits_options
@options.json_option
def bench(case: Path, method: str | None, repeat: int, limits: Limits, as_json: bool) -> None:
    """Time the stages of CASE in CPU seconds (one BLAS thread): minimum and median of several runs.

    \b
    jkr bench cases/halfspace.toml
    jkr bench cases/halfspace.toml --method layered --repeat 20
    """
    from ..case.models import load_case
    from ..case.store import solve
    from .studies import FEW, Bench

    loaded = load_case(case)
    choice, solution = solve(loaded, method, limits, note)
    announce(f"bench of {repeat} runs", (repeat + min(repeat, FEW)) * sum(solution.timings.values()))
    give(Bench.of(case, loaded, choice.name, type(choice.method).__module__, repeat), as_json)


# --------------------------------------------------------------------------------------------------
# ``jkr explore``: one page with sliders.

# Of a wing that reads measured curves, where it is there
reading_options: options.Options = offered("options of a reading") or options.several()


@options.verb("file [data...]")
@options.into_file("The page [default: <file>-explore.html].")
@click.option("--w", "work", type=options.WORK, help="To begin with [default: the case's first].")
@options.slopes_option
@reading_options
@options.limits_options
@options.output_options(force=options.ONE_FILE, json="Print what was written as JSON.")
def explore(
    file: Path, data: tuple[Path, ...], work: float | None, slopes: str, limits: Limits, output: Output,
    reading: Any = None,
) -> None:  # fmt: skip
    """Make one self-contained page with sliders from FILE, a case or a solution, with measured DATA (CSV) drawn over
    the curve.

    The page works from disk without a network. Its sliders and number fields set the work of adhesion, a factor to all
    moduli, the stiffness of the machine and the contact point of the data. It shows stable and unstable branches,
    pull-off, and the commands that give the same numbers. It saves the curve as CSV.

    \b
    jkr explore data.h5
    jkr explore gel.h5 measured.csv -o gel.html
    """
    from ..adhesion.finite_range import without_range
    from ..resolve.analysis import analyse
    from .explorer import COST_PAGE_PER_ROW, Explored, page, payload, start_work

    if data and reading is None:
        raise InputError(f"explore: measured DATA {absent('measured curves')}")
    if work == 0:
        raise InputError("explore: --w must be > 0 J/m^2 to begin with, got 0")
    if output.where is not None:
        output.file(output.where, [file, *data])
    file = inputs.series_file(file)
    target = output.file(file.parent / f"{file.stem}-explore.html", [file, *data])
    solution = inputs.read_series(file)
    inputs.warn_of_constant_moduli(solution)
    without_range(solution.record, "explore")
    curves = [] if reading is None else offered("measured curves")("explore", data, reading, limits)
    works = (work,) if work else tuple(w for w in solution.record.w if w > 0)[:1]
    seconds = COST_PAGE_PER_ROW * solution.increments.a.size
    inputs.begin_curves("explore", [solution], [works or (1.0,)], limits, beside=seconds)
    result = analyse(solution, works or (1.0,), slopes)[0]
    if not works:
        result = analyse(solution, (start_work(result.jkr.nonadhesive),), slopes)[0]
    write_text(target, page(payload(result, curves, slopes)))
    give(Explored(file, target, result.w, len(result.curve.series), len(curves), sum(map(len, curves))), output.json)


# --------------------------------------------------------------------------------------------------
# ``jkr pull-off --find``: the inverse question.

find_option = options.several(
    click.option("--find", "sought", metavar="KEY[=LOW..HIGH]",
                 help='With --load: the value of a number of the case that gives this pull-off force, such as '
                 'indenter.radius="1 um..1 mm".'),
)  # fmt: skip


# --------------------------------------------------------------------------------------------------
# ``jkr export --sizes``: a contact law of particles of all sizes.


class Sizes(options.ParsedType):
    """Two lengths that rise, LOW..HIGH."""

    name = "LOW..HIGH"

    def parsed(self, text: str) -> tuple[float, float]:
        low, _, high = text.partition("..")
        sizes = options.LENGTH_ABOVE_0.parsed(low), options.LENGTH_ABOVE_0.parsed(high or low)
        if not sizes[0] < sizes[1]:
            raise ValueError(f'must be two radii that rise, such as "1 um..100 um", got "{text}"')
        return sizes


sizes_option = click.option("--sizes", type=Sizes(), help='With --dem: one law for reduced radii R1 R2/(R1 + R2) of '
                            '"1 um..100 um", of a paraboloid.')  # fmt: skip

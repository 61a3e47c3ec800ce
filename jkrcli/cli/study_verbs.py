"""Verbs of many problems (``compare``, ``sweep``, ``study``, ``bench``), and of files and the installation (``show``,
``doctor``, ``completion``).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import click
from click.shell_completion import get_completion_class

from ..base.errors import InputError
from ..base.executors import executor
from ..case.models import load_case, method_of, plain_toml
from ..case.store import solve
from ..many import maps
from ..many import sweep as running
from ..many import sweep_plan as plans
from ..many.studies import FEW, Bench
from ..methods.protocol import METHODS, Limits
from ..report import archive
from ..report import archive as shown
from ..report.check import Machine
from ..report.forward import Compared
from ..report.result import PICTURES, Output
from ..series import Solution
from ..tables import rows_of_text
from . import LateGroup, options
from .inputs import announce_files, begin_tables, read_files, read_series, series_file
from .printing import announce, answer, give, note, progress, warn

# --------------------------------------------------------------------------------------------------
# Verbs of many problems: ``study`` (maps and meshes), ``sweep``, ``compare``, ``bench``.

STUDIES = {f"{name}-map": words for name, words in maps.MAPS.items()} | {
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
        return _command(maps.map_of(name.removesuffix("-map")))

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


def _command(row: maps.Map) -> click.Command:
    """The verb of a map: an option for each axis."""

    @options.parallel_options
    @options.into_folder("Folder [default: .].", default=Path())
    @options.output_options(plots="Write the CSV only.", json="Print the table as JSON.")
    def study_map(output: Output, parallel: options.Parallel, **axes: Any) -> None:
        chosen = {name: value for name, value in axes.items() if value not in (None, ())}
        files = output.files(output.folder(Path()) / f"{row.name}-map", (".csv", *PICTURES))
        with executor(*parallel, progress, row.forecast(**chosen)) as pool:
            result = row.over(pool, **chosen)
        files.write(result.columns, figure=files.draw(result.figure))
        give(result, output.json, f"  written {files}")

    axes = options.several(*(_option(name, axis) for name, axis in row.axes.items()))
    return click.command(f"{row.name}-map", cls=options.Verb, help=row.help)(axes(study_map))


def _option(name: str, axis: maps.Axis) -> Any:
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
    """Solve CASE by finite elements on meshes whose elements halve from one to the next (Appendix C).

    For each: contact radius and load at the common depth, pull-off force, points kept, time; then the observed order
    and the extrapolated value. Writes <case>-convergence.csv, .json, .png and .svg.

    \b
    jkr study converge cases/thin-layer.toml --levels 5
    jkr study converge cases/halfspace.toml --contact incremental -o results
    """
    from ..many import studies as convergence
    from ..methods.fem import FEM

    loaded = load_case(case)
    w = work if work is not None else next(iter(loaded.model.adhesion.w), None)
    if not w:
        raise InputError(f"{case}: names no work of adhesion > 0: give --w")
    folder = output.folder(Path())
    files = output.files(folder / f"{case.stem}-convergence", (".csv", ".json", *PICTURES), [case])
    method = method_of(loaded.model, "fem")
    assert isinstance(method, FEM)
    if contact is not None:
        method = replace(method, contact=contact)  # type: ignore[arg-type]
    problem = loaded.model.problem()
    with executor(*parallel, progress, method.forecast(problem).seconds) as pool:
        study = convergence.converge(problem, method, w, levels, pool=pool)
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
    """Solve all cases that SWEEP (TOML) makes of a base case; a table with a row per case: CSV, HDF5, Parquet.

    Draws forces (else the first results) over the longest axis, a line per value of the next: table.png, .svg. Run
    again after an interruption it goes on where it stopped; cases that share a solve are solved once.

    \b
    jkr sweep cases/sweeps/gel.toml -o results
    jkr sweep my-sweep.toml -o results --scheduler tcp://node1:8786
    jkr sweep my-sweep.toml --only 17
    jkr sweep my-sweep.toml --show-case 17 > case-17.toml
    """
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


def _number(plan: plans.Plan, number: int, option: str) -> int:
    if number >= plan.count:
        raise InputError(f"{option}: the cases of {plan.source} are numbered 0 to {plan.count - 1}, got {number}")
    return number


# --------------------------------------------------------------------------------------------------
# ``jkr compare``: two results of the same problem.

COLUMNS = ("P", "a", "S", "dS")


@options.verb("first second")
@click.option(
    "--rtol", type=options.NumberRange(min=0), default=1e-3, show_default=True, help="Largest relative difference."
)
@click.option("--column", "columns", multiple=True, type=click.Choice(COLUMNS), help="What counts [default: P].")
@click.option("--overlap", type=options.NumberRange(0, 1), default=0.9, show_default=True, help="Least common range.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the differences (.png or .svg).")
@options.output_options(force="Replace an existing plot that jkr did not write.", json="Print as JSON.")
@click.pass_context
def compare(
    ctx: click.Context, first: Path, second: Path, rtol: float, columns: tuple[str, ...], overlap: float,
    plot: Path | None, output: Output,
) -> None:  # fmt: skip
    """Compare two solution files (P and a at equal displacement, S and S' at equal radius), or two CSV curves.

    Exit code 1 where a column that counts differs by more than --rtol (CSV curves: every shared column counts).

    \b
    jkr compare fem.h5 layered.h5 --rtol 1e-3
    jkr compare today.h5 yesterday.h5 --rtol 1e-12 --column P --column a
    """
    if plot is not None:
        if plot.suffix not in PICTURES:
            raise InputError(f"--plot: must end in .png or .svg, got {plot}")
        output.file(plot, [first, second])
    files = first, second
    if first.suffix == ".csv":
        begin_tables("compare", sum(map(rows_of_text, files)))
    result = Compared.of(files, lambda: read_files("compare", files)[1], rtol, columns, overlap)
    give(result, output.json)
    if plot is not None:
        from ..report import plots

        plots.save(result.figure(), [plot])
    ctx.exit(0 if result.agree else 1)


# --------------------------------------------------------------------------------------------------
# ``jkr bench``: where the time of a run goes.


@options.verb("case")
@click.option("--method", type=click.Choice(METHODS), help="Method, instead of the case's.")
@click.option("--repeat", type=click.IntRange(1, 1000), default=5, show_default=True, help="Runs.")
@options.limits_options
@options.json_option
def bench(case: Path, method: str | None, repeat: int, limits: Limits, as_json: bool) -> None:
    """Time the stages of CASE in CPU seconds (one BLAS thread): minimum and median of several runs.

    \b
    jkr bench cases/halfspace.toml
    jkr bench cases/halfspace.toml --method layered --repeat 20
    """
    loaded = load_case(case)
    choice, solution = solve(loaded, method, limits, note)
    announce(f"bench of {repeat} runs", (repeat + min(repeat, FEW)) * sum(solution.timings.values()))
    give(Bench.of(case, loaded, choice.name, type(choice.method).__module__, repeat), as_json)


# --------------------------------------------------------------------------------------------------
# Verbs about files and the installation: ``show``, ``doctor``, ``completion``.


@options.verb("files...")
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@options.json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each solution FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

    Archives of fits and tables of sweeps (.h5) are shown too, checked against the digest they were written under.

    \b
    jkr show data.h5
    jkr show --case data.h5 > again.toml
    """
    announce_files("show", files)
    items = list[Solution | dict[str, Any]]()
    for path in files:
        if case_only or not archive.is_archive(path):
            items.append(read_series(series_file(path)))
            continue
        file = archive.read(path)
        if not file.is_protected:
            warn(f"{path}: {archive.DOUBT}")
        items.append(archive.archive_summary(file))
    if case_only and not as_json:
        click.echo("\n".join(plain_toml(item.record.toml).rstrip() for item in items if isinstance(item, Solution)))
        return
    give(shown.Shown(items), as_json)


# --------------------------------------------------------------------------------------------------
# ``jkr doctor``: what of jkr works on this machine.


@options.verb()
@options.json_option
def doctor(as_json: bool) -> int:
    """Look at versions, the mesher's system libraries, optional parts, threads, memory and temporary files.

    Exit code 0 where everything required works, 1 where something is missing; each line says what to type.

    \b
    jkr doctor
    """
    machine = Machine.examined()
    give(machine, as_json)
    return int(not machine.is_sound)


# --------------------------------------------------------------------------------------------------
# ``jkr completion``: the script that completes verbs, options and files in a shell.


@options.verb()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the completion script of SHELL.

    \b
    jkr completion bash >> ~/.bashrc
    jkr completion zsh >> ~/.zshrc
    jkr completion fish > ~/.config/fish/completions/jkr.fish
    """
    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(ctx.find_root().command, {}, "jkr", "_JKR_COMPLETE").source())

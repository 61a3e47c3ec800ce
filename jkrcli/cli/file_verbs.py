"""Verbs of results and of the installation: ``compare``, ``show``, ``doctor``, ``completion``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from click.shell_completion import get_completion_class

from ..base.errors import InputError
from ..report.result import PICTURES, Output
from . import options
from .inputs import announce_files, begin_tables, read_files, read_series, series_file
from .printing import give, warn

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

    The exit code is 1 if a compared column differs by more than --rtol. CSV curves are compared in all columns that
    both files have.

    \b
    jkr compare fem.h5 layered.h5 --rtol 1e-3
    jkr compare today.h5 yesterday.h5 --rtol 1e-12 --column P --column a
    """
    from ..report.forward import Compared
    from ..tables.text import rows_of_text

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
# Verbs about files and the installation: ``show``, ``doctor``, ``completion``.


@options.verb("files...")
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@options.json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each solution FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

    Results of fits and sweeps (.h5) are shown, too, after their checksums are verified.

    \b
    jkr show data.h5
    jkr show --case data.h5 > again.toml
    """
    if case_only and as_json:
        raise InputError("show: --case prints a case file: leave --json out")
    from ..report import archive

    announce_files("show", files)
    items: list[Any] = []  # solutions, and summaries of archives
    for path in files:
        if case_only or not archive.is_archive(path):
            items.append(read_series(series_file(path)))
            continue
        file = archive.read(path)
        if not file.is_protected:
            warn(f"{path}: {archive.DOUBT}")
        items.append(archive.archive_summary(file))
    if case_only:
        from ..case.models import plain_toml

        click.echo("\n".join(plain_toml(item.record.toml).rstrip() for item in items if not isinstance(item, dict)))
        return
    give(archive.Shown(items), as_json)


# --------------------------------------------------------------------------------------------------
# ``jkr doctor``: what of jkr works on this machine.


@options.verb()
@options.json_option
def doctor(as_json: bool) -> int:
    """Check versions, the system libraries of the mesher, and optional packages.

    The exit code is 0 if everything required works and 1 if something is missing. If a part is missing, its line ends
    with the command that installs it.

    \b
    jkr doctor
    """
    from ..report.check import Machine

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

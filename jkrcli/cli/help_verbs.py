"""Verbs about files and the installation: ``show``, ``doctor``, ``completion``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from click.shell_completion import get_completion_class

from ..case.reading import plain_toml
from ..report import archive
from ..report import archive as shown
from ..report.doctor import Machine
from ..series import Solution
from .inputs import announce_files, read_series, series_file
from .options import json_option
from .output import give, warn
from .verb import verb


@verb("files...")
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each solution FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

    Archives of fits and tables of sweeps (.h5) are shown too, checked against the digest they were written under.

    \b
    jkr show data.h5
    jkr show --case data.h5 > again.toml
    """
    announce_files("show", files)
    items = [_content(path, case_only) for path in files]
    if case_only and not as_json:
        click.echo("\n".join(plain_toml(item.record.toml).rstrip() for item in items if isinstance(item, Solution)))
        return
    give(shown.Shown(items), as_json)


def _content(path: Path, case_only: bool) -> Solution | dict[str, Any]:
    """The series in a file, or the summary of an archive, which has no case."""
    if case_only or not archive.is_archive(path):
        return read_series(series_file(path))
    file = archive.read(path)
    if not file.is_protected:
        warn(f"{path}: {archive.DOUBT}")
    return archive.archive_summary(file)


# --------------------------------------------------------------------------------------------------
# ``jkr doctor``: what of jkr works on this machine.


@verb()
@json_option
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


@verb()
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

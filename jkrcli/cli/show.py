"""``jkr show``: what a series file, an archive of fits or the table of a sweep holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..case import plain_toml
from ..report import archive, shown
from ..series import Solution
from .options import json_option
from .series import announce_files, read_series, series_file
from .verb import verb
from .voice import give, warn


@verb("files...")
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each series FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

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
    return archive.summary(file)

"""What a verb writes: -o, --no-plots, --force and --json as one argument, files that are checked before any work."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError
from ..base.files import check_series_target, check_target, make_folder, write_text
from ..base.table import as_json, write_csv

if TYPE_CHECKING:
    from ..report.plots import Figure

PICTURES = (".png", ".svg")
ONE_FILE = "Replace an existing file that jkr did not write."  # help of --force
Command = Callable[..., Any]


@dataclass(frozen=True)
class Files:
    """Files of one result that differ in their endings: ``stem`` and each of ``endings``."""

    stem: Path
    endings: tuple[str, ...]

    def __getitem__(self, ending: str) -> Path:
        return self.stem.with_name(self.stem.name + ending)

    def __str__(self) -> str:
        return f"{self.stem}{{{','.join(self.endings)}}}"

    def draw(self, figure: Callable[[], Figure]) -> Figure | None:
        """What ``figure`` draws, where a picture is to be written."""
        return figure() if set(PICTURES) & set(self.endings) else None

    def write(
        self,
        table: Mapping[str, Any] | None = None,
        summary: Mapping[str, Any] | None = None,
        figure: Figure | None = None,
    ) -> None:
        """The columns of a table as CSV, a summary as JSON, a figure as pictures, as far as they are given."""
        if table is not None:
            write_csv(self[".csv"], table)
        if summary is not None:
            write_text(self[".json"], as_json(summary))
        if figure is not None:
            from ..report import plots

            for ending in self.endings:
                if ending in PICTURES:
                    plots.save(figure, self[ending])


@dataclass(frozen=True)
class Output:
    """Where and how a verb writes, as its options say; ``where``: -o, None where it was not given."""

    where: Path | None
    force: bool
    plots: bool
    json: bool

    def folder(self, default: Path) -> Path:
        """The folder to write into, made where -o names one that is not there; else ``default``."""
        if self.where is None:
            return default
        make_folder(self.where)
        return self.where

    def file(self, default: Path, inputs: Iterable[Path] = ()) -> Path:
        """The one file to write, after a check that it can and may be written."""
        target = default if self.where is None else self.where
        check_target(target, self.force, inputs)
        return target

    def series(self, default: Path, inputs: Iterable[Path] = ()) -> Path:
        """As ``file``, of a series: its name must not promise another format."""
        target = default if self.where is None else self.where
        check_series_target(target, self.force, inputs)
        return target

    def files(self, stem: Path, endings: Iterable[str], inputs: Iterable[Path] = ()) -> Files:
        """``stem`` with ``endings``, without pictures under --no-plots; checked, before any work, like one file."""
        held = Files(stem, tuple(ending for ending in endings if self.plots or ending not in PICTURES))
        for ending in held.endings:
            check_target(held[ending], self.force, inputs)
        return held


json_option = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")


def into_folder(help: str = "Folder [default: the file's].", **options: Any) -> Callable[[Command], Command]:
    """-o for a folder."""
    kind = click.Path(path_type=Path, file_okay=False)
    return click.option("-o", "--output", type=kind, help=help, **options)


def into_file(help: str) -> Callable[[Command], Command]:
    """-o for a file."""
    return click.option("-o", "--output", type=click.Path(path_type=Path), help=help)


def output_options(
    plots: str = "", json: str = "", force: str = "Replace existing files that jkr did not write."
) -> Callable[[Command], Command]:
    """--no-plots, --force and --json with their help, the first and last where they have one.

    The verb takes the values, with that of -o (see ``into_folder``), as one argument ``output``: an ``Output``.
    """
    told = {"--no-plots": plots, "--force": force, "--json": json}
    flags = [click.option(flag, is_flag=True, help=words) for flag, words in told.items() if words]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def verb(*words: Any, force: bool, no_plots: bool = False, json: bool = False, **others: Any) -> Any:
            output = Output(others.pop("output", None), force, not no_plots, json)
            return command(*words, output=output, **others)

        for flag in reversed(flags):
            flag(verb)
        return verb

    return decorate


def refuse_doubles(stems: Sequence[Path], remedy: str) -> None:
    """InputError where two results would go to the same files."""
    places = [stem.resolve() for stem in stems]
    for i, stem in enumerate(stems):
        if places[i] in places[:i]:
            raise InputError(f"{stem}.csv: would be written twice; rename a file, or {remedy}")


def answer(data: Mapping[str, Any]) -> None:
    """A result for machines on stdout."""
    click.echo(as_json(data), nl=False)

"""What a verb writes: -o, --no-plots, --force and --json as one argument, files that are checked before any work."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base import InputError, as_json, files
from ..report import Files, Output
from .verb import Command, Options, several
from .voice import present, warn

ONE_FILE = "Replace an existing file that jkr did not write."  # help of --force
ENDINGS = (".msh", ".vtu", ".csv", ".json", ".png", ".svg", ".pdf", ".h5", ".html", ".toml", ".txt")
if TYPE_CHECKING:
    from ..report import Result

    _Path = click.Path[Path]
else:
    _Path = click.Path  # not generic in every version of click


json_option = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")


class Folder(_Path):
    """A folder, there or to be made; a name that ends like one of the files that go into it is answered."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        folder = super().convert(value, param, ctx)
        if folder.suffix in ENDINGS and not folder.is_dir():
            self.fail(f"{folder} is the name of a file, a folder is wanted: files are named by the input")
        return folder


def into_folder(help: str = "Folder [default: the file's].", **options: Any) -> Options:
    """-o for a folder."""
    return click.option("-o", "--output", type=Folder(path_type=Path, file_okay=False), help=help, **options)


def into_file(help: str) -> Options:
    """-o for a file."""
    return click.option("-o", "--output", type=click.Path(path_type=Path), help=help)


def output_options(
    plots: str = "", json: str = "", force: str = "Replace existing files that jkr did not write."
) -> Options:
    """--no-plots, --force and --json with their help, the first and last where they have one.

    The verb takes the values, with that of -o (see ``into_folder``), as one argument ``output``: an ``Output``.
    """
    helps = {"--no-plots": plots, "--force": force, "--json": json}
    flags = [click.option(flag, is_flag=True, help=words) for flag, words in helps.items() if words]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def taking(*words: Any, force: bool, no_plots: bool = False, json: bool = False, **others: Any) -> Any:
            output = Output(others.pop("output", None), force, not no_plots, json)
            return command(*words, output=output, **others)

        return several(*flags)(taking)

    return decorate


def files_beside(
    output: Output, paths: Sequence[Path], word: str, endings: Sequence[str], inputs: Sequence[Path]
) -> list[Files]:
    """Files called <stem>-<word> of each of the ``paths``, beside it or in the folder of -o."""
    stems = [(output.where or path.parent) / f"{path.stem}-{word}" for path in paths]
    refuse_doubles(stems, "give each its own -o")
    output.folder(Path())
    return [output.files(stem, endings, inputs) for stem in stems]


def refuse_doubles(stems: Sequence[Path], remedy: str) -> None:
    """InputError where two results would go to the same files."""
    places = list(map(files.real, stems))
    for i, stem in enumerate(stems):
        if places[i] in places[:i]:
            raise InputError(f"{stem}.csv: would be written twice; rename a file, or {remedy}")


def answer(data: Mapping[str, Any]) -> None:
    """A result for machines on stdout."""
    click.echo(as_json(data), nl=False)


def give(result: Result, json: bool, written: str = "", of: Path | None = None) -> None:
    """A result on stdout, for machines or for people, these with what is ``written``; then its warnings, after the name
    of the file that they are ``of``."""
    if json:
        answer(result.summary())
    else:
        present(*result.parts, last=written)
    for line in result.warnings:
        warn(f"{of}: {line}" if of else line)

"""``jkr new``: a commented case file to start from."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import click

from ..base import InputError, check_target, write_text
from .verb import verb
from .voice import say

TEMPLATE = resources.files(__package__).joinpath("new.toml").read_text(encoding="utf-8")


@verb("file")
@click.option("--force", is_flag=True, help="Replace an existing file.")
def new(file: Path, force: bool) -> None:
    """Write a commented case to FILE, ready to edit and run.

    \b
    jkr new my.toml && jkr check my.toml && jkr transform my.toml
    """
    if file.suffix != ".toml":
        raise InputError(f"{file}: the name of a case ends in .toml")
    if file.exists() and not force:
        raise InputError(f"{file}: exists; give --force to replace it, or another name")
    check_target(file, force)
    write_text(file, TEMPLATE)
    say(f"written {file}; next: edit it, jkr check {file}")

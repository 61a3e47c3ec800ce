"""How loud a verb is: results to stdout unless quiet, details to stderr when verbose, warnings to stderr always."""

from __future__ import annotations

import contextlib
import math
import os
import shlex
import sys
from collections.abc import Callable, Iterator
from typing import Any, TextIO

import click

from ..base.clock import SILENCE, duration
from ..base.errors import printable, writable

LEVEL, SAID, ANNOUNCED = "jkr.level", "jkr.said", "jkr.announced"
QUIET, USUAL, VERBOSE = range(3)
ANEW = 2.0  # choice: factor of what was told from which on more is told anew


def level_options() -> list[click.Option]:
    """``-q`` and ``-v``, of every verb whose result is a file."""
    return [
        click.Option(
            ["-q", "--quiet"],
            is_flag=True,
            expose_value=False,
            callback=_set(QUIET),
            help="Print warnings and errors only (results asked for as JSON are printed all the same).",
        ),
        click.Option(
            ["-v", "--verbose"],
            is_flag=True,
            expose_value=False,
            callback=_set(VERBOSE),
            help="Say more on stderr: stages, costs, versions.",
        ),
    ]


def _set(level: int) -> Any:
    def callback(ctx: click.Context, param: click.Parameter, value: bool) -> None:
        if not value:
            return
        if ctx.meta.get(LEVEL, level) != level:
            raise click.UsageError("-q and -v exclude each other", ctx)
        ctx.meta[LEVEL] = level

    return callback


def _level() -> int:
    ctx = click.get_current_context(silent=True)
    return USUAL if ctx is None else ctx.meta.get(LEVEL, USUAL)


def tell(line: str) -> None:
    """A line on stderr; where nobody can receive it (a full disk, a reader that is gone) work goes on without."""
    try:
        click.echo(line, err=True)
    except OSError:
        give_up(sys.__stderr__)


def give_up(stream: TextIO | None) -> None:
    """Drop what a standard stream still holds and cannot write, so that the interpreter ends quietly with our code."""
    with contextlib.suppress(OSError, ValueError):
        if stream is not None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say(text: str) -> None:
    """A line of the summary."""
    if _level() != QUIET:
        click.echo("\n".join(map(printable, text.split("\n"))))


def note(text: str) -> None:
    """A line on stderr on what goes on, for who waits."""
    if _level() != QUIET:
        tell(f"jkr: {printable(text)}")


def detail(text: str) -> None:
    """A line for those who want to know more."""
    if _level() == VERBOSE:
        tell(f"jkr: {printable(text)}")


def warn(text: str) -> None:
    """A sentence that a reader of the numbers should know; said once."""
    ctx = click.get_current_context(silent=True)
    said: set[str] = set() if ctx is None else ctx.meta.setdefault(SAID, set())
    if text not in said:
        said.add(text)
        tell(f"jkr: warning: {printable(text)}")


def announce(what: str, seconds: float) -> None:
    """Say beforehand what will take so many CPU ``seconds``, where that is long and known."""
    if SILENCE < seconds < math.inf:
        forewarn(f"{what}: about {duration(seconds)} of CPU time", seconds)


def forewarn(words: str, seconds: float) -> None:
    """A note on what will take so many CPU ``seconds``, unless the command has told of about as many."""
    ctx = click.get_current_context(silent=True)
    said: dict[str, float] = {} if ctx is None else ctx.meta
    if seconds > ANEW * said.get(ANNOUNCED, -1.0):
        said[ANNOUNCED] = seconds
        note(words)


@contextlib.contextmanager
def progress(label: str, total: int, seconds: float) -> Iterator[Callable[[bool], None]]:
    """The forecast of all items, and a bar on stderr, on a terminal alone; what it gives is called as an item is
    finished: whether it failed."""
    announce(label, seconds)
    failed = 0
    with click.progressbar(
        range(total), label=label, file=sys.stderr, hidden=not sys.stderr.isatty(), show_percent=False, show_pos=True,
        item_show_func=lambda count: f"{count} failed" if count else None,
    ) as bar:  # fmt: skip

        def step(wrong: bool) -> None:
            nonlocal failed
            failed += wrong
            bar.update(1, failed)

        yield step


def command_line() -> str:
    """What was typed, as a shell would take it; bytes of names that are no text as escapes."""
    return writable(shlex.join(click.get_current_context().find_root().obj))

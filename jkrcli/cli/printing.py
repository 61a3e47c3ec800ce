"""What a verb prints: results to stdout, for people or as JSON, warnings to stderr, lines folded to the terminal's
width."""

from __future__ import annotations

import contextlib
import math
import os
import re
import shlex
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import click

from ..base.errors import counted, printable, writable
from ..base.process import SILENCE, duration

if TYPE_CHECKING:
    from ..base.registry import Result


LEVEL, WARNED, ANNOUNCED = "jkr.level", "jkr.warned", "jkr.announced"
QUIET, USUAL, VERBOSE = range(3)
WIDE = 100  # choice: columns of a line, on wider terminals too
FIRST_LINES = 12  # choice: lines of a first answer
UNIT = r"(?:%|[anpumkMGTµ]?(?:m|N|J|Pa|s|V)\b)"
# What stands in one line: name, value and unit, and the force of a rigid sphere, 1.5 pi w R.
TOGETHER = re.compile(
    rf"(?<=\S) (?== \S)|(?<=[=±]) (?=[-+]?\d)|(?<=\d) (?={UNIT})"
    r"|(?<=\d) (?=pi\b)|(?<=\bpi) (?=w)|(?<=pi w) (?=/|R)|(?<=pi w /) (?=R)"
)


def _level() -> int:
    ctx = click.get_current_context(silent=True)
    return USUAL if ctx is None else ctx.meta.get(LEVEL, USUAL)


def folded(line: str) -> str:
    """A line as several of the terminal's width, broken between words; all but the first are set in."""
    width = max(shutil.get_terminal_size((WIDE, 0)).columns, 40)
    if not os.environ.get("COLUMNS", "").isdigit():  # who sets it is obeyed
        width = min(width, WIDE)
    if len(line) <= width:
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    whole = TOGETHER.sub(lambda gap: "\0" * len(gap[0]), line)
    lines = textwrap.fill(whole, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return lines.replace("\0", " ")


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
    """Lines of the summary."""
    if _level() != QUIET:
        click.echo("\n".join(folded(printable(line)) for line in text.split("\n")))


def present(*results: Sequence[str], last: str = "", most: int = FIRST_LINES) -> None:
    """At most ``most`` lines of a result, its verdict first and the ``last`` among them, as the terminal folds them; of
    several results their verdicts. All of it with -v."""
    lines = [line for lines in results for line in lines]
    room = most - (folded(last).count("\n") + 1) * bool(last)
    shown = lines if len(results) == 1 or _level() == VERBOSE else [lines[0] for lines in results]
    heights = list(accumulate(folded(printable(line)).count("\n") + 1 for line in shown))
    if _level() != VERBOSE and shown and (heights[-1] > room or shown != lines):
        shown = shown[: max(sum(height <= room - 1 for height in heights), 1)]
        shown.append(f"  ... {counted(len(lines) - len(shown), 'more line')} with -v")
    say("\n".join([*shown, *filter(None, [last])]))


def note(text: str) -> None:
    """A line on stderr on what goes on, for who waits."""
    if _level() != QUIET:
        tell(folded(f"jkr: {printable(text)}"))


def detail(text: str) -> None:
    """A line for those who want to know more."""
    if _level() == VERBOSE:
        tell(folded(f"jkr: {printable(text)}"))


def warn(text: str) -> None:
    """A sentence that a reader of the numbers should know; said once."""
    ctx = click.get_current_context(silent=True)
    before: set[str] = set() if ctx is None else ctx.meta.setdefault(WARNED, set())
    if text not in before:
        before.add(text)
        tell(folded(f"jkr: warning: {printable(text)}"))


def announce(what: str, seconds: float) -> None:
    """Say beforehand what will take so many CPU ``seconds``, where that is long and known."""
    if SILENCE < seconds < math.inf:
        forewarn(f"{what}: about {duration(seconds)} of CPU time", seconds)


def forewarn(words: str, seconds: float) -> None:
    """A note on what will take so many CPU ``seconds``, unless the command has told of half as many or more."""
    ctx = click.get_current_context(silent=True)
    meta: dict[str, float] = {} if ctx is None else ctx.meta
    if seconds > 2 * meta.get(ANNOUNCED, -1.0):
        meta[ANNOUNCED] = seconds
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


def answer(data: Mapping[str, Any]) -> None:
    """A result for machines on stdout."""
    from ..base.files import as_json

    click.echo(as_json(data), nl=False)


def give(result: Result, json: bool, written: str = "", of: Path | None = None) -> None:
    """A result on stdout, for machines or for people, these with what is ``written``; then its warnings, after the name
    of the file that they are ``of``."""
    if json:
        answer(result.summary())
    else:
        present(*result.parts, last=written, most=result.first_lines)
    for line in result.warnings:
        warn(f"{of}: {line}" if of else line)

"""The exceptions that the library raises on purpose; any other exception is a bug and shows itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence


def nearest(word: object, allowed: Iterable[object], cutoff: float = 0.5) -> str | None:
    """The one of ``allowed`` that ``word`` may be a misspelling of, one of the same letters but for case first; None
    where none is as like it as ``cutoff``."""
    import difflib

    words = list(map(str, allowed))
    same = [one for one in words if one.casefold() == str(word).casefold()]
    return next(iter(difflib.get_close_matches(str(word), same or words, 1, 0.0 if same else cutoff)), None)


def did_you_mean(word: object, allowed: Iterable[object], cutoff: float = 0.5) -> str:
    """The hint ``, did you mean "..."?`` for a word that is none of ``allowed``; empty where nothing is near."""
    close = nearest(word, allowed, cutoff)
    return "" if close is None else f', did you mean "{close}"?'


def printable(text: str) -> str:
    """``text`` on one line that does nothing to a terminal: line ends and control characters as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def writable(text: str) -> str:
    """``text`` as UTF-8 can hold it: the bytes of file names that are no text as escapes."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def first_line(error: BaseException) -> str:
    """The message of a foreign exception in one line; its type where it has none."""
    return str(error).split("\n", 1)[0] or type(error).__name__


class JkrError(Exception):
    """Root of all errors that carry a message for the user."""

    exit_code = 1


class InputError(JkrError):
    """The input is wrong; ``lines`` holds one sentence per mistake, each naming where, what and what is allowed."""

    exit_code = 2

    def __init__(self, lines: str | Sequence[str]):
        self.lines = tuple(map(printable, (lines,) if isinstance(lines, str) else lines))
        super().__init__("\n".join(self.lines))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[str, ...]]]:
        return type(self), (self.lines,)


def positive(unit: str = "", **values: float) -> None:
    """InputError where a value by name is not a finite number > 0 (of ``unit``)."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name}: must be > 0{unit and ' ' + unit}, got {value:g}")


class Refusal(InputError):
    """A method cannot represent this problem: the message gives the value found and the remedy."""


class SolveError(JkrError):
    """A numerical procedure did not reach what it promises (residual, complementarity, convergence)."""

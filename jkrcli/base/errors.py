"""The exceptions that the library raises on purpose; any other exception is a bug and shows itself."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias


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
    return text if text.isascii() else text.encode("utf-8", "backslashreplace").decode("utf-8")


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


# --------------------------------------------------------------------------------------------------
# A number, or why there is none; what its error is stated at, and from where on one is reported.

LEVEL = 0.95  # theory: usual of stated errors and intervals; of all, where no other is asked for
AT_LEVEL = f"{100 * LEVEL:g} %"  # of all errors, in words
NOTICEABLE = 1e-3  # choice: relative change from which on it is reported


@dataclass(frozen=True)
class Unknown:
    """Stands where a number is not known; ``reason``: a phrase for the reader, without a full stop."""

    reason: str

    def __str__(self) -> str:
        return self.reason

    def __bool__(self) -> bool:
        """Never true, so that ``value or otherwise`` reads as it should."""
        return False


Estimate: TypeAlias = float | Unknown  # mostly a relative error


def counted(count: int, one: str, several: str = "") -> str:
    """``count`` of a thing: "1 row", "1,200 rows"; ``several``: its plural, else with an s."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def known(value: Estimate) -> float | None:
    """The number, or None where it is not known."""
    return None if isinstance(value, Unknown) else value


# --------------------------------------------------------------------------------------------------
# What to type to install an optional part: in a checkout from there, with the Python that runs, else its packages.


def installs(extra: str) -> str:
    """The command that installs the optional part ``extra``, or what is required where it is empty."""
    root = Path(__file__).parents[2]
    if (root / "pyproject.toml").is_file():
        words = ["-e", f"{root}[{extra}]" if extra else str(root)]
    else:
        from importlib import metadata

        # The packages of a part as the installed metadata name them: this one may be on no index.
        try:
            required = metadata.requires("jkrcli") or []
        except metadata.PackageNotFoundError:
            required = []
        parts = (line.partition(";") for line in required)
        words = [name.strip() for name, _, when in parts if (f'"{extra}"' in when if extra else "extra" not in when)]
    return shlex.join([sys.executable or "python3", "-m", "pip", "install", *words])


def accuracy(error: Estimate, name: str = "numerical error") -> str:
    """A relative error called ``name`` in words: where it is small, a power of ten above it."""
    if isinstance(error, Unknown):
        return f"{name} {error}"
    if error >= 1e-4:
        return f"{name} {float(f'{100 * error:.2g}'):g} %"
    return f"{name} below {10.0 ** math.ceil(math.log10(max(error, 1e-15))):.0e}".replace("e-0", "e-")

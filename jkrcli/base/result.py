"""What a result says of itself, once for the command line and for Python.

A result whose class stands in a room below ``report`` (an adhesive curve, a fit) takes its table, summary, words and
picture from the functions that ``report`` registers for its class: ``TABLES``, ``SUMMARIES``, ``WORDS``, ``FIGURES``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from .errors import InputError, installs

if TYPE_CHECKING:
    from pandas import DataFrame

Function = TypeVar("Function", bound=Callable[..., Any])


class Result:
    """One object per result: ``columns`` (of its CSV), ``summary`` (its JSON), ``words`` (what is printed, also by
    ``print``), ``warnings``, and the ``figure``. What a result has not is empty."""

    columns: Mapping[str, Any]
    first_lines: ClassVar[int] = 12  # choice: that are printed without -v

    def summary(self) -> dict[str, Any]:
        """What the command prints with --json."""
        raise NotImplementedError

    def words(self) -> Sequence[str]:
        """Lines of text."""
        raise NotImplementedError

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        """The lines of each of several results in one; the first line of each is its verdict."""
        return [self.words()]

    @property
    def warnings(self) -> Sequence[str]:
        """What a reader of the numbers should know."""
        return ()

    def figure(self) -> Any:
        """The picture, a matplotlib Figure."""
        raise NotImplementedError(f"a {type(self).__name__} has no picture")

    def to_pandas(self) -> DataFrame:
        """The columns as a data frame (needs the optional package pandas)."""
        try:
            from pandas import DataFrame
        except ModuleNotFoundError:
            raise InputError(f"to_pandas needs the optional package pandas: {installs('pandas')}") from None
        return DataFrame(dict(self.columns))

    def __str__(self) -> str:
        return "\n".join(self.words())


class Reports:
    """What results say, by their classes: ``what`` it is, a "table", "summary", "words" or "picture"."""

    def __init__(self, what: str) -> None:
        self.what, self.functions = what, dict[type, Callable[..., Any]]()

    def register(self, kind: type) -> Callable[[Function], Function]:
        """Decorator of a function that says it of results of a ``kind``."""

        def known(function: Function) -> Function:
            self.functions[kind] = function
            return function

        return known

    def __call__(self, result: Result) -> Any:
        for kind in type(result).__mro__:
            if kind in self.functions:
                return self.functions[kind](result)
        raise NotImplementedError(f"a {type(result).__name__} has no {self.what}")


TABLES, SUMMARIES, WORDS, FIGURES = map(Reports, ("table", "summary", "words", "picture"))


class Reported(Result):
    """A result of a room below ``report``, which registers what it says by its class."""

    @cached_property
    def columns(self) -> Mapping[str, Any]:  # type: ignore[override]
        """The columns of the CSV file, by their titles with units."""
        return dict(TABLES(self))

    def summary(self) -> dict[str, Any]:
        return dict(SUMMARIES(self))

    def words(self) -> Sequence[str]:
        return list(WORDS(self))

    def figure(self) -> Any:
        return FIGURES(self)

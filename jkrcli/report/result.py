"""What a result says of itself, once for the command line and for Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from ..base import InputError, installs

if TYPE_CHECKING:
    from pandas import DataFrame

    from . import plots

Figure: TypeAlias = "plots.Figure"  # by its name: matplotlib is imported when something is drawn
AnyResult = TypeVar("AnyResult", bound="Result")


class Result:
    """One object per result: ``columns`` (of its CSV), ``summary`` (its JSON), ``words`` (what is printed, also by
    ``print``), ``warnings``, and the ``figure``. What a result has not is empty."""

    columns: Mapping[str, Any]

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

    def figure(self) -> Figure:
        """The picture."""
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


class Several(Result):
    """A result of several ``parts``."""

    def words(self) -> Sequence[str]:
        return [line for part in self.parts for line in part]


@dataclass(frozen=True, eq=False)
class Results(Several):
    """Results of one kind, with ``warnings`` of all of them; ``name``: of their list in the summary."""

    results: Sequence[Result]
    warnings: Sequence[str] = ()
    name: str = "results"

    def summary(self) -> dict[str, Any]:
        return {self.name: [one.summary() for one in self.results]}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [words for one in self.results if (words := one.words())]


def as_result(kind: type[AnyResult], data: Any, **more: Any) -> AnyResult:
    """The ``data``, a dataclass, as a result of the ``kind`` that extends its class with what is ``more``."""
    return kind(**{item.name: getattr(data, item.name) for item in fields(data)}, **more)

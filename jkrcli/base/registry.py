"""What is called by name: shapes of indenters and laws in a case file; and what is said of each class of results, once
for the command line and for Python.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, get_type_hints

from .errors import InputError, installs

if TYPE_CHECKING:
    from pandas import DataFrame


Builder = TypeVar("Builder", bound=Callable[..., Any])


@dataclass(frozen=True)
class Key:
    """Annotation of a field or parameter that a case file calls by another ``name``."""

    name: str


class Registry(dict[Any, Callable[..., Any]]):
    """The classes or functions that build what a case file calls by a name, by that name; or the functions that say
    something of a result, by its class.

    The parameters of a builder are the keys of the table, read by their annotations (``base.units``: ``Length``,
    ``Ranged``...), optional where they have a default. The parameter ``inherited`` is none of the keys: the table
    around passes it on. ``word``: the key that holds the name; or what is said, "table", "summary", "words", "picture".
    """

    def __init__(self, inherited: str = "", word: str = "law") -> None:
        super().__init__()
        self.inherited, self.word = inherited, word

    def register(self, name: str | type) -> Callable[[Builder], Builder]:
        """Decorator that makes a class or function known by ``name``, a class of results for what is said of them."""

        def known(builder: Builder) -> Builder:
            self[name] = builder
            return builder

        return known

    def parameters(self, name: str) -> dict[str, inspect.Parameter]:
        """The parameters of what is called ``name``, by key; the inherited one too; a default of ``...``: none."""
        hints, parameters = get_type_hints(self[name], include_extras=True), {}
        for item in inspect.signature(self[name]).parameters.values():
            notes = getattr(hints[item.name], "__metadata__", ())
            key = next((note.name for note in notes if isinstance(note, Key)), item.name)
            default = ... if item.default is item.empty else item.default
            parameters[key] = item.replace(annotation=hints[item.name], default=default)
        return parameters

    def keys_in_file(self, thing: object) -> dict[str, Any]:
        """The table of a thing whose class is registered: its name and the values of its keys."""
        for name, builder in self.items():
            if builder is type(thing):
                keys = {key: item.name for key, item in self.parameters(name).items() if key != self.inherited}
                return {self.word: name} | {key: getattr(thing, field) for key, field in keys.items()}
        raise InputError(f"a case has no word for {type(thing).__name__}")

    def said_of(self, result: object) -> Any:
        """What the function registered for the class of ``result`` says of it."""
        for kind in type(result).__mro__:
            if kind in self:
                return self[kind](result)
        raise NotImplementedError(f"a {type(result).__name__} has no {self.word}")


# --------------------------------------------------------------------------------------------------
# What a result says of itself, once for the command line and for Python.
#
# A result whose class stands in a room below ``report`` (an adhesive curve, a fit) takes its table, summary, words
# and picture from the functions that ``report`` registers for its class: ``TABLES``, ``SUMMARIES``, ``WORDS``,
# ``FIGURES``.


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


TABLES, SUMMARIES, WORDS, FIGURES = (Registry(word=word) for word in ("table", "summary", "words", "picture"))


class Reported(Result):
    """A result of a room below ``report``, which registers what it says by its class."""

    @cached_property
    def columns(self) -> Mapping[str, Any]:  # type: ignore[override]
        """The columns of the CSV file, by their titles with units."""
        return dict(TABLES.said_of(self))

    def summary(self) -> dict[str, Any]:
        return dict(SUMMARIES.said_of(self))

    def words(self) -> Sequence[str]:
        return list(WORDS.said_of(self))

    def figure(self) -> Any:
        return FIGURES.said_of(self)

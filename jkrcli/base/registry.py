"""What a case file calls by name: shapes of indenters, laws of a modulus over depth."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar, get_type_hints

from .errors import InputError

Builder = TypeVar("Builder", bound=Callable[..., Any])


@dataclass(frozen=True)
class Key:
    """Annotation of a field or parameter that a case file calls by another ``name``."""

    name: str


class Registry(dict[str, Callable[..., Any]]):
    """The classes or functions that build what a case file calls by a name, by that name.

    Their parameters are the keys of the table, read by their annotations (``base.units``: ``Length``, ``Ranged``...),
    optional where they have a default. The parameter ``inherited`` is none of the keys: the table around passes it on.
    ``word``: the key that holds the name.
    """

    def __init__(self, inherited: str = "", word: str = "law") -> None:
        super().__init__()
        self.inherited, self.word = inherited, word

    def register(self, name: str) -> Callable[[Builder], Builder]:
        """Decorator that makes a class or function known by ``name``."""

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

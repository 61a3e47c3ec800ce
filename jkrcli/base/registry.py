"""What a case file calls by name: shapes of indenters, laws of a modulus over depth."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, TypeVar, get_type_hints

Builder = TypeVar("Builder", bound=Callable[..., Any])


class Registry(dict[str, Callable[..., Any]]):
    """The classes or functions that build what a case file calls by a name, by that name.

    Their parameters are the keys of the table, read by their annotations (``base.units``: ``Length``, ``Ranged``...),
    optional where they have a default. The parameter ``given`` is none of the keys: it comes from elsewhere.
    """

    def __init__(self, given: str) -> None:
        super().__init__()
        self.given = given

    def register(self, name: str) -> Callable[[Builder], Builder]:
        """Decorator that makes a class or function known by ``name``."""

        def known(builder: Builder) -> Builder:
            self[name] = builder
            return builder

        return known

    def keys_of(self, name: str) -> dict[str, tuple[Any, Any]]:
        """Annotation and default (``...``: none) of every key of what is called ``name``."""
        hints = get_type_hints(self[name], include_extras=True)
        parameters = inspect.signature(self[name]).parameters.values()
        return {
            item.name: (hints[item.name], ... if item.default is inspect.Parameter.empty else item.default)
            for item in parameters
            if item.name != self.given
        }

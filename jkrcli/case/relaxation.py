"""The key ``relaxation`` of a specimen: one model per registered law."""

from __future__ import annotations

import functools
import operator
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from ..base import InputError, did_you_mean
from ..bodies import RELAXATIONS
from .fields import BuiltTable, table_of, wrong


class RelaxationTable(BuiltTable):
    """How the moduli relax, by a law."""

    law: str

    @model_validator(mode="after")
    def _usable(self) -> Self:
        try:
            self.built(None)
        except InputError as error:
            raise wrong(str(error).removeprefix("relaxation: ")) from None
        return self


def _known_law(value: Any) -> Any:
    """A table that names no known law is told so before its other keys are looked at."""
    if not isinstance(value, dict | RelaxationTable):
        raise wrong(f'must be a table, such as {{ law = "sls", ratio = 0.25, time = "1 s" }}, got {value}')
    if isinstance(value, dict) and (name := str(value.get("law", "none"))) not in RELAXATIONS:
        raise wrong(f"law must be one of {', '.join(RELAXATIONS)}, got {name}{did_you_mean(name, RELAXATIONS)}")
    return value


def _tag(value: Any) -> str:
    return f"<{value.law if isinstance(value, RelaxationTable) else value['law']}>"


def _table(name: str) -> Any:
    table = table_of(RELAXATIONS, name, RelaxationTable, law=(Literal.__getitem__(name), ...))
    table.tag = f"<{name}>"
    return Annotated[table, Tag(table.tag)]


AnyRelaxation = Annotated[
    functools.reduce(operator.or_, map(_table, RELAXATIONS)), Discriminator(_tag), BeforeValidator(_known_law)
]

"""Building blocks of the case tables: types that read numbers with dimension and range, and the strict table itself."""

from __future__ import annotations

import functools
import operator
import types
from typing import Annotated, Any, ClassVar, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError

from ..base import units
from ..base.units import Ranged


def wrong(message: str) -> PydanticCustomError:
    """A finding in our own words; braces would be taken as a template."""
    return PydanticCustomError("jkr", "{message}", {"message": message})


def readable(annotation: Any) -> Any:
    """The type that reads ``annotation`` from a file: numbers as their ``Ranged`` says, tuples from lists."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        notes = [BeforeValidator(_reader(note)) for note in annotation.__metadata__ if isinstance(note, Ranged)]
        return Annotated[(readable(parts[0]), *notes)] if notes else readable(parts[0])
    if origin is tuple:
        return Annotated[tuple[tuple(map(readable, parts))], BeforeValidator(as_tuple)]
    if origin in (Union, types.UnionType):
        return functools.reduce(operator.or_, map(readable, parts))
    return annotation


def _reader(ranged: Ranged) -> Any:
    def read(value: Any) -> float:
        try:
            return ranged.read(value)
        except ValueError as error:
            raise wrong(str(error)) from None

    return read


def quantity(dimension: str, **bounds: float) -> Any:
    """A finite number of ``dimension``, SI or text with a unit, within the ``bounds`` of ``Ranged``."""
    return readable(Annotated[float, Ranged(dimension, **bounds)])


Length, AnyLength, Modulus, Force, Work, Poisson = map(
    readable, (units.Length, units.AnyLength, units.Modulus, units.Force, units.Work, units.Poisson)
)


def as_tuple(value: Any) -> Any:
    """TOML lists become tuples; anything else is left for the type check."""
    return tuple(value) if isinstance(value, list) else value


def one_or_more(kind: Any) -> Any:
    """A tuple of ``kind``; a single value in the file is a tuple of one."""
    return Annotated[tuple[kind, ...], BeforeValidator(lambda v: as_tuple(v) if isinstance(v, list | tuple) else (v,))]


class Table(BaseModel):
    """A table of the case file: strict types, no unknown keys, frozen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)
    tag: ClassVar[str] = ""

    @classmethod
    def allowed_keys(cls) -> list[str]:
        """The keys that a file may hold here."""
        return list(cls.model_fields)

    @classmethod
    def tags(cls) -> tuple[str, ...]:
        """What an error's path may call this table where several are possible: its ``tag``, or its shape."""
        shape = cls.model_fields.get("shape")
        return (cls.tag,) if shape is None else get_args(shape.annotation)

"""Building blocks of the case tables: numbers with dimension and range, and the strict table itself."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError

from ..base import units


def wrong(message: str) -> PydanticCustomError:
    """A finding in our own words; braces would be taken as a template."""
    return PydanticCustomError("jkr", "{message}", {"message": message})


def _read(value: Any, dimension: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise wrong(
            f"must be {units.WORDS[dimension]}, got {value if not isinstance(value, bool) else str(value).lower()}"
        )
    if isinstance(value, str):
        try:
            return units.parse(value, dimension)
        except ValueError as error:
            raise wrong(str(error)) from None
    try:
        return float(value)
    except OverflowError:
        raise wrong("must be a finite number, got one with more than 300 digits") from None


def quantity(
    dimension: str, *, above: float | None = None, below: float | None = None, least: float | None = None,
    most: float | None = None,
) -> Any:  # fmt: skip
    """A finite number of ``dimension``, SI or text with a unit: ``above < x < below`` or ``least <= x <= most``."""
    bounds = [("> ", above, float.__gt__), (">= ", least, float.__ge__), ("< ", below, float.__lt__),
              ("<= ", most, float.__le__)]  # fmt: skip
    rule = " and ".join(f"{sign}{limit:g}" for sign, limit, _ in bounds if limit is not None)

    def check(value: Any) -> float:
        number = _read(value, dimension)
        given = value if isinstance(value, str) else f"{value} {units.SI[dimension]}".strip()
        if not math.isfinite(number):
            raise wrong(f"must be a finite number, got {given}")
        if dimension != "number" and number != 0 and not 1 / units.MOST <= abs(number) <= units.MOST:
            raise wrong(f"must lie within {1 / units.MOST:g} and {units.MOST:g} in SI units, got {given}")
        if not all(test(number, float(limit)) for _, limit, test in bounds if limit is not None):
            hint = (
                '; a bare number is in rad, write "70 deg"'
                if dimension == "angle" and not isinstance(value, str)
                else ""
            )
            raise wrong(f"must be {rule}, got {given}{hint}")
        return number

    return Annotated[float, BeforeValidator(check)]


Length = quantity("length", above=0)
AnyLength = quantity("length")
Modulus = quantity("modulus", above=0)
Force = quantity("load", above=0)
Work = quantity("work", least=0)
Poisson = quantity("number", above=-1, most=0.5)


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
    def tags(cls) -> tuple[str, ...]:
        """What an error's path may call this table where several are possible: its ``tag``, or its shape."""
        shape = cls.model_fields.get("shape")
        return (cls.tag,) if shape is None else get_args(shape.annotation)

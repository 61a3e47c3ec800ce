"""Types of options: numbers with units, pairs of a key and its value, rows."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from ..adhesion import LOAD_CONTROL
from ..base import units
from .voice import warn

if TYPE_CHECKING:
    ParamType = click.ParamType[Any, Any]
else:
    ParamType = click.ParamType  # not generic in every version of click

WORKERS = click.IntRange(1, 1024)


class NumberRange(click.FloatRange):
    """A number of a range; "nan", which every comparison lets pass, is of none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


POSITIVE = NumberRange(min=0, min_open=True)


class ParsedType(ParamType):
    """What ``parsed`` makes of a text; its ValueError is the message on the option."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):  # it is one already
            return value
        try:
            return self.parsed(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)

    def parsed(self, text: str) -> Any:
        """The value of ``text``; ValueError with what it must be."""
        raise NotImplementedError


class QuantityType(ParsedType):
    """A finite number of a ``dimension``, SI or with a unit, or one of ``words`` that stand for a number; ``allowed``:
    in words, where it must be > 0, else it is at least ``least``."""

    least = -math.inf

    def __init__(self, name: str, dimension: str, allowed: str = "", words: Mapping[str, float] | None = None):
        self.name, self.dimension, self.allowed, self.words = name, dimension, allowed, words or {}

    def parsed(self, text: str) -> Any:
        if (word := text.strip().lower()) in self.words:
            return self.words[word]
        number = units.parse(text, self.dimension)
        if not (math.isfinite(number) and (number > 0 if self.allowed else number >= self.least)):
            raise ValueError(f"must be {self.allowed or f'finite and >= {self.least:g}'}, got {text}")
        least, most = 1 / units.LARGEST_SI, units.LARGEST_SI
        if number != 0 and not least <= abs(number) <= most:
            raise ValueError(f"must lie within {least:g} and {most:g} in SI units, got {text}")
        return number


class WorkType(QuantityType):
    """A work of adhesion; a doubtful bare number is warned of."""

    least = 0.0

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        work = super().convert(value, param, ctx)
        if _is_bare(value) and (doubt := units.doubtful_work(work)):
            warn(f"{param.opts[0] if param else 'w'}: {doubt}")
        return work


def _is_bare(value: Any) -> bool:
    """Whether what was typed is a number without a unit."""
    try:
        return isinstance(value, str) and math.isfinite(float(value))
    except ValueError:
        return False


WORK = WorkType("WORK", "work")
LENGTH, LOAD = QuantityType("LENGTH", "length"), QuantityType("LOAD", "load")
LENGTH_ABOVE_0, STRESS = QuantityType("LENGTH", "length", "> 0"), QuantityType("STRESS", "modulus", "> 0")
FACTOR, SENSITIVITY = QuantityType("FACTOR", "number", "> 0"), QuantityType("SENSITIVITY", "sensitivity", "> 0")
STIFFNESS = QuantityType("STIFFNESS", "stiffness", "> 0", words={"rigid": math.inf})  # of a device
CONTROL = QuantityType("STIFFNESS", "stiffness", '> 0, or "load" for load control, or "rigid"',
                       words={"rigid": math.inf, "load": LOAD_CONTROL})  # fmt: skip


class KeyValueType(ParsedType):
    """KEY=TEXT with one of ``keys``; ``what`` names the text in help."""

    def __init__(self, what: str, keys: Sequence[str]):
        self.name = f"KEY={what}"
        self.keys = keys

    def parsed(self, text: str) -> Any:
        key, mark, value = text.partition("=")
        if not mark or key not in self.keys or not value:
            raise ValueError(f'must be KEY=VALUE with a key of {", ".join(self.keys)}, got "{text}"')
        return key, value


class NamedType(ParsedType):
    """NAME=TEXT, told apart by the name alone: what the text may be depends on it."""

    name, example = "NAME=VALUE", 'NAME=VALUE, such as w="50 mJ/m^2"'
    parted = staticmethod(str.partition)

    def parsed(self, text: str) -> Any:
        name, mark, value = (part.strip() for part in self.parted(text, "="))
        if not (name and mark and value):
            raise ValueError(f'must be {self.example}, got "{text}"')
        return name, value


class ColumnUnitType(NamedType):
    """KEY=UNIT with the key of a quantity, or the name or number of a column: only its file tells them apart."""

    name, example = "KEY=UNIT", "KEY=UNIT with a quantity or a column, such as P=nN"
    parted = staticmethod(str.rpartition)


class PairsType(ParsedType):
    """KEY=VALUE,KEY=VALUE ..."""

    name = "KEY=VALUE,..."

    def parsed(self, text: str) -> Any:
        pairs: dict[str, str] = {}
        for pair in text.split(","):
            key, mark, value = (part.strip() for part in pair.partition("="))
            if not (key and mark and value):
                raise ValueError(f'must be KEY=VALUE,..., such as v0="1 um/s",n=0.6, got "{text}"')
            if key in pairs:
                raise ValueError(f"{key} is given twice")
            pairs[key] = value
        return pairs


class RowsType(ParsedType):
    """FIRST..LAST, whole numbers from 1 on."""

    name = "FIRST..LAST"

    def parsed(self, text: str) -> Any:
        first, mark, last = text.partition("..")
        if not (mark and first.isdecimal() and last.isdecimal() and 0 < int(first[:9]) < int(last[:9])):
            raise ValueError(f'must be FIRST..LAST, two rows counted from 1, such as 100..900, got "{text}"')
        return int(first[:9]), int(last[:9])


ROWS = RowsType()


class ScaleType(KeyValueType):
    """KEY=VALUE with a key among a, delta, P: a length or a load."""

    def __init__(self, keys: Sequence[str] = ("a", "delta", "P")):
        super().__init__("VALUE", keys)

    def parsed(self, text: str) -> Any:
        key, value = super().parsed(text)
        return key, (LOAD if key == "P" else LENGTH).parsed(value)


class KeyNumberType(KeyValueType):
    """KEY=NUMBER, the number finite and not 0."""

    def __init__(self, keys: Sequence[str]):
        super().__init__("NUMBER", keys)

    def parsed(self, text: str) -> Any:
        key, value = super().parsed(text)
        number = 0.0
        with contextlib.suppress(ValueError):
            number = float(value)
        if not math.isfinite(number) or number == 0:
            raise ValueError(f'must be KEY=NUMBER, finite and not 0, got "{text}"')
        return key, number

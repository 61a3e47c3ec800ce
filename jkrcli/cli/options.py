"""Options that several verbs share, and their types: numbers with units, pairs of a key and its value."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from ..adhesion import LOAD_CONTROL
from ..adhesion.slopes import RULES
from ..base import units
from ..methods import LESS, Forecast, Limits, admit
from .verb import as_one, several
from .voice import forewarn, warn

if TYPE_CHECKING:
    ParamType = click.ParamType[Any, Any]
else:
    ParamType = click.ParamType  # not generic in every version of click

WORKERS = click.IntRange(1, 1024)
ANY = Limits(math.inf, math.inf)  # of verbs that have none


class NumberRange(click.FloatRange):
    """A number of a range; "nan", which every comparison lets pass, is of none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


POSITIVE = NumberRange(min=0, min_open=True)


limits_options = as_one(
    "limits",
    lambda limit_memory, limit_time: Limits(limit_memory, limit_time),
    click.option("--limit-memory", type=POSITIVE, metavar="GIB",
                 help="Refuse runs that need more memory [default: 80 % of what is free]."),
    click.option("--limit-time", type=POSITIVE, default=Limits().hours, show_default=True, metavar="HOURS",
                 help="Refuse runs that need more CPU time."),
)  # fmt: skip


def begin(what: str, cost: Forecast, limits: Limits = ANY, less: str = LESS) -> None:
    """Say what ``what`` will cost, where that is much; Refusal beyond the ``limits``, with the advice to ask for
    ``less``."""
    if said := admit(what, cost, limits, less):
        forewarn(said, cost.seconds)


slopes_option = click.option("--slopes", type=click.Choice(["auto", *RULES]), default="auto", show_default=True,
                             help="How S and S' are found.")  # fmt: skip


parallel_options = as_one(
    "parallel",
    lambda workers, scheduler: (workers, scheduler),
    click.option("--workers", type=WORKERS, help="Local processes [default: one per core, if they pay]."),
    click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler that you run, such as tcp://node1:8786."),
)


class ParsedType(ParamType):
    """What ``parsed`` makes of a text; the sentence of its ValueError is told of the option."""

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
    """A finite number of a dimension, SI or with a unit."""

    dimension = "number"
    least = -math.inf
    allowed = ""  # in words, where it must be > 0

    def parsed(self, text: str) -> Any:
        number = units.parse(text, self.dimension)
        if not (math.isfinite(number) and (number > 0 if self.allowed else number >= self.least)):
            raise ValueError(f"must be {self.allowed or f'finite and >= {self.least:g}'}, got {text}")
        least, most = 1 / units.LARGEST_SI, units.LARGEST_SI
        if number != 0 and not least <= abs(number) <= most:
            raise ValueError(f"must lie within {least:g} and {most:g} in SI units, got {text}")
        return number


class WorkType(QuantityType):
    name = "WORK"
    dimension = "work"
    least = 0.0

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        found = super().convert(value, param, ctx)
        if _is_bare(value) and (doubt := units.doubtful_work(found)):
            warn(f"{param.opts[0] if param else 'w'}: {doubt}")
        return found


def _is_bare(value: Any) -> bool:
    """Whether what was typed is a number without a unit."""
    try:
        return isinstance(value, str) and math.isfinite(float(value))
    except ValueError:
        return False


class LengthType(QuantityType):
    name = "LENGTH"
    dimension = "length"


class LoadType(QuantityType):
    name = "LOAD"
    dimension = "load"


class PositiveType(QuantityType):
    """A number > 0."""

    allowed = "> 0"


class StressType(PositiveType):
    name = "STRESS"
    dimension = "modulus"


class RangeType(PositiveType):
    name = "LENGTH"
    dimension = "length"


class FactorType(PositiveType):
    name = "FACTOR"


class StiffnessType(PositiveType):
    """A stiffness > 0 of a device, or "rigid"."""

    name = "STIFFNESS"
    dimension = "stiffness"

    def parsed(self, text: str) -> Any:
        return math.inf if text.strip().lower() == "rigid" else super().parsed(text)


class ControlType(StiffnessType):
    """A stiffness > 0 of a machine or cantilever, "rigid" (displacement control) or "load" (load control)."""

    allowed = '> 0, or "load" for load control, or "rigid"'

    def parsed(self, text: str) -> Any:
        return LOAD_CONTROL if text.strip().lower() == "load" else super().parsed(text)


class SensitivityType(PositiveType):
    name = "SENSITIVITY"
    dimension = "sensitivity"


# Of adhesion of finite range: its tension [Pa] and its length [m].
range_options = as_one(
    "attraction",
    lambda stress, length: (stress, length),
    click.option("--stress", type=StressType(),
                 help='Adhesion of finite range: its tension, "100 MPa" [default: the case\'s].'),
    click.option("--range", "length", type=RangeType(), help='The same by its range, "0.3 nm".'),
)  # fmt: skip
# One state of a contact, of which exactly one of radius and load is given.
state_options = several(
    click.option("--a", "radius", type=LengthType(), help='Contact radius, "2 um".'),
    click.option("--load", type=LoadType(), help='Load, "-3 mN" (stable branch), compression positive.'),
    click.option("--w", "work", type=WorkType(), help="Work of adhesion; 0: nonadhesive [default: the case's first]."),
)
modulus_factor_option = click.option(
    "--modulus-factor", type=FactorType(), default="1", show_default=True,
    help="All moduli, and a surface tension, this many times the case's; nothing is solved anew.",
)  # fmt: skip


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
        found: dict[str, str] = {}
        for pair in text.split(","):
            key, mark, value = (part.strip() for part in pair.partition("="))
            if not (key and mark and value):
                raise ValueError(f'must be KEY=VALUE,..., such as v0="1 um/s",n=0.6, got "{text}"')
            if key in found:
                raise ValueError(f"{key} is given twice")
            found[key] = value
        return found


class RowsType(ParsedType):
    """FIRST..LAST, whole numbers from 1 on."""

    name = "FIRST..LAST"

    def parsed(self, text: str) -> Any:
        first, mark, last = text.partition("..")
        if not (mark and first.isdecimal() and last.isdecimal() and 0 < int(first[:9]) < int(last[:9])):
            raise ValueError(f'must be FIRST..LAST, two rows counted from 1, such as 100..900, got "{text}"')
        return int(first[:9]), int(last[:9])


class ScaleType(KeyValueType):
    """KEY=VALUE with a key among a, delta, P: a length or a load."""

    def __init__(self, keys: Sequence[str] = ("a", "delta", "P")):
        super().__init__("VALUE", keys)

    def parsed(self, text: str) -> Any:
        key, value = super().parsed(text)
        return key, (LoadType() if key == "P" else LengthType()).parsed(value)


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

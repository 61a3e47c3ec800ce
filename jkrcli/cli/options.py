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


class QuantityType(ParamType):
    """A finite number of a dimension, SI or with a unit."""

    dimension = "number"
    least = -math.inf
    allowed = ""  # in words, where that is not all from the least on

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        try:
            number = units.parse(str(value), self.dimension)
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if not (math.isfinite(number) and number >= self.least):
            self.fail(f"must be {self.allowed or f'finite and >= {self.least:g}'}, got {value}", param, ctx)
        least, most = 1 / units.LARGEST_SI, units.LARGEST_SI
        if number != 0 and not least <= abs(number) <= most:
            self.fail(f"must lie within {least:g} and {most:g} in SI units, got {value}", param, ctx)
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

    least = 0.0
    allowed = "> 0"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        found = super().convert(value, param, ctx)
        if found == 0:
            self.fail(f"must be {self.allowed}, got {value}", param, ctx)
        return found


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

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        return math.inf if str(value).strip().lower() == "rigid" else super().convert(value, param, ctx)


class ControlType(StiffnessType):
    """A stiffness > 0 of a machine or cantilever, "rigid" (displacement control) or "load" (load control)."""

    allowed = '> 0, or "load" for load control, or "rigid"'

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        return LOAD_CONTROL if str(value).strip().lower() == "load" else super().convert(value, param, ctx)


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


class KeyValueType(ParamType):
    """KEY=TEXT with one of ``keys``; ``what`` names the text in help."""

    def __init__(self, what: str, keys: Sequence[str]):
        self.name = f"KEY={what}"
        self.keys = keys

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        key, mark, text = str(value).partition("=")
        if not mark or key not in self.keys or not text:
            self.fail(f'must be KEY=VALUE with a key of {", ".join(self.keys)}, got "{value}"', param, ctx)
        return key, text


class NamedType(ParamType):
    """NAME=TEXT, told apart by the name alone: what the text may be depends on it."""

    name, example = "NAME=VALUE", 'NAME=VALUE, such as w="50 mJ/m^2"'
    parted = staticmethod(str.partition)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        if isinstance(value, tuple):
            return value
        name, mark, text = (part.strip() for part in self.parted(str(value), "="))
        if not (name and mark and text):
            self.fail(f'must be {self.example}, got "{value}"', param, ctx)
        return name, text


class ColumnUnitType(NamedType):
    """KEY=UNIT with the key of a quantity, or the name or number of a column: only its file tells them apart."""

    name, example = "KEY=UNIT", "KEY=UNIT with a quantity or a column, such as P=nN"
    parted = staticmethod(str.rpartition)


class PairsType(ParamType):
    """KEY=VALUE,KEY=VALUE ..."""

    name = "KEY=VALUE,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, str]:
        if isinstance(value, dict):
            return value
        found: dict[str, str] = {}
        for pair in str(value).split(","):
            key, mark, text = (part.strip() for part in pair.partition("="))
            if not (key and mark and text):
                self.fail(f'must be KEY=VALUE,..., such as v0="1 um/s",n=0.6, got "{value}"', param, ctx)
            if key in found:
                self.fail(f"{key} is given twice", param, ctx)
            found[key] = text
        return found


class RowsType(ParamType):
    """FIRST..LAST, whole numbers from 1 on."""

    name = "FIRST..LAST"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        first, mark, last = str(value).partition("..")
        if not (mark and first.isdecimal() and last.isdecimal() and 0 < int(first[:9]) < int(last[:9])):
            self.fail(f'must be FIRST..LAST, two rows counted from 1, such as 100..900, got "{value}"', param, ctx)
        return int(first[:9]), int(last[:9])


class ScaleType(KeyValueType):
    """KEY=VALUE with a key among a, delta, P: a length or a load."""

    def __init__(self, keys: Sequence[str] = ("a", "delta", "P")):
        super().__init__("VALUE", keys)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        key, text = super().convert(value, param, ctx)
        kind = LoadType() if key == "P" else LengthType()
        return key, kind.convert(text, param, ctx)


class KeyNumberType(KeyValueType):
    """KEY=NUMBER, the number finite and not 0."""

    def __init__(self, keys: Sequence[str]):
        super().__init__("NUMBER", keys)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        key, text = super().convert(value, param, ctx)
        number = 0.0
        with contextlib.suppress(ValueError):
            number = float(text)
        if not math.isfinite(number) or number == 0:
            self.fail(f'must be KEY=NUMBER, finite and not 0, got "{value}"', param, ctx)
        return key, number

"""Units of the field: strings such as "100 um" or "35 mJ/m^2" to SI numbers, and SI numbers to people's units.

A closed vocabulary on purpose: every unit is a power of ten of the SI unit, so "100 um" is exactly 1e-4, nothing is
guessed ("5 m" is five metres, "-3 Pa" is minus three pascal, "1,5 um" is refused), and a mistake can be answered with
the complete list of what is allowed.
"""

import math
import numbers
import operator
import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Annotated, Any, NamedTuple, TypeAlias

from .errors import InputError, did_you_mean

PREFIX = {"a": -18, "f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9, "T": 12}


class Dimension(NamedTuple):
    """A quantity in ``words``, its unit in ``SI``, an ``example``; the one-letter ``prefixes`` that its units take, by
    unit, and ``other`` units with their powers of ten of that in SI."""

    words: str
    SI: str
    example: str
    prefixes: dict[str, str] = {}  # noqa: RUF012 - of a tuple
    other: dict[str, int] = {}  # noqa: RUF012


PER_LENGTH = {"N/mm": 3, "N/um": 6, "mN/um": 3, "uN/um": 0, "nN/um": -3, "nN/nm": 0, "uN/nm": 3, "pN/nm": -3}
DIMENSIONS = {
    "length": Dimension("a length", "m", "100 um", {"m": "pnumk"}, {"cm": -2, "Å": -10}),
    "modulus": Dimension("a modulus", "Pa", "5 GPa", {"Pa": "kMGT"}, {"N/m^2": 0, "kN/m^2": 3, "N/mm^2": 6}),
    "load": Dimension("a force", "N", "12 uN", {"N": "pnumk"}),
    "work": Dimension("a work of adhesion", "J/m^2", "50 mJ/m^2", {"J/m^2": "num", "N/m": "m"}, {"erg/cm^2": -3}),
    "tension": Dimension("a surface tension", "N/m", "30 mN/m", {"N/m": "um"}, {"dyn/cm": -3}),
    "stiffness": Dimension("a stiffness", "N/m", "0.2 N/m", {"N/m": "umk"}, PER_LENGTH),
    "speed": Dimension("a speed", "m/s", "10 um/s", {"m/s": "pnum"}),
    "time": Dimension("a time", "s", "20 ms", {"s": "num"}),
    "load rate": Dimension("a rate of loading", "N/s", "1 mN/s", {"N/s": "pnum"}),
    "energy": Dimension("an energy", "J", "10 nJ", {"J": "afpnum"}),
    "sensitivity": Dimension("a deflection per volt", "m/V", "45 nm/V", {"m/V": "pnum"}),
    "angle": Dimension("an angle", "rad", "70 deg"),
    "number": Dimension("a plain number", "", "0.3"),
}
SI = {name: dimension.SI for name, dimension in DIMENSIONS.items()}
UNITS = {  # powers of ten of the SI unit
    name: {p + unit: PREFIX[p] for unit, all_p in kind.prefixes.items() for p in ("", *all_p)} | kind.other
    for name, kind in DIMENSIONS.items()
    if kind.prefixes
}
LARGEST_FACTOR = 1e12  # choice: of a column or the moduli, its inverse the least: beyond nm for km, and no use
LARGEST_SI = 1e30  # of a quantity in SI, its inverse the least: beyond what exists, and products of a few stay finite
MODULI = (1e3, 2e12)  # choice: Pa, of soft gels and of diamond; a bare number outside is remarked, never refused
SMALL_WORK = 1e-4  # choice: J/m^2, below what solids of an E* from FIRM on have; remarked, never refused
FIRM = 1e6  # choice: Pa; softer ones, cells and gels in liquids, may have less
LARGE_WORK = 1.0  # choice: J/m^2, above what gels, polymers and contaminated metals have; remarked, never refused
LONGEST = 100  # characters of a quantity
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*\Z")


def parse(text: str, dimension: str) -> float:
    """The SI value of ``text`` ("100 um"; a bare number is SI). Raises ValueError with a full sentence."""
    match = _QUANTITY.match(text) if len(text) <= LONGEST else None
    if not match:
        kind = DIMENSIONS[dimension]
        raise ValueError(f'must be {kind.words}, such as "{kind.example}", got "{text[:LONGEST]}"')
    number, unit = Decimal(match[1]), match[2].replace("µ", "u").replace("μ", "u").replace("²", "^2").replace("**", "^")
    unit = re.sub(r"\s*m\^?-2\Z", "/m^2", unit)
    unit = re.sub(r"(?<=m)2\Z", "^2", unit)
    if not unit:
        return float(number)
    if dimension == "angle" and unit in ("rad", "deg", "°"):
        return float(number) if unit == "rad" else math.radians(float(number))
    powers = UNITS.get(dimension, {})
    if unit not in powers:
        allowed = list(powers) or (["rad", "deg"] if dimension == "angle" else [])
        if not allowed:
            hint = ", no unit is allowed here"
        else:
            pressure = (
                ", a pressure is no force per length" if dimension == "tension" and unit in UNITS["modulus"] else ""
            )
            hint = f"{pressure or did_you_mean(unit, allowed, 0.6)} (allowed: {', '.join(allowed)})"
        raise ValueError(f'must be {DIMENSIONS[dimension].words}, got "{text}": unknown unit "{match[2]}"{hint}')
    return float(number.scaleb(powers[unit]))


@dataclass(frozen=True)
class Ranged:
    """A finite number of ``dimension`` with ``above < x < below`` and ``least <= x <= most``, or what one of ``words``
    stands for; in ``Annotated``.

    From such annotations come the keys of a case file (``jkrcli.case``), the types of options (``jkrcli.cli``) and what
    ``base.arguments`` reads.
    """

    dimension: str
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    words: tuple[tuple[str, float], ...] = ()

    def __contains__(self, number: float) -> bool:
        return all(test(number, limit) for _, limit, test in self._bounds())

    def nearest(self, number: float) -> float:
        """The allowed number nearest to ``number``, of a range that holds its ends."""
        return min(
            max(number, number if self.least is None else self.least), number if self.most is None else self.most
        )

    @property
    def rule(self) -> str:
        """``> 0 and <= 0.5``, ``> 0 or "rigid"``."""
        bounds = " and ".join(f"{sign}{limit:g}" for sign, limit, _ in self._bounds())
        return " or ".join([*([bounds] if bounds else []), *(f'"{word}"' for word, _ in self.words)])

    def _bounds(self) -> Iterator[tuple[str, float, Callable[[float, float], bool]]]:
        signs = ("> ", self.above, operator.gt), (">= ", self.least, operator.ge), ("< ", self.below, operator.lt)
        for sign, limit, test in (*signs, ("<= ", self.most, operator.le)):
            if limit is not None:
                yield sign, limit, test

    def read(self, value: Any) -> float:
        """The SI value of a number [SI] or text with a unit; ValueError with a full sentence where it is wrong."""
        for word, meant in self.words:
            if (value.strip().lower() == word) if isinstance(value, str) else is_number(value) and value == meant:
                return meant
        value = plain(value)
        if not isinstance(value, str) and not is_number(value):
            raise KindError(DIMENSIONS[self.dimension].words, value)
        try:
            number = parse(value, self.dimension) if isinstance(value, str) else float(value)
        except OverflowError:
            raise ValueError("must be a finite number, got one with more than 300 digits") from None
        entry = value if isinstance(value, str) else f"{value} {SI[self.dimension]}".strip()
        if not math.isfinite(number):
            raise ValueError(f"must be a finite number, got {entry}")
        if self.dimension != "number" and number != 0 and not 1 / LARGEST_SI <= abs(number) <= LARGEST_SI:
            raise ValueError(f"must lie between {1 / LARGEST_SI:g} and {LARGEST_SI:g} in SI units, got {entry}")
        if number not in self:
            bare = self.dimension == "angle" and not isinstance(value, str)
            hint = '; a bare number is in rad, write "70 deg"' if bare else ""
            raise ValueError(f"must be {self.rule}, got {entry}{hint}")
        return number


Length: TypeAlias = Annotated[float, Ranged("length", above=0)]
AnyLength: TypeAlias = Annotated[float, Ranged("length")]
Modulus: TypeAlias = Annotated[float, Ranged("modulus", above=0)]
AnyForce: TypeAlias = Annotated[float, Ranged("load")]
Force: TypeAlias = Annotated[float, Ranged("load", above=0)]
Time: TypeAlias = Annotated[float, Ranged("time")]
Work: TypeAlias = Annotated[float, Ranged("work", least=0)]
Factor: TypeAlias = Annotated[float, Ranged("number", least=1 / LARGEST_FACTOR, most=LARGEST_FACTOR)]
Stiffness: TypeAlias = Annotated[float, Ranged("stiffness", above=0, words=(("rigid", math.inf),))]  # of a device
Control: TypeAlias = Annotated[float, Ranged("stiffness", above=0, words=(("load", 0.0), ("rigid", math.inf)))]
Sensitivity: TypeAlias = Annotated[float, Ranged("sensitivity", above=0)]
Tension: TypeAlias = Annotated[float, Ranged("tension", least=0)]
Poisson: TypeAlias = Annotated[float, Ranged("number", above=-1, most=0.5)]


def doubtful_work(w: float) -> str:
    """A remark on a bare number [J/m^2] that is far more than surfaces have; empty where it is not."""
    if w <= LARGE_WORK:
        return ""
    return (
        f"{w:g} without a unit is {show(w, 'work')}, and surfaces have a few mJ/m^2 to {show(LARGE_WORK, 'work')}; "
        f'if it is meant, write "{w:g} J/m^2", if not, perhaps "{w:g} mJ/m^2"'
    )


def doubtful_modulus(E: float) -> str:
    """A remark on a bare number [Pa] that hardly any solid has as its modulus; empty where many have."""
    least, most = MODULI
    if least <= E <= most:
        return ""
    perhaps = f', if not, perhaps "{E:g} MPa"' if E < least else ""
    return (
        f"{E:g} without a unit is {show(E, 'modulus')}, and solids have {show(least, 'modulus')} to "
        f'{show(most, "modulus")}; if it is meant, write "{E:g} Pa"{perhaps}'
    )


class KindError(ValueError):
    """A value is not even of the kind that is ``wanted``."""

    def __init__(self, wanted: str, value: Any):
        super().__init__(f"must be {wanted}, got {shortly(value)}")
        self.wanted = wanted


def shortly(value: Any) -> str:
    """A value in a message: numbers, texts and short lists as they are, of others their type."""
    if value is None or isinstance(value, bool):
        return {None: "nothing", True: "true", False: "false"}[value]
    if isinstance(value, str):
        return f'"{value[:LONGEST]}"'
    if isinstance(value, type):
        return f"the class {value.__name__}: write {value.__name__}(...)"
    if is_number(value):
        return f"{value}"[:LONGEST]
    return reprlib.repr(value) if isinstance(value, list | tuple | dict) else f"{type(value).__name__}(...)"


def plain(value: Any) -> Any:
    """The Python number, truth or text of one of NumPy's, or of an array without dimensions; others as they are."""
    if getattr(value, "shape", None) != () or not hasattr(value, "item"):
        return value
    if getattr(value, "mask", False):
        raise ValueError("is masked")
    return value.item()


def is_number(value: Any) -> bool:
    """Whether ``value`` is a real number, and no truth value."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def show(value: float, dimension: str, digits: int = 4) -> str:
    """``value`` [SI] in the unit that keeps the number between 1 and 1000: ``show(3e-6, "length") == "3 um"``."""
    value = float(f"{value:.{digits}g}") + 0.0  # rounded first: 0.99999 um is 1 um, not 1000 nm; a zero has no sign
    factor, unit = scale(value, dimension)
    return f"{value / factor:.{max(digits, 3)}g} {unit}".strip()  # 260 nm of two digits, not 2.6e+02 nm


def scale(value: float, dimension: str) -> tuple[float, str]:
    """Factor and name of the unit in which people would write ``value`` [SI]; for tables and axes."""
    base = SI[dimension]
    if dimension not in UNITS or value == 0 or not math.isfinite(value):
        return 1.0, base
    power, unit = min(
        ((p, u) for u, p in decades(dimension).items()),
        key=lambda item: (not 1 <= abs(value) / 10.0 ** item[0] < 1000, abs(math.log10(abs(value)) - item[0] - 1)),
    )
    return 10.0**power, unit


def decades(dimension: str) -> dict[str, int]:
    """The units that people choose from by magnitude, with their powers of ten: "um": -6, "mm": -3, ..."""
    base = SI[dimension]
    return {unit: power for unit, power in UNITS[dimension].items() if unit.endswith(base) and power % 3 == 0}


def deviation(relative: float) -> str:
    """By how much a number is wrong in words: "24 % too low"."""
    return f"{100 * abs(relative):.2g} % too {'high' if relative > 0 else 'low'}"


def reached(a: float, delta: float, P: float) -> str:
    """A state of contact as people read it."""
    return f"a = {show(a, 'length')}, delta = {show(delta, 'length')}, P = {show(P, 'load')}"


Named: TypeAlias = Mapping[str, float | str] | Iterable[tuple[str, float | str]]  # values of parameters, SI or text


def texts_of(named: Named) -> list[tuple[str, str]]:
    """Names and values as they are typed; a number is in SI, of all its digits."""
    pairs = []
    for name, value in named.items() if isinstance(named, Mapping) else named:
        if not isinstance(value, str) and not is_number(plain(value)):
            raise InputError(f"fit: {name}: must be a number, SI, or text with its unit, got {shortly(value)}")
        pairs.append((name, value if isinstance(value, str) else repr(float(value))))
    return pairs

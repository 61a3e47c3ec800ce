"""Units of the field: strings such as "100 um" or "35 mJ/m^2" to SI numbers, and SI numbers to people's units.

A closed vocabulary on purpose: every unit is a power of ten of the SI unit, so "100 um" is exactly 1e-4, nothing is
guessed ("5 m" is five metres, "-3 Pa" is minus three pascal, "1,5 um" is refused), and a mistake can be answered with
the complete list of what is allowed.
"""

from __future__ import annotations

import difflib
import math
import re
from decimal import Decimal

PREFIX = {"p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9, "T": 12}


def _family(unit: str, prefixes: str, **extra: int) -> dict[str, int]:
    """Powers of ten of ``unit`` with each of the one-letter ``prefixes`` (and none)."""
    return {p + unit: PREFIX[p] for p in ("", *prefixes)} | extra


UNITS: dict[str, dict[str, int]] = {
    "length": _family("m", "pnumk", cm=-2) | {"Å": -10},
    "modulus": _family("Pa", "kMGT") | {"N/m^2": 0, "kN/m^2": 3, "N/mm^2": 6},
    "load": _family("N", "pnumk"),
    "work": _family("J/m^2", "num") | _family("N/m", "m") | {"erg/cm^2": -3},
    "stiffness": _family("N/m", "umk")
    | {"N/mm": 3, "N/um": 6, "mN/um": 3, "uN/um": 0, "nN/um": -3, "nN/nm": 0}
    | {"uN/nm": 3, "pN/nm": -3},
}
WORDS = {
    "length": "a length",
    "modulus": "a modulus",
    "load": "a force",
    "work": "a work of adhesion",
    "stiffness": "a stiffness",
    "angle": "an angle",
    "number": "a plain number",
}
SI = {"length": "m", "modulus": "Pa", "load": "N", "work": "J/m^2", "stiffness": "N/m", "angle": "rad", "number": ""}
MOST = 1e30  # of a quantity in SI, its inverse the least: beyond what exists, and products of a few stay finite
LONGEST = 100  # characters of a quantity
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*\Z")


def parse(text: str, dimension: str) -> float:
    """The SI value of ``text`` ("100 um"; a bare number is SI). Raises ValueError with a full sentence."""
    match = _QUANTITY.match(text) if len(text) <= LONGEST else None
    if not match:
        raise ValueError(f'must be {WORDS[dimension]}, such as "{_example(dimension)}", got "{text[:LONGEST]}"')
    number, unit = Decimal(match[1]), _normalise(match[2])
    if not unit:
        return float(number)
    if dimension == "angle" and unit in ("rad", "deg", "°"):
        return float(number) if unit == "rad" else math.radians(float(number))
    table = UNITS.get(dimension, {})
    if unit not in table:
        raise ValueError(f'must be {WORDS[dimension]}, got "{text}": unknown unit "{match[2]}"{_hint(unit, dimension)}')
    return float(number.scaleb(table[unit]))


def show(value: float, dimension: str, digits: int = 4) -> str:
    """``value`` [SI] in the unit that keeps the number between 1 and 1000: ``show(3e-6, "length") == "3 um"``."""
    value = float(f"{value:.{digits}g}")  # rounded first: 0.99999 um is 1 um, not 1000 nm
    factor, unit = scale(value, dimension)
    return f"{value / factor:.{digits}g} {unit}".strip()


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


def _normalise(unit: str) -> str:
    unit = unit.replace("µ", "u").replace("μ", "u").replace("²", "^2").replace("**", "^")
    unit = re.sub(r"\s*m\^?-2\Z", "/m^2", unit)
    return re.sub(r"(?<=m)2\Z", "^2", unit)


def _example(dimension: str) -> str:
    examples = {"length": "100 um", "modulus": "5 GPa", "load": "12 uN", "work": "50 mJ/m^2", "stiffness": "0.2 N/m"}
    return examples.get(dimension, "70 deg" if dimension == "angle" else "0.3")


def _hint(unit: str, dimension: str) -> str:
    allowed = list(UNITS.get(dimension, ())) or (["rad", "deg"] if dimension == "angle" else [])
    if not allowed:
        return ", no unit is allowed here"
    close = difflib.get_close_matches(unit, allowed, 1, 0.6)
    suggestion = f', did you mean "{close[0]}"?' if close else ""
    return f"{suggestion} (allowed: {', '.join(allowed)})"

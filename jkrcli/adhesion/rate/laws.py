"""Laws of the work of adhesion over the speed of the contact's edge; each is a class that registers itself.

A receding edge takes w(v) >= w0, an advancing one gives back w_a^2/w(v) <= w_a: the factor of speed is the same in both
directions, divided by when the crack closes (Greenwood, J. Phys. D 37 (2004) 2557).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Protocol, TypeAlias

import numpy as np

from ...base import InputError, Ranged, Registry, check_ranges, did_you_mean

Speed: TypeAlias = Annotated[float, Ranged("speed", above=0)]
Exponent: TypeAlias = Annotated[float, Ranged("number", above=0, most=100)]
PositiveWork: TypeAlias = Annotated[float, Ranged("work", above=0)]

RATE_LAWS = Registry()
rate_law = RATE_LAWS.register  # decorator: the name by which ``--rate law=...`` and ``--law`` call it


class RateLaw(Protocol):
    """w over the edge's speed: a frozen dataclass whose fields, all > 0, are its parameters."""

    def work(self, w0: Any, v: Any) -> Any:
        """w [J/m^2] at the speeds ``v`` >= 0 [m/s], of any shape; ``w0`` at v = 0, growing without bound."""

    def speed(self, w0: float, excess: float) -> float:
        """The speed [m/s] at which w is ``excess`` >= 0 [J/m^2] beyond ``w0``: the inverse of ``work``. OverflowError
        beyond all numbers."""


@rate_law("power")
@dataclass(frozen=True)
class PowerRate:
    """w = w0 (1 + (v/v0)^n) (Gent and Schultz, J. Adhesion 3 (1972) 281; Maugis and Barquins 1978)."""

    v0: Speed
    n: Exponent

    def __post_init__(self) -> None:
        check_ranges(self, "power")

    def work(self, w0: Any, v: Any) -> Any:
        return w0 * (1 + (v / self.v0) ** self.n)

    def speed(self, w0: float, excess: float) -> float:
        return self.v0 * (excess / w0) ** (1 / self.n)


@rate_law("log")
@dataclass(frozen=True)
class LogRate:
    """w = w0 + b log(1 + v/v0): bonds that break thermally activated, b the thermal energy per area of a bond
    (Schallamach, Wear 6 (1963) 375; Chaudhury, J. Phys. Chem. B 103 (1999) 6562)."""

    v0: Speed
    b: PositiveWork

    def __post_init__(self) -> None:
        check_ranges(self, "log")

    def work(self, w0: Any, v: Any) -> Any:
        return w0 + self.b * np.log1p(v / self.v0)

    def speed(self, w0: float, excess: float) -> float:
        return self.v0 * math.expm1(excess / self.b)


def rate_law_of(values: Mapping[str, Any], where: str = "rate") -> RateLaw:
    """The law from its parameters, SI or text with units: ``{"law": "power", "v0": "1 um/s", "n": 0.6}``; "power" where
    none is named. InputError that begins with ``where``."""
    name = str(values.get("law", "power"))
    if name not in RATE_LAWS:
        known = ", ".join(RATE_LAWS)
        raise InputError(f'{where}: unknown law "{name}"{did_you_mean(name, RATE_LAWS)} (laws: {known})')
    allowed, entries = rate_parameters(name), {key: value for key, value in values.items() if key != "law"}
    for key in entries:
        if key not in allowed:
            hint = did_you_mean(key, allowed, 0.4)
            raise InputError(f'{where}: the law "{name}" has no parameter "{key}"{hint} (it has: {", ".join(allowed)})')
    if missing := [key for key in allowed if key not in entries]:
        raise InputError(f'{where}: the law "{name}" needs {", ".join(missing)} too, such as v0="1 um/s"')
    for key, value in entries.items():
        try:
            entries[key] = allowed[key].read(value)
        except ValueError as error:
            raise InputError(f"{where}: {key}: {error}") from None
    law: RateLaw = RATE_LAWS[name](**entries)
    return law


def rate_parameters(name: str) -> dict[str, Ranged]:
    """The parameters of the law called ``name``, by name, with their dimensions and ranges."""
    return dict(_parameters(name, RATE_LAWS[name]))


@cache
def _parameters(name: str, kind: type) -> dict[str, Ranged]:
    """Dimension and range of each parameter of the law called ``name``; kept for each class, as reading annotations
    takes longer than a prediction."""
    notes = {key: getattr(item.annotation, "__metadata__", ()) for key, item in RATE_LAWS.parameters(name).items()}
    return {
        key: next(note for note in reversed(metadata) if isinstance(note, Ranged)) for key, metadata in notes.items()
    }


def parameters_of(law: RateLaw) -> tuple[str, dict[str, float]]:
    """The name of a law and the values of its parameters, SI."""
    values = RATE_LAWS.keys_in_file(law)
    return values.pop(RATE_LAWS.word), values

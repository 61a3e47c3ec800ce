"""Profiles f = B r^d, the cone among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ...base.arrays import Array
from ...base.errors import InputError, positive
from ...base.units import Ranged
from ...formulas.half_space import abel_factor, power_law
from ..indenter import Indenter, shape
from ..materials import Elastic


@dataclass(frozen=True)
class PowerLaw(Indenter):
    """f = B r^d with d >= 1 (d = 1: cone of slope B); ``B`` in m^(1-d). F = c_d B x^d (Galin 1946, Sneddon 1965)."""

    B: float
    d: float
    material: Elastic | None = None
    noun: ClassVar[str] = "power law"

    def __post_init__(self) -> None:
        positive(B=self.B)
        if not (math.isfinite(self.d) and self.d >= 1):
            raise InputError(f"exponent: must be >= 1 (a convex profile), got {self.d:g}")

    @property
    def tip_radius(self) -> float | None:
        return 1 / (2 * self.B) if self.d == 2 else None

    @property
    def words(self) -> str:
        return f"cone of slope {self.B:.4g}" if self.d == 1 else f"profile {self.B:.4g} r^{self.d:g}"

    def f(self, r: Array) -> Array:
        return self.B * np.asarray(r, dtype=float) ** self.d

    def slope(self, r: Array) -> Array:
        return self.B * self.d * np.asarray(r, dtype=float) ** (self.d - 1)

    def abel(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # infinite is what it is then, and what a search for a radius can tell
            return self.B * (abel_factor(self.d) * np.asarray(x, dtype=float) ** self.d)

    def abel_slope(self, x: Array) -> Array:
        return self.d * self.abel(x) / x

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return power_law(a, E_star, self.B, self.d)


@shape("power")
def of_coefficient(
    coefficient: Annotated[float, Ranged("number", above=0)],
    exponent: Annotated[float, Ranged("number", least=1, most=20)],
    material: Elastic | None,
) -> PowerLaw:
    """f = coefficient r^exponent in SI (coefficient in m^(1 - exponent))."""
    return PowerLaw(coefficient, exponent, material)


@shape("cone")
def of_half_angle(
    half_angle: Annotated[float, Ranged("angle", above=0, below=math.pi / 2)], material: Elastic | None
) -> PowerLaw:
    """The cone of a case file; ``half_angle``: between the axis and the surface."""
    return PowerLaw(1 / math.tan(half_angle), 1.0, material)

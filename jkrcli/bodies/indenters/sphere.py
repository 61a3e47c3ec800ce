"""The exact sphere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...base.arrays import Array
from ...base.errors import positive
from ...base.units import Length, show
from ...formulas.half_space import sneddon_sphere
from ..indenter import Indenter, shape
from ..materials import Elastic


@dataclass(frozen=True)
class Sphere(Indenter):
    """Exact sphere of radius ``R`` [m]: f = R - sqrt(R^2 - r^2), F = x artanh(x/R)."""

    R: float
    material: Elastic | None = None
    noun: ClassVar[str] = "sphere"

    def __post_init__(self) -> None:
        positive(R=self.R)

    @property
    def r_max(self) -> float:
        return self.R

    @property
    def tip_radius(self) -> float:
        return self.R

    @property
    def words(self) -> str:
        return f"sphere R = {show(self.R, 'length')}"

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        inside = np.minimum(r, self.R)
        return np.where(r <= self.R, r**2 / (self.R + np.sqrt(self.R**2 - inside**2)), np.inf)

    def slope(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        return r / np.sqrt(self.R**2 - r**2)

    def abel(self, x: Array) -> Array:
        x = np.asarray(x, dtype=float)
        return x * np.arctanh(x / self.R)

    def abel_slope(self, x: Array) -> Array:
        return np.arctanh(x / self.R) + x * self.R / ((self.R - x) * (self.R + x))

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return sneddon_sphere(a, E_star, self.R)


@shape("sphere")
def of_radius(radius: Length, material: Elastic | None) -> Sphere:
    """The sphere of a case file."""
    return Sphere(radius, material)

"""The paraboloid, and by it a sphere on a sphere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...base.arrays import Array
from ...base.errors import InputError, positive
from ...base.units import AnyLength, Length, show
from ...formulas.half_space import effective_radius, hertz
from ..indenter import Indenter, shape
from ..materials import Elastic


@dataclass(frozen=True)
class Paraboloid(Indenter):
    """Paraboloid of tip radius ``R`` [m], the profile of classical JKR: f = r^2/(2R), F = x^2/R."""

    R: float
    material: Elastic | None = None
    noun: ClassVar[str] = "paraboloid"

    def __post_init__(self) -> None:
        positive(R=self.R)

    @property
    def tip_radius(self) -> float:
        return self.R

    @property
    def words(self) -> str:
        return f"paraboloid R = {show(self.R, 'length')}"

    def f(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) ** 2 / (2 * self.R)

    def slope(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) / self.R

    def abel(self, x: Array) -> Array:
        return np.asarray(x, dtype=float) ** 2 / self.R

    def abel_slope(self, x: Array) -> Array:
        return 2 * x / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return hertz(a, E_star, self.R)


@shape("paraboloid")
def on_a_sphere(radius: Length, counter_radius: AnyLength | None = None, *, material: Elastic | None) -> Paraboloid:
    """The paraboloid of a case file; ``counter_radius``: of a spherical specimen (negative: a cavity)."""
    if counter_radius is None:
        return Paraboloid(radius, material)
    if counter_radius == 0 or 1 / radius + 1 / counter_radius <= 0:
        raise InputError(
            f"counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got {counter_radius:g} m"
        )
    return Paraboloid(effective_radius(radius, counter_radius), material)

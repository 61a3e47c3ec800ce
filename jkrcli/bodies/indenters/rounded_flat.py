"""The flat end with a rounded edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...base.arrays import Array
from ...base.errors import positive
from ...base.units import Length, show
from ...formulas.half_space import rounded_flat, tangent_minus_angle
from ..indenter import Indenter, shape
from ..materials import Elastic


@dataclass(frozen=True)
class RoundedFlat(Indenter):
    """Flat end of radius ``b`` with a parabolic edge of radius ``edge_radius``: f = (r - b)^2/(2 edge_radius) outside.

    Contact begins at once over the flat (a0 = b). F = (x sqrt(x^2 - b^2) - x b arccos(b/x))/edge_radius.
    """

    b: float
    edge_radius: float
    material: Elastic | None = None
    noun: ClassVar[str] = "rounded flat end"

    def __post_init__(self) -> None:
        positive(flat_radius=self.b, edge_radius=self.edge_radius)

    @property
    def a0(self) -> float:
        return self.b

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.b,)

    @property
    def words(self) -> str:
        return f"flat end b = {show(self.b, 'length')} with edge radius {show(self.edge_radius, 'length')}"

    def f(self, r: Array) -> Array:
        return np.maximum(np.asarray(r, dtype=float) - self.b, 0) ** 2 / (2 * self.edge_radius)

    def slope(self, r: Array) -> Array:
        return np.maximum(np.asarray(r, dtype=float) - self.b, 0) / self.edge_radius

    def abel(self, x: Array) -> Array:
        x = np.maximum(np.asarray(x, dtype=float), self.b)
        tangent = np.sqrt((x - self.b) * (x + self.b)) / self.b
        return x * self.b * tangent_minus_angle(tangent) / self.edge_radius

    def abel_slope(self, x: Array) -> Array:
        root = np.sqrt(np.maximum(x - self.b, 0) * (x + self.b))
        return (2 * root - self.b * np.arctan2(root, self.b)) / self.edge_radius

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return rounded_flat(a, E_star, self.b, self.edge_radius)


@shape("flat")
def with_edge(flat_radius: Length, edge_radius: Length, material: Elastic | None) -> RoundedFlat:
    """The flat end of a case file."""
    return RoundedFlat(flat_radius, edge_radius, material)

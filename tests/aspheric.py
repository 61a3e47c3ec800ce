"""An indenter of one's own, all of it in this module: an aspheric lens f = r^2/(2 R) + k r^4."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from jkrcli.base.numerics import Array
from jkrcli.base.units import Length, Ranged, show
from jkrcli.bodies.indenters import Indenter, shape
from jkrcli.bodies.problem import Elastic


@shape("aspheric")
@dataclass(frozen=True)
class Aspheric(Indenter):
    """Lens of tip radius ``radius`` [m] and aspheric coefficient ``k`` [m^-3]; F = x^2/R + (8/3) k x^4."""

    radius: Length
    k: Annotated[float, Ranged("number", least=0)] = 0.0
    material: Elastic | None = None
    noun: ClassVar[str] = "lens"

    @property
    def tip_radius(self) -> float:
        return self.radius

    @property
    def words(self) -> str:
        return f"lens R = {show(self.radius, 'length')}"

    def f(self, r: Array) -> Array:
        return r**2 / (2 * self.radius) + self.k * r**4

    def slope(self, r: Array) -> Array:
        return r / self.radius + 4 * self.k * r**3

    def abel(self, x: Array) -> Array:
        return x**2 / self.radius + 8 / 3 * self.k * x**4

    def abel_slope(self, x: Array) -> Array:
        return 2 * x / self.radius + 32 / 3 * self.k * x**3

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        a = np.asarray(a, dtype=float)
        return self.abel(a), E_star * (4 * a**3 / (3 * self.radius) + 64 / 15 * self.k * a**5)

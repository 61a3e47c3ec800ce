"""Tips of cantilevers and of hardness testers: cones with a rounded end, pyramids as the cones of equal area."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ...base import Array, InputError, Key, Length, positive, show
from ...formulas import half_space
from ..indenter import Indenter, shape
from ..materials import Elastic
from .analytic import HalfAngle, PowerLaw

AREAS = {3: 3 * math.sqrt(3), 4: 4.0}  # theory: of the section of a pyramid over the square of its inner radius


@shape("rounded-cone")
@dataclass(frozen=True)
class RoundedCone(Indenter):
    """A cone of ``half_angle`` [rad] between axis and surface, its end a paraboloid of radius ``R`` [m] that goes over
    into it without a bend, at b = R cot(half_angle): f = r^2/(2R) up to b, then (r - b/2) b/R (Maugis and Barquins
    1983). F = x^2/R, from b on (x^2 - x sqrt(x^2 - b^2) + x b arccos(b/x))/R."""

    R: Annotated[Length, Key("radius")]
    half_angle: HalfAngle
    material: Elastic | None = None
    noun: ClassVar[str] = "rounded cone"

    def __post_init__(self) -> None:
        positive(R=self.R)
        if not 0 < self.half_angle < math.pi / 2:
            raise InputError(f"half_angle: must be > 0 and < 90 deg, got {math.degrees(self.half_angle):g} deg")

    @property
    def b(self) -> float:
        """The radius [m] at which the cone begins."""
        return self.R / math.tan(self.half_angle)

    @property
    def tip_radius(self) -> float:
        return self.R

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.b,)

    @property
    def words(self) -> str:
        return f"rounded cone R = {show(self.R, 'length')}, half angle {math.degrees(self.half_angle):.4g} deg"

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        inside = np.minimum(r, self.b)
        return (inside**2 / 2 + (r - inside) * self.b) / self.R

    def slope(self, r: Array) -> Array:
        return np.minimum(np.asarray(r, dtype=float), self.b) / self.R

    def abel(self, x: Array) -> Array:
        return half_space.rounded_cone(x, 1.0, self.R, self.b)[0]

    def abel_slope(self, x: Array) -> Array:
        x = np.asarray(x, dtype=float)
        root, angle = half_space.beyond(x, self.b)
        return (2 * (x - root) + self.b * angle) / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return half_space.rounded_cone(a, E_star, self.R, self.b)


@dataclass(frozen=True)
class EqualAreaCone(PowerLaw):
    """The cone whose sections have the area of those of a pyramid of as many ``sides``, ``half_angle`` [rad] between
    its axis and a face: cot(cone) = sqrt(pi/A) cot(half_angle), A = 4 or 3 sqrt(3)."""

    sides: int = 4
    half_angle: float = math.pi / 4

    @classmethod
    def of(cls, sides: int, half_angle: float, material: Elastic | None) -> EqualAreaCone:
        return cls(math.sqrt(math.pi / AREAS[sides]) / math.tan(half_angle), 1.0, material, sides, half_angle)

    @property
    def keys(self) -> dict[str, Any]:
        return {"shape": "pyramid" if self.sides == 4 else "three-sided-pyramid", "half_angle": self.half_angle}

    @property
    def words(self) -> str:
        cone, face = (math.degrees(angle) for angle in (math.atan(1 / self.B), self.half_angle))
        return f"pyramid of {self.sides} faces at {face:.4g} deg as its equal-area cone of {cone:.4g} deg"


@shape("pyramid")
def of_four_faces(half_angle: HalfAngle, material: Elastic | None) -> EqualAreaCone:
    """The four-sided pyramid of a case file, of cantilevers and Vickers; ``half_angle``: between axis and face."""
    return EqualAreaCone.of(4, half_angle, material)


@shape("three-sided-pyramid")
def of_three_faces(half_angle: HalfAngle, material: Elastic | None) -> EqualAreaCone:
    """The three-sided pyramid of a case file, Berkovich's or a cube's corner; ``half_angle``: between axis and face."""
    return EqualAreaCone.of(3, half_angle, material)

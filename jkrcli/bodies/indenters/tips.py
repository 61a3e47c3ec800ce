"""Tips of cantilevers and of hardness testers: cones with a rounded end, pyramids as the cones that stand for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import numpy as np

from ...base import Array, InputError, Key, Length, positive, show
from ...formulas import half_space
from ..indenter import Indenter, shape
from ..materials import Solid
from .analytic import HalfAngle, PowerLaw

Cap: TypeAlias = Literal["sphere", "parabola"]
Equal: TypeAlias = Literal["load", "area"]

# theory: of a rigid pyramid of so many faces on a frictionless half-space, at the angle t of a face to the axis, load P
# over E* tan(t) delta^2 and contact area over (tan(t) delta)^2: boundary elements, extrapolated from grids up to 384^2
# (tests/bodies/test_pyramids.py); of a cone 2/pi and 4/pi
LOADS = {3: 0.8824, 4: 0.7376}
CONTACTS = {3: 1.77, 4: 1.48}
SECTIONS = {3: 3 * math.sqrt(3), 4: 4.0}  # theory: area of the section of a pyramid over the square of its inner radius


@shape("rounded-cone")
@dataclass(frozen=True)
class RoundedCone(Indenter):
    """A cone of ``half_angle`` alpha [rad] between axis and surface, its end of radius ``R`` [m], without a bend.

    ``cap`` "sphere": the end is spherical up to b = R cos(alpha), as tips are described by their makers; "parabola": it
    is a paraboloid up to b = R cot(alpha) (Maugis and Barquins 1983). Beyond b the slope is cot(alpha).
    """

    R: Annotated[Length, Key("radius")]
    half_angle: HalfAngle
    material: Solid | None = None
    cap: Cap = "sphere"
    noun: ClassVar[str] = "rounded cone"

    def __post_init__(self) -> None:
        positive(R=self.R)
        if not 0 < self.half_angle < math.pi / 2:
            raise InputError(f"half_angle: must be > 0 and < 90 deg, got {math.degrees(self.half_angle):g} deg")
        if self.cap not in ("sphere", "parabola"):
            raise InputError(f'cap: must be one of sphere, parabola, got "{self.cap}"')

    @property
    def b(self) -> float:
        """The radius [m] at which the cone begins."""
        return self.R * (math.cos if self.cap == "sphere" else _cot)(self.half_angle)

    @property
    def tip_radius(self) -> float:
        return self.R

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.b,)

    @property
    def words(self) -> str:
        cap = {"sphere": "spherical", "parabola": "parabolic"}[self.cap]
        angle = f"half angle {math.degrees(self.half_angle):.4g} deg"
        return f"rounded cone R = {show(self.R, 'length')}, {angle}, {cap} cap"

    @property
    def remark(self) -> str:
        return self.words

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        inside = np.minimum(r, self.b)
        height = self.R if self.cap == "parabola" else (self.R + np.sqrt((self.R - inside) * (self.R + inside))) / 2
        return inside**2 / (2 * height) + (r - inside) * _cot(self.half_angle)

    def slope(self, r: Array) -> Array:
        inside = np.minimum(np.asarray(r, dtype=float), self.b)
        return inside / (self.R if self.cap == "parabola" else np.sqrt((self.R - inside) * (self.R + inside)))

    def abel(self, x: Array) -> Array:
        return self.half_space(x, 1.0)[0]

    def abel_slope(self, x: Array) -> Array:
        x = np.asarray(x, dtype=float)
        if self.cap == "sphere":
            return half_space.sphere_capped_cone_rate(x, self.R, self.b)
        root, angle = half_space.beyond(x, self.b)
        return (2 * (x - root) + self.b * angle) / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        formula = half_space.sphere_capped_cone if self.cap == "sphere" else half_space.rounded_cone
        return formula(a, E_star, self.R, self.b)


def _cot(angle: float) -> float:
    return 1 / math.tan(angle)


@dataclass(frozen=True)
class Pyramid(PowerLaw):
    """The cone that stands for a pyramid of ``sides`` faces, ``half_angle`` theta [rad] between its axis and a face.

    ``equal`` "load": the cone that carries the pyramid's load at equal depth on a frictionless half-space,
    tan(cone) = (pi/2) c tan(theta) with P = c E* tan(theta) delta^2, c = 0.8824 (three faces), 0.7376 (four).
    "area": the cone whose sections have the pyramid's area, as hardness testers use it: cot(cone) = sqrt(pi/A)
    cot(theta), A = 3 sqrt(3) or 4; it is 7.2 and 2.6 % too compliant.
    """

    sides: int = 4
    half_angle: float = math.pi / 4
    equal: Equal = "load"
    noun: ClassVar[str] = "pyramid"

    @classmethod
    def of(cls, sides: int, half_angle: float, material: Solid | None = None, equal: Equal = "load") -> Pyramid:
        """The pyramid of 3 or 4 ``sides``."""
        if sides not in LOADS:
            raise InputError(f"sides: must be 3 or 4, got {sides}")
        wider = math.pi / 2 * LOADS[sides] if equal == "load" else math.sqrt(SECTIONS[sides] / math.pi)
        return cls(1 / (wider * math.tan(half_angle)), 1.0, material, sides, half_angle, equal)

    @property
    def keys(self) -> dict[str, Any]:
        name = "pyramid" if self.sides == 4 else "three-sided-pyramid"
        return {"shape": name, "half_angle": self.half_angle, "equal": self.equal}

    @property
    def contact_share(self) -> float:
        cone: float = 4 / math.pi / (self.B * math.tan(self.half_angle)) ** 2
        return CONTACTS[self.sides] / cone

    @property
    def words(self) -> str:
        cone, face = (math.degrees(angle) for angle in (math.atan(1 / self.B), self.half_angle))
        coefficient = 2 / math.pi / (self.B * math.tan(self.half_angle))
        return (
            f"pyramid of {self.sides} faces, {face:.4g} deg from axis to face, as its cone of equal {self.equal}, "
            f"{cone:.4g} deg (P = {coefficient:.4f} E* tan({face:.4g} deg) delta^2)"
        )

    @property
    def remark(self) -> str:
        return self.words


@shape("pyramid")
def of_four_faces(half_angle: HalfAngle, material: Solid | None, equal: Equal = "load") -> Pyramid:
    """The four-sided pyramid of a case file, of cantilevers and Vickers; ``half_angle``: between axis and face."""
    return Pyramid.of(4, half_angle, material, equal)


@shape("three-sided-pyramid")
def of_three_faces(half_angle: HalfAngle, material: Solid | None, equal: Equal = "load") -> Pyramid:
    """The three-sided pyramid of a case file, Berkovich's or a cube's corner; ``half_angle``: between axis and face."""
    return Pyramid.of(3, half_angle, material, equal)

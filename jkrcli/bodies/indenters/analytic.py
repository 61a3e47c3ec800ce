"""Indenters whose profile is a formula: sphere, paraboloid, power law and cone, flat punch, rounded flat end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import numpy as np

from ... import formulas
from ...base.arguments import Checked, checked
from ...base.errors import InputError
from ...base.numerics import Array
from ...base.registry import Key
from ...base.units import AnyLength, Length, Ranged, show
from ..problem import Indenter, Solid, shape

HalfAngle = Annotated[float, Ranged("angle", above=0, below=math.pi / 2)]


@dataclass(frozen=True)
class _Round(Checked, Indenter):
    """An indenter that is known by the radius ``R`` [m] of its tip."""

    R: Annotated[Length, Key("radius")]
    material: Solid | None = None

    @property
    def tip_radius(self) -> float:
        return self.R

    @property
    def words(self) -> str:
        return f"{self.noun} R = {show(self.R, 'length')}"


@shape("sphere")
class Sphere(_Round):
    """Exact sphere of radius ``R`` [m]: f = R - sqrt(R^2 - r^2), F = x artanh(x/R)."""

    noun: ClassVar[str] = "sphere"

    @property
    def r_max(self) -> float:
        return self.R

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
        return formulas.sneddon_sphere(a, E_star, self.R)


class Paraboloid(_Round):
    """Paraboloid of tip radius ``R`` [m], the profile of classical JKR: f = r^2/(2R), F = x^2/R."""

    noun: ClassVar[str] = "paraboloid"

    @property
    def keys(self) -> dict[str, Any]:
        return {"shape": "paraboloid", "radius": self.R}

    def f(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) ** 2 / (2 * self.R)

    def slope(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) / self.R

    def abel(self, x: Array) -> Array:
        return np.asarray(x, dtype=float) ** 2 / self.R

    def abel_slope(self, x: Array) -> Array:
        return 2 * x / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return formulas.hertz(a, E_star, self.R)


@shape("paraboloid")
def on_a_sphere(radius: Length, counter_radius: AnyLength | None = None, *, material: Solid | None) -> Paraboloid:
    """The paraboloid of a case file; ``counter_radius``: of a spherical specimen (negative: a cavity)."""
    if counter_radius is None:
        return Paraboloid(radius, material)
    if counter_radius == 0 or 1 / radius + 1 / counter_radius <= 0:
        raise InputError(
            f"counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got {counter_radius:g} m"
        )
    return Paraboloid(formulas.effective_radius(radius, counter_radius), material)


@shape("power")
@dataclass(frozen=True)
class PowerLaw(Checked, Indenter):
    """f = B r^d with d >= 1 (d = 1: cone of slope B); ``B`` in m^(1-d). F = c_d B x^d (Galin 1946, Sneddon 1965)."""

    B: Annotated[float, Ranged("number", above=0), Key("coefficient")]
    d: Annotated[float, Ranged("number", least=1, most=20), Key("exponent")]
    material: Solid | None = None
    noun: ClassVar[str] = "power law"

    @property
    def tip_radius(self) -> float | None:
        return 1 / (2 * self.B) if self.d == 2 else None

    @property
    def words(self) -> str:
        half_angle = math.degrees(math.atan(1 / self.B))
        return f"cone of half-angle {half_angle:.4g} deg" if self.d == 1 else f"profile {self.B:.4g} r^{self.d:g}"

    def f(self, r: Array) -> Array:
        return self.B * np.asarray(r, dtype=float) ** self.d

    def slope(self, r: Array) -> Array:
        return self.B * self.d * np.asarray(r, dtype=float) ** (self.d - 1)

    def abel(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # infinite is what it is then, and what a search for a radius can tell
            return self.B * (formulas.abel_factor(self.d) * np.asarray(x, dtype=float) ** self.d)

    def abel_slope(self, x: Array) -> Array:
        return self.d * self.abel(x) / x

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return formulas.power_law(a, E_star, self.B, self.d)


@shape("cone")
def of_half_angle(half_angle: HalfAngle, material: Solid | None) -> PowerLaw:
    """The cone of a case file; ``half_angle``: between the axis and the surface."""
    return PowerLaw(1 / math.tan(half_angle), 1.0, material)


# theory: height of a plane end over its radius, below the rounding of any displacement that adhesion causes
PLANE = 1e-30


@dataclass(frozen=True)
class FlatPunch(_Round):
    """Flat punch of radius ``R`` [m] with a sharp edge, at which the full contact is pinned (Kendall 1971).

    An edge that has receded to a < R is that of a smaller punch, delta_H = P_H = 0: the limit f = PLANE r^2/R of a
    paraboloid whose height vanishes.
    """

    noun: ClassVar[str] = "flat punch"

    @property
    def rim(self) -> float:
        return self.R

    @property
    def tip_radius(self) -> None:  # type: ignore[override]
        return None

    @property
    def keys(self) -> dict[str, Any]:
        return {"shape": "flat", "radius": self.R}

    def f(self, r: Array) -> Array:
        return PLANE * np.asarray(r, dtype=float) ** 2 / self.R

    def slope(self, r: Array) -> Array:
        return 2 * PLANE * np.asarray(r, dtype=float) / self.R

    def abel(self, x: Array) -> Array:
        return 2 * PLANE * np.asarray(x, dtype=float) ** 2 / self.R

    def abel_slope(self, x: Array) -> Array:
        return 4 * PLANE * np.asarray(x, dtype=float) / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return formulas.hertz(a, E_star, self.R / (2 * PLANE))


@shape("flat")
def flat_end(
    radius: Length | None = None, flat_radius: Length | None = None, edge_radius: Length | None = None,
    *, material: Solid | None,
) -> FlatPunch | RoundedFlat:  # fmt: skip
    """The flat end of a case file: with a sharp edge at ``radius``, or an ``edge_radius`` around ``flat_radius``."""
    if radius is not None and flat_radius is None and edge_radius is None:
        return FlatPunch(radius, material)
    if radius is None and flat_radius is not None and edge_radius is not None:
        return RoundedFlat(flat_radius, edge_radius, material)
    raise InputError("a flat end needs radius (sharp edge), or flat_radius and edge_radius (rounded edge)")


@dataclass(frozen=True)
class RoundedFlat(Checked, Indenter):
    """Flat end of radius ``b`` with a parabolic edge of radius ``edge_radius``: f = (r - b)^2/(2 edge_radius) outside.

    Contact begins at once over the flat (a0 = b). F = (x sqrt(x^2 - b^2) - x b arccos(b/x))/edge_radius.
    """

    b: Annotated[Length, Key("flat_radius")]
    edge_radius: Length
    material: Solid | None = None
    noun: ClassVar[str] = "rounded flat end"

    @property
    def keys(self) -> dict[str, Any]:
        return {"shape": "flat", "flat_radius": self.b, "edge_radius": self.edge_radius}

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
        return x * self.b * formulas.tangent_minus_angle(tangent) / self.edge_radius

    def abel_slope(self, x: Array) -> Array:
        root = np.sqrt(np.maximum(x - self.b, 0) * (x + self.b))
        return (2 * root - self.b * np.arctan2(root, self.b)) / self.edge_radius

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return formulas.rounded_flat(a, E_star, self.b, self.edge_radius)


# --------------------------------------------------------------------------------------------------
# Tips of cantilevers and of hardness testers: cones with a rounded end, pyramids as the cones that stand for them.

Cap: TypeAlias = Literal["sphere", "parabola"]
Equal: TypeAlias = Literal["load", "area"]
Sides: TypeAlias = Literal[3, 4]

# theory: of a rigid pyramid of so many faces on a frictionless half-space, at the angle t of a face to the axis, load P
# over E* tan(t) delta^2 and contact area over (tan(t) delta)^2: boundary elements, extrapolated from grids up to 384^2
# (tests/bodies/test_tips.py); of a cone 2/pi and 4/pi
LOADS = {3: 0.8824, 4: 0.7376}
CONTACTS = {3: 1.77, 4: 1.48}
SECTIONS = {3: 3 * math.sqrt(3), 4: 4.0}  # theory: area of the section of a pyramid over the square of its inner radius


@shape("rounded-cone")
@dataclass(frozen=True)
class RoundedCone(Checked, Indenter):
    """A cone of ``half_angle`` alpha [rad] between axis and surface, its end of radius ``R`` [m], without a bend.

    ``cap`` "sphere": the end is spherical up to b = R cos(alpha), as tips are described by their makers; "parabola": it
    is a paraboloid up to b = R cot(alpha) (Maugis and Barquins 1983). Beyond b the slope is cot(alpha).
    """

    R: Annotated[Length, Key("radius")]
    half_angle: HalfAngle
    material: Solid | None = None
    cap: Cap = "sphere"
    noun: ClassVar[str] = "rounded cone"

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
            return formulas.sphere_capped_cone_rate(x, self.R, self.b)
        root, angle = formulas.beyond(x, self.b)
        return (2 * (x - root) + self.b * angle) / self.R

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        formula = formulas.sphere_capped_cone if self.cap == "sphere" else formulas.rounded_cone
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

    sides: Sides = 4
    half_angle: HalfAngle = math.pi / 4
    equal: Equal = "load"
    noun: ClassVar[str] = "pyramid"

    @classmethod
    @checked
    def of(
        cls, sides: Sides, half_angle: HalfAngle, material: Solid | None = None, equal: Equal = "load"
    ) -> Pyramid:  # fmt: skip
        """The pyramid of 3 or 4 ``sides``."""
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

"""Indenters whose profile is a formula: sphere, paraboloid, power law and cone, flat end with a rounded edge."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ...base import AnyLength, Array, InputError, Key, Length, Ranged, positive, show
from ...formulas import half_space
from ..indenter import Indenter, shape
from ..materials import Solid

HalfAngle = Annotated[float, Ranged("angle", above=0, below=math.pi / 2)]


@dataclass(frozen=True)
class _Round(Indenter):
    """An indenter that is known by the radius ``R`` [m] of its tip."""

    R: Annotated[Length, Key("radius")]
    material: Solid | None = None

    def __post_init__(self) -> None:
        positive(R=self.R)

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
        return half_space.sneddon_sphere(a, E_star, self.R)


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
        return half_space.hertz(a, E_star, self.R)


@shape("paraboloid")
def on_a_sphere(radius: Length, counter_radius: AnyLength | None = None, *, material: Solid | None) -> Paraboloid:
    """The paraboloid of a case file; ``counter_radius``: of a spherical specimen (negative: a cavity)."""
    if counter_radius is None:
        return Paraboloid(radius, material)
    if counter_radius == 0 or 1 / radius + 1 / counter_radius <= 0:
        raise InputError(
            f"counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got {counter_radius:g} m"
        )
    return Paraboloid(half_space.effective_radius(radius, counter_radius), material)


@shape("power")
@dataclass(frozen=True)
class PowerLaw(Indenter):
    """f = B r^d with d >= 1 (d = 1: cone of slope B); ``B`` in m^(1-d). F = c_d B x^d (Galin 1946, Sneddon 1965)."""

    B: Annotated[float, Ranged("number", above=0), Key("coefficient")]
    d: Annotated[float, Ranged("number", least=1, most=20), Key("exponent")]
    material: Solid | None = None
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
            return self.B * (half_space.abel_factor(self.d) * np.asarray(x, dtype=float) ** self.d)

    def abel_slope(self, x: Array) -> Array:
        return self.d * self.abel(x) / x

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return half_space.power_law(a, E_star, self.B, self.d)


@shape("cone")
def of_half_angle(half_angle: HalfAngle, material: Solid | None) -> PowerLaw:
    """The cone of a case file; ``half_angle``: between the axis and the surface."""
    return PowerLaw(1 / math.tan(half_angle), 1.0, material)


@shape("flat")
@dataclass(frozen=True)
class RoundedFlat(Indenter):
    """Flat end of radius ``b`` with a parabolic edge of radius ``edge_radius``: f = (r - b)^2/(2 edge_radius) outside.

    Contact begins at once over the flat (a0 = b). F = (x sqrt(x^2 - b^2) - x b arccos(b/x))/edge_radius.
    """

    b: Annotated[Length, Key("flat_radius")]
    edge_radius: Length
    material: Solid | None = None
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
        return x * self.b * half_space.tangent_minus_angle(tangent) / self.edge_radius

    def abel_slope(self, x: Array) -> Array:
        root = np.sqrt(np.maximum(x - self.b, 0) * (x + self.b))
        return (2 * root - self.b * np.arctan2(root, self.b)) / self.edge_radius

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array]:
        return half_space.rounded_flat(a, E_star, self.b, self.edge_radius)

"""Axisymmetric convex indenters: profile f(r), slope f'(r) and Abel image F(x).

    F(x) = x int_0^x f'(r) / sqrt(x^2 - r^2) dr

F is what the integral equation of the contact problem needs; on a half-space it is the displacement itself:
delta_H(a) = F(a) (Sneddon 1965). All functions take arrays of radii [m] and return arrays of lengths [m]
(``slope``: dimensionless).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..base.errors import InputError
from .materials import Elastic

Array = np.ndarray
KINK = 1e-10  # fraction of an interval over which a kink that the points force is rounded
SERIES_END, SERIES_TERMS = 0.5, 26  # u - arctan(u) by its series below, whose first term left out is 2^-52/55
GAMMA_END = 150  # above, the ratio of two Gamma functions by its asymptotic series, good to 1e-16


class Indenter(Protocol):
    """What every indenter offers; ``material = None`` is rigid."""

    @property
    def material(self) -> Elastic | None: ...

    @property
    def a0(self) -> float:
        """Contact radius at first touch [m]: 0 for round and pointed indenters, > 0 for a flat end."""
        ...

    @property
    def r_max(self) -> float:
        """Largest radius at which the profile is defined [m]."""
        ...

    @property
    def tip_radius(self) -> float | None:
        """Radius of curvature at the tip [m]; None where there is none (cone, flat end, blunt power laws)."""
        ...

    def f(self, r: Array) -> Array: ...
    def slope(self, r: Array) -> Array: ...
    def abel(self, x: Array) -> Array: ...


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name}: must be > 0, got {value:g}")


@dataclass(frozen=True)
class Sphere:
    """Exact sphere of radius ``R`` [m]: f = R - sqrt(R^2 - r^2), F = x artanh(x/R)."""

    R: float
    material: Elastic | None = None
    a0 = 0.0

    def __post_init__(self) -> None:
        _positive(R=self.R)

    @property
    def r_max(self) -> float:
        return self.R

    @property
    def tip_radius(self) -> float:
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


@dataclass(frozen=True)
class Paraboloid:
    """Paraboloid of tip radius ``R`` [m], the profile of classical JKR: f = r^2/(2R), F = x^2/R."""

    R: float
    material: Elastic | None = None
    a0 = 0.0
    r_max = math.inf

    def __post_init__(self) -> None:
        _positive(R=self.R)

    @property
    def tip_radius(self) -> float:
        return self.R

    def f(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) ** 2 / (2 * self.R)

    def slope(self, r: Array) -> Array:
        return np.asarray(r, dtype=float) / self.R

    def abel(self, x: Array) -> Array:
        return np.asarray(x, dtype=float) ** 2 / self.R


@dataclass(frozen=True)
class PowerLaw:
    """f = B r^d with d >= 1 (d = 1: cone of slope B); ``B`` in m^(1-d). F = c_d B x^d (Galin 1946, Sneddon 1965)."""

    B: float
    d: float
    material: Elastic | None = None
    a0 = 0.0
    r_max = math.inf

    def __post_init__(self) -> None:
        _positive(B=self.B)
        if not (math.isfinite(self.d) and self.d >= 1):
            raise InputError(f"exponent: must be >= 1 (a convex profile), got {self.d:g}")

    @property
    def tip_radius(self) -> float | None:
        return 1 / (2 * self.B) if self.d == 2 else None

    @property
    def c_d(self) -> float:
        """Abel factor of r^d: sqrt(pi) Gamma(d/2 + 1)/Gamma((d + 1)/2)."""
        return abel_factor(self.d)

    def f(self, r: Array) -> Array:
        return self.B * np.asarray(r, dtype=float) ** self.d

    def slope(self, r: Array) -> Array:
        return self.B * self.d * np.asarray(r, dtype=float) ** (self.d - 1)

    def abel(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # infinite is what it is then, and what a search for a radius can tell
            return self.B * (self.c_d * np.asarray(x, dtype=float) ** self.d)


@dataclass(frozen=True)
class RoundedFlat:
    """Flat end of radius ``b`` with a parabolic edge of radius ``edge_radius``: f = (r - b)^2/(2 edge_radius) outside.

    Contact begins at once over the flat (a0 = b). F = (x sqrt(x^2 - b^2) - x b arccos(b/x))/edge_radius.
    """

    b: float
    edge_radius: float
    material: Elastic | None = None
    r_max = math.inf
    tip_radius = None

    def __post_init__(self) -> None:
        _positive(flat_radius=self.b, edge_radius=self.edge_radius)

    @property
    def a0(self) -> float:
        return self.b

    def f(self, r: Array) -> Array:
        return np.maximum(np.asarray(r, dtype=float) - self.b, 0) ** 2 / (2 * self.edge_radius)

    def slope(self, r: Array) -> Array:
        return np.maximum(np.asarray(r, dtype=float) - self.b, 0) / self.edge_radius

    def abel(self, x: Array) -> Array:
        x = np.maximum(np.asarray(x, dtype=float), self.b)
        tangent = np.sqrt((x - self.b) * (x + self.b)) / self.b
        return x * self.b * tangent_minus_angle(tangent) / self.edge_radius


@dataclass(frozen=True, eq=False)
class TableProfile:
    """A measured or designed profile given by points (``r``, ``f``) [m], convex, from (0, 0) outwards.

    Between the points the profile is the convexity-preserving quadratic spline of Schumaker (1983), exact for a
    paraboloid; its Abel image is a sum of closed forms.
    """

    r: tuple[float, ...]
    heights: tuple[float, ...]
    material: Elastic | None = None
    knots: Array = field(init=False, repr=False)
    slopes: Array = field(init=False, repr=False)
    values: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        r, f = np.asarray(self.r, dtype=float), np.asarray(self.heights, dtype=float)
        _check_table(r, f)
        knots, slopes = _schumaker(r, f)
        values = np.concatenate([[0.0], np.cumsum(np.diff(knots) * (slopes[1:] + slopes[:-1]) / 2)])
        for name, array in (("knots", knots), ("slopes", slopes), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TableProfile) and (self.r, self.heights, self.material) == (
            other.r,
            other.heights,
            other.material,
        )

    def __hash__(self) -> int:
        return hash((self.r, self.heights, self.material))

    @property
    def a0(self) -> float:
        return float(max((r for r, f in zip(self.r, self.heights, strict=True) if f == 0), default=0.0))

    @property
    def r_max(self) -> float:
        return self.r[-1]

    @property
    def tip_radius(self) -> float | None:
        curvature = (self.slopes[1] - self.slopes[0]) / (self.knots[1] - self.knots[0])
        pointed = self.slopes[0] > 1e-3 * self.slopes[-1]
        return None if self.a0 > 0 or pointed or curvature <= 0 else float(1 / curvature)

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        i = np.clip(np.searchsorted(self.knots, r, side="right") - 1, 0, self.knots.size - 2)
        step = r - self.knots[i]
        inside = self.values[i] + step * (self.slopes[i] + self.slope(r)) / 2
        return np.where(r <= self.r_max * (1 + 1e-12), inside, np.inf)

    def slope(self, r: Array) -> Array:
        return np.interp(np.asarray(r, dtype=float), self.knots, self.slopes)

    def abel(self, x: Array) -> Array:
        """Slope alpha + beta r on each piece: its image is x [alpha arcsin(r/x) - beta sqrt(x^2 - r^2)]."""
        x = np.asarray(x, dtype=float)
        beta = np.diff(self.slopes) / np.diff(self.knots)
        alpha = self.slopes[:-1] - beta * self.knots[:-1]
        safe = np.where(x > 0, x, 1.0)[..., None]
        r = np.minimum(self.knots, safe)
        root = np.sqrt((safe - r) * (safe + r))
        angle = np.arctan2(r, root)  # arcsin(r/x), also to rounding where x lies just beyond a knot
        return x * np.sum(alpha * np.diff(angle, axis=-1) - beta * np.diff(root, axis=-1), axis=-1)


def tangent_minus_angle(u: Array) -> Array:
    """u - arctan(u) for u >= 0 [-], by u^3/3 - u^5/5 + ... where the difference would cancel."""
    u = np.asarray(u, dtype=float)
    orders = np.arange(SERIES_TERMS)
    square = np.minimum(u, SERIES_END) ** 2
    series = u**3 * np.polynomial.polynomial.polyval(square, (-1.0) ** orders / (2 * orders + 3))
    return np.where(u < SERIES_END, series, u - np.arctan(u))


def abel_factor(n: float) -> float:
    """c_n with Abel image of r^n = c_n x^n, n > 0: sqrt(pi) Gamma(n/2 + 1)/Gamma((n + 1)/2)."""
    z = (n + 1) / 2
    if z < GAMMA_END:
        return math.sqrt(math.pi) * math.gamma(z + 0.5) / math.gamma(z)
    terms = (1, -1 / 8, 1 / 128, 5 / 1024, -21 / 32768, -399 / 262144)
    return math.sqrt(math.pi * z) * sum(term / z**k for k, term in enumerate(terms))


def _check_table(r: Array, f: Array) -> None:
    if r.ndim != 1 or r.shape != f.shape or r.size < 3:
        raise InputError(f"profile table: needs at least 3 points (r, f), got {r.size} and {f.size}")
    if not (np.isfinite(r).all() and np.isfinite(f).all()):
        raise InputError("profile table: holds a value that is not finite")
    if r[0] != 0 or f[0] != 0:
        raise InputError(f"profile table: must start at r = 0, f = 0, got ({r[0]:g}, {f[0]:g})")
    if (np.diff(r) <= 0).any():
        i = int(np.argmax(np.diff(r) <= 0)) + 1
        raise InputError(f"profile table: radii must increase, point {i + 1} has r = {r[i]:g} after {r[i - 1]:g}")
    chord = np.diff(f) / np.diff(r)
    dips = np.diff(chord) < -1e-9 * max(float(np.max(np.abs(chord))), np.finfo(float).tiny)
    if chord[0] < 0 or dips.any():
        i = int(np.argmax(dips)) + 1 if chord[0] >= 0 else 0
        raise InputError(
            f"profile table: must be convex, the slope falls at point {i + 1} (r = {r[i]:g} m); "
            "JKR needs a contact disc that only grows: remove or smooth that point"
        )
    if f[-1] <= 0:
        raise InputError("profile table: is flat; a flat end needs a rounded edge")


def _schumaker(r: Array, f: Array) -> tuple[Array, Array]:
    """Knots and slopes of the convex C1 quadratic spline through (r, f); exact for parabolas."""
    h = np.diff(r)
    chord = np.diff(f) / h
    s = np.empty_like(r)
    s[1:-1] = (h[:-1] * chord[1:] + h[1:] * chord[:-1]) / (h[:-1] + h[1:])
    s[0] = max(2 * chord[0] - s[1], 0.0)
    s[-1] = 2 * chord[-1] - s[-2]
    _flatten_straight_runs(s, chord)
    knots: list[float] = [float(r[0])]
    slopes: list[float] = [float(s[0])]
    for i, width in enumerate(h):
        below, above = chord[i] - s[i], s[i + 1] - chord[i]
        if abs(above - below) > 1e-12 * (abs(s[i]) + abs(s[i + 1])):
            fraction = min(max(above / (above + below), KINK), 1 - KINK)
            knots.append(float(r[i] + width * fraction))
            slopes.append(float(chord[i]))
        knots.append(float(r[i + 1]))
        slopes.append(float(s[i + 1]))
    return np.array(knots), np.array(slopes)


def _flatten_straight_runs(s: Array, chord: Array) -> None:
    """Where one end slope equals the chord's, a convex profile is straight there: set the other end's, in place."""
    tiny = 1e-12 * float(np.max(chord))
    for i in range(chord.size):
        if s[i] >= chord[i] - tiny:
            s[i + 1] = chord[i]
    for i in reversed(range(chord.size)):
        if s[i + 1] <= chord[i] + tiny:
            s[i] = chord[i]

"""Profiles by points, measured or designed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from ...base.arrays import Array
from ...base.errors import InputError
from ...base.registry import Key
from ...base.units import AnyLength
from ..indenter import Indenter, shape
from ..materials import Elastic

MOST_POINTS = 5000  # choice: the cost grows with their square; so many take ten seconds
AT_ONCE = 1_000_000  # choice: pairs of a radius and a knot in memory
KINK = 1e-10  # choice: fraction of an interval over which a kink that the points force is rounded


@shape("table")
@dataclass(frozen=True)
class TableProfile(Indenter):
    """A measured or designed profile given by points (``r``, ``f``) [m], convex, from (0, 0) outwards.

    Between the points the profile is the convexity-preserving quadratic spline of Schumaker (1983), exact for a
    paraboloid; its Abel image is a sum of closed forms.
    """

    r: tuple[AnyLength, ...] = ()
    heights: Annotated[tuple[AnyLength, ...], Key("f")] = ()
    material: Elastic | None = None
    knots: Array = field(init=False, repr=False, compare=False)
    slopes: Array = field(init=False, repr=False, compare=False)
    values: Array = field(init=False, repr=False, compare=False)
    noun: ClassVar[str] = "tabulated profile"

    def __post_init__(self) -> None:
        r, f = np.asarray(self.r, dtype=float), np.asarray(self.heights, dtype=float)
        _check_table(r, f)
        knots, slopes = _schumaker(r, f)
        values = np.concatenate([[0.0], np.cumsum(np.diff(knots) * (slopes[1:] + slopes[:-1]) / 2)])
        for name, array in (("knots", knots), ("slopes", slopes), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

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

    @property
    def kinks(self) -> tuple[float, ...]:
        return tuple(self.knots[1:].tolist())

    @property
    def words(self) -> str:
        return f"profile of {len(self.r)} points"

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        i = np.clip(np.searchsorted(self.knots, r, side="right") - 1, 0, self.knots.size - 2)
        step = r - self.knots[i]
        inside = self.values[i] + step * (self.slopes[i] + self.slope(r)) / 2
        return np.where(r <= self.r_max * (1 + 1e-12), inside, np.inf)

    def slope(self, r: Array) -> Array:
        return np.interp(np.asarray(r, dtype=float), self.knots, self.slopes)

    def abel(self, x: Array) -> Array:
        """F(x): slope alpha + beta r on each piece gives x [alpha arcsin(r/x) - beta sqrt(x^2 - r^2)]."""
        x = np.asarray(x, dtype=float)
        angles, roots = self._sums(np.where(x > 0, x, 1.0))
        return x * (angles - roots)

    def abel_slope(self, x: Array) -> Array:
        angles, roots = self._sums(np.asarray(x, dtype=float))
        return angles - 2 * roots

    def _sums(self, x: Array) -> tuple[Array, Array]:
        """The sums over all pieces of alpha times the change of arcsin(r/x), and of beta times that of
        sqrt(x^2 - r^2) [m], r no larger than x; some x at a time, in little memory."""
        beta = np.diff(self.slopes) / np.diff(self.knots)
        alpha = self.slopes[:-1] - beta * self.knots[:-1]
        found = np.empty((2, x.size))
        step = max(AT_ONCE // self.knots.size, 1)
        for start in range(0, x.size, step):
            some = x.ravel()[start : start + step, None]
            r = np.minimum(self.knots[: np.searchsorted(self.knots, some.max()) + 1], some)
            root = np.sqrt((some - r) * (some + r))
            angle = np.arctan2(r, root)  # arcsin(r/x), also to rounding where x lies just beyond a knot
            pieces = slice(0, r.shape[1] - 1)
            found[:, start : start + step] = np.diff(angle) @ alpha[pieces], np.diff(root) @ beta[pieces]
        return found[0].reshape(x.shape), found[1].reshape(x.shape)


def _check_table(r: Array, f: Array) -> None:
    if r.size > MOST_POINTS:
        raise InputError(
            f"profile table: has {r.size:,} points, at most {MOST_POINTS:,} are taken; leave out points that lie "
            "nearly on the parabolas between their neighbours"
        )
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
    """Make intervals straight, in place, where one end slope equals the chord's: a convex profile is straight there."""
    tiny = 1e-12 * float(np.max(chord))
    for i in range(chord.size):
        if s[i] >= chord[i] - tiny:
            s[i + 1] = chord[i]
    for i in reversed(range(chord.size)):
        if s[i + 1] <= chord[i] + tiny:
            s[i] = chord[i]

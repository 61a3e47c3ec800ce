"""Piecewise cubics and quintics by values and derivatives at their knots, and bracketed zeros, with NumPy alone.

They agree with SciPy's, whose modules of splines and zeros take longer to be imported than most commands to run.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .arrays import Array

ROUNDING = float(np.finfo(float).eps)
HALVINGS = 200  # theory: two steps halve a bracket at least once; doubles hold no more


class PiecewisePolynomial:
    """Polynomials between increasing knots ``x`` (n,).

    ``c``: coefficients (degree + 1, n - 1, ...) of falling powers of the distance from the knot on the left. Beyond the
    knots the first and the last polynomial go on.
    """

    def __init__(self, x: Array, c: Array):
        self.x, self.c = x, c

    def __call__(self, x: Array, order: int = 0) -> Array:
        """Value (``order`` 0) or derivative of that order at ``x`` of any shape."""
        x = np.asarray(x, dtype=float)
        at = np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, self.x.size - 2)
        s = (x - self.x[at]).reshape(*x.shape, *[1] * (self.c.ndim - 2))
        degree, value = self.c.shape[0] - 1, np.zeros(())
        for i, c in enumerate(self.c[: degree + 1 - order]):
            value = value * s + math.perm(degree - i, order) * c[at]
        return value


class PiecewiseCubic(PiecewisePolynomial):
    """The cubics that have given values ``y`` and slopes ``dydx`` (n, ...) at increasing knots ``x`` (n,)."""

    def __init__(self, x: Array, y: Array, dydx: Array):
        h = np.diff(x).reshape(-1, *[1] * (y.ndim - 1))
        secant = np.diff(y, axis=0) / h
        bend = (dydx[:-1] + dydx[1:] - 2 * secant) / h
        super().__init__(x, np.stack([bend / h, (secant - dydx[:-1]) / h - bend, dydx[:-1], y[:-1]]))


class EvenCubic:
    """Cubic splines between equally spaced knots, ten times as fast as one that has to look for its pieces.

    ``first, step``: of the knots; ``c`` (4, ..., n - 1): coefficients of falling powers of the distance from the left.
    """

    def __init__(self, first: float, step: float, c: Array):
        self.first, self.step, self.c = first, step, np.ascontiguousarray(c)

    def __call__(self, x: Array) -> Array:
        """Values (..., *x.shape) at ``x`` of any shape, between the first and the last knot."""
        s = (x - self.first) / self.step
        at = np.minimum(s.astype(np.intp), self.c.shape[-1] - 1)
        s = (s - at) * self.step
        values = self.c[0].take(at, axis=-1)
        for c in self.c[1:]:
            values *= s
            values += c.take(at, axis=-1)
        return values


class PiecewiseQuintic(PiecewisePolynomial):
    """The quintics that have given values, slopes and second derivatives (n,) at increasing knots ``x`` (n,); between
    knots as ``close`` as that quartics, which leave small steps of the value: its error would be one of the slope."""

    def __init__(self, x: Array, y: Array, dydx: Array, bend: Array, close: float = 0.0):
        h = np.diff(x)
        b, half = h * dydx[:-1], h**2 * bend[:-1] / 2
        rise = np.diff(y) - b - half  # what the higher powers of s = distance/h make up at s = 1: value, slope, bend
        steep = h * dydx[1:] - b - 2 * half
        curved = h**2 * bend[1:] - 2 * half
        rise = np.where(h < close, steep / 2 - curved / 12, rise)
        c3, c4, c5 = (
            10 * rise - 4 * steep + curved / 2, -15 * rise + 7 * steep - curved, 6 * rise - 3 * steep + curved / 2
        )  # fmt: skip
        super().__init__(x, np.stack([c5 / h**5, c4 / h**4, c3 / h**3, half / h**2, dydx[:-1], y[:-1]]))


def spline_slopes(x: Array, y: Array) -> Array:
    """Slopes (n,) at its knots of the cubic spline through ``y`` (n,) at increasing ``x``, not-a-knot at both ends.

    Three points give a parabola, two a straight line.
    """
    h, secant = np.diff(x), np.diff(y) / np.diff(x)
    if x.size == 2:
        return np.repeat(secant, 2)
    ends = [_end(h, secant), _end(h[::-1], secant[::-1])]
    if x.size == 3:
        middle = np.array([(h[1] * secant[0] + h[0] * secant[1]) / (h[0] + h[1])])
    else:
        right = 3 * (h[1:] * secant[:-1] + h[:-1] * secant[1:])
        diagonal, below, above = 2 * (h[:-1] + h[1:]), h[1:].copy(), h[:-1].copy()
        # the end rows, h[1] s[0] + (h[0] + h[1]) s[1] = end and its mirror image, taken from the rows beside them
        diagonal[[0, -1]] = h[0] + h[1], h[-1] + h[-2]
        right[[0, -1]] -= ends
        middle = _tridiagonal(below, diagonal, above, right)
    first = (ends[0] - (h[0] + h[1]) * middle[0]) / h[1]
    last = (ends[1] - (h[-1] + h[-2]) * middle[-1]) / h[-2]
    return np.concatenate([[first], middle, [last]])


def _end(h: Array, secant: Array) -> float:
    """h[1] s[0] + (h[0] + h[1]) s[1] where the third derivative is continuous at the second knot."""
    both = h[0] + h[1]
    return float(((h[0] + 2 * both) * h[1] * secant[0] + h[0] ** 2 * secant[1]) / both)


def _tridiagonal(below: Array, diagonal: Array, above: Array, right: Array) -> Array:
    """Solution of a diagonally dominant system; entries (n,), ``below[0]`` and ``above[-1]`` unused. Plain floats: the
    recursion is sequential."""
    rows = zip(below.tolist(), diagonal.tolist(), above.tolist(), right.tolist(), strict=True)
    ratio = value = 0.0
    ratios, values = [], []
    for low, pivot, high, b in rows:
        pivot -= low * ratio
        ratio, value = high / pivot, (b - low * value) / pivot
        ratios.append(ratio)
        values.append(value)
    for i in range(len(values) - 2, -1, -1):
        values[i] -= ratios[i] * values[i + 1]
    return np.array(values)


def zeros_between(function: Callable[[Array], Array], low: Array, high: Array, tolerance: float) -> Array:
    """The zeros of ``function`` (elementwise), one in each bracket from ``low`` to ``high`` (n,), at whose ends its
    signs differ or it vanishes; to ``tolerance``, or to rounding, each as if it were sought alone.

    Chandrupatla (1997): inverse quadratic interpolation where three points allow it, else halves.
    """
    x1, x2 = np.array(low, dtype=float), np.array(high, dtype=float)
    f1, f2 = function(x1), function(x2)
    part = np.full_like(x1, 0.5)
    for _ in range(HALVINGS):
        best = np.where(np.abs(f1) < np.abs(f2), x1, x2)
        least = (tolerance + 2 * ROUNDING * np.abs(best)) / np.maximum(np.abs(x2 - x1), np.finfo(float).tiny)
        settled = (least > 0.5) | (f1 == 0) | (f2 == 0)
        if settled.all():
            break
        x = np.where(settled, x1, x1 + np.clip(part, np.minimum(least, 0.5), np.maximum(1 - least, 0.5)) * (x2 - x1))
        f = function(x)
        same = settled | (np.sign(f) == np.sign(f1))
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, f
        part = _next_part(x1, x2, x3, f1, f2, f3)
    return best


def _next_part(x1: Array, x2: Array, x3: Array, f1: Array, f2: Array, f3: Array) -> Array:
    """Where to look next between x1 (0) and x2 (1): by inverse quadratic interpolation where it is monotone."""
    with np.errstate(all="ignore"):
        place, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        monotone = (height**2 < place) & ((1 - height) ** 2 < 1 - place)
        inverse = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
    return np.where(monotone & np.isfinite(inverse), inverse, 0.5)

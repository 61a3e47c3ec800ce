"""Arrays, piecewise polynomials, quadrature, iteration and Fisher's distribution, of all rooms."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from statistics import NormalDist
from typing import Any, TypeAlias

import numpy as np

from . import process
from .errors import LEVEL
from .units import shortly

if process.runs():  # SciPy copies every name of NumPy; these two load a compiler's front end and unittest, 70 ms
    vars(np).update({name: vars(np).get(name) for name in ("f2py", "testing")})

Array: TypeAlias = np.ndarray[Any, np.dtype[Any]]


def numbers_of(values: Any) -> Array:
    """The numbers of a list, array or series, (n,), as a copy; nan where one is masked or missing. ValueError with a
    sentence where they are none."""
    try:
        if hasattr(values, "to_numpy"):
            values = values.to_numpy(dtype=float, na_value=math.nan)
        numbers = np.ma.array(values)
        if numbers.dtype.kind in "USMmc":
            raise TypeError
        filled = np.ma.filled(numbers.astype(float), math.nan)
    except (TypeError, ValueError, AttributeError):
        raise ValueError(f"must be a list of numbers, got {shortly(values)}") from None
    if filled.ndim != 1:
        raise ValueError(f"must be one-dimensional, got shape {filled.shape}")
    return np.array(filled)


def evenly(rows: int, most: int) -> Array:
    """The numbers of at most ``most`` of so many ``rows``, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, rows - 1, min(rows, most)).astype(int))


# --------------------------------------------------------------------------------------------------
# Numbers that many algorithms share: guards of iterations and divisions, sizes of work, what counts as the same.
#
# No result depends on the guards and sizes, nor, beyond its stated error, on what counts as the same.

MOST_STEPS = 100  # choice: guard of loops that converge, or end by themselves, in ten or twenty
MOST_SOLVES = 8  # choice: guard of loops whose every step is a solve; two or three are needed
MOST_CELLS = 100_000_000  # choice: numbers of a table that is read or written, 800 MB
AT_ONCE = 1_000_000  # choice: numbers of one array on the way to a result; 8 MB, and some such arrays
LOOKED_AT = 400  # choice: points of a curve as it is drawn, or among which a zero or the largest value is sought
DRAWN = 4000  # choice: points of curves that a picture tells apart
# choice: of a direction of a record, a base line and a contact of a few rows each; so many steps beside a jump too
FEWEST_ROWS = 20
ROWS = 200  # choice: default number of rows of a curve
TOGETHER = 20  # choice: items of one kind that are computed side by side, or make one task of another process
SHOWN = 20  # choice: names or rows in a message
SAME = 1e-6  # choice: relative difference of two values that are one: above round-off, below what anyone measures
ROUNDED = 1e-9  # theory: relative, above what a sum of a million numbers loses to round-off, 1e6 epsilon = 2e-10
RESIDUAL_LIMIT = 1e-6  # theory: of check solves; a sound factor leaves round-off, 1e-16 to 1e-12, a wrong one 1
UNSEEN = 1e-4  # choice: relative error that no measurement sees
NO_CLAIM = 1e-3  # of a tolerance, no smaller error is stated; tuned on work along a record, by `make constants`
SETTLED = 1e-13  # theory: a step of logs or of unknowns near 1 that is none: 450 machine epsilons, above round-off
TINY = sys.float_info.min  # theory: the least normal number, below every size that something is divided by


def half_width(level: float) -> float:
    """Half-width of an interval that holds a normal value with the probability ``level``, in standard deviations."""
    return NormalDist().inv_cdf((1 + level) / 2)


HALF_WIDTH = half_width(LEVEL)


def median(x: Array) -> float:
    """The median of finite numbers, in a quarter of the time that np.median takes for a thousand; nan of none."""
    half = x.size // 2
    if not half:
        return float(x.sum()) if x.size else math.nan
    ordered = np.partition(x, half, axis=None)  # by one place, which takes half the time of two
    return float(ordered[half]) if x.size % 2 else float(ordered[:half].max() + ordered[half]) / 2


# --------------------------------------------------------------------------------------------------
# Gauss quadrature on the intervals between given edges.

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)  # theory: exact for polynomials of degree 15 on an interval


def composite_gauss(edges: Array) -> tuple[Array, Array]:
    """Nodes and weights on the intervals between ``edges``, (intervals, nodes) both."""
    half = np.diff(edges)[:, None] / 2
    return edges[:-1, None] + half * (1 + NODES), half * WEIGHTS


# --------------------------------------------------------------------------------------------------
# Piecewise cubics and quintics by values and derivatives at their knots, and bracketed zeros, with NumPy alone.
#
# They agree with SciPy's, whose modules of splines and zeros take longer to be imported than most commands to run.

ROUNDING = float(np.finfo(float).eps)
HALVINGS = 200  # theory: two steps halve a bracket at least once; doubles hold no more


class PiecewisePolynomial:
    """Polynomials between increasing knots ``x`` (n,).

    ``c``: coefficients (degree + 1, n - 1, ...) of falling powers of the distance from the knot on the left. Beyond the
    knots the first and the last polynomial go on.
    """

    def __init__(self, x: Array, c: Array):
        self.x, self.c = x, c
        self._derivatives = dict[int, PiecewisePolynomial]()

    def __call__(self, x: Array, order: int = 0) -> Array:
        """Value (``order`` 0) or derivative of that order at ``x`` of any shape."""
        x = np.asarray(x, dtype=float)
        at = np.searchsorted(self.x[1:-1], x, side="right")
        s = (x - self.x.take(at)).reshape((*x.shape, *[1] * (self.c.ndim - 2)))
        highest, *others = self.derivative(order).c if order else self.c
        value = highest.take(at, axis=0)
        for c in others:
            value *= s
            value += c.take(at, axis=0)
        return value

    def derivative(self, order: int) -> PiecewisePolynomial:
        """Its derivative of an ``order`` up to its degree."""
        if order not in self._derivatives:
            degree = len(self.c) - 1
            factors = np.array([math.perm(degree - i, order) for i in range(degree + 1 - order)])
            self._derivatives[order] = PiecewisePolynomial(self.x, (factors * self.c[: factors.size].T).T)
        return self._derivatives[order]


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
    """Slopes (n, ...) at its knots of the cubic splines through ``y`` (n, ...) at increasing ``x``, not-a-knot at both
    ends.

    Three points give a parabola, two a straight line.
    """
    if y.ndim > 1:
        return np.stack([spline_slopes(x, one) for one in y.reshape(len(y), -1).T], axis=1).reshape(y.shape)
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


def cubic_spline(x: Array, y: Array) -> PiecewiseCubic:
    """The cubic splines through ``y`` (n, ...) at increasing ``x``, not-a-knot at both ends: SciPy's, whose import
    takes longer than most of what is computed with it."""
    return PiecewiseCubic(x, y, spline_slopes(x, y))


def pchip(x: Array, y: Array) -> PiecewiseCubic:
    """The cubics through ``y`` (n,) at increasing ``x`` that rise and fall where the points do, and no further: at a
    knot the harmonic mean of the secants beside it, weighted by the lengths (Fritsch and Butland, SIAM J. Sci. Stat.
    Comput. 5 (1984) 300), 0 where they differ in sign."""
    h, secant = np.diff(x), np.diff(y) / np.diff(x)
    if x.size == 2:
        return PiecewiseCubic(x, y, np.repeat(secant, 2))

    # (w1 + w2)/d = w1/s1 + w2/s2 between the secants s1, s2, with w1 = 2 h2 + h1 and w2 = h2 + 2 h1
    left, right, rises = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1], secant[:-1] * secant[1:] > 0
    s1, s2 = np.where(rises, secant[:-1], 1.0), np.where(rises, secant[1:], 1.0)
    middle = np.where(rises, (left + right) / (left / s1 + right / s2), 0.0)

    def end(h1: float, h2: float, s1: float, s2: float) -> float:
        """The slope of the parabola through three points at the first, as far as it goes the way of the secants."""
        slope = ((2 * h1 + h2) * s1 - h1 * s2) / (h1 + h2)
        if slope * s1 <= 0:
            return 0.0
        return 3 * s1 if s1 * s2 <= 0 and abs(slope) > abs(3 * s1) else slope

    first, last = end(*h[:2], *secant[:2]), end(*h[:-3:-1], *secant[:-3:-1])
    return PiecewiseCubic(x, y, np.concatenate([[first], middle, [last]]))


def rising_slopes(x: Array, y: Array, slopes: Array) -> Array:
    """The ``slopes`` at the points, none below 0 or larger than three times the chord on either side, where ``y`` rises
    there: others make a cubic fall in between (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238)."""
    chord = np.diff(y) / np.diff(x)
    most = 3 * np.minimum(np.append(chord[0], chord), np.append(chord, chord[-1]))
    return np.where(most > 0, np.clip(slopes, 0.0, np.maximum(most, 0.0)), slopes)


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
    if not x1.size:
        return x1
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
        # Where to look next between x1 (0) and x2 (1): by inverse quadratic interpolation where it is monotone.
        with np.errstate(all="ignore"):
            place, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            monotone = (height**2 < place) & ((1 - height) ** 2 < 1 - place)
            inverse = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        part = np.where(monotone & np.isfinite(inverse), inverse, 0.5)
    return best


# --------------------------------------------------------------------------------------------------
# Fisher's distribution of F: as SciPy's, whose import takes longer than a fit.


BETA_TERMS = 10_000  # choice: guard; some sqrt(dof) terms are needed


def _fisher(k: float, dof: float, F: float) -> tuple[float, float]:
    """The chance I_x(dof/2, k/2) that F of ``k`` and ``dof`` degrees of freedom is larger, x = dof/(dof + k F), and F
    times its density, x^a (1 - x)^b/B(a, b)."""
    if not (F >= 0 and 0 < dof < math.inf):
        return math.nan, math.nan
    a, b, x, y = dof / 2, k / 2, 1 / (1 + k * F / dof), (1 / (1 + dof / (k * F)) if F else 0.0)
    if not x or not y:
        return float(not y), 0.0
    density = math.exp(a * math.log(x) + b * math.log(y) - math.lgamma(a) - math.lgamma(b) + math.lgamma(a + b))

    # the continued fraction of the incomplete beta function (DLMF 8.17.22), of 1 - x where that converges faster, by
    # the quotients c, d of successive numerators and denominators (Lentz, Appl. Opt. 15 (1976) 668)
    upper = x > (a + 1) / (a + b + 2)
    p, q, z = (b, a, y) if upper else (a, b, x)
    c, d = 1.0, 1 / (1 - (p + q) / (p + 1) * z)
    fraction = before = d
    for m in range(1, BETA_TERMS):
        for term in (
            m * (q - m) / ((p + 2 * m - 1) * (p + 2 * m)), -(p + m) * (p + q + m) / ((p + 2 * m) * (p + 2 * m + 1))
        ):  # fmt: skip
            d, c = 1 / (1 + term * z * d), 1 + term * z / c
            fraction *= c * d
        if abs(fraction - before) <= ROUNDING * abs(fraction):
            break
        before = fraction
    chance = density * fraction / p
    return (1 - chance if upper else chance), density


def f_chance(k: float, dof: float, F: float) -> float:
    """The chance that F of ``k`` and ``dof`` degrees of freedom is above ``F`` >= 0; nan of nan."""
    return _fisher(k, dof, F)[0]


def f_tail(k: float, dof: float | Array, F: float | Array) -> Array:
    """The chances that F of ``k`` and ``dof`` degrees of freedom is above ``F`` >= 0, of any shape; nan of nan."""
    with np.errstate(all="ignore"):
        return np.vectorize(f_chance, otypes=[float])(k, dof, F)


def f_quantile(k: float, dof: float, level: float) -> float:
    """The F of ``k`` and ``dof`` degrees of freedom below which a share ``level`` of it lies; for k = 1 the square of
    half the two-sided interval of Student's t."""
    ln_F = 0.0
    for _ in range(MOST_STEPS):  # of Newton's for the log of the tail over that of F
        tail, density = _fisher(k, dof, math.exp(ln_F))
        step = min(max(tail / density * math.log(tail / (1 - level)), -1.0), 1.0)
        ln_F += step
        if abs(step) < SETTLED:
            break
    return math.exp(ln_F)

"""From a nonadhesive series to the adhesive curve (Eq. 13), and everything that is read off that curve.

delta(a) = delta_H(a) - t(a)      P(a) = P_H(a) - S(a) t(a)      t = sqrt(4 pi w a/S')
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, TypeVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import brentq

from ..base.arrays import Array
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..series import Series
from .slopes.result import Slopes

SAMPLES = 8  # per interval, where critical points are looked for
FEWEST, FEW = 5, 10  # points for an interpolation error, and for one that is known to fall with the spacing
WIDEST = 2.7  # ratio of neighbouring a - a0 up to which it can be told
ORDER_FACTOR = 8  # by which half the spacing reduces it, at least
ROUND_OFF = 1e-9  # radii may leave the series by this fraction


Columns = TypeVar("Columns", Series, Slopes)


@dataclass(frozen=True)
class CriticalPoint:
    """Where the controlled quantity is stationary along the curve: ``a`` [m], ``delta`` [m], ``P`` [N].

    ``kind``: "minimum" is where contact is lost on retraction, "maximum" bounds a stable branch on the other side.
    """

    a: float
    delta: float
    P: float
    kind: Literal["minimum", "maximum"] = "minimum"


@dataclass(frozen=True, eq=False)
class AdhesiveCurve:
    """The adhesive curve at the radii of ``series`` for work of adhesion ``w`` [J/m^2]: ``delta`` [m], ``P`` [N], (n,).

    ``errors``: 90 % half-widths of "delta" [m] and "P" [N] at given radius; empty where no error is known.
    """

    series: Series
    slopes: Slopes
    w: float
    delta: Array
    P: Array
    errors: Mapping[str, Array] = field(default_factory=dict)

    @cached_property
    def rule(self) -> Rule:
        """How the curve is evaluated between its points."""
        return Rule.through(self.series, self.slopes, self.w)

    @property
    def a(self) -> Array:
        """Contact radii of the series [m]."""
        return self.series.a

    def at(self, a: Array) -> tuple[Array, Array]:
        """delta [m] and P [N] at any contact radius within the series, by the curve's one evaluation rule."""
        return self.rule.point(self._inside(a))

    def rates(self, a: Array) -> tuple[Array, Array]:
        """d(delta)/da [-] and dP/da [N/m] at any contact radius within the series."""
        return self.rule.rates(self._inside(a))

    def error_at(self, a: Array) -> dict[str, Array]:
        """The half-widths of ``errors`` at any contact radius within the series (linear between points)."""
        inside = self._inside(a)
        return {name: np.interp(inside, self.a, values) for name, values in self.errors.items()}

    @cached_property
    def interpolation_error(self) -> Estimate:
        """Relative error of delta and P between the points: their change where every second point is left out, over 8.

        The units are the values themselves, or the lowest of the curve where that is larger. The rule is of fourth
        order in the spacing (16), of third where its splines end: 8; of few points nothing of the kind is assumed.
        Slopes with noise add theirs.
        """
        if len(self.series) < FEWEST:
            return Unknown(f"unknown: fewer than {FEWEST} points")
        beyond = self.a - self.series.a0
        if np.max(beyond[1:] / beyond[:-1]) > WIDEST:
            return Unknown(f"unknown: neighbouring radii differ by more than a factor of {WIDEST:g}")
        change = max(self._change_without(first) for first in (1, 2))
        return change if len(self.series) < FEW else change / ORDER_FACTOR

    def _change_without(self, first: int) -> float:
        """Largest relative change of delta and P at every second inner point from ``first`` on, left out."""
        rows = np.arange(len(self.series))
        left_out = rows[first:-1:2]
        kept = np.setdiff1d(rows, left_out)
        rule = Rule.through(_at(self.series, kept), _at(self.slopes, kept), self.w)
        changes = []
        for ours, there in zip((self.delta, self.P), rule.point(self.a[left_out]), strict=True):
            unit = np.maximum(np.abs(ours[left_out]), abs(np.min(ours)))
            changes.append(np.max(np.abs(there - ours[left_out]) / unit))
        return float(max(changes))

    def critical(self, stiffness: float) -> tuple[CriticalPoint, ...]:
        """All points in the series where d(delta + P/stiffness)/da = 0, by increasing radius; there may be none.

        ``stiffness`` [N/m] of the device: 0 is load control (dP/da = 0), infinity displacement control.
        """
        control = _control(stiffness)
        points = []
        for a, rising in self.zeros(lambda a: control(*self.rule.rates(a))):
            delta, P = (float(value) for value in self.at(np.array(a)))
            points.append(CriticalPoint(a, delta, P, "minimum" if rising else "maximum"))
        return tuple(points)

    def radii(self, *, P: float | None = None, delta: float | None = None) -> tuple[float, ...]:
        """All contact radii [m] in the series at which the load is ``P`` [N], or the displacement ``delta`` [m]."""
        if (P is None) == (delta is None):
            raise InputError("adhesive curve: give either P or delta to look for")
        index, value = (0, delta) if P is None else (1, P)
        return tuple(a for a, _ in self.zeros(lambda a: self.rule.point(a)[index] - value))

    def zeros(self, function: Callable[[Array], Array]) -> Iterator[tuple[float, bool]]:
        """Radii in the series where ``function`` of the radius [m] vanishes, increasing, and whether it rises there."""

        def along(x: Array) -> Array:
            return function(np.clip(np.exp(x), self.a[0], self.a[-1]))

        x = self._samples()
        signs = np.sign(along(x))
        for i in np.flatnonzero(signs[:-1] * signs[1:] <= 0):
            if signs[i + 1] == 0 and i + 2 < signs.size:
                continue  # taken by the next pair
            a = math.exp(brentq(along, x[i], x[i + 1], xtol=1e-14, rtol=1e-14))
            yield min(max(a, self.a[0]), self.a[-1]), bool(signs[i + 1] > signs[i])

    def pull_off(self, stiffness: float) -> CriticalPoint | Unknown:
        """The last stable point on retraction; ``stiffness`` [N/m] as in ``critical`` (0: load control).

        Where the curve has several minima, the lowest: at the others contact shrinks to a smaller stable radius.
        Unknown, with numbers and the remedy, where it does not lie in the series.
        """
        control = _control(stiffness)
        minima = [point for point in self.critical(stiffness) if point.kind == "minimum"]
        ends = {"smallest": self.a[0], "largest": self.a[-1]}
        lowest = min(ends, key=lambda end: control(*self.at(ends[end])))
        best = min(minima, key=lambda point: control(point.delta, point.P), default=None)
        if best is None or control(best.delta, best.P) > control(*self.at(ends[lowest])):
            return Unknown(self._outside_reason(stiffness, lowest, float(ends[lowest])))
        return best

    def _outside_reason(self, stiffness: float, end: str, a: float) -> str:
        delta, P = (float(value) for value in self.at(np.array(a)))
        quantity = {0.0: "load", math.inf: "displacement"}.get(stiffness, "device position")
        remedy = (
            'ask for smaller radii: loading.spacing = "log", by fem a smaller mesh.smallest '
            "(or contact shrinks to a point before it is lost)"
            if end == "smallest"
            else "the series would have to reach a larger radius: load further"
        )
        return (
            f"the {quantity} is lowest at the {end} radius of the series, a = {show(a, 'length')} "
            f"(P = {show(P, 'load')}, delta = {show(delta, 'length')}): pull-off lies outside it; {remedy}"
        )

    def _inside(self, a: Array) -> Array:
        a = np.asarray(a, dtype=float)
        low, high = self.a[0], self.a[-1]
        outside = (a < low * (1 - ROUND_OFF)) | (a > high * (1 + ROUND_OFF)) | ~np.isfinite(a)
        if outside.any():
            raise InputError(
                f"adhesive curve: contact radius {np.atleast_1d(a)[np.atleast_1d(outside)][0]:g} m lies outside the "
                f"series, {low:g} to {high:g} m"
            )
        return np.clip(a, low, high)

    def _samples(self) -> Array:
        x = np.log(self.a)
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(SAMPLES) / SAMPLES
        return np.append(inner.ravel(), x[-1])


@dataclass(frozen=True, eq=False)
class Rule:
    """The evaluation rule: cubic Hermite in the log of the radius of log delta_H, log P_H, log S and log t.

    The slope of log P_H comes from dP_H = S d(delta_H), that of log S is a S'/S; those of log delta_H and log S' are
    of a not-a-knot spline through the points. Power laws (Hertz) are exact with any number of points. delta_H and P_H
    vanish at the first contact radius a0: their logs are taken over log(a - a0).
    """

    a0: float
    delta_H: CubicHermiteSpline
    P_H: CubicHermiteSpline
    S: CubicHermiteSpline
    t: CubicHermiteSpline
    root_w: float

    @classmethod
    def through(cls, series: Series, slopes: Slopes, w: float) -> Rule:
        if len(series) < 2:
            raise InputError("adhesive curve: a series of one point has no values between points")
        delta, P = _columns(series, slopes, w)
        x, z = np.log(series.a), np.log(series.a - series.a0)
        y_delta, y_P, y_S, y_dS = (np.log(values) for values in (delta, P, slopes.S, slopes.dS))
        rate_delta = CubicSpline(z, y_delta)(z, 1)
        rate_dS = CubicSpline(x, y_dS)(x, 1)
        return cls(
            series.a0,
            CubicHermiteSpline(z, y_delta, rate_delta),
            CubicHermiteSpline(z, y_P, slopes.S * delta / P * rate_delta),
            CubicHermiteSpline(x, y_S, series.a * slopes.dS / slopes.S),
            CubicHermiteSpline(x, (math.log(4 * math.pi) + x - y_dS) / 2, (1 - rate_dS) / 2),
            math.sqrt(w),
        )

    def point(self, a: Array) -> tuple[Array, Array]:
        x, z = np.log(a), np.log(a - self.a0)
        t = self.root_w * np.exp(self.t(x))
        return np.exp(self.delta_H(z)) - t, np.exp(self.P_H(z)) - np.exp(self.S(x)) * t

    def rates(self, a: Array) -> tuple[Array, Array]:
        x, z = np.log(a), np.log(a - self.a0)
        t, S = self.root_w * np.exp(self.t(x)), np.exp(self.S(x))
        dt = t * self.t(x, 1) / a
        ddelta = np.exp(self.delta_H(z)) * self.delta_H(z, 1) / (a - self.a0)
        dP = np.exp(self.P_H(z)) * self.P_H(z, 1) / (a - self.a0)
        return ddelta - dt, dP - S * dt - S * self.S(x, 1) / a * t


def _at(columns: Columns, rows: Array) -> Columns:
    """The series or slopes at the points ``rows`` alone, without errors."""
    names = ("a", "delta", "P", "S", "dS")
    values = {name: getattr(columns, name)[rows] for name in names if getattr(columns, name, None) is not None}
    blank: dict[str, Any] = {"errors": {}} if isinstance(columns, Series) else {"covariance": None, "joint": None}
    return replace(columns, **values, **blank)


def thinned(curve: AdhesiveCurve, first: int) -> AdhesiveCurve:
    """The curve through every second point of its series from ``first`` on."""
    rows = np.arange(first, len(curve.series), 2)
    return transform(_at(curve.series, rows), _at(curve.slopes, rows), curve.w)


def transform(series: Series, slopes: Slopes, w: float) -> AdhesiveCurve:
    """The adhesive curve of ``series`` for the work of adhesion ``w`` >= 0 [J/m^2] (Eq. 13).

    Refused where S or S' is not positive. w = 0 returns the nonadhesive columns unchanged.
    """
    if not (math.isfinite(w) and w >= 0):
        raise InputError(f"w: must be >= 0 J/m^2, got {w:g}")
    bad = ~((slopes.dS > 0) & (slopes.S > 0))
    if bad.any():
        raise InputError(
            f"slopes: S or dS/da is not positive at {int(bad.sum())} radii, first at a = {series.a[bad][0]:.4g} m: "
            "Eq. 13 has no solution there; leave those points out or take other slopes"
        )
    delta_H, P_H = _columns(series, slopes, w)
    t = np.sqrt(4 * math.pi * w * series.a / slopes.dS)
    return AdhesiveCurve(series, slopes, w, delta_H - t, P_H - slopes.S * t, _band(slopes, t))


def _columns(series: Series, slopes: Slopes, w: float) -> tuple[Array, Array]:
    """delta_H and P_H: those of the slopes' own fit where it has them, the series' own at w = 0."""
    if w == 0 or slopes.delta is None or slopes.P is None:
        return series.delta, series.P
    return slopes.delta, slopes.P


def _band(slopes: Slopes, t: Array) -> dict[str, Array]:
    """First-order propagation of the covariance of (delta_H, P_H, S, S') to delta and P: 90 % half-widths."""
    if slopes.covariance is None:
        return {}
    zero, one = np.zeros_like(t), np.ones_like(t)
    by_dS = t / (2 * slopes.dS)
    gradients = {
        "delta": np.stack([one, zero, zero, by_dS], axis=1),
        "P": np.stack([zero, one, -t, slopes.S * by_dS], axis=1),
    }
    return {
        name: slopes.quantile * np.sqrt(np.einsum("ni,nij,nj->n", gradient, slopes.covariance, gradient))
        for name, gradient in gradients.items()
    }


def _control(stiffness: float) -> Callable[[Any, Any], Any]:
    """What a device of ``stiffness`` [N/m] controls, of delta and P: P itself (0), else delta + P/stiffness."""
    if math.isnan(stiffness) or stiffness < 0:
        raise InputError(f"stiffness: must be >= 0 N/m (0: load control, infinite: displacement), got {stiffness:g}")
    if stiffness == 0:
        return lambda delta, P: P
    return lambda delta, P: delta + P / stiffness


def scales_half_space(R: float, E_star: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a half-space (Eq. 15 corrected)."""
    P = math.pi * w * R
    delta = (9 * math.pi**2 * w**2 * R / (16 * E_star**2)) ** (1 / 3)
    a = (3 * math.pi * w * R**2 / (4 * E_star)) ** (1 / 3)
    return P, delta, a


def scales_thin_layer(R: float, K: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a thin layer of Winkler stiffness K [Pa/m] (Eq. 19 corrected)."""
    return 2 * math.pi * w * R, math.sqrt(2 * w / K), (8 * w * R**2 / K) ** 0.25

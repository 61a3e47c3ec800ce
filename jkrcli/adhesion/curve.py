"""From a nonadhesive series to the adhesive curve of any work of adhesion, and what is read off that curve.

delta(a) = delta_H(a) - sqrt(w) t(a)      P(a) = P_H(a) - sqrt(w) S(a) t(a)      t = sqrt(4 pi a/S')      (Eq. 13)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import brentq

from ..base.arrays import Array
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..formulas.griffith import shift
from ..series import Series
from .device import CONTROLS, DISPLACEMENT_CONTROL, LOAD_CONTROL, position
from .slopes.result import Slopes

NO_ADHESION = Unknown("there is no adhesion at w = 0")
Columns = TypeVar("Columns", Series, Slopes)


@dataclass(frozen=True)
class CurveTuning:
    """How a curve is searched, and when the error of its interpolation can be told."""

    samples: int = 8  # choice: per interval, where zeros are looked for; two of them between two samples are missed
    fewest: int = 5  # theory: every second of fewer points leaves no cubic
    few: int = 10  # points from which the error falls with the spacing; tuned on noisy series, by `make tuning`
    widest: float = 2.7  # ratio of neighbouring a - a0 up to which it does; tuned on the same, by `make tuning`
    order_factor: float = 8.0  # theory: halving the spacing divides an error of third order by it, at least
    end: float = 1e-9  # choice: fraction by which a radius may leave the series, for round-off of units


TUNING = CurveTuning()


@dataclass(frozen=True)
class Equilibrium:
    """One state of adhesive contact: contact radius ``a`` [m], displacement ``delta`` [m], load ``P`` [N]."""

    a: float
    delta: float
    P: float


@dataclass(frozen=True)
class CriticalPoint(Equilibrium):
    """An equilibrium where the controlled quantity is stationary along the curve.

    ``kind``: "minimum" is where contact is lost on retraction, "maximum" bounds a stable branch on the other side.
    """

    kind: Literal["minimum", "maximum"] = "minimum"


class Parts(NamedTuple):
    """Values of the w-free functions at some radii, or their derivatives; ``t``: the shift at w = 1 J/m^2."""

    delta_H: Array
    P_H: Array
    S: Array
    dS: Array
    t: Array


@dataclass(frozen=True, eq=False)
class Nonadhesive:
    """The w-free functions delta_H, P_H, S, S' and shift t of a series: all that its adhesive curves are made of.

    delta_H and P_H are those of the slopes' own fit where it has them. Between the points: cubic Hermite in the log of
    the radius of their logs. The slope of log P_H comes from dP_H = S d(delta_H), that of log S is a S'/S; those of
    log delta_H and log S' are of a not-a-knot spline through the points. Power laws (Hertz) are exact with any number
    of points. delta_H and P_H vanish at the first contact radius a0: their logs are taken over log(a - a0).
    Refused where S or S' is not positive.
    """

    series: Series
    slopes: Slopes

    def __post_init__(self) -> None:
        bad = ~((self.slopes.dS > 0) & (self.slopes.S > 0))
        if bad.any():
            raise InputError(
                f"slopes: S or dS/da is not positive at {int(bad.sum())} radii, first at a = {self.a[bad][0]:.4g} m: "
                "Eq. 13 has no solution there; leave those points out or take other slopes"
            )

    def scaled(self, factor: float) -> Nonadhesive:
        """The functions of the same bodies with all moduli multiplied by ``factor``."""
        return self if factor == 1 else Nonadhesive(self.series.scaled(factor), self.slopes.scaled(factor))

    def adhesive(self, w: float) -> AdhesiveCurve:
        """The curve for the work of adhesion ``w`` >= 0 [J/m^2]."""
        return AdhesiveCurve(self, w)

    @property
    def a(self) -> Array:
        """Contact radii of the series [m]."""
        return self.series.a

    @cached_property
    def points(self) -> Parts:
        """The functions at the radii of the series, as the slopes' method gives them."""
        series, slopes = self.series, self.slopes
        delta_H = series.delta if slopes.delta is None else slopes.delta
        P_H = series.P if slopes.P is None else slopes.P
        return Parts(delta_H, P_H, slopes.S, slopes.dS, shift(1.0, self.a, slopes.dS))

    def parts(self, a: Array) -> Parts:
        """delta_H [m], P_H [N], S [N/m], S' [N/m^2], t [m] at radii within the series, by one evaluation rule."""
        columns, slopes = self._logs
        delta_H, P_H = np.exp(np.moveaxis(columns(np.log(a - self.series.a0)), -1, 0))
        S, dS = np.exp(np.moveaxis(slopes(np.log(a)), -1, 0))
        return Parts(delta_H, P_H, S, dS, shift(1.0, a, dS))

    def rates(self, a: Array) -> Parts:
        """The derivatives of ``parts`` by the radius: ``rates(a).dS`` is S''."""
        return self.with_rates(a)[1]

    def with_rates(self, a: Array) -> tuple[Parts, Parts]:
        """``parts`` and ``rates`` at once."""
        here, beyond = self.parts(a), a - self.series.a0
        columns, slopes = self._logs
        by_delta, by_P = np.moveaxis(columns(np.log(beyond), 1), -1, 0) / beyond
        by_S, by_dS = np.moveaxis(slopes(np.log(a), 1), -1, 0) / a
        by_t = (1 / a - by_dS) / 2
        return here, Parts(here.delta_H * by_delta, here.P_H * by_P, here.S * by_S, here.dS * by_dS, here.t * by_t)

    def between(self, values: Array, a: Array) -> Array:
        """``values`` (n, ...) at the radii of the series, linear between them at the radii ``a``."""
        columns = values.reshape(len(self.series), -1).T
        there = np.stack([np.interp(a, self.a, column) for column in columns], axis=-1)
        return there.reshape(*np.shape(a), *values.shape[1:])

    @property
    def gradients(self) -> dict[str, tuple[Array, Array]]:
        """Gradients of "delta" and "P" at the series' radii by (delta_H, P_H, S, S'), (n, 4): without adhesion, what
        is added per root of w."""
        _, _, S, dS, t = self.points
        zero, one, by_dS = np.zeros_like(t), np.ones_like(t), t / (2 * dS)
        by_columns = {"delta": (one, zero, zero, zero), "P": (zero, one, zero, zero)}
        by_root_w = {"delta": (zero, zero, zero, by_dS), "P": (zero, zero, -t, S * by_dS)}
        return {name: (np.stack(by_columns[name], 1), np.stack(by_root_w[name], 1)) for name in ("delta", "P")}

    def at_rows(self, rows: Array) -> Nonadhesive:
        """The functions through the points ``rows`` alone, without errors."""
        return Nonadhesive(_at(self.series, rows), _at(self.slopes, rows))

    @cached_property
    def _logs(self) -> tuple[CubicHermiteSpline, CubicHermiteSpline]:
        """Log of (delta_H, P_H) over log(a - a0), log of (S, S') over log a."""
        if len(self.series) < 2:
            raise InputError("adhesive curve: a series of one point has no values between points")
        delta, P, S, dS, _ = self.points
        x, z = np.log(self.a), np.log(self.a - self.series.a0)
        rate = CubicSpline(z, np.log(delta))(z, 1)
        rate_dS = CubicSpline(x, np.log(dS))(x, 1)
        return (
            CubicHermiteSpline(z, np.log(np.stack([delta, P], 1)), np.stack([rate, S * delta / P * rate], 1)),
            CubicHermiteSpline(x, np.log(np.stack([S, dS], 1)), np.stack([self.a * dS / S, rate_dS], 1)),
        )


def _at(columns: Columns, rows: Array) -> Columns:
    """The series or slopes at the points ``rows`` alone, without errors."""
    names = ("a", "delta", "P", "S", "dS")
    values = {name: getattr(columns, name)[rows] for name in names if getattr(columns, name, None) is not None}
    blank: dict[str, Any] = {"errors": {}} if isinstance(columns, Series) else {"covariance": None, "joint": None}
    return replace(columns, **values, **blank)


def transform(series: Series, slopes: Slopes, w: float) -> AdhesiveCurve:
    """The adhesive curve of ``series`` for the work of adhesion ``w`` >= 0 [J/m^2] (Eq. 13).

    w = 0 is the limit of small w. Refused where S or S' is not positive.
    """
    return Nonadhesive(series, slopes).adhesive(w)


@dataclass(frozen=True, eq=False)
class AdhesiveCurve:
    """The adhesive curve of a series for the work of adhesion ``w`` [J/m^2]: a view on its w-free functions."""

    nonadhesive: Nonadhesive
    w: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.w) and self.w >= 0):
            raise InputError(f"w: must be >= 0 J/m^2, got {self.w:g}")

    @property
    def series(self) -> Series:
        """The nonadhesive series that the curve is made from."""
        return self.nonadhesive.series

    @property
    def slopes(self) -> Slopes:
        """S and S' of the series."""
        return self.nonadhesive.slopes

    @property
    def a(self) -> Array:
        """Contact radii of the series [m]."""
        return self.series.a

    @cached_property
    def _shift(self) -> Array:
        return shift(self.w, self.a, self.slopes.dS)

    @cached_property
    def delta(self) -> Array:
        """Displacement [m] at the radii of the series."""
        return self.nonadhesive.points.delta_H - self._shift

    @cached_property
    def P(self) -> Array:
        """Load [N] at the radii of the series."""
        return self.nonadhesive.points.P_H - self.slopes.S * self._shift

    @cached_property
    def errors(self) -> Mapping[str, Array]:
        """90 % half-widths of "delta" [m] and "P" [N] at given radius, by first-order propagation of the slopes'
        covariance; empty where no error is known."""
        covariance, root_w = self.slopes.covariance, math.sqrt(self.w)
        if covariance is None:
            return {}
        gradients = {name: fixed + root_w * rest for name, (fixed, rest) in self.nonadhesive.gradients.items()}
        return {
            name: self.slopes.quantile * np.sqrt(np.einsum("ni,nij,nj->n", gradient, covariance, gradient))
            for name, gradient in gradients.items()
        }

    def at(self, a: Array) -> tuple[Array, Array]:
        """delta [m] and P [N] at any contact radius within the series."""
        return self._at(self._inside(a))

    def rates(self, a: Array) -> tuple[Array, Array]:
        """d(delta)/da [-] and dP/da [N/m] at any contact radius within the series."""
        return self._rates(self._inside(a))

    def point(self, a: float) -> Equilibrium:
        """The equilibrium at contact radius ``a`` [m] within the series."""
        delta, P = self.at(np.array(a))
        return Equilibrium(a, float(delta), float(P))

    def error_at(self, a: Array) -> dict[str, Array]:
        """The half-widths of ``errors`` at any contact radius within the series (linear between points)."""
        inside = self._inside(a)
        return {name: np.interp(inside, self.a, values) for name, values in self.errors.items()}

    def thinned(self, first: int) -> AdhesiveCurve:
        """The curve through every second point of its series from ``first`` on."""
        return self.nonadhesive.at_rows(np.arange(first, len(self.series), 2)).adhesive(self.w)

    @cached_property
    def interpolation_error(self) -> Estimate:
        """Relative error of delta and P between the points: their change where every second point is left out, over 8.

        The units are the values themselves, or the lowest of the curve where that is larger. The rule is of fourth
        order in the spacing (16), of third where its splines end: 8; of few points nothing of the kind is assumed.
        Slopes with noise add theirs.
        """
        if len(self.series) < TUNING.fewest:
            return Unknown(f"unknown: fewer than {TUNING.fewest} points")
        beyond = self.a - self.series.a0
        if np.max(beyond[1:] / beyond[:-1]) > TUNING.widest:
            return Unknown(f"unknown: neighbouring radii differ by more than a factor of {TUNING.widest:g}")
        change = max(self._change_without(first) for first in (1, 2))
        return change if len(self.series) < TUNING.few else change / TUNING.order_factor

    def _change_without(self, first: int) -> float:
        """Largest relative change of delta and P at every second inner point from ``first`` on, left out."""
        rows = np.arange(len(self.series))
        left_out = rows[first:-1:2]
        coarser = self.nonadhesive.at_rows(np.setdiff1d(rows, left_out)).adhesive(self.w)
        changes = []
        for ours, there in zip((self.delta, self.P), coarser.at(self.a[left_out]), strict=True):
            unit = np.maximum(np.abs(ours[left_out]), abs(np.min(ours)))
            changes.append(np.max(np.abs(there - ours[left_out]) / unit))
        return float(max(changes))

    def critical(self, stiffness: float) -> tuple[CriticalPoint, ...]:
        """All points in the series where d(delta + P/stiffness)/da = 0, by increasing radius; there may be none.

        ``stiffness`` [N/m] of the device: 0 is load control (dP/da = 0), infinity displacement control.
        """
        points = []
        for a, rising in self.zeros(lambda a: position(*self._rates(a), stiffness)):
            points.append(CriticalPoint(**vars(self.point(a)), kind="minimum" if rising else "maximum"))
        return tuple(points)

    def radii(self, *, P: float | None = None, delta: float | None = None) -> tuple[float, ...]:
        """All contact radii [m] in the series at which the load is ``P`` [N], or the displacement ``delta`` [m]."""
        if P is not None and delta is None:
            return self.radii_at(P, LOAD_CONTROL)
        if delta is not None and P is None:
            return self.radii_at(delta, DISPLACEMENT_CONTROL)
        raise InputError("adhesive curve: give either P or delta to look for")

    def radii_at(self, held: float, stiffness: float) -> tuple[float, ...]:
        """All contact radii [m] in the series, increasing, at which a device of ``stiffness`` [N/m] stands at ``held``
        (its ``position``)."""
        return tuple(a for a, _ in self.zeros(lambda a: position(*self._at(a), stiffness) - held))

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
        """Pull-off under load control (``stiffness`` 0), pull-off under displacement control (inf), or by a device.

        The last stable point on retraction; ``stiffness`` [N/m] as in ``critical``. Where the curve has several minima,
        the lowest: at the others contact shrinks to a smaller stable radius. Unknown, with numbers and a remedy, where
        it does not lie in the series: contact is lost at a position <= 0 only, above the free bodies would overlap.
        """
        if self.w == 0:
            return NO_ADHESION

        def held(point: Equilibrium) -> float:
            return float(position(point.delta, point.P, stiffness))

        minima = [point for point in self.critical(stiffness) if point.kind == "minimum"]
        ends = {"smallest": self.point(float(self.a[0])), "largest": self.point(float(self.a[-1]))}
        lowest = min(ends, key=lambda end: held(ends[end]))
        best = min(minima, key=held, default=None)
        if best is None or held(best) > held(ends[lowest]):
            return Unknown(_outside(stiffness, lowest, ends[lowest]))
        if held(best) > 0:
            return Unknown(
                f"contact shrinks at P = {best.P:.4g} N, delta = {best.delta:.4g} m below the smallest radius of the "
                f"series, a = {self.a[0]:.4g} m, where some must remain: the series would have to begin at a smaller "
                "radius"
            )
        return best

    def _at(self, a: Array) -> tuple[Array, Array]:
        here, root_w = self.nonadhesive.parts(a), math.sqrt(self.w)
        t = root_w * here.t
        return here.delta_H - t, here.P_H - here.S * t

    def _rates(self, a: Array) -> tuple[Array, Array]:
        (here, rate), root_w = self.nonadhesive.with_rates(a), math.sqrt(self.w)
        t, dt = root_w * here.t, root_w * rate.t
        return rate.delta_H - dt, rate.P_H - here.S * dt - rate.S * t

    def _inside(self, a: Array) -> Array:
        a = np.asarray(a, dtype=float)
        low, high = self.a[0], self.a[-1]
        outside = (a < low * (1 - TUNING.end)) | (a > high * (1 + TUNING.end)) | ~np.isfinite(a)
        if outside.any():
            raise InputError(
                f"adhesive curve: contact radius {np.atleast_1d(a)[np.atleast_1d(outside)][0]:g} m lies outside the "
                f"series, {low:g} to {high:g} m"
            )
        return np.clip(a, low, high)

    def _samples(self) -> Array:
        x = np.log(self.a)
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(TUNING.samples) / TUNING.samples
        return np.append(inner.ravel(), x[-1])


def _outside(stiffness: float, end: str, lowest: Equilibrium) -> str:
    """Why pull-off lies outside the series: the device is lowest at its ``end``."""
    quantity = next((name for name, value in CONTROLS.items() if value == stiffness), "device position")
    remedy = (
        'ask for smaller radii: loading.spacing = "log", by fem a smaller mesh.smallest '
        "(or contact shrinks to a point before it is lost)"
        if end == "smallest"
        else "the series would have to reach a larger radius: load further"
    )
    return (
        f"the {quantity} is lowest at the {end} radius of the series, a = {show(lowest.a, 'length')} "
        f"(P = {show(lowest.P, 'load')}, delta = {show(lowest.delta, 'length')}): pull-off lies outside it; {remedy}"
    )

"""The one evaluator of the w-free functions: what every adhesive curve of a series is made of.

With delta_H, P_H, S = dP_H/d(delta_H), S' = dS/da and t = sqrt(4 pi a/S') the curve of any w is
delta = delta_H - sqrt(w) t, P = P_H - sqrt(w) S t (Eq. 13).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError
from ..base.numerics import ROUNDED, Array, PiecewiseCubic, PiecewiseQuintic, composite_gauss, spline_slopes
from ..formulas import shift
from ..series import COLUMNS, Series
from .slopes.result import Slopes

# --------------------------------------------------------------------------------------------------
# The w-free functions of a series between its rows, such that the energy of a contact is a function of its state.
#
# Through the rows go cubics of log delta_H over log(a - a0), and a quintic of log S over log a through S, S' and S'';
# S' is its slope. In each interval delta_H has besides a multiple of s^2 (1 - s)^2, which vanishes with its slope at
# the rows and makes int S d(delta_H) what P_H gains from row to row; P_H is that integral. Power laws (Hertz) are
# exact with any number of rows. All of it is tabulated once, so finely that cubics between the nodes conserve energy
# to about 1e-10.

# How finely the functions are tabulated.
BETWEEN_SPACING = 0.01  # theory: of log(a - a0); cubics between leave a share of 0.01^4/384 of the energies
BETWEEN_CLOSE = 1e-3  # theory: of log a; S' and S'' tell S to the fourth power of it, better than S is known
# Of P_H, what its rounding leaves of a gain: just beyond a flat end S hardly grows, and no hump can make it up
BETWEEN_ROUNDING = 1e-13  # theory: 450 times the machine epsilon, for the formula of a load


class Logs(NamedTuple):
    """``columns``: log of (delta_H, P_H) over log(a - a0); ``slopes``: log of (S, S') over log a; both at the same
    radii."""

    columns: PiecewiseCubic
    slopes: PiecewiseCubic


@dataclass(frozen=True, eq=False)
class Rows:
    """The functions at radii ``a`` [m], in SI, all (n,); ``rates`` (n, 2): slopes of log delta_H and of log S' over the
    logarithms of ``Logs``, NaN where they are not known. ``a0``: radius of first contact [m]. ``bends``: numbers of the
    rows at which delta_H is not smooth: splines of it end there. ``derived``: whether S' is the derivative of S."""

    a: Array
    a0: float
    delta: Array
    P: Array
    S: Array
    dS: Array
    rates: Array
    bends: Array = field(default_factory=lambda: np.empty(0, int))
    derived: bool = True

    @cached_property
    def logs(self) -> Logs:
        """Cubics through the rows alone: slopes that are not known are those of splines, that of log P_H is given by
        dP_H = S d(delta_H), that of log S is a S'/S where S' is the derivative of S."""
        x, z = np.log(self.a), np.log(self.a - self.a0)
        rates = self.rates
        if np.isnan(rates).any():
            # Slopes of splines that end at the bends; there that of the piece before, where y is smooth
            y = np.log(self.delta)
            pieces = np.empty_like(y)
            for lo, hi in itertools.pairwise([y.size - 1, *self.bends[::-1].tolist(), 0]):
                pieces[hi : lo + 1] = spline_slopes(z[hi : lo + 1], y[hi : lo + 1])
            fitted = np.stack([pieces, spline_slopes(x, np.log(self.dS))], 1)
            rates = np.where(np.isnan(rates), fitted, rates)
        rate, rate_dS = rates.T
        rate = _rising(z, np.log(self.delta), rate)
        by_P = _rising(z, np.log(self.P), self.S * self.delta / self.P * rate)
        by_S = self.a * self.dS / self.S if self.derived else spline_slopes(x, np.log(self.S))
        return Logs(
            PiecewiseCubic(z, np.log(np.stack([self.delta, self.P], 1)), np.stack([rate, by_P], 1)),
            PiecewiseCubic(x, np.log(np.stack([self.S, self.dS], 1)), np.stack([by_S, rate_dS], 1)),
        )


def _rising(x: Array, y: Array, slopes: Array) -> Array:
    """The ``slopes`` at the points, none larger than three times the chord on either side, where ``y`` rises there:
    steeper ones make a cubic fall in between (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238)."""
    chord = np.diff(y) / np.diff(x)
    most = 3 * np.minimum(np.append(chord[0], chord), np.append(chord, chord[-1]))
    return np.where(most > 0, np.minimum(slopes, most), slopes)


def energy_consistent_interpolant(rows: Rows) -> Logs:
    """The functions between the ``rows``; those through the rows alone where the columns contradict each other so much
    that delta_H or S would have to fall in between, or S' is not the derivative of S."""
    plain = rows.logs
    if not rows.derived:
        return plain

    # Places z = log(a - a0) close enough to each other, the rows among them, each in an interval i of the rows.
    z, widths = plain.columns.x, np.diff(plain.columns.x)
    counts = np.maximum(np.ceil(widths / BETWEEN_SPACING).astype(int), 1)
    first = np.repeat(np.arange(counts.size), counts)
    inner = np.arange(first.size) - np.repeat(np.cumsum(counts) - counts, counts)
    places, i = np.append(z[first] + widths[first] * inner / counts[first], z[-1]), np.append(first, first[-1])

    # The quintic of log S over log a, through its slope a S'/S and the slope of that.
    rate = rows.a * rows.dS / rows.S
    bend = rate * (1 + plain.slopes(plain.slopes.x, 1)[:, 1] - rate)
    log_S = PiecewiseQuintic(plain.slopes.x, np.log(rows.S), rate, bend, BETWEEN_CLOSE)

    def cubic(z: Array) -> tuple[Array, Array]:
        """exp of the cubic of log delta_H, and its slope over z."""
        value = np.exp(plain.columns(z)[..., 0])
        return value, value * plain.columns(z, 1)[..., 0]

    def hump(at: Array, i: Array) -> tuple[Array, Array]:
        """s^2 (1 - s)^2 in the intervals ``i`` of the rows, and its slope over z."""
        s = (at - z[i]) / widths[i]
        return (s * (1 - s)) ** 2, 2 * s * (1 - s) * (1 - 2 * s) / widths[i]

    # int S d(delta_H) from place to place, of the cubic and of one hump, and in each interval as many humps as make up
    # what P_H gains there; none where the cubic misses round-off alone.
    at, weights = composite_gauss(places)
    weights = weights * np.exp(log_S(np.log(rows.a0 + np.exp(at))))
    gained, by_hump = (np.sum(weights * slope, 1) for _, slope in (cubic(at), hump(at, first[:, None])))
    gain = np.diff(rows.P)
    missed = gain - np.bincount(first, gained)
    humps = np.where(np.abs(missed) > BETWEEN_ROUNDING * rows.P[1:], missed / np.bincount(first, by_hump), 0.0)
    gains = gained + humps[first] * by_hump
    gains *= (gain / np.bincount(first, gains))[first]  # round-off
    P = rows.P[0] + np.append(0.0, np.cumsum(gains))

    # delta_H, S and S' at the places, with their slopes.
    delta, by_z = (value + humps[i] * added for value, added in zip(cubic(places), hump(places, i), strict=True))
    x = np.log(rows.a0 + np.exp(places))
    log_S_here, rate, bend = (log_S(x, order) for order in range(3))
    S = np.exp(log_S_here)
    if not all((values > 0).all() for values in (by_z, rate, delta, P)):
        return plain  # delta_H or S falls somewhere, or a load is none
    log_dS = log_S_here + np.log(rate) - x
    return Logs(
        PiecewiseCubic(places, np.log(np.stack([delta, P], 1)), np.stack([by_z / delta, S / P * by_z], 1)),
        PiecewiseCubic(x, np.stack([log_S_here, log_dS], 1), np.stack([rate, rate + bend / rate - 1], 1)),
    )


# Which rows are neighbours.
NONADHESIVE_APART = 0.5  # choice: of a - a0, from which no error of theirs makes two radii one


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

    delta_H and P_H are those of the slopes' own fit where it has them. Between the points they belong to one energy
    (``energy_consistent_interpolant``). delta_H and P_H vanish at the first contact radius a0: their logs are taken
    over log(a - a0).
    Refused where S or S' is not positive. ``log_rates``: slopes (n, 2) of log delta_H and of log S' over the same
    logarithms where they are known, NaN elsewhere. ``further``: the functions at more radii, among those of the series,
    which what lies between passes through too. ``together``: whether what lies between belongs to one energy, or each
    function is interpolated for itself. ``unexplained``: factors of the profile and of all moduli that would make the
    functions those of the bodies that the series is said to be of, where nothing explains that they are not.
    """

    series: Series
    slopes: Slopes
    log_rates: Array | None = None
    further: Nonadhesive | None = None
    together: bool = True
    unexplained: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        bad = ~((self.slopes.dS > 0) & (self.slopes.S > 0))
        if bad.any():
            raise InputError(
                f"slopes: S or dS/da is not positive at {int(bad.sum())} radii, first at a = {self.a[bad][0]:.4g} m: "
                "Eq. 13 has no solution there; leave those points out or take other slopes"
            )

    @classmethod
    def of(cls, series: Series, rule: str = "auto") -> Nonadhesive:
        """Those of ``series`` with slopes by a ``rule`` ("exact"), or by the surest."""
        from .slopes.choice import slopes

        return cls(series, slopes(series, rule))

    def scaled(self, factor: float) -> Nonadhesive:
        """The functions of the same bodies with all moduli multiplied by ``factor``."""
        if factor == 1:
            return self
        further = None if self.further is None else self.further.scaled(factor)
        return replace(self, series=self.series.scaled(factor), slopes=self.slopes.scaled(factor), further=further)

    def under_profile(self, factor: float) -> Nonadhesive:
        """The functions of the same bodies under an indenter whose profile is ``factor`` times as high: delta_H and P_H
        are that many times as large, S and S' remain."""
        if factor == 1:
            return self
        further = None if self.further is None else self.further.under_profile(factor)
        series, slopes = self.series.under_profile(factor), self.slopes.under_profile(factor)
        return replace(self, series=series, slopes=slopes, further=further)

    @property
    def a(self) -> Array:
        """Contact radii of the series [m]."""
        return self.series.a

    @cached_property
    def shifted(self) -> tuple[Nonadhesive, ...]:
        """The functions with all radii larger, and smaller, by what is unknown of them together; none where nothing
        is."""
        shift = self.series.shift
        if shift is None or not shift.any():
            return ()
        rate, shifted = np.gradient(shift, self.a), list[Nonadhesive]()
        for sign in (1, -1):
            a, stretch = self.a + sign * shift, 1 + sign * rate  # and what that changes distances of radii by
            known = (a > self.series.a0) & (stretch > 0) & np.append(True, np.diff(a) > 0)
            rest = self.at_rows(np.flatnonzero(known))
            series, slopes = replace(rest.series, a=a[known]), replace(rest.slopes, dS=rest.slopes.dS / stretch[known])
            shifted.append(Nonadhesive(series, slopes, together=self.together))
        return tuple(shifted)

    @cached_property
    def described(self) -> Nonadhesive | None:
        """The functions with all that is unexplained put down to the series; None where nothing is."""
        profile, moduli = self.unexplained
        if profile == moduli == 1:
            return None
        return replace(self.under_profile(profile).scaled(moduli), unexplained=(1.0, 1.0))

    @cached_property
    def points(self) -> Parts:
        """The functions at the radii of the series, as the slopes' method gives them."""
        series, slopes = self.series, self.slopes
        delta_H = series.delta if slopes.delta is None else slopes.delta
        P_H = series.P if slopes.P is None else slopes.P
        return Parts(delta_H, P_H, slopes.S, slopes.dS, shift(1.0, self.a, slopes.dS))

    def parts(self, a: Array) -> Parts:
        """delta_H [m], P_H [N], S [N/m], S' [N/m^2], t [m] at radii within the series, by one evaluation rule."""
        columns, slopes = self.logs
        delta_H, P_H = np.exp(np.moveaxis(columns(np.log(a - self.series.a0)), -1, 0))
        S, dS = np.exp(np.moveaxis(slopes(np.log(a)), -1, 0))
        return Parts(delta_H, P_H, S, dS, shift(1.0, a, dS))

    def rates(self, a: Array) -> Parts:
        """The derivatives of ``parts`` by the radius, each in the unit of its part per m: ``rates(a).dS`` is S''."""
        return self.with_rates(a)[1]

    def with_rates(self, a: Array) -> tuple[Parts, Parts]:
        """``parts`` and ``rates`` at once."""
        here, beyond = self.parts(a), a - self.series.a0
        columns, slopes = self.logs
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
        known = None if self.log_rates is None else self.log_rates[rows]
        series = replace(self.series, **_at(self.series, rows), errors={}, unresolved=None, shift=None)
        slopes = replace(self.slopes, **_at(self.slopes, rows), covariance=None, joint=None)
        return Nonadhesive(series, slopes, known, together=self.together)

    @cached_property
    def knots(self) -> Nonadhesive:
        """The functions with all radii at which they are known as those of the series, without errors.

        A row closer to a further radius than the fourth root of their errors e gives way to it: the slope e/x that the
        two would make over their distance x is more than the x^3 that cubics leave of any other.
        """
        if self.further is None:
            return self
        parts = (self.at_rows(np.flatnonzero(self._apart(self.further))), self.further)
        a, order = np.unique(np.concatenate([part.a for part in parts]), return_index=True)
        columns = np.concatenate([np.array(part.points[:4]) for part in parts], axis=1)[:, order]
        rates = np.concatenate([part._known_rates for part in parts])[order]
        delta, P, S, dS = columns
        series = replace(self.series, a=a, delta=delta, P=P, S=S, dS=dS, errors={}, shift=None)
        slopes = replace(self.slopes, S=S, dS=dS, delta=None, P=None, covariance=None, joint=None)
        return Nonadhesive(series, slopes, rates, together=self.together)

    def _apart(self, further: Nonadhesive) -> Array:
        """Which rows are not too close to a ``further`` radius, or end the series: all between lies within knots."""
        series = further.series
        delta, dS = (series.errors[name] / getattr(series, name) for name in ("delta", "dS"))
        if series.unresolved is not None:  # rows and solved radii share it
            delta = np.maximum(delta - series.unresolved[0] / series.delta, 0.0)
        wrong = np.max([delta, dS], initial=0.0)
        right = np.searchsorted(further.a, self.a)
        distance = np.abs(further.a[np.clip([right - 1, right], 0, further.a.size - 1)] - self.a).min(axis=0)
        beyond = (self.a < further.a[0]) | (self.a > further.a[-1])
        ends = np.isin(self.a, self.a[[0, -1]]) & beyond
        return ends | (distance > min(wrong**0.25, NONADHESIVE_APART) * (self.a - series.a0))

    def thinned(self, first: int) -> Nonadhesive:
        """The functions of every second point from ``first`` on, the ends and the kinks; the same for every w."""
        if first not in self._thinned:
            last = self.a.size - 1
            rows = np.unique(np.concatenate([np.arange(first, last + 1, 2), [0, last], self.bends]))
            self._thinned[first] = self.at_rows(rows)
        return self._thinned[first]

    @cached_property
    def _thinned(self) -> dict[int, Nonadhesive]:
        """The functions of fewer points that are known by now, by the first that is left out or kept."""
        return {}

    @cached_property
    def apart(self) -> Nonadhesive:
        """The same functions, each interpolated for itself."""
        return replace(self, together=False)

    @cached_property
    def bends(self) -> Array:
        """Numbers of the rows at kinks of the profile."""
        kinks = np.array(self.series.kinks)
        at = np.any(np.abs(self.a[1:-1, None] / kinks - 1) < ROUNDED, axis=1)
        return np.flatnonzero(at) + 1

    @property
    def _known_rates(self) -> Array:
        return np.full((self.a.size, 2), np.nan) if self.log_rates is None else self.log_rates

    @cached_property
    def logs(self) -> Logs:
        """The functions between the points."""
        if self.further is not None:
            return self.knots.logs
        if len(self.series) < 2:
            raise InputError("adhesive curve: a solution of one point has no values between points")
        rows = Rows(self.a, self.series.a0, *self.points[:4], self._known_rates, self.bends, self.slopes.derived)
        return energy_consistent_interpolant(rows) if self.together else rows.logs


def _at(columns: Series | Slopes, rows: Array) -> dict[str, Any]:
    """The columns of a series, or of slopes, at the points ``rows`` alone."""
    return {name: getattr(columns, name)[rows] for name in COLUMNS if getattr(columns, name, None) is not None}

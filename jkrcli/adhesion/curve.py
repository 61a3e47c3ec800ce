"""From a nonadhesive series to the adhesive curve of any work of adhesion, and what is read off that curve.

delta(a) = delta_H(a) - sqrt(w) t(a)      P(a) = P_H(a) - sqrt(w) S(a) t(a)      t = sqrt(4 pi a/S')      (Eq. 13)

The stiffness of the device that presses decides what it prescribes, a load, a displacement or its own position
delta + P/stiffness: where that is stationary along the curve, contact is lost.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np

from ..base.errors import Estimate, InputError, Unknown
from ..base.numerics import (
    ROUNDED,
    SAME,
    UNSEEN,
    Array,
    PiecewiseCubic,
    PiecewiseQuintic,
    composite_gauss,
    rising_slopes,
    spline_slopes,
    zeros_between,
)
from ..base.units import show
from ..formulas import Parts, shift
from ..series import COLUMNS, Series
from .slopes import Slopes

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

    @property
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
        rate = rising_slopes(z, np.log(self.delta), rate)
        by_P = rising_slopes(z, np.log(self.P), self.S * self.delta / self.P * rate)
        by_S = self.a * self.dS / self.S if self.derived else spline_slopes(x, np.log(self.S))
        return Logs(
            PiecewiseCubic(z, np.log(np.stack([self.delta, self.P], 1)), np.stack([rate, by_P], 1)),
            PiecewiseCubic(x, np.log(np.stack([self.S, self.dS], 1)), np.stack([by_S, rate_dS], 1)),
        )


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
    if not ((total := np.bincount(first, gains)) > 0).all():
        return plain  # rows so near to each other that no load is gained between them
    gains *= (gain / total)[first]  # round-off
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


@dataclass(frozen=True, eq=False)
class Nonadhesive:
    """The w-free functions delta_H, P_H, S, S' and shift t of a series: all that its adhesive curves are made of.

    delta_H and P_H are those of the slopes' own fit where it has them. Between the points they belong to one energy
    (``energy_consistent_interpolant``). delta_H and P_H vanish at the first contact radius a0: their logs are taken
    over log(a - a0).
    Refused where S or S' is not positive. ``log_rates``: slopes (n, 2) of log delta_H and of log S' over the same
    logarithms where they are known, NaN elsewhere. ``further``: the functions at more radii, among those of the series,
    which what lies between passes through too. ``together``: whether what lies between belongs to one energy, or each
    function is interpolated for itself. ``reference``: the functions of the bodies that the series is said to be of, by
    their exact solution, where the series is another one.
    """

    series: Series
    slopes: Slopes
    log_rates: Array | None = None
    further: Nonadhesive | None = None
    together: bool = True
    reference: Nonadhesive | None = None
    _thinned: dict[int, Nonadhesive] = field(default_factory=dict, init=False)  # known by now

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
        from .slopes import slopes

        return cls(series, slopes(series, rule))

    def scaled(self, factor: float) -> Nonadhesive:
        """The functions of the same bodies with all moduli multiplied by ``factor``."""
        if factor == 1:
            return self
        further, reference = (None if one is None else one.scaled(factor) for one in (self.further, self.reference))
        series, slopes = self.series.scaled(factor), self.slopes.scaled(factor)
        return replace(self, series=series, slopes=slopes, further=further, reference=reference)

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
        """The functions with all radii larger, and smaller, by what is unknown of them together, by the same rule; none
        where nothing is."""
        shift = self.series.shift
        if shift is None or not shift.any():
            return ()
        shifted = list[Nonadhesive]()
        for a in (self.a + shift, self.a - shift):
            known = (a > self.series.a0) & np.append(True, np.diff(a) > 0)
            series = replace(self.at_rows(np.flatnonzero(known)).series, a=a[known])
            try:
                shifted.append(replace(self.of(series, self.slopes.method), together=self.together))
            except InputError:  # the rule finds no slopes there
                continue
        return tuple(shifted)

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
        place, a = a, self.contact_radii(a)
        delta_H, P_H = np.exp(np.moveaxis(columns(np.log(a - self.series.a0)), -1, 0))
        S, dS = np.exp(np.moveaxis(slopes(np.log(a)), -1, 0))
        here = Parts(delta_H, P_H, S, dS, shift(1.0, a, dS))
        if self.series.rim == math.inf:
            return here
        pressed = (place / a - 1) * here.t
        return here._replace(delta_H=delta_H + pressed, P_H=P_H + S * pressed)

    def contact_radii(self, places: Array) -> Array:
        """The contact radii [m] at ``places`` [m]: the same up to the rim of a full end, at which the edge is pinned
        while delta_H goes on as t (place/rim - 1), and P_H as S times that."""
        return np.minimum(places, self.series.rim)

    def rates(self, a: Array) -> Parts:
        """The derivatives of ``parts`` by the radius, each in the unit of its part per m: ``rates(a).dS`` is S''."""
        return self.with_rates(a)[1]

    def with_rates(self, a: Array) -> tuple[Parts, Parts]:
        """``parts`` and ``rates`` at once."""
        here, full = self.parts(a), a >= self.series.rim
        columns, slopes = self.logs
        a = self.contact_radii(a)
        beyond = a - self.series.a0
        by_delta, by_P = np.moveaxis(columns(np.log(beyond), 1), -1, 0) / beyond
        by_S, by_dS = np.moveaxis(slopes(np.log(a), 1), -1, 0) / a
        by_t = (1 / a - by_dS) / 2
        rates = Parts(here.delta_H * by_delta, here.P_H * by_P, here.S * by_S, here.dS * by_dS, here.t * by_t)
        if full.any():
            pinned = Parts(here.t / a, here.S * here.t / a, *np.zeros((3, *np.shape(a))))
            rates = Parts(*(np.where(full, one, other) for one, other in zip(pinned, rates, strict=True)))
        return here, rates

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
        series = replace(self.series, **columns_at(self.series, rows), errors={}, unresolved=None, shift=None)
        slopes = replace(self.slopes, **columns_at(self.slopes, rows), covariance=None, joint=None, other=None)
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
        # Any other column is known at the rows of the series alone, and left out
        known = dict.fromkeys(COLUMNS) | {"a": a, "delta": delta, "P": P, "S": S, "dS": dS}
        series = replace(self.series, **known, errors={}, shift=None)  # type: ignore[arg-type]
        slopes = replace(self.slopes, S=S, dS=dS, delta=None, P=None, covariance=None, joint=None, other=None)
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

    def spread(self, points: int) -> Array:
        """So many radii [m], as close to each other as those of the series around them."""
        a0, rows = self.series.a0, np.arange(len(self.series))
        a = a0 + np.exp(np.interp(np.linspace(0, rows[-1], points), rows, np.log(self.a - a0)))
        a[[0, -1]] = self.a[[0, -1]]
        return a

    def resampled(self, points: int) -> Nonadhesive:
        """The functions by so many ``points``, with the errors of the rows interpolated."""
        a, covariance = self.spread(points), self.slopes.covariance
        here = self.parts(a)
        errors = {name: self.between(values, a) for name, values in self.series.errors.items()}
        shared = None if self.series.shift is None else self.between(self.series.shift, a)
        series = replace(
            self.series, a=a, delta=here.delta_H, P=here.P_H, S=here.S, dS=here.dS, errors=errors, unresolved=None,
            shift=shared,
        )  # fmt: skip
        of_rows = None if covariance is None else self.between(covariance, a)
        slopes = replace(self.slopes, S=here.S, dS=here.dS, delta=None, P=None, covariance=of_rows, joint=None)
        return Nonadhesive(series, slopes, together=self.together)

    @property
    def apart(self) -> Nonadhesive:
        """The same functions, each interpolated for itself."""
        return replace(self, together=False)

    @property
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


def columns_at(columns: Series | Slopes, rows: Array) -> dict[str, Any]:
    """The columns of a series, or of slopes, at the points ``rows`` alone."""
    return {name: getattr(columns, name)[rows] for name in COLUMNS if getattr(columns, name, None) is not None}


# --------------------------------------------------------------------------------------------------
# The curve of a work of adhesion, and what is read off it.

NO_ADHESION = Unknown("there is no adhesion at w = 0")

# How a curve is searched, and when the error of its interpolation is known.
# per interval, between which zeros are sought, two between two samples are missed; tuned on cycles at speed, by
# `make constants`: half as many miss folds
CURVE_SAMPLES = 8
CURVE_FEWEST = 5  # theory: every second of fewer points leaves no cubic
CURVE_FEW = 10  # points from which the error falls with the spacing; tuned on noisy series, by `make tuning`
CURVE_WIDEST = 2.7  # ratio of neighbouring a - a0 up to which it does; tuned on the same, by `make tuning`
CURVE_ORDER = 3  # theory: with the spacing errors fall at least as its power, where splines end too
# of log(a - a0), the widest piece of a work; theory: Gauss' rule leaves 1e-10 of what bends as layers do
CURVE_WORKED = 0.05
CURVE_UNSURE = 2  # and that of works across two gaps that are wider; tuned on stacks, by `make stack-bounds`
CURVE_MIDDLE = 0.5  # theory: of its largest value, in which a cubic Hermite errs by s^2 (1 - s)^2 of an interval
CURVE_LOOKED_AT = (0.25, 0.5, 0.75)  # theory: of a gap, where S' and delta_H err most
CURVE_RIM = 0.01  # choice: of the position, up to which a first row may lie above the rim, with that as error
CURVE_ZERO = 1e-14  # theory: rounding of the samples, logs of radii or fractions of the last place


LOAD_CONTROL, DISPLACEMENT_CONTROL = 0.0, math.inf  # theory: as stiffness of the device [N/m]
CONTROLS = {"load": LOAD_CONTROL, "displacement": DISPLACEMENT_CONTROL}


def position(delta: Any, P: Any, stiffness: float) -> Any:
    """The position delta + P/stiffness [m] that a device of ``stiffness`` [N/m] prescribes; the load [N] at 0."""
    if math.isnan(stiffness) or stiffness < 0:
        raise InputError(f"stiffness: must be >= 0 N/m (0: load control, infinite: displacement), got {stiffness:g}")
    return P if stiffness == LOAD_CONTROL else delta + P / stiffness


def positions(delta: Array, P: Array, stiffness: Array) -> Array:
    """The ``position`` of each of several devices."""
    loaded = stiffness == LOAD_CONTROL
    return np.where(loaded, 0.0, delta) + P / np.where(loaded, 1.0, stiffness)


def controlled(stiffness: float) -> str:
    """The quantity that a device prescribes: ``load``, ``displacement`` or ``instrument position``."""
    return {value: name for name, value in CONTROLS.items()}.get(stiffness, "instrument position")


def control(stiffness: float) -> str:
    """The control in words: ``load control``, ``displacement control`` or ``instrument stiffness 0.2 N/m``."""
    name = controlled(stiffness)
    return f"{name} control" if name in CONTROLS else f"instrument stiffness {show(stiffness, 'stiffness')}"


@dataclass(frozen=True)
class Equilibrium:
    """One state of adhesive contact: contact radius ``a`` [m], displacement ``delta`` [m], load ``P`` [N]; ``c`` [m]:
    radius to which the surfaces attract, None where adhesion has no range; ``along``: its place on the curve [m] where
    that is not the contact radius."""

    a: float
    delta: float
    P: float
    c: float | None = None
    along: float | None = None

    @property
    def place(self) -> float:
        """Where it lies on its curve [m]: the contact radius, or ``along``."""
        return self.a if self.along is None else self.along


@dataclass(frozen=True)
class CriticalPoint(Equilibrium):
    """An equilibrium where the controlled quantity is stationary along the curve.

    ``kind``: "minimum" is where contact is lost on retraction, "maximum" bounds a stable branch on the other side.
    """

    kind: Literal["minimum", "maximum"] = "minimum"


def transform(series: Series, slopes: Slopes | str, w: float) -> AdhesiveCurve:
    """The adhesive curve of ``series`` for the work of adhesion ``w`` >= 0 [J/m^2] (Eq. 13), by its slopes or the rule
    for them.

    w = 0 is the limit of small w. Refused where S or S' is not positive.
    """
    return AdhesiveCurve(Nonadhesive.of(series, slopes) if isinstance(slopes, str) else Nonadhesive(series, slopes), w)


@dataclass(frozen=True, eq=False)
class EquilibriumCurve(ABC):
    """A curve of equilibria of adhesive contact along their place on it [m], which grows with the contact: the contact
    radius a, or what a subclass says. What is read off such a curve is the same whatever attracts the surfaces.

    Known by now: ``_critical`` points by stiffness, places ``_radii_at`` a position by a stiffness.
    """

    ranged: ClassVar[bool] = False  # whether adhesion has a range, so that surfaces may attract without contact
    _critical: dict[float, tuple[CriticalPoint, ...]] = field(default_factory=dict, init=False, repr=False)
    _radii_at: dict[tuple[float, float], tuple[float, ...]] = field(default_factory=dict, init=False, repr=False)
    if TYPE_CHECKING:  # fields of some, properties of others

        @property
        def w(self) -> float:
            """Work of adhesion [J/m^2]."""

        @property
        def series(self) -> Series:
            """The nonadhesive series of the same bodies."""

        @property
        def slopes(self) -> Slopes:
            """S and S' of that series."""

        @property
        def nonadhesive(self) -> Nonadhesive:
            """The w-free functions that hold between equilibria, where adhesion has no range."""

        @property
        def a(self) -> Array:
            """Contact radii of the points [m]."""

        @property
        def delta(self) -> Array:
            """Displacement [m] at the points."""

        @property
        def P(self) -> Array:
            """Load [N] at the points."""

        @property
        def complete(self) -> bool:
            """Whether it begins where the free bodies do, with nothing before its first point."""

        @property
        def onset(self) -> float:
            """Displacement [m] at which the free bodies begin to attract each other."""

    else:
        complete, onset = False, 0.0  # without a range

    @property
    @abstractmethod
    def places(self) -> Array:
        """Places of the points of the curve [m], increasing."""

    @property
    @abstractmethod
    def interpolation_error(self) -> Estimate:
        """Relative error of delta and P between the points."""

    @abstractmethod
    def thinned(self, first: int) -> Self:
        """The curve through every second of its points from ``first`` on."""

    @cached_property
    def halves(self) -> tuple[Self, Self]:
        """The curves through every second point."""
        return self.thinned(0), self.thinned(1)

    @property
    @abstractmethod
    def thinning(self) -> float:
        """By how much what leaving out every second point changes is more than the error of interpolation, at least: 1
        where it is scatter from point to point."""

    @property
    @abstractmethod
    def errors(self) -> Mapping[str, Array]:
        """Half-widths of "delta" [m] and "P" [N] at the points; empty where no error is known."""

    @property
    @abstractmethod
    def columns(self) -> dict[str, Array]:
        """The columns of its points by their names in a table."""

    @abstractmethod
    def point(self, place: float) -> Equilibrium:
        """The equilibrium at a ``place`` [m] on the curve."""

    def surface_displacement(self, point: Equilibrium) -> float | None:
        """How far the surface has moved at the ``point`` [m], downwards, where that is not delta; else None."""
        return None

    @abstractmethod
    def contact_radii(self, places: Array) -> Array:
        """The contact radii [m] at ``places`` on the curve."""

    def attracted_radii(self, places: Array) -> Array:
        """The radii [m] to which the surfaces attract each other at ``places``; the contact radii without a range."""
        return self.contact_radii(places)

    def spaced(self, first: float, last: float, points: int) -> Array:
        """``points`` places [m] from one to another, even on each smooth part of the curve."""
        return np.linspace(first, last, points)

    @abstractmethod
    def path(self, low: float, high: float) -> tuple[Array, Array]:
        """Places between two [m], and weights [m], for integrals along the curve."""

    @abstractmethod
    def _at(self, places: Array) -> tuple[Array, Array]: ...

    @abstractmethod
    def _rates(self, places: Array) -> tuple[Array, Array]: ...

    @property
    @abstractmethod
    def _samples(self) -> Array:
        """Numbers, increasing, whose ``_place`` lie close enough to separate two zeros."""

    @abstractmethod
    def _place(self, x: Array) -> Array:
        """Places [m] of such numbers: a monotone function along which the curve is smooth."""

    @abstractmethod
    def _outside(self, stiffness: float, end: str, lowest: Equilibrium) -> str:
        """Why there is no pull-off: the device is lowest at the "smallest" or "largest" ``end``."""

    def at(self, places: Array) -> tuple[Array, Array]:
        """delta [m] and P [N] at any place on the curve."""
        return self._at(self._inside(places))

    def rates(self, places: Array) -> tuple[Array, Array]:
        """Derivatives of delta [-] and P [N/m] by the place, at any place on the curve."""
        return self._rates(self._inside(places))

    def error_at(self, places: Array) -> dict[str, Array]:
        """The half-widths of delta [m] and P [N] at any place on the curve (linear between points)."""
        inside = self._inside(places)
        return {name: np.interp(inside, self.places, values) for name, values in self.errors.items()}

    def critical(self, stiffness: float) -> tuple[CriticalPoint, ...]:
        """All points of the curve where delta + P/stiffness is stationary, by increasing place; there may be none.

        ``stiffness`` [N/m] of the device: 0 is load control, infinity displacement control.
        """
        self.find_critical([stiffness])
        return self._critical[stiffness]

    def find_critical(self, devices: Iterable[float]) -> None:
        """Find the critical points under ``devices`` of several stiffnesses [N/m] together: one by one takes longer."""
        new = [stiffness for stiffness in dict.fromkeys(devices) if stiffness not in self._critical]
        for stiffness, zeros in zip(new, self._zeros(self._rates, new, [0.0] * len(new)), strict=True):
            self._critical[stiffness] = tuple(
                CriticalPoint(**vars(self.point(place)), kind="minimum" if rising else "maximum")
                for place, rising in zeros
            )

    @property
    def devices(self) -> tuple[float, ...]:
        """The stiffnesses [N/m] whose critical points are known by now."""
        return tuple(self._critical)

    def radii(self, *, P: float | None = None, delta: float | None = None) -> tuple[float, ...]:
        """All places [m] on the curve at which the load is ``P`` [N], or the displacement ``delta`` [m]."""
        if P is not None and delta is None:
            return self.radii_at(P, LOAD_CONTROL)
        if delta is not None and P is None:
            return self.radii_at(delta, DISPLACEMENT_CONTROL)
        raise InputError("adhesive curve: give either P or delta to look for")

    def radii_at(self, x: float, stiffness: float) -> tuple[float, ...]:
        """All places [m] on the curve, increasing, at which the ``position`` of a device of ``stiffness`` [N/m] is
        ``x``."""
        self.find_radii_at([(x, stiffness)])
        return self._radii_at[x, stiffness]

    def find_radii_at(self, pairs: Iterable[tuple[float, float]]) -> None:
        """Find the ``radii_at`` of several pairs of position and stiffness together."""
        new = [pair for pair in dict.fromkeys(pairs) if pair not in self._radii_at]
        zeros_of_pairs = self._zeros(self._at, [stiffness for _, stiffness in new], [x for x, _ in new])
        self._radii_at.update(zip(new, (tuple(place for place, _ in zeros) for zeros in zeros_of_pairs), strict=True))

    def _zeros(
        self, values: Callable[[Array], tuple[Array, Array]], devices: Sequence[float], levels: Sequence[float]
    ) -> list[list[tuple[float, bool]]]:
        """For each of the ``devices`` of a stiffness [N/m] the places on the curve, increasing, where its position,
        from ``values`` (delta and P, or their rates) at them, is that of the ``levels``, and whether it rises there."""
        if not devices:
            return []
        first, last, x = self.places[0], self.places[-1], self._samples

        def along(x: Array) -> tuple[Array, Array]:
            return values(np.clip(self._place(x), first, last))

        samples, lefts, rises = along(x), [], []
        for stiffness, value in zip(devices, levels, strict=True):
            signs = np.sign(position(*samples, stiffness) - value)
            changes = np.flatnonzero(signs[:-1] * signs[1:] <= 0)
            left = changes[(signs[changes + 1] != 0) | (changes + 2 == signs.size)]  # a zero there is the next pair's
            lefts.append(left)
            rises.append((signs[left + 1] > signs[left]).tolist())
        sizes = [left.size for left in lefts]
        left, stiff, level = np.concatenate(lefts), np.repeat(devices, sizes), np.repeat(levels, sizes)
        zeros = zeros_between(lambda x: positions(*along(x), stiff) - level, x[left], x[left + 1], CURVE_ZERO)
        places = np.split(np.clip(self._place(zeros), first, last), np.cumsum(sizes)[:-1])
        return [list(zip(some.tolist(), rising, strict=True)) for some, rising in zip(places, rises, strict=True)]

    def pull_off(self, stiffness: float) -> CriticalPoint | Unknown:
        """Pull-off under load control (``stiffness`` 0), pull-off under displacement control (inf), or by a device.

        The last stable point on retraction; ``stiffness`` [N/m] as in ``critical``. Where the curve has several minima,
        the lowest: at the others contact shrinks to a smaller stable radius. Unknown, with numbers and a remedy, where
        it does not lie in the series: contact is lost at a position <= 0 only, above the free bodies would overlap.
        """
        if self.w == 0:
            return NO_ADHESION

        def position_of(point: Equilibrium) -> float:
            return float(position(point.delta, point.P, stiffness))

        minima = [point for point in self.critical(stiffness) if point.kind == "minimum"]
        ends, lowest = self._ends, self.lowest_end(stiffness)
        best = min(minima, key=position_of, default=None)
        if best is None or position_of(best) > position_of(ends[lowest]):
            return Unknown(self._outside(stiffness, lowest, ends[lowest]))
        if position_of(best) > 0:
            return Unknown(
                f"at P = {best.P:.4g} N, delta = {best.delta:.4g} m contact shrinks to a radius below the smallest of "
                f"the solution, a = {self.places[0]:.4g} m, and is not lost: the solution must begin at a smaller "
                "radius"
            )
        return best

    def lowest_end(self, stiffness: float) -> str:
        """At which end of the curve a device of ``stiffness`` [N/m] stands lower, "smallest" or "largest"."""
        ends = self._ends
        return min(ends, key=lambda end: float(position(ends[end].delta, ends[end].P, stiffness)))

    @cached_property
    def _ends(self) -> dict[str, Equilibrium]:
        return {"smallest": self.point(float(self.places[0])), "largest": self.point(float(self.places[-1]))}

    def work(self, low: float, high: float) -> float:
        """Work int P d(delta) [J] along the curve from one place [m] to another."""
        if high < low:
            return -self.work(high, low)
        places, works = self._work_between
        first, last = np.searchsorted(places, low, side="right"), np.searchsorted(places, high) - 1
        if last < first:
            return float(self._works(low, high).sum())
        begin, end = self._works(low, places[first]), self._works(places[last], high)
        return float(begin.sum() + works[first:last].sum() + end.sum())

    @property
    def _joints(self) -> Array:
        """Places (n,), the ends among them, of pieces over which Gauss' rule is accurate: those of the ``path``."""
        return np.unique(self.places)

    @cached_property
    def _work_between(self) -> tuple[Array, Array]:
        """The joints (n,), and the work between them (n - 1,)."""
        return self._joints, self._works(*self.places[[0, -1]])

    def _works(self, low: float, high: float) -> Array:
        """The work between two places, of each piece of the ``path``."""
        places, weights = self.path(low, high)
        return (weights * self.at(places)[1] * self.rates(places)[0]).sum(axis=-1)

    def beyond(self, places: Array) -> Array:
        """Which places lie outside the curve."""
        low, high = self.places[[0, -1]]
        return (places < low * (1 - ROUNDED)) | (places > high * (1 + ROUNDED)) | ~np.isfinite(places)

    def beyond_words(self, place: float) -> str:
        """The message about a place outside the curve."""
        low, high = self.places[[0, -1]]
        return f"adhesive curve: contact radius {place:g} m lies outside the solution, {low:g} to {high:g} m"

    def _inside(self, places: Array) -> Array:
        places = np.asarray(places, dtype=float)
        beyond = self.beyond(places)
        if beyond.any():
            raise InputError(self.beyond_words(np.atleast_1d(places)[np.atleast_1d(beyond)][0]))
        return np.clip(places, *self.places[[0, -1]])


@dataclass(frozen=True, eq=False)
class AdhesiveCurve(EquilibriumCurve):
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
    def places(self) -> Array:
        """The contact radii themselves, and of a full end one place more: where it is pressed as far as the solution
        says, at least as deep as it is lost high."""
        a, rim = self.series.a, self.series.rim
        if a[-1] < rim:
            return a
        root_w, t = math.sqrt(self.w), float(self.nonadhesive.points.t[-1])
        end = max(2 * root_w, root_w + self.series.pressed / t)
        return np.append(a, rim * (1 + end)) if end else a

    @property
    def columns(self) -> dict[str, Array]:
        series, slopes = self.series, self.slopes
        return {
            "a_m": series.a,
            "delta_m": self.delta,
            "P_N": self.P,
            "delta_H_m": series.delta,
            "P_H_N": series.P,
            "S_N_per_m": slopes.S,
            "dS_da_N_per_m2": slopes.dS,
        }

    def contact_radii(self, places: Array) -> Array:
        return self.nonadhesive.contact_radii(places)

    @property
    def _points(self) -> tuple[Array, Array]:
        """delta [m] and P [N] at the radii of the series."""
        return self.nonadhesive.points.lagging(shift(self.w, self.a, self.slopes.dS))

    @property
    def delta(self) -> Array:
        """Displacement [m] at the radii of the series."""
        return self._points[0]

    @property
    def P(self) -> Array:
        """Load [N] at the radii of the series."""
        return self._points[1]

    @cached_property
    def errors(self) -> Mapping[str, Array]:
        """Half-widths of "delta" [m] and "P" [N] at given radius, by first-order propagation of the slopes'
        covariance and what the radii share; empty where no error is known."""
        covariance, root_w = self.slopes.covariance, math.sqrt(self.w)
        if covariance is None:
            return {}
        gradients = {name: fixed + root_w * rest for name, (fixed, rest) in self.nonadhesive.gradients.items()}
        of_rows = [np.sqrt(np.einsum("ni,nij,nj->n", each, covariance, each)) for each in gradients.values()]
        errors = np.hypot(self.slopes.quantile * np.stack(of_rows), self._by_shift)
        return dict(zip(gradients, errors, strict=True))

    def shift_error_at(self, place: Array) -> Array:
        """What a shift of all radii makes of delta [m] and P [N] at a ``place`` [m], (2,)."""
        return np.array([np.interp(place, self.a, values) for values in self._by_shift])

    @property
    def _by_shift(self) -> Array:
        """What a shift of all radii makes of delta [m] and P [N] at given radius, (2, n)."""
        shift = self.series.shift
        if shift is None:
            return np.zeros((2, self.a.size))
        here, rates = self.nonadhesive.with_rates(self.a)
        t = math.sqrt(self.w) * here.t
        return np.abs(here.lagging_rates(rates, t, -t * (rates.dS / (2 * here.dS)))) * shift

    def spaced(self, first: float, last: float, points: int) -> Array:
        rim, half = self.series.rim, points // 2
        if points == 2 or not min(first, last) < rim < max(first, last):
            return np.linspace(first, last, points)
        return np.append(np.linspace(first, rim, half, endpoint=False), np.linspace(rim, last, points - half))

    def error_at(self, places: Array) -> dict[str, Array]:
        inside, series = self._inside(places), self.series
        errors = {name: np.interp(inside, self.a, values) for name, values in self.errors.items()}
        if errors and series.rim < math.inf:  # and that of S times what a full end is pressed
            pressed = np.maximum(inside / series.rim - 1, 0.0) * self.nonadhesive.points.t[-1]
            errors["P"] = errors["P"] + float(series.errors["S"][-1]) * pressed
        return errors

    def point(self, place: float) -> Equilibrium:
        """The equilibrium at a place [m] of the curve."""
        place = self.series.rim if abs(place / self.series.rim - 1) <= ROUNDED else place
        delta, P = self.at(np.array(place))
        a = float(self.contact_radii(np.array(place)))
        return Equilibrium(a, float(delta), float(P), along=place if place > a else None)

    def thinned(self, first: int) -> Self:
        """The curve through every second point that is known from ``first`` on, the ends and the kinks."""
        return replace(self, nonadhesive=self.nonadhesive.knots.thinned(first))

    @cached_property
    def interpolation_error(self) -> Estimate:
        """Largest relative error of delta and P between the points (``interpolation_at`` inside each gap).

        The units are the values themselves, or the lowest of the curve where that is larger. Slopes with noise add
        theirs.
        """
        z = np.log(self.nonadhesive.knots.a - self.series.a0)
        wide = np.diff(z) > math.log(CURVE_WIDEST)
        if wide.all():
            return self._too_wide
        a = self.series.a0 + np.exp(z[:-1, None] + np.outer(np.diff(z), CURVE_LOOKED_AT))[~wide].ravel()
        a = a[~self.beyond(a)]  # points around pull-off may be solved beyond the last row
        errors = self.interpolation_at(a)
        if isinstance(errors, Unknown):
            return errors
        values = dict(zip(("delta", "P"), self.at(a), strict=True))
        lowest = {"delta": self.delta.min(), "P": self.P.min()}
        units = {name: np.maximum(np.abs(value), abs(lowest[name])) for name, value in values.items()}
        largest = float(max(np.max(errors[name] / units[name]) for name in units))
        if wide.any():
            end = show(float(self.nonadhesive.knots.a[1:][wide][-1]), "length", 4)
            return Unknown(f"{self._too_wide.reason} (up to a = {end}), {largest:.1e} elsewhere")
        return largest

    @property
    def _too_wide(self) -> Unknown:
        beyond = " beyond the flat end" if self.series.a0 > 0 else ""
        return Unknown(f"unknown where neighbouring radii{beyond} differ by more than a factor of {CURVE_WIDEST:g}")

    def interpolation_at(self, a: Array) -> dict[str, Array] | Unknown:
        """Errors of "delta" [m] and "P" [N] between the points, at radii within the series; 0 at the points.

        What leaving out every second point changes in this gap or one beside, over the cube of the ratio of the gaps:
        the rule is of fourth order in the spacing, of third where its splines end; of few points nothing of the kind is
        assumed. Of the two halves of the points the one counts in which the radius lies nearer to the middle of a gap.
        """
        knots = self.nonadhesive.knots.a - self.series.a0
        y = self._inside(a) - self.series.a0
        gaps, at, place = np.diff(np.log(knots)), _before(knots, y), _place_between(knots, y)
        if (reason := self._too_few(float(np.max(gaps[at])))) is not None:
            return reason
        beside = np.clip(np.stack([at - 1, at, at + 1]) if self._order else at[None], 0, gaps.size - 1)
        shape = 4 * place * (1 - place) * (gaps[at] / gaps[beside]) ** self._order
        return {name: np.max(changes[beside] * shape, axis=0) for name, changes in self._gap_errors.items()}

    def _too_few(self, gap: float) -> Unknown | None:
        """Why errors between points are unknown over such a ``gap`` of log(a - a0); None where they are known."""
        if self.nonadhesive.knots.a.size < CURVE_FEWEST:
            return Unknown(f"unknown: fewer than {CURVE_FEWEST} points")
        if gap > math.log(CURVE_WIDEST):
            return self._too_wide
        return None

    def work_between(self, low: float, high: float) -> Estimate:
        """Error of the ``work`` [J] from one place [m] to another, at equal displacements, by what lies between the
        points (see ``_gap_works``)."""
        x = np.log(self.nonadhesive.knots.a - self.series.a0)
        first, last = np.log(np.array([low, high]) - self.series.a0)
        gaps = np.diff(x)
        passed = (np.minimum(x[1:], last) - np.maximum(x[:-1], first)) / gaps
        some = passed > SAME
        if not some.any():
            return 0.0
        if (reason := self._too_few(float(np.max(gaps[some])))) is not None:
            return reason
        share = np.clip(passed, 0.0, 1.0)
        over_gap, over_part = self._gap_works
        return float(np.sum(over_gap * share + over_part * (4 * share * (1 - share)) ** 2))

    @cached_property
    def _gap_works(self) -> Array:
        """Errors (2, n - 1) of the work [J] over each gap between the points, and at most over a part of it.

        At equal displacements it errs by int (e_P d(delta) - e_delta dP), with one power of the gap more than values:
        what leaving out every second point changes is the error of the gap that is merged, less that of the gap.
        """
        a0, knots = self.series.a0, self.nonadhesive.knots.a - self.series.a0
        x, weights = composite_gauss(np.log(knots))
        gaps, a = np.diff(np.log(knots)), a0 + np.exp(x)
        (delta, P), rates = self._at(a), self._rates(a)
        largest = np.zeros((2, gaps.size))
        for coarser in self.halves:
            fewer = coarser.a - a0
            other_delta, other_P = coarser._at(a)
            pieces = weights * (a - a0) * ((other_P - P) * rates[0] - (other_delta - delta) * rates[1])
            merged = _before(fewer, np.sqrt(knots[1:] * knots[:-1]))
            so_far = np.cumsum(pieces).reshape(pieces.shape)
            begun = np.append(0.0, so_far[:-1, -1])[np.searchsorted(merged, merged)]
            reached = so_far - begun[:, None]
            both = np.zeros((2, fewer.size - 1))
            both[0] = np.abs(np.bincount(merged, pieces.sum(axis=1)))
            np.maximum.at(both[1], merged, np.abs(reached).max(axis=1))
            wider = np.diff(np.log(fewer))[merged] / gaps
            # the power of the gap with which it falls: less where splines end, and where gaps are too wide to say
            power = np.full(gaps.size, self._order + 1)
            power[np.isin(merged, [0, fewer.size - 2])] = max(self._order, 1)
            power[np.diff(np.log(fewer))[merged] > math.log(CURVE_WIDEST)] = CURVE_UNSURE
            change = both[:, merged] / np.maximum(wider**power - 1, ROUNDED)
            largest = np.where(wider > 1, np.maximum(largest, change), largest)
        return largest

    @property
    def _order(self) -> int:
        return CURVE_ORDER if self.nonadhesive.knots.a.size >= CURVE_FEW else 0

    @cached_property
    def _gap_errors(self) -> dict[str, Array]:
        """Errors (n - 1,) of "delta" [m] and "P" [N] in the middle of each gap between the points."""
        knots = self.nonadhesive.knots.a - self.series.a0
        y, gaps = np.sqrt(knots[1:] * knots[:-1]), np.diff(np.log(knots))
        a = self.series.a0 + y
        here, rounding = np.stack(self._at(a)), CURVE_ZERO * np.stack(self.nonadhesive.parts(a)[:2])
        largest = np.zeros_like(here)
        for coarser in self.halves:
            fewer = coarser.a - self.series.a0
            place, wider = _place_between(fewer, y), np.diff(np.log(fewer))[_before(fewer, y)] / gaps
            depth = 16 * (place * (1 - place)) ** 2
            change = np.maximum(np.abs(coarser._at(a) - here) - rounding, 0.0) / wider**self._order / depth
            largest = np.where((wider > 1) & (depth >= CURVE_MIDDLE), np.maximum(largest, change), largest)
        return {"delta": largest[0], "P": largest[1]}

    @property
    def smooth(self) -> bool:
        """Whether the points do not scatter, so that errors between them fall with their spacing."""
        return not isinstance(self.slopes.error, Unknown) and self.slopes.error <= UNSEEN

    @property
    def thinning(self) -> float:
        return 2.0**self._order if self.smooth else 1.0

    def _at(self, places: Array) -> tuple[Array, Array]:
        here = self.nonadhesive.parts(places)
        return here.lagging(math.sqrt(self.w) * here.t)

    def _rates(self, places: Array) -> tuple[Array, Array]:
        (here, rates), root_w = self.nonadhesive.with_rates(places), math.sqrt(self.w)
        return here.lagging_rates(rates, root_w * here.t, root_w * rates.t)

    @cached_property
    def _samples(self) -> Array:
        x = np.log(self.places - self.series.a0)  # of a, rounding would be felt just beyond a flat end
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(CURVE_SAMPLES) / CURVE_SAMPLES
        return np.append(inner.ravel(), x[-1])

    def _place(self, x: Array) -> Array:
        return self.series.a0 + np.exp(x)

    @cached_property
    def _joints(self) -> Array:
        knots, ends = self.nonadhesive.knots.a, self.places[[0, -1]]
        joints = np.union1d(ends, knots[(knots > ends[0]) & (knots < ends[1])])
        x = np.log(joints - self.series.a0)
        counts = np.ceil(np.diff(x) / CURVE_WORKED).astype(int)
        inner = [np.linspace(lo, hi, n + 1)[1:-1] for lo, hi, n in zip(x[:-1], x[1:], counts, strict=True)]
        return np.union1d(joints, self._place(np.concatenate(inner)))

    def path(self, low: float, high: float) -> tuple[Array, Array]:
        joints = self._joints
        edges = np.log(np.concatenate([[low], joints[(joints > low) & (joints < high)], [high]]))
        x, weights = composite_gauss(edges)
        a = np.clip(np.exp(x), low, high)
        return a, weights * a

    def pull_off(self, stiffness: float) -> CriticalPoint | Unknown:
        """As of every curve; where the first row is as good as the rim of a flat end, contact is lost there."""
        found = super().pull_off(stiffness)
        if isinstance(found, Unknown) and self.w > 0 and self.lowest_end(stiffness) == "smallest":
            first = self._ends["smallest"]
            left = abs(float(position(*self.below_first, stiffness)))
            if self.series.a0 > 0 and left <= CURVE_RIM * abs(float(position(first.delta, first.P, stiffness))):
                return CriticalPoint(**vars(first))
        return found

    @property
    def below_first(self) -> tuple[float, float]:
        """By how much delta [m] and P [N] may be lower below the first row: there -t and -S t are larger than here, and
        delta_H and P_H not below zero."""
        here = self.nonadhesive.parts(self.a[:1])
        return float(here.delta_H[0]), float(here.P_H[0])

    def _outside(self, stiffness: float, end: str, lowest: Equilibrium) -> str:
        """Why pull-off lies outside the series."""
        remedy = (
            'use smaller radii: loading.spacing = "log", by fem a smaller mesh.smallest '
            "(or contact shrinks to a point before it is lost)"
            if end == "smallest"
            else "increase [loading] radius"
        )
        if end == "smallest" and self.series.a0 > 0:
            rim = show(self.series.a0, "length")
            remedy += f"; contact is lost at the rim of the flat end at the latest, a = {rim}"
        return (
            f"the {controlled(stiffness)} is lowest at the {end} radius of the solution, a = "
            f"{show(lowest.a, 'length')} (P = {show(lowest.P, 'load')}, delta = {show(lowest.delta, 'length')}): "
            f"pull-off lies outside it; {remedy}"
        )


def _before(points: Array, x: Array) -> Array:
    """Number of the gap between the increasing ``points`` in which each ``x`` lies."""
    return np.clip(np.searchsorted(points, x, side="right"), 1, points.size - 1) - 1


def _place_between(points: Array, x: Array) -> Array:
    """Place of each ``x`` between the increasing ``points`` on both sides of it, in logarithms, from 0 to 1."""
    at = _before(points, x)
    return np.clip(np.log(x / points[at]) / np.log(points[at + 1] / points[at]), 0.0, 1.0)


# --------------------------------------------------------------------------------------------------
# Contacts too small for the theory: pull-off at radii below atoms.
#
# A cone has no length of its own, so that JKR theory goes on to any radius: a stiff one loses contact at picometres.

# When a contact is no longer one of an elastic continuum.
SHARP_NEAR = 3.0  # choice: distances of atoms z0 within which the end of a series is as good as pull-off itself


def mask_below_atomic_spacing(
    point: CriticalPoint | Unknown, curve: EquilibriumCurve, stiffness: float, z0: float
) -> CriticalPoint | Unknown:
    """A pull-off point under a device of ``stiffness`` [N/m], or Unknown where it lies at a radius below ``z0`` [m]."""
    if curve.ranged:  # its surfaces may attract each other without contact
        return point
    if isinstance(point, CriticalPoint):
        small = point.a < z0
    else:
        small = curve.a[0] < SHARP_NEAR * z0 and np.argmin(position(curve.delta, curve.P, stiffness)) == 0
    if not small:
        return point
    return Unknown(
        f"contact would be lost at a radius below the interatomic spacing, z0 = {show(z0, 'length')}, where continuum "
        'mechanics does not hold: give the radius that every real tip has (shape = "sphere", or a profile as "table"); '
        "of a tip so small that its Tabor number is below 0.1, forces of finite range pull off at about 2 pi w R"
    )

"""From a nonadhesive series to the adhesive curve of any work of adhesion, and what is read off that curve.

delta(a) = delta_H(a) - sqrt(w) t(a)      P(a) = P_H(a) - sqrt(w) S(a) t(a)      t = sqrt(4 pi a/S')      (Eq. 13)

The stiffness of the device that presses decides what it prescribes, a load, a displacement or its own position
delta + P/stiffness: where that is stationary along the curve, contact is lost.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np

from ..base.errors import Estimate, InputError, Unknown
from ..base.numerics import ROUNDED, UNSEEN, Array, composite_gauss, zeros_between
from ..base.units import show
from ..bodies.problem import Problem
from ..formulas import shift
from ..series import Series
from .interpolation import Nonadhesive
from .slopes.result import Slopes

NO_ADHESION = Unknown("there is no adhesion at w = 0")

# How a curve is searched, and when the error of its interpolation is known.
# per interval, between which zeros are sought, two between two samples are missed; tuned on cycles at speed, by
# `make constants`: half as many miss folds
CURVE_SAMPLES = 8
CURVE_FEWEST = 5  # theory: every second of fewer points leaves no cubic
CURVE_FEW = 10  # points from which the error falls with the spacing; tuned on noisy series, by `make tuning`
CURVE_WIDEST = 2.7  # ratio of neighbouring a - a0 up to which it does; tuned on the same, by `make tuning`
CURVE_ORDER = 3  # theory: with the spacing errors fall at least as its power, where splines end too
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


class EquilibriumCurve(ABC):
    """A curve of equilibria of adhesive contact along their place on it [m], which grows with the contact: the contact
    radius a, or what a subclass says. What is read off such a curve is the same whatever attracts the surfaces."""

    ranged: ClassVar[bool] = False  # whether adhesion has a range, so that surfaces may attract without contact
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
        """90 % half-widths of "delta" [m] and "P" [N] at the points; empty where no error is known."""

    @property
    @abstractmethod
    def columns(self) -> dict[str, Array]:
        """The columns of its points by their names in a table."""

    @abstractmethod
    def point(self, place: float) -> Equilibrium:
        """The equilibrium at a ``place`` [m] on the curve."""

    @abstractmethod
    def contact_radii(self, places: Array) -> Array:
        """The contact radii [m] at ``places`` on the curve."""

    def attracted_radii(self, places: Array) -> Array:
        """The radii [m] to which the surfaces attract each other at ``places``; the contact radii without a range."""
        return self.contact_radii(places)

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
        """The 90 % half-widths of delta [m] and P [N] at any place on the curve (linear between points)."""
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

    @cached_property
    def _critical(self) -> dict[float, tuple[CriticalPoint, ...]]:
        """The critical points known by now, by stiffness."""
        return {}

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

    @cached_property
    def _radii_at(self) -> dict[tuple[float, float], tuple[float, ...]]:
        """The places found by now, by position and stiffness."""
        return {}

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

    @cached_property
    def _work_between(self) -> tuple[Array, Array]:
        """Places of the points (n,), and the work between them (n - 1,)."""
        return np.unique(self.places), self._works(*self.places[[0, -1]])

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

    @property
    def places(self) -> Array:
        """The contact radii themselves."""
        return self.series.a

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
        return places

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
        covariance, what the radii share and what is unexplained; empty where no error is known."""
        covariance, root_w = self.slopes.covariance, math.sqrt(self.w)
        if covariance is None:
            return {}
        gradients = {name: fixed + root_w * rest for name, (fixed, rest) in self.nonadhesive.gradients.items()}
        of_rows = [np.sqrt(np.einsum("ni,nij,nj->n", each, covariance, each)) for each in gradients.values()]
        errors = self.with_shift(self.slopes.quantile * np.stack(of_rows), self._by_shift) + self._by_description
        return dict(zip(gradients, errors, strict=True))

    def with_shift(self, error: Array, shift: Array) -> Array:
        """An ``error`` of each row for itself with that of a ``shift`` of all radii: it adds where it has no middle,
        each place within it as likely as any."""
        return np.hypot(error, shift) if self.series.shift_found else error + shift

    def shift_error_at(self, place: Array) -> Array:
        """What a shift of all radii makes of delta [m] and P [N] at a ``place`` [m], (2,)."""
        return np.array([np.interp(place, self.a, values) for values in self._by_shift])

    @cached_property
    def _by_description(self) -> Array:
        """What is unexplained of the difference to the bodies described makes of delta [m] and P [N] at given radius,
        (2, n)."""
        described = self.nonadhesive.described
        if described is None:
            return np.zeros((2, self.a.size))
        other = replace(self, nonadhesive=described)
        return np.abs([other.delta - self.delta, other.P - self.P])

    @cached_property
    def _by_shift(self) -> Array:
        """What a shift of all radii makes of delta [m] and P [N] at given radius, (2, n)."""
        shift = self.series.shift
        if shift is None:
            return np.zeros((2, self.a.size))
        here, rates = self.nonadhesive.with_rates(self.a)
        t, by_bend = math.sqrt(self.w) * here.t, rates.dS / (2 * here.dS)
        delta = rates.delta_H + t * by_bend
        P = rates.P_H - rates.S * t + here.S * t * by_bend
        return np.abs([delta, P]) * shift

    def point(self, place: float) -> Equilibrium:
        """The equilibrium at a contact radius [m] within the series."""
        delta, P = self.at(np.array(place))
        return Equilibrium(place, float(delta), float(P))

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
        a = self.series.a0 + np.exp(z[:-1, None] + np.outer(np.diff(z), CURVE_LOOKED_AT)).ravel()
        errors = self.interpolation_at(a)
        if isinstance(errors, Unknown):
            return errors
        values = dict(zip(("delta", "P"), self.at(a), strict=True))
        lowest = {"delta": self.delta.min(), "P": self.P.min()}
        units = {name: np.maximum(np.abs(value), abs(lowest[name])) for name, value in values.items()}
        return float(max(np.max(errors[name] / units[name]) for name in units))

    def interpolation_at(self, a: Array) -> dict[str, Array] | Unknown:
        """Errors of "delta" [m] and "P" [N] between the points, at radii within the series; 0 at the points.

        What leaving out every second point changes in this gap or one beside, over the cube of the ratio of the gaps:
        the rule is of fourth order in the spacing, of third where its splines end; of few points nothing of the kind is
        assumed. Of the two halves of the points the one counts in which the radius lies nearer to the middle of a gap.
        """
        knots = self.nonadhesive.knots.a - self.series.a0
        if knots.size < CURVE_FEWEST:
            return Unknown(f"unknown: fewer than {CURVE_FEWEST} points")
        y = self._inside(a) - self.series.a0
        gaps, at, place = np.diff(np.log(knots)), _before(knots, y), _place_between(knots, y)
        if np.max(gaps[at]) > math.log(CURVE_WIDEST):
            return Unknown(f"unknown: neighbouring radii differ by more than a factor of {CURVE_WIDEST:g}")
        beside = np.clip(np.stack([at - 1, at, at + 1]) if self._order else at[None], 0, gaps.size - 1)
        shape = 4 * place * (1 - place) * (gaps[at] / gaps[beside]) ** self._order
        return {name: np.max(changes[beside] * shape, axis=0) for name, changes in self._gap_errors.items()}

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
    def thinning(self) -> float:
        smooth = not isinstance(self.slopes.error, Unknown) and self.slopes.error <= UNSEEN
        return 2.0**self._order if smooth else 1.0

    def _at(self, places: Array) -> tuple[Array, Array]:
        here, root_w = self.nonadhesive.parts(places), math.sqrt(self.w)
        t = root_w * here.t
        return here.delta_H - t, here.P_H - here.S * t

    def _rates(self, places: Array) -> tuple[Array, Array]:
        (here, rate), root_w = self.nonadhesive.with_rates(places), math.sqrt(self.w)
        t, dt = root_w * here.t, root_w * rate.t
        return rate.delta_H - dt, rate.P_H - here.S * dt - rate.S * t

    @cached_property
    def _samples(self) -> Array:
        x = np.log(self.a - self.series.a0)  # of a, rounding would be felt just beyond a flat end
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(CURVE_SAMPLES) / CURVE_SAMPLES
        return np.append(inner.ravel(), x[-1])

    def _place(self, x: Array) -> Array:
        return self.series.a0 + np.exp(x)

    def path(self, low: float, high: float) -> tuple[Array, Array]:
        edges = np.log(np.concatenate([[low], self.a[(self.a > low) & (self.a < high)], [high]]))
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
            f"{show(lowest.a, 'length')} "
            f"(P = {show(lowest.P, 'load')}, delta = {show(lowest.delta, 'length')}): pull-off lies outside it; "
            f"{remedy}"
        )


def _before(points: Array, x: Array) -> Array:
    """Number of the gap between the increasing ``points`` in which each ``x`` lies."""
    return np.clip(np.searchsorted(points, x, side="right"), 1, points.size - 1) - 1


def _place_between(points: Array, x: Array) -> Array:
    """Place of each ``x`` between the increasing ``points`` on both sides of it, in logarithms, from 0 to 1."""
    at = _before(points, x)
    return np.clip(np.log(x / points[at]) / np.log(points[at + 1] / points[at]), 0.0, 1.0)


# --------------------------------------------------------------------------------------------------
# Contacts too small or too hard pressed for the theory: pull-off at radii below atoms, pressures that bodies yield
# to.
#
# A cone has no length of its own, so that JKR theory goes on to any radius: a stiff one loses contact at picometres.

# When a contact is no longer one of an elastic continuum.
SHARP_NEAR = 3.0  # choice: distances of atoms z0 within which the end of a series is as good as pull-off itself
SHARP_PRESSURE = 0.1  # theory: of E*, the order of the ideal strength; hardness is less (Johnson 1985, ch. 6)
SHARP_STIFF = 1e8  # choice: Pa; gels and rubbers below it stretch instead of flowing


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


def yield_warning(problem: Problem, curve: EquilibriumCurve) -> list[str]:
    """A warning where the mean pressure at the largest radius is one at which stiff bodies yield; confined layers,
    whose pressure is hydrostatic, and gels are left out."""
    a, P = float(curve.series.a[-1]), float(curve.series.P[-1])
    mean = P / (math.pi * a**2 * problem.E_star)
    confined = a > (problem.specimen.top_thickness or math.inf)
    if mean <= SHARP_PRESSURE or problem.E_star < SHARP_STIFF or confined:
        return []
    return [
        f"mean pressure {mean:.2g} E* at the largest contact radius is above "
        f"{SHARP_PRESSURE:g} E*: most materials of "
        "that stiffness flow plastically first, and the contact is then larger than an elastic one"
    ]

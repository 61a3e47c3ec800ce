"""Pull-off from a viscoelastic specimen by its history: very fast and very slow cycles, and pulled at once from rest.

All moduli relax by one function r(t), from E0 to rho E0. At rest, relaxed, at the displacement delta0 the contact has
the radius a_s of Eq. 13 with the moduli rho E0. Pulled from there so fast that nothing relaxes, the specimen answers
with E0 to changes and keeps the share 1 - rho of its dent: within a_s that is elastic contact of E0 under the profile
rho f. With delta_H, P_H, S, S' of the moduli E0,

    delta = (1 - rho) delta0 + rho delta_H - sqrt(4 pi w a/S'),   P = rho P_H - S sqrt(4 pi w a/S'),   a <= a_s,

which is Eq. 13 of the relaxed moduli with w/rho (Schapery, Int. J. Fract. 39 (1989) 163, has that apparent work of
adhesion), cut at the radius of rest. At a_s contact keeps its radius, dP = S d(delta), until the energy release rate
has risen from rho w to w. Where the history is not known, the fold of the curve that is not cut is the largest force.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from ..adhesion.curve import (
    DISPLACEMENT_CONTROL,
    LOAD_CONTROL,
    AdhesiveCurve,
    CriticalPoint,
    Equilibrium,
    EquilibriumCurve,
    Nonadhesive,
    position,
)
from ..adhesion.pull_off_error import Errors, gradients_at, pull_off_error
from ..adhesion.slopes import Slopes
from ..adhesion.validity import LIMITS, Strains, large_strains
from ..adhesion.work_of_pull_off import FoundWork, Pull, work_from_pull_off
from ..base.errors import Estimate, InputError, Unknown
from ..base.numerics import SAME, Array
from ..base.units import show
from ..bodies.problem import Problem, Relaxation
from ..series import Series

FAST, SLOW, FROM_REST, AT_MOST = "very fast", "very slow", "from rest", "at most"


@dataclass(frozen=True)
class Rest:
    """How the contact is held until the specimen has relaxed: under a ``load`` [N], or at a ``depth`` delta0 [m]."""

    load: float = 0.0
    depth: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("load", self.load), ("depth", self.depth)):
            if value is not None and not math.isfinite(value):
                raise InputError(f"rest: the {name} must be finite, got {value:g}")

    @classmethod
    def of(cls, load: float | None, depth: float | None, called: Callable[[str], str] = str) -> Rest | None:
        """The rest under a ``load`` [N] or at a ``depth`` [m]; None where neither is given, InputError where both
        are."""
        if load is not None and depth is not None:
            raise InputError(f"give at most one of {called('rest_load')} and {called('rest_depth')}")
        if depth is not None:
            return cls(depth=depth)
        return None if load is None else cls(load)

    @property
    def suffix(self) -> str:
        """What distinguishes names of files."""
        return f"-rest-load{self.load:g}" if self.depth is None else f"-rest-depth{self.depth:g}"

    @property
    def words(self) -> str:
        """``P = 0`` or ``delta = 57 um``."""
        if self.depth is not None:
            return f"delta = {show(self.depth, 'length') if self.depth else 0}"
        return f"P = {show(self.load, 'load') if self.load else 0}"

    @property
    def _held(self) -> tuple[float, float]:
        """The stiffness of the device that holds it, and its position."""
        return (LOAD_CONTROL, self.load) if self.depth is None else (DISPLACEMENT_CONTROL, self.depth)

    def ends_too_soon(self, relaxed: AdhesiveCurve) -> bool:
        """Whether the series of the ``relaxed`` specimen ends before its contact at rest."""
        held, value = self._held
        return float(position(relaxed.delta[-1], relaxed.P[-1], held)) < value

    def state(self, relaxed: AdhesiveCurve) -> Equilibrium | Unknown:
        """The stable contact of the ``relaxed`` specimen."""
        held, value = self._held
        stable = [a for a in relaxed.radii_at(value, held) if position(*relaxed.rates(np.array(a)), held) > 0]
        if stable:
            state = relaxed.point(stable[-1])
            return replace(state, P=self.load) if self.depth is None else replace(state, delta=self.depth)
        if self.ends_too_soon(relaxed):
            return Unknown(
                f"at rest at {self.words} the relaxed contact is larger than the largest radius of the solution, a = "
                f"{show(float(relaxed.a[-1]), 'length')}: increase [loading] radius"
            )
        lost = relaxed.pull_off(held)
        end = (
            ""
            if isinstance(lost, Unknown)
            else f": the relaxed contact is lost at P = {show(lost.P, 'load')}, "
            + (f"delta = {show(lost.delta, 'length')}")
        )
        return Unknown(f"no contact rests at {self.words}{end}")


@dataclass(frozen=True, eq=False)
class FromRest(EquilibriumCurve):
    """The equilibria after ``rest``, while nothing relaxes: ``whole``, of the moduli at t = 0 under the profile times
    ``ratio``, up to the radius of rest; delta counts from (1 - ratio) delta0, the dent that is kept."""

    whole: AdhesiveCurve
    ratio: float
    rest: Equilibrium

    @property
    def w(self) -> float:
        return self.whole.w

    @property
    def series(self) -> Series:
        return self.whole.series

    @property
    def slopes(self) -> Slopes:
        return self.whole.slopes

    @property
    def nonadhesive(self) -> Nonadhesive:
        """The w-free functions under the profile that is left."""
        return self.whole.nonadhesive

    @property
    def onset(self) -> float:
        return (1 - self.ratio) * self.rest.delta

    @cached_property
    def a(self) -> Array:
        rows = self.series.a
        return np.append(rows[rows < self.rest.a * (1 - SAME)], self.rest.a)

    @property
    def places(self) -> Array:
        return self.a

    @cached_property
    def delta(self) -> Array:
        return self._at(self.a)[0]

    @cached_property
    def P(self) -> Array:
        return self._at(self.a)[1]

    @property
    def interpolation_error(self) -> Estimate:
        return self.whole.interpolation_error

    @property
    def thinning(self) -> float:
        return self.whole.thinning

    def thinned(self, first: int) -> Self:
        return replace(self, whole=self.whole.thinned(first))

    @cached_property
    def errors(self) -> Mapping[str, Array]:
        return {name: np.interp(self.a, self.whole.a, values) for name, values in self.whole.errors.items()}

    @property
    def columns(self) -> dict[str, Array]:
        return {"a_m": self.a, "delta_m": self.delta, "P_N": self.P}

    def point(self, place: float) -> Equilibrium:
        there = self.whole.point(place)
        return replace(there, delta=there.delta + self.onset)

    def contact_radii(self, places: Array) -> Array:
        return places

    @cached_property
    def _joints(self) -> Array:
        joints = self.whole._joints
        return np.append(joints[joints < self.rest.a], self.rest.a)

    def path(self, low: float, high: float) -> tuple[Array, Array]:
        return self.whole.path(low, high)

    def _at(self, places: Array) -> tuple[Array, Array]:
        delta, P = self.whole.at(places)
        return delta + self.onset, P

    def _rates(self, places: Array) -> tuple[Array, Array]:
        return self.whole.rates(places)

    @cached_property
    def _samples(self) -> Array:
        x, end = self.whole._samples, math.log(self.rest.a - self.series.a0)
        return np.append(x[x < end], end)

    def _place(self, x: Array) -> Array:
        return self.whole._place(x)

    def _outside(self, stiffness: float, end: str, lowest: Equilibrium) -> str:
        return self.whole._outside(stiffness, end, lowest)

    def pull_off(self, stiffness: float) -> CriticalPoint | Unknown:
        """Where contact is lost: the lowest minimum, or the radius of rest, at which a flat end lets go."""

        def held(point: Equilibrium) -> float:
            return float(position(point.delta, point.P, stiffness))

        minima = [point for point in self.critical(stiffness) if point.kind == "minimum"]
        lowest = min([*minima, CriticalPoint(**vars(self.point(self.rest.a)))], key=held)
        first = self.point(float(self.places[0]))
        return Unknown(self._outside(stiffness, "smallest", first)) if held(first) < held(lowest) else lowest


@dataclass(frozen=True)
class LoadingHistory(Pull):
    """A loading history that a viscoelastic specimen had before it is pulled, after which adhesion is known in closed
    form.

    The curve is that of the moduli at t = 0 times ``moduli`` under the profile times ``profile``; ``rest``: where it is
    cut.
    """

    name: str
    words: str
    moduli: float = 1.0
    profile: float = 1.0
    rest: Rest | None = None

    def body(self, unit: Nonadhesive) -> Nonadhesive:
        """The w-free functions; ``unit``: those of the moduli at t = 0."""
        return _changed(unit, self.moduli, self.profile)

    def relaxed(self, unit: Nonadhesive, w: float) -> AdhesiveCurve:
        """The curve on which the contact rests."""
        return AdhesiveCurve(_changed(unit, self.profile, 1.0), w)

    def curve(self, unit: Nonadhesive, w: float) -> AdhesiveCurve | FromRest | Unknown:
        """The curve of equilibria for the work of adhesion ``w`` [J/m^2]; Unknown where it has no rest."""
        whole = AdhesiveCurve(self.body(unit), w)
        if self.rest is None:
            return whole
        state = self.rest.state(self.relaxed(unit, w))
        return state if isinstance(state, Unknown) else FromRest(whole, self.profile, state)

    def ends_too_soon(self, unit: Nonadhesive, w: float) -> bool:
        """Whether the series ends before the contact at rest, or before the fold of a curve that is not cut."""
        if self.rest is not None:
            return self.rest.ends_too_soon(self.relaxed(unit, w))
        _, P = AdhesiveCurve(self.body(unit), w).rates(unit.a[-1:])
        return bool(P[0] <= 0)

    def work(self, unit: Nonadhesive, load: float, stiffness: float, R: float | None = None) -> FoundWork:
        return work_from_pull_off(self.body(unit), load, stiffness, R, lambda w: self.curve(unit, w))

    def radii(self, unit: Nonadhesive, w: float, controls: Sequence[float]) -> list[float]:
        curve = self.curve(unit, w)
        return super().radii(unit, w, controls) + ([curve.rest.a] if isinstance(curve, FromRest) else [])

    def error(
        self, unit: Nonadhesive, curve: EquilibriumCurve, point: CriticalPoint, stiffness: float
    ) -> Errors | Unknown:
        if not isinstance(curve, FromRest):
            return super().error(unit, curve, point, stiffness)
        moved = _of_rest(self, unit, curve)
        if isinstance(moved, Unknown):
            return moved
        at_rest, of_dent = moved
        if point.a >= curve.rest.a * (1 - SAME):
            return at_rest
        inside = pull_off_error(curve.whole, replace(point, delta=point.delta - curve.onset), stiffness)
        return inside if isinstance(inside, Unknown) else {"delta": inside["delta"] + of_dent, "P": inside["P"]}

    def strains(self, problem: Problem, w: float, point: CriticalPoint, loaded: bool) -> Strains:
        """Those of the force; not known of a dent that is kept."""
        R = problem.indenter.tip_radius
        if self.profile == 1:
            return large_strains(problem.scaled(self.moduli), w, point, loaded)
        if R is None or point.a <= LIMITS.strained * R:
            return None
        return Unknown(f"not estimated, a/R = {point.a / R:.2g} at pull-off")


@lru_cache(maxsize=4)
def _changed(unit: Nonadhesive, moduli: float, profile: float) -> Nonadhesive:
    """The functions with other moduli and another profile, whose interpolants serve every w."""
    return unit.scaled(moduli).under_profile(profile)


def histories(law: Relaxation, rest: Rest) -> tuple[LoadingHistory, ...] | Unknown:
    """The histories for which adhesion on a viscoelastic specimen by ``law`` is known, with that from ``rest``; very
    fast cycles alone where the relaxed modulus is zero."""
    ratio = law.relaxed
    if ratio is None:
        return Unknown("a power law has neither an instant nor a relaxed modulus; give the law sls or prony")
    fast = LoadingHistory(FAST, "very fast cycle, the moduli at t = 0")
    if not ratio > 0:  # nothing is at rest
        return (fast,)
    return (
        fast,
        LoadingHistory(SLOW, f"very slow cycle, the moduli times {ratio:.4g}", moduli=ratio),
        LoadingHistory(FROM_REST, f"at rest at {rest.words}, then pulled instantly", profile=ratio, rest=rest),
        LoadingHistory(AT_MOST, "any other history", profile=ratio),
    )


def _of_rest(history: LoadingHistory, unit: Nonadhesive, curve: FromRest) -> tuple[Errors, float] | Unknown:
    """Half-widths of delta and P where contact is pulled at the radius of rest, and that of the dent (1 - rho) delta0.

    First order in the columns c = (delta_H, P_H, S, S') of the moduli at t = 0: the radius of rest moves by da = -
    (dX/dc) dc/(dX/da) of the relaxed curve, X being what is held there, and the frozen curve's values with it.
    """
    assert history.rest is not None
    ratio, a = curve.ratio, np.array(curve.rest.a)
    relaxed, whole = history.relaxed(unit, curve.w), curve.whole
    between = [one.interpolation_at(a) for one in (relaxed, whole)]
    covariance = _covariance(unit, curve.rest.a)
    for unknown in (*between, covariance):
        if isinstance(unknown, Unknown):
            return unknown
    slow = np.stack(gradients_at(relaxed, a)) * [1.0, ratio, ratio, ratio]
    fast = np.stack(gradients_at(whole, a)) * [ratio, ratio, 1.0, 1.0]
    held = 1 if history.rest.depth is None else 0  # P, or delta
    slow_rates, fast_rates = (np.array([float(rate) for rate in one.rates(a)]) for one in (relaxed, whole))
    da = -slow[held] / slow_rates[held]
    dent = (1 - ratio) * (slow[0] + slow_rates[0] * da)
    moved = fast + fast_rates[:, None] * da
    moved[0] += dent

    def width(gradient: Array) -> float:
        return unit.slopes.quantile * math.sqrt(max(float(gradient @ covariance @ gradient), 0.0))

    gaps = [np.array([float(one[name]) for name in ("delta", "P")]) for one in between if not isinstance(one, Unknown)]
    by_gaps = gaps[1] + np.abs(fast_rates / slow_rates[held]) * gaps[0][held]
    delta, P = (width(moved[i]) + float(by_gaps[i]) for i in (0, 1))
    return {"delta": delta, "P": P}, width(dent) + (1 - ratio) * float(gaps[0][0])


def _covariance(unit: Nonadhesive, a: float) -> Array | Unknown:
    """Covariance (4, 4) of the columns at the radius ``a`` [m]: of what was solved there, else of the rows beside."""
    further, slopes = unit.further, unit.slopes
    if further is not None and further.slopes.joint is not None:
        nearest = int(np.argmin(np.abs(further.a - a)))
        joint: Array = further.slopes.joint[nearest, :4, :4]
        if abs(further.a[nearest] - a) <= SAME * (a - unit.series.a0):
            return joint
    if slopes.covariance is None:
        return Unknown(f"unknown: {slopes.error}")
    return unit.between(slopes.covariance, np.array(a))

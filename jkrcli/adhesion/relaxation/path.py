"""The history of a contact that relaxes: it grows, shrinks, is lost. It is made of the nonadhesive contact over its
depth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base import SAME, Array, InputError, PiecewiseCubic, show, zeros_between
from ...bodies import Modes
from ..nonadhesive import Nonadhesive
from .memory import Steps


@dataclass(frozen=True)
class PathTuning:
    """Accuracy of a history."""

    first: float = 1e-6  # theory: of the largest depth; the load there, 1e-9 of the largest, is interpolated to 1e-2
    ratio: float = 1.4  # theory: of depths from step to step; depth^1.5 is interpolated to 1e-11 of itself
    degree: int = 6  # theory: of the load over a step, see ``ratio``
    places: float = 1e-12  # theory: of a step, round-off
    below: float = 60.0  # theory: of log depth below the first row, down to a depth of 1e-26 of that row's
    intervals: int = 100  # choice: of the way back at least, over which its work is integrated; leaves 1e-8


TUNING = PathTuning()
PLACES = (1 - np.cos(np.pi * np.arange(TUNING.degree + 1) / TUNING.degree)) / 2  # theory: of Chebyshev and Lobatto
POWERS = np.linalg.inv(np.vander(PLACES, increasing=True)).T  # from values at the places to a polynomial
AGAIN = (
    "is loaded again before its dent recovers, which is not solved: retract without a stop, at a speed that does not "
    "fall, and end the program where contact is lost"
)


@dataclass(frozen=True, eq=False)
class Depths:
    """P_H, S and the radius of ``body`` over delta_H, with dP_H = S d(delta_H) between the rows too; below the first
    row a power law of its slope."""

    body: Nonadhesive

    @cached_property
    def curve(self) -> PiecewiseCubic:
        """log P_H and log(a - a0) over log delta_H."""
        z = self.body.logs.columns.x
        values, slopes = (self.body.logs.columns(z, order) for order in (0, 1))
        x, by_x = values[:, 0], np.stack([slopes[:, 1], np.ones_like(z)], 1) / slopes[:, :1]
        y = np.stack([values[:, 1], z], 1)
        ends = np.array([x[0] - TUNING.below]), y[:1] - TUNING.below * by_x[:1], by_x[:1]
        return PiecewiseCubic(*(np.concatenate(pair) for pair in zip(ends, (x, y, by_x), strict=True)))

    @property
    def least(self) -> float:
        return float(np.exp(self.curve.x[0]))

    @property
    def most(self) -> float:
        """The depth [m] at the end of the series."""
        return float(np.exp(self.curve.x[-1]))

    def loads(self, depth: Array) -> Array:
        """P_H [N] at depths >= 0 [m]."""
        return np.where(depth > 0, np.exp(self.curve(self._log(depth))[..., 0]), 0.0)

    def with_slopes(self, depth: Array) -> tuple[Array, Array]:
        """P_H [N] and S [N/m] at depths > 0 [m]."""
        x = self._log(depth)
        P = np.exp(self.curve(x)[..., 0])
        return P, P / np.exp(x) * self.curve(x, 1)[..., 0]

    def radii(self, depth: Array) -> Array:
        """Contact radii [m] at depths >= 0 [m]."""
        return np.where(depth > 0, self.body.series.a0 + np.exp(self.curve(self._log(depth))[..., 1]), 0.0)

    def _log(self, depth: Array) -> Array:
        return np.log(np.maximum(depth, self.least))


@dataclass(frozen=True, eq=False)
class RelaxedPath:
    """A contact over time: ``depth`` delta of the device's tip from first contact on, and ``load``: P_H, what it would
    bear without relaxation, in the same steps while it grows. ``lost``: when contact is lost [s]; infinite where it is
    not. ``grows``: of the largest depth, by which the contact may grow again before that is refused."""

    depths: Depths
    depth: Steps
    load: Steps
    lost: float = math.inf
    grows: float = SAME

    @property
    def deepest(self) -> float:
        """The depth [m] at which the contact stops to grow."""
        return float(self.depth.values(np.array([self.last]))[0])

    @property
    def begin(self) -> float:
        """The time of first contact [s]."""
        return float(self.depth.t[0])

    @property
    def last(self) -> float:
        """The place at which the contact stops to grow."""
        return float(self.load.t.size - 1)

    @property
    def turn(self) -> float:
        """The time [s] at which it does."""
        return float(self.load.t[-1])

    def marks(self, t: Array) -> Array:
        """The place, of the time t1, at which the contact grew through the radius that it has at the rising times ``t``
        in contact: int r(t - s) d(delta)(s) from t1 to t is 0."""
        marks, later = self.depth.places(t), t > self.turn
        if later.any():
            now, places = t[later], marks[later]
            integral, steps = self.depth.integral(places, now), self.depth.integrals_to_ends(now)
            low = np.clip(np.sum(steps[:, : int(self.last) + 1] < integral[:, None], axis=1) - 1.0, 0.0, self.last - 1)
            marks[later] = zeros_between(
                lambda place: integral - self.depth.integral(place, now), low, low + 1, TUNING.places
            )
            self._check(now, marks[later])
        return marks

    def _check(self, t: Array, places: Array) -> None:
        rises = np.flatnonzero(np.diff(self.depth.values(places)) > self.grows * self.depths.most)
        if rises.size:
            raise InputError(f"program: at t = {show(float(t[rises[0] + 1]), 'time')} the contact {AGAIN}")

    def place_at(self, depth: Array) -> Array:
        """The places at which the contact grew through depths [m] (n,)."""
        places, depths = self._inner
        k = np.clip(np.searchsorted(depths, depth) - 1, 0, depths.size - 2)
        return zeros_between(lambda place: self.depth.values(place) - depth, places[k], places[k + 1], TUNING.places)

    @cached_property
    def _inner(self) -> tuple[Array, Array]:
        """Places of the growth, several to a step, and the depths [m] there."""
        places = np.append(np.add.outer(np.arange(self.last), PLACES[:-1]).ravel(), self.last)
        return places, np.maximum.accumulate(self.depth.values(places))

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """a [m], delta [m], P [N] at the rising times ``t`` [s] (n,) from first contact on; a = P = 0 where it is
        lost."""
        a, P, contact = np.zeros_like(t), np.zeros_like(t), t < self.lost
        places = self.marks(t[contact])
        a[contact], P[contact] = self.depths.radii(self.depth.values(places)), self.load.integral(places, t[contact])
        return a, self.depth.values(self.depth.places(t)), P


def depth_controlled(
    depths: Depths, modes: Modes, t: Array, x: Array, ratio: float = TUNING.ratio, grows: float = SAME
) -> RelaxedPath:  # fmt: skip
    """The path under depths ``x`` [m] at the times ``t`` [s], linear between, from 0 on; ``ratio`` of depths from step
    to step; ``grows``: see ``RelaxedPath``."""
    falls = np.flatnonzero(np.diff(x) < 0)
    top = int(falls[0]) if falls.size else t.size - 1
    grown, deep = finer(t[: top + 1], x[: top + 1], ratio)
    load = Steps(modes, grown, depths.loads(deep[:-1, None] + np.diff(deep)[:, None] * PLACES) @ POWERS)
    t, x = np.append(grown, t[top + 1 :]), np.append(deep, x[top + 1 :])
    depth = Steps(modes, t, np.stack([x[:-1], np.diff(x)], 1))
    return RelaxedPath(depths, depth, load, _lost(depth, grown.size - 1), grows)


def finer(t: Array, x: Array, ratio: float) -> tuple[Array, Array]:
    """Depths ``x`` that never fall, and their times, with more between them, so that none is more than ``ratio``
    times the one before."""
    count = math.ceil(math.log(1 / TUNING.first) / math.log(ratio))
    levels = x[-1] * ratio ** -np.arange(1.0, count + 1)
    after = np.searchsorted(x, levels)
    part = (levels - x[after - 1]) / (x[after] - x[after - 1])
    order = np.argsort(np.append(np.arange(x.size), after - 1 + part), kind="stable")
    return np.append(t, t[after - 1] + part * (t[after] - t[after - 1]))[order], np.append(x, levels)[order]


def _lost(depth: Steps, turn: int) -> float:
    """When contact is lost [s], in the steps behind the place ``turn``: where the surface alone would be there."""
    places = np.arange(turn, depth.t.size)
    left = depth.integral(places, depth.t[places])
    gone = np.flatnonzero(left <= 0)
    if not gone.size:
        return math.inf
    if (back := np.flatnonzero(left[gone[0] :] > 0)).size:
        raise InputError(
            f"program: at t = {show(float(depth.t[places[gone[0] + back[0]]]), 'time')} the contact {AGAIN}"
        )
    end = places[gone[:1]].astype(float)
    place = zeros_between(lambda place: depth.integral(place, depth.times(place)), end - 1, end, 0.0)
    return float(depth.times(place)[0])

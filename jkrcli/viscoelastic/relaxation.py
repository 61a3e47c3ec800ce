"""Contact of viscoelastic bodies, without adhesion: E(t) = E r(t), one function for all layers, constant nu.

The pressure is a sum of flat ends. Inside every smaller radius a flat end moves the surface rigidly, on any body, so
that only the last one matters (Ting, J. Appl. Mech. 33 (1966) 845; here for layers, gradings, cylinders, any tip).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, Nonadhesive, control, position
from ..adhesion.device_path import Program, TimedState
from ..base import numerics
from ..base.errors import NOTICEABLE, Estimate, InputError, SolveError, Unknown
from ..base.numerics import SAME, Array
from ..base.units import show
from ..bodies.problem import Modes, Relaxation

# --------------------------------------------------------------------------------------------------
# What a sum of exponentials remembers of a quantity that is a polynomial of time from step to step.

# How moments of exponentials are computed.
MOMENT_LARGE = 2.0  # theory: exponent from which the recursion upwards, of up to seven steps, loses one digit
# theory: terms of the recursion downwards below an exponent, 2^22/22! = 4e-15 of its begin is left at the end
MOMENT_TERMS = ((1e-3, 5), (MOMENT_LARGE, 22))


def moments(x: Array, count: int) -> Array:
    """int_0^1 exp(-x (1 - y)) y^j dy at ``x`` >= 0 of any shape, for j < ``count``, (count, ...)."""
    if count == 1:
        return np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0)[None]
    values, least = np.empty((count, *x.shape)), -1.0
    for most, terms in MOMENT_TERMS:  # by the recursion downwards from so many terms beyond them
        band, least = (x > least) & (x <= most), most
        inner = x[band]
        below = np.full_like(inner, 1.0 / (count + terms + 1))
        for j in range(count + terms, 0, -1):
            below = (1 - inner * below) / j
            if j <= count:
                values[j - 1, band] = below
    large = x > least
    beyond = x[large]
    above = -np.expm1(-beyond) / beyond
    for j in range(count):
        values[j, large] = above
        above = (1 - (j + 1) * above) / beyond
    return values


def remembered(p: Array, x: Array) -> Array:
    """int_0^1 exp(-x (1 - y)) dp(y) of polynomials, ``p`` (..., n) of rising powers of y, at ``x`` (..., m)."""
    by_power = moments(x, p.shape[-1] - 1)
    return np.asarray(sum((j + 1) * p[..., j + 1, None] * moment for j, moment in enumerate(by_power)))


@dataclass(frozen=True, eq=False)
class Steps:
    """A quantity q over time: in step k, from ``t[k]`` to ``t[k + 1]`` [s], the polynomial ``p[k]`` (n) of its fraction
    y; equal times are a jump. ``modes``: what remembers it, from ``t[0]`` on, where q is 0. A place is k + y."""

    modes: Modes
    t: Array
    p: Array

    @cached_property
    def states(self) -> Array:
        """int exp(-rate (t - s)) dq(s) at all times ``t``, (times, m)."""
        x = np.diff(self.t)[:, None] * self.modes.rates
        states = [np.zeros(x.shape[1])]
        for factor, gain in zip(np.exp(-x), remembered(self.p, x), strict=True):
            states.append(factor * states[-1] + gain)
        return np.array(states)

    def places(self, t: Array) -> Array:
        """The places of times ``t``, behind a jump."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, self.t.size - 2)
        h, since = self.t[k + 1] - self.t[k], t - self.t[k]
        return k + np.clip(np.divide(since, h, out=np.ones_like(since), where=h > 0), 0.0, 1.0)

    def times(self, places: Array) -> Array:
        """The times [s] of ``places`` (n,)."""
        k, since, _ = self.parts(places)
        return self.t[k] + since

    def parts(self, places: Array) -> tuple[Array, Array, Array]:
        """The step of each of the ``places`` (n,), the time since its begin, and the polynomial of that time's
        fractions."""
        k = np.clip(places.astype(int), 0, self.t.size - 2)
        y = places - k
        return k, y * (self.t[k + 1] - self.t[k]), self.p[k] * y[:, None] ** np.arange(self.p.shape[1])

    def values(self, places: Array) -> Array:
        """q at ``places`` (n,)."""
        return self.parts(places)[2].sum(axis=1)

    def rates(self, places: Array) -> Array:
        """Derivative of q by the place, at ``places`` (n,)."""
        k, powers = np.clip(places.astype(int), 0, self.t.size - 2), np.arange(1, self.p.shape[1])
        return ((places - k)[:, None] ** (powers - 1) * (powers * self.p[k, 1:])).sum(axis=1)

    def integrals_to_ends(self, now: Array) -> Array:
        """The ``integral`` up to all times ``t`` seen from the times ``now`` [s] behind them, (now, times)."""
        since = np.maximum(now[:, None] - self.t, 0.0)
        values = np.append(self.p[:, 0], self.p[-1].sum())
        integrals = self.modes.relaxed * values + np.zeros_like(since)
        for weight, rate, state in zip(self.modes.weights, self.modes.rates, self.states.T, strict=True):
            integrals += weight * state * np.exp(-rate * since)
        return integrals

    def integral(self, places: Array, now: Array) -> Array:
        """The hereditary integral int r(now - s) dq(s) up to ``places`` (n,), seen from the times ``now`` [s] there or
        later."""
        return self.view(places, now).integral(self)

    def view(self, places: Array, now: Array) -> View:
        """What the ``integral`` needs of ``places`` and times alone."""
        k, since, _ = self.parts(places)
        x, modes = since[:, None] * self.modes.rates, self.modes
        weights = modes.weights * np.exp(-np.maximum(now - self.t[k] - since, 0.0)[:, None] * modes.rates)
        return View(k, places - k, weights, weights * np.exp(-x), moments(x, self.p.shape[1] - 1))


class View(NamedTuple):
    """Places in steps seen from later times: the steps ``k`` (n,) and fractions ``y`` (n,); ``weights`` of the modes,
    those of what was remembered at the steps' begins, (n, m), and the ``moments`` of these modes, (j, n, m)."""

    k: Array
    y: Array
    weights: Array
    of_states: Array
    moments: Array

    def integral(self, of: Steps) -> Array:
        """int r dq of a quantity in the same steps, of the same degree or less."""
        p = of.p[self.k] * self.y[:, None] ** np.arange(of.p.shape[1])
        grown = np.zeros_like(self.weights)
        for j, moment in enumerate(self.moments[: p.shape[1] - 1]):
            grown += (j + 1) * p[:, j + 1, None] * moment
        seen = np.sum(self.of_states * of.states[self.k] + self.weights * grown, axis=1)
        return of.modes.relaxed * p.sum(axis=1) + seen


# --------------------------------------------------------------------------------------------------
# The history of a contact that relaxes: it grows, shrinks, is lost. It is made of the nonadhesive contact over its
# depth.

# Accuracy of a history.
PATH_FIRST = 1e-6  # theory: of the largest depth; the load there, 1e-9 of the largest, is interpolated to 1e-2
PATH_RATIO = 1.4  # theory: of depths from step to step; depth^1.5 is interpolated to 1e-11 of itself
PATH_DEGREE = 6  # theory: of the load over a step, see ``ratio``
PATH_PLACES = 1e-12  # theory: of a step, round-off
PATH_BELOW = 60.0  # theory: of log depth below the first row, down to a depth of 1e-26 of that row's
PATH_INTERVALS = 100  # choice: of the way back at least, over which its work is integrated; leaves 1e-8


PLACES = (1 - np.cos(np.pi * np.arange(PATH_DEGREE + 1) / PATH_DEGREE)) / 2  # theory: of Chebyshev and Lobatto
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
    def curve(self) -> numerics.PiecewiseCubic:
        """log P_H and log(a - a0) over log delta_H."""
        z = self.body.logs.columns.x
        values, slopes = (self.body.logs.columns(z, order) for order in (0, 1))
        x, by_x = values[:, 0], np.stack([slopes[:, 1], np.ones_like(z)], 1) / slopes[:, :1]
        y = np.stack([values[:, 1], z], 1)
        ends = np.array([x[0] - PATH_BELOW]), y[:1] - PATH_BELOW * by_x[:1], by_x[:1]
        return numerics.PiecewiseCubic(*(np.concatenate(pair) for pair in zip(ends, (x, y, by_x), strict=True)))

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
            marks[later] = numerics.zeros_between(
                lambda place: integral - self.depth.integral(place, now), low, low + 1, PATH_PLACES
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
        return numerics.zeros_between(
            lambda place: self.depth.values(place) - depth, places[k], places[k + 1], PATH_PLACES
        )

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
    depths: Depths, modes: Modes, t: Array, x: Array, ratio: float = PATH_RATIO, grows: float = SAME
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
    count = math.ceil(math.log(1 / PATH_FIRST) / math.log(ratio))
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
    place = numerics.zeros_between(lambda place: depth.integral(place, depth.times(place)), end - 1, end, 0.0)
    return float(depth.times(place)[0])


# --------------------------------------------------------------------------------------------------
# A contact that relaxes in a device that does not prescribe its depth: a spring, or a load.
#
# position(delta, P) = x(t), with P and delta bound by the same sums as at a given depth, is an integral equation for
# delta(t); it is solved by collocation, in many steps at once, which grow after each corner of the program.

INNER = PLACES[1:]
DEGREE = INNER.size

# Steps in time, and how they are solved.
DRIVEN_FIRST = 1e-8  # choice: of a piece of the program, the first step after its corner
# of parts after a corner from step to step; tuned on histories, by `make constants`: twice as much moves loads by
# five stated errors
DRIVEN_RATIO = 1.5
DRIVEN_LAST = 1e-5  # choice: the same of the step in which contact is lost, of which it may be a power 2/3
# steps solved at once; tuned on relaxing bodies, by `make constants`: half cost 1.04 times, twice 1.25 times the
# seconds
DRIVEN_TOGETHER = 24
DRIVEN_CONVERGED = 1e-7  # theory: relative, of what Newton's last step is the square root
DRIVEN_FALLS = 1e-10  # theory: of the depth, what is no round-off
DRIVEN_NEAR = 2.0  # choice: of a step, how far at least it is to end before contact is lost; leaves 1e-7
DRIVEN_FAR = 2.0  # tuned on relaxing bodies, by `make constants`: guard, of the log depth in an iteration


class Run(NamedTuple):
    """Solved steps: their ``ends`` (n,) [s], equal in a jump; at their places (n, 7), from the begin on, ``depth`` of
    the tip and ``contact``, the depth [m] at which the contact grew through its radius, and ``load`` P_H [N] while it
    grows."""

    ends: Array
    depth: Array
    contact: Array
    load: Array

    def first(self, count: int) -> Run:
        """The first steps."""
        return Run(*(column[:count] for column in self))


class Now(NamedTuple):
    """A state between two steps: time [s], depth and contact [m], load P_H [N]; what is remembered of both."""

    t: float
    depth: float
    contact: float
    load: float
    of_depth: Array
    of_load: Array


Taken: TypeAlias = list[tuple[Now, Run]]  # steps that were taken, each one a run, with the state before it


# Lengths (n,) [s] of steps in a piece of a program, and the device's positions at their inner places (6 n,)
DeviceSteps: TypeAlias = tuple[Array, Array]
# Steps, and polynomials (n, 7) of their fractions that are positive up to the end of what happens; None: not found
Solver: TypeAlias = Callable[[Now, DeviceSteps], tuple[Run, Array] | None]


@dataclass(frozen=True, eq=False)
class Kernel:
    """int r(t - s) dq(s) at the inner places of steps of ``h`` (n,) [s], one after the other: ``seen`` of what is
    remembered at their begin, and ``matrix`` times q there and at all these places."""

    modes: Modes
    h: Array

    @cached_property
    def since(self) -> Array:
        """Times [s] since the begin (6 n,)."""
        return (np.cumsum(self.h)[:, None] - np.multiply.outer(self.h, 1 - INNER)).ravel()

    @cached_property
    def gains(self) -> Array:
        """What is remembered at the end of each step of the values at its places, (n, m, 7)."""
        by_power = moments(np.multiply.outer(self.h, self.modes.rates), DEGREE)
        return np.stack([0 * by_power[0], *((j + 1) * x for j, x in enumerate(by_power))], -1) @ POWERS.T

    def seen(self, memory: Array) -> Array:
        return np.exp(-np.multiply.outer(self.since, self.modes.rates)) @ (self.modes.weights * memory)

    @cached_property
    def matrix(self) -> Array:
        modes, n = self.modes, self.h.size
        by_power = moments(np.multiply.outer(np.multiply.outer(self.h, INNER), modes.rates), DEGREE)
        own = np.stack(
            [0 * self.since.reshape(n, -1), *((j + 1) * x @ modes.weights for j, x in enumerate(by_power))], -1
        )
        own = (own * INNER[:, None] ** np.arange(DEGREE + 1)) @ POWERS.T
        whole = np.eye(n * DEGREE, n * DEGREE + 1, 1) * modes.relaxed
        for k, end in enumerate(np.cumsum(self.h)):
            rows, columns = DEGREE * k, slice(DEGREE * k, DEGREE * (k + 1) + 1)
            whole[rows : rows + DEGREE, columns] += own[k]
            later = np.exp(-np.multiply.outer(self.since[rows + DEGREE :] - end, modes.rates))
            whole[rows + DEGREE :, columns] += (later * modes.weights) @ self.gains[k]
        return whole

    def after(self, memory: Array, values: Array) -> Iterator[Array]:
        """What is remembered at the end of each of as many steps as there are ``values`` (k, 7) of."""
        for x, gain, row in zip(np.multiply.outer(self.h, self.modes.rates), self.gains, values, strict=False):
            memory = np.exp(-x) * memory + gain @ row
            yield memory


@dataclass(frozen=True, eq=False)
class Drive:
    """The device of ``stiffness`` [N/m] at the positions ``x`` at the times ``t`` [s], 0 at first, and what it presses;
    ``ratio`` of times after a corner from step to step; ``grows``: see ``RelaxedPath``."""

    depths: Depths
    modes: Modes
    stiffness: float
    t: Array
    x: Array
    ratio: float = DRIVEN_RATIO
    grows: float = SAME

    def path(self) -> RelaxedPath:
        """What happens."""
        taken, now, i, turned = self._growth(math.inf)
        depth, load, lost = self._steps(taken, "depth"), self._steps(taken, "load"), False
        grown = RelaxedPath(self.depths, depth, load, grows=self.grows)
        while turned and not lost and i < self.t.size - 1:
            lost, now = self._piece(taken, now, i, Falling(self, grown).steps, self._to_end(DRIVEN_LAST))
            i += 1
        lost |= turned and self.stiffness == LOAD_CONTROL and self.x[-1] == 0
        return replace(grown, depth=self._steps(taken, "depth"), lost=now.t if lost else math.inf)

    def grown(self, deepest: float) -> RelaxedPath | None:
        """The growth of the contact up to the depth ``deepest`` [m]; None where it ends before."""
        taken, now, _, turned = self._growth(deepest)
        if not turned or now.depth < deepest * (1 - SAME):
            return None
        return RelaxedPath(self.depths, self._steps(taken, "depth"), self._steps(taken, "load"))

    def _growth(self, deepest: float) -> tuple[Taken, Now, int, bool]:
        """The steps up to where the contact stops to grow or comes to the depth ``deepest`` [m], the state there, the
        piece of the program, and whether it came to that before the end."""
        none = np.zeros(self.modes.rates.size)
        taken, now = Taken(), Now(float(self.t[0]), 0.0, 0.0, 0.0, none, none)

        def solver(now: Now, device: DeviceSteps) -> tuple[Run, Array] | None:
            run = self._grown(now, device)
            if run is None:
                return None
            # What is positive while the depth rises, which may fall by round-off
            rises = (np.diff(run.depth) > -DRIVEN_FALLS * run.depth.max(axis=1, keepdims=True)).all(axis=1)
            slopes = run.depth @ POWERS * np.arange(DEGREE + 1)
            left = np.where(rises[:, None], np.eye(1, DEGREE + 1), np.roll(slopes, -1, axis=1))
            beyond = run.depth[:, -1] > deepest
            left[beyond] = (deepest - run.depth[beyond]) @ POWERS
            return run, left

        for i in range(self.t.size - 1):
            turned, now = self._piece(taken, now, i, solver, np.ones(1))
            if turned:
                return taken, now, i, True
        return taken, now, self.t.size - 1, False

    def _steps(self, taken: Taken, name: str) -> Steps:
        t = np.concatenate([self.t[:1], *(step.ends for _, step in taken)])
        return Steps(self.modes, t, np.concatenate([getattr(step, name) for _, step in taken]) @ POWERS)

    def _piece(self, taken: Taken, now: Now, i: int, solver: Solver, last: Array) -> tuple[bool, Now]:
        """Take the steps through the piece ``i`` of the program, or up to where the contact turns or is lost; whether
        it does, and the state there. ``last``: ends of the steps, parts, in which the one is solved where it does."""
        count, since, begin = DRIVEN_TOGETHER, now.t, self._part(i, now.t)
        # Ends of the steps, parts of the piece, closer to each other at first, and where a load comes to 0: the contact
        # does as its power 2/3
        parts = self._from_begin(DRIVEN_FIRST)
        if self.stiffness == LOAD_CONTROL and self.x[i + 1] == 0:
            parts = np.concatenate([parts / 2, (1 + self._to_end(DRIVEN_FIRST)) / 2])
        ends = begin + (1 - begin) * parts if begin < 1 else parts[:0]
        while ends.size:
            solved = solver(now, self._device_steps(i, begin, ends[:count]))
            if solved is None:
                if count == 1:
                    raise _not_solved(now)
                count = max(min(count, ends.size) // 2, 1)
                continue
            whole, part = _first_fall(solved[1])
            now = self._add(taken, now, solved[0].first(whole))
            if whole < len(solved[1]):
                begin = float(ends[whole - 1]) if whole else begin
                falls = begin + part * float(ends[whole] - begin)
                if last.size > 1:
                    # steps that end too near to where contact is lost are given up: it shrinks like a power there
                    lost = self.t[i] + falls * (self.t[i + 1] - self.t[i])
                    while taken and taken[-1][0].t >= since and lost - now.t < DRIVEN_NEAR * (now.t - taken[-1][0].t):
                        now = taken.pop()[0]
                    begin = begin if now.t == since else self._part(i, now.t)
                return True, self._last(taken, now, i, begin, falls - begin, last, solver)
            begin, ends = float(ends[whole - 1]), ends[whole:]
        return False, now

    def _part(self, i: int, t: float) -> float:
        """The part of piece ``i`` that is over at a time."""
        lasts = float(self.t[i + 1] - self.t[i])
        return float(t - self.t[i]) / lasts if lasts > 0 else 0.0

    def _last(self, taken: Taken, now: Now, i: int, begin: float, part: float, last: Array, solver: Solver) -> Now:
        """Take steps up to where the contact turns or is lost, about ``part`` beyond the part ``begin`` of piece
        ``i``."""
        run, low, high, before = None, 0.0, math.inf, math.inf
        for _ in range(numerics.MOST_STEPS if part > 0 else 0):
            device = self._device_steps(i, begin, begin + part * last)
            if (solved := solver(now, device)) is None:
                raise _not_solved(now)
            run, left = solved
            low, high = (part, high) if left[-1].sum() > 0 else (low, part)
            # How far beyond the end of the last step, in parts of all steps, nothing is left if it goes on straight
            rate = float(left[-1] @ np.arange(left.shape[1]))
            beyond = 0.0 if rate == 0 else -float(left[-1].sum()) / rate * np.diff(last, prepend=0.0)[-1]
            if abs(beyond) < numerics.ROUNDED or high - low < numerics.ROUNDED * part:
                break
            after = part * (1 + min(max(beyond, 1 / DRIVEN_FAR - 1), DRIVEN_FAR - 1))
            if high < math.inf and (abs(after - part) > before / 2 or not low < after < high):
                after = (low + high) / 2  # a vertical slope sends straight steps to and fro
            before, part = abs(after - part), after
        return now if run is None else self._add(taken, now, run)

    def _from_begin(self, first: float) -> Array:
        """Ends of steps, parts of all of them, close to each other at the begin."""
        return self.ratio ** -np.arange(math.ceil(math.log(1 / first) / math.log(self.ratio)), -1.0, -1)

    def _to_end(self, last: float) -> Array:
        """The same, close to each other at the end."""
        return np.append(1 - self._from_begin(last)[-2::-1], 1.0)

    def _add(self, taken: Taken, now: Now, run: Run) -> Now:
        """The state after the steps of ``run``, which are taken."""
        kernel = Kernel(self.modes, np.diff(run.ends, prepend=now.t))
        memories = zip(kernel.after(now.of_depth, run.depth), kernel.after(now.of_load, run.load), strict=True)
        for k, (of_depth, of_load) in enumerate(memories):
            step = Run(*(column[k : k + 1] for column in run))
            taken.append((now, step))
            t, depth, contact, load = (float(column.flat[-1]) for column in step)
            now = Now(t, depth, contact, load, of_depth, of_load)
        return now

    def _device_steps(self, i: int, begin: float, ends: Array) -> DeviceSteps:
        """Steps from the part ``begin`` of piece ``i`` to ``ends``."""
        h = np.diff(ends, prepend=begin)
        inner = (ends[:, None] - np.multiply.outer(h, 1 - INNER)).ravel()
        return h * (self.t[i + 1] - self.t[i]), self.x[i] + (self.x[i + 1] - self.x[i]) * inner

    def _grown(self, now: Now, device: DeviceSteps) -> Run | None:
        """Steps in which the contact grows; None where Newton's iteration does not find them."""
        h, x = device
        kernel = Kernel(self.modes, h)
        seen, by = kernel.seen(now.of_load) + kernel.matrix[:, 0] * now.load, kernel.matrix[:, 1:]
        stiff, loaded = by.sum(axis=1), self.stiffness == LOAD_CONTROL

        def excess(log: Array) -> Array:
            depth = np.exp(log)
            return position(depth, seen + stiff * self.depths.loads(depth), self.stiffness) - x

        # log depths to begin with: of an elastic contact `stiff` times as stiff, loaded in one step
        low, high = (np.full(x.size, math.log(edge)) for edge in (self.depths.least, self.depths.most))
        low = np.where(excess(low) > 0, high, low)
        log = numerics.zeros_between(excess, low, np.where(excess(high) > 0, high, low), DRIVEN_FAR)
        for _ in range(numerics.MOST_STEPS):
            depth = np.exp(log)
            load, S = self.depths.with_slopes(depth)
            missing = position(depth, seen + by @ load, self.stiffness) - x
            rates = by * S if loaded else np.eye(x.size) + by * S / self.stiffness
            change = np.linalg.solve(rates * depth, missing)
            log = log - np.clip(change, -DRIVEN_FAR, DRIVEN_FAR)
            if np.max(np.abs(change)) < DRIVEN_CONVERGED:
                break
        else:
            return None
        depth = np.exp(log)
        whole = _places(now.depth, depth)
        return Run(now.t + np.cumsum(h), whole, whole, _places(now.load, self.depths.loads(depth)))


def _not_solved(now: Now) -> SolveError:
    return SolveError(f"relaxation: the contact at t = {now.t:g} s is not found")


def _places(first: float, values: Array) -> Array:
    """Values at all places of steps (n, 7), from those at the inner ones (6 n,)."""
    steps = values.reshape(-1, DEGREE)
    return np.column_stack([np.append(first, steps[:-1, -1]), steps])


def _first_fall(left: Array) -> tuple[int, float]:
    """The number of whole steps before what is ``left`` (n, 7) falls below 0, and where in the next it does: 0 at its
    begin."""
    y = np.linspace(0, 1, 16 * DEGREE)
    negative = left @ np.vander(y, left.shape[1], increasing=True).T < 0
    if not negative.any():
        return len(left), 1.0
    step = int(np.argmax(negative.any(axis=1)))
    at = int(np.argmax(negative[step]))
    if at == 0:
        return step, 0.0
    return step, float(
        numerics.zeros_between(np.polynomial.Polynomial(left[step]), y[at - 1 : at], y[at : at + 1], 0.0)[0]
    )


@dataclass(frozen=True, eq=False)
class Falling:
    """A contact that shrinks after it grew as on the path ``grown``."""

    drive: Drive
    grown: RelaxedPath

    def steps(self, now: Now, device: DeviceSteps) -> tuple[Run, Array] | None:
        """Steps, and what is positive in them up to the loss of contact; None where they are not found."""
        h, x = device
        kernel = Kernel(self.drive.modes, h)
        k, inverse = self.drive.stiffness, np.linalg.inv(kernel.matrix[:, 1:])
        seen = kernel.seen(now.of_depth) + kernel.matrix[:, 0] * now.depth
        contact, least = np.full(x.size, now.contact), self.drive.depths.least if k == LOAD_CONTROL else -math.inf
        top = self.grown.deepest
        for _ in range(numerics.MOST_STEPS):
            # int r d(delta) [m] and int r dP_H [N] up to where the contact grew through these depths, and their slopes;
            # below 0, where there is no contact, straight on
            path, inside, t = self.grown, np.maximum(contact, 0.0), now.t + kernel.since
            places = path.place_at(inside)
            by_depth = path.depth.modes(t - path.depth.times(places))
            view = path.depth.view(places, t)
            depth, P = view.integral(path.depth) + by_depth * (contact - inside), view.integral(path.load)
            S = self.drive.depths.with_slopes(np.maximum(contact, self.drive.depths.least))[1]
            by_P = np.where(contact > 0, by_depth * S, 0.0)
            delta = inverse @ (depth - seen)
            rates = np.diag(by_P) if k == LOAD_CONTROL else inverse * by_depth + np.diag(by_P) / k
            missing = position(delta, P, k) - x
            change = np.linalg.solve(rates, missing)
            contact = np.clip(contact - change, least, top)
            still = np.abs(change) > DRIVEN_CONVERGED * top
            if not (still & (np.abs(missing) > numerics.SETTLED * self.drive.x.max())).any():
                break
        else:
            return None
        ends, whole = now.t + np.cumsum(h), _places(now.contact, contact)
        self._check(ends, whole)
        left = np.ones_like(whole) if k == LOAD_CONTROL else whole @ POWERS  # a load is lost where it ends
        return Run(ends, _places(now.depth, delta), whole, np.zeros_like(whole)), left

    def _check(self, ends: Array, contact: Array) -> None:
        """InputError where the contact grows again before it is lost."""
        there = np.logical_and.accumulate((contact >= 0).all(axis=1))
        again = there & (np.diff(contact) > self.drive.grows * self.grown.deepest).any(axis=1)
        if again.any():
            raise InputError(f"program: at t = {show(float(ends[again][0]), 'time')} the contact {AGAIN}")


# --------------------------------------------------------------------------------------------------
# What a device records over time that presses a viscoelastic body: programs, turns, and the table of it all.


@dataclass(frozen=True, eq=False)
class RelaxingContact:
    """A contact without adhesion whose moduli relax by ``law``, in a device of ``stiffness`` [N/m]; ``coarser``: how
    many of its steps are joined; ``grows``: see ``RelaxedPath``."""

    body: Nonadhesive
    law: Relaxation
    stiffness: float = DISPLACEMENT_CONTROL
    coarser: int = 1
    grows: float = SAME

    least = 0.0  # the device's position at first contact

    @cached_property
    def depths(self) -> Depths:
        return Depths(self.body)

    def history(self, program: Program) -> RelaxedHistory:
        """What happens under ``program`` of positions [m], of loads [N] under load control."""
        path, most = self._path(program), self.depths.most
        if path.deepest > most * (1 + SAME):
            raise InputError(
                f"program: the contact comes {show(path.deepest - most, 'length')} beyond the largest depth of the "
                f"solution, {show(most, 'length')}: reverse before, or increase [loading] radius"
            )
        return RelaxedHistory(self, program, path)

    def within(self, program: Callable[[float], Program], x: float) -> float:
        """The turn ``x``, or before it that after which the contact creeps no farther than the series goes."""
        for _ in range(numerics.MOST_STEPS):
            beyond = self._path(program(x)).deepest / self.depths.most
            if beyond <= 1 + SAME:
                return x
            x *= (1 - NOTICEABLE) / beyond  # theory: the depth grows no faster than the position
        raise InputError("cycle: no reversal keeps the contact within the solution: give it, --to-depth")

    def _path(self, program: Program) -> RelaxedPath:
        # The program from first contact on, where it holds 0; loads up to where they come to 0 again
        t, x = _ended(program)
        pressed = np.flatnonzero(x > 0)
        if not pressed.size:
            raise InputError(f"program: never presses: its largest value is {np.max(x):g}, contact begins at 0")
        first = int(pressed[0])
        begin = t[0] if first == 0 else t[first] - x[first] / (x[first] - x[first - 1]) * (t[first] - t[first - 1])
        t, x = np.append(begin, t[first:]), np.append(0.0, x[first:])
        if self.stiffness == LOAD_CONTROL and (pulled := np.flatnonzero((x[1:] <= 0) & (x[:-1] > 0))).size:
            i = int(pulled[0])
            part = x[i] / (x[i] - x[i + 1])
            t, x = np.append(t[: i + 1], t[i] + part * (t[i + 1] - t[i])), np.append(x[: i + 1], 0.0)
        if not t[-1] > t[0]:
            raise InputError("program: must last longer than no time in contact")
        modes = self._modes(t)
        if math.isinf(self.stiffness):
            return depth_controlled(self.depths, modes, t, x, PATH_RATIO**self.coarser, self.grows)
        return Drive(self.depths, modes, self.stiffness, t, x, DRIVEN_RATIO**self.coarser, self.grows).path()

    def _modes(self, t: Array) -> Modes:
        return self.law.modes(float(t[-1] - t[0]))

    def turning(self, load: float | None, depth: float | None, speed: float) -> float:
        """The device's position where an approach at ``speed`` [m/s, under load control N/s] comes to ``load`` [N] or
        ``depth`` [m]; both None: to the end of the series."""

        if self.stiffness == (DISPLACEMENT_CONTROL if load is None else LOAD_CONTROL):
            return (depth or self.depths.most) if load is None else load
        path = self._approach(speed)
        if load is None and depth is None:
            return speed * path.turn
        name, wanted, unit = ("P", load, "load") if load is not None else ("delta", depth or 0.0, "length")

        def reached(places: Array) -> Array:
            loads = path.load.integral(places, path.load.times(places))
            return (loads if load is not None else path.depth.values(places)) - wanted

        places = np.linspace(0, path.last, numerics.LOOKED_AT)
        met = np.flatnonzero(reached(places) >= 0)[:1]
        if not met.size or met[0] == 0:
            raise InputError(
                f"cycle: the reversal at {name} = {show(wanted or 0.0, unit)} is not reached on approach, which in "
                "this "
                f"solution ends at {show(float(reached(places[-1:])[0]) + (wanted or 0.0), unit)}"
            )
        return speed * float(path.load.times(numerics.zeros_between(reached, places[met - 1], places[met], 0.0))[0])

    def _approach(self, speed: float) -> RelaxedPath:
        """An approach at ``speed`` to the end of the series."""
        most = self.depths.most
        P = float(self.depths.loads(np.array([most]))[0])
        lasting = float(position(most, P, self.stiffness)) / speed
        for _ in range(numerics.MOST_STEPS):
            t, x = np.array([0.0, lasting]), np.array([0.0, speed * lasting])
            if math.isinf(self.stiffness):
                return depth_controlled(self.depths, self._modes(t), t, x)
            grown = Drive(self.depths, self._modes(t), self.stiffness, t, x).grown(most)
            if grown is not None:
                return grown
            lasting *= 2
        raise InputError("cycle: the approach does not come to the end of the solution")


def _ended(program: Program) -> tuple[Array, Array]:
    """Times and positions of a program; one that goes on backwards ends at the position 0."""
    if program.rate is None:
        return program.t, program.x
    if program.rate > 0 or program.x[-1] <= 0:
        raise InputError("program: the way back must begin in contact")
    return np.append(program.t, program.t[-1] - program.x[-1] / program.rate), np.append(program.x, 0.0)


@dataclass(frozen=True, eq=False)
class RelaxedHistory:
    """What happened to ``contact`` under ``program``, on the ``path``."""

    contact: RelaxingContact
    program: Program
    path: RelaxedPath

    @property
    def control(self) -> str:
        """The control in words."""
        return control(self.contact.stiffness)

    @property
    def lost(self) -> float | None:
        """When contact is lost [s]; None where it is not."""
        return self.path.lost if math.isfinite(self.path.lost) else None

    @property
    def turn(self) -> float:
        """When the contact stopped to grow [s]."""
        return self.path.turn

    @property
    def whole(self) -> bool:
        """Whether it grew up to the end of the series."""
        return self.path.deepest >= (1 - NOTICEABLE) * self.path.depths.most

    @cached_property
    def peak(self) -> TimedState:
        """The state of the largest load, to a part of a program's piece."""
        t = np.sort(np.append(self._times(numerics.LOOKED_AT), self.turn))
        return max(self._timed(t), key=lambda state: state.P)

    @property
    def corners(self) -> tuple[TimedState, ...]:
        """The states at the corners of the program while there is contact."""
        t = np.unique(self._pieces)
        return self._timed(t[(t > self.path.begin) & (t < self.path.lost)])

    def _timed(self, t: Array) -> tuple[TimedState, ...]:
        rows = np.stack([*self.path.states(t), t], axis=1).tolist()
        return tuple(TimedState(a=a, delta=delta, P=P, t=when) for a, delta, P, when in rows)

    @cached_property
    def error(self) -> float:
        """Largest error of the loads over the largest load [-], of steps in time: what joining each two of them
        changes, an upper limit."""
        if self.contact.coarser > 1:
            return math.nan
        t = self._times(PATH_DEGREE)
        beside = replace(self.contact, coarser=2).history(self.program)
        P, other = self.path.states(t)[2], beside.path.states(t)[2]
        return float(np.max(np.abs(P - other)) / np.max(P))

    @cached_property
    def energy_lost(self) -> Estimate:
        """Work of the device from first contact to its loss [J], which the body does not give back."""
        if self.lost is None:
            return Unknown("contact is not lost")
        path, places, turn = self.path, np.arange(self.path.last + 1), int(self.path.last)
        steps = (np.diff(path.depth.t) == 0) & (np.abs(path.depth.p[:, 1:].sum(axis=1)) > SAME * path.depths.most)
        if steps[turn:].any():
            return Unknown("the instrument steps back")
        y, weights = numerics.composite_gauss(places)
        P = path.load.integral(y.ravel(), path.load.times(y.ravel()))
        t = path.depth.t[turn:]
        parts = 1 - np.geomspace(1.0, 1e-4, math.ceil(PATH_INTERVALS / t.size))
        t = np.minimum(np.append(t[:-1, None] + np.diff(t)[:, None] * parts, t[-1]), path.lost)
        later, lasts = numerics.composite_gauss(np.unique(np.append(t, path.lost)))
        work = weights.ravel() * path.depth.rates(y.ravel())
        h = np.diff(path.depth.t)[path.depth.places(later.ravel()).astype(int)]
        left = lasts.ravel() * path.depth.rates(path.depth.places(later.ravel())) / h
        return float(P @ work + path.states(later.ravel())[2] @ left)

    @property
    def _pieces(self) -> Array:
        """Ends of the pieces of the program from first contact on."""
        t = _ended(self.program)[0]
        return np.append(self.path.begin, t[t > self.path.begin])

    def _times(self, points: int) -> Array:
        """Times in contact, ``points`` to a piece of the program."""
        ends = np.unique(np.minimum(self._pieces, self.path.lost))
        return np.unique([np.linspace(a, b, points + 1) for a, b in itertools.pairwise(ends)])

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole program, ``points`` to a piece: "t_s", "a_m" (0 out of contact), "delta_m", "P_N",
        "device_m" (not under load control), "phase", "part"; at a step the state behind it."""
        ends, x = _ended(self.program)
        parts = [np.linspace(a, b, points) for a, b in itertools.pairwise(ends) if b > a]
        t, number = np.concatenate(parts), np.repeat(np.arange(1, len(parts) + 1), points)
        once = np.append(True, np.diff(t) > 0)  # where pieces meet
        t, number = t[once], number[once]
        a, delta, P = self.states(t)
        columns = {"t_s": t, "a_m": a, "delta_m": delta, "P_N": P}
        if self.contact.stiffness != LOAD_CONTROL:
            columns["device_m"] = np.interp(t, ends, x)
        phases = np.where(a == 0, "free", np.where(t <= self.turn, "advance", "recede"))
        return columns | {"phase": phases, "part": number}

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """a [m], delta [m], P [N] at the rising times ``t`` [s] of the program; out of contact a = P = 0, and the tip
        is where the device is."""
        loaded, touches = self.contact.stiffness == LOAD_CONTROL, (t >= self.path.begin) & (t < self.path.lost)
        a, P = np.zeros_like(t), np.zeros_like(t)
        delta = np.zeros_like(t) if loaded else np.interp(t, *_ended(self.program))  # of equal times the last
        if touches.any():
            a[touches], delta[touches], P[touches] = self.path.states(t[touches])
        return a, delta, P

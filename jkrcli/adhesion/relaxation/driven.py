"""A contact that relaxes in a device that does not hold its depth: a spring, or a load.

position(delta, P) = x(t), with P and delta bound by the same sums as at a given depth, is an integral equation for
delta(t); it is solved by collocation from step to step, steps growing after each corner of the program.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import Polynomial

from ...base.arrays import Array
from ...base.cubic import zeros_between
from ...base.errors import InputError, SolveError
from ...base.units import show
from ...bodies.relaxation import Modes
from ..device import LOAD_CONTROL, position
from .depths import Depths
from .memory import Steps, moments
from .path import AGAIN, PLACES, POWERS, RelaxedPath
from .path import TUNING as PATH

INNER = PLACES[1:]
DEGREE = INNER.size


@dataclass(frozen=True)
class DrivenTuning:
    """Steps in time, and how they are solved."""

    first: float = 1e-9  # choice: of a piece of the program, the first step after its corner
    ratio: float = 1.3  # choice: of times after a corner from step to step; leaves 1e-9
    newton: int = 60  # choice: guard
    converged: float = 1e-7  # theory: relative, of what Newton's last step is the square root
    falls: float = 1e-10  # theory: of the depth, what is no round-off
    ends: float = 1e-9  # choice: of the last step of growth or of contact, by which its end may be missed
    cuts: int = 30  # choice: guard, of the same step
    far: float = 2.0  # choice: guard, of the log depth in an iteration


TUNING = DrivenTuning()


class Step(NamedTuple):
    """A solved step: its ``end`` [s]; at its places, from its begin on, ``depth`` of the tip and ``contact``, the depth
    [m] at which the contact grew through its radius, and ``load`` P_H [N] while it grows."""

    end: float
    depth: Array
    contact: Array
    load: Array


class Now(NamedTuple):
    """A state between two steps: time [s], depth and contact [m], load P_H [N]; what is remembered of both."""

    t: float
    depth: float
    contact: float
    load: float
    of_depth: Array
    of_load: Array


Solver: TypeAlias = Callable[[Now, float, Array], tuple[Step, Polynomial]]


@dataclass(frozen=True, eq=False)
class Kernel:
    """int r(t - s) dq(s) at the inner places of a step of ``h`` [s]: ``seen`` of what is remembered, (places, m), and
    ``matrix`` times the values of q at all places."""

    modes: Modes
    h: float

    def seen(self, memory: Array) -> Array:
        return np.exp(-np.multiply.outer(INNER * self.h, self.modes.rates)) @ (self.modes.weights * memory)

    @property
    def matrix(self) -> Array:
        found = moments(np.multiply.outer(INNER * self.h, self.modes.rates), DEGREE)
        memory = [(j + 1) * moment @ self.modes.weights for j, moment in enumerate(found)]
        powers = INNER[:, None] ** np.arange(DEGREE + 1)
        return np.asarray((self.modes.relaxed + np.stack([np.zeros(DEGREE), *memory], 1)) * powers) @ POWERS.T

    def after(self, memory: Array, values: Array) -> Array:
        """What is remembered at the end."""
        x = self.h * self.modes.rates
        p = values @ POWERS
        gained = sum((j + 1) * p[j + 1] * moment for j, moment in enumerate(moments(x, DEGREE)))
        return np.asarray(np.exp(-x) * memory + gained)


@dataclass(frozen=True, eq=False)
class Drive:
    """The device of ``stiffness`` [N/m] that holds ``x`` at the times ``t`` [s], 0 at first, and what it presses;
    ``ratio`` of times after a corner from step to step; ``grows``: see ``RelaxedPath``."""

    depths: Depths
    modes: Modes
    stiffness: float
    t: Array
    x: Array
    ratio: float = TUNING.ratio
    grows: float = PATH.grows

    def path(self) -> RelaxedPath:
        """What happens."""
        steps, now, i, turned = self._growth(math.inf)
        grown, lost = (
            RelaxedPath(self.depths, self._steps(steps, "depth"), self._steps(steps, "load"), grows=self.grows),
            False,
        )
        while turned and not lost and i < self.t.size - 1:
            lost, now = self._piece(steps, now, i, Falling(self, grown).step)
            i += 1
        lost |= turned and self.stiffness == LOAD_CONTROL and self.x[-1] == 0
        return replace(grown, depth=self._steps(steps, "depth"), lost=now.t if lost else math.inf)

    def grown(self, deepest: float) -> RelaxedPath | None:
        """The growth of the contact up to the depth ``deepest`` [m]; None where it ends before."""
        steps, now, _, turned = self._growth(deepest)
        if not turned or now.depth < deepest * (1 - PATH.grows):
            return None
        return RelaxedPath(self.depths, self._steps(steps, "depth"), self._steps(steps, "load"))

    def _growth(self, deepest: float) -> tuple[list[Step], Now, int, bool]:
        """The steps up to where the contact stops to grow or comes to the depth ``deepest`` [m], the state there, the
        piece of the program, and whether it came to that before the end."""
        none = np.zeros(self.modes.rates.size)
        steps, now = list[Step](), Now(float(self.t[0]), 0.0, 0.0, 0.0, none, none)

        def solved(now: Now, end: float, x: Array) -> tuple[Step, Polynomial]:
            step, left = self._grown(now, end, x)
            return step, Polynomial((deepest - step.depth) @ POWERS) if step.depth[-1] > deepest else left

        for i in range(self.t.size - 1):
            turned, now = self._piece(steps, now, i, solved)
            if turned:
                return steps, now, i, True
        return steps, now, self.t.size - 1, False

    def _steps(self, steps: list[Step], name: str) -> Steps:
        t = np.array([self.t[0], *(step.end for step in steps)])
        return Steps(self.modes, t, np.stack([getattr(step, name) for step in steps]) @ POWERS)

    def _piece(self, steps: list[Step], now: Now, i: int, solved: Solver) -> tuple[bool, Now]:
        """Add the steps through the piece ``i`` of the program, or up to where the contact turns or is lost; whether it
        does, and the state there."""
        for whole in self._ends(now.t, i):
            end = float(whole)
            step, left = solved(now, end, self._held(i, now.t, end))
            part = _first_fall(left)
            ends = part < 1
            for _ in range(TUNING.cuts):
                if part == 0 or end == now.t or abs(part - 1) < TUNING.ends:
                    break
                end = now.t + part * (end - now.t)
                step, left = solved(now, end, self._held(i, now.t, end))
                part = _zero_near_end(left)
            if not ends or end < whole:
                steps.append(step)
                now = self._after(now, step)
            if ends:
                return True, now
        return False, now

    def _after(self, now: Now, step: Step) -> Now:
        kernel = Kernel(self.modes, step.end - now.t)
        memories = kernel.after(now.of_depth, step.depth), kernel.after(now.of_load, step.load)
        return Now(step.end, float(step.depth[-1]), float(step.contact[-1]), float(step.load[-1]), *memories)

    def _ends(self, t: float, i: int) -> Array:
        """Ends of the steps from the time ``t`` [s] on to the end of piece ``i``, closer to each other at first, and
        where a load comes to 0: the contact does as its power 2/3."""
        left = self.t[i + 1] - t
        if left <= 0:
            return self.t[i + 1 : i + 2]
        parts = self.ratio ** -np.arange(math.ceil(math.log(1 / TUNING.first) / math.log(self.ratio)), -1.0, -1)
        if self.stiffness == LOAD_CONTROL and self.x[i + 1] == 0:
            parts = np.concatenate([parts / 2, 1 - parts[-2::-1] / 2, [1.0]])
        return np.asarray(t + left * parts)

    def _held(self, i: int, t: float, end: float) -> Array:
        """What the device holds at the inner places of a step."""
        lasts = self.t[i + 1] - self.t[i]
        first, last = ((time - self.t[i]) / lasts for time in (t, end)) if lasts > 0 else (0.0, 1.0)
        return np.asarray(self.x[i] + (self.x[i + 1] - self.x[i]) * (first + (last - first) * INNER))

    def _grown(self, now: Now, end: float, x: Array) -> tuple[Step, Polynomial]:
        """A step in which the contact grows, and what is positive in it up to the largest depth."""
        kernel = Kernel(self.modes, end - now.t)
        matrix, seen = kernel.matrix, kernel.seen(now.of_load)
        seen, by = seen + matrix[:, 0] * now.load, matrix[:, 1:]
        log, loaded = self._guess(now, x, float(by[-1].sum())), self.stiffness == LOAD_CONTROL
        for _ in range(TUNING.newton):
            depth = np.exp(log)
            load, S = self.depths.with_slopes(depth)
            missing = position(depth, seen + by @ load, self.stiffness) - x
            rates = by * S if loaded else np.eye(DEGREE) + by * S / self.stiffness
            change = np.linalg.solve(rates * depth, missing)
            log = log - np.clip(change, -TUNING.far, TUNING.far)
            if np.max(np.abs(change)) < TUNING.converged:
                break
        else:
            raise SolveError(f"relaxation: the growth of the contact at t = {end:g} s is not found")
        depth = np.exp(log)
        whole = np.append(now.depth, depth)
        return Step(end, whole, whole, np.append(now.load, self.depths.loads(depth))), self._rising(whole)

    def _guess(self, now: Now, x: Array, stiff: float) -> Array:
        """log depth to begin with: of an elastic contact ``stiff`` times as stiff at first, then that before."""
        if now.depth > 0:
            return np.full(DEGREE, math.log(now.depth))
        edges = np.log(np.array([self.depths.least, self.depths.most]))
        low, high = (np.full(DEGREE, edge) for edge in edges)

        def excess(log: Array) -> Array:
            depth = np.exp(log)
            return np.asarray(position(depth, stiff * self.depths.loads(depth), self.stiffness) - x)

        return zeros_between(excess, low, np.where(excess(high) > 0, high, low), TUNING.far)

    def _rising(self, depth: Array) -> Polynomial:
        """What is positive in a step while the depth rises; it may fall by round-off."""
        if (np.diff(depth) > -TUNING.falls * depth.max()).all():
            return Polynomial([1.0])
        return Polynomial(depth @ POWERS).deriv()


def _first_fall(left: Polynomial) -> float:
    """Where in a step what is ``left`` falls below 0 first: 0 at its begin, 1 nowhere."""
    y = np.linspace(0, 1, 16 * DEGREE)
    falls = np.flatnonzero(left(y) < 0)
    if not falls.size or falls[0] == 0:
        return 0.0 if falls.size else 1.0
    return float(zeros_between(left, y[falls[:1] - 1], y[falls[:1]], 0.0)[0])


def _zero_near_end(left: Polynomial) -> float:
    """Where a step ends at which nothing is ``left``, that ends near there."""
    rate = float(left.deriv()(1.0))
    return 1.0 if rate == 0 else min(max(1 - float(left(1.0)) / rate, 1 / TUNING.far), TUNING.far)


@dataclass(frozen=True, eq=False)
class Falling:
    """A contact that shrinks after it grew as on the path ``grown``."""

    drive: Drive
    grown: RelaxedPath

    def step(self, now: Now, end: float, x: Array) -> tuple[Step, Polynomial]:
        """A step, and what is positive in it up to the loss of contact."""
        kernel, times = Kernel(self.drive.modes, end - now.t), now.t + INNER * (end - now.t)
        k, matrix = self.drive.stiffness, kernel.matrix
        inverse = np.linalg.inv(matrix[:, 1:])
        seen = kernel.seen(now.of_depth) + matrix[:, 0] * now.depth
        contact, least = np.full(DEGREE, now.contact), self.drive.depths.least if k == LOAD_CONTROL else -math.inf
        for _ in range(TUNING.newton):
            (depth, by_depth), (P, by_P) = self._held(contact, times)
            delta = inverse @ (depth - seen)
            rates = np.diag(by_P) if k == LOAD_CONTROL else inverse * by_depth + np.diag(by_P) / k
            change = np.linalg.solve(rates, position(delta, P, k) - x)
            contact = np.clip(contact - change, least, self.top)
            if np.max(np.abs(change)) < TUNING.converged * self.top:
                break
        whole = np.append(now.contact, contact)
        if (np.diff(whole) > self.drive.grows * self.top).any():
            raise InputError(f"program: at t = {show(end, 'time')} the contact {AGAIN}")
        return Step(end, np.append(now.depth, delta), whole, np.zeros(DEGREE + 1)), Polynomial(whole @ POWERS)

    @property
    def top(self) -> float:
        """The depth [m] at which the contact stopped to grow."""
        return float(self.grown.depth.values(np.array([self.grown.last]))[0])

    def _held(self, contact: Array, now: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """int r d(delta) [m] and int r dP_H [N] up to where the contact grew through depths ``contact``, seen from the
        times ``now``, and their slopes; below 0, where there is no contact, straight on."""
        path, inside = self.grown, np.maximum(contact, 0.0)
        places = path.place_at(inside)
        left = path.depth.modes(now - path.depth.times(places))
        depth, P = path.depth.held(places, now), path.load.held(places, now)
        S = self.drive.depths.with_slopes(np.maximum(contact, self.drive.depths.least))[1]
        return (depth + left * (contact - inside), left), (P, np.where(contact > 0, left * S, 0.0))

"""A contact that relaxes in a device that does not prescribe its depth: a spring, or a load.

position(delta, P) = x(t), with P and delta bound by the same sums as at a given depth, is an integral equation for
delta(t); it is solved by collocation, in many steps at once, which grow after each corner of the program.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from ...base import MOST_STEPS, ROUNDED, SAME, SETTLED, Array, InputError, SolveError, show, zeros_between
from ...bodies import Modes
from ..curve import LOAD_CONTROL, position
from .memory import Steps, moments
from .path import AGAIN, PLACES, POWERS, Depths, RelaxedPath

INNER = PLACES[1:]
DEGREE = INNER.size


@dataclass(frozen=True)
class DrivenTuning:
    """Steps in time, and how they are solved."""

    first: float = 1e-8  # choice: of a piece of the program, the first step after its corner
    # of parts after a corner from step to step; tuned on histories, by `make constants`: twice as much moves loads by
    # five stated errors
    ratio: float = 1.5
    last: float = 1e-5  # choice: the same of the step in which contact is lost, of which it may be a power 2/3
    # steps solved at once; tuned on relaxing bodies, by `make constants`: half cost 1.04 times, twice 1.25 times the
    # seconds
    together: int = 24
    converged: float = 1e-7  # theory: relative, of what Newton's last step is the square root
    falls: float = 1e-10  # theory: of the depth, what is no round-off
    near: float = 2.0  # choice: of a step, how far at least it is to end before contact is lost; leaves 1e-7
    far: float = 2.0  # tuned on relaxing bodies, by `make constants`: guard, of the log depth in an iteration


TUNING = DrivenTuning()


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
        return np.asarray(np.stack([0 * by_power[0], *((j + 1) * x for j, x in enumerate(by_power))], -1) @ POWERS.T)

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
    ratio: float = TUNING.ratio
    grows: float = SAME

    def path(self) -> RelaxedPath:
        """What happens."""
        taken, now, i, turned = self._growth(math.inf)
        depth, load, lost = self._steps(taken, "depth"), self._steps(taken, "load"), False
        grown = RelaxedPath(self.depths, depth, load, grows=self.grows)
        while turned and not lost and i < self.t.size - 1:
            lost, now = self._piece(taken, now, i, Falling(self, grown).steps, self._to_end(TUNING.last))
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
            left = self._rising(run.depth)
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
        count, since, begin = TUNING.together, now.t, self._part(i, now.t)
        ends = self._ends(begin, i)
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
                    now = self._back(taken, now, since, self.t[i] + falls * (self.t[i + 1] - self.t[i]))
                    begin = begin if now.t == since else self._part(i, now.t)
                return True, self._last(taken, now, i, begin, falls - begin, last, solver)
            begin, ends = float(ends[whole - 1]), ends[whole:]
        return False, now

    def _part(self, i: int, t: float) -> float:
        """The part of piece ``i`` that is over at a time."""
        lasts = float(self.t[i + 1] - self.t[i])
        return float(t - self.t[i]) / lasts if lasts > 0 else 0.0

    @staticmethod
    def _back(taken: Taken, now: Now, since: float, lost: float) -> Now:
        """The state before the steps, from a time [s] on, that end too near to where contact is ``lost`` [s], which are
        given up: it shrinks like a power there."""
        while taken and taken[-1][0].t >= since and lost - now.t < TUNING.near * (now.t - taken[-1][0].t):
            now = taken.pop()[0]
        return now

    def _last(self, taken: Taken, now: Now, i: int, begin: float, part: float, last: Array, solver: Solver) -> Now:
        """Take steps up to where the contact turns or is lost, about ``part`` beyond the part ``begin`` of piece
        ``i``."""
        run, low, high, before = None, 0.0, math.inf, math.inf
        for _ in range(MOST_STEPS if part > 0 else 0):
            device = self._device_steps(i, begin, begin + part * last)
            if (solved := solver(now, device)) is None:
                raise _not_solved(now)
            run, left = solved
            low, high = (part, high) if left[-1].sum() > 0 else (low, part)
            beyond = _beyond(left[-1]) * np.diff(last, prepend=0.0)[-1]  # in parts of all steps
            if abs(beyond) < ROUNDED or high - low < ROUNDED * part:
                break
            after = part * (1 + min(max(beyond, 1 / TUNING.far - 1), TUNING.far - 1))
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

    def _ends(self, begin: float, i: int) -> Array:
        """Ends of the steps from the part ``begin`` of piece ``i`` on, parts of it, closer to each other at first, and
        where a load comes to 0: the contact does as its power 2/3."""
        parts = self._from_begin(TUNING.first)
        if self.stiffness == LOAD_CONTROL and self.x[i + 1] == 0:
            parts = np.concatenate([parts / 2, (1 + self._to_end(TUNING.first)) / 2])
        return np.asarray(begin + (1 - begin) * parts if begin < 1 else parts[:0])

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
        log, loaded = self._guess(seen, by.sum(axis=1), x), self.stiffness == LOAD_CONTROL
        for _ in range(MOST_STEPS):
            depth = np.exp(log)
            load, S = self.depths.with_slopes(depth)
            missing = position(depth, seen + by @ load, self.stiffness) - x
            rates = by * S if loaded else np.eye(x.size) + by * S / self.stiffness
            change = np.linalg.solve(rates * depth, missing)
            log = log - np.clip(change, -TUNING.far, TUNING.far)
            if np.max(np.abs(change)) < TUNING.converged:
                break
        else:
            return None
        depth = np.exp(log)
        whole = _places(now.depth, depth)
        return Run(now.t + np.cumsum(h), whole, whole, _places(now.load, self.depths.loads(depth)))

    def _guess(self, seen: Array, stiff: Array, x: Array) -> Array:
        """log depths to begin with: of an elastic contact ``stiff`` times as stiff, loaded in one step."""
        low, high = (np.full(x.size, math.log(edge)) for edge in (self.depths.least, self.depths.most))

        def excess(log: Array) -> Array:
            depth = np.exp(log)
            return np.asarray(position(depth, seen + stiff * self.depths.loads(depth), self.stiffness) - x)

        low = np.where(excess(low) > 0, high, low)
        return zeros_between(excess, low, np.where(excess(high) > 0, high, low), TUNING.far)

    def _rising(self, depth: Array) -> Array:
        """What is positive in steps while the depth rises; it may fall by round-off."""
        rises = (np.diff(depth) > -TUNING.falls * depth.max(axis=1, keepdims=True)).all(axis=1)
        slopes = depth @ POWERS * np.arange(DEGREE + 1)
        return np.where(rises[:, None], np.eye(1, DEGREE + 1), np.roll(slopes, -1, axis=1))


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
    return step, float(zeros_between(np.polynomial.Polynomial(left[step]), y[at - 1 : at], y[at : at + 1], 0.0)[0])


def _beyond(left: Array) -> float:
    """How far beyond the end of a step, in such steps, nothing is ``left`` (7), if it goes on straight."""
    rate = float(left @ np.arange(left.size))
    return 0.0 if rate == 0 else -float(left.sum()) / rate


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
        for _ in range(MOST_STEPS):
            (depth, by_depth), (P, by_P) = self._integrals(contact, now.t + kernel.since)
            delta = inverse @ (depth - seen)
            rates = np.diag(by_P) if k == LOAD_CONTROL else inverse * by_depth + np.diag(by_P) / k
            missing = position(delta, P, k) - x
            change = np.linalg.solve(rates, missing)
            contact = np.clip(contact - change, least, top)
            still = np.abs(change) > TUNING.converged * top
            if not (still & (np.abs(missing) > SETTLED * self.drive.x.max())).any():
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

    def _integrals(self, contact: Array, now: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """int r d(delta) [m] and int r dP_H [N] up to where the contact grew through depths ``contact``, seen from the
        times ``now``, and their slopes; below 0, where there is no contact, straight on."""
        path, inside = self.grown, np.maximum(contact, 0.0)
        places = path.place_at(inside)
        left = path.depth.modes(now - path.depth.times(places))
        view = path.depth.view(places, now)
        depth, P = view.integral(path.depth), view.integral(path.load)
        S = self.drive.depths.with_slopes(np.maximum(contact, self.drive.depths.least))[1]
        return (depth + left * (contact - inside), left), (P, np.where(contact > 0, left * S, 0.0))

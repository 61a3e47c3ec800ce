"""Adhesion while the body relaxes: a cohesive stress around a contact whose moduli follow E(t) = E r(t).

In Abel's space, on any body whose kernel K is known, with p_hat(k) = (E*/2) int_0^c phi(t) cos(kt) dt of E* at t = 0,

    V(x, t) = (pi/2) phi + int_0^c K(x, y) phi(y, t) dy = int r(t - s) dW(x, s),

W the surface's displacement: time factors out of the kernel, and the hereditary integral of one place knows no other.
With r = r_inf + sum w_m exp(-t/t_m), each mode remembers eta_m = int exp(-(t - s)/t_m) dW(s). Of the surfaces

    W = delta - F(x)                          in contact,            x <= a
    phi = -(2/pi) s sqrt(c^2 - x^2)           s = 2 sigma/E*,        a <= x <= c;    phi = 0 beyond
    phi is continuous at a, and the gap at c is w/sigma:             a and c

(Dugdale's zone, as Maugis took it). Over a step in which W moves evenly, V = G W + H with the number
G = r_inf + sum w_m (1 - exp(-z))/z, z = h/t_m, and H(x) of what is remembered. So each step is elastic contact of the
modulus G E* under the profile F - H/G and the tension sigma: two unknowns. Where no such state is near, the contact
jumps: nothing relaxes meanwhile, G = 1. The memory of a step costs the same however many went before.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base.errors import Estimate, InputError, Refusal, Unknown
from ..base.numerics import MOST_STEPS, SAME, TINY, Array
from ..base.units import show
from ..bodies.materials import Modes, Relaxation
from ..bodies.problem import Problem
from ..methods.finite_range import AttractedBody
from ..methods.integral.dent import DentedProfile, DentPoints
from ..methods.integral.finite_range import Attraction, Rims
from ..series import Solution
from .curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, control, position
from .device_path import Jump, Program, TimedState
from .finite_range import Range, unable

# Accuracy.
# predicted less found radii over the width of the zone; choice: the forces of withdrawals at 0.01 to 1 R/tau are
# then good to 5e-4
STEP_TOLERANCE = 1e-3
STEP_COARSER = 4.0  # theory: of that in the second run, errors of second order halve with half the steps twice
STEP_ORDER = 3.0  # theory: by which the difference of both runs is larger than the error of the first
STEP_SAFETY = 2.0  # choice: on that
STEP_FIRST = 1e-6  # choice: of a piece of the program, behind its corner
STEP_FIRST_MOVE = 0.03  # choice: of the zone, what the edge moves in a step that nothing predicts
STEP_LARGEST = 0.5  # choice: of the zone, what the edge moves at most
STEP_GROWS, STEP_FALLS = 2.0, 0.4  # choice: from step to step
# An edge that moves so fast is seen to jump:
STEP_LEAST = 1e-9  # theory: of a piece
JUMPS = 1e-5  # theory: of the shortest time of relaxation, in which nothing relaxes
LAST_STEPS = 5  # choice: that tell which way an edge goes while the device rests
STEP_MOST = 20_000  # choice: half a minute
CLOSE = 1e-3  # theory: of the zone, from which one step of Newton's leaves 1e-6
ZONE_POINTS = 100  # of the narrowest zone; choice: twice as many change forces by 1e-5
ZONE_FEWEST = 10  # theory: the zone is then seen to 1 %
MOST_POINTS = 200_000  # choice: a step then takes 10 ms
FIRST_POINTS = 2000  # choice: over the reach at least
LEAST_LEFT = 1e-3  # choice: of the moduli, what answers in the end at least, to foresee reaches and zones
FIRST_REACH = 1.3  # choice: of the reach of the contact at the end of the series, which creeps and heals
REACH_GROWS = 1.5  # choice: from run to run
LEAPS = 80  # choice: radii among which a jump's end is looked for
LEAP_DECADES = 3.0  # theory: of them, below the largest; smaller contacts let go at once
FREE_STEPS = 40  # choice: of a piece of the program, at which the surface is looked at that nothing touches
FREE_RADII = 12  # choice: at which
ZONE_SLOPE = math.pi / 4  # theory: E* w/sigma^2, the width of Dugdale's zone at a crack, in these


class TooFarError(Exception):
    """The surfaces attract each other beyond the radius up to which the body was prepared."""


@dataclass(frozen=True, eq=False)
class Body:
    """A half-space or layered body ``attraction`` of the moduli at t = 0, known at ``points``, under its indenter's F,
    of ``modes`` of relaxation, with adhesion by ``law`` in a device of ``stiffness`` [N/m]."""

    attraction: Attraction
    points: DentPoints
    F: Array
    modes: Modes
    law: Range
    stiffness: float

    @property
    def s(self) -> float:
        return 2 * self.law.stress / self.attraction.E_star


@dataclass(frozen=True, eq=False)
class Memory:
    """What the ``body`` remembers: W [m] and V [m] at its points and eta_m of its modes, (m, points)."""

    body: Body
    W: Array
    V: Array
    eta: Array

    @classmethod
    def none(cls, body: Body) -> Memory:
        zero = np.zeros_like(body.F)
        return cls(body, zero, zero, np.zeros((body.modes.rates.size, zero.size)))

    def over(self, h: float) -> Step:
        """A step of ``h`` >= 0 [s] in which W moves evenly: eta -> exp(-z) eta + (1 - exp(-z))/z dW."""
        modes, z = self.body.modes, h * self.body.modes.rates
        decay = np.exp(-z)
        gain = np.divide(-np.expm1(-z), z, out=np.ones_like(z), where=z > 0)
        G = modes.relaxed + float(modes.weights @ gain)
        H = (modes.weights * decay) @ self.eta - float(modes.weights @ gain) * self.W
        return Step(self, decay, gain, G, H)


class Found(NamedTuple):
    """A state: radii of contact ``a`` and of the zone ``c`` [m], ``delta`` [m], ``P`` [N]; ``rims``: the same of the
    step's dented profile."""

    a: float
    c: float
    delta: float
    P: float
    rims: Rims | None = None


NOTHING = Found(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a ``memory``: elastic contact of the modulus ``G`` E* under the profile F - ``H``/G."""

    memory: Memory
    decay: Array
    gain: Array
    G: float
    H: Array

    @property
    def body(self) -> Body:
        return self.memory.body

    @cached_property
    def profile(self) -> DentedProfile:
        return DentedProfile(self.body.points, self.body.F - self.H / self.G)

    def rims(self, a: Array, b: Array) -> Rims:
        """States of contact radii ``a`` with zones ``b`` wide, ``gap`` as it comes; P [N] is that of G E*. Where
        a = 0 nothing touches, and delta is what opens the gap at c to the range."""
        rims = self.body.attraction.discs(a, self.profile).rims(b, self.body.s / self.G)
        open_, length = a == 0, self.body.law.length
        delta = np.where(open_, rims.delta + rims.gap - length, rims.delta)
        return Rims(a, rims.c, delta, rims.P * self.G, rims.gap)

    def excess(self, rims: Rims, x: float) -> tuple[Array, Array]:
        """Position of the device less ``x``, and log of the gap at c over the range."""
        held = np.asarray(position(rims.delta, rims.P, self.body.stiffness))
        return held - x, np.log(np.maximum(rims.gap / self.body.law.length, TINY))

    def near(self, x: float, a: float, c: float) -> Found | None:
        """The stable state at the device's position ``x`` near to the radii ``a`` and ``c``; None: there is none."""
        for _ in range(3):  # at a = 0 the one kind of state goes over into the other
            found = self._touching(x, a, c - a) if a > 0 else self._apart(x, c)
            if not isinstance(found, float):
                return found
            a = found
        return None

    def _touching(self, x: float, a: float, b: float) -> Found | float | None:
        """Newton in a and b; 0.0 where contact is lost into mere attraction."""
        before = math.inf
        for _ in range(MOST_STEPS):
            if not a + b < self._end:
                raise TooFarError
            e = CLOSE**2 * b
            rims = self.rims(np.array([a, a + e, a]), np.array([b, b, b + e]))
            off, opens = self.excess(rims, x)
            (xa, ga), (xb, gb) = (((off[i] - off[0]) / e, (opens[i] - opens[0]) / e) for i in (1, 2))
            det = xa * gb - xb * ga
            if not (gb > 0 and det > 0):  # dx/da along the states whose gap closes the law
                return None
            da, db = (xb * opens[0] - gb * off[0]) / det, (ga * off[0] - xa * opens[0]) / det
            moved = max(abs(da), abs(db)) / b
            part = min(1.0, STEP_LARGEST / max(moved, TINY))
            if a + part * da <= 0:
                if a < CLOSE * b:
                    return 0.0
                part = min(part, (a - CLOSE / 2 * b) / -da)
            a, b = a + part * da, b + part * db
            if moved < CLOSE or (moved > before > CLOSE and moved < CLOSE * STEP_LARGEST):
                rims = self.rims(np.array([a]), np.array([b]))
                return self._held(x, rims)
            before = moved
        return None

    def _apart(self, x: float, c: float) -> Found | float | None:
        """Newton in c of attraction without contact; a small contact radius where the surfaces touch."""
        for _ in range(MOST_STEPS):
            if not c < self._end:
                raise TooFarError
            e, none = CLOSE**2 * c, np.zeros(2)
            rims = self.rims(none, np.array([c, c + e]))
            off, _ = self.excess(rims, x)
            slope = (off[1] - off[0]) / e
            if not slope > 0:
                return None
            dc = float(np.clip(-off[0] / slope, -STEP_LARGEST * c, STEP_LARGEST * c))
            c += dc
            if abs(dc) < CLOSE * c:
                rims = self.rims(none[:1], np.array([c]))
                if rims.gap[0] > self.body.law.length:  # closed at the axis
                    return CLOSE * c
                return self._held(x, rims)
        return None

    def _held(self, x: float, rims: Rims) -> Found:
        """The state ``rims`` with what the device holds at ``x`` to the last digit."""
        a, c, delta, P = (float(column[0]) for column in (rims.a, rims.c, rims.delta, rims.P))
        k = self.body.stiffness
        return Found(a, c, x if math.isinf(k) else delta, x if k == LOAD_CONTROL else P, rims)

    def leap(self, x: float, c: float, inwards: bool) -> Found | None:
        """The stable state at ``x`` that is the next beyond the radius ``c``, of larger zones where it goes
        ``inwards``; None: nothing holds the surfaces together."""
        ends = self._end * np.logspace(-LEAP_DECADES, 0, LEAPS)[:-1]
        rows = ends[ends > c] if inwards else ends[ends < c]
        if not rows.size:
            return None
        a = self._contacts(rows)
        rims = self.rims(a, rows - a)
        off, _ = self.excess(rims, x)
        if inwards:
            off, a, rows = np.append(-TINY, off), np.append(0.0, a), np.append(0.0, rows)
        stable = np.flatnonzero((off[:-1] < 0) & (off[1:] >= 0))
        for i in stable if inwards else stable[::-1]:
            part = 1.0 if inwards and i == 0 else off[i] / (off[i] - off[i + 1])
            found = self.near(
                x, float(a[i] + part * (a[i + 1] - a[i])), float(rows[i] + part * (rows[i + 1] - rows[i]))
            )
            if found is not None:
                return found
        if inwards:
            raise TooFarError
        return None

    def _contacts(self, c: Array) -> Array:
        """Contact radii inside zones that end at ``c`` [m], by halving: the wider the zone, the larger the gap."""
        low, high = np.zeros_like(c), c.copy()
        open_ = self.rims(low, c).gap > self.body.law.length
        for _ in range(MOST_STEPS):
            if (high - low < CLOSE * (c - low)).all():
                break
            middle = (low + high) / 2
            wide = self.rims(middle, c - middle).gap > self.body.law.length
            low, high = np.where(wide, middle, low), np.where(wide, high, middle)
        return np.where(open_, low, 0.0)

    @property
    def _end(self) -> float:
        return self.body.attraction.reach * (1 - SAME)

    def taken(self, found: Found) -> tuple[Memory, Array, float]:
        """The memory behind the step that ends in the state ``found``, (pi/2) phi [m] at the points, and the energy [J]
        of the attraction less that of surfaces apart: -sigma times the integral of the range less the gap within c."""
        body, memory, x, energy = self.body, self.memory, self.body.points.x, 0.0
        V, kernel = np.zeros_like(x), np.zeros_like(x)
        if found.rims is not None:
            a, c, s, sigma = found.a, found.c, body.s / self.G, body.law.stress
            discs = body.attraction.discs(np.array([a]), self.profile)
            smooth = body.points.sums(discs.smooth(found.rims, s)[0])
            kernel = self.G * smooth
            pulled = kernel - body.s * np.sqrt(np.maximum((c - x) * (c + x), 0.0))
            V = np.where(x < a, self.G * (found.delta - self.profile.values), pulled)
            # int r gap dr = (2/pi) int (F + W - delta) sqrt(c^2 - x^2) dx, and W has -s sqrt(c^2 - x^2)
            open_ = DentedProfile(body.points, self.profile.values + smooth - found.delta).opened(a, c)
            open_ -= s * (c - a) ** 2 * (2 * c + a) / 3
            energy = -sigma * (math.pi * c**2 * body.law.length - 4 * open_)
        W = (V - self.H) / self.G
        eta = self.decay[:, None] * memory.eta + np.multiply.outer(self.gain, W - memory.W)
        return Memory(body, W, V, eta), V - kernel, energy


# --------------------------------------------------------------------------------------------------
# What happens under a program.


class Row(NamedTuple):
    """One moment: time [s], radii of contact and of the zone [m], tip's displacement [m], load [N]; up to it [J]: the
    work of the device, that which went into the body, the energy of the attraction, and what jumps radiated."""

    t: float
    a: float
    c: float
    delta: float
    P: float
    work: float = 0.0
    body: float = 0.0
    attraction: float = 0.0
    radiated: float = 0.0


@dataclass(eq=False)
class Course:
    """A ``body`` under a program, step by step: its ``memory``, ``rows`` and ``jumps``; ``tolerance`` of steps.
    ``rests``: whether it has relaxed for long at the program's begin."""

    body: Body
    tolerance: float
    rests: bool = False
    rows: list[Row] = field(default_factory=list)
    jumps: list[Jump] = field(default_factory=list)
    steps: int = 0

    def follow(self, program: Program) -> None:
        """Go through the ``program`` of the device, the surfaces apart before its begin; to the loss of contact where
        it goes on."""
        self.memory, self.at, self.q = Memory.none(self.body), NOTHING, np.zeros_like(self.body.F)
        self.t, self.x = float(program.t[0]), float(program.x[0])
        if self.rests:
            self._rest()
        else:
            self._record(self.memory.over(0.0), NOTHING._replace(delta=self._free(self.x)))
            if self._touches():
                self._jump(True)
        for ramp in program.ramps():
            if math.isfinite(ramp.t_end):
                self._piece(ramp.t, ramp.x, ramp.t_end, ramp.x_end)
                continue
            scale = self.body.law.stress * math.pi * self.at.c**2 if self._loaded else self.body.law.length
            lasting = (abs(ramp.x) + scale) / abs(ramp.rate)
            while self.at.c > 0:
                t = self.t
                self._piece(t, float(ramp.at(t)), t + lasting, float(ramp.at(t + lasting)), stops=True)

    def _rest(self) -> None:
        """Begin relaxed: elastic contact of the modulus r_inf E*, after which the modes remember nothing."""
        relaxed = self.body.modes.relaxed
        step = replace(self.memory.over(0.0), G=relaxed)
        found = step.leap(self.x, 0.0, True)
        assert found is not None
        self._record(step, found)
        memory = self.memory
        self.memory = replace(memory, V=relaxed * memory.W, eta=np.zeros_like(memory.eta))
        self.rows[:] = [Row(self.t, *found[:4], attraction=self.rows[-1].attraction)]

    def _piece(self, t0: float, x0: float, t1: float, x1: float, stops: bool = False) -> None:
        """One straight piece of the program; y: how much of it is done. It ``stops`` where contact is lost."""
        fastest = 1 / (float(self.body.modes.rates.max()) * max(t1 - t0, TINY))
        first, least = min(STEP_FIRST, CLOSE * fastest), min(STEP_LEAST, JUMPS * fastest)
        y, dy, last = 0.0, first, None
        while y < 1:
            if self.at.c == 0:
                if stops:
                    return
                y = self._alone(t0, x0, t1, x1, y)
                if y < 1:
                    self._jump(True)
                dy, last = first, None
                continue
            self.steps += 1
            if self.steps > STEP_MOST:
                raise Refusal(
                    f"cycle: the edge of the contact takes more than {STEP_MOST} steps, as its cohesive zone is "
                    "narrow: give a smaller --stress (a longer --range)"
                )
            dy = 1 - y if dy > (1 - y) * (1 - SAME) else min(dy, (1 - y) / 2) if 2 * dy > 1 - y else dy
            zone, x = self.at.c - self.at.a, x0 + (y + dy) * (x1 - x0)
            step = self.memory.over(dy * (t1 - t0))
            a, c = self._predicted(dy, last)
            found = step.near(x, a, c)
            missed = math.inf
            if found is not None:
                moved = abs(found.a - self.at.a) + abs(found.c - self.at.c)
                wrong = abs(found.a - a) + abs(found.c - c)
                missed = (moved / STEP_FIRST_MOVE / zone) ** 2 * self.tolerance if last is None else wrong / zone
                if moved < self._spacing:  # what the points resolve
                    missed = min(missed, self.tolerance / 4)
                if moved > 2 * STEP_LARGEST * zone:
                    missed = math.inf
            if found is None or missed > 4 * self.tolerance:
                dy *= STEP_FALLS
                if dy < least:
                    self.t, self.x = t0 + y * (t1 - t0), x0 + y * (x1 - x0)
                    self._jump(x1 > x0 or (x1 == x0 and self._grows))
                    dy, last = first, None
                continue
            last, y = (dy, self.at), 1.0 if y + dy > 1 - SAME**2 else y + dy
            self.t, self.x = t0 + y * (t1 - t0), x0 + y * (x1 - x0)
            self._record(step, found)
            dy *= float(np.clip(0.8 * math.sqrt(self.tolerance / max(missed, TINY)), STEP_FALLS, STEP_GROWS))

    def _predicted(self, dy: float, last: tuple[float, Found] | None) -> tuple[float, float]:
        """Radii a and c that go on as in the ``last`` step."""
        a, c = self.at.a, self.at.c
        if last is not None:
            more = dy / last[0]
            a, c = a + more * (a - last[1].a), c + more * (c - last[1].c)
        zone = self.at.c - self.at.a
        if self.at.a == 0:
            return 0.0, max(c, self.at.c / 2)
        a = float(np.clip(a, max(self.at.a - STEP_LARGEST * zone, self.at.a / 2), self.at.a + STEP_LARGEST * zone))
        return a, a + float(np.clip(c - a, zone / 2, 2 * zone))

    @property
    def _loaded(self) -> bool:
        return self.body.stiffness == LOAD_CONTROL

    @property
    def _spacing(self) -> float:
        return float(self.body.points.x[1])

    @property
    def _grows(self) -> bool:
        """Whether the zone moved outwards in the last steps."""
        return self.rows[-1].c > self.rows[max(len(self.rows) - LAST_STEPS, 0)].c

    def _free(self, x: float) -> float:
        """delta [m] of a tip that nothing holds, where the device is at ``x``."""
        return -self.body.law.length if self._loaded else x

    def _record(self, step: Step, found: Found) -> None:
        """Take the ``step`` to the state ``found``, with the works that it takes by the rule of trapezia, exact at
        jumps: the body's is 2 E* int (pi/2) phi dW dx."""
        memory, q, attraction = step.taken(found)
        body = self.body.points.integral((q + self.q) / 2 * (memory.W - self.memory.W))
        before = self.rows[-1] if self.rows else Row(self.t, *NOTHING[:2], found.delta, 0.0)
        self.rows.append(
            Row(
                self.t, *found[:4],
                before.work + (found.P + before.P) / 2 * (found.delta - before.delta),
                before.body + 2 * self.body.attraction.E_star * body,
                attraction,
                before.radiated,
            )
        )  # fmt: skip
        self.memory, self.at, self.q = memory, found, q

    def _jump(self, inwards: bool) -> None:
        """Jump at standing time and device: nothing relaxes."""
        step, start = self.memory.over(0.0), self.rows[-1]
        found = step.leap(self.x, self.at.c, inwards)
        if found is None and inwards:
            found = step.leap(self.x, self.at.c, False)
        self._record(step, found or NOTHING._replace(delta=self._free(self.x)))
        end = self.rows[-1]
        lost = (end.work - start.work) - (end.body - start.body) - (end.attraction - start.attraction)
        most = max(abs(energy) for row in (start, end) for energy in row[5:8])
        if lost < -CLOSE * most and not (self._loaded and found is None):
            raise Refusal(
                f"cycle: the edge of the contact is lost sight of at t = {show(self.t, 'time')}: a jump there would "
                "win energy; give a smaller --stress"
            )
        self.rows[-1] = end = end._replace(radiated=start.radiated + lost)
        self.jumps.append(Jump(_state(start), _state(end) if found else None, self.t))

    def _touches(self) -> bool:
        """Whether the surfaces that nothing holds come within the range where the device is; InputError where they do
        so beside the axis."""
        if self._loaded:
            return self.x >= 0
        values = DentedProfile(self.body.points, self.body.F + self.memory.W)
        r = float(self.body.points.x[-1]) * np.linspace(0, 1, FREE_RADII + 1)[1:]
        gaps = 2 / math.pi * values.arcs(np.zeros_like(r), r) - self.x
        centre = float(values.values[0]) - self.x
        length = self.body.law.length
        if gaps.min() < min(centre, length) * (1 - SAME):
            raise InputError(
                f"program: at t = {show(self.t, 'time')} the surfaces come within the range beside the axis, on the "
                "rim of a dent that has not recovered, which is not solved: wait longer, or end the program before"
            )
        first = (
            self.body.attraction.reach * (1 - SAME) * 10**-LEAP_DECADES
        )  # where the tip is so sharp that it is not drawn in by a jump
        rims = self.memory.over(0.0).rims(np.zeros(1), np.array([first]))
        return centre <= length * (1 + SAME) - max(float(rims.delta[0]) + length, 0.0)

    def _alone(self, t0: float, x0: float, t1: float, x1: float, y: float) -> float:
        """Nothing holds the surfaces: let the body recover until they come within the range, or to the end of the
        piece; how much of it is done."""
        if self._loaded and self.jumps:  # the tip is gone
            self.t, self.x = t1, x1
            self._record(self.memory.over((1 - y) * (t1 - t0)), NOTHING._replace(delta=self._free(x1)))
            return 1.0
        start = y
        virgin = not self.memory.W.any()
        while y < 1:
            dy = 1 - y if virgin else min((1 - start) / FREE_STEPS, 1 - y)

            def touches(dy: float, y: float = y, memory: Memory = self.memory) -> bool:
                step = memory.over(dy * (t1 - t0))
                self.memory, self.x = step.taken(NOTHING)[0], x0 + (y + dy) * (x1 - x0)
                self.t = t0 + (y + dy) * (t1 - t0)
                found = self._touches()
                self.memory = memory
                return found

            done = not touches(dy)
            if not done:
                low, high = 0.0, dy
                while high - low > SAME**2 * dy and (low + high) / 2 not in (low, high):
                    middle = (low + high) / 2
                    low, high = (low, middle) if touches(middle) else (middle, high)
                dy = high
            y = 1.0 if done and y + dy > 1 - SAME**2 else y + dy
            self.t, self.x = t0 + y * (t1 - t0), x0 + y * (x1 - x0)
            self._record(self.memory.over(dy * (t1 - t0)), NOTHING._replace(delta=self._free(self.x)))
            if not done:
                return min(y, 1 - SAME**2)
        return y


def _state(row: Row) -> TimedState:
    return TimedState(a=row.a, delta=row.delta, P=row.P, c=row.c, t=row.t)


# --------------------------------------------------------------------------------------------------
# A contact with adhesion that relaxes, and what becomes of it.


@dataclass(frozen=True, eq=False)
class RelaxingAdhesion:
    """A contact with adhesion by ``law`` of bodies whose moduli relax by ``relaxation``, in a device of ``stiffness``
    [N/m]; ``end``: the radius and the displacement [m] at the end of their series; ``tolerance`` of steps, ``rests``:
    whether they are relaxed where the program begins."""

    problem: Problem
    attracted: AttractedBody
    relaxation: Relaxation
    law: Range
    end: tuple[float, float]
    stiffness: float = DISPLACEMENT_CONTROL
    tolerance: float = STEP_TOLERANCE
    rests: bool = False

    def __post_init__(self) -> None:
        if self.relaxation.relaxed is None:
            raise InputError(
                "cycle: a power law has no instant modulus, by which a contact jumps: with adhesion give "
                "specimen.relaxation as sls or prony, or no adhesion, --w-approach 0"
            )

    @classmethod
    def of(cls, solution: Solution, law: Range, relaxation: Relaxation, stiffness: float) -> RelaxingAdhesion:
        """From a solution whose method knows the kernel."""
        if reason := unable(solution.problem, solution.method):
            raise InputError(f"{solution.record.path}: {reason}")
        end = float(solution.series.a[-1]), float(solution.series.delta[-1])
        body = AttractedBody(solution.problem, kept=solution.kernel)
        return cls(solution.problem, body, relaxation, law, end, stiffness)

    @property
    def least(self) -> float:
        """The device's position where the surfaces come within the range."""
        return 0.0 if self.stiffness == LOAD_CONTROL else -self.law.length

    def turning(self, load: float | None, depth: float | None, speed: float) -> float:
        """The device's position where an approach at ``speed`` [m/s, under load control N/s] comes to ``load`` [N] or
        ``depth`` [m]; both None: to the end of the series."""
        if self.stiffness == LOAD_CONTROL and load is not None:
            return load
        if math.isinf(self.stiffness) and load is None:
            return self.end[1] if depth is None else depth
        if load is None and depth is None:
            raise InputError("cycle: say where it turns, --to-load or --to-depth: adhesion draws it beyond the series")
        wanted, column = (load, 4) if load is not None else (depth, 3)
        assert wanted is not None
        x, unit = (max(self.law.length, self.end[1]), "length") if column == 3 else (self.law.length, "load")
        for _ in range(MOST_STEPS):
            t = (x - self.least) / speed
            try:
                course = self._run(
                    Program(np.array([0.0, t]), np.array([self.least, x])), self.tolerance * STEP_COARSER
                )
            except (InputError, Refusal):
                break
            rows = np.array(course.rows)
            if (rows[:, column] >= wanted).any():
                i = int(np.argmax(rows[:, column] >= wanted))
                part = 1.0 if i == 0 else (wanted - rows[i - 1, column]) / (rows[i, column] - rows[i - 1, column])
                then = rows[max(i - 1, 0), 0] + part * (rows[i, 0] - rows[max(i - 1, 0), 0])
                return self.least + speed * float(then)
            x = self.least + 2 * (x - self.least)
        raise InputError(f"cycle: the turn at {show(wanted, unit)} is not passed on approach")

    def within(self, program: Callable[[float], Program], x: float) -> float:
        """The turn ``x``: adhesion is followed beyond the series."""
        return x

    def history(self, program: Program) -> AdhesiveHistory:
        """What happens under ``program`` of positions [m], of loads [N] under load control."""
        course = self._run(program, self.tolerance)
        again = self._run(program, self.tolerance * STEP_COARSER, course.body.attraction.reach)
        return AdhesiveHistory(self, program, course, again)

    def _run(self, program: Program, tolerance: float, reach: float = 0.0) -> Course:
        """The ``program`` followed, on a body that is known as far as it needs to be, or to ``reach`` [m]."""
        left = self._left(program)
        self._spacing(left, self.end[0])  # refused before anything is solved
        reach = reach or self._reach(left, float(np.max(program.x)))
        for _ in range(MOST_STEPS):
            course = Course(self._body(reach, self._spacing(left, reach)), tolerance, self.rests)
            try:
                course.follow(program)
                return course
            except TooFarError:
                reach = self._further(reach)
        raise Refusal("cycle: the surfaces attract each other ever farther out")

    def _left(self, program: Program) -> float:
        """The least share of the moduli by which the body answers in the end: a bound for reaches and zones."""
        lasting = float(program.t[-1] - program.t[0])
        if program.rate:
            lasting += (abs(float(program.x[-1])) + self.law.length) / abs(program.rate)
        return max(float(self.relaxation.modes(lasting)(np.array([lasting]))[0]), LEAST_LEFT)

    def _body(self, reach: float, spacing: float) -> Body:
        attraction, indenter = self.attracted.attraction(reach), self.problem.indenter
        points = DentPoints.spaced(attraction.basis, spacing, np.array([indenter.a0, *indenter.joints]))
        return Body(attraction, points, indenter.abel(points.x), self.relaxation.modes(1.0), self.law, self.stiffness)

    def _reach(self, left: float, highest: float) -> float:
        """A radius [m] beyond that to which the surfaces attract each other where the device is ``highest``, with the
        share ``left`` of the moduli."""
        s, gap = 2 * self.law.stress / self.problem.E_star, self.law.length
        reach = self.attracted.reach(self.end[0], s, gap)
        for _ in range(MOST_STEPS):
            step = Memory.none(self._body(reach, reach / FIRST_POINTS)).over(0.0)
            try:
                found = replace(step, G=left).leap(highest, 0.0, True)
                return min(FIRST_REACH * found.c if found else reach, reach)
            except TooFarError:
                reach = self._further(reach)
        raise Refusal("cycle: the surfaces attract each other ever farther out")

    def _further(self, reach: float) -> float:
        if reach >= self.attracted.limit * (1 - SAME):
            raise InputError(
                f"cycle: the surfaces attract each other beyond {show(reach, 'length')}, the end of the profile or of "
                "the body: turn before, or hold for less time"
            )
        return min(REACH_GROWS * reach, self.attracted.limit)

    def _spacing(self, left: float, reach: float) -> float:
        """Distance [m] of the points at which the dent is known."""
        zone = ZONE_SLOPE * left * self.problem.E_star * self.law.w / self.law.stress**2
        if reach / zone * ZONE_FEWEST > MOST_POINTS:
            stress = self.law.stress * math.sqrt(MOST_POINTS * zone / reach / ZONE_FEWEST)
            raise InputError(
                f"cycle: the cohesive zone of {show(zone, 'length')} is too narrow beside {show(reach, 'length')} "
                f"to be followed: give a smaller --stress, about {show(stress, 'modulus', 2)}"
            )
        return min(max(zone / ZONE_POINTS, reach / MOST_POINTS), reach / FIRST_POINTS)


@dataclass(frozen=True, eq=False)
class AdhesiveHistory:
    """What happened to ``contact`` under ``program``: the ``course``, and the same in half as many steps."""

    contact: RelaxingAdhesion
    program: Program
    course: Course
    coarser: Course

    @property
    def control(self) -> str:
        """The control in words."""
        return control(self.contact.stiffness)

    @cached_property
    def rows(self) -> Array:
        """The columns of ``Row`` at all steps, (rows, 9)."""
        return np.array(self.course.rows)

    @property
    def jumps(self) -> list[Jump]:
        """The jumps in and out."""
        return self.course.jumps

    @property
    def lost(self) -> Jump | None:
        """The jump by which contact was lost for good; None where it is not."""
        return self.jumps[-1] if self.jumps and self.jumps[-1].end is None else None

    @property
    def pull_off(self) -> TimedState:
        """The state of the lowest load from the largest contact on."""
        return _pulled(self.course)

    @property
    def peak(self) -> TimedState:
        """The state of the largest load."""
        return _state(max(self.course.rows, key=lambda row: row.P))

    @property
    def turn(self) -> float:
        """When the contact was largest [s]."""
        return max(self.course.rows, key=lambda row: row.a).t

    @cached_property
    def corners(self) -> tuple[TimedState, ...]:
        """The states at the corners of the program while the surfaces hold each other."""
        at = {row.t: row for row in self.course.rows if row.c > 0}
        return tuple(_state(at[t]) for t in np.unique(self.program.t[1:]).tolist() if t in at)

    @cached_property
    def error(self) -> dict[str, Estimate]:
        """Relative errors of the pull-off force "P", of the time "lost" of loss since the last corner before it, and
        of the "energy": what halving the steps changes, by its order, and the energies' balance at least."""
        P = self._changed(lambda course: _pulled(course).P)
        last = (self.lost, AdhesiveHistory(self.contact, self.program, self.coarser, self.coarser).lost)
        if last[0] is None or last[1] is None:
            missing = Unknown("contact is not lost")
            return {"P": P, "lost": missing, "energy": missing}
        begin = float(np.max(self.program.t[self.program.t < last[0].t], initial=self.program.t[0]))
        since = last[0].t - begin
        lost = STEP_SAFETY / STEP_ORDER * abs(last[1].t - last[0].t) / max(since, TINY)
        energy = self._changed(lambda course: course.rows[-1].work) if not self._loaded else self._unknown
        return {"P": P, "lost": lost, "energy": energy}

    def _changed(self, of: Callable[[Course], float]) -> float:
        fine, coarse = of(self.course), of(self.coarser)
        return max(STEP_SAFETY / STEP_ORDER * abs(coarse - fine) / max(abs(fine), TINY), self.balance)

    @property
    def _loaded(self) -> bool:
        return self.contact.stiffness == LOAD_CONTROL

    @property
    def _unknown(self) -> Unknown:
        return Unknown("under load control the tip flies off")

    @property
    def energy_lost(self) -> Estimate:
        """Work of the device from first attraction to the loss of contact [J]."""
        if self.lost is None:
            return Unknown("contact is not lost")
        return self._unknown if self._loaded else self.course.rows[-1].work

    @property
    def in_body(self) -> Estimate:
        """Of the energy lost what relaxation takes [J], while what the body still holds relaxes, too."""
        return lost if isinstance(lost := self.energy_lost, Unknown) else self.course.rows[-1].body

    @property
    def at_edge(self) -> Estimate:
        """Of the energy lost what jumps radiate [J]; the attraction gives back in opening what closing took."""
        return lost if isinstance(lost := self.energy_lost, Unknown) else self.course.rows[-1].radiated

    @property
    def balance(self) -> float:
        """What the works and energies miss of balance over the largest of them [-]."""
        row = self.rows[-2 if self._loaded and self.lost else -1]
        missing = row[5] - row[6:9].sum() + self.rows[0, 7]
        return abs(float(missing)) / max(float(np.max(np.abs(self.rows[:, 5:8]))), TINY)

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole program, ``points`` to a piece, the ends of jumps and the pull-off point among them: "t_s",
        "a_m", "delta_m", "P_N", "device_m" (not under load control), "phase", "part", "c_m"."""
        rows = self.rows
        ends = np.unique(np.append(self.program.t[self.program.t <= rows[-1, 0]], rows[-1, 0]))
        even = [np.linspace(a, b, points) for a, b in itertools.pairwise(ends) if b > a]
        jumps = np.flatnonzero(np.diff(rows[:, 0]) == 0)
        kept = rows[np.unique([*jumps, *jumps + 1, int(np.flatnonzero(rows[:, 0] == self.pull_off.t)[0])])]
        t = np.setdiff1d(np.concatenate(even), kept[:, 0]) if even else np.empty(0)
        drawn = np.stack([t, *(np.interp(t, rows[:, 0], rows[:, k]) for k in range(1, 5))], axis=1)
        whole = np.concatenate([drawn, kept[:, :5]])
        whole = whole[np.argsort(whole[:, 0], kind="stable")]
        t, a, c, delta, P = whole.T
        columns = {"t_s": t, "a_m": a, "delta_m": delta, "P_N": P}
        if not self._loaded:
            columns["device_m"] = np.asarray(position(delta, P, self.contact.stiffness))
        later = np.append(c[1:], c[-1]) - np.insert(c[:-1], 0, c[0])
        still = np.abs(later) < SAME * np.max(c)
        phases = np.where(c == 0, "free", np.where(still, "rest", np.where(later > 0, "advance", "recede")))
        part = np.clip(np.searchsorted(ends, t, side="left"), 1, None)
        return columns | {"phase": phases, "part": part, "c_m": c}


def _pulled(course: Course) -> TimedState:
    """The state of the lowest load from the largest contact on, at the last one where there are several."""
    largest = max(range(len(course.rows)), key=lambda i: course.rows[i].a)
    return _state(min(course.rows[largest:], key=lambda row: (row.P, -row.t)))

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
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, Nonadhesive, control, position
from ..adhesion.device_path import Jump, Program, Ramp, TimedState
from ..adhesion.finite_range import AttractedBody, Range, unable
from ..base.errors import Estimate, InputError, JkrError, Refusal, Unknown
from ..base.numerics import MOST_STEPS, SAME, TINY, Array, zeros_between
from ..base.units import show
from ..bodies.problem import Modes, Problem, Relaxation
from ..methods.integral.finite_range import Attraction, Rims
from ..methods.integral.fredholm import angle
from ..series import Solution
from .dent import DentedProfile, DentPoints, dented_state
from .from_rest import Rest
from .rate import History, RateContact

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
STEP_ACCEPTED = 4.0  # choice: of the tolerance, what a prediction may miss in a step that is taken
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

    @property
    def end(self) -> float:
        """The radius [m] up to which it is known."""
        return self.attraction.reach * (1 - SAME)

    @property
    def loaded(self) -> bool:
        return self.stiffness == LOAD_CONTROL

    def free_delta(self, x: float) -> float:
        """delta [m] of a tip that nothing holds, where the device is at ``x``."""
        return -self.law.length if self.loaded else x


class Found(NamedTuple):
    """A state: radii of contact ``a`` and of the zone ``c`` [m], ``delta`` [m], ``P`` [N]; ``smooth``: int_0^c K phi
    on the polynomials of its body, None where K = 0."""

    a: float
    c: float
    delta: float
    P: float
    smooth: Array | None = None


NOTHING = Found(0.0, 0.0, 0.0, 0.0)


class Rim(NamedTuple):
    """``delta`` [m], ``P`` [N] and the ``gap`` [m] at c of a state of given radii a and c, the ``slopes`` (3, 2) of
    these by a and by c, and ``smooth`` as of ``Found``."""

    delta: float
    P: float
    gap: float
    slopes: Array
    smooth: Array | None


@dataclass(frozen=True, eq=False)
class Memory:
    """What the ``body`` remembers: W [m] at its points and eta_m of its modes, (m, points)."""

    body: Body
    W: Array
    eta: Array

    @classmethod
    def none(cls, body: Body) -> Memory:
        return cls(body, np.zeros_like(body.F), np.zeros((body.modes.rates.size, body.F.size)))

    def over(self, h: float) -> Step:
        """A step of ``h`` >= 0 [s] in which W moves evenly: eta -> exp(-z) eta + (1 - exp(-z))/z dW."""
        modes, z = self.body.modes, h * self.body.modes.rates
        decay = np.exp(-z)
        gain = np.divide(-np.expm1(-z), z, out=np.ones_like(z), where=z > 0)
        G = modes.relaxed + float(modes.weights @ gain)
        H = (modes.weights * decay) @ self.eta - float(modes.weights @ gain) * self.W
        return Step(self, decay, gain, G, H)


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
        """States of many contact radii ``a`` with zones ``b`` wide at once, to 1e-4, ``gap`` as it comes; P [N] is that
        of G E*. Where a = 0 nothing touches, and delta is what opens the gap at c to the range."""
        body, g, s = self.body, self.profile, self.body.s / self.G
        if body.attraction.is_half_space:
            c, theta, root = a + b, angle(b, a + b), np.sqrt(b * (2 * a + b))
            delta = g.F(a) - s * root
            gap = 2 / math.pi * (g.arcs(a, b) - delta * theta - s * b)
            P = 2 * body.attraction.E_star * (delta * a - g.inside(a) - s * (c**2 * theta - a * root) / 2)
            rims = Rims(a, c, delta, P, gap)
        else:
            rims = body.attraction.discs(a, g).rims(b, s)
        open_, length = a == 0, self.body.law.length
        delta = np.where(open_, rims.delta + rims.gap - length, rims.delta)
        return Rims(a, rims.c, delta, rims.P * self.G, rims.gap)

    def rim(self, a: float, c: float) -> Rim:
        """The state with the radii ``a`` and ``c``, whatever the gap at c, and its derivatives."""
        body, s = self.body, self.body.s / self.G
        if not body.attraction.is_half_space:
            discs = body.attraction.discs(np.array([a]), self.profile)
            rims, smooth, slopes = dented_state(discs, c - a, s)
            slopes *= np.array([[1.0], [self.G], [1.0]])
            return Rim(float(rims.delta[0]), float(rims.P[0]) * self.G, float(rims.gap[0]), slopes, smooth)
        # K = 0: delta = g(a) - s sqrt(c^2 - a^2), (pi/2) gap = int_a^c (g - delta)/sqrt(c^2 - x^2) dx - s (c - a)
        zone, E = self.profile.zone(a, c), 2 * body.attraction.E_star * self.G
        root, theta = zone.root, math.atan2(zone.root, a)
        delta = zone.F - s * root
        P = E * (delta * a - float(self.profile.inside(np.array(a))) - s * (c**2 * theta - a * root) / 2)
        gap = zone.arc + s * (root * theta - (c - a))
        by_a, by_c = zone.slope + s * a / root, -s * c / root
        gap_by_c = zone.arc_by_c + s * a / c - by_c * theta - s
        rows = [[by_a, by_c], [E * a * by_a, E * (by_c * a - s * c * theta)], [-theta * by_a, gap_by_c]]
        return Rim(delta, P, 2 / math.pi * gap, np.array(rows) * [[1.0], [1.0], [2 / math.pi]], None)

    def near(self, x: float, a: float, c: float) -> Found | None:
        """The stable state at the device's position ``x`` near to the radii ``a`` and ``c``; None: there is none."""
        for _ in range(3):  # at a = 0 the one kind of state goes over into the other
            found = self._touching(x, a, c - a) if a > 0 else self._apart(x, c)
            if not isinstance(found, float):
                return found
            a = found
        return None

    def _touching(self, x: float, a: float, b: float) -> Found | float | None:
        """Newton in a and c; 0.0 where contact is lost into mere attraction."""
        k, length, before, last = self.body.stiffness, self.body.law.length, math.inf, False
        for _ in range(MOST_STEPS):
            if not a + b < self.body.end:
                raise TooFarError
            delta, P, gap, slopes, smooth = self.rim(a, a + b)
            if last:
                return self._held(x, a, a + b, delta, P, smooth)
            off, opens = position(delta, P, k) - x, math.log(max(gap / length, TINY))
            xa, xc = position(slopes[0], slopes[1], k).tolist()
            ga, gc = (slopes[2] / max(gap, TINY)).tolist()
            det = xa * gc - xc * ga
            if not (gc > 0 and det > 0):  # dx/da along the states whose gap closes the law
                return None
            da, dc = (xc * opens - gc * off) / det, (ga * off - xa * opens) / det
            db = dc - da
            moved = max(abs(da), abs(db)) / b
            part = min(1.0, STEP_LARGEST / max(moved, TINY))
            if a + part * da <= 0:
                if a < CLOSE * b:
                    return 0.0
                part = min(part, (a - CLOSE / 2 * b) / -da)
            a, b = a + part * da, b + part * db
            last = moved < CLOSE or (moved > before > CLOSE and moved < CLOSE * STEP_LARGEST)
            before = moved
        return None

    def _apart(self, x: float, c: float) -> Found | float | None:
        """Newton in c of attraction without contact; a small contact radius where the surfaces touch."""
        k, length, last = self.body.stiffness, self.body.law.length, False
        for _ in range(MOST_STEPS):
            if not c < self.body.end:
                raise TooFarError
            rim = self.rim(0.0, c)
            opens = rim.gap - length  # the gap at c is the range
            if last and opens > 0:  # closed at the axis
                return CLOSE * c
            if last:
                return self._held(x, 0.0, c, rim.delta + opens, rim.P, rim.smooth)
            slope = position(rim.slopes[0, 1] + rim.slopes[2, 1], rim.slopes[1, 1], k)
            if not slope > 0:
                return None
            dc = (x - position(rim.delta + opens, rim.P, k)) / slope
            dc = min(max(dc, -STEP_LARGEST * c), STEP_LARGEST * c)
            c, last = c + dc, abs(dc) < CLOSE * c
        return None

    def excess(self, rims: Rims, x: float) -> Array:
        """Position of the device less ``x``."""
        return np.asarray(position(rims.delta, rims.P, self.body.stiffness)) - x

    def _held(self, x: float, a: float, c: float, delta: float, P: float, smooth: Array | None) -> Found:
        """The state with what the device holds at ``x`` to the last digit."""
        k = self.body.stiffness
        return Found(a, c, x if math.isinf(k) else delta, x if k == LOAD_CONTROL else P, smooth)

    def leap(self, x: float, c: float, inwards: bool) -> Found | None:
        """The stable state at ``x`` that is the next beyond the radius ``c`` (infinite: the largest), of larger zones
        where it goes ``inwards``; None: nothing holds the surfaces together."""
        ends = self.body.end * np.logspace(-LEAP_DECADES, 0, LEAPS)[:-1]
        rows = ends[ends > c] if inwards else ends[ends < c]
        if not rows.size:
            return None

        def wide(log_b: Array) -> Array:
            b = np.exp(log_b)
            return np.log(np.maximum(self.rims(np.maximum(rows - b, 0.0), b).gap / self.body.law.length, TINY))

        # Contact radii inside zones that end at these radii: the wider the zone, the larger the gap
        widest = np.log(rows)
        narrowest = np.where(wide(widest) > 0, np.log(SAME * rows), widest)  # else nothing touches
        a = np.where(narrowest < widest, rows - np.exp(zeros_between(wide, narrowest, widest, CLOSE)), 0.0)
        off = self.excess(self.rims(a, rows - a), x)
        if math.isinf(c) and off[-1] < 0:
            raise TooFarError
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

    def taken(self, found: Found) -> tuple[Memory, Array, float]:
        """The memory behind the step that ends in the state ``found``, (pi/2) phi [m] at the points, and the energy [J]
        of the attraction less that of surfaces apart: -sigma times the integral of the range less the gap within c."""
        body, memory, x = self.body, self.memory, self.body.points.x
        V, kernel, energy = np.zeros_like(x), np.zeros(1), 0.0
        if found.c > 0:
            (a, c, delta, *_), s, sigma = found, body.s / self.G, body.law.stress
            smooth = np.zeros(1) if found.smooth is None else body.points.sums(found.smooth)
            kernel = self.G * smooth
            pulled = kernel - body.s * np.sqrt(np.maximum((c - x) * (c + x), 0.0))
            V = np.where(x < a, self.G * (delta - self.profile.values), pulled)
            # int r gap dr = (2/pi) int (F + W - delta) sqrt(c^2 - x^2) dx, and W has -s sqrt(c^2 - x^2)
            open_ = DentedProfile(body.points, self.profile.values + smooth - delta).zone(a, c).opened
            open_ -= s * (c - a) ** 2 * (2 * c + a) / 3
            energy = -sigma * (math.pi * c**2 * body.law.length - 4 * open_)
        W = (V - self.H) / self.G
        eta = self.decay[:, None] * memory.eta + np.multiply.outer(self.gain, W - memory.W)
        return Memory(body, W, eta), V - kernel, energy


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


@dataclass(frozen=True, eq=False)
class Now:
    """A moment of a program: the device's position ``x``, what the body remembers, the state ``at``, (pi/2) phi [m] at
    its points, and the ``row`` of numbers."""

    x: float
    memory: Memory
    at: Found
    q: Array
    row: Row

    @classmethod
    def apart(cls, body: Body, t: float, x: float) -> Now:
        """The virgin body and its tip, which do not attract each other."""
        found = NOTHING._replace(delta=body.free_delta(x))
        return cls(x, Memory.none(body), found, np.zeros_like(body.F), Row(t, *found[:4]))

    @classmethod
    def at_rest(cls, body: Body, t: float, x: float) -> Now:
        """Relaxed for long: elastic contact of the modulus r_inf E*, of which the modes remember nothing."""
        relaxed = replace(Memory.none(body).over(0.0), G=body.modes.relaxed)
        found = relaxed.leap(x, math.inf, False)
        if found is None:
            raise InputError(f"program: no contact rests where it begins, at {x:.4g} {'N' if body.loaded else 'm'}")
        memory, q, attraction = relaxed.taken(found)
        return cls(
            x, replace(memory, eta=np.zeros_like(memory.eta)), found, q, Row(t, *found[:4], attraction=attraction)
        )

    def after(self, step: Step, t: float, x: float, found: Found) -> Now:
        """The moment behind a ``step`` to the state ``found``, with the works that it takes by the rule of trapezia,
        exact at jumps: the device's int P d(delta), the body's 2 E* int int (pi/2) phi dW dx."""
        memory, q, attraction = step.taken(found)
        body, before = step.body, self.row
        work = before.work + (found.P + before.P) / 2 * (found.delta - before.delta)
        taken = 2 * body.attraction.E_star * body.points.integral((q + self.q) / 2 * (memory.W - self.memory.W))
        row = Row(t, *found[:4], work, before.body + taken, attraction, before.radiated)
        return Now(x, memory, found, q, row)

    def alone(self, h: float, x: float) -> Now:
        """The moment a time ``h`` [s] later, with nothing between the surfaces."""
        found = NOTHING._replace(delta=self.memory.body.free_delta(x))
        return self.after(self.memory.over(h), self.row.t + h, x, found)

    @property
    def touches(self) -> bool:
        """Whether the surfaces that nothing holds come within the range where the device is; InputError where they do
        so beside the axis."""
        body = self.memory.body
        if body.loaded:
            return self.x >= 0
        values = DentedProfile(body.points, body.F + self.memory.W)
        r = float(body.points.x[-1]) * np.linspace(0, 1, FREE_RADII + 1)[1:]
        zones = [values.zone(0.0, c) for c in r.tolist()]
        gaps = np.array([zone.F + 2 / math.pi * zone.arc for zone in zones]) - self.x
        centre, length = float(values.values[0]) - self.x, body.law.length
        if gaps.min() < min(centre, length) * (1 - SAME):
            raise InputError(
                f"program: at t = {show(self.row.t, 'time')} the surfaces come within the range beside the axis, on "
                "the rim of a dent that has not recovered, which is not solved: wait longer, or end the program before"
            )
        # a tip so sharp that it is not drawn in by a jump touches with the least zone that is looked at
        rims = self.memory.over(0.0).rims(np.zeros(1), np.array([body.end * 10**-LEAP_DECADES]))
        return centre <= length * (1 + SAME) - max(float(rims.delta[0]) + length, 0.0)


@dataclass(frozen=True, eq=False)
class Course:
    """What happened to a ``body`` step by step: its ``rows`` and ``jumps``, and the last moment."""

    body: Body
    rows: list[Row]
    jumps: list[Jump]
    last: Now

    @property
    def pull_off(self) -> TimedState:
        """The state of the lowest load from the largest contact on, at the last one where there are several."""
        largest = max(range(len(self.rows)), key=lambda i: self.rows[i].a)
        return _state(min(self.rows[largest:], key=lambda row: (row.P, -row.t)))

    @property
    def lost(self) -> Jump | None:
        """The jump by which contact was lost for good; None where it is not."""
        return self.jumps[-1] if self.jumps and self.jumps[-1].end is None else None


def march(body: Body, program: Program, tolerance: float, rests: bool = False) -> Course:
    """Follow a ``program`` of the device step by step, to the loss of contact where it goes on; steps by their
    ``tolerance``.

    The surfaces are apart before its begin, or at rest (``rests``) with the body relaxed. A step of the time h is
    elastic contact of the modulus G E* under F - H/G (``Memory.over``) with the radii a and c of

        delta + P/k = x,     gap(c) = w/sigma                                        (``Step.near``),

    from where they would go on straight. It is taken where that is right to the ``tolerance`` of the zone, else tried
    again with a shorter h; where no h finds a stable state the contact jumps, and nothing relaxes meanwhile.
    """
    now = (Now.at_rest if rests else Now.apart)(body, float(program.t[0]), float(program.x[0]))
    rows, jumps = [now.row], list[Jump]()

    def jump(now: Now, inwards: bool) -> Now:
        there, jumped = _jump(now, inwards)
        rows.append(there.row)
        jumps.append(jumped)
        return there

    if not rests and now.touches:
        now = jump(now, True)
    ramps = deque(program.ramps())
    while ramps:
        piece = ramp = ramps.popleft()
        endless = not math.isfinite(ramp.t_end)
        if endless:  # parts of it, until contact is lost
            scale = body.law.stress * math.pi * now.at.c**2 if body.loaded else body.law.length
            t = ramp.t + (abs(ramp.x) + scale) / abs(ramp.rate)
            piece = Ramp.between(ramp.t, ramp.x, t, float(ramp.at(t)))
        fastest = 1 / (float(body.modes.rates.max()) * max(piece.t_end - piece.t, TINY))
        first, least = min(STEP_FIRST, CLOSE * fastest), min(STEP_LEAST, JUMPS * fastest)
        y, dy, before = 0.0, first, None  # the part of the piece that is done, the next step, the last one
        while y < 1 and not (endless and now.at.c == 0):
            if now.at.c == 0:
                y, moments = _wait(now, piece, y, bool(jumps))
                rows += [one.row for one in moments]
                now, dy, before = moments[-1], first, None
                if y < 1:
                    now = jump(now, True)
                continue
            if len(rows) > STEP_MOST:
                raise Refusal(
                    f"cycle: the edge of the contact takes more than {STEP_MOST} steps, as its cohesive zone is "
                    "narrow: give a smaller --stress (a longer --range)"
                )
            dy = 1 - y if dy > (1 - y) * (1 - SAME) else min(dy, (1 - y) / 2) if 2 * dy > 1 - y else dy
            end = 1.0 if y + dy > 1 - SAME**2 else y + dy
            t, x = piece.t + end * (piece.t_end - piece.t), piece.x + end * (piece.x_end - piece.x)
            step = now.memory.over(dy * (piece.t_end - piece.t))
            a, c = _predicted(now.at, dy, before)
            found = step.near(x, a, c)
            missed = _missed(now, found, a, c, before is None, tolerance)
            if found is not None and missed <= STEP_ACCEPTED * tolerance:
                before, y = (dy, now.at), end
                now = now.after(step, t, x, found)
                rows.append(now.row)
                dy *= float(np.clip(0.8 * math.sqrt(tolerance / max(missed, TINY)), STEP_FALLS, STEP_GROWS))
                continue
            dy *= STEP_FALLS
            if dy < least:
                grows = rows[-1].c > rows[max(len(rows) - LAST_STEPS, 0)].c
                now = jump(now, piece.rate > 0 or (piece.rate == 0 and grows))
                dy, before = first, None
        if endless and now.at.c > 0:
            ramps.append(replace(ramp, t=piece.t_end, x=piece.x_end))
    return Course(body, rows, jumps, now)


def _predicted(at: Found, dy: float, before: tuple[float, Found] | None) -> tuple[float, float]:
    """Radii a and c that go on as in the last step, of the length and from the state ``before``."""
    a, c, zone = at.a, at.c, at.c - at.a
    if before is not None:
        more = dy / before[0]
        a, c = a + more * (a - before[1].a), c + more * (c - before[1].c)
    if at.a == 0:
        return 0.0, max(c, at.c / 2)
    a = min(max(a, at.a - STEP_LARGEST * zone, at.a / 2), at.a + STEP_LARGEST * zone)
    return a, a + min(max(c - a, zone / 2), 2 * zone)


def _missed(now: Now, found: Found | None, a: float, c: float, first: bool, tolerance: float) -> float:
    """What the prediction ``a``, ``c`` missed over the width of the zone; infinite where the step is no step."""
    if found is None:
        return math.inf
    zone, spacing = now.at.c - now.at.a, float(now.memory.body.points.x[1])
    moved = abs(found.a - now.at.a) + abs(found.c - now.at.c)
    missed = (abs(found.a - a) + abs(found.c - c)) / zone
    if first:
        missed = (moved / STEP_FIRST_MOVE / zone) ** 2 * tolerance
    if moved < spacing:  # what the points resolve
        missed = min(missed, tolerance / 4)
    return math.inf if moved > 2 * STEP_LARGEST * zone else missed


def _jump(now: Now, inwards: bool) -> tuple[Now, Jump]:
    """Jump at standing time and device: nothing relaxes. What the works do not explain is radiated."""
    step, body, start = now.memory.over(0.0), now.memory.body, now.row
    found = step.leap(now.x, now.at.c, inwards)
    if found is None and inwards:
        found = step.leap(now.x, now.at.c, False)
    there = now.after(step, start.t, now.x, found or NOTHING._replace(delta=body.free_delta(now.x)))
    end = there.row
    lost = (end.work - start.work) - (end.body - start.body) - (end.attraction - start.attraction)
    most = max(abs(energy) for row in (start, end) for energy in row[5:8])
    if lost < -CLOSE * most and not (body.loaded and found is None):
        raise Refusal(
            f"cycle: the contact edge cannot be followed beyond t = {show(start.t, 'time')}: a jump there would "
            "gain energy; give a smaller --stress"
        )
    end = end._replace(radiated=start.radiated + lost)
    return replace(there, row=end), Jump(_state(start), _state(end) if found else None, start.t)


def _wait(now: Now, piece: Ramp, y: float, again: bool) -> tuple[float, list[Now]]:
    """Nothing holds the surfaces: let the body recover from the part ``y`` of the ``piece`` until they come within the
    range, or to its end; how much of it is done, and the moments."""
    moments, lasting, start = [now], piece.t_end - piece.t, y

    def later(dy: float) -> Now:
        return moments[-1].alone(dy * lasting, piece.x + (y + dy) * (piece.x_end - piece.x))

    if now.memory.body.loaded and again:  # the tip is gone
        return 1.0, [later(1 - y)]
    virgin = not now.memory.W.any()
    while y < 1:
        dy = 1 - y if virgin else min((1 - start) / FREE_STEPS, 1 - y)
        touches = later(dy).touches
        if touches:
            low, high = 0.0, dy
            while high - low > SAME**2 * dy and (low + high) / 2 not in (low, high):
                middle = (low + high) / 2
                low, high = (low, middle) if later(middle).touches else (middle, high)
            dy = high
        moments.append(later(dy))
        y = 1.0 if not touches and y + dy > 1 - SAME**2 else y + dy
        if touches:
            return min(y, 1 - SAME**2), moments[1:]
    return y, moments[1:]


def _state(row: Row) -> TimedState:
    return TimedState(a=row.a, delta=row.delta, P=row.P, c=row.c, t=row.t)


# --------------------------------------------------------------------------------------------------
# A contact with adhesion that relaxes, and what becomes of it.


@dataclass(frozen=True, eq=False)
class RelaxingAdhesion:
    """A contact with adhesion by ``law`` of bodies whose moduli relax by ``relaxation``, in a device of ``stiffness``
    [N/m]; ``end``: the radius and the displacement [m] at the end of their series; ``tolerance`` of steps,
    ``zone_points``: on the narrowest zone; ``rests``: whether they are relaxed where the program begins."""

    problem: Problem
    attracted: AttractedBody
    relaxation: Relaxation
    law: Range
    end: tuple[float, float]
    stiffness: float = DISPLACEMENT_CONTROL
    tolerance: float = STEP_TOLERANCE
    zone_points: int = ZONE_POINTS
    rests: bool = False

    def __post_init__(self) -> None:
        if self.relaxation.relaxed is None:
            raise InputError(
                "cycle: a power law has no instantaneous modulus, which governs jumps of the contact: give "
                "specimen.relaxation as sls or prony, or leave adhesion out (--w-approach 0)"
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
            raise InputError("cycle: give the reversal, --to-load or --to-depth: adhesion draws it beyond the solution")
        wanted, column = (load, 4) if load is not None else (depth, 3)
        assert wanted is not None
        x, unit = (max(self.law.length, self.end[1]), "length") if column == 3 else (self.law.length, "load")
        for _ in range(MOST_STEPS):
            t = (x - self.least) / speed
            try:
                course = self.course(
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
        raise InputError(f"cycle: the reversal at {show(wanted, unit)} is not reached on approach")

    def within(self, program: Callable[[float], Program], x: float) -> float:
        """The turn ``x``: adhesion is followed beyond the series."""
        return x

    def pulled_from(self, rest: Rest) -> float:
        """The device's position at ``rest``, relaxed; InputError where no contact rests there."""
        held, x = (LOAD_CONTROL, rest.load) if rest.depth is None else (DISPLACEMENT_CONTROL, rest.depth)
        relaxed = self.relaxation.relaxed or 0.0
        if not relaxed > 0:
            raise InputError("cycle: the relaxed modulus is zero: no contact is at rest: leave --rest-load and "
                             "--rest-depth out")  # fmt: skip
        reach = self._reach(relaxed, self.end[1])
        for _ in range(MOST_STEPS):
            body = replace(self._body(reach, self._spacing(relaxed, reach)), stiffness=held)
            step = replace(Memory.none(body).over(0.0), G=relaxed)
            try:
                if (found := step.leap(x, math.inf, False)) is None:
                    raise InputError(f"cycle: no contact rests at {rest.words}")
                return float(position(found.delta, found.P, self.stiffness))
            except TooFarError:
                reach = self._further(reach)
        raise Refusal("cycle: the attraction of the surfaces extends without limit")

    def history(self, program: Program) -> AdhesiveHistory:
        """What happens under ``program`` of positions [m], of loads [N] under load control."""
        course = self.course(program, self.tolerance)
        again = self.course(program, self.tolerance * STEP_COARSER, course.body.attraction.reach)
        return AdhesiveHistory(self, program, course, again)

    def course(self, program: Program, tolerance: float, reach: float = 0.0) -> Course:
        """The ``program`` followed, on a body that is known as far as it needs to be, or to ``reach`` [m]."""
        # The least share of the moduli by which the body answers in the end: a bound for reaches and zones
        lasting = float(program.t[-1] - program.t[0])
        if program.rate:
            lasting += (abs(float(program.x[-1])) + self.law.length) / abs(program.rate)
        left = max(float(self.relaxation.modes(lasting)(np.array([lasting]))[0]), LEAST_LEFT)
        self._spacing(left, self.end[0])  # refused before anything is solved
        reach = reach or self._reach(left, float(np.max(program.x)))
        for _ in range(MOST_STEPS):
            try:
                return march(self._body(reach, self._spacing(left, reach)), program, tolerance, self.rests)
            except TooFarError:
                reach = self._further(reach)
        raise Refusal("cycle: the attraction of the surfaces extends without limit")

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
        raise Refusal("cycle: the attraction of the surfaces extends without limit")

    def _further(self, reach: float) -> float:
        if reach >= self.attracted.limit * (1 - SAME):
            raise InputError(
                f"cycle: the surfaces attract each other beyond {show(reach, 'length')}, the end of the profile or of "
                "the body: reverse before, or hold for less time"
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
        whole = FIRST_POINTS * self.zone_points / ZONE_POINTS
        return min(max(zone / self.zone_points, reach / MOST_POINTS), reach / whole)


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
        return self.course.lost

    @property
    def pull_off(self) -> TimedState:
        """The state of the lowest load from the largest contact on."""
        return self.course.pull_off

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
        P = self._changed(lambda course: course.pull_off.P)
        last = self.lost, self.coarser.lost
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
        if self.contact.rests:
            return Unknown("contact begins at rest, with energy already stored")
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


# --------------------------------------------------------------------------------------------------
# What a law w(v) of the same material says of a course in which the bulk relaxes.
#
# Tests of adhesion are often evaluated as if the bulk were relaxed and only the crack lost energy, by a work of
# adhesion that grows with the speed v of the contact line. For a cohesive stress sigma that law is known. In a steady
# crack with the energy release rate G of the relaxed modulus E_inf the zone is L long, and its end, a time t(x) = (L
# - x)/v behind the place x, has opened by the compliance J of the moduli relaxed (Schapery, Int. J. Fract. 11 (1975)
# 141; Greenwood, J. Phys. D 37 (2004) 2557):
#
#     L = pi E_inf G/(4 sigma^2),     w/G = int_0^1 F'(y) J((1 - y) L/v)/J(infinity) dy,     F' = artanh(sqrt(y)),
#
# from G = w at rest to w E_0/E_inf where nothing relaxes at the tip.

CRACK_ROWS = 200  # choice: of the law; between them it is interpolated in logs
CRACK_NEAREST = 1e-5  # choice: of the range of G, how near to its ends the law is known; beyond it is straight
CRACK_NODES = 200  # choice: of the integral over the zone, good to 1e-6
CRACK_DECADES = 12  # choice: of speeds about the zone's length over the times of relaxation, in which v is looked for
CRACK_HALVINGS = 60  # theory: of their logs, to rounding
ENOUGH = 0.1  # choice: of the force and of the way to pull-off, up to which a rate law will do
TABLE_ROWS = 400  # choice: of a piece, between which the law's course is interpolated


def creep(modes: Modes) -> tuple[float, Array, Array]:
    """The creep function of r(t) = ``modes``, r(0) = 1: J_inf, weights c, rates q [1/s] of J_inf - sum c exp(-q t).

    Under a constant load W = 1 + w xi and dxi/dt = k (W - xi) of every mode.
    """
    A = modes.rates[:, None] * (modes.weights - np.eye(modes.rates.size))
    q, vectors = np.linalg.eig(A)
    settled = -np.linalg.solve(A, modes.rates)
    c = (modes.weights @ vectors) * np.linalg.solve(vectors, settled)
    return 1 + float(modes.weights @ settled), np.real(c), -np.real(q)


@dataclass(frozen=True, eq=False)
class CrackRate:
    """The law of a crack under a cohesive ``stress`` [Pa] and ``w`` [J/m^2] in a body of the instantaneous modulus
    ``E_star`` [Pa] and ``modes`` of relaxation, w(v) on its relaxed moduli."""

    w: float
    stress: float
    E_star: float
    modes: Modes

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """log v and log(G/w - 1)."""
        relaxed = self.modes.relaxed
        most = 1 / relaxed - 1
        side = np.geomspace(CRACK_NEAREST, 0.5, CRACK_ROWS // 2)
        excess = most * np.concatenate([side, 1 - side[-2::-1]])
        G = self.w * (1 + excess)
        L = math.pi * relaxed * self.E_star * G / (4 * self.stress**2)
        x, weights = np.polynomial.legendre.leggauss(CRACK_NODES)
        part = (x + 1) / 2  # y = 1 - part^2: F' is singular at the zone's end, as a log
        density = np.arctanh(np.sqrt(1 - part**2)) * part * weights
        J_inf, c, q = creep(self.modes)

        def opened(log_v: Array) -> Array:
            times = part**2 * (L / np.exp(log_v))[:, None]
            return 1 - np.exp(-np.multiply.outer(times, q)) @ c @ density / J_inf

        reach = CRACK_DECADES * math.log(10)
        low, high = np.log(L * q.min()) - reach, np.log(L * q.max()) + reach
        for _ in range(CRACK_HALVINGS):
            middle = (low + high) / 2
            slow = opened(middle) > self.w / G
            low, high = np.where(slow, middle, low), np.where(slow, high, middle)
        return low, np.log(excess)

    def work(self, w0: Any, v: Any) -> Any:
        """w [J/m^2] at the speeds ``v`` [m/s]."""
        log_v, log_excess = self._table
        x = np.log(np.maximum(v, np.finfo(float).tiny))
        return w0 * (1 + np.exp(np.interp(x, log_v, log_excess) + np.minimum(x - log_v[0], 0.0)))

    def speed(self, w0: float, excess: float) -> float:
        """The speed [m/s] at which w is ``excess`` [J/m^2] beyond ``w0``; infinite beyond the largest w."""
        log_v, log_excess = self._table
        x = math.log(max(excess / w0, np.finfo(float).tiny))
        if x >= log_excess[-1]:
            return math.inf
        return math.exp(float(np.interp(x, log_excess, log_v)) + min(x - float(log_excess[0]), 0.0))


@dataclass(frozen=True, eq=False)
class RateLawCourse:
    """What the ``law`` of the same material says, ``history``, where only the contact line of a relaxed specimen loses
    energy, of what happens in ``course``."""

    course: AdhesiveHistory
    law: CrackRate
    history: History

    @property
    def force_difference(self) -> float:
        """Pull-off force of the law over that of the course, less 1."""
        return self.history.pull_off.P / self.course.pull_off.P - 1

    @property
    def depth_difference(self) -> float:
        """Displacement at pull-off of the law less that of the course [m]."""
        return self.history.pull_off.delta - self.course.pull_off.delta

    @property
    def stroke(self) -> float:
        """The way of the tip from its turn to pull-off in the course [m]."""
        return float(np.max(self.course.rows[:, 3])) - self.course.pull_off.delta

    @property
    def enough(self) -> bool:
        """Whether the law tells force and place of pull-off to a tenth."""
        return max(abs(self.force_difference), abs(self.depth_difference) / self.stroke) < ENOUGH

    def columns(self, t: Array) -> dict[str, Array]:
        """Radius, displacement and load by the law at the times ``t`` [s] of the course."""
        table = self.history.table(TABLE_ROWS)
        return {f"rate_{name}": np.interp(t, table["t_s"], table[name]) for name in ("a_m", "delta_m", "P_N")}


def follow_crack_law(course: AdhesiveHistory, relaxed: Nonadhesive) -> RateLawCourse | Unknown:
    """The same program on the ``relaxed`` specimen, by the law w(v) of its cracks."""
    contact = course.contact
    law = CrackRate(contact.law.w, contact.law.stress, contact.problem.E_star, contact.relaxation.modes(1.0))
    rated = RateContact(relaxed, law, law.w, law.w, contact.stiffness)
    try:
        history = rated.history(course.program, course.course.rows[0].a if contact.rests else None)
    except (JkrError, Refusal, InputError) as error:
        return Unknown(str(error))
    if history.out_of_series is not None:
        return Unknown(history.out_of_series)
    return RateLawCourse(course, law, history)

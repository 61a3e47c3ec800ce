"""The modulus, a law of relaxation, w and its cohesive stress from one whole force curve, with its free rows.

Every row counts, by P_read = P0 + tilt (z - z_0) + P(t; body, w, stress, law) + noise: where the fitted contact is
not, P = 0, so that free rows say what offset, tilt and noise are and nothing else. The loads are marches of all trial
parameters at once (``lockstep_march.py``), P(E, w, sigma) = E p(w/E, sigma/E). Which side of a jump a row lies on is
not known within some rows of it: they are left out, and the time of the jump is a reading of its own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.finite_range import AttractedBody
from ..base.errors import InputError, SolveError
from ..base.numerics import FEWEST_ROWS, SAME, TINY, Array
from ..base.units import show
from ..bodies.problem import Modes, PowerRelaxation, Relaxation
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import SEARCH_MISFIT, Intervals, Least, LeastSquares, State, covariance
from ..measured.lockstep import together
from ..measured.parameters import Unknowns
from .lockstep_march import March, Marched, Trial
from .relaxing_adhesion import ZONE_SLOPE
from .timed_record import (
    BESIDE,
    MISFIT,
    MOTION_MOST,
    RELAXED,
    ROWS_APART,
    UNSETTLED,
    RelaxationFit,
    RelaxationSettings,
    TimedRecord,
    check_over_time,
    check_rising,
    corners,
    noise_of,
    through,
)

# How the rows are read.
BASE_FIRST = 0.02  # choice: of the rows, those of a base line at first; doubled while the loads stay on it
BASE_FEWEST = 10  # choice: of rows that make a base line
EVEN = 3e-4  # choice: of the way, what a device that moves evenly may be off
BINS = 120  # choice: places of a device that does not move in straight pieces
DEEPER = 1.5  # choice: times the depth, to which a body is solved
# Where a search begins.
RATIOS, TIMES, SHARES = (0.25, 0.75), (0.15,), (0.0, 0.5, 1.0)  # choice: shares: from very fast to from rest
ONSETS, APART_TIMES = (0.003, 0.05), 4.0  # choice: of power laws; from time to time of a series
ZONES = (0.25, 0.02, 0.0)  # choice: zones over the contact radius, where no range is known; 0: the likely range
LINE = ("P0", "tilt")
APART = 1.5  # theory: rows from a jump, within which no row shows when it was
JUMP_SEEN = 7.0  # theory: of the noise, a step between two rows that it does not make
NEAR = 10  # choice: rows, within which a jump lies that is seen
MEAN = 3  # choice: rows to either side, of whose loads means are taken
MODULI, TRIED = 1e6, 50  # choice: in those of the body, the moduli among which a search begins
FARTHEST = 4.0  # choice: of logs, from where a search begins
ROUNDS = 3  # choice: modulus and zero in turn, good to a tenth
SEEN = 4.0  # choice: part of the pull-off force, beyond noise
BEGINS = 3  # choice: searches
# choice: zones over contact radii at least, tolerances of steps, evaluations at most, of a search and of the fit
SEARCH, FINE = (0.03, 1e-2, 4), (0.012, 4e-3, 12)
FINEST = 0.5  # choice: of these zones, those that are extrapolated with them
ROUGH = 0.02  # choice: of the pull-off force, what a search may miss
ROUGH_TIME, JUMP_TIME = 0.003, 4e-4  # choice: of the time in contact, errors of jumps in a search and of the march
ROUGH_STEPS = 400  # choice: of a march, twice those of usual records, where a rough fit is to exclude the law
STRAIGHT, VALLEYS = 2, 3  # choice: evaluations between, and steps along valleys
CONVERGED = 0.5  # theory: of the sum of squares of rows by their noise: less than a standard error
POWER_STEP = 1.4  # theory: of log rates of a power law's exponentials, which then err by 1e-3
POWER_SLOWEST, POWER_LEAST = 0.02, 1e-6  # theory: rates times time that one stands for; weights that do not count
STEP = 0.01  # choice: of logs of the modulus and w, for differences; of others what changes loads alike
STEPS = {"time": 0.05, "onset": 0.3, "stress": 0.1, "delta0": 0.003, "ratio": 0.01, "weight": 0.01, "exponent": 0.01}
MARCH_ERROR = 0.5  # choice: of what zones half as wide change, extrapolated, what they may still err by
LOAD_ERROR = 1e-3  # choice: of loads and pull-off force; twice what fine marches differ from those of other equations
GIVEN_UP = "the contact of the fitted values could not be followed to its end"
# What is likely before: half-widths of normal distributions.
LIKELY_RANGE, RANGES = 4.5e-10, 3.0  # theory: w/stress of dry contact, 0.2 to 1 nm; log: 20 times it is no rarity
LIKELY = {"ratio": (0.5, 0.5), "weight": (0.4, 0.4), "exponent": (0.3, 0.4)}  # choice: hardly anything
LIKELY_TIMES = {"time": (0.25, 4.0), "onset": (0.01, 4.0)}  # choice: over the time in contact, and of logs


@dataclass(frozen=True, eq=False)
class ElasticLimits:
    """What the adhesive curves of a ``body`` that does not relax say of a record: where a search begins."""

    body: Nonadhesive

    @cached_property
    def _pulls(self) -> tuple[Array, Array]:
        """Logs of w over the modulus, and of the pull-off force over it."""
        a, P, S, dS = self.body.a, self.body.series.P, self.body.slopes.S, self.body.slopes.dS
        least = float(np.min(P**2 / (S**2 * 4 * math.pi * a / dS)))
        w = least * np.geomspace(1, 1e12, 200)
        pulled = np.max(S * np.sqrt(4 * math.pi * w[:, None] * a / dS) - P, axis=1)
        rising = pulled > 0
        return np.log(w[rising]), np.log(pulled[rising])

    def work(self, modulus: float, force: float) -> float:
        """The work of adhesion [J/m^2] behind a pull-off ``force`` [N] with the ``modulus`` in those of the body."""
        return modulus * math.exp(float(np.interp(math.log(force / modulus), self._pulls[1], self._pulls[0])))

    def modulus(self, delta: float, P: float, work: Callable[[float], float]) -> float:
        """The largest modulus, in those of the body, with which the load at ``delta`` [m] is ``P`` [N] under the
        ``work`` [J/m^2] of adhesion of each modulus."""
        a, series, slopes = self.body.a, self.body.series, self.body.slopes
        above, beyond = math.inf, MODULI
        for modulus in np.geomspace(MODULI, 1 / MODULI, TRIED).tolist():
            shift = np.sqrt(4 * math.pi * work(modulus) * a / (modulus * slopes.dS))
            there = series.delta - shift
            i = int(np.argmin(there))
            load = float(np.interp(delta, there[i:], (modulus * (series.P - slopes.S * shift))[i:]))
            if load <= P < above:
                part = (P - load) / (above - load) if math.isfinite(above) else 0.0
                return modulus * (beyond / modulus) ** part
            above, beyond = load, modulus
        return beyond


@dataclass(frozen=True, eq=False)
class Cycle:
    """A force curve over time: what the device did, ``t`` [s], ``z`` [m], ``stiffness`` [N/m], by its ``program``
    (corners), the loads ``P`` [N] with their ``noise``, the masks of ``before`` and ``behind`` of free rows."""

    curve: Curve
    t: Array
    z: Array
    P: Array
    stiffness: float
    program: tuple[Array, Array]
    straight: bool
    noise: float
    before: slice
    behind: slice

    @classmethod
    def of(cls, curve: Curve) -> Cycle:
        check_over_time(curve, "a fit of relaxation")
        if len(curve) < FEWEST_ROWS:
            raise InputError(f"{curve.where}: {len(curve)} rows, at least {FEWEST_ROWS} are needed")
        t, P = curve.time, curve.load
        check_rising(curve.where, t, np.arange(len(curve)))
        k, z = _moved(curve)
        knots = _corners(t, z)
        straight = knots[0].size < MOTION_MOST
        if not straight:
            edges = np.unique(np.linspace(0, t.size, BINS + 1).astype(int))
            means = [np.add.reduceat(one, edges[:-1]) / np.diff(edges) for one in (t, z)]
            knots = (np.r_[t[0], means[0], t[-1]], np.r_[z[0], means[1], z[-1]])
        noise = noise_of(P)
        first, last = _base_line(t, P, noise), _base_line(-t[::-1], P[::-1], noise)
        return cls(curve, t, z, P, k, knots, straight, noise, slice(0, first), slice(t.size - last, t.size))

    @property
    def free(self) -> Array:
        """Mask of rows that are free of contact, as far as is seen before a fit."""
        mask = np.zeros(self.t.size, dtype=bool)
        mask[self.before] = mask[self.behind] = True
        return mask

    @cached_property
    def base(self) -> tuple[float, float]:
        """Offset [N] and tilt [N/m] of the free rows; 0 where there are none."""
        rows = self.free
        if rows.sum() < BASE_FEWEST:
            return 0.0, 0.0
        x = self.z[rows] - self.z[0]
        if np.ptp(x) < 1e-3 * np.ptp(self.z):
            return float(np.mean(self.P[rows])), 0.0
        tilt, offset = np.polyfit(x, self.P[rows], 1)
        return float(offset), float(tilt)

    @cached_property
    def load(self) -> Array:
        """The loads less the base line [N]."""
        return self.P - self.base[0] - self.base[1] * (self.z - self.z[0])

    @cached_property
    def tip(self) -> Array:
        """The displacement of the tip [m]."""
        return self.z if math.isinf(self.stiffness) else self.z - self.load / self.stiffness

    @cached_property
    def contact(self) -> tuple[int, int]:
        """The first row in contact and the first behind it."""
        seen = np.flatnonzero(np.abs(self.load) > ROWS_APART * self.noise)
        first = max(self.before.stop, int(seen[0])) if seen.size and self.before.stop else self.before.stop
        return first, self.behind.start

    @property
    def spacing(self) -> float:
        """Time from row to row [s]."""
        return float(np.median(np.diff(self.t)))

    @cached_property
    def jumps(self) -> tuple[float, float]:
        """When the loads jump at the begin and at the end of contact, between two rows, infinite where they do not by
        more than their noise; of a record that ends in contact its last row [s]."""
        steps, times = np.diff(self.P), []
        for edge, sign in ((self.before.stop, -1.0), (self.behind.start, 1.0)):
            first = max(edge - NEAR, 0)
            near = sign * steps[first : edge + NEAR]
            i = first + int(np.argmax(near)) if near.size else 0
            seen = 0 < edge < self.t.size and sign * steps[i] > JUMP_SEEN * self.noise
            times.append(float(self.t[i] + self.t[i + 1]) / 2 if seen else math.inf)
        return times[0], float(self.t[-1]) if self.held else times[1]

    @property
    def held(self) -> bool:
        """Whether the last row is in contact."""
        return self.behind.start == self.t.size

    @property
    def lasting(self) -> float:
        """Time in contact [s]."""
        first, end = self.contact
        return float(self.t[min(end, self.t.size - 1)] - self.t[first])

    @cached_property
    def pulled(self) -> float:
        """The pull-off force [N]."""
        many = 2 * MEAN + 1
        smooth = np.convolve(np.pad(self.load, MEAN, mode="edge"), np.full(many, 1 / many), "valid")
        return -min(float(np.min(smooth)), float(np.min(self.load)) / 2)

    def record(self) -> TimedRecord:
        """The same as fits of relaxation report it."""
        noise, flags = (noise_of(self.z), self.noise), list[str]()
        if self.curve.stiffness is None and math.isfinite(self.stiffness):
            flags.append(f"the stiffness of the device, {show(self.stiffness, 'stiffness')}, is found from its motion: "
                         "its error is not in the intervals")  # fmt: skip
        if not self.straight:
            flags.append(f"nothing moved in straight pieces: means of {BINS} places stand for the motion")
        own = self.curve, self.t, self.z, self.P
        return TimedRecord(*own, "displacement", self.stiffness, self.program, noise, noise, read=not self.straight,
                           flags=tuple(flags), lasting=self.lasting)  # fmt: skip


def _corners(t: Array, z: Array) -> tuple[Array, Array]:
    some = np.unique(np.linspace(0, t.size - 1, min(t.size, 1000)).astype(int))
    times, _ = corners(t[some], z[some], max(noise_of(z[some]), EVEN * float(np.ptp(z))))
    if times.size >= MOTION_MOST:
        return times, through(t, z, times)[0]
    # a corner is where the straight lines of both sides meet
    gap, lines = 2 * float(np.median(np.diff(t[some]))), []
    for begin, end in itertools.pairwise(times.tolist()):
        rows = (t > begin + gap) & (t < end - gap)
        if rows.sum() < 3:
            return times, through(t, z, times)[0]
        lines.append(np.polyfit(t[rows] - times[0], z[rows], 1))
    for i, (one, other) in enumerate(itertools.pairwise(lines), 1):
        meets = times[0] + float((other[1] - one[1]) / (one[0] - other[0])) if one[0] != other[0] else math.nan
        if abs(meets - times[i]) < 2 * gap:
            times[i] = meets
    ends = [np.polyval(lines[min(i, len(lines) - 1)], at - times[0]) for i, at in enumerate(times)]
    return times, np.array(ends)


def _moved(curve: Curve) -> tuple[float, Array]:
    """The stiffness [N/m] and the places [m] of the device; where the stiffness is not known and the tip does not move
    in straight pieces, that with which the device did: z = delta + P/k."""
    if curve.stiffness is not None:
        return float(curve.stiffness), curve.device
    t, delta, P = curve.time, curve.depth, curve.load
    knots = _corners(t, delta)
    off = delta - np.interp(t, *knots)
    steps = np.diff(np.stack([delta, P]), axis=1)
    steps = steps - np.median(steps, axis=1)[:, None]
    compliance = -float(steps[0] @ steps[1]) / max(float(steps[1] @ steps[1]), TINY)
    if compliance <= 0:
        return math.inf, delta
    for _ in range(2):
        times = _corners(t, delta + compliance * P)[0]
        hats = np.stack([np.interp(t, times, row) for row in np.eye(times.size)], axis=1)
        found = np.linalg.lstsq(np.column_stack([hats, -P]), delta, rcond=None)[0]
        compliance = float(found[-1])
        if compliance <= 0:
            return math.inf, delta
    z = delta + compliance * P
    straighter = float(np.std(z - through(t, z, times)[1]))
    if knots[0].size < MOTION_MOST and straighter > 0.7 * float(np.std(off)):
        return math.inf, delta
    return 1 / compliance, z


def _base_line(t: Array, P: Array, noise: float) -> int:
    """How many rows from the begin on lie on a straight line."""
    n = max(BASE_FEWEST, int(BASE_FIRST * t.size))
    if n >= t.size or np.std(P[:n] - np.polyval(np.polyfit(t[:n] - t[0], P[:n], 1), t[:n] - t[0])) > 1.5 * noise:
        return 0
    block = max(n // 2, BASE_FEWEST)
    while n < t.size:
        line = np.polyfit(t[:n] - t[0], P[:n], 1)
        x = t[n : n + block] - t[0]
        off = P[n : n + block] - np.polyval(line, x)
        known = noise * np.sqrt(4 / n * (1 + 3 * (x / (t[n - 1] - t[0])) ** 2))  # of the line
        out = np.abs(off) > ROWS_APART * np.hypot(noise, known)
        pairs = out[:-1] & out[1:]
        if pairs.any():
            return max(n + int(np.argmax(pairs)) - MEAN, n // 2)
        if abs(float(off.mean())) > ROWS_APART * math.hypot(noise / math.sqrt(off.size), float(known.mean())):
            if block <= BASE_FEWEST:
                return n
            block = max(block // 2, BASE_FEWEST)
            continue
        n += off.size
        block = max(n // 2, BASE_FEWEST)
    return n


@dataclass(frozen=True, eq=False)
class Adhering:
    """The residuals of a ``cycle`` as a function of ``unknowns``, with marches of ``width`` and ``tolerance``;
    ``sigma``: standard deviations of the loads, ``left_out``: rows near jumps, ``jumps``: times of the begin and end of
    contact and their standard deviations (2, 2), infinite where there are none; ``correction``: what narrower zones add
    to the loads [N]."""

    body: FittedBody
    attracted: AttractedBody
    cycle: Cycle
    settings: RelaxationSettings
    unknowns: Unknowns
    width: float
    tolerance: float
    sigma: Array
    jumps: Array
    left_out: Array
    correction: Array | float = 0.0

    def trial(self, theta: Array) -> Trial:
        """The specimen of the unknowns ``theta``."""
        values = self.unknowns.values(theta)
        m, w = self.instant(theta), values["w"]
        stress = values["stress"] if "stress" in values else w / values["range"]
        modes = _few(self.settings.relaxation(values), float(np.ptp(self.cycle.t)))
        return Trial(w / m, stress / m, self.cycle.stiffness / m, modes, values["delta0"])

    def marched(self, thetas: Sequence[Array]) -> list[Marched]:
        """Marches of many unknowns."""
        return self.march([self.trial(theta) for theta in thetas])

    def march(self, trials: Sequence[Trial]) -> list[Marched]:
        """Marches of many trials."""
        steps = None if self.settings.most is None else ROUGH_STEPS
        how = self.cycle.program, self.width, self.tolerance, steps
        return March(self.body.problem, self.attracted, trials, *how).run()

    def instant(self, theta: Array) -> float:
        """The modulus at t = 0, in those of the body."""
        values = self.unknowns.values(theta)
        law = {name: np.asarray(values[name]) for name in self.settings.of_law}
        return float(values["modulus"] * RELAXED[self.settings.law](law, np.zeros(1))[0])

    def loads(self, theta: Array, marched: Marched) -> Array:
        """The loads that are read [N]."""
        values, cycle = self.unknowns.values(theta), self.cycle
        line = values["P0"] + values["tilt"] * (cycle.z - cycle.z[0])
        found: Array = line + self.instant(theta) * marched.load(cycle.t) + self.correction
        return found

    def corrected(self, theta: Array, here: Marched, narrow: Marched) -> Adhering:
        """The same with what zones of no width change from the march ``here`` with ``theta``, by a ``narrow`` one, in
        loads and in the end of contact."""
        t = self.cycle.t
        change = self.instant(theta) * (narrow.load(t) - here.load(t)) / (1 - FINEST)
        change = np.where(self.apart(here, (narrow.begun, narrow.lost)), 0.0, change)
        later = (narrow.lost - here.lost) / (1 - FINEST)
        jumps = self.jumps.copy()
        jumps[1, 0] -= later if math.isfinite(later) and math.isfinite(jumps[1, 1]) else 0.0
        return replace(self, correction=change, jumps=jumps)

    def apart(self, one: Marched, other: tuple[float, float]) -> Array:
        """Mask of rows between jumps of a march and ``other`` ones."""
        t, mask = self.cycle.t, np.zeros(self.cycle.t.size, dtype=bool)
        for mine, theirs in zip((one.begun, one.lost), other, strict=True):
            low, high = min(mine, theirs), max(mine, theirs)
            if math.isfinite(low):
                mask |= (t >= low) & (t <= high)
        return mask

    def state(self, theta: Array, marches: Sequence[Marched]) -> State:
        """Residuals and derivatives from the march at ``theta`` and those of its steps."""
        cycle, here, steps, left = self.cycle, marches[0], self.steps(theta), iter(marches[1:])
        times, seen = self.times(here), np.isfinite(self.jumps[:, 1])
        off = np.where(self.out(here), 0.0, (self.loads(theta, here) - cycle.P) / self.sigma)
        columns = []
        for i, name in enumerate(self.unknowns.names):
            if name in LINE:
                line = (1.0 if name == "P0" else cycle.z - cycle.z[0]) * self.unknowns.scales[i]
                columns.append(np.append(np.where(self.out(here), 0.0, line / self.sigma), np.zeros(seen.sum())))
            else:
                moved = theta + steps[i] * (np.arange(theta.size) == i)
                columns.append(self.change(theta, here, moved, next(left)) / steps[i])
        prior, J_prior = self.prior(theta)
        J = np.concatenate([np.stack(columns, axis=1), J_prior])
        return State(np.concatenate([off, ((times - self.jumps[:, 0]) / self.jumps[:, 1])[seen], prior]), lambda: J)

    def times(self, one: Marched) -> Array:
        """When contact began and was lost [s], not beyond the record."""
        cycle, late = self.cycle, self.cycle.t[-1] + self.cycle.lasting / 4
        return np.minimum([one.begun, one.lost], [late, self.jumps[1, 0] if cycle.held else late])

    def out(self, one: Marched) -> Array:
        """Mask of rows that do not count: beside jumps, or between those of the record and of the march ``one``."""
        mine, t = np.array([one.begun, one.lost]), self.cycle.t
        theirs = np.where(np.isfinite(self.jumps[:, 1]), self.jumps[:, 0], mine)
        beside = np.any(np.abs(t[:, None] - mine) < APART * self.cycle.spacing, axis=1)
        return self.left_out | self.apart(one, (float(theirs[0]), float(theirs[1]))) | beside

    def change(self, theta: Array, here: Marched, moved: Array, there: Marched) -> Array:
        """How residuals, of loads and jumps, change from the march ``here`` at ``theta`` to ``there`` at ``moved``."""
        seen = np.isfinite(self.jumps[:, 1])
        out = self.out(here) | self.apart(here, (there.begun, there.lost))
        loads = np.where(out, 0.0, (self.loads(moved, there) - self.loads(theta, here)) / self.sigma)
        return np.append(loads, ((self.times(there) - self.times(here)) / self.jumps[:, 1])[seen])

    def march_errors(self, here: Marched, theta: Array) -> Array:
        """What loads of marches may err by, in standard deviations of the rows, in each half of each piece."""
        cycle, times = self.cycle, self.cycle.program[0]
        cuts = np.sort(np.concatenate([times, (times[1:] + times[:-1]) / 2]))
        P = self.instant(theta) * here.load(cycle.t)
        err = np.where(self.left_out, 0.0, LOAD_ERROR * (np.abs(P) + cycle.pulled * (P != 0)) / self.sigma)
        piece = np.clip(np.searchsorted(cuts, cycle.t, side="right") - 1, 0, cuts.size - 2)
        return err[:, None] * (piece[:, None] == np.arange(cuts.size - 1))

    def steps(self, theta: Array) -> Array:
        """Of the unknowns for differences: shares towards the middle."""
        steps = np.array([STEPS.get(name.rstrip("0123456789"), STEP) for name in self.unknowns.names])
        shares = np.array([one.kind != "log" and one.name != "delta0" for one in self.unknowns.free])
        return np.where(shares & (theta > 0.5), -steps, steps)

    def prior(self, theta: Array) -> tuple[Array, Array]:
        """What is likely before, as residuals."""
        values, names, unit = self.unknowns.values(theta), self.unknowns.names, np.eye(theta.size)
        rows, by = list[float](), list[Array]()
        for i, name in enumerate(names):
            if likely := _likely(name, self.cycle.lasting):
                rows.append((theta[i] - likely[0]) / likely[1])
                by.append(unit[i] / likely[1])
        for name, sign in (("stress", -1), ("range", 1)):
            if name in names:
                length = values["range"] if name == "range" else values["w"] / values["stress"]
                rows.append(math.log(length / LIKELY_RANGE) / RANGES)
                w = unit[names.index("w")] if "w" in names and name == "stress" else 0.0
                by.append((sign * unit[names.index(name)] + w) / RANGES)
        return np.array(rows), np.array(by).reshape(-1, theta.size)

    def asked(self, theta: Array) -> list[Array]:
        """The unknowns whose marches make a state: ``theta`` and its steps."""
        steps, all_ = self.steps(theta), [theta]
        for i, name in enumerate(self.unknowns.names):
            if name not in LINE:
                moved = theta.copy()
                moved[i] += steps[i]
                all_.append(moved)
        return all_

    def __call__(self, theta: Array) -> State:
        (state,) = self.many([(self, theta)])
        return state

    @staticmethod
    def many(asked: Sequence[tuple[Adhering, Array]]) -> list[State]:
        """The states of several searches of one cycle by one march."""
        one = asked[0][0]
        sets = [model.asked(theta) for model, theta in asked]
        marches = iter(one.marched([theta for some in sets for theta in some]))
        return [model.state(some[0], list(itertools.islice(marches, len(some))))
                for (model, _), some in zip(asked, sets, strict=True)]  # fmt: skip

    def search(self, start: Array, evaluations: int) -> LeastSquares:
        """What is minimised from ``start`` on."""
        low, high = self.unknowns.bounds(start, FARTHEST)
        return LeastSquares(self, (low, high), 1e-6, CONVERGED / self.cycle.t.size, evaluations)


def _likely(name: str, lasting: float) -> tuple[float, float] | None:
    """What is likely of an unknown of a law before, mean and half-width of a normal distribution: of times of their
    logs; None of others. ``lasting``: time in contact [s]."""
    plain = name.rstrip("0123456789")
    if plain in LIKELY_TIMES:
        share, width = LIKELY_TIMES[plain]
        return math.log(share * lasting), width
    return LIKELY.get(plain)


def _few(law: Relaxation, lasting: float) -> Modes:
    """The law with r(0) = 1, up to the time ``lasting`` [s]; a power law by few exponentials."""
    if not isinstance(law, PowerRelaxation):
        return law.modes(lasting)
    modes = law.modes(lasting, POWER_STEP)
    slow, kept = modes.rates * lasting < POWER_SLOWEST, modes.weights > POWER_LEAST * modes.weights.sum()
    weight = modes.weights[slow].sum()
    weights = np.append(weight, modes.weights[kept & ~slow])
    rates = np.append(modes.weights[slow] @ modes.rates[slow] / weight, modes.rates[kept & ~slow])
    return Modes(0.0, weights / weights.sum(), rates)


def adhering_fit(body: FittedBody, curve: Curve, settings: RelaxationSettings) -> RelaxationFit:
    """The fit of a force curve with its retraction and free rows, w among the unknowns."""
    if body.no_range:
        raise InputError(body.no_range.replace("adhesion of finite range", "adhesion on a viscoelastic specimen"))
    cycle = Cycle.of(curve)
    if _load_is_prescribed(cycle):
        raise InputError(
            f"{curve.where}: w: adhesive cycles are fitted under a prescribed displacement, here the load is "
            "prescribed: leave w out"
        )
    if (
        cycle.pulled < ROWS_APART * cycle.noise / math.sqrt(2 * MEAN + 1)
        or float(-cycle.load.min()) < ROWS_APART * cycle.noise
    ):
        raise InputError(f"{curve.where}: w: no adhesion shows, no load lies below that before contact; leave w out")
    if not settings.ranged:
        settings = replace(settings, adhesion=(*settings.adhesion, "stress"))
    free = cycle.free.sum() >= BASE_FEWEST
    zeros = [
        name for name in ("delta0", "P0", "tilt") if name not in settings.fixed and (name in settings.zeros or free)
    ]
    if "tilt" in zeros and "tilt" not in settings.zeros and np.ptp(cycle.z[cycle.free]) < 0.05 * np.ptp(cycle.z):
        zeros.remove("tilt")
    settings = replace(settings, zeros=tuple(zeros))
    depth = float(cycle.tip.max() - cycle.tip[cycle.contact[0]])
    body = body.to_depth(DEEPER * depth)
    attracted = AttractedBody(body.problem)
    z, P = float(np.ptp(cycle.z)), float(np.ptp(cycle.P))
    units = {"delta0": max(depth, 1e-3 * z), "P0": P, "tilt": P / z}
    # the search of a series begins with a standard solid
    known = {name: value for name, value in settings.fixed.items() if name not in settings.of_law}
    first = settings if settings.law != "prony" else replace(settings, law="sls", fixed=known)
    unknowns = Unknowns(first.parameters, units)

    rough = np.maximum(ROUGH * (cycle.pulled + np.abs(cycle.load)), cycle.noise)
    seen = np.array(cycle.jumps)
    jumps = np.where(
        np.isfinite(seen)[:, None], np.stack([seen, np.full(2, ROUGH_TIME * cycle.lasting)], axis=1), [0.0, math.inf]
    )
    near = np.any(np.abs(cycle.t[:, None] - seen) < NEAR * cycle.spacing, axis=1)
    sigma = np.where(cycle.free, 3 * cycle.noise, rough)
    model = Adhering(body, attracted, cycle, first, unknowns, *SEARCH[:2], sigma, jumps, near)
    theta = _best(model, _starts(model), SEARCH[2])
    rough_least = model.search(theta, SEARCH[2]).least(theta)
    if settings.law == "prony":
        values = unknowns.values(rough_least.x)
        model = replace(model, settings=settings, unknowns=Unknowns(settings.parameters, units))
        (law,) = _laws_of(settings, values["ratio"], values["time"], cycle.lasting)
        theta = model.unknowns.at({**values, **law, **settings.fixed})
        rough_least = model.search(theta, 1).least(theta)
    if settings.most is not None:
        off = (model.loads(rough_least.x, model.marched([rough_least.x])[0]) - cycle.P)[~near] / cycle.noise
        if float(np.mean(off**2)) > settings.most:
            raise SolveError("no history of this specimen leaves as little")
    roughly = settings.most is not None
    begun = [rough_least.x, *Posterior.of(model, rough_least, 1.0).modes()]

    # All rows by their noise, the jumps where the rows show them.
    error = math.hypot(cycle.spacing / math.sqrt(12), JUMP_TIME * cycle.lasting)
    fine = replace(
        model, width=FINE[0], tolerance=FINE[1], sigma=np.full(cycle.t.size, cycle.noise),
        jumps=np.where(np.isfinite(jumps), [1.0, error / (ROUGH_TIME * cycle.lasting)], 1.0) * jumps,
        left_out=np.any(np.abs(cycle.t[:, None] - seen) < APART * cycle.spacing, axis=1),
    )  # fmt: skip
    x = _best(fine, begun, STRAIGHT)
    wide = fine.search(x, FINE[2]).least(x) if roughly else _along_valley(fine, x)
    # Narrower zones, extrapolated, and the least with what they change.
    (here,), (there,) = fine.marched([wide.x]), replace(fine, width=FINEST * FINE[0]).marched([wide.x])
    fine = fine.corrected(wide.x, here, there)
    least = fine.search(wide.x, FINE[2]).least(wide.x)
    fit = _result(fine, least, least.x - wide.x)
    return replace(fit, warnings=(*fit.warnings, GIVEN_UP)) if here.given_up or there.given_up else fit


def _load_is_prescribed(cycle: Cycle) -> bool:
    """Whether the load moved in fewer straight pieces than the device, or alone in any."""
    pieces = cycle.program[0].size if cycle.straight else MOTION_MOST
    return _corners(cycle.t, cycle.P)[0].size < pieces


def _starts(model: Adhering) -> list[Array]:
    """The best of some values, with each of some ratios and times: the pull-off force tells w in a very fast cycle,
    where it is elastic, from rest, where it is the ratio times that of the relaxed modulus, and between; the load at
    the reversal tells the modulus."""
    cycle, body, settings = model.cycle, model.body, model.settings
    limits, fixed = ElasticLimits(body.nonadhesive), settings.fixed
    first, end = cycle.contact
    shows, top = float(cycle.tip[first]), first + int(np.argmax(cycle.z[first:end]))  # at the reversal
    depth, load = float(cycle.tip[top]), float(cycle.load[top])
    radius = float(np.interp(depth - shows, body.series.delta, body.series.a))
    starts = []
    for ratio, time, share, zone in itertools.product(
        RATIOS, TIMES, SHARES, (1.0,) if fixed.keys() & {"stress", "range"} else ZONES
    ):

        def work(modulus: float, ratio: float = ratio, share: float = share) -> float:
            fast, rest = (limits.work(modulus, cycle.pulled), ratio * limits.work(ratio * modulus, cycle.pulled))
            return float(fast ** (1 - share) * rest**share)

        zero = shows
        for _ in range(ROUNDS):
            modulus = fixed.get("modulus", limits.modulus(depth - zero, load, work))
            w = fixed.get("w", work(modulus))
            of_zone = math.sqrt(zone * radius * w / (ZONE_SLOPE * modulus * body.problem.E_star))
            length = fixed.get("range", w / fixed["stress"] if "stress" in fixed else of_zone or LIKELY_RANGE)
            zero = shows + min(length, depth - shows)
        values = {"w": w, "stress": w / length, "range": length, "delta0": zero}
        values |= {"P0": cycle.base[0], "tilt": cycle.base[1]}
        for law in _laws_of(settings, ratio, time * cycle.lasting, cycle.lasting):
            own = {"modulus": modulus * law.get("modulus", 1.0)}
            starts.append(model.unknowns.at({**values, **law, **own, **fixed}))
    low, high = zip(*(model.unknowns.bounds(theta, FARTHEST) for theta in starts), strict=True)
    starts = [np.clip(theta, a, b) for theta, a, b in zip(starts, low, high, strict=True)]
    costs = []
    for theta, march in zip(starts, model.marched(starts), strict=True):
        off = (model.loads(theta, march) - cycle.P) / model.sigma
        lost = march.lost if math.isfinite(march.lost) else cycle.t[-1] + cycle.lasting / 4
        missed = 0.0 if math.isinf(model.jumps[1, 1]) else (lost - model.jumps[1, 0]) / cycle.lasting
        costs.append(float(np.sum(np.log1p(off**2))) * (1 + abs(missed)))
    return [starts[i] for i in np.argsort(costs)[:BEGINS]]


def _best(model: Adhering, begun: Sequence[Array], evaluations: int) -> Array:
    """The unknowns of the least of searches from several places, side by side."""
    ends = together([model.search(theta, evaluations).searching(theta) for theta in begun])
    found = [one for one in ends if not isinstance(one, Exception)]
    if not found:
        raise SolveError("no history of this specimen resembles the data")
    theta: Array = min(found, key=lambda one: one.cost).x
    return theta


def _laws_of(settings: RelaxationSettings, ratio: float, time: float, lasting: float) -> Iterator[dict[str, float]]:
    """Parameters of laws near a standard solid of ``ratio`` and ``time`` [s] in a contact ``lasting`` so long [s]; the
    "modulus" of a power law is over that at t = 0."""
    if settings.law == "sls":
        yield {"ratio": ratio, "time": time}
    elif settings.law == "power":
        left = ratio + (1 - ratio) * math.exp(-lasting / time)
        for onset in (share * lasting for share in ONSETS):
            exponent = min(max(-math.log(left) / math.log1p(lasting / onset), 0.01), 0.9)
            yield {"onset": onset, "exponent": exponent, "modulus": (settings.fixed["time"] / onset) ** -exponent}
    else:
        n = settings.terms
        weights = {f"weight{i + 1}": max((1 - ratio) / n, 0.01) for i in range(n)}
        yield weights | {f"time{i + 1}": time * APART_TIMES ** (i - (n - 1) / 2) for i in range(n)}


def _along_valley(model: Adhering, x: Array) -> Least:
    """The least near ``x`` of all rows. Laws that differ hardly in r(t) within the record lie along bent valleys: the
    least of loads that are linear in r(t), whatever its parameters, leads on where steps of Gauss and Newton creep."""
    least = model.search(x, STRAIGHT).least(x)
    for _ in range(VALLEYS):
        x = Posterior.of(model, least, 1.0).likeliest()
        there = model.search(x, STRAIGHT).least(x)
        gained = least.cost - there.cost
        least = there if gained > 0 else least
        if gained < CONVERGED:
            break
    return least


def _scatter(model: Adhering, least: Least) -> float:
    """Standard deviation of the residuals of the rows over the noise they are weighed by."""
    rows = least.state.residuals[: model.cycle.t.size]
    return math.sqrt(float(rows @ rows) / max(int(np.count_nonzero(rows)) - least.x.size, 1))


def _result(model: Adhering, least: Least, shift: Array) -> RelaxationFit:
    """The answer of the ``least``; ``shift``: of the unknowns, by the widths of zones that are extrapolated."""
    settings, unknowns, cycle = model.settings, model.unknowns, model.cycle
    J, off, n, scatter = least.state.jacobian, least.state.residuals, cycle.t.size, _scatter(model, least)
    rows = np.any(J[:n] != 0, axis=1)
    variance = max(1.0, scatter**2)
    own = covariance(J, variance)
    own = own if own is None else own + MARCH_ERROR**2 * np.outer(shift, shift)
    middle, samples = Posterior.of(model, least, variance).samples(shift)
    least = replace(least, x=middle)
    intervals = Intervals.of(unknowns, least, settings.level, "covariance", model.body.problem.E_star, variance)
    intervals = replace(intervals, covariance=own, samples=samples)
    fit = RelaxationFit(
        estimates=intervals.estimates(), free=unknowns.names, dof=least.dof, covariance=unknowns.covariance(own),
        relaxation=settings.relaxation(unknowns.values(least.x)), record=cycle.record(), imposed=cycle.z,
        response=np.where(rows, cycle.P + off[:n] * model.sigma, np.nan), settings=settings,
        scatter=scatter, samples=samples * unknowns.scales,
    )  # fmt: skip
    warnings = [*fit.record.flags, *([BESIDE] if settings.law == "power" else [])]
    warnings += [] if least.ended else [f"{UNSETTLED}: values and intervals are preliminary"]
    if fit.scatter > SEARCH_MISFIT:
        warnings.append(f"residuals are {fit.scatter:.2g} times the scatter from row to row: {MISFIT}")
    return replace(fit, warnings=tuple(warnings))


# --------------------------------------------------------------------------------------------------
# What the record leaves of the law. Where little relaxes within it, ratio and time are known together only, on no
# ellipse. The loads, though, are nearly linear in r(t) itself: r = r_0 + sum of omega_k (exp(-q_k t) - 1).

SPECTRUM = np.geomspace(0.3, 3000.0, 11)  # choice: rates q_k over the time in contact
SPECTRUM_STEP = 0.01  # choice: of r, for differences
SPECTRUM_TIMES = np.geomspace(1e-4, 1.0, 50)  # choice: over the time in contact, at which r is told by these
# choice: quantiles are then good to a tenth of a standard error
WALKERS, WALKED, BURNT, KEPT, TRIALS = 48, 450, 200, 600, 96
# choice: steps to valleys, and near them, where samples begin; ends of shares there; times over that in contact
SETTLING, SETTLING_NEAR, SHARE_ENDS, TIMES_TRIED = 15, 5, 1e-3, (0.01, 100.0)
MODES = (0.03, 0.3, 3.0)  # choice: times over that in contact, of laws among which a search begins
STRETCH = 2.0  # theory: of Goodman and Weare's moves (Comm. App. Math. Comp. Sci. 5 (2010) 65)
SEED = 1  # choice: the same samples every day


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is likely of the law's parameters ``best`` (of the unknowns ``own``), and of the others given these: minus
    twice its log is |``right`` + ``matrix`` omega|^2, and the others are ``mean`` + ``by`` omega with the Cholesky root
    ``spread`` of their covariance."""

    model: Adhering
    x: Array
    own: Array
    right: Array
    matrix: Array
    mean: Array
    by: Array
    spread: Array

    @classmethod
    def of(cls, model: Adhering, least: Least, variance: float) -> Posterior:
        names, x, settings = model.unknowns.names, least.x, model.settings
        own = np.array([_likely(name, model.cycle.lasting) is not None for name in names])
        trial, rates = model.trial(x), SPECTRUM / model.cycle.lasting
        sign = 1.0 if trial.modes.relaxed > 2 * SPECTRUM_STEP else -1.0
        trials = [trial]
        for q in rates.tolist():
            modes = trial.modes
            added = modes._replace(relaxed=modes.relaxed - sign * SPECTRUM_STEP,
                                   weights=np.append(modes.weights, sign * SPECTRUM_STEP),
                                   rates=np.append(modes.rates, q))  # fmt: skip
            trials.append(replace(trial, modes=added))
        marches = model.march(trials)
        J_r = np.stack([model.change(x, marches[0], x, one) for one in marches[1:]], axis=1) / (sign * SPECTRUM_STEP)
        J, off, n_law = least.state.jacobian, least.state.residuals, int(own.sum())
        law = slice(J_r.shape[0], J_r.shape[0] + n_law)  # what is likely of the law is told apart
        keep = np.delete(np.arange(off.size), np.arange(law.start, law.stop))
        spread_r = np.zeros((off.size, rates.size))
        spread_r[: J_r.shape[0]] = J_r
        scale = 1 / math.sqrt(variance)
        J, off, J_r = J[keep][:, ~own] * scale, off[keep] * scale, spread_r[keep] * scale
        # what marches err by, another in each half of each piece of the program, are unknowns too
        errs = model.march_errors(marches[0], x) * scale
        m, p = errs.shape[1], J.shape[1]
        wide = np.zeros((J.shape[0], m))
        wide[: errs.shape[0]] = errs
        J = np.block([[J, wide], [np.zeros((m, p)), np.eye(m)]])
        off, J_r = np.append(off, np.zeros(m)), np.vstack([J_r, np.zeros((m, J_r.shape[1]))])
        Q, R = np.linalg.qr(J)
        others = np.linalg.pinv(R)
        left, J_left = off - Q @ (Q.T @ off), J_r - Q @ (Q.T @ J_r)
        Q_r, matrix = np.linalg.qr(J_left)
        others = others[:p]
        spread = others @ others.T
        root = np.linalg.cholesky(spread + 1e-12 * np.diag(np.diag(spread)))
        assert settings.law in RELAXED
        return cls(model, x, own, Q_r.T @ left, matrix, -others @ (Q.T @ off), -others @ (Q.T @ J_r), root)

    def off(self, law: Array) -> tuple[Array, Array]:
        """What is left of all rows and of what is likely before, by parameters ``law`` (n, parameters), as residuals
        (n, rows), and omega of these."""
        lasting = self.model.cycle.lasting
        t = SPECTRUM_TIMES * lasting
        here, there = (self.r(one, t) / self.r(one, np.zeros(1)) for one in (self.x[self.own][None], law))
        omega = (there - here) @ np.linalg.pinv(np.expm1(-np.multiply.outer(t, SPECTRUM / lasting)), rcond=1e-4).T
        means, widths = np.array([_likely(name, lasting) for name in self.names]).T
        return np.concatenate([self.right + omega @ self.matrix.T, (law - means) / widths], axis=1), omega

    def log(self, law: Array) -> Array:
        """Logs of what parameters ``law`` (n, parameters) are likely."""
        shares = law[:, [not _is_time(name) for name in self.names]]
        weights = law[:, [name.startswith("weight") for name in self.names]]
        possible = ((shares > 0) & (shares < 1)).all(axis=1) & (weights.sum(axis=1) < 1)
        return np.where(possible, -np.sum(self.off(law)[0] ** 2, axis=1) / 2, -np.inf)

    @property
    def names(self) -> list[str]:
        """Of the unknowns of the law."""
        return [name for name, own in zip(self.model.unknowns.names, self.own, strict=True) if own]

    def r(self, law: Array, t: Array) -> Array:
        """r at the times ``t`` [s] (n, times)."""
        settings = self.model.settings
        every: dict[str, Array] = {name: np.asarray(value) for name, value in settings.fixed.items()}
        every |= {name: np.exp(one) if _is_time(name) else one for name, one in zip(self.names, law.T, strict=True)}
        return RELAXED[settings.law](every, t)

    def samples(self, march: Array) -> tuple[Array, Array]:
        """A point in the middle of what is likely, and samples of all unknowns (n, unknowns); ``march``: what narrower
        zones moved them, of which a part may be left over."""
        rng = np.random.default_rng(SEED)
        law = np.tile(self.x[self.own], (KEPT, 1))
        if law.size:
            law = rng.choice(self._walked(rng), KEPT, replace=False)
        found = self._whole(law)
        found[:, ~self.own] += rng.standard_normal((KEPT, int((~self.own).sum()))) @ self.spread.T
        found += MARCH_ERROR * rng.standard_normal((KEPT, 1)) * march
        shares = [i for i, name in enumerate(self.model.unknowns.names) if self.own[i] and not _is_time(name)]
        found[:, shares] = np.clip(found[:, shares], SAME, 1 - SAME)
        return self._central(law), found

    def _whole(self, law: Array) -> Array:
        """All unknowns (n, unknowns) with those of the ``law`` and the most likely of the others."""
        found = np.tile(self.x, (len(law), 1))
        found[:, self.own] = law
        found[:, ~self.own] += self.mean + self.off(law)[1] @ self.by.T
        zero = np.zeros(1)
        if "modulus" in self.model.unknowns.names:  # that at t = 0 is what the loads tell
            i = self.model.unknowns.names.index("modulus")
            found[:, i] -= np.log(self.r(law, zero) / self.r(self.x[self.own][None], zero))[:, 0]
        return found

    def _central(self, law: Array) -> Array:
        """Of the samples of a ``law`` that whose r(t) is nearest to the medians, with the most likely others."""
        r = np.log(np.maximum(self.r(law, SPECTRUM_TIMES * self.model.cycle.lasting), TINY))
        off = (r - np.median(r, axis=0)) / np.maximum(np.std(r, axis=0), TINY)
        nearest = int(np.argmin(np.sum(off**2, axis=1)))
        whole: Array = self._whole(law[nearest : nearest + 1])[0]
        return whole

    def likeliest(self) -> Array:
        """The unknowns with the likeliest law."""
        law = self._settled(self._about(np.random.default_rng(SEED)))
        whole: Array = self._whole(law[:1])[0]
        return whole

    def modes(self) -> list[Array]:
        """The unknowns with laws of short, middle and long times."""
        lasting, found = self.model.cycle.lasting, list[Array]()
        for share in MODES:
            law, middle = np.full(len(self.names), 0.3), (len(self.names) - 1) / 2
            for i, name in enumerate(self.names):
                if _is_time(name):
                    law[i] = math.log(share * lasting) + (i - middle) / 2 * math.log(APART_TIMES)
            if law.size:
                found.append(self._whole(self._settled(law[None]))[0])
        return found

    def _about(self, rng: np.random.Generator) -> Array:
        """Parameters of the law: its own, first, others near to it, and as many anywhere."""
        here, lasting = np.tile(self.x[self.own], (TRIALS, 1)), self.model.cycle.lasting
        for i, name in enumerate(self.names):
            width = 10 ** rng.uniform(-3, 0.3, TRIALS - 1) * (2.0 if _is_time(name) else 0.3)
            here[1:, i] += rng.normal(0, 1, TRIALS - 1) * width
            low, high = np.log(TIMES_TRIED).tolist()
            anywhere = math.log(lasting) + rng.uniform(low, high, TRIALS)
            far = anywhere if _is_time(name) else rng.random(TRIALS)
            here[TRIALS // 2 :, i] = far[TRIALS // 2 :]
            if not _is_time(name):
                here[:, i] = np.clip(here[:, i], SHARE_ENDS, 1 - SHARE_ENDS)
        return here

    def _settled(self, law: Array, steps_of: int = SETTLING) -> Array:
        """Each of many parameters ``law`` by steps of Levenberg and Marquardt in the valley next to it, the likeliest
        first."""
        d, log, damping = law.shape[1], self.log(law), np.full(len(law), 1e-2)
        steps = np.array([0.01 if _is_time(name) else 1e-3 for name in self.names])
        shares = np.array([not _is_time(name) for name in self.names], dtype=bool)
        for _ in range(steps_of if d else 0):
            off = self.off(law)[0]
            J = np.stack([(self.off(law + step)[0] - off) / step.sum() for step in np.diag(steps)], axis=2)
            A = np.einsum("nri,nrj->nij", J, J)
            A += damping[:, None, None] * (A * np.eye(d)) + TINY * np.eye(d)
            moved = -np.linalg.solve(A, np.einsum("nri,nr->ni", J, off)[..., None])[..., 0]
            there = law + np.clip(moved, -50 * steps, 50 * steps)
            there = np.where(shares, np.clip(there, SHARE_ENDS, 1 - SHARE_ENDS), there)
            better = self.log(there) > log
            law = np.where(better[:, None], there, law)
            log, damping = self.log(law), damping * np.where(better, 0.3, 10.0)
        return law[np.argsort(-log)]

    def _walked(self, rng: np.random.Generator) -> Array:
        """Samples of the law's parameters, (n, parameters), by walks over the logs of the slopes weight/time, by which
        laws of times beyond the record are alike, and of the times."""
        exponentials = self.model.settings.law != "power" and [*map(_is_time, self.names)] == [False, True] * (
            len(self.names) // 2
        )
        turned = -1.0 if self.names[0] == "ratio" else 1.0  # the weight is 1 - ratio

        def slopes(law: Array) -> Array:
            here = law.copy()
            here[:, ::2] = np.log(law[:, ::2] if turned > 0 else 1 - law[:, ::2]) - law[:, 1::2]
            return here if exponentials else law

        def laws(here: Array) -> Array:
            law = here.copy()
            weights = np.exp(np.minimum(here[:, ::2] + here[:, 1::2], 1.0))
            law[:, ::2] = weights if turned > 0 else 1 - weights
            return law if exponentials else here

        def logs(here: Array) -> Array:
            return self.log(laws(here)) + (np.sum(here, axis=1) if exponentials else 0.0)

        near = self._settled(self._about(rng), SETTLING_NEAR)
        here = slopes(near[:WALKERS])
        log, kept = logs(here), []
        halves, d = np.arange(WALKERS) < WALKERS // 2, here.shape[1]
        for step in range(WALKED):
            for some in (halves, ~halves):
                stretch = (1 + (STRETCH - 1) * rng.random(WALKERS // 2)) ** 2 / STRETCH
                other = rng.choice(here[~some], WALKERS // 2)
                tried = other + stretch[:, None] * (here[some] - other)
                there = logs(tried)
                takes = np.log(rng.random(WALKERS // 2)) < (d - 1) * np.log(stretch) + there - log[some]
                here[some] = np.where(takes[:, None], tried, here[some])
                log[some] = np.where(takes, there, log[some])
            if step >= BURNT:
                kept.append(laws(here))
        return self._in_order(np.concatenate(kept))

    def _in_order(self, law: Array) -> Array:
        """The terms of Prony's series by their times, where none of them is fixed."""
        terms = self.model.settings.terms
        if self.model.settings.law != "prony" or len(self.names) < 2 * terms:
            return law
        pairs = law.reshape(-1, terms, 2)
        order = np.argsort(pairs[..., 1], axis=1)
        return np.take_along_axis(pairs, order[..., None], axis=1).reshape(law.shape)


def _is_time(name: str) -> bool:
    return name.rstrip("0123456789") in LIKELY_TIMES

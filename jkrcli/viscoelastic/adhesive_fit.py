"""The modulus, a law of relaxation, w and its cohesive stress from one whole force curve, with its free rows.

Every row counts, by P_read = P0 + tilt (z - z_0) + P(t; body, w, stress, law) + noise: where the fitted contact is
not, P = 0, so that free rows say what offset, tilt and noise are and nothing else. The loads are marches of all trial
parameters at once (``lockstep_march.py``), P(E, w, sigma) = E p(w/E, sigma/E). Which side of a jump a row lies on is
not known within some rows of it: they are left out, and the time of the jump is a reading of its own.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
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
ONSET, APART_TIMES = 0.01, 4.0  # choice: of power laws; from time to time of a series
ZONES = (0.25, 0.02, 0.0)  # choice: zones over the contact radius, where no range is known; 0: the likely range
LINE, ZONE = ("P0", "tilt"), ("stress", "range")
APART = 1.5  # theory: rows from a jump, within which no row shows when it was
# choice: of the time in contact, within which loads fall to a jump as no derivative foretells, and no march
STEEP = (0.015, 0.004)
JUMP_SEEN = 7.0  # theory: of the noise, a step between two rows that it does not make
NEAR = 10  # choice: rows, within which a jump lies that is seen
MEAN = 3  # choice: rows to either side, of whose loads means are taken
MODULI, TRIED = 1e6, 50  # choice: in those of the body, the moduli among which a search begins
FARTHEST, REACH = 4.0, 1.5  # choice: of logs, from what is likely of a record, and from where a search begins
ROUNDS = 3  # choice: modulus and zero in turn, good to a tenth
BEGINS = 3  # choice: searches
# choice: zones over contact radii at least, tolerances of steps, evaluations at most, of a search and of the fit
SEARCH, FINE = (0.03, 2e-2, 4), (0.012, 8e-3, 12)
FINEST = 0.25, 0.5  # choice: of these zones, those that are extrapolated with them by squares of widths, or else
ALIKE = 0.05  # choice: of the time in contact, by which its end may differ in them
LIKE = 1.1  # choice: of a neighbour's scatter, what a fit may leave that begins there
ROUGH = 0.02  # choice: of the pull-off force, what a search may miss
ROUGH_TIME, JUMP_TIME = 0.003, 4e-4  # choice: of the time in contact, errors of jumps in a search and of the march
ROUGH_STEPS = 400  # choice: of a march, twice those of usual records, where it is to be excluded that the law fits
HELD = 0.05  # choice: of steps of others, those of a stress that is held
WITHIN = (0.01, 0.3, 1.0)  # choice: steps of logs at least, at first, and at most
CONVERGED = 0.5  # theory: of the sum of squares of rows by their noise: less than a standard error
SCATTERS = 1e-3, 8e-3  # choice: of that sum, what a step may still gain, or lose by what marches err
POWER_STEP = 1.1  # theory: of log rates of a power law's exponentials, which then err by 1e-4
POWER_SLOWEST, POWER_LEAST = 0.02, 1e-6  # theory: rates times time that one stands for; weights that do not count
STEP = 0.01  # choice: of logs of the modulus and w, for differences; of others what changes loads alike
STEPS = {"time": 0.05, "onset": 0.3, "stress": 0.1, "delta0": 0.003, "ratio": 0.01, "weight": 0.01, "exponent": 0.01}
MARCH_ERROR = 0.5  # choice: of what narrower zones change, what they may still err by
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
    def touch(self) -> float:
        """Where the tip is as contact begins, before it jumps [m]."""
        first = self.contact[0]
        return float(self.z[first - 1] if first else self.tip[0])

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

    def near(self, rows: float) -> Array:
        """Mask of those within so many of a jump that is seen."""
        return np.any(np.abs(self.t[:, None] - np.array(self.jumps)) < rows * self.spacing, axis=1)

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
    to the loads [N]; ``steep``: of the time in contact, how near to jumps rows do not count."""

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
    steep: float = STEEP[0]

    def trial(self, theta: Array) -> Trial:
        """The specimen of the unknowns ``theta``."""
        values = self.unknowns.values(theta)
        m, w = self.instant(theta), values["w"]
        stress = values["stress"] if "stress" in values else w / values["range"]
        modes = _few(self.settings.relaxation(values), float(np.ptp(self.cycle.t)))
        return Trial(w / m, stress / m, self.cycle.stiffness / m, modes, values["delta0"])

    def march(self, trials: Sequence[Trial], leaders: Sequence[int] | None = None) -> list[Marched]:
        """Marches of many trials, each with the steps of that of its ``leaders``."""
        steps = None if self.settings.most is None else ROUGH_STEPS
        how = self.cycle.program, self.width, self.tolerance, steps, leaders
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

    def corrected(self, theta: Array, here: Marched) -> Adhering:
        """The same with what zones of no width change from the march ``here`` with ``theta``, by a narrow one that can
        be followed, in loads and in the end of contact."""
        t = self.cycle.t
        for share in FINEST:
            (narrow,) = replace(self, width=share * self.width).march([self.trial(theta)])
            later = narrow.lost - here.lost if math.isfinite(here.lost) else 0.0
            if not narrow.given_up and abs(later) < ALIKE * self.cycle.lasting:
                break
        else:
            return self
        change = self.instant(theta) * (narrow.load(t) - here.load(t)) / (1 - share**2)
        change = np.where(self.apart(here, (narrow.begun, narrow.lost)), 0.0, change)
        jumps = self.jumps.copy()
        jumps[1, 0] -= later / (1 - share**2) if math.isfinite(jumps[1, 1]) else 0.0
        return replace(self, correction=change, jumps=jumps)

    def apart(self, one: Marched, other: tuple[float, float]) -> Array:
        """Mask of rows between jumps of a march and ``other`` ones."""
        t, mask = self.cycle.t, np.zeros(self.cycle.t.size, dtype=bool)
        for mine, theirs in zip((one.begun, one.lost), other, strict=True):
            low, high = min(mine, theirs), max(mine, theirs)
            if math.isfinite(low):
                mask |= (t >= low) & (t <= high)
        return mask

    def state(self, theta: Array, here: Marched, columns: Mapping[str, Array]) -> State:
        """Residuals from the march at ``theta``, with their derivatives by what moves the contact."""
        out, seen = self.out(here), np.isfinite(self.jumps[:, 1])
        off = np.where(out, 0.0, (self.loads(theta, here) - self.cycle.P) / self.sigma)
        off = np.append(off, ((self.times(here) - self.jumps[:, 0]) / self.jumps[:, 1])[seen])
        line = {"P0": np.ones_like(self.cycle.z), "tilt": self.cycle.z - self.cycle.z[0]}
        J = np.zeros((off.size, theta.size))
        for i, name in enumerate(self.unknowns.names):
            if name in LINE:
                J[: out.size, i] = np.where(out, 0.0, line[name] * self.unknowns.scales[i] / self.sigma)
            else:
                J[:, i] = columns[name]
        prior, J_prior = self.prior(theta)
        return State(np.append(off, prior), lambda: np.concatenate([J, J_prior]))

    def times(self, one: Marched) -> Array:
        """When contact began and was lost [s], not beyond the record."""
        cycle, late = self.cycle, self.cycle.t[-1] + self.cycle.lasting / 4
        return np.minimum([one.begun, one.lost], [late, self.jumps[1, 0] if cycle.held else late])

    def out(self, one: Marched) -> Array:
        """Mask of rows that do not count: beside jumps, or between those of the record and of the march ``one``."""
        mine, t = np.array([one.begun, one.lost]), self.cycle.t
        theirs = np.where(np.isfinite(self.jumps[:, 1]), self.jumps[:, 0], mine)
        width = max(APART * self.cycle.spacing, self.steep * self.cycle.lasting)
        beside = np.any(np.abs(t[:, None] - mine) < width, axis=1)
        return self.left_out | self.apart(one, (float(theirs[0]), float(theirs[1]))) | beside

    def change(self, here: Marched, loads: Array, moved: Array, there: Marched) -> Array:
        """How residuals, of loads and jumps, change from the march ``here`` with its ``loads`` to ``there`` at
        ``moved``."""
        seen = np.isfinite(self.jumps[:, 1])
        out = self.out(here) | self.apart(here, (there.begun, there.lost))
        change = np.where(out, 0.0, (self.loads(moved, there) - loads) / self.sigma)
        return np.append(change, ((self.times(there) - self.times(here)) / self.jumps[:, 1])[seen])

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

    def moved(self, theta: Array, names: Sequence[str]) -> list[Array]:
        """``theta`` with a step of each of some unknowns."""
        steps = np.diag(self.steps(theta))
        return [theta + steps[self.unknowns.names.index(name)] for name in names]

    def rates(self, theta: Array, here: Marched, names: Sequence[str], there: Iterable[Marched]) -> dict[str, Array]:
        """Derivatives by unknowns from the marches of their steps."""
        steps = dict(zip(self.unknowns.names, self.steps(theta), strict=True))
        loads = self.loads(theta, here)
        return {name: self.change(here, loads, moved, one) / steps[name]
                for name, moved, one in zip(names, self.moved(theta, names), there, strict=True)}  # fmt: skip

    @staticmethod
    def many(asked: Sequence[tuple[Adhering, Array]]) -> list[State]:
        """The states of several searches of one cycle by one march."""
        model = asked[0][0]
        names = [name for name in model.unknowns.names if name not in LINE]
        sets = [[theta, *model.moved(theta, names)] for _, theta in asked]
        leaders = np.repeat(np.arange(len(sets)) * (len(names) + 1), len(names) + 1)
        marches = iter(model.march([model.trial(theta) for some in sets for theta in some], leaders.tolist()))
        found = []
        for theta, *_ in sets:
            here, *there = itertools.islice(marches, len(names) + 1)
            found.append(model.state(theta, here, model.rates(theta, here, names, there)))
        return found

    def __call__(self, theta: Array) -> State:
        (state,) = self.many([(self, theta)])
        return state

    def search(self, start: Array, evaluations: int) -> LeastSquares:
        """What is minimised from ``start`` on, whose stress or range is held."""
        low, high = self.unknowns.bounds(start, REACH)
        held = np.isin(self.unknowns.names, ZONE)
        bounds = np.where(held, start, low), np.where(held, start, high)
        return LeastSquares(self, bounds, 1e-6, CONVERGED / self.cycle.t.size, evaluations)


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


def adhering_fit(
    body: FittedBody, curve: Curve, settings: RelaxationSettings, like: RelaxationFit | None = None
) -> RelaxationFit:
    """The fit of a force curve with its retraction and free rows, w among the unknowns; ``like``: the fit of one that
    may be alike, as that of a neighbour, where it begins."""
    if body.no_range:
        raise InputError(body.no_range.replace("adhesion of finite range", "adhesion on a viscoelastic specimen"))
    cycle = Cycle.of(curve)
    _check(cycle)
    settings = _with_base_line(cycle, settings)
    depth = float(cycle.tip.max()) - cycle.touch
    body = body.to_depth(DEEPER * depth)
    z, P = float(np.ptp(cycle.z)), float(np.ptp(cycle.P))
    units = {"delta0": max(depth, 1e-3 * z), "P0": P, "tilt": P / z}

    # All rows by their noise, the jumps where the rows show them.
    seen, error = np.array(cycle.jumps), math.hypot(cycle.spacing / math.sqrt(12), JUMP_TIME * cycle.lasting)
    jumps = np.where(np.isfinite(seen)[:, None], np.stack([seen, np.full(2, error)], axis=1), [0.0, math.inf])
    fine = Adhering(body, AttractedBody(body.problem), cycle, settings, Unknowns(settings.parameters, units), *FINE[:2],
                    np.full(cycle.t.size, cycle.noise), jumps, cycle.near(APART))  # fmt: skip
    wide = None if like is None else _beside(fine, like)
    if wide is None:
        near = Nearby.of(*_begun(fine))
        wide = _least(near if settings.law == "sls" else near.by_law(settings), FINE[2])
    off = wide.state.residuals[: cycle.t.size]
    if settings.most is not None and float(np.mean(off[off != 0] ** 2)) > settings.most:
        raise SolveError("no history of this specimen leaves as little")
    # Narrower zones, extrapolated, and the least with what they change.
    fine = wide.model
    narrower = fine.corrected(wide.x, wide.here)
    corrected = replace(wide, model=narrower)
    shift = np.linalg.pinv(corrected.state.jacobian) @ (wide.state.residuals - corrected.state.residuals)
    fit = _result(_least(corrected, FINE[2]), shift)
    return replace(fit, warnings=(*fit.warnings, GIVEN_UP)) if wide.here.given_up or narrower is fine else fit


def _check(cycle: Cycle) -> None:
    """InputError where no adhesion shows, or a load is prescribed."""
    if _load_is_prescribed(cycle):
        raise InputError(
            f"{cycle.curve.where}: w: adhesive cycles are fitted under a prescribed displacement, here the load is "
            "prescribed: leave w out"
        )
    if (
        cycle.pulled < ROWS_APART * cycle.noise / math.sqrt(2 * MEAN + 1)
        or float(-cycle.load.min()) < ROWS_APART * cycle.noise
    ):
        raise InputError(
            f"{cycle.curve.where}: w: no adhesion shows, no load lies below that before contact; leave w out"
        )


def _with_base_line(cycle: Cycle, settings: RelaxationSettings) -> RelaxationSettings:
    """Free too, unless fixed, are the stress and, where there are free rows, the zeros."""
    if not settings.ranged:
        settings = replace(settings, adhesion=(*settings.adhesion, "stress"))
    free = cycle.free.sum() >= BASE_FEWEST
    zeros = [
        name for name in ("delta0", "P0", "tilt") if name not in settings.fixed and (name in settings.zeros or free)
    ]
    if "tilt" in zeros and "tilt" not in settings.zeros and np.ptp(cycle.z[cycle.free]) < 0.05 * np.ptp(cycle.z):
        zeros.remove("tilt")
    return replace(settings, zeros=tuple(zeros))


def _beside(fine: Adhering, like: RelaxationFit) -> Nearby | None:
    """The likeliest unknowns from the specimen of another fit on, with the record's own begin of contact; None where
    that leads nowhere."""
    values = {item.name: item.value for item in like.estimates} | dict(like.settings.fixed)
    with contextlib.suppress(SolveError, ArithmeticError, ValueError):  # a LinAlgError is one
        length = values["range"] if "range" in values else values["w"] / values["stress"]
        own = {"delta0": fine.cycle.touch + length, "P0": fine.cycle.base[0], "tilt": fine.cycle.base[1]}
        x = fine.unknowns.at({**values, **own, **fine.settings.fixed})
        found = _least(Nearby.of(fine, x), FINE[2])
        if found.ended and found.scatter <= min(LIKE * like.scatter, SEARCH_MISFIT):
            return found
    return None


def _begun(fine: Adhering) -> tuple[Adhering, Array]:
    """The problem ``fine`` with a standard solid, by which every search begins, and its unknowns after rough ones."""
    cycle, settings = fine.cycle, fine.settings
    if settings.law != "sls":
        known = {name: value for name, value in settings.fixed.items() if name not in settings.of_law}
        settings = replace(settings, law="sls", fixed=known)
    fine = replace(fine, settings=settings, unknowns=Unknowns(settings.parameters, fine.unknowns.units))
    rough = np.maximum(ROUGH * (cycle.pulled + np.abs(cycle.load)), cycle.noise)
    jumps = fine.jumps.copy()
    jumps[np.isfinite(jumps[:, 1]), 1] = ROUGH_TIME * cycle.lasting
    sigma = np.where(cycle.free, 3 * cycle.noise, rough)
    model = replace(fine, width=SEARCH[0], tolerance=SEARCH[1], sigma=sigma, jumps=jumps, left_out=cycle.near(NEAR))
    return fine, _best(model, _starts(model), SEARCH[2])


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
    shows, top = cycle.touch, first + int(np.argmax(cycle.z[first:end]))  # at the reversal
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
        law = {"ratio": ratio, "time": time * cycle.lasting}
        starts.append(model.unknowns.at({**values, **law, "modulus": modulus, **fixed}))
    low, high = zip(*(model.unknowns.bounds(theta, FARTHEST) for theta in starts), strict=True)
    starts = [np.clip(theta, a, b) for theta, a, b in zip(starts, low, high, strict=True)]
    costs = []
    for theta, march in zip(starts, model.march([model.trial(theta) for theta in starts]), strict=True):
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


def _law_near(settings: RelaxationSettings, ratio: float, time: float, lasting: float) -> dict[str, float]:
    """Parameters of a law near a standard solid of ``ratio`` and ``time`` [s] in a contact ``lasting`` so long [s]; the
    "modulus" of a power law is over that at t = 0."""
    if settings.law == "power":
        left, onset = ratio + (1 - ratio) * math.exp(-lasting / time), ONSET * lasting
        exponent = min(max(-math.log(left) / math.log1p(lasting / onset), 0.01), 0.9)
        return {"onset": onset, "exponent": exponent, "modulus": (settings.fixed["time"] / onset) ** -exponent}
    n = settings.terms
    weights = {f"weight{i + 1}": max((1 - ratio) / n, 0.01) for i in range(n)}
    return weights | {f"time{i + 1}": time * APART_TIMES ** (i - (n - 1) / 2) for i in range(n)}


def _least(near: Nearby, evaluations: int) -> Nearby:
    """Where the record is likeliest, by steps to where it is by what it says near the last ones, first with the stress
    nearly held, which takes up what other unknowns are off; ``ended`` where the loads there hardly differ."""
    for held in (HELD, 1.0):
        within, ended = WITHIN[1], False
        for _ in range(evaluations):
            there = Posterior.of(near, 1.0, within, held).likeliest()
            if ended := near.moves(there) < CONVERGED:
                break
            new = Nearby.of(near.model, there)
            gained = near.cost - new.cost
            near = new if gained > 0 else near
            if ended := -CONVERGED - SCATTERS[1] * near.cost < gained < CONVERGED + SCATTERS[0] * near.cost:
                break
            within = min(within * 3, WITHIN[2]) if gained > 0 else within / 5
            if within < WITHIN[0]:
                break
    return replace(near, ended=ended)


def _result(near: Nearby, shift: Array) -> RelaxationFit:
    """The answer ``near`` the likeliest unknowns; ``shift``: of these, by the widths of zones that are extrapolated."""
    model, state = near.model, near.state
    settings, unknowns, cycle = model.settings, model.unknowns, model.cycle
    variance = max(1.0, near.scatter**2)
    own = covariance(state.jacobian, variance)
    own = own if own is None else own + MARCH_ERROR**2 * np.outer(shift, shift)
    middle, samples = Posterior.of(near, variance).samples(shift)
    low, high = unknowns.bounds(middle, FARTHEST)
    problem = LeastSquares(model, (low, high))
    least = Least(problem, middle, state, near.cost, (middle <= low) | (middle >= high), 0, near.ended)
    intervals = Intervals.of(unknowns, least, settings.level, "covariance", model.body.problem.E_star, variance)
    intervals = replace(intervals, covariance=own, samples=samples)
    fit = RelaxationFit(
        estimates=intervals.estimates(), free=unknowns.names, dof=least.dof, covariance=unknowns.covariance(own),
        relaxation=settings.relaxation(unknowns.values(least.x)), record=cycle.record(), imposed=cycle.z,
        response=np.where(replace(model, steep=STEEP[1]).out(near.here), np.nan, model.loads(near.x, near.here)),
        settings=settings, scatter=near.scatter, samples=samples * unknowns.scales,
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
SPECTRUM_STEP, LAW_STEP = 0.03, 1e-3  # choice: of r, and of parameters of laws, for differences
SPECTRUM_TIMES = np.geomspace(1e-4, 1.0, 50)  # choice: over the time in contact, at which r is told by these
OMEGA = np.linalg.pinv(np.expm1(-np.multiply.outer(SPECTRUM_TIMES, SPECTRUM)), rcond=1e-4).T  # of r at these
# choice: quantiles are then good to a tenth of a standard error
WALKERS, WALKED, BURNT, KEPT, TRIALS = 48, 330, 160, 600, 96
# choice: steps to valleys, and near them, where samples begin; ends of shares there; times over that in contact
SETTLING, SETTLING_NEAR, SHARE_ENDS, TIMES_TRIED = 15, 5, 1e-3, (0.01, 100.0)
UNKNOWN = 10.0  # choice: of logs, beyond which samples say no more
STRETCH = 2.0  # theory: of Goodman and Weare's moves (Comm. App. Math. Comp. Sci. 5 (2010) 65)
SEED = 1  # choice: the same samples every day


@dataclass(frozen=True, eq=False)
class Nearby:
    """What the record says near the unknowns ``x``, by the ``marches`` of these with the ``modes``, of steps of those
    that are not of the law and of r(t) at each rate; ``ended``: whether ``x`` is the likeliest."""

    model: Adhering
    x: Array
    modes: Modes
    marches: Sequence[Marched]
    ended: bool = False

    @classmethod
    def of(cls, model: Adhering, x: Array) -> Nearby:
        trial, added, names = model.trial(x), list[Trial](), cls._others(model)
        modes, step = trial.modes, cls._step(trial.modes)
        for q in (SPECTRUM / model.cycle.lasting).tolist():
            more = Modes(modes.relaxed - step, np.append(modes.weights, step), np.append(modes.rates, q))
            added.append(replace(trial, modes=more))
        trials = [trial, *map(model.trial, model.moved(x, names)), *added]
        return cls(model, x, modes, model.march(trials, [0] * len(trials)))

    @staticmethod
    def _step(modes: Modes) -> float:
        return SPECTRUM_STEP if modes.relaxed > 2 * SPECTRUM_STEP else -SPECTRUM_STEP

    def by_law(self, settings: RelaxationSettings) -> Nearby:
        """The same for the parameters of another law that is not far."""
        model, cycle = self.model, self.model.cycle
        values = model.unknowns.values(self.x)
        unknowns = Unknowns(settings.parameters, model.unknowns.units)
        law = _law_near(settings, values["ratio"], values["time"], cycle.lasting)
        at_once = values["modulus"] * law.pop("modulus", 1.0)
        x = unknowns.at({**values, **law, "modulus": at_once, **settings.fixed})
        return replace(self, model=replace(model, settings=settings, unknowns=unknowns), x=x)

    @staticmethod
    def _others(model: Adhering) -> list[str]:
        """The unknowns that are not of the law and move the contact."""
        return [name for name in model.unknowns.names
                if name not in LINE and _likely(name, model.cycle.lasting) is None]  # fmt: skip

    @property
    def here(self) -> Marched:
        return self.marches[0]

    @cached_property
    def own(self) -> Array:
        """Mask of the unknowns of the law."""
        return np.array([_likely(name, self.model.cycle.lasting) is not None for name in self.model.unknowns.names])

    @property
    def names(self) -> list[str]:
        """Of the unknowns of the law."""
        return [name for name, own in zip(self.model.unknowns.names, self.own, strict=True) if own]

    @cached_property
    def by_r(self) -> Array:
        """Derivatives of the residuals by the omega_k, (rows, rates)."""
        step, there = self._step(self.modes), self.marches[1 + len(self._others(self.model)) :]
        loads = self.model.loads(self.x, self.here)
        return np.stack([self.model.change(self.here, loads, self.x, one) for one in there], axis=1) / step

    @cached_property
    def state(self) -> State:
        """Residuals at ``x`` and their derivatives, by the law through r(t)."""
        others, law, unit = self._others(self.model), self.x[self.own], np.eye(int(self.own.sum()))
        columns = self.model.rates(self.x, self.here, others, self.marches[1 : 1 + len(others)])
        for name, direction in zip(self.names, unit, strict=True):
            ends = law + LAW_STEP * np.multiply.outer([1.0, -1.0], direction)
            by = np.diff(self.spectrum(ends), axis=0)[0] / (-2 * LAW_STEP)
            columns[name] = self.by_r @ by
            if "modulus" in columns:
                stiffer = math.log(np.divide(*self.r(ends, np.zeros(1))[:, 0])) / (2 * LAW_STEP)
                columns[name] = columns[name] + stiffer * columns["modulus"]
        return self.model.state(self.x, self.here, columns)

    @property
    def cost(self) -> float:
        return self.state.cost

    @property
    def scatter(self) -> float:
        """Standard deviation of the residuals of the rows over the noise they are weighed by."""
        off = self.state.residuals[: self.model.cycle.t.size]
        return math.sqrt(float(off @ off) / max(int(np.count_nonzero(off)) - self.x.size, 1))

    def r(self, law: Array, t: Array) -> Array:
        """r at the times ``t`` [s] (n, times) of laws (n, parameters)."""
        settings = self.model.settings
        every: dict[str, Array] = {name: np.asarray(value) for name, value in settings.fixed.items()}
        every |= {name: np.exp(one) if _is_time(name) else one for name, one in zip(self.names, law.T, strict=True)}
        return np.broadcast_to(RELAXED[settings.law](every, t), (len(law), t.size))

    def spectrum(self, law: Array) -> Array:
        """The weights of exp(-q_k t) - 1 in r(t)/r(0) - 1 of laws (n, parameters), (n, rates)."""
        r = self.r(law, np.append(0.0, SPECTRUM_TIMES) * self.model.cycle.lasting)
        found: Array = (r[:, 1:] / r[:, :1] - 1) @ OMEGA
        return found

    @cached_property
    def own_spectrum(self) -> Array:
        """That of the ``modes``."""
        t = SPECTRUM_TIMES * self.model.cycle.lasting
        found: Array = np.expm1(-np.multiply.outer(t, self.modes.rates)) @ self.modes.weights @ OMEGA
        return found

    def stiffer(self, law: Array) -> Array:
        """Log of r(0) of laws (n, parameters) over that of ``x``, (n,)."""
        zero = np.zeros(1)
        found: Array = np.log(self.r(law, zero) / self.r(self.x[self.own][None], zero))[:, 0]
        return found

    def moves(self, x: Array) -> float:
        """By how many standard errors of the rows the loads at ``x`` differ from those here, squared."""
        law, by = x[self.own][None], x - self.x
        if "modulus" in self.model.unknowns.names:
            i = self.model.unknowns.names.index("modulus")
            by[i] = math.expm1(by[i] + self.stiffer(law)[0])
        stiffer = 1 + (by[i] if "modulus" in self.model.unknowns.names else 0.0)
        omega = stiffer * (self.spectrum(law)[0] - self.own_spectrum)
        moved = self.state.jacobian[: len(self.by_r), ~self.own] @ by[~self.own] + self.by_r @ omega
        return float(moved @ moved)


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is likely of the law's parameters by what the record says ``near`` some unknowns, and of the others given
    these. Loads are linear in E(t), (1 + mu) r(t) + sum omega_k (exp(-q_k t) - 1) over the modulus at t = 0: minus
    twice the log is |``left`` + ``stiff`` mu + ``matrix`` omega|^2, least in mu, and the others, all but that
    modulus at t = 0, are ``mean`` + ``by`` (mu, omega) with the Cholesky root ``spread`` of their covariance."""

    near: Nearby
    others: Array
    left: Array
    stiff: Array
    matrix: Array
    mean: Array
    by: Array
    spread: Array

    @classmethod
    def of(cls, near: Nearby, variance: float, within: float = math.inf, held: float = 1.0) -> Posterior:
        """Of residuals of the ``variance``, over the noise; ``within``: how far off logs of the others are likely, of
        the cohesive stress that times ``held``."""
        J, off, rows = near.state.jacobian, near.state.residuals, len(near.by_r)
        modulus = np.array([name == "modulus" for name in near.model.unknowns.names])
        logs = np.array([one.kind == "log" for one in near.model.unknowns.free])
        others = ~near.own & ~modulus
        far = logs / within / np.where(np.isin(near.model.unknowns.names, ZONE), held, 1.0)
        # in the end what marches err by, another in each half of each piece of the program, are unknowns too
        errs = near.model.march_errors(near.here, near.x) * math.isinf(within)
        m, p, n = errs.shape[1], int(others.sum()), off.size
        every = np.zeros((n + m + p + 1, p + m + near.by_r.shape[1] + 2))
        every[:n, :p], every[:n, p + m], every[:n, -1] = J[:, others], J[:, modulus].sum(axis=1), off
        every[: len(errs), p : p + m], every[:rows, p + m + 1 : -1] = errs, near.by_r
        every[rows : rows + int(near.own.sum())] = 0.0  # what is likely of the law is told apart
        every[:n] /= math.sqrt(variance)
        every[n : n + m, p : p + m] = np.eye(m)
        every[n + m : -1, :p], every[-1, p + m] = np.diag(far[others]), modulus @ far
        Q, R = np.linalg.qr(every[:, : p + m])
        on = Q.T @ every[:, p + m :]
        seen = np.linalg.qr(every[:, p + m :] - Q @ on)[1]
        back = np.linalg.pinv(R)[:p]
        spread, found = back @ back.T, -back @ on
        root = np.linalg.cholesky(spread + 1e-12 * np.diag(np.diag(spread)))
        return cls(near, others, seen[:, -1], seen[:, 0], seen[:, 1:-1], found[:, -1], found[:, :-1], root)

    def told(self, law: Array) -> tuple[Array, Array, Array]:
        """What is left of all rows and of what is likely before, by parameters ``law`` (n, parameters), as residuals
        (n, rows), with the likeliest mu (n,), and its standard deviation."""
        changed = (self.near.spectrum(law) - self.near.own_spectrum) @ self.matrix.T
        off = self.left + changed
        mu, known = np.zeros(len(law)), np.zeros(len(law))
        if self.stiff.any():
            by = self.stiff + changed
            known = 1 / np.maximum(np.sqrt(np.sum(by**2, axis=1)), TINY)
            mu = np.maximum(-np.sum(by * off, axis=1) * known**2, SAME - 1)
            off = off + mu[:, None] * by
        likely = np.array([_likely(name, self.near.model.cycle.lasting) for name in self.near.names]).reshape(-1, 2)
        return np.concatenate([off, (law - likely[:, 0]) / likely[:, 1]], axis=1), mu, known

    def off(self, law: Array) -> Array:
        """The residuals of ``told``."""
        return self.told(law)[0]

    def log(self, law: Array) -> Array:
        """Logs of what parameters ``law`` (n, parameters) are likely."""
        shares = law[:, [not _is_time(name) for name in self.near.names]]
        weights = law[:, [name.startswith("weight") for name in self.near.names]]
        possible = ((shares > 0) & (shares < 1)).all(axis=1) & (weights.sum(axis=1) < 1)
        return np.where(possible, -np.sum(self.off(law) ** 2, axis=1) / 2, -np.inf)

    def samples(self, march: Array) -> tuple[Array, Array]:
        """A point in the middle of what is likely, and samples of all unknowns (n, unknowns); ``march``: what narrower
        zones moved them, of which a part may be left over."""
        rng = np.random.default_rng(SEED)
        law = np.tile(self.near.x[self.near.own], (KEPT, 1))
        if law.size:
            law = rng.choice(self._walked(rng), KEPT, replace=False)
        found = self._whole(law, rng.standard_normal(KEPT))
        found[:, self.others] += rng.standard_normal((KEPT, len(self.mean))) @ self.spread.T
        found += MARCH_ERROR * rng.standard_normal((KEPT, 1)) * march
        shares = [i for i, name in enumerate(self.near.model.unknowns.names) if self.near.own[i] and not _is_time(name)]
        found[:, shares] = np.clip(found[:, shares], SAME, 1 - SAME)
        logs = np.array([one.kind == "log" for one in self.near.model.unknowns.free])
        middle = self._central(law)
        return middle, np.where(logs, np.clip(found, middle - UNKNOWN, middle + UNKNOWN), found)

    def _whole(self, law: Array, errors: Array | float = 0.0) -> Array:
        """All unknowns (n, unknowns) with those of the ``law`` and the most likely of the others; of a modulus at t = 0
        that is so many standard ``errors`` more."""
        _, mu, known = self.told(law)
        mu = np.maximum(mu + errors * known, SAME - 1)
        omega = (1 + mu)[:, None] * (self.near.spectrum(law) - self.near.own_spectrum)
        found = np.tile(self.near.x, (len(law), 1))
        found[:, self.near.own] = law
        found[:, self.others] += self.mean + np.column_stack([mu, omega]) @ self.by.T
        if "modulus" in self.near.model.unknowns.names:
            i = self.near.model.unknowns.names.index("modulus")
            found[:, i] += np.log1p(mu) - self.near.stiffer(law)
        return found

    def _central(self, law: Array) -> Array:
        """Of the samples of a ``law`` that whose r(t) is nearest to the medians, with the most likely others."""
        r = np.log(np.maximum(self.near.r(law, SPECTRUM_TIMES * self.near.model.cycle.lasting), TINY))
        off = (r - np.median(r, axis=0)) / np.maximum(np.std(r, axis=0), TINY)
        nearest = int(np.argmin(np.sum(off**2, axis=1)))
        whole: Array = self._whole(law[nearest : nearest + 1])[0]
        return whole

    def likeliest(self) -> Array:
        """The unknowns with the likeliest law."""
        law = self._settled(self._about(np.random.default_rng(SEED)))
        whole: Array = self._whole(law[:1])[0]
        return whole

    def _about(self, rng: np.random.Generator) -> Array:
        """Parameters of the law: its own, first, others near to it, and as many anywhere."""
        here, lasting = np.tile(self.near.x[self.near.own], (TRIALS, 1)), self.near.model.cycle.lasting
        for i, name in enumerate(self.near.names):
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
        steps = np.array([0.01 if _is_time(name) else 1e-3 for name in self.near.names])
        shares = np.array([not _is_time(name) for name in self.near.names], dtype=bool)
        for _ in range(steps_of if d else 0):
            off = self.off(law)
            J = np.stack([(self.off(law + step) - off) / step.sum() for step in np.diag(steps)], axis=2)
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
        names, power = self.near.names, self.near.model.settings.law == "power"
        exponentials = not power and [*map(_is_time, names)] == [False, True] * (len(names) // 2)
        turned = -1.0 if self.near.names[0] == "ratio" else 1.0  # the weight is 1 - ratio

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
        terms = self.near.model.settings.terms
        if self.near.model.settings.law != "prony" or len(self.near.names) < 2 * terms:
            return law
        pairs = law.reshape(-1, terms, 2)
        order = np.argsort(pairs[..., 1], axis=1)
        return np.take_along_axis(pairs, order[..., None], axis=1).reshape(law.shape)


def _is_time(name: str) -> bool:
    return name.rstrip("0123456789") in LIKELY_TIMES

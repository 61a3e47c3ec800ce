"""The modulus, a law of relaxation, w and its cohesive stress from one whole force curve, with its free rows.

Every row counts, by P_read = P0 + tilt (z - z_0) + P(t; body, w, stress, law) + noise: where the fitted contact is
not, P = 0, so that free rows say what offset, tilt and noise are and nothing else. The loads are marches of all trial
parameters at once (``lockstep_march.py``), P(E, w, sigma) = E p(w/E, sigma/E). Which side of a jump a row lies on is
not known within some rows of it: they are left out, and the time of the jump is a reading of its own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.finite_range import AttractedBody
from ..base.errors import InputError, SolveError
from ..base.numerics import FEWEST_ROWS, SAME, TINY, Array
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import SEARCH_MISFIT, Intervals, Least, LeastSquares, State, covariance
from ..measured.lockstep import together
from ..measured.parameters import Unknowns
from .lockstep_march import Kernel, March, Marched, Trial
from .relaxing_adhesion import ZONE_SLOPE
from .timed_record import (
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
ZONES = (0.25, 0.02)  # choice: zones over the contact radius, where no range is known
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
CONVERGED = 2e-3  # choice: of the sum of squares
STEP, SHARE_STEP, ZERO_STEP = 0.01, 0.005, 0.002  # choice: of logs, of shares, of the zero over the way
MARCH_ERROR = 0.5  # choice: of what zones half as wide change, extrapolated, what they may still err by
LOAD_ERROR = 1e-3  # choice: of loads and pull-off force; twice what fine marches differ from those of other equations
# What is likely before, half-widths of normal distributions.
LIKELY_RANGE, RANGES = 4.5e-10, 3.0  # theory: w/stress of dry contact, 0.2 to 1 nm; log: 20 times it is no rarity
LIKELY = {"ratio": (0.5, 0.5), "weight": (0.4, 0.4)}  # choice: hardly anything
LIKELY_TIME = 4.0  # choice: log of a time over the time in contact


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
        k, z = _lever(curve)
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
        noise = noise_of(self.z), self.noise
        own = self.curve, self.t, self.z, self.P
        return TimedRecord(*own, "displacement", self.stiffness, self.program, noise, noise, read=not self.straight)


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


def _lever(curve: Curve) -> tuple[float, Array]:
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
    to the loads [N]; ``kernels``: the last kernel."""

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
    kernels: dict[str, Kernel] = field(default_factory=dict)

    def trial(self, theta: Array) -> Trial:
        """The specimen of the unknowns ``theta``."""
        values = self.unknowns.values(theta)
        m, w = values["modulus"], values["w"]
        stress = values["stress"] if "stress" in values else w / values["range"]
        modes = self.settings.relaxation(values).modes(float(np.ptp(self.cycle.t)))
        return Trial(w / m, stress / m, self.cycle.stiffness / m, modes, values["delta0"])

    def marched(self, thetas: Sequence[Array]) -> list[Marched]:
        """Marches of many unknowns."""
        return self.march([self.trial(theta) for theta in thetas])

    def march(self, trials: Sequence[Trial]) -> list[Marched]:
        """Marches of many trials."""
        march = March(self.body.problem, self.attracted, trials, self.cycle.program, self.width, self.tolerance,
                      self.kernels.get(""))  # fmt: skip
        self.kernels[""] = march.kernel  # type: ignore[assignment]
        return march.run()

    def loads(self, theta: Array, marched: Marched) -> Array:
        """The loads that are read [N]."""
        values, cycle = self.unknowns.values(theta), self.cycle
        line = values["P0"] + values["tilt"] * (cycle.z - cycle.z[0])
        found: Array = line + values["modulus"] * marched.load(cycle.t) + self.correction
        return found

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
        P = self.unknowns.values(theta)["modulus"] * here.load(cycle.t)
        err = np.where(self.left_out, 0.0, LOAD_ERROR * (np.abs(P) + cycle.pulled * (P != 0)) / self.sigma)
        piece = np.clip(np.searchsorted(cuts, cycle.t, side="right") - 1, 0, cuts.size - 2)
        return err[:, None] * (piece[:, None] == np.arange(cuts.size - 1))

    def steps(self, theta: Array) -> Array:
        """Of the unknowns for differences: shares towards the middle."""
        steps = np.full(theta.size, STEP)
        for i, one in enumerate(self.unknowns.free):
            if one.kind != "log":
                steps[i] = ZERO_STEP if one.name == "delta0" else SHARE_STEP if theta[i] < 0.5 else -SHARE_STEP
        return steps

    def prior(self, theta: Array) -> tuple[Array, Array]:
        """What is likely before, as residuals."""
        values, names, rows, by = self.unknowns.values(theta), self.unknowns.names, list[float](), list[Array]()
        unit = np.eye(theta.size)
        for i, name in enumerate(names):
            plain = name.rstrip("0123456789")
            if plain == "time":
                rows.append((theta[i] - math.log(self.cycle.lasting / 4)) / LIKELY_TIME)
                by.append(unit[i] / LIKELY_TIME)
            elif plain in LIKELY:
                rows.append((theta[i] - LIKELY[plain][0]) / LIKELY[plain][1])
                by.append(unit[i] / LIKELY[plain][1])
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
        return LeastSquares(self, (low, high), 1e-6, CONVERGED, evaluations)


def adhering_fit(body: FittedBody, curve: Curve, settings: RelaxationSettings) -> RelaxationFit:
    """The fit of a force curve with its retraction and free rows, w among the unknowns."""
    if body.no_range:
        raise InputError(body.no_range.replace("adhesion of finite range", "adhesion on a viscoelastic specimen"))
    cycle = Cycle.of(curve)
    if _load_is_prescribed(curve, cycle):
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
    # a search begins with a standard solid, whatever the law
    known = {name: value for name, value in settings.fixed.items() if name.rstrip("0123456789") not in LAW_NAMES}
    solid = settings if settings.law == "sls" else replace(settings, law="sls", fixed=known)
    unknowns = Unknowns(solid.parameters, units)

    rough = np.maximum(ROUGH * (cycle.pulled + np.abs(cycle.load)), cycle.noise)
    seen = np.array(cycle.jumps)
    jumps = np.where(
        np.isfinite(seen)[:, None], np.stack([seen, np.full(2, ROUGH_TIME * cycle.lasting)], axis=1), [0.0, math.inf]
    )
    near = np.any(np.abs(cycle.t[:, None] - seen) < NEAR * cycle.spacing, axis=1)
    sigma = np.where(cycle.free, 3 * cycle.noise, rough)
    model = Adhering(body, attracted, cycle, solid, unknowns, *SEARCH[:2], sigma, jumps, near)
    begun = _starts(model, solid)
    ends = together([model.search(theta, SEARCH[2]).searching(theta) for theta in begun])
    found = [one for one in ends if not isinstance(one, Exception)]
    if not found:
        raise SolveError("no history of this specimen resembles the data")
    theta = min(found, key=lambda one: one.cost).x
    theta = model.search(theta, 2 * SEARCH[2]).least(theta).x
    if settings.law != "sls":
        values = unknowns.values(theta)
        values |= _law_of(settings, values["ratio"], values["time"])
        values |= settings.fixed
        model = replace(model, settings=settings, unknowns=Unknowns(settings.parameters, units))
        theta = np.clip(model.unknowns.at(values), *model.unknowns.bounds(model.unknowns.at(values), FARTHEST))
        theta = model.search(theta, 2 * SEARCH[2]).least(theta).x

    # All rows by their noise, the jumps where the rows show them; then narrower zones, extrapolated.
    error = math.hypot(cycle.spacing / math.sqrt(12), JUMP_TIME * cycle.lasting)
    fine = replace(
        model, width=FINE[0], tolerance=FINE[1], sigma=np.full(cycle.t.size, cycle.noise),
        jumps=np.where(np.isfinite(jumps), [1.0, error / (ROUGH_TIME * cycle.lasting)], 1.0) * jumps,
        left_out=np.any(np.abs(cycle.t[:, None] - seen) < APART * cycle.spacing, axis=1),
    )  # fmt: skip
    more = 1 if settings.law == "sls" else 2  # terms are found along a valley
    least = fine.search(theta, more * FINE[2]).least(theta)
    theta, scatter = least.x, _scatter(fine, least)
    here = fine.marched([theta])[0]
    narrow = replace(fine, width=FINEST * FINE[0])
    there = narrow.marched([theta])[0]
    change = (narrow.loads(theta, there) - fine.loads(theta, here)) / (1 - FINEST)
    change = np.where(fine.apart(here, (there.begun, there.lost)), 0.0, change)
    fine = replace(fine, correction=change)
    return _result(fine, least, change, (there.lost - here.lost) / (1 - FINEST), scatter)


def _load_is_prescribed(curve: Curve, cycle: Cycle) -> bool:
    """Whether the load moved in fewer straight pieces than the device."""
    return _corners(cycle.t, cycle.P)[0].size < cycle.program[0].size


def _starts(model: Adhering, settings: RelaxationSettings) -> list[Array]:
    """The best of some values, with each of some ratios and times: the pull-off force tells w in a very fast cycle,
    where it is elastic, from rest, where it is the ratio times that of the relaxed modulus, and between; the load at
    the reversal tells the modulus."""
    cycle, body = model.cycle, model.body
    limits, fixed = ElasticLimits(body.nonadhesive), settings.fixed
    first, end = cycle.contact
    shows, top = float(cycle.tip[first]), first + int(np.argmax(cycle.z[first:end]))  # at the reversal
    depth, load = float(cycle.tip[top]), float(cycle.load[top])
    radius = float(np.interp(depth - shows, body.series.delta, body.series.a))
    starts = []
    for ratio, time, share, zone in itertools.product(
        RATIOS, TIMES, SHARES, (1.0,) if settings.fixed.keys() & {"stress", "range"} else ZONES
    ):

        def work(modulus: float, ratio: float = ratio, share: float = share) -> float:
            fast, rest = (limits.work(modulus, cycle.pulled), ratio * limits.work(ratio * modulus, cycle.pulled))
            return float(fast ** (1 - share) * rest**share)

        zero = shows
        for _ in range(ROUNDS):
            modulus = fixed.get("modulus", limits.modulus(depth - zero, load, work))
            w = fixed.get("w", work(modulus))
            stress = math.sqrt(ZONE_SLOPE * modulus * body.problem.E_star * w / (zone * radius))
            length = fixed.get("range", w / fixed.get("stress", stress))
            zero = shows + min(length, depth - shows)
        own = {"ratio": ratio, "time": time * cycle.lasting}
        line = {"P0": cycle.base[0], "tilt": cycle.base[1]}
        values = {"modulus": modulus, "w": w, "stress": w / length, "range": length, "delta0": zero}
        values |= {**line, **own, **fixed}
        starts.append(model.unknowns.at(values))
    low, high = zip(*(model.unknowns.bounds(theta, FARTHEST) for theta in starts), strict=True)
    starts = [np.clip(theta, a, b) for theta, a, b in zip(starts, low, high, strict=True)]
    costs = []
    for theta, march in zip(starts, model.marched(starts), strict=True):
        off = (model.loads(theta, march) - cycle.P) / model.sigma
        lost = march.lost if math.isfinite(march.lost) else cycle.t[-1] + cycle.lasting / 4
        missed = 0.0 if math.isinf(model.jumps[1, 1]) else (lost - model.jumps[1, 0]) / cycle.lasting
        costs.append(float(np.sum(np.log1p(off**2))) * (1 + abs(missed)))
    return [starts[i] for i in np.argsort(costs)[:BEGINS]]


def _law_of(settings: RelaxationSettings, ratio: float, time: float) -> dict[str, float]:
    """Parameters of Prony's series near a standard solid of ``ratio`` and ``time`` [s]."""
    n = settings.terms
    weights = {f"weight{i + 1}": max((1 - ratio) / n, 0.01) for i in range(n)}
    return weights | {f"time{i + 1}": time * 8.0 ** (i - (n - 1) / 2) for i in range(n)}


def _scatter(model: Adhering, least: Least) -> float:
    """Standard deviation of the residuals of the rows over the noise they are weighed by."""
    rows = least.state.residuals[: model.cycle.t.size]
    return math.sqrt(float(rows @ rows) / max(int(np.count_nonzero(rows)) - least.x.size, 1))


def _result(model: Adhering, least: Least, change: Array, later: float, scatter: float) -> RelaxationFit:
    """One more step of Gauss and Newton with the ``change`` of the loads [N] by narrow zones, which make contact end
    so much ``later`` [s], and the answer."""
    settings, unknowns, cycle = model.settings, model.unknowns, model.cycle
    J, before, n = least.state.jacobian, least.state.residuals, cycle.t.size
    rows, moved = np.any(J[:n] != 0, axis=1), np.zeros_like(before)
    moved[:n] = np.where(rows, change / model.sigma, 0.0)
    if math.isfinite(model.jumps[1, 1]) and math.isfinite(later):
        moved[n + int(np.isfinite(model.jumps[0, 1]))] = later / model.jumps[1, 1]
    shift = np.clip(least.x - np.linalg.lstsq(J, moved, rcond=None)[0], *least.problem.bounds) - least.x
    after = before + moved + J @ shift
    least = replace(least, x=least.x + shift, state=State(after, lambda: J))
    variance = max(1.0, scatter**2)
    own = covariance(J, variance)
    own = own if own is None else own + MARCH_ERROR**2 * np.outer(shift, shift)
    samples = Posterior.of(model, least, variance).samples(shift)
    least = replace(least, x=np.median(samples, axis=0))
    intervals = Intervals.of(unknowns, least, settings.level, "covariance", model.body.problem.E_star, variance)
    intervals = replace(intervals, covariance=own, samples=samples)
    fit = RelaxationFit(
        estimates=intervals.estimates(), free=unknowns.names, dof=least.dof, covariance=unknowns.covariance(own),
        relaxation=settings.relaxation(unknowns.values(least.x)), record=cycle.record(), imposed=cycle.z,
        response=np.where(rows, cycle.P + after[:n] * model.sigma, np.nan), settings=settings,
        scatter=scatter, samples=samples * unknowns.scales,
    )  # fmt: skip
    warnings = [] if least.ended else [f"{UNSETTLED}: values and intervals are preliminary"]
    if fit.scatter > SEARCH_MISFIT:
        warnings.append(f"residuals are {fit.scatter:.2g} times the scatter from row to row: {MISFIT}")
    return replace(fit, warnings=tuple(warnings))


# --------------------------------------------------------------------------------------------------
# What the record leaves of the law. Where little relaxes within it, ratio and time are known together only, on no
# ellipse. The loads, though, are nearly linear in r(t) itself: r = r_0 + sum of omega_k (exp(-q_k t) - 1).

SPECTRUM = np.geomspace(0.3, 300.0, 8)  # choice: rates q_k over the time in contact
SPECTRUM_STEP = 0.01  # choice: of r, for differences
SPECTRUM_TIMES = np.geomspace(1e-3, 1.0, 40)  # choice: over the time in contact, at which r is told by these
# choice: quantiles are then good to a tenth of a standard error
WALKERS, WALKED, BURNT, KEPT, TRIALS = 48, 450, 200, 600, 4000
LAW_NAMES = ("ratio", "time", "weight")
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
        own = np.array([name.rstrip("0123456789") in LAW_NAMES for name in names])
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

    def log(self, law: Array) -> tuple[Array, Array]:
        """Logs of what parameters ``law`` (n, parameters) are likely, and their omega."""
        lasting, settings = self.model.cycle.lasting, self.model.settings
        t = SPECTRUM_TIMES * lasting
        names = [name for name, one in zip(self.model.unknowns.names, self.own, strict=True) if one]
        unit = dict(zip(names, law.T, strict=True))
        every: dict[str, Array] = {name: np.asarray(value) for name, value in settings.fixed.items()}
        for name in names:
            every[name] = np.exp(unit[name]) if name.startswith("time") else unit[name]
        start = every.copy()
        for name, value in zip(names, self.x[self.own], strict=True):
            start[name] = np.exp(value) if name.startswith("time") else value
        r = RELAXED[settings.law](every, t) - RELAXED[settings.law](start, t)
        basis = np.expm1(-np.multiply.outer(t, SPECTRUM / lasting))
        omega = r @ np.linalg.pinv(basis, rcond=1e-4).T
        chi2 = np.sum((self.right + omega @ self.matrix.T) ** 2, axis=1)
        weights = np.zeros(len(law))
        for name in names:
            plain = name.rstrip("0123456789")
            if plain == "time":
                chi2 = chi2 + ((unit[name] - math.log(lasting / 4)) / LIKELY_TIME) ** 2
            else:
                chi2 = chi2 + ((unit[name] - LIKELY[plain][0]) / LIKELY[plain][1]) ** 2
                chi2 = np.where((unit[name] > 0) & (unit[name] < 1), chi2, np.inf)
                weights += unit[name] * (plain == "weight")
        return -np.where(weights < 1, chi2, np.inf) / 2, omega

    def samples(self, march: Array) -> Array:
        """Samples of all unknowns (n, unknowns); ``march``: what narrower zones moved them, of which a part may be left
        over."""
        rng, d = np.random.default_rng(SEED), int(self.own.sum())
        found, rows = np.tile(self.x, (KEPT, 1)), np.zeros((KEPT, self.matrix.shape[1]))
        if d:
            names = [name for name, one in zip(self.model.unknowns.names, self.own, strict=True) if one]
            here = np.tile(self.x[self.own], (TRIALS, 1))
            for i, name in enumerate(names):
                width = 10 ** rng.uniform(-3, 0.3, TRIALS) * (2.0 if name.startswith("time") else 0.3)
                here[:, i] += rng.normal(0, 1, TRIALS) * width
            here = here[np.argsort(-self.log(here)[0])[:WALKERS]]
            log, kept = self.log(here)[0], []
            halves = np.arange(WALKERS) < WALKERS // 2
            for step in range(WALKED):
                for some in (halves, ~halves):
                    stretch = (1 + (STRETCH - 1) * rng.random(WALKERS // 2)) ** 2 / STRETCH
                    other = rng.choice(here[~some], WALKERS // 2)
                    tried = other + stretch[:, None] * (here[some] - other)
                    there = self.log(tried)[0]
                    takes = np.log(rng.random(WALKERS // 2)) < (d - 1) * np.log(stretch) + there - log[some]
                    here[some] = np.where(takes[:, None], tried, here[some])
                    log[some] = np.where(takes, there, log[some])
                if step >= BURNT:
                    kept.append(here.copy())
            law = rng.choice(np.concatenate(kept), KEPT, replace=False)
            rows = self.log(law)[1]
            found[:, self.own] = law
        noise = rng.standard_normal((KEPT, int((~self.own).sum())))
        found[:, ~self.own] += self.mean + rows @ self.by.T + noise @ self.spread.T
        found += MARCH_ERROR * rng.standard_normal((KEPT, 1)) * march
        shares = [i for i, name in enumerate(self.model.unknowns.names)
                  if self.own[i] and not name.startswith("time")]  # fmt: skip
        found[:, shares] = np.clip(found[:, shares], SAME, 1 - SAME)
        return found

"""A force curve over time with its free rows: what the device did, base lines, where contact begins and ends."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.errors import InputError
from ..base.numerics import FEWEST_ROWS, TINY, Array
from ..base.units import show
from ..measured.curve import Curve
from .timed_record import (
    MOTION_MOST,
    ROWS_APART,
    TimedRecord,
    check_over_time,
    check_rising,
    corners,
    noise_of,
    through,
)

BASE_FIRST = 0.02  # choice: of the rows, those of a base line at first; doubled while the loads stay on it
BASE_FEWEST = 10  # choice: of rows that make a base line
EVEN = 3e-4  # choice: of the way, what a device that moves evenly may be off
BINS = 120  # choice: places of a device that does not move in straight pieces
JUMP_SEEN = 7.0  # theory: of the noise, a step between two rows that it does not make
NEAR = 10  # choice: rows, within which a jump lies that is seen
JUMP_TIME = 4e-4  # choice: of the time in contact, what a march errs by in that of a jump
STRAIGHT = 0.2  # choice: of all loads, what two base lines, or one from end to end, may differ by
LATE = (0.0, 0.1, 0.2)  # choice: of the time in contact, how late it may show
# choice: of the time in contact, within which no derivative foretells how contact ends that does so without a jump, and
# the error of its end
PARTING, PARTING_TIME = 0.03, 2e-3
MEAN = 3  # choice: rows to either side, of whose loads means are taken


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
        knots = corners_of(t, z)
        straight = knots[0].size < MOTION_MOST
        if not straight:
            edges = np.unique(np.linspace(0, t.size, BINS + 1).astype(int))
            means = [np.add.reduceat(one, edges[:-1]) / np.diff(edges) for one in (t, z)]
            knots = (np.r_[t[0], means[0], t[-1]], np.r_[z[0], means[1], z[-1]])
        noise = noise_of(P)
        first, last = _base_line(t, P, noise), _base_line(-t[::-1], P[::-1], noise)
        if first and last:  # a straight piece that begins or ends in contact is no base line
            line = np.polyfit(z[:first] - z[0], P[:first], 1 if np.ptp(z[:first]) > 0.05 * np.ptp(z) else 0)
            off, much = P[-last:] - np.polyval(line, z[-last:] - z[0]), STRAIGHT * float(np.ptp(P))
            deep = z[-last:].min() > z[min(first, z.size - 1)]  # than where contact began
            if deep or max(abs(float(off[0])), abs(float(off[-1]))) > much:
                first, last = (0, last) if abs(float(P[first - 1] - P[0])) > much else (first, 0)
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

    @property
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
    def touches(self) -> list[float]:
        """Where the tip may be as contact begins, before it jumps [m]: where no jump is seen, contact shows late."""
        first = self.contact[0]
        if not first:
            return [float(self.tip[0])]
        late = np.array(LATE if math.isinf(self.jumps[0]) else (0.0,)) * self.lasting
        return np.unique(np.interp(self.t[first - 1] - late, self.t, self.z))[::-1].tolist()

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
    def jump_error(self) -> float:
        """Of the time of a jump, by the rows and by a march [s]."""
        return math.hypot(self.spacing / math.sqrt(12), JUMP_TIME * self.lasting)

    def near(self, rows: float) -> Array:
        """Mask of those within so many of a jump that is seen."""
        return np.any(np.abs(self.t[:, None] - np.array(self.jumps)) < rows * self.spacing, axis=1)

    @property
    def recovered(self) -> float:
        """When half of the pull-off force is gone for good, infinite where it is not [s]."""
        return recovers(self.t, self.load, self.pulled)

    @cached_property
    def parting(self) -> tuple[float, float]:
        """How long before and behind the recovery of the load it changes by more than its noise in what marches may err
        by in time [s]."""
        end = self.recovered
        if math.isinf(end):
            return 0.0, 0.0
        fast = np.abs(np.gradient(self.load, self.t)) * PARTING_TIME * self.lasting > self.noise / 2
        ways = np.flatnonzero(self.t <= end)[::-1], np.flatnonzero(self.t > end)
        before, behind = (int(np.argmin(np.append(fast[way], False))) for way in ways)
        near = PARTING * self.lasting
        late = float(self.t[min(self.contact[1], self.t.size - 1)]) - end  # a small contact is left, and jumps off
        return before * self.spacing + near, max(behind * self.spacing, late) + near

    @property
    def speed(self) -> float:
        """The largest at which the device moves back [m/s]."""
        return float(-np.min(np.diff(self.program[1]) / np.diff(self.program[0])))

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

    @property
    def load_is_prescribed(self) -> bool:
        """Whether the load moved in fewer straight pieces than the device, or alone in any."""
        pieces = self.program[0].size if self.straight else MOTION_MOST
        most = min(pieces + 1, MOTION_MOST)  # two corners in neighbouring rows are one
        return corners_of(self.t, self.P, most)[0].size < pieces

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


def recovers(t: Array, P: Array, pulled: float) -> float:
    """When half of the largest tension ``pulled`` of the loads ``P`` is gone for good, infinite where it is not [s]."""
    low = np.flatnonzero(P < -pulled / 2)
    i = int(low[-1]) if low.size else P.size - 1
    if i + 1 == P.size:
        return math.inf
    return float(t[i] + (-pulled / 2 - P[i]) / (P[i + 1] - P[i]) * (t[i + 1] - t[i]))


def corners_of(t: Array, z: Array, most: int = MOTION_MOST) -> tuple[Array, Array]:
    some = np.unique(np.linspace(0, t.size - 1, min(t.size, 1000)).astype(int))
    times, _ = corners(t[some], z[some], max(noise_of(z[some]), EVEN * float(np.ptp(z))), most)
    if times.size >= most:
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
    knots = corners_of(t, delta)
    off = delta - np.interp(t, *knots)
    steps = np.diff(np.stack([delta, P]), axis=1)
    steps = steps - np.median(steps, axis=1)[:, None]
    compliance = -float(steps[0] @ steps[1]) / max(float(steps[1] @ steps[1]), TINY)
    if compliance <= 0:
        return math.inf, delta
    for _ in range(2):
        times = corners_of(t, delta + compliance * P)[0]
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

"""The rows of a force curve as marches foretell them, P_read = P0 + tilt (z - z_0) + P(t; body, w, stress, law):
residuals of loads and of jumps over their noise, their derivatives by what is no law, and what is likely before."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion.finite_range import AttractedBody
from ..base.numerics import TINY, Array
from ..bodies.problem import Modes, PowerRelaxation
from ..measured.forward_model import FittedBody
from ..measured.least_squares import State
from ..measured.parameters import Unknowns
from .edge_speed import law_over, likely
from .lockstep_march import March, Marched, Trial
from .timed_record import RelaxationSettings, relaxation_at
from .whole_record import Cycle, recovers

LINE, ZONE = ("P0", "tilt"), ("stress", "range")
APART = 1.5  # theory: rows from a jump, within which no row shows when it was
# choice: of the time in contact, within which loads fall to a jump as no derivative foretells, and no march
STEEP = (0.015, 0.004)
CONVERGED = 0.5  # theory: of the sum of squares of rows by their noise: less than a standard error
FINEST = 0.25, 0.5  # choice: of these zones, those that are extrapolated with them by squares of widths, or else
SHORTER = 1 / 6  # choice: of the tolerance there: a power law relaxes at once behind each corner
LATER_ERROR = 0.2  # choice: of what they add to the end of contact, what that may err by
ALIKE = 0.05  # choice: of the time in contact, by which its end may differ in them
ROUGH_STEPS = 400  # choice: of a march, twice those of usual records, where it is to be excluded that the law fits
POWER_STEP = 1.1  # theory: of log rates of a power law's exponentials, which then err by 1e-4
POWER_SLOWEST, POWER_LEAST = 0.02, 1e-6  # theory: rates times time that one stands for; weights that do not count
STEP = 0.01  # choice: of logs of the modulus and w, for differences; of others what changes loads alike
STEPS = {"time": 0.05, "onset": 0.3, "stress": 0.1, "delta0": 0.003, "ratio": 0.01, "weight": 0.01, "exponent": 0.01,
         "v0": 0.05, "n": 0.03, "b": 0.03}  # fmt: skip
LOAD_ERROR = 1e-3  # choice: of loads and pull-off force; twice what fine marches differ from those of other equations
# What is likely before: half-widths of normal distributions.
LIKELY_RANGE, RANGES = 4.5e-10, 3.0  # theory: w/stress of dry contact, 0.2 to 1 nm; log: 20 times it is no rarity
LIKELY = {"ratio": (0.5, 0.5), "weight": (0.4, 0.4), "exponent": (0.3, 0.4)}  # choice: hardly anything
LIKELY_TIMES = {"time": (0.25, 4.0), "onset": (0.01, 4.0)}  # choice: over the time in contact, and of logs


@dataclass(frozen=True, eq=False)
class Adhering:
    """The residuals of a ``cycle`` as a function of ``unknowns``, with marches of ``width`` and ``tolerance``;
    ``sigma``: standard deviations of the loads, ``left_out``: rows near jumps, ``jumps``: times of the begin and end of
    contact and their standard deviations (2, 2), infinite where there are none; ``correction``: what narrower zones add
    to the loads [N]; ``steep``: of the time in contact, how near to jumps rows do not count; ``parting``: how long
    before and behind its end loads change too fast for their times [s]; ``erring``: whether what marches may err by are
    unknowns too; ``settled``: whether the rows that do not count are those ``left_out``, whatever the march, and
    derivatives are by steps to both sides."""

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
    parting: tuple[float, float] = (0.0, 0.0)
    erring: bool = False
    settled: bool = False

    def trial(self, theta: Array) -> Trial:
        """The specimen of the unknowns ``theta``."""
        values = self.unknowns.values(theta)
        m, w = self.instant(theta), values["w"]
        stress = values["stress"] if "stress" in values else w / values["range"]
        # the law with r(0) = 1; a power law by few exponentials
        law, lasting = self.settings.relaxation(values), float(np.ptp(self.cycle.t))
        modes = law.modes(lasting, POWER_STEP) if isinstance(law, PowerRelaxation) else law.modes(lasting)
        if isinstance(law, PowerRelaxation):
            slow, kept = modes.rates * lasting < POWER_SLOWEST, modes.weights > POWER_LEAST * modes.weights.sum()
            weight = modes.weights[slow].sum()
            weights = np.append(weight, modes.weights[kept & ~slow])
            rates = np.append(modes.weights[slow] @ modes.rates[slow] / weight, modes.rates[kept & ~slow])
            modes = Modes(0.0, weights / weights.sum(), rates)
        rate = law_over(self.settings.rate, values, m) if self.settings.rate else None
        return Trial(w / m, stress / m, self.cycle.stiffness / m, modes, values["delta0"], rate)

    def march(self, trials: Sequence[Trial], leaders: Sequence[int] | None = None) -> list[Marched]:
        """Marches of many trials, each with the steps of that of its ``leaders``."""
        steps = None if self.settings.most is None else ROUGH_STEPS
        how = self.cycle.program, self.width, self.tolerance, steps, leaders
        found = March(self.body.problem, self.attracted, trials, *how).run()
        if self.settings.rate:  # contact ends without a jump
            ends = [recovers(one.rows[:, 0], one.rows[:, 4], -float(one.rows[:, 4].min())) for one in found]
            return [replace(one, lost=end) for one, end in zip(found, ends, strict=True)]
        return found

    def instant(self, theta: Array) -> float:
        """The modulus at t = 0, in those of the body."""
        values = self.unknowns.values(theta)
        law = {name: values[name] for name in self.settings.of_law}
        return float(values["modulus"] * relaxation_at(np.zeros(1), self.settings.law, law)[0])

    def loads(self, theta: Array, marched: Marched) -> Array:
        """The loads that are read [N]."""
        values, cycle = self.unknowns.values(theta), self.cycle
        line = values["P0"] + values["tilt"] * (cycle.z - cycle.z[0])
        return line + self.instant(theta) * marched.load(cycle.t) + self.correction

    def corrected(self, theta: Array, here: Marched) -> Adhering:
        """The same with what zones of no width, and shorter steps, change from the march ``here`` with ``theta``, by a
        narrow one that can be followed, in loads and in the end of contact."""
        t, tolerance = self.cycle.t, self.tolerance * (SHORTER if self.settings.law == "power" else 1.0)
        for share in FINEST:
            (narrow,) = replace(self, width=share * self.width, tolerance=tolerance).march([self.trial(theta)])
            later = narrow.lost - here.lost if min(narrow.lost, here.lost) < math.inf else 0.0
            if not narrow.given_up and abs(later) < ALIKE * self.cycle.lasting:
                break
        else:
            return self
        change = self.instant(theta) * (narrow.load(t) - here.load(t)) / (1 - share**2)
        change = np.where(self.apart(here, (narrow.begun, narrow.lost)), 0.0, change)
        jumps, later = self.jumps.copy(), later / (1 - share**2)
        if math.isfinite(jumps[1, 1]):
            known = jumps[1, 1] if self.settings.rate else self.cycle.jump_error
            jumps[1] = jumps[1, 0] - later, math.hypot(known, LATER_ERROR * later)
        return replace(self, correction=change, jumps=jumps)

    def apart(self, one: Marched, other: tuple[float, float], parting: tuple[float, float] = (0.0, 0.0)) -> Array:
        """Mask of rows between jumps of a march and ``other`` ones, and ``parting`` before and behind the last [s]."""
        t, mask = self.cycle.t, np.zeros(self.cycle.t.size, dtype=bool)
        for mine, theirs, near in zip((one.begun, one.lost), other, ((0.0, 0.0), parting), strict=True):
            low, high = min(mine, theirs) - near[0], max(mine, theirs) + near[1]
            if math.isfinite(low):
                mask |= (t >= low) & (t <= high)
        return mask

    def off(self, theta: Array, here: Marched) -> Array:
        """Residuals of rows and jumps from the march at ``theta``."""
        seen = np.isfinite(self.jumps[:, 1])
        off = np.where(self.out(here), 0.0, (self.loads(theta, here) - self.cycle.P) / self.sigma)
        return np.append(off, ((self.times(here) - self.jumps[:, 0]) / self.jumps[:, 1])[seen])

    def costs(self, tried: Sequence[Array]) -> list[float]:
        """Half the sums of squares of all residuals at many places, by one march."""
        found = []
        for theta, one in zip(tried, self.march([self.trial(theta) for theta in tried]), strict=True):
            off = np.append(self.off(theta, one), self.prior(theta)[0])
            found.append(float(off @ off) / 2)
        return found

    def state(self, theta: Array, here: Marched, columns: Mapping[str, Array]) -> State:
        """Residuals from the march at ``theta``, with their derivatives by what moves the contact."""
        out, off = self.out(here), self.off(theta, here)
        line = {"P0": np.ones_like(self.cycle.z), "tilt": self.cycle.z - self.cycle.z[0]}
        J = np.zeros((off.size, theta.size))
        for i, name in enumerate(self.unknowns.names):
            if name in LINE:
                J[: out.size, i] = np.where(out, 0.0, line[name] * self.unknowns.scales[i] / self.sigma)
            else:
                J[:, i] = columns[name]
        if self.erring:  # (1 + B B^T)^(-1/2), the columns of B have no row in common
            B = np.where(out[:, None], 0.0, self.march_errors(here, theta))
            size = np.sum(B**2, axis=0)
            share = (1 - 1 / np.sqrt(1 + size)) / np.maximum(size, TINY)
            for one in (off, J):
                one[: out.size] -= (B * share) @ (B.T @ one[: out.size])
        prior, J_prior = self.prior(theta)
        return State(np.append(off, prior), lambda: np.concatenate([J, J_prior]))

    def times(self, one: Marched) -> Array:
        """When contact began and was lost [s], not beyond the record."""
        cycle, late = self.cycle, self.cycle.t[-1] + self.cycle.lasting / 4
        return np.minimum([one.begun, one.lost], [late, self.jumps[1, 0] if cycle.held else late])

    def out(self, one: Marched) -> Array:
        """Mask of rows that do not count: beside jumps, or between those of the record and of the march ``one``."""
        if self.settled:
            return self.left_out
        mine, t = np.array([one.begun, one.lost]), self.cycle.t
        theirs = np.where(np.isfinite(self.jumps[:, 1]), self.jumps[:, 0], mine)
        width = max(APART * self.cycle.spacing, self.steep * self.cycle.lasting)
        beside = np.any(np.abs(t[:, None] - mine) < width, axis=1)
        return self.left_out | self.apart(one, (float(theirs[0]), float(theirs[1])), self.parting) | beside

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
        steps = np.where(shares & (theta > 0.5), -steps, steps)
        inside = np.where(shares, np.minimum(theta, 1 - theta) / 2, np.inf)  # to both sides
        return np.clip(steps, -inside, inside) if self.settled else steps

    def prior(self, theta: Array) -> tuple[Array, Array]:
        """What is likely before, as residuals."""
        values, names, unit = self.unknowns.values(theta), self.unknowns.names, np.eye(theta.size)
        rows, by = list[float](), list[Array]()
        for i, name in enumerate(names):
            if before := likely_before(name, self.cycle.lasting) or likely(name, self.cycle.speed):
                rows.append((theta[i] - before[0]) / before[1])
                by.append(unit[i] / before[1])
        for name, sign in (("stress", -1), ("range", 1)):
            if name in names:
                length = values["range"] if name == "range" else values["w"] / values["stress"]
                rows.append(math.log(length / LIKELY_RANGE) / RANGES)
                w = unit[names.index("w")] if "w" in names and name == "stress" else 0.0
                by.append((sign * unit[names.index(name)] + w) / RANGES)
        return np.array(rows), np.array(by).reshape(-1, theta.size)

    def moved(self, theta: Array, names: Sequence[str]) -> list[Array]:
        """``theta`` with a step of each of some unknowns, to both sides where the rows are settled."""
        steps = np.diag(self.steps(theta))[[self.unknowns.names.index(name) for name in names]]
        return list(theta + (np.concatenate([steps, -steps]) if self.settled else steps))

    def rates(self, theta: Array, here: Marched, names: Sequence[str], there: Iterable[Marched]) -> dict[str, Array]:
        """Derivatives by unknowns from the marches of their steps."""
        steps = dict(zip(self.unknowns.names, self.steps(theta), strict=True))
        loads = self.loads(theta, here)
        changes = [self.change(here, loads, *one) for one in zip(self.moved(theta, names), there, strict=True)]
        if self.settled:
            changes = [(up - down) / 2 for up, down in zip(changes, changes[len(names) :], strict=False)]
        return {name: change / steps[name] for name, change in zip(names, changes, strict=True)}

    @staticmethod
    def many(asked: Sequence[tuple[Adhering, Array]]) -> list[State]:
        """The states of several searches of one cycle by one march."""
        model = asked[0][0]
        names = [name for name in model.unknowns.names if name not in LINE]
        sets = [[theta, *model.moved(theta, names)] for _, theta in asked]
        leaders = np.repeat(np.arange(len(sets)) * len(sets[0]), len(sets[0]))
        marches = iter(model.march([model.trial(theta) for some in sets for theta in some], leaders.tolist()))
        found = []
        for theta, *_ in sets:
            here, *there = itertools.islice(marches, len(sets[0]))
            found.append(model.state(theta, here, model.rates(theta, here, names, there)))
        return found

    def __call__(self, theta: Array) -> State:
        (state,) = self.many([(self, theta)])
        return state


def likely_before(name: str, lasting: float) -> tuple[float, float] | None:
    """What is likely of an unknown of a law before, mean and half-width of a normal distribution: of times of their
    logs; None of others. ``lasting``: time in contact [s]."""
    plain = name.rstrip("0123456789")
    if plain in LIKELY_TIMES:
        share, width = LIKELY_TIMES[plain]
        return math.log(share * lasting), width
    return LIKELY.get(plain)


def is_time(name: str) -> bool:
    return name.rstrip("0123456789") in LIKELY_TIMES

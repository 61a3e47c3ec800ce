"""One statistical model of a whole force curve: base line, contact point, modulus and work of adhesion together.

The reading at device position z is that of a contact on its path (``device_path``) over a straight base line; all
scatter is in the load:

    reading(z) = offset + tilt (z - z_touch) + P(z - z0; s, w, k)

P is 0 where a row is free. On approach the edge advances with its own w; from the turning point on it rests, then
recedes with the w of the retraction. Where the retraction is alone, the root of the w of its approach is a share
``turn`` of its own. Each direction has its own base line (drag, drift of the load), on request with a wave c cos + s
sin of 2 pi (z - at)/period (``interference``). On request positions err by a drift, hysteresis or creep, 0 at the
turning point (``positions``): of one direction alone these cannot be told from another modulus.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from ...base import ROWS, Array, SolveError, known
from ...data.measured.curve import APPROACH
from ...data.record import BaseLine, Direction, ForceCurve
from ..least_squares import Least, LeastSquares, State
from .coloured import Spectrum, Spread, in_time
from .coloured import spread as covariance
from .device_path import Changes, DeviceBranch, Rest, branch, on_grid, rest
from .family import Family
from .interference import Wave, parts
from .points import in_contact, third_differences
from .positions import creep, hysteresis
from .settings import Loss
from .statistics import TURNS, influence, robust_scale


@dataclass(frozen=True)
class ForceCurveTuning:
    """How starts are tried, and when a search ends."""

    window: float = 4.0  # choice: standard errors of z0 and w that the window about first touch covers
    beside: float = 2.0  # choice: rows on each side of first touch, at least, that belong to the window
    narrow: float = 0.3  # choice: of the depth of contact, that the window covers at most
    above: float = 1.1  # choice: of the w that the last row holds at rest, one with which it rests for sure
    recedes: float = 12.0  # theory: fall of chi^2 by one unknown that chance brings once in 2000
    # tuned on raw records, by `make constants`: of the rows of a base line, those that tell the noise: contact begins
    # gently
    surely: float = 0.9
    surely_found: float = 1.05  # choice: of the noise, residuals that the search is not begun anew for
    enough: float = 1.5  # choice: of the noise, residuals that no other start is tried below
    # choice: of a retraction alone, the share of its way in contact that tells a start, and ``turn`` to begin with:
    alone: tuple[tuple[float, float], ...] = ((0.5, 0.1), (0.5, 0.6), (1.0, 1.0))
    shapes: int = 25  # choice: ratios w/s tried
    points: int = 41  # choice: contact points tried
    # tuned on fits, by `make constants`: of the rows in contact, those next to the turning point that are left out
    turning: float = 0.01
    blunt: tuple[float, ...] = (1e-2, 1e-3, 1e-5)  # choice: of the depth of contact, for a blunt fold while searching
    moduli: float = 10.0  # choice: of ln s about its start, where the search may go
    periods: float = 0.3  # choice: the same of the log of a wave's period
    converged: float = 1e-11  # choice: relative change of parameters
    fell: float = 1e-8  # choice: of the cost, below which the minimum is found: a hundredth of a standard error
    about: float = 1e-6  # choice: the same while the fold is blunter than it will be, or no more can be had
    unsure: float = 0.1  # choice: of the way in contact, the most that the place of a fold is taken to be uncertain by
    widths: int = 5  # choice: of that error, each told by the one before
    narrower: float = 2.0  # choice: factor between two of them, below which they agree
    near: float = 0.1  # choice: of chi^2, the fall still to be had a third of a standard error from its minimum
    evaluations: int = 80  # choice: steps after which the search gives up
    remembered: int = 2  # choice: residuals of a model that are asked for again at the same unknowns


TUNING = ForceCurveTuning()


@dataclass(frozen=True, eq=False)
class DirectionReadings:
    """The ``rows`` of one direction, from the far end inwards: device position ``z`` [m], reading ``P`` [N].

    ``touching``: whether a row may be in contact; where ``jumped``, all those rows are, and the others are free, as a
    jump tells, or a window about first touch that is left out.
    ``line``: the base line that was found from the free rows alone, ``wave``: on top of it. ``t``: time since the end
    of the approach [s], 0 where it is not known, ``waits`` until the retraction, of ``lasting`` in all. ``turn``: where
    the device turns [m]; ``tension``: the largest that is told from the noise [N].
    """

    kind: str
    rows: Array
    line: BaseLine
    z: Array
    P: Array
    touching: Array
    jumped: bool
    t: Array
    turn: float
    tension: float
    wave: Wave | None = None
    waits: float = 0.0
    lasting: float = 0.0

    @cached_property
    def spacing(self) -> float:
        """Usual distance of neighbouring rows [m]; the mean where most of them repeat their position."""
        steps = np.abs(np.diff(self.z))
        return float(np.median(steps)) or float(np.mean(steps))

    @cached_property
    def travel(self) -> float:
        """How far the device moves in all [m]."""
        return self.turn - float(self.z.min())

    @property
    def way(self) -> Array:
        """The share of the travel between the turn and each row."""
        return (self.turn - self.z) / self.travel

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m], about."""
        touching = float(np.ptp(self.z[self.touching])) if self.jumped and self.touching.any() else 0.0
        return touching or 0.1 * float(np.ptp(self.z))

    def thinned(self) -> DirectionReadings:
        """Means of neighbouring rows, none across the border of contact."""
        size = self.z.size // ROWS
        if size < 2:
            return self
        first = np.union1d(np.arange(0, self.z.size, size), np.flatnonzero(np.diff(self.touching)) + 1)
        count = np.diff(np.append(first, self.z.size))
        z, P, t = (np.add.reduceat(column, first) / count for column in (self.z, self.P, self.t))
        return replace(self, rows=self.rows[first], touching=self.touching[first], z=z, P=P, t=t)


@dataclass(frozen=True, eq=False)
class ForceCurveModel:
    """The readings of some stretches on one body at a device of stiffness ``k`` [N/m], as a function of the unknowns.

    These are ln s, z0, the errors of ``positions``, the log of the period where there are waves, for each
    stretch its offset, tilt, cosine and sine of its wave, and q = w/s unless its w is one of ``works`` [J/m^2]; of an
    approach before a retraction that adheres its signed root instead, which the resting edge is smooth in; of a
    retraction alone the share ``turn``. ``known``: those that are not fitted, by name. ``moduli``: least and largest s.
    """

    family: Family
    k: float
    stretches: tuple[DirectionReadings, ...]
    known: Mapping[str, float] = field(default_factory=dict)
    works: Mapping[str, float] = field(default_factory=dict)
    moduli: tuple[float, float] = (0.0, math.inf)
    positions: tuple[str, ...] = ()

    @cached_property
    def rows(self) -> Array:
        """The rows of the record in all stretches."""
        return np.concatenate([part.rows for part in self.stretches])

    def ordered(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows as they were taken, where the order matters to the ``noise``."""
        return in_time(columns, self.rows, noise) if noise.slow else columns

    def whitened(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows so that a noise has unit variance and no colour."""
        return noise.whitened(self.ordered(columns, noise))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The unknowns in order; those of a stretch carry its kind."""
        names = (
            ["ln_s", "z0"]
            + list(self.positions)
            + ["ln_period"] * any(stretch.wave is not None for stretch in self.stretches)
        )
        for stretch in self.stretches:
            names += [f"offset:{stretch.kind}", f"tilt:{stretch.kind}"]
            names += [f"cos:{stretch.kind}", f"sin:{stretch.kind}"] * (stretch.wave is not None)
            names += [self.adhesion_of(stretch)] * (stretch.kind not in self.works)
            names += ["turn"] * (len(self.stretches) == 1 and stretch.kind != APPROACH and stretch.tension > 0)
        return tuple(name for name in names if name not in self.known)

    def adhesion_of(self, stretch: DirectionReadings) -> str:
        """The name of the unknown that w of a stretch comes from."""
        rests = stretch is not self.stretches[-1] and self.stretches[-1].tension > 0
        return f"r:{stretch.kind}" if rests else f"q:{stretch.kind}"

    @cached_property
    def most(self) -> float:
        """Largest q: of a curve that is pulled off at the end of the series."""
        _, (_, _, dH, dV), _ = on_grid(self.family)
        return 0.9 * float(dH[-1] / dV[-1]) ** 2

    @property
    def limits(self) -> Mapping[str, tuple[float, float]]:
        """Least and largest values of unknowns by name."""
        least, most = (math.log(s) if s > 0 else -math.inf for s in self.moduli)
        return {"ln_s": (least, most)}

    def further(self, values: Mapping[str, float]) -> dict[str, float]:
        """What other unknowns mean, SI, by name."""
        return {}

    def values(self, x: Array) -> dict[str, float]:
        """All unknowns by name, the known ones too, and q of each stretch."""
        found = {**self.known, **dict(zip(self.names, map(float, x), strict=True))}
        found |= {f"q:{kind}": w / math.exp(found["ln_s"]) for kind, w in self.works.items()}
        roots = {name: r for name, r in found.items() if name.startswith("r:")}
        return found | {f"q{name[1:]}": r * abs(r) for name, r in roots.items()}

    def depth(self, part: DirectionReadings, values: Mapping[str, float]) -> Array:
        """Position of the device beyond its zero [m], at all rows of a stretch."""
        depth: Array = part.z - values["z0"]
        for name, by in self.misplaced(part).items():
            depth += values[name] * by
        return depth

    def misplaced(self, part: DirectionReadings) -> dict[str, Array]:
        """How much deeper the rows of a stretch stand than they say, per amount of each error of positions [m]."""
        back = part.travel * (part.kind != APPROACH)
        found = {}
        for name in self.positions:
            if name == "drift":
                found[name] = -part.t
            elif name == "hysteresis":
                found[name] = back * hysteresis(part.way)
            else:
                found[name] = back * creep(np.maximum(part.t, 0.0) / part.lasting)
        return found

    def deepened(self, part: DirectionReadings, values: Mapping[str, float]) -> float:
        """How much deeper the device creeps while it waits before the way back, per amount [m]."""
        crept = part.waits > 0 and values.get("creep", 0.0) > 0
        return part.travel * float(creep(np.array(part.waits / part.lasting))) if crept else 0.0

    def branch(self, part: DirectionReadings, values: Mapping[str, float]) -> DeviceBranch:
        """The branch on which the edge of a stretch moves."""
        return branch(self.family, math.exp(values["ln_s"]), values[f"q:{part.kind}"], self.k)

    def rest(self, part: DirectionReadings, values: Mapping[str, float]) -> Rest | None:
        """The resting edge with which a stretch begins at the turning point."""
        root = math.sqrt(max(values[f"q:{part.kind}"], 0.0))
        first = self.stretches[0]
        if first is not part:
            before = values.get(f"r:{first.kind}", math.sqrt(max(values[f"q:{first.kind}"], 0.0)))
        elif "turn" in values:
            before = values["turn"] * root
        else:
            return None
        depth = part.turn - values["z0"] + values.get("creep", 0.0) * self.deepened(part, values)
        return rest(self.family, math.exp(values["ln_s"]), before, root, self.k, depth) if before < root else None

    def touching(self, part: DirectionReadings, values: Mapping[str, float], fold: float) -> Array:
        """Which rows of a stretch are in contact: those that are told to be, else those beyond first touch, or on the
        branch down to its ``fold`` [m]."""
        return part.touching if part.jumped else self.depth(part, values) > (0.0 if part.kind == APPROACH else fold)

    def contact_radii(self, part: DirectionReadings, values: Mapping[str, float]) -> tuple[Array, Array]:
        """Contact radius [m] at all rows of a stretch, 0 where they are free, and which of them are at rest."""
        moving, resting, z = self.branch(part, values), self.rest(part, values), self.depth(part, values)
        touching = self.touching(part, values, moving.fold)
        still = np.zeros_like(touching) if resting is None else touching & (z > resting.end)
        a = np.where(still, math.exp(resting.u), moving.radii(z)) if resting is not None else moving.radii(z)
        return np.where(touching, a, 0.0), still

    def calibrated(self, factor: float, of_stiffness: bool) -> ForceCurveModel:
        """The same of a device whose loads are ``factor`` times as large: by its stiffness, at the same deflections, or
        by its sensitivity, which its deflections follow."""
        parts = tuple(replace(part, P=factor * part.P, tension=factor * part.tension) for part in self.stretches)
        return replace(self, stretches=parts, k=factor * self.k if of_stiffness else self.k)

    def moved(self, found: ForceCurveFit, factor: float) -> Array:
        """The unknowns of a fit as they are about where all loads are ``factor`` times as large."""
        loads = np.array([name.startswith(("offset:", "tilt:", "cos:", "sin:")) for name in found.names], dtype=bool)
        ln_s = np.array([name == "ln_s" for name in found.names])
        return np.where(loads, factor * found.x, found.x) + np.where(ln_s, math.log(factor), 0.0)

    def free(self, columns: Array) -> list[Array]:
        """Of columns of all rows, those of each stretch that surely are free, whatever the model says."""
        ends = np.cumsum([part.rows.size for part in self.stretches])[:-1]
        parts = zip(self.stretches, np.split(columns, ends), strict=True)
        return [column[: round(TUNING.surely * part.line.rows)] for part, column in parts]

    @cached_property
    def _residuals(self) -> dict[tuple[bytes, float], tuple[Array, Array]]:
        return {}

    def residuals(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """Model minus reading [N] of all rows, and its derivatives by the unknowns, (rows, unknowns), both remembered.

        ``blunt``: share of the depth of contact over which the fold is blunt; 0: half the distance of two rows.
        """
        held, key = self._residuals, (x.tobytes(), blunt)
        if key not in held:
            if len(held) >= TUNING.remembered:
                del held[next(iter(held))]
            held[key] = self.evaluated(x, blunt)
        return held[key]

    def evaluated(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """The same anew."""
        values, names = self.values(x), {name: i for i, name in enumerate(self.names)}
        ends = np.cumsum([0] + [part.P.size for part in self.stretches])
        off, rates = np.empty(ends[-1]), np.zeros((x.size, ends[-1]))
        for part, first, last in zip(self.stretches, ends[:-1], ends[1:], strict=True):
            load, by = self._contact(part, values, blunt)
            line, by_line = base_line(part, values)
            off[first:last] = line + load - part.P
            for name, column in {**by, **by_line}.items():
                if name in names:
                    rates[names[name], first:last] = column
        return off, rates.T

    def off(self, x: Array, blunt: float) -> Array:
        """Model minus reading [N] of all rows."""
        values = self.values(x)
        parts = (base_line(part, values)[0] + self._load(part, values, blunt) - part.P for part in self.stretches)
        return np.concatenate([*parts])

    def by_position(self, x: Array) -> Array:
        """Derivative of the loads of all rows by their positions [N/m], the turn and the base lines where they are."""
        values = self.values(x)
        return np.concatenate([self._contact(part, values, 0.0)[1]["z"] for part in self.stretches])

    def _load(self, part: DirectionReadings, values: Mapping[str, float], blunt: float) -> Array:
        """Load of the contact at all rows of a stretch."""
        moving, resting, depth, rows, still = self._edges(part, values)
        P = np.zeros(depth.size)
        P[rows] = moving.load(depth[rows], blunt * part.reach if blunt else part.spacing / 2)
        if resting is not None:
            P[still] = resting.load(depth[still])
        return P

    def _edges(
        self, part: DirectionReadings, values: Mapping[str, float]
    ) -> tuple[DeviceBranch, Rest | None, Array, Array, Array]:
        """The branch and the resting edge of a stretch, the depth [m] of all rows, and the numbers of those at which
        the edge moves, and of those at which it rests."""
        moving, resting, depth = self.branch(part, values), self.rest(part, values), self.depth(part, values)
        rows = np.flatnonzero(self.touching(part, values, moving.fold))
        if resting is None:
            return moving, None, depth, rows, rows[:0]
        rests = depth[rows] > resting.end
        return moving, resting, depth, rows[~rests], rows[rests]

    def _contact(
        self, part: DirectionReadings, values: Mapping[str, float], blunt: float
    ) -> tuple[Array, dict[str, Array]]:
        """Load of the contact at all rows of a stretch, and its derivatives by name."""
        moving, resting, depth, rows, still = self._edges(part, values)
        own, q = f"q:{part.kind}", values[f"q:{part.kind}"]
        P, by = np.zeros(depth.size), np.zeros((3, depth.size))  # by ln s, own q, z
        P[rows], by[:, rows] = moving.at(depth[rows], blunt * part.reach if blunt else part.spacing / 2)
        by_s, by_q, by_z = by
        more: dict[str, Array] = {}
        if resting is not None:
            by_before, by_turn = np.zeros((2, depth.size))  # the root of q before, the turn
            P[still], (by_s[still], by_before[still], by_z[still], by_turn[still]) = resting.at(depth[still])
            root = math.sqrt(max(q, 1e-300))
            by_q += by_before * (values.get("turn", 0.0) / (2 * root))
            more = {"turn": by_before * root, **_by_advance(self.stretches[0], part, values, by_before)}
        elif part is self.stretches[0] and (name := f"r:{part.kind}") in values:
            more = {name: 2 * abs(values[name]) * by_q}
        by_z0 = -by_z if resting is None else -by_z - by_turn
        for name, misplaced in self.misplaced(part).items():
            more[name] = by_z * misplaced
            if name == "creep" and resting is not None:
                more[name] += by_turn * self.deepened(part, values)
        return P, {
            "ln_s": by_s - q * by_q if part.kind in self.works else by_s,
            "z": by_z,
            "z0": by_z0,
            own: by_q,
        } | more

    def by_body(self, x: Array, changes: Sequence[Changes | None]) -> Array:
        """Derivative of the loads of all rows by an amount of ``changes`` of the body, those of each stretch."""
        values, columns = self.values(x), []
        for part, change in zip(self.stretches, changes, strict=True):
            columns.append(column := np.zeros(part.z.size))
            if change is None:
                continue
            moving, resting, depth = self.branch(part, values), self.rest(part, values), self.depth(part, values)
            moves = self.touching(part, values, moving.fold)
            if resting is not None:
                still = moves & (depth > resting.end)
                column[still], moves = resting.by_body(depth[still], change), moves & ~still
            column[moves] = moving.by_body(depth[moves], part.spacing / 2, change)
        return np.concatenate(columns)


def _by_advance(
    first: DirectionReadings, part: DirectionReadings, values: Mapping[str, float], by_before: Array
) -> dict[str, Array]:
    """Derivatives of the load of a stretch at rest by q of the ``first`` one or its root, with which it came to the
    turn."""
    q = values[f"q:{first.kind}"]
    if part is first:
        return {}
    if f"r:{first.kind}" in values:
        return {f"r:{first.kind}": by_before}
    return {f"q:{first.kind}": by_before / (2 * math.sqrt(q))} if q > 0 else {}


def base_line(part: DirectionReadings, values: Mapping[str, float]) -> tuple[Array, dict[str, Array]]:
    """Load of the base line of a stretch at all its rows, and its derivatives by name."""
    along = part.z - part.z[0]
    line = values[f"offset:{part.kind}"] + values[f"tilt:{part.kind}"] * along
    by = {f"offset:{part.kind}": np.ones_like(along), f"tilt:{part.kind}": along}
    if part.wave is None:
        return line, by
    way, period = part.z - part.wave.at, math.exp(values["ln_period"])
    c, s = values[f"cos:{part.kind}"], values[f"sin:{part.kind}"]
    cos, sin = parts(way, period).T
    waves = {"ln_period": 2 * math.pi * way / period * (c * sin - s * cos), f"cos:{part.kind}": cos,
             f"sin:{part.kind}": sin}  # fmt: skip
    return line + c * cos + s * sin, by | waves


@dataclass(frozen=True, eq=False)
class ForceCurveFit:
    """The model that fits best: ``values`` and standard errors by name; ``off`` residuals [N] of all rows.

    ``sigma``: standard deviation of a reading about the model [N]; ``weight``: the noise that rows were weighted by;
    ``spread``: covariance of the unknowns, and the noise that it rests on. ``least``: as the search sees it, in units
    of ``weight``. ``ended``: whether it is a minimum, and not where the search was given up.
    """

    model: ForceCurveModel
    names: tuple[str, ...]
    x: Array
    weight: Spectrum
    spread: Spread
    off: Array
    sigma: float
    least: Least
    ended: bool

    @property
    def covariance(self) -> Array:
        return self.spread.covariance

    def value(self, name: str) -> float:
        return float(self.x[self.names.index(name)])

    def error(self, name: str) -> float:
        i = self.names.index(name)
        return math.sqrt(self.covariance[i, i])

    def unknowns(self, model: ForceCurveModel) -> Array:
        """Those of a ``model`` that may know fewer of them."""
        values = self.model.values(self.x)
        return np.array([values[name] for name in model.names])


def stretches(
    record: ForceCurve, kinds: Sequence[str], waves: Mapping[str, Wave] | None = None
) -> tuple[DirectionReadings, ...]:
    """The directions ``kinds`` of a record as the model takes them: rows within a jump belong to neither side and are
    left out. ``waves``: what was taken off the loads of the record and is to be fitted with the rest."""
    sides = [side for kind in kinds if (side := record.direction(kind)) is not None]
    return tuple(_stretch(record, side, (waves or {}).get(side.segment.kind)) for side in sides)


def _stretch(record: ForceCurve, side: Direction, wave: Wave | None) -> DirectionReadings:
    curve, rows = record.curve, np.arange(side.segment.first, side.segment.last + 1)
    if side.segment.kind != APPROACH:
        rows = rows[::-1]
    z = curve.device[rows]
    P = curve.load[rows] if wave is None else curve.load[rows] + wave(z)
    line, tension, touching, keep = _told(side, z, P)
    contact = np.count_nonzero(touching) or rows.size - side.border[1]
    keep[rows.size - round(TUNING.turning * contact) :] = False
    keep &= ~np.isin(rows, record.spikes)
    into = record.direction(APPROACH)
    last = int(np.argmax(curve.device)) if into is None else into.segment.last
    t = np.zeros(len(curve)) if curve.t is None else curve.t - curve.t[last]
    return DirectionReadings(
        side.segment.kind, rows[keep], line, z[keep], P[keep], touching[keep], bool(touching.any()), t[rows[keep]],
        float(curve.device.max()), tension, wave, max(float(t[rows[-1]]), 0.0), float(np.ptp(t)),
    )  # fmt: skip


def _told(side: Direction, z: Array, P: Array) -> tuple[BaseLine, float, Array, Array]:
    """Base line of a direction, its largest tension [N], which rows are in contact, and which are to be kept; no row
    where first touch is not told by a jump. Without a base line the load is that over 0."""
    tension, touching, keep = known(side.adhesion) or 0.0, np.zeros(z.size, dtype=bool), np.ones(z.size, dtype=bool)
    if not side.begins_free:
        touching = in_contact({"delta": z, "P": P}, 0.0)
        line = BaseLine(0.0, 0.0, float(z[0]), 0, third_differences(P), 0.0, False)
        tension = max(-float(P.min()), 0.0)
        return line, tension if tension > line.least else 0.0, touching, touching.copy()
    if side.jumps or (side.segment.kind != APPROACH and tension):
        first, last = side.border
        touching[last:], keep[first + 1 : last] = True, False
    return side.base, tension, touching, keep


def _even(model: ForceCurveModel) -> Spectrum:
    """White noise as large as the range of the loads: the weight while nothing is known of it."""
    return Spectrum(max(float(np.ptp(part.P)) for part in model.stretches) ** 2)


def _state(model: ForceCurveModel, weight: Spectrum, blunt: float, x: Array) -> State:
    """The residuals, weighted by noise."""
    return _weighted(model, weight, *model.residuals(x, blunt))


def _weighted(model: ForceCurveModel, weight: Spectrum, off: Array, rates: Array) -> State:
    return State(model.whitened(off, weight), partial(model.whitened, rates, weight))


def _problem(
    model: ForceCurveModel, weight: Spectrum, bounds: tuple[Array, Array], blunt: float, enough: float
) -> LeastSquares:
    return LeastSquares(partial(_state, model, weight, blunt), bounds, enough, TUNING.fell, TUNING.evaluations)


def misfit_at(model: ForceCurveModel, x: Array) -> float:
    """Half the sum of squares at the unknowns ``x``, of loads over their range."""
    off = _state(model, _even(model), TUNING.blunt[-1], np.clip(x, *_bounds(model, x))).residuals
    return float(off @ off) / 2


def rough(model: ForceCurveModel, start: Array, steps: int) -> tuple[float, Array]:
    """Half the sum of squares that is left, of loads over their range, and the unknowns that leave about least, by a
    search from ``start`` on of a few ``steps``."""
    problem = _problem(model, _even(model), _bounds(model, start), TUNING.blunt[1], TUNING.about)
    found = replace(problem, evaluations=steps).least(start)
    return found.cost, found.x


def fit(model: ForceCurveModel, start: Array, near: bool = False, loss: Loss = "linear") -> ForceCurveFit:
    """The unknowns that leave least, first of a few rows and with a blunt fold unless ``start`` is ``near``, then of
    all as they are; then weighted by the noise of the free rows where that has a colour. Where the rows do not
    determine them the search creeps along a valley: it is given up, and that is told."""
    bounds, even = _bounds(model, start), _even(model)
    x, sharp = np.clip(start, *bounds), TUNING.blunt[-1]
    few = model
    if "turn" not in model.names:  # of a retraction alone other minima are near
        few = replace(model, stretches=tuple(part.thinned() for part in model.stretches))
    whole, level = _problem(model, even, bounds, sharp, TUNING.converged), max(p.line.noise for p in model.stretches)
    slow = TUNING.blunt[: -1 if few is model else None]
    for stages in [()] if near else [slow] if few is model else [TUNING.blunt[1:2], slow]:
        begun = x
        for blunt in stages:
            begun = _problem(few, _even(few), bounds, blunt, TUNING.about).least(begun).x
        found = whole.least(begun)
        if found.ended and 2 * found.cost * even.A < (TUNING.surely_found * level) ** 2 * found.state.residuals.size:
            break  # no other minimum leaves less than the noise
    about = _problem(model, even, bounds, sharp, TUNING.about)
    if not found.ended:  # of few rows at the fold each makes a kink, between which a search runs to and fro
        found = about.least(found.x)
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * robust_scale(found.state.residuals)
        found = replace(about, loss=loss, width=width).least(found.x)
    best = _fitted(model, found, even)
    noise = best.spread.noise
    if loss != "linear" or not noise.slow:
        return best
    x = best.unknowns(model)  # an edge that rests by white noise need not by this one
    for blunt in (sharp, TUNING.blunt[1]):  # where misfit runs to and fro between the kinks of a sharp fold
        found = _problem(model, noise, _bounds(model, x), blunt, TUNING.about).least(x)
        if found.ended:
            break
    return _fitted(model, found, noise)


def _fitted(model: ForceCurveModel, found: Least, weight: Spectrum) -> ForceCurveFit:
    """What the end of a search means."""
    before, sharp, (model, x) = found.problem, TUNING.blunt[-1], _without_idle(model, found.x, weight)
    problem = replace(before, model=partial(_state, model, weight, sharp), bounds=_bounds(model, x))
    off, rates = model.residuals(x, sharp)
    found = replace(found, problem=problem, x=x, state=_weighted(model, weight, off, rates))
    size = before.width * math.sqrt(_even(model).A)
    psi, slope = influence(off / size, before.loss)
    pull = psi * size / max(float(np.mean(slope)), 0.1)  # what a row pulls with (Huber 1981, Sec. 7.6)
    dof = max(off.size - x.size, 1)
    J, spread = _told_at_folds(model, x, off, pull, weight)
    ended = found.ended or _flat(model.whitened(pull, weight), model.whitened(J, weight), TUNING.near / dof)
    return ForceCurveFit(model, model.names, x, weight, spread, off, math.sqrt(float(pull @ pull) / dof), found, ended)


def _told_at_folds(model: ForceCurveModel, x: Array, off: Array, pull: Array, weight: Spectrum) -> tuple[Array, Spread]:
    """Derivatives of all rows, (rows, unknowns), and the covariance by them, residuals ``off`` and what rows ``pull``
    with [N].

    From a fold on loads rise with the root of the distance: their slope there holds no nearer to it than its place is
    known to, nor than half of the way between two rows. White noise leaves it known to about that.
    """
    residuals, free = model.ordered(pull, weight), model.free(off)

    def told(J: Array) -> Spread:
        return covariance(residuals, model.ordered(J, weight), free, weight)

    J = model.residuals(x, 0.0)[1]
    spread, first = told(J), 0
    for part in model.stretches if weight.slow and "z0" in model.names else ():
        rows = slice(first, first := first + part.z.size)
        lost, width = rows.start + int(np.argmax(part.touching)), TUNING.unsure * part.reach
        if not part.jumped or _place_error(model, J[lost], spread) <= part.spacing:
            continue
        J = J.copy()
        for _ in range(TUNING.widths):
            J[rows] = model.evaluated(x, width / part.reach)[1][rows]
            spread = told(J)
            error = max(_place_error(model, J[lost], spread), part.spacing / 2)
            if TUNING.narrower * error > width:
                break
            width = error
    return J, spread


def _place_error(model: ForceCurveModel, slopes: Array, spread: Spread) -> float:
    """The standard error [m] of the place of a fold, where loads change by ``slopes`` with the unknowns."""
    rise = abs(float(slopes[model.names.index("z0")]))
    return math.sqrt(max(float(slopes @ spread.covariance @ slopes), 0.0)) / rise if rise else 0.0


def _flat(off: Array, J: Array, share: float) -> bool:
    """Whether a step of Gauss and Newton would lower chi^2 by less than a ``share`` of it."""
    step = J @ np.linalg.lstsq(J, off, rcond=None)[0]
    return float(step @ step) < share * float(off @ off)


def _without_idle(model: ForceCurveModel, x: Array, weight: Spectrum) -> tuple[ForceCurveModel, Array]:
    """The model and its unknowns without those that no row depends on, which are known then: the share of an edge that
    never rests, w of an edge that rests throughout, which is at least what its last row holds."""
    idle = ~model.residuals(x, 0.0)[1].any(axis=0)
    idle |= (np.array(model.names) == "turn") & (np.abs(x) == 1)
    values, last = dict(zip(model.names, map(float, x), strict=True)), model.stretches[-1]
    own = f"q:{last.kind}"
    told = own in values and last.touching.any() and (last.tension > 0 or not last.line.rows)
    if told and (resting := model.rest(last, model.values(x))):
        depth = model.depth(last, model.values(x))[last.touching]
        most = resting.released(math.sqrt(max(values[own], 0.0)), float(depth.min())) ** 2  # its last row holds that
        if _rests_throughout(model, x, own, most, weight):
            idle |= np.array(model.names) == own
            values[own] = most
    known = {name: values[name] for name, no in zip(model.names, idle, strict=True) if no}
    return (replace(model, known={**model.known, **known}), x[~idle]) if known else (model, x)


def _rests_throughout(model: ForceCurveModel, x: Array, own: str, most: float, weight: Spectrum) -> bool:
    """Whether an edge that never recedes, as of a w above ``most``, describes the rows as well, in units of noise."""
    never = np.where(np.array(model.names) == own, min(TUNING.above * most, model.most), x)
    with contextlib.suppress(SolveError):  # no contact bears that
        recedes, rests = (float(np.sum(model.whitened(model.residuals(at, 0.0)[0], weight) ** 2)) for at in (x, never))
        return (rests / recedes - 1) * sum(part.P.size for part in model.stretches) < TUNING.recedes
    return False


def windowed(found: ForceCurveFit) -> ForceCurveModel:
    """The model without the rows about first touch where nothing else tells which of them are in contact: the load is
    not smooth there in z0 and w. The same model where there are none."""
    parts = tuple(part if part.jumped else _windowed(found, part) for part in found.model.stretches)
    return found.model if parts == found.model.stretches else replace(found.model, stretches=parts)


def _windowed(found: ForceCurveFit, part: DirectionReadings) -> DirectionReadings:
    """A stretch whose rows are free up to the window and in contact beyond."""
    values = found.model.values(found.x)
    depth, own = found.model.depth(part, values), f"q:{part.kind}"
    error = found.error(own) if own in found.names else 0.0
    most = values | {own: max(values[own], 0.0) + TUNING.window * error}
    neck = 0.0 if part.kind == APPROACH else -found.model.branch(part, most).fold
    unsure = found.error("z0") if "z0" in found.names else 0.0
    half = neck + max(TUNING.window * unsure, TUNING.beside * part.spacing)
    half = min(half, TUNING.narrow * float(depth.max()))
    if half <= 0:
        return part  # no row of it is in contact
    keep = np.abs(depth) > half
    cut = {name: getattr(part, name)[keep] for name in ("rows", "z", "P", "t")}
    return replace(part, touching=(depth > 0)[keep], jumped=True, **cut)


@dataclass(frozen=True, eq=False)
class OneMore:
    """One step of Gauss and Newton from a fit with one more unknown, whose derivatives are the last column of ``J``;
    ``step``: of all unknowns; ``size``: of the last one's, in standard errors of white noise."""

    found: ForceCurveFit
    J: Array
    step: Array
    size: float

    @classmethod
    def of(cls, found: ForceCurveFit, column: Array) -> OneMore:
        off, J = found.model.residuals(found.x, 0.0)
        J, noise = np.column_stack([J, column]), found.spread.noise
        scale = np.maximum(np.linalg.norm(J, axis=0), np.finfo(float).tiny)
        Q, triangle = np.linalg.qr(found.model.whitened(J / scale, noise))
        along = Q.T @ found.model.whitened(off, noise)
        return cls(found, J, -np.linalg.lstsq(triangle, along, rcond=None)[0] / scale, abs(float(along[-1])))

    @property
    def last(self) -> float:
        """The step of the one more."""
        return float(self.step[-1])

    @cached_property
    def error(self) -> float:
        """Its standard error."""
        model, weight = self.found.model, self.found.weight
        off = model.ordered(model.residuals(self.found.x, 0.0)[0] + self.J @ self.step, weight)
        spread = covariance(off, model.ordered(self.J, weight), (), weight)
        return math.sqrt(max(spread.covariance[-1, -1], 0.0))


def unasked_drift(found: ForceCurveFit) -> OneMore:
    """A drift of z0 [m/s] that was not fitted: one step of a search that knows it."""
    model = replace(found.model, positions=(*found.model.positions, "drift"))
    values = found.model.values(found.x) | {"drift": 0.0}
    J = model.evaluated(np.array([values[name] for name in model.names]), 0.0)[1]
    return OneMore.of(found, J[:, model.names.index("drift")])


def another_modulus(found: ForceCurveFit) -> OneMore:
    """Change of ln s on the way back against the way in that the data ask for: one step of a search with a modulus for
    each direction."""
    off, J = found.model.residuals(found.x, 0.0)
    back = np.arange(off.size) >= found.model.stretches[0].P.size
    return OneMore.of(found, J[:, found.names.index("ln_s")] * back)


def _bounds(model: ForceCurveModel, start: Array) -> tuple[Array, Array]:
    """Least and largest unknowns of a search from ``start`` on."""
    names = np.array(model.names, dtype=str)
    reach = np.select([names == "ln_s", names == "ln_period"], [TUNING.moduli, TUNING.periods], np.inf)
    lowest, highest = start - reach, start + reach
    for letter, high in (("q", model.most), ("r", math.sqrt(model.most)), ("t", 1.0)):
        own = np.char.startswith(names, f"{letter}:") | (names == "turn") & (letter == "t")
        lowest, highest = np.where(own, -high, lowest), np.where(own, high, highest)
    least, most = np.array([model.limits.get(name, (-np.inf, np.inf)) for name in model.names]).T
    return np.maximum(lowest, least), np.minimum(highest, most)


class Neighbour:
    """Where the search of one record ended, for that of the next one of a map."""

    def __init__(self) -> None:
        self.found: ForceCurveFit | None = None

    def start(self, model: ForceCurveModel) -> Array | None:
        """Unknowns of a ``model`` with moduli and w of the last record, contact beginning as far from the outermost row
        that is in contact for sure; None where it has others."""
        found = self.found
        if found is None or found.names != model.names or model.positions or any(one.wave for one in model.stretches):
            return None
        then, now = _outermost(found.model), _outermost(model)
        if then is None or now is None:
            return None
        values = {name: found.value(name) for name in found.names} | _by_base_lines(model)
        values["z0"] += now - then
        return np.array([values[name] for name in model.names])


def _outermost(model: ForceCurveModel) -> float | None:
    """The position [m] of the outermost row of the last direction that is in contact for sure."""
    part = model.stretches[-1]
    return float(part.z[part.touching].min()) if part.jumped else None


def nearest(model: ForceCurveModel, loss: Loss = "linear", near: Array | None = None) -> ForceCurveFit:
    """The unknowns that leave least, from several starts until one leaves no more than noise, ``near`` being the first
    one; SolveError where no search converges. Of a retraction alone all are tried: how far its edge rests is told by
    its shape only."""
    noise = max(part.line.noise for part in model.stretches)
    if near is not None and "turn" not in model.names:
        with contextlib.suppress(SolveError):
            found = fit(model, near, True, loss)
            if found.ended and found.sigma <= TUNING.surely_found * noise:
                return found
    best: ForceCurveFit | SolveError = SolveError("no curve of this body resembles the record")
    for x in starts_of(model):
        try:
            found = fit(model, x, loss=loss)
        except SolveError as error:
            best = error if isinstance(best, SolveError) else best
            continue
        if isinstance(best, SolveError) or (not found.ended, found.sigma) < (not best.ended, best.sigma):
            best = found
        if "turn" not in model.names and best.sigma <= TUNING.enough * noise:
            break
    if isinstance(best, SolveError):
        raise best
    return best


def starts_of(model: ForceCurveModel) -> Iterator[Array]:
    """Unknowns to begin with, as each stretch suggests."""
    if "turn" not in model.names:
        yield from (_start(model, part, 1.0, 0.0) for part in model.stretches)
        return
    yield from (_start(model, model.stretches[0], share, turn) for share, turn in TUNING.alone)


def _start(model: ForceCurveModel, part: DirectionReadings, share: float, turn: float) -> Array:
    """Unknowns to begin with, as a ``share`` of the way in contact of one stretch suggests: shapes w/s and contact
    points are tried; for each of them the rest is linear."""
    s, zero, r = _tried(model, part, share)
    values = {"ln_s": math.log(s), "z0": zero, "turn": turn, **dict.fromkeys(model.positions, 0.0)}
    values |= _by_base_lines(model)
    for other in model.stretches:
        q = r**2 if other is part else _of_tension(model, s, other.tension)
        values |= {f"q:{other.kind}": q, f"r:{other.kind}": math.sqrt(q)}
        if other.wave is not None:
            values["ln_period"] = math.log(other.wave.period)
            values |= {f"cos:{other.kind}": other.wave.cos, f"sin:{other.kind}": other.wave.sin}
    return np.array([values[name] for name in model.names])


def _by_base_lines(model: ForceCurveModel) -> dict[str, float]:
    """Offsets and tilts as the free rows have them."""
    offsets = {f"offset:{part.kind}": float(part.line(part.z[0])) for part in model.stretches}
    return offsets | {f"tilt:{part.kind}": part.line.tilt for part in model.stretches}


def _of_tension(model: ForceCurveModel, s: float, tension: float) -> float:
    """q of moduli times ``s`` that a contact is pulled off at a ``tension`` [N] with."""
    (D, T, H, V), _, _ = on_grid(model.family)
    r = _shapes(D, T)[:, None]
    folds = np.argmin(D - r * T + s * (H - r * V) / model.k, axis=1)
    tensions = s * (r[:, 0] * V[folds] - H[folds])
    return float(np.interp(tension, np.maximum.accumulate(tensions), r[:, 0])) ** 2


def _tried(model: ForceCurveModel, part: DirectionReadings, share: float) -> tuple[float, float, float]:
    """s, z0 and sqrt(q) that a stretch is best described with, by its found base line, up to a ``share`` of the way in
    contact."""
    rows = _some_rows(part)
    rows = rows[part.z[rows] <= part.z.max() - (1 - share) * part.reach] if share < 1 else rows
    net = part.P[rows] - part.line(part.z[rows])
    if part.wave is not None:
        net -= part.wave(part.z[rows])
    delta = part.z[rows] - net / model.k
    (D, T, H, V), _, _ = on_grid(model.family)
    modulus, work = model.known.get("ln_s"), model.works.get(part.kind)
    best = (math.inf, 0.0, 0.0, 0.0)
    points = _contact_points(part, delta, rows)
    for r in _shapes(D, T) if part.jumped and work != 0 else (0.0,):
        path, load = D - r * T, H - r * V
        fold = int(np.argmin(path))
        zeros = points - float(path[fold]) if part.jumped else points
        basis = np.interp(delta - zeros[:, None], path[fold:], load[fold:], left=0.0 if not part.jumped else None)
        if part.jumped:
            basis = np.where(part.touching[rows], basis, 0.0)
        size = np.sum(basis**2, axis=1)
        factors = basis @ net / np.where(size > 0, size, np.inf)
        if modulus is not None or work:
            factors[:] = math.exp(modulus) if modulus is not None else (work or 0.0) / r**2 if r else 0.0
        costs = np.sum((net - factors[:, None] * basis) ** 2, axis=1)
        at = int(np.argmin(np.where(factors > 0, costs, np.inf)))
        if factors[at] > 0 and costs[at] < best[0]:
            best = (float(costs[at]), float(factors[at]), float(zeros[at]), float(r))
    if best[1] == 0:
        raise SolveError("no curve of this body resembles the record")
    return best[1:]


def _some_rows(part: DirectionReadings) -> Array:
    """Rows spread evenly, half of them where contact may be."""
    n = part.z.size
    if n <= ROWS:
        return np.arange(n)
    near = int(np.argmax(part.touching)) if part.jumped else n // 2
    halves = [np.linspace(first, n - 1, ROWS // 2) for first in (0, near)]
    return np.unique(np.concatenate(halves).astype(int))


def _shapes(D: Array, T: Array) -> Array:
    """Ratios sqrt(w/s): of almost no adhesion, and so that the shift is the displacement at radii across the series."""
    ratio = np.unique(D / T)
    return np.concatenate([[0.0], np.geomspace(ratio[0], ratio[-1], TUNING.shapes)])


def _contact_points(part: DirectionReadings, delta: Array, rows: Array) -> Array:
    """Displacements tried as zero; with a jump, as the fold, about its first row in contact."""
    span = float(np.ptp(delta))
    if not part.jumped:
        return np.linspace(delta.min(), delta.max() - 0.01 * span, TUNING.points)
    first = float(delta[part.touching[rows]][0])
    steps = span * np.geomspace(1e-4, 0.5, TUNING.points // 3)
    return first + np.concatenate([-steps, [0.0], steps])

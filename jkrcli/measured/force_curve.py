"""One statistical model of a whole force curve: base line, contact point, modulus and work of adhesion together.

The reading at device position z is that of a contact on its path (``branches``) over a straight base line and what
acts beside the contact (``free_rows``); all scatter is in the load:

    reading(z) = offset + tilt (z - z_touch) + B(z) + P(z - z0; s, w, k)

P is 0 where a row is free. On approach the contact line closes with its own w; from the reversal on it is pinned,
then it opens with the w of the retraction. Where the retraction is alone, the root of the w of its approach is a share
``turn`` of its own. Each direction has its own base line (drag, drift of the load). On request positions err by a
drift, hysteresis or creep, 0 at the turning point: in one direction alone they cannot be separated from another
modulus.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import NamedTuple, TypeAlias

import numpy as np

from ..base.errors import SolveError, known
from ..base.numerics import MOST_SOLVES, MOST_STEPS, ROWS, SAME, SETTLED, Array, median, pchip
from ..base.process import REMEMBERED
from .branches import Branches, DeviceBranch, Moving, Rest, Resting, branch, rest
from .choices import Loss, Values
from .curve import APPROACH, RETRACT
from .forward_model import Family, on_grid
from .free_rows import LOADS, RANGE, RELAXED, FreeRows, Place, Term
from .least_squares import (
    TURNS,
    Least,
    LeastSquares,
    Spectrum,
    Spread,
    State,
    TimeOrder,
    covariance_coloured,
    influence,
    robust_scale,
)
from .lockstep import Flow, alone, ask, beside
from .rows import in_contact, noise_from_third_differences
from .segmentation import BaseLine, Direction, ForceCurve

# --------------------------------------------------------------------------------------------------
# Rows of a raw record as its model takes them: each direction from its far end inwards, with its base line.

# Which rows are left out.
# tuned on fits, by `make constants`: of the rows in contact, those next to the turning point that are left out
READINGS_TURNING = 0.01


@dataclass(frozen=True, eq=False)
class DirectionReadings:
    """The ``rows`` of one direction, from the far end inwards: device position ``z`` [m], reading ``P`` [N].

    ``touching``: whether a row may be in contact; where ``jumped``, all those rows are, and the others are free, by a
    jump, or by a window about first touch that is left out.
    ``line``: the base line of the free rows alone; ``held``: what was taken off the loads.
    ``t``: time since the end of the approach [s], 0 where it is not known, ``waits`` until the retraction, of
    ``lasting`` in all. ``turn``: where the device turns [m]; ``tension``: the largest above the noise [N].
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
    waits: float = 0.0
    lasting: float = 0.0
    held: FreeRows | None = None

    @cached_property
    def place(self) -> Place | None:
        """Where its rows lie beside the contact."""
        return None if self.held is None else self.held.place.some(self.rows)

    @property
    def terms(self) -> tuple[Term, ...]:
        """What acts beside the contact."""
        return () if self.held is None else self.held.terms

    @cached_property
    def spacing(self) -> float:
        """Usual distance of neighbouring rows [m]; the mean where most of them repeat their position."""
        steps = np.abs(np.diff(self.z))
        return median(steps) or float(np.mean(steps))

    @property
    def span(self) -> float:
        """Range of the loads [N]."""
        return float(np.ptp(self.P))

    @property
    def along(self) -> Array:
        """Way of the device from the first row on [m]."""
        return self.z - self.z[0]

    @property
    def contact(self) -> Array:
        """The numbers of the rows in contact, where these are known."""
        return np.flatnonzero(self.touching)

    @property
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
        begins = np.arange(self.z.size) % size == 0
        begins[1:] |= self.touching[1:] != self.touching[:-1]
        first = begins.nonzero()[0]
        count = np.diff(np.append(first, self.z.size))
        z, P, t = (np.add.reduceat(column, first) / count for column in (self.z, self.P, self.t))
        return replace(self, rows=self.rows[first], touching=self.touching[first], z=z, P=P, t=t)


def stretches(record: ForceCurve, kinds: Sequence[str]) -> tuple[DirectionReadings, ...]:
    """The directions ``kinds`` of a record as the model takes them: rows within a jump belong to neither side and are
    left out."""
    sides = [side for kind in kinds if (side := record.direction(kind)) is not None]
    return tuple(_stretch(record, side) for side in sides)


def _stretch(record: ForceCurve, side: Direction) -> DirectionReadings:
    curve, inwards = record.curve, slice(None, None, 1 if side.segment.kind == APPROACH else -1)
    rows = np.arange(side.segment.first, side.segment.last + 1)[inwards]
    z, P = (column[side.segment.rows][inwards] for column in (curve.device, curve.load))
    line, tension, touching, keep = _base_and_contact(side, z, P)
    contact = np.count_nonzero(touching) or rows.size - side.border[1]
    keep[rows.size - round(READINGS_TURNING * contact) :] = False
    if record.ignored.size:
        keep &= ~np.isin(rows, record.ignored)
    into = record.direction(APPROACH)
    last = int(np.argmax(curve.device)) if into is None else into.segment.last
    t = np.zeros(len(curve)) if curve.t is None else curve.t - curve.t[last]
    return DirectionReadings(
        side.segment.kind, rows[keep], line, z[keep], P[keep], touching[keep], bool(touching.any()), t[rows[keep]],
        float(curve.device.max()), tension, max(float(t[rows[-1]]), 0.0), float(np.ptp(t)),
        record.held,
    )  # fmt: skip


def unbroken(record: ForceCurve, model: ForceCurveModel) -> ForceCurveModel:
    """The ``model`` of all rows of its directions of a record, within jumps too, in contact where the model says so;
    without a base line as it is."""
    parts = list[DirectionReadings]()
    for part in model.stretches:
        side = record.direction(part.kind)
        if side is None or not side.begins_free:
            parts.append(part)
            continue
        rows = np.arange(side.segment.first, side.segment.last + 1)[:: 1 if part.kind == APPROACH else -1]
        rows = rows[~np.isin(rows, record.ignored)]
        z, P = record.curve.device[rows], record.curve.load[rows]
        order = np.argsort(part.rows)
        t = np.interp(rows, part.rows[order], part.t[order])
        parts.append(replace(part, rows=rows, z=z, P=P, touching=np.zeros(rows.size, dtype=bool), jumped=False, t=t))
    return replace(model, stretches=tuple(parts))


def _base_and_contact(side: Direction, z: Array, P: Array) -> tuple[BaseLine, float, Array, Array]:
    """Base line of a direction, its largest tension [N], masks of the rows in contact and of those to keep; no row is
    surely in contact without a jump at first touch. Without a base line the load is that over 0."""
    tension, touching, keep = known(side.adhesion) or 0.0, np.zeros(z.size, dtype=bool), np.ones(z.size, dtype=bool)
    if not side.begins_free:
        touching = in_contact({"delta": z, "P": P}, 0.0)
        line = BaseLine(0.0, 0.0, float(z[0]), 0, noise_from_third_differences(P), 0.0, False)
        tension = max(-float(P.min()), 0.0)
        return line, tension if tension > line.least else 0.0, touching, touching.copy()
    if side.jumps or (side.segment.kind != APPROACH and tension):
        first, last = side.border
        touching[last:], keep[first + 1 : last] = True, False
    return side.base, tension, touching, keep


# --------------------------------------------------------------------------------------------------
# Errors of the positions of a device, each as one unknown of a raw record; all are 0 where the device turns.
#
# ``drift`` is a steady motion of the zero [m/s]. ``hysteresis`` and ``creep`` are those of a piezo without a sensor,
# on the way back: it stands deeper than its positions say, by a parabola that is 0 at both ends of the travel, or by
# the logarithm of the time since the turn (Devasia, Eleftheriou and Moheimani, IEEE Trans. Control Syst. Technol. 15,
# 802, 2007). Their amounts are fractions of the travel: the largest separation of the ways, and the creep per decade
# of time from a hundredth of the record on.

# How creep begins.
POSITION_ONSET = 0.01  # choice: of the time of a record, from which on it goes by decades


TIMED = ("drift", "creep")  # that need a column of time


def hysteresis(way: Array) -> Array:
    """The share of the largest separation at shares ``way`` of the travel from the turn on."""
    return 4 * way * (1 - way)


def creep(time: Array) -> Array:
    """Decades of the ``time`` since the turn, over that of the record."""
    return np.log10(1 + time / POSITION_ONSET)


# Which rows tell the noise, and what is remembered.
# tuned on raw records, by `make constants`: of the rows of a base line, those that tell the noise: contact begins
# gently
FORCE_CURVE_SURELY = 0.9
FORCE_CURVE_REMEMBERED = 2  # theory: residuals at the same unknowns, with the fold as the search sees it and as it is


Edges: TypeAlias = tuple[DeviceBranch, Rest | None, Array, Array, Array]  # with the depth of all rows, and which move
Loads: TypeAlias = "Callable[[ForceCurveModel, DirectionReadings, Values], Array]"  # [N], of all rows


@dataclass(frozen=True, eq=False)
class ForceCurveModel:
    """The readings of some stretches on one body at a device of stiffness ``k`` [N/m], as a function of the unknowns.

    These are ln s, z0, the errors of ``positions``, for each stretch its offset, tilt, and q = w/s unless its w is one
    of ``works`` [J/m^2]; of an approach before a retraction that adheres its signed root instead, which the resting
    edge is smooth in; of a retraction alone the share ``turn``; and those of what acts beside the contact. ``known``:
    those that are not fitted, by name. ``moduli``: least and largest s.
    """

    family: Family
    k: float
    stretches: tuple[DirectionReadings, ...]
    known: Values = field(default_factory=dict)
    works: Values = field(default_factory=dict)
    moduli: tuple[float, float] = (0.0, math.inf)
    positions: tuple[str, ...] = ()

    @cached_property
    def few(self) -> ForceCurveModel:
        """The model of a few rows; of all where these skip a term."""
        few = replace(self, stretches=tuple(part.thinned() for part in self.stretches))
        return few if few.names == self.names else self

    @property
    def rows(self) -> Array:
        """The rows of the record in all stretches."""
        return np.concatenate([part.rows for part in self.stretches])

    @cached_property
    def in_time(self) -> TimeOrder:
        """The order in which the rows were taken."""
        return TimeOrder.of(self.rows)

    def ordered(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows as they were taken, where the order matters to the ``noise``."""
        return self.in_time.series(columns, noise) if noise.slow else columns

    def whitened(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of all rows so that a noise has unit variance and no colour."""
        return noise.whitened(self.ordered(columns, noise))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The unknowns in order; those of a stretch carry its kind."""
        names = ["ln_s", "z0", *self.positions]
        for stretch in self.stretches:
            names += [f"offset:{stretch.kind}", f"tilt:{stretch.kind}"]
            rests = stretch is not self.stretches[-1] and self.stretches[-1].tension > 0
            names += [f"{'r' if rests else 'q'}:{stretch.kind}"] * (stretch.kind not in self.works)
            names += ["turn"] * (len(self.stretches) == 1 and stretch.kind != APPROACH and stretch.tension > 0)
        names += [name for term in self.stretches[0].terms if self.has(term) for name in term.names]
        return tuple(name for name in names if name not in self.known)

    def has(self, term: Term) -> bool:
        """Whether a term acts on a row of a stretch."""
        places = [part.place for part in self.stretches if part.place is not None]
        of = term.moved if term.law == RELAXED else term.at
        return any(column.any() for place in places for column in of(place, term.values)[1])

    @property
    def most(self) -> float:
        """Largest q: of a curve that is pulled off at the end of the series."""
        _, (_, _, dH, dV), _ = on_grid(self.family)
        return 0.9 * float(dH[-1] / dV[-1]) ** 2

    @property
    def by_terms(self) -> dict[str, float]:
        """The unknowns of what acts beside the contact as the free rows have them."""
        terms = self.stretches[0].terms
        return {name: value for term in terms for name, value in zip(term.names, term.values, strict=True)}

    @property
    def limits(self) -> Mapping[str, tuple[float, float]]:
        """Least and largest values of unknowns by name."""
        least, most = (math.log(s) if s > 0 else -math.inf for s in self.moduli)
        held = self.stretches[0].held
        ranges = {name: held.place.limits(term.law) for term in held.terms for name in term.names} if held else {}
        return {"ln_s": (least, most)} | {name: ends for name, ends in ranges.items() if name.startswith(RANGE)}

    def further(self, values: Values) -> dict[str, float]:
        """What other unknowns mean, SI, by name."""
        return {}

    def values(self, x: Array) -> dict[str, float]:
        """All unknowns by name, the known ones too, and q of each stretch."""
        values = {**self.by_terms, **self.known, **dict(zip(self.names, x.tolist(), strict=True))}
        for kind, w in self.works.items():
            values[f"q:{kind}"] = w / math.exp(values["ln_s"])
        for kind in (APPROACH, RETRACT):
            if (r := values.get(f"r:{kind}")) is not None:
                values[f"q:{kind}"] = r * abs(r)
        return values

    def unknowns(self, values: Values) -> Array:
        """Those of some ``values`` by name, in order."""
        return np.array([values[name] for name in self.names])

    @property
    def noise(self) -> float:
        """The largest noise of a base line [N]."""
        return max(part.line.noise for part in self.stretches)

    def depth(self, part: DirectionReadings, values: Values) -> Array:
        """Position of the device beyond its zero [m], at all rows of a stretch."""
        depth: Array = part.z - values["z0"]
        for name, by in self.misplaced(part).items() if self.positions else ():
            depth += values[name] * by
        for term in part.terms:
            if term.moves and part.place is not None:
                depth -= term.moved(part.place, [values[name] for name in term.names])[0]
        return depth

    def misplaced(self, part: DirectionReadings) -> dict[str, Array]:
        """How much deeper the rows of a stretch stand than they say, per amount of each error of positions [m]."""
        back = part.travel * (part.kind != APPROACH)
        shifts = {}
        for name in self.positions:
            if name == "drift":
                shifts[name] = -part.t
            elif name == "hysteresis":
                shifts[name] = back * hysteresis(part.way)
            else:
                shifts[name] = back * creep(np.maximum(part.t, 0.0) / part.lasting)
        return shifts

    def deepened(self, part: DirectionReadings, values: Values) -> float:
        """How much deeper the device creeps while it waits before the way back, per amount [m]."""
        crept = part.waits > 0 and values.get("creep", 0.0) > 0
        return part.travel * float(creep(np.array(part.waits / part.lasting))) if crept else 0.0

    def moving(self, part: DirectionReadings, values: Values) -> Moving:
        """What the branch on which the edge of a stretch moves is of."""
        return self.family, math.exp(values["ln_s"]), values[f"q:{part.kind}"], self.k

    def resting(self, part: DirectionReadings, values: Values) -> Resting | None:
        """What the resting edge with which a stretch begins at the turning point is of; None where none rests."""
        root = math.sqrt(max(values[f"q:{part.kind}"], 0.0))
        first = self.stretches[0]
        if first is not part:
            before = values.get(f"r:{first.kind}", math.sqrt(max(values[f"q:{first.kind}"], 0.0)))
        elif "turn" in values:
            before = values["turn"] * root
        else:
            return None
        depth = part.turn - values["z0"] + values.get("creep", 0.0) * self.deepened(part, values)
        return (self.family, math.exp(values["ln_s"]), before, root, self.k, depth) if before < root else None

    def in_place_of_path(self, part: DirectionReadings) -> Loads | None:
        """What gives the loads of a stretch where they are not those of the path."""
        return None

    def branch(self, part: DirectionReadings, values: Values) -> DeviceBranch:
        """The branch on which the edge of a stretch moves."""
        return branch(*self.moving(part, values))

    def rest(self, part: DirectionReadings, values: Values) -> Rest | None:
        """The resting edge with which a stretch begins at the turning point."""
        asked = self.resting(part, values)
        return None if asked is None else rest(*asked)

    def touching(self, part: DirectionReadings, depth: Array, fold: float) -> Array:
        """Which rows of a stretch at their ``depth`` [m] are in contact: those known to be, else those beyond first
        touch, or on the branch down to its ``fold`` [m]."""
        return part.touching if part.jumped else depth > (0.0 if part.kind == APPROACH else fold)

    def calibrated(self, factor: float, of_stiffness: bool) -> ForceCurveModel:
        """The same of a device whose loads are ``factor`` times as large: by its stiffness, at the same deflections, or
        by its sensitivity, which its deflections follow."""
        k = factor * self.k if of_stiffness else self.k
        held = [None if part.held is None else part.held.scaled(factor, k) for part in self.stretches]
        parts = tuple(
            replace(part, P=factor * part.P, tension=factor * part.tension, held=one)
            for part, one in zip(self.stretches, held, strict=True)
        )
        return replace(self, stretches=parts, k=k)

    def free(self, columns: Array) -> list[Array]:
        """Of columns of all rows, those of each stretch that surely are free, whatever the model says."""
        parts = zip(self.stretches, np.split(columns, self.ends[1:-1]), strict=True)
        return [column[: round(FORCE_CURVE_SURELY * part.line.rows)] for part, column in parts]

    @cached_property
    def known_residuals(self) -> dict[tuple[bytes, float], tuple[Array, Array]]:
        """The ``residuals`` at the last unknowns, by these and ``blunt``."""
        return {}

    def residuals(self, x: Array, blunt: float) -> tuple[Array, Array]:
        """Model minus reading [N] of all rows, and its derivatives by the unknowns, (rows, unknowns), both remembered.

        ``blunt``: share of the depth of contact over which the fold is blunt; 0: half the distance of two rows.
        """
        return alone(ask(residuals_of, (self, x, blunt)))

    def assembled(self, values: Values, on_path: Sequence[OnPath]) -> tuple[Array, Array]:
        """Model minus reading [N] of all rows and its derivatives (unknowns, rows), from the loads of the contact in
        each stretch and their derivatives."""
        ends = self.ends
        off, rates = np.empty(ends[-1]), np.zeros((len(self.names), ends[-1]))
        for part, (columns, _), first, last in zip(self.stretches, on_path, ends[:-1], ends[1:], strict=True):
            line, by_line = base_line(part, values)
            off[first:last] = line + columns[0] - part.P
            by = {} if self.in_place_of_path(part) else self._by_names(part, values, columns)
            for term in part.terms:
                if term.moves and part.place is not None and by:
                    _, shifts = term.moved(part.place, [values[name] for name in term.names])
                    by_line |= {name: by_line[name] - columns[3] * shift
                                for name, shift in zip(term.names, shifts, strict=True)}  # fmt: skip
            for name, column in itertools.chain(by.items(), by_line.items()):
                if name in self.places:
                    rates[self.places[name], first:last] += column
        return off, rates

    def completed(self, x: Array, blunt: float, off: Array, rates: Array) -> Array:
        """The derivatives with those of unknowns that the path does not know."""
        return rates

    @cached_property
    def places(self) -> dict[str, int]:
        """The place of each unknown among all, by name."""
        return {name: i for i, name in enumerate(self.names)}

    @property
    def ends(self) -> list[int]:
        """Where the rows of each stretch begin among all, and their number."""
        return list(itertools.accumulate((part.P.size for part in self.stretches), initial=0))

    def off(self, x: Array, blunt: float) -> Array:
        """Model minus reading [N] of all rows."""
        return alone(ask(offs, (self, x, blunt)))

    def by_position(self, x: Array) -> Array:
        """Derivative of the loads of all rows by their positions [N/m], the turn and the base lines where they are."""
        return self._path(x)[0]

    def edges(self, x: Array) -> Sequence[Edges]:
        """Of each stretch the branch and the resting edge, the depth [m] of all rows, and the numbers of those at which
        the edge moves, and of those at which it rests; remembered."""
        if (key := x.tobytes()) in self._edges:
            return self._edges[key]
        edges: list[Edges] = []
        values = self.values(x)
        for part, kept in zip(self.stretches, self._path(x)[1], strict=True):
            moving, resting = kept or (self.branch(part, values), self.rest(part, values))
            depth = self.depth(part, values)
            lost, end = np.array(moving.fold), np.array(math.inf)
            if resting is not None:
                lost, end = resting.until(moving.u[0], lost)
            rows = part.contact if part.jumped else self.touching(part, depth, float(lost)).nonzero()[0]
            rests = depth[rows] > end
            edges.append((moving, resting, depth, rows[~rests], rows[rests]))
        self._edges.clear()
        self._edges[key] = edges
        return edges

    @cached_property
    def _edges(self) -> dict[bytes, Sequence[Edges]]:
        return {}

    def _path(self, x: Array) -> tuple[Array, Sequence[tuple[DeviceBranch, Rest | None] | None]]:
        """``by_position``, and the branch and the resting edge of each stretch, None where its loads are not those of
        the path: of the last evaluation or of one more."""
        if (key := x.tobytes()) not in self._paths:
            alone(ask(evaluated, (self, x, 0.0)))
        return self._paths[key]

    def remember_path(self, x: Array, on_path: Sequence[OnPath]) -> None:
        """Keep the derivatives ``by_position`` [N/m] of what stretches do, and the edges that they are on."""
        self._paths.clear()
        self._paths[x.tobytes()] = np.concatenate([one.columns[3] for one in on_path]), [one.edges for one in on_path]

    @cached_property
    def _paths(self) -> dict[bytes, tuple[Array, Sequence[tuple[DeviceBranch, Rest | None] | None]]]:
        return {}

    def _by_names(self, part: DirectionReadings, values: Values, columns: Array) -> dict[str, Array]:
        """Derivatives of the load of the contact at all rows of a stretch, by the names of the unknowns."""
        _, by_s, by_q, by_z, *of_rest = columns
        own, q = f"q:{part.kind}", values[f"q:{part.kind}"]
        by_zero, more = -by_z, dict[str, Array]()
        if of_rest:
            by_before, by_turn = of_rest
            by_zero -= by_turn
            root = math.sqrt(max(q, 1e-300))
            if "turn" in values:
                by_q = by_q + by_before * (values["turn"] / (2 * root))
                more["turn"] = by_before * root
            first = self.stretches[0].kind  # by whose q, or its root, the edge came to the turn
            if part is not self.stretches[0] and f"r:{first}" in values:
                more[f"r:{first}"] = by_before
            elif part is not self.stretches[0] and (before := values[f"q:{first}"]) > 0:
                more[f"q:{first}"] = by_before / (2 * math.sqrt(before))
        elif part is self.stretches[0] and (name := f"r:{part.kind}") in values:
            more = {name: 2 * abs(values[name]) * by_q}
        for name, misplaced in self.misplaced(part).items() if self.positions else ():
            more[name] = by_z * misplaced
            if name == "creep" and of_rest:
                more[name] += of_rest[1] * self.deepened(part, values)
        by_modulus = by_s - q * by_q if part.kind in self.works else by_s
        return {"ln_s": by_modulus, "z0": by_zero, own: by_q} | more


def radii_at(
    moving: DeviceBranch, resting: Rest | None, depth: Array, rows: Array, still: Array
) -> tuple[Array, Array]:
    """Contact radius [m] at all rows of a stretch by its edges, 0 where they are free, and which of them are at
    rest."""
    a, rests = np.zeros(depth.size), np.zeros(depth.size, dtype=bool)
    a[rows] = moving.radii(depth[rows])
    if resting is not None:
        a[still], rests[still] = math.exp(resting.u), True
    return a, rests


def base_line(part: DirectionReadings, values: Values) -> tuple[Array, dict[str, Array | float]]:
    """Load of the base line of a stretch at all its rows, and its derivatives by name."""
    along, offset, tilt = part.along, f"offset:{part.kind}", f"tilt:{part.kind}"
    line = values[offset] + values[tilt] * along
    by: dict[str, Array | float] = {offset: 1.0, tilt: along}
    if part.place is not None and part.held is not None:
        line = line - part.held.taken[part.rows]
        for term in part.terms:
            own = [values[name] for name in term.names]
            load, columns, by_zero = term.beside_contact(part.place, own, values["z0"])
            line += load
            by["z0"] = by.get("z0", 0.0) + by_zero
            by |= dict(zip(term.names, columns, strict=True))
    return line, by


# --------------------------------------------------------------------------------------------------
# Loads and residuals of many records at once: rows are flat, in the order of records and stretches.


class OnPath(NamedTuple):
    """Loads of the contact at all rows of a stretch with their derivatives by ln s, own q and z, (4, rows), and where
    it is pinned by the root of q before and by the turn, (6, rows), or loads alone, (1, rows); ``edges``: the branch
    and the resting edge that they are on, if these are kept."""

    columns: Array
    edges: tuple[DeviceBranch, Rest | None] | None = None


def contact_loads(
    asked: Sequence[tuple[ForceCurveModel, DirectionReadings, Values, float]], slopes: bool = True
) -> list[OnPath | Exception]:
    """Loads of the contact at all rows of some stretches, with ``slopes`` or alone, each of a model with values of its
    unknowns and the share of its depth over which its fold is blunt; 0: half the distance of two rows, and with slopes
    the edges are kept."""
    answers: list[OnPath | Exception] = [OnPath(np.empty(0))] * len(asked)
    each: list[tuple[int, DirectionReadings, Array, float, Moving, Resting | None]] = []
    for place, (model, part, values, blunt) in enumerate(asked):
        try:
            if (loads := model.in_place_of_path(part)) is not None:
                rates = np.zeros((5 * slopes, part.z.size))
                answers[place] = OnPath(np.append(loads(model, part, values)[None], rates, axis=0))
                continue
            depth, width = model.depth(part, values), blunt * part.reach if blunt else part.spacing / 2
            each.append((place, part, depth, width, model.moving(part, values), model.resting(part, values)))
        except Exception as error:
            answers[place] = error
    if not each:
        return answers
    places, parts, depths, widths, edges, at_rest = zip(*each, strict=True)
    moving = Branches.of(edges)
    resting = [i for i, one in enumerate(at_rest) if one is not None]
    edge = Rest.of([one for one in at_rest if one is not None]) if resting else None
    lost, end = moving.fold, np.full(len(each), np.inf)
    if edge is not None:
        lost = lost.copy()
        lost[resting], end[resting] = edge.until(moving.u[resting, moving.first[resting]], lost[resting])
    # Rows in contact, in order of the curves, and the curve of each.
    stretches = zip((asked[place][0] for place in places), parts, depths, lost.tolist(), strict=True)
    touching = [model.touching(part, depth, fold) for model, part, depth, fold in stretches]
    depth, rows = np.concatenate(depths), np.concatenate(touching).nonzero()[0]
    ends = list(itertools.accumulate((one.size for one in depths), initial=0))
    own, z = np.repeat(np.arange(len(each)), np.diff(ends))[rows], depth[rows]
    columns = np.zeros((6 if slopes else 1, depth.size))
    if edge is not None:
        number = np.zeros(len(each), dtype=int)
        number[resting] = np.arange(len(resting))
        still = z > end[own]
        moves, rests = np.flatnonzero(~still), np.flatnonzero(still)
        columns[:, rows[rests]] = edge.at(z[rests], number[own[rests]])[: len(columns)]
        rows, own, z = rows[moves], own[moves], z[moves]
    columns[: 4 if slopes else 1, rows] = moving.at(own, z, np.array(widths), slopes)
    for i, place in enumerate(places):
        if not moving.stable[i]:
            answers[place] = moving.unstable(i)
            continue
        kept = slopes and not asked[place][3]
        held = None if edge is None or at_rest[i] is None or not kept else edge.some(number[i])
        some = columns[: 4 if at_rest[i] is None else 6, ends[i] : ends[i + 1]]
        answers[place] = OnPath(some, (moving.one(i), held) if kept else None)
    return answers


AtUnknowns: TypeAlias = tuple[ForceCurveModel, Array, float]  # a model, its unknowns, and how blunt the fold is
AtRows: TypeAlias = tuple[Values, Sequence[OnPath]]  # values of the unknowns, and what stretches do


@np.errstate(all="ignore")
def at_rows(asked: Sequence[AtUnknowns], slopes: bool = True) -> list[AtRows | Exception]:
    """The values of the unknowns of some models, and the ``contact_loads`` of their stretches."""
    each = [(model, model.values(x), blunt) for model, x, blunt in asked]
    parts = [(model, part, values, blunt) for model, values, blunt in each for part in model.stretches]
    found, answers = iter(contact_loads(parts, slopes)), list[AtRows | Exception]()
    for model, values, _ in each:
        on_path = list(itertools.islice(found, len(model.stretches)))
        failed = next((one for one in on_path if isinstance(one, Exception)), None)
        answers.append(failed or (values, [one for one in on_path if not isinstance(one, Exception)]))
    return answers


def offs(asked: Sequence[AtUnknowns]) -> list[Array | Exception]:
    """Model minus reading [N] of all rows of some models."""
    answers: list[Array | Exception] = []
    for (model, _, _), answer in zip(asked, at_rows(asked, slopes=False), strict=True):
        if isinstance(answer, Exception):
            answers.append(answer)
            continue
        values, on_path = answer
        each = zip(model.stretches, on_path, strict=True)
        answers.append(np.concatenate([base_line(part, values)[0] + one.columns[0] - part.P for part, one in each]))
    return answers


def evaluated(asked: Sequence[AtUnknowns]) -> list[tuple[Array, Array] | Exception]:
    """Model minus reading [N] of all rows of some models, and its derivatives by the unknowns, (rows, unknowns)."""
    answers: list[tuple[Array, Array] | Exception] = []
    for (model, x, blunt), answer in zip(asked, at_rows(asked), strict=True):
        if isinstance(answer, Exception):
            answers.append(answer)
            continue
        off, rates = model.assembled(*answer)
        if not blunt:
            model.remember_path(x, answer[1])
        try:
            answers.append((off, model.completed(x, blunt, off, rates).T))
        except SolveError as error:
            answers.append(error)
    return answers


def residuals_of(asked: Sequence[AtUnknowns]) -> list[tuple[Array, Array] | Exception]:
    """The ``residuals`` of some models, each remembered by its model."""
    keys = [(x.tobytes(), blunt) for _, x, blunt in asked]
    known = [model.known_residuals.get(key) for (model, _, _), key in zip(asked, keys, strict=True)]
    found = iter(evaluated([one for one, answer in zip(asked, known, strict=True) if answer is None]))
    answers = [next(found) if answer is None else answer for answer in known]
    for (model, _, _), key, answer in zip(asked, keys, answers, strict=True):
        if not isinstance(answer, Exception):
            if key not in model.known_residuals and len(model.known_residuals) >= FORCE_CURVE_REMEMBERED:
                del model.known_residuals[next(iter(model.known_residuals))]
            model.known_residuals[key] = answer
    return answers


# --------------------------------------------------------------------------------------------------
# Where the search for the unknowns of a force curve begins: shapes and contact points tried, the rest linear.

# How many starts are tried.
# choice: of a retraction alone, the share of its way in contact that tells a start, and ``turn`` to begin with:
STARTS_ALONE = ((0.5, 0.1), (0.5, 0.6), (1.0, 1.0), (0.2, 0.4))
STARTS_ROWS = 60  # choice: rows by which starts are compared
STARTS_SHAPES = 13  # choice: ratios w/s tried
STARTS_POINTS = 41  # choice: contact points tried
_BESIDE = np.geomspace(1e-4, 0.5, STARTS_POINTS // 3)
# choice: of the way in contact, contact points tried beside that of its first row
STARTS_BESIDE = np.concatenate([-_BESIDE, [0.0], _BESIDE])


def starts_of(model: ForceCurveModel) -> Iterator[Array]:
    """Unknowns to begin with, as each stretch suggests."""
    if "turn" not in model.names:
        yield from (_start(model, part, 1.0, 0.0) for part in model.stretches)
        return
    yield from (_start(model, model.stretches[0], share, turn) for share, turn in STARTS_ALONE)


def _start(model: ForceCurveModel, part: DirectionReadings, share: float, turn: float) -> Array:
    """Unknowns to begin with, as a ``share`` of the way in contact of one stretch suggests: shapes w/s and contact
    points are tried; for each of them the rest is linear."""
    s, zero, r = _tried(model, part, share)
    values = {"ln_s": math.log(s), "z0": zero, "turn": turn, **dict.fromkeys(model.positions, 0.0), **model.by_terms}
    # q of these moduli by the tension [N] at which the contact is pulled off
    ratios, path, load = _shapes(model.family)
    folds = np.argmin(path + s / model.k * load, axis=1)
    tensions = np.maximum.accumulate(-s * load[np.arange(ratios.size), folds])
    for other in model.stretches:
        q = r**2 if other is part else float(np.interp(other.tension, tensions, ratios)) ** 2
        values |= {f"q:{other.kind}": q, f"r:{other.kind}": math.sqrt(q), f"tilt:{other.kind}": other.line.tilt}
        values[f"offset:{other.kind}"] = float(other.line(other.z[0]))
    return model.unknowns(values)


def _tried(model: ForceCurveModel, part: DirectionReadings, share: float) -> tuple[float, float, float]:
    """s, z0 and sqrt(q) that a stretch is best described with, by the base line of its free rows, up to a ``share``
    of the way in contact."""
    # Rows spread evenly, half of them where contact may be
    rows = np.arange(part.z.size)
    if rows.size > STARTS_ROWS:
        some = np.zeros(rows.size, dtype=bool)
        for first in (0, int(np.argmax(part.touching)) if part.jumped else rows.size // 2):
            some[np.linspace(first, rows.size - 1, STARTS_ROWS // 2).astype(int)] = True
        rows = some.nonzero()[0]
    rows = rows[part.z[rows] <= part.z.max() - (1 - share) * part.reach] if share < 1 else rows
    net = part.P[rows] - part.line(part.z[rows])
    delta = part.z[rows] - net / model.k
    # Displacements tried as zero; with a jump, as the fold, about its first row in contact
    span = float(np.ptp(delta))
    points = np.linspace(delta.min(), delta.max() - 0.01 * span, STARTS_POINTS)
    if part.jumped:  # the others are free
        delta, net = delta[part.touching[rows]], net[part.touching[rows]]
        points = float(delta[0]) + span * STARTS_BESIDE
    modulus, work = model.known.get("ln_s"), model.works.get(part.kind)
    # Ratios sqrt(w/s) with the displacement and the load of each from the fold on, at s = 1 without a device
    shapes = itertools.islice(zip(*_shapes(model.family), strict=True), None if part.jumped and work != 0 else 1)
    each = [(float(r), path, load, int(np.argmin(path))) for r, path, load in shapes]
    curves = [(r, path[fold:], load[fold:]) for r, path, load, fold in each]
    sizes, along = np.empty((2, len(curves), points.size))
    for i, (_, path, load) in enumerate(curves):
        zeros = points - path[0] if part.jumped else points
        basis = np.interp(delta - zeros[:, None], path, load, left=None if part.jumped else 0.0)
        sizes[i], along[i] = np.einsum("ij,ij->i", basis, basis), basis @ net
    factors = along / np.where(sizes > 0, sizes, np.inf)
    if modulus is not None or work:
        known = [math.exp(modulus) if modulus is not None else (work or 0.0) / r**2 if r else 0.0 for r, _, _ in curves]
        factors[:] = np.array(known)[:, None]
    costs = np.where(factors > 0, factors * (factors * sizes - 2 * along), np.inf)
    shape, point = divmod(int(np.argmin(costs)), points.size)
    if not factors[shape, point] > 0:
        raise SolveError("no curve of this body resembles the force curve; --flip P, if compression is negative")
    r, path, _ = curves[shape]
    return float(factors[shape, point]), float(points[point] - path[0] * part.jumped), r


@lru_cache(maxsize=REMEMBERED)
def _shapes(family: Family) -> tuple[Array, Array, Array]:
    """Ratios r = sqrt(w/s), of almost no adhesion, and so that the shift is the displacement at radii across the
    series, with the displacement D - r T and the load H - r V of each on the grid, at s = 1."""
    (D, T, H, V), _, _ = on_grid(family)
    ratio = D / T
    r = np.append(0.0, np.geomspace(ratio.min(), ratio.max(), STARTS_SHAPES))
    return r, D - r[:, None] * T, H - r[:, None] * V


# --------------------------------------------------------------------------------------------------
# The search for the unknowns of a force curve, and its end: estimates, covariance, noise.

# How starts are tried, and when a search ends.
FIT_WINDOW = 4.0  # choice: standard errors of z0 and w that the window about first touch covers
FIT_BESIDE = 2.0  # choice: rows on each side of first touch, at least, that belong to the window
FIT_NARROW = 0.3  # choice: of the depth of contact, that the window covers at most
FIT_RECEDES = 12.0  # theory: fall of chi^2 by one unknown that chance brings once in 2000
FIT_SAME = 1e-3  # choice: of half the sum of squares, that of the difference of two curves that are one
FIT_EXPLAINED = 1.05  # choice: of the noise, residuals that no other start is tried below
FIT_ENOUGH = 1.5  # choice: of the noise, or of what another fit leaves, residuals above which a model is none
FIT_TRIED = 2  # choice: ends with a few rows beside the first, from which a search goes on with all of them
FIT_ROUGH = 30  # choice: steps with a few rows
FIT_BLUNT = (1e-2, 1e-3, 1e-5)  # choice: of the depth of contact, for a blunt fold while searching
FIT_MODULI = 10.0  # choice: of ln s about its start, where the search may go
FIT_CONVERGED = 1e-11  # choice: relative change of parameters
FIT_FELL = 4e-3  # theory: of chi^2 over its rows, its rise six hundredths of a standard error from the minimum
FIT_BEGUN = 1e-4  # choice: of chi^2, its fall by a step with which a search goes on with all rows and a sharper fold
FIT_UNSURE = 0.1  # choice: of the way in contact, the most that the place of a fold is taken to be uncertain by
FIT_NARROWER = 2.0  # choice: factor between two estimates of it, below which they agree
FIT_NEAR = 0.1  # choice: of chi^2, the fall still to be had a third of a standard error from its minimum
FIT_EVALUATIONS = 80  # choice: steps after which the search gives up


@dataclass(frozen=True, eq=False)
class ForceCurveFit:
    """The model that fits best: ``values`` and standard errors by name; ``off`` residuals [N] of all rows.

    ``sigma``: standard deviation of a reading about the model [N]; ``weight``: the noise that rows were weighted by;
    ``spread``: covariance of the unknowns, and the noise that it rests on. ``least``: as the search sees it, in units
    of ``weight``. ``ended``: whether it is a minimum, and not where the search was given up.
    """

    model: ForceCurveModel
    x: Array
    weight: Spectrum
    spread: Spread
    off: Array
    sigma: float
    least: Least
    ended: bool

    @property
    def names(self) -> tuple[str, ...]:
        return self.model.names

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
        return model.unknowns(model.by_terms | self.model.values(self.x))

    @cached_property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, 0 where they are free, and which of them rest."""
        return [radii_at(*edges) for edges in self.model.edges(self.x)]

    @property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return np.concatenate([a for a, _ in self.radii])

    @property
    def weighted(self) -> Array:
        """Derivatives by the unknowns and, last, residuals of all rows in units of the noise, (unknowns + 1, rows)."""
        off, J = self.model.residuals(self.x, 0.0)
        return self.model.whitened(np.concatenate([J.T, off[None]]).T, self.spread.noise).T

    def moves(self, loads: Array) -> Array:
        """By how much the unknowns move, to first order, where the readings are higher by ``loads`` of all rows [N]."""
        J, by = self.weighted[:-1], self.model.whitened(loads[self.model.rows], self.spread.noise)
        scale = np.maximum(np.linalg.norm(J, axis=1), 1e-300)
        return np.linalg.lstsq(J.T / scale, by, rcond=SAME)[0] / scale

    def at_loads(self, factor: float) -> Array:
        """The unknowns as they are about where all loads are ``factor`` times as large."""
        of_loads = "offset:", "tilt:", *LOADS
        loads = np.array([name.startswith(of_loads) for name in self.names], dtype=bool)
        ln_s = np.array([name == "ln_s" for name in self.names])
        return np.where(loads, factor * self.x, self.x) + np.where(ln_s, math.log(factor), 0.0)


def _even(model: ForceCurveModel) -> Spectrum:
    """White noise as large as the range of the loads: the weight while nothing is known of it."""
    return Spectrum(max(part.span for part in model.stretches) ** 2)


@dataclass(frozen=True, eq=False)
class Weighted:
    """The residuals of a model, weighted by noise."""

    model: ForceCurveModel
    weight: Spectrum
    blunt: float

    def __call__(self, x: Array) -> State:
        return alone(ask(self.many, (self, x)))

    @staticmethod
    def many(asked: Sequence[tuple[Weighted, Array]]) -> list[State | Exception]:
        """The states of some of them, each at its unknowns."""
        answers: list[State | Exception] = []
        each = residuals_of([(one.model, x, one.blunt) for one, x in asked])
        for (one, _), answer in zip(asked, each, strict=True):
            if isinstance(answer, Exception):
                answers.append(answer)
            else:
                off, rates = answer
                rated = partial(one.model.whitened, rates, one.weight)
                answers.append(State(one.model.whitened(off, one.weight), rated))
        return answers


def _problem(
    model: ForceCurveModel, weight: Spectrum, bounds: tuple[Array, Array], blunt: float, enough: float,
    fell: float | None = None,
) -> LeastSquares:  # fmt: skip
    least = FIT_FELL / model.ends[-1] if fell is None else fell
    return LeastSquares(Weighted(model, weight, blunt), bounds, enough, least, FIT_EVALUATIONS)


def misfit_at(model: ForceCurveModel, x: Array) -> float:
    """Half the sum of squares at the unknowns ``x``, of loads over their range."""
    off = model.off(np.clip(x, *_bounds(model, x)), FIT_BLUNT[-1])
    return float(off @ off) / (2 * _even(model).A)


def fit(model: ForceCurveModel, start: Array, near: bool = False, loss: Loss = "linear") -> ForceCurveFit:
    """What ``fitting`` leads to."""
    return alone(fitting(model, start, near, loss))


def fitting(model: ForceCurveModel, start: Array, near: bool = False, loss: Loss = "linear") -> Flow[ForceCurveFit]:
    """The unknowns that leave least from a ``start`` on, first of a few rows unless it is ``near``; then weighted by
    the noise of the free rows where that has a colour. Where the rows do not determine them the search creeps along
    a valley: it is given up, and the fit reports it."""
    ends = [] if near else (yield from roughly(model.few, start))
    least = yield from _whole(model, ends[0].x if ends else start).searching(ends[0].x if ends else start)
    return (yield from _finished(model, least, loss))


def _whole(model: ForceCurveModel, start: Array) -> LeastSquares:
    """The search from a ``start`` over all rows of a model."""
    return _problem(model, _even(model), _bounds(model, start), FIT_BLUNT[-1], FIT_CONVERGED)


def roughly(few: ForceCurveModel, start: Array, folds: Sequence[float] = FIT_BLUNT[:-1]) -> Flow[list[Least]]:
    """About the least of ``few`` rows from a ``start`` on, by ever sharper ``folds``; none where there is no curve."""
    bounds, ends = _bounds(few, start), list[Least]()
    with contextlib.suppress(SolveError):
        for blunt in folds:
            problem = _problem(few, _even(few), bounds, blunt, SAME, FIT_BEGUN)
            ends.append((yield from replace(problem, evaluations=FIT_ROUGH).searching(ends[-1].x if ends else start)))
    return ends[-1:]


def _finished(model: ForceCurveModel, least: Least, loss: Loss) -> Flow[ForceCurveFit]:
    """The fit at the least of squares, by the ``loss``, or weighted by the noise of the free rows."""
    bounds, even, sharp = least.problem.bounds, _even(model), FIT_BLUNT[-1]
    about = _problem(model, even, bounds, sharp, SAME)
    if not least.ended:  # of few rows at the fold each makes a kink, between which a search runs to and fro
        least = yield from about.searching(least.x)
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * robust_scale(least.state.residuals)
        least = yield from replace(about, loss=loss, width=width).searching(least.x)
    best = yield from _fitted(model, least, even)
    noise = best.spread.noise
    if loss != "linear" or not noise.slow:
        return best
    x = best.unknowns(model)  # an edge that rests by white noise need not by this one
    for blunt in (sharp, FIT_BLUNT[1]):  # where misfit runs to and fro between the kinks of a sharp fold
        least = yield from _problem(model, noise, _bounds(model, x), blunt, SAME).searching(x)
        weighted = yield from _fitted(model, least, noise)
        if weighted.ended:
            break
    return weighted


def _fitted(model: ForceCurveModel, least: Least, weight: Spectrum) -> Flow[ForceCurveFit]:
    """The fit at the minimum of a search."""
    before, sharp = least.problem, FIT_BLUNT[-1]
    yield from ask(residuals_of, (model, least.x, 0.0))
    model, x = _without_idle(model, least.x, weight)
    problem = replace(before, model=Weighted(model, weight, sharp), bounds=_bounds(model, x))
    off, _ = yield from ask(residuals_of, (model, x, sharp))
    yield from ask(residuals_of, (model, x, 0.0))
    least = replace(least, problem=problem, x=x, state=problem.model(x))
    size = before.width * math.sqrt(_even(model).A)
    psi, slope = influence(off / size, before.loss)
    pull = psi * size / max(float(np.mean(slope)), 0.1)  # what a row pulls with (Huber 1981, Sec. 7.6)
    dof = max(off.size - x.size, 1)

    # From a fold on loads rise with the root of the distance: their slope there holds no nearer to it than its place is
    # known to, nor than half of the way between two rows. White noise leaves it known to about that.
    residuals, free = model.ordered(pull, weight), model.free(off)
    rounding = max(part.line.rounding for part in model.stretches) ** 2

    def spread_by(J: Array) -> Spread:
        return covariance_coloured(residuals, model.ordered(J, weight), free, weight, rounding)

    J = model.residuals(x, 0.0)[1]
    spread, first = spread_by(J), 0
    for part in model.stretches if weight.slow and "z0" in model.names else ():
        rows = slice(first, first := first + part.z.size)
        lost, width = rows.start + int(np.argmax(part.touching)), FIT_UNSURE * part.reach
        if not part.jumped or _place_error(model, J[lost], spread) <= part.spacing:
            continue
        J = J.copy()
        for _ in range(MOST_SOLVES):
            J[rows] = (yield from ask(evaluated, (model, x, width / part.reach)))[1][rows]
            spread = spread_by(J)
            error = max(_place_error(model, J[lost], spread), part.spacing / 2)
            if FIT_NARROWER * error > width:
                break
            width = error
    ended = least.ended or _flat(model.whitened(pull, weight), model.whitened(J, weight), FIT_NEAR / dof)
    return ForceCurveFit(model, x, weight, spread, off, math.sqrt(float(pull @ pull) / dof), least, ended)


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
    off, J = model.residuals(x, 0.0)
    idle = ~J.any(axis=0)
    idle |= (np.array(model.names) == "turn") & (np.abs(x) == 1)
    values, last = model.values(x), model.stretches[-1]
    own, rests, most = f"q:{last.kind}", False, 0.0
    adheres = own in model.names and last.touching.any() and (last.tension > 0 or not last.line.rows)
    if adheres and (resting := model.edges(x)[-1][1]) is not None:
        # Whether an edge that never recedes describes the rows as well, in units of noise: the straight line of the
        # edge at rest goes on then in the rows in which it moves
        (_, _, depth, rows, _), never = model.edges(x)[-1], off.copy()
        never[model.ends[-2] + rows] = (base_line(last, values)[0] - last.P)[rows] + resting.at(depth[rows])[0]
        recedes, rest = (float(np.sum(model.whitened(one, weight) ** 2)) for one in (off, never))
        rests = (rest / recedes - 1) * sum(part.P.size for part in model.stretches) < FIT_RECEDES
        most = held_by_last_row(model, values, resting) * (1 + SAME)  # so that its last row rests, too
    if rests:
        idle |= np.array(model.names) == own
        if "turn" in model.names:  # of which the advance, turn sqrt(q), is to stay as it is
            turn = model.places["turn"]
            idle[turn], x = False, np.where(np.arange(x.size) == turn, x * math.sqrt(values[own] / most), x)
        values[own] = most
    known = {name: values[name] for name, no in zip(model.names, idle, strict=True) if no}
    return (replace(model, known={**model.known, **known}), x[~idle]) if known else (model, x)


def held_by_last_row(model: ForceCurveModel, values: Values, resting: Rest) -> float:
    """The q that the last row of an edge that is ``resting`` throughout holds."""
    last = model.stretches[-1]
    lost = float(model.depth(last, values)[last.touching].min())
    return resting.released(math.sqrt(max(values[f"q:{last.kind}"], 0.0)), lost) ** 2


def windowed(best: ForceCurveFit) -> ForceCurveModel:
    """The model without the rows about first touch where no jump shows which of them are in contact: the load is
    not smooth there in z0 and w. The same model where there are none."""
    parts = tuple(part if part.jumped else _windowed(best, part) for part in best.model.stretches)
    return best.model if parts == best.model.stretches else replace(best.model, stretches=parts)


def _windowed(best: ForceCurveFit, part: DirectionReadings) -> DirectionReadings:
    """A stretch whose rows are free up to the window and in contact beyond."""
    values = best.model.values(best.x)
    depth, own = best.model.depth(part, values), f"q:{part.kind}"
    error = best.error(own) if own in best.names else 0.0
    most = values | {own: max(values[own], 0.0) + FIT_WINDOW * error}
    neck = 0.0 if part.kind == APPROACH else -best.model.branch(part, most).fold
    unsure = best.error("z0") if "z0" in best.names else 0.0
    half = neck + max(FIT_WINDOW * unsure, FIT_BESIDE * part.spacing)
    half = min(half, FIT_NARROW * float(depth.max()))
    if half <= 0:
        return part  # no row of it is in contact
    keep = np.abs(depth) > half
    cut = {name: getattr(part, name)[keep] for name in ("rows", "z", "P", "t")}
    return replace(part, touching=(depth > 0)[keep], jumped=True, **cut)


def _bounds(model: ForceCurveModel, start: Array) -> tuple[Array, Array]:
    """Least and largest unknowns of a search from ``start`` on."""
    about, within = {"ln_s": FIT_MODULI}, {"q": model.most, "r": math.sqrt(model.most)}
    limits, bounds = model.limits, []
    for name, x in zip(model.names, start.tolist(), strict=True):
        reach, (least, most) = about.get(name, math.inf), limits.get(name, (-math.inf, math.inf))
        low, high = x - reach, x + reach
        if (largest := 1.0 if name == "turn" else within.get(name.partition(":")[0])) is not None:
            low, high = -largest, largest
        bounds.append((max(low, least), min(high, most)))
    least, most = np.array(bounds).T
    return least, most


def nearest(model: ForceCurveModel, loss: Loss = "linear") -> Flow[ForceCurveFit]:
    """The unknowns that leave least, none of them of another record; SolveError where no search converges.

    Starts compete on a few rows: the first alone, and unless it leaves no more than noise all side by side. From those
    of the ends that leave least of all rows the search goes on with these. Of a retraction alone all compete at once:
    only its shape shows how far its contact line is pinned.
    """
    wrong = SolveError("no curve of this body resembles the force curve; --flip P, if compression is negative")
    retracts, ends, best = "turn" in model.names, list[Least](), None
    for enough in (FIT_EXPLAINED, 0.0)[retracts:]:
        if enough:
            found = yield from roughly(model.few, next(starts_of(model)), FIT_BLUNT[1:2])
        else:
            found = sorted((yield from _rough_ends(model)), key=lambda one: misfit_at(model, one.x))
        for end in found:
            off = [end.state.residuals - one.state.residuals for one in ends]
            if len(ends) > FIT_TRIED or any(float(one @ one) < FIT_SAME * end.cost for one in off):
                continue
            ends.append(end)
            try:
                least = yield from _whole(model, end.x).searching(end.x)
            except SolveError as error:
                wrong = error
                continue
            misfit = math.sqrt(2 * least.cost * _even(model).A / least.dof)
            ended = least.ended or _flat(least.state.residuals, least.state.jacobian, FIT_NEAR / least.dof)
            if best is None or (not ended, misfit) < best[0]:
                best = (not ended, misfit), least
        if best is not None and (best[0] <= (False, enough * model.noise) or not enough):
            try:
                fitted = yield from _finished(model, best[1], loss)
            except SolveError as error:
                wrong = error
                continue
            # with all unknowns: an edge that rests throughout may be a valley beside that of one that recedes
            if fitted.names == model.names or not enough:
                return fitted
    raise wrong


def _rough_ends(model: ForceCurveModel) -> Flow[list[Least]]:
    """What all starts lead to with a few rows, of two directions also unknowns as each alone has them, moduli and the
    zero as either does."""
    few, own = model.few, dict[str, dict[str, float]]()
    begun = [(few, x, folds) for x in starts_of(model) for folds in (FIT_BLUNT[1:2], FIT_BLUNT[:2])]
    for part in model.stretches if len(model.stretches) > 1 else ():
        single = replace(model, stretches=(part,))
        with contextlib.suppress(SolveError):
            begun += [(single.few, x, FIT_BLUNT[:2]) for x in starts_of(single)]
    found = yield from beside([roughly(*one) for one in begun])
    ends = [(one, end) for (one, _, _), each in zip(begun, found, strict=True) for end in each]
    for one, end in sorted(ends, key=lambda pair: -pair[1].cost):  # of each direction the least comes last
        if one is not few:
            values, kind = one.values(end.x), one.stretches[0].kind
            own[kind] = values | {f"r:{kind}": math.sqrt(max(values[f"q:{kind}"], 0.0))}
    both = {name: value for values in own.values() for name, value in values.items()}
    starts = [both | {name: values[name] for name in ("ln_s", "z0")} for values in own.values() if len(own) > 1]
    found = yield from beside([roughly(few, few.unknowns(values)) for values in starts])
    return [*(end for one, end in ends if one is few), *itertools.chain(*found)]


# --------------------------------------------------------------------------------------------------
# The retraction of a contact whose work of adhesion rises with the speed of its edge: w = w0 (1 + b v^n).
#
# Gent and Schultz's law, quasi-static but for the edge. With L = delta_H - delta and G = S' L^2/(4 pi a) the edge
# recedes where G > w0, at the speed v that its law gives; the device moves back evenly, so that v = -da/dz follows
# from positions alone. Over the contact radius: dz/da = -1/v with z = D - y T + s (H - y V)/k, y = sqrt(q (1 + b
# v^n)).

# Radii at which the edge is followed.
SLOW_EDGE_FIRST = 1e-12  # choice: of the radius at the turn, the first step of the edge, which begins at rest
SLOW_EDGE_EVEN = 0.01  # choice: of it, from where on radii are even, in a geometric sequence before; the contact that
# is left when it is taken as lost
SLOW_EDGE_RADII = 100  # choice: of either; loads are then good to 5e-4 of the tension
SLOW_EDGE_WIDEST = 3.0  # choice: of logs, a step by Newton's method


@lru_cache(maxsize=REMEMBERED)
def receding(
    family: Family, s: float, q: float, k: float, law: tuple[float, float], resting: Rest, turn: float
) -> Array:
    """Positions of the device [m], increasing, and loads [N] of the edge (2, n), for moduli times ``s``, w0 = ``q`` s
    and the ``law`` (b, n); from the end of its ``resting``, where G is w0, or from the ``turn`` [m]."""
    start = math.exp(resting.u)
    x = np.geomspace(SLOW_EDGE_FIRST, SLOW_EDGE_EVEN, SLOW_EDGE_RADII, endpoint=False)
    x = np.append(x, np.linspace(SLOW_EDGE_EVEN, 1 - SLOW_EDGE_EVEN, SLOW_EDGE_RADII))
    D, T, H, V = family.at(np.log(start * (1 - x)))[0]
    r, steps = math.sqrt(q), np.diff(start * x, prepend=0.0)
    free, pulled = D + s * H / k, r * (T + s * V / k)
    begin = place = min(float(resting.end), turn)
    log, before, (b, n), (z, grown) = 0.0, 0.0, law, np.empty((2, x.size))
    for i, (whole, shift, step) in enumerate(zip(free.tolist(), pulled.tolist(), steps.tolist(), strict=True)):
        half = step if i == 0 else step / 2  # it begins at rest: the rule of the trapezium from the second on
        target = place - (0.0 if i == 0 else half * before)
        for _ in range(MOST_STEPS):
            power, slowness = b * math.exp(n * log), half * math.exp(-log)
            root = math.sqrt(1 + power)
            off = whole - shift * root + slowness - target
            change = off / (shift * n * power / (2 * root) + slowness)
            log += min(max(change, -SLOW_EDGE_WIDEST), SLOW_EDGE_WIDEST)
            if abs(change) < SETTLED:
                break
        before = math.exp(-log)
        grown[i] = math.sqrt(1 + b * math.exp(n * log))  # the root of w over w0
        z[i] = place = whole - shift * grown[i]
    loads = np.append(resting.at(np.array([begin]))[0], s * (H - r * grown * V))
    return np.stack([np.append(begin, z), loads])[:, ::-1]


def load_at(path: Array, resting: Rest, turn: float, z: Array) -> Array:
    """Loads [N] at positions ``z`` [m]: at rest down to where the edge begins, 0 where contact is lost."""
    positions, P = path
    rising = np.append(True, np.diff(np.maximum.accumulate(positions)) > 0)
    moving = pchip(positions[rising], P[rising])(np.clip(z, positions[0], positions[-1]))
    return np.where(z > min(resting.end, turn), resting.at(z)[0], np.where(z < positions[0], 0.0, moving))

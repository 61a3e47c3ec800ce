"""The search for the parameters whose curve lies nearest to the points: starts, least squares, bodies solved anew.

A start is a curve of the body, named by the radius at which it is pulled off under load control, which fixes the shape
sqrt(w/s), and by the radius that the largest load reaches, which fixes the factor s of all moduli. Zero points follow
by averages.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..base.errors import NOTICEABLE, InputError, JkrError
from ..base.numerics import FEWEST_ROWS, MOST_SOLVES, ROUNDED, SAME, SETTLED, TINY, UNSEEN, Array, evenly, median
from ..base.units import show
from .choices import BranchName, Loss, SegmentName, Values
from .curve import APPROACH, RETRACT, Curve
from .forward_model import ADVANCING, RECEDING, RESTING, Drift, Family, FittedBody, Member, Members, RestingMember
from .least_squares import STATISTICS_NORMAL_MEDIAN, TURNS, Least, LeastSquares, State, robust_scale
from .parameters import OF_A_CYCLE, Parameter, Unknowns
from .settings import RANGES, Settings

# --------------------------------------------------------------------------------------------------
# The rows of a measured curve that lie on the adhesive curve, and the scatter of their readings.

COLUMNS = ("a", "delta", "P")
EDGES: dict[SegmentName, int] = {"approach": ADVANCING, "retract": RECEDING}  # of directions

# Limits that separate rows out of contact from rows of the curve, and noise from the curve.
ROWS_LEAST = 8  # choice: points, and at least twice as many as free parameters
ROWS_LOST = 0.3  # tuned on records by `make tuning`: of the pull-off force: near 0 after a jump
ROWS_LEVEL = 0.02  # tuned on records by `make tuning`: of the pull-off force: on the base line
ROWS_SEVERAL = 5  # tuned on records by `make tuning`: readings that no jump leaves
ROWS_FLAT = 0.2  # tuned on records by `make tuning`: of the pull-off force: standing still
ROWS_ADHESION = 6.0  # theory: standard deviations of normal noise that no reading of thousands reaches
ROWS_LONGER = 2.0  # choice: times as far as any curve stays near its beginning, a base line reaches
ROWS_NOISE = 3.0  # theory: standard deviations that one reading in 370 exceeds

ROWS_LARGEST_NOISE = 0.1  # tuned on records by `make tuning`: of the curve: rows in no order beyond it
ROWS_OPPOSITE = -0.3  # choice: correlation of columns of which one has the wrong sign
ROWS_ORDERED = 0.9  # choice: rank correlation of rows with their order, from which on they go one way
ROWS_SWING = 0.2  # choice: of the range of a column, the least way back that is a turn and no noise
ROWS_STAND = 3.0  # choice: of the usual step, up to which rows stand at the turn
ROWS_HELD = 12  # choice: rows that stand there, from which on they are a hold
HELD = "dwell"
ROWS_WAY = 5  # choice: rows between turns, of several; those of rows in no order are fewer
ROWS_BALANCE = 0.05  # tuned on records by `make tuning`: least ratio of the axes' relative scatters


@dataclass(frozen=True, eq=False)
class Points:
    """The rows to be fitted: ``values`` of the measured columns among a, delta [m], P [N], their ``rows`` in the curve.

    ``left_out``: sentences on rows that were not taken; ``baseline``: load reading out of contact [N], where it was
    recorded. ``edges``: of a cycle what the edge does at each row, as ``edges`` numbers it; None: all rows lie on one
    branch.
    """

    values: Mapping[str, Array]
    rows: Array
    left_out: tuple[str, ...]
    baseline: float | None
    edges: Array | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(name for name in COLUMNS if name in self.values)

    def __len__(self) -> int:
        return self.rows.size

    def at(self, chosen: Array) -> Points:
        """The ``chosen`` rows, a mask or numbers."""
        values = {name: column[chosen] for name, column in self.values.items()}
        edges = None if self.edges is None else self.edges[chosen]
        return replace(self, values=values, rows=self.rows[chosen], edges=edges)


def points_of(
    curve: Curve, segment: SegmentName | None, branch: BranchName, unknowns: int, zero: float | None
) -> Points:
    """The rows of ``curve`` to be fitted, in order of recording.

    ``segment = None``: both directions where the curve names them, of one alone where the other holds too few rows;
    else all. ``zero``: load reading of no load [N], None: unknown. InputError in one line where too few rows are left
    for ``unknowns`` free parameters.
    """
    of = partial(_rows_of, curve, branch=branch, unknowns=unknowns, zero=zero)
    points = _of_a_cycle(curve, segment, of) if EDGES.keys() & curve.segments() else of(segment)

    # Columns that do not vary, or that fall where others rise
    for name, column in points.values.items():
        if not np.ptp(column) > 0:
            raise InputError(f"{curve.where}: {name} has the same value {column[0]:g} in all rows")
    for one, two in itertools.combinations(points.values, 2):
        together = float(np.corrcoef(points.values[one], points.values[two])[0, 1])
        if together < ROWS_OPPOSITE:
            raise InputError(f"{curve.where}: {two} falls as {one} rises (correlation {together:.2f}): one of them has "
                             "the wrong sign; displacement into the specimen and compression are positive (--flip "
                             "delta, --flip P)")  # fmt: skip
    return points


def _rows_of(
    curve: Curve, segment: SegmentName | None, branch: BranchName, unknowns: int, zero: float | None
) -> Points:
    """As ``points_of``, whatever the signs."""
    if curve.segment is None and segment in EDGES:
        curve.only(segment)  # which refuses
    chosen = np.ones(len(curve), dtype=bool)
    if curve.segment is not None:
        chosen = np.isin(curve.segment, list(EDGES) if segment == "both" else [segment or "retract"])
        if segment is not None and not chosen.any():
            raise InputError(f'{curve.where}: segment "{segment}" is empty (segments: {", ".join(curve.segments())})')
        chosen = chosen if chosen.any() else ~chosen
    values = {name: column[chosen] for name in COLUMNS if (column := getattr(curve, name)) is not None}
    if len(values) < 2:
        raise InputError(f"{curve.where}: a fit needs two of a, delta, P, got {', '.join(values) or 'none'}")
    level = 0.0 if zero is None or "P" not in values else zero
    if zero is None and {"P", "delta"} <= values.keys():
        # The load reading at the smallest displacements, where it stands still as out of contact: a base line is flat
        # and parted from the curve by a jump; a curve is not
        P, delta = values["P"], values["delta"]
        far = P[np.argsort(delta)[: max(5, P.size // 50)]]
        flat, lowest = float(np.median(far)), float(np.min(P))
        before = delta < delta[int(np.argmin(P))]
        between = before & (P < flat - 0.1 * (flat - lowest)) & (P > flat - 0.5 * (flat - lowest))
        level = flat if np.ptp(far) < ROWS_FLAT * (flat - lowest) and between.sum() < 3 else 0.0
    touching = in_contact(values, level)
    baseline = None
    if "P" in values and not touching.all():
        level = baseline = float(np.median(values["P"][~touching]))
    if branch == "compressive" and "P" not in values:
        raise InputError(f"{curve.where}: the compressive branch cannot be selected without the load")
    taken = touching & (values["P"] > level) if branch == "compressive" else touching
    counts = {"of other segments": ~chosen, "out of contact": ~touching, "of the adhesive part": touching & ~taken}
    words = tuple(f"{n} row{'s' if n > 1 else ''} {why}" for why, rows in counts.items() if (n := int(rows.sum())))
    least = max(ROWS_LEAST, 2 * unknowns)
    if taken.sum() < least:
        out = f" ({', '.join(words)} left out)" if words else ""
        raise InputError(f"{curve.where}: {int(taken.sum())} rows to fit{out}, at least {least} are needed")
    values = {name: column[taken] for name, column in values.items()}
    return Points(values, np.flatnonzero(chosen)[taken], words, baseline)


def _of_a_cycle(curve: Curve, segment: SegmentName | None, rows_of: Callable[[SegmentName], Points]) -> Points:
    """The rows of both directions of ``curve``, or of the wanted one, as ``rows_of`` gives those of one."""
    parts: dict[str, Points] = {}
    reasons: list[str] = []
    for kind, edge in EDGES.items():
        if segment not in (None, "both", kind) or (segment != kind and kind not in curve.segments()):
            continue
        try:
            part = rows_of(kind)
            parts[kind] = replace(part, edges=np.full(len(part), edge))
        except InputError as error:
            reasons += error.lines
    if not parts:
        raise InputError(reasons[0])
    first, *others = parts.values()
    if not others:
        return replace(first, left_out=(*first.left_out, *(one.removeprefix(f"{curve.where}: ") for one in reasons)))
    words = [f"{name}: {words}" for name, part in parts.items() for words in part.left_out if "segments" not in words]
    rows, edges = (np.concatenate([getattr(part, name) for part in parts.values()]) for name in ("rows", "edges"))
    values = {name: np.concatenate([part.values[name] for part in parts.values()]) for name in first.values}
    baseline = others[0].baseline if first.baseline is None else first.baseline
    return Points(values, rows, tuple(words), baseline, edges)


def orient(curve: Curve) -> Curve:
    """The curve with words for its directions by the order of its rows, where no column has any and they go into the
    specimen and out again; several times, which is said."""
    driven = curve.delta if curve.delta is not None else curve.P
    if curve.segment is not None or driven is None:
        return curve
    turn, sure = int(np.argmax(driven)), driven if curve.a is None or curve.delta is not None else curve.a
    if (words := _alternating(sure, driven)) is not None:
        note = (
            f"{1 + np.count_nonzero(words[1:] != words[:-1])} branches by the order of rows, loading and unloading in "
        )
        note += "turn; if they are others, name them in a column branch"
        return replace(curve, segment=words, flags=(*curve.flags, note))
    parts = sure[: turn + 1], -sure[turn:]
    if min(part.size for part in parts) <= ROWS_LEAST or min(map(_rising, parts)) < ROWS_ORDERED:
        return curve
    words = np.where(np.arange(len(curve)) <= turn, APPROACH, RETRACT)
    # A hold at the turn is of neither direction: all its rows are one state, by whose depth the radius of an edge that
    # rests from there on changes the loads to second order only, a valley without an end
    held = np.flatnonzero(driven > driven[turn] - ROWS_STAND * np.median(np.abs(np.diff(driven))))
    if held.size > ROWS_HELD:
        words[held[0] + 1 : held[-1]] = HELD
    return replace(curve, segment=words)


def _alternating(column: Array, driven: Array) -> Array | None:
    """A word for the direction of each row of a ``column`` that turns several times, as what is ``driven`` does; None
    where it does not, or its rows are in no order between turns."""
    starts = _starts(column)
    if len(starts) < 2:
        return None
    first_up = column[starts[0] - 1] > column[0]
    ends = [0, *starts, column.size]
    for i in range(1 if first_up else 2, len(starts) + 1, 2):  # at the top a contact may rest while its load falls
        ends[i] = ends[i - 1] + int(np.argmax(driven[ends[i - 1] : ends[i + 1]])) + 1
    ways = [column[first:end] for first, end in itertools.pairwise(ends)]
    signs = [1 if (i % 2 == 0) == first_up else -1 for i in range(len(ways))]
    if min(way.size for way in ways) < ROWS_WAY:
        return None
    if min(_rising(sign * way) for sign, way in zip(signs, ways, strict=True)) < ROWS_ORDERED:
        return None
    return np.repeat([APPROACH if sign > 0 else RETRACT for sign in signs], [way.size for way in ways])


def _starts(column: Array) -> list[int]:
    """The rows at which a ``column`` begins to go the other way: after the largest, and after the least or at it, where
    that is nearer to the next row than to the one before, as where contact was lost and is made anew."""
    values, least = column.tolist(), ROWS_SWING * float(np.ptp(column))
    starts: list[int] = []
    low, high, way = 0, 0, 0
    for i, value in enumerate(values):
        low, high = (i if value < values[low] else low), (i if value > values[high] else high)
        if way >= 0 and values[high] - value > least:
            starts += [high + 1] * way
            low, way = i, -1
        elif way <= 0 and value - values[low] > least:
            anew = way < 0 and values[low - 1] > values[low + 1]
            starts += [low if anew else low + 1] * -way
            high, way = i, 1
    return starts


def _rising(column: Array) -> float:
    """Rank correlation of a ``column`` with the order of its rows."""
    return float(np.corrcoef(np.argsort(np.argsort(column)), np.arange(column.size))[0, 1])


def in_contact(values: Mapping[str, Array], level: float) -> Array:
    """Mask of the rows in contact: not of a base line at the load reading ``level`` [N]; of radius > 0 where read.

    The base line lies at displacements below that of the least load. Contact is lost in a jump, on whose way lie few
    readings. Many of them there are a curve that a stiff device follows further, as on thin layers: then only what
    stands near the base line is out of contact. Where no adhesion stands out of the noise, the base line lies below the
    displacement from which on all loads do.
    """
    size = next(iter(values.values())).size
    if "a" in values:
        return values["a"] > 0
    touching = np.ones(size, dtype=bool)
    if not {"delta", "P"} <= set(values):
        return touching
    P, delta, noise = values["P"], values["delta"], noise_from_third_differences(values["P"])
    lowest = int(np.argmin(P))
    force = level - P[lowest]
    if force > ROWS_ADHESION * noise or noise > ROWS_LARGEST_NOISE * np.ptp(P):
        beyond, load = delta < delta[lowest], (P - level) / force
        risen, standing = load > -ROWS_LOST, load > -max(ROWS_NOISE * noise / force, ROWS_LEVEL)
        jump = (beyond & risen & ~standing).sum() < ROWS_SEVERAL
        return ~(beyond & (risen if jump else standing))
    quiet = np.abs(P - level) <= ROWS_NOISE * noise

    # A base line is half of a direction or more, or several rows at the smallest displacements that reach farther than
    # a load that grows with the third power of the depth, as on a thin layer, stays so near
    order, near = np.argsort(delta, kind="stable"), ROWS_NOISE * noise / max(float(np.ptp(P)), TINY)
    count = int(np.argmin(np.append(quiet[order], False)))
    reach = float(delta[order[count - 1]] - delta[order[0]])
    stands = count >= ROWS_SEVERAL and reach > ROWS_LONGER * near ** (1 / 3) * float(np.ptp(delta))
    return touching & ((delta > delta[quiet].max()) if quiet.sum() > FEWEST_ROWS // 2 or stands else True)


def noise_estimate(values: Mapping[str, Array], units: Values) -> dict[str, float]:
    """Standard deviation of the readings of each column from its third differences along the record.

    ``units``: size of the curve on each axis. Where rows are not in order of recording the differences show the curve
    rather than the noise: beyond ``ROWS_LARGEST_NOISE`` of the unit on any axis the units themselves are returned. No
    axis is taken as more exact than ``ROWS_BALANCE`` of the other, relative to the units.
    """
    relative = {name: noise_from_third_differences(values[name]) / units[name] for name in values}
    largest = max(relative.values())
    if largest > ROWS_LARGEST_NOISE or largest == 0:
        return {name: units[name] for name in values}
    return {name: max(part, ROWS_BALANCE * largest) * units[name] for name, part in relative.items()}


def noise_from_third_differences(column: Array) -> float:
    """Standard deviation of the noise in a ``column`` (n,), in its unit: the median size of third differences, which
    for independent normal noise scatter sqrt(20) times as much; infinite below 5 rows."""
    if column.size <= 4:
        return np.inf
    return median(np.abs(np.diff(column, 3))) / (STATISTICS_NORMAL_MEDIAN * math.sqrt(20))


# --------------------------------------------------------------------------------------------------
# The statistical model of a record: what an instrument reads at contact radius a, and how far a record lies from it.
#
# delta_read = delta0 + delta(a) + compliance P(a) P_read = P0 + P(a) a_read = a
#
# Every measured point has its own unknown contact radius. At its foot point the distance vector is normal to the
# curve of readings, so that these unknowns drop out of the problem (variable projection): a change of the parameters
# moves the distance by the normal part of the change of the readings alone. With two columns that derivative is
# exact; with three it leaves out the turning of the normal plane, which does not enter the gradient.

# Limits of the search for foot points on the curve of readings; radii by their logs.
FOOT_POINT_VERTICES = 400  # tuned on records by `make tuning`: of the polyline that starts the foot points
FOOT_POINT_BEYOND_LAST = 0.4  # tuned on records by `make tuning`: beyond the series, on the way to a solution
FOOT_POINT_BELOW_FOLD = 0.5  # tuned on records by `make tuning`: below the radius of stationary displacement

FOOT_POINT_LONGEST_STEP = 0.1  # choice: guard, some vertices
FOOT_POINT_LEAST_BEND = 0.2  # choice: guard, of the squared speed along the curve, where a point is far off it
FOOT_POINT_CLOSE = 1e-6  # theory: errors of the distance are its square


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings at the ``values`` of the parameters, SI.

    ``columns``: those of a, delta, P that are measured; each is divided by its scale in ``scales`` [m, m, N].
    ``drift``: of w or of the moduli along the record; ``edge``: what it does, as ``edges`` numbers it.
    """

    members: Members
    values: Values
    columns: tuple[str, ...]
    scales: Array
    drift: Drift | None = None
    edge: int = RECEDING

    @cached_property
    def member(self) -> Member:
        """The curve behind the readings."""
        values = self.values
        if self.edge == RESTING:
            return RestingMember(self.members.plain, values["modulus"], values["a_turn"], self.drift)
        w = values["w_approach" if self.edge == ADVANCING else "w"]
        return self.members.member({**values, "w": w}, self.drift)

    def radii(self, u: Array) -> Array:
        """Contact radii [m]."""
        return self.member.along(u)[0][0]

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """Scaled readings and their first and second derivatives by u, each of shape (columns, n)."""
        value, first, second = self.member.along(u)
        zeros = self.values["delta0"], self.values["P0"]
        return self._read(value, *zeros), self._read(first), self._read(second)

    def by_parameters(self, u: Array, names: Sequence[str]) -> Array:
        """Derivatives of the scaled readings by parameters on their scales, shape (names, columns, n)."""
        one, zero = np.ones_like(u), np.zeros_like(u)
        rates = {name: self._read(by) for name, by in self.member.rates(u).items()}
        if self.edge == ADVANCING:
            rates["w_approach"] = rates.pop("w")
        rates |= {"delta0": self._scaled(zero, one, zero), "P0": self._scaled(zero, zero, one)}
        rates["compliance"] = self._scaled(zero, self.member.along(u)[0][2], zero)
        none = self._scaled(zero, zero, zero)
        return np.stack([rates.get(name, none) for name in names])

    def _read(self, states: Array, delta0: float = 0.0, P0: float = 0.0) -> Array:
        a, delta, P = states
        return self._scaled(a, delta0 + delta + self.values["compliance"] * P, P0 + P)

    def _scaled(self, a: Array, delta: Array, P: Array) -> Array:
        rows = {"a": a, "delta": delta, "P": P}
        return np.stack([rows[name] for name in self.columns]) / self.scales[:, None]


# ---------------------------------------------------------------------- foot points
@dataclass(frozen=True, eq=False)
class FootPoints:
    """Those of n points whose edge does the same, among all of the ``places``: ``u`` log of their places on the curve,
    ``residuals`` (k, n), scaled.

    Two columns: k = 1, the signed normal distance; three: k = 3, the distance vector. ``tangent``: unit vectors along
    the curve at the foot points (columns, n).
    """

    readings: Readings
    places: Array
    u: Array
    residuals: Array
    tangent: Array

    @property
    def a(self) -> Array:
        """Their contact radii [m]."""
        return self.readings.radii(self.u)

    def line(self) -> dict[str, Array]:
        """The curve of the readings by column, and its contact radii "a", SI."""
        readings, u = self.readings, arc(self.readings)
        low, high = float(self.u.min()), float(self.u.max())
        if readings.edge == ADVANCING:
            u = np.append(u[u < high], high)
        elif readings.edge == RESTING:
            u = np.array([low, high])
        else:
            end = max(float(np.exp(readings.members.plain.high)), float(self.a.max()))
            u = u[readings.radii(u) <= end]
        values = dict(zip(readings.columns, readings.along(u)[0] * readings.scales[:, None], strict=True))
        return {"a": readings.radii(u)} | values

    def rates(self, names: Sequence[str]) -> Array:
        """Derivatives of the residuals by parameters on their scales, shape (names, k, n)."""
        rates = self.readings.by_parameters(self.u, names)
        if len(self.readings.columns) == 2:
            return -np.einsum("cn,pcn->pn", _normal(self.tangent), rates)[:, None]
        along = np.einsum("cn,pcn->pn", self.tangent, rates)
        return -(rates - along[:, None] * self.tangent)


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of all points, each of one of the ``parts`` from the curve that its edge is on."""

    parts: tuple[FootPoints, ...]

    @property
    def readings(self) -> Readings:
        """Those of the edge that moves last."""
        return self.parts[-1].readings

    def at(self, edge: int) -> FootPoints:
        """Those of the points whose edge does this."""
        return next(part for part in self.parts if part.readings.edge == edge)

    def _together(self, columns: Sequence[Array]) -> Array:
        """Columns (..., n) of all points, in their order, from those of the parts."""
        if len(columns) == 1:
            return columns[0]
        return np.concatenate(columns, axis=-1)[..., np.argsort(np.concatenate([part.places for part in self.parts]))]

    @property
    def residuals(self) -> Array:
        return self._together([part.residuals for part in self.parts])

    @property
    def a(self) -> Array:
        """Contact radii of the foot points [m]."""
        return self._together([part.a for part in self.parts])

    @property
    def along(self) -> Array:
        """The order of the points along the path."""
        ways = (np.argsort(part.u)[:: -1 if part.readings.edge == RECEDING else 1] for part in self.parts)
        return np.concatenate([part.places[way] for part, way in zip(self.parts, ways, strict=True)])

    def jacobian(self, names: Sequence[str]) -> Array:
        """Derivatives of all residuals by parameters on their scales, shape (k n, names)."""
        return self._together([part.rates(names) for part in self.parts]).reshape(len(names), -1).T

    def line(self) -> dict[str, Array]:
        """The curve of the readings in one stroke, by column, and its contact radii "a", SI."""
        lines = [part.line() for part in self.parts]
        return {name: np.concatenate([line[name] for line in lines]) for name in lines[0]}


def foot_points(readings: Readings, points: Array, places: Array) -> FootPoints:
    """Nearest points of the curve to the scaled measured ``points`` (columns, all) of the ``places``."""
    from scipy.spatial import cKDTree

    points = points[:, places]
    radii = points[readings.columns.index("a")] * readings.scales[0] if "a" in readings.columns else None
    u = arc(readings, None if radii is None else float(radii.min()))
    u = u[cKDTree(readings.along(u)[0].T).query(points.T)[1]]  # of the nearest vertices
    for _ in range(MOST_SOLVES):  # Newton's method needs two or three
        X, first, second = readings.along(u)
        gap = points - X
        length2 = np.einsum("cn,cn->n", first, first)
        slope = np.einsum("cn,cn->n", first, gap)
        bend = length2 - np.einsum("cn,cn->n", second, gap)
        step = slope / np.maximum(bend, FOOT_POINT_LEAST_BEND * length2)
        step = np.clip(step, -FOOT_POINT_LONGEST_STEP, FOOT_POINT_LONGEST_STEP)
        u = u + step
        if np.max(np.abs(step)) < FOOT_POINT_CLOSE:
            break
    X, first, _ = readings.along(u)
    speed = np.sqrt(np.maximum(np.einsum("cn,cn->n", first, first), TINY))
    tangent, gap = first / speed, points - X
    if len(readings.columns) == 2:
        gap = np.einsum("cn,cn->n", _normal(tangent), gap)[None]
    return FootPoints(readings, places, u, gap, tangent)


def _normal(tangent: Array) -> Array:
    return np.stack([-tangent[1], tangent[0]])


def arc(readings: Readings, least: float | None = None) -> Array:
    """u of the vertices of the part of the curve on which foot points are sought, down to the ``least`` radius that was
    measured [m], if any."""
    return np.linspace(*readings.member.ends(FOOT_POINT_BELOW_FOLD, FOOT_POINT_BEYOND_LAST, least), FOOT_POINT_VERTICES)


# ---------------------------------------------------------------------- what is minimised
@dataclass(frozen=True, eq=False)
class ScaledDistances(State):
    """The ``distances`` at some unknowns as the search takes them."""

    distances: Distances


@dataclass(frozen=True, eq=False)
class Objective:
    """Scaled distances of ``points`` as a function of the ``parameters``, of which some are free."""

    body: FittedBody
    parameters: tuple[Parameter, ...]
    points: Points
    scales: Array
    drift: Drift | None = None

    @property
    def ranged(self) -> bool:
        """Whether adhesion has a range."""
        return any(parameter.name in RANGES for parameter in self.parameters)

    def holding(self, x: Values, *names: str) -> Objective:
        """The same objective with the parameters of these ``names`` fixed where they are in ``x``."""
        held = (replace(p, free=False, value=p.outer(x[p.name])) if p.name in names else p for p in self.parameters)
        return replace(self, parameters=tuple(held))

    def scaled(self, values: Values) -> dict[str, float]:
        """The ``values`` of the parameters, SI, on their scales."""
        return {p.name: p.inner(values[p.name]) for p in self.parameters}

    def values(self, x: Values) -> dict[str, float]:
        """The parameters ``x`` on their scales as values, SI."""
        return {p.name: p.outer(x[p.name]) for p in self.parameters}

    def at(self, begin: Values, y: Array) -> dict[str, float]:
        """All parameters on their scales: the unknowns ``y`` of the search, the others as in ``begin``."""
        return {**begin, **dict(zip(self.unknowns.names, (y * self.unknowns.scales).tolist(), strict=True))}

    def state(self, begin: Values, y: Array) -> ScaledDistances:
        """The residuals there."""
        distances = self.distances(self.at(begin, y))
        return ScaledDistances(distances.residuals.ravel(), partial(self.rates, distances), distances)

    def rates(self, distances: Distances) -> Array:
        """Derivatives of the residuals by the unknowns of the search."""
        return distances.jacobian(self.unknowns.names) * self.unknowns.scales

    def readings(self, x: Values, rated: bool = True) -> Readings:
        """The readings at the parameters ``x`` on their scales; where layers vary the body is solved anew, without
        their derivatives where not ``rated``."""
        values = self.values(x)
        own = {p.name: values[p.name] for p in self.parameters if p.of_body}
        varied = [p.name for p in self.parameters if p.of_body and p.free]
        body = self.body.rated(own, varied) if rated and varied else self.body.with_values(own)
        return Readings(body.members(self.ranged), values, self.points.columns, self.scales, self.drift)

    def distances(self, x: Values, rated: bool = True) -> Distances:
        """The distances of the points from the ``readings``."""
        readings, edges = self.readings(x, rated), self.points.edges
        edges = np.full(len(self.points), RECEDING) if edges is None else edges
        target = np.stack([self.points.values[name] for name in readings.columns]) / self.scales[:, None]
        each = ((replace(readings, edge=edge), np.flatnonzero(edges == edge)) for edge in np.unique(edges))
        return Distances(tuple(foot_points(part, target, places) for part, places in each))

    @cached_property
    def unknowns(self) -> Unknowns:
        """Of the search, in units by the nonadhesive body at half of its largest radius: delta, P, and w that shifts
        it by its own displacement."""
        family = self.body.family
        D, _, H, _ = family.at(np.array([family.high - math.log(2)]))[0][:, 0]
        w = family.natural_work
        return Unknowns(self.parameters, {"w": w, "w_approach": w, "delta0": D, "P0": H, "compliance": D / H})


# Limits of the search: where it starts, which starts it follows, which minimum is the answer.
# Least squares
SEARCH_CONVERGED_ROUGH = 1e-7  # choice: relative, of a robust loss, whose turn is an estimate, and of samples
SEARCH_EVALUATIONS = 200  # choice: guard
SEARCH_REACH = 7.0  # choice: guard, how far logs may move from their start
SEARCH_BODY_REACH = 9.0  # choice: guard, the same of layers from their nominal values
SEARCH_FAINT = 1e-8  # theory: w > 0, in natural units: at 0 the shift by its root has no derivative by w
# Starts
SEARCH_NODES = 200  # tuned on records by `make tuning`: vertices of a curve that is tried
SEARCH_BEYOND = 1.2  # choice: of log a, how far beyond a series that can be extended curves are tried
SEARCH_SLIGHTLY = 0.05  # choice: the same of one that cannot
SEARCH_SHAPES = 24  # tuned on records by `make tuning`: values of sqrt(w/s) that are tried
SEARCH_FACTORS = 24  # tuned on records by `make tuning`: values of s that are tried
SEARCH_READINGS = 60  # tuned on records by `make tuning`: rows that starts are compared with
SEARCH_ALTERNATIVES = 4  # tuned on records by `make tuning`: starts kept for each body
SEARCH_LOAD_ZEROS = (0.0, -0.3, 0.3, -0.8, 0.8)  # choice: zeros of the load, in ranges of the loads
# Factors of nominal values where one or two parameters of layers are free; of more only the nominal values.
SEARCH_SCANNED: Mapping[int, Mapping[str, tuple[float, ...]]] = {  # choice: factors that least squares bridges
    1: {"E": (0.05, 0.2, 1.0, 4.0, 16.0), "h": (0.2, 0.45, 1.0, 2.2, 5.0)},
    2: {"E": (0.1, 1.0, 10.0), "h": (0.3, 1.0, 3.0)},
}
SEARCH_LOOKED_AT = 8  # tuned on records by `make tuning`: starts whose cost is computed in full
SEARCH_FOLLOWED = 4  # tuned on records by `make tuning`: starts that are followed to their minimum

# Ranges over the displacement that adhesion adds at JKR's pull-off; Tabor numbers 0.3, 1, 3, 10:
SEARCH_RANGES = (1.0, 0.3, 0.1, 0.03)  # choice: least squares bridges what lies between
SEARCH_HALVINGS = 2  # choice: of the steps next to the least, whose valley may be as narrow as one
SEARCH_FOLLOWED_RANGES = 2  # choice: of them that are followed to their minimum

SEARCH_SPAN = 5.0  # choice: of the log of a range from its start: beyond, all is a rigid sphere or JKR
# Cycles
SEARCH_SHARES = (0.75, 0.5)  # choice: of a way back, what may recede if the rest is at rest
SEARCH_WORTH = 16.0  # theory: fall of chi^2 by a turn and a choice of rows that chance brings once in 2000
SEARCH_NEARER = 16.0  # theory: square of four standard deviations, beyond which 6e-5 of normal noise lies
# Minima, in sizes of the curve
SEARCH_LEAST_SIZE = 0.05  # choice: of the data's range, the least size of a curve
SEARCH_NEAR = 1e-3  # tuned on records by `make tuning`: residuals so small that no other start is tried
SEARCH_NOISE = 2.0  # theory: standard deviations of the readings that leave nothing to explain
SEARCH_FAR = 0.1  # tuned on records by `make tuning`: noise that hides whether a fit is good
SEARCH_ALIEN = 0.5  # choice: residuals that are no fit at all
# Radii
SEARCH_PAST_END = 1.02  # choice: how far the data may reach beyond a series, as noise does
# choice: of the radii that the data reach, where a body is solved anew, and how far starts may reach beyond a
# series before it is
SEARCH_ROOM = 1.25
# of the largest radius, to which the series must begin at most; theory: the depth there is 1e-6 of the largest
SEARCH_SMALLEST = 1e-3
SEARCH_LEAST_USED = 0.5  # choice: part of the series below which it is solved anew to smaller radii


# ---------------------------------------------------------------------- least squares
@dataclass(frozen=True, eq=False)
class Minimum:
    """The point of least sum of losses of an ``objective``: ``x`` all parameters on their scales, ``least`` by the
    unknowns of the search."""

    objective: Objective
    x: Values
    least: Least

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name there, SI."""
        return self.objective.values(self.x)

    @property
    def distances(self) -> Distances:
        """The distances there."""
        assert isinstance(self.least.state, ScaledDistances)
        return self.least.state.distances

    @property
    def cost(self) -> float:
        """Half the sum of the losses."""
        return self.least.cost

    @property
    def width(self) -> float:
        """At which the robust loss turns, in scaled units."""
        return self.least.problem.width

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Names of parameters that end on a bound."""
        free = zip(self.objective.unknowns.names, self.least.at_bound, strict=True)
        return tuple(name for name, on_bound in free if on_bound)


def minimise(objective: Objective, start: Values, loss: Loss = "linear", width: float = 1.0) -> Minimum:
    """The least sum of squares (or of a robust ``loss`` that turns at ``width``) from the parameters ``start`` on their
    scales.

    Where the data do not determine the unknowns the search may creep along a valley that has no lowest point, and
    whether it stops there is a matter of round-off: it is given up after so many evaluations, and the minimum is marked
    as one whose search did not end.
    """
    unknowns = objective.unknowns
    y = np.array([start[name] for name in unknowns.names]) / unknowns.scales
    splines = objective.ranged or any(parameter.of_body for parameter in unknowns.free)
    close = ROUNDED if splines else SETTLED  # curves of layers and ranges are good to 1e-8 themselves
    close = close if loss == "linear" else max(close, SEARCH_CONVERGED_ROUGH)
    # Logs stay near their start, those of layers around their nominal values, as far as the user's bounds let them
    free, about = unknowns.free, {}
    for p, x in zip(free, y.tolist(), strict=True):
        if p.of_body:
            about[p.name] = p.inner(objective.body.nominal(p.name)), SEARCH_BODY_REACH
        elif p.name in RANGES:
            about[p.name] = x, SEARCH_SPAN
    low, high = unknowns.bounds(y, SEARCH_REACH, about)
    faint = np.array([SEARCH_FAINT if p.kind == "positive" else -math.inf for p in free])
    low = np.maximum(low, np.minimum(faint, high / 2))
    room = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(y), 1.0))  # the trust region wants some
    problem = LeastSquares(partial(objective.state, start), (low, high), close, 0.0, SEARCH_EVALUATIONS, loss, width)
    least = problem.least(np.clip(y, low + 1e-8 * room, high - 1e-8 * room))
    return Minimum(objective, objective.at(start, least.x), least)


def _minima(objective: Objective, starts: Iterable[Values], held: Sequence[str]) -> list[Minimum]:
    """The same from each of these ``starts``, the parameters ``held`` there, but where a range takes the surfaces
    beyond the body."""
    minima = []
    for x in starts:
        with contextlib.suppress(*[JkrError] * objective.ranged):
            minima.append(minimise(objective.holding(x, *held), x))
    return minima


def robust(minimum: Minimum, loss: Loss) -> Minimum:
    """The minimum of a robust loss from that of least squares on; its turn is set twice by the residuals' scatter."""
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * max(robust_scale(minimum.distances.residuals), 1e-12)
        minimum = minimise(minimum.objective, minimum.x, loss, width)
    return minimum


# ---------------------------------------------------------------------- starts
@dataclass(frozen=True)
class Start:
    """Values of parameters to begin with, SI, by name; ``reach``: the largest contact radius [m] of the data with
    them; ``cost``: mean square distance in units of the data's ranges, for comparison of starts."""

    values: Values
    reach: float
    cost: float


def starts(family: Family, points: Points, known: Values, beyond: bool) -> list[Start]:
    """The best starting values, best first; InputError where no curve of the series resembles the data.

    ``known``: the values that are fixed, SI. ``beyond``: curves that go beyond the series count too.
    """
    if "a" in points.columns:
        return [_with_radii(family, points, known)]
    delta, P = points.values["delta"], points.values["P"]
    zeros: Sequence[float] = [part * float(np.ptp(P)) for part in SEARCH_LOAD_ZEROS]
    if "P0" in known or points.baseline is not None:
        zeros = [known.get("P0", points.baseline or 0.0)]

    # A few readings spread over those that are stable under load control: not beyond the least load, if enough
    rows = np.flatnonzero(delta >= delta[int(np.argmin(P))])
    rows = rows if rows.size >= ROWS_LEAST else np.arange(P.size)
    some = rows[evenly(rows.size, SEARCH_READINGS)]

    # sqrt(w/s) of curves that are pulled off at radii across the series, and of almost no adhesion
    u = np.linspace(family.low, family.high + (SEARCH_BEYOND if beyond else SEARCH_SLIGHTLY), SEARCH_NODES)
    (D, T, H, V), (dD, dT, dH, dV), _ = family.at(u)
    shapes = np.unique((dH / dV)[dH / dV > 0])
    shapes = np.append(0.0, shapes[np.linspace(0, shapes.size - 1, min(SEARCH_SHAPES, shapes.size)).astype(int)])
    candidates = list[Start]()
    for P0, shape in itertools.product(zeros, shapes):
        stable = slice(int(np.argmin(H - shape * V)), None)
        branch = u[stable], *((X - shape * Y)[stable] for X, Y in ((D, T), (H, V), (dD, dT), (dH, dV)))
        candidates += _of_shape(float(shape), branch, delta[some], P[some] - P0, {**known, "P0": P0})
    candidates.sort(key=lambda start: start.cost)
    if not candidates:
        raise InputError("no curve of the solution resembles the data: check signs, units and the indenter")
    return candidates[:SEARCH_ALTERNATIVES]


def _of_shape(shape: float, branch: tuple[Array, ...], delta: Array, P: Array, known: Values) -> Iterator[Start]:
    """The best start for the few factors s of all moduli that are possible with sqrt(w/s) = ``shape``, if any.

    ``branch``: that of the curve at s = 1 which is stable under load control, by increasing load: log a, displacement
    and load, and their derivatives by log a.
    """
    u, depth, loads, by_depth, by_loads = branch
    if "modulus" in known:
        factors = np.array([known["modulus"]])
    elif "w" in known and shape > 0:
        factors = np.array([known["w"] / shape**2])
    else:
        end = P.max() if P.max() >= -P.min() else P.min()
        some = loads[np.linspace(0, loads.size - 1, SEARCH_FACTORS).astype(int)]
        factors = end / some[some * end > 0]
    factors = factors[np.isfinite(factors) & (factors > 0)]
    if loads.size < 4 or factors.size == 0:
        return
    compliance = known.get("compliance") or 0.0
    load = P / factors[:, None]
    model = np.interp(load, loads, depth)
    slope = np.interp(load, loads, by_depth / np.maximum(by_loads, 1e-30 * by_loads.max()))
    force, length = np.ptp(P), np.ptp(delta)
    weight = 1 / (length**2 + (slope / factors[:, None] * force) ** 2)
    gap = delta - compliance * P - model
    zero = np.sum(weight * gap, axis=1) / np.sum(weight, axis=1)
    zero = np.full(factors.size, known["delta0"]) if "delta0" in known else zero
    beyond = (load - np.clip(load, loads[0], loads[-1])) * factors[:, None] / force
    cost = np.mean(weight * (gap - zero[:, None]) ** 2 + beyond**2, axis=1)
    best = int(np.argmin(cost))
    s = float(factors[best])
    reach = float(np.exp(np.interp(load[best].max(), loads, u)))
    yield Start(_values(s, shape**2 * s, zero[best], known["P0"], compliance), reach, float(cost[best]))


def _values(modulus: float, w: float, delta0: float, P0: float, compliance: float) -> dict[str, float]:
    named = {"modulus": modulus, "w": w, "delta0": delta0, "P0": P0, "compliance": compliance}
    return {name: float(value) for name, value in named.items()}


def _with_radii(family: Family, points: Points, known: Values) -> Start:
    """The start by measured radii: the load is linear in s, sqrt(w s), P0; the displacement in sqrt(w/s), delta0."""
    (D, T, H, V), _, _ = family.at(np.clip(np.log(points.values["a"]), family.low - 0.5, family.high + 0.5))
    s, w, P0, delta0 = (known.get(name) for name in ("modulus", "w", "P0", "delta0"))
    compliance, one, gaps, off = known.get("compliance") or 0.0, np.ones_like(D), [], np.zeros_like(D)
    if (load := points.values.get("P")) is not None:
        fitted, pull, P0 = _linear_fit([H, -V, one], load, [None, None, P0])
        s = max(fitted, 1e-3 * float(np.ptp(load) / np.ptp(H))) if s is None else s
        w, off = max(pull, 0.0) ** 2 / s if w is None else w, load - P0
        gaps.append((off - s * H + np.sqrt(w * s) * V) / np.ptp(load))
    s = 1.0 if s is None else s
    if (delta := points.values.get("delta")) is not None:
        own = delta - D - compliance * off
        v, delta0 = _linear_fit([-T, one], own, [None if w is None else math.sqrt(w / s), delta0])
        w = max(v, 0.0) ** 2 * s if w is None else w
        gaps.append((own - delta0 + np.sqrt(w / s) * T) / np.ptp(delta))
    assert w is not None
    reach = float(points.values["a"].max())
    return Start(_values(s, w, delta0 or 0.0, P0 or 0.0, compliance), reach, float(np.mean(np.square(gaps))))


def _linear_fit(columns: list[Array], wanted: Array, known: list[float | None]) -> list[float]:
    """Coefficients of the linear least squares by ``columns``, each in units of its size, but for those ``known``."""
    free, coefficients = [value is None for value in known], np.array([value or 0.0 for value in known])
    matrix = np.stack(columns, axis=1)
    size = np.linalg.norm(matrix[:, free], axis=0)
    left = wanted - matrix @ coefficients
    coefficients[free] = np.linalg.lstsq(matrix[:, free] / size, left, rcond=None)[0] / size
    return coefficients.tolist()


# ---------------------------------------------------------------------- cycles
def search(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit to one branch, or to both of a cycle: from that to the approach on.

    InputError where no curve of the body comes near the data, or where they leave the radii of its series.
    """
    if points.edges is None:
        return _of_a_branch(body, points, settings)
    ranges = {name: float(np.ptp(column)) for name, column in points.values.items()}
    noise = noise_estimate(points.values, ranges) | dict(settings.noise)  # in order of recording
    settings = replace(settings, noise=noise)
    edges = set(points.edges)
    if RECEDING not in edges:
        return _of_a_branch(body, replace(points, edges=None), settings)
    if ADVANCING in edges:
        return _there_and_back(body, points, settings)
    # Of a way back the edge may rest at first: with the turn only where the rows ask for one
    minimum = _of_a_branch(body, replace(points, edges=None), settings.without(OF_A_CYCLE))
    objective = replace(minimum.objective, parameters=settings.parameters, points=points)
    variance = minimum.cost / max(len(points) - minimum.least.x.size, 1)
    order = np.argsort(points.values["P" if "P" in points.columns else "delta"])
    for share in SEARCH_SHARES:
        some = np.sort(order[: round(share * len(points))])
        with contextlib.suppress(JkrError):
            values = minimise(replace(minimum.objective, points=points.at(some)), minimum.x).values
            rested = _settled(objective, values | {"a_turn": _turn(objective, values, int(order[-1]))})
            minimum = rested if minimum.cost - rested.cost > SEARCH_WORTH * variance else minimum
    return minimum


def _there_and_back(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit to both directions, from that to the approach on."""
    assert points.edges is not None
    forth = replace(points.at(points.edges == ADVANCING), edges=None)
    law = settings.range
    plain = settings.without(RANGES)
    into = _of_a_branch(body, forth, plain.of_the_approach)
    objective = replace(into.objective, parameters=plain.parameters, points=points)
    values = into.values | {"a_turn": float(into.distances.a.max())}
    values["w_approach"] = values["w"]
    shifts = np.append(0.0, np.geomspace(math.sqrt(UNSEEN), 1, SEARCH_NODES // 8)) ** 2
    natural = objective.body.family.natural_work * values["modulus"]
    tried = [{**values, "w": values["w_approach"] + shift * natural} for shift in shifts]
    values = min(tried, key=lambda values: _assigned(objective, values)[0])
    jkr = _settled(objective, values)
    if law is None:
        return jkr
    values, objective = jkr.values, replace(objective, parameters=settings.parameters)
    tried = list(_ranged(body, values, law.name)) if law.free else [{**values, law.name: float(law.value or 0.0)}]
    tried.sort(key=lambda values: _assigned(objective, values)[0])
    minima = [_settled(objective, values) for values in tried[:SEARCH_FOLLOWED_RANGES]]
    return min(minima, key=lambda item: item.cost)


def _turn(objective: Objective, values: Values, top: int) -> float:
    """The contact radius [m] at the turn of an edge that rests at the row ``top``: as it was read, or that which its
    load and displacement belong to."""
    read = {name: float(column[top]) for name, column in objective.points.values.items()}
    if "a" in read:
        return read["a"]
    family = objective.body.with_values({name: v for name, v in values.items() if ":" in name}).family
    u = np.linspace(family.low, family.high, SEARCH_NODES)
    D, T, H, V = family.at(u)[0]
    P = read["P"] - values["P0"]
    v = (D - read["delta"] + values["delta0"] + values["compliance"] * P) / T
    return float(np.exp(u[np.argmin(np.abs(values["modulus"] * (H - v * V) - P))]))


def _settled(objective: Objective, values: Values) -> Minimum:
    """The minimum from ``values`` on at which each row lies on the edge that it was fitted with; w is fixed where no
    row of a cycle recedes, the turn where none rests, or where a search by it does not end: of a contact that hardly
    adheres it changes the loads to second order only, and steps of first order leap to and fro over the best one."""
    parameters, points, x = objective.parameters, _assigned(objective, values)[1], objective.scaled(values)
    leaps = False
    for _ in range(MOST_SOLVES):
        assert points.edges is not None
        idle = [name for edge, name in ((RECEDING, "w"), (RESTING, "a_turn"))
                if edge not in points.edges or (leaps and name == "a_turn")]  # fmt: skip
        objective = replace(objective, parameters=parameters, points=points).holding(x, *idle)
        minimum = minimise(objective, x)
        if not minimum.least.ended and "a_turn" not in idle:
            leaps, x = True, objective.scaled(minimum.values)
            objective = objective.holding(x, "a_turn")
            minimum = minimise(objective, x)
        before, points = points, _assigned(objective, minimum.values)[1]
        x = objective.scaled(minimum.values)
        if np.all(points.edges == before.edges):
            break
    return minimum


def _assigned(objective: Objective, values: Values) -> tuple[float, Points]:
    """The cost of these ``values``, and the points with each row of the way back at rest, where on the straight line it
    is nearest to G < w and the receding edge is not clearly nearer, else on that."""
    points, x = objective.points, objective.scaled(values)
    assert points.edges is not None
    back = np.flatnonzero(points.edges > ADVANCING)
    each = []
    for edge in (RESTING, RECEDING):
        edges = points.edges.copy()
        edges[back] = edge
        each.append(replace(objective, points=replace(points, edges=edges)).distances(x, rated=False))
    still, (off, moving) = each[0].at(RESTING), (np.sum(distances.residuals**2, axis=0)[back] for distances in each)
    assert isinstance(still.readings.member, RestingMember)
    end = math.sqrt(values["w"] / values["modulus"]) / still.readings.member.unit
    rests = (still.u <= end) & (off < moving + SEARCH_NEARER)
    edges[back] = np.where(rests, RESTING, RECEDING)
    cost = float(np.sum(each[0].residuals ** 2) - np.sum(off) + np.sum(np.where(rests, off, moving)))
    return cost, replace(points, edges=edges)


# ---------------------------------------------------------------------- bodies and radii
def _of_a_branch(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit, on the body solved anew to other radii where the data need it and it may be.

    InputError where no curve of the body comes near the data, or where they leave the radii of its series.
    """
    body = _among_radii(body, points)
    for _ in range(MOST_SOLVES):
        tried = _all_starts(body, points, settings)
        high = float(body.series.a[-1])
        if body.extensible and tried[0].reach > high * SEARCH_ROOM:
            body = body.to_radius(SEARCH_ROOM * tried[0].reach)
            continue
        minimum = _best(body, points, settings, tried)
        reach = float(minimum.distances.a.max())
        least, low = _least(minimum), float(body.series.a[0])
        if body.extensible and not SEARCH_LEAST_USED * high <= reach <= high * SEARCH_PAST_END:
            body = body.to_radius(SEARCH_ROOM * reach)
        elif body.extensible and least < low / SEARCH_PAST_END:
            body = body.down_to(max(least / SEARCH_ROOM, body.series.a0 * (1 + SAME)))
        else:
            break
    else:
        minimum = _best(body, points, settings, _all_starts(body, points, settings))
    _check_reach(minimum.objective.body, _least(minimum), float(minimum.distances.a.max()))
    return minimum


def _least(minimum: Minimum) -> float:
    """The least contact radius [m] that the series must hold: of the data, but for what is so small that no row tells
    it. A curve of finite range begins at first touch, whatever the series does."""
    a = minimum.distances.a
    return math.inf if minimum.objective.ranged else max(float(a.min()), SEARCH_SMALLEST * float(a.max()))


def _among_radii(body: FittedBody, points: Points) -> FittedBody:
    """The body with a series that reaches the measured radii, where most of them lie far outside it.

    InputError where it may not be solved anew: starts would be sought where the series says nothing.
    """
    if "a" not in points.columns:
        return body
    least, middle, most = (float(a) for a in np.quantile(points.values["a"], (0.0, 0.5, 1.0)))
    low, high = (float(a) for a in body.series.a[[0, -1]])
    if low / SEARCH_ROOM <= middle <= high * SEARCH_ROOM:
        return body
    if body.extensible:
        return body.to_radius(SEARCH_ROOM * most)
    _check_reach(body, least, most)
    return body


def _check_reach(body: FittedBody, least: float, reach: float) -> None:
    """Refuse contact radii of the data outside those of the series, but for noise."""
    low, high = (float(a) for a in body.series.a[[0, -1]])
    above = reach > high * SEARCH_PAST_END
    if low / SEARCH_PAST_END <= least and not above:
        return
    end, remedy = (high, "increase [loading] radius") if above else (low, "begin at smaller radii")
    radii, last = f"{show(least, 'length')} to {show(reach, 'length')}", show(end, "length")
    raise InputError(f"the data reach contact radii of {radii}, the solution ends at {last}: {remedy}, or fit with the "
                     "case file; or units or signs are wrong")  # fmt: skip


def _all_starts(body: FittedBody, points: Points, settings: Settings) -> list[Start]:
    """Starts on every body that is tried, with the values of its own parameters, best first."""
    known = {p.name: p.value for p in settings.parameters if not (p.of_body or p.free) and p.value is not None}
    tried = []
    reason: JkrError | None = None

    # Of the body's own parameters fixed values, and some around the nominal ones of those that are free
    layers = [p for p in settings.parameters if p.of_body]
    fixed = {p.name: float(p.value) for p in layers if not p.free and p.value is not None}
    free = [p for p in layers if p.free]
    factors = (SEARCH_SCANNED[len(free)][p.name[0]] if len(free) in SEARCH_SCANNED else (1.0,) for p in free)
    for chosen in itertools.product(*factors):
        values = {p.name: body.nominal(p.name) * factor for p, factor in zip(free, chosen, strict=True)}
        if set(chosen) - {1.0} and not all(p.low <= values[p.name] <= p.high for p in free):
            continue
        own = fixed | {p.name: float(np.clip(values[p.name], p.low, p.high)) for p in free}
        try:
            near = starts(body.with_values(own).family, points, known, body.extensible)
            tried += [replace(start, values={**start.values, **own}) for start in near]
        except JkrError as error:
            reason = error
    if not tried:
        assert reason is not None
        raise reason
    tried.sort(key=lambda start: start.cost)
    law = settings.range
    if law is None or not law.free:
        return tried
    return [replace(tried[0], values=values) for values in _ranged(body, tried[0].values, law.name)]


def _ranged(body: FittedBody, values: Values, name: str) -> Iterator[dict[str, float]]:
    """These values with ranges (or tensions, as ``name`` says) from those of a rigid sphere to those of JKR."""
    s = values["modulus"]
    w = max(values["w"], NOTICEABLE * body.family.natural_work * s)
    for part in SEARCH_RANGES:
        length = part * body.family.neck(s, w)
        yield {**values, "w": w, name: length if name == "range" else w / length}


def _best(body: FittedBody, points: Points, settings: Settings, tried: list[Start]) -> Minimum:
    """The minimum from the nearest start; where it stays far from the data the lowest of those from all starts.

    Starts are those from the data and, if any, the user's. InputError where all stay far.
    """
    known = {p.name: p.value for p in settings.parameters if p.value is not None}  # fixed, or the user's to begin with
    fixed = {p.name: known[p.name] for p in settings.parameters if not p.free}
    objective = Objective(body, settings.parameters, points, np.ones(len(points.columns)))
    begins = [objective.scaled({**start.values, **fixed}) for start in tried[:SEARCH_LOOKED_AT]]
    # The size of a start's curve on each axis: its pull-off, or a part of the data's range where that is larger
    readings = objective.readings(begins[0], rated=False)
    offsets = {"delta": readings.values["delta0"], "P": readings.values["P0"]}
    sizes = {column: float(np.ptp(points.values[column])) for column in points.columns}
    for column, row in zip(points.columns, readings.along(arc(readings))[0], strict=True):
        if column in offsets:  # a radius has no zero of its own: its size is its range
            sizes[column] = max(offsets[column] - float(np.min(row)), SEARCH_LEAST_SIZE * sizes[column])
    scales = noise_estimate(points.values, sizes) | dict(settings.noise)
    objective = replace(objective, scales=np.array([scales[name] for name in points.columns]))
    if len(known) > len(fixed):
        begins.append(objective.scaled({**tried[0].values, **known}))
    far = max(scales[name] / sizes[name] for name in points.columns)
    minima: list[Minimum] = []
    failed: JkrError | None = None
    for x in _by_cost(objective, begins)[: SEARCH_FOLLOWED_RANGES if objective.ranged else SEARCH_FOLLOWED]:
        try:
            minima.append(minimise(objective, x))
        except JkrError as error:
            if not objective.ranged:
                raise
            failed = error
            continue
        distance = robust_scale(minima[-1].distances.residuals)
        noise = distance < SEARCH_NOISE and far < SEARCH_FAR  # where the record shows it
        if (noise or distance * far < SEARCH_NEAR) and not objective.ranged:  # whose range may make it better
            break
    if failed is not None and not minima:
        raise failed
    minimum = min(minima, key=lambda item: item.cost)
    distance = far * robust_scale(minimum.distances.residuals)
    if distance > SEARCH_ALIEN:
        raise InputError(f"the best fit leaves {distance:.0%} of the signal unexplained: check units, signs, contact "
                         "point, the indenter and the layers")  # fmt: skip
    return minimum


def _by_cost(objective: Objective, starts: Sequence[Values]) -> Sequence[Values]:
    """Starts sorted by their cost; where layers or a range vary, after a fit of the other parameters alone. Half way,
    in the logarithm of the range, from the lowest to its neighbours on both sides there are more."""

    def cost(x: Values) -> float:
        """The sum of squares; infinite where a range takes the surfaces beyond the body."""
        with contextlib.suppress(*[JkrError] * objective.ranged):
            return float(np.sum(objective.distances(x, rated=False).residuals ** 2))
        return math.inf

    own = [p.name for p in objective.unknowns.free if p.of_body or p.name in RANGES]
    if not own or len(own) == len(objective.unknowns.free):
        return sorted(starts, key=cost)
    minima = _minima(objective, starts, own)
    for _ in range(SEARCH_HALVINGS if objective.ranged and minima else 0):
        law = next(p.name for p in objective.parameters if p.name in RANGES)
        ordered = sorted(minima, key=lambda minimum: minimum.x[law])
        best = min(range(len(minima)), key=lambda i: ordered[i].cost)
        middle, others = ordered[best].x, (*ordered[max(best - 1, 0) : best], *ordered[best + 1 : best + 2])
        minima += _minima(objective, [{**middle, law: (middle[law] + other.x[law]) / 2} for other in others], own)
    return [minima[i].x for i in np.argsort([minimum.cost for minimum in minima])] if minima else starts

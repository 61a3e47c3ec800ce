"""The rows of a measured curve that lie on the adhesive curve, and the scatter of their readings."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import FEWEST_ROWS, TINY, Array, InputError
from ...data import APPROACH, RETRACT, Curve
from .family import ADVANCING, RECEDING
from .settings import BranchName, SegmentName
from .statistics import TUNING as STATISTICS

COLUMNS = ("a", "delta", "P")
EDGES: dict[SegmentName, int] = {"approach": ADVANCING, "retract": RECEDING}  # of directions


@dataclass(frozen=True)
class RowsTuning:
    """Limits that separate rows out of contact from rows of the curve, and noise from the curve."""

    least: int = 8  # choice: points, and at least twice as many as free parameters
    lost: float = 0.3  # tuned on records by `make tuning`: of the pull-off force: near 0 after a jump
    level: float = 0.02  # tuned on records by `make tuning`: of the pull-off force: on the base line
    several: int = 5  # tuned on records by `make tuning`: readings that no jump leaves
    flat: float = 0.2  # tuned on records by `make tuning`: of the pull-off force: standing still
    adhesion: float = 6.0  # theory: standard deviations of normal noise that no reading of thousands reaches
    longer: float = 2.0  # choice: times as far as any curve stays near its beginning, a base line reaches
    noise: float = 3.0  # theory: standard deviations that one reading in 370 exceeds

    largest_noise: float = 0.1  # tuned on records by `make tuning`: of the curve: rows in no order beyond it
    opposite: float = -0.3  # choice: correlation of columns of which one has the wrong sign
    ordered: float = 0.9  # choice: rank correlation of rows with their order, from which on they go one way
    swing: float = 0.2  # choice: of the range of a column, the least way back that is a turn and no noise
    way: int = 5  # choice: rows between turns, of several; those of rows in no order are fewer
    balance: float = 0.05  # tuned on records by `make tuning`: least ratio of the axes' relative scatters


TUNING = RowsTuning()


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

    def joined(self, other: Points, left_out: tuple[str, ...]) -> Points:
        """These rows and then those of another direction."""
        both = ((getattr(part, name) for part in (self, other)) for name in ("rows", "edges"))
        rows, edges = (np.concatenate(list(columns)) for columns in both)
        values = {name: np.concatenate([column, other.values[name]]) for name, column in self.values.items()}
        return Points(values, rows, left_out, other.baseline if self.baseline is None else self.baseline, edges)

    def at(self, chosen: Array) -> Points:
        """The ``chosen`` rows, a mask or numbers."""
        values = {name: column[chosen] for name, column in self.values.items()}
        return replace(
            self, values=values, rows=self.rows[chosen], edges=None if self.edges is None else self.edges[chosen]
        )


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
    _check_signs(curve, points.values)
    return points


def _rows_of(
    curve: Curve, segment: SegmentName | None, branch: BranchName, unknowns: int, zero: float | None
) -> Points:
    """As ``points_of``, whatever the signs."""
    chosen = _of_segment(curve, segment)
    values = {name: column[chosen] for name in COLUMNS if (column := getattr(curve, name)) is not None}
    if len(values) < 2:
        raise InputError(f"{curve.where}: a fit needs two of a, delta, P, got {', '.join(values) or 'none'}")
    level = 0.0 if "P" not in values else _level(values) if zero is None else zero
    touching = in_contact(values, level)
    baseline = None
    if "P" in values and not touching.all():
        level = baseline = float(np.median(values["P"][~touching]))
    taken = touching & _of_branch(curve, values, branch, level)
    words = _left_out({
        "of other segments": chosen.size - chosen.sum(),
        "out of contact": (~touching).sum(),
        "of the adhesive part": (touching & ~taken).sum(),
    })  # fmt: skip
    least = max(TUNING.least, 2 * unknowns)
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
    return first.joined(others[0], tuple(words))


def directed(curve: Curve) -> Curve:
    """The curve with words for its directions by the order of its rows, where no column has any and they go into the
    specimen and out again; several times, which is said."""
    driven = curve.delta if curve.delta is not None else curve.P
    if curve.segment is not None or driven is None:
        return curve
    turn, sure = int(np.argmax(driven)), driven if curve.a is None or curve.delta is not None else curve.a
    if (words := _alternating(sure, driven)) is not None:
        ways = 1 + np.count_nonzero(words[1:] != words[:-1])
        note = f"{ways} branches by the order of rows, loading and unloading in turn; if they are others, name them in "
        note += "a column branch"
        return replace(curve, segment=words, flags=(*curve.flags, note))
    parts = sure[: turn + 1], -sure[turn:]
    if min(part.size for part in parts) <= TUNING.least or min(map(_rising, parts)) < TUNING.ordered:
        return curve
    words = np.where(np.arange(len(curve)) <= turn, APPROACH, RETRACT)
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
    if min(way.size for way in ways) < TUNING.way:
        return None
    if min(_rising(sign * way) for sign, way in zip(signs, ways, strict=True)) < TUNING.ordered:
        return None
    return np.repeat([APPROACH if sign > 0 else RETRACT for sign in signs], [way.size for way in ways])


def _starts(column: Array) -> list[int]:
    """The rows at which a ``column`` begins to go the other way: after the largest, and after the least or at it, where
    that is nearer to the next row than to the one before, as where contact was lost and is made anew."""
    values, least = column.tolist(), TUNING.swing * float(np.ptp(column))
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


def _left_out(counts: Mapping[str, int]) -> tuple[str, ...]:
    return tuple(f"{count} row{'s' if count > 1 else ''} {why}" for why, count in counts.items() if count)


def _of_branch(curve: Curve, values: Mapping[str, Array], branch: BranchName, level: float) -> Array:
    if branch == "compressive" and "P" not in values:
        raise InputError(f"{curve.where}: the compressive branch cannot be selected without the load")
    size = next(iter(values.values())).size
    return values["P"] > level if branch == "compressive" else np.ones(size, dtype=bool)


def _of_segment(curve: Curve, segment: SegmentName | None) -> Array:
    if curve.segment is None:
        if segment in EDGES:
            curve.only(segment)  # which refuses
        return np.ones(len(curve), dtype=bool)
    words = list(EDGES) if segment == "both" else [segment or "retract"]
    chosen = np.isin(curve.segment, words)
    if segment is not None and not chosen.any():
        raise InputError(f'{curve.where}: segment "{segment}" is empty (segments: {", ".join(curve.segments())})')
    return chosen if chosen.any() else ~chosen


def in_contact(values: Mapping[str, Array], level: float) -> Array:
    """Mask of the rows in contact: not of a base line at the load reading ``level`` [N]; of radius > 0 where read.

    The base line lies at displacements below that of the least load (see ``_lost``); where no adhesion stands out of
    the noise, below the displacement from which on all loads do.
    """
    size = next(iter(values.values())).size
    if "a" in values:
        return values["a"] > 0
    touching = np.ones(size, dtype=bool)
    if not {"delta", "P"} <= set(values):
        return touching
    P, delta, noise = values["P"], values["delta"], third_differences(values["P"])
    lowest = int(np.argmin(P))
    force = level - P[lowest]
    if force > TUNING.adhesion * noise or noise > TUNING.largest_noise * np.ptp(P):
        return ~_lost(delta < delta[lowest], (P - level) / force, TUNING.noise * noise / force)
    quiet = np.abs(P - level) <= TUNING.noise * noise
    # a base line is half of a direction or more, or stands longer than any curve that begins there
    line = quiet.sum() > FEWEST_ROWS // 2 or _stands(delta, quiet, TUNING.noise * noise / max(float(np.ptp(P)), TINY))
    return touching & ((delta > delta[quiet].max()) if line else True)


def _stands(delta: Array, quiet: Array, near: float) -> bool:
    """Whether the rows at the smallest displacements ``delta`` [m] that are ``quiet``, within the part ``near`` of the
    load's range, are several and reach farther than a load that grows with the third power of the depth, as on a thin
    layer, stays so near."""
    order = np.argsort(delta, kind="stable")
    count = int(np.argmin(np.append(quiet[order], False)))
    if count < TUNING.several:
        return False
    reach = float(delta[order[count - 1]] - delta[order[0]])
    return reach > TUNING.longer * near ** (1 / 3) * float(np.ptp(delta))


def _lost(beyond: Array, P: Array, near: float) -> Array:
    """Mask of those rows ``beyond`` the least load that have lost contact; ``P`` in units of the pull-off force.

    Contact is lost in a jump, on whose way lie few readings. Many of them there are a curve that a stiff device follows
    further, as on thin layers: then only what stands ``near`` the base line is out of contact.
    """
    risen, standing = P > -TUNING.lost, P > -max(near, TUNING.level)
    jump = (beyond & risen & ~standing).sum() < TUNING.several
    return beyond & (risen if jump else standing)


def _level(values: Mapping[str, Array]) -> float:
    """The load reading at the smallest displacements, where it stands still as out of contact; else 0.

    A base line is flat and parted from the curve by a jump; a curve is not.
    """
    if "delta" not in values:
        return 0.0
    P, delta = values["P"], values["delta"]
    far = P[np.argsort(delta)[: max(5, P.size // 50)]]
    level, least = float(np.median(far)), float(np.min(P))
    before = delta < delta[int(np.argmin(P))]
    between = before & (P < level - 0.1 * (level - least)) & (P > level - 0.5 * (level - least))
    return level if np.ptp(far) < TUNING.flat * (level - least) and between.sum() < 3 else 0.0


def _check_signs(curve: Curve, values: Mapping[str, Array]) -> None:
    """Refuse columns that do not vary, or that fall where others rise."""
    for name, column in values.items():
        if not np.ptp(column) > 0:
            raise InputError(f"{curve.where}: {name} has the same value {column[0]:g} in all rows")
    for one, two in itertools.combinations(values, 2):
        together = float(np.corrcoef(values[one], values[two])[0, 1])
        if together < TUNING.opposite:
            raise InputError(
                f"{curve.where}: {two} falls as {one} rises (correlation {together:.2f}): one of them has the wrong "
                "sign; displacement into the specimen and compression are positive (--flip delta, --flip P)"
            )


def scatter(values: Mapping[str, Array], units: Mapping[str, float]) -> dict[str, float]:
    """Standard deviation of the readings of each column from its third differences along the record.

    ``units``: size of the curve on each axis. Where rows are not in order of recording the differences show the curve
    rather than the noise: beyond ``largest_noise`` of the unit on any axis the units themselves are returned. No axis
    is taken as more exact than ``balance`` of the other, relative to the units.
    """
    relative = {name: third_differences(values[name]) / units[name] for name in values}
    largest = max(relative.values())
    if largest > TUNING.largest_noise or largest == 0:
        return {name: units[name] for name in values}
    return {name: max(part, TUNING.balance * largest) * units[name] for name, part in relative.items()}


def third_differences(column: Array) -> float:
    """Standard deviation of the noise in a ``column`` (n,), in its unit: the median size of third differences, which
    for independent normal noise scatter sqrt(20) times as much; infinite below 5 rows."""
    if column.size <= 4:
        return np.inf
    return float(np.median(np.abs(np.diff(column, 3)))) / (STATISTICS.normal_median * math.sqrt(20))

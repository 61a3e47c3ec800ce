"""The parts of a force curve by its numbers alone: directions, base line, first touch, jumps, pull-off.

The body is unknown here, and zeros are arbitrary. Each direction is read from its far end, where the indenter is
free: there the load is a straight line, and what leaves that line is contact or adhesion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from ..base.errors import NOTICEABLE, Estimate, InputError, Unknown, counted, known
from ..base.numerics import FEWEST_ROWS, ROUNDED, ROUNDING, SAME, Array, median
from ..base.process import REMEMBERED
from ..base.units import show
from ..series.vocabulary import NO_UNIT
from .curve import APPROACH, AS_DEPTH, NOT_SUBTRACTED, RETRACT, Curve
from .free_rows import FreeRows, Side, free_rows
from .instruments import presses_outward
from .lockstep import Flow, alone, ask, together

# --------------------------------------------------------------------------------------------------
# A detector at its limit.

# What no load of a contact does.
SATURATION_SATURATED = 5  # choice: rows in succession at the very same largest load that count
SATURATION_FREE = 0.1  # choice: of the way, its far end: rows that rest at the same load there are a base line
SATURATION_LEVELS = 10.0  # choice: of a converter, by which the load must have come there within as many rows


def saturation(curve: Curve) -> dict[str, Array]:
    """The rows at which the load stands still at its "largest" or "smallest" value while the device moves on, as it
    does at a detector's limit: the load is at least that large there; none of a base line."""
    if curve.P is None or curve.delta is None:
        return {}
    found = {}
    for name, end in (("largest", float(curve.P.max())), ("smallest", float(curve.P.min()))):
        rows = curve.P == end
        if np.count_nonzero(rows) >= SATURATION_SATURATED and _standing_still(curve.P, curve.device, rows):
            found[name] = rows
    return found


def saturation_words(curve: Curve, saturated: Mapping[str, Array]) -> tuple[str, ...]:
    """A sentence on each end of the loads at which they are ``saturated``."""
    return tuple(
        f"{np.count_nonzero(rows)} rows hold the same {name} load, {show(float(curve.load[rows][0]), 'load')}, as at "
        "the limit of a detector"
        for name, rows in saturated.items()
    )


def _standing_still(P: Array, z: Array, at_end: Array) -> bool:
    """Whether the longest run of rows ``at_end`` of the loads is long, and came there by more than some steps of the
    converter."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at_end, [False]]).astype(int)))
    first, last = edges[::2], edges[1::2]
    i = int(np.argmax(last - first))
    count = int(last[i] - first[i])
    held = z[first[i] : last[i]]
    if count < SATURATION_SATURATED or count == P.size or np.abs(held - held[0]).max() < NOTICEABLE * np.ptp(z):
        return False
    if held.min() < z.min() + SATURATION_FREE * np.ptp(z):
        return False
    # A load that turns there by itself leaves it slowly: by a parabola that rests within a level for so many rows
    # changes by 4.5 levels in as many more, on the side of no jump.
    sides = P[max(first[i] - count, 0) : first[i] + 1], P[last[i] - 1 : last[i] + count]
    left = min((float(np.ptp(side)) for side in sides if side.size > count // 2 + 1), default=float(np.ptp(P)))
    return left > SATURATION_LEVELS * float(np.diff(np.unique(P)).min())


DWELL, PERMANENT_SET = "dwell", "permanent set"

# Where a departure counts; lengths are shares of the rows of a direction.
RECORD_NORMAL = 1.4826  # theory: standard deviation over median deviation of normal noise
RECORD_BLOCK = 1 / 200  # tuned on records, by `make constants`: rows averaged in the search for slow deviations
# choice: the part of a direction that is free if anything is; of the whole way, least of both ways that make two
# directions of one segment
RECORD_FAR = 0.1
RECORD_INSIDE = (0.5, 0.8)  # choice: of the free part found before, what surely is free; the last was tuned, 0.8
RECORD_SIGMAS = 6.0  # theory: 1e-9 of normal noise lies beyond, of rows and of what they leave a line by
RECORD_LEAST = 0.005  # choice: of the range of the load, below which no departure counts
# choice: of the range of the load next to the free part, below which no row leaves its line; a pull-off may be 0.002
RECORD_BENT = 0.001
RECORD_WHOLE = 0.1  # theory: off whole numbers, of steps between levels; a few that are none are so by chance
RECORD_RUN = 3  # tuned on records, by `make constants`: blocks in succession that must agree
# choice: of all rows, the range of the load, or the way: what is no direction, no jump, no motion, no place of
# steps
RECORD_SMALL = 0.02
RECORD_HALF = 0.5  # theory: of a way, a step, the least load or what a line leaves: more is the larger part of it
# choice: of the rows, least length of a tether, and how many may be spikes; relative change of its load, beyond the
# error; no contact's is below 0.1 by then
RECORD_TETHER = 0.05
RECORD_STRAIGHT = 1.3  # choice: of the noise, what the line through them leaves at most
# tuned on records, by `make constants`: just below the half of a step in speed that smoothing leaves at its place
RECORD_STILL = 0.45
RECORD_RING = 12  # choice: rows of a window in which a device is seen to ring after a jump
RECORD_BESIDE = (4, 8, 16, 32, 64, 128)  # choice: rows on either side that tell the largest tension
RECORD_CHANCE = 3.0  # choice: standard deviations of chi^2, beyond which a parabola is none
RECORD_RUNG = 2.0  # theory: of the usual size, 3.5 standard deviations of that of a window of normal noise
RECORD_WINDOWS = 4  # choice: such windows at least, of which the usual size is the median
RECORD_SMOOTH = 4  # choice: degree of a polynomial that follows the end of a contact and no kink
RECORD_WAVY = 0.03  # choice: of the range of the load, waviness of a base line that is flagged
# choice: what a tilt may make of the largest load over the depth of contact, and the largest load or tension at
# least of what it makes over all of the base line
RECORD_STEEP = 0.2
CUTS = 200  # choice: places at which a direction may be cut into a line and a curve
ALONGSIDE = 30_000  # choice: rows of directions that are read at once; more no longer saves time
RECORD_WANDERING = 2.0  # theory: way over distance of a device that reverses once


@dataclass(frozen=True)
class Segment:
    """A stretch of rows ``first`` to ``last`` (both included): "approach", "dwell", "retract" or the file's word."""

    kind: str
    first: int
    last: int

    @property
    def rows(self) -> slice:
        return slice(self.first, self.last + 1)

    def __len__(self) -> int:
        return self.last - self.first + 1


@dataclass(frozen=True)
class BaseLine:
    """The load without contact, ``offset`` + ``tilt`` (z - ``at``) [N, N/m, m] over the device's position z, through
    ``rows`` free rows.

    ``noise``: standard deviation of a row [N]; ``waviness``: of what is left of slow deviations from the line [N];
    ``curved``: the rows are part of the curve that follows, not of a line; ``rounding``: standard deviation [N] of
    readings in steps of a converter, which is noise at least.
    """

    offset: float
    tilt: float
    at: float
    rows: int
    noise: float
    waviness: float
    curved: bool
    rounding: float = 0.0

    def __call__(self, position: Array) -> Array:
        return self.offset + self.tilt * (position - self.at)

    @property
    def least(self) -> float:
        """The smallest load [N] that stands out from the base line."""
        return RECORD_SIGMAS * math.hypot(self.noise, self.waviness)


@dataclass(frozen=True)
class ForceJump:
    """A sudden change of the load by ``step`` [N] at the device's ``position`` [m], between two rows near ``row``."""

    row: int
    position: float
    step: float


@dataclass(frozen=True)
class Direction:
    """One segment in which the device moves one way, with its base line and its events.

    ``touch``: position of the device [m] where contact begins (approach) or has ended (retract), ``touch_err`` its
    half-width; ``largest``: largest load over the base line [N]; ``adhesion``: largest tension below it [N], with its
    standard error, at ``adhesion_at`` [m]. ``border``: from the far end inwards, the last row that is free for sure and
    the first that is in contact for sure: after a jump, else where tension is largest, as what lets go slowly beyond is
    no contact of an elastic body. ``way, depth``: how far the device moves in all, and beyond touch [m]. ``free``: how
    many rows from the far end on may be free, up to the largest ``jump`` [N] to tension, 0 without one. ``jumps``: to
    tension, seen from the far end inwards; ``steps``: all other sudden changes of the load; ``ringing``: rows after the
    jump in which the device still rings, which belong to no side.
    """

    segment: Segment
    base: BaseLine
    touch: Estimate
    touch_err: float
    largest: float
    adhesion: Estimate
    adhesion_err: float
    adhesion_at: float
    jumps: tuple[ForceJump, ...]
    steps: tuple[ForceJump, ...]
    border: tuple[int, int]
    way: float
    depth: float
    free: int
    jump: float
    ringing: int = 0

    @property
    def begins_free(self) -> bool:
        """Whether there is a base line: not a few rows only, not contact's own end, not as steep as contact is between
        its largest tension and its largest load, and not the straight line of an edge at rest."""
        enough = self.base.rows >= RECORD_FAR * len(self.segment) and not self.base.curved
        rise, off = abs(self.base.tilt) * self.way * self.base.rows / len(self.segment), known(self.adhesion) or 0.0
        level = RECORD_STEEP * rise <= max(self.largest, off)
        return enough and level and abs(self.base.tilt) * self.depth <= RECORD_STEEP * (self.largest + off)

    @property
    def based(self) -> bool:
        """Whether touch and loads over the base line mean anything: it is there, or nothing but a base line."""
        return self.begins_free or isinstance(self.touch, Unknown)


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """A measured curve taken apart; ``flags``: what is wrong with it, in a word or two, and a sentence on each;
    ``spikes``: rows that stand alone off the others, ``saturated``: rows at a detector's limit: they count for nothing.
    ``held``: what the free rows hold beside a base line, which is taken off the loads of the ``curve``.
    """

    curve: Curve
    segments: tuple[Segment, ...]
    directions: tuple[Direction, ...]
    flags: dict[str, str]
    spikes: Array
    saturated: Array
    held: FreeRows | None = None

    def holding(self, held: FreeRows) -> ForceCurve:
        """The record with something else taken off its loads; base lines follow when it is fitted."""
        taken, signal = held.taken, held.of_signal
        if self.held is not None:
            taken, signal = taken - self.held.taken, signal - self.held.of_signal
        return replace(self.less(taken, signal), held=held)

    def less(self, taken: Array, of_signal: Array | float = 0.0) -> ForceCurve:
        """The record with ``taken`` off its loads [N], of which some is no force but an error of the signal."""
        curve = _less(self.curve, taken, of_signal)
        parts = [side.segment for side in self.directions]
        code = max((side.base.rounding for side in self.directions), default=0.0) * math.sqrt(12)
        sides = alone(_directions(curve.device, curve.load, parts, code))
        return replace(self, curve=curve, directions=sides)

    @property
    def ignored(self) -> Array:
        """The rows that count for nothing."""
        within = np.zeros(0, dtype=int) if self.held is None else self.held.spoilt
        return np.unique(np.concatenate([self.spikes, self.saturated, within]))

    def contact(self, side: Direction) -> Array:
        """The rows of a direction from contact on that count, from the far end inwards."""
        rows = np.arange(side.segment.first, side.segment.last + 1)
        rows = (rows if side.segment.kind == APPROACH else rows[::-1])[side.border[1] :]
        return rows[~np.isin(rows, self.ignored)]

    @property
    def rest(self) -> int:
        """How many rows belong to no segment."""
        return len(self.curve) - sum(map(len, self.segments))

    def direction(self, kind: str) -> Direction | None:
        """The first direction of a kind, "approach" or "retract"."""
        return next((item for item in self.directions if item.segment.kind == kind), None)


def _less(curve: Curve, taken: Array, of_signal: Array | float) -> Curve:
    """The curve less what was ``taken`` off its loads [N]: of forces the tip stays at its depth, of an error of the
    signal, ``of_signal``, the device stays where it is."""
    depth = None if curve.stiffness is None else curve.depth + of_signal / curve.stiffness
    return replace(curve, P=curve.load - taken, delta=curve.delta if depth is None else depth)


def segment_force_curve(curve: Curve) -> ForceCurve:
    """The parts of a measured curve; InputError where it holds no displacement and load, or too few rows."""
    return alone(examined(curve))


def segment_force_curves(curves: Sequence[Curve], quick: bool = False) -> list[ForceCurve | Exception]:
    """The parts of each of some curves, by ``segment_force_curve``; its error where one cannot be examined, whatever
    the others are. ``quick``: without what free rows hold beside a base line."""
    return together([examined(curve, quick) for curve in curves])


def examined(curve: Curve, quick: bool = False) -> Flow[ForceCurve]:
    """The parts of a measured curve, as a flow; InputError where it holds no displacement and load, or too few rows."""
    if curve.delta is None or curve.P is None:
        left_out = [f"{curve.where}: {flag}" for flag in curve.flags if NO_UNIT in flag]
        raise InputError([
            f"{curve.where}: a force curve needs displacement and load, the file has {', '.join(curve.measured)}"
            + ("; jkr fit takes contact radius and load" if curve.a is not None else ""), *left_out,
        ])  # fmt: skip
    if len(curve) < FEWEST_ROWS:
        raise InputError(
            f"{curve.where}: holds {counted(len(curve), 'row')}, at least {FEWEST_ROWS} are needed to look at"
        )
    whole, z, P, spikes = curve, curve.device, curve.P, _spikes(curve.P)
    if spikes.size:
        P = P.copy()
        P[spikes] = (P[spikes - 1] + P[spikes + 1]) / 2
        curve = replace(curve, P=P, delta=z if curve.stiffness is None else z - P / curve.stiffness)
        z = curve.device
    parts, by_load = _segments_by_motion(z, P) if curve.segment is None else (_named_segments(curve, z), False)
    sides = [part for part in parts if part.kind in (APPROACH, RETRACT) and len(part) >= FEWEST_ROWS]
    directions = yield from _directions(z, P, sides)
    code = resolution(whole.load)
    sunk = 0.0 if quick else _sunk(z, P, directions)
    held = None if quick else (yield from _free_rows(z, P, directions, code, curve.stiffness, sunk))
    saturated = saturation(curve)
    if held is not None:
        curve, whole = (_less(one, held.taken, held.of_signal) for one in (curve, whole))
        z, P = curve.device, curve.load
        directions = yield from _directions(z, P, sides, code)
    # What a reader should know before trusting anything that is fitted to this curve; the last sentence of a name.
    touched = [item for item in directions if not isinstance(item.touch, Unknown)]
    flags, kinds = list[tuple[str, str]](), [item.segment.kind for item in directions]
    for kind, other in ((APPROACH, RETRACT), (RETRACT, APPROACH)):
        if kind not in kinds:  # it is missing, or the record holds too little of it
            lack = f"only {other} rows" if other in kinds else "neither approach nor retraction"
            few = sum(len(part) for part in parts if part.kind == kind)
            flags.append((f"no {kind}", f"{few} of its rows, at least {FEWEST_ROWS} are needed" if few else lack))
    if directions and not touched:
        flags.append(("no contact", "the load never leaves its base line"))
    dent = _permanent_set(z, P, directions) if by_load else ()
    limits = np.flatnonzero(np.any([*saturated.values()], axis=0)) if saturated else spikes[:0]
    flags += [*(dent or _on_base_lines(P, touched)), *_on_jumps(touched, limits), *_on_signs(z, P, directions)]
    second = sum(level.of_contact for level in held.levels) if held is not None else 0
    flags += [("several contacts", f"{second + 1} jumps under tension in the {RETRACT}")] * bool(second)
    flags += [("saturated", f"{sentence}: they are left out") for sentence in saturation_words(curve, saturated)]
    return ForceCurve(whole, tuple(parts), directions, dict(flags), spikes, limits, held)


def _free_rows(
    z: Array, P: Array, directions: Sequence[Direction], code: float, stiffness: float | None, sunk: float
) -> Flow[FreeRows | None]:
    """What the free rows of the first approach and the first retraction hold beside a base line; ``code`` [N]: the step
    of the converter, ``sunk`` [m]: what the surface has sunk by in between."""
    sides = []
    for kind in (APPROACH, RETRACT):
        item = next((item for item in directions if item.segment.kind == kind), None)
        if item is None or isinstance(item.touch, Unknown):
            continue
        rows = np.arange(item.segment.first, item.segment.last + 1)[:: 1 if kind == APPROACH else -1]
        free, contact = rows[: item.free], rows[item.free :]
        sides.append(Side(kind, free, z[free], P[free], contact, item.jump, code, z[contact], P[contact]))
    return (yield from free_rows(sides, P.size, math.inf if stiffness is None else stiffness, sunk))


def _sunk(z: Array, P: Array, directions: Sequence[Direction]) -> float:
    """By how much the surface has sunk [m] where the load falls while the device stands still between approach and
    retraction, by the stiffness with which that begins; 0 where it does not fall by more than noise."""
    into, back = (next((side.segment for side in directions if side.segment.kind == kind), None)
                  for kind in (APPROACH, RETRACT))  # fmt: skip
    if into is None or back is None or back.first - into.last <= FEWEST_ROWS:
        return 0.0
    between = slice(into.last + 1, back.first)
    if float(np.ptp(z[between])) > RECORD_SMALL * float(np.ptp(z)):
        return 0.0  # no standstill
    loads, noise = P[between], max(side.base.noise for side in directions)
    size = max(loads.size // 10, 1)
    fall = float(loads[:size].mean() - loads[-size:].mean())
    first = slice(back.first, back.first + max(len(back) // 20, FEWEST_ROWS // 2))
    way, lost = z[first] - z[first].mean(), P[first] - P[first].mean()
    stiffness = float(way @ lost) / max(float(way @ way), 1e-300)
    falls = fall > RECORD_SIGMAS * noise * math.sqrt(2 / size) and fall > RECORD_LEAST * float(np.ptp(P))
    return fall / stiffness if falls and stiffness > 0 else 0.0


def _spikes(P: Array) -> Array:
    """Rows that leave the middle of their neighbours far beyond what the others do, and the lines through the two
    before and the two after to the same side; none where they are many. At a jump one of the lines holds, or they are
    apart."""
    bends = _bends(P)
    before, bend, after = bends[:-2], bends[1:-1], bends[2:]
    off = np.abs(bend) / 2
    rows = np.flatnonzero(off > RECORD_LEAST * float(P.max() - P.min()))
    before, bend, after, off = before[rows], bend[rows], after[rows], off[rows]
    least = np.minimum(np.abs(before), np.abs(after))
    alone = ((before > 0) == (after > 0)) & ((before > 0) != (bend > 0))
    rows = rows[alone & (least > RECORD_HALF * off) & (np.abs(before - after) < off)]
    if rows.size:
        rows = rows[np.abs(bends[rows + 1]) > RECORD_SIGMAS * _robust(bends)] + 2
    return rows if rows.size <= RECORD_TETHER * P.size else rows[:0]


def _named_segments(curve: Curve, delta: Array) -> list[Segment]:
    """Stretches of rows with the same word. One that turns back in its middle holds both directions, whatever it is
    called; rows of one direction at a standstill by the turn are a dwell."""
    words, P = curve.segment, curve.load
    assert words is not None
    edges = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist(), words.size]
    stretches = [Segment(str(words[first]), first, end - 1) for first, end in pairwise(edges)]
    parts: list[Segment] = []
    for part in stretches:
        inside = _segments_by_motion(delta[part.rows], P[part.rows])[0] if len(part) >= FEWEST_ROWS else []
        if len(inside) < 2:
            parts.append(part)
            continue
        moved = [item for item in inside if item.kind != DWELL]
        ways = {item.kind: float(np.ptp(delta[part.rows][item.rows])) for item in inside}
        both = len(moved) > 1 and min(ways[item.kind] for item in moved) > RECORD_FAR * float(np.ptp(delta))
        stood = len(moved) == 1 and ways.get(DWELL, math.inf) < RECORD_SMALL * ways[moved[0].kind]
        if both or (stood and moved[0].kind == part.kind):
            parts += [Segment(item.kind, part.first + item.first, part.first + item.last) for item in inside]
        else:
            parts.append(part)
    return parts


def _segments_by_motion(delta: Array, P: Array) -> tuple[list[Segment], bool]:
    """Approach, dwell and retraction by the motion alone: up to the turning point, at rest there, and back. Under load
    control the displacement follows little of an unloading that leaves a dent: where the load falls in a dwell in which
    the displacement recovers, the load tells the parts; whether it does."""
    parts = _parts_of_way(delta)
    dwell = next((part for part in parts if part.kind == DWELL), None)
    if dwell is None or len(dwell) < FEWEST_ROWS:
        return parts, False
    size = _block(len(dwell))
    moved, loads = (_blocks(v[dwell.rows], size) for v in (delta, P))
    least = max(RECORD_LEAST * float(np.ptp(delta)), RECORD_SIGMAS * _robust(np.diff(delta, 2)) / math.sqrt(6 * size))
    by_load = bool(loads[0] - loads[-1] > RECORD_FAR * np.ptp(P) and moved[0] - moved[-1] > least)
    return _parts_of_way(P) if by_load else parts, by_load


def _parts_of_way(delta: Array) -> list[Segment]:
    """The parts of what rises, rests and falls again."""
    n = delta.size
    window = _block(n)
    rows = np.empty(n + 2 * window)
    rows[:window], rows[window : n + window], rows[n + window :] = delta[0], delta, delta[-1]
    smooth = np.convolve(rows, np.full(2 * window + 1, 1 / (2 * window + 1)), "valid")
    turn = int(np.argmax(smooth))
    speed = np.empty(n)
    speed[1:-1] = (smooth[2:] - smooth[:-2]) / 2
    speed[0], speed[-1] = smooth[1] - smooth[0], smooth[-1] - smooth[-2]
    np.abs(speed, out=speed)
    # The speed at which half of the way is covered or less: dwells have no part in it, however long they last.
    ordered = np.sort(speed)
    way = np.cumsum(ordered)
    moving = speed >= RECORD_STILL * float(ordered[np.searchsorted(way, way[-1] / 2)])
    before, after = moving[:turn][::-1], moving[turn:]
    first = turn - 1 - int(before.argmax()) if before.any() else 0
    last = turn + int(after.argmax()) - 1 if after.any() else n - 1
    if last - first < RECORD_SMALL * n:
        first = last = turn
    if last == 0 and delta[0] == delta.max():  # retraction from the first row on
        first = last = -1
    parts = [Segment(APPROACH, 0, first), Segment(DWELL, first + 1, last), Segment(RETRACT, last + 1, n - 1)]
    return [part for part in parts if len(part) > RECORD_SMALL * n]


def _directions(z: Array, P: Array, parts: Sequence[Segment], code: float = 0.0) -> Flow[tuple[Direction, ...]]:
    """Base line, touch, adhesion and jumps of the directions that are ``parts`` of a record, as a flow; ``code`` [N]:
    the step of a converter at least, that loads of which something is taken off no longer show."""
    sides = [(z[part.rows], P[part.rows], part, code) for part in parts]
    return (yield from ask(_directions_of, sides))


def _directions_of(records: Sequence[Sequence[tuple[Array, Array, Segment, float]]]) -> list[tuple[Direction, ...]]:
    """The directions of each record, by their positions, loads and segments.

    Those of nearly equal rows together, as arrays (directions, places) from the far end inwards, which go on with their
    last rows. How many places follows from the rows of each alone, so that no sum depends on the others.
    """
    found: list[list[Any]] = [[None] * len(sides) for sides in records]
    alike: dict[tuple[int, int, int], list[tuple[int, int]]] = {}
    for i, sides in enumerate(records):
        for j, (x, *_) in enumerate(sides):
            step = 1 if _cuts(x.size).size < CUTS else 2 ** (x.size.bit_length() - 4)
            key = -(-x.size // step) * step, _block(x.size), _jump_width(x.size)
            alike.setdefault(key, []).append((i, j))
    for (size, _, _), places in alike.items():
        many = max(1, ALONGSIDE // size)
        for part in (places[k : k + many] for k in range(0, len(places), many)):
            of_each = [records[i][j] for i, j in part]
            rows, columns = np.array([x.size for x, *_ in of_each]), np.empty((2, len(part), size))
            for column, (z, P, side, _) in zip(columns.swapaxes(0, 1), of_each, strict=True):
                column[:, : z.size] = (z, P) if side.kind == APPROACH else (z[::-1], P[::-1])
                column[:, z.size :] = column[:, z.size - 1 : z.size]
            x, y, segments, codes = columns[0], columns[1], [one[2] for one in of_each], [one[3] for one in of_each]
            for (i, j), direction in zip(part, _side_by_side(x, y, rows, segments, codes), strict=True):
                found[i][j] = direction
    return [tuple(sides) for sides in found]


def _side_by_side(
    x: Array, y: Array, rows: Array, segments: Sequence[Segment], codes: Sequence[float]
) -> list[Direction]:
    """Base lines, touch, adhesion and jumps of directions whose positions and loads are the first ``rows`` of ``x, y``
    (directions, places), in the order from their far ends inwards, with the least steps of converters."""
    block, width = _block(int(rows[0])), _jump_width(int(rows[0]))
    roundings = [max(own) / math.sqrt(12) for own in zip(resolutions(y, rows), codes, strict=True)]
    ends = _ends_of_free_parts(x, y, rows)
    bases, off = _base_lines(x, y, ends, roundings, block)
    falls, rises = _sudden(off, rows, bases)
    # The load falls at once for the first time: a tether or a second contact holds beyond, however straight it is.
    sooner = np.array([
        min((first for first, _ in _runs(fall, width) if first >= RECORD_FAR * n), default=n)
        for fall, n in zip(falls, rows.tolist(), strict=True)
    ])  # fmt: skip
    again = np.flatnonzero(sooner < ends)
    if again.size:
        ends[again] = sooner[again]
        at = again.tolist()
        changed, off[again] = _base_lines(x[again], y[again], ends[again], [roundings[i] for i in at], block)
        fallen, risen = _sudden(off[again], rows[again], changed)
        for k, i in enumerate(at):
            bases[i], falls[i], rises[i] = changed[k], fallen[k], risen[k]
    for i in np.flatnonzero(_are_curved(x, y, rows, ends)).tolist():
        bases[i] = replace(bases[i], curved=True)
    return [
        _direction(x[i, :n], y[i, :n], off[i, :n], (falls[i], rises[i], width), bases[i], segments[i])
        for i, n in enumerate(rows.tolist())
    ]


def _direction(
    x: Array, y: Array, off: Array, sudden: tuple[list[int], list[int], int], base: BaseLine, segment: Segment
) -> Direction:
    """Touch, adhesion and jumps of one direction by its base line and the loads ``off`` it; ``sudden``: the rows
    from which on the load falls and rises at once, over so many rows."""
    order = 1 if segment.kind == APPROACH else -1
    row, error = _touch(x, off, base)
    touch: Estimate = float(x[row]) if row < x.size else Unknown("the load never leaves its base line")
    lowest = int(np.argmin(off))
    rows = range(segment.first, segment.last + 1)[::order]
    falls, others = _jumps(off, base, *sudden)
    tension, unsure = _largest_tension(x, off, base, lowest, falls)
    main = min(falls, key=lambda fall: off[fall[1]] - off[fall[0]], default=None)
    jump = 0.0 if main is None else float(off[main[1]] - off[main[0]])
    ringing = 0
    if main is not None:  # a lever rings after its jump, in time: inwards on the way in, outwards on the way out
        first = min(falls)
        if order > 0 and first != main and _ringing(y[first[1] :]):
            main, jump = first, float(off[first[1]] - off[first[0]])
        ringing = _ringing(y[main[1] :] if order > 0 else y[main[0] :: -1])
        rung = range(main[0], main[1] + ringing + 1) if order > 0 else range(main[0] - ringing, main[1] + 1)
        falls = [main, *(fall for fall in falls if fall[0] not in rung and fall[1] not in rung)]
        others = [step for step in others if step[0] not in rung and step[1] not in rung]
    falls = sorted(falls + _end_of_tether(off, base, falls))
    deepest = float(x.max())
    way = deepest - float(x.min())
    turn = deepest - RECORD_SMALL * way  # beyond, a change of drag is no event
    others = [(first, last) for first, last in others if x[last] < turn and not _by_motion(x, off, first, last)]
    jumps, steps = (
        tuple(ForceJump(rows[(i + j) // 2], float(x[(i + j) // 2]), float(off[j] - off[i])) for i, j in pairs)
        for pairs in (falls, others)
    )
    inner = falls[-1][1] if falls else row if isinstance(tension, Unknown) else max(lowest, row)
    border = min([row - 1, *(first for first, _ in falls)]), inner
    if main is not None and ringing:
        border = (border[0], max(inner, main[1] + ringing)) if order > 0 else (min(border[0], main[0] - ringing), inner)
    depth = deepest - float(x[min(row, x.size - 1)])
    loads = float(off.max()), tension, unsure, float(x[lowest])
    if main is not None:
        free = main[0] + 1
    elif order > 0:  # contact raises the load: free rows lie before the least of means of rows
        block = _block(off.size)
        free = int(np.argmin(_blocks(off, block))) * block
    else:
        free = border[0] + 1
    free -= 0 if order > 0 else ringing
    return Direction(segment, base, touch, error, *loads, jumps, steps, border, way, depth, max(free, 0), jump, ringing)


@lru_cache(maxsize=REMEMBERED)
def _parabolas(rows: int) -> tuple[Array, Array]:
    """The orthonormal polynomials of degree 0 to 2 at evenly spaced rows, (rows, 3), and the lengths of their rows: the
    standard error of a parabola there over that of a row."""
    columns = np.linalg.qr(np.vander(np.linspace(-1, 1, rows), 3))[0]
    return columns, np.linalg.norm(columns, axis=1)


def _largest_tension(
    x: Array, off: Array, base: BaseLine, lowest: int, falls: list[tuple[int, int]]
) -> tuple[Estimate, float]:  # fmt: skip
    """The largest tension [N] about the ``lowest`` row and its standard error: of the parabola through as many rows
    beside it, on the contact's side of a jump, as agree with what fewer tell (Lepski 1991). The least of many noisy
    rows alone would be too low. The base line errs there by what it is known to, and a jump lies between two rows."""
    if -off[lowest] <= base.least:
        return Unknown("no tension beyond the noise"), base.noise
    tension, error, wider, between = float(-off[lowest]), base.noise, base.noise, 0.0
    begins = max((inner for outer, inner in falls if outer < lowest), default=0)
    least_told, most_told = -math.inf, math.inf
    for half in RECORD_BESIDE:
        y = off[max(begins, lowest - half) : lowest + half + 1]
        if (dof := y.size - 3) < half // 2:
            continue
        parabolas, errors = _parabolas(y.size)
        smooth = parabolas @ (y @ parabolas)
        least, left = int(smooth.argmin()), y - smooth
        told, unsure = -float(smooth[least]), base.noise * float(errors[least])
        bends = float(left @ left) > base.noise**2 * (dof + RECORD_CHANCE * math.sqrt(2 * dof))
        if bends or not least_told <= told <= most_told:
            break
        tension, error, wider = told, wider, unsure  # a parabola may be off by what half as many rows cannot tell
        least_told, most_told = max(least_told, told - 2 * unsure), min(most_told, told + 2 * unsure)
        between = float(smooth[1] - smooth[0]) / 2 if least == 0 else 0.0
    free = x[: base.rows]
    away = float(x[lowest] - free.mean()) / (float(free.max() - free.min()) or 1.0)
    line = base.noise * math.sqrt((1 + 12 * away**2) / base.rows)
    return tension, math.hypot(error, line, base.waviness, between)


def _ringing(y: Array) -> int:
    """How many rows after a jump, in time, the load still swings to and fro, by second differences of windows of rows
    beside those of all that follow; 0 where it does not swing, or does not die away."""
    width = RECORD_RING
    bends = _bends(y[1:])
    count = bends.size // width
    if count < RECORD_WINDOWS:
        return 0
    windows = bends[: count * width].reshape(count, width)
    size = np.sqrt(np.einsum("ij,ij->i", windows, windows) / width)
    loud = size > RECORD_RUNG * median(size)
    if not loud[0]:
        return 0
    last = int(np.argmin(loud))  # windows that are loud without a gap
    swings = np.count_nonzero(np.diff(np.sign(bends[: last * width]))) >= last
    dies_away = loud.sum() < RECORD_HALF * count and size[0] >= size[max(last - 1, 0)]
    if not (swings and dies_away):
        return 0
    # Beyond, what a parabola leaves of wider windows shows swings that bend the load less than noise does.
    noise, wide = median(size) / math.sqrt(6), 2 * width
    parabola, _ = _parabolas(wide)
    parts = y[1 : 1 + (y.size - 1) // wide * wide].reshape(-1, wide)
    left = np.sqrt(np.mean((parts - parts @ parabola @ parabola.T) ** 2, axis=1))
    quiet = np.flatnonzero(left[last // 2 :] < RECORD_STRAIGHT * noise)
    rows = (last // 2 + int(quiet[0]) + 1) * wide if quiet.size else y.size
    return int(min(max(rows, (last + 1) * width), RECORD_HALF * y.size))


def in_succession(marked: Array) -> Array:
    """Whether each place begins a run of ``RECORD_RUN`` that are ``marked`` (a mask)."""
    places = max(marked.shape[-1] - RECORD_RUN + 1, 0)
    runs = marked[..., :places].copy()
    for shift in range(1, RECORD_RUN):
        runs &= marked[..., shift : shift + places]
    return runs


def _block(rows: int) -> int:
    """The number of rows of a block."""
    return max(1, round(rows * RECORD_BLOCK))


def _blocks(values: Array, size: int) -> Array:
    """Means of successive blocks of ``size`` rows along the last axis; what is left at the end is left out."""
    whole = values.shape[-1] // size * size
    return np.asarray(np.einsum("...i->...", values[..., :whole].reshape(*values.shape[:-1], -1, size)) / size)


def _bends(values: Array) -> Array:
    """Second differences along the last axis."""
    steps = values[..., 1:] - values[..., :-1]
    return steps[..., 1:] - steps[..., :-1]


def _robust(values: Array) -> float:
    """Standard deviation of the bulk of ``values``, by the median of their distance from the median."""
    return RECORD_NORMAL * median(np.abs(values - median(values)))


def _robust_of_first(values: Array, rows: Array) -> Array:
    """Standard deviations (B,) of the bulk of the first ``rows`` (B,) of each of the ``values`` (B, n), as ``_robust``
    tells them; 0 of none."""
    beyond = np.arange(values.shape[1]) >= rows[:, None]

    def medians(values: Array) -> Array:
        ordered, last = np.sort(np.where(beyond, math.inf, values), axis=1), np.maximum(rows, 1)
        low, high = (np.take_along_axis(ordered, at[:, None], axis=1) for at in ((last - 1) // 2, last // 2))
        return (low + high) / 2

    values = np.where(beyond, 0.0, values)
    off = np.abs(values - medians(values))
    return np.where(rows > 0, RECORD_NORMAL * medians(off)[:, 0], 0.0)


def _ends_of_free_parts(x: Array, y: Array, rows: Array) -> Array:
    """How many rows (B,) from the far ends on are free: first the best of all cuts into a line and a curve, then as far
    as the load stays on the line through what surely is free."""
    size, all_of = _block(int(rows[0])), np.arange(rows.size)
    ends = np.maximum(_best_cuts(x, y, rows), 5)
    rough = _robust_of_first(_bends(y), rows - 2) / math.sqrt(6 * size)
    x, y = x - x[:, :1], y - y[:, :1]
    products = [column.ravel() for column in (x, y, x * x, x * y)]
    starts, loads = x.shape[1] * all_of, products[1]
    x, y = _blocks(x, size), _blocks(y, size)
    blocks = np.arange(x.shape[1] + RECORD_RUN - 1)
    last = np.minimum(blocks, rows[:, None] // size - 1)  # which may alone be in contact: it goes on
    for share in RECORD_INSIDE:
        sure = np.maximum(np.rint(share * ends).astype(int), 5)
        X, Y, XX, XY = (_over_first(np.add, column, starts, sure) for column in products)
        way = XX - X * X / sure
        tilt = np.where(way > 0, XY - X * Y / sure, 0.0) / np.where(way > 0, way, 1.0)
        off = y - (Y / sure)[:, None] - tilt[:, None] * (x - (X / sure)[:, None])
        inside = sure // size
        slow = np.sum(off**2 * (blocks[: off.shape[1]] < inside[:, None]), axis=1) / np.maximum(inside, 1)
        scatter = np.maximum(np.sqrt(slow), rough)
        seen = np.minimum(2 * ends, rows)
        highest, lowest = (_over_first(extreme, loads, starts, seen) for extreme in (np.maximum, np.minimum))
        least = RECORD_BENT * (highest - lowest)
        away = np.abs(off) > np.maximum(RECORD_SIGMAS * scatter, least)[:, None]
        away &= (inside > 0)[:, None]
        away[:, 1:-1] |= away[:, :-2] & away[:, 2:]  # where a tension passes through the line to a load
        runs = in_succession(np.take_along_axis(away, last, axis=1))
        ends = np.where(runs.any(axis=1), np.maximum(np.argmax(runs, axis=1) * size, 5), rows)
    return ends


def _over_first(operation: np.ufunc, values: Array, starts: Array, rows: Array) -> Array:
    """The sums, or extremes, by an ``operation`` of so many ``rows`` (B,) of the ``values`` from each of the
    ``starts`` (B,) on."""
    edges = np.column_stack([starts, starts + rows]).ravel()
    return operation.reduceat(values, edges[:-1] if edges[-1] == values.size else edges)[::2]


def _cuts(rows: int) -> Array:
    """The numbers of rows before the cuts that are tried."""
    return np.unique(np.linspace(max(5, round(RECORD_FAR * rows)), rows - 4, min(rows, CUTS)).astype(int))


def _best_cuts(x: Array, y: Array, rows: Array) -> Array:
    """The numbers (B,) of rows before the cuts at which a straight line up to it and a parabola beyond leave least.

    All polynomials follow from sums of powers between the cuts; the sums of squares that they leave, from the
    triangular factors of their normal equations (Cholesky).
    """
    cuts = np.stack([_cuts(n) for n in rows.tolist()])
    within, count = np.arange(x.shape[1]) < rows[:, None], rows[:, None]
    ways = (np.ptp(w, axis=1, keepdims=True) for w in (x, y))
    u, v = (
        (w - np.sum(w * within, axis=1, keepdims=True) / count) / np.where(way > 0, way, 1.0) * within
        for w, way in zip((x, y), ways, strict=True)
    )
    uu, uv = u * u, u * v
    edges = (np.column_stack([0 * rows, cuts]) + x.shape[1] * np.arange(rows.size)[:, None]).ravel()
    powers = (u, uu, u * uu, uu * uu, v, uv, uu * v, v * v)
    between = np.stack([np.add.reduceat(power.ravel(), edges).reshape(rows.size, -1) for power in powers])
    before, beyond = np.cumsum(between[..., :-1], axis=2), np.cumsum(between[..., :0:-1], axis=2)[..., ::-1]
    left = _left_by_sums(before, cuts, 1) + _left_by_sums(beyond, count - cuts, 2)
    return cuts[np.arange(rows.size), np.argmin(left, axis=1)]


def _left_by_sums(sums: Array, rows: Array, degree: int) -> Array:
    """Sums of squares that polynomials of ``degree`` 1 or 2 leave of so many ``rows``, by the sums of u, u^2, u^3, u^4,
    v, u v, u^2 v and v^2 over them."""
    S1, S2, S3, S4, V0, V1, V2, VV = sums
    least = 1e-12 * rows  # in place of a way that is none
    S0 = rows + least
    d1, r1 = S2 + least - S1 * S1 / S0, V1 - S1 * V0 / S0
    left = VV - V0 * V0 / S0 - r1 * r1 / d1
    if degree == 2:
        m = S3 - S1 * S2 / S0
        d2, r2 = S4 + least - S2 * S2 / S0 - m * m / d1, V2 - S2 * V0 / S0 - m * r1 / d1
        left -= r2 * r2 / d2
    return np.maximum(left, 0.0)


def _lines(x: Array, y: Array, rows: Array) -> tuple[Array, Array, Array, Array]:
    """Straight lines through the first ``rows`` (B,) of x and y (B, n): mean positions, mean loads and tilts, (B, 1)
    each, the last 0 where the device stands still; and which rows these are (B, n)."""
    within = np.arange(x.shape[1]) < rows[:, None]
    count = rows[:, None]
    middle, level = (np.sum(v * within, axis=1, keepdims=True) / count for v in (x, y))
    away = (x - middle) * within
    moves = ((x != x[:, :1]) & within).any(axis=1, keepdims=True)
    way = np.sum(away * away, axis=1, keepdims=True)
    tilt = np.where(moves, np.sum(away * (y - level), axis=1, keepdims=True), 0.0) / np.where(moves, way, 1.0)
    return middle, level, tilt, within


def _base_lines(
    x: Array, y: Array, ends: Array, roundings: Sequence[float], block: int
) -> tuple[list[BaseLine], Array]:
    """The straight lines through the first ``ends`` (B,) rows of x and y (B, n), and what they leave of all rows."""
    middle, level, tilt, _ = _lines(x, y, ends)
    at = np.take_along_axis(x, ends[:, None] - 1, axis=1)
    offset = level - tilt * (middle - at)
    off = y - (offset + tilt * (x - at))
    noises = _robust_of_first(_bends(off), np.where(ends > 3, ends - 2, 0)) / math.sqrt(6)
    bases = []
    for i, (end, rounding) in enumerate(zip(ends.tolist(), roundings, strict=True)):
        noise = max(float(noises[i]), rounding)
        size = max(1, min(end // 10, block))
        means = _blocks(off[i, :end], size)
        slow = float(means @ means) / means.size - noise**2 / size
        line = float(offset[i, 0]), float(tilt[i, 0]), float(at[i, 0])
        bases.append(BaseLine(*line, end, noise, math.sqrt(max(slow, 0.0)), False, rounding))
    return bases, off


def resolution(y: Array) -> float:
    """The step of readings that are whole numbers of steps; 0 where they are none, or none repeats."""
    (step,) = resolutions(y[None], np.array([y.size]))
    return step


def resolutions(y: Array, rows: Array) -> list[float]:
    """The steps of so many ``rows`` (B,) of readings (B, n) by ``resolution``; beyond, readings are repeated."""
    values = np.sort(y, axis=1)
    steps = values[:, 1:] - values[:, :-1]
    differ = steps > SAME * (values[:, -1:] - values[:, :1])  # conversion to other units parts equal ones by round-off
    found = []
    for own_steps, of_own, count in zip(steps, differ, rows.tolist(), strict=True):
        step = 0.0
        if 0 < 2 * np.count_nonzero(of_own) <= count:
            own = own_steps[of_own]
            step = median(own[own < 1.5 * own.min()])
            whole = own / step
            if float(np.abs(whole - np.rint(whole)).max()) >= RECORD_WHOLE:
                step = 0.0
        found.append(step)
    return found


def _are_curved(x: Array, y: Array, rows: Array, ends: Array) -> Array:
    """Whether the first ``ends`` rows (B,) go on smoothly in as many more: one polynomial through all of them leaves
    much less than the line through what surely would be free. Contact begins with a kink or a jump, which none
    follows."""
    sure = np.rint(RECORD_INSIDE[-1] * ends).astype(int)
    curved = (sure >= 2 * (RECORD_SMOOTH + 1)) & (2 * ends <= rows)
    if curved.any():
        x, y, sure, ends = x[curved], y[curved], sure[curved], ends[curved]
        middle, level, tilt, within = _lines(x, y, sure)
        off = (y - level - tilt * (x - middle)) * within
        straight = np.sqrt(np.sum(off * off, axis=1) / sure)
        curved[curved] = _left(x, y, 2 * ends, RECORD_SMOOTH) < RECORD_HALF * straight
    return curved


def _left(x: Array, y: Array, rows: Array, degree: int) -> Array:
    """Root mean squares (B,) of what polynomials of ``degree`` leave of the first ``rows`` (B,) of x and y (B, n)."""
    within = np.arange(x.shape[1]) < rows[:, None]
    first = np.where(within, x, math.inf).min(axis=1, keepdims=True)
    way = np.where(within, x, -math.inf).max(axis=1, keepdims=True) - first
    powers = np.empty((x.shape[0], degree + 1, x.shape[1]))
    powers[:, 0], along = within, (x - first) / np.where(way > 0, way, 1.0) * 2 - 1
    for i in range(degree):
        np.multiply(powers[:, i], along, out=powers[:, i + 1])
    normal, right = powers @ powers.transpose(0, 2, 1), powers @ y[..., None]
    # a device that stands still leaves the powers alike: at round-off they add to the diagonal
    normal += (degree + 1) * ROUNDING * rows[:, None, None] * np.eye(degree + 1)
    left = (y - (powers.transpose(0, 2, 1) @ np.linalg.solve(normal, right))[..., 0]) * within
    left -= np.sum(left, axis=1, keepdims=True) / rows[:, None] * within
    return np.sqrt(np.sum(left * left, axis=1) / rows)


def _touch(x: Array, off: Array, base: BaseLine) -> tuple[int, float]:
    """The row from which on the load is off the base line for good, and how far about that its position may be
    wrong: a block of rows; all rows where it never is, by more than round-off."""
    i = base.rows
    if i >= x.size or off.max() - off.min() <= ROUNDED * abs(base.offset):
        return x.size, math.inf
    size = _block(x.size)
    limit = 2 * math.hypot(base.noise / math.sqrt(size), base.waviness)
    while i > size and abs(float(np.add.reduce(off[i - size : i])) / size) > limit:
        i -= size
    near = x[max(i - size, 0) : i + size + 1]
    return i, float(near.max() - near.min()) / 2


def _jumps(
    off: Array, base: BaseLine, falls: list[int], rises: list[int], width: int
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Rows before and after which the load changes at once, seen from the far end inwards: falls to tension (the jump
    into contact on approach, those of pull-off on retraction) and any change of a tension beyond, and all others.

    At once: within a few rows, and far beyond what the load does before and after; a kink is none.
    """

    def tension(row: int) -> float:
        load = float(off[row])
        return -load / base.least if base.least else -math.copysign(1.0, load) * (load != 0)

    jumps = [row for row in falls if tension(row + width) > 1]
    first = jumps[0] if jumps else off.size
    within = {row for row in rises if row >= first and min(tension(row + width), tension(row)) > 1}
    others = [row for row in falls if tension(row + width) < RECORD_HALF] + [row for row in rises if row not in within]
    least = RECORD_SMALL * float(np.ptp(off))
    others = [row for row in others if abs(float(off[row + width] - off[row])) > least]
    return _runs(sorted([*jumps, *within]), width), _runs(sorted(others), width)


def _by_motion(x: Array, y: Array, first: int, last: int) -> bool:
    """Whether the load changes between two rows by no more than the way between them makes of it, by the slopes on both
    sides: rows that lie far apart, or unevenly, step by themselves."""
    rows, slopes = FEWEST_ROWS, [0.0]
    for side in (slice(max(first - rows, 0), first + 1), slice(last, last + rows + 1)):
        count = np.array([x[side].size])
        slopes.append(abs(float(_lines(x[None, side], y[None, side], count)[2][0, 0])))
    return abs(float(y[last] - y[first])) <= 2 * max(slopes) * abs(float(x[last] - x[first]))


def _end_of_tether(off: Array, base: BaseLine, falls: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Rows before and after which the load leaves a level tension inside of the only one of the ``falls``, which a
    tether or a second contact holds there, however little happens where the first one ends; none without one."""
    if len(falls) != 1:
        return []
    inside = off[falls[0][1] + 1 :]
    count = max(round(RECORD_TETHER * off.size), FEWEST_ROWS // 2)
    if inside.size < count:
        return []
    tension, along = -float(inside[:count].mean()), np.linspace(-0.5, 0.5, count)
    left = inside[:count] + tension
    change = 12 * float(along @ left) / count
    left -= change * along
    if abs(change) >= RECORD_TETHER * tension + 2 * base.noise * math.sqrt(12 / count):
        return []
    if math.sqrt(float(left @ left) / count) >= RECORD_STRAIGHT * base.noise:
        return []
    size = _block(off.size)
    away = np.abs(_blocks(inside + tension, size)) > RECORD_HALF * base.least
    if not away.any():
        return []
    rows = int(np.argmax(away)) * size
    around, end = inside[: rows + count], falls[0][1] + rows
    # one polynomial passes through the largest tension of a contact, where none ends
    (scatter,) = _left(np.arange(around.size)[None], around[None], np.array([around.size]), RECORD_SMOOTH)
    goes_on = scatter < RECORD_STRAIGHT * base.noise
    return [] if goes_on else [(end, end + size)]


def _jump_width(rows: int) -> int:
    """The number of rows over which a load that jumps changes."""
    return max(1, round(rows * RECORD_BLOCK / 4))


def _sudden(off: Array, rows: Array, bases: Sequence[BaseLine]) -> tuple[list[list[int]], list[list[int]]]:
    """The rows from which on the loads ``off`` each of B base lines (B, n) fall at once, by more than noise and
    round-off, and those from which on they rise; ``rows`` (B,) of them are readings."""
    width = _jump_width(int(rows[0]))
    step = off[:, width:] - off[:, :-width]
    least = np.array([[max(RECORD_SIGMAS * math.sqrt(2) * one.noise, ROUNDED * abs(one.offset))] for one in bases])
    weak = np.minimum(RECORD_SMALL * np.ptp(off, axis=1), -RECORD_FAR * off.min(axis=1))  # a weak pull-off jumps, too
    least = np.maximum(least, weak[:, None])
    # The median of the steps over `width` rows just before each of them, and just after: none is above, or below, as
    # many of all steps as of its own window.
    n, last = FEWEST_ROWS, rows[:, None] - width - 1
    places = np.arange(-n - 1, step.shape[1] // width + n + 2) * width
    some = np.take_along_axis(step, np.clip(places, 0, last // width * width), axis=1)
    low, high = (n - 1) // 2, n // 2
    ordered = np.sort(some, axis=1)
    away = (step < ordered[:, high - n, None] - least) | (step > ordered[:, low, None] + least)
    which, rows = np.divmod(np.flatnonzero(away & (np.arange(step.shape[1]) <= last)), step.shape[1])
    first = (rows // width)[:, None] + np.arange(n)
    before, after = (
        np.sort(some[which[:, None], first + shift], axis=1)[:, low : high + 1].mean(axis=1) for shift in (0, n + 3)
    )
    there, least = step[which, rows], least[which, 0]
    falls: list[list[int]] = [[] for _ in bases]
    rises: list[list[int]] = [[] for _ in bases]
    for found, marked in (
        (falls, there < np.minimum(before, after) - least),
        (rises, there > np.maximum(before, after) + least),
    ):
        for i, row in zip(which[marked].tolist(), rows[marked].tolist(), strict=True):
            found[i].append(row)
    return falls, rises


def _runs(rows: Sequence[int], width: int) -> list[tuple[int, int]]:
    """First and last, ``width`` further on, of each run of increasing ``rows``, with short gaps."""
    runs: list[tuple[int, int]] = []
    for row in rows:
        if runs and row - (runs[-1][1] - width) <= 2 * width:
            runs[-1] = runs[-1][0], row + width
        else:
            runs.append((row, row + width))
    return runs


def _on_base_lines(P: Array, touched: Sequence[Direction]) -> Iterator[tuple[str, str]]:
    """Flags of base lines that are not there, or not straight."""
    span = float(np.ptp(P))
    for item in touched:
        name, waviness = item.segment.kind, item.base.waviness
        if not item.begins_free:
            end = "begins" if name == APPROACH else "ends"
            yield "no base line", f"the {name} {end} in contact, or has no straight part"
        elif waviness > RECORD_WAVY * span:
            # What a line leaves of the loads from their free end on is slow, and no noise from row to row
            rows = np.arange(item.base.rows)
            free = P[item.segment.rows][:: 1 if name == APPROACH else -1][: rows.size]
            off = free - np.polyval(np.polyfit(rows, free, 1), rows)
            if float(off[1:] @ off[:-1]) > float(off @ off) / 2:
                yield (
                    "wavy base line",
                    (
                        f"the base line of the {name} is wavy by {show(waviness, 'load')}, {waviness / span:.0%} of "
                        "the range of the load: more than one wave of interference, or drift"
                    ),
                )


def _permanent_set(z: Array, P: Array, directions: Sequence[Direction]) -> tuple[tuple[str, str], ...]:
    """A flag with the depth at which the load of an unloading is gone without any tension: that of a dent."""
    sides = {item.segment.kind: item for item in directions}
    into, out = sides.get(APPROACH), sides.get(RETRACT)
    if into is None or out is None or not into.begins_free or isinstance(into.touch, Unknown):
        return ()
    deepest = float(z.max())
    z, P = (_blocks(v[out.segment.rows], _block(len(out.segment))) for v in (z, P))
    off, least = P - into.base(z), max(into.base.least, RECORD_SMALL * into.largest)
    gone = np.flatnonzero(off < least)
    if not gone.size or off.min() < -least:
        return ()
    dent, depth = float(z[gone[0]]) - into.touch, deepest - into.touch
    if dent < RECORD_FAR * depth + into.touch_err:
        return ()
    sentence = f"unloading leaves a dent of {show(dent, 'length', 3)} after a depth of {show(depth, 'length', 3)}"
    return ((PERMANENT_SET if dent > RECORD_HALF * depth else f"some {PERMANENT_SET}", sentence),)


def _on_jumps(touched: Sequence[Direction], limits: Array) -> Iterator[tuple[str, str]]:
    """Flags of contacts beside the one, and of steps where there should be none, but where the rows of a detector at
    its limit, ``limits``, begin and end."""
    for item in touched:
        name, near = item.segment.kind, 2 * _block(len(item.segment))
        jumps, steps = (
            [one for one in events if not limits.size or np.abs(limits - one.row).min() > near]
            for events in (item.jumps, item.steps)
        )
        if len(jumps) > 1:
            yield "several contacts", f"{len(jumps)} jumps under tension in the {name}"
        if steps:
            step = max(steps, key=lambda step: abs(step.step))
            sentence = (
                f"the load of the {name} jumps by {show(step.step, 'load', 3)} at row {step.row + 1}: "
                "base line, second contact, or slip"
            )
            yield "step", sentence


def _on_signs(device: Array, P: Array, directions: Sequence[Direction]) -> Iterator[tuple[str, str]]:
    """Flags of devices that run to and fro, and of columns that count the other way round."""
    ways = (device[item.segment.rows] for item in directions)
    means = [_blocks(way, max(1, round(way.size / 20))) for way in ways]  # without noise
    if any(float(np.abs(way[1:] - way[:-1]).sum()) > RECORD_WANDERING * float(way.max() - way.min()) for way in means):
        yield "no force curve", "the instrument reverses more than once"
    for item in directions:
        name = item.segment.kind
        # Whether a direction goes the other way than the file names it, or back and then in again.
        z, load = device[item.segment.rows], P[item.segment.rows]
        ends, least = max(1, round(z.size * RECORD_FAR)), float(z.min())
        first, last = float(z[:ends].mean()), float(z[-ends:].mean())
        way = (last - first) * (1 if item.segment.kind == APPROACH else -1)
        returns = min(first, last) - least
        if max(-way, returns) > RECORD_HALF * (float(z.max()) - least):
            which = f" of the {name}" if len(directions) > 1 else ""  # of one that returns the last bits chose the name
            sentence = f"the displacement{which} has the opposite sign: indentation must be positive (--flip delta)"
            yield "wrong way", sentence
        elif len(directions) == 1 and presses_outward(z, load):
            sentence = "the load rises while the displacement falls; indentation must be positive (--flip delta)"
            yield "wrong way", sentence
        elif (
            isinstance(item.touch, float) and isinstance(item.adhesion, float) and item.based
            and z.max() - RECORD_SMALL * float(np.ptp(z)) < item.adhesion_at >= z[np.argmax(load)]
        ):  # fmt: skip
            # Tension is largest where it presses deepest, and compression is not, as where tension counts as positive;
            # a gel that relaxes after the turn has both there
            sentence = f"the load of the {name} is least where the instrument presses deepest"
            yield "wrong sign", f"{sentence}: is compression negative (--flip P)?"


# --------------------------------------------------------------------------------------------------
# Displacements that were computed as z - P/k from the position z of a device: they hold the noise of the load.
#
# In contact delta and P then err together, and beside the free rows, whose noise is that of P alone, delta looks
# noisy. The position delta + P/k is smooth, and k follows from the noise.

# When the noise of a displacement is that of the load.
# theory: rows; third differences are correlated, and leave so many as 100/2.3 apart: by chance the noise of two
# columns has the ``share`` at 4.7 standard deviations
TIP_POSITION_FEWEST = 100
TIP_POSITION_SHARE = 0.5  # theory: of the variance of delta: more of it follows P than does not
TIP_POSITION_USUAL = 4.0  # theory: medians, 2.7 standard deviations of normal noise: beyond is a jump or a turn


def of_its_device(curve: Curve) -> Curve:
    """The curve with the stiffness of its device where the noise of its displacement shows one."""
    if curve.delta is None or curve.P is None or curve.a is not None:
        return curve
    k = stiffness_of_noise(curve.delta, curve.P)
    if k is None:
        return curve
    flags = tuple(flag for flag in curve.flags if flag not in (NOT_SUBTRACTED, AS_DEPTH))
    flag = f"the displacement is that of the tip, with the noise of the load: the instrument has {show(k, 'stiffness')}"
    return replace(curve, stiffness=k, flags=(*flags, flag))


def stiffness_of_noise(delta: Array, P: Array) -> float | None:
    """Stiffness k [N/m] for which the noise of ``delta`` [m] is that of -P/k, by the third differences of rows in
    their order; None where less than half of it is, or where differences are those of a smooth curve."""
    if delta.size < TIP_POSITION_FEWEST:
        return None
    x, y = (bends[1:] - bends[:-1] for bends in map(_bends, (delta, P)))
    usual_x, usual_y = (size <= TIP_POSITION_USUAL * median(size) for size in map(np.abs, (x, y)))
    usual = usual_x & usual_y
    x, y = x * usual, y * usual
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    smooth = float(y[1:] @ y[:-1]) > 0  # neighbours correlate by 1 on a smooth curve, by -0.75 in white noise
    if xy >= 0 or xy**2 <= TIP_POSITION_SHARE * xx * yy or smooth:
        return None
    return -yy / xy if math.isfinite(yy / xy) else None


# --------------------------------------------------------------------------------------------------
# Zero points of a recorded approach, by its base line and the row at which the load leaves that for good.

GIVE = "give --zero P=... and --zero delta=..."

# What separates contact from the free part of an approach.
FIRST_TOUCH_SIGMAS = 5.0  # theory: standard deviations of normal noise that no row of a million reaches


def with_zero_points(curve: Curve) -> Curve:
    """The curve with the load's straight base line subtracted (tilt too) and displacement 0 at first touch.

    By the positions of the device, whose deflection by the load that is left is subtracted where its stiffness is
    known.

    First touch is where the load of the approach leaves the base line for good: in JKR contact forces have no range,
    so that is delta = 0, with a jump into contact or without. Between two rows: half a step of uncertainty. An
    estimate to start from, not a measurement. InputError where the approach holds no free part.
    """
    side = segment_force_curve(curve).direction(APPROACH)
    if side is None:
        segments = f" (segments: {', '.join(curve.segments())})" if curve.segment is not None else ""
        raise InputError(
            f"{curve.where}: has no approach{segments}: contact point and force offset cannot be estimated"
        )
    if isinstance(side.touch, Unknown):
        raise InputError(f"{curve.where}: the load of the approach never leaves its baseline: no contact was made")
    if not side.begins_free:
        raise InputError(
            f"{curve.where}: the approach has no free part to estimate contact point and force offset from; {GIVE}"
        )
    z, P = curve.device[side.segment.rows], curve.load[side.segment.rows]
    off, free = np.abs(P - side.base(z)), side.base.rows
    scatter = RECORD_NORMAL * median(off[:free])
    away = off > max(FIRST_TOUCH_SIGMAS * scatter, SAME * float(np.ptp(P)))  # the latter in records without noise
    first = max(int(np.argmax(in_succession(away))), 1)
    touch, half = float(z[first - 1] + z[first]) / 2, abs(float(z[first] - z[first - 1])) / 2
    flag = (
        f"contact point and force offset estimated from {free} free rows: first touch at "
        f"{show(touch, 'length')} (within {show(half, 'length')}), "
        f"baseline {show(float(side.base(np.array(touch))), 'load')} with a tilt of {side.base.tilt:.3g} N/m"
    )
    P = curve.load - side.base(curve.device)
    delta = curve.device - touch - (0.0 if curve.stiffness is None else P / curve.stiffness)
    return replace(curve, delta=delta, P=P, flags=(*curve.flags, flag))

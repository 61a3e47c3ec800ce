"""The parts of a force curve by its numbers alone: directions, base line, first touch, jumps, pull-off.

The body is unknown here, and zero points are arbitrary. Each direction is read from its far end, where the indenter is
free: there the load is a straight line, and what leaves that line is contact or adhesion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..base.errors import Estimate, InputError, Unknown, counted, known
from ..base.numerics import FEWEST_ROWS, NOTICEABLE, ROUNDED, SAME, Array, median
from ..base.units import show
from .curve import APPROACH, AS_DEPTH, NOT_SUBTRACTED, RETRACT, Curve
from .free_rows import FreeRows, Side, free_rows
from .instruments import presses_outward
from .tables import NO_UNIT

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
    ends = {"largest": float(curve.P.max()), "smallest": float(curve.P.min())}
    return {name: curve.P == end for name, end in ends.items() if _standing_still(curve.P, curve.device, end)}


def saturation_words(curve: Curve) -> tuple[str, ...]:
    """A sentence on each end of the loads at which they are saturated."""
    return tuple(
        f"{np.count_nonzero(rows)} rows hold the same {name} load, {show(float(curve.load[rows][0]), 'load')}, as at "
        "the limit of a detector"
        for name, rows in saturation(curve).items()
    )


def _standing_still(P: Array, z: Array, end: float) -> bool:
    """Whether the longest run at the load ``end`` is long, and came there by more than some steps of the converter."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], end == P, [False]]).astype(int)))
    first, last = edges[::2], edges[1::2]
    i = int(np.argmax(last - first))
    count = int(last[i] - first[i])
    held = z[first[i] : last[i]]
    levels = np.diff(np.unique(P))
    if count < SATURATION_SATURATED or count == P.size or np.abs(held - held[0]).max() < NOTICEABLE * np.ptp(z):
        return False
    if held.min() < z.min() + SATURATION_FREE * np.ptp(z):
        return False
    # A load that turns there by itself leaves it slowly: by a parabola that rests within a level for so many rows
    # changes by 4.5 levels in as many more, on the side of no jump.
    sides = P[max(first[i] - count, 0) : first[i] + 1], P[last[i] - 1 : last[i] + count]
    left = min((float(np.ptp(side)) for side in sides if side.size > count // 2 + 1), default=float(np.ptp(P)))
    return left > SATURATION_LEVELS * float(levels.min())


DWELL, PERMANENT_SET = "dwell", "permanent set"

# Where a departure counts; lengths are shares of the rows of a direction.
RECORD_NORMAL = 1.4826  # theory: standard deviation over median deviation of normal noise
RECORD_BLOCK = 1 / 200  # tuned on records, by `make constants`: rows averaged in the search for slow deviations
# choice: the part of a direction that is free if anything is; of the whole way, least of both ways that make two
# directions of one segment
RECORD_FAR = 0.1
RECORD_INSIDE = 0.8  # tuned on records, by `make constants`: of the free part found first, what surely is free
RECORD_SIGMAS = 6.0  # theory: 1e-9 of normal noise lies beyond, of rows and of what they leave a line by
RECORD_LEAST = 0.005  # choice: of the range of the load, below which no departure counts
RECORD_WHOLE = 0.1  # theory: off whole numbers, of steps between levels; a few that are none are so by chance
RECORD_RUN = 3  # tuned on records, by `make constants`: blocks in succession that must agree
# choice: of all rows, the range of the load, or the way: what is no direction, no jump, no motion, no place of
# steps, and how many rows may be spikes
RECORD_SMALL = 0.02
RECORD_HALF = 0.5  # theory: of a way, a step, the least load or what a line leaves: more is the larger part of it
# choice: of the rows, least length of a tether; relative change of its load, beyond the error; no contact's is
# below 0.1 by then
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
        """Whether there is a base line: not a few rows only, not contact's own end, not as steep as contact is, and not
        the straight line of an edge at rest."""
        enough = self.base.rows >= RECORD_FAR * len(self.segment) and not self.base.curved
        rise, off = abs(self.base.tilt) * self.way * self.base.rows / len(self.segment), known(self.adhesion) or 0.0
        level = RECORD_STEEP * rise <= max(self.largest, off)
        return enough and level and abs(self.base.tilt) * self.depth <= RECORD_STEEP * self.largest

    @property
    def based(self) -> bool:
        """Whether touch and loads over the base line mean anything: it is there, or nothing but a base line."""
        return self.begins_free or isinstance(self.touch, Unknown)


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """A measured curve taken apart; ``flags``: what is wrong with it, in a word or two, and a sentence on each;
    ``spikes``: rows that stand alone off the others, ``saturated``: rows at a detector's limit: they count for nothing.
    ``held``: what the free rows hold beside a base line, which is taken off the loads of the ``curve``; ``plain``: the
    record with it.
    """

    curve: Curve
    segments: tuple[Segment, ...]
    directions: tuple[Direction, ...]
    flags: dict[str, str]
    spikes: Array
    saturated: Array
    held: FreeRows | None = None
    plain: ForceCurve | None = None

    def holding(self, held: FreeRows) -> ForceCurve:
        """The record with something else taken off its loads; base lines follow when it is fitted."""
        taken = np.zeros(len(self.curve)) if self.held is None else self.held.taken
        curve = replace(self.curve, P=self.curve.load + taken - held.taken)
        P = curve.load
        sides = tuple(_direction(curve.device, P, side.segment) for side in self.directions)
        return replace(self, curve=curve, held=held, directions=sides)

    @cached_property
    def ignored(self) -> Array:
        """The rows that count for nothing."""
        within = np.zeros(0, dtype=int) if self.held is None else self.held.spoilt
        return np.unique(np.concatenate([self.spikes, self.saturated, within]))

    @property
    def rest(self) -> int:
        """How many rows belong to no segment."""
        return len(self.curve) - sum(map(len, self.segments))

    def direction(self, kind: str) -> Direction | None:
        """The first direction of a kind, "approach" or "retract"."""
        return next((item for item in self.directions if item.segment.kind == kind), None)


def segment_force_curve(curve: Curve) -> ForceCurve:
    """The parts of a measured curve; InputError where it holds no displacement and load, or too few rows."""
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
    whole, P, spikes = curve, curve.P, _spikes(curve.P)
    if spikes.size:
        z, P = curve.device, P.copy()
        P[spikes] = (P[spikes - 1] + P[spikes + 1]) / 2
        curve = replace(curve, P=P, delta=z if curve.stiffness is None else z - P / curve.stiffness)
    parts, by_load = _segments_by_motion(curve.device, P) if curve.segment is None else (_named_segments(curve), False)
    sides = [part for part in parts if part.kind in (APPROACH, RETRACT) and len(part) >= FEWEST_ROWS]
    directions = tuple(_direction(curve.device, P, part) for part in sides)
    held = _free_rows(curve, directions, resolution(whole.load))
    plain = ForceCurve(whole, tuple(parts), directions, {}, spikes, spikes[:0]) if held is not None else None
    if held is not None:  # the tip stays at its depth
        curve, whole = (replace(one, P=one.load - held.taken) for one in (curve, whole))
        directions = tuple(_direction(curve.device, curve.load, part) for part in sides)
    # What a reader should know before trusting anything that is fitted to this curve; the last sentence of a name.
    touched = [item for item in directions if not isinstance(item.touch, Unknown)]
    flags = [*_missing(parts, directions)]
    if directions and not touched:
        flags.append(("no contact", "the load never leaves its base line"))
    dent = _permanent_set(curve, directions) if by_load else ()
    limits = np.flatnonzero(np.any([np.zeros(len(curve), dtype=bool), *saturation(curve).values()], axis=0))
    flags += [*(dent or _on_base_lines(curve, touched)), *_on_jumps(touched, limits), *_on_signs(curve, directions)]
    flags += [("saturated", f"{sentence}: they are left out") for sentence in saturation_words(curve)]
    return ForceCurve(whole, tuple(parts), directions, dict(flags), spikes, limits, held, plain)


def _free_rows(curve: Curve, directions: Sequence[Direction], code: float) -> FreeRows | None:
    """What the free rows of the first approach and the first retraction hold beside a base line; ``code`` [N]: the step
    of the converter."""
    sides, z, P = [], curve.device, curve.load
    for kind in (APPROACH, RETRACT):
        item = next((item for item in directions if item.segment.kind == kind), None)
        if item is None or isinstance(item.touch, Unknown):
            continue
        rows = np.arange(item.segment.first, item.segment.last + 1)[:: 1 if kind == APPROACH else -1]
        free, contact = rows[: item.free], rows[item.free :]
        sides.append(Side(kind, free, z[free], P[free], contact, item.jump, code, z[contact]))
    return free_rows(sides, len(curve), math.inf if curve.stiffness is None else curve.stiffness)


def _spikes(P: Array) -> Array:
    """Rows that leave the lines through the two before and the two after by as much and to the same side, far beyond
    what the others do; none where they are many. At a jump one of the lines holds, or they are apart."""
    before, after = 2 * P[1:-3] - P[:-4], 2 * P[3:-1] - P[4:]
    off = np.minimum(np.abs(P[2:-2] - before), np.abs(P[2:-2] - after))
    least = max(RECORD_SIGMAS * _robust(P[2:-2] - before), RECORD_LEAST * float(np.ptp(P)))
    between = (P[2:-2] - before) * (P[2:-2] - after) > 0
    spikes = np.flatnonzero(between & (off > least) & (np.abs(before - after) < RECORD_HALF * off)) + 2
    return spikes if spikes.size <= RECORD_SMALL * P.size else spikes[:0]


def _named_segments(curve: Curve) -> list[Segment]:
    """Stretches of rows with the same word. One that turns back in its middle holds both directions, whatever it is
    called; rows of one direction at a standstill by the turn are a dwell."""
    words, delta, P = curve.segment, curve.device, curve.load
    assert words is not None
    ends = np.flatnonzero(words[1:] != words[:-1])
    stretches = [
        Segment(str(words[first]), int(first), int(last))
        for first, last in zip([0, *(ends + 1)], [*ends, words.size - 1], strict=True)
    ]
    parts: list[Segment] = []
    for part in stretches:
        inside = _segments_by_motion(delta[part.rows], P[part.rows])[0] if len(part) >= FEWEST_ROWS else []
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
    smooth = np.convolve(np.pad(delta, window, mode="edge"), np.ones(2 * window + 1) / (2 * window + 1), "valid")
    turn = int(np.argmax(smooth))
    speed = np.abs(np.gradient(smooth))
    # The speed at which half of the way is covered or less: dwells have no part in it, however long they last.
    ordered = np.sort(speed)
    way = np.cumsum(ordered)
    moving = speed >= RECORD_STILL * float(ordered[np.searchsorted(way, way[-1] / 2)])
    before, after = np.flatnonzero(moving[:turn]), np.flatnonzero(moving[turn:])
    first = int(before[-1]) if before.size else 0
    last = turn + int(after[0]) - 1 if after.size else n - 1
    if last - first < RECORD_SMALL * n:
        first = last = turn
    if last == 0 and delta[0] == delta.max():  # retraction from the first row on
        first = last = -1
    parts = [Segment(APPROACH, 0, first), Segment(DWELL, first + 1, last), Segment(RETRACT, last + 1, n - 1)]
    return [part for part in parts if len(part) > RECORD_SMALL * n]


def _direction(position: Array, P: Array, segment: Segment) -> Direction:
    """Base line, touch, adhesion and jumps of one direction."""
    order = 1 if segment.kind == APPROACH else -1  # from the far end inwards
    x, y = position[segment.rows][::order], P[segment.rows][::order]
    end = _end_of_free_part(x, y)
    base = _base_line(x, y, end)
    # The load falls at once for the first time: a tether or a second contact holds beyond, however straight it is.
    fall, _, width = _sudden(y - base(x), base)
    sooner = min((first for first, _ in _runs(fall, width) if first >= RECORD_FAR * x.size), default=x.size)
    if sooner < end:
        end = sooner
        base = _base_line(x, y, end)
    off = y - base(x)
    row, error = _touch(x, off, base, end)
    touch: Estimate = float(x[row]) if row < x.size else Unknown("the load never leaves its base line")
    lowest = int(np.argmin(off))
    rows = range(segment.first, segment.last + 1)[::order]
    falls, others = _jumps(off, base)
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
    turn = x.max() - RECORD_SMALL * np.ptp(x)  # beyond, a change of drag is no event
    others = [(first, last) for first, last in others if x[last] < turn and not _by_motion(x, off, first, last)]
    jumps, steps = (
        tuple(ForceJump(rows[(i + j) // 2], float(x[(i + j) // 2]), float(off[j] - off[i])) for i, j in pairs)
        for pairs in (falls, others)
    )
    inner = falls[-1][1] if falls else row if isinstance(tension, Unknown) else max(lowest, row)
    border = min([row - 1, *(first for first, _ in falls)]), inner
    if main is not None and ringing:
        border = (border[0], max(inner, main[1] + ringing)) if order > 0 else (min(border[0], main[0] - ringing), inner)
    depth = float(x.max() - x[min(row, x.size - 1)])
    loads = float(off.max()), tension, unsure, float(x[lowest])
    block = _block(off.size)  # contact raises the load: free rows lie before the least of means of rows
    before_least = int(np.argmin(_blocks(off, block))) * block
    free = main[0] + 1 if main is not None else before_least if order > 0 else border[0] + 1
    free -= 0 if order > 0 else ringing
    return Direction(
        segment, base, touch, error, *loads, jumps, steps, border, float(np.ptp(x)), depth, max(free, 0), jump, ringing
    )


def _largest_tension(
    x: Array, off: Array, base: BaseLine, lowest: int, falls: list[tuple[int, int]]
) -> tuple[Estimate, float]:  # fmt: skip
    """The largest tension [N] about the ``lowest`` row and its standard error: of the parabola through as many rows
    beside it, on the contact's side of a jump, as agree with what fewer tell (Lepski 1991). The least of many noisy
    rows alone would be too low. The base line errs there by what it is known to, and a jump lies between two rows."""
    if -off[lowest] < base.least:
        return Unknown("no tension beyond the noise"), base.noise
    tension, error, wider, between = float(-off[lowest]), base.noise, base.noise, 0.0
    begins = max((inner for outer, inner in falls if outer < lowest), default=0)
    least_told, most_told = -math.inf, math.inf
    for half in RECORD_BESIDE:
        y = off[max(begins, lowest - half) : lowest + half + 1]
        if (dof := y.size - 3) < half // 2:
            continue
        Q = np.linalg.qr(np.vander(np.linspace(-1, 1, y.size), 3))[0]
        smooth = Q @ (Q.T @ y)
        least = int(np.argmin(smooth))
        told, unsure = float(-smooth[least]), base.noise * float(np.linalg.norm(Q[least]))
        bends = float(np.sum((y - smooth) ** 2)) > base.noise**2 * (dof + RECORD_CHANCE * math.sqrt(2 * dof))
        if bends or not least_told <= told <= most_told:
            break
        tension, error, wider = told, wider, unsure  # a parabola may be off by what half as many rows cannot tell
        least_told, most_told = max(least_told, told - 2 * unsure), min(most_told, told + 2 * unsure)
        between = float(smooth[1] - smooth[0]) / 2 if least == 0 else 0.0
    free = x[: base.rows]
    away = float(x[lowest] - free.mean()) / (float(np.ptp(free)) or 1.0)
    line = base.noise * math.sqrt((1 + 12 * away**2) / base.rows)
    return tension, math.hypot(error, line, base.waviness, between)


def _ringing(y: Array) -> int:
    """How many rows after a jump, in time, the load still swings to and fro, by second differences of windows of rows
    beside those of all that follow; 0 where it does not swing, or does not die away."""
    width = RECORD_RING
    bends = np.diff(y[1:], 2)
    count = bends.size // width
    if count < RECORD_WINDOWS:
        return 0
    windows = bends[: count * width].reshape(count, width)
    size = np.sqrt(np.mean(windows**2, axis=1))
    loud = size > RECORD_RUNG * median(size)
    last = int(np.argmin(loud))  # windows that are loud without a gap
    swings = last > 0 and np.count_nonzero(np.diff(np.sign(bends[: last * width]))) >= last
    dies_away = loud.sum() < RECORD_HALF * count and size[0] >= size[max(last - 1, 0)]
    if not (swings and dies_away):
        return 0
    # Beyond, what a parabola leaves of wider windows shows swings that bend the load less than noise does.
    noise, wide = median(size) / math.sqrt(6), 2 * width
    parabola = np.linalg.qr(np.vander(np.arange(wide), 3))[0]
    parts = y[1 : 1 + (y.size - 1) // wide * wide].reshape(-1, wide)
    left = np.sqrt(np.mean((parts - parts @ parabola @ parabola.T) ** 2, axis=1))
    quiet = np.flatnonzero(left[last // 2 :] < RECORD_STRAIGHT * noise)
    rows = (last // 2 + int(quiet[0]) + 1) * wide if quiet.size else y.size
    return int(min(max(rows, (last + 1) * width), RECORD_HALF * y.size))


def in_succession(marked: Array) -> Array:
    """Whether each place begins a run of ``RECORD_RUN`` that are ``marked`` (a mask)."""
    runs: Array = np.convolve(marked, np.ones(RECORD_RUN, dtype=int), "valid") == RECORD_RUN
    return runs


def _block(rows: int) -> int:
    """The number of rows of a block."""
    return max(1, round(rows * RECORD_BLOCK))


def _blocks(values: Array, size: int) -> Array:
    """Means of successive blocks of ``size`` rows; what is left at the end is left out."""
    return values[: values.size // size * size].reshape(-1, size).mean(axis=1)


def _robust(values: Array) -> float:
    """Standard deviation of the bulk of ``values``, by the median of their distance from the median."""
    return RECORD_NORMAL * median(np.abs(values - median(values)))


def _end_of_free_part(x: Array, y: Array) -> int:
    """How many rows from the far end on are free: first the best of all cuts into a line and a curve, then as far as
    the load stays on the line through what surely is free."""
    n, size = x.size, _block(x.size)
    end = max(_best_cut(x, y), 5)
    for _ in range(2):
        sure = max(round(RECORD_INSIDE * end), 5)
        off = y - _straight(x[:sure], y[:sure])(x)
        inner = _blocks(off[:sure], size)
        scatter = max(float(np.sqrt(np.mean(inner**2))), _robust(np.diff(y, 2)) / math.sqrt(6 * size))
        least = RECORD_LEAST * float(np.ptp(y[: 2 * end]))
        away = np.abs(_blocks(off, size)) > max(RECORD_SIGMAS * scatter, least)
        padded = np.concatenate([away, away[-1:].repeat(RECORD_RUN - 1)])  # the last block alone may be in contact
        runs = in_succession(padded)
        end = max(int(np.argmax(runs)) * size if runs.any() else n, 5)
    return end


def _best_cut(x: Array, y: Array) -> int:
    """The number of rows before the cut at which a straight line up to it and a parabola beyond leave least."""
    n = x.size
    cuts = np.unique(np.linspace(max(5, round(RECORD_FAR * n)), n - 4, min(n, 200)).astype(int))
    line = _misfits(x, y, 1, cuts)
    curve = _misfits(x[::-1], y[::-1], 2, n - cuts)
    return int(cuts[np.argmin(line + curve)])


def _misfits(x: Array, y: Array, degree: int, rows: Array) -> Array:
    """Sums of squares left by the polynomial of ``degree`` through so many of the first ``rows``."""
    u = (x - x.mean()) / (np.ptp(x) or 1.0)
    v = (y - y.mean()) / (np.ptp(y) or 1.0)
    powers = np.cumsum(np.vander(u, 2 * degree + 1, increasing=True), axis=0)[rows - 1]
    right = np.cumsum(v[:, None] * np.vander(u, degree + 1, increasing=True), axis=0)[rows - 1]
    index = np.arange(degree + 1)
    normal = powers[:, index[:, None] + index]
    normal = normal + 1e-12 * powers[:, :1, None] * np.eye(degree + 1)
    solution = np.linalg.solve(normal, right[..., None])[..., 0]
    return np.maximum(np.cumsum(v**2)[rows - 1] - np.einsum("ki,ki->k", solution, right), 0.0)


def _base_line(x: Array, y: Array, end: int) -> BaseLine:
    """The straight line through the first ``end`` rows."""
    at = float(x[end - 1])
    line = _straight(x[:end] - at, y[:end])
    off = y[:end] - line(x[:end] - at)
    rounding = resolution(y) / math.sqrt(12)
    noise = max(_robust(np.diff(off, 2)) / math.sqrt(6) if end > 3 else 0.0, rounding)
    size = max(1, min(end // 10, _block(x.size)))
    slow = float(np.mean(_blocks(off, size) ** 2)) - noise**2 / size
    offset, tilt, waviness = float(line(0.0)), float(line.deriv()(0.0)), math.sqrt(max(slow, 0.0))
    return BaseLine(offset, tilt, at, end, float(noise), waviness, _is_curved(x, y, end), rounding)


def resolution(y: Array) -> float:
    """The step of readings that are whole numbers of steps; 0 where they are none, or none repeats."""
    values = np.unique(y)
    steps = np.diff(values)
    steps = steps[steps > SAME * np.ptp(y)]  # conversion to other units parts equal ones by round-off
    if not steps.size or 2 * steps.size > y.size:
        return 0.0
    step = median(steps[steps < 1.5 * steps.min()])
    whole = steps / step
    return step if float(np.abs(whole - np.rint(whole)).max()) < RECORD_WHOLE else 0.0


def _is_curved(x: Array, y: Array, end: int) -> bool:
    """Whether the first ``end`` rows go on smoothly in as many more: one polynomial through all of them leaves much
    less than the line through what surely would be free. Contact begins with a kink or a jump, which none follows."""
    sure, whole = round(RECORD_INSIDE * end), 2 * end
    if sure < 2 * (RECORD_SMOOTH + 1) or whole > x.size:
        return False
    return _left(x[:whole], y[:whole], RECORD_SMOOTH) < RECORD_HALF * _left(x[:sure], y[:sure], 1)


def _left(x: Array, y: Array, degree: int) -> float:
    """Root mean square of what the polynomial of ``degree`` leaves."""
    way = float(np.ptp(x)) or 1.0
    powers = np.vander((x - float(x.min())) / way * 2 - 1, degree + 1)
    normal = powers.T @ powers
    left: Array = y - powers @ np.linalg.lstsq(normal, powers.T @ y, rcond=None)[0]
    return float(np.std(left))


def _straight(x: Array, y: Array) -> np.polynomial.Polynomial:
    """The straight line through rows; their mean where the device stands still."""
    if np.ptp(x) == 0:
        return np.polynomial.Polynomial([y.mean()])
    middle = x.mean()
    tilt = (x - middle) @ y / ((x - middle) @ (x - middle))
    return np.polynomial.Polynomial([y.mean() - tilt * middle, tilt])


def _touch(x: Array, off: Array, base: BaseLine, end: int) -> tuple[int, float]:
    """The row from which on the load is off the base line for good, and how far about that its position may be
    wrong: a block of rows; all rows where it never is, by more than round-off."""
    if end >= x.size or np.ptp(off) <= ROUNDED * abs(base.offset):
        return x.size, math.inf
    size = _block(x.size)
    limit = 2 * math.hypot(base.noise / math.sqrt(size), base.waviness)
    i = end
    while i > size and abs(float(off[i - size : i].mean())) > limit:
        i -= size
    near = x[max(i - size, 0) : i + size + 1]
    return i, float(np.ptp(near)) / 2


def _jumps(off: Array, base: BaseLine) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Rows before and after which the load changes at once, seen from the far end inwards: falls to tension (the jump
    into contact on approach, those of pull-off on retraction) and any change of a tension beyond, and all others.

    At once: within a few rows, and far beyond what the load does before and after; a kink is none.
    """
    fall, rise, width = _sudden(off, base)
    if not fall.any() and not rise.any():
        return [], []
    tension = -off / base.least if base.least else -np.sign(off)
    jump = fall & (tension[width:] > 1)
    within = rise & (np.minimum(tension[width:], tension[:-width]) > 1) & np.maximum.accumulate(jump)
    return _runs(jump | within, width), _runs(fall & (tension[width:] < RECORD_HALF) | rise & ~within, width)


def _by_motion(x: Array, y: Array, first: int, last: int) -> bool:
    """Whether the load changes between two rows by no more than the way between them makes of it, by the slopes on both
    sides: rows that lie far apart, or unevenly, step by themselves."""
    rows, slopes = FEWEST_ROWS, [0.0]
    for side in (slice(max(first - rows, 0), first + 1), slice(last, last + rows + 1)):
        way = float(np.ptp(x[side]))
        if way > 0:
            slopes.append(abs(float(np.polyfit(x[side] / way, y[side], 1)[0])) / way)
    return abs(float(y[last] - y[first])) <= 2 * max(slopes) * abs(float(x[last] - x[first]))


def _end_of_tether(off: Array, base: BaseLine, falls: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Rows before and after which the load leaves a level tension inside of the only one of the ``falls``, which a
    tether or a second contact holds there, however little happens where the first one ends; none without one."""
    if len(falls) != 1:
        return []
    inside = off[falls[0][1] + 1 :]
    count = max(round(RECORD_TETHER * off.size), FEWEST_ROWS // 2)
    part, along = inside[:count], np.linspace(-0.5, 0.5, count)
    if part.size < count:
        return []
    tension, change = -float(part.mean()), 12 * float(np.mean(along * (part - part.mean())))
    error = base.noise * math.sqrt(12 / count)
    scatter = float(np.std(part - part.mean() - change * along))
    level = abs(change) < RECORD_TETHER * tension + 2 * error and scatter < RECORD_STRAIGHT * base.noise
    size = _block(off.size)
    away = np.abs(_blocks(inside + tension, size)) > RECORD_HALF * base.least
    if not level or not away.any():
        return []
    left = int(np.argmax(away)) * size
    around, end = inside[: left + count], falls[0][1] + left
    # one polynomial passes through the largest tension of a contact, where none ends
    goes_on = _left(np.arange(around.size), around, RECORD_SMOOTH) < RECORD_STRAIGHT * base.noise
    return [] if goes_on else [(end, end + size)]


def _sudden(off: Array, base: BaseLine) -> tuple[Array, Array, int]:
    """Where the load falls and where it rises at once, over so many rows."""
    width = max(1, round(off.size * RECORD_BLOCK / 4))
    if off.size <= 4 * width:
        return np.zeros(0, bool), np.zeros(0, bool), off.size
    step = off[width:] - off[:-width]
    least = max(RECORD_SIGMAS * math.sqrt(2) * base.noise, RECORD_SMALL * float(np.ptp(off)))
    # The median of the steps over `width` rows just before each of them, and just after.
    n, every = FEWEST_ROWS, np.arange(step.size) // width
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(step[::width], n + 1, mode="edge"), n)
    medians = np.sort(windows, axis=1)[:, (n - 1) // 2 : n // 2 + 1].mean(axis=1)  # half as long as np.median takes
    before, after = medians[every], medians[every + n + 3]
    return step < np.minimum(before, after) - least, step > np.maximum(before, after) + least, width


def _runs(marked: Array, width: int) -> list[tuple[int, int]]:
    """First row and last, ``width`` further on, of each run of ``marked`` rows, with short gaps."""
    rows = np.flatnonzero(marked)
    groups = np.split(rows, np.flatnonzero(np.diff(rows) > 2 * width) + 1) if rows.size else []
    return [(int(group[0]), int(group[-1]) + width) for group in groups]


def _missing(parts: Sequence[Segment], directions: Sequence[Direction]) -> Iterator[tuple[str, str]]:
    """A flag for each direction that the record lacks, or holds too little of."""
    kinds = [item.segment.kind for item in directions]
    for kind, other in ((APPROACH, RETRACT), (RETRACT, APPROACH)):
        if kind in kinds:
            continue
        lack = f"only {other} rows" if other in kinds else "neither approach nor retraction"
        few = sum(len(part) for part in parts if part.kind == kind)
        yield f"no {kind}", f"{few} of its rows, at least {FEWEST_ROWS} are needed" if few else lack


def _on_base_lines(curve: Curve, touched: Sequence[Direction]) -> Iterator[tuple[str, str]]:
    """Flags of base lines that are not there, or not straight."""
    span = float(np.ptp(curve.load))
    for item in touched:
        name, waviness = item.segment.kind, item.base.waviness
        if not item.begins_free:
            end = "begins" if name == APPROACH else "ends"
            yield "no base line", f"the {name} {end} in contact, or has no straight part"
        elif waviness > RECORD_WAVY * span:
            sentence = (
                f"the base line of the {name} is wavy by {show(waviness, 'load')}, {waviness / span:.0%} of "
                "the range of the load (optical interference: fit --base-line sine)"
            )
            yield "wavy base line", sentence


def _permanent_set(curve: Curve, directions: Sequence[Direction]) -> tuple[tuple[str, str], ...]:
    """A flag with the depth at which the load of an unloading is gone without any tension: that of a dent."""
    sides = {item.segment.kind: item for item in directions}
    into, out = sides.get(APPROACH), sides.get(RETRACT)
    if into is None or out is None or not into.begins_free or isinstance(into.touch, Unknown):
        return ()
    z, P = (_blocks(v[out.segment.rows], _block(len(out.segment))) for v in (curve.device, curve.load))
    off, least = P - into.base(z), max(into.base.least, RECORD_SMALL * into.largest)
    gone = np.flatnonzero(off < least)
    if not gone.size or off.min() < -least:
        return ()
    dent, depth = float(z[gone[0]]) - into.touch, float(curve.device.max()) - into.touch
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


def _on_signs(curve: Curve, directions: Sequence[Direction]) -> Iterator[tuple[str, str]]:
    """Flags of devices that run to and fro, and of columns that count the other way round."""
    ways = (curve.device[item.segment.rows] for item in directions)
    means = [_blocks(way, max(1, round(way.size / 20))) for way in ways]  # without noise
    if any(float(np.abs(np.diff(way)).sum()) > RECORD_WANDERING * float(np.ptp(way)) for way in means):
        yield "no force curve", "the instrument reverses more than once"
    for item in directions:
        name = item.segment.kind
        # Whether a direction goes the other way than the file names it, or back and then in again.
        z = curve.device[item.segment.rows]
        ends = max(1, round(z.size * RECORD_FAR))
        first, last = float(z[:ends].mean()), float(z[-ends:].mean())
        way = (last - first) * (1 if item.segment.kind == APPROACH else -1)
        returns = min(first, last) - float(z.min())
        if max(-way, returns) > RECORD_HALF * float(np.ptp(z)):
            which = f" of the {name}" if len(directions) > 1 else ""  # of one that returns the last bits chose the name
            sentence = f"the displacement{which} has the opposite sign: indentation must be positive (--flip delta)"
            yield "wrong way", sentence
        elif len(directions) == 1 and presses_outward(curve.device[item.segment.rows], curve.load[item.segment.rows]):
            yield (
                "wrong way",
                ("the load rises while the displacement falls; indentation must be positive (--flip delta)"),
            )
        elif _pulls_deepest(curve, item):
            sentence = f"the load of the {name} is least where the instrument presses deepest"
            yield "wrong sign", f"{sentence}: is compression negative (--flip P)?"


def _pulls_deepest(curve: Curve, item: Direction) -> bool:
    """Whether tension is largest where it presses deepest, and compression is not, as where tension counts as
    positive; a gel that relaxes after the turn has both there."""
    z = curve.device[item.segment.rows]
    deepest = item.adhesion_at > z.max() - RECORD_SMALL * float(np.ptp(z))
    pressed = z[np.argmax(curve.load[item.segment.rows])] > item.adhesion_at
    return deepest and not pressed and item.based and isinstance(item.touch, float) and isinstance(item.adhesion, float)


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


SUBTRACTED_TWICE = "the displacement has its deflection subtracted already: leave --stiffness out"


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
    x, y = np.diff(delta, 3), np.diff(P, 3)
    usual = np.all([np.abs(column) <= TIP_POSITION_USUAL * np.median(np.abs(column)) for column in (x, y)], axis=0)
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
    side = _approach(curve)
    z, P = curve.device[side.segment.rows], curve.load[side.segment.rows]
    off, free = np.abs(P - side.base(z)), side.base.rows
    scatter = RECORD_NORMAL * median(off[:free])
    away = off > max(FIRST_TOUCH_SIGMAS * scatter, SAME * float(np.ptp(P)))  # the latter in records without noise
    first = max(int(np.argmax(in_succession(away))), 1)
    touch, half = float(z[first - 1] + z[first]) / 2, abs(float(z[first] - z[first - 1])) / 2
    flag = (
        f"contact point and force offset estimated from {free} free rows: first touch at "
        f"{show(touch, 'length')} (within "
        f"{show(half, 'length')}), baseline {show(float(side.base(np.array(touch))), 'load')} with a tilt of "
        f"{side.base.tilt:.3g} N/m"
    )
    P = curve.load - side.base(curve.device)
    delta = curve.device - touch - (0.0 if curve.stiffness is None else P / curve.stiffness)
    return replace(curve, delta=delta, P=P, flags=(*curve.flags, flag))


def _approach(curve: Curve) -> Direction:
    """The approach of a curve; InputError where it shows no zero points."""
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
    return side

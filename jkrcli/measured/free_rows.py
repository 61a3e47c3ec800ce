"""What the free rows of a force curve hold beside a straight base line: levels, attraction, errors of the signal.

A tether or a second weak contact holds the device at a tension after pull-off, level or along a line, and lets go at
once: a step of the load between free rows, which is found by its edges. Charge, a double layer or a van der Waals tail
draw the device in before contact: A f(gap/range), by f = exp(-x) or (1 + x)^-2, is A throughout contact, or 0 where it
is adhesion's own and ends at touch. A virtual deflection bends the base line by A ((z - z_touch)/way)^2, a drift from
the first row by A exp(-row/range); light that the specimen reflects adds a wave over z. Each is a term of the record's
model, whose size and range are fitted with the rest; what free rows alone tell of them is a start, and tells which
hypotheses are worth a fit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from ..base.numerics import HALF_WIDTH, Array, median
from ..base.units import show
from .lockstep import Flow, ask

# When a step of the free rows is one.
FREE_FEWEST = 40  # choice: free rows, below which no more than a line is seen in them
FREE_SEEN = 1e-4  # choice: of the free rows' range or the jump of contact, the noise of a row at least
FREE_SIGMAS = 7.0  # theory: 1e-12 of normal noise lies beyond; scales and places tried are 1e4
FREE_NARROWEST = 4  # choice: rows in a window beside an edge
FREE_WIDEST = 5  # theory: of the free rows, one part: two windows on each side of an edge
FREE_MOST = 4  # choice: steps of one direction
FREE_EVEN = 1.6  # choice: of the noise, what the line beside an edge leaves at most: more is ringing
FREE_LOCAL = 8  # choice: of the free rows, one part: rows on each side of an edge, by which its step is told
FREE_LEVEL = 0.9  # choice: of the jump of the contact, which is the largest, the tension beyond it at most
FREE_TETHER = 0.35  # choice: of it, the largest step of a tether; a larger one is a second contact's
FREE_EVEN_LEVEL = 0.5  # theory: of a step of a converter, by which neighbours differ where they are the same
FREE_RESTS = 0.7  # theory: share of equal neighbours; noise of half a step, which rounding averages over, leaves half
FREE_CODES = 1.5  # theory: steps of a converter, above which a level is none of them
FREE_SLOPED = 2.0  # theory: standard errors of the change along a level, from which it is told
# When a bend towards contact is an attraction.
FREE_BENDS = 16.0  # choice: fall of chi^2, four standard errors, from which on what bends is a hypothesis
FREE_MORE = 6.0  # choice: the same from which on a second or a third one is, or another one beside that
FREE_BLOCKS = 300  # choice: means of rows that a bend is looked for in
FREE_RANGES = np.array([0.02, 4.0])  # choice: of the free way, ranges of an attraction
FREE_DECAYS = np.array([0.02, 0.5])  # choice: of the rows, of a drift; of a slower one no more than a parabola is seen
FREE_TRIED = 22  # choice: ranges from which the best begins a search
FREE_FINER = 4  # theory: frequencies tried for each that the free way tells apart
# choice: of the free way, periods of a wave; theory: at least six blocks, whose means leave sinc(1/6) = 95 % of it
FREE_PERIODS = np.array([6 / FREE_BLOCKS, 1.0])
FREE_ROUNDS = 4  # choice: Newton's steps to the gap before a device that the attraction deflects
FREE_STEEPEST = 0.1  # choice: least share of the device's way that the gap closes by; below 0 it jumps
FREE_STEPS = 8  # choice: steps of Gauss and Newton to the least of the free rows, and halvings of each
FREE_LOOKED_AT = np.geomspace(0.03, 0.3, 5)  # choice: those that are looked at before, at contact and at the far end
FREE_APART = 36.0  # theory: fall of chi^2, six standard errors, by an amount for each direction
FREE_TELLS = 0.2  # choice: of the noise of a row, the least attraction at contact
FREE_DESCRIBED = 2.5  # choice: of chi^2 of the blocks per degree of freedom, that a law leaves at most,
FREE_DESCRIBED_BY_MORE = 1.5  # choice: and two or three
FREE_BENT = 200.0  # choice: the same that excludes a straight base line, as noise may be slow
FREE_EXCLUDED = 50.0  # choice: rise of chi^2 of the free rows, seven standard errors, that excludes a hypothesis

Shape: TypeAlias = Callable[[Array], Array]
LAWS: dict[str, tuple[Shape, Shape]] = {  # with their derivatives
    "exponential": (lambda x: np.exp(-x), lambda x: -np.exp(-x)),
    "power": (lambda x: (1 + x) ** -2.0, lambda x: -2 * (1 + x) ** -3.0),
}
VIRTUAL, DECAY, LEVEL, WAVE = "virtual deflection", "decaying drift", "level", "interference"
RELAXED = "relaxation in the dwell"
RANGE = "range:"  # and those that are logs of ranges
LOADS = ("size:", "change:", "cos:", "sin:")  # how unknowns of terms begin that are loads
STAYS = {True: "stays in contact", False: "ends at touch"}


@dataclass(frozen=True, eq=False)
class Side:
    """The free ``rows`` of a direction ``kind``, from the far end inwards, with positions ``x`` [m] and loads ``y``
    [N]; ``contact``: its other rows; ``jump`` [N]: the fall of the load where they meet; ``code`` [N]: the step of the
    converter; ``deep, pressed``: positions [m] and loads [N] of the other rows."""

    kind: str
    rows: Array
    x: Array
    y: Array
    contact: Array
    jump: float
    code: float
    deep: Array
    pressed: Array

    @property
    def noise(self) -> float:
        """Standard deviation of a row [N], at least what a converter and what matters leave."""
        least = FREE_SEEN * max(float(np.ptp(self.y)), abs(self.jump)) if self.y.size else 0.0
        return max(row_noise(self.y), self.code / math.sqrt(12), least)

    @property
    def rounds(self) -> bool:
        """Whether noise is too small to move rows between levels of a converter."""
        return row_noise(self.y) < self.code


@dataclass(frozen=True, eq=False)
class Place:
    """Where rows lie: their numbers ``rows``, positions ``x`` [m] of the device and of its ``tips``, whether they are
    ``free`` or ``inside`` contact, 1 on approach and 2 on retraction, else 0; ``at``: where contact begins [m];
    ``way``: the free one [m]; ``stiffness`` of the device [N/m]."""

    rows: Array
    x: Array
    tips: Array
    free: Array
    inside: Array
    at: float
    way: float
    stiffness: float

    def limits(self, law: str) -> tuple[float, float]:
        """The least and the largest log of the range of a term by a ``law``."""
        whole = float(self.rows.max()) if law == DECAY else self.way
        low, high = np.log(whole * {DECAY: FREE_DECAYS, WAVE: FREE_PERIODS}.get(law, FREE_RANGES)).tolist()
        return low, high

    def some(self, rows: Array) -> Place:
        """The same of some of the rows."""
        columns = {name: getattr(self, name)[rows] for name in ("rows", "x", "tips", "free", "inside")}
        return replace(self, **columns)


@dataclass(frozen=True)
class Term:
    """A load beside the contact by a ``law``: its ``values``, with standard ``errors``, are its size [N], and the log
    of its range [m; rows of a drift] or the change of a level along its rows [N]. An attraction ``stays`` in contact or
    ends at touch, a level stays as a spring that is stretched on; ``side``: the direction that it is of, 0: of all;
    ``between``: least and largest row of a level, ``far, near``: where it begins and ends [m], ``of_contact``: whether
    it is too large for a tether."""

    law: str
    values: tuple[float, ...]
    errors: tuple[float, ...] = (0.0, 0.0)
    stays: bool = True
    side: int = 0
    between: tuple[int, int] = (0, 0)
    far: float = 0.0
    near: float = 1.0
    of_contact: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Its unknowns in the model of a record."""
        label = f"{self.law} {self.between[0] or self.side or ''}".strip()
        names = {LEVEL: ("size", "change"), WAVE: ("cos", "range", "sin")}.get(self.law, ("size", "range"))
        return tuple(f"{name}:{label}" for name in names[: len(self.values)])

    @property
    def size(self) -> float:
        return self.values[0] if self.law != WAVE else math.hypot(self.values[0], self.values[2])

    @property
    def error(self) -> float:
        return self.errors[0]

    @property
    def range(self) -> float:
        return math.exp(self.values[1])

    @property
    def moves(self) -> bool:
        """Whether the depth of the tip follows it: what bends the device by what depends on the depth, or a surface
        that has sunk."""
        return self.law == RELAXED or (self.law == LEVEL and self.stays)

    def moved(self, place: Place, values: Sequence[float]) -> tuple[Array, list[Array]]:
        """How much higher the tip stands over the surface than the device says [m], and the derivatives of that."""
        if self.law == RELAXED:
            sunk = (place.inside == self.side).astype(float)
            return values[0] * sunk, [sunk]
        load, columns = self.at(place, values)
        bent = (place.inside > 0) / place.stiffness
        return (load - self.at(place, self.values)[0]) * bent, [column * bent for column in columns]

    def at(self, place: Place, values: Sequence[Any]) -> tuple[Array, list[Array]]:
        """The load [N] at rows, and its derivatives by the ``values``."""
        A, x = values[0], place.x
        free, inside = self._rows(place)
        if self.law == VIRTUAL:
            bend = ((x - place.at) / place.way) ** 2 * (free + inside)
            return A * bend, [bend]
        if self.law == DECAY:
            reach = np.exp(values[1])
            bend = np.exp(-place.rows / reach) * (free + inside)
            return A * bend, [bend, A * bend * place.rows / reach]
        if self.law == RELAXED:
            return np.zeros(x.size), [np.zeros(x.size)]
        if self.law == WAVE:
            phase = 2 * math.pi * (x - place.at) / np.exp(values[1])
            cos, sin = np.cos(phase) * (free + inside), np.sin(phase) * (free + inside)
            return A * cos + values[2] * sin, [cos, phase * (A * sin - values[2] * cos), sin]
        if self.law == LEVEL:
            on = free * (place.rows >= self.between[0]) * (place.rows <= self.between[1])
            along = (x - self.far) / (self.near - self.far)
            load, columns = (A + values[1] * along) * on, [on, along * on]
            if not self.stays:
                return load, columns
            # The line is that of a spring in series with the device, stretched from where it ends on: in contact, at
            # the same depth of the tip, -K max(end - tip, 0)
            B, way = values[1], self.near - self.far
            b = max(B / way, 1e-12 * abs(A) / way)
            K = b / max(1 - b / place.stiffness, 1e-2)
            end = self.far - A / b
            out, bound = inside * np.maximum(end - place.tips, 0.0), inside * (place.tips < end)
            by_b = -((K / b) ** 2) * out - K * bound * A / b**2
            return load - K * out, [columns[0] + K / b * bound, columns[1] + by_b / way]

        return self._attraction(place, values)[:2]

    def _rows(self, place: Place) -> tuple[Array, Array]:
        """Indicators (0 or 1) of the free rows, and of those in contact, that the term acts on."""
        own = (kinds == self.side if self.side else kinds > 0 for kinds in (place.free, place.inside))
        free, inside = (rows.astype(float) for rows in own)
        return free, inside

    def beside_contact(self, place: Place, values: Sequence[float], zero: float) -> tuple[Array, list[Array], Array]:
        """The same, and the derivative by the ``zero`` of the depth in contact [N/m]: where the gap of an attraction
        closes, by what is taken off in contact, which is what stays."""
        if self.law not in LAWS:
            return *self.at(place, values), np.zeros(place.x.size)
        place = replace(place, at=zero + (self.size if self.stays else values[0]) / place.stiffness)
        load, columns, by_at = self._attraction(place, values)
        columns[0] = columns[0] + by_at * (not self.stays) / place.stiffness
        return load, columns, by_at

    def _attraction(self, place: Place, values: Sequence[Any]) -> tuple[Array, list[Array], Array]:
        """``at`` of an attraction, and its derivative by the place of contact [N/m]. The gap before a device that it
        deflects, at - z + A (f(gap/range) - 1)/k, is by Newton's steps."""
        (A, log), k, (f, slope), (free, inside) = values, place.stiffness, LAWS[self.law], self._rows(place)
        reach, gap = np.exp(log), np.maximum(place.at - place.x, 0.0)
        for _ in range(FREE_ROUNDS if A and math.isfinite(k) else 0):
            off = gap - place.at + place.x - A * (f(gap / reach) - 1) / k
            rate = 1 - A * slope(gap / reach) / (reach * k)
            gap = np.maximum(gap - off / np.maximum(rate, FREE_STEEPEST), 0.0)
        shape, fall = f(gap / reach), A * slope(gap / reach) / reach * (gap > 0)
        by_at = fall / np.maximum(1 - fall / k, FREE_STEEPEST) * free
        bend = shape * free + self.stays * inside
        return A * bend, [bend + by_at * (shape - 1) / k, -by_at * gap], by_at

    @property
    def words(self) -> str:
        error = f" ± {show(HALF_WIDTH * self.error, 'length' if self.law == RELAXED else 'load', 2)}"
        if self.law == LEVEL:
            change, sloped = self.values[1], abs(self.values[1]) > FREE_SLOPED * self.errors[1]
            end = f" to {show(self.size + change, 'load', 3)}" * sloped
            ends, what = f"{show(self.far, 'length', 4)} and {show(self.near, 'length', 4)}", "a second contact"
            what = (what if self.of_contact else f"a tether or {what}") + ", stretched in contact too" * self.stays
            return f"a level of {show(self.size, 'load', 3)}{error}{end} between {ends} after contact is lost: {what}"
        if self.law == RELAXED:
            sunk = f"{show(self.size, 'length', 3)}{error}"
            return f"{RELAXED}, by which the surface has sunk by {sunk} before the retraction"
        size = f"{show(abs(self.size), 'load', 3)}{error}"
        if self.law == VIRTUAL:
            return f"a {VIRTUAL} that bends the base line by {size} over the free way"
        if self.law == DECAY:
            return f"a {DECAY} of the load, {size} at first, by a factor e over {self.range:.3g} rows"
        if self.law == WAVE:
            return f"a wave of {size} and a period of {show(self.range, 'length', 4)}: {WAVE}"
        what = "an attraction" if self.size < 0 else "a repulsion"
        reach = f"{self.law} over a range of {show(self.range, 'length', 3)}"
        return f"{what} before contact of {size} at contact, {reach}, that {STAYS[self.stays]}"

    @property
    def brief(self) -> str:
        """What it is beside another one."""
        return f"{self.law}, {STAYS[self.stays]}" if self.law in LAWS else self.law


@dataclass(frozen=True, eq=False)
class FreeRows:
    """What is taken off the loads of a record: ``terms``, at the rows of its ``place``; ``spoilt``: rows within an
    edge; ``others``: terms that the free rows do not tell from these; ``rounding`` [N]: what a converter leaves of the
    offset, where noise does not move it between levels, and ``raised``: by it the loads in contact [N], by rows;
    ``sunk``: by what the surface may have sunk in a dwell; ``left_out``: rows that something else holds."""

    place: Place
    terms: tuple[Term, ...]
    spoilt: Array
    others: tuple[tuple[Term, ...], ...] = ()
    rounding: float = 0.0
    raised: tuple[Array, ...] = ()
    sunk: Term | None = None
    left_out: int = 0

    @cached_property
    def taken(self) -> Array:
        """The load [N] of all terms at all rows."""
        return self._sum(self.terms)

    @property
    def of_signal(self) -> Array:
        """What of it is no force, but an error of the signal [N]: a virtual deflection or a drift."""
        return self._sum([term for term in self.terms if term.law not in (*LAWS, LEVEL)])

    def _sum(self, terms: Sequence[Term]) -> Array:
        return sum((term.at(self.place, term.values)[0] for term in terms), np.zeros(self.place.x.size))

    @property
    def names(self) -> tuple[str, ...]:
        """The unknowns of all terms."""
        return tuple(name for term in self.terms for name in term.names)

    @property
    def levels(self) -> tuple[Term, ...]:
        return tuple(term for term in self.terms if term.law == LEVEL)

    @property
    def bends(self) -> tuple[Term, ...]:
        """What bends the base line."""
        return tuple(term for term in self.terms if term.law not in (LEVEL, RELAXED))

    @property
    def words(self) -> Iterator[str]:
        if self.rounding:
            offset = show(self.rounding, "load", 2)
            yield f"they lie on levels of an A/D converter: the force offset is known to {offset}"
        if self.left_out:
            yield f"{self.left_out} of them, after contact is lost, are held by several tethers and are left out"
        yield from (term.words for term in self.terms)

    @property
    def brief(self) -> str:
        """What bends the base line, in a word or two."""
        stretched = f"{LEVEL} stretched in contact"
        springs = [stretched if term.law == LEVEL else RELAXED for term in self.terms if term.moves]
        return " and ".join([*(term.brief for term in self.bends), *springs]) or "a straight base line"

    def of(self, *terms: Term) -> FreeRows:
        """The same of other terms."""
        return replace(self, terms=terms)

    @property
    def straight(self) -> FreeRows:
        """The same without what bends the base line."""
        return self.of(*(term for term in self.terms if term not in self.bends))

    def scaled(self, factor: float, stiffness: float) -> FreeRows:
        """The same of loads that are ``factor`` times as large, by a device of a ``stiffness`` [N/m]."""
        each = [zip(term.names, term.values, strict=True) for term in self.terms]
        loads = [tuple(value * factor if name.startswith(LOADS) else value for name, value in own) for own in each]
        terms = tuple(replace(term, values=values) for term, values in zip(self.terms, loads, strict=True))
        return replace(self, terms=terms, place=replace(self.place, stiffness=stiffness))

    @property
    def hypotheses(self) -> list[FreeRows]:
        """What free rows may hold beside their levels: all that they do not tell apart, each attraction in contact or
        not, or nothing; and the innermost level, where its tension rises away from contact, as a spring that is
        stretched in contact, too."""
        found, levels = list[FreeRows](), self.levels
        for terms in (self.terms, *self.others):
            # adhesion's own is an attraction
            ends = tuple(replace(term, stays=False) if term.law in LAWS and term.size < 0 else term for term in terms)
            found += [self.of(*each) for each in dict.fromkeys([terms, ends])]
        if levels and levels[-1].values[1] > FREE_SLOPED * levels[-1].errors[1]:
            spring = replace(levels[-1], stays=True)
            found.append(self.of(*(spring if term is levels[-1] else term for term in self.terms)))
        sinks = [()] if self.sunk is None else [(self.sunk,), ()]
        return [one.of(*one.terms, *sunk) for one in found for sunk in sinks]


def free_rows(sides: Sequence[Side], size: int, stiffness: float, sunk: float = 0.0) -> Flow[FreeRows | None]:
    """What the free rows of some directions hold beside lines, as a flow; None where that is nothing.

    ``size``: rows of the record, ``stiffness`` of the device [N/m]; ``sunk``: by how much the surface may have sunk in
    a dwell [m].
    """
    x, tips, free, inside = np.zeros(size), np.zeros(size), np.zeros(size, dtype=int), np.zeros(size, dtype=int)
    used = [side for side in sides if side.x.size]
    for side in used:
        number = 1 + (side.kind != "approach")
        x[side.rows], x[side.contact] = side.x, side.deep
        free[side.rows], inside[side.contact] = number, number
        base = float(np.mean(side.y[: max(side.y.size // 4, 1)]))
        tips[side.contact] = side.deep - (side.pressed - base) / stiffness
    at = next((float(side.x[-1]) for side in sorted(used, key=lambda one: one.kind != "approach")), 0.0)
    way = max((float(np.ptp(side.x)) for side in used), default=1.0) or 1.0
    place = Place(np.arange(size), x, tips, free, inside, at, way, stiffness)
    levels = [_levels(side) for side in sides]
    uneven = [side.rows[rows - 1 :] for side, (_, rows) in zip(sides, levels, strict=True) if rows < side.y.size]
    sides = [replace(side, rows=side.rows[:rows], x=side.x[:rows], y=side.y[:rows])
             for side, (_, rows) in zip(sides, levels, strict=True)]  # fmt: skip
    found = [(side, *level) for side, (of_side, _) in zip(sides, levels, strict=True) for level in of_side]
    spoilt = [np.zeros(0, dtype=int), *(side.rows[max(edge - 1, 0) : edge + 2] for side, edge, _ in found)]
    terms = yield from _bends(sides, place, [term for _, _, term in found])
    # Rows that rest on one level of a converter, with noise below it, know their load to its share of a level only.
    coded = [side for side in sides if side.code and side.y.size >= FREE_FEWEST]
    rest = [side for side in coded if np.mean(np.abs(np.diff(side.y)) < FREE_EVEN_LEVEL * side.code) > FREE_RESTS]
    rounding, raised = max((side.code for side in rest), default=0.0) / math.sqrt(12), list[Array]()
    for power in (0, 1) if rounding else ():  # of the offset, and of the tilt over the free way
        own = np.zeros(size)
        for side in sides:
            way = (side.deep - side.x.mean()) / (np.ptp(side.x) / 2 or 1.0) if side.x.size else 0.0
            own[side.contact] = rounding * way**power
        raised.append(own)
    if not (raised or terms or sunk or uneven):
        return None
    best, *others = terms or [()]
    relaxed = Term(RELAXED, (sunk,), (0.0,), side=2) if sunk else None
    left_out = sum(rows.size for rows in uneven)
    spoilt += uneven
    return FreeRows(place, best, np.concatenate(spoilt), tuple(others), rounding, tuple(raised), relaxed, left_out)


def row_noise(y: Array) -> float:
    """Standard deviation of a row by second differences, whatever the rows follow."""
    steps = y[1:] - y[:-1]
    return 1.4826 * median(np.abs(steps[1:] - steps[:-1])) / math.sqrt(6) if y.size > 3 else 0.0


# ---------------------------------------------------------------------- levels
def _levels(side: Side) -> tuple[list[tuple[int, Term]], int]:
    """Tensions along lines, from the far end inwards, each from an edge, a row of the side, up to the next: all that
    lie outside of a contact that lets go by a jump; and how many rows are free of what is neither free nor a line."""
    edges, rows = list[int](), side.y.size
    if side.y.size < FREE_FEWEST or not side.jump < 0:
        return [], rows
    # Single rows that stand out are no edges, nor uneven
    near = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(side.y, FREE_NARROWEST // 2, "edge"),
                                                              FREE_NARROWEST + 1), axis=1)  # fmt: skip
    side = replace(side, y=np.where(np.abs(side.y - near) > FREE_SIGMAS * side.noise, near, side.y))
    steps: dict[int, tuple[float, float, float]] = {}
    for _ in range(FREE_MOST):
        stairs = sum((step * (np.arange(rows) >= edge) for edge, (step, _, _) in steps.items()), np.zeros(rows))
        edge = _edge(side.y - stairs, side.noise)
        if edge is None or edge in steps:
            break
        edges = sorted({*edges, edge})
        around = zip([0, *edges], edges, [*edges[1:], rows], strict=False)
        steps = {edge: _step(side, before, edge, after) for before, edge, after in around}
    edges = [edge for edge in edges if abs(steps[edge][0]) > FREE_SIGMAS * steps[edge][1]]
    tensions = np.cumsum([steps[edge][0] for edge in edges])
    falls = all(steps[edge][0] < -FREE_CODES * side.code for edge in edges)
    tethers = falls and edges and tensions.min() > FREE_LEVEL * side.jump
    if not tethers or any(steps[edge][2] > FREE_EVEN * side.noise for edge in edges):
        return [], edges[0] if tethers and len(edges) > 1 else rows
    found = list[tuple[int, Term]]()
    ends = [end - 1 for end in (*edges[1:], side.y.size)]
    for edge, end, tension in zip(edges, ends, tensions.tolist(), strict=True):
        if end > edge:
            (first, last), (far, near) = sorted(side.rows[[edge, end]].tolist()), side.x[[edge, end]].tolist()
            second = steps[edge][0] < FREE_TETHER * side.jump
            level = Term(LEVEL, (tension, 0.0), (0.0, 0.0), False, 0, (first, last), far, near, second)
            found.append((edge, level))
    return found, rows


def _step(side: Side, before: int, edge: int, after: int) -> tuple[float, float, float]:
    """The step of the load at an ``edge`` [N] between lines through the rows on both sides, up to those ``before`` and
    ``after``, its standard error, and what these leave."""
    near = max(side.y.size // FREE_LOCAL, FREE_FEWEST // 2)
    first, last = max(before, edge - near), min(after, edge + near)
    rows = np.arange(first, last)
    on, along = (rows >= edge).astype(float), (rows - edge) / near
    design = np.column_stack([np.ones(rows.size), along, on, on * along])
    values = np.linalg.lstsq(design, side.y[first:last], rcond=None)[0]
    left = float(np.std(side.y[first:last] - design @ values))
    error = max(side.noise, left) * math.sqrt(float(np.linalg.pinv(design.T @ design)[2, 2]))
    return float(values[2]), error, left


def _edge(y: Array, noise: float) -> int | None:
    """The row at which the load changes at once, by the change between two windows over those to the next windows on
    both sides; None where none stands out at any width."""
    best, widest = (0.0, 0, 0), y.size // FREE_WIDEST
    total = np.zeros(y.size + 1)
    np.cumsum(y - y.mean(), out=total[1:])
    width = FREE_NARROWEST
    while width <= widest:
        # of the means a, b, c, d of windows, (a - d)/2 + 3/2 (c - b): a fourth difference of the sums at their edges
        change = total
        for _ in range(4):
            change = change[width:] - change[:-width]
        change = np.abs(change)
        at, unit = int(change.argmax()), 2 * width
        least = noise * math.sqrt(5 / width) * unit
        if change[at] > max(best[0], FREE_SIGMAS) * least:  # or it cannot stand out, whatever is usual
            usual = max(1.4826 * median(change), least)
            if usual > 0 and change[at] / usual > max(best[0], FREE_SIGMAS):
                best = (change[at] / usual, at + 2 * width, width)
        width *= 2
    if best[0] == 0:
        return None
    _, middle, width = best
    first, last = middle - 2 * width, middle + 2 * width
    part = y[first:last]
    rows = np.arange(part.size)
    near = range(max(width, 2), 3 * width + 1)
    left = []
    for edge in near:
        design = np.column_stack([np.ones(part.size), rows, rows >= edge])
        off = part - design @ np.linalg.lstsq(design, part, rcond=None)[0]
        left.append(float(off @ off))
    return first + near[int(np.argmin(left))]


# ---------------------------------------------------------------------- attraction, virtual deflection, drift
@dataclass(frozen=True, eq=False)
class _Blocks:
    """Means of free rows of all sides: where they lie, loads ``y`` [N] and standard deviations ``noise``, and over
    these the ``lines`` of each side and of the ``levels``, (blocks, 2 for each)."""

    place: Place
    y: Array
    noise: Array
    lines: Array
    levels: tuple[Term, ...]

    @classmethod
    def of(cls, sides: Sequence[Side], place: Place, levels: Sequence[Term]) -> _Blocks:
        means, ends, columns = list[Array](), [0], list[Array]()
        for side in sides:
            size, own = max(1, side.y.size // FREE_BLOCKS), place.some(side.rows)
            of_levels = [column for term in levels for column in term.at(own, term.values)[1]]
            each = (v[v.size % size :].reshape(-1, size) for v in (side.rows.astype(float), side.x, side.y, *of_levels))
            rows, x, y, *of_levels = (np.einsum("ij->i", v) / size for v in each)
            rounding = side.code / math.sqrt(12) * side.rounds  # which means do not lessen
            noise = max(row_noise(y), side.noise / math.sqrt(size), rounding)
            means.append(np.vstack([rows, x, y, np.full((2, y.size), [[1 + (side.kind != "approach")], [noise]])]))
            columns.append(np.array(of_levels).reshape(-1, y.size))
            ends.append(ends[-1] + y.size)
        rows, x, y, number, noise = np.concatenate(means, axis=1)
        lines = np.zeros((y.size, 2 * len(means)))
        for i, (first, last) in enumerate(itertools.pairwise(ends)):
            lines[first:last, 2 * i], lines[first:last, 2 * i + 1] = 1.0, x[first:last] - x[last - 1]
        lines[:, 1::2] /= place.way
        lines = np.column_stack([lines, np.concatenate(columns, axis=1).T])
        of_blocks = replace(place, rows=rows, x=x, tips=x, free=number.astype(int), inside=np.zeros(y.size, dtype=int))
        return cls(of_blocks, y, noise, lines / noise[:, None], tuple(levels))

    def with_levels(self, terms: Sequence[Term]) -> tuple[Term, ...]:
        """The levels as they are beside ``terms``, and these."""
        off = self.less(terms).y / self.noise
        values = (self._inverse @ off)[-2 * len(self.levels) :].reshape(-1, 2).tolist() if self.levels else []
        errors = np.linalg.norm(self._inverse, axis=1)[-2 * len(self.levels) :].reshape(-1, 2).tolist()
        levels = (replace(level, values=tuple(value), errors=tuple(error))
                  for level, value, error in zip(self.levels, values, errors, strict=False))  # fmt: skip
        return (*levels, *terms)

    def less(self, terms: Sequence[Term]) -> _Blocks:
        """The same less what ``terms`` make of their loads."""
        return replace(self, y=self.y - sum(term.at(self.place, term.values)[0] for term in terms))

    @property
    def dof(self) -> int:
        return max(self.y.size - self.lines.shape[1] - 2, 1)

    @cached_property
    def straight(self) -> _Bent:
        """Lines alone."""
        off = self._beside_lines(self.y)
        return _Bent(float(off @ off), (), off, np.zeros((off.size, 0)))

    def _beside_lines(self, columns: Array) -> Array:
        """Columns (blocks, n) less their projection on lines, over the noise."""
        scaled = (columns.T / self.noise).T
        return scaled - self.lines @ (self._inverse @ scaled)

    @cached_property
    def _inverse(self) -> Array:
        return np.linalg.pinv(self.lines)

    @np.errstate(over="ignore", invalid="ignore")
    def fitted(self, terms: Sequence[Term]) -> _Bent:
        """The ``terms`` as they leave least beside lines, by Gauss and Newton's steps from where they are."""
        free = -math.inf, math.inf
        names = [(term.law, name) for term in terms for name in term.names]
        least, most = np.array([self.place.limits(law) if name.startswith(RANGE) else free for law, name in names]).T

        def at(values: Array) -> tuple[float, Array, Array]:
            loads, columns, first = np.zeros(self.y.size), list[Array](), 0
            for term in terms:
                load, by = term.at(self.place, values[first : (first := first + len(term.values))].tolist())
                loads, columns = loads + load, [*columns, *by]
            off, J = self._beside_lines(self.y - loads), self._beside_lines(np.column_stack(columns))
            return float(off @ off), off, J

        values = np.array([value for term in terms for value in term.values])
        cost, off, J = at(values)
        for _ in range(FREE_STEPS):
            scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
            step = np.linalg.lstsq(J / scale, off, rcond=1e-10)[0] / scale
            for _ in range(FREE_STEPS):
                tried = np.clip(values + step, least, most)
                if (new := at(tried))[0] < cost:
                    break
                step = step / 2
            else:
                break
            fell, (cost, off, J), values = cost - new[0], new, tried
            if fell < 1e-3:
                break
        colour = max(cost / self.dof, 1.0)
        scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
        scaled = J / scale
        errors = np.sqrt(colour * np.maximum(np.linalg.pinv(scaled.T @ scaled).diagonal(), 0.0)) / scale
        found, first = list[Term](), 0
        for term in terms:
            own = slice(first, first := first + len(term.values))
            found.append(replace(term, values=tuple(values[own].tolist()), errors=tuple(errors[own].tolist())))
        return _Bent(cost, tuple(found), off, np.linalg.qr(scaled)[0])

    def begun(self, law: str, bent: _Bent) -> tuple[tuple[Term, ...], float]:
        """The terms of ``bent`` and one by a ``law``, of the range tried with which they leave least to first order,
        and the chi^2 that this is."""
        logs, columns = self._tried[law]
        columns = columns - bent.Q @ (bent.Q.T @ columns)
        u, v = columns[0], columns[-1] * (law == WAVE)
        uu = np.maximum(np.einsum("ij,ij->j", u, u), 1e-300)
        uv = np.einsum("ij,ij->j", u, v) / uu
        v = v - u * uv
        vv = np.einsum("ij,ij->j", v, v)
        along = bent.off @ u / uu, np.where(vv > 1e-6 * uu, bent.off @ v / np.maximum(vv, 1e-300), 0.0)
        falls = along[0] ** 2 * uu + along[1] ** 2 * vv
        best = int(falls.argmax())
        size, sine = float(along[0][best] - along[1][best] * uv[best]), float(along[1][best])
        values = (size, float(logs[best]), sine)[: {VIRTUAL: 1, WAVE: 3}.get(law, 2)]
        return (*bent.terms, Term(law, values, (0.0,) * len(values))), bent.cost - float(falls[best])

    def with_another(self, several: Sequence[_Bent], by: Iterable[str], least: float) -> list[_Bent]:
        """Those of ``several`` with one more term ``by`` other laws that leave less than the ``least`` by more than
        chance: begun from where they leave least to first order, unless that is no less."""
        begun = dict[frozenset[str], tuple[float, tuple[Term, ...]]]()
        for bent, law in itertools.product(several, by):
            laws = {term.law for term in bent.terms}
            if laws.isdisjoint(LAWS.keys() if law in LAWS else {law}):
                begin, cost = self.begun(law, bent)
                if cost < begun.get(key := frozenset({*laws, law}), (least, begin))[0]:
                    begun[key] = cost, begin
        more = [self.fitted(begin) for _, begin in begun.values()]
        colour = max(min((one.cost for one in more), default=0.0) / self.dof, 1.0)
        return [one for one in more if least - one.cost > colour * FREE_MORE]

    @cached_property
    def _tried(self) -> dict[str, tuple[Array, Array]]:
        """By law the logs of ranges, and the load per size with each where nothing is deflected, beside lines, (1,
        blocks, ranges); of a wave cosines and sines."""
        tried, place = dict[str, tuple[Array, Array]](), self.place.some(np.arange(self.y.size)[:, None])
        # of a wave those that the free way tells apart
        waves = np.log(place.way / np.arange(1 / FREE_PERIODS[1], 1 / FREE_PERIODS[0], 1 / FREE_FINER))
        for law in (*LAWS, VIRTUAL, DECAY, WAVE):
            logs = waves if law == WAVE else np.linspace(*place.limits(law), 1 if law == VIRTUAL else FREE_TRIED)
            columns = Term(law, ()).at(place, (0.0, logs, 0.0)[: 3 if law == WAVE else 2])[1][::2]
            tried[law] = logs, np.array([self._beside_lines(column) for column in columns])
        return tried


@dataclass(frozen=True, eq=False)
class _Bent:
    """``terms`` as they fit free rows best, and the ``cost``, chi^2, that is left; what they leave ``off`` blocks, and
    orthonormal columns ``Q`` of their derivatives, beside lines."""

    cost: float
    terms: tuple[Term, ...]
    off: Array
    Q: Array


def _bends(sides: Sequence[Side], place: Place, levels: Sequence[Term]) -> Flow[list[tuple[Term, ...]]]:
    """What bends the base lines, the likeliest by the free rows first: an attraction, where they bend at contact; a
    virtual deflection or a drift, where they bend at all; two of these, where one leaves more than noise; none where
    none of these describes them."""
    usable = [side for side in sides if side.y.size >= FREE_FEWEST and side.noise > 0]
    if not usable:
        return [tuple(levels)] if levels else []
    blocks = _Blocks.of(usable, place, levels)
    straight = [blocks.with_levels(())] if levels else []
    at, way, noise = place.at, place.way, max(side.noise for side in usable)
    numbers, y = blocks.place.free, blocks.less(blocks.with_levels(())).y
    each = [(blocks.place.x[mine], y[mine], float(blocks.noise[mine][0]))
            for mine in (numbers == number for number in np.unique(numbers))]  # fmt: skip
    near, far = yield from ask(_falls, (each, at, way))
    if max(near, far) < FREE_BENDS and blocks.straight.cost < blocks.dof + FREE_BENDS:
        return straight
    # Rows next to contact may belong to it, or to a slow jump: what bends is seen without them, too.
    beyond = [(x < at - FREE_RANGES[0] * way, x, y, noise) for x, y, noise in each]
    apart = [(x[some], y[some], noise) for some, x, y, noise in beyond if some.any()]
    seen = max((yield from ask(_falls, (apart, at, way)))) >= FREE_BENDS if apart else False
    if not apart or not (seen or blocks.straight.cost >= blocks.dof + FREE_BENDS):
        return straight

    single = {law: blocks.fitted(blocks.begun(law, blocks.straight)[0]) for law in (*LAWS, VIRTUAL, DECAY, WAVE)}
    found = list(single.values())
    if near >= FREE_BENDS and len(usable) > 1:
        sided = [blocks.fitted([replace(single[law].terms[0], side=side) for side in (1, 2)]) for law in LAWS]
        colour = max(min(one.cost for one in sided) / blocks.dof, 1.0)
        if min(single[law].cost for law in LAWS) - min(one.cost for one in sided) > colour * FREE_APART:
            found += sided
    if two := blocks.with_another([*single.values()], single, min(one.cost for one in found)):
        best = min(two, key=lambda one: one.cost)
        found += two + blocks.with_another([best], single, best.cost)
    least = max(FREE_TELLS * noise, *(side.code * side.rounds for side in usable))
    found = [one for one in found if _describes(one, blocks) and min(abs(term.size) for term in one.terms) >= least]
    if not any(blocks.straight.cost - one.cost >= max(one.cost / blocks.dof, 1.0) * FREE_BENDS for one in found):
        return straight
    colour = max(min(one.cost for one in found) / blocks.dof, 1.0)
    found.sort(key=lambda one: one.cost + colour * FREE_BENDS * len(one.terms))
    most = found[0].cost + colour * FREE_EXCLUDED
    found = [one for one in found if one.cost < most]
    found += [blocks.straight] * (blocks.straight.cost < found[0].cost + colour * FREE_BENT)
    return [blocks.with_levels(one.terms) for one in found]


def _describes(bent: _Bent, blocks: _Blocks) -> bool:
    """Whether what terms leave is noise, and beside it what lines leave is not."""
    colour = max(bent.cost / blocks.dof, 1.0)
    several = len({term.law for term in bent.terms}) > 1
    if several and any(abs(term.size) < FREE_SLOPED * term.error for term in bent.terms):
        return False  # of which one makes up for what another one makes
    most = FREE_DESCRIBED_BY_MORE if several else FREE_DESCRIBED
    return blocks.straight.cost - bent.cost >= colour * FREE_MORE and colour <= most


def _falls(asked: Sequence[tuple[Sequence[tuple[Array, Array, float]], float, float]]) -> list[tuple[float, float]]:
    """How far chi^2 of lines falls by a bend at contact, and by one at the far end, each of the best range; ``asked``:
    the blocks of each record, the position of contact and the free way [m]."""
    sides = [(x, y, noise, at, way) for blocks, at, way in asked for x, y, noise in blocks]
    counts = np.array([x.size for x, *_ in sides])
    starts = np.cumsum(counts) - counts
    records = starts[np.cumsum([0, *(len(blocks) for blocks, _, _ in asked[:-1])])]
    numbers = zip(*((max(noise, 1e-300), at, way) for _, _, noise, at, way in sides), strict=True)
    noise, at, way = (np.repeat(values, counts) for values in numbers)
    x, y = (np.concatenate([side[column] for side in sides]) for column in (0, 1))

    def of_side(values: Array) -> Array:
        """The sums over the rows of each side, at each of them."""
        return np.repeat(np.add.reduceat(values, starts, axis=-1), counts, axis=-1)

    rows = np.repeat(counts, counts)
    along = x - of_side(x) / rows
    length = np.sqrt(of_side(along**2))
    along /= np.where(length > 0, length, 1.0)

    def beside_lines(values: Array) -> Array:
        """What the line of each side leaves."""
        values = values / noise
        values -= of_side(values) / rows
        return values - of_side(values * along) * along

    def by_each(columns: Array) -> Array:
        """Falls of the sum of squares of ``off`` by each of some columns (n, rows), of each record (n, records)."""
        square = np.add.reduceat(columns**2, records, axis=1)
        return np.add.reduceat(columns * off, records, axis=1) ** 2 / np.maximum(square, 1e-300)

    off, shares = beside_lines(y), -1 / FREE_LOOKED_AT
    ways = np.maximum(at - x, 0.0) / way, (x - np.repeat(x[starts], counts)) / way  # from contact, and from the far end
    falls = [by_each(beside_lines(np.exp(np.outer(shares, one)))).max(axis=0).tolist() for one in ways]
    return list(zip(*falls, strict=True))

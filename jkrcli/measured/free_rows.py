"""What the free rows of a force curve hold beside a straight base line: levels and attraction.

A tether or a second weak contact holds the device at a level tension after pull-off, and lets go at once: a step of
the load between free rows, which is found by its edges. Charge, a double layer or a van der Waals tail draw the device
in before contact: A f(gap/range), by f = exp(-x) or (1 + x)^-2, is A throughout contact, or 0 where it is adhesion's
own and ends at touch. Both are taken off the load before anything else is read from it; how well they are known, and
which of them there are, a fit finds out with loads that are a little different.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from ..base.numerics import HALF_WIDTH, Array, median
from ..base.units import show
from .lockstep import Flow, ask

STAYS = {True: "stays in contact", False: "ends at touch"}

# When a step of the free rows is one.
FREE_FEWEST = 40  # choice: free rows, below which no more than a line is seen in them
FREE_SEEN = 1e-4  # choice: of the free rows' range or the jump of contact, the noise of a row at least
FREE_SIGMAS = 7.0  # theory: 1e-12 of normal noise lies beyond; scales and places tried are 1e4
FREE_NARROWEST = 4  # choice: rows in a window beside an edge
FREE_WIDEST = 5  # theory: of the free rows, one part: two windows on each side of an edge
FREE_MOST = 4  # choice: steps of one direction
FREE_EVEN = 1.6  # choice: of the noise, what the levels beside an edge leave at most: more is ringing
FREE_LEVEL = 0.35  # choice: of the jump of the contact, the largest level that is a tether's and no second contact's
FREE_EVEN_LEVEL = 0.5  # theory: of a step of a converter, by which neighbours differ where they are the same
FREE_RESTS = 0.7  # theory: share of equal neighbours; noise of half a step, which rounding averages over, leaves half
FREE_CODES = 1.5  # theory: steps of a converter, above which a level is none of them
# When a bend towards contact is an attraction.
FREE_BENDS = 16.0  # choice: fall of chi^2, four standard errors, from which on what bends is a hypothesis
FREE_BLOCKS = 150  # choice: means of rows that a bend is looked for in
FREE_RANGES = np.geomspace(0.02, 4.0, 22)  # choice: of the free way, ranges tried
FREE_COARSE = math.log(FREE_RANGES[1] / FREE_RANGES[0])  # theory: of logs, the distance of two of them
FREE_FINER = 4  # choice: rounds of finer ranges, each by a third
FREE_ROUNDS = 3  # theory: of the deflection by the attraction, which converges by the ratio of stiffnesses each
FREE_LOOKED_AT = np.geomspace(0.03, 0.3, 5)  # choice: those that are looked at before, at contact and at the far end
FREE_SLOWEST = 0.5  # choice: of the rows, range of a drift that decays; of a slower one no more than a parabola is seen
FREE_APART = 36.0  # theory: fall of chi^2, six standard errors, by an amount for each direction
FREE_TELLS = 0.2  # choice: of the noise of a row, the least attraction at contact
FREE_DESCRIBED = 2.5  # choice: of chi^2 of the blocks per degree of freedom, that a law leaves at most
FREE_SHALLOWEST = 0.05  # choice: rise of chi^2 by a standard error at a given range, below which it is no parabola

LAWS: dict[str, Callable[[Array], Array]] = {"exponential": lambda x: np.exp(-x), "power": lambda x: (1 + x) ** -2.0}
VIRTUAL, DECAY = "virtual deflection", "decaying drift"  # a parabola over the positions; exp(-row/range) from the first


@dataclass(frozen=True, eq=False)
class Side:
    """The free ``rows`` of a direction ``kind``, from the far end inwards, with positions ``x`` [m] and loads ``y``
    [N]; ``contact``: its other rows; ``jump`` [N]: the fall of the load where they meet; ``code`` [N]: the step of the
    converter; ``deep``: positions of the other rows [m]."""

    kind: str
    rows: Array
    x: Array
    y: Array
    contact: Array
    jump: float
    code: float
    deep: Array

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a row [N], at least what a converter and what matters leave."""
        least = FREE_SEEN * max(float(np.ptp(self.y)), abs(self.jump)) if self.y.size else 0.0
        return max(row_noise(self.y), self.code / math.sqrt(12), least)


@dataclass(frozen=True)
class Level:
    """A level tension [N] of free rows of the direction ``kind``, with its standard ``error``, between positions."""

    kind: str
    size: float
    error: float
    far: float
    near: float

    @property
    def words(self) -> str:
        return (
            f"a level of {show(self.size, 'load', 3)} ± {show(HALF_WIDTH * self.error, 'load', 2)} between "
            f"{show(self.far, 'length', 4)} and {show(self.near, 'length', 4)} after contact is lost: a tether or a "
            "second contact"
        )


@dataclass(frozen=True)
class Attraction:
    """An attraction of ``size`` [N] at contact, with its standard ``error``, over a ``range`` [m] by a ``law``, that
    ``stays`` in contact, or ends at touch; or what bends the base line of all rows: a virtual deflection of ``size``
    over the free way, or a drift that decays over ``range`` rows."""

    size: float
    error: float
    range: float
    law: str
    stays: bool = True

    @property
    def words(self) -> str:
        what = "an attraction" if self.size < 0 else "a repulsion"
        size = f"{show(abs(self.size), 'load', 3)} ± {show(HALF_WIDTH * self.error, 'load', 2)}"
        if self.law == VIRTUAL:
            return f"a {VIRTUAL} that bends the base line by {size} over the free way"
        if self.law == DECAY:
            return f"a {DECAY} of the load, {size} at first, by a factor e over {self.range:.3g} rows"
        reach = f"{self.law} over a range of {show(self.range, 'length', 3)}"
        return f"{what} before contact of {size} at contact, {reach}, that {STAYS[self.stays]}"

    @property
    def brief(self) -> str:
        """What it is beside another one."""
        return f"{self.law}, {STAYS[self.stays]}" if self.law in LAWS else self.law


@dataclass(frozen=True, eq=False)
class FreeRows:
    """What was taken off the loads of a record: ``taken`` [N] of each row, 0 where nothing is; ``spoilt``: rows within
    an edge; ``raised``: one standard error of each level [N], by rows. ``bent``: the attraction at other sizes;
    ``rounding`` [N]: what a converter leaves of the offset, where noise does not move it between levels."""

    levels: tuple[Level, ...]
    attraction: Attraction | None
    taken: Array
    spoilt: Array
    raised: tuple[Array, ...]
    bent: Bent | None
    rounding: float = 0.0

    @property
    def words(self) -> Iterator[str]:
        if self.rounding:
            offset = show(self.rounding, "load", 2)
            yield f"they lie on levels of an A/D converter: the force offset is known to {offset}"
        yield from (level.words for level in self.levels)
        if self.attraction is not None:
            yield self.attraction.words

    def stronger(self, step: float) -> FreeRows:
        """The same with an attraction so many standard errors larger, its range as the free rows have it then."""
        return self if step == 0 or self.bent is None else self._by(self.bent.at(step), self)

    @property
    def straight(self) -> FreeRows:
        """The same without an attraction."""
        if self.bent is None or self.attraction is None:
            return self
        taken = self.taken - self.bent.over_rows(self.bent.best, self.attraction.stays)
        return replace(self, attraction=None, taken=taken, bent=None)

    @property
    def of_signal(self) -> Array:
        """What of it is no force, but an error of the signal [N]: a virtual deflection or a drift."""
        bends = self.bent is not None and self.bent.best.law not in LAWS
        return self.bent.over_rows(self.bent.best) if self.bent is not None and bends else np.zeros(self.taken.size)

    @property
    def by_laws(self) -> list[FreeRows]:
        """The same by all laws, its own first, and by those of an attraction that ends at touch."""
        laws = [self, *(replace(self, bent=one)._by(one.best, self) for one in (self.bent.laws if self.bent else ()))]
        ends = [one._by(one.bent.best, one, stays=False) for one in laws if one.bent and one.bent.best.law in LAWS]
        return [*laws, *ends]

    def _by(self, bend: _Bend, before: FreeRows, stays: bool | None = None) -> FreeRows:
        """The same with a ``bend`` of its own law in place of what was taken off ``before``."""
        if self.bent is None or before.attraction is None:
            return self
        stays = before.attraction.stays if stays is None else stays
        found = Attraction(bend.sizes[0], self.bent.error, bend.range, bend.law, stays)
        taken = before.straight.taken + self.bent.over_rows(bend, stays)
        return replace(self, attraction=found, taken=taken, bent=replace(self.bent, best=bend))


def free_rows(sides: Sequence[Side], size: int, stiffness: float) -> Flow[FreeRows | None]:
    """What the free rows of some directions hold beside lines, as a flow; None where that is nothing.

    ``size``: rows of the record, ``stiffness`` of the device [N/m].
    """
    taken, spoilt = np.zeros(size), [np.zeros(0, dtype=int)]
    levels, raised, level_free = list[Level](), list[Array](), list[Side]()
    for side in sides:
        y = side.y.copy()
        for edge, level, error in _levels(side):
            own = np.zeros(size)
            own[side.rows[edge:]] = 1.0
            taken += level * own
            y[edge:] -= level
            levels.append(Level(side.kind, level, error, float(side.x[edge]), float(side.x[-1])))
            raised.append(error * own)
            spoilt.append(side.rows[max(edge - 1, 0) : edge + 2])
        level_free.append(replace(side, y=y) if (y != side.y).any() else side)
    bent = yield from _bent(level_free, size, stiffness)
    # Rows that rest on one level of a converter, with noise below it, know their load to its share of a level only.
    rest = [
        side
        for side in sides
        if side.code
        and side.y.size >= FREE_FEWEST
        and np.mean(np.abs(np.diff(side.y)) < FREE_EVEN_LEVEL * side.code) > FREE_RESTS
    ]
    rounding = max((side.code for side in rest), default=0.0) / math.sqrt(12)
    if rounding:
        for power in (0, 1):  # of the offset, and of the tilt over the free way
            own = np.zeros(size)
            for side in sides:
                way = (side.deep - side.x.mean()) / (np.ptp(side.x) / 2 or 1.0) if side.x.size else 0.0
                own[side.contact] = rounding * way**power
            raised.append(own)
    if not raised and bent is None:
        return None
    attraction = None
    if bent is not None:
        taken += bent.over_rows(bent.best)
        attraction = Attraction(bent.best.sizes[0], bent.error, bent.best.range, bent.best.law)
    return FreeRows(tuple(levels), attraction, taken, np.concatenate(spoilt), tuple(raised), bent, rounding)


def row_noise(y: Array) -> float:
    """Standard deviation of a row by second differences, whatever the rows follow."""
    steps = y[1:] - y[:-1]
    return 1.4826 * median(np.abs(steps[1:] - steps[:-1])) / math.sqrt(6) if y.size > 3 else 0.0


# ---------------------------------------------------------------------- levels
def _levels(side: Side) -> list[tuple[int, float, float]]:
    """Edges of level tensions, rows from the far end, with the size [N] of each and its error: all that lie outside of
    a contact that lets go by a jump."""
    edges: list[int] = []
    if side.y.size < FREE_FEWEST or not side.jump < 0:
        return []
    noise = side.noise
    for _ in range(FREE_MOST):
        edge = _edge(side.y - _stairs(side, edges) if edges else side.y, noise)
        if edge is None:
            break
        edges = sorted({*edges, edge})
    while edges:
        design = _design(side, edges)
        sizes = np.linalg.lstsq(design, side.y, rcond=None)[0]
        off = side.y - design @ sizes
        spread = np.linalg.pinv(design.T @ design)
        error = max(noise, float(np.std(off))) * np.sqrt(np.diag(spread))
        steps, errors = sizes[2:], error[2:]
        weak = np.abs(steps) / np.maximum(errors, 1e-300)
        if weak.min() > FREE_SIGMAS:
            least = max(FREE_CODES * side.code, 0.0)
            tethers = (steps < -least) & (-np.cumsum(steps) < FREE_LEVEL * -side.jump)
            even = float(np.std(off)) < FREE_EVEN * noise
            whole = list(zip(edges, map(float, steps), map(float, errors), strict=True))
            return whole if even and tethers.all() else []
        del edges[int(np.argmin(weak))]
    return []


def _design(side: Side, edges: Sequence[int]) -> Array:
    """Columns of a line and of a step at each of the ``edges``."""
    along = (side.x - side.x[0]) / (float(np.ptp(side.x)) or 1.0)
    steps = [(np.arange(side.y.size) >= edge).astype(float) for edge in edges]
    return np.column_stack([np.ones_like(along), along, *steps])


def _stairs(side: Side, edges: Sequence[int]) -> Array:
    """The steps at the ``edges`` alone [N]."""
    design = _design(side, edges)
    sizes = np.linalg.lstsq(design, side.y, rcond=None)[0]
    found: Array = design[:, 2:] @ sizes[2:]
    return found


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
Block: TypeAlias = tuple[Array, Array, float, Array]  # positions, loads, standard deviation, numbers of rows


@dataclass(frozen=True, eq=False)
class _Bend:
    """A bend towards contact at ``at`` [m] of blocks of all sides: its ``cost`` chi^2 on so many ``dof``, the ``sizes``
    [N] at contact of each side, and the ``error`` of the first."""

    cost: float
    dof: int
    range: float
    law: str
    at: float
    sizes: tuple[float, ...]
    error: float


@dataclass(frozen=True, eq=False)
class Bent:
    """A bend towards contact of the ``sides`` of a record of ``size`` rows, in ``blocks``: the ``best`` of a law, and
    the standard ``error`` [N] of the size at contact, whatever the range; ``way``: the free one [m]; ``laws``: the same
    by other laws."""

    sides: tuple[Side, ...]
    blocks: tuple[Block, ...]
    best: _Bend
    error: float
    way: float
    stiffness: float
    size: int
    laws: tuple[Bent, ...] = ()

    def at(self, step: float) -> _Bend:
        """The bend whose size is so many standard errors larger."""
        best, larger = self.best, math.copysign(step * self.error, step * self.best.sizes[0])
        if len(set(best.sizes)) > 1:
            return replace(best, sizes=tuple(A + larger for A in best.sizes))
        return _bend(self.blocks, best.law, best.at, self.way, self.stiffness, False, best.sizes[0] + larger)

    def over_rows(self, bend: _Bend, stays: bool = True) -> Array:
        """The attraction [N] at all rows of the record: that at contact, or none, where a row is not free."""
        taken = np.zeros(self.size)
        for side, A in zip(self.sides, bend.sizes, strict=True):
            taken[side.rows] = A * _shape(bend, side.x, side.rows, A, self.way, self.stiffness)
            inside = 1.0 if bend.law in LAWS else _shape(bend, side.deep, side.contact, A, self.way, self.stiffness)
            taken[side.contact] = A * stays * inside
        return taken


def _bent(sides: Sequence[Side], size: int, stiffness: float) -> Flow[Bent | None]:
    """What bends the base lines: an attraction, where the free rows bend at contact and not elsewhere; a virtual
    deflection or a drift, where they bend at all; None where none of these describes them."""
    usable = tuple(side for side in sides if side.y.size >= FREE_FEWEST and side.noise > 0)
    if not usable or all(side.kind != "approach" for side in usable):
        return None
    blocks = tuple(map(_blocked, usable))
    at = next(float(side.x[-1]) for side in usable if side.kind == "approach")
    way = max(float(np.ptp(side.x)) for side in usable)
    noise = max(side.noise for side in usable)
    near, far = yield from ask(_falls, ([block[:3] for block in blocks], at, way))
    if max(near, far) < FREE_BENDS:
        return None
    # Rows next to contact may belong to it, or to a slow jump: what bends is seen without them, too.
    beyond = [(x < at - FREE_RANGES[0] * way, x, y) for x, y, _, _ in blocks]
    apart_from_contact = [(x[some], y[some], noise) for some, x, y in beyond if some.any()]
    if not apart_from_contact or max((yield from ask(_falls, (apart_from_contact, at, way)))) < FREE_BENDS:
        return None
    fit = partial(_bend, blocks, at=at, way=way, stiffness=stiffness)
    straight = fit(VIRTUAL, own=False, held=0.0)
    bends = list[_Bend]()
    if near >= FREE_BENDS:
        bends = [fit(law, own=False) for law in LAWS]
        least = min(one.cost for one in bends)
        apart = [fit(law, own=True) for law in LAWS] if len(blocks) > 1 else bends
        if least - min(one.cost for one in apart) > max(least / bends[0].dof, 1.0) * FREE_APART:
            bends = apart
    bends += [fit(law, own=False) for law in (VIRTUAL, DECAY)]
    bends = [one for one in bends if _describes(one, straight) and abs(one.sizes[0]) >= FREE_TELLS * noise]
    if not bends:
        return None
    bends.sort(key=lambda one: one.cost)
    colour = max(bends[0].cost / bends[0].dof, 1.0)
    laws = [_with_error(Bent(usable, blocks, one, one.error, way, stiffness, size), colour) for one in bends]
    return replace(laws[0], laws=tuple(laws[1:]))


def _describes(bend: _Bend, straight: _Bend) -> bool:
    """Whether what a ``bend`` leaves is noise, and beside it what lines leave, ``straight``, is not."""
    colour = max(bend.cost / bend.dof, 1.0)
    return straight.cost - bend.cost >= colour * FREE_BENDS and colour <= FREE_DESCRIBED


def _with_error(bent: Bent, colour: float) -> Bent:
    """The bend with the error of its size whatever the range, from that at a given one."""
    bent = replace(bent, error=math.sqrt(colour) * bent.error)
    rise = max((bent.at(1.0).cost - bent.best.cost) / colour, FREE_SHALLOWEST)
    return replace(bent, error=bent.error / math.sqrt(min(rise, 1.0)))


def _blocked(side: Side) -> Block:
    """Positions and loads of blocks of rows, the standard deviation of a block, by the differences of neighbours, and
    the numbers of their rows in the record."""
    size = max(1, side.y.size // FREE_BLOCKS)
    x, y, rows = (
        np.einsum("ij->i", v[v.size % size :].reshape(-1, size)) / size
        for v in (side.x, side.y, side.rows.astype(float))
    )
    return x, y, max(row_noise(y), side.noise / math.sqrt(size)), rows


def _lines(blocks: Sequence[Block], bends: Sequence[Array] | None, own: bool = False) -> Array:
    """Columns of a line for each side and of a bend, common or of each side."""
    ends = np.cumsum([0, *(block[0].size for block in blocks)])
    columns = []
    for i, (x, _, _, _) in enumerate(blocks):
        for values in (np.ones_like(x), (x - x[-1]) / (float(np.ptp(x)) or 1.0)):
            columns.append(np.zeros(ends[-1]))
            columns[-1][ends[i] : ends[i + 1]] = values
    if bends is not None and own:
        for i, bend in enumerate(bends):
            columns.append(np.zeros(ends[-1]))
            columns[-1][ends[i] : ends[i + 1]] = bend
    elif bends is not None:
        columns.append(np.concatenate(list(bends)))
    return np.column_stack(columns)


def _bend(
    blocks: Sequence[Block], law: str, at: float, way: float, stiffness: float, own: bool, held: float | None = None,
) -> _Bend:  # fmt: skip
    """The bend by a ``law`` of the range that leaves least; ``own``: of another size for each side; ``held``: its
    size [N], where that is known."""
    y = np.concatenate([block[1] for block in blocks])
    noise = np.concatenate([np.full(block[0].size, max(block[2], 1e-300)) for block in blocks])

    def of(reach: float) -> _Bend:
        """The bend of a range [m], whose gaps follow from its size."""
        size, unit = np.zeros(len(blocks)), _Bend(0.0, 1, reach, law, at, (), 0.0)
        for _ in range(FREE_ROUNDS if law in LAWS else 1):
            bends = [_shape(unit, block[0], block[3], A, way, stiffness) for block, A in zip(blocks, size, strict=True)]
            scaled = _lines(blocks, bends, own) / noise[:, None]
            if held is None:
                values = np.linalg.lstsq(scaled, y / noise, rcond=None)[0]
                size = values[-len(blocks) :] if own else np.full(len(blocks), values[-1])
            else:
                lines = np.linalg.lstsq(scaled[:, :-1], y / noise - held * scaled[:, -1], rcond=None)[0]
                values, size = np.append(lines, held), np.full(len(blocks), held)
        off = scaled @ values - y / noise
        first = scaled.shape[1] - (len(blocks) if own else 1)
        error = math.sqrt(max(float(np.linalg.pinv(scaled.T @ scaled)[first, first]), 0.0))
        dof = max(y.size - scaled.shape[1] - 1, 1)
        return _Bend(float(off @ off), dof, reach, law, at, tuple(map(float, size)), error)

    if law == VIRTUAL:
        return of(way)
    rows = max(float(block[3].max()) for block in blocks)
    ranges = way * FREE_RANGES if law in LAWS else rows * FREE_RANGES[FREE_RANGES < FREE_SLOWEST]
    best, step = min(map(of, ranges.tolist()), key=lambda one: one.cost), FREE_COARSE
    for _ in range(FREE_FINER):
        step /= 3
        best = min([best, *(of(best.range * math.exp(i * step)) for i in (-2, -1, 1, 2))], key=lambda one: one.cost)
    return best


def _shape(bend: _Bend, x: Array, rows: Array, size: float, way: float, stiffness: float) -> Array:
    """The load over its ``size`` [N] at positions ``x`` [m] and numbers of ``rows``."""
    if bend.law == VIRTUAL:
        return ((x - bend.at) / way) ** 2
    if bend.law == DECAY:
        return np.exp(-rows / bend.range)
    return LAWS[bend.law](_gaps(x, bend.at, size, bend.range, bend.law, stiffness) / bend.range)


def _gaps(x: Array, at: float, size: float, reach: float, law: str, stiffness: float) -> Array:
    """Gaps [m] before contact at positions ``x`` of a device that an attraction deflects."""
    gap = np.maximum(at - x, 0.0)
    if not math.isfinite(stiffness) or size == 0:
        return gap
    for _ in range(FREE_ROUNDS):
        gap = np.maximum(at - x + size * (LAWS[law](gap / reach) - 1) / stiffness, 0.0)
    return gap


def _falls(asked: Sequence[tuple[Sequence[tuple[Array, Array, float]], float, float]]) -> list[tuple[float, float]]:
    """How far chi^2 of lines falls by a bend at contact, and by one at the far end, each of the best range; ``asked``:
    the blocks of each record, the position of contact and the free way [m]."""
    sides = [(x, y, noise, at, way) for blocks, at, way in asked for x, y, noise in blocks]
    counts = np.array([x.size for x, *_ in sides])
    starts = np.cumsum(counts) - counts
    records = starts[np.cumsum([0, *(len(blocks) for blocks, _, _ in asked[:-1])])]
    noise, at, way = (
        np.repeat(values, counts)
        for values in zip(*((max(noise, 1e-300), at, way) for _, _, noise, at, way in sides), strict=True)
    )
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

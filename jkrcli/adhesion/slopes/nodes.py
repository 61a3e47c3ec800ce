"""Contact radii that are those of nodes: what they tell of the radius of the contact.

A node carries once the edge of the contact is a fraction o of an element beyond it, the same at all radii: 0 where
nodes that carry are told exactly, 0.1 to 0.3 where contact is averaged over surfaces. Counted in nodes the edge is at
k + o when node k begins to carry, and goes on to k + 1 + o while k is the outermost that does: elements may be of any
sizes. The radius of the next node, or of the nearest, is the same with o - 1 or o - 1/2. So is a radius that was
rounded, or an area in its place.

Where several increments fall on one element, the next node is reached between two of them, at a depth between theirs:
this tells more of the radius than any row does. Where an increment passes several nodes, its own row does.

Which nodes lie between two radii is not seen. On any mesh neighbouring elements are nearly alike, or change at few
places, while the distances of the radii that are reported jump by whole elements: of all ways of counting, the one is
taken by which the sizes of elements change least (the shortest path, Viterbi, IEEE Trans. Inf. Theory 13 (1967) 260).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.numerics import HALF_WIDTH, ROUNDED, Array
from ...series import RawSeries

# When radii are those of nodes, and what their rows tell.
NODE_REPEATS = 0.2  # choice: share of the rows that repeat a radius, from which it is that of a node
NODE_FEWEST = 5  # theory: differences of radii that chance does not make multiples of one
NODE_FEW = 20  # choice: rows that do not repeat radii, from which this can be told
NODE_MOST = 1000.0  # choice: elements under the largest contact; more are no matter
# theory: of an element, by which radii miss what their neighbours make of them; those of nodes miss it by 0.4,
# radii that were asked for by nothing
NODE_SCATTER = 0.15
NODE_TURNS = 3  # choice: times that the nodes passed become more and fewer by turns; radii asked for do not
NODE_BENT = 0.5  # choice: of the bend of loads from node to node, between none within an element and all of it
# How nodes are counted.
NODE_PASSED = 16  # choice: most nodes that an increment is thought to pass
NODE_JUMP = 0.4  # choice: of the log of a size, a change as large as any: zones
# of a change of the log of a size, what e times as many nodes cost; tuned on meshes, by `make node-study`
NODE_EACH = 0.05
NODE_REGULAR = 0.05  # choice: median of what radii miss nodes by, in elements; noise in the radii makes more


class Ahead(NamedTuple):
    """By how many elements the edge of the contact is beyond a node that begins to carry, and the half-width of
    this number, which all rows share; ``source``: what it is known from; ``left``: what of the half-width the scatter
    of the same rows does not explain, which moves the edge as it moves them, and cancels there."""

    elements: float
    error: float
    source: str
    left: float


AS_THEY_ARE = Ahead(0.0, 0.0, "taken as it is", 0.0)


@dataclass(frozen=True, eq=False)
class Touches:
    """States in which the radius of the contact is known: ``rows`` with their radii, the half-widths ``errors`` of
    these (n,) [m], each row for itself, the ``element`` (n,) [m] there, and the node, ``at`` (n,), that the edge would
    be at were it not ahead."""

    rows: RawSeries
    errors: Array
    element: Array
    at: Array


@dataclass(frozen=True, eq=False)
class NodeRadii:
    """Rows whose radii are those of nodes: the ``number`` (n,) of each, the ``radii`` (m,) [m] of all nodes by number;
    ``before``: the last displacement [m] at which no node carried, or 0."""

    rows: RawSeries
    number: Array
    radii: Array
    before: float

    @property
    def element(self) -> Array:
        """Distance (n,) [m] from the node of each row to the next one."""
        return self.radius(self.number + 1.0) - self.rows.a

    @property
    def spacing(self) -> float:
        """Of the nodes under the largest contact [m]."""
        return float(self.element[-1])

    def radius(self, at: Array) -> Array:
        """Radii [m] at places counted in nodes, straight between them."""
        return np.interp(at, np.arange(self.radii.size), self.radii)

    def counted(self, a: Array) -> Array:
        """Places, counted in nodes, of radii [m]."""
        last, inner, outer = self.radii.size - 1, *np.diff(self.radii)[[0, -1]]
        below, above = np.minimum(a - self.radii[0], 0.0) / inner, np.maximum(a - self.radii[last], 0.0) / outer
        return np.interp(a, self.radii, np.arange(last + 1)) + below + above

    def touches(self, ahead: float = 0.0) -> Touches:
        """Where the edge, ``ahead`` elements beyond a node that begins to carry, is known best: on its way to a node
        between two increments, and in the increments that pass several.

        Depth: the middle of the two increments. Load: that of the contact as it is at a node. While the nodes in
        contact are the same the load is linear in the depth, and lies above that of a contact whose edge goes on; the
        lines through the rows of either run of equal radii meet where it reaches the node.
        """
        first = np.flatnonzero(np.diff(self.rows.a, prepend=0.0) > 0)  # of each run of equal radii
        lengths, number = np.diff(np.append(first, self.rows.a.size)), self.number[first]
        single = np.append(False, np.diff(number) == 1)
        if self.before > 0 and self.rows.a[0] < 1.5 * self.element[0]:
            single[0] = True
        share = np.append(1.0, 2.0 / (lengths[1:] + lengths[:-1]))  # of an element, that an increment goes on
        share = np.where(single, np.minimum(share, 1.0), 1.0)
        delta, P, last = self.rows.delta[first], self.rows.P[first], first[1:] - 1
        depth = np.where(single, (np.append(self.before, self.rows.delta[last]) + delta) / 2, delta)
        load = _loads_between(self.rows, first, lengths, depth)
        load = np.where(single, np.clip(load, np.append(0.0, self.rows.P[last]), P), P)
        at = number + np.where(single, 0.0, 0.5)
        radius = self.radius(at + ahead)
        known = (radius > 0) & (np.diff(radius, prepend=0.0) > 0)
        width = self.radius(at + ahead + 0.5) - self.radius(at + ahead - 0.5)
        rows = RawSeries(radius, depth, load, self.rows.rows[first])
        errors = HALF_WIDTH * share / math.sqrt(12) * width  # theory: all places of the interval are as likely
        return Touches(rows.only(known), errors[known], width[known], at[known])


def _loads_between(rows: RawSeries, first: Array, lengths: Array, depth: Array) -> Array:
    """Loads [N] at the ``depth`` (n,) [m] at which each run of equal radii begins, at its ``first`` row (n,): the mean
    by the line through its rows and by that of the run before.

    Lines of the load over the depth, but of their logs where loads do not feel nodes and bend within runs as they do
    from run to run.
    """
    run, many = np.repeat(np.arange(first.size), lengths), first.size > 1

    def mean(values: Array) -> Array:
        return np.add.reduceat(values, first) / lengths

    def at(x: Array, y: Array, single: Array, wanted: Array) -> tuple[Array, Array, Array]:
        """y (n,) on the lines at the ``wanted`` x, with their slopes, and what they leave of the rows; ``single``: the
        slopes of runs of one x."""
        middle, height = mean(x), mean(y)
        u = x - middle[run]
        spread = mean(u**2)
        line = spread > (ROUNDED * middle) ** 2
        slope = np.where(line, mean(u * y) / np.where(line, spread, 1.0), single)
        before = np.maximum(np.arange(wanted.size) - 1, 0)
        of_run, of_last = (height[i] + slope[i] * (wanted - middle[i]) for i in (np.arange(wanted.size), before))
        return (of_run + of_last) / 2, slope, np.where(line[run], y - height[run] - slope[run] * u, 0.0)

    x, y = np.log(rows.delta), np.log(rows.P)
    rate = np.gradient(mean(y), mean(x)) if many else np.ones(1)
    loads, slope, left = at(rows.delta, rows.P, rate * mean(rows.P) / mean(rows.delta), depth)
    bend = np.gradient(slope, mean(rows.delta)) if many else np.zeros(1)
    _, _, parabola = at(rows.delta, bend[run] * (rows.delta - mean(rows.delta)[run]) ** 2 / 2, slope, depth)
    left, parabola = left / rows.P, parabola / rows.P
    if left @ parabola > NODE_BENT * (parabola @ parabola):
        return np.exp(at(x, y, rate, np.log(depth))[0])
    return loads


def node_radii(raw: RawSeries) -> NodeRadii | None:
    """The rows in contact as those of nodes; None where the radii are none of nodes: where they fall, or neither repeat
    nor are those of a mesh while they scatter by its elements."""
    rows = raw.touching
    nodes = as_nodes(raw)
    if nodes is None or rows.element is not None:
        return nodes
    repeated = np.diff(rows.a) == 0
    if repeated.mean() > NODE_REPEATS:
        return nodes
    # whether some radii repeat while displacement and load go on
    repeat = bool(np.any(repeated & (np.diff(rows.delta) > 0) & (np.diff(rows.P) > 0)))
    # Whether sizes of elements go on growing as they do, but at few places; counts can be made to fit any other radii
    # to a part of an element only
    number, first = np.unique(nodes.number, return_index=True)
    passed = np.diff(number)
    sizes = np.log(np.diff(nodes.rows.a[first]) / passed)
    between = (passed[1:] + passed[:-1]) / 2
    growth = np.diff(sizes) / between  # from node to node
    off = np.diff(growth) * passed[1:-1] * (between[1:] + between[:-1]) / 2  # elements
    return nodes if np.median(np.abs(off)) < NODE_REGULAR and (repeat or _scatters(nodes)) else None


def as_nodes(raw: RawSeries) -> NodeRadii | None:
    """The rows in contact as those of nodes, whether or not they are; None where radii fall, or are too few to tell
    nodes, or of too many of them to matter."""
    rows = raw.touching
    if rows.a.size < 2 or np.any(np.diff(rows.a) < 0) or min(rows.delta.min(), rows.P.min()) <= 0:
        return None
    radii, first, lengths = np.unique(rows.a, return_index=True, return_counts=True)
    steps = np.diff(radii)
    if rows.element is None:
        if steps.size < NODE_FEWEST:
            return None
        passed = _passed(steps, (lengths[1:] > 1) & (lengths[:-1] > 1))
        element = np.append(steps / passed, steps[-1] / passed[-1])
    else:
        element = rows.element[first]
        passed = np.maximum(np.round(2 * steps / (element[1:] + element[:-1])), 1).astype(int)
    if rows.a[-1] > NODE_MOST * element[-1]:
        return None
    # All nodes: one before the first radius, and what the elements outside the last one make of those beyond
    number = 1 + np.append(0, np.cumsum(passed))
    places, known = number[:-1][passed > 1] + 1, radii[:-1][passed > 1] + element[:-1][passed > 1]
    ends = [max(radii[0] - element[0], 0.0)], radii[-1] + element[-1] * np.array([1.0, 2.0])
    order = np.argsort(np.append(number, places), kind="stable")
    index = np.concatenate([[0], np.append(number, places)[order], number[-1] + [1, 2]])
    values = np.concatenate([ends[0], np.append(radii, known)[order], ends[1]])
    untouched = raw.delta[(raw.a <= 0) & (raw.delta < rows.delta[0])]
    before = max(float(np.max(untouched, initial=0.0)), 0.0)
    all_nodes = np.interp(np.arange(index[-1] + 1), index, values)
    return NodeRadii(rows, number[np.searchsorted(radii, rows.a)], all_nodes, before)


def _passed(steps: Array, single: Array) -> Array:
    """How many nodes each of the ``steps`` (n,) [m] from radius to radius passes, 1 where it is a ``single`` one: by
    the way of counting with the least sum of changes of the log of the sizes, and of what nodes cost."""
    counts = np.arange(1, NODE_PASSED + 1)
    sizes = np.log(steps)[:, None] - np.log(counts)  # (n, counts): of the elements within a step
    own = np.where(single[:, None] & (counts > 1), np.inf, NODE_EACH * np.log(counts))
    best, came = own[0], np.zeros(sizes.shape, dtype=int)
    for j in range(1, steps.size):
        total = best[:, None] + np.minimum(np.abs(sizes[j] - sizes[j - 1][:, None]), NODE_JUMP)
        came[j], best = np.argmin(total, axis=0), np.min(total, axis=0) + own[j]
    path = [int(np.argmin(best))]
    for j in range(steps.size - 1, 0, -1):
        path.append(int(came[j, path[-1]]))
    return counts[path[::-1]]


def _scatters(nodes: NodeRadii) -> bool:
    """Whether radii that do not repeat lie off what two neighbours on either side make of them by parts of an element,
    as those of nodes do."""
    rows = nodes.rows
    if rows.a.size < NODE_FEW or np.any(np.diff(rows.delta) <= 0):
        return False
    turns = np.diff(np.diff(nodes.number))
    if np.count_nonzero(turns[turns != 0][1:] * turns[turns != 0][:-1] < 0) < NODE_TURNS:
        return False
    x, y = np.log(rows.delta), np.log(rows.a)
    i = np.arange(2, x.size - 2)
    others = np.stack([i - 2, i - 1, i + 1, i + 2])
    weights = np.ones(others.shape)
    for j in range(4):
        for k in range(4):
            if k != j:
                weights[j] *= (x[i] - x[others[k]]) / (x[others[j]] - x[others[k]])
    gap = np.abs(y[i] - np.sum(weights * y[others], axis=0)) * rows.a[i] / nodes.element[i]
    return bool(np.sqrt(np.mean(gap**2)) > NODE_SCATTER)

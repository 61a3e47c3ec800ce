"""Contact radii that are those of nodes: what they tell of the radius of the contact.

A node carries once the edge of the contact is a fraction o of an element beyond it, the same at all radii: 0 where
nodes that carry are told exactly, 0.1 to 0.3 where contact is averaged over surfaces. The radius of the outermost node
that carries, r, holds while the edge goes on from r + o e to r + (1 + o) e, e being the element; that of the next node,
or of the nearest, is the same with o - 1 or o - 1/2. So is a radius that was rounded, or an area in its place.

Where several increments fall on one element, the next node is reached between two of them, at a depth between theirs:
this tells more of the radius than any row does. Where an increment passes several nodes, its own row does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.numerics import Array
from ...series import RawSeries

# When radii are those of nodes, and what their rows tell.
NODE_REPEATS = 0.2  # choice: share of the rows that repeat a radius, from which it is that of a node
NODE_FEWEST = 5  # theory: differences of radii that chance does not make multiples of one
NODE_FEW = 20  # choice: rows that do not repeat radii, from which this can be told
NODE_MULTIPLE = 0.1  # choice: of an element, by how far differences of radii may miss its multiples
NODE_PARTS = 6  # choice: most elements in the smallest difference of radii
NODE_MOST = 1000.0  # choice: elements under the largest contact; more are no matter
# theory: of an element, by which radii miss what their neighbours make of them; those of nodes miss it by 0.4,
# radii that were asked for by nothing
NODE_SCATTER = 0.15
NODE_TURNS = 3  # choice: times that the nodes passed become more and fewer by turns; radii asked for do not
NODE_HALF_WIDTH = 0.9  # theory: of an interval in which all places are as likely, for 90 %


class Ahead(NamedTuple):
    """By how many elements the edge of the contact is beyond a node that begins to carry, and the 90 % half-width of
    this number, which all rows share; ``source``: what it is known from."""

    elements: float
    error: float
    source: str

    @property
    def found(self) -> bool:
        """Whether the rows beside the solution of their bodies told it."""
        return self.source == "body"


AS_THEY_ARE = Ahead(0.0, 0.0, "taken as it is")


@dataclass(frozen=True, eq=False)
class Touches:
    """States in which the radius of the contact is known: ``rows`` with their radii, the 90 % half-widths ``errors`` of
    these (n,) [m], each row for itself, and the ``element`` (n,) [m] there."""

    rows: RawSeries
    errors: Array
    element: Array


@dataclass(frozen=True, eq=False)
class NodeRadii:
    """Rows whose radii are those of nodes, ``element`` (n,) [m] before the next one; ``before``: the last displacement
    [m] at which no node carried, or 0."""

    rows: RawSeries
    element: Array
    before: float

    @property
    def spacing(self) -> float:
        """Of the nodes under the largest contact [m]."""
        return float(self.element[-1])

    def touches(self, ahead: float = 0.0) -> Touches:
        """Where the edge, ``ahead`` elements beyond a node that begins to carry, is known best: on its way to a node
        between two increments, and in the increments that pass several.

        Depth: the middle of the two increments; load: on the line through the rows around them, log P over log delta,
        from the middle of the one run of equal radii to that of the next.
        """
        a, delta, P = self.rows.a, self.rows.delta, self.rows.P
        first = np.flatnonzero(np.diff(a, prepend=0.0) > 0)  # of each run of equal radii
        ends = np.append(first[1:], a.size)
        lengths = ends - first
        e = self.element[first]
        single = np.append(False, np.diff(a[first]) < 1.5 * e[:-1])
        if self.before > 0 and a[0] < 1.5 * e[0]:
            single[0] = True
        share = np.append(1.0, 2.0 / (lengths[1:] + lengths[:-1]))  # of an element, that an increment goes on
        share = np.where(single, np.minimum(share, 1.0), 1.0)
        last = np.append(self.before, delta[first[1:] - 1])
        depth = np.where(single, (last + delta[first]) / 2, delta[first])
        radius = a[first] + (np.where(single, 0.0, 0.5) + ahead) * e
        load = P[first].copy()
        for i in np.flatnonzero(single):
            begin = first[i] if i == 0 else (first[i - 1] + ends[i - 1]) // 2
            end = max((first[i] + ends[i] + 1) // 2, first[i] + 1)
            # the load at the depth on the line through these rows, log P over log delta
            around = slice(min(begin, max(first[i] - 1, 0)), max(end, 2))
            x, y = np.log(delta[around]), np.log(P[around])
            spread = x - x.mean()
            slope = float(spread @ y) / max(float(spread @ spread), 1e-300)
            load[i] = float(np.exp(y.mean() + slope * (np.log(depth[i]) - x.mean())))
        rows = RawSeries(radius, depth, load, self.rows.rows[first])
        known = radius > 0
        errors = NODE_HALF_WIDTH * share / 2 * e
        return Touches(rows.only(known), errors[known], e[known])


def has_plateaus(raw: RawSeries) -> bool:
    """Whether radii repeat while depth and load go on, as node-based radii do: at one increment in five at least."""
    raw = raw.touching
    return bool(raw.a.size > 1 and np.all(np.diff(raw.a) >= 0) and np.mean(np.diff(raw.a) == 0) > NODE_REPEATS)


def node_radii(raw: RawSeries) -> NodeRadii | None:
    """The rows in contact as those of nodes; None where the radii are none of nodes: where they fall, or neither repeat
    nor differ by multiples of one length while they scatter by it."""
    rows = raw.touching
    if not _in_order(rows):
        return None
    before, radii = _before(raw), np.unique(rows.a)
    if rows.element is not None:
        return NodeRadii(rows, rows.element, before)
    # whether some radii repeat while displacement and load go on
    repeat = bool(np.any((np.diff(rows.a) == 0) & (np.diff(rows.delta) > 0) & (np.diff(rows.P) > 0)))
    if (even := evenly_spaced(raw)) is not None and (repeat or _scatters(rows, even.spacing)):
        return even
    if not has_plateaus(raw) or radii.size < 2:
        return None
    steps = np.diff(radii)
    element = np.append(steps, steps[-1])[np.searchsorted(radii, rows.a)]
    return NodeRadii(rows, element, before)


def evenly_spaced(raw: RawSeries) -> NodeRadii | None:
    """The rows in contact as those of evenly spaced nodes, whether or not they are; None where their radii do not
    differ by multiples of one length."""
    rows = raw.touching
    even = _even_spacing(np.unique(rows.a)) if _in_order(rows) else None
    if even is None or rows.a[-1] > NODE_MOST * even:
        return None
    return NodeRadii(rows, np.full(rows.a.size, even), _before(raw))


def _in_order(rows: RawSeries) -> bool:
    """Whether radii do not fall, and displacements and loads are positive."""
    return bool(rows.a.size > 1 and np.all(np.diff(rows.a) >= 0) and min(rows.delta.min(), rows.P.min()) > 0)


def _before(raw: RawSeries) -> float:
    """The last displacement [m] at which no node carried, or 0."""
    untouched = raw.delta[(raw.a <= 0) & (raw.delta < raw.touching.delta[0])]
    return max(float(np.max(untouched, initial=0.0)), 0.0)


def _even_spacing(radii: Array) -> float | None:
    """The largest length of which all differences of the ``radii`` are multiples; None where there is none."""
    steps = np.diff(radii)
    if steps.size < NODE_FEWEST:
        return None
    for parts in range(1, NODE_PARTS + 1):
        multiples = np.round(steps * parts / steps.min())
        length = float(steps.sum() / multiples.sum())
        if np.abs(steps / length - multiples).max() < NODE_MULTIPLE / parts:
            return length
    return None


def _scatters(rows: RawSeries, element: float) -> bool:
    """Whether radii that do not repeat lie off what two neighbours on either side make of them by parts of an element,
    as those of nodes do."""
    if rows.a.size < NODE_FEW or np.any(np.diff(rows.delta) <= 0):
        return False
    turns = np.diff(np.round(np.diff(rows.a) / element))
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
    gap = np.abs(y[i] - np.sum(weights * y[others], axis=0)) * rows.a[i] / element
    return bool(np.sqrt(np.mean(gap**2)) > NODE_SCATTER)

"""Elimination order for a sparse Cholesky factor: nested dissection of the mesh (George 1973).

Every group of cells is split at its median along one of a few directions, whichever cuts the fewest facets, until
the groups are small; all groups of a level at once. The nodes between two halves are eliminated after both.
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray
LEAF = 6  # cells; smaller groups gain nothing


def nested_dissection(cell_nodes: Array, centres: Array, neighbours: Array) -> Array:
    """Rank of every node: eliminate in increasing rank.

    ``cell_nodes`` (m, k): the nodes of each cell; ``centres`` (m, 2) [m]; ``neighbours`` (2, f): cells on both sides
    of every inner facet.
    """
    code = _cell_codes(centres, neighbours)
    nodes = cell_nodes.ravel()
    codes = np.repeat(code, cell_nodes.shape[1])
    lowest, highest = np.full(nodes.max() + 1, code.max()), np.zeros(nodes.max() + 1, dtype=np.int64)
    np.minimum.at(lowest, nodes, codes)
    np.maximum.at(highest, nodes, codes)
    level = np.ceil(np.log2((lowest ^ highest) + 1)).astype(np.int64)  # digits in which the node's cells differ
    last = lowest | ((1 << level) - 1)  # the last cell code of the subtree that the node separates
    order = np.lexsort((level, last))
    rank = np.empty_like(order)
    rank[order] = np.arange(order.size)
    return rank


def _cell_codes(centres: Array, neighbours: Array) -> Array:
    """Path of every cell in the tree of halves, as a binary number with one digit per level."""
    m = len(centres)
    by_axis = [np.argsort(values, kind="stable") for values in _directions(centres)]
    code = np.zeros(m, dtype=np.int64)
    groups = 1
    while m > LEAF * groups:
        code = 2 * code + _halves(code, groups, by_axis, neighbours)
        groups *= 2
    return code


def _directions(centres: Array) -> list[Array]:
    """What the cells may be split by: radius, depth, both diagonals, and the two polar coordinates of meshes that are
    graded towards the origin."""
    r, z = centres.T
    return [r, z, r + z, r - z, np.hypot(r, z), np.arctan2(z, r)]


def _halves(group: Array, groups: int, by_axis: list[Array], neighbours: Array) -> Array:
    """Half 0 or 1 of every cell of its group."""
    sizes = np.bincount(group, minlength=groups)
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    together = neighbours[:, group[neighbours[0]] == group[neighbours[1]]]
    halves, cuts = [], []
    for order in by_axis:
        order = order[np.argsort(group[order], kind="stable")]
        half = np.empty(group.size, dtype=np.int64)
        half[order] = 2 * (np.arange(group.size) - starts[group[order]]) >= sizes[group[order]]
        halves.append(half)
        crossing = half[together[0]] != half[together[1]]
        cuts.append(np.bincount(group[together[0, crossing]], minlength=groups))
    best = np.argmin(cuts, axis=0)
    return np.array(halves)[best[group], np.arange(group.size)]

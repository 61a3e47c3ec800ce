"""Sparse factors of symmetric matrices that keep the order they are given, and that order (the door to CHOLMOD).

SciPy's SuperLU factorises everything; CHOLMOD, where the optional package cvxopt is installed, positive definite
matrices several times faster (Chen et al., ACM Trans. Math. Softw. 35 (2008) 22). Kept in order, the trailing block of
either factor is the Cholesky factor of the matrix condensed onto its last unknowns. The order is nested dissection of
the mesh (George, SIAM J. Numer. Anal. 10 (1973) 345): every group of cells is split at its median along one of a few
directions, whichever cuts the fewest facets, until the groups are small; all groups of a level at once. The nodes
between two halves are eliminated after both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, tril
from scipy.sparse.linalg import splu

from ...base import Array, InputError, SolveError, installs, one_thread
from .options import Solver


@dataclass(frozen=True)
class FactorTuning:
    """Sizes on which the time of a solve depends, not its result."""

    small: int = 20_000  # unknowns; CHOLMOD gains less than its import costs; tuned on its cases, by `make bench`
    leaf: int = 6  # cells; smaller groups gain nothing; tuned on the cases of `make bench`, by `make bench`


TUNING = FactorTuning()
ONLY_THE_GIVEN_ORDER = {"supernodal": 2, "nmethods": 1, "postorder": False}


@dataclass(frozen=True, eq=False)
class SparseFactor:
    """Factorised symmetric matrix A: ``solve(b)`` gives A^-1 b; ``root``: lower Cholesky factor of A condensed onto
    its last unknowns; ``name`` of the library, ``entries``: numbers it stores."""

    name: str
    entries: int
    root: Array
    solve: Callable[[Array], Array]


def sparse_factor(matrix: csc_matrix, tail: int, definite: bool, solver: Solver) -> SparseFactor:
    """Factorise ``matrix`` as it is ordered, to condense it onto the last ``tail`` unknowns; ``definite``: positive
    definite, no saddle point. "auto" takes CHOLMOD where it can and pays. Errors: InputError where it is missing,
    SolveError."""
    if solver == "cholmod" and not has_cholmod():
        raise InputError(f'mesh.solver: "cholmod" needs the optional package cvxopt: {installs("fast")}')
    pays = solver == "cholmod" or (solver == "auto" and matrix.shape[0] > TUNING.small)
    return _cholmod(matrix, tail) if definite and pays and has_cholmod() else _superlu(matrix, tail)


def has_cholmod() -> bool:
    """Whether the optional package is installed."""
    return find_spec("cvxopt") is not None


def _superlu(matrix: csc_matrix, tail: int) -> SparseFactor:
    """Factor by SuperLU, whose root is the last part of L, scaled by the pivots on U's diagonal."""
    with one_thread():
        lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    last = np.arange(matrix.shape[0] - tail, matrix.shape[0])
    if not (np.array_equal(lu.perm_c[-tail:], last) and np.array_equal(lu.perm_r[-tail:], last)):
        raise SolveError("factorisation: the solver did not keep the contact nodes last")
    L, U = (part[:, -tail:][-tail:].toarray() for part in (lu.L, lu.U))
    pivots = U.diagonal()
    if not (pivots > 0).all():
        raise SolveError(f"factorisation: the condensed stiffness is not positive (pivot {pivots.min():.3g} N/m)")
    return SparseFactor("SuperLU", int(lu.nnz), np.tril(L) * np.sqrt(pivots), lu.solve)


def _cholmod(matrix: csc_matrix, tail: int) -> SparseFactor:
    """Factor by CHOLMOD, which gives it away whole and has none left then: it factorises once more for the solves."""
    from cvxopt import cholmod, spmatrix
    from cvxopt import matrix as dense

    lower = tril(matrix, format="coo")
    size = matrix.shape[0]
    rows, columns, natural = (dense(index.astype(np.int64)) for index in (lower.row, lower.col, np.arange(size)))
    A = spmatrix(dense(lower.data), rows, columns, matrix.shape)

    def numeric() -> Any:
        handle = cholmod.symbolic(A, p=natural)
        cholmod.numeric(A, handle)
        return handle

    def solve(loads: Array) -> Array:
        solution = dense(np.ascontiguousarray(loads, dtype=float))
        cholmod.solve(handle, solution)
        return np.array(solution).reshape(loads.shape)

    before = dict(cholmod.options)
    cholmod.options.update(ONLY_THE_GIVEN_ORDER)
    try:
        with one_thread():
            L = cholmod.getfactor(numeric())
            root, entries = np.tril(np.array(dense(L[size - tail :, size - tail :]))), len(L)
            del L
            handle = numeric()
        return SparseFactor("CHOLMOD", entries, root, solve)
    except ArithmeticError as error:
        raise SolveError(f"factorisation: the stiffness is not positive definite (row {error})") from None
    finally:
        cholmod.options.clear()
        cholmod.options.update(before)


# ---------------------------------------------------------------------- the order
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
    r, z = centres.T
    # split along them, along both diagonals, and in the polar coordinates of meshes that are graded towards the origin
    along = r, z, r + z, r - z, np.hypot(r, z), np.arctan2(z, r)
    by_axis = [np.argsort(values, kind="stable") for values in along]
    code = np.zeros(m, dtype=np.int64)
    groups = 1
    while m > TUNING.leaf * groups:
        code = 2 * code + _halves(code, groups, by_axis, neighbours)
        groups *= 2
    return code


def _halves(group: Array, groups: int, by_axis: list[Array], neighbours: Array) -> Array:
    """The half of its group, 0 or 1, that every cell goes to."""
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

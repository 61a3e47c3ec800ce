"""Sparse factors of symmetric matrices that keep the order they are given (the door to CHOLMOD).

SciPy's SuperLU factorises everything; CHOLMOD, where the optional package cvxopt is installed, positive definite
matrices several times faster (Chen et al., ACM Trans. Math. Softw. 35 (2008) 22). Kept in order, the trailing block of
either factor is the Cholesky factor of the matrix condensed onto its last unknowns.
"""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csc_matrix, tril
from scipy.sparse.linalg import SuperLU, splu
from threadpoolctl import ThreadpoolController

from ...base.errors import InputError, SolveError
from .options import Solver

Array = np.ndarray
SMALL = 20_000  # unknowns, up to which CHOLMOD gains less than its import costs
SYMMETRIC = {"SymmetricMode": True}
ONLY_THE_GIVEN_ORDER = {"supernodal": 2, "nmethods": 1, "postorder": False}


class SparseFactor(Protocol):
    """A factorised symmetric matrix; ``entries``: stored numbers, ``name``: of the library; ``root``: lower Cholesky
    factor of the matrix condensed onto its last unknowns."""

    @property
    def name(self) -> str: ...

    @property
    def entries(self) -> int: ...

    @property
    def root(self) -> Array: ...

    def solve(self, loads: Array) -> Array: ...


def sparse_factor(matrix: csc_matrix, tail: int, definite: bool, solver: Solver) -> SparseFactor:
    """Factorise ``matrix`` as it is ordered, to condense it onto the last ``tail`` unknowns; ``definite``: positive
    definite, no saddle point. "auto" takes CHOLMOD where it can and pays. Errors: InputError where it is missing,
    SolveError."""
    if solver == "cholmod" and not has_cholmod():
        raise InputError('mesh.solver: "cholmod" needs the optional package cvxopt: pip install "jkrcli[fast]"')
    pays = solver == "cholmod" or (solver == "auto" and matrix.shape[0] > SMALL)
    if definite and pays and has_cholmod():
        return _cholmod(matrix, tail)
    with one_thread():
        lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options=SYMMETRIC)
    return SuperLUFactor(lu, _superlu_root(lu, tail))


def one_thread() -> AbstractContextManager[Any]:
    """While it lasts, BLAS works in one thread: on small matrices and many-column solves more only wait."""
    return _blas("cvxopt" in sys.modules).limit(limits=1)


@cache
def _blas(with_cholmod: bool) -> ThreadpoolController:
    """All BLAS libraries that are loaded, looked for once (it takes milliseconds); CHOLMOD brings its own."""
    return ThreadpoolController()


def has_cholmod() -> bool:
    """Whether the optional package is installed."""
    return find_spec("cvxopt") is not None


@dataclass(frozen=True, eq=False)
class SuperLUFactor:
    lu: SuperLU
    root: Array
    name = "SuperLU"

    @property
    def entries(self) -> int:
        return int(self.lu.nnz)

    def solve(self, loads: Array) -> Array:
        with one_thread():
            return self.lu.solve(loads)


def _superlu_root(lu: SuperLU, n: int) -> Array:
    """The factor of the Schur complement: the last n rows and columns of L, scaled by the pivots on U's diagonal."""
    size = lu.shape[0]
    last = np.arange(size - n, size)
    if not (np.array_equal(lu.perm_c[-n:], last) and np.array_equal(lu.perm_r[-n:], last)):
        raise SolveError("factorisation: the solver did not keep the contact nodes last")
    pivots = _last_block(lu.U, n).diagonal()
    if not (pivots > 0).all():
        raise SolveError(f"factorisation: the condensed stiffness is not positive (pivot {pivots.min():.3g} N/m)")
    return np.tril(_last_block(lu.L, n)) * np.sqrt(pivots)


def _last_block(matrix: csc_matrix, n: int) -> Array:
    """The last n rows and columns as a dense array."""
    size = matrix.shape[0]
    start = matrix.indptr[size - n]
    rows = matrix.indices[start:] - (size - n)
    columns = np.repeat(np.arange(n), np.diff(matrix.indptr[size - n :]))
    block = np.zeros((n, n))
    inside = rows >= 0
    block[rows[inside], columns[inside]] = matrix.data[start:][inside]
    return block


@dataclass(frozen=True, eq=False)
class CholmodFactor:
    """``handle``: CHOLMOD's own object; ``root``: the trailing block."""

    handle: Any
    root: Array
    entries: int
    name = "CHOLMOD"

    def solve(self, loads: Array) -> Array:
        from cvxopt import cholmod, matrix

        solution = matrix(np.ascontiguousarray(loads, dtype=float))
        with one_thread():
            cholmod.solve(self.handle, solution)
        return np.array(solution).reshape(loads.shape)


def _cholmod(matrix: csc_matrix, tail: int) -> CholmodFactor:
    """CHOLMOD gives its factor away only whole, and has none left then: it factorises once more for the solves."""
    from cvxopt import cholmod, spmatrix
    from cvxopt import matrix as dense

    lower = tril(matrix, format="coo")
    size = matrix.shape[0]
    rows, columns, natural = (dense(index.astype(np.int64)) for index in (lower.row, lower.col, np.arange(size)))

    def numeric() -> Any:
        handle = cholmod.symbolic(A, p=natural)
        cholmod.numeric(A, handle)
        return handle

    before = dict(cholmod.options)
    cholmod.options.update(ONLY_THE_GIVEN_ORDER)
    try:
        with one_thread():
            A = spmatrix(dense(lower.data), rows, columns, matrix.shape)
            L = cholmod.getfactor(numeric())
            root = np.tril(np.array(dense(L[size - tail :, size - tail :])))
            entries = len(L)
            del L
            return CholmodFactor(numeric(), root, entries)
    except ArithmeticError as error:
        raise SolveError(f"factorisation: the stiffness is not positive definite (row {error})") from None
    finally:
        cholmod.options.clear()
        cholmod.options.update(before)

"""Axisymmetric elasticity on a rectangle of products of line elements: every block is a sum of Kronecker products.

Moduli depend on depth alone, so that each integral over the rectangle is a product of one along r and one along z.
Unknowns: u_r of all nodes (z by z), u_z of all nodes, and in nearly incompressible layers a pressure of one degree
less, continuous in the layer (Taylor and Hood 1973). All integrals carry the weight 2 pi r.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import bmat, coo_matrix, csr_matrix
from scipy.sparse.linalg import splu

from ...base import AT_ONCE, RESIDUAL_LIMIT, Array, SolveError
from .lines import LineElements
from .region import Moduli, Region


@dataclass(frozen=True)
class SolveTuning:
    """When a factor pivots, and when a solve is repeated."""

    # Of the column's largest entry, what a diagonal entry must be: with pressures some are zero.
    pivot: float = 1e-3  # tuned on nearly incompressible bodies, by `make tuning`
    # Relative residual of a solve that is not repeated for what is left: great contrasts and distances leave 1e-7.
    close: float = 1e-9  # theory: K errs by its square only


TUNING = SolveTuning()


@dataclass(frozen=True, eq=False)
class Mesh:
    """Mesh of a region: line elements along ``r`` and ``z``; fields at nodes or Gauss points have the shape (..., z,
    r)."""

    region: Region
    r: LineElements
    z: LineElements

    @cached_property
    def moduli(self) -> Moduli:
        """Stiffnesses at the Gauss points along z."""
        return self.region.moduli(self.z.rule[0])

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Number of nodes along z and along r."""
        return self.z.nodes.size, self.r.nodes.size

    @property
    def nodes(self) -> int:
        return self.shape[0] * self.shape[1]

    @cached_property
    def joined(self) -> tuple[Array, Array]:
        """Inner edges along r and along z at which a pressure is continuous: not at interfaces."""
        layer = self.region.layer_at((self.z.edges[1:] + self.z.edges[:-1]) / 2)
        return np.ones(self.r.degrees.size - 1, dtype=bool), layer[1:] == layer[:-1]

    @cached_property
    def used(self) -> Array:
        """Which pressure functions along z belong to layers with a pressure."""
        return np.any(self.z.pressure(self.joined[1])[self.moduli.mixed] != 0, axis=0)

    @cached_property
    def pressure(self) -> tuple[Array, Array]:
        """Pressure functions at the Gauss points along r and along z; none along z where no layer needs them."""
        return self.r.pressure(self.joined[0]), self.z.pressure(self.joined[1])[:, self.used]

    @cached_property
    def constrained(self) -> Array:
        """Mask (2, z, r) of the displacements that the supports or the axis prescribe."""
        mask = np.zeros((2, *self.shape), dtype=bool)
        mask[0, :, 0] = True
        mask[:, -1, :] |= np.array(self.region.base)[:, None]
        mask[:, :, -1] |= np.array(self.region.side)[:, None]
        return mask

    @cached_property
    def stiffness(self) -> csr_matrix:
        """The symmetric matrix of all unknowns; indefinite with pressures."""
        C11, C12, C13, C33, C44 = self.moduli.C
        r, w = self.r.rule
        w = 2 * np.pi * w
        (V, D), (V_z, D_z) = self.r.basis, self.z.basis
        mass, slope, mixed = _integral(V, w * r, V), _integral(D, w * r, D), _integral(D, w * r, V)
        hoop, cross, whole = _integral(V, w / r, V), _integral(D, w, V), _integral(V, w, V)

        def over_z(left: Array, weight: Array | float, right: Array) -> Array:
            return _integral(left, self.z.rule[1] * weight, right)

        product = _Product(_touching(V_z, V_z), _touching(V, V))
        rr = product(
            (over_z(V_z, C11, V_z), slope + hoop),
            (over_z(V_z, C12, V_z), cross + cross.T),
            (over_z(D_z, C44, D_z), mass),
        )
        rz = product((over_z(V_z, C13, D_z), mixed + whole), (over_z(D_z, C44, V_z), mixed.T))
        zz = product((over_z(D_z, C33, D_z), mass), (over_z(V_z, C44, V_z), slope))
        Q, Q_z = self.pressure
        if not Q_z.shape[1]:
            return bmat([[rr, rz], [rz.T, zz]], format="csr")
        coupling = _Product(_touching(Q_z, V_z), _touching(Q, V))
        p_r = coupling((over_z(Q_z, 1.0, V_z), _integral(Q, w * r, D) + _integral(Q, w, V)))
        p_z = coupling((over_z(Q_z, 1.0, D_z), _integral(Q, w * r, V)))
        inverse = over_z(Q_z, self.moduli.inverse_lame, Q_z)
        pp = _Product(_touching(Q_z, Q_z), _touching(Q, Q))((inverse, _integral(Q, w * r, Q)))
        return bmat([[rr, rz, -p_r.T], [rz.T, zz, -p_z.T], [-p_r, -p_z, -pp]], format="csr")

    def work(self, U: Array) -> tuple[Array, Array]:
        """The work (m, m) of the stresses of each of the fields ``U`` (n, m) in the strains of the others, and how far
        rounding can move it.

        It is gathered from strains: what rounding leaves of U^T A U grows with the square of motions that strain
        nothing, as those of the top of a slender rod, a thousand times what the contact changes there.
        """
        weights = 2 * np.pi * self.z.rule[1][:, None] * (self.r.rule[1] * self.r.rule[0])
        work, moved = np.zeros((2, U.shape[1], U.shape[1]))
        fields, sizes = self._along_r(U), self._along_r(np.abs(U), np.abs)
        for rows in self._slabs(U.shape[1]):
            rr, tt, zz, rz, p = strains = self._strains(fields, rows)
            C11, C12, C13, C33, C44 = self.moduli.C[:, rows, None, None]
            misfit = rr + tt + zz + self.moduli.inverse_lame[rows, None, None] * p
            s_rr, s_tt = C11 * rr + C12 * tt + C13 * zz - p, C12 * rr + C11 * tt + C13 * zz - p
            stresses = s_rr, s_tt, C13 * (rr + tt) + C33 * zz - p, C44 * rz, -misfit
            for stress, strain, size in zip(stresses, strains, self._strains(sizes, rows, np.abs), strict=True):
                stress *= weights[rows, :, None]
                work += _pairs(stress, strain)
                moved += _pairs(np.abs(stress), size)
        return work, np.finfo(float).eps * (moved + moved.T)

    def _slabs(self, count: int) -> Iterator[slice]:
        """Gauss points along z for fields of ``count`` at a time within the memory allowed."""
        points = self.z.rule[0].size
        size = max(1, AT_ONCE // (count * self.r.rule[0].size))
        return (slice(start, start + size) for start in range(0, points, size))

    def _along_r(self, U: Array, of: Callable[[Array], Array] = np.asarray) -> list[Array]:
        """What strains and pressures need of the fields ``U`` (n, m) at the Gauss points along r, by nodes along z: of
        u_r its slope, its value and u_r/r, of u_z its slope and its value, and p, each (z, r * m)."""
        (nz, nr), n, m = self.shape, self.nodes, U.shape[1]
        (V, D), (Q, Q_z) = self.r.basis, self.pressure
        hoop = V / self.r.rule[0][:, None]
        u_r, u_z = U[: 2 * n].reshape(2, nz, nr, m)
        p = U[2 * n :].reshape(Q_z.shape[1], Q.shape[1], m)
        pairs = ((D, u_r), (V, u_r), (hoop, u_r), (D, u_z), (V, u_z), (Q, p))
        return [_applied(of(A), np.moveaxis(field, 0, 1)) for A, field in pairs]

    def _strains(self, along: list[Array], rows: slice, of: Callable[[Array], Array] = np.asarray) -> list[Array]:
        """Strains rr, tt, zz, 2 rz and the pressure (z, r, m) at some ``rows`` of Gauss points, from ``_along_r``."""
        V, D, Q = (csr_matrix(of(A[rows])) for A in (*self.z.basis, self.pressure[1]))
        slope_r, u_r, hoop, slope_z, u_z, p = along
        points = self.r.rule[0].size
        strains = V @ slope_r, V @ hoop, D @ u_z, D @ u_r + V @ slope_z, Q @ p
        return [strain.reshape(len(strain), points, strain.shape[1] // points) for strain in strains]

    @cached_property
    def free(self) -> Array:
        """Numbers of the unknowns that nothing prescribes."""
        constrained = np.flatnonzero(self.constrained.ravel())
        return np.setdiff1d(np.arange(self.stiffness.shape[0]), constrained)

    def solve(self, loads: Array, prescribed: Array) -> Array:
        """Unknowns (n, m) in balance with ``loads`` (n, m) where free, equal to ``prescribed`` (n, m) elsewhere."""
        free, K = self.free, self.stiffness
        known = prescribed.copy()
        known[free] = 0.0
        right = (loads - K @ known)[free]
        matrix = K[free][:, free].tocsc()
        threshold = TUNING.pivot if self.pressure[1].shape[1] else 0.0
        options = {"SymmetricMode": True}
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=threshold, options=options)
        known[free] = lu.solve(right)
        size, left = np.abs(right).max(), right - matrix @ known[free]
        if not np.abs(left).max() < TUNING.close * size:
            known[free] += lu.solve(left)
            left = right - matrix @ known[free]
        residual = np.abs(left).max() / size
        if not residual < RESIDUAL_LIMIT:
            raise SolveError(
                f"hybrid: the correction leaves a residual of {residual:.1e}, allowed {RESIDUAL_LIMIT:g}: moduli or "
                "sizes differ by too much for elements; leave out what is far softer, stiffer or thinner than all "
                "else, or, of a wide body, use method layered"
            )
        return known


@dataclass(frozen=True, eq=False)
class _Product:
    """Sums of Kronecker products of a matrix along z and one along r, from the entries where functions overlap."""

    z: Array
    r: Array

    def __call__(self, *terms: tuple[Array, Array]) -> coo_matrix:
        (rows_z, columns_z), (rows_r, columns_r) = np.nonzero(self.z), np.nonzero(self.r)
        values = sum(np.multiply.outer(A[rows_z, columns_z], B[rows_r, columns_r]) for A, B in terms)
        rows = np.add.outer(rows_z * self.r.shape[0], rows_r)
        columns = np.add.outer(columns_z * self.r.shape[1], columns_r)
        shape = (self.z.shape[0] * self.r.shape[0], self.z.shape[1] * self.r.shape[1])
        return coo_matrix((np.ravel(values), (rows.ravel(), columns.ravel())), shape=shape)


def _applied(A: Array, fields: Array) -> Array:
    """A (points, r) along the first axis of ``fields`` (r, z, m): (z, points * m)."""
    r, z, m = fields.shape
    values = csr_matrix(A) @ fields.reshape(r, z * m)
    return np.moveaxis(values.reshape(len(A), z, m), 0, 1).reshape(z, len(A) * m)


def _pairs(stress: Array, strain: Array) -> Array:
    """Sums (m, m) over all points of the products of every ``stress`` (z, r, m) with every ``strain``."""
    m = stress.shape[-1]
    return stress.reshape(-1, m).T @ strain.reshape(-1, m)


def _touching(left: Array, right: Array) -> Array:
    """Which functions are both not zero somewhere."""
    return (left != 0).astype(float).T @ (right != 0).astype(float) > 0


def _integral(left: Array, weights: Array, right: Array) -> Array:
    """Integral of ``left`` times ``right`` with the given weights at the Gauss points."""
    return left.T @ (weights[:, None] * right)

"""Stresses of a solution with second-order elements: at the vertices, and tractions along the lines of a body.

At a vertex: the quadratic polynomial that fits best the stresses at the integration points of the elements around it
(Zienkiewicz and Zhu, Int. J. Numer. Meth. Eng. 33 (1992) 1331), layer by layer.

On a line: the tractions that balance the nodal forces which the elements on one side of it exert, int t v dA =
int sigma : eps(v) dV for every shape function v of the line. They are in equilibrium whatever the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, identity
from scipy.sparse.linalg import spsolve

from ...base.arrays import Array
from .elasticity import ElasticSystem, force_r, force_z, mass, measure, stiffness_constants


@dataclass(frozen=True)
class RecoveryTuning:
    """Patches of cells from which the stress at a vertex is recovered."""

    few: int = 5  # cells around a vertex that are no patch by themselves; theory: 6 monomials want as many cells
    singular: float = 1e-8  # of a patch's moments; theory: square root of round-off: combinations left undetermined


TUNING = RecoveryTuning()
COMPONENTS = ("rr", "tt", "zz", "rz")


@dataclass(frozen=True, eq=False)
class TractionLine:
    """Tractions ``zz, rz`` (n,) [Pa], tension positive, at the radii ``r`` [m] of a horizontal line at ``depth`` [m].

    ``zz_error, rz_error`` [Pa]: what tractions of one order less differ by. ``area`` [m^2]: of the rings that integrate
    them, so that ``area @ zz`` is a force.
    """

    depth: float
    r: Array
    zz: Array
    rz: Array
    zz_error: Array
    rz_error: Array
    area: Array

    @property
    def load(self) -> float:
        """Compressive force that passes through [N]."""
        return -float(self.area @ self.zz)

    @property
    def size(self) -> float:
        """Pressure and tension together, both counted positive [N]: of an adhesive contact they nearly cancel."""
        return float(self.area @ np.abs(self.zz))

    def error(self, reach: float) -> float:
        """Mean error of zz within the radius ``reach`` [m] over the mean size of zz there."""
        near = self.r <= reach
        return float(self.area[near] @ self.zz_error[near] / (self.area[near] @ np.abs(self.zz[near])))


@dataclass(frozen=True, eq=False)
class Stress:
    """Stress recovery for a ``solution`` of ``system``."""

    system: ElasticSystem
    solution: Array

    def at_vertices(self, layer: int) -> tuple[Array, Array]:
        """Vertex numbers of a layer (n,) and the stresses (4, n) there [Pa]: rr, tt, zz, rz."""
        grid, cells = self.system.grid, self.system.in_layer(layer, degree=2)
        used, corners = np.unique(grid.cells[grid.materials == layer], return_inverse=True)
        samples = np.moveaxis(np.asarray(cells.global_coordinates()), 0, -1)
        values = np.moveaxis(self._at_points(cells, layer), 0, -1)
        fitted = _fitted(grid.points[used], corners.reshape(len(samples), -1), samples, values).T
        fitted[3, grid.points[used, 0] == 0] = 0.0  # there is no shear on the axis
        return used, fitted

    def interface(self, above: int) -> TractionLine:
        """Tractions between the layers ``above`` and ``above`` + 1."""
        f2t, layers = self.system.basis.mesh.f2t, self.system.grid.materials
        inner = np.flatnonzero(f2t[1] >= 0)
        upper, lower = np.sort(layers[f2t[:, inner]], axis=0)
        return self._balanced(inner[(upper == above) & (lower == above + 1)], above, -1)

    def surface(self, reach: float) -> TractionLine:
        """Tractions on the contact surface out to the radius ``reach`` [m], a vertex."""
        mesh = self.system.basis.mesh
        facets = mesh.boundaries["surface"]
        return self._balanced(facets[mesh.p[0, mesh.facets[:, facets]].max(axis=0) <= reach * (1 + 1e-9)], 0, 1)

    def base(self) -> TractionLine:
        """Tractions on the base of the body."""
        return self._balanced(self.system.basis.mesh.boundaries["base"], int(self.system.grid.materials.max()), -1)

    def _balanced(self, facets: Array, layer: int, outward: int) -> TractionLine:
        """Tractions on ``facets`` of a ``layer`` that lies below (``outward`` = 1) or above (-1) them."""
        cells, on_line = self.system.in_layer(layer), self.system.on_facets(facets, degree=5)
        stress = dict(zip(COMPONENTS, self._at_points(cells, layer), strict=True))
        nodes = np.unique(on_line.get_dofs(facets).all())
        nodes = nodes[np.argsort(self.system.nodes[nodes, 0], kind="stable")]
        r, z = self.system.nodes[nodes].T
        products = mass.assemble(on_line)[nodes][:, nodes].tocsc()
        axis = int(r[0] == 0)  # there is no shear on it
        zz, zz_linear = _traction(products, outward * force_z.assemble(cells, **stress)[nodes], 0)
        rz, rz_linear = _traction(products, outward * force_r.assemble(cells, **stress)[nodes], axis)
        area = measure.assemble(on_line)[nodes]
        return TractionLine(abs(float(z[0])), r, zz, rz, np.abs(zz - zz_linear), np.abs(rz - rz_linear), area)

    def _at_points(self, basis: Any, layer: int) -> Array:
        """rr, tt, zz, rz (4, cells, points) [Pa] at the points of a basis on cells of one layer."""
        system = self.system
        u_r, u_z = (basis.interpolate(part) for part in system.components(self.solution))
        r, z = np.asarray(basis.global_coordinates())
        on_axis = r <= 0
        rr, zz = u_r.grad[0], u_z.grad[1]
        tt = np.where(on_axis, rr, np.asarray(u_r) / np.where(on_axis, 1.0, r))
        rz = u_r.grad[1] + u_z.grad[0]
        depth = system.grid.depth_below_top(layer, z)
        C11, C12, C13, C33, C44 = stiffness_constants(system.materials[layer], layer in system.mixed, depth)
        p = system.pressure(self.solution, layer, basis)
        return np.array([
            C11 * rr + C12 * tt + C13 * zz - p, C12 * rr + C11 * tt + C13 * zz - p, C13 * (rr + tt) + C33 * zz - p,
            C44 * rz,
        ])  # fmt: skip


def _traction(products: csc_matrix, force: Array, first: int) -> tuple[Array, Array]:
    """Tractions at the nodes of a line, vertices and midsides in turn, that balance ``force``: quadratic, and linear
    between the vertices; 0 at the nodes before ``first``."""
    nodes = np.arange(force.size)
    hats = np.eye(nodes[::2].size)
    linear = csc_matrix(np.column_stack([np.interp(nodes, nodes[::2], hat) for hat in hats]))
    return tuple(
        T @ spsolve((T.T @ products @ T).tocsc(), T.T @ force)
        for T in (space[:, first:].tocsc() for space in (identity(force.size, format="csc"), linear))
    )


def _fitted(vertices: Array, corners: Array, samples: Array, values: Array) -> Array:
    """Best quadratic fits at ``vertices`` (n, 2) to the ``values`` (cells, q, k) at ``samples`` (cells, q, 2) of the
    cells that have them as ``corners`` (cells, c): values at the vertices (n, k). On the axis they are even in r."""
    n = len(vertices)
    owners, cells = _patches(n, corners)
    offsets = samples[cells] - vertices[owners][:, None]
    size = np.zeros(n)
    np.maximum.at(size, owners, np.linalg.norm(offsets, axis=-1).max(axis=1))
    x, y = np.moveaxis(offsets / size[owners][:, None, None], -1, 0)
    odd = np.where(vertices[owners, 0] > 0, 1.0, 0.0)[:, None] * x
    monomials = np.stack([np.ones_like(x), odd, y, x * x, odd * y, y * y], axis=-1)
    known = np.concatenate([monomials, values[cells]], axis=-1)
    products = np.einsum("pqi,pqj->ijp", monomials, known)
    sums = np.array([[np.bincount(owners, one, n) for one in row] for row in products])
    moments, right = np.moveaxis(sums[:, :6], -1, 0), np.moveaxis(sums[:, 6:], -1, 0)
    return (np.linalg.pinv(moments, rcond=TUNING.singular, hermitian=True) @ right)[:, 0]


def _patches(n: int, corners: Array) -> tuple[Array, Array]:
    """Vertices and cells that belong together: the cells around each of ``n`` vertices, where these are few with the
    cells around their other corners."""
    rows, columns = corners.ravel(), np.repeat(np.arange(len(corners)), corners.shape[1])
    around = csr_matrix((np.ones(rows.size), (rows, columns)), shape=(n, len(corners)))
    few = np.diff(around.indptr) < TUNING.few
    wider = (around[few] @ around.T @ around).tocoo()
    own = around[~few].tocoo()
    owners = np.concatenate([np.flatnonzero(few)[wider.row], np.flatnonzero(~few)[own.row]])
    return owners, np.concatenate([wider.col, own.col])

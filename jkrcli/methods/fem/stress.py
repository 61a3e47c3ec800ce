"""Stresses of a solution: at the vertices, and tractions along the lines of a body.

At a vertex: the mean of the cells around it, layer by layer; on a line the tractions are those of the line.

On a line: the tractions that balance the nodal forces which the elements on one side of it exert, int t v dA =
int sigma : eps(v) dV for every shape function v of the line. They are in equilibrium whatever the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, identity
from scipy.sparse.linalg import spsolve

from ...base import ROUNDED, Array
from .elasticity import ElasticSystem, force_r, force_z, mass, measure, stiffness_constants


@dataclass(frozen=True)
class TractionTuning:
    """What the error of tractions is concluded from."""

    caution: float = 4.0  # times what one order less changes; tuned on the bodies of test_fields.py, by `make test-all`


TUNING = TractionTuning()
COMPONENTS = ("rr", "tt", "zz", "rz")


@dataclass(frozen=True, eq=False)
class TractionLine:
    """Tractions ``zz, rz`` (n,) [Pa], tension positive, at the radii ``r`` [m] of a horizontal line at ``depth`` [m].

    ``zz_error, rz_error`` [Pa]: their estimated errors. ``area`` [m^2]: of the rings that integrate
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
    """Stress recovery for a ``solution`` of ``system``; ``cut``: its relative error by where the body is cut off."""

    system: ElasticSystem
    solution: Array
    cut: float

    def at_vertices(self, layer: int) -> tuple[Array, Array]:
        """Vertex numbers of a layer (n,) and the stresses (4, n) there [Pa]: rr, tt, zz, rz."""
        grid, cells = self.system.grid, self.system.basis.mesh.t.T
        used, corners = np.unique(cells[grid.materials == layer], return_inverse=True)
        values = self._at_points(self.system.at_corners(layer), layer).reshape(len(COMPONENTS), -1)
        means = np.array([np.bincount(corners.ravel(), row) for row in values]) / np.bincount(corners.ravel())
        means[3, grid.points[used, 0] == 0] = 0.0  # there is no shear on the axis
        return used, means

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
        return self._balanced(facets[mesh.p[0, mesh.facets[:, facets]].max(axis=0) <= reach * (1 + ROUNDED)], 0, 1)

    def base(self) -> TractionLine:
        """Tractions on the base of the body."""
        return self._balanced(self.system.basis.mesh.boundaries["base"], int(self.system.grid.materials.max()), -1)

    def _balanced(self, facets: Array, layer: int, outward: int) -> TractionLine:
        """Tractions on ``facets`` of a ``layer`` that lies below (``outward`` = 1) or above (-1) them."""
        order = self.system.order
        cells, on_line = self.system.in_layer(layer), self.system.on_facets(facets, degree=2 * order + 1)
        stress = dict(zip(COMPONENTS, self._at_points(cells, layer), strict=True))
        nodes = np.unique(on_line.get_dofs(facets).all())
        nodes = nodes[np.argsort(self.system.nodes[nodes, 0], kind="stable")]
        r, z = self.system.nodes[nodes].T
        products = mass.assemble(on_line)[nodes][:, nodes].tocsc()
        axis = int(r[0] == 0)  # there is no shear on it
        zz, zz_error = _traction(products, outward * force_z.assemble(cells, **stress)[nodes], 0, order)
        rz, rz_error = _traction(products, outward * force_r.assemble(cells, **stress)[nodes], axis, order)
        area = measure.assemble(on_line)[nodes]
        zz_error, rz_error = zz_error + self.cut * np.abs(zz), rz_error + self.cut * np.abs(rz)
        return TractionLine(abs(float(z[0])), r, zz, rz, zz_error, rz_error, area)

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


def _traction(products: csc_matrix, force: Array, first: int, order: int) -> tuple[Array, Array]:
    """Tractions at the nodes of a line that balance ``force``, 0 at the nodes before ``first``, and their errors, from
    what polynomials of one order less than ``order`` change."""
    tractions = []
    for space in (identity(force.size, format="csc"), _one_order_less(force.size, order)):
        T = space[:, first:].tocsc()
        tractions.append(T @ spsolve((T.T @ products @ T).tocsc(), T.T @ force))
    return tractions[0], TUNING.caution * np.abs(tractions[0] - tractions[1])


def _one_order_less(nodes: int, order: int) -> csc_matrix:
    """Values at the ``nodes`` of a line of sides of ``order`` from those at the nodes of ``order`` - 1."""
    x, y = np.linspace(-1, 1, order + 1), np.linspace(-1, 1, order)
    side = np.vander(x, order) @ np.linalg.inv(np.vander(y, order))
    matrix = np.zeros((nodes, (nodes - 1) // order * (order - 1) + 1))
    for k in range((nodes - 1) // order):
        matrix[k * order : (k + 1) * order + 1, k * (order - 1) : (k + 1) * (order - 1) + 1] = side
    return csc_matrix(matrix)

"""Stresses of a solution with second-order elements: at the vertices, and tractions along the lines of a body.

At a vertex: the quadratic polynomial that fits best the stresses at the integration points of the elements around it
(Zienkiewicz and Zhu, Int. J. Numer. Meth. Eng. 33 (1992) 1331), layer by layer.

On a line: the tractions that balance the nodal forces which the elements on one side of it exert, int t v dA =
int sigma : eps(v) dV for every shape function v of the line. They are in equilibrium whatever the mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, identity
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, FacetBasis, LinearForm

from ...bodies.materials import Material, TransverselyIsotropic
from .elasticity import PRESSURE, ElasticSystem, isotropic_constants, ring_area
from .grid import Grid

Array = np.ndarray
COMPONENTS = ("rr", "tt", "zz", "rz")
FEW = 5  # cells around a vertex that do not make a patch by themselves
SINGULAR = 1e-8  # of a patch's moments: combinations of monomials that its points do not determine


@BilinearForm
def ring_mass(u: Any, v: Any, w: Any) -> Array:
    return u * v * 2 * np.pi * w.x[0]


@LinearForm
def force_r(v: Any, w: Any) -> Array:
    """sigma : eps(v) of a radial v."""
    return (w["rr"] * v.grad[0] + w["rz"] * v.grad[1]) * 2 * np.pi * w.x[0] + w["tt"] * v * 2 * np.pi


@LinearForm
def force_z(v: Any, w: Any) -> Array:
    """sigma : eps(v) of an axial v."""
    return (w["zz"] * v.grad[1] + w["rz"] * v.grad[0]) * 2 * np.pi * w.x[0]


@dataclass(frozen=True, eq=False)
class Line:
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
    """Stress recovery for a ``solution`` of ``system`` on ``grid`` with the ``materials`` of its layers."""

    grid: Grid
    system: ElasticSystem
    materials: Sequence[Material]
    solution: Array

    def at_vertices(self, layer: int) -> tuple[Array, Array]:
        """Vertex numbers of a layer (n,) and the stresses (4, n) there [Pa]: rr, tt, zz, rz."""
        inside = np.flatnonzero(self.grid.materials == layer)
        cells = Basis(self._mesh, self._element, elements=inside, intorder=2)
        used, corners = np.unique(self.grid.cells[inside], return_inverse=True)
        samples = np.moveaxis(np.asarray(cells.global_coordinates()), 0, -1)
        values = np.moveaxis(self._evaluated(cells, layer), 0, -1)
        fitted = _fitted(self.grid.points[used], corners.reshape(len(inside), -1), samples, values).T
        fitted[3, self.grid.points[used, 0] == 0] = 0.0  # there is no shear on the axis
        return used, fitted

    def interface(self, above: int) -> Line:
        """Tractions between the layers ``above`` and ``above`` + 1."""
        f2t, layers = self._mesh.f2t, self.grid.materials
        inner = np.flatnonzero(f2t[1] >= 0)
        upper, lower = np.sort(layers[f2t[:, inner]], axis=0)
        facets = inner[(upper == above) & (lower == above + 1)]
        return self._balanced(facets, above, -1)

    def end(self, name: str, reach: float | None = None) -> Line:
        """Tractions on the "surface" (out to the radius ``reach`` [m], a vertex) or the "base" of the body."""
        top = name == "surface"
        layer = 0 if top else int(self.grid.materials.max())
        facets = self._mesh.boundaries[name]
        if reach is not None:
            facets = facets[self._mesh.p[0, self._mesh.facets[:, facets]].max(axis=0) <= reach * (1 + 1e-9)]
        return self._balanced(facets, layer, 1 if top else -1)

    # ------------------------------------------------------------------ evaluation
    @property
    def _mesh(self) -> Any:
        return self.system.basis.mesh

    @property
    def _element(self) -> Any:
        return self.system.basis.elem

    def _balanced(self, facets: Array, layer: int, outward: int) -> Line:
        """Tractions on ``facets`` of a ``layer`` that lies below (``outward`` = 1) or above (-1) them."""
        inside, basis = np.flatnonzero(self.grid.materials == layer), self.system.basis
        cells = Basis(self._mesh, self._element, elements=inside, quadrature=(basis.X, basis.W))
        stress = dict(zip(COMPONENTS, self._evaluated(cells, layer), strict=True))
        on_line = FacetBasis(self._mesh, self._element, facets=facets, intorder=5)
        nodes = np.unique(on_line.get_dofs(facets).all())
        nodes = nodes[np.argsort(self.system.nodes[nodes, 0], kind="stable")]
        r, z = self.system.nodes[nodes].T
        mass = ring_mass.assemble(on_line)[nodes][:, nodes].tocsc()
        axis = int(r[0] == 0)  # there is no shear on it
        zz, zz_linear = _traction(mass, outward * force_z.assemble(cells, **stress)[nodes], 0)
        rz, rz_linear = _traction(mass, outward * force_r.assemble(cells, **stress)[nodes], axis)
        area = ring_area.assemble(on_line)[nodes]
        return Line(abs(float(z[0])), r, zz, rz, np.abs(zz - zz_linear), np.abs(rz - rz_linear), area)

    def _evaluated(self, basis: Any, layer: int) -> Array:
        """rr, tt, zz, rz (4, cells, points) [Pa] at the points of a basis on cells of one layer."""
        N = len(self.system.nodes)
        u_r, u_z = (basis.interpolate(part) for part in (self.solution[:N], self.solution[N : 2 * N]))
        r, z = np.asarray(basis.global_coordinates())
        on_axis = r <= 0
        rr, zz = u_r.grad[0], u_z.grad[1]
        tt = np.where(on_axis, rr, np.asarray(u_r) / np.where(on_axis, 1.0, r))
        rz = u_r.grad[1] + u_z.grad[0]
        C11, C12, C13, C33, C44 = self._constants(layer, z)
        p = self._pressure(basis, layer)
        return np.array([
            C11 * rr + C12 * tt + C13 * zz - p, C12 * rr + C11 * tt + C13 * zz - p, C13 * (rr + tt) + C33 * zz - p,
            C44 * rz,
        ])  # fmt: skip

    def _constants(self, layer: int, z: Array) -> Array:
        """C11, C12, C13, C33, C44 [Pa] at the heights ``z`` [m]; of a layer with a pressure unknown without lambda."""
        material = self.materials[layer]
        if isinstance(material, TransverselyIsotropic):
            return np.array(material.stiffness).reshape(5, *[1] * z.ndim)
        top = self.grid.points[self.grid.cells[self.grid.materials == layer], 1].max()
        unit = isotropic_constants(material.nu, layer in self.system.mixed)
        return np.multiply.outer(unit, material.at(np.maximum(top - z, 0.0)))

    def _pressure(self, basis: Any, layer: int) -> Array | float:
        """The layer's own pressure unknown [Pa] at the points of ``basis``; 0 where it has none."""
        mixed = self.system.mixed
        if layer not in mixed:
            return 0.0
        used = [np.unique(self.grid.cells[self.grid.materials == i]) for i in mixed]
        k = mixed.index(layer)
        first = 2 * len(self.system.nodes) + sum(vertices.size for vertices in used[:k])
        values = np.zeros(len(self.grid.points))
        values[used[k]] = self.solution[first : first + used[k].size]
        return np.asarray(basis.with_element(PRESSURE[self.grid.element]()).interpolate(values))


def _traction(mass: csc_matrix, force: Array, first: int) -> tuple[Array, Array]:
    """Tractions at the nodes of a line, vertices and midsides in turn, that balance ``force``: quadratic, and linear
    between the vertices; 0 at the nodes before ``first``."""
    n = force.size
    vertices = np.arange(0, n, 2)
    middles = np.arange(1, n, 2)
    rows = np.concatenate([vertices, middles, middles])
    columns = np.concatenate([vertices, middles - 1, middles + 1]) // 2
    weights = np.concatenate([np.ones(vertices.size), np.full(2 * middles.size, 0.5)])
    linear = csc_matrix((weights, (rows, columns)), shape=(n, vertices.size))
    return tuple(
        T @ spsolve((T.T @ mass @ T).tocsc(), T.T @ force)
        for T in (space[:, first:].tocsc() for space in (identity(n, format="csc"), linear))
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
    return (np.linalg.pinv(moments, rcond=SINGULAR, hermitian=True) @ right)[:, 0]


def _patches(n: int, corners: Array) -> tuple[Array, Array]:
    """Vertices and cells that belong together: the cells around each of ``n`` vertices, where these are few with the
    cells around their other corners."""
    rows, columns = corners.ravel(), np.repeat(np.arange(len(corners)), corners.shape[1])
    around = csr_matrix((np.ones(rows.size), (rows, columns)), shape=(n, len(corners)))
    few = np.diff(around.indptr) < FEW
    wider = (around[few] @ around.T @ around).tocoo()
    own = around[~few].tocoo()
    owners = np.concatenate([np.flatnonzero(few)[wider.row], np.flatnonzero(~few)[own.row]])
    return owners, np.concatenate([wider.col, own.col])

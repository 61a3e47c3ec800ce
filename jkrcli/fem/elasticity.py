"""Axisymmetric linear elasticity on a grid (the door to scikit-fem).

With one scalar basis for both components, u = (u_r, u_z), strains rr: du_r/dr, tt: u_r/r, zz: du_z/dz,
rz: du_r/dz + du_z/dr, the stiffness has three blocks, each a scalar form with the weight 2 pi r. Layers that are
nearly or exactly incompressible carry a pressure p = -lambda div u of their own (Taylor and Hood 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.sparse import bmat, csr_matrix
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementTriP1,
    ElementTriP2,
    FacetBasis,
    LinearForm,
    MeshQuad,
    MeshTri,
)

from ..errors import Refusal
from ..materials import Elastic
from .grid import Grid

Array = np.ndarray
Side = Literal["free", "roller", "clamped"]
ELEMENTS = {
    ("triangle", 1): ElementTriP1,
    ("triangle", 2): ElementTriP2,
    ("quadrilateral", 1): ElementQuad1,
    ("quadrilateral", 2): ElementQuad2,
}
PRESSURE = {"triangle": ElementTriP1, "quadrilateral": ElementQuad1}


@BilinearForm
def stiffness_rr(u: Any, v: Any, w: Any) -> Array:
    """Energy of u_r with v_r: lambda div u div v + 2 mu (rr and hoop) + mu shear."""
    r, lam, mu = w.x[0], w["lam"], w["mu"]
    div_u, div_v = u.grad[0] + u / r, v.grad[0] + v / r
    normal = u.grad[0] * v.grad[0] + u * v / r**2
    return (lam * div_u * div_v + mu * (2 * normal + u.grad[1] * v.grad[1])) * 2 * np.pi * r


@BilinearForm
def stiffness_rz(u: Any, v: Any, w: Any) -> Array:
    """Energy of trial u_z with test v_r: lambda du_z/dz div v + mu du_z/dr dv_r/dz."""
    r, lam, mu = w.x[0], w["lam"], w["mu"]
    return (lam * u.grad[1] * (v.grad[0] + v / r) + mu * u.grad[0] * v.grad[1]) * 2 * np.pi * r


@BilinearForm
def stiffness_zz(u: Any, v: Any, w: Any) -> Array:
    """Energy of u_z with v_z: (lambda + 2 mu) zz + mu shear."""
    r, lam, mu = w.x[0], w["lam"], w["mu"]
    return ((lam + 2 * mu) * u.grad[1] * v.grad[1] + mu * u.grad[0] * v.grad[0]) * 2 * np.pi * r


@BilinearForm
def pressure_r(u: Any, q: Any, w: Any) -> Array:
    """-q (du_r/dr + u_r/r)."""
    return -q * (u.grad[0] + u / w.x[0]) * 2 * np.pi * w.x[0]


@BilinearForm
def pressure_z(u: Any, q: Any, w: Any) -> Array:
    """-q du_z/dz."""
    return -q * u.grad[1] * 2 * np.pi * w.x[0]


@BilinearForm
def pressure_mass(p: Any, q: Any, w: Any) -> Array:
    return p * q * 2 * np.pi * w.x[0]


@LinearForm
def ring_area(v: Any, w: Any) -> Array:
    return v * 2 * np.pi * w.x[0]


@dataclass(frozen=True, eq=False)
class ElasticSystem:
    """Stiffness ``K`` (all unknowns: u_r of N nodes, u_z of N nodes, pressures) and what the contact needs of it.

    ``nodes`` (N, 2) [m]; ``node_of``: the node each unknown sits on; ``free``: unknowns not held by the supports;
    ``surface``: nodes of the contact surface by increasing radius, ``radii`` [m], ``is_vertex``, ``areas``: integral
    of each node's shape function over the surface [m^2]; ``cell_centres`` (m, 2) [m]; ``basis``: the scalar basis of
    both components; ``mixed``: layers with a pressure unknown.
    """

    K: csr_matrix
    nodes: Array
    node_of: Array
    free: Array
    surface: Array
    radii: Array
    is_vertex: Array
    areas: Array
    cell_centres: Array
    basis: Basis
    mixed: tuple[int, ...]

    @property
    def normal(self) -> Array:
        """Unknowns u_z of the surface nodes."""
        return len(self.nodes) + self.surface

    @property
    def cell_nodes(self) -> Array:
        """Nodes of every cell (m, k)."""
        return self.basis.element_dofs.T

    @property
    def neighbours(self) -> Array:
        """Cells on both sides of every inner facet (2, f)."""
        both = self.basis.mesh.f2t
        return both[:, both[1] >= 0]

    @property
    def held(self) -> Array:
        """Unknowns that the supports hold."""
        return np.setdiff1d(np.arange(self.K.shape[0]), self.free)

    def reactions(self, solution: Array) -> Array:
        """Forces of the supports on the body, of all unknowns; zero where free (to round-off) [N]."""
        forces = np.zeros_like(solution)
        held = self.held
        forces[held] = (self.K @ solution)[held]
        return forces

    def side_load(self, traction: Callable[[Array, Array], Array]) -> Array:
        """Consistent nodal loads [N], shape (nodes,), of one component of a ``traction(r, z)`` [Pa] on the side."""

        @LinearForm
        def form(v: Any, w: Any) -> Array:
            return traction(w.x[0], w.x[1]) * v * 2 * np.pi * w.x[0]

        return form.assemble(FacetBasis(self.basis.mesh, self.basis.elem, facets="side", intorder=4))

    def vertical_reaction(self, solution: Array) -> float:
        """Upward force of the supports on the body [N]."""
        N = len(self.nodes)
        return float(self.reactions(solution)[N : 2 * N].sum())


def assemble(
    grid: Grid,
    materials: Sequence[Elastic],
    order: int,
    *,
    bonded: bool = True,
    side: Side = "free",
    mixed: Sequence[int] = (),
) -> ElasticSystem:
    """The elastic system of ``grid``; ``materials[i]`` belongs to layer i; ``mixed``: layers with a pressure unknown.

    The base is held (``bonded``) or slides (normal displacement held); the axis holds u_r.
    """
    basis = _basis(grid, order)
    K, pressure_nodes = _stiffness(basis, grid, materials, tuple(mixed), order)
    N = basis.N
    held = _held(basis, bonded, side)
    surface = basis.get_dofs("surface").all()
    surface = surface[np.argsort(basis.doflocs[0, surface], kind="stable")]
    top = FacetBasis(basis.mesh, basis.elem, facets="surface", intorder=2 * order + 1)
    return ElasticSystem(
        K=K,
        nodes=basis.doflocs.T.copy(),
        node_of=np.concatenate([np.arange(N), np.arange(N), pressure_nodes]),
        free=np.setdiff1d(np.arange(K.shape[0]), held),
        surface=surface,
        radii=basis.doflocs[0, surface],
        is_vertex=np.isin(surface, basis.nodal_dofs[0]),
        areas=ring_area.assemble(top)[surface],
        cell_centres=grid.points[grid.cells].mean(axis=1),
        basis=basis,
        mixed=tuple(mixed),
    )


def _basis(grid: Grid, order: int) -> Basis:
    """Scalar basis on the grid with its boundaries named."""
    kind = MeshTri if grid.element == "triangle" else MeshQuad
    mesh = kind(np.ascontiguousarray(grid.points.T), np.ascontiguousarray(grid.cells.T))
    n = len(grid.points)
    codes = mesh.facets.min(axis=0).astype(np.int64) * n + mesh.facets.max(axis=0)
    by_code = np.argsort(codes)

    def numbers(pairs: Array) -> Array:
        wanted = pairs.min(axis=1).astype(np.int64) * n + pairs.max(axis=1)
        return by_code[np.searchsorted(codes, wanted, sorter=by_code)]

    mesh = mesh.with_boundaries({name: numbers(pairs) for name, pairs in grid.boundaries.items()})
    return Basis(mesh, ELEMENTS[grid.element, order](), intorder=2 * order)


def _stiffness(
    basis: Basis, grid: Grid, materials: Sequence[Elastic], mixed: tuple[int, ...], order: int
) -> tuple[csr_matrix, Array]:
    """All blocks, and the nodes that the pressure unknowns sit on."""
    soft = [0.0 if i in mixed else material.lame for i, material in enumerate(materials)]
    if not np.isfinite(soft).all():
        raise Refusal("nu: 0.5 needs the mixed form (second-order elements), got the displacement form")
    lam = np.array(soft)[grid.materials][:, None]
    mu = np.array([material.G for material in materials])[grid.materials][:, None]
    rr, rz, zz = (form.assemble(basis, lam=lam, mu=mu) for form in (stiffness_rr, stiffness_rz, stiffness_zz))
    blocks = [[rr, rz], [rz.T, zz]]
    nodes: list[Array] = []
    for layer in mixed:
        B_r, B_z, M, at = _pressure_blocks(basis, grid, layer, order)
        inverse_lame = 1 / materials[layer].lame  # zero at nu = 1/2
        blocks[0].append(B_r.T)
        blocks[1].append(B_z.T)
        blocks.append([B_r, B_z, *([None] * len(nodes)), -inverse_lame * M])
        nodes.append(at)
    size = len(blocks)
    square = [row + [None] * (size - len(row)) for row in blocks]
    return bmat(square, format="csr"), np.concatenate([np.zeros(0, dtype=int), *nodes])


def _pressure_blocks(basis: Basis, grid: Grid, layer: int, order: int) -> tuple[Any, Any, Any, Array]:
    """Divergence blocks, mass and nodes of a linear pressure in one layer only: it may jump at interfaces."""
    inside = np.flatnonzero(grid.materials == layer)
    displacement = Basis(basis.mesh, basis.elem, elements=inside, intorder=2 * order)
    linear = Basis(basis.mesh, PRESSURE[grid.element](), elements=inside, intorder=2 * order)
    used = np.unique(linear.element_dofs)
    B_r, B_z = (form.assemble(displacement, linear)[used] for form in (pressure_r, pressure_z))
    M = pressure_mass.assemble(linear)[used][:, used]
    return B_r, B_z, M, basis.nodal_dofs[0][used]


def _held(basis: Basis, bonded: bool, side: Side) -> Array:
    """Unknowns that the supports hold at zero."""
    N = basis.N
    axis, base, rim = (basis.get_dofs(name).all() for name in ("axis", "base", "side"))
    held = [axis, N + base]
    if bonded:
        held.append(base)
    if side != "free":
        held.append(rim)
    if side == "clamped":
        held.append(N + rim)
    return np.unique(np.concatenate(held))

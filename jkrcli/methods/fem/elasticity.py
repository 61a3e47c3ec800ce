"""Axisymmetric linear elasticity on a grid (the door to scikit-fem).

With one scalar basis for both components, u = (u_r, u_z), strains rr: du_r/dr, tt: u_r/r, zz: du_z/dz,
rz: du_r/dz + du_z/dr, the stiffness has three blocks, each a scalar form with the weight 2 pi r, for the five constants
C11, C12, C13, C33, C44 of a transversely isotropic material; an isotropic one is the case C33 = C11 = lambda + 2 G,
C13 = C12 = lambda, C44 = G. Graded moduli are taken at the quadrature points. Layers that are nearly or exactly
incompressible carry a pressure p = -lambda div u of their own (Taylor and Hood 1973).
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

from ...base.errors import Refusal
from ...bodies.materials import Elastic, Graded, Material, TransverselyIsotropic
from .grid import Grid

Array = np.ndarray
Side = Literal["free", "roller", "clamped"]
ELEMENTS = {
    ("triangle", 1): ElementTriP1,
    ("triangle", 2): ElementTriP2,
    ("quadrilateral", 1): ElementQuad1,
    ("quadrilateral", 2): ElementQuad2,
}
GRADED_DEGREE = 2  # what the moduli of a graded layer add to the degree of the integrands
PRESSURE = {"triangle": ElementTriP1, "quadrilateral": ElementQuad1}


@BilinearForm
def stiffness_rr(u: Any, v: Any, w: Any) -> Array:
    """Energy of u_r with v_r: C11 (rr rr + tt tt) + C12 (rr tt + tt rr) + C44 rz rz."""
    r = w.x[0]
    same = u.grad[0] * v.grad[0] + u * v / r**2
    cross = (u.grad[0] * v + u * v.grad[0]) / r
    return (w["C11"] * same + w["C12"] * cross + w["C44"] * u.grad[1] * v.grad[1]) * 2 * np.pi * r


@BilinearForm
def stiffness_rz(u: Any, v: Any, w: Any) -> Array:
    """Energy of trial u_z with test v_r: C13 zz (rr + tt) + C44 rz rz."""
    r = w.x[0]
    return (w["C13"] * u.grad[1] * (v.grad[0] + v / r) + w["C44"] * u.grad[0] * v.grad[1]) * 2 * np.pi * r


@BilinearForm
def stiffness_zz(u: Any, v: Any, w: Any) -> Array:
    """Energy of u_z with v_z: C33 zz zz + C44 rz rz."""
    return (w["C33"] * u.grad[1] * v.grad[1] + w["C44"] * u.grad[0] * v.grad[0]) * 2 * np.pi * w.x[0]


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
    """p q/lambda."""
    return w["compressibility"] * p * q * 2 * np.pi * w.x[0]


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
    materials: Sequence[Material],
    order: int,
    *,
    bonded: bool = True,
    side: Side = "free",
    mixed: Sequence[int] = (),
) -> ElasticSystem:
    """The elastic system of ``grid``; ``materials[i]`` belongs to layer i; ``mixed``: layers with a pressure unknown.

    The base is held (``bonded``) or slides (normal displacement held); the axis holds u_r.
    """
    basis = _basis(grid, order, 2 * order + (GRADED_DEGREE if any(isinstance(m, Graded) for m in materials) else 0))
    K, pressure_nodes = _stiffness(basis, grid, materials, tuple(mixed))
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


def _basis(grid: Grid, order: int, degree: int) -> Basis:
    """Scalar basis on the grid with its boundaries named; quadrature exact for polynomials of ``degree``."""
    kind = MeshTri if grid.element == "triangle" else MeshQuad
    mesh = kind(np.ascontiguousarray(grid.points.T), np.ascontiguousarray(grid.cells.T))
    n = len(grid.points)
    codes = mesh.facets.min(axis=0).astype(np.int64) * n + mesh.facets.max(axis=0)
    by_code = np.argsort(codes)

    def numbers(pairs: Array) -> Array:
        wanted = pairs.min(axis=1).astype(np.int64) * n + pairs.max(axis=1)
        return by_code[np.searchsorted(codes, wanted, sorter=by_code)]

    mesh = mesh.with_boundaries({name: numbers(pairs) for name, pairs in grid.boundaries.items()})
    return Basis(mesh, ELEMENTS[grid.element, order](), intorder=degree)


def _stiffness(
    basis: Basis, grid: Grid, materials: Sequence[Material], mixed: tuple[int, ...]
) -> tuple[csr_matrix, Array]:
    """All blocks, and the nodes that the pressure unknowns sit on."""
    C = dict(zip(("C11", "C12", "C13", "C33", "C44"), _constants(basis, grid, materials, mixed), strict=True))
    rr, rz, zz = (form.assemble(basis, **C) for form in (stiffness_rr, stiffness_rz, stiffness_zz))
    blocks = [[rr, rz], [rz.T, zz]]
    nodes: list[Array] = []
    for layer in mixed:
        material = materials[layer]
        assert not isinstance(material, TransverselyIsotropic)  # always compressible
        B_r, B_z, M, at = _pressure_blocks(basis, grid, layer, material)
        blocks[0].append(B_r.T)
        blocks[1].append(B_z.T)
        blocks.append([B_r, B_z, *([None] * len(nodes)), -M])
        nodes.append(at)
    size = len(blocks)
    square = [row + [None] * (size - len(row)) for row in blocks]
    return bmat(square, format="csr"), np.concatenate([np.zeros(0, dtype=int), *nodes])


def _constants(basis: Basis, grid: Grid, materials: Sequence[Material], mixed: tuple[int, ...]) -> Array:
    """C11, C12, C13, C33, C44 [Pa] at the quadrature points of every cell, or one value per cell if none is graded;
    of a mixed layer the part without lambda."""
    points = basis.X.shape[1] if any(isinstance(material, Graded) for material in materials) else 1
    C = np.empty((5, len(grid.cells), points))
    for i, material in enumerate(materials):
        inside = np.flatnonzero(grid.materials == i)
        if isinstance(material, TransverselyIsotropic):
            C[:, inside] = np.array(material.stiffness)[:, None, None]
            continue
        unit = isotropic_constants(material.nu, i in mixed)
        C[:, inside] = unit[:, None, None] * _moduli(basis, grid, i, material)
    return C


def isotropic_constants(nu: float, mixed: bool) -> Array:
    """C11, C12, C13, C33, C44 of an isotropic material over its Young's modulus; ``mixed``: the part without lambda."""
    material = Elastic(1.0, nu)
    lame, G = 0.0 if mixed else material.lame, material.G
    if np.isinf(lame):
        raise Refusal("nu: 0.5 needs the mixed form (second-order elements), got the displacement form")
    return np.array([lame + 2 * G, lame, lame, lame + 2 * G, G])


def _moduli(basis: Basis, grid: Grid, layer: int, material: Elastic | Graded) -> Array:
    """Young's modulus [Pa] in the cells of a layer, at quadrature points (cells, points), or (1, 1) throughout."""
    if isinstance(material, Elastic):
        return np.full((1, 1), material.E)
    inside = np.flatnonzero(grid.materials == layer)
    top = grid.points[grid.cells[inside], 1].max()
    z = basis.mapping.F(basis.X, tind=inside)[1]
    return material.at(np.maximum(top - z, 0.0))


def _pressure_blocks(basis: Basis, grid: Grid, layer: int, material: Elastic | Graded) -> tuple[Any, Any, Any, Array]:
    """Divergence blocks, compressibility and nodes of a linear pressure in one layer: it may jump at interfaces."""
    inside = np.flatnonzero(grid.materials == layer)
    displacement, linear = (
        Basis(basis.mesh, element, elements=inside, quadrature=(basis.X, basis.W))
        for element in (basis.elem, PRESSURE[grid.element]())
    )
    used = np.unique(linear.element_dofs)
    B_r, B_z = (form.assemble(displacement, linear)[used] for form in (pressure_r, pressure_z))
    compressibility = 1 / (Elastic(1.0, material.nu).lame * _moduli(basis, grid, layer, material))  # zero at nu = 1/2
    M = pressure_mass.assemble(linear, compressibility=compressibility)[used][:, used]
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

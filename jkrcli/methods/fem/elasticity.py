"""Axisymmetric linear elasticity on a grid (the door to scikit-fem).

With one scalar basis for both components, u = (u_r, u_z), and the strains

    rr = du_r/dr,   tt = u_r/r,   zz = du_z/dz,   rz = du_r/dz + du_z/dr,

the stiffness has three blocks, each a scalar form with the weight 2 pi r, for the five constants C11, C12, C13, C33,
C44 of a transversely isotropic material; an isotropic one is the case C33 = C11 = lambda + 2 G, C13 = C12 = lambda,
C44 = G. Graded moduli are taken at the quadrature points. Layers that are nearly or exactly incompressible carry a
pressure p = -lambda div u of their own (Taylor and Hood 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import block_diag, bmat, csr_matrix

from ...base.errors import Refusal
from ...base.numerics import Array
from ...bodies.materials import (
    AnyGraded,
    AnyTransverse,
    Elastic,
    GradedTransverselyIsotropic,
    Material,
    TransverselyIsotropic,
)
from .mesh import Grid, MeshedBody, require, sides

try:
    import skfem
except ModuleNotFoundError:
    require("skfem")
    raise

ELEMENTS = {  # of first order, second, ...
    "triangle": (skfem.ElementTriP1, skfem.ElementTriP2, skfem.ElementTriP3, skfem.ElementTriP4),
    "quadrilateral": (skfem.ElementQuad1, skfem.ElementQuad2),
}
CENTRE = (np.array([[0.5], [0.5]]), np.array([1.0]))  # theory: the rule of one point on the unit square
HOURGLASS = 0.05  # share of the shear stiffness integrated in full; tuned on the cases of cases/paper, by `make paper`
GRADED_DEGREE = 2  # theory: what moduli that vary over an element add to the degree of the integrands


# ---------------------------------------------------------------------- weak forms
def ring(form: Callable[..., Any], kind: Any = skfem.BilinearForm) -> Any:
    """The form with the volume of a ring, 2 pi r dr dz, as its measure (on the surface the area 2 pi r dr)."""
    return kind(lambda *fields: form(*fields) * 2 * np.pi * fields[-1].x[0])


@ring
def stiffness_rr(u: Any, v: Any, w: Any) -> Any:
    """Elastic energy C11 (rr rr + tt tt) + C12 (rr tt + tt rr) + C44 rz rz, of u_r with v_r."""
    r = w.x[0]
    same = u.grad[0] * v.grad[0] + u * v / r**2
    cross = (u.grad[0] * v + u * v.grad[0]) / r
    return w["C11"] * same + w["C12"] * cross + w["C44"] * u.grad[1] * v.grad[1]


@ring
def stiffness_rz(u: Any, v: Any, w: Any) -> Any:
    """Elastic energy C13 zz (rr + tt) + C44 rz rz, of u_z with v_r."""
    return w["C13"] * u.grad[1] * (v.grad[0] + v / w.x[0]) + w["C44"] * u.grad[0] * v.grad[1]


@ring
def stiffness_zz(u: Any, v: Any, w: Any) -> Any:
    """Elastic energy C33 zz zz + C44 rz rz, of u_z with v_z."""
    return w["C33"] * u.grad[1] * v.grad[1] + w["C44"] * u.grad[0] * v.grad[0]


@ring
def pressure_r(u: Any, q: Any, w: Any) -> Any:
    """Work of a pressure, -q (rr + tt), in a radial u."""
    return -q * (u.grad[0] + u / w.x[0])


@ring
def pressure_z(u: Any, q: Any, w: Any) -> Any:
    """Work of a pressure, -q zz, in an axial u."""
    return -q * u.grad[1]


@ring
def pressure_mass(p: Any, q: Any, w: Any) -> Any:
    """Energy of a pressure, p q/lambda."""
    return w["compressibility"] * p * q


@ring
def mass(u: Any, v: Any, w: Any) -> Any:
    """Product u v."""
    return u * v


@skfem.LinearForm
def force_r(v: Any, w: Any) -> Any:
    """Virtual work sigma : eps(v) = s_rr rr + s_tt tt + s_rz rz of a radial v."""
    return (w["rr"] * v.grad[0] + w["rz"] * v.grad[1]) * 2 * np.pi * w.x[0] + w["tt"] * v * 2 * np.pi


@partial(ring, kind=skfem.LinearForm)
def force_z(v: Any, w: Any) -> Any:
    """Virtual work sigma : eps(v) = s_zz zz + s_rz rz of an axial v."""
    return w["zz"] * v.grad[1] + w["rz"] * v.grad[0]


@partial(ring, kind=skfem.LinearForm)
def measure(v: Any, w: Any) -> Any:
    """Integral of v: on the surface the area that belongs to each node."""
    return v


@ring
def membrane(u: Any, v: Any, w: Any) -> Any:
    """Stiffness u_z-u_z of a surface of the tension 1 N/m: its energy is half of the tension times (du_z/dr)^2."""
    return u.grad[0] * v.grad[0]


# ---------------------------------------------------------------------- the system
@dataclass(frozen=True, eq=False)
class ElasticSystem:
    """Stiffness ``K`` (all unknowns: u_r of N nodes, u_z of N nodes, pressures) and what the contact needs of it.

    ``grid`` and the ``materials`` of its layers; ``mixed``: layers with a pressure unknown; ``basis``: the scalar basis
    of both components; ``node_of``: the node each unknown sits on; ``free``: unknowns that the supports do not
    constrain; ``surface``: nodes of the contact surface by increasing radius, ``areas``: integral of each of their
    shape functions over the surface [m^2].
    """

    grid: Grid
    materials: Sequence[Material]
    mixed: tuple[int, ...]
    basis: skfem.Basis
    K: csr_matrix
    node_of: Array
    free: Array
    surface: Array
    areas: Array

    @property
    def nodes(self) -> Array:
        """Positions of the nodes (N, 2) [m]."""
        return self.basis.doflocs.T

    @property
    def radii(self) -> Array:
        """Radii of the nodes of the surface [m]."""
        return self.basis.doflocs[0, self.surface]

    @property
    def is_vertex(self) -> Array:
        """Which nodes of the surface are vertices of the mesh."""
        return np.isin(self.surface, self.basis.nodal_dofs[0])

    @property
    def normal(self) -> Array:
        """Unknowns u_z of the surface nodes."""
        return len(self.nodes) + self.surface

    def both(self, count: int) -> Array:
        """Unknowns u_z and, off the axis, u_r of the innermost ``count`` surface nodes, node by node."""
        pairs = np.column_stack([self.normal[:count], self.surface[:count]])
        return pairs[np.column_stack([np.ones(count, dtype=bool), self.radii[:count] > 0])]

    def components(self, solution: Array) -> tuple[Array, Array]:
        """u_r and u_z of all nodes, or the forces along them."""
        N = len(self.nodes)
        return solution[:N], solution[N : 2 * N]

    def reactions(self, solution: Array) -> Array:
        """Forces of the supports on the body, of all unknowns; zero where free [N]."""
        forces = self.K @ solution
        forces[self.free] = 0.0
        return forces

    def vertical_reaction(self, solution: Array) -> float:
        """Upward force of the supports on the body [N]."""
        return float(self.components(self.reactions(solution))[1].sum())

    def on_facets(self, facets: Array | str, degree: int) -> skfem.FacetBasis:
        """The basis on facets, or on a named side; quadrature exact for polynomials of ``degree``."""
        return skfem.FacetBasis(self.basis.mesh, self.basis.elem, facets=facets, intorder=degree)

    @property
    def order(self) -> int:
        """Degree of the polynomials along a side of a cell."""
        return ELEMENTS[self.grid.element].index(type(self.basis.elem)) + 1

    def in_layer(self, layer: int) -> skfem.Basis:
        """The basis on the cells of a layer."""
        return _restricted(self.basis, self.grid, layer, self.basis.elem)

    def at_corners(self, layer: int) -> skfem.Basis:
        """The basis on the cells of a layer at their vertices (cells, 3 or 4)."""
        corners = self.basis.mesh.elem.refdom.p
        points = (corners, np.full(corners.shape[1], 1.0))  # the weights are not used
        numbers = np.flatnonzero(self.grid.materials == layer)
        return skfem.Basis(self.basis.mesh, self.basis.elem, elements=numbers, quadrature=points)

    def side_load(self, traction: Callable[[Array, Array], Array]) -> Array:
        """Consistent nodal loads [N], shape (nodes,), of one component of a ``traction(r, z)`` [Pa] on the side."""
        return ring(lambda v, w: traction(*w.x) * v, skfem.LinearForm).assemble(self.on_facets("side", 2 * self.order))

    def pressure(self, solution: Array, layer: int, basis: skfem.Basis) -> Array | float:
        """The pressure unknown [Pa] of a layer at the points of ``basis``; 0 where it has none."""
        if layer not in self.mixed:
            return 0.0
        lower = basis.with_element(_of_pressure(self.basis, self.grid))
        used = [np.unique(lower.dofs.element_dofs[:, self.grid.materials == i]) for i in self.mixed]
        k = self.mixed.index(layer)
        first = 2 * len(self.nodes) + sum(own.size for own in used[:k])
        values = np.zeros(lower.N)
        values[used[k]] = solution[first : first + used[k].size]
        return np.asarray(lower.interpolate(values))


def assemble(
    grid: Grid, body: MeshedBody, order: int, mixed: Sequence[int] = (), reduced: bool = False
) -> ElasticSystem:
    """Assemble the elastic system of the ``grid`` of a ``body``; ``mixed``: layers with a pressure unknown;
    ``reduced``: integrate linear quadrilaterals at their centres.

    The base is fixed (``bonded``) or slides (normal displacement fixed); u_r is 0 on the axis. The tension is that of
    the whole surface.
    """
    materials = body.materials
    # Scalar basis on the grid with its boundaries named; quadrature exact for polynomials of `degree`.
    kind = skfem.MeshTri if grid.element == "triangle" else skfem.MeshQuad
    mesh = kind(np.ascontiguousarray(grid.points.T), np.ascontiguousarray(grid.cells.T))
    middles = mesh.p[:, mesh.facets].mean(axis=1)
    named = sides(middles.T, grid.width, grid.depth)
    mesh = mesh.with_boundaries({name: np.flatnonzero(on_side) for name, on_side in named.items()})
    basis = skfem.Basis(
        mesh,
        ELEMENTS[grid.element][order - 1](),
        intorder=2 * order + (GRADED_DEGREE if any(isinstance(m, AnyGraded) for m in materials) else 0),
    )
    if reduced:
        # Stiffness of linear quadrilaterals by one Gauss point each, with hourglass control.
        centre = skfem.Basis(basis.mesh, basis.elem, quadrature=CENTRE)
        at_centre, in_full = (_constants(b, grid, materials, ()) for b in (centre, basis))
        shear = HOURGLASS * np.array([2.0, 0.0, 0.0, 2.0, 1.0])[:, None, None]
        terms = [(centre, at_centre - shear * at_centre[4]), (basis, shear * in_full[4])]
        K, pressure_nodes = sum(_displacement_blocks(b, C) for b, C in terms), np.zeros(0, dtype=int)
    else:
        K, pressure_nodes = _stiffness(basis, grid, materials, tuple(mixed))
    surface = basis.get_dofs("surface").all()
    surface = surface[np.argsort(basis.doflocs[0, surface], kind="stable")]
    rule = {"quadrature": (np.array([[0.5]]), np.array([1.0]))} if reduced else {"intorder": 2 * order + 1}
    top = skfem.FacetBasis(basis.mesh, basis.elem, facets="surface", **rule)
    if body.tension:
        N, rest = basis.N, K.shape[0] - 2 * basis.N
        K = K + block_diag([csr_matrix((N, N)), body.tension * membrane.assemble(top), csr_matrix((rest, rest))], "csr")
    node_of = np.concatenate([np.arange(basis.N), np.arange(basis.N), pressure_nodes])
    # Unknowns that the supports constrain to zero
    N = basis.N
    axis, base, rim = (basis.get_dofs(name).all() for name in ("axis", "base", "side"))
    held = {"free": [], "roller": [rim], "clamped": [rim, N + rim]}[body.side]
    constrained = np.unique(np.concatenate([axis, N + base, *([base] if body.bonded else []), *held]))
    free = np.setdiff1d(np.arange(K.shape[0]), constrained)
    areas = measure.assemble(top)[surface]
    return ElasticSystem(grid, materials, tuple(mixed), basis, K, node_of, free, surface, areas)


def _of_pressure(basis: skfem.Basis, grid: Grid) -> Any:
    """Element of the pressure, one order below that of the displacements."""
    kinds = ELEMENTS[grid.element]
    return kinds[kinds.index(type(basis.elem)) - 1]()


def _restricted(basis: skfem.Basis, grid: Grid, layer: int, element: Any) -> skfem.Basis:
    """Basis of the ``element`` on the cells of a layer, with the same quadrature."""
    numbers = np.flatnonzero(grid.materials == layer)
    return skfem.Basis(basis.mesh, element, elements=numbers, quadrature=(basis.X, basis.W))


def _stiffness(
    basis: skfem.Basis, grid: Grid, materials: Sequence[Material], mixed: tuple[int, ...]
) -> tuple[csr_matrix, Array]:
    """All blocks, and the nodes that the pressure unknowns sit on."""
    K = _displacement_blocks(basis, _constants(basis, grid, materials, mixed))
    if not mixed:
        return K, np.zeros(0, dtype=int)
    pressures = [_pressure_blocks(basis, grid, layer, materials[layer]) for layer in mixed]
    coupling = [bmat([[B_r, B_z]], format="csr") for B_r, B_z, *_ in pressures]
    blocks = [[K, *(B.T for B in coupling)]]
    for k, (B, (_, _, M, _)) in enumerate(zip(coupling, pressures, strict=True)):
        blocks.append([B, *(-M if i == k else None for i in range(len(mixed)))])
    return bmat(blocks, format="csr"), np.concatenate([np.zeros(0, dtype=int), *(nodes for *_, nodes in pressures)])


def _displacement_blocks(basis: skfem.Basis, constants: Array) -> csr_matrix:
    """Stiffness between the displacements for C11, C12, C13, C33, C44 at the quadrature points of every cell."""
    C = dict(zip(("C11", "C12", "C13", "C33", "C44"), constants, strict=True))
    rr, rz, zz = (form.assemble(basis, **C) for form in (stiffness_rr, stiffness_rz, stiffness_zz))
    return bmat([[rr, rz], [rz.T, zz]], format="csr")


def _pressure_blocks(basis: skfem.Basis, grid: Grid, layer: int, material: Material) -> tuple[Any, Any, Any, Array]:
    """Divergence blocks, compressibility and nodes of the pressure in one layer: it may jump at interfaces."""
    assert not isinstance(material, AnyTransverse)  # always compressible
    displacement, lower = (_restricted(basis, grid, layer, e) for e in (basis.elem, _of_pressure(basis, grid)))
    used = np.unique(lower.element_dofs)
    B_r, B_z = (form.assemble(displacement, lower)[used] for form in (pressure_r, pressure_z))
    moduli = material.at(_depths(basis, grid, layer, material))
    compressibility = 1 / (Elastic(1.0, material.nu).lame * moduli)  # zero at nu = 1/2
    M = pressure_mass.assemble(lower, compressibility=compressibility)[used][:, used]
    nodes = np.empty(lower.N, dtype=int)  # of the same vertex, side or cell
    for name in ("nodal_dofs", "facet_dofs", "interior_dofs"):
        if (own := getattr(lower, name)).size:
            nodes[own] = getattr(basis, name)[:1]
    return B_r, B_z, M, nodes[used]


def _constants(basis: skfem.Basis, grid: Grid, materials: Sequence[Material], mixed: tuple[int, ...]) -> Array:
    """C11, C12, C13, C33, C44 [Pa] at the quadrature points of every cell, or one value per cell if none is graded."""
    points = basis.X.shape[1] if any(isinstance(material, AnyGraded) for material in materials) else 1
    C = np.empty((5, len(grid.cells), points))
    for i, material in enumerate(materials):
        C[:, grid.materials == i] = stiffness_constants(material, i in mixed, _depths(basis, grid, i, material))
    return C


def _depths(basis: skfem.Basis, grid: Grid, layer: int, material: Material) -> Array:
    """Depths below the top of the layer [m] at the quadrature points of its cells, or one for all if homogeneous."""
    if not isinstance(material, AnyGraded):
        return np.zeros((1, 1))
    return grid.depth_below_top(layer, basis.mapping.F(basis.X, tind=np.flatnonzero(grid.materials == layer))[1])


def stiffness_constants(material: Material, mixed: bool, depth: Array) -> Array:
    """C11, C12, C13, C33, C44 [Pa], shape (5, ...), at every ``depth`` [m] below the top of its layer; ``mixed``: the
    part without lambda."""
    if isinstance(material, TransverselyIsotropic):
        return np.array(material.stiffness).reshape(5, *[1] * depth.ndim)
    if isinstance(material, GradedTransverselyIsotropic):
        return material.stiffness_at(depth)
    unit = Elastic(1.0, material.nu)
    lame, G = 0.0 if mixed else unit.lame, unit.G
    if np.isinf(lame):
        raise Refusal("nu: 0.5 needs the mixed form (second-order elements), got the displacement form")
    return np.multiply.outer([lame + 2 * G, lame, lame, lame + 2 * G, G], material.at(depth))

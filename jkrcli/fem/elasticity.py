"""Axisymmetric linear elasticity on a grid (the door to scikit-fem), factorised and condensed onto the surface.

With one scalar basis for both components, u = (u_r, u_z), and the strains

    rr = du_r/dr,   tt = u_r/r,   zz = du_z/dz,   rz = du_r/dz + du_z/dr,

the stiffness has three blocks, each a scalar form with the weight 2 pi r, for the five constants C11, C12, C13, C33,
C44 of a transversely isotropic material; an isotropic one is the case C33 = C11 = lambda + 2 G, C13 = C12 = lambda,
C44 = G. Graded moduli are taken at the quadrature points. Layers that are nearly or exactly incompressible carry a
pressure p = -lambda div u of their own (Taylor and Hood 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.linalg import cho_solve
from scipy.sparse import block_diag, bmat, csc_matrix, csr_matrix, tril
from scipy.sparse.linalg import splu

from .. import formulas
from ..base.errors import InputError, Refusal, SolveError, installs
from ..base.numerics import RESIDUAL_LIMIT, Array
from ..base.process import one_thread
from ..bodies.problem import AnyGraded, Elastic, GradedTransverselyIsotropic, Material, TransverselyIsotropic
from .mesh import Grid, MeshedBody, require, sides
from .options import Solver

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

    def at_places(self, layer: int, places: Array) -> skfem.Basis:
        """The basis on the cells of a layer at the same ``places`` (2, n) of the reference cell in each."""
        numbers = np.flatnonzero(self.grid.materials == layer)
        rule = (places, np.ones(places.shape[1]))  # the weights are not used
        return skfem.Basis(self.basis.mesh, self.basis.elem, elements=numbers, quadrature=rule)

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
    """The blocks of the stiffness, and the nodes of the pressure unknowns."""
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
    assert not isinstance(material, TransverselyIsotropic | GradedTransverselyIsotropic)  # always compressible
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


# --------------------------------------------------------------------------------------------------
# Sparse factors of symmetric matrices that keep the order they are given, and that order (the door to CHOLMOD).
#
# SciPy's SuperLU factorises everything; CHOLMOD, where the optional package cvxopt is installed, positive definite
# matrices several times faster (Chen et al., ACM Trans. Math. Softw. 35 (2008) 22). Kept in order, the trailing block
# of either factor is the Cholesky factor of the matrix condensed onto its last unknowns. The order is nested
# dissection of the mesh (George, SIAM J. Numer. Anal. 10 (1973) 345): every group of cells is split at its median
# along one of a few directions, whichever cuts the fewest facets, until the groups are small; all groups of a level
# at once. The nodes between two halves are eliminated after both.

# Sizes on which the time of a solve depends, not its result.
FACTOR_SMALL = 20_000  # unknowns; CHOLMOD gains less than its import costs; tuned on its cases, by `make bench`
FACTOR_LEAF = 6  # cells; smaller groups gain nothing; tuned on the cases of `make bench`, by `make bench`


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
    pays = solver == "cholmod" or (solver == "auto" and matrix.shape[0] > FACTOR_SMALL)
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
    # Path of every cell in the tree of halves, as a binary number with one digit per level
    m = len(centres)
    r, z = centres.T
    # split along them, along both diagonals, and in the polar coordinates of meshes that are graded towards the origin
    along = r, z, r + z, r - z, np.hypot(r, z), np.arctan2(z, r)
    by_axis = [np.argsort(values, kind="stable") for values in along]
    code = np.zeros(m, dtype=np.int64)
    groups = 1
    while m > FACTOR_LEAF * groups:
        code = 2 * code + _halves(code, groups, by_axis, neighbours)
        groups *= 2
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


# --------------------------------------------------------------------------------------------------
# The contact surface of an elastic body: one factorisation, condensed onto the candidate contact nodes.
#
# The displacements of the candidate nodes along which the contact acts are eliminated last. The trailing block of the
# one sparse factor is then the Cholesky factor of the body's stiffness condensed onto them, and its inverse the
# surface compliance: no right-hand sides are needed.


@dataclass(frozen=True, eq=False)
class StiffnessFactor:
    """Factorised stiffness of the free unknowns in the ``order`` of their elimination, the ``last`` of them those that
    the contact acts on. The first ``displacements`` of all unknowns are displacements [m], the others pressures [Pa].
    """

    factor: SparseFactor
    order: Array
    last: Array
    stiffness: csr_matrix
    displacements: int

    def loads(self, forces: Array) -> Array:
        """Loads of all unknowns [N] from ``forces`` on the ``last`` ones."""
        loads = np.zeros(self.stiffness.shape[0])
        loads[self.last] = forces
        return loads

    def solve(self, loads: Array) -> Array:
        """Displacements (and pressures) of all unknowns for nodal ``loads`` (n,); zero where constrained."""
        solution = np.zeros_like(loads)
        with one_thread():
            solution[self.order] = self.factor.solve(loads[self.order])
        return solution

    def compliance(self) -> Array:
        """Displacements of the ``last`` unknowns under unit forces on them [m/N], (n, n)."""
        inverse = cho_solve((self.factor.root, True), np.eye(self.last.size))
        return (inverse + inverse.T) / 2

    def residual(self, solution: Array, loads: Array) -> float:
        """Largest relative imbalance of the free unknowns: of the forces against the ``loads``, of the volumes that
        belong to pressures against what the largest of all displacements could make (they do not share a unit).

        Their own terms are no measure: where a layer is fixed on all sides they are nothing but round-off.
        """
        left = np.abs(self.stiffness @ solution - loads)
        is_force = self.order < self.displacements
        imbalance = float(left[self.order[is_force]].max() / np.abs(loads).max())
        volumes = self.order[~is_force]
        if not volumes.size:
            return imbalance
        largest = np.abs(solution)
        largest[: self.displacements] = largest[: self.displacements].max()
        terms = abs(self.stiffness[volumes]) @ largest
        return max(imbalance, float(left[volumes].max() / terms.max()))


@dataclass(frozen=True, eq=False)
class Surface:
    """The contact surface as the contact problem sees it: n candidate nodes by increasing radius.

    ``C`` (m, m): displacement i under a unit force along displacement j [m/N], symmetric. Of sliding surfaces these are
    the downward displacements of the nodes, m = n; of surfaces that stick the downward and the outward displacement of
    each node in turn (downward alone on the axis). ``radii``, ``is_vertex``, ``areas`` [m, -, m^2] of the candidates;
    ``exempt``: number of leading nodes whose force may have any sign (the axis node of second-order elements: the
    integral of its shape function is zero). ``residual``, ``asymmetry``: what the check solves left, relative.
    """

    C: Array
    radii: Array
    is_vertex: Array
    areas: Array
    exempt: int
    residual: float
    asymmetry: float

    @property
    def sticks(self) -> bool:
        """Whether radial displacements are among the m."""
        return len(self.C) > self.radii.size

    @property
    def normal(self) -> Array:
        """Rows of C that are downward displacements (n,)."""
        if not self.sticks:
            return np.arange(self.radii.size)
        return np.cumsum(np.where(self.radii > 0, 2, 1)) - np.where(self.radii > 0, 2, 1)

    @property
    def last(self) -> Array:
        """Last row of C of each node (n,)."""
        return np.append(self.normal[1:], len(self.C)) - 1

    @property
    def direction(self) -> Array:
        """Sense of each of the m displacements along its coordinate: downwards -1, outwards 1."""
        signs = np.ones(len(self.C))
        signs[self.normal] = -1.0
        return signs

    def shifted(self, w: float) -> Surface:
        """The surface with a uniform downward displacement ``w`` [m] per unit downward force added."""
        if not self.sticks:
            return replace(self, C=self.C + w)
        C = self.C.copy()
        C[np.ix_(self.normal, self.normal)] += w
        return replace(self, C=C)


def factorise(system: ElasticSystem, last: Array, solver: Solver = "auto") -> StiffnessFactor:
    """Factorise with the unknowns ``last`` at the end, in their order."""
    facets, centres = system.basis.mesh.f2t, system.grid.points[system.grid.cells].mean(axis=1)
    rank = nested_dissection(system.basis.element_dofs.T, centres, facets[:, facets[1] >= 0])
    inner = np.setdiff1d(system.free, last)
    # Rank of every unknown: its node's; a pressure follows all displacements it couples to (no zero pivots).
    ranks = 2 * rank[system.node_of]
    displacements = 2 * len(system.nodes)
    if ranks.size > displacements:
        latest = np.zeros_like(rank)
        nodes = system.basis.element_dofs
        np.maximum.at(latest, nodes, np.broadcast_to(rank[nodes].max(axis=0), nodes.shape))
        ranks[displacements:] = 2 * latest[system.node_of[displacements:]] + 1
    order = np.concatenate([inner[np.argsort(ranks[inner], kind="stable")], last])
    factor = sparse_factor(system.K[order][:, order].tocsc(), last.size, not system.mixed, solver)
    return StiffnessFactor(factor, order, last, system.K, 2 * len(system.nodes))


def condense(system: ElasticSystem, factor: StiffnessFactor) -> Surface:
    """Surface whose contact forces act on the displacements that the ``factor`` has last; checked by full solves."""
    n = np.unique(system.node_of[factor.last]).size
    C = factor.compliance()
    # Residual of full solves for unit forces on the innermost and outermost candidate, and their distance to the
    # columns of C
    residuals, distances = [], []
    for j in {0, len(C) - 1}:
        loads = factor.loads(np.eye(len(C))[j])
        solution = factor.solve(loads)
        residuals.append(factor.residual(solution, loads))
        distances.append(np.abs(solution[factor.last] - C[:, j]).max() / np.abs(C[:, j]).max())
    if not max(residuals) < RESIDUAL_LIMIT:
        raise SolveError(
            f"factorisation: residual {max(residuals):.1e} of the check solves, allowed {RESIDUAL_LIMIT:g}: moduli or "
            "sizes differ by too much for elements; use method layered or hybrid, or leave out what is far softer, "
            "stiffer or thinner than all else"
        )
    residual, asymmetry = max(residuals), float(max(distances))
    radii, areas = system.radii[:n], system.areas[:n]
    exempt = int(radii[0] == 0 and abs(areas[0]) < 1e-6 * abs(areas[1]))
    surface = Surface(C, radii, system.is_vertex[:n], areas, exempt, residual, asymmetry)
    return replace(surface, C=C * np.outer(surface.direction, surface.direction)) if surface.sticks else surface


# --------------------------------------------------------------------------------------------------
# What cutting a half-space at finite depth and width changes: an estimate by Betti's theorem.
#
# Far from the contact the half-space carries the field of a point force: Boussinesq's (Johnson 1985, Sec. 3.2), or
# that of a transversely isotropic material. The cut body holds its base still and leaves its side free instead. With
# u the cut body's field under a unit load, the missing displacement of the contact is
#
#     w = -sum(base reactions . u_point) + int_side t_point . u dA,
#
# to leading order in contact radius over the body's size; at equal depth the load is then off by S w, relatively.

# theory: equal roots, as of an isotropic material, are taken this far apart; the field changes by the square of it
EQUAL_ROOTS = 1e-4


def missing_displacement(system: ElasticSystem, material: Elastic | TransverselyIsotropic, solution: Array) -> float:
    """Displacement of the contact that the cut body lacks, per unit load [m/N]; ``solution``: its field under a unit
    load near the origin, pressing down."""
    force = point_force(material)
    reactions_r, reactions_z = system.components(system.reactions(solution))
    u_r, u_z = system.components(solution)
    at_side = system.side_load(lambda r, z: force.side_traction(r, z)[0]) @ u_r
    at_side += system.side_load(lambda r, z: force.side_traction(r, z)[1]) @ u_z
    r, z = system.nodes.T
    supported = np.flatnonzero((r > 0) & (np.hypot(r, z) > 0.5 * min(r.max(), -z.min())))
    u_r, u_z = force.displacement(r[supported], z[supported])
    at_base = reactions_r[supported] @ u_r + reactions_z[supported] @ u_z
    axis = np.flatnonzero((r == 0) & (z < 0))
    at_base += reactions_z[axis] @ force.displacement(r[axis], z[axis])[1]
    return float(-at_base + at_side)


@dataclass(frozen=True)
class Boussinesq:
    """Field of a unit force that presses down on an isotropic half-space z <= 0 at the origin.

    Johnson (1985), Sec. 3.2.
    """

    material: Elastic

    def displacement(self, r: Array, z: Array) -> tuple[Array, Array]:
        """u_r, u_z [m/N], u_z upwards."""
        u_r, u_z = formulas.point_force(r, -z, self.material.E, self.material.nu)
        return u_r, -u_z

    def side_traction(self, r: Array, z: Array) -> tuple[Array, Array]:
        """sigma_rr, sigma_rz [1/m^2]: the traction on a cylinder r = const, outward normal, z upwards."""
        nu, depth = self.material.nu, -z
        rho = np.hypot(r, depth)
        s_rr = ((1 - 2 * nu) / (rho * (rho + depth)) - 3 * r**2 * depth / rho**5) / (2 * np.pi)
        return s_rr, 3 * r * depth**2 / rho**5 / (2 * np.pi)


@dataclass(frozen=True)
class TransversePointForce:
    """Field of a unit force that presses down on a transversely isotropic half-space z <= 0 at the origin.

    Elliott (1949), Hanson (J. Appl. Mech. 1992). In Hankel space the displacements are sums of exp(-s_j k z), z
    downwards, with the two roots s_j, Re s_j > 0, of

        C33 C44 s^4 - (C11 C33 - C13^2 - 2 C13 C44) s^2 + C11 C44 = 0,

    real or conjugate, and u_z/u_r = m_j = (C13 + C44) s_j/(C33 s_j^2 - C44). No shear at the surface and the unit force
    fix the two factors; int exp(-k z) J0(kr) dk = 1/sqrt(r^2 + z^2) and its derivatives do the rest.
    """

    material: TransverselyIsotropic

    def _terms(self, r: Array, z: Array) -> tuple[Array, ...]:
        """Roots s_j [-], ratios m_j [-] and factors c_j [1/Pa] of both terms, then the depth s_j z downwards and the
        distance from the force that each sees at ``r`` and ``z`` [m], (2, ...)."""
        C11, _, C13, C33, C44 = self.material.stiffness
        middle = (C11 * C33 - C13**2 - 2 * C13 * C44) / (2 * C33 * C44)
        apart = np.sqrt(complex(middle**2 - C11 / C33))
        if abs(apart) < EQUAL_ROOTS * middle:
            apart = complex(EQUAL_ROOTS * middle)
        s = np.sqrt(np.array([middle + apart, middle - apart]))
        m = (C13 + C44) * s / (C33 * s**2 - C44)
        c = np.linalg.solve(np.array([s + m, C13 - C33 * m * s]), np.array([0.0, -1 / (2 * np.pi)]))
        s, m, c = (each.reshape(2, *[1] * np.ndim(r)) for each in (s, m, c))
        return s, m, c, -s * z, np.sqrt(r**2 + (s * z) ** 2)

    def displacement(self, r: Array, z: Array) -> tuple[Array, Array]:
        """u_r, u_z [m/N], u_z upwards."""
        _, m, c, deep, rho = self._terms(r, z)
        return np.sum(c * r / (rho * (rho + deep)), axis=0).real, -np.sum(c * m / rho, axis=0).real

    def side_traction(self, r: Array, z: Array) -> tuple[Array, Array]:
        """sigma_rr, sigma_rz [1/m^2]: the traction on a cylinder r = const, outward normal, z upwards."""
        (C11, C12, C13, _, C44), (s, m, c, deep, rho) = self.material.stiffness, self._terms(r, z)
        s_rr = c * ((C11 * s - C13 * m * s**2) * -z / rho**3 - (C11 - C12) / (rho * (rho + deep)))
        return np.sum(s_rr, axis=0).real, np.sum(C44 * c * (s + m) * r / rho**3, axis=0).real


def point_force(material: Elastic | TransverselyIsotropic) -> Boussinesq | TransversePointForce:
    """Field of a unit force on a half-space of ``material``."""
    return TransversePointForce(material) if isinstance(material, TransverselyIsotropic) else Boussinesq(material)

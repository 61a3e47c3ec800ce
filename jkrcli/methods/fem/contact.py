"""Unilateral contact on the condensed surface: nested (all contact radii at once, sliding or sticking) and by
increments (sliding).

Nodal forces p >= 0, gaps f - delta + C p >= 0, and one of the two zero at every node, with f the indenter's
profile at the nodes and C the surface compliance; but for round-off, of the largest force and of the depth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.sparse import csc_matrix, csr_matrix, tril
from scipy.sparse.linalg import splu

from ...base.errors import InputError, SolveError, installs
from ...base.numerics import MOST_STEPS, RESIDUAL_LIMIT, ROUNDED, Array
from ...base.process import one_thread
from ..protocol import Solver
from .elasticity import ElasticSystem

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
    while m > FACTOR_LEAF * groups:
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

    @cached_property
    def normal(self) -> Array:
        """Rows of C that are downward displacements (n,)."""
        if not self.sticks:
            return np.arange(self.radii.size)
        return np.cumsum(np.where(self.radii > 0, 2, 1)) - np.where(self.radii > 0, 2, 1)

    @cached_property
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
    residual, asymmetry = _check(factor, C)
    radii, areas = system.radii[:n], system.areas[:n]
    exempt = int(radii[0] == 0 and abs(areas[0]) < 1e-6 * abs(areas[1]))
    surface = Surface(C, radii, system.is_vertex[:n], areas, exempt, residual, asymmetry)
    return replace(surface, C=C * np.outer(surface.direction, surface.direction)) if surface.sticks else surface


def _check(factor: StiffnessFactor, C: Array) -> tuple[float, float]:
    """Residual of full solves for unit forces on the innermost and outermost candidate, and their distance to the
    columns of C."""
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
    return max(residuals), float(max(distances))


@dataclass(frozen=True, eq=False)
class SurfaceContact:
    """The contact problem on ``surface`` for profile heights ``f`` [m] at its nodes.

    With C = L L^T, y = L^-1 e, e of a unit displacement downwards, and z = L^-1 f, the leading block k of L serves the
    contact set {0..k}: running sums give the stiffness S_k of that set, the depth delta_k at which node k just touches
    with zero force, and the load there, P_k = S_k delta_k - T_k. Where surfaces stick, a node has two rows: it is
    touched with the first of them, and the set has both.
    """

    surface: Surface
    f: Array

    @cached_property
    def L(self) -> Array:
        return cholesky(self.surface.C, lower=True)

    @cached_property
    def _solved(self) -> Array:
        return solve_triangular(self.L, np.column_stack([np.ones_like(self.f), self.f]), lower=True).T

    @property
    def y(self) -> Array:
        return self._solved[0]

    @property
    def z(self) -> Array:
        return self._solved[1]

    @cached_property
    def S(self) -> Array:
        """Stiffness dP/d(delta) of the contact sets {0..k} [N/m]."""
        return np.cumsum(self.y**2)[self.surface.last]

    @cached_property
    def T(self) -> Array:
        """Load that the profile takes off: P = S delta - T for the contact set {0..k} [N]."""
        return np.cumsum(self.y * self.z)[self.surface.last]

    @cached_property
    def delta(self) -> Array:
        """Depth at which node k touches with zero force, all nodes inside it in contact [m]."""
        return (self.z / self.y)[self.surface.normal]

    @cached_property
    def P(self) -> Array:
        """Load at that depth [N]."""
        S, T = np.cumsum([self.y**2, self.y * self.z], axis=1)[:, self.surface.normal]
        return S * self.delta - T

    def pressed(self, last: Array, depth: Array) -> tuple[Array, Array]:
        """Halves L^T p and forces p (m, sets) [N] of the rows {0..last} pressed to ``depth`` [m]."""
        inside = np.arange(len(self.surface.C))[:, None] <= last
        halves = np.where(inside, depth * self.y[:, None] - self.z[:, None], 0.0)
        return halves, solve_triangular(self.L, halves, lower=True, trans="T")

    def set_at(self, depth: Array) -> Array:
        """Last node k of the disc that touches at ``depth`` [m]."""
        touched = np.searchsorted(np.maximum.accumulate(self.delta), depth, side="right")
        return np.clip(touched - 1, 0, self.f.size - 1)


@dataclass(frozen=True, eq=False)
class StuckContact(SurfaceContact):
    """The contact problem on a ``surface`` whose points keep the radial displacement with which they were touched.

    As for sliding surfaces, with two rows of L for each node: z = L^-1 (f, -g) in turn, g the outward displacements. A
    node is touched where its normal force does not act yet, which gives delta_k = z_k/y_k from its first row. Would it
    stick at that very moment, its second row were z = delta_k y instead of g: the disc that grows node by node while
    stuck discs are pressed down, P = int S d(delta). But then the edge of the shear would not be that of the pressure.
    Both are where the ``rows`` (n, 2, 2) tell them to be (``edge_rows``), and z makes up for it to the second order of
    the spacing. ``flat``: radius of the flat end [m].
    """

    rows: Array
    flat: float = 0.0

    @cached_property
    def y(self) -> Array:
        e = np.zeros(len(self.surface.C))
        e[self.surface.normal] = 1.0
        return solve_triangular(self.L, e, lower=True)

    @cached_property
    def _ramps(self) -> Array:
        """What the rows of each node read of a field that begins to act there (n, 2) [m times y]."""
        y = self.y[np.column_stack([self.surface.normal, self.surface.last])]
        return np.einsum("nij,nj->ni", self.rows[: len(y)], y)

    @cached_property
    def edges(self) -> Array:
        """Radius of the edge of the contact when each node touches (n,) [m]."""
        return self.surface.radii + self._ramps[:, 0] / self.y[self.surface.normal]

    @cached_property
    def z(self) -> Array:
        y, z, delta = self.y, np.zeros_like(self.y), np.zeros_like(self.f)
        lag = self._ramps[:, 1] - self._ramps[:, 0] * y[self.surface.last] / y[self.surface.normal]
        for k, (row, last) in enumerate(zip(self.surface.normal, self.surface.last, strict=True)):
            z[row] = (self.f[k] - self.L[row, :row] @ z[:row]) / self.L[row, row]
            delta[k] = z[row] / y[row]
            if last > row:
                # d(delta)/da at node k, by a power law through it and the last node of its kind; first a parabola
                j = k - int(np.flatnonzero(self.surface.is_vertex)[1])
                width, before = self.surface.radii[[k, j]] - self.flat
                if not delta[k] > 0 < width:
                    slope = 0.0
                else:
                    power = 2.0
                    if j > 0 and before > 0 < delta[j]:
                        power = math.log(delta[k] / delta[j]) / math.log(width / before)
                    slope = float(power * delta[k] / width)
                z[last] = delta[k] * y[last] + slope * lag[k]
        return z


@dataclass(frozen=True, eq=False)
class Events:
    """First touches of the vertices, of increasing radius: ``a``, ``delta``, ``P``, and ``S``, the stiffness from here
    to the next node's touch (it belongs to a radius beyond ``a``). ``violation``: largest negative force or gap of
    all events, relative; ``p`` (events, m): forces on the ``surface`` [N]."""

    a: Array
    delta: Array
    P: Array
    S: Array
    p: Array
    violation: float

    @property
    def valid(self) -> bool:
        """Whether the contact is a disc that only grows, so that these are solutions of the contact problem."""
        return self.violation <= ROUNDED and bool((np.diff(self.delta) > 0).all())

    def quantity(self, name: str) -> Array:
        """The column of a loading's quantity: "depth", "load" or "radius"."""
        return {"depth": self.delta, "load": self.P, "radius": self.a}[name]

    @property
    def rising(self) -> Events:
        """Events at a larger depth and load than all before: all, where the contact is a disc that only grows."""
        first = np.zeros(1)
        rises = [x > np.maximum.accumulate(np.append(first, x[:-1])) for x in (self.delta, self.P)]
        both = np.logical_and(*rises)
        return replace(self, **{name: getattr(self, name)[both] for name in ("a", "delta", "P", "S", "p")})


def nested_events(contact: SurfaceContact, a0: float, to: str, maximum: float, spare: int = 0) -> Events:
    """Nested contact: all contact radii of a growing disc from one factor, whose leading blocks serve one radius each.

    The events at the vertices beyond the flat radius ``a0`` up to the first one at which the quantity ``to`` ("depth",
    "load" or "radius") reaches ``maximum`` [m or N], and up to ``spare`` more that hold as well; up to the last
    candidate where none does.
    """
    surface = contact.surface
    k = np.flatnonzero(surface.is_vertex & (surface.radii > a0 * (1 + ROUNDED)) & (contact.delta > 0))
    quantity = {"depth": contact.delta, "load": contact.P, "radius": surface.radii}[to][k]
    beyond = np.flatnonzero(quantity >= maximum * (1 - ROUNDED))
    needed = int(beyond[0]) + 1 if beyond.size else k.size
    k = k[: needed + spare]
    depth = contact.delta[k]
    # Forces (m, events) [N] when these nodes touch, and the largest negative force or gap of each event, relative to
    # the largest force or the depth
    touching = surface.normal[k]
    inside = np.arange(len(surface.C))[:, None] <= touching
    w, forces = contact.pressed(touching, depth)
    p = forces[surface.normal]
    gap = contact.f[:, None] - depth + (contact.L @ w)[surface.normal]
    pull = np.max(-p[surface.exempt :] / np.abs(p).max(axis=0, initial=0.0), axis=0, initial=0.0)
    negative = np.maximum(pull, np.max(np.where(inside[surface.normal], 0.0, -gap) / depth, axis=0, initial=0.0))
    sound = (negative[needed:] <= ROUNDED) & (np.diff(depth)[max(needed - 1, 0) :] > 0)
    n = needed + int(np.cumprod(sound).sum())
    violation = float(np.max(negative[:n], initial=0.0))
    return Events(surface.radii[k[:n]], depth[:n], contact.P[k[:n]], contact.S[k[:n]], forces.T[:n], violation)


@dataclass(frozen=True, eq=False)
class Increment:
    """One solved increment: depth ``delta`` [m], load ``P`` [N], nodal forces ``p`` (n,) [N], the ``active`` nodes,
    and the relative violation of the three conditions."""

    delta: float
    P: float
    p: Array
    active: Array
    violation: float

    @property
    def is_disc(self) -> bool:
        """Whether the nodes in contact are the innermost ones."""
        return bool(self.active[: int(self.active.sum())].all())


def solve_depths(contact: SurfaceContact, depths: Sequence[float] | Array) -> list[Increment]:
    """Increments at prescribed depths [m], each started from the contact nodes of the one before."""
    active = np.zeros(contact.f.size, dtype=bool)
    increments = []
    for depth in depths:
        increments.append(_increment(contact, float(depth), active))
        active = increments[-1].active
    return increments


def solve_loads(contact: SurfaceContact, loads: Sequence[float] | Array) -> list[Increment]:
    """Increments at prescribed loads [N]: P(delta) is piecewise linear and convex, so Newton's method ends exactly."""
    active = np.zeros(contact.f.size, dtype=bool)
    increments: list[Increment] = []
    delta = 0.0
    for load in loads:
        for _ in range(MOST_STEPS):
            active = active if active.any() else contact.f <= contact.f[0]
            y = _on(contact, active, np.ones(int(active.sum())))
            z = _on(contact, active, contact.f[active])
            delta = (load + float(z.sum())) / float(y.sum())
            step = _increment(contact, delta, active)
            if abs(step.P - load) <= ROUNDED * load:
                break
            active = step.active
        else:
            steps = MOST_STEPS
            raise SolveError(f"contact: the load {load:g} N was not reached after {steps} steps (at {step.P:g} N)")
        increments.append(step)
    return increments


def _on(contact: SurfaceContact, active: Array, values: Array) -> Array:
    """Forces on the ``active`` nodes that give them the displacements ``values``: C_AA^-1 values."""
    n = int(active.sum())
    L = contact.L[:n, :n] if active[:n].all() else cholesky(contact.surface.C[np.ix_(active, active)], lower=True)
    half = solve_triangular(L, values, lower=True, check_finite=False)
    return solve_triangular(L, half, lower=True, trans="T", check_finite=False)


def _increment(contact: SurfaceContact, delta: float, active: Array) -> Increment:
    """Newton's method on the set of active nodes (Hintermueller, Ito and Kunisch 2002)."""
    exempt = contact.surface.exempt
    active = active.copy()
    for _ in range(MOST_STEPS):
        p, gap = _state(contact, delta, active)
        force_limit = ROUNDED * np.abs(p).max()
        wanted = np.where(active, p >= -force_limit, gap < -ROUNDED * delta)
        wanted[:exempt] |= wanted.any()
        if np.array_equal(wanted, active):
            return _checked(contact, delta, p, gap, active)
        active = wanted
    # Active set by another way: the forces p >= 0 minimise |L^T p - L^-1 (delta - f)| (Lawson and Hanson 1974, Ch.
    # 23); those of `exempt` nodes are differences of two.
    exempt, n = contact.surface.exempt, contact.f.size
    matrix = np.column_stack([contact.L.T, -contact.L.T[:, :exempt]])
    try:
        p, _ = nnls(matrix, solve_triangular(contact.L, delta - contact.f, lower=True))
    except RuntimeError:
        raise SolveError(f"contact: no active set found at depth {delta:g} m") from None
    active = (p[:n] > 0) | ((np.arange(n) < exempt) & p.any())
    return _checked(contact, delta, *_state(contact, delta, active), active)


def _state(contact: SurfaceContact, delta: float, active: Array) -> tuple[Array, Array]:
    """Forces with the ``active`` nodes in contact, and the gaps of all nodes, round-off where they touch."""
    p = np.zeros_like(contact.f)
    if active.any():
        p[active] = _on(contact, active, delta - contact.f[active])
    return p, contact.f - delta + contact.surface.C[:, active] @ p[active]


def _checked(contact: SurfaceContact, delta: float, p: Array, gap: Array, active: Array) -> Increment:
    largest = float(np.abs(p).max())
    negative_force = float(np.max(-p[contact.surface.exempt :], initial=0.0)) / largest if largest else 0.0
    violation = max(negative_force, float(np.where(active, np.abs(gap), -gap).max(initial=0.0)) / delta)
    if violation > 10 * ROUNDED:
        raise SolveError(f"contact: conditions violated by {violation:.1e} (relative) at depth {delta:g} m")
    return Increment(delta, float(p.sum()), p, active, violation)

"""The contact surface of an elastic body: one factorisation, condensed onto the candidate contact nodes.

The displacements of the candidate nodes along which the contact acts are eliminated last. The trailing block of the one
sparse factor is then the Cholesky factor of the body's stiffness condensed onto them, and its inverse the surface
compliance: no right-hand sides are needed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve
from scipy.sparse import csr_matrix

from ...base import RESIDUAL_LIMIT, Array, SolveError, one_thread
from .elasticity import ElasticSystem
from .factor import SparseFactor, nested_dissection, sparse_factor
from .options import Solver


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
    order = np.concatenate([inner[np.argsort(_unknown_ranks(system, rank)[inner], kind="stable")], last])
    factor = sparse_factor(system.K[order][:, order].tocsc(), last.size, not system.mixed, solver)
    return StiffnessFactor(factor, order, last, system.K, 2 * len(system.nodes))


def _unknown_ranks(system: ElasticSystem, rank: Array) -> Array:
    """Rank of every unknown: its node's; a pressure follows all displacements it couples to (no zero pivots)."""
    ranks = 2 * rank[system.node_of]
    displacements = 2 * len(system.nodes)
    if ranks.size > displacements:
        latest = np.zeros_like(rank)
        nodes = system.basis.element_dofs
        np.maximum.at(latest, nodes, np.broadcast_to(rank[nodes].max(axis=0), nodes.shape))
        ranks[displacements:] = 2 * latest[system.node_of[displacements:]] + 1
    return ranks


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

"""From the elastic body to its contact surface: one factorisation, condensed onto the candidate contact nodes.

The normal displacements of the candidate nodes are eliminated last. The trailing block of the one sparse factor is
then the Cholesky factor of the body's stiffness condensed onto them, and its inverse the surface compliance: no
right-hand sides are needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve
from scipy.sparse import csr_matrix

from ...base.errors import SolveError
from .elasticity import ElasticSystem
from .factor import SparseFactor, sparse_factor
from .options import Solver
from .ordering import nested_dissection

Array = np.ndarray
RESIDUAL_LIMIT = 1e-8  # relative; a sound factor leaves 1e-16 to 1e-12
PROBES = 2


@dataclass(frozen=True, eq=False)
class Factor:
    """Factorised stiffness of the free unknowns; the last ``tail`` of ``order`` are the candidates' normal ones.

    The first ``displacements`` of all unknowns are displacements [m], the others pressures [Pa].
    """

    factor: SparseFactor
    order: Array
    tail: int
    stiffness: csr_matrix
    displacements: int

    def solve(self, loads: Array) -> Array:
        """Displacements (and pressures) of all unknowns for nodal ``loads`` (n,); zero where held."""
        solution = np.zeros_like(loads)
        solution[self.order] = self.factor.solve(loads[self.order])
        return solution

    def residual(self, solution: Array, loads: Array) -> float:
        """Largest relative imbalance of the free unknowns: of the forces against the ``loads``, of the volumes that
        belong to pressures against what the largest of all displacements could make (they do not share a unit).

        Their own terms are no measure: where a layer is held on all sides they are nothing but round-off.
        """
        left = np.abs(self.stiffness @ solution - loads)
        forces, volumes = (
            self.order[part] for part in (self.order < self.displacements, self.order >= self.displacements)
        )
        imbalance = float(left[forces].max() / np.abs(loads).max())
        if not volumes.size:
            return imbalance
        largest = np.abs(solution)
        largest[: self.displacements] = largest[: self.displacements].max()
        terms = abs(self.stiffness[volumes]) @ largest
        return max(imbalance, float(left[volumes].max() / terms.max()))


@dataclass(frozen=True, eq=False)
class Surface:
    """The contact surface as the contact problem sees it: n candidate nodes by increasing radius.

    ``C`` (n, n): downward displacement of node i under a unit downward force on node j [m/N], symmetric.
    ``radii``, ``is_vertex``, ``areas`` [m, -, m^2] of the candidates; ``exempt``: number of leading nodes whose force
    may have any sign (the axis node of second-order elements: the integral of its shape function is zero).
    ``residual``, ``asymmetry``: what the check solves left, relative.
    """

    C: Array
    radii: Array
    is_vertex: Array
    areas: Array
    exempt: int
    residual: float
    asymmetry: float


def factorise(system: ElasticSystem, candidates: int, solver: Solver = "auto") -> Factor:
    """Factorise with the normal unknowns of the innermost ``candidates`` surface nodes last."""
    last = system.normal[:candidates]
    rank = nested_dissection(system.cell_nodes, system.cell_centres, system.neighbours)
    inner = np.setdiff1d(system.free, last)
    order = np.concatenate([inner[np.argsort(_unknown_ranks(system, rank)[inner], kind="stable")], last])
    matrix = system.K[order][:, order].tocsc()
    factor = sparse_factor(matrix, candidates, not system.mixed, solver)
    return Factor(factor, order, candidates, system.K, 2 * len(system.nodes))


def _unknown_ranks(system: ElasticSystem, rank: Array) -> Array:
    """Rank of every unknown: its node's; a pressure follows all displacements it couples to (no zero pivots)."""
    ranks = 2 * rank[system.node_of]
    displacements = 2 * len(system.nodes)
    if ranks.size > displacements:
        latest = np.zeros_like(rank)
        in_cell = np.broadcast_to(rank[system.cell_nodes].max(axis=1)[:, None], system.cell_nodes.shape)
        np.maximum.at(latest, system.cell_nodes, in_cell)
        ranks[displacements:] = 2 * latest[system.node_of[displacements:]] + 1
    return ranks


def condense(system: ElasticSystem, factor: Factor) -> Surface:
    """Surface compliance of the candidates, checked by full solves."""
    n = factor.tail
    inverse = cho_solve((factor.factor.root, True), np.eye(n))
    C = (inverse + inverse.T) / 2
    residual, asymmetry = _check(system, factor, C)
    radii, areas = system.radii[:n], system.areas[:n]
    exempt = int(radii[0] == 0 and abs(areas[0]) < 1e-6 * abs(areas[1]))
    return Surface(C, radii, system.is_vertex[:n], areas, exempt, residual, asymmetry)


def _check(system: ElasticSystem, factor: Factor, C: Array) -> tuple[float, float]:
    """Residual of full solves for unit forces on a few candidates, and their distance to the columns of C."""
    n = factor.tail
    residuals, distances = [], []
    for j in np.unique(np.linspace(0, n - 1, PROBES).astype(int)):
        loads = np.zeros(system.K.shape[0])
        loads[system.normal[j]] = -1.0
        solution = factor.solve(loads)
        residuals.append(factor.residual(solution, loads))
        distances.append(np.abs(solution[system.normal[:n]] + C[:, j]).max() / np.abs(C[:, j]).max())
    if not max(residuals) < RESIDUAL_LIMIT:
        raise SolveError(
            f"factorisation: residual {max(residuals):.1e} of the check solves, allowed {RESIDUAL_LIMIT:g}"
        )
    return max(residuals), float(max(distances))

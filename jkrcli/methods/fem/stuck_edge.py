"""What a mesh makes of the edge of a stuck contact, known from a half-space with the same surface vertices.

The rows of L for a node read the field next to the edge of the disc that ends there: with the densities xi of a stuck
disc (``integral.stuck``), whose value at the edge is the amplitude of its singular fields, the halves in both rows of
the node at r are

    y delta - z = M xi(r) + N xi'(r)

up to the second order of the spacing, M and N (2, 2) of the mesh and its uppermost material alone. On the half-space
xi is known in closed form where its surface is displaced by 1, r^2 downwards or r, r^3 outwards. The transform of a
ring's tractions gives the work that they do on such a displacement: with the coefficients C_n, Q_n of rho^n in C, Q,

    xi(r) = (2/pi) (C_0, -4 C_2 r^2, 2 Q_1 r, -16 Q_3 r^3).

A contact that grows has xi = 0 at its edge a, and xi(r) = xi_1 (delta - delta_H(r)) where a disc of radius r would have
xi_1 under a unit displacement: with y = M xi_1, and ramps N xi_1,

    z = delta_H(r) y + delta_H'(r) N xi_1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from scipy.linalg import cholesky, solve_triangular

from ...base import Array
from ...bodies import Material
from ..integral import ring_transforms
from ..integral.coulomb import coulomb_series
from ..layered.stuck import half_space_compliances
from .surface import Surface


@dataclass(frozen=True)
class EdgeTuning:
    """Node spacings over the radius between which meshes tell where the edge is."""

    # theory: a tenth of a spacing is then half the error of the half-space's own mesh, 1e-4 of the radius
    resolved: float = 5e-4
    # Next to the edge the field of a compressible body oscillates with eta times the logarithm of the distance. Where
    # that is turned too far nodes fall out of step. choice: logarithm of where the turn begins, and the turn; on bonded
    # layers of nu = -0.5, -0.8, -0.95 nodes do below spacings of 0.045, 0.1, 0.16
    phase: tuple[float, float] = (3.8, 1.7)


TUNING = EdgeTuning()


def finest_spacing(material: Material) -> float:
    """Least spacing of surface vertices over the radius that follows a contact that sticks to the ``material``."""
    eta = abs(_oscillation(material)[1])
    start, turn = TUNING.phase
    return math.exp(start - turn / eta) if eta else 0.0


def _oscillation(material: Material) -> tuple[float, float]:
    """Dundurs's constant of the material under a rigid indenter, and the oscillation index."""
    zz, zr, rr = half_space_compliances(material)
    beta = zr / math.sqrt(zz * rr)
    return beta, math.atanh(beta) / math.pi


@dataclass(frozen=True, eq=False)
class EdgeRows:
    """``reading`` (n, 2, 2) [m]: N M^-1 of each node, which makes ramps of y; zero on the axis, and where nodes are so
    close that it does not matter."""

    reading: Array

    @classmethod
    def of(cls, surface: Surface, material: Material) -> EdgeRows:
        """Those of the ``surface`` of a half-space of the ``material``."""
        beyond = surface.radii > 0
        r, rows = surface.radii[beyond], np.column_stack([surface.normal, surface.last])[beyond]
        displaced = np.zeros((len(surface.C), 4))
        displaced[surface.normal, :2] = surface.radii[:, None] ** [0, 2]
        displaced[rows[:, 1], 2:] = r[:, None] ** [1, 3]
        halves = solve_triangular(cholesky(surface.C, lower=True), displaced, lower=True)[rows]
        xi, slope = _densities(material, r)
        unit, profile = [0, 2], [1, 3]
        edge = np.linalg.solve(xi[..., unit], xi[..., profile])  # displacements that take profiles' xi off at r
        M = _over(halves[..., unit], xi[..., unit])
        N = _over(halves[..., unit] @ edge - halves[..., profile], slope[..., unit] @ edge - slope[..., profile])
        reading = np.zeros((surface.radii.size, 2, 2))
        close = np.gradient(surface.radii)[beyond] < TUNING.resolved * r
        reading[beyond] = np.where(close[:, None, None], 0.0, _over(N, M))
        return cls(reading)

    def ramps(self, y: Array) -> Array:
        """N xi_1 (n, 2) from the rows ``y`` (n, 2) of discs under a unit displacement, of the innermost n nodes."""
        return np.einsum("nij,nj->ni", self.reading[: len(y)], y)


def _densities(material: Material, r: Array) -> tuple[Array, Array]:
    """xi pi/2 (n, 2, 4) at ``r`` (n,) for the displacements 1, r^2 downwards and r, r^3 outwards, and its slope."""
    beta, eta = _oscillation(material)
    zz, _, rr = half_space_compliances(material)
    waves = [(F[:4], polynomial.polyder(F)[:4]) for F in (coulomb_series(-eta), coulomb_series(eta))]
    C, Q = (np.array(pair) for pair in ring_transforms(beta, *waves))
    outward = math.sqrt(zz / rr)
    factors = np.column_stack([C[:, 0], -4 * C[:, 2], 2 * outward * Q[:, 1], -16 * outward * Q[:, 3]])
    powers = np.array([0, 2, 1, 3])
    return factors * r[:, None, None] ** powers, factors * powers * r[:, None, None] ** np.maximum(powers - 1, 0)


def _over(A: Array, B: Array) -> Array:
    """A B^-1 of the pairs of matrices (n, 2, 2)."""
    return np.swapaxes(np.linalg.solve(np.swapaxes(B, 1, 2), np.swapaxes(A, 1, 2)), 1, 2)

"""What cutting a half-space at finite depth and width changes: an estimate by Betti's theorem.

Far from the contact the half-space carries the field of a point force: Boussinesq's (Johnson 1985, Sec. 3.2), or that
of a transversely isotropic material. The cut body holds its base still and leaves its side free instead. With u the cut
body's field under a unit load, the missing displacement of the contact is

    w = -sum(base reactions . u_point) + int_side t_point . u dA,

to leading order in contact radius over the body's size; at equal depth the load is then off by S w, relatively.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base import Array
from ...bodies import Elastic, TransverselyIsotropic
from ...formulas import boussinesq
from .elasticity import ElasticSystem

# theory: equal roots, as of an isotropic material, are taken this far apart; the field changes by the square of it
EQUAL_ROOTS = 1e-4


def missing_displacement(system: ElasticSystem, material: Elastic | TransverselyIsotropic, solution: Array) -> float:
    """Displacement of the contact that the cut body lacks, per unit load [m/N]; ``solution``: its field under a unit
    load near the origin, pressing down."""
    force = point_force(material)
    reactions_r, reactions_z = system.components(system.reactions(solution))
    r, z = system.nodes.T
    supported = np.flatnonzero((r > 0) & (np.hypot(r, z) > 0.5 * min(r.max(), -z.min())))
    u_r, u_z = force.displacement(r[supported], z[supported])
    at_base = reactions_r[supported] @ u_r + reactions_z[supported] @ u_z
    axis = np.flatnonzero((r == 0) & (z < 0))
    at_base += reactions_z[axis] @ force.displacement(r[axis], z[axis])[1]
    u_r, u_z = system.components(solution)
    at_side = system.side_load(lambda r, z: force.side_traction(r, z)[0]) @ u_r
    at_side += system.side_load(lambda r, z: force.side_traction(r, z)[1]) @ u_z
    return float(-at_base + at_side)


@dataclass(frozen=True)
class Boussinesq:
    """Field of a unit force that presses down on an isotropic half-space z <= 0 at the origin.

    Johnson (1985), Sec. 3.2.
    """

    material: Elastic

    def displacement(self, r: Array, z: Array) -> tuple[Array, Array]:
        """u_r, u_z [m/N], u_z upwards."""
        u_r, u_z = boussinesq.point_force(r, -z, self.material.E, self.material.nu)
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

    @cached_property
    def _terms(self) -> list[tuple[complex, complex, complex]]:
        """Roots s_j [-], ratios m_j [-] and the factor c_j [1/Pa] of both terms."""
        C11, _, C13, C33, C44 = self.material.stiffness
        middle = (C11 * C33 - C13**2 - 2 * C13 * C44) / (2 * C33 * C44)
        apart = np.sqrt(complex(middle**2 - C11 / C33))
        if abs(apart) < EQUAL_ROOTS * middle:
            apart = complex(EQUAL_ROOTS * middle)
        s = np.sqrt(np.array([middle + apart, middle - apart]))
        m = (C13 + C44) * s / (C33 * s**2 - C44)
        c = np.linalg.solve(np.array([s + m, C13 - C33 * m * s]), np.array([0.0, -1 / (2 * np.pi)]))
        return list(zip(s, m, c, strict=True))

    def displacement(self, r: Array, z: Array) -> tuple[Array, Array]:
        """u_r, u_z [m/N], u_z upwards."""
        along_r, along_z = np.zeros(np.shape(r), complex), np.zeros(np.shape(r), complex)
        for s, m, c in self._terms:
            deep, rho = -s * z, np.sqrt(r**2 + (s * z) ** 2)
            along_r += c * r / (rho * (rho + deep))
            along_z -= c * m / rho
        return along_r.real, along_z.real

    def side_traction(self, r: Array, z: Array) -> tuple[Array, Array]:
        """sigma_rr, sigma_rz [1/m^2]: the traction on a cylinder r = const, outward normal, z upwards."""
        C11, C12, C13, _, C44 = self.material.stiffness
        s_rr, s_rz = np.zeros(np.shape(r), complex), np.zeros(np.shape(r), complex)
        for s, m, c in self._terms:
            deep, rho = -s * z, np.sqrt(r**2 + (s * z) ** 2)
            s_rr += c * ((C11 * s - C13 * m * s**2) * -z / rho**3 - (C11 - C12) / (rho * (rho + deep)))
            s_rz += C44 * c * (s + m) * r / rho**3
        return s_rr.real, s_rz.real


def point_force(material: Elastic | TransverselyIsotropic) -> Boussinesq | TransversePointForce:
    """Field of a unit force on a half-space of ``material``."""
    return TransversePointForce(material) if isinstance(material, TransverselyIsotropic) else Boussinesq(material)

"""The field of a unit force that presses on a transversely isotropic half-space.

Elliott (1949), Hanson (J. Appl. Mech. 1992). In Hankel space the displacements are sums of exp(-s_j k z), z downwards,
with the two roots s_j, Re s_j > 0, of

    C33 C44 s^4 - (C11 C33 - C13^2 - 2 C13 C44) s^2 + C11 C44 = 0,

real or conjugate, and u_z/u_r = m_j = (C13 + C44) s_j/(C33 s_j^2 - C44). No shear at the surface and the unit force
fix the two factors; int exp(-k z) J0(kr) dk = 1/sqrt(r^2 + z^2) and its derivatives do the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...bodies.materials import TransverselyIsotropic

Array = np.ndarray
EQUAL = 1e-4  # roots closer than this, as those of an isotropic material, are taken this far apart


@dataclass(frozen=True)
class PointForce:
    """At the origin of the half-space z <= 0, pressing down."""

    material: TransverselyIsotropic

    @cached_property
    def _terms(self) -> list[tuple[complex, complex, complex]]:
        """s_j [-], m_j [-] and the factor c_j [1/Pa] of both terms."""
        C11, _, C13, C33, C44 = self.material.stiffness
        middle = (C11 * C33 - C13**2 - 2 * C13 * C44) / (2 * C33 * C44)
        apart = np.sqrt(complex(middle**2 - C11 / C33))
        if abs(apart) < EQUAL * middle:
            apart = complex(EQUAL * middle)
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

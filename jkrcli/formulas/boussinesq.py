"""A force on the surface of an isotropic elastic half-space (Boussinesq; Johnson 1985, Sec. 3.2)."""

from __future__ import annotations

import numpy as np

from ..base import Array


def point_force(r: Array, z: Array, E: float, nu: float) -> tuple[Array, Array]:
    """Displacements u_r, u_z [m/N] at the radius ``r`` and the depth ``z`` [m] under a unit force at the origin, u_z as
    the force into the half-space of the modulus ``E`` [Pa]."""
    rho = np.hypot(r, z)
    factor = (1 + nu) / (2 * np.pi * E * rho)
    return factor * (r * z / rho**2 - (1 - 2 * nu) * r / (rho + z)), factor * (z**2 / rho**2 + 2 * (1 - nu))

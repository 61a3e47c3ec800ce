"""What cutting a half-space at finite depth and width changes: an estimate by Betti's theorem.

Far from the contact the half-space carries the field of a point force (Boussinesq; Johnson 1985, Sec. 3.2). The cut
body holds its base still and leaves its side free instead. With u the cut body's field under a unit load, the missing
displacement of the contact is
    w = -sum(base reactions . u_Boussinesq) + int_side t_Boussinesq . u dA,
to leading order in contact radius over the body's size; at equal depth the load is then off by S w, relatively.
"""

from __future__ import annotations

import numpy as np

from ...bodies.materials import Elastic, TransverselyIsotropic
from .elasticity import ElasticSystem
from .point_force import PointForce

Array = np.ndarray
HalfSpaceMaterial = Elastic | TransverselyIsotropic


def missing_displacement(system: ElasticSystem, material: HalfSpaceMaterial, solution: Array, load: float) -> float:
    """Displacement of the contact that the cut body lacks, per unit load [m/N]; ``solution``: its field under ``load``
    [N] near the origin, pressing down."""
    N = len(system.nodes)
    forces = system.reactions(solution)
    rim = np.flatnonzero(system.nodes[:, 0] > 0)
    r, z = system.nodes[rim].T
    outer = np.hypot(r, z) > 0.5 * min(system.nodes[:, 0].max(), -system.nodes[:, 1].min())
    rim, r, z = rim[outer], r[outer], z[outer]
    u_r, u_z = boussinesq_displacement(r, z, material)
    at_base = forces[rim] @ u_r + forces[N + rim] @ u_z
    axis = np.flatnonzero((system.nodes[:, 0] == 0) & (system.nodes[:, 1] < 0))
    on_axis = boussinesq_displacement(system.nodes[axis, 0], system.nodes[axis, 1], material)[1]
    at_base += forces[N + axis] @ on_axis
    return float((-at_base + _side_work(system, material, solution)) / load)


def boussinesq_displacement(r: Array, z: Array, material: HalfSpaceMaterial) -> tuple[Array, Array]:
    """u_r, u_z [m/N] of a half-space z <= 0 under a unit force pressing down at the origin."""
    if isinstance(material, TransverselyIsotropic):
        return PointForce(material).displacement(r, z)
    nu, depth = material.nu, -z
    rho = np.hypot(r, depth)
    factor = 1 / (4 * np.pi * material.G * rho)
    u_r = factor * (r * depth / rho**2 - (1 - 2 * nu) * r / (rho + depth))
    return u_r, -factor * (depth**2 / rho**2 + 2 * (1 - nu))


def boussinesq_side_traction(r: Array, z: Array, material: HalfSpaceMaterial) -> tuple[Array, Array]:
    """sigma_rr, sigma_rz [1/m^2] of the same field: the traction on a cylinder r = const, outward normal."""
    if isinstance(material, TransverselyIsotropic):
        return PointForce(material).side_traction(r, z)
    nu, depth = material.nu, -z
    rho = np.hypot(r, depth)
    s_rr = ((1 - 2 * nu) / (rho * (rho + depth)) - 3 * r**2 * depth / rho**5) / (2 * np.pi)
    return s_rr, 3 * r * depth**2 / rho**5 / (2 * np.pi)


def _side_work(system: ElasticSystem, material: HalfSpaceMaterial, solution: Array) -> float:
    """Work of the point force's traction on the side in the displacement of ``solution``."""
    N = len(system.nodes)
    along_r = system.side_load(lambda r, z: boussinesq_side_traction(r, z, material)[0])
    along_z = system.side_load(lambda r, z: boussinesq_side_traction(r, z, material)[1])
    return float(along_r @ solution[:N] + along_z @ solution[N : 2 * N])

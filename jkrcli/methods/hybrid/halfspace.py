"""The field of a half-space under the pressures of the contact equation, in closed form.

The pressure with the Hankel transform p_hat(k) = (E*/2) cos(k t) has, with z downwards, zeta = z + i t and
rho = sqrt(r^2 + zeta^2), Re rho > 0, a field of elementary functions, as int_0^inf e^(-k zeta) J0(k r) dk = 1/rho.
All lengths are in one unit, all stresses in units of E of the half-space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base import Array


@dataclass(frozen=True, eq=False)
class RingField:
    """Fields of a half-space, one per parameter t: arrays of shape (t.size, points).

    ``u_r, u_z`` [1/length]; stresses ``s_rr, s_tt, s_zz, s_rz`` and the pressure ``p`` = -lambda div u, finite at
    nu = 1/2 too [E/length^2]. ``u_z`` and z point into the half-space.
    """

    u_r: Array
    u_z: Array
    s_rr: Array
    s_tt: Array
    s_zz: Array
    s_rz: Array
    p: Array
    nu: float

    @classmethod
    def at(cls, r: Array, z: Array, t: Array, nu: float) -> RingField:
        """The fields of the parameters ``t`` at the points (``r``, ``z``) of equal shape, away from r = t, z = 0."""
        zeta = z + 1j * t[:, None]
        rho = np.sqrt(r**2 + zeta**2)
        cube = 1 / rho**3
        sheared = z * cube / rho**2
        narrow = (1 - 2 * nu) / (rho * (rho + zeta))
        loaded, twisted = (zeta * cube).real, ((2 * zeta**2 - r**2) * sheared).real
        half = 0.5 / (1 - nu**2)  # E*/2
        s_zz = -half * (loaded + twisted)
        s_rr = -half * (loaded - twisted + (z * cube - narrow).real)
        return cls(
            u_r=-0.5 / (1 - nu) * r * (narrow - z * cube).real,
            u_z=0.5 / (1 - nu) * (2 * (1 - nu) / rho + z * zeta * cube).real,
            s_rr=s_rr,
            s_tt=-4 * half * (1 + nu) / 2 * loaded - s_rr - s_zz,
            s_zz=s_zz,
            s_rz=-half * (3 * r * zeta * sheared).real,
            p=2 * nu * half * loaded,
            nu=nu,
        )

    @property
    def strains(self) -> tuple[Array, Array, Array, Array]:
        """Strains rr, tt, zz and 2 rz [1/length^2], by Hooke's law for E = 1."""
        nu = self.nu
        shear = 0.5 / (1 + nu)
        trace = nu / (1 + nu) * (self.s_rr + self.s_tt + self.s_zz)
        rr, tt, zz = ((s - trace) / (2 * shear) for s in (self.s_rr, self.s_tt, self.s_zz))
        return rr, tt, zz, self.s_rz / shear

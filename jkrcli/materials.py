"""Linear elastic materials."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .errors import InputError


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elastic material: Young's modulus ``E`` [Pa] and Poisson's ratio ``nu`` in (-1, 1/2]."""

    E: float
    nu: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.E) and self.E > 0):
            raise InputError(f"E: must be > 0 Pa, got {self.E:g}")
        if not -1 < self.nu <= 0.5:
            raise InputError(f"nu: must be > -1 and <= 0.5, got {self.nu:g}")

    @property
    def E_star(self) -> float:
        """Plane-strain (contact) modulus E/(1 - nu^2) [Pa]."""
        return self.E / (1 - self.nu**2)

    @property
    def G(self) -> float:
        """Shear modulus [Pa]."""
        return self.E / (2 * (1 + self.nu))

    @property
    def lame(self) -> float:
        """First Lamé constant [Pa]; infinite at nu = 1/2."""
        if self.nu == 0.5:
            return math.inf
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))

    def scaled(self, factor: float) -> Elastic:
        """The same material with its modulus multiplied by ``factor``."""
        return Elastic(self.E * factor, self.nu)


def contact_modulus(first: Elastic, second: Elastic | None = None) -> float:
    """Reduced modulus E* of two bodies in contact [Pa] (Eq. 4); ``second = None`` is a rigid body."""
    if second is None:
        return first.E_star
    return 1 / (1 / first.E_star + 1 / second.E_star)

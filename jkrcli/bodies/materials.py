"""Linear elastic materials: homogeneous and isotropic, graded over depth, transversely isotropic.

Each has ``surface``, the isotropic half-space that the first touch of its top feels, ``scaled`` and ``words``;
``Elastic`` and ``Graded`` have ``at(depth)``, Young's modulus over depth. ``Layer``: a thickness of
one; ``Coated``: what an indenter with layers is made of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..base import ROUNDED, Array, InputError, positive, show
from .grading import Law

GEL_TENSION = 0.03  # theory: [N/m], of surfaces of gels and rubbers; silicones have 0.02, water 0.07
INCOMPRESSIBLE = 0.45  # choice: nu from which on a material is spoken of as rubber, and elements may lock


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elastic material: Young's modulus ``E`` [Pa] and Poisson's ratio ``nu`` in (-1, 1/2]."""

    E: float
    nu: float

    def __post_init__(self) -> None:
        positive("Pa", E=self.E)
        _check_poisson(self.nu)

    @property
    def E_star(self) -> float:
        """Plane-strain (contact) modulus E/(1 - nu^2) [Pa]."""
        return self.E / (1 - self.nu**2)

    @property
    def words(self) -> str:
        """``E = 5 GPa, nu = 0.4``."""
        return f"E = {show(self.E, 'modulus')}, nu = {self.nu:g}"

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

    @property
    def surface(self) -> Elastic:
        """The material itself."""
        return self

    def at(self, depth: Array) -> Array:
        """E [Pa] at every ``depth`` [m]."""
        return np.full(np.shape(depth), self.E)

    def scaled(self, factor: float) -> Elastic:
        """The same material with its modulus multiplied by ``factor``."""
        return Elastic(self.E * factor, self.nu)


@dataclass(frozen=True)
class Graded:
    """Isotropic material of a layer whose Young's modulus follows ``law`` over the depth below the layer's own top.

    ``nu``: Poisson's ratio in (-1, 1/2], the same at every depth.
    """

    law: Law
    nu: float

    def __post_init__(self) -> None:
        _check_poisson(self.nu)

    @property
    def surface(self) -> Elastic:
        """The homogeneous material with the modulus at the top of the layer."""
        return Elastic(float(self.law.at(np.zeros(1))[0]), self.nu)

    @property
    def words(self) -> str:
        """``E graded from 1 MPa at the top, linear, nu = 0.3``."""
        law = type(self.law).__name__.lower()
        return f"E graded from {show(self.surface.E, 'modulus')} at the top, {law}, nu = {self.nu:g}"

    def at(self, depth: Array) -> Array:
        """E [Pa] at every ``depth`` [m] below the layer's top."""
        return self.law.at(depth)

    def scaled(self, factor: float) -> Graded:
        """The same material with its moduli multiplied by ``factor``."""
        return replace(self, law=self.law.scaled(factor))


@dataclass(frozen=True)
class TransverselyIsotropic:
    """Material that is isotropic in the planes parallel to the surface; moduli in Pa.

    ``E_p, nu_p``: Young's modulus and Poisson's ratio in the plane; ``E_z``: Young's modulus along the depth;
    ``nu_zp``: contraction in the plane over extension along z, under a stress along z (so nu_pz = nu_zp E_p/E_z);
    ``G_z``: shear modulus between z and the plane.
    """

    E_p: float
    E_z: float
    nu_p: float
    nu_zp: float
    G_z: float

    def __post_init__(self) -> None:
        positive("Pa", E_p=self.E_p, E_z=self.E_z, G_z=self.G_z)
        if not -1 < self.nu_p < 1:
            raise InputError(f"nu_p: must be > -1 and < 1, got {self.nu_p:g}")
        if not (math.isfinite(self.nu_zp) and self.nu_zp**2 < self._nu_zp_squared_limit):
            raise InputError(
                f"nu_zp: must lie between -{math.sqrt(self._nu_zp_squared_limit):.4g} and "
                f"{math.sqrt(self._nu_zp_squared_limit):.4g} for a positive strain energy "
                f"(2 nu_zp^2 E_p/E_z < 1 - nu_p), got {self.nu_zp:g}"
            )

    @property
    def words(self) -> str:
        """``transversely isotropic, E = 1 GPa in the plane, 2 GPa along z``."""
        in_plane, along = show(self.E_p, "modulus"), show(self.E_z, "modulus")
        return f"transversely isotropic, E = {in_plane} in the plane, {along} along z"

    @property
    def _nu_zp_squared_limit(self) -> float:
        return (1 - self.nu_p) * self.E_z / (2 * self.E_p)

    @property
    def stiffness(self) -> tuple[float, float, float, float, float]:
        """C11, C12, C13, C33, C44 [Pa]; 1 and 2 in the plane, 3 along z."""
        D = 1 - self.nu_p - 2 * self.nu_zp**2 * self.E_p / self.E_z
        both, difference = self.E_p / D, self.E_p / (1 + self.nu_p)
        C13, C33 = self.nu_zp * self.E_p / D, self.E_z * (1 - self.nu_p) / D
        return (both + difference) / 2, (both - difference) / 2, C13, C33, self.G_z

    @property
    def E_star(self) -> float:
        """Indentation modulus of the half-space, its surface being the plane of isotropy [Pa].

        2 sqrt[(C11 C33 - C13^2)/C11 / (1/C44 + 2/(sqrt(C11 C33) + C13))]: Elliott (1949), Hanson (1992), in the form of
        Delafargue and Ulm, Int. J. Solids Struct. 41 (2004) 7351, Eq. 30.
        """
        C11, _, C13, C33, C44 = self.stiffness
        root = math.sqrt(C11 * C33)
        return 2 * math.sqrt((root - C13) / C11 * (root + C13) / (1 / C44 + 2 / (root + C13)))

    @property
    def surface(self) -> Elastic:
        """An isotropic material with the same indentation modulus (nu = 0, so that E is E*)."""
        return Elastic(self.E_star, 0.0)

    def scaled(self, factor: float) -> TransverselyIsotropic:
        """The same material with its moduli multiplied by ``factor``."""
        return replace(self, E_p=self.E_p * factor, E_z=self.E_z * factor, G_z=self.G_z * factor)


Material = Elastic | Graded | TransverselyIsotropic


@dataclass(frozen=True)
class Layer:
    """One layer of a stack, perfectly bonded to what lies below; ``thickness`` in m."""

    material: Material
    thickness: float
    name: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        positive("m", thickness=self.thickness)
        if isinstance(self.material, Graded) and self.material.law.reach < self.thickness * (1 - ROUNDED):
            raise InputError(
                f"the law of E ends at a depth of {self.material.law.reach:g} m, above the bottom of the layer "
                f"(thickness {self.thickness:g} m)"
            )

    @property
    def words(self) -> str:
        """``E = 1 MPa, nu = 0.4, h = 1 um``."""
        return f"{self.material.words}, h = {show(self.thickness, 'length')}"

    @property
    def moduli(self) -> tuple[float, float]:
        """The least and the largest Young's modulus in the layer [Pa] (every law is monotone between its kinks)."""
        match self.material:
            case Elastic(E=E):
                return E, E
            case Graded(law=law):
                values = law.at(np.array([0.0, *(z for z in law.kinks if z < self.thickness), self.thickness]))
                return float(values.min()), float(values.max())
            case TransverselyIsotropic(E_p=E_p, E_z=E_z):
                return min(E_p, E_z), max(E_p, E_z)


@dataclass(frozen=True)
class Coated:
    """An elastic ``core`` under bonded, homogeneous ``layers``, outermost first: the material of an indenter.

    Its surface is as compliant as that of the flat stack: what an indenter is, whose layers are thin beside its radius.
    """

    layers: tuple[Layer, ...]
    core: Elastic

    def __post_init__(self) -> None:
        if not self.layers:
            raise InputError("indenter.layers: must hold at least one layer")
        if any(isinstance(layer.material, Graded) for layer in self.layers):
            raise InputError("indenter.layers: must be homogeneous: cut a graded one into several")

    @property
    def surface(self) -> Elastic:
        """What first touch feels: the outermost material, or the isotropic one of the same E*."""
        return self.layers[0].material.surface

    @property
    def E_star(self) -> float:
        """Contact modulus of the outermost material [Pa]."""
        return self.surface.E_star

    def scaled(self, factor: float) -> Coated:
        """The same with every modulus multiplied by ``factor``."""
        layers = tuple(replace(layer, material=layer.material.scaled(factor)) for layer in self.layers)
        return Coated(layers, self.core.scaled(factor))


Solid = Elastic | Coated  # of an indenter


def _check_poisson(nu: float) -> None:
    if not -1 < nu <= 0.5:
        raise InputError(f"nu: must be > -1 and <= 0.5, got {nu:g}")


def contact_modulus(first: Elastic, second: Solid | None = None) -> float:
    """Reduced modulus E* of two bodies in contact [Pa] (Eq. 4); ``second = None`` is a rigid body."""
    if second is None:
        return first.E_star
    return 1 / (1 / first.E_star + 1 / second.E_star)

"""The contact problem: materials, indenter, specimen and loading. Physics only, SI, no mesh and no work of adhesion."""

from __future__ import annotations

import hashlib
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Protocol, Self, TypeAlias, cast, runtime_checkable

import numpy as np

from ..base.arguments import Checked, read_fields
from ..base.errors import InputError, did_you_mean
from ..base.numerics import ROUNDED, Array
from ..base.registry import Key, Registry
from ..base.units import AnyLength, Force, Length, Modulus, Poisson, Ranged, Tension, show

# --------------------------------------------------------------------------------------------------
# Linear elastic materials: isotropic or transversely isotropic, each homogeneous or graded over depth.
#
# Each has ``surface``, the isotropic half-space that the first touch of its top feels, ``scaled`` and ``words``;
# ``Elastic`` and ``Graded`` have ``at(depth)``, Young's modulus over depth, ``GradedTransverselyIsotropic`` its three
# moduli. ``Layer``: a thickness of one; ``Coated``: what an indenter with layers is made of.


# --------------------------------------------------------------------------------------------------
# Laws of Young's modulus over depth, measured from the top of the layer that has them.

LAWS = Registry(inherited="thickness")
law = LAWS.register  # decorator: the name by which ``E = { law = ... }`` of a case file calls it


class Law(ABC):
    """E(z) > 0 [Pa] for 0 <= z <= ``reach`` [m], smooth between its ``kinks``; a frozen dataclass."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """The depth [m] down to which the law is defined."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Depths [m] inside the reach at which the slope jumps."""
        return ()

    @abstractmethod
    def at(self, depth: Array) -> Array:
        """E [Pa] at ``depth`` [m], same shape."""

    @abstractmethod
    def taylor(self, count: int) -> Array:
        """The first ``count`` coefficients of E(z)/E(0) in powers of z at the top [m^-n]."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """The same law with all moduli multiplied by ``factor``."""


@dataclass(frozen=True)
class _Between(Checked, Law):
    """A smooth law from ``top`` to ``bottom`` [Pa] over ``depth`` [m]."""

    top: Modulus
    bottom: Modulus
    depth: Annotated[Length, Key("thickness")]

    @property
    def reach(self) -> float:
        return self.depth

    def scaled(self, factor: float) -> Self:
        return replace(self, top=self.top * factor, bottom=self.bottom * factor)


@law("linear")
class Linear(_Between):
    """E = top + (bottom - top) z/depth."""

    def at(self, depth: Array) -> Array:
        return self.top + (self.bottom - self.top) * np.asarray(depth, dtype=float) / self.depth

    def taylor(self, count: int) -> Array:
        return np.append([1.0, (self.bottom / self.top - 1) / self.depth], np.zeros(count))[:count]


@law("exponential")
class Exponential(_Between):
    """E = top (bottom/top)^(z/depth)."""

    @property
    def rate(self) -> float:
        """d(ln E)/dz [1/m]."""
        return math.log(self.bottom / self.top) / self.depth

    def at(self, depth: Array) -> Array:
        return self.top * np.exp(self.rate * np.asarray(depth, dtype=float))

    def taylor(self, count: int) -> Array:
        return np.array([self.rate**n / math.factorial(n) for n in range(count)])


@law("power")
@dataclass(frozen=True)
class Power(Checked, Law):
    """E = top (1 + z/length)^exponent; any real ``exponent``."""

    top: Modulus
    length: Length
    exponent: Annotated[float, Ranged("number")]

    @property
    def reach(self) -> float:
        return math.inf

    def at(self, depth: Array) -> Array:
        return self.top * (1 + np.asarray(depth, dtype=float) / self.length) ** self.exponent

    def taylor(self, count: int) -> Array:
        ratios = [(self.exponent - n + 1) / (n * self.length) for n in range(1, count)]
        return np.array(list(itertools.accumulate(ratios, lambda c, ratio: c * ratio, initial=1.0)))

    def scaled(self, factor: float) -> Self:
        return replace(self, top=self.top * factor)


@law("table")
@dataclass(frozen=True)
class Tabulated(Law):
    """``moduli`` [Pa] at increasing ``depths`` [m] from 0 on, straight lines between them."""

    depths: Annotated[tuple[AnyLength, ...], Key("depth")]
    moduli: Annotated[tuple[Modulus, ...], Key("E")]

    def __post_init__(self) -> None:
        read_fields(self)
        if len(self.depths) != len(self.moduli) or len(self.depths) < 2:
            raise InputError(
                "a table needs as many moduli as depths, at least two of each, "
                f"got {len(self.moduli)} and {len(self.depths)}"
            )
        if self.depths[0] != 0 or any(not b > a for a, b in itertools.pairwise(self.depths)):
            raise InputError(f"depth: must start at 0 m and increase, got {list(self.depths)}")

    @property
    def reach(self) -> float:
        return self.depths[-1]

    @property
    def kinks(self) -> tuple[float, ...]:
        return self.depths[1:-1]

    def at(self, depth: Array) -> Array:
        return np.interp(np.asarray(depth, dtype=float), self.depths, self.moduli)

    def taylor(self, count: int) -> Array:
        return np.append([1.0, (self.moduli[1] / self.moduli[0] - 1) / self.depths[1]], np.zeros(count))[:count]

    def scaled(self, factor: float) -> Self:
        return replace(self, moduli=tuple(modulus * factor for modulus in self.moduli))


GEL_TENSION = 0.03  # theory: [N/m], of surfaces of gels and rubbers; silicones have 0.02, water 0.07
INCOMPRESSIBLE = 0.45  # choice: nu from which on a material is spoken of as rubber, and elements may lock


@dataclass(frozen=True)
class Elastic(Checked):
    """Isotropic linear elastic material: Young's modulus ``E`` [Pa] and Poisson's ratio ``nu`` in (-1, 1/2]."""

    E: Modulus
    nu: Poisson

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
class Graded(Checked):
    """Isotropic material of a layer whose Young's modulus follows ``law`` over the depth below the layer's own top.

    ``nu``: Poisson's ratio in (-1, 1/2], the same at every depth.
    """

    law: Law
    nu: Poisson

    @property
    def laws(self) -> tuple[Law, ...]:
        """The law of E, alone."""
        return (self.law,)

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


InPlane: TypeAlias = Annotated[float, Ranged("number", above=-1, below=1)]
Contraction: TypeAlias = Annotated[float, Ranged("number")]


@dataclass(frozen=True)
class TransverselyIsotropic:
    """Material that is isotropic in the planes parallel to the surface; moduli in Pa.

    ``E_p, nu_p``: Young's modulus and Poisson's ratio in the plane; ``E_z``: Young's modulus along the depth;
    ``nu_zp``: contraction in the plane over extension along z, under a stress along z (so nu_pz = nu_zp E_p/E_z);
    ``G_z``: shear modulus between z and the plane.
    """

    E_p: Modulus
    E_z: Modulus
    nu_p: InPlane
    nu_zp: Contraction
    G_z: Modulus

    def __post_init__(self) -> None:
        read_fields(self)
        if not self.nu_zp**2 < (square := (1 - self.nu_p) * self.E_z / (2 * self.E_p)):
            raise InputError(
                f"nu_zp: must lie between -{math.sqrt(square):.4g} and {math.sqrt(square):.4g} for a positive strain "
                f"energy (2 nu_zp^2 E_p/E_z < 1 - nu_p), got {self.nu_zp:g}"
            )

    @property
    def words(self) -> str:
        """``transversely isotropic, E = 1 GPa in the plane, 2 GPa along z``."""
        in_plane, along = show(self.E_p, "modulus"), show(self.E_z, "modulus")
        return f"transversely isotropic, E = {in_plane} in the plane, {along} along z"

    @property
    def stiffness(self) -> tuple[float, float, float, float, float]:
        """C11, C12, C13, C33, C44 [Pa]; 1 and 2 in the plane, 3 along z."""
        return transverse_stiffness(self.E_p, self.E_z, self.nu_p, self.nu_zp, self.G_z)

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
    def top(self) -> TransverselyIsotropic:
        """The material itself."""
        return self

    @property
    def surface(self) -> Elastic:
        """An isotropic material with the same indentation modulus (nu = 0, so that E is E*)."""
        return Elastic(self.E_star, 0.0)

    def scaled(self, factor: float) -> TransverselyIsotropic:
        """The same material with its moduli multiplied by ``factor``."""
        return replace(self, E_p=self.E_p * factor, E_z=self.E_z * factor, G_z=self.G_z * factor)


def transverse_stiffness(E_p: Any, E_z: Any, nu_p: float, nu_zp: float, G_z: Any) -> Any:
    """C11, C12, C13, C33, C44 [Pa] of the five constants; 1 and 2 in the plane, 3 along z. Moduli of any shape."""
    D = 1 - nu_p - 2 * nu_zp**2 * E_p / E_z
    both, difference = E_p / D, E_p / (1 + nu_p)
    C13, C33 = nu_zp * E_p / D, E_z * (1 - nu_p) / D
    return (both + difference) / 2, (both - difference) / 2, C13, C33, G_z


@dataclass(frozen=True)
class GradedTransverselyIsotropic:
    """Transversely isotropic material of a layer whose moduli vary over the depth below the layer's own top.

    ``E_p, E_z, G_z``: each a law, or a number [Pa] that holds at every depth; at least one is a law. ``nu_p, nu_zp``:
    the same at every depth. All as in ``TransverselyIsotropic``.
    """

    E_p: Law | Modulus
    E_z: Law | Modulus
    nu_p: InPlane
    nu_zp: Contraction
    G_z: Law | Modulus

    def __post_init__(self) -> None:
        read_fields(self)
        if not self.laws:
            raise InputError("at least one of E_p, E_z and G_z must be a law: else take TransverselyIsotropic")
        _ = self.top

    @property
    def moduli(self) -> dict[str, Law | float]:
        """The three moduli by name."""
        return {"E_p": self.E_p, "E_z": self.E_z, "G_z": self.G_z}

    @property
    def laws(self) -> tuple[Law, ...]:
        """Those of the moduli that vary."""
        return tuple(modulus for modulus in self.moduli.values() if isinstance(modulus, Law))

    @property
    def top(self) -> TransverselyIsotropic:
        """The homogeneous material with the moduli at the top of the layer."""
        E_p, E_z, G_z = self.at(np.zeros(1))[:, 0].tolist()
        return TransverselyIsotropic(E_p, E_z, self.nu_p, self.nu_zp, G_z)

    @property
    def surface(self) -> Elastic:
        """An isotropic material with the indentation modulus at the top of the layer (nu = 0, so that E is E*)."""
        return self.top.surface

    @property
    def words(self) -> str:
        """``transversely isotropic, E = 1 GPa in the plane, 2 GPa along z at the top, graded (E_p linear)``."""
        laws = (f"{key} {type(law).__name__.lower()}" for key, law in self.moduli.items() if isinstance(law, Law))
        return f"{self.top.words} at the top, graded ({', '.join(laws)})"

    def at(self, depth: Array) -> Array:
        """E_p, E_z and G_z [Pa], shape (3, ...), at every ``depth`` [m] below the layer's top."""
        values = (m.at(depth) if isinstance(m, Law) else np.full(np.shape(depth), m) for m in self.moduli.values())
        return np.array(list(values))

    def stiffness_at(self, depth: Array) -> Array:
        """C11, C12, C13, C33, C44 [Pa], shape (5, ...), at every ``depth`` [m] below the layer's top."""
        E_p, E_z, G_z = self.at(depth)
        return np.array(transverse_stiffness(E_p, E_z, self.nu_p, self.nu_zp, G_z))

    def check_strain_energy(self, thickness: float) -> None:
        """InputError where the strain energy is not positive at every depth down to ``thickness`` [m].

        Each law is monotone where all are smooth, so that ends bound E_p/E_z there; where the bound is too large, the
        ratio has at most one extremum, which is looked for.
        """
        limit = (1 - self.nu_p) / (2 * self.nu_zp**2) if self.nu_zp else math.inf
        largest = (0.0, 0.0)
        for low, high in smooth_parts(self.laws, thickness):
            E_p, E_z, _ = self.at(np.array([low, high]))
            if E_p.max() / E_z.min() < limit:
                continue
            for _ in range(ZOOMS):
                depths = np.linspace(low, high, ZOOM + 1)
                E_p, E_z, _ = self.at(depths)
                i = int(np.argmax(E_p / E_z))
                largest = max(largest, (float(E_p[i] / E_z[i]), float(depths[i])))
                low, high = depths[max(i - 1, 0)], depths[min(i + 1, ZOOM)]
        ratio, depth = largest
        if not ratio < limit:
            allowed = math.sqrt((1 - self.nu_p) / (2 * ratio))
            raise InputError(
                f"nu_zp: must lie between -{allowed:.4g} and {allowed:.4g} for a positive strain energy {depth:.4g} m "
                f"below the layer's top, where E_p/E_z = {ratio:.4g} (2 nu_zp^2 E_p/E_z < 1 - nu_p), got {self.nu_zp:g}"
            )

    def scaled(self, factor: float) -> GradedTransverselyIsotropic:
        """The same material with its moduli multiplied by ``factor``."""
        scaled: Any = {
            key: modulus.scaled(factor) if isinstance(modulus, Law) else modulus * factor
            for key, modulus in self.moduli.items()
        }
        return replace(self, **scaled)


ZOOM = 64  # choice: parts into which the neighbourhood of an extremum is cut,
ZOOMS = 10  # theory: and how often: (2/64)^10 is the rounding of a double

AnyGraded = Graded | GradedTransverselyIsotropic
AnyTransverse = TransverselyIsotropic | GradedTransverselyIsotropic
Material = Elastic | AnyGraded | TransverselyIsotropic


def smooth_parts(laws: Sequence[Law], thickness: float) -> list[tuple[float, float]]:
    """Depths [m] between which all the ``laws`` of a layer are smooth, from the top down."""
    kinks = {z for law in laws for z in law.kinks if z < thickness}
    return list(itertools.pairwise([0.0, *sorted(kinks), thickness]))


# What layers are squeezed against, in place of a rigid base, and how their compliance over depth is added up.
SUPPORT_STIFFER = 10.0  # choice: for a warning; a plate this stiff keeps nine tenths of a strain above it
SUPPORT_THICKER = 3.0  # choice: for a warning; than all above it: sheets of a laminate bend with it
SQUEEZED_NODES = 16  # choice: for a warning


@dataclass(frozen=True)
class Layer:
    """One layer of a stack, perfectly bonded to what lies below; ``thickness`` in m."""

    material: Material
    thickness: Length
    name: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        read_fields(self)
        material = self.material
        if isinstance(material, AnyGraded):
            named = {"E": material.law} if isinstance(material, Graded) else material.moduli
            for name, law in named.items():
                if isinstance(law, Law) and law.reach < self.thickness * (1 - ROUNDED):
                    raise InputError(
                        f"the law of {name} ends at a depth of {law.reach:g} m, above the bottom of the layer "
                        f"(thickness {self.thickness:g} m)"
                    )
        if isinstance(material, GradedTransverselyIsotropic):
            material.check_strain_energy(self.thickness)

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
            case Graded() | GradedTransverselyIsotropic() as material:
                depths = np.unique(smooth_parts(material.laws, self.thickness))
                values = material.at(depths) if isinstance(material, Graded) else material.at(depths)[:2]
                return float(values.min()), float(values.max())
            case TransverselyIsotropic(E_p=E_p, E_z=E_z):
                return min(E_p, E_z), max(E_p, E_z)

    @property
    def mean_modulus(self) -> float:
        """Young's modulus [Pa] of a homogeneous layer that is squeezed as much; of transverse isotropy, that of its
        surface."""
        if not isinstance(self.material, Graded):
            return self.material.surface.E
        depths, weights = np.polynomial.legendre.leggauss(SQUEEZED_NODES)
        return 2 / float(weights @ (1 / self.material.at(self.thickness * (1 + depths) / 2)))


@dataclass(frozen=True)
class Coated:
    """An elastic ``core`` under bonded, homogeneous ``layers``, outermost first: the material of an indenter.

    Its surface is as compliant as that of the flat stack: what an indenter is, whose layers are thin beside its radius.
    """

    layers: tuple[Layer, ...]
    core: Elastic

    def __post_init__(self) -> None:
        read_fields(self, "indenter")
        if not self.layers:
            raise InputError("indenter.layers: must hold at least one layer")
        if any(isinstance(layer.material, AnyGraded) for layer in self.layers):
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


def contact_modulus(first: Elastic, second: Solid | None = None) -> float:
    """Reduced modulus E* of two bodies in contact [Pa] (Eq. 4); ``second = None`` is a rigid body."""
    if second is None:
        return first.E_star
    return 1 / (1 / first.E_star + 1 / second.E_star)


# --------------------------------------------------------------------------------------------------
# Laws by which the moduli of a specimen relax: one function r(t) for all its layers, at constant Poisson's ratios.
#
# Each law is a class that registers itself. r is given as a sum of exponentials, which every step in time carries on
# exactly.

Time: TypeAlias = Annotated[float, Ranged("time", above=0)]
Share: TypeAlias = Annotated[float, Ranged("number", above=0, most=1)]

RELAXATIONS = Registry()
relaxation_law = RELAXATIONS.register  # decorator: the name by which ``relaxation = { law = ... }`` calls it

# The exponentials that stand for a power law over a program that lasts T.
SPECTRUM_STEP = 0.4  # theory: of log rates; the trapezoidal rule errs by exp(-pi^2/0.4) = 2e-11
SPECTRUM_SLOWEST = 1e-5  # theory: rate times T below which one exponential stands for all; errs by its square
SPECTRUM_FASTEST = 1e10  # theory: the same above which one does, of equal area and moment


class Modes(NamedTuple):
    """r(t) = ``relaxed`` + sum of ``weights`` exp(-``rates`` t); weights and rates [1/s] (m,)."""

    relaxed: float
    weights: Array
    rates: Array

    def __call__(self, t: Any) -> Any:
        """r at the times ``t`` >= 0 [s] of any shape."""
        return self.relaxed + np.exp(-np.multiply.outer(t, self.rates)) @ self.weights


@runtime_checkable
class Relaxation(Protocol):
    """r(t) of the moduli: a frozen dataclass whose fields are its parameters."""

    @property
    def relaxed(self) -> float | None:
        """The relaxed over the instantaneous modulus; None where there is none."""

    def modes(self, lasting: float) -> Modes:
        """r over the times up to ``lasting`` [s]."""


@relaxation_law("sls")
@dataclass(frozen=True)
class StandardSolid:
    """r = ratio + (1 - ratio) exp(-t/time), the standard linear solid; E is the instantaneous modulus, ``ratio`` the
    relaxed one over it."""

    ratio: Annotated[float, Ranged("number", least=0, most=1)]
    time: Time

    def __post_init__(self) -> None:
        read_fields(self, "relaxation", sought=True)

    @property
    def relaxed(self) -> float | None:
        return self.ratio

    def modes(self, lasting: float) -> Modes:
        return Modes(self.ratio, np.array([1 - self.ratio]), np.array([1 / self.time]))

    def __str__(self) -> str:
        return f"standard linear solid, ratio = {self.ratio:.4g}, time = {show(self.time, 'time')}"


@relaxation_law("kelvin-voigt")
@dataclass(frozen=True)
class KelvinVoigtSolid:
    """The standard linear solid by how it creeps, J E = 1 + (1/ratio - 1) (1 - exp(-t/retardation)): a spring of E
    before a Kelvin-Voigt element of the ``retardation`` time; it relaxes within the ``ratio`` of that time."""

    ratio: Annotated[float, Ranged("number", above=0, most=1)]
    retardation: Time

    def __post_init__(self) -> None:
        read_fields(self, "relaxation", sought=True)

    @property
    def relaxed(self) -> float | None:
        return self.ratio

    def modes(self, lasting: float) -> Modes:
        return StandardSolid(self.ratio, self.ratio * self.retardation).modes(lasting)

    def __str__(self) -> str:
        return f"Kelvin-Voigt form, ratio = {self.ratio:.4g}, retardation = {show(self.retardation, 'time')}"


@relaxation_law("power")
@dataclass(frozen=True)
class PowerRelaxation:
    """r = ((t + onset)/time)^-exponent: E is the modulus at ``time`` where the ``onset`` is short; there is no relaxed
    one, and without an onset no instant one.

    t^-x Gamma(x) = int exp(x u - t exp(u)) du, by the trapezoidal rule (Beylkin and Monzon, Appl. Comput. Harmon. Anal.
    28 (2010) 131).
    """

    time: Time
    exponent: Annotated[float, Ranged("number", above=0, below=1)]
    onset: Annotated[float, Ranged("time", least=0)] = 0.0

    def __post_init__(self) -> None:
        read_fields(self, "relaxation", sought=True)

    @property
    def relaxed(self) -> float | None:
        return None

    def modes(self, lasting: float, h: float = SPECTRUM_STEP) -> Modes:
        x, T = self.exponent, lasting / self.time
        low, high = math.floor(math.log(SPECTRUM_SLOWEST / T) / h), math.ceil(math.log(SPECTRUM_FASTEST / T) / h)
        u = h * np.arange(low, high + 1)
        slow, slower = (math.exp(p * u[0]) / math.expm1(p * h) for p in (x, x + 1))  # sums below: weight, weight x rate
        fast, faster = (math.exp(-p * u[-1]) / math.expm1(p * h) for p in (1 - x, 2 - x))  # above: over rate, rate^2
        weights = np.concatenate([[slow], np.exp(x * u), [fast**2 / faster]])
        rates = np.concatenate([[slower / slow], np.exp(u), [fast / faster]])
        weights *= np.exp(-self.onset / self.time * rates) * h / math.gamma(x)
        return Modes(0.0, weights, rates / self.time)

    def __str__(self) -> str:
        begins = f", onset = {show(self.onset, 'time')}" if self.onset else ""
        return f"power law, exponent = {self.exponent:.4g}{begins}, E at {show(self.time, 'time')}"


@relaxation_law("prony")
@dataclass(frozen=True)
class Prony:
    """r = 1 - sum of g_i (1 - exp(-t/t_i)): ``weights`` g_i > 0 of sum at most 1, relaxation ``times`` t_i [s]; E is
    the instantaneous modulus."""

    weights: tuple[Share, ...]
    times: tuple[Time, ...]

    def __post_init__(self) -> None:
        read_fields(self, "relaxation")
        if len(self.weights) != len(self.times) or not self.weights:
            raise InputError(
                f"relaxation: needs as many times as weights, got {len(self.weights)} weights, {len(self.times)} times"
            )
        if sum(self.weights) > 1 + 1e-12:
            raise InputError(f"relaxation: the weights must be > 0, their sum at most 1, got {list(self.weights)}")

    @property
    def relaxed(self) -> float | None:
        return max(0.0, 1 - sum(self.weights))

    def modes(self, lasting: float) -> Modes:
        return Modes(self.relaxed or 0.0, np.array(self.weights), 1 / np.array(self.times))

    def __str__(self) -> str:
        pairs = zip(self.weights, self.times, strict=True)
        return "prony, " + ", ".join(f"{weight:.4g} within {show(time, 'time')}" for weight, time in pairs)


def relaxing(law: Relaxation | None) -> list[str]:
    """A warning of what a result of constant moduli means for a viscoelastic specimen, which relaxes by ``law``; none
    for an elastic one."""
    if law is None:
        return []
    begin = "the specimen relaxes: "
    if law.relaxed is None:
        here = "the moduli here are those at the time of the law"
        return [f"{begin}{here}; without adhesion jkr cycle --speed follows them"]
    over_time = "jkr cycle --speed follows them over time, with adhesion by --stress or --range"
    fast = f"{begin}this is the limit of very fast cycles, with the moduli at t = 0"
    if not law.relaxed > 0:
        return [f"{fast}; {over_time}"]
    return [
        f"{fast}, and no bound: pulled instantly from rest, contact holds up to {1 / law.relaxed:.3g} times as much; "
        f"jkr pull-off and jkr cycle give the force by the history; {over_time}"
    ]


# --------------------------------------------------------------------------------------------------
# What an indenter must know, and the shapes by which case files call them.
#
# An indenter is a rigid or elastic, convex, axisymmetric profile f(r). What the contact problem needs of it is the Abel
# image F; on a half-space F is the displacement itself: delta_H(a) = F(a) (Sneddon 1965).

SHAPES = Registry(inherited="material", word="shape")
shape = SHAPES.register  # decorator: the shape by which the table [indenter] of a case file calls it


class Indenter(ABC):
    """Describe a convex axisymmetric profile f(r); base of the frozen dataclasses of ``bodies/indenters``.

    A shape has a field ``material``, None where rigid, and a ``noun`` for messages; the table [indenter] of a case file
    calls it by the name of its decorator ``@shape("name")``, its other fields are the keys.

    Methods
    -------
    f(r)
        Profile [m] at radii r (n,) [m]: f(0) = 0, infinite beyond ``r_max``.
    slope(r)
        Slope f'(r) (n,) [-].
    abel(x)
        Abel image F(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr (n,) [m].
    abel_slope(x)
        F'(x) (n,) [-], x > 0.
    words
        Property: the shape for a sentence, "sphere R = 100 um".

    Notes
    -----
    On a half-space delta_H(a) = F(a) and P_H = 2 E* int_0^a (F(a) - F(x)) dx (Sneddon, Int. J. Eng. Sci. 3 (1965) 47);
    ``half_space`` gives both where they have a closed form. ``a0``, ``tip_radius``, ``kinks`` and ``joints`` have
    defaults of a smooth tip without a radius.
    """

    material: Solid | None
    noun: ClassVar[str]  # what messages call it: "tabulated profile"

    @property
    def a0(self) -> float:
        """Contact radius at first touch [m]: 0 for round and pointed indenters, > 0 for a flat end."""
        return 0.0

    @property
    def r_max(self) -> float:
        """Largest radius at which the profile is defined [m]."""
        return math.inf

    @property
    def rim(self) -> float:
        """Contact radius [m] of a full end, at which the edge is pinned; infinite where contact grows on and on."""
        return math.inf

    @property
    def tip_radius(self) -> float | None:
        """Radius of curvature at the tip [m]; None where there is none (cone, flat end, blunt power laws)."""
        return None

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radii > 0 [m] where the slope f' bends, and with it F, increasing."""
        return ()

    @property
    def bends(self) -> tuple[float, ...]:
        """The kinks [m] that are meant, and not what is left between the points of a table."""
        return self.kinks

    @property
    def joints(self) -> tuple[float, ...]:
        """Radii > 0 [m] at which formulas of f begin, the kinks among them, increasing: where quadrature is cut."""
        return self.kinks

    @property
    def contact_share(self) -> float:
        """Contact area of the tip over that of the body of revolution that stands for it, at equal depth."""
        return 1.0

    @property
    def error_name(self) -> str:
        """What the largest part of a stated error is likely to be."""
        return "numerical error"

    @property
    def remark(self) -> str:
        """What stands for the tip, where that is a convention that results depend on; else empty."""
        return ""

    def resolution(self, a: Array) -> Array:
        """Errors (2, n) of F [m] and of its slope up to the radii ``a`` (n,), where f is only known at points."""
        return np.zeros((2, a.size))

    @property
    def thinned(self) -> tuple[Indenter, ...]:
        """The profiles through fewer points, where f is only known at points."""
        return ()

    def left(self, a: Array) -> Array:
        """Errors of F near the radii ``a`` (n,), of its slope, and of the mean of F up to there, over what the
        ``thinned`` profiles change of them, (3, n)."""
        return np.zeros((3, a.size))

    @property
    def keys(self) -> dict[str, Any]:
        """Its keys in the table [indenter] of a case file."""
        return SHAPES.keys_in_file(self)

    @property
    @abstractmethod
    def words(self) -> str:
        """The shape for a sentence: ``sphere R = 100 um``."""

    @abstractmethod
    def f(self, r: Array) -> Array:
        """Profile f(r) [m], f(0) = 0; infinite beyond ``r_max``."""

    @abstractmethod
    def slope(self, r: Array) -> Array:
        """Slope f'(r) [-]."""

    @abstractmethod
    def abel(self, x: Array) -> Array:
        """Abel image F(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr [m]."""

    @abstractmethod
    def abel_slope(self, x: Array) -> Array:
        """F'(x) [-], x > 0: F' = F/x + int_0^x r f''(r)/sqrt(x^2 - r^2) dr."""

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array] | None:
        """delta_H = F(a) [m], P_H = 2 E* int_0^a (F(a) - F(x)) dx [N] on a half-space; None: it has no closed form."""
        return None


# --------------------------------------------------------------------------------------------------
# What is pressed on what, and how far: the problem of one contact.

Quantity = Literal["depth", "load", "radius"]
Spacing = Literal["radius", "depth", "load", "log", "given"]
Side = Literal["free", "roller", "clamped"]
NO_FINITE_RANGE = (
    "adhesion of finite range is not derived with surface tension: leave range, stress and capillary out, or "
    "specimen.surface_tension"
)
PUNCH_WITHOUT_RANGE = (
    "adhesion of finite range is not derived at the sharp edge of a flat punch: leave range, stress and capillary out, "
    "or give indenter.flat_radius and edge_radius"
)
NOT_TOGETHER = {
    ("relaxation", "elastic"): "specimen.relaxation: needs a rigid indenter: an elastic one does not relax with the "
    "specimen; leave out indenter.E and nu, or the relaxation",
    ("relaxation", "sticking"): "specimen.relaxation: is for frictionless contact only: leave out "
    'surface = "sticking" or the relaxation',
    ("relaxation", "tension"): "specimen.relaxation: contact of a viscoelastic specimen is not derived with surface "
    "tension: leave specimen.surface_tension out, or the relaxation",
    ("relaxation", "rim"): "specimen.relaxation: contact of a viscoelastic specimen with a sharp-edged flat punch is "
    "not derived: leave the relaxation out, or give indenter.flat_radius and edge_radius",
    ("tension", "sticking"): "specimen.surface_tension: contact without slip is not derived with surface tension: "
    'leave it out, or take specimen.surface = "sliding"',
}
MOST_PIECES = 1000  # of E over depth, in all layers; choice: minutes, each is solved by sublayers of its own


@dataclass(frozen=True)
class Rigid(Checked):
    """A rigid base, to which the lowest layer is bonded or on which it slides without friction."""

    where: ClassVar[str] = "base"
    bonded: bool = True


@dataclass(frozen=True)
class HalfSpace(Checked):
    """A homogeneous elastic half-space below the layers; with no layers it is the whole specimen."""

    where: ClassVar[str] = "half_space"
    material: Elastic | TransverselyIsotropic


@dataclass(frozen=True)
class Specimen:
    """Layers from the contact surface down, and a base (default: rigid, bonded); ``radius`` [m] and ``side`` for a
    really finite body only.

    ``surface_tension`` [N/m]: of the solid, a constant stress of its whole surface. ``relaxation``: of all moduli
    together, which are those at t = 0 (or at the law's own reference time); no part of what is solved.
    """

    layers: tuple[Layer, ...]
    base: Rigid | HalfSpace = field(default_factory=Rigid)
    radius: Length | None = None
    side: Side | None = None
    surface_tension: Tension = field(default=0.0, repr=False)
    relaxation: Relaxation | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        read_fields(self, "specimen")
        if not self.layers and isinstance(self.base, Rigid):
            raise InputError("specimen: a rigid substrate needs at least one layer on it")
        if (self.radius is None) != (self.side is None):
            raise InputError("specimen: a cylinder needs both radius and side (free, roller or clamped)")
        if self.pieces > MOST_PIECES:
            raise InputError(
                f"E over depth has {self.pieces:,} smooth pieces, at most {MOST_PIECES:,} are taken; "
                "leave out points that lie nearly on the straight line between their neighbours"
            )

    @property
    def is_half_space(self) -> bool:
        """True for a homogeneous, laterally unbounded half-space."""
        return not self.layers and self.radius is None

    @property
    def surface(self) -> Elastic:
        """What first touch feels: the material at the contact, or the isotropic one of the same E*."""
        return self.materials[0].surface

    @property
    def materials(self) -> tuple[Material, ...]:
        """All materials from the surface down."""
        layers = tuple(layer.material for layer in self.layers)
        return (*layers, self.base.material) if isinstance(self.base, HalfSpace) else layers

    @property
    def is_graded(self) -> bool:
        """True where the modulus of any layer varies over depth."""
        return any(isinstance(layer.material, AnyGraded) for layer in self.layers)

    @property
    def pieces(self) -> int:
        """How many smooth pieces the laws of E over depth have, in all layers."""
        return sum(
            len(smooth_parts(layer.material.laws, layer.thickness))
            for layer in self.layers
            if isinstance(layer.material, AnyGraded)
        )

    @property
    def thickness(self) -> float:
        """Total thickness of the layers [m]; infinite on an elastic half-space."""
        if isinstance(self.base, HalfSpace):
            return math.inf
        return sum(layer.thickness for layer in self.layers)

    @property
    def top_thickness(self) -> float:
        """Thickness of the uppermost layer [m], the h of a/h; infinite for a half-space."""
        return self.layers[0].thickness if self.layers else math.inf

    @property
    def tension_length(self) -> float:
        """kappa = 2 Ups/E* of the material at the surface [m], below which its tension carries more than it does."""
        return 2 * self.surface_tension / self.surface.E_star

    @property
    def yielding_depth(self) -> float:
        """Depth [m] over which the softest material above the support is squeezed, as if all of it were of that
        material: sum of h E_softest/E, E the harmonic mean over a layer. The support is the rigid base, a stiffer
        half-space, or a layer ``SUPPORT_STIFFER`` times as stiff and ``SUPPORT_THICKER`` times as thick as what is
        above. Infinite where there is none, as below a stiff skin."""
        above: list[tuple[float, float]] = []
        softest, thickness = math.inf, 0.0
        for layer in self.layers:
            h, E = layer.thickness, layer.mean_modulus
            if E > SUPPORT_STIFFER * softest and h > SUPPORT_THICKER * thickness:
                break
            above.append((h, E))
            softest, thickness = min(softest, E), thickness + h
        else:
            if isinstance(self.base, HalfSpace) and self.base.material.surface.E <= softest:
                return math.inf
        return sum(h * (softest / E) for h, E in above)

    @property
    def words(self) -> str:
        """``a layer (E = 1 MPa, nu = 0.4, h = 1 um) on a rigid base``."""
        surface = self.materials[0].words
        if self.surface_tension:
            surface += f", surface tension {show(self.surface_tension, 'tension')}"
        if self.is_half_space:
            return f"a half-space ({surface})"
        height = f"h = {show(self.top_thickness, 'length')}"
        count = len(self.layers)
        layers, top = ("a layer", "") if count == 1 else (f"{count} layers", " on top")
        side = ""
        if self.radius is not None:
            side = f", cylinder of radius {show(self.radius, 'length')}, side {self.side}"
        match self.base:
            case HalfSpace(material=Elastic(E=E)):
                base = f"an elastic half-space (E = {show(E, 'modulus')})"
            case HalfSpace(material=material):
                base = f"an elastic half-space ({material.words})"
            case Rigid(bonded=bonded):
                base = "a rigid substrate" if bonded else "a rigid frictionless base"
        return f"{layers} ({surface}, {height}{top}{side}) on {base}"

    def scaled(self, factor: float) -> Specimen:
        """The same specimen with every modulus, and the surface tension, multiplied by ``factor``: the same
        displacements."""
        layers = tuple(replace(layer, material=layer.material.scaled(factor)) for layer in self.layers)
        base = self.base
        if isinstance(base, HalfSpace):
            base = HalfSpace(base.material.scaled(factor))
        return replace(self, layers=layers, base=base, surface_tension=self.surface_tension * factor)


@dataclass(frozen=True)
class Loading:
    """What is prescribed: increments up to ``maximum`` of a quantity [m or N], or the ``values`` themselves.

    ``spacing = "radius"``: ``points`` contact radii, evenly spaced between first touch and the largest one;
    ``"depth"``, ``"load"``: evenly spaced displacements, or loads; ``"log"``: radii graded towards first
    contact, sqrt(a^2 - a0^2) in a geometric sequence over four decades; ``"given"``: increasing ``values``.
    """

    to: Quantity
    maximum: float
    points: Annotated[int, Ranged("number", least=1)] = 100
    spacing: Spacing = "radius"
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        kind: Any = Force if self.to == "load" else Length
        read_fields(self, "loading", maximum=kind, values=tuple[kind, ...])
        if self.spacing == "given":
            steps = [b - a for a, b in zip((0.0, *self.values), self.values, strict=False)]
            if not self.values or min(steps) <= 0:
                raise InputError(f"loading.values: must be positive and increase, got {list(self.values)}")
            if (self.points, self.maximum) != (len(self.values), self.values[-1]):
                raise InputError(
                    f"loading.values: are {len(self.values)} up to {self.values[-1]:g}, points and maximum say "
                    f"{self.points} up to {self.maximum:g}: write Loading.given(to, values)"
                )
        elif self.values:
            raise InputError(
                'loading.values: are for spacing "given": leave them out, or write Loading.given(to, values)'
            )

    @property
    def goal(self) -> str:
        """The largest value with its unit: ``3 um``."""
        return show(self.maximum, "load" if self.to == "load" else "length")

    @classmethod
    def given(cls, to: Quantity, values: tuple[float, ...]) -> Loading:
        """Loading to the given, increasing values of ``to``."""
        return cls(to, max(values, default=0.0), len(values), "given", tuple(values))

    def at_rim(self, R: float, other: float) -> Loading:
        """The same for a full end of the ``other`` radius in place of ``R`` [m]: contact radii go along."""
        if self.to != "radius":
            return self
        return replace(self, maximum=self.maximum / R * other, values=tuple(a / R * other for a in self.values))


@dataclass(frozen=True)
class Problem:
    """An axisymmetric contact problem, geometrically linear (method: any).

    ``sticks``: each point keeps the radial displacement with which it was touched; else the surfaces slide without
    friction.
    """

    indenter: Indenter
    specimen: Specimen
    loading: Loading
    sticks: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        read_fields(self, "problem")
        specimen = self.specimen
        features = {"elastic": self.indenter.material is not None, "sticking": self.sticks}
        features |= {"relaxation": specimen.relaxation is not None, "tension": specimen.surface_tension > 0}
        features |= {"rim": self.indenter.rim < math.inf}
        for pair, words in NOT_TOGETHER.items():
            if all(features[name] for name in pair):
                raise InputError(words)

    @property
    def E_star(self) -> float:
        """Reduced modulus of the two materials that touch [Pa] (Eq. 4)."""
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def coatings(self) -> tuple[Layer, ...]:
        """The layers of the indenter from its surface inwards."""
        material = self.indenter.material
        return material.layers if isinstance(material, Coated) else ()

    @property
    def layers(self) -> tuple[Layer, ...]:
        """All layers of both bodies."""
        return (*self.specimen.layers, *self.coatings)

    @property
    def is_half_space(self) -> bool:
        """True where E* is all that counts: a homogeneous half-space under a rigid or homogeneous indenter."""
        return self.specimen.is_half_space and not self.coatings

    @property
    def top_thickness(self) -> float:
        """Thickness of the thinner of the two layers that touch [m]; infinite between half-spaces."""
        return min([self.specimen.top_thickness, *(layer.thickness for layer in self.coatings[:1])])

    @property
    def surface(self) -> str:
        """What the surfaces do that touch: "sliding" without friction, or "sticking"."""
        return "sticking" if self.sticks else "sliding"

    @property
    def words(self) -> str:
        """``sphere R = 100 um on a half-space (E = 5 GPa, nu = 0.4) to a depth of 3 um``."""
        elastic, to = "" if self.indenter.material is None else "elastic ", self.loading.to
        end = f"{'contact radius' if to == 'radius' else to} of {self.loading.goal}"
        stuck = ", no slip," if self.sticks else ""
        more = " on top" if len(self.coatings) > 1 else ""
        coated = f", coated ({self.coatings[0].words}{more})," if self.coatings else ""
        where = f"on {self.specimen.words}{stuck} to a {end}"
        return f"{elastic}{self.indenter.words}{coated} {where}"

    def scaled(self, factor: float) -> Problem:
        """The same problem with every modulus, tension and prescribed load multiplied by ``factor``."""
        indenter, loading = self.indenter, self.loading
        if indenter.material is not None:
            indenter = replace(cast(Any, indenter), material=indenter.material.scaled(factor))
        if loading.to == "load":
            values = tuple(value * factor for value in loading.values)
            loading = replace(loading, maximum=loading.maximum * factor, values=values)
        return Problem(indenter, self.specimen.scaled(factor), loading, self.sticks)

    @property
    def key(self) -> str:
        """A hash of the physics: equal for equal problems, whatever method solves them."""
        words = f"{self!r}, sticks" if self.sticks else repr(self)
        words += f", surface tension {tension!r}" if (tension := self.specimen.surface_tension) else ""
        return hashlib.sha256(words.encode()).hexdigest()[:16]


# --------------------------------------------------------------------------------------------------
# The layers of a body by name, and the body with other values in some of them, or without sides.

BASE = "base"  # name of an elastic half-space below the layers
RADIUS = "radius"  # of the indenter, among the names of inputs


def layer_names(specimen: Specimen) -> tuple[str, ...]:
    """Names of the layers in the case, else their numbers from 1 at the contact; "base": the half-space."""
    names = [layer.name or str(i) for i, layer in enumerate(specimen.layers, start=1)]
    return (*names, *([BASE] if isinstance(specimen.base, HalfSpace) else []))


def nominal(specimen: Specimen, name: str) -> float:
    """The value of "E:layer" [Pa], "h:layer" [m] or "nu:layer"."""
    quantity, _, layer = name.partition(":")
    names = layer_names(specimen)
    checked_names([layer], names)
    part: Any = (*specimen.layers, specimen.base)[_place(layer, names)]
    if quantity != "h":
        return float(getattr(part.material.surface, quantity))
    if not isinstance(part, Layer):
        raise InputError(f"{name}: a half-space has no thickness")
    return part.thickness


def _place(name: str, names: Sequence[str]) -> int:
    """The last that is called so: "base" is the half-space, whatever layers are called."""
    return len(names) - 1 - names[::-1].index(name)


def changed(problem: Problem, values: Mapping[str, float]) -> Problem:
    """The problem with other moduli [Pa], thicknesses [m] and Poisson's ratios by name ("E:film": 2e6, ...), or another
    "radius" of the indenter [m]."""
    specimen, names = problem.specimen, layer_names(problem.specimen)
    parts: list[Any] = [*specimen.layers, specimen.base]
    for name, value in values.items():
        quantity, _, layer = name.partition(":")
        if quantity == RADIUS:
            indenter: Any = problem.indenter
            loading = problem.loading if indenter.rim == math.inf else problem.loading.at_rim(indenter.R, value)
            problem = replace(problem, indenter=replace(indenter, R=value), loading=loading)
            continue
        i = _place(layer, names)
        material = parts[i].material
        if quantity == "h":
            parts[i] = replace(parts[i], thickness=value)
        elif quantity == "nu":
            parts[i] = replace(parts[i], material=replace(material, nu=value))
        elif isinstance(material, Elastic):
            parts[i] = replace(parts[i], material=replace(material, E=value))
        else:  # the modulus of its top, all moduli in proportion
            parts[i] = replace(parts[i], material=material.scaled(value / material.surface.E))
    return replace(problem, specimen=replace(specimen, layers=tuple(parts[:-1]), base=parts[-1]))


def without_side_walls(problem: Problem) -> Problem:
    """The same problem without the sides of the specimen."""
    return replace(problem, specimen=replace(problem.specimen, radius=None, side=None))


def alone(problem: Problem) -> Problem:
    """The same indenter on a half-space of the material at the surface, with its tension, both without layers."""
    specimen, indenter = problem.specimen, problem.indenter
    half_space = Specimen((), HalfSpace(specimen.surface), surface_tension=specimen.surface_tension)
    if problem.coatings:
        indenter = replace(cast(Any, indenter), material=problem.coatings[0].material.surface)
    return replace(problem, specimen=half_space, indenter=indenter)


def stacks(specimen: Specimen, indenter: Solid | None = None) -> tuple[Specimen, ...]:
    """The bodies whose compliance is not that of a half-space: the specimen and the coated indenter, as a flat stack on
    its core."""
    bodies = [specimen]
    if isinstance(indenter, Coated):
        bodies.append(Specimen(indenter.layers, HalfSpace(indenter.core)))
    return tuple(body for body in bodies if body.layers)


def checked_names(names: Sequence[str], allowed: Sequence[str], verb: str = "fit") -> None:
    """Refuse a name that is none of ``allowed``, with the nearest that is; the message begins with the ``verb``."""
    for name in names:
        if name not in allowed:
            hint = did_you_mean(name, allowed, 0.4)
            raise InputError(f'{verb}: unknown parameter "{name}"{hint} (allowed: {", ".join(allowed)})')

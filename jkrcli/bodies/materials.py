"""Linear elastic materials: isotropic or transversely isotropic, each homogeneous or graded over depth.

Each has ``surface``, the isotropic half-space that the first touch of its top feels, ``scaled`` and ``words``;
``Elastic`` and ``Graded`` have ``at(depth)``, Young's modulus over depth, ``GradedTransverselyIsotropic`` its three
moduli. ``Layer``: a thickness of one; ``Coated``: what an indenter with layers is made of.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple, Protocol, Self, TypeAlias

import numpy as np

from ..base.errors import InputError, positive
from ..base.numerics import ROUNDED, Array
from ..base.registry import Key, Registry
from ..base.units import AnyLength, Length, Modulus, Ranged, check_ranges, show

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
class _Between(Law):
    """A smooth law from ``top`` to ``bottom`` [Pa] over ``depth`` [m]."""

    top: Modulus
    bottom: Modulus
    depth: Annotated[float, Key("thickness")]

    def __post_init__(self) -> None:
        positive("Pa", top=self.top, bottom=self.bottom)
        positive("m", depth=self.depth)

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
class Power(Law):
    """E = top (1 + z/length)^exponent; any real ``exponent``."""

    top: Modulus
    length: Length
    exponent: Annotated[float, Ranged("number")]

    def __post_init__(self) -> None:
        positive("Pa", top=self.top)
        positive("m", length=self.length)
        if not math.isfinite(self.exponent):
            raise InputError(f"exponent: must be a finite number, got {self.exponent:g}")

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
        if len(self.depths) != len(self.moduli) or len(self.depths) < 2:
            raise InputError(
                "a table needs as many moduli as depths, at least two of each, "
                f"got {len(self.moduli)} and {len(self.depths)}"
            )
        if self.depths[0] != 0 or any(not b > a for a, b in itertools.pairwise(self.depths)):
            raise InputError(f"depth: must start at 0 m and increase, got {list(self.depths)}")
        if not math.isfinite(self.depths[-1]):
            raise InputError(f"depth: must be finite, got {self.depths[-1]:g} m")
        wrong = [modulus for modulus in self.moduli if not (math.isfinite(modulus) and modulus > 0)]
        if wrong:
            raise InputError(f"E: every modulus must be > 0 Pa, got {wrong[0]:g}")

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

    E_p: Law | float
    E_z: Law | float
    nu_p: float
    nu_zp: float
    G_z: Law | float

    def __post_init__(self) -> None:
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


@dataclass(frozen=True)
class Layer:
    """One layer of a stack, perfectly bonded to what lies below; ``thickness`` in m."""

    material: Material
    thickness: float
    name: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        positive("m", thickness=self.thickness)
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


def _check_poisson(nu: float) -> None:
    if not -1 < nu <= 0.5:
        raise InputError(f"nu: must be > -1 and <= 0.5, got {nu:g}")


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

    ratio: Annotated[float, Ranged("number", least=0, below=1)]
    time: Time

    def __post_init__(self) -> None:
        check_ranges(self, "relaxation")

    @property
    def relaxed(self) -> float | None:
        return self.ratio

    def modes(self, lasting: float) -> Modes:
        return Modes(self.ratio, np.array([1 - self.ratio]), np.array([1 / self.time]))

    def __str__(self) -> str:
        return f"standard linear solid, ratio = {self.ratio:.4g}, time = {show(self.time, 'time')}"


@relaxation_law("power")
@dataclass(frozen=True)
class PowerRelaxation:
    """r = (t/time)^-exponent: E is the modulus at ``time``; there is neither an instant nor a relaxed one.

    t^-x Gamma(x) = int exp(x u - t exp(u)) du, by the trapezoidal rule (Beylkin and Monzon, Appl. Comput. Harmon. Anal.
    28 (2010) 131).
    """

    time: Time
    exponent: Annotated[float, Ranged("number", above=0, below=1)]

    def __post_init__(self) -> None:
        check_ranges(self, "relaxation")

    @property
    def relaxed(self) -> float | None:
        return None

    def modes(self, lasting: float) -> Modes:
        h, x, T = SPECTRUM_STEP, self.exponent, lasting / self.time
        low, high = math.floor(math.log(SPECTRUM_SLOWEST / T) / h), math.ceil(math.log(SPECTRUM_FASTEST / T) / h)
        u = h * np.arange(low, high + 1)
        slow, slower = (math.exp(p * u[0]) / math.expm1(p * h) for p in (x, x + 1))  # sums below: weight, weight x rate
        fast, faster = (math.exp(-p * u[-1]) / math.expm1(p * h) for p in (1 - x, 2 - x))  # above: over rate, rate^2
        weights = np.concatenate([[slow], np.exp(x * u), [fast**2 / faster]])
        rates = np.concatenate([[slower / slow], np.exp(u), [fast / faster]])
        return Modes(0.0, weights * h / math.gamma(x), rates / self.time)

    def __str__(self) -> str:
        return f"power law, exponent = {self.exponent:.4g}, E at {show(self.time, 'time')}"


@relaxation_law("prony")
@dataclass(frozen=True)
class Prony:
    """r = 1 - sum of g_i (1 - exp(-t/t_i)): ``weights`` g_i > 0 of sum at most 1, relaxation ``times`` t_i [s]; E is
    the instantaneous modulus."""

    weights: tuple[Share, ...]
    times: tuple[Time, ...]

    def __post_init__(self) -> None:
        if len(self.weights) != len(self.times) or not self.weights:
            raise InputError(
                f"relaxation: needs as many times as weights, got {len(self.weights)} weights, {len(self.times)} times"
            )
        if not min(self.weights) > 0 or sum(self.weights) > 1 + 1e-12:
            raise InputError(f"relaxation: the weights must be > 0, their sum at most 1, got {list(self.weights)}")
        if not min(self.times) > 0:
            raise InputError(f"relaxation: the times must be > 0 s, got {list(self.times)}")

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
        "jkr "
        f"pull-off and jkr cycle give the force by the history; {over_time}"
    ]

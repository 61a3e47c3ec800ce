"""Compliance spectrum g(k) of a stack: surface compliance C(k) = 2 g(k)/(E* k) in Hankel space, and its kernels.

The kernel of the contact equation is K(x, t) = int_0^inf (g(k) - 1) cos(kx) cos(kt) dk, by quadrature in k. Panels in k
are refined until g is a polynomial on each, down to k = 0: it has features at 1/h of the thinnest layer and at 1/H of
the whole depth, far below for stiff coatings, whatever lies between. Then they are cut until cos(k (x + t)) turns by no
more on each than the nodes can follow. Under a graded top layer g - 1 has a slowly decaying
``tail``, whose part of K is known in closed form and left to ``product``; for ``LayeredSpectrum`` the rest is then
g - 1 - t(k).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from ...base.errors import SolveError
from ...base.numerics import Array
from ...base.process import REMEMBERED
from ...bodies.problem import (
    AnyGraded,
    AnyTransverse,
    Elastic,
    Graded,
    GradedTransverselyIsotropic,
    HalfSpace,
    Law,
    Layer,
    Material,
    Problem,
    Rigid,
    Solid,
    Specimen,
    TransverselyIsotropic,
    contact_modulus,
    smooth_parts,
    stacks,
)
from ..integral.fredholm import CosineKernel, gauss, phase_allowed, rule, split, to_legendre

# --------------------------------------------------------------------------------------------------
# Compliance of what lies below a depth, as minors, and their way up through the layers of a stack.
#
# The material below a depth is described by its compliance matrix F: displacements (u_r, u_z) = F (T_r, T_z)/(G k),
# with T the tractions on it. Upwards through a layer, zeta = k z, F obeys a Riccati equation; its five minors
#
#     m = m_0 (1, F_rr, F_zz, F_rz, det F)
#
# obey a linear one, dm/dzeta = B m (the delta-matrix method, Dunkin 1965). In an isotropic material B has the
# eigenvalues 0 (triple), 2 and -2, so
#
#     exp(B y) = I + B y + B^2 y^2/2 + B^3 (sinh 2y - 2y)/8 + B^4 (cosh 2y - 1 - 2 y^2)/16,        y = k h,
#
# which is used with the factor exp(-2 y) throughout: nothing overflows, nothing cancels at small y, and nu = 1/2 is
# an ordinary value. A rigid base that allows sliding has infinite F_rr, but ordinary minors.
#
# A transversely isotropic material differs by the constants in B: the eigenvalues are 0, +-(s1 + s2), +-(s1 - s2),
# where exp(-s_j k z) are the half-space's two fields, real or conjugate. With X = A^2 or D^2, A = s1 + s2, D = s1 -
# s2, and sinh and cosh as functions of X,
#
#     exp(B y) = I + B (o(D^2) + o1 (B^2 - D^2)) + B^2 (q(D^2) + q1 (B^2 - D^2)),
#     o(X) = sinh(sqrt(X) y)/sqrt(X),   q(X) = (cosh(sqrt(X) y) - 1)/X,   o1, q1: differences over A^2 - D^2,
#
# which for A = 2, D = 0 is the isotropic one; it carries the factor exp(-A y).
#
# A graded layer is many homogeneous sublayers, extrapolated to infinitely many. A sublayer with the moduli of its
# middle is a symmetric splitting of dm/dz = (k B(z) + gamma D) m, gamma = (ln G)', D = diag(0, 1, 1, 1, 2): its error
# has even powers of the sublayer's thickness only, and Richardson's extrapolation over 1, 2, 3, 4, 5 times as many
# sublayers is of order ten (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, Sec. II.9). B varies
# where not all moduli of a transversely isotropic layer follow the same law. What lies deeper than ``seen`` / (s k)
# below a smooth part's top, s the slowest root, is not felt at that top; sublayers become thinner towards it.


# Where series replace closed forms, and how finely a graded layer is cut.
MINORS_SMALL = 1.0  # y below which the isotropic functions are power series; theory: both hold there to rounding
MINORS_SMALL_TRANSVERSE = 2.0  # the same of A y and |D| y; theory: both hold there to rounding
MINORS_SEEN = 18.0  # theory: exp(-2 seen) is the rounding of a double
# times 1/k, the depth below the top layer from which nothing is felt; theory: 24^4 exp(-2 * 24) is 1e-15 of it
MINORS_FELT = 24.0
MINORS_STEPS = 5  # of the extrapolation; tuned on graded layers, by `make tuning`
MINORS_ACCURACY = 1e-10  # of g, judged by the last of them; tuned on graded layers, by `make tuning`
MINORS_FEWEST = 6  # sublayers in the first of them; tuned on graded layers, by `make tuning`
# theory: ``fewest`` doubled four times; the extrapolation is of order ten, so that these gain 2^40, and what is not
# as accurate by then is not smooth
MINORS_MOST = 96
MINORS_LOOKS = 17  # depths at which a piece's slowest root is looked for; choice: of smooth laws of little contrast
MINORS_STEEP = 6.0  # largest ratio of moduli in one piece; tuned on graded layers, by `make tuning`


_ODD = 1 / np.array([float(math.factorial(n)) for n in range(3, 28, 2)])
_EVEN = 1 / np.array([float(math.factorial(n)) for n in range(4, 29, 2)])


# ---------------------------------------------------------------------- one material
@dataclass(frozen=True)
class LayerMedium:
    """Constants c = C13/C33, beta = C44/C33, e = (C11 - C13^2/C33)/C44 of the minors' equation, in units of C44.

    Numbers, or arrays of the wave numbers' shape.
    """

    c: Any
    beta: Any
    e: Any

    @classmethod
    def isotropic(cls, nu: float) -> LayerMedium:
        """Constants c = lambda/(lambda + 2 G), beta = G/(lambda + 2 G), e = 4 (lambda + G) beta/G."""
        return cls(nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu)), 2 / (1 - nu))

    @classmethod
    def transverse(cls, material: AnyTransverse) -> LayerMedium:
        """Constants of a transversely isotropic material, at its top if graded."""
        one = material.top
        return cls.of(one.E_p, one.E_z, one.nu_p, one.nu_zp, one.G_z)

    @classmethod
    def of(cls, E_p: Any, E_z: Any, nu_p: float, nu_zp: float, G_z: Any) -> LayerMedium:
        """Constants c = p, beta = (G_z/E_z)(1 - 2 nu_zp p), e = E_p/(G_z (1 - nu_p^2)), p = nu_zp E_p/(E_z (1 - nu_p));
        the moduli of any shape."""
        c = nu_zp / (1 - nu_p) * (E_p / E_z)
        return cls(c, G_z / E_z * (1 - 2 * nu_zp * c), E_p / G_z / (1 - nu_p**2))

    @property
    def root(self) -> Any:
        """Product s1 s2 of the roots."""
        return np.sqrt(self.c**2 + self.e * self.beta)

    @property
    def squares(self) -> tuple[Any, Any]:
        """Squares A^2 and D^2 of the sum and the difference of the roots."""
        middle, twice = self.e - 2 * self.c, 2 * self.root
        return middle + twice, middle - twice

    @property
    def slowest(self) -> float:
        """The least real part of s1 and s2: fields die out as exp(-slowest k z), at least."""
        A2, D2 = self.squares
        return float(np.min(np.sqrt(A2) - np.sqrt(np.maximum(D2, 0.0)))) / 2

    @property
    def half_space(self) -> list[float]:
        """Minors of the half-space: where the Riccati equation of F stands still."""
        root = self.root
        rz = (self.c - root) / self.e
        rr = np.sqrt((1 - 2 * rz) / self.e)
        zz = rr * root
        return [1.0, rr, zz, rz, rr * zz - rz**2]

    def powers(self, m: Array) -> Iterator[Array]:
        """Products B m, B^2 m, B^3 m, B^4 m, one after the other."""
        for _ in range(4):
            m = self.generator(m)
            yield m

    def generator(self, m: Array) -> Array:
        """Product B m of the minors' equation."""
        out = np.empty_like(m)
        out[0] = self.e * m[1]
        out[1] = m[0] - 2 * m[3]
        out[2] = self.beta * m[0] + 2 * self.c * m[3] + self.e * m[4]
        out[3] = self.c * m[1] - m[2]
        out[4] = self.beta * m[1] + m[2]
        return out

    def through(self, m: Array, y: Array) -> Array:
        """exp(B y) m exp(-A y): the minors (5, n) one layer of y = k h further up."""
        A2, D2 = self.squares
        o, q, o1, q1 = _transverse_functions(A2, D2, y)
        b1, b2, b3, b4 = self.powers(m)
        once = np.exp(-np.sqrt(A2) * y)
        return once * m + (o - D2 * o1) * b1 + (q - D2 * q1) * b2 + o1 * b3 + q1 * b4


def rescaled(m: Array, ratio: Array | float) -> Array:
    """The minors when F is counted in units of a modulus ``ratio`` times larger; largest entry 1."""
    m = m * ratio
    m[0] /= ratio
    m[4] *= ratio
    return m / np.abs(m).max(axis=0)


def propagate_isotropic(m: Array, y: Array, nu: float) -> Array:
    """exp(B y) m exp(-2 y): the minors (5, n) one layer of y = k h further up."""
    b1, b2, b3, b4 = (_powers(nu) @ m).reshape(4, 5, -1)
    # Exp(-2y), (sinh 2y - 2y) exp(-2y), (cosh 2y - 1 - 2 y^2) exp(-2y)
    x = 2 * y
    once = np.exp(-x)
    twice = once * once
    odd = (1 - twice) / 2 - x * once
    even = (1 + twice) / 2 - (1 + x * x / 2) * once
    small = np.flatnonzero(y < MINORS_SMALL)
    if small.size:  # differences of nearly equal numbers: their power series instead
        s = x[small]
        squares = np.multiply.accumulate(np.broadcast_to(s * s, (_ODD.size, s.size)))
        cube = squares[0] * s * once[small]
        odd[small] = cube * (_ODD[0] + _ODD[1:] @ squares[:-1])
        even[small] = cube * s * (_EVEN[0] + _EVEN[1:] @ squares[:-1])
    return once * m + (once * y) * b1 + (once * y**2 / 2) * b2 + (odd / 8) * b3 + (even / 16) * b4


@lru_cache(maxsize=1024)
def _powers(nu: float) -> Array:
    """B, B^2, B^3, B^4 of an isotropic material, one below the other."""
    return np.concatenate(list(LayerMedium.isotropic(nu).powers(np.eye(5))))


def _transverse_functions(A2: Any, D2: Any, y: Array) -> tuple[Array, Array, Array, Array]:
    """Functions o and q of D^2, o1, q1 of the matrix exponential, all times exp(-A y)."""
    A2, D2 = (np.broadcast_to(X, y.shape) for X in (A2, D2))
    A = np.sqrt(A2)
    o_A, q_A = _hyperbolic(A2, y, A)
    o, q = _hyperbolic(D2, y, A)
    largest = np.sqrt(np.maximum(A2, -D2))  # |D| > A under a stiffness in shear far above the others
    o1, q1 = (o_A - o) / (A2 - D2), (q_A - q) / (A2 - D2)
    small = np.flatnonzero(largest * y < MINORS_SMALL_TRANSVERSE)
    if small.size:  # differences of nearly equal numbers: their power series, of (a^n - b^n)/(a - b)
        x = y[small]
        a, b = A2[small] * x**2, D2[small] * x**2
        term, power, odd, even = np.zeros_like(x), np.ones_like(x), np.zeros_like(x), np.zeros_like(x)
        for for_odd, for_even in zip(_ODD, _EVEN, strict=True):
            term = a * term + power
            power = power * b
            odd += for_odd * term
            even += for_even * term
        decay = x**3 * np.exp(-A[small] * x)
        o1[small], q1[small] = odd * decay, even * decay * x
    return o, q, o1, q1


def _hyperbolic(X: Array, y: Array, A: Array) -> tuple[Array, Array]:
    """Functions o(X) and q(X) of the matrix exponential, times exp(-A y), A >= sqrt(X)."""
    d, real = np.sqrt(np.abs(X)), X >= 0
    x = np.maximum(d * y, 1e-300)
    decay = np.exp(np.where(real, d - A, -A) * y)
    if real.all():
        o, q = -np.expm1(-2 * x) / (2 * x), np.expm1(-x) / x
    elif not real.any():
        o, q = np.sin(x) / x, np.sin(x / 2) / (x / 2)
    else:
        o = np.where(real, -np.expm1(-2 * x) / (2 * x), np.sin(x) / x)
        q = np.where(real, np.expm1(-x) / x, np.sin(x / 2) / (x / 2))
    return y * decay * o, y**2 / 2 * decay * q**2


# ---------------------------------------------------------------------- graded layers
def propagate_graded(m: Array, k: Array, material: AnyGraded, thickness: float) -> Array:
    """Minors (5, n) at the top of a graded layer, in units of its shear modulus there, from those at its bottom, in
    units of that at the bottom; ``k`` (n,) [1/m]. Raises SolveError where the moduli change too quickly."""
    parts = [part for ends in smooth_parts(material.laws, thickness) for part in _gentle_parts(material.laws, *ends)]
    for top, bottom in reversed(parts):
        count, slowest = _sublayers(material, top, bottom)
        steps = range(1, MINORS_STEPS + 1)
        m = _extrapolated([_through_part(m, k, material, (top, bottom), n * count, slowest) for n in steps])
    return m


def _gentle_parts(laws: Sequence[Law], top: float, bottom: float) -> list[tuple[float, float]]:
    """A smooth part halved until no modulus changes by more than the factor ``steep`` in each piece."""
    ends = np.array([law.at(np.array([top, bottom])) for law in laws])
    if np.all(ends.max(axis=1) <= MINORS_STEEP * ends.min(axis=1)):
        return [(top, bottom)]
    middle = (top + bottom) / 2
    return _gentle_parts(laws, top, middle) + _gentle_parts(laws, middle, bottom)


@lru_cache(maxsize=REMEMBERED)
def _sublayers(material: AnyGraded, top: float, bottom: float) -> tuple[int, float]:
    """The number of sublayers in the first step that makes g accurate enough, starting from a rigid base; and the
    slowest root in the part."""
    slowest = slowest_root(material, top, bottom)
    k = np.geomspace(1e-2, 1e3, 12) / (bottom - top)
    start = np.repeat(np.eye(5)[:, :1], k.size, axis=1)
    count = MINORS_FEWEST
    while count <= MINORS_MOST:
        steps = [
            _through_part(start, k, material, (top, bottom), n * count, slowest) for n in range(1, MINORS_STEPS + 1)
        ]
        best, before = _extrapolated(steps), _extrapolated(steps[:-1])
        if np.max(np.abs((before[2] / before[0]) / (best[2] / best[0]) - 1)) < 100 * MINORS_ACCURACY:
            return count, slowest
        count *= 2
    raise SolveError(
        f"layered: the moduli change too quickly between {top:g} and {bottom:g} m below their layer's top for "
        f"{count // 2} sublayers; cut the layer into several, or use a law with less contrast"
    )


def slowest_root(material: Material, top: float = 0.0, bottom: float = 0.0) -> float:
    """The least real part of the roots between two depths [m] of a layer, at most 1: that of an isotropic material."""
    match material:
        case TransverselyIsotropic():
            return min(LayerMedium.transverse(material).slowest, 1.0)
        case GradedTransverselyIsotropic():
            return min(_medium(material, np.linspace(top, bottom, MINORS_LOOKS))[0].slowest, 1.0)
        case _:
            return 1.0


def _medium(material: GradedTransverselyIsotropic, depth: Array) -> tuple[LayerMedium, Array]:
    """Constants and shear modulus [Pa] at every ``depth`` [m]."""
    E_p, E_z, G_z = material.at(depth)
    return LayerMedium.of(E_p, E_z, material.nu_p, material.nu_zp, G_z), G_z


def _through_part(
    m: Array, k: Array, material: AnyGraded, part: tuple[float, float], count: int, slowest: float
) -> Array:
    """Minors after ``count`` homogeneous sublayers between the depths ``part`` [m], from its bottom to its top."""
    top, bottom = part
    seen = np.minimum(bottom - top, MINORS_SEEN / (slowest * k))
    edges = np.linspace(0, 1, 2 * count + 1) ** 2
    modulus = _shear_modulus(material, top + seen)
    for upper, middle, lower in zip(edges[-3::-2], edges[-2::-2], edges[:1:-2], strict=True):
        depth, y = top + seen * middle, k * seen * (lower - upper)
        if isinstance(material, Graded):
            here = material.at(depth)
            m = propagate_isotropic(rescaled(m, here / modulus), y, material.nu)
        else:
            medium, here = _medium(material, depth)
            m = medium.through(rescaled(m, here / modulus), y)
        modulus = here
    return rescaled(m, _shear_modulus(material, np.full_like(k, top)) / modulus)


def _shear_modulus(material: AnyGraded, depth: Array) -> Array:
    """What is proportional to the shear modulus, across the layer if that is not isotropic, at every ``depth`` [m]."""
    return material.at(depth) if isinstance(material, Graded) else material.at(depth)[2]


def _extrapolated(steps: list[Array]) -> Array:
    """The limit of minors from 1, 2, ... times as many sublayers, scaled so that those of positive sign add up to 1."""
    squares = np.arange(1.0, len(steps) + 1) ** 2
    total = np.zeros_like(steps[0])
    for i, m in enumerate(steps):
        weight = np.prod([squares[i] / (squares[i] - other) for j, other in enumerate(squares) if j != i])
        total += weight * m / (m[0] + m[1] + m[2] + m[4])
    return total


# ---------------------------------------------------------------------- stacks
def minors_of(specimen: Specimen, k: Array) -> Array:
    """Minors (5, n) of the whole stack at its surface, up to a positive factor, in units of the modulus there."""
    return propagate(minors_below(specimen, k), k, specimen.layers[0])


def minors_below(specimen: Specimen, k: Array) -> Array:
    """Minors of everything below the top layer, in units of the shear modulus at the bottom of that layer.

    Each wave number begins at the lowest layer that is felt below the top layer: k of many thin layers go far beyond
    the inverse of the whole depth.
    """
    below = specimen.layers[1:]
    order = np.argsort(k)
    k = k[order]
    depths = np.cumsum([0.0, *(each.thickness * slowest_root(each.material, 0.0, each.thickness) for each in below)])
    felt = [k.size, *np.searchsorted(k, MINORS_FELT / depths[1:-1])][: len(below)]  # by the first of them
    match specimen.base:  # its minors, and the shear modulus [Pa] in whose units they are (any, for a rigid base)
        case HalfSpace(material=Elastic(nu=nu, G=G)):
            minors = [1.0, 1 - nu, 1 - nu, nu - 0.5, (3 - 4 * nu) / 4]
        case HalfSpace(material=TransverselyIsotropic(G_z=G) as material):
            minors = LayerMedium.transverse(material).half_space
        case Rigid(bonded=bonded):
            minors, G = [1.0, 0, 0, 0, 0] if bonded else [0.0, 1, 0, 0, 0], 1.0
    m = np.repeat(np.array(minors)[:, None], k.size, axis=1)
    for layer, count in zip(reversed(below), reversed(felt), strict=True):
        top, bottom = shear_moduli(layer)
        if count:
            m[:, :count] = propagate(rescaled(m[:, :count], bottom / G), k[:count], layer)
        G = top
    given = np.empty_like(m)
    given[:, order] = m
    return rescaled(given, shear_moduli(specimen.layers[0])[1] / G)


def propagate(m: Array, k: Array, layer: Layer) -> Array:
    """Minors at the top of a layer, in units of the shear modulus there, from those at its bottom, in units of that."""
    match layer.material:
        case Graded() | GradedTransverselyIsotropic() as material:
            return propagate_graded(m, k, material, layer.thickness)
        case TransverselyIsotropic() as material:
            return LayerMedium.transverse(material).through(m, k * layer.thickness)
        case Elastic(nu=nu):
            return propagate_isotropic(m, k * layer.thickness, nu)


def shear_moduli(layer: Layer) -> tuple[float, float]:
    """Shear modulus [Pa] at the top and at the bottom of a layer, across the layer if that is not isotropic."""
    match layer.material:
        case Graded() as material:
            G, ends = material.surface.G, material.at(np.array([0.0, layer.thickness]))
            return G, G * float(ends[1] / ends[0])
        case GradedTransverselyIsotropic() as material:
            top, bottom = material.at(np.array([0.0, layer.thickness]))[2].tolist()
            return top, bottom
        case TransverselyIsotropic(G_z=G_z):
            return G_z, G_z
        case Elastic(G=G):
            return G, G


# --------------------------------------------------------------------------------------------------
# The part of g - 1 that decays slowly: a modulus that changes right below the contact.
#
# Below the surface of a layer with shear modulus G(z), gamma = (ln G)', the compliance matrix F in units of the local
# 1/(k G) obeys, z downwards (the equation behind the ``minors``),
#
#     F' = -k R(F) + gamma F,      R = (1 - 2 F_rz - e F_rr^2, beta + 2 c F_rz - e F_rz^2, c F_rr - F_zz - e F_rr F_rz).
#
# For large k it has the solution F = F_0 + F_1/k + F_2/k^2 + ..., F_0 of the half-space and, order by order, J
# F_(n+1) = gamma F_n - F_n' - (products of lower orders) with J = dR/dF at F_0. That gives g - 1 ~ sum c_n/k^n, wrong
# only by what the end of the smooth part, in the depth d, sends back: exp(-2 k d). With c_1 = -gamma (1 - nu/2)/(1 -
# nu) the kernel of the contact equation has a logarithm at x = t. The sum is taken over in terms that exist for every
# k >= 0,
#
#     t(k) = sum b_n (k^2 + q^2)^(-n/2),
#     int_0^inf t(k) cos(ks) dk = sum b_n sqrt(pi)/Gamma(n/2) (s/2q)^m K_m(qs),   m = (n - 1)/2
#
# (Basset's integral, Abramowitz and Stegun 9.6.25), and the rest of g - 1 decays like k^-(count + 1).

COUNT = 6  # terms of the tail; tuned on graded layers, by `make tuning`


@dataclass(frozen=True, eq=False)
class Tail:
    """Slowly decaying part t(k) of g - 1, with ``coefficients`` b_n [m^-n], n = 1, 2, ..., and q = ``rate`` [1/m];
    ``finest``: the length [m] over which the modulus changes below the surface."""

    coefficients: Array
    rate: float
    finest: float

    @classmethod
    def of(cls, specimen: Specimen, indenter: Solid | None = None) -> Tail | None:
        """Tail of g - 1 of ``specimen`` under an ``indenter``; None where g - 1 decays exponentially."""
        material = specimen.layers[0].material if specimen.layers else None
        if not isinstance(material, AnyGraded):
            return None
        c = surface_series(material, COUNT)[1:]
        rate = float(np.max(np.abs(c) ** (1 / np.arange(1, COUNT + 1))))
        if rate * specimen.top_thickness < 1e-12:  # rounding
            return None
        _, smooth = smooth_parts(material.laws, specimen.top_thickness)[0]
        smooth *= slowest_root(material, 0.0, smooth)
        factor = contact_modulus(specimen.surface, indenter) / specimen.surface.E_star
        return cls(factor * regularised(c, rate), rate, min(smooth, 1 / rate))

    @property
    def strength(self) -> float:
        """|b_1| [1/m], the factor of the kernel's logarithm."""
        return abs(float(self.coefficients[0]))

    def __call__(self, k: Array) -> Array:
        """t(k) [-]."""
        root = 1 / np.sqrt(k**2 + self.rate**2)
        return root * np.polynomial.polynomial.polyval(root, self.coefficients)

    def transform(self, s: Array) -> Array:
        """int_0^inf t(k) cos(ks) dk [1/m] at s > 0 [m]: like -b_1 ln(s) for s -> 0."""
        from scipy.special import k0e, k1e

        x = self.rate * s
        decay = np.exp(-x)
        whole = [k0e(x) * decay, x * k1e(x) * decay]  # x^m K_m(x), m = 0, 1, ...
        half = [math.sqrt(math.pi / 2) * decay, math.sqrt(math.pi / 2) * (1 + x) * decay]  # m = 1/2, 3/2, ...
        total = np.zeros_like(x)
        for n, b in enumerate(self.coefficients, start=1):
            m = (n - 1) / 2
            ladder, step = (whole, (n - 1) // 2) if n % 2 else (half, n // 2 - 1)
            if step == len(ladder):
                ladder.append(x**2 * ladder[-2] + 2 * (m - 1) * ladder[-1])
            total += b * math.sqrt(math.pi) / math.gamma(n / 2) / (2 * self.rate**2) ** m * ladder[step]
        return total


def surface_series(material: AnyGraded, count: int) -> Array:
    """Coefficients c_0 = 1, c_1, ..., c_count [m^-n] of g ~ sum c_n/k^n at the top of a graded layer.

    All quantities are power series in z, cut after z^count. F_0 is where R = 0 at every depth; then, order by order,
    J F_(n+1) = gamma F_n - F_n' - (products of lower orders).
    """
    size = count + 1
    medium, taylor = _surface_medium(material, size + 1)
    rates = divided(taylor[1:] * np.arange(1, taylor.size), taylor)  # gamma = G'/G
    c, beta, e = (series[:size] for series in (medium.c, medium.beta, medium.e))
    one = np.eye(1, size)[0]

    def R(rr: Array, zz: Array, rz: Array) -> Array:
        return np.array(
            [
                one - 2 * rz - _product(e, _product(rr, rr)),
                beta + 2 * _product(c, rz) - _product(e, _product(rz, rz)),
                _product(c, rr) - zz - _product(e, _product(rr, rz)),
            ]
        )

    F_0 = np.outer(LayerMedium(c[0], beta[0], e[0]).half_space[1:4], one)
    J = _jacobian(c, e, F_0)
    for n in range(1, size):
        F_0[:, n] = -np.linalg.solve(J[:, :, 0], R(*F_0)[:, n])
    F, J = [F_0], _jacobian(c, e, F_0)
    for n in range(count):
        right = np.array([_product(rates, f) for f in F[n]])
        right[:, :-1] -= F[n][:, 1:] * np.arange(1, size)
        for a, b in zip(F[1:], reversed(F[1:]), strict=True):
            products = np.array([_product(a[0], b[0]), _product(a[2], b[2]), _product(a[0], b[2])])
            right += np.array([_product(e, product) for product in products])
        following = np.zeros_like(right)
        for j in range(size):
            carried = sum((J[:, :, i] @ following[:, j - i] for i in range(1, j + 1)), np.zeros(3))
            following[:, j] = np.linalg.solve(J[:, :, 0], right[:, j] - carried)
        F.append(following)
    return np.array([f[1, 0] for f in F]) / F_0[1, 0]


def _surface_medium(material: AnyGraded, size: int) -> tuple[LayerMedium, Array]:
    """Constants as power series of depth at a layer's top, ``size`` terms; and that of the shear modulus over its value
    at the top."""
    one = np.eye(1, size)[0]
    if isinstance(material, Graded):
        isotropic = LayerMedium.isotropic(material.nu)
        return LayerMedium(isotropic.c * one, isotropic.beta * one, isotropic.e * one), material.law.taylor(size)
    top = LayerMedium.transverse(material)
    E_p, E_z, G_z = (m.taylor(size) if isinstance(m, Law) else one for m in material.moduli.values())
    c = top.c * divided(E_p, E_z)
    share = 2 * material.nu_zp * c
    beta = top.beta / (1 - share[0]) * _product(divided(G_z, E_z), one - share)
    return LayerMedium(c, beta, top.e * divided(E_p, G_z)), G_z


def _jacobian(c: Array, e: Array, F: Array) -> Array:
    """dR/dF (3, 3, n) at F = (F_rr, F_zz, F_rz), as power series."""
    none, one = np.zeros_like(c), np.eye(1, c.size)[0]
    e_rr, e_rz = _product(e, F[0]), _product(e, F[2])
    return np.array(
        [
            [-2 * e_rr, none, -2 * one],
            [none, none, 2 * (c - e_rz)],
            [c - e_rz, -one, -e_rr],
        ]
    )


def divided(series: Array, divisor: Array) -> Array:
    """Quotient of two power series, as long as the first."""
    quotient = np.zeros_like(series)
    for n in range(series.size):
        quotient[n] = (series[n] - divisor[1 : n + 1] @ quotient[:n][::-1]) / divisor[0]
    return quotient


def _product(a: Array, b: Array) -> Array:
    """Product of two power series, cut at their length."""
    return np.convolve(a, b)[: a.size]


def regularised(c: Array, rate: float) -> Array:
    """Coefficients b with sum b_n (k^2 + q^2)^(-n/2) = sum c_n k^-n up to the last term."""
    b = c.copy()
    for n in range(1, c.size + 1):
        term = 1.0
        for j in range(1, (c.size - n) // 2 + 1):
            term *= -(n / 2 + j - 1) / j * rate**2
            b[n + 2 * j - 1] -= b[n - 1] * term
    return b


# How far and how finely g(k) is resolved.
SPECTRUM_SAMPLES = 16  # Gauss nodes per panel on which it is judged; tuned on reference bodies, by `make tuning`
SPECTRUM_LAST = 1e-10  # coefficients of g on a panel, relative; theory: Gauss quadrature squares this
SPECTRUM_NOISE = 1e-14  # theory: 50 times machine epsilon, the rounding of g - 1 and of its coefficients
SPECTRUM_FLOOR = 1e-12  # |g - 1| beyond k_max; tuned on reference bodies, by `make tuning`
SPECTRUM_GRADED_FLOOR = 1e-9  # the same of graded layers; choice: there g is accurate to 1e-10
SPECTRUM_PHASE = 1e-14  # error of a panel of (g - 1) cos(k s); theory: 50 times machine epsilon
SPECTRUM_ORDERS = (1, 2, 4)  # choice: times as many nodes on a panel; more save another tenth
SPECTRUM_START = 0.012  # CPU seconds of any stack; tuned on the cases of `make bench`, by `make bench`
SPECTRUM_LAYER_SECONDS = 1e-3  # and of a layer; tuned on stacks of 50 to 1000 layers, by `make bench`
SPECTRUM_GRADED_SECONDS = 0.1  # and of a smooth piece of a law; tuned on tables of 10 to 100 points, by `make bench`
SPECTRUM_TRANSVERSE = 3.0  # choice: times as much where it is transversely isotropic, where 2.5 to 3.2 was measured
SPECTRUM_HALVINGS = 60  # theory: the panel from k = 0 is then 2^-60 of k_max, below all that counts
SPECTRUM_NARROWEST = 1e-12  # panel over its k; theory: g varies over k itself, and that is far below
# octaves below the first node of the panel from k = 0, in which g is looked for, each at two places;
# theory: as wave numbers, all that counts of layers 1e-15 times as thin as the depth
SPECTRUM_BELOW = 50


def deviation(specimen: Specimen, k: Array, indenter: Solid | None = None) -> Array:
    """Deviation g(k) - 1 at the wave numbers ``k`` >= 0 [1/m], shape of ``k``; small values keep their relative
    accuracy.

    With an elastic ``indenter`` g belongs to both bodies together, normalised by E* of the surfaces: compliances add,
    C = 2 g/(E* k) = 2 g_1/(E*_1 k) + 2 g_2/(E*_2 k), so that g - 1 = sum (E*/E*_i)(g_i - 1); a half-space adds none.
    """
    bodies = weighed_stacks(specimen, indenter)
    return sum((share * compliance(body, k)[1] for body, share in bodies), np.zeros(np.shape(k)))


def weighed_stacks(specimen: Specimen, indenter: Solid | None) -> tuple[tuple[Specimen, float], ...]:
    """The bodies whose compliance is not that of a half-space, each with E*/E*_i."""
    bodies, E_star = stacks(specimen, indenter), contact_modulus(specimen.surface, indenter)
    return tuple((body, E_star / body.surface.E_star) for body in bodies)


def compliance(specimen: Specimen, k: Array) -> Array:
    """g(k) and g(k) - 1 of a stack (2, ...) at the wave numbers ``k`` >= 0 [1/m], each accurate relative to itself."""
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.stack([np.ones_like(k), np.zeros_like(k)])
    # minors over a sliding base vanish at 0 itself
    positive = np.maximum(np.ravel(k), 1e-30 / specimen.layers[0].thickness)
    return _of_stack(specimen, positive).reshape(2, *k.shape)


def _of_stack(specimen: Specimen, k: Array) -> Array:
    top, nu = specimen.layers[0], specimen.surface.nu
    if not isinstance(top.material, Elastic):
        half_space = 2 * shear_moduli(top)[0] / specimen.surface.E_star  # F_zz in units of 1/G at the surface
        g = _over(minors_of(specimen, k), half_space)
        return np.array([g, g - 1])
    below = minors_below(specimen, k)
    y = k * top.thickness
    dev = np.empty_like(k)
    g = np.empty_like(k)
    small = y < MINORS_SMALL
    g[small] = _over(propagate_isotropic(below[:, small], y[small], nu), 1 - nu)
    dev[small] = g[small] - 1
    dev[~small] = _far(below[:, ~small], y[~small], nu)
    g[~small] = 1 + dev[~small]
    return np.array([g, dev])


def _over(m: Array, half_space: float) -> Array:
    """Compliance ratio g from the minors at the surface."""
    return m[2] / (half_space * m[0])


def _far(m: Array, y: Array, nu: float) -> Array:
    """Deviation g - 1 for a thick top layer: its growing part, a half-space, is taken out of exp(B y) before any
    subtraction."""
    b1, b2, b3, b4 = LayerMedium.isotropic(nu).powers(m)
    once = np.exp(-2 * y)
    twice = once * once

    def excess(v: Array) -> Array:
        return v[2] - (1 - nu) * v[0]

    decaying = once * (
        excess(m) + y * (excess(b1) - excess(b3) / 4) + y**2 * (excess(b2) / 2 - excess(b4) / 8) - excess(b4) / 16
    ) + twice * (excess(b4) / 32 - excess(b3) / 16)
    return decaying / ((1 - nu) * propagate_isotropic(m, y, nu)[0])


@dataclass(frozen=True, eq=False)
class LayeredSpectrum:
    """Spectrum g(k) - 1 of one pair of bodies, with the panels in k on which it is resolved; makes kernels of any
    reach. ``least``: what is left of the rest beyond k_max where it decays like a power of k."""

    specimen: Specimen
    indenter: Solid | None = None
    least: float = SPECTRUM_GRADED_FLOOR

    def __call__(self, k: Array) -> Array:
        rest = deviation(self.specimen, k, self.indenter)
        return rest if self.tail is None else rest - self.tail(k)

    @property
    def bodies(self) -> tuple[tuple[Specimen, float], ...]:
        """What is not a half-space, with its share of the compliance."""
        return weighed_stacks(self.specimen, self.indenter)

    @cached_property
    def tail(self) -> Tail | None:
        """The slowly decaying part of g - 1."""
        return Tail.of(self.specimen, self.indenter)

    @property
    def floor(self) -> float:
        """Size of the rest beyond k_max."""
        return SPECTRUM_FLOOR if self.tail is None else self.least

    @cached_property
    def scan(self) -> tuple[Array, Array]:
        """Wave numbers [1/m], decreasing, and the rest there."""
        # The length [m] over which the bodies change below the surface, as far as the contact feels it
        lengths = []
        for body, _ in self.bodies:
            top, own = body.layers[0], self.tail if body is self.specimen else None
            slowest = slowest_root(top.material, 0.0, top.thickness)
            lengths.append(top.thickness * slowest if own is None else own.finest)
        finest = min(lengths)
        k = 2.0 ** np.arange(5.5, -60.0, -0.5) / finest
        return k, self(k)

    def bandwidth(self, level: float) -> float:
        """The k [1/m] beyond which the rest is below ``level``; 0 for a homogeneous half-space."""
        if not self.bodies:
            return 0.0
        k, size = self.scan[0], np.abs(self.scan[1])
        above = np.flatnonzero(size >= level)
        if not above.size or above[0] == 0:
            return float(k[0]) if above.size else 0.0
        i = above[0]
        ends = np.log(np.maximum(size[[i - 1, i]], 1e-3 * level))
        return float(np.exp(np.interp(math.log(level), ends, np.log(k[[i - 1, i]]))))

    @cached_property
    def scale(self) -> float:
        """The length over which the kernel varies [m]: h for one layer, whose |g - 1| is 1e-6 at k h of 8 to 9."""
        if self.bandwidth(self.floor) == 0:
            return np.inf
        waves, level = (9, 1e-6) if self.tail is None else (5, 1e-3)  # a tail needs less accuracy
        return waves / self.bandwidth(min(level, 0.01 * float(np.max(np.abs(self.scan[1])))))

    @cached_property
    def panels(self) -> tuple[Array, Array, Array]:
        """Ends lo, hi [1/m] of panels that resolve g, down to k = 0, and the rest at the nodes of each."""
        return resolved(self, *self.octaves, self.tail)

    @property
    def octaves(self) -> tuple[Array, Array]:
        """Ends lo, hi [1/m] of the panels that ``panels`` are halves of; none for a homogeneous half-space."""
        k_max = self.bandwidth(self.floor)
        edges = np.append(0.0, k_max * 2.0 ** np.arange(-6, 1) if k_max else [])
        return edges[:-1], edges[1:]

    def nodes(self, reach: float, order: int) -> tuple[Array, Array, Array]:
        """Wave numbers and weights [1/m] of ``order`` Gauss nodes on every panel, cut for all x, t with x + t <=
        ``reach`` [m], and the number of each one's panel; over many wave lengths wider panels of more nodes, which are
        fewer in all."""
        lo, hi, values = self.panels
        allowed = SPECTRUM_PHASE / np.clip(np.max(np.abs(values), axis=1), 1e-12, 1.0)

        def cut(order: int) -> Array:
            turn = reach / phase_allowed(order - 5, allowed)
            return np.maximum(np.ceil((hi - lo) * turn), 1).astype(int)

        order = min((order * times for times in SPECTRUM_ORDERS), key=lambda order: order * int(cut(order).sum()))
        pieces = cut(order)
        return *gauss(*split(lo, hi, pieces), *rule(order)), np.repeat(np.arange(lo.size), order * pieces)

    def kernel(self, reach: float, order: int = 24) -> CosineKernel:
        """Kernel for all x, t with x + t <= ``reach`` [m], from ``order`` Gauss nodes in k on every panel."""
        k, w, panel = self.nodes(reach, order)
        if self.specimen.is_graded:
            # The rest at k, each on the panel of the given index: cheaper than g itself through graded layers
            lo, hi, values = self.panels
            local = (2 * k - lo[panel] - hi[panel]) / (hi - lo)[panel]
            rest = legendre.legval(local, (values @ to_legendre(SPECTRUM_SAMPLES)).T[:, panel], tensor=False)
        else:
            rest = self(k)
        return CosineKernel(k, w * rest, self.scale)


def spectrum_seconds(problem: Problem) -> float:
    """CPU seconds to resolve the spectrum of the bodies and evaluate its kernels, about; a single look takes half."""
    specimen = problem.specimen
    graded = SPECTRUM_GRADED_SECONDS * (2 + specimen.pieces) if specimen.is_graded else 0.0
    if any(isinstance(material, GradedTransverselyIsotropic) for material in specimen.materials):
        graded *= SPECTRUM_TRANSVERSE
    return SPECTRUM_START + SPECTRUM_LAYER_SECONDS * len(problem.layers) + graded


def resolved(
    function: Callable[[Array], Array], lo: Array, hi: Array, tail: Callable[[Array], Array] | None = None
) -> tuple[Array, Array, Array]:
    """Panels, cut until ``function`` = g - 1, less its ``tail``, is a polynomial on each, to ``SPECTRUM_LAST`` of g.

    Returns the ends and the values at the Gauss nodes of each. An error of g relative to g itself is what counts: S is
    the minimum of a quadratic form with the symbol g > 0. Panels are halved; one that begins at k = 0 is cut into
    octaves down to what lies below its first node.
    """
    done: list[tuple[Array, Array, Array]] = []
    project = to_legendre(SPECTRUM_SAMPLES)
    for _ in range(SPECTRUM_HALVINGS):
        k, _ = gauss(lo, hi, *rule(SPECTRUM_SAMPLES))
        values = function(k).reshape(lo.size, SPECTRUM_SAMPLES)
        size = np.max(np.abs(values), axis=1)
        g = 1 + values if tail is None else 1 + values + tail(k).reshape(values.shape)
        coefficients, allowed = values @ project, SPECTRUM_LAST * np.max(g, axis=1) + SPECTRUM_NOISE * size
        good = np.max(np.abs(coefficients[:, -2:]), axis=1) <= allowed
        octaves = np.zeros(0)
        if lo.size and lo[0] == 0 and good[0]:
            # Down to the largest k below the first node at which the function is not the Legendre series: it may be off
            # by what is allowed at that node, and by more like 1/k below, where its integral is no more
            first = hi[0] * (1 + rule(SPECTRUM_SAMPLES)[0][0]) / 2
            k = first * 2.0 ** np.arange(-0.5, -SPECTRUM_BELOW, -0.5)
            off = np.abs(function(k) - legendre.legval(2 * k / hi[0] - 1, coefficients[0]))
            missed = k[off * k > (allowed[0] + len(project) * SPECTRUM_NOISE * size[0]) * first]
            if missed.size:
                good[0] = False
                octaves = np.append(0.0, hi[0] * 2.0 ** np.arange(-math.ceil(math.log2(hi[0] / missed[0])), 1))
        if (rough := lo[~good & (hi - lo < SPECTRUM_NARROWEST * hi)]).size:
            break
        done.append((lo[good], hi[good], values[good]))
        if good.all():
            return tuple(np.concatenate(parts) for parts in zip(*done, strict=True))  # type: ignore[return-value]
        halved = ~good & ((lo > 0) | (octaves.size == 0))
        lo, hi = split(lo[halved], hi[halved], np.full(int(halved.sum()), 2))
        lo, hi = np.append(octaves[:-1], lo), np.append(octaves[1:], hi)
    raise SolveError(
        f"layered: the compliance spectrum is not smooth near k = {np.append(rough, lo)[0]:g} 1/m; "
        "check the thicknesses and moduli of the layers"
    )

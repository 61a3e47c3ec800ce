"""Compliance of what lies below a depth, as minors, and their way up through the layers of a stack.

The material below a depth is described by its compliance matrix F: displacements (u_r, u_z) = F (T_r, T_z)/(G k), with
T the tractions on it. Upwards through a layer, zeta = k z, F obeys a Riccati equation; its five minors

    m = m_0 (1, F_rr, F_zz, F_rz, det F)

obey a linear one, dm/dzeta = B m (the delta-matrix method, Dunkin 1965). In an isotropic material B has the eigenvalues
0 (triple), 2 and -2, so

    exp(B y) = I + B y + B^2 y^2/2 + B^3 (sinh 2y - 2y)/8 + B^4 (cosh 2y - 1 - 2 y^2)/16,        y = k h,

which is used with the factor exp(-2 y) throughout: nothing overflows, nothing cancels at small y, and nu = 1/2 is an
ordinary value. A rigid base that allows sliding has infinite F_rr, but ordinary minors.

A transversely isotropic material differs by the constants in B: the eigenvalues are 0, +-(s1 + s2), +-(s1 - s2), where
exp(-s_j k z) are the half-space's two fields, real or conjugate. With X = A^2 or D^2, A = s1 + s2, D = s1 - s2, and
sinh and cosh as functions of X,

    exp(B y) = I + B (o(D^2) + o1 (B^2 - D^2)) + B^2 (q(D^2) + q1 (B^2 - D^2)),
    o(X) = sinh(sqrt(X) y)/sqrt(X),   q(X) = (cosh(sqrt(X) y) - 1)/X,   o1, q1: differences over A^2 - D^2,

which for A = 2, D = 0 is the isotropic one; it carries the factor exp(-A y).

A graded layer is many homogeneous sublayers, extrapolated to infinitely many. A sublayer with the modulus of its middle
is a symmetric splitting of dm/dz = (k B + gamma D) m, gamma = (ln G)', D = diag(0, 1, 1, 1, 2): its error has even
powers of the sublayer's thickness only, and Richardson's extrapolation over 1, 2, 3, 4, 5 times as many sublayers is of
order ten (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, Sec. II.9). What lies deeper than
``seen`` / k below a smooth part's top is not felt at that top; sublayers become thinner towards it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...base import REMEMBERED, Array, SolveError
from ...bodies import Elastic, Graded, HalfSpace, Law, Layer, Rigid, Specimen, TransverselyIsotropic


@dataclass(frozen=True)
class MinorsTuning:
    """Where series replace closed forms, and how finely a graded layer is cut."""

    small: float = 1.0  # y below which the isotropic functions are power series; theory: both hold there to rounding
    small_transverse: float = 2.0  # the same of A y and |D| y; theory: both hold there to rounding
    terms: int = 14  # of the transverse series; theory: the next are below rounding at ``small_transverse``
    seen: float = 18.0  # theory: exp(-2 seen) is the rounding of a double
    steps: int = 5  # of the extrapolation; tuned on graded layers, by `make tuning`
    accuracy: float = 1e-10  # of g, judged by the last of them; tuned on graded layers, by `make tuning`
    fewest: int = 6  # sublayers in the first of them; tuned on graded layers, by `make tuning`
    # theory: ``fewest`` doubled four times; the extrapolation is of order ten, so that these gain 2^40, and what is not
    # as accurate by then is not smooth
    most: int = 96
    steep: float = 6.0  # largest ratio of moduli in one piece; tuned on graded layers, by `make tuning`


TUNING = MinorsTuning()
_ODD = 1 / np.array([float(math.factorial(n)) for n in range(3, 28, 2)])
_EVEN = 1 / np.array([float(math.factorial(n)) for n in range(4, 29, 2)])


# ---------------------------------------------------------------------- one material
@dataclass(frozen=True)
class Medium:
    """Constants c = C13/C33, beta = C44/C33, e = (C11 - C13^2/C33)/C44 of the minors' equation, in units of C44."""

    c: float
    beta: float
    e: float

    @classmethod
    def isotropic(cls, nu: float) -> Medium:
        """Constants c = lambda/(lambda + 2 G), beta = G/(lambda + 2 G), e = 4 (lambda + G) beta/G."""
        return cls(nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu)), 2 / (1 - nu))

    @classmethod
    def transverse(cls, material: TransverselyIsotropic) -> Medium:
        C11, _, C13, C33, C44 = material.stiffness
        return cls(C13 / C33, C44 / C33, (C11 - C13**2 / C33) / C44)

    @cached_property
    def _root(self) -> float:
        """Product s1 s2 of the roots."""
        return math.sqrt(self.c**2 + self.e * self.beta)

    @property
    def squares(self) -> tuple[float, float]:
        """Squares A^2 and D^2 of the sum and the difference of the roots."""
        middle = self.e - 2 * self.c
        return middle + 2 * self._root, middle - 2 * self._root

    @property
    def slowest(self) -> float:
        """The lesser real part of s1 and s2: fields die out as exp(-slowest k z)."""
        A2, D2 = self.squares
        return (math.sqrt(A2) - math.sqrt(max(D2, 0.0))) / 2

    @property
    def half_space(self) -> list[float]:
        """Minors of the half-space: where the Riccati equation of F stands still."""
        rz = (self.c - self._root) / self.e
        rr = math.sqrt((1 - 2 * rz) / self.e)
        zz = rr * self._root
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
        once = np.exp(-math.sqrt(A2) * y)
        return once * m + (o - D2 * o1) * b1 + (q - D2 * q1) * b2 + o1 * b3 + q1 * b4


def rescaled(m: Array, ratio: Array | float) -> Array:
    """The minors when F is counted in units of a modulus ``ratio`` times larger; largest entry 1."""
    m = m * ratio
    m[0] /= ratio
    m[4] *= ratio
    return m / np.abs(m).max(axis=0)


def through_isotropic(m: Array, y: Array, nu: float) -> Array:
    """exp(B y) m exp(-2 y): the minors (5, n) one layer of y = k h further up."""
    b1, b2, b3, b4 = (_powers(nu) @ m).reshape(4, 5, -1)
    once, odd, even = _isotropic_functions(y)
    return once * m + (once * y) * b1 + (once * y**2 / 2) * b2 + (odd / 8) * b3 + (even / 16) * b4


@lru_cache(maxsize=1024)
def _powers(nu: float) -> Array:
    """B, B^2, B^3, B^4 of an isotropic material, one below the other."""
    return np.concatenate(list(Medium.isotropic(nu).powers(np.eye(5))))


def _isotropic_functions(y: Array) -> tuple[Array, Array, Array]:
    """exp(-2y), (sinh 2y - 2y) exp(-2y), (cosh 2y - 1 - 2 y^2) exp(-2y)."""
    x = 2 * y
    once = np.exp(-x)
    twice = once * once
    odd = (1 - twice) / 2 - x * once
    even = (1 + twice) / 2 - (1 + x * x / 2) * once
    small = np.flatnonzero(y < TUNING.small)
    if small.size:  # differences of nearly equal numbers: their power series instead
        s = x[small]
        squares = np.multiply.accumulate(np.broadcast_to(s * s, (_ODD.size, s.size)))
        cube = squares[0] * s * once[small]
        odd[small] = cube * (_ODD[0] + _ODD[1:] @ squares[:-1])
        even[small] = cube * s * (_EVEN[0] + _EVEN[1:] @ squares[:-1])
    return once, odd, even


def _transverse_functions(A2: float, D2: float, y: Array) -> tuple[Array, Array, Array, Array]:
    """Functions o and q of D^2, o1, q1 of the matrix exponential, all times exp(-A y)."""
    A = math.sqrt(A2)
    o_A, q_A = _hyperbolic(A2, y, A)
    o, q = _hyperbolic(D2, y, A)
    largest = math.sqrt(max(A2, -D2))  # |D| > A under a stiffness in shear far above the others
    x = np.minimum(y, TUNING.small_transverse / largest)
    odd, even, power = np.zeros_like(y), np.zeros_like(y), 1.0
    difference = 0.0
    for n in range(1, TUNING.terms + 1):
        difference, power = A2 * difference + power, power * D2
        odd += difference * x ** (2 * n + 1) / math.factorial(2 * n + 1)
        even += difference * x ** (2 * n + 2) / math.factorial(2 * n + 2)
    small, decay = largest * y < TUNING.small_transverse, np.exp(-A * x)
    o1 = np.where(small, odd * decay, (o_A - o) / (A2 - D2))
    q1 = np.where(small, even * decay, (q_A - q) / (A2 - D2))
    return o, q, o1, q1


def _hyperbolic(X: float, y: Array, A: float) -> tuple[Array, Array]:
    """Functions o(X) and q(X) of the matrix exponential, times exp(-A y), A >= sqrt(X)."""
    d = math.sqrt(abs(X))
    x = np.maximum(d * y, 1e-300)
    if X < 0:
        decay = np.exp(-A * y)
        return y * decay * np.sin(x) / x, y**2 / 2 * decay * (np.sin(x / 2) / (x / 2)) ** 2
    decay = np.exp((d - A) * y)
    return y * decay * -np.expm1(-2 * x) / (2 * x), y**2 / 2 * decay * (np.expm1(-x) / x) ** 2


# ---------------------------------------------------------------------- graded layers
def through_graded(m: Array, k: Array, material: Graded, thickness: float) -> Array:
    """Minors (5, n) at the top of a graded layer, in units of its shear modulus there, from those at its bottom, in
    units of that at the bottom; ``k`` (n,) [1/m]. Raises SolveError where the modulus changes too quickly."""
    parts = [part for ends in smooth_parts(material.law, thickness) for part in _gentle_parts(material.law, *ends)]
    for top, bottom in reversed(parts):
        count = _sublayers(material, top, bottom, TUNING)
        m = _extrapolated([_through_part(m, k, material, top, bottom, n * count) for n in range(1, TUNING.steps + 1)])
    return m


def smooth_parts(law: Law, thickness: float) -> Iterator[tuple[float, float]]:
    """Depths [m] between which the law is smooth, from the top down."""
    return itertools.pairwise([0.0, *(z for z in law.kinks if z < thickness), thickness])


def _gentle_parts(law: Law, top: float, bottom: float) -> list[tuple[float, float]]:
    """A smooth part halved until the modulus changes by no more than the factor ``steep`` in each piece."""
    ends = law.at(np.array([top, bottom]))
    if ends.max() <= TUNING.steep * ends.min():
        return [(top, bottom)]
    middle = (top + bottom) / 2
    return _gentle_parts(law, top, middle) + _gentle_parts(law, middle, bottom)


@lru_cache(maxsize=REMEMBERED)
def _sublayers(material: Graded, top: float, bottom: float, tuning: MinorsTuning) -> int:
    """The number of sublayers in the first step that makes g accurate enough, starting from a rigid base."""
    k = np.geomspace(1e-2, 1e3, 12) / (bottom - top)
    start = np.repeat(np.eye(5)[:, :1], k.size, axis=1)
    count = tuning.fewest
    while count <= tuning.most:
        steps = [_through_part(start, k, material, top, bottom, n * count) for n in range(1, tuning.steps + 1)]
        best, before = _extrapolated(steps), _extrapolated(steps[:-1])
        if np.max(np.abs((before[2] / before[0]) / (best[2] / best[0]) - 1)) < 100 * tuning.accuracy:
            return count
        count *= 2
    raise SolveError(
        f"layered: the modulus changes too quickly between {top:g} and {bottom:g} m below its layer's top for "
        f"{count // 2} sublayers; cut the layer into several, or use a law with less contrast"
    )


def _through_part(m: Array, k: Array, material: Graded, top: float, bottom: float, count: int) -> Array:
    """Minors after ``count`` homogeneous sublayers between the depths ``bottom`` and ``top`` [m]."""
    seen = np.minimum(bottom - top, TUNING.seen / k)
    edges = np.linspace(0, 1, 2 * count + 1) ** 2
    modulus = material.at(top + seen)
    for upper, middle, lower in zip(edges[-3::-2], edges[-2::-2], edges[:1:-2], strict=True):
        here = material.at(top + seen * middle)
        m = through_isotropic(rescaled(m, here / modulus), k * seen * (lower - upper), material.nu)
        modulus = here
    return rescaled(m, material.at(np.full_like(k, top)) / modulus)


def _extrapolated(steps: list[Array]) -> Array:
    """The limit of minors from 1, 2, ... times as many sublayers, scaled so that those of positive sign add up to 1."""
    squares = np.arange(1.0, len(steps) + 1) ** 2
    total = np.zeros_like(steps[0])
    for i, m in enumerate(steps):
        weight = np.prod([squares[i] / (squares[i] - other) for j, other in enumerate(squares) if j != i])
        total += weight * m / (m[0] + m[1] + m[2] + m[4])
    return total


# ---------------------------------------------------------------------- stacks
def _base(base: Rigid | HalfSpace, size: int) -> tuple[Array, float]:
    """Minors of the base, and the shear modulus [Pa] in whose units they are (any, for a rigid base)."""
    match base:
        case HalfSpace(material=Elastic(nu=nu, G=G)):
            minors = [1.0, 1 - nu, 1 - nu, nu - 0.5, (3 - 4 * nu) / 4]
        case HalfSpace(material=TransverselyIsotropic(G_z=G) as material):
            minors = Medium.transverse(material).half_space
        case Rigid(bonded=bonded):
            minors, G = [1.0, 0, 0, 0, 0] if bonded else [0.0, 1, 0, 0, 0], 1.0
    return np.repeat(np.array(minors)[:, None], size, axis=1), G


def minors_of(specimen: Specimen, k: Array) -> Array:
    """Minors (5, n) of the whole stack at its surface, up to a positive factor, in units of the modulus there."""
    return upwards(minors_below(specimen, k), k, specimen.layers[0])


def minors_below(specimen: Specimen, k: Array) -> Array:
    """Minors of everything below the top layer, in units of the shear modulus at the bottom of that layer."""
    m, G = _base(specimen.base, k.size)
    for layer in reversed(specimen.layers[1:]):
        top, bottom = shear_moduli(layer)
        m, G = upwards(rescaled(m, bottom / G), k, layer), top
    return rescaled(m, shear_moduli(specimen.layers[0])[1] / G)


def upwards(m: Array, k: Array, layer: Layer) -> Array:
    """Minors at the top of a layer, in units of the shear modulus there, from those at its bottom, in units of that."""
    match layer.material:
        case Graded() as material:
            return through_graded(m, k, material, layer.thickness)
        case TransverselyIsotropic() as material:
            return Medium.transverse(material).through(m, k * layer.thickness)
        case Elastic(nu=nu):
            return through_isotropic(m, k * layer.thickness, nu)


def shear_moduli(layer: Layer) -> tuple[float, float]:
    """Shear modulus [Pa] at the top and at the bottom of a layer, across the layer if that is not isotropic."""
    match layer.material:
        case Graded() as material:
            G, ends = material.surface.G, material.at(np.array([0.0, layer.thickness]))
            return G, G * float(ends[1] / ends[0])
        case TransverselyIsotropic(G_z=G_z):
            return G_z, G_z
        case Elastic(G=G):
            return G, G

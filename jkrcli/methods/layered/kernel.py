"""The kernel of the contact equation, K(x, t) = int_0^inf (g(k) - 1) cos(kx) cos(kt) dk, by quadrature in k.

K depends on x - t and x + t only, but a matrix of it is a product C D C^T of cosines at the quadrature nodes in k: it
costs less than a table of that one function, is symmetric and free of interpolation. Panels in k are refined until g is
a polynomial on each (it has features far below 1/h for stiff coatings), then until cos(k (x + t)) turns by no more on
each than the nodes can follow. Under a graded top layer g - 1 has a slowly decaying ``tail``, whose part of K is known
in closed form and left to ``product``; all here then means the rest, g - 1 - t(k).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre

from ...base.errors import SolveError
from ...bodies.materials import Elastic, TransverselyIsotropic
from ...bodies.problem import Specimen
from .spectrum import deviation
from .tail import Tail
from .transverse import Medium

Array = np.ndarray

SAMPLES = 16  # Gauss nodes per panel on which the resolution of g is judged
TAIL = 1e-10  # last Legendre coefficients of g on a panel; Gauss quadrature squares this
NOISE = 1e-14  # rounding of g - 1 and of its coefficients
FLOOR = 1e-12  # |g - 1| beyond k_max; an error of g relative to g
GRADED_FLOOR = 1e-9  # the same where g is accurate to 1e-10
PHASE = 1e-14  # error of the quadrature of (g - 1) cos(k s), relative to its panel
HALVINGS = 45
CHUNK = 2048  # nodes in k per matrix product, a bound on the memory
SCAN = 2.0 ** np.arange(5.5, -60.0, -0.5)  # k h_top in which the end of g - 1 is looked for
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(SAMPLES)
_LEGENDRE = legendre.legvander(_NODES, SAMPLES - 1) * _WEIGHTS[:, None] * (np.arange(SAMPLES) + 0.5)


class Kernel(Protocol):
    """Symmetric, smooth K(x, t) [1/m] of the contact equation; zero for a homogeneous half-space."""

    @property
    def scale(self) -> float:
        """The length over which K varies [m], about the thickness of the top layer; infinite for K = 0."""
        ...

    def __call__(self, x: Array, t: Array) -> Array:
        """K(x_i, t_j), shape (x.size, t.size)."""
        ...

    def square(self, x: Array) -> Array:
        """K(x_i, x_j), symmetric."""
        ...


@dataclass(frozen=True, eq=False)
class CosineKernel:
    """K as a sum of cosines at the nodes ``k`` [1/m], ``weights`` [1/m] = quadrature weights times g - 1."""

    k: Array
    weights: Array
    scale: float

    def __call__(self, x: Array, t: Array) -> Array:
        return (np.cos(np.outer(x, self.k)) * self.weights) @ np.cos(np.outer(t, self.k)).T

    def square(self, x: Array) -> Array:
        total = np.zeros((x.size, x.size))
        for sign in (1.0, -1.0):
            k, amplitude = self.k[sign * self.weights > 0], np.sqrt(np.abs(self.weights[sign * self.weights > 0]))
            for start in range(0, k.size, CHUNK):
                part = slice(start, start + CHUNK)
                cosines = np.cos(np.outer(x, k[part])) * amplitude[part]
                total += sign * (cosines @ cosines.T)  # one array with its transpose: half the work of two
        return total


@dataclass(frozen=True, eq=False)
class Sum:
    """The sum of two kernels."""

    first: Kernel
    second: Kernel

    @property
    def scale(self) -> float:
        return min(self.first.scale, self.second.scale)

    def __call__(self, x: Array, t: Array) -> Array:
        return self.first(x, t) + self.second(x, t)

    def square(self, x: Array) -> Array:
        return self.first.square(x) + self.second.square(x)


@dataclass(frozen=True, eq=False)
class LayeredSpectrum:
    """g(k) - 1 of one pair of bodies, with the panels in k on which it is resolved; makes kernels of any reach."""

    specimen: Specimen
    indenter: Elastic | None = None

    def __call__(self, k: Array) -> Array:
        rest = deviation(self.specimen, k, self.indenter)
        return rest if self.tail is None else rest - self.tail(k)

    @cached_property
    def tail(self) -> Tail | None:
        """The slowly decaying part of g - 1."""
        return Tail.of(self.specimen, self.indenter)

    @property
    def floor(self) -> float:
        """The rest beyond k_max."""
        return FLOOR if self.tail is None else GRADED_FLOOR

    @cached_property
    def scan(self) -> tuple[Array, Array]:
        """Wave numbers [1/m], decreasing, and the rest there."""
        k = SCAN / self._finest
        return k, self(k)

    @property
    def _finest(self) -> float:
        """The length [m] over which the specimen changes below the surface, as far as the contact feels it."""
        top = self.specimen.layers[0]
        if isinstance(top.material, TransverselyIsotropic):
            return top.thickness * min(Medium.of(top.material).slowest, 1.0)
        return top.thickness if self.tail is None else self.tail.finest

    def bandwidth(self, level: float) -> float:
        """The k [1/m] beyond which the rest is below ``level``; 0 for a homogeneous half-space."""
        if not self.specimen.layers:
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
        if self.tail is not None:  # less accuracy is asked for
            return 5 / self.bandwidth(min(1e-3, 0.01 * float(np.max(np.abs(self.scan[1])))))
        return 9 / self.bandwidth(min(1e-6, 0.01 * float(np.max(np.abs(self.scan[1])))))

    @cached_property
    def panels(self) -> tuple[Array, Array, Array]:
        """Ends lo, hi [1/m] of panels that resolve g, down to k = 0, and the rest at the ``SAMPLES`` nodes of each."""
        k_max = self.bandwidth(self.floor)
        edges = np.concatenate([[0.0], k_max * 2.0 ** np.arange(-6, 1)])
        return resolved(self, edges[:-1], edges[1:], self.tail)

    def kernel(self, reach: float, order: int = 24) -> CosineKernel:
        """K for all x, t with x + t <= ``reach`` [m], from ``order`` Gauss nodes in k on every panel."""
        if self.bandwidth(self.floor) == 0:
            return CosineKernel(np.zeros(0), np.zeros(0), np.inf)
        lo, hi, values = self.panels
        size = np.max(np.abs(values), axis=1)
        turn = 0.0 if reach == 0 else reach / phase_allowed(order - 5, PHASE / np.clip(size, 1e-12, 1.0))
        pieces = np.maximum(np.ceil((hi - lo) * turn), 1).astype(int)
        k, w = gauss(*split(lo, hi, pieces), *rule(order))
        panel = np.repeat(np.arange(lo.size), order * pieces)
        rest = self._interpolated(k, panel) if self.specimen.is_graded else self(k)
        return CosineKernel(k, w * rest, self.scale)

    def _interpolated(self, k: Array, panel: Array) -> Array:
        """The rest at ``k``, each on the panel of the given index: cheaper than g itself through graded layers."""
        lo, hi, values = self.panels
        local = (2 * k - lo[panel] - hi[panel]) / (hi - lo)[panel]
        return legendre.legval(local, (values @ _LEGENDRE).T[:, panel], tensor=False)


def gauss_constant(order: int) -> float:
    """C in the error C (k d)^(2 order) of Gauss quadrature of cos(kx) on a panel of width d, relative to d [-]."""
    return math.exp(4 * math.lgamma(order + 1) - 3 * math.lgamma(2 * order + 1)) / (2 * order + 1)


def phase_allowed(order: int, error: Array | float) -> Array | float:
    """The phase k d [rad] that ``order`` Gauss nodes integrate with a relative ``error``."""
    return (error / gauss_constant(order)) ** (1 / (2 * order))


@cache
def rule(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [-1, 1], read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


def gauss(lo: Array, hi: Array, nodes: Array, weights: Array) -> tuple[Array, Array]:
    """Nodes and weights of a composite rule on the panels (lo, hi) from one on [-1, 1], flat, panel by panel."""
    half = (hi - lo)[:, None] / 2
    return np.ravel((lo + hi)[:, None] / 2 + half * nodes), np.ravel(half * weights)


def split(lo: Array, hi: Array, pieces: Array) -> tuple[Array, Array]:
    """Every panel (lo, hi) cut into the given number of equal pieces, in order."""
    step = np.repeat((hi - lo) / pieces, pieces)
    start = np.repeat(lo, pieces)
    index = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return start + index * step, start + (index + 1) * step


def resolved(
    function: Callable[[Array], Array], lo: Array, hi: Array, tail: Callable[[Array], Array] | None = None
) -> tuple[Array, Array, Array]:
    """Halve panels until ``function`` = g - 1, less its ``tail``, is a polynomial on each, to ``TAIL`` of its g.

    Returns the ends and the values at the ``SAMPLES`` nodes of each. An error of g relative to g itself is what counts:
    S is the minimum of a quadratic form with the symbol g > 0.
    """
    done: list[tuple[Array, Array, Array]] = []
    for _ in range(HALVINGS):
        k, _ = gauss(lo, hi, _NODES, _WEIGHTS)
        values = function(k).reshape(lo.size, SAMPLES)
        size = np.max(np.abs(values), axis=1)
        g = 1 + values if tail is None else 1 + values + tail(k).reshape(values.shape)
        last = np.max(np.abs(values @ _LEGENDRE[:, -2:]), axis=1)
        good = last <= TAIL * np.max(g, axis=1) + NOISE * size
        done.append((lo[good], hi[good], values[good]))
        if good.all():
            return tuple(np.concatenate(parts) for parts in zip(*done, strict=True))  # type: ignore[return-value]
        lo, hi = split(lo[~good], hi[~good], np.full(int((~good).sum()), 2))
    raise SolveError(
        f"layered: the compliance spectrum is not smooth near k = {lo[0]:g} 1/m after {HALVINGS} halvings; "
        "check the thicknesses and moduli of the layers"
    )

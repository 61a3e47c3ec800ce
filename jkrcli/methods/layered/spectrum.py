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
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre

from ...base import Array, SolveError
from ...bodies import Elastic, Problem, Solid, Specimen, TransverselyIsotropic, contact_modulus, stacks
from ..integral import CosineKernel, gauss, phase_allowed, rule, split, to_legendre
from .minors import TUNING as MINORS
from .minors import Medium, minors_below, minors_of, shear_moduli, through_isotropic
from .tail import Tail


@dataclass(frozen=True)
class SpectrumTuning:
    """How far and how finely g(k) is resolved."""

    samples: int = 16  # Gauss nodes per panel on which it is judged; tuned on reference bodies, by `make tuning`
    last: float = 1e-10  # coefficients of g on a panel, relative; theory: Gauss quadrature squares this
    noise: float = 1e-14  # theory: 50 times machine epsilon, the rounding of g - 1 and of its coefficients
    floor: float = 1e-12  # |g - 1| beyond k_max; tuned on reference bodies, by `make tuning`
    graded_floor: float = 1e-9  # the same of graded layers; choice: there g is accurate to 1e-10
    phase: float = 1e-14  # error of a panel of (g - 1) cos(k s); theory: 50 times machine epsilon
    start: float = 0.012  # CPU seconds of any stack; tuned on the cases of `make bench`, by `make bench`
    layer_seconds: float = 5e-4  # and of a layer; tuned on stacks of 50 to 1000 layers, by `make bench`
    graded_seconds: float = 0.1  # and of a smooth piece of a law; tuned on tables of 10 to 100 points, by `make bench`
    halvings: int = 60  # theory: the panel from k = 0 is then 2^-60 of k_max, below all that counts
    narrowest: float = 1e-12  # panel over its k; theory: g varies over k itself, and that is far below
    # octaves below the first node of the panel from k = 0, in which g is looked for, each at two places;
    # theory: as wave numbers, all that counts of layers 1e-15 times as thin as the depth
    below: int = 50


TUNING = SpectrumTuning()


def deviation(specimen: Specimen, k: Array, indenter: Solid | None = None) -> Array:
    """Deviation g(k) - 1 at the wave numbers ``k`` >= 0 [1/m], shape of ``k``; small values keep their relative
    accuracy.

    With an elastic ``indenter`` g belongs to both bodies together, normalised by E* of the surfaces: compliances add,
    C = 2 g/(E* k) = 2 g_1/(E*_1 k) + 2 g_2/(E*_2 k), so that g - 1 = sum (E*/E*_i)(g_i - 1); a half-space adds none.
    """
    E_star = contact_modulus(specimen.surface, indenter)
    parts = [E_star / body.surface.E_star * compliance(body, k)[1] for body in stacks(specimen, indenter)]
    return sum(parts, np.zeros(np.shape(k)))


def compliance(specimen: Specimen, k: Array) -> Array:
    """g(k) and g(k) - 1 of a stack (2, ...) at the wave numbers ``k`` >= 0 [1/m], each accurate relative to itself."""
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.stack([np.ones_like(k), np.zeros_like(k)])
    positive = np.maximum(np.ravel(k), 1e-30 / specimen.top_thickness)  # minors over a sliding base vanish at 0 itself
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
    small = y < MINORS.small
    g[small] = _over(through_isotropic(below[:, small], y[small], nu), 1 - nu)
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
    b1, b2, b3, b4 = Medium.isotropic(nu).powers(m)
    once = np.exp(-2 * y)
    twice = once * once

    def excess(v: Array) -> Array:
        return v[2] - (1 - nu) * v[0]

    decaying = once * (
        excess(m) + y * (excess(b1) - excess(b3) / 4) + y**2 * (excess(b2) / 2 - excess(b4) / 8) - excess(b4) / 16
    ) + twice * (excess(b4) / 32 - excess(b3) / 16)
    return decaying / ((1 - nu) * through_isotropic(m, y, nu)[0])


@dataclass(frozen=True, eq=False)
class LayeredSpectrum:
    """Spectrum g(k) - 1 of one pair of bodies, with the panels in k on which it is resolved; makes kernels of any
    reach."""

    specimen: Specimen
    indenter: Solid | None = None

    def __call__(self, k: Array) -> Array:
        rest = deviation(self.specimen, k, self.indenter)
        return rest if self.tail is None else rest - self.tail(k)

    @cached_property
    def tail(self) -> Tail | None:
        """The slowly decaying part of g - 1."""
        return Tail.of(self.specimen, self.indenter)

    @property
    def floor(self) -> float:
        """Size of the rest beyond k_max."""
        return TUNING.floor if self.tail is None else TUNING.graded_floor

    @cached_property
    def scan(self) -> tuple[Array, Array]:
        """Wave numbers [1/m], decreasing, and the rest there."""
        k = 2.0 ** np.arange(5.5, -60.0, -0.5) / self._finest
        return k, self(k)

    @property
    def _finest(self) -> float:
        """The length [m] over which the bodies change below the surface, as far as the contact feels it."""
        lengths = []
        for body in stacks(self.specimen, self.indenter):
            top = body.layers[0]
            if isinstance(top.material, TransverselyIsotropic):
                lengths.append(top.thickness * min(Medium.transverse(top.material).slowest, 1.0))
            else:
                own = None if body is not self.specimen else self.tail
                lengths.append(top.thickness if own is None else own.finest)
        return min(lengths)

    def bandwidth(self, level: float) -> float:
        """The k [1/m] beyond which the rest is below ``level``; 0 for a homogeneous half-space."""
        if not stacks(self.specimen, self.indenter):
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
        ``reach`` [m], and the number of each one's panel."""
        lo, hi, values = self.panels
        size = np.max(np.abs(values), axis=1)
        turn = reach / phase_allowed(order - 5, TUNING.phase / np.clip(size, 1e-12, 1.0))
        pieces = np.maximum(np.ceil((hi - lo) * turn), 1).astype(int)
        return *gauss(*split(lo, hi, pieces), *rule(order)), np.repeat(np.arange(lo.size), order * pieces)

    def kernel(self, reach: float, order: int = 24) -> CosineKernel:
        """Kernel for all x, t with x + t <= ``reach`` [m], from ``order`` Gauss nodes in k on every panel."""
        k, w, panel = self.nodes(reach, order)
        rest = self._interpolated(k, panel) if self.specimen.is_graded else self(k)
        return CosineKernel(k, w * rest, self.scale)

    def _interpolated(self, k: Array, panel: Array) -> Array:
        """The rest at ``k``, each on the panel of the given index: cheaper than g itself through graded layers."""
        lo, hi, values = self.panels
        local = (2 * k - lo[panel] - hi[panel]) / (hi - lo)[panel]
        return legendre.legval(local, (values @ to_legendre(TUNING.samples)).T[:, panel], tensor=False)


def spectrum_seconds(problem: Problem) -> float:
    """CPU seconds to resolve the spectrum of the bodies and evaluate its kernels, about; a single look takes half."""
    specimen = problem.specimen
    graded = TUNING.graded_seconds * (2 + specimen.pieces) if specimen.is_graded else 0.0
    return TUNING.start + TUNING.layer_seconds * len(problem.layers) + graded


def resolved(
    function: Callable[[Array], Array], lo: Array, hi: Array, tail: Callable[[Array], Array] | None = None
) -> tuple[Array, Array, Array]:
    """Panels, cut until ``function`` = g - 1, less its ``tail``, is a polynomial on each, to ``TUNING.last`` of g.

    Returns the ends and the values at the Gauss nodes of each. An error of g relative to g itself is what counts: S is
    the minimum of a quadratic form with the symbol g > 0. Panels are halved; one that begins at k = 0 is cut into
    octaves down to what lies below its first node.
    """
    done: list[tuple[Array, Array, Array]] = []
    project = to_legendre(TUNING.samples)
    for _ in range(TUNING.halvings):
        k, _ = gauss(lo, hi, *rule(TUNING.samples))
        values = function(k).reshape(lo.size, TUNING.samples)
        size = np.max(np.abs(values), axis=1)
        g = 1 + values if tail is None else 1 + values + tail(k).reshape(values.shape)
        coefficients, allowed = values @ project, TUNING.last * np.max(g, axis=1) + TUNING.noise * size
        good = np.max(np.abs(coefficients[:, -2:]), axis=1) <= allowed
        octaves = np.zeros(0)
        if lo.size and lo[0] == 0 and good[0]:
            octaves = _octaves_to(function, hi[0], coefficients[0], allowed[0] + len(project) * TUNING.noise * size[0])
            good[0] = not octaves.size
        if (rough := lo[~good & (hi - lo < TUNING.narrowest * hi)]).size:
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


def _octaves_to(function: Callable[[Array], Array], hi: float, coefficients: Array, allowed: float) -> Array:
    """Ends of octaves from 0 to ``hi`` [1/m], down to the largest k below the first node of that one panel at which
    ``function`` is not the Legendre series of ``coefficients``; none where it is that everywhere.

    It may be off by what is ``allowed`` at the first node, and by more like 1/k below: its integral is no more.
    """
    first = hi * (1 + rule(TUNING.samples)[0][0]) / 2
    k = first * 2.0 ** np.arange(-0.5, -TUNING.below, -0.5)
    off = np.abs(function(k) - legendre.legval(2 * k / hi - 1, coefficients))
    missed = k[off * k > allowed * first]
    if not missed.size:
        return missed
    return np.append(0.0, hi * 2.0 ** np.arange(-math.ceil(math.log2(hi / missed[0])), 1))

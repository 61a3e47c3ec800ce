"""Compliance spectrum g(k) of a stack: surface compliance C(k) = 2 g(k)/(E* k) in Hankel space, and its kernels.

The kernel of the contact equation is K(x, t) = int_0^inf (g(k) - 1) cos(kx) cos(kt) dk, by quadrature in k. Panels in k
are refined until g is a polynomial on each (it has features far below 1/h for stiff coatings), then until
cos(k (x + t)) turns by no more on each than the nodes can follow. Under a graded top layer g - 1 has a slowly decaying
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
from ...bodies import Elastic, Specimen, TransverselyIsotropic, contact_modulus
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
    halvings: int = 45  # theory: panels are then 2^-45 of k_max


TUNING = SpectrumTuning()


def deviation(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """Deviation g(k) - 1 at the wave numbers ``k`` >= 0 [1/m], shape of ``k``; small values keep their relative
    accuracy.

    With an elastic ``indenter`` g belongs to both bodies together, normalised by E* of both: its own half-space adds a
    constant to the compliance, so that only the factor E*/E*_top remains.
    """
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.zeros_like(k)
    top = specimen.surface
    factor = contact_modulus(top, indenter) / top.E_star
    positive = np.maximum(np.ravel(k), 1e-30 / specimen.top_thickness)  # minors over a sliding base vanish at 0 itself
    return (factor * _deviation_of_stack(specimen, positive)).reshape(k.shape)


def _deviation_of_stack(specimen: Specimen, k: Array) -> Array:
    top, nu = specimen.layers[0], specimen.surface.nu
    if not isinstance(top.material, Elastic):
        half_space = 2 * shear_moduli(top)[0] / specimen.surface.E_star  # F_zz in units of 1/G at the surface
        return _excess(minors_of(specimen, k), half_space)
    below = minors_below(specimen, k)
    y = k * top.thickness
    dev = np.empty_like(k)
    small = y < MINORS.small
    dev[small] = _excess(through_isotropic(below[:, small], y[small], nu), 1 - nu)
    dev[~small] = _far(below[:, ~small], y[~small], nu)
    return dev


def _excess(m: Array, half_space: float) -> Array:
    """Deviation g - 1 from the minors at the surface, by subtraction."""
    return m[2] / (half_space * m[0]) - 1


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
        """Size of the rest beyond k_max."""
        return TUNING.floor if self.tail is None else TUNING.graded_floor

    @cached_property
    def scan(self) -> tuple[Array, Array]:
        """Wave numbers [1/m], decreasing, and the rest there."""
        k = 2.0 ** np.arange(5.5, -60.0, -0.5) / self._finest
        return k, self(k)

    @property
    def _finest(self) -> float:
        """The length [m] over which the specimen changes below the surface, as far as the contact feels it."""
        top = self.specimen.layers[0]
        if isinstance(top.material, TransverselyIsotropic):
            return top.thickness * min(Medium.transverse(top.material).slowest, 1.0)
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


def spectrum_seconds(specimen: Specimen) -> float:
    """CPU seconds to resolve the spectrum of a stack and evaluate its kernels, about; a single look takes half."""
    graded = TUNING.graded_seconds * (2 + specimen.pieces) if specimen.is_graded else 0.0
    return TUNING.start + TUNING.layer_seconds * len(specimen.layers) + graded


def resolved(
    function: Callable[[Array], Array], lo: Array, hi: Array, tail: Callable[[Array], Array] | None = None
) -> tuple[Array, Array, Array]:
    """Panels, halved until ``function`` = g - 1, less its ``tail``, is a polynomial on each, to ``TUNING.last`` of g.

    Returns the ends and the values at the Gauss nodes of each. An error of g relative to g itself is what counts: S is
    the minimum of a quadratic form with the symbol g > 0.
    """
    done: list[tuple[Array, Array, Array]] = []
    project = to_legendre(TUNING.samples)
    for _ in range(TUNING.halvings):
        k, _ = gauss(lo, hi, *rule(TUNING.samples))
        values = function(k).reshape(lo.size, TUNING.samples)
        size = np.max(np.abs(values), axis=1)
        g = 1 + values if tail is None else 1 + values + tail(k).reshape(values.shape)
        last = np.max(np.abs(values @ project[:, -2:]), axis=1)
        good = last <= TUNING.last * np.max(g, axis=1) + TUNING.noise * size
        done.append((lo[good], hi[good], values[good]))
        if good.all():
            return tuple(np.concatenate(parts) for parts in zip(*done, strict=True))  # type: ignore[return-value]
        lo, hi = split(lo[~good], hi[~good], np.full(int((~good).sum()), 2))
    raise SolveError(
        f"layered: the compliance spectrum is not smooth near k = {lo[0]:g} 1/m after {TUNING.halvings} halvings; "
        "check the thicknesses and moduli of the layers"
    )

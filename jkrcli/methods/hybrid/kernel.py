"""The kernel K(x, t) of a body of revolution as even polynomials in x and t, from finite-element corrections."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ...base import AT_ONCE, Array
from ..integral import rule
from .correction import Correction, correction, side_correction
from .lines import TUNING as LINES
from .lines import LineElements, lines
from .region import TUNING as REGIONS
from .region import Region, nearest

STEP = 2  # in the degree, from level to level; tuned on bodies by hybrid, by `make constants`: odd ones gain little


@dataclass(frozen=True)
class CostTuning:
    """Rates of one core for forecasts."""

    begin: float = 5e-3  # s; tuned on bodies, by `make guards`: for forecasts
    # s, to integrate and factorise, per entry of the stiffness; tuned on bodies, by `make guards`: for forecasts
    per_entry: float = 1e-7
    # s, to solve, per entry and right-hand side; tuned on bodies, by `make guards`: for forecasts
    per_entry_and_side: float = 1.2e-9
    # s, for the half-space's field, per Gauss point and parameter t; tuned on bodies, by `make guards`: for forecasts
    per_point: float = 2e-7
    # s, for their works in one another, per pair of t; tuned on bodies, by `make guards`: for forecasts
    per_point_and_pair: float = 2e-9
    # s, for a field towards its ring under a graded top; tuned on bodies, by `make guards`: for forecasts
    around: float = 8e-3
    # entries of the factor beside elements graded to a corner, per unknown; tuned on bodies, by `make guards`: for
    # forecasts
    fill: float = 4.5
    operations: float = 1.2e10  # on them, per s; tuned on bodies, by `make guards`: for forecasts
    bytes_per_entry: float = 40.0  # of the stiffness and its factor; tuned on bodies, by `make guards`: for forecasts
    # of the unknowns of one parameter t; tuned on bodies, by `make guards`: for forecasts
    bytes_per_value: float = 100.0


COST_TUNING = CostTuning()


@dataclass(frozen=True, eq=False)
class PolynomialKernel:
    """Kernel K [1/m] for 0 <= x, t <= ``reach`` [m]: sum of c_ij P_2i(x/reach) P_2j(t/reach), Legendre polynomials.

    ``scale``: the length over which K varies [m].
    """

    coefficients: Array
    reach: float
    scale: float

    def times(self, x: Array, t: Array, values: Array) -> Array:
        count = len(self.coefficients)
        waves: Array = self.coefficients @ (_even(t / self.reach, count).T @ values)
        return _even(x / self.reach, count) @ waves

    def square(self, x: Array) -> Array:
        even = _even(x / self.reach, len(self.coefficients))
        return even @ self.coefficients @ even.T

    def shorter(self) -> PolynomialKernel:
        """Kernel without the highest polynomial in x and in t."""
        return replace(self, coefficients=self.coefficients[:-1, :-1])


def _even(x: Array, count: int) -> Array:
    """Even Legendre polynomials P_0, P_2, ... at ``x``, (x.size, count)."""
    return legendre.legvander(x, 2 * count - 1)[:, ::2]


def convergence(region: Region) -> float:
    """The factor by which one more even polynomial in t reduces the error of K.

    K is analytic but for images of the contact: they lie twice the depth d of the nearest interface above, at
    t = x +- 2 i d, and at the side. The factor is rho^2, rho: sum of the half axes of the ellipse through the nearest
    singularity (Trefethen 2013, Ch. 8).
    """
    growth = 2 * region.first + math.hypot(1, 2 * region.first)
    if not region.cut_beside:
        growth = min(growth, region.width + math.sqrt(region.width**2 - 1))
    return growth**2


def count_for(region: Region, error: float) -> int:
    """How many even polynomials leave about ``error``."""
    falls = math.log(convergence(region))  # 0 to rounding where the contact is beyond all sizes of the body
    return max(3, math.ceil(min(math.log(1 / error) / max(falls, 1 / AT_ONCE), AT_ONCE)) + 1)


class CorrectionCost(NamedTuple):
    """CPU ``seconds``, peak ``memory_mib`` [MiB] and ``unknowns`` of one correction."""

    seconds: float
    memory_mib: float
    unknowns: int


def cost_of(region: Region, count: int, degree: int) -> CorrectionCost:
    """Cost of the correction for ``count`` parameters t: operations counted, with rates of one core."""
    r, z = lines(region, degree)
    rates = COST_TUNING
    pressures = 1 + any(region.mixed) / 3
    unknowns = 2 * pressures * (r.degrees.sum() + 1.0) * (z.degrees.sum() + 1.0)
    entries = 4 * pressures**2 * _pairs(r) * _pairs(z)
    points = float((r.degrees + LINES.extra).sum() * (z.degrees + LINES.extra).sum())
    fill = 0.0
    if region.corners or region.free_edges:
        fill = rates.fill * unknowns * 2 * pressures * min(r.degrees.sum(), z.degrees.sum())
    seconds = rates.begin + rates.per_entry * entries + rates.per_entry_and_side * count * (entries + fill)
    seconds += fill * (fill + 2 * entries) / unknowns / rates.operations
    fields = (rates.per_point + rates.per_point_and_pair * count) * points * count
    seconds += fields + rates.around * count * region.changing
    memory = (rates.bytes_per_entry * (entries + fill / 2) + rates.bytes_per_value * unknowns * count) / 2**20
    return CorrectionCost(float(seconds), float(memory), int(unknowns))


def _pairs(line: LineElements) -> float:
    """How many pairs of functions overlap."""
    return float(np.sum((line.degrees + 1.0) ** 2))


def _below(degree: int) -> int:
    """The degree of elements that tell what a cut changes."""
    return max(degree - STEP, REGIONS.least)


@dataclass(frozen=True, eq=False)
class KernelLevels:
    """Kernels of one ``region`` of growing degree, each computed once, from ``count`` parameters t.

    ``factor``: share of the specimen in the compliance of the half-spaces of both bodies. ``wide``: the laterally
    unbounded body of the same layers, where K is what the side adds to that.
    """

    region: Region
    count: int
    factor: float
    wide: Region | None = None

    @cached_property
    def _corrections(self) -> dict[tuple[int, bool], Correction]:
        return {}

    def correction(self, degree: int, nearer: bool = False) -> Correction:
        """The correction with elements of ``degree``; ``nearer``: after the second cut of an unbounded body."""
        key = (degree, nearer)
        if key not in self._corrections:
            t = rule(2 * self.count)[0][self.count :]
            region = self.region.nearer() if nearer else self.region
            if self.wide is None:
                self._corrections[key] = correction(region, t, degree)
            else:
                self._corrections[key] = side_correction(region, self.wide, t, degree)
        return self._corrections[key]

    def cost(self, degree: int) -> CorrectionCost:
        """Cost of a level with its estimates of the error, the coarser levels left out."""
        costs = [cost_of(region, self.count, degree) for region in (self.region, self.wide) if region is not None]
        if self.region.cut_beside:
            costs.append(cost_of(self.region.nearer(), self.count, _below(degree)))
        seconds, memory, unknowns = zip(*costs, strict=True)
        return CorrectionCost(sum(seconds), max(memory), max(unknowns))

    def cut(self, degree: int) -> PolynomialKernel:
        """K of the body after its first cut where extrapolating goes on from there, or else after the second one."""
        K = self.correction(degree).K
        return self._kernel(K if self.region.algebraic else K - self._by_cut(degree))

    def kernel(self, degree: int, coarser: int = 0) -> PolynomialKernel:
        """K of the whole body by elements of ``degree``, or so many levels ``coarser``; extrapolated, where what the
        cut costs falls with the square of its distance."""
        K = self.correction(degree - STEP * coarser).K
        if self.region.algebraic:
            K = K + self._by_cut(degree) / (REGIONS.shrink**2 - 1)
        return self._kernel(K)

    def _by_cut(self, degree: int) -> Array:
        """What the first cut leaves of K beyond the second one, by elements of about one level below ``degree``."""
        below = _below(degree)
        return self.correction(below).K - self.correction(below, nearer=True).K

    def rounded(self, degree: int) -> PolynomialKernel:
        """K of the whole body by elements of ``degree`` with the error that rounding leaves: in the longest and in the
        shortest waves, as it is at random."""
        i = np.arange(self.count)
        error = self._kernel(self.correction(degree).rounding * (1 + (-1.0) ** np.add.outer(i, i)))
        kernel = self.kernel(degree)
        return replace(kernel, coefficients=kernel.coefficients + error.coefficients)

    def _kernel(self, K: Array) -> PolynomialKernel:
        t, w = (half[self.count :] for half in rule(2 * self.count))
        even = _even(t, self.count) * w[:, None] * (4 * np.arange(self.count) + 1)
        unit = self.region.unit
        return PolynomialKernel(self.factor / unit * (even.T @ K @ even), unit, unit * nearest(self.region))

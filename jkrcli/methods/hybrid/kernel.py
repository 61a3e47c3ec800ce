"""The kernel K(x, t) of a body of revolution as even polynomials in x and t, from finite-element corrections."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre

from ..integral.quadrature import rule
from .correction import Correction, correction, side_correction
from .cost import Cost, cost_of
from .region import SHRINK, Region, nearest
from .sizes import Resolution

Array = np.ndarray
STEP = 2  # in the degree, from one level to the next


@dataclass(frozen=True, eq=False)
class PolynomialKernel:
    """K [1/m] for 0 <= x, t <= ``reach`` [m]: sum of c_ij P_2i(x/reach) P_2j(t/reach), Legendre polynomials.

    ``scale``: the length over which K varies [m].
    """

    coefficients: Array
    reach: float
    scale: float

    def __call__(self, x: Array, t: Array) -> Array:
        count = len(self.coefficients)
        return _even(x / self.reach, count) @ self.coefficients @ _even(t / self.reach, count).T

    def square(self, x: Array) -> Array:
        return self(x, x)

    def shorter(self) -> PolynomialKernel:
        """The same without the highest polynomial in x and in t."""
        return replace(self, coefficients=self.coefficients[:-1, :-1])


def _even(x: Array, count: int) -> Array:
    """P_0, P_2, ... at ``x``, (x.size, count)."""
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
    return max(3, math.ceil(math.log(1 / error) / math.log(convergence(region))) + 1)


@dataclass(frozen=True, eq=False)
class Levels:
    """Kernels of one ``region`` of growing degree, each computed once, from ``count`` parameters t.

    ``factor``: share of the specimen in the compliance of the half-spaces of both bodies. ``wide``: the laterally
    unbounded body of the same layers, where K is what the side adds to that.
    """

    region: Region
    count: int
    factor: float
    wide: Region | None = None

    @cached_property
    def _found(self) -> dict[tuple[int, bool], Correction]:
        return {}

    def correction(self, degree: int, nearer: bool = False) -> Correction:
        """The correction with elements of ``degree``; ``nearer``: after the second cut of an unbounded body."""
        key = (degree, nearer)
        if key not in self._found:
            t = rule(2 * self.count)[0][self.count :]
            region = self.region.nearer() if nearer else self.region
            if self.wide is None:
                self._found[key] = correction(region, t, Resolution(degree))
            else:
                self._found[key] = side_correction(region, self.wide, t, Resolution(degree))
        return self._found[key]

    def cost(self, degree: int) -> Cost:
        """Of that level with its estimates of the error, the coarser levels left out."""
        once = cost_of(self.region, self.count, Resolution(degree))
        if self.wide is not None:
            once += cost_of(self.wide, self.count, Resolution(degree))
        if self.region.cut_beside:
            below = degree - STEP if self.region.algebraic else degree
            once += cost_of(self.region.nearer(), self.count, Resolution(below))
        return once

    def plain(self, degree: int) -> PolynomialKernel:
        """K of the body as it was cut."""
        return self._kernel(self.correction(degree).K)

    def kernel(self, degree: int) -> PolynomialKernel:
        """K of the whole body, by elements of ``degree``, what the cut costs by those of one level below."""
        return self._whole(degree, degree - STEP)

    def coarser(self, degree: int, steps: int) -> PolynomialKernel:
        """The same by elements of so many levels below, as far as the body itself goes."""
        return self._whole(degree - STEP * steps, degree - STEP)

    def nearer(self, degree: int) -> PolynomialKernel:
        """K of the body after the second cut."""
        return self._kernel(self.correction(degree, nearer=True).K)

    def _whole(self, degree: int, below: int) -> PolynomialKernel:
        """Extrapolated where what the cut costs falls with the square of the distance."""
        K = self.correction(degree).K
        return self._kernel(K + self._change(below) / (SHRINK**2 - 1) if self.region.algebraic else K)

    def _change(self, degree: int) -> Array:
        """What the distance from the second cut to the first changes."""
        return self.correction(degree).K - self.correction(degree, nearer=True).K

    def _kernel(self, K: Array) -> PolynomialKernel:
        t, w = (half[self.count :] for half in rule(2 * self.count))
        even = _even(t, self.count) * w[:, None] * (4 * np.arange(self.count) + 1)
        unit = self.region.unit
        return PolynomialKernel(self.factor / unit * (even.T @ K @ even), unit, unit * nearest(self.region))

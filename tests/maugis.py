"""Maugis' closed form, paraboloid on a half-space, constant tension (J. Colloid Interface Sci. 150 (1992) 243).

In his units, K = 4 E*/3: lengths a0 = (pi w R^2/K)^(1/3) for a, a0^2/R for delta, loads pi w R;
lambda = 2 sigma (R/(pi w K^2))^(1/3), m = c/a.
"""

import math
from dataclasses import dataclass

import numpy as np

from jkrcli.adhesion.finite_range import FiniteRangeBody, FiniteRangeCurve, Range
from jkrcli.series import Solution

Array = np.ndarray


@dataclass(frozen=True)
class Maugis:
    """States of contact at the ratios ``m`` = c/a; columns in SI."""

    R: float
    E_star: float
    w: float
    lam: float
    m: Array

    @property
    def stress(self) -> float:
        return self.lam / 2 * (math.pi * self.w * self.K**2 / self.R) ** (1 / 3)

    @property
    def K(self) -> float:
        return 4 * self.E_star / 3

    @property
    def length(self) -> float:
        return (math.pi * self.w * self.R**2 / self.K) ** (1 / 3)

    @property
    def _root(self) -> tuple[Array, Array]:
        root = np.sqrt((self.m - 1) * (self.m + 1))
        return root, np.arctan(root)

    @property
    def _a(self) -> Array:
        """lambda a^2/2 (root + (m^2 - 2) arc) + 4 lambda^2 a/3 (root arc - m + 1) = 1, solved without cancellation."""
        root, arc = self._root
        square, linear = self.lam / 2 * (root + (self.m**2 - 2) * arc), 4 / 3 * self.lam**2 * (root * arc - self.m + 1)
        return 2 / (linear + np.sqrt(linear**2 + 4 * square))

    @property
    def a(self) -> Array:
        return self._a * self.length

    @property
    def c(self) -> Array:
        return self.m * self.a

    @property
    def delta(self) -> Array:
        root, _ = self._root
        return (self._a**2 - 4 / 3 * self.lam * self._a * root) * self.length**2 / self.R

    @property
    def P(self) -> Array:
        root, arc = self._root
        return (self._a**3 - self.lam * self._a**2 * (root + self.m**2 * arc)) * math.pi * self.w * self.R


def finite_range_curve(
    solution: Solution, w: float, *, stress: float | None = None, length: float | None = None
) -> FiniteRangeCurve:
    """The adhesive curve of a solved body for ``w`` and a constant tension ``stress`` or its range ``length``."""
    return FiniteRangeBody.of(solution).curve(Range.of(w, stress=stress, length=length))

"""The Fredholm kernel K(x, t) of the contact equation: what every kernel offers, sums of cosines, sums of kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...base import Array

CHUNK = 2048  # nodes in k per matrix product; tuned on ranges, by `make constants`: a bound on the memory


class FredholmKernel(Protocol):
    """Fredholm kernel K(x, t) [1/m] of the contact equation: symmetric, smooth, zero for a homogeneous half-space."""

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
    """K as a sum of cosines at the nodes ``k`` [1/m], ``weights`` [1/m] = quadrature weights times g - 1.

    K depends on x - t and x + t only, but a matrix of it is a product C D C^T of cosines: it costs less than a table of
    that one function, is symmetric and free of interpolation.
    """

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
class SumKernel:
    """The sum of two kernels."""

    first: FredholmKernel
    second: FredholmKernel

    @property
    def scale(self) -> float:
        return min(self.first.scale, self.second.scale)

    def __call__(self, x: Array, t: Array) -> Array:
        return self.first(x, t) + self.second(x, t)

    def square(self, x: Array) -> Array:
        return self.first.square(x) + self.second.square(x)

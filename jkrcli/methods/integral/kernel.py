"""The Fredholm kernel K(x, t) of the contact equation: what every kernel offers, and sums of cosines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...base import Array

CHUNK = 256  # nodes in k per matrix product; tuned on ranges, by `make constants`: a bound on the memory


class FredholmKernel(Protocol):
    """Fredholm kernel K(x, t) [1/m] of the contact equation: symmetric, smooth, zero for a homogeneous half-space."""

    @property
    def scale(self) -> float:
        """The length over which K varies [m], about the thickness of the top layer; infinite for K = 0."""
        ...

    def times(self, x: Array, t: Array, values: Array) -> Array:
        """sum_j K(x_i, t_j) values_j (x.size, m) of values (t.size, m)."""
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

    def times(self, x: Array, t: Array, values: Array) -> Array:
        total = np.zeros((x.size, values.shape[1]))
        for part in _chunks(self.k.size):
            waves = self.weights[part, None] * (np.cos(np.outer(self.k[part], t)) @ values)
            total += np.cos(np.outer(x, self.k[part])) @ waves
        return total

    def square(self, x: Array) -> Array:
        total = np.zeros((x.size, x.size))
        for sign in (1.0, -1.0):
            k, amplitude = self.k[sign * self.weights > 0], np.sqrt(np.abs(self.weights[sign * self.weights > 0]))
            for part in _chunks(k.size):
                cosines = np.cos(np.outer(x, k[part])) * amplitude[part]
                total += sign * (cosines @ cosines.T)  # one array with its transpose: half the work of two
        return total


def _chunks(count: int) -> Iterator[slice]:
    return (slice(start, start + CHUNK) for start in range(0, count, CHUNK))

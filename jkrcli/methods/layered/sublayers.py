"""The minors' way up through a graded layer: many homogeneous sublayers, extrapolated to infinitely many.

A sublayer with the modulus of its middle is a symmetric splitting of dm/dz = (k B + gamma D) m, gamma = (ln G)',
D = diag(0, 1, 1, 1, 2): its error has even powers of the sublayer's thickness only, and Richardson's extrapolation over
1, 2, 3, 4, 5 times as many sublayers is of order ten (Hairer, Norsett and Wanner, Solving Ordinary Differential
Equations I, Sec. II.9). What lies deeper than ``SEEN`` / k below a smooth part's top is not felt at that top; sublayers
become thinner towards it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from ...base.errors import SolveError
from ...bodies.grading import Law
from ...bodies.materials import Graded
from .minors import rescaled, through

Array = np.ndarray

SEEN = 18.0  # exp(-2 SEEN) is rounding
LEVELS = np.arange(1, 6)
ACCURACY = 1e-10  # of g, relative, judged by the last step of the extrapolation
FEWEST, MOST = 6, 96  # sublayers of the first level
STEEP = 6.0  # largest ratio of moduli in one piece
_SAMPLE = np.geomspace(1e-2, 1e3, 12)  # k times thickness


def through_graded(m: Array, k: Array, material: Graded, thickness: float) -> Array:
    """Minors (5, n) at the top of a graded layer, in units of its shear modulus there, from those at its bottom, in
    units of that at the bottom; ``k`` (n,) [1/m]. Raises SolveError where the modulus changes too quickly."""
    parts = [part for ends in smooth_parts(material.law, thickness) for part in _gentle_parts(material.law, *ends)]
    for top, bottom in reversed(parts):
        count = _sublayers(material, top, bottom)
        m = _extrapolated([_through_part(m, k, material, top, bottom, int(n)) for n in count * LEVELS])
    return m


def smooth_parts(law: Law, thickness: float) -> Iterator[tuple[float, float]]:
    """Depths [m] between which the law is smooth, from the top down."""
    return itertools.pairwise([0.0, *(z for z in law.kinks if z < thickness), thickness])


def _gentle_parts(law: Law, top: float, bottom: float) -> list[tuple[float, float]]:
    """A smooth part halved until the modulus changes by no more than the factor ``STEEP`` in each piece."""
    ends = law.at(np.array([top, bottom]))
    if ends.max() <= STEEP * ends.min():
        return [(top, bottom)]
    middle = (top + bottom) / 2
    return _gentle_parts(law, top, middle) + _gentle_parts(law, middle, bottom)


@lru_cache(maxsize=256)
def _sublayers(material: Graded, top: float, bottom: float) -> int:
    """The number of sublayers on the first level that makes g accurate to ``ACCURACY``, starting from a rigid base."""
    k = _SAMPLE / (bottom - top)
    start = np.repeat(np.eye(5)[:, :1], k.size, axis=1)
    count = FEWEST
    while count <= MOST:
        levels = [_through_part(start, k, material, top, bottom, int(n)) for n in count * LEVELS]
        best, before = _extrapolated(levels), _extrapolated(levels[:-1])
        if np.max(np.abs((before[2] / before[0]) / (best[2] / best[0]) - 1)) < 100 * ACCURACY:
            return count
        count *= 2
    raise SolveError(
        f"layered: the modulus changes too quickly between {top:g} and {bottom:g} m below its layer's top for "
        f"{count // 2} sublayers; cut the layer into several, or use a law with less contrast"
    )


def _through_part(m: Array, k: Array, material: Graded, top: float, bottom: float, count: int) -> Array:
    """Through ``count`` homogeneous sublayers between the depths ``bottom`` and ``top`` [m]."""
    seen = np.minimum(bottom - top, SEEN / k)
    edges = np.linspace(0, 1, 2 * count + 1) ** 2
    modulus = material.at(top + seen)
    for upper, middle, lower in zip(edges[-3::-2], edges[-2::-2], edges[:1:-2], strict=True):
        here = material.at(top + seen * middle)
        m = through(rescaled(m, here / modulus), k * seen * (lower - upper), material.nu)
        modulus = here
    return rescaled(m, material.at(np.full_like(k, top)) / modulus)


def _extrapolated(levels: list[Array]) -> Array:
    """The limit of minors from 1, 2, ... times as many sublayers, scaled so that those of positive sign add up to 1."""
    squares = LEVELS[: len(levels)].astype(float) ** 2
    total = np.zeros_like(levels[0])
    for i, m in enumerate(levels):
        weight = np.prod([squares[i] / (squares[i] - other) for j, other in enumerate(squares) if j != i])
        total += weight * m / (m[0] + m[1] + m[2] + m[4])
    return total

"""Whether the nonadhesive contact is a full disc: pressed together everywhere inside it, and open outside.

The contact equation takes the disc for granted. On a coating stiffer than what lies below it bends like a plate, and a
profile that is not curved enough at its tip loses touch there, or the plate touches again beyond the edge.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..errors import JkrError, Refusal
from ..problem import Problem
from ..units import show
from .fields import profile

Array = np.ndarray
FRACTIONS = (0.1, 0.25, 0.5, 1.0)  # of the largest contact radius, where it is looked at
INSIDE = np.array([0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95])  # of the contact radius
OUTSIDE = np.array([1.02, 1.1, 1.3, 2.0])
PULL = 1e-3  # of the mean pressure: less tension than that is round-off
OVERLAP = 1e-5  # of the displacement


def refuse_shrinking(a: Array, delta: Array) -> None:
    """Refusal where the displacement [m] does not grow with the radius ``a`` [m]: a plate that lies on its rim."""
    falls = np.flatnonzero(np.diff(delta) <= 0)
    if falls.size:
        raise Refusal(
            f"the displacement falls beyond the contact radius {show(float(a[falls[0]]), 'length')}: a coating so "
            "much stiffer than what lies below it is no longer touched in a disc that grows; ask for a smaller radius"
        )


def disc_warnings(problem: Problem, largest: float) -> tuple[str, ...]:
    """What is wrong with a disc up to ``largest`` [m] as the contact of ``problem``; () where nothing is."""
    E = [material.surface.E_star for material in problem.specimen.materials]
    if all(below >= above for above, below in itertools.pairwise(E)):
        return ()  # nothing bends over something softer
    a0 = problem.indenter.a0
    for fraction in FRACTIONS:
        a = a0 + fraction * (largest - a0)
        try:
            if words := _broken(problem, a):
                return (
                    f"at the contact radius {show(a, 'length')} {words}: the contact without adhesion is not a full "
                    "disc there, the adhesive curve is right only where adhesion holds it together; load less, or see "
                    "jkr profile",
                )
        except JkrError as error:
            return (f"it was not checked whether the contact is a full disc at {show(a, 'length')} ({error})",)
    return ()


def _broken(problem: Problem, a: float) -> str | None:
    outside = a * OUTSIDE
    found = profile(problem, a, 0.0, a * INSIDE, outside[outside <= problem.indenter.r_max])
    pull = float(found.pressure.min()) / (found.P / (math.pi * a**2))
    if pull < -PULL:
        return f"the middle pulls with {-pull:.2g} of the mean pressure"
    overlap = -float(found.gap.min(initial=0.0)) / found.delta
    return f"the surfaces overlap by {overlap:.2g} of the displacement beyond the edge" if overlap > OVERLAP else None

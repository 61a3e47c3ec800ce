"""Whether the nonadhesive contact is a full disc: pressed together everywhere inside it, and open outside.

The contact equation takes the disc for granted. On a coating stiffer than what lies below it bends like a plate, and a
profile that is not curved enough at its tip loses touch there, or the plate touches again beyond the edge.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from ...base.errors import JkrError, Refusal
from ...base.units import show
from ...bodies.problem import Specimen
from .density import Density
from .fields import gaps, pressures, unsmooth
from .kernel import Kernel
from .search import Contact

Array = np.ndarray
FRACTIONS = np.array([0.1, 0.25, 0.5, 1.0])  # of the largest contact radius, where it is looked at
INSIDE = np.array([0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95])  # of the contact radius
OUTSIDE = np.array([1.02, 1.1, 1.3, 2.0])
PULL = 1e-3  # of the mean pressure: less tension than that is round-off
OVERLAP = 1e-5  # of the displacement
TOLERANCE, ORDER = 1e-6, 9  # of the quadrature; nodes on each piece of phi


def refuse_shrinking(a: Array, delta: Array) -> None:
    """Refusal where the displacement [m] does not grow with the radius ``a`` [m]: a plate that lies on its rim."""
    falls = np.flatnonzero(np.diff(delta) <= 0)
    if falls.size:
        raise Refusal(
            f"the displacement falls beyond the contact radius {show(float(a[falls[0]]), 'length')}: a coating so "
            "much stiffer than what lies below it is no longer touched in a disc that grows; ask for a smaller radius"
        )


def disc_warnings(
    contact: Contact, specimen: Specimen, largest: float, kernel: Callable[[float], Kernel]
) -> tuple[str, ...]:
    """What is wrong with discs up to ``largest`` [m] as the ``contact`` with ``specimen``; () where nothing is.

    ``kernel(reach)``: K for x + t <= ``reach`` [m]; outside, the surface is looked at no farther than it is known.
    """
    if not _bends(specimen):
        return ()
    a0 = contact.indenter.a0
    radii = a0 + FRACTIONS * (largest - a0)
    try:
        if reason := unsmooth(specimen):
            raise Refusal(reason)
        nested = contact.nested(radii, contact.plan(radii, TOLERANCE))
    except JkrError as error:
        return (f"it was not checked whether the contact is a full disc ({error})",)
    end = min(OUTSIDE[-1] * largest, contact.indenter.r_max, contact.limit)
    known, each = kernel(largest + end), range(radii.size)
    for n, phi in enumerate(Density.each(known, contact.indenter, nested, each, 0.0, end, ORDER)):
        if words := _broken(phi.anchored(), contact.E_star / 2, float(nested.P[n]), end):
            return (
                f"at the contact radius {show(phi.a, 'length')} {words}: the contact without adhesion is not a full "
                "disc there, the adhesive curve is right only where adhesion holds it together; load less, or see "
                "jkr profile",
            )
    return ()


def _bends(specimen: Specimen) -> bool:
    """Whether something lies on something softer, or a side is near."""
    E = [material.surface.E_star for material in specimen.materials]
    return specimen.radius is not None or any(below < above for above, below in itertools.pairwise(E))


def _broken(phi: Density, factor: float, P: float, end: float) -> str | None:
    """Where the pressure, ``factor`` [Pa] times that of ``phi``, or the gap up to ``end`` [m] is negative."""
    pull = factor * float(pressures(phi, 0.0, phi.a * INSIDE).min()) / (P / (math.pi * phi.a**2))
    if pull < -PULL:
        return f"the middle pulls with {-pull:.2g} of the mean pressure"
    outside = phi.a * OUTSIDE
    overlap = -float(gaps(phi, outside[outside <= end]).min(initial=0.0)) / phi.delta
    return f"the surfaces overlap by {overlap:.2g} of the displacement beyond the edge" if overlap > OVERLAP else None

"""Whether the nonadhesive contact is a full disc: pressed together everywhere inside it, and open outside.

The contact equation takes the disc for granted. On a coating stiffer than what lies below it bends like a plate, and a
profile that is not curved enough at its tip loses touch there, or the plate touches again beyond the edge.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base import SAME, Array, JkrError, Refusal, show
from ...bodies import Specimen, stacks
from .density import Density, unsmooth
from .kernel import FredholmKernel
from .pair import Contact
from .quadrature import EXACT


@dataclass(frozen=True)
class DiscTuning:
    """Where a contact is looked at, and what counts as more than the rounding of the quadrature."""

    fractions: tuple[float, ...] = (0.1, 0.25, 0.5, 1.0)  # of the largest contact radius; choice: for a warning
    # Over each radius, to look at; choice: for a warning
    places: tuple[float, ...] = (0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 1.02, 1.1, 1.3, 2.0)
    pull: float = 1e-3  # least tension over the mean pressure; tuned on stiff coatings, by `make failures`
    overlap: float = 1e-5  # least overlap over the displacement; tuned on stiff coatings, by `make failures`


TUNING = DiscTuning()
PLACES = np.array(TUNING.places)


def refuse_shrinking(a: Array, delta: Array) -> None:
    """Refusal where the displacement [m] does not grow with the radius ``a`` [m]: a plate that lies on its rim."""
    falls = np.flatnonzero(np.diff(delta) <= 0)
    if falls.size:
        raise Refusal(
            f"the displacement falls beyond the contact radius {show(float(a[falls[0]]), 'length')}: a coating so "
            "much stiffer than what lies below it is no longer touched in a disc that grows; ask for a smaller radius"
        )


def disc_warnings(
    contact: Contact, specimen: Specimen, largest: float, kernel: Callable[[float], FredholmKernel]
) -> tuple[str, ...]:
    """What is wrong with discs up to ``largest`` [m] as the ``contact`` with ``specimen``; () where nothing is.

    ``kernel(reach)``: K for x + t <= ``reach`` [m]; outside, the surface is looked at no farther than it is known.
    """
    if not any(_bends(body) for body in (specimen, *stacks(specimen, contact.indenter.material))):
        return ()
    a0 = contact.indenter.a0
    radii = a0 + np.array(TUNING.fractions) * (largest - a0)
    try:
        if reason := unsmooth(specimen):
            raise Refusal(reason)
        result = contact.solved(radii, contact.plan(radii, SAME))
    except JkrError as error:
        return (f"it was not checked whether the contact is a full disc ({error})",)
    end = min(TUNING.places[-1] * largest, contact.indenter.r_max, contact.limit)
    densities = Density.each(kernel(largest + end), result, end, order=EXACT)
    for phi, P in zip(densities, result.P.tolist(), strict=True):
        if words := _broken(phi.anchored(), contact.E_star / 2, P, end):
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
    inside, outside = phi.a * PLACES[PLACES < 1], phi.a * PLACES[PLACES > 1]
    pull = factor * float(phi.pressures(0.0, inside).min()) / (P / (math.pi * phi.a**2))
    if pull < -TUNING.pull:
        return f"the middle pulls with {-pull:.2g} of the mean pressure"
    overlap = -float(phi.gaps(outside[outside <= end]).min(initial=0.0)) / phi.delta
    if overlap > TUNING.overlap:
        return f"the surfaces overlap by {overlap:.2g} of the displacement beyond the edge"
    return None

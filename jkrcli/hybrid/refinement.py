"""What to refine next, from the errors that a kernel leaves: elements, parameters t, or the cut."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .kernel import STEP, convergence
from .region import Region

Array = np.ndarray

LOWEST, HIGHEST = 4, 16  # degrees
SHARE = 0.25  # of the tolerance, to which parameters and cut are brought
MORE, WIDENED = 2, 2  # times that parameters are added and that the cut is moved outwards
STALLED = 2  # times that elements of a higher degree may bring nothing


@dataclass(frozen=True, eq=False)
class Judged:
    """Estimated relative errors (columns, radii) at ``radii`` [m]: of elements, of the parameters t, of the cut."""

    radii: Array
    elements: Array
    parameters: Array
    cut: Array

    @property
    def total(self) -> Array:
        return self.elements + self.parameters + self.cut

    def at(self, radii: Array) -> Array:
        """The total (columns, radii) at any radii: never less than at a smaller one."""
        rising = np.maximum.accumulate(self.total, axis=1)
        return np.array([np.interp(radii, self.radii, row) for row in rising])


@dataclass(frozen=True)
class Step:
    """Where a refinement stands: elements of ``degree``, ``more`` parameters t than planned, and the cut planned for an
    error that is ``sharper`` times as small; how often parameters were ``added``, the cut was ``widened``, and a higher
    degree ``stalled`` above the least error ``elements`` so far."""

    degree: int = LOWEST + STEP
    more: int = 0
    sharper: float = 1.0
    added: int = 0
    widened: int = 0
    stalled: int = 0
    elements: float = math.inf

    def after(self, judged: Judged, tolerance: float, region: Region) -> Step | None:
        """What lessens the largest of the errors; None where nothing does."""
        elements, parameters, cut = (float(e.max()) for e in (judged.elements, judged.parameters, judged.cut))
        goal = SHARE * tolerance
        if parameters >= max(elements, cut, goal) and self.added < MORE:
            missing = math.ceil(math.log(parameters / goal) / math.log(convergence(region)))
            return replace(self, more=self.more + max(missing, 1), added=self.added + 1)
        if cut >= max(elements, parameters, goal) and region.algebraic:
            if self.widened == WIDENED:
                return None
            return replace(self, sharper=self.sharper * cut / goal, widened=self.widened + 1)
        if self.degree == HIGHEST:
            return None
        stalled = self.stalled + (self.elements < math.inf and max(elements, parameters) > self.elements / 2)
        if stalled == STALLED:
            return None
        least = min(self.elements, max(elements, parameters))
        return replace(self, degree=self.degree + STEP, stalled=stalled, elements=least)

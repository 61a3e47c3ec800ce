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
STALLS = 1  # times that a step may bring next to nothing
HOPELESS = 30.0  # times the tolerance: no such step is forgiven


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
    degree ``stalled``: left more than half of the ``least`` error so far, last seen ``at`` a lower degree."""

    degree: int = LOWEST + STEP
    more: int = 0
    sharper: float = 1.0
    added: int = 0
    widened: int = 0
    stalled: int = 0
    least: float = math.inf
    at: int = HIGHEST

    def after(self, judged: Judged, tolerance: float, region: Region) -> Step | None:
        """What lessens the largest of the errors; None where nothing does."""
        total = float(judged.total.max())
        stalled = self.stalled + (self.degree > self.at and total > self.least / 2)
        if stalled > (self.stalled if total > HOPELESS * tolerance else STALLS):
            return None
        here = replace(self, stalled=stalled, least=min(self.least, total), at=self.degree)
        elements, parameters, cut = (float(e.max()) for e in (judged.elements, judged.parameters, judged.cut))
        goal = SHARE * tolerance
        if math.inf > parameters > max(elements, cut, goal) and self.added < MORE:
            missing = math.ceil(math.log(parameters / goal) / math.log(convergence(region)))
            return replace(here, more=self.more + max(missing, 1), added=self.added + 1)
        if math.inf > cut > max(elements, parameters, goal) and region.algebraic:
            wider = replace(here, sharper=self.sharper * cut / goal, widened=self.widened + 1)
            return wider if wider.widened <= WIDENED else None
        return replace(here, degree=self.degree + STEP) if self.degree < HIGHEST else None

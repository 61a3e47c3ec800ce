"""What is known before the data of each hypothesis that a result is averaged over, or its error holds: one table.

A ``Prior`` is the width of an amount, the odds of the hypothesis against the simpler one, and the limits that no body,
tip or instrument exceeds. ``WIDTHS`` scales all widths at once: results hardly depend on it (``make kinds``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

WIDTHS = 1.0  # choice: of all widths; halved and doubled by the study

RANGE, LONG, TENSION = "adhesion of finite range", "adhesion of long range (DMT)", "surface tension"


@dataclass(frozen=True)
class Prior:
    """What is known of an amount before the data.

    Parameters
    ----------
    size : float
        The amount in either direction that is likely unless the user or the data say otherwise; 0 of what the
        description of the body rules out.
    odds : float
        Of the hypothesis against the simpler one, or of an amount beyond the likely ones against those.
    limits : (float, float)
        Least and largest amounts that any body, tip or instrument has.
    """

    size: float = 0.0
    odds: float = 1.0
    limits: tuple[float, float] = (-math.inf, math.inf)

    @property
    def width(self) -> float:
        """The size, by ``WIDTHS``."""
        return WIDTHS * self.size

    @property
    def cost(self) -> float:
        """What the odds are of chi^2."""
        return -2 * math.log(self.odds)


UNLIKELY, POSITIVE = Prior(), (0.0, math.inf)
PRIORS = {
    # choice: [m], of molecules in dry contact 1 nm, of hairs more; theory: longer ones with odds of 1 to 20, exp(-3)
    RANGE: Prior(10e-9, math.exp(-3), limits=POSITIVE),
    LONG: Prior(limits=(0.0, 1.0)),  # theory: from JKR to DMT
    TENSION: Prior(limits=POSITIVE),  # choice: none, where nobody tells one
    # choice: exponent within which a tip is what it is called: by as much its radius of curvature changes over a factor
    # e of the contact radius; at most three times what a cone's differs from a paraboloid's by: one step overshoots
    "exponent of the tip": Prior(0.003, limits=(-3.0, 3.0)),
    "sphere or paraboloid": Prior(limits=(-1.0, 1.0)),  # theory: from one to the other
    "no slip": Prior(1.0, limits=POSITIVE),  # theory: from none to full
    "large strains": Prior(1.0, limits=(0.0, 2.0)),  # choice: of their effect on rubber, that of other materials
    "stiffness of the cantilever": Prior(limits=(-1.0, 1.0)),  # choice: relative, of one that someone measured
}

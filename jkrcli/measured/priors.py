"""What is known before the data of each hypothesis that a result is averaged over, or its error holds: one table.

A ``Prior`` is the width of an amount, the odds of the hypothesis against the simpler one, and the limits that no body,
tip or instrument exceeds. ``WIDTHS`` scales all widths at once: halved or doubled it moves no result by more than a
third of its half-width (``make kinds``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

WIDTHS = 1.0  # theory: of all widths as they stand

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
    limits : (float, float), optional
        Least and largest amounts that any body, tip or instrument has.
    over : str, optional
        What the size of a load beside the contact is over: the pull-off force, "tension", the range of the "load", or
        the "way" of the device.
    of_range : float, optional
        Standard deviation of the log of the range or the period of such a load.
    """

    size: float = 0.0
    odds: float = 1.0
    limits: tuple[float, float] = (-math.inf, math.inf)
    over: Literal["tension", "load", "way"] = "tension"
    of_range: float = 1.5

    @property
    def width(self) -> float:
        """The size, by ``WIDTHS``."""
        return WIDTHS * self.size

    @property
    def width_of_range(self) -> float:
        """The same of the log of a range."""
        return WIDTHS * self.of_range

    @property
    def spread(self) -> float:
        """Two standard deviations of an amount that is either none or as large as its width, at its odds."""
        return 2 * math.sqrt(self.odds) / (1 + self.odds) * self.width

    @property
    def cost(self) -> float:
        """What the odds are of chi^2."""
        return -2 * math.log(self.odds)


UNLIKELY, POSITIVE = Prior(), (0.0, math.inf)
PRIORS = {
    # What acts beside the contact:
    # choice: of all; a virtual deflection is one of 3 % of the largest load, a drift as large as a pull-off force
    "exponential": Prior(0.3, 1 / 9), "power": Prior(0.3, 1 / 9), "level": Prior(0.3, 1 / 9),
    "virtual deflection": Prior(0.03, 1 / 19, over="load", limits=(-1.0, 1.0)),
    "decaying drift": Prior(0.1, 1 / 19, over="load"), "interference": Prior(0.03, 1 / 19, over="load"),
    "relaxation in the dwell": Prior(0.01, 1.0, over="way"),
    # What body, tip, adhesion and instrument may be else:
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
    "stiffness of the cantilever": Prior(limits=(-0.5, 1.0)),  # choice: relative, a factor 2 of what someone measured
    "a rigid substrate below": Prior(limits=POSITIVE),
    # choice: standard deviation of the relative change along a table; w of polymers may double
    "a change of w along the curve": Prior(0.5), "a change of E* along the curve": Prior(0.5),
}  # fmt: skip

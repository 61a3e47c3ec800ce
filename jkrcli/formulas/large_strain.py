"""Pull-off of a rigid sphere from a thick incompressible body at large strains.

With wc = (w/(E* R))^(1/3), -P_min = 1.5 pi w R [1 + 0.046 wc + O(wc^2)] on a neo-Hookean half-space, nu = 1/2: the
cubic energy U3 = mu sum c_k D^(3-k) X^k, D = a^2/R, X = D - delta, c = -0.11569, 0.34707, -0.43430, 0.2002, as a
perturbation of JKR's; finite elements agree (0.003 at wc = 0.06). Under displacement control the same energy gives
0.116 wc. The second order depends on what w is the energy of: + 0.7 wc^2 per undeformed area, -4.5 wc^2 per deformed
area.
"""

from __future__ import annotations

import numpy as np

BY_LOAD, BY_DISPLACEMENT = 0.046, 0.116  # theory: of wc, the cubic energy at pull-off under either control
PER_DEFORMED, PER_UNDEFORMED = -4.5, 0.7  # theory: of wc^2, neo-Hookean finite elements
EXPANDED = 0.15  # theory: wc up to which the expansion is as good as the elements
MEASURED, LEAST, MOST = 0.3, -0.27, 0.06  # theory: the largest wc of the elements, and the changes there
SPHERE = 0.9  # theory: of wc^2, by which the exact sphere's pull-off in linear theory is below the paraboloid's


def strained_pull_off(wc: float, first: float = BY_LOAD, sphere: bool = False) -> tuple[float, float] | None:
    """Least and largest relative change of the pull-off force by large strains at ``wc``; None beyond 0.3.

    ``first``: coefficient of wc of the control. Linear between the end of the expansion and the last elements.
    ``sphere``: of the linear theory of the exact sphere, else of the paraboloid.
    """
    if wc > MEASURED:
        return None
    at, ends = min(wc, EXPANDED), (LEAST, MOST + (first - BY_LOAD) * MEASURED)
    expanded = (PER_DEFORMED * at**2, first * at + PER_UNDEFORMED * at**2)
    low, high = (float(np.interp(wc, (at, MEASURED), pair)) for pair in zip(expanded, ends, strict=True))
    own = 1 - SPHERE * wc**2 if sphere else 1.0
    return (1 + low) / own - 1, (1 + high) / own - 1

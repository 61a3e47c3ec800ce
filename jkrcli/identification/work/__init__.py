"""The work of adhesion along measured data: Eq. 13 solved for w at every measured point.

w = S'(a) (delta_H(a) - delta)^2/(4 pi a) is the energy release rate G of the contact's edge, whatever the specimen;
in equilibrium it is the work of adhesion, and along a curve recorded at speed its dependence on the edge's speed shows
the rate-dependent adhesion (Maugis and Barquins, J. Phys. D 11 (1978) 1989).
"""

from __future__ import annotations

from .along import PAIRS, Evaluation, WorkAlong, typical, work_along
from .radius import ABOVE, BELOW, NONE, OK

__all__ = ["ABOVE", "BELOW", "NONE", "OK", "PAIRS", "Evaluation", "WorkAlong", "typical", "work_along"]

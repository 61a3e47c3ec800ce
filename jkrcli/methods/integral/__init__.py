"""The Fredholm equation of axisymmetric contact, for any smooth kernel: kernel, quadrature, equation, densities, radii.

    phi(x) + (2/pi) int_0^a K(x,t) phi(t) dt = (2/pi) (delta - F(x)),    0 <= x <= a        (Lebedev-Ufliand)

A method of this kind knows the kernel K of its bodies (``layered`` from the compliance spectrum of a stack, ``hybrid``
from finite elements) and leaves the rest to this folder.
"""

from __future__ import annotations

from ...base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .attraction import Attraction, Discs, Rims, panels_for, refuse_narrow
    from .disc import disc_warnings, refuse_shrinking
    from .equation import ContactResult, DiscreteEquation, EquationResult, panel_means, solve
    from .kernel import CosineKernel, FredholmKernel
    from .pair import FLOPS_PER_SECOND, InaccurateError, first_stiffness, search, series_of, tolerance_remedy
    from .quadrature import (
        EXACT,
        Panels,
        Quadrature,
        crowded,
        crowded_rule,
        gauss,
        phase_allowed,
        rule,
        split,
        to_legendre,
    )
    from .stuck import StuckDisc, StuckKernel, ring_transforms

__getattr__ = lazily(__name__, __file__)

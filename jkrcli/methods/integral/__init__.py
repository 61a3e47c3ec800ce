"""The Fredholm equation of axisymmetric contact, for any smooth kernel: kernel, quadrature, equation, densities, radii.

    phi(x) + (2/pi) int_0^a K(x,t) phi(t) dt = (2/pi) (delta - F(x)),    0 <= x <= a        (Lebedev-Ufliand)

A method of this kind knows the kernel K of its bodies (``layered`` from the compliance spectrum of a stack, ``hybrid``
from finite elements) and leaves the rest to this folder.
"""

from __future__ import annotations

from ...base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .density import disc_warnings, refuse_shrinking
    from .finite_range import Attraction, Discs, Rims, panels_for, refuse_narrow
    from .fredholm import (
        EXACT,
        FLOPS_PER_SECOND,
        ContactResult,
        CosineKernel,
        DiscreteEquation,
        EquationResult,
        FredholmKernel,
        InaccurateError,
        Panels,
        Quadrature,
        crowded,
        crowded_rule,
        first_stiffness,
        gauss,
        panel_means,
        phase_allowed,
        rule,
        search,
        series_of,
        solve,
        split,
        to_legendre,
        tolerance_remedy,
    )
    from .no_slip import StuckDisc, StuckKernel, ring_transforms

__getattr__ = lazily(__name__, __file__)

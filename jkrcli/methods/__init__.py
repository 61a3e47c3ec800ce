"""Methods behind one interface: each is a frozen dataclass that is called with a problem and returns a solution.

A method makes itself known by a ``Descriptor``, from which the names, the order of "auto" and the tables of a case file
follow; its solver is imported when it is used. ``options.py`` registers the four methods and is light; a method of
one's own may register itself in any module that has been imported.
"""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .closed_form import ClosedForm
    from .fem.fields import ContactState, contact_state
    from .fem.mesh import write_msh, write_vtu
    from .fem.method import FEM
    from .finite_range import AttractedBody
    from .hybrid.method import Hybrid
    from .layered.solver import Layered, largest_radius, surface_profile
    from .protocol import (
        LESS,
        METHODS,
        Choice,
        Descriptor,
        Forecast,
        Limits,
        Method,
        Option,
        admit,
        choose_method,
        least_first,
        long_look,
        method_class,
        register,
        survey,
    )
    from .radii import DENSE

__getattr__ = lazily(__name__, __file__)

from . import options as _options  # noqa: E402  # registers the four methods

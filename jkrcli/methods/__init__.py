"""Methods behind one interface: each is a frozen dataclass that is called with a problem and returns a solution.

A method makes itself known by a ``Descriptor``, from which the names, the order of "auto" and the tables of a case file
follow; its solver is imported when it is used. Every folder here with a file ``options.py`` holds a method, and
that file registers it and must be light; a method of one's own may do so in any module that has been imported.
"""

from __future__ import annotations

import importlib
from pathlib import Path

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .attraction import AttractedBody
    from .choose import Choice, Option, choose_method, long_look, survey
    from .closed_form.method import ClosedForm
    from .fem.mesh import write_msh, write_vtu
    from .fem.method import FEM
    from .fem.state import ContactState, contact_state
    from .guards import LESS, Limits, admit
    from .hybrid.method import Hybrid
    from .layered.fields import surface_profile
    from .layered.layered import Layered, largest_radius
    from .protocol import METHODS, Descriptor, Forecast, Method, least_first, method_class, register
    from .radii import DENSE

__getattr__ = lazily(__name__, __file__)

for _folder in sorted(Path(__file__).parent.glob("*/options.py")):
    importlib.import_module(f"{__name__}.{_folder.parent.name}.options")

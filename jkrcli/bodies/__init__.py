"""What is pressed on what: indenters, materials, layers, loading; SI, no mesh, no work of adhesion."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .grading import LAWS, Exponential, Law, Linear, Power, Tabulated
    from .indenters import (
        SHAPES,
        Indenter,
        Paraboloid,
        PowerLaw,
        Pyramid,
        RoundedCone,
        RoundedFlat,
        Sphere,
        TableProfile,
    )
    from .materials import (
        GEL_TENSION,
        INCOMPRESSIBLE,
        Coated,
        Elastic,
        Graded,
        Layer,
        Material,
        Solid,
        TransverselyIsotropic,
        contact_modulus,
    )
    from .parts import RADIUS, alone, changed, checked_names, layer_names, nominal, stacks, unbounded
    from .problem import NO_FINITE_RANGE, HalfSpace, Loading, Problem, Quantity, Rigid, Side, Specimen
    from .relaxation import RELAXATIONS, Modes, PowerRelaxation, Prony, Relaxation, StandardSolid, relaxing

__getattr__ = lazily(__name__, __file__)

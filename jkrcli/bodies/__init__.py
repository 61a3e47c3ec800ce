"""What is pressed on what: indenters, materials, layers, loading; SI, no mesh, no work of adhesion."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
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
        LAWS,
        RELAXATIONS,
        AnyGraded,
        AnyTransverse,
        Coated,
        Elastic,
        Exponential,
        Graded,
        GradedTransverselyIsotropic,
        Law,
        Layer,
        Linear,
        Material,
        Modes,
        Power,
        PowerRelaxation,
        Prony,
        Relaxation,
        Solid,
        StandardSolid,
        Tabulated,
        TransverselyIsotropic,
        contact_modulus,
        relaxing,
        smooth_parts,
    )
    from .problem import (
        NO_FINITE_RANGE,
        RADIUS,
        HalfSpace,
        Loading,
        Problem,
        Quantity,
        Rigid,
        Side,
        Specimen,
        alone,
        changed,
        checked_names,
        layer_names,
        nominal,
        stacks,
        unbounded,
    )

__getattr__ = lazily(__name__, __file__)

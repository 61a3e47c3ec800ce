"""What the wing of bodies with side walls registers: the method ``hybrid``, and the kernel that it finds."""

from ..base.wings import Wing

WING = Wing(
    "hybrid",
    methods={"hybrid": "hybrid.options"},
    functions={"Hybrid": "hybrid.solver"},
    uses=("the kernel of a cylinder",),
    offers={"the kernel of a cylinder": "hybrid.attracted:AttractedCylinder"},
)

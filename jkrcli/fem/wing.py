"""What the wing of finite elements registers: the method ``fem``, its meshes, and states in the body."""

from ..base.wings import Verb, Wing

FIELDS = "Displacement and stress in the body, for ParaView."
WING = Wing(
    "fem",
    verbs={
        "mesh": Verb("More of a case", "", "Write and draw the finite-element mesh.", "fem.verbs"),
        "fields": Verb("More of an adhesive curve", "profile", FIELDS, "fem.verbs"),
    },
    methods={"fem": "fem.options"},
    functions={"FEM": "fem.solver"},
    uses=("finite elements", "table mesh", "table contact"),
    offers={
        "the surface by finite elements": "fem.report:surface_columns",
        "seconds of a state by finite elements": "fem.fields:seconds_of_state",
        "the mesher": "fem.report:mesher",
    },
)

"""What the wing of measured curves registers: reading and looking, fits, the work of adhesion along them."""

from ..base.wings import Verb, Wing

FUNCTIONS = (
    "Reading",
    "fit",
    "identify",
    "identify_joint",
    "identify_tension",
    "look",
    "measured_curves",
    "plan",
    "work",
)
WING = Wing(
    "measured",
    verbs={
        "look": Verb(
            "Commands", "pull-off", "What a force curve holds: base line, contact, adhesion.", "measured.verbs"
        ),
        "fit": Verb("Commands", "look", "E*, w and contact point of measured curves, with errors.", "measured.verbs"),
        "work": Verb("More of a measurement", "", "Energy release rate G along a measured curve.", "measured.verbs"),
    },
    options={"pull-off": ("--load", "--uncertain")},
    functions=dict.fromkeys(FUNCTIONS, "measured.functions"),
    uses=("measured curves",),
    offers={
        "options of a reading": "measured.readings:reading_options",
        "measured curves": "measured.readings:read_for",
        "options of a measured pull-off": "measured.readings:force_options",
        "idle options of a measured pull-off": "measured.pull_off:refuse_idle",
        "work of a measured pull-off": "measured.pull_off:works_of_force",
        "work of one pull-off": "measured.pull_off:work_of_force",
    },
)

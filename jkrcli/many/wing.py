"""What the wing of many bodies registers: sweeps, maps, studies, the page with sliders."""

from ..base.wings import Verb, Wing

WING = Wing(
    "many",
    verbs={
        "sweep": Verb("More of a case", "compare", "Solve many cases from one file, to one table.", "many.verbs"),
        "explore": Verb(
            "More of an adhesive curve", "export", "One page with sliders for w, modulus and stiffness.", "many.explore"
        ),
        "study": Verb("More", "", "Maps and studies over many bodies.", "many.verbs"),
        "bench": Verb("More", "study", "Time the stages of a run.", "many.verbs"),
    },
    functions={"study_map": "many.functions"},
)

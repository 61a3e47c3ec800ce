"""What the wing of many bodies registers: sweeps, maps, studies, the page with sliders."""

from ..base.wings import Verb, Wing

PAGE = "One page with sliders for w, modulus and stiffness."
WING = Wing(
    "many",
    verbs={
        "sweep": Verb("More of a case", "compare", "Solve many cases from one file, to one table.", "many.verbs"),
        "explore": Verb("More of an adhesive curve", "export", PAGE, "many.verbs"),
        "study": Verb("More", "", "Maps and studies over many bodies.", "many.verbs"),
        "bench": Verb("More", "study", "Time the stages of a run.", "many.verbs"),
    },
    functions={"study_map": "many.maps"},
)

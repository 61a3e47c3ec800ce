"""What the wing of many bodies and samples registers: sweeps, maps, studies, the page with sliders, samples of fits."""

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
    options={"fit": ("--sample", "--report"), "pull-off": ("--find",)},
    functions={"study_map": "many.maps", "find_value": "many.inverse"},
    offers={
        "samples of a fit": "many.samples:Samples",
        "report of a fit": "many.lab_report:LabReport",
        "option of the inverse question": "many.inverse:find_option",
        "the inverse question": "many.inverse:find_by_words",
    },
)

"""What the wing of many bodies and samples registers: sweeps, maps, studies, the page with sliders, samples of fits."""

from ..base.wings import Verb, Wing, is_offered

PAGE = "One page with sliders for w, modulus and stiffness."
WING = Wing(
    "many",
    verbs={
        "sweep": Verb("More of a case", "compare", "Solve many cases from one file, to one table.", "many.verbs"),
        "explore": Verb("More of an adhesive curve", "export", PAGE, "many.verbs"),
        "study": Verb("More", "", "Maps and studies over many bodies.", "many.verbs"),
        "bench": Verb("More", "study", "Time the stages of a run.", "many.verbs"),
    },
    options={"fit": ("--sample", "--report"), "pull-off": ("--find",), "export": ("--sizes",)},
    functions={"study_map": "many.maps", "find_value": "many.inverse"},
    offers={
        "samples of a fit": "many.samples:Samples",
        "report of a fit": "many.lab_report:LabReport",
        "option of the inverse question": "many.verbs:find_option",
        "the inverse question": "many.inverse:find_by_words",
        "option of particles of all sizes": "many.verbs:sizes_option",
        "law of particles of all sizes": "many.particles:OfSizes",
    },
)

MAPS = {
    "pull-off": "The pull-off force on a layer, in pi w R, over w R^2/(E* h^3).",
    "sticking": "Contact without slip over frictionless contact on a layer: S and load, over a/h.",
    "transition": "The pull-off force on a layer between JKR and DMT, over the range of adhesion.",
    "adhesion": "Which model of adhesion holds on a layer, over its range and the load.",
    "rate": "Pull-off force and energy lost over speed, stiffness and body.",
    "roughness": "What roughness leaves of w, over rms height and modulus.",
}


def maps() -> dict[str, str]:
    """The maps and what each shows; that over speeds where a wing knows of them."""
    return {name: words for name, words in MAPS.items() if name != "rate" or is_offered("contact of a law over speed")}

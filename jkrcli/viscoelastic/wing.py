"""What the wing of contact over time registers: adhesion over speed, viscoelastic bodies, their fits."""

from ..base.wings import Verb, Wing

CYCLE = "Force curve of an approach-retract cycle, over time too."
OF_CYCLE = """--rate --rate-advance --speed --speed-approach --hold --dwell --dwell-time --rest-load --rest-depth
--compare-rate"""
FUNCTIONS = ("LogRate", "PowerRate", "cycle_at_speed", "cycle_relaxing")
OF_FITS = ("identify_law", "identify_relaxation")
WING = Wing(
    "viscoelastic",
    verbs={"cycle": Verb("More of an adhesive curve", "", CYCLE, "viscoelastic.cycle", of_core=True)},
    options={
        "cycle": tuple(OF_CYCLE.split()),
        "fit": ("--law", "--relaxation", "--terms"),
        "pull-off": ("--rest-load", "--rest-depth"),
    },
    functions=dict.fromkeys(FUNCTIONS, "viscoelastic.functions") | dict.fromkeys(OF_FITS, "viscoelastic.fit_functions"),
    uses=("contact over time",),
    offers={
        "how a specimen that relaxes lets go": "viscoelastic.by_history:by_history",
        "options of a rest": "viscoelastic.options:rest_options",
        "options of laws over time": "viscoelastic.options:over_time",
        "a law of w over speed": "viscoelastic.rate:rate_law_of",
        "contact of a law over speed": "viscoelastic.rate:RateContact",
        "hypotheses over time": "viscoelastic.hypotheses:HYPOTHESES",
        "relaxation under adhesion": "viscoelastic.relaxing_alternative:with_relaxation",
        "law over speed": "viscoelastic.rate_fit:law_along",
        "summary of a law over speed": "viscoelastic.law_fits:through_summary",
        "words of a law over speed": "viscoelastic.law_fits:through_words",
        "fit of laws": "viscoelastic.fit_functions:fit_laws",
        "fit of a law over speed": "viscoelastic.fits:fit_law",
        "fit of a law of relaxation": "viscoelastic.fits:fit_relaxation",
    },
)

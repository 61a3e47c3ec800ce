"""The rules, one light file each: what is known of them before their functions are imported."""

from __future__ import annotations

from . import Rule, register

# --------------------------------------------------------------------------------------------------
# The rule "exact".

EXACT_SENTENCE = "The slopes that the series carries; nothing is smoothed."
register(Rule("exact", EXACT_SENTENCE, "jkrcli.adhesion.slopes.exact:exact"))


# --------------------------------------------------------------------------------------------------
# The rule "integral".

SENTENCE = "S' and d(delta_H)/da fitted through their integrals; nothing is differentiated."
register(Rule("integral", SENTENCE, "jkrcli.adhesion.slopes.integral:integral"))


# --------------------------------------------------------------------------------------------------
# The rules "loocv", the paper's, and "gcv", the same with another measure of the smoothing; of both S is re-evaluated
# by the smoothing spline, or kept from the cubic spline.

for _name, _left_out in (("loocv", "leave-one-out"), ("gcv", "generalised")):
    _sentence = f"Derivative of a spline P(delta), smoothed over a by {_left_out} cross-validation."
    register(Rule(_name, _sentence, f"jkrcli.adhesion.slopes.loocv:{_name}", optimistic=True, quantised=True))
    _sentence = f"As {_name}, with S kept from the spline P(delta): the paper's examples."
    register(
        Rule(f"{_name}-kept", _sentence, f"jkrcli.adhesion.slopes.loocv:{_name}_kept", optimistic=True, quantised=True)
    )

"""The rules "loocv", the paper's, and "gcv", the same with another measure of the smoothing."""

from __future__ import annotations

from .. import Rule, register

register(
    Rule(
        "loocv",
        "Derivative of a spline P(delta), smoothed over a by leave-one-out cross-validation.",
        "jkrcli.adhesion.slopes.loocv:loocv",
        optimistic=True,
    )
)
register(
    Rule(
        "gcv",
        "Derivative of a spline P(delta), smoothed over a by generalised cross-validation.",
        "jkrcli.adhesion.slopes.loocv:gcv",
        optimistic=True,
    )
)

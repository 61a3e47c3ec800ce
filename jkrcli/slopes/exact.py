"""Slopes that the series carries itself: nothing is differentiated."""

from __future__ import annotations

from ..errors import Refusal
from ..series import Series
from .result import Slopes, covariance_from_errors


def exact(series: Series) -> Slopes:
    """S and S' of the series as they are; refused where the method that made it does not know them."""
    if series.S is None or series.dS is None:
        raise Refusal(
            "slopes: this series carries no exact S and dS/da; use the slopes 'integral' or 'loocv', or a method that "
            "gives them (closed-form, layered)"
        )
    covariance = covariance_from_errors(series, series.S, series.dS)
    return Slopes(series.S, series.dS, "exact", error="no smoothing was done", covariance=covariance)

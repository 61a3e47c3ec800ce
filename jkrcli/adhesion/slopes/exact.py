"""Slopes that the series carries itself: nothing is smoothed."""

from __future__ import annotations

from ...base.errors import Refusal, Unknown
from ...series import Series
from .result import TWO_SIDED_90, Slopes, covariance_from_errors, shift_error

NOT_STATED = Unknown("no error is stated")


def exact(series: Series) -> Slopes:
    """S and S' of the series as they are; refused where the method that made it does not know them."""
    if series.S is None or series.dS is None:
        raise Refusal(
            "slopes: this series carries no exact S and dS/da; use the slopes 'integral' or 'loocv', or a method that "
            "gives them (closed-form, layered, hybrid; fem with edge correction and error estimate)"
        )
    covariance = covariance_from_errors(series.a, series.errors, series.dS)
    error = NOT_STATED if covariance is None else shift_error(series.dS, covariance, TWO_SIDED_90)
    return Slopes(series.S, series.dS, "exact", error=error, covariance=covariance)

"""Slopes of a series by the requested rule, or by the surest: what "auto" takes, and why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...base.errors import InputError, Unknown
from ...base.numerics import UNSEEN, Array
from ...series import RawSeries, Series
from . import slopes_function
from .node_radii import AS_THEY_ARE, Ahead
from .result import Slopes

# When "auto" takes the slopes that a series carries.
# of the radii at which a smooth fit may leave their error; choice: half of what 90 % intervals leave
CHOICE_FEW = 0.05


def slopes(series: Series, name: str = "auto", against: tuple[Series, Slopes] | None = None) -> Slopes:
    """S and S' of ``series``; "auto" takes those that the series carries, unless they are no better than a smooth fit
    that agrees with them; else the surer estimate. ``against``: by what a rule that does not see its own error is
    judged, where other rows than those of the series tell more."""
    if name != "auto":
        rule = slopes_function(name)
        by_rule = rule(series)
        if rule.optimistic:
            if against is None:
                fitted = _integral_or_none(series)
            else:  # the slopes of the other rows at these radii, power laws between their own
                other, fitted = against
                x, known = np.log(series.a), np.log(other.a)
                S, dS = (np.exp(np.interp(x, known, np.log(values))) for values in (fitted.S, fitted.dS))
                fitted = replace(fitted, S=S, dS=dS)
            by_rule = replace(_measured_against(by_rule, fitted), against=against)
        return replace(by_rule, reason=f"requested; {by_rule.reason}" if by_rule.reason else "requested")
    if series.S is not None and series.dS is not None:
        return _carried(series)
    return _surer(series)


def _carried(series: Series) -> Slopes:
    """The slopes that the series carries; or, where their stated error is noticeable and the fit "integral" stays
    within it, that fit: it smooths the scatter of differences. At a flat end, where S' jumps, and where the profile
    bends it errs more."""
    exact = slopes_function("exact")(series)
    if isinstance(exact.error, Unknown) or exact.error <= UNSEEN or "dS" not in series.errors:
        return replace(exact, reason="the solution carries exact slopes")
    if series.a0 > 0:
        reason = "a smooth fit errs at the edge of the flat end"
    elif any(series.a[0] < bend < series.a[-1] for bend in series.bends):
        reason = "a smooth fit errs at kinks of the profile"
    elif (fitted := _integral_or_none(series)) is None or fitted.flags:
        reason = "'integral' does not converge"
    elif (beyond := np.mean(np.abs(fitted.dS - exact.dS) > series.errors["dS"])) > CHOICE_FEW:
        reason = f"'integral' deviates by more than their stated error at {beyond:.0%} of the radii"
    else:
        reason = f"smoother than the slopes that the solution carries, within their stated error ({exact.error:.1g})"
        return replace(fitted, reason=reason)
    return replace(exact, reason=f"the solution carries slopes, and {reason}")


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, own: Series | None = None, ahead: Ahead = AS_THEY_ARE,
    load_errors: Array | None = None,
) -> tuple[Series, Slopes]:  # fmt: skip
    """Series and slopes straight from increments, noisy or with repeated radii, by the method "integral"."""
    from .integral import smoothed as fitted

    series, fit = fitted(raw, a0, S0, own, ahead, load_errors)
    return series, replace(fit, reason=f"the increments themselves were fitted{_towards(own)}{_unseen(fit)}")


def _towards(own: Series | None) -> str:
    """What the rows were smoothed towards, where their bodies have a solution of their own."""
    return "" if own is None else ", smoothed towards the shape of these bodies' own solution"


def _unseen(fitted: Slopes) -> str:
    """What the noise of few points does not tell."""
    return f"; {fitted.correlation}" if isinstance(fitted.correlation, Unknown) else ""


def _integral_or_none(series: Series) -> Slopes | None:
    try:
        return slopes_function("integral")(series)
    except InputError:
        return None


def _measured_against(paper: Slopes, fitted: Slopes | None) -> Slopes:
    """The slopes of "loocv" with an error (and a band) no smaller than their distance from those of "integral".

    A smoothing spline cannot see the error of what it is given, a derivative of the data: its own estimate is often
    20 to 100 times too small on series of finite elements.
    """
    if fitted is None:
        return paper
    distance = float(np.quantile(np.abs(np.sqrt(paper.dS / fitted.dS) - 1), 0.9))
    if isinstance(paper.error, float) and distance <= paper.error:
        return paper
    covariance = paper.covariance
    if covariance is not None and isinstance(paper.error, float) and paper.error > 0:
        covariance = covariance * (distance / paper.error) ** 2
    return replace(paper, error=distance, covariance=covariance)


def _surer(series: Series) -> Slopes:
    """The slopes of "integral" or "loocv", those with the smaller estimate of their error."""
    fitted = slopes_function("integral")(series)
    if fitted.correlation is not None:
        reason = f"the solution is noisy and carries no exact slopes{_towards(series.own)}{_unseen(fitted)}"
        return replace(fitted, reason=reason)
    try:
        paper = _measured_against(slopes_function("loocv")(series), fitted)
    except InputError:
        return replace(fitted, reason="the solution carries no exact slopes, and those of 'loocv' are not positive")
    if _number(paper) < _number(fitted):
        fitted, paper = paper, fitted
    others = f"by {paper.method!r} {_words(paper)}"
    return replace(fitted, reason=f"the solution carries no exact slopes; estimated error {_words(fitted)}, {others}")


def _number(fitted: Slopes) -> float:
    return math.inf if isinstance(fitted.error, Unknown) else fitted.error


def _words(fitted: Slopes) -> str:
    return str(fitted.error) if isinstance(fitted.error, Unknown) else f"{fitted.error:.1g}"

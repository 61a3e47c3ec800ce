"""Slopes S = dP/d(delta) and S' = dS/da of a nonadhesive series: what they are, and what "auto" takes of the rules."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ...base.errors import Estimate, InputError, Refusal, Unknown
from ...base.numerics import HALF_WIDTH, UNSEEN, Array
from ...series import COLUMNS, RawSeries, Series
from ..rules import slopes_function
from .nodes import AS_THEY_ARE, Ahead

# --------------------------------------------------------------------------------------------------
# The result type that every way of finding S and S' shares.

Signs: TypeAlias = tuple[int, int, int, int]

# How errors of columns go together.
# Of the variances, what is common to columns that err together:
ERROR_COMMON = 0.9  # tuned on random bodies, by `make bounds`
# Signs of common errors of (delta_H, P_H, S, S'):
ERROR_AT_RADIUS = (-1, 0, 1, 1)  # theory: a spring in series
ERROR_AT_DISPLACEMENT = (0, 1, 1, 1)  # theory: a stiffness that is too large


@dataclass(frozen=True, eq=False)
class Slopes:
    """S = dP/d(delta) [N/m] and S' = dS/da [N/m^2] at the radii of a series, both arrays of shape (n,).

    ``delta, P``: the nonadhesive columns as the same fit sees them, where the method smooths them too, else None.
    ``covariance``: shape (n, 4, 4), of (delta_H, P_H, S, S') at each radius, SI; None where no error is known.
    ``joint``: shape (n, 6, 6), the same with d(delta_H)/da and S'' behind them, where the method knows their errors; in
    noise with no more smoothing bias than there is away from the ends.
    ``quantile``: standard deviations in the half-width of an interval (more than ``HALF_WIDTH`` for few points).
    ``correlation``: of the errors of neighbouring rows as the residuals have it; None where they are no noise.
    ``error``: relative half-width of sqrt(a/S'), the median over the points, or why it is unknown.
    ``derived``: whether S' is the derivative of S, or S was kept apart from the smooth curve that S' comes from.
    ``flags``: sentences on where the slopes are to be trusted less; ``reason``: why this method was taken.
    ``against``: by what a rule that does not see its own error is judged, the slopes "integral" with their series,
    where they are of other rows than its own; ``other``: slopes of another rule at the same radii, where these were
    computed and are others: errors that deny it are not stated.
    """

    S: Array
    dS: Array
    method: str
    error: Estimate
    smoothing_lambda: float | None = None
    flags: tuple[str, ...] = ()
    reason: str = ""
    delta: Array | None = None
    P: Array | None = None
    covariance: Array | None = None
    joint: Array | None = None
    quantile: float = HALF_WIDTH
    correlation: Estimate | None = None
    derived: bool = True
    against: tuple[Series, Slopes] | None = None
    other: Slopes | None = None

    def scaled(self, factor: float) -> Slopes:
        """The slopes of the same bodies with all moduli multiplied by ``factor``; ``delta`` does not change."""
        against = None if self.against is None else (self.against[0].scaled(factor), self.against[1].scaled(factor))
        other = None if self.other is None else self.other.scaled(factor)
        return replace(self._times(1.0, factor, factor, factor, 1.0, factor), against=against, other=other)

    def under_profile(self, factor: float) -> Slopes:
        """The slopes of the same bodies under an indenter whose profile is ``factor`` times as high."""
        other = None if self.other is None else self.other.under_profile(factor)
        return replace(self._times(factor, factor, 1.0, 1.0, factor, 1.0), other=other)

    def _times(self, *factors: float) -> Slopes:
        """The slopes with delta, P, S, S', d(delta_H)/da and S'' multiplied by a factor each."""
        by = np.array(factors)
        delta, P = (None if one is None else one * each for one, each in zip((self.delta, self.P), by[:2], strict=True))
        covariance = None if self.covariance is None else self.covariance * np.outer(by[:4], by[:4])
        joint = None if self.joint is None else self.joint * np.outer(by, by)
        S, dS = self.S * by[2], self.dS * by[3]
        return replace(self, delta=delta, P=P, S=S, dS=dS, covariance=covariance, joint=joint)

    @property
    def dS_err(self) -> Array | None:
        """Half-width of S' [N/m^2]."""
        return None if self.covariance is None else self.quantile * np.sqrt(self.covariance[:, 3, 3])


def covariance_from_errors(
    a: Array, errors: Mapping[str, Array], dS: Array, signs: Signs = ERROR_AT_RADIUS, common: float = ERROR_COMMON
) -> Array | None:
    """Covariance (n, 4, 4) of (delta_H, P_H, S, S') at radii ``a`` from a series' ``errors``, half-widths; None
    where there are none.

    ``signs``: of what columns share, ``common`` of their variance. Errors of one body's compliance, as those of meshes
    and cuts mostly are, move S and S' up and delta down together and leave P, like a spring in series. An error of the
    radius acts on the curve through t = sqrt(4 pi w a/S'): a contact radius that is wrong by a fraction e makes
    S' = dS/da wrong by -e too, so t by e. It is carried as an error 2 e of S', which does the same.
    """
    if not errors:
        return None
    sigma = {name: errors.get(name, np.zeros(a.size)) / HALF_WIDTH for name in COLUMNS}
    rows = np.stack([sigma[name] for name in ("delta", "P", "S", "dS")], axis=1)
    together = common * np.outer(signs, signs)
    np.fill_diagonal(together, 1.0)
    covariance = rows[:, :, None] * rows[:, None, :] * together
    covariance[:, 3, 3] += (2 * dS * sigma["a"] / a) ** 2
    return covariance


def shift_error(dS: Array, covariance: Array, quantile: float) -> float:
    """Relative half-width of sqrt(a/S'), the median over the points."""
    return float(np.median(quantile * np.sqrt(covariance[:, 3, 3]) / (2 * dS)))


# --------------------------------------------------------------------------------------------------
# Slopes that the series carries itself: nothing is smoothed.

NOT_STATED = Unknown("no error is stated")


def exact(series: Series) -> Slopes:
    """S and S' of the series as they are; refused where the method that made it does not know them."""
    if series.S is None or series.dS is None:
        raise Refusal(
            "slopes: this solution carries no exact S and dS/da; use the slopes 'integral' or 'loocv', or a method "
            "that gives them (closed-form, layered, hybrid; fem with edge correction and error estimate)"
        )
    covariance = covariance_from_errors(series.a, series.errors, series.dS)
    error = NOT_STATED if covariance is None else shift_error(series.dS, covariance, HALF_WIDTH)
    return Slopes(series.S, series.dS, "exact", error=error, covariance=covariance)


# --------------------------------------------------------------------------------------------------
# Slopes of a series by the requested rule, or by the surest: what "auto" takes, and why.

# When "auto" takes the slopes that a series carries.
# of the radii at which a smooth fit may leave their error; choice: what intervals leave
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
            by_rule = replace(_measured_against(by_rule, fitted, series.rim < math.inf), against=against)
        return replace(by_rule, reason=f"requested; {by_rule.reason}" if by_rule.reason else "requested")
    if series.S is not None and series.dS is not None:
        return _carried(series)
    # The slopes of "integral" or "loocv", those with the smaller estimate of their error
    fitted = slopes_function("integral")(series)
    if fitted.correlation is not None:
        reason = f"the solution is noisy and carries no exact slopes{_towards(series.own)}{_unseen(fitted)}"
        return replace(fitted, reason=reason)
    try:
        paper = _measured_against(slopes_function("loocv")(series), fitted, series.rim < math.inf)
    except InputError:
        return replace(fitted, reason="the solution carries no exact slopes, and those of 'loocv' are not positive")
    if _number(paper) < _number(fitted):
        fitted, paper = paper, fitted
    others = f"by {paper.method!r} {_words(paper)}"
    return replace(fitted, reason=f"the solution carries no exact slopes; estimated error {_words(fitted)}, {others}")


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
        exact = replace(exact, other=fitted)
    else:
        reason = f"smoother than the slopes that the solution carries, within their stated error ({exact.error:.1g})"
        return replace(fitted, reason=reason)
    return replace(exact, reason=f"the solution carries slopes, and {reason}")


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, own: Series | None = None, ahead: Ahead = AS_THEY_ARE,
    load_errors: Array | None = None,
) -> tuple[Series, Slopes]:  # fmt: skip
    """Series and slopes straight from increments, noisy or with repeated radii, by the method "integral"."""
    module = importlib.import_module(f"{__name__}.integral")  # with what of SciPy it takes
    series, fit = module.smoothed(raw, a0, S0, own, ahead, load_errors)
    return series, replace(fit, reason=f"the increments themselves were fitted{_towards(own)}{_unseen(fit)}")


def _towards(own: Series | None) -> str:
    """For ``reason``: that rows were smoothed towards the bodies' ``own`` solution; "" without one."""
    return "" if own is None else ", smoothed towards the shape of these bodies' own solution"


def _unseen(fitted: Slopes) -> str:
    """Why the correlation of the errors is not known, for ``reason``; "" where it is."""
    return f"; {fitted.correlation}" if isinstance(fitted.correlation, Unknown) else ""


def _integral_or_none(series: Series) -> Slopes | None:
    try:
        return slopes_function("integral")(series)
    except InputError:
        return None


def _measured_against(paper: Slopes, fitted: Slopes | None, full: bool) -> Slopes:
    """The slopes of "loocv" with an error (and a band) no smaller than their distance from those of "integral".

    A smoothing spline cannot see the error of what it is given, a derivative of the data: its own estimate is often
    20 to 100 times too small on series of finite elements. ``full``: a flat end, where pull-off is at the end of the
    spline, whose bias is in its estimate already.
    """
    if fitted is None:
        return paper
    off = np.abs(np.sqrt(paper.dS / fitted.dS) - 1)
    distance = float(np.quantile(off, 0.9))
    if isinstance(paper.error, float) and distance <= paper.error:
        return paper
    covariance = paper.covariance
    if covariance is not None and isinstance(paper.error, float) and paper.error > 0:
        own = paper.quantile * np.sqrt(covariance[:, 3, 3]) / (2 * paper.dS)
        enough = np.clip(off.max() / own, 1.0, distance / paper.error)[:, None, None]
        covariance = covariance * (enough if full else distance / paper.error) ** 2
    return replace(paper, error=distance, covariance=covariance)


def _number(fitted: Slopes) -> float:
    return math.inf if isinstance(fitted.error, Unknown) else fitted.error


def _words(fitted: Slopes) -> str:
    return str(fitted.error) if isinstance(fitted.error, Unknown) else f"{fitted.error:.1g}"

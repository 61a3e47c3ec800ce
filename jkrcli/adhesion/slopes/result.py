"""The result type that every way of finding S and S' shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import TypeAlias

import numpy as np

from ...base.errors import Estimate, Refusal, Unknown
from ...base.numerics import Array
from ...series import COLUMNS, Series

Signs: TypeAlias = tuple[int, int, int, int]
TWO_SIDED_90 = NormalDist().inv_cdf(0.95)  # half-width of a 90 % interval in standard deviations

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
    ``quantile``: standard deviations in the half-width of a 90 % interval (more than 1.64 for few points).
    ``correlation``: of the errors of neighbouring rows as the residuals have it; None where they are no noise.
    ``error``: relative 90 % half-width of sqrt(a/S'), the median over the points, or why it is unknown.
    ``derived``: whether S' is the derivative of S, or S was kept apart from the smooth curve that S' comes from.
    ``flags``: sentences on where the slopes are to be trusted less; ``reason``: why this method was taken.
    ``against``: by what a rule that does not see its own error is judged, the slopes "integral" with their series,
    where they are of other rows than its own.
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
    quantile: float = TWO_SIDED_90
    correlation: Estimate | None = None
    derived: bool = True
    against: tuple[Series, Slopes] | None = None

    def scaled(self, factor: float) -> Slopes:
        """The slopes of the same bodies with all moduli multiplied by ``factor``; ``delta`` does not change."""
        P = None if self.P is None else self.P * factor
        by = np.array([1.0, factor, factor, factor])
        covariance = None if self.covariance is None else self.covariance * np.outer(by, by)
        by = np.append(by, [1.0, factor])
        joint = None if self.joint is None else self.joint * np.outer(by, by)
        against = None if self.against is None else (self.against[0].scaled(factor), self.against[1].scaled(factor))
        return replace(
            self, S=self.S * factor, dS=self.dS * factor, P=P, covariance=covariance, joint=joint, against=against
        )

    def under_profile(self, factor: float) -> Slopes:
        """The slopes of the same bodies under an indenter whose profile is ``factor`` times as high."""
        delta, P = (None if values is None else values * factor for values in (self.delta, self.P))
        by = np.array([factor, factor, 1.0, 1.0, factor, 1.0])
        covariance = None if self.covariance is None else self.covariance * np.outer(by[:4], by[:4])
        joint = None if self.joint is None else self.joint * np.outer(by, by)
        return replace(self, delta=delta, P=P, covariance=covariance, joint=joint)

    @property
    def dS_err(self) -> Array | None:
        """90 % half-width of S' [N/m^2]."""
        return None if self.covariance is None else self.quantile * np.sqrt(self.covariance[:, 3, 3])


def covariance_from_errors(
    a: Array, errors: Mapping[str, Array], dS: Array, signs: Signs = ERROR_AT_RADIUS, common: float = ERROR_COMMON
) -> Array | None:
    """Covariance (n, 4, 4) of (delta_H, P_H, S, S') at radii ``a`` from a series' ``errors``, 90 % half-widths; None
    where there are none.

    ``signs``: of what columns share, ``common`` of their variance. Errors of one body's compliance, as those of meshes
    and cuts mostly are, move S and S' up and delta down together and leave P, like a spring in series. An error of the
    radius acts on the curve through t = sqrt(4 pi w a/S'): a contact radius that is wrong by a fraction e makes
    S' = dS/da wrong by -e too, so t by e. It is carried as an error 2 e of S', which does the same.
    """
    if not errors:
        return None
    sigma = {name: errors.get(name, np.zeros(a.size)) / TWO_SIDED_90 for name in COLUMNS}
    rows = np.stack([sigma[name] for name in ("delta", "P", "S", "dS")], axis=1)
    together = common * np.outer(signs, signs)
    np.fill_diagonal(together, 1.0)
    covariance = rows[:, :, None] * rows[:, None, :] * together
    covariance[:, 3, 3] += (2 * dS * sigma["a"] / a) ** 2
    return covariance


def shift_error(dS: Array, covariance: Array, quantile: float) -> float:
    """Relative 90 % half-width of sqrt(a/S'), the median over the points."""
    return float(np.median(quantile * np.sqrt(covariance[:, 3, 3]) / (2 * dS)))


# --------------------------------------------------------------------------------------------------
# Slopes that the series carries itself: nothing is smoothed.

NOT_STATED = Unknown("no error is stated")


def exact(series: Series) -> Slopes:
    """S and S' of the series as they are; refused where the method that made it does not know them."""
    if series.S is None or series.dS is None:
        raise Refusal(
            "slopes: this solution carries no exact S and dS/da; use the slopes 'integral' or 'loocv', or a method "
            "that "
            "gives them (closed-form, layered, hybrid; fem with edge correction and error estimate)"
        )
    covariance = covariance_from_errors(series.a, series.errors, series.dS)
    error = NOT_STATED if covariance is None else shift_error(series.dS, covariance, TWO_SIDED_90)
    return Slopes(series.S, series.dS, "exact", error=error, covariance=covariance)

"""The result of a fit: parameters with their uncertainty, residuals, and what a reader should know."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from sys import float_info

import numpy as np
from scipy.special import ndtri

from ...base import Array, InputError, Unknown
from ...data import Pixel
from .record_scores import Verdict
from .settings import Settings
from .statistics import Structure

ONE_SIDED = float(ndtri(0.95) / ndtri(0.975))  # theory: one-sided over two-sided 95 % of a normal value


@dataclass(frozen=True)
class FittedValue:
    """A parameter or what follows from it, SI. ``error``: standard error, ``low, high``: the confidence interval;
    None where the data do not tell, or where it is fixed. ``systematic``: from uncertain inputs, by name,
    held in the interval; ``model``: half-widths from models near this one that the data do not exclude, beside it."""

    name: str
    value: float
    free: bool
    dimension: str
    error: float | None = None
    low: float | None = None
    high: float | None = None
    systematic: Mapping[str, float] | None = None
    model: Mapping[str, float] | None = None


def estimated(
    name: str, x: float, dimension: str, sigma: float | None, t: float, log: bool = False,
    ends: tuple[float, float] = (-math.inf, math.inf),
) -> FittedValue:  # fmt: skip
    """The estimate of a free unknown ``x``, the ``log`` of a value or the value itself, within its ``ends``, by its
    standard error ``sigma`` and the half-width of the interval in these, ``t``."""
    value = math.exp(min(x, float_info.max_10_exp)) if log else x
    if sigma is None:
        return FittedValue(name, value, True, dimension)
    if not log:
        low, high = max(x - t * sigma, ends[0]), min(x + t * sigma, ends[1])
        return FittedValue(name, value, True, dimension, sigma, low, high)
    spread = math.exp(min(t * sigma, float_info.max_10_exp))
    return FittedValue(name, value, True, dimension, value * sigma, value / spread, value * spread)


def estimated_work(name: str, value: float, error: float, t: float) -> FittedValue:
    """w [J/m^2] that a search may have found below 0: an interval, or an upper limit where it does not exclude 0."""
    if value > t * error:
        return FittedValue(name, value, True, "work", error, value - t * error, value + t * error)
    value = max(value, 0.0)
    return FittedValue(name, value, True, "work", error, 0.0, value + ONE_SIDED * t * error)


def times(item: FittedValue, factor: float, name: str, dimension: str) -> FittedValue:
    """What is ``factor`` times an estimate, under its own ``name``."""
    error, low, high = (None if end is None else end * factor for end in (item.error, item.low, item.high))
    return FittedValue(name, item.value * factor, item.free, dimension, error, low, high)


@dataclass(frozen=True)
class JKRBeside:
    """JKR's nearest curve to rows that were fitted with a range: ``E_star`` [Pa], ``w`` [J/m^2], the root mean squares
    of the residuals, ``rms`` and ``rms_of_range``, in the same units, and how much larger half the sum of losses
    is; ``values`` of all its parameters, SI."""

    E_star: float
    w: float
    rms: float
    rms_of_range: float
    excess: float
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Further:
    """A measurement in ``words``, and the relative standard errors of E* and w with it; of "now" without."""

    words: str
    E_star: float
    w: float


@dataclass(frozen=True, eq=False)
class Fit:
    """One fitted curve: plain numbers, light to send between processes.

    ``name`` of the curve in its ``file``, ``where``: both, for messages. ``estimates``: the parameters, then what
    follows from them (E_star, moduli of layers); ``covariance``: of the free parameters ``free``, SI, None where
    the data do not tell them apart; ``samples``: their bootstrap values (n, free). ``data``: the readings that were
    used, of the ``rows`` of the curve; ``left_out``: why others were not. ``a``: contact radius at each foot point
    [m]; ``residuals`` (k, n): signed normal distances (k = 1), or for three columns distance vectors (k = 3), in
    units of ``scales``; ``scatter``: their standard deviation, ``dof`` their degrees of freedom. ``line``: the
    fitted curve, readings by column and "a". ``warnings``: sentences with numbers. ``flags``: what is wrong with a
    raw record, in a word or two each; ``surface``: what the surfaces were taken to do; ``quality``: of a raw
    record, between 0 and 1, with its parts, None where readings were prepared; ``adhesion``: its largest tension on
    retraction [N], None where none is told; ``directions``: of it that were fitted. ``pixel``: in a map. ``jkr``: of a
    fit with a range, JKR beside it; ``range_left``: of a fit of JKR, the longest range [m] that the rows leave, None
    where none was tried; ``verdict``: of a raw record, on its rivals; ``plan``: what further
    measurements would tell, where that was asked.
    """

    name: str
    file: str
    where: str
    estimates: tuple[FittedValue, ...]
    free: tuple[str, ...]
    covariance: Array | None
    samples: Array | None
    data: Mapping[str, Array]
    rows: Array
    left_out: tuple[str, ...]
    a: Array
    residuals: Array
    scales: Mapping[str, float]
    scatter: float
    dof: int
    structure: Structure
    line: Mapping[str, Array]
    evaluations: int
    settings: Settings
    warnings: tuple[str, ...]
    flags: tuple[str, ...] = ()
    quality: Mapping[str, float] | None = None
    surface: str = "sliding"
    adhesion: float | None = None
    pixel: Pixel | None = None
    jkr: JKRBeside | Unknown | None = None
    range_left: float | None = None
    directions: str = ""
    verdict: Verdict | None = None
    plan: tuple[Further, ...] = ()

    @property
    def correlation(self) -> Array | None:
        """Correlation coefficients of the free parameters."""
        if self.covariance is None:
            return None
        sigma = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(sigma, sigma)

    def correlated(self, one: str, two: str) -> float | None:
        """Correlation coefficient of two free parameters; None where there is none."""
        matrix = self.correlation
        if matrix is None or not {one, two} <= set(self.free):
            return None
        return float(matrix[self.free.index(one), self.free.index(two)])

    def estimate(self, name: str) -> FittedValue:
        """The estimate called ``name``."""
        known = {item.name: item for item in self.estimates}
        if name not in known:
            raise InputError(f'no estimate is called "{name}" (there are: {", ".join(known)})')
        return known[name]

    @property
    def work(self) -> FittedValue:
        """The work of adhesion; of an approach alone its own."""
        return self.estimate("w" if any(item.name == "w" for item in self.estimates) else "w_approach")

    def value(self, name: str) -> float:
        """The value called ``name``, SI."""
        return self.estimate(name).value

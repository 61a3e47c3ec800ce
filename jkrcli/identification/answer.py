"""The result of any fit: values with their errors and intervals, their correlations, and warnings on both."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..base import Array, InputError


@dataclass(frozen=True)
class AnswerTuning:
    """Limits beyond which a reader is warned; nothing else depends on them."""

    apart: float = 0.99  # choice: correlation beyond which the data hardly separate two parameters
    vague: float = 0.3  # choice: relative standard error beyond which a value is little more than its order


TUNING = AnswerTuning()


@dataclass(frozen=True)
class FittedValue:
    """A parameter or what follows from it, SI. ``error``: standard error, ``low, high``: the confidence interval;
    None where the data do not determine it, or where it is fixed. ``systematic``: from uncertain inputs, by name, part
    of the interval; ``model``: half-widths from models near this one that the data do not exclude, beside it."""

    name: str
    value: float
    free: bool
    dimension: str
    error: float | None = None
    low: float | None = None
    high: float | None = None
    systematic: Mapping[str, float] | None = None
    model: Mapping[str, float] | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Answer:
    """``estimates``: the parameters, then what follows from them; ``free``: names of those that were fitted, with their
    ``covariance`` (of SI values, or of logs), None where the data do not separate them; ``dof``: degrees of freedom;
    ``warnings``: sentences."""

    estimates: tuple[FittedValue, ...]
    free: tuple[str, ...]
    covariance: Array | None
    dof: int
    warnings: tuple[str, ...] = ()

    def estimate(self, name: str) -> FittedValue:
        """The estimate called ``name``."""
        known = {item.name: item for item in self.estimates}
        if name not in known:
            raise InputError(f'no estimate is called "{name}" (there are: {", ".join(known)})')
        return known[name]

    def value(self, name: str) -> float:
        """The value called ``name``, SI."""
        return self.estimate(name).value

    @property
    def correlation(self) -> Array | None:
        """Correlation coefficients of the free parameters; 0 of one that has no variance, as a w whose root is 0."""
        if self.covariance is None:
            return None
        variance = np.diag(self.covariance)
        sigma = np.sqrt(np.where(variance > 0, variance, 1.0))
        return self.covariance / np.outer(sigma, sigma)

    def correlated(self, one: str, two: str) -> float | None:
        """Correlation coefficient of two free parameters; None where there is none."""
        if (matrix := self.correlation) is None or not {one, two} <= set(self.free):
            return None
        return float(matrix[self.free.index(one), self.free.index(two)])

    @property
    def hardly_apart(self) -> Iterator[tuple[str, str, str]]:
        """Pairs of free parameters that the data hardly separate, with a sentence on each."""
        if (matrix := self.correlation) is None:
            return
        for (i, one), (j, two) in itertools.combinations(enumerate(self.free), 2):
            if abs(matrix[i, j]) > TUNING.apart:
                yield one, two, f"{word(one)} and {word(two)} are strongly correlated ({matrix[i, j]:.4f})"

    def vague(self, names: Sequence[str]) -> Iterator[str]:
        """A sentence on each of these that is little more than its order."""
        for item in map(self.estimate, names):
            if item.error is not None and item.error > TUNING.vague * item.value > 0:
                yield f"{word(item.name)} is uncertain by {item.error / item.value:.0%} (standard error)"


def word(name: str) -> str:
    """What a parameter is called in sentences."""
    return "E*" if name in ("modulus", "E_star") else name

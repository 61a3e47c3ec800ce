"""Distributions of uncertain numbers, and draws: inverse distribution functions of points in the unit cube."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .arrays import Array
from .errors import InputError

LIMITS = {"least": -math.inf, "most": math.inf}  # of what is cut off


class Kind(NamedTuple):
    """A kind of distribution: the parameters that it needs, the values ``at`` fractions of all draws (n,) by these and
    its ``limits``, and the parameter that must be ``positive``."""

    needed: tuple[str, ...]
    at: Callable[..., Array]
    positive: str = ""
    limits: Mapping[str, float] = {}


def _normal(u: Array, mean: float, sd: float, least: float, most: float) -> Array:
    from scipy.special import ndtr, ndtri

    low, high = ndtr((least - mean) / sd), ndtr((most - mean) / sd)
    return np.clip(mean + sd * ndtri(low + (high - low) * u), least, most)


def _lognormal(u: Array, median: float, factor: float, *limits: float) -> Array:
    cut = (math.log(x) if x > 0 else -math.inf for x in limits)
    return np.exp(_normal(u, math.log(median), math.log(factor), *cut))


DISTRIBUTIONS = {
    "uniform": Kind(("from", "to"), lambda u, start, end: start + (end - start) * u),
    "loguniform": Kind(("from", "to"), lambda u, start, end: start * (end / start) ** u, "from"),
    "normal": Kind(("mean", "sd"), _normal, "sd", LIMITS),
    "lognormal": Kind(("median", "factor"), _lognormal, "median", LIMITS),
    "integer": Kind(("from", "to"), lambda u, start, end: (start + np.floor((end - start + 1) * u)).astype(int)),
    "choice": Kind(("values",), lambda u, values: np.fromiter(values, object)[(len(values) * u).astype(int)]),
}


@dataclass(frozen=True)
class Distribution:
    """A ``kind`` with the parameters in SI; InputError where they describe none."""

    kind: str
    parameters: Mapping[str, Any]

    def __post_init__(self) -> None:
        name = DISTRIBUTIONS[self.kind].positive
        self._check_rise("from", "to")
        if name and self.parameters[name] <= 0:
            raise InputError(f"{self.kind}: {name} must be > 0, got {self.parameters[name]:g}")
        self._check_rise("least", "most")

    def _check_rise(self, low: str, high: str) -> None:
        start, end = self.parameters.get(low, -math.inf), self.parameters.get(high, math.inf)
        if not start < end:
            raise InputError(f"{self.kind}: {low} must be below {high}, got {start:g} and {end:g}")

    def at(self, u: Array) -> tuple[Any, ...]:
        """The values below which the fractions ``u`` of all draws lie."""
        needed, at, _, limits = DISTRIBUTIONS[self.kind]
        values = {**limits, **self.parameters}
        return tuple(at(u, *(values[name] for name in (*needed, *limits))).tolist())


def _random(count: int, size: int, seed: int) -> Array:
    return np.random.default_rng(seed).random((count, size))


def _sobol(count: int, size: int, seed: int) -> Array:
    from scipy.stats import qmc

    powers = max(count - 1, 0).bit_length()
    return qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed)).random_base2(powers)[:count]


def _latin(count: int, size: int, seed: int) -> Array:
    from scipy.stats import qmc

    return qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(count)


METHODS: dict[str, Callable[[int, int, int], Array]] = {"random": _random, "sobol": _sobol, "latin-hypercube": _latin}


def draw(distributions: list[Distribution], count: int, method: str, seed: int) -> list[tuple[Any, ...]]:
    """``count`` draws of all distributions together, a tuple per draw."""
    inside = 1e-12, 1 - 1e-12  # the normal distribution has no ends
    points = np.clip(METHODS[method](count, len(distributions), seed), *inside)
    return list(zip(*(item.at(u) for item, u in zip(distributions, points.T, strict=True)), strict=True))

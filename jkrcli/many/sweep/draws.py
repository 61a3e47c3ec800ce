"""Draws from given distributions, by inverse distribution functions of points in the unit cube."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base import Array, InputError


@dataclass(frozen=True)
class Distribution:
    """``kind`` with its parameters in SI; ``least`` and ``most`` cut a normal or lognormal one off."""

    kind: str
    start: float = 0.0
    end: float = 1.0
    least: float = -math.inf
    most: float = math.inf
    values: tuple[Any, ...] = ()

    def at(self, u: Array) -> tuple[Any, ...]:
        """The values below which the fractions ``u`` of all draws lie."""
        match self.kind:
            case "uniform":
                drawn = self.start + (self.end - self.start) * u
            case "loguniform":
                drawn = self.start * (self.end / self.start) ** u
            case "normal":
                drawn = _normal(u, self.start, self.end, self.least, self.most)
            case "lognormal":
                limits = (math.log(x) if x > 0 else -math.inf for x in (self.least, self.most))
                drawn = np.exp(_normal(u, math.log(self.start), math.log(self.end), *limits))
            case "integer":
                return tuple(int(n) for n in self.start + np.floor((self.end - self.start + 1) * u))
            case _:
                return tuple(self.values[int(i)] for i in np.floor(len(self.values) * u))
        return tuple(drawn.tolist())


def _normal(u: Array, mean: float, sd: float, least: float, most: float) -> Array:
    from scipy.special import ndtr, ndtri

    low, high = ndtr((least - mean) / sd), ndtr((most - mean) / sd)
    return np.clip(mean + sd * ndtri(low + (high - low) * u), least, most)


def _random(count: int, size: int, seed: int) -> Array:
    return np.random.default_rng(seed).random((count, size))


def _sobol(count: int, size: int, seed: int) -> Array:
    from scipy.stats import qmc

    powers = max(count - 1, 0).bit_length()
    return qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed)).random_base2(powers)[:count]


def _latin(count: int, size: int, seed: int) -> Array:
    from scipy.stats import qmc

    return qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(count)


METHODS: dict[str, Callable[[int, int, int], Array]] = {
    "random": _random,
    "sobol": _sobol,
    "latin-hypercube": _latin,
}


def draw(distributions: list[Distribution], count: int, method: str, seed: int) -> list[tuple[Any, ...]]:
    """``count`` draws of all distributions together, a tuple per draw."""
    inside = 1e-12, 1 - 1e-12  # the normal distribution has no ends
    points = np.clip(METHODS[method](count, len(distributions), seed), *inside)
    return list(zip(*(item.at(u) for item, u in zip(distributions, points.T, strict=True)), strict=True))


def check(item: Distribution) -> None:
    """Refuse parameters that describe no distribution."""
    if item.kind in ("uniform", "loguniform", "integer") and not item.start < item.end:
        raise InputError(f"{item.kind}: from must be below to, got {item.start:g} and {item.end:g}")
    if item.kind == "loguniform" and item.start <= 0:
        raise InputError(f"loguniform: from must be > 0, got {item.start:g}")
    if item.kind == "normal" and item.end <= 0:
        raise InputError(f"normal: sd must be > 0, got {item.end:g}")
    if item.kind == "lognormal" and item.start <= 0:
        raise InputError(f"lognormal: median must be > 0, got {item.start:g}")
    if not item.least < item.most:
        raise InputError(f"{item.kind}: least must be below most, got {item.least:g} and {item.most:g}")

"""Fisher's distribution, and draws of uncertain numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .errors import InputError
from .numerics import MOST_STEPS, ROUNDING, SETTLED, Array

# --------------------------------------------------------------------------------------------------
# Fisher's distribution of F: as SciPy's, whose import takes longer than a fit.


BETA_TERMS = 10_000  # choice: guard; some sqrt(dof) terms are needed


def _fisher(k: float, dof: float, F: float) -> tuple[float, float]:
    """The chance I_x(dof/2, k/2) that F of ``k`` and ``dof`` degrees of freedom is larger, x = dof/(dof + k F), and F
    times its density, x^a (1 - x)^b/B(a, b)."""
    if not (F >= 0 and 0 < dof < math.inf):
        return math.nan, math.nan
    a, b, x, y = dof / 2, k / 2, 1 / (1 + k * F / dof), (1 / (1 + dof / (k * F)) if F else 0.0)
    if not x or not y:
        return float(not y), 0.0
    density = math.exp(a * math.log(x) + b * math.log(y) - math.lgamma(a) - math.lgamma(b) + math.lgamma(a + b))

    # the continued fraction of the incomplete beta function (DLMF 8.17.22), of 1 - x where that converges faster, by
    # the quotients c, d of successive numerators and denominators (Lentz, Appl. Opt. 15 (1976) 668)
    upper = x > (a + 1) / (a + b + 2)
    p, q, z = (b, a, y) if upper else (a, b, x)
    c, d = 1.0, 1 / (1 - (p + q) / (p + 1) * z)
    fraction = before = d
    for m in range(1, BETA_TERMS):
        for term in (
            m * (q - m) / ((p + 2 * m - 1) * (p + 2 * m)), -(p + m) * (p + q + m) / ((p + 2 * m) * (p + 2 * m + 1))
        ):  # fmt: skip
            d, c = 1 / (1 + term * z * d), 1 + term * z / c
            fraction *= c * d
        if abs(fraction - before) <= ROUNDING * abs(fraction):
            break
        before = fraction
    chance = density * fraction / p
    return (1 - chance if upper else chance), density


def f_tail(k: float, dof: float | Array, F: float | Array) -> Array:
    """The chances that F of ``k`` and ``dof`` degrees of freedom is above ``F`` >= 0, of any shape; nan of nan."""
    with np.errstate(all="ignore"):
        return np.vectorize(lambda *at: _fisher(*at)[0], otypes=[float])(k, dof, F)


def f_quantile(k: float, dof: float, level: float) -> float:
    """The F of ``k`` and ``dof`` degrees of freedom below which a share ``level`` of it lies; for k = 1 the square of
    half the two-sided interval of Student's t."""
    ln_F = 0.0
    for _ in range(MOST_STEPS):  # of Newton's for the log of the tail over that of F
        tail, density = _fisher(k, dof, math.exp(ln_F))
        step = min(max(tail / density * math.log(tail / (1 - level)), -1.0), 1.0)
        ln_F += step
        if abs(step) < SETTLED:
            break
    return math.exp(ln_F)


# --------------------------------------------------------------------------------------------------
# Distributions of uncertain numbers, and draws: inverse distribution functions of points in the unit cube.

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


DISTRIBUTIONS = {
    "uniform": Kind(("from", "to"), lambda u, start, end: start + (end - start) * u),
    "loguniform": Kind(("from", "to"), lambda u, start, end: start * (end / start) ** u, "from"),
    "normal": Kind(("mean", "sd"), _normal, "sd", LIMITS),
    "lognormal": Kind(
        ("median", "factor"),
        lambda u, median, factor, *limits: np.exp(
            _normal(u, math.log(median), math.log(factor), *(math.log(x) if x > 0 else -math.inf for x in limits))
        ),
        "median",
        LIMITS,
    ),
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


METHODS = ("random", "sobol", "latin-hypercube")


def draw(distributions: list[Distribution], count: int, method: str, seed: int) -> list[tuple[Any, ...]]:
    """``count`` draws of all distributions together, a tuple per draw."""
    rng, size = np.random.default_rng(seed), len(distributions)
    if method == "random":
        points = rng.random((count, size))
    else:
        from scipy.stats import qmc

        if method == "sobol":
            points = qmc.Sobol(size, scramble=True, rng=rng).random_base2(max(count - 1, 0).bit_length())[:count]
        else:
            points = qmc.LatinHypercube(size, rng=rng).random(count)
    points = np.clip(points, 1e-12, 1 - 1e-12)  # the normal distribution has no ends
    return list(zip(*(item.at(u) for item, u in zip(distributions, points.T, strict=True)), strict=True))

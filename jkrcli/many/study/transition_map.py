"""The transition map: the pull-off force of a paraboloid on a layer from JKR to DMT, over how strongly and how far it
adheres.

-P_min/(pi w R) under load control depends on Poisson's ratio, the base, q = w R^2/(E* h^3) and mu = sigma (R/(E*^2
w))^(1/3) alone: the adhesion map of Johnson and Greenwood (J. Colloid Interface Sci. 192 (1997) 326) for a layer. Its
limits are JKR's force on that layer for large mu, and 2 for small; thin incompressible layers rise above both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...adhesion.curve import CriticalPoint, transform
from ...adhesion.device import LOAD_CONTROL
from ...adhesion.finite_range import FiniteRangeBody
from ...adhesion.law import Range
from ...adhesion.slopes.choice import slopes
from ...base.arrays import Array
from ...base.errors import InputError, JkrError, SolveError
from ...base.executors import Pool, in_order
from ...base.unknown import Unknown
from ...bodies.indenters import Paraboloid
from ...bodies.materials import Elastic
from ...bodies.problem import Layer, Loading, Problem, Rigid, Specimen
from ...methods.attraction import AttractedBody
from ...methods.layered.layered import Layered


@dataclass(frozen=True)
class TransitionTuning:
    """Which part of the map there is, how finely it is solved, and what that takes."""

    points: int = 60  # choice: contact radii of a curve; more are added where it bends
    room: float = 1.5  # choice: of the largest radius over that of pull-off without a range
    least: float = 1e-4  # choice: q
    largest: float = 1e4  # choice: q
    softest: float = 0.05  # choice: mu, below which all is DMT
    hardest: float = 50.0  # choice: mu, above which all is JKR
    per_point: float = 0.06  # CPU seconds; tuned on maps of 17 and 100 ranges, by `make guards`


TUNING = TransitionTuning()


@dataclass(frozen=True)
class TransitionPoint:
    """One point of the map: ``force`` = -P_min/(pi w R), ``jkr``: that without a range; ``a_over_h``, ``c_over_h``;
    NaN where there is no curve, and the ``reason``."""

    nu: float
    base: str
    q: float
    mu: float
    force: float
    jkr: float
    a_over_h: float
    c_over_h: float
    reason: str = ""


def transition_map(
    nus: Iterable[float], bonded: bool, qs: Sequence[float], mus: Sequence[float], pool: Pool | None = None
) -> list[TransitionPoint]:
    """The points of the map; ``pool`` works on Poisson's ratios and q. Errors: InputError for values outside it."""
    for name, values, ends in (
        ("q", qs, (TUNING.least, TUNING.largest)),
        ("mu", mus, (TUNING.softest, TUNING.hardest)),
    ):
        if not values or not (ends[0] <= min(values) and max(values) <= ends[1]):
            raise InputError(f"{name}: must be between {ends[0]:g} and {ends[1]:g}, got {[float(v) for v in values]}")
    cells = [(nu, q) for nu in dict.fromkeys(nus) for q in sorted(set(qs))]
    rows = in_order(pool, partial(_row, bonded, tuple(sorted(set(mus)))), cells, "transition map")
    return [point for row in rows for point in row]


def forecast(nus: Sequence[float], qs: Sequence[float], mus: Sequence[float]) -> float:
    """CPU seconds that the map takes."""
    return TUNING.per_point * len(nus) * len(qs) * len(mus)


def transition_columns(points: Sequence[TransitionPoint]) -> dict[str, Array]:
    """The columns of the table by name; the force of a long range is 2 everywhere."""
    names = {"nu": "nu", "base": "base", "w_R2_over_Estar_h3": "q", "mu": "mu", "minus_P_over_pi_w_R": "force",
             "jkr_minus_P_over_pi_w_R": "jkr", "a_over_h": "a_over_h", "c_over_h": "c_over_h"}  # fmt: skip
    return {column: np.array([getattr(point, name) for point in points]) for column, name in names.items()}


def _row(bonded: bool, mus: Sequence[float], cell: tuple[float, float]) -> list[TransitionPoint]:
    """All ranges of one layer and one work of adhesion, in units of h = R = 1 m, E* = 1 Pa."""
    nu, q = cell
    specimen = Specimen((Layer(Elastic(1 - nu**2, nu), 1.0),), Rigid(bonded))
    thick, thin = (9 * math.pi * q / 8) ** (1 / 3), max((8 * q) ** (1 / 4), (384 * q) ** (1 / 6))
    a = TUNING.room * max(thick, min(thin, 2 * thick))
    problem = Problem(Paraboloid(1.0), specimen, Loading("radius", a, TUNING.points))
    solution = Layered()(problem)
    sharp = transform(solution.series, slopes(solution.series, "exact"), q).pull_off(LOAD_CONTROL)
    if isinstance(sharp, Unknown):
        raise SolveError(f"transition map: nu = {nu:g}, q = {q:g}: {sharp.reason}")
    body = FiniteRangeBody(problem, solution.series, AttractedBody(problem))
    found, unit, base = [], math.pi * q, "bonded" if bonded else "frictionless"
    for mu in mus:
        found.append(_point(body, nu, base, q, mu, -sharp.P / unit))
    return found


def _point(body: FiniteRangeBody, nu: float, base: str, q: float, mu: float, jkr: float) -> TransitionPoint:
    """One range on a ``body``; by what its curve is refused where it has none."""
    try:
        point = body.curve(Range.of(q, stress=mu * q ** (1 / 3))).pull_off(LOAD_CONTROL)
    except JkrError as error:
        point = Unknown(str(error))
    if isinstance(point, CriticalPoint) and point.c is not None:
        return TransitionPoint(nu, base, q, mu, -point.P / (math.pi * q), jkr, point.a, point.c)
    reason = f"nu = {nu:g}, q = {q:g}, mu = {mu:g}: {point.reason if isinstance(point, Unknown) else 'no pull-off'}"
    return TransitionPoint(nu, base, q, mu, math.nan, jkr, math.nan, math.nan, reason)

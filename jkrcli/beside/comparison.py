"""How far a computed curve lies from the exact solution of the same indenter on a half-space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..adhesion import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Slopes, transform
from ..base import ROUNDED, Array, Estimate, Unknown, zeros_between
from ..bodies import Indenter, Problem, Sphere
from ..formulas import griffith, half_space
from ..series import Series
from .sticking import OUTSIDE

NO_FORMULA = Unknown("no formula for a half-space under this tip")


@dataclass(frozen=True)
class DistanceTuning:
    """How the point of the exact curve is found that is nearest to a computed one."""

    window: float = 1.8  # factor of the radius within which it lies; choice: errors of the radius are far smaller
    coarse: int = 129  # points of the exact curve in that window; choice: several to each of its bends
    fine: int = 17  # and in each refinement around the nearest; choice: time alone depends on it
    refinements: int = 17  # theory: by fine // 2 each, down to round-off of the radius
    rim: float = 2e-6  # theory: of a0, the first sqrt(a^2 - a0^2): a - a0 is 1e4 times the round-off of a
    beyond: float = 3.0  # choice: of the pull-off radius of a paraboloid, up to which that of another tip is sought


TUNING = DistanceTuning()


@dataclass(frozen=True, eq=False)
class Comparison:
    """Relative differences to the closed form of the same profile, and that closed form's own curve for plots.

    ``load``: worst of P_H at equal displacement above a tenth of the largest. ``pull_off``: of the pull-off force
    (unknown where it lies outside the series). ``curve``: greatest distance between the adhesive curves, in units of
    the exact pull-off force and of its displacement. ``parabola``: for the sphere, by how much its exact pull-off force
    is smaller than the paraboloid's (Eq. 18): physics, not an error.
    """

    load: float
    pull_off: Estimate
    curve: Estimate
    parabola: float | None
    exact: AdhesiveCurve


def compare_half_space(computed: AdhesiveCurve, problem: Problem) -> Comparison | None:
    """The distance of ``computed`` from the closed form for the same indenter; None where there is none."""
    series = computed.series
    exact = exact_curve(problem, computed.w, float(series.a[-1]))
    if exact is None:
        return None
    load = _load_difference(series, problem)
    exact_point = _exact_pull_off(problem, computed.w, float(series.a[-1]))
    if exact_point is None:
        return Comparison(load, OUTSIDE, OUTSIDE, None, exact)
    point = computed.pull_off(LOAD_CONTROL)
    pull_off = point.P / exact_point.P - 1 if isinstance(point, CriticalPoint) else OUTSIDE
    parabola = None
    if isinstance(problem.indenter, Sphere):
        parabola = 1 - exact_point.P / (-1.5 * np.pi * computed.w * problem.indenter.R)
    return Comparison(load, pull_off, _curve_distance(computed, problem, exact_point), parabola, exact)


def exact_curve(problem: Problem, w: float, a_max: float, points: int = 400) -> AdhesiveCurve | None:
    """The closed-form adhesive curve of the indenter on a half-space up to ``a_max`` [m]."""
    indenter, E_star = problem.indenter, problem.E_star
    top = min(a_max, indenter.r_max * (1 - ROUNDED))
    a = indenter.a0 + (top - indenter.a0) * np.linspace(0, 1, points + 1)[1:] ** 2
    if indenter.a0:
        v = np.sqrt((a[0] - indenter.a0) * (a[0] + indenter.a0))
        rim = np.hypot(indenter.a0, np.geomspace(min(TUNING.rim * indenter.a0, v / 2), v, TUNING.coarse)[:-1])
        a = np.concatenate([rim, a])
    pair = indenter.half_space(a, E_star)
    if pair is None:
        return None
    slope = np.full_like(a, 2 * E_star)
    series = Series(a, *pair, slope * a, slope, a0=indenter.a0, S0=2 * E_star * indenter.a0)
    return transform(series, Slopes(slope * a, slope, "exact", 0.0), w)


def half_space_pull_off(problem: Problem, w: float, stiffness: float) -> CriticalPoint | Unknown:
    """JKR's pull-off of the indenter from a half-space under a device of a ``stiffness`` [N/m], against the work of
    adhesion ``w`` [J/m^2]; Unknown for tips without a radius and under surface tension."""
    R = problem.indenter.tip_radius
    if R is None or problem.specimen.surface_tension:
        return NO_FORMULA
    radius = (9 * np.pi * w * R**2 / (8 * problem.E_star)) ** (1 / 3)  # JKR's under load control, the widest
    curve = exact_curve(problem, w, TUNING.beyond * radius)
    return NO_FORMULA if curve is None else curve.pull_off(stiffness)


def _exact_pull_off(problem: Problem, w: float, a_max: float) -> CriticalPoint | None:
    """The formula's own pull-off point under load control; None where it lies beyond ``a_max`` [m] or is none.

    The radius is that of the interpolated curve, where P is stationary: its error enters P by its square.
    """
    curve = exact_curve(problem, w, 1.02 * a_max)
    point = None if curve is None else curve.pull_off(LOAD_CONTROL)
    if not isinstance(point, CriticalPoint):
        return None
    delta, P = _formula(problem, w, np.array(point.a))
    return CriticalPoint(point.a, float(delta), float(P), kind=point.kind)


def _formula(problem: Problem, w: float, a: Array) -> tuple[Array, Array]:
    """delta [m] and P [N] of the closed form at radii ``a`` [m] of any shape."""
    pair = problem.indenter.half_space(a, problem.E_star)
    assert pair is not None
    return half_space.adhesive_half_space(a, *pair, problem.E_star, w)


def _load_difference(series: Series, problem: Problem) -> float:
    """Worst relative difference of P_H to the closed form at equal delta_H, above a tenth of the depth."""
    deep = series.delta >= 0.1 * series.delta[-1]
    a = _radii_of_depth(series.delta[deep], problem.indenter)
    return float(np.max(np.abs(series.P[deep] / _formula(problem, 0.0, a)[1] - 1)))


def _radii_of_depth(delta: Array, indenter: Indenter) -> Array:
    """Radii [m] of the closed form at ``delta`` [m] > 0, where F(a) = delta, between two logs of a - a0."""
    a0, top = indenter.a0, (indenter.r_max - indenter.a0) * (1 - 1e-15)
    low = high = min(max(a0, float(delta[-1])), top / 2)
    while (indenter.abel(np.array(a0 + low)) > delta).any():
        low /= 2
    while high < top and (indenter.abel(np.array(a0 + high)) < delta).any():
        high = min(2 * high, top)
    start, end = np.full_like(delta, np.log(low)), np.full_like(delta, np.log(high))
    return a0 + np.exp(zeros_between(lambda x: indenter.abel(a0 + np.exp(x)) - delta, start, end, 0.0))


def _curve_distance(computed: AdhesiveCurve, problem: Problem, unit: CriticalPoint) -> float:
    """Greatest relative distance of the computed points from the exact curve; near pull-off in units of that point.

    Where its displacement nearly vanishes (f = B r^1.5), a tenth of the shift t = sqrt(2 pi w a/E*) is the unit.
    """
    indenter = problem.indenter
    moved = griffith.shift(computed.w, unit.a, 2 * problem.E_star)
    units = CriticalPoint(unit.a, max(abs(unit.delta), 0.1 * moved), unit.P)
    ends = (indenter.a0, indenter.r_max * (1 - 1e-12))
    return curve_distance(
        computed.a, computed.delta, computed.P, lambda a: _formula(problem, computed.w, a), units, ends, relative=True
    )


def curve_distance(
    a: Array, delta: Array, P: Array, exact: Callable[[Array], tuple[Array, Array]], unit: CriticalPoint,
    ends: tuple[float, float], relative: bool = False,
) -> float:  # fmt: skip
    """Greatest distance of the points (``delta``, ``P``) from the curve ``exact`` of the radius, which is sought
    near their radii ``a`` [m] between the ``ends`` [m]; the axes in units of the displacement and load of ``unit``,
    or, where ``relative``, of the point itself where these are larger."""
    low, high = np.maximum(a / TUNING.window, ends[0]), np.minimum(a * TUNING.window, ends[1])
    columns = np.arange(a.size)
    pairs = (delta, abs(unit.delta)), (P, abs(unit.P))
    sizes = [np.maximum(np.abs(values), size) if relative else size for values, size in pairs]
    v = np.broadcast_to(np.linspace(0, 1, TUNING.coarse)[:, None], (TUNING.coarse, a.size))  # of the way, squared
    step, least = 1 / (TUNING.coarse - 1), np.full(a.size, np.inf)
    for _ in range(TUNING.refinements):
        delta_there, P_there = exact(low + (high - low) * v**2)
        off = (delta_there - delta) / sizes[0], (P_there - P) / sizes[1]
        distances = np.hypot(*off)
        nearest = np.argmin(distances, axis=0)
        least = np.minimum(least, distances[nearest, columns])
        v = np.clip(v[nearest, columns] + step * np.linspace(-1, 1, TUNING.fine)[:, None], 0, 1)
        step *= 2 / (TUNING.fine - 1)
    return float(np.max(least))

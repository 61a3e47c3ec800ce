"""How far a computed curve lies from the exact solution of the same indenter on a half-space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import closed_form
from .adhesion import AdhesiveCurve, CriticalPoint, transform
from .indenters import Sphere
from .problem import Problem
from .series import Array, Series
from .slopes.result import Slopes

FINE = 20_000  # points of the exact curve
WINDOW = 1_000  # of them on either side of the same radius are looked at


@dataclass(frozen=True, eq=False)
class Comparison:
    """Relative differences to the closed form of the same profile, and that closed form's own curve for plots.

    ``load``: worst of P_H at equal displacement above a tenth of the largest. ``pull_off``: of the pull-off force
    (None where it lies outside the series). ``curve``: greatest distance between the adhesive curves, in units of the
    exact pull-off force and of its displacement. ``parabola``: for the sphere, by how much its exact pull-off force is
    smaller than the paraboloid's (Eq. 18): physics, not an error.
    """

    load: float
    pull_off: float | None
    curve: float | None
    parabola: float | None
    exact: AdhesiveCurve


def compare_half_space(computed: AdhesiveCurve, problem: Problem) -> Comparison | None:
    """The distance of ``computed`` from the closed form for the same indenter; None where there is none."""
    series = computed.series
    exact = exact_curve(problem, computed.w, float(series.a[-1]))
    if exact is None:
        return None
    exact_point = exact.pull_off(0.0) if computed.w > 0 else None
    if not isinstance(exact_point, CriticalPoint):
        return Comparison(_load_difference(series, exact.series), None, None, None, exact)
    point = computed.pull_off(0.0)
    pull_off = point.P / exact_point.P - 1 if isinstance(point, CriticalPoint) else None
    parabola = None
    if isinstance(problem.indenter, Sphere):
        parabola = 1 - exact_point.P / (-1.5 * np.pi * computed.w * problem.indenter.R)
    distance = _curve_distance(computed, exact, exact_point)
    return Comparison(_load_difference(series, exact.series), pull_off, distance, parabola, exact)


def exact_curve(problem: Problem, w: float, a_max: float, points: int = 400) -> AdhesiveCurve | None:
    """The closed-form adhesive curve of the indenter on a half-space up to ``a_max`` [m]."""
    indenter, E_star = problem.indenter, problem.E_star
    top = min(1.02 * a_max, indenter.r_max * (1 - 1e-9))
    a = indenter.a0 + (top - indenter.a0) * np.linspace(0, 1, points + 1)[1:] ** 2
    pair = closed_form.half_space(a, E_star, indenter)
    if pair is None:
        return None
    slope = np.full_like(a, 2 * E_star)
    series = Series(a, *pair, slope * a, slope, a0=indenter.a0, S0=2 * E_star * indenter.a0)
    return transform(series, Slopes(slope * a, slope, "exact", 0.0), w)


def _load_difference(series: Series, exact: Series) -> float:
    """Worst relative difference of P_H at equal delta_H above a tenth of the depth (interpolated in logs)."""
    deep = (series.delta >= 0.1 * series.delta[-1]) & (series.delta <= exact.delta[-1])
    reference = np.exp(np.interp(np.log(series.delta[deep]), np.log(exact.delta), np.log(exact.P)))
    return float(np.max(np.abs(series.P[deep] / reference - 1)))


def _curve_distance(computed: AdhesiveCurve, exact: AdhesiveCurve, unit: CriticalPoint) -> float:
    """Greatest distance of the computed points from the exact curve, both axes in units of the exact pull-off."""
    scale = np.array([abs(unit.delta), abs(unit.P)])
    a = np.geomspace(exact.a[0], exact.a[-1], FINE)
    line = np.stack(exact.at(a), axis=1) / scale
    points = np.stack([computed.delta, computed.P], axis=1) / scale
    near = np.searchsorted(a, computed.a)
    found = [_distance(points[i], line[max(0, near[i] - WINDOW) : near[i] + WINDOW]) for i in range(len(points))]
    return float(np.max([distance for distance, radius in zip(found, computed.a, strict=True) if radius >= a[0]]))


def _distance(point: Array, line: Array) -> float:
    """Distance of ``point`` (2,) from the polyline through ``line`` (m, 2)."""
    start, step = line[:-1], np.diff(line, axis=0)
    along = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0, 1)
    return float(np.sqrt(np.min(np.sum((start + along[:, None] * step - point) ** 2, axis=1))))

"""The points where contact is lost, solved anew at their own radii where the method that made the series is exact.

Between its radii a series is interpolated, with a larger error than that of an exact method. The problem is solved once
more at five radii close around each pull-off point: the curve then passes through the middle one with the slopes of the
quartics through the five, and the errors of these slopes say how well the place is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion.curve import TUNING as CURVE
from ..adhesion.curve import AdhesiveCurve, CriticalPoint, Equilibrium, EquilibriumCurve
from ..adhesion.device import CONTROLS
from ..adhesion.nonadhesive import Nonadhesive
from ..adhesion.slopes.exact import exact
from ..adhesion.slopes.result import TWO_SIDED_90, covariance_from_errors
from ..base.arrays import Array
from ..base.errors import JkrError
from ..bodies.problem import Loading, Problem
from ..series import Series, Solution
from .again import again, method_behind

POINTS = 10  # radii that are solved at once for a curve: five around each of two pull-off points
Further = Callable[[Array], Nonadhesive]  # the functions at other radii [m], solved
STEPS = np.arange(-2, 3)
# Rows: derivative of the quartic through values at ``STEPS``, of the parabola through the inner three, by the step.
WEIGHTS = np.array([[1, -8, 0, 8, -1], [0, -6, 0, 6, 0]]) / 12


@dataclass(frozen=True)
class SolvedTuning:
    """Where further radii are solved, and how often."""

    # Of log(a - a0) between the five, the fifth root of the error of the columns, within these limits:
    least: float = 3e-3  # theory: a smooth series errs by the fourth power
    most: float = 5e-2  # choice: what still lies close
    rounds: int = 8  # of solves; choice: fine series need two, 20 rows over four decades six
    each: float = 0.3  # of that of a solve, the cost of a curve's points; tuned on 1 to 1000 layers, by `make bench`


TUNING = SolvedTuning()


def solver_of(solution: Solution) -> Further | None:
    """How further radii of ``solution`` are solved; None where its radii are not exact. ``seconds_of_points`` says what
    that costs."""
    method, series = method_behind(solution), solution.series
    stated = {"delta", "dS"} <= series.errors.keys() and series.dS is not None
    if method is None or not stated or np.any(series.errors.get("a", 0.0)):
        return None
    problem = replace(solution.problem, loading=Loading.given("radius", (float(series.a[-1]),)))
    if method.refusal(problem):
        return None
    step = min(max(float(np.max(_scatter(series, problem))) ** 0.2, TUNING.least), TUNING.most)

    def further(a: Array) -> Nonadhesive:
        beyond = np.outer(a - series.a0, np.exp(step * STEPS))
        radii, order = np.unique(series.a0 + beyond, return_inverse=True)
        return _in_the_middle(again(problem, radii, method), order.reshape(-1, STEPS.size), step)

    return further


def _scatter(series: Series, problem: Problem) -> Array:
    """Relative errors (2, n) of delta_H and S' that differ from radius to radius: those of a profile do not."""
    assert series.dS is not None
    shift, _ = problem.indenter.resolution(series.a)
    return np.stack([(series.errors["delta"] - shift) / series.delta, series.errors["dS"] / series.dS])


def seconds_of_points(solution: Solution, devices: int = 0) -> float:
    """CPU seconds of the solved pull-off points of a curve, about, those by so many ``devices`` included; 0 where none
    are."""
    method = method_behind(solution)
    if method is None or solver_of(solution) is None:
        return 0.0
    radii = solution.series.a[-1] * np.linspace(0.5, 1, POINTS + STEPS.size * devices)
    problem = replace(solution.problem, loading=Loading.given("radius", tuple(radii.tolist())))
    return TUNING.each * method.forecast(problem).seconds


def _in_the_middle(solution: Solution, fives: Array, step: float) -> Nonadhesive:
    """The functions at the middle of each of the ``fives``, rows (n, 5) of ``solution`` a ``step`` of log(a - a0)
    apart, with slopes and the joint covariance of columns and slopes."""
    series = solution.series
    assert series.S is not None
    assert series.dS is not None
    middle, rows = fives[:, 2], np.sort(fives[:, 2])
    assert (middle == rows).all()
    names = ("a", "delta", "P", "S", "dS")
    columns = {name: getattr(series, name)[rows] for name in names}
    errors = {name: values[rows] for name, values in series.errors.items()}
    inner = replace(series, **columns, errors=errors)
    logs = np.log(np.stack([series.delta, series.dS]))[:, fives]
    quartic, parabola = np.einsum("cnk,wk->wcn", logs, WEIGHTS) / step
    noise = float(np.linalg.norm(WEIGHTS[0])) / step * _scatter(inner, solution.problem)
    unsure = noise + (quartic - parabola) ** 2 / np.maximum(np.abs(quartic), 1.0)
    beyond = inner.a - inner.a0
    slopes = exact(inner)
    covariance = covariance_from_errors(inner, columns["S"], columns["dS"])
    assert covariance is not None
    joint = np.zeros((rows.size, 6, 6))
    joint[:, :4, :4] = covariance
    absolute = unsure * np.stack([inner.delta, columns["dS"]]) / beyond
    absolute[0] += solution.problem.indenter.resolution(inner.a)[1]
    joint[:, 4, 4], joint[:, 5, 5] = (absolute / TWO_SIDED_90) ** 2
    log_rates = np.stack([quartic[0], quartic[1] * inner.a / beyond], axis=1)
    return Nonadhesive(inner, replace(slopes, joint=joint), log_rates)


def solved(curve: AdhesiveCurve, further: Further, *devices: float) -> AdhesiveCurve:
    """The ``curve`` through what is solved at its pull-off points, those by ``devices`` of a stiffness [N/m] included,
    until they lie there."""
    for _ in range(TUNING.rounds):
        radii = _wanted(curve, {*CONTROLS.values(), *devices})
        if not radii.size:
            break
        try:
            found = _through(curve, further(radii))
            found.nonadhesive.logs  # noqa: B018 - refuses points that do not fit in between the rows
        except JkrError:  # nor may body or profile allow it: what is interpolated stands, with its error
            break
        curve = found
    return curve


def _wanted(curve: AdhesiveCurve, devices: set[float]) -> Array:
    """Radii of the pull-off points; none where they are all solved."""
    curve.look_for_critical(devices)
    found = (curve.pull_off(stiffness) for stiffness in devices)
    points = [point for point in found if isinstance(point, CriticalPoint)]
    return np.unique([] if all(is_solved(curve, point) for point in points) else [point.a for point in points])


def is_solved(curve: EquilibriumCurve, point: Equilibrium) -> bool:
    """Whether the ``point`` was solved at its own radius, and is not one between rows."""
    if not isinstance(curve, AdhesiveCurve):
        return True  # of finite range: each solves itself
    further = curve.nonadhesive.further
    nearest = math.inf if further is None else float(np.min(np.abs(further.a - point.a)))
    return nearest <= CURVE.solved * (point.a - curve.series.a0)


def _through(curve: AdhesiveCurve, found: Nonadhesive) -> AdhesiveCurve:
    """The ``curve`` through the functions ``found`` at further radii in place of those before."""
    return AdhesiveCurve(replace(curve.nonadhesive, further=found), curve.w)

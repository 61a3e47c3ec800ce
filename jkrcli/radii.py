"""Which contact radii a loading asks for, on any body whose nonadhesive delta(a), P(a) can be evaluated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .errors import InputError, SolveError
from .problem import Problem

Array = np.ndarray
Curve = Callable[[Array], tuple[Array, Array]]  # radii [m] -> delta_H [m], P_H [N]


def radii_of(problem: Problem, curve: Curve) -> Array:
    """The increasing contact radii [m] that ``problem.loading`` prescribes on the body described by ``curve``."""
    loading, a0 = problem.loading, problem.indenter.a0
    if loading.to == "radius":
        return _given_radii(problem)
    if loading.spacing == "given":
        targets = np.array(loading.values)
        return _solve_for(problem, curve, targets, largest_radius(problem, curve))
    a_max = largest_radius(problem, curve)
    if loading.spacing == "radius":
        return a0 + (a_max - a0) * np.arange(1, loading.points + 1) / loading.points
    depth = float(curve(np.array([a_max]))[0][0])
    return _solve_for(problem, curve, depth * np.arange(1, loading.points + 1) / loading.points, a_max, column=0)


def _given_radii(problem: Problem) -> Array:
    loading, a0 = problem.loading, problem.indenter.a0
    _check_reach(problem, loading.maximum)
    if loading.spacing == "given":
        radii = np.array(loading.values)
    elif loading.spacing == "depth":
        raise InputError("loading: spacing by depth needs a depth or a load as the goal, not a radius")
    else:
        radii = a0 + (loading.maximum - a0) * np.arange(1, loading.points + 1) / loading.points
    if radii[0] <= a0:
        raise InputError(
            f"loading.radius: must be > {a0:g} m, where this indenter's contact begins, got {radii[0]:g} m"
        )
    return radii


def _check_reach(problem: Problem, a: float) -> None:
    if a >= problem.indenter.r_max:
        raise InputError(
            f"loading: needs a contact radius of {a:g} m, but the indenter's profile ends at "
            f"{problem.indenter.r_max:g} m: load less"
        )


def largest_radius(problem: Problem, curve: Curve) -> float:
    """The contact radius [m] at the largest load or depth: a bracket around the half-space's, then a root search."""
    loading = problem.loading
    if loading.to == "radius":
        _check_reach(problem, loading.maximum)
        return loading.maximum
    column = 0 if loading.to == "depth" else 1
    low, high = _bracket(problem, curve, column)
    return float(_root(problem, curve, column, loading.maximum, low, high))


def half_space_radius(problem: Problem) -> float:
    """The radius [m] at which a half-space would be at the largest depth (or carry the load): a first guess only."""
    from scipy.optimize import brentq

    indenter, loading = problem.indenter, problem.loading
    if loading.to == "radius":
        return loading.maximum
    reach = indenter.r_max * (1 - 1e-9) if np.isfinite(indenter.r_max) else np.inf
    x = (np.polynomial.legendre.leggauss(24)[0] + 1) / 2
    weights = np.polynomial.legendre.leggauss(24)[1] / 2

    def value(a: float) -> float:
        F = float(indenter.abel(np.array(a)))
        if loading.to == "depth":
            return F / loading.maximum - 1
        P = 2 * problem.E_star * (F * a - a * float(weights @ indenter.abel(a * x)))
        return P / loading.maximum - 1

    scale = indenter.tip_radius or indenter.a0 or loading.maximum if loading.to == "depth" else 1.0
    low = high = min(max(indenter.a0, 1e-3 * scale), 0.5 * reach) or 1.0
    while value(low) > 0 and low > indenter.a0 * (1 + 1e-14):
        low = indenter.a0 + (low - indenter.a0) / 4
        if low < 1e-300:
            break
    while high < reach and value(min(high, reach)) < 0:
        high = indenter.a0 + (high - indenter.a0) * 4 if high > indenter.a0 else 2 * high
    if high >= reach:
        return reach
    return float(brentq(value, low, high, xtol=1e-300, rtol=1e-10)) if value(low) < 0 else low


def _bracket(problem: Problem, curve: Curve, column: int) -> tuple[float, float]:
    """Radii whose column (0: delta, 1: P) lies below and above the loading's maximum."""
    a0, goal = problem.indenter.a0, problem.loading.maximum
    reach = problem.indenter.r_max * (1 - 1e-9) if np.isfinite(problem.indenter.r_max) else np.inf
    a = min(half_space_radius(problem), reach)
    low, high = (
        a0 + (a - a0) * (1 - 1e-6),
        min(a0 + (a - a0) * (1 + 1e-6), reach),
    )  # off the root by more than round-off
    for _ in range(200):
        if _value(curve, column, low) < goal:
            break
        low, high = a0 + (low - a0) / 2, low
    for _ in range(200):
        if _value(curve, column, high) >= goal:
            break
        if high >= reach:
            _check_reach(problem, np.nextafter(problem.indenter.r_max, np.inf))
        low, high = high, min(a0 + (high - a0) * 2, reach)
    return low, high


def _value(curve: Curve, column: int, a: float) -> float:
    return float(curve(np.array([a]))[column][0])


def _root(problem: Problem, curve: Curve, column: int, goal: float, low: float, high: float) -> float:
    from scipy.optimize import brentq

    a0 = problem.indenter.a0

    def mismatch(log_a: float) -> float:
        return np.log(max(_value(curve, column, a0 + np.exp(log_a)), np.finfo(float).tiny) / goal)

    return a0 + np.exp(brentq(mismatch, np.log(low - a0), np.log(high - a0), xtol=1e-14, rtol=1e-14))


def _solve_for(problem: Problem, curve: Curve, targets: Array, a_max: float, column: int | None = None) -> Array:
    """All radii at which the column reaches the increasing ``targets``; the last one is ``a_max``.

    Newton in log(a - a0) and the logarithm of the column, all targets at once, from a table of the curve.
    """
    from scipy.interpolate import PchipInterpolator

    if column is None:
        column = 0 if problem.loading.to == "depth" else 1
    a0 = problem.indenter.a0
    logs = np.log(targets)
    steps = np.log(a_max - a0) + np.linspace(-0.75 * (logs[-1] - logs[0]) - 1, 0, 48)
    values = np.log(curve(a0 + np.exp(steps))[column])
    table = PchipInterpolator(values, steps, extrapolate=True)
    u = table(logs)
    for _ in range(30):
        error = np.log(curve(a0 + np.exp(u))[column]) - logs
        if np.max(np.abs(error)) < 1e-12:
            break
        u = u - error * table.derivative()(logs)
    else:
        raise SolveError(
            f"loading: the radii for the given {problem.loading.to}s were found to {np.max(error):.1g} only"
        )
    u[-1] = np.log(a_max - a0)
    return a0 + np.exp(u)

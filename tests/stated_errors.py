"""Series in other units, and stated errors of pull-off points beside the true ones."""

import math
from dataclasses import replace

import numpy as np

from jkrcli.bodies.problem import Loading, Problem
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import Method
from jkrcli.resolve.analysis import Analysis
from jkrcli.series import Series


def in_units(series: Series, length: float, force: float) -> Series:
    """The ``series`` where a metre and a newton are as many units."""
    stiff = force / length
    return Series(
        series.a * length, series.delta * length, series.P * force, series.S * stiff, series.dS * stiff / length
    )


def assert_pull_off_within(found: Analysis, exact: Analysis, most: float, factor: float = math.inf) -> None:
    """P and delta of all pull-off points err by what is stated at most, which is below ``most`` of them and below
    ``factor`` times the error."""
    for control, point in found.pull_off.items():
        truth, stated = exact.pull_off[control], found.pull_off_errors[control]
        for name in ("P", "delta"):
            error = abs(getattr(point, name) - getattr(truth, name))
            assert error <= stated[name] < most * abs(getattr(truth, name))
            assert stated[name] < factor * error


def stationary(
    problem: Problem, w: float, a: float, control: str | float, method: Method | None = None, around: float = 0.02
) -> tuple[float, float]:
    """P and delta where the polynomial of degree 8 through Eq. 13 at nine radii, so much ``around`` the radius ``a``,
    is stationary, by ``method``, default: layered, under ``control`` or by a device of a stiffness [N/m]."""
    x, a0 = around * np.cos(np.pi * np.arange(9) / 8)[::-1], problem.indenter.a0
    radii = tuple((a0 + (a - a0) * (1 + x)).tolist())
    series = (method or Layered(1e-11))(replace(problem, loading=Loading.given("radius", radii))).series
    t = np.sqrt(4 * math.pi * w * series.a / series.dS)
    fits = {"P": series.P - series.S * t, "delta": series.delta - t}
    P, delta = (np.polynomial.Chebyshev.fit(x, fits[name], 8) for name in ("P", "delta"))
    held = delta + P / control if isinstance(control, float) else P if control == "load" else delta
    roots = held.deriv().roots()
    root = float(np.real(roots[np.argmin(np.abs(roots))]))
    return float(P(root)), float(delta(root))

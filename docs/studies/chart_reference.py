"""The exact solution that the methods of a chart are measured against, and how far from it a result lies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from jkrcli.adhesion.curve import AdhesiveCurve, CriticalPoint, EquilibriumCurve, transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import JkrError, Refusal
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Loading, Problem
from jkrcli.methods.integral.fredholm import InaccurateError
from jkrcli.methods.layered.solver import Layered, largest_radius
from jkrcli.methods.protocol import Method, method_class
from jkrcli.resolve.resolve import curve_distance
from jkrcli.series import Series

# How exact the exact solution is, and where it is compared.
REFERENCE_POINTS = 400  # choice: radii of the reference, whose cubics are then good to 1e-9
REFERENCE_BEYOND = 1.02  # choice: how far it goes beyond the largest contact radius
REFERENCE_TOLERANCES = (1e-10, 1e-9, 1e-8)  # choice: the first that double precision allows
REFERENCE_JUDGED = 0.1  # choice: of the deepest; P is compared at larger depths


@dataclass(frozen=True)
class Errors:
    """Distances from the reference: ``load``: worst relative one of P_H at equal displacement above a tenth of the
    largest; ``curve``: greatest of the adhesive curve's points, in units of the pull-off force and displacement;
    ``pull_off``: relative, of the pull-off force under load control. None: not known, as where there is no pull-off."""

    load: float
    curve: float | None = None
    pull_off: float | None = None


@dataclass(frozen=True, eq=False)
class Reference:
    """The exact adhesive curve ``exact`` of a problem by the method ``name``."""

    name: str
    exact: AdhesiveCurve

    def load_error(self, delta: Array, P: Array) -> float:
        """Worst relative difference of loads ``P`` [N] at the displacements ``delta`` [m] above a tenth of the last."""
        series = self.exact.series
        assert series.S is not None
        x, y = np.log(series.delta), np.log(series.P)
        load = CubicHermiteSpline(x, y, series.S * series.delta / series.P)
        deep = (delta >= REFERENCE_JUDGED * delta[-1]) & (delta <= series.delta[-1])
        return float(np.max(np.abs(P[deep] / np.exp(load(np.log(delta[deep]))) - 1)))

    def errors(self, curve: EquilibriumCurve) -> Errors:
        """How far a computed adhesive curve and its nonadhesive series lie from this one."""
        load = self.load_error(curve.series.delta, curve.series.P)
        exact, found = self.exact.pull_off(0.0), curve.pull_off(0.0)
        if not isinstance(exact, CriticalPoint):
            return Errors(load)
        inside = (curve.a >= self.exact.a[0]) & (curve.a <= self.exact.a[-1])
        a, delta, P = (column[inside] for column in (curve.a, curve.delta, curve.P))
        ends = (float(self.exact.a[0]), float(self.exact.a[-1]))
        distance = curve_distance(a, delta, P, self.exact.at, self._unit(exact), ends)
        pull_off = abs(found.P / exact.P - 1) if isinstance(found, CriticalPoint) else None
        return Errors(load, distance, pull_off)

    def _unit(self, point: CriticalPoint) -> CriticalPoint:
        """The pull-off point as the unit of distances; where its displacement nearly vanishes, a tenth of the shift
        by adhesion instead."""
        shift = float(np.interp(point.a, self.exact.a, self.exact.series.delta)) - point.delta
        return replace(point, delta=max(abs(point.delta), 0.1 * shift))


def reference_of(problem: Problem, w: float) -> Reference:
    """The closed form where there is one, else the exact method for layers to 1e-10, for ``w`` [J/m^2].

    Refused for bodies of finite radius, for which there is none.
    """
    if problem.specimen.radius is not None:
        raise Refusal(
            f"chart: the specimen has a finite radius of {problem.specimen.radius:g} m, for which there is no exact "
            "solution to measure against: leave radius and side out, or see jkr study converge"
        )
    largest = min(REFERENCE_BEYOND * largest_radius(problem), problem.indenter.r_max * (1 - 1e-9))
    dense = replace(problem, loading=Loading("radius", largest, REFERENCE_POINTS))
    name, series = _exact(dense)
    return Reference(name, transform(series, slopes(series, "exact"), w))


def _exact(problem: Problem) -> tuple[str, Series]:
    """Name and series of the first exact method that can solve ``problem``."""
    candidates: list[tuple[str, Method]] = [(f"layered, tolerance {t:g}", Layered(t)) for t in REFERENCE_TOLERANCES]
    if problem.specimen.is_half_space:
        candidates.insert(0, ("closed form", method_class("closed-form")()))
    reasons = []
    for name, method in candidates:
        try:
            return name, method(problem).series
        except JkrError as error:
            reasons.append(f"{name}: {error.fixed if isinstance(error, InaccurateError) else error}")
    raise Refusal([f"chart: no exact solution to measure against: {reason}" for reason in reasons])

"""The work of adhesion that a measured pull-off force means on a given body: the inverse of pull-off."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError, SolveError, Unknown
from ..base.numerics import ROUNDED, SAME, Array, zeros_between
from ..base.units import show
from ..bodies.problem import Problem
from .curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, EquilibriumCurve, Nonadhesive, position
from .pull_off_error import Errors, pull_off_error
from .validity import Strains, large_strains

STEP = math.log(4.0)  # of log w, beyond what the radii of the series give; choice: time alone depends on it


@dataclass(frozen=True, eq=False)
class FoundWork:
    """``w`` [J/m^2] whose pull-off force is the measured ``load`` [N, > 0] on this body.

    ``curve``: the adhesive curve for it, ``point``: its pull-off. ``half_space``: load/(1.5 pi R), what classical JKR
    would have given under load control, None where the indenter has no tip radius.
    """

    load: float
    stiffness: float
    w: float
    curve: EquilibriumCurve
    point: CriticalPoint
    half_space: float | None


def work_from_pull_off(
    body: Nonadhesive,
    load: float,
    stiffness: float = LOAD_CONTROL,
    R: float | None = None,
    curve_of: Callable[[float], EquilibriumCurve | Unknown] | None = None,
) -> FoundWork:
    """The w at which contact is lost at P = -``load`` [N] by a device of ``stiffness`` [N/m]; ``R``: tip radius [m],
    ``curve_of``: the equilibria for a w, where they are not all of those of ``body``.

    At every radius of the series there is at most one w whose curve is stationary there; the pull-off force grows with
    w, so the ends of the series bound the forces that it can tell. Refused outside them.
    """
    if not (math.isfinite(load) and load > 0):
        raise InputError(f"load: the measured pull-off force must be > 0 N, got {load:g}")
    control = body.series.control_of_force(stiffness)

    def equilibria(w: float) -> EquilibriumCurve | Unknown:
        return AdhesiveCurve(body, w) if curve_of is None else curve_of(w)

    def point(w: float) -> CriticalPoint | Unknown:
        curve = equilibria(w)
        return curve if isinstance(curve, Unknown) else curve.pull_off(control)

    def force(log_w: float) -> float:
        tear_off = point(math.exp(log_w))
        if isinstance(tear_off, Unknown):
            raise SolveError(f"load: w lies beyond the range of the solution: {tear_off.reason}")
        return -tear_off.P

    def excess(log_w: float) -> float:
        return force(log_w) / load - 1

    def inside(works: Array) -> float:
        """The log of the first of ``works`` whose pull-off lies in the series."""
        for w in works:
            if isinstance(point(float(w)), CriticalPoint):
                return math.log(w)
        raise InputError("load: this solution holds no pull-off for any work of adhesion: increase [loading] radius")

    def widened(log_w: float, step: float) -> float:
        """``log_w`` moved step by step: beyond the last stationary radius the pull-off may lie between two points."""
        while excess(log_w) * step < 0 and isinstance(point(math.exp(log_w + step)), CriticalPoint):
            log_w += step
        return log_w

    # The works of adhesion > 0 whose curves are stationary at radii across the series, increasing
    a = body.a.copy()
    a[0], a[-1] = a[0] * (1 + SAME), a[-1] * (1 - SAME)
    here, rates = body.with_rates(a)
    nonadhesive = position(rates.delta_H, rates.P_H, control)
    adhesive = position(rates.t, rates.S * here.t + here.S * rates.t, control)
    root = np.divide(nonadhesive, adhesive, out=np.zeros_like(a), where=adhesive > 0)
    works = np.sort(root[root > 0] ** 2)
    if body.series.rim < math.inf:  # of a flat punch the force goes with the root of w
        works = np.array([(load / force(0.0)) ** 2])
    low, high = widened(inside(works), -STEP), widened(inside(works[::-1]), STEP)
    if not excess(low) <= 0 <= excess(high):
        least, greatest = force(low), force(high)
        remedy = "increase [loading] radius" if load > greatest else "begin the solution at a smaller radius"
        raise InputError(
            f"load: a pull-off force of {show(load, 'load')} lies outside the solution, which covers forces from "
            f"{show(least, 'load')} to {show(greatest, 'load')}: {remedy}"
        )
    if low < high:
        low = float(zeros_between(np.vectorize(excess, otypes=[float]), np.array([low]), np.array([high]), 1e-14)[0])
    w = math.exp(low)
    tear_off = point(w)
    if isinstance(tear_off, Unknown) or abs(-tear_off.P / load - 1) > ROUNDED:
        raise InputError(
            f"load: no work of adhesion gives a pull-off force of {show(load, 'load')}: where the last stable branch "
            f"changes, at w = {show(w, 'work')}, the force jumps past it"
        )
    curve = equilibria(w)
    assert not isinstance(curve, Unknown)  # it has a point
    half_space = None if R is None else load / (1.5 * math.pi * R)
    return FoundWork(load, stiffness, float(w), curve, tear_off, half_space)


class Pull:
    """How an elastic specimen lets go when it is pulled. A specimen whose moduli relax is a subclass: its answer
    depends on how it was loaded before."""

    def curve(self, body: Nonadhesive, w: float) -> EquilibriumCurve | Unknown:
        """The equilibria for the work of adhesion ``w`` [J/m^2]; Unknown where there are none."""
        return AdhesiveCurve(body, w)

    def work(self, body: Nonadhesive, load: float, stiffness: float, R: float | None = None) -> FoundWork:
        """The w at which contact is lost at P = -``load`` [N] by a device of ``stiffness`` [N/m]; ``R``: tip radius."""
        return work_from_pull_off(body, load, stiffness, R)

    def radii(self, body: Nonadhesive, w: float, controls: Sequence[float]) -> list[float]:
        """The radii [m] on which pull-off under ``controls`` by devices of a stiffness [N/m] depends."""
        curve = self.curve(body, w)
        points = () if isinstance(curve, Unknown) else map(curve.pull_off, controls)
        return [point.a for point in points if isinstance(point, CriticalPoint)]

    def error(
        self, body: Nonadhesive, curve: EquilibriumCurve, point: CriticalPoint, stiffness: float
    ) -> Errors | Unknown:
        """Half-widths of "delta" [m] and "P" [N] at the pull-off ``point`` under a device of ``stiffness`` [N/m]."""
        assert isinstance(curve, AdhesiveCurve)
        return pull_off_error(curve, point, stiffness)

    def strains(self, problem: Problem, w: float, point: CriticalPoint, loaded: bool) -> Strains:
        """What large strains change of the pull-off force at the ``point``, under load control or another."""
        return large_strains(problem, w, point, loaded)

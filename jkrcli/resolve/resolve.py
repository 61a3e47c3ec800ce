"""Bodies solved again: over other radii, by another method, with other surfaces; and at the very points where contact
is lost.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, EquilibriumCurve, Nonadhesive, transform
from ..adhesion.finite_range import AttractedBody, FiniteRangeBody, Range
from ..adhesion.slopes import Slopes
from ..adhesion.validity import FROM_RIM
from ..base.errors import Estimate, JkrError, Refusal, Unknown
from ..base.numerics import ROUNDED, Array, zeros_between
from ..base.process import PATIENCE, duration
from ..bodies.indenters import Sphere
from ..bodies.problem import Loading, Problem
from ..formulas import adhesive_half_space, punch_of_range, shift
from ..methods.protocol import METHODS, Method, method_class
from ..series import Series, Solution

# The radii of the solution, and how long it may take.
# in equal steps of log(a - a0); tuned on bodies, by `make constants`: half move the radius of a jump by 2e-5
OWN_BODY_RADII = 80
# of log(a - a0), how far below the least radius it reaches, as far as a fit does; tuned on bodies,
# by `make constants`: half of it moves the radius of a jump by 2 %
OWN_BODY_BELOW = 2.5


def resolve_with(
    problem: Problem, radii: Array | None = None, method: Method | None = None, longest: float = math.inf,
    **otherwise: Any,
) -> Solution:  # fmt: skip
    """A body solved again: the solution of a ``problem`` with ``otherwise`` in place of its fields, over ``radii`` [m]
    (default: as it is loaded), by ``method`` or the first exact one that represents it; JkrError where none does, or
    not within ``longest`` [CPU s]."""
    if radii is not None:
        otherwise["loading"] = Loading.given("radius", tuple(radii.tolist()))
    changed = replace(problem, **otherwise)
    failed: JkrError | None = None
    for each in exact_methods() if method is None else (method,):
        try:
            if reason := each.refusal(changed):
                raise Refusal(reason)
            if longest < math.inf and (seconds := each.forecast(changed).seconds) >= longest:
                raise Refusal(f"the coarse solution would take about {duration(seconds)}")
            return each(changed)
        except JkrError as error:
            failed = error
    raise failed or Refusal("no exact method represents these bodies")


def exact_methods() -> list[Method]:
    """The methods that are exact and cost next to nothing, least effort first."""
    return [method_class(name)() for name, method in METHODS.items() if method.exact]


def own_solution(problem: Problem, a: Array) -> Series | None:
    """The solution over the radii ``a`` (n,) [m] and some way below; None where no exact method represents them, or
    not soon."""
    beyond = a - problem.indenter.a0
    steps = np.geomspace(beyond.min() * np.exp(-OWN_BODY_BELOW), beyond.max(), OWN_BODY_RADII)
    try:
        return resolve_with(problem, problem.indenter.a0 + steps, longest=PATIENCE).series
    except JkrError:
        return None


# --------------------------------------------------------------------------------------------------
# Adhesive curves beside those of a simpler body: a half-space, no slip, a finite range.

OUTSIDE = Unknown("pull-off lies outside the solution")


def pull_off_ratios(
    one: Series, other: Series, works: Sequence[float], outside: Unknown = OUTSIDE
) -> dict[float, Estimate]:
    """The pull-off force under load control of one series with exact slopes over that of the other, for each of the
    ``works`` of adhesion [J/m^2]."""
    ratios = dict[float, Estimate]()
    for w, first, second in zip(works, *(_pull_offs(each, tuple(works)) for each in (one, other)), strict=True):
        known = isinstance(first, CriticalPoint) and isinstance(second, CriticalPoint)
        ratios[w] = first.P / second.P if known else outside
    return ratios


@lru_cache(maxsize=2)  # one body is compared with several others
def _pull_offs(series: Series, works: tuple[float, ...]) -> list[CriticalPoint | Unknown]:
    """What lies between the rows is found once for all ``works``."""
    functions = Nonadhesive.of(series, "exact")
    return [AdhesiveCurve(functions, w).pull_off(LOAD_CONTROL) for w in works]


NO_FORMULA = Unknown("no formula for a half-space under this tip")

# How the point of the exact curve is found that is nearest to a computed one.
DISTANCE_WINDOW = 1.8  # factor of the radius within which it lies; choice: errors of the radius are far smaller
DISTANCE_COARSE = 129  # points of the exact curve in that window; choice: several to each of its bends
DISTANCE_FINE = 17  # and in each refinement around the nearest; choice: time alone depends on it
DISTANCE_REFINEMENTS = 17  # theory: by fine // 2 each, down to round-off of the radius
DISTANCE_RIM = 2e-6  # theory: of a0, the first sqrt(a^2 - a0^2): a - a0 is 1e4 times the round-off of a
DISTANCE_BEYOND = 3.0  # choice: of the pull-off radius of a paraboloid, up to which that of another tip is sought


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
    # Worst relative difference of P_H to the closed form at equal delta_H, above a tenth of the depth.
    deep = series.delta >= 0.1 * series.delta[-1]
    # Radii [m] of the closed form at `delta` [m] > 0, where F(a) = delta, between two logs of a - a0.
    delta = series.delta[deep]
    a0, top = problem.indenter.a0, (problem.indenter.r_max - problem.indenter.a0) * (1 - 1e-15)
    low = high = min(max(a0, float(delta[-1])), top / 2)
    while (problem.indenter.abel(np.array(a0 + low)) > delta).any():
        low /= 2
    while high < top and (problem.indenter.abel(np.array(a0 + high)) < delta).any():
        high = min(2 * high, top)
    start, end = np.full_like(delta, np.log(low)), np.full_like(delta, np.log(high))
    a = a0 + np.exp(zeros_between(lambda x: problem.indenter.abel(a0 + np.exp(x)) - delta, start, end, 0.0))
    load = float(np.max(np.abs(series.P[deep] / _formula(problem, 0.0, a)[1] - 1)))
    # The formula's own pull-off point; its radius is that of the interpolated curve, where P is stationary: its error
    # enters P by its square
    curve = exact_curve(problem, computed.w, 1.02 * float(series.a[-1]))
    exact_point = None if curve is None else curve.pull_off(LOAD_CONTROL)
    if not isinstance(exact_point, CriticalPoint):
        return Comparison(load, OUTSIDE, OUTSIDE, None, exact)
    delta_there, P = _formula(problem, computed.w, np.array(exact_point.a))
    exact_point = CriticalPoint(exact_point.a, float(delta_there), float(P), kind=exact_point.kind)
    point = computed.pull_off(LOAD_CONTROL)
    pull_off = point.P / exact_point.P - 1 if isinstance(point, CriticalPoint) else OUTSIDE
    parabola = None
    if isinstance(problem.indenter, Sphere):
        parabola = 1 - exact_point.P / (-1.5 * np.pi * computed.w * problem.indenter.R)
    # Greatest relative distance of the computed points from the exact curve; near pull-off in units of that point.
    # Where its displacement nearly vanishes (f = B r^1.5), a tenth of the shift t = sqrt(2 pi w a/E*) is the unit.
    moved = shift(computed.w, exact_point.a, 2 * problem.E_star)
    unit = CriticalPoint(exact_point.a, max(abs(exact_point.delta), 0.1 * moved), exact_point.P)
    distance = curve_distance(
        computed.a, computed.delta, computed.P, lambda radii: _formula(problem, computed.w, radii), unit,
        (problem.indenter.a0, problem.indenter.r_max * (1 - 1e-12)), relative=True,
    )  # fmt: skip
    return Comparison(load, pull_off, distance, parabola, exact)


def exact_curve(problem: Problem, w: float, a_max: float) -> AdhesiveCurve | None:
    """The closed-form adhesive curve of the indenter on a half-space up to ``a_max`` [m]."""
    indenter, E_star, a0 = problem.indenter, problem.E_star, problem.indenter.a0
    top = min(a_max, indenter.r_max * (1 - ROUNDED))
    a = a0 + (top - a0) * np.linspace(0, 1, 401)[1:] ** 2
    if a0:
        v = np.sqrt((a[0] - a0) * (a[0] + a0))
        rim = np.hypot(a0, np.geomspace(min(DISTANCE_RIM * a0, v / 2), v, DISTANCE_COARSE)[:-1])
        a = np.concatenate([rim, a])
    pair = indenter.half_space(a, E_star)
    if pair is None:
        return None
    slope = np.full_like(a, 2 * E_star)
    series = Series(a, *pair, slope * a, slope, a0=a0, S0=2 * E_star * a0)
    return transform(series, Slopes(slope * a, slope, "exact", 0.0), w)


def half_space_pull_off(problem: Problem, w: float, stiffness: float) -> CriticalPoint | Unknown:
    """JKR's pull-off of the indenter from a half-space under a device of a ``stiffness`` [N/m], against the work of
    adhesion ``w`` [J/m^2]; Unknown for tips without a radius and under surface tension."""
    R = problem.indenter.tip_radius
    if R is None or problem.specimen.surface_tension:
        return NO_FORMULA
    radius = (9 * np.pi * w * R**2 / (8 * problem.E_star)) ** (1 / 3)  # JKR's under load control, the widest
    curve = exact_curve(problem, w, DISTANCE_BEYOND * radius)
    return NO_FORMULA if curve is None else curve.pull_off(stiffness)


def _formula(problem: Problem, w: float, a: Array) -> tuple[Array, Array]:
    """delta [m] and P [N] of the closed form at radii ``a`` [m] of any shape."""
    pair = problem.indenter.half_space(a, problem.E_star)
    assert pair is not None
    return adhesive_half_space(a, *pair, problem.E_star, w)


def curve_distance(
    a: Array, delta: Array, P: Array, exact: Callable[[Array], tuple[Array, Array]], unit: CriticalPoint,
    ends: tuple[float, float], relative: bool = False,
) -> float:  # fmt: skip
    """Greatest distance of the points (``delta``, ``P``) from the curve ``exact`` of the radius, which is sought
    near their radii ``a`` [m] between the ``ends`` [m]; the axes in units of the displacement and load of ``unit``,
    or, where ``relative``, of the point itself where these are larger."""
    low, high = np.maximum(a / DISTANCE_WINDOW, ends[0]), np.minimum(a * DISTANCE_WINDOW, ends[1])
    columns = np.arange(a.size)
    pairs = (delta, abs(unit.delta)), (P, abs(unit.P))
    sizes = [np.maximum(np.abs(values), size) if relative else size for values, size in pairs]
    v = np.broadcast_to(np.linspace(0, 1, DISTANCE_COARSE)[:, None], (DISTANCE_COARSE, a.size))  # of the way, squared
    step, least = 1 / (DISTANCE_COARSE - 1), np.full(a.size, np.inf)
    for _ in range(DISTANCE_REFINEMENTS):
        delta_there, P_there = exact(low + (high - low) * v**2)
        off = (delta_there - delta) / sizes[0], (P_there - P) / sizes[1]
        distances = np.hypot(*off)
        nearest = np.argmin(distances, axis=0)
        least = np.minimum(least, distances[nearest, columns])
        v = np.clip(v[nearest, columns] + step * np.linspace(-1, 1, DISTANCE_FINE)[:, None], 0, 1)
        step *= 2 / (DISTANCE_FINE - 1)
    return float(np.max(least))


# --------------------------------------------------------------------------------------------------
# How far JKR holds: by what fraction the pull-off force would differ if adhesion had the range z0.
#
# The Tabor number answers it for a half-space alone. Here the same body is solved with a constant tension up to z0,
# unless the annulus in which it would act, pi z0^2 E*/(4 w) wide, is so narrow that nothing can differ.

# When the effect of a range is computed, and when it is reported.
# Width of the annulus over the contact radius and the top layer, below which the force differs by less than is
# reported:
RANGE_EFFECT_NARROW = 0.03  # choice: there a half-space differs by 0.5 %, layers by less
RANGE_EFFECT_POINTS = 40  # contact radii of the solution; choice: a tenth of a second


def effect_of_range(problem: Problem, series: Series, w: float, z0: float, point: CriticalPoint) -> Estimate:
    """The pull-off force under load control at the range ``z0`` [m] over that of JKR at ``point``, less 1; 0 where it
    must be next to nothing.

    ``series``: its radii are the ones solved for; ``w``: work of adhesion [J/m^2].
    """
    if problem.sticks:
        return Unknown("adhesion of finite range is implemented for frictionless contact only")
    if problem.specimen.surface_tension:
        return Unknown("adhesion of finite range is not derived with surface tension")
    h = min(point.a, problem.top_thickness)
    if math.pi * z0**2 * problem.E_star / (4 * w) < RANGE_EFFECT_NARROW * h:
        return 0.0
    if (R := problem.indenter.rim) < math.inf:
        if not problem.is_half_space or point.a < R:
            return FROM_RIM
        return punch_of_range(R, w, problem.E_star, z0) / -point.P - 1
    try:
        pull_off = ranged(problem, series, w, z0).pull_off(LOAD_CONTROL)
    except JkrError as error:
        return Unknown(str(error))
    return pull_off.P / point.P - 1 if isinstance(pull_off, CriticalPoint) else Unknown(pull_off.reason)


def ranged(problem: Problem, series: Series, w: float, z0: float) -> EquilibriumCurve:
    """The adhesive curve at some of the radii of ``series``, of the range ``z0`` [m] and the work of adhesion ``w``
    [J/m^2]."""

    some = np.unique(np.linspace(0, len(series) - 1, RANGE_EFFECT_POINTS).astype(int))
    body = FiniteRangeBody(problem, Series(series.a[some], series.delta[some], series.P[some]), AttractedBody(problem))
    return body.curve(Range.of(w, length=z0))

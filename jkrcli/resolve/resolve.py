"""Bodies solved again: over other radii, by another method, with other surfaces; and at the very points where contact
is lost.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..adhesion.contact_shape import ContactShape
from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, EquilibriumCurve, Nonadhesive, transform
from ..adhesion.finite_range import AttractedBody, FiniteRangeBody, Range
from ..adhesion.slopes import Slopes
from ..adhesion.validity import FROM_RIM
from ..base.errors import Estimate, JkrError, Refusal, Unknown
from ..base.numerics import ROUNDED, Array, zeros_between
from ..base.process import PATIENCE, duration
from ..base.units import show
from ..bodies.indenters import Sphere
from ..bodies.problem import Loading, Problem, without_side_walls
from ..formulas import adhesive_half_space, punch_of_range, shift
from ..methods.layered import contact as stack
from ..methods.layered import no_slip, solver
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

# --------------------------------------------------------------------------------------------------
# What it matters whether the surfaces stick or slide: the same body solved roughly under both assumptions.
#
# The sides of a finite body are left out. Eq. 13 holds for either: with the S, S', delta_H and P_H of a contact that
# was laid down without adhesion and then retracted, the radial displacements with which points were touched do no
# work.

# The rough solutions, and when their difference is worth a word.
# tuned on bodies, by `make constants`: of ratios that are shown to three digits; most are a hundred times as good
STICKING_EFFECT_ACCURACY = 1e-2
STICKING_EFFECT_RADII = 25  # tuned on bodies, by `make constants`: where pull-off is sought
# of the largest radius, the least of them; tuned on bodies, by `make constants`: below, the contact is a
# half-space's
STICKING_EFFECT_SMALLEST = 0.02
# of it, one more; tuned on bodies, by `make constants`: a stuck contact is wider at equal depth by less
STICKING_EFFECT_BEYOND = 1.1
STICKING_EFFECT_NOTICEABLE = 0.05  # relative change from which a reader is warned; choice: as for Tabor numbers


OUTSIDE = Unknown("pull-off lies outside the solution")
NOT_KEPT = Unknown("solution files do not keep it")


@dataclass(frozen=True)
class StickingEffect:
    """Sticking over sliding: ``load`` and ``stiffness_at_depth`` S at equal depth, ``stiffness`` S at equal radius, all
    at the radius ``a`` [m]; ``pull_off``: of the pull-off force under load control for each work of adhesion
    [J/m^2]."""

    a: float
    load: float
    stiffness: float
    pull_off: dict[float, Estimate]
    stiffness_at_depth: Estimate = NOT_KEPT

    @property
    def largest(self) -> float:
        """The largest of the relative changes."""
        pulls = (value for value in self.pull_off.values() if not isinstance(value, Unknown))
        return max(abs(ratio - 1) for ratio in (self.load, self.stiffness, *pulls))

    @property
    def words(self) -> str:
        """``1.63 times the load at equal depth, 1.7 times S at equal radius, 0.956 times the pull-off force``, the last
        with each w where they differ."""
        pulls = {w: f"{value:.3g}" for w, value in self.pull_off.items() if not isinstance(value, Unknown)}
        alike = len(set(pulls.values())) < 2
        each = dict.fromkeys(value if alike else f"{value} (w = {show(w, 'work')})" for w, value in pulls.items())
        parts = [f"{self.load:.3g} times the load at equal depth", f"{self.stiffness:.3g} times S at equal radius"]
        return ", ".join(parts + ([f"{' and '.join(each)} times the pull-off force"] if pulls else []))


def sticking_effect(problem: Problem, largest: float, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on ``problem`` at the contact radius ``largest`` [m], or why it is not known."""
    if problem.specimen.surface_tension:
        return Unknown("effect of no slip unknown: it is not derived with surface tension")
    body = without_side_walls(problem)
    if reason := no_slip.why_unsupported(body.indenter, body.specimen):
        return Unknown(f"effect of no slip unknown: {reason}")
    pair = stack.LayeredContact(body.indenter, body.specimen), no_slip.StuckLayeredContact(body.indenter, body.specimen)
    if largest > solver.QUICK * pair[1].scale:
        return Unknown(f"effect of no slip not computed at a contact radius of {largest:.3g} m")
    a0 = body.indenter.a0
    radii = a0 + (largest - a0) * np.append(
        np.geomspace(STICKING_EFFECT_SMALLEST, 1.0, STICKING_EFFECT_RADII), STICKING_EFFECT_BEYOND
    )
    radii = radii[(radii < body.indenter.r_max) & (radii <= body.indenter.rim)]
    try:
        solved: list[Series] = []
        for contact in pair:
            result: Any = contact.solved(radii, contact.plan(radii, STICKING_EFFECT_ACCURACY))  # type: ignore[arg-type]
            solved.append(Series(radii, result.delta, result.P, result.S, result.dS, a0=a0, rim=body.indenter.rim))
        sliding, sticking = solved
        pulled = [w for w in works if w > 0]
        pull_off = pull_off_ratios(sticking, sliding, pulled) if pulled else {}
    except JkrError as error:
        return Unknown(f"effect of no slip unknown: {error}")
    last = min(STICKING_EFFECT_RADII, radii.size) - 1
    stiffness = float(sticking.stiffness[last] / sliding.stiffness[last])
    if body.indenter.rim < math.inf:
        return StickingEffect(largest, stiffness, stiffness, pull_off, stiffness)
    depth = min(sliding.delta[last], sticking.delta[-1])
    load = _punch_at(sticking, sticking.P, depth) / _punch_at(sliding, sliding.P, depth)
    at_depth = _punch_at(sticking, sticking.stiffness, depth) / _punch_at(sliding, sliding.stiffness, depth)
    return StickingEffect(largest, load, stiffness, pull_off, at_depth)


def _punch_at(series: Series, column: Array, depth: float) -> float:
    """A ``column`` of the series at a ``depth`` [m], between its rows along a power law."""
    return float(np.exp(np.interp(np.log(depth), np.log(series.delta), np.log(column))))


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


def sticking_warnings(problem: Problem, effect: StickingEffect | Unknown) -> Iterator[str]:
    """Sentences on an assumption that matters by more than ``STICKING_EFFECT_NOTICEABLE``."""
    if isinstance(effect, Unknown) or effect.largest <= STICKING_EFFECT_NOTICEABLE:
        return
    other = "sliding" if problem.sticks else "sticking"
    assumed = "no slip" if problem.sticks else "no friction"
    yield (
        f"{assumed} is assumed: no slip gives {effect.words} of frictionless contact (a = "
        f'{show(effect.a, "length")}): compare with specimen.surface = "{other}"'
    )


def sticking(effect: StickingEffect | Unknown) -> dict[str, Any] | str:
    """The radius [m] and the ratios [-] of an effect, or why it is not known."""
    if isinstance(effect, Unknown):
        return str(effect)
    pulls = [{"w_J_per_m2": w, "ratio": value} for w, value in effect.pull_off.items()]
    return {"a_m": effect.a, "load": effect.load, "S": effect.stiffness, "pull_off": pulls}


def effect_facts(effect: StickingEffect | Unknown) -> dict[str, float | str]:
    """What a solution file keeps of it."""
    if isinstance(effect, Unknown):
        return {"sticking_over_sliding": str(effect)}
    return {"sticking_over_sliding_load": effect.load, "sticking_over_sliding_S": effect.stiffness}


def effect_on(solution: Solution, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on a solved body with its pull-off forces; not computed again where its file has it as small, and not of a
    contact that is no disc."""
    if ContactShape.of(solution.facts, False):
        return Unknown("effect of no slip unknown: it is solved for contacts that are discs")
    load, stiffness = (solution.facts.get(f"sticking_over_sliding_{name}") for name in ("load", "S"))
    a = float(solution.series.a[-1])
    if isinstance(load, float) and isinstance(stiffness, float):
        small = Unknown("not computed: load and S hardly differ")
        effect = StickingEffect(a, load, stiffness, dict.fromkeys(works, small))
        if effect.largest <= STICKING_EFFECT_NOTICEABLE:
            return effect
    return sticking_effect(solution.problem, a, works)


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

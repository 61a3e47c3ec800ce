"""Bodies solved again: over other radii, by another method, with other surfaces; and at the very points where contact
is lost.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..adhesion.curve import CONTROLS, AdhesiveCurve, CriticalPoint, Equilibrium, EquilibriumCurve, Nonadhesive
from ..adhesion.slopes import TWO_SIDED_90, exact
from ..base.errors import JkrError, Refusal
from ..base.numerics import MOST_SOLVES, SAME, Array, composite_gauss
from ..base.process import PATIENCE, duration
from ..bodies.problem import Loading, Problem
from ..case.models import Case, method_of
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
    failed: JkrError = Refusal("no exact method represents these bodies")
    for each in exact_methods() if method is None else (method,):
        try:
            if reason := each.refusal(changed):
                raise Refusal(reason)
            if longest < math.inf and (seconds := each.forecast(changed).seconds) >= longest:
                raise Refusal(f"the coarse solution would take about {duration(seconds)}")
            return each(changed)
        except JkrError as error:
            failed = error
    raise failed


def exact_methods() -> list[Method]:
    """The methods that are exact and cost next to nothing, least effort first."""
    return [method_class(name)() for name, method in METHODS.items() if method.exact]


def method_behind(solution: Solution) -> Method | None:
    """The method that made ``solution``, with the options of its case and the kernel that it has found."""
    name, case = solution.method, solution.record.case
    if name not in METHODS:
        return None
    method: Any = method_of(case.model, name) if isinstance(case, Case) else method_class(name)()
    found: Method = method if solution.kernel is None else replace(method, known=solution)
    return found


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
# The points where contact is lost, solved anew at their own radii where the method that made the series is exact.
#
# Between its radii a series is interpolated, with a larger error than that of an exact method. The problem is solved
# once more at seven radii close around each pull-off point: the curve then passes through the middle one with the
# slopes of the polynomials through the seven, and the errors of these slopes say how well the place is known.
#
# Over a homogeneous half-space delta_H is F, over others delta_H' = sqrt(2 E*/S') F' + what the kernel adds, which is
# smooth where the profile is not: the first part is integrated, and the polynomials only follow the rest.

POINTS = 14  # choice: radii that are solved at once for a curve: seven around each of two pull-off points
Further = Callable[[Array], Nonadhesive]  # the functions at other radii [m], solved
STEPS = np.arange(-3, 4)
MIDDLE = STEPS.size // 2
# Rows: derivatives of the polynomials through all values at ``STEPS``, the inner five, the inner three, by the step.
WEIGHTS = np.array([[-1, 9, -45, 0, 45, -9, 1], [0, 5, -40, 0, 40, -5, 0], [0, 0, -30, 0, 30, 0, 0]]) / 60

# Where further radii are solved, and how often.
SOLVED_STEP = 0.02  # of log(a - a0) between the seven; tuned on random bodies, by `make bounds`
# Of what is stated of columns, and of S', what is neither a spring in series nor a stiffness: on random bodies at
# most 0.03 of delta, 0.08 of S'
SOLVED_OWN = (0.06, 0.06, 0.06, 0.13)  # tuned on random bodies, by `make bounds`
# of delta where delta' is meant, at least
SOLVED_ROUGH = 0.25  # tuned on random bodies, by `make bounds`
# and of S' where S'' is meant, at least
SOLVED_BENT = 0.45  # tuned on random bodies, by `make bounds`
# Error of a rate, in logs, over that of its column: one kernel errs smoothly
SOLVED_STEEPER = 1.5  # tuned on random bodies, by `make bounds`
# Radius up to which such a kernel is made over that of the outermost point, less the flat end, at most:
SOLVED_REACH = 1.6  # tuned on random bodies, by `make bounds`
SOLVED_SCATTER = 1e-11  # of the columns from radius to radius; tuned on random bodies, by `make bounds`
SOLVED_EACH = 0.3  # of that of a solve, the cost of a curve's points; tuned on 1 to 1000 layers, by `make bench`
# Rows below a series, in equal steps of log sqrt(a^2 - a0^2), and how many more below the least pull-off:
SOLVED_DECADE = 15  # choice: a little closer than the 25 of four decades of "log", per decade of a - a0
SOLVED_UNDER = 4  # theory: of which splines and seven points around the point need some
SOLVED_RIM = 2e-6  # theory: of a0, the first sqrt(a^2 - a0^2): a - a0 is 1e4 times the round-off of a


def solver_of(solution: Solution) -> Further | None:
    """How further radii of ``solution`` are solved; None where its radii are not exact. ``seconds_of_points`` forecasts
    what that costs."""
    method, series = method_behind(solution), solution.series
    stated = {"delta", "dS"} <= series.errors.keys() and series.dS is not None
    if method is None or not stated or np.any(series.errors.get("a", 0.0)):
        return None
    problem, kept = replace(solution.problem, loading=Loading.given("radius", (float(series.a[-1]),))), solution.kernel
    if method.refusal(problem):
        return None

    def further(a: Array) -> Nonadhesive:
        beyond = np.outer(a - series.a0, np.exp(SOLVED_STEP * STEPS))
        radii = (series.a0 + beyond).ravel()
        if "parameters" in solution.facts and (kept is None or radii.max() > kept.reach):
            end = min(series.a0 + SOLVED_REACH * float(np.max(a - series.a0)), float(series.a[-1]))
            radii = np.append(radii, max(end, radii.max()))
        radii, order = np.unique(radii, return_inverse=True)
        return _in_the_middle(resolve_with(problem, radii, method), order[: beyond.size].reshape(-1, STEPS.size))

    return further


def seconds_of_points(solution: Solution, devices: int = 0) -> float:
    """CPU seconds of the solved pull-off points of a curve, about, those by so many ``devices`` included; 0 where none
    are."""
    method = method_behind(solution)
    if method is None or solver_of(solution) is None:
        return 0.0
    least, most = (float(solution.series.a[end]) for end in (0, -1))
    radii = np.unique(np.linspace(max(0.5 * most, least), most, POINTS + STEPS.size * devices))
    problem = replace(solution.problem, loading=Loading.given("radius", tuple(radii.tolist())))
    return SOLVED_EACH * method.forecast(problem).seconds


def _in_the_middle(solution: Solution, sevens: Array) -> Nonadhesive:
    """The functions at the ``sevens``, rows (n, 7) of ``solution`` at ``STEPS``, with slopes and the joint covariance
    of columns and slopes at the middle of each: those around it say how the slopes change."""
    series, problem = solution.series, solution.problem
    assert series.S is not None
    assert series.dS is not None
    # Rows that lie nearer, in logs, to their own middle than to any other, which all do
    places = np.log(series.a[sevens] - series.a0)
    middles, n = places[:, MIDDLE], np.arange(len(sevens))
    away, own = np.abs(places[:, :, None] - middles), np.abs(places - middles[:, None])
    away[n, :, n] = np.inf
    nearer = np.min(away, axis=2) >= own + SOLVED_STEP / 2
    nearer[:, MIDDLE] = True
    rows = np.unique(sevens[nearer])
    columns = {name: getattr(series, name)[rows] for name in ("a", "delta", "P", "S", "dS")}
    errors = {name: values[rows] for name, values in series.errors.items()}
    inner = replace(series, **columns, errors=errors, unresolved=solution.unresolved[:, rows])
    middle = sevens[:, MIDDLE]
    beyond, delta, dS = series.a[middle] - series.a0, series.delta[middle], series.dS[middle]
    followed = [_followed(problem, series, seven) for seven in sevens]
    known = np.array([rate for _, rate in followed]) * beyond / delta
    rest = np.stack([rest for rest, _ in followed]) / delta[:, None]
    (rate, by_dS), left = _rates(np.stack([rest, np.log(series.dS[sevens])]))
    log_rates, joint = np.full((rows.size, 2), np.nan), np.zeros((rows.size, 6, 6))
    here = np.searchsorted(rows, middle)
    log_rates[here] = np.stack([known + rate, by_dS * series.a[middle] / beyond], axis=1)
    unit = np.stack([delta, dS]) / beyond
    joint[here] = _joint(solution, sevens, np.stack([known + rate, by_dS]) * unit, left * unit)
    return Nonadhesive(inner, replace(exact(inner), joint=joint), log_rates)


def _joint(solution: Solution, sevens: Array, rates: Array, left: Array) -> Array:
    """Covariance (n, 6, 6) of the columns and of the ``rates`` delta_H', S'' (2, n) at the middle of the ``sevens``, of
    which polynomials leave ``left``.

    A kernel errs smoothly: most of it is the compliance of one spring in series, which leaves P as it is and changes S
    by the relative error e, S' by 2 e, delta_H by e P/S and delta_H' by e delta_H' the other way, S'' as S'; and what
    errs of P is one stiffness that is too large, of S, S' and S'' too. A small share of what is stated goes its own
    way, more of it where rates are meant; and so does the profile's part.

    What is known better are ``companions``: each errs in a way of its own, rates included.
    """
    series, companions = solution.series, solution.companions
    at = sevens[:, MIDDLE]
    values = np.stack([getattr(series, name)[at] for name in ("delta", "P", "S", "dS")])
    stated = np.stack([series.errors[name][at] for name in ("delta", "P", "S", "dS")])
    shift, slope = solution.unresolved[:, at]
    delta, P, S, dS = values
    kernel = stated - shift * np.stack([np.ones_like(S), S, 0 * S, 0 * S])
    kernel = kernel if companions is None else companions.least * values
    by_spring = np.stack([-P / S, 0 * S, S, 2 * dS, -rates[0], 2 * (dS**2 / S + rates[1])]) * kernel[2] / S
    by_stiffness = np.stack([0 * S, P, S, dS, 0 * S, rates[1]]) * kernel[1] / P
    common = np.stack([by_spring, by_stiffness])
    if companions is not None:
        columns = np.stack([getattr(series, name) for name in ("delta", "P", "S", "dS")])
        changes = (companions(series.a) * columns)[:, :, sevens]
        changed_rates = _rates(changes[:, ::3])[0] / (series.a[at] - series.a0)
        common = np.concatenate([common, np.concatenate([changes[..., MIDDLE], changed_rates], axis=1)])
    unit = np.stack([delta, dS]) / (series.a[at] - series.a0)
    steep = np.maximum(np.abs(rates), unit)
    pair = kernel[::3]
    not_of = np.sqrt(np.maximum(pair**2 - by_spring[:4:3] ** 2, 0.0))  # one spring
    rough = np.maximum(not_of, np.array([[SOLVED_ROUGH], [SOLVED_BENT]]) * pair)
    of_rates = SOLVED_STEEPER * steep * rough / values[::3] + left + SOLVED_SCATTER / SOLVED_STEP * unit
    profile = np.stack([shift, S * shift, 0 * S, 0 * S, slope, 0 * S])
    covariance = np.sum(common[:, :, None] * common[:, None], axis=0)
    own = np.array(SOLVED_OWN)[:, None] * kernel
    if companions is None:  # by the quadrature of F, where S is known much better: no spring
        own[0] = np.maximum(own[0], not_of[0])
    covariance[np.arange(6), np.arange(6)] += np.concatenate([own, of_rates]) ** 2 + profile**2
    return np.moveaxis(covariance, -1, 0) / TWO_SIDED_90**2


def _followed(problem: Problem, series: Series, seven: Array) -> tuple[Array, float]:
    """delta_H [m] at the rows ``seven`` without int sqrt(2 E*/S') F' da, up to a constant, and the integrand [-] at the
    middle one: whatever it is subtracted for, the sum is delta_H'."""
    assert series.dS is not None
    a, a0, indenter = series.a[seven], series.a0, problem.indenter
    log_dS = np.polynomial.Polynomial.fit(STEPS, np.log(series.dS[seven]), STEPS.size - 1)

    def rate(r: Array) -> Array:
        places = np.log((r - a0) / (a[MIDDLE] - a0)) / SOLVED_STEP
        return np.sqrt(2 * problem.E_star) * np.exp(-log_dS(places) / 2) * indenter.abel_slope(r)

    joints = [joint for joint in indenter.joints if a[0] < joint < a[-1]]
    nodes, weights = composite_gauss(np.union1d(a, joints))
    gained = np.sum(weights * rate(nodes.ravel()).reshape(nodes.shape), axis=1)
    through = np.concatenate([[0.0], np.cumsum(gained)])[np.searchsorted(np.union1d(a, joints), a)]
    return series.delta[seven] - through, float(rate(a[MIDDLE : MIDDLE + 1])[0])


def _rates(values: Array) -> tuple[Array, Array]:
    """Slopes (...) over log(a - a0) of ``values`` (..., 7) at ``STEPS``, and what the polynomials leave: their changes
    go on to fall as they have done, and no faster than by the step."""
    sixth, quartic, parabola = np.einsum("...k,wk->w...", values, WEIGHTS) / SOLVED_STEP
    first = np.abs(quartic - parabola)
    second = np.maximum(np.abs(sixth - quartic), SOLVED_STEP**2 * first)
    fall = np.divide(second, first, out=np.ones_like(first), where=first > second)
    return sixth, second * np.maximum(fall, SOLVED_STEP)


def solved(curve: AdhesiveCurve, further: Further, *devices: float) -> AdhesiveCurve:
    """The ``curve`` through what is solved at its pull-off points, those by ``devices`` of a stiffness [N/m] included,
    until they lie there."""
    controls = {*CONTROLS.values(), *devices}

    def wanted(body: Nonadhesive) -> list[float]:
        trial = AdhesiveCurve(body, curve.w)
        trial.find_critical(controls)
        return [point.a for k in controls if isinstance(point := trial.pull_off(k), CriticalPoint)]

    return AdhesiveCurve(refined(curve.nonadhesive, further, wanted), curve.w)


def solved_below(
    solution: Solution, works: Sequence[float], modulus_factor: float = 1.0, devices: Sequence[float] = ()
) -> Solution:  # fmt: skip
    """The ``solution`` with rows below its first one, down to the least radius at which contact is lost with the
    ``works`` of adhesion [J/m^2] under either control or by ``devices`` of a stiffness [N/m].

    As it is where that lies within it, or its method is not exact. Down to z0, with a flat end to its rim, where
    nothing is lost more.
    """
    method, series = method_behind(solution), solution.series
    if method is None or not METHODS[solution.method].exact or series.dS is None or len(series) < 2:
        return solution
    controls = [*CONTROLS.values(), *devices]

    def least(rows: Series) -> float:
        """The least radius [m] of pull-off; 0 where one lies below the ``rows``."""
        body, radii = Nonadhesive(rows, exact(rows)).scaled(modulus_factor), [math.inf]
        for curve, k in itertools.product([AdhesiveCurve(body, w) for w in works if w > 0], controls):
            point = curve.pull_off(k)
            if isinstance(point, CriticalPoint) and point.a > rows.a[0]:
                radii.append(point.a)
            elif curve.lowest_end(k) == "smallest":
                return 0.0
        return min(radii)

    first, a0 = float(np.sqrt((series.a[0] - series.a0) * (series.a[0] + series.a0))), series.a0
    floor = SOLVED_RIM * a0 if a0 else solution.record.z0
    if first <= floor or least(series) > 0:
        return solution
    steps = math.ceil(SOLVED_DECADE * math.log10(first / floor))
    below = np.hypot(a0, np.geomspace(floor, first, steps + 1)[:-1])
    try:
        rows = resolve_with(solution.problem, np.append(below, series.a), method, PATIENCE)
        begin = np.searchsorted(below, least(rows.series)) - SOLVED_UNDER
        if begin > 0:
            below = below[begin:]
            rows = resolve_with(solution.problem, np.append(below, series.a), method, PATIENCE)
    except JkrError:
        return solution
    facts = {**solution.facts, "rows_below": below.size}
    return replace(solution, series=rows.series, budget=rows.budget, companions=rows.companions, facts=facts)


def refined(body: Nonadhesive, further: Further, wanted: Callable[[Nonadhesive], Sequence[float]]) -> Nonadhesive:
    """The functions of ``body`` through what is solved at the radii [m] that are ``wanted`` of them, until these lie
    there."""
    before = np.array([])
    for step in range(MOST_SOLVES):
        radii = np.unique(wanted(body))
        if all(_is_solved_at(body, a) for a in radii):
            break
        if step > 1:
            # Those radii of the step before that lie apart from the new radii: where steps go to and fro, the
            # place lies between them
            steps = np.abs(np.log((before[:, None] - body.series.a0) / (radii - body.series.a0)))
            apart = before[np.min(steps, axis=1) > SOLVED_STEP]
        else:
            apart = before[:0]
        try:
            there = further(np.union1d(apart, radii))  # in place of what was solved further before
            trial = replace(body, further=there)
            trial.logs  # noqa: B018 - refuses points that do not fit in between the rows
        except JkrError:  # nor may body or profile allow it: what is interpolated stands, with its error
            break
        body, before = trial, radii
    return body


def is_refined(curve: EquilibriumCurve, point: Equilibrium) -> bool:
    """Whether the ``point`` was solved at its own radius, and is not one between rows."""
    if not isinstance(curve, AdhesiveCurve):
        return True  # of finite range: each solves itself
    return _is_solved_at(curve.nonadhesive, point.a)


def _is_solved_at(body: Nonadhesive, a: float) -> bool:
    further = body.further
    nearest = math.inf if further is None else float(np.min(np.abs(further.a - a)))
    return nearest <= SAME * (a - body.series.a0)

"""How far a body has to be solved for its pull-off, and where a viscoelastic specimen lets go, by its history."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Nonadhesive, mask_below_atomic_spacing
from ..adhesion.from_rest import FromRest, LoadingHistory, Rest, histories, history_error, work_from_pull_off
from ..adhesion.pull_off_error import Errors
from ..adhesion.validity import LIMITS, Strains, large_strains
from ..base.errors import Estimate, InputError, JkrError, Refusal, Unknown
from ..base.numerics import MOST_STEPS, ROWS, Array
from ..base.process import PATIENCE
from ..bodies.indenters import Indenter
from ..bodies.problem import Loading, Problem
from ..formulas import adhesive_half_space
from ..methods.layered.solver import Layered
from ..methods.radii import ROOM
from ..series import Solution
from .analysis import Analysis, forecast, method_behind, nonadhesive, refined, solver_of
from .neglected import LEFT_OUT_ACCURACY
from .resolve import resolve_with

# Radii at which a half-space is looked at, and those of a body whose w is known.
REACH_RADII = (1e-13, 1e3)  # choice: [m], from below atoms to beyond every body

REACH_INSIDE = 0.99  # choice: of the radius at which the indenter ends
REACH_FURTHER = 3.0  # choice: times the thickness of layers, then the radius of the contact before: the next one's
REACH_OF_DEVICES = 1e3  # choice: w of a force under displacement control over that under load control; a cone's: 3


def solved_for(problem: Problem, works: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0) -> Solution:
    """The ``problem``, whatever its loading, solved as far as its pull-off asks with any of the ``works`` [J/m^2]
    > 0: to little more than the largest contact radius without load; coarsely where thin layers leave no more."""
    w, largest = max(works), 0.0
    for wider in _wider(problem, w, modulus_factor):
        body = nonadhesive(wider, slopes).scaled(modulus_factor)
        P = AdhesiveCurve(body, w).P
        largest = float(body.a[P <= 0].max(initial=body.a[0]))
        if P[-1] > 0:
            break
    try:
        return resolve_with(_to(problem, largest))
    except JkrError:
        return resolve_with(_to(problem, largest), method=Layered(LEFT_OUT_ACCURACY))


def solved_for_force(
    problem: Problem, load: float, stiffnesses: Sequence[float], slopes: str = "auto", modulus_factor: float = 1.0
) -> Solution:
    """The same for the pull-off force ``load`` [N, > 0] measured by devices of the ``stiffnesses`` [N/m] (default: load
    control), whose w is sought on series that reach farther and farther."""
    w = work_on_half_space(problem.indenter, modulus_factor * problem.E_star, load)
    for wider in _wider(problem, w * REACH_OF_DEVICES if stiffnesses else w, modulus_factor):
        body = nonadhesive(wider, slopes).scaled(modulus_factor)
        try:
            works = [work_from_pull_off(body, load, stiffness).w for stiffness in stiffnesses or (LOAD_CONTROL,)]
        except InputError as error:  # the force may lie beyond this series
            failed = error
        else:
            return solved_for(problem, works, slopes, modulus_factor)
    raise failed


def work_on_half_space(indenter: Indenter, E_star: float, load: float) -> float:
    """The w [J/m^2] of which a half-space lets go at the pull-off force ``load`` [N, > 0] under load control: over all
    radii the least w = (P_H + load)^2/(8 pi E* a^3) that holds it."""
    a, _, P_H = half_space_radii(indenter, E_star)
    return float(np.min((P_H + load) ** 2 / (8 * math.pi * E_star * a**3)))


def _wider(problem: Problem, w: float, modulus_factor: float) -> Iterator[Solution]:
    """The problem solved to wider and wider contacts, coarsely, at last to the radius that a half-space of its softest
    material keeps without load: adhesion holds a smaller one on anything stiffer, far smaller on thin layers."""
    below = [layer.material for layer in problem.specimen.layers], getattr(problem.specimen.base, "material", None)
    softest = min(problem.E_star, *(getattr(one, "E_star", math.inf) for one in (*below[0], below[1])))
    E_star = modulus_factor * softest
    a, delta_H, P_H = half_space_radii(problem.indenter, E_star)
    _, P = adhesive_half_space(a, delta_H, P_H, E_star, w)
    widest = min(float(a[P <= 0].max(initial=a[0])), problem.indenter.rim)
    layers = problem.layers
    grows = layers and problem.indenter.rim == math.inf
    reach = min(REACH_FURTHER * sum(layer.thickness for layer in layers), widest) if grows else widest
    while True:
        far = _to(problem, reach)
        yield resolve_with(far, method=Layered(LEFT_OUT_ACCURACY)) if layers else resolve_with(far)
        if reach == widest:
            return
        reach = min(REACH_FURTHER * reach, widest)


def _to(problem: Problem, a: float) -> Problem:
    """The problem to little more than the contact radius ``a`` [m], by rows that crowd towards first touch."""
    end = min(ROOM * a, REACH_INSIDE * problem.indenter.r_max, problem.indenter.rim)
    return replace(problem, loading=Loading("radius", end, ROWS, "log"))


def half_space_radii(indenter: Indenter, E_star: float) -> tuple[Array, Array, Array]:
    """Contact radii from atoms to the end of the indenter [m], ``ROWS`` per decade, with delta_H [m] and P_H [N] on a
    half-space."""
    least, most = REACH_RADII
    end = min(most, REACH_INSIDE * indenter.r_max, indenter.rim)
    a = indenter.a0 + np.geomspace(least, end - indenter.a0, round(ROWS * math.log10(most / least)))
    columns = indenter.half_space(a, E_star)
    if columns is None:
        raise InputError(f"{indenter.words} has no closed form on a half-space: describe the bodies in a case file")
    return a, *columns


@dataclass(frozen=True)
class Rough:
    """``E_star`` [Pa] by the formula without adhesion at the largest load, its contact radius ``a`` [m], and ``w``
    [J/m^2] by the pull-off force of JKR with that modulus: of a half-space, without an error."""

    E_star: float
    a: float
    w: Estimate


def rough(tip: Indenter, load: float, depth: float, adhesion: Estimate) -> Rough | Unknown:
    """A glance at the ``load`` [N] that holds the ``tip`` at a ``depth`` [m], and at the force of ``adhesion`` [N]."""
    if not (load > 0 and depth > 0):
        return Unknown("the largest load or its depth is not positive")
    a, delta, P = half_space_radii(tip, 1.0)
    if not delta[0] < depth < delta[-1]:
        return Unknown("the depth lies beyond the indenter")
    radius, unit = (float(np.exp(np.interp(np.log(depth), np.log(delta), np.log(column)))) for column in (a, P))
    E_star = load / unit
    w = adhesion if isinstance(adhesion, Unknown) else work_on_half_space(tip, E_star, adhesion)
    return Rough(E_star, radius, w)


# --------------------------------------------------------------------------------------------------
# Where a viscoelastic specimen lets go, by its history: the curves of ``adhesion/from_rest.py``, solved as far as
# they reach and at their pull-off points.

CURVES = 4  # theory: one for each history; choice: of a forecast
FURTHER = 1.5  # choice: the next series over the one that ends too soon; what is solved in vain grows with it


NEVER_AT_REST = Unknown(
    "the relaxed modulus is zero: no contact is in equilibrium, the pull-off force has no upper limit"
)


@dataclass(frozen=True, eq=False)
class LostByHistory:
    """Where contact is lost after one ``history``: its ``curve``, and under each control, by the stiffness of the
    device [N/m], the point with its half-widths. ``solved_to``: radius [m] to which the body was solved on for it."""

    history: LoadingHistory
    curve: AdhesiveCurve | FromRest | Unknown
    lost: Mapping[float, tuple[CriticalPoint | Unknown, Errors | Unknown | None]]
    solved_to: float | None = None


def checked_histories(solution: Solution, rest: Rest | None) -> tuple[LoadingHistory, ...] | Unknown | None:
    """The histories of the specimen of ``solution`` with that from ``rest`` (default: at P = 0); None where it is
    elastic, InputError where a rest is given for it."""
    law = solution.problem.specimen.relaxation
    if law is not None:
        return histories(law, rest or Rest())
    if rest is not None:
        raise InputError(
            f"{solution.record.path}: its specimen is elastic, so that nothing relaxes at rest: leave --rest-load and "
            "--rest-depth out, or give specimen.relaxation"
        )
    return None


def lost_by_history(
    result: Analysis, controls: Sequence[float], rest: Rest | None = None, slopes: str = "auto"
) -> Sequence[LostByHistory] | Unknown | None:
    """Where the viscoelastic specimen of ``result`` loses contact after each history under ``controls`` by devices of a
    stiffness [N/m]; None for an elastic one."""
    known = checked_histories(result.solution, rest)
    if known is None or isinstance(known, Unknown):
        return known
    if len(known) == 1:
        return NEVER_AT_REST
    if result.law is not None:
        return Unknown("these histories are solved for JKR's adhesion: leave --stress and --range out")
    if result.w == 0:
        return Unknown("there is no adhesion at w = 0")
    return [_lost(result, one, controls, slopes) for one in known]


def _lost(result: Analysis, history: LoadingHistory, controls: Sequence[float], slopes: str) -> LostByHistory:
    w, z0 = result.w, result.solution.record.z0
    unit = replace(result.jkr.nonadhesive, further=None)
    solution, unit = solved_on(result.solution, unit, lambda body: not history.ends_too_soon(body, w), slopes)
    unit = with_history_solved(solution, unit, history, w, controls)
    curve = history.curve(unit, w)
    lost: dict[float, tuple[CriticalPoint | Unknown, Errors | Unknown | None]] = {}
    for stiffness in controls:
        if isinstance(curve, Unknown):
            lost[stiffness] = curve, None
            continue
        point = mask_below_atomic_spacing(curve.pull_off(stiffness), curve, stiffness, z0)
        error = None if isinstance(point, Unknown) else history_error(history, unit, curve, point, stiffness)
        lost[stiffness] = point, error
    end = float(unit.a[-1])
    return LostByHistory(history, curve, lost, end if end > result.curve.series.a[-1] else None)


def with_history_solved(
    solution: Solution, unit: Nonadhesive, history: LoadingHistory, w: float, controls: Sequence[float]
) -> Nonadhesive:
    """The functions ``unit`` through what is solved at the radii of rest and of pull-off after a ``history``, where the
    method of ``solution`` is exact."""
    further = solver_of(solution) if unit.slopes.method == "exact" else None

    def wanted(body: Nonadhesive) -> list[float]:
        curve = history.curve(body, w)
        if isinstance(curve, Unknown):
            return []
        points = [point for k in controls if isinstance(point := curve.pull_off(k), CriticalPoint)]
        return [point.a for point in points] + ([curve.rest.a] if isinstance(curve, FromRest) else [])

    return unit if further is None else refined(unit, further, wanted)


def strains_after(problem: Problem, w: float, history: LoadingHistory, point: CriticalPoint, loaded: bool) -> Strains:
    """What large strains change of the pull-off force at the ``point`` after a ``history``; not known of a dent that is
    kept."""
    R = problem.indenter.tip_radius
    if history.profile == 1:
        return large_strains(problem.scaled(history.moduli), w, point, loaded)
    if R is None or point.a <= LIMITS.strained * R:
        return None
    return Unknown(f"not estimated, a/R = {point.a / R:.2g} at pull-off")


def curves_from_rest(
    solution: Solution, works: tuple[float, float], history: LoadingHistory, slopes: str, modulus_factor: float,
    stiffness: float,
) -> tuple[AdhesiveCurve, FromRest, Strains]:  # fmt: skip
    """The curve on which the contact grows while the specimen is relaxed, and the one after the rest of ``history``,
    for the ``works`` of adhesion [J/m^2] of approach and retraction, and what large strains change of the force at
    which a device of ``stiffness`` [N/m] pulls off; InputError where the contact does not rest."""
    assert history.rest is not None
    inwards, outwards = works
    solution, unit = solution.scaled(modulus_factor), nonadhesive(solution, slopes).scaled(modulus_factor)
    solution, unit = solved_on(solution, unit, lambda body: not history.ends_too_soon(body, inwards), slopes)
    unit = with_history_solved(solution, unit, history, outwards, [stiffness])
    relaxed = history.relaxed(unit, inwards)
    state = history.rest.state(relaxed)
    if isinstance(state, Unknown):
        raise InputError(f"{solution.record.path}: {state.reason}")
    pulled = FromRest(AdhesiveCurve(history.body(unit), outwards), history.profile, state)
    lost = pulled.pull_off(stiffness)
    if isinstance(lost, Unknown):
        return relaxed, pulled, None
    return relaxed, pulled, strains_after(solution.problem, outwards, history, lost, stiffness == LOAD_CONTROL)


def solved_on(
    solution: Solution, unit: Nonadhesive, enough: Callable[[Nonadhesive], bool], slopes: str = "auto"
) -> tuple[Solution, Nonadhesive]:
    """The ``solution`` and its functions ``unit``, solved on to larger radii until they are ``enough``; as they are
    where its method does not go so far, or not soon."""
    method, there, body = method_behind(solution), solution, unit
    problem = solution.problem
    most = REACH_INSIDE * min(problem.indenter.r_max, problem.specimen.radius or problem.indenter.r_max)
    for _ in range(MOST_STEPS):
        end = min(FURTHER * float(body.a[-1]), most)
        if enough(body):
            return there, body
        if method is None or not end > body.a[-1]:
            break
        try:
            loading = Loading("radius", end, len(solution.series), "log")
            wider = resolve_with(replace(problem, loading=loading), None, method, PATIENCE)
            there = replace(wider, record=solution.record)
            body = nonadhesive(there, slopes)
        except (JkrError, Refusal):
            break
    return solution, unit


def seconds_of_histories(solution: Solution, works: Sequence[float], devices: int = 0) -> float:
    """CPU seconds of what is lost after the histories of a viscoelastic specimen, for each of the ``works`` of adhesion
    [J/m^2], beside the curve of very fast cycles."""
    if solution.problem.specimen.relaxation is None:
        return 0.0
    return CURVES * forecast(solution, works, devices=devices).seconds


def rest_of(load: float | None, depth: float | None, called: Callable[[str], str] = str) -> Rest | None:
    """The rest under a ``load`` [N] or at a ``depth`` [m]; None where neither is given, InputError where both are."""
    if load is not None and depth is not None:
        raise InputError(f"give at most one of {called('rest_load')} and {called('rest_depth')}")
    if depth is not None:
        return Rest(depth=depth)
    return None if load is None else Rest(load)

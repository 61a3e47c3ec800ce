"""Where a viscoelastic specimen lets go, by its history: the curves of ``adhesion/from_rest.py``, solved as far as they
reach and at their pull-off points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ..adhesion.curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, mask_below_atomic_spacing
from ..adhesion.finite_range import RangeRequest
from ..adhesion.from_rest import FAST, FROM_REST, SLOW, FromRest, LoadingHistory, Rest, histories, history_error
from ..adhesion.interpolation import Nonadhesive
from ..adhesion.pull_off_error import Errors
from ..adhesion.validity import LIMITS, Strains, large_strains
from ..base.errors import InputError, JkrError, Refusal, Unknown
from ..base.numerics import MOST_STEPS
from ..base.process import PATIENCE
from ..bodies.problem import Loading, Problem
from ..series import Solution
from .analysis import Analysis, analyse, forecast, nonadhesive
from .pull_off_range import REACH_INSIDE
from .refine_pull_off import refined, solver_of
from .resolve import method_behind, resolve_with

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


def pull_off_in_limits(
    solution: Solution, w: float, range_: RangeRequest, history: LoadingHistory | None, slopes: str = "auto",
    modulus_factor: float = 1.0,
) -> dict[str, CriticalPoint | Unknown]:  # fmt: skip
    """The pull-off points under load of what a viscoelastic specimen is between, for a work of adhesion ``w``
    [J/m^2]: very fast and very slow cycles with adhesion of finite range, and, without a range, the ``history`` from
    rest (None: nothing is at rest)."""
    relaxation = solution.problem.specimen.relaxation
    shares = {FAST: 1.0} | ({SLOW: relaxation.relaxed} if relaxation and relaxation.relaxed else {})
    points = {
        name: analyse(solution, [w], slopes, modulus_factor * share, range_)[0].curve.pull_off(LOAD_CONTROL)
        for name, share in shares.items()
    }
    if history is not None:
        try:
            _, curve, _ = curves_from_rest(solution, (w, w), history, slopes, modulus_factor, LOAD_CONTROL)
            points[FROM_REST] = curve.pull_off(LOAD_CONTROL)
        except InputError as error:
            points[FROM_REST] = Unknown(str(error))
    return points


def relaxed_specimen(solution: Solution, radius: float, slopes: str, modulus_factor: float = 1.0) -> Nonadhesive:
    """The w-free functions of a viscoelastic specimen whose moduli are relaxed, solved up to a contact ``radius`` [m]
    at least where that is not long."""
    relaxation = solution.problem.specimen.relaxation
    if relaxation is None or not relaxation.relaxed:
        raise InputError("cycle: --compare-rate needs a relaxed modulus above zero: a fluid has none")
    unit = nonadhesive(solution, slopes).scaled(modulus_factor)
    _, unit = solved_on(solution.scaled(modulus_factor), unit, lambda body: bool(body.a[-1] > radius), slopes)
    return unit.scaled(relaxation.relaxed)


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


def rest_of(load: float | None, depth: float | None) -> Rest | None:
    """The rest under a ``load`` [N] or at a ``depth`` [m]; None where neither is given, InputError where both are."""
    if load is not None and depth is not None:
        raise InputError("give at most one of --rest-load and --rest-depth")
    if depth is not None:
        return Rest(depth=depth)
    return None if load is None else Rest(load)

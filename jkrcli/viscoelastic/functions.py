"""What the Python interface offers of contact over time: adhesion over the speed of the edge, viscoelastic bodies.

Adhesion that depends on the speed of the contact's edge, over time:

>>> import jkrcli as jkr
>>> gel = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.499), thickness=5e-6),), jkr.Rigid(bonded=True))
>>> solved = jkr.solve(jkr.Problem(jkr.Paraboloid(R=10e-6), gel, jkr.Loading("radius", 8e-6)))
>>> history = jkr.cycle_at_speed(solved, 0.05, jkr.PowerRate(v0=1e-6, n=0.5), speed="10 um/s", to_load="1 uN")
>>> f"{history.pull_off.P * 1e6:.2f} uN after {history.pull_off.t:.3f} s"
'-12.98 uN after 0.126 s'

Bodies that relax, with ``w`` and ``stress`` with adhesion, too:

>>> solid = jkr.StandardSolid(ratio=0.25, time=1.0)
>>> history = jkr.cycle_relaxing(solved, solid, speed="10 um/s", to_depth="1 um", hold="3 s")
>>> [f"{corner.P * 1e6:.3f} uN" for corner in history.corners], f"lost after {history.lost:.3f} s"
(['14.983 uN', '4.395 uN'], 'lost after 3.129 s')
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, TypeAlias

from ..adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
from ..adhesion.device_path import Program
from ..adhesion.finite_range import without_range
from ..api import (
    Body,
    Force,
    Length,
    PositiveLength,
    SlopesRule,
    Stiffness,
    Stress,
    WorkOfAdhesion,
    range_of,
    solution_of,
)
from ..base import units
from ..base.arguments import checked, exactly_one
from ..base.errors import InputError
from ..base.process import one_thread
from ..bodies.problem import Relaxation
from ..resolve.analysis import analyse, nonadhesive, with_solved_points
from . import report as rate
from .by_history import CycledInLimits, traced_histories
from .course import Course
from .from_rest import LoadingHistory, Rest
from .rate import LogRate, PowerRate, RateContact, RateLaw, rate_law_of
from .relaxation import RelaxingContact
from .relaxing_adhesion import RelaxingAdhesion

__all__ = ["LogRate", "PowerRate", "cycle_at_speed", "cycle_relaxing"]

AnyLaw: TypeAlias = RateLaw | Mapping[str, Any]  # or its keys
Speed: TypeAlias = str | float  # of a device; under load control of its load
Time: TypeAlias = Annotated[float, units.Ranged("time", least=0)] | Any


@checked
@one_thread()
def cycle_at_speed(
    solved: Body, w: WorkOfAdhesion, law: AnyLaw, speed: Speed | None = None, *,
    program: Program | None = None, w_approach: WorkOfAdhesion | None = None, law_approach: AnyLaw | None = None,
    speed_approach: Speed | None = None, to_load: Force | None = None, to_depth: Length | None = None,
    hold: Time | None = None, stiffness: Stiffness = DISPLACEMENT_CONTROL, slopes: SlopesRule = "auto",
    stress: Stress | None = None,
) -> rate.CycledAtSpeed | CycledInLimits:  # fmt: skip
    """Compute a cycle over time whose work of adhesion depends on the speed of the contact line.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    w : float or str
        Work of adhesion at rest, on retraction [J/m^2].
    law : PowerRate, LogRate or mapping
        w over the speed of the edge: ``PowerRate(v0=1e-6, n=0.6)``, or its keys as of ``jkr cycle --rate``.
    speed : float or str, optional
        Of the instrument on retraction [m/s], under load control [N/s].
    program : Program, optional
        Positions over time, instead of speeds and reversals.
    w_approach : float or str, optional
        At rest, on approach; default: ``w``.
    law_approach : PowerRate, LogRate or mapping, optional
        On approach; default: w does not depend on speed there.
    speed_approach : float or str, optional
        On approach; default: ``speed``.
    to_load, to_depth : float or str, optional
        Where the instrument reverses [N] or [m]; default: the end of the solution.
    hold : float or str, optional
        Dwell at the reversal [s].
    stiffness : float or str, optional
        Of the instrument [N/m]: 0 is load control, infinite (default) a rigid one.
    slopes : str, optional
        As of `transform`.
    stress : float or str, optional
        Cohesive stress [Pa] of the dissipating zone, for its width.

    Returns
    -------
    CycledAtSpeed or CycledInLimits
        ``pull_off``, ``jumps``, ``lost``, ``energy_lost`` and ``error`` tell what happened; ``table(points)``: columns.

    Raises
    ------
    InputError
        Where the contact leaves the series.

    Notes
    -----
    G(a, delta) = w0 (1 + f(v)) at an edge that recedes with v = -da/dt (Gent and Schultz); f: the law.
    """

    w0, k = w, stiffness
    w_a = w0 if w_approach is None else w_approach
    inwards = None if law_approach is None else _law(law_approach)
    course = Course(to_load, to_depth, program, speed, speed_approach, hold)
    exactly_one("cycle_at_speed", speed=speed, program=program)
    solution = solution_of(solved, None)
    without_range(solution.record, "cycle_at_speed")

    def cycled(history: LoadingHistory | None) -> rate.CycledAtSpeed:
        share, words = (1.0, "") if history is None else (history.moduli, history.words)
        result = with_solved_points(analyse(solution, [w0], slopes, share)[0], k)
        contact = RateContact(result.jkr.nonadhesive, _law(law), w0, w_a, k, inwards)
        return rate.CycledAtSpeed.of(contact, course.program(contact), result, stress=stress, history=words)

    if solution.problem.specimen.relaxation is None:
        return cycled(None)
    known = traced_histories(solution, None, rests=False)
    return CycledInLimits.of(solution.record.path, known, map(cycled, known))


@checked
@one_thread()
def cycle_relaxing(
    solved: Body, relaxation: Relaxation | None = None, speed: Speed | None = None, *, w: WorkOfAdhesion = 0.0,
    stress: Stress | None = None, length: PositiveLength | None = None, rest_load: Force | None = None,
    rest_depth: Length | None = None, program: Program | None = None, speed_approach: Speed | None = None,
    to_load: Force | None = None, to_depth: Length | None = None, hold: Time | None = None,
    stiffness: Stiffness = DISPLACEMENT_CONTROL, slopes: SlopesRule = "auto", compare_rate: bool = False,
) -> rate.CycledRelaxing | rate.CycledAdhering:  # fmt: skip
    """Compute a cycle over time on a viscoelastic specimen.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    relaxation : StandardSolid, PowerRelaxation or Prony, optional
        ``StandardSolid(ratio=0.25, time=1.0)``; PowerRelaxation without adhesion only. Default: that of the specimen.
    speed : float or str, optional
        Of the instrument on retraction [m/s], under load control [N/s].
    w : float or str, optional
        Work of adhesion [J/m^2]; default: none.
    stress, length : float or str, optional
        Cohesive stress [Pa] or range [m] of the adhesion; default: what the case says.
    rest_load, rest_depth : float or str, optional
        The contact is at rest there [N] or [m] at the begin, and is pulled at ``speed``.
    program, speed_approach, to_load, to_depth, hold, stiffness, slopes : optional
        As of `cycle_at_speed`.
    compare_rate : bool, optional
        Add what a law w(v) of the same material predicts with the relaxed moduli: ``rate``.

    Returns
    -------
    CycledRelaxing or CycledAdhering
        ``peak``, ``corners``, ``turn``, ``lost`` and ``error`` tell what happened, with adhesion ``pull_off``,
        ``jumps`` and ``limits``, too; ``table(points)``: columns.

    Raises
    ------
    InputError
        Where the contact leaves the series or, without adhesion, is loaded again onto its dent.
    """
    solution, k, work = solution_of(solved, None), stiffness, w
    law, rest = relaxation or solution.problem.specimen.relaxation, Rest.of(rest_load, rest_depth)
    if law is None:
        raise InputError(
            "cycle_relaxing: the specimen has no relaxation: give one, StandardSolid(ratio=0.25, time=1.0)"
        )
    relaxing = replace(solution.problem, specimen=replace(solution.problem.specimen, relaxation=law))  # may refuse
    solution, ranged = replace(solution, problem=relaxing), range_of(solution, stress, length)
    course = Course(to_load, to_depth, program, speed, speed_approach, hold)
    exactly_one("cycle_relaxing", speed=speed, program=program)
    if work == 0:
        idle = {"rest_load": rest_load, "rest_depth": rest_depth, "stress": stress, "length": length}
        for name in [
            name for name, value in (idle | {"compare_rate": compare_rate or None}).items() if value is not None
        ]:
            raise InputError(f"cycle_relaxing: {name} is of adhesion: give w > 0, or leave it out")
        free = RelaxingContact(nonadhesive(solution, slopes), law, k)
        return rate.CycledRelaxing.of(free, course.program(free), solution.record.path)
    if not ranged:
        raise InputError(
            "cycle_relaxing: adhesion at a given speed needs its cohesive stress or range: give stress or length"
        )
    contact = RelaxingAdhesion.of(solution, ranged.law(work), law, k)
    turn = to_load, to_depth
    at_rest = [one for one in traced_histories(solution, rest, *turn) if one.rest is not None]
    limits = rate.pull_off_in_limits(solution, work, ranged, next(iter(at_rest), None), slopes)
    if rest is None:
        driven = course.program(contact)
    else:
        course.refuse_before_rest()
        contact = replace(contact, rests=True)
        driven = Program.on(contact.pulled_from(rest), -course.moves(k == LOAD_CONTROL).back)
    return rate.followed_with_limits(solution, contact, driven, limits, slopes, compare_rate=compare_rate)


def _law(law: AnyLaw) -> RateLaw:
    return rate_law_of(law, "law") if isinstance(law, Mapping) else law

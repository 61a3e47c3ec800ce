"""The Python interface: the objects that the command line works with, from a case to an adhesive curve.

>>> import jkrcli as jkr
>>> case = jkr.parse_case('''
... [indenter]
... shape = "paraboloid"
... radius = "10 um"
... [[specimen.layers]]
... thickness = "5 um"
... E = "1 MPa"
... nu = 0.499
... [loading]
... radius = "8 um"
... ''')
>>> solved = jkr.solve(case)
>>> solved.method
'layered'
>>> curve = jkr.transform(solved, w=0.05)
>>> point = curve.pull_off["load"]
>>> f"{point.P * 1e6:.4f} uN at a = {point.a * 1e6:.3f} um"
'-2.4906 uN at a = 2.418 um'
>>> list(jkr.table(curve))[:3]
['a_m', 'delta_m', 'P_N']

The same without TOML, by a method of one's choice:

>>> gel = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.499), thickness=5e-6),), jkr.Rigid(bonded=True))
>>> problem = jkr.Problem(jkr.Paraboloid(R=10e-6), gel, jkr.Loading("radius", 8e-6))
>>> curve = jkr.transform(jkr.solve(problem, jkr.Layered(tolerance=1e-9)), w="50 mJ/m^2")
>>> f"{curve.pull_off['load'].P * 1e6:.4f} uN"
'-2.4906 uN'

Adhesion that depends on the speed of the contact's edge, over time:

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

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol, TypeAlias, TypeVar, runtime_checkable

from .adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
from .adhesion.device_path import Course, Program
from .adhesion.finite_range import RangeRequest, without_range
from .adhesion.from_rest import LoadingHistory, Rest
from .adhesion.rate import RATE_LAWS, LogRate, PowerRate, RateContact, RateLaw, rate_law_of
from .adhesion.slopes import RULES
from .base import units
from .base.arguments import OneOf, check_names, checked, exactly_one
from .base.errors import InputError, JkrError, Refusal, Unknown
from .base.files import check_series_target
from .base.numerics import LEVEL
from .base.process import one_thread
from .base.registry import Result
from .bodies.indenters import Indenter, Paraboloid, PowerLaw, Pyramid, RoundedCone, RoundedFlat, Sphere, TableProfile
from .bodies.problem import (
    RELAXATIONS,
    Coated,
    Elastic,
    Exponential,
    Graded,
    GradedTransverselyIsotropic,
    HalfSpace,
    Layer,
    Linear,
    Loading,
    Power,
    PowerRelaxation,
    Problem,
    Prony,
    Relaxation,
    Rigid,
    Specimen,
    StandardSolid,
    Tabulated,
    TransverselyIsotropic,
)
from .case.models import Case, load_case
from .case.models import parse_case as _parse_case
from .case.store import read_solution, write_solution
from .case.store import solve as _solve
from .data.curve import Curve, Reading, Use
from .data.measured import from_columns
from .data.measured import read as read_curves
from .fitting import procedure
from .fitting.forward_model import FittedBody, body_of
from .fitting.joint import JointFit, joint_fit, shared_of, with_radii
from .fitting.parameters import Level, texts_of
from .fitting.procedure import further
from .fitting.rate import RateFit, rate_fit, rate_settings
from .fitting.relaxation import RelaxationFit, relaxation_fit, relaxation_settings
from .fitting.result import Fit, Further
from .fitting.settings import EACH, LAW, OPTIONS_OF, RELAXATION, SHARED, Noise, check_unused, settings_of
from .fitting.surface_tension import TENSION, TensionFit, known_values, radii_of, tension_fit
from .fitting.work import WORK_LEAST_WINDOW
from .methods.closed_form import ClosedForm
from .methods.fem import FEM
from .methods.hybrid import Hybrid
from .methods.layered.solver import Layered
from .methods.protocol import METHODS, Limits, Method
from .report import law_fits, rate  # noqa: F401 - the first registers what fits of laws say
from .report.check import Check
from .report.forward import Compared, Cycled, CycledByProgram, MeasuredByHistory, MeasuredPullOff, Profile, PullOff
from .report.inverse import Look, Work
from .report.result import PICTURES, Figure
from .resolve.analysis import Analysis, analyse, nonadhesive, with_solved_points
from .resolve.histories import checked_histories, curves_from_rest, lost_by_history, pull_off_in_limits, rest_of
from .series import Solution

__all__ = [
    "FEM", "ClosedForm", "Coated", "Elastic", "Exponential", "Graded", "GradedTransverselyIsotropic", "HalfSpace",
    "Hybrid", "InputError", "JkrError", "Layer", "Layered", "Limits", "Linear", "Loading", "LogRate", "Paraboloid",
    "Power", "PowerLaw", "PowerRate", "PowerRelaxation", "Problem", "Program", "Prony", "Pyramid", "Reading",
    "Refusal", "Rigid", "RoundedCone", "RoundedFlat", "Specimen", "Sphere", "StandardSolid", "TableProfile",
    "Tabulated", "TransverselyIsotropic", "Unknown", "check", "compare", "cycle", "cycle_at_speed",
    "cycle_relaxing", "fit", "identify", "identify_joint", "identify_law", "identify_relaxation",
    "identify_tension", "load_case", "look", "measured_curves", "parse_case", "plan", "plot", "profile", "pull_off",
    "read", "save", "solve", "summary", "table", "to_pandas", "transform", "work",
]  # fmt: skip
if TYPE_CHECKING:
    from pandas import DataFrame

AnyPath: TypeAlias = str | Path
Body: TypeAlias = Case | Problem | Solution | AnyPath  # to be solved, or solved; or the file of either
OneCurve: TypeAlias = Curve | AnyPath  # or the file that holds it
AnyLaw: TypeAlias = RateLaw | Mapping[str, Any]  # or its keys
Known: TypeAlias = Mapping[str, str | float] | None  # values of what is not fitted, standard deviations of inputs
AnyMethod: TypeAlias = Annotated[str, OneOf(METHODS, ("auto",))] | Method | None
SlopesRule: TypeAlias = Annotated[str, OneOf(RULES, ("auto",))]
AnyResult = TypeVar("AnyResult", bound=Result)

# Quantities are numbers in SI or, which only a call can see, text with a unit: ``checked`` reads both.
WorkOfAdhesion: TypeAlias = units.Work | Any
Force: TypeAlias = units.AnyForce | Any
Length: TypeAlias = units.AnyLength | Any
PositiveLength: TypeAlias = units.Length | Any
Stress: TypeAlias = units.Modulus | Any
Factor: TypeAlias = units.Factor | Any
Stiffness: TypeAlias = units.Control | Any
Tolerance: TypeAlias = Annotated[float, units.Ranged("number", least=0)]
Share: TypeAlias = Annotated[float, units.Ranged("number", least=0, most=1)]
RateName: TypeAlias = Annotated[str, OneOf(RATE_LAWS)]
RelaxationName: TypeAlias = Annotated[str, OneOf(RELAXATIONS)]
Speed: TypeAlias = str | float  # of a device; under load control of its load
Time: TypeAlias = Annotated[float, units.Ranged("time", least=0)] | Any


@runtime_checkable
class Columns(Protocol):
    """Arrays by the names of columns: a data frame, or a mapping."""

    def keys(self) -> Iterable[str]: ...

    def __getitem__(self, name: str, /) -> Any: ...


@checked
def parse_case(text: str, folder: AnyPath = ".") -> Case:
    """Parse a case from TOML text.

    Parameters
    ----------
    text : str
        A case as a file holds it.
    folder : path, optional
        Where names of profile tables are looked up.

    Returns
    -------
    Case
        To be solved by `solve`, or checked by `check`.

    Raises
    ------
    InputError
        With a line per mistake (exit code 2 of the command line).
    """
    return _parse_case(text.encode(), "case", Path(folder))


@checked
def solve(problem: Case | Problem | AnyPath, method: AnyMethod = None, limits: Limits | None = None) -> Solution:
    """Solve a body without adhesion at increasing contact radii.

    Parameters
    ----------
    problem : Case, Problem or path
        A case, its file, or a problem in objects.
    method : str or Method, optional
        A name ("closed-form", "layered", "fem", "hybrid") or a configured method, ``FEM(tolerance=1e-3)``; default: the
        case's own, else the cheapest that is exact enough.
    limits : Limits, optional
        Most memory and time to begin with, ``Limits(memory=8, hours=2)``: GiB and hours.

    Returns
    -------
    Solution
        Its ``series`` holds a [m], delta [m], P [N], S = dP/d(delta) [N/m] and dS/da [N/m^2], each of shape (n,), with
        relative errors; ``increments``: those of the method.

    Raises
    ------
    InputError
        Where the case is wrong.
    Refusal
        Where no method can represent it, or it would cost more than the limits.
    """
    _, solution = _solve(load_case(problem) if isinstance(problem, str | Path) else problem, method, limits)
    return solution


@checked
def read(path: AnyPath) -> Solution:
    """Read a solution file (HDF5) of ``jkr run``, contact pressures included.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Solution
        What `solve` gave.

    Raises
    ------
    InputError
        Where the file is damaged or none of ours.
    """
    return read_solution(path, with_pressure=True)


@checked
def save(solved: Solution, path: AnyPath, force: bool = False) -> Path:
    """Write a solution file (HDF5), whole or not at all.

    Parameters
    ----------
    solved : Solution
        What `solve` gave.
    path : path
        Its name ends in ``.h5``.
    force : bool, optional
        Replace a file that jkr did not write, too.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        Where the file cannot, or may not, be written.
    """
    target = Path(path)
    check_series_target(target, force)
    write_solution(target, solved, "import jkrcli")
    return target


@checked
@one_thread()
def transform(
    solved: Body, w: WorkOfAdhesion, slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0,
    method: AnyMethod = None, *,
    stress: Stress | None = None, length: PositiveLength | None = None,
) -> Analysis:  # fmt: skip
    """Transform a nonadhesive solution to the adhesive curve for one work of adhesion.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        A solution or its file; a case, its file or a problem is solved first, by ``method``.
    w : float or str
        Work of adhesion [J/m^2], or text with a unit, "40 mJ/m^2".
    slopes : str, optional
        How dS/da is found: "auto", "exact", "integral", "loocv", "gcv" or, with S of the cubic spline kept,
        "loocv-kept" and "gcv-kept".
    modulus_factor : float, optional
        All moduli times this; nothing is solved again.
    method : str or Method, optional
        Of what is not solved yet.
    stress : float or str, optional
        Cohesive stress [Pa] of adhesion of finite range (Maugis-Dugdale); default: what the case says.
    length : float or str, optional
        Range [m] of such adhesion, instead of ``stress``.

    Returns
    -------
    Analysis
        ``pull_off["load"]`` and ``["displacement"]`` with ``pull_off_errors`` (95 % half-widths), ``validity``,
        ``budget`` of errors, ``warnings``; ``columns``: arrays (n,) by name and unit; ``figure()``, ``summary()``,
        ``print(curve)``.

    Raises
    ------
    InputError
        Where w, slopes or the range cannot be used on this body.

    Notes
    -----
    delta = delta_H - sqrt(w) t, P = P_H - sqrt(w) S t with t = sqrt(4 pi a/S'), S' = dS/da (Eq. 13 of the paper).
    """
    solution = _solution(solved, method)
    ranged = _range(solution, stress, length)
    return analyse(solution, [w], slopes, modulus_factor, ranged)[0]


@checked
@one_thread()
def cycle(
    solved: Body, w: WorkOfAdhesion, *, program: Program | None = None, w_approach: WorkOfAdhesion | None = None,
    to_load: Force | None = None, to_depth: Length | None = None, stiffness: Stiffness = DISPLACEMENT_CONTROL,
    slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0, stress: Stress | None = None,
    length: PositiveLength | None = None,
    rest_load: Force | None = None, rest_depth: Length | None = None,
) -> Cycled | CycledByProgram | rate.CycledInLimits:  # fmt: skip
    """Compute the quasi-static cycle of approach and retraction.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    w : float or str
        Work of adhesion on retraction [J/m^2].
    program : Program, optional
        Positions of the instrument, with reversals anywhere; instead of ``to_load`` and ``to_depth``.
    w_approach : float or str, optional
        On approach, not larger than ``w``, the default.
    to_load, to_depth : float or str, optional
        Where the instrument reverses [N] or [m]; default: the end of the solution.
    stiffness : float or str, optional
        Of the instrument [N/m]: 0 is load control, infinite (default) a rigid one.
    slopes, modulus_factor, stress, length
        As of `transform`.
    rest_load, rest_depth : float or str, optional
        Of a viscoelastic specimen: where it is at rest before it is pulled [N] or [m]; default: at the reversal, or P =
        0.

    Returns
    -------
    Cycled, CycledByProgram or CycledInLimits
        Jumps, pull-off, and the energy that is lost; of a viscoelastic specimen after each history that is known: very
        fast and very slow cycles, and at rest, then pulled at once.

    Raises
    ------
    InputError
        Where the contact leaves the series.
    """

    solution, k = _solution(solved, None), stiffness
    Course(to_load=to_load, to_depth=to_depth, tabulated=program).refuse_idle()
    works = (w if w_approach is None else w_approach, w)
    ranged = _range(solution, stress, length)
    ranged.refuse_two(*works)
    turn = to_load, to_depth

    def cycled(history: LoadingHistory | None) -> Cycled | CycledByProgram:
        if history is not None and history.rest is not None:
            pulled = curves_from_rest(solution, works, history, slopes, modulus_factor, k)
            return Cycled.from_rest(solution.record.path, *pulled, k, history=history.words)
        share, words = (1.0, "") if history is None else (history.moduli, history.words)
        pair = analyse(solution, works, slopes, modulus_factor * share, ranged)
        curves = [with_solved_points(curve, k) for curve in pair]
        if program is not None:
            return CycledByProgram.of(curves, k, program)
        return Cycled.of(curves, k, *turn, history=words)

    rest = rest_of(rest_load, rest_depth)
    return _in_limits(solution, cycled, rest, *turn, program is None and not ranged)


def _in_limits(
    solution: Solution, cycled: Callable[[LoadingHistory | None], AnyResult], rest: Rest | None = None,
    load: float | None = None, depth: float | None = None, rests: bool = False,
) -> AnyResult | rate.CycledInLimits:  # fmt: skip
    """What was ``cycled`` on the moduli as they are; of a specimen that relaxes after each history that is known."""
    if solution.problem.specimen.relaxation is None:
        checked_histories(solution, rest)
        return cycled(None)
    known = rate.traced_histories(solution, rest, load, depth, rests)
    return rate.CycledInLimits.of(solution.record.path, known, cycled)


@checked
@one_thread()
def cycle_at_speed(
    solved: Body, w: WorkOfAdhesion, law: AnyLaw, speed: Speed | None = None, *,
    program: Program | None = None, w_approach: WorkOfAdhesion | None = None, law_approach: AnyLaw | None = None,
    speed_approach: Speed | None = None, to_load: Force | None = None, to_depth: Length | None = None,
    hold: Time | None = None, stiffness: Stiffness = DISPLACEMENT_CONTROL, slopes: SlopesRule = "auto",
    stress: Stress | None = None,
) -> rate.CycledAtSpeed | rate.CycledInLimits:  # fmt: skip
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
    course = Course(speed, speed_approach, to_load, to_depth, hold, tabulated=program)
    exactly_one("cycle_at_speed", speed=speed, program=program)
    solution = _solution(solved, None)
    without_range(solution.record, "cycle_at_speed")

    def cycled(history: LoadingHistory | None) -> rate.CycledAtSpeed:
        share, words = (1.0, "") if history is None else (history.moduli, history.words)
        result = with_solved_points(analyse(solution, [w0], slopes, share)[0], k)
        contact = RateContact(result.jkr.nonadhesive, _law(law), w0, w_a, k, inwards)
        return rate.CycledAtSpeed.of(contact, course.program(contact), result, stress=stress, history=words)

    return _in_limits(solution, cycled)


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
    from .adhesion.relaxation import RelaxingContact
    from .adhesion.relaxing_adhesion import RelaxingAdhesion

    solution, k, work = _solution(solved, None), stiffness, w
    law, rest = relaxation or solution.problem.specimen.relaxation, rest_of(rest_load, rest_depth)
    if law is None:
        raise InputError(
            "cycle_relaxing: the specimen has no relaxation: give one, StandardSolid(ratio=0.25, time=1.0)"
        )
    relaxing = replace(solution.problem, specimen=replace(solution.problem.specimen, relaxation=law))  # may refuse
    solution, ranged = replace(solution, problem=relaxing), _range(solution, stress, length)
    course = Course(speed, speed_approach, to_load, to_depth, hold, tabulated=program)
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
    at_rest = [one for one in rate.traced_histories(solution, rest, *turn) if one.rest is not None]
    limits = pull_off_in_limits(solution, work, ranged, next(iter(at_rest), None), slopes)
    if rest is None:
        driven = course.program(contact)
    else:
        course.refuse_before_rest()
        contact = replace(contact, rests=True)
        driven = Program.on(contact.pulled_from(rest), -course.moves(k == LOAD_CONTROL).back)
    return rate.followed_with_limits(solution, contact, driven, limits, slopes, compare_rate=compare_rate)


def _range(solution: Solution, stress: Stress | None, length: PositiveLength | None) -> RangeRequest:
    """Adhesion of finite range by its tension or its length, in numbers or text."""
    return RangeRequest.of(solution.record, stress, length)


def _law(law: AnyLaw) -> RateLaw:

    return rate_law_of(law, "law") if isinstance(law, Mapping) else law


def _solution(solved: Body, method: str | Method | None) -> Solution:
    """The series of what is solved, or to be solved."""
    if isinstance(solved, Case | Problem) or (not isinstance(solved, Solution) and Path(solved).suffix == ".toml"):
        solved = solve(solved, method)
    elif method is not None:
        raise InputError("method: is of what is not solved yet, and this is a solution: leave it out")
    return solved if isinstance(solved, Solution) else read_solution(solved)


@checked
def identify(
    body: Body, measured: OneCurve | Columns | None = None, free: Iterable[str] = (),
    fix: Known = None, slopes: SlopesRule = "auto", *, reading: Reading | None = None,
    a: Any = None, delta: Any = None, P: Any = None, t: Any = None, **options: Any,
) -> Fit:  # fmt: skip
    """Fit E*, w, contact point and force offset to one measured curve; ``fit`` is the same function.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        What was measured on: a case or problem (solved to the radii that the data ask for), a solution, or its file.
    measured : Curve, path, DataFrame or mapping, optional
        A file, or columns named as in a table ("delta_um", "P (nN)").
    free : iterable of str, optional
        More parameters: "P0", "E:film".
    fix : mapping, optional
        Known ones, ``{"w": "50 mJ/m^2", "E_star": 2e6}``.
    slopes : str, optional
        As of `transform`.
    reading : Reading, optional
        Units, signs and instrument of columns: ``Reading(units={"P": "nN"})``.
    a, delta, P, t : array, shape (n,), optional
        Instead of ``measured``: contact radius [m], displacement [m], load [N], time [s].
    **options
        Fields of `jkrcli.fitting.settings.Settings`: confidence, level, loss and others.

    Returns
    -------
    Fit
        ``value("E_star")``, ``estimate("w")`` with error and interval, ``verdict``, ``warnings``; ``figure()``,
        ``summary()``, ``print(fit)``.

    Raises
    ------
    InputError
        Where the data cannot be fitted.
    """
    _check_options("identify", EACH, options)
    arrays = {"a": a, "delta": delta, "P": P, "t": t}
    named = {name: values for name, values in arrays.items() if values is not None}
    if (measured is None) == (not named):
        raise InputError("identify: give either what was measured or arrays of a, delta, P, t")
    if reading is not None:  # a fit finds zero points itself, with the rest
        options = {"contact": reading.contact} | options
        reading = replace(reading, contact="as-is")
    curve = _curve_of(named if measured is None else measured, reading)
    source = body_of(body, slopes)
    result = one_thread()(procedure.fit)(source, curve, settings_of(source, free, fix or {}, **options))
    return replace(result, body=_named(body, source))


fit = identify  # the verb's name


@checked
def identify_joint(
    body: Body, measured: Sequence[OneCurve], shared: Iterable[str] = ("E_star", "w"), own: Iterable[str] = (),
    tip_radii: Sequence[PositiveLength] = (), free: Iterable[str] = (), fix: Known = None,
    slopes: SlopesRule = "auto", **options: Any,
) -> JointFit:  # fmt: skip
    """Fit what several measured curves share, E* and w by default, to all of them together.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        As of `identify`.
    measured : sequence of Curve or path
        One curve each.
    shared : iterable of str, optional
        Parameters that all curves have in common.
    own : iterable of str, optional
        Parameters that each curve has for itself, beside its zero points.
    tip_radii : sequence of float or str, optional
        Radius [m] of each tip, or one of all; default: the body's.
    free, fix, slopes, **options
        As of `identify`.

    Returns
    -------
    JointFit
        ``shared`` estimates, ``fits`` of the curves with these, what each says ``alone``, and the ``chance`` that
        curves which share them differ as much.

    Raises
    ------
    InputError
        Where a curve cannot be used, or the curves do not tell what they share.
    """
    _check_options("identify_joint", SHARED, options, **_given(slopes), tip_radius=tip_radii)
    source = body_of(body, slopes)
    curves = [_curve_of(item, None) for item in measured]
    settings = settings_of(source, free, fix or {}, **options)
    bodies = with_radii(source, tip_radii, len(curves))
    result = one_thread()(joint_fit)(bodies, curves, settings, shared_of(shared, own, settings))
    return replace(result, body=_named(body, source))


@checked
def plan(body: Body, found: Fit, slopes: SlopesRule = "auto") -> tuple[Further, ...]:
    """Compare what further measurements would leave of the errors of E* and w.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        What was fitted.
    found : Fit
        What `identify` gave.
    slopes : str, optional
        As of `transform`.

    Returns
    -------
    tuple of Further
        In ``words``: now, the same again, other largest loads, tip radii, thicknesses; each with the relative standard
        errors of ``E_star`` and ``w``.

    Raises
    ------
    InputError
        Where the data do not tell both.
    """

    return one_thread()(further)(body_of(body, slopes), found)


@checked
def identify_law(
    body: Body, measured: Iterable[OneCurve], law: RateName = "power", free: Iterable[str] = (), fix: Known = None,
    slopes: SlopesRule = "auto", **options: Any,
) -> RateFit:  # fmt: skip
    """Fit w0, the parameters of a law of w over the speed of the edge, E* and the contact point.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        As of `identify`.
    measured : iterable of Curve or path
        Retractions with time at one or several speeds, fitted together.
    law : str, optional
        "power" or "log".
    free : iterable of str, optional
        More parameters: "P0".
    fix : mapping, optional
        Known ones, ``{"n": "0.5"}``.
    slopes : str, optional
        As of `transform`.
    **options
        start, level, confidence, segment as of ``jkr fit --law``.

    Returns
    -------
    RateFit
        ``estimates``, the ``law``, and its ``band(v)`` over speeds [m/s].

    Raises
    ------
    InputError
        Where the curves cannot be fitted.
    """

    _check_options("identify_law", LAW, options)
    source = body_of(body, slopes)
    settings = rate_settings(source, law, free, fix or {}, **options)
    curves = [curve for each in measured for curve in ([each] if isinstance(each, Curve) else measured_curves(each))]
    return replace(one_thread()(rate_fit)(source, curves, settings), body=_named(body, source))


@checked
def identify_relaxation(
    body: Body, measured: OneCurve, law: RelaxationName = "sls", fix: Known = None, slopes: SlopesRule = "auto",
    free: Sequence[str] = (), **options: Any,
) -> RelaxationFit:  # fmt: skip
    """Fit the modulus, the parameters of a law of relaxation and the contact point to a curve with time.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        As of `identify`.
    measured : Curve or path
        One curve of t, delta, P.
    law : str, optional
        "sls", "power" or "prony".
    fix : mapping, optional
        Known values, ``{"ratio": "0.3"}``.
    slopes : str, optional
        As of `transform`.
    free : sequence of str, optional
        More parameters: ``["w"]`` for a retraction with adhesion, with ``fix`` ``{"stress": "300 Pa"}`` or "range".
    **options
        level, confidence, terms as of ``jkr fit --relaxation``.

    Returns
    -------
    RelaxationFit
        ``estimates``, the law as ``relaxation``, and the modelled ``response``.

    Raises
    ------
    InputError
        Where the curve cannot be fitted.
    """

    _check_options("identify_relaxation", RELAXATION, options, **_given(slopes), relaxation=law)
    source = body_of(body, slopes)
    curve = _curve_of(measured, None)
    names = (law, fix or {}, free, source.problem.E_star, source.range_of_case)
    result = one_thread()(relaxation_fit)(source, curve, relaxation_settings(*names, **options))
    return replace(result, body=_named(body, source))


@checked
def identify_tension(
    body: Body, measured: Sequence[OneCurve], tip_radii: Sequence[PositiveLength] = (), fix: Known = None,
    level: Level = LEVEL,
) -> TensionFit:  # fmt: skip
    """Fit surface tension, E*, w and the contact points to curves by tips of one or more radii.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        As of `identify`.
    measured : sequence of Curve or path
        One curve each, all of the same specimen.
    tip_radii : sequence of float or str, optional
        Radius [m] of each tip, or one of all; default: the body's.
    fix : mapping, optional
        Known values, ``{"w": "1 mJ/m^2"}``.
    level : float, optional
        Of the intervals.

    Returns
    -------
    TensionFit
        ``estimates``; ``mixed``: what tips of one radius do not separate from the tension.

    Raises
    ------
    InputError
        Where a curve cannot be used.
    """

    source = body_of(body)
    problem = source.problem
    curves = [_curve_of(item, None) for item in measured]
    radii = radii_of(problem, tip_radii, len(curves))
    known = known_values(problem, [] if TENSION in (fix or {}) else [TENSION], fix or {})
    result = one_thread()(tension_fit)(problem, curves, radii, known, level)
    return replace(result, body=_named(body, source))


def _check_options(name: str, kind: str, options: Mapping[str, Any], **beside: Any) -> None:
    """InputError where one of the ``options`` of the function ``name`` is none, or without an effect on a ``kind`` of
    fit with what is given ``beside``."""
    check_unused(kind, {**options, **beside}, by=name)
    check_names(name, options, OPTIONS_OF[kind])


def _given(slopes: str) -> dict[str, str]:
    """The rule for slopes where it is not the default."""
    return {} if slopes == "auto" else {"slopes": slopes}


def _named(body: Any, source: FittedBody) -> str:
    """What was fitted in words: its file, or the body."""
    return str(body) if isinstance(body, str | Path) else source.problem.words


def _curve_of(measured: Any, reading: Reading | None) -> Curve:
    """One curve, of what may be a curve, a file, a data frame or arrays by name."""
    if isinstance(measured, Curve):
        if reading not in (None, Reading(contact="as-is")):
            raise InputError("reading: is of what is not read yet, and this is a curve: leave it out")
        return measured
    if not isinstance(measured, str | Path):
        names = {"a": "a (m)", "delta": "delta (m)", "P": "P (N)", "t": "t (s)"}  # SI where no unit is named
        units = () if reading is None else reading.units
        return from_columns({names.get(k, k) if k not in units else k: measured[k] for k in measured}, reading)
    curves = read_curves(Path(measured), reading)
    if len(curves) > 1:
        raise InputError(f"{measured}: holds {len(curves)} curves, one is wanted: give one of measured_curves(path)")
    return curves[0]


@checked
def measured_curves(path: AnyPath, **reading: Any) -> list[Curve]:
    """Read the measured curves in a file.

    Parameters
    ----------
    path : path
        A table, an instrument's file, or a folder or archive of them.
    **reading
        Fields of `Reading`: ``units={"P": "nN"}``.

    Returns
    -------
    list of Curve
        In SI, compression and indentation positive.

    Raises
    ------
    InputError
        Where the file cannot be read.
    """
    return read_curves(Path(path), _reading("measured_curves", reading))


def _reading(where: str, options: Mapping[str, Any]) -> Reading:
    check_names(where, options, [item.name for item in fields(Reading)])
    return Reading(**options)


@checked
def check(case: Case | AnyPath) -> Check:
    """Tell which method a case needs, what each costs and what to expect; nothing is solved at full accuracy.

    Parameters
    ----------
    case : Case or path
        The case, or its file.

    Returns
    -------
    Check
        The choice of the method, costs and errors of all, ``expected`` sizes, and neglected effects with their size.

    Raises
    ------
    InputError
        Where the case is wrong.
    """
    loaded = load_case(case) if isinstance(case, str | Path) else case
    return one_thread()(Check.of)(Path(case) if isinstance(case, str | Path) else Path("case"), loaded)


@checked
def look(path: AnyPath, tip: Indenter | None = None, **reading: Any) -> Look:
    """Tell what a measured file holds: segments, base line, contact, jumps, adhesion force; no body is needed.

    Parameters
    ----------
    path : path
        The file.
    tip : indenter, optional
        ``Sphere(5e-6)``: with a rough modulus, too.
    **reading
        Fields of `Reading`.

    Returns
    -------
    Look
        ``records``, and why others are ``unusable``; ``figure()``.

    Raises
    ------
    InputError
        Where a field of the reading is wrong.
    """
    return one_thread()(Look.at)(Path(path), _reading("look", reading), tip)


@checked
@one_thread()
def profile(
    solved: Body, a: Length | None = None, load: Force | None = None, w: WorkOfAdhesion = 0.0, *,
    stress: Stress | None = None, length: PositiveLength | None = None,
) -> Profile:  # fmt: skip
    """Compute pressure, displacement and gap around one contact.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    a : float or str, optional
        Contact radius [m]; give either this or ``load``.
    load : float or str, optional
        Load [N] under which the radius is found.
    w : float or str, optional
        Work of adhesion [J/m^2]; default: none.
    stress, length : float or str, optional
        As of `transform`.

    Returns
    -------
    Profile
        ``columns``: radius [m], pressure [Pa], displacement and gap [m], each of shape (n,).

    Raises
    ------
    InputError
        Where the contact is not one of the series.
    """
    from .resolve.analysis import profile_columns, radius_under

    exactly_one("profile", a=a, load=load)
    solution = _solution(solved, None)
    ranged = _range(solution, stress, length)
    radius: Any = a if load is None else radius_under(solution, load, w, ranged)
    return Profile(solution.record.path, radius, w, profile_columns(solution, radius, w, ranged))


@checked
@one_thread()
def pull_off(
    solved: Body, w: WorkOfAdhesion | None = None, load: Force | None = None, stiffness: Sequence[Stiffness] = (),
    slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0, *, stress: Stress | None = None,
    length: PositiveLength | None = None,
    uncertain: Known = None, rest_load: Force | None = None, rest_depth: Length | None = None,
) -> PullOff | MeasuredPullOff | MeasuredByHistory:  # fmt: skip
    """Find where contact is lost, or which w a measured pull-off force means.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    w : float or str, optional
        Work of adhesion [J/m^2]; give either this or ``load``.
    load : float or str, optional
        Measured pull-off force [N]: which w does it mean?
    stiffness : sequence of float or str, optional
        Of instruments [N/m]; default: load and displacement control.
    slopes, modulus_factor, stress, length
        As of `transform`.
    uncertain : mapping, optional
        Standard deviations of what w follows from, ``{"load": "5%", "R": "2%"}``.
    rest_load, rest_depth : float or str, optional
        Of a viscoelastic specimen: at rest there [N] or [m], then pulled at once; default: at P = 0.

    Returns
    -------
    PullOff, MeasuredPullOff or MeasuredByHistory
        Under each control, of a viscoelastic specimen after each history.

    Raises
    ------
    InputError
        Where contact is not lost within the series, or the force is none of this body.
    """
    from .resolve.analysis import where_lost
    from .resolve.measured_work import measured_work, refuse_idle, works_by_history

    exactly_one("pull_off", w=w, load=load)
    refuse_idle(load, uncertain or {}, stress, length)
    solution, devices, rest = _solution(solved, None), list(stiffness), rest_of(rest_load, rest_depth)
    if load is not None:
        without_range(solution.record, "pull_off: load")
        if len(devices) > 1:
            raise InputError(f"stiffness: a measured load has one, got {len(devices)}")
        force, pairs = abs(load), texts_of(uncertain or {})
        under = (devices or [LOAD_CONTROL])[0]
        found = works_by_history(solution, force, under, rest, slopes, modulus_factor, pairs)
        if isinstance(found, list):
            return MeasuredByHistory.of(solution, force, under, found, slopes, modulus_factor)
        return MeasuredPullOff(measured_work(solution, force, under, slopes, modulus_factor, pairs))
    ranged = _range(solution, stress, length)
    works: list[Any] = [w]
    curve, lost = where_lost(solution, works, devices, slopes, modulus_factor, ranged)[0]
    controls = devices or [LOAD_CONTROL, DISPLACEMENT_CONTROL]
    return PullOff(curve, lost, lost_by_history(curve, controls, rest, slopes))


@checked
@one_thread()
def work(
    solved: Body, measured: AnyPath, slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0, *,
    reading: Reading | None = None, use: Use | None = None, segment: str | None = None, noise: Noise | None = None,
    window: Annotated[int, units.Ranged("number", least=WORK_LEAST_WINDOW)] = 11,
) -> Work:  # fmt: skip
    """Compute the work of adhesion along measured curves, row by row.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        As of `transform`.
    measured : path
        The file of the curves.
    slopes, modulus_factor
        As of `transform`.
    reading : Reading, optional
        How the file is read.
    use : {"a,P", "a,delta", "delta,P"}, optional
        Columns from which w is computed; default: the first of these that were measured.
    segment : str, optional
        Rows of this segment only.
    noise : mapping, optional
        Standard deviations of measured quantities, ``{"P": "2 nN"}``.
    window : int, optional
        Rows for the speed da/dt: an odd number.

    Returns
    -------
    Work
        ``curves`` with w [J/m^2] and its error by rows, over the speed of the edge where time was recorded.

    Raises
    ------
    InputError
        Where the file cannot be read or has too few columns.
    """
    from .base.executors import executor
    from .fitting.work import along_file, evaluation_of

    solution, path, reading = _solution(solved, None), Path(measured), reading or Reading()
    unit = nonadhesive(solution, slopes)
    without_range(solution.record, "work")
    evaluation = evaluation_of(solution, unit, reading, modulus_factor, use, segment, noise, window)
    with executor(1) as pool:
        return Work.of(path, *along_file(path, reading, evaluation, pool), solution, unit, modulus_factor)


@checked
def compare(
    first: Body, second: Body, rtol: Tolerance = 1e-3, columns: Iterable[str] = (), overlap: Share = 0.9,
) -> Compared:  # fmt: skip
    """Compare two results of the same problem.

    Parameters
    ----------
    first, second : Solution, Case, Problem or path
        Solutions ("P" and "a" at equal displacement, "S" and "dS" at equal radius), or the CSV files of curves.
    rtol : float, optional
        Relative difference up to which they agree.
    columns : iterable of str, optional
        Those that count; default: P, of curves all.
    overlap : float, optional
        Least share of their range that is common.

    Returns
    -------
    Compared
        Whether they ``agree``, and the difference of each column.

    Raises
    ------
    InputError
        Where less is common.
    """
    one, two = (Path(item) if isinstance(item, str | Path) else Path("solved") for item in (first, second))
    both = (first, second)
    return Compared.of((one, two), lambda: [_solution(item, None) for item in both], rtol, columns, overlap)


@checked
def table(curve: Result) -> Mapping[str, Any]:
    """Return the columns of a result's CSV file.

    Parameters
    ----------
    curve : Result
        Of any function here.

    Returns
    -------
    mapping
        Arrays by names with units, of a curve one value per contact radius.
    """
    return curve.columns


@checked
def to_pandas(curve: Result) -> DataFrame:
    """Return the columns of a result as a data frame (needs pandas).

    Parameters
    ----------
    curve : Result
        Of any function here.

    Returns
    -------
    pandas.DataFrame
        A column each.

    Raises
    ------
    InputError
        Where pandas is not installed.
    """
    return curve.to_pandas()


@checked
def plot(curve: Result, path: AnyPath | None = None) -> Figure:
    """Draw a result.

    Parameters
    ----------
    curve : Result
        Of any function here; a curve is drawn as load over displacement and contact radius over load.
    path : path, optional
        Also written there: .png or .svg.

    Returns
    -------
    matplotlib.figure.Figure
        To draw on.

    Raises
    ------
    InputError
        Where the path cannot be written, or ends otherwise.
    """
    from .report import plots

    if path is not None and Path(path).suffix not in PICTURES:
        raise InputError(f"path: must end in {' or '.join(PICTURES)}, got {path}")
    figure = curve.figure()
    if path is not None:
        plots.save(figure, [Path(path)])
    return figure


@checked
def summary(curve: Result) -> dict[str, Any]:
    """Return what a result's JSON file says.

    Parameters
    ----------
    curve : Result
        Of any function here.

    Returns
    -------
    dict
        Plain values, SI; names with units.
    """
    return curve.summary()

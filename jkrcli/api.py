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
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from .adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
from .adhesion.device_path import Program
from .adhesion.finite_range import RangeRequest
from .adhesion.from_rest import LoadingHistory, Rest
from .adhesion.rate import LogRate, PowerRate
from .base.errors import InputError, JkrError, Refusal, Unknown
from .base.files import check_series_target
from .base.process import one_thread
from .base.result import Result
from .base.units import parse
from .bodies.indenters import Paraboloid, PowerLaw, Pyramid, RoundedCone, RoundedFlat, Sphere, TableProfile
from .bodies.materials import (
    Coated,
    Elastic,
    Exponential,
    Graded,
    GradedTransverselyIsotropic,
    Layer,
    Linear,
    Power,
    PowerRelaxation,
    Prony,
    StandardSolid,
    Tabulated,
    TransverselyIsotropic,
)
from .bodies.problem import HalfSpace, Loading, Problem, Rigid, Specimen
from .case.reading import Case, load_case
from .case.reading import parse_case as _parse_case
from .case.store import read_solution, write_solution
from .case.store import solve as _solve
from .data.curve import Curve, Reading
from .data.measured import from_columns
from .data.measured import read as read_curves
from .fitting import procedure
from .fitting.forward_model import FittedBody, body_of
from .fitting.joint import JointFit, joint_fit, shared_of, with_radii
from .fitting.procedure import further
from .fitting.result import Fit, Further
from .fitting.settings import settings_of
from .methods.closed_form import ClosedForm
from .methods.fem.method import FEM
from .methods.hybrid.method import Hybrid
from .methods.layered.solver import Layered
from .methods.protocol import Limits, Method
from .report.check import Check
from .report.forward import (
    Compared,
    Cycled,
    CycledByProgram,
    MeasuredByHistory,
    MeasuredPullOff,
    Profile,
    PullOff,
)
from .report.inverse import Look, Work
from .report.rate import (
    CycledAdhering,
    CycledAtSpeed,
    CycledInLimits,
    CycledRelaxing,
    followed_with_limits,
    traced_histories,
)
from .report.result import Figure
from .resolve.analysis import Analysis, analyse, nonadhesive, with_solved_points
from .series import Solution

__all__ = [
    "FEM", "ClosedForm", "Coated", "Elastic", "Exponential", "Graded", "GradedTransverselyIsotropic", "HalfSpace",
    "Hybrid", "InputError", "JkrError", "Layer", "Layered", "Limits", "Linear", "Loading", "LogRate", "Paraboloid",
    "Power", "PowerLaw", "PowerRate", "PowerRelaxation", "Problem", "Program", "Prony", "Pyramid", "Reading",
    "Refusal", "Rigid", "RoundedCone", "RoundedFlat", "Specimen", "Sphere", "StandardSolid", "TableProfile",
    "Tabulated", "TransverselyIsotropic", "Unknown", "check", "compare", "cycle", "cycle_at_speed",
    "cycle_relaxing", "fit", "identify", "identify_joint", "identify_law", "identify_relaxation",
    "identify_tension", "load_case", "look", "measured_curves", "parse_case", "plan", "plot", "profile", "pull_off",
    "read", "save", "solve", "study_map", "summary", "table", "to_pandas", "transform", "work",
]  # fmt: skip
if TYPE_CHECKING:
    from pandas import DataFrame

    from .adhesion.device_path import Turning
    from .adhesion.rate import RateLaw
    from .bodies.indenters import Indenter
    from .bodies.materials import Relaxation
    from .fitting.rate import RateFit
    from .fitting.relaxation import RelaxationFit
    from .fitting.surface_tension import TensionFit
    from .many.maps import MapResult

Body: TypeAlias = Case | Problem | Solution | str | Path  # to be solved, or solved; or the file of either
Number: TypeAlias = float | str  # in SI, or text with its unit
OneCurve: TypeAlias = Curve | str | Path  # or the file that holds it
AnyLaw: TypeAlias = "RateLaw | Mapping[str, Any]"  # or its keys
Known: TypeAlias = Mapping[str, Number] | None  # values of what is not fitted, standard deviations of inputs
AnyResult = TypeVar("AnyResult", bound=Result)


def parse_case(text: str, folder: str | Path = ".") -> Case:
    """A case from TOML text; ``folder`` is where names of profile tables are looked up.

    Raises InputError (exit code 2 of the command line) with a line per mistake.
    """
    return _parse_case(text.encode(), "case", Path(folder))


def solve(
    problem: Case | Problem | str | Path, method: str | Method | None = None, limits: Limits | None = None
) -> Solution:
    """The nonadhesive series of a problem, a case or the case file at a path, as its series file gives it back.

    ``method``: a name or a configured method, FEM(tolerance=1e-3), instead of the case's own; ``limits``: most memory
    and time to begin with, Limits(memory=8, hours=2). Raises InputError where the case is wrong, no method can
    represent it, or it would cost too much.
    """
    _, solution = _solve(load_case(problem) if isinstance(problem, str | Path) else problem, method, limits)
    return solution


def read(path: str | Path) -> Solution:
    """What the series file (HDF5) at ``path`` holds, contact pressures included."""
    return read_solution(path, with_pressure=True)


def save(solved: Solution, path: str | Path, force: bool = False) -> Path:
    """Write a series file, whole or not at all; a file that jkr did not write is replaced only with ``force``."""
    target = Path(path)
    check_series_target(target, force)
    write_solution(target, solved, "import jkrcli")
    return target


@one_thread()
def transform(
    solved: Body, w: Number, slopes: str = "auto", modulus_factor: float = 1.0, method: str | Method | None = None, *,
    stress: Number | None = None, length: Number | None = None,
) -> Analysis:  # fmt: skip
    """The adhesive curve for the work of adhesion ``w`` [J/m^2], with pull-off, errors, validity and warnings.

    ``solved``: a solution or its file; a case, its file or a problem is solved first, by ``method``. ``w``: a number,
    or text with a unit, "40 mJ/m^2"; ``slopes``: "auto", "exact", "integral", "loocv", "gcv" or, with S of the cubic
    spline kept, "loocv-kept" and "gcv-kept"; ``modulus_factor``: all moduli times this. ``stress`` [Pa] or ``length``
    [m]: adhesion of finite range by its tension or its range, else what the case says.
    """
    solution = _solution(solved, method)
    ranged = _range(solution, stress, length)
    return analyse(solution, [_number("w", w, "work")], slopes, modulus_factor, ranged)[0]


@one_thread()
def cycle(
    solved: Body, w: Number, *, program: Program | None = None, w_approach: Number | None = None,
    to_load: Number | None = None, to_depth: Number | None = None, stiffness: Number = DISPLACEMENT_CONTROL,
    slopes: str = "auto", modulus_factor: float = 1.0, stress: Number | None = None, length: Number | None = None,
    rest_load: Number | None = None, rest_depth: Number | None = None,
) -> Cycled | CycledByProgram | CycledInLimits:  # fmt: skip
    """What a device records that presses the bodies together and pulls them apart, however slowly.

    ``w`` on retraction [J/m^2], not smaller than ``w_approach`` (default: ``w``). The device of ``stiffness`` [N/m] (0:
    load control, infinite, the default: a rigid one) turns at ``to_load`` or ``to_depth``, default: the end of the
    series; or it does what a ``program`` says, with turns anywhere. ``stress`` [Pa] or ``length`` [m]: adhesion of
    finite range, else what the case says. A specimen that relaxes is traced after each history that is known: very fast
    and very slow cycles, and at rest under ``rest_load`` or at ``rest_depth`` (default: at the turn, else at P = 0),
    then pulled at once.
    """
    from .resolve.histories import curves_from_rest

    solution, k = _solution(solved, None), _number("stiffness", stiffness, "stiffness")
    works = (_number("w", w if w_approach is None else w_approach, "work"), _number("w", w, "work"))
    ranged = _range(solution, stress, length)
    turn = _maybe("to_load", to_load, "load"), _maybe("to_depth", to_depth, "length")

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

    rest = _rest(rest_load, rest_depth)
    return _in_limits(solution, cycled, rest, *turn, program is None and not ranged)


def _in_limits(
    solution: Solution, cycled: Callable[[LoadingHistory | None], AnyResult], rest: Rest | None = None,
    load: float | None = None, depth: float | None = None, rests: bool = False,
) -> AnyResult | CycledInLimits:  # fmt: skip
    """What was ``cycled`` on the moduli as they are; of a specimen that relaxes after each history that is known."""
    if solution.problem.specimen.relaxation is None:
        return cycled(None)
    known = traced_histories(solution, rest, load, depth, rests)
    return CycledInLimits.of(solution.record.path, known, cycled)


def _rest(load: Number | None, depth: Number | None) -> Rest | None:
    """Where a viscoelastic specimen rests before it is pulled, in numbers or text."""
    from .resolve.histories import rest_of

    return rest_of(_maybe("rest_load", load, "load"), _maybe("rest_depth", depth, "length"))


@one_thread()
def cycle_at_speed(
    solved: Body, w: Number, law: AnyLaw, speed: Number | None = None, *,
    program: Program | None = None, w_approach: Number | None = None, law_approach: AnyLaw | None = None,
    speed_approach: Number | None = None, to_load: Number | None = None, to_depth: Number | None = None,
    hold: Number = 0.0, stiffness: Number = DISPLACEMENT_CONTROL, slopes: str = "auto", stress: Number | None = None,
) -> CycledAtSpeed | CycledInLimits:  # fmt: skip
    """What a device records over time while the work of adhesion depends on the speed of the contact's edge.

    ``w`` at rest on retraction [J/m^2] and its ``law``: PowerRate(v0=1e-6, n=0.6), LogRate, or their keys as of ``jkr
    cycle --rate``, {"v0": "1 um/s", "n": 0.6}. The device presses at ``speed_approach`` (default: ``speed``) to
    ``to_load`` or ``to_depth`` (default: the end of the series), waits for the time ``hold`` and goes back at
    ``speed``; or it does what a ``program`` says. Its speeds are in m/s, under load control in N/s. ``w_approach``:
    default ``w``; ``law_approach``: else an advancing edge follows at once. ``stiffness`` [N/m]: 0 is load control,
    infinite (default) a rigid device; ``stress`` [Pa] in the zone at the edge. Numbers are SI, text carries its unit.

    The result's ``pull_off``, ``jumps``, ``lost``, ``energy_lost`` and ``error`` tell what happened, ``table(points)``
    gives its columns. A specimen that relaxes is traced for very fast and very slow cycles. Raises InputError where the
    contact leaves the series.
    """
    from .adhesion.rate import RateContact

    w0, k = _number("w", w, "work"), _number("stiffness", stiffness, "stiffness")
    w_a = w0 if w_approach is None else _number("w_approach", w_approach, "work")
    inwards = None if law_approach is None else _law(law_approach)
    solution = _solution(solved, None)

    def cycled(history: LoadingHistory | None) -> CycledAtSpeed:
        share, words = (1.0, "") if history is None else (history.moduli, history.words)
        result = with_solved_points(analyse(solution, [w0], slopes, share)[0], k)
        contact = RateContact(result.jkr.nonadhesive, _law(law), w0, w_a, k, inwards)
        driven = _driven("cycle_at_speed", contact, program, speed, speed_approach, to_load, to_depth, hold)
        zone_stress = _maybe("stress", stress, "modulus")
        return CycledAtSpeed.of(contact, driven, result, stress=zone_stress, history=words)

    return _in_limits(solution, cycled)


@one_thread()
def cycle_relaxing(
    solved: Body, relaxation: Relaxation | None = None, speed: Number | None = None, *, w: Number = 0.0,
    stress: Number | None = None, length: Number | None = None, rest_load: Number | None = None,
    rest_depth: Number | None = None, program: Program | None = None, speed_approach: Number | None = None,
    to_load: Number | None = None, to_depth: Number | None = None, hold: Number = 0.0,
    stiffness: Number = DISPLACEMENT_CONTROL, slopes: str = "auto", compare_rate: bool = False,
) -> CycledRelaxing | CycledAdhering:  # fmt: skip
    """What a device records over time while the moduli of the specimen relax.

    ``relaxation``: StandardSolid(ratio=0.25, time=1.0), PowerRelaxation (without adhesion), Prony; default: that of the
    specimen. The device presses, waits and goes back as in ``cycle_at_speed``, or does what a ``program`` says. With a
    work of adhesion ``w`` [J/m^2] the surfaces attract each other by a cohesive ``stress`` [Pa], or up to a ``length``
    [m], default: what the case says. With ``rest_load`` or ``rest_depth`` the contact is at rest there, and is pulled
    at ``speed``. ``compare_rate``: what a law w(v) of the same material says, as if the bulk were relaxed, is ``rate``.

    The result's ``peak``, ``corners``, ``turn``, ``lost`` and ``error`` tell what happened, with adhesion ``pull_off``,
    ``jumps`` and ``limits``, too; ``table(points)`` gives its columns. Raises InputError where the contact leaves the
    series, or, without adhesion, is loaded again onto its dent.
    """
    from .adhesion.relaxation import RelaxingContact
    from .adhesion.relaxing_adhesion import RelaxingAdhesion
    from .resolve.histories import pull_off_in_limits

    solution, k, work = _solution(solved, None), _number("stiffness", stiffness, "stiffness"), _number("w", w, "work")
    law, rest = relaxation or solution.problem.specimen.relaxation, _rest(rest_load, rest_depth)
    if law is None:
        raise InputError(
            "cycle_relaxing: the specimen has no relaxation: give one, StandardSolid(ratio=0.25, time=1.0)"
        )
    relaxing = replace(solution.problem, specimen=replace(solution.problem.specimen, relaxation=law))  # may refuse
    solution, ranged = replace(solution, problem=relaxing), _range(solution, stress, length)
    does = (program, speed, speed_approach, to_load, to_depth, hold)
    if work == 0:
        if rest is not None:
            raise InputError("cycle_relaxing: rest_load and rest_depth need adhesion: give w")
        free = RelaxingContact(nonadhesive(solution, slopes), law, k)
        return CycledRelaxing.of(free, _driven("cycle_relaxing", free, *does), solution.record.path)
    if not ranged:
        raise InputError("cycle_relaxing: adhesion is followed over time by a cohesive stress: give stress or length")
    contact = RelaxingAdhesion.of(solution, ranged.law(work), law, k)
    turn = _maybe("to_load", to_load, "load"), _maybe("to_depth", to_depth, "length")
    at_rest = [one for one in traced_histories(solution, rest, *turn) if one.rest is not None]
    limits = pull_off_in_limits(solution, work, ranged, next(iter(at_rest), None), slopes)
    if rest is None:
        driven = _driven("cycle_relaxing", contact, *does)
    elif speed is None:
        raise InputError("cycle_relaxing: from rest it is pulled at a speed: give it")
    else:
        contact = replace(contact, rests=True)
        driven = Program.on(contact.pulled_from(rest), -_number("speed", speed, "load rate" if k == 0 else "speed"))
    return followed_with_limits(solution, contact, driven, limits, slopes, compare_rate=compare_rate)


def _driven(
    verb: str, contact: Turning, program: Program | None, speed: Number | None,
    speed_approach: Number | None, to_load: Number | None, to_depth: Number | None, hold: Number,
) -> Program:  # fmt: skip
    """The ``program``, or there and back at a speed."""
    from .adhesion.device_path import Course

    if (speed is None) == (program is None):
        raise InputError(f"{verb}: give either the speed of the instrument or its program")
    if speed is None:
        assert program is not None
        return program
    turn = _maybe("to_load", to_load, "load"), _maybe("to_depth", to_depth, "length")
    return Course(speed, speed_approach, *turn, hold).program(contact)


def _range(solution: Solution, stress: Number | None, length: Number | None) -> RangeRequest:
    """Adhesion of finite range by its tension or its length, in numbers or text."""
    return RangeRequest.of(solution.record, _maybe("stress", stress, "modulus"), _maybe("length", length, "length"))


def _law(law: AnyLaw) -> RateLaw:
    from .adhesion.rate import rate_law_of

    return rate_law_of(law, "law") if isinstance(law, Mapping) else law


def _solution(solved: Body, method: str | Method | None) -> Solution:
    """The series of what is solved, or to be solved."""
    if isinstance(solved, Case | Problem) or (not isinstance(solved, Solution) and Path(solved).suffix == ".toml"):
        solved = solve(solved, method)
    return solved if isinstance(solved, Solution) else read_solution(solved)


def _maybe(name: str, value: Number | None, dimension: str) -> float | None:
    """The same where it is given."""
    return None if value is None else _number(name, value, dimension)


def _number(name: str, value: Number, dimension: str) -> float:
    """A number in SI, or text with its unit."""
    try:
        return parse(value, dimension) if isinstance(value, str) else float(value)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def _texts(known: Known) -> list[tuple[str, str]]:
    """Names and values as a user types them; a number is in SI, of all its digits."""
    return [(name, value if isinstance(value, str) else repr(float(value))) for name, value in (known or {}).items()]


def identify(
    body: Body, measured: OneCurve | DataFrame | Mapping[str, Any] | None = None, free: Iterable[str] = (),
    fix: Known = None, slopes: str = "auto", *, reading: Reading | None = None,
    a: Any = None, delta: Any = None, P: Any = None, t: Any = None, **options: Any,
) -> Fit:  # fmt: skip
    """E*, w and the zero points that bring the adhesive curve of ``body`` nearest to one ``measured`` curve: of a file,
    a data frame with columns named as in a table ("delta_um", "P (nN)"), or arrays of ``a, delta, P, t`` [SI]. In these
    ``reading``, Reading(units={"P": "nN"}), tells units, signs and the device.

    ``body``: a case or problem (solved to the radii that the data ask for), a solved series, or the file of either.
    ``free``: more parameters ("P0", "E:film"); ``fix``: known ones, {"w": "50 mJ/m^2", "E_star": 2e6}; ``options``: see
    jkrcli.fitting.Settings. Raises InputError where the data cannot be fitted.
    """
    arrays = {"a": a, "delta": delta, "P": P, "t": t}
    named = {name: values for name, values in arrays.items() if values is not None}
    if (measured is None) == (not named):
        raise InputError("identify: give either what was measured or arrays of a, delta, P, t")
    if reading is not None:  # a fit finds zero points itself, with the rest
        options = {"contact": reading.contact} | options
        reading = replace(reading, contact="as-is")
    curve = _curve_of(named if measured is None else measured, reading)
    source = body_of(body, slopes)
    result = one_thread()(procedure.fit)(source, curve, settings_of(source, free, _texts(fix), **options))
    return replace(result, body=_named(body, source))


fit = identify  # the verb's name


def identify_joint(
    body: Body, measured: Sequence[OneCurve], shared: Iterable[str] = ("E_star", "w"), own: Iterable[str] = (),
    tip_radii: Sequence[Number] = (), free: Iterable[str] = (), fix: Known = None, slopes: str = "auto", **options: Any,
) -> JointFit:  # fmt: skip
    """E*, w or whatever else all records ``measured`` share, from all of them together; the rest is each record's own.

    ``tip_radii`` [m]: of each, or one of all (default: the body's); ``free``, ``fix``, ``options`` as of ``identify``.
    Raises InputError where a record cannot be used, or the records do not tell what they share.
    """
    source = body_of(body, slopes)
    curves = [_curve_of(item, None) for item in measured]
    settings = settings_of(source, free, _texts(fix), **options)
    bodies = with_radii(source, [_number("tip_radii", R, "length") for R in tip_radii], len(curves))
    result = one_thread()(joint_fit)(bodies, curves, settings, shared_of(shared, own, settings))
    return replace(result, body=_named(body, source))


def plan(body: Body, found: Fit, slopes: str = "auto") -> tuple[Further, ...]:
    """Which further measurement would narrow E* and w of a fit most: relative standard errors now and with the same
    measurement again, other largest loads, tip radii, thicknesses. InputError where the data do not tell both."""

    return one_thread()(further)(body_of(body, slopes), found)


def identify_law(
    body: Body, measured: Iterable[OneCurve], law: str = "power", free: Iterable[str] = (), fix: Known = None,
    slopes: str = "auto", **options: Any,
) -> RateFit:  # fmt: skip
    """w0, the parameters of a ``law`` over the edge's speed, E* and the zero point, from records with time together.

    ``measured``: curves of retractions at one or several speeds, or their files; ``free``: more parameters ("P0");
    ``fix``: known ones, {"n": "0.5"}; ``options``: start, level, confidence, segment as of ``jkr fit --law``. Raises
    InputError where the records cannot be fitted.
    """
    from .fitting.rate import rate_fit, rate_settings

    source = body_of(body, slopes)
    start = _texts(options.pop("start", None))
    settings = rate_settings(source, law, free, _texts(fix), start, **options)
    curves = [curve for each in measured for curve in ([each] if isinstance(each, Curve) else measured_curves(each))]
    return replace(one_thread()(rate_fit)(source, curves, settings), body=_named(body, source))


def identify_relaxation(
    body: Body, measured: OneCurve, law: str = "sls", fix: Known = None, slopes: str = "auto", **options: Any,
) -> RelaxationFit:  # fmt: skip
    """The modulus, the parameters of a ``law`` of relaxation and the zero point, from a record with time.

    ``measured``: one curve of t, delta, P, or its file; ``fix``: known ones, {"ratio": "0.3"}; ``options``: level,
    confidence, terms as of ``jkr fit --relaxation``. Raises InputError where the record cannot be fitted.
    """
    from .fitting.relaxation import relaxation_fit, relaxation_settings

    source = body_of(body, slopes)
    curve = _curve_of(measured, None)
    result = one_thread()(relaxation_fit)(source, curve, relaxation_settings(law, _texts(fix), **options))
    return replace(result, body=_named(body, source))


def identify_tension(
    body: Body, measured: Sequence[OneCurve], tip_radii: Sequence[Number] = (), fix: Known = None,
    level: float = 0.95,
) -> TensionFit:  # fmt: skip
    """Surface tension, E*, w and the zero points from records by tips of one or more radii on the same body, together.

    ``measured``: curves or their files; ``tip_radii`` [m]: of each, or one of all (default: the body's); ``fix``: known
    values, {"w": "1 mJ/m^2"}. Raises InputError where a record cannot be used.
    """
    from .fitting.surface_tension import TENSION, known_values, radii_of, tension_fit

    source = body_of(body)
    problem = source.problem
    curves = [_curve_of(item, None) for item in measured]
    radii = radii_of(problem, [_number("tip_radii", R, "length") for R in tip_radii], len(curves))
    known = known_values(problem, [] if TENSION in (fix or {}) else [TENSION], _texts(fix))
    result = one_thread()(tension_fit)(problem, curves, radii, known, level)
    return replace(result, body=_named(body, source))


def _named(body: Any, source: FittedBody) -> str:
    """What was fitted in words: its file, or the body."""
    return str(body) if isinstance(body, str | Path) else source.problem.words


def _curve_of(measured: Any, reading: Reading | None) -> Curve:
    """One curve, of what may be a curve, a file, a data frame or arrays by name."""
    if isinstance(measured, Curve):
        return measured
    if not isinstance(measured, str | Path):
        names = {"a": "a (m)", "delta": "delta (m)", "P": "P (N)", "t": "t (s)"}  # SI where no unit is named
        units = () if reading is None else reading.units
        return from_columns({names.get(k, k) if k not in units else k: measured[k] for k in measured}, reading)
    curves = read_curves(Path(measured), reading)
    if len(curves) > 1:
        raise InputError(f"{measured}: holds {len(curves)} curves, one is wanted: give one of measured_curves(path)")
    return curves[0]


def measured_curves(path: str | Path, **reading: Any) -> list[Curve]:
    """The measured curves in a file; ``reading``: how to read it, see jkrcli.data.measured.Reading."""
    return read_curves(Path(path), Reading(**reading))


def check(case: Case | str | Path) -> Check:
    """Which method a case needs, what each would cost, and what to expect, as ``jkr check`` says it; nothing is
    solved."""
    loaded = load_case(case) if isinstance(case, str | Path) else case
    return one_thread()(Check.of)(Path(case) if isinstance(case, str | Path) else Path("case"), loaded)


def look(path: str | Path, tip: Indenter | None = None, **reading: Any) -> Look:
    """What a measured file holds, as ``jkr look`` says it: segments, base line, contact, jumps, adhesion; no body is
    needed. With a ``tip``, Sphere(5e-6), a rough modulus too. ``reading``: see jkrcli.data.measured.Reading."""
    return one_thread()(Look.at)(Path(path), Reading(**reading), tip)


@one_thread()
def profile(
    solved: Body, a: Number | None = None, load: Number | None = None, w: Number = 0.0, *,
    stress: Number | None = None, length: Number | None = None,
) -> Profile:  # fmt: skip
    """Pressure, displacement and gap around one contact, of radius ``a`` [m] or under a ``load`` [N], with the work of
    adhesion ``w`` [J/m^2] (default: none); ``stress`` and ``length`` as of ``transform``."""
    from .resolve.profile import profile_columns, radius_under

    if (a is None) == (load is None):
        raise InputError("profile: give exactly one of a and load")
    solution, work = _solution(solved, None), _number("w", w, "work")
    ranged = _range(solution, stress, length)
    if load is not None:
        radius = radius_under(solution, _number("load", load, "load"), work, ranged)
    else:
        assert a is not None
        radius = _number("a", a, "length")
    return Profile(solution.record.path, radius, work, profile_columns(solution, radius, work, ranged))


@one_thread()
def pull_off(
    solved: Body, w: Number | None = None, load: Number | None = None, stiffness: Sequence[Number] = (),
    slopes: str = "auto", modulus_factor: float = 1.0, *, stress: Number | None = None, length: Number | None = None,
    uncertain: Known = None, rest_load: Number | None = None, rest_depth: Number | None = None,
) -> PullOff | MeasuredPullOff | MeasuredByHistory:  # fmt: skip
    """Where contact is lost with the work of adhesion ``w`` [J/m^2] under load and displacement control or by devices
    of a ``stiffness`` [N/m]; or which w a measured pull-off ``load`` [N] means, its inputs ``uncertain``: {"R": "2%"}.

    A specimen that relaxes has several of both, by its history: very fast and very slow cycles, at rest under
    ``rest_load`` or at ``rest_depth`` (default: at P = 0) and then pulled at once, and the largest of any other.
    """
    from .fitting.pull_off_work import measured_work, works_by_history
    from .resolve.analysis import where_lost
    from .resolve.histories import lost_by_history

    if (w is None) == (load is None):
        raise InputError("pull_off: give exactly one of w and load")
    solution, devices = _solution(solved, None), [_number("stiffness", k, "stiffness") for k in stiffness]
    rest = _rest(rest_load, rest_depth)
    if load is not None:
        force, pairs = abs(_number("load", load, "load")), _texts(uncertain)
        under = (devices or [LOAD_CONTROL])[0]
        found = works_by_history(solution, force, under, rest, slopes, modulus_factor, pairs)
        if isinstance(found, list):
            return MeasuredByHistory.of(solution, force, under, found, slopes, modulus_factor)
        return MeasuredPullOff(measured_work(solution, force, under, slopes, modulus_factor, pairs))
    assert w is not None
    ranged = _range(solution, stress, length)
    curve, lost = where_lost(solution, [_number("w", w, "work")], devices, slopes, modulus_factor, ranged)[0]
    controls = devices or [LOAD_CONTROL, DISPLACEMENT_CONTROL]
    return PullOff(curve, lost, lost_by_history(curve, controls, rest, slopes))


@one_thread()
def work(
    solved: Body, measured: str | Path, slopes: str = "auto", modulus_factor: float = 1.0, *,
    reading: Reading | None = None, **options: Any,
) -> Work:  # fmt: skip
    """The work of adhesion along the curves of a ``measured`` file, as ``jkr work`` says it; ``options``: use ("a,P"),
    segment, noise {"P": 2e-9}, window."""
    from .base.executors import executor
    from .fitting.work_along_curve import along_file, evaluation_of

    solution, path, reading = _solution(solved, None), Path(measured), reading or Reading()
    unit = nonadhesive(solution, slopes)
    evaluation = evaluation_of(solution, unit, reading, modulus_factor, **options)
    with executor(1) as pool:
        return Work.of(path, *along_file(path, reading, evaluation, pool), solution, unit, modulus_factor)


def compare(
    first: Body, second: Body, rtol: float = 1e-3, columns: Iterable[str] = (), overlap: float = 0.9,
) -> Compared:  # fmt: skip
    """How far two results of the same problem lie apart: series ("P" and "a" at equal displacement, "S" and "dS" at
    equal radius), or the CSV files of curves; they ``agree`` where no column that counts (default: P, of curves all)
    differs by more than ``rtol``. Raises InputError where less than ``overlap`` of their range is common."""
    one, two = (Path(item) if isinstance(item, str | Path) else Path("solved") for item in (first, second))
    both = (first, second)
    return Compared.of((one, two), lambda: [_solution(item, None) for item in both], rtol, columns, overlap)


def study_map(name: str, **axes: Any) -> MapResult:
    """The map called ``name`` ("pull-off", "sticking", "transition", "adhesion", "rate") over its ``axes``, as of ``jkr
    study <name>-map``: study_map("pull-off", nu=[0.3], q=[0.1, 1]); its ``columns``, ``summary()`` and ``figure()``."""
    from .many.maps import map_of

    return one_thread()(map_of(name).over)(**axes)


def table(curve: Result) -> Mapping[str, Any]:
    """The columns of a result's CSV file: names with units, one value per contact radius of a curve."""
    return curve.columns


def to_pandas(curve: Result) -> DataFrame:
    """The columns as a data frame (needs the optional package pandas)."""
    return curve.to_pandas()


def plot(curve: Result, path: str | Path | None = None) -> Figure:
    """The picture of a result, of a curve load over displacement and contact radius over load; also written to ``path``
    (.png, .svg, .pdf) where given."""
    from .report import plots

    figure = curve.figure()
    if path is not None:
        plots.save(figure, [Path(path)])
    return figure


def summary(curve: Result) -> dict[str, Any]:
    """What the result's JSON file says."""
    return curve.summary()

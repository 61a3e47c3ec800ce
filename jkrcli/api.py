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

Bodies that relax, without adhesion:

>>> solid = jkr.StandardSolid(ratio=0.25, time=1.0)
>>> history = jkr.cycle_relaxing(solved, solid, speed="10 um/s", to_depth="1 um", hold="3 s")
>>> [f"{corner.P * 1e6:.3f} uN" for corner in history.corners], f"lost after {history.lost:.3f} s"
(['14.983 uN', '4.395 uN'], 'lost after 3.129 s')
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .adhesion import DISPLACEMENT_CONTROL, LOAD_CONTROL, RangeRequest
from .base import InputError, check_series_target, one_thread, parse
from .beside import analyse, nonadhesive, with_solved_points
from .bodies import Problem
from .case import Case, load_case, store
from .case import parse_case as _parse_case
from .case import solve as _solve
from .data import Curve, Reading, from_columns
from .data import read as read_curves
from .methods import Limits, Method
from .report import AnyResult, Result, as_result
from .series import Solution

if TYPE_CHECKING:
    from pandas import DataFrame

    from .adhesion import Program, RateContact, RateLaw, RelaxingContact
    from .bodies import Indenter, Relaxation
    from .identification.fit import Fit, FittedBody, Further
    from .many.study.maps import MapResult
    from .report import (
        Check,
        Compared,
        Cycled,
        CycledAtSpeed,
        CycledByProgram,
        CycledInLimits,
        CycledRelaxing,
        Fitted,
        JointFitted,
        LawFit,
        Look,
        MeasuredPullOff,
        Profile,
        PullOff,
        RelaxationFitted,
        TensionFitted,
        Transformed,
        Work,
    )
    from .report.plots import Figure

__all__ = [
    "check", "compare", "cycle", "cycle_at_speed", "cycle_relaxing", "fit", "identify", "identify_joint",
    "identify_law", "identify_relaxation", "identify_tension", "load_case", "look", "measured_curves", "parse_case",
    "plan", "plot", "profile", "pull_off", "read", "save", "solve", "study_map", "summary", "table", "to_pandas",
    "transform", "work",
]  # fmt: skip


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
    return store.read(path, with_pressure=True)


def save(solved: Solution, path: str | Path, force: bool = False) -> Path:
    """Write a series file, whole or not at all; a file that jkr did not write is replaced only with ``force``."""
    target = Path(path)
    check_series_target(target, force)
    store.write(target, solved, "import jkrcli")
    return target


@one_thread()
def transform(
    solved: Solution | Case | Problem | str | Path,
    w: float | str,
    slopes: str = "auto",
    modulus_factor: float = 1.0,
    method: str | Method | None = None,
    *,
    stress: float | str | None = None,
    length: float | str | None = None,
) -> Transformed:
    """The adhesive curve for the work of adhesion ``w`` [J/m^2], with pull-off, errors, validity and warnings.

    ``solved``: a solution or its file; a case, its file or a problem is solved first, by ``method``. ``w``: a number,
    or text with a unit, "40 mJ/m^2"; ``slopes``: "auto", "exact", "integral", "loocv" or "gcv"; ``modulus_factor``:
    all moduli times this. ``stress`` [Pa] or ``length`` [m]: adhesion of finite range by its tension or its range,
    else what the case says.
    """
    solution = _solution(solved, method)
    ranged = _range(solution, stress, length)
    from .report import Transformed

    return as_result(Transformed, analyse(solution, [_number("w", w, "work")], slopes, modulus_factor, ranged)[0])


@one_thread()
def cycle(
    solved: Solution | Case | Problem | str | Path,
    w: float | str,
    *,
    program: Program | None = None,
    w_approach: float | str | None = None,
    to_load: float | str | None = None,
    to_depth: float | str | None = None,
    stiffness: float | str = DISPLACEMENT_CONTROL,
    slopes: str = "auto",
    modulus_factor: float = 1.0,
    stress: float | str | None = None,
    length: float | str | None = None,
) -> Cycled | CycledByProgram | CycledInLimits:
    """What a device records that presses the bodies together and pulls them apart, however slowly.

    ``w`` on retraction [J/m^2], not smaller than ``w_approach`` (default: ``w``). The device of ``stiffness`` [N/m] (0:
    load control, infinite, the default: a rigid one) turns at ``to_load`` or ``to_depth``, default: the end of the
    series; or it does what a ``program`` says, with turns anywhere. ``stress`` [Pa] or ``length`` [m]: adhesion of
    finite range, else what the case says. A specimen that relaxes is traced in its limits, very fast and very slow.
    """
    from .report import Cycled, CycledByProgram

    solution, k = _solution(solved, None), _number("stiffness", stiffness, "stiffness")
    works = [_number("w", value, "work") for value in (w if w_approach is None else w_approach, w)]
    ranged = _range(solution, stress, length)
    turn = _maybe("to_load", to_load, "load"), _maybe("to_depth", to_depth, "length")

    def cycled(share: float) -> Cycled | CycledByProgram:
        pair = analyse(solution, works, slopes, modulus_factor * share, ranged)
        curves = [with_solved_points(curve, k) for curve in pair]
        return Cycled.of(curves, k, *turn) if program is None else CycledByProgram.of(curves, k, program)

    return _in_limits(solution, cycled)


def _in_limits(solution: Solution, cycled: Callable[[float], AnyResult]) -> AnyResult | CycledInLimits:
    """What was ``cycled`` on the moduli as they are; of a specimen that relaxes on those of both limits."""
    law = solution.problem.specimen.relaxation
    if law is None:
        return cycled(1.0)
    from .report import CycledInLimits

    return CycledInLimits.of(solution.record.path, law, cycled)


@one_thread()
def cycle_at_speed(
    solved: Solution | Case | Problem | str | Path,
    w: float | str,
    law: RateLaw | Mapping[str, Any],
    speed: float | str | None = None,
    *,
    program: Program | None = None,
    w_approach: float | str | None = None,
    law_approach: RateLaw | Mapping[str, Any] | None = None,
    speed_approach: float | str | None = None,
    to_load: float | str | None = None,
    to_depth: float | str | None = None,
    hold: float | str = 0.0,
    stiffness: float | str = DISPLACEMENT_CONTROL,
    slopes: str = "auto",
    stress: float | str | None = None,
) -> CycledAtSpeed | CycledInLimits:
    """What a device records over time while the work of adhesion depends on the speed of the contact's edge.

    ``w`` at rest on retraction [J/m^2] and its ``law``: PowerRate(v0=1e-6, n=0.6), LogRate, or their keys as of ``jkr
    cycle --rate``, {"v0": "1 um/s", "n": 0.6}. The device presses at ``speed_approach`` (default: ``speed``) to
    ``to_load`` or ``to_depth`` (default: the end of the series), waits for the time ``hold`` and goes back at
    ``speed``; or it does what a ``program`` says. Its speeds are in m/s, under load control in N/s. ``w_approach``:
    default ``w``; ``law_approach``: else an advancing edge follows at once. ``stiffness`` [N/m]: 0 is load control,
    infinite (default) a rigid device; ``stress`` [Pa] in the zone at the edge. Numbers are SI, text carries its unit.

    The result's ``pull_off``, ``jumps``, ``lost``, ``energy_lost`` and ``error`` tell what happened, ``table(points)``
    gives its columns. A specimen that relaxes is traced in its limits, very fast and very slow. Raises InputError where
    the contact leaves the series.
    """
    from .adhesion import RateContact
    from .report import CycledAtSpeed

    w0, k = _number("w", w, "work"), _number("stiffness", stiffness, "stiffness")
    w_a = w0 if w_approach is None else _number("w_approach", w_approach, "work")
    inwards = None if law_approach is None else _law(law_approach)
    solution = _solution(solved, None)

    def cycled(share: float) -> CycledAtSpeed:
        result = with_solved_points(analyse(solution, [w0], slopes, share)[0], k)
        contact = RateContact(result.jkr.nonadhesive, _law(law), w0, w_a, k, inwards)
        driven = _driven("cycle_at_speed", contact, program, speed, speed_approach, to_load, to_depth, hold)
        return CycledAtSpeed.of(contact, driven, result, stress=_maybe("stress", stress, "modulus"))

    return _in_limits(solution, cycled)


@one_thread()
def cycle_relaxing(
    solved: Solution | Case | Problem | str | Path,
    relaxation: Relaxation | None = None,
    speed: float | str | None = None,
    *,
    program: Program | None = None,
    speed_approach: float | str | None = None,
    to_load: float | str | None = None,
    to_depth: float | str | None = None,
    hold: float | str = 0.0,
    stiffness: float | str = DISPLACEMENT_CONTROL,
    slopes: str = "auto",
) -> CycledRelaxing:
    """What a device records over time while the moduli of the specimen relax, without adhesion.

    ``relaxation``: StandardSolid(ratio=0.25, time=1.0), PowerRelaxation, Prony; default: that of the specimen. The
    device presses, waits and goes back as in ``cycle_at_speed``, or does what a ``program`` says.

    The result's ``peak``, ``corners``, ``turn``, ``lost`` and ``error`` tell what happened, ``table(points)`` gives its
    columns. Raises InputError where the contact leaves the series, or is loaded again onto its dent.
    """
    from .adhesion import RelaxingContact
    from .report import CycledRelaxing

    solution, k = _solution(solved, None), _number("stiffness", stiffness, "stiffness")
    law = relaxation or solution.problem.specimen.relaxation
    if law is None:
        raise InputError(
            "cycle_relaxing: the specimen has no relaxation: give one, StandardSolid(ratio=0.25, time=1.0)"
        )
    relaxing = replace(solution.problem, specimen=replace(solution.problem.specimen, relaxation=law))  # may refuse
    contact = RelaxingContact(nonadhesive(replace(solution, problem=relaxing), slopes), law, k)
    driven = _driven("cycle_relaxing", contact, program, speed, speed_approach, to_load, to_depth, hold)
    return CycledRelaxing.of(contact, driven, solution.record.path)


def _driven(
    verb: str, contact: RateContact | RelaxingContact, program: Program | None, speed: float | str | None,
    speed_approach: float | str | None, to_load: float | str | None, to_depth: float | str | None, hold: float | str,
) -> Program:  # fmt: skip
    """The ``program``, or there and back at a speed."""
    from .adhesion import Course

    if (speed is None) == (program is None):
        raise InputError(f"{verb}: give either the speed of the device or its program")
    if speed is None:
        assert program is not None
        return program
    turn = _maybe("to_load", to_load, "load"), _maybe("to_depth", to_depth, "length")
    return Course(speed, speed_approach, *turn, hold).program(contact)


def _range(solution: Solution, stress: float | str | None, length: float | str | None) -> RangeRequest:
    """Adhesion of finite range by its tension or its length, in numbers or text."""
    return RangeRequest.of(solution.record, _maybe("stress", stress, "modulus"), _maybe("length", length, "length"))


def _law(law: RateLaw | Mapping[str, Any]) -> RateLaw:
    from .adhesion import rate_law_of

    return rate_law_of(law, "law") if isinstance(law, Mapping) else law


def _solution(solved: Solution | Case | Problem | str | Path, method: str | Method | None) -> Solution:
    """The series of what is solved, or to be solved."""
    if isinstance(solved, Case | Problem) or (not isinstance(solved, Solution) and Path(solved).suffix == ".toml"):
        solved = solve(solved, method)
    return solved if isinstance(solved, Solution) else store.read(solved)


def _maybe(name: str, value: float | str | None, dimension: str) -> float | None:
    """The same where it is given."""
    return None if value is None else _number(name, value, dimension)


def _number(name: str, value: float | str, dimension: str) -> float:
    """A number in SI, or text with its unit."""
    try:
        return parse(value, dimension) if isinstance(value, str) else float(value)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def identify(
    body: Case | Problem | Solution | str | Path,
    measured: Curve | DataFrame | Mapping[str, Any] | str | Path | None = None,
    free: Iterable[str] = (),
    fix: Mapping[str, str] | None = None,
    slopes: str = "auto",
    *,
    reading: Reading | None = None,
    a: Any = None,
    delta: Any = None,
    P: Any = None,
    t: Any = None,
    **options: Any,
) -> Fitted:
    """E*, w and the zero points that bring the adhesive curve of ``body`` nearest to one ``measured`` curve: of a file,
    a data frame with columns named as in a table ("delta_um", "P (nN)"), or arrays of ``a, delta, P, t`` [SI]. In these
    ``reading``, Reading(units={"P": "nN"}), tells units, signs and the device.

    ``body``: a case or problem (solved to the radii that the data ask for), a solved series, or the file of either.
    ``free``: more parameters ("P0", "E:film"); ``fix``: known ones, {"w": "50 mJ/m^2"}; ``options``: see
    jkrcli.identification.fit.Settings. Raises InputError where the data cannot be fitted.
    """
    from .identification.fit import body_of, fit, settings_of
    from .report import Fitted

    arrays = {"a": a, "delta": delta, "P": P, "t": t}
    named = {name: values for name, values in arrays.items() if values is not None}
    if (measured is None) == (not named):
        raise InputError("identify: give either what was measured or arrays of a, delta, P, t")
    if reading is not None:  # a fit finds zero points itself, with the rest
        options = {"contact": reading.contact} | options
        reading = replace(reading, contact="as-is")
    curve = _curve_of(named if measured is None else measured, reading)
    source = body_of(body, slopes)
    result = one_thread()(fit)(source, curve, settings_of(source, free, (fix or {}).items(), **options))
    return as_result(Fitted, result, body=_named(body, source))


fit = identify  # the verb's name


def identify_joint(
    body: Case | Problem | Solution | str | Path,
    measured: Sequence[Curve | str | Path],
    shared: Iterable[str] = ("E_star", "w"),
    own: Iterable[str] = (),
    tip_radii: Sequence[float | str] = (),
    free: Iterable[str] = (),
    fix: Mapping[str, str] | None = None,
    slopes: str = "auto",
    **options: Any,
) -> JointFitted:
    """E*, w or whatever else all records ``measured`` share, from all of them together; the rest is each record's own.

    ``tip_radii`` [m]: of each, or one of all (default: the body's); ``free``, ``fix``, ``options`` as of ``identify``.
    Raises InputError where a record cannot be used, or the records do not tell what they share.
    """
    from .identification.fit import body_of, joint_fit, settings_of, shared_of, with_radii
    from .report import JointFitted

    source = body_of(body, slopes)
    curves = [_curve_of(item, None) for item in measured]
    settings = settings_of(source, free, (fix or {}).items(), **options)
    bodies = with_radii(source, [_number("tip_radii", R, "length") for R in tip_radii], len(curves))
    result = one_thread()(joint_fit)(bodies, curves, settings, shared_of(shared, own, settings))
    return as_result(JointFitted, result, body=_named(body, source), level=settings.level)


def plan(body: Case | Problem | Solution | str | Path, found: Fit, slopes: str = "auto") -> tuple[Further, ...]:
    """Which further measurement would narrow E* and w of a fit most: relative standard errors now and with the same
    measurement again, other largest loads, tip radii, thicknesses. InputError where the data do not tell both."""
    from .identification.fit import body_of, further

    return one_thread()(further)(body_of(body, slopes), found)


def identify_law(
    body: Case | Problem | Solution | str | Path,
    measured: Iterable[Curve | str | Path],
    law: str = "power",
    free: Iterable[str] = (),
    fix: Mapping[str, str] | None = None,
    slopes: str = "auto",
    **options: Any,
) -> LawFit:
    """w0, the parameters of a ``law`` over the edge's speed, E* and the zero point, from records with time together.

    ``measured``: curves of retractions at one or several speeds, or their files; ``free``: more parameters ("P0");
    ``fix``: known ones, {"n": "0.5"}; ``options``: start, level, confidence, segment as of ``jkr fit --law``. Raises
    InputError where the records cannot be fitted.
    """
    from .identification.fit import body_of
    from .identification.rate.fitting import rate_fit, rate_settings
    from .report import LawFit

    source = body_of(body, slopes)
    start = options.pop("start", {}).items()
    settings = rate_settings(source, law, free, (fix or {}).items(), start, **options)
    curves = [curve for each in measured for curve in ([each] if isinstance(each, Curve) else measured_curves(each))]
    return as_result(LawFit, one_thread()(rate_fit)(source, curves, settings), body=_named(body, source))


def identify_relaxation(
    body: Case | Problem | Solution | str | Path,
    measured: Curve | str | Path,
    law: str = "sls",
    fix: Mapping[str, str] | None = None,
    slopes: str = "auto",
    **options: Any,
) -> RelaxationFitted:
    """The modulus, the parameters of a ``law`` of relaxation and the zero point, from a record with time.

    ``measured``: one curve of t, delta, P, or its file; ``fix``: known ones, {"ratio": "0.3"}; ``options``: level,
    confidence, terms as of ``jkr fit --relaxation``. Raises InputError where the record cannot be fitted.
    """
    from .identification.fit import body_of
    from .identification.relaxation import relaxation_fit, relaxation_settings
    from .report import RelaxationFitted

    source = body_of(body, slopes)
    curve = _curve_of(measured, None)
    result = one_thread()(relaxation_fit)(source, curve, relaxation_settings(law, (fix or {}).items(), **options))
    return as_result(RelaxationFitted, result, body=_named(body, source))


def identify_tension(
    body: Case | Problem | Solution | str | Path,
    measured: Sequence[Curve | str | Path],
    tip_radii: Sequence[float | str] = (),
    fix: Mapping[str, str] | None = None,
    level: float = 0.95,
) -> TensionFitted:
    """Surface tension, E*, w and the zero points from records by tips of one or more radii on the same body, together.

    ``measured``: curves or their files; ``tip_radii`` [m]: of each, or one of all (default: the body's); ``fix``: known
    values, {"w": "1 mJ/m^2"}. Raises InputError where a record cannot be used.
    """
    from .identification.fit import body_of
    from .identification.tension import TENSION, known_values, radii_of, tension_fit
    from .report import TensionFitted

    source = body_of(body)
    problem = source.problem
    curves = [_curve_of(item, None) for item in measured]
    radii = radii_of(problem, [_number("tip_radii", R, "length") for R in tip_radii], len(curves))
    known = known_values(problem, [] if TENSION in (fix or {}) else [TENSION], (fix or {}).items())
    result = one_thread()(tension_fit)(problem, curves, radii, known, level)
    return as_result(TensionFitted, result, body=_named(body, source), level=level)


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
    from .report import Check

    loaded = load_case(case) if isinstance(case, str | Path) else case
    return one_thread()(Check.of)(Path(case) if isinstance(case, str | Path) else Path("case"), loaded)


def look(path: str | Path, tip: Indenter | None = None, **reading: Any) -> Look:
    """What a measured file holds, as ``jkr look`` says it: segments, base line, contact, jumps, adhesion; no body is
    needed. With a ``tip``, Sphere(5e-6), a rough modulus too. ``reading``: see jkrcli.data.measured.Reading."""
    from .report import Look

    return one_thread()(Look.at)(Path(path), Reading(**reading), tip)


@one_thread()
def profile(
    solved: Solution | Case | Problem | str | Path,
    a: float | str | None = None,
    load: float | str | None = None,
    w: float | str = 0.0,
    *,
    stress: float | str | None = None,
    length: float | str | None = None,
) -> Profile:
    """Pressure, displacement and gap around one contact, of radius ``a`` [m] or under a ``load`` [N], with the work of
    adhesion ``w`` [J/m^2] (default: none); ``stress`` and ``length`` as of ``transform``."""
    from .beside import profile_columns, radius_under
    from .report import Profile

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
    solved: Solution | Case | Problem | str | Path,
    w: float | str | None = None,
    load: float | str | None = None,
    stiffness: Sequence[float | str] = (),
    slopes: str = "auto",
    modulus_factor: float = 1.0,
    *,
    stress: float | str | None = None,
    length: float | str | None = None,
    uncertain: Mapping[str, str] | None = None,
) -> PullOff | MeasuredPullOff:
    """Where contact is lost with the work of adhesion ``w`` [J/m^2] under load and displacement control or by devices
    of a ``stiffness`` [N/m]; or which w a measured pull-off ``load`` [N] means, its inputs
    ``uncertain``: {"R": "2%"}."""
    from .beside import where_lost
    from .identification.work_of_adhesion import measured_work
    from .report import MeasuredPullOff, PullOff

    if (w is None) == (load is None):
        raise InputError("pull_off: give exactly one of w and load")
    solution, devices = _solution(solved, None), [_number("stiffness", k, "stiffness") for k in stiffness]
    if load is not None:
        force, pairs = abs(_number("load", load, "load")), (uncertain or {}).items()
        under = (devices or [LOAD_CONTROL])[0]
        return MeasuredPullOff(measured_work(solution, force, under, slopes, modulus_factor, pairs))
    assert w is not None
    ranged = _range(solution, stress, length)
    return PullOff(*where_lost(solution, [_number("w", w, "work")], devices, slopes, modulus_factor, ranged)[0])


@one_thread()
def work(
    solved: Solution | Case | Problem | str | Path,
    measured: str | Path,
    slopes: str = "auto",
    modulus_factor: float = 1.0,
    *,
    reading: Reading | None = None,
    **options: Any,
) -> Work:
    """The work of adhesion along the curves of a ``measured`` file, as ``jkr work`` says it; ``options``: use ("a,P"),
    segment, noise {"P": 2e-9}, window."""
    from .base import executor
    from .identification.work import along_file, evaluation_of
    from .report import Work

    solution, path, reading = _solution(solved, None), Path(measured), reading or Reading()
    unit = nonadhesive(solution, slopes)
    evaluation = evaluation_of(solution, unit, reading, modulus_factor, **options)
    with executor(1) as pool:
        return Work.of(path, *along_file(path, reading, evaluation, pool), solution, unit, modulus_factor)


def compare(
    first: Solution | Case | Problem | str | Path,
    second: Solution | Case | Problem | str | Path,
    rtol: float = 1e-3,
    columns: Iterable[str] = (),
    overlap: float = 0.9,
) -> Compared:
    """How far two results of the same problem lie apart: series ("P" and "a" at equal displacement, "S" and "dS" at
    equal radius), or the CSV files of curves; they ``agree`` where no column that counts (default: P, of curves all)
    differs by more than ``rtol``. Raises InputError where less than ``overlap`` of their range is common."""
    from .report import Compared, of_curves, of_solutions

    one, two = (Path(item) if isinstance(item, str | Path) else Path("solved") for item in (first, second))
    files = one, two
    if one.suffix == ".csv":
        return Compared.of(files, of_curves(files), rtol, tuple(columns), overlap)
    differences = of_solutions(files, _solution(first, None), _solution(second, None))
    return Compared.of(files, differences, rtol, tuple(columns) or ("P",), overlap)


def study_map(name: str, **axes: Any) -> MapResult:
    """The map called ``name`` ("pull-off", "sticking", "transition", "adhesion", "rate") over its ``axes``, as of ``jkr
    study <name>-map``: study_map("pull-off", nu=[0.3], q=[0.1, 1]); its ``columns``, ``summary()`` and ``figure()``."""
    from .many.study.maps import map_of

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

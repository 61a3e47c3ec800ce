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
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from .adhesion.curve import DISPLACEMENT_CONTROL, LOAD_CONTROL
from .adhesion.device_path import Course, Program
from .adhesion.finite_range import RangeRequest, without_range
from .adhesion.roughness import Roughness, works_on
from .adhesion.rules import RULES
from .base import units
from .base.arguments import OneOf, checked, exactly_one
from .base.errors import InputError, JkrError, Refusal, Unknown
from .base.files import check_series_target
from .base.process import one_thread
from .base.registry import Result
from .base.units import texts_of
from .base.wings import absent, is_offered, offered
from .bodies.indenters import FlatPunch, Paraboloid, PowerLaw, Pyramid, RoundedCone, RoundedFlat, Sphere, TableProfile
from .bodies.problem import (
    Coated,
    Elastic,
    Exponential,
    Graded,
    GradedTransverselyIsotropic,
    HalfSpace,
    KelvinVoigtSolid,
    Layer,
    Linear,
    Loading,
    Power,
    PowerRelaxation,
    Problem,
    Prony,
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
from .methods.closed_form import ClosedForm
from .methods.layered.solver import Layered
from .methods.protocol import METHODS, Limits, Method
from .report.check import Check
from .report.forward import (
    AskedCycle,
    Compared,
    Cycled,
    CycledByProgram,
    Profile,
    PullOff,
    by_history,
)
from .report.result import PICTURES, Figure
from .resolve.analysis import Analysis, analyse, profile_columns, radius_under, where_lost
from .series import Solution

__all__ = [
    "ClosedForm", "Coated", "Elastic", "Exponential", "FlatPunch", "Graded", "GradedTransverselyIsotropic",
    "HalfSpace", "InputError", "JkrError", "KelvinVoigtSolid", "Layer", "Layered", "Limits", "Linear",
    "Loading", "Paraboloid", "Power", "PowerLaw", "PowerRelaxation", "Problem", "Program", "Prony", "Pyramid",
    "Refusal", "Rigid", "Roughness", "RoundedCone", "RoundedFlat", "Specimen", "Sphere", "StandardSolid",
    "TableProfile", "Tabulated", "TransverselyIsotropic", "Unknown", "check", "compare", "cycle", "load_case",
    "parse_case", "plot", "profile", "pull_off", "read", "save", "solve", "summary", "table", "to_pandas",
    "transform",
]  # fmt: skip
if TYPE_CHECKING:
    from pandas import DataFrame

AnyPath: TypeAlias = str | Path
Body: TypeAlias = Case | Problem | Solution | AnyPath  # to be solved, or solved; or the file of either
Known: TypeAlias = Mapping[str, str | float] | None  # values of what is not fitted, standard deviations of inputs
AnyMethod: TypeAlias = Annotated[str, OneOf(METHODS, ("auto",), "method")] | Method | None
SlopesRule: TypeAlias = Annotated[str, OneOf(RULES, ("auto",))]

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
    stress: Stress | None = None, length: PositiveLength | None = None, roughness: Roughness | None = None,
) -> Analysis:  # fmt: skip
    """Transform a nonadhesive solution to the adhesive curve for one work of adhesion.

    Parameters
    ----------
    solved : Solution, Case, Problem or path
        A solution or its file; a case, its file or a problem is solved first, by ``method``.
    w : float or str
        Work of adhesion [J/m^2], or text with a unit, "40 mJ/m^2".
    slopes : str, optional
        How dS/da is found: "auto", "exact", "integral", "loocv", "gcv", "loocv-smoothed" or, with S of the cubic spline
        kept, "loocv-kept" and "gcv-kept".
    modulus_factor : float, optional
        All moduli times this; nothing is solved again.
    method : str or Method, optional
        Of what is not solved yet.
    stress : float or str, optional
        Cohesive stress [Pa] of adhesion of finite range (Maugis-Dugdale); default: what the case says.
    length : float or str, optional
        Range [m] of such adhesion, instead of ``stress``.
    roughness : Roughness, optional
        Of the surfaces: ``w`` is that between smooth ones, less the elastic energy of full contact.

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
    solution = solution_of(solved, method)
    ranged = range_of(solution, stress, length)
    works, rough = works_on(roughness, solution.problem.scaled(modulus_factor), [w], bool(ranged))
    return replace(analyse(solution, works, slopes, modulus_factor, ranged)[0], rough=rough[0])


@checked
@one_thread()
def cycle(
    solved: Body, w: WorkOfAdhesion, *, program: Program | None = None, w_approach: WorkOfAdhesion | None = None,
    to_load: Force | None = None, to_depth: Length | None = None, stiffness: Stiffness = DISPLACEMENT_CONTROL,
    slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0, stress: Stress | None = None,
    length: PositiveLength | None = None,
    rest_load: Force | None = None, rest_depth: Length | None = None,
) -> Cycled | CycledByProgram | Result:  # fmt: skip
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

    solution = solution_of(solved, None)
    Course(to_load=to_load, to_depth=to_depth, tabulated=program).refuse_idle()
    works = (w if w_approach is None else w_approach, w)
    ranged = range_of(solution, stress, length)
    ranged.refuse_two(*works)
    asked = AskedCycle(solution, works, stiffness, ranged, slopes, modulus_factor, to_load, to_depth, program)
    relaxing = by_history(solution, rest_load, rest_depth)
    return asked.quasi_static() if relaxing is None else relaxing.cycle(asked)


def range_of(solution: Solution, stress: Stress | None, length: PositiveLength | None) -> RangeRequest:
    """Adhesion of finite range by its tension or its length, in numbers or text."""
    return RangeRequest.of(solution.record, stress, length)


def solution_of(solved: Body, method: str | Method | None) -> Solution:
    """The series of what is solved, or to be solved."""
    if isinstance(solved, Case | Problem) or (not isinstance(solved, Solution) and Path(solved).suffix == ".toml"):
        solved = solve(solved, method)
    elif method is not None:
        raise InputError("method: is of what is not solved yet, and this is a solution: leave it out")
    return solved if isinstance(solved, Solution) else read_solution(solved)


@checked
def check(case: Case | AnyPath, roughness: Roughness | None = None) -> Check:
    """Tell which method a case needs, what each costs and what to expect; nothing is solved at full accuracy.

    Parameters
    ----------
    case : Case or path
        The case, or its file.
    roughness : Roughness, optional
        As of `transform`.

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
    path = Path(case) if isinstance(case, str | Path) else Path("case")
    return one_thread()(Check.of)(path, loaded, roughness)


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
    exactly_one("profile", a=a, load=load)
    solution = solution_of(solved, None)
    ranged = range_of(solution, stress, length)
    radius: Any = a if load is None else radius_under(solution, load, w, ranged)
    return Profile(solution.record.path, radius, w, profile_columns(solution, radius, w, ranged))


@checked
@one_thread()
def pull_off(
    solved: Body, w: WorkOfAdhesion | None = None, load: Force | None = None, stiffness: Sequence[Stiffness] = (),
    slopes: SlopesRule = "auto", modulus_factor: Factor = 1.0, *, stress: Stress | None = None,
    length: PositiveLength | None = None,
    uncertain: Known = None, rest_load: Force | None = None, rest_depth: Length | None = None,
    roughness: Roughness | None = None,
) -> Result:  # fmt: skip
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
    roughness : Roughness, optional
        As of `transform`; with ``load`` the w between smooth surfaces, at most, is told too.

    Returns
    -------
    PullOff, MeasuredPullOff or MeasuredByHistory
        Under each control, of a viscoelastic specimen after each history.

    Raises
    ------
    InputError
        Where contact is not lost within the series, or the force is none of this body.
    """
    exactly_one("pull_off", w=w, load=load)
    if load is not None or uncertain:
        if not is_offered("work of one pull-off"):
            raise InputError(f"pull_off: load {absent('measured curves')}")
        offered("idle options of a measured pull-off")(load, uncertain or {}, stress, length)
    solution, devices = solution_of(solved, None), list(stiffness)
    relaxing = by_history(solution, rest_load, rest_depth)
    if load is not None:
        without_range(solution.record, "pull_off: load")
        if len(devices) > 1:
            raise InputError(f"stiffness: a measured load has one, got {len(devices)}")
        under, pairs = (devices or [LOAD_CONTROL])[0], texts_of(uncertain or {})
        how = slopes, modulus_factor, pairs, roughness
        return offered("work of one pull-off")(solution, relaxing, abs(load), under, *how)
    ranged = range_of(solution, stress, length)
    given: list[Any] = [w]
    works, rough = works_on(roughness, solution.problem.scaled(modulus_factor), given, bool(ranged))
    curve, lost = where_lost(solution, works, devices, slopes, modulus_factor, ranged)[0]
    curve = replace(curve, rough=rough[0])
    controls = devices or [LOAD_CONTROL, DISPLACEMENT_CONTROL]
    return PullOff(curve, lost) if relaxing is None else relaxing.pull_off(curve, lost, controls, slopes)


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
    return Compared.of((one, two), lambda: [solution_of(item, None) for item in both], rtol, columns, overlap)


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

"""What the Python interface offers of measured curves: reading, looking, fits, the work of adhesion along them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any, Protocol, TypeAlias, runtime_checkable

from ..adhesion.finite_range import without_range
from ..api import AnyPath, Body, Factor, Known, PositiveLength, SlopesRule, solution_of
from ..base import units
from ..base.arguments import check_names, checked
from ..base.errors import LEVEL, InputError
from ..base.executors import executor
from ..base.process import one_thread
from ..bodies.indenters import Indenter
from ..resolve.analysis import nonadhesive
from . import procedure
from .batch import header_errors
from .choices import Use
from .curve import Curve, Reading
from .files import from_columns
from .files import read as read_curves
from .forward_model import FittedBody, body_of
from .joint import JointFit, joint_fit, shared_of, with_radii
from .parameters import Level
from .procedure import further
from .report import Look, Work
from .result import Fit, Further
from .settings import EACH, OPTIONS_OF, SHARED, Noise, check_unused, settings_of
from .surface_tension import TENSION, TensionFit, known_values, radii_of, tension_fit
from .work import WORK_LEAST_WINDOW, along_file, evaluation_of

__all__ = [
    "Reading", "fit", "identify", "identify_joint", "identify_tension", "look", "measured_curves", "plan", "work",
]  # fmt: skip

OneCurve: TypeAlias = Curve | AnyPath  # or the file that holds it


@runtime_checkable
class Columns(Protocol):
    """Arrays by the names of columns: a data frame, or a mapping."""

    def keys(self) -> Iterable[str]: ...

    def __getitem__(self, name: str, /) -> Any: ...


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
        Fields of `jkrcli.measured.settings.Settings`: confidence, level, loss and others.

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
    check_options("identify", EACH, options)
    arrays = {"a": a, "delta": delta, "P": P, "t": t}
    named = {name: values for name, values in arrays.items() if values is not None}
    if (measured is None) == (not named):
        raise InputError("identify: give either what was measured or arrays of a, delta, P, t")
    if reading is not None:  # a fit finds zero points itself, with the rest
        options = {"contact": reading.contact} | options
        reading = replace(reading, contact="as-is")
    curve = curve_of(named if measured is None else measured, reading)
    source = body_of(body, slopes)
    settings = settings_of(source, free, fix or {}, **options)
    settings = replace(settings, uncertain={**header_errors([curve]), **settings.uncertain})
    result = one_thread()(procedure.fit)(source, curve, settings)
    return replace(result, body=body_words(body, source))


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
    check_options("identify_joint", SHARED, options, **given(slopes), tip_radius=tip_radii)
    source = body_of(body, slopes)
    curves = [curve_of(item, None) for item in measured]
    settings = settings_of(source, free, fix or {}, **options)
    bodies = with_radii(source, tip_radii, len(curves))
    result = one_thread()(joint_fit)(bodies, curves, settings, shared_of(shared, own, settings))
    return replace(result, body=body_words(body, source))


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
    curves = [curve_of(item, None) for item in measured]
    radii = radii_of(problem, tip_radii, len(curves))
    known = known_values(problem, [] if TENSION in (fix or {}) else [TENSION], fix or {})
    result = one_thread()(tension_fit)(problem, curves, radii, known, level)
    return replace(result, body=body_words(body, source))


def check_options(name: str, kind: str, options: Mapping[str, Any], **beside: Any) -> None:
    """InputError where one of the ``options`` of the function ``name`` is none, or without an effect on a ``kind`` of
    fit with what is given ``beside``."""
    check_unused(kind, {**options, **beside}, by=name)
    check_names(name, options, OPTIONS_OF[kind])


def given(slopes: str) -> dict[str, str]:
    """The rule for slopes where it is not the default."""
    return {} if slopes == "auto" else {"slopes": slopes}


def body_words(body: Any, source: FittedBody) -> str:
    """What was fitted in words: its file, or the body."""
    return str(body) if isinstance(body, str | Path) else source.problem.words


def curve_of(measured: Any, reading: Reading | None) -> Curve:
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
def look(path: AnyPath, tip: Indenter | None = None, rigid: bool = False, **reading: Any) -> Look:
    """Tell what a measured file holds: segments, base line, contact, jumps, adhesion force; no body is needed.

    Parameters
    ----------
    path : path
        The file.
    tip : indenter, optional
        ``Sphere(5e-6)``: with a rough modulus, too.
    rigid : bool, optional
        Whether the specimen is rigid: then ``rigid`` of the result is the sensitivity that follows.
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
    return one_thread()(Look.at)(Path(path), _reading("look", reading), tip, rigid)


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
    solution, path, reading = solution_of(solved, None), Path(measured), reading or Reading()
    unit = nonadhesive(solution, slopes)
    without_range(solution.record, "work")
    evaluation = evaluation_of(solution, unit, reading, modulus_factor, use, segment, noise, window)
    with executor(1) as pool:
        return Work.of(path, *along_file(path, reading, evaluation, pool), solution, unit, modulus_factor)

"""What the Python interface offers of measured curves: reading, looking, fits, the work of adhesion along them."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any, Protocol, TypeAlias, overload, runtime_checkable

from ..adhesion.finite_range import without_range
from ..api import AnyPath, Body, Factor, Known, PositiveLength, SlopesRule, solution_of
from ..base import units
from ..base.arguments import OneOf, check_names, checked
from ..base.errors import LEVEL, InputError
from ..base.executors import executor
from ..base.process import one_thread
from ..base.wings import absent, offered
from ..bodies.indenters import Indenter
from ..bodies.problem import RELAXATIONS
from ..resolve.analysis import nonadhesive
from . import procedure
from .batch import header_errors
from .choices import Use
from .curve import Curve, Reading
from .files import from_columns
from .files import read as read_curves
from .forward_model import FittedBody, body_of, refuse_full_end
from .joint import joint_fit, shared_of, with_radii
from .parameters import ALIAS, Answer, Level
from .procedure import further
from .report import Look, Work
from .result import Fit, Further
from .settings import EACH, LAW, OPTIONS_OF, RELAXATION, SHARED, USUALLY_FREE, Noise, check_unused, settings_of
from .surface_tension import TENSION, known_values, radii_of, tension_fit
from .work import WORK_LEAST_WINDOW, along_file, evaluation_of

__all__ = [
    "Reading", "fit", "identify", "identify_joint", "identify_tension", "look", "measured_curves", "plan", "work",
]  # fmt: skip

OneCurve: TypeAlias = Curve | AnyPath  # or the file that holds it
RelaxationName: TypeAlias = Annotated[str, OneOf(RELAXATIONS)]


@runtime_checkable
class Columns(Protocol):
    """Arrays by the names of columns: a data frame, or a mapping."""

    def keys(self) -> Iterable[str]: ...

    def __getitem__(self, name: str, /) -> Any: ...


@overload
def fit(
    body: Body, measured: OneCurve | Sequence[OneCurve], free: Iterable[str] = ..., fix: Known = ...,
    slopes: SlopesRule = ..., *, law: str, **others: Any,
) -> Answer: ...  # fmt: skip
@overload
def fit(
    body: Body, measured: OneCurve | Sequence[OneCurve], free: Iterable[str] = ..., fix: Known = ...,
    slopes: SlopesRule = ..., *, relaxation: str, **others: Any,
) -> Answer: ...  # fmt: skip
@overload
def fit(body: Body, measured: OneCurve | Columns | None = None, *more: Any, **others: Any) -> Fit: ...
@overload
def fit(body: Body, measured: Sequence[OneCurve], *more: Any, **others: Any) -> Answer: ...
@checked
def fit(
    body: Body, measured: OneCurve | Columns | Sequence[OneCurve] | None = None, free: Iterable[str] = (),
    fix: Known = None, slopes: SlopesRule = "auto", *, law: str | None = None,
    relaxation: RelaxationName | None = None, shared: Iterable[str] = (), own: Iterable[str] = (),
    tip_radii: Sequence[PositiveLength] = (), reading: Reading | None = None,
    a: Any = None, delta: Any = None, P: Any = None, t: Any = None, **options: Any,
) -> Answer:  # fmt: skip
    """Fit E*, w, contact point and force offset to a measured curve, or what several share, as ``jkr fit`` does.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        What was measured on: a case or problem (solved to the radii that the data need), a solution, or its file.
    measured : Curve, path, DataFrame or mapping, or a sequence of curves or paths, optional
        A file, or columns named as in a table ("delta_um", "P (nN)").
    free : iterable of str, optional
        More parameters: "P0", "E:film", "surface_tension" (of curves by tips of several radii).
    fix : mapping, optional
        Known ones, ``{"w": "50 mJ/m^2", "E_star": 2e6}``.
    slopes : str, optional
        As of `transform`.
    law : str, optional
        "power" or "log": of w over the speed of the contact line, from curves with time at one or several speeds.
    relaxation : str, optional
        "sls", "power" or "prony": of a viscoelastic specimen; with ``free=["w"]`` under adhesion.
    shared, own : iterable of str, optional
        Parameters that several curves have in common, ``["E_star", "w"]``, or each for itself.
    tip_radii : sequence of float or str, optional
        Radius [m] of each curve's tip, or one of all; default: the body's.
    reading : Reading, optional
        Units, signs and instrument of columns: ``Reading(units={"P": "nN"})``.
    a, delta, P, t : array, shape (n,), optional
        Instead of ``measured``: contact radius [m], displacement [m], load [N], time [s].
    **options
        Fields of `jkrcli.measured.settings.Settings`: confidence, level, loss and others; start, terms.

    Returns
    -------
    Fit
        ``value("E_star")``, ``estimate("w")`` with error and interval, ``verdict``, ``warnings``; ``figure()``,
        ``summary()``, ``print(fit)``. Of several curves, laws or surface tension a JointFit, RateFit, SharedSpeedsFit,
        RelaxationFit or TensionFit, with the same ``value`` and ``estimate``.

    Raises
    ------
    InputError
        Where the data cannot be fitted.
    """
    arrays = {"a": a, "delta": delta, "P": P, "t": t}
    named = {name: values for name, values in arrays.items() if values is not None}
    data = named if measured is None else measured
    several = data if isinstance(data, tuple) else (data,)
    usual = (*USUALLY_FREE, ALIAS, *(fix or {}))
    free = tuple(dict.fromkeys([*free, *(name for name in (*shared, *own) if name not in usual)]))
    kind = SHARED if shared or len(several) != 1 else EACH
    kind = TENSION if TENSION in {*free, *(fix or {})} else kind
    kind = RELAXATION if relaxation else LAW if law else kind
    beside = {"shared": shared, "own": own, "tip_radius": tip_radii, "slopes": slopes != "auto" and slopes,
              "law": relaxation and law, "relaxation": relaxation}  # fmt: skip
    beside = {name: value for name, value in beside.items() if value}
    check_options(kind, options, beside)
    if (measured is None) == (not named):
        raise InputError("fit: give either what was measured or arrays of a, delta, P, t")
    source = refuse_full_end(body_of(body, slopes))
    result: Answer
    if kind in (LAW, RELAXATION):
        if refused := absent("fit --law"):
            raise InputError(f"law: {refused}")
        options |= {"shared": shared, "own": own} if relaxation else {}
        curves = [each for item in several for each in curves_of(item, reading)]
        result = one_thread()(offered("fit of laws"))(source, curves, law, relaxation, free, fix or {}, **options)
        return replace(result, body=body_words(body, source))
    if reading is not None:  # a fit finds contact points itself, with the rest
        options = {"contact": reading.contact} | options
        reading = replace(reading, contact="as-is")
    curves = [curve_of(item, reading) for item in several]
    if not curves:
        raise InputError("fit: measured holds no curve")
    if kind == TENSION or source.problem.specimen.surface_tension > 0:
        check_options(TENSION, options, beside)
        radii = radii_of(source.problem, tip_radii, len(curves))
        known = known_values(source.problem, free, fix or {})
        result = one_thread()(tension_fit)(source.problem, curves, radii, known, **options)
        return replace(result, body=body_words(body, source))
    if kind == SHARED and not shared:
        raise InputError(f'fit: {len(curves)} curves: give what they share, shared=["E_star", "w"], or fit each alone')
    bodies = with_radii(source, tip_radii, len(curves))
    settings = settings_of(bodies[0], free, fix or {}, **options)
    if kind == SHARED:
        result = one_thread()(joint_fit)(bodies, curves, settings, shared_of(shared, own, settings))
    else:
        settings = replace(settings, uncertain={**header_errors(curves), **settings.uncertain})
        result = one_thread()(procedure.fit)(bodies[0], curves[0], settings)
    return replace(result, body=body_words(body, source))


def instead(name: str, call: str) -> None:
    """Warn that the public function ``name``, which a user called, is deprecated for the ``call`` of `fit`."""
    warnings.warn(f"{name} is deprecated: {call}", DeprecationWarning, stacklevel=4)


@checked
def identify(body: Body, measured: OneCurve | Columns | None = None, *more: Any, **options: Any) -> Fit:
    """Deprecated: `fit`, which takes the same."""
    instead("identify", "call fit, which takes the same")
    return fit(body, measured, *more, **options)


@checked
def identify_joint(
    body: Body, measured: Sequence[OneCurve], shared: Iterable[str] = ("E_star", "w"), own: Iterable[str] = (),
    tip_radii: Sequence[PositiveLength] = (), free: Iterable[str] = (), fix: Known = None,
    slopes: SlopesRule = "auto", **options: Any,
) -> Answer:  # fmt: skip
    """Deprecated: `fit` with ``shared``."""
    instead("identify_joint", 'call fit with shared=["E_star", "w"]')
    return fit(body, measured, free, fix, slopes, shared=shared, own=own, tip_radii=tip_radii, **options)


@checked
def identify_tension(
    body: Body, measured: Sequence[OneCurve], tip_radii: Sequence[PositiveLength] = (), fix: Known = None,
    level: Level = LEVEL,
) -> Answer:  # fmt: skip
    """Deprecated: `fit` with ``free=["surface_tension"]``."""
    instead("identify_tension", 'call fit with free=["surface_tension"]')
    free = [] if TENSION in (fix or {}) else [TENSION]
    return fit(body, measured, free, fix, tip_radii=tip_radii, level=level)


@checked
def plan(body: Body, found: Fit, slopes: SlopesRule = "auto") -> tuple[Further, ...]:
    """Compare what further measurements would leave of the errors of E* and w.

    Parameters
    ----------
    body : Case, Problem, Solution or path
        What was fitted.
    found : Fit
        What `fit` gave.
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


def check_options(kind: str, options: Mapping[str, Any], beside: Mapping[str, Any]) -> None:
    """InputError where one of the ``options`` of `fit` is none, or without an effect on a ``kind`` of fit with what is
    given ``beside``."""
    check_unused(kind, {**options, **beside}, by="fit")
    check_names("fit", options, OPTIONS_OF[kind])


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


def curves_of(measured: Any, reading: Reading | None) -> list[Curve]:
    """One curve, or all of a file."""
    if isinstance(measured, str | Path):
        return read_curves(Path(measured), reading)
    return [curve_of(measured, reading)]


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

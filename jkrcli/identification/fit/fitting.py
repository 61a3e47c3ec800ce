"""Fits of measured curves: one curve, or many on one body, each on its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...adhesion import Equilibrium, large_strains, strain_words
from ...base import TOGETHER, InputError, JkrError, Pool, SolveError, Unknown, completed, executor, show
from ...bodies import Paraboloid, Sphere
from ...data import (
    APPROACH,
    AS_DEPTH,
    GAPS,
    NO_UNIT,
    NOT_SUBTRACTED,
    OVERRULED,
    RETRACT,
    SUBTRACTED_TWICE,
    Curve,
    ForceCurve,
    Pixel,
    examine,
    with_zero_points,
)
from ..answer import FittedValue
from ..parameters import Parameter
from .body import FittedBody, check_parameters
from .checks import warnings_of
from .confidence import confidence_of, jkr_beside
from .family import ADVANCING, RECEDING, RESTING, RestingMember
from .force_curve_fit import Neighbour
from .points import EDGES, Points, directed, points_of
from .record import beside, differ, fit_record, reduced
from .record_flags import RESTS
from .result import Fit
from .rivals import Rivals, missed_pull_off, rivals_of
from .search import Minimum, robust, search
from .settings import CALIBRATED, TENSION, Settings
from .statistics import covariance, structure
from .whole_record import beyond_the_record, whole_record

OWN = {"w": "w_approach"}  # names of an approach alone
OF_SHAPE = "the faces of the pyramid"
OF_STRAINS = "large strains"
NOTICED = 0.1  # choice: of the interval of w, the part by large strains from which on it is told
FLAT = 0.2  # theory: of R, the contact radius up to which sphere and paraboloid agree to 1 % in the load
SYMBOLS = {"E_star": "E*"}
WARNED = {  # flags of a curve that matter
    NOT_SUBTRACTED: "E* is that of contact and device in series: ",
    AS_DEPTH: "",
    SUBTRACTED_TWICE: "",
}


@dataclass(frozen=True, eq=False)
class Failure:
    """A curve that could not be fitted; ``lines``: why, one sentence each; ``flags``: what is wrong with the record, in
    a word or two each."""

    curve: Curve
    lines: tuple[str, ...]

    @property
    def flags(self) -> tuple[str, ...]:
        return tuple(flags_of(self.curve))

    @property
    def pixel(self) -> Pixel | None:
        return self.curve.pixel


def _examined(curve: Curve) -> ForceCurve | None:
    """The record taken apart; None where it is too short or no force curve."""
    try:
        return examine(curve)
    except InputError:
        return None


def flags_of(curve: Curve) -> Mapping[str, str]:
    """What is wrong with a record, in a word or two, and a sentence on each."""
    record = _examined(curve)
    return {} if record is None else record.flags


def parted(curve: Curve, settings: Settings) -> Curve:
    """The curve with approach and retraction separated by its motion, where it holds both, no column names them and
    one of them is requested, or needed because it is the record of a device."""
    needed = settings.segment in (APPROACH, RETRACT) or (settings.segment is None and curve.stiffness is not None)
    curve = directed(curve)
    record = _examined(curve) if needed and curve.segment is None else None
    if record is None or not {APPROACH, RETRACT} <= {segment.kind for segment in record.segments}:
        return curve
    words = np.full(len(curve), "", dtype="U8")
    for segment in record.segments:
        words[segment.rows] = segment.kind
    return replace(curve, segment=words)


def fit_all(body: FittedBody, curves: Sequence[Curve], settings: Settings, pool: Pool) -> list[Fit | Failure]:
    """Fits of all curves in their order; any exception but the project's own is a bug and shows itself. Of a single
    one the pool works on the samples of its bootstrap."""
    fits: dict[int, Fit | Failure] = {}
    with nullcontext(pool) if len(curves) > 1 else executor(1) as outer:
        work = partial(_next, body, settings, None if outer is pool else pool, Neighbour())
        for index, result in completed(outer, work, list(enumerate(curves)), "fitting", chunk=TOGETHER):
            if isinstance(result, JkrError):
                lines = result.lines if isinstance(result, InputError) else (str(result),)
                fits[index] = Failure(curves[index], lines)
            elif isinstance(result, Exception):
                raise result
            else:
                fits[index] = result
    return [fits[index] for index in sorted(fits)]


def _next(
    body: FittedBody, settings: Settings, pool: Pool | None, before: Neighbour, numbered: tuple[int, Curve]
) -> Fit:
    """The fit of a numbered curve, its search begun where that of the one ``before`` it in its task ended: the same
    however many work on tasks."""
    number, curve = numbered
    if number % TOGETHER == 0:
        before.last = None
    return fit(body, curve, settings, pool, before)


def fit(
    body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None = None, before: Neighbour | None = None
) -> Fit:
    """The parameters of ``settings`` that bring the curves of ``body`` nearest to a measured ``curve``; ``pool``: for
    the samples of its bootstrap; ``before``: where the search of a raw record before it in a map ended.

    Raises InputError where the data do not allow it, SolveError where it does not converge; both name the curve.
    """
    try:
        fitted = _fit(body, curve, settings, pool, before)
        flags = [
            WARNED.get(flag, "") + flag
            for flag in curve.flags
            if flag in WARNED or any(part in flag for part in (OVERRULED, NO_UNIT, GAPS))
        ]
        warnings = (*flags, *fitted.warnings)
        fitted = replace(fitted, warnings=warnings, pixel=curve.pixel, surface=body.problem.surface)
        return with_other_profile(with_strains(with_shape(fitted, body), body), body, curve, settings)
    except InputError as error:
        likely = "".join(f"; {flag}" for flag in (NOT_SUBTRACTED, SUBTRACTED_TWICE) if flag in curve.flags)
        lines = [line if line.startswith(curve.where) else f"{curve.where}: {line}" for line in error.lines]
        raise InputError([f"{line}{likely}" for line in lines]) from None
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}") from None
    except (ArithmeticError, RuntimeWarning) as error:  # of one curve, which takes no others of a map with it
        raise SolveError(f"{curve.where}: the numbers leave the range of arithmetic ({error})") from error


def with_shape(fitted: Fit, body: FittedBody) -> Fit:
    """The fit with what the shape of a tip that is no body of revolution leaves open, as a part of the model.

    Its contact area is the share kappa of that of the body of revolution: w acts as kappa w, on a half-space at equal
    E*. On layers S goes with the power n = a S'/S of the radius, in place of 1: E* changes by (n - 1)(1 - sqrt(kappa)).
    """
    tip = body.problem.indenter
    share, largest = tip.contact_share, float(np.max(fitted.a, initial=0.0))
    if share == 1:
        return replace(fitted, tip=tip.remark)
    parts = body.nonadhesive.parts(np.clip(largest, body.series.a[0], body.series.a[-1]))
    power = abs(float(largest * parts.dS / parts.S) - 1) if body.problem.layers else 0.0
    left = {"modulus": power * abs(1 - math.sqrt(share)), "work": 1 / share - 1}
    estimates = tuple(
        replace(item, model={**(item.model or {}), OF_SHAPE: left[item.dimension] * item.value})
        if item.error is not None and left.get(item.dimension) and item.value else item
        for item in fitted.estimates
    )  # fmt: skip
    return replace(fitted, estimates=estimates, tip=tip.remark)


def with_strains(fitted: Fit, body: FittedBody) -> Fit:
    """The fit with what large strains at pull-off change of w, as a part of the model where that is more than
    ``NOTICED`` of the interval; where it is not estimated, as a warning. w is as good as proportional to the force."""
    found, modulus = fitted.work, fitted.estimate("E_star").value
    if not (found.free and found.value > 0) or missed_pull_off(fitted.a, fitted.line) is not None:
        return fitted
    line, problem = fitted.line, body.problem.scaled(modulus / body.problem.E_star)
    least = int(np.argmin(line["P"])) if "P" in line else int(np.argmin(line["a"]))
    held = {name: float(line[name][least]) if name in line else 0.0 for name in ("a", "delta", "P")}
    change = large_strains(problem, found.value, Equilibrium(**held))
    if isinstance(change, Unknown):
        return replace(fitted, warnings=(*fitted.warnings, f"w: {strain_words(change)}"))
    moved = found.value * max((abs(1 / (1 + each) - 1) for each in change or ()), default=0.0)
    interval = (found.high or found.value) - (found.low or found.value)
    if found.error is None or moved <= NOTICED * interval:
        return fitted
    estimates = tuple(
        replace(item, model={**(item.model or {}), OF_STRAINS: moved}) if item is found else item
        for item in fitted.estimates
    )
    return replace(fitted, estimates=estimates)


def with_other_profile(fitted: Fit, body: FittedBody, curve: Curve, settings: Settings) -> Fit:
    """The fit with E* and w by the other profile of the same radius, where they differ by more than their errors.

    The literature's JKR is that of the paraboloid r^2/(2R), a ball is an exact sphere: beyond a/R of 0.3 they differ by
    more than many errors. Fitted again only there, and not for the curves of a map.
    """
    indenter, largest = body.problem.indenter, float(np.max(fitted.a, initial=0.0))
    R = indenter.tip_radius
    if type(indenter) not in (Sphere, Paraboloid) or R is None or curve.pixel is not None or not body.extensible:
        return fitted
    if largest < FLAT * R or indenter.material is not None:
        return fitted
    name, other = ("paraboloid", Paraboloid(R)) if isinstance(indenter, Sphere) else ("exact sphere", Sphere(R))
    try:
        again = _fit(body.under(other, largest), curve, settings, None)
    except JkrError:
        return fitted
    found = {item.name: item for item in again.estimates}
    pairs = [
        (item, found[item.name])
        for item in fitted.estimates
        if item.name in ("E_star", "w", "w_approach") and item.error and item.name in found
    ]
    outside = (two.value < (one.low or 0.0) or two.value > (one.high or math.inf) for one, two in pairs)
    if not any(outside):
        return fitted
    others = [two for _, two in reversed(pairs)]
    values = ", ".join(f"{SYMBOLS.get(item.name, item.name)} = {show(item.value, item.dimension)}" for item in others)
    words = f"by the {name} of the same radius {values} (a/R up to {largest / R:.2g}); say --shape for the tip you have"
    return replace(fitted, tip="; ".join(filter(None, (fitted.tip, words))))


@dataclass(frozen=True, eq=False)
class Prepared:
    """What is fitted of a ``curve``: its ``points``, the ``settings`` that its columns and edges leave of those that
    were ``requested``, and ``words`` on it."""

    curve: Curve
    points: Points
    settings: Settings
    requested: Settings
    words: tuple[str, ...]


def prepared(body: FittedBody, curve: Curve, settings: Settings) -> Prepared | ForceCurve:
    """The points of a curve, or a raw record, which is fitted as a whole."""
    original = curve
    check_parameters(body, [parameter.name for parameter in settings.parameters])
    if (record := whole_record(curve, settings)) is not None:
        if not beyond_the_record(settings):
            return record
        curve, settings = reduced(body, record, settings)
    requested = settings
    if idle := [name for name in settings.uncertain if name in CALIBRATED]:
        raise InputError(f"{curve.where}: --uncertain {idle[0]} is for raw records of a device, it has no effect here")
    if settings.tension_at_most:
        raise InputError(f"{curve.where}: --bound {TENSION} is for raw records, it has no effect here")
    curve = with_zero_points(curve) if settings.contact == "estimate" else curve
    curve, zero = parted(curve, settings), settings.known("P0")
    level = 0.0 if curve is not original and zero.free else None if zero.free else zero.value
    points = points_of(curve, settings.segment, settings.branch, len(settings.free), level)
    if unread := sorted(set(settings.noise) - set(points.values)):
        raise InputError(
            f"{curve.where}: --noise {unread[0]}: it was not measured, so this has no effect: leave it out"
        )
    settings, words = _determined_by(settings, points)
    edges = set() if points.edges is None else set(points.edges)
    settings = settings.of_a_cycle(ADVANCING in edges) if RECEDING in edges else settings
    return Prepared(curve, points, settings, requested, (*curve.flags[len(original.flags) :], *words))


def _fit(body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None, before: Neighbour | None = None) -> Fit:
    ready = prepared(body, curve, settings)
    if isinstance(ready, ForceCurve):
        return fit_record(body, ready, settings, pool, before)
    curve, points, settings, words = ready.curve, ready.points, ready.settings, ready.words
    edges, zero = set() if points.edges is None else set(points.edges), settings.known("P0")
    minimum = robust(search(body, points, settings), settings.loss)
    sharp = None if settings.range is None else jkr_beside(minimum, body, points, settings)
    confidence = confidence_of(minimum, settings, sharp, pool)
    rivals = Rivals((), 1.0)
    if settings.range is None and minimum.least.ended:
        rivals = rivals_of(minimum, confidence.scatter**2, confidence.dof, settings)
    flags: Mapping[str, str] = {} if curve.stiffness is None else flags_of(curve)
    free = minimum.objective.unknowns.names
    estimates = _resting(minimum, rivals.with_parts(confidence.estimates))
    undetermined = any(item.name in free and item.low is None and item.high is None for item in estimates)
    distances = minimum.distances
    readings, a = distances.readings, distances.a
    readings.member.refuse_beyond(float(a.max()))
    result = Fit(
        name=curve.name,
        file="" if curve.origin is None else str(curve.origin),
        where=curve.where,
        estimates=estimates,
        free=free,
        covariance=confidence.covariance,
        samples=confidence.samples,
        data=points.values,
        rows=points.rows,
        left_out=points.left_out,
        a=a,
        residuals=distances.residuals,
        scales=dict(zip(points.columns, map(float, readings.scales), strict=True)),
        scatter=confidence.scatter,
        dof=confidence.dof,
        structure=structure(distances.residuals[-1][distances.along]),
        line=distances.line(),
        evaluations=minimum.least.steps,
        settings=settings,
        flags=(*flags, *["not determined"] * undetermined),
        jkr=sharp,
        range_left=None if rivals.range is None else rivals.range.most,
    )
    checks = warnings_of(
        result, minimum.objective.body, readings.members.plain, minimum.at_bound, rivals, minimum.least.ended
    )
    words = (*words, *[RESTS] * (ADVANCING in edges and "w" not in free))
    result = replace(result, warnings=(*_on_record(flags, zero), *words, *checks))
    if edges == {ADVANCING}:
        return _of_an_approach(result)
    if ADVANCING not in edges or not _apart(minimum, confidence.scatter):
        return result
    into, back = (_fit(body, curve, replace(ready.requested, segment=kind), pool) for kind in EDGES)
    moduli = [one.estimate("E_star") for one in (into, back)]
    error = math.hypot(*((item.error or 0.0) / item.value for item in moduli))
    return beside(back, into, result) if differ(moduli[0].value, moduli[1].value, error) else result


def _apart(minimum: Minimum, scatter: float) -> bool:
    """Whether the rows of a cycle ask for another modulus on the way back than on the way in: by one step of Gauss and
    Newton with a modulus for each; ``scatter`` of the residuals."""
    objective, distances = minimum.objective, minimum.distances
    names = objective.unknowns.names
    if "modulus" not in names:
        return False
    assert objective.points.edges is not None
    jacobian, back = distances.jacobian(objective.free), objective.points.edges != ADVANCING
    own = jacobian[:, names.index("modulus")] * np.tile(back, distances.residuals.shape[0])
    matrix = np.column_stack([jacobian, own])
    spread = covariance(matrix, scatter**2)
    step = np.linalg.lstsq(matrix, -distances.residuals.ravel(), rcond=None)[0]
    return spread is not None and differ(1.0, 1 + float(step[-1]), math.sqrt(spread[-1, -1]))


def _of_an_approach(result: Fit) -> Fit:
    """The fit of an approach alone, whose w is called w_approach: w is that of a retraction."""
    estimates = tuple(replace(item, name=OWN.get(item.name, item.name)) for item in result.estimates)
    return replace(result, estimates=estimates, free=tuple(OWN.get(name, name) for name in result.free))


def _resting(minimum: Minimum, estimates: tuple[FittedValue, ...]) -> tuple[FittedValue, ...]:
    """The estimates; w of an edge that rests in all rows of the way back is at least what the last of them holds."""
    edges = minimum.objective.points.edges
    if edges is None or RECEDING in edges:
        return estimates
    modulus, part = minimum.objective.values(minimum.x)["modulus"], minimum.distances.at(RESTING)
    member = part.readings.member
    assert isinstance(member, RestingMember)
    least = modulus * (member.unit * float(part.u.max())) ** 2
    return tuple(FittedValue("w", least, True, "work", None, least) if item.name == "w" else item for item in estimates)


def _on_record(flags: Mapping[str, str], zero: Parameter) -> Iterator[str]:
    """Sentences on what is wrong with the record of a device whose readings were fitted as they are."""
    yield from (f"{name}: {sentence}" for name, sentence in flags.items())
    if "no base line" in flags and not zero.free and not zero.value:
        yield "no base line: the zero of the load is set to 0 (--free P0, or --zero P=... if known)"


def _determined_by(settings: Settings, points: Points) -> tuple[Settings, tuple[str, ...]]:
    """The settings with the parameters fixed that the measured columns do not determine, and words on them."""
    absent = set() if "delta" in points.columns else {"delta0", "compliance"}
    fixed = dict.fromkeys(absent if "P" in points.columns else absent | {"P0"}, 0.0)
    words: tuple[str, ...] = ()
    if "P" not in points.columns and {"modulus", "w"} <= {p.name for p in settings.free}:
        words = ("a and delta alone determine w/E* only: the moduli of the case are kept",)
        fixed["modulus"] = 1.0
    parameters = (replace(p, free=False, value=fixed[p.name]) if p.name in fixed else p for p in settings.parameters)
    return replace(settings, parameters=tuple(parameters)), words

"""Fits of measured curves: one curve, or many on one body, each on its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base.errors import InputError, JkrError, SolveError
from ...base.executors import Pool, completed, executor
from ...data.measured import Curve
from ...data.measured.contact import with_zero_points
from ...data.measured.curve import APPROACH, AS_DEPTH, NOT_SUBTRACTED, OVERRULED, RETRACT, Pixel
from ...data.record import examine
from .body import FittedBody, check_parameters
from .checks import warnings_of
from .confidence import confidence_of
from .jkr_beside import jkr_beside
from .model import arc
from .points import Points, points_of
from .record import fit_record, whole_record
from .result import Fit
from .rivals import Rivals, rivals_of
from .search import robust, search
from .settings import CALIBRATED, Parameter, Settings
from .statistics import structure

CHUNK = 20  # choice: curves per task
WARNED = {NOT_SUBTRACTED: "E* is that of contact and device in series: ", AS_DEPTH: ""}  # flags of a curve that matter


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


def flags_of(curve: Curve) -> Mapping[str, str]:
    """What is wrong with a record, in a word or two, and a sentence on each; none where it is too short or no force
    curve."""
    try:
        return examine(curve).flags
    except InputError:
        return {}


def parted(curve: Curve, settings: Settings) -> Curve:
    """The curve with approach and retraction told apart by its motion, where it holds both, no column tells them and
    one of them is asked for, or to be taken because it is the record of a device."""
    asked = settings.segment in (APPROACH, RETRACT) or (settings.segment is None and curve.stiffness is not None)
    if curve.segment is not None or not asked:
        return curve
    try:
        segments = examine(curve).segments
    except InputError:
        return curve
    if not {APPROACH, RETRACT} <= {segment.kind for segment in segments}:
        return curve
    words = np.full(len(curve), "", dtype="U8")
    for segment in segments:
        words[segment.rows] = segment.kind
    return replace(curve, segment=words)


def fit_all(body: FittedBody, curves: Sequence[Curve], settings: Settings, pool: Pool) -> list[Fit | Failure]:
    """Fits of all curves in their order; any exception but the project's own is a bug and shows itself. Of a single
    one the pool works on the samples of its bootstrap."""
    found: dict[int, Fit | Failure] = {}
    with nullcontext(pool) if len(curves) > 1 else executor(1) as outer:
        work = partial(fit, body, settings=settings, pool=None if outer is pool else pool)
        for index, result in completed(outer, work, curves, "fitting", chunk=CHUNK):
            if isinstance(result, JkrError):
                lines = result.lines if isinstance(result, InputError) else (str(result),)
                found[index] = Failure(curves[index], lines)
            elif isinstance(result, Exception):
                raise result
            else:
                found[index] = result
    return [found[index] for index in sorted(found)]


def fit(body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None = None) -> Fit:
    """The parameters of ``settings`` that bring the curves of ``body`` nearest to a measured ``curve``; ``pool``: for
    the samples of its bootstrap.

    Raises InputError where the data do not allow it, SolveError where it does not converge; both name the curve.
    """
    try:
        found = _fit(body, curve, settings, pool)
        kept = [WARNED.get(flag, "") + flag for flag in curve.flags if flag in WARNED or OVERRULED in flag]
        warnings = (*kept, *found.warnings)
        return replace(found, warnings=warnings, pixel=curve.pixel, surface=body.problem.surface)
    except InputError as error:
        missing = f"; {NOT_SUBTRACTED}" if NOT_SUBTRACTED in curve.flags else ""
        lines = [line if line.startswith(curve.where) else f"{curve.where}: {line}" for line in error.lines]
        raise InputError([f"{line}{missing}" for line in lines]) from None
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}") from None


def _fit(body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None) -> Fit:
    check_parameters(body, [parameter.name for parameter in settings.parameters])
    if (record := whole_record(curve, settings)) is not None:
        return fit_record(body, record, settings)
    if idle := [name for name in settings.uncertain if name in CALIBRATED]:
        raise InputError(f"{curve.where}: --uncertain {idle[0]} is for raw records of a device, it has no effect here")
    curve = with_zero_points(curve) if settings.contact == "estimate" else curve
    curve, zero = parted(curve, settings), settings.parameter("P0")
    level = 0.0 if zero is None else None if zero.free else zero.value
    points = points_of(curve, settings.segment, settings.branch, len(settings.free), level)
    settings, words = _told_by(settings, points)
    minimum = robust(search(body, points, settings), settings.loss)
    sharp = None if settings.range is None else jkr_beside(minimum, body, points, settings)
    confidence = confidence_of(minimum, settings, sharp, pool)
    rivals = Rivals((), 1.0)
    if settings.range is None and minimum.ended:
        rivals = rivals_of(minimum, confidence.scatter**2, confidence.dof, settings)
    flags: Mapping[str, str] = {} if curve.stiffness is None else flags_of(curve)
    estimates, free = rivals.with_parts(confidence.estimates), tuple(parameter.name for parameter in settings.free)
    untold = any(item.name in free and item.low is None and item.high is None for item in estimates)
    distances = minimum.found
    readings, a = distances.readings, distances.a
    readings.member.refuse_beyond(float(a.max()))
    along = arc(readings)
    line_a = readings.radii(along)
    along = along[line_a <= max(float(np.exp(readings.members.plain.high)), a.max())]
    line = readings.along(along)[0] * readings.scales[:, None]
    found = Fit(
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
        structure=structure(distances.residuals[-1][np.argsort(distances.u)]),
        line={"a": readings.radii(along)} | dict(zip(points.columns, line, strict=True)),
        evaluations=minimum.evaluations,
        settings=settings,
        warnings=(),
        flags=(*flags, *["not determined"] * untold),
        jkr=sharp,
        range_left=None if rivals.range is None else rivals.range.most,
    )
    said = warnings_of(found, minimum.objective.body, readings.members.plain, minimum.at_bound, rivals, minimum.ended)
    return replace(found, warnings=(*_on_record(flags, zero), *words, *_on_branches(curve, settings), *said))


def _on_branches(curve: Curve, settings: Settings) -> Iterator[str]:
    """A sentence where prepared readings of both directions are fitted as one branch."""
    if settings.segment == "both" and {APPROACH, RETRACT} <= set(curve.segments()):
        yield "one w is fitted to approach and retraction: give --segment retract or approach where theirs differ"


def _on_record(flags: Mapping[str, str], zero: Parameter | None) -> Iterator[str]:
    """Sentences on what is wrong with the record of a device whose readings were fitted as they are."""
    yield from (f"{name}: {sentence}" for name, sentence in flags.items())
    if "no base line" in flags and zero is not None and not zero.free and not zero.value:
        yield "no base line tells the reading of no load: it is taken as 0 (--free P0, or --zero P=... if it is known)"


def _told_by(settings: Settings, points: Points) -> tuple[Settings, tuple[str, ...]]:
    """The settings with the parameters that the measured columns do not tell fixed, and words on what is not told."""
    absent = set() if "delta" in points.columns else {"delta0", "compliance"}
    fixed = dict.fromkeys(absent if "P" in points.columns else absent | {"P0"}, 0.0)
    words: tuple[str, ...] = ()
    if "P" not in points.columns and {"modulus", "w"} <= {p.name for p in settings.free}:
        words = ("a and delta alone tell w/E* only: the moduli are taken as the case has them",)
        fixed["modulus"] = 1.0
    parameters = (replace(p, free=False, value=fixed[p.name]) if p.name in fixed else p for p in settings.parameters)
    return replace(settings, parameters=tuple(parameters)), words

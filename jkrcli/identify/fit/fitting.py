"""Fit one measured curve: rows, the search for the minimum, confidence, warnings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base.errors import InputError, SolveError
from ...data.measured import Curve
from .body import Body, check_parameters
from .checks import warnings_of
from .confidence import intervals
from .distances import arc
from .points import Points, points_of
from .result import Fit
from .search import search
from .settings import Settings
from .solve import Minimum, minimise
from .statistics import TURNS, correlation, robust_scale, structure
from .uncertain import widened


def fit(body: Body, curve: Curve, settings: Settings) -> Fit:
    """The parameters of ``settings`` that bring the curves of ``body`` nearest to a measured ``curve``.

    Raises InputError where the data do not allow it, SolveError where it does not converge; both name the curve.
    """
    try:
        return _fit(body, curve, settings)
    except InputError as error:
        lines = [line if line.startswith(curve.where) else f"{curve.where}: {line}" for line in error.lines]
        raise InputError(lines) from None
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}") from None


def _fit(body: Body, curve: Curve, settings: Settings) -> Fit:
    check_parameters(body, [parameter.name for parameter in settings.parameters])
    zero = settings.parameter("P0")
    level = 0.0 if zero is None else None if zero.free else zero.value
    points = points_of(curve, settings.segment, settings.branch, len(settings.free), level)
    settings, words = _told_by(settings, points)
    minimum = _robust(search(body, points, settings), settings)
    confidence = intervals(minimum, settings)
    estimates = widened(minimum, confidence, settings) if settings.uncertain else confidence.estimates
    residuals, u = minimum.found.residuals, minimum.found.u
    readings = minimum.found.readings
    along = arc(readings)
    line = readings.along(along[along <= max(readings.family.high, u.max())])[0] * readings.scales[:, None]
    found = Fit(
        name=curve.name,
        file="" if curve.origin is None else str(curve.origin),
        where=curve.where,
        estimates=estimates,
        free=tuple(parameter.name for parameter in settings.free),
        covariance=confidence.covariance,
        correlation=None if confidence.covariance is None else correlation(confidence.covariance),
        samples=confidence.samples,
        data=points.values,
        rows=points.rows,
        left_out=points.left_out,
        a=np.exp(u),
        residuals=residuals,
        scales=dict(zip(points.columns, map(float, minimum.objective.scales), strict=True)),
        scatter=confidence.scatter,
        dof=confidence.dof,
        structure=structure(residuals[-1][np.argsort(u)]),
        line={"a": np.exp(along[: line.shape[1]])} | dict(zip(points.columns, line, strict=True)),
        evaluations=minimum.evaluations,
        settings=settings,
        warnings=words,
    )
    return replace(found, warnings=(*words, *warnings_of(found, minimum)))


def _told_by(settings: Settings, points: Points) -> tuple[Settings, tuple[str, ...]]:
    """With the parameters that the measured columns do not tell fixed, and words on what cannot be told."""
    absent = set()
    if "delta" not in points.columns:
        absent |= {"delta0", "compliance"}
    if "P" not in points.columns:
        absent.add("P0")
    parameters = [replace(p, free=False, value=0.0) if p.name in absent else p for p in settings.parameters]
    words: list[str] = []
    both = [p for p in parameters if p.name in ("modulus", "w") and p.free]
    if "P" not in points.columns and len(both) == 2:
        words.append("a and delta alone tell w/E* only: the moduli are taken as the case has them")
        parameters = [replace(p, free=False, value=1.0) if p.name == "modulus" else p for p in parameters]
    return replace(settings, parameters=tuple(parameters)), tuple(words)


def _robust(minimum: Minimum, settings: Settings) -> Minimum:
    """With a robust loss: from the least squares on, its turn set twice by the scatter of the residuals."""
    for _ in range(2 * (settings.loss != "linear")):
        width = TURNS[settings.loss] * max(robust_scale(minimum.found.residuals), 1e-12)
        minimum = replace(minimise(minimum.objective, minimum.x, settings.loss, width), width=width)
    return minimum

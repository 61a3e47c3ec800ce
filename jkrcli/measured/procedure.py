"""Fits of measured curves: one curve, or many on one body, each on its own."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..adhesion.curve import Equilibrium
from ..adhesion.validity import large_strains, strain_words
from ..base.errors import InputError, JkrError, SolveError, Unknown
from ..base.executors import Pool, batches_completed, executor
from ..base.numerics import LOOKED_AT, UNSEEN, Array
from ..base.units import show
from ..bodies.indenters import Paraboloid, Sphere
from ..bodies.problem import RADIUS, changed, checked_names
from ..methods.radii import ROOM
from ..resolve.sticking import sticking_effect, sticking_warnings
from .batch import header_errors
from .checks import warnings_of
from .choices import Values
from .curve import APPROACH, RETRACT, Curve, Pixel
from .force_curve import FIT_ENOUGH, ForceCurveFit, fitting
from .forward_model import ADVANCING, RECEDING, RESTING, DugdaleCurve, FittedBody, RestingMember
from .least_squares import (
    Intervals,
    State,
    bootstrap,
    covariance,
    covariance_of_uneven,
    larger,
    structure,
    t_quantile,
    variance_factor,
    wider,
)
from .lockstep import Flow, alone, together
from .model_changes import ADHESION, TIP
from .nuisance import fit_settled
from .parameters import LOG, FittedValue, Parameter, changes_by, dimension_of
from .range_alternative import TableAlternatives, alternatives_of, missed_pull_off
from .record import (
    REJECTED,
    RESTS,
    beside,
    beyond_the_record,
    contact_rows,
    differ,
    fitted_whole,
    outcome_of,
    raw_force_curve,
)
from .result import Fit, Further, JKRBeside, attempted, later, left_out, without
from .rows import (
    COLUMNS,
    EDGES,
    SEARCH_CONVERGED_ROUGH,
    SEARCH_EVALUATIONS,
    Distances,
    FootPoints,
    Minimum,
    Objective,
    Points,
    Readings,
    minimise,
    orient,
    points_of,
    robust,
    search,
)
from .score_tests import SCORE_TIED
from .segmentation import PERMANENT_SET as SET
from .segmentation import ForceCurve, segment_force_curve, with_zero_points
from .settings import CALIBRATED, RANGES, TENSION, Settings

# --------------------------------------------------------------------------------------------------
# Confidence of a fit to prepared readings: intervals as the settings want them, the systematic part, and how much
# worse JKR describes the same rows beside adhesion of finite range.

# How intervals are computed.
CONFIDENCE_FEW = 10  # choice: degrees of freedom, below which residuals do not show the noise's change along the curve


@dataclass(frozen=True, eq=False)
class Confidence:
    """What is known of a fit: ``estimates`` with their intervals, ``covariance`` of the free parameters, SI,
    ``samples`` of a bootstrap, ``scatter``: standard deviation of the residuals, ``dof``: degrees of freedom."""

    estimates: tuple[FittedValue, ...]
    covariance: Array | None
    samples: Array | None
    scatter: float
    dof: int


def confidence_of(
    minimum: Minimum, settings: Settings, jkr: JKRBeside | Unknown | None = None, pool: Pool | None = None
) -> Confidence:
    """All parameters and what follows from them, with intervals as ``settings`` want them; ``jkr``: beside a range;
    ``pool``: for the samples of a bootstrap.

    A range that JKR does without is known on one side only, by its profile; nothing where the search did not end.
    """
    if not minimum.least.ended:
        settings = replace(settings, confidence="covariance", uncertain={})
    objective, here, (inner, factor, dof) = minimum.objective, minimum.values, spread_of(minimum, settings)
    t, samples = t_quantile(settings.level, dof), None
    if settings.confidence == "bootstrap":
        change = partial(_redrawn, minimum.distances.residuals.shape)
        samples = bootstrap(minimum.least, change, SEARCH_CONVERGED_ROUGH, settings.samples, settings.seed, pool)
    follow = _follows(objective, here)
    dimensions = {name: dimension_of(name) if name in RANGES else "modulus" for name in follow}
    following = (Parameter(name, True, scale=LOG, quantity=kind, follows=True) for name, kind in dimensions.items())
    intervals = Intervals(
        minimum.least, [*objective.parameters, *following], partial(_meaning, minimum), inner, t, settings.level,
        settings.confidence == "profile", factor, samples,
    )  # fmt: skip
    estimates = intervals.estimates()
    if isinstance(jkr, JKRBeside) and jkr.excess < 0.5 * t**2 * factor:
        estimates = tuple(_without_range(item, intervals, jkr.values, here) for item in estimates)

    # Uncertain inputs of the body, to first order: each changed by its standard deviation
    def outcome(name: str, value: float) -> dict[str, float]:
        moved = replace(objective, body=objective.body.with_values({name: value}))
        again = minimise(moved, minimum.x, settings.loss, minimum.width).values
        return again | _follows(moved, again)

    changes = {
        name: changes_by(name, objective.body.nominal(name), sigma, here | follow, partial(outcome, name))
        for name, sigma in settings.uncertain.items()
    }
    estimates = tuple(wider(item, {name: by[item.name] for name, by in changes.items()}, t) for item in estimates)
    free = objective.unknowns.names
    return Confidence(estimates, intervals.covariance_of(free), intervals.sampled(free), math.sqrt(factor), dof)


def _meaning(minimum: Minimum, y: Array) -> dict[str, float]:
    """The quantities at the unknowns ``y`` of the search, on their own scales."""
    x = minimum.objective.at(minimum.x, y)
    follow = _follows(minimum.objective, minimum.objective.values(x))
    return x | {name: math.log(value) if value > 0 else -math.inf for name, value in follow.items()}


def _without_range(item: FittedValue, intervals: Intervals, jkr: Values, here: Values) -> FittedValue:
    """The estimate where a range is not significantly above 0: of a range the largest that it may have, of a tension
    the least; of others the interval holds that of JKR as well."""
    if item.name in RANGES:
        quantity = next(one for one in intervals.quantities if one.name == item.name)
        if quantity.follows or not item.free:
            return replace(item, error=None, low=None, high=None)
        end = intervals.end(quantity, intervals.t if item.name == "range" else -intervals.t)
        low, high = (0.0, end) if item.name == "range" else (end, None)
        return replace(item, error=None, low=low, high=high)
    name = "modulus" if item.dimension == "modulus" and item.name not in jkr else item.name
    if name not in jkr or item.error is None or item.low is None or item.high is None:
        return item
    shift = jkr[name] - here[name] if name == item.name else item.value * (jkr[name] / here[name] - 1)
    least, most = min(item.low, item.low + shift), max(item.high, item.high + shift)
    least = max(least, 0.0) if item.dimension == "work" else least
    return replace(item, error=math.hypot(item.error, shift), low=least, high=most)


def spread_of(minimum: Minimum, settings: Settings) -> tuple[Array | None, float, int]:
    """The covariance of the unknowns of the search, the variance of the residuals, and their degrees of freedom."""
    residuals, jacobian, free = minimum.distances.residuals, minimum.least.state.jacobian, minimum.least.x
    measured = set(minimum.objective.points.columns)
    columns = len(measured)
    dof = max(residuals.shape[1] * (columns - 1) - free.size, 1)  # a foot point takes one number from every point
    factor = variance_factor(residuals, dof, settings.loss, minimum.width)
    inner = covariance(jacobian, factor) if minimum.least.ended else None
    even = measured <= settings.noise.keys()  # else that is more than a record of a sensor shows
    if settings.loss == "linear" and dof >= CONFIDENCE_FEW and not even:
        inner = larger(inner, covariance_of_uneven(jacobian, residuals))
    return inner, factor, dof


def _follows(objective: Objective, values: Values) -> dict[str, float]:
    """E* [Pa] and the moduli E of all layers [Pa] that are no parameters themselves, and tension [Pa] or range [m]."""
    problem = changed(objective.body.problem, {name: value for name, value in values.items() if ":" in name})
    following = replace(objective.body, problem=problem).moduli(values.get("modulus", 1.0))
    if objective.ranged:
        following |= {"stress": values["w"] / values["range"]} if "range" in values else {}
        following |= {"range": values["w"] / values["stress"]} if "stress" in values else {}
    return {name: value for name, value in following.items() if name not in values}


def _redrawn(shape: tuple[int, int], rng: np.random.Generator) -> Callable[[State], State]:
    """Residuals of this ``shape`` (columns, rows) at rows drawn with replacement."""
    rows = rng.integers(0, shape[1], shape[1])
    every = (np.arange(shape[0])[:, None] * shape[1] + rows).ravel()
    return lambda state: state.rows(every)


# ---------------------------------------------------------------------- beside a range
def jkr_comparison(minimum: Minimum, body: FittedBody, points: Points, settings: Settings) -> JKRBeside | Unknown:
    """The nearest curve of JKR to the rows of ``minimum``, in its scales; Unknown where none comes near."""
    plain = settings.without(RANGES)
    try:
        near = search(body, points, plain)
        objective = replace(near.objective, scales=minimum.objective.scales)
        jkr = robust(minimise(objective, near.x), settings.loss)
        jkr = minimise(objective, jkr.x, settings.loss, minimum.width)  # the same turn of a robust loss
    except JkrError as error:
        return Unknown(str(error))
    if not jkr.least.ended:
        return Unknown(f"the fit did not converge in {SEARCH_EVALUATIONS} steps")
    values = jkr.values
    rms, with_range = (math.sqrt(float(np.mean(item.distances.residuals**2))) for item in (jkr, minimum))
    E_star = values["modulus"] * body.problem.E_star
    return JKRBeside(E_star, values["w"], rms, with_range, jkr.cost - minimum.cost, values)


OWN = {"w": "w_approach"}  # names of an approach alone
OF_SHAPE = "the faces of the pyramid"
OF_STRAINS = "large strains"
UNREAD = "not read"
NOTICED = 0.1  # choice: of the interval of w, the part by large strains from which on it is told
FLAT = 0.2  # theory: of R, the contact radius up to which sphere and paraboloid agree to 1 % in the load
SIDE_BY_SIDE = 64  # choice: curves that are fitted together, which shares what each step costs besides its rows
SIDE_BY_SIDE_ROWS = 150_000  # choice: of theirs in all
SIDE_BY_SIDE_KIB, KEPT_KIB = 1.1, 0.1  # choice: of memory, a row while it is fitted and afterwards; measured
STIFFEST = 50.0  # choice: of the device, a contact's stiffness beyond which no E* is told
STIFFNESS_PART = 0.2  # choice: of the range of the load, from the largest on, over which a contact's stiffness is taken
SYMBOLS = {"E_star": "E*"}


@dataclass(frozen=True, eq=False)
class Failure:
    """A curve that could not be fitted, without ``curve`` a file that could not be read; ``lines``: why, one sentence
    each; ``flags``: what is wrong with the record, in a word or two each."""

    curve: Curve | None
    lines: tuple[str, ...]

    @property
    def flags(self) -> tuple[str, ...]:
        return () if self.curve is None else tuple(flags_of(self.curve))

    @property
    def pixel(self) -> Pixel | None:
        return None if self.curve is None else self.curve.pixel

    @property
    def where(self) -> str:
        """File and name, for messages, which begin with them."""
        return self.lines[0].partition(": ")[0] if self.curve is None else self.curve.where

    @property
    def file(self) -> str:
        return self.where if self.curve is None else str(self.curve.origin or "")

    @property
    def name(self) -> str:
        return Path(self.where).stem if self.curve is None else self.curve.name

    @property
    def reason(self) -> str:
        """The first of the lines, without the place."""
        return f"{UNREAD}: " * (self.curve is None) + self.lines[0].removeprefix(f"{self.where}: ")


def _examined(curve: Curve) -> ForceCurve | None:
    """The record taken apart; None where it is too short or no force curve."""
    try:
        return segment_force_curve(curve)
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
    curve = orient(curve)
    record = _examined(curve) if needed and curve.segment is None else None
    if record is None or not {APPROACH, RETRACT} <= {segment.kind for segment in record.segments}:
        return curve
    words = np.full(len(curve), "", dtype="U8")
    for segment in record.segments:
        words[segment.rows] = segment.kind
    return replace(curve, segment=words)


def memory_of(curves: Sequence[Curve], bodies: int = 1, workers: int | None = 1) -> float:
    """MiB of memory that the fits of some curves on so many ``bodies`` need, by processes of which all ``workers`` are
    told, or one."""
    rows = sum(map(len, curves))
    return (KEPT_KIB * rows * bodies + SIDE_BY_SIDE_KIB * min(rows, (workers or 1) * SIDE_BY_SIDE_ROWS)) / 1024


def fit_all(body: FittedBody, curves: Sequence[Curve], settings: Settings, pool: Pool) -> list[Fit | Failure]:
    """Fits of all curves in their order; any exception but the project's own is a bug and shows itself. Of a single
    one the pool works on the samples of its bootstrap."""
    fits: dict[int, Fit | Failure] = {}
    with nullcontext(pool) if len(curves) > 1 else executor(1) as outer:
        work = partial(_fits_together, body, settings=settings, pool=None if outer is pool else pool)
        groups = outer.workers * math.ceil(len(curves) / (SIDE_BY_SIDE * outer.workers)) or 1  # of about one size
        for index, result in batches_completed(outer, work, curves, "fitting", math.ceil(len(curves) / groups) or 1):
            if isinstance(result, JkrError):
                lines = result.lines if isinstance(result, InputError) else (str(result),)
                fits[index] = Failure(curves[index], lines)
            elif isinstance(result, Exception):
                raise result
            else:
                fits[index] = result
    return [fits[index] for index in sorted(fits)]


def _fits_together(
    body: FittedBody, curves: list[Curve], settings: Settings, pool: Pool | None
) -> list[Fit | Exception]:
    """The fits of some curves, side by side as far as their rows are few, exceptions in place of those that failed."""
    fits, batch, rows = list[Fit | Exception](), list[Curve](), 0
    for curve in (*curves, None):
        if batch and (curve is None or rows + len(curve) > SIDE_BY_SIDE_ROWS):
            fits += together([_fitting(body, one, settings, pool) for one in batch])
            batch, rows = [], 0
        if curve is not None:
            batch, rows = [*batch, curve], rows + len(curve)
    return fits


def fit(body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None = None) -> Fit:
    """The parameters of ``settings`` that bring the curves of ``body`` nearest to a measured ``curve``; ``pool``: for
    the samples of its bootstrap.

    Raises InputError where the data do not allow it, SolveError where it does not converge; both name the curve.
    """
    return alone(_fitting(body, curve, settings, pool))


def _fitting(body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None) -> Flow[Fit]:
    try:
        fitted, whole = yield from _fit(body, curve, settings, pool)
        fitted = yield from _completed(fitted, body, curve)
        other = partial(with_other_profile, fitted, body, curve, settings, whole)
        return (yield from later(fitted, "the other profile of the same radius", other))
    except InputError as error:
        lines = [line if line.startswith(curve.where) else f"{curve.where}: {line}" for line in error.lines]
        raise InputError([f"{line}{curve.likely}" for line in lines]) from None
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}") from None
    except (ArithmeticError, RuntimeWarning) as error:  # of one curve, which takes no others of a map with it
        raise SolveError(
            f"{curve.where}: arithmetic overflow ({error}): check the units of the columns, --radius and --E"
        ) from error


def _completed(fitted: Fit, body: FittedBody, curve: Curve) -> Flow[Fit]:
    """The fit with what its readings, inputs and body say besides."""
    warnings = (*curve.doubts, *fitted.warnings)
    fitted = replace(fitted, warnings=warnings, pixel=curve.pixel, surface=body.problem.surface)
    inputs = partial(with_inputs, fitted, body, curve.stiffness)
    fitted = yield from later(fitted, "inputs that no error holds", inputs)
    fitted = yield from later(fitted, OF_SHAPE, partial(with_shape, fitted, body))
    return (yield from later(fitted, OF_STRAINS, partial(with_strains, fitted, body)))


def with_inputs(fitted: Fit, body: FittedBody, stiffness: float | None) -> Fit:
    """The fit of a raw record with what no row can tell: its inputs that no error holds, and how far the sensitivity of
    the device counts, beside which a contact may be too stiff.

    At the device z = delta + P/k a relative error e of P/k is one of -e N in delta, N = (dP/d delta)/k: E* errs by
    e (1 + N) on a half-space (Hertz). Beyond ``STIFFEST`` it is known only to be at least what has that N there: a
    contact's stiffness goes with E*^(2/3) at equal loads.
    """
    if fitted.sizes is None or fitted.covariance is None:
        return fitted
    missing = [] if RADIUS in fitted.settings.uncertain or body.problem.indenter.tip_radius is None else ["radius"]
    if missing and not body.problem.layers:
        missing = ["tip radius (E* ~ R^-1/2, w ~ 1/R)"]
    ratio = None
    if stiffness is not None and not math.isinf(stiffness):
        # dP/d delta of the fitted curve over the deepest part of its contact, if that holds two depths
        P, delta = (fitted.line[name][fitted.line["a"] > 0] for name in ("P", "delta"))
        top = P > np.max(P, initial=-math.inf) - STIFFNESS_PART * np.ptp(P)
        along = delta[top] - delta[top].mean()
        if along.any():
            ratio = abs(float(along @ P[top] / (along @ along))) / stiffness
    if ratio is not None:
        of_error = f" (1 % changes E* by {round(1 + ratio, 1 if ratio < STIFFEST / 5 else None)} %)"
        of_device = {"stiffness": "spring constant", "sensitivity": f"sensitivity{of_error}"}
        missing += [words for name, words in of_device.items() if name not in fitted.settings.uncertain]
    words = f"errors of {', '.join(missing)}: --uncertain adds them" if missing else ""
    fitted = replace(fitted, not_included=words)
    modulus = next((item for item in fitted.estimates if item.name == "E_star"), None)
    if ratio is None or ratio <= STIFFEST or modulus is None or not modulus.free:
        return fitted
    factor = (STIFFEST / ratio) ** 1.5
    estimates = tuple(
        replace(item, value=factor * item.value, error=None, low=factor * item.value, high=None, model=None)
        if item.free and (item.dimension == "modulus" or item.name == "modulus") else item
        for item in fitted.estimates
    )  # fmt: skip
    sentence = (
        f"too stiff: at the largest load the contact is {ratio:.0f} times stiffer than the cantilever, the specimen is "
        f"stiffer than E* = {show(factor * modulus.value, 'modulus', 2)}: take a stiffer instrument or a blunter tip"
    )
    return replace(
        fitted, estimates=estimates, flags=(*fitted.flags, "too stiff"), warnings=(sentence, *fitted.warnings)
    )


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
        item.with_model(OF_SHAPE, left[item.dimension] * item.value)
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
    line, w = fitted.line, found.value * body.problem.E_star / modulus  # strains go with w/E*
    least = int(np.argmin(line["P"])) if "P" in line else int(np.argmin(line["a"]))
    held = {name: float(line[name][least]) if name in line else 0.0 for name in ("a", "delta", "P")}
    change = large_strains(body.problem, w, Equilibrium(**held))
    if isinstance(change, Unknown):
        return replace(fitted, warnings=(*fitted.warnings, f"w: {strain_words(change)}"))
    moved = found.value * max((abs(1 / (1 + each) - 1) for each in change or ()), default=0.0)
    interval = (found.high or found.value) - (found.low or found.value)
    if found.error is None or moved <= NOTICED * interval:
        return fitted
    moving = (item.with_model(OF_STRAINS, moved) if item is found else item for item in fitted.estimates)
    return replace(fitted, estimates=tuple(moving))


def with_other_profile(
    fitted: Fit, body: FittedBody, curve: Curve, settings: Settings,
    whole: tuple[ForceCurve, ForceCurveFit] | None = None,
) -> Flow[Fit]:  # fmt: skip
    """The fit with E* and w by the other profile of the same radius, where they differ by more than their errors; that
    fit, where the data reject this one for the shape of its tip, and not the other. ``whole``: of a raw record what was
    fitted, and the fit of all its directions.

    The literature's JKR is that of the paraboloid r^2/(2R), a ball is an exact sphere: beyond a/R of 0.3 they differ by
    more than many errors. Fitted again only there, from this fit on, and not for the curves of a map.
    """
    indenter, largest = body.problem.indenter, float(np.max(fitted.a, initial=0.0))
    R = indenter.tip_radius
    if type(indenter) not in (Sphere, Paraboloid) or R is None or curve.pixel is not None or not body.extensible:
        return fitted
    if largest < FLAT * R or indenter.material is not None or (fitted.verdict and fitted.verdict.answers):
        return fitted
    own, name = ("exact sphere", "paraboloid") if isinstance(indenter, Sphere) else ("paraboloid", "exact sphere")
    named = () if fitted.verdict is None or REJECTED not in fitted.flags else fitted.verdict.alternatives.named
    try:
        other = body.under(Paraboloid(R) if isinstance(indenter, Sphere) else Sphere(R), ROOM * largest)
        found, noise = yield from _by_profile(fitted, other, curve, settings, whole)
        # What another law of adhesion takes of the misfit as well as the other profile does may be the cause
        falls = fitted.rows.size * ((fitted.scales.get("P", 0.0) / noise) ** 2 - 1)
        by_adhesion = any(one.family == ADHESION and one.taken > falls - SCORE_TIED for one in named)
        by_tip = any(one.family == TIP for one in named) and not by_adhesion
        explained = whole is None or noise <= FIT_ENOUGH * whole[1].model.noise
        again = (yield from _fit(other, curve, settings, None))[0] if by_tip and explained else None
    except JkrError:
        return fitted
    if again is not None and not {REJECTED, "misfit"} & {*again.flags}:
        E_star, work = fitted.estimate("E_star"), fitted.work
        values = f"E* = {show(E_star.value, 'modulus')}, {work.name} = {show(work.value, 'work')}"
        words = f"the {name} of the same radius, which describes the record; the {own} does not and would give {values}"
        again = yield from _completed(again, other, curve)
        return replace(again, tip=words, warnings=(f"E* and w are of {words}: choose --shape", *again.warnings))
    pairs = [
        (item, replace(item, value=found[item.name]))
        for item in fitted.estimates
        if item.name in ("E_star", "w", "w_approach") and item.error and item.name in found
    ]
    outside = (two.value < (one.low or 0.0) or two.value > (one.high or math.inf) for one, two in pairs)
    if not any(outside):
        return fitted
    others = [two for _, two in reversed(pairs)]
    values = ", ".join(f"{SYMBOLS.get(item.name, item.name)} = {show(item.value, item.dimension)}" for item in others)
    words = f"the {name} of the same radius would give {values} (a/R up to {largest / R:.2g}): choose --shape"
    return replace(fitted, tip="; ".join(filter(None, (fitted.tip, words))))


def _by_profile(
    fitted: Fit, other: FittedBody, curve: Curve, settings: Settings, whole: tuple[ForceCurve, ForceCurveFit] | None
) -> Flow[tuple[Values, float]]:
    """E* and w on the ``other`` body, and the scatter of loads about its curve [N]."""
    if whole is None or settings.range is not None:
        again, _ = yield from _fit(other, curve, settings, None)
        return {item.name: item.value for item in again.estimates}, again.scales.get("P", math.inf)
    record, best = whole
    if any(item.name == "E_star_approach" for item in fitted.estimates):  # beside the answer of the retraction
        _, found = yield from fitted_whole(other, record, replace(settings, segment="retract"))
    else:
        found = yield from fitting(replace(best.model, family=other.family), best.x, loss=settings.loss)
    return outcome_of(found, found.x, other), found.sigma


@dataclass(frozen=True, eq=False)
class Prepared:
    """What is fitted of a ``curve``: its ``points``, the ``settings`` that its columns and edges leave of those that
    were ``requested``, and ``words`` on it."""

    curve: Curve
    points: Points
    settings: Settings
    requested: Settings
    words: tuple[str, ...]


def preparing(body: FittedBody, curve: Curve, settings: Settings) -> Flow[Prepared | ForceCurve]:
    """The points of a curve, or a raw record, which is fitted as a whole."""
    original = curve
    if (own := [parameter.name for parameter in settings.parameters if parameter.of_body]) and not body.own_parameters:
        raise InputError(f"fit: {own[0]}: a finite cylinder is not solved anew; fit its modulus, or leave radius out")
    checked_names(own, body.own_parameters)
    if (record := (yield from raw_force_curve(curve, settings))) is not None:
        if not beyond_the_record(settings):
            return record
        if settings.range is not None:
            raise InputError(
                f"{settings.range.name} is fitted to whole force curves, without compliance, parameters of single "
                "layers, known zeros, --branch, --noise, --start and --bound: leave these or it out"
            )
        curve, settings = contact_rows(body, record, settings)
    requested = settings
    of_device = [name for name in settings.uncertain if name in CALIBRATED]
    if idle := [name for name in of_device if name not in header_errors([curve])]:
        raise InputError(
            f"{curve.where}: --uncertain {idle[0]} is for raw force curves of an instrument, it has no effect here"
        )
    settings = replace(settings, uncertain={k: v for k, v in settings.uncertain.items() if k not in of_device})
    if settings.tension_at_most:
        raise InputError(f"{curve.where}: --bound {TENSION} is for raw force curves, it has no effect here")
    curve = with_zero_points(curve) if settings.contact == "estimate" else curve
    curve, zero = parted(curve, settings), settings.known("P0")
    level = 0.0 if curve is not original and zero.free else None if zero.free else zero.value
    points = points_of(curve, settings.segment, settings.branch, len(settings.free), level)
    if unread := sorted(set(settings.noise) - set(points.values)):
        raise InputError(f"{curve.where}: --noise {unread[0]}: the file has no {unread[0]}: leave it out")
    # What the measured columns do not determine is fixed
    absent, words = set() if "delta" in points.columns else {"delta0", "compliance"}, tuple[str, ...]()
    fixed = dict.fromkeys(absent if "P" in points.columns else absent | {"P0"}, 0.0)
    if "P" not in points.columns and {"modulus", "w"} <= {p.name for p in settings.free}:
        words = ("a and delta alone determine w/E* only: the moduli of the case are kept",)
        fixed["modulus"] = 1.0
    parameters = (replace(p, free=False, value=fixed[p.name]) if p.name in fixed else p for p in settings.parameters)
    settings = replace(settings, parameters=tuple(parameters))
    edges = set() if points.edges is None else set(points.edges)
    settings = settings.of_a_cycle(ADVANCING in edges) if RECEDING in edges else settings
    return Prepared(curve, points, settings, requested, (*curve.flags[len(original.flags) :], *words))


def _fit(
    body: FittedBody, curve: Curve, settings: Settings, pool: Pool | None
) -> Flow[tuple[Fit, tuple[ForceCurve, ForceCurveFit] | None]]:
    """The fit of a curve; of a raw record also what was fitted, and the fit of all its directions."""
    ready = yield from preparing(body, curve, settings)
    if not isinstance(ready, ForceCurve):
        return (yield from _of_table(body, ready, pool)), None
    fitted, record, best = yield from fit_settled(body, ready, settings, pool)
    return fitted, (record, best)


def _of_table(body: FittedBody, ready: Prepared, pool: Pool | None) -> Flow[Fit]:
    curve, points, settings, words = ready.curve, ready.points, ready.settings, ready.words
    edges, zero = set() if points.edges is None else set(points.edges), settings.known("P0")
    minimum = robust(search(body, points, settings), settings.loss)
    left, sharp = list[str](), None
    if settings.range is not None:
        nothing: JKRBeside | Unknown = Unknown("it cannot be computed here")
        compared = partial(jkr_comparison, minimum, body, points, settings)
        sharp = attempted("JKR beside the range", compared, nothing, left)
    try:
        confidence = confidence_of(minimum, settings, sharp, pool)
    except Exception as error:
        left.append(left_out(f"intervals by {settings.confidence}, and uncertain inputs", error))
        confidence = confidence_of(minimum, replace(settings, confidence="covariance", uncertain={}))
    alternatives = TableAlternatives((), 1.0)
    if settings.range is None and minimum.least.ended:
        of = partial(alternatives_of, minimum, confidence.scatter**2, confidence.dof, settings)
        alternatives = attempted("alternative models", of, alternatives, left)
    flags = {name: line for name, line in flags_of(curve).items() if curve.stiffness is not None or SET in name}
    free = minimum.objective.unknowns.names
    estimates = _resting(minimum, alternatives.with_parts(confidence.estimates))
    undetermined = any(item.name in free and item.low is None and item.high is None for item in estimates)
    distances = minimum.distances
    readings, a = distances.readings, distances.a
    if isinstance(readings.member, DugdaleCurve):
        readings.member.refuse_beyond(float(a.max()))
    result = Fit(
        name=curve.name, file="" if curve.origin is None else str(curve.origin), where=curve.where,
        estimates=estimates, free=free, covariance=confidence.covariance, samples=confidence.samples,
        data=points.values, rows=points.rows, left_out=points.left_out, a=a, residuals=distances.residuals,
        scales=dict(zip(points.columns, map(float, readings.scales), strict=True)), scatter=confidence.scatter,
        dof=confidence.dof, structure=structure(distances.residuals[-1][distances.along]), line=distances.line(),
        evaluations=minimum.least.steps, settings=settings, flags=(*flags, *["not determined"] * undetermined),
        jkr=sharp, range_left=None if alternatives.range is None else alternatives.range.most,
    )  # fmt: skip
    remarks = partial(
        warnings_of, result, minimum.objective.body, readings.members.plain, minimum.at_bound, alternatives,
        minimum.least.ended,
    )  # fmt: skip
    checks = attempted("remarks on the fit", remarks, list[str](), left)
    on_record = [f"{name}: {sentence}" for name, sentence in flags.items()]
    if "no base line" in flags and not zero.free and not zero.value:
        on_record.append("no base line: the zero of the load is set to 0 (--free P0, or --zero P=... if known)")
    words = (*words, *[RESTS] * (ADVANCING in edges and "w" not in free))
    result = replace(result, warnings=(*on_record, *words, *left, *checks))
    if edges == {ADVANCING}:  # alone, whose w is called w_approach: w is that of a retraction
        estimates = tuple(replace(item, name=OWN.get(item.name, item.name)) for item in result.estimates)
        return replace(result, estimates=estimates, free=tuple(OWN.get(name, name) for name in result.free))
    if ADVANCING not in edges or not _apart(minimum, confidence.scatter):
        return result

    def of_each() -> Fit:
        into, back = (alone(_fit(body, curve, replace(ready.requested, segment=kind), pool))[0] for kind in EDGES)
        moduli = [one.estimate("E_star") for one in (into, back)]
        error = math.hypot(*((item.error or 0.0) / item.value for item in moduli))
        return beside(back, into, result) if differ(moduli[0].value, moduli[1].value, error) else result

    return (yield from later(result, "each direction by its own modulus", of_each))


def _apart(minimum: Minimum, scatter: float) -> bool:
    """Whether the rows of a cycle ask for another modulus on the way back than on the way in: by one step of Gauss and
    Newton with a modulus for each; ``scatter`` of the residuals."""
    objective, distances = minimum.objective, minimum.distances
    names = objective.unknowns.names
    if "modulus" not in names:
        return False
    assert objective.points.edges is not None
    jacobian, back = distances.jacobian(names), objective.points.edges != ADVANCING
    own = jacobian[:, names.index("modulus")] * np.tile(back, distances.residuals.shape[0])
    matrix = np.column_stack([jacobian, own])
    spread = covariance(matrix, scatter**2)
    step = np.linalg.lstsq(matrix, -distances.residuals.ravel(), rcond=None)[0]
    return spread is not None and differ(1.0, 1 + float(step[-1]), math.sqrt(spread[-1, -1]))


def _resting(minimum: Minimum, estimates: tuple[FittedValue, ...]) -> tuple[FittedValue, ...]:
    """The estimates; w of an edge that rests in all rows of the way back is at least what the last of them holds."""
    edges = minimum.objective.points.edges
    if edges is None or RECEDING in edges:
        return estimates
    modulus, part = minimum.values["modulus"], minimum.distances.at(RESTING)
    member = part.readings.member
    assert isinstance(member, RestingMember)
    least = modulus * (member.unit * float(part.u.max())) ** 2
    return tuple(FittedValue("w", least, True, "work", None, least) if item.name == "w" else item for item in estimates)


# --------------------------------------------------------------------------------------------------
# Whether the surfaces slid or stuck: what it means for a fit, and what the data favour.

NAMES_OF_SURFACES = {"sliding": "frictionless contact", "sticking": "no slip"}

# When data prefer one assumption.
# Difference of Akaike's criterion, whose parameters are as many on both sides:
PREFERENCE_CLEAR = 10.0  # theory: odds of exp(5) (Burnham and Anderson 2002, Sec. 2.6)
PREFERENCE_LEAST = 0.02  # of the scatter; choice: smaller differences are those of the series and of the noise's shape


def preferences(results: Sequence[Fit | Failure]) -> Iterator[str]:
    """A sentence on each curve that was fitted under both assumptions: E*, w, and what the data prefer, if they do."""
    fits = [item for item in results if isinstance(item, Fit)]
    sticking = {(item.file, item.name): item for item in fits if item.surface == "sticking"}
    for one in fits:
        other = sticking.get((one.file, one.name))
        if one.surface == "sliding" and other is not None:
            each = (
                f"{NAMES_OF_SURFACES[item.surface]}: E* = {show(item.value('E_star'), 'modulus')}, "
                f"w = {show(item.value('w'), 'work')}"
                for item in (one, other)
            )
            yield f"{_preferred(one, other)}; {'; '.join(each)}: {one.where}"


def _preferred(sliding: Fit, sticking: Fit) -> str:
    """Which assumption residuals of the same rows prefer; those of the better fit count as fewer where they are
    autocorrelated."""
    both, name = (sliding, sticking), list(sliding.scales)[-1]
    first, second = (item.scatter * float(list(item.scales.values())[-1]) for item in both)  # in the same unit
    spreads = (show(spread, "load" if name == "P" else "length", 3) for spread in (first, second))
    scatter = f"scatter {' and '.join(spreads)} in {name}"
    if sliding.rows.size != sticking.rows.size or not (first > 0 and second > 0):
        return f"the data do not compare them ({scatter})"
    better = sliding if first < second else sticking
    lag = min(max(better.structure.lag1, 0.0), 0.99)
    difference = 2 * better.dof * (1 - lag) / (1 + lag) * math.log(first / second)
    if abs(difference) < PREFERENCE_CLEAR or abs(first / second - 1) < PREFERENCE_LEAST:
        return f"the data do not decide ({scatter})"
    name = NAMES_OF_SURFACES[better.surface]
    return f"the data favour {name} ({scatter}; Akaike's criterion lower by {abs(difference):.0f})"


def friction_warnings(body: FittedBody, results: Sequence[Fit | Failure]) -> Iterator[str]:
    """What the assumption on the surfaces matters at the largest radius of the data."""
    fits = [item for item in results if isinstance(item, Fit) and item.a.size]
    if not fits:
        return
    values = {item.name: item.value for item in fits[0].estimates}
    works = [values["w"]] if "w" in values else []
    problem = body.problem.scaled(values.get("modulus", 1.0))
    effect = sticking_effect(problem, max(float(item.a.max()) for item in fits), works)
    for warning in sticking_warnings(problem, effect):
        yield f"{warning}; jkr fit --surface both fits either"


# --------------------------------------------------------------------------------------------------
# Which further measurement would narrow E* and w most: another tip radius, largest load or thickness of the layer.
#
# A measurement that is not yet made has a Fisher information already: that of the curve which the fitted values
# predict, with as many rows and the noise of the one at hand, at the cost of its own contact point and force offset
# (their Schur complement); scaled so that the measurement at hand, repeated, has the information that it has now. Added
# to what is known, it gives the standard errors that both would have together, to first order.

WANTED = ("modulus", "w")
ZEROS = ("delta0", "P0")

# Which measurements are proposed.
PLAN_RADII = (0.25, 0.5, 2.0, 4.0)  # choice: over that at hand
PLAN_FACTORS = (0.3, 3.0)  # choice: loads and thicknesses over those at hand
PLAN_WIDEST = 0.4  # choice: of a tip's radius, to which it is pressed at most


def further(body: FittedBody, fit: Fit) -> tuple[Further, ...]:
    """The errors now, and those with the same measurement again and with others; InputError where the data do not
    determine E* and w."""
    if fit.covariance is None or not set(WANTED) <= set(fit.free) or fit.value("w") <= 0:
        raise InputError(f"{fit.where}: --plan: needs E* and w free and determined by the data")
    wanted = [fit.free.index(name) for name in WANTED]
    now = np.linalg.inv(fit.covariance[np.ix_(wanted, wanted)])
    largest = float(np.max(fit.line["P"][fit.line["a"] > 0])) - fit.value("P0")
    scale = np.linalg.cholesky(now) @ np.linalg.inv(np.linalg.cholesky(_information(body, fit, largest)))
    measurements = [_further("now", now, fit), _further("the same again", 2 * now, fit)]
    for words, changes, load in _candidates(body, fit, largest):
        with contextlib.suppress(JkrError):  # a body that cannot be solved is no proposal
            more = scale @ _information(body.with_values(dict(changes)), fit, load) @ scale.T
            measurements.append(_further(words, now + more, fit))
    return tuple(measurements)


def planned(body: FittedBody, fit: Fit) -> Fit:
    """The fit with the errors that further measurements would leave; a warning where they are not known."""
    try:
        return replace(fit, plan=further(body, fit))
    except InputError as error:
        return replace(fit, warnings=(*fit.warnings, str(error)))
    except Exception as error:
        return without(fit, "further measurements", error)


def _candidates(body: FittedBody, fit: Fit, largest: float) -> Iterator[tuple[str, Values, float]]:
    """Measurements in words, changes of the body, and their largest load [N]."""
    for factor in PLAN_FACTORS:
        yield f"largest load {show(factor * largest, 'load', 3)}", {}, factor * largest
    if not body.own_parameters:
        return
    if hasattr(body.problem.indenter, "R"):
        for factor in PLAN_RADII:
            R = factor * body.nominal(RADIUS)
            yield f"tip radius {show(R, 'length', 3)}", {RADIUS: R}, largest
    for name in [name for name in body.own_parameters if name.startswith("h:")][:1]:
        h = next((item.value for item in fit.estimates if item.name == name), body.nominal(name))
        for factor in PLAN_FACTORS:
            yield f"thickness {show(factor * h, 'length', 3)}", {name: factor * h}, largest


def _further(words: str, information: Array, fit: Fit) -> Further:
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    return Further(words, *(float(e) / fit.value(name) for e, name in zip(errors, WANTED, strict=True)))


def _information(body: FittedBody, fit: Fit, largest: float) -> Array:
    """Fisher information of modulus factor and w [SI] in a measurement on this ``body`` up to a load [N]."""
    columns = tuple(name for name in COLUMNS if name in fit.data)
    values = {item.name: item.value for item in fit.estimates} | dict.fromkeys(ZEROS, 0.0)
    both = "w_approach" in values and "w_approach" in fit.free
    own = [name for name in ZEROS if name in fit.free and not (name == "P0" and fit.sizes)]  # of a base line
    body, ways = _ways(body, values, both, largest, int(np.count_nonzero(fit.a > 0)))
    values["a_turn"] = float(np.exp(ways[ADVANCING if both else RECEDING].max()))
    names, values = [*WANTED, *own, *["w_approach", "a_turn"] * both], {"compliance": 0.0} | values
    parts = [(Readings(body.family, values, columns, np.ones(len(columns)), None, edge), u)
             for edge, u in ways.items()]  # fmt: skip
    # Standard deviations of the readings [SI]; of positions without scatter next to none
    noise = {name: scale * fit.scatter for name, scale in fit.scales.items()}
    spans = dict(zip(columns, np.ptp(np.hstack([part.along(u)[0] for part, u in parts]), axis=1), strict=True))
    least = UNSEEN * max(noise.get(name, 0.0) / spans[name] for name in columns)
    scales = np.array([noise.get(name, least * spans[name]) for name in columns])

    # Rows that lie on the curve
    feet = []
    for part, u in ((replace(part, scales=scales), u) for part, u in parts):
        first = part.along(u)[1]
        feet.append(
            FootPoints(part, np.arange(u.size), u, np.zeros((1, u.size)), first / np.linalg.norm(first, axis=0))
        )
    J = np.concatenate([Distances((part,)).jacobian(names) for part in feet])
    J[:, 0] /= values["modulus"]  # from its log
    size = np.linalg.norm(J, axis=0)
    whole = (J / size).T @ (J / size)
    cross = whole[:2, 2:]
    return (whole[:2, :2] - cross @ np.linalg.pinv(whole[2:, 2:]) @ cross.T) * np.outer(size[:2], size[:2])


def _ways(
    body: FittedBody, values: Values, both: bool, largest: float, rows: int
) -> tuple[FittedBody, dict[int, Array]]:
    """The body solved as far as it is pressed, and the places of rows even in displacement, for each thing that the
    edge does: in to the largest load and out to the pull-off under load, or out alone."""
    s, works = values["modulus"], [values[name] for name in ["w_approach"] * both + ["w"]]
    body, into = _branch(body, s, works[0], largest)
    if not both:
        return body, {RECEDING: _even(body, s, works[0], into, rows)}
    turn, (D, T, _, _) = into[1], body.family.at(into[1:])[0][:, 0]
    unit, ends = float(D / T), [math.sqrt(w / s) for w in works]
    out = np.array([_branch(body, s, works[1], largest)[1][0], turn])
    delta = body.family.member({"modulus": s, "w": works[1]}).along(out)[0][1]
    spans = [float(T) * abs(ends[1] - ends[0]), float(np.ptp(delta))]
    still = max(round(rows / 2 * spans[0] / sum(spans)), 2)
    return body, {
        ADVANCING: _even(body, s, works[0], into, rows // 2),
        RESTING: np.linspace(ends[0], ends[1], still) / unit,
        RECEDING: _even(body, s, works[1], out, max(rows // 2 - still, 2)),
    }


def _branch(body: FittedBody, s: float, w: float, largest: float) -> tuple[FittedBody, Array]:
    """The body solved as far as it is pressed, and the logs of the contact radii at pull-off under load and there."""
    R = body.problem.indenter.tip_radius
    for _ in range(2):
        high = math.log(PLAN_WIDEST * R) if R is not None and body.extensible else body.family.high
        u = np.linspace(min(body.family.low, high - 5), high, LOOKED_AT)
        P = body.family.member({"modulus": s, "w": w}).along(u)[0][2]
        low = int(np.argmin(P))
        end = float(np.interp(largest, P[low:], u[low:]))
        if not body.extensible or end <= body.family.high:
            break
        body = body.to_radius(ROOM * math.exp(end))
    return body, np.array([u[low], end])


def _even(body: FittedBody, s: float, w: float, ends: Array, rows: int) -> Array:
    """Logs of contact radii of so many rows, even in displacement."""
    u = np.linspace(ends[0], ends[1], LOOKED_AT)
    delta = body.family.member({"modulus": s, "w": w}).along(u)[0][1]
    return np.interp(np.linspace(delta[0], delta[-1], rows), delta, u)

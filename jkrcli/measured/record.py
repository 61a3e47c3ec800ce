"""The fit of a whole raw record with its verdict, and of its directions alone where one modulus does not describe
both."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..base.errors import InputError, SolveError, Unknown, known
from ..base.executors import Pool
from ..base.numerics import FEWEST_ROWS, HALF_WIDTH, MOST_SOLVES, MOST_STEPS, ROUNDED, SAME, TINY, UNSEEN, Array
from ..base.units import show
from ..base.wings import offered
from ..bodies.problem import Problem
from ..methods.radii import ROOM
from .alternative_fits import fall_of, fit_alternatives, record_alternatives, with_free_range, with_range_of
from .checks import warnings_of
from .choices import Values
from .curve import APPROACH, RETRACT, TURNED, Curve
from .fitted_record import FittedRecord, Known
from .force_curve import (
    FIT_BLUNT,
    FIT_ENOUGH,
    TIMED,
    ForceCurveFit,
    ForceCurveModel,
    base_line,
    fitting,
    held_by_last_row,
    nearest,
    roughly,
    stretches,
    windowed,
)
from .forward_model import FittedBody
from .free_rows import WAVE, Term
from .grade import LEFT_OUT, NO_CHANGE, UNDETERMINED, UNEXPLAINED, change_words, is_misfit, left_out, misfits
from .hypotheses import amount_of_range, finite_range, range_of
from .least_squares import Intervals, Least, State, bootstrap, covariance_coloured, structure, t_quantile, wider
from .lockstep import Flow, alone
from .model_changes import AMOUNT, OF_ALTERNATIVES
from .parameters import LIMIT, LINEAR, LOG, POSITIONS, ROOT, FittedValue, Parameter, changes_by, dimension_of
from .result import Fit, JKRBeside, later, without
from .rows import noise_from_third_differences
from .score_tests import SCORE_DIGITS, SCORE_TIED, FittedAlternative, RecordAlternatives, Verdict, relative_errors
from .segmentation import PERMANENT_SET, Direction, ForceCurve, examined
from .settings import AUTO, CALIBRATED, RANGES, Settings

# --------------------------------------------------------------------------------------------------
# What a force curve would make of one more unknown: one step of Gauss and Newton from the end of its fit.


@dataclass(frozen=True, eq=False)
class AddedParameter:
    """One step of Gauss and Newton from a fit with one more unknown, by which loads change by a ``column`` [N]: the
    ``step`` of all unknowns, the new one last, whose ``size`` is in standard errors of white noise."""

    fit: ForceCurveFit
    column: Array
    step: Array
    size: float

    @classmethod
    def of(cls, fit: ForceCurveFit, column: Array) -> AddedParameter:
        """By the products of weighted columns."""
        *own, r = fit.weighted
        J = np.array([*own, fit.model.whitened(column, fit.spread.noise)])
        scale = np.linalg.norm(J, axis=1)
        scale[scale == 0] = 1.0
        inverse = np.linalg.pinv(J @ J.T / (scale[:, None] * scale), rcond=SCORE_DIGITS, hermitian=True)
        step = -(inverse @ (J @ r / scale)) / scale
        return cls(fit, column, step, abs(float(step[-1] * scale[-1])) / math.sqrt(max(float(inverse[-1, -1]), TINY)))

    @property
    def last(self) -> float:
        """The step of the new unknown."""
        return float(self.step[-1])

    @cached_property
    def error(self) -> float:
        """Its standard error."""
        model, weight = self.fit.model, self.fit.weight
        off, J = model.residuals(self.fit.x, 0.0)
        J = np.column_stack([J, self.column])
        spread = covariance_coloured(model.ordered(off + J @ self.step, weight), model.ordered(J, weight), (), weight)
        return math.sqrt(max(spread.covariance[-1, -1], 0.0))


def another_modulus(fit: ForceCurveFit) -> AddedParameter:
    """Change of ln s on the way back against the way in that the data need: one step of a search with a modulus for
    each direction."""
    off, J = fit.model.residuals(fit.x, 0.0)
    back = np.arange(off.size) >= fit.model.stretches[0].P.size
    return AddedParameter.of(fit, J[:, fit.names.index("ln_s")] * back)


# --------------------------------------------------------------------------------------------------
# What a fit of a raw record says of itself: flags, quality, sentences.

# What raises a flag.
FLAG_MISFIT = 0.03  # choice: residual over the range of the load above which the model does not describe it
FLAG_VAGUE = 0.1  # choice: noise over the range, error of the contact point over the depth: little is known
FLAG_DEPENDENT = 2.0  # choice: rows worth one above which a warning tells
FLAG_SURE = 3.0  # choice: standard errors of w below 0, or of a drift, that are no noise
FLAG_EXCESS = 4.0  # choice: of the standard errors, what misfit would add to them where its flag is raised


RESTS = "w: the contact line is pinned in all rows of the retraction: a lower limit, from the last row"
NAMES = {APPROACH: APPROACH, RETRACT: "retraction"}

GIVEN_UP = "the search stopped after {} steps, the rows do not determine the unknowns: fix one (--fix w=...)"


def judgement(record: ForceCurve, best: ForceCurveFit) -> tuple[dict[str, str], dict[str, float]]:
    """Flags of the fit itself with a sentence each, and the sizes of its misfit."""
    span = max(part.span for part in best.model.stretches)
    noise = max(record_side.base.noise for record_side in record.directions)
    depth = max(part.reach for part in best.model.stretches)
    contact = best.error("z0") / depth if "z0" in best.names else 0.0
    sizes, flags = misfits(best, noise), {} if best.ended else {UNDETERMINED: GIVEN_UP.format(best.least.steps)}
    if sizes["misfit"] > FLAG_MISFIT or (best.spread.excess - 1 > FLAG_EXCESS and is_misfit(sizes)):
        free, touching = (np.append(best.off[rows] ** 2, 0.0).mean() for rows in (best.a == 0, best.a > 0))
        flags["misfit"] = (
            f"the residuals are {sizes['misfit']:.2%} of the range of the load, {best.spread.excess:.0f} "
            "times what the noise of the free rows explains: "
            + ("no line describes the free rows" if free > touching else "another body, indenter or adhesion")
        )
    if noise / span > FLAG_VAGUE:
        flags["noisy"] = f"the noise is {noise / span:.0%} of the range of the load"
    if contact > FLAG_VAGUE:
        flags["vague contact point"] = f"known to {contact:.0%} of the depth only"
    return flags, sizes


def sentences(best: ForceCurveFit, settings: Settings) -> Iterator[str]:
    """How the record was taken, and what its residuals did to the intervals."""
    if settings.base_line == "sine" and wave_of(best.model) is None:
        yield "base line: no sine beyond its noise, a straight line is used"
    if [part.kind for part in best.model.stretches] == [APPROACH]:
        yield "approach alone: its w is w_approach; w, that of the retraction, stays empty"
    if f"q:{RETRACT}" in best.model.known:
        yield RESTS
    free = [parameter.name for parameter in settings.free]
    for kind in (part.kind for part in best.model.stretches if best.model.works.get(part.kind) == 0 and "w" in free):
        yield f"{NAMES[kind]}: w would be negative and is set to 0: check body and indenter"
    if any(name.startswith("offset:") for name in best.model.known):
        yield "no base line: the zero of the load is set to 0 (--free P0, or --zero P=... if known)"
    model = best.model
    timed = all(np.ptp(part.t) > 0 for part in model.stretches)
    if timed and len(model.stretches) > 1 and "drift" not in model.positions:
        # of z0 [m/s], one step of a search that knows it
        t = np.concatenate([part.t for part in model.stretches])
        drift = AddedParameter.of(best, -t * model.by_position(best.x))
        if drift.size > FLAG_SURE and abs(drift.last) > FLAG_SURE * drift.error:
            change = float(drift.step[best.names.index("ln_s")]) if "ln_s" in best.names else 0.0
            half = show(HALF_WIDTH * drift.error, "speed", 2)
            yield (
                f"drift: the depth drifts by {show(drift.last, 'speed', 3)} ± {half}, which "
                f"would change the moduli by {change:+.2%}: --free drift fits it"
            )
    if not all(part.line.rows for part in best.model.stretches):
        yield "no free rows: noise cannot be separated from misfit"
    if best.spread.tau > FLAG_DEPENDENT:
        yield (
            f"residuals are autocorrelated (effective sample size n/{best.spread.tau:.1f}), "
            f"which widens the intervals by {math.sqrt(best.spread.tau):.1f}"
        )


# --------------------------------------------------------------------------------------------------
# What alternative models make of a fit: flags, warnings, the systematic parts, and the formula beside it.

REJECTED, DIFFER = "model rejected", "directions differ"
OF_DEVICE = "stiffness of the cantilever"  # an alternative by which the loads change too

# When alternatives leave nothing determined.
# choice: share of E* and of w that alternatives may move it by, above which it is flagged: a half, of which an
# approach tells no more where adhesion may have a range
VERDICT_LARGE = 0.5

# choice: share of E* and of w that they are unknown by at least where the model is rejected: one step is of first order
VERDICT_LEAST = (0.002, 0.01)


def attach_verdict(result: Fit, body: FittedBody, fit: ForceCurveFit, curve: Curve) -> Flow[Fit]:
    """The result with its verdict: that of a ``fit`` of all directions of the record, whose rows are the ``curve``."""
    settings = result.settings
    told = math.isfinite(settings.range_at_most)
    record = FittedRecord(body, fit, Known(settings.longest_range, settings.tension_at_most, settings.level, told))
    remarks = list[str]()

    def with_size(scores: RecordAlternatives) -> RecordAlternatives:
        # Neither the misfit nor what those that are named would change has a size, as in readings without noise
        changes = [one.change(name) for one in scores.named for name in ("E_star", "w")]
        if not changes or is_misfit(result.sizes or {}) or max(map(abs, changes)) > NO_CHANGE:
            return scores
        names = ", ".join(f"{one.name} ({one.change('E_star'):+.2%})" for one in scores.named)
        remarks.append(f"a negligible misfit would be removed by (change of E*): {names}")
        return scores.undecided()

    alternatives = yield from record_alternatives(record, with_size)
    over_time, answer = offered("relaxation under adhesion"), None
    if over_time:
        alternatives, answer, words = over_time(record, curve, alternatives, UNEXPLAINED in result.flags)
        remarks += [words] * bool(words)
    new = {name: sentence for name, sentence in _flags(alternatives, fit) if name not in result.flags}
    moves = left_out(record)
    if E_star_approach := next((item.value for item in result.estimates if item.name == "E_star_approach"), None):
        moves["E_star"] = abs(E_star_approach / result.value("E_star") - 1)
    if not is_misfit(misfits(fit, fit.model.noise)):
        alternatives = replace(alternatives, excess=1.0)
    here, stated = outcome_of(fit, fit.x, body), {"E_star": result.estimate("modulus"), "w": result.work}
    alternatives = alternatives.told_of({
        name: here[item.name] / item.value for name, item in stated.items() if item.value > 0 and here[item.name] > 0
    })  # fmt: skip
    estimates = tuple(_with_part(item, alternatives, moves) for item in result.estimates)
    sizes = {**(result.sizes or {}), **{f"{name}_by_direction": size for name, size in moves.items()}}
    warnings = tuple(f"{name}: {sentence}" for name, sentence in new.items())
    verdict = Verdict(alternatives, *_by_formula(body.problem, fit), answer=answer)
    return replace(
        result, estimates=estimates, sizes=sizes, flags=(*result.flags, *new), verdict=verdict,
        warnings=(*warnings, *remarks[:1], *result.warnings),
    )  # fmt: skip


def replace_by_best_alternative(
    plain: Fit, body: FittedBody, fit: ForceCurveFit, models: Sequence[ForceCurveModel],
    result_of: Callable[[ForceCurveFit], Fit],
) -> Fit:  # fmt: skip
    """The result by the best of the alternatives that are taken, where the data favour one; ``result_of`` a fit of the
    record. The systematic part holds what is tied with it."""
    verdict = plain.verdict
    if verdict is None or not verdict.alternatives.named:
        return plain
    full = fit_alternatives(FittedRecord(body, fit), models, verdict.alternatives)
    verdict = replace(verdict, fitted=tuple(one for one, _ in full)).with_answer
    if not verdict.tied:
        return replace(plain, verdict=verdict)
    taken, answer = {one.name for one in verdict.tied}, verdict.answer
    results = {one.name: result_of(found) for one, found in full if one.name in taken}
    if answer is not None and answer.alternative.name in taken:
        results[answer.alternative.name] = answer(result_of(fit), fit)
    result = results[verdict.tied[0].name]
    estimates = tuple(_with_ties(item, verdict.tied, results) for item in result.estimates)
    return replace(result, estimates=estimates, verdict=verdict)


def _with_ties(item: FittedValue, tied: Sequence[FittedAlternative], results: Mapping[str, Fit]) -> FittedValue:
    """The estimate with what the farthest of those that are tied makes of it, or how far its interval reaches beyond
    this one's, where that is more; ``results`` by name."""
    of_modulus, best = _of_modulus(item), tied[0]
    if item.error is None or not (of_modulus or item.dimension == "work"):
        return item
    moves = {}
    for one in tied[1:]:
        shift = (one.E_star / best.E_star - 1) * item.value if of_modulus else one.w - best.w
        moves[one.name] = abs(shift)
        same = next((other for other in results[one.name].estimates if other.name == item.name), item)
        if item.low is not None and item.high is not None and same.low is not None and same.high is not None:
            moves[one.name] = max(abs(shift), item.low - same.low, same.high - item.high)
    moves |= dict(item.model or {})
    worst = max(moves, key=lambda name: moves[name], default="")
    return replace(item, model={worst: moves[worst]}) if worst else item


def _flags(alternatives: RecordAlternatives, fit: ForceCurveFit) -> Iterator[tuple[str, str]]:
    """Flags with a sentence each; a quantity whose interval is wider than what alternatives may change it by tells so
    itself."""
    if alternatives.named:
        names = ", ".join(f"{one.name} ({change_words(one.change('E_star'))})" for one in alternatives.named)
        each = "each of these" if len(alternatives.named) > 1 else "this"
        yield REJECTED, f"{each} would remove the misfit (change of E*): {names}"
    if alternatives.named and (one := alternatives.named[0]).of_directions:
        amount = f"{one.amount:+.1%} ± {one.quantile * one.error:.1%} ({one.amount_is})"
        yield DIFFER, f"approach and retraction favour {one.name} {amount}"
    work = "w_approach" if fit.model.stretches[-1].kind == APPROACH else "w"
    for quantity, symbol, error in zip(("E_star", "w"), ("E*", work), relative_errors(fit), strict=True):
        worst = alternatives.worst(quantity)
        if worst is not None and abs(worst[1]) > max(VERDICT_LARGE, HALF_WIDTH * error):
            yield f"{symbol} not determined", f"{worst[0]} may change it by {abs(worst[1]):.0%}"


def _with_part(item: FittedValue, alternatives: RecordAlternatives, moves: Values) -> FittedValue:
    """The estimate with what the worst alternative may move it by, what leaving out a direction does, and the scale of
    the loads: of a device whose stiffness or sensitivity errs, E* and w err with it; and with the misfit, as if it were
    noise, where no alternative explains it."""
    of_modulus = _of_modulus(item)
    if item.error is None or not (of_modulus or item.dimension == "work"):
        return item
    worst = alternatives.worst("E_star" if of_modulus else "w")
    if worst is not None:
        least = VERDICT_LEAST[not of_modulus] if alternatives.named else 0.0
        lowers = frozenset(worst[:1]) if worst[1] < 0 else frozenset[str]()
        item = replace(item, model={worst[0]: max(abs(worst[1]), least) * abs(item.value)}, lowers=lowers)
    scale = max((abs(one.amount) + one.quantile * one.error for one in alternatives.named if one.name == OF_DEVICE),
                default=0.0)  # fmt: skip
    parts = {LEFT_OUT: moves.get("E_star" if of_modulus else item.name, 0.0), "scale of the loads": scale}
    if not alternatives.named and item.low is not None and item.high is not None and item.value:
        parts[UNEXPLAINED] = (alternatives.excess - 1) * (item.high - item.low) / abs(2 * item.value)
    for name, move in parts.items():
        item = item.with_model(name, move * abs(item.value)) if move else item
    return item


def _of_modulus(item: FittedValue) -> bool:
    return item.dimension == "modulus" or item.name == "modulus"


def _by_formula(problem: Problem, fit: ForceCurveFit) -> tuple[str, float | None]:
    """E* by Hertz of a half-space, by JKR of one under a layered body, from the deepest row of the last direction."""
    R, part = problem.indenter.tip_radius, fit.model.stretches[-1]
    values = fit.model.values(fit.x)
    i = int(np.argmax(part.z))
    load = float((part.P + fit.off[-part.P.size :] - base_line(part, values)[0])[i])
    depth = float(fit.model.depth(part, values)[i]) - load / fit.model.k
    if R is None or depth <= 0:
        return "", None
    formula, adheres = ("a half-space formula", 1.0) if problem.layers else ("Hertz", 0.0)
    w = adheres * max(values[f"q:{part.kind}"], 0.0) * math.exp(values["ln_s"])
    return formula, half_space_modulus(load, depth, R, w)


def half_space_modulus(P: float, delta: float, R: float, w: float) -> float | None:
    """E* [Pa] of the half-space on which a paraboloid of radius ``R`` [m] stands at depth ``delta`` [m] under the load
    ``P`` [N] against the work of adhesion ``w`` [J/m^2] (JKR, Hertz without w); None where there is none."""
    if w == 0:
        return 3 * P / (4 * math.sqrt(R * delta**3)) if P > 0 else None

    def modulus(a: float) -> float:
        return 2 * math.pi * a * w / (a**2 / R - delta) ** 2

    def excess(a: float) -> float:
        E = modulus(a)
        return 4 * E * a**3 / (3 * R) - math.sqrt(8 * math.pi * w * E * a**3) - P

    from scipy.optimize import brentq

    # From the contact radius without adhesion, to where the depth is nothing beside a^2/R:
    touching = math.sqrt(R * delta)
    try:
        return modulus(touching * float(brentq(lambda x: excess(touching * x), 1 + ROUNDED, 1 / UNSEEN)))
    except ValueError:
        return None


# --------------------------------------------------------------------------------------------------
# Which curves are fitted as whole raw records, and which of their directions.

# When a record is taken as a whole.
WHOLE_RECORD_PLACED = 0.3  # choice: scatter of positions over that of loads, both over their range, of a table


PARAMETERS = frozenset({"modulus", "w", "delta0", "P0", *POSITIONS})  # of a whole record; others need prepared readings
FREE = (-math.inf, math.inf)
ZEROS = frozenset({"delta0", "P0", "compliance"})  # always fitted, or known by the stiffness of the device


def raw_force_curve(curve: Curve, settings: Settings) -> Flow[ForceCurve | None]:
    """The record taken apart, where base line and contact are to be fitted together; None: the readings as they are.

    By itself that is so for records of a device whose deflection is known, or of both directions with a base line each;
    without a base line the zero of the load is that of the file.
    """
    prepared = settings.contact == "as-is"
    only = [f"--base-line {settings.base_line}"] * (settings.base_line != "straight") + list(settings.positions)
    only += [f"--model {settings.model}"] * (settings.model == AUTO)
    required = settings.contact == "fitted" or bool(only)
    if prepared or curve.a is not None or curve.delta is None or curve.P is None:
        if required:
            what = next(iter(only), "--contact fitted")
            raise InputError(f"{what} is for raw force curves of displacement and load, with --contact fitted or auto")
        return None
    try:
        record = yield from examined(curve)
    except InputError:
        if required:
            raise
        return None
    if dent := record.flags.get(PERMANENT_SET):
        raise InputError(
            f"{curve.where}: {PERMANENT_SET}: {dent}: the specimen yields or flows, no elastic contact has such an "
            "unloading: measure below the load at which it begins to"
        )
    if not (required or _raw(record)):
        # Without a base line: that of a device, on which a contact line is pinned where it turns
        of_device = record.curve.stiffness is not None and record.directions and not beyond_the_record(settings)
        if settings.contact != "auto" or not of_device:
            return None
        _refuse_wrong_way(record)
        return record
    idle = [name for name in settings.uncertain if name in CALIBRATED and curve.stiffness in (None, math.inf)]
    if idle:
        raise InputError(
            f"{curve.where}: --uncertain {idle[0]}: the force curve has no stiffness, so it has no effect here"
        )
    _refuse_wrong_way(record)
    _check_positions(curve, settings)
    return record


def _refuse_wrong_way(record: ForceCurve) -> None:
    """InputError where the displacement counts the other way round; of a record without contact nobody can tell."""
    if (reason := record.flags.get("wrong way")) and "no contact" not in record.flags:
        if any(TURNED in flag for flag in record.curve.flags):  # --flip is of the sign in the file
            reason = reason.replace("--flip delta", "its sign was turned when it was read: --factor delta=-1")
        raise InputError(f"{record.curve.where}: wrong way: {reason}")


def _check_positions(curve: Curve, settings: Settings) -> None:
    """InputError where an error of positions is to be fitted that the record, or another option, does not determine."""
    for name in settings.positions:
        if settings.segment not in (None, "both"):
            raise InputError(f"{curve.where}: {name} needs approach and retraction together: leave --segment out")
        if name in TIMED and (curve.t is None or not np.ptp(curve.t) > 0):
            raise InputError(f"{curve.where}: {name} needs a column of time, there is none: leave {name} out")
        if beyond_the_record(settings):
            raise InputError(
                f"{curve.where}: {name} is fitted to whole force curves only, without compliance, "
                f"parameters of single layers, --branch, --noise, --start and --bound: leave out these or {name}"
            )


def _raw(record: ForceCurve) -> bool:
    """Whether it is an instrument's record, and no prepared readings: a base line is there, or no contact at all, and
    the scatter is in the load."""
    sides = [kind for kind in (APPROACH, RETRACT) if usable(record, kind)]
    delta, P = record.curve.device, record.curve.P
    assert P is not None
    placed, scattered = map(noise_from_third_differences, (delta, P))
    if placed * np.ptp(P) > WHOLE_RECORD_PLACED * scattered * np.ptp(delta):
        return False
    if len(sides) > 1 or (sides and record.curve.stiffness is not None):
        return True
    return len(record.directions) > 1 and bool({"no contact", "no force curve"} & set(record.flags))


def beyond_the_record(settings: Settings) -> bool:
    """Whether the settings have an option that the model of a whole record does not know."""
    named = any(p.name not in {*PARAMETERS, *RANGES} or p.value is not None for p in settings.free)
    bound = any(p.name != "modulus" and (p.low, p.high) != FREE for p in settings.free)
    fixed = any(p.name in ZEROS & settings.named and not p.free for p in settings.parameters)
    return named or bound or fixed or settings.branch != "all" or bool(settings.noise)


def usable(record: ForceCurve, kind: str) -> bool:
    side = record.direction(kind)
    if side is None or isinstance(side.touch, Unknown):
        return False
    return side.begins_free and side.base.rows >= FEWEST_ROWS and not _contact_left_out(record, side)


def _contact_left_out(record: ForceCurve, side: Direction) -> bool:
    """Whether no row of the contact of a direction counts."""
    return record.ignored.size > 0 and not isinstance(side.touch, Unknown) and not record.contact(side).size


def requested(settings: Settings) -> tuple[str, ...]:
    """The requested directions."""
    return (APPROACH, RETRACT) if settings.segment in (None, "both") else (str(settings.segment),)


def directions_of(record: ForceCurve, settings: Settings) -> tuple[str, ...]:
    """The directions to fit: those requested that can be fitted."""
    wanted = requested(settings)
    kinds = tuple(kind for kind in wanted if usable(record, kind))
    if not kinds and settings.contact == "auto" and record.curve.stiffness is not None:
        sides = filter(None, map(record.direction, wanted))
        kinds = tuple(side.segment.kind for side in sides if not _contact_left_out(record, side))
    if not kinds:
        reasons = [f"{kind}: {reason_not(record, kind)}" for kind in wanted]
        raise InputError(f"no direction can be fitted ({'; '.join(reasons)})")
    return kinds


def reason_not(record: ForceCurve, kind: str) -> str:
    """Why a direction cannot be fitted."""
    side = record.direction(kind)
    if side is None:
        return "not in the force curve"
    if isinstance(side.touch, Unknown):
        return side.touch.reason
    return "all its rows in contact are left out" if _contact_left_out(record, side) else "it has no base line"


# --------------------------------------------------------------------------------------------------
# The fit of a raw record as the result that every fit gives: what the unknowns mean, intervals, columns.

WORKS = {APPROACH: "w_approach", RETRACT: "w"}
DIMENSIONS = {
    "modulus": "number", "w": "work", "w_approach": "work", "delta0": "length", "P0": "load",
    "tilt": "stiffness", "wave_period": "length", "wave_amplitude": "load", **OF_ALTERNATIVES,
    **{name: dimension_of(name) for name in POSITIONS},
}  # fmt: skip


def wave_of(model: ForceCurveModel) -> Term | None:
    """The wave in the base lines of a model."""
    return next((term for term in model.stretches[0].terms if term.law == WAVE), None)


def outcome_of(best: ForceCurveFit, x: Array, body: FittedBody) -> dict[str, float]:
    """What the unknowns ``x`` mean, SI."""
    values = best.model.values(x)
    s = math.exp(values["ln_s"])
    last = best.model.stretches[-1]
    quantities = {"modulus": s} | {WORKS[part.kind]: values[f"q:{part.kind}"] * s for part in best.model.stretches}
    tilt = values[f"tilt:{last.kind}"]
    P0 = values[f"offset:{last.kind}"] + tilt * (values["z0"] - last.z[0])
    quantities |= {"delta0": values["z0"] - P0 / best.model.k, "P0": P0, "tilt": tilt}
    quantities |= {name: values[name] for name in best.model.positions}
    if (wave := wave_of(best.model)) is not None:
        cos, period, sin = (values[name] for name in wave.names)
        quantities |= {"wave_period": math.exp(period), "wave_amplitude": math.hypot(cos, sin)}
    quantities |= best.model.further(values)
    return quantities | body.moduli(s)


def as_fit(
    body: FittedBody, record: ForceCurve, curve: Curve, settings: Settings, best: ForceCurveFit, pool: Pool | None,
    jkr: JKRBeside | None = None, ranged: Sequence[FittedValue] = (),
) -> Fit:  # fmt: skip
    """The fit of a ``curve`` as every fit gives it; ``record``: less what its free rows hold; of one with a
    range of adhesion ``jkr`` beside it, and the range and tension that it is ``ranged`` by."""
    values = outcome_of(best, best.x, body)
    dof = max(best.off.size - best.x.size, 1)
    t = t_quantile(settings.level, max(round(best.spread.dof / best.spread.tau), 1))
    fixed = {item.name for item in settings.parameters if not item.free and item.name in settings.named}
    intervals = _intervals(body, best, settings, values, fixed, t, pool)
    carried = _carried(body, best, settings, values)
    plain = (_resting(item, best, t, intervals) for item in intervals.estimates())
    estimates = tuple(wider(item, {key: change[item.name] for key, change in carried.items()}, t) for item in plain)
    if not best.ended:
        estimates = tuple(replace(item, error=None, low=None, high=None) for item in estimates)
    others = ("E_star", *RANGES)
    estimates = (*estimates, *ranged)
    free = tuple(item.name for item in estimates if item.free and item.name not in others and ":" not in item.name
                 and (item.error is not None or item.name != WORKS[RETRACT]))  # fmt: skip
    a, order = best.a, np.argsort(best.model.rows, kind="stable")
    rows = best.model.rows[order]
    back = record.direction(RETRACT)
    flags, sizes = judgement(record, best)
    missing = [f"no {kind}" for kind in (APPROACH, RETRACT) if kind not in requested(settings)]  # nobody asked for it
    missing += ["no base line"] * all(part.line.rows > 0 for part in best.model.stretches)  # that of one left out
    flags = {name: words for name, words in record.flags.items() if name not in missing} | flags
    result = Fit(
        name=curve.name, file="" if curve.origin is None else str(curve.origin), where=curve.where,
        estimates=estimates, free=free, covariance=intervals.covariance_of(free) if best.ended else None,
        samples=intervals.sampled(free), data={"delta": curve.depth[rows], "P": curve.load[rows]}, rows=rows,
        left_out=_left_out(record, rows.size), a=a[order], residuals=best.off[order][None] / best.sigma,
        scales={"P": best.sigma}, scatter=1.0, dof=dof, structure=structure(best.off[a > 0]), line=line_of(best),
        evaluations=best.least.steps, settings=settings, flags=tuple(flags), sizes=sizes,
        adhesion=None if back is None else known(back.adhesion), directions=_directions(record, best, settings),
        jkr=jkr,
    )  # fmt: skip
    at_bound = ["modulus"] * any(math.isclose(values["modulus"], end, rel_tol=SAME) for end in best.model.moduli)
    result = replace(result, warnings=tuple(f"{name}: {sentence}" for name, sentence in flags.items()))

    def with_remarks() -> Fit:
        more = warnings_of(result, body, body.family, at_bound)
        return replace(result, warnings=(*result.warnings, *sentences(best, settings), *more))

    return alone(later(result, "remarks on the fit", with_remarks))


def _carried(body: FittedBody, best: ForceCurveFit, settings: Settings, here: Values) -> dict[str, dict[str, float]]:
    """Changes of the outcome by the standard deviation of each uncertain input."""

    def outcome(name: str, value: float) -> dict[str, float]:
        if name in CALIBRATED:
            moved, model = body, best.model.calibrated(value, name == "stiffness")
        else:
            moved = body.with_values({name: value})
            model = replace(best.model, family=moved.family)
        begin = best.at_loads(value if name in CALIBRATED else 1.0)
        again = alone(fitting(model, begin, near=True, loss=settings.loss))
        return outcome_of(again, again.x, moved)

    centres = {name: 1.0 if name in CALIBRATED else body.nominal(name) for name in settings.uncertain}
    return {
        name: changes_by(name, centres[name], sigma, here, partial(outcome, name))
        for name, sigma in settings.uncertain.items()
    }


def _intervals(
    body: FittedBody, best: ForceCurveFit, settings: Settings, here: Values, fixed: Container[str],
    t: float, pool: Pool | None,
) -> Intervals:  # fmt: skip
    """Intervals of the parameters at the outcome ``here``, of which some are ``fixed``."""
    # Moduli by their logs, w as it may come out below 0, an advancing one before an edge that rests by its signed root
    quantities = []
    for name in here:
        dimension, scale = DIMENSIONS.get(name, "modulus"), LINEAR
        if name == "modulus" or dimension == "modulus":
            scale = LOG
        elif dimension == "work":
            scale = ROOT if name == WORKS[APPROACH] and f"r:{APPROACH}" in best.names else LIMIT
        quantities.append(Parameter(name, True, scale=scale, quantity=dimension, follows=dimension == "modulus"))
    fixed_values = {name: value for name, value in here.items() if name in fixed}
    bent = [item for item in quantities if item.kind in (LOG, ROOT)]

    def meaning(x: Array) -> dict[str, float]:
        outcome = outcome_of(best, x, body) | fixed_values
        return outcome | {item.name: item.inner(outcome[item.name]) for item in bent}

    samples = None
    if settings.confidence == "bootstrap" and best.ended:
        cost = best.least.problem.converged
        samples = bootstrap(best.least, partial(_renewed, best), cost, settings.samples, settings.seed, pool)
    profiled = settings.confidence == "profile" and best.ended
    return Intervals(best.least, quantities, meaning, best.covariance, t, settings.level, profiled, samples=samples)


def _resting(item: FittedValue, best: ForceCurveFit, t: float, intervals: Intervals) -> FittedValue:
    """The estimate; w of an edge that rests throughout is a lower bound: what its last row holds, less ``t`` of its
    standard errors. Rows at rest go with the root of the w before: where that may be 0, its limit is by the profile."""
    rests = best.ended and best.model.edges(best.x)[-1][1] is not None
    if item.name == WORKS[APPROACH] and item.low == 0 and rests and f"r:{APPROACH}" not in best.names:
        return intervals.with_limit(item)
    if item.name != WORKS[RETRACT] or f"q:{RETRACT}" not in best.model.known:
        return item
    last = best.model.stretches[-1]

    def held(x: Array) -> float:
        values = best.model.values(x)
        resting = best.model.rest(last, values)
        return math.exp(values["ln_s"]) * held_by_last_row(best.model, values, resting) if resting else 0.0

    steps = np.diag([best.error(name) for name in best.names])
    rates = np.array([(held(best.x + step) - held(best.x - step)) / (2 * step.sum() or 1.0) for step in steps])
    error = math.sqrt(max(float(rates @ best.covariance @ rates), 0.0))
    low = max(_least_held(best, t) * item.value - t * error, 0.0)
    return FittedValue(item.name, item.value, True, item.dimension, None, low)


def _least_held(best: ForceCurveFit, t: float) -> float:
    """The least w of an edge that rests in all rows, over what its last row holds: it may recede in the last of them,
    if chi^2 rises by less than ``t`` squared, and to a fold that lies beyond."""
    own, part = f"q:{RETRACT}", best.model.stretches[-1]
    model = replace(best.model, known={name: value for name, value in best.model.known.items() if name != own})
    values = best.model.values(best.x)
    lost = float(best.model.depth(part, values)[part.touching].min())

    def chi2(q: float) -> float:
        off = model.off(model.unknowns({**values, own: q}), 0.0)
        return float(np.sum(model.whitened(off, best.spread.noise) ** 2))

    low, high, least = 0.0, values[own], chi2(values[own])
    for _ in range(MOST_STEPS):
        there = {**values, own: (low + high) / 2}
        moving, resting = model.branch(part, there), model.rest(part, there)
        recedes = moving.fold <= lost and resting is not None and resting.u > moving.u[0]
        low, high = (low, there[own]) if recedes and chi2(there[own]) - least < t**2 else (there[own], high)
        if high - low < UNSEEN * high:
            break
    return high / values[own]


def _renewed(best: ForceCurveFit, rng: np.random.Generator) -> Callable[[State], State]:
    """Records that the model and the noise of the free rows may have made: residuals as they are, with other noise."""
    rows = best.model.rows - best.model.rows.min()
    noise = best.spread.noise.drawn(rng, int(rows.max()) + 1)[rows]
    other = best.model.whitened(noise, best.weight) - best.least.state.residuals
    return lambda state: state.moved(other)


def line_of(best: ForceCurveFit) -> dict[str, Array]:
    """The fitted readings in one stroke, in by the first direction and out by the second: a, delta and P."""
    model = np.concatenate([part.P for part in best.model.stretches]) + best.off
    z = np.concatenate([part.z for part in best.model.stretches])
    first = best.model.stretches[0].z.size  # each direction goes from its far end inwards
    columns = {"a": best.a, "delta": z - model / best.model.k, "P": model}
    return {name: np.concatenate([each[:first], each[first:][::-1]]) for name, each in columns.items()}


def _left_out(record: ForceCurve, used: int) -> tuple[str, ...]:
    spikes, limits = record.spikes.size, record.saturated.size
    rest = len(record.curve) - used - spikes - limits
    ringing = sum(side.ringing for side in record.directions)
    return (
        *[f"{rest} rows of other segments, next to the reversal or in jumps"] * (rest > 0),
        *[f"{spikes} {'isolated outliers' if spikes > 1 else 'isolated outlier'}"] * (spikes > 0),
        *[f"{limits} saturated"] * (limits > 0),
        *[f"among them {ringing} in which the cantilever rings after a jump"] * (ringing > 0),
    )


def _directions(record: ForceCurve, best: ForceCurveFit, settings: Settings) -> str:
    """Which directions were fitted, and why another one was not."""
    kinds = [part.kind for part in best.model.stretches]
    if len(kinds) > 1:
        return f"{APPROACH} and {NAMES[RETRACT]}"
    other = RETRACT if kinds[0] == APPROACH else APPROACH
    why = f" ({NAMES[other]}: {reason_not(record, other)})" if settings.segment in (None, "both") else ""
    return f"{NAMES[kinds[0]]} alone{why}"


# When one modulus does not describe both directions, or the rows determine none.
RECORD_PLACED_ROWS = 0.05  # choice: of the loads' relative scatter, that of positions which have none
RECORD_APART = 4.0  # choice: standard errors between the moduli of the two directions from which on they differ
RECORD_UNDETERMINED = 1.0  # theory: of ln E*, a standard error with which 95 % span a factor of fifty
RECORD_HALF = 0.5  # choice: of the range of the load, from the largest on, over which a device's line is looked at
# theory: of the device's stiffness, what its line lacks beside a contact fifty times stiffer; choice: also the excess
# that an error of the deflection sensitivity may make
RECORD_RIGID = 0.02
RANGE_IN_LAYER = 0.1  # choice: of its thickness, a ring of attraction that is as on a half-space
RECORD_DIFFERS = 0.01  # choice: of a modulus, a difference that is none
# Where a search ends at rest in noise though the contact line opens: w of the retraction to begin anew with.
RECORD_RECEDES = (1.05, 1.2, 1.6)  # tuned on curves of large noise, by `make dirt`: of what its last row holds
RECORD_BEFORE = 0.4  # tuned on the same, by `make dirt`: of it, w of the approach


def fit_record(
    body: FittedBody, record: ForceCurve, settings: Settings, pool: Pool | None = None,
    begin: tuple[FittedBody, ForceCurveFit] | None = None,
) -> Flow[tuple[Fit, ForceCurveFit]]:  # fmt: skip
    """Modulus, w, contact point and base lines of a whole record, and the fit of all its directions; InputError where
    it holds no contact.

    Where one modulus does not describe both directions, the retraction's answer with that of the approach beside it.
    ``pool``: for the samples of its bootstrap; ``begin``: the body and the fit of all directions, where known.
    """
    if (reason := record.flags.get("no contact")) is not None:
        raise InputError(f"{record.curve.where}: no contact: {reason}")
    curve = record.curve
    body = _with_known(body, settings)
    kinds = directions_of(record, settings)

    def of(*kinds: str) -> Flow[tuple[FittedBody, ForceCurveFit]]:
        return _fitted(body, _model(body, record, settings, kinds), settings)

    def result_of(body: FittedBody, best: ForceCurveFit, *ranged: Any) -> Fit:
        plain = replace(settings, confidence="covariance", uncertain={})
        try:
            return as_fit(body, record, curve, settings, best, pool, *ranged)
        except Exception as error:
            if settings == plain:
                raise
            inputs = ["uncertain inputs"] * bool(settings.uncertain)
            what = " and ".join([f"intervals by {settings.confidence}", *inputs])
            return without(as_fit(body, record, curve, plain, best, pool, *ranged), what, error)

    whole, joint = begin or (yield from of(*kinds))
    if not joint.ended:
        return result_of(whole, joint), joint
    _refuse_undetermined(curve, joint)
    if settings.range is not None:
        fresh = _model(whole, record, settings, kinds)
        return _with_range(FittedRecord(whole, joint), fresh, settings, result_of), joint
    result = result_of(whole, joint)
    apart = partial(_of_directions, of, result_of, joint, result)
    result = yield from later(result, "each direction by its own modulus", apart)
    plain = yield from later(result, "alternative models", partial(attach_verdict, result, whole, joint, curve))
    if settings.model != AUTO:
        return plain, joint
    straight = [record.holding(record.held.straight)] if record.held is not None and record.held.bends else []
    models = [_model(whole, one, settings, kinds) for one in (record, *straight)]
    best = partial(replace_by_best_alternative, plain, whole, joint, models, partial(result_of, whole))
    return (yield from later(plain, "fits of alternative models", best)), joint


def _with_range(jkr: FittedRecord, fresh: ForceCurveModel, settings: Settings, result_of: Callable[..., Fit]) -> Fit:
    """The fit with the range of adhesion that the settings have, from that of ``jkr`` on, which it contains."""
    law, change = settings.range, finite_range(jkr)
    assert law is not None
    if change is None:
        raise InputError(f"adhesion of finite range needs w > 0, which JKR does not find here: leave {law.name} out")
    change, fresh = replace(change, quantities=lambda values: {}), replace(fresh, family=jkr.model.family)
    of_stress, known = law.name == "stress", float(law.value or 0.0)

    def work_of(best: ForceCurveFit) -> float:
        values = best.model.values(best.x)
        return max(values[f"q:{best.model.stretches[-1].kind}"], 0.0) * math.exp(values["ln_s"]) or jkr.work

    # The range with its ends: fitted, or known; of a known stress by the w that it leads to
    t, w = t_quantile(settings.level, max(jkr.residuals.size - jkr.fit.x.size, 1)), work_of(jkr.fit)
    near = list[ForceCurveFit]()
    if law.free:
        best, near = with_free_range(jkr, fresh, change)
        amount, error = best.value(AMOUNT), best.error(AMOUNT)
        z0, low, high = (range_of(jkr, max(one, 0.0)) for one in (amount, amount - t * error, amount + t * error))
        w = work_of(best)
    else:
        for _ in range(MOST_SOLVES):
            z0 = low = high = w / known if of_stress else known
            best = with_range_of(jkr, fresh, change, amount_of_range(jkr, z0))
            before, w = w, work_of(best)
            if not of_stress or abs(w / before - 1) < UNSEEN:
                break

    # Its ring of attraction is that of a half-space: pi E* z0^2/(4 w) wide, while that is narrow
    E_star, layer = math.exp(best.model.values(best.x)["ln_s"]) * jkr.body.problem.E_star, jkr.body.problem.specimen
    ring = math.pi * E_star * min(high, 1.0) ** 2 / (4 * w)
    if ring > RANGE_IN_LAYER * layer.top_thickness:
        raise InputError(
            f"adhesion of finite range reaches up to {show(ring, 'length')} beyond the contact, more than "
            f"{RANGE_IN_LAYER:.0%} of the layer, but is that of a half-space here: leave {law.name} out"
        )
    two_sided = law.free and low > 0 and math.isfinite(high)
    relative = (high - low) / (2 * t * z0) if two_sided else None
    ends = {"range": (low, high), "stress": (w / high, w / low if low else math.inf)}
    told = {name: [end if law.free and math.isfinite(end) else None for end in pair] for name, pair in ends.items()}
    ranged = [
        FittedValue(name, value, law.free, kind, relative and relative * value, told[name][0], told[name][1])
        for name, value, kind in (("range", z0, "length"), ("stress", w / z0 if z0 else math.inf, "modulus"))
        if math.isfinite(value)
    ]  # fmt: skip
    falls = fall_of(jkr, FittedRecord(jkr.body, best))
    values = outcome_of(jkr.fit, jkr.fit.x, jkr.body)
    beside_it = JKRBeside(jkr.E_star, work_of(jkr.fit), jkr.fit.sigma, best.sigma, falls / 2, values)
    result = result_of(jkr.body, best, beside_it, ranged)

    # What fits with other ranges that the data do not tell from it make of E* and w
    if near:
        q = f"q:{best.model.stretches[-1].kind}"
        logs = np.array([[v["ln_s"], math.log(max(v[q], TINY)) + v["ln_s"]] for v in (
            fit.model.values(fit.x) for fit in (best, *near))])  # fmt: skip
        moved = dict(zip(("E_star", "w"), np.max(np.abs(np.expm1(logs[1:] - logs[0])), axis=0).tolist(), strict=True))
        estimates = (one.with_model("range", moved[one.name] * one.value) if moved.get(one.name) else one
                     for one in result.estimates)  # fmt: skip
        result = replace(result, estimates=tuple(estimates))
    if falls > -SCORE_TIED:
        return result
    sentence = f"{REJECTED}: chi^2 is lower by {-falls:.0f} with adhesion of no range (JKR)"
    return replace(result, flags=(*result.flags, REJECTED), warnings=(sentence, *result.warnings))


def _refuse_undetermined(curve: Curve, joint: ForceCurveFit) -> None:
    """InputError where the rows determine no modulus: its error, or loads that rise faster than beside a rigid body."""
    if "ln_s" not in joint.names:
        return
    model, part, error = joint.model, joint.model.stretches[-1], joint.error("ln_s")
    top = part.P >= part.P.max() - RECORD_HALF * part.span
    depth = model.depth(part, model.values(joint.x))[top]  # less errors of positions, as far as they are fitted
    along = depth - depth.mean()
    squares = max(float(along @ along), TINY)
    rigid = (float(along @ part.P[top]) / squares - part.line.tilt) / model.k - 1  # how much steeper than the device
    unsure = RECORD_APART * joint.sigma / math.sqrt(squares) / model.k
    if error <= RECORD_UNDETERMINED and rigid < RECORD_RIGID + unsure:
        return
    other = "fit both directions, or " if len(joint.model.stretches) == 1 else ""
    reason = f"the rows in contact do not separate it from w and the contact point: {other}fix w (--fix w=...)"
    if rigid > -RECORD_RIGID:
        beside_it = f"compared with a cantilever of {show(model.k, 'stiffness')}"
        reason = f"{beside_it} the specimen is nearly rigid: check --stiffness and units"
    times = "" if error <= RECORD_UNDETERMINED else f"{error:.2g}" if error < 1000 else "more than 1000"
    times = f", its standard error is {times} times its value" if times else ""
    raise InputError(f"{curve.where}: E* is not determined{times}: {reason}")


def _of_directions(
    of: Callable[..., Flow[tuple[FittedBody, ForceCurveFit]]], result_of: Callable[[FittedBody, ForceCurveFit], Fit],
    joint: ForceCurveFit, result: Fit,
) -> Flow[Fit]:  # fmt: skip
    """The ``result`` of both directions by one modulus, or each by its own where they differ."""
    if len(joint.model.stretches) < 2 or joint.model.positions or "ln_s" not in joint.names:
        return result  # one direction alone tells no error of positions
    if joint.sigma <= FIT_ENOUGH * joint.model.noise:
        other = another_modulus(joint)  # which the data may need on the way back
        if not (differ(1.0, 1 + other.last, 0.0) and differ(1.0, 1 + other.last, other.error)):
            return result
    _, into = yield from of(APPROACH)
    deeper, back = yield from of(RETRACT)
    error = math.hypot(*(one.error("ln_s") * one.spread.excess for one in (into, back)))
    if not differ(math.exp(into.value("ln_s")), math.exp(back.value("ln_s")), error):
        return result
    return beside(result_of(deeper, back), result_of(deeper, into), result)


def whole_fit(body: FittedBody, record: ForceCurve, settings: Settings) -> ForceCurveFit:
    """What leaves least of all directions of a record."""
    return alone(fitted_whole(body, record, settings))[1]


def fitted_whole(
    body: FittedBody, record: ForceCurve, settings: Settings, begin: Values | None = None
) -> Flow[tuple[FittedBody, ForceCurveFit]]:
    """The same as a flow, with the body solved as far as it reaches; searched from values of its unknowns, if these are
    about known."""
    body = _with_known(body, settings)
    return (yield from _fitted(body, _model(body, record, settings, directions_of(record, settings)), settings, begin))


def about_whole(
    body: FittedBody, record: ForceCurve, settings: Settings, near: ForceCurveFit
) -> Flow[dict[str, float] | None]:
    """About the values of the unknowns that leave least of a few rows, from the fit of a record that differs little on,
    none where it lacks some; None where they leave more than that by so much that the record is excluded."""
    model = _model(body, record, settings, directions_of(record, settings))
    few = replace(model, family=near.model.family).few
    values = few.by_terms | near.model.values(near.x)
    if not values.keys() >= set(few.names):
        return {}
    ends = yield from roughly(few, few.unknowns(values), FIT_BLUNT[1:2])
    for end in ends:
        there, here = few.off(end.x, FIT_BLUNT[1]), near.model.few.off(near.x, FIT_BLUNT[1])
        if there @ there / there.size <= FIT_ENOUGH**2 * (here @ here) / here.size:
            return few.values(end.x)
    return None if ends else {}


def _with_known(body: FittedBody, settings: Settings) -> FittedBody:
    """The body with the known values of its layers."""
    return body.with_values({p.name: float(p.value) for p in settings.parameters if p.of_body and p.value is not None})


def receding_rows(body: FittedBody, curve: Curve, settings: Settings) -> Curve:
    """The rows of a raw record's last direction on which the edge of the contact moves, less the base line and from the
    zero that fit best; a curve that is no raw record, or has no base line, as it is."""
    record = alone(raw_force_curve(curve, settings))
    if record is None or not any(usable(record, kind) for kind in requested(settings)):
        return curve
    best = whole_fit(body, record, settings)
    curve = _in_contact(best, curve, receding=True)
    return replace(curve, delta=curve.depth - curve.load / best.model.k)


def _in_contact(best: ForceCurveFit, curve: Curve, receding: bool = False) -> Curve:
    """The rows in contact, or of the last direction those on which the edge is ``receding``, in order of recording: net
    load over the position of the device from first touch."""
    values, each = best.model.values(best.x), []
    for part, (a, rests) in list(zip(best.model.stretches, best.radii, strict=True))[-1 if receding else 0 :]:
        chosen = (a > 0) & ~rests if receding else a > 0
        depth, P = best.model.depth(part, values), part.P - base_line(part, values)[0]
        each.append((part.rows[chosen], depth[chosen], P[chosen], np.full(np.count_nonzero(chosen), part.kind)))
    rows, delta, P, words = (np.concatenate(columns) for columns in zip(*each, strict=True))
    order = np.argsort(rows, kind="stable")
    return replace(curve.rows(rows[order]), delta=delta[order], P=P[order], segment=words[order], stiffness=None)


def contact_rows(body: FittedBody, record: ForceCurve, settings: Settings) -> tuple[Curve, Settings]:
    """The rows of a raw record that are in contact, less the base lines and from the zero that fit best, for what its
    model does not know, and the settings by which they are fitted: the device is a compliance that is known, positions
    have no scatter, what the zeros err by is fitted again."""
    usual = tuple(Parameter(name, True) for name in ("modulus", "w", "delta0"))
    plain = replace(settings, parameters=usual, named=frozenset(), noise={}, branch="all", loss="linear")
    best = whole_fit(body, record, plain)
    curve = _in_contact(best, record.curve)
    outcome = outcome_of(best, best.x, body)
    chosen = {p.name: p for p in settings.parameters if p.name in settings.named}
    fixed_zeros = {name for name in ("delta0", "P0") if name in chosen and not chosen[name].free}
    shift = {name: outcome[name] if name in fixed_zeros else 0.0 for name in ("delta0", "P0")}
    stiff = 0.0 if "compliance" in chosen else 1 / best.model.k
    delta = curve.depth - (1 / best.model.k - stiff) * curve.load + shift["delta0"]
    note = (
        "only rows in contact are fitted; base lines and contact point are from the whole force curve, "
        f"delta0 = {show(outcome['delta0'], 'length', 5)} and P0 = {show(outcome['P0'], 'load', 5)}"
    )
    placed = RECORD_PLACED_ROWS * best.sigma * float(np.ptp(delta) / np.ptp(curve.load))
    placed = max(placed, best.sigma * (1 / best.model.k - stiff))
    fixed = {"compliance": Parameter("compliance", False, stiff)} | {"P0": Parameter("P0", True)}
    parameters = tuple(fixed.get(p.name, p) if p.name not in chosen else p for p in settings.parameters)
    curve = replace(curve, delta=delta, P=curve.load + shift["P0"], flags=(*curve.flags, note))
    noise = {"delta": placed, "P": best.sigma} | dict(settings.noise)
    return curve, replace(settings, parameters=parameters, noise=noise, contact="as-is", base_line="straight")


def _fitted(
    body: FittedBody, model: ForceCurveModel, settings: Settings, begin: Values | None = None
) -> Flow[tuple[FittedBody, ForceCurveFit]]:
    """The model that fits best, and the body solved as far as it reaches; from some values of its unknowns on."""
    for part in model.stretches:
        if part.z.size == 0:
            raise InputError(f"the {part.kind} has no row to fit: contact ends where it begins, or its signs are wrong")
        if np.ptp(part.z) == 0:
            raise SolveError(f"the {part.kind} has {part.z.size} rows to fit, all at one piezo position")
    # Up to the contact radius that a record can reach at most, as its tip moves no deeper
    ways = ((part.z - part.P / model.k)[part.touching if part.jumped else slice(None)] for part in model.stretches)
    body = body.to_depth(max(float(np.ptp(way)) for way in ways))
    for _ in range(MOST_SOLVES):
        model = replace(model, family=body.family)
        best = yield from _again(begin, model, settings) if begin else nearest(model, settings.loss)
        begin, reach = best.model.values(best.x), best.a.max()
        if not body.extensible or reach <= body.series.a[-1]:
            break
        body = body.to_radius(ROOM * float(reach))
    if np.count_nonzero(best.a) <= len(best.names):
        raise SolveError("the curve that fits best has next to no row in contact; --flip P, if compression is negative")
    whole, best = best, (yield from _without_window(best, model, settings))
    values, few, ends = {**whole.model.values(whole.x), **best.model.known}, model.few, list[Least]()
    pinned = f"q:{RETRACT}" in best.model.known and f"q:{RETRACT}" not in model.known
    hidden = f"r:{APPROACH}" in whole.names and values[f"r:{APPROACH}"] <= 0 < values.get(f"q:{RETRACT}", 0.0)
    if len(model.stretches) > 1 and (pinned or hidden):
        # Noise hides where contact begins or is lost: begun anew with a w of the approach, and an edge that recedes, of
        # the w that leaves few rows least.
        for q in (share * values[f"q:{RETRACT}"] for share in (RECORD_RECEDES if pinned else (1.0,))):
            before = {f"q:{APPROACH}": RECORD_BEFORE * q, f"r:{APPROACH}": math.sqrt(RECORD_BEFORE * q)}
            ends += yield from roughly(few, few.unknowns(values | before | {f"q:{RETRACT}": q}), FIT_BLUNT[1:2])
        here = few.off(few.unknowns(values), FIT_BLUNT[1])
        for end in sorted(ends, key=lambda one: one.cost)[:1]:
            there = few.off(end.x, FIT_BLUNT[1])
            with contextlib.suppress(SolveError):
                if pinned or there @ there < here @ here:
                    other = yield from fitting(model, end.x, True, settings.loss)
                    if other.sigma < whole.sigma:
                        best = yield from _without_window(other, model, settings)
    # w that comes out below 0 by more than noise and misfit explain is of another body: 0 is as near as it can come
    model, zero_works = best.model, dict[str, float]()
    for part in model.stretches:
        own = next((name for name in (f"q:{part.kind}", f"r:{part.kind}") if name in best.names), None)
        if own is not None and best.value(own) < -FLAG_SURE * best.error(own) * best.spread.excess:
            zero_works[part.kind] = 0.0
    if zero_works:
        model = replace(model, works={**model.works, **zero_works})
        best = yield from fitting(model, best.unknowns(model), loss=settings.loss)
    return body, best


def _without_window(best: ForceCurveFit, model: ForceCurveModel, settings: Settings) -> Flow[ForceCurveFit]:
    """The fit of the ``model`` without the rows about first touch."""
    cut = windowed(best)
    if cut is best.model:
        return best
    return (yield from _again(best.model.values(best.x), replace(cut, known=model.known), settings))


def _again(begin: Values, model: ForceCurveModel, settings: Settings) -> Flow[ForceCurveFit]:
    """The fit of a ``model`` from values of its unknowns on that are near."""
    return fitting(model, model.unknowns({**model.by_terms, **begin}), True, settings.loss)


def beside(back: Fit, into: Fit, both: Fit) -> Fit:
    """The fit of the retraction with the estimates of the approach beside its own; ``both``: that of one modulus."""
    one, other = back.estimate("E_star"), into.estimate("E_star")
    name = "directions differ"
    sentence = (
        f"{name}: E* is {show(other.value, 'modulus', 4)} on approach and {show(one.value, 'modulus', 4)} on "
        "retraction, one value does not fit both: the specimen relaxes or yields, or the instrument drifts"
    )
    work, drifts = into.estimate("w_approach"), [line for line in both.warnings if line.startswith("drift")]
    return replace(
        back, estimates=(*back.estimates, replace(other, name="E_star_approach"), work),
        flags=(*back.flags, name), warnings=(sentence, *drifts, *back.warnings),
        directions=f"{NAMES[RETRACT]}, the approach beside it",
    )  # fmt: skip


def differ(into: float, back: float, error: float) -> bool:
    """Whether the moduli of two directions exclude each other, by the ``error`` of their relative difference."""
    return abs(back / into - 1) > max(RECORD_APART * error, RECORD_DIFFERS)


def _model(body: FittedBody, record: ForceCurve, settings: Settings, kinds: Sequence[str]) -> ForceCurveModel:
    """The model of the directions ``kinds`` of a record, by the settings."""
    curve, w, modulus = record.curve, settings.known("w"), settings.known("modulus")
    parts = stretches(record, kinds)
    works = {} if w.free else {part.kind: float(w.value or 0.0) for part in parts if part is parts[-1] or not w.value}
    known = {} if modulus.free else {"ln_s": math.log(modulus.value or 1.0)}
    for part in (part for part in parts if not part.line.rows):
        known |= {f"tilt:{part.kind}": 0.0} | ({} if settings.known("P0").free else {f"offset:{part.kind}": 0.0})
    if settings.positions and len(parts) < 2:
        which = settings.positions[0]
        raise InputError(f"{curve.where}: {which} needs approach and retraction together, only one can be fitted")
    errors = (settings.known(name) for name in settings.positions)
    known |= {item.name: item.value for item in errors if item.value is not None}
    k = math.inf if curve.stiffness is None else curve.stiffness
    moduli = (modulus.low, modulus.high)
    return ForceCurveModel(body.family, k, parts, known, works, moduli, settings.positions)

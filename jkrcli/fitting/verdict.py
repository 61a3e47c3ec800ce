"""What the rivals of a raw record make of its fit: flags, warnings, the systematic parts, and the formula beside it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.lockstep import Flow, ask
from ..base.numerics import ROUNDED, UNSEEN
from ..bodies.problem import Problem
from ..data.curve import APPROACH
from .alternative_tests import (
    SCORE_NORMAL,
    FittedRival,
    RecordRivals,
    RivalFit,
    Verdict,
    bounds,
    fit_alternatives,
    relative_errors,
    rivals_of_records,
)
from .alternatives import MEMORY, FittedRecord, Known
from .force_curve import ForceCurveFit, ForceCurveModel, base_line
from .forward_model import FittedBody
from .parameters import FittedValue
from .result import Fit

REJECTED, DIFFER = "model rejected", "directions differ"

# When rivals leave nothing determined.
# choice: share of E* and of w that rivals may move it by, above which it is flagged: half of w, of which an approach
# tells no more where adhesion may have a range
VERDICT_LARGE = (0.3, 0.5)
VERDICT_TENFOLD = 9.0  # theory: relative change of a quantity that becomes ten times as large


def attach_verdict(result: Fit, body: FittedBody, fit: ForceCurveFit) -> Flow[Fit]:
    """The result with its verdict: that of a ``fit`` of all directions of the record."""
    settings = result.settings
    record = FittedRecord(body, fit, Known(settings.range_at_most, settings.tension_at_most, settings.level))
    scores = yield from ask(rivals_of_records, record)
    rivals = yield from bounds(record, scores)
    new = {name: sentence for name, sentence in _flags(rivals, fit) if name not in result.flags}
    estimates = tuple(_with_part(item, rivals) for item in result.estimates)
    warnings = tuple(f"{name}: {sentence}" for name, sentence in new.items())
    return replace(
        result, estimates=estimates, flags=(*result.flags, *new), warnings=(*warnings, *result.warnings),
        verdict=Verdict(rivals, *_by_formula(body.problem, fit)),
    )  # fmt: skip


def replace_by_best_alternative(
    plain: Fit, body: FittedBody, fit: ForceCurveFit, fresh: ForceCurveModel, result_of: Callable[[ForceCurveFit], Fit]
) -> Fit:
    """The result by the best of the rivals that are taken, where the data favour one; ``result_of`` a fit of the
    record. The systematic part holds what is tied with it."""
    verdict = plain.verdict
    if verdict is None or not verdict.rivals.named:
        return plain
    full = fit_alternatives(FittedRecord(body, fit), fresh, verdict.rivals)
    verdict = replace(verdict, fitted=tuple(_fitted_rival(one, full[0], body) for one in full))
    if not verdict.tied:
        return replace(plain, verdict=verdict)
    results = {one.score.name: result_of(one.fit) for one in full[: len(verdict.tied)]}
    result = results[verdict.tied[0].name]
    estimates = tuple(_with_ties(item, verdict.tied, results) for item in result.estimates)
    return replace(result, estimates=estimates, verdict=verdict)


def _fitted_rival(one: RivalFit, best: RivalFit, body: FittedBody) -> FittedRival:
    model, score = one.fit.model, one.score
    values = model.values(one.fit.x)
    s, quantities = math.exp(values["ln_s"]), model.further(values)
    w = quantities.pop("w", max(values[f"q:{model.stretches[-1].kind}"], 0.0) * s)
    E_star, taken = s * body.problem.E_star, one.taken(best)
    return FittedRival(score.name, score.family, one.falls, one.chance, taken, E_star, w, quantities)


def _with_ties(item: FittedValue, tied: Sequence[FittedRival], results: Mapping[str, Fit]) -> FittedValue:
    """The estimate with what the farthest of those that are tied makes of it, or how far its interval reaches beyond
    this one's, where that is more; ``results`` by name."""
    of_modulus, best = _of_modulus(item), tied[0]
    if item.error is None or not (of_modulus or item.dimension == "work"):
        return item
    moves = {}
    for one in tied[1:]:
        shift = (one.E_star / best.E_star - 1) * item.value if of_modulus else one.w - best.w
        moves[one.name] = max(abs(shift), _beyond(item, results[one.name]))
    moves |= dict(item.model or {})
    worst = max(moves, key=lambda name: moves[name], default="")
    return replace(item, model={worst: moves[worst]}) if worst else item


def _beyond(item: FittedValue, other: Fit) -> float:
    """How far the interval of the same estimate of an ``other`` fit reaches beyond its own."""
    same = next((one for one in other.estimates if one.name == item.name), None)
    if same is None or item.low is None or item.high is None or same.low is None or same.high is None:
        return 0.0
    return max(item.low - same.low, same.high - item.high, 0.0)


def _by(change: float) -> str:
    """A relative change; of one step, which is of first order, no more than that it is tenfold."""
    return f"{change:+.1%}" if change < VERDICT_TENFOLD else "more than tenfold"


def _flags(rivals: RecordRivals, fit: ForceCurveFit) -> Iterator[tuple[str, str]]:
    """Flags with a sentence each; a quantity whose interval is wider than what rivals may change it by tells so
    itself."""
    if rivals.named:
        names = " or ".join(f"{one.name} (E* {_by(one.change(one.E_star))})" for one in rivals.named)
        apart = ", not distinguishable by this test" if len(rivals.named) > 1 else ""
        yield REJECTED, f"p = {rivals.chance:.1g}, the residuals favour {names}{apart}"
    if rivals.named and rivals.named[0].of_directions:
        compared = (one for one in rivals.scores if one.of_directions and one.family == MEMORY)
        amounts = ", ".join(f"{one.name} {one.amount:+.1%} ± {one.error:.1%} ({one.amount_is})" for one in compared)
        families = ", ".join(rivals.families)
        yield DIFFER, f"approach and retraction favour {amounts}; {families} would explain the difference"
    work = "w_approach" if fit.model.stretches[-1].kind == APPROACH else "w"
    for quantity, symbol, error, most in zip(
        ("E_star", "w"), ("E*", work), relative_errors(fit), VERDICT_LARGE, strict=True
    ):
        worst = rivals.worst(quantity)
        if worst is not None and worst[1] > max(most, SCORE_NORMAL * error):
            yield f"{symbol} not determined", f"{worst[0]} may change it by {worst[1]:.0%}"


def _with_part(item: FittedValue, rivals: RecordRivals) -> FittedValue:
    """The estimate with what the worst rival may move it by."""
    of_modulus = _of_modulus(item)
    worst = rivals.worst("E_star" if of_modulus else "w") if of_modulus or item.dimension == "work" else None
    return item if worst is None or item.error is None else replace(item, model={worst[0]: worst[1] * abs(item.value)})


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
    if not problem.layers:
        return "Hertz", 3 * load / (4 * math.sqrt(R * depth**3)) if load > 0 else None
    w = max(values[f"q:{part.kind}"], 0.0) * math.exp(values["ln_s"])
    try:
        return "a half-space formula", half_space_modulus(load, depth, R, w)
    except ValueError:
        return "a half-space formula", None


def half_space_modulus(P: float, delta: float, R: float, w: float) -> float:
    """E* [Pa] of the half-space on which a paraboloid of radius ``R`` [m] stands at depth ``delta`` [m] under the load
    ``P`` [N] against the work of adhesion ``w`` [J/m^2] (JKR); ValueError where there is none."""
    if w == 0:
        return 3 * P / (4 * math.sqrt(R * delta**3))

    def modulus(a: float) -> float:
        return 2 * math.pi * a * w / (a**2 / R - delta) ** 2

    def excess(a: float) -> float:
        E = modulus(a)
        return 4 * E * a**3 / (3 * R) - math.sqrt(8 * math.pi * w * E * a**3) - P

    from scipy.optimize import brentq

    # From the contact radius without adhesion, to where the depth is nothing beside a^2/R:
    touching = math.sqrt(R * delta)
    return modulus(touching * float(brentq(lambda x: excess(touching * x), 1 + ROUNDED, 1 / UNSEEN)))

"""What the free rows of a record hold beside base lines, in its fit: how large it is, and what it leaves of E* and w.

Loads of a level or of an attraction are taken off before a fit. Its size is a parameter all the same: the whole record
is fitted at sizes a standard error apart, the least of the parabola through their chi^2 is the size, and its width by
the change of an estimate over it is added to the interval (the profile of one parameter). What the other law of an
attraction makes of an estimate is a part by the model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..base.errors import JkrError
from ..base.executors import Pool
from ..base.units import show
from .force_curve import ForceCurveFit
from .forward_model import FittedBody
from .free_rows import FreeRows
from .least_squares import t_quantile, wider
from .lockstep import Flow
from .record import fit_record, outcome_of, whole_fit
from .result import Fit, attempted, later
from .segmentation import ForceCurve
from .settings import AUTO, Settings

NUISANCE_FARTHEST = 10.0  # choice: standard errors of the free rows, which the contact moves the size by at most
NUISANCE_ROUNDS = 3  # choice: parabolas through sizes
NUISANCE_EXCLUDED = 100.0  # choice: rise of chi^2, ten standard errors, beyond which another law is none of these data
NUISANCE_NEEDED = 4.0  # theory: of chi^2, Akaike's criterion, the fall by the two parameters of an attraction
OTHER_LAW = "the law of the attraction"


Outcome: TypeAlias = tuple[float, Mapping[str, float], ForceCurveFit]  # cost, values, and the fit itself


@dataclass(frozen=True, eq=False)
class Nuisance:
    """The ``record`` as it is fitted best, and what is not known of its free rows: ``changes`` of the outcome by a
    standard error each, ``laws``: by the other law; ``words`` on what it holds."""

    record: ForceCurve
    changes: tuple[Mapping[str, float], ...]
    laws: Mapping[str, float]
    words: tuple[str, ...]


def fit_settled(body: FittedBody, record: ForceCurve, settings: Settings, pool: Pool | None = None) -> Flow[Fit]:
    """The fit of a raw record less what its free rows hold.

    A model that is wrong in the first rows of contact makes them look like an attraction: where the best alternative
    is to be taken, it is fitted to the loads with the attraction too, and that is the answer where it leaves no more.
    """
    left = list[str]()
    sizes = partial(settled, body, record, settings)
    nuisance = attempted("how large what the free rows hold is", sizes, None, left)
    if nuisance is None or record.held is None:
        fitted = yield from fit_record(body, record, settings, pool)
        return replace(fitted, warnings=(*fitted.warnings, *left))
    fitted = yield from fit_record(body, nuisance.record, settings, pool)
    fitted = yield from later(fitted, "errors by what free rows hold", partial(with_nuisance, fitted, nuisance))
    if settings.model != AUTO or record.held.attraction is None:
        return fitted
    straight = record.holding(record.held.straight)

    def without_attraction() -> Flow[Fit]:
        other = yield from fit_settled(body, straight, settings, pool)
        rise = other.rows.size * ((other.scales["P"] / fitted.scales["P"]) ** 2 - 1)
        if other.verdict is not None and other.verdict.tied and rise < NUISANCE_NEEDED:
            words = f"no attraction before contact remains with the alternative model: {other.verdict.tied[0].name}"
            return replace(other, held=(*other.held, words))
        return fitted

    return (yield from later(fitted, "the alternative model without the attraction", without_attraction))


def settled(body: FittedBody, record: ForceCurve, settings: Settings) -> Nuisance | None:
    """The record with what its free rows hold at the sizes that fit best; None where they hold a line alone."""
    held = record.held
    if held is None:
        return None

    def of(other: ForceCurve) -> Outcome:
        best = whole_fit(body, other, settings)
        return float(best.off @ best.off), outcome_of(best, best.x, body), best

    changes, laws, unknown = list[Mapping[str, float]](), dict[str, float](), tuple[str, ...]()
    try:
        if held.attraction is not None:
            (held, here, cost, per_row, width), other = sorted(
                (_of_law(of, record, one) for one in (held, held.by_other_law)), key=lambda one: one[2]
            )
            record = record.holding(held)
            changes.append(_between(here, of(record.holding(held.stronger(width)))[1]))
            if other[2] - cost < NUISANCE_EXCLUDED * per_row:
                laws = _between(here, other[1])
        else:
            here = of(record)[1]
        for raised in held.raised:
            moved = replace(held, taken=held.taken + raised)
            changes.append(_between(here, of(record.holding(moved))[1]))
    except JkrError:  # a size that no curve resembles tells nothing
        unknown = ("how well its size is known is not in the errors: no curve fits at other sizes",)

    # E* and w where it is left in the loads
    left_in = tuple[str, ...]()
    if record.plain is not None and record.held is not None and (record.held.levels or record.held.attraction):
        try:
            _, outcome, best = of(record.plain)
            E_star = math.exp(best.model.values(best.x)["ln_s"]) * body.problem.E_star
            work = "w" if "w" in outcome else "w_approach"
            sizes = f"E* = {show(E_star, 'modulus', 4)}, {work} = {show(max(outcome[work], 0.0), 'work', 4)}"
            left_in = (f"left in the loads {sizes}",)
        except JkrError:
            left_in = ("left in the loads no fit converges",)
    return Nuisance(record, tuple(changes), laws, (*held.words, *left_in, *unknown))


def _of_law(
    of: Callable[[ForceCurve], Outcome], record: ForceCurve, held: FreeRows
) -> tuple[FreeRows, Mapping[str, float], float, float, float]:
    """An attraction by one law at the size of least chi^2, the outcome there, the sum of squares of the residuals and
    that of one row, and the standard error of the size, in those of the free rows."""

    def cost_of(size: float) -> tuple[float, ForceCurveFit]:
        return of(record.holding(held.stronger(size)))[::2]

    tried, found = {size: cost_of(size) for size in (-1.0, 0.0, 1.0)}, (0.0, 1.0)  # the size and its standard error
    for _ in range(NUISANCE_ROUNDS):
        sizes = sorted(sorted(tried, key=lambda size: tried[size][0])[:3])
        best = min(tried.values(), key=lambda one: one[0])[1]
        per_row = best.sigma**2 * best.spread.tau
        bend, slope, _ = np.polyfit(sizes, [tried[size][0] / per_row for size in sizes], 2)
        if bend <= 0 or abs(least := -slope / (2 * bend)) > NUISANCE_FARTHEST:
            found = 0.0, 1.0  # as the free rows have it, where the record has no least
            break
        found = float(least), float(1 / math.sqrt(bend))
        if min(abs(least - size) for size in tried) < 0.3 / math.sqrt(bend):
            break
        tried[least] = cost_of(least)
    held = held.stronger(found[0])
    cost, outcome, best = of(record.holding(held))
    return held, outcome, cost, best.sigma**2 * best.spread.tau, found[1]


def _between(here: Mapping[str, float], there: Mapping[str, float]) -> dict[str, float]:
    return {name: there[name] - value for name, value in here.items() if name in there}


def with_nuisance(fitted: Fit, nuisance: Nuisance | None) -> Fit:
    """The fit of a settled record with what is not known of its free rows in the errors."""
    if nuisance is None:
        return fitted
    t = t_quantile(fitted.settings.level, fitted.dof)
    estimates = []
    for item in fitted.estimates:
        if item.error is not None and item.free:
            total = math.hypot(*(change.get(item.name, 0.0) for change in nuisance.changes))
            law = abs(nuisance.laws.get(item.name, 0.0)) if item.dimension in ("modulus", "work") else 0.0
            item = replace(wider(item, {"free rows": total}, t), systematic=item.systematic)
            item = item.with_model(OTHER_LAW, law) if law else item
        estimates.append(item)
    return replace(fitted, estimates=tuple(estimates), held=nuisance.words)

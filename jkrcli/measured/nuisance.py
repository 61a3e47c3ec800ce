"""What the free rows of a record hold beside base lines, in its fit: how large it is, and what it leaves of E* and w.

Loads of a level or of an attraction are taken off before a fit. Its size is a parameter all the same: the whole record
is fitted at sizes a standard error apart, the least of the parabola through their chi^2 is the size, and its width by
the change of an estimate over it is added to the interval (the profile of one parameter). Whether an attraction stays
in contact or ends at touch, by which law, and whether there is any, are hypotheses: the likeliest is the answer, and
the spread to the others at their odds is a part of the model's error.
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
from .free_rows import LAWS, FreeRows
from .least_squares import t_quantile, wider
from .lockstep import Flow
from .record import fit_record, outcome_of, whole_fit
from .result import Fit, attempted, later
from .segmentation import ForceCurve
from .settings import AUTO, Settings

NUISANCE_FARTHEST = 10.0  # choice: standard errors of the free rows, which the contact moves the size by at most
NUISANCE_ROUNDS = 3  # choice: parabolas through sizes
NUISANCE_EXCLUDED = 100.0  # choice: rise of chi^2, ten standard errors, beyond which a hypothesis is none of these data
NUISANCE_NEEDED = 4.0  # theory: of chi^2, Akaike's criterion, the fall by the two parameters of an attraction
NUISANCE_LEFT_OUT = 2.0  # theory: the same of a row, by one parameter
NUISANCE_TOLD = 30.0  # choice: of chi^2, the same, up to which values of the next hypothesis are told


Outcome: TypeAlias = tuple[float, Mapping[str, float], ForceCurveFit]  # cost, values, and the fit itself


@dataclass(frozen=True, eq=False)
class Nuisance:
    """The ``record`` as it is fitted best, and what is not known of its free rows: ``changes`` of the outcome by a
    standard error each, ``spread`` of it to the other hypotheses, by their names; ``words`` on what it holds."""

    record: ForceCurve
    changes: tuple[Mapping[str, float], ...]
    spread: Mapping[str, Mapping[str, float]]
    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What the free rows may hold: loads ``held``, the ``outcome`` and chi^2 of the fit less them, in ``per_row`` [N^2]
    of one row, and the standard error ``width`` of an attraction's size in those of the free rows."""

    held: FreeRows
    outcome: Mapping[str, float]
    chi2: float
    per_row: float
    width: float = 1.0

    @classmethod
    def of(cls, record: ForceCurve, held: FreeRows, fitted: Callable[[ForceCurve], Outcome]) -> Hypothesis:
        """By a fit; no attraction is the simpler one, and each row that is left out a number of its own."""
        cost, outcome, best = fitted(record.holding(held))
        per_row = best.sigma**2 * best.spread.tau
        left_out = NUISANCE_LEFT_OUT * (len(record.curve) - best.off.size)
        simpler = NUISANCE_NEEDED * (held.attraction is None)
        return cls(held, outcome, cost + (left_out - simpler) * per_row, per_row)

    def name(self, other: Hypothesis) -> str:
        """What tells it from an ``other`` one."""
        mine, theirs = self.held.attraction, other.held.attraction
        if mine is None or theirs is None:
            return "a bend of the base line"
        if {mine.law, theirs.law} - LAWS.keys():
            return "what bends the base line"
        return "the law of the attraction" if mine.stays == theirs.stays else "the attraction in contact"

    @property
    def values(self) -> str:
        """E* and w in words."""
        work = "w" if "w" in self.outcome else "w_approach"
        E_star, w = self.outcome["E_star"], max(self.outcome[work], 0.0)
        return f"E* = {show(E_star, 'modulus', 4)}, {work} = {show(w, 'work', 4)}"


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
        E_star = math.exp(best.model.values(best.x)["ln_s"]) * body.problem.E_star
        return float(best.off @ best.off), outcome_of(best, best.x, body) | {"E_star": E_star}, best

    changes, spread, words = list[Mapping[str, float]](), dict[str, Mapping[str, float]](), list[str]()
    try:
        if held.attraction is not None:
            likeliest, *others = _hypotheses(record, held, of)
            held, here = likeliest.held, likeliest.outcome
            record = record.holding(held)
            if held.attraction is not None:
                changes.append(_between(here, of(record.holding(held.stronger(likeliest.width)))[1]))
            # Beside the likeliest, one of odds p has the standard deviation sqrt(p (1 - p)) of the difference
            for one in others:
                rise = (one.chi2 - likeliest.chi2) / likeliest.per_row
                share = 1 / math.cosh(
                    min(rise, 2 * NUISANCE_EXCLUDED) / 4
                )  # 2 sqrt(p (1 - p)), p = 1/(1 + exp(rise/2))
                parts = {name: share * abs(off) for name, off in _between(here, one.outcome).items()}
                before = spread.get(one.name(likeliest), {})
                spread[one.name(likeliest)] = {name: max(part, before.get(name, 0.0)) for name, part in parts.items()}
                if rise < NUISANCE_TOLD:
                    what = "no attraction" if one.held.attraction is None else one.held.attraction.brief
                    words.append(f"{what}: {one.values} (chi^2 higher by {rise:.2g})")
        else:
            here = of(record)[1]
        for raised in held.raised:
            moved = replace(held, taken=held.taken + raised)
            changes.append(_between(here, of(record.holding(moved))[1]))
    except JkrError:  # a size that no curve resembles tells nothing
        words.append("how well its size is known is not in the errors: no curve fits at other sizes")
    if record.plain is not None and held.levels:
        try:
            _, outcome, _ = of(record.plain)
            words.append(f"left in the loads {Hypothesis(held, outcome, 0.0, 1.0).values}")
        except JkrError:
            words.append("left in the loads no fit converges")
    return Nuisance(record, tuple(changes), spread, (*held.words, *words))


def _hypotheses(record: ForceCurve, held: FreeRows, of: Callable[[ForceCurve], Outcome]) -> list[Hypothesis]:
    """What the free rows may hold, the likeliest first: an attraction that stays in contact, one that ends at touch, by
    either law, or none; JkrError where no curve fits with any. Contact tells the size of one that stays."""
    found, reasons = list[Hypothesis](), list[JkrError]()
    for each in (*held.by_laws, held.straight):
        try:
            found.append(Hypothesis.of(record, each, of))
        except JkrError as error:
            reasons.append(error)
    if not found:
        raise reasons[0]
    least = min(found, key=lambda one: one.chi2)
    for i, one in enumerate(found):
        law = one.held.attraction
        if law is not None and law.stays and one.chi2 - least.chi2 < NUISANCE_EXCLUDED * least.per_row:
            found[i] = _of_size(record, one, of)
    return sorted(found, key=lambda one: one.chi2)


def _of_size(record: ForceCurve, begin: Hypothesis, of: Callable[[ForceCurve], Outcome]) -> Hypothesis:
    """The hypothesis of an attraction at its size of least chi^2, with the standard error of the size."""
    held = begin.held

    def at(size: float) -> Hypothesis:
        return Hypothesis.of(record, held.stronger(size), of)

    tried, found = {0.0: begin} | {size: at(size) for size in (-1.0, 1.0)}, (0.0, 1.0)  # the size and its error
    for _ in range(NUISANCE_ROUNDS):
        sizes = sorted(sorted(tried, key=lambda size: tried[size].chi2)[:3])
        per_row = min(tried.values(), key=lambda one: one.chi2).per_row
        bend, slope, _ = np.polyfit(sizes, [tried[size].chi2 / per_row for size in sizes], 2)
        if bend <= 0 or abs(least := -slope / (2 * bend)) > NUISANCE_FARTHEST:
            found = 0.0, 1.0  # as the free rows have it, where the record has no least
            break
        found = float(least), float(1 / math.sqrt(bend))
        if min(abs(least - size) for size in tried) < 0.3 / math.sqrt(bend):
            break
        tried[least] = at(least)
    return replace(tried.get(found[0]) or at(found[0]), width=found[1])


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
            item = replace(wider(item, {"free rows": total}, t), systematic=item.systematic)
            for name, parts in nuisance.spread.items() if item.dimension in ("modulus", "work") else ():
                item = item.with_model(name, parts[item.name]) if parts.get(item.name) else item
        estimates.append(item)
    return replace(fitted, estimates=tuple(estimates), held=nuisance.words)

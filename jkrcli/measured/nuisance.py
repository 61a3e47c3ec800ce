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
from ..base.numerics import TINY, Array
from ..base.units import show
from .force_curve import ForceCurveFit, unbroken
from .forward_model import FittedBody
from .free_rows import LAWS, FreeRows
from .least_squares import t_quantile, wider
from .lockstep import Flow, alone, beside, together
from .record import fit_record, fitted_whole, outcome_of
from .result import Fit, attempted, later
from .segmentation import ForceCurve
from .settings import Settings

NUISANCE_FARTHEST = 10.0  # choice: standard errors of the free rows, which the contact moves the size by at most
NUISANCE_ROUNDS = 3  # choice: parabolas through sizes
NUISANCE_EXCLUDED = 100.0  # choice: rise of chi^2, ten standard errors, beyond which a hypothesis is none of these data
NUISANCE_NEEDED = 4.0  # theory: of chi^2, Akaike's criterion, the fall by the two parameters of an attraction
NUISANCE_FAR = 3.0  # choice: standard deviations of a row, beyond which it counts no more: a jump a row late is none
NUISANCE_SEEN = 1e-4  # choice: relative, a part of an error below which it is none
NUISANCE_TOLD = 30.0  # choice: of chi^2, the same, up to which values of the next hypothesis are told


Outcome: TypeAlias = Mapping[str, float]  # of a fit, SI, by name
Fitted: TypeAlias = Callable[[ForceCurve, ForceCurveFit | None], Flow[tuple[Outcome, ForceCurveFit]]]


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
    """What the free rows may hold: loads ``held``, the ``fit`` less them, its ``outcome``, what it leaves ``off`` all
    rows of the record [N], those that it left out too, and the standard error ``width`` of a size in those of the free
    rows."""

    held: FreeRows
    fit: ForceCurveFit
    outcome: Outcome
    off: Array
    width: float = 1.0

    @classmethod
    def of(
        cls, record: ForceCurve, held: FreeRows, fitted: Fitted, begin: ForceCurveFit | None = None
    ) -> Flow[Hypothesis]:
        """By a fit, which may leave rows out."""
        record = record.holding(held)
        outcome, best = yield from fitted(record, begin)
        whole, off = unbroken(record, best.model), np.zeros(len(record.curve))
        off[whole.rows] = whole.off(best.x, 0.0)
        off[best.model.rows] = best.off
        return cls(held, best, outcome, off)

    def rise(self, other: Hypothesis) -> float:
        """By how much chi^2 is higher than that of an ``other`` one, in units of its noise: of the rows that either is
        fitted to, of which none counts for more than one at ``NUISANCE_FAR``; no bend is the simpler one."""
        noise, rows = max(other.fit.sigma, TINY), np.union1d(self.fit.model.rows, other.fit.model.rows)
        mine, theirs = (float(np.minimum((one.off[rows] / noise) ** 2, NUISANCE_FAR**2).sum()) for one in (self, other))
        simpler = float(other.held.attraction is None) - float(self.held.attraction is None)
        return (mine - theirs) / other.fit.spread.tau + NUISANCE_NEEDED * simpler

    def name(self, other: Hypothesis) -> str:
        """What tells it from an ``other`` one."""
        mine, theirs = self.held.attraction, other.held.attraction
        if mine is None or theirs is None:
            return "whether the base line bends"
        if {mine.law, theirs.law} - LAWS.keys():
            return "attraction, virtual deflection or drift"
        return "the law of the attraction" if mine.stays == theirs.stays else "whether the attraction stays in contact"


def _values(outcome: Mapping[str, float]) -> str:
    """E* and w in words."""
    work = "w" if "w" in outcome else "w_approach"
    return f"E* = {show(outcome['E_star'], 'modulus', 4)}, {work} = {show(max(outcome[work], 0.0), 'work', 4)}"


def fit_settled(
    body: FittedBody, record: ForceCurve, settings: Settings, pool: Pool | None = None
) -> Flow[tuple[Fit, ForceCurve, ForceCurveFit]]:
    """The fit of a raw record less what its free rows hold, that record, and the fit of all its directions."""
    left = list[str]()
    sizes = partial(settled, body, record, settings)
    nuisance = attempted("how large what the free rows hold is", sizes, None, left)
    if nuisance is None or record.held is None:
        fitted, whole = yield from fit_record(body, record, settings, pool)
        return replace(fitted, warnings=(*fitted.warnings, *left)), record, whole
    fitted, whole = yield from fit_record(body, nuisance.record, settings, pool)
    known = yield from later(fitted, "errors by what free rows hold", partial(with_nuisance, fitted, nuisance))
    return known, nuisance.record, whole


def settled(body: FittedBody, record: ForceCurve, settings: Settings) -> Nuisance | None:
    """The record with what its free rows hold at the sizes that fit best; None where they hold a line alone."""
    held = record.held
    if held is None:
        return None

    def of(other: ForceCurve, begin: ForceCurveFit | None) -> Flow[tuple[Outcome, ForceCurveFit]]:
        best = yield from fitted_whole(body, other, settings, begin)
        E_star = math.exp(best.model.values(best.x)["ln_s"]) * body.problem.E_star
        return outcome_of(best, best.x, body) | {"E_star": E_star}, best

    changes, spread, words = list[Mapping[str, float]](), dict[str, Mapping[str, float]](), list[str]()
    try:
        if held.attraction is not None:
            likeliest, *others = _hypotheses(record, held, of)
            held, here, begin = likeliest.held, likeliest.outcome, likeliest.fit
            record = record.holding(held)
            for one in others:
                rise = min(max(one.rise(likeliest), 0.0), 2 * NUISANCE_EXCLUDED)
                # of odds p = 1/(1 + exp(rise/2)): 2 sqrt(p (1 - p)), two standard deviations of the difference
                share = 1 / math.cosh(rise / 4)
                parts = {name: share * abs(off) for name, off in _between(here, one.outcome).items()}
                before = spread.get(one.name(likeliest), {})
                spread[one.name(likeliest)] = {name: max(part, before.get(name, 0.0)) for name, part in parts.items()}
                if rise < NUISANCE_TOLD:
                    what = "a straight base line" if one.held.attraction is None else one.held.attraction.brief
                    words.append(f"{what}: {_values(one.outcome)} (chi^2 higher by {rise:.2g})")
            if held.attraction is not None:
                changes.append(_between(here, alone(of(record.holding(held.stronger(likeliest.width)), begin))[0]))
        else:
            here, begin = alone(of(record, None))
        for raised in held.raised:
            moved = replace(held, taken=held.taken + raised)
            changes.append(_between(here, alone(of(record.holding(moved), begin))[0]))
    except JkrError:  # a size that no curve resembles tells nothing
        words.append("how well its size is known is not in the errors: no curve fits at other sizes")
    if record.plain is not None and held.levels:
        try:
            words.append(f"left in the loads {_values(alone(of(record.plain, None))[0])}")
        except JkrError:
            words.append("left in the loads no fit converges")
    return Nuisance(record, tuple(changes), spread, (*held.words, *words))


def _hypotheses(record: ForceCurve, held: FreeRows, of: Fitted) -> list[Hypothesis]:
    """What the free rows may hold, the likeliest first: an attraction that stays in contact, one that ends at touch, by
    either law, a virtual deflection, a drift, or none; JkrError where no curve fits with any. Contact tells the size of
    what stays."""
    ends = together([Hypothesis.of(record, one, of) for one in (*held.by_laws, held.straight)])
    found = [one for one in ends if isinstance(one, Hypothesis)]
    for wrong in ends:
        if isinstance(wrong, Exception) and not (found and isinstance(wrong, JkrError)):
            raise wrong
    most = min(found, key=lambda one: one.fit.sigma)
    near = [
        i for i, one in enumerate(found)
        if (law := one.held.attraction) and law.stays and one.rise(most) < NUISANCE_EXCLUDED
    ]  # fmt: skip
    for i, sized in zip(near, together([_of_size(record, found[i], of) for i in near]), strict=True):
        if isinstance(sized, Exception) and not isinstance(sized, JkrError):
            raise sized
        found[i] = sized if isinstance(sized, Hypothesis) else found[i]
    most = min(found, key=lambda one: one.fit.sigma)
    return sorted(found, key=lambda one: one.rise(most))


def _of_size(record: ForceCurve, begin: Hypothesis, of: Fitted) -> Flow[Hypothesis]:
    """The hypothesis of an attraction at its size of least chi^2, with the standard error of the size."""
    held = begin.held

    def at(size: float) -> Flow[Hypothesis]:
        return Hypothesis.of(record, held.stronger(size), of, begin.fit)

    less, more = yield from beside([at(-1.0), at(1.0)])
    tried, found = {-1.0: less, 0.0: begin, 1.0: more}, (0.0, 1.0)  # the size and its error
    for _ in range(NUISANCE_ROUNDS):
        rises = {size: one.rise(begin) for size, one in tried.items()}
        sizes = sorted(sorted(rises, key=lambda size: rises[size])[:3])
        bend, slope, _ = np.polyfit(sizes, [rises[size] for size in sizes], 2)
        if bend <= 0 or abs(least := -slope / (2 * bend)) > NUISANCE_FARTHEST:
            found = 0.0, 1.0  # as the free rows have it, where the record has no least
            break
        found = float(least), float(1 / math.sqrt(bend))
        if min(abs(least - size) for size in tried) < 0.3 / math.sqrt(bend):
            break
        tried[least] = yield from at(least)
    return replace(tried.get(found[0]) or (yield from at(found[0])), width=found[1])


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
                part = parts.get(item.name, 0.0)
                item = item.with_model(name, part) if part > NUISANCE_SEEN * abs(item.value) else item
        estimates.append(item)
    return replace(fitted, estimates=tuple(estimates), held=nuisance.words)

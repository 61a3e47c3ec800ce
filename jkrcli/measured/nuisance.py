"""What the free rows of a record hold beside base lines: hypotheses, each a model of the whole record.

Sizes and ranges of what acts beside the contact are unknowns of the fit, so that its covariance holds how well they are
known. Whether an attraction stays in contact or ends at touch, by which law, whether a level is a spring that contact
stretches, and whether there is any, are hypotheses: the record is fitted by the likeliest, by the rows and by what is
likely before the data; estimates are averages over all at their odds, and the spread is a part of the model's error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from ..base.errors import JkrError, known
from ..base.executors import Pool
from ..base.numerics import TINY, Array
from ..base.units import show
from .choices import Values
from .force_curve import ForceCurveFit, unbroken
from .forward_model import FittedBody
from .free_rows import LAWS, RANGE, RELAXED, WAVE, FreeRows
from .least_squares import Spectrum, t_quantile, wider
from .lockstep import Flow, together
from .priors import PRIORS
from .record import about_whole, fit_record, fitted_whole, outcome_of, requested, usable
from .result import Fit, attempted, later
from .segmentation import ForceCurve
from .settings import Settings

NUISANCE_EXCLUDED = 100.0  # choice: of -2 ln L, ten standard errors, beyond which one is none of these data
NUISANCE_FAR = 3.0  # choice: standard deviations of a row, beyond which it counts no more: a jump a row late is none
NUISANCE_SEEN = 1e-4  # choice: relative, a part of an error below which it is none
NUISANCE_LEAST = 0.01  # choice: of the range of the load, the pull-off force that sizes are compared with at least
NUISANCE_VAGUE = 0.5  # choice: of ln E*, the standard error that tells nothing of it
NUISANCE_LEFT = 13.8  # theory: of -2 ln L, odds of 1 in 1,000, up to which one is not excluded
NUISANCE_TOLD = 30.0  # choice: of -2 ln L, up to which values of the next hypothesis are told


Outcome: TypeAlias = Values  # of a fit, SI, by name
Whole: TypeAlias = tuple[FittedBody, ForceCurveFit]  # the body as far as it was solved


Found: TypeAlias = "tuple[list[Hypothesis], list[float], list[str]]"  # with rises of -2 ln L, and words


@dataclass(frozen=True, eq=False)
class Nuisance:
    """The ``record`` as it is ``fitted`` best; what is not known of its free rows: ``changes`` of the outcome by a
    standard error each, ``shift`` from it to the average over hypotheses, ``spread`` of it to the others, by their
    names; ``words`` on what it holds."""

    record: ForceCurve
    fitted: Whole
    changes: tuple[Values, ...]
    shift: Values
    spread: Mapping[str, Values]
    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What the free rows may hold: the ``record`` less that, its ``fit`` on a ``body``, its ``outcome``, and what it
    leaves ``off`` all rows of the record [N], those that it left out too."""

    record: ForceCurve
    body: FittedBody
    fit: ForceCurveFit
    outcome: Outcome
    off: Array

    @classmethod
    def of(
        cls, body: FittedBody, record: ForceCurve, settings: Settings, near: ForceCurveFit | None = None
    ) -> Flow[Hypothesis | None]:
        """By a fit, which may leave rows out; None where by a few rows the fit ``near`` it excludes the record."""
        begin = {} if near is None else (yield from about_whole(body, record, settings, near))
        if begin is None:
            return None
        body, best = yield from fitted_whole(body, record, settings, begin)
        whole, off = unbroken(record, best.model), np.zeros(len(record.curve))
        off[whole.rows] = whole.off(best.x, 0.0)
        off[best.model.rows] = best.off
        return cls(record, body, best, outcome_of(best, best.x, body), off)

    @cached_property
    def held(self) -> FreeRows:
        """What it takes off, as it is fitted."""
        held = self.record.held
        assert held is not None
        values, error = self.fit.model.values(self.fit.x), dict.fromkeys(held.names, 0.0)
        error |= {name: self.fit.error(name) for name in self.fit.names if name in error}
        fitted = (term for term in held.terms if term.names[0] in self.fit.names)
        return held.of(*(replace(term, values=tuple(values[name] for name in term.names),
                                 errors=tuple(error[name] for name in term.names)) for term in fitted))  # fmt: skip

    @property
    def cost(self) -> float:
        """What its terms cost, of -2 ln L: those of their odds, and of how much of what is likely of them
        before the data is left (Laplace's approximation); of sizes by Cauchy's distribution, whose tail is heavy."""
        tension = max((known(side.adhesion) or 0.0 for side in self.record.directions), default=0.0)
        span = float(np.ptp(self.record.curve.load))
        scales = {"tension": max(tension, NUISANCE_LEAST * span), "load": span,
                  "way": float(np.ptp(self.record.curve.device))}  # fmt: skip
        cost, widths, names = 0.0, list[float](), list[str]()
        for term in self.held.terms:
            prior = PRIORS[term.law]
            width = prior.width * scales[prior.over]
            cost += 2 * math.log1p((term.size / width) ** 2) + prior.cost
            fitted = [name for name in term.names if name in self.fit.names]
            names += fitted
            widths += [prior.width_of_range if name.startswith(RANGE) else width for name in fitted]
        if not names:
            return cost
        rows = [self.fit.names.index(name) for name in names]
        inverse = np.linalg.pinv(self.fit.covariance[np.ix_(rows, rows)] / np.outer(widths, widths))
        return cost + float(np.linalg.slogdet(np.eye(len(rows)) + inverse)[1])

    def unlikely(self, rows: Array, misfit: float) -> float:
        """Minus twice the logarithm of the likelihood of some rows, with the noise that the free rows show and
        ``misfit`` times its variance; rows that it leaves out are no noise of any colour."""
        noise = self.fit.spread.noise.times(misfit)
        far = NUISANCE_FAR * math.sqrt(noise.level(rows.size))
        off, own = np.clip(self.off[rows], -far, far), np.isin(rows, self.fit.model.rows)
        return noise.unlikely(off[own]) + Spectrum(max(noise.A, TINY)).unlikely(off[~own])

    def name(self, other: Hypothesis) -> str:
        """What tells it from an ``other`` one."""
        mine, theirs = self.held, other.held
        if len({any(term.law == RELAXED for term in one.terms) for one in (mine, theirs)}) > 1:
            return RELAXED
        if not (mine.bends and theirs.bends):
            return "whether the base line bends"
        laws = [tuple(term.law for term in one.bends) for one in (mine, theirs)]
        if any(set(each) - LAWS.keys() for each in laws) and laws[0] != laws[1]:
            return "attraction, virtual deflection or drift"
        if any(term.moves for one in (mine, theirs) for term in one.terms):
            return "whether a level is stretched in contact"
        stays = [[term.stays for term in one.bends] for one in (mine, theirs)]
        return "the law of the attraction" if stays[0] == stays[1] else "whether the attraction stays in contact"


def _values(outcome: Values) -> str:
    """E* and w in words."""
    work = "w" if "w" in outcome else "w_approach"
    return f"E* = {show(outcome['E_star'], 'modulus', 4)}, {work} = {show(max(outcome[work], 0.0), 'work', 4)}"


def fit_settled(
    body: FittedBody, record: ForceCurve, settings: Settings, pool: Pool | None = None
) -> Flow[tuple[Fit, ForceCurve, ForceCurveFit]]:
    """The fit of a raw record less what its free rows hold, that record, and the fit of all its directions."""
    left = list[str]()
    average = partial(settled, body, record, settings)
    nuisance = attempted("the average over what the free rows may hold", average, None, left)
    if nuisance is None:
        fitted, whole = yield from fit_record(body, record, settings, pool)
        held = () if record.held is None else tuple(record.held.words)
        return replace(fitted, warnings=(*fitted.warnings, *left), held=held), record, whole
    fitted, whole = yield from fit_record(body, nuisance.record, settings, pool, nuisance.fitted)
    known = yield from later(fitted, "errors by what free rows hold", partial(with_nuisance, fitted, nuisance))
    return known, nuisance.record, whole


def settled(body: FittedBody, record: ForceCurve, settings: Settings) -> Nuisance | None:
    """The record with what its free rows hold as it is likeliest; None where they hold a line alone."""
    if record.held is None:
        return None

    found, rises, failed = _hypotheses(body, record, settings)
    likeliest, here = found[0], found[0].outcome
    spread, words = dict[str, Values](), [*likeliest.held.words]
    for one, rise in zip(found[1:], rises[1:], strict=True):
        # of odds p = 1/(1 + exp(rise/2)): 2 sqrt(p (1 - p)), two standard deviations of the difference
        # and within three half-widths whatever is not excluded
        share = max(1 / math.cosh(rise / 4), (rise < NUISANCE_LEFT) / 3)
        parts = {name: share * abs(off) for name, off in _between(here, one.outcome).items()}
        before = spread.get(one.name(likeliest), {})
        spread[one.name(likeliest)] = {name: max(part, before.get(name, 0.0)) for name, part in parts.items()}
        if rise < NUISANCE_TOLD:
            words.append(f"or {one.held.brief}: {_values(one.outcome)}, at odds of {math.exp(-rise / 2):.2g}")
    if len(words) > (count := len([*likeliest.held.words])):
        words.insert(count, f"{likeliest.held.brief}: {_values(here)}, of which and of others this is the average")
    words += failed
    odds, each = np.exp(-np.array(rises) / 2), [_between(here, one.outcome) for one in found]
    shift = {name: float(np.average([one.get(name, 0.0) for one in each], weights=odds)) for name in here}
    best = likeliest.fit
    raised = () if likeliest.record.held is None else likeliest.record.held.raised
    changes = tuple(_between(here, outcome_of(best, best.x + best.moves(loads), likeliest.body)) for loads in raised)
    return Nuisance(likeliest.record, (likeliest.body, best), changes, shift, spread, tuple(words))


def _hypotheses(body: FittedBody, record: ForceCurve, settings: Settings) -> Found:
    """What the free rows may hold, the likeliest first, and by how much -2 ln L of each is higher, with what its terms
    cost; sentences on those that no curve fits with, JkrError where that is so of all. Of a sine only those with a
    wave, if there are; none that leaves a direction without a base line, which others have. The first is fitted, and
    from there on those of the others that a few rows do not exclude.

    The likelihood is that of all rows that any is fitted to, with the noise that the free rows of each show: slow noise
    bends base lines, too. No row counts for more than one at ``NUISANCE_FAR``.
    """
    assert record.held is not None
    sine = settings.base_line == "sine"
    asked = [held for held in record.held.hypotheses if not sine or any(term.law == WAVE for term in held.terms)]
    each = [record.holding(held) for held in asked or record.held.hypotheses]
    told = [sum(usable(one, kind) for kind in requested(settings)) for one in each]
    first, *others = (one for one, count in zip(each, told, strict=True) if count == max(told))
    ends = together([Hypothesis.of(body, first, settings)])
    near = ends[0].fit if isinstance(ends[0], Hypothesis) else None
    ends += together([Hypothesis.of(body, one, settings, near) for one in others])
    found = [one for one in ends if isinstance(one, Hypothesis)]
    failed = list[str]()
    for wrong, asked_of in zip(ends, (first, *others), strict=True):
        if isinstance(wrong, Exception) and not (found and isinstance(wrong, JkrError)):
            raise wrong
        if isinstance(wrong, Exception) and asked_of.held is not None:
            failed.append(f"{asked_of.held.brief}: not in the average, {wrong}")
    # Of several bends each is to be told by the fit, or one makes up for another; adhesion's own attracts; and one of
    # any size, with which E* is anything, is held by what is likely of it, as the others are.
    plain = [
        one for one in found
        if ("ln_s" not in one.fit.names or one.fit.error("ln_s") < NUISANCE_VAGUE)
        and (len(bends := one.held.bends) < 2 or all(abs(term.size) > term.error for term in bends))
        and not any(term.size > 0 and not term.stays for term in bends)
    ]  # fmt: skip
    found = plain or found
    least = min(found, key=lambda one: one.fit.sigma)
    rows = np.unique(np.concatenate([one.fit.model.rows for one in found]))
    misfit = max(least.fit.sigma**2 / max(least.fit.spread.noise.level(rows.size), TINY), 1.0)
    costs = [one.cost + one.unlikely(rows, misfit) for one in found]
    order = np.argsort(costs)
    return [found[i] for i in order], [min(costs[i] - min(costs), 2 * NUISANCE_EXCLUDED) for i in order], failed


def _between(here: Values, there: Values) -> dict[str, float]:
    return {name: there[name] - value for name, value in here.items() if name in there}


def with_nuisance(fitted: Fit, nuisance: Nuisance) -> Fit:
    """The fit of a settled record with what is not known of its free rows in the errors."""
    t = t_quantile(fitted.settings.level, fitted.dof)
    # Of another fit than that of all directions, which hypotheses were averaged by, the shift is a part of the error.
    tied = () if fitted.verdict is None else fitted.verdict.tied
    apart = any(item.name == "E_star_approach" for item in fitted.estimates)
    averaged = not (tied or apart or fitted.settings.range)
    estimates = []
    for item in fitted.estimates:
        if item.error is not None and item.free:
            name = "E_star" if item.name == "E_star_approach" else item.name
            total = math.hypot(*(change.get(name, 0.0) for change in nuisance.changes))
            wide, shift = wider(item, {"free rows": total}, t), nuisance.shift.get(name, 0.0)
            by, least = averaged * shift, 0.0 if item.dimension in ("modulus", "work") else -math.inf
            value = max(wide.value + by, least)
            low = wide.low if wide.low is None or wide.low == least else max(wide.low + by, least)
            high = None if wide.high is None else max(wide.high + by, value)
            item = replace(wide, value=value, low=low, high=high, systematic=item.systematic)
            for what, parts in nuisance.spread.items():
                part = max(parts.get(name, 0.0), 0.0 if averaged else abs(shift))
                item = item.with_model(what, part) if part > NUISANCE_SEEN * abs(item.value) else item
        estimates.append(item)
    straight = bool(tied) and tied[0].straight
    words = (f"a straight base line: what bends it is {tied[0].name}",) if straight else nuisance.words
    return replace(fitted, estimates=tuple(estimates), held=words)

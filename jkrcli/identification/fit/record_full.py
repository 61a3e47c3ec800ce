"""The best rivals of each family, fitted in full where the data ask for them, and the one that is taken.

A rival is taken where its misfit is lower than that of the plain model by more than ``TUNING.falls``, in chi^2, and
what it leaves is no more than the noise of the free rows. Of several that are taken the first is the best one; those
within as much of it cannot be told from it.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import fdtrc

from ...base.arrays import Array
from ...base.errors import JkrError
from .body import FittedBody
from .force_curve import ForceCurveFit, ForceCurveModel, fit, misfit_at, rough, starts_of, windowed
from .record_change import AMOUNT, Change, RivalModel
from .record_rivals import RANGE, RIVALS, amount_of_range, finite_range, neck, range_of
from .record_scores import RecordRivals, Score, left_over
from .record_situation import Situation


@dataclass(frozen=True)
class FullTuning:
    """Which rivals are fitted in full, and when one is taken."""

    falls: float = 9.0  # choice: of chi^2, by which a rival must be better: three standard errors of one number
    passes: float = 1e-3  # choice: chance of what is left, by the noise of the free rows, below which it is misfit
    each: int = 3  # choice: of a family, its best by one step, which does not always name the right one
    steps: int = 20  # choice: guard, of a search that only finds out which rivals are worth a fit
    promising: float = 1.2  # choice: of the least sum of squares, up to which a rival is fitted to the end
    long: float = 0.5  # choice: of the amount of a range by which adhesion deforms the body, above which it is fitted
    softest: float = 10.0  # choice: of how far adhesion deforms the body, the longest range that is tried
    shorter: int = 12  # choice: ranges tried, each shorter by the root of 2, until the data leave one
    possible: float = 3.84  # theory: rise of chi^2 up to which a number is in its 95 % interval
    none: float = 1e-300  # choice: [J/m^2], for a logarithm
    rounds: int = 4  # choice: guard, fits of a change that is made about a fit
    settled: float = 0.1  # choice: standard errors of the modulus, by which the last round may move it


TUNING = FullTuning()


@dataclass(frozen=True, eq=False)
class InFull:
    """A rival fitted in full: its one-step ``score``, what was ``found``; ``misfit``: chi^2 of what is left in units of
    the noise of the free rows; ``chance``: that this noise leaves as much; ``falls``: how much lower than without, on
    the rows that both are judged by."""

    score: Score
    found: ForceCurveFit
    misfit: float
    chance: float
    falls: float

    @property
    def passes(self) -> bool:
        return self.found.ended and self.falls > TUNING.falls and self.chance > TUNING.passes


@np.errstate(all="ignore")
def bounded(body: FittedBody, found: ForceCurveFit, rivals: RecordRivals) -> RecordRivals:
    """The rivals, of which a range that may be long moves E* and w by what a fit with it does: one step is of first
    order in its square. ``found``: the fit without."""
    at = Situation(body, found)
    long = [i for i, one in enumerate(rivals.scores) if _is_long(at, one)] if not rivals.named else []
    scores = [_at_bound(at, one) if i in long else one for i, one in enumerate(rivals.scores)]
    return replace(rivals, scores=tuple(scores))


def _is_long(at: Situation, score: Score) -> bool:
    return score.name == RANGE.name and score.known > TUNING.long * amount_of_range(at, neck(at))


def _at_bound(at: Situation, score: Score) -> Score:
    """The score with the moves at its bound, or at the longest range tried that the data leave."""
    longest, change = min(range_of(at, score.known), TUNING.softest * neck(at)), finite_range(at)
    assert change is not None
    for step in range(TUNING.shorter):
        amount = amount_of_range(at, longest / 2 ** (step / 2))
        model = replace(RivalModel.of(at.model, change), known={**at.model.known, AMOUNT: amount})
        with contextlib.suppress(JkrError):
            found = fit(model, at.found.x, near=True)
            here = Situation(at.body, found)
            if left_over(here, at)[0] - left_over(at, here)[0] < TUNING.possible:
                E, w = math.log(here.modulus / at.modulus), math.log(max(here.work, TUNING.none) / at.work)
                return replace(score, amount=0.0, error=math.inf, known=amount, E_star=E / amount, w=w / amount)
    return score


@np.errstate(all="ignore")
def fitted_in_full(
    body: FittedBody, found: ForceCurveFit, fresh: ForceCurveModel, rivals: RecordRivals
) -> tuple[InFull, ...]:
    """The best of each family, by how much the misfit falls, those that are taken first; ``fresh``: the model of the
    record before any row was left out by what was ``found``."""
    at, tried = Situation(body, found), []
    fresh = replace(fresh, family=found.model.family)
    for score in _likeliest(rivals.scores):
        with contextlib.suppress(JkrError):  # what cannot be solved is not taken
            look = next(rival for rival in RIVALS if rival.name == score.name).look(at)
            tried += [(*_roughly(at, fresh, look, score.amount), look, score)] if isinstance(look, Change) else []
    least = min((cost for cost, *_ in tried), default=0.0)
    each = []
    for cost, x, change, score in tried:
        with contextlib.suppress(JkrError):
            each += [_in_full(at, RivalModel.of(fresh, change), x, score)] if cost <= TUNING.promising * least else []
    return tuple(sorted(each, key=lambda one: (not one.passes, -one.falls)))


def _likeliest(scores: Sequence[Score]) -> Iterator[Score]:
    """Those of each family that one step takes most from the misfit with: it detects, so that neither sign nor size of
    an amount that is not small says much."""
    ranked = sorted((one for one in scores if one.taken > TUNING.falls), key=lambda one: -one.taken)
    for family in dict.fromkeys(one.family for one in ranked):
        yield from [one for one in ranked if one.family == family][: TUNING.each]


def _roughly(at: Situation, fresh: ForceCurveModel, change: Change, amount: float) -> tuple[float, Array]:
    """About the least misfit with a ``change``, and its unknowns: from the best of its starts, and of what one step
    asks for."""
    low, high = change.limits.get(AMOUNT, (-math.inf, math.inf))
    starts = dict.fromkeys([(min(max(amount, low), high), *change.starts[0][1:]), *change.starts])
    model = RivalModel.of(fresh, change)
    x = _known(at, model)
    begun = [[np.append(x, start) for start in starts], [x for start in starts for x in _new(at, model, start)]]
    begun = begun if change.load is None else [[start] for start in begun[0]]
    searches = [rough(model, min(some, key=partial(misfit_at, model)), TUNING.steps) for some in begun if some]
    return min(searches, key=lambda one: one[0])


def _known(at: Situation, model: RivalModel) -> Array:
    """The unknowns of a ``model`` but its change's as they were found, those that were held at what they were."""
    values = at.model.values(at.found.x)
    roots = {f"r:{kind}": math.sqrt(max(values[f"q:{kind}"], 0.0)) for kind in (part.kind for part in model.stretches)}
    own = [name for name in model.names if name not in model.change.names]
    return np.array([({"turn": 0.0} | roots | values)[name] for name in own])


def _new(at: Situation, model: RivalModel, start: tuple[float, ...]) -> Iterator[Array]:
    """Unknowns about an amount to ``start`` from, as its body suggests."""
    if model.change.model is None or model.change.felt:
        return
    values = at.model.values(at.found.x) | dict(zip(model.change.names, start, strict=True))
    with contextlib.suppress(JkrError):
        yield from (np.append(x, start) for x in starts_of(model.followed(model.stretches[-1], values)))


def _in_full(at: Situation, model: RivalModel, x: Array, score: Score) -> InFull:
    found = fit(model, x, near=True)
    if (without := windowed(found)) is not found.model:
        found = fit(without, found.x, near=True)
    found = settled(found)
    here = Situation(at.body, found)
    (misfit, dof, loose), (plain, *_) = left_over(here, at), left_over(at, here)
    chance = float(fdtrc(dof, max(loose, 1), misfit / dof))
    return InFull(score, found, misfit, chance, plain - misfit)


def settled(found: ForceCurveFit) -> ForceCurveFit:
    """A fit whose change is made about it."""
    for _ in range(TUNING.rounds):
        model, before = found.model, found
        if not isinstance(model, RivalModel) or model.change.renewed is None or AMOUNT not in found.names:
            break
        found = fit(RivalModel.of(model, model.change.renewed(found)), found.x, near=True)
        if abs(found.value("ln_s") - before.value("ln_s")) < TUNING.settled * found.error("ln_s"):
            break
    return found

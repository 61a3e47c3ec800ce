"""The best rivals of each family, fitted in full where the data ask for them, and the one that is taken.

The best one is taken where its misfit is lower than that of the plain model by more than ``SCORES.tied``, in chi^2, and
what it leaves is no more than the noise of the free rows. Those within as much of it cannot be told from it.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import fdtrc

from ...base import MOST_SOLVES, TINY, Array, JkrError, SolveError
from .body import FittedBody
from .force_curve import ForceCurveFit, ForceCurveModel, fit, misfit_at, rough, starts_of, windowed
from .record_change import AMOUNT, Change, RivalModel
from .record_rivals import LONG, RANGE, RIVALS, TENSION, Known, amount_of_range, neck, tension_amount
from .record_scores import (
    ASKED,
    EXCLUDED,
    UNTOLD,
    RecordRivals,
    Score,
    Weighted,
    at_chance,
    least_of_named,
    left_over,
    off_folds,
    rows_of,
    told_rows,
)
from .record_scores import TUNING as SCORES
from .record_situation import Situation


@dataclass(frozen=True)
class FullTuning:
    """Which rivals are fitted in full, and when one is taken."""

    passes: float = 1e-3  # choice: chance of what is left, by the noise of the free rows, below which it is misfit
    each: int = 3  # choice: of a family, its best by one step, which does not always name the right one
    steps: int = 20  # choice: guard, of a search that only finds out which rivals are worth a fit
    promising: float = 1.5  # choice: of the least sum of squares, up to which a rival is fitted to the end
    endless: float = 400.0  # choice: of how far adhesion deforms the body, a range from which on no longer one differs
    ranges: tuple[float, ...] = (32.0, 8.0, 4.0, 2.83, 2.0, 1.41, 1.0, 0.71)  # choice: the same, those tried below it
    # choice: 2 tension/E* over the contact radius, those tried: the largest of which the first order holds, and smaller
    skins: tuple[float, ...] = (0.1, 0.05, 0.025, 0.0125, 0.006, 0.003, 0.0015)
    skinned: float = 0.03  # choice: [N/m], surface tension of gels and rubbers; of water 0.07
    leaning: float = 1.0  # theory: fall of chi^2 by a number that means nothing, from which on one that nobody
    # described counts
    halves: int = 2  # choice: bisections between the largest amount that the data leave and the next one
    smaller: int = 20  # choice: guard, halvings of the least of those tried down to one that the data leave
    # choice: standard errors by one step, up to the shortest of these, from which on none is; of 85 made
    # records that were left one, of Tabor numbers 0.15 to 1, the most was 3.5
    excluded: float = 6.0
    about: float = 0.5  # choice: standard errors, by which what a range does to a fit may be off
    falling: float = 2.0  # choice: of the step to come, by which chi^2 may still fall
    certain: float = 9.0  # choice: rise of chi^2 by three standard errors, from which on a change is excluded
    chords: int = 12  # choice: guard, steps with derivatives of the fit without; three to six are needed
    hopeless: float = 3000.0  # choice: rise of chi^2 after a step, from which on there are no more
    still: float = 0.02  # choice: standard errors, below which a step is the last one
    slow: float = 0.3  # choice: of w of the retraction, the least w of a slow edge to start from where none advanced
    settled: float = 0.1  # choice: standard errors of the modulus, by which the last round may move it


TUNING = FullTuning()
Moves = tuple[float, float, float]  # rises of chi^2 and of the logs of E* and w


@dataclass(frozen=True, eq=False)
class InFull:
    """A rival fitted in full: its one-step ``score``, what was ``found``; ``misfit``: chi^2 of what is left in units of
    the noise of the free rows, where no row is next to a fold; ``chance``: that this noise leaves as much; ``falls``:
    how much lower it is than without, on the rows of both that are off the folds."""

    score: Score
    found: ForceCurveFit
    misfit: float
    chance: float
    falls: float

    @property
    def passes(self) -> bool:
        return self.found.ended and self.chance > TUNING.passes

    def taken(self, best: InFull) -> bool:
        """Whether the ``best`` one rejects the model without and this one leaves about as little, as noise would."""
        return self.passes and best.falls > SCORES.tied and self.falls > best.falls - SCORES.tied


@np.errstate(all="ignore")
def bounded(at: Situation, rivals: RecordRivals, known: Known) -> RecordRivals:
    """The rivals, of which those that are likely before the data move E* and w by what a fit with as much of them as
    is possible does: one step trusts no row next to a fold. ``at``: the fit without."""
    if rivals.named:
        return rivals
    scores = [_bounded(at, score, known) for score in rivals.scores]
    named = next((_with_alike(one, scores) for one in scores if one.word == ASKED), ())
    return replace(rivals, scores=tuple(scores), named=named)


def _bounded(at: Situation, score: Score, known: Known) -> Score:
    look = _look(at, score) if score.most > 0 or score.name in (RANGE.name, TENSION.name) else None
    if not isinstance(look, Change):
        return score
    own = Weighted.of(at, off_folds(at))
    if score.name == RANGE.name:
        return _of_amounts(at, own, score, look, _along(at, own, look, _ranges(at, score, known.range)))
    if score.name == TENSION.name:
        return _of_tension(at, own, score, look, known.tension)
    return _at_most(at, Weighted.of(at), look, score)


def _with_alike(asked: Score, scores: Sequence[Score]) -> tuple[Score, ...]:
    """The one that is ``asked`` for, and those that take nearly as much of the misfit, though they see fewer rows."""
    limits = {rival.name: rival.limits() for rival in RIVALS}
    least = least_of_named(asked.taken)
    others = [one for one in scores if one is not asked and one.taken > least]
    return (asked, *(one for one in others if limits[one.name][0] <= one.amount <= limits[one.name][1]))


def _look(at: Situation, score: Score) -> Change | Array | None:
    return next(rival for rival in RIVALS if rival.name == score.name).look(at)


def _at_most(at: Situation, own: Weighted, change: Change, score: Score) -> Score:
    """The score with the moves at the largest amount that is possible."""
    found = _stepped(own, _held(at, change, score.most))
    E, w = (math.nan, math.nan) if found is None else _moves(own, found[1])
    return replace(score, E_star=E / score.most, w=w / score.most) if math.isfinite(E + w) else score


def _of_tension(at: Situation, own: Weighted, score: Score, change: Change, known: float) -> Score:
    """The same of surface tensions up to the one that is ``known`` [N/m], or the usual one where the data lean to any:
    by more than can be chance."""
    most = tension_amount(at, known or TUNING.skinned)
    tried: dict[float, Moves | None] = {}
    least, leans = 0.0, False
    for amount in sorted({min(most, TUNING.skins[0]), *(amount for amount in TUNING.skins if amount < most)}):
        tried[amount] = found = _left_moves(own, _held(at, change, amount))
        rises = found is not None and found[0] > least
        least = least if found is None else min(least, found[0])
        leans = bool(known) or -least > TUNING.leaning or at_chance(at.found, -least) < SCORES.chance / len(RIVALS)
        if (found is None and len(tried) > 1) or (rises and not leans):
            break  # no larger one is left either, or takes more
    return _of_amounts(at, own, score, change, tried) if leans else score


def _of_amounts(
    at: Situation, own: Weighted, score: Score, change: Change, tried: Mapping[float, Moves | None]
) -> Score:
    """The score with the largest moves at those amounts ``tried`` of a ``change`` that the data leave; it is asked for
    where one takes enough of the misfit. Those beyond the interval count by the chord to it, as moves may grow steeply
    there."""
    tried = _down_to_left(at, own, score, change, tried)
    near = {amount: found for amount, found in tried.items() if found is not None}
    left = [amount for amount, found in near.items() if found[0] < score.wide**2]
    if not left:
        return score
    end = max(left)
    beyond = min((amount for amount in tried if amount > end), default=0.0)
    for _ in range(TUNING.halves * (beyond > 0)):
        middle = math.sqrt(end * beyond)
        if (found := _left_moves(own, _held(at, change, middle))) is not None:
            near[middle] = found
        end, beyond = (end, middle) if found is None or found[0] > score.wide**2 else (middle, beyond)
    best = min(near, key=lambda amount: near[amount][0])
    chords = [min(1.0, score.wide / math.sqrt(max(found[0], TINY))) for found in near.values()]
    moves = np.max([chord * np.abs(found[1:]) for chord, found in zip(chords, near.values(), strict=True)], axis=0)
    taken = -near[best][0]
    if (chance := at_chance(at.found, taken)) < SCORES.chance / len(RIVALS):
        asked = _moving(score, best, near[best][1:])
        return replace(asked, amount=best, word=ASKED, chance=chance, taken=taken)
    told = _moving(score, end, moves.tolist())
    return replace(told, amount=best * (taken > 0), chance=chance, taken=max(taken, 0.0))


def _down_to_left(
    at: Situation, own: Weighted, score: Score, change: Change, tried: Mapping[float, Moves | None]
) -> dict[float, Moves | None]:
    """Those ``tried``, and where the data leave none of them smaller ones, each half of the last, down to one that they
    leave."""
    tried, least = dict(tried), min(tried)
    for _ in range(TUNING.smaller):
        if any(found is not None and found[0] < score.wide**2 for found in tried.values()):
            break
        least /= 2
        tried[least] = _left_moves(own, _held(at, change, least))
    return tried


def _ranges(at: Situation, score: Score, longest: float) -> list[float]:
    """Amounts of ranges to try, from the ``longest`` [m] that there may be down to the one that is likely before the
    data; where one step excludes all that are longer, up to what it leaves for certain."""
    deep, shortest = neck(at), TUNING.ranges[-1] * neck(at)
    certain = max(score.amount, 0.0) + TUNING.excluded * score.error
    if amount_of_range(at, shortest) > certain:
        return [min(score.known, certain)]
    known = [longest] * (shortest < longest < TUNING.endless * deep)
    ranges = [*known, *(r * deep for r in (TUNING.endless, *TUNING.ranges) if r * deep < longest)]
    amounts = [amount_of_range(at, z0) for z0 in ranges]
    return [*amounts, *[score.known] * (score.known < min(amounts, default=math.inf))]


def _along(at: Situation, own: Weighted, change: Change, amounts: Iterable[float]) -> dict[float, Moves | None]:
    """The same as ``_left_moves`` at several ``amounts`` of a change, each from where the next smaller one led to."""
    moves: dict[float, Moves | None] = {}
    begin = own.x
    for amount in sorted(amounts):
        end = _stepped(own, _held(at, change, amount), TUNING.certain, TUNING.about, begin)
        moves[amount] = _left(own, end)
        begin = own.x if end is None or moves[amount] is None else end[1]
    return moves


def _left_moves(own: Weighted, model: RivalModel) -> Moves | None:
    """By how much chi^2, and the logs of E* and w, rise with a change; None where the data exclude it for certain."""
    return _left(own, _stepped(own, model, TUNING.certain, TUNING.about))


def _left(own: Weighted, end: tuple[float, Array] | None) -> Moves | None:
    """The same by the ``end`` of the steps of a model."""
    moves = None if end is None else (end[0], *_moves(own, end[1]))
    return moves if moves is not None and moves[0] < TUNING.certain and np.isfinite(moves).all() else None


def _moves(own: Weighted, x: Array) -> tuple[float, float]:
    """By how much the logs of E* and w differ at the unknowns ``x``."""
    here, there = (own.at.model.values(one) for one in (own.x, x))
    works = [max(one[f"q:{part.kind}"] for part in own.at.model.stretches) for one in (here, there)]
    E, (old, new) = there["ln_s"] - here["ln_s"], (max(work, TINY) for work in works)
    return E, E + math.log(new / old) if own.at.work else 0.0


def _moving(score: Score, amount: float, moves: Sequence[float]) -> Score:
    """The score of a rival that ``moves`` the logs of E* and w at an ``amount``."""
    E, w = (float(move) / amount for move in moves)
    word = UNTOLD if max(map(abs, moves)) > SCORES.matters else EXCLUDED
    return replace(score, amount=0.0, error=math.inf, known=amount, E_star=E, w=w, word=word)


def _held(at: Situation, change: Change, amount: float) -> RivalModel:
    """The model with an amount of a change that is known."""
    return replace(RivalModel.of(at.model, change), known={**at.model.known, AMOUNT: amount})


def _stepped(
    own: Weighted, model: RivalModel, least: float = math.inf, still: float = TUNING.still, begin: Array | None = None
) -> tuple[float, Array] | None:
    """By how much chi^2 rises in a ``model`` whose change is known, and its unknowns, by steps with the derivatives of
    the fit without, down to ``still`` standard errors, from ``begin`` on, else from that fit; None where they do not
    settle, or come to a contact that is nowhere stable, or chi^2 will not fall to about ``least``."""
    x, size, excess = own.x if begin is None else begin, math.inf, math.inf
    with contextlib.suppress(SolveError, OverflowError):  # unknowns that no row tells may go anywhere
        for _ in range(TUNING.chords):
            step, left = own.step(model.off(x, 0.0))
            before, size, x, excess = size, own.size(step), x - step, left - own.left
            if not (size < before and excess < min(TUNING.hopeless, least + TUNING.falling * size)):
                return None
            if size < still:
                break
        return excess, x
    return None


@np.errstate(all="ignore")
def fitted_in_full(
    body: FittedBody, found: ForceCurveFit, fresh: ForceCurveModel, rivals: RecordRivals
) -> tuple[InFull, ...]:
    """The best of each family, by how much the misfit falls, those that pass first; ``fresh``: the model of the
    record before any row was left out by what was ``found``."""
    at, tried = Situation(body, found), []
    fresh = replace(fresh, family=found.model.family)
    for score in _likeliest(rivals):
        with contextlib.suppress(JkrError):  # what cannot be solved is not taken
            look = _look(at, score)
            tried += [(*_roughly(at, fresh, look, score.amount), look, score)] if isinstance(look, Change) else []
    least = min((cost for cost, *_ in tried), default=0.0)
    each = []
    for cost, x, change, score in tried:
        with contextlib.suppress(JkrError):
            each += [_in_full(at, RivalModel.of(fresh, change), x, score)] if cost <= TUNING.promising * least else []
    return tuple(sorted(each, key=lambda one: (not one.passes, -one.falls)))


def _likeliest(rivals: RecordRivals) -> Iterator[Score]:
    """Those of each family that one step takes most from the misfit with: it detects, so that neither sign nor size of
    an amount that is not small says much."""
    asked = [one for one in rivals.scores if one.taken > SCORES.tied or one in rivals.named]
    ranked = sorted(asked, key=lambda one: -one.taken)
    of_range = dict(zip([LONG.name], (one for one in rivals.scores if one.name == RANGE.name), strict=False))  # of all
    for family in dict.fromkeys(one.family for one in ranked):
        best = [one for one in ranked if one.family == family][: TUNING.each]
        yield from dict.fromkeys(of_range.get(one.name, one) for one in best)


def _roughly(at: Situation, fresh: ForceCurveModel, change: Change, amount: float) -> tuple[float, Array]:
    """About the least misfit with a ``change``, and its unknowns: from the best of its starts and what one step asks
    for, and from the best that the body suggests at each of these."""
    low, high = change.limits.get(AMOUNT, (-math.inf, math.inf))
    starts = dict.fromkeys([(min(max(amount, low), high), *change.starts[0][1:]), *change.starts])
    model = RivalModel.of(fresh, change)
    x = _known(at, model, at.found.x)
    plain, new = [np.append(x, start) for start in starts], [[*_new(at, model, start)] for start in starts]
    begun = [plain, *new]
    if change.felt and change.bends is not None:
        begun = [[start] for start in _valleys(at, model, starts)]
    if change.load is not None or change.back is not None:  # of histories, which have several minima
        begun = [[start] for group in ([plain] if change.back is None else new) for start in group]
    searches = []
    for some in filter(None, begun):
        with contextlib.suppress(JkrError):  # others may come to an end
            searches.append(rough(model, min(some, key=partial(misfit_at, model)), TUNING.steps))
    if not searches:
        raise SolveError("no curve with this change resembles the record")
    return min(searches, key=lambda one: one[0])


def _valleys(at: Situation, model: RivalModel, starts: Iterable[tuple[float, ...]]) -> Iterator[Array]:
    """Unknowns to start from with those of the fit without as an amount would have them, at those amounts that leave no
    more than the ones next to them."""
    own = Weighted.of(at, off_folds(at))
    tried = [(start, _stepped(own, _held(at, model.change, start[0]), still=TUNING.about)) for start in sorted(starts)]
    left = np.array([math.inf, *(math.inf if found is None else found[0] for _, found in tried), math.inf])
    lowest = left[1:-1] <= np.minimum(left[:-2], left[2:])
    for (start, found), low in zip(tried, lowest, strict=True):
        if found is not None and low:
            yield np.append(_known(at, model, found[1]), start)


def _known(at: Situation, model: RivalModel, x: Array) -> Array:
    """The unknowns of a ``model`` but its change's as they are at ``x``, those that were held at what they were."""
    values = at.model.values(x)
    roots = {f"r:{kind}": math.sqrt(max(values[f"q:{kind}"], 0.0)) for kind in (part.kind for part in model.stretches)}
    own = [name for name in model.names if name not in model.change.names]
    return np.array([({"turn": 0.0} | roots | values)[name] for name in own])


def _new(at: Situation, model: RivalModel, start: tuple[float, ...]) -> Iterator[Array]:
    """Unknowns about an amount to ``start`` from, as its body suggests."""
    if model.change.back is not None:
        x, way, back = _known(at, model, at.found.x), model.stretches[0], model.stretches[-1]
        slow = max(at.model.values(at.found.x)[f"q:{way.kind}"], TUNING.slow * x[model.names.index(f"q:{back.kind}")])
        x[model.names.index(f"q:{back.kind}")] = slow
        yield np.append(x, start)
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
    misfit, dof, loose = left_over(here, told_rows(here))
    chance = float(fdtrc(dof, max(loose, 1), misfit / dof))
    falls = left_over(at, rows_of(at, here))[0] - left_over(here, rows_of(here, at))[0]
    return InFull(score, found, misfit, chance, falls)


def settled(found: ForceCurveFit) -> ForceCurveFit:
    """A fit whose change is made about it."""
    for _ in range(MOST_SOLVES):
        model, before = found.model, found
        if not isinstance(model, RivalModel) or model.change.renewed is None or AMOUNT not in found.names:
            break
        found = fit(RivalModel.of(model, model.change.renewed(found)), found.x, near=True)
        if abs(found.value("ln_s") - before.value("ln_s")) < TUNING.settled * found.error("ln_s"):
            break
    return found

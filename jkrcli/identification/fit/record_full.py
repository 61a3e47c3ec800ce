"""The best rivals of each family, fitted in full where the data ask for them, and the one that is taken.

The best one is taken where its misfit is lower than that of the plain model by more than ``SCORES.tied``, in chi^2, and
what it leaves is no more than the noise of the free rows. Those within as much of it cannot be distinguished.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.special import fdtrc

from ...base import MOST_SOLVES, MOST_STEPS, TINY, Array, JkrError, SolveError
from ...bodies import GEL_TENSION
from .fitted_record import FittedRecord
from .force_curve import ForceCurveModel
from .force_curve_fit import ForceCurveFit, fit, misfit_at, rough, windowed
from .force_curve_starts import starts_of
from .record_change import AMOUNT, Change, RivalModel
from .record_rival_adhesion import TUNING as ADHESION
from .record_rival_adhesion import amount_of_range, neck
from .record_rival_body import amount_of_tension
from .record_rivals import LONG, RANGE, RIVALS, TENSION
from .record_scores import (
    DETECTED,
    EXCLUDED,
    UNDECIDED,
    Linearised,
    RecordRivals,
    Score,
    chance_of,
    common_rows,
    least_taken,
    misfit_left,
    misfit_of,
    off_folds,
    regular_rows,
)
from .record_scores import TUNING as SCORES
from .statistics import TUNING as STATISTICS


@dataclass(frozen=True)
class FullTuning:
    """Which rivals are fitted in full, and when one is taken."""

    each: int = 3  # choice: of a family, its best by one step, which does not always name the right one
    steps: int = 20  # choice: guard, of a search that only finds out which rivals are worth a fit
    promising: float = 1.5  # choice: of the least sum of squares, up to which a rival is fitted to the end
    # choice: of how far adhesion deforms the body, ranges that are tried below endless ones
    ranges: tuple[float, ...] = (32.0, 8.0, 4.0, 2.83, 2.0, 1.41, 1.0, 0.71)
    # choice: 2 tension/E* over the contact radius, those tried: the largest of which the first order holds, and smaller
    skins: tuple[float, ...] = (0.1, 0.05, 0.025, 0.0125, 0.006, 0.003, 0.0015)
    leaning: float = 1.0  # theory: fall of chi^2 by a number that means nothing, from which on one that nobody
    # described counts
    halves: int = 2  # choice: bisections between the largest amount that the data leave and the next one
    # choice: standard errors by one step, up to the shortest of these, from which on none is; of 85 made
    # records that were left one, of Tabor numbers 0.15 to 1, the most was 3.5
    excluded: float = 6.0
    about: float = 0.5  # choice: standard errors, by which what a range does to a fit may be off
    falling: float = 2.0  # choice: of the step to come, by which chi^2 may still fall
    still: float = 0.02  # choice: standard errors, below which a step is the last one
    slow: float = 0.3  # choice: of w of the retraction, the least w of a slow edge to start from where none advanced
    settled: float = 0.1  # choice: standard errors of the modulus, by which the last round may move it


TUNING = FullTuning()
Moves = tuple[float, float, float]  # rises of chi^2 and of the logs of E* and w


@dataclass(frozen=True, eq=False)
class RivalFit:
    """A rival fitted in full: its one-step ``score``; ``chance``: that the noise of the free rows leaves as much, where
    no row is next to a fold; ``falls``: how much lower chi^2 is than without, on the rows of both that are off the
    folds, in units of the noise without."""

    score: Score
    fit: ForceCurveFit
    chance: float
    falls: float

    @property
    def passes(self) -> bool:
        return self.fit.ended and self.chance > STATISTICS.improbable

    def taken(self, best: RivalFit) -> bool:
        """Whether the ``best`` one rejects the model without and this one leaves about as little, as noise would."""
        return self.passes and best.falls > SCORES.tied and self.falls > best.falls - SCORES.tied


@np.errstate(all="ignore")
def bounded(record: FittedRecord, rivals: RecordRivals) -> RecordRivals:
    """The rivals, of which those that are likely before the data move E* and w by what a fit with as much of them as
    is possible does: one step trusts no row next to a fold. ``record``: the fit without."""
    if rivals.named:
        return rivals
    scores = [_bounded(record, score) for score in rivals.scores]
    named = next((_with_alike(one, scores) for one in scores if one.word == DETECTED), ())
    return replace(rivals, scores=tuple(scores), named=named)


def _bounded(record: FittedRecord, score: Score) -> Score:
    change = _effect(record, score) if score.most > 0 or score.name in (RANGE.name, TENSION.name) else None
    if not isinstance(change, Change):
        return score
    if score.name not in (RANGE.name, TENSION.name):
        return _at_most(Linearised.of(record), change, score)
    tried = _Amounts(Linearised.of(record, off_folds(record)), change)
    return _of_ranges(tried, score) if score.name == RANGE.name else _of_tension(tried, score)


def _with_alike(best: Score, scores: Sequence[Score]) -> tuple[Score, ...]:
    """The ``best``, and those that take nearly as much of the misfit, though they see fewer rows."""
    limits, least = {rival.name: rival.limits for rival in RIVALS}, least_taken(best.taken)
    others = [one for one in scores if one is not best and one.taken > least]
    return (best, *(one for one in others if limits[one.name][0] <= one.amount <= limits[one.name][1]))


def _effect(record: FittedRecord, score: Score) -> Change | Array | None:
    return next(rival for rival in RIVALS if rival.name == score.name).effect(record)


def _at_most(near: Linearised, change: Change, score: Score) -> Score:
    """The score with the moves at the largest amount that is possible."""
    end = _followed(near, _with_amount(near.record, change, score.most))
    E, w = (math.nan, math.nan) if end is None else _moves(near, end[1])
    return replace(score, E_star=E / score.most, w=w / score.most) if math.isfinite(E + w) else score


@dataclass(frozen=True, eq=False)
class _Amounts:
    """What the data say of those amounts of a ``change`` that were tried, ``near`` the fit without: by how much chi^2
    and the logs of E* and w rise, None where the data exclude it for certain, by three standard errors, or where steps
    do not settle; ``ends``: the unknowns of those that are left."""

    near: Linearised
    change: Change
    moves: dict[float, Moves | None] = field(default_factory=dict)
    ends: dict[float, Array] = field(default_factory=dict)

    @property
    def left(self) -> dict[float, Moves]:
        """The moves at those that are left."""
        return {amount: moves for amount, moves in self.moves.items() if moves is not None}

    def at(self, amount: float) -> Moves | None:
        """The moves at an amount, from where those below lead."""
        model = _with_amount(self.near.record, self.change, amount)
        end = _followed(self.near, model, SCORES.tied, TUNING.about, self._begin(amount))
        moves = None if end is None else (end[0], *_moves(self.near, end[1]))
        self.moves[amount] = None
        if end is not None and moves is not None and moves[0] < SCORES.tied and np.isfinite(moves).all():
            self.moves[amount], self.ends[amount] = moves, end[1]
        return self.moves[amount]

    def _begin(self, amount: float) -> Array:
        """Unknowns at an amount on the straight line through the two below; as without, where none is left next to it:
        another valley may begin there."""
        points = [(0.0, self.near.x)]
        for less in sorted(less for less in self.moves if less < amount):
            points = [*points, (less, self.ends[less])] if less in self.ends else points[:1]
        (first, x), (last, y) = points[-2:][0], points[-1]
        return y + (y - x) * ((amount - last) / (last - first)) if last > first else y


def _of_ranges(tried: _Amounts, score: Score) -> Score:
    """The score with the moves at ranges up to the longest that there may be."""
    for amount in sorted({*_ranges(tried.near.record, score)}):
        tried.at(amount)
    return _of_amounts(tried, score)


def _of_tension(tried: _Amounts, score: Score) -> Score:
    """The same of surface tensions up to the largest that is known, or the usual one where the data lean to any: by
    more than can be chance."""
    record, known = tried.near.record, tried.near.record.known.tension
    most, least, leans = amount_of_tension(record, known or GEL_TENSION), 0.0, False
    for amount in sorted({min(most, TUNING.skins[0]), *(amount for amount in TUNING.skins if amount < most)}):
        moves = tried.at(amount)
        rises = moves is not None and moves[0] > least
        least = least if moves is None else min(least, moves[0])
        leans = bool(known) or -least > TUNING.leaning or _by_chance(record, -least)
        if (moves is None and len(tried.moves) > 1) or (rises and not leans):
            break  # no larger one is left either, or takes more
    return _of_amounts(tried, score) if leans else score


def _by_chance(record: FittedRecord, taken: float) -> bool:
    """Whether so much of chi^2 is more than chance takes with any of the rivals."""
    return chance_of(record.fit, taken) < SCORES.chance / len(RIVALS)


def _of_amounts(tried: _Amounts, score: Score) -> Score:
    """The score with the largest moves at those amounts ``tried`` that the data leave, where they leave none, at
    smaller ones, each half of the last; it is detected where one takes enough of the misfit. Those beyond the interval
    count by the chord to it, as moves may grow steeply there."""
    within, least = score.quantile**2, min(tried.moves)
    for _ in range(MOST_STEPS):
        if any(moves[0] < within for moves in tried.left.values()):
            break
        tried.at(least := least / 2)
    else:
        return score
    end = max(amount for amount, moves in tried.left.items() if moves[0] < within)
    beyond = min((amount for amount in tried.moves if amount > end), default=0.0)
    for _ in range(TUNING.halves * (beyond > 0)):
        middle = math.sqrt(end * beyond)
        moves = tried.at(middle)
        end, beyond = (end, middle) if moves is None or moves[0] > within else (middle, beyond)
    possible, record = tried.left, tried.near.record
    best = min(possible, key=lambda amount: possible[amount][0])
    taken = -possible[best][0]
    chance = chance_of(record.fit, taken)
    if _by_chance(record, taken):
        return replace(_moving(score, best, possible[best][1:]), amount=best, word=DETECTED, chance=chance, taken=taken)
    chords = [min(1.0, score.quantile / math.sqrt(max(moves[0], TINY))) * np.abs(moves[1:])
              for moves in possible.values()]  # fmt: skip
    moving = _moving(score, end, np.max(chords, axis=0).tolist())
    return replace(moving, amount=best * (taken > 0), chance=chance, taken=max(taken, 0.0))


def _ranges(record: FittedRecord, score: Score) -> list[float]:
    """Amounts of ranges to try, from the longest that there may be down to the one that is likely before the data;
    where one step excludes all that are longer, up to what it leaves for certain."""
    longest, deep, shortest = record.known.range, neck(record), TUNING.ranges[-1] * neck(record)
    certain = max(score.amount, 0.0) + TUNING.excluded * score.error
    if amount_of_range(record, shortest) > certain:
        return [min(score.known, certain)]
    known = [longest] * (shortest < longest < ADHESION.endless * deep)
    ranges = [*known, *(r * deep for r in (ADHESION.endless, *TUNING.ranges) if r * deep < longest)]
    amounts = [amount_of_range(record, z0) for z0 in ranges]
    return [*amounts, *[score.known] * (score.known < min(amounts, default=math.inf))]


def _moves(near: Linearised, x: Array) -> tuple[float, float]:
    """By how much the logs of E* and w differ at the unknowns ``x``; where w falls its relative change, which has an
    end: w may come to 0."""
    model = near.record.model
    here, there = (model.values(one) for one in (near.x, x))
    E = there["ln_s"] - here["ln_s"]
    if not near.record.work:
        return E, 0.0
    old, new = (max(0.0, *(one[f"q:{part.kind}"] for part in model.stretches)) for one in (here, there))
    rise = (new * math.exp(E) - old) * math.exp(here["ln_s"]) / near.record.work
    return E, math.log1p(rise) if rise > 0 else rise


def _moving(score: Score, amount: float, moves: Sequence[float]) -> Score:
    """The score of a rival that ``moves`` the logs of E* and w at an ``amount``."""
    E, w = (float(move) / amount for move in moves)
    word = UNDECIDED if max(map(abs, moves)) > SCORES.matters else EXCLUDED
    return replace(score, amount=0.0, error=math.inf, known=amount, E_star=E, w=w, word=word)


def _with_amount(record: FittedRecord, change: Change, amount: float) -> RivalModel:
    """The model with an amount of a change that is known."""
    return replace(RivalModel.of(record.model, change), known={**record.model.known, AMOUNT: amount})


def _followed(
    near: Linearised, model: RivalModel, most: float = math.inf, still: float = TUNING.still, begin: Array | None = None
) -> tuple[float, Array] | None:
    """By how much chi^2 rises in a ``model`` whose change is known, and its unknowns, by steps with the derivatives of
    the fit without, down to ``still`` standard errors, from ``begin`` on, else from that fit; None where they do not
    settle, or come to a contact that is nowhere stable, or chi^2 will not fall to about ``most``."""
    x, size, excess = near.x if begin is None else begin, math.inf, math.inf
    with contextlib.suppress(SolveError, ArithmeticError):  # unknowns that no row determines may go anywhere
        for _ in range(MOST_STEPS):
            step, left = near.step(model.off(x, 0.0))
            before, size, x, excess = size, near.size(step), x - step, left - near.left
            if not (size < before and excess < most + TUNING.falling * size):
                return None
            if size < still:
                break
        return excess, x
    return None


@np.errstate(all="ignore")
def fitted_in_full(record: FittedRecord, fresh: ForceCurveModel, rivals: RecordRivals) -> tuple[RivalFit, ...]:
    """The best of each family, by how much the misfit falls, those that pass first; ``fresh``: the model of the
    record before its fit left any row out."""
    fresh, begun = replace(fresh, family=record.model.family), []
    for score in _likeliest(rivals):
        with contextlib.suppress(JkrError):  # what cannot be solved is not taken
            if isinstance(change := _effect(record, score), Change):
                begun.append((*_roughly(record, fresh, change, score.amount), change, score))
    most = TUNING.promising * min((cost for cost, *_ in begun), default=0.0)
    fits = []
    for cost, x, change, score in begun:
        if cost <= most:
            with contextlib.suppress(JkrError):
                fits.append(_in_full(record, RivalModel.of(fresh, change), x, score))
    return tuple(sorted(fits, key=lambda one: (not one.passes, -one.falls)))


def _likeliest(rivals: RecordRivals) -> Iterator[Score]:
    """Those of each family that one step takes most from the misfit with: it detects, so that neither sign nor size of
    an amount that is not small says much. The range of adhesion stands for a long one, which has a column alone."""
    detected = [one for one in rivals.scores if one.taken > SCORES.tied or one in rivals.named]
    ranked = sorted(detected, key=lambda one: -one.taken)
    of_range = next((one for one in rivals.scores if one.name == RANGE.name), None)
    for family in dict.fromkeys(one.family for one in ranked):
        best = [one for one in ranked if one.family == family][: TUNING.each]
        yield from dict.fromkeys((of_range or one) if one.name == LONG.name else one for one in best)


def _roughly(record: FittedRecord, fresh: ForceCurveModel, change: Change, amount: float) -> tuple[float, Array]:
    """About the least misfit with a ``change``, and its unknowns: from the best of its starts and what one step asks
    for, and from the best that the body suggests at each of these."""
    low, high = change.limits.get(AMOUNT, (-math.inf, math.inf))
    starts = dict.fromkeys([(min(max(amount, low), high), *change.starts[0][1:]), *change.starts])
    model = RivalModel.of(fresh, change)
    x = _unknowns(record, model, record.fit.x)
    plain, new = [np.append(x, start) for start in starts], [[*_new(record, model, start)] for start in starts]
    groups = [plain, *new]
    if change.coupled and change.log_changes is not None:
        groups = [[start] for start in _valleys(record, model, starts)]
    if change.loads is not None or change.loads_back is not None:  # of histories, which have several minima
        groups = [[start] for group in ([plain] if change.loads_back is None else new) for start in group]
    searches = []
    for group in filter(None, groups):
        with contextlib.suppress(JkrError):  # others may come to an end
            searches.append(rough(model, min(group, key=partial(misfit_at, model)), TUNING.steps))
    if not searches:
        raise SolveError("no curve with this change resembles the record")
    return min(searches, key=lambda one: one[0])


def _valleys(record: FittedRecord, model: RivalModel, starts: Iterable[tuple[float, ...]]) -> Iterator[Array]:
    """Unknowns to start from with those of the fit without as an amount would have them, at those amounts that leave no
    more than the ones next to them."""
    near, starts = Linearised.of(record, off_folds(record)), sorted(starts)
    ends = [_followed(near, _with_amount(record, model.change, start[0]), still=TUNING.about) for start in starts]
    left = np.array([math.inf, *(math.inf if end is None else end[0] for end in ends), math.inf])
    lowest = left[1:-1] <= np.minimum(left[:-2], left[2:])
    for start, end, low in zip(starts, ends, lowest, strict=True):
        if end is not None and low:
            yield np.append(_unknowns(record, model, end[1]), start)


def _unknowns(record: FittedRecord, model: RivalModel, x: Array) -> Array:
    """The unknowns of a ``model`` but its change's as they are at ``x``, those that were known at what they were."""
    values = record.model.values(x)
    roots = {f"r:{part.kind}": math.sqrt(max(values[f"q:{part.kind}"], 0.0)) for part in model.stretches}
    own = [name for name in model.names if name not in model.change.names]
    return np.array([({"turn": 0.0} | roots | values)[name] for name in own])


def _new(record: FittedRecord, model: RivalModel, start: tuple[float, ...]) -> Iterator[Array]:
    """Unknowns about an amount to ``start`` from, as its body suggests."""
    if model.change.loads_back is not None:
        x, i = _unknowns(record, model, record.fit.x), model.names.index(f"q:{model.stretches[-1].kind}")
        x[i] = max(record.values[f"q:{model.stretches[0].kind}"], TUNING.slow * x[i])
        yield np.append(x, start)
    if model.change.model is None or model.change.coupled:
        return
    values = {**record.values, **dict(zip(model.change.names, start, strict=True))}
    with contextlib.suppress(JkrError):
        yield from (np.append(x, start) for x in starts_of(model.followed(model.stretches[-1], values)))


def _in_full(record: FittedRecord, model: RivalModel, x: Array, score: Score) -> RivalFit:
    full = fit(model, x, near=True)
    if (without := windowed(full)) is not full.model:
        full = fit(without, full.x, near=True)
    here = FittedRecord(record.body, settled(full))
    misfit, dof, loose = misfit_left(here, regular_rows(here))
    chance = float(fdtrc(dof, max(loose, 1), misfit / dof))
    noise = record.fit.spread.noise  # for all rivals: misfit that is slow may pass for noise of the fit's own
    plain = misfit_of(record, common_rows(record, here), noise)
    falls = plain - misfit_of(here, common_rows(here, record), noise)
    return RivalFit(score, here.fit, chance, falls)


def settled(full: ForceCurveFit) -> ForceCurveFit:
    """The fit whose change, where it is made about one, is made about itself."""
    for _ in range(MOST_SOLVES):
        model, before = full.model, full
        if not isinstance(model, RivalModel) or model.change.recentred is None or AMOUNT not in full.names:
            break
        full = fit(RivalModel.of(model, model.change.recentred(full)), full.x, near=True)
        if abs(full.value("ln_s") - before.value("ln_s")) < TUNING.settled * full.error("ln_s"):
            break
    return full

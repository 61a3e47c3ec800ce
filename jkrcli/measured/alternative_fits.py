"""Alternatives of a raw record in full: how far amounts that the data leave move what was fitted, and the best ones
fitted.

Those that are likely before the data are followed from the fit without to the largest amount that is possible. The best
of each family is fitted where the data need it; one is taken where its misfit is lower than that of the plain model
by more than ``SCORE_TIED``, in chi^2, and what it leaves is no more than the noise of the free rows. Those within as
much of it cannot be distinguished.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..base import numerics
from ..base.errors import JkrError, SolveError
from ..base.numerics import MOST_SOLVES, MOST_STEPS, TINY, Array
from ..bodies.problem import GEL_TENSION
from .fitted_record import FittedRecord
from .force_curve import FIT_BLUNT, ForceCurveFit, ForceCurveModel, fit, misfit_at, roughly, starts_of, windowed
from .free_rows import FREE_BENDS
from .hypotheses import ADHESION_ENDLESS, ALTERNATIVES, amount_of_range, amount_of_tension
from .least_squares import STATISTICS_IMPROBABLE, Spectrum, in_time
from .lockstep import Flow, alone, ask, beside, quiet
from .model_changes import (
    AMOUNT,
    ANY,
    LITTLE,
    BodyChange,
    Change,
    ChangedModel,
    LoadsChange,
    StiffnessChange,
    bodies_at,
    by_bodies,
    changed_offs,
)
from .priors import LONG, PRIORS, RANGE, TENSION
from .score_tests import (
    DETECTED,
    EXCLUDED,
    SCORE_CHANCE,
    SCORE_MATTERS,
    SCORE_TIED,
    UNDECIDED,
    FittedAlternative,
    Linearised,
    RecordAlternatives,
    Score,
    Table,
    by_moves,
    chance_of,
    explains,
    least_taken,
    linearised,
    misfit_left,
    score_tests,
    tables,
)

# Which alternatives are fitted in full, and when one is taken.
FULL_EACH = 3  # choice: of a family, its best by one step, which does not always name the right one
FULL_PROMISING = 1.5  # choice: of the least sum of squares, up to which an alternative is fitted to the end
# choice: of how far adhesion deforms the body, ranges that are tried below endless ones
FULL_RANGES = (32.0, 8.0, 4.0, 2.83, 2.0, 1.41, 1.0, 0.71)
# choice: 2 tension/E* over the contact radius, those tried: the largest of which the first order holds, and smaller
FULL_SKINS = (0.1, 0.05, 0.025, 0.0125, 0.006, 0.003, 0.0015)
FULL_LEANING = 1.0  # theory: fall of chi^2 by a number that means nothing, from which on one that nobody
# described counts
FULL_CLOSE = 0.95  # choice: of the rise of chi^2 at the end of an interval, from which on an amount is its end
FULL_NEARLY = 0.8  # choice: the same, where amounts beyond it count by the chord to the end
# choice: of SCORE_MATTERS, moves to first order below which nothing is fitted; of 24 curves of a map none was 0.2 % off
FULL_LINEAR = 0.5
FULL_HARDLY = 0.25  # choice: of such a fall, what one step finds at least where there may be as much
# choice: the same to first order in the loads at an amount itself, and of a rise: of 148 falls the least was 0.80
FULL_AHEAD = 0.6
FULL_HALVES = 2  # choice: bisections between the largest amount that the data leave and the next one
# choice: standard errors by one step, up to the shortest of these, from which on none is; of 85 made records that
# were left one, of Tabor numbers 0.15 to 1, the most was 3.5; the same to first order in the loads, where of 260
# that were left one the most was 5.1
FULL_EXCLUDED = 6.0
FULL_ABOUT = 0.5  # choice: standard errors, by which what a range does to a fit may be off
FULL_FALLING = 2.0  # choice: of the step to come, by which chi^2 may still fall
FULL_SLOW = 0.3  # choice: of w of the retraction, the least w of a slow edge to start from where none advanced
FULL_SETTLED = 0.1  # choice: standard errors of the modulus, by which the last round may move it


Moves = tuple[float, float, float]  # rises of chi^2 and of the logs of E* and w


def record_alternatives(
    record: FittedRecord, weighed: Callable[[RecordAlternatives], RecordAlternatives] = lambda found: found
) -> Flow[RecordAlternatives]:
    """The scores of all alternatives of a fit, of which those that are likely before the data move E* and w by what a
    fit with as much of them as is possible does: one step trusts no row next to a fold. ``weighed``: without those that
    change nothing among the named."""
    alternatives, table = yield from score_tests(record)
    alternatives = weighed(alternatives)
    return alternatives if alternatives.named else weighed((yield from quiet(bounds(alternatives, table))))


def bounds(alternatives: RecordAlternatives, table: Table) -> Flow[RecordAlternatives]:
    """The alternatives with these moves; unknowns that no row determines may go anywhere meanwhile."""
    record, every = table.record, np.ones(table.record.residuals.size, dtype=bool)
    off = yield from ask(linearised, (table, record.off_folds))
    near, rates = (yield from ask(linearised, (table, every))), by_moves(record.fit)
    each = [_bounded(off if one.name in (RANGE, TENSION) else near, one, i, rates)
            for i, one in enumerate(alternatives.scores)]  # fmt: skip
    ends = iter((yield from beside([quiet(one) for one in each if not isinstance(one, Score)])))
    scores = [one if isinstance(one, Score) else next(ends) for one in each]
    named = [one for one in scores if one.word == DETECTED][:1]
    for best in named[:1]:  # and those that take nearly as much of the misfit, though they see fewer rows
        least, limits = least_taken(best.taken), {one.name: one.prior.limits for one in ALTERNATIVES}
        others = [one for one in scores if one is not best and one.taken > least]
        named += [one for one in others if limits[one.name][0] <= one.amount <= limits[one.name][1]]
    return replace(alternatives, scores=tuple(scores), named=tuple(named))


def _bounded(near: Linearised, score: Score, which: int, rates: Array) -> Score | Flow[Score]:
    """The score with the moves at the largest amount that is possible, or what leads to it: to first order where they
    are small by it, and long ranges of adhesion, of which it says nothing, are excluded. ``which`` of the columns is
    the alternative's; ``rates``: of the logs of E* and w by the unknowns."""
    ranged, tense = score.name == RANGE, score.name == TENSION
    if not (ranged or tense or score.most > 0):
        return score
    ahead, record = near.moves[which], near.record
    error = 1 / max(float(near.sizes[which]), math.sqrt(TINY))
    best = -float(near.shared[which]) * error
    falls = (max(best, 0.0) / error) ** 2
    if tense and not record.known.tension and falls < FULL_HARDLY * FULL_LEANING:
        return score  # no data lean to any
    certain = max(score.amount, 0.0) + FULL_EXCLUDED * score.error
    long = ranged and amount_of_range(record, FULL_RANGES[-1] * record.neck) <= certain
    seen = replace(score, amount=best, error=error) if ranged else score
    E, w = (float(rate) for rate in rates @ ahead)
    little = seen.most > 0 and max(abs(E), abs(w)) * seen.most < FULL_LINEAR * SCORE_MATTERS
    if little and not (tense or long or (ranged and _by_chance(near, falls))):
        return replace(seen, E_star=E, w=w, word=EXCLUDED if ranged else score.word)
    change = near.table.alternatives[which].change(record)
    if change is None or not change.in_full:
        return score
    if not isinstance(change, BodyChange) or not (ranged or tense):
        return _at_most(near, change, ahead, score)
    tried = _Amounts(near, change, ahead)
    return _of_ranges(tried, score, certain, long) if ranged else _of_tension(tried, score)


def _at_most(near: Linearised, change: Change, ahead: Array, score: Score) -> Flow[Score]:
    """The score with the moves at the largest amount that is possible, about ``ahead`` per amount."""
    end = yield from _followed(near, change, score.most, begin=near.x + score.most * ahead)
    E, w = (math.nan, math.nan) if end is None else _moves(near, end[1])
    return replace(score, E_star=E / score.most, w=w / score.most) if math.isfinite(E + w) else score


@dataclass(frozen=True, eq=False)
class _Amounts:
    """What the data say of those amounts of a ``change`` that were tried, ``near`` the fit without: by how much chi^2
    and the logs of E* and w rise, None where the data exclude it for certain, by three standard errors, or where steps
    do not settle; ``ends``: the unknowns of those that are left, which move by ``ahead`` per amount at first."""

    near: Linearised
    change: BodyChange
    ahead: Array
    moves: dict[float, Moves | None] = field(default_factory=dict)
    ends: dict[float, Array] = field(default_factory=dict)
    first: dict[float, Array] = field(default_factory=dict)

    @property
    def left(self) -> dict[float, Moves]:
        """The moves at those that are left."""
        return {amount: moves for amount, moves in self.moves.items() if moves is not None}

    def at(self, amount: float) -> Flow[Moves | None]:
        """The moves at an amount, from where those below lead: from the unknowns to first order, and what is missing to
        those that are left next to it, or at the two below, on the straight line through these; nothing where none is
        left next to it: another valley may begin there."""
        missing = {0.0: np.zeros_like(self.near.x)}
        missing |= {one: x - self.near.x - self._first(one) for one, x in self.ends.items()}
        points, more = [0.0], min((more for more in self.moves if more > amount), default=0.0)
        for less in sorted(less for less in self.moves if less < amount):
            points = [*points, less] if less in missing else points[:1]
        points += [more] if more in self.ends else []
        first, last = points[-2:][0], points[-1]
        share = (amount - last) / (last - first) if last > first else 0.0
        begin = self.near.x + self._first(amount) + missing[last] + (missing[last] - missing[first]) * share
        end = yield from _followed(self.near, self.change, amount, SCORE_TIED, begin)
        moves = None if end is None else (end[0], *_moves(self.near, end[1]))
        self.moves[amount] = None
        if end is not None and moves is not None and moves[0] < SCORE_TIED and np.isfinite(moves).all():
            self.moves[amount], self.ends[amount] = moves, end[1]
        return self.moves[amount]

    def look_ahead(self, amounts: Sequence[float]) -> tuple[list[float], Array]:
        """To first order in the loads about by how much chi^2 rises at some amounts, and the moves of the unknowns."""
        near = self.near
        bodies = bodies_at([(near.record, self.change, amount) for amount in amounts])
        c, r = (near.whitened(columns) for columns in (by_bodies(near.record, bodies), near.record.residuals))
        own = c @ near.Q
        rises = np.vecdot(c, c) + 2 * (c @ r) - np.vecdot(own, own + 2 * (r @ near.Q))
        return rises.tolist(), -(own @ near.inverse.T) / near.scale

    def _first(self, amount: float) -> Array:
        """Moves of the unknowns to first order, between amounts that were looked at on straight lines."""
        if not self.first:
            return amount * self.ahead
        known = [0.0, *sorted(self.first)]
        rows = np.array([np.zeros_like(self.ahead), *(self.first[one] for one in known[1:])])
        return np.array([np.interp(amount, known, column) for column in rows.T])


def _of_ranges(tried: _Amounts, score: Score, certain: float, long: bool) -> Flow[Score]:
    """The score with the moves at ranges up to the longest that there may be, or where one step excludes all amounts
    beyond ``certain`` and with them the ``long`` ones, up to the end of the interval, from where that step has it
    on."""
    record, within, unsure = tried.near.record, score.quantile**2, score.quantile * score.error
    if long:
        # endless ones, that no short one is detected for, and the longest that is likely
        lengths = [amount_of_range(record, times * record.neck) for times in (ADHESION_ENDLESS, *FULL_RANGES)]
        amounts, shortest = sorted({*lengths, score.known}), lengths[-1]
        (rise,), _ = tried.look_ahead([shortest])
        if rise > FULL_EXCLUDED**2:
            tried.moves.update((amount, None) for amount in amounts if amount >= shortest)
        for amount in amounts:
            if amount not in tried.moves:
                yield from tried.at(amount)
        return (yield from _of_amounts(tried, score))
    most = min(score.known, certain)
    amount = min(most, score.amount if score.amount > unsure else max(score.most, score.error))
    for _ in range(MOST_STEPS):
        moves = yield from tried.at(amount)
        if moves is None or moves[0] > FULL_CLOSE * within or amount == most:
            break
        amount = min(most, amount * min(2.0, score.quantile / math.sqrt(FULL_CLOSE * max(moves[0], TINY))))
    return (yield from _of_amounts(tried, score))


def _of_tension(tried: _Amounts, score: Score) -> Flow[Score]:
    """The same of surface tensions up to the largest that is known, or the usual one where the data lean to any: by
    more than can be chance, as one step has it about, too."""
    record, known = tried.near.record, tried.near.record.known.tension
    most, least, leans = amount_of_tension(record, known or GEL_TENSION), 0.0, False
    amounts = sorted({min(most, FULL_SKINS[0]), *(amount for amount in FULL_SKINS if amount < most)})
    about, first = tried.look_ahead(amounts)
    lowest = int(np.argmin(about))
    if about[lowest] > -FULL_AHEAD * FULL_LEANING and not known:
        return score
    tried.first.update(zip(amounts, first, strict=True))
    for amount, rise in [*zip(amounts, about, strict=True)][max(lowest - 1, 0) :]:
        if FULL_AHEAD * rise > SCORE_TIED:
            moves = tried.moves[amount] = None
        else:
            moves = yield from tried.at(amount)
        rises = moves is not None and moves[0] > least
        least = least if moves is None else min(least, moves[0])
        leans = bool(known) or -least > FULL_LEANING or _by_chance(tried.near, -least)
        if (moves is None and len(tried.moves) > 1) or (rises and not leans):
            break  # no larger one is left either, or takes more
    return (yield from _of_amounts(tried, score)) if leans else score


def _by_chance(near: Linearised, taken: float) -> bool:
    """Whether so much of chi^2 is more than chance or misfit takes with any of the alternatives."""
    likely = chance_of(near.record.fit, taken) < SCORE_CHANCE / len(ALTERNATIVES)
    return likely and bool(explains(near, np.array(taken)))


def _of_amounts(tried: _Amounts, score: Score) -> Flow[Score]:
    """The score with the largest moves at those amounts ``tried`` that the data leave, where they leave none, at
    smaller ones; it is detected where one takes enough of the misfit. Those beyond the interval count by the chord to
    it, as moves may grow steeply there; longer ranges than are likely count where the data outweigh
    their odds."""
    within, least = score.quantile**2, min(tried.moves)
    likely = score.known if score.name == RANGE else math.inf
    longer = math.inf if tried.near.record.known.told else PRIORS[RANGE].cost

    def possible() -> dict[float, Moves]:
        return {amount: moves for amount, moves in tried.left.items()
                if amount <= likely or moves[0] + longer < within}  # fmt: skip

    for _ in range(MOST_STEPS):
        if any(moves[0] < within for moves in possible().values()):
            break
        moves = tried.moves[least]  # chi^2 rises with the square of the amount
        yield from tried.at(least := least * (0.5 if moves is None else math.sqrt(FULL_CLOSE * within / moves[0])))
    else:
        return score
    end = max(amount for amount, moves in possible().items() if moves[0] < within)
    most = likely if end <= likely else math.inf
    beyond = min((amount for amount in tried.moves if end < amount <= most), default=0.0)
    for _ in range(FULL_HALVES * (beyond > 0)):
        if tried.left[end][0] > FULL_NEARLY * within:
            break
        middle = math.sqrt(end * beyond)
        moves = yield from tried.at(middle)
        end, beyond = (end, middle) if moves is None or moves[0] > within else (middle, beyond)
    left, record = tried.left, tried.near.record
    best = min(left, key=lambda amount: left[amount][0])
    taken = -left[best][0]
    chance = chance_of(record.fit, taken)
    if _by_chance(tried.near, taken):
        return replace(_moving(score, best, left[best][1:]), amount=best, word=DETECTED, chance=chance, taken=taken)
    chords = [min(1.0, score.quantile / math.sqrt(max(moves[0], TINY))) * np.abs(moves[1:])
              for moves in possible().values()]  # fmt: skip
    moving = _moving(score, end, np.max(chords, axis=0).tolist())
    return replace(moving, amount=best * (taken > 0), chance=chance, taken=max(taken, 0.0))


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
    """The score of an alternative that ``moves`` the logs of E* and w at an ``amount``."""
    E, w = (float(move) / amount for move in moves)
    word = UNDECIDED if max(map(abs, moves)) > SCORE_MATTERS else EXCLUDED
    return replace(score, amount=0.0, error=math.inf, known=amount, E_star=E, w=w, word=word)


def _followed(
    near: Linearised, change: Change, amount: float, most: float = math.inf, begin: Array | None = None
) -> Flow[tuple[float, Array] | None]:
    """By how much chi^2 rises with an ``amount`` of a ``change``, and the unknowns, by steps with the derivatives of
    the fit without, from ``begin`` on, else from that fit; None where they do not settle, or come to a contact that is
    nowhere stable, or chi^2 will not fall to about ``most``."""
    model = ChangedModel.of(near.record.model, change, {AMOUNT: amount})
    x, size, excess = near.x if begin is None else begin, math.inf, math.inf
    with contextlib.suppress(SolveError, ArithmeticError):  # unknowns that no row determines may go anywhere
        for _ in range(MOST_STEPS):
            step, left = near.step((yield from ask(changed_offs, (model, x, 0.0))))
            before, size, x, excess = size, near.size(step), x - step, left - near.left
            if not (size < before and excess < most + FULL_FALLING * size):
                return None
            if size < FULL_ABOUT:
                break
        return excess, x
    return None


@np.errstate(all="ignore")
def fit_alternatives(
    record: FittedRecord, models: Sequence[ForceCurveModel], alternatives: RecordAlternatives
) -> list[tuple[FittedAlternative, ForceCurveFit]]:
    """The best of each family with its fit, by how much chi^2 falls, on the rows of both that are off the folds, those
    that leave no more than noise first; ``models``: of the record before its fit left any row out, with a straight base
    line too, where something bends it."""
    begun, fits = [], list[tuple[FittedAlternative, ForceCurveFit]]()
    models = [replace(one, family=record.model.family) for one in models]
    # Of each family those that one step takes most from the misfit with: it detects, so that neither sign nor size of
    # an amount that is not small says much. The range of adhesion stands for a long one, which has a column alone.
    entries, likeliest = {one.name for one in ALTERNATIVES}, list[Score]()
    scores = [one for one in alternatives.scores if one.name in entries]
    detected = [one for one in scores if one.taken > SCORE_TIED or one in alternatives.named]
    ranked = sorted(detected, key=lambda one: -one.taken)
    of_range = next((one for one in alternatives.scores if one.name == RANGE), None)
    for family in dict.fromkeys(one.family for one in ranked):
        best_of = [one for one in ranked if one.family == family][:FULL_EACH]
        likeliest += dict.fromkeys((of_range or one) if one.name == LONG else one for one in best_of)
    for score, fresh in itertools.product(likeliest, models):
        with contextlib.suppress(JkrError):  # what cannot be solved is not taken
            change = next(one for one in ALTERNATIVES if one.name == score.name).change(record)
            if change is not None and change.in_full:
                begun.append((*_roughly(record, fresh, change, score.amount), fresh, change, score))
    most = FULL_PROMISING * min((cost for cost, *_ in begun), default=0.0)
    for _, x, fresh, change, score in (one for one in begun if one[0] <= most):
        with contextlib.suppress(JkrError):
            here = FittedRecord(record.body, reconverge(to_the_end(ChangedModel.of(fresh, change), x)))
            misfit, dof, loose = misfit_left(here, here.regular)
            chance, quantities = numerics.f_chance(dof, max(loose, 1), misfit / dof), here.model.further(here.values)
            q = max(here.values[f"q:{here.model.stretches[-1].kind}"], 0.0)
            fits.append((FittedAlternative(
                score.name, score.family, fall_of(record, here), chance,
                here.fit.ended and chance > STATISTICS_IMPROBABLE, here.E_star, quantities.pop("w", q * here.modulus),
                quantities, fresh is not models[0],
            ), here.fit))  # fmt: skip
    # theory: bends of the base line cost their odds and unknowns
    fits.sort(key=lambda one: (not one[0].taken, -one[0].falls - FREE_BENDS * one[0].straight), reverse=True)
    fits = [*{one.name: (one, full) for one, full in fits}.values()]
    fits.sort(key=lambda one: (not one[0].taken, -one[0].falls))
    best = fits[0][0].falls if fits else 0.0  # which rejects the model without, or none is taken
    least = best - SCORE_TIED if best > SCORE_TIED else math.inf
    return [(replace(one, taken=one.taken and one.falls > least), full) for one, full in fits]


def _roughly(record: FittedRecord, fresh: ForceCurveModel, change: Change, amount: float) -> tuple[float, Array]:
    """About the least misfit with a ``change``, and its unknowns: from the best of its starts and what one step asks
    for, and from the best that the body suggests at each of these."""
    low, high = change.limits.get(AMOUNT, ANY)
    starts = dict.fromkeys([(min(max(amount, low), high), *change.starts[0][1:]), *change.starts])
    model, searches = ChangedModel.of(fresh, change), []
    for group in _begins(record, model, [*starts]):
        with contextlib.suppress(JkrError):  # others may come to an end
            begin = min(group, key=partial(misfit_at, model))
            searches += [(end.cost, end.x) for end in alone(roughly(model, begin, FIT_BLUNT[1:2]))]
    if not searches:
        raise SolveError("no curve with this change resembles the force curve")
    return min(searches, key=lambda one: one[0])


def _begins(record: FittedRecord, model: ChangedModel, starts: Sequence[tuple[float, ...]]) -> Iterator[list[Array]]:
    """Groups of unknowns about ``starts`` of the change, of each of which the best is a start: histories and ranges
    have several minima."""
    change, x, last = model.change, _unknowns(record, model, record.fit.x), model.stretches[-1]
    if isinstance(change, BodyChange) and change.coupled:
        # what the fit without becomes, at those amounts that leave no more than the ones next to them
        near, starts = _about(record), sorted(starts)
        ends = alone(beside([_followed(near, change, start[0]) for start in starts]))
        left = np.array([math.inf, *(math.inf if end is None else end[0] for end in ends), math.inf])
        lowest = left[1:-1] <= np.minimum(left[:-2], left[2:])
        for start, end, low in zip(starts, ends, lowest, strict=True):
            if end is not None and low:
                yield [np.append(_unknowns(record, model, end[1]), start)]
        return
    if isinstance(change, LoadsChange) and change.where == "last":
        i = model.names.index(f"q:{last.kind}")
        x[i] = max(record.values[f"q:{model.stretches[0].kind}"], FULL_SLOW * x[i])
    plain = [np.append(x, start) for start in starts]
    yield from [[begin] for begin in plain] if isinstance(change, LoadsChange) else [plain]
    for start in starts if isinstance(change, BodyChange | StiffnessChange) else ():
        values = {**record.values, **dict(zip(change.names, start, strict=True))}
        with contextlib.suppress(JkrError):  # as its body suggests
            yield [np.append(x, start) for x in starts_of(model.followed(last, values))]


def _about(record: FittedRecord) -> Linearised:
    """A fit without alternatives, on the rows that are off the folds."""
    (near,) = linearised([(tables([record], ())[0], record.off_folds)])
    return near


def _unknowns(record: FittedRecord, model: ChangedModel, x: Array) -> Array:
    """The unknowns of a ``model`` but its change's as they are at ``x``, those that were known at what they were."""
    values = record.model.values(x)
    roots = {f"r:{part.kind}": math.sqrt(max(values[f"q:{part.kind}"], 0.0)) for part in model.stretches}
    own = [name for name in model.names if name not in model.change.names]
    return np.array([({"turn": 0.0} | roots | values)[name] for name in own])


def to_the_end(model: ForceCurveModel, x: Array) -> ForceCurveFit:
    """The fit from about there, without the rows about first touch."""
    full = fit(model, x, near=True)
    without = windowed(full)
    return full if without is full.model else fit(without, full.x, near=True)


def fall_of(record: FittedRecord, here: FittedRecord) -> float:
    """How much lower chi^2 is ``here`` than without, on the rows of both that are off the folds, as a fit to all rows
    leaves it: those at folds hold its folds where they are."""
    noise = record.fit.spread.noise  # for all alternatives: misfit that is slow may pass for noise of the fit's own

    def left(one: FittedRecord, other: FittedRecord) -> float:
        rows = one.off_folds & np.isin(one.model.rows, other.model.rows[other.off_folds])
        return chi2_of(one.residuals[rows], one.model.rows[rows], noise)

    return left(record, here) - left(here, record)


def chi2_of(residuals: Array, rows: Array, noise: Spectrum) -> float:
    """chi^2 of what is left of some ``rows`` of a record, by the ``noise`` of its free rows."""
    r = noise.whitened(in_time(residuals, rows, noise) if noise.slow else residuals)
    return float(r @ r)


RANGE_LOWER = 4.0  # theory: chi^2 of one unknown at 95 %, by which a minimum with a longer range is to be lower
RANGE_EVERY = 3  # choice: of the Tabor numbers of ``ADHESION_TABOR``, which stand closer than minima


def with_range_of(record: FittedRecord, fresh: ForceCurveModel, change: Change, amount: float) -> ForceCurveFit:
    """The fit with an ``amount`` of a range of adhesion that is known."""
    model = ChangedModel.of(fresh, change, {AMOUNT: amount})
    end = alone(_followed(_about(record), change, amount))
    return to_the_end(model, _unknowns(record, model, record.fit.x if end is None else end[1]))


def with_free_range(
    record: FittedRecord, fresh: ForceCurveModel, change: Change
) -> tuple[ForceCurveFit, list[ForceCurveFit]]:
    """The fit with a range of adhesion that is fitted with the rest, from that without on, which it contains; and those
    that the data do not tell from it, with known ranges or at other minima. SolveError where it leaves more than that
    without."""
    # JKR is a minimum of its own where the range is as long as the neck: from fits at a few that are known, too.
    model = ChangedModel.of(fresh, change)
    starts = [_roughly(record, fresh, change, 0.0)[1], np.append(_unknowns(record, model, record.fit.x), LITTLE)]
    near = list[ForceCurveFit]()
    for (known,) in change.starts[::RANGE_EVERY]:
        with contextlib.suppress(SolveError):
            near.append(with_range_of(record, fresh, change, known))
            starts.append(np.append(near[-1].x, known))
    free = list[ForceCurveFit]()
    for x in starts:
        with contextlib.suppress(SolveError):
            free.append(to_the_end(model, x))
    free = [one for one in free if one.ended]
    falls = {one: fall_of(record, FittedRecord(record.body, one)) for one in (*free, *near)}
    best, fall = None, -FULL_LEANING
    for one in free:
        if falls[one] > fall + RANGE_LOWER * (best is not None):
            best, fall = one, falls[one]
    if best is not None:
        return best, [one for one in falls if one is not best and falls[one] > fall - RANGE_LOWER]
    raise SolveError("the fit with a range of adhesion does not converge: none leaves as little as JKR, which it "
                     "contains; leave the range out, or fix it")  # fmt: skip


def reconverge(full: ForceCurveFit) -> ForceCurveFit:
    """The fit whose change, where it is made about one, is made about itself."""
    for _ in range(MOST_SOLVES):
        model, before = full.model, full
        if not isinstance(model, ChangedModel) or model.change.recentred is None or AMOUNT not in full.names:
            break
        full = fit(ChangedModel.of(model, model.change.recentred(full)), full.x, near=True)
        if abs(full.value("ln_s") - before.value("ln_s")) < FULL_SETTLED * full.error("ln_s"):
            break
    return full

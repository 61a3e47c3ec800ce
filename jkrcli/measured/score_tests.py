"""What the data say of every alternative of a raw record's model, by one step of Gauss and Newton each.

Residuals r, the Jacobian J and the column c of an alternative are weighted by the spectrum of the noise in the free
rows. With r' and c' what is left of them beyond the columns of J, the alternative takes (c' r')^2/c'^2 from chi^2, one
degree of freedom where the model holds; its amount is -c' r'/c'^2 with the standard error 1/|c'|, and the unknowns move
by -J+ c per amount. That detects, and does not name: alternatives that take nearly as much of the misfit as the best
are named together. Many records are tested together; no alternative is known here but by its entry and its column.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Protocol

import numpy as np

from ..base import numerics
from ..base.errors import LEVEL, JkrError
from ..base.numerics import HALF_WIDTH, TINY, UNSEEN, Array, PiecewiseCubic
from ..base.process import REMEMBERED
from .cosine import cosine_transform, fast_length
from .curve import APPROACH
from .fitted_record import FittedRecord
from .force_curve import DirectionReadings, ForceCurveFit
from .hypotheses import ALTERNATIVES
from .least_squares import COLOURED_FREE, frequencies, in_time, t_quantile
from .lockstep import Flow, ask, by_groups
from .model_changes import AlternativeModel

DETECTED, EXCLUDED, UNDECIDED = "favoured by the data", "excluded", "not distinguishable"

# When an alternative is detected, and when it is excluded.
SCORE_CHANCE = 0.01  # choice: of any alternative being detected in data of the model itself
SCORE_MISFIT = 5.0  # choice: times that misfit widens standard errors, beyond which it hides causes as noise does
SCORE_MOVES = 0.5  # choice: of its error, by which E* or w must move
SCORE_MATTERS = 0.02  # choice: relative change of E* and w, below which an alternative is excluded
SCORE_TIED = 9.0  # choice: of chi^2, three standard errors: alternatives nearer are named together or not at all
SCORE_NEAR = 0.5  # choice: of the misfit that the best takes, the same: one step is of first order
SCORE_OVER = 1.25  # choice: of what is possible, up to which an amount may come out: the same
SCORE_ALIKE = 0.9  # choice: correlation of what is left of two columns, from which they are named together
SCORE_DIGITS = 1e-12  # theory: of squares of unit columns, what is left of one beside the others that products hold
SCORE_SEEN = 1e-7  # theory: of a column, what is left of it that differences of squares tell
SCORE_TAIL = 0.125  # theory: of Student's t: cubics of logs of its tail between are good to 1e-6
SCORE_FARTHEST = 1e3  # choice: of the same, beyond which a tail is as there


@dataclass(frozen=True)
class Score:
    """What the data say of one alternative, by its ``name`` and ``family``; ``amount_is``: what its ``amount`` is, in
    words.

    ``error``: standard error of the amount, infinite where no row determines it; ``chance`` of as much from noise;
    ``taken`` from chi^2, and the ``share`` of all that is; ``E_star``, ``w``: by how much their logarithms move per
    amount. ``least, known``: the amounts that are likely before the data; ``word``: DETECTED, EXCLUDED or UNDECIDED;
    ``quantile``: half-width of intervals, in standard errors; ``over``: E* and w of the fit over the values that
    changes are told of, those of one direction where both differ.
    """

    name: str
    family: str
    amount_is: str
    of_directions: bool
    amount: float
    error: float
    chance: float
    taken: float
    share: float
    E_star: float
    w: float
    least: float
    known: float
    word: str
    quantile: float = HALF_WIDTH
    over: Mapping[str, float] = field(default_factory=dict, hash=False)

    def _log(self, quantity: str) -> tuple[float, float]:
        """By how much the logarithm of a quantity moves per amount, and what it is without any."""
        return self.E_star if quantity == "E_star" else self.w, math.log(self.over.get(quantity, 1.0))

    def change(self, quantity: str) -> float:
        """Relative change of "E_star" or "w" with the amount."""
        rate, before = self._log(quantity)
        return math.expm1(min(before + self.amount * rate, 700.0))

    def moved(self, quantity: str) -> float:
        """How far "E_star" or "w" may be off, relative: by the amount and its error, at the level of the intervals,
        where the alternative is detected; else by the largest that the data and what is known leave. With its sign,
        there for an amount above 0."""
        rate, before = self._log(quantity)
        if self.word == DETECTED and math.isfinite(self.error):
            logs = [before + rate * (self.amount + end * self.error) for end in (-self.quantile, self.quantile)]
            low, high = -math.expm1(min(logs)), max(logs)  # it falls by no more than all, and rises to first order
            return high if high >= low else -low
        return rate * self.most if rate else 0.0

    @property
    def most(self) -> float:
        """The largest amount that is known to be possible and not excluded by the data."""
        if math.isinf(self.error) or self.least == self.known:
            return self.known
        room = self.quantile * self.error
        low, high = (min(max(end, self.least), self.known) for end in (self.amount - room, self.amount + room))
        return max(abs(low), abs(high))


@dataclass(frozen=True)
class RecordAlternatives:
    """The ``scores`` of a record, and among them those that are ``named``: detected, and explaining the misfit about as
    well as the best one, which is the first. ``misfit``: chi^2 of the weighted residuals over their degrees of freedom
    ``dof``; ``loose``: free rows that the noise is estimated from, 0 where they are too few; ``excess``: how many times
    misfit widens standard errors where it counts as noise."""

    scores: tuple[Score, ...]
    named: tuple[Score, ...]
    misfit: float
    dof: int
    loose: int
    excess: float = 1.0

    @property
    def families(self) -> tuple[str, ...]:
        """The families of those that are named, the likeliest first."""
        return tuple(dict.fromkeys(one.family for one in self.named))

    def worst(self, quantity: str) -> tuple[str, float] | None:
        """The alternative that may move "E_star" or "w" most, and by how much, relative: of the named, where some
        are."""
        moves = {one.name: one.moved(quantity) for one in self.named or self.scores}
        name = max(moves, key=lambda name: abs(moves[name]), default="")
        return (name, moves[name]) if moves.get(name) else None

    def told_of(self, over: Mapping[str, float]) -> RecordAlternatives:
        """The same, with changes of values which E* and w of the fit are so many times ``over``."""
        scores, named = (tuple(replace(one, over=over) for one in some) for some in (self.scores, self.named))
        return replace(self, scores=scores, named=named)

    def undecided(self) -> RecordAlternatives:
        """The same, none of them named."""
        scores = (replace(one, word=UNDECIDED) if one.word == DETECTED else one for one in self.scores)
        return replace(self, scores=tuple(scores), named=())


@dataclass(frozen=True)
class FittedAlternative:
    """An alternative fitted in full: by how much chi^2 ``falls``, the ``chance`` that the noise of the free rows leaves
    as much, whether it is ``taken``; E* [Pa], w [J/m^2], and its own ``quantities``, SI, by name; whether it leaves the
    base line ``straight``, which the record without it does not."""

    name: str
    family: str
    falls: float
    chance: float
    taken: bool
    E_star: float
    w: float
    quantities: Mapping[str, float]
    straight: bool = False


class Answering(Protocol):
    """What an ``alternative`` that is no change of a record's model makes of a plain fit, and of what it was fitted
    by."""

    @property
    def alternative(self) -> FittedAlternative: ...

    def __call__(self, plain: Any, fit: ForceCurveFit) -> Any: ...


@dataclass(frozen=True)
class Verdict:
    """The ``alternatives`` of a record and what a formula of the half-space makes of its deepest row: ``formula`` by
    name and its ``E_star`` [Pa], None where the tip has no radius. ``fitted``: alternatives that were fitted in full,
    best first; if the first is taken it is the model of the answer, and those ``tied`` with it, taken too, cannot be
    distinguished. ``answer``: that by an alternative that is no change of the model, where it was asked for.
    """

    alternatives: RecordAlternatives
    formula: str
    E_star: float | None
    fitted: tuple[FittedAlternative, ...] = ()
    answer: Answering | None = None

    @property
    def tied(self) -> tuple[FittedAlternative, ...]:
        """Those that are taken, the best one first."""
        return tuple(one for one in self.fitted if one.taken)

    @property
    def answers(self) -> bool:
        """Whether the answer is by an alternative that is no change of the model."""
        return self.answer is not None and bool(self.tied) and self.tied[0].name == self.answer.alternative.name

    @property
    def with_answer(self) -> Verdict:
        """With the answer among those that were fitted; those that leave more by ``SCORE_TIED`` are not taken."""
        if self.answer is None:
            return self
        fitted = sorted((*self.fitted, self.answer.alternative), key=lambda one: (not one.taken, -one.falls))
        least = fitted[0].falls - SCORE_TIED
        return replace(self, fitted=tuple(replace(one, taken=one.taken and one.falls > least) for one in fitted))

    @property
    def families(self) -> tuple[str, ...]:
        """The families that are named: of those that are tied, else of those that one step names."""
        return tuple(dict.fromkeys(one.family for one in self.tied)) or self.alternatives.families


@dataclass(frozen=True, eq=False)
class Table:
    """The residuals of a ``record``, their derivatives by the unknowns and the columns of those ``alternatives`` that
    mean anything for it, one after the other: ``columns`` [N] (columns, rows)."""

    record: FittedRecord
    alternatives: tuple[AlternativeModel, ...]
    columns: Array

    @cached_property
    def products(self) -> Array:
        """Products of all columns over all rows [N^2]."""
        return self.columns @ self.columns.T

    def taken(self, rows: Array) -> tuple[Array, Linearised]:
        """The columns of some ``rows`` in units of the noise, as if no other row were there, and the fit by them."""
        noise, some = self.record.fit.spread.noise, self.columns.take(np.flatnonzero(rows), axis=1).T
        columns = noise.whitened(in_time(some, self.record.model.rows[rows], noise) if noise.slow else some).T
        (linear,) = _factored([(self, rows, columns @ columns.T)])
        return columns, linear

    def gram(self, rows: Array) -> Array:
        """Products of the weighted columns: of white noise those over all rows, less those over the others, which are
        few."""
        noise = self.record.fit.spread.noise
        if noise.slow:  # where other rows count as exact
            weighted = self.record.model.whitened((self.columns * rows).T, noise)
            return weighted.T @ weighted
        others = self.columns[:, np.flatnonzero(~rows)]
        return (self.products - others @ others.T) / noise.A


def tables(records: Sequence[FittedRecord], alternatives: Sequence[AlternativeModel] = ALTERNATIVES) -> list[Table]:
    """The tables of some records, columns of one type of change together."""
    asked = []
    for record in records:
        for alternative in alternatives:
            try:
                change = alternative.change(record)
            except (JkrError, FloatingPointError):
                continue  # a neighbouring body that cannot be solved is no alternative, and takes no fit with it
            if change is not None:
                asked.append((record, alternative, change))
    columns = by_groups(asked, lambda one: type(one[2]).columns, lambda of, some: of([one[::2] for one in some]))
    each: dict[FittedRecord, list[tuple[AlternativeModel, Array]]] = {record: [] for record in records}
    for (record, alternative, _), column in zip(asked, columns, strict=True):
        if 0 < column @ column < math.inf:  # of what is 0 throughout or has no meaning, nothing
            each[record].append((alternative, column))
    return [
        Table(record, tuple(one for one, _ in own),
              np.vstack([record.residuals, record.jacobian.T, *(column for _, column in own)]))
        for record, own in each.items()
    ]  # fmt: skip


def score_tests(record: FittedRecord) -> Flow[tuple[RecordAlternatives, Table]]:
    """The scores of all alternatives of a fit, and the table that they are by."""
    table = yield from ask(tables, record)
    rows, noise, own = record.regular, record.fit.spread.noise, 1 + record.fit.x.size
    if noise.slow:
        columns, linear = table.taken(rows)
    else:
        columns, linear = table.columns, (yield from ask(linearised, (table, rows)))
    left = None
    if noise.slow or record.fit.spread.possible is not None:
        left = linear.moves @ columns[1:own] + columns[own:]  # c' = c + J moves
    scores, dof = _scores(linear, left), max(int(np.count_nonzero(rows)) - record.fit.x.size, 1)
    # Those that are detected and take nearly as much as the best, or whose columns are much alike its own
    named = sorted((i for i, one in enumerate(scores) if one.word == DETECTED), key=lambda i: -scores[i].taken)
    if named:
        least, same = least_taken(scores[named[0]].taken), np.abs(linear.alike(named[0])) > SCORE_ALIKE
        named = [i for i in named if scores[i].taken >= least or same[i]]
    rest = linear.left, dof, _loose(record), _excess(record.fit, linear.left)
    return RecordAlternatives(tuple(scores), tuple(scores[i] for i in named), *rest), table


@np.errstate(all="ignore")
def _scores(linear: Linearised, left: Array | None) -> list[Score]:
    """The scores of the alternatives; ``left``: what is of each column beyond the model's."""
    record, alternatives, sizes = linear.record, linear.table.alternatives, linear.sizes
    # The degrees of freedom of the noise at the frequencies of what is left of each column: waves of the free rows in
    # each octave, of which a share has as much of the variance, at least one
    spread, unseen = record.fit.spread, sizes <= UNSEEN * linear.whole
    dofs = np.full(sizes.size, float(spread.dof))
    if left is not None and spread.noise.slow:
        edges = _octaves(left.shape[1])
        share = np.add.reduceat((left / np.where(sizes > 0, sizes, np.inf)[:, None]) ** 2, edges, axis=1)
        counts = np.maximum(np.diff(np.append(edges, left.shape[1])) * spread.dof / left.shape[1], 1)
        dofs = 1 / np.maximum((share**2 / counts).sum(axis=1), 1 / max(spread.dof, 1.0))
    chances = np.where(unseen, 1.0, _chances(record, left, linear.rows, sizes, linear.shared**2, dofs))
    amounts, errors = np.where(unseen, 0.0, -linear.shared / sizes), np.where(unseen, np.inf, 1 / sizes)
    taken, rates = np.where(unseen, 0.0, linear.shared**2), linear.moves @ by_moves(record.fit).T
    low, high = np.array([one.prior.limits for one in alternatives]).reshape(-1, 2).T
    most, moved = np.array([one.likely_in(record) for one in alternatives]), np.abs(rates * amounts[:, None])
    detected = (
        (chances * len(alternatives) < SCORE_CHANCE) & explains(linear, taken)
        & (SCORE_OVER * low - HALF_WIDTH * errors <= amounts) & (amounts <= SCORE_OVER * high + HALF_WIDTH * errors)
        & (moved > SCORE_MOVES * np.array(relative_errors(record.fit))).any(axis=1)
    )  # fmt: skip
    ends = np.abs(amounts) + np.array([t_quantile(LEVEL, round(dof)) for dof in dofs.tolist()]) * errors
    excluded = np.abs(rates).max(axis=1, initial=0.0) * ends < SCORE_MATTERS
    words = np.where(detected, DETECTED, np.where(excluded, EXCLUDED, UNDECIDED))
    numbers = (amounts, errors, chances, taken, taken / np.maximum(linear.left, taken), *rates.T,
               np.maximum(low, -most), most, words, np.full(sizes.size, record.known.quantile))  # fmt: skip
    each = zip(alternatives, *(column.tolist() for column in numbers), strict=True)
    return [Score(one.name, one.family, one.amount, one.of_directions, *own) for one, *own in each]


def explains(linear: Linearised, taken: Array) -> Array:
    """Whether what is ``taken`` from chi^2 is more than any column takes of a misfit as slow, by the F of one number:
    excess^2, less what the alternative explains."""
    misfit, excess = linear.left - np.count_nonzero(linear.rows), _excess(linear.record.fit, linear.left)
    return taken >= SCORE_TIED * (excess > 1) * excess**2 * np.maximum(1 - taken / max(misfit, TINY), 0.0)


def _excess(fit: ForceCurveFit, left: float) -> float:
    """How many times misfit widens standard errors where it hides causes as noise does, else 1: as chi^2 of ``left`` by
    as many numbers as there are unknowns at most, for what they leave changes its sign as often."""
    excess = min(fit.spread.excess, math.sqrt(left / max(fit.x.size, 1)))
    return excess if excess > SCORE_MISFIT else 1.0


def _octaves(n: int) -> Array:
    """The first of ``n`` frequencies of each octave."""
    return np.append(0, 2 ** np.arange(math.ceil(math.log2(n))))


def _chances(record: FittedRecord, left: Array | None, rows: Array, sizes: Array, taken: Array, dofs: Array) -> Array:
    """The chances that noise makes one number more, along what is ``left`` of each column, as large as ``sizes``, take
    as much of chi^2: the mean over the spectra that are possible where white noise is likeliest, each of which raises
    it as much as the column is slow."""
    possible, noise = record.fit.spread.possible, record.fit.spread.noise
    if possible is None or left is None:
        return numerics.f_tail(1, dofs, taken)
    used = np.flatnonzero(rows)
    taken_at = record.model.rows[used] - record.model.rows[used].min()  # as white noise of those missing tells nothing
    size = fast_length(int(taken_at.max()) + 1)  # with some rows more at an end, where the contact is free
    if len(record.model.stretches) == 1 and record.model.stretches[0].kind == APPROACH:
        taken_at += size - 1 - taken_at.max()
    which, there = np.zeros(size, dtype=int), np.zeros(size)
    which[taken_at], there[taken_at] = used, 1.0
    series = left.take(which, axis=1)
    series *= there  # 0 where no row was taken
    power, edges = cosine_transform(series), _octaves(size)
    power *= power
    energy = np.add.reduceat(power, edges, axis=1)
    power *= frequencies(size)
    centre = np.add.reduceat(power, edges, axis=1) / np.maximum(energy, TINY)
    energy /= (noise.A * np.where(sizes > 0, sizes, np.inf) ** 2)[:, None]  # of c'/|c'|, 0 where there is none
    raised = possible.of_waves(centre, energy) / noise.A
    return possible.chance @ _tails(taken / np.maximum(raised, TINY), record.fit.spread.dof)


def _tails(taken: Array, dof: float) -> Array:
    """The chances that the square of Student's t of ``dof`` degrees of freedom is above each of ``taken``: between even
    t by cubics of their logs through values and slopes, good to 1e-6; nan where nothing is known."""
    place = np.sqrt(taken)
    farthest = min(float(np.fmax.reduce(place, axis=None, initial=0.0)), SCORE_FARTHEST) / SCORE_TAIL
    cubics = _log_tails(dof, 1 << math.ceil(farthest).bit_length())  # as many as several records may share
    logs = cubics(np.minimum(place, cubics.x[-1]))
    return np.where((logs > math.log(TINY)) | np.isnan(place), np.exp(logs), 0.0)


@lru_cache(maxsize=REMEMBERED)
def _log_tails(dof: float, count: int) -> PiecewiseCubic:
    """Cubics through the log of the two-sided tail of Student's t, at ``count`` + 1 even t."""
    nodes = SCORE_TAIL * np.arange(count + 1)
    peak = 2 * math.exp(math.lgamma((dof + 1) / 2) - math.lgamma(dof / 2)) / math.sqrt(dof * math.pi)

    def density(t: Array) -> Array:
        """That of |t|."""
        return peak * (1 + t**2 / dof) ** (-(dof + 1) / 2)

    # the tail at the nodes: its integral between them, from the last one inwards
    between, weights = numerics.composite_gauss(nodes)
    pieces = np.sum(weights * density(between), axis=1)
    last = numerics.f_chance(1, dof, float(nodes[-1]) ** 2)
    tail = np.maximum(np.cumsum(np.append(last, pieces[::-1]))[::-1], TINY)
    return PiecewiseCubic(nodes, np.log(tail), -density(nodes) / tail)


def chance_of(fit: ForceCurveFit, taken: float) -> float:
    """The chance that noise makes one number more take as much of chi^2."""
    return numerics.f_chance(1, max(fit.spread.dof / fit.spread.tau, 1.0), max(taken, 0.0))


def misfit_left(record: FittedRecord, rows: Array) -> tuple[float, int, int]:
    """chi^2 of what a fit leaves on some ``rows``, its degrees of freedom, and how many rows the noise is estimated
    from."""
    (table,) = tables([record], ())
    return table.taken(rows)[1].left, max(int(np.count_nonzero(rows)) - record.fit.x.size, 1), _loose(record)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A fit with its derivatives in units of the noise, for steps of models that differ a little, on some ``rows`` of
    the ``table``. ``gram``: products of its columns in these units. J = Q ``root`` over the lengths ``scale`` of its
    columns; ``along``: what of all columns is along Q, ``inverse``: the unknowns in their lengths by that.
    Of the columns c of alternatives, c' what is left of them beyond the model's: ``sizes`` |c'|, ``shared``: what of
    the residuals is along it, and by how much the unknowns ``moves`` per amount, (alternatives, unknowns)."""

    table: Table
    rows: Array
    gram: Array
    scale: Array
    root: Array
    along: Array
    inverse: Array
    sizes: Array
    shared: Array
    moves: Array

    @property
    def record(self) -> FittedRecord:
        return self.table.record

    @property
    def left(self) -> float:
        """chi^2 of what is left of the residuals."""
        return float(self.gram[0, 0] - self.along[:, 0] @ self.along[:, 0])

    @property
    def x(self) -> Array:
        """The unknowns where the derivatives of chi^2 vanish, as they need not in the fit itself, at the kink of a
        fold."""
        return self.record.fit.x - self.inverse @ self.along[:, 0] / self.scale

    @cached_property
    def Q(self) -> Array:
        """Q, (rows, unknowns)."""
        return (self.inverse.T @ (self.whitened(self.record.jacobian.T) / self.scale[:, None])).T

    @np.errstate(all="ignore")
    def step(self, residuals: Array) -> tuple[Array, float]:
        """What the unknowns are to fall by for ``residuals`` [N] of all rows, and chi^2 of what is left then."""
        r = self.whitened(residuals)
        along = r @ self.Q
        return self.inverse @ along / self.scale, float(r @ r - along @ along)

    def whitened(self, columns: Array) -> Array:
        """Columns of all rows [N], (..., rows), in units of the noise, where those left out count as exact."""
        noise = self.record.fit.spread.noise
        if not noise.slow:
            return columns * self.weights
        return self.record.model.whitened((columns * self.rows).T, noise).T

    @property
    def weights(self) -> Array:
        """Of each row, of noise that is white."""
        return self.rows / math.sqrt(self.record.fit.spread.noise.A)

    @property
    def whole(self) -> Array:
        """The sizes |c| of the columns of alternatives."""
        return np.sqrt(np.diag(self.gram)[1 + len(self.scale) :])

    def alike(self, which: int) -> Array:
        """The correlations of what is left of the columns of alternatives with that of one."""
        c, first = self.along[:, 1 + len(self.scale) :], 1 + len(self.scale)
        both = self.sizes * self.sizes[which]
        shared = self.gram[first:, first + which] - c.T @ c[:, which]
        return np.where(both > 0, shared, 0.0) / np.where(both > 0, both, 1.0)

    def size(self, step: Array) -> float:
        """The size of a step, in standard errors of white noise."""
        return float(np.linalg.norm(self.root @ (self.scale * step)))


def linearised(asked: Sequence[tuple[Table, Array]]) -> list[Linearised]:
    """Fits with the columns of their tables, each on some of its rows."""
    return _factored([(table, rows, table.gram(rows)) for table, rows in asked])


def _factored(asked: Sequence[tuple[Table, Array, Array]]) -> list[Linearised]:
    """Fits by the products of columns over some rows, those of as many columns together: J^T J = V L V^T over the
    lengths of the columns, Q = J V L^(-1/2) over them."""

    def alike(size: tuple[int, int], some: Sequence[tuple[Table, Array, Array]]) -> Iterator[Linearised]:
        p, grams = slice(1, 1 + size[0]), np.stack([gram for *_, gram in some])
        scales = np.sqrt(np.diagonal(grams, 0, 1, 2)[:, p])
        scales = np.where(scales > 0, scales, 1.0)  # of an unknown that none of the rows determines, which stays
        squares, vectors = np.linalg.eigh(grams[:, p, p] / (scales[:, :, None] * scales[:, None]))
        seen = squares > SCORE_DIGITS * squares.max(axis=1, initial=0.0, keepdims=True)
        roots = np.sqrt(np.where(seen, squares, 1.0))[:, None]
        inverses, factors = vectors * seen[:, None] / roots, (vectors * seen[:, None] * roots).transpose(0, 2, 1)
        along = inverses.transpose(0, 2, 1) @ (grams[:, p] / scales[..., None])
        numbers = (grams, scales, factors, along, inverses, *_evidence(grams, scales, along, inverses))
        for (table, rows, _), *own in zip(some, *numbers, strict=True):
            yield Linearised(table, rows, *own)

    return by_groups(asked, lambda one: (one[0].record.fit.x.size, len(one[0].columns)), alike)


def _evidence(gram: Array, scale: Array, along: Array, inverse: Array) -> tuple[Array, Array, Array]:
    """Of the columns c of alternatives, c' what is left of them beyond the model's: |c'|, what of the residuals is
    along it, and by how much the unknowns move per amount (alternatives, unknowns); of several fits."""
    alternatives = slice(1 + scale.shape[-1], None)
    c, r, whole = along[..., alternatives], along[..., :1], np.sqrt(np.diagonal(gram, 0, -2, -1)[..., alternatives])
    sizes = np.sqrt(np.maximum(whole**2 - np.sum(c * c, axis=-2), 0.0))
    seen = sizes > SCORE_SEEN * whole
    shared = gram[..., 0, alternatives] - np.sum(r * c, axis=-2)
    moves = -(inverse @ c).swapaxes(-1, -2) / scale[..., None, :]
    return np.where(seen, sizes, 0.0), np.where(seen, shared, 0.0) / np.where(seen, sizes, 1.0), moves


def least_taken(most: float) -> float:
    """What an alternative takes from chi^2 at least that is named beside the one that takes ``most``."""
    return min(most - SCORE_TIED, SCORE_NEAR * most)


def by_moves(fit: ForceCurveFit) -> Array:
    """Changes of the logs of E* and w with moves of the unknowns, (2, unknowns)."""
    by = by_unknown(fit, fit.model.stretches)
    return np.array([[float(name == "ln_s") for name in fit.names], [by.get(name, 0.0) for name in fit.names]])


def by_unknown(fit: ForceCurveFit, stretches: Sequence[DirectionReadings]) -> dict[str, float]:
    """Derivatives of ln w of the last of the ``stretches`` whose w is above its error, by the unknowns: w = s q =
    s r^2."""
    for part in reversed(stretches):
        for name, power in ((f"q:{part.kind}", 1.0), (f"r:{part.kind}", 2.0)):
            if name in fit.names and fit.value(name) > HALF_WIDTH * fit.error(name):
                return {name: power / fit.value(name), "ln_s": 1.0}
    return {}


def relative_errors(fit: ForceCurveFit) -> tuple[float, float]:
    """Relative standard errors of E* and w, infinite where they are not determined."""
    E = fit.error("ln_s") if "ln_s" in fit.names else math.inf
    rates = by_unknown(fit, fit.model.stretches)
    by = np.array([rates.get(name, 0.0) for name in fit.names])
    return E, math.sqrt(max(float(by @ fit.covariance @ by), 0.0)) if rates else math.inf


def _loose(record: FittedRecord) -> int:
    """From how many rows the noise is estimated, 0 where they are too few."""
    loose = sum(part.size for part in record.model.free(record.residuals))
    return loose if loose >= COLOURED_FREE else 0

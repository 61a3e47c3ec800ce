"""What the data say of every alternative of a raw record's model, by one step of Gauss and Newton each.

Residuals r, the Jacobian J and the column c of an alternative are weighted by the spectrum of the noise in the free
rows. With r' and c' what is left of them beyond the columns of J, the alternative takes (c' r')^2/c'^2 from chi^2, one
degree of freedom where the model holds; its amount is -c' r'/c'^2 with the standard error 1/|c'|, and the unknowns move
by -J+ c per amount. That detects, and does not name: alternatives that take nearly as much of the misfit as the best
are named together.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import NamedTuple

import numpy as np

from ..base import numerics
from ..base.errors import JkrError, SolveError
from ..base.numerics import HALF_WIDTH, LEVEL, MOST_SOLVES, MOST_STEPS, REMEMBERED, TINY, UNSEEN, Array
from ..bodies.problem import GEL_TENSION
from .alternatives import (
    ADHESION_ENDLESS,
    ALTERNATIVES,
    AMOUNT,
    LITTLE,
    LONG,
    RANGE,
    TENSION,
    AlternativeModel,
    ChangedModel,
    FittedRecord,
    Perturbation,
    amount_of_range,
    amount_of_tension,
    changed_offs,
    prepare,
)
from .curve import APPROACH
from .force_curve import ForceCurveFit, ForceCurveModel, fit, misfit_at, rough, starts_of, windowed
from .least_squares import (
    COLOURED_FREE,
    SEARCH_DIGITS,
    STATISTICS_IMPROBABLE,
    Spectrum,
    frequencies,
    in_time,
    t_quantile,
)
from .lockstep import Flow, alone, answers, ask, beside, quiet, together

DETECTED, EXCLUDED, UNDECIDED = "favoured by the data", "excluded", "not distinguishable"

# When an alternative is detected, and when it is excluded.
SCORE_CHANCE = 0.01  # choice: of any alternative being detected in data of the model itself
SCORE_MOVES = 0.5  # choice: of its error, by which E* or w must move
SCORE_MATTERS = 0.02  # choice: relative change of E* and w, below which an alternative is excluded
SCORE_TIED = 9.0  # choice: of chi^2, three standard errors: alternatives nearer are named together or not at all
SCORE_NEAR = 0.5  # choice: of the misfit that the best takes, the same: one step is of first order
SCORE_OVER = 1.25  # choice: of what is possible, up to which an amount may come out: the same
SCORE_ALIKE = 0.9  # choice: correlation of what is left of two columns, from which they are named together
# rows about a fold, that no fall of chi^2 counts; tuned on right records, by `make record-rivals`
SCORE_BESIDE = 1.5
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
    ``quantile``: half-width of intervals, in standard errors.
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

    def change(self, rate: float) -> float:
        """Relative change, with the amount, of a quantity whose logarithm moves by ``rate`` per amount."""
        return math.expm1(min(self.amount * rate, 700.0))

    def moved(self, rate: float) -> float:
        """How far a quantity may be off, relative, that moves by ``rate`` per amount: by the amount and its error, at
        the level of the intervals, where the alternative is detected; else by the largest that the data and what is
        known leave."""
        if self.word == DETECTED and math.isfinite(self.error):
            return abs(rate) * (abs(self.amount) + self.quantile * self.error)
        return abs(rate) * self.most if rate else 0.0

    @cached_property
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
    ``dof``; ``loose``: free rows that the noise is estimated from, 0 where they are too few."""

    scores: tuple[Score, ...]
    named: tuple[Score, ...]
    misfit: float
    dof: int
    loose: int

    @property
    def families(self) -> tuple[str, ...]:
        """The families of those that are named, the likeliest first."""
        return tuple(dict.fromkeys(one.family for one in self.named))

    @property
    def chance(self) -> float:
        """That noise makes as much of any alternative as of the best one."""
        return min(1.0, len(self.scores) * min((one.chance for one in self.scores), default=1.0))

    def worst(self, quantity: str) -> tuple[str, float] | None:
        """The alternative that may move "E_star" or "w" most, and by how much, relative: of the named, where some
        are."""
        return self._worst[quantity]

    @cached_property
    def _worst(self) -> dict[str, tuple[str, float] | None]:
        worst: dict[str, tuple[str, float] | None] = {}
        for quantity in ("E_star", "w"):
            moves = {one.name: one.moved(getattr(one, quantity)) for one in self.named or self.scores}
            name = max(moves, key=lambda key: moves[key], default="")
            worst[quantity] = (name, moves[name]) if name and moves[name] > 0 else None
        return worst


@dataclass(frozen=True)
class FittedAlternative:
    """An alternative fitted in full: by how much chi^2 ``falls``, the ``chance`` that the noise of the free rows leaves
    as much, whether it is ``taken``; E* [Pa], w [J/m^2], and its own ``quantities``, SI, by name."""

    name: str
    family: str
    falls: float
    chance: float
    taken: bool
    E_star: float
    w: float
    quantities: Mapping[str, float]


@dataclass(frozen=True)
class Verdict:
    """The ``alternatives`` of a record and what a formula of the half-space makes of its deepest row: ``formula`` by
    name and its ``E_star`` [Pa], None where the tip has no radius. ``fitted``: alternatives that were fitted in full,
    best first; if the first is taken it is the model of the answer, and those ``tied`` with it, taken too, cannot be
    distinguished.
    """

    alternatives: RecordAlternatives
    formula: str
    E_star: float | None
    fitted: tuple[FittedAlternative, ...] = ()

    @property
    def tied(self) -> tuple[FittedAlternative, ...]:
        """Those that are taken, the best one first."""
        return tuple(one for one in self.fitted if one.taken)

    @property
    def families(self) -> tuple[str, ...]:
        """The families that are named: of those that are tied, else of those that one step names."""
        return tuple(dict.fromkeys(one.family for one in self.tied)) or self.alternatives.families


def alternatives_of_records(records: Sequence[FittedRecord]) -> list[RecordAlternatives | Exception]:
    """The scores of all alternatives of some fits, each by itself."""
    found: list[RecordAlternatives | Exception] = []
    with contextlib.suppress(JkrError, ArithmeticError):  # of one of them, which tells so itself
        prepare(records)
    white = [record for record in records if not record.fit.spread.noise.slow]
    linear = dict(zip(white, answers(linearised, [(one, [one.regular]) for one in white]), strict=True))
    for record in records:
        one = linear.get(record)
        try:
            found.append(one if isinstance(one, Exception) else _scored(record, None if one is None else one[0]))
        except (JkrError, ArithmeticError, np.linalg.LinAlgError) as error:
            found.append(error)
    return found


def _scored(record: FittedRecord, linear: Linearised | None) -> RecordAlternatives:
    """The scores of one; ``linear``: of noise that is white, on the rows that columns are trusted in."""
    table, noise, own = record.table, record.fit.spread.noise, 1 + record.fit.x.size
    if linear is None:
        rows = record.regular
        table = _weighted(record, table, rows)
        linear = Linearised.of_table(record, rows, table)
    rows = linear.rows
    sizes, along, moves = linear.evidence
    left = None
    if noise.slow or record.fit.spread.possible is not None:
        left = moves @ table[1:own]  # c' = c + J moves
        left += table[own:]
    dofs, misfit = _noise_dofs(record.fit, left, sizes), linear.left
    chances = _chances(record, left, rows, sizes, along**2, dofs)
    evidence = zip(sizes.tolist(), along.tolist(), linear.whole.tolist(), dofs.tolist(), chances.tolist(), strict=True)
    rates, errors = (moves @ _by_moves(record.fit).T).tolist(), relative_errors(record.fit)
    scores = [
        _score(record, alternative, _Evidence(*items, len(record.alternatives), misfit), (E, w), errors)
        for alternative, items, (E, w) in zip(record.alternatives, evidence, rates, strict=True)
    ]
    dof = max(int(np.count_nonzero(rows)) - record.fit.x.size, 1)
    return RecordAlternatives(tuple(scores), _named(scores, linear.alike), misfit, dof, _loose(record))


class _Evidence(NamedTuple):
    """What the rows say of one of ``alternatives``: |c'|, c' r'/|c'|, |c|, degrees of freedom of the noise, and the
    chance of what it takes from the ``misfit``, chi^2 in all."""

    size: float
    along: float
    whole: float
    dof: float
    chance: float
    alternatives: int
    misfit: float


def _score(
    record: FittedRecord, alternative: AlternativeModel, by: _Evidence, rates: tuple[float, float],
    errors: tuple[float, float],
) -> Score:  # fmt: skip
    """The score of an alternative that moves the logs of E* and w at these ``rates`` per amount; ``errors``: theirs."""
    most, quantile, (low, high) = alternative.likely_in(record), record.known.quantile, alternative.limits
    labels = alternative.name, alternative.family, alternative.amount, alternative.of_directions
    likely = max(low, -most), most
    if by.size <= UNSEEN * by.whole:
        return Score(*labels, 0.0, math.inf, 1.0, 0.0, 0.0, *rates, *likely, UNDECIDED, quantile)
    amount, error, taken = -by.along / by.size, 1 / by.size, by.along**2
    room, E, w = HALF_WIDTH * error, abs(rates[0]), abs(rates[1])
    detected = (
        by.chance * by.alternatives < SCORE_CHANCE
        and SCORE_OVER * low - room <= amount <= SCORE_OVER * high + room
        and (E * abs(amount) > SCORE_MOVES * errors[0] or w * abs(amount) > SCORE_MOVES * errors[1])
    )
    end = abs(amount) + t_quantile(LEVEL, round(by.dof)) * error
    excluded = max(E, w) * end < SCORE_MATTERS
    word = DETECTED if detected else EXCLUDED if excluded else UNDECIDED
    share = taken / max(by.misfit, taken)
    return Score(*labels, amount, error, by.chance, taken, share, *rates, *likely, word, quantile)


def _noise_dofs(fit: ForceCurveFit, left: Array | None, sizes: Array) -> Array:
    """The degrees of freedom of the noise at the frequencies of what is ``left`` of each column, as large as ``sizes``:
    waves of the free rows in each octave, of which a share has as much of the variance, at least one."""
    spread = fit.spread
    if left is None or not spread.noise.slow:
        return np.full(sizes.size, float(spread.dof))
    rows = left.shape[1]
    edges = _octaves(rows)
    share = np.add.reduceat((left / np.where(sizes > 0, sizes, np.inf)[:, None]) ** 2, edges, axis=1)
    counts = np.maximum(np.diff(np.append(edges, rows)) * spread.dof / rows, 1)
    return 1 / np.maximum((share**2 / counts).sum(axis=1), 1 / max(spread.dof, 1.0))


@lru_cache(maxsize=REMEMBERED)
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
    size = numerics.fast_length(int(taken_at.max()) + 1)  # with some rows more at an end, where the contact is free
    if len(record.model.stretches) == 1 and record.model.stretches[0].kind == APPROACH:
        taken_at += size - 1 - taken_at.max()
    which, there = np.zeros(size, dtype=int), np.zeros(size)
    which[taken_at], there[taken_at] = used, 1.0
    series = left.take(which, axis=1)
    series *= there  # 0 where no row was taken
    power, edges = numerics.cosine_transform(series), _octaves(size)
    power *= power
    energy = np.add.reduceat(power, edges, axis=1)
    power *= frequencies(size)
    centre = np.add.reduceat(power, edges, axis=1) / np.maximum(energy, TINY)
    energy /= (noise.A * np.where(sizes > 0, sizes, np.inf) ** 2)[:, None]  # of c'/|c'|, 0 where there is none
    raised = possible.of_waves(centre, energy) / noise.A
    mean: Array = possible.chance @ _tails(taken / np.maximum(raised, TINY), record.fit.spread.dof)
    return mean


def _tails(taken: Array, dof: float) -> Array:
    """The chances that the square of Student's t of ``dof`` degrees of freedom is above each of ``taken``: between even
    t by cubics of their logs through values and slopes, good to 1e-6; nan where nothing is known."""
    place = np.sqrt(taken) / SCORE_TAIL
    farthest = min(float(np.fmax.reduce(place, axis=None, initial=0.0)), SCORE_FARTHEST / SCORE_TAIL)
    cubics = _log_tails(dof, 1 << math.ceil(farthest).bit_length())  # as many as several records may share
    last = cubics.shape[1]
    i = np.fmin(place, last - 1.0).astype(int)
    x, (c0, c1, c2, c3) = np.minimum(place, last) - i, cubics.take(i, axis=1)
    chances: Array = np.exp(c0 + x * (c1 + x * (c2 + x * c3)))
    return np.where((c0 > math.log(TINY)) | np.isnan(x), chances, 0.0)


@lru_cache(maxsize=REMEMBERED)
def _log_tails(dof: float, count: int) -> Array:
    """Coefficients of those cubics, (4, count)."""
    nodes = SCORE_TAIL * np.arange(count + 1)
    peak = 2 * math.exp(math.lgamma((dof + 1) / 2) - math.lgamma(dof / 2)) / math.sqrt(dof * math.pi)

    def density(t: Array) -> Array:
        """That of |t|."""
        values: Array = peak * (1 + t**2 / dof) ** (-(dof + 1) / 2)
        return values

    # the tail at the nodes: its integral between them, from the last one inwards
    between, weights = numerics.composite_gauss(nodes)
    pieces = np.sum(weights * density(between), axis=1)
    last = numerics.f_chance(1, dof, float(nodes[-1]) ** 2)
    tail = np.maximum(np.cumsum(np.append(last, pieces[::-1]))[::-1], TINY)
    slope, log = -SCORE_TAIL * density(nodes) / tail, np.log(tail)
    rise = np.diff(log)
    return np.stack([log[:-1], slope[:-1], 3 * rise - 2 * slope[:-1] - slope[1:], slope[:-1] + slope[1:] - 2 * rise])


def chance_of(fit: ForceCurveFit, taken: float) -> float:
    """The chance that noise makes one number more take as much of chi^2."""
    return numerics.f_chance(1, max(fit.spread.dof / fit.spread.tau, 1.0), max(taken, 0.0))


def misfit_left(record: FittedRecord, rows: Array) -> tuple[float, int, int]:
    """chi^2 of what a fit leaves on some ``rows``, its degrees of freedom, and how many rows the noise is estimated
    from."""
    own = np.vstack([record.residuals, record.jacobian.T])
    left = Linearised.of_table(record, rows, _weighted(record, own, rows)).left
    return left, max(int(np.count_nonzero(rows)) - record.fit.x.size, 1), _loose(record)


def misfit_of(record: FittedRecord, rows: Array, noise: Spectrum) -> float:
    """chi^2 of some ``rows``, in units of a ``noise``, as a fit to all of them leaves it: those at folds hold its folds
    where they are."""
    r = record.residuals[rows]
    r = noise.whitened(in_time(r, record.model.rows[rows], noise) if noise.slow else r)
    return float(r @ r)


def common_rows(record: FittedRecord, other: FittedRecord) -> Array:
    """Which rows of a fit an ``other`` has, too, but for those at the fold of either."""
    return off_folds(record) & np.isin(record.model.rows, other.model.rows[off_folds(other)])


def off_folds(record: FittedRecord) -> Array:
    """Which rows are not right at the fold that a stretch jumps at: there the load rises with a root of the distance,
    so that a fold misplaced by less than from row to row leaves many times the noise, in a model that is right."""
    rows = []
    for part, (a, _) in zip(record.model.stretches, record.radii, strict=True):
        fold = part.z[a > 0].min() if part.jumped and (a > 0).any() else math.inf
        rows.append(np.abs(part.z - fold) > SCORE_BESIDE * part.spacing)
    return np.concatenate(rows)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A fit with its derivatives in units of the noise, for steps of models that differ a little, on some ``rows``.
    ``gram``: products of the residuals, these derivatives and the columns of alternatives, as far as they are asked
    for, in these units. J = Q R over the lengths ``scale`` of its columns, R the ``triangle``; ``along``: what of all
    columns is along Q."""

    record: FittedRecord
    rows: Array
    gram: Array
    scale: Array
    triangle: Array
    along: Array

    @classmethod
    def of(cls, record: FittedRecord, rows: Array | None = None, alternatives: bool = False) -> Linearised:
        """That of all rows or some, of which the others count as exact; with the columns of ``alternatives`` or
        without."""
        rows = np.ones(record.residuals.size, dtype=bool) if rows is None else rows
        if alternatives:
            ((one,),) = linearised([(record, [rows])])
            return one
        own = np.vstack([record.residuals, record.jacobian.T])
        return cls.of_table(record, rows, record.model.whitened((own * rows).T, record.fit.spread.noise).T)

    @classmethod
    def of_table(cls, record: FittedRecord, rows: Array, weighted: Array) -> Linearised:
        """That of residuals, derivatives and columns of alternatives in units of the noise (columns, rows)."""
        return cls.several([record], [rows], (weighted @ weighted.T)[None], [lambda: weighted])[0]

    @classmethod
    def several(
        cls, records: Sequence[FittedRecord], rows: Sequence[Array], grams: Array,
        weighted: Sequence[Callable[[], Array]],
    ) -> list[Linearised]:  # fmt: skip
        """Those of some records with as many columns each, by J^T J of their ``grams``; by a QR decomposition of what
        is ``weighted`` where J^T J loses too many digits."""
        p = slice(1, 1 + records[0].fit.x.size)
        scales = np.sqrt(np.diagonal(grams, 0, 1, 2)[:, p])
        scales = np.where(scales > 0, scales, 1.0)  # of an unknown that none of the rows determines, which stays
        lower, each = np.zeros((len(grams), scales.shape[1], scales.shape[1])), range(len(grams))
        try:
            lower = np.linalg.cholesky(grams[:, p, p] / (scales[:, :, None] * scales[:, None]))
        except np.linalg.LinAlgError:
            if len(grams) > 1:
                return [
                    one for i in each for one in cls.several([records[i]], [rows[i]], grams[i, None], [weighted[i]])
                ]
        sizes = np.diagonal(lower, 0, 1, 2)
        good = sizes.min(axis=1, initial=1.0) > SEARCH_DIGITS * sizes.max(axis=1, initial=1.0)
        lower[~good] = np.eye(scales.shape[1])
        alongs = np.linalg.solve(lower, grams[:, p] / scales[..., None])
        triangles, found = lower.transpose(0, 2, 1), list[Linearised]()
        evidence = zip(*_evidence(grams, scales, alongs, np.linalg.inv(triangles)), strict=True)
        for i, of_alternatives in enumerate(evidence):
            if good[i]:
                found.append(cls(records[i], rows[i], grams[i], scales[i], triangles[i], alongs[i]))
                vars(found[-1])["evidence"] = of_alternatives
                continue
            table = weighted[i]()
            Q, R = np.linalg.qr((table[p] / scales[i, :, None]).T)
            found.append(cls(records[i], rows[i], grams[i], scales[i], R, Q.T @ table.T))
        return found

    @cached_property
    def own(self) -> Array:
        """The derivatives in units of the noise, (unknowns, rows)."""
        return self.whitened(self.record.jacobian.T)

    @cached_property
    def left(self) -> float:
        """chi^2 of what is left of the residuals."""
        return float(self.gram[0, 0] - self.along[:, 0] @ self.along[:, 0])

    @cached_property
    def x(self) -> Array:
        """The unknowns where the derivatives of chi^2 vanish, as they need not in the fit itself, at the kink of a
        fold."""
        x: Array = self.record.fit.x - self.inverse @ self.along[:, 0] / self.scale
        return x

    @cached_property
    def Q(self) -> Array:
        """Q, (rows, unknowns)."""
        Q: Array = (self.inverse.T @ (self.own / self.scale[:, None])).T
        return Q

    @cached_property
    def inverse(self) -> Array:
        """The unknowns in their lengths by what is along ``Q``: rows that are left out may determine one alone."""
        sizes = np.abs(np.diag(self.triangle))
        if sizes.min(initial=1.0) > SEARCH_DIGITS * sizes.max(initial=1.0):
            return np.asarray(np.linalg.inv(self.triangle))
        inverse: Array = np.linalg.pinv(self.triangle, rcond=len(self.triangle) * np.finfo(float).eps)
        return inverse

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
        weighted: Array = self.record.model.whitened((columns * self.rows).T, noise).T
        return weighted

    @cached_property
    def weights(self) -> Array:
        """Of each row, of noise that is white."""
        weights: Array = self.rows / math.sqrt(self.record.fit.spread.noise.A)
        return weights

    @cached_property
    def residuals(self) -> Array:
        """What the fit leaves of the rows, in units of the noise."""
        return self.whitened(self.record.residuals)

    @cached_property
    def whole(self) -> Array:
        """The sizes |c| of the columns of alternatives."""
        whole: Array = np.sqrt(np.diag(self.gram)[1 + len(self.scale) :])
        return whole

    @cached_property
    def evidence(self) -> tuple[Array, Array, Array]:
        """The ``_evidence`` of its alternatives."""
        sizes, along, moves = _evidence(self.gram, self.scale, self.along, self.inverse)
        return sizes, along, moves

    def alike(self, which: int) -> Array:
        """The correlations of what is left of the columns of alternatives with that of one."""
        c, first, sizes = self.along[:, 1 + len(self.scale) :], 1 + len(self.scale), self.evidence[0]
        shared = self.gram[first:, first + which] - c.T @ c[:, which]
        both = sizes * sizes[which]
        correlations: Array = np.where(both > 0, shared, 0.0) / np.where(both > 0, both, 1.0)
        return correlations

    def size(self, step: Array) -> float:
        """The size of a step, in standard errors of white noise."""
        return float(np.linalg.norm(self.triangle @ (self.scale * step)))


def linearised(asked: Sequence[tuple[FittedRecord, Sequence[Array]]]) -> list[list[Linearised]]:
    """Fits with the columns of alternatives, each on several choices of its rows; those of as many columns together."""
    each = [(record, rows) for record, choices in asked for rows in choices]
    alike: dict[tuple[int, int], list[int]] = {}
    for place, (record, _) in enumerate(each):
        alike.setdefault((record.fit.x.size, len(record.table)), []).append(place)
    found: dict[int, Linearised] = {}
    for places in alike.values():
        records, rows = zip(*(each[place] for place in places), strict=True)
        weighted = [partial(_on_rows, *each[place]) for place in places]
        grams = [
            (table := of()) @ table.T if record.fit.spread.noise.slow
            else record.products(some) / record.fit.spread.noise.A
            for record, some, of in zip(records, rows, weighted, strict=True)
        ]  # fmt: skip
        found |= dict(zip(places, Linearised.several(records, rows, np.stack(grams), weighted), strict=True))
    ordered = iter([found[place] for place in range(len(each))])
    return [[next(ordered) for _ in choices] for _, choices in asked]


def _on_rows(record: FittedRecord, rows: Array) -> Array:
    """The table in units of the noise, where the other rows count as exact."""
    return record.model.whitened((record.table * rows).T, record.fit.spread.noise).T


def _evidence(gram: Array, scale: Array, along: Array, inverse: Array) -> tuple[Array, Array, Array]:
    """Of the columns c of alternatives, c' what is left of them beyond the model's: |c'|, what of the residuals is
    along it, and by how much the unknowns move per amount (alternatives, unknowns); of one ``Linearised`` or of
    several."""
    alternatives = slice(1 + scale.shape[-1], None)
    c, r, whole = along[..., alternatives], along[..., :1], np.sqrt(np.diagonal(gram, 0, -2, -1)[..., alternatives])
    sizes = np.sqrt(np.maximum(whole**2 - np.sum(c * c, axis=-2), 0.0))
    seen = sizes > SCORE_SEEN * whole
    shared = gram[..., 0, alternatives] - np.sum(r * c, axis=-2)
    moves = -(inverse @ c).swapaxes(-1, -2) / scale[..., None, :]
    return np.where(seen, sizes, 0.0), np.where(seen, shared, 0.0) / np.where(seen, sizes, 1.0), moves


def _named(scores: Sequence[Score], alike: Callable[[int], Array]) -> tuple[Score, ...]:
    """Those that are detected and take nearly as much as the best, or whose columns are much ``alike`` its own."""
    detected = [i for i, one in enumerate(scores) if one.word == DETECTED]
    if not detected:
        return ()
    detected.sort(key=lambda i: -scores[i].taken)
    best = detected[0]
    least, same = least_taken(scores[best].taken), np.abs(alike(best)) > SCORE_ALIKE
    return tuple(scores[i] for i in detected if scores[i].taken >= least or same[i])


def least_taken(most: float) -> float:
    """What an alternative takes from chi^2 at least that is named beside the one that takes ``most``."""
    return min(most - SCORE_TIED, SCORE_NEAR * most)


def _by_moves(fit: ForceCurveFit) -> Array:
    """Changes of the logs of E* and w with moves of the unknowns, (2, unknowns)."""
    by = _by_unknown(fit)
    return np.array([[float(name == "ln_s") for name in fit.names], [by.get(name, 0.0) for name in fit.names]])


def _by_unknown(fit: ForceCurveFit) -> dict[str, float]:
    """Derivatives of ln w of the last direction whose w is above its error, by the unknowns: w = s q = s r^2."""
    for part in reversed(fit.model.stretches):
        for name, power in ((f"q:{part.kind}", 1.0), (f"r:{part.kind}", 2.0)):
            if name in fit.names and fit.value(name) > HALF_WIDTH * fit.error(name):
                return {name: power / fit.value(name), "ln_s": 1.0}
    return {}


def relative_errors(fit: ForceCurveFit) -> tuple[float, float]:
    """Relative standard errors of E* and w, infinite where they are not determined."""
    E = fit.error("ln_s") if "ln_s" in fit.names else math.inf
    rates = _by_unknown(fit)
    by = np.array([rates.get(name, 0.0) for name in fit.names])
    return E, math.sqrt(max(float(by @ fit.covariance @ by), 0.0)) if rates else math.inf


def _weighted(record: FittedRecord, table: Array, rows: Array) -> Array:
    """The ``rows`` of a ``table`` (columns, rows) in units of the noise of the free rows, so that noise has unit
    variance and no colour."""
    noise, some = record.fit.spread.noise, table.take(np.flatnonzero(rows), axis=1)
    return (
        noise.whitened(in_time(some.T, record.model.rows[rows], noise)).T if noise.slow else some / math.sqrt(noise.A)
    )


def _loose(record: FittedRecord) -> int:
    """From how many rows the noise is estimated, 0 where they are too few."""
    loose = sum(part.size for part in record.model.free(record.residuals))
    return loose if loose >= COLOURED_FREE else 0


# --------------------------------------------------------------------------------------------------
# The best alternatives of each family, fitted in full where the data ask for them, and the one that is taken.
#
# The best one is taken where its misfit is lower than that of the plain model by more than ``SCORE_TIED``, in chi^2,
# and what it leaves is no more than the noise of the free rows. Those within as much of it cannot be distinguished.

# Which alternatives are fitted in full, and when one is taken.
FULL_EACH = 3  # choice: of a family, its best by one step, which does not always name the right one
FULL_STEPS = 20  # choice: guard, of a search that only finds out which alternatives are worth a fit
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
FULL_LONGER = 6.0  # choice: of chi^2, odds of 1 to 20, of a range longer than is likely
FULL_ABOUT = 0.5  # choice: standard errors, by which what a range does to a fit may be off
FULL_FALLING = 2.0  # choice: of the step to come, by which chi^2 may still fall
FULL_STILL = 0.02  # choice: standard errors, below which a step is the last one
FULL_SLOW = 0.3  # choice: of w of the retraction, the least w of a slow edge to start from where none advanced
FULL_SETTLED = 0.1  # choice: standard errors of the modulus, by which the last round may move it


Moves = tuple[float, float, float]  # rises of chi^2 and of the logs of E* and w


@dataclass(frozen=True, eq=False)
class AlternativeFit:
    """An alternative fitted in full: its one-step ``score``; ``chance``: that the noise of the free rows leaves as
    much, where no row is next to a fold; ``falls``: how much lower chi^2 is than without, on the rows of both that are
    off the folds, in units of the noise without."""

    score: Score
    fit: ForceCurveFit
    chance: float
    falls: float

    @property
    def passes(self) -> bool:
        return self.fit.ended and self.chance > STATISTICS_IMPROBABLE

    def taken(self, best: AlternativeFit) -> bool:
        """Whether the ``best`` one rejects the model without and this one leaves about as little, as noise would."""
        return self.passes and best.falls > SCORE_TIED and self.falls > best.falls - SCORE_TIED


def bounds(record: FittedRecord, alternatives: RecordAlternatives) -> Flow[RecordAlternatives]:
    """The alternatives with their ``_bounds``: unknowns that no row determines may go anywhere meanwhile."""
    return quiet(_bounds(record, alternatives))


def _bounds(record: FittedRecord, alternatives: RecordAlternatives) -> Flow[RecordAlternatives]:
    """The alternatives, of which those that are likely before the data move E* and w by what a fit with as much of them
    as is possible does: one step trusts no row next to a fold. ``record``: the fit without."""
    if alternatives.named:
        return alternatives
    every = np.ones(record.residuals.size, dtype=bool)
    off, near = yield from ask(linearised, (record, [off_folds(record), every]))
    by_moves = _by_moves(record.fit)
    each = [_bounded(off if one.name in (RANGE.name, TENSION.name) else near, one, i, by_moves)
            for i, one in enumerate(alternatives.scores)]  # fmt: skip
    followed = yield from beside([quiet(one) for one in each if not isinstance(one, Score)])
    ends = iter(followed)
    scores = [one if isinstance(one, Score) else next(ends) for one in each]
    named = next((_with_alike(one, scores) for one in scores if one.word == DETECTED), ())
    return replace(alternatives, scores=tuple(scores), named=named)


def _bounded(near: Linearised, score: Score, which: int, by_moves: Array) -> Score | Flow[Score]:
    """The score with the moves at the largest amount that is possible, or what leads to it: to first order where they
    are small by it, and long ranges of adhesion, of which it says nothing, are excluded. ``which`` of the columns is
    the alternative's; ``by_moves``: of the fit."""
    ranged, tense = score.name == RANGE.name, score.name == TENSION.name
    if not (ranged or tense or score.most > 0):
        return score
    (sizes, along, moves), alternative, record = near.evidence, _alternative(score), near.record
    ahead, error = moves[which], 1 / max(float(sizes[which]), math.sqrt(TINY))
    best = -float(along[which]) * error
    falls = (max(best, 0.0) / error) ** 2
    if tense and not record.known.tension and falls < FULL_HARDLY * FULL_LEANING:
        return score  # no data lean to any
    certain = max(score.amount, 0.0) + FULL_EXCLUDED * score.error
    long = ranged and amount_of_range(record, FULL_RANGES[-1] * record.neck) <= certain
    seen = replace(score, amount=best, error=error) if ranged else score
    rates = by_moves @ ahead
    little = seen.most > 0 and float(np.abs(rates).max()) * seen.most < FULL_LINEAR * SCORE_MATTERS
    if little and not (tense or long or (ranged and _by_chance(record, falls))):
        return replace(seen, E_star=float(rates[0]), w=float(rates[1]), word=EXCLUDED if ranged else score.word)
    change = alternative.effect(record)
    if not isinstance(change, Perturbation):
        return score
    if not (ranged or tense):
        return _at_most(near, change, ahead, score)
    tried = _Amounts(near, change, ahead)
    return _of_ranges(tried, score, certain, long) if ranged else _of_tension(tried, score)


def _with_alike(best: Score, scores: Sequence[Score]) -> tuple[Score, ...]:
    """The ``best``, and those that take nearly as much of the misfit, though they see fewer rows."""
    limits, least = {alternative.name: alternative.limits for alternative in ALTERNATIVES}, least_taken(best.taken)
    others = [one for one in scores if one is not best and one.taken > least]
    return (best, *(one for one in others if limits[one.name][0] <= one.amount <= limits[one.name][1]))


def _alternative(score: Score) -> AlternativeModel:
    return next(alternative for alternative in ALTERNATIVES if alternative.name == score.name)


def _at_most(near: Linearised, change: Perturbation, ahead: Array, score: Score) -> Flow[Score]:
    """The score with the moves at the largest amount that is possible, about ``ahead`` per amount."""
    begin = near.x + score.most * ahead
    end = yield from _followed(near, _with_amount(near.record, change, score.most), still=FULL_ABOUT, begin=begin)
    E, w = (math.nan, math.nan) if end is None else _moves(near, end[1])
    return replace(score, E_star=E / score.most, w=w / score.most) if math.isfinite(E + w) else score


@dataclass(frozen=True, eq=False)
class _Amounts:
    """What the data say of those amounts of a ``change`` that were tried, ``near`` the fit without: by how much chi^2
    and the logs of E* and w rise, None where the data exclude it for certain, by three standard errors, or where steps
    do not settle; ``ends``: the unknowns of those that are left, which move by ``ahead`` per amount at first."""

    near: Linearised
    change: Perturbation
    ahead: Array
    moves: dict[float, Moves | None] = field(default_factory=dict)
    ends: dict[float, Array] = field(default_factory=dict)
    first: dict[float, Array] = field(default_factory=dict)

    @property
    def left(self) -> dict[float, Moves]:
        """The moves at those that are left."""
        return {amount: moves for amount, moves in self.moves.items() if moves is not None}

    def at(self, amount: float) -> Flow[Moves | None]:
        """The moves at an amount, from where those below lead."""
        model = _with_amount(self.near.record, self.change, amount)
        end = yield from _followed(self.near, model, SCORE_TIED, FULL_ABOUT, self._begin(amount))
        moves = None if end is None else (end[0], *_moves(self.near, end[1]))
        self.moves[amount] = None
        if end is not None and moves is not None and moves[0] < SCORE_TIED and np.isfinite(moves).all():
            self.moves[amount], self.ends[amount] = moves, end[1]
        return self.moves[amount]

    def look_ahead(self, amounts: Sequence[float]) -> tuple[list[float], Array]:
        """To first order in the loads about by how much chi^2 rises at some amounts, and the moves of the unknowns."""
        near = self.near
        c = near.whitened(near.record.by_bodies(near.record.bodies_at(self.change, amounts)))
        own, r = c @ near.Q, near.residuals
        rises = np.vecdot(c, c) + 2 * (c @ r) - np.vecdot(own, own + 2 * (r @ near.Q))
        return rises.tolist(), -(own @ near.inverse.T) / near.scale

    def _first(self, amount: float) -> Array:
        """Moves of the unknowns to first order, between amounts that were looked at on straight lines."""
        if amount in self.first or not self.first:
            return self.first.get(amount, amount * self.ahead)
        known = [0.0, *sorted(self.first)]
        rows = np.array([np.zeros_like(self.ahead), *(self.first[one] for one in known[1:])])
        return np.array([np.interp(amount, known, column) for column in rows.T])

    def _begin(self, amount: float) -> Array:
        """Unknowns at an amount: to first order, and what is missing to those that are left next to it, or at the two
        below, on the straight line through these; nothing where none is left next to it: another valley may begin
        there."""
        missing = {0.0: np.zeros_like(self.near.x)}
        missing |= {one: x - self.near.x - self._first(one) for one, x in self.ends.items()}
        points, more = [0.0], min((more for more in self.moves if more > amount), default=0.0)
        for less in sorted(less for less in self.moves if less < amount):
            points = [*points, less] if less in missing else points[:1]
        points += [more] if more in self.ends else []
        first, last = points[-2:][0], points[-1]
        share = (amount - last) / (last - first) if last > first else 0.0
        return self.near.x + self._first(amount) + missing[last] + (missing[last] - missing[first]) * share


def _of_ranges(tried: _Amounts, score: Score, certain: float, long: bool) -> Flow[Score]:
    """The score with the moves at ranges up to the longest that there may be, or where one step excludes all amounts
    beyond ``certain`` and with them the ``long`` ones, up to the end of the interval, from where that step has it
    on."""
    record, within, unsure = tried.near.record, score.quantile**2, score.quantile * score.error
    if long:
        amounts, shortest = sorted({*_ranges(record, score)}), amount_of_range(record, FULL_RANGES[-1] * record.neck)
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
        leans = bool(known) or -least > FULL_LEANING or _by_chance(record, -least)
        if (moves is None and len(tried.moves) > 1) or (rises and not leans):
            break  # no larger one is left either, or takes more
    return (yield from _of_amounts(tried, score)) if leans else score


def _by_chance(record: FittedRecord, taken: float) -> bool:
    """Whether so much of chi^2 is more than chance takes with any of the alternatives."""
    return chance_of(record.fit, taken) < SCORE_CHANCE / len(ALTERNATIVES)


def _of_amounts(tried: _Amounts, score: Score) -> Flow[Score]:
    """The score with the largest moves at those amounts ``tried`` that the data leave, where they leave none, at
    smaller ones; it is detected where one takes enough of the misfit. Those beyond the interval count by the chord to
    it, as moves may grow steeply there; longer ranges than are likely count where the data outweigh
    their odds."""
    within, least = score.quantile**2, min(tried.moves)
    likely = score.known if score.name == RANGE.name else math.inf
    longer = math.inf if tried.near.record.known.told else FULL_LONGER

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
    if _by_chance(record, taken):
        return replace(_moving(score, best, left[best][1:]), amount=best, word=DETECTED, chance=chance, taken=taken)
    chords = [min(1.0, score.quantile / math.sqrt(max(moves[0], TINY))) * np.abs(moves[1:])
              for moves in possible().values()]  # fmt: skip
    moving = _moving(score, end, np.max(chords, axis=0).tolist())
    return replace(moving, amount=best * (taken > 0), chance=chance, taken=max(taken, 0.0))


def _ranges(record: FittedRecord, score: Score) -> list[float]:
    """Amounts of ranges to try: endless ones, that no short one is detected for, and the longest that is likely."""
    ranges = (ADHESION_ENDLESS, *FULL_RANGES)
    return [*(amount_of_range(record, times * record.neck) for times in ranges), score.known]


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


def _with_amount(record: FittedRecord, change: Perturbation, amount: float) -> ChangedModel:
    """The model with an amount of a change that is known."""
    return ChangedModel.of(record.model, change, {AMOUNT: amount})


def _followed(
    near: Linearised, model: ChangedModel, most: float = math.inf, still: float = FULL_STILL, begin: Array | None = None
) -> Flow[tuple[float, Array] | None]:
    """By how much chi^2 rises in a ``model`` whose change is known, and its unknowns, by steps with the derivatives of
    the fit without, down to ``still`` standard errors, from ``begin`` on, else from that fit; None where they do not
    settle, or come to a contact that is nowhere stable, or chi^2 will not fall to about ``most``."""
    x, size, excess = near.x if begin is None else begin, math.inf, math.inf
    with contextlib.suppress(SolveError, ArithmeticError):  # unknowns that no row determines may go anywhere
        for _ in range(MOST_STEPS):
            step, left = near.step((yield from ask(changed_offs, (model, x, 0.0))))
            before, size, x, excess = size, near.size(step), x - step, left - near.left
            if not (size < before and excess < most + FULL_FALLING * size):
                return None
            if size < still:
                break
        return excess, x
    return None


@np.errstate(all="ignore")
def fit_alternatives(
    record: FittedRecord, fresh: ForceCurveModel, alternatives: RecordAlternatives
) -> tuple[AlternativeFit, ...]:
    """The best of each family, by how much the misfit falls, those that pass first; ``fresh``: the model of the
    record before its fit left any row out."""
    fresh, begun = replace(fresh, family=record.model.family), []
    for score in _likeliest(alternatives):
        with contextlib.suppress(JkrError):  # what cannot be solved is not taken
            if isinstance(change := _alternative(score).effect(record), Perturbation):
                begun.append((*_roughly(record, fresh, change, score.amount), change, score))
    most = FULL_PROMISING * min((cost for cost, *_ in begun), default=0.0)
    fits = []
    for cost, x, change, score in begun:
        if cost <= most:
            with contextlib.suppress(JkrError):
                fits.append(_in_full(record, ChangedModel.of(fresh, change), x, score))
    return tuple(sorted(fits, key=lambda one: (not one.passes, -one.falls)))


def _likeliest(alternatives: RecordAlternatives) -> Iterator[Score]:
    """Those of each family that one step takes most from the misfit with: it detects, so that neither sign nor size of
    an amount that is not small says much. The range of adhesion stands for a long one, which has a column alone."""
    detected = [one for one in alternatives.scores if one.taken > SCORE_TIED or one in alternatives.named]
    ranked = sorted(detected, key=lambda one: -one.taken)
    of_range = next((one for one in alternatives.scores if one.name == RANGE.name), None)
    for family in dict.fromkeys(one.family for one in ranked):
        best = [one for one in ranked if one.family == family][:FULL_EACH]
        yield from dict.fromkeys((of_range or one) if one.name == LONG.name else one for one in best)


def _roughly(record: FittedRecord, fresh: ForceCurveModel, change: Perturbation, amount: float) -> tuple[float, Array]:
    """About the least misfit with a ``change``, and its unknowns: from the best of its starts and what one step asks
    for, and from the best that the body suggests at each of these."""
    low, high = change.limits.get(AMOUNT, (-math.inf, math.inf))
    starts = dict.fromkeys([(min(max(amount, low), high), *change.starts[0][1:]), *change.starts])
    model = ChangedModel.of(fresh, change)
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
            searches.append(rough(model, min(group, key=partial(misfit_at, model)), FULL_STEPS))
    if not searches:
        raise SolveError("no curve with this change resembles the force curve")
    return min(searches, key=lambda one: one[0])


def _valleys(record: FittedRecord, model: ChangedModel, starts: Iterable[tuple[float, ...]]) -> Iterator[Array]:
    """Unknowns to start from with those of the fit without as an amount would have them, at those amounts that leave no
    more than the ones next to them."""
    near, starts = Linearised.of(record, off_folds(record)), sorted(starts)
    flows = [_followed(near, _with_amount(record, model.change, start[0]), still=FULL_ABOUT) for start in starts]
    ends = []
    for end in together(flows):
        if isinstance(end, Exception):
            raise end
        ends.append(end)
    left = np.array([math.inf, *(math.inf if end is None else end[0] for end in ends), math.inf])
    lowest = left[1:-1] <= np.minimum(left[:-2], left[2:])
    for start, end, low in zip(starts, ends, lowest, strict=True):
        if end is not None and low:
            yield np.append(_unknowns(record, model, end[1]), start)


def _unknowns(record: FittedRecord, model: ChangedModel, x: Array) -> Array:
    """The unknowns of a ``model`` but its change's as they are at ``x``, those that were known at what they were."""
    values = record.model.values(x)
    roots = {f"r:{part.kind}": math.sqrt(max(values[f"q:{part.kind}"], 0.0)) for part in model.stretches}
    own = [name for name in model.names if name not in model.change.names]
    return np.array([({"turn": 0.0} | roots | values)[name] for name in own])


def _new(record: FittedRecord, model: ChangedModel, start: tuple[float, ...]) -> Iterator[Array]:
    """Unknowns about an amount to ``start`` from, as its body suggests."""
    if model.change.loads_back is not None:
        x, i = _unknowns(record, model, record.fit.x), model.names.index(f"q:{model.stretches[-1].kind}")
        x[i] = max(record.values[f"q:{model.stretches[0].kind}"], FULL_SLOW * x[i])
        yield np.append(x, start)
    if model.change.model is None or model.change.coupled:
        return
    values = {**record.values, **dict(zip(model.change.names, start, strict=True))}
    with contextlib.suppress(JkrError):
        yield from (np.append(x, start) for x in starts_of(model.followed(model.stretches[-1], values)))


def _in_full(record: FittedRecord, model: ChangedModel, x: Array, score: Score) -> AlternativeFit:
    here = FittedRecord(record.body, reconverge(to_the_end(model, x)))
    misfit, dof, loose = misfit_left(here, here.regular)
    chance = numerics.f_chance(dof, max(loose, 1), misfit / dof)
    return AlternativeFit(score, here.fit, chance, fall_of(record, here))


def to_the_end(model: ForceCurveModel, x: Array) -> ForceCurveFit:
    """The fit from about there, without the rows about first touch."""
    full = fit(model, x, near=True)
    without = windowed(full)
    return full if without is full.model else fit(without, full.x, near=True)


def fall_of(record: FittedRecord, here: FittedRecord) -> float:
    """How much lower chi^2 is ``here`` than without, on the rows of both that are off the folds."""
    noise = record.fit.spread.noise  # for all alternatives: misfit that is slow may pass for noise of the fit's own
    plain = misfit_of(record, common_rows(record, here), noise)
    return plain - misfit_of(here, common_rows(here, record), noise)


RANGE_LOWER = 4.0  # theory: chi^2 of one unknown at 95 %, by which a minimum with a longer range is to be lower
RANGE_EVERY = 3  # choice: of the Tabor numbers of ``ADHESION_TABOR``, which stand closer than minima


def with_range_of(record: FittedRecord, fresh: ForceCurveModel, change: Perturbation, amount: float) -> ForceCurveFit:
    """The fit with an ``amount`` of a range of adhesion that is known."""
    model = ChangedModel.of(fresh, change, {AMOUNT: amount})
    near = Linearised.of(record, off_folds(record))
    end = alone(_followed(near, _with_amount(record, change, amount), still=FULL_ABOUT))
    return to_the_end(model, _unknowns(record, model, record.fit.x if end is None else end[1]))


def with_free_range(
    record: FittedRecord, fresh: ForceCurveModel, change: Perturbation
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
    best, fall, ends = None, -FULL_LEANING, list[tuple[ForceCurveFit, float]]()
    for x in starts:
        with contextlib.suppress(SolveError):
            full = to_the_end(model, x)
            falls = fall_of(record, FittedRecord(record.body, full))
            if full.ended:
                ends.append((full, falls))
                if falls > (fall if best is None else fall + RANGE_LOWER):
                    best, fall = full, falls
    if best is not None:
        ends += [(one, fall_of(record, FittedRecord(record.body, one))) for one in near]
        return best, [one for one, falls in ends if one is not best and falls > fall - RANGE_LOWER]
    raise SolveError(
        "the fit with a range of adhesion does not converge: none leaves as little as JKR, which it contains; leave "
        "the range out, or fix it"
    )


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

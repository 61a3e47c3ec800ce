"""What the data say of every rival of a raw record's model, by one step of Gauss and Newton each.

Residuals r, the Jacobian J and the column c of a rival are weighted by the spectrum of the noise in the free rows. With
r' and c' what is left of them beyond the columns of J, the rival takes (c' r')^2/c'^2 from chi^2, one degree of freedom
where the model holds; its amount is -c' r'/c'^2 with the standard error 1/|c'|, and the unknowns move by -J+ c per
amount. That detects, and does not name: rivals that take nearly as much of the misfit as the best are named together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import fdtrc

from ...base import TINY, UNSEEN, Array
from .coloured import TUNING as COLOURED
from .coloured import Spectrum, frequencies, in_time, waves
from .fitted_record import FittedRecord
from .force_curve_fit import ForceCurveFit
from .record_change import TUNING as CHANGES
from .record_rivals import Rival, columns
from .statistics import t_quantile

DETECTED, EXCLUDED, UNDECIDED = "asked for by the data", "excluded", "cannot be told"


@dataclass(frozen=True)
class ScoreTuning:
    """When a rival is detected, and when it is excluded."""

    chance: float = 0.01  # choice: of any rival being detected in data of the model itself
    moves: float = 0.5  # choice: of its error, by which E* or w must move
    matters: float = 0.02  # choice: relative change of E* and w, below which a rival is excluded
    tied: float = 9.0  # choice: of chi^2, three standard errors: rivals nearer are named together or not at all
    near: float = 0.5  # choice: of the misfit that the best takes, the same: one step is of first order
    over: float = 1.25  # choice: of what is possible, up to which an amount may come out: the same
    normal: float = 1.96  # theory: 95 % of a normal value
    alike: float = 0.9  # choice: correlation of what is left of two columns, from which they are named together
    # rows about a fold, that no fall of chi^2 counts; tuned on right records, by `make record-rivals`
    beside: float = 1.5


TUNING = ScoreTuning()


@dataclass(frozen=True)
class Score:
    """What the data say of one rival, by its ``name`` and ``family``; ``amount_is``: what its ``amount`` is, in words.

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
    quantile: float = TUNING.normal

    def change(self, rate: float) -> float:
        """Relative change, with the amount, of a quantity whose logarithm moves by ``rate`` per amount."""
        return math.expm1(min(self.amount * rate, 700.0))

    def moved(self, rate: float) -> float:
        """How far a quantity may be off, relative, that moves by ``rate`` per amount: by the amount and its error, at
        the level of the intervals, where the rival is detected; else by the largest that the data and what is known
        leave."""
        if self.word == DETECTED and math.isfinite(self.error):
            return abs(rate) * (abs(self.amount) + self.quantile * self.error)
        return abs(rate) * self.most if rate else 0.0

    @property
    def most(self) -> float:
        """The largest amount that is known to be possible and not excluded by the data."""
        if math.isinf(self.error):
            return self.known
        room = self.quantile * self.error
        interval = (self.amount - room, self.amount + room)
        return max(abs(min(max(end, self.least), self.known)) for end in interval)


@dataclass(frozen=True)
class RecordRivals:
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
        """That noise makes as much of any rival as of the best one."""
        return min(1.0, len(self.scores) * min((one.chance for one in self.scores), default=1.0))

    def worst(self, quantity: str) -> tuple[str, float] | None:
        """The rival that may move "E_star" or "w" most, and by how much, relative: of the named, where some are."""
        moves = {one.name: one.moved(getattr(one, quantity)) for one in self.named or self.scores}
        name = max(moves, key=lambda key: moves[key], default="")
        return (name, moves[name]) if name and moves[name] > 0 else None


@dataclass(frozen=True)
class FittedRival:
    """A rival fitted in full: by how much chi^2 ``falls``, the ``chance`` that the noise of the free rows leaves as
    much, whether it is ``taken``; E* [Pa], w [J/m^2], and its own ``quantities``, SI, by name."""

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
    """The ``rivals`` of a record and what a formula of the half-space makes of its deepest row: ``formula`` by name and
    its ``E_star`` [Pa], None where the tip has no radius. ``fitted``: rivals that were fitted in full, best first; if
    the first is taken it is the model of the answer, and those ``tied`` with it, taken too, cannot be distinguished.
    """

    rivals: RecordRivals
    formula: str
    E_star: float | None
    fitted: tuple[FittedRival, ...] = ()

    @property
    def tied(self) -> tuple[FittedRival, ...]:
        """Those that are taken, the best one first."""
        return tuple(one for one in self.fitted if one.taken)

    @property
    def families(self) -> tuple[str, ...]:
        """The families that are named: of those that are tied, else of those that one step names."""
        return tuple(dict.fromkeys(one.family for one in self.tied)) or self.rivals.families


def rivals_of_record(record: FittedRecord) -> RecordRivals:
    """The scores of all rivals of a fit."""
    by_rival, rows, J = columns(record), regular_rows(record), record.jacobian
    table = np.column_stack([record.residuals, J, *by_rival.values()])
    weighted, loose = _weighted(record, table, rows)
    own, c = weighted[:, 1 : 1 + J.shape[1]], weighted[:, 1 + J.shape[1] :]
    scale, Q, triangle = _factors(own)
    r, beyond = (x - Q @ (Q.T @ x) for x in (weighted[:, 0], c))
    sizes = np.linalg.norm(beyond, axis=0)
    unit = beyond / np.maximum(sizes, TINY)  # c'/|c'|
    along = r @ unit
    moves = -np.linalg.lstsq(triangle, Q.T @ c, rcond=None)[0] / scale[:, None]
    dof, misfit = max(int(np.count_nonzero(rows)) - J.shape[1], 1), float(r @ r)
    dofs = _noise_dofs(record.fit, unit)
    evidence = zip(sizes.tolist(), along.tolist(), np.linalg.norm(c, axis=0).tolist(), dofs,
                   _chances(record, unit, rows, along**2, dofs).tolist(), strict=True)  # fmt: skip
    scores = [
        _score(record, rival, _Evidence(*items, len(by_rival), misfit), _rates(record.fit, move))
        for rival, items, move in zip(by_rival, evidence, moves.T, strict=True)
    ]
    return RecordRivals(tuple(scores), _named(scores, unit), misfit, dof, loose)


@dataclass(frozen=True)
class _Evidence:
    """What the rows say of one of ``rivals``: |c'|, c' r'/|c'|, |c|, degrees of freedom of the noise, and the chance of
    what it takes from the ``misfit``, chi^2 in all."""

    size: float
    along: float
    whole: float
    dof: float
    chance: float
    rivals: int
    misfit: float


def _score(record: FittedRecord, rival: Rival, by: _Evidence, rates: tuple[float, float]) -> Score:
    """The score of a rival that moves the logs of E* and w at these ``rates`` per amount."""
    most, quantile, (low, high) = rival.likely_in(record), record.known.quantile, rival.limits
    labels, likely = (rival.name, rival.family, rival.amount, rival.of_directions), (max(low, -most), most)
    if by.size <= UNSEEN * by.whole:
        return Score(*labels, 0.0, math.inf, 1.0, 0.0, 0.0, *rates, *likely, UNDECIDED, quantile)
    amount, error, taken = -by.along / by.size, 1 / by.size, by.along**2
    room = TUNING.normal * error
    detected = (
        TUNING.over * low - room <= amount <= TUNING.over * high + room
        and by.chance * by.rivals < TUNING.chance
        and any(abs(rate * amount) > TUNING.moves * own
                for rate, own in zip(rates, relative_errors(record.fit), strict=True))
    )  # fmt: skip
    end = abs(amount) + t_quantile(0.95, round(by.dof)) * error
    excluded = max(map(abs, rates)) * end < TUNING.matters
    word = DETECTED if detected else EXCLUDED if excluded else UNDECIDED
    share = taken / max(by.misfit, taken)
    return Score(*labels, amount, error, by.chance, taken, share, *rates, *likely, word, quantile)


def _noise_dofs(fit: ForceCurveFit, unit: Array) -> list[float]:
    """The degrees of freedom of the noise at the frequencies of each ``unit`` column: waves of the free rows in each
    octave, of which a share has as much of the variance, at least one."""
    if not fit.spread.noise.slow:
        return [fit.spread.dof] * unit.shape[1]
    edges = _octaves(len(unit))
    share = np.add.reduceat(unit**2, edges, axis=0)
    counts = np.maximum(np.diff(np.append(edges, len(unit))) * fit.spread.dof / len(unit), 1)
    share = np.maximum((share**2 / counts[:, None]).sum(axis=0), 1 / max(fit.spread.dof, 1.0))
    return (1 / share).tolist()


def _octaves(n: int) -> Array:
    """The first of ``n`` frequencies of each octave."""
    return np.append(0, 2 ** np.arange(math.ceil(math.log2(n))))


def _chances(record: FittedRecord, unit: Array, rows: Array, taken: Array, dofs: Sequence[float]) -> Array:
    """The chances that noise makes one number more, along each ``unit`` column, take as much of chi^2: the mean over
    the spectra that are possible, each of which raises it as much as the column is slow."""
    possible, noise = record.fit.spread.possible, record.fit.spread.noise
    if possible is None:
        return np.array(fdtrc(1, dofs, taken))
    power = waves(in_time(unit, record.model.rows[rows], noise)) ** 2
    edges, f = _octaves(len(power)), frequencies(len(power))[:, None]
    energy = np.add.reduceat(power, edges, axis=0)
    centre = np.add.reduceat(f * power, edges, axis=0) / np.maximum(energy, TINY)
    raised = possible.of_waves(centre, energy) / noise.A
    chances = fdtrc(1, np.array(dofs), taken / np.maximum(raised, TINY))
    mean: Array = possible.chance @ chances
    return mean


def chance_of(fit: ForceCurveFit, taken: float) -> float:
    """The chance that noise makes one number more take as much of chi^2."""
    return float(fdtrc(1, max(fit.spread.dof / fit.spread.tau, 1.0), max(taken, 0.0)))


def misfit_left(record: FittedRecord, rows: Array) -> tuple[float, int, int]:
    """chi^2 of what a fit leaves on some ``rows``, its degrees of freedom, and how many rows the noise is estimated
    from."""
    J = record.jacobian
    weighted, loose = _weighted(record, np.column_stack([record.residuals, J]), rows)
    _, Q, _ = _factors(weighted[:, 1:])
    r = weighted[:, 0] - Q @ (Q.T @ weighted[:, 0])
    return float(r @ r), max(int(np.count_nonzero(rows)) - J.shape[1], 1), loose


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
        rows.append(np.abs(part.z - fold) > TUNING.beside * part.spacing)
    return np.concatenate(rows)


def regular_rows(record: FittedRecord) -> Array:
    """Which rows columns are trusted in: none next to a fold or first touch, where they diverge."""
    rows = []
    for part, (a, _) in zip(record.model.stretches, record.radii, strict=True):
        z, touching = part.z, a > 0
        first = z[touching].min() if touching.any() else math.inf
        span = max(CHANGES.fold * part.reach, 2 * part.spacing)
        rows.append(~touching | (z > first + span) if part.jumped else np.abs(z - first) > span)
    return np.concatenate(rows)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A fit with its derivatives in units of the noise, for steps of models that differ a little, on some ``rows``.
    ``x``: its unknowns where the derivatives of chi^2 vanish, as they need not in the fit itself, at the kink of a
    fold; ``left``: chi^2 left there."""

    record: FittedRecord
    rows: Array
    x: Array
    scale: Array
    Q: Array
    triangle: Array
    left: float

    @classmethod
    def of(cls, record: FittedRecord, rows: Array | None = None) -> Linearised:
        rows = np.ones(record.residuals.size, dtype=bool) if rows is None else rows
        weighted = record.model.whitened(record.jacobian * rows[:, None], record.fit.spread.noise)
        at_fit = cls(record, rows, record.fit.x, *_factors(weighted), 0.0)
        step, left = at_fit.step(record.residuals)
        return replace(at_fit, x=record.fit.x - step, left=left)

    @cached_property
    def inverse(self) -> Array:
        """The unknowns in their lengths by what is along ``Q``: rows that are left out may determine one alone."""
        inverse: Array = np.linalg.pinv(self.triangle, rcond=len(self.triangle) * np.finfo(float).eps)
        return inverse

    def step(self, residuals: Array) -> tuple[Array, float]:
        """What the unknowns are to fall by for ``residuals`` [N] of all rows, and chi^2 of what is left then."""
        r = self.record.model.whitened(residuals * self.rows, self.record.fit.spread.noise)
        along = self.Q.T @ r
        return self.inverse @ along / self.scale, float(r @ r - along @ along)

    def size(self, step: Array) -> float:
        """The size of a step, in standard errors of white noise."""
        return float(np.linalg.norm(self.triangle @ (self.scale * step)))


def _factors(own: Array) -> tuple[Array, Array, Array]:
    """Lengths of the model's own columns, and Q and R of these over them."""
    scale = np.maximum(np.linalg.norm(own, axis=0), TINY)
    return (scale, *np.linalg.qr(own / scale))


def _named(scores: Sequence[Score], unit: Array) -> tuple[Score, ...]:
    """Those that are detected and take nearly as much as the best, or whose ``unit`` column is much like its own."""
    detected = [i for i, one in enumerate(scores) if one.word == DETECTED]
    if not detected:
        return ()
    detected.sort(key=lambda i: -scores[i].taken)
    best = detected[0]
    least, alike = least_taken(scores[best].taken), np.abs(unit.T @ unit[:, best]) > TUNING.alike
    return tuple(scores[i] for i in detected if scores[i].taken >= least or alike[i])


def least_taken(most: float) -> float:
    """What a rival takes from chi^2 at least that is named beside the one that takes ``most``."""
    return min(most - TUNING.tied, TUNING.near * most)


def _rates(fit: ForceCurveFit, moves: Array) -> tuple[float, float]:
    """Changes of the logs of E* and w with ``moves`` of the unknowns."""
    by = dict(zip(fit.names, moves, strict=True))
    return float(by.get("ln_s", 0.0)), float(sum(rate * by.get(name, 0.0) for name, rate in _by_unknown(fit).items()))


def _by_unknown(fit: ForceCurveFit) -> dict[str, float]:
    """Derivatives of ln w of the last direction whose w is above its error, by the unknowns: w = s q = s r^2."""
    for part in reversed(fit.model.stretches):
        for name, power in ((f"q:{part.kind}", 1.0), (f"r:{part.kind}", 2.0)):
            if name in fit.names and fit.value(name) > TUNING.normal * fit.error(name):
                return {name: power / fit.value(name), "ln_s": 1.0}
    return {}


def relative_errors(fit: ForceCurveFit) -> tuple[float, float]:
    """Relative standard errors of E* and w, infinite where they are not determined."""
    E = fit.error("ln_s") if "ln_s" in fit.names else math.inf
    rates = _by_unknown(fit)
    by = np.array([rates.get(name, 0.0) for name in fit.names])
    return E, math.sqrt(max(float(by @ fit.covariance @ by), 0.0)) if rates else math.inf


def _weighted(record: FittedRecord, table: Array, rows: Array) -> tuple[Array, int]:
    """The ``rows`` of a ``table`` in units of the noise of the free rows, so that noise has unit variance and no
    colour; from how many rows it is estimated, 0 where they are too few."""
    noise, loose = record.fit.spread.noise, sum(part.size for part in record.model.free(table[:, 0]))
    ordered = in_time(table[rows], record.model.rows[rows], noise) if noise.slow else table[rows]
    return noise.whitened(ordered), loose if loose >= COLOURED.free else 0

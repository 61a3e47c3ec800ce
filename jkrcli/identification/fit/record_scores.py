"""What the data say of every rival of a raw record's model, by one step of Gauss and Newton each.

Residuals and columns are weighted by the spectrum of the noise in the free rows. A rival whose column c is left with
c' beside the model's own has the score (c' r)^2/c'^2, chi^2 of one degree of freedom where the model holds; its amount
is -c' r/c'^2, and the unknowns move with it by -J+ c. That detects, and does not name: rivals that take nearly as much
of the misfit as the best are named together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import fdtrc

from ...base import Array
from .coloured import TUNING as COLOURED
from .coloured import frequencies, in_time, waves
from .force_curve import ForceCurveFit
from .record_change import TUNING as CHANGES
from .record_rivals import Known, Rival, columns, known_amount
from .record_situation import Situation
from .statistics import t_quantile

ASKED, EXCLUDED, UNTOLD = "asked for by the data", "excluded", "cannot be told"


@dataclass(frozen=True)
class ScoreTuning:
    """When a rival is asked for, and when it is excluded."""

    chance: float = 0.01  # choice: of any rival being asked for, of data of the model itself
    moves: float = 0.5  # choice: of its error, by which E* or w must move
    matters: float = 0.02  # choice: relative change of E* and w, below which a rival is excluded
    tied: float = 9.0  # choice: of chi^2, three standard errors: rivals nearer are named together or not at all
    near: float = 0.5  # choice: of the misfit that the best takes, the same: one step is of first order
    over: float = 1.25  # choice: of what is possible, up to which an amount may come out: the same
    normal: float = 1.96  # theory: 95 % of a normal value
    alike: float = 0.9  # choice: correlation of what is left of two columns, from which they are named together
    singular: float = 1e-4  # choice: share of a column beyond the model's own, below which no data tell it
    # rows about a fold, that no fall of chi^2 counts; tuned on right records, by `make record-rivals`
    beside: float = 1.5


TUNING = ScoreTuning()


@dataclass(frozen=True)
class Score:
    """What the data say of one rival, by its ``name``, ``family`` and what its ``amount`` is in ``words``.

    ``error``: standard error of the amount, infinite where no row tells it; ``chance`` of as much from noise; ``taken``
    from chi^2, and the ``share`` of all that is; ``E_star``, ``w``: by how much their logarithms move per amount.
    ``least, known``: the amounts that are likely before the data; ``word``: one of three; ``wide``: half-width of what
    is stated, in standard errors.
    """

    name: str
    family: str
    words: str
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
    wide: float = TUNING.normal

    def change(self, rate: float) -> float:
        """Relative change, with the amount found, of a quantity whose logarithm moves by ``rate`` per amount."""
        return math.expm1(min(self.amount * rate, 700.0))

    def moved(self, rate: float) -> float:
        """How far a quantity may be off, relative, that moves by ``rate`` per amount: by the amount found and its
        error, at the level of the intervals, where the data ask for it; else by the largest that they and what is known
        leave."""
        if self.word == ASKED and math.isfinite(self.error):
            return abs(rate) * (abs(self.amount) + self.wide * self.error)
        return abs(rate) * self.most if rate else 0.0

    @property
    def most(self) -> float:
        """The largest amount that is known to be possible and not excluded by the data."""
        if math.isinf(self.error):
            return self.known
        room = self.wide * self.error
        reach = (self.amount - room, self.amount + room)
        return max(abs(min(max(end, self.least), self.known)) for end in reach)


@dataclass(frozen=True)
class RecordRivals:
    """The ``scores`` of a record, and among them those that are ``named``: asked for, and explaining the misfit about
    as well as the best one, which is the first. ``misfit``: chi^2 of the weighted residuals over their degrees of
    freedom ``dof``; ``loose``: free rows that told the noise, 0 where they are too few."""

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
class Tried:
    """A rival fitted in full: by how much chi^2 ``falls``, the ``chance`` that the noise of the free rows leaves as
    much, whether it is ``taken``; E* [Pa], w [J/m^2], and what else it ``told``, SI, by name."""

    name: str
    family: str
    falls: float
    chance: float
    taken: bool
    E_star: float
    w: float
    told: Mapping[str, float]


@dataclass(frozen=True)
class Verdict:
    """The ``rivals`` of a record and what a formula of the half-space makes of its deepest row: ``formula`` by name and
    its ``E_star`` [Pa], None where the tip has no radius. ``tried``: rivals that were fitted in full, best first; where
    the first is taken it is the model of the answer, and those ``tied`` with it, taken too, cannot be told from it.
    """

    rivals: RecordRivals
    formula: str
    E_star: float | None
    tried: tuple[Tried, ...] = ()

    @property
    def tied(self) -> tuple[Tried, ...]:
        """Those that are taken, the best one first."""
        return tuple(one for one in self.tried if one.taken)

    @property
    def families(self) -> tuple[str, ...]:
        """The families that are named: of those that are tied, else of those that one step names."""
        return tuple(dict.fromkeys(one.family for one in self.tied)) or self.rivals.families


def rivals_of_record(at: Situation, known: Known) -> RecordRivals:
    """All rivals of a fit, with what is ``known`` before the data."""
    held, found = columns(at), at.found
    keep = told_rows(at)
    names, (off, J) = list(held), at.here
    table = np.column_stack([off, J, *held.values()])
    weighted, loose = _weighted(at, table, keep)
    own, wide = weighted[:, 1 : 1 + J.shape[1]], weighted[:, 1 + J.shape[1] :]
    scale, Q, triangle = _spanned(own)
    r, beyond = (item - Q @ (Q.T @ item) for item in (weighted[:, 0], wide))
    sizes = np.linalg.norm(beyond, axis=0)
    left = beyond / np.maximum(sizes, np.finfo(float).tiny)
    moves = -np.linalg.lstsq(triangle, Q.T @ wide, rcond=None)[0] / scale[:, None]
    dof = max(int(np.count_nonzero(keep)) - J.shape[1], 1)
    misfit, errors, along, told = float(r @ r), errors_of(found), r @ left, _told_at(found, left)
    chances = _chances(at, left, keep, along**2, told)
    scores = [
        _score(rival, float(size), float(by), whole, _rates(found, move), errors,
               (misfit, own_dof, float(chance), len(names)), (known_amount(at, rival, known), known.wide))
        for rival, size, by, whole, move, own_dof, chance in zip(
            names, sizes, along, np.linalg.norm(wide, axis=0), moves.T, told, chances, strict=True)
    ]  # fmt: skip
    return RecordRivals(tuple(scores), _named(scores, left), misfit, dof, loose)


def _told_at(found: ForceCurveFit, left: Array) -> list[float]:
    """The degrees of freedom of the noise at the frequencies of each of the columns ``left``, of length 1: waves of the
    free rows in each octave, of which a share has as much of the variance, at least one."""
    if not found.spread.noise.slow:
        return [found.spread.dof] * left.shape[1]
    edges = np.append(0, 2 ** np.arange(math.ceil(math.log2(len(left)))))
    share = np.add.reduceat(left**2, edges, axis=0)
    counts = np.maximum(np.diff(np.append(edges, len(left))) * found.spread.dof / len(left), 1)
    return (1 / (share**2 / counts[:, None]).sum(axis=0)).tolist()


def _chances(at: Situation, left: Array, keep: Array, taken: Array, told: Sequence[float]) -> Array:
    """The chances that noise makes one number more, along each of the columns ``left``, take as much of chi^2: the mean
    over the spectra that are possible, each of which raises it as much as the column is slow."""
    possible, noise = at.found.spread.possible, at.found.spread.noise
    if not possible:
        return np.array(fdtrc(1, told, taken))
    power = waves(in_time(left, at.model.rows[keep], noise)) ** 2
    edges, f = np.append(0, 2 ** np.arange(math.ceil(math.log2(len(power))))), frequencies(len(power))[:, None]
    energy = np.add.reduceat(power, edges, axis=0)
    centre = np.add.reduceat(f * power, edges, axis=0) / np.maximum(energy, np.finfo(float).tiny)
    raised = np.array([np.sum(S(centre) * energy, axis=0) for _, S in possible]) / noise.A
    chances = fdtrc(1, np.array(told), taken / np.maximum(raised, np.finfo(float).tiny))
    mean: Array = np.array([share for share, _ in possible]) @ chances
    return mean


def at_chance(found: ForceCurveFit, taken: float) -> float:
    """The chance that noise makes one number more take as much of chi^2."""
    return float(fdtrc(1, max(found.spread.dof / found.spread.tau, 1.0), max(taken, 0.0)))


def left_over(at: Situation, keep: Array) -> tuple[float, int, int]:
    """chi^2 of what a fit leaves on the rows to ``keep``, its degrees of freedom, and how many rows told the noise."""
    off, J = at.here
    weighted, loose = _weighted(at, np.column_stack([off, J]), keep)
    _, Q, _ = _spanned(weighted[:, 1:])
    r = weighted[:, 0] - Q @ (Q.T @ weighted[:, 0])
    return float(r @ r), max(int(np.count_nonzero(keep)) - J.shape[1], 1), loose


def rows_of(at: Situation, other: Situation) -> Array:
    """Which rows of a fit an ``other`` has, too, but for those at the fold of either."""
    return off_folds(at) & np.isin(at.model.rows, other.model.rows[off_folds(other)])


def off_folds(at: Situation) -> Array:
    """Which rows are not right at the fold that a stretch jumps at: there the load rises with a root of the distance,
    so that a fold misplaced by less than from row to row leaves many times the noise, in a model that is right."""
    keep = []
    for part, (a, _) in zip(at.model.stretches, at.radii, strict=True):
        fold = part.z[a > 0].min() if part.jumped and (a > 0).any() else math.inf
        keep.append(np.abs(part.z - fold) > TUNING.beside * part.spacing)
    return np.concatenate(keep)


@dataclass(frozen=True, eq=False)
class Weighted:
    """The derivatives of a fit in units of the noise, for steps of models that differ a little, at the rows ``kept``.
    ``x``: its unknowns where these vanish, as they need not in the fit itself, at the kink of a fold; ``left``: chi^2
    left there."""

    at: Situation
    kept: Array
    x: Array
    scale: Array
    Q: Array
    triangle: Array
    left: float

    @classmethod
    def of(cls, at: Situation, kept: Array | None = None) -> Weighted:
        (off, J), noise = at.here, at.found.spread.noise
        kept = np.ones(off.size, dtype=bool) if kept is None else kept
        scale, Q, triangle = _spanned(at.model.whitened(J * kept[:, None], noise))
        plain = cls(at, kept, at.found.x, scale, Q, triangle, 0.0)
        step, left = plain.step(off)
        return replace(plain, x=at.found.x - step, left=left)

    @cached_property
    def inverse(self) -> Array:
        """The unknowns in their lengths by what is along ``Q``: rows that are left out may hold one alone."""
        found: Array = np.linalg.pinv(self.triangle, rcond=len(self.triangle) * np.finfo(float).eps)
        return found

    def step(self, off: Array) -> tuple[Array, float]:
        """What the unknowns are to fall by for residuals ``off`` [N] of all rows, and chi^2 of what is left then."""
        r = self.at.model.whitened(off * self.kept, self.at.found.spread.noise)
        along = self.Q.T @ r
        return self.inverse @ along / self.scale, float(r @ r - along @ along)

    def size(self, step: Array) -> float:
        """The size of a step, in standard errors of white noise."""
        return float(np.linalg.norm(self.triangle @ (self.scale * step)))


def _spanned(own: Array) -> tuple[Array, Array, Array]:
    """Lengths of the model's own columns, and the factors of what they span."""
    scale = np.maximum(np.linalg.norm(own, axis=0), np.finfo(float).tiny)
    return (scale, *np.linalg.qr(own / scale))


def _named(scores: Sequence[Score], left: Array) -> tuple[Score, ...]:
    """Those that are asked for and take nearly as much as the best, or whose column is much like its own; ``left``:
    what of the columns is beyond the model's own, each of length 1."""
    asked = sorted((i for i, one in enumerate(scores) if one.word == ASKED), key=lambda i: -scores[i].taken)
    if not asked:
        return ()
    least = least_of_named(scores[asked[0]].taken)
    alike = np.abs(left.T @ left[:, asked[0]]) > TUNING.alike
    return tuple(scores[i] for i in asked if scores[i].taken >= least or alike[i])


def least_of_named(most: float) -> float:
    """What a rival takes from chi^2 at least that is named beside the one that takes ``most``."""
    return min(most - TUNING.tied, TUNING.near * most)


def _score(
    rival: Rival, size: float, along: float, whole: float, rates: tuple[float, float], errors: tuple[float, float],
    judged: tuple[float, float, float, int], known: tuple[float, float],
) -> Score:  # fmt: skip
    """The score of a rival whose weighted column is ``whole`` long, ``size`` of it beyond the model's own, with the
    product ``along`` of that direction and the residuals; ``errors`` of E* and w, relative; ``judged``: chi^2, the
    degrees of freedom of the noise, the chance of what it takes, and how many rivals there are; ``known``: what is
    likely of it, and how wide a statement is."""
    (misfit, dof, chance, count), (most, wide) = judged, known
    told = (rival.name, rival.family, rival.amount, rival.of_directions)
    likely = (0.0 if rival.positive else -most, most)
    if size <= TUNING.singular * whole:
        return Score(*told, 0.0, math.inf, 1.0, 0.0, 0.0, *rates, *likely, UNTOLD, wide)
    amount, error, taken = -along / size, 1 / size, along**2
    room, reach = TUNING.normal * error, TUNING.over * rival.possible
    possible = (0.0 if rival.positive else -reach) - room <= amount <= reach + room
    asked = (
        possible
        and chance * count < TUNING.chance
        and any(abs(rate * amount) > TUNING.moves * own for rate, own in zip(rates, errors, strict=True))
    )
    ends = abs(amount) + t_quantile(0.95, round(dof)) * error
    word = ASKED if asked else EXCLUDED if max(map(abs, rates)) * ends < TUNING.matters else UNTOLD
    return Score(*told, amount, error, chance, taken, taken / max(misfit, taken), *rates, *likely, word, wide)


def _rates(found: ForceCurveFit, moves: Array) -> tuple[float, float]:
    """Relative changes of E* and w with ``moves`` of the unknowns."""
    by = dict(zip(found.names, moves, strict=True))
    return float(by.get("ln_s", 0.0)), float(sum(rate * by.get(name, 0.0) for name, rate in _of_work(found).items()))


def _of_work(found: ForceCurveFit) -> dict[str, float]:
    """Derivatives of the log of w of the last direction whose w is told, by the unknowns."""
    for part in reversed(found.model.stretches):
        for name, power in ((f"q:{part.kind}", 1.0), (f"r:{part.kind}", 2.0)):
            if name in found.names and found.value(name) > TUNING.normal * found.error(name):
                return {name: power / found.value(name), "ln_s": 1.0}
    return {}


def errors_of(found: ForceCurveFit) -> tuple[float, float]:
    """Relative standard errors of E* and w, infinite where they are not told."""
    E = found.error("ln_s") if "ln_s" in found.names else math.inf
    rates = _of_work(found)
    by = np.array([rates.get(name, 0.0) for name in found.names])
    return E, math.sqrt(max(float(by @ found.covariance @ by), 0.0)) if rates else math.inf


def told_rows(at: Situation) -> Array:
    """Which rows columns are trusted in: none next to a fold or first touch, where they diverge."""
    keep = []
    for part, (a, _) in zip(at.model.stretches, at.radii, strict=True):
        z, touching = part.z, a > 0
        near = z[touching].min() if touching.any() else math.inf
        span = max(CHANGES.fold * part.reach, 2 * part.spacing)
        keep.append(~touching | (z > near + span) if part.jumped else np.abs(z - near) > span)
    return np.concatenate(keep)


def _weighted(at: Situation, table: Array, keep: Array) -> tuple[Array, int]:
    """The rows of ``table`` in units of the noise of the free rows, so that noise has unit variance and no colour; how
    many rows told it, 0 where they are too few."""
    noise, loose = at.found.spread.noise, sum(part.size for part in at.model.free(table[:, 0]))
    ordered = in_time(table[keep], at.model.rows[keep], noise) if noise.slow else table[keep]
    return noise.whitened(ordered), loose if loose >= COLOURED.free else 0

"""The modulus, a law of relaxation and the zero point from one record over time.

What moved in straight pieces between corners, the device, its tip, or the load, is fitted with the rest. So its noise
has its part in the intervals. Where a lever is between, the readings of tip and load share noise: they are weighed by
their covariance. Where w is asked for, the whole record is fitted, with its retraction (``adhesive_march.py``).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import Program
from ..adhesion.finite_range import RangeRequest
from ..base.arguments import ranges_of, read_fields
from ..base.errors import InputError, JkrError, SolveError
from ..base.numerics import FEWEST_ROWS, LEVEL, MOST_STEPS, ROWS, SAME, TINY, Array, evenly
from ..base.units import Named, Ranged, show
from ..bodies.problem import RELAXATIONS, Relaxation
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import (
    SEARCH_MISFIT,
    SEARCH_REACH,
    Followed,
    Intervals,
    Least,
    LeastSquares,
    State,
    by_differences,
)
from ..measured.parameters import (
    ALIAS,
    MODULUS,
    Answer,
    Level,
    Nameable,
    Parameter,
    Unknowns,
    check_law,
    parameters_of,
    word,
)
from ..measured.rows import noise_from_third_differences
from ..measured.settings import SegmentName
from .adhesive_march import ADHESION, MARCH_APART, MARCH_NEAR, MARCH_SHARES, AdhesiveMarch, ElasticLimits, Secants
from .relaxation import RelaxingContact

# --------------------------------------------------------------------------------------------------
# What a device did, from its readings: straight pieces between corners.

# Limits of the search for corners.
# tuned on relaxing records, by `make constants`: corners, ends among them; of more no pieces are straight
MOTION_MOST = 9
MOTION_WORTH = 30.0  # theory: of the sum of squares over the noise's; chance gives 20 in one of 1e3 records of 1e4
MOTION_TRIED = 64  # choice: rows of a piece where a corner is begun; it is then moved
MOTION_STRAIGHT = 1.1  # choice: scatter over the noise up to which no corner is missing


def noise_of(column: Array) -> float:
    """Standard deviation of the readings of a column from row to row, not below what is the same."""
    return max(noise_from_third_differences(column), SAME * float(np.ptp(column)))


def noise_about(squares: float, left: float, column: Array) -> float:
    """That of the readings of a ``column`` by the sum of ``squares``, or its mean, of what they are off a model, of
    which so many, or such a part, are ``left`` by its unknowns."""
    return max(math.sqrt(squares / left), SAME * float(np.ptp(column)))


def check_over_time(curve: Curve, what: str) -> None:
    """Refuse a curve that holds no readings over time, ``what`` needs them."""
    if missing := [name for name in ("t", "delta", "P") if name not in curve.measured]:
        raise InputError(f"{curve.where}: {what} needs t, delta and P, it lacks {', '.join(missing)}")


def check_rising(where: str, t: Array, rows: Array) -> None:
    """Refuse times that do not rise, by the numbers of their ``rows``."""
    if (falls := np.flatnonzero(np.diff(t) <= 0)).size:
        row = int(rows[falls[0] + 1]) + 1
        raise InputError(f"{where}: time must rise from row to row, it does not in row {row}")


def corners(t: Array, x: Array, noise: float) -> tuple[Array, Array]:
    """The times and places of the corners, ends among them, of straight pieces that leave of ``x`` at rising times
    ``t`` no more than ``noise``; as many as are worth it."""
    knots, sums = [0, t.size - 1], _Sums.of(t, x)
    while len(knots) < MOTION_MOST:
        rest = x - through(t, x, t[knots])[1]
        if np.sqrt(np.mean(rest**2)) < MOTION_STRAIGHT * noise:
            break
        better = _settled(sums, sorted([*knots, _next(rest, knots)]))
        if sums.left(knots) - sums.left(better) < MOTION_WORTH * noise**2:
            break
        knots = better
    times = _between_rows(t, x, knots)
    return times, through(t, x, times)[0]


def _between_rows(t: Array, x: Array, knots: list[int]) -> Array:
    """The times of the corners; for two in rows one after the other that where the straight pieces before and behind
    them meet, if they do so between these rows: a device turns there, and goes beyond both."""
    times, places = t[knots], through(t, x, t[knots])[0]
    slopes = np.diff(places) / np.diff(times)
    for i in range(len(knots) - 3, 0, -1):
        if knots[i + 1] == knots[i] + 1 and slopes[i - 1] != slopes[i + 1]:
            ahead = (places[i + 1] - places[i] - slopes[i + 1] * (times[i + 1] - times[i])) / (
                slopes[i - 1] - slopes[i + 1]
            )
            if 0 <= ahead <= times[i + 1] - times[i]:
                times = np.concatenate([times[:i], [times[i] + ahead], times[i + 2 :]])
                places = through(t, x, times)[0]
                slopes = np.diff(places) / np.diff(times)
    return times


def through(t: Array, x: Array, knots: Array) -> tuple[Array, Array]:
    """Places at the times ``knots`` by least squares, and the straight pieces through them at all times."""
    hats = np.stack([np.interp(t, knots, row) for row in np.eye(knots.size)], axis=1)
    places = np.linalg.lstsq(hats, x, rcond=None)[0]
    return places, hats @ places


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums of 1, t, t^2, x, t x and x^2 over the rows before each, ``upto`` (rows + 1, 6), of columns about their
    means: what is left by any straight pieces follows from them."""

    t: Array
    upto: Array

    @classmethod
    def of(cls, t: Array, x: Array) -> _Sums:
        t, x = (t - t.mean()) / np.ptp(t), x - x.mean()
        rows = np.stack([np.ones_like(t), t, t**2, x, t * x, x**2], axis=1)
        return cls(t, np.concatenate([np.zeros((1, 6)), np.cumsum(rows, axis=0)]))

    def left(self, knots: list[int]) -> float:
        """The least sum of squares about straight pieces between ``knots``."""
        first, last = np.array(knots[:-1]), np.array(knots[1:])
        a, h = self.t[first], self.t[last] - self.t[first]
        last[-1] += 1
        n, t, tt, x, tx, xx = (self.upto[last] - self.upto[first]).T
        u, uu, ux = (t - n * a) / h, (tt - 2 * a * t + n * a**2) / h**2, (tx - a * x) / h  # of u = (t - a)/h
        ends, both, right = np.zeros(len(knots)), u - uu, np.zeros(len(knots))
        ends[:-1], right[:-1] = n - 2 * u + uu, x - ux
        ends[1:] += uu
        right[1:] += ux
        matrix = np.diag(ends) + np.diag(both, 1) + np.diag(both, -1)
        return float(np.sum(xx) - right @ np.linalg.solve(matrix, right))


def _next(rest: Array, knots: list[int]) -> int:
    """The row of a new corner: in the piece that leaves most, where a hat stands out most in what is left."""
    squares = [float(np.sum(rest[a : b + 1] ** 2)) if b - a > 1 else -1.0 for a, b in itertools.pairwise(knots)]
    a, b = knots[(i := int(np.argmax(squares)))], knots[i + 1]
    tops, rows = (np.unique(np.linspace(a + 1, b - 1, min(b - a - 1, MOTION_TRIED)).astype(int)), np.arange(a, b + 1))
    sums = [abs(float(np.sum(rest[a : b + 1] * np.interp(rows, [a, top, b], [0, 1, 0])))) for top in tops]
    return int(tops[int(np.argmax(sums))])


def _settled(sums: _Sums, knots: list[int]) -> list[int]:
    """The knots moved, one after the other, each to the row between its neighbours that leaves least, until none
    moves."""
    for _ in range(MOST_STEPS):
        before = list(knots)
        for i in range(1, len(knots) - 1):
            width = max((knots[i + 1] - knots[i - 1]) // 8, 1)
            while width:
                tried = [k for k in (knots[i] - width, knots[i], knots[i] + width) if knots[i - 1] < k < knots[i + 1]]
                best = min(tried, key=lambda k: sums.left([*knots[:i], k, *knots[i + 1 :]]))
                width = width if best != knots[i] else width // 2
                knots[i] = best
        if knots == before:
            break
    return knots


# --------------------------------------------------------------------------------------------------
# Which rows of a record that relaxes are fitted: means of many, and none of a retraction that adheres.

# Limits on rows.
ROWS_MOST = 1_500  # choice: rows beyond which means of as few as possible are taken
ROWS_APART = 5.0  # theory: standard deviations by which a load stands out, as that of a contact does
ROWS_FALLS = 0.2  # choice: of the largest speed, at which a device goes back
ROWS_BEFORE = 5  # choice: rows before contact that make a base line


def averaged(curve: Curve) -> Curve:
    """Means of neighbouring rows, where there are very many."""
    each = math.ceil(len(curve) / ROWS_MOST)
    if each == 1:
        return curve
    whole = slice(len(curve) // each * each)
    means = {name: getattr(curve, name)[whole].reshape(-1, each).mean(axis=1) for name in ("t", "delta", "P")}
    return replace(curve, a=None, segment=None, **means)


def without_adhesion(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The rows up to a retraction that pulls, and a flag on it, if any."""
    t, x = corners(curve.time, curve.device, noise_of(curve.device))
    slopes = np.diff(x) / np.diff(t)
    back = np.logical_and.accumulate(slopes[::-1] < -ROWS_FALLS * np.abs(slopes).max())
    begin = float(t[-1 - int(back.sum())])
    later = curve.time > begin
    pulls = float(np.min(curve.load[~later]) - np.min(curve.load[later], initial=math.inf))
    if pulls < ROWS_APART * noise_of(curve.load) or later.all():
        return curve, ()
    flag = (
        f"adhesion pulls with {show(pulls, 'load')} in the retraction: only rows up to {show(begin, 'time')} are "
        "fitted; to fit the retraction too: --free w"
    )
    return curve.rows(~later), (flag,)


def followed(t: Array, depth: Array) -> tuple[Array, Array]:
    """A motion by some of its places, that goes in up to its deepest and then out."""
    edges = np.unique(np.linspace(0, t.size, min(t.size, ROWS) + 1).astype(int))
    t, x = (np.add.reduceat(column, edges[:-1]) / np.diff(edges) for column in (t, depth))
    top = int(np.argmax(x))
    x = np.concatenate([np.maximum.accumulate(x[: top + 1]), np.minimum.accumulate(x[top:])[1:]])
    return t, x


# How the least sum of squares is sought, and when it is doubted.
FIT_ROWS = 1_000  # choice: by which corners are sought
FIT_SOME = 80  # choice: by which starts are compared
FIT_TIMES = (0.02, 0.06, 0.2, 0.6)  # choice: starts of a relaxation time, over the record's length
FIT_SHARES = (0.2, 0.6)  # choice: starts of the ratio
FIT_EXPONENTS = (0.05, 0.15, 0.4)  # choice: starts of an exponent
FIT_DEPTHS = (0.0, 0.3, 1.0)  # choice: starts of the depth at which contact shows, over ``unseen``
FIT_RISES = 0.5  # theory: exponent of the depth over the load of a cone, the least of common tips
FIT_DEEPER = 1.5  # times the depth, to which a body is solved; choice: guard of a search
FIT_SHOWN = 0.01  # choice: of the range of the load, that does too; a tilted base line does not
FIT_APART = 2.5  # theory: rows between two corners, within which no row shows when a step was
FIT_STEP = 1e-6  # theory: of the unknowns, for derivatives: the root of what the histories err by
FIT_CONVERGED = 1e-6  # theory: relative, of the sum of squares; a change of 1e-3 standard errors in 1e3 rows
FIT_MARCHED = 0.02  # choice: of the unknowns, for differences of marches, which err by a hundredth of what these change
FIT_MARCHED_SHARE = 0.005  # choice: the same of shares and of zeros, places and times over their ranges
FIT_MARCHED_END = 3e-4  # choice: of the sum of squares, a change of a third of a standard error at most in 300 rows
FIT_SPREAD = 3.0  # choice: over which jumps are spread first, so that the loads tell where they are
FIT_HELD = 0.05  # choice: of the way, within which the device is at its turn
FIT_MARCHED_FIRST = 0.1  # choice: the same in the first search, which another follows
FIT_STARTS = 3  # choice: from which a first search begins, at most
FIT_FOUND = 8.0  # choice: mean square of its residuals over the noise, which jumps that are spread leave, too
FIT_LAST = 4  # choice: marches that are not coarse, at most
FIT_EXACT = 0.1  # choice: of the noise of loads, over the ranges of both; a device less noisy did what was read
FIT_RANGES = (0.5, 2.0)  # choice: of a stress that is not known, those by which its influence is stated
FIT_COARSER = 3  # choice: steps joined in the histories of a spring or a load, 1e-4 of the loads
FIT_GROWS = 0.02  # choice: of the depth, by which a contact may grow again: corners have the noise of readings


MISFIT = "the relaxation law or the specimen does not describe the force curve"
RANGE = "the numbers leave the range of arithmetic"
AS_READ = (
    "neither instrument nor load moved at constant rates: the displacement of the tip is used as read, its noise is "
    "not in the intervals"
)
FAILURES = (JkrError, FloatingPointError, OverflowError, ValueError)  # of a history far from any record
ZEROS = {"delta0": Ranged("length"), "P0": Ranged("load"), "tilt": Ranged("stiffness")}  # added to what is read
Control: TypeAlias = Literal["displacement", "tip", "load"]  # what is imposed
WEIGHT, TIME = Ranged("number", above=0, most=1), Ranged("time", above=0)


@dataclass(frozen=True)
class RelaxationSettings:
    """A request: the ``law`` by name, of ``terms`` where it is "prony", the names of the ``zeros`` that are free, the
    ``fixed`` values, SI, the ``level`` of the intervals, and by what ``confidence`` they are computed;
    ``segment``: its rows alone; ``adhesion``: of w, stress and range, those that are free."""

    law: str
    zeros: tuple[str, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    terms: Annotated[int, Ranged("number", least=1, most=4)] = 2
    level: Level = LEVEL
    confidence: Followed = "covariance"
    segment: SegmentName | None = None
    adhesion: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        read_fields(self, "fit")

    @property
    def adheres(self) -> bool:
        """Whether w is asked for, or known."""
        return "w" in self.adhesion or "w" in self.fixed

    @property
    def ranged(self) -> bool:
        """Whether the range of adhesion is known, or asked for."""
        return bool({"stress", "range"} & {*self.adhesion, *self.fixed})

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The modulus, those of the law, and zeros."""
        known = {**dict.fromkeys(ZEROS.keys() - set(self.zeros), 0.0), **self.fixed}
        adhesion = {name: ADHESION[name] for name in ADHESION if name in self.adhesion or name in known}
        ranges = MODULUS | _of_law(self.law, self.terms) | adhesion | ZEROS
        return parameters_of(ranges, ranges.keys() - known.keys(), known)

    def relaxation(self, values: Mapping[str, float]) -> Relaxation:
        """The law with its parameters."""
        parameters: dict[str, Any] = {name: values[name] for name in _of_law(self.law, self.terms)}
        if self.law == "prony":
            own = tuple(parameters.values())
            parameters = {"weights": own[::2], "times": own[1::2]}
        law: Relaxation = RELAXATIONS[self.law](**parameters)
        return law


def _of_law(law: str, terms: int) -> dict[str, Ranged]:
    """The ranges of the parameters of a law."""
    if law == "prony":
        numbers = range(1, terms + 1)
        return {f"{name}{i}": ranged for i in numbers for name, ranged in (("weight", WEIGHT), ("time", TIME))}
    return ranges_of(RELAXATIONS[law])


def relaxation_settings(
    law: str, fix: Named = (), free: Iterable[str] = (), E_star: float = 1.0,
    ranged: RangeRequest | None = None, **options: Any,
) -> RelaxationSettings:  # fmt: skip
    """Settings from what a user types: free are the modulus, the law's parameters and delta0, but for what ``fix``
    names, and what ``free`` adds: P0, and tilt of the base line [N/m]; w, and the stress or range of adhesion, which
    is else that of the case, ``ranged``, if it has one. Of a power law, whose modulus is that at its time, the time is
    fixed, 1 s by default. ``E_star`` of the body [Pa]."""
    check_law(law, RELAXATIONS)
    asked_for = RelaxationSettings(law, (), **options)
    own = _of_law(law, asked_for.terms)
    named = Nameable("--relaxation", MODULUS | own | ADHESION | ZEROS, E_star)
    fixed = ({"time": 1.0} if law == "power" else {}) | named.known(fix)
    wanted = ["delta0", *(named.own(name) for name in free if name != "relaxation")]
    wanted = [name for name in wanted if name not in fixed]
    adhesion = tuple(name for name in ADHESION if name in wanted)
    zeros = tuple(name for name in wanted if name in ZEROS)
    asked = [name for name in ADHESION if name in adhesion or name in fixed]
    if asked and "w" not in asked:
        raise InputError(f"fit: {asked[0]}: of a relaxing body it goes with w: give --free w, or leave it out")
    if asked and law == "power":
        raise InputError("fit: a power law has no instantaneous modulus, which governs jumps of the contact: with w "
                         "give --relaxation sls or prony")  # fmt: skip
    if {"stress", "range"} <= set(asked):
        raise InputError("fit: stress and range are one parameter with w: give one of them")
    if asked == ["w"] and ranged:
        fixed |= {"range": ranged.length} if ranged.stress is None else {"stress": ranged.stress}  # type: ignore[dict-item]
    return replace(asked_for, zeros=zeros, fixed=fixed, adhesion=adhesion)


@dataclass(frozen=True, eq=False)
class TimedRecord:
    """Readings over time: ``t`` [s], what was ``imposed`` by ``control`` (the position of the device or of its "tip"
    [m], or the load [N]) and the ``response`` (the load, or the displacement); standard deviations of both from row to
    row, ``noise``, and those by which they are weighed, ``sigma``: of the imposed, and of what is left of the response
    less ``shared`` times the noise of the imposed (per row). ``read``: nothing moved in straight pieces; then the
    displacement of the tip is imposed, as it was read. ``flags``: how rows were chosen; ``left_out``: mask of rows
    of which it is not known on which side of a jump of the contact they lie; ``jumps``: times of these jumps and their
    standard deviations [s] (m, 2)."""

    curve: Curve
    t: Array
    imposed: Array
    response: Array
    control: Control
    stiffness: float
    knots: tuple[Array, Array]
    noise: tuple[float, float]
    sigma: tuple[float, float | Array]
    shared: float = 0.0
    read: bool = False
    flags: tuple[str, ...] = ()
    left_out: Array | None = None
    jumps: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def loaded(self) -> bool:
        return self.control == "load"

    @cached_property
    def _load(self) -> tuple[Array, float, float]:
        """The load, by how much it stands out where contact shows, and its largest [N]."""
        load, noise = (self.imposed, self.noise[0]) if self.loaded else (self.response, self.noise[1])
        load = load - np.median(load[:3])
        return load, max(ROWS_APART * noise, FIT_SHOWN * float(np.ptp(load))), float(load.max())

    @cached_property
    def shows(self) -> int:
        """The first row whose load shows contact."""
        load, least, _ = self._load
        return int(np.argmax(load > least))

    @property
    def unseen(self) -> float:
        """How deep the tip may be before the load shows it [m]."""
        load, _, most = self._load
        share = min(max(float(load[self.shows]) / most, 0.0), 1 - FIT_SHOWN) ** FIT_RISES
        return self._shown * share / (1 - share)

    @property
    def _shown(self) -> float:
        """How much deeper it goes from there on [m]."""
        depth = self.response if self.loaded else self.imposed
        return float(depth[self.shows :].max() - depth[self.shows])

    @property
    def depth(self) -> float:
        """How deep the tip may go [m]."""
        return self._shown + self.unseen

    @property
    def by_tip(self) -> TimedRecord:
        """The record by the displacement of its tip as it was read, where a spring is between: quickly followed."""
        if not 0 < self.stiffness < math.inf or self.curve.delta is None:
            return self
        knots = followed(self.t, self.curve.delta)
        return replace(self, imposed=self.curve.delta, stiffness=math.inf, read=True, knots=knots)

    def thinned(self) -> TimedRecord:
        """The record by a few of its rows."""
        some = evenly(self.t.size, FIT_SOME)
        return replace(self, t=self.t[some], imposed=self.imposed[some], response=self.response[some])

    @cached_property
    def spacing(self) -> float:
        """The time from row to row [s]."""
        return float(np.median(np.diff(self.t)))

    def weighed(self, off: tuple[Array, Array]) -> tuple[Array, Array]:
        """What readings are ``off`` a model, imposed and response, in standard deviations, independent of each
        other."""
        alone = (off[1] - self.shared * off[0]) / self.sigma[1]
        return off[0] / self.sigma[0], alone if self.left_out is None else np.where(self.left_out, 0.0, alone)

    def with_jumps(self, jumps: Array, model: Array) -> TimedRecord:
        """The record with the times of its own jumps near those [s] of a ``model`` of the response.

        Each jump lies between two rows; that it is those behind row k has the probability

            p_k ~ exp(-sum_(j <= k) (y_j - y_before(t_j))^2/2 sigma^2 - sum_(j > k) (y_j - y_after(t_j))^2/2 sigma^2),

        where the model's branches before and after are drawn straight on. Within a pair of rows the time is even.
        """
        t, y, h = self.t, self.response, self.spacing
        found, left_out = [], np.zeros(t.size, dtype=bool)
        for jump in jumps.tolist():
            first, last = np.searchsorted(t, jump - h) - 1, np.searchsorted(t, jump + h, "right")
            near = np.flatnonzero(np.abs(t - jump) < MARCH_NEAR * h)
            if first < 1 or last > t.size - 2:
                continue
            # The branches of the model, drawn straight on from the last row before and the first behind its jump
            back, on = ((t[near] - t[i]) / (t[i] - t[j]) for i, j in ((first, first - 1), (last, last + 1)))
            before = np.where(near <= first, model[near], model[first] + (model[first] - model[first - 1]) * back)
            after = np.where(near >= last, model[near], model[last] + (model[last] - model[last + 1]) * on)
            off = [(y[near] - side) ** 2 / (2 * self.noise[1] ** 2) for side in (before, after)]
            cost = np.cumsum(off[0])[:-1] + np.sum(off[1]) - np.cumsum(off[1])[:-1]
            p = np.exp(cost.min() - cost)
            p /= p.sum()
            middle = (t[near[1:]] + t[near[:-1]]) / 2
            mean = float(p @ middle)
            spread = math.sqrt(float(p @ ((middle - mean) ** 2 + np.diff(t[near]) ** 2 / 12)))
            found.append((mean, spread))
            left_out |= np.abs(t - mean) < MARCH_APART * h + 2 * spread
        return replace(self, left_out=left_out, jumps=np.array(found).reshape(-1, 2))


@dataclass(frozen=True, eq=False, kw_only=True)
class RelaxationFit(Answer):
    """A fitted ``record``: the parameters and E* (instant, of a power law at its time; ``covariance``: of logs but for
    zeros and shares), the model of what was ``imposed`` and of the ``response``, the ``scatter`` of the residuals over
    the noise from row to row."""

    relaxation: Relaxation
    record: TimedRecord
    imposed: Array
    response: Array
    scatter: float
    settings: RelaxationSettings

    @property
    def doubts(self) -> list[str]:
        """Why it is not to be believed as it stands, in a few words each."""
        own = [self.estimate(name) for name in ("E_star", *self.free) if name != "modulus" and name not in ZEROS]
        lost = [word(item.name) for item in own if item.error is None or item.low is item.high is None]
        doubts = [f"{', '.join(lost)} not determined"] if lost else []
        doubts += self.vague([item.name for item in own if word(item.name) not in lost])
        return doubts + ([MISFIT] if self.scatter > SEARCH_MISFIT else [])


def timed_record(curve: Curve, adheres: bool = False) -> TimedRecord:
    """The readings of ``curve`` over time, of a retraction that ``adheres`` too; InputError where a column is
    missing."""
    check_over_time(curve, "a fit of relaxation")
    if len(curve) < FEWEST_ROWS:
        raise InputError(f"{curve.where}: {len(curve)} rows, at least {FEWEST_ROWS} are needed")
    check_rising(curve.where, curve.time, np.arange(len(curve)))
    curve, flags = averaged(curve), tuple[str, ...]()
    if not adheres:
        curve, flags = without_adhesion(curve)
    t, load = curve.time, curve.load
    moved = _straight(curve)
    if moved is not None and moved[0] == "load" and np.ptp(moved[1][1]) < ROWS_APART * noise_of(load):
        raise InputError(
            f"{curve.where}: no contact shows: the load stays within its noise, {show(noise_of(load), 'load')}"
        )
    control: Control
    if moved is None:
        control, knots, stiffness = "displacement", followed(t, curve.depth), math.inf
        imposed, response = curve.depth, load
        flags += (AS_READ,)
    else:
        control, knots = moved
        imposed, response = (load, curve.device) if control == "load" else (_motions(curve)[control], load)
        stiffness = 0.0 if control == "load" else _lever(curve) if control == "displacement" else math.inf
    of_rows, shared = (noise_of(imposed), noise_of(response)), 0.0
    if moved is not None and math.isfinite(_lever(curve)):  # where the load is a lever's, tip or device share its noise
        both = [
            noise_from_third_differences(imposed / of_rows[0] + sign * response / of_rows[1]) ** 2 for sign in (1, -1)
        ]
        shared = (both[0] - both[1]) / 4 * of_rows[1] / of_rows[0]
    alone = max(of_rows[1] ** 2 - (shared * of_rows[0]) ** 2, (SAME * float(np.ptp(response))) ** 2)
    sigma = of_rows[0], math.sqrt(alone)
    return TimedRecord(
        curve, t, imposed, response, control, stiffness, knots, of_rows, sigma, shared, moved is None, flags
    )


def _lever(curve: Curve) -> float:
    """The stiffness of the device [N/m], infinite where none is between."""
    return math.inf if curve.stiffness is None else float(curve.stiffness)


def _motions(curve: Curve) -> dict[Control, Array]:
    """What may have moved in straight pieces of a displacement: the device, and its tip where a lever is between."""
    motions: dict[Control, Array] = {"displacement": curve.device}
    return motions if math.isinf(_lever(curve)) else motions | {"tip": curve.depth}


def _straight(curve: Curve) -> tuple[Control, tuple[Array, Array]] | None:
    """What moved in the fewest straight pieces, and their corners; None: nothing did. Of device and tip with as many,
    that which is nearer to its pieces: the noise of a lever's load is in the other; the load where neither has as
    few."""
    t, some = curve.time, evenly(len(curve), FIT_ROWS)
    found: dict[Control, tuple[Array, Array]] = {}
    ranks: dict[Control, tuple[int, float]] = {}
    for name, column in {**_motions(curve), "load": curve.load}.items():
        found[name] = corners(t[some], column[some], noise_of(column))
        off = float(np.std(column[some] - np.interp(t[some], *found[name])))
        ranks[name] = found[name][0].size, math.inf if name == "load" else off
    best = min(ranks, key=lambda name: ranks[name])
    return None if ranks[best][0] >= MOTION_MOST else (best, found[best])


def relaxation_fit(body: FittedBody, curve: Curve, settings: RelaxationSettings) -> RelaxationFit:
    """The parameters that bring the history of ``body`` nearest to the record ``curve``; InputError where it does not
    allow it, SolveError where no history is found; both name the curve."""
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            part = curve if settings.segment in (None, "both") else curve.only(settings.segment)
            return _fit(body, part, settings)
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}") from None
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise SolveError(f"{curve.where}: {RANGE} ({error}); are all sizes and units right?") from error


def _fit(body: FittedBody, curve: Curve, settings: RelaxationSettings) -> RelaxationFit:
    if body.problem.indenter.material is not None or body.problem.sticks:
        raise InputError("fit: --relaxation needs a rigid indenter and frictionless contact")
    record = timed_record(curve, settings.adheres)
    settings = _with_base_line(record, settings)
    if settings.adheres:
        return _fit_adhering(body, record, settings)
    body = body.to_depth(FIT_DEEPER * record.depth)
    problem = _Problem(body.nonadhesive, record, settings)
    least = problem.minimise(problem.start())
    problem = replace(problem, record=problem.reweighed(least))
    fit = problem.result(problem.minimise(least.x), body.problem.E_star)
    return replace(fit, warnings=(*fit.warnings, *_fewer(body, fit)))


def _fit_adhering(body: FittedBody, record: TimedRecord, settings: RelaxationSettings) -> RelaxationFit:
    """The fit of a record with its retraction, w among the unknowns, from the best of the elastic limits on."""
    if record.loaded:
        raise InputError(
            f"{record.curve.where}: w: adhesive cycles are fitted under a prescribed displacement, here the load is "
            "prescribed: leave w out"
        )
    # What is seen: where contact shows, its pull-off force, the reversal.
    load, tip, noise = record.response, record.imposed, record.noise[1]
    base, seen = _contact_seen(load, noise)
    load = load - base
    if -load.min() < ROWS_APART * noise:
        raise InputError(f"{record.curve.where}: w: no adhesion shows, no load lies below that before contact; leave w "
                         "out")  # fmt: skip
    if 0 < record.stiffness < math.inf:
        tip = tip - load / record.stiffness
    times, places = record.knots
    top = int(np.argmax(places > places.max() - FIT_HELD * np.ptp(places)))
    turn = float(times[top])
    shows = float(tip[seen])
    depth = float(tip.max()) - shows
    body = body.to_depth(FIT_DEEPER * depth)

    # Where to begin, and the stress of a zone a part of the contact wide where no range is known.
    fixed, known = settings.fixed, settings.ranged
    march = AdhesiveMarch.of(body, 2 * float(np.median(np.diff(record.t))))

    def ranged(w: float) -> float:
        return fixed.get("range", w / fixed["stress"] if "stress" in fixed else 0.0)

    found = ElasticLimits(body.nonadhesive).starts(record.t, tip, load, turn, shows, ranged)
    radius = float(np.interp(depth, body.series.delta, body.series.a))
    middle = found[len(MARCH_SHARES) // 2]  # between very fast and from rest
    stress = march.stress(middle["w"], middle["modulus"] * body.problem.E_star, radius)
    settings = settings if known else replace(settings, fixed={**fixed, "stress": stress})
    more = {"stress": stress, "P0": base, "tilt": 0.0}
    starts = [{**more, "range": one["w"] / stress, **_of_start(settings, one), **settings.fixed} for one in found]

    # Coarse marches, what the device did as it was read, the zero where contact shows; then all unknowns, on rows away
    # from jumps; then with the noise that is left and marches that are not coarse.
    tied = settings if "delta0" in settings.fixed else replace(settings, fixed={**settings.fixed, "delta0": 0.0})
    first = _Problem(body.nonadhesive, record, tied, replace(march, over=FIT_SPREAD * march.over), True,
                     None if "delta0" in settings.fixed else shows)  # fmt: skip
    least = None
    for theta in sorted(map(first.unknowns.at, starts), key=first.cost)[:FIT_STARTS]:
        there = first.minimise(theta, FIT_MARCHED_FIRST)
        least = there if least is None or there.cost < least.cost else least
        if least.cost < FIT_FOUND * record.t.size / 2:
            break
    assert least is not None
    exact = np.ptp(record.response) * record.noise[0] < FIT_EXACT * np.ptp(record.imposed) * record.noise[1]
    whole = _Problem(body.nonadhesive, record, settings, march, bool(exact))
    theta = whole.extended(whole.unknowns.at(first.zeroed(first.unknowns.values(least.x))))
    whole = whole.with_jumps(theta)
    least = whole.minimise(theta, FIT_MARCHED_END)
    whole = whole.with_jumps(least.x)
    whole = replace(whole, record=whole.reweighed(least), march=march.full())
    least = whole.minimise(least.x, FIT_MARCHED_END, FIT_LAST)
    fit = whole.result(least, body.problem.E_star)
    return fit if known else whole.ranged(fit, least)


def _contact_seen(load: Array, noise: float) -> tuple[float, int]:
    """The level of the ``load`` before contact, and the first row that stands out from it, by attraction or contact."""
    base = float(np.median(load[:ROWS_BEFORE]))
    return base, int(np.argmax(np.abs(load - base) > ROWS_APART * noise))


def _fewer(body: FittedBody, fit: RelaxationFit) -> Iterator[str]:
    """A warning where a term less of a Prony series does as well, by the information criterion of Bayes."""
    terms, rows = fit.settings.terms - 1, fit.record.t.size
    if fit.settings.law != "prony" or terms == 0:
        return
    fewer = relaxation_fit(body, fit.record.curve, replace(fit.settings, terms=terms))
    scores = [rows * math.log(np.sum((one.response - one.record.response) ** 2)) for one in (fit, fewer)]
    rise = scores[0] - scores[1] + (len(fit.free) - len(fewer.free)) * math.log(rows)
    if rise >= 0:
        yield f"{terms} terms fit as well as {terms + 1} (BIC better by {rise:.2g}): take --terms {terms}"


def _of_start(settings: RelaxationSettings, start: Mapping[str, float]) -> dict[str, float]:
    """The values of a ``start`` with the law's parameters."""
    if settings.law != "prony":
        return dict(start)
    n = settings.terms
    weights = {f"weight{i + 1}": (1 - start["ratio"]) / n for i in range(n)}
    return dict(start) | weights | {f"time{i + 1}": start["time"] * 8.0 ** (i - (n - 1) / 2) for i in range(n)}


def _with_base_line(record: TimedRecord, settings: RelaxationSettings) -> RelaxationSettings:
    """Free too, unless fixed, is what the loads before contact show of their base line."""
    if record.loaded:
        return settings
    shows = record.shows
    if settings.adheres:
        shows = _contact_seen(record.response, record.noise[1])[1]
    before, limit = slice(0, shows // 2), ROWS_APART * record.noise[1]  # contact begins before it shows
    P, x, shown = record.response[before], record.imposed[before], list[str]()
    if P.size >= ROWS_BEFORE:
        about = x - x.mean()
        tilt = float(about @ P) / math.sqrt(max(float(about @ about), TINY))
        shown += ["P0"] * (abs(float(P.mean())) > limit / math.sqrt(P.size)) + ["tilt"] * (abs(tilt) > limit)
    return replace(settings, zeros=(*settings.zeros, *shown))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Residuals as a function of the unknowns: the free parameters, then places and times of the corners. ``march``:
    the model with adhesion, None without; ``pinned``: whether the corners stay where they were read; ``shows``: place
    [m] at which the surfaces come within the range, to which the zero is tied; ``secants``: derivatives of marches."""

    body: Nonadhesive
    record: TimedRecord
    settings: RelaxationSettings
    march: AdhesiveMarch | None = None
    pinned: bool = False
    shows: float | None = None
    secants: Secants = field(default_factory=Secants)

    @property
    def still(self) -> bool:
        """Whether what was imposed is known as it was read."""
        return self.pinned or self.record.read

    # ------------------------------------------------------------------ unknowns
    @cached_property
    def unknowns(self) -> Unknowns:
        """Of the body and its zeros, which count in ranges of their columns."""
        curve = self.record.curve
        x, P = float(np.ptp(curve.device)), float(np.ptp(curve.load))
        return Unknowns(self.settings.parameters, {"delta0": x, "P0": P, "tilt": P / x})

    @cached_property
    def moving(self) -> Array:
        """Which corners may move in time: not the ends, and not those of a step between two rows."""
        if self.still:
            return np.array([], dtype=int)
        gaps = np.diff(self.record.knots[0]) > FIT_APART * float(np.median(np.diff(self.record.curve.time)))
        return np.flatnonzero(np.concatenate([[False], gaps[:-1] & gaps[1:], [False]]))

    def program(self, theta: Array) -> Program:
        """What the device did, as it was read."""
        n, (t, x) = len(self.unknowns.free), self.record.knots
        if self.still:
            return Program(t, x)
        t = t.copy()
        t[self.moving] += theta[n + x.size :] * (t[-1] - t[0])
        return Program(t, theta[n : n + x.size] * float(np.ptp(x)))

    # ------------------------------------------------------------------ the model
    def model(self, theta: Array) -> tuple[Array, Array]:
        """What is imposed and the response, at the rows, as readings."""
        return self._readings(theta)[:2]

    def zeroed(self, values: dict[str, float]) -> dict[str, float]:
        """The ``values`` with the zero that is tied."""
        if self.shows is None:
            return values
        return values | {"delta0": self.shows + values.get("range", values["w"] / values.get("stress", math.inf))}

    def columns(self, theta: Array) -> Array:
        """The same one after the other, in units of the noise from row to row; SolveError where there is no such
        history."""
        record = self.record
        try:
            *both, _, jumps = self._readings(theta)
        except FAILURES as error:
            raise SolveError(f"no history of this specimen resembles the data ({error})") from None
        columns = [one / unit for one, unit in zip(both, record.noise, strict=True)]
        if record.jumps.size:
            if not jumps.size:
                raise SolveError("no history of this specimen resembles the data (the contact does not jump)")
            nearest = np.argmin(np.abs(jumps - record.jumps[:, :1]), axis=1)
            columns.append(jumps[nearest] / record.spacing)
        return np.concatenate(columns)

    def with_jumps(self, theta: Array) -> _Problem:
        """The same with the times of the record's own jumps near those of the model."""
        _, response, _, jumps = self._readings(theta)
        return replace(self, record=self.record.with_jumps(jumps, response))

    def _readings(self, theta: Array) -> tuple[Array, Array, Array, Array]:
        """The same, which rows are in contact, and the times of jumps."""
        values, record, program = self.zeroed(self.unknowns.values(theta)), self.record, self.program(theta)
        zero, other = ("P0", "delta0") if record.loaded else ("delta0", "P0")
        imposed = np.interp(record.t, program.t, program.x)
        x, modulus = program.x - values[zero], values["modulus"]
        law, stiffness = self.settings.relaxation(values), record.stiffness / modulus  # loads over the modulus
        program = Program(program.t, x / modulus if record.loaded else x)
        if self.march is None:
            (a, delta, P), jumps = self._contact(law, stiffness).history(program).states(record.t), np.empty(0)
        else:
            a, delta, P, jumps = self.march.states(law, values, stiffness, program, record.t)
        response = delta if record.loaded else modulus * P
        return imposed, response + values[other] + values["tilt"] * (imposed - imposed[0]), a > 0, jumps

    def _contact(self, law: Relaxation, stiffness: float) -> RelaxingContact:
        coarser = 1 if math.isinf(stiffness) else FIT_COARSER
        return RelaxingContact(self.body, law, stiffness, coarser, FIT_GROWS)

    def residuals(self, theta: Array) -> Array:
        """In standard deviations; as large as the readings where there is no such history."""
        record = self.record
        try:
            imposed, response = self.model(theta)
        except FAILURES:
            imposed, response = record.imposed + np.ptp(record.imposed), record.response + np.ptp(record.response)
        return self.weighed(np.concatenate([imposed - record.imposed, response - record.response]))

    def weighed(self, off: Array) -> Array:
        """What both readings, one after the other, and times of jumps are ``off`` in standard deviations."""
        n = self.record.t.size
        first, rest = self.record.weighed((off[:n], off[n : 2 * n]))
        return np.concatenate([*([] if self.still else [first]), rest, off[2 * n :] / self.record.jumps[:, 1]])

    def reweighed(self, least: Least) -> TimedRecord:
        """The record with standard deviations as the readings scatter about the model: of the response those of the
        rows in contact, whose noise is another than that of a free lever, and of all others apart."""
        record, n = self.record, self.record.t.size
        imposed, response, touches, _ = self._readings(least.x)
        off = imposed - record.imposed, response - record.response
        left = 1 - np.sum(np.linalg.qr(least.state.jacobian)[0] ** 2, axis=1)  # of each square, by its leverage
        left = left[: n if self.still else 2 * n]  # without those of jumps
        shared = record.shared if record.shared == 0 else float(off[0] @ off[1]) / max(float(off[0] @ off[0]), TINY)
        first = record.sigma[0]
        if not self.still:
            first = noise_about(float(off[0] @ off[0]), float(left[:n].sum()), record.imposed)
        alone, second = off[1] - shared * off[0], np.empty(n)
        used = np.full(n, True) if record.left_out is None else ~record.left_out
        parts = [touches & used, ~touches & used]
        if min(int(part.sum()) for part in parts) < FEWEST_ROWS:
            parts = [used]
        second[:] = record.sigma[1]
        for part in parts:
            squares = float(alone[part] @ alone[part])
            second[part] = noise_about(squares, float(left[-n:][part].sum()), record.response)
        return replace(record, sigma=(first, second), shared=shared)

    def minimise(self, start: Array, cost: float = 0.0, evaluations: int | None = None) -> Least:
        """The least sum of squares from ``start`` on: logs stay near it, shares within 0 and 1, corners between their
        neighbours."""
        low, high = self.unknowns.bounds(start, SEARCH_REACH)
        t, k = self.record.knots[0] / np.ptp(self.record.knots[0]), self.moving
        first = start.size - k.size
        low[first:], high[first:] = (t[k - 1] - t[k]) / 2, (t[k + 1] - t[k]) / 2
        return LeastSquares(self.state, (low, high), FIT_CONVERGED, cost, evaluations).least(start)

    def cost(self, theta: Array) -> float:
        """The sum of squares; infinite where there is no history."""
        with contextlib.suppress(SolveError):
            return float(np.sum(self.state(theta).residuals ** 2))
        return math.inf

    def state(self, theta: Array) -> State:
        """The residuals in standard deviations with their derivatives; of marches by secants."""
        if self.march is None:
            return by_differences(self.residuals, theta, self.steps(theta))
        record, here = self.record, self.columns(theta)
        units = np.concatenate([np.repeat(record.noise, record.t.size), np.full(len(record.jumps), record.spacing)])

        def rates() -> Array:
            J = self.secants.rates(self.columns, theta, here, self.steps(theta), len(self.unknowns.free))
            return np.stack([self.weighed(units * column) for column in J.T], axis=1)

        readings = np.concatenate([record.imposed, record.response, record.jumps[:, 0]])
        return State(self.weighed(units * here - readings), rates)

    def steps(self, theta: Array) -> Array:
        """Of the unknowns, for differences: of histories, or of marches, whose logs, and shares of 1 or of ranges, take
        others; of shares towards the middle."""
        log, other, least = FIT_STEP, FIT_STEP, FIT_STEP
        if self.march is not None:
            log, other, least = FIT_MARCHED, FIT_MARCHED_SHARE, FIT_SHARES[-1]
        steps = np.full(theta.size, other)
        for i, parameter in enumerate(self.unknowns.free):
            if parameter.kind == "log":
                steps[i] = log
            elif parameter.high < 1 and theta[i] > least:
                steps[i] = -other
        return steps

    def extended(self, own: Array) -> Array:
        """All unknowns from those of the parameters."""
        if self.still:
            return own
        places = self.record.knots[1] / np.ptp(self.record.knots[1])
        return np.concatenate([own, places, np.zeros(self.moving.size)])

    def ranged(self, fit: RelaxationFit, least: Least) -> RelaxationFit:
        """The ``fit`` with the influence of a cohesive stress that is not known, by one step of Gauss and Newton from
        half and twice of it, as the model's part of errors."""
        stress, moves = self.settings.fixed["stress"], []
        for factor in FIT_RANGES:
            fixed = {**self.settings.fixed, "stress": factor * stress}
            other = replace(self, settings=replace(self.settings, fixed=fixed)).state(least.x)
            off = other.residuals - least.state.residuals
            moves.append(np.linalg.lstsq(least.state.jacobian, -off, rcond=None)[0])
        parts = dict(zip(fit.free, np.max(np.abs(moves), axis=0).tolist(), strict=False))
        logs = {one.name for one in self.unknowns.free if one.kind == "log"}
        parts[ALIAS] = parts.get("modulus", 0.0)
        estimates = []
        for item in fit.estimates:
            unit = item.value if item.name == ALIAS or item.name in logs else self.unknowns.units.get(item.name, 1.0)
            moved = parts.get(item.name)
            estimates.append(item.with_model("range", moved * unit) if moved else item)
        warning = (
            f"the cohesive stress is not known, {show(stress, 'modulus')} is taken: half or twice of it changes w by "
            f"{parts.get('w', 0.0):.0%}; give --fix stress or range, or --free stress"
        )
        return replace(fit, estimates=tuple(estimates), warnings=(*fit.warnings, warning))

    # ------------------------------------------------------------------ where to begin
    def start(self) -> Array:
        """The best of some values, the modulus by the loads in proportion."""
        tip, candidates, reason = replace(self, record=self.record.by_tip), [], ""
        thin = replace(tip, record=tip.record.thinned())
        for values in tip._tried():  # of all rows: a quick press may lie between a few
            try:
                theta = thin._from_loads(values)
            except FAILURES as error:
                reason = f" ({error})"
                continue
            candidates.append((thin.cost(theta), theta[: len(self.unknowns.free)]))
        if not candidates:
            raise InputError(
                f"{self.record.curve.where}: no history of this specimen resembles the force curve{reason}: it must "
                "approach, hold and retract once; check the units and the tip's radius, or fix delta0"
            )
        return self.extended(min(candidates, key=lambda item: item[0])[1])

    def _tried(self) -> list[dict[str, float]]:
        """Values of the parameters to begin with, those that are fixed among them."""
        duration, fixed = float(np.ptp(self.record.t)), self.unknowns.fixed
        n, times = self.settings.terms, [time * duration for time in FIT_TIMES]
        if self.settings.law == "power":
            laws = [{"exponent": x} for x in FIT_EXPONENTS]
        elif self.settings.law == "prony":
            spans = {f"time{i + 1}": 8.0 ** (i - (n - 1)) for i in range(n)}
            weights = {f"weight{i + 1}": 0.6 / n for i in range(n)}
            laws = [{name: time * span for name, span in spans.items()} | weights for time in times]
        else:
            laws = [{"ratio": r, "time": time} for r in FIT_SHARES for time in times]
        own = {parameter.name: 1.0 for parameter in self.settings.parameters if parameter.name not in ZEROS}
        record = self.record
        base, places = float(np.median(record.response[:3])), [-share * record.unseen for share in FIT_DEPTHS]
        begins = [float(record.imposed[record.shows]) + place for place in places]  # where contact may
        if record.loaded:
            base, begins = 0.0, [float(record.response[max(record.shows - 1, 0)])]
        zeros = [{"delta0": zero, "P0": base, "tilt": 0.0} for zero in begins]
        return [own | law | zero | fixed for law in laws for zero in zeros]

    def _from_loads(self, values: Mapping[str, float]) -> Array:
        """The same with the modulus that brings the loads nearest; of a load, the depth where it is largest."""
        theta, record = self.extended(self.unknowns.at(values)), self.record
        if "modulus" in self.unknowns.fixed:
            return theta
        if record.loaded:  # with which the largest load would make the depth that was read then
            law, row = self.settings.relaxation(values), int(np.argmax(record.imposed))
            depths, lasting = self._contact(law, math.inf).depths, float(np.ptp(record.t))
            depth = min(max(float(record.response[row]) - values["delta0"], depths.most * SAME), depths.most)
            left = float(law.modes(lasting)(max(record.t[row] - record.t[0], SAME * lasting)))
            modulus = float(record.imposed[row]) / (float(depths.loads(np.array([depth]))[0]) * left)
        else:
            response, rest = self.model(theta)[1] - values["P0"], record.response - values["P0"]
            modulus = max(float(np.sum(response * rest) / np.sum(response**2)), 1e-12)
        theta[self.unknowns.names.index("modulus")] = math.log(modulus)
        return theta

    # ------------------------------------------------------------------ the answer
    def result(self, least: Least, E_star: float) -> RelaxationFit:
        settings, record, unknowns = self.settings, self.record, self.unknowns
        intervals = Intervals.of(unknowns, least, settings.level, settings.confidence, E_star, 1.0)
        imposed, response = self.model(least.x)
        off = (response - record.response) / record.noise[1]
        off = off if record.left_out is None else off[~record.left_out]
        fit = RelaxationFit(
            estimates=intervals.estimates(), free=unknowns.names, dof=least.dof,
            covariance=unknowns.covariance(intervals.covariance),
            relaxation=settings.relaxation(unknowns.values(least.x)), record=record,
            imposed=imposed, response=response, settings=settings,
            scatter=math.sqrt(float(off @ off) / max(off.size - len(unknowns.free), 1)),
        )  # fmt: skip
        return replace(fit, warnings=tuple(_warnings(fit, self.program(least.x))))


def _warnings(fit: RelaxationFit, program: Program) -> list[str]:
    """Warnings, each with its number."""
    lines = list(fit.record.flags)
    if fit.covariance is None:
        lines.append(
            f"the force curve does not determine {', '.join(fit.free)} together: fix one of them, such as delta0"
        )
    lines += fit.vague([name for name in fit.free if name not in ZEROS])
    times = [item.value for item in fit.estimates if item.name.startswith("time")]
    rises = np.diff(program.t)[np.diff(program.x) > 0]
    if fit.settings.law != "power" and rises.size and rises[0] > min(times):
        lines.append(
            f"the first rise lasts {show(float(rises[0]), 'time')}, {float(rises[0]) / min(times):.2g} times the "
            "shortest relaxation time: the instantaneous modulus is extrapolated; press faster"
        )
    if fit.scatter > SEARCH_MISFIT:
        lines.append(
            f"residuals are {fit.scatter:.2g} times the scatter from row to row: {MISFIT}; intervals are too narrow"
        )
    return lines

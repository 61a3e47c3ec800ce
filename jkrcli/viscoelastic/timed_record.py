"""Readings over time, as fits of relaxation take them: what a device did, which rows count, and what is asked of them.

What moved in straight pieces between corners, the device, its tip, or the load, is fitted with the rest. So its noise
has its part in the intervals. Where a lever is between, the readings of tip and load share noise: they are weighed by
their covariance.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from ..adhesion.finite_range import RangeRequest
from ..base.arguments import ranges_of, read_fields
from ..base.errors import LEVEL, InputError
from ..base.numerics import FEWEST_ROWS, MOST_STEPS, ROWS, SAME, TINY, Array, evenly
from ..base.units import Named, Ranged, show
from ..bodies.problem import RELAXATIONS, Relaxation
from ..measured.choices import SegmentName, Values
from ..measured.curve import Curve
from ..measured.least_squares import SEARCH_MISFIT, Followed, t_quantile
from ..measured.parameters import MODULUS, Answer, Level, Nameable, Parameter, Unknowns, check_law, parameters_of, word
from ..measured.rows import noise_from_third_differences
from .rate import RATE_ENDS, rate_parameters

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


def corners(t: Array, x: Array, noise: float, most: int = MOTION_MOST) -> tuple[Array, Array]:
    """The times and places of the corners, ends among them, of straight pieces that leave of ``x`` at rising times
    ``t`` no more than ``noise``; as many as are worth it, ``most`` at most."""
    knots, sums = [0, t.size - 1], _Sums.of(t, x)
    while len(knots) < most:
        rest = x - through(t, x, t[knots])[1]
        if np.sqrt(np.mean(rest**2)) < MOTION_STRAIGHT * noise:
            break
        # A new corner in the piece that leaves most, where a hat stands out most in what is left
        left = [float(np.sum(rest[a : b + 1] ** 2)) if b - a > 1 else -1.0 for a, b in itertools.pairwise(knots)]
        a, b = knots[(i := int(np.argmax(left)))], knots[i + 1]
        tops, rows = np.unique(np.linspace(a + 1, b - 1, min(b - a - 1, MOTION_TRIED)).astype(int)), np.arange(a, b + 1)
        hats = [abs(float(np.sum(rest[a : b + 1] * np.interp(rows, [a, top, b], [0, 1, 0])))) for top in tops]
        better = _settled(sums, sorted([*knots, int(tops[int(np.argmax(hats))])]))
        if sums.left(knots) - sums.left(better) < MOTION_WORTH * noise**2:
            break
        knots = better
    # Two corners in rows one after the other are one where the straight pieces before and behind them meet, if they
    # do so between these rows: a device turns there, and goes beyond both
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
    return times, through(t, x, times)[0]


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


FIT_ROWS = 1_000  # choice: by which corners are sought
FIT_SOME = 80  # choice: by which starts are compared
FIT_RISES = 0.5  # theory: exponent of the depth over the load of a cone, the least of common tips
FIT_SHOWN = 0.01  # choice: of the range of the load, that does too; a tilted base line does not


MODULUS_STEP = 1e-5  # theory: of unknowns, for derivatives in closed form

UNSETTLED = "the search did not converge"
MISFIT = "the relaxation law or the specimen does not describe the force curve"
BESIDE = "the power-law fit may be a local minimum: compare with --relaxation prony"
LONG_RANGE = "attraction without contact is left out: E* and w may err by more than stated"
AS_READ = (
    "neither instrument nor load moved at constant rates: the displacement of the tip is used as read, its noise is "
    "not in the intervals"
)
ADHESION = {"w": Ranged("work", above=0), "stress": Ranged("modulus", above=0), "range": Ranged("length", above=0)}
ZEROS = {"delta0": Ranged("length"), "P0": Ranged("load"), "tilt": Ranged("stiffness")}  # added to what is read
Control: TypeAlias = Literal["displacement", "tip", "load"]  # what is imposed
WEIGHT, TIME = Ranged("number", above=0, most=1), Ranged("time", above=0)


@dataclass(frozen=True)
class RelaxationSettings:
    """A request: the ``law`` by name, of ``terms`` where it is "prony", the names of the ``zeros`` that are free, the
    ``fixed`` values, SI, the ``level`` of the intervals, and by what ``confidence`` they are computed;
    ``segment``: its rows alone; ``adhesion``: of w, stress and range, those that are free; ``most``: mean square
    residual, in units of the noise, above which a rough fit is abandoned; then valleys are not followed; ``rate``: the
    law of w over the speed of the edge by name, None: w is the same at all speeds; ``own``: what each of several
    records has for itself."""

    law: str
    zeros: tuple[str, ...]
    fixed: Values = field(default_factory=dict)
    terms: Annotated[int, Ranged("number", least=1, most=4)] = 2
    level: Level = LEVEL
    confidence: Followed = "covariance"
    segment: SegmentName | None = None
    adhesion: tuple[str, ...] = ()
    most: float | None = None
    rate: str | None = None
    own: tuple[str, ...] = ("delta0", "P0", "tilt")

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
        ranges = MODULUS | self.of_law | adhesion | self.of_rate | ZEROS
        return parameters_of(ranges, ranges.keys() - known.keys(), known, RATE_ENDS)

    @property
    def of_rate(self) -> dict[str, Ranged]:
        """The ranges of the parameters of the law of w over speed."""
        return {} if self.rate is None else rate_parameters(self.rate)

    @property
    def of_law(self) -> dict[str, Ranged]:
        """The ranges of the parameters of the law; a power law has its onset where jumps of the contact show it."""
        onset = {"onset": TIME} if self.law == "power" and self.adheres else {}
        return _of_law(self.law, self.terms) | onset

    def relaxation(self, values: Values) -> Relaxation:
        """The law with its parameters."""
        parameters: dict[str, Any] = {name: values[name] for name in self.of_law}
        if self.law == "prony":
            own = tuple(parameters.values())
            over = max(sum(own[::2]) / (1 - SAME), 1.0)  # a search may step beyond
            parameters = {"weights": tuple(weight / over for weight in own[::2]), "times": own[1::2]}
        law: Relaxation = RELAXATIONS[self.law](**parameters)
        return law


def _of_law(law: str, terms: int) -> dict[str, Ranged]:
    """The ranges of the parameters of a law."""
    if law == "prony":
        numbers = range(1, terms + 1)
        return {f"{name}{i}": ranged for i in numbers for name, ranged in (("weight", WEIGHT), ("time", TIME))}
    return {name: ranged for name, ranged in ranges_of(RELAXATIONS[law]).items() if name != "onset"}


def relaxation_settings(
    law: str, fix: Named = (), free: Iterable[str] = (), E_star: float = 1.0,
    ranged: RangeRequest | None = None, rate: str | None = None, shared: Iterable[str] = (), own: Iterable[str] = (),
    **options: Any,
) -> RelaxationSettings:  # fmt: skip
    """Settings from what a user types: free are the modulus, the law's parameters and delta0, but for what ``fix``
    names, and what ``free`` adds: P0, and tilt of the base line [N/m]; w, and the stress or range of adhesion, which
    is else that of the case, ``ranged``, if it has one. Of a power law, whose modulus is that at its time, the time is
    fixed, 1 s by default. With a law of w over speed, ``rate``, w is free too. Several records have in common what is
    ``shared``, all but zeros by default, but for what is each's ``own``. ``E_star`` of the body [Pa]."""
    check_law(law, RELAXATIONS)
    law = "sls" if law == "kelvin-voigt" else law  # the same solid; both forms are told
    asked_for = RelaxationSettings(law, (), rate=rate, **options)
    of_law = _of_law(law, asked_for.terms) | ({"onset": TIME} if law == "power" else {})
    named = Nameable("--relaxation", MODULUS | of_law | ADHESION | asked_for.of_rate | ZEROS, E_star,
                     {"w0": "w"} if rate else {})  # fmt: skip
    fixed = named.known(fix)
    fixed = ({"time": 1.0} if law == "power" else {}) | fixed
    freed = [named.own(name) for name in free if name != "relaxation"]
    if twice := sorted({*freed} & fixed.keys()):
        raise InputError(f"fit: {twice[0]} is both free and fixed")
    wanted = ["delta0", *(["w"] if rate else []), *freed]
    wanted = [name for name in wanted if name not in fixed]
    adhesion = tuple(name for name in ADHESION if name in wanted)
    zeros = tuple(name for name in wanted if name in ZEROS)
    asked = [name for name in ADHESION if name in adhesion or name in fixed]
    if asked and "w" not in asked:
        raise InputError(f"fit: {asked[0]}: of a relaxing body it goes with w: give --free w, or leave it out")
    if asked and asked_for.confidence != "covariance":
        raise InputError(f"fit: --confidence {asked_for.confidence}: intervals of force curves that adhere are those "
                         "of samples: leave it out")  # fmt: skip
    if law == "power" and "onset" in fixed and not asked:
        raise InputError("fit: onset: what jumps of the contact show: it goes with w")
    if law == "power" and "modulus" in fixed and asked:
        raise InputError("fit: modulus: of a power law it is free with w")
    if {"stress", "range"} <= set(asked):
        raise InputError("fit: stress and range are one parameter with w: give one of them")
    if asked == ["w"] and ranged:
        fixed |= {"range": ranged.length} if ranged.stress is None else {"stress": ranged.stress}  # type: ignore[dict-item]
    common, each = [named.own(name) for name in shared], [named.own(name) for name in own]
    if both := set(common) & ({*each} | ZEROS.keys()):
        raise InputError(f"fit: {min(both)}: is each force curve's own, it cannot be in --shared")
    together = rate is not None or bool(common)
    if together and not (adhesion or fixed.keys() & ADHESION.keys()):
        raise InputError("fit: --shared: force curves are fitted together with w: add --free w")
    if together and asked_for.segment not in (None, "both"):
        raise InputError(f"fit: --segment {asked_for.segment}: whole force curves are fitted together: leave it out")
    others = (named.ranges.keys() - set(common)) if common else set(each)
    return replace(asked_for, zeros=zeros, fixed=fixed, adhesion=adhesion, own=(*ZEROS, *sorted(others - ZEROS.keys())))


def relaxation_at(t: Array, law: str, p: Mapping[str, float | Array]) -> Array:
    """r at the times ``t`` [s] of a ``law`` with many parameters ``p`` at once, (..., times)."""
    of = {name: np.asarray(value)[..., None] for name, value in p.items()}
    match law:
        case "sls":  # ratio + (1 - ratio) exp(-t/time)
            return of["ratio"] + (1 - of["ratio"]) * np.exp(-t / of["time"])
        case "power":  # ((t + onset)/time)^-exponent
            return ((t + of["onset"]) / of["time"]) ** -of["exponent"]
        case "prony":  # 1 - sum of weight (1 - exp(-t/time))
            terms = [name.removeprefix("weight") for name in p if name.startswith("weight")]
            return 1 + sum(of[f"weight{i}"] * np.expm1(-t / of[f"time{i}"]) for i in terms)
    # Another, of one's own, for one set of parameters after the other
    sets = np.broadcast_arrays(*p.values())
    laws = (RELAXATIONS[law](**dict(zip(p, values, strict=True))) for values in zip(*map(np.ravel, sets), strict=True))
    r = [one.modes(float(np.max(t, initial=TINY)))(t) for one in laws]
    return np.reshape(r, (*sets[0].shape, t.size))


@dataclass(frozen=True, eq=False)
class TimedRecord:
    """Readings over time: ``t`` [s], what was ``imposed`` by ``control`` (the position of the device or of its "tip"
    [m], or the load [N]) and the ``response`` (the load, or the displacement); standard deviations of both from row to
    row, ``noise``, and those by which they are weighed, ``sigma``: of the imposed, and of what is left of the response
    less ``shared`` times the noise of the imposed (per row). ``read``: nothing moved in straight pieces; then the
    displacement of the tip is imposed, as it was read. ``flags``: how rows were chosen; ``lasting``: time in contact
    [s], where free rows are among them."""

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
    lasting: float | None = None

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

    @property
    def spacing(self) -> float:
        """The time from row to row [s]."""
        return float(np.median(np.diff(self.t)))

    def weighed(self, off: tuple[Array, Array]) -> tuple[Array, Array]:
        """What readings are ``off`` a model, imposed and response, in standard deviations, independent of each
        other."""
        alone = (off[1] - self.shared * off[0]) / self.sigma[1]
        return off[0] / self.sigma[0], alone


@dataclass(frozen=True, eq=False, kw_only=True)
class RelaxationFit(Answer):
    """A fitted ``record``: the parameters and E* (instant, of a power law at its time; ``covariance``: of logs but for
    zeros and shares), the model of what was ``imposed`` and of the ``response``, the ``scatter`` of the residuals over
    the noise from row to row; ``samples`` of the unknowns (n, free), where they lie on no ellipse."""

    relaxation: Relaxation
    record: TimedRecord
    imposed: Array
    response: Array
    scatter: float
    settings: RelaxationSettings
    samples: Array | None = None

    def modulus(self, t: Array) -> Array:
        """E*(t) [Pa] at the times ``t`` [s] after a step with the ends of its intervals, (times, 3); nan where not
        determined."""
        nominal = self.value("E_star") / self.value("modulus")

        def logs(own: Values) -> Array:
            r = relaxation_at(t, self.settings.law, own)
            return np.log(nominal * own["modulus"] * np.maximum(r, TINY))

        return self.intervals(logs)

    def intervals(self, logs: Callable[[Values], Array]) -> Array:
        """Quantities by their ``logs`` as a function of the parameters, with the ends of their intervals, (n, 3)."""
        unknowns, values = Unknowns(self.settings.parameters), {item.name: item.value for item in self.estimates}
        x = unknowns.at(values)
        if self.samples is not None:
            drawn = np.array([logs(unknowns.values(sample)) for sample in self.samples])
            half = self.settings.level / 2
            return np.exp(np.quantile(drawn, [0.5, 0.5 - half, 0.5 + half], axis=0).T)
        here = logs(unknowns.values(x))
        error = np.full(here.size, math.nan)
        if self.covariance is not None:
            steps = MODULUS_STEP * np.maximum(np.abs(x), 1e-3)
            by = [(logs(unknowns.values(x + step)) - here) / step.sum() for step in np.diag(steps)]
            error = np.sqrt(np.maximum(np.einsum("it,ij,jt->t", by, self.covariance, by), 0.0))
        width = t_quantile(self.settings.level, self.dof) * error
        return np.exp(np.stack([here, here - width, here + width], axis=1))

    @property
    def doubts(self) -> list[str]:
        """Why it is not to be believed as it stands, in a few words each."""
        own = [self.estimate(name) for name in ("E_star", *self.free) if name != "modulus" and name not in ZEROS]
        lost = [word(item.name) for item in own if item.error is None or item.low is item.high is None]
        doubts = [f"{', '.join(lost)} not determined"] if lost else []
        doubts += self.vague([item.name for item in own if word(item.name) not in lost])
        doubts += [said for said in (UNSETTLED, BESIDE, LONG_RANGE) if any(said in line for line in self.warnings)]
        return doubts + ([MISFIT] if self.scatter > SEARCH_MISFIT else [])


def timed_record(curve: Curve) -> TimedRecord:
    """The readings of ``curve`` over time up to a retraction that pulls; InputError where a column is missing."""
    check_over_time(curve, "a fit of relaxation")
    if len(curve) < FEWEST_ROWS:
        raise InputError(f"{curve.where}: {len(curve)} rows, at least {FEWEST_ROWS} are needed")
    check_rising(curve.where, curve.time, np.arange(len(curve)))
    curve, flags = without_adhesion(averaged(curve))
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

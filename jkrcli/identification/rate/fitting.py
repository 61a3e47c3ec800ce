"""The common fit of records at one or several speeds: w0, the law's parameters, the modulus, zeros.

Every record has three unknowns of its own, the radius at its begin and shift and tilt of the device's motion: these
two carry what the displacements' noise leaves of that motion, which bounds them. All else is common.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ...adhesion import RATE_LAWS, RateLaw, rate_parameters
from ...base import NOTICEABLE, SAME, Array, InputError, JkrError, Ranged, SolveError, Unknown, evenly, show
from ...data import Curve
from ..answer import Answer
from ..fit import FittedBody, Settings, fit
from ..intervals import Followed, Intervals
from ..least_squares import TUNING as FITS
from ..least_squares import Least, LeastSquares, State
from ..motion import noise_about
from ..parameters import MODULUS, Nameable, Parameter, Unknowns, check_law, parameters_of
from ..work import WorkAlong, work_along
from .prediction import BESIDE, Prediction, predict
from .record import RateRecord, rate_record, recovered
from .through import ENDS, LawThrough, law_of, law_ranges, law_through, receding
from .through import TUNING as POINTS


@dataclass(frozen=True)
class RateFitTuning:
    """How the least sum of squares is sought, and when it is doubted."""

    good: float = 3.0  # theory: standard deviations of the scatter over 1 up to which no other start is tried
    softer: tuple[float, ...] = (1.0, 0.8, 0.64, 0.5, 0.4)  # choice: moduli over that of an even adhesion
    beyond: float = 0.2  # choice: of a record's length, how long after its last row contact may be predicted to be lost
    looked_at: int = 1_000  # choice: times at which the contact is examined for it
    rows: int = 120  # choice: of each record, by which starts are compared and followed
    exponents: tuple[float, ...] = (0.3, 0.6, 1.0)  # choice: starts of n, where the points' own does not lead to it
    first: int = 15  # choice: rows from which the radius at the begin is guessed


TUNING = RateFitTuning()
NO_START = "the fit over speed found no start from which it converges; fix n or v0, or check the units"


@dataclass(frozen=True)
class RateSettings:
    """A request: the ``law`` by name, the common ``unknowns`` (modulus, w0, those of the law, delta0, P0), the
    ``level`` of the intervals and by what ``confidence`` they are computed, the ``segment`` of the rows; values to
    ``start`` from: the search begins there alone where they are those of all free ones."""

    law: str
    unknowns: Unknowns
    level: float = 0.95
    confidence: Followed = "covariance"
    segment: str | None = None
    start: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, kw_only=True)
class RateFit(Answer):
    """Records fitted together: the common parameters and E* (``covariance``: of logs of those > 0), each record's
    readings and prediction, ``scatter`` of the residuals over the noise from row to row, ``speeds``: range of the
    edges' [m/s]."""

    law: RateLaw
    w0: float
    records: tuple[RateRecord, ...]
    predictions: tuple[Prediction, ...]
    zero: float
    scatter: float
    speeds: tuple[float, float]
    settings: RateSettings

    def band(self, v: Array) -> tuple[Array, Array, Array]:
        """w [J/m^2] at the speeds ``v`` [m/s], and the ends of its confidence band."""
        names = tuple(name for name in ("w0", *vars(self.law)) if name in self.free)
        chosen = [self.free.index(name) for name in names]
        inner = None if self.covariance is None else self.covariance[np.ix_(chosen, chosen)]
        return LawThrough(self.law, self.w0, names, inner, self.speeds, self.dof).band(v, self.settings.level)


def rate_settings(
    body: FittedBody, law: str, free: Iterable[str] = (), fix: Iterable[tuple[str, str]] = (),
    start: Iterable[tuple[str, str]] = (), **options: Any,
) -> RateSettings:  # fmt: skip
    """Settings from what a user types: free are the modulus, w0, the law's parameters and delta0, but for what ``fix``
    names, and what ``free`` adds (P0)."""
    check_law(law, RATE_LAWS)
    ranges = MODULUS | law_ranges(law) | {"delta0": Ranged("length"), "P0": Ranged("load")}
    named = Nameable("--law", ranges, body.problem.E_star, {"w": "w0"})
    fixed, wanted = named.known(fix), [named.own(name) for name in free]
    if both := [name for name in wanted if name in fixed]:
        raise InputError(f"fit: {both[0]} is both free and fixed")
    known = fixed if "P0" in wanted else {"P0": 0.0} | fixed
    unknowns = Unknowns(parameters_of(ranges, ranges.keys() - known.keys(), known, ENDS))
    return RateSettings(law, unknowns, start=named.known(start), **options)


def rate_fit(body: FittedBody, curves: Sequence[Curve], settings: RateSettings) -> RateFit:
    """The parameters that bring the predicted traces of ``body`` nearest to all ``curves`` together.

    InputError where the records do not allow it, SolveError where no search converges.
    """
    problem = _Problem(body, tuple(rate_record(curve, settings.segment) for curve in curves), settings)
    coarse, best = problem.thinned(), list[Least]()
    usual = 1 + TUNING.good / math.sqrt(2 * coarse.size)
    for start in coarse.starts():
        with contextlib.suppress(SolveError):
            least = coarse.minimise(start, NOTICEABLE)  # what is below takes the whole records
            best = [min([*best, least], key=lambda one: one.cost)]
        if best and math.sqrt(best[0].variance) < usual and not best[0].at_bound.any():
            break
    if not best:
        raise SolveError(NO_START)
    least = problem.minimise(best[0].x)
    problem = problem.settled(least)
    return problem.result(problem.minimise(least.x))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Residuals of all records as a function of the unknowns: the free common ones, then each record's three."""

    body: FittedBody
    records: tuple[RateRecord, ...]
    settings: RateSettings

    def thinned(self) -> _Problem:
        """The problem with a few rows of each record only, to find where to start."""
        return replace(self, records=tuple(record.thinned(TUNING.rows) for record in self.records))

    @property
    def unknowns(self) -> Unknowns:
        """Those that all records have in common."""
        return self.settings.unknowns

    def own(self, theta: Array, i: int) -> Array:
        """log a at the begin, shift and tilt over their standard deviations, of record ``i``."""
        first = len(self.unknowns.free) + 3 * i
        return theta[first : first + 3]

    def predictions(self, theta: Array) -> tuple[Prediction, ...]:
        """What each record shows at its rows."""
        return tuple(self._predicted(theta, i, record.t, False) for i, record in enumerate(self.records))

    def differences(self, theta: Array, predictions: Sequence[Prediction]) -> list[dict[str, Array]]:
        """What the ``predictions`` differ from the columns of each record, by their names."""
        zeros = {"P": self.unknowns.values(theta)["P0"], "a": 0.0}
        return [
            {name: getattr(prediction, name) + zeros[name] - read for name, read in record.columns.items()}
            for record, prediction in zip(self.records, predictions, strict=True)
        ]

    def _predicted(self, theta: Array, i: int, t: Array, onwards: bool) -> Prediction:
        values, (u, shift, tilt), record = self.unknowns.values(theta), self.own(theta, i), self.records[i]
        law, w0 = law_of(self.settings.law, values)
        body = self.body.nonadhesive.scaled(values["modulus"])
        program = record.program(shift * record.loose[0] - values["delta0"], tilt * record.loose[1], onwards)
        start = float(np.clip(math.exp(u), body.a[0] * 1.001, body.a[-1]))
        return predict(body, law, w0, record.stiffness, program, record.tilt, start, t)

    def equations(self, theta: Array) -> State:
        """Residuals in standard deviations, and their derivatives by the unknowns."""
        n, parts, rates, predictions = theta.size, [], [], self.predictions(theta)
        common = np.flatnonzero([parameter.free for parameter in self.unknowns.parameters])
        each = zip(self.records, predictions, self.differences(theta, predictions), strict=True)
        for i, (record, prediction, differences) in enumerate(each):
            first = common.size + 3 * i
            for name, off in differences.items():
                parts.append(off / record.sigma[name])
                by, matrix = getattr(prediction, f"d{name}"), np.zeros((off.size, n))
                all_common = np.vstack([by[0], by[BESIDE + 1 :], -by[1], np.full(off.size, float(name == "P"))])
                matrix[:, : common.size] = all_common[common].T
                own = by[BESIDE], by[1] * record.loose[0], by[2] * record.loose[1]
                matrix[:, first : first + 3] = np.stack(own, axis=1)
                rates.append(matrix / record.sigma[name])
            parts.append(theta[first + 1 : first + 3])
            rates.append(np.eye(n)[first + 1 : first + 3])
        return State(np.concatenate(parts), partial(np.concatenate, rates))

    def minimise(self, start: Array, cost: float = 0.0) -> Least:
        """The least sum of squares from ``start`` on, to ``cost`` relatively; SolveError where the way there fails."""
        try:
            bounds = self.unknowns.bounds(start, FITS.reach)
            return LeastSquares(self.equations, bounds, SAME, cost).least(start)
        except (JkrError, FloatingPointError, OverflowError, np.linalg.LinAlgError):
            raise SolveError(NO_START) from None

    @property
    def size(self) -> int:
        """Number of readings."""
        return sum(record.t.size * len(record.noise) for record in self.records)

    def settled(self, least: Least) -> _Problem:
        """The problem with each record cut at its predicted loss of contact, as its last row is else chosen by its own
        noise, and weighed by its residuals, which show the noise better than the differences of neighbours."""
        taken, records = (least.x.size - 2 * len(self.records)) / self.size, []
        parts = self.differences(least.x, self.predictions(least.x))
        for i, (record, part) in enumerate(zip(self.records, parts, strict=True)):
            again = rate_record(record.curve, self.settings.segment, self._lost(least.x, i))
            sigma = {name: noise_about(off, getattr(record, name), taken) for name, off in part.items()}
            records.append(replace(again, sigma=sigma))
        return replace(self, records=tuple(records))

    def _lost(self, theta: Array, i: int) -> float | None:
        """The time [s] at which the predicted tension of record ``i`` has all but gone; None where it does not go."""
        begin, end = self.records[i].t[[0, -1]]
        t = np.linspace(begin, end + TUNING.beyond * (end - begin), TUNING.looked_at)
        P = self._predicted(theta, i, t, True).P
        row = recovered(P, int(np.argmin(P)))
        return None if row == t.size else float(t[row])

    # ------------------------------------------------------------------ starts
    def starts(self) -> list[Array]:
        """Unknowns to begin with, the nearest first: the elastic part of the slowest record as if its adhesion did not
        depend on speed, with its own modulus and smaller ones, and the law by w over speed on that body."""
        candidates, reasons = [], []
        if set(self.unknowns.names) <= set(self.settings.start):
            values = dict(self.settings.start) | self.unknowns.fixed
            return [self._from(values, self._along(values))]
        for elastic in self._elastic():
            try:
                tried = [(self._cost(theta), theta) for theta in self._with(elastic)]
                candidates.append(min(tried, key=lambda item: item[0]))
            except InputError as error:
                reasons.append(error)
        if not candidates:
            raise reasons[0]
        return [theta for _, theta in sorted(candidates, key=lambda item: item[0])]

    def _cost(self, theta: Array) -> float:
        try:
            return float(np.sum(np.square(self.equations(theta).residuals)))
        except (JkrError, OverflowError):
            return math.inf

    def _with(self, elastic: Mapping[str, float]) -> list[Array]:
        """Starts with this elastic part: by the points of w over speed, and by exponents."""
        along = self._along(elastic)
        v, w, *_ = receding(along)
        some = slice(None, None, 1 + v.size // (TUNING.rows * len(along)))
        through = law_through(self.settings.law, v[some], w[some], 1)
        guesses = [] if isinstance(through, Unknown) or through.narrow else [through.values]
        speed = float(np.median(v)) if v.size else float(np.median([record.speed for record in self.records]))
        middle = float(np.median(w)) if w.size else float(np.median(along[0].w[along[0].ok]))
        guesses += [{"w0": middle / 2, "v0": speed, "n": n, "b": middle / 2} for n in TUNING.exponents]
        known = {**self.settings.start, **self.unknowns.fixed}
        return [self._from({**elastic, **guess, **known}, along) for guess in guesses]

    def _from(self, values: Mapping[str, float], along: Sequence[WorkAlong]) -> Array:
        """The unknowns of common ``values``, SI, and the radii at the begins of the records; w ``along`` each."""
        least, most = self.body.nonadhesive.a[[0, -1]] * (1.01, 0.999)
        radii = [np.clip(np.median(item.a[item.ok][: TUNING.first]), least, most) for item in along]
        return np.array([*self.unknowns.at(values), *(x for a in radii for x in (math.log(a), 0.0, 0.0))])

    def _along(self, values: Mapping[str, float]) -> list[WorkAlong]:
        """w along each record with the elastic part of ``values``; InputError where one has none."""
        body, along = self.body.nonadhesive.scaled(values["modulus"]), []
        for record in self.records:
            part, rows = record.curve.rows(record.rows), record.t.size
            moved = replace(part, delta=part.depth - values["delta0"], P=part.load - values["P0"])
            along.append(work_along(body, moved, window=min(max(11, rows // 40) | 1, rows - 1 + rows % 2)))
        return along

    def _elastic(self) -> Iterator[dict[str, float]]:
        """Modulus factors with delta0 and P0 of the slowest record, fitted as if its adhesion did not depend on speed:
        that makes it look stiffer, so that smaller moduli are tried too."""
        free = self._quiet(None)
        moduli = [1.0]
        if "modulus" in self.unknowns.fixed:
            moduli = [self.unknowns.fixed["modulus"]]
        elif free is not None:
            moduli = [free["modulus"] * factor for factor in TUNING.softer] + [1.0]
        for modulus in moduli:
            elastic = self._quiet(modulus)
            if elastic is not None:
                yield elastic
        yield {"modulus": moduli[-1], "delta0": 0.0, "P0": 0.0} | self.unknowns.fixed

    def _quiet(self, modulus: float | None) -> dict[str, float] | None:
        """Modulus, delta0 and P0 of the slowest record, its adhesion being the same at all speeds."""
        slowest = min(self.records, key=lambda record: record.speed)
        known = {key: value for key, value in self.unknowns.fixed.items() if key in ("delta0", "P0")}
        known |= {} if modulus is None else {"modulus": modulus}
        names = [name for name in ("modulus", "delta0", "P0") if name in self.unknowns.names and name not in known]
        parameters = [Parameter(name, True) for name in (*names, "w")]
        parameters += [Parameter(name, False, value) for name, value in known.items()]
        curve = replace(slowest.curve.rows(slowest.rows), segment=None)
        curve = curve.rows(evenly(len(curve), TUNING.rows))
        try:
            fitted = fit(self.body, curve, Settings(tuple(parameters), contact="as-is"))
        except JkrError:
            return None
        return {name: fitted.value(name) for name in ("modulus", "delta0", "P0")}

    # ------------------------------------------------------------------ the answer
    def result(self, least: Least) -> RateFit:
        values, settings, unknowns = self.unknowns.values(least.x), self.settings, self.unknowns
        law, w0 = law_of(settings.law, values)
        E_star = self.body.problem.E_star
        intervals = Intervals.of(unknowns, least, settings.level, settings.confidence, E_star)
        predictions = self.predictions(least.x)
        parts = zip(self.records, self.differences(least.x, predictions), strict=True)
        squares = sum(float(np.sum((part[name] / record.noise[name]) ** 2)) for record, part in parts for name in part)
        moving = np.concatenate([item.speed[item.speed > 0] for item in predictions])
        low, high = map(float, np.quantile(moving, (0.05, 0.95))) if moving.size else (0.0, 0.0)
        fit = RateFit(
            estimates=intervals.estimates(), free=unknowns.names, dof=least.dof,
            covariance=unknowns.covariance(intervals.covariance), law=law, w0=w0, records=self.records,
            predictions=predictions, zero=values["P0"], scatter=math.sqrt(squares / least.dof), speeds=(low, high),
            settings=settings,
        )  # fmt: skip
        return replace(fit, warnings=tuple(_warnings(fit)))


def _warnings(fit: RateFit) -> list[str]:
    """Warnings, each with its number."""
    lines = []
    low, high = fit.speeds
    of_law = [name for name in rate_parameters(fit.settings.law) if name in fit.free]
    if len(of_law) > 1 and high < POINTS.decade * low:
        lines.append(
            f"the edge's speeds span a factor of {high / low if low else 1:.2g} only ({show(low, 'speed')} to "
            f"{show(high, 'speed')}): less than a decade hardly determines {' and '.join(of_law)}; add other speeds"
        )
    if fit.covariance is None:
        return [*lines, f"the data do not determine {', '.join(fit.free)} together: fix one of them (--fix)"]
    lines += [line for _, _, line in fit.hardly_apart]
    lines += fit.vague([name for name in fit.free if name not in ("delta0", "P0")])
    if fit.scatter > FITS.misfit:
        lines.append(
            f"the loads scatter {fit.scatter:.2g} times as far about the prediction as from row to row: the law, the "
            "body or the device's stiffness is not what the data show; intervals are too narrow"
        )
    return lines

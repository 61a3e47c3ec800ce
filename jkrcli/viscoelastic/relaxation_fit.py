"""The modulus, a law of relaxation and the zero point from one record over time, without adhesion; with w the whole
record is fitted, with its retraction (``adhesive_fit.py``)."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import Program
from ..base.errors import InputError, JkrError, SolveError
from ..base.numerics import FEWEST_ROWS, SAME, TINY, Array
from ..base.units import show
from ..bodies.problem import Relaxation
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import SEARCH_MISFIT, SEARCH_REACH, Intervals, Least, LeastSquares, State, by_differences
from ..measured.parameters import Unknowns
from .adhesive_fit import adhering_fit
from .relaxation import RelaxingContact
from .timed_record import (
    MISFIT,
    ROWS_APART,
    ROWS_BEFORE,
    ZEROS,
    RelaxationFit,
    RelaxationSettings,
    TimedRecord,
    noise_about,
    timed_record,
)

# How the least sum of squares is sought, and when it is doubted.
FIT_TIMES = (0.02, 0.06, 0.2, 0.6)  # choice: starts of a relaxation time, over the record's length
FIT_SHARES = (0.2, 0.6)  # choice: starts of the ratio
FIT_EXPONENTS = (0.05, 0.15, 0.4)  # choice: starts of an exponent
FIT_DEPTHS = (0.0, 0.3, 1.0)  # choice: starts of the depth at which contact shows, over ``unseen``
FIT_DEEPER = 1.5  # times the depth, to which a body is solved; choice: guard of a search
FIT_APART = 2.5  # theory: rows between two corners, within which no row shows when a step was
FIT_STEP = 1e-6  # theory: of the unknowns, for derivatives: the root of what the histories err by
FIT_CONVERGED = 1e-6  # theory: relative, of the sum of squares; a change of 1e-3 standard errors in 1e3 rows
FIT_COARSER = 3  # choice: steps joined in the histories of a spring or a load, 1e-4 of the loads
FIT_GROWS = 0.02  # choice: of the depth, by which a contact may grow again: corners have the noise of readings
RANGE = "arithmetic overflow"
FAILURES = (JkrError, FloatingPointError, OverflowError, ValueError)  # of a history far from any record


def check_body(body: FittedBody) -> None:
    """InputError where a history is not that of one relaxation function."""
    if body.problem.indenter.material is not None or body.problem.sticks:
        raise InputError("fit: --relaxation needs a rigid indenter and frictionless contact")


def relaxation_fit(
    body: FittedBody, curve: Curve, settings: RelaxationSettings, like: RelaxationFit | None = None
) -> RelaxationFit:
    """The parameters that bring the history of ``body`` nearest to the record ``curve``; InputError where it does not
    allow it, SolveError where no history is found; both name the curve. ``like``: a fit with w of one that may be
    alike, where it begins."""
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            part = curve if settings.segment in (None, "both") else curve.only(settings.segment)
            fit = _fit(body, part, settings, like)
    except InputError as error:
        raise InputError([f"{line}{curve.likely}" for line in error.lines]) from None
    except SolveError as error:
        raise SolveError(f"{curve.where}: {error}{curve.likely}") from None
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        reason = f"{RANGE} ({error}); are all sizes and units right?{curve.likely}"
        raise SolveError(f"{curve.where}: {reason}") from error
    return replace(fit, warnings=(*curve.doubts, *fit.warnings))


def _fit(body: FittedBody, curve: Curve, settings: RelaxationSettings, like: RelaxationFit | None) -> RelaxationFit:
    check_body(body)
    if settings.adheres:
        with np.errstate(all="ignore"):  # of trials far from any record
            return adhering_fit(body, curve, settings, like)
    record = timed_record(curve)
    settings = _with_base_line(record, settings)
    body = body.to_depth(FIT_DEEPER * record.depth)
    problem = _Problem(body.nonadhesive, record, settings)
    least = problem.minimise(problem.start())
    problem = replace(problem, record=problem.reweighed(least))
    fit = problem.result(problem.minimise(least.x), body.problem.E_star)
    # Whether a term less of a Prony series does as well, by the information criterion of Bayes
    terms, rows = settings.terms - 1, fit.record.t.size
    if settings.law == "prony" and terms:
        fewer = relaxation_fit(body, fit.record.curve, replace(fit.settings, terms=terms))
        scores = [rows * math.log(np.sum((one.response - one.record.response) ** 2)) for one in (fit, fewer)]
        rise = scores[0] - scores[1] + (len(fit.free) - len(fewer.free)) * math.log(rows)
        if rise >= 0:
            words = f"{terms} terms fit as well as {terms + 1} (BIC better by {rise:.2g}): take --terms {terms}"
            fit = replace(fit, warnings=(*fit.warnings, words))
    return fit


def _with_base_line(record: TimedRecord, settings: RelaxationSettings) -> RelaxationSettings:
    """Free too, unless fixed, is what the loads before contact show of their base line."""
    if record.loaded:
        return settings
    before, limit = slice(0, record.shows // 2), ROWS_APART * record.noise[1]  # contact begins before it shows
    P, x, shown = record.response[before], record.imposed[before], list[str]()
    if P.size >= ROWS_BEFORE:
        about = x - x.mean()
        tilt = float(about @ P) / math.sqrt(max(float(about @ about), TINY))
        shown += ["P0"] * (abs(float(P.mean())) > limit / math.sqrt(P.size)) + ["tilt"] * (abs(tilt) > limit)
    return replace(settings, zeros=(*settings.zeros, *shown))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Residuals as a function of the unknowns: the free parameters, then places and times of the corners."""

    body: Nonadhesive
    record: TimedRecord
    settings: RelaxationSettings

    @property
    def still(self) -> bool:
        """Whether what was imposed is known as it was read."""
        return self.record.read

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

    def _readings(self, theta: Array) -> tuple[Array, Array, Array]:
        """The same, and which rows are in contact."""
        values, record, program = self.unknowns.values(theta), self.record, self.program(theta)
        zero, other = ("P0", "delta0") if record.loaded else ("delta0", "P0")
        imposed = np.interp(record.t, program.t, program.x)
        x, modulus = program.x - values[zero], values["modulus"]
        law, stiffness = self.settings.relaxation(values), record.stiffness / modulus  # loads over the modulus
        program = Program(program.t, x / modulus if record.loaded else x)
        a, delta, P = self._contact(law, stiffness).history(program).states(record.t)
        response = delta if record.loaded else modulus * P
        return imposed, response + values[other] + values["tilt"] * (imposed - imposed[0]), a > 0

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
        """What both readings, one after the other, are ``off`` in standard deviations."""
        n = self.record.t.size
        first, rest = self.record.weighed((off[:n], off[n:]))
        return np.concatenate([*([] if self.still else [first]), rest])

    def reweighed(self, least: Least) -> TimedRecord:
        """The record with standard deviations as the readings scatter about the model: of the response those of the
        rows in contact, whose noise is another than that of a free lever, and of all others apart."""
        record, n = self.record, self.record.t.size
        imposed, response, touches = self._readings(least.x)
        off = imposed - record.imposed, response - record.response
        left = 1 - np.sum(np.linalg.qr(least.state.jacobian)[0] ** 2, axis=1)  # of each square, by its leverage
        shared = record.shared if record.shared == 0 else float(off[0] @ off[1]) / max(float(off[0] @ off[0]), TINY)
        first = record.sigma[0]
        if not self.still:
            first = noise_about(float(off[0] @ off[0]), float(left[:n].sum()), record.imposed)
        alone, second = off[1] - shared * off[0], np.empty(n)
        parts = [touches, ~touches]
        if min(int(part.sum()) for part in parts) < FEWEST_ROWS:
            parts = [np.full(n, True)]
        second[:] = record.sigma[1]
        for part in parts:
            squares = float(alone[part] @ alone[part])
            second[part] = noise_about(squares, float(left[-n:][part].sum()), record.response)
        return replace(record, sigma=(first, second), shared=shared)

    def minimise(self, start: Array) -> Least:
        """The least sum of squares from ``start`` on: logs stay near it, shares within 0 and 1, corners between their
        neighbours."""
        low, high = self.unknowns.bounds(start, SEARCH_REACH)
        t, k = self.record.knots[0] / np.ptp(self.record.knots[0]), self.moving
        first = start.size - k.size
        low[first:], high[first:] = (t[k - 1] - t[k]) / 2, (t[k + 1] - t[k]) / 2
        return LeastSquares(self.state, (low, high), FIT_CONVERGED).least(start)

    def cost(self, theta: Array) -> float:
        """The sum of squares; infinite where there is no history."""
        with contextlib.suppress(SolveError):
            return float(np.sum(self.state(theta).residuals ** 2))
        return math.inf

    def state(self, theta: Array) -> State:
        """The residuals in standard deviations with their derivatives."""
        return by_differences(self.residuals, theta, np.full(theta.size, FIT_STEP))

    def extended(self, own: Array) -> Array:
        """All unknowns from those of the parameters."""
        if self.still:
            return own
        places = self.record.knots[1] / np.ptp(self.record.knots[1])
        return np.concatenate([own, places, np.zeros(self.moving.size)])

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
        fit = RelaxationFit(
            estimates=intervals.estimates(), free=unknowns.names, dof=least.dof,
            covariance=unknowns.covariance(intervals.covariance),
            relaxation=settings.relaxation(unknowns.values(least.x)), record=record,
            imposed=imposed, response=response, settings=settings,
            scatter=math.sqrt(float(off @ off) / max(off.size - len(unknowns.free), 1)),
        )  # fmt: skip
        program = self.program(least.x)
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
        return replace(fit, warnings=tuple(lines))

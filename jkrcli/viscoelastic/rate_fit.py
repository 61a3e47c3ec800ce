"""The common fit of records at one or several speeds: w0, the law's parameters, the modulus, zeros.

Every record has three unknowns of its own, the radius at its begin and shift and tilt of the device's motion: these
two carry what the displacements' noise leaves of that motion, which bounds them. All else is common.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import REST, Edge, Program
from ..base.arguments import read_fields
from ..base.errors import LEVEL, NOTICEABLE, InputError, JkrError, SolveError, Unknown, counted
from ..base.numerics import FEWEST_ROWS, HALF_WIDTH, ROUNDED, SAME, Array, PiecewiseCubic, evenly, zeros_between
from ..base.units import LARGEST_SI, Named, Ranged, show
from ..measured.choices import SegmentName, Values
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
    covariance,
    larger,
    robust_scale,
    t_quantile,
)
from ..measured.parameters import MODULUS, Answer, Level, Nameable, Parameter, Unknowns, check_law, parameters_of
from ..measured.procedure import fit
from ..measured.rows import noise_from_third_differences
from ..measured.settings import Settings
from ..measured.work import WorkAlong, work_along
from .rate import RATE_ENDS, RATE_LAWS, Motion, RateContact, RateLaw, rate_parameters
from .timed_record import check_over_time, check_rising, noise_about, noise_of, through

# --------------------------------------------------------------------------------------------------
# Records of retraction over time: which rows are fitted, and what the device did.

# Limits of the rows of a retraction.
RECORD_MOVING = 0.1  # choice: of the travel, beyond which the device surely moves back
RECORD_RECOVERED = 0.2  # choice: of the pull-off force: rows of less tension behind it are taken as free
RECORD_STILL = 3.0  # theory: standard deviations above the highest rows, where the way back would begin: it waited
RECORD_HIGHEST = 2.33  # theory: standard deviations by which 1 % of rows at rest lie higher
RECORD_STRAIGHT = 1.5  # choice: scatter about a straight line over the noise, beyond which the motion is no line
RECORD_KNOTS = 40  # choice: points of a motion that is no line


@dataclass(frozen=True, eq=False)
class RateRecord:
    """One retraction: times ``t`` [s], load ``P`` [N], where measured radius ``a`` [m]; their standard deviations from
    row to row, ``noise``, and those by which they are weighed, ``sigma``. The device moves by ``base`` (t, x) but for a
    shift and a tilt of standard deviations ``loose`` [m]; ``rows`` of the curve."""

    curve: Curve
    t: Array
    P: Array
    a: Array | None
    noise: dict[str, float]
    sigma: dict[str, float]
    base: tuple[Array, Array]
    loose: tuple[float, float]
    stiffness: float
    rows: Array

    @property
    def columns(self) -> dict[str, Array]:
        """What was measured of load and radius, by name."""
        return {"P": self.P} | ({} if self.a is None else {"a": self.a})

    @property
    def tilt(self) -> tuple[float, float]:
        """Middle and half-width [s] of the times, over which the tilt grows from -1 to 1."""
        return float(self.t[0] + self.t[-1]) / 2, float(self.t[-1] - self.t[0]) / 2

    def program(self, shift: float, tilt: float, onwards: bool = False) -> Program:
        """What the device did, moved by ``shift`` [m] and tilted by ``tilt`` [m] at the ends; ``onwards``: moving on as
        at the last row for as long as there is contact."""
        t, x = self.base
        middle, half = self.tilt
        moved = x + shift + tilt * (t - middle) / half
        rate = float((moved[-1] - moved[-2]) / (t[-1] - t[-2]))
        return Program(t, moved, rate if onwards and rate < 0 else None)

    def thinned(self, most: int) -> RateRecord:
        """The record by at most ``most`` of its rows, its ends among them."""
        some = evenly(self.t.size, most)
        a = None if self.a is None else self.a[some]
        return replace(self, t=self.t[some], P=self.P[some], a=a, rows=self.rows[some])

    @property
    def speed(self) -> float:
        """Mean speed of the device on its way back [m/s]."""
        t, x = self.base
        return float((x[0] - x[-1]) / (t[-1] - t[0]))


def rate_record(curve: Curve, segment: str | None, lost: float | None = None) -> RateRecord:
    """The retraction in ``curve``: its rows of ``segment`` (default: "retract" where it names any), from the turn of
    the device until the time ``lost`` [s], None: that at which the readings show the contact to be lost. InputError
    where a column is missing or too few rows are left."""
    check_over_time(curve, "a fit over speed")
    if segment not in (None, "retract"):
        raise InputError(f"{curve.where}: a fit over speed takes the retraction alone: leave --segment {segment} out")
    if curve.segment is None and segment is not None:
        curve.only(segment)  # refuses
    numbers = np.arange(len(curve)) if curve.segment is None else np.flatnonzero(curve.segment == "retract")
    part = curve.rows(numbers)
    t, P, device = part.time, part.load, part.device
    check_rising(curve.where, t, numbers)
    chosen = _retraction(t, P, device, lost) if t.size >= FEWEST_ROWS else np.empty(0, dtype=int)
    if chosen.size < FEWEST_ROWS:
        raise InputError(f"{curve.where}: {chosen.size} rows of a retraction, at least {FEWEST_ROWS} are needed")
    # The device's motion as points (t, x), and standard deviations of its shift and tilt, from noise alone: that of the
    # readings about the motion
    times, x = t[chosen], device[chosen]
    z = (times - (times[0] + times[-1]) / 2) / ((times[-1] - times[0]) / 2)
    line = np.polynomial.Polynomial(np.polynomial.polynomial.polyfit(z, x, 1))
    base = times[[0, -1]], line(np.array([-1.0, 1.0]))
    off = noise_about(float(np.sum((x - line(z)) ** 2)), times.size - 2, x)
    if off > RECORD_STRAIGHT * noise_from_third_differences(x) + SAME * float(np.ptp(x)):
        knots = np.linspace(times[0], times[-1], min(RECORD_KNOTS, times.size // 4) + 1)
        places, pieces = through(times, x, knots)
        base, off = (knots, places), noise_about(float(np.sum((x - pieces) ** 2)), times.size - knots.size, x)
    loose = off / np.sqrt(times.size), off / np.sqrt(np.sum((z - z.mean()) ** 2))
    stiffness = np.inf if curve.stiffness is None else float(curve.stiffness)
    a = None if part.a is None else part.a[chosen]
    record = RateRecord(curve, times, P[chosen], a, {}, {}, base, loose, stiffness, numbers[chosen])
    noise = {name: noise_of(column) for name, column in record.columns.items()}
    return replace(record, noise=noise, sigma=noise)


def _retraction(t: Array, P: Array, device: Array, lost: float | None) -> Array:
    """Rows from the turn of the device to loss of contact; none where the device does not move back."""
    top, end = float(np.quantile(device, 0.99)), float(np.min(device))
    moved = np.flatnonzero(device > top - RECORD_MOVING * (top - end))
    last = int(moved[-1]) if moved.size else 0
    if last + 2 > t.size:
        return np.empty(0, dtype=int)
    lowest = last + int(np.argmin(P[last:]))
    fitted = slice(last, max(lowest, last + 2))
    since, way = t[fitted] - t[last], device[fitted]  # of two rows at least, whose times rise
    rate = float((since - since.mean()) @ way / np.sum((since - since.mean()) ** 2))
    level = float(way.mean() - rate * since.mean())
    noise = noise_from_third_differences(device)
    begin = 0
    if rate < 0 and level + rate * (t[0] - t[last]) > top + RECORD_STILL * noise:
        begin = int(np.searchsorted(t, t[last] + (top - RECORD_HIGHEST * noise - level) / rate))
    free = float(np.median(P[-max(5, P.size // 50) :]))
    level = free if abs(free) < 0.3 * (np.max(P) - np.min(P)) else 0.0  # of the load out of contact
    over = recovered(P - level, lowest) if lost is None else max(int(np.searchsorted(t, lost)), begin + FEWEST_ROWS)
    return np.arange(begin, min(over, t.size))


def recovered(P: Array, lowest: int) -> int:
    """The row behind the ``lowest`` where the tension has all but gone; the number of rows where it never has."""
    risen = np.flatnonzero(P[lowest:] > RECORD_RECOVERED * P[lowest])
    return lowest + int(risen[0]) if risen.size else P.size


# --------------------------------------------------------------------------------------------------
# A law through works of adhesion at measured speeds of the edge: what `work` shows, and where a fit begins.

# When a law is put through points, and how.
WHOLE_LEAST = 12  # choice: points
WHOLE_DECADE = 10.0  # choice: ratio of the speeds below which the points do not separate n and v0
WHOLE_EXPONENTS = (0.25, 0.5, 1.0)  # choice: starts of n
WHOLE_REACH = 40.0  # tuned on work along a record, by `make constants`: guard, how far logs move
# tuned on work along a record, by `make constants`: relative half-width of a speed, beyond which its point says
# nothing about a law
WHOLE_SURE = 0.3
# tuned on work along a record, by `make constants`: of weights by the errors of the speeds, which ask for the law
WHOLE_ROUNDS = 3
WHOLE_BLOCKS = 8  # choice: of neighbouring points that are left out in turn
WHOLE_EVEN = 0.01  # choice: guard, least weight of a point's error over the median
# tuned on work along a record, by `make constants`: standard deviations beyond which a point pulls less, as
# outliers are usual
WHOLE_TURN = 1.5


@dataclass(frozen=True, eq=False)
class LawAlongRecords:
    """A ``law`` with its ``w0`` [J/m^2] through points of w over speed; ``names`` of what is free of them, and the
    covariance of their logs (None where the points do not separate them); ``speeds``: the range [m/s]; ``dof``: degrees
    of freedom."""

    law: RateLaw
    w0: float
    names: tuple[str, ...]
    inner: Array | None
    speeds: tuple[float, float]
    dof: int

    @property
    def values(self) -> dict[str, float]:
        """w0 and the law's parameters, SI."""
        return {name: self.w0 if name == "w0" else getattr(self.law, name) for name in self.names}

    @property
    def errors(self) -> dict[str, float | None]:
        """Relative standard errors of the same."""
        sigma = [None] * len(self.names) if self.inner is None else np.sqrt(np.diag(self.inner)).tolist()
        return dict(zip(self.names, sigma, strict=True))

    @property
    def narrow(self) -> bool:
        """Whether the speeds span less than the decade that separates n and v0, or n ends on a bound."""
        ends = "n" in self.values and not RATE_ENDS["n"][0] * 1.01 < self.values["n"] < RATE_ENDS["n"][1] * 0.99
        return ends or self.speeds[1] < WHOLE_DECADE * self.speeds[0]

    def band(self, v: Array, level: float = LEVEL) -> tuple[Array, Array, Array]:
        """w [J/m^2] at the speeds ``v`` [m/s], and the ends of its confidence band."""
        w = self.law.work(self.w0, v)
        if self.inner is None:
            return w, w, w
        rates = log_rates(self.law, self.w0, v)[[name in self.names for name in ("w0", *vars(self.law))]]
        variance = np.maximum(np.einsum("pn,pq,qn->n", rates, self.inner, rates), 0.0)  # of exact points: rounding
        spread = t_quantile(level, self.dof) * np.sqrt(variance)
        return w, w * np.exp(-spread), w * np.exp(spread)


def law_ranges(name: str) -> dict[str, Ranged]:
    """The ranges of w0 and of the parameters of the law called ``name``."""
    return {"w0": Ranged("work", above=0)} | rate_parameters(name)


def law_of(name: str, values: Values) -> tuple[RateLaw, float]:
    """The law called ``name`` and w0 by the ``values`` of its parameters and w0, SI."""
    law: RateLaw = RATE_LAWS[name](**{key: values[key] for key in rate_parameters(name)})
    return law, values["w0"]


def log_rates(law: RateLaw, w0: float, v: Array) -> Array:
    """Derivatives of log w at the speeds ``v`` by the logs of (w0, parameters), shape (parameters, n)."""
    kind, values, step = type(law), vars(law), 1e-6
    rates = [np.log(law.work(w0 * (1 + step), v) / law.work(w0 * (1 - step), v))]
    for name in values:
        high, low = (kind(**(values | {name: values[name] * (1 + sign * step)})) for sign in (1, -1))
        rates.append(np.log(high.work(w0, v) / low.work(w0, v)))
    return np.stack(rates) / (2 * step)


def law_along_records(
    name: str, v: Array, w: Array, together: int = 1, v_err: Array | None = None
) -> LawAlongRecords | Unknown:
    """The law called ``name`` nearest to works ``w`` [J/m^2] at speeds ``v`` > 0 [m/s], by their logs, robustly.

    ``together``: how many neighbouring points share their noise; ``v_err``: half-widths of the speeds [m/s]. Unknown
    where there are too few points.
    """
    rows = (v > 0) & (w > 0)
    if v_err is not None:
        rows &= v_err < WHOLE_SURE * v
    v, w = v[rows], w[rows]
    if v.size < WHOLE_LEAST * max(1, together // 4):
        return Unknown(f"{v.size} points with a receding contact line are too few for a law")
    ranges = law_ranges(name)
    logs = Unknowns(parameters_of(ranges, ranges, {}, RATE_ENDS))
    # Half of w at the middle speed is due to it
    low, middle, speed = float(np.quantile(w, 0.02)), float(np.median(w)), float(np.median(v))
    known = dict.fromkeys(logs.names, 1.0) | {"w0": min(low, middle / 2), "v0": speed, "b": middle / 2}
    starts, sigma = [logs.at(known | {"n": exponent}) for exponent in WHOLE_EXPONENTS], np.ones(v.size)
    for _ in range(1 if v_err is None else WHOLE_ROUNDS):
        best = min((_nearest(name, logs, v, w, sigma, start) for start in starts), key=lambda least: least.cost)
        law, w0 = law_of(name, logs.values(best.x))
        residuals, starts = np.log(law.work(w0, v) / w), [best.x]
        if v_err is not None:
            # By the half-widths of the speeds and the scatter of the half of the points whose speeds are surest
            by_v = np.log(law.work(w0, v * (1 + 1e-4)) / law.work(w0, v * (1 - 1e-4))) / 2e-4
            known_to = by_v * v_err[rows] / (HALF_WIDTH * v)
            sigma = np.hypot(known_to, robust_scale(residuals[known_to <= np.median(known_to)]))
            even = float(np.median(sigma))
            sigma = np.maximum(sigma / even, WHOLE_EVEN) if even > 0 else np.ones_like(v)
    dof = max(v.size // together - best.x.size, 1)
    factor = robust_scale(residuals / sigma) ** 2 * together
    ends = np.quantile(v, (0.05, 0.95))
    inner = covariance((log_rates(law, w0, v) / sigma).T, factor)
    if v_err is not None:
        # By leaving out blocks of neighbouring points in turn: what smoothing has done to the speeds of neighbours is
        # no noise that averages out (delete-block jackknife, Kuensch, Ann. Statist. 17 (1989) 1217)
        every = np.arange(v.size)
        rest = [np.setdiff1d(every, block) for block in np.array_split(every, WHOLE_BLOCKS)]
        estimates = np.array([_nearest(name, logs, v[rows], w[rows], sigma[rows], best.x).x for rows in rest])
        apart = estimates - estimates.mean(axis=0)
        inner = larger(inner, (WHOLE_BLOCKS - 1) / WHOLE_BLOCKS * apart.T @ apart)
    return LawAlongRecords(law, w0, logs.names, inner, (float(ends[0]), float(ends[1])), dof)


def receding(along: Sequence[WorkAlong]) -> tuple[Array, Array, int, Array]:
    """Speeds [m/s] > 0 of receding edges that stand out of their error and w [J/m^2] there, of all curves that were
    timed; rows of their window, and half-widths of the speeds."""
    parts, window = [np.empty((3, 0))], 1
    for item in along:
        if item.timed is not None and item.speed is not None and item.speed_err is not None:
            rows = item.timed & (item.speed < -item.speed_err)
            parts.append(np.stack([-item.speed, item.w, item.speed_err])[:, rows])
            window = max(window, item.window)
    speeds, works, errors = np.concatenate(parts, axis=1)
    return speeds, works, window, errors


def law_along(along: Sequence[WorkAlong]) -> LawAlongRecords | Unknown | None:
    """The power law through all receding edges ``along`` records; None where no time was recorded."""
    if all(item.timed is None for item in along):
        return None
    return law_along_records("power", *receding(along))


def _nearest(name: str, logs: Unknowns, v: Array, w: Array, sigma: Array, start: Array) -> Least:
    def residuals(x: Array) -> Array:
        law, w0 = law_of(name, logs.values(x))
        return np.log(law.work(w0, v) / w) / sigma

    def state(x: Array) -> State:
        return State(residuals(x), lambda: (log_rates(*law_of(name, logs.values(x)), v) / sigma).T)

    scale = max(float(np.median(np.abs(residuals(start)))), 1e-3)
    width, bounds = scale * WHOLE_TURN / 10, logs.bounds(start, WHOLE_REACH)
    return LeastSquares(state, bounds, loss="soft_l1", width=width).least(start)


# --------------------------------------------------------------------------------------------------
# Load and contact radius of a record at every row as functions of the parameters, with their derivatives.
#
# The path of the edge is that of ``adhesion.rate``; along it the change y_p of log a by a parameter p at fixed time
# obeys the linear equation dy/dt = F_u y + F_p of the motion du/dt = F(u, t, p). It is solved on the nodes of the
# path by exponential steps, whose error is of second order and bounded where the equation is stiff.

# Accuracy of a trace that is compared with readings.
PREDICTION_TOLERANCE = 1e-8  # choice: of the integrator, far below the noise of any record
PREDICTION_EVALUATIONS = 5_000  # choice: guard, ten times what a retraction takes; beyond it values are far off
PREDICTION_BETWEEN = 4  # choice: nodes per step of the integrator; the steps of the derivatives err by 1e-4 with them
PREDICTION_STEP = 1e-4  # theory: of log v, for the law's slope: the square root of what round-off leaves of it

# theory: columns beside the law's: common modulus, what the device holds, its speed; then the radius at the begin
BESIDE = 3


@dataclass(frozen=True, eq=False)
class Prediction:
    """Load ``P`` [N] and radius ``a`` [m] (0 out of contact) at the rows' times; ``dP, da``: derivatives by log of the
    modulus factor, what the device holds [m], its tilt, log of the first radius, logs of (w0, law), (p, n).
    ``speed`` [m/s]: of the receding edge, 0 at rest."""

    P: Array
    a: Array
    dP: Array
    da: Array
    speed: Array


def predict(
    body: Nonadhesive, law: RateLaw, w0: float, stiffness: float, program: Program, tilt: tuple[float, float],
    start: float, t: Array,
) -> Prediction:  # fmt: skip
    """The trace of a ``body`` retracted by ``program`` from the radius ``start`` [m] on, at the times ``t`` [s].

    ``tilt``: middle and half-width [s] of the times, over which a tilt of the program grows from -1 to 1.
    """
    contact = RateContact(
        body, law, w0, 0.0, stiffness, tolerance=PREDICTION_TOLERANCE, evaluations=PREDICTION_EVALUATIONS, slow=0.0
    )
    pieces = contact.once(program, start).pieces
    edge, parameters = contact.edge, BESIDE + 1 + 1 + len(vars(law))
    y = np.zeros(parameters)
    y[BESIDE] = 1.0
    u, rates, speed = np.full(t.size, -np.inf), np.zeros((parameters, t.size)), np.zeros(t.size)
    x = np.interp(t, program.t, program.x)
    if program.rate is not None:
        x = np.where(t > program.t[-1], program.x[-1] + program.rate * (t - program.t[-1]), x)
    for piece in pieces:
        rows = (t >= piece.first[0]) & (t <= piece.last[0])
        if piece.phase == REST:
            u[rows], rates[:, rows] = np.log(piece.last[1]), y[:, None]
        elif isinstance(piece, Motion):
            u[rows], rates[:, rows], y, speed[rows] = _moving(edge, piece, law, w0, tilt, y, t[rows])

    # Load and radius, and their derivatives, of log a and its derivatives
    touching = u > -np.inf
    ends = edge.body.a[[0, -1]]
    a = np.clip(np.exp(np.where(touching, u, np.log(ends[0]))), *ends)
    state, here = edge.state(a, x), edge.body.parts(a)
    give = 1 / edge.stiffness
    c = 1 + here.S * give
    direct = np.zeros_like(rates)
    direct[0] = state.P - here.S * (here.P_H - state.lag * here.S) * give / c
    direct[1], direct[2] = here.S / c, here.S / c * ((t - tilt[0]) / tilt[1])
    dP = direct - here.dS * state.lag * a / c * rates
    P, a, dP, da = (np.where(touching, column, 0.0) for column in (state.P, a, dP, a * rates))
    return Prediction(P, a, dP, da, speed)


def _moving(
    edge: Edge, piece: Motion, law: RateLaw, w0: float, tilt: tuple[float, float], y: Array, t: Array
) -> tuple[Array, Array, Array, Array]:
    """log a and its derivatives at the times ``t`` of a motion, the derivatives at its end, and the edge's speed."""
    inner = np.arange(PREDICTION_BETWEEN) / PREDICTION_BETWEEN
    s = np.append((piece.nodes[:-1, None] + np.diff(piece.nodes)[:, None] * inner).ravel(), piece.nodes[-1])
    tau, u = piece.path(s)[:2]
    times, a = piece.ramp.t + piece.unit * tau, np.exp(u)
    # Speed v, F_u and F_p of du/dt = F = -v(G)/a on the path
    x = piece.ramp.at(times)
    state = edge.state(a, x)
    v = -piece.speeds(a, state.G)
    here, rate = edge.body.with_rates(a)
    give = 1 / edge.stiffness  # of a rigid device 0
    c = 1 + here.S * give
    lag_u = a * (rate.delta_H - state.lag * here.dS * give / c)
    lag_s = (here.P_H - state.lag * here.S) * give / c
    g_u = a * rate.dS / here.dS + 2 * lag_u / state.lag - 1  # of log G
    g_x = -2 / (c * state.lag)
    moves = state.G > w0 * (1 + ROUNDED)  # below, round-off hides how v follows from G
    safe, step = np.where(moves, v, 1.0), PREDICTION_STEP
    slope = np.log(law.work(w0, safe * (1 + step)) / law.work(w0, safe * (1 - step))) / (2 * step)  # dlog w/dlog v
    by_G = np.where(moves, 1 / slope, 0.0)  # dlog v/dlog G
    F = -v / a
    shift = np.stack([1 + 2 * lag_s / state.lag, g_x, g_x * (times - tilt[0]) / tilt[1], np.zeros_like(a)])
    by_law = -log_rates(law, w0, safe)
    forcing = F * by_G * np.concatenate([shift, by_law])
    growth = F * (by_G * g_u - 1)
    per_s = piece.unit / np.hypot(1.0, v * piece.unit / a)  # dt/ds
    along = _linear(s, growth * per_s, forcing * per_s, y)
    clock = PiecewiseCubic(s, times, per_s)  # the s, among the nodes, of the times t
    t = np.clip(t, *clock(s[[0, -1]]))
    after = np.clip(np.searchsorted(clock(s), t), 1, s.size - 1)
    at = zeros_between(lambda at: clock(at) - t, s[after - 1], s[after], 0.0)
    u_rows = PiecewiseCubic(s, u, -v / a * per_s)(at)
    rates = np.stack([np.interp(at, s, row) for row in along])
    return u_rows, rates, along[:, -1], np.interp(at, s, v)


def _linear(s: Array, growth: Array, forcing: Array, y: Array) -> Array:
    """The solution (p, n) of dy/ds = growth y + forcing from ``y`` (p,) on, by exponential steps."""
    h = np.diff(s)
    A = np.clip(h * (growth[:-1] + growth[1:]) / 2, -700, 1)
    phi = np.where(np.abs(A) < 1e-8, 1.0, np.expm1(A) / np.where(A == 0, 1.0, A))
    gain, added = np.exp(A), (h * phi * (forcing[:, :-1] + forcing[:, 1:]) / 2).T
    solution = np.empty((s.size, y.size))
    solution[0] = y
    for i, (factor, term) in enumerate(zip(gain.tolist(), added, strict=True)):
        y = solution[i + 1] = factor * y + term
    return np.clip(np.nan_to_num(solution.T), -LARGEST_SI, LARGEST_SI)  # a path far from any record runs away


# How the least sum of squares is sought, and when it is doubted.
FIT_GOOD = 3.0  # theory: standard deviations of the scatter over 1 up to which no other start is tried
FIT_SOFTER = (1.0, 0.8, 0.64, 0.5, 0.4)  # choice: moduli over that of an even adhesion
FIT_BEYOND = 0.2  # choice: of a record's length, how long after its last row contact may be predicted to be lost
FIT_LOOKED_AT = 1_000  # choice: times at which the contact is examined for it
FIT_ROWS = 120  # choice: of each record, by which starts are compared and followed
FIT_EXPONENTS = (0.3, 0.6, 1.0)  # choice: starts of n, where the points' own does not lead to it
FIT_FIRST = 15  # choice: rows from which the radius at the begin is guessed


NO_START = "the fit over speed found no start from which it converges; fix n or v0, or check the units"


@dataclass(frozen=True)
class RateSettings:
    """A request: the ``law`` by name, the common ``unknowns`` (modulus, w0, those of the law, delta0, P0), the
    ``level`` of the intervals and by what ``confidence`` they are computed, the ``segment`` of the rows; values to
    ``start`` from: the search begins there alone where they are those of all free ones."""

    law: str
    unknowns: Unknowns
    level: Level = LEVEL
    confidence: Followed = "covariance"
    segment: SegmentName | None = None
    start: Values = field(default_factory=dict)

    def __post_init__(self) -> None:
        read_fields(self, "fit")


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
        return LawAlongRecords(self.law, self.w0, names, inner, self.speeds, self.dof).band(v, self.settings.level)


def rate_settings(
    body: FittedBody, law: str, free: Iterable[str] = (), fix: Named = (), start: Named = (), **options: Any
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
    unknowns = Unknowns(parameters_of(ranges, ranges.keys() - known.keys(), known, RATE_ENDS))
    return RateSettings(law, unknowns, start=named.known(start), **options)


def rate_fit(
    body: FittedBody, curves: Sequence[Curve], settings: RateSettings,
    announce: Callable[[str, float], None] | None = None,
) -> RateFit:  # fmt: skip
    """The parameters that bring the predicted traces of ``body`` nearest to all ``curves`` together.

    ``announce`` gets what is done and about how many CPU seconds are left, where the first start does not match.
    InputError where the records do not allow it, SolveError where no search converges.
    """
    problem = _Problem(body, tuple(rate_record(curve, settings.segment) for curve in curves), settings)
    few = tuple(record.thinned(FIT_ROWS) for record in problem.records)  # to find where to start
    coarse, best = replace(problem, records=few), list[Least]()
    usual = 1 + FIT_GOOD / math.sqrt(2 * coarse.size)
    begun, starts = time.process_time(), coarse.starts()
    for i, start in enumerate(starts):
        if i == 1 and announce is not None:
            what = f"fit of a law to {counted(coarse.size, 'reading')} from {counted(len(starts), 'start')}"
            announce(what, len(starts) * (time.process_time() - begun))
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
            bounds = self.unknowns.bounds(start, SEARCH_REACH)
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
            # Where the predicted tension has all but gone
            begin, end = record.t[[0, -1]]
            t = np.linspace(begin, end + FIT_BEYOND * (end - begin), FIT_LOOKED_AT)
            P = self._predicted(least.x, i, t, True).P
            row = recovered(P, int(np.argmin(P)))
            again = rate_record(record.curve, self.settings.segment, None if row == t.size else float(t[row]))
            squares = {name: float(np.mean(off**2)) for name, off in part.items()}
            sigma = {name: noise_about(mean, 1 - taken, getattr(record, name)) for name, mean in squares.items()}
            records.append(replace(again, sigma=sigma))
        return replace(self, records=tuple(records))

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

    def _with(self, elastic: Values) -> list[Array]:
        """Starts with this elastic part: by the points of w over speed, and by exponents."""
        along = self._along(elastic)
        v, w, *_ = receding(along)
        some = slice(None, None, 1 + v.size // (FIT_ROWS * len(along)))
        through = law_along_records(self.settings.law, v[some], w[some], 1)
        guesses = [] if isinstance(through, Unknown) or through.narrow else [through.values]
        speed = float(np.median(v)) if v.size else float(np.median([record.speed for record in self.records]))
        middle = float(np.median(w)) if w.size else float(np.median(along[0].w[along[0].ok]))
        guesses += [{"w0": middle / 2, "v0": speed, "n": n, "b": middle / 2} for n in FIT_EXPONENTS]
        known = {**self.settings.start, **self.unknowns.fixed}
        return [self._from({**elastic, **guess, **known}, along) for guess in guesses]

    def _from(self, values: Values, along: Sequence[WorkAlong]) -> Array:
        """The unknowns of common ``values``, SI, and the radii at the begins of the records; w ``along`` each."""
        least, most = self.body.nonadhesive.a[[0, -1]] * (1.01, 0.999)
        radii = [np.clip(np.median(item.a[item.ok][:FIT_FIRST]), least, most) for item in along]
        return np.array([*self.unknowns.at(values), *(x for a in radii for x in (math.log(a), 0.0, 0.0))])

    def _along(self, values: Values) -> list[WorkAlong]:
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
            moduli = [free["modulus"] * factor for factor in FIT_SOFTER] + [1.0]
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
        curve = curve.rows(evenly(len(curve), FIT_ROWS))
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
    lines = [f"{one.curve.where}: {line}" for one in fit.records for line in one.curve.doubts]
    low, high = fit.speeds
    of_law = [name for name in rate_parameters(fit.settings.law) if name in fit.free]
    if len(of_law) > 1 and high < WHOLE_DECADE * low:
        lines.append(
            f"the edge's speeds span a factor of {high / low if low else 1:.2g} only ({show(low, 'speed')} to "
            f"{show(high, 'speed')}): less than a decade hardly determines {' and '.join(of_law)}; add other speeds"
        )
    if fit.covariance is None:
        return [*lines, f"the data do not determine {', '.join(fit.free)} together: fix one of them (--fix)"]
    lines += [line for _, _, line in fit.hardly_apart]
    lines += fit.vague([name for name in fit.free if name not in ("delta0", "P0")])
    if fit.scatter > SEARCH_MISFIT:
        lines.append(
            f"residuals of the load are {fit.scatter:.2g} times the scatter from row to row: the law, "
            "the body or the instrument's stiffness does not describe the data; intervals are too narrow"
        )
    return lines

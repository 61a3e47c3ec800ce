"""Load and contact radius of a record at every row as functions of the parameters, with their derivatives.

The path of the edge is that of ``adhesion.rate``; along it the change y_p of log a by a parameter p at fixed time obeys
the linear equation dy/dt = F_u y + F_p of the motion du/dt = F(u, t, p). It is solved on the nodes of the path by
exponential steps, whose error is of second order and bounded where the equation is stiff.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...adhesion import REST, Nonadhesive, Program, RateContact, RateLaw
from ...adhesion.edge import Edge
from ...adhesion.rate.motion import Motion
from ...base import LARGEST_SI, ROUNDED, Array, PiecewiseCubic, zeros_between
from .through import log_rates


@dataclass(frozen=True)
class PredictionTuning:
    """Accuracy of a trace that is compared with readings."""

    tolerance: float = 1e-8  # choice: of the integrator, far below the noise of any record
    evaluations: int = 5_000  # choice: guard, ten times what a retraction takes; beyond it values are far off
    between: int = 4  # choice: nodes per step of the integrator; the steps of the derivatives err by 1e-4 with them
    step: float = 1e-4  # theory: of log v, for the law's slope: the square root of what round-off leaves of it


TUNING = PredictionTuning()

BESIDE = 3  # columns beside the law's: common modulus, what the device holds, its speed; then the radius at the begin


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
        body, law, w0, 0.0, stiffness, tolerance=TUNING.tolerance, evaluations=TUNING.evaluations, slow=0.0
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
    return _readings(edge, u, rates, x, (t - tilt[0]) / tilt[1], speed)


def _moving(
    edge: Edge, piece: Motion, law: RateLaw, w0: float, tilt: tuple[float, float], y: Array, t: Array
) -> tuple[Array, Array, Array, Array]:
    """log a and its derivatives at the times ``t`` of a motion, the derivatives at its end, and the edge's speed."""
    inner = np.arange(TUNING.between) / TUNING.between
    s = np.append((piece.nodes[:-1, None] + np.diff(piece.nodes)[:, None] * inner).ravel(), piece.nodes[-1])
    tau, u = piece.path(s)[:2]
    times, a = piece.ramp.t + piece.unit * tau, np.exp(u)
    v, growth, forcing = _linearised(edge, piece, law, w0, tilt, times, a)
    per_s = piece.unit / np.hypot(1.0, v * piece.unit / a)  # dt/ds
    along = _linear(s, growth * per_s, forcing * per_s, y)
    at = _located(s, PiecewiseCubic(s, times, per_s), t)
    u_rows = PiecewiseCubic(s, u, -v / a * per_s)(at)
    rates = np.stack([np.interp(at, s, row) for row in along])
    return u_rows, rates, along[:, -1], np.interp(at, s, v)


def _linearised(
    edge: Edge, piece: Motion, law: RateLaw, w0: float, tilt: tuple[float, float], t: Array, a: Array
) -> tuple[Array, Array, Array]:
    """Speed v [m/s], F_u [1/s] and F_p (p, n) of du/dt = F = -v(G)/a on the path."""
    x = piece.ramp.at(t)
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
    safe, step = np.where(moves, v, 1.0), TUNING.step
    slope = np.log(law.work(w0, safe * (1 + step)) / law.work(w0, safe * (1 - step))) / (2 * step)  # dlog w/dlog v
    by_G = np.where(moves, 1 / slope, 0.0)  # dlog v/dlog G
    F = -v / a
    shift = np.stack([1 + 2 * lag_s / state.lag, g_x, g_x * (t - tilt[0]) / tilt[1], np.zeros_like(a)])
    by_law = -log_rates(law, w0, safe)
    forcing = F * by_G * np.concatenate([shift, by_law])
    return v, F * (by_G * g_u - 1), forcing


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


def _located(s: Array, times: PiecewiseCubic, t: Array) -> Array:
    """The s, among the nodes ``s``, of the times ``t``."""
    t = np.clip(t, *times(s[[0, -1]]))
    after = np.clip(np.searchsorted(times(s), t), 1, s.size - 1)
    return zeros_between(lambda at: times(at) - t, s[after - 1], s[after], 0.0)


def _readings(edge: Edge, u: Array, rates: Array, x: Array, tilts: Array, speed: Array) -> Prediction:
    """Load and radius, and their derivatives, of log a and its derivatives."""
    touching = u > -np.inf
    ends = edge.body.a[[0, -1]]
    a = np.clip(np.exp(np.where(touching, u, np.log(ends[0]))), *ends)
    state, here = edge.state(a, x), edge.body.parts(a)
    give = 1 / edge.stiffness
    c = 1 + here.S * give
    direct = np.zeros_like(rates)
    direct[0] = state.P - here.S * (here.P_H - state.lag * here.S) * give / c
    direct[1], direct[2] = here.S / c, here.S / c * tilts
    dP = direct - here.dS * state.lag * a / c * rates
    P = np.where(touching, state.P, 0.0)
    return Prediction(
        P, np.where(touching, a, 0.0), np.where(touching, dP, 0.0), np.where(touching, a * rates, 0.0), speed
    )

"""The motion of a contact's edge while the device moves evenly: an ordinary differential equation, da/dt = -+v(G).

Near rest the edge hardly moves for long, at the end it runs away within an instant. So not time but the length s of the
path (t/T, log a) is the independent variable: ds^2 = (dt/T)^2 + (d log a)^2. LSODA changes between Adams' formulae and
the stiff ones of Gear as it goes (Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136). A slow edge is nearly in
equilibrium, its speed that of a small excess G/w0 - 1 of large numbers: the excess is an unknown of its own, with the
slope of G along the path, and drawn to what the state gives.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ...base import MOST_STEPS, Array, SolveError
from ..curve import LOAD_CONTROL, position
from ..edge import Edge
from ..path import ADVANCE, RECEDE, EdgeRule, Follow, Now, Piece
from ..program import Ramp
from .laws import RateLaw


@dataclass(frozen=True)
class MotionTuning:
    """Accuracy and bounds of the integration."""

    # theory: of the excess, over which it is drawn to the state's: its round-off, 1e-16 over this, is an absolute step
    drawn: float = 1e-4
    # tuned on cycles at speed, by `make constants`: of the relative tolerance; the unknowns are scaled to 1
    absolute: float = 1e-2
    fastest: float = 1e200  # theory: in radii per T: a speed beyond numbers, its square must not overflow
    longest: float = 1e15  # theory: of s; beyond it the round-off of a double is longer than a step
    # tuned on cycles at speed, by `make constants`: of a motion's time, at its end: contact runs away, which inertia
    # would delay
    instant: float = 1e-6
    # theory: distances to a fold, over the first, at which a slow edge is looked at; D rises by the square of the last
    nearer: Array = field(default_factory=lambda: np.geomspace(1, 1e-6, 200))


TUNING = MotionTuning()


@dataclass(frozen=True, eq=False)
class Motion(Piece):
    """The path of the edge from one state until it rests, leaves the series or the ramp ends.

    ``path``: of s gives t/T from the ramp's begin on, log a, the works [J] of device and edge over ``energy``, and the
    excess G/w - 1; ``nodes``: the s of the integrator's steps; ``ends``: "ramp", "rest", "lost" or "series".
    """

    rule: ByLaw
    unit: float
    energy: float
    path: Callable[[Array], Array]
    nodes: Array

    @cached_property
    def steps(self) -> Array:
        """The unknowns at the nodes, shape (5, n)."""
        return self.path(self.nodes)

    @property
    def first(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the begin."""
        return self.ramp.t + self.unit * float(self.steps[0, 0]), math.exp(self.steps[1, 0])

    @property
    def last(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the end."""
        t = self.ramp.t_end if self.ends == "ramp" else self.ramp.t + self.unit * float(self.steps[0, -1])
        return t, math.exp(self.steps[1, -1])

    @property
    def work(self) -> float:
        """Work of the device [J]."""
        return self.energy * float(self.steps[2, -1] - self.steps[2, 0])

    @property
    def dissipated(self) -> float:
        """Work of the edge, - int G d(pi a^2) [J]: what is not stored again."""
        return self.energy * float(self.steps[3, -1] - self.steps[3, 0])

    def rows(self, points: int) -> tuple[Array, Array]:
        """Times [s] and radii [m] of ``points`` states, even in s, to the last state."""
        return self._states(np.linspace(self.nodes[0], self._last_reported, points))

    @property
    def parting(self) -> tuple[float, float]:
        """Time [s] and radius [m] of the last state that is reported: the end, or an instant before contact is lost."""
        t, a = self._states(np.array([self._last_reported]))
        return float(t[0]), float(a[0])

    @cached_property
    def _last_reported(self) -> float:
        """The s up to which states are reported."""
        tau, end = self.steps[0], float(self.nodes[-1])
        if self.ends != "lost":
            return end
        until = tau[-1] - TUNING.instant * (tau[-1] - tau[0])
        i = min(int(np.searchsorted(tau, until)), tau.size - 1)
        low = float(self.nodes[max(i - 1, 0)])
        return low if tau[0] == until else float(brentq(lambda s: self.path(s)[0] - until, low, self.nodes[i]))

    def at(self, t: Array) -> Array:
        """Radii [m] at the times ``t`` [s] of the motion: s by Newton's method, from the nodes."""
        tau = np.clip((t - self.ramp.t) / self.unit, self.steps[0, 0], self.steps[0, -1])
        s = np.interp(tau, self.steps[0], self.nodes)
        low, high = self.nodes[[0, -1]]
        for _ in range(MOST_STEPS):
            times, radii = self._states(s)
            rate = self.speeds(radii, self.rule.edge.state(radii, self.ramp.at(times)).G) * self.unit / radii
            step = (tau - (times - self.ramp.t) / self.unit) * np.hypot(1, rate)
            s = np.clip(s + step, low, high)
            if np.max(np.abs(step), initial=0.0) < 1e-12 * (high - low):
                break
        return self._states(s)[1]

    def lowest(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the least load: at an end, or where dP/dt = 0 between two nodes."""
        if self.rule.stiffness == LOAD_CONTROL:
            return self.last if self.ramp.rate < 0 else self.first

        def slope(s: float) -> float:
            return float(self._load_rate(np.array([s]))[0])

        signs = np.sign(self._load_rate(self.nodes))
        inner = [brentq(slope, self.nodes[i], self.nodes[i + 1], xtol=1e-12, rtol=1e-12)
                 for i in np.flatnonzero((signs[:-1] < 0) & (signs[1:] > 0))]  # fmt: skip
        times, radii = self._states(np.array([self.nodes[0], *inner, self.nodes[-1]]))
        i = int(np.argmin(self.rule.edge.state(radii, self.ramp.at(times)).P))
        return float(times[i]), float(radii[i])

    def _load_rate(self, s: Array) -> Array:
        """(1 + S/k) dP/dt [N/s] = S dx/dt - S' L da/dt; of a receding edge by the excess that was followed, which has
        less round-off than the state's."""
        t, a = self._states(s)
        here, state = self.rule.edge.body.parts(a), self.rule.edge.state(a, self.ramp.at(t))
        excess = state.G / self.rule.w - 1 if self.rule.grows else self.path(s)[4]
        return here.S * self.ramp.rate - here.dS * state.lag * self._moving(excess)

    def speeds(self, a: Array, G: Array) -> Array:
        """da/dt [m/s] at energy release rates ``G`` [J/m^2]."""
        return self._moving(G / self.rule.w - 1)

    def _moving(self, excess: Array) -> Array:
        return np.array([self.rule.speed(e) for e in excess.tolist()])

    def _states(self, s: Array) -> tuple[Array, Array]:
        tau, u, *_ = self.path(s)
        ends = self.rule.edge.body.a[[0, -1]]
        return self.ramp.t + self.unit * tau, np.clip(np.exp(u), *ends)


@dataclass(frozen=True, eq=False)
class ByLaw(EdgeRule):
    """An edge that moves by a ``law`` of its speed: infinitely slowly in equilibrium, from which it differs where the
    law's excess of w is more than ``slow``."""

    edge: Edge
    law: RateLaw
    tolerance: float
    evaluations: int
    slow: float

    @cached_property
    def w(self) -> float:
        """Work of adhesion [J/m^2] of an edge at rest."""
        return self.curve.w

    @property
    def forms(self) -> float:
        return float(self.edge.body.a[0])

    def speed(self, excess: float) -> float:
        """da/dt [m/s] where G is ``w (1 + excess)``, within what numbers hold; 0 where the edge rests."""
        if not (excess < 0 if self.grows else excess > 0):
            return 0.0
        beyond = self.w * excess if not self.grows else -self.w * excess / (1 + excess) if excess > -1 else math.inf
        try:
            v = min(self.law.speed(self.w, beyond), TUNING.fastest)
        except OverflowError:
            v = TUNING.fastest
        return v if self.grows else -v

    def move(self, ramp: Ramp, now: Now) -> Motion | Follow:
        slowly = self._slowly(ramp, now)
        if slowly is not None:
            return slowly
        return move(self, ramp, now.t, now.place)

    def _slowly(self, ramp: Ramp, now: Now) -> Follow | None:
        """How far the edge is in equilibrium; None: not at all."""
        a = now.place
        if not (self.slow and ramp.rate and self.stands(now)):
            return None
        if self._excess(ramp, np.array([a]))[0] > self.slow:
            return None
        whole = self.along(ramp, a)
        near = whole.end + (a - whole.end) * TUNING.nearer
        fast = np.flatnonzero(self._excess(ramp, near) > self.slow)
        return whole if not fast.size else replace(whole, end=float(near[fast[0]]), ends="fast", lands=None)

    def _excess(self, ramp: Ramp, a: Array) -> Array:
        """The excess of w over that at rest, at the speed of an edge in equilibrium at the radii ``a`` [m]."""
        rises = position(*self.curve.rates(a), self.stiffness)
        v = np.divide(abs(ramp.rate), rises, out=np.full_like(a, np.inf), where=rises > 0)
        return np.asarray(self.law.work(self.w, v) / self.w - 1)


def move(rule: ByLaw, ramp: Ramp, t: float, a: float) -> Motion:
    """The motion of the edge from radius ``a`` [m] at the time ``t`` [s] of a ``ramp`` on. SolveError where the
    integrator gives up, or takes too many evaluations."""
    unit, tolerance = _unit_of_time(rule, ramp, t, a), rule.tolerance
    energy = math.pi * a**2 * rule.w
    rates = _equations(rule, ramp, unit, energy)
    excess = float(rule.edge.state(np.array(a), np.array(ramp.x + ramp.rate * (t - ramp.t))).G) / rule.w - 1
    start = [(t - ramp.t) / unit, math.log(a), 0.0, 0.0, excess]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "lsoda", UserWarning)  # it gives up, reported below
        try:
            solution = solve_ivp(
                rates, (0.0, TUNING.longest), start, method="LSODA", rtol=tolerance, atol=tolerance * TUNING.absolute,
                dense_output=True, events=_events(rule, ramp, unit),
            )  # fmt: skip
        except OverflowError:  # a step that was tried left all numbers
            raise _unfollowed(a) from None
    if solution.status != 1:
        raise _unfollowed(math.exp(solution.y[1, -1]))
    pressed = ramp.at(ramp.t + unit * solution.y[0, -1]) > 0  # a smaller contact outside the data remains
    names = ("ramp", "series" if rule.grows or pressed else "lost", "rest")
    ends = next(name for name, times in zip(names, solution.t_events, strict=False) if len(times))
    phase = ADVANCE if rule.grows else RECEDE
    return Motion(rule, unit, energy, solution.sol, solution.t, phase=phase, ramp=ramp, ends=ends)


def _unfollowed(a: float) -> SolveError:
    return SolveError(
        f"the edge's motion could not be integrated beyond a = {a:.4g} m: look at v0 and n; a device that is very slow "
        "against v0 makes the cycle without --rate"
    )


def _unit_of_time(rule: ByLaw, ramp: Ramp, t: float, a: float) -> float:
    """T [s]: in which the device moves by the lag at G = w, or where it stands the edge by its radius."""
    if ramp.rate != 0:
        adhesive = rule.edge.position_at(np.array(a), rule.w) - rule.edge.position_at(np.array(a), 0.0)
        return float(abs(adhesive / ramp.rate))
    G = float(rule.edge.state(np.array(a), np.array(ramp.x)).G)
    return a / max(abs(rule.speed(G / rule.w - 1)), a / TUNING.longest)


def _equations(rule: ByLaw, ramp: Ramp, unit: float, energy: float) -> Callable[..., list[float]]:
    """d/ds of t/T, log a, the works of device and edge over ``energy``, and the excess of a receding edge."""
    rate, x0, loaded, edge, w = ramp.rate, ramp.x, rule.stiffness == LOAD_CONTROL, rule.edge, rule.w
    give = edge.give
    count = itertools.count(1)

    def rates(_: float, y: Any) -> list[float]:
        if next(count) > rule.evaluations:
            raise _unfollowed(math.exp(float(y[1])))
        tau, u, _, _, excess = y.tolist()
        a = math.exp(u)
        (_, P_H, S, dS, by_u, bend), lag, c, G = edge.at(u, x0 + rate * unit * tau)
        v = rule.speed(G / w - 1 if rule.grows else excess) * unit
        size = math.hypot(1.0, v / a)
        P = P_H - S * lag
        moved = (lag * v * dS + rate * unit) / S if loaded else rate * unit  # of delta, or of the device
        flows = [1 / size, v / a / size, P * moved / size / energy, -2 * math.pi * a * G * v / size / energy]
        if rule.grows:
            return [*flows, 0.0]
        d_lag = (by_u - lag * a * dS * (1 if loaded else give) / c) * v / a - rate * unit / c
        d_G = G * (bend - 1) * v / a + dS * lag / (2 * math.pi * a) * d_lag
        d_excess = d_G / w / size + (G / w - 1 - excess) / max(abs(excess), TUNING.drawn)
        return [*flows, d_excess]

    return rates


def _events(rule: ByLaw, ramp: Ramp, unit: float) -> list[Callable[..., float]]:
    """What ends a motion: the end of the ramp, the end of the series, and rest where the device moves towards it."""
    end = math.log(rule.edge.body.a[-1 if rule.grows else 0])
    lasts = (ramp.t_end - ramp.t) / unit

    def over(_: float, y: Any) -> float:
        return float(y[0]) - lasts if math.isfinite(lasts) else -1.0

    def out(_: float, y: Any) -> float:
        return float(y[1]) - end

    def rests(_: float, y: Any) -> float:
        return rule.edge.at(float(y[1]), ramp.x + ramp.rate * unit * float(y[0]))[-1] - rule.w

    towards = ramp.rate < 0 if rule.grows else ramp.rate > 0
    events: list[Callable[..., float]] = [over, out, *([rests] if towards else [])]
    for event in events:
        event.terminal = True  # type: ignore[attr-defined]
    over.direction = 1  # type: ignore[attr-defined]
    out.direction = rests.direction = 1 if rule.grows else -1  # type: ignore[attr-defined]
    return events

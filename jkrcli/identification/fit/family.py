"""The adhesive curves of one body for every modulus factor and every work of adhesion.

With all moduli multiplied by s and work of adhesion w (Eq. 13)
    delta = D(a) - v T(a)        P = s (H(a) - v V(a))        v = sqrt(w/s)
D, H: delta_H and P_H of the series; T = sqrt(4 pi a/S'), V = S T: its adhesive parts at w = 1 J/m^2. So where the edge
moves. While the contact grows it advances with w_a, while it shrinks it recedes with w_r >= w_a; between the two it
rests at the contact radius a_m of the turn, sqrt(w_a/s) <= v <= sqrt(w_r/s): on (delta, P) a straight line.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from ...adhesion import Nonadhesive, Slopes
from ...base import ROWS, Array
from ...series import Series

FUNCTIONS = 4  # D, T, H, V
ADVANCING, RESTING, RECEDING = range(3)  # what the edge does at a row
LOADS = np.array([[0.0], [0.0], [1.0], [1.0]])  # of these the parts of the load


class Member(Protocol):
    """One adhesive curve of a body over u, the log of a place on it [m]: states (a [m], delta [m], P [N])."""

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        """u between which measured points are sought, so far beyond the fold and the end of the series, and down to
        the ``least`` radius that was measured [m], if any."""

    def refuse_beyond(self, a: float) -> None:
        """Refusal where the curve does not reach the contact radius ``a`` [m]."""

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """The states and their first and second derivatives by u, each of shape (3, n)."""

    def rates(self, u: Array) -> Mapping[str, Array]:
        """Derivatives (3, n) of the states by the log of the modulus factor "modulus", by "w", and by the log of what
        else the curve depends on, the body's own parameters that vary among it."""


class Members(Protocol):
    """The adhesive curves of one body by the values of the parameters, SI; ``plain``: its family without a range of
    adhesion."""

    @property
    def plain(self) -> Family: ...

    def member(self, values: Mapping[str, float], drift: Drift | None = None) -> Member:
        """The curve of these values, with a ``drift`` of one of them along the record where the family knows it."""


@dataclass(frozen=True, eq=False)
class Family:
    """log D, log T, log H, log V over u = log a (a in m) with two derivatives; power laws beyond the ends.

    ``low, high``: log of the smallest and largest contact radius of the series. ``rates``: derivatives of the same four
    logs by those of the body's own parameters that vary, by name.
    """

    logs: PPoly
    low: float
    high: float
    rates: Mapping[str, PPoly] | None = None

    @classmethod
    def of(cls, series: Series, slopes: Slopes) -> Family:
        """The family of a series, at the nodes of its own evaluator."""
        body = Nonadhesive(series, slopes)
        u = body.logs.slopes.x
        a = np.clip(np.exp(u), series.a[0], series.a[-1])
        here, rate = body.with_rates(a)
        values = np.stack([here.delta_H, here.t, here.P_H, here.S * here.t], axis=1)
        rates = np.stack([rate.delta_H, rate.t, rate.P_H, rate.S * here.t + here.S * rate.t], axis=1)
        logs = CubicHermiteSpline(u, np.log(values), a[:, None] * rates / values)
        return cls(_with_derivatives(_extended(logs)), float(u[0]), float(u[-1]))

    @property
    def plain(self) -> Family:
        return self

    def member(self, values: Mapping[str, float], drift: Drift | None = None) -> JKRMember:
        return JKRMember(self, values["modulus"], values["w"], drift)

    def neck(self, s: float, w: float) -> float:
        """What adhesion adds to the displacement where the load is least [m], for JKR."""
        _, T, H, V = self.at(np.linspace(self.low, self.high, ROWS))[0]
        return float(np.sqrt(w / s) * T[np.argmin(s * H - np.sqrt(w * s) * V)])

    @property
    def natural_work(self) -> float:
        """The w [J/m^2] that shifts the body at half of its largest radius by its own displacement."""
        D, T, _, _ = self.at(np.array([self.high - np.log(2)]))[0][:, 0]
        return float((D / T) ** 2)

    def rate_to(self, moved: Family, step: float) -> PPoly:
        """The change of the four logs towards a ``moved`` family, per ``step`` of a parameter."""
        return PPoly((moved.logs.c - self.logs.c)[..., :FUNCTIONS] / step, self.logs.x)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        """(D, T, H, V) and their first and second derivatives by u, each of shape (4, n)."""
        logs = self.logs(u).T
        values = np.exp(logs[:FUNCTIONS])
        first, second = logs[FUNCTIONS : 2 * FUNCTIONS], logs[2 * FUNCTIONS :]
        return values, values * first, values * (second + first**2)

    def at_nodes(self, u: Array) -> tuple[Array, Array, Array]:
        """The same at evenly spaced nodes."""
        return self.at(u)

    def own_rates(self, u: Array) -> Mapping[str, Array]:
        """Derivatives of log (D, T, H, V) (4, n) by the logs of the body's own parameters."""
        return {name: rate(u).T for name, rate in (self.rates or {}).items()}


@dataclass(frozen=True)
class Drift:
    """w and the moduli times 1 + change times the place on the record: 0 at the contact radius ``low``, 1 at ``high``
    [m], less ``centre``."""

    name: str
    change: float
    centre: float
    low: float
    high: float

    def factor(self, a: Array) -> Array:
        """What w or the moduli are multiplied by at contact radii ``a`` [m]; even beyond the record."""
        return 1 + self.change * (np.clip((a - self.low) / (self.high - self.low), -0.2, 1.2) - self.centre)

    def applied(self, functions: tuple[Array, Array, Array], u: Array) -> tuple[Array, Array, Array]:
        """The family's functions (D, T, H, V) and their derivatives by u = log a with this drift."""
        a, factor = np.exp(u), self.factor(np.exp(u))
        rate = self.change * a / (self.high - self.low) / factor
        power = np.array(DRIFTS[self.name])[:, None]
        first, second = power * rate, power * rate * (1 - rate)
        value, by_u, by_uu = functions
        g = factor**power
        return g * value, g * (by_u + first * value), g * (by_uu + 2 * first * by_u + (second + first**2) * value)


DRIFTS = {"w": (0.0, 0.5, 0.0, 0.5), "modulus": (0.0, -0.5, 1.0, 0.5)}  # theory: powers of w and moduli in the family


def states(a: Array | float, functions: Array, s: float, v: Array | float) -> Array:
    """(a, delta, P) of functions (D, T, H, V), or derivatives of them: v = sqrt(w/s) where the edge moves."""
    D, T, H, V = functions
    delta = D - v * T
    all_three = np.empty((3, *delta.shape))
    all_three[0], all_three[1], all_three[2] = a, delta, s * (H - v * V)
    return all_three


def of_v(functions: Array, s: float, v: Array | float) -> Array:
    """Derivatives of the ``states`` by the log of v."""
    _, T, _, V = functions
    return states(0.0, np.stack([0 * T, T, 0 * T, V]), s, v)


@dataclass(frozen=True, eq=False)
class JKRMember:
    """The curve of a ``family`` for the modulus factor ``s`` and the work of adhesion ``w`` [J/m^2], over u = log a;
    ``drift``: of w or of the moduli along the record."""

    family: Family
    s: float
    w: float
    drift: Drift | None

    @property
    def v(self) -> float:
        return math.sqrt(self.w / self.s)

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        whole = np.linspace(self.family.low - below_fold, self.family.high, ROWS)
        (D, T, _, _), _, _ = self.family.at(whole)
        fold = whole[np.argmin(D - self.v * T)]
        below = fold - below_fold if least is None else min(fold - below_fold, np.log(least))
        return float(max(below, whole[0])), self.family.high + beyond_last

    def functions(self, u: Array) -> tuple[Array, Array, Array]:
        """(D, T, H, V) and their derivatives by u."""
        functions = self.family.at(u)
        return functions if self.drift is None else self.drift.applied(functions, u)

    def refuse_beyond(self, a: float) -> None:
        """Nothing is refused: beyond the series power laws go on, and the search itself looks at where it ends."""

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        first, second, third = (states(np.exp(u), functions, self.s, self.v) for functions in self.functions(u))
        return first, second, third

    def rates(self, u: Array) -> Mapping[str, Array]:
        here = self.functions(u)[0]
        by_v, own = of_v(here, self.s, self.v), self.family.own_rates(u)
        rates = {name: states(0.0, here * rate, self.s, self.v) for name, rate in own.items()}
        by_w = by_v / (2 * self.w) if self.w > 0 else 0 * by_v  # a free w stays above 0
        return rates | {"modulus": states(0.0, here * LOADS, self.s, self.v) - by_v / 2, "w": by_w}


@dataclass(frozen=True, eq=False)
class RestingMember:
    """The readings of an edge at rest at contact radius ``turn`` [m] for moduli times ``s``, over u = v/``unit``."""

    family: Family
    s: float
    turn: float
    drift: Drift | None

    @cached_property
    def functions(self) -> tuple[Array, Array]:
        """(D, T, H, V) at the turn, and their derivatives by its log, (4, 1)."""
        return JKRMember(self.family, self.s, 0.0, self.drift).functions(np.log([self.turn]))[:2]

    @property
    def unit(self) -> float:
        """The v that shifts the contact by its own displacement."""
        D, T, _, _ = self.functions[0][:, 0]
        return float(D / T)

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        return -1.0, 3.0  # several times what a stable edge holds

    def refuse_beyond(self, a: float) -> None:
        """Nothing is refused."""

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        here = states(self.turn, self.functions[0], self.s, self.unit * u)
        return here, np.broadcast_to(of_v(self.functions[0], self.s, self.unit), here.shape), np.zeros_like(here)

    def rates(self, u: Array) -> Mapping[str, Array]:
        here, by_turn = self.functions
        changes = {name: here * rate for name, rate in self.family.own_rates(np.log([self.turn])).items()}
        rates = {
            name: states(0.0, by, self.s, self.unit * u) for name, by in (changes | {"modulus": here * LOADS}).items()
        }
        return rates | {"a_turn": states(self.turn, by_turn, self.s, self.unit * u)}


def _extended(logs: CubicHermiteSpline) -> PPoly:
    """The cubics with a straight line added at each end, far enough for any foot point."""
    ends, width = logs.x[[0, -1]], logs.x[-1] - logs.x[0] + 1
    before, after = np.zeros((2, *logs.c.shape[::2]))
    before[2:] = logs(ends[0], 1), logs(ends[0]) - width * logs(ends[0], 1)
    after[2:] = logs(ends[1], 1), logs(ends[1])
    c = np.concatenate([before[:, None], logs.c, after[:, None]], axis=1)
    return PPoly(c, np.concatenate([[ends[0] - width], logs.x, [ends[1] + width]]))


def _with_derivatives(logs: PPoly) -> PPoly:
    """One piecewise cubic that gives values, first and second derivatives in one evaluation."""
    zero = np.zeros_like(logs.c[:1])
    first, second = logs.derivative(1).c, logs.derivative(2).c
    return PPoly(
        np.concatenate([logs.c, np.concatenate([zero, first]), np.concatenate([zero, zero, second])], 2), logs.x
    )

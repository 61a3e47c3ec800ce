"""The edge of a contact in a device: its energy release rate at every radius and position of the device.

A device of stiffness k prescribes its position x = delta + P/k (load control: x = P). With the lag L = delta_H - delta
of the displacement behind the nonadhesive one, P = P_H - S L (Eq. 13), so that x = x_H - c L with c = 1 + S/k (load
control: c = S) and G = S' L^2/(4 pi a), at once for every radius, in equilibrium or not.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base import Array
from .curve import LOAD_CONTROL, AdhesiveCurve, position
from .nonadhesive import Nonadhesive


class EdgeState(NamedTuple):
    """Displacement ``delta`` [m], load ``P`` [N], energy release rate ``G`` [J/m^2] and lag [m] at some radii."""

    delta: Array
    P: Array
    G: Array
    lag: Array


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge of the contact of a ``body`` in a device of ``stiffness`` [N/m] (0: load control, infinite: rigid)."""

    body: Nonadhesive
    stiffness: float

    def state(self, a: Array, x: Array) -> EdgeState:
        """The state at the radii ``a`` [m] and the device's positions ``x``."""
        here = self.body.parts(a)
        lag = (position(here.delta_H, here.P_H, self.stiffness) - x) / self._give(here.S)
        P = here.P_H - here.S * lag if self.stiffness != LOAD_CONTROL else np.broadcast_to(x, lag.shape)
        return EdgeState(here.delta_H - lag, P, here.dS * lag**2 / (4 * math.pi * a), lag)

    def position_at(self, a: Array, G: float) -> Array:
        """The device's position where the edge at radius ``a`` [m] has the energy release rate ``G``."""
        here = self.body.parts(a)
        return position(here.delta_H, here.P_H, self.stiffness) - self._give(here.S) * math.sqrt(G) * here.t

    def _give(self, S: Array) -> Array:
        """c = -dx/dL at constant radius: 1 + S/k, under load control S [N/m]."""
        return position(np.ones_like(S), S, self.stiffness)

    def stored(self, first: tuple[float, float], last: tuple[float, float]) -> float:
        """Change of the elastic energy [J] of body and device from one state (a, x) to another.

        U = int P_H d(delta_H) - P_H L + S L^2/2, as dU = P d(delta) + G d(pi a^2); the device's spring has P^2/(2 k).
        """
        return self.free.work(first[0], last[0]) + self._beside(*last) - self._beside(*first)

    @cached_property
    def free(self) -> AdhesiveCurve:
        """The contact without adhesion."""
        return AdhesiveCurve(self.body, 0.0)

    def _beside(self, a: float, x: float) -> float:
        here, state = self.body.parts(np.array(a)), self.state(np.array(a), np.array(x))
        spring = 0.0 if self.stiffness in (LOAD_CONTROL, math.inf) else float(state.P) ** 2 / (2 * self.stiffness)
        return float(-here.P_H * state.lag + here.S * state.lag**2 / 2) + spring

    def at(self, u: float, x: float) -> tuple[tuple[float, ...], float, float, float]:
        """The ``pointwise`` functions at one radius, log a = ``u``, the lag [m] (none below 0), c and G [J/m^2] there
        at the device's position ``x``: ``state`` in plain floats."""
        here = self.pointwise(u)
        delta_H, P_H, S, dS, *_ = here
        loaded = self.stiffness == LOAD_CONTROL
        c = S if loaded else 1 + S * self.give
        lag = max(((P_H if loaded else delta_H + P_H * self.give) - x) / c, 0.0)
        return here, lag, c, dS * lag * lag / (4 * math.pi * math.exp(u))

    @cached_property
    def give(self) -> float:
        """1/k [m/N] of the device; 0 where it is rigid, or prescribes the load."""
        return 0.0 if self.stiffness in (LOAD_CONTROL, math.inf) else 1 / self.stiffness

    @cached_property
    def pointwise(self) -> Pointwise:
        """The functions of the body at one radius at a time."""
        return Pointwise.of(self.body)


@dataclass(frozen=True, eq=False)
class Pointwise:
    """delta_H [m], P_H [N], S [N/m], S' [N/m^2] at one radius, in plain floats: the rule of ``Nonadhesive.parts``, at a
    thirtieth of the cost of arrays of one. ``a0``: radius of first contact [m]."""

    nodes: list[float]
    starts: list[float]
    cubics: Array
    a0: float
    known: dict[int, list[list[float]]] = field(default_factory=dict)  # those used by now, as lists

    @classmethod
    def of(cls, body: Nonadhesive) -> Pointwise:
        columns, slopes = body.logs
        cubics = np.concatenate([columns.c, slopes.c], axis=2)  # (order, interval, function)
        return cls(slopes.x.tolist(), columns.x.tolist(), cubics.transpose(1, 2, 0), body.series.a0)

    def __call__(self, u: float) -> tuple[float, float, float, float, float, float]:
        """The four functions at log a = ``u``, and d(delta_H)/du [m] and d(log S')/du; the outer cubics go on beyond
        the ends."""
        i = min(max(bisect_right(self.nodes, u) - 1, 0), len(self.cubics) - 1)
        if i not in self.known:
            self.known[i] = self.cubics[i].tolist()
        y, beyond = u - self.nodes[i], math.exp(u) - self.a0
        z = (math.log(beyond) if self.a0 else u) - self.starts[i]
        delta, P, S, dS = self.known[i]
        delta_H = _exp(delta, z)
        rate = delta_H * _slope(delta, z) * (1 + self.a0 / beyond)
        return delta_H, _exp(P, z), _exp(S, y), _exp(dS, y), rate, _slope(dS, y)


def _exp(cubic: list[float], x: float) -> float:
    c3, c2, c1, c0 = cubic
    return math.exp(((c3 * x + c2) * x + c1) * x + c0)


def _slope(cubic: list[float], x: float) -> float:
    c3, c2, c1, _ = cubic
    return (3 * c3 * x + 2 * c2) * x + c1

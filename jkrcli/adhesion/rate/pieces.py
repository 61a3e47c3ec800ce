"""Pieces of a history without a differential equation: no contact, a resting edge, equilibrium on advance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from ...base.arrays import Array
from ..curve import AdhesiveCurve
from ..device import LOAD_CONTROL, position
from ..passage import spring, work
from .edge import Edge
from .program import Ramp


class Piece(Protocol):
    """What the contact does on one ``ramp``, from ``first`` to ``last``: time [s] and radius [m], 0 out of contact."""

    @property
    def phase(self) -> str: ...
    @property
    def ramp(self) -> Ramp: ...
    @property
    def first(self) -> tuple[float, float]: ...
    @property
    def last(self) -> tuple[float, float]: ...
    @property
    def work(self) -> float:
        """Work of the device [J]; under load control of the load."""

    @property
    def dissipated(self) -> float:
        """- int G d(pi a^2) [J]."""

    def rows(self, points: int) -> tuple[Array, Array]:
        """Times [s] and radii [m] of at most ``points`` states."""

    def at(self, t: Array) -> Array:
        """Radii [m] at the times ``t`` [s] of the piece."""

    def lowest(self) -> tuple[float, float]:
        """Time [s] and radius [m] at the least load."""

    def speeds(self, a: Array, G: Array) -> Array:
        """da/dt [m/s] at radii ``a`` [m] and energy release rates ``G`` [J/m^2] of the piece."""


@dataclass(frozen=True)
class Rest:
    """The edge rests at the radius ``a`` [m] between two times [s]: P, delta and x lie on one straight line."""

    edge: Edge
    ramp: Ramp
    a: float
    t: float
    t_end: float
    x: float
    x_end: float
    phase: str = "rest"
    dissipated: float = 0.0

    @property
    def first(self) -> tuple[float, float]:
        return self.t, self.a

    @property
    def last(self) -> tuple[float, float]:
        return self.t_end, self.a

    @property
    def work(self) -> float:
        ends = self.edge.state(np.full(2, self.a), np.array([self.x, self.x_end]))
        moved = ends.delta if self.edge.stiffness == LOAD_CONTROL else np.array([self.x, self.x_end])
        return float((ends.P[0] + ends.P[1]) / 2 * (moved[1] - moved[0]))

    def rows(self, points: int) -> tuple[Array, Array]:
        t = np.linspace(self.t, self.t_end, points)
        return t, np.full(points, self.a)

    def at(self, t: Array) -> Array:
        return np.full(t.shape, self.a)

    def lowest(self) -> tuple[float, float]:
        return self.first if self.x < self.x_end else self.last

    def speeds(self, a: Array, G: Array) -> Array:
        return np.zeros_like(a)


@dataclass(frozen=True)
class Free:
    """No contact between two times [s]."""

    ramp: Ramp
    t: float
    t_end: float
    phase: str = "free"
    work: float = 0.0
    dissipated: float = 0.0

    @property
    def first(self) -> tuple[float, float]:
        return self.t, 0.0

    @property
    def last(self) -> tuple[float, float]:
        return self.t_end, 0.0

    def rows(self, points: int) -> tuple[Array, Array]:
        t = np.linspace(self.t, self.t_end, points)
        return t, np.zeros(points)

    def at(self, t: Array) -> Array:
        return np.zeros(t.shape)

    def lowest(self) -> tuple[float, float]:
        return self.first

    def speeds(self, a: Array, G: Array) -> Array:
        return np.zeros_like(a)


@dataclass(frozen=True, eq=False)
class Follow:
    """The edge in equilibrium at the work of adhesion of advance, from radius ``a`` to ``a_end`` [m]: it follows the
    device as fast as this moves. On a step, an instant: it comes to equilibrium at ``a``."""

    edge: Edge
    curve: AdhesiveCurve
    ramp: Ramp
    a: float
    a_end: float
    phase: str = "advance"

    @property
    def first(self) -> tuple[float, float]:
        return self._time(self.a), self.a

    @property
    def last(self) -> tuple[float, float]:
        return self._time(self.a_end), self.a_end

    @property
    def work(self) -> float:
        along, k = work(self.curve, self.a, self.a_end), self.edge.stiffness
        return along if k == LOAD_CONTROL else along + spring(self.curve, k, self.a, self.a_end)

    @property
    def dissipated(self) -> float:
        return -float(np.pi) * self.curve.w * (self.a_end**2 - self.a**2)

    def rows(self, points: int) -> tuple[Array, Array]:
        if self.ramp.is_step:
            return np.array([self.ramp.t]), np.array([self.a])
        a = np.linspace(self.a, self.a_end, points)
        return self.ramp.t + (self._held(a) - self.ramp.x) / self.ramp.rate, a

    def at(self, t: Array) -> Array:
        if self.ramp.is_step:
            return np.full(t.shape, self.a)
        return np.array([self._radius(float(x)) for x in np.atleast_1d(self.ramp.at(t))])

    def lowest(self) -> tuple[float, float]:
        inner = [point.a for point in self.curve.critical(LOAD_CONTROL) if self.a < point.a < self.a_end]
        a = np.array([self.a, *inner, self.a_end])
        best = float(a[np.argmin(self.curve.at(a)[1])])
        return self._time(best), best

    def speeds(self, a: Array, G: Array) -> Array:
        rising = position(*self.curve.rates(a), self.edge.stiffness)
        rate = 0.0 if self.ramp.is_step else self.ramp.rate
        return np.divide(rate, rising, out=np.full_like(a, np.inf), where=rising > 0)

    def _held(self, a: Array) -> Array:
        return position(*self.curve.at(a), self.edge.stiffness)

    def _time(self, a: float) -> float:
        return self.ramp.when(float(self._held(np.array(a))))

    def _radius(self, x: float) -> float:
        def excess(a: float) -> float:
            return float(self._held(np.array(a))) - x

        if excess(self.a) >= 0:
            return self.a
        return self.a_end if excess(self.a_end) <= 0 else float(brentq(excess, self.a, self.a_end, xtol=0, rtol=1e-14))

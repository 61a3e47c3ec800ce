"""The path of a contact at a device: advancing, resting and receding edge, as loads over the device's position.

At position z of a device of stiffness k, delta = z - P/k. With L = delta_H - delta and r = sqrt(w/s) for moduli times s
an edge that moves has L = r T: delta = D - r T, P = s (H - r V). Where the device turns, at contact radius a_m, the
edge rests: P = P_m + S(a_m) (delta - delta_m), until the energy release rate has come to the w of the other way; then
it recedes, down to the fold d(delta + P/k)/da = 0. As w -> 0 the load of a moving edge is linear in w,
dP/dw = -2 pi a/(d delta_H/da): that goes on below 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...base import LOOKED_AT, MOST_STEPS, REMEMBERED, SAME, SETTLED, Array, SolveError, show
from .family import Family


@dataclass(frozen=True)
class DevicePathTuning:
    """How far branches are tabulated, and steps along them."""

    polished: int = 4  # theory: steps of Newton's method, which square the error, from a tenth of a step to 1e-16
    below: float = 4.0  # choice: of log a below the series, where its limit by power laws holds
    beyond: float = 0.5  # choice: of log a above the series, tried while starting values are sought; no step is longer


TUNING = DevicePathTuning()
Changes = Callable[[Array], Array]  # of the logs of D, T, H, V over u, (4, n), per amount of what differs


# Quintics through values and two derivatives at 0 and at 1 (rows), by powers of x (columns):
HERMITE = np.array([[1, 0, 0, -10, 15, -6], [0, 1, 0, -6, 8, -3], [0, 0, 0.5, -1.5, 1.5, -0.5],
                    [0, 0, 0, 10, -15, 6], [0, 0, 0, -4, 7, -3], [0, 0, 0, 0.5, -1, 0.5]])  # fmt: skip


def grid(family: Family) -> Array:
    """Logs of contact radii at which paths are tabulated; loads between them are good to 1e-7 of the largest."""
    return _between(family.low, family.high)


@lru_cache(maxsize=REMEMBERED)
def _between(low: float, high: float) -> Array:
    return np.linspace(low - TUNING.below, high + TUNING.beyond, LOOKED_AT)


@lru_cache(maxsize=REMEMBERED)
def on_grid(family: Family) -> tuple[Array, Array, Array]:
    """The functions of a body there, as ``Family.at`` gives them."""
    return family.at_nodes(grid(family))


@dataclass(frozen=True, eq=False)
class Nodes:
    """The functions of a ``family`` at the nodes ``u`` of its grid, for paths of any moduli and any w on it: D, T, H, V
    and two derivatives by u (4, 3, nodes); ``released``: V' T - V T', by which loads change with q."""

    family: Family
    u: Array
    functions: Array
    released: Array

    @classmethod
    @lru_cache(maxsize=REMEMBERED)
    def of(cls, family: Family) -> Nodes:
        functions = np.stack(on_grid(family), axis=1)
        (T, dT, _), (V, dV, _) = functions[1], functions[3]
        return cls(family, grid(family), functions, dV * T - V * dT)

    def at(self, u: float) -> Array:
        """D, T, H, V and their derivatives at one place (3, 4), good to rounding."""
        place = (u - float(self.u[0])) / float(self.u[1] - self.u[0])
        i = math.floor(place)
        if not 0 <= i < self.u.size - 1:
            return np.stack(self.family.at(np.array([u])))[..., 0]
        x, per = place - i, (self.u.size - 1) / float(self.u[-1] - self.u[0])
        value, first, second = self.functions[..., i : i + 2].transpose(1, 2, 0)
        rate = first / value
        logs = np.stack([np.log(value), rate / per, (second / value - rate**2) / per**2], axis=1)
        x2, x3, per2 = x * x, x * x * x, per * per
        powers = np.array([
            [1, x, x2, x3, x2 * x2, x2 * x3], [0, per, 2 * x * per, 3 * x2 * per, 4 * x3 * per, 5 * x2 * x2 * per],
            [0, 0, 2 * per2, 6 * x * per2, 12 * x2 * per2, 20 * x3 * per2],
        ])  # fmt: skip
        functions: Array = powers @ (HERMITE.T @ logs.reshape(6, 4))
        functions[0] = np.exp(functions[0])
        functions[2] += functions[1] ** 2
        functions[1:] *= functions[0]
        return functions


def _path(s: float, r: float, k: float, functions: Array) -> Array:
    """Position and load of an edge that moves, by ``functions`` D, T, H, V (4, ...)."""
    of_four = np.array([[1.0, -r, s / k, -s * r / k], [0.0, 0.0, s, -s * r]])
    path: Array = (of_four @ functions.reshape(4, -1)).reshape(2, *functions.shape[1:])
    return path


@dataclass(frozen=True, eq=False)
class DeviceBranch:
    """The stable branch of one body at a device, on which the edge moves: load over zeta = sqrt(z - fold), where it is
    smooth, of a body at ``nodes`` with moduli times ``s`` and ``r`` the root of q.

    ``fold`` [m]: where it ends; ``u``: log of the contact radius [m] along it, ``steep``: zeta over the derivative of z
    by it, ``slope``: derivative of the load by zeta; ``released`` as of ``nodes``. ``below``: q where it is negative,
    else 0; ``k`` of the device.
    """

    fold: float
    u: Array
    zeta: Array
    P: Array
    slope: Array
    steep: Array
    released: Array
    below: float
    k: float
    s: float
    r: float
    nodes: Nodes

    @cached_property
    def parts(self) -> Array:
        """What D, T, H and V have of displacement and load (4, n)."""
        D, T, H, V = self.nodes.family.at(self.u)[0]
        return np.stack([D, self.r * T, self.s * H, self.s * self.r * V])

    @cached_property
    def cubics(self) -> Array:
        """Between nodes: where they begin, the inverse width, and the load's coefficients of a cubic (6, n - 1)."""
        first, left, cubics = self.zeta[:-1], self.P[:-1], np.empty((6, self.zeta.size - 1))
        width, rise = self.zeta[1:] - first, self.P[1:] - left
        cubics[0], cubics[1], cubics[2], cubics[3] = first, 1 / width, left, self.slope[:-1] * width
        cubics[5] = cubics[3] + self.slope[1:] * width - 2 * rise
        cubics[4] = rise - cubics[3] - cubics[5]
        return cubics

    @cached_property
    def rates(self) -> Array:
        """Derivatives of the load at fixed z by ln s and q = w/s, times zeta, between nodes: value and change (4, n -
        1)."""
        by_s, by_q = self.zeta * self.P - self.slope * self.P / (2 * self.k), -self.s / 2 * self.released * self.steep
        return np.stack([by_s[:-1], by_q[:-1], by_s[1:] - by_s[:-1], by_q[1:] - by_q[:-1]])

    def load(self, z: Array, blunt: float) -> Array:
        """Load at positions ``z`` [m], as ``at`` gives it."""
        if self.below:
            return self.at(z, blunt)[0]
        return self._load(z, blunt)[0]

    def _load(self, z: Array, blunt: float) -> tuple[Array, Array, Array, Array, Array]:
        """Load at positions ``z`` [m] and its derivative by them, for w = 0 where w is less; zeta there, the nodes
        before, and the place between two."""
        zeta = np.sqrt(np.maximum(z - self.fold, blunt))
        i = np.minimum(np.maximum(self.zeta.searchsorted(zeta) - 1, 0), self.zeta.size - 2)
        first, per, c0, c1, c2, c3 = self.cubics[:, i]
        x = (zeta - first) * per
        by_z = (c1 + x * (2 * c2 + 3 * x * c3)) * per / (2 * zeta)
        return c0 + x * (c1 + x * (c2 + x * c3)) + by_z * (z - self.fold - zeta**2), by_z, zeta, i, x

    def at(self, z: Array, blunt: float) -> tuple[Array, Array]:
        """Load at positions ``z`` [m], and its derivatives by ln s, q and z, (3, n).

        From ``blunt`` [m] before the fold on the tangent there goes on: a load for every position, and a search that
        sees where the fold should be.
        """
        P, by_z, zeta, i, x = self._load(z, blunt)
        s0, q0, s1, q1 = self.rates[:, i]
        by_s, by_q = (s0 + s1 * x) / zeta, (q0 + q1 * x) / zeta
        if self.below:
            bent = (q1 * self.cubics[1, i] - by_q) / (2 * zeta**2)
            P, by_s, by_z = P + self.below * by_q, by_s + self.below * by_q, by_z + self.below * bent
        return P, np.stack([by_s, by_q, by_z])

    def radii(self, z: Array) -> Array:
        """Contact radii [m] at positions ``z`` [m], that of the fold before it."""
        a: Array = np.interp(np.sqrt(np.maximum(z - self.fold, 0.0)), self.zeta, np.exp(self.u))
        return a

    def by_body(self, z: Array, blunt: float, changes: Changes) -> Array:
        """Derivative of the load at positions ``z`` [m] by an amount of ``changes`` of the body."""
        zeta = np.sqrt(np.maximum(z - self.fold, blunt))
        D, T, H, V = changes(self.u) * self.parts
        rate = self.zeta * (H - V) - self.slope / 2 * (D - T + (H - V) / self.k)
        dP: Array = np.interp(zeta, self.zeta, rate) / zeta
        return dP


@lru_cache(maxsize=REMEMBERED)
def branch(family: Family, s: float, q: float, k: float) -> DeviceBranch:
    """The stable branch for moduli times ``s`` and work of adhesion ``q`` s, by a device of stiffness ``k``: at the
    fold and at radii of the grid beyond."""
    nodes, r = Nodes.of(family), math.sqrt(max(q, 0.0))
    path = _path(s, r, k, nodes.functions)
    i, start = _fold(nodes.u, path[0, 1], path[0, 2])
    first = nodes.at(start)
    path[..., i - 1] = _path(s, r, k, first.T)
    (z, dz, _), (P, dP, _) = path[..., i - 1 :]
    u, released = nodes.u[i - 1 :].copy(), nodes.released[i - 1 :].copy()
    u[0], released[0] = start, first[1, 3] * first[0, 1] - first[0, 3] * first[1, 1]
    zeta = np.sqrt(np.maximum.accumulate(z - z[0]))
    steep = np.divide(zeta, dz, out=np.zeros_like(z), where=dz > 0)
    bend = float(path[0, 2, i - 1])
    if i > 1 and bend > 0:
        steep[0] = 1 / math.sqrt(2 * bend)  # its limit at the fold, where z is a parabola of u
    slope, up = 2 * dP * steep, zeta[1:] > zeta[:-1]
    if not up.any():
        raise SolveError(
            f"no contact is stable at this w up to a = {show(math.exp(u[-1]), 'length')}: take a smaller w, or check "
            "the radius and the units"
        )
    if not up.all():
        up = np.append(True, up)
        u, zeta, P, slope, steep, released = (one[up] for one in (u, zeta, P, slope, steep, released))
    return DeviceBranch(float(z[0]), u, zeta, P, slope, steep, released, min(q, 0.0), k, s, r, nodes)


def _fold(u: Array, rates: Array, bends: Array) -> tuple[int, float]:
    """Where the position, of derivatives ``rates`` and ``bends`` on ``u``, turns to rise for good: the first node that
    is well beyond, and the place, a root of the cubic through two nodes; the first u where it rises or falls on all."""
    falling = np.flatnonzero(rates <= 0)
    if not falling.size or falling[-1] == u.size - 1:
        return 1, float(u[0])
    i, step = int(falling[-1]), float(u[1] - u[0])
    left, right, dl, dr = (float(item) for item in (rates[i], rates[i + 1], step * bends[i], step * bends[i + 1]))
    x, a, b = left / (left - right), 2 * (left - right) + dl + dr, 3 * (right - left) - 2 * dl - dr
    for _ in range(TUNING.polished):
        slope = dl + x * (2 * b + 3 * x * a)
        x = min(max(x - (left + x * (dl + x * (b + x * a))) / slope, 0.0), 1.0) if slope > 0 else x
    return i + 1 + round(x), float(u[i]) + x * step


@dataclass(frozen=True, eq=False)
class Rest:
    """The straight line on which the edge rests at one contact radius e^``u``: load ``P`` + ``by_z`` z [N].

    ``end`` [m]: the position below which it recedes. ``by_u``: of u's place in the record: its derivatives by ln s, by
    the root of q with which it advanced, and by the position of the turn. ``S, dS``: contact stiffness and its
    derivative by u [N/m]; ``D``: displacement without adhesion [m], ``P_H``: load; ``shift``: of the advancing edge by
    adhesion [m]; ``k`` of the device.
    """

    u: float
    end: float
    by_u: tuple[float, float, float]
    D: float
    P_H: float
    S: float
    dS: float
    shift: float
    k: float

    def released(self, receding: float, z: float) -> float:
        """The root of q that a row at ``z`` [m] holds, where ``receding`` is that at the end."""
        return receding + (self.end - z) * self.by_u[2] / self.by_u[1]

    def load(self, z: Array) -> Array:
        """Load at positions ``z`` [m]."""
        P: Array = (self.P_H - self.S * (self.D - z)) / (1 + self.S / self.k)
        return P

    def at(self, z: Array) -> tuple[Array, Array]:
        """Load at positions ``z`` [m], and its derivatives by ln s, the root of q, z, and the position of the turn."""
        yields, P = 1 / (1 + self.S / self.k), self.load(z)
        of_u = -self.dS * (self.D - z + P / self.k) * yields
        by_s, by_root, by_turn = (of_u * rate for rate in self.by_u)
        return P, np.stack([P * yields + by_s, by_root, np.full_like(P, self.S * yields), by_turn])

    def by_body(self, z: Array, changes: Changes) -> Array:
        """Derivative of the load at positions ``z`` [m] by an amount of ``changes`` of the body."""
        D, T, H, V = (float(rate) for rate in changes(np.array([self.u]))[:, 0])
        P, (_, _, _, by_turn) = self.at(z)
        turns = D * self.D - T * self.shift + (H * self.P_H - V * self.S * self.shift) / self.k
        off = (V - T) * (self.D - z + P / self.k) + D * self.D
        dP: Array = (H * self.P_H - self.S * off) / (1 + self.S / self.k) - by_turn * turns
        return dP


@lru_cache(maxsize=REMEMBERED)
def rest(family: Family, s: float, advanced: float, receding: float, k: float, turn: float) -> Rest:
    """The resting edge of a device that turns at position ``turn`` [m], after an advance with the root ``advanced`` of
    q, until it recedes with ``receding``. ``advanced`` < 0: a smaller contact than without adhesion."""
    nodes = Nodes.of(family)
    z = _path(s, advanced, k, nodes.functions[:, 0])[0]
    first = int(np.argmin(z))
    near = float(np.interp(turn, z[first:], nodes.u[first:]))
    for _ in range(MOST_STEPS):
        (d, t, h, v), (dD, dT, dH, dV), _ = nodes.at(near).tolist()
        dz = dD - advanced * dT + s * (dH - advanced * dV) / k
        off = turn - (d - advanced * t + s * (h - advanced * v) / k)
        step = min(max(off / max(dz, 1e-300), -TUNING.beyond), TUNING.beyond)
        if abs(step) < SETTLED or near + step < nodes.u[first]:
            break
        near += step
    S = s * v / t
    dS = S * (dV / v - dT / t)
    per = 1 / max(dz, SAME * d)  # nothing rests on a turn at the fold, where dz = 0
    by_u = -s * (h - advanced * v) / k * per, (t + s * v / k) * per, per
    return Rest(near, d - receding * t + s * (h - receding * v) / k, by_u, d, s * h, S, dS, advanced * t, k)

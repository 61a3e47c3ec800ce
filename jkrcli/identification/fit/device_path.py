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
from functools import lru_cache

import numpy as np

from ...base.arrays import Array
from .family import Family


@dataclass(frozen=True)
class DevicePathTuning:
    """How finely branches are tabulated."""

    bodies: int = 8  # choice: whose functions on the grid are remembered
    branches: int = 32  # choice: of one record, asked for again at the same unknowns, that are remembered
    nodes: int = 400  # choice: of a branch; loads between them are good to 1e-7 of the largest
    zooms: int = 3  # choice: grids on which a fold is sought, each of ``zoomed`` points within a step of the one before
    zoomed: int = 33  # choice: see ``zooms``; the position at the fold, flat there, is then good to 1e-16
    below: float = 4.0  # choice: of log a below the series, where its limit by power laws holds
    beyond: float = 0.5  # choice: of log a above the series, tried while starting values are looked for
    flat: float = 1e-6  # choice: of the displacement, least dz/du at the turn; nothing rests on a turn at the fold
    steps: int = 30  # choice: of Newton's method for the radius at the turn, at most
    found: float = 1e-13  # choice: of log a, when it has come there
    widest: float = 0.5  # choice: of log a, a step of it


TUNING = DevicePathTuning()


def grid(family: Family) -> Array:
    """Logs of contact radii over which paths are looked at."""
    return np.linspace(family.low - TUNING.below, family.high + TUNING.beyond, TUNING.nodes)


@lru_cache(maxsize=TUNING.bodies)
def on_grid(family: Family) -> tuple[Array, Array, Array]:
    """The functions of a body there, as ``Family.at`` gives them."""
    return family.at(grid(family))


@dataclass(frozen=True, eq=False)
class DeviceBranch:
    """The stable branch of one body at a device, on which the edge moves: load over zeta = sqrt(z - fold), where it is
    smooth.

    ``rates``: derivatives of the load at fixed z by ln s and q = w/s, times zeta, (2, n). ``fold`` [m]: where it ends;
    ``u, z``: log of the contact radius and position [m] along it. ``below``: q where it is negative, else 0.
    """

    fold: float
    u: Array
    z: Array
    zeta: Array
    P: Array
    slope: Array
    rates: Array
    below: float

    def at(self, z: Array, blunt: float) -> tuple[Array, Array]:
        """Load at positions ``z`` [m], and its derivatives by ln s, q and z, (3, n).

        From ``blunt`` [m] before the fold on the tangent there goes on: a load for every position, and a search that
        sees where the fold should be.
        """
        zeta = np.sqrt(np.maximum(z - self.fold, blunt))
        i = np.clip(np.searchsorted(self.zeta, zeta) - 1, 0, self.zeta.size - 2)
        width = self.zeta[i + 1] - self.zeta[i]
        x = (zeta - self.zeta[i]) / width
        left, right, dl, dr = self.P[i], self.P[i + 1], self.slope[i] * width, self.slope[i + 1] * width
        a, b = 2 * (left - right) + dl + dr, 3 * (right - left) - 2 * dl - dr
        by_z = (dl + x * (2 * b + 3 * x * a)) / width / (2 * zeta)
        P = left + x * (dl + x * (b + x * a)) + by_z * (z - self.fold - zeta**2)
        change = self.rates[:, i + 1] - self.rates[:, i]
        by_s, by_q = (self.rates[:, i] + change * x) / zeta
        if self.below:
            bent = (change[1] / width - by_q) / (2 * zeta**2)
            P, by_s, by_z = P + self.below * by_q, by_s + self.below * by_q, by_z + self.below * bent
        return P, np.stack([by_s, by_q, by_z])

    def radii(self, z: Array) -> Array:
        """Contact radii [m] at positions ``z`` [m], that of the fold before it."""
        return np.exp(np.interp(z, self.z, self.u))


@lru_cache(maxsize=TUNING.branches)
def branch(family: Family, s: float, q: float, k: float) -> DeviceBranch:
    """The stable branch for moduli times ``s`` and work of adhesion ``q`` s, by a device of stiffness ``k``."""
    u, r = grid(family), math.sqrt(max(q, 0.0))

    def path(functions: tuple[Array, Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
        """Position and load, their derivatives by u, and that of the load by q at fixed z times that of z by u."""
        (D, T, H, V), (dD, dT, dH, dV), _ = functions
        P, dP = s * (H - r * V), s * (dH - r * dV)
        return D - r * T + P / k, P, dD - r * dT + dP / k, dP, -s / 2 * (dV * T - V * dT)

    start = _fold(lambda u: path(family.at(u))[2], u, path(on_grid(family))[2])
    u = start + (u[-1] - start) * np.linspace(0, 1, TUNING.nodes) ** 2
    z, P, dz, dP, by_q = path(family.at(u))
    zeta = np.sqrt(np.maximum.accumulate(z - z[0]))
    steep = np.divide(zeta, dz, out=np.zeros_like(z), where=dz > 0)
    slope, rates = 2 * dP * steep, np.stack([zeta * P - dP * steep * P / k, by_q * steep])
    slope[0], rates[:, 0] = slope[1], rates[:, 1]
    rising = np.append(True, np.diff(zeta) > 0)
    return DeviceBranch(
        float(z[0]), u[rising], z[rising], zeta[rising], P[rising], slope[rising], rates[:, rising], min(q, 0.0)
    )


def _fold(rate: Callable[[Array], Array], u: Array, rates: Array) -> float:
    """Where ``rate``, ``rates`` on ``u``, turns positive for good, by ever finer grids and a secant; the first u where
    it never does within them."""
    for zoom in range(TUNING.zooms):
        rates = rate(u) if zoom else rates
        falling = np.flatnonzero(rates <= 0)
        if not falling.size or falling[-1] == u.size - 1:
            return float(u[0])
        i = falling[-1]
        share = rates[i] / (rates[i] - rates[i + 1])
        found, u = float(u[i] + share * (u[i + 1] - u[i])), np.linspace(u[i], u[i + 1], TUNING.zoomed)
    return found


@dataclass(frozen=True, eq=False)
class Rest:
    """The straight line on which the edge rests at one contact radius e^``u``: load ``P`` + ``by_z`` z [N].

    ``end`` [m]: the position below which it recedes. ``by_u``: of u's place in the record: its derivatives by ln s, by
    the root of q with which it advanced, and by the position of the turn. ``S, dS``: contact stiffness and its
    derivative by u [N/m]; ``D``: displacement without adhesion [m]; ``k`` of the device.
    """

    u: float
    end: float
    by_u: tuple[float, float, float]
    D: float
    P_H: float
    S: float
    dS: float
    k: float

    def released(self, receding: float, z: float) -> float:
        """The root of q that a row at ``z`` [m] holds, where ``receding`` is that at the end."""
        return receding + (self.end - z) * self.by_u[2] / self.by_u[1]

    def at(self, z: Array) -> tuple[Array, Array]:
        """Load at positions ``z`` [m], and its derivatives by ln s, the root of q, z, and the position of the turn."""
        yields = 1 / (1 + self.S / self.k)
        P = (self.P_H - self.S * (self.D - z)) * yields
        of_u = -self.dS * (self.D - z + P / self.k) * yields
        by_s, by_root, by_turn = (of_u * rate for rate in self.by_u)
        return P, np.stack([P * yields + by_s, by_root, np.full_like(P, self.S * yields), by_turn])


@lru_cache(maxsize=TUNING.branches)
def rest(family: Family, s: float, advanced: float, receding: float, k: float, turn: float) -> Rest:
    """The resting edge of a device that turns at position ``turn`` [m], after an advance with the root ``advanced`` of
    q, until it recedes with ``receding``. ``advanced`` < 0: a smaller contact than without adhesion."""
    u = grid(family)
    (D, T, H, V), _, _ = on_grid(family)
    z = D - advanced * T + s * (H - advanced * V) / k
    first = int(np.argmin(z))
    near = float(np.interp(turn, z[first:], u[first:]))
    for _ in range(TUNING.steps):
        (D, T, H, V), (dD, dT, dH, dV), _ = family.at(np.array([near]))[0:3]
        z, dz = D - advanced * T + s * (H - advanced * V) / k, dD - advanced * dT + s * (dH - advanced * dV) / k
        step = float(np.clip((turn - z[0]) / max(dz[0], 1e-300), -TUNING.widest, TUNING.widest))
        if abs(step) < TUNING.found or near + step < u[first]:
            break
        near += step
    d, t, h, v = (float(item[0]) for item in (D, T, H, V))
    S = s * v / t
    dS = S * float(dV[0] / v - dT[0] / t)
    per = 1 / max(float(dz[0]), TUNING.flat * d)
    by_u = -s * (h - advanced * v) / k * per, (t + s * v / k) * per, per
    return Rest(near, d - receding * t + s * (h - receding * v) / k, by_u, d, s * h, S, dS, k)

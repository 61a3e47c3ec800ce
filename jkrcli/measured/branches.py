"""The path of a contact at a device, of many curves at once: loads over the device's position where the edge moves and
where it rests.

At position z of a device of stiffness k, delta = z - P/k. An edge that moves follows Eq. 13 (``formulas``) with r =
sqrt(w/s) for moduli times s. At the reversal, at contact radius a_m, the crack is pinned: P = P_m + S(a_m) (delta -
delta_m), until the energy release rate has come to the w of the other way; then it recedes, down to the fold d(delta +
P/k)/da = 0. As w -> 0 the load of a moving edge is linear in w, dP/dw = -2 pi a/(d delta_H/da): that goes on below 0.

Curves are the leading axis of all arrays, rows are flat, each with the number of its curve. No number of a curve
depends on which others are beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from ..base.errors import SolveError
from ..base.numerics import MOST_STEPS, SAME, TINY, Array
from ..base.process import REMEMBERED
from ..base.units import show
from ..formulas import adhesive, device_factors
from .forward_model import FUNCTIONS, Family, grid, on_grid

# Steps along branches.
DEVICE_PATH_POLISHED = 4  # theory: steps of Newton's method, which square the error, from a tenth of a step to 1e-16
DEVICE_PATH_NEAR = 1e-6  # theory: of log a, whose third power is round-off
DEVICE_PATH_STEP = 0.5  # choice: of log a, the longest step to where the contact line is pinned
# theory: the quintic through values and two derivatives at 0 and 1, by powers of the place: of each what it counts
DEVICE_PATH_QUINTIC = np.array([
    [1.0, 0.0, 0.0, -10.0, 15.0, -6.0], [0.0, 1.0, 0.0, -6.0, 8.0, -3.0], [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
    [0.0, 0.0, 0.0, 10.0, -15.0, 6.0], [0.0, 0.0, 0.0, -4.0, 7.0, -3.0], [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
]).T  # fmt: skip
_RISING = np.diag(np.arange(1.0, 6.0), 1)  # the derivatives of 1, x, ..., x^5 by these powers
# what each counts in the value, the derivative and the second one, side by side
DEVICE_PATH_QUINTICS = np.hstack([np.linalg.matrix_power(_RISING, n) @ DEVICE_PATH_QUINTIC for n in range(3)])

Moving: TypeAlias = tuple[Family, float, float, float]  # body, factor s of its moduli, q = w/s, stiffness k
Resting: TypeAlias = tuple[Family, float, float, float, float, float]  # body, s, sqrt(q) before and after, k, turn


@dataclass(frozen=True, eq=False)
class Nodes:
    """The functions of a ``family`` at the nodes ``u`` of its grid, for paths of any moduli and any w on it: D, T, H, V
    and two derivatives by u (4, 3, nodes)."""

    family: Family
    u: Array
    functions: Array

    @classmethod
    @lru_cache(maxsize=REMEMBERED)
    def of(cls, family: Family) -> Nodes:
        return cls(family, grid(family), np.ascontiguousarray(on_grid(family).swapaxes(0, 1)))


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of some curves: their ``nodes``, each body once, and ``which`` of them is that of each curve;
    ``u`` (bodies, nodes) and ``functions`` (bodies, 4, 3, nodes) of them."""

    nodes: tuple[Nodes, ...]
    which: Array
    u: Array
    functions: Array

    @classmethod
    def of(cls, families: Sequence[Family]) -> Bodies:
        """Those of ``families``, one for each curve."""
        places = {family: i for i, family in enumerate(dict.fromkeys(families))}
        nodes, which = tuple(Nodes.of(family) for family in places), np.array([places[family] for family in families])
        if len(nodes) == 1:
            return cls(nodes, which, nodes[0].u[None], nodes[0].functions[None])
        return cls(nodes, which, np.array([one.u for one in nodes]), np.array([one.functions for one in nodes]))

    @property
    def step(self) -> Array:
        """The distance of neighbouring nodes of each curve."""
        return (self.u[:, -1] - self.u[:, 0])[self.which] / (self.u.shape[1] - 1)

    def combined(self, factors: Array, orders: slice, first: int = 0) -> Array:
        """Sums of D, T, H, V of each curve with ``factors`` (curves, sums, 4), those ``orders`` of derivatives, from
        the ``first`` node on: (curves, sums, orders, nodes)."""
        functions = self.functions[:, :, orders, first:]
        columns = functions.reshape(len(functions), FUNCTIONS, -1)
        sums: Array = factors @ (columns if len(columns) == 1 else columns[self.which])
        return sums.reshape(*factors.shape[:2], *functions.shape[2:])

    def beside(self, i: Array) -> Array:
        """D, T, H, V and two derivatives at node ``i`` of each curve and the next one, (curves, 2, 4, 3)."""
        return self.functions[self.which[:, None], :, :, i[:, None] + np.arange(2)]

    def at(self, u: Array) -> Array:
        """D, T, H, V at one place of each curve, with two derivatives: (3, curves, 4), good to rounding: of their logs,
        quintics through values and two derivatives at the nodes beside it."""
        place, last, step = (u - self.u[self.which, 0]) / self.step, self.u.shape[1] - 1, self.step[:, None]
        i = np.fmin(np.fmax(place, 0.0), last - 1).astype(int)  # of a place that is no number the first, and nan there
        value, by_u, by_uu = self.beside(i).transpose(3, 0, 1, 2)
        # Logs and two derivatives by the place, (curves, 2, 3, 4):
        logs = np.empty((u.size, 2, 3, FUNCTIONS))
        logs[:, :, 0], per = np.log(value), step[:, None] / value
        first = np.multiply(by_u, per, out=logs[:, :, 1])
        logs[:, :, 2] = by_uu * per * step[:, None] - first**2
        weights = (((place - i)[:, None] ** np.arange(6))[:, None] @ DEVICE_PATH_QUINTICS).reshape(-1, 3, 6)
        log, first, second = (weights @ logs.reshape(-1, 6, FUNCTIONS)).transpose(1, 0, 2)
        at = np.empty((3, u.size, FUNCTIONS))
        value, first = np.exp(log, out=at[0]), first / step
        at[1], at[2] = value * first, value * (second / step**2 + first**2)
        outside = (place < 0) | (place > last)
        for one in np.flatnonzero(outside).tolist() if outside.any() else ():
            at[:, one] = np.stack(self.nodes[self.which[one]].family.at(u[one : one + 1]))[:, :FUNCTIONS, 0]
        return at


@dataclass(frozen=True, eq=False)
class Branches:
    """The stable branches of some curves at their devices, on which the edge moves: load over zeta = sqrt(z - fold),
    where it is smooth.

    ``fold`` [m]: where each ends, at its ``first`` node; ``u``: log of the contact radius [m] along it, ``zeta``,
    ``P``, all (curves, nodes), at nodes before the first without a meaning; ``slope``: derivative of the load by
    zeta, ``steep``: zeta over the derivative of z by u; ``released``: V' T - V T', by which loads change with q.
    ``q``, ``k, s, r`` of the curves; ``at_fold``: D, T, H, V there (curves, 4); ``stable``: which of them have a stable
    contact at all.
    """

    bodies: Bodies
    fold: Array
    first: Array
    u: Array
    zeta: Array
    P: Array
    slope: Array
    steep: Array
    released: Array
    q: Array
    k: Array
    s: Array
    r: Array
    at_fold: Array
    stable: Array

    @classmethod
    def of(cls, asked: Sequence[Moving]) -> Branches:
        """Those of bodies with moduli times s and works of adhesion q s, by devices of stiffness k: at the fold and at
        radii of the grid beyond."""
        families, *numbers = zip(*asked, strict=True)
        bodies, (s, q, k) = Bodies.of(families), np.array(numbers)
        r, curves = np.sqrt(np.maximum(q, 0.0)), np.arange(len(asked))
        # Positions z = D - r T + s (H - r V)/k and loads s (H - r V), with their derivatives by u, at the nodes from
        # the first fold on: (curves, 2, 2, nodes).
        of_four = device_factors(s, r, k)
        first, start = _folds(bodies, of_four[:, 0])
        begin, turns = min(int(first.min()), bodies.u.shape[1] - 2), first > 0  # a cell, where none is stable, too
        path, n, first = bodies.combined(of_four, slice(2), begin), bodies.u.shape[1] - begin, first - begin
        at_fold = bodies.at(start)
        there = of_four @ at_fold.transpose(1, 2, 0)
        path[curves, :, :, first], bend = there[..., :2], there[:, 0, 2]
        T, V = bodies.functions[:, 1, :2, begin:], bodies.functions[:, 3, :2, begin:]
        u, released = bodies.u[bodies.which, begin:], (V[:, 1] * T[:, 0] - V[:, 0] * T[:, 1])[bodies.which]
        (_, T, _, V), (_, dT, _, dV) = at_fold[0].T, at_fold[1].T
        u[curves, first], released[curves, first] = start, dV * T - V * dT
        (z, dz), (P, dP) = path.transpose(1, 2, 0, 3)
        fold, before = z[curves, first], np.arange(n) < first[:, None]
        zeta = z - fold[:, None]
        zeta[before] = 0.0
        np.sqrt(np.maximum.accumulate(zeta, axis=1, out=zeta), out=zeta)
        steep = zeta * (dz > 0) / np.maximum(dz, TINY)
        parabola = turns & (bend > 0)  # its limit at the fold, where z is a parabola of u
        steep[curves[parabola], first[parabola]] = 1 / np.sqrt(2 * bend[parabola])
        slope, up = 2 * dP * steep, zeta[:, 1:] > zeta[:, :-1]
        stable = up.any(axis=1)
        for one in np.flatnonzero((~up & ~before[:, :-1]).any(axis=1) & stable).tolist():
            keep = np.append(True, up[one, first[one] :])  # nodes at which z has risen
            last, first[one] = slice(first[one], None), n - np.count_nonzero(keep)
            for column in (u, zeta, P, slope, steep, released):
                column[one, first[one] :] = column[one, last][keep]
        return cls(bodies, fold, first, u, zeta, P, slope, steep, released, q, k, s, r, at_fold[0], stable)

    def unstable(self, one: int) -> SolveError:
        """Why a curve has no branch."""
        most = show(math.exp(self.u[one, -1]), "length")
        return SolveError(f"no contact is stable at this w up to a = {most}: take a smaller w, or check the radius and "
                          "the units")  # fmt: skip

    @property
    def cells(self) -> Array:
        """Between nodes, (6, curves * (nodes - 1)): where they begin, the inverse width, and the load's coefficients of
        a cubic."""
        cells = np.empty((6, len(self.zeta), self.zeta.shape[1] - 1))
        begin, per, c0, c1, c2, c3 = cells
        begin[:], c0[:] = self.zeta[:, :-1], self.P[:, :-1]
        width, rise = self.zeta[:, 1:] - begin, self.P[:, 1:] - c0
        per[:] = 1 / np.where(width > 0, width, 1.0)
        np.multiply(self.slope[:, :-1], width, out=c1)
        c3[:] = c1 + self.slope[:, 1:] * width - 2 * rise
        c2[:] = rise - c1 - c3
        return cells.reshape(6, -1)

    @property
    def rates(self) -> Array:
        """The derivatives of the load at fixed z by ln s and q = w/s, times zeta, which are straight between nodes:
        where these begin, and their changes, (4, curves * (nodes - 1))."""
        of_s = (self.zeta - self.slope / (2 * self.k[:, None])) * self.P
        of_q = self.released * self.steep * (-self.s[:, None] / 2)
        rates = np.stack([of_s[:, :-1], of_q[:, :-1], np.diff(of_s), np.diff(of_q)])
        return rates.reshape(4, -1)

    def cell(self, own: Array, zeta: Array) -> Array:
        """The number of the cell of each row at ``zeta`` of the curve ``own``, in which rows are sorted."""
        n = self.zeta.shape[1]
        ends = np.searchsorted(own, np.arange(len(self.zeta) + 1)).tolist()
        i = np.empty(own.size, dtype=np.intp)
        firsts = np.minimum(self.first, n - 2).tolist()  # of one without a stable contact there is no cell
        for one, (first, begin, end) in enumerate(zip(firsts, ends[:-1], ends[1:], strict=True)):
            found = self.zeta[one, first + 1 : n - 1].searchsorted(zeta[begin:end])
            np.add(found, one * (n - 1) + first, out=i[begin:end])
        return i

    def at(self, own: Array, z: Array, blunt: Array, slopes: bool = True) -> Array:
        """Loads of rows at positions ``z`` [m] on the branches of curves ``own``, in which they are sorted, and, with
        ``slopes``, their derivatives by ln s, q and z: (4, rows), or (1, rows).

        From ``blunt`` (curves) [m] before the fold on the tangent there goes on: a load for every position, and a
        search that sees where the fold should be. Where q < 0 the load is continued straight from w = 0.
        """
        gap = z - self.fold[own]
        zeta = np.sqrt(np.maximum(gap, blunt[own]))
        cell = self.cell(own, zeta)
        begin, per, c0, c1, c2, c3 = self.cells.take(cell, axis=1)
        x, half = (zeta - begin) * per, 0.5 / zeta
        at = np.empty((4 if slopes else 1, z.size))
        by_z = (c1 + x * (2 * c2 + 3 * x * c3)) * per * half
        at[0] = c0 + x * (c1 + x * (c2 + x * c3)) + by_z * (gap - zeta * zeta)
        below = np.minimum(self.q, 0.0)
        if not (slopes or below.any()):
            return at
        by_s, by_q, more_s, more_q = self.rates.take(cell, axis=1)
        by_w = (by_q + more_q * x) / zeta
        if slopes:
            at[1], at[2], at[3] = (by_s + more_s * x) / zeta, by_w, by_z
        if below.any():
            low = below[own]
            at[0] += low * by_w
            if slopes:
                at[1] += low * by_w
                at[3] += low * (more_q * per - by_w) * half / zeta
        return at

    def one(self, curve: int) -> DeviceBranch:
        """That of one curve; SolveError where no contact is stable."""
        if not self.stable[curve]:
            raise self.unstable(curve)
        some = slice(self.first[curve], None)
        u, zeta, slope = (column[curve, some] for column in (self.u, self.zeta, self.slope))
        fold, k, s, r = (float(column[curve]) for column in (self.fold, self.k, self.s, self.r))
        nodes = self.bodies.nodes[self.bodies.which[curve]]
        return DeviceBranch(fold, u, zeta, slope, k, s, r, self.at_fold[curve], nodes)


def _folds(bodies: Bodies, factors: Array) -> tuple[Array, Array]:
    """Where the position of each curve, the sum of D, T, H, V with ``factors`` (curves, 4), turns to rise for good: the
    node that the fold takes the place of, and the place, a root of the cubic through two nodes; the first node where it
    rises or falls on all."""
    rates = bodies.combined(factors[:, None], slice(1, 2))[:, 0, 0]
    n, curves, falling = rates.shape[1], np.arange(len(rates)), rates <= 0
    i = n - 1 - np.argmax(falling[:, ::-1], axis=1)
    turns = falling.any(axis=1) & (i < n - 1)
    i = np.where(turns, i, 0)
    step, bends = bodies.step, (factors[:, None, None] @ bodies.beside(i)[..., 2:])[..., 0, 0]
    left, right, (dl, dr) = rates[curves, i], rates[curves, i + 1], step * bends.T
    x = np.where(turns, left / np.where(left == right, 1.0, left - right), 0.0)
    a, b = 2 * (left - right) + dl + dr, 3 * (right - left) - 2 * dl - dr
    for _ in range(DEVICE_PATH_POLISHED):
        slope = dl + x * (2 * b + 3 * x * a)
        better = np.clip(x - (left + x * (dl + x * (b + x * a))) / np.where(slope > 0, slope, 1.0), 0.0, 1.0)
        x = np.where(turns & (slope > 0), better, x)
    return i + np.rint(x).astype(int), bodies.u[bodies.which, i] + x * step


@dataclass(frozen=True, eq=False)
class DeviceBranch:
    """The branch of one curve, as of ``Branches``, from its fold on, of a body at ``nodes``; ``at_fold``: D, T, H, V
    there."""

    fold: float
    u: Array
    zeta: Array
    slope: Array
    k: float
    s: float
    r: float
    at_fold: Array
    nodes: Nodes

    def radii(self, z: Array) -> Array:
        """Contact radii [m] at positions ``z`` [m], that of the fold before it."""
        return np.interp(np.sqrt(np.maximum(z - self.fold, 0.0)), self.zeta, np.exp(self.u))

    def by_body(self, z: Array, blunt: float, changes: Array) -> Array:
        """Derivatives of the load at positions ``z`` [m], (changes, rows), by an amount of each of the ``changes`` of
        the logs of D, T, H, V of the body (changes, 4, nodes)."""
        # between two nodes at the fold, on one of them beyond:
        place = np.maximum((self.u - self.nodes.u[0]) / (self.nodes.u[1] - self.nodes.u[0]), 0.0)
        i, first = np.rint(place).astype(int), min(int(place[0]), self.nodes.u.size - 2)
        here, parts = changes.take(i, axis=-1), self.nodes.functions[:, 0, i]
        here[..., 0] = changes[..., first] + (changes[..., first + 1] - changes[..., first]) * (place[0] - first)
        parts[:, 0] = self.at_fold
        parts[:2] *= self.slope / -2
        parts[2:] *= self.s * (self.zeta - self.slope / (2 * self.k))
        parts[1::2] *= -self.r
        rate = np.einsum("ijk,jk->ik", here, parts)
        zeta = np.sqrt(np.maximum(z - self.fold, blunt))
        i = self.zeta[1:-1].searchsorted(zeta)
        x = np.minimum((zeta - self.zeta[i]) / (self.zeta[i + 1] - self.zeta[i]), 1.0)
        left, right = rate.take(i, axis=1), rate.take(i + 1, axis=1)
        return (left + (right - left) * x) / zeta


def branch(family: Family, s: float, q: float, k: float) -> DeviceBranch:
    """The stable branch for moduli times ``s`` and work of adhesion ``q`` s, by a device of stiffness ``k``."""
    return Branches.of([(family, s, q, k)]).one(0)


@dataclass(frozen=True, eq=False)
class Rest:
    """The straight ``lines`` of load over position on which the edges of some curves rest, each at one contact radius
    e^``u``; all numbers (curves,), or of one.

    ``end`` [m]: the position below which it recedes. ``by_u``: of u's place in the record: its derivatives by ln s, by
    the root of q with which it advanced, and by the position of the turn (3, curves). ``S, dS``: contact stiffness and
    its derivative by u [N/m]; ``D``: displacement without adhesion [m], ``P_H``: load; ``shift``: of the advancing edge
    by adhesion [m]; ``k`` of the device.
    """

    u: Array
    end: Array
    by_u: Array
    D: Array
    P_H: Array
    S: Array
    dS: Array
    shift: Array
    k: Array

    @classmethod
    def of(cls, asked: Sequence[Resting]) -> Rest:
        """Those of curves whose device turns at positions turn [m], after an advance with the root ``advanced`` of q,
        until they recede with ``receding``. ``advanced`` < 0: a smaller contact than without adhesion."""
        families, *columns = zip(*asked, strict=True)
        s, advanced, receding, k, turn = np.array(columns)
        bodies = Bodies.of(families)
        nodes = bodies.u[bodies.which]
        of_four = device_factors(s, advanced, k)[:, :1]
        z = bodies.combined(of_four, slice(1))[:, 0, 0]
        first = np.argmin(z, axis=1)
        u = np.array([np.interp(at, y[i:], x[i:]) for at, x, y, i in zip(turn, nodes, z, first, strict=True)])
        lowest = nodes[np.arange(s.size), first]
        for _ in range(MOST_STEPS):  # Newton's method for D - r T + s (H - r V)/k = turn
            at = bodies.at(u)
            here, rise = (of_four[:, 0] * at[:2]).sum(axis=2)
            step = np.minimum(np.maximum((turn - here) / np.maximum(rise, TINY), -DEVICE_PATH_STEP), DEVICE_PATH_STEP)
            step[u + step < lowest] = 0.0
            far = np.abs(step) > DEVICE_PATH_NEAR
            if not far.any():
                break
            u = np.where(far, u + step, u)
        step[far] = 0.0  # which found no place
        u, rest = u + step, step[:, None]  # of which the derivatives know enough
        at = np.stack([at[0] + rest * (at[1] + rest / 2 * at[2]), at[1] + rest * at[2]])
        rise = (of_four[:, 0] * at[1]).sum(axis=1)
        (d, t, h, v), (_, dT, _, dV) = at[0].T, at[1].T
        S = s * v / t
        per = 1 / np.maximum(rise, SAME * d)  # nothing rests on a turn at the fold, where dz/du = 0
        by_u = np.stack([-s * (h - advanced * v) / k * per, (t + s * v / k) * per, per])
        (delta, P), dS = adhesive((d, t, h, v), s, receding), S * (dV / v - dT / t)
        end = delta + P / k
        return cls(u, end, by_u, d, s * h, S, dS, advanced * t, k)

    def some(self, which: Array | int) -> Rest:
        """Those of curves ``which``, each as often as it is named."""
        return Rest(*(getattr(self, item.name)[..., which] for item in fields(Rest)))

    def released(self, receding: float, z: float) -> float:
        """The root of q that a row at ``z`` [m] holds, where ``receding`` is that at the end."""
        return float(receding + (self.end - z) * self.by_u[2] / self.by_u[1])

    def until(self, fold: Array, lost: Array) -> tuple[Array, Array]:
        """Where contact is lost [m] and where the edges have come to their ends [m], where those that move have their
        ``fold`` at these logs of radii and are ``lost`` there [m]: a smaller contact is unstable when its edge is
        released, so that it rests until it is lost."""
        unstable = self.u < fold
        return np.where(unstable, self.end, lost), np.where(unstable, -np.inf, self.end)

    @property
    def lines(self) -> Array:
        """The straight lines over D - z [m], what they begin with and rise by, (2, 6, curves): the load and its
        derivatives by ln s, q of the edge that moves (none), z, the root of q before, and the position of the turn."""
        y = 1 / (1 + self.S / self.k)
        lines = np.zeros((2, 6, *np.shape(y)))
        lines[:, 0] = y * self.P_H, -y * self.S
        by_u = -self.dS * y**2 * np.stack([self.P_H / self.k, np.ones_like(y)])  # at a fixed z
        for line, rate in zip((1, 4, 5), self.by_u, strict=True):
            lines[:, line] = by_u * rate
        lines[:, 1] += y * lines[:, 0]
        lines[0, 3] = y * self.S
        return lines

    def at(self, z: Array, own: Array | None = None) -> Array:
        """Load at positions ``z`` [m] and its derivatives, as of ``lines``, (6, rows), of curves ``own``, or of one."""
        if own is None:
            begin, rise = self.lines
            return begin[:, None] + rise[:, None] * (self.D - z)
        begin, rise = self.lines.take(own, axis=2)
        rise *= self.D[own] - z
        begin += rise
        return begin

    def by_body(self, z: Array, u: Array, changes: Array) -> Array:
        """Derivatives of the load at positions ``z`` [m], (changes, rows), by an amount of each of the ``changes`` of
        the logs of D, T, H, V of the body (changes, 4, nodes) at the nodes ``u``."""
        i = min(max(int(np.searchsorted(u, self.u)) - 1, 0), u.size - 2)
        share = (self.u - u[i]) / (u[i + 1] - u[i])
        D, T, H, V = (changes[..., i] + share * (changes[..., i + 1] - changes[..., i])).T[..., None]
        P, _, _, _, _, by_turn = self.at(z)
        turns = D * self.D - T * self.shift + (H * self.P_H - V * self.S * self.shift) / self.k
        off = (V - T) * (self.D - z + P / self.k) + D * self.D
        return (H * self.P_H - self.S * off) / (1 + self.S / self.k) - by_turn * turns


@lru_cache(maxsize=REMEMBERED)
def rest(family: Family, s: float, advanced: float, receding: float, k: float, turn: float) -> Rest:
    """The resting edge of one curve, as of ``Rest.of``."""
    return Rest.of([(family, s, advanced, receding, k, turn)]).some(0)

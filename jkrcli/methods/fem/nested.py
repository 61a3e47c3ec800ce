"""Unilateral contact on the condensed surface: nested (all contact radii at once, sliding or sticking) and by
increments (sliding).

Nodal forces p >= 0, gaps f - delta + C p >= 0, and one of the two zero at every node, with f the indenter's
profile at the nodes and C the surface compliance; but for round-off, of the largest force and of the depth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from ...base import MOST_STEPS, ROUNDED, Array, SolveError
from .surface import Surface


@dataclass(frozen=True, eq=False)
class SurfaceContact:
    """The contact problem on ``surface`` for profile heights ``f`` [m] at its nodes.

    With C = L L^T, y = L^-1 e, e of a unit displacement downwards, and z = L^-1 f, the leading block k of L serves the
    contact set {0..k}: running sums give the stiffness S_k of that set, the depth delta_k at which node k just touches
    with zero force, and the load there, P_k = S_k delta_k - T_k. Where surfaces stick, a node has two rows: it is
    touched with the first of them, and the set has both.
    """

    surface: Surface
    f: Array

    @cached_property
    def L(self) -> Array:
        return cholesky(self.surface.C, lower=True)

    @cached_property
    def _solved(self) -> Array:
        return solve_triangular(self.L, np.column_stack([np.ones_like(self.f), self.f]), lower=True).T

    @property
    def y(self) -> Array:
        return self._solved[0]

    @property
    def z(self) -> Array:
        return self._solved[1]

    @cached_property
    def S(self) -> Array:
        """Stiffness dP/d(delta) of the contact sets {0..k} [N/m]."""
        return np.cumsum(self.y**2)[self.surface.last]

    @cached_property
    def T(self) -> Array:
        """Load that the profile takes off: P = S delta - T for the contact set {0..k} [N]."""
        return np.cumsum(self.y * self.z)[self.surface.last]

    @cached_property
    def delta(self) -> Array:
        """Depth at which node k touches with zero force, all nodes inside it in contact [m]."""
        return (self.z / self.y)[self.surface.normal]

    @cached_property
    def P(self) -> Array:
        """Load at that depth [N]."""
        S, T = np.cumsum([self.y**2, self.y * self.z], axis=1)[:, self.surface.normal]
        return S * self.delta - T

    def pressed(self, last: Array, depth: Array) -> tuple[Array, Array]:
        """Halves L^T p and forces p (m, sets) [N] of the rows {0..last} pressed to ``depth`` [m]."""
        inside = np.arange(len(self.surface.C))[:, None] <= last
        halves = np.where(inside, depth * self.y[:, None] - self.z[:, None], 0.0)
        return halves, solve_triangular(self.L, halves, lower=True, trans="T")

    def set_at(self, depth: Array) -> Array:
        """Last node k of the disc that touches at ``depth`` [m]."""
        touched = np.searchsorted(np.maximum.accumulate(self.delta), depth, side="right")
        return np.clip(touched - 1, 0, self.f.size - 1)


@dataclass(frozen=True, eq=False)
class StuckContact(SurfaceContact):
    """The contact problem on a ``surface`` whose points keep the radial displacement with which they were touched.

    As for sliding surfaces, with two rows of L for each node: z = L^-1 (f, -g) in turn, g the outward displacements. A
    node is touched where its normal force does not act yet, which gives delta_k = z_k/y_k from its first row. Would it
    stick at that very moment, its second row were z = delta_k y instead of g: the disc that grows node by node while
    stuck discs are pressed down, P = int S d(delta). But then the edge of the shear would not be that of the pressure.
    Both are where the ``rows`` (n, 2, 2) tell them to be (``edge_rows``), and z makes up for it to the second order of
    the spacing. ``flat``: radius of the flat end [m].
    """

    rows: Array
    flat: float = 0.0

    @cached_property
    def y(self) -> Array:
        e = np.zeros(len(self.surface.C))
        e[self.surface.normal] = 1.0
        return solve_triangular(self.L, e, lower=True)

    @cached_property
    def _ramps(self) -> Array:
        """What the rows of each node read of a field that begins to act there (n, 2) [m times y]."""
        y = self.y[np.column_stack([self.surface.normal, self.surface.last])]
        return np.einsum("nij,nj->ni", self.rows[: len(y)], y)

    @cached_property
    def edges(self) -> Array:
        """Radius of the edge of the contact when each node touches (n,) [m]."""
        return self.surface.radii + self._ramps[:, 0] / self.y[self.surface.normal]

    @cached_property
    def z(self) -> Array:
        y, z, delta = self.y, np.zeros_like(self.y), np.zeros_like(self.f)
        lag = self._ramps[:, 1] - self._ramps[:, 0] * y[self.surface.last] / y[self.surface.normal]
        for k, (row, last) in enumerate(zip(self.surface.normal, self.surface.last, strict=True)):
            z[row] = (self.f[k] - self.L[row, :row] @ z[:row]) / self.L[row, row]
            delta[k] = z[row] / y[row]
            if last > row:
                z[last] = delta[k] * y[last] + self._slope(delta, k) * lag[k]
        return z

    def _slope(self, delta: Array, k: int) -> float:
        """d(delta)/da at node k, by a power law through it and the last node of its kind; first a parabola."""
        j = k - int(np.flatnonzero(self.surface.is_vertex)[1])
        width, before = self.surface.radii[[k, j]] - self.flat
        if not delta[k] > 0 < width:
            return 0.0
        power = 2.0
        if j > 0 and before > 0 < delta[j]:
            power = math.log(delta[k] / delta[j]) / math.log(width / before)
        return float(power * delta[k] / width)


@dataclass(frozen=True, eq=False)
class Events:
    """First touches of the vertices, of increasing radius: ``a``, ``delta``, ``P``, and ``S``, the stiffness from here
    to the next node's touch (it belongs to a radius beyond ``a``). ``violation``: largest negative force or gap of
    all events, relative; ``p`` (events, m): forces on the ``surface`` [N]."""

    a: Array
    delta: Array
    P: Array
    S: Array
    p: Array
    violation: float

    @property
    def valid(self) -> bool:
        """Whether the contact is a disc that only grows, so that these are solutions of the contact problem."""
        return self.violation <= ROUNDED and bool((np.diff(self.delta) > 0).all())

    def quantity(self, name: str) -> Array:
        """The column of a loading's quantity: "depth", "load" or "radius"."""
        return {"depth": self.delta, "load": self.P, "radius": self.a}[name]

    @property
    def rising(self) -> Events:
        """Events at a larger depth and load than all before: all, where the contact is a disc that only grows."""
        first = np.zeros(1)
        rises = [x > np.maximum.accumulate(np.append(first, x[:-1])) for x in (self.delta, self.P)]
        both = np.logical_and(*rises)
        return replace(self, **{name: getattr(self, name)[both] for name in ("a", "delta", "P", "S", "p")})


def nested_events(contact: SurfaceContact, a0: float, to: str, maximum: float, spare: int = 0) -> Events:
    """Nested contact: all contact radii of a growing disc from one factor, whose leading blocks serve one radius each.

    The events at the vertices beyond the flat radius ``a0`` up to the first one at which the quantity ``to`` ("depth",
    "load" or "radius") reaches ``maximum`` [m or N], and up to ``spare`` more that hold as well; up to the last
    candidate where none does.
    """
    surface = contact.surface
    k = np.flatnonzero(surface.is_vertex & (surface.radii > a0 * (1 + ROUNDED)) & (contact.delta > 0))
    quantity = {"depth": contact.delta, "load": contact.P, "radius": surface.radii}[to][k]
    beyond = np.flatnonzero(quantity >= maximum * (1 - ROUNDED))
    needed = int(beyond[0]) + 1 if beyond.size else k.size
    k = k[: needed + spare]
    depth = contact.delta[k]
    p, negative = _conditions(contact, k)
    sound = (negative[needed:] <= ROUNDED) & (np.diff(depth)[max(needed - 1, 0) :] > 0)
    n = needed + int(np.cumprod(sound).sum())
    violation = float(np.max(negative[:n], initial=0.0))
    return Events(surface.radii[k[:n]], depth[:n], contact.P[k[:n]], contact.S[k[:n]], p[:n], violation)


def _conditions(contact: SurfaceContact, k: Array) -> tuple[Array, Array]:
    """Forces on the surface (events, m) [N] when the nodes ``k`` touch, and the largest negative force or gap of each
    event, relative to the largest force or the depth."""
    depth, surface = contact.delta[k], contact.surface
    touching = surface.normal[k]
    inside = np.arange(len(surface.C))[:, None] <= touching
    w, forces = contact.pressed(touching, depth)
    p = forces[surface.normal]
    gap = contact.f[:, None] - depth + (contact.L @ w)[surface.normal]
    pull = np.max(-p[surface.exempt :] / np.abs(p).max(axis=0, initial=0.0), axis=0, initial=0.0)
    return forces.T, np.maximum(pull, np.max(np.where(inside[surface.normal], 0.0, -gap) / depth, axis=0, initial=0.0))


@dataclass(frozen=True, eq=False)
class Increment:
    """One solved increment: depth ``delta`` [m], load ``P`` [N], nodal forces ``p`` (n,) [N], the ``active`` nodes,
    and the relative violation of the three conditions."""

    delta: float
    P: float
    p: Array
    active: Array
    violation: float

    @property
    def is_disc(self) -> bool:
        """Whether the nodes in contact are the innermost ones."""
        return bool(self.active[: int(self.active.sum())].all())


def solve_depths(contact: SurfaceContact, depths: Sequence[float] | Array) -> list[Increment]:
    """Increments at prescribed depths [m], each started from the contact nodes of the one before."""
    active = np.zeros(contact.f.size, dtype=bool)
    increments = []
    for depth in depths:
        increments.append(_increment(contact, float(depth), active))
        active = increments[-1].active
    return increments


def solve_loads(contact: SurfaceContact, loads: Sequence[float] | Array) -> list[Increment]:
    """Increments at prescribed loads [N]: P(delta) is piecewise linear and convex, so Newton's method ends exactly."""
    active = np.zeros(contact.f.size, dtype=bool)
    increments: list[Increment] = []
    delta = 0.0
    for load in loads:
        for _ in range(MOST_STEPS):
            active = active if active.any() else contact.f <= contact.f[0]
            y = _on(contact, active, np.ones(int(active.sum())))
            z = _on(contact, active, contact.f[active])
            delta = (load + float(z.sum())) / float(y.sum())
            step = _increment(contact, delta, active)
            if abs(step.P - load) <= ROUNDED * load:
                break
            active = step.active
        else:
            steps = MOST_STEPS
            raise SolveError(f"contact: the load {load:g} N was not reached after {steps} steps (at {step.P:g} N)")
        increments.append(step)
    return increments


def _on(contact: SurfaceContact, active: Array, values: Array) -> Array:
    """Forces on the ``active`` nodes that give them the displacements ``values``: C_AA^-1 values."""
    n = int(active.sum())
    L = contact.L[:n, :n] if active[:n].all() else cholesky(contact.surface.C[np.ix_(active, active)], lower=True)
    half = solve_triangular(L, values, lower=True, check_finite=False)
    return solve_triangular(L, half, lower=True, trans="T", check_finite=False)


def _increment(contact: SurfaceContact, delta: float, active: Array) -> Increment:
    """Newton's method on the set of active nodes (Hintermueller, Ito and Kunisch 2002)."""
    exempt = contact.surface.exempt
    active = active.copy()
    for _ in range(MOST_STEPS):
        p, gap = _state(contact, delta, active)
        force_limit = ROUNDED * np.abs(p).max()
        wanted = np.where(active, p >= -force_limit, gap < -ROUNDED * delta)
        wanted[:exempt] |= wanted.any()
        if np.array_equal(wanted, active):
            return _checked(contact, delta, p, gap, active)
        active = wanted
    active = _least_squares(contact, delta)
    return _checked(contact, delta, *_state(contact, delta, active), active)


def _state(contact: SurfaceContact, delta: float, active: Array) -> tuple[Array, Array]:
    """Forces with the ``active`` nodes in contact, and the gaps of all nodes, round-off where they touch."""
    p = np.zeros_like(contact.f)
    if active.any():
        p[active] = _on(contact, active, delta - contact.f[active])
    return p, contact.f - delta + contact.surface.C[:, active] @ p[active]


def _checked(contact: SurfaceContact, delta: float, p: Array, gap: Array, active: Array) -> Increment:
    largest = float(np.abs(p).max())
    negative_force = float(np.max(-p[contact.surface.exempt :], initial=0.0)) / largest if largest else 0.0
    violation = max(negative_force, float(np.where(active, np.abs(gap), -gap).max(initial=0.0)) / delta)
    if violation > 10 * ROUNDED:
        raise SolveError(f"contact: conditions violated by {violation:.1e} (relative) at depth {delta:g} m")
    return Increment(delta, float(p.sum()), p, active, violation)


def _least_squares(contact: SurfaceContact, delta: float) -> Array:
    """Active set by another way: the forces p >= 0 minimise |L^T p - L^-1 (delta - f)| (Lawson and Hanson 1974, Ch.
    23); those of ``exempt`` nodes are differences of two."""
    exempt, n = contact.surface.exempt, contact.f.size
    matrix = np.column_stack([contact.L.T, -contact.L.T[:, :exempt]])
    try:
        p, _ = nnls(matrix, solve_triangular(contact.L, delta - contact.f, lower=True))
    except RuntimeError:
        raise SolveError(f"contact: no active set found at depth {delta:g} m") from None
    return (p[:n] > 0) | ((np.arange(n) < exempt) & p.any())

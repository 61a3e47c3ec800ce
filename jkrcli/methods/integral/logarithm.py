"""Adhesion of finite range under a kernel with a logarithm: that of a body whose modulus changes right below the
contact.

K(x, t) = (tau(|x - t|) + tau(x + t))/2 goes like ln|x - t|, and phi bends at the edge of the contact like
(a - x) ln(a - x): panels of polynomials that every contact radius shares would have to be narrow everywhere. Here each
radius has panels of its own that crowd at its edge, on which the equation of ``finite_range`` is collocated,

    (pi/2) phi(x) + int_0^a K(x,t) phi(t) dt = delta - F(x) + (2/pi) s R(x),
    R(x) = int_a^c K(x,t) sqrt(c^2 - t^2) dt,

by product integration: int K l_j of the panels' polynomials l_j, with points that crowd at t = x. Around the contact
t = c cos(theta), in which the tension is smooth. phi is linear in delta and s, so that one inverse for each radius
serves every annulus around it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from ...base.numerics import Array
from ...bodies.indenters import Indenter
from .finite_range import ATTRACTION_INNER, ContactDiscs, Rims, profile_kinks, tension_arc
from .fredholm import abel_arcs, angle, crowded_rule, distinct, gauss, lagrange, panel_means, rule, to_legendre

# The panels of a contact, and the points of the integrals.
# theory: of a panel at the edge over the next: those beyond the neighbour lie a third of their width away, where ten
# Gauss nodes integrate a logarithm to 1e-9
LOGARITHM_RATIO = 0.25
LOGARITHM_CUTS = 8  # theory: the last panel is 1e-5 of the radius, and the error goes with its square
LOGARITHM_AROUND_KINK = 4  # choice: cuts on both sides of a kink, over which F is averaged
# points next to t = x for each node of a panel, and the power in which all points crowd; tuned on linear laws of
# 1:20, by `make range-bounds`: with half as many points columns err by 3e-6 at a = 5 h
LOGARITHM_CLOSE = 4
LOGARITHM_POWER = 4  # tuned on linear laws of 1:20, by `make range-bounds`: 3 errs ten times as much, 5 no less
LOGARITHM_ARC = 24  # points across the annulus; tuned on linear laws, by `make range-bounds`: good to 1e-8
LOGARITHM_ARC_MORE = 10  # and for each widest panel in it; tuned on linear laws, by `make range-bounds`
LOGARITHM_STEP = 0.0125  # theory: of asinh(s/finest): to the power 8, with what varies over s, far below rounding
LOGARITHM_FLOOR = 1e-11  # theory: of what is left of g - 1 beyond k_max: a thin soft layer of nu = 1/2 has g of 1e-4
# a decade of the kernel's spline, for each node of a panel; tuned on linear laws of 1:20, by `make range-bounds`
LOGARITHM_KNOTS = 60
# Widest panels: of the top layer's thickness, where they are not more than so many
LOGARITHM_WIDEST = 0.5  # tuned on linear laws of 1:20, by `make range-bounds`
LOGARITHM_MOST = 40  # choice: a matrix of some hundred rows
LOGARITHM_NARROWER = 0.8  # choice: from one width of panels that is tried to the next
LOGARITHM_HALVINGS = 40  # choice: of them, down to 1e-4 of the reach
LOGARITHM_ROUNDING = 1e-10  # theory: (ln 10/600)^4/384, the kernel's spline between knots, times its fourth derivative
LOGARITHM_CHUNK = 32  # radii that are solved together; choice: what fits in a cache
LOGARITHM_NEAREST = 1e-14  # theory: of the reach; the logarithm below adds less than g of a thin soft layer can feel

Transform = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Edged:
    """Contacts of the radii ``a`` (m,) [m] with as many panels each, solved for the right-hand sides 1 and F.

    Distances from the edge [m]: ``edges`` (m, panels + 1) of panels and ``z`` (m, n) of nodes, whose weights are ``w``
    [m]; ``inverse``: of pi/2 + K, (m, n, n); ``flat, shaped``: phi of both sides; ``edge``: int_0^a K(a,t) phi(t) dt as
    sums over right-hand sides, (m, n); ``ends``: (pi/2) phi(a) of both, (2, m).
    """

    rows: Array
    a: Array
    edges: Array
    z: Array
    w: Array
    inverse: Array
    flat: Array
    shaped: Array
    edge: Array
    ends: Array

    @classmethod
    def of(cls, rows: Array, a: Array, edges: Array, F: Array, F_edge: Array, tau: Transform, order: int) -> Edged:
        """From the ``edges`` (m, panels + 1) of the panels, as distances [m] from the edge of the contact, with the
        panel means ``F`` (m, n) of the Abel image, and ``F_edge`` at the edge itself."""
        width = np.diff(edges)
        nodes, weights = (rule(order)[0] + 1) / 2, rule(order)[1] / 2
        z = edges[:, :-1, None] + width[..., None] * nodes
        z, w = z.reshape(a.size, -1), (width[..., None] * weights).reshape(a.size, -1)
        # Int K(x, t) l_j(t) dt of all nodes' polynomials, (m, n, n) at the nodes x and (m, n) at the edge x = a
        m, panels = width.shape
        own, across = np.abs(z[:, :, None] - z[:, None, :]), (2 * a[:, None] - z)[:, :, None] - z[:, None, :]
        K = tau(own) * w[:, None, :]
        blocks = K.reshape(m, panels, order, panels, order)
        # Close panels: their polynomials at points that crowd at t = x, or at the end that faces it
        u, v = crowded_rule(LOGARITHM_CLOSE * order, LOGARITHM_POWER)
        away, facing = v[:, None] * lagrange(order, u), v[:, None] * lagrange(order, 1 - u)
        # Distances from each Gauss node of points on both sides that crowd at it, and weights times polynomials there
        close, weight = crowded_rule(LOGARITHM_CLOSE * order, LOGARITHM_POWER)
        below, above = nodes[:, None] * close, (1 - nodes)[:, None] * close
        weights = np.concatenate([nodes[:, None] * weight, (1 - nodes)[:, None] * weight], axis=1)
        points = np.concatenate([nodes[:, None] - below, nodes[:, None] + above], axis=1)
        inside, both = np.concatenate([below, above], axis=1), weights[..., None] * lagrange(order, points)
        each = np.arange(panels)
        d = width[:, :, None, None]
        blocks[:, each, :, each, :] = np.einsum("mpiq,iqj->pmij", tau(d * inside) * d, both)
        outer, nearer = d[:, 1:], d[:, :-1]
        to_outer = tau(nearer * (1 - nodes)[:, None] + outer * u) * outer
        to_nearer = tau(outer * nodes[:, None] + nearer * u) * nearer
        blocks[:, each[:-1], :, each[1:], :] = np.moveaxis(to_outer @ away, 1, 0)
        blocks[:, each[1:], :, each[:-1], :] = np.moveaxis(to_nearer @ facing, 1, 0)
        # The mirrored half: only that of the panel at the axis is close, to itself
        mirrored = tau(across) * w[:, None, :]
        last = width[:, -1, None, None]
        mirrored[:, -order:, -order:] = (tau(last * (1 - nodes)[:, None] + last * u) * last) @ facing
        at_edge = tau(z) * w
        first = width[:, :1]
        at_edge[:, :order] = (tau(first * u) * first) @ away
        K, at_edge = (K + mirrored) / 2, (at_edge + tau(2 * a[:, None] - z) * w) / 2
        K.reshape(a.size, -1)[:, :: z.shape[1] + 1] += math.pi / 2
        inverse = np.linalg.inv(K)
        flat, shaped = inverse.sum(axis=2), np.einsum("mij,mj->mi", inverse, F)
        ends = np.stack([1 - np.sum(at_edge * flat, axis=1), F_edge - np.sum(at_edge * shaped, axis=1)])
        return cls(rows, a, edges, z, w, inverse, flat, shaped, np.einsum("mi,mij->mj", at_edge, inverse), ends)


@dataclass(frozen=True, eq=False)
class EdgedDiscs(ContactDiscs):
    """Contact discs with panels of their own, in ``groups`` of as many of them."""

    body: LogarithmicAttraction
    groups: tuple[Edged, ...]

    def F(self, x: Array) -> Array:
        return self.body.indenter.abel(x)

    @cached_property
    def sides(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        ends, integrals = np.empty((2, 2, self.a.size))
        for group in self.groups:
            ends[:, group.rows] = group.ends
            for integral, phi in zip(integrals, (group.flat, group.shaped), strict=True):
                integral[group.rows] = math.pi / 2 * np.sum(group.w * phi, axis=1)
        return (ends[0], integrals[0]), (ends[1], integrals[1])

    def rims(self, b: Array, s: Array | float) -> Rims:
        b, s = np.broadcast_to(b, self.a.shape), np.broadcast_to(s, self.a.shape)
        arcs = abel_arcs(self.F, self.body.kinks, self.a, b, ATTRACTION_INNER)
        delta, P, gap = (np.empty_like(self.a) for _ in range(3))
        for group in self.groups:
            rows = group.rows
            delta[rows], P[rows], gap[rows], _ = self._state(group, b[rows], s[rows], arcs[rows])
        return Rims(self.a, self.a + b, delta, P, gap)

    def _state(self, group: Edged, b: Array, s: Array, arcs: Array) -> tuple[Array, Array, Array, Array]:
        """delta [m], P [N], the gap at c [m] and phi at the nodes of each contact of a group."""
        arc = Annulus.of(group.a, b, self.body.arc_points(b))
        c, root, (edge, z) = group.a + b, np.sqrt(b * (2 * group.a + b)), group.ends
        # K between the nodes and the points of the annulus
        beyond = arc.beyond[:, None, :]
        K = self.body.mean(group.z[:, :, None] + beyond, (2 * group.a[:, None] - group.z)[:, :, None] + beyond)
        R, opens = K @ arc.tension[..., None], (K @ arc.weights[..., None])[..., 0]
        R_edge = np.sum(self.body.mean(arc.beyond, 2 * group.a[:, None] + arc.beyond) * arc.tension, axis=1)
        pulled = R_edge - np.sum(group.edge * R[..., 0], axis=1)
        delta = (z - s * (2 / math.pi * pulled + root)) / edge
        phi_R = (group.inverse @ R)[..., 0]
        phi = delta[:, None] * group.flat - group.shaped + 2 / math.pi * s[:, None] * phi_R
        integral = math.pi / 2 * np.sum(group.w * phi, axis=1) - s * (c**2 * arc.whole - group.a * root) / 2
        own = np.sum(arc.weights * arc.of_tension(self.body.tau, arc.angles, 0.0), axis=1)
        gap = arcs - delta * arc.whole - s * b + np.sum(opens * group.w * phi, axis=1) - 2 / math.pi * s * own
        return delta, 2 * self.E_star * integral, 2 / math.pi * gap, phi

    def inside(self, rims: Rims, s: float, x: Array) -> Array:
        (group,), order = self.groups, self.body.order
        phi = self._state(group, rims.c - self.a, np.array([s]), np.zeros(1))[3]
        nodes = rims.delta - self.F(group.a - group.z[0]) - math.pi / 2 * phi[0]
        z, edges = self.a - x, group.edges[0]
        panel = np.clip(edges.searchsorted(z, side="right") - 1, 0, edges.size - 2)
        local = (z - edges[panel]) / np.diff(edges)[panel]
        return np.sum(lagrange(order, local) * nodes.reshape(-1, order)[panel], axis=1)

    def separations(self, rims: Rims, s: float, r: Array) -> Array:
        b, separations = rims.c - self.a, np.empty_like(r)
        for group in self.groups:
            rows, a = group.rows, group.a
            phi = self._state(group, b[rows], np.full(a.size, s), np.zeros(a.size))[3]
            arc = Annulus.of(a, b[rows], self.body.arc_points(b[rows]))
            for i, x in enumerate(r[rows].T):
                upto = Annulus.of(a, x - a, self.body.arc_points(x - a))
                beyond, (eta, past) = upto.beyond[:, None, :], arc.place(upto.beyond)
                K = self.body.mean(group.z[:, :, None] + beyond, (2 * a[:, None] - group.z)[:, :, None] + beyond)
                smooth = ((group.w * phi)[:, None] @ K)[:, 0]
                smooth -= 2 / math.pi * s * arc.of_tension(self.body.tau, eta, past)
                apart = -rims.delta[rows] * upto.whole - s * tension_arc(a, rims.c[rows], x)
                separations[rows, i] = apart + np.sum(upto.weights * smooth, axis=1)
        for i, x in enumerate(r.T):
            separations[:, i] += abel_arcs(self.F, self.body.kinks, self.a, x - self.a, ATTRACTION_INNER)
        return 2 / math.pi * separations


@dataclass(frozen=True, eq=False)
class Annulus:
    """Points t = c cos(theta) across annuli a < t < c that crowd at a, (m, points).

    ``angles``: theta [rad]; ``beyond``: t - a [m], without cancellation; ``weights``: those of an integral over theta,
    dt/sqrt(c^2 - t^2), and ``tension`` of sqrt(c^2 - t^2) dt [m^2]; ``whole``: theta at a.
    """

    a: Array
    c: Array
    angles: Array
    beyond: Array
    weights: Array
    tension: Array
    whole: Array

    @classmethod
    def of(cls, a: Array, b: Array, points: int) -> Annulus:
        c = a + b
        whole, (u, v) = angle(b, c), crowded_rule(points, LOGARITHM_POWER)
        theta, less = whole[:, None] * (1 - u), whole[:, None] * u
        beyond = 2 * c[:, None] * np.sin((whole[:, None] + theta) / 2) * np.sin(less / 2)
        weights = whole[:, None] * v
        return cls(a, c, theta, beyond, weights, weights * (c[:, None] * np.sin(theta)) ** 2, whole)

    def place(self, beyond: Array) -> tuple[Array, Array]:
        """The angles [rad], and the distances beyond c [m], of points ``beyond`` a [m]."""
        short = (self.c - self.a)[:, None] - beyond
        return angle(np.maximum(short, 0.0), self.c[:, None]), np.maximum(-short, 0.0)

    def of_tension(self, tau: Transform, eta: Array, past: Array | float) -> Array:
        """int_a^c K(y, t) sqrt(c^2 - t^2) dt [m] at y = c cos(eta) + ``past``, (m, n), split at t = y."""
        c, (u, v) = self.c[:, None, None], crowded_rule(self.angles.shape[1], LOGARITHM_POWER)
        eta, past = eta[..., None], np.asarray(past)[..., None]
        total = np.zeros(eta.shape[:-1])
        for ends in (0.0, self.whole[:, None, None]):
            step = (ends - eta) * u
            theta = eta + step
            distance = past + 2 * c * np.abs(np.sin(eta + step / 2) * np.sin(step / 2))
            total += np.sum(tau(distance) * np.abs(ends - eta) * v * (c * np.sin(theta)) ** 2, axis=-1)
        across = c * np.cos(eta) + past + self.a[:, None, None] + self.beyond[:, None, :]
        return (total + np.sum(tau(across) * self.tension[:, None, :], axis=-1)) / 2


def widest_panel(tau: Transform, order: int, reach: float, tolerance: float, thickness: float) -> float:
    """The widest panel [m] of ``order`` nodes to which the kernel ``tau`` is a polynomial, at its own width and beyond,
    up to the ``tolerance`` of what it adds to phi; nearer points are integrated with ``tau`` as it is, which varies
    there over less than the ``thickness`` [m] of the top layer."""
    order *= 2  # theory: what Gauss quadrature integrates
    project = to_legendre(order)
    for widest in reach * LOGARITHM_NARROWER ** np.arange(1, LOGARITHM_HALVINGS):
        begin = widest * np.arange(1, 2 * reach / widest)
        s, _ = gauss(begin, np.minimum(begin + widest, 2 * reach), *rule(order))
        values = widest * tau(s)
        rough = np.abs((values.reshape(-1, order) @ project)[:, -2:])
        if np.max(rough, initial=0.0) < tolerance * max(np.max(np.abs(values), initial=0.0), 1.0):
            break
    return min(float(widest), max(LOGARITHM_WIDEST * thickness, reach / LOGARITHM_MOST))


def panels_to(reach: float, thickness: float) -> int:
    """The panels, at least, of a contact as wide as the ``reach`` [m] on a top layer of a ``thickness`` [m]."""
    return LOGARITHM_CUTS + math.ceil(min(reach / (LOGARITHM_WIDEST * thickness), LOGARITHM_MOST))


@dataclass(frozen=True, eq=False)
class LogarithmicAttraction:
    """A body whose kernel has a logarithm, ready for a tension of any strength and range up to the radius ``reach``
    [m].

    ``tau``: of the distance [m], between ``LOGARITHM_NEAREST`` and twice the ``reach``; ``order``: nodes on a
    panel, ``widest`` [m].
    """

    indenter: Indenter
    E_star: float
    tau: Transform
    reach: float
    order: int
    widest: float
    is_half_space: ClassVar[bool] = False
    rounding: ClassVar[float] = LOGARITHM_ROUNDING

    @property
    def kinks(self) -> Array:
        return profile_kinks(self.indenter, self.reach)

    def arc_points(self, b: Array) -> int:
        """Points across annuli ``b`` [m] wide."""
        return LOGARITHM_ARC + math.ceil(LOGARITHM_ARC_MORE * float(np.max(b, initial=0.0)) / self.widest)

    def mean(self, distance: Array, across: Array) -> Array:
        """K [1/m] of the distances x - t and x + t."""
        return (self.tau(distance) + self.tau(across)) / 2

    def discs(self, a: Array) -> EdgedDiscs:
        """Contact discs of the radii ``a`` >= 0 [m] below ``reach``."""
        order, joints = self.order, np.array(self.indenter.joints)
        edges = [self._edges(float(radius)) for radius in a]
        counts, groups = np.array([len(each) for each in edges]), []
        for count in np.unique(counts):
            alike = np.flatnonzero(counts == count)
            for rows in np.array_split(alike, math.ceil(alike.size / LOGARITHM_CHUNK)):
                F = np.zeros((rows.size, (count - 1) * order))
                for mean, row in zip(F, rows, strict=True):
                    if a[row] > 0:
                        upwards = np.maximum(a[row] - edges[row][::-1], 0.0)
                        mean[:] = panel_means(self.indenter.abel, joints, upwards, order, ATTRACTION_INNER)[::-1]
                own = np.array([edges[row] for row in rows])
                groups.append(Edged.of(rows, a[rows], own, F, self.indenter.abel(a[rows]), self.tau, order))
        return EdgedDiscs(self.E_star, a, self, tuple(groups))

    def _edges(self, a: float) -> Array:
        """Ends of panels as distances [m] from the edge of a contact of the radius ``a`` [m]: crowded at it, and less
        at kinks of the profile."""
        kinks = np.array([kink for kink in (self.indenter.a0, *self.indenter.kinks) if 0 < kink < a])
        ends = distinct([0.0, *(a - kinks), a]) if a > 0 else np.zeros(2)
        edges = [np.zeros(1)]
        for n, (lo, hi) in enumerate(pairwise(ends)):
            cuts = LOGARITHM_CUTS if n == 0 else LOGARITHM_AROUND_KINK
            steps = LOGARITHM_RATIO ** np.arange(cuts, -1, -1)
            last = hi == ends[-1]
            middle = hi if last else (lo + hi) / 2
            marks = lo + (middle - lo) * steps
            if not last:
                marks = np.append(
                    marks, hi - (hi - middle) * LOGARITHM_RATIO ** np.arange(1, LOGARITHM_AROUND_KINK + 1)
                )
                marks = np.append(marks, hi)
            for low, high in pairwise([lo, *marks]):
                pieces = max(math.ceil((high - low) / self.widest), 1)
                edges.append(np.linspace(low, high, pieces + 1)[1:])
        return np.concatenate(edges)

    def apart(self, c: Array, s: float, gap: float) -> Rims:
        """The states in which nothing touches and the surfaces attract within the radii ``c`` > 0 [m], nearer than
        ``gap`` [m]."""
        zero, drawn = np.zeros_like(c), np.empty_like(c)
        for rows in np.array_split(np.arange(c.size), math.ceil(c.size / LOGARITHM_CHUNK)):
            arc = Annulus.of(zero[rows], c[rows], self.arc_points(c[rows]))
            drawn[rows] = np.sum(arc.weights * arc.of_tension(self.tau, arc.angles, 0.0), axis=1)
        pull = c + 2 / math.pi * drawn
        P = -math.pi * self.E_star * s / 2 * c**2
        return Rims(zero, c, self.indenter.f(c) - 2 / math.pi * s * pull - gap, P, np.full_like(c, gap))

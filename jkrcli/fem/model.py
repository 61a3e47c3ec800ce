"""The contact of a body condensed onto its surface, on one mesh: its answer to a loading, and the errors of that."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from ..base.errors import Estimate, InputError, JkrError, Refusal, SolveError, Unknown
from ..base.numerics import MOST_SOLVES, MOST_STEPS, ROUNDED, SAME, SETTLED, Array, cubic_spline, pchip
from ..base.process import StageClock
from ..bodies.indenters import Indenter, Paraboloid
from ..bodies.problem import INCOMPRESSIBLE, AnyGraded, HalfSpace, Loading, Material, Problem, Specimen
from ..methods.layered.no_slip import coulomb_series, half_space_compliances, ring_transforms
from ..methods.layered.solver import largest_radius
from ..methods.layered.surface_tension import SurfaceTensionSolver
from ..methods.radii import DENSE, ROOM, graded_radii
from ..series import CoarseSeries, ErrorBudget, PressureTable, RawSeries, Series, Solution, filter_plateaus
from . import mesh
from .elasticity import ElasticSystem, StiffnessFactor, Surface, assemble, condense, factorise, missing_displacement
from .options import FEMOptions, Solver

# --------------------------------------------------------------------------------------------------
# Unilateral contact on the condensed surface: nested (all contact radii at once, sliding or sticking) and by
# increments (sliding).
#
# Nodal forces p >= 0, gaps f - delta + C p >= 0, and one of the two zero at every node, with f the indenter's
# profile at the nodes and C the surface compliance; but for round-off, of the largest force and of the depth.


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

    @property
    def S(self) -> Array:
        """Stiffness dP/d(delta) of the contact sets {0..k} [N/m]."""
        return np.cumsum(self.y**2)[self.surface.last]

    @property
    def T(self) -> Array:
        """Load that the profile takes off: P = S delta - T for the contact set {0..k} [N]."""
        return np.cumsum(self.y * self.z)[self.surface.last]

    @property
    def delta(self) -> Array:
        """Depth at which node k touches with zero force, all nodes inside it in contact [m]."""
        return (self.z / self.y)[self.surface.normal]

    @property
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

    @property
    def _ramps(self) -> Array:
        """What the rows of each node read of a field that begins to act there (n, 2) [m times y]."""
        y = self.y[np.column_stack([self.surface.normal, self.surface.last])]
        return np.einsum("nij,nj->ni", self.rows[: len(y)], y)

    @property
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
                # d(delta)/da at node k, by a power law through it and the last node of its kind; first a parabola
                j = k - int(np.flatnonzero(self.surface.is_vertex)[1])
                width, before = self.surface.radii[[k, j]] - self.flat
                if not delta[k] > 0 < width:
                    slope = 0.0
                else:
                    power = 2.0
                    if j > 0 and before > 0 < delta[j]:
                        power = math.log(delta[k] / delta[j]) / math.log(width / before)
                    slope = float(power * delta[k] / width)
                z[last] = delta[k] * y[last] + slope * lag[k]
        return z


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
    # Forces (m, events) [N] when these nodes touch, and the largest negative force or gap of each event, relative to
    # the largest force or the depth
    touching = surface.normal[k]
    inside = np.arange(len(surface.C))[:, None] <= touching
    w, forces = contact.pressed(touching, depth)
    p = forces[surface.normal]
    gap = contact.f[:, None] - depth + (contact.L @ w)[surface.normal]
    pull = np.max(-p[surface.exempt :] / np.abs(p).max(axis=0, initial=0.0), axis=0, initial=0.0)
    negative = np.maximum(pull, np.max(np.where(inside[surface.normal], 0.0, -gap) / depth, axis=0, initial=0.0))
    sound = (negative[needed:] <= ROUNDED) & (np.diff(depth)[max(needed - 1, 0) :] > 0)
    n = needed + int(np.cumprod(sound).sum())
    violation = float(np.max(negative[:n], initial=0.0))
    return Events(surface.radii[k[:n]], depth[:n], contact.P[k[:n]], contact.S[k[:n]], forces.T[:n], violation)


@dataclass(frozen=True, eq=False)
class Increment:
    """One solved increment: depth ``delta`` [m], load ``P`` [N], nodal forces ``p`` (n,) [N], the ``active`` nodes,
    and the relative violation of the three conditions."""

    delta: float
    P: float
    p: Array
    active: Array
    violation: float


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
    # Active set by another way: the forces p >= 0 minimise |L^T p - L^-1 (delta - f)| (Lawson and Hanson 1974, Ch.
    # 23); those of `exempt` nodes are differences of two.
    exempt, n = contact.surface.exempt, contact.f.size
    matrix = np.column_stack([contact.L.T, -contact.L.T[:, :exempt]])
    try:
        p, _ = nnls(matrix, solve_triangular(contact.L, delta - contact.f, lower=True))
    except RuntimeError:
        raise SolveError(f"contact: no active set found at depth {delta:g} m") from None
    active = (p[:n] > 0) | ((np.arange(n) < exempt) & p.any())
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


# --------------------------------------------------------------------------------------------------
# What a mesh makes of the edge of the contact, known from a half-space with the same surface vertices.
#
# The vertex that just touches is not the edge of the contact: it lies beyond it by a fraction of the local node
# spacing that depends on the mesh near the surface, not on the body below. On a half-space the edge is known, delta =
# F(a), or the exact one of the same surface tension, so one solve with the same surface vertices and elements gives
# the factor a / r for every vertex.
#
# Where surfaces stick, the rows of L for a node read the field next to the edge of the disc that ends there: with the
# densities xi of a stuck disc (``layered.no_slip``), whose value at the edge is the amplitude of its singular fields,
# the halves in both rows of the node at r are
#
#     y delta - z = M xi(r) + N xi'(r)
#
# up to the second order of the spacing, M and N (2, 2) of the mesh and its uppermost material alone. On the half-
# space xi is known in closed form where its surface is displaced by 1, r^2 downwards or r, r^3 outwards. The
# transform of a ring's tractions gives the work that they do on such a displacement: with the coefficients C_n, Q_n
# of rho^n in C, Q,
#
#     xi(r) = (2/pi) (C_0, -4 C_2 r^2, 2 Q_1 r, -16 Q_3 r^3).
#
# A contact that grows has xi = 0 at its edge a, and xi(r) = xi_1 (delta - delta_H(r)) where a disc of radius r would
# have xi_1 under a unit displacement: with y = M xi_1, and ramps N xi_1,
#
#     z = delta_H(r) y + delta_H'(r) N xi_1.

# The exact half-space under surface tension, and node spacings over the radius between which meshes tell where the
# edge is.
EDGE_NEAR = 0.8  # of the vertices' radii, beyond which their contact radii do not lie; choice: spare
EDGE_ACCURACY = 1e-7  # theory: a thousandth of what the half-space's own mesh errs by, as below
# theory: a tenth of a spacing is then half the error of the half-space's own mesh, 1e-4 of the radius
EDGE_RESOLVED = 5e-4
# Node spacings over the radius, down to which the half-space's own mesh tells the fraction of a spacing; tuned on
# the thin layer of `make paper`, by `make paper`: below, what that mesh errs by as a whole is read as one
EDGE_TELLING = 1e-2


def edge_correction(surface: Surface, body: mesh.MeshedBody, reach: float, indenter: Indenter) -> Array:
    """Edge correction of surfaces that slide: contact radius over vertex radius for the candidate vertices beyond the
    flat radius, by increasing radius, out to ``reach`` [m], from the ``surface`` of a half-space like that of the
    ``body``."""
    profile: Indenter = indenter if indenter.a0 > 0 else Paraboloid(reach)
    events = nested_events(SurfaceContact(surface, profile.f(surface.radii)), profile.a0, "radius", np.inf)
    spline, a0 = None, profile.a0
    if body.tension:  # delta_H [m] on a half-space with that surface tension
        specimen = Specimen((), HalfSpace(mesh.surface_material(body.materials[0])), surface_tension=body.tension)
        solver = SurfaceTensionSolver(profile, specimen)
        beyond = np.geomspace(EDGE_NEAR * (events.a[0] - a0), (events.a[-1] - a0) / EDGE_NEAR, DENSE)
        solved = solver.solved(a0 + beyond, solver.plan(a0 + beyond, EDGE_ACCURACY))
        spline = cubic_spline(np.log(beyond), np.log(solved.delta))

    def log_exact(u: Array) -> Array:
        a = a0 + np.exp(u)
        return np.log(profile.abel(a)) if spline is None else spline(np.log(a - a0))

    # Radii where the `exact` displacement is delta: Newton's method in logarithms from the vertex radii.
    u, step = np.log(events.a - a0), SAME
    for _ in range(MOST_STEPS):
        value, ahead = log_exact(u), log_exact(u + step)
        change = (value - np.log(events.delta)) * step / (ahead - value)
        u -= change
        if np.abs(change).max() < SETTLED:
            break
    return _in_step(a0 + np.exp(u), a0, events.a) / events.a


def _in_step(edges: Array, a0: float, vertices: Array) -> Array:
    """Radii of the edge (n,) at ``vertices`` [m], those where nodes are close by the fraction of a spacing that it lies
    off the vertices before: it is the same at all radii."""
    spacing = np.gradient(vertices)
    told = spacing >= EDGE_TELLING * (vertices - a0)
    last = told & (spacing < 2 * EDGE_TELLING * (vertices - a0))
    if told.all() or not last.any():
        return edges
    fraction = float(np.mean((edges - vertices)[last] / spacing[last]))
    return np.where(told, edges, vertices + fraction * spacing)


# ---------------------------------------------------------------------- surfaces that stick
def edge_rows(surface: Surface, material: Material) -> Array:
    """N M^-1 (n, 2, 2) [m] of each node on the ``surface`` of a half-space of the ``material``, which makes the ramps
    N xi_1 of y; zero on the axis, and where nodes are so close that it does not matter."""
    beyond = surface.radii > 0
    r, rows = surface.radii[beyond], np.column_stack([surface.normal, surface.last])[beyond]
    displaced = np.zeros((len(surface.C), 4))
    displaced[surface.normal, :2] = surface.radii[:, None] ** [0, 2]
    displaced[rows[:, 1], 2:] = r[:, None] ** [1, 3]
    halves = solve_triangular(cholesky(surface.C, lower=True), displaced, lower=True)[rows]
    # xi pi/2 (n, 2, 4) at `r` (n,) for the displacements 1, r^2 downwards and r, r^3 outwards, and its slope.
    beta, eta = mesh.oscillation(material)
    zz, _, rr = half_space_compliances(material)
    waves = [(F[:4], polynomial.polyder(F)[:4]) for F in (coulomb_series(-eta), coulomb_series(eta))]
    C, Q = (np.array(pair) for pair in ring_transforms(beta, *waves))
    outward = math.sqrt(zz / rr)
    factors = np.column_stack([C[:, 0], -4 * C[:, 2], 2 * outward * Q[:, 1], -16 * outward * Q[:, 3]])
    powers = np.array([0, 2, 1, 3])
    xi, slope = factors * r[:, None, None] ** powers, factors * powers * r[:, None, None] ** np.maximum(powers - 1, 0)
    unit, profile = [0, 2], [1, 3]
    edge = np.linalg.solve(xi[..., unit], xi[..., profile])  # displacements that take profiles' xi off at r
    M = _over(halves[..., unit], xi[..., unit])
    N = _over(halves[..., unit] @ edge - halves[..., profile], slope[..., unit] @ edge - slope[..., profile])
    reading = np.zeros((surface.radii.size, 2, 2))
    close = np.gradient(surface.radii)[beyond] < EDGE_RESOLVED * r
    reading[beyond] = np.where(close[:, None, None], 0.0, _over(N, M))
    return reading


def _over(A: Array, B: Array) -> Array:
    """A B^-1 of the pairs of matrices (n, 2, 2)."""
    return np.swapaxes(np.linalg.solve(np.swapaxes(B, 1, 2), np.swapaxes(A, 1, 2)), 1, 2)


# Which events of the contact make a series.
# of the distance to the next event; choice: one as close to the end gives way to it, no two rows alike
EVENT_CLOSE = 0.05
EVENT_FEWEST = 4  # events for slopes; theory: S takes two, dS/da three, and its error one more
# events beyond the end of the loading; theory: the end lies between two, and dS/da takes one more
EVENT_SPARE = 2


Columns = tuple[Array, Array, Array]  # a [m], delta [m], P [N]
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Discretisation:
    """What a model is made from: ``layout`` on its body, element ``order``, ``mixed``: layers with a pressure unknown,
    ``reach``: radius out to which surface nodes are candidates [m]; ``solver``: of the sparse factor; ``sticks``:
    whether contact forces are also radial; ``reduced``: whether elements are integrated at their centres alone."""

    layout: mesh.Layout
    order: int
    mixed: tuple[int, ...]
    reach: float
    solver: Solver = "auto"
    sticks: bool = False
    reduced: bool = False

    def coarser(self, factor: float) -> Discretisation:
        return replace(self, layout=self.layout.coarser(factor))

    def on_half_space(self, body: mesh.MeshedBody) -> Discretisation:
        """The same surface vertices on a homogeneous ``body``."""
        mixed = tuple(i for i in self.mixed if i == 0)
        return replace(self, layout=self.layout.on(body), mixed=mixed)

    def build(self, clock: StageClock) -> Model:
        """Mesh, assemble, factorise and condense."""
        with clock("mesh"):
            grid = self.layout.grid()
        with clock("assembly"):
            system = assemble(grid, self.layout.body, self.order, self.mixed, self.reduced)
        return self.condensed(system, clock)

    def condensed(self, system: ElasticSystem, clock: StageClock) -> Model:
        """Factorise and condense the assembled ``system``."""
        candidates = int(np.searchsorted(system.radii, self.reach * (1 + ROUNDED)))
        with clock("factorisation"):
            last = system.both(candidates) if self.sticks else system.normal[:candidates]
            factor = factorise(system, last, self.solver)
        with clock("surface solves"):
            surface = condense(system, factor)
            if self.layout.body.cut_below:
                # What the cut-out half-space lacks, under a uniform pressure on the candidates' disc [m/N]
                below = self.layout.body.materials[-1]
                assert not isinstance(below, AnyGraded)  # it stands for a half-space, which is homogeneous
                forces = np.zeros(len(surface.C))
                forces[surface.normal] = -surface.areas / surface.areas.sum()
                loads = factor.loads(forces)
                w = missing_displacement(system, below, factor.solve(loads))
            else:
                w = 0.0
        if self.layout.body.completed:
            surface = surface.shifted(w)
        return Model(self, system, factor, surface, w)


@dataclass(frozen=True, eq=False)
class Model:
    """Elastic system, factor and condensed surface of one body; ``missing``: displacement per load that a cut-out
    half-space lacks [m/N], contained in the surface compliance where the body is ``completed``."""

    discretisation: Discretisation
    system: ElasticSystem
    factor: StiffnessFactor
    surface: Surface
    missing: float

    @property
    def body(self) -> mesh.MeshedBody:
        return self.discretisation.layout.body

    def contact(self, indenter: Indenter) -> SurfaceContact:
        """The contact problem with ``indenter``."""
        heights = indenter.f(self.surface.radii)
        if not self.surface.sticks:
            return SurfaceContact(self.surface, heights)
        rows = edge_rows(self.half_space, mesh.surface_material(self.body.materials[0]))
        return StuckContact(self.surface, heights, rows, indenter.a0)

    @property
    def half_space(self) -> Surface:
        """Surface of a half-space of the uppermost material with the same vertices: this one where it is one."""
        if self.body.cut_below and len(self.body.materials) == 1:
            return self.completed()
        body = mesh.homogenised_half_space(self.body, self.discretisation.reach)
        return self.discretisation.on_half_space(body).build(StageClock()).completed()

    def completed(self) -> Surface:
        """The surface of the whole half-space, whether or not the model is completed itself."""
        return self.surface if self.body.completed else self.surface.shifted(self.missing)

    def field(self, p: Array) -> Array:
        """Displacements (and pressures) of all unknowns under the contact forces ``p`` (m,) on the surface [N]."""
        return self.factor.solve(self.factor.loads(self.surface.direction * p))


# ---------------------------------------------------------------------- solved, and the answer to a loading
@dataclass(frozen=True, eq=False)
class MeshLevel:
    """One mesh of a sequence, with the contact problem solved on it; every part is computed once, when first needed.

    ``model`` under ``indenter``: the ``contact`` problem and its ``touches`` (events with the radii of vertices);
    ``correct``: whether the edge of the contact is sought between the vertices.
    """

    model: Model
    indenter: Indenter
    contact: SurfaceContact
    touches: Events
    correct: bool

    @classmethod
    def of(cls, recipe: Discretisation, indenter: Indenter, correct: bool, deepest: float) -> MeshLevel:
        """Mesh and solve ``recipe`` out to the depth ``deepest`` [m], or its last candidate."""
        model = recipe.build(StageClock())
        contact = model.contact(indenter)
        return cls(
            model, indenter, contact, nested_events(contact, indenter.a0, "depth", deepest, EVENT_SPARE), correct
        )

    @cached_property
    def events(self) -> Events:
        """The touches with the radii of the contact."""
        if not self.correct:
            return self.touches
        if isinstance(self.contact, StuckContact):
            edges = self.contact.edges[np.searchsorted(self.model.surface.radii, self.touches.a)]
            return replace(self.touches, a=edges)
        reach = self.model.discretisation.reach
        factors = edge_correction(self.model.half_space, self.model.body, reach, self.indenter)
        return replace(self.touches, a=self.touches.a * factors[: self.touches.a.size])

    def edge_at(self, vertices: Array) -> Array:
        """The radius of the contact that just touches the vertices at radii ``vertices`` (n,) [m], 0 where there is
        none."""
        return vertices * np.interp(vertices, self.touches.a, self.events.a / self.touches.a)

    def slopes(self, a: Array) -> tuple[Array, Array] | None:
        """S [N/m] and dS/da [N/m^2] at radii ``a`` [m]; None where the contact has too few nodes, or no correction.

        From one touch to the next P(delta) is linear for each contact set, so that the increments of P over delta are
        the mean of those sets' stiffness, and belong to the mean radius on the way; dS/da are their differences.
        """
        events = self.events
        if not (self.correct and events.valid) or events.a.size < EVENT_FEWEST:
            return None
        # Mean of the radius over delta from each touch to the next [m].
        delta, a0 = self.events.delta, self.indenter.a0
        inner = delta[:-1, None] + np.diff(delta)[:, None] * (1 + GAUSS_X) / 2
        radii = power_interpolated(delta, self.events.a - a0, inner.ravel()).reshape(inner.shape)
        S, at = np.diff(events.P) / np.diff(events.delta), a0 + radii @ GAUSS_W / 2
        dS, middle = np.diff(S) / np.diff(at), (at[1:] + at[:-1]) / 2
        if not (dS > 0).all():
            return None
        return power_interpolated(at, S, a), power_interpolated(middle, dS, a)


@dataclass(frozen=True, eq=False)
class Run:
    """One mesh's answer to the loading of ``problem``: the ``columns`` of the series on ``level``; where the loading
    was followed in ``increments``, these, their ``raw`` series and the number of those ``dropped`` from it."""

    problem: Problem
    level: MeshLevel
    columns: Columns
    increments: tuple[Increment, ...] = ()
    raw: RawSeries | None = None
    dropped: int = 0

    @classmethod
    def of_increments(cls, problem: Problem, level: MeshLevel, increments: list[Increment]) -> Run:
        """The increments with those dropped whose radius is not their own (the paper's filter)."""
        raw = raw_series(level.model.surface, increments)
        if level.correct:
            raw = replace(
                raw, a=level.edge_at(raw.a), element=level.edge_at(raw.a + raw.element) - level.edge_at(raw.a)
            )
        series, dropped = filter_plateaus(raw)
        return cls(problem, level, (series.a, series.delta, series.P), tuple(increments), raw, dropped)

    @property
    def deepest(self) -> float:
        """Depth of the last point [m]."""
        return float(self.columns[1][-1])

    @property
    def at_touches(self) -> Run | None:
        """The same contact at the moments at which its edge reaches nodes, to the deepest increment; None where there
        are no increments, or these moments are not known."""
        if self.raw is None or not self.level.correct:
            return None
        loading = Loading("depth", float(self.raw.delta.max()))
        columns = nested_columns(loading, self.level.events, self.problem.indenter.a0)
        return Run(replace(self.problem, loading=loading), self.level, columns)

    def companion(self, ratio: float) -> MeshLevel:
        """A solved mesh whose elements are ``ratio`` times as large."""
        recipe = self.level.model.discretisation.coarser(ratio)
        return MeshLevel.of(recipe, self.problem.indenter, self.level.correct, self.deepest)


# ---------------------------------------------------------------------- from the options
def run(options: FEMOptions, problem: Problem, clock: StageClock, reach: float | None = None) -> Run:
    """Solve on one mesh of the given sizes; ``reach``: radius to mesh finely, where it is known [m]."""
    reach = mesh.expected_reach(options, problem) if reach is None else reach
    model, contact, touches = _solve_large_enough(options, problem, clock, reach)
    by_increments = options.contact == "incremental" or not touches.valid
    level = MeshLevel(model, problem.indenter, contact, touches, options.edge_correction and touches.valid)
    if by_increments and problem.sticks:
        raise Refusal(
            f"the contact is not a growing disc of nodes (violation {touches.violation:.1e}), so that it is not known "
            'where points stuck: load less, give a larger mesh.spacing, or set specimen.surface = "sliding"'
        )
    if by_increments:
        with clock("contact"):
            loading = problem.loading
            if loading.spacing == "given" and loading.to == "load":
                increments = solve_loads(contact, loading.values)
            elif loading.spacing == "load":
                end = solve_depths(contact, depths_of(problem, touches)[-1:])
                steps = np.arange(1, loading.points) / loading.points
                increments = [*solve_loads(contact, end[0].P * steps), *end]
            else:
                increments = solve_depths(contact, depths_of(problem, touches))
        with clock("edge correction"):
            return Run.of_increments(problem, level, increments)
    with clock("edge correction"):
        events = level.events
    return Run(problem, level, nested_columns(problem.loading, events, problem.indenter.a0))


def _solve_large_enough(
    options: FEMOptions, problem: Problem, clock: StageClock, reach: float
) -> tuple[Model, SurfaceContact, Events]:
    """Solve on meshes for growing contact radii until the loading's end lies within the candidates."""
    loading, mixed = problem.loading, mesh.mixed_layers(options, problem)
    for _ in range(MOST_SOLVES):
        layout = mesh.layout_for(options, problem, reach)
        reduced = options.integration == "reduced"
        recipe = Discretisation(layout, options.order, mixed, reach, options.solver, problem.sticks, reduced)
        model = recipe.build(clock)
        with clock("contact"):
            contact = model.contact(problem.indenter)
            events = nested_events(contact, problem.indenter.a0, loading.to, loading.maximum, EVENT_SPARE)
        needed = needed_radius(problem, events, reach)
        if needed is None:
            return model, contact, events
        if options.contact_radius is not None:
            # A contact radius [m] to provide for: needed, which a mesh too small has shown, or that of the wide
            # body, and a twentieth for what a finite body or a coarse mesh changes
            try:
                expected = largest_radius(problem)
            except JkrError:
                expected = 0.0
            enough = ROOM * max(needed, expected)
            raise Refusal(
                f"contact leaves the refined zone: mesh.contact_radius is {options.contact_radius:g} m, "
                f"this loading needs about {enough:.2g} m: give that or leave it out"
            )
        wider = mesh.within(problem, options.margin * needed)
        if wider <= reach:
            break
        reach = wider
    raise Refusal(
        f"contact reaches the edge of the body or of the indenter's profile, {reach:g} m, before the "
        f"{loading.to} reaches {loading.maximum:g}: load less"
    )


# ---------------------------------------------------------------------- what a loading asks of the surface
def power_interpolated(x: Array, y: Array, at: Array) -> Array:
    """y(x) at the positive values ``at``: a monotone cubic in logarithms, a power law outside the table."""
    u, v, wanted = np.log(x), np.log(y), np.log(at)
    first, last = (v[1] - v[0]) / (u[1] - u[0]), (v[-1] - v[-2]) / (u[-1] - u[-2])
    inner = pchip(u, v)(np.clip(wanted, u[0], u[-1]))
    return np.exp(inner + first * np.minimum(wanted - u[0], 0.0) + last * np.maximum(wanted - u[-1], 0.0))


def nested_columns(loading: Loading, events: Events, a0: float) -> Columns:
    """The series that a loading asks of the events: those before its end and that end itself, or the given values.
    Refusal: a value below the first event. ``a0``: flat radius [m]."""
    table = {"radius": events.a - a0, "depth": events.delta, "load": events.P}
    x, shift = table[loading.to], a0 if loading.to == "radius" else 0.0
    if loading.spacing == "given":
        first = float(x[0]) + shift
        unit = {"depth": "m", "load": "N", "radius": "m"}[loading.to]
        if loading.values[0] < first * (1 - ROUNDED):
            raise Refusal(
                f"loading: {loading.to} {loading.values[0]:g} {unit} lies below the first that the mesh resolves, "
                f"{first:.3g} {unit}: take a smaller mesh.smallest (layout zones: mesh.element_size), or larger values"
            )
        a, delta, P = _at(table, x, np.array(loading.values) - shift)
    elif x.size < 2:
        return events.a, events.delta, events.P
    else:
        end = loading.maximum - shift
        ahead = min(max(int(np.searchsorted(x, end)), 1), x.size - 1)
        before = x < end - EVENT_CLOSE * (x[ahead] - x[ahead - 1])
        last = _at(table, x, np.array([end]))
        a, delta, P = (np.append(y[before], value) for y, value in zip(table.values(), last, strict=True))
    return a + a0, delta, P


def _at(table: dict[str, Array], x: Array, values: Array) -> list[Array]:
    """All columns of the table at ``values`` of the column ``x``."""
    return [values if y is x else power_interpolated(x, y, values) for y in table.values()]


def nodal_forces(contact: SurfaceContact, events: Events, delta: Array) -> Array:
    """Forces on the surface [N] at depths ``delta`` [m]: the events', and solved for where a depth is no event's."""
    if contact.surface.sticks:
        return contact.pressed(contact.surface.last[contact.set_at(delta)], delta)[1].T
    near = np.clip(np.searchsorted(events.delta, delta * (1 - 1e-12)), 0, events.delta.size - 1)
    p = events.p[near]
    other = np.flatnonzero(np.abs(events.delta[near] / delta - 1) > 1e-12)
    for i, step in zip(other, solve_depths(contact, delta[other]), strict=True):
        p[i] = step.p
    return p


def needed_radius(problem: Problem, events: Events, reach: float) -> float | None:
    """Contact radius, about, at which the loading ends [m]; None where the events reach it."""
    loading, a0 = problem.loading, problem.indenter.a0
    if not events.a.size:
        return 2 * reach
    last = events.quantity(loading.to)[-1]
    if last >= loading.maximum * (1 - ROUNDED):
        return None
    power = {"depth": 1 / 2, "load": 1 / 3, "radius": 1.0}[loading.to]
    return float(a0 + (events.a[-1] - a0) * ROOM * (loading.maximum / last) ** power)


def depths_of(problem: Problem, events: Events) -> Array:
    """Displacements of the increments [m]; other quantities are interpolated in the table of events."""
    loading, a0, events = problem.loading, problem.indenter.a0, events.rising
    if loading.to == "depth" and loading.spacing == "given":
        return np.array(loading.values)
    steps = np.arange(1, loading.points + 1) / loading.points
    deepest = loading.maximum
    if loading.to != "depth":
        deepest = float(_depths_at(events, loading.to, np.array([loading.maximum]), a0)[0])
    if loading.spacing == "depth":
        return deepest * steps
    if loading.spacing == "given":
        return _depths_at(events, loading.to, np.array(loading.values), a0)
    largest = a0 + float(power_interpolated(events.delta, events.a - a0, np.array([deepest]))[0])
    radii = graded_radii(a0, largest, loading.points) if loading.spacing == "log" else a0 + (largest - a0) * steps
    depths = _depths_at(events, "radius", radii, a0)
    depths[-1] = deepest
    return depths


def _depths_at(events: Events, quantity: str, values: Array, a0: float) -> Array:
    """Depths [m] at which ``quantity`` ("radius" or "load") has the given values [m or N]."""
    shift = a0 if quantity == "radius" else 0.0
    return power_interpolated(events.quantity(quantity) - shift, events.delta, values - shift)


def raw_series(surface: Surface, increments: list[Increment]) -> RawSeries:
    """Increments with the radius of the outermost active vertex (0 where there is none beyond the axis)."""
    a = np.array([np.max(surface.radii[step.active & surface.is_vertex], initial=0.0) for step in increments])
    delta, P = (np.array(values) for values in ([s.delta for s in increments], [s.P for s in increments]))
    vertices = surface.radii[surface.is_vertex]
    k = np.clip(np.searchsorted(vertices, a * (1 + ROUNDED), side="right"), 1, vertices.size - 1)
    return RawSeries(a, delta, P, element=vertices[k] - vertices[k - 1])


def pressures(surface: Surface, forces: Array) -> PressureTable:
    """Downward nodal force over nodal area; nodes without area (the axis of second-order elements) are left out."""
    forces = forces[:, surface.normal]
    areas, radii = surface.areas, surface.radii
    wide = areas > 1e-6 * areas.max() * (radii / radii[-1]) ** 2
    return PressureTable(radii[wide], forces[:, wide] / areas[wide])


# --------------------------------------------------------------------------------------------------
# Error budget of a finite-element series: against a second mesh with larger elements, and for what the cut costs.

# How errors are concluded from what larger elements change.
# errors in what doubling the sizes changes: first order leaves 1, and meshes differ by luck
BUDGET_LOADS = 1.4  # tuned on the bodies of `make failures`, by `make failures`
BUDGET_RADII = 2.0  # tuned on the bodies of `make failures`, by `make failures`
BUDGET_FALLEN = 1.5  # of changes over errors, at most; tuned on random bodies, by `make bounds`: 3 is second order
# Of what doubling changed before over what it changes, at most; where that falls by more, the meshes agree by
# accident:
BUDGET_PLAUSIBLE = 12.0  # of loads; tuned on random bodies, by `make bounds`
BUDGET_PLAUSIBLE_RADII = 4.0  # of radii; tuned on random bodies, by `make bounds`
BUDGET_TENSION = 2.0  # times that of radii; choice: calibrated radii then err by up to the estimate itself
BUDGET_ROUND_OFF = 1e-12  # of radii; theory: 1e4 eps, as they come from a search


TOO_FEW = Unknown("fewer than four vertices in contact")


@dataclass(frozen=True, eq=False)
class Assessment:
    """The error budget over the judged part of a series, from the depth ``judged_from`` [m] on, and the relative
    ``errors`` row by row of P (at equal depth), a, S and dS where known, larger where few nodes are in contact;
    ``coarser``: what they are concluded from."""

    budget: ErrorBudget
    judged_from: float | None = None
    errors: Mapping[str, Array] = field(default_factory=dict)
    coarser: CoarseSeries | None = None


def assessed(run: Run, larger: Sequence[MeshLevel], ratio: float, truncation: Estimate) -> Assessment:
    """Relative errors of P at equal depth (discretisation) and of a (radius), by comparison with a level whose elements
    are ``ratio`` times as large, the first of the ``larger``, and of that with one of elements as much larger once
    more, where there is such; ``truncation``: as found by ``truncation_of``."""
    coarse = larger[0]
    if coarse.touches.a.size < 4 or run.level.touches.a.size < 4:
        return Assessment(ErrorBudget(TOO_FEW, truncation, TOO_FEW))
    run, rows = _with_events(run)
    fine, (a, delta, P) = run.level, run.columns
    judged = delta >= mesh.BUDGET_JUDGED_DEPTH * delta[-1]
    loads, radii = BUDGET_LOADS / (ratio - 1), BUDGET_RADII / (ratio - 1)
    radii *= BUDGET_TENSION if fine.model.body.tension else 1.0
    if not all(level.touches.valid and level.touches.a.size >= 4 for level in larger):
        larger = [coarse]
    there, radius = _on_coarse(run, larger, radii)
    values = [P, there, *(_load_on(level, run) for level in larger[1:])]

    # What larger elements change over the error that is left, by the order that the judged rows show where it is least,
    # in their mean or where they change most: 1 of first order, and where no third mesh tells it
    fallen = 1.0
    if len(values) > 2:
        last, before = (changes[judged] for changes in _changes(values))
        fallen = BUDGET_FALLEN
        if last.any():
            order = min(before.mean() / last.mean(), before[np.argmax(last)] / last.max()) - 1
            fallen = float(np.clip(order, 1.0, BUDGET_FALLEN))
    change = loads * _change(values, BUDGET_PLAUSIBLE) / fallen
    width = a - fine.indenter.a0  # errors fall by no more than its square, as those of a uniform mesh do
    load = np.maximum.accumulate(change * width**2) / width**2
    # the many rows of increments cross zero between nodes: what shallower rows leave of it is already that of a row
    load = np.maximum.accumulate(load[::-1])[::-1] if run.raw is not None else _envelope(load, delta)
    worst = radius if isinstance(radius, Unknown) else float(radius[judged].max())
    budget = ErrorBudget(discretisation=float(load[judged].max()), truncation=truncation, radius=worst)
    judged_from = float(delta[rows][judged[rows]][0])
    if isinstance(radius, Unknown) or isinstance(truncation, Unknown):
        return Assessment(budget, judged_from)
    errors = {"P": load + truncation, "a": radius}

    # S and S': what larger elements change at equal radius, which is most that of the radius, and of S what the error
    # of the radius makes of it, as meshes agree by accident; increments have no slopes of their own
    ours, theirs = (level.slopes(a) if run.raw is None else None for level in (fine, coarse))
    if ours is not None and theirs is not None:
        S, dS = (_envelope(radii * np.abs(other / own - 1), delta) for own, other in zip(ours, theirs, strict=True))
        errors |= {"S": np.maximum(S, a * ours[1] / ours[0] * radius), "dS": dS}
    cut = truncation * float(np.sign(np.mean(there - P)))
    other = None if run.raw is not None else _coarser(larger, delta, ratio, cut)
    return Assessment(budget, judged_from, {name: values[rows] for name, values in errors.items()}, other)


def _coarser(levels: Sequence[MeshLevel], delta: Array, ratio: float, cut: float) -> CoarseSeries | None:
    """The series of the ``levels``, each of elements ``ratio`` times as large as those before, as deep as ``delta``
    [m], of a body that is stiffer by the fraction ``cut``; None where the first one's contact is no disc that only
    grows, or too small."""
    if not levels:
        return None
    level, *larger = levels
    events = level.events.rising
    rows = slice(int(np.searchsorted(events.delta, delta[-1])) + 1)
    a, slopes = events.a[rows], level.slopes(events.a[rows])
    if slopes is None:
        return None
    P, S, dS = ((1 + cut) * values for values in (events.P[rows], *slopes))
    beyond = _coarser(larger, delta, ratio, cut)
    try:
        return CoarseSeries(Series(a, events.delta[rows], P, S, dS, a0=level.indenter.a0, coarser=beyond), ratio)
    except InputError:
        return None


def _with_events(run: Run) -> tuple[Run, Array]:
    """The run with all events up to its end among its columns, and the numbers of its own rows: two meshes agree by
    accident at a few given values more easily than at all of them."""
    a, delta, P = run.columns
    events = run.level.events
    if run.raw is not None or run.problem.loading.spacing != "given":
        return run, np.arange(a.size)
    others = events.delta < delta[-1]
    own = np.concatenate([np.ones(a.size, bool), np.zeros(int(others.sum()), bool)])
    columns = zip((a, delta, P), (events.a, events.delta, events.P), strict=True)
    merged = np.stack([np.append(ours, theirs[others]) for ours, theirs in columns])
    order = np.argsort(merged[1], kind="stable")
    return replace(run, columns=tuple(merged[:, order])), np.flatnonzero(own[order])


def _changes(values: Sequence[Array]) -> list[Array]:
    """Relative changes of ``values`` from each mesh to the next coarser one."""
    return [np.abs(coarser / finer - 1) for finer, coarser in itertools.pairwise(values)]


def _change(values: Sequence[Array], plausible: float) -> Array:
    """What larger elements change, relatively, and at least a ``plausible`` part of what still larger ones do."""
    change, *before = _changes(values)
    return np.max([change, *(other / plausible for other in before)], axis=0)


def _on_coarse(run: Run, larger: Sequence[MeshLevel], caution: float) -> tuple[Array, Array | Unknown]:
    """P [N] of the first coarser mesh at the depths of the series, and the relative error of the radius."""
    fine, coarse, (a, delta, _) = run.level, larger[0], run.columns
    if not (fine.touches.valid and coarse.touches.valid):
        # P [N] of the coarser mesh at depths `delta` [m], and the error of the radius, where the contact is no disc
        # that only grows: what larger elements change, at least the distance to the next vertex.
        there = raw_series(coarse.model.surface, solve_depths(coarse.contact, delta))
        surface = fine.contact.surface
        vertices = surface.radii[surface.is_vertex]
        k = np.clip(np.searchsorted(vertices, a * (1 - ROUNDED)), 0, vertices.size - 2)
        change = np.maximum(caution * np.abs(there.a / a - 1), (vertices[k + 1] - vertices[k]) / a)
        return there.P, _envelope(change, delta)
    return _load_on(coarse, run), _radius([level.events for level in (fine, *larger)], a, delta, caution)


def _load_on(level: MeshLevel, run: Run) -> Array:
    """P [N] of a coarser ``level`` at the depths of the series, where its contact is a disc that only grows."""
    delta, touches = run.columns[1], level.touches
    there = load_at(level.contact, delta)
    if run.raw is not None:
        return there
    # a series of touches interpolates between them
    return np.where(delta < touches.delta[0], there, power_interpolated(touches.delta, touches.P, delta))


def _envelope(errors: Array, delta: Array) -> Array:
    """Largest of the errors from each depth up to the deepest, and at least of those in the deepest decade: the
    changes between two meshes pass through zero here and there, the errors need not."""
    deepest = float(np.max(errors[delta >= 0.1 * delta[-1]]))
    return np.maximum(np.maximum.accumulate(errors[::-1])[::-1], deepest)


def load_at(contact: SurfaceContact, delta: Array) -> Array:
    """P [N] at depths ``delta`` [m] of a disc that grows node by node: linear between the nodes' touches."""
    k = contact.set_at(delta)
    return contact.S[k] * delta - contact.T[k]


def _radius(levels: Sequence[Events], a: Array, delta: Array, caution: float) -> Array | Unknown:
    """Relative error of the radius: what larger elements change at equal depth (a vertex radius is off by a fraction of
    the spacing), plus where the series' radii differ from the events' (increments); ``levels``: from the finest on.

    Below the meshes' first events, where the spacing is uniform, the change grows like the inverse radius.
    """
    events, coarse = levels[:2]
    first, last = max(coarse.delta[0], events.delta[0]), min(coarse.delta[-1], events.delta[-1])
    if first >= last or delta[-1] < first:
        return Unknown("the mesh and the coarser mesh have no contact radius in common")
    fine = power_interpolated(events.delta, events.a, delta)
    samples = np.unique(np.clip(np.concatenate([delta, coarse.delta, events.delta]), first, last))
    radii = [power_interpolated(level.delta, level.a, samples) for level in levels]
    changes = _envelope(np.maximum(caution * _change(radii, BUDGET_PLAUSIBLE_RADII), BUDGET_ROUND_OFF), samples)
    at_first = power_interpolated(events.delta, events.a, np.array([first]))
    change = np.interp(delta, samples, changes) * np.maximum(at_first / fine, 1.0)
    return _envelope(change + np.abs(a / fine - 1), delta)


def truncation_of(run: Run, coarse: MeshLevel) -> Estimate:
    """Relative error of P at the deepest point from where the body is cut. Half-spaces: Betti's theorem, to first order
    in contact radius over size, which a completed body contains. Stacks on a rigid base: a free against a roller side,
    on the mesh of ``coarse``."""
    model, events, body = run.level.model, run.level.touches, run.level.model.body
    if body.cut_below:
        reached = events.delta >= run.deepest * (1 - ROUNDED)
        last = int(np.argmax(reached)) if events.valid and reached.any() else events.S.size - 1
        lacking = abs(model.missing) * float(events.S[last])
        return lacking**2 if body.completed else lacking
    if not body.cut_beside:
        return 0.0
    free = coarse.contact
    # The same body with its side fixed in radial direction; mesh and stiffness stay
    rim = coarse.model.system.basis.get_dofs("side").all()
    system = replace(coarse.model.system, free=np.setdiff1d(coarse.model.system.free, rim))
    roller = replace(free, surface=coarse.model.discretisation.condensed(system, StageClock()).surface)
    depth = np.array([run.deepest])
    if events.valid:
        return float(abs(load_at(roller, depth)[0] / load_at(free, depth)[0] - 1))
    return abs(solve_depths(roller, depth)[0].P / solve_depths(free, depth)[0].P - 1)


# --------------------------------------------------------------------------------------------------
# What is returned of a finite-element run: series with errors, facts, and warnings with numbers.


def to_solution(
    options: FEMOptions, run: Run, judged: Assessment, clock: StageClock, touches: Series | None = None
) -> Solution:
    """The solution: series, pressures, facts and warnings; of increments also the series at the ``touches``."""
    level = run.level
    with clock("contact"):
        if run.raw is None:
            forces = nodal_forces(level.contact, level.touches, run.columns[1])
        else:
            forces = np.array([step.p for step in run.increments])
        series, pressure = _series(run, judged), pressures(level.model.surface, forces)
    facts, warnings = _facts(options, run, judged.judged_from), tuple(_warnings(options, run))
    solution = Solution(
        run.problem, series, judged.budget, "fem", run.raw, pressure,
        facts=facts, timings=clock.seconds, warnings=warnings, touches=touches,
    )  # fmt: skip
    return solution.widened()


def series_of(run: Run, judged: Assessment) -> Series:
    """The series of a ``run`` without increments, its errors those of a profile known at points included."""
    return Solution(run.problem, _series(run, judged), judged.budget, "fem").widened().series


def _series(run: Run, judged: Assessment) -> Series:
    """The nonadhesive series with the errors that are known; S and dS/da only where theirs are."""
    a, delta, P = run.columns
    a0, contact = run.problem.indenter.a0, run.level.contact
    flat = int(np.count_nonzero(contact.surface.radii <= a0 * (1 + ROUNDED)))
    S0 = float(contact.S[flat - 1]) if a0 > 0 else 0.0
    S, dS = (run.level.slopes(a) if "dS" in judged.errors else None) or (None, None)
    values = {"a": a, "P": P, "S": S, "dS": dS}
    errors = {name: error * values[name] for name, error in judged.errors.items()}
    return Series(a, delta, P, S, dS, errors=errors, a0=a0, S0=S0, coarser=judged.coarser)


def _facts(options: FEMOptions, run: Run, judged_from: float | None) -> dict[str, Any]:
    """Plain numbers and words about mesh, solver and checks; ``judged_from``: least depth of the error budget [m]."""
    model, events, increments = run.level.model, run.level.touches, run.increments
    system, surface = model.system, model.surface
    grid, quality = system.grid, system.grid.quality()
    last = increments[-1] if increments else None
    p, P = (last.p, last.P) if last is not None else (events.p[-1], float(events.P[-1]))
    violation = max((step.violation for step in increments), default=events.violation)
    # Where the contact radii of the series come from
    if run.increments:
        where = "where the outermost one just touches" if run.level.correct else "not corrected"
        radii = f"vertices in contact after each increment of the loading, {where}"
    elif run.problem.loading.spacing == "given":
        radii = "at the given values, interpolated between the vertices' first touches"
    else:
        radii = "algorithm nested has one radius per node, where it first touches: points and spacing have no effect"
    contact_reason = "as asked"
    if run.increments and options.contact == "nested":
        nested = run.level.touches.violation
        contact_reason = f"the contact is not a growing disc of nodes (violation {nested:.1e}): solved by increments"
    mixed = model.system.mixed
    if not mixed:
        formulation = "displacement"
    else:
        nu = max(model.body.materials[i].surface.nu for i in mixed)
        formulation = f"displacement and pressure in layers {', '.join(str(i + 1) for i in mixed)} (nu = {nu:g})"
    return {
        "layout": options.layout,
        "element": grid.element,
        "order": options.order,
        "integration": options.integration,
        "elements": len(grid.cells),
        "vertices": len(grid.points),
        "unknowns": int(system.free.size),
        "candidates": int(surface.radii.size),
        "quality_min": float(quality.min()),
        "quality_median": float(np.median(quality)),
        "depth_m": grid.depth,
        "width_m": grid.width,
        "formulation": formulation,
        "contact": "nested" if last is None else "incremental",
        "contact_reason": contact_reason,
        "edge_correction": run.level.correct,
        "solver": f"{model.factor.factor.name}, nested dissection, contact nodes last",
        "factor_entries": model.factor.factor.entries,
        "residual": surface.residual,
        "asymmetry": surface.asymmetry,
        "balance": abs(system.vertical_reaction(model.field(p)) / P - 1),
        "complementarity": max(violation, 0.0),
        "increments": len(increments),
        "dropped": run.dropped,
        "events": int(events.a.size),
        "radii": radii,
    } | ({} if judged_from is None else {"judged_from_m": judged_from})


def _warnings(options: FEMOptions, run: Run) -> Iterator[str]:
    """Sentences on what may spoil the result."""
    problem, events, increments = run.problem, run.level.touches, run.increments
    nu = max(material.surface.nu for material in problem.specimen.materials)
    if options.order == 1 and options.integration == "full" and nu > INCOMPRESSIBLE:
        quads = ', or mesh.integration = "reduced"' if options.element == "quadrilateral" else ""
        yield (
            f"first-order elements lock near incompressibility: nu = {nu:g} > {INCOMPRESSIBLE:g}, the load may be "
            f"several per cent too large; take mesh.order = 2{quads}"
        )
    if options.contact == "nested" and not events.valid:
        yield (
            "nested contact does not hold here (a force or gap is negative by "
            f"{events.violation:.1e}, relative): increments were solved instead"
        )
    broken = sum(not step.active[: int(step.active.sum())].all() for step in increments)  # nodes, the innermost ones
    if broken:
        yield (
            f"in {broken} of {len(increments)} increments the contact is no full disc: its middle lifts off, or the "
            "surfaces touch again beyond the edge; the radius is that of the outermost vertex, and the adhesive curve "
            "is right only where adhesion holds the disc together: load less"
        )
    if run.dropped and (problem.loading.spacing in ("given", "log") or 2 * run.dropped > len(increments)):
        yield (
            f"{run.dropped} of {len(increments)} requested values share a node with another or lie below the first "
            "node and are not in the solution: take a finer mesh (mesh.spacing, mesh.smallest, mesh.element_size), or "
            "fewer values"
        )

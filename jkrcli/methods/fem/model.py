"""One mesh, one factorisation: the contact of a body condensed onto its surface, and its answer to a loading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import MOST_SOLVES, ROUNDED, Array, JkrError, Refusal, StageClock
from ...bodies import Graded, Indenter, Loading, Material, Problem
from ...series import PressureTable, RawSeries, filter_plateaus
from ..layered.layered import largest_radius
from ..radii import ROOM, graded_radii
from .body import MeshedBody, at_surface, half_space_like
from .edge import edge_correction, edge_rows
from .elasticity import ElasticSystem, assemble
from .far_field import missing_displacement
from .layout import Layout, layout_for
from .nested import Events, Increment, StuckContact, SurfaceContact, nested_events, solve_depths, solve_loads
from .options import FEMOptions, Solver
from .surface import StiffnessFactor, Surface, condense, factorise


@dataclass(frozen=True)
class LockingTuning:
    """Poisson's ratios beyond which displacements alone lock."""

    sliding: float = 0.49  # tuned on the gel of Sec. 4.3 and its like, by `make tuning`
    # tuned on bodies, by `make constants`: the edge of the shear locks before the layer does; at 0.45 and a/h = 10/3
    # radii err by 3e-4, mixed by 5e-5
    sticking: float = 0.4


@dataclass(frozen=True)
class EventTuning:
    """Which events of the contact make a series."""

    # of the distance to the next event; choice: one as close to the end gives way to it, no two rows alike
    close: float = 0.05
    fewest: int = 4  # events for slopes; theory: S takes two, dS/da three, and its error one more
    # events beyond the end of the loading; theory: the end lies between two, and dS/da takes one more
    spare: int = 2


TUNING, EVENTS = LockingTuning(), EventTuning()
Columns = tuple[Array, Array, Array]  # a [m], delta [m], P [N]
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(3)


def pressure_layers(materials: Sequence[Material], sticks: bool, above: float | None = None) -> tuple[int, ...]:
    """Layers that get a pressure unknown: those of a Poisson's ratio ``above`` this one (None: where displacements of
    surfaces that slide, or stick, lock)."""
    if above is None:
        above = TUNING.sticking if sticks else TUNING.sliding
    return tuple(i for i, material in enumerate(materials) if material.surface.nu > above)


@dataclass(frozen=True)
class Discretisation:
    """What a model is made from: ``layout`` on its body, element ``order``, ``mixed``: layers with a pressure unknown,
    ``reach``: radius out to which surface nodes are candidates [m]; ``solver``: of the sparse factor; ``sticks``:
    whether contact forces are also radial; ``reduced``: whether elements are integrated at their centres alone."""

    layout: Layout
    order: int
    mixed: tuple[int, ...]
    reach: float
    solver: Solver = "auto"
    sticks: bool = False
    reduced: bool = False

    def coarser(self, factor: float) -> Discretisation:
        return replace(self, layout=self.layout.coarser(factor))

    def on_half_space(self, body: MeshedBody) -> Discretisation:
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
            w = self._missing_displacement(system, factor, surface) if self.layout.body.cut_below else 0.0
        if self.layout.body.completed:
            surface = surface.shifted(w)
        return Model(self, system, factor, surface, w)

    def _missing_displacement(self, system: ElasticSystem, factor: StiffnessFactor, surface: Surface) -> float:
        """What the cut-out half-space lacks, under a uniform pressure on the candidates' disc [m/N]."""
        below = self.layout.body.materials[-1]
        assert not isinstance(below, Graded)  # it stands for a half-space, which is homogeneous
        forces = np.zeros(len(surface.C))
        forces[surface.normal] = -surface.areas / surface.areas.sum()
        loads = factor.loads(forces)
        return missing_displacement(system, below, factor.solve(loads))


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
    def body(self) -> MeshedBody:
        return self.discretisation.layout.body

    def contact(self, indenter: Indenter) -> SurfaceContact:
        """The contact problem with ``indenter``."""
        heights = indenter.f(self.surface.radii)
        if not self.surface.sticks:
            return SurfaceContact(self.surface, heights)
        rows = edge_rows(self.half_space, at_surface(self.body.materials[0]))
        return StuckContact(self.surface, heights, rows, indenter.a0)

    def with_roller(self) -> Model:
        """The same body with its side fixed in radial direction; the mesh and the stiffness stay."""
        rim = self.system.basis.get_dofs("side").all()
        system = replace(self.system, free=np.setdiff1d(self.system.free, rim))
        return self.discretisation.condensed(system, StageClock())

    @property
    def half_space(self) -> Surface:
        """Surface of a half-space of the uppermost material with the same vertices: this one where it is one."""
        if self.body.cut_below and len(self.body.materials) == 1:
            return self.completed()
        body = half_space_like(self.body, self.discretisation.reach)
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
            model, indenter, contact, nested_events(contact, indenter.a0, "depth", deepest, EVENTS.spare), correct
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
        factors = np.interp(vertices, self.touches.a, self.events.a / self.touches.a)
        return vertices * factors

    def slopes(self, a: Array) -> tuple[Array, Array] | None:
        """S [N/m] and dS/da [N/m^2] at radii ``a`` [m]; None where the contact has too few nodes, or no correction.

        From one touch to the next P(delta) is linear for each contact set, so that the increments of P over delta are
        the mean of those sets' stiffness, and belong to the mean radius on the way; dS/da are their differences.
        """
        events = self.events
        if not (self.correct and events.valid) or events.a.size < EVENTS.fewest:
            return None
        S, at = np.diff(events.P) / np.diff(events.delta), self._mean_radii()
        dS, middle = np.diff(S) / np.diff(at), (at[1:] + at[:-1]) / 2
        if not (dS > 0).all():
            return None
        return power_interpolated(at, S, a), power_interpolated(middle, dS, a)

    def _mean_radii(self) -> Array:
        """Mean of the radius over delta from each touch to the next [m]."""
        delta, a0 = self.events.delta, self.indenter.a0
        inner = delta[:-1, None] + np.diff(delta)[:, None] * (1 + GAUSS_X) / 2
        radii = power_interpolated(delta, self.events.a - a0, inner.ravel()).reshape(inner.shape)
        return a0 + radii @ GAUSS_W / 2


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

    def companion(self, ratio: float) -> MeshLevel:
        """A solved mesh whose elements are ``ratio`` times as large."""
        recipe = self.level.model.discretisation.coarser(ratio)
        return MeshLevel.of(recipe, self.problem.indenter, self.level.correct, self.deepest)


# ---------------------------------------------------------------------- from the options
def expected_reach(options: FEMOptions, problem: Problem) -> float:
    """Radius out to which the mesh is fine and nodes are candidates [m]."""
    largest = options.contact_radius if options.contact_radius is not None else largest_radius(problem)
    return _within(problem, options.margin * largest)


def _within(problem: Problem, reach: float) -> float:
    """The reach, or where the body or the indenter's profile ends before [m]."""
    edge = problem.specimen.radius if problem.specimen.radius is not None else math.inf
    return min(reach, edge, problem.indenter.r_max * (1 - ROUNDED))


def mixed_layers(options: FEMOptions, problem: Problem) -> tuple[int, ...]:
    """Layers that get a pressure unknown."""
    if options.order == 1 or options.formulation == "displacement":
        return ()
    materials = problem.specimen.materials
    return pressure_layers(materials, problem.sticks, None if options.formulation == "auto" else 0.0)


def run(options: FEMOptions, problem: Problem, clock: StageClock, reach: float | None = None) -> Run:
    """Solve on one mesh of the given sizes; ``reach``: radius to mesh finely, where it is known [m]."""
    reach = expected_reach(options, problem) if reach is None else reach
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
            increments = _increments(problem, contact, touches)
        with clock("edge correction"):
            return Run.of_increments(problem, level, increments)
    with clock("edge correction"):
        events = level.events
    return Run(problem, level, nested_columns(problem.loading, events, problem.indenter.a0))


def _solve_large_enough(
    options: FEMOptions, problem: Problem, clock: StageClock, reach: float
) -> tuple[Model, SurfaceContact, Events]:
    """Solve on meshes for growing contact radii until the loading's end lies within the candidates."""
    loading, mixed = problem.loading, mixed_layers(options, problem)
    for _ in range(MOST_SOLVES):
        layout = layout_for(options, problem, reach)
        reduced = options.integration == "reduced"
        recipe = Discretisation(layout, options.order, mixed, reach, options.solver, problem.sticks, reduced)
        model = recipe.build(clock)
        with clock("contact"):
            contact = model.contact(problem.indenter)
            events = nested_events(contact, problem.indenter.a0, loading.to, loading.maximum, EVENTS.spare)
        needed = needed_radius(problem, events, reach)
        if needed is None:
            return model, contact, events
        if options.contact_radius is not None:
            raise Refusal(
                f"contact leaves the refined zone: mesh.contact_radius is {options.contact_radius:g} m, "
                f"this loading needs about {_enough(problem, needed):.2g} m: give that or leave it out"
            )
        wider = _within(problem, options.margin * needed)
        if wider <= reach:
            break
        reach = wider
    raise Refusal(
        f"contact reaches the edge of the body or of the indenter's profile, {reach:g} m, before the "
        f"{loading.to} reaches {loading.maximum:g}: load less"
    )


def _enough(problem: Problem, needed: float) -> float:
    """A contact radius [m] to provide for: ``needed``, which a mesh too small has shown, or that of the wide body, and
    a twentieth for what a finite body or a coarse mesh changes."""
    try:
        expected = largest_radius(problem)
    except JkrError:
        expected = 0.0
    return ROOM * max(needed, expected)


def _increments(problem: Problem, contact: SurfaceContact, events: Events) -> list[Increment]:
    loading = problem.loading
    if loading.spacing == "given" and loading.to == "load":
        return solve_loads(contact, loading.values)
    return solve_depths(contact, depths_of(problem, events))


# ---------------------------------------------------------------------- what a loading asks of the surface
def power_interpolated(x: Array, y: Array, at: Array) -> Array:
    """y(x) at the positive values ``at``: a monotone cubic in logarithms, a power law outside the table."""
    from scipy.interpolate import PchipInterpolator

    u, v, wanted = np.log(x), np.log(y), np.log(at)
    first, last = (v[1] - v[0]) / (u[1] - u[0]), (v[-1] - v[-2]) / (u[-1] - u[-2])
    inner = PchipInterpolator(u, v)(np.clip(wanted, u[0], u[-1]))
    return np.exp(inner + first * np.minimum(wanted - u[0], 0.0) + last * np.maximum(wanted - u[-1], 0.0))


def nested_columns(loading: Loading, events: Events, a0: float) -> Columns:
    """The series that a loading asks of the events: those before its end and that end itself, or the given values.
    Refusal: a value below the first event. ``a0``: flat radius [m]."""
    table = {"radius": events.a - a0, "depth": events.delta, "load": events.P}
    x, shift = table[loading.to], a0 if loading.to == "radius" else 0.0
    if loading.spacing == "given":
        _refuse_unresolved(loading, float(x[0]) + shift)
        a, delta, P = _at(table, x, np.array(loading.values) - shift)
    elif x.size < 2:
        return events.a, events.delta, events.P
    else:
        end = loading.maximum - shift
        ahead = min(max(int(np.searchsorted(x, end)), 1), x.size - 1)
        before = x < end - EVENTS.close * (x[ahead] - x[ahead - 1])
        last = _at(table, x, np.array([end]))
        a, delta, P = (np.append(y[before], value) for y, value in zip(table.values(), last, strict=True))
    return a + a0, delta, P


def _at(table: dict[str, Array], x: Array, values: Array) -> list[Array]:
    """All columns of the table at ``values`` of the column ``x``."""
    return [values if y is x else power_interpolated(x, y, values) for y in table.values()]


def _refuse_unresolved(loading: Loading, first: float) -> None:
    unit = {"depth": "m", "load": "N", "radius": "m"}[loading.to]
    if loading.values[0] < first * (1 - ROUNDED):
        raise Refusal(
            f"loading: {loading.to} {loading.values[0]:g} {unit} lies below the first that the mesh resolves, "
            f"{first:.3g} {unit}: take a smaller mesh.smallest (layout zones: mesh.element_size), or larger values"
        )


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

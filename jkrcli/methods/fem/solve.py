"""One solved mesh from the options and a problem: how far it is fine, what it is made of, the contact on it."""

from __future__ import annotations

import math

from ...base import MOST_SOLVES, ROUNDED, JkrError, Refusal, StageClock
from ...bodies import Problem
from ..layered.layered import largest_radius
from .layout import layout_for
from .loading import depths_of, needed_radius, nested_columns
from .model import Discretisation, Model, pressure_layers
from .nested import Events, Increment, SurfaceContact, nested_events, solve_depths, solve_loads
from .options import FEMOptions
from .run import SPARE, MeshLevel, Run


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
    level = MeshLevel(model, problem.indenter, contact, touches, options.edge_correction and not by_increments)
    if by_increments and problem.sticks:
        raise Refusal(
            f"the contact is not a growing disc of nodes (violation {touches.violation:.1e}), so that it is not known "
            'where points stuck: load less, give a larger mesh.spacing, or set specimen.surface = "sliding"'
        )
    if by_increments:
        with clock("contact"):
            return Run.of_increments(problem, level, _increments(problem, contact, touches))
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
        model = Discretisation(layout, options.order, mixed, reach, options.solver, problem.sticks).build(clock)
        with clock("contact"):
            contact = model.contact(problem.indenter)
            events = nested_events(contact, problem.indenter.a0, loading.to, loading.maximum, SPARE)
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
    return 1.05 * max(needed, expected)


def _increments(problem: Problem, contact: SurfaceContact, events: Events) -> list[Increment]:
    loading = problem.loading
    if loading.spacing == "given" and loading.to == "load":
        return solve_loads(contact, loading.values)
    return solve_depths(contact, depths_of(problem, events))

"""Displacement and stress in the body at one state of adhesive contact.

The surface under a contact of radius a is where the indenter holds it, u_z = f(r) - delta for r <= a, and free outside;
it slides without friction, or has the u_r with which each point was touched (the contact is grown on the same mesh).
That is the nonadhesive field at a and the field of a flat punch of radius a, superposed (Eq. 13), in one solve. The
mesh is graded towards the contact's edge, where the stresses of an adhesive contact go like 1/sqrt(a - r).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from scipy.linalg import cho_solve

from ...base import ROUNDED, Array, InputError, Refusal, StageClock
from ...bodies import Problem
from .body import cut_out
from .edge import finest_spacing
from .grid import Grid
from .layout import scaled_layout
from .method import FEM
from .model import Discretisation, Model, pressure_layers
from .stress import Stress, TractionLine


@dataclass(frozen=True)
class StateTuning:
    """The mesh for the field at one contact radius."""

    order: int = 4  # of the elements; tuned on gel and coating, by `make tuning`
    spacing: float = 0.2  # element size over the distance from the edge; tuned on gel and coating, by `make tuning`
    stuck: float = 0.1  # the same of surfaces that stick, which must be grown on it; choice: as exact there
    growth: float = 0.2  # beyond the contact; tuned on the bodies of `make tuning`, by `make tuning`
    finest: float = 1e-5  # radii from the edge with elements of one size; tuned on gel and coating, by `make tuning`
    near: float = 3.0  # radii within which tractions are judged; choice: what the error stands for


TUNING = StateTuning()


@dataclass(frozen=True, eq=False)
class ContactState:
    """The body in contact of radius ``a`` [m] at displacement ``delta`` [m] and load ``P`` [N].

    ``grid``: its vertices, those of interfaces once for each layer; ``displacement`` (n, 2): u_r, u_z [m];
    ``stress`` (4, n): rr, tt, zz, rz [Pa], tension positive; ``lines``: tractions by name, "surface" first, then
    "interface 1" ... and "base" where the specimen ends there.
    """

    a: float
    delta: float
    P: float
    grid: Grid
    displacement: Array
    stress: Array
    lines: dict[str, TractionLine]

    @cached_property
    def mises(self) -> Array:
        """Von Mises' equivalent stress [Pa], (n,)."""
        rr, tt, zz, rz = self.stress
        return np.sqrt(((rr - tt) ** 2 + (tt - zz) ** 2 + (zz - rr) ** 2) / 2 + 3 * rz**2)

    @cached_property
    def imbalance(self) -> dict[str, float]:
        """Compressive force that passes through each line less the load, relative to the line's ``size``."""
        return {name: (line.load - self.P) / line.size for name, line in self.lines.items()}

    @cached_property
    def error(self) -> dict[str, float]:
        """Mean error of each line's tractions zz within three contact radii, relative to their mean size."""
        return {name: line.error(TUNING.near * self.a) for name, line in self.lines.items()}


def contact_state(
    method: FEM, problem: Problem, a: float, delta: float, surface: Callable[[Array], Array] | None = None
) -> ContactState:
    """The field at contact radius ``a`` [m] and displacement ``delta`` [m] of the indenter.

    ``surface``: the displacement [m] of the body at radii [m] within the contact, where it is not that of a rigid
    indenter: what an elastic one leaves of it.

    ``method`` gives where an unbounded body is cut (``depth``, ``width``) and the ``solver``; the mesh is made for
    ``a``. Errors: Refusal, InputError.
    """
    if surface is not None:
        problem = replace(problem, indenter=replace(cast(Any, problem.indenter), material=None))
    elif problem.indenter.material is not None and not problem.is_half_space:
        raise Refusal("fields: under an elastic indenter the displacement of the body's surface must be given")
    reason = replace(method, contact_radius=a, layout="scaled", element_size=None, order=2).refusal(problem)
    if reason is not None:
        raise Refusal(reason)
    edge = problem.specimen.radius
    if edge is not None and a >= edge:
        raise InputError(f"fields: contact radius {a:g} m reaches the edge of the body, {edge:g} m")
    body = cut_out(problem, a, method.depth, method.width)
    spacing, finest = TUNING.spacing, TUNING.finest
    if problem.sticks:
        spacing = TUNING.stuck
        finest = max(finest, finest_spacing(body.materials[0]) * TUNING.order / (2 * spacing))
    layout = scaled_layout(body, "triangle", a, a, finest * a, spacing, TUNING.growth)
    mixed = pressure_layers(body.materials, problem.sticks)
    model = Discretisation(layout, TUNING.order, mixed, a, method.solver, problem.sticks).build(StageClock())
    contact = model.contact(problem.indenter)
    if problem.sticks:
        p = contact.pressed(contact.surface.last[-1:], np.array([delta]))[1][:, 0]
    else:
        target = delta - contact.f if surface is None else surface(contact.surface.radii)
        p = cho_solve((contact.L, True), target)
    # An elastic indenter is part of the body's modulus; the body's own displacements are smaller by that much.
    return _state(model, a, delta, p, problem.E_star / problem.specimen.surface.E_star)


def _state(model: Model, a: float, delta: float, p: Array, share: float) -> ContactState:
    system, body, P = model.system, model.body, float(p[model.surface.normal].sum())
    solution = model.field(p)
    stress, vertices = Stress(system, solution, _cut(model)), system.basis.nodal_dofs[0]
    u = np.column_stack([part[vertices] for part in system.components(solution)])
    u[:, 1] -= model.missing * P if body.completed else 0.0
    layers = range(len(body.materials))
    used, values = zip(*(stress.at_vertices(layer) for layer in layers), strict=True)
    lines = {"surface": stress.surface(a)} | {f"interface {i + 1}": stress.interface(i) for i in layers[:-1]}
    if not body.cut_below:
        lines["base"] = stress.base()
    grid, stresses = _split(system.grid, used), np.concatenate(values, axis=1)
    for line in lines.values():  # tractions are the same on both sides
        on = np.isclose(grid.points[:, 1], -line.depth, rtol=ROUNDED, atol=0) & (grid.points[:, 0] <= line.r[-1])
        stresses[2:, on] = [np.interp(grid.points[on, 0], line.r, traction) for traction in (line.zz, line.rz)]
    return ContactState(a, delta, P, grid, share * u[np.concatenate(used)], stresses, lines)


def _cut(model: Model) -> float:
    """Relative error of the field from where an unbounded body is cut, about: what a half-space lacks there, times how
    far its layers reach, as membranes, on the way to the cut."""
    body = model.body
    if not body.cut_below:
        return 0.0
    C, normal = model.surface.C, model.surface.normal
    S = float(np.linalg.solve(C[np.ix_(normal, normal)], np.ones(normal.size)).sum())
    base = body.materials[-1].surface.E
    layers = zip(body.thicknesses[:-1], body.materials[:-1], strict=True)
    reach = sum(h * max(material.surface.E / base, 1.0) for h, material in layers)
    return abs(model.missing) * S * reach / body.width


def _split(grid: Grid, used: tuple[Array, ...]) -> Grid:
    """The grid with the vertices of interfaces once for each layer, ``used``: those of each."""
    cells = np.empty_like(grid.cells)
    start = 0
    for layer, numbers in enumerate(used):
        inside = grid.materials == layer
        cells[inside] = start + np.searchsorted(numbers, grid.cells[inside])
        start += numbers.size
    return Grid(grid.points[np.concatenate(used)], cells, grid.materials, {})

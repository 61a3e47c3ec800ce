"""Displacement and stress in the body at one state of adhesive contact.

The surface under a contact of radius a is where the indenter holds it, u_z = f(r) - delta for r <= a, frictionless, and
free outside. That is the nonadhesive field at a and the field of a flat punch of radius a, superposed (Eq. 13), in one
solve. The mesh is graded towards the contact's edge, where the stresses of an adhesive contact go like 1/sqrt(a - r).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve

from ...base.clock import StageClock
from ...base.errors import InputError, Refusal
from ...bodies.materials import TransverselyIsotropic
from ...bodies.problem import Problem
from .domain import Body, cut_out
from .grid import Grid
from .layout import scaled_layout
from .method import FEM, NEARLY_INCOMPRESSIBLE
from .model import Model, Recipe
from .stress import Line, Stress

Array = np.ndarray
SPACING, GROWTH = 0.08, 0.1  # element size over the distance from the contact's edge, within the contact and beyond
NEAR = 3.0  # contact radii within which tractions are judged
FINEST = 1e-4  # of the contact radius: within this distance of the edge elements are of one size


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
    lines: dict[str, Line]

    @cached_property
    def mises(self) -> Array:
        """Von Mises' equivalent stress [Pa], (n,)."""
        rr, tt, zz, rz = self.stress
        return np.sqrt(((rr - tt) ** 2 + (tt - zz) ** 2 + (zz - rr) ** 2) / 2 + 3 * rz**2)

    @cached_property
    def imbalance(self) -> dict[str, float]:
        """Of each line the compressive force that passes through it less the load, relative to its ``size``."""
        return {name: (line.load - self.P) / line.size for name, line in self.lines.items()}

    @cached_property
    def error(self) -> dict[str, float]:
        """Mean error of each line's tractions zz within ``NEAR`` contact radii, relative to their mean size."""
        return {name: line.error(NEAR * self.a) for name, line in self.lines.items()}


def contact_state(method: FEM, problem: Problem, a: float, delta: float) -> ContactState:
    """The field at contact radius ``a`` [m] and displacement ``delta`` [m] of the indenter.

    ``method`` gives where an unbounded body is cut (``depth``, ``width``) and the ``solver``; the mesh is made for
    ``a``. Errors: Refusal, InputError.
    """
    if problem.indenter.material is not None and not problem.specimen.is_half_space:
        raise Refusal("fields: an elastic indenter on a layered or finite body is not represented: take a rigid one")
    reason = replace(method, contact_radius=a, layout="scaled", element_size=None, order=2).refusal(problem)
    if reason is not None:
        raise Refusal(reason)
    edge = problem.specimen.radius
    if edge is not None and a >= edge:
        raise InputError(f"fields: contact radius {a:g} m reaches the edge of the body, {edge:g} m")
    body = cut_out(problem, a, method.depth, method.width)
    layout = scaled_layout(body, "triangle", a, a, FINEST * a, SPACING, GROWTH)
    model = Recipe(layout, 2, _mixed(body), a, method.solver).build(StageClock())
    contact = model.contact(problem.indenter)
    p = cho_solve((contact.L, True), delta - contact.f)
    # An elastic indenter is part of the body's modulus; the body's own displacements are smaller by that much.
    return _state(model, a, delta, p, problem.E_star / problem.specimen.surface.E_star)


def _mixed(body: Body) -> tuple[int, ...]:
    """Layers that get a pressure unknown."""
    return tuple(
        i
        for i, material in enumerate(body.materials)
        if not isinstance(material, TransverselyIsotropic) and material.nu > NEARLY_INCOMPRESSIBLE
    )


def _state(model: Model, a: float, delta: float, p: Array, share: float) -> ContactState:
    system, body, P = model.system, model.body, float(p.sum())
    solution = model.field(p)
    stress = Stress(model.grid, system, body.materials, solution)
    N, vertices = len(system.nodes), system.basis.nodal_dofs[0]
    u = np.column_stack([solution[vertices], solution[N + vertices]])
    u[:, 1] -= model.missing * P if body.completed else 0.0
    used, values = zip(*(stress.at_vertices(layer) for layer in range(len(body.materials))), strict=True)
    numbers = np.concatenate(used)
    lines = {"surface": stress.end("surface", a)}
    lines |= {f"interface {i + 1}": stress.interface(i) for i in range(len(body.materials) - 1)}
    if not body.cut_below:
        lines["base"] = stress.end("base")
    grid = _split(model.grid, used)
    return ContactState(a, delta, P, grid, share * u[numbers], np.concatenate(values, axis=1), lines)


def _split(grid: Grid, used: tuple[Array, ...]) -> Grid:
    """The grid with the vertices of interfaces once for each layer, ``used``: those of each."""
    cells = np.empty_like(grid.cells)
    start = 0
    for layer, numbers in enumerate(used):
        inside = grid.materials == layer
        cells[inside] = start + np.searchsorted(numbers, grid.cells[inside])
        start += numbers.size
    return Grid(grid.points[np.concatenate(used)], cells, grid.materials, {})

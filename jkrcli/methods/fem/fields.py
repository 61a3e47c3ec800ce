"""Displacement and stress in the body at one state of adhesive contact.

The surface under a contact of radius a is where the indenter holds it, u_z = f(r) - delta for r <= a, and free outside;
it slides without friction, or has the u_r with which each point was touched (the contact is grown on the same mesh).
That is the nonadhesive field at a and the field of a flat punch of radius a, superposed (Eq. 13), in one solve. The
mesh is graded towards the contact's edge, where the stresses of an adhesive contact go like 1/sqrt(a - r).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from scipy.linalg import cho_solve
from scipy.sparse import csc_matrix, identity
from scipy.sparse.linalg import spsolve

from ...base.errors import InputError, Refusal
from ...base.numerics import ROUNDED, Array
from ...base.process import StageClock
from ...bodies.problem import Problem
from . import FEM
from .elasticity import ElasticSystem, force_r, force_z, mass, measure, stiffness_constants
from .mesh import Grid, finest_spacing, pressure_layers, scaled_layout, truncate
from .model import Discretisation, Model

# --------------------------------------------------------------------------------------------------
# Stresses of a solution: at the vertices, and tractions along the lines of a body.
#
# At a vertex: the mean of the cells around it, layer by layer; on a line the tractions are those of the line.
#
# On a line: the tractions that balance the nodal forces which the elements on one side of it exert, int t v dA = int
# sigma : eps(v) dV for every shape function v of the line. They are in equilibrium whatever the mesh.

# What the error of tractions is concluded from.
TRACTION_CAUTION = 4.0  # times what one order less changes; tuned on the bodies of test_fields.py, by `make test-all`


COMPONENTS = ("rr", "tt", "zz", "rz")


@dataclass(frozen=True, eq=False)
class TractionLine:
    """Tractions ``zz, rz`` (n,) [Pa], tension positive, at the radii ``r`` [m] of a horizontal line at ``depth`` [m].

    ``zz_error, rz_error`` [Pa]: their estimated errors. ``area`` [m^2]: of the rings that integrate
    them, so that ``area @ zz`` is a force.
    """

    depth: float
    r: Array
    zz: Array
    rz: Array
    zz_error: Array
    rz_error: Array
    area: Array

    @property
    def load(self) -> float:
        """Compressive force that passes through [N]."""
        return -float(self.area @ self.zz)

    @property
    def size(self) -> float:
        """Pressure and tension together, both counted positive [N]: of an adhesive contact they nearly cancel."""
        return float(self.area @ np.abs(self.zz))

    def error(self, reach: float) -> float:
        """Mean error of zz within the radius ``reach`` [m] over the mean size of zz there."""
        near = self.r <= reach
        return float(self.area[near] @ self.zz_error[near] / (self.area[near] @ np.abs(self.zz[near])))


@dataclass(frozen=True, eq=False)
class Stress:
    """Stress recovery for a ``solution`` of ``system``; ``cut``: its relative error by where the body is cut off."""

    system: ElasticSystem
    solution: Array
    cut: float

    def at_vertices(self, layer: int) -> tuple[Array, Array]:
        """Vertex numbers of a layer (n,) and the stresses (4, n) there [Pa]: rr, tt, zz, rz."""
        grid, cells = self.system.grid, self.system.basis.mesh.t.T
        used, corners = np.unique(cells[grid.materials == layer], return_inverse=True)
        values = self._at_points(self.system.at_corners(layer), layer).reshape(len(COMPONENTS), -1)
        means = np.array([np.bincount(corners.ravel(), row) for row in values]) / np.bincount(corners.ravel())
        means[3, grid.points[used, 0] == 0] = 0.0  # there is no shear on the axis
        return used, means

    def interface(self, above: int) -> TractionLine:
        """Tractions between the layers ``above`` and ``above`` + 1."""
        f2t, layers = self.system.basis.mesh.f2t, self.system.grid.materials
        inner = np.flatnonzero(f2t[1] >= 0)
        upper, lower = np.sort(layers[f2t[:, inner]], axis=0)
        return self._balanced(inner[(upper == above) & (lower == above + 1)], above, -1)

    def surface(self, reach: float) -> TractionLine:
        """Tractions on the contact surface out to the radius ``reach`` [m], a vertex."""
        mesh = self.system.basis.mesh
        facets = mesh.boundaries["surface"]
        return self._balanced(facets[mesh.p[0, mesh.facets[:, facets]].max(axis=0) <= reach * (1 + ROUNDED)], 0, 1)

    def base(self) -> TractionLine:
        """Tractions on the base of the body."""
        return self._balanced(self.system.basis.mesh.boundaries["base"], int(self.system.grid.materials.max()), -1)

    def _balanced(self, facets: Array, layer: int, outward: int) -> TractionLine:
        """Tractions on ``facets`` of a ``layer`` that lies below (``outward`` = 1) or above (-1) them."""
        order = self.system.order
        cells, on_line = self.system.in_layer(layer), self.system.on_facets(facets, degree=2 * order + 1)
        stress = dict(zip(COMPONENTS, self._at_points(cells, layer), strict=True))
        nodes = np.unique(on_line.get_dofs(facets).all())
        nodes = nodes[np.argsort(self.system.nodes[nodes, 0], kind="stable")]
        r, z = self.system.nodes[nodes].T
        products = mass.assemble(on_line)[nodes][:, nodes].tocsc()
        axis = int(r[0] == 0)  # there is no shear on it
        zz, zz_error = _traction(products, outward * force_z.assemble(cells, **stress)[nodes], 0, order)
        rz, rz_error = _traction(products, outward * force_r.assemble(cells, **stress)[nodes], axis, order)
        area = measure.assemble(on_line)[nodes]
        zz_error, rz_error = zz_error + self.cut * np.abs(zz), rz_error + self.cut * np.abs(rz)
        return TractionLine(abs(float(z[0])), r, zz, rz, zz_error, rz_error, area)

    def _at_points(self, basis: Any, layer: int) -> Array:
        """rr, tt, zz, rz (4, cells, points) [Pa] at the points of a basis on cells of one layer."""
        system = self.system
        u_r, u_z = (basis.interpolate(part) for part in system.components(self.solution))
        r, z = np.asarray(basis.global_coordinates())
        on_axis = r <= 0
        rr, zz = u_r.grad[0], u_z.grad[1]
        tt = np.where(on_axis, rr, np.asarray(u_r) / np.where(on_axis, 1.0, r))
        rz = u_r.grad[1] + u_z.grad[0]
        depth = system.grid.depth_below_top(layer, z)
        C11, C12, C13, C33, C44 = stiffness_constants(system.materials[layer], layer in system.mixed, depth)
        p = system.pressure(self.solution, layer, basis)
        return np.array([
            C11 * rr + C12 * tt + C13 * zz - p, C12 * rr + C11 * tt + C13 * zz - p, C13 * (rr + tt) + C33 * zz - p,
            C44 * rz,
        ])  # fmt: skip


def _traction(products: csc_matrix, force: Array, first: int, order: int) -> tuple[Array, Array]:
    """Tractions at the nodes of a line that balance ``force``, 0 at the nodes before ``first``, and their errors, from
    what polynomials of one order less than ``order`` change."""
    tractions = []
    # Values at the nodes of a line of sides of order from those at the nodes of order - 1
    x, y = np.linspace(-1, 1, order + 1), np.linspace(-1, 1, order)
    side = np.vander(x, order) @ np.linalg.inv(np.vander(y, order))
    matrix = np.zeros((force.size, (force.size - 1) // order * (order - 1) + 1))
    for k in range((force.size - 1) // order):
        matrix[k * order : (k + 1) * order + 1, k * (order - 1) : (k + 1) * (order - 1) + 1] = side
    one_order_less = csc_matrix(matrix)
    for space in (identity(force.size, format="csc"), one_order_less):
        T = space[:, first:].tocsc()
        tractions.append(T @ spsolve((T.T @ products @ T).tocsc(), T.T @ force))
    return tractions[0], TRACTION_CAUTION * np.abs(tractions[0] - tractions[1])


# The mesh for the field at one contact radius.
STATE_ORDER = 4  # of the elements; tuned on gel and coating, by `make tuning`
STATE_SPACING = 0.2  # element size over the distance from the edge; tuned on gel and coating, by `make tuning`
STATE_STUCK = 0.1  # the same of surfaces that stick, which must be grown on it; choice: as exact there
STATE_GROWTH = 0.2  # beyond the contact; tuned on the bodies of `make tuning`, by `make tuning`
STATE_FINEST = 1e-5  # radii from the edge with elements of one size; tuned on gel and coating, by `make tuning`
STATE_NEAR = 3.0  # radii within which tractions are judged; choice: what the error stands for


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
        return {name: line.error(STATE_NEAR * self.a) for name, line in self.lines.items()}


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
    body = truncate(problem, a, method.depth, method.width)
    spacing, finest = STATE_SPACING, STATE_FINEST
    if problem.sticks:
        spacing = STATE_STUCK
        finest = max(finest, finest_spacing(body.materials[0]) * STATE_ORDER / (2 * spacing))
    layout = scaled_layout(body, "triangle", a, a, finest * a, spacing, STATE_GROWTH)
    mixed = pressure_layers(body.materials, problem.sticks)
    model = Discretisation(layout, STATE_ORDER, mixed, a, method.solver, problem.sticks).build(StageClock())
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
    # The grid with the vertices of interfaces once for each layer, used: those of each
    cells = np.empty_like(system.grid.cells)
    start = 0
    for layer, numbers in enumerate(used):
        inside = system.grid.materials == layer
        cells[inside] = start + np.searchsorted(numbers, system.grid.cells[inside])
        start += numbers.size
    split = Grid(system.grid.points[np.concatenate(used)], cells, system.grid.materials, {})
    grid, stresses = split, np.concatenate(values, axis=1)
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

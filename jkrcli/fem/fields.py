"""Displacement and stress in the body at one state of adhesive contact.

The surface under a contact of radius a is where the indenter holds it, u_z = f(r) - delta for r <= a, and free outside;
it slides without friction, or has the u_r with which each point was touched (the contact is grown on the same mesh).
That is the nonadhesive field at a and the field of a flat punch of radius a, superposed (Eq. 13), in one solve. The
mesh is graded towards the contact's edge, where the stresses of an adhesive contact go like 1/sqrt(a - r).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from scipy.linalg import cho_solve
from scipy.sparse import csc_matrix, identity
from scipy.sparse.linalg import spsolve

from ..base.errors import InputError, Refusal
from ..base.numerics import ROUNDED, Array
from ..base.process import StageClock
from ..bodies.problem import Problem
from .elasticity import ElasticSystem, force_r, force_z, mass, measure, stiffness_constants
from .mesh import Grid, finest_spacing, pressure_layers, scaled_layout, truncate
from .model import Discretisation, Model
from .solver import FEM

# --------------------------------------------------------------------------------------------------
# Stresses of a solution: at the nodes, and tractions along the lines of a body.
#
# Every cell is written as quadratic triangles through the nodes of its elements. At a node: the mean of the cells
# around it, layer by layer; on a line the tractions are those of the line. The error of what is written: what the
# elements have between the nodes, and beside them in each cell, less what is interpolated from the nodes.
#
# On a line: the tractions that balance the nodal forces which the elements on one side of it exert, int t v dA = int
# sigma : eps(v) dV for every shape function v of the line. They are in equilibrium whatever the mesh.

# What the error of tractions is concluded from.
TRACTION_CAUTION = 4.0  # times what one order less changes; tuned on the bodies of test_fields.py, by `make test-all`
# On what elements and the interpolation differ by around a triangle:
FIELD_CAUTION = 2.0  # tuned on the bodies of test_fields.py, by `make test-all`


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

    def at_places(self, layer: int, places: Array) -> tuple[Array, Array]:
        """u_r, u_z [m] (2, cells, n) and rr, tt, zz, rz [Pa] (4, ...) at the ``places`` in each cell of a layer."""
        basis = self.system.at_places(layer, places)
        u = np.array([np.asarray(basis.interpolate(part)) for part in self.system.components(self.solution)])
        return u, self._at_points(basis, layer).reshape(len(COMPONENTS), *u.shape[1:])

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
STATE_SECONDS = 2.0  # CPU seconds of a state, 1 to 4; tuned on the shipped cases, by `make guards`
STATE_SECONDS_STUCK = 15.0  # of surfaces that stick, 10 to 22; tuned on gel and coating, by `make guards`
STATE_AWAY = 0.05  # radii from the edge, where stresses are infinite, beyond which fields are; choice: as in pictures
STATE_NEAR = 3.0  # radii within which tractions are judged; choice: what the error stands for


@dataclass(frozen=True, eq=False)
class ContactState:
    """The body in contact of radius ``a`` [m] at displacement ``delta`` [m] and load ``P`` [N].

    ``grid``: triangles through the nodes, those of interfaces once for each layer; ``middles`` (m, 3): the nodes amid
    their sides 01, 12, 20, which make them quadratic; ``displacement`` (n, 2): u_r, u_z [m]; ``stress`` (4, n): rr, tt,
    zz, rz [Pa], tension positive; ``errors`` (m, ...) of what is interpolated in each triangle: "displacement" (m, 2),
    "stress" (m, 4) and "mises" (m,), NaN at the edge of the contact; ``lines``: tractions by name, "surface" first,
    then "interface 1" ... and "base" where the specimen ends there.
    """

    a: float
    delta: float
    P: float
    grid: Grid
    middles: Array
    displacement: Array
    stress: Array
    errors: dict[str, Array]
    lines: dict[str, TractionLine]

    @property
    def mises(self) -> Array:
        """Von Mises' equivalent stress [Pa], (n,)."""
        return von_mises(self.stress)

    @property
    def quadratic(self) -> Array:
        """Nodes of the triangles (m, 6): vertices, then the middles of the sides 01, 12, 20."""
        return np.column_stack([self.grid.cells, self.middles])

    @property
    def shown(self) -> Array:
        """Whether each triangle is within three contact radii, and further from the edge than a twentieth of one."""
        corners = self.grid.points[self.grid.cells]
        near = np.hypot(*np.moveaxis(corners, 2, 0)).max(axis=1) <= STATE_NEAR * self.a
        return near & (np.hypot(corners[..., 0] - self.a, corners[..., 1]).min(axis=1) >= STATE_AWAY * self.a)

    @property
    def largest_mises(self) -> tuple[float, float, float]:
        """The largest von Mises stress [Pa] that is shown, and where: r and depth [m]."""
        nodes = np.unique(self.quadratic[self.shown])
        node = nodes[np.argmax(self.mises[nodes])]
        r, z = np.abs(self.grid.points[node]).tolist()
        return float(self.mises[node]), r, z

    @property
    def interpolation_error(self) -> dict[str, float]:
        """Largest error of displacements and of von Mises' stress where they are ``shown``, relative to their largest
        values there."""
        near = self.shown
        nodes = self.quadratic[near]
        displacement = self.errors["displacement"][near].max() / np.abs(self.displacement[nodes]).max()
        return {
            "displacement": float(displacement),
            "von_mises": float(self.errors["mises"][near].max() / self.mises[nodes].max()),
        }

    @property
    def imbalance(self) -> dict[str, float]:
        """Compressive force that passes through each line less the load, relative to the line's ``size``."""
        return {name: (line.load - self.P) / line.size for name, line in self.lines.items()}

    @property
    def error(self) -> dict[str, float]:
        """Mean error of each line's tractions zz within three contact radii, relative to their mean size."""
        return {name: line.error(STATE_NEAR * self.a) for name, line in self.lines.items()}


def seconds_of_state(problem: Problem) -> float:
    """CPU seconds of a `contact_state`."""
    return STATE_SECONDS_STUCK if problem.sticks else STATE_SECONDS


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


def von_mises(stress: Array) -> Array:
    """Von Mises' equivalent of the stresses (4, ...): rr, tt, zz, rz."""
    rr, tt, zz, rz = stress
    return np.sqrt(((rr - tt) ** 2 + (tt - zz) ** 2 + (zz - rr) ** 2) / 2 + 3 * rz**2)


def _state(model: Model, a: float, delta: float, p: Array, share: float) -> ContactState:
    system, body, P = model.system, model.body, float(p[model.surface.normal].sum())
    stress = Stress(system, model.field(p), _cut(model))
    lines = {"surface": stress.surface(a)}
    lines |= {f"interface {i + 1}": stress.interface(i) for i in range(len(body.materials) - 1)}
    if not body.cut_below:
        lines["base"] = stress.base()
    # Positions (n, 2) [m] of the lattice of nodes on a mesh, and their numbers in each cell (cells, places): vertices
    # first, then those on sides, from the lower vertex on, then those inside
    n, (i, j) = STATE_ORDER, _PLACES[STATE_ORDER].T
    weights = np.column_stack([n - i - j, i, j])
    p, t, t2f, facets = system.basis.mesh.p, system.basis.mesh.t, system.basis.mesh.t2f, system.basis.mesh.facets
    lower, upper = p[:, facets[0], None], p[:, facets[1], None]
    on_sides = lower + (upper - lower) * np.arange(1, n) / n
    inside = np.flatnonzero((weights > 0).all(axis=1))
    centres = np.einsum("dkc,qk->dcq", p[:, t], weights[inside] / n)
    points = np.concatenate([p, on_sides.reshape(2, -1), centres.reshape(2, -1)], axis=1).T
    numbers = np.empty((t.shape[1], len(weights)), dtype=np.int64)
    numbers[:, inside] = points.shape[0] - centres[0].size + np.arange(centres[0].size).reshape(-1, inside.size)
    for q, weight in enumerate(weights):
        ends = np.flatnonzero(weight)
        if ends.size == 1:
            numbers[:, q] = t[ends[0]]
        elif ends.size == 2:
            facet = t2f[[(0, 1), (1, 2), (0, 2)].index((ends[0], ends[1]))]
            steps = np.where(t[ends[1]] == facets[1][facet], weight[ends[1]], weight[ends[0]])
            numbers[:, q] = p.shape[1] + facet * (n - 1) + steps - 1
    parts, start = [], 0
    for layer in range(len(body.materials)):
        part = _written(stress, layer, points, numbers[system.grid.materials == layer], lines, a)
        parts.append(replace(part, triangles=part.triangles + start))
        start += len(part.points)
    missing = model.missing * P if body.completed else 0.0
    displacement = np.concatenate([part.u for part in parts]) - np.array([0.0, missing])
    triangles = np.concatenate([part.triangles for part in parts])
    layers = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    grid = Grid(np.concatenate([part.points for part in parts]), triangles[:, :3], layers, {})
    errors = {name: np.concatenate([part.errors[name] for part in parts]) for name in parts[0].errors}
    errors["displacement"] = share * errors["displacement"]
    stresses = np.concatenate([part.stress for part in parts], axis=1)
    return ContactState(a, delta, P, grid, triangles[:, 3:], share * displacement, stresses, errors, lines)


# The places of a cell: a lattice with the elements' nodes, and one twice as fine, between them.
_PLACES = {
    n: np.array([(i, j) for j in range(n + 1) for i in range(n + 1 - j)]) for n in (STATE_ORDER, 2 * STATE_ORDER)
}


def _triangles(n: int) -> Array:
    """Vertices (m, 3, 2) of the triangles on the lattice of order ``n`` with a place amid each side."""
    corners = []
    for i, j in _PLACES[n][(_PLACES[n] % 2 == 0).all(axis=1)]:
        if i + j < n:
            corners.append([(i, j), (i + 2, j), (i, j + 2)])
        if i + j < n - 2:
            corners.append([(i + 2, j + 2), (i, j + 2), (i + 2, j)])
    return np.array(corners)


@dataclass(frozen=True, eq=False)
class _Written:
    """What is written of a layer: ``points`` (n, 2), ``triangles`` (m, 6), ``u`` (n, 2), ``stress`` (4, n), and
    ``errors`` by triangle."""

    points: Array
    triangles: Array
    u: Array
    stress: Array
    errors: dict[str, Array]


def _written(
    stress: Stress, layer: int, points: Array, numbers: Array, lines: dict[str, TractionLine], a: float
) -> _Written:
    """A layer as quadratic triangles through the nodes, by their ``numbers`` (cells, places) among the ``points``."""
    n = STATE_ORDER
    used, own = np.unique(numbers, return_inverse=True)
    own = own.reshape(numbers.shape)
    u, values = stress.at_places(layer, _PLACES[2 * n].T / (2 * n))
    fine = {(int(i), int(j)): k for k, (i, j) in enumerate(_PLACES[2 * n])}
    at_nodes = [fine[2 * int(i), 2 * int(j)] for i, j in _PLACES[n]]

    # Means of the cells around each node; displacements are the same in all
    count = np.bincount(own.ravel())
    mean_u, means = (
        np.array([np.bincount(own.ravel(), row[:, at_nodes].ravel()) for row in field]) / count for field in (u, values)
    )
    places = points[used]
    means[3, places[:, 0] == 0] = 0.0  # there is no shear on the axis
    for line in lines.values():  # tractions are the same on both sides
        on = np.isclose(places[:, 1], -line.depth, rtol=ROUNDED, atol=0) & (places[:, 0] <= line.r[-1])
        means[2:, on] = [np.interp(places[on, 0], line.r, traction) for traction in (line.zz, line.rz)]

    # Of each triangle the lattice of all its places in between: vertices, middles, and the nine others
    coarse = {(int(i), int(j)): k for k, (i, j) in enumerate(_PLACES[n])}
    inner = _PLACES[n] / n
    x, y = inner.T
    z = 1 - x - y  # shape functions of a quadratic triangle: vertices, then the middles of the sides 01, 12, 20
    shapes = np.column_stack([z * (2 * z - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * z * x, 4 * x * y, 4 * y * z])
    mean_mises, mises = von_mises(means), von_mises(values)
    fields = {"displacement": (u, mean_u), "stress": (values, means), "mises": (mises[None], mean_mises[None])}
    triangles: list[Array] = []
    errors: dict[str, list[Array]] = {name: [] for name in fields}
    for corners in _triangles(n):
        ring = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) // 2])
        nodes = own[:, [coarse[int(i), int(j)] for i, j in ring]]
        first, *others = 2 * corners
        between = first + inner @ np.array([other - first for other in others])
        at = [fine[int(i), int(j)] for i, j in np.rint(between)]
        triangles.append(nodes)
        for name, (field, nodal) in fields.items():
            errors[name].append(np.abs(field[..., at] - nodal[..., nodes] @ shapes.T).max(axis=-1))
    of_triangles = np.concatenate(triangles)
    sides = np.diff(places[of_triangles[:, :3]], axis=1)
    clockwise = sides[:, 0, 0] * sides[:, 1, 1] < sides[:, 0, 1] * sides[:, 1, 0]
    of_triangles[clockwise] = of_triangles[clockwise][:, [0, 2, 1, 5, 4, 3]]
    at_edge = (np.abs(places[of_triangles] - np.array([a, 0.0])) <= ROUNDED * a).all(axis=2).any(axis=1)
    found = {}
    for name, (_, nodal) in fields.items():
        error = np.concatenate([part.T for part in errors[name]])
        error[at_edge] = 0.0 if name == "displacement" else np.nan  # stresses are infinite there
        around = np.zeros(nodal.T.shape)  # the largest of the triangles around each node
        np.fmax.at(around, of_triangles, error[:, None])
        size = stress.cut * np.abs(nodal[:, of_triangles]).max(axis=2).T
        found[name] = FIELD_CAUTION * around[of_triangles].max(axis=1) + size + 0 * error
    return _Written(places, of_triangles, mean_u.T, means, found | {"mises": found["mises"][:, 0]})


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

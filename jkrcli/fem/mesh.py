"""Grids from a body and the user's wishes: the layouts ``scaled`` and ``zones``, in triangles or quadrilaterals."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ..base.errors import InputError, Refusal, SolveError, installs
from ..base.numerics import AT_ONCE, ROUNDED, SAME, Array
from ..bodies.problem import (
    AnyGraded,
    AnyTransverse,
    Elastic,
    HalfSpace,
    Material,
    Problem,
    Side,
    Specimen,
    TransverselyIsotropic,
)
from ..methods.layered.no_slip import half_space_compliances
from ..methods.layered.solver import largest_radius
from .options import FEMOptions

# --------------------------------------------------------------------------------------------------
# Where a mesh is fine: one law of element size over the body, and graded points along a line.
#
# The law is a formula written once: it is evaluated on numbers, or written out as text for the mesh generator.


# Where a law of sizes is looked at to count elements before they are made.
COUNT_NEAR = 150  # points towards a place of small sizes; choice: the count is then good to a few per cent
COUNT_POINTS = 15_000  # of them together over all layers; choice: a thousand layers in a tenth of a second
COUNT_LEAST_NEAR = 40  # of them, however many layers; choice: the count is then good to a fifth
COUNT_LEAST_ACROSS = 2  # points towards either side of a layer; choice: likewise


class Expression(NDArrayOperatorsMixin):
    """Text of an arithmetic expression, as which NumPy writes down the functions that are applied to it."""

    FORMS: ClassVar[dict[np.ufunc, str]] = {
        np.add: "({}+{})",
        np.subtract: "({}-{})",
        np.multiply: "({}*{})",
        np.maximum: "Max({},{})",
        np.minimum: "Min({},{})",
        np.hypot: "Sqrt({0}*{0}+{1}*{1})",
    }

    def __init__(self, text: str):
        self.text = text

    def __array_ufunc__(self, function: np.ufunc, method: str, *values: Any) -> Expression:
        texts = (value.text if isinstance(value, Expression) else f"({float(value)!r})" for value in values)
        return Expression(self.FORMS[function].format(*texts))


@dataclass(frozen=True)
class SizeLaw:
    """Element size [m] at (r, z): fine along the contact 0 <= r <= reach, growing by ``growth`` per distance from it
    (``far_growth`` from ``far`` reaches on, where the field is smooth).

    Along the contact the size is ``slope * max(|r - a0|, inner)``, or ``floor`` where that is larger.
    ``zones``: (extent, size) of squares around the origin, inside which the size stays below ``size`` [m].
    ``layers``: (top depth, thickness, size, largest size far from the contact) of layers with their own limit.
    ``corners``: (r, depth, size) of points where the field is singular: the size grows from there by ``growth``.
    """

    reach: float
    growth: float
    far_growth: float
    far: float
    a0: float = 0.0
    inner: float = 0.0
    slope: float = 0.0
    floor: float = 0.0
    zones: tuple[tuple[float, float], ...] = ()
    layers: tuple[tuple[float, float, float, float], ...] = ()
    corners: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, r: Any, z: Any) -> Any:
        """Size at radius ``r`` and height ``z <= 0`` (numbers, arrays, or formulas)."""
        near = np.minimum(r, self.reach)
        offset = near - self.a0
        along = self.slope * np.maximum(np.maximum(offset, 0.0 - offset), self.inner)
        distance = np.hypot(r - near, z)
        faster = (self.far_growth - self.growth) * np.maximum(distance - self.far * self.reach, 0.0)
        size = np.maximum(along, self.floor) + self.growth * distance + faster
        for limit in self._limits(r, z):
            size = np.minimum(size, limit)
        return size

    def _limits(self, r: Any, z: Any) -> Iterator[Any]:
        """Upper limits of the size from zones (inside square k, growing outwards from it), layers and corners."""
        for extent, size in self.zones:
            yield size + self.growth * np.maximum(np.maximum(r, 0.0 - z) - extent, 0.0)
        for top, thickness, size, longest in self.layers:
            # the layer's size inside it, growing with the distance from it and from the contact
            above = np.maximum((0.0 - z) - (top + thickness), top + z)
            beyond = np.maximum(r - (self.reach + 2 * (top + thickness)), 0.0)
            sideways = np.minimum(size + self.growth * beyond, longest)
            yield sideways + self.growth * np.maximum(above, 0.0)
        for radius, depth, size in self.corners:
            yield size + self.growth * np.hypot(r - radius, z + depth)

    def on_grid(self, r: Array, depth: Array) -> Array:
        """Sizes at all radii ``r`` (m,) and depths (n,), shape (m, n)."""
        rest = replace(self, layers=())(r[:, None], -depth)
        return np.minimum(rest, self._least_of_layers(r, depth)) if self.layers else rest

    def _least_of_layers(self, r: Array, depth: Array) -> Array:
        """The least of all layers' limits: they grow by one rate away from each layer, so that one pass downwards and
        one upwards carry the least along."""
        top, thickness, size, longest = np.array(self.layers).T
        bottom = top + thickness
        beyond = np.maximum(r[:, None] - (self.reach + 2 * bottom), 0.0)
        sideways = np.minimum(size + self.growth * beyond, longest)
        none = np.full((r.size, 1), np.inf)
        above = np.minimum.accumulate(np.hstack([none, sideways - self.growth * bottom]), axis=1)
        below = np.minimum.accumulate(np.hstack([sideways + self.growth * top, none])[:, ::-1], axis=1)[:, ::-1]
        i = np.searchsorted(top, depth, side="right") - 1
        under = depth > bottom[i]  # all layers
        own = np.where(under, np.inf, sideways[:, i])
        passed = np.minimum(above[:, i + under] + self.growth * depth, below[:, i + 1] - self.growth * depth)
        return np.minimum(own, passed)

    def coarser(self, factor: float, steepest: float) -> SizeLaw:
        """Every size ``factor`` times as large, but no growth above ``steepest``."""
        return replace(
            self,
            growth=min(self.growth * factor, steepest),
            far_growth=min(self.far_growth * factor, steepest),
            slope=self.slope * factor,
            floor=self.floor * factor,
            zones=tuple((extent, size * factor) for extent, size in self.zones),
            layers=tuple((top, t, min(size * factor, t), longest) for top, t, size, longest in self.layers),
            corners=tuple((r, depth, size * factor) for r, depth, size in self.corners),
        )

    def text(self) -> str:
        """The law as a formula in x = r and y = z."""
        return self(Expression("x"), Expression("y")).text


def graded_points(start: float, stop: float, size: Callable[[Array], Array]) -> Array:
    """Points from ``start`` to ``stop`` (both included) spaced by ``size`` to within rounding of their count.

    The point density 1/size is integrated exactly for a size that is linear between samples.
    """
    towards = np.geomspace(1e-7, 1, 201)  # either end
    x = np.unique(start + (stop - start) * np.concatenate([np.linspace(0, 1, 201), towards, 1 - towards]).clip(0, 1))
    h = size(x)
    if not (h > 0).all():
        raise SolveError(f"mesh: element size {h.min():g} m between {start:g} and {stop:g} m")
    step, rate = np.diff(x), np.diff(h) / np.diff(x)
    flat = np.abs(np.diff(h)) < ROUNDED * h[:-1]
    safe = np.where(flat, 1.0, rate)
    counts = np.where(flat, step / h[:-1], np.log(h[1:] / h[:-1]) / safe)
    total = np.concatenate([[0.0], np.cumsum(counts)])
    n = max(1, round(total[-1]))
    if n > AT_ONCE:
        raise Refusal(
            f"mesh: {n:,} points between {start:g} and {stop:g} of the contact's size, at most {AT_ONCE:,}: "
            "take a larger mesh.spacing or mesh.smallest, or a smaller mesh.width or specimen"
        )
    wanted = np.arange(1, n) * (total[-1] / n)
    i = np.clip(np.searchsorted(total, wanted, side="right") - 1, 0, step.size - 1)
    ahead = wanted - total[i]
    growth = np.where(flat[i], 0.0, safe[i] * ahead)  # a long flat stretch would overflow the other branch
    inner = x[i] + h[i] * np.where(flat[i], ahead, np.expm1(growth) / safe[i])
    return np.concatenate([[start], inner, [stop]])


@lru_cache(maxsize=32)  # every look at a method asks for it several times
def expected_triangles(law: SizeLaw, width: float, depth: float) -> float:
    """About how many triangles of the sizes of ``law`` fill the rectangle 0 <= r <= width, -depth <= z <= 0
    (the generator makes an eighth more than equilateral ones). Takes time linear in the number of layers.

    Between two points the size h is linear: the integral of 1/h^2 is their distance over the product of both sizes.
    """
    # Radii and depths at which a law is looked at to count elements: dense where its sizes may be small
    many = len(law.layers)
    near = np.geomspace(1e-9, 1, max(COUNT_LEAST_NEAR, min(COUNT_NEAR, COUNT_POINTS // max(many, 1))))
    near *= max(width, depth)
    knots = [0.0, law.a0, law.reach, *(radius for radius, *_ in law.corners)]
    r = np.concatenate([k + sign * near for k in knots for sign in (-1, 1)] + [knots])
    share = np.geomspace(1e-6, 0.5, max(COUNT_LEAST_ACROSS, COUNT_NEAR // max(many, 1)))
    tops, across = np.array(law.layers)[:, :2].T if many else np.zeros((2, 0))
    inside = tops + across * np.concatenate([[0.0], share, 1 - share])[:, None]
    ends = [0.0, *(tops + across)[-1:]]
    upwards = [corner - near for _, corner, _ in law.corners]
    z = np.concatenate([inside.ravel(), *(end + near for end in ends), *upwards, ends, [depth]])
    r, z = np.unique(np.clip(r, 0, width)), np.unique(np.clip(z, 0, depth))
    rows = max(1, AT_ONCE // z.size)
    lines = np.concatenate([_along(law.on_grid(part, z), z) for part in np.split(r, range(rows, r.size, rows))])
    return float(1.12 * 4 / np.sqrt(3) * _along(1 / np.sqrt(lines), r))


def _along(size: Array, x: Array) -> Array:
    """Integral of 1/size^2 over ``x`` (n,), ``size`` (..., n)."""
    return np.sum(np.diff(x) / (size[..., 1:] * size[..., :-1]), axis=-1)


# --------------------------------------------------------------------------------------------------
# Meshes as plain arrays: vertices and cells in the (r, z) half-plane, and those parts of them that are structured.
#
# The body is the rectangle 0 <= r <= L, -H <= z <= 0; the contact surface is z = 0 and the axis r = 0.


@dataclass(frozen=True, eq=False)
class Grid:
    """A mesh: ``points`` (n, 2) [m]; ``cells`` (m, 3) triangles or (m, 4) quadrilaterals, counter-clockwise vertex
    numbers; ``materials`` (m,) index of the cell's layer from the top; ``boundaries``: facets (k, 2) as vertex pairs.
    """

    points: Array
    cells: Array
    materials: Array
    boundaries: Mapping[str, Array]

    @property
    def element(self) -> str:
        return "triangle" if self.cells.shape[1] == 3 else "quadrilateral"

    @property
    def depth(self) -> float:
        return float(-self.points[:, 1].min())

    @property
    def width(self) -> float:
        return float(self.points[:, 0].max())

    def surface_radii(self) -> Array:
        """Radii of the vertices of the contact surface, increasing [m]."""
        return np.unique(self.points[np.unique(self.boundaries["surface"]), 0])

    def depth_below_top(self, layer: int, z: Array) -> Array:
        """Depths of the heights ``z`` [m] below the top of a layer [m]."""
        top = self.points[self.cells[self.materials == layer], 1].max()
        return np.maximum(top - z, 0.0)

    def quality(self) -> Array:
        """Shape of each cell in (0, 1]: 4 sqrt(3) area / sum(l^2) for triangles, the smallest corner sine of
        quadrilaterals (a slender rectangle has 1)."""
        corners = self.points[self.cells]
        edges = np.roll(corners, -1, axis=1) - corners
        if self.cells.shape[1] == 3:
            return 2 * np.sqrt(3) * np.abs(_cross(edges[:, 0], edges[:, 1])) / np.sum(edges**2, axis=(1, 2))
        before = np.roll(edges, 1, axis=1)
        lengths = np.linalg.norm(edges, axis=2)
        return np.min(_cross(before, edges) / (lengths * np.roll(lengths, 1, axis=1)), axis=1)

    def scaled(self, unit: float) -> Grid:
        """The same mesh with all lengths multiplied by ``unit``."""
        return Grid(self.points * unit, self.cells, self.materials, self.boundaries)


def _cross(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def make_grid(points: Array, cells: Array, interfaces: Array) -> Grid:
    """A checked grid from vertices and cells; ``interfaces``: depths (> 0) of the layer boundaries inside the body."""
    used, numbers = np.unique(cells, return_inverse=True)  # gmsh leaves points that belong to no cell
    points, cells = points[used], numbers.reshape(cells.shape)
    a, b, c = (points[cells[:, i]] for i in range(3))
    cells = np.where((_cross(b - a, c - b) < 0)[:, None], cells[:, ::-1], cells)  # counter-clockwise
    materials = np.searchsorted(np.asarray(interfaces), -points[cells, 1].mean(axis=1))
    # Facets that belong to one cell only, named by the side of the rectangle they lie on.
    pairs = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, first, count = np.unique(pairs[:, 0] * len(points) + pairs[:, 1], return_index=True, return_counts=True)
    outer = pairs[first[count == 1]]
    (width, _), (_, depth) = points.max(axis=0), -points.min(axis=0)
    on = {name: ends.all(axis=1) for name, ends in sides(points[outer], width, depth).items()}
    if sum(int(mask.sum()) for mask in on.values()) != len(outer):
        raise SolveError("mesh: the boundary of the mesh is not the boundary of the body (a crack or an overlap)")
    grid = Grid(points, cells, materials, {name: outer[mask] for name, mask in on.items()})
    for array in (points, cells, materials):
        array.setflags(write=False)
    if not grid.quality().min() > 0:
        raise SolveError(f"mesh: a cell is degenerate (quality {grid.quality().min():.2g})")
    return grid


def sides(points: Array, width: float, depth: float) -> dict[str, Array]:
    """Which of the ``points`` (..., 2) lie on the named sides of the body."""
    r, z = points[..., 0], points[..., 1]
    return {"surface": z == 0, "base": z == -depth, "axis": r == 0, "side": r == width}


# ---------------------------------------------------------------------- structured quadrilaterals
def tensor_quads(r: Array, depths: Array) -> tuple[Array, Array]:
    """Vertices and cells of the grid of lines at radii ``r`` and at ``depths`` (both increasing from 0) [m]."""
    points = np.stack(np.meshgrid(r, -depths, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, _quads(np.arange(len(points)).reshape(r.size, depths.size))


def ringed_quads(r: Array, depths: Array, widths: Array, heights: Array) -> tuple[Array, Array]:
    """A tensor grid inside, and around it rings of rectangles: ring k reaches to radius ``widths[k]`` and depth
    ``heights[k]``. Every ring carries the divisions of the inner grid's outer sides, so no element is a triangle."""
    points, cells = tensor_quads(r, depths)
    numbers = np.arange(len(points)).reshape(r.size, depths.size)
    path = np.concatenate([numbers[-1, :], numbers[-2::-1, -1]])  # down the right side, then along the bottom inwards
    outline = np.stack([points[path, 0] / r[-1], points[path, 1] / depths[-1]], axis=1)
    outer = outline * np.column_stack([widths, heights])[:, None]
    rings = np.concatenate([path[None], len(points) + np.arange(outer.size // 2).reshape(-1, path.size)])
    sides = rings[:, : depths.size], rings[:, depths.size - 1 :]
    return np.concatenate([points, outer.reshape(-1, 2)]), np.concatenate([cells, *map(_quads, sides)])


def _quads(numbers: Array) -> Array:
    """Quadrilaterals of a logically rectangular array of vertex numbers."""
    corners = (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:])
    return np.stack([corner.ravel() for corner in corners], axis=1)


# ---------------------------------------------------------------------- the strip below the contact
@dataclass(frozen=True, eq=False)
class Strip:
    """Rows of right-angled triangles below the contact surface: the part that two meshes have in common.

    Where a vertex sits relative to the edge of the contact depends on the elements around it. Two meshes with the same
    strip share that, whatever lies below; so one calibrates the other (``fem.model``).
    ``points`` (rows + 1, n, 2): vertices by row from the surface down and by increasing radius.
    """

    points: Array

    @classmethod
    def below(cls, radii: Array, thickest: float, rows: Array, height: float) -> Strip:
        """The strip below surface vertices at ``radii`` (from 0 on): the ``rows`` end at these depths, in ``height``
        local distances of the vertices; the last no deeper than ``thickest``."""
        steps = np.diff(radii)
        local = np.concatenate([steps[:1], np.minimum(steps[1:], steps[:-1]), steps[-1:]])
        depths = np.append(0.0, rows)[:, None] * np.minimum(height * local, thickest / rows[-1])
        return cls(np.stack([np.broadcast_to(radii, depths.shape), -depths], axis=-1))

    @property
    def _numbers(self) -> Array:
        return np.arange(self.points.size // 2).reshape(self.points.shape[:2])

    @property
    def cells(self) -> Array:
        """Vertex numbers of the triangles, row after row (2 rows (n - 1), 3)."""
        a, d, c, b = _quads(self._numbers).T
        return np.concatenate([np.stack([d, c, a], axis=1), np.stack([c, b, a], axis=1)])

    @property
    def width(self) -> int:
        """Number of surface vertices."""
        return self.points.shape[1]

    def outline_numbers(self, end: float) -> Array:
        """Numbers of the vertices below it from the axis on, then those beside it up to the surface, unless the body
        ends there, at the radius ``end``."""
        numbers = self._numbers
        return numbers[-1] if self.points[0, -1, 0] == end else np.concatenate([numbers[-1], numbers[-2::-1, -1]])

    def outline(self, end: float) -> Array:
        """The points of ``outline_numbers``."""
        return self.points.reshape(-1, 2)[self.outline_numbers(end)]


# --------------------------------------------------------------------------------------------------
# The body that is meshed: a rectangle of layers with supports, cut out of the specimen where that is unbounded.


# Where an unbounded specimen is cut, in lengths over which its field changes far from the contact.
CUT_HALF_SPACE = 500.0  # size of the cut-out; tuned on the bodies of `make tuning`, by `make tuning`
CUT_BONDED = 40.0  # width beyond the contact on a bonded base; tuned on the same, by `make tuning`
CUT_SLIDING = 1000.0  # width beyond the contact on a sliding base; tuned on the same, by `make tuning`
CUT_CALIBRATION = 100.0  # candidate radii to its half-space's end; theory: the rest of what it lacks ~ its ^-3


@dataclass(frozen=True)
class MeshedBody:
    """Layers from the surface down, each ``thicknesses[i]`` m of ``materials[i]``, out to radius ``width`` [m].

    ``bonded``: the base holds the body, else it only supports it; ``cut_below``: the lowest layer stands for a
    half-space; ``cut_beside``: the specimen is wider than the body; ``completed``: the displacement that a cut-out
    half-space lacks is added; ``tension`` of the whole surface [N/m].
    """

    thicknesses: tuple[float, ...]
    materials: tuple[Material, ...]
    width: float
    bonded: bool
    side: Side
    cut_below: bool
    cut_beside: bool
    completed: bool = False
    tension: float = 0.0

    @property
    def depth(self) -> float:
        return float(sum(self.thicknesses))

    @property
    def interfaces(self) -> Array:
        """Depths of the layer boundaries inside the body, increasing [m]."""
        return np.cumsum(self.thicknesses)[:-1]

    @property
    def layers(self) -> list[tuple[float, float]]:
        """Top depth and thickness [m] of the layers whose lower side is a boundary of the specimen."""
        tops = np.concatenate([[0.0], self.interfaces])
        pairs = list(zip(tops.tolist(), self.thicknesses, strict=True))
        return pairs[:-1] if self.cut_below else pairs


def truncate(problem: Problem, reach: float, depth: float | None, width: float | None) -> MeshedBody:
    """The body to mesh for contact radii up to ``reach``; ``depth`` and ``width``: the user's truncation, or None."""
    specimen = problem.specimen
    if problem.indenter.material is not None:
        # An elastic indenter on a homogeneous half-space acts through E* alone (Eq. 4): give it all to the half-space
        nu = specimen.surface.nu
        specimen = Specimen((), HalfSpace(Elastic(problem.E_star * (1 - nu**2), nu)))
    # Length over which the field changes far from the contact [m]: the layers' thickness, longer under a stiff
    # plate (of moduli E1 on E2 like (E1/E2)^(1/3) on a half-space, and like (E1/E2)^(1/4) on a layer, as
    # Winkler's) or under a tension, that carries over kappa = 2 Ups/E* on a half-space, and sqrt(kappa h) on a
    # layer
    kappa = specimen.tension_length
    moduli = [modulus for layer in specimen.layers for modulus in layer.moduli]
    total = sum(layer.thickness for layer in specimen.layers)
    if isinstance(specimen.base, HalfSpace):
        E = specimen.base.material.surface.E
        contrast = max([*moduli, E]) / E
        decay = max(reach, total * contrast ** (1 / 3), kappa)
    else:
        decay = max(total * (max(moduli) / min(moduli)) ** (1 / 4), math.sqrt(kappa * total))
    base, thicknesses = specimen.base, [layer.thickness for layer in specimen.layers]
    if isinstance(base, HalfSpace):
        bonded, far = True, CUT_HALF_SPACE * decay
        cut = far if depth is None else depth
        if 2 * (total + reach) >= cut:
            raise Refusal(
                f"mesh.depth: {cut:g} m leaves too little of the half-space below contact and layers; "
                f"give more than {2 * (total + reach):.3g} m or leave it out"
            )
        thicknesses.append(cut - total)
    else:
        bonded, far = base.bonded, reach + (CUT_BONDED if base.bonded else CUT_SLIDING) * decay
        if depth is not None:
            raise Refusal(
                f"mesh.depth: the specimen ends at its rigid substrate, {specimen.thickness:g} m deep: leave it out"
            )
    cut_below, cut_beside = isinstance(base, HalfSpace), specimen.radius is None
    completed = cut_below and depth is None and width is None
    side: Side = "free" if cut_beside else specimen.side or "free"
    own = tuple(thicknesses), specimen.materials, _width(specimen, reach, width, far), bonded, side
    return MeshedBody(*own, cut_below, cut_beside, completed=completed, tension=specimen.surface_tension)


def homogenised_half_space(body: MeshedBody, reach: float) -> MeshedBody:
    """A homogeneous half-space of the uppermost material at the surface, for contact radii up to ``reach`` [m]."""
    top = surface_material(body.materials[0])
    size = CUT_CALIBRATION * max(reach, 2 * body.tension / top.surface.E_star)
    return MeshedBody((size,), (top,), size, True, "free", True, True, completed=True, tension=body.tension)


def surface_material(material: Material) -> Elastic | TransverselyIsotropic:
    """The homogeneous material that the first touch of ``material`` feels."""
    return material.top if isinstance(material, AnyTransverse) else material.surface


# What a mesh has to follow and elements have to hold: the reach of the contact, the edge of surfaces that stick, layers
# that displacements alone lock.

# Next to the edge the field of a compressible body oscillates with eta times the logarithm of the distance. Where
# that is turned too far nodes fall out of step. choice: logarithm of where the turn begins, and the turn; on bonded
# layers of nu = -0.5, -0.8, -0.95 nodes do below spacings of 0.045, 0.1, 0.16
STUCK_PHASE = (3.8, 1.7)
# Poisson's ratios beyond which displacements alone lock.
LOCKING_SLIDING = 0.49  # tuned on the gel of Sec. 4.3 and its like, by `make tuning`
# tuned on bodies, by `make constants`: the edge of the shear locks before the layer does; at 0.45 and a/h = 10/3
# radii err by 3e-4, mixed by 5e-5
LOCKING_STICKING = 0.4
# of the largest depth: below it few nodes are in contact, and the budget leaves the rows out; tuned on bodies, by
# `make constants`: says so
BUDGET_JUDGED_DEPTH = 0.01


def expected_reach(options: FEMOptions, problem: Problem) -> float:
    """Radius out to which the mesh is fine and nodes are candidates [m]."""
    largest = options.contact_radius if options.contact_radius is not None else largest_radius(problem)
    return within(problem, options.margin * largest)


def within(problem: Problem, reach: float) -> float:
    """The reach, or where the body or the indenter's profile ends before [m]."""
    edge = problem.specimen.radius if problem.specimen.radius is not None else math.inf
    return min(reach, edge, problem.indenter.r_max * (1 - ROUNDED))


def mixed_layers(options: FEMOptions, problem: Problem) -> tuple[int, ...]:
    """Layers that get a pressure unknown."""
    if options.order == 1 or options.formulation == "displacement":
        return ()
    materials = problem.specimen.materials
    return pressure_layers(materials, problem.sticks, None if options.formulation == "auto" else 0.0)


def finest_spacing(material: Material) -> float:
    """Least spacing of surface vertices over the radius that follows a contact that sticks to the ``material``."""
    eta = abs(oscillation(surface_material(material))[1])
    start, turn = STUCK_PHASE
    return math.exp(start - turn / eta) if eta else 0.0


def oscillation(material: Material) -> tuple[float, float]:
    """Dundurs's constant of the material under a rigid indenter, and the oscillation index."""
    zz, zr, rr = half_space_compliances(material)
    beta = zr / math.sqrt(zz * rr)
    return beta, math.atanh(beta) / math.pi


def pressure_layers(materials: Sequence[Material], sticks: bool, above: float | None = None) -> tuple[int, ...]:
    """Layers that get a pressure unknown: those of a Poisson's ratio ``above`` this one (None: where displacements of
    surfaces that slide, or stick, lock)."""
    if above is None:
        above = LOCKING_STICKING if sticks else LOCKING_SLIDING
    return tuple(i for i, material in enumerate(materials) if material.surface.nu > above)


def _width(specimen: Specimen, reach: float, width: float | None, far: float) -> float:
    """Radius of the body [m]: the specimen's own, the user's ``width``, or ``far``."""
    if specimen.radius is not None:
        if width is not None:
            raise Refusal(f"mesh.width: the specimen ends at its radius, {specimen.radius:g} m: leave it out")
        return specimen.radius
    if width is not None and width <= 1.5 * reach:
        raise Refusal(
            f"mesh.width: must be more than 1.5 times the refined zone, {1.5 * reach:.4g} m, or left out, got "
            f"{width:g} m"
        )
    return far if width is None else width


# --------------------------------------------------------------------------------------------------
# Free triangle meshes, and meshes and fields as files (the door to gmsh and meshio).

SYSTEM_PACKAGES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
PACKAGES = {"gmsh": "gmsh", "skfem": "scikit-fem", "meshio": "meshio"}  # of finite elements, by their modules


def missing_packages(*modules: str) -> str | None:
    """Return which packages finite elements lack here, and the remedy; None where all ``modules`` are installed."""
    if all(find_spec(module) for module in modules):
        return None
    missing = ", ".join(package for module, package in PACKAGES.items() if not find_spec(module))
    return f"finite elements need packages that are not installed ({missing}): {how_to_install()}, or another method"


def how_to_install() -> str:
    """The command for what finite elements need, and where gmsh has no wheel: Linux and Windows on ARM, and musl."""
    return f"{installs('')} (gmsh on ARM but for macOS, and with musl: from conda-forge or Debian's python3-gmsh)"


def require(*modules: str) -> None:
    """Refusal where one of the ``modules`` of finite elements is not installed."""
    if reason := missing_packages(*modules):
        raise Refusal(reason)


@contextmanager
def _gmsh() -> Iterator[ModuleType]:
    """A fresh gmsh session that leaves signal handlers and the user's configuration alone."""
    require("gmsh")
    try:
        import gmsh
    except OSError as error:
        raise InputError(
            f"gmsh cannot be loaded ({error}): install its system libraries with 'apt-get install {SYSTEM_PACKAGES}', "
            "or use a method that needs no mesh (closed-form, layered) or structured quadrilaterals"
        ) from error
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        for name in ("ExtendFromBoundary", "FromPoints"):  # only the size law counts
            gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
        gmsh.model.add("body")
        yield gmsh
    finally:
        gmsh.finalize()


def triangles(surface: Array, depth: float, interfaces: Array, size: str, strip: Strip | None = None) -> Grid:
    """Free triangles of the rectangle below ``surface``, the radii of the surface's vertices (0 to the body's width).

    ``interfaces``: depths of the lines that no triangle crosses; ``size``: the size law as a formula in x = r, y = z;
    ``strip``: triangles below the first surface vertices, taken as they are.
    Lengths should be of order one where the mesh is fine: gmsh has absolute tolerances.
    """
    top = np.column_stack([surface, np.zeros_like(surface)])
    if strip is not None:
        top = np.concatenate([strip.outline(surface[-1]), top[strip.width :]])
    with _gmsh() as gmsh:
        _rectangle(gmsh, top, [*interfaces, depth])
        field = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(field, "F", size)
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        gmsh.model.mesh.generate(2)
        # Points, cells, and the numbers of the first top points of the geometry
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        kinds, _, node_tags = gmsh.model.mesh.getElements(2)
        if list(kinds) != [2]:
            raise SolveError(f"mesh: expected triangles only, gmsh gave element types {list(kinds)}")
        number = np.zeros(int(tags.max()) + 1, dtype=int)
        number[tags.astype(int)] = np.arange(tags.size)
        first = number[[int(gmsh.model.mesh.getNodes(0, tag)[0][0]) for tag in range(1, len(top) + 1)]]
        points, cells = coordinates.reshape(-1, 3)[:, :2].copy(), number[node_tags[0].astype(int)].reshape(-1, 3)
    # Put vertices on the body's straight lines exactly, in place (gmsh leaves round-off there)
    width = surface[-1]
    depths = [0.0, *interfaces, depth]
    for column, values in ((0, [0.0, width]), (1, [-depth for depth in depths])):
        for value in values:
            near = np.abs(points[:, column] - value) <= 1e-13 * max(width, depths[-1]) + 1e-11 * abs(value)
            points[near, column] = value
    if strip is not None:
        # One mesh of the strip and what is below and beside it; `top`: the vertices along the top, from the axis on.
        own = strip.points.reshape(-1, 2)
        shared = strip.outline_numbers(surface[-1])
        numbers = np.arange(len(points)) + len(own)
        numbers[first[: shared.size]] = shared
        points, cells = np.concatenate([own, points]), np.concatenate([strip.cells, numbers[cells]])
    return make_grid(points, cells, np.asarray(interfaces))


def _rectangle(gmsh: ModuleType, top_points: Array, depths: list[float]) -> None:
    """Stacked rectangles; the top side has exactly the given vertices, from the axis outwards."""
    geo = gmsh.model.geo
    width = top_points[-1, 0]
    tags = [geo.addPoint(r, z, 0) for r, z in top_points]
    top = [geo.addLine(p, q) for p, q in itertools.pairwise(tags)]
    fixed = list(top)
    left, right = tags[0], tags[-1]
    for depth in depths:
        low_left, low_right = geo.addPoint(0, -depth, 0), geo.addPoint(width, -depth, 0)
        lines = [geo.addLine(p, q) for p, q in itertools.pairwise([right, low_right, low_left, left])]
        geo.addPlaneSurface([geo.addCurveLoop([*top, *lines])])
        top, left, right = [-lines[1]], low_left, low_right
    geo.synchronize()
    for line in fixed:
        gmsh.model.mesh.setTransfiniteCurve(line, 2)


def write_msh(grid: Grid, path: Path) -> None:
    """Write the mesh in gmsh's format 4.1 with the layers and the named boundaries as physical groups."""
    kind = 2 if grid.element == "triangle" else 3
    with _gmsh() as gmsh:
        model = gmsh.model
        layers = np.unique(grid.materials)
        for layer in layers:
            model.addDiscreteEntity(2, int(layer) + 1)
        tags = np.arange(1, len(grid.points) + 1)
        flat = np.column_stack([grid.points, np.zeros(len(grid.points))]).ravel()
        model.mesh.addNodes(2, int(layers[0]) + 1, tags, flat)
        for layer in layers:
            cells = grid.cells[grid.materials == layer] + 1
            model.mesh.addElementsByType(int(layer) + 1, kind, [], cells.ravel())
            model.addPhysicalGroup(2, [int(layer) + 1], name=f"layer-{int(layer) + 1}")
        for number, (name, facets) in enumerate(grid.boundaries.items(), start=1):
            model.addDiscreteEntity(1, number)
            model.mesh.addElementsByType(number, 1, [], (facets + 1).ravel())
            model.addPhysicalGroup(1, [number], name=name)
        with tempfile.TemporaryDirectory() as folder:  # gmsh takes no names that are no text
            written = Path(folder) / "mesh.msh"
            gmsh.write(str(written))
            path.write_bytes(written.read_bytes())


def write_vtu(
    grid: Grid,
    path: Path,
    point_data: Mapping[str, Array] | None = None,
    cell_data: Mapping[str, Array] | None = None,
    middles: Array | None = None,
) -> None:
    """Write the mesh in VTK's format .vtu with layer and quality of each cell; ``point_data``: values at points,
    ``cell_data``: of cells; ``middles`` (m, 3): points amid the sides 01, 12, 20, which make triangles quadratic."""
    require("meshio")
    import meshio

    points = np.column_stack([grid.points, np.zeros(len(grid.points))])
    kind, cells = "triangle" if grid.element == "triangle" else "quad", np.asarray(grid.cells)
    if middles is not None:
        kind, cells = "triangle6", np.column_stack([cells, middles])
    of_cells = {"layer": grid.materials, "quality": grid.quality()} | dict(cell_data or {})
    data = {name: [np.asarray(values)] for name, values in of_cells.items()}
    mesh = meshio.Mesh(points, [(kind, cells)], point_data=dict(point_data or {}), cell_data=data)
    mesh.write(str(path), file_format="vtu")


# Element sizes over a body, dimensionless.
LAYOUT_FAR = 5.0  # reaches from the contact, beyond which the field is smooth; tuned on the bodies of `make tuning`
LAYOUT_FAR_GROWTH = 0.2  # growth there, at most, twice the near one; tuned on the same, by `make tuning`
LAYOUT_STEEPEST = 0.6  # growth of any mesh; tuned on bodies, by `make constants`: beyond it triangles are slender
LAYOUT_TOP_LAYER = 1.0  # size in the top layer, of growth times thickness; tuned on the same, by `make tuning`
LAYOUT_DEEP_LAYER = 2.0  # size in deeper ones; tuned on the same, by `make tuning`
LAYOUT_FEWEST_ROWS = 2.0  # through a layer; tuned on bodies, by `make constants`: one row holds no bending
LAYOUT_LONGEST = 100.0  # cell in a layer far from the contact, in thicknesses; tuned on the same, by `make tuning`
LAYOUT_CORNER = 0.02  # size at a corner singularity, of growth times extent; tuned on the same, by `make tuning`
LAYOUT_ZONE_THREE = 20.0  # units; theory: depth of the paper's body (Sec. 4.1), beyond it elements grow on
LAYOUT_ROWS = 2  # of the strip below the contact; tuned on the same, by `make tuning`
LAYOUT_HEIGHT = 0.8  # of a row, in local distances of the vertices; tuned on the same, by `make tuning`
# Rows at the surface of a material whose modulus changes much within the first one, each so high over the next:
LAYOUT_THINNER = 0.3  # tuned on power laws of depth, by `make bounds`
LAYOUT_CHANGED = 1.3  # factor of the modulus that one row follows; tuned on power laws of depth, by `make bounds`
LAYOUT_THINNEST = 5  # of them, at most; choice: the first is then 2e-3 of a row
LAYOUT_SHARE = 0.6  # of the top layer that the strip takes, at most; tuned on the same, by `make tuning`
LAYOUT_BEYOND = 4.0  # sizes at the reach: so far the strip goes on; tuned on the same, by `make tuning`
LAYOUT_BELOW = 5 / 3  # growth below the strip of a calibration, in the body's; tuned on the same, by `make tuning`
LAYOUT_FAR_BELOW = 4.0  # and far from the contact; tuned on the same, by `make tuning`
LAYOUT_DIGITS = 12  # of dimensionless lengths; choice: the mesh does not depend on the unit of length
LAYOUT_MOST_CELLS = 3_000_000  # choice: more need more memory than machines have


@dataclass(frozen=True)
class Layout:
    """A size law over a body, in units of ``unit`` [m]: what is needed to make a grid, and to coarsen it.

    ``sides``: (extent, size) along both sides of quadrilateral zones; ``fixed``: radii of the first surface vertices
    and ``thickest``: how deep the strip below them may be, both taken from another layout; ``thin``: rows into which
    the first one below the surface is divided.
    """

    body: MeshedBody
    law: SizeLaw
    unit: float
    element: str
    sides: tuple[tuple[float, float], ...] = ()
    fixed: tuple[float, ...] = ()
    thickest: float | None = None
    thin: int = 0

    @property
    def shares(self) -> Array:
        """Depths of the rows below the surface in the height of one, as far as they are ``thin``."""
        return np.append(LAYOUT_THINNER ** np.arange(self.thin, 0.0, -1), 1.0)

    def following(self) -> Layout:
        """The layout with as many thin rows as follow how the modulus grows below the surface."""
        material = self.body.materials[0]
        if not isinstance(material, AnyGraded):
            return self
        heights = self._row * LAYOUT_THINNER ** np.arange(LAYOUT_THINNEST)
        moduli = np.log([law.at(np.append(heights, 0.0)) for law in material.laws])
        large = np.abs(moduli[:, :-1] - moduli[:, -1:]).max(axis=0) > np.log(LAYOUT_CHANGED)
        return replace(self, thin=int(large.sum()))

    @property
    def _row(self) -> float:
        """Height of the largest row below the contact [m], thin ones together."""
        size = float(self._along_surface(np.array([self.law.reach]))[0])
        return min(LAYOUT_HEIGHT * size, self._thickest / LAYOUT_ROWS) * self.unit

    @property
    def unresolved(self) -> float:
        """What the row at the surface leaves of a modulus that grows like the power k < 1 of the depth there: k times
        the power 1 - k of its height over the reach, in which depth compresses next to a surface that yields."""
        material = self.body.materials[0]
        if not isinstance(material, AnyGraded):
            return 0.0
        first = self._row * float(self.shares[0])
        moduli = np.log([law.at(first * (1 + np.array([-SAME, SAME]))) for law in material.laws])
        k = float(np.clip(np.diff(moduli).max() / (2 * SAME), 0.0, 1.0))
        return k * (first / (self.law.reach * self.unit)) ** (1 - k)

    def coarser(self, factor: float) -> Layout:
        """The same layout with every element ``factor`` times as large."""
        sides = tuple((extent, size * factor) for extent, size in self.sides)
        return replace(self, law=self.law.coarser(factor, LAYOUT_STEEPEST), sides=sides)

    def on(self, body: MeshedBody) -> Layout:
        """The same surface vertices in the contact, and strip below them, on another body without layers."""
        growth, far = (min(factor * self.law.growth, LAYOUT_STEEPEST) for factor in (LAYOUT_BELOW, LAYOUT_FAR_BELOW))
        law = replace(self.law, layers=(), zones=(), corners=(), growth=growth, far_growth=far)
        surface = self._surface_points(self.body.width / self.unit)
        fixed = surface[: self._strip_width(surface)]
        return replace(self, body=body, law=law, sides=(), fixed=tuple(fixed.tolist()), thickest=self._thickest)

    def expected_cells(self) -> float:
        """About how many elements ``grid`` will make, without making them."""
        width, depth = self.body.width / self.unit, self.body.depth / self.unit
        if self.element == "triangle":
            thin = 2 * self.thin * _expected_points(self._along_surface, self._strip_end) if self.thin else 0.0
            return expected_triangles(self.law, width, depth) + thin
        across = _expected_points(self._along_surface, width)
        corner = self._ring_start(width, depth, self.body.interfaces)
        if corner is None:
            return across * (_expected_points(self._down, depth) + self.thin)
        inner = _expected_points(self._along_surface, corner)
        return inner * (2 * across - inner)

    def grid(self) -> Grid:
        """Mesh the body."""
        width, depth = _rounded(self.body.width / self.unit), _rounded(self.body.depth / self.unit)
        interfaces = np.array([_rounded(depth) for depth in self.body.interfaces / self.unit])
        surface = self._surface_points(width)
        if self.element == "triangle":
            below = surface[: self._strip_width(surface)]
            shares = np.append(self.shares, np.arange(2.0, LAYOUT_ROWS + 1))
            strip = Strip.below(below, _rounded(self._thickest), shares, LAYOUT_HEIGHT)
            made = triangles(surface, depth, interfaces, self.law.text(), strip)
        else:
            made = make_grid(*self._quadrilaterals(surface, depth, interfaces), interfaces)
        return made.scaled(self.unit)

    def _along_surface(self, r: Array) -> Array:
        return self._sizes(r, r, np.zeros_like(r))

    def _down(self, z: Array) -> Array:
        """Size along the depth at the finest part of the contact."""
        return self._sizes(z, np.full_like(z, min(self.law.a0 + self.law.inner, self.law.reach)), -z)

    def _sizes(self, along: Array, r: Array, z: Array) -> Array:
        """Element sizes by the law at (r, z), or those of the ``sides`` where these give them."""
        return np.interp(along, *np.transpose(self.sides)) if self.sides else self.law(r, z)

    def _surface_points(self, width: float) -> Array:
        """Radii of the surface vertices; the edge of a flat end, the reach, the end of the strip and the corners of
        the zones are among them, so that the vertices within the reach do not depend on the width."""
        knots = [self.law.a0, self.law.reach, self._strip_end, *(extent for extent, _ in self.sides)]
        start = self.fixed[-1] if self.fixed else 0.0
        stops = np.unique([start, *(x for x in knots if start < x < width * (1 - ROUNDED)), width])
        parts = [graded_points(p, q, self._along_surface) for p, q in itertools.pairwise(stops)]
        return np.unique(np.concatenate([self.fixed, *parts]))

    @property
    def _strip_end(self) -> float:
        law = self.law
        return law.reach + LAYOUT_BEYOND * float(self._along_surface(np.array([law.reach]))[0])

    def _strip_width(self, surface: Array) -> int:
        """Number of surface vertices of the strip; all where it would nearly reach the end of the body."""
        if self.fixed:
            return len(self.fixed)
        n = int(np.searchsorted(surface, self._strip_end * (1 + ROUNDED)))
        return n if n + 1 < surface.size else surface.size

    @property
    def _thickest(self) -> float:
        """Most that the strip may take of the body or its top layer."""
        if self.thickest is not None:
            return self.thickest
        layers = self.body.layers or [(0.0, self.body.depth)]
        return LAYOUT_SHARE * layers[0][1] / self.unit

    def _quadrilaterals(self, surface: Array, depth: float, interfaces: Array) -> tuple[Array, Array]:
        """Vertices and cells of a tensor grid, or of rings around a smaller one."""
        corner = self._ring_start(surface[-1], depth, interfaces)
        if corner is None:
            stops = [0.0, *interfaces, depth]
            lines = [graded_points(p, q, self._down) for p, q in itertools.pairwise(stops)]
            down = _limited(surface, np.unique(np.concatenate(lines)))
            return tensor_quads(surface, np.union1d(down, down[1] * self.shares))
        inner = surface[surface <= corner * (1 + ROUNDED)]
        rings = surface[surface > corner * (1 + ROUNDED)]
        across = np.log(rings / corner) / np.log(rings[-1] / corner)
        heights = corner * (depth / corner) ** across
        heights[-1] = depth
        return ringed_quads(inner, _limited(surface, inner), rings, heights)

    def _ring_start(self, width: float, depth: float, interfaces: Array) -> float | None:
        """Side of the inner square that rings surround: of homogeneous large bodies touched at a point, else None (and
        where the surface is that of another layout)."""
        law = self.law
        if self.fixed or self.thin or interfaces.size or law.a0 > 0 or min(width, depth) < 5 * law.reach:
            return None
        return self.sides[2][0] if self.sides else law.inner


def _expected_points(size: Callable[[Array], Array], stop: float) -> float:
    """About how many points spaced by ``size`` there are between 0 and ``stop``."""
    x = np.unique(np.concatenate([np.linspace(0, stop, 1000), stop * np.geomspace(1e-10, 1, 1000)]))
    return float(np.trapezoid(1 / size(x), x))


def _rounded(x: float) -> float:
    """The length ``x``, rounded to so many digits that the mesh does not depend on the unit of length."""
    scale = 10.0 ** (LAYOUT_DIGITS - np.ceil(np.log10(x or 1.0)))
    return float(np.round(x * scale) / scale)


def _limited(surface: Array, lines: Array) -> Array:
    if surface.size * lines.size > LAYOUT_MOST_CELLS:
        raise Refusal(
            f"mesh: {surface.size} x {lines.size} lines make too many quadrilaterals (at most {LAYOUT_MOST_CELLS}): "
            "take larger elements, or triangles"
        )
    return lines


# ---------------------------------------------------------------------- the two layouts
def layout_for(options: FEMOptions, problem: Problem, reach: float) -> Layout:
    """The layout of the options, fine out to the radius ``reach`` [m]. Refusal: too many elements, or a truncation
    that does not fit the body."""
    body = truncate(problem, reach, options.depth, options.width)
    a0, growth = problem.indenter.a0, options.growth_of_sizes
    if options.layout == "scaled":
        smallest = options.smallest * (reach - a0)
        layout = scaled_layout(body, options.element, reach, a0, smallest, options.spacing, growth)
    else:
        layout = zones_layout(body, options, reach, a0, problem.indenter.tip_radius or 6 * reach)
    if (cells := layout.expected_cells()) > LAYOUT_MOST_CELLS:
        # Remedy for too many cells
        if options.tolerance is not None:
            remedy = "use a larger mesh.tolerance, or use the method layered where it represents the body"
        else:
            size = "mesh.element_size" if options.layout == "zones" else "mesh.spacing or mesh.smallest"
            quads = options.element == "quadrilateral"
            fewer = quads and replace(layout, element="triangle").expected_cells() < cells
            remedy = f"take a larger {size}, or {'triangles' if fewer else 'a larger mesh.growth'}"
        raise Refusal(
            f"mesh: about {cells:.1e} elements expected, too many {options.element}s (at most {LAYOUT_MOST_CELLS}): "
            + remedy
        )
    return layout


def scaled_layout(
    body: MeshedBody, element: str, reach: float, a0: float, smallest: float, spacing: float, growth: float
) -> Layout:
    """Element size ``spacing`` times the distance from the first contact beyond ``smallest`` [m], then growing."""
    law = _law(body, reach, 1.0, a0, growth)
    return Layout(body, replace(law, inner=_rounded(smallest / reach), slope=spacing), reach, element).following()


def zones_layout(body: MeshedBody, options: FEMOptions, reach: float, a0: float, R: float) -> Layout:
    """The paper's zones (Sec. 4.1): uniform ``element_size`` over the contact, then up to ``zone_sizes[k]`` (in units
    of ``R``) within zone I (square R), II (square 2R), III. On a body thinner than R the unit is its depth instead."""
    thin = not body.cut_below and body.depth < R
    unit = body.depth if thin else R
    size = options.element_size if options.element_size is not None else (0.02 if thin else 0.0005) * unit
    extent, e = _rounded(reach / unit), _rounded(size / unit)
    halves = 2 if options.order == 2 and options.element == "triangle" else 1
    second = max(2.0, 2.5 * extent)
    ends = (max(1.0, 1.25 * extent), second, max(LAYOUT_ZONE_THREE, 2 * second))
    zones = tuple((end, max(halves * size, e)) for end, size in zip(ends, options.zone_sizes, strict=True))
    law = replace(_law(body, unit, extent, a0, options.growth_of_sizes), floor=e, zones=() if thin else zones)
    if options.element == "triangle":
        return Layout(body, law, unit, options.element).following()
    far = max(body.width, body.depth, 2 * ends[2] * unit) / unit
    beyond = (far, zones[2][1] + law.far_growth * (far - ends[2]))
    return Layout(body, law, unit, options.element, ((0.0, e), (extent, e), *zones, beyond)).following()


def _law(body: MeshedBody, unit: float, reach: float, a0: float, growth: float) -> SizeLaw:
    """Size law of contact, layers and corners in units of ``unit`` [m]: out to ``reach`` units, round ``a0`` [m]."""
    far_growth = max(growth, min(2 * growth, LAYOUT_FAR_GROWTH))
    # Elements across the layers: 1/growth through the uppermost one, half as many through deeper ones
    layers = []
    for i, (top, thickness) in enumerate(body.layers):
        share, t = (LAYOUT_TOP_LAYER if i == 0 else LAYOUT_DEEP_LAYER) * growth, _rounded(thickness / unit)
        layers.append((_rounded(top / unit), t, min(share, 1 / LAYOUT_FEWEST_ROWS) * t, LAYOUT_LONGEST * t))
    # Points of singular fields, where the side's support meets another one: a free side on a bonded base, a clamped
    # side at the free surface
    size = LAYOUT_CORNER * growth * min(body.depth, body.width) / unit
    singular = {body.depth: body.side == "free" and body.bonded, 0.0: body.side == "clamped"}
    corners = [
        (_rounded(body.width / unit), _rounded(depth / unit), _rounded(size))
        for depth, is_singular in singular.items()
        if is_singular and not body.cut_beside
    ]
    law = SizeLaw(reach, growth, far_growth, LAYOUT_FAR, _rounded(a0 / unit))
    return replace(law, layers=tuple(layers), corners=tuple(corners))

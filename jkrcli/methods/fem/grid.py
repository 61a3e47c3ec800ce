"""Meshes as plain arrays: vertices and cells in the (r, z) half-plane, and those parts of them that are structured.

The body is the rectangle 0 <= r <= L, -H <= z <= 0; the contact surface is z = 0 and the axis r = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...base import Array, SolveError


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
    grid = Grid(points, cells, materials, _boundaries(points, cells))
    for array in (points, cells, materials):
        array.setflags(write=False)
    if not grid.quality().min() > 0:
        raise SolveError(f"mesh: a cell is degenerate (quality {grid.quality().min():.2g})")
    return grid


def _boundaries(points: Array, cells: Array) -> dict[str, Array]:
    """Facets that belong to one cell only, named by the side of the rectangle they lie on."""
    pairs = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, first, count = np.unique(pairs[:, 0] * len(points) + pairs[:, 1], return_index=True, return_counts=True)
    outer = pairs[first[count == 1]]
    (width, _), (_, depth) = points.max(axis=0), -points.min(axis=0)
    on = {name: ends.all(axis=1) for name, ends in sides(points[outer], width, depth).items()}
    if sum(int(mask.sum()) for mask in on.values()) != len(outer):
        raise SolveError("mesh: the boundary of the mesh is not the boundary of the body (a crack or an overlap)")
    return {name: outer[mask] for name, mask in on.items()}


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
    strip share that, whatever lies below; so one calibrates the other (``fem.edge``).
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

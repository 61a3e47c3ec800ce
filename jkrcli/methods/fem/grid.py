"""A mesh as plain arrays: vertices and cells in the (r, z) half-plane, with materials, named boundaries and quality.

The body is the rectangle 0 <= r <= L, -H <= z <= 0; the contact surface is z = 0 and the axis r = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...base.errors import SolveError

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Grid:
    """``points`` (n, 2) [m]; ``cells`` (m, 3) triangles or (m, 4) quadrilaterals, counter-clockwise vertex numbers;
    ``materials`` (m,) index of the cell's layer from the top; ``boundaries``: facets (k, 2) as vertex pairs."""

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
    points, cells = _used_only(points, cells)
    cells = _counter_clockwise(points, cells)
    materials = np.searchsorted(np.asarray(interfaces), -points[cells, 1].mean(axis=1))
    grid = Grid(points, cells, materials, _boundaries(points, cells))
    for array in (points, cells, materials):
        array.setflags(write=False)
    if not grid.quality().min() > 0:
        raise SolveError(f"mesh: a cell is degenerate (quality {grid.quality().min():.2g})")
    return grid


def _used_only(points: Array, cells: Array) -> tuple[Array, Array]:
    """Drop vertices that belong to no cell."""
    used, numbers = np.unique(cells, return_inverse=True)
    return points[used], numbers.reshape(cells.shape)


def _counter_clockwise(points: Array, cells: Array) -> Array:
    a, b, c = points[cells[:, 0]], points[cells[:, 1]], points[cells[:, 2]]
    return np.where((_cross(b - a, c - b) < 0)[:, None], cells[:, ::-1], cells)


def facets_of(cells: Array) -> Array:
    """All facets (vertex pairs, smaller number first) of all cells, inner ones twice."""
    pairs = np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.sort(pairs, axis=1)


def _boundaries(points: Array, cells: Array) -> dict[str, Array]:
    """Facets that belong to one cell only, named by the side of the rectangle they lie on."""
    pairs = facets_of(cells)
    _, first, count = np.unique(pairs[:, 0] * len(points) + pairs[:, 1], return_index=True, return_counts=True)
    outer = pairs[first[count == 1]]
    r, z = points[outer, 0], points[outer, 1]
    on = {
        "surface": (z == 0).all(axis=1),
        "base": (z == points[:, 1].min()).all(axis=1),
        "axis": (r == 0).all(axis=1),
        "side": (r == points[:, 0].max()).all(axis=1),
    }
    if sum(int(mask.sum()) for mask in on.values()) != len(outer):
        raise SolveError("mesh: the boundary of the mesh is not the boundary of the body (a crack or an overlap)")
    return {name: outer[mask] for name, mask in on.items()}

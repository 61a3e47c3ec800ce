"""Structured quadrilateral meshes: a tensor grid of lines, optionally surrounded by rings of nested rectangles."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def tensor_quads(r: Array, depths: Array) -> tuple[Array, Array]:
    """Vertices and cells of the grid of lines at radii ``r`` and at ``depths`` (both increasing from 0) [m]."""
    points = np.stack(np.meshgrid(r, -depths, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, _cells(np.arange(len(points)).reshape(r.size, depths.size))


def ringed_quads(r: Array, depths: Array, widths: Array, heights: Array) -> tuple[Array, Array]:
    """A tensor grid inside, and around it rings of rectangles: ring k reaches to radius ``widths[k]`` and depth
    ``heights[k]``. Every ring carries the divisions of the inner grid's outer sides, so no element is a triangle."""
    points, cells = tensor_quads(r, depths)
    numbers = np.arange(len(points)).reshape(r.size, depths.size)
    path = np.concatenate([numbers[-1, :], numbers[-2::-1, -1]])  # down the right side, then along the bottom inwards
    corner = depths.size - 1
    all_points, all_cells, count = [points], [cells], len(points)
    outline = np.stack([points[path, 0] / r[-1], points[path, 1] / depths[-1]], axis=1)
    strip = [path]
    for width, height in zip(widths, heights, strict=True):
        all_points.append(outline * (width, height))
        strip.append(np.arange(count, count + path.size))
        count += path.size
    rings = np.array(strip)
    all_cells += [_cells(rings[:, : corner + 1]), _cells(rings[:, corner:])]
    return np.concatenate(all_points), np.concatenate(all_cells)


def _cells(numbers: Array) -> Array:
    """Quadrilaterals of a logically rectangular array of vertex numbers."""
    corners = (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:])
    return np.stack([corner.ravel() for corner in corners], axis=1)

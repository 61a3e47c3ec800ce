"""Rows of right-angled triangles below the contact surface: the part that two meshes have in common.

Where a vertex sits relative to the edge of the contact depends on the elements around it. Two meshes with the same
strip share that, whatever lies below; so one calibrates the other (``fem.edge``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray
ROWS = 2
HEIGHT = 0.8  # of a row, in local distances of the surface vertices
SHARE = 0.6  # of the top layer's thickness, at most


@dataclass(frozen=True, eq=False)
class Strip:
    """``points`` (rows + 1, n, 2): vertices by row from the surface down and by increasing radius."""

    points: Array

    @property
    def cells(self) -> Array:
        """Vertex numbers of the triangles, row after row (2 rows (n - 1), 3)."""
        rows, n = self.points.shape[:2]
        numbers = np.arange(rows * n).reshape(rows, n)
        a, b, c, d = (part.ravel() for part in (numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]))
        return np.concatenate([np.stack([d, c, a], axis=1), np.stack([c, b, a], axis=1)])

    @property
    def width(self) -> int:
        """Number of surface vertices."""
        return self.points.shape[1]

    def outline_numbers(self, end: float) -> Array:
        """Numbers of the vertices below it from the axis on, then those beside it up to the surface, unless the body
        ends there, at the radius ``end``."""
        rows, n = self.points.shape[:2]
        numbers = np.arange(rows * n).reshape(rows, n)
        return numbers[-1] if self.points[0, -1, 0] == end else np.concatenate([numbers[-1], numbers[-2::-1, -1]])

    def outline(self, end: float) -> Array:
        """The points of ``outline_numbers``."""
        return self.points.reshape(-1, 2)[self.outline_numbers(end)]


def strip_below(radii: Array, thickest: float) -> Strip:
    """The strip below surface vertices at ``radii`` (from 0 on), together no deeper than ``thickest``."""
    steps = np.diff(radii)
    local = np.concatenate([steps[:1], np.minimum(steps[1:], steps[:-1]), steps[-1:]])
    height = np.minimum(HEIGHT * local, thickest / ROWS)
    depths = np.arange(ROWS + 1)[:, None] * height
    return Strip(np.stack([np.broadcast_to(radii, depths.shape), -depths], axis=-1))

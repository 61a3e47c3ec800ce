"""Meshes and fields on them as files for other programs (VTK's .vtu through meshio)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from .grid import Grid

Array = np.ndarray


def write_vtu(grid: Grid, path: Path, point_data: Mapping[str, Array] | None = None) -> None:
    """Write the grid with the layer and the quality of each cell; ``point_data``: values at the vertices."""
    import meshio

    points = np.column_stack([grid.points, np.zeros(len(grid.points))])
    kind = "triangle" if grid.element == "triangle" else "quad"
    cell_data = {"layer": [np.asarray(grid.materials)], "quality": [grid.quality()]}
    mesh = meshio.Mesh(points, [(kind, np.asarray(grid.cells))], point_data=dict(point_data or {}), cell_data=cell_data)
    mesh.write(str(path), file_format="vtu")

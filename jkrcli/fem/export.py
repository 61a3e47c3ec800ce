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


def write_msh(grid: Grid, path: Path) -> None:
    """Write the grid in gmsh's MSH 2.2 text format: layers as physical surfaces, boundaries as physical curves."""
    layers = np.unique(grid.materials)
    names = [f'2 {layer + 1} "layer {layer + 1}"' for layer in layers]
    names += [f'1 {len(layers) + i + 1} "{name}"' for i, name in enumerate(grid.boundaries)]
    kind = 2 if grid.element == "triangle" else 3
    rows = [
        f"1 2 {len(layers) + i + 1} {len(layers) + i + 1} {a + 1} {b + 1}"
        for i, facets in enumerate(grid.boundaries.values())
        for a, b in facets
    ]
    rows += [
        f"{kind} 2 {layer + 1} {layer + 1} {' '.join(map(str, cell + 1))}"
        for layer, cell in zip(grid.materials, grid.cells, strict=True)
    ]
    nodes = [f"{i} {r!r} {z!r} 0" for i, (r, z) in enumerate(grid.points.tolist(), start=1)]
    with path.open("w", encoding="utf-8") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        for section, lines in (("PhysicalNames", names), ("Nodes", nodes)):
            file.write(f"${section}\n{len(lines)}\n" + "\n".join(lines) + f"\n$End{section}\n")
        numbered = (f"{i} {row}" for i, row in enumerate(rows, start=1))
        file.write(f"$Elements\n{len(rows)}\n" + "\n".join(numbered) + "\n$EndElements\n")

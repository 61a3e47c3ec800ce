"""The only door to gmsh: free triangle meshes, and files in its format."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numpy as np

from ..errors import InputError, SolveError
from .grid import Grid, make_grid

Array = np.ndarray
SYSTEM_PACKAGES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
OPTIONS = {
    "Algorithm": 6,  # frontal Delaunay
    "Binary": 0,
    "ElementOrder": 1,
    "MeshSizeExtendFromBoundary": 0,
    "MeshSizeFactor": 1,
    "MeshSizeFromCurvature": 0,
    "MeshSizeFromParametricPoints": 0,
    "MeshSizeFromPoints": 0,
    "MeshSizeMax": 1e22,
    "MeshSizeMin": 0,
    "MshFileVersion": 4.1,
    "Optimize": 1,
    "RandomFactor": 1e-9,
    "RecombineAll": 0,
    "SaveAll": 0,
    "Smoothing": 1,
    "SubdivisionAlgorithm": 0,
    "ToleranceEdgeLength": 0,
}


@contextmanager
def _gmsh() -> Iterator[ModuleType]:
    """A fresh gmsh session that leaves signal handlers and the user's configuration alone."""
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
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.model.add("body")
        yield gmsh
    finally:
        gmsh.finalize()


def triangles(surface: Array, depth: float, interfaces: Array, size: str) -> Grid:
    """Free triangles of the rectangle below ``surface``, the radii of the surface's vertices (0 to the body's width).

    ``interfaces``: depths of the lines that no triangle crosses; ``size``: the size law as a formula in x = r, y = z.
    Lengths should be of order one where the mesh is fine: gmsh has absolute tolerances.
    """
    with _gmsh() as gmsh:
        _rectangle(gmsh, surface, [*interfaces, depth])
        field = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(field, "F", size)
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        gmsh.model.mesh.generate(2)
        points, cells = _arrays(gmsh)
    _snap(points, surface[-1], [0.0, *interfaces, depth])
    return make_grid(points, cells, np.asarray(interfaces))


def _rectangle(gmsh: ModuleType, surface: Array, depths: list[float]) -> None:
    """Stacked rectangles; the top side has exactly the given vertices."""
    geo = gmsh.model.geo
    width = surface[-1]
    top_points = [geo.addPoint(r, 0, 0) for r in surface]
    top = [geo.addLine(p, q) for p, q in itertools.pairwise(top_points)]
    fixed = list(top)
    left, right = top_points[0], top_points[-1]
    for depth in depths:
        low_left, low_right = geo.addPoint(0, -depth, 0), geo.addPoint(width, -depth, 0)
        side, bottom, axis = (
            geo.addLine(right, low_right),
            geo.addLine(low_right, low_left),
            geo.addLine(low_left, left),
        )
        geo.addPlaneSurface([geo.addCurveLoop([*top, side, bottom, axis])])
        top, left, right = [-bottom], low_left, low_right
    geo.synchronize()
    for line in fixed:
        gmsh.model.mesh.setTransfiniteCurve(line, 2)


def _arrays(gmsh: ModuleType) -> tuple[Array, Array]:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    kinds, _, node_tags = gmsh.model.mesh.getElements(2)
    if list(kinds) != [2]:
        raise SolveError(f"mesh: expected triangles only, gmsh gave element types {list(kinds)}")
    number = np.zeros(int(tags.max()) + 1, dtype=int)
    number[tags.astype(int)] = np.arange(tags.size)
    return coordinates.reshape(-1, 3)[:, :2].copy(), number[node_tags[0].astype(int)].reshape(-1, 3)


def _snap(points: Array, width: float, depths: list[float]) -> None:
    """Put vertices on the body's straight lines exactly, in place (gmsh leaves round-off there)."""
    for column, values in ((0, [0.0, width]), (1, [-depth for depth in depths])):
        for value in values:
            near = np.abs(points[:, column] - value) <= 1e-13 * max(width, depths[-1]) + 1e-11 * abs(value)
            points[near, column] = value


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
        gmsh.write(str(path))

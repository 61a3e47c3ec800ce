"""Free triangle meshes, and meshes and fields as files (the door to gmsh and meshio)."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numpy as np

from ...base import Array, InputError, SolveError
from .grid import Grid, Strip, make_grid

SYSTEM_PACKAGES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"


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
        points, cells, first = _arrays(gmsh, len(top))
    _snap(points, surface[-1], [0.0, *interfaces, depth])
    if strip is not None:
        points, cells = _joined(points, cells, first, strip, surface[-1])
    return make_grid(points, cells, np.asarray(interfaces))


def _joined(points: Array, cells: Array, top: Array, strip: Strip, width: float) -> tuple[Array, Array]:
    """One mesh of the strip and what is below and beside it; ``top``: the vertices along the top, from the axis on."""
    own = strip.points.reshape(-1, 2)
    shared = strip.outline_numbers(width)
    numbers = np.arange(len(points)) + len(own)
    numbers[top[: shared.size]] = shared
    return np.concatenate([own, points]), np.concatenate([strip.cells, numbers[cells]])


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


def _arrays(gmsh: ModuleType, top: int) -> tuple[Array, Array, Array]:
    """Points, cells, and the numbers of the first ``top`` points of the geometry."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    kinds, _, node_tags = gmsh.model.mesh.getElements(2)
    if list(kinds) != [2]:
        raise SolveError(f"mesh: expected triangles only, gmsh gave element types {list(kinds)}")
    number = np.zeros(int(tags.max()) + 1, dtype=int)
    number[tags.astype(int)] = np.arange(tags.size)
    first = [int(gmsh.model.mesh.getNodes(0, tag)[0][0]) for tag in range(1, top + 1)]
    cells = number[node_tags[0].astype(int)].reshape(-1, 3)
    return coordinates.reshape(-1, 3)[:, :2].copy(), cells, number[first]


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
        with tempfile.TemporaryDirectory() as folder:  # gmsh takes no names that are no text
            written = Path(folder) / "mesh.msh"
            gmsh.write(str(written))
            path.write_bytes(written.read_bytes())


def write_vtu(grid: Grid, path: Path, point_data: Mapping[str, Array] | None = None) -> None:
    """Write the mesh in VTK's format .vtu with layer and quality of each cell; ``point_data``: values at vertices."""
    import meshio

    points = np.column_stack([grid.points, np.zeros(len(grid.points))])
    kind = "triangle" if grid.element == "triangle" else "quad"
    cell_data = {"layer": [np.asarray(grid.materials)], "quality": [grid.quality()]}
    mesh = meshio.Mesh(points, [(kind, np.asarray(grid.cells))], point_data=dict(point_data or {}), cell_data=cell_data)
    mesh.write(str(path), file_format="vtu")

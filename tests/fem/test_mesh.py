"""Meshes: geometry, sizes, names, and what happens without gmsh's system libraries."""

import builtins
import signal
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from conftest import refused_by

from jkrcli.bodies.indenters import Paraboloid, RoundedFlat, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.fem.mesh import (
    SizeLaw,
    expected_triangles,
    graded_points,
    triangles,
    write_msh,
    write_vtu,
)
from jkrcli.fem.solver import FEM

SOFT, STIFF = Elastic(1.0, 0.3), Elastic(10.0, 0.2)
LAW = SizeLaw(
    reach=1.1,
    growth=0.3,
    far_growth=0.3,
    far=5.0,
    inner=0.1,
    slope=0.2,
    zones=((2.0, 0.3), (20.0, 2.0)),
    layers=((0.0, 0.5, 0.2, 50.0),),
)


def problem(length=1.0, layers=(), base=None, indenter=None, **specimen):
    base = base or HalfSpace(SOFT)
    return Problem(indenter or Paraboloid(10 * length), Specimen(layers, base, **specimen), Loading("radius", length))


def length(grid, name):
    ends = grid.points[grid.boundaries[name]]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()


def test_the_law_reads_the_same_as_text_and_as_numbers():
    names = {"Max": max, "Min": min, "Sqrt": np.sqrt}
    for r, z in [(0.0, 0.0), (0.7, -0.2), (1.5, -0.4), (30.0, -3.0)]:
        assert eval(LAW.text(), {**names, "x": r, "y": z}) == pytest.approx(float(LAW(r, z)), rel=1e-14)  # same formula


@pytest.mark.parametrize("interfaces", [[], [0.3], [0.05, 0.3]])
def test_triangles_fill_the_rectangle_and_respect_interfaces(interfaces):
    surface = graded_points(0.0, 6.0, lambda r: LAW(r, 0 * r))
    grid = triangles(surface, 4.0, interfaces, LAW.text())
    x, y = grid.points[grid.cells].transpose(2, 0, 1)
    area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1))
    assert area == pytest.approx(24.0, rel=1e-12)  # no gaps, no overlaps
    tops, ends = [0.0, *interfaces], [*interfaces, 4.0]
    for layer, (top, end) in enumerate(zip(tops, ends, strict=True)):
        z = -grid.points[grid.cells[grid.materials == layer], 1]
        assert z.min() == pytest.approx(top, abs=1e-12)
        assert z.max() == pytest.approx(end, rel=1e-12)
    for name, expected in {"surface": 6.0, "base": 6.0, "axis": 4.0, "side": 4.0}.items():
        assert length(grid, name) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(grid.surface_radii(), surface, rtol=1e-12, atol=1e-14)
    assert np.median(grid.quality()) > 0.85  # slender only in the layer that is thinner than the sizes asked for
    assert not grid.points.flags.writeable


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_scaled_surface_spacing_is_proportional_to_the_radius(element):
    r = FEM(element=element, spacing=0.1, order=1, growth=0.2).mesh(problem()).surface_radii()
    near = (r[:-1] > 0.1) & (r[1:] < 1.0)
    ratio = np.diff(r)[near] / r[:-1][near]
    assert ratio == pytest.approx(0.1, rel=0.12)  # e^0.1 - 1 = 0.105, and the rounded count


def test_the_edge_of_a_flat_end_is_a_vertex_with_small_elements_on_both_sides():
    grid = FEM().mesh(problem(indenter=RoundedFlat(0.6, 5.0)))
    r = grid.surface_radii()
    at = np.argmin(np.abs(r - 0.6))
    assert r[at] == pytest.approx(0.6, rel=1e-11)
    assert np.diff(r)[[at - 1, at]].max() < 0.002  # 0.04 * 0.05 * (1.1 - 0.6)


@pytest.mark.slow
def test_the_papers_half_space_has_about_its_number_of_quadrilaterals():
    case = Problem(Sphere(1e-4), Specimen((), HalfSpace(Elastic(5e9, 0.4))), Loading("depth", 3e-6))
    method = FEM(layout="zones", element="quadrilateral", order=1, depth=2e-3, width=1.2e-3)
    grid = method.mesh(case)
    assert len(grid.cells) == pytest.approx(413_132, rel=0.1)  # Sec. 4.1: the same sizes, another arrangement
    r = grid.surface_radii()
    assert np.diff(r[r <= 0.17e-4]) == pytest.approx(0.0005e-4, rel=0.01)
    assert grid.depth == pytest.approx(2e-3, rel=1e-12)
    assert grid.width == pytest.approx(1.2e-3, rel=1e-12)


def test_zones_on_a_thin_layer_are_the_papers_uniform_mesh():
    case = Problem(Paraboloid(1000.0), Specimen((Layer(SOFT, 1.0),), Rigid()), Loading("depth", 0.15))
    grid = FEM(layout="zones", element="quadrilateral", order=1, width=30.0).mesh(case)
    assert len(grid.cells) == pytest.approx(75_000, rel=0.2)  # Sec. 4.2; ours is coarser beside the contact
    assert np.diff(np.unique(grid.points[:, 1])) == pytest.approx(0.02, rel=1e-6)


def test_missing_system_libraries_are_one_clear_line(monkeypatch):
    real = builtins.__import__

    def broken(name, *args, **kwargs):
        if name == "gmsh":
            raise OSError("libGLU.so.1: cannot open shared object file")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", broken)
    assert refused_by(FEM().mesh, problem()) == (
        "gmsh cannot be loaded (libGLU.so.1: cannot open shared object file): install its system libraries with "
        "'apt-get install libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1', or use a method that needs "
        "no mesh (closed-form, layered) or structured quadrilaterals",
    )
    assert FEM(element="quadrilateral").mesh(problem()).element == "quadrilateral"


def test_meshing_leaves_the_interrupt_handler_alone():
    before = signal.getsignal(signal.SIGINT)
    FEM().mesh(problem())
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.fem
@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_meshes_are_written_for_gmsh_and_paraview(tmp_path, element):
    import gmsh

    grid = FEM(element=element, spacing=0.2, order=1, growth=0.3).mesh(problem(layers=(Layer(STIFF, 0.7),)))
    write_msh(grid, tmp_path / "body.msh")
    write_vtu(grid, tmp_path / "body.vtu", {"radius": grid.points[:, 0]})
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "body.msh"))
        names = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
        cells = sum(len(tags) for tags in gmsh.model.mesh.getElements(2)[1])
    finally:
        gmsh.finalize()
    assert names == {"layer-1", "layer-2", "surface", "base", "axis", "side"}
    assert cells == len(grid.cells)
    piece = ET.parse(tmp_path / "body.vtu").getroot().find(".//Piece")
    assert int(piece.attrib["NumberOfCells"]) == len(grid.cells)


def law(thicknesses: list[float], growth: float) -> SizeLaw:
    tops = np.cumsum([0.0, *thicknesses[:-1]]).tolist()
    layers = tuple((top, t, min(2 * growth, 0.5) * t, 100 * t) for top, t in zip(tops, thicknesses, strict=True))
    return SizeLaw(1.0, growth, 0.2, 5.0, inner=0.1, slope=0.2, layers=layers)


def brute_force(sizes: SizeLaw, width: float, depth: float) -> float:
    r, z = (np.concatenate([[0], np.geomspace(1e-5, end, 1500)]) for end in (width, depth))
    near = np.geomspace(1e-4, 0.5, 100)
    across = np.array([top + t * part for top, t, *_ in sizes.layers for part in (near, 1 - near)]).ravel()
    z = np.unique(np.concatenate([z, across]).clip(0, depth))
    lines = [np.trapezoid(1 / sizes(np.full_like(z, radius), -z) ** 2, z) for radius in r]
    return float(1.12 * 4 / np.sqrt(3) * np.trapezoid(lines, r))


@pytest.mark.first(1)
@pytest.mark.parametrize("thicknesses", [[1.0], [0.2] * 6, [0.02, 0.3] * 3, [0.5, 0.01, 2.0, 0.1]], ids=str)
def test_expected_triangles_are_those_of_the_law(thicknesses: list[float]) -> None:
    sizes = law(thicknesses, 0.15)
    for depth in (sum(thicknesses), 50.0):
        counted = expected_triangles(sizes, 40.0, depth)
        assert counted == pytest.approx(brute_force(sizes, 40.0, depth), rel=0.02)  # measured: 0.007


def test_sizes_on_a_grid_are_those_at_its_points() -> None:
    chance = np.random.default_rng(3)
    sizes = law((10 ** chance.uniform(-2, 0, 30)).tolist(), 0.1)
    r, z = np.sort(chance.uniform(0, 20, 40)), np.sort(chance.uniform(0, 30, 300))
    points = sizes(np.repeat(r[:, None], z.size, axis=1), np.repeat(-z[None, :], r.size, axis=0))
    assert sizes.on_grid(r, z) == pytest.approx(points, rel=1e-12)

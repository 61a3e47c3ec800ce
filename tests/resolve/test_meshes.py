"""Series on meshes of any sizes of elements: which nodes their radii are, and bands that hold."""

from pathlib import Path

import numpy as np
import pytest
from meshed_series import MESHES, MeshedSeries, drawn

from jkrcli.adhesion.slopes.nodes import as_nodes, node_radii
from jkrcli.base.errors import InputError, Unknown
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import RawSeries


def judged(series: MeshedSeries, folder: Path) -> dict[str, tuple[float, float]]:
    """Relative error of the pull-off force and its stated half-width, by control; NaN where there is none."""
    solution = read_series(series.write(folder), series.body.problem, SeriesReading(compare=series.known))
    result, found = analyse(solution, [series.w])[0], {}
    for control in ("load", "displacement"):
        point, half, true = result.pull_off[control], result.pull_off_errors.get(control), series.true(control)[2]
        told = not (half is None or isinstance(half, Unknown) or isinstance(point, Unknown))
        found[control] = (point.P / true - 1, half["P"] / abs(true)) if told else (np.nan, np.nan)
    return found


@pytest.mark.parametrize("kind", MESHES)
def test_elements_of_any_mesh_are_told_by_the_radii(kind: str) -> None:
    right = []
    for series in drawn(2, 3, (kind,)):
        nodes = node_radii(RawSeries(*series.columns))
        number = np.searchsorted(series.nodes, nodes.rows.a * (1 - 1e-9))
        element = np.diff(series.nodes)[number]
        right.append(np.abs(nodes.element / element - 1) < 0.1)
    assert np.mean(np.concatenate(right)) > 0.9


@pytest.mark.parametrize(("scatter", "power"), [(1e-4, 0.5), (1e-3, 1.0)])
def test_radii_that_scatter_are_none_of_nodes(scatter: float, power: float) -> None:
    """Counts of up to 16 fit any radii to a tenth of an element."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        rows = int(rng.integers(20, 100))
        a = (np.arange(1, rows + 1) / rows) ** power
        read = np.sort(a * (1 + scatter * rng.standard_normal(rows)))
        assert node_radii(RawSeries(read, a**2, a**3)) is None


def test_smooth_radii_are_none_of_nodes() -> None:
    for a in (np.linspace(0.02, 1, 50), np.geomspace(0.02, 1, 50), np.sqrt(np.linspace(0.02, 1, 50))):
        raw = RawSeries(a, a**2, a**3)
        assert as_nodes(raw) is not None
        assert node_radii(raw) is None


def test_what_integral_errs_by_is_in_the_error_of_a_rule_that_is_judged_by_it(tmp_path: Path) -> None:
    series = list(drawn(5, 21, ("even",)))[4]
    solution = read_series(series.write(tmp_path), series.body.problem, SeriesReading(compare=series.known))
    found, errors = [], []
    for rule in ("loocv", "integral"):
        result = analyse(solution, [series.w], rule)[0]
        point, half = result.pull_off["displacement"], result.pull_off_errors["displacement"]
        found.append(point.P)
        errors.append(half["P"])
    assert errors[0] >= abs(found[0] - found[1]) + errors[1]


def zones(ahead: float, sizes: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Radii of nodes [m] in two zones, and the rows (3, n) of Hertz with R = 1 mm, E* = 1 MPa at 100 even depths."""
    nodes = 1e-6 * np.concatenate([sizes[0] * np.arange(1, 31), 30 * sizes[0] + sizes[1] * np.arange(1, 50)])
    edges = nodes[:-1] + ahead * np.diff(nodes)
    delta, P = edges**2 / 1e-3, 4 / 3 * 1e6 * edges**3 / 1e-3
    depths = 40e-6 * np.arange(1, 101) / 100
    touched = np.searchsorted(delta, depths, side="right")
    loads = np.interp(depths, np.append(0, delta), np.append(0, P))
    return nodes, np.stack([np.append(0, nodes)[touched], depths, loads])[:, touched > 0]


HALF_SPACE = Problem(
    Paraboloid(1e-3), Specimen((), HalfSpace(Elastic(0.75e6, 0.5))), Loading("depth", 1e-6, 10)
)  # E* = 1 MPa


@pytest.mark.parametrize("sizes", [(2.0, 14 / 3), (3.0, 4.5)])
def test_two_zones_are_no_mesh_of_their_common_divisor(sizes: tuple[float, float], tmp_path: Path) -> None:
    _, rows = zones(0.3, sizes)
    np.savetxt(tmp_path / "t.csv", rows.T, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.9g")
    solution = read_series(tmp_path / "t.csv", HALF_SPACE, SeriesReading())
    assert solution.warnings == ()
    w = 8e6 * 50e-6**3 / (9 * np.pi * 1e-6)  # lost at 50 um
    point = analyse(solution, [w])[0].pull_off["load"]
    half = analyse(solution, [w])[0].pull_off_errors["load"]
    true = 1.5 * np.pi * w * 1e-3
    assert abs(point.P + true) < half["P"] < 0.012 * true
    assert "2 um to 4.667 um" in solution.facts["radii"] or sizes != (2.0, 14 / 3)


def test_nodes_may_be_given(tmp_path: Path) -> None:
    nodes, rows = zones(0.2, (2.0, 14 / 3))
    np.savetxt(tmp_path / "t.csv", rows[:, 2::7].T, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.9g")
    file = tmp_path / "nodes.txt"
    file.write_text("r (um)\n0\n" + "\n".join(f"{1e6 * r:.6g}" for r in nodes))
    solution = read_series(tmp_path / "t.csv", HALF_SPACE, SeriesReading(nodes=file))
    assert solution.raw.element is not None
    np.testing.assert_allclose(
        solution.raw.element, np.diff(nodes)[np.searchsorted(nodes, solution.raw.a - 1e-9)], 1e-3
    )
    assert solution.facts["nodes"] == "nodes.txt"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("r_um\n" + "\n".join(str(1.37 * k) for k in range(200)), r"line 5: contact radius .* is that of no node"),
        ("\n".join(str(2e-6 * k) for k in range(99)), r"names no unit: give --unit a=um"),
        ("r_um,z_um\n" + "\n".join(f"{k},0" for k in range(9)), r"must hold one column, radii of nodes, got 2"),
        ("r_um\n1\n2\n3", r"at least 5 radii of nodes, none below 0, got 3 different ones"),
        ("r_um\n-1\n1\n2\n3\n4\n5", r"none below 0, got -1e-06 m"),
        ("r_um\n1\n2\nthree\n4\n5\n6", r"line 4 must hold 1 numbers"),
    ],
)
def test_nodes_that_are_none_are_refused(text: str, message: str, tmp_path: Path) -> None:
    _, rows = zones(0.2, (2.0, 14 / 3))
    np.savetxt(tmp_path / "t.csv", rows.T, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.9g")
    file = tmp_path / "nodes.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_series(tmp_path / "t.csv", HALF_SPACE, SeriesReading(nodes=file))


@pytest.mark.parametrize("each", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_a_part_of_the_study_of_meshes(each: int, tmp_path: Path) -> None:
    found = [judged(series, tmp_path) for series in drawn(each, 2)]
    errors = np.array([each[control] for each in found for control in ("load", "displacement")])
    assert np.isfinite(errors).all()
    assert np.mean(np.abs(errors[:, 0]) <= errors[:, 1]) >= 0.87
    if each > 1:
        assert np.median(errors[:, 1] / np.abs(errors[:, 0])) <= 6

"""Mesh convergence and the paper's figures: observed orders, what is written, what is refused."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base.errors import InputError, Unknown
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.fem.solver import FEM
from jkrcli.many.studies import coarser, converge, edge_size, richardson

MATERIAL = Elastic(1.0, 0.3)
HERTZ = Problem(Paraboloid(100.0), Specimen((), HalfSpace(MATERIAL)), Loading("radius", 1.0, 40))
W = 1e-5  # pull-off at a = 0.68


@settings(deadline=None)
@given(order=st.floats(0.5, 4.0), limit=st.floats(-10, 10), factor=st.sampled_from([-1.0, 0.3, 2.0]))
def test_richardson_finds_order_and_limit_of_a_power(order: float, limit: float, factor: float) -> None:
    values = [limit + factor * h**order for h in (1.0, 0.5, 0.25, 0.125)]
    found = richardson(values)
    assert found[0] == pytest.approx(order, abs=1e-9)  # rounding of 10 against differences above 1e-4 of it
    assert found[1] == pytest.approx(limit, abs=1e-9)


@pytest.mark.parametrize("values", [[1.0, 2.0], [1.0, None, 2.0], [1.0, 2.0, 3.0], [1.0, 2.0, 1.5], [1.0, 1.0, 1.0]])
def test_no_order_without_a_reason(values: list[float | None]) -> None:
    few = len(values) < 3 or None in values
    reason = "needs three meshes with a value" if few else "the differences do not shrink from mesh to mesh"
    assert richardson(values) == Unknown(reason)


@pytest.mark.slow
def test_hertz_converges_with_node_based_radii() -> None:
    """First order in the radius (a node's), better than second in the load at equal depth (measured: 1.0 and 2.4)."""
    found = converge(HERTZ, FEM(edge_correction=False), W, 4)
    sizes = np.array([level.size for level in found.levels])
    np.testing.assert_allclose(sizes[:-1] / sizes[1:], 2, rtol=0.1)  # vertices are fitted between fixed points
    assert [level.kept for level in found.levels] == sorted(level.kept for level in found.levels)
    assert found.order("a") == pytest.approx(1, abs=0.3)
    assert found.order("P") > 1.7
    a, P, force = (found.errors(quantity)[-1] for quantity in ("a", "P", "pull_off"))
    assert abs(a) < 1e-2  # a fraction of the spacing of 0.04 a
    assert abs(P) < 5e-4
    assert abs(force) < 1e-2
    assert found.exact.P == pytest.approx(4 / 3 * MATERIAL.E_star * 10 * found.depth**1.5, rel=1e-6)  # Hertz


def test_too_coarse_a_mesh_has_a_reason_for_its_missing_pull_off() -> None:
    problem = Problem(HERTZ.indenter, HERTZ.specimen, Loading("radius", 1.0, 4, "radius"))
    method = FEM(contact="incremental", spacing=0.2, edge_correction=False)
    found = converge(problem, method, W, 2)
    assert isinstance(found.levels[0].state.point, Unknown)
    assert found.levels[0].state.curve is found.levels[0].state.point
    assert found.values("pull_off")[0] is None
    assert found.errors("pull_off")[0] is None
    assert "needs at least" in found.levels[0].state.point.reason


def test_coarser_doubles_every_element_and_knows_its_limit() -> None:
    zones = FEM(layout="zones", element_size=0.02)
    twice = coarser(zones, HERTZ, 2)
    assert (twice.element_size, twice.zone_sizes) == (0.04, (0.04, 0.1, 1.0))
    assert edge_size(twice, HERTZ, 1.0) == pytest.approx(0.04, rel=0.05)
    assert coarser(FEM(), HERTZ, 2).spacing == 0.08
    with pytest.raises(
        InputError, match=r"coarsest mesh would have mesh.spacing = 0.64, at most 0.49 is possible: take"
    ):
        coarser(FEM(), HERTZ, 16)


CASE = """
indenter = { shape = "sphere", radius = "100 um" }
specimen.half_space = { E = "5 MPa", nu = 0.4 }
loading = { depth = "3 um", points = 30 }
adhesion.w = 0.05
mesh = { element_size = "1 um", layout = "zones", growth = 0.4 }
"""


@pytest.fixture(name="cases")
def _cases(tmp_path: Path) -> Path:
    (folder := tmp_path / "cases").mkdir()
    (folder / "halfspace.toml").write_text(CASE)
    return folder


def test_study_converge_writes_table_and_summary(jkr, cases: Path, tmp_path: Path) -> None:
    outcome = jkr("study", "converge", cases / "halfspace.toml", "--levels", 2, "-o", "out", "--no-plots", "--json").ok
    assert outcome.err == ""
    assert sorted(path.suffix for path in (tmp_path / "out").iterdir()) == [".csv", ".json"]
    rows = list(csv.DictReader((tmp_path / "out" / "halfspace-convergence.csv").read_text().splitlines()))
    data = json.loads((tmp_path / "out" / "halfspace-convergence.json").read_text())
    assert [float(row["P_N"]) for row in rows] == [level["P_N"] for level in data["levels"]]
    assert [int(row["points_kept"]) for row in rows] == [level["points"]["kept"] for level in data["levels"]]
    assert data["depth_m"] == pytest.approx(3e-6, rel=0.2)
    assert set(data["exact"]) == set(data["extrapolated"]) == {"contact radius", "load", "pull-off force"}
    assert json.loads(outcome.out) == data


@pytest.mark.slow
def test_the_paper_by_its_own_method(study, tmp_path: Path) -> None:
    """Pull-off of Secs. 4.1 to 4.3 by the paper's splines on its meshes, against the exact solution."""
    outcome = study("paper", "--cases", Path(__file__).parents[2] / "cases" / "paper", "-o", "paper").ok
    drawn = {path.name for path in (tmp_path / "paper").iterdir()}
    assert drawn == {"paper.csv", *(f"fig{n}.{end}" for n in (5, 7, 8, 10) for end in ("png", "svg"))}
    rows = list(csv.DictReader((tmp_path / "paper" / "paper.csv").read_text().splitlines()))
    worst = dict[tuple[str, str], float]()
    for row in rows:
        key = row["case"], row["rule"]
        worst[key] = max(worst.get(key, 0.0), abs(float(row["error"])))
    for rule in ("loocv-kept", "loocv", "gcv"):
        assert worst["half-space", rule] < 0.02  # measured: 1.2e-2, 1.6e-3, 1.0e-3
        assert worst["thin-layer", rule] < 0.01  # measured: 1.2e-3
        assert worst["gel", rule] < 0.03  # measured: 1.9e-2
        assert worst["gel, CAX4R", rule] < 0.05  # measured: 3.4e-2
    assert "639" in outcome.out
    assert "471" in outcome.out


def test_wrong_input_to_the_studies(jkr, study, cases: Path, tmp_path: Path) -> None:
    half = cases / "halfspace.toml"
    (cases / "dry.toml").write_text(half.read_text().replace("adhesion.w = 0.05\n", ""))
    (tmp_path / "points.csv").write_text("displacement, load (uN)\n-5,-0.6\n0,-0.5\n")
    jkr("study", "converge", "cases/dry.toml").refused("cases/dry.toml: names no work of adhesion > 0: give --w")
    jkr("study", "converge", "cases/halfspac.toml").refused('did you mean "cases/halfspace.toml"?')
    study("paper", "--cases", "nowhere").refused("nowhere/half-space.toml: case file not found")
    study("paper", "--measured", "points.csv").refused("points.csv: column 1", "names no unit: give --unit delta=um")

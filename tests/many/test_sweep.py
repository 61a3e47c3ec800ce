"""Sweeps: which cases a file makes, and what is told of each."""

import json
import math
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet
import pytest
from conftest import CASES
from hypothesis import given, settings
from hypothesis import strategies as st
from sweep_files import AXIS, BAD, HALF_SPACE, TWO_LAYERS, R, axis, plan_of, rows

from jkrcli.base.errors import InputError
from jkrcli.formulas import jkr as jkr_curve
from jkrcli.many.sweep import alone
from jkrcli.many.sweep_file import Distribution, draw
from jkrcli.many.sweep_plan import NAMES, RATIOS, load_plan, names_of, with_values

pytestmark = pytest.mark.usefixtures("no_pictures")


def test_axes_are_combined_the_last_running_fastest(tmp_path: Path) -> None:
    zipped = '[[axes]]\nzip = { "indenter.radius" = ["1 mm", "2 mm"], "loading.radius" = ["0.1 mm", "0.2 mm"] }\n'
    moduli = axis("specimen.half_space.E", 'from = "1 kPa"\nto = "1 MPa"\ncount = 4\nspacing = "log"\n')
    points = axis("loading.points", "from = 10\nto = 30\ncount = 3\n")
    plan = plan_of(tmp_path, HALF_SPACE + zipped + moduli + points)
    assert plan.count == 24
    assert plan.key_columns == ("indenter.radius_m", "loading.radius_m", "specimen.half_space.E_Pa", "loading.points")
    assert list(plan.values(0).values()) == [1e-3, 1e-4, 1e3, 10]
    assert list(plan.values(1).values()) == [1e-3, 1e-4, 1e3, 20]
    np.testing.assert_allclose(plan.values(3)["specimen.half_space.E"], 1e4, rtol=1e-12)  # geomspace rounds
    assert list(plan.values(23).values()) == [2e-3, 2e-4, 1e6, 30]
    assert len({json.dumps(plan.values(i)) for i in range(24)}) == 24


def test_the_table_holds_the_classical_formulae(jkr, tmp_path: Path) -> None:
    """1.5 and 5/6 pi w R whatever the moduli; delta and P of Eq. 7 at a radius between the points."""
    (tmp_path / "s.toml").write_text(
        HALF_SPACE.replace('w = "50 mJ/m^2"', "w = [0.03, 0.05]").replace('"0.1 mm"', '"0.2 mm"')
        + AXIS
        + '[outputs]\nquantities = ["pull_off", "contact"]\nradii = "0.123 mm"\n'
    )
    outcome = jkr("sweep", "s.toml", "-o", "r").ok
    assert outcome.err == "jkr: 6 cases to compute by 3 solves\n"
    table = rows(tmp_path / "r" / "table.csv")
    assert [row["case"] for row in table] == list("012345")
    for row in table:
        w, nu = float(row["adhesion.w_J_per_m2"]), float(row["specimen.half_space.nu"])
        E_star = 1e6 / (1 - nu**2)
        assert (row["status"], row["reason"]) == ("ok", "")
        np.testing.assert_allclose(float(row["contact.E_star_Pa"]), E_star, rtol=1e-14)
        np.testing.assert_allclose(float(row["pull_off.load.P_N"]), -1.5 * np.pi * w * R, rtol=1e-6)
        np.testing.assert_allclose(float(row["pull_off.load.over_pi_w_R"]), 1.5, rtol=1e-6)
        np.testing.assert_allclose(float(row["pull_off.displacement.P_N"]), -5 / 6 * np.pi * w * R, rtol=1e-6)
        delta, P = jkr_curve(np.array(0.123e-3), E_star, R, w)
        at = {"delta_m": delta, "P_N": P, "S_N_per_m": 2 * E_star * 0.123e-3, "dS_da_N_per_m2": 2 * E_star,
              "P_H_N": 4 * E_star * 0.123e-3**3 / 3 / R}  # fmt: skip
        assert {name: float(row[f"at_0.000123_m.{name}"]) for name in at} == pytest.approx(at, rel=1e-9)


def test_contact_goes_to_the_rim_of_each_punch_of_a_sweep(jkr, tmp_path: Path) -> None:
    """Flat, with a sharp edge: sqrt(8 pi w E* R^3) (Kendall 1971) whatever the device."""
    text = HALF_SPACE.replace('"paraboloid"', '"flat"').replace('radius = "0.1 mm"', 'radius = "1 mm"')
    radii = (0.5e-3, 1e-3, 2e-3)
    (tmp_path / "s.toml").write_text(text + axis("indenter.radius", f"values = {[*radii]}"))
    assert jkr("sweep", "s.toml", "-o", "r").code == 0
    for row, punch in zip(rows(tmp_path / "r" / "table.csv"), radii, strict=True):
        for name in ("load", "displacement"):
            assert float(row[f"pull_off.{name}.a_m"]) == punch
            kendall = math.sqrt(8 * math.pi * 0.05 * 1e6 / 0.91 * punch**3)
            assert float(row[f"pull_off.{name}.P_N"]) == pytest.approx(-kendall, rel=1e-9)


@pytest.mark.slow
def test_hdf5_and_parquet_hold_the_same_table(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + BAD)
    jkr("sweep", "s.toml", "-o", "r")
    table = rows(tmp_path / "r" / "table.csv")
    with h5py.File(tmp_path / "r" / "table.h5") as file:
        assert file.attrs["format"] == b"jkr-sweep-table"
        group = file["table"]
        assert list(group) == list(table[0])
        numbers = group["pull_off.load.P_N"][()]
        assert group["status"].asstr()[()].tolist() == [row["status"] for row in table]
    expected = [float(row["pull_off.load.P_N"]) if row["pull_off.load.P_N"] else np.nan for row in table]
    np.testing.assert_array_equal(numbers, expected)
    parquet = pyarrow.parquet.read_table(tmp_path / "r" / "table.parquet")
    assert parquet.column_names == list(table[0])
    assert parquet["pull_off.load.P_N"].to_pylist() == [None if np.isnan(x) else x for x in expected]


def test_a_layer_by_its_name_is_answered_with_its_index() -> None:
    with pytest.raises(
        InputError, match=r'has no "film": specimen.layers is a list, its entries are specimen.layers\[0\]'
    ):
        with_values({"specimen": {"layers": [{"name": "film", "nu": 0.3}]}}, {"specimen.layers.film.nu": 0.1})


@pytest.mark.parametrize("path", sorted((CASES / "sweeps").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_sweeps_load_and_their_first_case_is_solved(jkr, path: Path) -> None:
    row = jkr("sweep", path, "--only", "0", "--json").told
    assert row["status"] == "ok"
    assert row["pull_off.load.P_N"] < 0


def test_layers_are_counted_after_their_values_are_set(tmp_path: Path) -> None:
    counts = axis("specimen.layers.count", "values = [1, 2]") + axis("specimen.layers[1].E", "values = [5]")
    plan = plan_of(tmp_path, TWO_LAYERS + counts)
    assert [len(plan.case(i).model.specimen.layers) for i in range(2)] == [1, 2]
    assert plan.case(1).model.specimen.layers[1].E == 5


def test_profiles_in_files_travel_with_the_sweep(tmp_path: Path) -> None:
    """A worker on another machine has no such file: its points stand in the recipe."""
    (tmp_path / "profile.csv").write_text("r_m,f_m\n0,0\n1e-4,5e-6\n2e-4,2e-5\n")
    text = HALF_SPACE.replace('shape = "paraboloid", radius = "1 mm"', 'shape = "table", file = "profile.csv"')
    plan = plan_of(tmp_path, text + AXIS)
    (tmp_path / "profile.csv").unlink()
    assert plan.case(2).model.indenter.r == (0.0, 1e-4, 2e-4)


def test_groups_of_quantities_are_taken_apart() -> None:
    of_load = [f"pull_off.load.{name}" for name in ("P_N", "delta_m", "a_m", "over_pi_w_R")]
    assert names_of(["pull_off.load", "errors.total", "pull_off.load.P_N"], "s") == (*of_load, "errors.total")


@pytest.mark.parametrize(
    ("wanted", "controls"), [("pull_off", ["load", "displacement"]), ("pull_off.load.P_N", ["load"])]
)
def test_pull_off_has_its_errors_beside_it(tmp_path: Path, wanted: str, controls: list[str]) -> None:
    """As if they were asked for."""
    names = [f"pull_off_errors.{control}.{key}" for control in controls for key in ("P_err_N", "delta_err_m")]
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS + f'[outputs]\nquantities = ["{wanted}"]\n')
    (tmp_path / "t.toml").write_text(HALF_SPACE + AXIS + f'[outputs]\nquantities = ["{wanted}", "pull_off_errors"]\n')
    one, other = (load_plan(tmp_path / f"{name}.toml") for name in "st")
    columns = one.recipe.wanted.columns
    assert [name for name in columns if name.startswith("pull_off_errors.")] == names
    row, asked = alone(one, 0).summary(), alone(other, 0).summary()
    assert all(row[name] == asked[name] > 0 for name in names)


def test_every_quantity_is_told_or_its_absence_explained(jkr, tmp_path: Path) -> None:
    groups = dict.fromkeys(name.split(".")[0] for name in NAMES)
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS + f"[outputs]\nquantities = {list(groups)}\n")
    row = jkr("sweep", "s.toml", "--only", "1", "--json").told
    absent = {name for name in NAMES if row[name] is None}
    of_layers = {f"ratios.{name}" for name in RATIOS}  # a half-space has none
    assert absent == {"validity.delta_over_h", "validity.a_over_h", "validity.a_over_L", *of_layers}
    assert row["solved_by.method"] == "closed-form"
    assert abs(row["comparison.pull_off"]) < 1e-6
    assert row["stability.energy_lost_J"] > row["stability.work_of_separation_J"] * 0.1 > 0


@pytest.mark.parametrize(
    ("key", "values", "column"),
    [
        ("specimen.surface_tension", '["10 mN/m", "30 mN/m"]', "specimen.surface_tension_N_per_m"),
        ("specimen.surface", '["sliding", "sticking"]', "specimen.surface"),
    ],
)
def test_each_tension_and_surface_is_solved(jkr, tmp_path: Path, key: str, values: str, column: str) -> None:
    base = """[base]
indenter = { shape = "paraboloid", radius = "5 um" }
specimen = { half_space = { E = "5 kPa", nu = 0.3 } }
loading = { radius = "1 um", points = 10 }
"""
    (tmp_path / "s.toml").write_text(base + axis(key, f"values = {values}") + '[outputs]\nquantities = ["end"]\n')
    done = jkr("sweep", "s.toml", "--workers", 1)
    assert (done.code, "2 cases to compute by 2 solves" in done.err) == (0, True), done.err
    one, other = rows(tmp_path / "s-results" / "table.csv")
    assert column in one
    assert [name for name in one if name.startswith("end.") and one[name] != other[name]]


@settings(deadline=None)
@given(st.integers(0, 2**20), st.sampled_from(["random", "sobol", "latin-hypercube"]))
def test_draws_keep_their_limits(seed: int, method: str) -> None:
    items = [
        Distribution("uniform", {"from": -1.0, "to": 2.0}),
        Distribution("loguniform", {"from": 1e-3, "to": 1e3}),
        Distribution("normal", {"mean": 1.0, "sd": 0.5, "least": 0.9}),
        Distribution("lognormal", {"median": 2.0, "factor": 1.5, "most": 2.5}),
        Distribution("integer", {"from": 1, "to": 3}),
        Distribution("choice", {"values": ("a", "b")}),
    ]
    drawn = draw(items, 33, method, seed)
    assert drawn == draw(items, 33, method, seed)
    for uniform, log, normal, lognormal, integer, choice in drawn:
        assert -1 <= uniform <= 2
        assert 1e-3 * (1 - 1e-12) <= log <= 1e3 * (1 + 1e-12)
        assert normal >= 0.9
        assert 0 < lognormal <= 2.5
        assert integer in (1, 2, 3)
        assert choice in ("a", "b")


def test_draws_follow_their_distributions() -> None:
    """4096 Sobol points integrate smooth functions to about 1e-3: mean and sd of the normal, median of the lognormal,
    equal shares of three whole numbers."""
    items = [
        Distribution("normal", {"mean": 3.0, "sd": 0.2}),
        Distribution("lognormal", {"median": 2.0, "factor": 1.5}),
        Distribution("integer", {"from": 1, "to": 3}),
    ]
    normal, lognormal, integer = (np.array(values) for values in zip(*draw(items, 4096, "sobol", 0), strict=True))
    assert normal.mean() == pytest.approx(3.0, abs=1e-3)
    assert normal.std() == pytest.approx(0.2, rel=5e-3)
    assert np.median(lognormal) == pytest.approx(2.0, rel=2e-3)
    assert np.log(lognormal).std() == pytest.approx(np.log(1.5), rel=5e-3)
    assert [np.mean(integer == n) for n in (1, 2, 3)] == pytest.approx([1 / 3] * 3, abs=1e-3)

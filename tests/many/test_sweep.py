"""Sweeps: which cases a file makes, what is shared, what is told of each, what is refused."""

from __future__ import annotations

import csv
import json
import os
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet
import pytest
from conftest import CASES
from hypothesis import given
from hypothesis import strategies as st

from jkrcli.base.errors import InputError, JkrError
from jkrcli.case import store
from jkrcli.formulas.half_space import jkr as jkr_curve
from jkrcli.many import cache
from jkrcli.many.sweep import solving
from jkrcli.many.sweep.draws import Distribution, draw
from jkrcli.many.sweep.paths import with_values
from jkrcli.many.sweep.plan import load_plan
from jkrcli.many.sweep.quantities import NAMES, names_of
from jkrcli.methods.closed_form.method import ClosedForm
from jkrcli.methods.layered.layered import Layered

HALF_SPACE = """
[base]
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm" }
adhesion = { w = "50 mJ/m^2" }
"""
TWO_LAYERS = """
[base]
method = "layered"
indenter = { shape = "sphere", radius = "1 mm" }
specimen.layers = [{ E = "1 MPa", nu = 0.3, thickness = "0.1 mm" }, { E = "2 MPa", nu = 0.4, thickness = "0.2 mm" }]
loading = { radius = "0.1 mm", points = 20 }
adhesion = { w = "50 mJ/m^2" }
"""
AXIS = '[[axes]]\nkey = "specimen.half_space.nu"\nvalues = [0.1, 0.3, 0.5]\n'
R = 1e-3


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are drawn in test_sweep_figure.py: each takes longer than the sweeps here."""
    monkeypatch.setattr("jkrcli.cli.sweep._draw", lambda *_: False)


def axis(key: str, rest: str) -> str:
    """An axis of a sweep file."""
    return f'[[axes]]\nkey = "{key}"\n{rest}\n'


def samples(distribution: str, key: str = "adhesion.w") -> str:
    """Three draws of one key."""
    return f'[samples]\ncount = 3\n[samples.of]\n"{key}" = {{ {distribution} }}\n'


def plan_of(tmp_path: Path, text: str):
    path = tmp_path / "s.toml"
    path.write_text(text)
    return load_plan(path)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_axes_are_combined_the_last_running_fastest(tmp_path: Path) -> None:
    plan = plan_of(
        tmp_path,
        HALF_SPACE
        + """
[[axes]]
zip = { "indenter.radius" = ["1 mm", "2 mm"], "loading.radius" = ["0.1 mm", "0.2 mm"] }
[[axes]]
key = "specimen.half_space.E"
from = "1 kPa"
to = "1 MPa"
count = 4
spacing = "log"
[[axes]]
key = "loading.points"
from = 10
to = 30
count = 3
""",
    )
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
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert outcome.code == 0
    assert outcome.err == "jkr: 6 cases to do with 3 solves\n"
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
        np.testing.assert_allclose(float(row["at_0.000123_m.delta_m"]), delta, rtol=1e-9)
        np.testing.assert_allclose(float(row["at_0.000123_m.P_N"]), P, rtol=1e-9)
        np.testing.assert_allclose(float(row["at_0.000123_m.S_N_per_m"]), 2 * E_star * 0.123e-3, rtol=1e-9)
        np.testing.assert_allclose(float(row["at_0.000123_m.dS_da_N_per_m2"]), 2 * E_star, rtol=1e-9)
        np.testing.assert_allclose(float(row["at_0.000123_m.P_H_N"]), 4 * E_star * 0.123e-3**3 / 3 / R, rtol=1e-9)


@pytest.fixture(name="solves")
def _solves(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The problems that are really solved, in order."""
    seen: list[object] = []

    def counted(plain: Callable) -> Callable:
        return lambda method, body: seen.append(body.key) or plain(method, body)

    for kind in (ClosedForm, Layered):
        monkeypatch.setattr(kind, "__call__", counted(kind.__call__))
    return seen


SHARED = """
[[axes]]
key = "adhesion.w"
values = [0.01, 0.02, 0.05]
[[axes]]
zip = { "specimen.layers[0].E" = ["1 MPa", "3 MPa", "0.7 MPa"], "specimen.layers[1].E" = ["2 MPa", "6 MPa", "1.4 MPa"] }
[[axes]]
key = "specimen.layers[0].thickness"
values = ["0.1 mm", "0.2 mm"]
"""


@pytest.mark.slow
def test_cases_that_differ_in_w_or_one_modulus_factor_share_a_solve(jkr, tmp_path: Path, solves: list) -> None:
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    assert (outcome.code, len(solves)) == (0, 2)
    table = rows(tmp_path / "r" / "table.csv")
    assert len(table) == 18
    for row in table[3:9:4]:  # against each case solved alone, by the ordinary verbs
        (tmp_path / "one.toml").write_text(jkr("sweep", "s.toml", "--show-case", row["case"]).out)
        assert jkr("run", "one.toml").code == 0
        alone = json.loads(jkr("transform", "one.h5", "--no-plots", "--json").out)["results"][0]
        told = alone["pull_off"]["load"]
        for quantity, unit in (("P", "N"), ("delta", "m")):  # a sweep interpolates to the points, and says its error
            off = abs(float(row[f"pull_off.load.{quantity}_{unit}"]) - told[f"{quantity}_{unit}"])
            stated = float(row[f"pull_off_errors.load.{quantity}_err_{unit}"])
            assert off <= stated < 1e-3 * abs(told[f"{quantity}_{unit}"])
        np.testing.assert_allclose(float(row["validity.tabor"]), alone["tabor"], rtol=1e-12)


@pytest.mark.slow
def test_a_row_depends_on_its_case_alone(jkr, tmp_path: Path) -> None:
    """To the last bit: in company, alone, by two processes, in another order of axes."""
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    first, second, third = SHARED.split("[[axes]]")[1:]
    (tmp_path / "t.toml").write_text(TWO_LAYERS + "".join(f"[[axes]]{axis}" for axis in (third, second, first)))
    for name, workers in (("s", 2), ("t", 1)):
        assert jkr("sweep", f"{name}.toml", "-o", name, "--workers", workers).code == 0
    table, other = (rows(tmp_path / name / "table.csv") for name in "st")
    shuffled = sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in other)
    assert sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in table) == shuffled
    alone = json.loads(jkr("sweep", "s.toml", "--only", "7", "--json").out)
    assert {k: "" if v is None else str(v) for k, v in alone.items()} == table[7]


def test_a_solve_that_cannot_be_kept_is_no_failed_case(
    jkr, tmp_path: Path, tuned: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk is told by the journal and the table, not by cases that count as done from then on."""

    def full(path: Path, *_: object) -> None:
        raise JkrError(f"{path}: cannot be written (No space left on device)")

    tuned("jkrcli.many.cache.TUNING.worth_keeping", 0.0)
    monkeypatch.setattr("jkrcli.case.store.write", full)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED.partition("[[axes]]\nzip")[0])
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok"] * 3


def test_unit_modulus_is_the_same_for_every_factor() -> None:
    """1/3 of 3 and 0.7 of 1.4: quotients are rounded alike, and the factor is the surface's E."""
    from jkrcli.bodies.indenters import Sphere
    from jkrcli.bodies.materials import Elastic
    from jkrcli.bodies.problem import HalfSpace, Layer, Loading, Problem, Specimen

    def body(factor: float) -> Problem:
        layers = (Layer(Elastic(1.1 * factor, 0.3), 1e-4),)
        base = HalfSpace(Elastic(0.7 * factor, 0.2))
        return Problem(Sphere(1e-3, Elastic(13 * factor, 0.3)), Specimen(layers, base), Loading("load", 1e-9 * factor))

    bodies = [cache.at_unit_modulus(body(factor)) for factor in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]
    assert len({problem.key for problem, _ in bodies}) == 1
    assert [factor for _, factor in bodies] == [1.1 * f for f in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]


BAD = """
[samples]
count = 40
seed = 3
method = "random"
[samples.of]
"specimen.half_space.nu" = { distribution = "normal", mean = 0.45, sd = 0.05 }
"""


def test_one_bad_case_never_stops_the_rest(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + BAD)
    outcome = jkr("sweep", "s.toml", "-o", "r")
    table = rows(tmp_path / "r" / "table.csv")
    beyond = [row for row in table if float(row["specimen.half_space.nu"]) > 0.5]
    assert outcome.code == 0
    assert 0 < len(beyond) < 40
    assert [row for row in table if row["status"] == "failed"] == beyond
    nu = beyond[0]["specimen.half_space.nu"]
    reason = f"specimen.half_space.nu: must be > -1 and <= 0.5, got {nu}"
    assert beyond[0]["reason"] == reason
    assert beyond[0]["pull_off.load.P_N"] == ""
    assert outcome.err.splitlines()[-1] == (f"jkr: warning: {len(beyond)} cases failed, the first because: {reason}")
    failed = rows(tmp_path / "r" / "failed.csv")
    assert [row["case"] for row in failed] == [row["case"] for row in beyond]
    again = jkr(*shlex.split(failed[0]["command"])[1:], "--json")
    assert json.loads(again.out)["reason"] == reason


def test_a_fault_in_a_library_is_a_reason_too(jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = solving.solved

    def faulty(body, method, kept):
        if body.specimen.surface.nu == 0.3:
            raise ZeroDivisionError("by zero")
        return plain(body, method, kept)

    monkeypatch.setattr(solving, "solved", faulty)
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    table = rows(tmp_path / "r" / "table.csv")
    assert [row["status"] for row in table] == ["ok", "failed", "ok"]
    assert table[1]["reason"] == "unexpected ZeroDivisionError: by zero"
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")  # what failed is not tried again unasked
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok", "failed", "ok"]
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1", "--retry-failed")
    assert "1 failed cases are tried again\njkr: 2 of 3 cases are there from an earlier run" in outcome.err
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok", "ok", "ok"]
    assert not (tmp_path / "r" / "failed.csv").exists()


def test_every_case_failed_is_an_error(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(
        TWO_LAYERS.replace('"layered"', '"closed-form"') + '[[axes]]\nkey = "adhesion.w"\nvalues = [1]\n'
    )
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert outcome.code == 1
    assert outcome.err.splitlines()[-1].startswith(
        "jkr: error: s.toml: every case failed, the first because: method cl"
    )


@pytest.mark.slow
def test_restart_goes_on_where_it_was_cut(jkr, tmp_path: Path, solves: list) -> None:
    """The journal cut anywhere, in the middle of a line too: only what is missing is solved, the table is the same."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + BAD)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    journal, table = tmp_path / "r" / "journal.jsonl", tmp_path / "r" / "table.csv"
    whole, wanted = journal.read_bytes(), table.read_bytes()
    lines = whole.splitlines(keepends=True)
    for size in (0, len(lines[0]), len(lines[0]) + 7, sum(map(len, lines[:20])), len(whole) - 1, len(whole)):
        journal.write_bytes(whole[:size])
        table.unlink()
        kept = whole[:size].count(b"\n")
        kept_ok = sum(line.split(b'"')[3] == b"ok" for line in lines[1:kept])
        solves.clear()
        assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
        assert len(solves) == sum(b'"ok"' in line for line in lines) - kept_ok
        assert table.read_bytes() == wanted
        assert len({_identity(line) for line in journal.read_bytes().splitlines()[1:]}) == len(lines) - 1


def _identity(line: bytes) -> str:
    return json.loads(line)[0]


def test_a_longer_sweep_solves_what_is_new(jkr, tmp_path: Path, solves: list) -> None:
    """Another value on an axis, more Sobol points: the cases that were there stay."""
    sobol = samples('distribution = "uniform", from = 0, to = 0.5', "specimen.half_space.nu")
    for n, new in ((5, 5), (5, 0), (12, 7)):
        (tmp_path / "s.toml").write_text(HALF_SPACE + sobol.replace("count = 3", f"count = {n}"))
        solves.clear()
        assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
        assert len(solves) == new
        assert len(rows(tmp_path / "r" / "table.csv")) == n


@pytest.mark.slow
def test_expensive_solves_are_kept(jkr, tmp_path: Path, solves: list, tuned: Callable) -> None:
    """Other quantities of the same bodies: new rows, no new solve; a damaged file is solved again."""
    tuned("jkrcli.many.cache.TUNING.worth_keeping", 0.0)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    before = rows(tmp_path / "r" / "table.csv")
    kept = sorted((tmp_path / "r" / "solves").iterdir())
    assert [store.read(path).method for path in kept] == ["layered", "layered"]
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED + '[outputs]\nquantities = ["pull_off"]\n')
    kept[0].write_bytes(kept[0].read_bytes()[:-100])
    solves.clear()
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert len(solves) == 1
    assert store.read(kept[0]).method == "layered"
    after = rows(tmp_path / "r" / "table.csv")
    for name in after[0]:
        assert [row[name] for row in after] == [row[name] for row in before]


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
    with pytest.raises(InputError) as caught:
        with_values({"specimen": {"layers": [{"name": "film", "nu": 0.3}]}}, {"specimen.layers.film.nu": 0.1})
    told = 'has no "film": specimen.layers is a list, its entries are specimen.layers[0], [1], ...'
    assert str(caught.value) == f"specimen.layers.film.nu: {told}"


REFUSALS = [
    ('[[axe]]\nkey = "a"', 's.toml: axe: unknown key, did you mean "axes"? (allowed: title, base, axes, samples, '),
    ("", "s.toml: nothing varies: give [[axes]] or [samples]"),
    (
        axis("specimen.half_space.mu", "values = [0.1]"),
        's.toml: base: specimen.half_space.mu: unknown key, did you mean "nu"? (allowed: E, nu',
    ),
    (
        axis("specimen.half_space.nu", "values = [0.1, 0.6]"),
        "s.toml: axes[0]: specimen.half_space.nu: must be > -1 and <= 0.5, got 0.6",
    ),
    (
        axis("specimen.layers[2].nu", "values = [0.1]"),
        "s.toml: base: specimen.layers[2].nu: the base case has 0 entries there, numbered from 0",
    ),
    (
        axis("specimen.half_space.nu.mean", "values = [0.1]"),
        's.toml: base: specimen.half_space.nu.mean: has no "mean": specimen.half_space.nu is no table',
    ),
    (
        axis("specimen..nu", "values = [0.1]"),
        's.toml: axes: must be a key of a case such as "specimen.layers[0].nu", got "specimen..nu"',
    ),
    (
        axis("adhesion.w", ""),
        "s.toml: axes[0]: must hold key and values, or key, from, to, count (and spacing), or zip alone, got key",
    ),
    (axis("adhesion.w", "values = []"), "s.toml: axes[0]: is empty"),
    (AXIS + AXIS, "s.toml: specimen.half_space.nu: is varied twice; keys that go together stand in one zip"),
    (
        '[[axes]]\nzip = { "adhesion.w" = [1], "adhesion.z0" = [1e-10, 2e-10] }',
        "s.toml: axes[0]: the lists of zip must have one length, got {'adhesion.w': 1, 'adhesion.z0': 2}",
    ),
    (
        axis("adhesion.w", 'from = 0\nto = 1\ncount = 3\nspacing = "log"'),
        "s.toml: axes[0]: adhesion.w: a log range needs from and to > 0, got 0 and 1",
    ),
    (
        axis("indenter.shape", 'from = "paraboloid"\nto = "sphere"\ncount = 3'),
        "s.toml: axes[0]: indenter.shape: is no number: give its values as a list",
    ),
    (
        AXIS + '[outputs]\nquantities = ["pull_of"]',
        's.toml: outputs.quantities: unknown quantity "pull_of", did you mean "pull_off"? (groups: solved_by, ',
    ),
    (
        AXIS + '[outputs]\nstiffness = "5 N"',
        's.toml: outputs.stiffness: must be a stiffness, got "5 N": unknown unit "N',
    ),
    (
        samples('distribution = "normal", mean = 1'),
        "s.toml: samples.of.adhesion.w: normal takes mean, sd (and least, most), got mean",
    ),
    (
        samples('distribution = "norml", mean = 1'),
        "s.toml: samples.of.adhesion.w.distribution: must be one of uniform, loguniform, normal, ",
    ),
    (
        samples('distribution = "uniform", from = 2, to = 1'),
        "s.toml: samples.of: adhesion.w: uniform: from must be below to, got 2 and 1",
    ),
    (
        axis("adhesion.w", "from = 1\nto = 2\ncount = 2000001"),
        "s.toml: makes 2,000,001 cases, at most 2,000,000 are allowed in one sweep",
    ),
]


@pytest.mark.parametrize(("text", "line"), REFUSALS, ids=lambda value: str(value)[-40:])
def test_wrong_files_are_refused_in_one_line(jkr, tmp_path: Path, text: str, line: str) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + text)
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert outcome.code == 2
    assert outcome.err.startswith(f"jkr: error: {line}"), outcome.err
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "r").exists()


def test_no_work_of_adhesion_is_refused_before_any_solve(jkr, tmp_path: Path) -> None:
    text = HALF_SPACE.replace("adhesion = ", "# ") + AXIS
    (tmp_path / "s.toml").write_text(text)
    assert jkr("sweep", "s.toml").err == (
        "jkr: error: s.toml: the quantities asked for need a work of adhesion: vary adhesion.w, or set it in the base "
        "case\n"
    )
    (tmp_path / "s.toml").write_text(text + '[outputs]\nquantities = "end"\n')
    assert jkr("sweep", "s.toml").code == 0
    table = rows(tmp_path / "s-results" / "table.csv")
    np.testing.assert_allclose(float(table[0]["end.P_H_N"]), 4 / 3 * 1e6 / (1 - 0.01) * 1e-12 / R, rtol=1e-12)


def test_a_missing_base_case_and_mistakes_in_it_are_named(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text('base = "missing-base-case.toml"\n' + AXIS)
    assert jkr("sweep", "s.toml").err == "jkr: error: missing-base-case.toml: base case not found\n"
    (tmp_path / "s.toml").write_text(HALF_SPACE.replace('"1 MPa"', '"1 MP"') + AXIS)
    assert jkr("sweep", "s.toml").err.startswith(
        'jkr: error: s.toml: base: specimen.half_space.E: must be a modulus, got "1 MP": unknown unit "MP"'
    )


def test_long_sweeps_are_announced_and_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(
        TWO_LAYERS + '[[axes]]\nkey = "specimen.layers[0].thickness"\nfrom = 1e-4\nto = 2e-4\ncount = 200\n'
    )
    outcome = jkr("sweep", "s.toml", "-o", "r", "--hours", "1e-4")
    assert outcome.code == 2
    announced, refused = outcome.err.splitlines()
    assert announced == "jkr: 200 cases to do with 200 solves"
    assert refused.startswith("jkr: error: --hours: 200 cases with 200 solves would take about 0.00")
    assert refused.endswith(
        " core hours, more than the limit of 0.0001; raise it by --hours 1, or ask for fewer cases, fewer points or a "
        "cheaper method"
    )
    assert len((tmp_path / "r" / "journal.jsonl").read_text().splitlines()) == 1


def test_nothing_foreign_is_replaced(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "table.csv").write_text("my thesis")
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert outcome.err == (
        "jkr: error: r/table.csv: exists and was not written by jkr; give --force to replace it, or another name\n"
    )
    (tmp_path / "r" / "table.csv").unlink()
    (tmp_path / "r" / "journal.jsonl").write_text('{"my": "diary"}\n')
    assert jkr("sweep", "s.toml", "-o", "r", "--force").code == 2
    assert (tmp_path / "r" / "journal.jsonl").read_text() == '{"my": "diary"}\n'


def test_an_empty_journal_marks_nothing_as_ours(jkr, tmp_path: Path) -> None:
    """Every table beside it that jkr did not write stays, Parquet and the table of failed cases too."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "journal.jsonl").touch()
    arrow = pyarrow.table({"x": [1.0]})
    for name in ("table.csv", "table.h5", "table.parquet", "failed.csv"):
        foreign = tmp_path / "r" / name
        foreign.write_text("x,y\n1,2\n")
        if name == "table.parquet":
            pyarrow.parquet.write_table(arrow, foreign)
        content = foreign.read_bytes()
        outcome = jkr("sweep", "s.toml", "-o", "r")
        assert (outcome.code, foreign.read_bytes()) == (2, content)
        assert f"r/{name}: exists and was not written by jkr" in outcome.err
        foreign.unlink()
    assert jkr("sweep", "s.toml", "-o", "r").code == 0
    (tmp_path / "r" / "journal.jsonl").unlink()
    assert jkr("sweep", "s.toml", "-o", "r").code == 0, "our own tables carry their own marks"


@pytest.mark.parametrize("kind", ["folder", "pipe", "device", "file of 100 GiB"])
def test_what_is_no_journal_is_not_read(jkr, tmp_path: Path, kind: str) -> None:
    """A link to /dev/zero was read into all memory."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    journal = tmp_path / "r" / "journal.jsonl"
    make = {
        "folder": lambda: journal.mkdir(),
        "pipe": lambda: os.mkfifo(journal),
        "device": lambda: journal.symlink_to("/dev/null"),
        "file of 100 GiB": lambda: (journal.touch(), os.truncate(journal, 100 << 30)),
    }
    (tmp_path / "r").mkdir()
    make[kind]()
    outcome = jkr("sweep", "s.toml", "-o", "r")
    said = "journal is larger than 2048 MiB" if "GiB" in kind else "is a folder, a device or a pipe, not a journal"
    assert (outcome.code, outcome.err) == (2, f"jkr: error: r/journal.jsonl: {said}; give another folder\n")


def test_a_damaged_line_is_said_and_its_case_solved_again(jkr, tmp_path: Path, solves: list) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    journal, table = tmp_path / "r" / "journal.jsonl", tmp_path / "r" / "table.csv"
    wanted, lines = table.read_bytes(), journal.read_bytes().splitlines(keepends=True)
    fewer = json.dumps([*json.loads(lines[2])[:3], [1.0], 0.1, json.loads(lines[2])[5]]).encode()
    deep = b"[" * 100_000
    for line in (lines[2][:30], b"[[[[", deep, fewer, b'["a"]', lines[2].replace(b"ok", b"no")[:-1]):
        journal.write_bytes(b"".join([*lines[:2], line + b"\n", *lines[3:]]))
        solves.clear()
        outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
        assert (outcome.code, len(solves), table.read_bytes()) == (0, 1, wanted)
        assert "jkr: r/journal.jsonl: 1 damaged lines (3): their cases are solved again\n" in outcome.err


def test_a_row_with_other_values_than_the_columns_is_not_believed(jkr, tmp_path: Path) -> None:
    from jkrcli.many.sweep.journal import opened

    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    jkr("sweep", "s.toml", "-o", "r")
    wanted = (tmp_path / "r" / "table.csv").read_bytes()
    with opened(tmp_path / "r" / "journal.jsonl") as journal:
        identity, row = next(iter(journal.rows.items()))
        journal.append(identity, replace(row, values=row.values[:-1]))
    assert jkr("sweep", "s.toml", "-o", "r").code == 0
    assert (tmp_path / "r" / "table.csv").read_bytes() == wanted


@pytest.mark.slow
def test_changed_bytes_of_a_journal_change_no_row(tmp_path: Path, seed: int) -> None:
    """2,000 random bytes, or the head: every row that is still read is as it was written."""
    from jkrcli.many.sweep.journal import opened

    path, made = tmp_path / "journal.jsonl", np.random.default_rng(seed)
    with opened(path) as journal:
        for i in range(20):
            journal.append(f"{i:020x}", solving.Row(-1, "ok", "", tuple(made.random(5).tolist()), 0.25))
        written = dict(journal.rows)
    content = path.read_bytes()
    for _ in range(2000):
        damaged = bytearray(content)
        damaged[made.integers(len(content))] ^= made.integers(1, 256)
        path.write_bytes(damaged)
        try:
            with opened(path) as journal:
                assert journal.rows.items() <= written.items()
                assert len(journal.rows) >= 18
        except InputError as error:
            assert "is no journal of a sweep" in str(error)  # noqa: PT017


@pytest.mark.slow
def test_a_kept_solve_is_known_by_what_it_holds_not_by_its_name(
    jkr, tmp_path: Path, solves: list, tuned: Callable
) -> None:
    """Two kept files with their names exchanged: both bodies are solved again."""
    tuned("jkrcli.many.cache.TUNING.worth_keeping", 0.0)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    table, journal = tmp_path / "r" / "table.csv", tmp_path / "r" / "journal.jsonl"
    wanted = table.read_bytes()
    one, other = sorted((tmp_path / "r" / "solves").iterdir())
    first = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(first)
    journal.unlink()
    solves.clear()
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    assert (len(solves), table.read_bytes()) == (2, wanted)


def test_two_sweeps_into_one_folder_are_refused(jkr, tmp_path: Path) -> None:
    from jkrcli.many.sweep.journal import opened

    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    with opened(tmp_path / "r" / "journal.jsonl"):
        outcome = jkr("sweep", "s.toml", "-o", "r")
    assert outcome.err == (
        "jkr: error: r/journal.jsonl: another jkr sweep is writing there; wait for it, or give another folder\n"
    )


def test_case_numbers_beyond_the_sweep_are_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    assert jkr("sweep", "s.toml", "--only", "3").err == (
        "jkr: error: --only: the cases of s.toml are numbered 0 to 2, got 3\n"
    )


@pytest.mark.parametrize("path", sorted((CASES / "sweeps").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_sweeps_load_and_their_first_case_is_solved(jkr, path: Path) -> None:
    row = json.loads(jkr("sweep", path, "--only", "0", "--json").out)
    assert row["status"] == "ok"
    assert row["pull_off.load.P_N"] < 0


def test_layers_are_counted_after_their_values_are_set(tmp_path: Path) -> None:
    plan = plan_of(
        tmp_path,
        TWO_LAYERS + axis("specimen.layers.count", "values = [1, 2]") + axis("specimen.layers[1].E", "values = [5]"),
    )
    assert [len(plan.case(i).model.specimen.layers) for i in range(2)] == [1, 2]
    assert plan.case(1).model.specimen.layers[1].E == 5


def test_profiles_in_files_travel_with_the_sweep(tmp_path: Path) -> None:
    """A worker on another machine has no such file: its points stand in the recipe."""
    (tmp_path / "profile.csv").write_text("r_m,f_m\n0,0\n1e-4,5e-6\n2e-4,2e-5\n")
    text = HALF_SPACE.replace('shape = "paraboloid", radius = "1 mm"', 'shape = "table", file = "profile.csv"')
    plan = plan_of(tmp_path, text + AXIS)
    (tmp_path / "profile.csv").unlink()
    assert plan.case(2).model.indenter.r == (0.0, 1e-4, 2e-4)


@given(st.integers(0, 2**20), st.sampled_from(["random", "sobol", "latin-hypercube"]))
def test_draws_keep_their_limits(seed: int, method: str) -> None:
    items = [
        Distribution("uniform", -1.0, 2.0),
        Distribution("loguniform", 1e-3, 1e3),
        Distribution("normal", 1.0, 0.5, least=0.9),
        Distribution("lognormal", 2.0, 1.5, most=2.5),
        Distribution("integer", 1, 3),
        Distribution("choice", values=("a", "b")),
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
    items = [Distribution("normal", 3.0, 0.2), Distribution("lognormal", 2.0, 1.5), Distribution("integer", 1, 3)]
    normal, lognormal, integer = (np.array(values) for values in zip(*draw(items, 4096, "sobol", 0), strict=True))
    assert normal.mean() == pytest.approx(3.0, abs=1e-3)
    assert normal.std() == pytest.approx(0.2, rel=5e-3)
    assert np.median(lognormal) == pytest.approx(2.0, rel=2e-3)
    assert np.log(lognormal).std() == pytest.approx(np.log(1.5), rel=5e-3)
    assert [np.mean(integer == n) for n in (1, 2, 3)] == pytest.approx([1 / 3] * 3, abs=1e-3)


def test_groups_of_quantities_are_taken_apart() -> None:
    assert names_of(["pull_off.load", "errors.total", "pull_off.load.P_N"], "s") == (
        "pull_off.load.P_N",
        "pull_off.load.delta_m",
        "pull_off.load.a_m",
        "pull_off.load.over_pi_w_R",
        "errors.total",
    )


def test_every_quantity_is_told_or_its_absence_explained(jkr, tmp_path: Path) -> None:
    groups = dict.fromkeys(name.split(".")[0] for name in NAMES)
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS + f"[outputs]\nquantities = {list(groups)}\n")
    row = json.loads(jkr("sweep", "s.toml", "--only", "1", "--json").out)
    absent = {name for name in NAMES if row[name] is None}
    assert absent == {"validity.delta_over_h", "validity.a_over_h", "validity.a_over_L"}  # a half-space has none
    assert row["solved_by.method"] == "closed-form"
    assert abs(row["comparison.pull_off"]) < 1e-6
    assert row["stability.energy_lost_J"] > row["stability.work_of_separation_J"] * 0.1 > 0


def test_unknown_sources_of_numbers_raise(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"sweep file not found"):
        load_plan(tmp_path / "none.toml")

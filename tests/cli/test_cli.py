"""The command line in process: what is written, what is printed, what is refused and with which exit code."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli import __version__
from jkrcli.case import store
from jkrcli.formulas import jkr_dimensionless
from jkrcli.report.tables import read_curve

HALFSPACE = CASES / "halfspace.toml"
COLUMNS = ["a_m", "delta_m", "P_N", "delta_H_m", "P_H_N", "S_N_per_m", "dS_da_N_per_m2"]


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_no_verb_at_all_is_answered_with_the_help_and_version_with_it(jkr) -> None:
    assert (jkr().code, jkr().out) == (0, jkr("--help").out)
    assert jkr("--version").out == f"jkr, version {__version__}\n"


def test_run_writes_the_case_stem_here_and_transform_beside_it(jkr, tmp_path: Path) -> None:
    outcome = jkr("run", HALFSPACE, "--method", "closed-form")
    assert (outcome.code, outcome.err) == (0, "")
    assert files(tmp_path) == ["halfspace.h5"]
    outcome = jkr("transform", "halfspace.h5").ok
    names = [f"halfspace-w50{ending}" for ending in (".csv", ".json", ".png", ".svg")]
    assert files(tmp_path) == [*names, "halfspace.h5"]
    assert (tmp_path / names[0]).read_text().splitlines()[0].split(",")[: len(COLUMNS)] == COLUMNS
    summary = json.loads((tmp_path / names[1]).read_text())
    assert summary["pull_off"]["load"]["P_N"] == pytest.approx(
        -1.49734 * np.pi * 50 * 100e-6, rel=1e-5, abs=0
    )  # 6 digits
    assert summary["tabor"] == pytest.approx(639, abs=0.5)
    assert summary["points"] == {"kept": 100, "dropped": 0}
    assert set(summary["errors"]) == {"discretisation", "truncation", "radius", "smoothing", "total", "between_rows"}
    assert abs(summary["comparison"]["pull_off"]) < 1e-9


def test_many_works_with_units_and_no_adhesion(jkr, tmp_path: Path) -> None:
    jkr("run", HALFSPACE, "--method", "layered", "-o", "x.h5")
    assert jkr("transform", "x.h5", "--w", "35 mJ/m^2", "--w", "0", "--w", "7", "-o", "out", "--no-plots").code == 0
    assert files(tmp_path / "out") == [f"x-w{w}.{end}" for w in ("0.035", "0", "7") for end in ("csv", "json")]
    nonadhesive = read_curve(tmp_path / "out" / "x-w0.csv")
    np.testing.assert_array_equal(nonadhesive["P_N"], nonadhesive["P_H_N"])
    np.testing.assert_array_equal(nonadhesive["delta_m"], nonadhesive["delta_H_m"])
    point = json.loads((tmp_path / "out" / "x-w0.json").read_text())["pull_off"]["load"]
    assert point == {"P_N": None, "delta_m": None, "a_m": None, "reason": "there is no adhesion at w = 0"}


def test_compare_agrees_differs_and_refuses(jkr, tmp_path: Path) -> None:
    jkr("run", HALFSPACE, "--method", "closed-form", "-o", "a.h5")
    jkr("run", HALFSPACE, "--method", "layered", "-o", "b.h5")
    outcome = jkr("compare", "a.h5", "b.h5", "--rtol", "1e-10", "--column", "P", "--column", "S", "--plot", "d.png").ok
    assert outcome.out.startswith("a.h5 against b.h5: agree at rtol 1e-10\n")
    assert (tmp_path / "d.png").exists()
    text = HALFSPACE.read_text().replace('shape = "sphere"', 'shape = "paraboloid"')
    (tmp_path / "c.toml").write_text(text)
    jkr("run", "c.toml", "--method", "closed-form")
    jkr("compare", "a.h5", "c.h5").refused(
        "c.h5: its indenter is not that of a.h5; compare results of the same problem"
    )
    jkr("transform", "a.h5", "c.h5", "--no-plots")
    outcome = jkr("compare", "a-w50.csv", "c-w50.csv", "--rtol", "1e-4")
    assert outcome.code == 1
    assert "DIFFER at rtol 0.0001" in outcome.out


def test_nothing_foreign_is_overwritten(jkr, tmp_path: Path) -> None:
    (tmp_path / "halfspace.h5").write_text("my thesis")
    jkr("run", HALFSPACE, "--method", "closed-form").refused(
        "halfspace.h5: exists and was not written by jkr; give --force to replace it, or another name"
    )
    assert (tmp_path / "halfspace.h5").read_text() == "my thesis"
    assert jkr("run", HALFSPACE, "--method", "closed-form", "--force").code == 0
    assert jkr("run", HALFSPACE, "--method", "layered").code == 0  # its own file is replaced
    assert store.read_solution("halfspace.h5").method == "layered"
    (tmp_path / "halfspace-w50.csv").write_text("x,y\n1,2\n")
    outcome = jkr("transform", "halfspace.h5")
    outcome.refused("halfspace-w50.csv: exists and was not written by jkr")
    assert files(tmp_path) == ["halfspace-w50.csv", "halfspace.h5"]
    assert jkr("transform", "halfspace.h5", "--force").code == 0
    assert jkr("transform", "halfspace.h5").code == 0  # all four are recognised as its own


REFUSALS = [
    (("rnu",), 'unknown command "rnu", did you mean "run"?'),
    (("run",), "missing argument 'CASE'; see jkr run --help"),
    (("run", "no.toml"), "no.toml: case file not found"),
    (("run", HALFSPACE, "-o", "no/x.h5"), "no/x.h5: the folder no does not exist"),
    (("run", HALFSPACE, "-o", "x.csv"), "x.csv: a solution is written as HDF5, its name must end in .h5"),
    (("run", HALFSPACE, "-o", "."), ".: is a folder, cannot be written as a file"),
    (("run", CASES / "gel.toml", "--method", "closed-form"), "the thin-layer formula gives up to 48 times"),
    (("transform", "no.h5"), "no.h5: solution file not found"),
    (("transform", "x.h5", "--w", "-1"), "invalid value for '--w': must be >= 0, got -1"),
    (("transform", "x.h5", "--w", "5 kg"), "invalid value for '--w': must be a work of adhesion, got \"5 kg\""),
    (("transform", "x.h5", "x.h5"), "x-w50.csv: would be written twice"),
    (("transform", "x.h5", "--w", "1", "--w", "1 N/m"), "x-w1.csv: would be written twice"),
    (("transform", "x.h5", "--dimensionless", "thin-layer"), "thin-layer: needs one homogeneous isotropic layer"),
    (("compare", "x.h5", "no.h5"), "no.h5: solution file not found"),
    (("compare", "x.csv", "x.csv"), "x.csv: curve not found"),
]


@pytest.mark.parametrize(("words", "line"), REFUSALS, ids=lambda value: str(value)[:40])
def test_refusals_are_one_line_with_exit_code_2(jkr, tmp_path: Path, words: tuple, line: str) -> None:
    jkr("run", HALFSPACE, "--method", "closed-form", "-o", "x.h5")
    jkr(*words).refused(line)
    assert files(tmp_path) == ["x.h5"]


def test_new_writes_a_case_that_runs_and_never_replaces_one(jkr, tmp_path: Path) -> None:
    assert jkr("new", "my.toml").code == 0
    assert jkr("run", "my.toml").code == 0
    assert store.read_solution("my.h5").method == "layered"
    assert jkr("new", "my.toml").err == "jkr: error: my.toml: exists; give --force to replace it, or another name\n"
    assert jkr("new", "my.case").err == "jkr: error: my.case: the name must end in .toml\n"
    assert files(tmp_path) == ["my.h5", "my.toml"]


def test_new_writes_every_shipped_example(jkr, tmp_path: Path) -> None:
    for path in (*CASES.glob("*.toml"), *CASES.glob("measured/*")):
        assert jkr("new", "--example", path.stem).code == 0
        assert Path(path.name).read_bytes() == path.read_bytes()
    assert jkr("new", "mine.toml", "--example", "gel").code == 0
    assert 'unknown example "gell", did you mean "gel"? (' in jkr("new", "--example", "gell").err
    assert jkr("new").err == "jkr: error: new: give the FILE to write, such as my.toml, or --example\n"


def test_pull_off_outside_the_series_is_said(jkr, tmp_path: Path) -> None:
    (tmp_path / "shallow.toml").write_text(HALFSPACE.read_text().replace('"3 um"', '"0.1 um"'))
    jkr("run", "shallow.toml", "--method", "closed-form")
    outcome = jkr("transform", "shallow.h5", "--no-plots")
    assert "pull-off under load control: the load is lowest at the largest radius of the solution" in outcome.err
    assert json.loads((tmp_path / "shallow-w50.json").read_text())["pull_off"]["load"]["P_N"] is None


def test_interrupt_leaves_nothing(jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("jkrcli.base.hdf5._describe", interrupted)
    outcome = jkr("run", HALFSPACE, "--method", "closed-form")
    assert (outcome.code, outcome.err.strip()) == (130, "jkr: error: interrupted; nothing half-written was left")
    assert files(tmp_path) == []


def test_dimensionless_columns_are_eq_18_for_a_paraboloid(jkr, tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(HALFSPACE.read_text().replace('"sphere"', '"paraboloid"'))
    jkr("run", "p.toml", "--method", "closed-form")
    assert jkr("transform", "p.h5", "--dimensionless", "half-space").code == 0
    curve = read_curve(tmp_path / "p-w50.csv")
    delta_bar, P_bar = jkr_dimensionless(curve["a_bar"])
    np.testing.assert_allclose(curve["P_bar"], P_bar, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(curve["delta_bar"], delta_bar, rtol=1e-10, atol=1e-12)
    assert (
        jkr("transform", "p.h5", "--scale", "a=1um", "--scale", "delta=1nm", "--scale", "P=1mN", "--no-plots").code == 0
    )
    curve = read_curve(tmp_path / "p-w50.csv")
    np.testing.assert_allclose(curve["P_bar"], curve["P_N"] * 1e3, rtol=1e-14)
    np.testing.assert_allclose(curve["a_bar"], curve["a_m"] * 1e6, rtol=1e-14)
    assert json.loads((tmp_path / "p-w50.json").read_text())["scales"]["name"] == "own"
    outcome = jkr("transform", "p.h5", "--scale", "a=1um")
    assert outcome.err == "jkr: error: --scale: needs a, delta and P, each > 0, got delta = nothing\n"


def test_an_input_is_never_an_output_not_even_by_force(jkr, tmp_path: Path) -> None:
    jkr("new", "my.toml")
    before = (tmp_path / "my.toml").read_text()
    for words in ((), ("--force",)):
        jkr("run", "my.toml", "-o", "my.toml", *words).refused(
            "my.toml: is read by this command, cannot be written too; give another name"
        )
    assert (tmp_path / "my.toml").read_text() == before


def test_folders_that_cannot_be_made_are_refused(jkr, tmp_path: Path) -> None:
    jkr("run", HALFSPACE, "--method", "closed-form", "-o", "x.h5")
    for words in (("transform", "x.h5"), ("profile", "x.h5", "--a", "5um"), ("mesh", HALFSPACE), ("cycle", "x.h5")):
        jkr(*words, "-o", "x.h5/inside").refused("x.h5/inside: cannot be made a folder (Not a directory)")


def test_compare_wants_a_common_range_and_a_picture_it_can_draw(jkr, tmp_path: Path) -> None:
    text = HALFSPACE.read_text()
    for name, values in {"low": "[1e-6, 2e-6]", "high": "[2e-6, 3e-6]"}.items():
        (tmp_path / f"{name}.toml").write_text(text.replace('"3 um"', values).replace("points = 100\n", ""))
        assert jkr("run", f"{name}.toml", "--method", "closed-form").code == 0
    jkr("compare", "low.h5", "high.h5").refused("share only 0% of their range of delta_m", "--overlap 0.00")
    jkr("compare", "low.h5", "low.h5", "--plot", "x.toml").refused("--plot: must end in .png or .svg")


def test_a_pipe_or_device_is_not_read(jkr) -> None:
    assert jkr("run", "/dev/zero").err == "jkr: error: /dev/zero: is a device or a pipe, not a case file\n"
    os.mkfifo("record.csv")
    for verb in ("look", "fit"):  # their forecast read it, and waited for a writer that never came
        flags = ("--radius", "5 um", "--nu", "0.5") if verb == "fit" else ()
        jkr(verb, *flags, "record.csv").refused("record.csv: is a device or a pipe, not a table")
    os.mkfifo("records.zip")
    assert jkr("look", "records.zip").err == "jkr: error: records.zip: is a device or a pipe, not a zip archive\n"


def test_a_pipe_or_device_is_not_replaced(jkr) -> None:
    """Whether it is ours would be read, and waited for; by force a device of the system would become a file."""
    for name in ("r.h5", "c.toml"):
        os.mkfifo(name)
    jkr("new", "my.toml")
    run = ("run", "my.toml", "-o", "r.h5")
    for name, words in (("r.h5", run), ("r.h5", (*run, "--force")), ("c.toml", ("new", "c.toml", "--force"))):
        jkr(*words).refused(f"{name}: is a device or a pipe, cannot be written as a file")
        assert Path(name).is_fifo()


def test_graded_radii_reach_a_pull_off_close_to_first_contact(jkr, tmp_path: Path) -> None:
    text = (
        '[indenter]\nshape = "flat"\nflat_radius = "50 um"\nedge_radius = "20 um"\n[specimen.half_space]\nE = "1 MPa"\n'
        'nu = 0.5\n[loading]\nradius = "60 um"\nspacing = "log"\n[adhesion]\nw = 0.05\n'
    )
    (tmp_path / "log.toml").write_text(text)
    assert jkr("run", "log.toml").code == 0
    assert jkr("transform", "log.h5", "--no-plots").code == 0
    point = json.loads((tmp_path / "log-w0.05.json").read_text())["pull_off"]["load"]
    assert point["P_N"] == pytest.approx(-457.84e-6, rel=1e-5, abs=0)  # minimum of the closed form, to five digits
    assert point["a_m"] == pytest.approx(50.042e-6, rel=1e-5, abs=0)

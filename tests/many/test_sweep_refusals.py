"""Sweep files that are refused, each in one line, before any solve; cases that fail, and the rest goes on."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from sweep_files import AXIS, BAD, HALF_SPACE, TWO_LAYERS, R, axis, rows, samples

from jkrcli.many import sweep_plan as plan

pytestmark = pytest.mark.usefixtures("no_pictures")


REFUSALS = [
    ('[[axe]]\nkey = "a"', 'axe: unknown key, did you mean "axes"? (allowed: title, base, axes, samples, '),
    ("", "s.toml: nothing varies: give [[axes]] or [samples]"),
    (axis("specimen.half_space.mu", "values = [0.1]"), 'base: specimen.half_space.mu: unknown key, did you mean "nu"?'),
    (axis("specimen.half_space.nu", "values = [0.1, 0.6]"), "axes[0]: specimen.half_space.nu: must be > -1 and <= 0.5"),
    (axis("specimen.layers[2].nu", "values = [0.1]"), "the base case has 0 entries there, numbered from 0"),
    (axis("specimen.half_space.nu.mean", "values = [0.1]"), 'has no "mean": specimen.half_space.nu is no table'),
    (
        axis("specimen..nu", "values = [0.1]"),
        'axes: must be a key of a case such as "specimen.layers[0].nu", got "spec',
    ),
    (axis("adhesion.w", ""), "axes[0]: must hold key and values, or key, from, to, count (and spacing), or zip alone"),
    (axis("adhesion.w", "values = []"), "s.toml: axes[0]: is empty"),
    (AXIS + AXIS, "specimen.half_space.nu: varies twice; put keys that vary together into one zip"),
    ('[[axes]]\nzip = { "adhesion.w" = [1], "adhesion.z0" = [1e-10, 2e-10] }', "the lists of zip must have one length"),
    (
        axis("adhesion.w", 'from = 0\nto = 1\ncount = 3\nspacing = "log"'),
        "a log range needs from and to > 0, got 0 and 1",
    ),
    (
        axis("indenter.shape", 'from = "paraboloid"\nto = "sphere"\ncount = 3'),
        "is no number: give its values as a list",
    ),
    (AXIS + '[outputs]\nquantities = ["pull_of"]', 'unknown quantity "pull_of", did you mean "pull_off"? (groups: '),
    (AXIS + '[outputs]\nstiffness = "5 N"', 'outputs.stiffness: must be a stiffness, got "5 N": unknown unit "N'),
    (samples('distribution = "normal", mean = 1'), "normal takes mean, sd (and least, most), got mean"),
    (samples('distribution = "norml", mean = 1'), "distribution: must be one of uniform, loguniform, normal, "),
    (samples('distribution = "uniform", from = 2, to = 1'), "adhesion.w: uniform: from must be below to, got 2 and 1"),
    (axis("adhesion.w", "from = 1\nto = 2\ncount = 2000001"), "makes 2,000,001 cases, at most 2,000,000 are allowed"),
]


@pytest.mark.parametrize(("text", "line"), REFUSALS, ids=lambda value: str(value)[-40:])
def test_wrong_files_are_refused_in_one_line(jkr, tmp_path: Path, text: str, line: str) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + text)
    jkr("sweep", "s.toml", "-o", "r").refused(line)
    assert not (tmp_path / "r").exists()


def test_no_work_of_adhesion_is_refused_before_any_solve(jkr, tmp_path: Path) -> None:
    text = HALF_SPACE.replace("adhesion = ", "# ") + AXIS
    (tmp_path / "s.toml").write_text(text)
    jkr("sweep", "s.toml").refused("the requested quantities need a work of adhesion: vary adhesion.w, or set it")
    (tmp_path / "s.toml").write_text(text + '[outputs]\nquantities = "end"\n')
    assert jkr("sweep", "s.toml").code == 0
    table = rows(tmp_path / "s-results" / "table.csv")
    np.testing.assert_allclose(float(table[0]["end.P_H_N"]), 4 / 3 * 1e6 / (1 - 0.01) * 1e-12 / R, rtol=1e-12)


@pytest.mark.parametrize(("text", "words", "line"), [
    ('base = "missing-base-case.toml"\n' + AXIS, (), "missing-base-case.toml: base case not found"),
    (HALF_SPACE.replace('"1 MPa"', '"1 MP"') + AXIS, (), 's.toml: base: specimen.half_space.E: must be a modulus, got'),
    (HALF_SPACE + AXIS, ("--only", "3"), "--only: the cases of s.toml are numbered 0 to 2, got 3"),
])  # fmt: skip
def test_a_base_case_and_numbers_of_cases(jkr, tmp_path: Path, text: str, words: tuple[str, ...], line: str) -> None:
    (tmp_path / "s.toml").write_text(text)
    jkr("sweep", "s.toml", *words).refused(line)
    jkr("sweep", "none.toml").refused("sweep file not found")


def test_long_sweeps_are_announced_and_refused(jkr, tmp_path: Path) -> None:
    many = axis("specimen.layers[0].thickness", "from = 1e-4\nto = 2e-4\ncount = 200\n")
    (tmp_path / "s.toml").write_text(TWO_LAYERS + many)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--hours", "1e-4")
    assert outcome.code == 2
    announced, refused = outcome.err.splitlines()
    assert announced == "jkr: 200 cases to compute by 200 solves"
    assert refused.startswith("jkr: error: --hours: 200 cases with 200 solves would take about 0.00")
    assert "more than the limit of 0.0001; raise it with --hours 1, or use fewer cases" in refused
    assert len((tmp_path / "r" / "journal.jsonl").read_text().splitlines()) == 1


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
    plain = plan.solved_once

    def faulty(body, method, kept):
        if body.specimen.surface.nu == 0.3:
            raise ZeroDivisionError("by zero")
        return plain(body, method, kept)

    monkeypatch.setattr(plan, "solved_once", faulty)
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
    one = axis("adhesion.w", "values = [1]")
    (tmp_path / "s.toml").write_text(TWO_LAYERS.replace('"layered"', '"closed-form"') + one)
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert (outcome.code, "s.toml: every case failed, the first because: method closed" in outcome.err) == (1, True)

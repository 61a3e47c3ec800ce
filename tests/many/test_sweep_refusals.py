"""Sweep files that are refused, each in one line, before any solve."""

from pathlib import Path

import numpy as np
import pytest
from sweep_files import AXIS, HALF_SPACE, TWO_LAYERS, R, axis, rows, samples

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

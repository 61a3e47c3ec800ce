"""Sweep files that are refused, each in one line, before any solve."""

from pathlib import Path

import numpy as np
import pytest
from sweep_files import AXIS, HALF_SPACE, TWO_LAYERS, R, axis, rows, samples

from jkrcli.base.errors import InputError
from jkrcli.many.sweep_plan import load_plan

pytestmark = pytest.mark.usefixtures("no_pictures")


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
    (AXIS + AXIS, "s.toml: specimen.half_space.nu: varies twice; put keys that vary together into one zip"),
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
    jkr("sweep", "s.toml", "-o", "r").refused(line)
    assert not (tmp_path / "r").exists()


def test_no_work_of_adhesion_is_refused_before_any_solve(jkr, tmp_path: Path) -> None:
    text = HALF_SPACE.replace("adhesion = ", "# ") + AXIS
    (tmp_path / "s.toml").write_text(text)
    assert jkr("sweep", "s.toml").err == (
        "jkr: error: s.toml: the requested quantities need a work of adhesion: vary adhesion.w, or set it in the base "
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
    assert announced == "jkr: 200 cases to compute by 200 solves"
    assert refused.startswith("jkr: error: --hours: 200 cases with 200 solves would take about 0.00")
    assert refused.endswith(
        " core hours, more than the limit of 0.0001; raise it with --hours 1, or use fewer cases, fewer points or a "
        "cheaper method"
    )
    assert len((tmp_path / "r" / "journal.jsonl").read_text().splitlines()) == 1


def test_case_numbers_beyond_the_sweep_are_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    assert jkr("sweep", "s.toml", "--only", "3").err == (
        "jkr: error: --only: the cases of s.toml are numbered 0 to 2, got 3\n"
    )


def test_unknown_sources_of_numbers_raise(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"sweep file not found"):
        load_plan(tmp_path / "none.toml")

"""Every half-width that is printed or written is one at 95 %, and says so."""

import csv
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from jkrcli.base.errors import LEVEL
from jkrcli.base.numerics import HALF_WIDTH, half_width

CASES = Path(__file__).parents[2] / "cases"
PROBE = CASES / "measured" / "gel-probe.csv"
RECORD = CASES / "measured" / "raw-force-curve.txt"


def levels(data: Any) -> list[float]:
    """All that is called level, anywhere in JSON."""
    if isinstance(data, list):
        return [level for one in data for level in levels(one)]
    if not isinstance(data, dict):
        return []
    own = [data["level"]] if "level" in data else []
    return own + [level for one in data.values() for level in levels(one)]


def stated(path: Path) -> set[str]:
    with path.open() as file:
        return {row["level"] for row in csv.DictReader(file)}


def test_the_half_width_of_a_normal_error() -> None:
    assert (LEVEL, HALF_WIDTH) == (0.95, pytest.approx(1.959964, abs=1e-6))
    assert half_width(0.9) == pytest.approx(1.644854, abs=1e-6)


def test_every_output_states_it(jkr: Callable) -> None:
    assert jkr("run", CASES / "gel.toml", "-o", "gel.h5").code == 0
    for words in (
        ("show", "gel.h5"),
        ("transform", "gel.h5", "--slopes", "integral", "--no-plots"),
        ("pull-off", "gel.h5", "--load", "1.2 mN"),
        ("cycle", "gel.h5", "--stiffness", "10 N/m", "--no-plots"),
        ("work", "gel.h5", PROBE, "--noise", "P=1 uN", "--no-plots", "-o", "."),
        ("look", RECORD, "--no-plots"),
    ):
        assert set(levels(jkr(*words, "--json").told)) == {0.95}, words
        said = jkr(*words, *["--force"] * (words[0] in ("transform", "cycle", "work")), "-v")
        assert "90 %" not in said.out, words
        if "±" in said.out or "confidence" in said.out:
            assert "95 %" in said.out, said.out
    for name in ("gel-w0.04.csv", "gel-probe-work.csv"):
        assert stated(Path(name)) == {"0.95"}


def test_a_table_of_fits_has_half_widths(jkr: Callable) -> None:
    for level in (0.95, 0.5):
        tip = ("--radius", "5 um", "--nu", "0.5")
        assert jkr("fit", RECORD, *tip, "--no-plots", "--level", str(level), "-o", str(level)).code == 0
        with Path(f"{level}/raw-force-curve-fit.csv").open() as file:
            (row,) = csv.DictReader(file)
        (one,) = json.loads(Path(f"{level}/raw-force-curve-fit.json").read_text())["curves"]
        assert float(row["level"]) == one["level"] == level
        told = one["estimates"]["E_star"]
        low, high, half, *parts = (
            float(row[f"E_star_{name}_Pa"]) for name in ("low", "high", "err", "statistical", "calibration", "model")
        )
        assert half == pytest.approx((high - low) / 2, rel=1e-3)  # ends of logs are a little apart
        assert half == pytest.approx(math.hypot(*parts), rel=1e-12)
        assert parts[0] == pytest.approx(half_width(level) * told["standard_error"], rel=0.05)
        assert parts[2] == pytest.approx(math.hypot(*told["model"].values()), rel=1e-12)
        assert [low, high, half, *parts[:2]] == [
            told[key] for key in ("low", "high", "err", "statistical", "calibration")
        ]


@pytest.mark.first(1)
@pytest.mark.parametrize("w", ["2 mJ/m^2", "0.5 mJ/m^2"])
def test_differences_are_those_of_the_printed_numbers(jkr: Callable, w: str) -> None:
    Path("soft.toml").write_text(
        f'[indenter]\nshape = "sphere"\nradius = "1 um"\n[specimen.half_space]\nE = "10 kPa"\nnu = 0.5\n'
        f'[loading]\nradius = "0.9 um"\npoints = 60\n[adhesion]\nw = "{w}"\n'
    )
    assert jkr("run", "soft.toml").code == 0
    first = jkr("pull-off", "soft.h5", "--w", w).out.splitlines()[0]
    found = re.search(r"force ([\d.]+) nN \(load\).* 1\.5 pi w R = ([\d.]+) nN \(([\d.]+) % too high\)", first)
    assert found is not None, first
    force, classical, percent = map(float, found.groups())
    assert abs(100 * (classical / force - 1) - percent) <= 0.5  # as 7.5 of 9.425, to a whole number
    assert f"P = -{found[1]} nN" in jkr("check", "soft.toml", "-v").out

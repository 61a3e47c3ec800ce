"""``jkr work`` from files to files: table, summary, plots, several curves, and whole lines for what is wrong."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import described_body
import numpy as np
import pytest
from conftest import Outcome, write_table

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.case import store

CASE = """
indenter = { shape = "sphere", radius = "1 mm" }
specimen.layers = [{ thickness = "50 um", E = "1 MPa", nu = 0.499 }]
loading = { radius = "0.2 mm", points = 40 }
"""
W = 0.05
Run = Callable[..., Outcome]


@pytest.fixture(name="measured")
def _measured(jkr: Run) -> Path:
    """A series and the table of a retraction on it, in the folder of the test."""
    Path("gel.toml").write_text(CASE)
    assert jkr("run", "gel.toml", "--method", "layered").code == 0
    series = store.read_solution("gel.h5").series
    curve = transform(series, slopes(series), W)
    t = np.arange(len(series)) * 0.5
    table = np.stack([t, curve.a * 1e6, curve.delta * 1e6, curve.P * 1e3], axis=1)[::-1]
    table[:, 0] = t
    path = Path("m.csv")
    return write_table(path, "t_s,a_um,delta_um,P_mN", *table.T)


def table(path: str) -> dict[str, list[str]]:
    rows = list(csv.DictReader(Path(path).read_text().splitlines()))
    return {name: [row[name] for row in rows] for name in rows[0]}


@pytest.mark.first(1)
@pytest.mark.parametrize("use", ["delta,P", "a,P", "a,delta"])
def test_a_table_comes_back_with_w_and_speed(jkr: Run, measured: Path, use: str) -> None:
    done = jkr("work", "gel.h5", measured, "--use", use, "--noise", "P=1 nN", "--noise", "a=1 nm", "--no-plots")
    assert (done.code, done.out[:13]) == (0, "w = 50 mJ/m^2")
    assert done.out.splitlines()[0].endswith(", 40 of 40 rows: m.csv")
    found = table("m-work.csv")
    assert list(found)[:6] == ["curve", "segment", "state", "a_m", "w_J_per_m2", "w_err_J_per_m2"]
    np.testing.assert_allclose(np.array(found["w_J_per_m2"], float), W, rtol=5e-12)  # 3e-13
    np.testing.assert_allclose(np.array(found["speed_m_per_s"], float), -1e-5, rtol=1e-12)  # 5 um in 0.5 s
    summary = json.loads(Path("m-work.json").read_text())
    assert summary["curves"][0]["from"] == use.split(",")
    assert summary["curves"][0]["w"]["advancing"] is None
    assert summary["curves"][0]["w"]["receding"]["rows"] == 40
    assert summary["curves"][0]["w"]["all"]["err_by_noise_J_per_m2"] > 0
    assert summary["errors"]["smoothing"] < 1e-2
    assert not Path("m-work.png").exists()


def test_where_the_noise_is_not_known_and_rows_without_w(jkr: Run, measured: Path) -> None:
    done = jkr("work", "gel.h5", measured, "--no-plots")
    assert "no error of w: the noise is not known, give --noise" in done.out
    assert set(table("m-work.csv")["w_err_J_per_m2"]) == {""}
    spread = json.loads(Path("m-work.json").read_text())["curves"][0]["w"]["all"]
    assert spread["err_J_per_m2"] is None
    assert spread["err_by_slopes_J_per_m2"] > 0
    rows = measured.read_text().splitlines()
    rows[20] = "9.5,400,0,0"  # beyond the series
    measured.write_text("\n".join(rows) + "\n")
    assert jkr("work", "gel.h5", measured, "--no-plots").code == 0
    found = table("m-work.csv")
    assert found["state"][19] == "above the solution"
    assert (found["w_J_per_m2"][19], found["speed_m_per_s"][19], found["a_m"][19]) == ("", "", "0.0004")
    assert "nan" not in Path("m-work.csv").read_text()


def test_rows_of_a_segment_and_their_factors(jkr: Run, measured: Path) -> None:
    words = ("--factor", "P=2", "--modulus-factor", "2", "--no-plots", "--json")
    (summary,) = jkr("work", "gel.h5", measured, *words).told["results"]
    assert summary["modulus_factor"] == 2
    np.testing.assert_allclose(summary["curves"][0]["w"]["all"]["quartiles_J_per_m2"], 2 * W, rtol=5e-14)  # 2e-15
    header, *rows = measured.read_text().splitlines()
    told = [f"{row},{'approach' if i < 10 else 'retract'}" for i, row in enumerate(rows)]
    measured.write_text("\n".join([header + ",segment", *told]) + "\n")
    done = jkr("work", "gel.h5", measured, "--segment", "retract", "--no-plots").ok
    assert "30 of 30 rows" in done.out
    assert set(table("m-work.csv")["segment"]) == {"retract"}


def test_bad_curves_and_bad_files_among_many(jkr: Run, measured: Path) -> None:
    rows = measured.read_text().splitlines()
    lines = ["curve," + rows[0], *("good," + row for row in rows[1:]), *(f"bad,{i},900,1,1" for i in range(4))]
    Path("map.csv").write_text("\n".join(lines) + "\n")
    done = jkr("work", "gel.h5", "map.csv", "--no-plots").ok
    (skipped,) = json.loads(Path("map-work.json").read_text())["skipped"]
    assert skipped.startswith(
        'map.csv: curve "bad": none of its 4 rows gives a work of adhesion: 4 at contact radii above'
    )
    assert f"jkr: warning: skipped: {skipped}\n" in done.err
    assert set(table("map-work.csv")["curve"]) == {"good"}
    Path("lame.csv").write_text("\n".join([lines[0], *lines[-4:]]) + "\n")
    jkr("work", "gel.h5", "lame.csv", "--no-plots").refused(skipped.replace("map.csv", "lame.csv"))


MISTAKES = {
    ("--window", "4"): "--window: must be an odd number of rows, at least 5, got 4",
    ("--noise", "w=1"): 'must be KEY=VALUE with a key of a, delta, P, got "w=1"',
    ("--zero", "a=1"): 'must be KEY=VALUE with a key of delta, P, got "a=1"',
    ("--stiffness", "0"): 'must be > 0 or "rigid", got 0',
    ("m.csv",): "m-work.csv: would be written twice",
}


@pytest.mark.parametrize("flags", MISTAKES, ids=" ".join)
def test_mistakes_are_told_in_one_line(jkr: Run, measured: Path, flags: tuple[str, ...]) -> None:
    jkr("work", "gel.h5", measured, *flags).refused(MISTAKES[flags])
    assert not list(Path().glob("m-work*"))


RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"


def test_a_raw_record_is_zeroed_by_its_fit(jkr: Run) -> None:
    """Read as it stands, the record says 102 J/m^2; w is 1 mJ/m^2 on its way out and 0.2 mJ/m^2 on its way in."""
    Path("gel.toml").write_text(
        described_body.CASE.format(shape="sphere").replace("1 um", "2 um").replace("100 kPa", "150 kPa")
    )
    assert jkr("run", "gel.toml").code == 0
    for segment, w, other in (("retract", 1e-3, "advancing"), ("approach", 0.2e-3, "receding")):
        (found,) = jkr("work", "gel.h5", str(RAW), "--segment", segment, "--json", "--no-plots", "-o", segment).told[
            "results"
        ]
        assert found["curves"][0]["w"]["all"]["median_J_per_m2"] == pytest.approx(w, rel=0.05)
        assert found["curves"][0]["w"][other] is None
        rows = table(f"{segment}/raw-force-curve-work.csv")
        off, half = (np.array(rows[name], float) for name in ("w_J_per_m2", "w_err_J_per_m2"))
        z = 1.96 * (off - np.median(off)) / half  # the noise of the base line is that of the rows
        assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5

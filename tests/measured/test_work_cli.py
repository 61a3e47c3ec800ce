"""``jkr work`` from files to files: table, summary, plots, several curves, and whole lines for what is wrong."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Outcome

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.files import is_ours
from jkrcli.case import store

CASE = """
[indenter]
shape = "sphere"
radius = "1 mm"
[[specimen.layers]]
thickness = "50 um"
E = "1 MPa"
nu = 0.499
[loading]
radius = "0.2 mm"
points = 40
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
    lines = ["t_s,a_um,delta_um,P_mN", *(",".join(map(repr, row)) for row in table.tolist())]
    path.write_text("\n".join(lines) + "\n")
    return path


def table(path: str) -> dict[str, list[str]]:
    rows = list(csv.DictReader(Path(path).read_text().splitlines()))
    return {name: [row[name] for row in rows] for name in rows[0]}


@pytest.mark.parametrize("use", ["a,P", "a,delta", "delta,P"])
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


@pytest.mark.slow
def test_plots_are_written_and_everything_is_ours_to_replace(jkr: Run, measured: Path) -> None:
    assert jkr("work", "gel.h5", measured).code == 0
    assert jkr("work", "gel.h5", measured, "--no-plots").code == 0
    assert all(is_ours(Path(f"m-work{ending}")) for ending in (".csv", ".json", ".png", ".svg"))
    Path("m-work.csv").write_text("my own table\n")
    done = jkr("work", "gel.h5", measured)
    assert (done.code, done.err) == (
        2, "jkr: error: m-work.csv: exists and was not written by jkr; give --force to replace it, or another name\n",
    )  # fmt: skip
    assert jkr("work", "gel.h5", measured, "--force", "--no-plots").code == 0
    assert jkr("work", "gel.h5", measured, "-o", "out", "--no-plots").code == 0
    assert Path("out/m-work.json").exists()


def test_where_the_noise_is_not_known_w_has_no_error(jkr: Run, measured: Path) -> None:
    done = jkr("work", "gel.h5", measured, "--no-plots")
    assert "no error of w: the noise is not known, give --noise" in done.out
    assert set(table("m-work.csv")["w_err_J_per_m2"]) == {""}
    spread = json.loads(Path("m-work.json").read_text())["curves"][0]["w"]["all"]
    assert spread["err_J_per_m2"] is None
    assert spread["err_by_slopes_J_per_m2"] > 0


def test_rows_without_w_have_empty_cells(jkr: Run, measured: Path) -> None:
    rows = measured.read_text().splitlines()
    rows[20] = "9.5,400,0,0"  # beyond the series
    measured.write_text("\n".join(rows) + "\n")
    assert jkr("work", "gel.h5", measured, "--no-plots").code == 0
    found = table("m-work.csv")
    assert found["state"][19] == "above the solution"
    assert (found["w_J_per_m2"][19], found["speed_m_per_s"][19], found["a_m"][19]) == ("", "", "0.0004")
    assert "nan" not in Path("m-work.csv").read_text()


def test_moduli_and_loads_twice_as_large_mean_twice_w(jkr: Run, measured: Path) -> None:
    text = measured.read_text().replace("P_mN", "P")
    measured.write_text(text)
    scaled = [float(row.split(",")[3]) * 2 for row in text.splitlines()[1:]]
    Path("n.csv").write_text("\n".join(f"{row.rsplit(',', 1)[0]},{load!r}" for row, load in
                                       zip(text.splitlines()[1:], scaled, strict=True)))  # fmt: skip
    columns = [f"--column={key}={i}" for i, key in enumerate(("t", "a", "delta", "P"), start=1)]
    units = ["--unit=t=s", "--unit=a=um", "--unit=delta=um", "--unit=P=mN"]
    done = jkr("work", "gel.h5", "n.csv", *columns, *units, "--modulus-factor", "2", "--no-plots", "--json")
    (summary,) = json.loads(done.out)["results"]
    assert summary["modulus_factor"] == 2
    np.testing.assert_allclose(summary["curves"][0]["w"]["all"]["quartiles_J_per_m2"], 2 * W, rtol=5e-14)  # 2e-15


def test_bad_curves_and_bad_files_among_many(jkr: Run, measured: Path) -> None:
    rows = measured.read_text().splitlines()
    lines = ["curve," + rows[0], *("good," + row for row in rows[1:]), *(f"bad,{i},900,1,1" for i in range(4))]
    Path("map.csv").write_text("\n".join(lines) + "\n")
    done = jkr("work", "gel.h5", "map.csv", "--no-plots")
    assert done.code == 0
    skipped = (
        'map.csv: curve "bad": none of its 4 rows gives a work of adhesion: 4 at contact radii above 200 um, where it '
        "ends; are contact point and force offset (--zero), signs (--flip), units and modulus right?"
    )
    assert f"jkr: warning: skipped: {skipped}\n" in done.err
    assert json.loads(Path("map-work.json").read_text())["skipped"] == [skipped]
    assert set(table("map-work.csv")["curve"]) == {"good"}
    Path("lame.csv").write_text("\n".join([lines[0], *lines[-4:]]) + "\n")
    done = jkr("work", "gel.h5", "lame.csv", "--no-plots")
    assert (done.code, done.err) == (2, f"jkr: error: {skipped.replace('map.csv', 'lame.csv')}\n")


MISTAKES = {
    ("--window", "4"): "--window: must be an odd number of rows, at least 5, got 4",
    ("--segment", "retract"): 'm.csv: names no segments, cannot take "retract" alone',
    ("--noise", "w=1"): "invalid value for '--noise': must be KEY=VALUE with a key of a, delta, P, got \"w=1\"; "
    "see jkr work --help",
    ("--zero", "a=1"): "invalid value for '--zero': must be KEY=VALUE with a key of delta, P, got \"a=1\"; "
    "see jkr work --help",
    ("--stiffness", "0"): "invalid value for '--stiffness': must be > 0 or \"rigid\", got 0; see jkr work --help",
    ("--column", "P=lod"): 'm.csv: no single column "lod" for P (columns: 1 "t_s", 2 "a_um", 3 "delta_um", 4 "P_mN")',
    ("m.csv",): "m-work.csv: would be written twice; rename a file, or give each its own -o",
}


@pytest.mark.parametrize("flags", MISTAKES, ids=" ".join)
def test_mistakes_are_told_in_one_line(jkr: Run, measured: Path, flags: tuple[str, ...]) -> None:
    done = jkr("work", "gel.h5", measured, *flags)
    assert (done.code, done.err) == (2, f"jkr: error: {MISTAKES[flags]}\n")
    assert not list(Path().glob("m-work*"))


@pytest.mark.slow
def test_a_force_map_of_a_microscope(jkr: Run, measured: Path) -> None:
    """Offset, tilt and unknown first touch of a piezo on a spring of 50 kN/m; w as good as the touch is known."""
    afmformats = pytest.importorskip("afmformats")
    import h5py

    series = store.read_solution("gel.h5").series
    curve = transform(series, slopes(series), W)
    k = 5e4
    touched = curve.pull_off(k).a * (1 + 1e-9)
    a = np.linspace(touched, series.a[-1], 4000)
    delta, P = curve.at(a)
    end = (delta + P / k)[-1]
    piezo = np.linspace(-end / 2, end, 20001)
    load = np.where(piezo > 0, np.interp(piezo, delta + P / k, P), 0.0) + 1e-7 + 1e-3 * piezo
    back = np.interp(piezo[::-1], delta + P / k, P) + 1e-7 + 1e-3 * piezo[::-1]
    held = piezo[::-1] > (delta + P / k)[0]
    content = {
        "force": np.append(load, back[held]),
        "height (measured)": 3e-6 - np.append(piezo, piezo[::-1][held]),
        "segment": np.append(np.zeros(piezo.size, int), np.ones(held.sum(), int)),
    }
    with h5py.File("map.h5", "w") as file:
        for index in range(2):
            metadata = {"imaging mode": "force-distance", "path": "x", "enum": index, "spring constant": k}
            afmformats.AFMForceDistance(content, metadata).export_data(file, fmt="hdf5")
    done = jkr("work", "gel.h5", "map.h5", "--contact", "estimate", "--segment", "retract", "--no-plots", "--json")
    assert done.code == 0
    (summary,) = json.loads(done.out)["results"]
    assert [item["curve"] for item in summary["curves"]] == ["0", "1"]
    for item in summary["curves"]:
        # Half a step of the piezo, 0.6 nm, against a shift of some 60 nm: d(log w) = 2 d(delta)/shift
        np.testing.assert_allclose(item["w"]["all"]["median_J_per_m2"], W, rtol=0.03)
        assert item["flags"][1].startswith("contact point and force offset estimated from")


RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"


def test_a_raw_record_is_zeroed_by_its_fit(jkr: Run) -> None:
    """Read as it stands, the record says 102 J/m^2; w is 1 mJ/m^2 on its way out and 0.2 mJ/m^2 on its way in."""
    Path("gel.toml").write_text(
        '[indenter]\nshape = "sphere"\nradius = "5 um"\n[specimen.half_space]\nE = "150 kPa"\nnu = 0.5\n'
        '[loading]\nradius = "2 um"\npoints = 100\nspacing = "log"\n'
    )
    assert jkr("run", "gel.toml").code == 0
    for segment, w, other in (("retract", 1e-3, "advancing"), ("approach", 0.2e-3, "receding")):
        done = jkr("work", "gel.h5", str(RAW), "--segment", segment, "--json", "--no-plots", "-o", segment)
        assert done.code == 0
        (found,) = json.loads(done.out)["results"]
        assert found["curves"][0]["w"]["all"]["median_J_per_m2"] == pytest.approx(w, rel=0.05)
        assert found["curves"][0]["w"][other] is None
        rows = table(f"{segment}/raw-force-curve-work.csv")
        off, half = (np.array(rows[name], float) for name in ("w_J_per_m2", "w_err_J_per_m2"))
        z = 1.96 * (off - np.median(off)) / half  # the noise of the base line is that of the rows
        assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5

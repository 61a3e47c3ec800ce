"""``jkr look``: any measured file drawn and told, before any body is thought of."""

import base64
import json
import math
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CASES, Outcome, shown_at, write_table
from force_curves import Instrument, record
from raw_records import export

from jkrcli.base.errors import InputError
from jkrcli.base.files import is_ours
from jkrcli.bodies.indenters import Pyramid, RoundedCone, Sphere
from jkrcli.measured import files as measured
from jkrcli.measured.archive import UNUSABLE
from jkrcli.measured.curve_page import page
from jkrcli.measured.functions import look
from jkrcli.measured.instruments import constant_errors, constants
from jkrcli.measured.rigid import Sensitivity, mean
from jkrcli.measured.segmentation import segment_force_curve

E_STAR, R, W, K = 20e3, 5e-6, 1e-4, 0.05
FORCE = 1.5 * np.pi * W * R


@pytest.fixture
def table(tmp_path: Path) -> Path:
    device = Instrument(K, 1000, 3e-6, 4 * FORCE, 0.01 * FORCE, FORCE, pause=100)
    columns = record(E_STAR, R, 0.0, W, device, 1)
    rounded = [np.round(values, digits) for values, digits in
               ((columns["t"], 6), (columns["z"] * 1e9, 4), (columns["P"] * 1e9, 6))]  # fmt: skip
    return write_table(tmp_path / "probe.csv", "t_s,delta_nm,P_nN", *rounded)


def test_a_table_is_told_and_drawn(jkr: Callable[..., Outcome], table: Path, tmp_path: Path) -> None:
    done = jkr("look", str(table), "--stiffness", "0.05 N/m").ok
    assert done.out.startswith("adhesion force 2.37 nN, largest load 9.43 nN: ")
    assert done.out.splitlines()[1].startswith("  2100 rows of displacement, load, time; approach 100")
    assert ", dwell " in done.out
    assert "no jump into contact" in done.out
    assert "by one jump at -" in done.out
    assert {path.name for path in table.parent.iterdir()} == {"probe.csv", "probe-look.png", "probe-look.svg"}
    a = np.concatenate([np.linspace(3e-4, 7e-4, 30), np.linspace(7e-4, 3e-4, 30)])
    names = "contact radius (um),displacement (um),load (mN)"
    file = write_table(tmp_path / "lens.csv", names, 1e6 * a, 1e6 * a**2 / 1e-2, 1e3 * 2e9 * a**3)
    printed = jkr("look", str(file), "--no-plots").out
    assert "loading-unloading table" in printed
    assert "contact radius 300 um to 700 um" in printed
    assert "base line of" not in printed


def test_a_rough_w_is_that_of_the_adhesion_force(jkr: Callable[..., Outcome], table: Path) -> None:
    words = ("look", str(table), "--stiffness", "0.05 N/m", "--no-plots")
    done = jkr(*words, "--shape", "paraboloid", "--radius", "5 um")
    assert re.search(
        r"^  rough: E\* = \d+ kPa \(half-space without adhesion, largest load, a = .*\), w = ", done.out, re.M
    )
    found = jkr(*words, "--shape", "paraboloid", "--radius", "5 um", "--json").told["files"][0]["curves"][0]
    force = found["retract"]["adhesion_force_N"]
    assert found["rough"]["w_J_per_m2"] == pytest.approx(force / (1.5 * np.pi * R), rel=1e-4)
    assert "rough:" not in jkr(*words).out
    jkr(*words, "--shape", "cone").refused("look: --half-angle missing")
    volts = jkr("look", str(table), "--unit", "P=V", "--no-plots", "--radius", "5 um")
    first, _, second, *_ = volts.out.splitlines()
    assert first.startswith("adhesion force unknown, loads in arbitrary units: ")
    assert second.endswith("loads in arbitrary units, give --sensitivity and --stiffness")
    assert "no rough modulus: loads are in arbitrary units" in volts.out


@pytest.mark.parametrize("shape", ["sphere", "pyramid", "rounded-cone"])
def test_a_tip_gives_a_rough_modulus(jkr: Callable[..., Outcome], tmp_path: Path, shape: str) -> None:
    """The load of a contact of 60 kPa pressed to 300 nm, over the formula's at the depth beyond where touch is seen."""
    flags, tip = {
        "sphere": (("--radius", "5 um"), Sphere(5e-6)),
        "pyramid": (("--shape", "pyramid", "--half-angle", "35 deg"), Pyramid.of(4, math.radians(35))),
        "rounded-cone": (("--shape", "rounded-cone", "--radius", "50 nm", "--half-angle", "35 deg"),
                         RoundedCone(50e-9, math.radians(35))),
    }[shape]  # fmt: skip
    a = np.geomspace(1e-10, 5e-6 if shape == "sphere" else 1e-6, 4000)[:-1]
    delta, P = tip.half_space(a, 60e3)
    z = np.concatenate([way := np.linspace(-700, 300, 2001), way[::-1]])
    load = np.interp(z * 1e-9, delta, P, left=0.0) * 1e9
    noise = np.random.default_rng(0).normal(0, 1e-4 * load.max(), z.size)
    write_table(tmp_path / "tip.csv", "delta_nm,P_nN", z, load + noise)
    (curve,) = jkr("look", "tip.csv", *flags, "--stiffness", "rigid", "--json", "--no-plots").told["files"][0]["curves"]
    depth = 300e-9 - curve["approach"]["touch_m"]
    held, there = np.interp([300e-9, depth], delta, P)
    assert curve["rough"]["E_star_Pa"] == pytest.approx(60e3 * held / there, rel=1e-3)
    assert curve["rough"]["a_m"] == pytest.approx(np.interp(depth, delta, a), rel=1e-3)
    assert curve["rough"]["w_J_per_m2"] is None


def test_no_base_line_leaves_nothing_that_is_told_over_it(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    z = np.concatenate([way := np.linspace(0.2, 1.0, 500), way[::-1]])
    path = write_table(tmp_path / "deep.csv", "delta_um,P_nN", z, 30 * z**1.5)
    done = jkr("look", str(path), "--no-plots")
    words = "no straight base line: where contact"
    assert f"approach  {words} begins and the largest load are unknown" in done.out
    assert f"retract   {words} ends and the adhesion force are unknown" in done.out
    assert done.out.count("base line") == 4  # that there is none: the verdict, of each direction and of the record
    told = jkr("look", str(path), "--json", "--no-plots").told["files"][0]["curves"][0]["retract"]
    assert told["base_line"] is None
    assert told["touch_m"] is None
    assert told["adhesion_force_N_unknown"] == "there is no base line"


def test_a_radius_of_metres_is_remarked(jkr: Callable[..., Outcome], table: Path) -> None:
    done = jkr("fit", "--radius", "5", "--nu", "0.5", str(table), "--no-plots", "--stiffness", "0.05 N/m")
    assert done.err.startswith('jkr: warning: --radius 5 without a unit is 5 m: give its unit, --radius "5 um"\n')


@pytest.mark.parametrize(("words", "said"), [
    (("--radius", "5 um"), "fit: needs a case or solution file, or the specimen from options: --nu missing"),
    ((), "fit: needs --radius and --nu (specimen from options), or a case: jkr fit CASE MEASURED"),
    (("sphere.toml", "--radius", "5 um", "--nu", "0.5"), "from options, not both: sphere.toml and --radius, --nu"),
    (("gel.h5", "--radius", "5 um"), "from options, not both: gel.h5 and --radius"),
])  # fmt: skip
def test_a_body_is_a_file_or_flags(jkr: Callable[..., Outcome], table: Path, words: tuple[str, ...], said: str) -> None:
    """A series file was read as a measured one: "--nu missing"."""
    if "gel.h5" in words:
        assert jkr("run", CASES / "soft-gel.toml", "-o", "gel.h5", "-q").code == 0
    jkr("fit", *words, str(table)).refused(said)


def test_a_file_without_any_usable_curve_leaves_table_and_picture(jkr: Callable, tmp_path: Path) -> None:
    z = np.concatenate([np.linspace(-3, 0, 200), np.linspace(0, -3, 200)])
    path = write_table(tmp_path / "free.csv", "delta_um,P_nN", z, np.random.default_rng(1).normal(size=400))
    words = ("fit", "--radius", "5 um", "--nu", "0.5", "--contact", "fitted", str(path))
    for _ in range(2):
        jkr(*words).refused(f"{path}: no contact: the load never leaves its base line")
    assert json.loads((tmp_path / "free-fit.json").read_text())["curves"][0]["status"] == "unusable"
    assert (tmp_path / "free-fit-free.png").exists()


def test_what_is_no_measurement_is_said_to_be_none(jkr: Callable[..., Outcome], table: Path) -> None:
    """A case was told to "give --separator and --decimal", a series was "no file that afmformats reads"."""
    (table.parent / "gel.toml").write_bytes((CASES / "soft-gel.toml").read_bytes())
    assert jkr("run", "gel.toml", "-o", "gel.h5", "-q").code == 0
    for words, line in {
        ("look", "gel.toml"): "gel.toml: is a case file, no measurement",
        ("fit", "gel.toml", "gel.h5"): "gel.h5: was written by jkr (jkr-series), is no measurement",
        ("run", "gel.h5", "-o", "other.h5"): "gel.h5: is not a text file (byte 0 is not UTF-8); for the case of a "
        "solution file use jkr show --case",
    }.items():
        jkr(*words).refused(line)


def test_columns_that_are_not_what_they_should_be(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    # P_mn was left out without a word, and E* with it.
    rows = "".join(f"{i},{i * i},{i**3}\n" for i in range(1, 30))
    (tmp_path / "probe.csv").write_text(f"a_um,delta_nm,P_mn\n{rows}")
    done = jkr("fit", "--radius", "1 mm", "--nu", "0.5", "probe.csv", "--no-plots")
    line = 'column 3 "P_mn" left out: it ends in no unit of load; if it is the load: --column P=P_mn --unit P=mN'
    assert f"jkr: warning: probe.csv: {line}\n" in done.err
    assert jkr("look", "probe.csv").err.endswith(f"jkr: error: probe.csv: {line}\n")
    rows = "".join(f"{i},{i * i},{i**3}\n" for i in range(1, 12))
    (tmp_path / "probe.csv").write_text(f"a_um,delta_nm,P_nN\n{rows}")
    jkr("look", "probe.csv", "--sensitivity", "45 nm/V").refused("this file holds no volts", "--unit P=V")


def test_no_row_and_no_file_is_dropped_silently(jkr: Callable[..., Outcome], table: Path, tmp_path: Path) -> None:
    for flags in ((), ("--json",)):
        done = jkr("look", "missing.txt", table, "--no-plots", *flags)
        assert (done.code, "missing.txt" in done.err, "probe" in done.out) == (2, True, True)
    z = np.linspace(1.0, -3.0, 400)
    load = 30 * np.maximum(z, 0) ** 1.5 + 0.05 * np.random.default_rng(1).normal(size=400)
    rows = [f"{x},{P}" for x, P in zip(z, load, strict=True)]
    path = tmp_path / "back.csv"
    told = [f"{rows[0]},approach", *(f"{row},retract" for row in rows)]
    path.write_text("\n".join(["delta_um,P_nN,segment", *told]) + "\n")
    done = jkr("look", str(path), "--no-plots")
    assert "401 rows of displacement, load; approach 1, retract 400" in done.out
    assert "no approach: 1 of its rows, at least 20 are needed" in done.out
    path.write_text("\n".join(["delta_um,P_nN", *rows]) + "\n")
    assert "400 rows of displacement, load; retract 400; " in jkr("look", str(path), "--no-plots").out
    path.write_text("\n".join(["delta_um,P_nN", rows[1], *rows]) + "\n")
    assert "401 rows of displacement, load; retract 400, 1 of neither" in jkr("look", str(path), "--no-plots").out


# ---------------------------------------------------------------------- calibration
S, STIFF = 45.2e-9, 0.3
SPECIMEN = ("--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid")


def glass(path: Path, seed: int, drag: float = 0.0, bend: float = 0.0) -> Path:
    """Volts over the position of the piezo on glass; relative: ``drag`` between approach and retraction, ``bend`` by
    which the slope grows along the contact."""
    rng = np.random.default_rng(seed)
    z = np.linspace(-500e-9, 150e-9, 600)
    bent = np.concatenate([np.maximum(z, 0) * (1 + drag), (np.where(z > -10e-9, z, 0) * (1 - drag))[::-1]])
    bent *= 1 + bend * bent / (2 * z[-1])
    volts = bent / S + 0.002 * rng.normal(size=bent.size) + 0.3
    rows = "".join(f"{x * 1e9:.4f},{v:.6f}\n" for x, v in zip(np.concatenate([z, z[::-1]]), volts, strict=True))
    path.write_text(f"# spring constant: {STIFF} N/m\npiezo (nm),deflection (V)\n{rows}")
    return path


def gel(path: Path, head: str) -> Path:
    return export(path, record(2e5, 5e-6, 2e-4, 1e-3, Instrument(STIFF, 200, 1.5e-6, 40e-9, 1e-10), 1), head)


def test_drag_is_part_of_the_error_and_directions_that_differ_are_said(tmp_path: Path) -> None:
    found = look(glass(tmp_path / "glass.csv", 1, 0.01), rigid=True).rigid
    assert found.error / found.factor == pytest.approx(0.01, rel=0.1)
    assert look(glass(tmp_path / "glass.csv", 1, 0.03), rigid=True).rigid.straight is False
    assert look(glass(tmp_path / "glass.csv", 1, bend=0.2), rigid=True).rigid.straight is False
    path = glass(tmp_path / "glass.csv", 1)
    for known in ({}, {"sensitivity": "40 nm/V"}, {"sensitivity": 60e-9, "stiffness": 1.0}):
        found = look(path, rigid=True, **known).rigid
        assert found.value == pytest.approx(S, rel=2e-3)
        assert abs(found.value / S - 1) < 4 * found.error / found.factor
        assert found.straight


def test_files_on_glass_tell_one_sensitivity_and_a_gel_is_no_glass(jkr: Callable, tmp_path: Path) -> None:
    (tmp_path / "glass").mkdir()
    for seed in range(4):
        glass(tmp_path / f"glass/{seed}.csv", seed)
    done = jkr("look", "glass", "--rigid", "--no-plots")
    assert done.out.startswith('rigid specimen: --sensitivity "45.')
    told = jkr("look", "glass", "--rigid", "--no-plots", "--json").told["files"][0]["rigid"]
    assert told["value"] == pytest.approx(S, rel=1e-3)
    done = jkr("look", gel(tmp_path / "gel.csv", f"# springConstant: {STIFF}"), "--rigid", "--no-plots")
    assert "the contact is curved: the specimen is not rigid" in done.out
    assert "--factor P=" in done.out  # of loads, not of volts


def test_files_by_different_assumed_sensitivities_have_one_mean_and_its_scatter() -> None:
    """Whichever is the first: the mean is of sensitivities, not of the factors to what each file assumed."""
    found = [Sensitivity(factor, 0.001 * factor, factor * assumed, True)
             for factor, assumed in ((1.1, 40e-9), (0.75, 60e-9), (46e-9, 1.0))]  # fmt: skip
    for order in (found, found[::-1]):
        one = mean(order)
        assert one.value == pytest.approx(45e-9)
        assert one.error / one.factor == pytest.approx(1 / 45)
    with pytest.raises(InputError, match="3 of 4 force curves hold volts"):
        mean([*found, Sensitivity(1.0, 0.01, None, True)])


@pytest.mark.parametrize(
    "head",
    ["# springConstant: 0.3 ± 0.03 N/m", "# k: 0.30 +- 0.03 N/m", "# k: 0.30 +/- 10 % N/m",
     "# spring constant: 0.3 N/m\n# spring constant error: 10 %",
     "# spring constant: 0.3 N/m\n# Spring constant uncertainty: 30 mN/m"],
)  # fmt: skip
def test_an_error_in_the_header_is_read(head: str) -> None:
    lines = head.splitlines()
    assert constants(lines) == {"stiffness": pytest.approx(STIFF)}
    assert constant_errors(lines) == {"stiffness": pytest.approx(0.1)}


def test_an_error_in_the_header_is_a_part_of_the_calibration(jkr: Callable, tmp_path: Path) -> None:
    path = gel(tmp_path / "gel.csv", "# springConstant: 0.3 ± 0.03 N/m")
    for more, share in (((), 0.196), (("--uncertain", "stiffness=2%"), 0.0392)):  # 1.96 times 10 %: E* goes with k
        told = jkr("fit", path, *SPECIMEN, "--no-plots", "--json", *more).told["curves"][0]["estimates"]["E_star"]
        assert told["calibration"] == pytest.approx(share * told["value"], rel=0.02)


# ---------------------------------------------------------------------- the page to click through curves
RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"


def curves_of(text: str) -> list[dict[str, Any]]:
    return json.loads(re.search(r'<script id="curves" type="application/json">(.*?)</script>', text, re.S)[1])


def column(packed: list) -> np.ndarray:
    least, step, text = packed
    return least + step * np.frombuffer(base64.b64decode(text), "<u2")


@pytest.fixture(name="files")
def _files(jkr: Callable) -> list[str]:
    """Two records and one whose load never leaves its base line."""
    for name in ("one.txt", "two.txt"):
        shutil.copy(RAW, name)
    z = np.concatenate([way := np.linspace(0, 1, 300), way[::-1]])
    write_table("none.csv", "delta_um,P_nN", z, 1e-3 * np.random.default_rng(1).standard_normal(z.size))
    return ["one.txt", "two.txt", "none.csv"]


def test_look_leaves_a_page_of_all_curves(jkr: Callable, files: list[str]) -> None:
    done = jkr("look", *files)
    assert (done.code, "curves-look.html" in done.out) == (0, True), done.err
    text = Path("curves-look.html").read_text(encoding="utf-8")
    one, _, none = curves_of(text)
    assert is_ours(Path("curves-look.html"))
    assert "://" not in re.sub(r'<script id="curves".*?</script>', "", text, flags=re.S)  # nothing is fetched
    assert (one["name"], one["status"], none["status"]) == ("one", "no remark", "no contact")
    (curve,) = measured.read(Path("one.txt"))
    load = np.concatenate([column(line["y"]) for line in one["lines"]])
    assert [load.min(), load.max()] == pytest.approx([curve.P.min(), curve.P.max()], abs=2e-5 * np.ptp(curve.P))
    told = jkr("look", "one.txt", "--json", "--no-plots").told["files"][0]
    assert (told["format"], told["version"]) == ("jkr-look", 1)
    found = told["curves"][0]
    for direction, (place, _), (x0, y0, x1, y1) in zip(
        ("approach", "retract"), one["contact"], one["base"], strict=True
    ):
        assert place == pytest.approx(found[direction]["touch_m"], rel=1e-12)
        assert (y1 - y0) / (x1 - x0) == pytest.approx(found[direction]["base_line"]["tilt_N_per_m"], rel=1e-6)
    assert any("adhesion force" in line for line in one["words"])


def test_which_fits_and_looks_leave_a_page(jkr: Callable, files: list[str]) -> None:
    assert jkr("fit", "--radius", "5 um", "--nu", "0.5", "one.txt", "none.csv", "-o", "out").ok
    (found,) = Path("out").glob("*-curves.html")
    fitted, failed = curves_of(found.read_text(encoding="utf-8"))
    assert (fitted["status"], failed["status"]) == ("fitted", UNUSABLE)
    assert {line["kind"] for line in fitted["lines"]} == {"measured", "fitted"}
    estimates = json.loads(next(Path("out").glob("fit.json")).read_text())["curves"][0]["estimates"]
    assert fitted["contact"] == [[estimates["delta0"]["value"], estimates["P0"]["value"]]]
    assert failed["lines"]
    assert failed["words"]
    assert jkr("look", "one.txt").code == 0
    assert jkr("look", *files, "--no-plots").code == 0
    assert not list(Path().glob("*look.html"))
    Path("curves-look.html").write_text("of someone else")
    done = jkr("look", *files)
    assert (done.code, "curves-look.html" in done.err) == (2, True)
    assert Path("curves-look.html").read_text() == "of someone else"


class Many(list):
    """One curve that says to be of 4,000, which is thinned as all of them are."""

    def __len__(self) -> int:
        return 4000


def test_four_thousand_curves_make_a_small_page() -> None:
    record = segment_force_curve(measured.read(RAW)[0])
    text = page(Many([record]), "many <curves>")
    assert "many &lt;curves&gt;" in text
    (one,), (alone,) = curves_of(text), curves_of(page([record], ""))
    size, wide = (len(json.dumps(curve, ensure_ascii=False, separators=(",", ":"))) for curve in (one, alone))
    assert (4000 * size < 10e6, wide > 1.5 * size) == (True, True)
    assert sum(column(line["y"]).size for line in one["lines"]) > 150


@pytest.mark.slow
def test_four_thousand_curves_in_a_browser(tmp_path: Path, browser: Any) -> None:
    text = page([segment_force_curve(measured.read(RAW)[0])] * 4000, "many")
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    shown_at(browser, 1280)
    began = time.monotonic()
    browser.get((tmp_path / "page.html").as_uri())
    assert browser.find_element("id", "place").text == "1 of 4000"
    body = browser.find_element("tag name", "body")
    for key, place in (("n", 2), ("\ue014", 3), ("p", 2), ("\ue010", 4000), ("\ue012", 3999), ("\ue011", 1)):
        body.send_keys(key)  # arrows, End and Home by their codes
        assert browser.find_element("id", "place").text == f"{place} of 4000"
    browser.find_element("id", "next").click()
    assert browser.find_element("id", "place").text == "2 of 4000"
    assert time.monotonic() - began < 60  # no hang; a second or two on an idle machine
    colours = browser.execute_script(
        "const c = document.getElementById('picture');"
        "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data, found = new Set();"
        "for (let i = 0; i < d.length; i += 4) if (d[i + 3] === 255) found.add(`${d[i]},${d[i + 1]},${d[i + 2]}`);"
        "return [...found]"
    )
    assert {"0,114,178", "213,94,0"} <= set(colours)  # approach and retraction are drawn
    assert "contact point" in browser.find_element("id", "legend").text
    browser.find_element("id", "all").click()
    left = "return document.querySelectorAll('#thumbs canvas:not([data-drawn])').length"
    assert browser.execute_script(left) > 3000  # far below
    browser.execute_script("dispatchEvent(new Event('beforeprint'))")
    assert browser.execute_script(left) == 0
    thumbs = browser.find_elements("css selector", "#thumbs button")
    assert (len(thumbs), len(browser.find_elements("css selector", "#table tr"))) == (4000, 4001)
    thumbs[7].click()
    assert browser.find_element("id", "place").text == "8 of 4000"
    assert browser.get_log("browser") == []

"""The page to click through curves: what it holds, and in a real browser."""

import base64
import json
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import shown_at, write_table

from jkrcli.base.files import is_ours
from jkrcli.measured import files as measured
from jkrcli.measured.archive import UNUSABLE
from jkrcli.measured.curve_page import page
from jkrcli.measured.segmentation import segment_force_curve

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


def test_fit_leaves_a_page_with_what_could_not_be_fitted(jkr: Callable, files: list[str]) -> None:
    assert jkr("fit", "--radius", "5 um", "--nu", "0.5", "one.txt", "none.csv", "-o", "out").ok
    (found,) = Path("out").glob("*-curves.html")
    fitted, failed = curves_of(found.read_text(encoding="utf-8"))
    assert (fitted["status"], failed["status"]) == ("fitted", UNUSABLE)
    assert {line["kind"] for line in fitted["lines"]} == {"measured", "fitted"}
    estimates = json.loads(next(Path("out").glob("fit.json")).read_text())["curves"][0]["estimates"]
    assert fitted["contact"] == [[estimates["delta0"]["value"], estimates["P0"]["value"]]]
    assert failed["lines"]
    assert failed["words"]


def test_one_curve_and_no_plots_leave_no_page(jkr: Callable, files: list[str]) -> None:
    assert jkr("look", "one.txt").code == 0
    assert jkr("look", *files, "--no-plots").code == 0
    assert not list(Path().glob("*.html"))
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

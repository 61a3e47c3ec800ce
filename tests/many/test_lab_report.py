"""The report of a fit: whole in one file, with the reason of each curve that is left out, to be repeated."""

import contextlib
import hashlib
import html
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import MEDIA, shown_at
from force_curves import Instrument, record
from raw_records import export
from test_samples import SPECIMEN, K, R, read, write

from jkrcli.base.files import is_ours
from jkrcli.cli import call
from jkrcli.measured.grade import kind_of

WORKS = {"ctrl": 1e-3, "drug A": 2e-3, "drug<B>": 3e-3}


@pytest.fixture(name="fitted", scope="module")
def _fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three samples: one has a curve of two moduli, one a curve out of contact and a file that cannot be read."""
    folder = tmp_path_factory.mktemp("lab")
    for name, w in WORKS.items():
        (folder / name).mkdir()
        for i in range(2):
            write(folder / name / f"c{i}.txt", w * (1 + 0.1 * i), i)
    i, words = np.arange(-99, 99), np.repeat(["approach", "retract"], 99)
    export(folder / "drug<B>/free.txt", {"z": 1e-8 * np.abs(i), "P": 1e-9 * np.sin(37 * i) / 9, "segment": words})
    one, other = (record(E_star, R, 4e-4, 2e-3, Instrument(K, 250, 1.5e-6, 94e-9, 2e-10), 1) for E_star in (2e5, 1.4e5))
    export(folder / "drug A/two.txt", {name: np.append(one[name][:250], other[name][250:]) for name in one})
    (folder / "drug<B>/notes.txt").write_text("measured on Monday\n")
    words = ("fit", *SPECIMEN, "ctrl", "drug A", "drug<B>", "-o", "out", "--uncertain", "stiffness=10%", "--report")
    said = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(said):
        assert call(words) == 0
    told = said.getvalue()
    assert "report in out/report{.html,.md}" in " ".join(told.split())
    assert told.startswith("3 samples: 6 of 9 curves fitted, 3 left out (")
    assert "\n  drug A over ctrl: E* x 1.00 (" in told
    return folder


@pytest.fixture(name="report")
def _report(fitted: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(fitted)
    return Path("out/report.html").read_text(encoding="utf-8")


def test_a_report_is_whole_and_names_what_was_left_out_and_why(report: str) -> None:
    assert not re.search(r'(?:src|href)="(?:https?:|//)', report)
    assert report.count("data:image/png;base64,") == 2  # E*, w by sample
    said = html.unescape(report)
    for words in (
        "9 force curves of 3 samples", "between ctrl, drug A, drug<B>", "jkr fit --radius '5 um'", "numpy ",
        "Stiffness 0.3 N/m from the header of the file", "Standard uncertainty of stiffness: 10%.", "drug<B>/notes.txt",
        "no contact: the load never leaves its base line", "Paraboloid R = 5 um on a half-space (nu = 0.5)",
    ):  # fmt: skip
        assert words in said
    assert hashlib.sha256(Path("ctrl/c0.txt").read_bytes()).hexdigest() in said
    assert "1 MPa" not in said  # which stands for a modulus that nobody gave
    (row,) = re.findall(r'href="(fit-curves\.html#\d+)">free<', report)
    assert row == "fit-curves.html#8"  # its place on the page of all curves
    values = re.search(
        r'fit-curves\.html#1">c0</a></td><td>([\w ]+)</td><td>([\d.]+)</td><td>([\d.]+) to ([\d.]+)<', report
    )
    assert float(values[3]) < float(values[2]) < float(values[4])  # E* of the first curve, with its interval
    assert all(is_ours(Path("out", name)) for name in ("report.html", "report.md", "samples.csv", "samples.png"))


def test_samples_have_means_and_ratios_in_which_one_cantilever_cancels(report: str) -> None:
    rows = read("out/samples.csv")
    assert [(row["sample"], row["curves"], row["fitted"]) for row in rows] == [
        ("ctrl", "2", "2"), ("drug A", "3", "2"), ("drug<B>", "4", "2"),
    ]  # fmt: skip
    for row in rows:
        assert float(row["w_low_J_per_m2"]) < 1.05 * WORKS[row["sample"]] < float(row["w_high_J_per_m2"])
        assert float(row["E_star_calibration_relative"]) == pytest.approx(0.196, rel=0.02)
    assert float(rows[1]["w_ratio"]) == pytest.approx(2, rel=0.02)
    assert 0 < float(rows[1]["w_ratio_calibration"]) < 1e-3
    assert json.loads(Path("out/fit.json").read_text())["samples"]["differences"]["w"][0]["against"] == "ctrl"


def test_a_curve_is_left_out_for_one_reason_wherever_it_is_told(report: str) -> None:
    """A curve whose directions differ, one out of contact, a file that cannot be read: table, samples, report, page."""
    rows = [row for row in read("out/fit.csv") if row["status"] != "fitted"]
    assert [(row["curve"], row["grade"]) for row in rows] == [
        ("two", "look at it"), ("free", "not usable"), ("notes", "not usable"),
    ]  # fmt: skip
    assert [row["reason"] for row in rows] == [row["grade_reason"] for row in rows]
    assert rows[1]["reason"] == "no contact: the load never leaves its base line"
    assert rows[2]["reason"].startswith("not read: ")
    said = html.unescape(report)
    why = {row["sample"]: row["why"] for row in read("out/samples.csv")}
    assert why == {"ctrl": "", "drug A": f"1 {kind_of(rows[0]['reason'])}", "drug<B>": "1 no contact; 1 not read"}
    page = json.loads(re.search(r'<script id="curves" type="application/json">(.*?)</script>',
                                Path("out/fit-curves.html").read_text(encoding="utf-8"), re.S)[1])  # fmt: skip
    grades = {curve["name"]: curve["grade"] for curve in page}
    assert grades["two"] == [rows[0]["grade"], rows[0]["reason"]]
    assert [grades[name] for name in ("free", "notes")] == [["not usable", "no contact"], ["not usable", "not read"]]
    assert json.loads(Path("out/fit.json").read_text())["curves"][-1]["grade_reason"] == rows[2]["reason"]
    for row in rows:
        assert f"<td>{row['reason']}</td>" in said


@pytest.mark.parametrize(
    ("reason", "kind"),
    [("no contact: the load never leaves its base line", "no contact"), ("w ± more than tenfold", "w uncertain"),
     ("E* is not determined, its standard error is 1.4 times its value: fix w", "E* is not determined"),
     ("misfit 12 % of the pull-off force", "misfit of the pull-off force")],
)  # fmt: skip
def test_reasons_are_counted_by_their_kind(reason: str, kind: str) -> None:
    assert kind_of(reason) == kind


def test_the_report_in_markdown_says_the_same(report: str) -> None:
    text = Path("out/report.md").read_text(encoding="utf-8")
    assert re.findall(r"<h2>(.*?)</h2>", report) == re.findall(r"^## (.*)$", text, re.M)
    assert "![E*, w of each sample](samples.png)" in text
    rows = [line.count("|") for line in text.splitlines() if line.startswith("| ")]
    assert rows.count(4) == 5  # head and three curves that were left out


@pytest.mark.slow
@pytest.mark.parametrize(("media", "width"), MEDIA)
def test_report_and_page_of_curves_fit_a_phone_a_screen_and_paper(report, browser, media, width) -> None:
    shown_at(browser, width, media)
    for page in ("report.html", "fit-curves.html#8"):
        browser.get(Path("out").absolute().as_uri() + f"/{page}")
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width, page
    if media == "screen":  # paper has all curves, small
        assert browser.find_element("id", "place").text == "8 of 9"  # the curve that the report points to
        assert browser.find_element("id", "picture").size["width"] > 0.6 * width
    assert browser.get_log("browser") == []

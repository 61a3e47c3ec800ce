"""Samples of a fit: means and differences by classical formulas, results of several inputs, their report."""

import contextlib
import csv
import hashlib
import html
import io
import json
import math
import re
import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from conftest import MEDIA, shown_at
from force_curves import Instrument, record
from raw_records import export
from scipy import stats

from jkrcli.base.files import is_ours
from jkrcli.cli import call
from jkrcli.many.samples import Samples, difference, shown, spread_of
from jkrcli.measured.grade import kind_of

R, K = 5e-6, 0.3
SPECIMEN = ("--radius", "5 um", "--nu", "0.5", "--shape", "paraboloid")
WORKS = {"ctrl": 1e-3, "drug": 2e-3}


def write(path: Path, w: float, seed: int, radius: float = R, far: float = 1.5e-6) -> None:
    force = 1.5 * math.pi * w * radius
    made = record(2e5, radius, 0.2 * w, w, Instrument(K, 250, far, 2 * force, 0.005 * force), seed)
    export(path, made)


@pytest.fixture(name="folders")
def _folders(tmp_path: Path) -> list[str]:
    for name, w in WORKS.items():
        (tmp_path / name).mkdir()
        for i in range(3):
            write(tmp_path / name / f"c{i}.txt", w * (1 + 0.05 * i), i)
    i = np.arange(-99, 99)
    words = np.where(i > 0, "retract", "approach")
    export(tmp_path / "drug/free.txt", {"z": 1e-8 * np.abs(i), "P": 1e-9 * np.sin(37 * i) / 9, "segment": words})
    return [*WORKS]


def read(path: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(path).read_text().splitlines()))


def table(**samples: list[float]) -> Mapping[str, list]:
    rows = [(name, value) for name, values in samples.items() for value in values]
    return {"sample": [name for name, _ in rows], "status": ["fitted"] * len(rows), "w_J_per_m2": [w for _, w in rows],
            "level": [0.95] * len(rows)}  # fmt: skip


@pytest.mark.parametrize(
    ("value", "said"),
    [(0.98377, "0.984"), (18.0, "18.0"), (202.4, "202"), (999.7, "1000"), (1.5, "1.50"), (1e-5, "1e-05")],
)
def test_values_have_three_digits(value: float, said: str) -> None:
    assert shown(value) == said


def test_the_mean_of_logarithms_has_the_interval_of_student() -> None:
    values = np.array([1.0, 2.0, 4.0, 8.0])
    one = spread_of(values, {"calibration": 0.1}, 0.9)
    assert one.mean == pytest.approx(math.sqrt(8))
    low, high = stats.t.interval(0.9, 3, np.log(values).mean(), stats.sem(np.log(values)))
    assert one.interval == pytest.approx((math.exp(low), math.exp(high)))
    assert (one.median, one.common) == (3.0, {"calibration": 0.1})


def test_a_value_of_zero_has_no_geometric_mean() -> None:
    one = spread_of(np.array([0.0, 1.0, 2.0]), {}, 0.95)
    assert (one.mean, one.interval, one.median) == (None, None, 1.0)


def test_a_ratio_has_the_interval_of_welch_and_what_does_not_cancel_widens_it() -> None:
    rng = np.random.default_rng(3)
    x, y = np.exp(rng.normal(1, 0.2, 9)), np.exp(rng.normal(0, 0.6, 30))
    one = difference(("x", "y"), x, y, 0.95)
    test = stats.ttest_ind(np.log(x), np.log(y), equal_var=False)
    assert np.log(one.interval) == pytest.approx(tuple(test.confidence_interval(0.95)), rel=1e-6)
    assert one.ratio == pytest.approx(stats.gmean(x) / stats.gmean(y))
    half = float(np.diff(np.log(one.interval))[0]) / 2
    own = difference(("x", "y"), x, y, 0.95, {"calibration": 0.3, "model": 0.1})
    assert float(np.diff(np.log(own.interval))[0]) / 2 == pytest.approx(math.hypot(half, 0.3, 0.1))
    parts = {"statistical": half, "calibration": 0.3, "model": 0.1}
    assert own.parts == pytest.approx({kind: own.ratio * math.sinh(part) for kind, part in parts.items()})


def test_hedges_g_of_one_pooled_deviation() -> None:
    """Logs 0, 2 and 1, 3: a pooled standard deviation of sqrt(2), a difference of 1, J = 1 - 3/7."""
    one = difference(("x", "y"), np.exp([1.0, 3.0]), np.exp([0.0, 2.0]), 0.95)
    g = (1 - 3 / 7) / math.sqrt(2)
    assert one.g == pytest.approx(g)
    assert one.g_interval[1] - g == pytest.approx(1.959964 * math.sqrt(1 + g**2 / 8), rel=1e-6)


def test_what_does_not_scatter_has_a_ratio_and_no_standardised_difference() -> None:
    one = difference(("x", "y"), np.array([2.0, 2.0]), np.array([1.0, 1.0]), 0.95)
    assert (one.ratio, one.interval, one.g, one.g_interval) == (2.0, (2.0, 2.0), None, None)


def test_intervals_of_all_pairs_hold_together_and_a_common_factor_cancels() -> None:
    samples = {"a": [1.0, 1.1, 1.3], "b": [2.0, 2.2, 2.1], "c": [3.0, 3.9, 3.3]}
    found = Samples(table(**samples), [{("w", "calibration", "stiffness"): 0.1}] * 9)
    pairs = {(one.sample, one.against): one for one in found.differences["w"]}
    assert list(pairs) == [("b", "a"), ("c", "a"), ("c", "b")]
    alone = difference(("b", "a"), *(np.array(samples[name]) for name in "ba"), 1 - 0.05 / 3)
    assert pairs["b", "a"].interval == pytest.approx(alone.interval)
    twice = Samples(table(**{name: [1.2 * w for w in values] for name, values in samples.items()}))
    assert [one.ratio for one in twice.differences["w"]] == pytest.approx([one.ratio for one in pairs.values()])
    assert pairs["b", "a"].parts["calibration"] == 0
    assert found.words()[0].endswith("; beside these: calibration ± 10 % of w")
    assert "beside" not in twice.words()[0]


def test_of_a_common_error_a_ratio_holds_what_it_changes_in_one_sample_more() -> None:
    """Half-widths with their signs: means of 0.1 and 0.3 leave 0.2 of one sensitivity, of two tips both; a cause of the
    other sign adds; the sign of a misfit is unknown."""
    by = [(0.05, 0.0, 0.02), (0.15, 0.2, -0.02), (0.3, 0.1, 0.04), (0.3, 0.1, 0.04)]
    causes = [{("w", "calibration", "sensitivity"): s, ("w", "model", "misfit"): m, ("w", "model", "strains"): large,
               ("E_star", "calibration", "sensitivity"): 9.0} for s, m, large in by]  # fmt: skip
    values = table(a=[1.0, 1.2], b=[3.0, 3.3])
    one = Samples(values, causes, ["misfit"])
    assert one.common("w", "a") == pytest.approx({"calibration": 0.1, "model": 0.1})
    assert one.common("w", "b", "a") == pytest.approx({"calibration": 0.2, "model": math.hypot(0.1, 0.1, 0.04)})
    two = Samples(values, causes, ["misfit", "sensitivity"])
    assert two.common("w", "b", "a")["calibration"] == pytest.approx(math.hypot(0.1, 0.3))


def test_an_error_of_the_sensitivity_moves_a_ratio_of_unlike_specimens_as_it_says(jkr, tmp_path: Path) -> None:
    """Deflections in volts on a soft and a stiff specimen, fitted with 5 % more and less of the sensitivity."""
    for name, E_star in (("soft", 5e4), ("stiff", 4e5)):
        (tmp_path / name).mkdir()
        for i in range(2):
            made = record(E_star, R, 2e-4, 1e-3, Instrument(K, 250, 1.5e-6, 60e-9, 1e-10), i)
            export(tmp_path / name / f"{i}.txt", made | {"P": 1e-9 * made["P"] / K / 40e-9}, signal="deflection (V)")

    def ratios(sensitivity: float) -> dict[str, float]:
        assert jkr("fit", *SPECIMEN, "soft", "stiff", "--sensitivity", f"{sensitivity} nm/V", "--no-plots", "--force",
                   "--uncertain", "sensitivity=5%", "--uncertain", "stiffness=10%", "-o", "out").ok  # fmt: skip
        return {name: float(value) for name, value in read("out/samples.csv")[1].items() if "_ratio" in name}

    here, low, high = (ratios(40 * factor) for factor in (1, 0.95, 1.05))
    for name in ("E_star", "w"):
        moved = 1.96 * abs(math.log(high[f"{name}_ratio"] / low[f"{name}_ratio"])) / 2
        told = here[f"{name}_ratio"] * math.sinh(moved)
        assert here[f"{name}_ratio_calibration"] == pytest.approx(told, rel=0.05, abs=1e-3)
    assert here["E_star_ratio_calibration"] > 0.03 * here["E_star_ratio"]
    parts = [here[f"E_star_ratio_{kind}"] / here["E_star_ratio"] for kind in ("statistical", "calibration", "model")]
    whole = math.log(here["E_star_ratio_high"] / here["E_star_ratio"])
    assert whole == pytest.approx(math.hypot(*map(math.asinh, parts)))


def test_errors_of_two_cantilevers_do_not_cancel(jkr, folders: list[str], tmp_path: Path) -> None:
    for path in (tmp_path / "drug").glob("c*.txt"):
        path.write_text(path.read_text().replace(f"springConstant: {K}", "springConstant: 0.31"))
    words = ("--no-plots", "-o", "results", "--uncertain", "stiffness=10%")
    assert jkr("fit", *SPECIMEN, *folders, *words).code == 0
    ratio = read("results/samples.csv")[1]
    told = math.asinh(float(ratio["w_ratio_calibration"]) / float(ratio["w_ratio"]))
    assert told == pytest.approx(0.196 * math.sqrt(2), rel=0.05)


def test_results_of_another_selection_are_replaced_by_force_alone(jkr, folders: list[str]) -> None:
    words = ("fit", *SPECIMEN, "--no-plots", "-o", "results")
    assert jkr(*words, *folders).code == 0
    assert jkr(*words, *folders).code == 0  # the same again
    before = Path("results/fit.csv").read_text()
    Path("more").mkdir()
    shutil.copy("ctrl/c0.txt", "more")
    done = jkr(*words, "ctrl", "more")
    assert (done.code, "holds results of other inputs (../drug)" in done.err) == (2, True), done.err
    assert Path("results/fit.csv").read_text() == before
    assert jkr(*words, "ctrl", "more", "--force").code == 0
    one = jkr("fit", *SPECIMEN, "--no-plots", "more", "-o", "results")
    assert (one.code, Path("results/more-fit.csv").exists()) == (0, True), one.err


def test_samples_by_name_and_folders_in_a_folder(jkr, folders: list[str]) -> None:
    Path("day").mkdir()
    for name in folders:
        shutil.move(name, "day")
    assert jkr("fit", *SPECIMEN, "--no-plots", "day", "-o", "out").code == 0
    rows = read("out/day-samples.csv")
    assert [row["sample"] for row in rows] == folders
    words = ("fit", *SPECIMEN, "--no-plots", "day/ctrl", "-o", "out", "--sample")
    assert jkr(*words, r"c(\d)\.txt").code == 0
    assert [row["sample"] for row in read("out/ctrl-samples.csv")] == ["0", "1", "2"]
    done = jkr(*words, "plate")
    assert (done.code, 'c0.txt: has no sample, --sample "plate" finds nothing' in done.err) == (2, True), done.err


def test_samples_named_by_headers_or_a_column_need_no_option(jkr, folders: list[str], tmp_path: Path) -> None:
    Path("all").mkdir()
    rows, head = list[str](), ""
    for name in folders:
        for i in range(2):
            note, head, *lines = (tmp_path / name / f"c{i}.txt").read_text().splitlines()
            Path(f"all/{name}{i}.txt").write_text("\n".join([note, f"# Sample: {name} ", head, *lines]))
            rows += [f"{line},{name}{i},{name}" for line in lines]
    Path("table.csv").write_text("\n".join(["# springConstant: 0.3", f"{head},curve,sample", *rows]))
    Path("all/zz.txt").write_text("no table")
    for given, left in (("all", [["unknown", "1", "0"]]), ("table.csv", [])):
        done = jkr("fit", *SPECIMEN, "--no-plots", given, "-o", "out").ok
        found = read(f"out/{Path(given).stem}-samples.csv")
        assert [[row[key] for key in ("sample", "curves", "fitted")] for row in found] == [
            ["ctrl", "2", "2"], ["drug", "2", "2"], *left,
        ]  # fmt: skip
        assert "which are not read" not in done.err


def test_each_folder_by_its_own_tip(jkr, tmp_path: Path) -> None:
    tips = {"small": 2e-6, "large": 10e-6}
    for name, radius in tips.items():
        (tmp_path / name).mkdir()
        for i in range(2):
            write(tmp_path / name / f"{i}.txt", 1e-3, i, radius)
    by_tip = [word for radius in tips.values() for word in ("--tip-radius", f"{radius * 1e6:g} um")]
    words = ("fit", *SPECIMEN, *tips, *by_tip, "--no-plots", "--uncertain")
    assert jkr(*words, "stiffness=10%", "-o", "shared").code == 0
    assert jkr(*words, "radius=10%", "-o", "out").ok
    rows = read("out/fit.csv")
    np.testing.assert_allclose([float(row["E_star_Pa"]) for row in rows], 2e5, rtol=0.03)
    np.testing.assert_allclose([float(row["w_J_per_m2"]) for row in rows], 1e-3, rtol=0.03)
    ratio = read("out/samples.csv")[1]
    assert float(ratio["w_ratio_high"]) - float(ratio["w_ratio_low"]) > 0.3  # each tip has an error of its own


THREE = {"ctrl": 1e-3, "drug A": 2e-3, "drug<B>": 3e-3}


@pytest.fixture(name="fitted", scope="module")
def _fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three samples: one has a curve of two moduli, one a curve out of contact and a file that cannot be read."""
    folder = tmp_path_factory.mktemp("lab")
    for name, w in THREE.items():
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
    with contextlib.chdir(folder), contextlib.redirect_stdout(said), pytest.MonkeyPatch.context() as patch:
        patch.setattr("jkrcli.report.plots.DPI", 40)
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
        assert float(row["w_low_J_per_m2"]) < 1.05 * THREE[row["sample"]] < float(row["w_high_J_per_m2"])
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

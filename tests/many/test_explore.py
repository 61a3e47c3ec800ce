"""``jkr explore``: the page holds the curve's own rule, loads nothing, and is refused where it cannot be made."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CASES
from every_verb import write_inputs
from scipy.interpolate import CubicHermiteSpline

from jkrcli.adhesion.curve import AdhesiveCurve
from jkrcli.base.errors import installs
from jkrcli.base.files import is_ours
from jkrcli.base.numerics import DRAWN
from jkrcli.case import store
from jkrcli.many.explorer import payload
from jkrcli.measured.curve import Curve
from jkrcli.resolve.analysis import adhesive, analyse, nonadhesive

pytest.importorskip("plotly")
ROUND_OFF = 1e-13  # logs, splines and exponentials of both sides, a few rounding errors each
# Cubics through entries that are a sixteenth of an interval apart; those of "loocv" have bends of their own between.
BETWEEN = {"auto": 1e-7, "integral": 1e-7, "loocv": 1e-5}


@pytest.fixture(name="gel")
def _gel(jkr: Callable, tmp_path: Path) -> Path:
    write_inputs(tmp_path, jkr)
    return tmp_path / "gel.h5"


def content(path: Path) -> dict[str, Any]:
    """What the page at ``path`` was given."""
    found = re.search(r'<script id="content" type="application/json">(.*?)</script>', path.read_text())
    return json.loads(found[1])


def evaluated(held: dict[str, Any], a: np.ndarray, w: float, factor: float) -> tuple[np.ndarray, np.ndarray]:
    """delta and P as the page has them: cubics through its table, then Eq. 13 at unit modulus."""
    table = held["table"]
    delta, P, S, t = (
        CubicHermiteSpline(table["a"], table[name], table[f"d{name}"])(a) for name in ("delta", "P", "S", "t")
    )
    q = np.sqrt(w / factor)
    return delta - q * t, factor * (P - q * S * t)


@pytest.mark.parametrize(
    ("slopes", "w", "factor"), [("auto", 0.2, 0.3), ("integral", 0.004, 7.0), ("loocv", 0.035, 1.0)]
)
def test_the_table_is_the_curve(gel: Path, slopes: str, w: float, factor: float) -> None:
    stored = store.read_solution(gel)
    body = nonadhesive(stored, slopes)  # without the points that are solved for one w
    held = payload(adhesive(stored, body, 0.04), [])
    curve = AdhesiveCurve(body.scaled(factor), w)
    for at, off in ((curve.a, ROUND_OFF), (np.geomspace(curve.a[0], curve.a[-1], 37), BETWEEN[slopes])):
        for ours, theirs in zip(evaluated(held, at, w, factor), curve.at(at), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=off * np.abs(theirs).max())


@pytest.mark.parametrize(("w", "factor"), [(0.035, 1.0), (0.2, 0.3)])
def test_the_band_is_the_curves(gel: Path, w: float, factor: float) -> None:
    stored = store.read_solution(gel)
    held = payload(analyse(stored, [0.04], "integral")[0], [])
    curve = analyse(stored, [w], "integral", factor)[0].curve
    powers = np.sqrt(w / factor) ** np.arange(3)
    for name, by in (("delta", 1.0), ("P", factor)):
        # S and S' correlate: the terms cancel to 1e-7 of their size, so half the digits of the width are left
        np.testing.assert_allclose(by * np.sqrt(powers @ held["band"][name]), curve.errors[name], rtol=1e-7)


def test_the_page_is_whole(jkr: Callable, gel: Path) -> None:
    outcome = jkr("explore", "gel.h5", "--w", "40 mJ/m^2").ok
    assert outcome.err == ""
    page = gel.with_name("gel-explore.html")
    assert outcome.out.splitlines()[0] == "100 points: gel.h5"
    assert page.stat().st_size < 6e6
    assert is_ours(page)
    text = page.read_text()
    assert "default-src 'none'" in text  # the browser itself refuses any network
    own = text[: text.index("plotly.js v")]  # the library comes last
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)|url\(|@import|https?:""", own)
    assert "{{" not in own
    assert content(page)["controls"]["w"]["value"] == 0.04
    assert jkr("explore", "gel.h5").code == 0  # ours: replaced without --force
    assert content(page)["controls"]["w"]["value"] == 0.035


def test_the_reading_options_hold(jkr: Callable, gel: Path) -> None:
    Path("one.csv").write_text("depth;force\n" + "".join(f"{i},5;{i}0\n" for i in range(1, 7)))
    words = ["--column", "delta=depth", "--column", "P=force", "--unit", "delta=um", "--unit", "P=uN", "--flip", "P"]
    outcome = jkr("explore", "gel.h5", "one.csv", *words).ok
    assert outcome.err == ""
    (curve,) = content(gel.with_name("gel-explore.html"))["measured"]
    assert curve["delta"] == pytest.approx([(i + 0.5) * 1e-6 for i in range(1, 7)])
    assert curve["P"] == pytest.approx([-i * 1e-5 for i in range(1, 7)])


def test_many_points_are_thinned(gel: Path) -> None:
    rows = np.linspace(1e-6, 2e-6, 3 * DRAWN)
    held = payload(analyse(store.read_solution(gel), [0.04])[0], [Curve("long", delta=rows, P=rows)])
    assert held["measured_points"] == 3 * DRAWN
    assert len(held["measured"][0]["P"]) == DRAWN
    assert held["measured"][0]["P"][:2] == [rows[0], rows[3]]


def test_a_title_cannot_end_the_script(jkr: Callable, gel: Path) -> None:
    case = jkr("show", "--case", "gel.h5").out
    title = "</script><script>alert(1)</script>{{library}}"
    Path("evil.toml").write_text(re.sub(r'title = ".*"', f'title = "{title}"', case))
    assert jkr("run", "evil.toml").code == 0
    assert jkr("explore", "evil.h5").code == 0
    assert content(Path("evil-explore.html"))["title"] == title


def test_without_a_work_one_is_found_whose_pull_off_is_seen(jkr: Callable, gel: Path) -> None:
    case = jkr("show", "--case", "gel.h5").out
    Path("bare.toml").write_text(case[: case.index("[adhesion]")])
    assert jkr("run", "bare.toml").code == 0
    w = jkr("explore", "bare.h5", "--json").told["w_J_per_m2"]
    found = jkr("pull-off", "bare.h5", "--w", w, "--json").told
    third = store.read_solution(Path("bare.h5")).increments.a[100 // 3]
    # w has two digits; the radius of pull-off goes with w^(1/3) to w^(1/2)
    assert found["results"][0]["controls"][0]["pull_off"]["a_m"] == pytest.approx(third, rel=0.03, abs=0)


def test_work_of_a_soft_gel_ends_where_it_wets(jkr: Callable) -> None:
    """2 Ups = 20 mN/m; the page says the angle at the edge, and where there is none."""
    assert jkr("explore", CASES / "soft-gel.toml", "--w", "5 mJ/m^2", "-o", "look.html").code == 0
    held = content(Path("look.html"))
    assert held["controls"]["w"]["high"] == pytest.approx(20e-3)
    assert (held["tension"], held["angle"]) == (10e-3, 0.5)


def test_wrong_input_foreign_files_and_a_missing_library_are_one_line(jkr, gel, monkeypatch) -> None:
    jkr("explore", "gel.h5", "--w", "0").refused("--w must be > 0 J/m^2")
    jkr("explore", "gel.h5", "no.csv").refused("table not found")
    assert not gel.with_name("gel-explore.html").exists()
    Path("gel-explore.html").write_text("<!doctype html><p>my notes on jkr")
    jkr("explore", "gel.h5").refused("gel-explore.html: exists and was not written by jkr")
    assert jkr("explore", "gel.h5", "--force").code == 0
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    jkr("explore", "gel.h5").refused(f"explore: needs the optional package plotly: {installs('explore')}")


def test_a_flat_punch_is_not_drawn(jkr: Callable) -> None:
    Path("punch.toml").write_text(
        'indenter = { shape = "flat", radius = 1e-3 }\nspecimen.half_space = { E = 1e6, nu = 0.5 }\n'
        "loading.radius = 1e-3\nadhesion.w = 0.05\n"
    )
    jkr("run", "punch.toml")
    assert "draws no full end" in jkr("explore", "punch.h5").err

"""The explorer in a real browser: its numbers are the command line's, it works by keyboard and on a narrow window."""

import shlex
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CASES, MEDIA, shown_at

from jkrcli.report.tables import read_curve

pytest.importorskip("plotly")
pytestmark = pytest.mark.slow
CONTROLS = ("load", "displacement", "machine")  # in the order of the page's command


@pytest.fixture(name="opened", params=["gel", "halfspace", "coating"])
def _opened(jkr: Callable, browser: Any, request: pytest.FixtureRequest) -> Any:
    Path("measured.csv").write_text("delta_m,P_N\n" + "".join(f"{i}e-8,{i}e-6\n" for i in range(1, 9)))
    assert jkr("run", CASES / f"{request.param}.toml", "--method", "layered", "-o", "body.h5").code == 0
    return _open(jkr, browser, "body.h5", "measured.csv")


def _open(jkr: Callable, browser: Any, *words: str) -> Any:
    shown_at(browser, 1300)
    assert jkr("explore", *words, "-o", "page.html").code == 0
    browser.get(Path("page.html").absolute().as_uri())
    return browser


def settled(browser: Any) -> None:
    """Wait until what was typed is drawn."""
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")


def press(browser: Any, name: str, key: str, times: int) -> None:
    """Keys on a slider, as a user without a mouse would."""
    browser.find_element("id", f"{name}-slider").send_keys(key * times)
    settled(browser)


def pull_offs(browser: Any) -> dict[str, dict[str, float] | None]:
    """P, delta, a [SI] of each row of the table; None where it says that there is none."""
    found: dict[str, dict[str, float] | None] = {}
    for name in CONTROLS:
        cells = browser.find_elements("css selector", f"#pull-off-{name} td")
        values = [cell.get_attribute("data-value") for cell in cells]
        keys = ("P_N", "delta_m", "a_m")
        found[name] = None if values == [None] else dict(zip(keys, map(float, values), strict=True))
    return found


LEFT, RIGHT = "\ue012", "\ue014"
POSITIONS = [  # keys pressed one after the other on w, modulus factor, stiffness
    (0, 0, 0), (RIGHT * 40, 0, 0), (0, LEFT * 77, 0), (0, 0, RIGHT * 120), (LEFT * 160, 0, 0),
    (0, RIGHT * 250, 0), (0, 0, LEFT * 300), (RIGHT * 190, LEFT * 30, RIGHT * 60),
    (LEFT * 333, 0, 0), (0, 0, LEFT * 150),
]  # fmt: skip


def test_ten_positions_equal_the_command_line(jkr: Callable, opened: Any) -> None:
    seen = set()
    for keys in POSITIONS:
        for name, pressed in zip(("w", "factor", "stiffness"), keys, strict=True):
            if pressed:
                press(opened, name, pressed, 1)
        command = opened.find_element("id", "commands").text.splitlines()[1]
        program, *words = shlex.split(command)
        assert program == "jkr"
        results = jkr(*words, "--json").told["results"][0]["controls"]
        ours = pull_offs(opened)
        for name, theirs in zip(CONTROLS, results, strict=True):
            if theirs["pull_off"]["P_N"] is None:
                assert ours[name] is None
                continue
            P, solved = ours[name]["P_N"], theirs["pull_off"]["P_N"]
            script = "return pointError(arguments[0], window.explorer.curve.w / window.explorer.curve.factor)"
            stated = opened.execute_script(script, name) or 0.0
            assert abs(P / solved - 1) <= max(stated, 1e-11), (command, name)  # the command solves the point
            for key in ("delta_m", "a_m"):  # an order less: P is stationary there
                assert ours[name][key] == pytest.approx(theirs["pull_off"][key], rel=1e-3, abs=0), (command, name)
        seen.add(command)
    assert len(seen) == len(POSITIONS)


def test_saves_what_transform_writes(jkr: Callable, opened: Any) -> None:
    press(opened, "factor", RIGHT, 31)
    command = opened.find_element("id", "commands").text.splitlines()[0]
    assert jkr(*shlex.split(command)[1:], "--no-plots").code == 0
    for old in opened.downloads.iterdir():
        old.unlink()
    opened.find_element("id", "save-csv").click()
    for _ in range(100):
        if saved := list(opened.downloads.glob("*.csv")):
            break
        time.sleep(0.05)
    theirs = Path.cwd() / saved[0].name  # by the same name
    ours_words, their_words = (
        [line.split(",")[-2:] for line in path.read_text().splitlines()] for path in (saved[0], theirs)
    )
    assert ours_words == their_words
    ours, expected = read_curve(saved[0]), read_curve(theirs)
    assert list(ours) == list(expected)
    for name, values in expected.items():
        np.testing.assert_allclose(ours[name], values, rtol=0, atol=1e-13 * np.abs(values).max(), err_msg=name)


def test_a_band_and_typed_numbers(jkr: Callable, browser: Any) -> None:
    assert jkr("run", CASES / "gel.toml", "-o", "body.h5").code == 0
    _open(jkr, browser, "body.h5", "--slopes", "integral")
    field = browser.find_element("id", "w")
    field.send_keys("\ue009a\ue000" + "41.5")  # Control-A: all of it is replaced
    settled(browser)
    transform = browser.find_element("id", "commands").text.splitlines()[0]
    assert transform == 'jkr transform body.h5 --w "41.5 mJ/m^2" --slopes integral'
    names = browser.execute_script("return document.getElementById('load-plot').data.map((trace) => trace.name)")
    assert "95 % band" in names
    before = pull_offs(browser)
    field.send_keys("x")
    settled(browser)
    assert field.get_attribute("aria-invalid") == "true"
    assert pull_offs(browser) == before  # nothing is drawn of what is no number


def test_zero_points_and_the_machines_give_move_the_data(jkr: Callable, opened: Any) -> None:
    def drawn() -> tuple[np.ndarray, np.ndarray]:
        script = (
            "const trace = document.getElementById('load-plot').data.find((t) => t.name === 'measured');"
            "const axes = document.getElementById('load-plot').layout;"
            "return [trace.x, trace.y, axes.xaxis.title.text, axes.yaxis.title.text]"
        )
        x, y, across, up = opened.execute_script(script)
        return np.array(x) * _unit(across), np.array(y) * _unit(up)

    i = np.arange(1, 9)
    np.testing.assert_allclose(drawn(), (i * 1e-8, i * 1e-6), rtol=1e-12)
    press(opened, "delta0", RIGHT, 100)
    press(opened, "P0", LEFT, 50)
    shifts = [_si(opened, name) for name in ("delta0", "P0")]
    assert shifts[0] > 0 > shifts[1]
    P = i * 1e-6 + shifts[1]
    np.testing.assert_allclose(drawn(), (i * 1e-8 + shifts[0], P), rtol=1e-10)
    opened.find_element("id", "recorded").send_keys(" ")
    settled(opened)
    np.testing.assert_allclose(drawn(), (i * 1e-8 + shifts[0] - P / _si(opened, "stiffness"), P), rtol=1e-8)


def _unit(title: str) -> float:
    return {"m": 1e-3, "µ": 1e-6, "n": 1e-9, "p": 1e-12}[title.split("(")[1][0]]


def _si(browser: Any, name: str) -> float:
    return float(browser.execute_script(f"return controls.{name}.value"))


def test_works_by_keyboard_alone(opened: Any) -> None:
    """Every control is reached by Tab, has a name, and is not hidden where it has the focus."""
    shown_at(opened, 400)
    reached = []
    for _ in range(40):
        opened.switch_to.active_element.send_keys("\ue004")
        focused = opened.switch_to.active_element
        if focused.tag_name == "body":
            break
        name = focused.get_attribute("id") or focused.get_attribute("name")
        assert focused.accessible_name, name
        over = opened.execute_script(
            "const box = arguments[0].getBoundingClientRect();"
            "const at = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);"
            "return arguments[0] === at || arguments[0].contains(at)", focused)  # fmt: skip
        assert over, f"{name} is hidden"
        reached.append(name)
    sliders = {f"{name}-slider" for name in ("w", "factor", "stiffness", "delta0", "P0")}
    fields = {"w", "factor", "stiffness", "delta0", "P0"}
    assert sliders | fields | {"position", "recorded", "save-csv", "save-picture", "reset", "copy"} <= set(reached)
    assert {"control", "view"} <= set(reached)
    assert opened.get_log("browser") == []


@pytest.mark.parametrize(("media", "width"), [*MEDIA, ("screen", 320), ("screen", 800)])
def test_fits_any_window_and_paper(opened: Any, media: str, width: int) -> None:
    shown_at(opened, width, media)
    settled(opened)
    assert opened.execute_script("return document.documentElement.scrollWidth") <= width
    for name in ("load-plot", "radius-plot"):
        assert opened.find_element("id", name).rect["width"] > min(250, 0.3 * width)

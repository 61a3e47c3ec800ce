"""What takes long is announced, about as long as it takes; a forecast is that of all that is computed."""

import io
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from jkrcli.base.errors import JkrError
from jkrcli.cli.printing import announce, progress
from jkrcli.report.check import Check

CASE = """
indenter = {{ shape = "paraboloid", radius = "100 um" }}
specimen.layers = [{{ thickness = "50 um", E = "1 MPa", nu = 0.45 }}]
loading = {{ depth = "5 um", points = 20 }}
adhesion.w = [{}]
"""


def test_check_says_what_many_works_of_adhesion_take(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """It took 0.07 s for each of them without a word."""

    def of(*_: object) -> Check:
        raise JkrError("solved")

    monkeypatch.setattr(Check, "of", of)
    Path("few.toml").write_text(CASE.format("0.01"))
    Path("many.toml").write_text(CASE.format(", ".join(str(i / 1e4) for i in range(1, 401))))
    assert "works of adhesion" not in jkr("check", "few.toml").err
    said, last = jkr("check", "many.toml").err.splitlines()
    assert "check for 400 works of adhesion: about 36 s of CPU time" in said
    assert "solved" in last


def test_the_explorer_counts_its_page(jkr: Callable, tuned: Callable) -> None:
    """100,000 rows were announced as 4 s and took 38: the page's errors were not counted."""
    Path("gel.toml").write_text(CASE.format("0.01"))
    assert jkr("run", "gel.toml").code == 0
    tuned("jkrcli.many.explorer.COST_PAGE_PER_ROW", 1.0)
    done = jkr("explore", "gel.h5")
    assert "explore of 20 rows" in done.err
    assert "20 s of CPU time" in done.err


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "file"])
def test_progress_is_shown_on_terminals_alone(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> None:
    monkeypatch.setattr("sys.stderr", stream)
    with progress("cases", 2, 1.0) as step:
        step(False)
        step(True)
    if stream.isatty():
        assert stream.getvalue().splitlines()[-1].rstrip("\x1b[?25h ").endswith("2/2  1 failed")
        assert "1/2" in stream.getvalue()
    else:
        assert stream.getvalue() == ""


def test_a_command_announces_its_time_once(capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        with click.Context(click.Command("x")):
            announce("all", 60.0)
            with progress("a part", 2, 40.0):
                pass
    assert capsys.readouterr().err == "jkr: all: about 60 s of CPU time\n" * 2

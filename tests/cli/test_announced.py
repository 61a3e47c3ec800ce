"""What takes long is announced, about as long as it takes; a forecast is that of all that is computed."""

from collections.abc import Callable
from pathlib import Path

import pytest

from jkrcli.base.errors import JkrError
from jkrcli.report.check import Check

CASE = """[indenter]
shape = "paraboloid"
radius = "100 um"
[specimen]
base = "bonded"
[[specimen.layers]]
thickness = "50 um"
E = "1 MPa"
nu = 0.45
[loading]
depth = "5 um"
points = 20
[adhesion]
w = [{}]
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

"""A command's JSON is what Python's ``summary()`` gives, and what it prints is what ``print`` does."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jkrcli as python
from jkrcli.report.result import Result

CASES = Path(__file__).parent.parent / "cases"
RECORD = CASES / "measured" / "raw-force-curve.txt"


@pytest.fixture(name="gel")
def _gel(jkr: Callable, tmp_path: Path) -> str:
    assert jkr("run", CASES / "gel.toml", "-o", "gel.h5").code == 0
    return "gel.h5"


def plain(value: Any) -> Any:
    """As JSON gives it back."""
    return json.loads(json.dumps(value, default=lambda unknown: unknown.reason))


MADE: dict[str, tuple[tuple[object, ...], Callable[[], Result], str]] = {
    "check": (("check", CASES / "gel.toml"), lambda: python.check(CASES / "gel.toml"), ""),
    "look": (("look", RECORD, "--no-plots"), lambda: python.look(RECORD), "files"),
    "pull-off": (("pull-off", "gel.h5", "--w", "40 mJ/m^2"), lambda: python.pull_off("gel.h5", "40 mJ/m^2"), "results"),
    "pull-off by a device": (
        ("pull-off", "gel.h5", "--w", "0.04", "--stiffness", "2 kN/m"),
        lambda: python.pull_off("gel.h5", 0.04, stiffness=["2 kN/m"]),
        "results",
    ),
    "w of a pull-off": (
        ("pull-off", "gel.h5", "--load", "1.2 mN", "--uncertain", "R=1%"),
        lambda: python.pull_off("gel.h5", load="1.2 mN", uncertain={"R": "1%"}),
        "results",
    ),
    "pull-off map": (
        ("study", "pull-off-map", "--q", "1", "--nu", "0.3", "--no-plots"),
        lambda: python.study_map("pull-off", q=[1.0], nu=[0.3]),
        "",
    ),
    "rate map": (
        ("study", "rate-map", "--speed", "1", "--stiffness", "rigid", "--no-plots"),
        lambda: python.study_map("rate", speed=[1.0], stiffness=["rigid"]),
        "",
    ),
}


@pytest.mark.parametrize("name", MADE)
def test_command_and_python_say_the_same(jkr: Callable, gel: str, name: str) -> None:
    words, make, inside = MADE[name]
    result, done = make(), jkr(*words, "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert plain(result.summary()) == (found[inside][0] if inside else found)
    assert str(result) in jkr(*words).out


def test_a_profile_is_that_of_the_command(jkr: Callable, gel: str) -> None:
    done = jkr("profile", gel, "--load", "0.5 mN", "--w", "40 mJ/m^2")
    assert done.code == 0, done.err
    result = python.profile(gel, load="0.5 mN", w=0.04)
    assert done.out.startswith(f"{result}\n")
    rows = np.genfromtxt("gel-profile.csv", delimiter=",", names=True)
    for column, values in result.columns.items():
        np.testing.assert_array_equal(rows[column], values)
    assert result.figure().axes
    with pytest.raises(python.InputError, match="profile: give exactly one of a and load"):
        python.profile(gel)


def test_what_pull_off_cannot_answer_is_said(gel: str) -> None:
    with pytest.raises(python.InputError, match="pull_off: give exactly one of w and load"):
        python.pull_off(gel)
    with pytest.raises(python.InputError, match=r'^load: must be a force, got "1 m"'):
        python.pull_off(gel, load="1 m")


def test_columns_of_any_result_are_a_data_frame() -> None:
    pytest.importorskip("pandas")
    result = python.study_map("pull-off", q=[0.1, 1.0], nu=[0.3])
    frame = result.to_pandas()
    assert list(frame.columns) == list(result.columns)
    assert len(frame) == 2

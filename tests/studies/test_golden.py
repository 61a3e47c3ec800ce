"""The comparison of commands with those of another commit: what counts as a difference, and what does not."""

from __future__ import annotations

import pytest

from studies.golden import MASKS, difference, scenes


def masked(text: str) -> str:
    for mask, instead in MASKS:
        text = mask.sub(instead, text)
    return text


@pytest.mark.parametrize(
    "pair",
    [
        ("took 0.31 s", "took 1.2 s"),
        ('"cpu_s": 0.3,', '"cpu_s": 0.41,'),
        ("2026-01-02T10:00:00Z", "2026-11-26T09:59:01Z"),
    ],
)
def test_costs_and_dates_are_no_difference(pair: tuple[str, str]) -> None:
    assert masked(pair[0]) == masked(pair[1])


def test_a_number_that_changes_is_told_with_its_size() -> None:
    assert difference("P 1.0 mN", "P 1.0 mN") is None
    assert "numbers alone, by 1.0e-09" in str(difference("P\n1.000000000", "P\n1.000000001"))
    assert "in words" in str(difference("the load", "the force"))
    assert difference(None, "x") == "is new"
    assert "line 2" in str(difference("a\nb\n", "a\n"))


@pytest.mark.parametrize("text", ["P = -97.101 uN at a = 1.2 mm", "w 20 mJ/m^2", "stiffness 0.2 N/m"])
def test_what_a_user_reads_is_not_masked(text: str) -> None:
    assert masked(text) == text


def test_scenes_have_names_of_their_own() -> None:
    names = [scene.name for scene in scenes()]
    assert len(names) == len(set(names))

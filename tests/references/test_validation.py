"""The tables of the documentation's validation: every row within its tolerance, the page as it stands up to date."""

import re

import pytest

from docs.validation import validate

FAST = (validate.sphere, validate.layers, validate.tension, validate.relaxation, validate.paper)


@pytest.mark.parametrize(
    "section",
    [pytest.param(one, marks=() if one in FAST else pytest.mark.slow, id=one.__name__) for one in validate.SECTIONS],
)
def test_rows_are_within_their_tolerances_and_on_the_page(section: object) -> None:
    page = validate.PAGE.read_text(encoding="utf-8")
    for row in section():  # type: ignore[operator]
        assert row.difference <= row.tolerance, row
        assert re.search(rf"^\| {re.escape(row.what)} \|", page, re.M), f"{row.what}: run make validation"


def test_a_row_that_is_off_is_found() -> None:
    assert validate.Row("", 1.0, 1.1, "", 1e-3).difference > 1e-3


def test_the_second_solution_is_a_solution() -> None:
    """A layer of great thickness is a half-space: S = 2 E* a."""
    assert validate.plain_stiffness(0.3, 1e-3) == pytest.approx(1.0, abs=2e-3)  # departs as a/h: 1e-3

"""A list of one value is that value alone."""

import pytest

from jkrcli.case.models import parse_case
from jkrcli.case.store import solve

BODY = """
indenter = { shape = "paraboloid", radius = 1.0 }
specimen.half_space = { E = 1.0, nu = 0.3 }
[loading]
"""


@pytest.mark.parametrize(
    ("loading", "rows"),
    [
        ("radius = [0.001]", 1),
        ("radius = 0.001", 100),
        ("radius = [0.001]\npoints = 7", 7),
        ("depth = [1e-6]", 1),
        ("radius = 0.001\npoints = 1", 1),
    ],
)
def test_one_value_in_brackets_is_one_row(loading: str, rows: int) -> None:
    case = parse_case((BODY + loading).encode(), "case")
    series = solve(case)[1].series
    assert len(series) == rows
    assert series.a[-1] == pytest.approx(1e-3)
    again = parse_case(case.to_toml().encode(), "case")
    assert again.model.problem().key == case.model.problem().key

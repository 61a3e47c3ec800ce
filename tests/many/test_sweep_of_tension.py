"""Cases that differ in what a body's words leave out are solved each: surface tension, surfaces that stick."""

import csv

import pytest

CASE = """
[indenter]
shape = "paraboloid"
radius = "5 um"
[specimen]
surface_tension = "30 mN/m"
half_space = { E = "5 kPa", nu = 0.3 }
[loading]
radius = "1 um"
points = 10
[adhesion]
w = "0 J/m^2"
"""


@pytest.mark.parametrize(
    ("key", "values", "column"),
    [
        ("specimen.surface_tension", '["10 mN/m", "30 mN/m"]', "specimen.surface_tension_N_per_m"),
        ("specimen.surface", '["sliding", "sticking"]', "specimen.surface"),
    ],
)
def test_each_is_solved(jkr, tmp_path, key, values, column):
    case = CASE.replace('surface_tension = "30 mN/m"', "") if key == "specimen.surface" else CASE
    (tmp_path / "case.toml").write_text(case)
    (tmp_path / "s.toml").write_text(
        f'base = "case.toml"\n[[axes]]\nkey = "{key}"\nvalues = {values}\n[outputs]\nquantities = ["end"]\n'
    )
    done = jkr("sweep", "s.toml", "--workers", 1)
    assert done.code == 0, done.err
    assert "2 cases to compute by 2 solves" in done.err
    rows = list(csv.DictReader((tmp_path / "s-results" / "table.csv").open()))
    assert column in rows[0]
    assert [name for name in rows[0] if name.startswith("end.") and rows[0][name] != rows[1][name]]

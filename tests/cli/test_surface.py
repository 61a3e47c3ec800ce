"""Surfaces that stick, from the case file to series, curve, profile and warnings."""

import json
import re

import numpy as np
import pytest
from maugis import finite_range_curve

from jkrcli import parse_case, read
from jkrcli.api import solve, transform
from jkrcli.base.errors import InputError, Refusal

LAYER = """
[indenter]
shape = "paraboloid"
radius = "6 mm"
[specimen]
surface = "SURFACE"
[[specimen.layers]]
thickness = "0.36 mm"
E = "15 kPa"
nu = NU
[loading]
radius = "1 mm"
points = 20
[adhesion]
w = "40 mJ/m^2"
"""


def layer(surface, nu=0.499):
    return LAYER.replace("SURFACE", surface).replace("NU", str(nu))


@pytest.fixture
def folder(tmp_path):
    for surface in ("sliding", "sticking"):
        (tmp_path / f"{surface}.toml").write_text(layer(surface))
    return tmp_path


@pytest.mark.slow
def test_the_surface_goes_from_the_case_to_every_summary(jkr, folder):
    for surface in ("sliding", "sticking"):
        told = jkr("run", folder / f"{surface}.toml", "-o", folder / f"{surface}.h5", "--json").told
        assert told["surface"] == surface
        assert told["sticking"]["load"] == pytest.approx(1.5, abs=0.1)
        path = folder / f"{surface}.h5"
        assert read(path).problem.sticks == (surface == "sticking")
        assert f"surface   {surface}" in jkr("show", path).out
        result = jkr("transform", path, "--json", "--no-plots").told["results"][0]
        assert result["surface"] == surface
        assert result["sticking"]["pull_off"][0]["ratio"] == pytest.approx(0.956, abs=0.005)


def test_keys_of_frictionless_problems_are_what_they_were():
    plain = parse_case(layer("sliding").replace('[specimen]\nsurface = "sliding"', "")).model.problem()
    sliding, sticking = (parse_case(layer(surface)).model.problem() for surface in ("sliding", "sticking"))
    assert plain.key == sliding.key != sticking.key
    assert "sticks" not in repr(sliding)


def test_what_is_left_out_stands_behind_the_verdict_where_it_matters(jkr, folder):
    said = jkr("check", folder / "sliding.toml").out
    assert re.search(r"no slip +\+.*specimen.surface = \"sticking\"", said)
    assert "S: punch stiffness" in said
    assert re.search(r"  slip +-", jkr("check", folder / "sticking.toml").out)


def test_the_work_behind_a_pull_off_force_names_what_it_assumes(jkr, folder):
    done = jkr("pull-off", folder / "sliding.toml", "--load", "1 mN")
    assert "warning: " in done.err
    assert "no friction is assumed: no slip gives" in done.err


@pytest.mark.slow
def test_a_profile_shows_the_shear(jkr, folder):
    jkr("run", folder / "sticking.toml", "-o", folder / "s.h5")
    jkr("profile", folder / "s.h5", "--a", "0.6 mm", "--w", "0")
    table = np.genfromtxt(folder / "s-profile.csv", delimiter=",", names=True)
    inside = table["r_m"] < 0.6e-3
    r, p, shear = (table[name][inside] for name in ("r_m", "pressure_Pa", "shear_Pa"))
    assert 2 * np.pi * np.trapezoid(p * r, r) == pytest.approx(2.319e-3, rel=0.01)
    assert shear.min() < -0.1 * p.max()  # the squeezed layer is held back, inwards
    assert (table["gap_m"][~inside] > -1e-5 * 28e-6).all()  # measured -1.2e-11 m next to the edge


def test_what_knows_sliding_alone_says_so(jkr, folder):
    solution = solve(parse_case(layer("sticking")))
    with pytest.raises(Refusal, match="for frictionless contact only"):
        finite_range_curve(solution, 0.04, stress=1e4)
    for method in ("hybrid", "closed-form"):
        with pytest.raises(InputError, match="use method layered"):
            solve(parse_case(layer("sticking")), method)


def test_pull_off_changes_by_little_where_the_load_changes_by_much():
    forces = [transform(parse_case(layer(s)), 0.04).pull_off["load"].P for s in ("sticking", "sliding")]
    assert forces[0] / forces[1] == pytest.approx(0.9561, abs=1e-3)


@pytest.mark.slow
def test_a_fit_under_both_assumptions_finds_which_one_made_the_data(jkr, folder):
    curve = transform(parse_case(layer("sticking").replace("points = 20", "points = 80")), 0.04).curve
    noise = 1 + 0.005 * np.random.default_rng(1).standard_normal((3, 80))
    rows = np.column_stack([curve.a, curve.delta, curve.P])[20:] * noise[:, 20:].T
    np.savetxt(folder / "data.csv", rows, delimiter=",", header="a_m,delta_m,P_N", comments="")
    outcome = jkr("fit", folder / "sliding.toml", folder / "data.csv", "--surface", "both", "-o", folder, "--json")
    first, second = json.loads(outcome.out)["curves"]
    assert (first["surface"], second["surface"]) == ("sliding", "sticking")
    E, wrong = (one["estimates"]["modulus"]["value"] for one in (second, first))
    assert E == pytest.approx(1, abs=0.02)
    assert wrong > 1.2
    assert second["estimates"]["w"]["value"] == pytest.approx(0.04, rel=0.03)
    assert "the data favour no slip" in outcome.err
    assert len(list(folder.glob("*-sticking.svg"))) == len(list(folder.glob("*-sliding.svg"))) == 1


def test_a_fit_says_what_friction_would_change(jkr, folder):
    curve = transform(parse_case(layer("sliding")), 0.04).curve
    rows = np.column_stack([curve.a, curve.delta, curve.P])[5:]
    np.savetxt(folder / "data.csv", rows, delimiter=",", header="a_m,delta_m,P_N", comments="")
    told = jkr("fit", folder / "sliding.toml", folder / "data.csv", "-o", folder, "--no-plots").err
    assert "no friction is assumed" in told
    assert "jkr fit --surface both fits either" in told

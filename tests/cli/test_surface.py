"""Surfaces that stick, from the case file to series, curve, profile and warnings; surfaces under tension."""

import json
import re

import numpy as np
import pytest
from maugis import finite_range_curve

from jkrcli import parse_case
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


def test_keys_of_frictionless_problems_are_what_they_were():
    plain = parse_case(layer("sliding").replace('[specimen]\nsurface = "sliding"', "")).model.problem()
    sliding, sticking = (parse_case(layer(surface)).model.problem() for surface in ("sliding", "sticking"))
    assert plain.key == sliding.key != sticking.key
    assert "sticks" not in repr(sliding)


@pytest.mark.slow
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


GEL = """
[indenter]
shape = "sphere"
radius = "5 um"
[specimen]
surface_tension = "30 mN/m"
[[specimen.layers]]
E = "5 kPa"
nu = 0.5
thickness = "10 um"
[loading]
radius = "1.2 um"
points = 30
[adhesion]
w = "1 mJ/m^2"
"""
TENSION = 'surface_tension = "30 mN/m"'


@pytest.fixture(name="gel")
def _gel(tmp_path):
    def write(*changes):
        text = GEL
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "gel.toml").write_text(text)

    return write


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("30 mN/m", "30 kPa"), 'got "30 kPa": unknown unit "kPa", a pressure is no force per'),
        (("30 mN/m", "-1 mN/m"), "specimen.surface_tension: must be >= 0, got -1 mN/m"),
        ((TENSION, TENSION + '\nsurface = "sticking"'), 'leave it out, or take specimen.surface = "sliding"'),
        (("[indenter]", 'method = "fem"\n[indenter]\nE = "1 MPa"\nnu = 0.3'), "rigid profile: use method layered"),
        (("[adhesion]", '[adhesion]\nrange = "10 nm"'), "leave range, stress and capillary out, or specimen.surface"),
        (("[indenter]", 'method = "hybrid"\n[indenter]'), "does not represent surface tension: use method"),
        (("[indenter]", 'method = "closed-form"\n[indenter]'), "use method layered or fem, or leave specimen.surface_"),
    ],
)
def test_refused_in_one_line_with_a_remedy(jkr, gel, change, said):
    gel(change)
    jkr("run", "gel.toml").refused(said)


def test_a_gel_with_surface_tension(jkr, gel):
    gel()
    assert jkr("run", "gel.toml").code == 0
    found = jkr("pull-off", "gel.h5", "--json").told
    assert found["results"][0]["validity"]["edge_angle"] == pytest.approx((2 / 30) ** 0.5)
    assert "theta = 0.258" in jkr("pull-off", "gel.h5").out
    steep = jkr("pull-off", "gel.h5", "--w", "10 mJ/m^2")
    assert "theta = sqrt(2 w/Ups) = 0.816 rad at the edge is above 0.5" in steep.out
    jkr("transform", "gel.h5", "--w", "61 mJ/m^2").refused("more than twice the surface tension", "w up to 60 mJ/m^2")
    assert "under surface tension" in jkr("profile", "gel.h5", "--a", "1 um", "--w", "0").err


def test_check_says_what_a_surface_tension_would_change(jkr, gel):
    """Half-space: P at equal depth changes by 3 kappa/(pi a), kappa = 2 Ups/E*, to first order."""
    gel((TENSION + "\n[[specimen.layers]]", "[specimen.half_space]"), ('thickness = "10 um"\n', ""),
        ('radius = "1.2 um"', 'radius = "0.3 mm"'), ('radius = "5 um"', 'radius = "3 mm"'),
        ('w = "1 mJ/m^2"', "w = 0"))  # fmt: skip
    rows = {row["name"]: row for row in jkr("check", "gel.toml", "--json").told["left_out"]}
    row = rows["surface tension 30 mN/m"]
    kappa = 2 * 30e-3 / (5e3 / 0.75)
    assert row["load"] == pytest.approx(3 * kappa / (3.141593 * 0.3e-3), rel=0.1)
    assert row["key"] == 'specimen.surface_tension = "30 mN/m"'
    assert re.search(r"surface tension 30 mN/m +\+2\.8%", jkr("check", "gel.toml").out)
    gel()
    assert "surface tension 30 mN/m  " not in jkr("check", "gel.toml").out  # it is in the case


def test_large_strains_in_per_cent(jkr, gel):
    gel((TENSION + "\n[[specimen.layers]]", "[specimen.half_space]"), ('thickness = "10 um"\n', ""),
        ('radius = "1.2 um"', 'radius = "2.5 um"'), ('"sphere"', '"paraboloid"'))  # fmt: skip
    err = jkr("run", "gel.toml").err
    assert "linear elasticity overestimates P by about 5.6% at this depth (neo-Hookean)" in err
    assert 'with indenter.shape = "sphere" by 2.9%' in err

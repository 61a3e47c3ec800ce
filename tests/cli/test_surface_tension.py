"""Surface tension from the command line: what is refused and why, what is stated, what check tells where it is none."""

import re

import pytest

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

"""Surface tension from records of one and of two radii, made by the exact solver: another table than the fit's."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from conftest import write_table

import jkrcli
from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.files import is_ours
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured.curve import NOT_SUBTRACTED, Curve
from jkrcli.measured.report import tension_words
from jkrcli.measured.surface_tension import _tabulated, tension_fit
from jkrcli.methods.layered.solver import Layered

E_STAR, TENSION, W = 4e3 / (1 - 0.49**2), 0.02, 5e-4
SMALL, LARGE = 3e-6, 30e-6
DEPTHS = {SMALL: 1e-6, LARGE: 4e-6}
START = Problem(Paraboloid(1e-5), Specimen((), HalfSpace(Elastic(1e4, 0.49))), Loading("depth", 1e-6))


@pytest.fixture(autouse=True)
def _lengths(request, tuned):
    """Of the table fewer, where no digits are asked for: 3e-3 of values instead of 1e-4."""
    slow = request.node.get_closest_marker("slow")
    tuned("jkrcli.measured.surface_tension.TENSION_FIT_LENGTHS", 14 if slow else 8)
    if slow:
        _tabulated.cache_clear()


@cache
def retraction(R):
    """Displacement and load down to pull-off under displacement control."""
    body = Specimen((), HalfSpace(Elastic(4e3, 0.49)), surface_tension=TENSION)
    series = Layered(1e-6)(Problem(Paraboloid(R), body, Loading("depth", DEPTHS[R], 120))).series
    curve = transform(series, slopes(series, "exact"), W)
    delta, P = (values[np.argmin(curve.delta) :] for values in (curve.delta, curve.P))
    rows = np.linspace(delta[0] + 0.02 * np.ptp(delta), 0.95 * delta[-1], 80)
    return rows, np.interp(rows, delta, P)


def record(R, noise, seed):
    """A retraction with the zero point 0.3 um and ``noise`` of the load."""
    rows, load = retraction(R)
    load = load + noise * np.ptp(load) * np.random.default_rng(seed).standard_normal(80)
    return Curve(f"{R * 1e6:g}um", delta=rows + 3e-7, P=load)


@pytest.mark.slow
def test_two_radii_tell_the_tension():
    exact = tension_fit(START, [record(R, 0.0, 0) for R in (SMALL, LARGE)], [SMALL, LARGE], {})
    for name, value in (("E_star", E_STAR), ("surface_tension", TENSION), ("w", W)):
        assert exact.estimate(name).value == pytest.approx(value, rel=3e-3)  # of the tables of both
    apart = []
    for seed in range(2):
        curves = [record(R, 0.01, 2 * seed + i) for i, R in enumerate((SMALL, LARGE))]
        item = tension_fit(START, curves, [SMALL, LARGE], {}).estimate("surface_tension")
        assert item.error < 0.03 * TENSION
        apart.append((item.value - TENSION) / item.error)
    assert np.mean(np.square(apart)) < 4  # of 2; of 1,000: see the page
    assert not exact.warnings


def test_one_radius_does_not_and_it_is_said_from_what():
    found = tension_fit(START, [record(LARGE, 0.01, 1)], [LARGE], {})
    assert found.estimate("surface_tension").low is None
    assert "do not separate surface_tension from E*" in found.warnings[0]
    first, *_ = tension_words(found)
    assert first.endswith(f"; one radius does not separate the tension from {' and '.join(found.mixed)}")
    assert next(iter(found.mixed)) == "E*"
    bent = replace(record(LARGE, 0.01, 1), flags=(NOT_SUBTRACTED,))
    known = tension_fit(START, [bent], [LARGE], {"surface_tension": TENSION})
    assert known.estimate("E_star").value == pytest.approx(E_STAR, rel=0.05)
    assert known.warnings == (f"{bent.where}: {bent.doubts[0]}",)  # of how it was read


def test_from_the_command_line(jkr, tmp_path):
    for name, R in (("small", SMALL), ("large", LARGE)):
        curve = record(R, 0.01, 3)
        write_table(f"{name}.csv", "delta_m,P_N", curve.delta, curve.P)
    (tmp_path / "gel.toml").write_text(
        '[indenter]\nshape = "paraboloid"\nradius = "10 um"\n[specimen.half_space]\nE = "10 kPa"\nnu = 0.49\n'
        '[loading]\ndepth = "1 um"\n'
    )
    words = ("fit", "gel.toml", "small.csv", "large.csv")
    tips = ("--tip-radius", "3 um", "--tip-radius", "30 um")
    done = jkr(*words, "--free", "surface_tension", *tips).ok
    found = json.loads((tmp_path / "gel-fit.json").read_text())["estimates"]["surface_tension"]
    assert found["low"] < TENSION < found["high"]
    assert "surface_tension" in done.out
    assert is_ours(tmp_path / "gel-fit.csv")  # so that the same fit again may replace it
    for wrong, said in (
        ((*tips, "--tip-radius", "1 um"), "--tip-radius: give one for each of the 2 files, or one for all, got 3"),
        ((*tips, "--fix", "nu=0.4"), "surface_tension: nu cannot be free or fixed beside it"),
        ((*tips, "--fix", "w=5 nm"), 'w: must be a work of adhesion, got "5 nm"'),
        ((*tips, "--loss", "huber"), "surface_tension does not take --loss huber"),
    ):
        jkr(*words, "--free", "surface_tension", *wrong, "--force").refused(said)
    assert jkr(*words, *tips, "--force").code == 0  # each file by its own tip


def test_python_fits_as_the_command_does():
    curves = [record(R, 0.0, 0) for R in (SMALL, LARGE)]
    solved = jkrcli.solve(START, "closed-form")
    radii = [SMALL, f"{LARGE * 1e6:g} um"]
    found = jkrcli.fit(solved, curves, ["surface_tension"], {"w": f"{W} J/m^2"}, tip_radii=radii)
    plain = tension_fit(START, curves, [SMALL, LARGE], {"w": W})
    assert found.estimate("E_star").value == plain.estimate("E_star").value
    with pytest.raises(jkrcli.InputError, match="give one for each of the 2 files, or one for all, got 3"):
        jkrcli.fit(solved, curves, ["surface_tension"], tip_radii=[SMALL] * 3)

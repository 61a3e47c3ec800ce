"""Pull-off at large strains: the first order by its energy, the ranges where elements measured them, who is told."""

import csv
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import jkrcli as jkr
from jkrcli.adhesion.curve import Equilibrium
from jkrcli.adhesion.validity import large_strains
from jkrcli.base.errors import Unknown
from jkrcli.formulas import BY_DISPLACEMENT, BY_LOAD, strained_pull_off

CUBIC = (-0.11569, 0.34707, -0.43430, 0.2002)  # c_k of U3 = mu sum c_k D^(3-k) X^k


@pytest.mark.parametrize(("control", "published"), [("load", BY_LOAD), ("displacement", BY_DISPLACEMENT)])
def test_the_first_order_is_that_of_the_cubic_energy(control: str, published: float) -> None:
    """E* = 4 mu = R = 1: JKR's energy and the cubic one, dU/da = 2 pi w a solved for delta at each radius."""
    wc = 0.01
    w = wc**3

    def by_delta(a: float, delta: float) -> float:
        D, X = a**2, a**2 - delta
        cubic = sum(k * c * D ** (3 - k) * X ** (k - 1) for k, c in enumerate(CUBIC) if k)
        return 2 * a * delta - 2 / 3 * a**3 - cubic / 4

    def by_radius(a: float, delta: float) -> float:
        D, X = a**2, a**2 - delta
        cubic = sum((3 - k) * c * D ** (2 - k) * X**k for k, c in enumerate(CUBIC) if k < 3)
        cubic += sum(k * c * D ** (3 - k) * X ** (k - 1) for k, c in enumerate(CUBIC) if k)
        return (delta - a**2) ** 2 + cubic / 4 * 2 * a - 2 * math.pi * w * a

    radii = wc * np.linspace(0.5, 2.0, 301)
    shifts = np.sqrt(2 * math.pi * w * radii)
    delta = np.array([brentq(lambda d, a=a: by_radius(a, d), a * a - 1.5 * t, a * a - t / 2, xtol=1e-18, rtol=1e-13)
                      for a, t in zip(radii, shifts, strict=True)])  # fmt: skip
    P = np.array([by_delta(a, d) for a, d in zip(radii, delta, strict=True)])
    held, unit = (P, 1.5) if control == "load" else (delta, 5 / 6)
    i = int(np.argmin(held))
    parabola = np.polyfit(radii[i - 5 : i + 6] - radii[i], held[i - 5 : i + 6], 4)
    a = radii[i] + brentq(np.poly1d(parabola).deriv(), radii[i - 1] - radii[i], radii[i + 1] - radii[i])
    lowest = np.interp(a, radii, P)
    assert (-lowest / (unit * math.pi * w) - 1) / wc == pytest.approx(published, abs=1e-3)


def body(E: float = 5e3, nu: float = 0.5, h: float = math.inf, shape: type = jkr.Paraboloid) -> jkr.Problem:
    material = jkr.Elastic(E, nu)
    half = jkr.Specimen((), jkr.HalfSpace(material))
    layered = jkr.Specimen((jkr.Layer(material, h),), jkr.Rigid()) if h < math.inf else half
    return jkr.Problem(shape(5e-6), layered, jkr.Loading("radius", 4.9e-6, 100))


POINT = Equilibrium(2.4e-6, -4e-7, -2e-8)  # a/R = 0.47


def test_whose_change_is_known() -> None:
    soft, stiff = large_strains(body(), 1e-3, POINT), large_strains(body(1e5), 1e-3, POINT)
    assert isinstance(soft, Unknown)
    assert "beyond the estimate" in soft.reason
    assert stiff == strained_pull_off((1e-3 / (1e5 / 0.75 * 5e-6)) ** (1 / 3))
    assert isinstance(large_strains(body(1e5, h=6e-6), 1e-3, POINT), tuple)
    for other in (body(1e5, nu=0.3), body(1e5, h=1e-6), replace(body(1e5), sticks=True)):
        assert "of unknown effect" in large_strains(other, 1e-3, POINT).reason
        assert large_strains(other, 1e-3, Equilibrium(5e-7, -1e-9, -2e-8)) is None
    assert large_strains(body(), 0.0, POINT) is None


def test_no_nine_digits_where_strains_are_large(jkr: Callable) -> None:
    """R 5 um, E 5 kPa, nu 1/2, w 1 mJ/m^2: once "below 1e-9", "JKR holds" at wc = 0.31."""
    where = ("--shape", "paraboloid", "--radius", "5 um", "--nu", 0.5, "--w", "1 mJ/m^2")
    done = jkr("pull-off", "--E", "5 kPa", *where).ok
    for gone in ("below 1e-", "JKR holds", "23.56 nN (load)"):
        assert gone not in done.out
    assert "large strains beyond the estimate" in " ".join(done.out.split())
    done = jkr("pull-off", "--E", "100 kPa", *where)
    assert "pull-off force 23.6 nN (load)" in done.out
    assert "large strains -5.9 to +1.4 % (model)" in done.out
    found = jkr("pull-off", "--E", "100 kPa", *where, "--json").told["results"][0]
    point = found["controls"][0]["pull_off"]
    assert point["large_strains"] == [pytest.approx(-0.059, abs=1e-3), pytest.approx(0.0144, abs=1e-3)]
    assert point["P_err_N"] < 1e-6 * abs(point["P_N"])  # the numerical error is its own
    assert found["validity"]["regime"].startswith("short-range adhesion, but large strains")


def test_every_w_of_a_force_carries_them(jkr: Callable) -> None:
    words = ("pull-off", "--shape", "paraboloid", "--radius", "5 um", "--E", "100 kPa", "--nu", 0.5, "--load", "23 nN")
    assert "large strains -1.4 to +6.2 % (model)" in jkr(*words).out


def test_what_is_below_a_tenth_of_a_per_cent_is_not_said() -> None:
    """E 1 GPa, nu 1/2, w 1 mJ/m^2: once "large strains -0.001 to +0.025 %", on every stiff rubber."""
    wc = (1e-3 / (1e9 / 0.75 * 5e-6)) ** (1 / 3)
    assert 0 < max(strained_pull_off(wc)) < 1e-3
    assert large_strains(body(1e9), 1e-3, POINT) is None
    said = large_strains(body(1e7), 1e-3, POINT)
    assert isinstance(said, tuple)
    assert max(map(abs, said)) > 1e-3


SWEEP = """
base.indenter = { shape = "paraboloid", radius = "5 um" }
base.specimen.half_space = { E = "100 kPa", nu = 0.5 }
base.loading = { radius = "3 um", points = 40, spacing = "log" }
base.adhesion.w = "1 mJ/m^2"
outputs.quantities = ["pull_off.load.P_N"]
[[axes]]
key = "specimen.half_space.E"
values = ["5 kPa", "100 kPa", "1 GPa"]
"""


def test_rows_of_a_sweep_say_them(jkr: Callable, tmp_path: Path) -> None:
    """wc of 0.31, 0.11 and 0.005: unknown with the reason, the largest change, none; once none of it was told."""
    (tmp_path / "s.toml").write_text(SWEEP)
    done = jkr("sweep", tmp_path / "s.toml", "-o", tmp_path / "out").ok
    said = " ".join(done.out.split())
    assert "large strains change the pull-off force in 1 (validity.large_strains); how" in said
    assert "change the pull-off force is unknown in 1: " in said
    assert jkr("sweep", tmp_path / "s.toml", "-o", tmp_path / "out", "--json").told["large_strains"] == 2
    with (tmp_path / "out" / "table.csv").open() as file:
        soft, rubber, stiff = csv.DictReader(file)
    name = "validity.large_strains"
    assert (soft[name], stiff[name]) == ("", "0.0")
    assert "large strains beyond the estimate" in soft["reason"]
    wc = (1e-3 * 0.75 / (1e5 * 5e-6)) ** (1 / 3)
    assert float(rubber[name]) == pytest.approx(4.5 * wc**2, rel=1e-6)
    assert rubber["reason"] == ""

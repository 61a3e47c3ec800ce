"""Stated errors of the energies of pull-off and cycles against those of finer series."""

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from maugis import finite_range_curve
from scipy.integrate import quad
from scipy.interpolate import PPoly, make_interp_spline
from scipy.optimize import brentq

import jkrcli as jkr
from jkrcli.adhesion.curve import AdhesiveCurve, EquilibriumCurve
from jkrcli.adhesion.device_path import Cycle, cycle, energy_lost_error, separation_error, stability_under
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import with_solved_points

LAYER = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.45), 10e-6),), jkr.Rigid())
SPHERE = jkr.Paraboloid(100e-6)


def curve(
    points: int, w: float, method: str = "layered", body: jkr.Specimen = LAYER, devices: tuple[float, ...] = ()
) -> AdhesiveCurve:
    loading = jkr.Loading("radius", 40e-6, points)
    return with_solved_points(jkr.transform(jkr.solve(jkr.Problem(SPHERE, body, loading), method), w), *devices).jkr


def judged(coarse: Cycle, fine: Cycle, least: float = 0.0) -> list[float]:
    """Stated over true errors of both energies, which must hold; ``least``: relative, of what stands for the truth."""
    ratios = []
    for name, error in (
        ("energy_lost", energy_lost_error(coarse)),
        ("separation", separation_error(coarse.retraction)),
    ):
        value, true = getattr(coarse, name), getattr(fine, name)
        assert isinstance(error, float), error
        off = max(abs(value - true) - least * abs(true), 0.0)
        assert off <= error, (name, value, true, error)
        ratios.append(error / max(off, least * abs(true), 1e-9 * abs(true)))
    return ratios


def cycled(one: EquilibriumCurve, two: EquilibriumCurve, stiffness: float) -> Cycle:
    found = cycle(one, two, stiffness)
    assert isinstance(found, Cycle)
    return found


@pytest.mark.parametrize(("stiffness", "ratio"), [(20.0, 3.0), (math.inf, 1.0)])
def test_energies_of_few_rows_state_what_interpolation_leaves(stiffness: float, ratio: float) -> None:
    coarse, fine = (
        cycled(*(curve(n, w, devices=(stiffness,)) for w in (0.02, 0.02 * ratio)), stiffness) for n in (25, 200)
    )
    assert max(judged(coarse, fine)) < 100
    judged(cycled(curve(25, 0.02), curve(25, 0.02 * ratio), stiffness), fine)  # nor where pull-off is not solved


STACK = jkr.Specimen(
    (jkr.Layer(jkr.Elastic(1e6, 0.45), 3e-6), jkr.Layer(jkr.Elastic(3e4, 0.3), 2e-6)),
    jkr.HalfSpace(jkr.Elastic(1e7, 0.3)),
)


@pytest.mark.parametrize(("rows", "spacing"), [(100, "log"), (5, "radius"), (14, "radius"), (5, "log"), (14, "depth")])
def test_energies_of_stacks_are_within_what_is_stated_by_splines_through_many_radii(rows: int, spacing: str) -> None:
    """Of few rows: gaps beside solved points count, and work is not integrated over the ends of pieces."""
    solution = jkr.solve(jkr.Problem(SPHERE, STACK, jkr.Loading("radius", 20e-6, rows, spacing)), "layered")
    stiffness = 30.0
    result = with_solved_points(jkr.transform(solution, 0.001), stiffness)
    for device in (stiffness, math.inf):
        means = stability_under(result.curve, device)
        for name, true in splined(0.001, device).items():
            energy, error = getattr(means, name), getattr(means, f"{name}_error")
            if isinstance(error, jkr.Unknown):
                assert spacing != "radius"
                assert "differ by more than a factor" in error.reason
            else:
                assert abs(energy - true) <= error + 3e-9 * true, (name, energy, true, error)


@cache
def splined(w: float, stiffness: float) -> dict[str, float]:
    """The energies of ``STACK`` by quintic splines of Eq. 13 over log a, from loss of contact to the position or the
    load 0: int P dD."""
    a = np.geomspace(5e-8, 20e-6, 300)
    series = Layered(1e-11)(jkr.Problem(SPHERE, STACK, jkr.Loading.given("radius", tuple(a.tolist())))).series
    t = np.sqrt(4 * math.pi * w * a / series.dS)
    P = make_interp_spline(np.log(a), series.P - series.S * t, 5)
    D = make_interp_spline(np.log(a), series.delta - t + (series.P - series.S * t) / stiffness, 5)
    lost = max(root for root in PPoly.from_spline(D.derivative()).roots(extrapolate=False))
    ends = {"energy_lost": D, "separation": P}
    energies = {}
    for name, held in ends.items():
        x = np.linspace(lost, min(r for r in PPoly.from_spline(held).roots(extrapolate=False) if r > lost), 60)
        energies[name] = -float(sum(quad(lambda y: P(y) * D(y, 1), lo, hi)[0] for lo, hi in itertools.pairwise(x)))
    return energies


FILM = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.5), 1e-6),), jkr.HalfSpace(jkr.Elastic(6e3, 0.3)))


@pytest.mark.parametrize(("rows", "spacing"), [(14, "radius"), (25, "depth")])
def test_energies_across_a_jump_to_smaller_contact_count_what_its_place_errs_by(rows: int, spacing: str) -> None:
    """A stiff film on a soft half-space has two folds: up to 16 times beyond, as the upper one's place had no error."""
    w, loading = 1.8e-4, jkr.Loading("radius", 13e-6, rows, spacing)
    result = with_solved_points(jkr.transform(jkr.solve(jkr.Problem(SPHERE, FILM, loading), "layered"), w))
    means = stability_under(result.curve, math.inf)
    assert len(means.partial) == 1

    a = np.geomspace(4e-7, 13e-6, 150)
    series = Layered(1e-11)(jkr.Problem(SPHERE, FILM, jkr.Loading.given("radius", tuple(a.tolist())))).series
    t, x = np.sqrt(4 * math.pi * w * a / series.dS), np.log(a)
    P, D = (make_interp_spline(x, y, 5) for y in (series.P - series.S * t, series.delta - t))
    lower, crest, upper = PPoly.from_spline(D.derivative()).roots(extrapolate=False)
    lands = brentq(lambda y: float(D(y) - D(upper)), lower, crest)
    for name, held in (("energy_lost", D), ("separation", P)):
        first = min(root for root in PPoly.from_spline(held).roots(extrapolate=False) if root > upper)
        true = -sum(quad(lambda y: P(y) * D(y, 1), *ends, limit=200)[0] for ends in ((upper, first), (lower, lands)))
        assert abs(getattr(means, name) - true) <= getattr(means, f"{name}_error") + 1e-8 * true


def test_energies_of_finite_range_state_their_errors() -> None:
    one, two = (jkr.solve(jkr.Problem(SPHERE, LAYER, jkr.Loading("radius", 40e-6, n)), "layered") for n in (25, 200))
    coarse, fine = (finite_range_curve(each, 0.02, length=1e-7) for each in (one, two))
    for stiffness in (20.0, math.inf):
        judged(cycled(coarse, coarse, stiffness), cycled(fine, fine, stiffness))


@pytest.mark.slow
def test_energies_by_elements_state_those_of_the_mesh() -> None:
    ratios = []
    for nu in (0.3, 0.45, 0.49):
        body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, nu), 10e-6),), jkr.Rigid())
        coarse, fine = (curve(60, 0.02, method, body=body) for method in ("fem", "layered"))
        for stiffness in (20.0, math.inf):
            ratios += judged(cycled(coarse, coarse, stiffness), cycled(fine, fine, stiffness), 1e-6)
    assert np.median(ratios) < 30


def test_a_series_without_errors_has_energies_of_unknown_error() -> None:
    plain = curve(40, 0.02)
    bare = replace(plain, nonadhesive=replace(plain.nonadhesive, slopes=replace(plain.slopes, covariance=None)))
    error = energy_lost_error(cycled(bare, bare, math.inf))
    assert isinstance(error, jkr.Unknown)
    assert error.reason.startswith("unknown")

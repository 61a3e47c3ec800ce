"""Surface tension by the equation of the first kind: reference values, identities, limits, another way to solve it."""

import numpy as np
import pytest
from tension_records import galerkin

from jkrcli import formulas, study_map
from jkrcli.adhesion.curve import LOAD_CONTROL, transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat, Sphere
from jkrcli.bodies.problem import (
    Elastic,
    Exponential,
    Graded,
    HalfSpace,
    Layer,
    Loading,
    Problem,
    Rigid,
    Specimen,
    TransverselyIsotropic,
)
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.layered.surface_tension import SurfaceTensionSolver
from jkrcli.resolve.analysis import solved, solver_of

UNIT = Paraboloid(1.0)
SOFT, STIFF = Elastic(1.0, 0.4), Elastic(10.0, 0.25)


def half_space(kappa):
    return Specimen((), HalfSpace(Elastic(0.91, 0.3)), surface_tension=kappa / 2)


def bonded(nu, kappa, h=1.0):
    return Specimen((Layer(Elastic(1 - nu**2, nu), h),), Rigid(), surface_tension=kappa / 2)


def others(kappa):
    graded = Graded(Exponential(0.84, 8.4, 1.0), 0.4)
    lamellar = TransverselyIsotropic(E_p=2.0, E_z=1.0, nu_p=0.3, nu_zp=0.2, G_z=0.5)
    return {
        "coating": Specimen((Layer(Elastic(0.84, 0.4), 1.0),), HalfSpace(STIFF), surface_tension=kappa / 2),
        "graded": Specimen((Layer(graded, 1.0),), Rigid(), surface_tension=kappa / 2),
        "lamellar": Specimen((Layer(lamellar, 1.0), Layer(SOFT, 0.5)), Rigid(False), surface_tension=kappa / 2),
    }


def at(specimen, *radii, indenter=UNIT, tolerance=1e-8):
    return Layered(tolerance)(Problem(indenter, specimen, Loading.given("radius", radii))).series


# S, S', delta_H, P_H of a = E* = R = 1: an integral equation, confirmed by elements without a Hankel transform
VALUES = {
    "half-space, 0.1": (half_space(0.1), [2.29913958, 2.05772430, 1.18163976, 1.85841016]),
    "half-space, 10": (half_space(10.0), [12.41540014, 4.40953394, 3.21305495, 33.82476086]),
    "nu = 0.3, 0.1": (bonded(0.3, 0.1), [5.94724643, 9.44511562, 0.74206246, 2.36224271]),
    "nu = 0.5, 1": (bonded(0.5, 1.0), [16.05754824, 26.06913920, 0.82726235, 6.94745175]),
}


@pytest.mark.parametrize("body", VALUES)
def test_values_of_two_derivations(body):
    specimen, expected = VALUES[body]
    series = at(specimen, 1.0)
    found = [series.S[0], series.dS[0], series.delta[0], series.P[0]]
    np.testing.assert_allclose(found, expected, rtol=1e-8)  # measured 7e-9, digits and the other's 100 points
    assert max(series.errors["P"] / series.P) < 1e-8


# -P_min/(pi w R), rows beta = Ups/(E* a0), columns half-space, (nu, q = (a0/h)^3)
BODIES = (None, (0.5, 1), (0.5, 10), (0.3, 1))
PULL_OFF = {
    0.01: (1.470933, 1.890595, 2.095540, 1.754619),
    0.1: (1.347199, 1.700525, 1.902179, 1.583810),
    1: (1.086167, 1.212696, 1.372310, 1.163909),
    10: (1.004509, 1.011091, 1.024635, 1.007835),
}


def pull_off(specimen, largest, w=1.0):
    solution = Layered()(Problem(UNIT, specimen, Loading("radius", largest, 60)))
    curve = transform(solution.series, slopes(solution.series, "exact"), w)
    return -solved(curve, solver_of(solution)).pull_off(LOAD_CONTROL).P / np.pi


@pytest.mark.slow
@pytest.mark.parametrize("beta", sorted(PULL_OFF, reverse=True))
def test_pull_off_over_tension_and_thickness(beta):
    specimens = [half_space(2 * beta), *(bonded(nu, 2 * beta, q ** (-1 / 3)) for nu, q in BODIES[1:])]
    found = [pull_off(specimen, 2.2) for specimen in specimens]
    np.testing.assert_allclose(found, PULL_OFF[beta], rtol=1e-6)  # their digits


def test_the_map_of_the_study_has_the_same_values():
    found = study_map("pull-off", nu=[0.5], q=[1.0, 10.0], beta=[0.1]).columns["minus_P_over_pi_w_R"]
    np.testing.assert_allclose(found, PULL_OFF[0.1][1:3], rtol=1e-6)


def slope(values, step):
    return np.array([1, -8, 0, 8, -1]) @ values / (12 * step)


def energies(contact, a):
    """S, Q, T of U = S delta^2/2 - Q delta + T/2 at the radius a, by psi_1 and psi_F."""
    plan = contact.plan(np.array([a]), 1e-12)
    grid = contact._angles(a, plan)
    spectrum = contact.spectrum
    K = grid.matrices(lambda s: spectrum.singular(s)[None], lambda s: spectrum.smooth(2 * a, 24)(s)[:1], a)[0]
    F = contact.indenter.abel(a * np.cos(grid.tau))
    one, psi = np.linalg.solve(K, np.stack([np.ones_like(F), F], axis=1)).T
    return np.pi * contact.E_star * np.array([grid.w @ one, grid.w @ (one * F), grid.w @ (psi * F)])


@pytest.mark.parametrize("specimen", [half_space(0.3), bonded(0.5, 0.5)], ids=str)
def test_the_energy_is_a_parabola_with_one_zero_of_its_derivative(specimen):
    step = 0.004
    contact = SurfaceTensionSolver(UNIT, specimen)
    values = np.array([energies(contact, 1 + n * step) for n in range(-2, 3)])
    dS, dQ, dT = (slope(column, step) for column in values.T)
    series = at(specimen, 1.0)
    assert dQ**2 == pytest.approx(dS * dT, rel=1e-8)
    assert dS == pytest.approx(series.dS[0], rel=3e-8)  # of the difference
    assert dQ / dS == pytest.approx(series.delta[0], rel=3e-8)


@pytest.mark.parametrize(
    ("indenter", "body"),
    [(Sphere(2.0), "half-space"), (PowerLaw(0.3, 1.0), "coating"), (PowerLaw(1.0, 4.0), "lamellar"),
     (RoundedFlat(0.5, 1.0), "graded")],
)  # fmt: skip
def test_the_series_hangs_together(indenter, body):
    """S' is the derivative of S, and P_H' = S delta_H': any body, any tip."""
    specimen = half_space(0.2) if body == "half-space" else others(0.2)[body]
    step = 0.005
    series = at(
        specimen, *(1 + step * np.arange(-2, 3)), indenter=indenter, tolerance=1e-5 if body == "graded" else 1e-8
    )
    rel = 2e-6 if body == "graded" else 1e-7
    assert slope(series.S, step) == pytest.approx(series.dS[2], rel=rel)
    assert slope(series.P, step) == pytest.approx(series.S[2] * slope(series.delta, step), rel=rel)


@pytest.mark.parametrize("specimen", [bonded(0.3, 0.1), others(0.5)["coating"]], ids=str)
def test_another_way_to_solve_it(specimen):
    series = at(specimen, 1.0)
    found = [series.S[0], series.delta[0], series.P[0]]
    np.testing.assert_allclose(found, galerkin(specimen, 1.0)[:3], rtol=1e-5)  # of its differences and 12 terms


@pytest.mark.parametrize("indenter", [UNIT, RoundedFlat(0.5, 1.0)], ids=str)
def test_a_slight_tension_is_a_correction_to_first_order(indenter):
    left = []
    for kappa in (1e-2, 1e-3):
        contact = SurfaceTensionSolver(indenter, half_space(kappa))
        exact = contact.solved(np.array([1.0]), contact.plan(np.array([1.0]), 1e-9)).columns[:, 0]
        square = (kappa * formulas.logarithm(np.array(1.0), kappa)) ** 2
        left.append(np.abs(contact._slight(1.0) / exact - 1) / square)
    assert np.max(left) < 1  # the stated bound
    assert np.max(left[1]) < np.max(left[0]) * 1.5  # second order


@pytest.mark.first(1)
@pytest.mark.parametrize("body", ["half-space", "coating", "graded", "lamellar"])
def test_tension_alone_leaves_wetting(body):
    """kappa >> a: pull-off is pi w R at a = R sqrt(w/(2 Ups)) on every body."""
    kappa, w = 2e3, 1e-2
    specimen = half_space(kappa) if body == "half-space" else others(kappa)[body]
    radius = formulas.wetting_radius(1.0, w, specimen.surface_tension)
    assert pull_off(specimen, 3 * radius, w) / w == pytest.approx(1, rel=2e-4)


def test_stated_errors_hold():
    specimen = bonded(0.5, 0.2)
    radii = np.linspace(0.02, 2.0, 100)
    series, finer = at(specimen, *radii, tolerance=1e-6), at(specimen, *radii[::9], tolerance=1e-8)
    for name in ("delta", "P", "S", "dS"):
        true = np.abs(getattr(series, name)[::9] - getattr(finer, name))
        assert (true <= series.errors[name][::9]).all()
        assert (series.errors[name] <= 1e-6 * getattr(series, name)).all()


def test_a_tension_too_slight_for_layers_is_refused_with_its_size():
    with pytest.raises(Refusal, match=r"1e-07 of the contact radius.*leave specimen.surface_tension out"):
        at(bonded(0.3, 1e-7), 1.0)

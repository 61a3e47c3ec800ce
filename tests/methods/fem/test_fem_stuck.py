"""Surfaces that stick, by finite elements: against dense solves ring by ring, energies, limits, cost, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from jkrcli.base.clock import StageClock
from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, RoundedFlat
from jkrcli.bodies.materials import Elastic
from jkrcli.bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.fem.body import MeshedBody
from jkrcli.methods.fem.layout import scaled_layout
from jkrcli.methods.fem.method import FEM
from jkrcli.methods.fem.model import Discretisation

PARABOLOID = Paraboloid(1000.0)


def bonded(nu, radius=None, side=None):
    return Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid(), radius, side)


@pytest.fixture(scope="module", params=[(0.2, ()), (0.5, (0,))], ids=["compressible", "incompressible"])
def contact(request):
    nu, mixed = request.param
    body = MeshedBody((1.0,), (Elastic(1.0, nu),), 30.0, True, "free", False, True)
    layout = scaled_layout(body, "triangle", 2.0, 0.0, 0.2, 0.2, 0.2)
    model = Discretisation(layout, 2, mixed, 2.0, sticks=True).build(StageClock())
    return model.contact(PARABOLOID)


def incremental(contact):
    """Depths and loads at which the nodes are touched, and their frozen outward displacements, by discs pressed down
    one after the other: dense solves, no factor."""
    surface, f = contact.surface, contact.f
    C, normal, last = surface.C, surface.normal, surface.last
    u, delta, P = np.zeros(len(C)), [0.0], [0.0]
    frozen = np.zeros(len(C))
    for k in range(1, f.size):
        inside = np.arange(last[k - 1] + 1)
        unit = np.isin(inside, normal).astype(float)
        forces = np.linalg.solve(C[np.ix_(inside, inside)], unit)
        rise = C[:, inside] @ forces
        step = (f[k] - (delta[-1] - u[normal[k]])) / (1 - rise[normal[k]])
        u += step * rise
        frozen[last[k]] = u[last[k]]
        delta.append(delta[-1] + step)
        P.append(P[-1] + step * float(forces @ unit))
    return np.array(delta), np.array(P), frozen


def test_one_pass_through_the_factor_is_the_disc_grown_ring_by_ring(contact):
    delta, P, _ = incremental(contact)
    np.testing.assert_allclose(contact.delta, delta, rtol=1e-8, atol=1e-12 * delta[-1])
    np.testing.assert_allclose(contact.P, P, rtol=1e-8, atol=1e-12 * P[-1])


def test_energy_let_go_by_the_outer_ring_is_that_of_both_modes(contact):
    """At a fixed depth below that of touch: (delta_k - delta)^2 dS/2, which makes Eq. 13 hold for stuck surfaces."""
    delta, _, frozen = incremental(contact)
    C, normal, last = contact.surface.C, contact.surface.normal, contact.surface.last
    k, depth = delta.size - 5, 0.6 * delta[-5]

    def energy(set_end):
        inside = np.arange(last[set_end] + 1)
        u = frozen[inside].copy()
        u[normal[: set_end + 1]] = depth - contact.f[: set_end + 1]
        return u @ np.linalg.solve(C[np.ix_(inside, inside)], u) / 2

    released = energy(k) - energy(k - 1)
    dS = contact.S[k] - contact.S[k - 1]
    assert released == pytest.approx((delta[k] - depth) ** 2 * dS / 2, rel=1e-6)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_the_half_space_has_mossakovskis_factor(nu):
    problem = Problem(PARABOLOID, Specimen((), HalfSpace(Elastic(1.0, nu))), Loading("radius", 1.0), True)
    series = FEM()(problem).series
    factor = series.S / (2 / (1 - nu**2) * series.a)
    exact = (1 - nu) * math.log(3 - 4 * nu) / (1 - 2 * nu)
    np.testing.assert_allclose(factor[-10:], exact, atol=1.5e-3)  # measured 1.0e-3; spacing 0.02: 3e-4


def test_an_incompressible_half_space_does_not_notice():
    problem = Problem(PARABOLOID, Specimen((), HalfSpace(Elastic(1.0, 0.5))), Loading("radius", 1.0))
    sliding, sticking = FEM()(problem), FEM()(replace(problem, sticks=True))
    depth = sticking.series.delta[-1]
    there = np.interp(depth, sliding.series.delta, sliding.series.P)
    assert sticking.series.P[-1] == pytest.approx(there, rel=2e-3)


@pytest.mark.slow
def test_errors_fall_with_the_spacing_on_a_confined_layer():
    """First order, since the modes I and II of a ring end at different places; 0.4970882 by the integral equation."""
    errors = []
    for spacing in (0.04, 0.02):
        fem = FEM(spacing=spacing)(Problem(PARABOLOID, bonded(0.499), Loading("depth", 4.304897e-3), True))
        errors.append(abs(fem.series.P[-1] / 0.4970882 - 1))
        assert errors[-1] <= fem.budget.discretisation
    assert errors[0] < 4e-3
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.slow
def test_cylinders_and_flat_ends_stick_too():
    for indenter, side in ((PARABOLOID, "free"), (PARABOLOID, "clamped"), (RoundedFlat(0.4, 100.0), "roller")):
        problem = Problem(indenter, bonded(0.3, 3.0, side), Loading("radius", 1.0), True)
        sticking, sliding = FEM()(problem), FEM()(replace(problem, sticks=False))
        assert np.isfinite(sticking.series.P).all()
        # a stuck end is at least as stiff; the meshes' radii are not the same to round-off
        assert sticking.series.S[-1] > 0.999 * np.interp(sticking.series.a[-1], sliding.series.a, sliding.series.S)


@pytest.mark.parametrize(
    ("method", "indenter", "words"),
    [
        (FEM(contact="incremental"), PARABOLOID, 'set contact.algorithm = "nested"'),
        (FEM(), Paraboloid(1000.0, Elastic(1.0, 0.3)), "use layered"),
    ],
)
def test_what_is_not_represented_is_refused(method, indenter, words):
    with pytest.raises(Refusal, match=words):
        method(Problem(indenter, bonded(0.3), Loading("radius", 1.0), True))

"""Surfaces that stick, by finite elements: against dense solves ring by ring, energies, limits, cost, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from jkrcli.base.errors import Refusal
from jkrcli.base.process import StageClock
from jkrcli.bodies.indenters import Paraboloid, RoundedFlat
from jkrcli.bodies.problem import Elastic, Exponential, Graded, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.fem.fields import contact_state
from jkrcli.fem.mesh import MeshedBody, scaled_layout
from jkrcli.fem.model import Discretisation
from jkrcli.fem.solver import FEM
from jkrcli.methods.layered.solver import Layered

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


@pytest.fixture(scope="module")
def at_touch(contact):
    """The same contact, each node of which sticks at the moment of its touch."""
    return replace(contact, rows=np.zeros_like(contact.rows))


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


def test_one_pass_through_the_factor_is_the_disc_grown_ring_by_ring(at_touch):
    delta, P, frozen = incremental(at_touch)
    np.testing.assert_allclose(at_touch.delta, delta, rtol=1e-8, atol=1e-12 * delta[-1])
    np.testing.assert_allclose(at_touch.P, P, rtol=1e-8, atol=1e-12 * P[-1])
    outward = np.setdiff1d(np.arange(frozen.size), at_touch.surface.normal)
    ours = -(at_touch.L @ at_touch.z)[outward]
    np.testing.assert_allclose(ours, frozen[outward], atol=1e-9 * np.abs(frozen).max())


def test_energy_let_go_by_the_outer_ring_is_that_of_both_modes(at_touch):
    """At a fixed depth below that of touch: (delta_k - delta)^2 dS/2, which makes Eq. 13 hold for stuck surfaces."""
    delta, _, frozen = incremental(at_touch)
    C, normal, last = at_touch.surface.C, at_touch.surface.normal, at_touch.surface.last
    k, depth = delta.size - 5, 0.6 * delta[-5]

    def energy(set_end):
        inside = np.arange(last[set_end] + 1)
        u = frozen[inside].copy()
        u[normal[: set_end + 1]] = depth - at_touch.f[: set_end + 1]
        return u @ np.linalg.solve(C[np.ix_(inside, inside)], u) / 2

    released = energy(k) - energy(k - 1)
    dS = at_touch.S[k] - at_touch.S[k - 1]
    assert released == pytest.approx((delta[k] - depth) ** 2 * dS / 2, rel=1e-6)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_the_half_space_has_mossakovskis_factor(nu):
    problem = Problem(PARABOLOID, Specimen((), HalfSpace(Elastic(1.0, nu))), Loading("radius", 1.0), True)
    series = FEM()(problem).series
    factor = series.S / (2 / (1 - nu**2) * series.a)
    exact = (1 - nu) * math.log(3 - 4 * nu) / (1 - 2 * nu)
    np.testing.assert_allclose(factor[-10:], exact, atol=2e-4)  # measured 6e-5


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


@pytest.mark.slow
def test_auxetic_bodies_take_a_mesh_that_follows_the_edge():
    problem = Problem(PARABOLOID, bonded(-0.5), Loading("radius", 1.0), True)
    with pytest.raises(Refusal, match=r"oscillates: give mesh.spacing = 0.06 or more or use method layered"):
        FEM()(problem)
    fem = FEM(spacing=0.06)(problem)
    exact = Layered()(replace(problem, loading=Loading.given("depth", fem.series.delta[-3:]))).series
    np.testing.assert_allclose(fem.series.P[-3:], exact.P, rtol=fem.budget.discretisation)  # 3e-4; measured 1e-4
    with pytest.raises(Refusal, match=r"mesh.tolerance: 1e-05 is not reached"):
        FEM(tolerance=1e-5)(problem)


# measured 5e-6, 3e-5
@pytest.mark.slow
@pytest.mark.parametrize(("nu", "off"), [(0.0, 1e-5), (0.499, 1e-4)])
def test_the_field_of_a_stuck_contact_carries_its_load(nu, off):
    """At nu = 0 the edge oscillates far from it: elements are not as small there as those of other bodies."""
    problem = Problem(PARABOLOID, bonded(nu), Loading.given("radius", [1.5]), True)
    exact = Layered()(problem).series
    state = contact_state(FEM(), problem, 1.5, float(exact.delta[0]))
    assert state.P == pytest.approx(exact.P[0], rel=off)
    assert state.lines["surface"].load == pytest.approx(state.P, rel=1e-9)


# S/(2 E* a) of flat ends, by tied finite elements of other make and an integral equation
@pytest.mark.slow
@pytest.mark.parametrize(("a", "exact"), [(1.0, 3.929038), (5.0, 106.5713)])
def test_flat_ends_within_their_stated_error(a, exact):
    fem = FEM()(Problem(RoundedFlat(a, 1000.0), bonded(0.5), Loading("radius", 1.05 * a), True))
    error = abs(fem.series.S0 / (2 / 0.75 * a) / exact - 1)
    assert error <= fem.budget.discretisation  # 4e-4
    assert error < 1e-4  # measured 4e-5, 5e-5


@pytest.mark.slow
def test_graded_layers_stick_like_stacks_of_thin_ones():
    law = Exponential(1.0, 3.0, 1.0)
    slices = tuple(Layer(Elastic(float(law.at(np.array([(i + 0.5) / 16]))[0]), 0.4), 1 / 16) for i in range(16))
    exact = Layered()(Problem(PARABOLOID, Specimen(slices, Rigid()), Loading.given("radius", [1.5]), True)).series
    graded = Specimen((Layer(Graded(law, 0.4), 1.0),), Rigid())
    fem = FEM()(Problem(PARABOLOID, graded, Loading.given("depth", exact.delta), True))
    assert abs(fem.series.P[0] / exact.P[0] - 1) <= fem.budget.discretisation  # 3e-4; measured 1.2e-4
    assert abs(fem.series.a[0] / 1.5 - 1) <= fem.budget.radius

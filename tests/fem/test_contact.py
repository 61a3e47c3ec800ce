"""The contact problem on a condensed surface: against brute force, nested against increments, loads and depths."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base.process import StageClock
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic
from jkrcli.fem.elasticity import Surface
from jkrcli.fem.mesh import MeshedBody, scaled_layout
from jkrcli.fem.model import Discretisation, SurfaceContact, nested_events, solve_depths


@pytest.fixture(scope="module")
def models():
    body = MeshedBody((200.0,), (Elastic(2.0, 0.35),), 200.0, True, "free", True, True, completed=True)
    layout = scaled_layout(body, "triangle", 1.0, 0.0, 0.1, 0.1, 0.2)
    return {order: Discretisation(layout, order, (), 1.0).build(StageClock()) for order in (1, 2)}


def brute_force(C, f, delta):
    """All active sets: the one whose forces and gaps are both nonnegative."""
    n = f.size
    for size in range(n + 1):
        for chosen in itertools.combinations(range(n), size):
            A = list(chosen)
            p = np.zeros(n)
            p[A] = np.linalg.solve(C[np.ix_(A, A)], delta - f[A])
            gap = f - delta + C @ p
            if p.min(initial=0) >= -1e-12 and gap.min() >= -1e-12:
                return p
    raise AssertionError("no solution")


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_increments_find_the_one_solution_of_any_positive_definite_problem(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    C = root @ root.T + 0.2 * np.eye(6)
    f, delta = rng.uniform(0, 1, 6), 0.6
    surface = Surface(C, np.arange(1.0, 7), np.ones(6, dtype=bool), np.ones(6), 0, 0.0, 0.0)
    (step,) = solve_depths(SurfaceContact(surface, f), [delta])
    np.testing.assert_allclose(step.p, brute_force(C, f, delta), atol=1e-8 * max(step.p.max(), 1e-300))


@pytest.mark.parametrize("order", [1, 2])
def test_least_squares_find_the_contact_where_newton_s_method_does_not(models, order, monkeypatch):
    contact, depths = models[order].contact(Paraboloid(10.0)), np.linspace(0.01, 0.09, 5)
    loads = [step.P for step in solve_depths(contact, depths)]
    monkeypatch.setattr("jkrcli.fem.model.MOST_STEPS", 0)
    np.testing.assert_allclose([step.P for step in solve_depths(contact, depths)], loads, rtol=1e-10)  # measured: 1e-13


@pytest.mark.parametrize("order", [1, 2])
def test_nested_events_are_solutions_of_the_contact_problem(models, order):
    contact = models[order].contact(Paraboloid(10.0))
    events = nested_events(contact, 0.0, "radius", 1.0)
    assert events.valid
    assert events.violation < 1e-12  # forces and gaps of the right sign, to round-off
    steps = solve_depths(contact, events.delta)
    np.testing.assert_allclose([s.P for s in steps], events.P, rtol=1e-10)
    assert max(s.violation for s in steps) < 1e-12


def test_an_annular_contact_is_noticed_by_nested_and_solved_by_increments(models):
    surface = models[1].surface
    contact = SurfaceContact(surface, (surface.radii - 0.5) ** 2 / 2)
    assert not nested_events(contact, 0.0, "radius", 1.0).valid
    (step,) = solve_depths(contact, [0.01])
    touching = surface.radii[step.active]
    assert touching.min() > 0.2
    assert touching.max() < 0.8
    assert step.violation < 1e-9

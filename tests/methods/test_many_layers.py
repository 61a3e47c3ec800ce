"""Stacks of many layers and tables of many points: what they cost is known at once, by counts that are right."""

from dataclasses import replace

import numpy as np
import pytest
from stopwatch import takes_less_than

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Graded, HalfSpace, Layer, Loading, Problem, Rigid, Specimen, Tabulated
from jkrcli.methods.layered.solver import Layered, largest_radius
from jkrcli.methods.protocol import long_look, method_class, survey


def stack(count: int, loading: Loading | None = None, top: float = 1e-4) -> Problem:
    rest = [Layer(Elastic(1e6 * (1 + i % 7), 0.2 + 0.02 * (i % 9)), 1e-4 / count) for i in range(1, count)]
    layers = (Layer(Elastic(1e6, 0.2), top), *rest)
    return Problem(Paraboloid(1e-3), Specimen(layers, HalfSpace(Elastic(1e7, 0.3))), loading or Loading("radius", 5e-5))


@pytest.mark.fem
@pytest.mark.first(1)
@pytest.mark.parametrize("goal", [Loading("radius", 5e-5), Loading("load", 5e-4)])
def test_three_hundred_layers_are_surveyed_at_once(goal: Loading) -> None:
    problem = stack(300, goal)
    with takes_less_than(1):
        options = {option.name: option for option in survey(problem, lambda name: method_class(name)())}
    assert "elements expected" in options["fem"].refusal


def test_a_wide_contact_is_forecast_without_a_search() -> None:
    """On a thin bonded layer the radius is a hundred times the thickness: the search goes on by powers."""
    layers = (Layer(Elastic(1e6, 0.3), 1e-6),)
    wide = Problem(Paraboloid(1e-2), Specimen(layers, Rigid()), Loading("radius", 1e-4))
    load = float(Layered()(replace(wide, loading=Loading("radius", 1e-4, 5))).series.P[-1])
    assert largest_radius(replace(wide, loading=Loading("load", load))) == pytest.approx(1e-4, rel=0.05)


def graded(points: int) -> Specimen:
    depths = np.linspace(0, 1e-4, points)
    E = 1e6 * (2 + np.sin(3e5 * depths))
    layer = Layer(Graded(Tabulated(tuple(depths.tolist()), tuple(E.tolist())), 0.3), 1e-4)
    return Specimen((layer,), Rigid())


def test_a_table_of_many_points_is_refused() -> None:
    wanted = "E over depth has 20,000 smooth pieces, at most 1,000 are taken; leave out"
    with takes_less_than(2), pytest.raises(InputError, match=wanted):
        graded(20_001)


def test_a_long_look_is_announced() -> None:
    problem = Problem(Paraboloid(1e-3), graded(101), Loading("radius", 1e-5))
    assert long_look(problem) == (
        "a layer with 100 pieces of E over depth: estimating the cost of each method takes about 10 s of CPU time"
    )
    assert long_look(stack(200)) is None

"""Layers of a body by name."""

import pytest

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Specimen, changed, nominal


def test_base_is_the_half_space_even_where_a_layer_is_called_so() -> None:
    layer, below = Layer(Elastic(1e6, 0.4), 1e-6, name="base"), HalfSpace(Elastic(3e6, 0.3))
    problem = Problem(Paraboloid(1e-5), Specimen((layer,), below), Loading("radius", 1e-6, 10))
    assert nominal(problem.specimen, "E:base") == 3e6
    with pytest.raises(InputError, match="a half-space has no thickness"):
        nominal(problem.specimen, "h:base")
    other = changed(problem, {"E:base": 5e6}).specimen
    assert other.layers == (layer,)
    assert nominal(other, "E:base") == 5e6

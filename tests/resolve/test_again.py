"""The one function that solves a body again: which method it takes, what it changes, what it refuses."""

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.methods.protocol import METHODS
from jkrcli.resolve.resolve import exact_methods, resolve_with

GEL = jkr.Specimen((jkr.Layer(jkr.Elastic(1e4, 0.4), 1e-3),), jkr.Rigid())
ON_GEL = jkr.Problem(jkr.Paraboloid(1e-3), GEL, jkr.Loading("radius", 1e-4, 20))
RADII = np.array([1e-4, 2e-4])


def test_methods_say_themselves_what_they_can() -> None:
    assert [type(method).__name__ for method in exact_methods()] == ["ClosedForm", "Layered"]
    assert [name for name, method in METHODS.items() if method.kernel] == ["closed-form", "layered", "hybrid"]


def test_the_least_exact_method_that_represents_the_body_is_taken() -> None:
    found = resolve_with(ON_GEL, RADII)
    assert found.method == "layered"
    np.testing.assert_array_equal(found.series.a, RADII)
    half_space = resolve_with(ON_GEL, RADII, specimen=jkr.Specimen((), jkr.HalfSpace(GEL.layers[0].material)))
    assert half_space.method == "closed-form"
    np.testing.assert_allclose(half_space.series.delta, RADII**2 / 1e-3, rtol=1e-12)  # Hertz
    assert np.all(found.series.P > half_space.series.P)  # the rigid base stiffens


def test_without_slip_the_same_depth_takes_more_load() -> None:
    slip, no_slip = (resolve_with(ON_GEL, RADII, jkr.Layered(1e-4), sticks=sticks).series for sticks in (False, True))
    assert np.all(no_slip.S > slip.S)


def test_what_takes_long_or_has_no_method_is_refused() -> None:
    with pytest.raises(jkr.Refusal, match="the coarse solution would take about"):
        resolve_with(ON_GEL, RADII, longest=0.0)
    narrow = jkr.Specimen(GEL.layers, GEL.base, radius=1e-3, side="free")
    with pytest.raises(jkr.Refusal, match="finite radius"):
        resolve_with(ON_GEL, RADII, specimen=narrow)

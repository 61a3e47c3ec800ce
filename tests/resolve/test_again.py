"""The one function that solves a body again: which method it takes, what it changes, what it refuses."""

from pathlib import Path

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.methods.protocol import METHODS
from jkrcli.resolve.analysis import method_behind
from jkrcli.resolve.resolve import exact_methods, resolve_with

GEL = jkr.Specimen((jkr.Layer(jkr.Elastic(1e4, 0.4), 1e-3),), jkr.Rigid())
ON_GEL = jkr.Problem(jkr.Paraboloid(1e-3), GEL, jkr.Loading("radius", 1e-4, 20))
RADII = np.array([1e-4, 2e-4])


def test_methods_say_themselves_what_they_can() -> None:
    assert [type(method).__name__ for method in exact_methods()] == ["ClosedForm", "Layered"]
    assert {name for name, method in METHODS.items() if not method.kernel} <= {"fem"}


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


FILM = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.3), thickness=5e-6),), jkr.Rigid(bonded=True))
SLIDING = jkr.Problem(jkr.Paraboloid(R=10e-6), FILM, jkr.Loading("radius", 3e-6, 20))


def test_a_configured_method_is_the_one_behind_its_solution() -> None:
    method = jkr.Layered(tolerance=1e-4)
    assert jkr.solve(SLIDING, method).solver == method


def test_a_file_gives_back_the_method_of_its_case(tmp_path: Path) -> None:
    case = jkr.parse_case("""
method = "layered"
indenter = { shape = "paraboloid", radius = "10 um" }
loading = { radius = "3 um", points = 20 }
layered.tolerance = 1e-5
[[specimen.layers]]
thickness = "5 um"
E = "1 MPa"
nu = 0.3""")
    solution = jkr.solve(case)
    again = jkr.read(jkr.save(solution, tmp_path / "x.h5"))
    assert method_behind(again) == solution.solver == jkr.Layered(tolerance=1e-5)


@pytest.mark.slow
def test_a_profile_of_surfaces_that_stick_needs_no_case() -> None:
    sticking = jkr.Problem(SLIDING.indenter, FILM, SLIDING.loading, sticks=True)
    columns = jkr.profile(jkr.solve(sticking), a=2e-6).columns
    assert any("shear" in name for name in columns)

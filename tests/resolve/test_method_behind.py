"""A solution knows the method that made it, as it was configured: of cases, of problems in objects, of files."""

from pathlib import Path

import pytest

import jkrcli as jkr
from jkrcli.methods.protocol import Method
from jkrcli.resolve.analysis import fem_behind, method_behind

GEL = jkr.Specimen((jkr.Layer(jkr.Elastic(E=1e6, nu=0.3), thickness=5e-6),), jkr.Rigid(bonded=True))
SLIDING = jkr.Problem(jkr.Paraboloid(R=10e-6), GEL, jkr.Loading("radius", 3e-6, 20))


@pytest.mark.parametrize("method", [jkr.Layered(tolerance=1e-4), jkr.FEM(spacing=0.1), jkr.Hybrid(tolerance=1e-2)])
def test_a_configured_method_is_the_one_behind_its_solution(method: Method) -> None:
    solution = jkr.solve(SLIDING, method)
    assert solution.solver == method
    assert fem_behind(solution) == (method if isinstance(method, jkr.FEM) else jkr.FEM())


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


def test_a_profile_of_surfaces_that_stick_needs_no_case() -> None:
    sticking = jkr.Problem(SLIDING.indenter, GEL, SLIDING.loading, sticks=True)
    columns = jkr.profile(jkr.solve(sticking), a=2e-6).columns
    assert any("shear" in name for name in columns)

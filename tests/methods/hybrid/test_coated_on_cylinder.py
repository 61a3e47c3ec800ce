"""A coated tip on a cylinder: a coating of its core's material is none, a wide cylinder is the layer without sides."""

from dataclasses import replace

import pytest

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Sphere
from jkrcli.bodies.problem import Coated, Elastic, Layer, Loading, Problem, Rigid, Specimen, without_side_walls
from jkrcli.methods.hybrid import Hybrid
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import analyse, profile_columns, solver_of

CORE, SKIN, GEL = Elastic(3e6, 0.4), Elastic(3e5, 0.4), Elastic(1e6, 0.45)
NARROW = Specimen((Layer(GEL, 3e-3),), Rigid(), radius=8e-3, side="free")
COLUMNS = ("delta", "P", "S", "dS")


def solved(material: object, specimen: Specimen = NARROW) -> object:
    return Hybrid()(Problem(Sphere(1e-2, material), specimen, Loading("radius", 1e-3, 20)))


def test_a_coating_of_the_core_is_no_coating() -> None:
    coated, plain = solved(Coated((Layer(CORE, 1e-4),), CORE)).series, solved(CORE).series
    for name in COLUMNS:
        one, other = getattr(coated, name), getattr(plain, name)
        assert one == pytest.approx(other, rel=1e-5)
        assert (abs(one - other) <= coated.errors[name] + plain.errors[name]).all()


def test_a_wide_cylinder_is_the_layer_without_sides_and_a_narrow_one_is_not() -> None:
    coated = Coated((Layer(SKIN, 1e-4),), CORE)
    wide, narrow = (solved(coated, replace(NARROW, radius=radius)) for radius in (3e-2, 5e-3))
    exact = Layered()(without_side_walls(wide.problem)).series
    for name in COLUMNS:
        off = abs(getattr(wide.series, name) - getattr(exact, name))
        assert (off <= wide.series.errors[name] + 1e-6 * getattr(exact, name)).all()
    assert abs(narrow.series.S[-1] / exact.S[-1] - 1) > 1e-4


def test_pull_off_is_solved_with_the_kept_kernel() -> None:
    solution = solved(Coated((Layer(SKIN, 1e-4),), CORE))
    assert solver_of(solution) is not None
    point, exact = (analyse(one, [0.05])[0].pull_off["load"]
                    for one in (solution, Layered()(without_side_walls(solution.problem))))  # fmt: skip
    assert point.P == pytest.approx(exact.P, rel=2e-3)  # as the side changes it


def test_without_sides_and_for_profiles_it_is_refused() -> None:
    solution = solved(Coated((Layer(SKIN, 1e-4),), CORE))
    with pytest.raises(Refusal, match="how a coated indenter and the specimen share the displacement is not derived"):
        profile_columns(solution, 5e-4, 0.05, None)
    assert "use method layered" in str(Hybrid().refusal(without_side_walls(solution.problem)))

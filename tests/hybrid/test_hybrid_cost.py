"""What the hybrid costs: foretold, bounded, refused before it is begun; and whether its discs hold."""

from dataclasses import replace

import numpy as np
import pytest
from finite_bodies import FINITE, cylinder, stack
from scipy.sparse.linalg import splu
from stopwatch import takes_less_than

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, PowerLaw
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.hybrid import kernel
from jkrcli.hybrid.correction import Mesh, Region, correction, lines
from jkrcli.hybrid.kernel import AdaptiveKernel, ErrorEstimates, Refinement
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.layered.solver import Layered

PARABOLOID = Paraboloid(1000.0)
BODIES = {
    "sliding, nu = 0.4986": (stack((1.0, 0.4986, 1.0), base=Rigid(False)), 2.0),
    "sliding, nu = 1/2, thin": (stack((1.0, 0.5, 1.0), base=Rigid(False)), 15.0),
    "thin": (stack((1.0, 0.4997, 1.0)), 16.0),
    "on something 4000 times as stiff": (stack((1.0, 0.5, 1.0), base=HalfSpace(Elastic(4000.0, 0.3))), 0.36),
    "two layers": (stack((1.0, 0.3, 1.0), (270.0, 0.3, 2.0)), 1.6),
    "clamped": (FINITE["clamped, nu = 0.499"], 1.0),
}


@pytest.mark.parametrize("name", BODIES)
def test_bodies_of_layers_are_forecast_to_take_seconds(name: str) -> None:
    assert 0.01 < Hybrid().forecast(_problem(name)).seconds < 3.0


def _problem(name: str) -> Problem:
    specimen, a = BODIES[name]
    return Problem(PARABOLOID, specimen, Loading("radius", a, 20))


def test_a_contact_beyond_the_limits_is_refused_before_it_is_begun() -> None:
    problem = Problem(PARABOLOID, cylinder(2000.0, 1.0, "free", 0.5), Loading("radius", 1000.0))
    with takes_less_than(0.5):
        reason = Hybrid().refusal(problem)
    assert reason.startswith("contact radii up to 1 km need elements of degree ")
    assert reason.endswith(
        "(limits 60 s, 4096 MiB): the contact is large against the nearest interface or side (1 m away); use a "
        "smaller contact or a larger hybrid.tolerance, or use method fem"
    )
    with pytest.raises(Refusal):
        Hybrid()(problem)
    thin = Specimen((Layer(Elastic(1e6, 0.4), 1e-9),), Rigid(), 10.0, "free")  # its lines alone would take 14 GiB
    assert "use a smaller contact" in Hybrid().refusal(Problem(Paraboloid(1e3), thin, Loading("radius", 1.0)))
    skin = Specimen((Layer(Elastic(1.0, 0.3), 5e-4), Layer(Elastic(1.0, 0.5), 1.0)), Rigid(), 2.0, "free")
    told = Hybrid().refusal(Problem(PARABOLOID, skin, Loading("radius", 1.0)))
    assert "more than 10 min and more than 40960 MiB (limits 60 s, 4096 MiB)" in told


def judged(elements: float, parameters: float, cut: float) -> ErrorEstimates:
    rows = (np.full((4, 1), error) for error in (elements, parameters, cut))
    return ErrorEstimates(np.ones(1), *rows)


def test_the_largest_error_is_what_is_refined() -> None:
    sliding = Region.of(stack((1.0, 0.3, 1.0), base=Rigid(False)), 1.0, 1e-6)
    first = Refinement()
    finer = first.after(judged(1e-3, 5e-6, 1e-4), 1e-5, sliding)
    assert (finer.degree, finer.more, finer.sharper) == (first.degree + 2, 0, 1.0)
    both = first.after(judged(1e-3, 1e-4, 1e-4), 1e-5, sliding)  # or the higher degree would be computed twice
    assert (both.degree, both.added) == (first.degree + 2, 1)
    assert both.more >= 1
    fuller = first.after(judged(1e-6, 1e-4, 1e-5), 1e-5, sliding)
    assert (fuller.degree, fuller.sharper) == (first.degree, 1.0)
    assert fuller.more >= 1
    wider = first.after(judged(1e-6, 1e-6, 2e-5), 1e-5, sliding)
    assert (wider.degree, wider.more, wider.sharper) == (first.degree, 0, pytest.approx(8.0))


def test_what_no_longer_gets_better_is_given_up() -> None:
    region = Region.of(FINITE["free"], 1.0, 1e-6)
    step = Refinement().after(judged(1e-2, 0.0, 0.0), 1e-5, region)
    assert step.after(judged(9e-3, 0.0, 0.0), 1e-5, region) is None  # hopeless
    near = Refinement().after(judged(2e-5, 0.0, 0.0), 1e-5, region)
    again = near.after(judged(1.9e-5, 0.0, 0.0), 1e-5, region)
    assert again.after(judged(1.8e-5, 0.0, 0.0), 1e-5, region) is None


def test_a_plate_that_lifts_is_said_so_by_both_methods() -> None:
    specimen = stack((1.0, 0.3, 1.0), (1e-3, 0.3, 4.0))
    problem = Problem(PowerLaw(1e-3, 4.0), specimen, Loading("radius", 3.0, 10))
    exact, found = Layered()(problem), Hybrid(1e-4)(problem)
    assert "tension in the middle of the contact," in exact.warnings[0]
    assert "tension in the middle of the contact," in found.warnings[0]
    wide = replace(specimen, radius=40.0, side="clamped")
    assert "tension in the middle of the contact," in Hybrid(1e-4)(replace(problem, specimen=wide)).warnings[0]


def test_no_correction_is_computed_again_for_more_parameters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a squeezed layer, wide against its depth, which needs more of them than a soft one: ten before."""
    solved = []
    monkeypatch.setattr(kernel, "correction", lambda *given: solved.append(given[2]) or correction(*given))
    problem = Problem(PARABOLOID, stack((1.0, 0.499, 1.0)), Loading("radius", 16.0, 10))
    Hybrid(1e-6)(problem)
    assert len(solved) <= 6
    assert solved.count(max(solved)) == 1


def test_levels_say_what_they_cost() -> None:
    for specimen in FINITE.values():
        levels = AdaptiveKernel(PARABOLOID, specimen, 1e-5).levels(1.0)
        assert levels.cost(8).unknowns == pytest.approx(levels.correction(8).unknowns, rel=0.35)


# Incompressible layers of great contrast on something soft: its far field reaches over 10^7 contact radii.
GREAT_CONTRAST = stack((4e6, 0.5, 6.0), (5e4, 0.0, 11.0), (3.5e9, 0.5, 2.3), base=HalfSpace(Elastic(2.2e4, 0.5)))


def test_pressures_in_great_contrasts_are_eliminated_without_pivots() -> None:
    """Entries of the factor per entry of the matrix: 1.8; by pivots, which its zeros asked for, 16."""
    levels = AdaptiveKernel(PARABOLOID, GREAT_CONTRAST, 1e-5).levels(1.0)
    mesh = Mesh(levels.region, *lines(levels.region, 6))
    matrix = mesh.stiffness[mesh.order][:, mesh.order].tocsc()
    lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    assert (lu.perm_r == np.arange(mesh.order.size)).all()
    assert lu.L.nnz + lu.U.nnz < 3 * matrix.nnz
    np.testing.assert_array_equal(np.sort(mesh.order), mesh.free)


def test_wide_layers_that_would_take_elements_long_are_solved_by_layered() -> None:
    thin = Problem(PARABOLOID, stack((1.0, 0.3, 1.0), (2.0, 0.4, 1.0), (1.0, 0.3, 1.0)), Loading("radius", 60.0, 5))
    assert Hybrid().refusal(thin) is None
    assert Hybrid().forecast(thin).seconds < 1.0
    assert Hybrid().forecast(thin).note.endswith("by method layered")
    found, exact = Hybrid()(thin), Layered(1e-5)(thin)
    assert found.method == "layered"
    assert found.solver == Layered(1e-5)
    np.testing.assert_array_equal(found.series.S, exact.series.S)
    assert "hybrid: elements would take" in found.warnings[0]
    assert "solved by method layered, exact for layers without sides" in found.warnings[0]
    own = Hybrid(1e-3)(_problem("two layers"))
    assert (own.method, own.solver) == ("hybrid", Hybrid(1e-3))

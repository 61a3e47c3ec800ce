"""Layers on the indenter: the compliances of both bodies add, so that either may carry the layers."""

from dataclasses import replace

import numpy as np
import pytest

import jkrcli
from jkrcli.base.errors import InputError, Refusal
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import (
    Coated,
    Elastic,
    HalfSpace,
    Layer,
    Loading,
    Problem,
    Rigid,
    Specimen,
    TransverselyIsotropic,
    alone,
)
from jkrcli.case.models import case_of, parse_case
from jkrcli.methods.layered.no_slip import StuckSpectrum
from jkrcli.methods.layered.solver import Layered, surface_profile
from jkrcli.methods.layered.spectrum import deviation
from jkrcli.methods.protocol import METHODS, method_class, refusal_of
from studies.stack_judge import compliance_ratio, compliances, contact

R = 50e-6
CORE, FILM, SOFT = Elastic(2e9, 0.3), Elastic(9e6, 0.45), Elastic(3e6, 0.5)
THREADS = TransverselyIsotropic(30e6, 9e6, 0.3, 0.2, 4e6)
RADII = Loading.given("radius", (0.5e-6, 2e-6, 6e-6))
ON_RIGID = Specimen((Layer(SOFT, 5e-6),), Rigid())


def coated(*layers: Layer) -> Paraboloid:
    return Paraboloid(R, Coated(layers, CORE))


def columns(indenter, specimen, sticks=False, tolerance=1e-11):
    series = Layered(tolerance)(Problem(indenter, specimen, RADII, sticks)).series
    return np.array([series.delta, series.P, series.S, series.dS])


@pytest.mark.parametrize(("film", "sticks", "tolerance"), [(THREADS, False, 1e-11), (FILM, True, 1e-8)])
def test_the_layers_may_be_on_either_body(film, sticks, tolerance):
    layers = Layer(film, 3e-6), Layer(SOFT, 1e-6)
    one = columns(coated(*layers), Specimen((), HalfSpace(FILM)), sticks, tolerance)
    other = columns(Paraboloid(R, FILM), Specimen(layers, HalfSpace(CORE)), sticks, tolerance)
    assert one == pytest.approx(other, rel=1e-10)


@pytest.mark.parametrize(
    ("layers", "specimen"),
    [
        ((Layer(FILM, 2e-6),), ON_RIGID),
        ((Layer(CORE, 1e-6), Layer(SOFT, 3e-6)), Specimen((Layer(FILM, 1e-6),), Rigid(bonded=False))),
    ],
)
def test_two_stacks_add_as_an_independent_solver_adds_them(layers, specimen):
    indenter = Specimen(layers, HalfSpace(CORE))
    judged = contact(specimen, R, np.array(RADII.values), indenter)
    assert columns(coated(*layers), specimen) == pytest.approx(judged, rel=1e-9)
    k = np.geomspace(1e2, 1e8, 30)
    E_star = 1 / (1 / specimen.surface.E_star + 1 / indenter.surface.E_star)
    g = sum(E_star / body.surface.E_star * compliance_ratio(body, k) for body in (specimen, indenter))
    assert 1 + deviation(specimen, k, Coated(layers, CORE)) == pytest.approx(g, rel=1e-11)


def test_shear_of_two_stacks_that_stick_acts_against_each_other():
    layers, specimen = (Layer(FILM, 2e-6),), Specimen((Layer(Elastic(3e6, 0.2), 5e-6),), Rigid())
    spectrum, k = StuckSpectrum(specimen, Coated(layers, CORE)), np.geomspace(1e4, 1e7, 20)
    own = compliances(Specimen(layers, HalfSpace(CORE)), k) / FILM.G
    both = compliances(specimen, k) / specimen.surface.G + own * np.array([[1.0], [-1.0], [1.0]])
    half_spaces = (1 - 0.45) / FILM.G + (1 - 0.2) / specimen.surface.G
    expected = both / half_spaces - np.array([[1.0], [spectrum.beta], [1.0]])
    assert spectrum.deviations(k) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_what_touches_has_the_modulus_of_the_outermost_layer():
    problem = Problem(coated(Layer(FILM, 2e-6)), Specimen((), HalfSpace(SOFT)), RADII)
    assert pytest.approx(1 / (1 / FILM.E_star + 1 / SOFT.E_star), rel=1e-14) == problem.E_star
    assert problem.scaled(3.0).E_star == pytest.approx(3 * problem.E_star, rel=1e-14)
    assert alone(problem).indenter == Paraboloid(R, FILM)
    assert "coated (E = 9 MPa" in problem.words
    assert problem.key != replace(problem, indenter=coated(Layer(FILM, 3e-6))).key
    assert not problem.is_half_space
    assert problem.top_thickness == 2e-6
    thrice = Layered()(problem.scaled(3.0)).series
    assert thrice.P == pytest.approx(3 * Layered()(problem).series.P, rel=1e-11)


@pytest.mark.parametrize("name", [name for name, method in METHODS.items() if not method.coating])
def test_other_methods_refuse_with_the_remedy(name):
    method = method_class(name)()
    problem = Problem(coated(Layer(FILM, 2e-6)), ON_RIGID, RADII)
    assert "method layered" in refusal_of(name, method, problem)
    with pytest.raises(Refusal, match=r"leave indenter\.layers out"):
        method(problem)
    cylinder = replace(problem, specimen=replace(ON_RIGID, radius=1e-4, side="free"))
    assert "method layered" not in refusal_of(name, method, cylinder)


def test_the_profile_of_each_body_is_refused():
    with pytest.raises(Refusal, match=r"indenter\.layers"):
        surface_profile(Problem(coated(Layer(FILM, 2e-6)), ON_RIGID, RADII), 1e-6, 0.0)


CASE = """
[indenter]
shape = "sphere"
radius = "50 um"
E = "2 GPa"
nu = 0.3
{layers}
[specimen.half_space]
E = "3 MPa"
nu = 0.5
[loading]
radius = ["3 um"]
"""
LAYER = '[[indenter.layers]]\nname = "brush"\nthickness = "2 um"\nE = "9 MPa"\nnu = 0.45\n'
ACROSS = '[[indenter.layers]]\nthickness = "1 um"\nE_p = 3e7\nE_z = 9e6\nnu_p = 0.3\nnu_zp = 0.2\nG_z = 4e6\n'


def case(layers: str, text: str = CASE):
    return parse_case(text.format(layers=layers).encode(), "tip.toml")


def test_a_case_says_the_layers_and_a_series_keeps_them(tmp_path):
    problem = case(LAYER).model.problem()
    assert problem.indenter == Sphere(R, Coated((Layer(FILM, 2e-6),), CORE))
    assert case_of(problem).model.problem() == problem
    assert case(ACROSS + LAYER).model.problem().coatings == (Layer(THREADS, 1e-6), Layer(FILM, 2e-6))
    path = tmp_path / "tip.h5"
    jkrcli.save(jkrcli.solve(case(LAYER)), path)
    assert jkrcli.read(path).problem == problem


@pytest.mark.parametrize(
    ("layers", "words"),
    [
        (LAYER.replace("thickness", "thicknes"), r'indenter\.layers\[0\]\.thicknes: .*did you mean "thickness"'),
        (LAYER.replace('"9 MPa"', "-9"), r"indenter\.layers\[0\]\.E: must be > 0"),
        (LAYER.replace('"9 MPa"', '{law = "linear", top = 1e6, bottom = 2e6}'), r"layers\[0\]\.E: .*homogeneous"),
    ],
)
def test_mistakes_in_the_layers_are_named(layers, words):
    with pytest.raises(InputError, match=words):
        case(layers)


def test_layers_need_a_core():
    with pytest.raises(InputError, match=r"indenter: .*core"):
        case(LAYER, CASE.replace('E = "2 GPa"\nnu = 0.3\n{', "{"))

"""Good case files: units, defaults, the resolved case, and the problem that comes out."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jkrcli.base import units
from jkrcli.base.errors import counted
from jkrcli.bodies.indenters import (
    FlatPunch,
    Paraboloid,
    PowerLaw,
    Pyramid,
    RoundedCone,
    RoundedFlat,
    Sphere,
    TableProfile,
)
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Rigid, Specimen
from jkrcli.case import models
from jkrcli.case.models import load_case, parse_case
from jkrcli.case.store import solve
from jkrcli.cli.case_verbs import TEMPLATE
from jkrcli.measured.parameters import show_within

SHIPPED = Path(__file__).parents[2] / "cases"
CASES = sorted([*SHIPPED.glob("*.toml"), *SHIPPED.glob("paper/*.toml")])


def case_of(indenter: str, specimen: str = "half_space = {E = 1, nu = 0.3}", loading: str = "depth = 0.1"):
    return parse_case(f"[indenter]\n{indenter}\n[specimen]\n{specimen}\n[loading]\n{loading}".encode(), "x.toml").model


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_shipped_cases_load_and_their_resolved_form_is_the_same_case(path: Path) -> None:
    case = load_case(path)
    again = parse_case(case.to_toml().encode(), "resolved")
    assert again.model == case.model
    assert again.model.problem().key == case.model.problem().key


def test_halfspace_is_the_papers_case() -> None:
    model = load_case(SHIPPED / "halfspace.toml").model
    problem = model.problem()
    assert problem.indenter == Sphere(100e-6)
    assert problem.specimen == Specimen((), HalfSpace(Elastic(5e9, 0.4)))
    assert problem.loading == Loading("depth", 3e-6, 100, "radius")
    assert (model.adhesion.w, model.adhesion.z0, model.method) == ((50.0,), 0.3e-9, "fem")
    assert (model.mesh.depth, model.mesh.width, model.mesh.layout) == (2e-3, 1.2e-3, "zones")  # 20 R, 12 R


def test_template_is_a_valid_case_and_so_are_its_commented_options() -> None:
    template = TEMPLATE.read_text(encoding="utf-8")
    assert parse_case(template.encode(), "new").model.method == "auto"
    tables = re.sub("(?m)^# ", "", template[template.index("# [layered]") :])
    assert parse_case((template + tables).encode(), "new").model == parse_case(template.encode(), "new").model


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("shape='sphere'\nradius='1 mm'", Sphere(1e-3)),
        ("shape='paraboloid'\nradius=2\ncounter_radius=2", Paraboloid(1.0)),
        ("shape='paraboloid'\nradius=2\ncounter_radius=-4", Paraboloid(4.0)),
        ("shape='power'\ncoefficient=3\nexponent=4", PowerLaw(3.0, 4.0)),
        ("shape='cone'\nhalf_angle='45 deg'", PowerLaw(1 / np.tan(np.pi / 4), 1.0)),
        ("shape='pyramid'\nhalf_angle='35 deg'", Pyramid.of(4, np.radians(35))),
        ("shape='three-sided-pyramid'\nhalf_angle='65 deg'", Pyramid.of(3, np.radians(65))),
        ("shape='pyramid'\nhalf_angle='35 deg'\nequal='area'", Pyramid.of(4, np.radians(35), equal="area")),
        ("shape='rounded-cone'\nradius='20 nm'\nhalf_angle='20 deg'", RoundedCone(2e-8, np.radians(20))),
        (
            "shape='rounded-cone'\nradius='20 nm'\nhalf_angle='20 deg'\ncap='parabola'",
            RoundedCone(2e-8, np.radians(20), cap="parabola"),
        ),
        ("shape='flat'\nradius='1 mm'", FlatPunch(1e-3)),
        ("shape='flat'\nflat_radius='1 um'\nedge_radius='2 nm'", RoundedFlat(1e-6, 2e-9)),
        ("shape='table'\nr=[0,1,2]\nf=[0,1,4]", TableProfile((0.0, 1.0, 2.0), (0.0, 1.0, 4.0))),
        ("shape='sphere'\nradius=1\nE='1 GPa'\nnu=0.5", Sphere(1.0, Elastic(1e9, 0.5))),
    ],
)
def test_shapes(text: str, expected: object) -> None:
    problem = case_of(text).problem()
    assert problem.indenter == expected
    assert models.case_of(problem).model.problem() == problem


def test_layers_on_each_base() -> None:
    layers = "layers = [{thickness='1 um', E='1 MPa', nu=0.5}, {thickness='2 um', E=3, nu=0, name='glue'}]\n"
    stack = (Layer(Elastic(1e6, 0.5), 1e-6), Layer(Elastic(3.0, 0.0), 2e-6))
    bases = {
        "": Rigid(True),
        "base='frictionless'": Rigid(False),
        "half_space={E=7,nu=0.1}": HalfSpace(Elastic(7.0, 0.1)),
    }
    for text, base in bases.items():
        built = case_of("shape='sphere'\nradius=1", layers + text).problem().specimen
        assert built == Specimen(stack, base)


def test_loading_by_each_quantity() -> None:
    for text, expected in {
        "depth='3 um'": Loading("depth", 3e-6, 100, "radius"),
        "load='2 mN'\npoints=7\nspacing='depth'": Loading("load", 2e-3, 7, "depth"),
        "radius=[1e-6,2e-6]": Loading.given("radius", (1e-6, 2e-6)),
    }.items():
        assert case_of("shape='sphere'\nradius=1", loading=text).problem().loading == expected


@given(st.integers(1, 10**9), st.sampled_from(sorted(units.UNITS["length"])))
def test_units_are_exact_powers_of_ten(mantissa: int, unit: str) -> None:
    assert units.parse(f"{mantissa} {unit}", "length") == float(f"{mantissa}e{units.UNITS['length'][unit]}")


@given(st.floats(1e-12, 1e12), st.sampled_from(sorted(units.UNITS)))
def test_shown_values_read_back(value: float, dimension: str) -> None:
    assert units.parse(units.show(value, dimension, 12), dimension) == pytest.approx(
        value, rel=1e-11
    )  # 12 digits shown


def test_notations_of_the_work_of_adhesion() -> None:
    for text in ("35 mJ/m^2", "35 mJ/m2", "35 mJ/m²", "35 mJ m^-2", "35mN/m", "35 erg/cm^2", "0.035"):
        assert units.parse(text, "work") == 0.035


def test_shown_values_are_rounded_before_the_unit_is_chosen() -> None:
    assert units.show(0.99999999e-6, "length") == "1 um"
    assert units.show(999.4e-9, "length") == "999.4 nm"
    assert units.show(-0.999999e-3, "load") == "-1 mN"
    assert units.show(2.613e-7, "length", 2) == "260 nm"


@pytest.mark.parametrize(("value", "error", "words"), [
    (2e-12, 29.166e-6, "0 ± 29 uJ/m^2"), (-2e-12, 2.9e-6, "0.0 ± 2.9 uJ/m^2"), (0.0, 0.0291, "0 ± 29 mJ/m^2"),
    (0.3e-3, 2.04e-3, "0.3 ± 2.0 mJ/m^2"), (55e-3, 0.3e-3, "55 mJ/m^2 ± 300 uJ/m^2"), (1e-3, math.inf, "1 mJ/m^2 ± "),
])  # fmt: skip
def test_a_value_within_a_larger_error_takes_its_unit(value: float, error: float, words: str) -> None:
    assert show_within(value, error, "work").startswith(words)


def test_one_of_a_thing_has_no_plural() -> None:
    assert [counted(n, "row") for n in (0, 1, 1200)] == ["0 rows", "1 row", "1,200 rows"]
    assert counted(2, "radius", "radii") == "2 radii"


BODY = """
indenter = { shape = "paraboloid", radius = 1.0 }
specimen.half_space = { E = 1.0, nu = 0.3 }
[loading]
"""


@pytest.mark.parametrize(
    ("loading", "rows"), [("depth = [1e-6]", 1), ("radius = 0.001", 100), ("radius = [0.001]\npoints = 7", 7)]
)
def test_one_value_in_brackets_is_one_row(loading: str, rows: int) -> None:
    case = parse_case((BODY + loading).encode(), "case")
    series = solve(case)[1].series
    assert len(series) == rows
    assert series.a[-1] == pytest.approx(1e-3)
    again = parse_case(case.to_toml().encode(), "case")
    assert again.model.problem().key == case.model.problem().key

"""The Tabor number's counterparts on layers and coatings."""

from __future__ import annotations

import math

import pytest

from jkrcli.adhesion.validity import layer_tabor
from jkrcli.base.errors import InputError
from jkrcli.base.unknown import Unknown
from jkrcli.bodies.indenters import Paraboloid, PowerLaw
from jkrcli.bodies.materials import Elastic
from jkrcli.bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen

Z0 = 0.3e-9


def problem(specimen: Specimen, indenter=None) -> Problem:
    return Problem(indenter or Paraboloid(1e-3), specimen, Loading("radius", 1e-5))


def bonded(nu: float, base=None, E: float = 5e9) -> Problem:
    return problem(Specimen((Layer(Elastic(E, nu), 1e-6),), base or Rigid()))


def test_a_thin_bonded_layer_by_its_neck_height() -> None:
    """The thin layer of the paper's Sec. 4.2: w = 10 J/m^2, h = 1 um; the height is where the curve ends at a = 0."""
    K = 5e9 * 0.6 / (1e-6 * 1.4 * 0.2)  # Eq. 22
    found = layer_tabor(bonded(0.4), 10.0, Z0)
    assert found["tabor_thin_layer"] == pytest.approx(math.sqrt(20.0 / K) / Z0, rel=1e-14)
    assert found["tabor_thin_layer"] == pytest.approx(144, abs=0.5)
    assert found["regime_thin_layer"] == "JKR holds"
    weak = layer_tabor(bonded(0.4), 1e-3, Z0)
    assert weak["regime_thin_layer"].startswith("JKR is doubtful: use the Maugis-Dugdale")
    assert layer_tabor(bonded(0.4), 1e-7, Z0)["regime_thin_layer"].startswith("JKR does not hold: use DMT")


@pytest.mark.parametrize(
    ("body", "w", "z0", "reason"),
    [
        (bonded(0.499), 1.0, Z0, "nu = 0.499 is above 0.45: the layer is not compressible (Eq. 22)"),
        (
            bonded(0.3, Rigid(bonded=False)),
            1.0,
            Z0,
            "the layer slides on its base: the literature has bonded layers only",
        ),
        (bonded(0.3), 1.0, None, "no equilibrium distance z0 given"),
        (bonded(0.3), 0.0, Z0, "no adhesion (w = 0)"),
    ],
)
def test_where_there_is_no_number_it_says_why(body: Problem, w: float, z0: float | None, reason: str) -> None:
    found = layer_tabor(body, w, z0)
    assert found == {"tabor_thin_layer": Unknown(reason), "regime_thin_layer": f"unknown: {reason}"}


def test_a_coating_lies_between_its_materials() -> None:
    body = bonded(0.4, HalfSpace(Elastic(5e6, 0.4)))
    found = layer_tabor(body, 10.0, Z0)
    assert found["tabor_of_coating"] == pytest.approx(471, abs=0.5)  # the number of Sec. 4.2, same R, w and E*
    assert found["tabor_of_substrate"] == pytest.approx(found["tabor_of_coating"] * 1000 ** (2 / 3), rel=1e-12)
    assert found["regime_coated"] == "JKR holds"
    weak = layer_tabor(body, 2e-3, Z0)
    assert weak["regime_coated"] == (
        "from the coating's to the substrate's: JKR is doubtful: use the Maugis-Dugdale transition model; JKR holds"
    )


def test_a_cone_has_none_on_a_coating_and_other_bodies_have_none_at_all() -> None:
    coated = Specimen((Layer(Elastic(5e9, 0.4), 1e-6),), HalfSpace(Elastic(5e6, 0.4)))
    found = layer_tabor(problem(coated, PowerLaw(0.3, 1.0)), 10.0, Z0)
    assert str(found["tabor_of_coating"]).startswith("the indenter has no tip radius")
    assert layer_tabor(problem(Specimen((), HalfSpace(Elastic(1e9, 0.3)))), 1.0, Z0) == {}
    layer = Layer(Elastic(5e9, 0.4), 1e-6)
    assert layer_tabor(problem(Specimen((layer, layer), Rigid())), 1.0, Z0) == {}


def test_change_of_units() -> None:
    length, force = 1e3, 1e-4
    here = layer_tabor(bonded(0.3), 10.0, Z0)["tabor_thin_layer"]
    scaled = problem(Specimen((Layer(Elastic(5e9 * force / length**2, 0.3), 1e-6 * length),), Rigid()))
    there = layer_tabor(scaled, 10.0 * force / length, Z0 * length)["tabor_thin_layer"]
    assert there == pytest.approx(here, rel=1e-13)


def test_impossible_numbers_are_refused() -> None:
    with pytest.raises(InputError, match="Tabor number: w and z0 must be > 0, got -1 and 3e-10"):
        layer_tabor(bonded(0.3), -1.0, Z0)

"""Names of spring and dashpot models for fitted laws of relaxation."""

from __future__ import annotations

import math

import pytest

from jkrcli.viscoelastic.rheology import values_of


def test_both_forms_of_the_solid_are_one() -> None:
    """The modulus of one form times the compliance of the other is 1 at any rate s."""
    E_inf, E2, eta, series, viscosity, retardation = values_of("sls", {"ratio": 0.25, "time": 3.0}, 2.0)
    assert (E_inf, E2, eta, retardation) == pytest.approx((0.5, 1.5, 4.5, 12.0))
    for s in (0.01, 0.3, 20.0):
        modulus = E_inf + E2 * s / (s + E2 / eta)
        assert modulus * (1 / 2.0 + 1 / (series + viscosity * s)) == pytest.approx(1)


def test_a_power_law_by_its_modulus_at_one_second() -> None:
    assert values_of("power", {"time": 0.01, "exponent": 0.2}, 5.0) == [pytest.approx(5 * 0.01**0.2), 0.2]


def test_terms_of_a_series_are_springs_and_dashpots() -> None:
    p = {"weight1": 0.25, "time1": 2.0, "weight2": 0.5, "time2": 8.0}
    assert values_of("prony", p, 4.0) == pytest.approx([1, 1, 2, 2, 16])


@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_a_body_that_relaxes_altogether_or_not_at_all_has_no_kelvin_voigt_element(ratio: float) -> None:
    left, lost, eta, *element = values_of("sls", {"ratio": ratio, "time": 3.0}, 2.0)
    assert (left, lost, eta) == pytest.approx((2 * ratio, 2 - 2 * ratio, 6 - 6 * ratio))
    assert all(map(math.isnan, element))

"""The dissipating zone at the edge: its size, what is said of it, and where nothing is known of it."""

import math

import pytest

from jkrcli.adhesion.validity import zone
from jkrcli.base.errors import Unknown


def test_the_width_is_dugdales_and_its_shares_are_said() -> None:
    found = zone(2.0, 1.0, 1e6, 1e-3, 1e-4, 1e5, None)
    assert found.width == pytest.approx(math.pi * 1e6 * 2 / (4 * 1e10))
    assert found.over_a == pytest.approx(found.width / 1e-3)
    assert found.over_h == pytest.approx(found.width / 1e-4)
    assert found.words == "160 um, 0.16 of the contact radius and 1.6 of the layer's thickness"
    assert ["contact radius" in line or "layer" in line for line in found.warnings] == [True, True]


def test_a_half_space_has_no_share_of_a_layer() -> None:
    found = zone(1.0, 0.05, 1e9, 1e-4, math.inf, None, 1e-9)  # 50 MPa
    assert isinstance(found.over_h, Unknown)
    assert found.words == "310 nm, 0.0031 of the contact radius"
    assert found.warnings == []


def test_less_than_an_atom_is_no_size() -> None:
    found = zone(0.07, 0.035, 2e4, 1e-3, 1e-4, None, 3e-10)
    for size in (found.width, found.over_a, found.over_h):
        assert isinstance(size, Unknown)
    assert "116.7 MPa, its size would be 0.081 pm, less than an atom" in found.words
    assert found.warnings == []


def test_without_a_stress_nothing_is_known() -> None:
    assert zone(1.0, 1.0, 1e6, 1e-3, 1e-4, None, None).words == (
        "unknown: no cohesive stress or range of adhesion is known: --stress"
    )

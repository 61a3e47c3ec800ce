"""The tests' own layer against limits that need no program: a half-space, and flat ends on a layer of nu = 1/2."""

import numpy as np
import pytest
from layer_contact import BondedLayer, contact, half_space


@pytest.mark.parametrize(
    ("a", "true"), [(0.5, 1.932934), (0.7, 2.522355), (1.0, 3.618736), (2.0, 9.149450), (5.0, 50.139738)]
)
def test_flat_ends_on_an_incompressible_layer(a: float, true: float) -> None:
    assert contact(a, 0.5)[2] / (2 * a) == pytest.approx(true, rel=2e-7)  # their seven digits


@pytest.mark.slow
def test_a_thick_layer_is_a_half_space_and_slopes_agree() -> None:
    a, R = np.geomspace(1e-3, 1e-2, 5), 1.0
    for ours, plain in zip(BondedLayer(1.0, 0.4)(a, R), half_space(a, R), strict=True):
        np.testing.assert_allclose(ours, plain, rtol=0.02)
    near = np.linspace(0.99, 1.01, 3)
    delta, P, S, dS = (np.array([contact(a, 0.3)[i] for a in near]) for i in range(4))
    assert (P[2] - P[0]) / (delta[2] - delta[0]) == pytest.approx(S[1], rel=1e-4)
    assert (S[2] - S[0]) / 0.02 == pytest.approx(dS[1], rel=1e-4)

"""g(k) of a stack against closed forms, 2500-digit arithmetic and exact identities."""

import numpy as np
import pytest
from compliance import compliance_ratio
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Specimen
from jkrcli.methods.layered.spectrum import LayeredSpectrum, deviation

ROUNDING = 1e-14  # relative: some forty operations in double precision
NUS = [-0.9, 0.0, 0.3, 0.499, 0.5]


def one_layer(nu: float, base: Rigid | HalfSpace, h: float = 1.0, E: float = 1.0) -> Specimen:
    return Specimen((Layer(Elastic(E, nu), h),), base)


def bonded(y: np.ndarray, nu: float) -> tuple[np.ndarray, np.ndarray]:
    """g and g - 1 of one bonded layer at y = kh, divided by exp(2y); for y that cancel nothing."""
    kappa, decay = 3 - 4 * nu, np.exp(-2 * y)
    below = kappa * (1 + decay**2) + (1 + kappa**2 + 4 * y**2) * decay
    g = (kappa * (1 - decay**2) - 4 * y * decay) / below
    return g, -decay * (2 * kappa * decay + 4 * y + 1 + kappa**2 + 4 * y**2) / below


@pytest.mark.parametrize("nu", NUS)
def test_bonded_layer(nu: float) -> None:
    y = np.geomspace(0.5, 1e4, 60)
    g, excess = bonded(y, nu)
    assert compliance_ratio(one_layer(nu, Rigid()), y) == pytest.approx(g, rel=ROUNDING)
    assert deviation(one_layer(nu, Rigid()), y[y < 300]) == pytest.approx(excess[y < 300], rel=ROUNDING * 10)


STACK_A = (Layer(Elastic(1e6, 0.3), 0.1), Layer(Elastic(1e-6, 0.5), 2.0), Layer(Elastic(1.0, 0.499), 1.0))
STACK_B = (Layer(Elastic(1e-6, -0.5), 1.0), Layer(Elastic(1e6, 0.3), 0.05), Layer(Elastic(1.0, 0.5), 3.0))
# g, then g - 1, at k = 1e-8, 1e-3, 0.3, 2, 20, 1000, from a 4 x 4 propagator (not minors) in 2500-digit arithmetic
PRECISE = [
    (
        Specimen(STACK_A, Rigid()),
        [3.2879709199624e-5, 1102.1975662368, 222260.45053045, 756.03656862369, 1.7090626647224, 1.0],
        [-0.9999671202908, 1101.1975662368, 222259.45053045, 755.03656862369, 0.70906266472242, 5.5912187473081e-83],
    ),
    (
        Specimen(STACK_A, Rigid(bonded=False)),
        [3.3341448216351e-5, 2563.2815150901, 222260.45055492, 756.03656862369, 1.7090626647224, 1.0],
        [-0.99996665855178, 2562.2815150901, 222259.45055492, 755.03656862369, 0.70906266472242, 5.5912187473081e-83],
    ),
    (
        Specimen(STACK_B, HalfSpace(Elastic(1e6, 0.3))),
        [4.4456577777593e-9, 0.00044444451974039, 0.13519787311565, 0.84073002280363, 1.0, 1.0],
        [-0.99999999555434, -0.99955555548026, -0.86480212688435, -0.15926997719637, -1.4495384718893e-15, 0.0],
    ),
]


@pytest.mark.parametrize(("specimen", "g", "excess"), PRECISE)
def test_stacks_of_extreme_contrast(specimen: Specimen, g: list[float], excess: list[float]) -> None:
    k = np.array([1e-8, 1e-3, 0.3, 2.0, 20.0, 1000.0])
    assert compliance_ratio(specimen, k) == pytest.approx(np.array(g), rel=1e-13)  # as printed
    assert deviation(specimen, k) == pytest.approx(np.array(excess), rel=1e-13, abs=0)


@pytest.mark.parametrize("base", [Rigid(), Rigid(bonded=False), HalfSpace(Elastic(3.0, 0.2))])
def test_half_space_limit_at_zero_wave_number(base: Rigid | HalfSpace) -> None:
    specimen = Specimen((Layer(Elastic(2.0, 0.5), 1.0), Layer(Elastic(70.0, 0.3), 0.1)), base)
    ratio = specimen.surface.E_star / base.material.E_star if isinstance(base, HalfSpace) else 0.0
    assert compliance_ratio(specimen, np.array([0.0]))[0] == pytest.approx(ratio, rel=ROUNDING, abs=1e-28)


layers = st.builds(
    Layer,
    st.builds(Elastic, st.floats(-4, 4).map(lambda x: 10**x), st.sampled_from([-0.5, 0.0, 0.3, 0.45, 0.499, 0.5])),
    st.floats(-1, 1).map(lambda x: 10**x),
)
bases = st.sampled_from([Rigid(), Rigid(bonded=False), HalfSpace(Elastic(1.0, 0.3)), HalfSpace(Elastic(50.0, 0.5))])


@settings(max_examples=60, deadline=None)
@given(st.lists(layers, min_size=1, max_size=5), bases, st.data())
def test_split_layer_is_the_whole_layer(stack: list[Layer], base: Rigid | HalfSpace, data: st.DataObject) -> None:
    i = data.draw(st.integers(0, len(stack) - 1))
    share = data.draw(st.floats(0.05, 0.95))
    parts = [
        Layer(stack[i].material, share * stack[i].thickness),
        Layer(stack[i].material, (1 - share) * stack[i].thickness),
    ]
    k = np.geomspace(1e-6, 1e3, 30) / stack[0].thickness
    whole = compliance_ratio(Specimen(tuple(stack), base), k)
    split = compliance_ratio(Specimen((*stack[:i], *parts, *stack[i + 1 :]), base), k)
    assert (whole > 0).all()
    assert split == pytest.approx(whole, rel=1e-13)


def test_over_many_wave_lengths_fewer_nodes_in_k_make_the_same_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stack whose top layer is a thousandth of the contact: panels of 24 nodes each took 1.5 times as many."""
    layers = [Layer(Elastic(E, 0.4), h) for E, h in ((1e6, 1e-3), (5e6, 3e-3), (2e6, 1.0))]
    spectrum = LayeredSpectrum(Specimen(tuple(layers), Rigid()))
    x = np.linspace(0.1, 1.0, 12)
    wide = spectrum.kernel(2.0)
    monkeypatch.setattr("jkrcli.methods.layered.spectrum.SPECTRUM_ORDERS", (1,))
    narrow = spectrum.kernel(2.0)
    assert wide.k.size < 0.75 * narrow.k.size
    K = narrow.square(x)
    np.testing.assert_allclose(wide.square(x), K, rtol=0, atol=1e-12 * np.abs(K).max())

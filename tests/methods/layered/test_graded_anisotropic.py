"""Transversely isotropic moduli that vary over depth: an ordinary differential equation per wave number, many thin
homogeneous layers, isotropic constants, the other methods; strain energy at every depth; cases."""

import itertools

import numpy as np
import pytest
from conftest import refused_by
from layers_of_any_kind import assert_finite_elements_agree, assert_moduli_scale_loads_and_not_depths, read_back
from scipy.integrate import solve_ivp

from jkrcli.base.errors import InputError, Refusal
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import (
    Elastic,
    Exponential,
    Graded,
    GradedTransverselyIsotropic,
    HalfSpace,
    Layer,
    Linear,
    Loading,
    Power,
    Problem,
    Rigid,
    Specimen,
    Tabulated,
    TransverselyIsotropic,
)
from jkrcli.case.models import parse_case
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.layered.spectrum import deviation, surface_series
from jkrcli.methods.protocol import method_class

ALL = GradedTransverselyIsotropic(Linear(1.0, 5.0, 1.0), Exponential(3.0, 9.0, 1.0), 0.2, 0.3, Power(0.5, 0.3, 0.7))
ONE = GradedTransverselyIsotropic(5.0, Linear(4.0, 1.3, 1.0), 0.2, 0.1, 3.0)  # conjugate roots
STEEP = GradedTransverselyIsotropic(Power(1.0, 0.1, 1.0), 1.0, 0.1, 0.05, Linear(9.0, 0.3, 1.0))  # they become real
TABLES = GradedTransverselyIsotropic(
    Tabulated((0.0, 0.3, 1.0), (1.0, 3.0, 2.0)), 3.0, 0.2, 0.3, Tabulated((0.0, 0.5, 1.0), (0.4, 0.9, 0.3))
)
PARABOLOID = Paraboloid(100.0)


def solved(specimen, radii, method=None):
    return (method or Layered())(Problem(PARABOLOID, specimen, Loading.given("radius", tuple(radii)))).series


def surface_displacement(material, k, bonded):
    """u_z at the surface under the unit pressure J_0(kr), the layer being 1 thick: the equations of elasticity for
    u_r = U J_1, u_z = W J_0, s_rz = T J_1, s_zz = N J_0, z downwards, from the base upwards."""

    def slopes(height, flat):
        E_p, E_z, G = (m if isinstance(m, float) else float(m.at(np.array(1 - height)))
                       for m in (material.E_p, material.E_z, material.G_z))  # fmt: skip
        nu, axial = material.nu_p, material.nu_zp
        across = -axial / E_z
        C = np.linalg.inv([[1 / E_p, -nu / E_p, across], [-nu / E_p, 1 / E_p, across], [across, across, 1 / E_z]])
        U, W, T, N = flat.reshape(4, 2)
        dW = (N - C[0, 2] * k * U) / C[2, 2]
        down = [T / G + k * W, dW, C[0, 0] * k**2 * U + C[0, 2] * k * dW, -k * T]
        return -np.concatenate(down)

    y = np.zeros((4, 2))
    y[2 if bonded else 0, 0] = y[3, 1] = 1
    stations = np.linspace(0, 1, 1 + max(4, int(3 * k)))
    for start, end in itertools.pairwise(stations):  # made independent again at every station
        y = solve_ivp(slopes, (start, end), y.ravel(), "DOP853", rtol=1e-11, atol=1e-14).y[:, -1].reshape(4, 2)
        y, _ = np.linalg.qr(y)
    return float(y[1] @ np.linalg.solve(y[2:], [0.0, -1.0]))


@pytest.mark.first(2)
@pytest.mark.parametrize(("material", "bonded"), [(ALL, True), (STEEP, False), (ONE, True), (TABLES, False)])
def test_the_spectrum_solves_the_equations_of_elasticity(material, bonded):
    specimen, k = Specimen((Layer(material, 1.0),), Rigid(bonded)), np.array([0.1, 1.7])
    exact = [surface_displacement(material, value, bonded) for value in k]
    found = 2 * (1 + deviation(specimen, k)) / (specimen.surface.E_star * k)
    assert found == pytest.approx(exact, rel=2e-10)  # extrapolated to 1e-10


def test_isotropic_constants_give_the_graded_isotropic_layer():
    law, nu = Power(1.0, 0.3, 0.7), 0.3
    five = GradedTransverselyIsotropic(law, law, nu, nu, law.scaled(1 / (2 * (1 + nu))))
    one, other = (
        Specimen((Layer(material, 1.0),), HalfSpace(Elastic(4.0, 0.3))) for material in (five, Graded(law, nu))
    )
    k = np.geomspace(1e-2, 30, 10)
    assert deviation(one, k) == pytest.approx(deviation(other, k), rel=1e-8, abs=1e-11)
    assert surface_series(five, 6) == pytest.approx(surface_series(other.layers[0].material, 6), rel=1e-11, abs=1e-12)


@pytest.mark.first(1)
@pytest.mark.parametrize("material", [ALL, TABLES])
def test_the_tail_is_the_spectrum_for_large_k(material):
    """What six terms leave decays like the seventh power."""
    specimen, k = Specimen((Layer(material, 1.0),), Rigid()), np.array([100.0, 200.0])
    rest = 1 + deviation(specimen, k) - np.polynomial.polynomial.polyval(1 / k, surface_series(material, 6))
    assert rest[0] / rest[1] == pytest.approx(2.0**7, rel=0.2)
    assert np.all(np.abs(rest) < 2e-5)


def test_hybrid_below_an_isotropic_layer_is_the_exact_method():
    specimen = Specimen((Layer(Elastic(2.0, 0.3), 0.5), Layer(TABLES, 1.0)), HalfSpace(Elastic(4.0, 0.3)))
    found, exact = (solved(specimen, (0.5, 1.0), method) for method in (method_class("hybrid")(), Layered()))
    for name in ("delta", "P", "S", "dS"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=1e-5)


def test_hybrid_needs_an_isotropic_contact():
    with pytest.raises(Refusal, match="isotropic material at the contact"):
        solved(Specimen((Layer(ALL, 1.0),), Rigid()), (0.5,), method_class("hybrid")())


@pytest.mark.parametrize(
    ("layers", "base"),
    [
        ((Layer(ALL, 1.0),), Rigid()),
        pytest.param((Layer(Elastic(2.0, 0.4), 0.5), Layer(ONE, 1.0)), Rigid(False), marks=pytest.mark.slow),
    ],
)
def test_fem_agrees_within_its_stated_errors(layers, base):
    assert_finite_elements_agree(Specimen(layers, base))


def test_the_moduli_scale_loads_and_not_depths():
    assert_moduli_scale_loads_and_not_depths(Specimen((Layer(ONE, 1.0),), HalfSpace(Elastic(1.0, 0.3))))


def test_stiffness_at_a_depth_is_that_of_the_homogeneous_material():
    z = np.array([0.0, 0.2, 0.9])
    C = ALL.stiffness_at(z)
    for i, (E_p, E_z, G_z) in enumerate(ALL.at(z).T.tolist()):
        assert C[:, i] == pytest.approx(TransverselyIsotropic(E_p, E_z, 0.2, 0.3, G_z).stiffness, rel=1e-14)
    assert ALL.top == TransverselyIsotropic(1.0, 3.0, 0.2, 0.3, 0.5)


def test_strain_energy_must_be_positive_between_the_ends_too():
    """E_p/E_z = sqrt(1 + 20 z)/(1 + 3.58 z): 1 at both ends, largest, 1.40, at z = 0.179 between."""
    rising, linear = Power(1.0, 1 / 20, 0.5), Linear(1.0, np.sqrt(21.0), 1.0)
    rate = np.sqrt(21.0) - 1
    depth = 1 / rate - 1 / 10
    largest = np.sqrt(1 + 20 * depth) / (1 + rate * depth)
    nu = np.sqrt(0.8 / (2 * largest))
    Layer(GradedTransverselyIsotropic(rising, linear, 0.2, nu * (1 - 1e-9), 0.4), 1.0)
    with pytest.raises(InputError, match=rf"strain energy {depth:.4g} m below the layer's top") as caught:
        Layer(GradedTransverselyIsotropic(rising, linear, 0.2, nu * (1 + 1e-9), 0.4), 1.0)
    assert f"E_p/E_z = {largest:.4g}" in str(caught.value)


def test_a_law_is_needed_and_must_reach_the_bottom():
    with pytest.raises(InputError, match="at least one of E_p, E_z and G_z"):
        GradedTransverselyIsotropic(1.0, 1.0, 0.2, 0.3, 0.4)
    with pytest.raises(InputError, match="the law of G_z ends"):
        Layer(GradedTransverselyIsotropic(1.0, 1.0, 0.2, 0.3, Linear(1.0, 2.0, 0.5)), 1.0)


FIVE = """E_p = { law = "linear", top = "1 MPa", bottom = "5 MPa" }
E_z = "3 MPa"
nu_p = 0.2
nu_zp = 0.3
G_z = { depth = [0, "3 um", "10 um"], E = ["0.5 MPa", "0.9 MPa", "1 MPa"] }
"""


def case(indenter="", layer=FIVE, rest='base = "bonded"'):
    return (
        f'[indenter]\nshape = "paraboloid"\nradius = "100 um"\n{indenter}\n[loading]\nradius = "2 um"\npoints = 3\n'
        f'[specimen]\n{rest}\n[[specimen.layers]]\nthickness = "10 um"\n{layer}'
    ).encode()


def test_a_case_with_laws_reads_back():
    material = read_back(case()).specimen.layers[0].material
    assert material.E_p == Linear(1e6, 5e6, 1e-5)
    assert (material.E_z, material.G_z.moduli) == (3e6, (5e5, 9e5, 1e6))


@pytest.mark.parametrize(
    ("parts", "place", "words"),
    [
        ({"layer": FIVE.replace('"linear"', '"linaer"')}, "specimen.layers[0].E_p", 'did you mean "linear"'),
        ({"layer": FIVE.replace('"10 um"', '"9 um"')}, "specimen.layers[0]", "the law of G_z ends"),
        ({"layer": FIVE.replace("nu_zp = 0.3", "nu_zp = 0.8")}, "specimen.layers[0]", "E_p/E_z = 1.667"),
        ({"rest": f"[specimen.half_space]\n{FIVE}"}, "specimen.half_space.E_p", "a half-space is homogeneous"),
        (
            {"indenter": f'E = "1 GPa"\nnu = 0.3\n[[indenter.layers]]\nthickness = "10 um"\n{FIVE}'},
            "indenter.layers[0].G_z",
            "a layer of the indenter is homogeneous",
        ),
    ],
)
def test_wrong_laws_in_a_case(parts, place, words):
    assert any(
        line.startswith(f"my.toml: {place}:") and words in line
        for line in refused_by(parse_case, case(**parts), "my.toml")
    )


def test_from_the_case_to_the_curve(jkr, tmp_path):
    (tmp_path / "my.toml").write_bytes(case())
    solved = jkr("run", "my.toml").ok
    assert "1 MPa in the plane, 3 MPa along z at the top, graded (E_p linear, G_z tabulated), h = 10 um" in " ".join(
        solved.out.split()
    )
    assert jkr("transform", "my.h5", "--w", "10 mJ/m^2").code == 0

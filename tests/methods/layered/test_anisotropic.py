"""Transversely isotropic layers and half-spaces: constants, element, half-space fields, layers by two methods."""

import numpy as np
import pytest
from compliance import compliance_ratio
from layers_of_any_kind import assert_finite_elements_agree, assert_moduli_scale_loads_and_not_depths
from scipy.linalg import expm

from jkrcli.base.errors import InputError
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Specimen, TransverselyIsotropic
from jkrcli.case.models import parse_case
from jkrcli.methods.layered.spectrum import LayerMedium, deviation

ISOTROPIC, AS_FIVE = Elastic(2.6, 0.3), TransverselyIsotropic(2.6, 2.6, 0.3, 0.3, 1.0)
REAL, CONJUGATE = TransverselyIsotropic(1.0, 3.0, 0.2, 0.3, 0.5), TransverselyIsotropic(5.0, 1.0, 0.2, 0.1, 3.0)
FIBRES = TransverselyIsotropic(5.0, 1.0, 0.2, 0.1, 0.3)
SHEAR_STIFF = TransverselyIsotropic(0.18251, 0.44968, 0.75576, 0.50840, 9.56748)  # D^2/A^2 = -18
MATERIALS = [AS_FIVE, REAL, CONJUGATE, FIBRES, SHEAR_STIFF]


def test_constants_of_no_material():
    with pytest.raises(InputError, match=r"^nu_zp: must lie between -0.5 and 0.5 for a positive strain energy"):
        TransverselyIsotropic(1.0, 1.0, 0.5, 0.5, 1.0)


@pytest.mark.parametrize("material", MATERIALS)
def test_the_way_through_a_layer_is_a_matrix_exponential(material):
    medium = LayerMedium.transverse(material)
    B, A = medium.generator(np.eye(5)), np.sqrt(medium.squares[0])
    m = np.array([1.0, 0.3, 0.2, -0.1, 0.05])[:, None]
    for y in (1e-6, 0.1, 0.9, 1.1, 3.0, 20.0):
        exact = expm(y * (B - A * np.eye(5))) @ m
        assert medium.through(m, np.array([y])) == pytest.approx(exact, rel=1e-10)
    still = np.array(medium.half_space)[:, None]
    assert medium.generator(still) == pytest.approx(medium.generator(still)[0] * still, rel=1e-13)


@pytest.mark.parametrize("base", [Rigid(), Rigid(False), HalfSpace(Elastic(4.0, 0.3))])
def test_isotropic_constants_give_the_isotropic_spectrum(base):
    k = np.geomspace(1e-3, 20, 20)
    for above in ((), (Layer(Elastic(1.0, 0.4), 0.5),)):
        one, other = (Specimen((*above, Layer(material, 1.0)), base) for material in (ISOTROPIC, AS_FIVE))
        assert compliance_ratio(other, k) == pytest.approx(compliance_ratio(one, k), rel=1e-11)
        assert deviation(other, k) == pytest.approx(deviation(one, k), rel=1e-9, abs=1e-13)


def test_a_layer_on_its_own_half_space_is_the_half_space():
    k = np.geomspace(1e-3, 20, 20)
    for material in MATERIALS:
        specimen = Specimen((Layer(material, 1.0),), HalfSpace(material))
        assert deviation(specimen, k) == pytest.approx(np.zeros(k.size), abs=1e-12)


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("layers", "base"),
    [
        ((Layer(REAL, 1.0),), Rigid()),
        ((Layer(CONJUGATE, 1.0),), Rigid(False)),
        ((Layer(Elastic(1.0, 0.4), 0.5), Layer(FIBRES, 1.0)), HalfSpace(REAL)),
    ],
)
def test_two_methods_agree_within_the_stated_errors(layers, base):
    assert_finite_elements_agree(Specimen(layers, base))


def test_the_moduli_scale_loads_and_not_depths():
    assert_moduli_scale_loads_and_not_depths(Specimen((Layer(FIBRES, 1.0),), HalfSpace(REAL)))


def case(keys):
    return (
        "[indenter]\nshape = 'paraboloid'\nradius = '100 um'\n[specimen]\nbase = 'bonded'\n[[specimen.layers]]\n"
        f"thickness = '10 um'\n{keys}\n[loading]\nradius = '5 um'\n"
    ).encode()


FIVE = "E_p = '5 MPa'\nE_z = '1 MPa'\nnu_p = 0.2\nnu_zp = 0.1\nG_z = '300 kPa'"


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("E_z = ", "E_zz = ", '.E_zz: unknown key, did you mean "E_z"? (allowed: E_p, E_z, nu_p, nu_zp, G_z, '),
        ("nu_p = 0.2\n", "", ".nu_p: is required"),
        ("nu_zp = 0.1", "nu_zp = 0.3", ": nu_zp: must lie between -0.2828 and 0.2828 for a positive strain energy "),
    ],
)
def test_wrong_constants_in_a_case(old, new, line):
    with pytest.raises(InputError, check=lambda error: error.lines[0].startswith(f"my.toml: specimen.layers[0]{line}")):
        parse_case(case(FIVE.replace(old, new)), "my.toml")

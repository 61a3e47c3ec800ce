"""Compliance ratio g(k) of a stack, straight from its minors."""

import numpy as np

from jkrcli import Elastic, Specimen
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import contact_modulus
from jkrcli.methods.layered.spectrum import minors_of, shear_moduli


def compliance_ratio(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """g(k) [-]: the surface compliance over that of a half-space of the top material, 1 for k h -> infinity; accurate
    relative to itself also where it is small, except that an elastic ``indenter`` adds its constant."""
    if not specimen.layers:
        return np.ones(np.shape(k))
    top = specimen.surface
    m = minors_of(specimen, np.maximum(np.ravel(k), 1e-30 / specimen.top_thickness))
    half_space = 2 * shear_moduli(specimen.layers[0])[0] / top.E_star
    g: Array = (m[2] / (half_space * m[0])).reshape(np.shape(k))
    return g if indenter is None else contact_modulus(top, indenter) * (g / top.E_star + 1 / indenter.E_star)

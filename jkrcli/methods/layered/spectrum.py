"""Surface compliance of a stack of layers in Hankel space, C(k) = 2 g(k)/(E* k), from the minors of the stack."""

from __future__ import annotations

import numpy as np

from ...bodies.materials import Elastic, Graded, TransverselyIsotropic, contact_modulus
from ...bodies.problem import Layer, Specimen
from .minors import SMALL, base, powers, rescaled, through
from .sublayers import through_graded
from .transverse import Medium

Array = np.ndarray

TINY = 1e-30  # k h that stands for 0


def deviation(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """g(k) - 1 at the wave numbers ``k`` >= 0 [1/m], shape of ``k``; small values keep their relative accuracy.

    With an elastic ``indenter`` g belongs to both bodies together, normalised by E* of both: its own half-space adds a
    constant to the compliance, so that only the factor E*/E*_top remains.
    """
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.zeros_like(k)
    top = specimen.surface
    factor = contact_modulus(top, indenter) / top.E_star
    return (factor * _deviation_of_stack(specimen, _positive(specimen, k))).reshape(k.shape)


def compliance_ratio(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """g(k), the surface compliance over that of a half-space of the top material: 1 for k h -> infinity [-].

    Relative accuracy also where g is small (rigid base, k -> 0), except that an elastic ``indenter`` adds its constant.
    """
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.ones_like(k)
    top = specimen.surface
    m = _minors(specimen, _positive(specimen, k))
    g = (m[2] / (_half_space(specimen) * m[0])).reshape(k.shape)
    if indenter is None:
        return g
    return contact_modulus(top, indenter) * (g / top.E_star + 1 / indenter.E_star)


def _positive(specimen: Specimen, k: Array) -> Array:
    """``k``, flat, with zero replaced by next to nothing: the minors over a frictionless base vanish at zero itself."""
    return np.maximum(np.ravel(k), TINY / specimen.top_thickness)


def _deviation_of_stack(specimen: Specimen, k: Array) -> Array:
    top, nu = specimen.layers[0], specimen.surface.nu
    if not isinstance(top.material, Elastic):
        return _excess(_minors(specimen, k), _half_space(specimen))
    below = _below(specimen, k)
    y = k * top.thickness
    dev = np.empty_like(k)
    small = y < SMALL
    dev[small] = _excess(through(below[:, small], y[small], nu), 1 - nu)
    dev[~small] = _far(below[:, ~small], y[~small], nu)
    return dev


def _half_space(specimen: Specimen) -> float:
    """F_zz of a half-space of the material at the surface, in units of 1/G of that: 1 - nu if isotropic."""
    return 2 * _moduli(specimen.layers[0])[0] / specimen.surface.E_star


def _excess(m: Array, half_space: float) -> Array:
    """g - 1 from the minors at the surface, by subtraction."""
    return m[2] / (half_space * m[0]) - 1


def _far(m: Array, y: Array, nu: float) -> Array:
    """g - 1 for a thick top layer: its growing part, a half-space, is taken out of exp(B y) before any subtraction."""
    b1, b2, b3, b4 = powers(m, nu)
    once = np.exp(-2 * y)
    twice = once * once

    def excess(v: Array) -> Array:
        return v[2] - (1 - nu) * v[0]

    decaying = once * (
        excess(m) + y * (excess(b1) - excess(b3) / 4) + y**2 * (excess(b2) / 2 - excess(b4) / 8) - excess(b4) / 16
    ) + twice * (excess(b4) / 32 - excess(b3) / 16)
    return decaying / ((1 - nu) * through(m, y, nu)[0])


def _minors(specimen: Specimen, k: Array) -> Array:
    """Minors (5, n) of the whole stack at its surface, up to a positive factor, in units of the modulus there."""
    return _upwards(_below(specimen, k), k, specimen.layers[0])


def _below(specimen: Specimen, k: Array) -> Array:
    """Minors of everything below the top layer, in units of the shear modulus at the bottom of that layer."""
    m, G = base(specimen.base, k.size)
    for layer in reversed(specimen.layers[1:]):
        top, bottom = _moduli(layer)
        m, G = _upwards(rescaled(m, bottom / G), k, layer), top
    return rescaled(m, _moduli(specimen.layers[0])[1] / G)


def _upwards(m: Array, k: Array, layer: Layer) -> Array:
    """From the bottom of a layer, in units of the shear modulus there, to its top, in units of that at the top."""
    match layer.material:
        case Graded() as material:
            return through_graded(m, k, material, layer.thickness)
        case TransverselyIsotropic() as material:
            return Medium.of(material).through(m, k * layer.thickness)
        case Elastic(nu=nu):
            return through(m, k * layer.thickness, nu)


def _moduli(layer: Layer) -> tuple[float, float]:
    """Shear modulus [Pa] at the top and at the bottom of a layer, across the layer if that is not isotropic."""
    match layer.material:
        case Graded() as material:
            G, ends = material.surface.G, material.at(np.array([0.0, layer.thickness]))
            return G, G * float(ends[1] / ends[0])
        case TransverselyIsotropic(G_z=G_z):
            return G_z, G_z
        case Elastic(G=G):
            return G, G

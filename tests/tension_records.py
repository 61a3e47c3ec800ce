"""Bodies with surface tension solved in another way than the program's."""

from functools import cache

import numpy as np
from compliance import compliance_ratio
from scipy.special import jv

from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Specimen


@cache
def _transforms(terms: int, most: float) -> tuple[Array, Array, Array]:
    """k, weights of a quadrature over it, and the Hankel transforms of the terms, (terms, k)."""
    edges = np.concatenate([[0.0], np.geomspace(1e-3, 1, 20), np.arange(2, most + 0.5)])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = np.diff(edges)[:, None] / 2
    k, w = np.ravel(edges[:-1, None] + half * (1 + nodes)), np.ravel(half * weights)
    orders = np.arange(terms)
    return k, w, jv(2 * orders[:, None], k) * (-1.0) ** orders[:, None]


def galerkin(specimen: Specimen, a: float, terms: int = 12, most: float = 1500.0) -> tuple[float, float, float, float]:
    """S, delta_H, P_H, S' under the paraboloid of R = 1, by Chebyshev polynomials of t/a over sqrt(a^2 - t^2), in
    Hankel space; delta_H from the state of least derivative of the energy, differences in a."""
    k, w, J = _transforms(terms, most)

    def energy(a: float) -> Array:
        kappa, g = specimen.tension_length / a, compliance_ratio(specimen, k / a)
        A = (J * (w * g / (1 + kappa * g * k))) @ J.T + 1 / (np.pi * kappa * most)
        sides = np.zeros((terms, 2))
        sides[0], sides[1, 1] = (1, a**2 / 2), a**2 / 4
        found = np.linalg.solve(np.pi / 2 * A, sides[:, 0])
        whole: Array = np.pi**2 / 2 * specimen.surface.E_star * a * (found @ sides)
        return whole

    step = 2e-3 * a
    S, Q = energy(a)
    dS, dQ = ((energy(a + step)[i] - energy(a - step)[i]) / (2 * step) for i in range(2))
    return S, dQ / dS, S * dQ / dS - Q, dS

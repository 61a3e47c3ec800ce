"""Contact with a stack of isotropic layers by means that share nothing with method layered: its compliance from the
ordinary differential equation of each wave number, the contact equation by Galerkin's method in Legendre polynomials.

With u_r = U J1(kr), u_z = W J0(kr), z downwards, the tractions sigma_rz = G k T J1, sigma_zz = G k N J0 and y = k z,

    U' = W + T,   W' = b N - c U,   T' = e U + c N,   N' = -T,
    c = nu/(1 - nu),   b = (1 - 2 nu)/(2 - 2 nu),   e = 2/(1 - nu)

(equilibrium and Hooke's law; nu = 1/2 is an ordinary value). The two fields that the base allows are carried upwards in
steps of at most one in y by the Taylor series of the equation and made orthonormal after each (Godunov 1961), in long
doubles. With phi(t) = sum c_n P_2n(t/a) the cosine transforms are a (-1)^n j_2n(ka), and the quadrature in k is one of
octaves from far below any wave number that the contact sees.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre
from scipy.special import spherical_jn

from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Elastic, HalfSpace, Specimen

# How far and how finely; halving or doubling any moves results by less than 1e-11.
JUDGE_STEP = 1.0  # largest step in y; theory: the fields grow by e on it, so that two stay apart
JUDGE_TERMS = 26  # of the Taylor series; theory: 1/26! is below the rounding of a long double
JUDGE_DEEP = 45.0  # layers thicker than this over k are half-spaces; theory: exp(-2 deep) is below rounding
JUDGE_LOWEST = 1e-13  # smallest k, over 1/a; theory: what lies below acts on S by this
JUDGE_HIGHEST = 18.0  # largest k, over 1/thickness of the top layer; theory: |g - 1| is below 1e-13 times its size
JUDGE_NODES = 16  # Gauss nodes of an octave, or of a phase of one turn; theory: exact to rounding
JUDGE_MODES = 16  # polynomials beyond those of the highest wave number that counts; choice: ten are enough


def compliance_ratio(specimen: Specimen, k: Array) -> Array:
    """g(k) [-], surface compliance of isotropic layers over that of a half-space of the top material, at ``k`` > 0
    [1/m]."""
    return compliances(specimen, k)[0] / (1 - specimen.surface.nu)


def compliances(specimen: Specimen, k: Array) -> Array:
    """Displacements zz, zr, rr (3, k) of the surface of isotropic layers under unit tractions, times G k of the top, at
    ``k`` > 0 [1/m]; 1 - nu, nu - 1/2, 1 - nu on a half-space."""
    k = np.asarray(k, dtype=np.longdouble)
    base = specimen.base
    if isinstance(base, HalfSpace):
        assert isinstance(base.material, Elastic)
        fields, G = _decaying(base.material.nu, k.size), base.material.G
    else:
        fields, G = np.zeros((4, 2, k.size), dtype=np.longdouble), 1.0
        fields[2 if base.bonded else 0, 0] = fields[3, 1] = 1.0
    for layer in reversed(specimen.layers):
        material = layer.material
        assert isinstance(material, Elastic)
        fields[2:] *= np.longdouble(G) / np.longdouble(material.G)
        G, y = material.G, k * np.longdouble(layer.thickness)
        hidden = y > JUDGE_DEEP
        fields[:, :, hidden] = _decaying(material.nu, int(hidden.sum()))
        y[hidden] = 0
        fields = _upwards(_orthonormal(fields), y, material.nu)
    U, W, T, N = fields
    both = np.stack([T[0] * W[1] - T[1] * W[0], T[0] * U[1] - T[1] * U[0], N[1] * U[0] - N[0] * U[1]])
    return np.asarray(-both / (T[0] * N[1] - T[1] * N[0]), dtype=float)


def _decaying(nu: float, size: int) -> Array:
    """The two fields (4, 2, size) of a half-space that die out downwards."""
    fields = np.array([[1, 1, -2, -2], [0, 3 - 4 * nu, 4 * nu - 2, 4 * nu - 4]], dtype=np.longdouble).T
    return np.repeat(fields[:, :, None], size, axis=2)


def _upwards(fields: Array, y: Array, nu: float) -> Array:
    """The fields (4, 2, n) the distances ``y`` further up."""
    exact_nu = np.longdouble(nu)
    c, b, e = exact_nu / (1 - exact_nu), (1 - 2 * exact_nu) / (2 - 2 * exact_nu), 2 / (1 - exact_nu)
    steps = np.ceil(y / JUDGE_STEP).astype(int)
    for i in range(int(steps.max(initial=0))):
        active = np.flatnonzero(steps > i)
        back = -y[active] / steps[active]
        term = fields[:, :, active]
        total = term.copy()
        for n in range(1, JUDGE_TERMS):
            U, W, T, N = term
            term = np.stack([W + T, b * N - c * U, e * U + c * N, -T]) * (back / n)
            total += term
        fields[:, :, active] = _orthonormal(total)
    return fields


def _orthonormal(fields: Array) -> Array:
    """Two orthonormal combinations of two fields (4, 2, n)."""
    one = fields[:, 0] / np.sqrt(np.sum(fields[:, 0] ** 2, axis=0))
    two = fields[:, 1] - np.sum(one * fields[:, 1], axis=0) * one
    return np.stack([one, two / np.sqrt(np.sum(two**2, axis=0))], axis=1)


def contact(specimen: Specimen, R: float, radii: Array, indenter: Specimen | None = None) -> Array:
    """Rows delta [m], P [N], S [N/m], S' [N/m^2] of a paraboloid of the radius ``R`` [m] on isotropic layers, at the
    contact ``radii`` [m]; ``indenter``: its own layers and core as a flat stack, where it is not rigid."""
    bodies = [specimen] if indenter is None else [specimen, indenter]
    E_star = 1 / sum(1 / body.surface.E_star for body in bodies)
    edges = _edges(min(body.top_thickness for body in bodies), radii)
    x, w = legendre.leggauss(JUDGE_NODES)
    half = np.diff(edges)[:, None] / 2
    k, weights = np.ravel(edges[:-1, None] + half * (1 + x)), np.ravel(half * w)
    weights = weights * sum(E_star / body.surface.E_star * (compliance_ratio(body, k) - 1) for body in bodies)
    return np.stack([_at(float(a), k, weights, R, E_star) for a in radii], axis=1)


def _edges(thinnest: float, radii: Array) -> Array:
    """Panels in k [1/m]: octaves, and no wider than a turn at the largest radius."""
    top, turn = JUDGE_HIGHEST / thinnest, 2 * math.pi / float(radii[-1])
    octaves = turn * 2.0 ** np.arange(math.floor(math.log2(JUDGE_LOWEST)), 1)
    if top <= turn:
        return np.concatenate([[0.0], octaves[octaves < top], [top]])
    return np.concatenate([[0.0], octaves[:-1], np.linspace(turn, top, math.ceil((top - turn) / turn) + 1)])


def _at(a: float, k: Array, weights: Array, R: float, E_star: float) -> Array:
    """delta, P, S, S' at the contact radius ``a`` from the nodes in k and g - 1 times their weights."""
    felt = np.abs(weights) > 1e-22 * np.abs(weights).max()
    k, weights = k[felt], weights[felt]
    n = np.arange(JUDGE_MODES + math.ceil(a * float(k[-1]) / 2))
    norm = np.sqrt((4 * n + 1) * a)
    waves = norm[:, None] * (-1.0) ** n[:, None] * spherical_jn(2 * n[:, None], a * k)
    matrix = np.eye(n.size) + 2 / math.pi * (waves * weights) @ waves.T
    sides = np.zeros((n.size, 2))
    sides[0] = 2 / math.pi * norm[0] * np.array([1.0, a**2 / (3 * R)])
    sides[1, 1] = 2 / math.pi * norm[1] / (4 + 1) * 2 * a**2 / (3 * R)
    one, bowl = np.linalg.solve(matrix, sides).T
    ends = norm / a @ one, norm / a @ bowl
    delta, whole, moment = ends[1] / ends[0], norm[0] * one[0], norm[0] * bowl[0]
    scale = math.pi * E_star
    return np.array([delta, scale * (delta * whole - moment), scale * whole, scale * math.pi / 2 * ends[0] ** 2])

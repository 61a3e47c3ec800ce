"""Fields in a stack of isotropic layers by brute force: a linear system of the boundary conditions for each k of Hankel
space, and a Gauss rule over k. Nothing of the package but the density of the contact pressure goes in.

In a layer, u_r = sum f J1(kr), u_z = sum g J0(kr), of modes (f, g) = (1, 1), (y, 3 - 4 nu + y) times exp(-y), y = k z
from its top, and the same with u_z reversed from its bottom; they solve Navier's equations for any nu, 1/2 included.
"""

import numpy as np
from scipy.special import j0, j1

from jkrcli.bodies.problem import HalfSpace, Problem
from jkrcli.methods.integral.density import Density
from jkrcli.methods.layered.contact import LayeredContact

Modes = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def fields(problem: Problem, a: float, delta: float, r: np.ndarray, depth: float, layer: int) -> dict[str, np.ndarray]:
    """u_r, u_z (downwards) as "r", "z" and rr, zz, rz (z upwards, tension positive) at the radii ``r`` and a ``depth``
    > 0 in the ``layer``, for the contact radius ``a`` at the displacement ``delta``."""
    k, dk = _rule(a, float(r.max()), depth)
    modes, amplitudes = _amplitudes(problem, k, depth, layer)
    f, g, zz, rz, lame = (np.einsum("kn,kn->k", mode, amplitudes) for mode in modes)
    G = problem.specimen.materials[layer].surface.G
    weights = dk * _pressure(problem, a, delta, k)
    J0, J1 = j0(np.outer(r, k)), j1(np.outer(r, k))
    by_r = np.where(r[:, None] > 0, J1 / np.maximum(np.outer(r, k), 1e-300), 0.5)
    return {
        "r": J1 @ (weights * f),
        "z": J0 @ (weights * g),
        "rr": J0 @ (weights * k * (lame + 2 * G * f)) - by_r @ (weights * k * 2 * G * f),
        "zz": J0 @ (weights * k * zz),
        "rz": -J1 @ (weights * k * rz),
    }


def surface_displacement(problem: Problem, k: np.ndarray) -> np.ndarray:
    """k u_z [1/Pa] under a unit pressure J0(kr): 2/E* of a half-space."""
    modes, amplitudes = _amplitudes(problem, k, 0.0, 0)
    return np.einsum("kn,kn->k", modes[1], amplitudes)


def _rule(a: float, reach: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights in k: all decays at least like exp(-k depth)."""
    step = 3 / (reach + a)
    edges = np.concatenate([[0.0], step * np.geomspace(1e-6, 1, 25), np.arange(2 * step, 40 / depth, step)])
    x, w = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges)[:, None] / 2
    return np.ravel((edges[:-1, None] + half) + half * x), np.ravel(half * w)


def _pressure(problem: Problem, a: float, delta: float, k: np.ndarray) -> np.ndarray:
    """Hankel transform (E*/2) int_0^a phi(t) cos(kt) dt of the pressure."""
    contact = LayeredContact(problem.indenter, problem.specimen)
    result, _ = contact.refined(np.array([a]), 1e-10)
    kernel = contact.spectrum.kernel(2 * a)
    phi = Density.of(kernel, result, float(result.delta[0]) - delta, a)
    x, w = np.polynomial.legendre.leggauss(300)
    t = a * np.sin(np.pi / 4 * (x + 1))
    return contact.E_star / 2 * np.cos(np.outer(k, t)) @ (w * np.pi / 4 * np.sqrt(a**2 - t**2) * phi(t))


def _modes(G: float, nu: float, down: np.ndarray, up: np.ndarray | None) -> Modes:
    """f, g, zz, rz and lambda div u of each mode (k, 2 or 4), stresses over k, at ``down`` below a layer's top and
    ``up`` above its bottom."""
    kappa, found = 3 - 4 * nu, []
    for y, sense in ((down, 1.0), (up, -1.0)):
        if y is None:
            continue
        e, lame = np.exp(-y), -4 * G * nu * np.exp(-y)
        found.append((e, sense * e, -2 * G * e, -2 * sense * G * e, 0 * e))
        slope = (1 - kappa - y) * e
        found.append((y * e, sense * (kappa + y) * e, lame + 2 * G * slope,
                      sense * G * ((1 - y) * e - (kappa + y) * e), lame))  # fmt: skip
    return tuple(np.stack(parts, axis=-1) for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _amplitudes(problem: Problem, k: np.ndarray, depth: float, layer: int) -> tuple[Modes, np.ndarray]:
    """Modes of the ``layer`` at the ``depth``, and their amplitudes under a unit pressure J0(kr)."""
    specimen = problem.specimen
    materials, thick = [m.surface for m in specimen.materials], [part.thickness for part in specimen.layers]
    below = isinstance(specimen.base, HalfSpace)
    size, unit, zero = 4 * len(thick) + 2 * below, materials[0].G, np.zeros_like(k)
    M, right = np.zeros((k.size, size, size)), np.zeros((k.size, size))
    right[:, 0] = -1 / unit
    scales = (1.0, 1.0, 1 / unit, 1 / unit)
    for i, material in enumerate(materials):
        own, last = slice(4 * i, 4 * i + 4), i == len(thick)
        at_top = _modes(material.G, material.nu, zero, None if last else k * thick[i])
        rows = (0, 1) if i == 0 else range(4 * i - 2, 4 * i + 2)
        for row, n in zip(rows, (2, 3) if i == 0 else range(4), strict=True):
            M[:, row, own] = (1 if i == 0 else -1) * scales[n] * at_top[n]
        if not last:
            at_bottom = _modes(material.G, material.nu, k * thick[i], zero)
            held = range(4) if i + 1 < len(materials) else (1, 0 if specimen.base.bonded else 3)
            for row, n in zip(range(4 * i + 2, 4 * i + 6), held, strict=False):
                M[:, row, own] = scales[n] * at_bottom[n]
    own, top = slice(4 * layer, 4 * layer + 4), sum(thick[:layer])
    bottom = None if layer == len(thick) else k * (top + thick[layer] - depth)
    modes = _modes(materials[layer].G, materials[layer].nu, k * (depth - top), bottom)
    return modes, np.linalg.solve(M, right[..., None])[:, own, 0]

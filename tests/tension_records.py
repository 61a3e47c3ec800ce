"""Bodies with surface tension solved in another way than the program's, and records of them: retractions from a press
under displacement control, with noise."""

from dataclasses import dataclass, replace
from functools import cache, lru_cache

import numpy as np
from compliance import compliance_ratio
from scipy.interpolate import CubicSpline
from scipy.special import jv

from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Specimen
from jkrcli.measured.curve import Curve

DEGREES = 40  # radii at which a body of records is solved


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


@dataclass(frozen=True)
class TenseBody:
    """E* = 1 at the surface, tip radius 1 and the length 2 Ups/E* ``kappa``; a layer of ``h`` and ``nu`` on a rigid
    base, or a half-space."""

    kappa: float
    h: float | None = None
    nu: float = 0.5

    @property
    def specimen(self) -> Specimen:
        own = Elastic(1 - self.nu**2, self.nu)
        whole = Specimen((), HalfSpace(own)) if self.h is None else Specimen((Layer(own, self.h),), Rigid())
        return replace(whole, surface_tension=self.kappa / 2)


@lru_cache(maxsize=64)
def _solved(body: TenseBody, largest: float) -> tuple[Array, tuple[CubicSpline, ...]]:
    """Logs of radii, and splines of the logs of S, delta_H, P_H, S' over them."""
    u = np.linspace(np.log(largest) - 5, np.log(largest), DEGREES)
    columns = np.log([galerkin(body.specimen, float(np.exp(x)), terms=16) for x in u]).T
    return u, tuple(CubicSpline(u, column) for column in columns)


def record(
    body: TenseBody, R: float, E: float, w: float, largest: float, rows: int, noise: float, zero: float, seed: int
) -> Curve:
    """A retraction from the contact radius ``largest`` (of R) to 95 % of the way to the loss of contact, under a tip of
    radius ``R`` [m] on the ``body`` in units of R and E* = ``E`` [Pa], at ``w`` [J/m^2]; ``noise`` over the range of
    the load, ``zero`` [m] of the displacement."""
    u, splines = _solved(body, largest)
    a = np.exp(np.linspace(u[0], u[-1], 4000))
    S, D, P, dS = np.exp([spline(np.log(a)) for spline in splines])
    back = np.sqrt(4 * np.pi * a * w / (E * R) / dS)
    delta, load = R * (D - back), E * R**2 * (P - S * back)
    first = int(np.argmin(delta))
    x = np.linspace(delta[-1], delta[first] + 0.05 * (delta[-1] - delta[first]), rows)
    y = np.interp(x, delta[first:], load[first:])
    scatter = noise * np.ptp(y) * np.random.default_rng(seed).standard_normal(rows)
    return Curve(f"R = {R:g} m", delta=x + zero, P=y + scatter)

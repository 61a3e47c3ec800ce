"""Intervals of fits of surface tension against the truth of made records: ``make tension-bounds SEED=7``.

Pairs of records by two tip radii, 3 um and 10 to 30 um, on half-spaces and bonded layers, by a Galerkin solution in
Hankel space that shares nothing with the fit's; lengths 2 Ups/E* of 0.03 to 3 of the large contact radius, angles at
the edge below 0.5, 1 % noise on loads, zero points unknown. How many of the 95 % intervals of E*, Ups and w hold, and
the mean square of the errors in standard errors.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from tension_records import galerkin  # type: ignore[import-not-found]

from jkrcli.base.errors import JkrError
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.surface_tension import tension_fit

from .relaxation_bounds import told

NAMES = ("E_star", "surface_tension", "w")


@dataclass(frozen=True)
class Pairs:
    """What is drawn; few lengths, radii and bodies, so that each is solved once."""

    small: float = 3e-6  # choice: [m], one tip's radius
    large: tuple[float, ...] = (1e-5, 3e-5)  # choice: [m], of the other tip
    lengths: tuple[float, ...] = (0.03, 0.3, 3.0)  # choice: 2 Ups/E* over the large tip's contact radius
    deep: float = 0.7  # choice: that over the tip's radius
    layers: tuple[tuple[float | None, float], ...] = ((None, 0.49), (1.0, 0.5), (0.5, 0.3))
    moduli: tuple[float, float] = (5e2, 2e4)  # choice: [Pa]
    angles: tuple[float, float] = (0.1, 0.5)  # choice: [rad] at the edge
    rows: tuple[int, int] = (50, 300)  # choice: of a record
    noise: float = 0.01  # choice: of the range of the load
    shown: int = 20  # choice: pairs between two reports


PAIRS = Pairs()
DEGREES = 40  # choice: radii at which a body of records is solved


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


def drawn(rng: np.random.Generator, seed: int) -> tuple[Problem, list[Any], list[float], dict[str, float]]:
    """A body whose modulus and tension are wrong, two records, their radii, and the truth."""
    R = float(rng.choice(PAIRS.large))
    layer, nu = PAIRS.layers[rng.integers(len(PAIRS.layers))]
    kappa = float(rng.choice(PAIRS.lengths)) * PAIRS.deep * R
    E = float(np.exp(rng.uniform(*np.log(PAIRS.moduli))))
    tension = kappa * E / 2
    w = tension * float(rng.uniform(*PAIRS.angles)) ** 2 / 2
    rows = int(rng.integers(*PAIRS.rows))
    curves, radii = [], [PAIRS.small, R]
    for i, tip in enumerate(radii):
        body = TenseBody(kappa / tip, None if layer is None else layer * R / tip, nu)
        zero = float(rng.uniform(-0.5, 0.5)) * tip
        curves.append(replace(record(body, tip, E, w, PAIRS.deep, rows, PAIRS.noise, zero, 2 * seed + i), name=str(i)))
    start = TenseBody(0.0, None if layer is None else layer * R, nu).specimen
    problem = Problem(Paraboloid(R), start, Loading("depth", R / 10))
    return problem, curves, radii, {"E_star": E, "surface_tension": tension, "w": w}


def main(seed: int, count: int) -> None:
    """Fit ``count`` pairs and tell how the intervals hold."""
    found = defaultdict[str, list[tuple[bool, float]]](list)
    for i in range(count):
        problem, curves, radii, truth = drawn(np.random.default_rng((seed, i)), seed + i)
        try:
            fit = tension_fit(problem, curves, radii, {})
        except JkrError as error:
            print(f"pair {i}: {error}", flush=True)
            continue
        for name in NAMES:
            item, true = fit.estimate(name), truth[name]
            if item.error is None or item.low is None or item.high is None:
                print(f"pair {i}: {name} {item.value:g}: not determined", flush=True)
                continue
            found[name].append((item.low <= true <= item.high, (item.value - true) / item.error))
            if abs(found[name][-1][1]) > 5:
                print(f"pair {i}: {name} {item.value:g} ({item.error:.2g}) of {true:g}, {truth}, {fit.warnings}")
        if (i + 1) % PAIRS.shown == 0:
            told(found)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))

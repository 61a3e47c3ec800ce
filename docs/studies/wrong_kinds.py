"""Wrong models that no test needs, beside those of the tests' generator, in the order in which they are drawn."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from force_curves import record  # type: ignore[import-not-found]
from layer_contact import BondedLayer, half_space  # type: ignore[import-not-found]
from wrong_records import (  # type: ignore[import-not-found]
    WRONG as TESTED,
)
from wrong_records import (
    Drawn,
    R,
    Wrong,
    misplaced,
    positions,
    read,
    right,
)

from jkrcli.base.numerics import Array


def nu_of_layer(at: Drawn) -> Wrong:
    h = at.radius * 0.7
    return Wrong(record(at.E, R, at.w, at.w, at.device, at.seed, BondedLayer(h, 0.3)), at.k, at.truth, h=h,
                 families=("layer or substrate",))  # fmt: skip


def tension(at: Drawn) -> Wrong:
    """First order in kappa/a, kappa a tenth of the largest radius at most."""
    kappa = at.radius * np.random.default_rng(at.seed + 1).uniform(0.02, 0.08)

    def body(a: Array, tip: float) -> tuple[Array, ...]:
        delta, P, S, dS = half_space(a, tip)
        x, log = kappa / (math.pi * np.maximum(a, 3 * kappa)), np.log(2 * np.maximum(a, 3 * kappa) / kappa) + 0.5772
        return delta * (1 + 2 * x * (log - 1)), P * (1 + 3 * x * log), S * (1 + x * (log + 1)), dS * (1 + x)

    return Wrong(
        record(at.E, R, at.w, at.w, at.device, at.seed, body), at.k, at.truth, families=("layer or substrate",)
    )


def strains(at: Drawn) -> Wrong:
    """A neo-Hookean half-space under an exact sphere that is read as one; factors of finite elements at equal depth."""
    top = np.random.default_rng(at.seed + 1).uniform(0.5, 0.8) * R
    a = np.geomspace(1e-5, 1, 6000) * top
    delta = np.append(0.0, a * np.arctanh(a / R))
    P = np.append(0.0, at.E * ((R**2 + a**2) * np.arctanh(a / R) - a * R))
    over = np.interp(np.append(0, a) / R, (0, 0.2, 0.3, 0.5, 0.7, 0.8), (0, 0.01, 0.016, 0.029, 0.047, 0.061))
    return _elastic(
        at, delta, P / (1 + over), ("layer or substrate", "shape of the tip"), louder=(top / at.radius) ** 3
    )


def _elastic(at: Drawn, delta: Array, P: Array, families: tuple[str, ...], louder: float = 1.0) -> Wrong:
    at = Drawn(at.E, 0.0, at.radius * louder ** (1 / 3), at.k, at.largest * louder, at.noise * louder, at.seed)
    way = positions(at, float(delta[-1] + P[-1] / at.k))
    loads = np.interp(way, delta + P / at.k, P, left=0.0)
    return Wrong(read(at, way, loads, loads), at.k, {"E_star": at.E}, families=families)


def stiffness(at: Drawn) -> Wrong:
    return Wrong(right(at).columns, 1.1 * at.k, at.truth, families=("device", "layer or substrate"))


def radius(at: Drawn) -> Wrong:
    return Wrong(right(at).columns, at.k, at.truth, R=1.1 * R)


def hysteresis(at: Drawn) -> Wrong:
    """Over what drives the piezo, and so over the way that is read."""

    def error(way: Array, size: float) -> Array:
        read = way
        for _ in range(30):
            read = way - size * 0.02 * 4 * read * (1 - read)
        return 0.02 * 4 * read * (1 - read)

    return misplaced(at, error)


MORE: dict[str, Callable[[Drawn], Wrong]] = {
    "surface tension": tension, "large strains": strains, "nu .3 as .5 on a layer": nu_of_layer,
    "stiffness +10 %": stiffness, "R +10 %": radius, "hysteresis": hysteresis,
}  # fmt: skip
ORDER = ("layer as half-space", "DMT", "Maugis mu 0.3", "w rising to four times", "surface tension", "relaxation",
         "large strains", "plastic", "cone", "nu .3 as .5 on a layer", "stiffness +10 %", "R +10 %", "creep",
         "hysteresis")  # fmt: skip
WRONG: dict[str, Callable[[Drawn], Wrong]] = {name: (TESTED | MORE)[name] for name in ORDER}

"""The retraction of a contact whose work of adhesion rises with the speed of its edge: w = w0 (1 + b v^n).

Gent and Schultz's law, quasi-static but for the edge. With L = delta_H - delta and G = S' L^2/(4 pi a) the edge recedes
where G > w0, at the speed v that its law gives; the device moves back evenly, so that v = -da/dz follows from positions
alone. Over the contact radius: dz/da = -1/v with z = D - y T + s (H - y V)/k, y = sqrt(q (1 + b v^n)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...base import MOST_STEPS, REMEMBERED, SETTLED, Array
from .device_path import Rest
from .family import Family


@dataclass(frozen=True)
class SlowEdgeTuning:
    """Radii at which the edge is followed."""

    first: float = 1e-12  # choice: of the radius at the turn, the first step of the edge, which begins at rest
    even: float = 0.01  # choice: of it, from where on radii are even, in a geometric sequence before; the contact that
    # is left when it is taken as lost
    radii: int = 100  # choice: of either; loads are then good to 5e-4 of the tension
    widest: float = 3.0  # choice: of logs, a step by Newton's method


TUNING = SlowEdgeTuning()


@lru_cache(maxsize=REMEMBERED)
def receding(
    family: Family, s: float, q: float, k: float, law: tuple[float, float], resting: Rest, turn: float
) -> Array:
    """Positions of the device [m], increasing, and loads [N] of the edge (2, n), for moduli times ``s``, w0 = ``q`` s
    and the ``law`` (b, n); from the end of its ``resting``, where G is w0, or from the ``turn`` [m]."""
    start = math.exp(resting.u)
    x = np.concatenate([np.geomspace(TUNING.first, TUNING.even, TUNING.radii, endpoint=False),
                        np.linspace(TUNING.even, 1 - TUNING.even, TUNING.radii)])  # fmt: skip
    D, T, H, V = family.at(np.log(start * (1 - x)))[0]
    r, steps = math.sqrt(q), np.diff(start * x, prepend=0.0)
    free, pulled = D + s * H / k, r * (T + s * V / k)
    z = np.empty(x.size)
    begin = min(resting.end, turn)
    grown = _follow(free.tolist(), pulled.tolist(), steps.tolist(), begin, law, z)
    loads = np.append(resting.at(np.array([begin]))[0], s * (H - r * grown * V))
    path: Array = np.stack([np.append(begin, z), loads])[:, ::-1]
    return path


def _follow(
    free: list[float], pulled: list[float], steps: list[float], z: float, law: tuple[float, float], out: Array
) -> Array:
    """Positions ``out`` over the nodes, and the root of w over w0 there; ``z``: where the edge begins."""
    b, n = law
    log, before, grown = 0.0, 0.0, np.empty(len(free))
    for i, (whole, shift, step) in enumerate(zip(free, pulled, steps, strict=True)):
        half = step if i == 0 else step / 2  # it begins at rest: the rule of the trapezium from the second on
        target = z - (0.0 if i == 0 else half * before)
        for _ in range(MOST_STEPS):
            power, slowness = b * math.exp(n * log), half * math.exp(-log)
            root = math.sqrt(1 + power)
            off = whole - shift * root + slowness - target
            change = off / (shift * n * power / (2 * root) + slowness)
            log += min(max(change, -TUNING.widest), TUNING.widest)
            if abs(change) < SETTLED:
                break
        before = math.exp(-log)
        grown[i] = math.sqrt(1 + b * math.exp(n * log))
        out[i] = z = whole - shift * grown[i]
    return grown


def load_at(path: Array, resting: Rest, turn: float, z: Array) -> Array:
    """Loads [N] at positions ``z`` [m]: at rest down to where the edge begins, 0 where contact is lost."""
    positions, P = path
    rising = np.append(True, np.diff(np.maximum.accumulate(positions)) > 0)
    moving = PchipInterpolator(positions[rising], P[rising])(np.clip(z, positions[0], positions[-1]))
    loads: Array = np.where(z > min(resting.end, turn), resting.at(z)[0], np.where(z < positions[0], 0.0, moving))
    return loads

"""Raw records of a paraboloid on a half-space with adhesion of finite range, by Maugis' closed form (J. Colloid
Interface Sci. 150 (1992) 243) and, before contact, attraction over a disc: both directions with their jumps, a base
line, a lever, noise. Shares no code with what reads them."""

import math
from dataclasses import dataclass

import numpy as np
from maugis import Maugis

R = 5e-6  # tip radius [m]


@dataclass(frozen=True, eq=False)
class Ranged:
    """Positions ``z`` [m] and loads ``P`` [N] of approach and retraction by a lever ``k`` [N/m], and the truth."""

    z: np.ndarray
    P: np.ndarray
    k: float
    tabor: float
    length: float
    truth: dict[str, float]


def states(E: float, w: float, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacements [m] and loads [N] from the first attraction on: without contact, then with it."""
    # A disc of tension sigma draws the surface up by 4 sigma c/(pi E*) at its rim and by 2 sigma c/E* in the middle,
    # until the gap at the rim is w/sigma; contact begins where the one in the middle is closed.
    c = np.linspace(0, 1, 4000) * 3 * math.sqrt(2 * R * w / sigma)
    before = c**2 / (2 * R) - 4 * sigma * c / (math.pi * E) - w / sigma, -math.pi * c**2 * sigma
    apart = -before[0] - 2 * sigma * c / E > 0
    end = int(np.argmin(apart)) if not apart.all() else c.size

    lam = 2 * sigma * (R / (math.pi * w * (4 * E / 3) ** 2)) ** (1 / 3)
    held = Maugis(R, E, w, lam, 1 + np.geomspace(1e5, 1e-9, 20000))
    return np.append(before[0][:end], held.delta), np.append(before[1][:end], held.P)


def drawn(seed: tuple[int, ...], tabor: float | None = None) -> Ranged:
    rng = np.random.default_rng(seed)
    tabor = 10 ** rng.uniform(-1, 2) if tabor is None else tabor
    E, radius = 10 ** rng.uniform(4, 6), R * rng.uniform(0.03, 0.12)
    w = 8 * E * radius**3 / (9 * math.pi * R**2)  # pulled off at that contact radius, if of no range
    length = (R * w**2 / E**2) ** (1 / 3) / tabor
    force, k = 1.5 * math.pi * w * R, 2 * E * radius * 10 ** rng.uniform(-1, 1)
    delta, P = states(E, w, w / length)
    position, largest = delta + P / k, force * rng.uniform(1, 8)
    end = int(np.argmax(P > largest))
    position, P = position[:end], P[:end]
    # On the way in the first state of each position, on the way out the last one.
    reach, back = np.maximum.accumulate(position), np.minimum.accumulate(position[::-1])[::-1]
    turn, rows = float(position[-1]), int(10 ** rng.uniform(2.5, 3.5))
    far = min(float(position[0]), float(back[0])) - rng.uniform(0.5, 2) * (turn - float(back.min()))
    way = np.linspace(far, turn, rows)
    into = np.searchsorted(reach, way).clip(1, end - 1)
    out = np.searchsorted(back, way, side="right").clip(1, end - 1)

    def at(i: np.ndarray) -> np.ndarray:
        share = (way - position[i - 1]) / (position[i] - position[i - 1])
        return P[i - 1] + share.clip(0, 1) * (P[i] - P[i - 1])

    loads = [np.where(way < position[0], 0.0, at(into)), np.where(way < back[0], 0.0, at(out))]
    z = np.append(way, way[::-1])
    noise = force * 10 ** rng.uniform(-3, -1.5)
    read = np.append(loads[0], loads[1][::-1]) + noise * rng.normal(size=z.size)
    read += force * rng.uniform(-2, 2) + force / (turn - far) * rng.uniform(-0.1, 0.1) * z
    return Ranged(z, read, k, tabor, length, {"E_star": E, "w": w})

"""Force curves of a paraboloid on a half-space, by the classical formulae of Johnson, Kendall and Roberts, or on a
layer, with the dirt of real records: spring, offset, tilt, drag, drift, pause, noise. Shares no code
with what reads them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from layer_contact import half_space

Body = Callable[[np.ndarray, float], tuple[np.ndarray, ...]]  # of radii and R: delta_H, P_H, S, S' for E* = 1 Pa


@dataclass(frozen=True)
class Instrument:
    """A piezo behind a spring ``k`` [N/m]: ``rows`` in each direction, from ``far`` [m] before touch to the load
    ``largest`` [N]; the rest is dirt, loads in N, ``tilt`` in N/m, ``correlation`` of neighbouring noise."""

    k: float
    rows: int
    far: float
    largest: float
    noise: float = 0.0
    offset: float = 0.0
    tilt: float = 0.0
    drag: float = 0.0
    drift: float = 0.0
    pause: int = 0
    correlation: float = 0.0


def equilibrium(
    E_star: float, R: float, w: float, k: float, largest: float, body: Body = half_space
) -> tuple[np.ndarray, ...]:
    """Device position [m], displacement [m] and load [N] over increasing contact radii, up to the load ``largest``."""
    pull = 3 * math.pi * w * R
    top = 1.2 * (3 * R * (largest + pull + math.sqrt(2 * pull * largest + pull**2)) / (4 * E_star)) ** (1 / 3)
    a = np.geomspace(1e-4 * top, top, 20000)
    delta, P, S, dS = body(a, R)
    shift = np.sqrt(4 * math.pi * w * a / (E_star * dS))
    delta, P = delta - shift, E_star * (P - S * shift)
    end = int(np.flatnonzero(P <= largest)[-1]) + 1
    return (delta + P / k)[:end], delta[:end], P[:end]


def load_at(
    z: np.ndarray, E_star: float, R: float, w: float, k: float, largest: float, approach: bool, body: Body = half_space
) -> np.ndarray:
    """Load [N] at device positions ``z``: on approach contact from z = 0 on, on retraction down to the fold."""
    position, _, P = equilibrium(E_star, R, w, k, 1.1 * largest, body)
    fold = int(np.argmin(position))
    held = np.interp(z, position[fold:], P[fold:])
    return np.where(z >= (0.0 if approach else position[fold]), held, 0.0)


def record(
    E_star: float,
    R: float,
    w_approach: float,
    w_retract: float,
    device: Instrument,
    seed: int,
    body: Body = half_space,
) -> dict[str, np.ndarray]:
    """Columns z [m], P [N], t [s] and the words of segments, of one approach and retraction; zero points as they fall:
    z = 0 is first touch, P is offset. ``z`` is the device's position, deflection not subtracted."""
    rng = np.random.default_rng(seed)
    end = equilibrium(E_star, R, w_approach, device.k, device.largest, body)[0][-1]
    way = np.linspace(-device.far, end, device.rows)
    z = np.concatenate([way, np.full(device.pause, end), way[::-1]])
    loads = [load_at(way, E_star, R, w, device.k, device.largest, approach, body)
             for w, approach in ((w_approach, True), (w_retract, False))]  # fmt: skip
    P = np.concatenate([loads[0] + device.drag, np.full(device.pause, loads[0][-1]), loads[1][::-1] - device.drag])
    noise = rng.normal(size=z.size)
    for i in range(1, z.size if device.correlation else 0):
        noise[i] = device.correlation * noise[i - 1] + math.sqrt(1 - device.correlation**2) * noise[i]
    t = np.arange(z.size) / device.rows
    P = P + device.offset + device.tilt * z + device.drift * t + device.noise * noise
    words = np.repeat(["approach", "pause", "retract"], [device.rows, device.pause, device.rows])
    return {"z": z, "P": P, "t": t, "segment": words}

"""Force curves of a paraboloid on a half-space, by the classical formulae of Johnson, Kendall and Roberts, or on a
layer, with the edge at rest after the turn, and the dirt of real records: spring, offset, tilt, drag, drift, pause,
noise. Shares no code with what reads them."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from layer_contact import half_space

Body = Callable[[np.ndarray, float], tuple[np.ndarray, ...]]  # of radii and R: delta_H, P_H, S, S' for E* = 1 Pa


@dataclass(frozen=True)
class Instrument:
    """A piezo behind a spring ``k`` [N/m]: ``rows`` in each direction, from ``far`` [m] before touch to the load
    ``largest`` [N]; the rest is dirt, loads in N, ``tilt`` in N/m."""

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


def equilibrium(
    E_star: float, R: float, w: float, k: float, largest: float, body: Body = half_space
) -> tuple[np.ndarray, ...]:
    """Device position [m], displacement [m] and load [N] over increasing contact radii, up to the load ``largest``."""
    a = _radii(E_star, R, w, largest, body)
    delta, P, S, dS = body(a, R)
    shift = np.sqrt(4 * math.pi * w * a / (E_star * dS))
    delta, P = delta - shift, E_star * (P - S * shift)
    end = int(np.flatnonzero(P <= largest)[-1]) + 1
    return (delta + P / k)[:end], delta[:end], P[:end]


def _radii(E_star: float, R: float, w: float, largest: float, body: Body) -> np.ndarray:
    """Contact radii [m] up to more than what the load ``largest`` [N] needs on a half-space; so on any layer."""
    pull = 3 * math.pi * w * R
    top = 1.3 * (3 * R * (largest + pull + math.sqrt(2 * pull * largest + pull**2)) / (4 * E_star)) ** (1 / 3)
    return np.geomspace(1e-4 * top, top, 20000)


def pulled_off(body: Body, a: float, R: float, E_star: float) -> tuple[float, float, float]:
    """The w [J/m^2] that is pulled off at the contact radius ``a`` [m] under load, the pull-off force [N] and the
    contact's stiffness [N/m]: P = P_H - S sqrt(4 pi w a/S') has its least there."""
    near = a * np.array([0.999, 1.0, 1.001])
    _, P, S, dS = body(near, R)
    tension = S * np.sqrt(4 * math.pi * near / dS)  # of w = E* = 1
    w = E_star * float((P[2] - P[0]) / (tension[2] - tension[0])) ** 2
    return w, math.sqrt(w * E_star) * float(tension[1]) - E_star * float(P[1]), E_star * float(S[1])


def load_at(
    z: np.ndarray, E_star: float, R: float, w: float, k: float, largest: float, body: Body = half_space
) -> np.ndarray:
    """Load [N] of an advancing edge at device positions ``z`` [m]: contact from z = 0 on."""
    position, _, P = equilibrium(E_star, R, w, k, 1.1 * largest, body)
    fold = int(np.argmin(position))
    return np.where(z >= 0, np.interp(z, position[fold:], P[fold:]), 0.0)


def back_at(
    z: np.ndarray, E_star: float, R: float, works: tuple[float, float], k: float, largest: float, turn: float,
    body: Body = half_space,
) -> np.ndarray:  # fmt: skip
    """Load [N] on the way back from position ``turn`` [m], advanced with the first of ``works``: the edge rests until
    the energy release rate has come to the second, then it recedes to the fold."""
    w_in, w_out = works
    largest = 1.1 * largest
    position, _, P = equilibrium(E_star, R, w_in, k, largest, body)
    a = _radii(E_star, R, w_in, largest, body)[: position.size]
    fold = int(np.argmin(position))
    a_turn = np.array([np.interp(turn, position[fold:], a[fold:])])
    delta_H, P_H, S, dS = (float(item[0]) for item in body(a_turn, R))
    release = delta_H - math.sqrt(4 * math.pi * w_out * a_turn[0] / (E_star * dS))  # where it begins to recede
    P_release = E_star * (P_H - S * (delta_H - release))
    resting = P_release + E_star * S / (1 + E_star * S / k) * (z - release - P_release / k)
    position, _, P = equilibrium(E_star, R, w_out, k, largest, body)
    fold = int(np.argmin(position))
    lost = position[fold] if a_turn[0] > _radii(E_star, R, w_out, largest, body)[fold] else release + P_release / k
    receding = np.interp(z, position[fold:], P[fold:])
    held = np.where(z > release + P_release / k, resting, receding) if w_out > w_in else receding
    return np.where(z >= lost, held, 0.0)


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
    loads = [
        load_at(way, E_star, R, w_approach, device.k, device.largest, body),
        back_at(way, E_star, R, (w_approach, w_retract), device.k, device.largest, end, body),
    ]
    P = np.concatenate([loads[0] + device.drag, np.full(device.pause, loads[0][-1]), loads[1][::-1] - device.drag])
    noise = rng.normal(size=z.size)
    t = np.arange(z.size) / device.rows
    P = P + device.offset + device.tilt * z + device.drift * t + device.noise * noise
    words = np.repeat(["approach", "pause", "retract"], [device.rows, device.pause, device.rows])
    return {"z": z, "P": P, "t": t, "segment": words}

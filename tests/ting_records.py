"""Records of a paraboloid on a body of power-law relaxation, in closed form (Ting 1966): no code of the package."""

import numpy as np
from numpy.typing import NDArray
from relaxing_rings import stepped
from scipy.special import beta, betainc, gamma

Array = NDArray[np.float64]


def ting_loads(t: Array, speed: float, turn: float, E_star: float, exponent: float, R: float) -> Array:
    """Loads [N] at times [s] since contact of a tip that goes in and, from ``turn`` [s] on, out at one ``speed`` [m/s];
    E* is that at 1 s.

    P = 2 E* sqrt(R) v^(3/2) int_0^t1 (t - s)^-al sqrt(s) ds, t1 = t, behind the turn t - 2^(1/(1 - al)) (t - tm).
    """
    t1 = np.where(t <= turn, t, t - 2 ** (1 / (1 - exponent)) * (t - turn))
    t1 = np.maximum(t1, 0.0)
    whole = beta(1.5, 1 - exponent) * np.maximum(t, 1e-300) ** (1.5 - exponent)
    share = betainc(1.5, 1 - exponent, np.clip(t1 / np.maximum(t, 1e-300), 0.0, 1.0))
    return np.where(t > 0, 2 * E_star * np.sqrt(R) * speed**1.5 * whole * share, 0.0)


def ting_record(
    rng: np.random.Generator, noise: float = 0.024, lever: float = 28.0, E_star: float = 4e3 / 3, exponent: float = 0.2,
    R: float = 5e-6, rows: int = 1200, exact: bool = False, free: float = 7.5, deepest: float = 1e-6,
    speed: float = 1e-5,
) -> tuple[Array, float]:  # fmt: skip
    """Times, positions of the device and loads (rows, 3), and the stiffness of the device [N/m]: ``lever`` times that
    of the contact at the turn; ``noise`` of the loads over their largest; in the positions it is too, but for ``exact``
    ones; ``free``: of the depth, the way before contact."""
    turn = deepest / speed
    first = -free * turn
    t = np.linspace(first, 2 * turn - first, rows)
    tip = np.where(t <= turn, speed * t, deepest - speed * (t - turn))
    P = ting_loads(t, speed, turn, E_star, exponent, R)
    ends = ting_loads(turn * np.array([1 - 1e-6, 1.0]), speed, turn, E_star, exponent, R)
    k = lever * float(np.ptp(ends)) / (deepest * 1e-6)
    read = P + noise * P.max() * rng.standard_normal(rows)
    x = tip + (P if exact else read) / k
    return np.stack([t - first, x, read], axis=1), k


def power_modes(exponent: float, shortest: float, longest: float) -> tuple[float, Array, Array]:
    """t^-al as a sum of exponentials between two times [s]: 1/Gamma(al) int exp(al u - t exp(u)) du by midpoints, what
    is slower than all as a constant."""
    step, low = 0.35, np.log(1e-7 / longest)
    u = np.arange(low + step / 2, np.log(40 / shortest), step)
    return np.exp(exponent * low) / gamma(1 + exponent), step * np.exp(exponent * u) / gamma(exponent), np.exp(u)


def ramp_record(
    rng: np.random.Generator, noise: float = 0.024, lever: float = 1.0, E_star: float = 4e3 / 3, exponent: float = 0.2,
    R: float = 5e-6, rows: int = 1200, free: float = 7.5, deepest: float = 1e-6, speed: float = 1e-5, steps: int = 1500,
) -> tuple[Array, float]:  # fmt: skip
    """The same where the device, not its tip, moves at one ``speed``, by rings stepped through time; ``deepest``: of
    the device in contact; ``lever``: about what it is to the contact where it turns."""
    k = lever * 2 * E_star * (deepest / speed) ** -exponent * np.sqrt(R * deepest)
    turn = deepest / speed
    times = np.linspace(0, 2 * turn, steps + 1)
    modes = power_modes(exponent, times[1] / 30, 2 * turn)
    _, _, P = stepped(
        lambda d: 4 / 3 * E_star * np.sqrt(R) * d**1.5, deepest, modes,
        lambda t: np.interp(t, [0, turn, 2 * turn], [0, deepest, 0]), times, k, 500,
    )  # fmt: skip
    t = np.linspace(-free * turn, (2 + free) * turn, rows)
    device = np.where(t <= turn, speed * t, deepest - speed * (t - turn))
    load = np.interp(t, times, P, 0.0, 0.0)
    read = load + noise * load.max() * rng.standard_normal(rows)
    return np.stack([t + free * turn, device, read], axis=1), k

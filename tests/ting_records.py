"""Records of a paraboloid on a body of power-law relaxation, in closed form (Ting 1966): no code of the package."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import beta, betainc

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

"""Nonadhesive contact of a paraboloid with a layer bonded to a rigid base, by a plain Nystroem solution of its integral
equation, one dense solve per radius. Shares no code with the methods that it stands against.

With p_hat(k) = E*/2 int_0^a phi(t) cos kt dt and the layer's surface compliance 2 L(kh)/(E* k), L -> 1 for k -> inf,
    phi(x) + 2/pi int_0^a K(x, t) phi(t) dt = 2/pi (delta - x^2/R),    K = int_0^inf (L(kh) - 1) cos kx cos kt dk.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline


def compliance(x: np.ndarray, nu: float) -> np.ndarray:
    """L(kh) of a layer bonded to a rigid base over ``x`` = kh."""
    kappa = 3 - 4 * nu
    decay = np.exp(-2 * x)
    above = kappa * (1 - decay**2) - 4 * x * decay
    below = kappa * (1 + decay**2) + (1 + kappa**2 + 4 * x**2) * decay
    return above / below


def contact(
    a: float, nu: float | None, nodes: int = 60, image: Callable[[np.ndarray], np.ndarray] = np.square,
    spectrum: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[float, float, float, float]:  # fmt: skip
    """(delta R, P R/E*, S/E*, S'/E*) at radius ``a``, all lengths in units of the layer's thickness, R apart; of
    another tip than the paraboloid (delta, P/E*, S/E*, S'/E*), by the Abel ``image`` of its profile; of another body by
    its ``spectrum``, k and (L - 1) dk."""
    x, weights = np.polynomial.legendre.leggauss(nodes)
    t, dt = a * (x + 1) / 2, a * weights / 2
    if spectrum is None:
        k, dk = (np.concatenate(parts) for parts in zip(*(_panel(i, 1.0) for i in range(25)), strict=True))
        spectrum = k, (compliance(k, nu) - 1) * dk
    k, lack = spectrum
    waves = np.cos(np.outer(np.append(t, a), k))
    kernel = waves * lack @ waves.T * 2 / np.pi
    matrix = np.eye(nodes) + kernel[:-1, :-1] * dt
    flat, bowl = np.linalg.solve(matrix, np.stack([np.ones(nodes), image(t)], axis=1) * 2 / np.pi).T
    edge_flat, edge_bowl = (2 / np.pi * end - (kernel[-1, :-1] * dt) @ phi
                            for end, phi in ((1.0, flat), (float(image(np.array(a))), bowl)))  # fmt: skip
    delta = edge_bowl / edge_flat
    return delta, np.pi * dt @ (delta * flat - bowl), np.pi * dt @ flat, np.pi**2 / 2 * edge_flat**2


def _panel(i: int, width: float) -> tuple[np.ndarray, np.ndarray]:
    x, weights = np.polynomial.legendre.leggauss(20)
    return width * (i + (x + 1) / 2), width * weights / 2


class BondedLayer:
    """A layer of thickness ``h`` [m] on a rigid base: (delta_H, P_H, S, S') for E* = 1 Pa over contact radii [m], of a
    paraboloid, or of a ``sphere`` of that radius [m]."""

    def __init__(self, h: float, nu: float, sphere: float | None = None) -> None:
        self.h, self.nu, self.sphere = h, nu, sphere

    @cached_property
    def table(self) -> CubicSpline:
        """Logs of the four over the half-space's own, over log(a/h)."""
        if self.sphere is None:
            radii, plain, image = np.geomspace(0.01, 6.0, 60), half_space, np.square
        else:
            R, plain = self.sphere / self.h, ball
            radii, image = np.geomspace(0.01, min(6.0, 0.8 * R), 60), lambda t: t / 2 * np.log((R + t) / (R - t))
        ours = np.array([contact(a, self.nu, image=image) for a in radii])
        return CubicSpline(np.log(radii), np.log(ours / np.stack(plain(radii, R if self.sphere else 1.0), axis=1)))

    def __call__(self, a: np.ndarray, R: float) -> tuple[np.ndarray, ...]:
        factors = np.exp(self.table(np.clip(np.log(a / self.h), *self.table.x[[0, -1]]))).T
        plain = half_space(a, R) if self.sphere is None else ball(np.minimum(a, 0.8 * R), R)
        return tuple(f * p for f, p in zip(factors, plain, strict=True))


def half_space(a: np.ndarray, R: float) -> tuple[np.ndarray, ...]:
    """(delta_H, P_H, S, S') of Hertz for E* = 1 Pa over contact radii [m]."""
    return a**2 / R, 4 * a**3 / (3 * R), 2 * a, np.full(a.size, 2.0)


def ball(a: np.ndarray, R: float) -> tuple[np.ndarray, ...]:
    """The same of Sneddon's sphere."""
    log = np.log((R + a) / (R - a))
    return a / 2 * log, ((R**2 + a**2) * log - 2 * a * R) / 2, 2 * a, np.full(a.size, 2.0)

"""Clean records of a paraboloid or a sphere on a half-space or a bonded layer, pressed to between 0 and 20 times the
pull-off force at levers of 0.03 to 30 times the contact's stiffness: the edge advances, rests at the turn and recedes.
Shares no code with what reads them."""

import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from force_curves import Body, Instrument, equilibrium, record
from layer_contact import BondedLayer, contact, half_space
from scipy.interpolate import CubicSpline

R = 5e-6  # tip radius [m]
LAYERS = [(h, nu) for h in (0.5e-6, 1.5e-6, 5e-6) for nu in (0.3, 0.45, 0.5)]  # thickness [m] and Poisson's ratio
DIRECTIONS = ("approach", "retract")


def ball(a: np.ndarray, R: float) -> tuple[np.ndarray, ...]:
    """(delta_H, P_H, S, S') of Sneddon's sphere on a half-space for E* = 1 Pa over contact radii [m]."""
    log = np.log((R + a) / (R - a))
    return a / 2 * log, ((R**2 + a**2) * log - 2 * a * R) / 2, 2 * a, np.full(a.size, 2.0)


class BallOnLayer:
    """The sphere ``R`` [m] on a layer of thickness ``h`` [m] on a rigid base, over contact radii [m], for E* = 1 Pa."""

    def __init__(self, h: float, nu: float, R: float) -> None:
        self.h, self.nu, self.R = h, nu, R

    @cached_property
    def table(self) -> CubicSpline:
        """Logs of the four over the half-space's own, over log(a/h)."""
        radius = self.R / self.h
        radii = np.geomspace(0.01, min(6.0, 0.8 * radius), 60)
        ours = np.array([contact(a, self.nu, image=lambda t: t / 2 * np.log((radius + t) / (radius - t)))
                         for a in radii])  # fmt: skip
        return CubicSpline(np.log(radii), np.log(ours / np.stack(ball(radii, radius), axis=1)))

    def __call__(self, a: np.ndarray, R: float) -> tuple[np.ndarray, ...]:
        factors = np.exp(self.table(np.clip(np.log(a / self.h), *self.table.x[[0, -1]]))).T
        return tuple(f * p for f, p in zip(factors, ball(np.minimum(a, 0.8 * R), R), strict=True))


@cache
def body_of(sphere: bool, layer: tuple[float, float] | None) -> Body:
    """The functions of a body, for E* = 1 Pa."""
    if layer is None:
        return ball if sphere else half_space
    return BallOnLayer(*layer, R) if sphere else BondedLayer(*layer)


@dataclass(frozen=True, eq=False)
class Shallow:
    """Columns of a record at a device of stiffness ``k`` [N/m], the ``truth`` of what is in it, SI, its largest load
    over the pull-off force, ``presses``, and the directions that it holds."""

    columns: dict[str, np.ndarray]
    k: float
    truth: dict[str, float]
    presses: float
    directions: tuple[str, ...]
    sphere: bool
    layer: tuple[float, float] | None
    lever: float
    noise: float


def drawn(seed: tuple[int, ...], presses: float | None = None) -> Shallow:
    """A random record; ``presses``: its largest load over the pull-off force, if that is not random too."""
    rng = np.random.default_rng(seed)
    sphere, layer = bool(rng.random() < 0.5), LAYERS[rng.integers(len(LAYERS))] if rng.random() < 0.5 else None
    body = body_of(sphere, layer)
    widest = 0.12 * R if layer is None else min(0.12 * R, 1.5 * layer[0])
    E_star, a = 10 ** rng.uniform(3, 7), widest * 10 ** rng.uniform(-1, 0) * np.array([0.999, 1.0, 1.001])

    # w that is pulled off at this contact radius under load: P = P_H - S sqrt(4 pi w a/S') has its least there
    _, P, S, dS = body(a, R)
    tension = S * np.sqrt(4 * math.pi * a / dS)
    w = E_star * ((P[2] - P[0]) / (tension[2] - tension[0])) ** 2
    force = math.sqrt(w * E_star) * tension[1] - E_star * P[1]

    lever, drawn_load = 10 ** rng.uniform(math.log10(0.03), math.log10(30)), 20 * rng.random() ** 2
    k, presses = E_star * S[1] * lever, drawn_load if presses is None else presses
    w_in = w * (1.0, 30 ** -rng.random(), 0.0)[rng.integers(3)]
    turn = float(equilibrium(E_star, R, w_in, k, presses * force, body)[0][-1])
    lost = float(equilibrium(E_star, R, w, k, presses * force, body)[0].min())
    span = turn - lost
    noise, rows = 10 ** rng.uniform(-3, -1), int(10 ** rng.uniform(math.log10(200), math.log10(5000)))
    device = Instrument(
        k, rows, far=span * rng.uniform(0.5, 3) - lost, largest=presses * force, noise=noise * force,
        offset=force * rng.uniform(-5, 5), tilt=force / span * rng.uniform(-0.2, 0.2),
    )  # fmt: skip
    columns = record(E_star, R, w_in, w, device, int(rng.integers(1 << 30)), body)
    directions = (DIRECTIONS, DIRECTIONS[:1], DIRECTIONS[1:], DIRECTIONS)[rng.integers(4)]
    keep = np.isin(columns["segment"], directions)
    truth = {"E_star": E_star, "w": w, "w_approach": w_in}
    return Shallow({name: column[keep] for name, column in columns.items()}, k, truth, presses, directions, sphere,
                   layer, lever, noise)  # fmt: skip

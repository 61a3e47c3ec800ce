"""Clean records of a paraboloid or a sphere on a half-space or a bonded layer, pressed to between 0 and 20 times the
pull-off force at levers of 0.03 to 30 times the contact's stiffness: the edge advances, rests at the turn and recedes.
Shares no code with what reads them."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from force_curves import (  # type: ignore[import-not-found]
    Body,
    Instrument,
    equilibrium,
    pulled_off,
    record,
)
from layer_contact import BondedLayer, ball, half_space  # type: ignore[import-not-found]

R = 5e-6  # tip radius [m]
LAYERS = [(h, nu) for h in (0.5e-6, 1.5e-6, 5e-6) for nu in (0.3, 0.45, 0.5)]  # thickness [m] and Poisson's ratio
DIRECTIONS = ("approach", "retract")


@cache
def body_of(sphere: bool, layer: tuple[float, float] | None) -> Body:
    """The functions of a body, for E* = 1 Pa."""
    if layer is None:
        return ball if sphere else half_space
    return BondedLayer(*layer, R if sphere else None)


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
    E_star, radius = 10 ** rng.uniform(3, 7), widest * 10 ** rng.uniform(-1, 0)
    w, force, S = pulled_off(body, radius, R, E_star)
    lever, drawn_load = 10 ** rng.uniform(math.log10(0.03), math.log10(30)), 20 * rng.random() ** 2
    k, presses = S * lever, drawn_load if presses is None else presses
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

"""Whole cycles of random bodies, devices and dirt, as ``force_curves`` makes them: w on the way out up to 30 times that
on the way in, springs of 0.03 to 100 times the contact's stiffness, white noise, and at times one kind of other noise:
1/f, a thermal peak, or the steps of a converter. Shares no code with what reads them."""

import math
from dataclasses import dataclass

import numpy as np
from force_curves import Body, Instrument, equilibrium, pulled_off, record  # type: ignore[import-not-found]
from layer_contact import half_space  # type: ignore[import-not-found]

from jkrcli.base.numerics import Array

NOISES = ("white", "pink", "peak", "steps")


@dataclass(frozen=True, eq=False)
class Cycle:
    """Columns of a record at a device of stiffness ``k`` [N/m], the ``truth`` of what is in it, SI, and its noise."""

    columns: dict[str, Array]
    k: float
    truth: dict[str, float]
    noise: str


def drawn(rng: np.random.Generator, R: float, h: float | None, body: Body = half_space, kind: str = "white") -> Cycle:
    """A random cycle of a paraboloid ``R`` [m] on a ``body``; a layer has the thickness ``h`` [m]."""
    widest = 0.3 * R if h is None else min(0.3 * R, 4 * h)
    E_star, radius = 10 ** rng.uniform(2, 7), widest * 10 ** rng.uniform(-1, 0)
    w, force, S = pulled_off(body, radius, R, E_star)
    k, largest = S * 10 ** rng.uniform(math.log10(0.03), 2), force * rng.uniform(2, 10)
    w_in = w / 30 ** rng.uniform(0, 1) if rng.random() < 0.8 else 0.0
    position = equilibrium(E_star, R, w, k, largest, body)[0]
    span = float(position[-1] - position.min())
    rows = int(10 ** rng.uniform(math.log10(200), math.log10(50000)))
    device = Instrument(
        k, rows, far=span * rng.uniform(0.5, 3) - float(position.min()), largest=largest,
        noise=force * 10 ** rng.uniform(-3, math.log10(0.03)), offset=force * rng.uniform(-5, 5),
        tilt=force / span * rng.uniform(-0.2, 0.2), drag=force * rng.uniform(0, 0.2),
        drift=force * rng.uniform(-0.1, 0.1), pause=int(rng.choice([0, rows // 10])),
    )  # fmt: skip
    columns = record(E_star, R, w_in, w, device, int(rng.integers(1 << 30)), body)
    columns["P"] = spoilt(rng, columns["P"], device.noise, kind)
    return Cycle(columns, k, {"E_star": E_star, "w": w, "w_approach": w_in}, kind)


def spoilt(rng: np.random.Generator, P: Array, noise: float, kind: str) -> Array:
    """Loads [N] with more noise of a ``kind``, as large as the white ``noise`` [N] that they have."""
    if kind == "steps":
        return np.round(P / (2 * noise)) * (2 * noise)
    n = P.size
    f = np.fft.rfftfreq(n, 1.0)
    shape = {"white": np.zeros(f.size), "pink": 1 / np.sqrt(np.maximum(f, f[1])),
             "peak": 1 / np.sqrt((1 - (f / 0.2) ** 2) ** 2 + (f / 2) ** 2 / 25)}[kind]  # fmt: skip
    more = np.fft.irfft(shape * np.fft.rfft(rng.normal(size=n)), n)
    size = float(np.std(more))
    return P + noise * more / size if size else P

"""Tables of an apparatus that presses a lens on a layer and pulls it off: contact radius, displacement and load on both
branches, from the equations of the cycle over ``layer_contact``. Shares no code with what reads them."""

import math
from dataclasses import dataclass

import numpy as np
from layer_contact import BondedLayer

from jkrcli.measured.curve import Curve

R, H, NU, E_STAR = 10e-3, 1e-3, 0.5, 2e6
LAYER = BondedLayer(H, NU)
PIXEL = 2e-6  # of the camera [m]; the scatter of a radius is as large


@dataclass(frozen=True, eq=False)
class Lens:
    """A table, the ``truth`` of what is in it, SI, and the contact radius at the turn [m]."""

    curve: Curve
    truth: dict[str, float]
    turn: float


def state(a: np.ndarray, w: float, stiffer: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """delta [m] and P [N] at contact radii ``a`` [m] of moduli ``stiffer`` times E_STAR."""
    D, P, S, dS = LAYER(a, R)
    E = stiffer * E_STAR
    shift = np.sqrt(4 * math.pi * a * w / (E * dS))
    return D - shift, E * (P - S * shift)


def stable(a_m: float, w: float) -> float:
    """The smallest contact radius [m] that a rigid device holds."""
    radii = np.linspace(1e-5, a_m, 2000)
    return max(float(radii[np.argmin(state(radii, w)[0])]), 0.05 * a_m)


def lens(
    rng: np.random.Generator, columns: str = "a,delta,P", rest: bool = True, words: tuple[str, str] | None = None,
    rows: int = 80, noise: float = 0.005, stiffer: float = 1.0,
) -> Lens:  # fmt: skip
    """A random lens of ``rows`` on each branch, with or without rows at ``rest``; ``words`` for the branches, None: the
    order of rows tells them; ``noise`` of delta and P over their range; ``stiffer``: the way back over the way in."""
    w_in = 0.03 * rng.uniform(0.2, 1.5)
    w_out, turn = w_in * 10 ** rng.uniform(0.05, 1.2), rng.uniform(0.4e-3, 1e-3)
    into = np.linspace(stable(turn, w_in), turn, rows)
    back = np.linspace(turn, stable(turn, w_out), rows)
    forth, out = state(into, w_in), state(back, w_out, stiffer)
    share = np.linspace(0, 1, rows // 4 + 2)[1:-1] if rest else np.zeros(0)
    still = [one[-1] + (two[0] - one[-1]) * share for one, two in zip(forth, out, strict=True)]
    a = np.concatenate([into, np.full(share.size, turn), back])
    delta, P = (np.concatenate(parts) for parts in zip(forth, still, out, strict=True))
    held = {
        "a": np.maximum(np.round((a + PIXEL * rng.normal(size=a.size)) / PIXEL), 1) * PIXEL,
        "delta": 3e-6 + delta + noise * np.ptp(delta) * rng.normal(size=a.size),
        "P": P + noise * np.ptp(P) * rng.normal(size=a.size),
    }
    told = None if words is None else np.repeat(words, [rows, a.size - rows])
    curve = Curve("lens", segment=told, **{name: held[name] for name in columns.split(",")})
    return Lens(curve, {"E_star": E_STAR, "w": w_out, "w_approach": w_in}, turn)

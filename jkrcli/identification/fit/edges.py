"""Parts of a measured cycle whose edge does not move: the curves that their rows lie on.

While the contact grows its edge advances with w_a, while it shrinks it recedes with w_r >= w_a. Between the two it
rests at the contact radius a_m of the turn: on (delta, P) a straight line, G between w_a and w_r,
    delta = D - v T        P = s (H - v V)        sqrt(w_a/s) <= v <= sqrt(w_r/s), all at a_m.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...base import Array
from .family import Drift, Family, JKRMember

ADVANCING, RESTING, RECEDING = range(3)  # what the edge does at a row


@dataclass(frozen=True, eq=False)
class RestingMember:
    """The readings of an edge at rest at contact radius ``turn`` [m] for moduli times ``s``, over u = v/``unit``."""

    family: Family
    s: float
    turn: float
    drift: Drift | None

    @property
    def functions(self) -> tuple[Array, Array]:
        """(D, T, H, V) at the turn, and their derivatives by its log."""
        values, rates = JKRMember(self.family, self.s, 0.0, self.drift).functions(np.log([self.turn]))[:2]
        return values[:, 0], rates[:, 0]

    @property
    def unit(self) -> float:
        """The v that shifts the contact by its own displacement."""
        D, T, _, _ = self.functions[0]
        return float(D / T)

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        return -1.0, 3.0  # several times what a stable edge holds

    def refuse_beyond(self, a: float) -> None:
        """Nothing is refused."""

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        (D, T, H, V), _ = self.functions
        zero, v = np.zeros_like(u), self.unit * u
        straight = np.stack([zero, zero - self.unit * T, zero - self.s * self.unit * V])
        return np.stack([zero + self.turn, D - v * T, self.s * (H - v * V)]), straight, np.zeros_like(straight)

    def rates(self, u: Array) -> Mapping[str, Array]:
        (_, _, H, V), (dD, dT, dH, dV) = self.functions
        zero, v = np.zeros_like(u), self.unit * u
        turn = np.stack([zero + self.turn, dD - v * dT, self.s * (dH - v * dV)])
        return {"modulus": np.stack([zero, zero, self.s * (H - v * V)]), "a_turn": turn}

    def own_rates(self, u: Array) -> Array:
        (D, T, H, V), _ = self.functions
        rD, rT, rH, rV = self.family.relative_rates(np.log([self.turn]))[..., 0].T[..., None]
        v = self.unit * u
        return np.stack([v * 0 * rD, D * rD - v * T * rT, self.s * (H * rH - v * V * rV)], axis=1)

"""Work of adhesion over the speed of the edge within marches: w(v)/w of many trials, each by a law of its own.

In a step of time the speed of a receding edge, which is at c in the end, is v = (c_0 - c)/h in the middle and, carried
on by the step before, v + (v - v_before) h/(h + h_before) in the end. There the law is sought with the state. It rises
from v = 0 with a vertical tangent: up to ``SLOWEST`` of the device's speeds log w is replaced by a straight line.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..base.numerics import Array
from .rate import RATE_LAWS, RateLaw, rate_parameters

SLOWEST = 1e-4  # choice: of the device's largest speed
FASTEST = 1e9  # choice: over the same, beyond which w grows no more
# choice: what is likely before of v0 over the device's speed and of n, logs and their half-widths: hardly anything
LIKELY = {"v0": (1.0, 5.0), "n": (-0.8, 1.0)}
PLACES = 600  # choice: of tables of log w over log v, which then err by 1e-5 of it


@dataclass(frozen=True, eq=False)
class EdgeLaws:
    """Tables of log w(v)/w0 (n, places) at even logs of v from ``first`` on, ``step`` apart; ``slow``: the speed up
    to which they are straight lines [m/s]."""

    logs: Array
    first: float
    step: float
    slow: float

    @classmethod
    def of(cls, laws: Sequence[RateLaw], works: Array, speed: float) -> EdgeLaws:
        """Those of ``laws`` with their ``works`` at rest, under a device whose largest ``speed`` is given [m/s]."""
        v = speed * np.geomspace(SLOWEST, FASTEST, PLACES)
        logs = [np.log(law.work(w, v) / w) for law, w in zip(laws, works.tolist(), strict=True)]
        return cls(np.array(logs), math.log(v[0]), math.log(v[1] / v[0]), SLOWEST * speed)

    def at(self, rows: Array, v: Array) -> tuple[Array, Array]:
        """log w(v)/w0 of the trials ``rows`` and its derivative by v at speeds ``v`` > 0 of receding edges [m/s]."""
        x = np.log(np.maximum(v, self.slow))
        y = np.clip((x - self.first) / self.step, 0, self.logs.shape[1] - 1.001)
        i = y.astype(int)
        low, high = self.logs[rows, i], self.logs[rows, i + 1]
        found, by = low + (y - i) * (high - low), (high - low) / self.step / np.maximum(v, self.slow)
        part = np.clip(v / self.slow, 0.0, 1.0)
        return part * found, np.where(v > self.slow, by, np.where(v > 0, found / self.slow, 0.0))

    def limited(self, v: Array, to: Array) -> Array:
        """The next speeds ``to`` of Newton's steps from ``v`` on: a steep tangent leads from its left to all speeds."""
        to = np.where(v <= 0, np.minimum(to, self.slow / 2), to)
        return np.where(v > self.slow, np.maximum(to, v / 10), to)


def law_over(name: str, values: Mapping[str, float], modulus: float) -> RateLaw:
    """The law called ``name`` by the ``values`` of its parameters, works over the ``modulus``."""
    ranges = rate_parameters(name)
    law: RateLaw = RATE_LAWS[name](
        **{key: values[key] / (modulus if ranges[key].dimension == "work" else 1.0) for key in ranges}
    )
    return law


def likely(name: str, speed: float) -> tuple[float, float] | None:
    """What is likely of a parameter of a law before, mean and half-width of a normal distribution of its log; None of
    others. ``speed``: of the device [m/s]."""
    if name not in LIKELY:
        return None
    mean, width = LIKELY[name]
    return mean + (math.log(speed) if name == "v0" else 0.0), width

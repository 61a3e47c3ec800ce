"""The nonadhesive contact over its depth: what the history of a contact that relaxes is made of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base import Array, PiecewiseCubic
from ..nonadhesive import Nonadhesive


@dataclass(frozen=True)
class DepthsTuning:
    """How far the contact goes on below the first row."""

    below: float = 60.0  # theory: of log depth, down to a depth of 1e-26 of that row's


TUNING = DepthsTuning()


@dataclass(frozen=True, eq=False)
class Depths:
    """P_H, S and the radius of ``body`` over delta_H, with dP_H = S d(delta_H) between the rows too; below the first
    row a power law of its slope."""

    body: Nonadhesive

    @cached_property
    def curve(self) -> PiecewiseCubic:
        """log P_H and log(a - a0) over log delta_H."""
        z = self.body.logs.columns.x
        values, slopes = (self.body.logs.columns(z, order) for order in (0, 1))
        x, by_x = values[:, 0], np.stack([slopes[:, 1], np.ones_like(z)], 1) / slopes[:, :1]
        y = np.stack([values[:, 1], z], 1)
        ends = np.array([x[0] - TUNING.below]), y[:1] - TUNING.below * by_x[:1], by_x[:1]
        return PiecewiseCubic(*(np.concatenate(pair) for pair in zip(ends, (x, y, by_x), strict=True)))

    @property
    def least(self) -> float:
        return float(np.exp(self.curve.x[0]))

    @property
    def most(self) -> float:
        """The depth [m] at the end of the series."""
        return float(np.exp(self.curve.x[-1]))

    def loads(self, depth: Array) -> Array:
        """P_H [N] at depths >= 0 [m]."""
        return np.where(depth > 0, np.exp(self.curve(self._log(depth))[..., 0]), 0.0)

    def with_slopes(self, depth: Array) -> tuple[Array, Array]:
        """P_H [N] and S [N/m] at depths > 0 [m]."""
        x = self._log(depth)
        P = np.exp(self.curve(x)[..., 0])
        return P, P / np.exp(x) * self.curve(x, 1)[..., 0]

    def radii(self, depth: Array) -> Array:
        """Contact radii [m] at depths >= 0 [m]."""
        return np.where(depth > 0, self.body.series.a0 + np.exp(self.curve(self._log(depth))[..., 1]), 0.0)

    def _log(self, depth: Array) -> Array:
        return np.log(np.maximum(depth, self.least))

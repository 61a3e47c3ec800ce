"""A paraboloid over a layer bonded to a rigid base under a constant tension on r < c, without contact: an explicit
formula. Shares no code with what it stands against.

With the layer's surface compliance 2 L(kh)/(E* k) the surface at the rim of a disc of tension sigma is drawn up by

    u(c) = (2 sigma c/E*) [2/pi + int_0^inf (L(kh) - 1) J0(kc) J1(kc)/k dk],

the separation there is the range, so that delta = c^2/(2 R) - u(c) - w/sigma, and P = -pi sigma c^2.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from layer_contact import compliance
from scipy.optimize import brentq
from scipy.special import j0, j1


@dataclass(frozen=True)
class Uncontacted:
    """The layer h = 1, E* = 1 of Poisson's ratio ``nu``; radius ``R``, tension ``stress`` up to the separation
    ``length``."""

    nu: float
    R: float
    stress: float
    length: float

    @cached_property
    def _waves(self) -> tuple[np.ndarray, np.ndarray]:
        x, weights = np.polynomial.legendre.leggauss(24)
        edges = np.linspace(0, 25.0, 251)  # L - 1 falls like exp(-2 k)
        k = edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2
        return k.ravel(), (np.diff(edges)[:, None] * weights / 2).ravel() * (compliance(k.ravel(), self.nu) - 1)

    def delta(self, c: float) -> float:
        """The displacement of the state."""
        k, layer = self._waves
        drawn = 2 * self.stress * c * (2 / math.pi + layer @ (j0(k * c) * j1(k * c) / k))
        return c**2 / (2 * self.R) - drawn - self.length

    def middle(self, c: float) -> float:
        """The gap on the axis."""
        k, layer = self._waves
        return -self.delta(c) - 2 * self.stress * c * (1 + float(layer @ (j1(k * c) / k)))

    def P(self, c: float) -> float:
        return -math.pi * self.stress * c**2

    def rate(self, c: float, stiffness: float) -> float:
        """d(delta + P/stiffness)/dc."""
        k, layer = self._waves
        drawn = 2 * self.stress * (2 / math.pi + layer @ (c * (j0(k * c) ** 2 - j1(k * c) ** 2)))
        return c / self.R - float(drawn) - 2 * math.pi * self.stress * c / stiffness

    @cached_property
    def touch(self) -> float:
        """The first c at which the surfaces touch on the axis."""
        c = np.geomspace(1e-3, 300, 400)
        first = int(np.argmax([self.middle(x) < 0 for x in c.tolist()]))
        root: float = brentq(self.middle, c[first - 1], c[first], xtol=1e-15)
        return root

    def lost(self, stiffness: float) -> tuple[float, float, float] | None:
        """c, delta and P where the surfaces let go in a jump without contact; None where they do not."""
        c = np.geomspace(1e-4, 1, 200) * self.touch
        rising = [self.rate(x, stiffness) > 0 for x in c.tolist()]
        if not rising[-1] or all(rising):
            return None
        last = int(np.flatnonzero(~np.array(rising))[-1])
        at: float = brentq(self.rate, c[last], c[last + 1], args=(stiffness,), xtol=1e-15)
        return at, self.delta(at), self.P(at)

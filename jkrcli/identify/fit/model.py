"""What an instrument reads at contact radius a, for given parameters, with every derivative in closed form.

delta_read = delta0 + delta(a) + compliance P(a)        P_read = P0 + P(a)        a_read = a
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...series import Array
from .family import Family
from .parameters import Parameter

COLUMNS = ("a", "delta", "P")


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings of one set of parameters; ``x``: the optimiser's unknowns in the order of ``parameters``.

    ``columns``: those of a, delta, P that are measured; each is divided by its scale in ``scales`` [m, m, N].
    """

    family: Family
    parameters: tuple[Parameter, ...]
    x: Array
    columns: tuple[str, ...]
    scales: Array

    def value(self, name: str) -> float:
        """The value of the parameter called ``name``, SI."""
        pairs = zip(self.parameters, self.x, strict=True)
        return next(parameter.outer(float(x)) for parameter, x in pairs if parameter.name == name)

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """Scaled readings and their first and second derivatives by u = log a, each of shape (columns, n)."""
        parts = self.family.at(u)
        s, w = self.value("modulus"), self.value("w")
        found = []
        for order, (D, T, H, V) in enumerate(parts):
            delta, P = D - np.sqrt(w / s) * T, s * H - np.sqrt(w * s) * V
            offsets = (self.value("delta0"), self.value("P0")) if order == 0 else (0.0, 0.0)
            rows = {"a": np.exp(u), "delta": offsets[0] + delta + self.value("compliance") * P, "P": offsets[1] + P}
            found.append(np.stack([rows[name] for name in self.columns]) / self.scales[:, None])
        return found[0], found[1], found[2]

    def by_parameters(self, u: Array) -> Array:
        """Derivatives of the scaled readings by the optimiser's unknowns, shape (parameters, columns, n)."""
        (D, T, H, V), _, _ = self.family.at(u)
        s, w, compliance = self.value("modulus"), self.value("w"), self.value("compliance")
        root, q = np.sqrt(s), np.sqrt(w)
        P = s * H - q * root * V
        one, zero = np.ones_like(u), np.zeros_like(u)
        half = 1 / (2 * q) if q > 0 else 0.0  # a free w stays above 0
        pairs = {  # d(delta), dP before compliance
            "modulus": (q / root * T / 2, s * H - q * root * V / 2),
            "w": (-T / root * half, -root * V * half),
            "P0": (zero, zero),
            "delta0": (zero, zero),
            "compliance": (zero, zero),
        }
        direct = {"delta0": (one, zero), "P0": (zero, one), "compliance": (P, zero)}
        of_body = iter(self.family.relative_rates(u))
        found = []
        for parameter in self.parameters:
            if parameter.of_body:
                rD, rT, rH, rV = next(of_body) if parameter.free else np.zeros((4, u.size))
                ddelta, dP = D * rD - q / root * T * rT, s * H * rH - q * root * V * rV
            else:
                ddelta, dP = pairs[parameter.name]
            more = direct.get(parameter.name, (zero, zero))
            rows = {"a": zero, "delta": ddelta + compliance * dP + more[0], "P": dP + more[1]}
            found.append(np.stack([rows[name] for name in self.columns]) / self.scales[:, None])
        return np.stack(found)


def scaled(columns: Sequence[str], values: dict[str, Array], scales: Array) -> Array:
    """Measured values in units of their scales, shape (columns, n)."""
    return np.stack([values[name] for name in columns]) / np.asarray(scales)[:, None]

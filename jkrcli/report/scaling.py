"""Units of an adhesive curve on axes, and those that make it dimensionless: Eq. 15, Eq. 19, or the user's own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..base import Array, InputError
from ..beside import Analysis
from ..bodies import Elastic, Problem, Rigid
from ..formulas.scales import scales_half_space, scales_thin_layer
from ..formulas.thin_layer import foundation_modulus


@dataclass(frozen=True)
class Scales:
    """What P [N], delta [m] and a [m] are divided by, and the labels of (delta, P, a) on axes."""

    name: str
    P: float
    delta: float
    a: float
    labels: tuple[str, str, str]

    def label(self, name: str) -> str:
        """The label of the axis of "delta", "P" or "a"."""
        return self.labels[("delta", "P", "a").index(name)]

    def columns(self, result: Analysis) -> dict[str, Array]:
        """The curve without dimensions, with Eq. 15 as units: Eq. 16."""
        columns = result.curve.columns
        return {
            "a_bar": columns["a_m"] / self.a,
            "delta_bar": columns["delta_m"] / self.delta,
            "P_bar": columns["P_N"] / self.P,
            "delta_H_bar": columns["delta_H_m"] / self.delta,
            "P_H_bar": columns["P_H_N"] / self.P,
        }


def scales_of(problem: Problem, w: float, name: str) -> Scales:
    """The scales of Eq. 15 ("half-space") or Eq. 19 ("thin-layer") for a body and ``w`` [J/m^2]."""
    R = problem.indenter.tip_radius
    if R is None or w == 0:
        raise InputError("--dimensionless: needs an indenter with a tip radius and w > 0")
    if name == "half-space":
        P, delta, a = scales_half_space(R, problem.E_star, w)
        return Scales(name, P, delta, a, (r"$\delta / \delta_0$ (Eq. 15)", r"$P / (\pi w R)$", "$a / a_0$ (Eq. 15)"))
    layers, base = problem.specimen.layers, problem.specimen.base
    material = layers[0].material if len(layers) == 1 and isinstance(base, Rigid) and base.bonded else None
    if not isinstance(material, Elastic) or material.nu >= 0.5:
        raise InputError(
            "--dimensionless thin-layer: needs one homogeneous isotropic layer with nu < 0.5, bonded to a rigid base "
            "(Eq. 22)"
        )
    K = foundation_modulus(material.E, material.nu, layers[0].thickness)
    P, delta, a = scales_thin_layer(R, K, w)
    return Scales(name, P, delta, a, (r"$\delta / \sqrt{2 w/K}$", r"$P / (2 \pi w R)$", r"$a / (8 w R^2/K)^{1/4}$"))


def own_scales(values: Mapping[str, float]) -> Scales:
    """The user's own scales: all of a, delta [m] and P [N], each > 0."""
    for key in ("a", "delta", "P"):
        if not (key in values and np.isfinite(values[key]) and values[key] > 0):
            raise InputError(f"--scale: needs a, delta and P, each > 0, got {key} = {values.get(key, 'nothing')}")
    return Scales("own", values["P"], values["delta"], values["a"], (r"$\delta / \delta_0$", "$P / P_0$", "$a / a_0$"))

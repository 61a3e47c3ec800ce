"""A method of one's own, all of it in this module: a layer as a bed of springs (Winkler) under any indenter."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jkrcli.base.units import Ranged
from jkrcli.bodies.problem import Problem
from jkrcli.formulas import foundation_modulus, thin_layer_slopes
from jkrcli.methods.protocol import Descriptor, Forecast, register
from jkrcli.series import ErrorBudget, Series, Solution


@dataclass(frozen=True)
class Winkler:
    """P = 2 pi K int_0^a (f(a) - f(r)) r dr on a bed of springs, K of Eq. 22 times ``stiffening``."""

    nodes: int = 20
    stiffening: Annotated[float, Ranged("number", above=0, most=10)] = 1.0

    def refusal(self, problem: Problem) -> str | None:
        return None if len(problem.specimen.layers) == 1 else "one layer only: use method layered"

    def forecast(self, problem: Problem) -> Forecast:
        return Forecast(1e-3, 1.0, 0.5, "a bed of springs")

    def __call__(self, problem: Problem) -> Solution:
        (layer,), f = problem.specimen.layers, problem.indenter.f
        K = self.stiffening * foundation_modulus(layer.material.E, layer.material.nu, layer.thickness)
        a = problem.loading.maximum * np.arange(1, problem.loading.points + 1) / problem.loading.points
        x, weights = np.polynomial.legendre.leggauss(self.nodes)
        r = a[:, None] * (x + 1) / 2
        P = math.pi * K * a * np.sum(weights * (f(a)[:, None] - f(r)) * r, axis=-1)
        S, dS = thin_layer_slopes(a, K)
        return Solution(problem, Series(a, f(a), P, S, dS), ErrorBudget(0.5, 0.0, 0.0), "winkler")


register(Descriptor("winkler", "A bed of springs.", Winkler, effort=15, options=Winkler, automatic=False))

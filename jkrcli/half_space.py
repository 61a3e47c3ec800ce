"""The method ``closed-form``: bodies whose solution is a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from . import closed_form
from .clock import StageClock
from .errors import Refusal
from .methods import Forecast
from .problem import Problem
from .series import ErrorBudget, Series, Solution

Array = np.ndarray


@dataclass(frozen=True)
class ClosedForm:
    """Homogeneous half-space under any indenter that has a closed form (sphere, paraboloid, power law, rounded flat).

    Exact to round-off within linear elasticity: S = 2 E* a, S' = 2 E*.
    """

    name: ClassVar[str] = "closed-form"

    def refusal(self, problem: Problem) -> str | None:
        if not problem.specimen.is_half_space:
            return "closed-form solves homogeneous half-spaces only: use method layered (or fem) for this specimen"
        if closed_form.half_space(np.array([problem.indenter.a0]), 1.0, problem.indenter) is None:
            return "no closed form for a tabulated profile: use method layered"
        return None

    def forecast(self, problem: Problem) -> Forecast:
        return Forecast(1e-3, 1.0, 1e-14, "a formula")

    def __call__(self, problem: Problem) -> Solution:
        if reason := self.refusal(problem):
            raise Refusal(reason)
        clock = StageClock()
        with clock("solve"):
            series = self._series(problem)
        budget = ErrorBudget(discretisation=1e-14, truncation=0.0, radius=0.0)
        return Solution(series, budget, self.name, facts={"solution": "closed form"}, timings=clock.seconds)

    def _series(self, problem: Problem) -> Series:
        from .radii import radii_of

        E_star, indenter = problem.E_star, problem.indenter

        def solve(a: Array) -> tuple[Array, Array]:
            pair = closed_form.half_space(a, E_star, indenter)
            assert pair is not None
            return pair

        a = radii_of(problem, solve)
        delta, P = solve(a)
        slope = np.full_like(a, 2 * E_star)
        errors = {"a": 0 * a, "delta": 1e-14 * delta, "P": 1e-14 * P, "S": 1e-14 * slope * a, "dS": 0 * a}
        return Series(a, delta, P, slope * a, slope, errors, indenter.a0, 2 * E_star * indenter.a0)

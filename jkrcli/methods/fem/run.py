"""One mesh's answer to a loading, its assessment, and the solution that is made of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.clock import StageClock
from ...base.unknown import Estimate
from ...bodies.problem import Problem
from ...series import RawSeries, Series, Solution, filter_plateaus
from .budget import Assessment, estimate, truncation_of
from .contact import Increment
from .ending import Columns
from .increments import nodal_forces, pressures, raw_series
from .level import Level
from .options import FEMOptions
from .report import facts, warnings

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Run:
    """``columns``: a, delta, P of the series on ``level``; ``increments``, ``raw`` and the number of ``dropped`` ones
    where the loading was followed in increments."""

    problem: Problem
    level: Level
    columns: Columns
    increments: tuple[Increment, ...] = ()
    raw: RawSeries | None = None
    dropped: int = 0

    @classmethod
    def of_increments(cls, problem: Problem, level: Level, increments: list[Increment]) -> Run:
        """The increments with those dropped whose radius is not their own (the paper's filter)."""
        raw = raw_series(level.model, increments)
        kept, dropped = filter_plateaus(raw)
        return cls(problem, level, (kept.a, kept.delta, kept.P), tuple(increments), raw, dropped)

    @property
    def deepest(self) -> float:
        """Depth of the last point [m]."""
        return float(self.columns[1][-1])

    def truncation(self, coarse: Level) -> Estimate:
        """Relative error of P at the deepest point from where the body is cut, on the mesh ``coarse``."""
        return truncation_of(self.level.model, coarse.model, coarse.contact, self.level.touches, self.deepest)

    def assessed(self, coarse: Level, ratio: float, truncation: Estimate) -> Assessment:
        """The errors by comparison with a level whose elements are ``ratio`` times as large."""
        return estimate(self.level, coarse, ratio, self.columns, self.raw is not None, truncation)

    def series(self, judged: Assessment) -> Series:
        """The nonadhesive series with the errors that are known; S and dS/da only where theirs are."""
        a, delta, P = self.columns
        a0, contact = self.problem.indenter.a0, self.level.contact
        flat = int(np.count_nonzero(contact.surface.radii <= a0 * (1 + 1e-9)))
        S0 = float(contact.S[flat - 1]) if a0 > 0 else 0.0
        slopes = self.level.slopes(a) if "dS" in judged.errors else None
        S, dS = (None, None) if slopes is None else slopes
        values = {"a": a, "P": P, "S": S, "dS": dS}
        errors = {name: error * values[name] for name, error in judged.errors.items()}
        return Series(a, delta, P, S, dS, errors=errors, a0=a0, S0=S0)


def finished(method: FEMOptions, run: Run, judged: Assessment, clock: StageClock) -> Solution:
    """Series, pressures, facts and warnings."""
    level, problem = run.level, run.problem
    with clock("contact"):
        if run.raw is None:
            forces = nodal_forces(level.contact, level.touches, run.columns[1])
        else:
            forces = np.array([step.p for step in run.increments])
        series = run.series(judged)
    return Solution(
        series=series,
        raw=run.raw,
        budget=judged.budget,
        method="fem",
        pressure=pressures(level.model, forces),
        facts=facts(method, problem, level.model, level.touches, run.increments, run.dropped, judged.judged_from),
        timings=clock.seconds,
        warnings=tuple(warnings(method, problem, level.touches, run.increments, run.dropped)),
    )

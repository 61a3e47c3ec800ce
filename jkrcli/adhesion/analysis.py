"""A solution and a work of adhesion to everything that is said about the adhesive curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from ..base.errors import InputError
from ..base.units import MOST
from ..base.unknown import Unknown, known
from ..bodies.problem import Problem
from ..series import ErrorBudget, Series, Solution, is_series
from .comparison import Comparison, compare_half_space
from .critical import Errors, point_error
from .curve import AdhesiveCurve, CriticalPoint, Nonadhesive
from .device import CONTROLS
from .slopes.choice import slopes, smoothed
from .slopes.result import Slopes
from .validity import Validity, check, end_of_body, judge, unresolved


@dataclass(frozen=True, eq=False)
class Analysis:
    """One adhesive curve with its critical points, error budget, validity and, where it exists, the exact solution."""

    solution: Solution
    curve: AdhesiveCurve
    budget: ErrorBudget
    modulus_factor: float = 1.0

    def __repr__(self) -> str:
        return f"<Analysis of {self.path}: w = {self.w:g} J/m^2, {len(self.curve.series)} points>"

    @property
    def path(self) -> Path:
        """The series file, as messages name it."""
        return self.solution.record.path

    @property
    def problem(self) -> Problem:
        """What was solved, with the moduli of this curve."""
        return self.solution.problem

    @property
    def dropped(self) -> int:
        """How many increments are not in the series."""
        return self.solution.increments.a.size - len(self.curve.series)

    @property
    def w(self) -> float:
        return self.curve.w

    @cached_property
    def pull_off(self) -> dict[str, CriticalPoint | Unknown]:
        """Where contact is lost under control of the load and of the displacement."""
        return {name: self.curve.pull_off(stiffness) for name, stiffness in CONTROLS.items()}

    @cached_property
    def pull_off_errors(self) -> dict[str, Errors | Unknown]:
        """90 % half-widths of delta [m] and P [N] of each pull-off point that there is, or why they are unknown."""
        return {
            name: point_error(self.curve, found, CONTROLS[name])
            for name, found in self.pull_off.items()
            if isinstance(found, CriticalPoint)
        }

    @cached_property
    def validity(self) -> Validity:
        problem, series, point = self.problem, self.curve.series, self.pull_off["load"]
        return judge(
            a=float(series.a[-1]),
            delta=float(series.delta[-1]),
            E_star=problem.E_star,
            w=self.w,
            R=problem.indenter.tip_radius,
            h=problem.specimen.top_thickness,
            L=end_of_body(problem, self.solution.facts),
            z0=self.solution.record.z0,
            a_pull_off=point.a if isinstance(point, CriticalPoint) else None,
            end_is_cut=problem.specimen.radius is None,
        )

    @cached_property
    def comparison(self) -> Comparison | None:
        """The distance to the exact solution of the same indenter; None but for a homogeneous half-space."""
        if not self.problem.specimen.is_half_space:
            return None
        return compare_half_space(self.curve, self.problem)

    @property
    def warnings(self) -> list[str]:
        """Everything that a reader of the numbers should know, each with its number."""
        outside = [f"pull-off under {name} control: {point.reason}" for name, point in self.pull_off.items()
                   if isinstance(point, Unknown) and self.w > 0]  # fmt: skip
        flags = self.curve.slopes.flags
        if self.curve.slopes.method != "exact":
            flags += unresolved(self.problem.indenter, self.curve.a)
        found = [*self.solution.warnings, *flags, *check(self.validity), *outside]
        difference = None if self.comparison is None else known(self.comparison.pull_off)
        budget = self.budget
        parts = (budget.discretisation, budget.truncation, budget.radius, budget.smoothing)
        stated = max(2 * sum(part for part in parts if not isinstance(part, Unknown)), 1e-6)
        point, half_widths = self.pull_off["load"], self.pull_off_errors.get("load")
        if isinstance(point, CriticalPoint) and half_widths is not None and not isinstance(half_widths, Unknown):
            stated = max(stated, half_widths["P"] / abs(point.P))
        if difference is not None and abs(difference) > stated:
            found.append(
                f"the pull-off force differs from the closed form by {abs(difference):.2g}, "
                f"more than the {stated:.2g} that was estimated"
            )
        return found


def analyse(
    solution: Solution, works: Sequence[float], slopes_name: str = "auto", modulus_factor: float = 1.0
) -> list[Analysis]:
    """The adhesive curves of a solution for each work of adhesion [J/m^2]; the slopes are found once.

    ``modulus_factor``: of bodies whose moduli are all that many times those of the solution; nothing is solved anew.
    """
    body = nonadhesive(solution, slopes_name)
    return [adhesive(solution, body, w, modulus_factor) for w in works]


def adhesive(solution: Solution, body: Nonadhesive, w: float, modulus_factor: float = 1.0) -> Analysis:
    """The adhesive curve for the work of adhesion ``w`` [J/m^2] on bodies ``modulus_factor`` times as stiff."""
    if not 0 <= w <= MOST:
        raise InputError(f"w: must lie within 0 and {MOST:g} J/m^2, got {w:g}")
    curve = body.scaled(modulus_factor).adhesive(w)
    return Analysis(solution.scaled(modulus_factor), curve, _budget(solution.budget, curve), modulus_factor)


def nonadhesive(solution: Solution, slopes_name: str = "auto") -> Nonadhesive:
    """The w-free functions of a solution by the slopes called ``slopes_name``; InputError names the file.

    The integral fit takes increments as they are, plateaus and noise included; all else takes the paper's filter first.
    """
    try:
        pair = _series_and_slopes(solution, slopes_name)
    except InputError as error:
        path = str(solution.record.path)
        raise InputError([line if line.startswith(path) else f"{path}: {line}" for line in error.lines]) from None
    return Nonadhesive(*pair)


def _series_and_slopes(solution: Solution, name: str) -> tuple[Series, Slopes]:
    if solution.raw is not None and name in ("auto", "integral") and not is_series(solution.raw):
        return smoothed(solution.raw, solution.series.a0, solution.series.S0)
    series = solution.filtered
    if name not in ("auto", "exact"):
        series = replace(series, S=None, dS=None)
    return series, slopes(series, name)


def _budget(budget: ErrorBudget, curve: AdhesiveCurve) -> ErrorBudget:
    """The series' budget with that of the slopes; where the series carries these, the interpolation's between the
    points added."""
    error = curve.slopes.error
    if curve.slopes.method != "exact":
        return replace(budget, smoothing=error)
    between = curve.interpolation_error
    both = between + error if isinstance(between, float) and isinstance(error, float) else between
    return replace(budget, smoothing=both)

"""A series file and a work of adhesion to everything that is said about the adhesive curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..base.errors import InputError
from ..base.unknown import Unknown, known
from ..bodies.problem import Problem
from ..case import parse_case
from ..case.store import Stored
from ..series import ErrorBudget, Series, first_of_plateaus
from .comparison import Comparison, compare_half_space
from .critical import Errors, point_error
from .curve import AdhesiveCurve, CriticalPoint, transform
from .device import CONTROLS
from .slopes.choice import slopes, smoothed
from .slopes.result import Slopes
from .validity import Validity, check, end_of_body, judge, unresolved


@dataclass(frozen=True, eq=False)
class Specification:
    """What a stored file says about its case: the problem, the works of adhesion and z0 [m]."""

    problem: Problem
    w: tuple[float, ...]
    z0: float
    title: str


@dataclass(frozen=True, eq=False)
class Analysis:
    """One adhesive curve with its critical points, error budget, validity and, where it exists, the exact solution."""

    stored: Stored
    case: Specification
    curve: AdhesiveCurve
    dropped: int
    budget: ErrorBudget
    modulus_factor: float = 1.0

    def __repr__(self) -> str:
        return f"<Analysis of {self.stored.path}: w = {self.w:g} J/m^2, {len(self.curve.series)} points>"

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
        problem, series, point = self.case.problem, self.curve.series, self.pull_off["load"]
        return judge(
            a=float(series.a[-1]),
            delta=float(series.delta[-1]),
            E_star=problem.E_star,
            w=self.w,
            R=problem.indenter.tip_radius,
            h=problem.specimen.top_thickness,
            L=end_of_body(problem, self.stored.facts),
            z0=self.case.z0,
            a_pull_off=point.a if isinstance(point, CriticalPoint) else None,
            end_is_cut=problem.specimen.radius is None,
        )

    @cached_property
    def comparison(self) -> Comparison | None:
        """The distance to the exact solution of the same indenter; None but for a homogeneous half-space."""
        if not self.case.problem.specimen.is_half_space:
            return None
        return compare_half_space(self.curve, self.case.problem)

    @property
    def warnings(self) -> list[str]:
        """Everything that a reader of the numbers should know, each with its number."""
        outside = [f"pull-off under {name} control: {point.reason}" for name, point in self.pull_off.items()
                   if isinstance(point, Unknown) and self.w > 0]  # fmt: skip
        flags = self.curve.slopes.flags
        if self.curve.slopes.method != "exact":
            flags += unresolved(self.case.problem.indenter, self.curve.a)
        found = [*self.stored.warnings, *flags, *check(self.validity), *outside]
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


def specification(stored: Stored) -> Specification:
    """The case that a series file carries."""
    model = parse_case(stored.case.encode(), f"{stored.path}: case").model
    return Specification(model.problem(), model.adhesion.w, model.adhesion.z0, model.title)


@dataclass(frozen=True, eq=False)
class Fitted:
    """One nonadhesive series of a ``case`` with its slopes: what every adhesive curve of it starts from."""

    stored: Stored
    case: Specification
    series: Series
    slopes: Slopes
    dropped: int

    @classmethod
    def of(cls, stored: Stored, case: Specification, slopes_name: str = "auto") -> Fitted:
        """Slopes of the stored series by ``slopes_name``; InputError names the file."""
        try:
            series, dropped, found = _fitted(stored, slopes_name)
        except InputError as error:
            known = str(stored.path)
            lines = [line if line.startswith(known) else f"{known}: {line}" for line in error.lines]
            raise InputError(lines) from None
        return cls(stored, case, series, found, dropped)

    def scaled(self, factor: float) -> Fitted:
        """The same for bodies whose moduli are all ``factor`` times as large; nothing is solved anew."""
        if factor == 1:
            return self
        case = replace(self.case, problem=self.case.problem.scaled(factor))
        return replace(self, case=case, series=self.series.scaled(factor), slopes=self.slopes.scaled(factor))


def analyse(
    stored: Stored, works: Sequence[float], slopes_name: str = "auto", modulus_factor: float = 1.0
) -> list[Analysis]:
    """The adhesive curves of one series file for each work of adhesion [J/m^2]; the slopes are found once.

    ``modulus_factor``: of bodies whose moduli are all that many times those of the file's case; nothing is solved anew.
    """
    fitted = Fitted.of(stored, specification(stored), slopes_name).scaled(modulus_factor)
    return [adhesive(fitted, w, modulus_factor) for w in works]


def adhesive(fitted: Fitted, w: float, modulus_factor: float = 1.0) -> Analysis:
    """The adhesive curve of a series for the work of adhesion ``w`` [J/m^2]; ``modulus_factor``: as said in results."""
    curve = transform(fitted.series, fitted.slopes, w)
    budget = _budget(fitted.stored, curve)
    return Analysis(fitted.stored, fitted.case, curve, fitted.dropped, budget, modulus_factor)


def _budget(stored: Stored, curve: AdhesiveCurve) -> ErrorBudget:
    """The series' budget with that of the slopes; where the series carries these, the interpolation's between the
    points added."""
    error = curve.slopes.error
    if curve.slopes.method != "exact":
        return replace(stored.budget, smoothing=error)
    between = curve.interpolation_error
    both = between + error if isinstance(between, float) and isinstance(error, float) else between
    return replace(stored.budget, smoothing=both)


def _fitted(stored: Stored, name: str) -> tuple[Series, int, Slopes]:
    """Series, dropped increments and slopes.

    The integral fit takes increments as they are, plateaus and noise included; all else takes the paper's filter first.
    """
    if name in ("auto", "integral") and "dS" not in stored.columns and not _is_series(stored):
        series, found = smoothed(stored.raw, stored.a0, stored.S0)
        return series, int(stored.raw.a.size - len(series)), found
    series, dropped = stored.series(name in ("auto", "exact"))
    return series, dropped, slopes(series, name)


def _is_series(stored: Stored) -> bool:
    """Whether the increments are a series as they stand: radii, displacements and loads all increase."""
    raw = stored.raw
    return bool(first_of_plateaus(raw.a).all() and all((np.diff(column) > 0).all() for column in (raw.delta, raw.P)))

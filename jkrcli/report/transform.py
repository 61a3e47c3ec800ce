"""Adhesive curves in words: pull-off with its error, validity, comparison with a closed form, error budget."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..adhesion import CriticalPoint
from ..base import Array, Estimate, Unknown, accuracy, show
from ..beside import Analysis, StickingEffect, effect_as_json, effect_on, is_solved
from . import tables
from .result import Figure, Result
from .scaling import Scales


@dataclass(frozen=True, eq=False, repr=False)
class Transformed(Analysis, Result):
    """An adhesive curve as a result; ``scales``: units of more columns and of the picture; ``effect``:
    what it matters whether the surfaces stick, where that is known for several curves of one body at once."""

    scales: Scales | None = None
    effect: StickingEffect | Unknown | None = None

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return tables.curve_columns(self.curve) | ({} if self.scales is None else self.scales.columns(self))

    @cached_property
    def sticking(self) -> StickingEffect | Unknown:
        """What it matters whether the surfaces stick."""
        return effect_on(self.solution, [self.w]) if self.effect is None else self.effect

    def summary(self) -> dict[str, Any]:
        summary, scales = tables.summary(self) | {"sticking": effect_as_json(self.sticking)}, self.scales
        if scales is not None:
            summary["scales"] = {"name": scales.name} | tables.quantities(scales, "P delta a")
        return summary

    def words(self) -> list[str]:
        """Where contact is lost, what the numbers are worth, what an exact solution says."""
        errors = self.pull_off_errors
        points = {f"{name} control": (point, errors.get(name)) for name, point in self.pull_off.items()}
        return [*tables.lost_words(self, points), *(f"  {line}" for line in _of_curve(self))]

    @property
    def units(self) -> Scales:
        """Of the axes."""
        from .plots.curve import physical_units

        return self.scales or physical_units(self.curve)

    def figure(self) -> Figure:
        from .plots.curve import curve_figure

        return curve_figure(self, self.units)


def figure_of(results: Sequence[Transformed]) -> Figure:
    """One picture of the curves of one body for several works of adhesion."""
    from .plots.curve import curves_figure

    return curves_figure(results, results[-1].units)


def _of_curve(result: Analysis) -> Iterator[str]:
    for name, point in result.pull_off.items():
        if isinstance(point, CriticalPoint):
            between = "" if is_solved(result.curve, point) else "; interpolated"
            P = show(point.P, "load", tables.digits(point.P, result.large_strains(point)))
            yield (
                f"{name + ' control':<21} P = {P:<11} delta = {show(point.delta, 'length'):<12} "
                f"a = {show(point.a, 'length')}{between}"
            )
        elif result.w > 0:
            yield f"{name + ' control':<21} not in the series (see the warning)"
    tabor = result.validity.tabor
    if not isinstance(tabor, Unknown):
        yield f"Tabor number {tabor:.3g}: {result.validity.regime}"
    yield from _comparison(result)
    budget, slopes = result.budget, result.curve.slopes
    yield (
        f"curve: {accuracy(budget.total)} (series {_estimate(budget.series)}, slopes {_estimate(budget.smoothing)}); "
        f"between the rows up to {_estimate(result.curve.interpolation_error)} more"
    )
    below = result.solution.facts.get("rows_below", 0)
    more = f", {below} of them solved below its own for pull-off" if below else ""
    yield (
        f"series: {len(result.curve.series)} points kept{more}, {result.dropped} dropped; "
        f"slopes {slopes.method} ({slopes.reason})"
    )


def _comparison(result: Analysis) -> Iterator[str]:
    """The closed form of the same indenter on a half-space beside the curve, where there is one."""
    comparison = result.comparison
    if comparison is None:
        return
    parts = [f"P_H(delta) within {comparison.load:.2e}"]
    if not isinstance(comparison.pull_off, Unknown):
        parts.append(f"pull-off force {comparison.pull_off:+.2e}")
    if not isinstance(comparison.curve, Unknown):
        parts.append(f"adhesive curve within {comparison.curve:.2e}")
    yield f"against the closed form of the same indenter: {', '.join(parts)}"
    if comparison.parabola is not None:
        yield (
            f"the sphere's own pull-off is {comparison.parabola:.2%} smaller than the paraboloid's -1.5 pi w R of "
            "Eq. 18 (physics, not error)"
        )


def _estimate(value: Estimate) -> str:
    return str(value) if isinstance(value, Unknown) else f"{value:.1e}"

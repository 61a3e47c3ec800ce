"""Adhesive curves in words: pull-off with its error, validity, comparison with a closed form, error budget."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from ..adhesion.curve import CriticalPoint
from ..base.arrays import Array
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..beside.analysis import Analysis
from ..beside.solved import is_solved
from ..beside.sticking import StickingEffect, as_told, effect_on
from . import tables
from .result import Result

if TYPE_CHECKING:
    from .plots import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Transformed(Analysis, Result):
    """An adhesive curve with what is said of it."""

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return tables.curve_columns(self.curve)

    @cached_property
    def sticking(self) -> StickingEffect | Unknown:
        """What it matters whether the surfaces stick."""
        return effect_on(self.solution, [self.w])

    def summary(self) -> dict[str, Any]:
        return tables.summary(self) | {"sticking": as_told(self.sticking)}

    def words(self) -> list[str]:
        return words([self], [])

    def figure(self) -> Figure:
        from .plots.curve import curve_figure, physical_units

        return curve_figure(self, physical_units(self.curve))


def words(results: Sequence[Analysis], written: Sequence[str]) -> list[str]:
    """The curves of one series for several works of adhesion as lines of text; ``written``: the files of each."""
    first = results[0]
    kept, slopes = len(first.curve.series), first.curve.slopes
    lines = [f"{first.path}: {kept} points kept, {first.dropped} dropped; slopes {slopes.method} ({slopes.reason})"]
    for result, files in zip_longest(results, written):
        lines.append(f"  w = {show(result.w, 'work')}{tables.law_words(result)}")
        lines += [f"    {line}" for line in _of_curve(result)]
        lines += [f"    written {files}"] if files else []
    return lines


def _of_curve(result: Analysis) -> Iterator[str]:
    """Where contact is lost, what the numbers are worth, and what an exact solution says."""
    for name, point in result.pull_off.items():
        if isinstance(point, CriticalPoint):
            between = "" if is_solved(result.curve, point) else " (interpolated)"
            load = f"{show(point.P, 'load')} {_half_width(result, name)}{between}"
            yield (
                f"pull-off, {name + ' control:':<22} P = {load:<22} delta = {show(point.delta, 'length'):<12} "
                f"a = {show(point.a, 'length')}"
            )
        elif result.w > 0:
            yield f"pull-off, {name + ' control:':<22} not in the series (see the warning)"
    tabor = result.validity.tabor
    if not isinstance(tabor, Unknown):
        yield f"Tabor number {tabor:.3g}: {result.validity.regime}"
    yield from _comparison(result)
    budget = result.budget
    yield (
        f"estimated error: {_estimate(budget.total)} "
        f"(series {_estimate(budget.series)}, slopes {_estimate(budget.smoothing)}); "
        f"between the rows up to {_estimate(result.curve.interpolation_error)} more"
    )


def _half_width(result: Analysis, control: str) -> str:
    """The 90 % half-width of the pull-off force, relative to it; the JSON file says why there is none."""
    found, point = result.pull_off_errors[control], result.pull_off[control]
    if isinstance(found, Unknown) or not isinstance(point, CriticalPoint) or point.P == 0:
        return "± ?"
    percent = 100 * found["P"] / abs(point.P)
    return f"± {float(f'{percent:.2g}'):g} %"


def _comparison(result: Analysis) -> Iterator[str]:
    """The closed form of the same indenter on a half-space beside the curve, where there is one."""
    found = result.comparison
    if found is None:
        return
    parts = [f"P_H(delta) within {found.load:.2e}"]
    if not isinstance(found.pull_off, Unknown):
        parts.append(f"pull-off force {found.pull_off:+.2e}")
    if not isinstance(found.curve, Unknown):
        parts.append(f"curve within {found.curve:.2e} pull-off units")
    yield f"against the closed form of the same indenter: {', '.join(parts)}"
    if found.parabola is not None:
        yield (
            f"the sphere's own pull-off is {found.parabola:.2%} smaller than the paraboloid's -1.5 pi w R of Eq. 18"
            " (physics, not error)"
        )


def _estimate(value: Estimate) -> str:
    return str(value) if isinstance(value, Unknown) else f"{value:.1e}"

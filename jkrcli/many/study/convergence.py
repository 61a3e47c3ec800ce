"""A convergence study as table, summary, words and figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...base import Unknown, show
from ...report import Figure, Result, tables
from .meshes import QUANTITIES, Meshes

DIMENSIONS = {"a": "length", "P": "load", "pull_off": "load"}
WORDS = {"a": "contact radius", "P": "load", "pull_off": "pull-off force"}


@dataclass(frozen=True, eq=False)
class Convergence(Meshes, Result):
    """A study of meshes as a result."""

    @property
    def columns(self) -> dict[str, Sequence[Any]]:  # type: ignore[override]
        """A row per mesh; the pull-off cell is empty where it lies outside the series."""
        levels = self.levels
        return {
            "size_m": [level.size for level in levels],
            "elements": [level.elements for level in levels],
            "unknowns": [level.unknowns for level in levels],
            "a_m": self.values("a"),
            "P_N": self.values("P"),
            "pull_off_P_N": self.values("pull_off"),
            "points_kept": [level.kept for level in levels],
            "points_dropped": [level.dropped for level in levels],
            "cpu_s": [level.seconds for level in levels],
        }

    def summary(self) -> dict[str, Any]:
        """The meshes from coarse to fine, the exact values where there are some, the limits."""
        return {
            "format": "jkr-convergence",
            "version": 1,
            "problem": self.problem.words,
            "w_J_per_m2": self.w,
            "depth_m": self.depth,
            "levels": [
                {
                    "size_m": level.size,
                    "elements": level.elements,
                    "unknowns": level.unknowns,
                    "a_m": level.state.a,
                    "P_N": level.state.P,
                    "pull_off": tables.point(level.state.point),
                    "points": {"kept": level.kept, "dropped": level.dropped},
                    "cpu_s": level.seconds,
                }
                for level in self.levels
            ],
            "exact": {WORDS[name]: self.exact.value(name) for name in QUANTITIES} if self.exact is not None else None,
            "extrapolated": {
                WORDS[name]: {"reason": limit} if isinstance(limit, Unknown) else {"order": limit[0], "value": limit[1]}
                for name, limit in self.extrapolated.items()
            },
            "order": {WORDS[name]: self.order(name) for name in QUANTITIES},
            "errors": {WORDS[name]: self.errors(name) for name in QUANTITIES},
            "time_exponent": self.time_exponent,
        }

    def words(self) -> list[str]:
        against = "the exact solution" if self.exact is not None else "the extrapolated value or the finest mesh"
        finest = [abs(error) for name in QUANTITIES if (error := self.errors(name)[-1]) is not None]
        verdict = f"errors within {max(finest):.1e} of {against}" if finest else "no errors"
        return [
            f"elements of {show(self.levels[-1].size, 'length', 3)}: {verdict}",
            f"  body      {self.problem.words}",
            f"  at        delta = {show(self.depth, 'length')}, w = {show(self.w, 'work')}",
            *map(self._order, QUANTITIES),
            f"  {'CPU seconds':<15} grow like the number of unknowns to the power {self.time_exponent:.2f}",
            f"  {'size':>10}{'elements':>10}{'a':>12}{'error':>9}{'P':>12}{'error':>9}{'pull-off':>12}{'error':>9}"
            f"{'kept':>6}{'dropped':>8}{'CPU s':>7}",
            *map(self._row, range(len(self.levels))),
        ]

    def _row(self, i: int) -> str:
        level = self.levels[i]
        cells = "".join(_cell(level.state.value(name), self.errors(name)[i], DIMENSIONS[name]) for name in QUANTITIES)
        size = show(level.size, "length", 3)
        return f"  {size:>10}{level.elements:>10}{cells}{level.kept:>6}{level.dropped:>8}{level.seconds:>7.2f}"

    def _order(self, name: str) -> str:
        order, limit = self.order(name), self.extrapolated[name]
        words = f"no order: {order}" if isinstance(order, Unknown) else f"observed order {order:.2f}"
        if isinstance(limit, Unknown):
            return f"  {WORDS[name]:<15} {words}; not extrapolated: {limit}"
        return f"  {WORDS[name]:<15} {words}; extrapolated {show(limit[1], DIMENSIONS[name], 6)}"

    @property
    def warnings(self) -> list[str]:
        points = ((show(level.size, "length", 3), level.state.point) for level in self.levels)
        return [f"elements of {size}: {point.reason}" for size, point in points if isinstance(point, Unknown)]

    def figure(self) -> Figure:
        from .converge_figure import convergence_figure

        return convergence_figure(self)


def _cell(value: float | None, error: float | None, dimension: str) -> str:
    if value is None:
        return f"{'none':>12}{'':>9}"
    return f"{show(value, dimension):>12}" + (f"{'':>9}" if error is None else f"{error:>+9.1e}")

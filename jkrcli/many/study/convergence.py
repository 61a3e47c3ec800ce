"""A convergence study as table, summary, words and figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...base import Unknown, show
from ...report import Figure, Result, tables
from .meshes import DIMENSIONS, WORDS, Meshes


@dataclass(frozen=True, eq=False)
class Convergence(Meshes, Result):
    """A study of meshes as a result."""

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row per mesh; the pull-off cell is empty where it lies outside the series."""
        return tables.by_columns([
            level.cells | {"pull_off_P_N": level.state.values["pull_off"], "points_kept": level.kept,
                           "points_dropped": level.dropped, "cpu_s": level.seconds}
            for level in self.levels
        ])  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """The meshes from coarse to fine, the exact values where there are some, the limits."""
        return {
            "format": "jkr-convergence",
            "version": 1,
            "problem": self.problem.words,
            "w_J_per_m2": self.w,
            "depth_m": self.depth,
            "levels": [
                level.cells | {"pull_off": tables.point(level.state.point),
                               "points": {"kept": level.kept, "dropped": level.dropped}, "cpu_s": level.seconds}
                for level in self.levels
            ],
            "exact": None if self.exact is None else {WORDS[name]: x for name, x in self.exact.values.items()},
            "extrapolated": {
                WORDS[name]: {"reason": limit} if isinstance(limit, Unknown) else {"order": limit[0], "value": limit[1]}
                for name, limit in self.extrapolated.items()
            },
            "order": {words: self.order(name) for name, words in WORDS.items()},
            "errors": {words: self.errors(name) for name, words in WORDS.items()},
            "time_exponent": self.time_exponent,
        }  # fmt: skip

    def words(self) -> list[str]:
        against = "the exact solution" if self.exact is not None else "the extrapolated value or the finest mesh"
        finest = [abs(error) for name in WORDS if (error := self.errors(name)[-1]) is not None]
        verdict = f"errors within {max(finest):.1e} of {against}" if finest else "no errors"
        return [
            f"elements of {show(self.levels[-1].size, 'length', 3)}: {verdict}",
            f"  body      {self.problem.words}",
            f"  at        delta = {show(self.depth, 'length')}, w = {show(self.w, 'work')}",
            *map(self._order, WORDS),
            f"  {'CPU seconds':<15} grow like the number of unknowns to the power {self.time_exponent:.2f}",
            f"  {'size':>10}{'elements':>10}{'a':>12}{'error':>9}{'P':>12}{'error':>9}{'pull-off':>12}{'error':>9}"
            f"{'kept':>6}{'dropped':>8}{'CPU s':>7}",
            *map(self._row, range(len(self.levels))),
        ]

    def _row(self, i: int) -> str:
        level = self.levels[i]
        cells = "".join(_cell(self.values(name)[i], self.errors(name)[i], DIMENSIONS[name]) for name in WORDS)
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
    shown = "none" if value is None else show(value, dimension)
    return f"{shown:>12}" + (f"{'':>9}" if error is None else f"{error:>+9.1e}")

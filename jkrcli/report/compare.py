"""Two results of the same problem: how far they lie apart, column by column."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..base import InputError
from ..series import Solution
from ..series.differences import Difference, curve_differences, series_differences
from .result import Figure, Result
from .tables import by_columns, read_curve


@dataclass(frozen=True, eq=False)
class Compared(Result):
    """Differences of the ``second`` from the ``first``; they ``agree`` where none of the columns that are ``counting``
    differs by more than ``rtol``."""

    first: Path
    second: Path
    differences: Sequence[Difference]
    rtol: float
    counting: Collection[str]

    @classmethod
    def of(
        cls, files: tuple[Path, Path], solutions: Callable[[], Sequence[Solution]], rtol: float,
        counting: Iterable[str], overlap: float,
    ) -> Compared:  # fmt: skip
        """Two CSV ``files`` of adhesive curves, of which all columns count where none is named, or else the series that
        ``solutions`` gives, of which P does. InputError where a column is not in both, or where less than ``overlap``
        of their range is."""
        if files[0].suffix == ".csv":
            differences = curve_differences(*map(read_curve, files))
            counts = set(counting) or {one.column for one in differences}
        else:
            differences, counts = _of_solutions(files, *solutions()), set(counting) or {"P"}
        if missing := counts - {one.column for one in differences}:
            raise InputError(f"compare: column {sorted(missing)[0]} is not in both files")
        for one in differences:
            if one.column in counts and one.coverage < overlap:
                raise InputError(
                    f"compare: {files[0]} and {files[1]} share only {one.coverage:.0%} of their range of {one.over}; "
                    f"load both as far, or allow it with --overlap {one.coverage:.2f}"
                )
        return cls(*files, differences, rtol, counts)

    @property
    def agree(self) -> bool:
        return all(one.worst <= self.rtol for one in self.differences if one.column in self.counting)

    @cached_property
    def _rows(self) -> Mapping[str, Mapping[str, Any]]:
        return {
            one.column: {
                "worst": one.worst,
                "over": one.over,
                "at": float(one.x[one.worst_row]),
                "counts": one.column in self.counting,
            }
            for one in self.differences
        }

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return by_columns([{"column": name, **row} for name, row in self._rows.items()])

    def summary(self) -> dict[str, Any]:
        files = {"first": str(self.first), "second": str(self.second)}
        return files | {"rtol": self.rtol, "agree": self.agree, "columns": dict(self._rows)}

    def words(self) -> list[str]:
        lines = [f"{self.first} against {self.second}: {'agree' if self.agree else 'DIFFER'} at rtol {self.rtol:g}"]
        for one in self.differences:
            counts = "" if one.column in self.counting else "  (not counted)"
            where = f"at {one.over} = {one.x[one.worst_row]:.6g}, {one.x.size} rows of {self.first.name}"
            lines.append(f"  {one.column:<16} worst {one.worst:.3e} {where}{counts}")
        return lines

    def figure(self) -> Figure:
        from .plots.study import differences_figure

        return differences_figure(self.differences, self.rtol)


def _of_solutions(files: tuple[Path, Path], one: Solution, two: Solution) -> list[Difference]:
    """Differences of two series of the same bodies; InputError where they are of others."""
    for name in ("indenter", "specimen"):
        if getattr(one.problem, name) != getattr(two.problem, name):
            raise InputError(f"{files[1]}: its {name} is not that of {files[0]}; compare results of the same problem")
    return series_differences(one.filtered, two.filtered)

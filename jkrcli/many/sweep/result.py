"""A sweep, and one case of it, as results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...base import InputError, printable
from ...report import Figure, Result
from .plan import Plan
from .solving import FAILED, Row
from .table import SweepTable


@dataclass(frozen=True, eq=False)
class Swept(Result):
    """All cases of a ``plan`` in a ``table``, a row each, and the ``files`` that hold it."""

    plan: Plan
    table: SweepTable
    files: Sequence[Path] = ()

    @property
    def columns(self) -> Mapping[str, list[Any]]:  # type: ignore[override]
        return self.table.columns

    @property
    def warnings(self) -> list[str]:
        failed = self.table.failed
        return [f"{len(failed):,} cases failed, the first because: {failed[0][1]}"] if failed else []

    def summary(self) -> dict[str, Any]:
        return {
            "format": "jkr-sweep-summary",
            "cases": self.plan.count,
            FAILED: len(self.table.failed),
            "columns": list(self.columns),
            "files": [str(path) for path in self.files],
        }

    def words(self) -> list[str]:
        plan, failed = self.plan, self.table.failed
        return [
            f"{plan.count:,} cases, {len(failed):,} of them failed: {plan.title or plan.source}",
            f"  one case  {plan.command(failed[0][0] if failed else 0)}",
        ]

    def figure(self) -> Figure:
        from .figure import sweep_figure

        if (figure := sweep_figure(self.plan, self.table)) is None:
            raise InputError(f"{self.plan.source}: no axis or no result is a number: there is nothing to draw")
        return figure


@dataclass(frozen=True, eq=False)
class SweptCase(Result):
    """The ``row`` of one case of a ``plan``."""

    plan: Plan
    row: Row

    def summary(self) -> dict[str, Any]:
        row, plan = self.row, self.plan
        inputs = dict(zip(plan.key_columns, plan.values(row.number).values(), strict=True))
        outputs = dict(zip(plan.recipe.wanted.columns, row.values, strict=True))
        return {"case": row.number, "status": row.status, "reason": row.reason, **inputs, **outputs}

    def words(self) -> list[str]:
        cells = self.summary().items()
        return [printable(f"{name:<40} {'' if value is None else value}".rstrip()) for name, value in cells]

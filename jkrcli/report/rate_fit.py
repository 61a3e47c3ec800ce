"""A common fit of records at several speeds as a table, as a summary and in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..adhesion.rate.validity import NEGLECTED
from ..base import show
from ..identification.rate.fitting import RateFit
from .fit import brief, estimate_summary, estimate_words
from .rate import law_words
from .result import Figure, Result
from .tables import stiffness

NAMES = ("curve", "t_s", "P_N", "P_fit_N", "a_fit_m", "speed_m_per_s")
FORMAT, VERSION = "jkr-rate-fit", 1


@dataclass(frozen=True, eq=False)
class LawFit(RateFit, Result):
    """A common fit with what is said of it; ``body``: of what, in words."""

    warnings: tuple[str, ...] = ()
    body: str = ""

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all records: readings, prediction, and the edge's speed and radius."""
        found: dict[str, list[Any]] = {name: [] for name in NAMES}
        measured = any(record.a is not None for record in self.records)
        if measured:
            found["a_m"] = []
        for record, told in zip(self.records, self.predictions, strict=True):
            found["curve"] += [record.curve.name] * record.t.size
            values = {"t_s": record.t, "P_N": record.P, "P_fit_N": told.P + self.zero, "a_fit_m": told.a,
                      "speed_m_per_s": np.where(told.speed > 0, -told.speed, 0.0)}  # fmt: skip
            if measured:
                values["a_m"] = np.full(record.t.size, np.nan) if record.a is None else record.a
            for name, column in values.items():
                found[name] += column.tolist()
        return found

    def summary(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "version": VERSION,
            "body": self.body,
            "law": self.settings.law,
            "free": list(self.free),
            "level": self.settings.level,
            "estimates": {item.name: estimate_summary(item) for item in self.estimates},
            "records": [
                {"curve": record.curve.where, "rows": record.t.size, "device_speed_m_per_s": record.speed,
                 "stiffness_N_per_m": stiffness(record.stiffness),
                 "noise_P_N": record.noise["P"]} for record in self.records
            ],
            "edge_speeds_m_per_s": list(self.speeds),
            "scatter": self.scatter,
            "degrees_of_freedom": self.dof,
            "neglected": NEGLECTED,
            "warnings": list(self.warnings),
        }  # fmt: skip

    def words(self) -> list[str]:
        rows = sum(record.t.size for record in self.records)
        speeds = " to ".join(show(v, "speed", 3) for v in self.speeds)
        records = f"{len(self.records)} record{'s' if len(self.records) > 1 else ''}"
        free = [item for item in self.estimates if item.free and item.name in ("E_star", "w0")]
        lines = [brief(free, self.settings.level), f"  {records}, {rows} rows; {law_words(self.law)}; edge {speeds}"]
        for item in self.estimates:
            if item.free and item.name != "modulus":
                lines.append(
                    f"  {'E*' if item.name == 'E_star' else item.name:<12} {estimate_words(item, self.settings.level)}"
                )
        lines.append(f"  {'scatter':<12} {self.scatter:.3g} of the noise from row to row")
        return lines

    def figure(self) -> Figure:
        from .plots.rate import rate_fit_figure

        return rate_fit_figure(self)

"""A common fit of records at several speeds as a table, as a summary and in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..adhesion.validity import NEGLECTED
from ..base import show
from ..identification.rate.fitting import RateFit
from .fit import brief, estimate_lines, estimate_summary
from .rate import law_words
from .result import Figure, Result
from .tables import stacked, stiffness

FORMAT, VERSION = "jkr-rate-fit", 1


@dataclass(frozen=True, eq=False)
class LawFit(RateFit, Result):
    """A common fit as a result; ``body``: what was fitted, in words."""

    body: str = ""

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all records: readings, prediction, and the edge's speed and radius."""
        tables = []
        measured = any(record.a is not None for record in self.records)
        for record, prediction in zip(self.records, self.predictions, strict=True):
            values = {"t_s": record.t, "P_N": record.P, "P_fit_N": prediction.P + self.zero, "a_fit_m": prediction.a,
                      "speed_m_per_s": np.where(prediction.speed > 0, -prediction.speed, 0.0)}  # fmt: skip
            if measured:
                values["a_m"] = np.full(record.t.size, np.nan) if record.a is None else record.a
            curve = {"curve": [record.curve.name] * record.t.size}
            tables.append(curve | {name: column.tolist() for name, column in values.items()})
        return stacked(tables)

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
        return [
            brief(free, self.settings.level),
            f"  {records}, {rows} rows; {law_words(self.law)}; edge {speeds}",
            *estimate_lines(self.estimates, self.settings.level),
            f"  {'scatter':<12} {self.scatter:.3g} of the noise from row to row",
        ]

    def figure(self) -> Figure:
        from .plots.rate import rate_fit_figure

        return rate_fit_figure(self)

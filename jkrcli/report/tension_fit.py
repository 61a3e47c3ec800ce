"""A common fit of surface tension as a table, as a summary and in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import show
from ..identification.tension import TensionFit
from .fit import brief, estimate_summary, estimate_words
from .result import Result
from .tables import stacked


@dataclass(frozen=True, eq=False)
class TensionFitted(TensionFit, Result):
    """A common fit as a result; ``body``: what was fitted, in words; ``level`` of its intervals."""

    body: str = ""
    level: float = 0.95

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all records: readings and the fitted load."""
        return stacked([
            {"curve": [record.name] * loads.size, "delta_m": record.depth.tolist(), "P_N": record.load.tolist(),
             "P_fit_N": loads.tolist()} for record, loads in zip(self.records, self.loads, strict=True)
        ])  # fmt: skip

    def summary(self) -> dict[str, Any]:
        return {
            "format": "jkr-tension-fit",
            "version": 1,
            "body": self.body,
            "estimates": {item.name: estimate_summary(item) for item in self.estimates},
            "free": list(self.free),
            "correlation": np.asarray(self.correlation).tolist(),
            "scatter_N": self.scatter,
            "warnings": list(self.warnings),
        }

    def words(self) -> list[str]:
        rows = sum(map(len, self.records))
        together = "1 record" if len(self.records) == 1 else f"{len(self.records)} records together"
        free = [item for item in self.estimates if item.free]
        mixed = f"; one radius does not separate the tension from {' and '.join(self.mixed)}" if self.mixed else ""
        lines = [
            brief(free, self.level) + mixed,
            f"  {together}, {rows} rows, scatter of the load {show(self.scatter, 'load', 2)}",
        ]
        known = [f"{item.name} = {show(item.value, item.dimension)}" for item in self.estimates if not item.free]
        lines += [f"  {item.name:<24} {estimate_words(item, self.level)}" for item in free]
        return lines + ([f"  fixed: {', '.join(known)}"] if known else [])

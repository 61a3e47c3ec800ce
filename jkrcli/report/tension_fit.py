"""A common fit of surface tension as a table, as a summary and in words."""

from __future__ import annotations

from typing import Any

from ..base.units import show
from ..identification.tension import TensionFit
from .fit import brief, estimate_summary, estimate_words


def columns(fit: TensionFit) -> dict[str, list[Any]]:
    """All rows of all records: readings and the fitted load."""
    found: dict[str, list[Any]] = {name: [] for name in ("curve", "delta_m", "P_N", "P_fit_N")}
    for record, loads in zip(fit.records, fit.loads, strict=True):
        found["curve"] += [record.name] * record.P.size
        for name, values in (("delta_m", record.delta), ("P_N", record.P), ("P_fit_N", loads)):
            found[name] += values.tolist()
    return found


def summary(fit: TensionFit, body: str) -> dict[str, Any]:
    """What stands in the JSON file."""
    return {
        "format": "jkr-tension-fit",
        "version": 1,
        "body": body,
        "estimates": {item.name: estimate_summary(item) for item in fit.estimates},
        "free": list(fit.free),
        "correlation": fit.correlation.tolist(),
        "scatter_N": fit.scatter,
        "warnings": list(fit.warnings),
    }


def words(fit: TensionFit, level: float) -> list[str]:
    """The fit as lines of text."""
    rows = sum(record.P.size for record in fit.records)
    free = [item for item in fit.estimates if item.free]
    lines = [
        ", ".join(map(brief, free)),
        f"  {len(fit.records)} records together, {rows} rows, scatter of the load {show(fit.scatter, 'load', 2)}",
    ]
    known = [f"{item.name} = {show(item.value, item.dimension)}" for item in fit.estimates if not item.free]
    lines += [f"  {item.name:<24} {estimate_words(item, level)}" for item in free]
    return lines + ([f"  fixed: {', '.join(known)}"] if known else [])

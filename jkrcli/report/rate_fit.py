"""A common fit of records at several speeds as a table, as a summary and in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..adhesion.rate.validity import NEGLECTED
from ..base.units import show
from ..identification.rate.fitting import RateFit
from .fit import brief, estimate_summary, estimate_words
from .rate import law_words
from .tables import stiffness

FORMAT, VERSION = "jkr-rate-fit", 1


def columns(fit: RateFit) -> dict[str, list[Any]]:
    """All rows of all records: readings, prediction, and the edge's speed and radius."""
    found: dict[str, list[Any]] = {name: [] for name in ("curve", "t_s", "P_N", "P_fit_N", "a_fit_m", "speed_m_per_s")}
    measured = any(record.a is not None for record in fit.records)
    if measured:
        found["a_m"] = []
    for record, told in zip(fit.records, fit.predictions, strict=True):
        found["curve"] += [record.curve.name] * record.t.size
        values = {"t_s": record.t, "P_N": record.P, "P_fit_N": told.P + fit.zero, "a_fit_m": told.a,
                  "speed_m_per_s": np.where(told.speed > 0, -told.speed, 0.0)}  # fmt: skip
        if measured:
            values["a_m"] = np.full(record.t.size, np.nan) if record.a is None else record.a
        for name, column in values.items():
            found[name] += column.tolist()
    return found


def summary(fit: RateFit, body: str) -> dict[str, Any]:
    """What stands in the JSON file."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "body": body,
        "law": fit.settings.law,
        "free": list(fit.free),
        "level": fit.settings.level,
        "estimates": {item.name: estimate_summary(item) for item in fit.estimates},
        "records": [
            {"curve": record.curve.where, "rows": record.t.size, "device_speed_m_per_s": record.speed,
             "stiffness_N_per_m": stiffness(record.stiffness),
             "noise_P_N": record.noise["P"]} for record in fit.records
        ],
        "edge_speeds_m_per_s": list(fit.speeds),
        "scatter": fit.scatter,
        "degrees_of_freedom": fit.dof,
        "neglected": NEGLECTED,
        "warnings": list(fit.warnings),
    }  # fmt: skip


def words(fit: RateFit) -> list[str]:
    """Lines for people."""
    rows = sum(record.t.size for record in fit.records)
    speeds = " to ".join(show(v, "speed", 3) for v in fit.speeds)
    records = f"{len(fit.records)} record{'s' if len(fit.records) > 1 else ''}"
    free = [item for item in fit.estimates if item.free and item.name in ("E_star", "w0")]
    lines = [", ".join(map(brief, free)), f"  {records}, {rows} rows; {law_words(fit.law)}; edge {speeds}"]
    for item in fit.estimates:
        if item.free and item.name != "modulus":
            lines.append(
                f"  {'E*' if item.name == 'E_star' else item.name:<12} {estimate_words(item, fit.settings.level)}"
            )
    lines.append(f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row")
    return lines

"""Records fitted together as a table, as a summary and in words: what they share, a surface tension, or a law of w over
the speed of the contact's edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..adhesion.validity import NEGLECTED
from ..base import show
from ..identification.fit import JointFit
from ..identification.rate.fitting import RateFit
from ..identification.tension import TensionFit
from . import fit as each
from .fit import DOUBTFUL, FITTED, brief, estimate_lines, estimate_summary, estimate_words, identity
from .rate import law_words
from .result import Figure, Result
from .tables import stacked, stiffness


@dataclass(frozen=True, eq=False)
class JointFitted(JointFit, Result):
    """Records fitted together as a result; ``body``: what was fitted, in words; ``level`` of their intervals."""

    body: str = ""
    level: float = 0.95

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row for each record: what all share, and its own."""
        return each.columns(self.fits)

    def summary(self) -> dict[str, Any]:
        return identity("jkr-joint-fit", self.body) | {
            "shared": {item.name: estimate_summary(item) for item in self.shared},
            "correlation": np.asarray(self.correlation).tolist(),
            "chance": self.chance,
            "status": DOUBTFUL if self.flags else FITTED,
            "flags": list(self.flags),
            "alone": [dict(values) for values in self.alone],
            "curves": each.summary(self.fits, self.body)["curves"],
            "warnings": list(self.warnings),
        }

    def words(self) -> list[str]:
        """What is shared, then what each record says alone, and its own."""
        shared = [item for item in self.shared if item.name != "modulus"]
        lines = [
            brief(shared, self.level) + (f"; {DOUBTFUL}: {', '.join(self.flags)}" if self.flags else ""),
            f"  {len(self.fits)} records together (p = {self.chance:.2g} that such records differ as much)",
        ]
        lines += estimate_lines(shared, self.level, {})
        dimensions = {item.name: item.dimension for item in self.shared}
        for one, values in zip(self.fits, self.alone, strict=True):
            own = [item for item in one.estimates if item.free and item.name not in dimensions]
            parts = [f"{name} = {show(value, dimensions[name], 4)}" for name, value in values.items()]
            rest = ", ".join(f"{i.name} = {show(i.value, i.dimension, 4)}" for i in own if i.dimension != "modulus")
            lines.append(f"  {one.name}: alone {', '.join(parts)}; its own {rest or 'none'}")
        return lines

    def figure(self) -> Figure:
        from .plots.fit import joint_figure

        return joint_figure(self)


@dataclass(frozen=True, eq=False)
class TensionFitted(TensionFit, Result):
    """A common fit as a result; ``body``: what was fitted, in words; ``level`` of its intervals."""

    body: str = ""
    level: float = 0.95

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all records: readings and the fitted load."""
        return stacked([
            {"curve": [record.name] * loads.size, "delta_m": record.depth, "P_N": record.load, "P_fit_N": loads}
            for record, loads in zip(self.records, self.loads, strict=True)
        ])  # fmt: skip

    def summary(self) -> dict[str, Any]:
        return identity("jkr-tension-fit", self.body) | {
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


@dataclass(frozen=True, eq=False)
class LawFit(RateFit, Result):
    """A common fit of records at several speeds as a result; ``body``: what was fitted, in words."""

    body: str = ""

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all records: readings, prediction, and the edge's speed and radius."""
        tables = []
        measured = any(record.a is not None for record in self.records)
        for record, prediction in zip(self.records, self.predictions, strict=True):
            values: dict[str, Any] = {
                "curve": [record.curve.name] * record.t.size, "t_s": record.t, "P_N": record.P,
                "P_fit_N": prediction.P + self.zero, "a_fit_m": prediction.a,
                "speed_m_per_s": np.where(prediction.speed > 0, -prediction.speed, 0.0),
            }  # fmt: skip
            if measured:
                values["a_m"] = np.full(record.t.size, np.nan) if record.a is None else record.a
            tables.append(values)
        return stacked(tables)

    def summary(self) -> dict[str, Any]:
        return identity("jkr-rate-fit", self.body) | {
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

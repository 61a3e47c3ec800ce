"""Fits of relaxation as a table, as a summary and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..base import SI
from ..identification.relaxation import RelaxationFit
from .fit import DOUBTFUL, FITTED, ZERO_POINTS, brief, estimate_lines, estimate_summary, identity
from .relaxation import NEGLECTED, law_summary
from .result import Figure, Several
from .tables import by_columns, stiffness


class _OfFits(Several):
    """Results of ``fits`` of one law, each to a record, on a ``body``."""

    fits: Sequence[RelaxationFit]
    body: str

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row per record: its estimates with their standard errors, and the scatter."""
        return by_columns([
            {"curve": fit.record.curve.where, "law": fit.settings.law, **_values(fit), "scatter": fit.scatter,
             "rows": fit.record.t.size} for fit in self.fits
        ])  # fmt: skip

    def summary(self) -> dict[str, Any]:
        level, fits = self.fits[0].settings.level, [_fit(fit) for fit in self.fits]
        return identity("jkr-relaxation-fit", self.body) | {"level": level, "fits": fits, "neglected": NEGLECTED}

    @property
    def parts(self) -> list[list[str]]:
        return list(map(_words, self.fits))

    def figure(self) -> Figure:
        from .plots.rate import relaxation_fit_figure

        return relaxation_fit_figure(self.fits)


@dataclass(frozen=True, eq=False)
class RelaxationFits(_OfFits):
    """Fits of one law, each of a record; ``body``: what was fitted, in words."""

    fits: Sequence[RelaxationFit]
    body: str

    @property
    def warnings(self) -> list[str]:
        return [f"{fit.record.curve.where}: {line}" for fit in self.fits for line in fit.warnings]


@dataclass(frozen=True, eq=False)
class RelaxationFitted(RelaxationFit, _OfFits):
    """A fit as a result; ``body``: what was fitted, in words."""

    body: str = ""

    @property
    def fits(self) -> Sequence[RelaxationFit]:  # type: ignore[override]
        return [self]


def _values(fit: RelaxationFit) -> dict[str, float | None]:
    """The free parameters with their standard errors."""
    free = [item for item in fit.estimates if item.free and item.name != "modulus"]
    named = ((f"{item.name}_{SI[item.dimension]}".rstrip("_"), item) for item in free)
    return {key: value for name, item in named for key, value in ((name, item.value), (f"{name}_error", item.error))}


def _fit(fit: RelaxationFit) -> dict[str, Any]:
    record = fit.record
    return {
        "curve": record.curve.where,
        "rows": record.t.size,
        "control": record.control,
        "stiffness_N_per_m": stiffness(record.stiffness),
        "relaxation": law_summary(fit.relaxation),
        "free": list(fit.free),
        "estimates": {item.name: estimate_summary(item) for item in fit.estimates},
        "scatter": fit.scatter,
        "degrees_of_freedom": fit.dof,
        "status": DOUBTFUL if fit.doubts else FITTED,
        "warnings": list(fit.warnings),
    }


def _words(fit: RelaxationFit) -> list[str]:
    """Lines for people."""
    record, level = fit.record, fit.settings.level
    control = "displacement of the tip" if record.control == "tip" else record.control
    pieces = len(record.knots[0]) - 1
    straight = f"held, {pieces} straight piece{'s' if pieces > 1 else ''}"
    motion = "as it was read" if record.read else straight
    own = [fit.estimate(name) for name in ("E_star", *fit.free) if name not in ("modulus", *ZERO_POINTS)]
    doubts = f"; doubtful: {', '.join(fit.doubts)}" if fit.doubts else ""
    return [
        brief(own, level) + doubts,
        f"  {record.curve.where}: {fit.relaxation}; {record.t.size} rows, the {control} {motion}",
        *estimate_lines(fit.estimates, level, {"E_star": "E*" if fit.settings.law == "power" else "E* instant"}),
        f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row",
    ]

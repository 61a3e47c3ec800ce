"""Fits of relaxation as a table, as a summary and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..base import SI
from ..identification.relaxation import RelaxationFit
from .fit import brief, estimate_summary, estimate_words
from .relaxation import NEGLECTED, law_summary
from .result import Figure, Result, Several
from .tables import stiffness

FORMAT = "jkr-relaxation-fit"


@dataclass(frozen=True, eq=False)
class RelaxationFits(Several):
    """Fits of one law, each of a record; ``body``: of what, in words."""

    fits: Sequence[RelaxationFit]
    body: str

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row per record: its estimates with their standard errors, and the scatter."""
        fits = self.fits
        found: dict[str, list[Any]] = {
            "curve": [fit.record.curve.where for fit in fits], "law": [fit.settings.law for fit in fits],
        }  # fmt: skip
        for item in fits[0].estimates:
            if item.free and item.name != "modulus":
                head = f"{item.name}_{SI[item.dimension]}".rstrip("_")
                found[head] = [fit.estimate(item.name).value for fit in fits]
                found[f"{head}_error"] = [fit.estimate(item.name).error for fit in fits]
        return found | {"scatter": [fit.scatter for fit in fits], "rows": [fit.record.t.size for fit in fits]}

    def summary(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "version": 1,
            "body": self.body,
            "level": self.fits[0].settings.level,
            "fits": [_fit(fit) for fit in self.fits],
            "neglected": NEGLECTED,
        }

    @property
    def parts(self) -> list[list[str]]:
        return list(map(_words, self.fits))

    @property
    def warnings(self) -> list[str]:
        return [f"{fit.record.curve.where}: {line}" for fit in self.fits for line in fit.warnings]

    def figure(self) -> Figure:
        from .plots.relaxation import relaxation_fit_figure

        return relaxation_fit_figure(self.fits)


@dataclass(frozen=True, eq=False)
class RelaxationFitted(RelaxationFit, Result):
    """A fit with what is said of it; ``body``: of what, in words."""

    body: str = ""

    @property
    def _alone(self) -> RelaxationFits:
        return RelaxationFits([self], self.body)

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return self._alone.columns

    def summary(self) -> dict[str, Any]:
        return self._alone.summary()

    def words(self) -> list[str]:
        return _words(self)

    def figure(self) -> Figure:
        return self._alone.figure()


def _fit(fit: RelaxationFit) -> dict[str, Any]:
    record = fit.record
    return {
        "curve": record.curve.where,
        "rows": record.t.size,
        "control": "load" if record.loaded else "displacement",
        "stiffness_N_per_m": stiffness(record.stiffness),
        "relaxation": law_summary(fit.relaxation),
        "free": list(fit.free),
        "estimates": {item.name: estimate_summary(item) for item in fit.estimates},
        "scatter": fit.scatter,
        "degrees_of_freedom": fit.dof,
        "warnings": list(fit.warnings),
    }


def _words(fit: RelaxationFit) -> list[str]:
    """Lines for people."""
    record, level = fit.record, fit.settings.level
    held = "load" if record.loaded else "displacement"
    motion = "as it was read" if record.read else f"held, {_pieces(record.knots[0])}"
    lines = [
        brief([fit.estimate("E_star")], level),
        f"  {record.curve.where}: {fit.relaxation}; {record.t.size} rows, the {held} {motion}",
    ]
    for item in fit.estimates:
        if item.free and item.name != "modulus":
            name = ("E* instant" if fit.settings.law != "power" else "E*") if item.name == "E_star" else item.name
            lines.append(f"  {name:<12} {estimate_words(item, level)}")
    return [*lines, f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row"]


def _pieces(knots: Any) -> str:
    count = len(knots) - 1
    return f"{count} straight piece{'s' if count > 1 else ''}"

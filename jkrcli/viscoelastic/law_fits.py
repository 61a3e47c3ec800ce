"""Results of fits of laws, of w over the speed of the edge and of relaxation, as tables, summaries, words, figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import AT_LEVEL, LEVEL, Unknown
from ..base.registry import FIGURES, SUMMARIES, TABLES, WORDS
from ..base.units import show
from ..measured.archive import DOUBTFUL, FITTED
from ..measured.least_squares import t_quantile
from ..measured.report import ZERO_POINTS, brief, estimate_lines, estimate_summary, identity
from ..report.result import Figure, Several
from ..report.tables import stacked, stiffness, transpose_rows, with_unit
from . import report as rate
from . import rheology
from .edge_zone import NEGLECTED
from .rate_fit import LawAlongRecords, RateFit
from .shared_speeds import SharedSpeedsFit
from .timed_record import RelaxationFit

VAGUE = 1.0  # relative standard error, theory: one as large as the parameter does not tell it from zero
OVER_TIME, OVER_TIMES = (0.01, 0.5), 5  # choice: of the time in contact, at which E*(t) is written


@TABLES.register(RateFit)
def rate_fit_table(fit: RateFit) -> dict[str, list[Any]]:
    """All rows of all records: readings, prediction, and the edge's speed and radius."""
    tables = []
    measured = any(record.a is not None for record in fit.records)
    for record, prediction in zip(fit.records, fit.predictions, strict=True):
        values: dict[str, Any] = {
            "curve": [record.curve.name] * record.t.size, "t_s": record.t, "P_N": record.P,
            "P_fit_N": prediction.P + fit.zero, "a_fit_m": prediction.a,
            "speed_m_per_s": np.where(prediction.speed > 0, -prediction.speed, 0.0),
        }  # fmt: skip
        if measured:
            values["a_m"] = np.full(record.t.size, np.nan) if record.a is None else record.a
        tables.append(values)
    return stacked(tables)


@SUMMARIES.register(RateFit)
def rate_fit_summary(fit: RateFit) -> dict[str, Any]:
    """The law, its parameters and the records."""
    return identity("jkr-rate-fit", fit.body) | {
        "law": fit.settings.law,
        "free": list(fit.free),
        "level": fit.settings.level,
        "estimates": {item.name: estimate_summary(item, fit.settings.level) for item in fit.estimates},
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


@WORDS.register(RateFit)
def rate_fit_words(fit: RateFit) -> list[str]:
    """E* and w0, the law over the speeds of the edge, then each value."""
    rows = sum(record.t.size for record in fit.records)
    speeds = " to ".join(show(v, "speed", 3) for v in fit.speeds)
    records = f"{len(fit.records)} record{'s' if len(fit.records) > 1 else ''}"
    free = [item for item in fit.estimates if item.free and item.name in ("E_star", "w0")]
    return [
        brief(free, fit.settings.level),
        f"  {records}, {rows} rows; {rate.law_words(fit.law)}; edge {speeds}",
        *estimate_lines(fit.estimates, fit.settings.level),
        f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row",
    ]


@FIGURES.register(RateFit)
def draw_rate_fit(fit: RateFit) -> Figure:
    """The picture of a law of w over the speed of the edge."""
    from .figures import rate_fit_figure

    return rate_fit_figure(fit)


# --------------------------------------------------------------------------------------------------
# Fits of relaxation as a table, as a summary and in words.


@dataclass(frozen=True, eq=False)
class RelaxationFits(Several):
    """Results of ``fits`` of one law, each to a record; ``body``: what was fitted, in words."""

    fits: Sequence[RelaxationFit]
    body: str

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row per record: its estimates with their half-widths, and the scatter."""
        rows = []
        for fit in self.fits:
            row: dict[str, Any] = {"curve": fit.record.curve.where, "law": fit.settings.law}
            for item in fit.estimates:
                if item.free and item.name != "modulus":
                    name = with_unit(item.name, item.dimension)
                    row |= {name: item.value, f"{name}_error": item.half_width(fit.settings.level)}
            row |= rheology.columns(fit)
            rows.append(row | {"scatter": fit.scatter, "rows": fit.record.t.size, "level": fit.settings.level})
        return transpose_rows(rows)

    def summary(self) -> dict[str, Any]:
        level, fits = self.fits[0].settings.level, [_fit(fit) for fit in self.fits]
        return identity("jkr-relaxation-fit", self.body) | {
            "level": level,
            "fits": fits,
            "neglected": rate.ADHESION_NEGLECTED if self.fits[0].settings.adheres else rate.RELAXATION_NEGLECTED,
        }

    @property
    def parts(self) -> list[list[str]]:
        return list(map(relaxation_fit_words, self.fits))

    def figure(self) -> Figure:
        from .figures import relaxation_fit_figure

        return relaxation_fit_figure(self.fits)

    @property
    def warnings(self) -> list[str]:
        return [f"{fit.record.curve.where}: {line}" for fit in self.fits for line in fit.warnings]


TABLES.register(RelaxationFit)(lambda fit: RelaxationFits([fit], fit.body).columns)
SUMMARIES.register(RelaxationFit)(lambda fit: RelaxationFits([fit], fit.body).summary())
FIGURES.register(RelaxationFit)(lambda fit: RelaxationFits([fit], fit.body).figure())


def _fit(fit: RelaxationFit) -> dict[str, Any]:
    record, over_time = fit.record, list[dict[str, float]]()
    if fit.settings.adheres:  # E*(t) after a step at some times within the contact, with its intervals
        t = np.geomspace(OVER_TIME[0], OVER_TIME[-1], OVER_TIMES) * (record.lasting or float(np.ptp(record.t)))
        names = ("t_s", "E_star_Pa", "low_Pa", "high_Pa")
        over_time = [dict(zip(names, row, strict=True)) for row in np.column_stack([t, fit.modulus(t)]).tolist()]
    return {
        "curve": record.curve.where,
        "rows": record.t.size,
        "control": record.control,
        "stiffness_N_per_m": stiffness(record.stiffness),
        "relaxation": rate.relaxation_law_summary(fit.relaxation),
        "free": list(fit.free),
        "estimates": {item.name: estimate_summary(item, fit.settings.level) for item in fit.estimates},
        "rheology": rheology.summary(fit),
        **({"modulus_over_time": over_time} if over_time else {}),
        "scatter": fit.scatter,
        "degrees_of_freedom": fit.dof,
        "status": DOUBTFUL if fit.doubts else FITTED,
        "warnings": list(fit.warnings),
    }


@WORDS.register(RelaxationFit)
def relaxation_fit_words(fit: RelaxationFit) -> list[str]:
    """Lines for people."""
    record, level = fit.record, fit.settings.level
    control = "displacement of the tip" if record.control == "tip" else record.control
    pieces = len(record.knots[0]) - 1
    straight = f"prescribed, {pieces} straight piece{'s' if pieces > 1 else ''}"
    motion = "as it was read" if record.read else straight
    own = [fit.estimate(name) for name in ("E_star", *fit.free) if name not in ("modulus", *ZERO_POINTS)]
    doubts = f"; doubtful: {', '.join(fit.doubts)}" if fit.doubts else ""
    fixed = [fit.estimate(name) for name in ("w", "stress", "range") if name in fit.settings.fixed]
    known = "".join(f", {item.name} = {show(item.value, item.dimension)} (fixed)" for item in fixed)
    return [
        brief(own, level) + doubts,
        f"  {record.curve.where}: {fit.relaxation}{known}; {record.t.size} rows, the {control} {motion}",
        *estimate_lines(fit.estimates, level, {"E_star": "E*" if fit.settings.law == "power" else "E* instant"}),
        rheology.words(fit),
        f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row",
    ]


# --------------------------------------------------------------------------------------------------
# Of records of one specimen at several speeds.


@TABLES.register(SharedSpeedsFit)
def shared_speeds_table(fit: SharedSpeedsFit) -> dict[str, list[Any]]:
    """A row per record: what is common to all, its own zeros, its scatter."""
    return RelaxationFits(fit.fits, fit.body).columns | {"device_speed_m_per_s": list(fit.speeds)}


@SUMMARIES.register(SharedSpeedsFit)
def shared_speeds_summary(fit: SharedSpeedsFit) -> dict[str, Any]:
    """What is common to all records, then each of them."""
    level = fit.settings.level
    return identity("jkr-shared-speeds-fit", fit.body) | {
        "level": level,
        "free": list(fit.free),
        "estimates": {item.name: estimate_summary(item, level) for item in fit.estimates},
        "rate": rate.law_summary(fit.law),
        "scatter": fit.scatter,
        "fits": [_fit(one) | {"device_speed_m_per_s": v} for one, v in zip(fit.fits, fit.speeds, strict=True)],
        "neglected": rate.ADHESION_NEGLECTED,
        "warnings": list(fit.warnings),
    }


@WORDS.register(SharedSpeedsFit)
def shared_speeds_words(fit: SharedSpeedsFit) -> list[str]:
    """What is common to all records; their zeros stand in the table."""
    level, first = fit.settings.level, fit.fits[0]
    own = [item for item in fit.estimates if item.free and item.name != "modulus"]
    doubts = list(dict.fromkeys(doubt for one in fit.fits for doubt in one.doubts))
    speeds = ", ".join(show(v, "speed", 3) for v in fit.speeds)
    law = f"; w0 = {show(fit.value('w'), 'work')}, {rate.law_words(fit.law)}" if fit.law else ""
    return [
        brief(own, level) + (f"; doubtful: {', '.join(doubts)}" if doubts else ""),
        f"  {len(fit.fits)} force curves at {speeds} fitted together: {first.relaxation}{law}",
        *estimate_lines(fit.estimates, level, {"E_star": "E*" if fit.settings.law == "power" else "E* instant"}),
        rheology.words(first),
        f"  {'scatter':<12} {fit.scatter:.3g} of the noise from row to row",
    ]


@FIGURES.register(SharedSpeedsFit)
def draw_shared_speeds(fit: SharedSpeedsFit) -> Figure:
    """The pictures of the records, and w over the speed of the edge."""
    from .figures import relaxation_fit_figure

    return relaxation_fit_figure(fit.fits, fit.speeds if fit.law else ())


# --------------------------------------------------------------------------------------------------
# A law through points of w over speed, of a measured work of adhesion.


def through_summary(through: LawAlongRecords | Unknown | None) -> dict[str, Any] | None:
    """The law through points of w over speed, or why there is none; None where no time was recorded."""
    if through is None or isinstance(through, Unknown):
        return None if through is None else {"law": None, "reason": through.reason}
    return {
        **(rate.law_summary(through.law) or {}),
        "w0_J_per_m2": through.w0,
        "relative_standard_errors": through.errors,
        "speeds_m_per_s": list(through.speeds),
        "told": not through.narrow
        and through.inner is not None
        and all((error or 1) < VAGUE for error in through.errors.values()),
    }


def through_words(through: LawAlongRecords | Unknown) -> str:
    """The law through points of w over the speed in a line, or that the points determine none of its parameters."""
    if isinstance(through, Unknown):
        return f"no law over speed: {through.reason}"
    low, high = (show(v, "speed", 3) for v in through.speeds)
    known = {name: error for name, error in through.errors.items() if error is not None and error <= VAGUE}
    if not known:
        return f"no law over speed: {low} to {high} determine none of {', '.join(through.names)}"
    t = t_quantile(LEVEL, through.dof)
    determined = {
        name: f"± {100 * t * known[name]:.2g} %" if name in known else "not determined" for name in through.names
    }
    errors = ", ".join(f"{name} {word}" for name, word in determined.items()) + f", at {AT_LEVEL}"
    doubt = "; less than a decade of speeds does not separate v0 and n" if through.narrow else ""
    return f"w0 = {show(through.w0, 'work')}, {rate.law_words(through.law)} ({errors}) between {low} and {high}{doubt}"

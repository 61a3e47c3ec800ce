"""The work of adhesion along measured curves as a table, as a summary, and in words."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion import Nonadhesive
from ..base import Array, Unknown, show
from ..beside import Analysis, adhesive
from ..data import saturation, some
from ..identification.rate.through import LawThrough, law_along
from ..identification.work import ABOVE, BELOW, NONE, OK, WorkAlong, typical
from ..series import Solution
from .rate import through_summary, through_words
from .result import SHOWN, Figure, Result
from .tables import stacked

FORMAT, VERSION = "jkr-work", 1  # type and version of the JSON
QUARTILES = (0.25, 0.5, 0.75)  # shares of the rows below each
MANY = 0.1  # of the rows: as many without a work of adhesion are worth a warning


@dataclass(frozen=True, eq=False)
class Work(Result):
    """The work of adhesion along the ``curves`` in the file at ``path`` on a ``body``; the ``law`` over the speed of
    the edge through them, where there is one, and why others were ``skipped``."""

    path: Path
    curves: Sequence[WorkAlong]
    skipped: Sequence[str]
    body: Analysis
    law: LawThrough | Unknown | None

    @classmethod
    def of(
        cls, path: Path, curves: list[WorkAlong], skipped: Sequence[str], solution: Solution, unit: Nonadhesive,
        modulus_factor: float,
    ) -> Work:  # fmt: skip
        """The ``curves`` on a ``solution`` with its functions ``unit``."""
        return cls(path, curves, skipped, adhesive(solution, unit, typical(curves), modulus_factor), law_along(curves))

    @cached_property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """All rows of all curves, a curve at a time; None where there is no value. Quantities that no curve has make
        no column, but for the error of w: that is empty where the noise is not known."""
        names = {name for item in self.curves for name, (values, _) in _numbers(item).items() if values is not None}
        names.add("w_err_J_per_m2")
        return stacked([_labels(item) | _cells(item, names) for item in self.curves])

    def summary(self) -> dict[str, Any]:
        """Per curve and for the body."""
        body = self.body
        return {
            "format": FORMAT,
            "version": VERSION,
            "file": str(self.path),
            "series": str(body.path),
            "title": body.solution.record.title,
            "modulus_factor": body.modulus_factor,
            "slopes": body.curve.slopes.method,
            "errors": body.budget.as_dict(),
            "curves": [curve_summary(item) for item in self.curves],
            "skipped": list(self.skipped),
            "warnings": self._body_warnings,
            "rate_law": through_summary(self.law),
        }

    def words(self) -> list[str]:
        lines = [line for item in self.curves[:SHOWN] for line in words(item)]
        if len(self.curves) > SHOWN:
            lines.append(f"  ... and {len(self.curves) - SHOWN} more curves")
        return lines + ([] if self.law is None else [f"  {through_words(self.law)}"])

    @property
    def warnings(self) -> list[str]:
        lines = [f"skipped: {line}" for line in some(list(self.skipped))]
        lines += [f"{item.curve.where}: {flag}" for item in self.curves[:SHOWN] for flag in flags(item)]
        return lines + [f"{self.path}: {warning}" for warning in self._body_warnings]

    @property
    def _body_warnings(self) -> list[str]:
        """What holds for every curve on this body: of its series, slopes and validity."""
        body = self.body
        return [*body.solution.warnings, *body.curve.slopes.flags, *body.validity.warnings]

    def figure(self) -> Figure:
        from .plots.work import work_figure

        return work_figure(self.curves, self.law if isinstance(self.law, LawThrough) else None)


def _labels(item: WorkAlong) -> dict[str, list[Any]]:
    """Curve, segment (may be empty) and state of each row."""
    curve, size = item.curve, len(item.curve)
    segments = [None] * size if curve.segment is None else curve.segment.tolist()
    return {"curve": [curve.name] * size, "segment": segments, "state": item.state.tolist()}


def _numbers(item: WorkAlong) -> dict[str, tuple[Array | None, Array]]:
    """The columns of numbers, each with the rows that have them."""
    curve, ok = item.curve, item.ok
    every = np.ones(ok.size, dtype=bool)
    timed = ~every if item.timed is None else item.timed
    return {
        "a_m": (curve.a, every) if "a" in item.used else (item.a, ok),
        "w_J_per_m2": (item.w, ok),
        "w_err_J_per_m2": (item.w_err, ok),
        "delta_m": (curve.delta, every),
        "P_N": (curve.P, every),
        "a_err_m": (item.a_err, ok),
        "t_s": (curve.t, every),
        "speed_m_per_s": (item.speed, timed),
        "speed_err_m_per_s": (item.speed_err, timed),
    }


def _cells(item: WorkAlong, names: AbstractSet[str]) -> dict[str, list[Any]]:
    """The columns that are called ``names``."""
    return {
        name: [None] * rows.size if values is None else np.where(rows, values, np.nan).tolist()
        for name, (values, rows) in _numbers(item).items()
        if name in names
    }


def curve_summary(item: WorkAlong) -> dict[str, Any]:
    """Counts, quartiles of w over all usable rows and by the sense of the edge's motion, where its speed is more than
    its error in as many rows as a speed is taken from, and what to mind."""
    groups = {"all": item.ok}
    if item.timed is not None and item.speed is not None:
        moving = item.timed if item.speed_err is None else item.timed & (np.abs(item.speed) > item.speed_err)
        senses = {"advancing": moving & (item.speed > 0), "receding": moving & (item.speed < 0)}
        groups |= {name: rows & (np.count_nonzero(rows) >= item.window) for name, rows in senses.items()}
    return {
        "curve": item.curve.name,
        "from": list(item.used),
        "rows": {word: int((item.state == word).sum()) for word in (OK, NONE, BELOW, ABOVE)},
        "w": {name: _spread(item, rows) for name, rows in groups.items()},
        "window": item.window or None,
        "flags": [*item.curve.flags, *flags(item)],
    }


def _spread(item: WorkAlong, rows: Array) -> dict[str, Any] | None:
    """Quartiles of w and the median of its error over some rows; None where there are none."""
    if not rows.any():
        return None
    low, middle, high = (float(value) for value in np.quantile(item.w[rows], QUARTILES))
    spread: dict[str, Any] = {"rows": int(rows.sum()), "median_J_per_m2": middle, "quartiles_J_per_m2": [low, high]}
    errors = {"err": item.w_err} | {f"err_by_{name}": share for name, share in item.shares.items()}
    spread |= {
        f"{name}_J_per_m2": None if values is None else float(np.median(values[rows]))
        for name, values in errors.items()
    }
    if item.speed is not None and item.timed is not None and (timed := rows & item.timed).any():
        spread["speed_m_per_s"] = [float(value) for value in np.quantile(item.speed[timed], (0, 1))]
    return spread


def flags(item: WorkAlong) -> list[str]:
    """What a reader of the numbers should know about one curve."""
    size = len(item.curve)
    lines = list(saturation(item.curve))
    ends = {BELOW: "begin the series at smaller radii", ABOVE: "increase [loading] radius"}
    for word, remedy in ends.items():
        if (count := int((item.state == word).sum())) > MANY * size:
            lines.append(f"{count} of {size} rows lie {word}: they have no w; {remedy}, or they are not in contact")
    if (count := int((item.state == NONE).sum())) > MANY * size:
        lines.append(
            f"{count} of {size} rows lie at or above the nonadhesive load: check zero points and modulus; if "
            "noise put them there, the w of the others is too large on average"
        )
    if item.w_err is not None and (unsure := int((item.w_err > item.w)[item.ok].sum())) > MANY * size:
        lines.append(f"at {unsure} of {size} rows the error of w is larger than w")
    if item.timed is not None and not item.timed.any():
        lines.append(f"no {item.window} usable rows follow one another with rising time: no speed")
    return lines


def words(item: WorkAlong) -> list[str]:
    """One curve: the work of adhesion along all rows, then of advancing and receding edges."""
    parts = [f"{int(item.ok.sum())} of {len(item.curve)} rows: {item.curve.where}"]
    for name, spread in curve_summary(item)["w"].items():
        if spread is None:
            continue
        low, high = (show(value, "work") for value in spread["quartiles_J_per_m2"])
        label = "w" if name == "all" else f"{name} w"
        error = f" ± {show(spread['err_J_per_m2'], 'work')}" if "err_by_noise_J_per_m2" in spread else ""
        parts.append(f"{label} = {show(spread['median_J_per_m2'], 'work')}{error} (half of the rows: {low} to {high})")
    unknown = ["no error of w: the noise is not known, give --noise"] if item.w_err is None else []
    return [", ".join([*parts[1:2], parts[0]]), *(f"    {part}" for part in (*parts[2:], *unknown, *item.curve.flags))]

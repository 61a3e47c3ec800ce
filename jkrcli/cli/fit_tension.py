"""``jkr fit --free surface_tension``: the tension, E*, w and zeros from records by tips of several radii together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import InputError, SolveError
from ..report.output import Files, Output
from .output import answer
from .voice import present, warn

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..identification.fit import FittedBody

TENSION = "surface_tension"


def is_asked(body: FittedBody, names: Sequence[str], fix: Sequence[tuple[str, str]]) -> bool:
    """Whether surface tension has a part in the fit."""
    return TENSION in names or TENSION in dict(fix) or body.problem.specimen.surface_tension > 0


def fit_tension(
    body: FittedBody, measured: Sequence[Path], radii: Sequence[float], reading: Reading, names: Sequence[str],
    fix: Sequence[tuple[str, str]], level: float, targets: Files, told: str, output: Output,
) -> None:  # fmt: skip
    """One fit of all curves in all files, its table and summary."""
    from ..data.measured import each
    from ..identification.tension import known_values, radii_of, tension_fit
    from ..report import tension_fit as report

    fixed = known_values(body.problem, names, fix)
    curves, tips = [], []
    for path, R in zip(measured, radii_of(body.problem, radii, len(measured)), strict=True):
        for item in each(path, replace(reading, contact="as-is")):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
            tips.append(R)
    try:
        found = tension_fit(body.problem, curves, tips, fixed, level)
    except SolveError as error:
        raise InputError(f"{measured[0]}: {error}") from None
    targets.write(report.columns(found), report.summary(found, told))
    if output.json:
        answer(report.summary(found, told))
    else:
        present(report.words(found, level), last=f"  written {targets}")
    for line in found.warnings:
        warn(line)

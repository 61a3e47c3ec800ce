"""``jkr fit --free surface_tension``: the tension, E*, w and zeros from records by tips of several radii together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..base import InputError, SolveError
from .fit_law import Asked
from .output import give

if TYPE_CHECKING:
    from ..identification.fit import FittedBody

TENSION = "surface_tension"


def is_asked(body: FittedBody, names: Sequence[str], fix: Sequence[tuple[str, str]]) -> bool:
    """Whether surface tension has a part in the fit."""
    return TENSION in names or TENSION in dict(fix) or body.problem.specimen.surface_tension > 0


def fit_tension(asked: Asked, radii: Sequence[float]) -> None:
    """One fit of all curves in all files, its table and summary."""
    from ..data.measured import each
    from ..identification.tension import known_values, radii_of, tension_fit
    from ..report.result import as_result
    from ..report.tension_fit import TensionFitted

    body, measured, options = asked.body, asked.measured, asked.options
    fixed = known_values(body.problem, asked.names, asked.fix)
    curves, tips = [], []
    for path, R in zip(measured, radii_of(body.problem, radii, len(measured)), strict=True):
        for item in each(path, replace(asked.reading, contact="as-is")):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
            tips.append(R)
    try:
        level = options["level"]
        found = as_result(
            TensionFitted, tension_fit(body.problem, curves, tips, fixed, level), body=asked.told, level=level
        )
    except SolveError as error:
        raise InputError(f"{measured[0]}: {error}") from None
    asked.targets.write(found.columns, found.summary())
    give(found, asked.output, f"  written {asked.targets}")

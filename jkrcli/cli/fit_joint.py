"""``jkr fit --shared``: what all records have in common, from all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import InputError, SolveError
from ..report.output import Files, Output
from .output import answer
from .voice import say, warn

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..identification.fit import FittedBody, Settings


def fit_joint(
    body: FittedBody, measured: Sequence[Path], radii: Sequence[float], reading: Reading, settings: Settings,
    shared: Sequence[str], own: Sequence[str], targets: Files, told: str, output: Output,
) -> None:  # fmt: skip
    """One fit of all curves in all files, its table, summary and picture."""
    from ..base.threads import one_thread
    from ..data.measured import each
    from ..identification.fit.joint import joint_fit, shared_of, with_radii
    from ..report import joint_fit as report

    names, curves, bodies = shared_of(shared, own, settings), [], []
    for path, one in zip(measured, with_radii(body, radii, len(measured)), strict=True):
        for item in each(path, replace(reading, contact="as-is")):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
            bodies.append(one)
    try:
        with one_thread():
            found = joint_fit(bodies, curves, settings, names)
    except SolveError as error:
        raise InputError(f"{measured[0]}: {error}") from None
    figure = None
    if output.plots:
        from ..report.plots.joint import joint_figure

        figure = joint_figure(found)
    targets.write(report.columns(found), report.summary(found, told), figure)
    if output.json:
        answer(report.summary(found, told))
    else:
        say("\n".join(report.words(found, settings.level)))
        say(f"written {targets}")
    for line in (*found.warnings, *(f"{one.where}: {line}" for one in found.fits for line in one.warnings)):
        warn(line)

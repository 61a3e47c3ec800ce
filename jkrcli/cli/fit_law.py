"""``jkr fit --law``: w0, the law's parameters, E* and zeros from records at one or several speeds together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import InputError, SolveError
from ..report.output import Files, Output
from .output import answer
from .voice import present, warn

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..identification.fit import FittedBody


def fit_law(
    body: FittedBody, law: str, measured: Sequence[Path], reading: Reading, names: Sequence[str],
    fix: Sequence[tuple[str, str]], start: Sequence[tuple[str, str]], options: dict[str, Any], targets: Files,
    told: str, output: Output,
) -> None:  # fmt: skip
    """One fit of all curves in all files, its table, summary and picture."""
    from ..base.threads import one_thread
    from ..data.measured import each
    from ..identification.rate.fitting import rate_fit, rate_settings
    from ..report import rate_fit as report

    settings = rate_settings(body, law, names, fix, start, level=options["level"], segment=options["segment"])
    curves = []
    for path in measured:
        for item in each(path, reading):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
    try:
        with one_thread():
            found = rate_fit(body, curves, settings)
    except SolveError as error:
        raise InputError(f"{measured[0]}: {error}") from None
    figure = None
    if output.plots:
        from ..report.plots.rate import rate_fit_figure

        figure = rate_fit_figure(found)
    targets.write(report.columns(found), report.summary(found, told), figure)
    if output.json:
        answer(report.summary(found, told))
    else:
        present(report.words(found), last=f"  written {targets}")
    for line in found.warnings:
        warn(line)

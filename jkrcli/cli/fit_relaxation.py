"""``jkr fit --relaxation``: the modulus, a law of relaxation and zeros from records over time, each for itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import InputError
from ..report.output import Files, Output
from .output import answer
from .voice import present, warn

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..identification.fit import FittedBody


def fit_relaxation(
    body: FittedBody, law: str, measured: Sequence[Path], reading: Reading, names: Sequence[str],
    fix: Sequence[tuple[str, str]], options: dict[str, Any], targets: Files, told: str, output: Output,
) -> None:  # fmt: skip
    """A fit of each curve in all files, their table, summary and picture; curves that cannot be used are skipped and
    said."""
    from ..base.threads import one_thread
    from ..data.measured import each
    from ..data.text_table import some
    from ..identification.relaxation import relaxation_fit, relaxation_settings
    from ..report import relaxation_fit as report

    terms = {} if options["terms"] is None else {"terms": options["terms"]}
    E_star = body.problem.E_star
    settings = relaxation_settings(law, fix, names, E_star, level=options["level"], **terms)
    found, skipped = [], list[str]()
    for path in measured:
        for item in each(path, reading):
            try:
                if isinstance(item, InputError):
                    raise item
                curve = item if options["segment"] in (None, "both") else item.only(options["segment"])
                with one_thread():
                    found.append(relaxation_fit(body, curve, settings))
            except InputError as error:
                skipped += error.lines
    if not found:
        raise InputError(some(skipped))
    figure = None
    if output.plots:
        from ..report.plots.relaxation import relaxation_fit_figure

        figure = relaxation_fit_figure(found)
    targets.write(report.columns(found), report.summary(found, told), figure)
    for line in skipped:
        warn(f"skipped: {line}")
    if output.json:
        answer(report.summary(found, told))
    else:
        present(*map(report.words, found), last=f"  written {targets}")
    for fit in found:
        for line in fit.warnings:
            warn(f"{fit.record.curve.where}: {line}")

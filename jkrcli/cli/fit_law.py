"""``jkr fit --law``: w0, the law's parameters, E* and zeros from records at one or several speeds together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base import InputError, SolveError
from ..report.output import Files, Output
from .output import give

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..identification.fit import FittedBody


@dataclass(frozen=True, eq=False)
class Asked:
    """What is fitted to what, how the files are read, and where it goes; ``told``: the ``body`` in words; ``options``:
    all the others by name."""

    body: FittedBody
    measured: Sequence[Path]
    reading: Reading
    names: Sequence[str]
    fix: Sequence[tuple[str, str]]
    start: Sequence[tuple[str, str]]
    options: dict[str, Any]
    targets: Files
    told: str
    output: Output


def fit_law(asked: Asked, law: str) -> None:
    """One fit of all curves in all files, its table, summary and picture."""
    from ..base import one_thread
    from ..data.measured import each
    from ..identification.rate.fitting import rate_fit, rate_settings
    from ..report.rate_fit import LawFit
    from ..report.result import as_result

    body, options, targets = asked.body, asked.options, asked.targets
    settings = rate_settings(
        body, law, asked.names, asked.fix, asked.start, level=options["level"], segment=options["segment"]
    )
    curves = []
    for path in asked.measured:
        for item in each(path, asked.reading):
            if isinstance(item, InputError):
                raise item
            curves.append(item)
    try:
        with one_thread():
            found = as_result(LawFit, rate_fit(body, curves, settings), body=asked.told)
    except SolveError as error:
        raise InputError(f"{asked.measured[0]}: {error}") from None
    targets.write(found.columns, found.summary(), targets.draw(found.figure))
    give(found, asked.output, f"  written {targets}")

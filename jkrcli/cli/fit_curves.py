"""``jkr fit`` of curves one by one: their table, summary, archive and pictures."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TypeAlias

from .. import data, report
from ..base import InputError, beside, executor, together
from ..identification import fit as fits
from ..methods import Forecast, Limits
from ..report import PICTURES, SHOWN
from .fit_together import FitRequest
from .measured import TUNING
from .options import Parallel, begin
from .voice import give, note, progress, say, warn

Outcome: TypeAlias = "fits.Fit | fits.Failure"
Pictures: TypeAlias = "list[tuple[Outcome, report.Files]]"
FEWER = "fewer rows, curves or samples"


def refits_of(confidence: str, samples: int, uncertain: int) -> int:
    """How often a curve is fitted anew for its intervals, and for as many ``uncertain`` inputs."""
    anew = {"covariance": 0, "profile": TUNING.profiled, "bootstrap": samples}
    return anew[confidence] + TUNING.carried * uncertain


def fit_curves(
    request: FitRequest, bodies: list[fits.FittedBody], settings: fits.Settings, refits: int, limits: Limits,
    parallel: Parallel,
) -> None:  # fmt: skip
    """Each curve on each of the ``bodies``, which are one under different surfaces: table, archive and pictures."""
    from ..identification.fit.friction import friction_warnings, preferences

    output = request.output
    curves, reasons = data.usable(request.measured, request.reading)
    each_curve = (TUNING.fit_per_curve + refits * (TUNING.refit + TUNING.refit_per_row * len(one)) for one in curves)
    seconds = sum(each_curve)
    begin(f"fit of {len(curves):,} curves", Forecast(len(bodies) * seconds, 0.0, 0.0), limits, FEWER)
    each = []
    for one in bodies:
        with executor(*parallel, progress, seconds) as pool:
            each.append(fits.fit_all(one, curves, settings, pool))
    outcomes = [item for items in each for item in items]
    if request.options["rivals"] and not any(isinstance(item, fits.Fit) and item.verdict for item in outcomes):
        raise InputError("fit: --rivals is for raw records, which none of these was fitted as: leave it out")
    if request.options["plan"]:
        outcomes = [fits.planned(one, item) if isinstance(item, fits.Fit) else item
                 for one, items in zip(bodies, each, strict=True) for item in items]  # fmt: skip
    reasons += [line for item in each[0] if isinstance(item, fits.Failure) for line in item.lines]
    pictures = _pictures(request, each, bodies) if output.plots else []
    preferred = list(preferences(outcomes)) if len(bodies) > 1 else []
    friction = [] if len(bodies) > 1 else list(friction_warnings(request.body, outcomes))
    result = report.Fits(outcomes, request.body_words, friction)
    map_file = _write(request, result, reasons, pictures)
    for line in reasons:
        warn(f"skipped: {line}")
    drawn = f", {len(pictures)} picture{'s' if len(pictures) > 1 else ''}" if pictures else ""
    more = f" ({len(result.fits) - SHOWN:,} more curves)" if len(result.fits) > SHOWN else ""
    scan = f", the map in {map_file}" if map_file else ""
    give(result, output.json, f"  written {request.targets}{drawn}{scan}{more}")
    for item in result.fits[:SHOWN] if not output.json else []:
        if lines := [*(report.rivals_table(item) if request.options["rivals"] else []), *report.plan_table(item)]:
            say("\n".join(lines))
    for line in preferred:
        (note if output.json else say)(line)


def _write(request: FitRequest, result: report.Fits, reasons: list[str], pictures: Pictures) -> report.Files | None:
    """Write table, summary, archive and pictures; the files of the map, if there is one. InputError, when all that can
    be written is, where no curve could be used."""
    from ..report import fit_archive
    from ..report import map as scans

    if not result.outcomes:
        raise InputError(data.some(reasons))
    targets, output, summary = request.targets, request.output, result.summary()
    scan = scans.map_of(result.outcomes) if output.plots else None
    of_map = None if scan is None else output.files(Path(f"{targets.stem}-map"), PICTURES, request.inputs)
    with together():
        targets.write(result.columns, summary)
        fit_archive.write(targets[".h5"], result.outcomes, summary)
        if pictures:
            _draw(pictures)
        if scan is not None and of_map is not None:
            from ..report.plots.map import map_figure

            of_map.write(figure=map_figure(scan))
    if not result.fits:
        raise InputError(data.some(reasons))
    return of_map


def _pictures(request: FitRequest, each: list[list[Outcome]], bodies: list[fits.FittedBody]) -> Pictures:
    """Curves to draw, fitted or not, each with its files, named after its file, itself where it is not alone, and, of
    several, the surface; none where they are many."""
    named: list[tuple[Outcome, str]] = []
    for items, body in zip(each, bodies, strict=True):
        shown = [item for item in items if isinstance(item, fits.Fit) or {"delta", "P"} <= set(item.curve.measured)]
        for item in shown if len(shown) <= SHOWN else []:
            file, name = (item.file, item.name) if isinstance(item, fits.Fit) else (item.curve.origin, item.curve.name)
            words = [Path(file or "").stem, *[name] * (len(shown) > 1), *[body.problem.surface] * (len(bodies) > 1)]
            named.append((item, "-".join(words)))
    stems = beside(request.targets.stem, [name for _, name in named])
    return [(item, request.output.files(stem, PICTURES, request.inputs))
            for (item, _), stem in zip(named, stems, strict=True)]  # fmt: skip


def _draw(drawn: Pictures) -> None:
    """The fitted curve over its data; of a curve that could not be fitted its record, if it can be taken apart."""
    from ..report.plots.fit import fit_figure
    from ..report.plots.segments import record_figure

    for item, target in drawn:
        if not isinstance(item, fits.Failure):
            target.write(figure=fit_figure(item))
            continue
        with contextlib.suppress(InputError):
            target.write(figure=record_figure([data.examine(item.curve)]))

"""``jkr fit`` of curves one by one: their table, summary, archive and pictures."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from ..base import InputError, beside, together
from ..methods import Forecast, Limits
from ..report import PICTURES, SHOWN, Files, Output
from .fit_together import Asked
from .measured import TUNING
from .options import begin
from .output import give
from .voice import note, progress, say, warn

if TYPE_CHECKING:
    from ..identification.fit import Failure, Fit, FittedBody, Settings
    from ..report import Fits

    Pictures = list[tuple[Fit | Failure, Files]]

FEWER = "fewer rows, curves or samples"


def refits_of(confidence: str, samples: int, uncertain: int) -> int:
    """How often a curve is fitted anew for its intervals, and for as many ``uncertain`` inputs."""
    fits = {"covariance": 0, "profile": TUNING.profiled, "bootstrap": samples}
    return fits[confidence] + TUNING.carried * uncertain


def fit_curves(
    asked: Asked, bodies: list[FittedBody], settings: Settings, refits: int, inputs: tuple[Path, ...], limits: Limits,
    parallel: tuple[int | None, str | None],
) -> None:  # fmt: skip
    """Each curve on each of the ``bodies``, which are one under different surfaces: table, archive and pictures."""
    from ..base import executor
    from ..data import usable
    from ..identification.fit import Failure, Fit, fit_all, planned
    from ..identification.fit.friction import friction_warnings, preferences
    from ..report import Fits, plan_table, rivals_table

    targets, output = asked.targets, asked.output
    curves, reasons = usable(asked.measured, asked.reading)
    each_curve = (TUNING.fit_per_curve + refits * (TUNING.refit + TUNING.refit_per_row * len(one)) for one in curves)
    seconds = sum(each_curve)
    begin(f"fit of {len(curves):,} curves", Forecast(len(bodies) * seconds, 0.0, 0.0), limits, FEWER)
    each = []
    for one in bodies:
        with executor(*parallel, progress, seconds) as pool:
            each.append(fit_all(one, curves, settings, pool))
    found = [item for items in each for item in items]
    if asked.options["rivals"] and not any(isinstance(item, Fit) and item.verdict for item in found):
        raise InputError("fit: --rivals is for raw records, which none of these was fitted as: leave it out")
    if asked.options["plan"]:
        found = [planned(one, item) if isinstance(item, Fit) else item
                 for one, items in zip(bodies, each, strict=True) for item in items]  # fmt: skip
    reasons += [line for item in each[0] if isinstance(item, Failure) for line in item.lines]
    pictures = _pictures(each, bodies, targets, inputs, output) if output.plots else []
    told = list(preferences(found)) if len(bodies) > 1 else []
    friction = [] if len(bodies) > 1 else list(friction_warnings(asked.body, found))
    result = Fits(found, asked.told, friction)
    map_file = _write(result, reasons, targets, pictures, output, inputs)
    for line in reasons:
        warn(f"skipped: {line}")
    drawn = f", {len(pictures)} picture{'s' if len(pictures) > 1 else ''}" if pictures else ""
    more = f" ({len(result.fits) - SHOWN:,} more curves)" if len(result.fits) > SHOWN else ""
    give(result, output.json, f"  written {targets}{drawn}{f', the map in {map_file}' if map_file else ''}{more}")
    for item in result.fits[:SHOWN] if not output.json else []:
        if lines := [*(rivals_table(item) if asked.options["rivals"] else []), *plan_table(item)]:
            say("\n".join(lines))
    for line in told:
        (note if output.json else say)(line)


def _write(
    result: Fits, reasons: list[str], targets: Files, pictures: Pictures, output: Output, inputs: tuple[Path, ...]
) -> Files | None:
    """Write table, summary, archive and pictures; the files of the map, if there is one. InputError, when all that can
    be written is, where no curve could be used."""
    from ..data import some
    from ..report.fit_archive import write
    from ..report.map import map_of

    if not result.found:
        raise InputError(some(reasons))
    held = map_of(result.found) if output.plots else None
    of_map = None if held is None else output.files(Path(f"{targets.stem}-map"), PICTURES, inputs)
    told = result.summary()
    with together():
        targets.write(result.columns, told)
        write(targets[".h5"], result.found, told)
        if pictures:
            _draw(pictures)
        if held is not None and of_map is not None:
            from ..report.plots.map import map_figure

            of_map.write(figure=map_figure(held))
    if not result.fits:
        raise InputError(some(reasons))
    return of_map


def _pictures(
    each: list[list[Fit | Failure]], bodies: list[FittedBody], targets: Files,
    inputs: tuple[Path, ...], output: Output,
) -> Pictures:  # fmt: skip
    """Curves to draw, fitted or not, each with its files, named after the curve and, of several, the surface."""
    named = [
        (item, name if len(bodies) == 1 else f"{name}-{body.problem.surface}")
        for items, body in zip(each, bodies, strict=True)
        for item, name in _named(items)
    ]
    stems = beside(targets.stem, [name for _, name in named])
    return [(item, output.files(stem, PICTURES, inputs)) for (item, _), stem in zip(named, stems, strict=True)]


def _named(found: list[Fit | Failure]) -> list[tuple[Fit | Failure, str]]:
    """Curves that can be drawn, each with what its pictures are called after; none where they are many."""
    from ..identification.fit import Failure

    drawable = [
        item for item in found if not (isinstance(item, Failure) and (item.curve.delta is None or item.curve.P is None))
    ]
    if len(drawable) > SHOWN:
        return []
    held = [(str(item.curve.origin or ""), item.curve.name) if isinstance(item, Failure) else (item.file, item.name)
            for item in drawable]  # fmt: skip
    names = [Path(file).stem if len(held) == 1 else f"{Path(file).stem}-{name}" for file, name in held]
    return list(zip(drawable, names, strict=True))


def _draw(drawn: Pictures) -> None:
    """The fitted curve over its data; of a curve that could not be fitted its record, if it can be taken apart."""
    from ..data import examine
    from ..identification.fit import Failure
    from ..report.plots.fit import fit_figure
    from ..report.plots.segments import record_figure

    for item, target in drawn:
        if not isinstance(item, Failure):
            target.write(figure=fit_figure(item))
            continue
        with contextlib.suppress(InputError):
            target.write(figure=record_figure([examine(item.curve)]))

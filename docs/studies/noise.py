"""The noise study, what noise in the data does to the adhesive curve: its command, table and picture."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from operator import attrgetter
from typing import Any, TypeGuard

import numpy as np

from jkrcli.report.plots import BLUE, GREEN, NARROW, ORANGE, WIDE, Axes, Figure, drawing, legend_below
from jkrcli.report.result import PICTURES

from .command import call, output_of, parser_of, pool_of
from .noise_cells import BODIES, METHODS, NOISE, POINTS, NoiseCell, noise_study


def main(words: Sequence[str] | None = None) -> int:
    """Error of the pull-off force, and coverage of the 95 % band, over noise, points, bodies and slopes.

    Independent relative Gaussian noise on contact radius, displacement and load of exact series.
    Writes noise-study.csv, and of each body noise-<body>.png and .svg; 20 seeds take about twenty minutes.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--seeds", type=int, default=20, help="runs per cell [default: 20]")
    names = [body.name for body in BODIES]
    parser.add_argument("--body", action="append", choices=names, help="only these")
    parser.add_argument("--points", action="append", type=int, help=f"of a series [default: {POINTS}]")
    given = parser.parse_args(words)
    output = output_of(given)
    files = output.files(given.output / "noise-study", (".csv",))
    chosen, points = [body for body in BODIES if body.name in (given.body or names)], given.points or POINTS
    drawn = chosen if output.plots else []
    pictures = {body.name: output.files(given.output / f"noise-{body.name}", PICTURES) for body in drawn}
    runs = given.seeds * len(chosen) * len(points) * len(NOISE) * len(METHODS)
    with pool_of(given, 0.1 * runs) as pool:
        cells = noise_study(chosen, points, NOISE, METHODS, given.seeds, pool)
    columns = {item.name: [getattr(cell, item.name) for cell in cells] for item in fields(NoiseCell)}
    files.write(columns)
    for body, picture in pictures.items():
        picture.write(figure=picture.draw(partial(noise_figure, cells, body)))
    _print(cells)
    print(f"  written {files}" + "".join(f", {picture}" for picture in pictures.values()))
    return 0


def _known(value: float | None) -> TypeGuard[float]:
    """Whether there is a figure: not for a band that a method lacks, nor for errors where every run failed."""
    return value is not None and value != math.inf


def _print(cells: Sequence[NoiseCell]) -> None:
    print(f"  {'body':<14}{'points':>7}{'noise':>8} {'slopes':<9}{'median':>9}{'worst':>9}{'band':>7}{'failed':>8}")
    for cell in cells:
        band = "" if cell.band is None else f"{cell.band:.0%}"
        median, worst = (f"{error:.1e}" if _known(error) else "-" for error in (cell.median, cell.worst))
        print(
            f"  {cell.body:<14}{cell.points:>7}{cell.noise:>8g} {cell.method:<9}{median:>9}{worst:>9}"
            f"{band:>7}{cell.failures:>8.0%}"
        )


# ---------------------------------------------------------------------- the picture
WAYS = {"integral": (ORANGE, "o-"), "loocv": (BLUE, "s--"), "gcv": (GREEN, "^:")}
NONE, FLOOR = 1e-6, 1e-7  # places on the axes of no noise, and of no error
TICKS = {NONE: "none", 1e-5: "10⁻⁵", 1e-4: "10⁻⁴", 1e-3: "10⁻³", 1e-2: "10⁻²"}


def noise_figure(cells: Sequence[NoiseCell], body: str) -> Figure:
    """How the pull-off force of a ``body`` errs over noise, a column per number of rows: median error above, share of
    runs whose 95 % band holds the truth, and share of runs without a result below."""
    mine = [cell for cell in cells if cell.body == body]
    sizes = sorted({cell.points for cell in mine})
    with drawing(WIDE if len(sizes) > 1 else NARROW, 5.4) as figure:
        axes = figure.subplots(3, len(sizes), sharex=True, sharey="row", squeeze=False, height_ratios=(2, 1, 1))
        for column, points in enumerate(sizes):
            _panels(list(axes[:, column]), [cell for cell in mine if cell.points == points])
            axes[0, column].set_title(f"{points} rows")
            axes[2, column].set_xlabel("relative noise of a, δ, P")
        for place, label in zip(axes[:, 0], ("median error", "band holds", "no result"), strict=True):
            place.set_ylabel(label)
        legend_below(figure, axes[:1, 0], 3)
        return figure


def _panels(axes: Sequence[Axes], cells: Sequence[NoiseCell]) -> None:
    for method, (color, style) in WAYS.items():
        line = sorted((cell for cell in cells if cell.method == method), key=attrgetter("noise"))
        look = {"color": color, "ms": 4, "mfc": "none", "label": method}

        def draw(place: Axes, values: Sequence[float | None], line: Sequence[NoiseCell] = line, style: str = style,
                 look: dict[str, Any] = look) -> None:  # fmt: skip
            pairs = [(max(cell.noise, NONE), value) for cell, value in zip(line, values, strict=True) if _known(value)]
            place.plot(*np.transpose(pairs) if pairs else ((), ()), style, **look)

        draw(axes[0], [max(cell.median, FLOOR) if _known(cell.median) else None for cell in line])
        draw(axes[1], [cell.coverage for cell in line])
        draw(axes[2], [cell.failures for cell in line])
    axes[0].set(xscale="log", yscale="log", ylim=(FLOOR, 1.0))
    axes[0].axhspan(1e-2, 1.0, color="0.95", zorder=0)
    axes[1].axhline(0.9, color="0.7", lw=1)
    for place in axes[1:]:
        place.set_ylim(-0.04, 1.04)
    axes[2].set_xticks(list(TICKS), list(TICKS.values()))
    axes[2].minorticks_off()


if __name__ == "__main__":
    sys.exit(call(main))

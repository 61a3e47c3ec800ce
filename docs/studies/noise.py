"""The noise study, what noise in the data does to the adhesive curve: its command, table and picture."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from jkrcli.report import PICTURES
from jkrcli.report.plots import Figure, drawing, legend_below
from jkrcli.report.plots.looks import BLUE, NARROW, ORANGE, WIDE

from .command import call, output_of, parser_of, pool_of
from .noise_cells import BODIES, METHODS, NOISE, POINTS, NoiseCell, noise_study


def main(words: Sequence[str] | None = None) -> int:
    """Error of the pull-off force, and coverage of the 90 % band, over noise, points, bodies and slopes.

    Independent relative Gaussian noise on contact radius, displacement and load of exact series.
    Writes noise-study.csv, .png and .svg; 200 seeds take about twenty minutes.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--seeds", type=int, default=200, help="runs per cell [default: 200]")
    names = [body.name for body in BODIES]
    parser.add_argument("--body", action="append", choices=names, help="only these")
    parser.add_argument("--points", action="append", type=int, help=f"of a series [default: {POINTS}]")
    given = parser.parse_args(words)
    files = output_of(given).files(given.output / "noise-study", (".csv", *PICTURES))
    chosen, points = [body for body in BODIES if body.name in (given.body or names)], given.points or POINTS
    runs = given.seeds * len(chosen) * len(points) * len(NOISE) * len(METHODS)
    with pool_of(given, 0.1 * runs) as pool:
        cells = noise_study(chosen, points, NOISE, METHODS, given.seeds, pool)
    columns = {item.name: [getattr(cell, item.name) for cell in cells] for item in fields(NoiseCell)}
    files.write(columns, figure=files.draw(lambda: noise_figure(cells)))
    _print(cells)
    print(f"  written {files}")
    return 0


def _known(value: object) -> bool:
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
WAYS = {"integral": (ORANGE, "o-"), "loocv": (BLUE, "s--")}
SHADES = {0: 0.35, 1: 0.65, 2: 1.0}
TICKS = {1e-6: "none", 1e-4: "10⁻⁴", 1e-2: "10⁻²"}


def noise_figure(cells: Sequence[NoiseCell]) -> Figure:
    """One column per body: median error of the pull-off force above, pointwise coverage of the 90 % band below."""
    bodies = list(dict.fromkeys(cell.body for cell in cells))
    with drawing(WIDE if len(bodies) > 1 else NARROW, 4.6) as figure:
        axes = figure.subplots(2, len(bodies), sharex=True, sharey="row", squeeze=False)
        for column, body in enumerate(bodies):
            _panel(axes[:, column], [cell for cell in cells if cell.body == body])
            axes[0, column].set_title(body)
            axes[1, column].set_xlabel("relative noise")
        axes[0, 0].set_ylabel("median error\nof the pull-off force")
        axes[1, 0].set_ylabel("coverage\nof the 90 % band")
        legend_below(figure, axes[:1, 0], 3 if len(bodies) > 1 else 2)
        return figure


def _panel(axes: np.ndarray, cells: Sequence[NoiseCell]) -> None:
    floor = min(TICKS)  # of the errors drawn, and the place of "no noise" on the axis
    sizes = sorted({cell.points for cell in cells})
    for method, (color, style) in WAYS.items():
        for rank, points in enumerate(sizes):
            line = [cell for cell in cells if cell.method == method and cell.points == points]
            known = [cell for cell in line if np.isfinite(cell.median)]
            noise = [max(cell.noise, floor) for cell in known]
            look = {"color": color, "alpha": SHADES.get(rank, 1.0), "ms": 3, "label": f"{method}, {points} points"}
            axes[0].loglog(noise, [max(cell.median, floor) for cell in known], style, **look)
            banded = [cell for cell in line if cell.band is not None and cell.noise > 0]
            axes[1].semilogx([cell.noise for cell in banded], [cell.band for cell in banded], style, **look)
    axes[1].axhspan(0.8, 0.97, color="0.9", zorder=0)
    axes[1].set_ylim(0, 1.02)
    axes[1].set_xticks(list(TICKS), list(TICKS.values()))
    axes[1].minorticks_off()


if __name__ == "__main__":
    sys.exit(call(main))

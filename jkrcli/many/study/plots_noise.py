"""The picture of the noise study: error of the pull-off force over the noise, and the coverage of the band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...report.plots import BLUE, NARROW, ORANGE, WIDE, Figure, drawing, legend_below
from .noise import Cell

WAYS = {"integral": (ORANGE, "o-"), "loocv": (BLUE, "s--")}
SHADES = {0: 0.35, 1: 0.65, 2: 1.0}
TICKS = {1e-6: "none", 1e-4: "10⁻⁴", 1e-2: "10⁻²"}
FLOOR = 1e-6  # of the errors drawn, and the place of "no noise" on the axis


def noise_figure(cells: Sequence[Cell]) -> Figure:
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


def _panel(axes: np.ndarray, cells: Sequence[Cell]) -> None:
    sizes = sorted({cell.points for cell in cells})
    for method, (color, style) in WAYS.items():
        for rank, points in enumerate(sizes):
            line = [cell for cell in cells if cell.method == method and cell.points == points]
            known = [cell for cell in line if np.isfinite(cell.median)]
            noise = [max(cell.noise, FLOOR) for cell in known]
            look = {"color": color, "alpha": SHADES.get(rank, 1.0), "ms": 3, "label": f"{method}, {points} points"}
            axes[0].loglog(noise, [max(cell.median, FLOOR) for cell in known], style, **look)
            banded = [cell for cell in line if cell.band is not None and cell.noise > 0]
            axes[1].semilogx([cell.noise for cell in banded], [cell.band for cell in banded], style, **look)
    axes[1].axhspan(0.8, 0.97, color="0.9", zorder=0)
    axes[1].set_ylim(0, 1.02)
    axes[1].set_xticks(list(TICKS), list(TICKS.values()))
    axes[1].minorticks_off()

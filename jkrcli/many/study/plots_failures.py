"""The failure map: for every pair of axes where a method was right, said that it was not, or erred silently."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...report.plots import BLACK, BLUE, GREEN, ORANGE, PURPLE, Axes, Figure, drawing
from .failures import CRASHED, REFUSED, RIGHT, SAID, SILENT, TOO_SLOW, UNJUDGED, Verdict
from .failures_cells import AXES, BODIES, SHAPES

LOOKS = {  # colour, marker, size: the rarer and worse the larger
    RIGHT: (GREEN, ".", 3),
    SAID: (BLUE, "+", 4),
    REFUSED: (ORANGE, "x", 3.5),
    UNJUDGED: ("0.7", ".", 3),
    TOO_SLOW: (PURPLE, "v", 4),
    SILENT: (BLACK, "s", 5),
    CRASHED: (BLACK, "D", 5),
}
WORDS = {
    "shape": "indenter", "body": "body", "nu": "ν", "a_over_h": "a/h", "contrast": "E below / E on top",
    "points": "points", "nodes": "nodes in contact", "increments": "increments (0: nested)", "noise": "noise",
    "length_unit": "unit of length (m)", "force_unit": "unit of force (N)",
}  # fmt: skip
COMMON = ("nu", "a_over_h", "contrast", "points", "shape", "body", "length_unit", "force_unit")
RELEVANT = {"fem": ("nodes", "increments", *COMMON), "slopes": ("noise", *COMMON)}
CATEGORIES = {"shape": SHAPES, "body": BODIES}
PANEL = 1.25  # inch
SMALL = {"font.size": 7, "xtick.labelsize": 6, "ytick.labelsize": 6, "axes.grid": False}
SPACING = {"left": 0.09, "right": 0.99, "bottom": 0.09, "top": 0.99, "hspace": 0.12, "wspace": 0.12}
LEAST = {"increments": 1.0, "noise": 1e-7}  # where none stands on a logarithmic axis


def failures_figure(verdicts: Sequence[Verdict], method: str) -> Figure:
    """A triangle of panels, one for every pair of the axes that matter to ``method``."""
    mine = [verdict for verdict in verdicts if verdict.cell.method == method]
    names = RELEVANT.get(method, COMMON)
    n = len(names) - 1
    with drawing(PANEL * n + 0.8, PANEL * n + 0.8, SMALL, layout=None) as figure:
        axes = figure.subplots(n, n, squeeze=False, gridspec_kw=SPACING)
        for (row, below), (column, beside) in itertools.product(enumerate(names[1:]), enumerate(names[:-1])):
            if column > row:
                axes[row, column].remove()
                continue
            _draw(axes[row, column], mine, beside, below)
            axes[row, column].label_outer()
        figure.align_labels()
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="upper right", fontsize=9, title_fontsize=9, title=f"{method}, {len(mine)} cells"
        )
        return figure


def _draw(axes: Axes, verdicts: Sequence[Verdict], x: str, y: str) -> None:
    for outcome, (color, marker, size) in LOOKS.items():
        cells = [verdict.cell for verdict in verdicts if verdict.outcome == outcome]
        if cells:
            label = f"{outcome}: {len(cells)}"
            axes.plot([_place(cell, x) for cell in cells], [_place(cell, y) for cell in cells], marker, color=color,
                      ms=size, mew=0.8, alpha=0.8, label=label)  # fmt: skip
    axes.set(xlabel=WORDS[x], ylabel=WORDS[y])
    for name, axis, scale in ((x, axes.xaxis, axes.set_xscale), (y, axes.yaxis, axes.set_yscale)):
        if name in CATEGORIES:
            axis.set_ticks(np.arange(len(CATEGORIES[name])), CATEGORIES[name])
        elif name in AXES:
            scale("log")
    axes.tick_params(axis="x", rotation=90)


def _place(cell: object, name: str) -> float:
    value = getattr(cell, name)
    return CATEGORIES[name].index(value) if name in CATEGORIES else max(value, LEAST.get(name, value))

"""Figures of what a device records, and of the pull-off map."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...series import Array
from . import BLACK, BLUE, COLORS, GREEN, MIDDLE, ORANGE, STYLE, WIDE, legend_below, scaled

PHASES = {"approach": (BLUE, 2.4), "turn": (GREEN, 1.8), "retraction": (ORANGE, 1.1)}  # the last drawn the thinnest
LIMITS = {1.5: "thick: 3/2", 2.0: "thin, compressible: 2", 3.0: "thin, incompressible: 3"}


def cycle_figure(columns: Mapping[str, Array], title: str) -> Figure:
    """Load and contact radius over what the device controls (the displacement under load control), jumps dotted.

    ``columns``: as ``stability.trace`` gives them, with "phase" and "part".
    """
    over = "device_m" if "device_m" in columns else "delta_m"
    soft = not np.array_equal(columns[over], columns["delta_m"])
    name = "device position δ + P/k" if soft else "displacement δ"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDE, 3.4), layout="constrained")
        panels = figure.subplots(1, 2)
        x, x_unit = scaled(columns[over], "length")
        for axes, column, dimension, label in (
            (panels[0], "P_N", "load", "load P"),
            (panels[1], "a_m", "length", "contact radius a"),
        ):
            y, y_unit = scaled(columns[column], dimension)
            _phases(axes, x, y, columns)
            axes.axhline(0, color="0.7", lw=0.6, zorder=0)
            axes.set_xlabel(f"{name} ({x_unit})")
            axes.set_ylabel(f"{label} ({y_unit})")
        legend_below(figure, panels, 4)
        figure.suptitle(title)
        return figure


def map_figure(columns: Mapping[str, Array]) -> Figure:
    """The pull-off map: -P_min/(pi w R) over w R^2/(E* h^3), one line per Poisson's ratio, with its limits."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(MIDDLE, 3.4), layout="constrained")
        axes = figure.subplots()
        q, force = columns["w_R2_over_Estar_h3"], columns["minus_P_over_pi_w_R"]
        for value, words in LIMITS.items():
            axes.axhline(value, color="0.6", lw=0.8, ls="--")
            axes.annotate(words, (0.99, value), xycoords=("axes fraction", "data"), ha="right", va="bottom", size=8,
                          color="0.4")  # fmt: skip
        for i, nu in enumerate(dict.fromkeys(columns["nu"].tolist())):
            rows = columns["nu"] == nu
            axes.semilogx(q[rows], force[rows], ".-", color=COLORS[i % len(COLORS)], ms=4, label=f"ν = {nu:g}")
        axes.set_xlabel("w R² / (E* h³)")
        axes.set_ylabel("pull-off force / (π w R)")
        axes.set_ylim(1.4, 3.15)
        axes.set_title(f"layer on a rigid base, {columns['base'][0]}")
        legend_below(figure, [axes], 4)
        return figure


def _phases(axes: Axes, x: Array, y: Array, columns: Mapping[str, Array]) -> None:
    """One line per part, in the colour of its phase, over a dotted line that shows where the jumps between them lie."""
    axes.plot(x, y, ":", color=BLACK, lw=0.9, label="jump")
    for part in range(1, int(columns["part"][-1]) + 1):
        rows = columns["part"] == part
        label = str(columns["phase"][rows][0]).removeprefix("free ")
        colour, width = PHASES[label]
        axes.plot(x[rows], y[rows], color=colour, lw=width, label=label)

"""Charts of studies: panels of lines given as data, drawn in the style of all figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...series import Array
from . import MIDDLE, STYLE, WIDE, legend_below

HEIGHT = 3.0  # of a row of panels [inch]
UNNAMED = "_nolegend_"  # label of a line that the legend leaves out
MARKERS = 30  # at most, on a line


@dataclass(frozen=True, eq=False)
class Line:
    """One line or cloud of points; ``style`` as matplotlib's format without colour, "o" for points alone."""

    x: Array
    y: Array
    label: str
    style: str = "-"
    color: str = "#000000"


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes; limits None: all of the data.

    ``logs``: logarithmic axes, "", "x", "y" or "xy"; a logarithmic x axis has its ticks at the first line's points.
    """

    xlabel: str
    ylabel: str
    lines: Sequence[Line]
    title: str = ""
    logs: str = ""
    xlim: tuple[float | None, float | None] | None = None
    ylim: tuple[float | None, float | None] | None = None


def panels_figure(panels: Sequence[Panel], title: str = "") -> Figure:
    """The panels two by two, lettered, each with its legend, or with one for all where it is the same."""
    rows = (len(panels) + 1) // 2
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDE if len(panels) > 1 else MIDDLE, HEIGHT * rows), layout="constrained")
        axes = figure.subplots(rows, min(2, len(panels)), squeeze=False).ravel()
        for place, panel, letter in zip(axes, panels, "abcdefgh", strict=False):
            _draw(place, panel, f"({letter}) " if len(panels) > 1 else "")
        for place in axes[len(panels) :]:
            place.set_axis_off()
        named = [place for place in axes if place.get_legend_handles_labels()[1]]
        if len({tuple(place.get_legend_handles_labels()[1]) for place in named}) == 1:
            legend_below(figure, named[:1], 4)
        else:
            for place in named:
                place.legend()
        if title:
            figure.suptitle(title)
        return figure


def _draw(axes: Axes, panel: Panel, letter: str) -> None:
    if "x" in panel.logs:
        axes.set_xscale("log")
        axes.set_xticks(panel.lines[0].x, [f"{x:.3g}" for x in panel.lines[0].x])
        axes.minorticks_off()
    if "y" in panel.logs:
        axes.set_yscale("log")
    if not panel.logs:
        axes.axvline(0, color="0.7", lw=0.6)
        axes.axhline(0, color="0.7", lw=0.6)
    for line in panel.lines:
        every = max(1, len(line.x) // MARKERS)
        axes.plot(line.x, line.y, line.style, color=line.color, label=line.label, ms=3.5, mfc="none", lw=1.0,
                  markevery=every)  # fmt: skip
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=letter + panel.title, xlim=panel.xlim, ylim=panel.ylim)

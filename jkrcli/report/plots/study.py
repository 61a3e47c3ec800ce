"""Figures of comparisons and studies: panels of lines given as data, differences of two results."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...base import Array
from ...series.differences import Difference
from . import Axes, Figure, legend_below, log_ticks, panelled, zero_lines
from .looks import COLORS, MIDDLE, NARROW, WIDE


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
    ``right``: a line of another quantity, and the label of its own axis.
    """

    xlabel: str
    ylabel: str
    lines: Sequence[Line]
    title: str = ""
    logs: str = ""
    xlim: tuple[float | None, float | None] | None = None
    ylim: tuple[float | None, float | None] | None = None
    right: tuple[str, Line] | None = None


def panels_figure(panels: Sequence[Panel], title: str = "") -> Figure:
    """The panels two by two, lettered, each with its legend, or with one for all where it is the same."""
    rows = (len(panels) + 1) // 2
    with panelled(WIDE if len(panels) > 1 else MIDDLE, 3.0 * rows, len(panels), min(2, len(panels))) as (figure, axes):
        for place, panel, letter in zip(axes, panels, "abcdefgh", strict=False):
            _draw(place, panel, f"({letter}) " if len(panels) > 1 else "")
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
        ticks = _apart(panel.lines[0].x)
        axes.set_xticks(ticks, [f"{x:.3g}" if x < 1000 else f"{x:,.0f}" for x in ticks])
        axes.minorticks_off()
    if "y" in panel.logs:
        axes.set_yscale("log")
    else:
        axes.ticklabel_format(axis="y", useOffset=False)  # 1.1998, not -2e-4 + 1.2
    if not panel.logs:
        zero_lines(axes)
    for line in panel.lines:
        _line(axes, line)
    if panel.right is not None:
        label, line = panel.right
        other = axes.twinx()
        other.set_yscale(axes.get_yscale())
        other.set_ylabel(label)
        other.grid(visible=False)
        other.spines["right"].set_visible(True)
        _line(other, line)
        if "y" in panel.logs:
            log_ticks(other.yaxis)
        _line(axes, replace(line, x=np.empty(0), y=np.empty(0)))  # for the legend
    if "y" in panel.logs:
        log_ticks(axes.yaxis)
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=letter + panel.title, xlim=panel.xlim, ylim=panel.ylim)


def _apart(x: Array) -> list[float]:
    """Those of the points on a logarithmic axis whose labels have room beside each other."""
    room, ticks = 0.15 * math.log(float(x.max() / x.min())), [float(x.max())]
    for value in sorted(x.tolist(), reverse=True):
        if math.log(ticks[-1] / value) > room:
            ticks.append(value)
    return ticks


def _line(axes: Axes, line: Line) -> None:
    every = max(1, len(line.x) // 30)  # at most so many markers on a line
    axes.plot(line.x, line.y, line.style, color=line.color, label=line.label, ms=3.5, mfc="none", lw=1.0,
              markevery=every)  # fmt: skip


def differences_figure(differences: Sequence[Difference], rtol: float) -> Figure:
    """Relative differences over what they are compared at, in logs, with the limit."""
    with panelled(NARROW, 3.2, legend=3) as (figure, [axes]):
        for difference, color in zip(differences, itertools.cycle(COLORS), strict=False):
            size = np.maximum(np.abs(difference.relative), 1e-17)
            label = f"${_symbol(difference.column)}({_symbol(difference.over)})$"
            axes.loglog(difference.x, size, ".-", color=color, ms=4, lw=0.8, label=label)
        axes.axhline(rtol, color="0.4", lw=0.8, ls=":", label=f"rtol {rtol:g}")
        names = dict.fromkeys(item.over for item in differences)
        axes.set(xlabel=" or ".join(f"${_symbol(over)}$ (m)" for over in names), ylabel="relative difference")
        return figure


def _symbol(column: str) -> str:
    """The symbol of a column: "delta_m" is \\delta, "dS" S'."""
    return column.removesuffix("_m").replace("delta", r"\delta").replace("dS", "S'")

"""Figures of maps: lines over one axis, a family of them; the pull-off force filled over adhesion and its range; zones
of the models.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator

from ..base.numerics import Array
from ..report.plots import (
    BLACK,
    COLORS,
    MIDDLE,
    NARROW,
    WIDE,
    Axes,
    Figure,
    axis_of,
    drawing,
    legend_below,
    log_ticks,
    panelled,
    zero_lines,
)

MU = r"$\sigma\,(R / E^{*2} w)^{1/3}$"  # words of an axis
LINES = ("-", "--", ":", "-.")
GOLDEN = (math.sqrt(5) - 1) / 2  # theory: its multiples fill an interval evenly
WRITTEN = 1e4  # choice: of the ends of an axis, below which its ticks are numbers as people write them
LETTER = 0.0135  # choice: width of a letter of the words beside lines, in shares of the axes


@dataclass(frozen=True)
class MapPanel:
    """One column of a map over its axis: words of the y axis, ``limits``: values with what they are; ``logs``: "x" or
    "xy"; ``dashed``: a column that is drawn beside it."""

    column: str
    ylabel: str
    title: str = ""
    limits: Mapping[float, str] = field(default_factory=dict)
    ylim: tuple[float, float] | None = None
    logs: str = "x"
    dashed: str = ""


def lines_figure(
    columns: Mapping[str, Array],
    over: tuple[str, str],
    panels: Sequence[MapPanel],
    families: Mapping[str, Callable[[float], str]],
) -> Figure:
    """The ``panels`` over the column and words ``over``: a colour for each set of values of the columns in
    ``families``, named by the words there, a kind of line for each value of the last of several."""
    sets = list(dict.fromkeys(zip(*(columns[name].tolist() for name in families), strict=True)))
    last = list(dict.fromkeys(values[-1] for values in sets)) if len(families) > 1 else []
    width, legend = WIDE if len(panels) > 1 else MIDDLE, 4 if len(families) == 1 else 3
    with panelled(width, 3.4, len(panels), legend=legend) as (figure, places):
        for axes, panel in zip(places, panels, strict=True):
            for i, values in enumerate(sets):
                of = np.all([columns[name] == value for name, value in zip(families, values, strict=True)], axis=0)
                words = (words_of(value) for words_of, value in zip(families.values(), values, strict=True))
                line = LINES[last.index(values[-1]) % len(LINES)] if last else "-"
                color = COLORS[i % len(COLORS)]
                axes.plot(columns[over[0]][of], columns[panel.column][of], "." + line, color=color, ms=4,
                          label=", ".join(words))  # fmt: skip
                if panel.dashed:
                    axes.plot(columns[over[0]][of], columns[panel.dashed][of], "--", color=color, lw=0.8)
            _dress(axes, panel, over[1])
        return figure


def _dress(axes: Axes, panel: MapPanel, xlabel: str) -> None:
    """Scales, limits and words of a panel."""
    axes.set(xlabel=xlabel, ylabel=panel.ylabel, title=panel.title, xscale="log")
    if "y" in panel.logs:
        axes.set_yscale("log")
        log_ticks(axes.yaxis)
    if panel.ylim is not None:  # None would keep the limits of a linear axis
        axes.set_ylim(panel.ylim)
    drawn = [_placed(axes, np.asarray(line.get_xydata())) for line in axes.get_lines()]
    for value, words in panel.limits.items():
        axes.axhline(value, color="0.6", lw=0.8, ls="--" if words else ":")
        # The word stands where it is farthest from the lines drawn, above (1) or below (-1) its own
        level = float(_placed(axes, np.array([[axes.get_xlim()[0], value]]))[0, 1])
        wide, high = LETTER * len(words), 2 * LETTER
        places = []
        for left in (0.99 - wide, 0.01):
            word = np.linspace(left, left + wide, 20)
            for side in (1, -1):
                middle = level + side * high
                inside = high < middle < 1 - high
                lines = [np.abs(np.interp(word, line[:, 0], line[:, 1]) - middle).min() for line in drawn]
                places.append((min([*lines, 8 * LETTER]) if inside else 0.0, (left, side)))
        x, side = next((place for room, place in places if room > 4 * LETTER), max(places)[1])
        axes.annotate(words, (x, value), xycoords=("axes fraction", "data"), xytext=(0, side), ha="left",
                      textcoords="offset points", va="bottom" if side > 0 else "top", size=8, color="0.4")  # fmt: skip


def _placed(axes: Axes, points: Array) -> Array:
    """Points of the data in shares of the axes."""
    return (axes.transScale + axes.transLimits).transform(points)


def filled_figure(columns: Mapping[str, Array]) -> Figure:
    """-P_min/(pi w R) in colour over mu and q: where it is within a hundredth of JKR's force and of that of a long
    range, and where it lies above both, with its largest excess. What is not known stays white."""
    nus = list(dict.fromkeys(columns["nu"].tolist()))
    low, high = (float(function(columns["minus_P_over_pi_w_R"])) for function in (np.nanmin, np.nanmax))
    levels = np.arange(np.floor(20 * low), np.ceil(20 * high) + 1) / 20
    with drawing(max(NARROW * len(nus), MIDDLE), 3.8) as figure:
        panels = np.atleast_1d(figure.subplots(1, len(nus), sharey=True))
        for axes, nu in zip(panels, nus, strict=True):
            rows = {name: values[columns["nu"] == nu] for name, values in columns.items()}
            mu, q = np.unique(rows["mu"]), np.unique(rows["w_R2_over_Estar_h3"])
            order = np.lexsort((rows["mu"], rows["w_R2_over_Estar_h3"]))
            names = "minus_P_over_pi_w_R", "jkr_minus_P_over_pi_w_R"
            force, sharp = (rows[name][order].reshape(q.size, mu.size) for name in names)
            drawn = axes.contourf(mu, q, force, levels=levels, cmap="viridis")
            short, long = (np.abs(np.nan_to_num(force / limit - 1)) for limit in (sharp, 2))
            short = np.maximum.accumulate(short[:, ::-1], axis=1)[:, ::-1]  # from there on, as the force crosses limits
            long = np.maximum.accumulate(long, axis=1)
            for values, style, words in ((short, "--", "JKR to 1 %"), (long, ":", "long range to 1 %")):
                edged = [withStroke(linewidth=2.4, foreground="0.2")]  # white on any ground, that of the legend too
                line = axes.contour(mu, q, values, levels=[0.01], colors="white", linestyles=style, linewidths=1.2)
                line.set(path_effects=edged)
                axes.plot([], [], style, color="white", lw=1.2, path_effects=edged, label=words)
            excess, seen = np.nan_to_num(force / np.maximum(sharp, 2) - 1), 0.001
            if excess.max() > seen:
                axes.contour(mu, q, excess, levels=[seen], colors=COLORS[1], linewidths=1.6)
                axes.plot([], [], "-", color=COLORS[1], lw=1.6, label="above both limits")
                ridge = excess.argmax(axis=1)
                there = excess[np.arange(q.size), ridge] > seen
                axes.plot(mu[ridge][there], q[there], "o", color=COLORS[1], ms=3, label="largest excess")
            _log_axes(axes)
            axes.set(title=rf"$\nu$ = {nu:g}, {columns['base'][0]}", xlabel=MU)
        panels[0].set_ylabel(r"$w R^2 / (E^* h^3)$")
        figure.colorbar(drawn, ax=list(panels), label=r"pull-off force / $\pi w R$")
        legend_below(figure, list(panels), 3)
        return figure


def _log_axes(axes: Axes) -> None:
    axes.set(xscale="log", yscale="log")
    log_ticks(axes.xaxis, axes.yaxis)


def zones_figure(columns: Mapping[str, Array], names: Sequence[str]) -> Figure:
    """The zone of each model over range and load in colour, by its name."""
    from matplotlib.colors import ListedColormap

    mus, loads = (np.unique(columns[name]) for name in ("mu", "load_over_pi_w_R"))
    zone = np.array([names.index(name) for name in columns["zone"]]).reshape(loads.size, mus.size)
    shades = ("#dddddd", "#9ecae1", "#fff3b0", "#c7e9c0", "#fdd0a2")
    with drawing(MIDDLE, 3.8) as figure:
        axes = figure.subplots()
        axes.pcolormesh(mus, loads, zone, cmap=ListedColormap(shades), vmin=-0.5, vmax=len(names) - 0.5,
                        shading="nearest")  # fmt: skip
        _log_axes(axes)
        for number, name in enumerate(names):
            row, column = np.nonzero(zone == number)
            if row.size:
                middle = int(np.argmin(np.hypot(row - np.median(row), column - np.median(column))))
                axes.annotate(name, (mus[column[middle]], loads[row[middle]]), ha="center", va="center", size=9)
        nu, q = (columns[name][0] for name in ("nu", "w_R2_over_Estar_h3"))
        axes.set(xlabel=MU, ylabel=r"load / $\pi w R$", title=rf"$\nu$ = {nu:g}, $w R^2/(E^* h^3)$ = {q:g}")
        return figure


# --------------------------------------------------------------------------------------------------
# Figures of comparisons and studies: panels of lines given as data, differences of two results.


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
    """One pair of axes.

    ``logs``: logarithmic axes, "", "x", "y" or "xy"; ``at_points``: a logarithmic x axis has its ticks at the first
    line's points, else where people write numbers.
    ``xlim``, ``ylim``: ends of the axes, where they are given.
    ``right``: a line of another quantity, and the label of its own axis.
    """

    xlabel: str
    ylabel: str
    lines: Sequence[Line]
    title: str = ""
    logs: str = ""
    at_points: bool = True
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
    if "x" in panel.logs and panel.at_points:
        # Those of the points whose labels have room beside each other
        x = panel.lines[0].x
        room, ticks = 0.15 * math.log(float(x.max() / x.min())), [float(x.max())]
        for value in sorted(x.tolist(), reverse=True):
            if math.log(ticks[-1] / value) > room:
                ticks.append(value)
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
    if "x" in panel.logs and not panel.at_points:
        log_ticks(axes.xaxis)
        low, high = axes.get_xlim()
        if 100 <= high / low < WRITTEN:  # 0.02, 0.05, 0.1, not powers of ten
            axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high / low < WRITTEN / 10 else (1,)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=letter + panel.title, xlim=panel.xlim, ylim=panel.ylim)


def _line(axes: Axes, line: Line) -> None:
    every = max(1, len(line.x) // 30)  # at most so many markers on a line
    axes.plot(line.x, line.y, line.style, color=line.color, label=line.label, ms=3.5, mfc="none", lw=1.0,
              markevery=every)  # fmt: skip


# --------------------------------------------------------------------------------------------------
# Samples of measured curves.

WIDEST_POINTS = 0.3  # choice: of the distance of two boxes, over which the points of one are spread
LONG_NAMES = 24  # choice: letters of the names under a panel, beyond which they stand aslant


def boxes_figure(names: Sequence[str], quantities: Mapping[str, Sequence[tuple[Array, Sequence[float]]]]) -> Figure:
    """A box (median, quartiles, whiskers to the last point within 1.5 of their distance) and all points of each sample,
    a panel for each quantity; on a logarithmic axis where they span more than a decade. Beside the values stands, where
    there is one, a mean with the ends of its interval: an open diamond."""
    with panelled(WIDE if len(quantities) > 1 else NARROW, 3.2, len(quantities)) as (figure, places):
        for axes, (name, each) in zip(places, quantities.items(), strict=True):
            every, thin, heavy = (
                np.concatenate([values for values, _ in each]),
                {"lw": 0.8},
                {"color": BLACK, "lw": 1.4},
            )
            factor, label = axis_of(name, every)
            axes.boxplot([values / factor for values, _ in each], positions=range(len(names)), widths=0.6,
                         showfliers=False, boxprops=thin, whiskerprops=thin, medianprops=heavy)  # fmt: skip
            for i, (values, mean) in enumerate(each):
                spread = WIDEST_POINTS * (np.arange(values.size) * GOLDEN % 1 * 2 - 1)
                axes.plot(i + spread, values / factor, "o", color=COLORS[i % len(COLORS)], ms=2.5, mfc="none", mew=0.6)
                if mean:
                    reach = np.abs(np.array(mean[1:])[:, None] - mean[0])
                    axes.errorbar([i + 0.42], [mean[0] / factor], reach / factor, fmt="D", color=BLACK, ms=4,
                                  mfc="white", lw=1.0, capsize=2, zorder=4)  # fmt: skip
            if (every > 0).all() and every.max() > 10 * every.min():
                axes.set_yscale("log")
                log_ticks(axes.yaxis)
            aslant = len("".join(names)) > LONG_NAMES
            axes.set_xticks(range(len(names)), labels=names, rotation=30 * aslant, ha="right" if aslant else "center")
            axes.set(ylabel=label, xlim=(-0.6, len(names) - 0.4))
            axes.grid(visible=False, axis="x")
        return figure

"""Maps between JKR and DMT: the pull-off force on layers, filled over adhesion and its range; zones of the models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patheffects import withStroke

from ...base.arrays import Array
from . import COLORS, MIDDLE, NARROW, Axes, Figure, drawing, legend_below

if TYPE_CHECKING:
    from matplotlib.contour import ContourSet

FEWEST = 4  # choice: values on both axes from which a map is filled
NEAR = 0.01  # choice: of a limit, within which it is drawn to hold
STEP = 0.05  # choice: of the force, from colour to colour


def transition_figure(columns: Mapping[str, Array]) -> Figure:
    """The transition map: filled for each nu where there are values enough on both axes, else as lines."""
    sizes = [np.unique(columns[name]).size for name in ("w_R2_over_Estar_h3", "mu")]
    return _filled(columns) if min(sizes) >= FEWEST else _lines(columns)


def _filled(columns: Mapping[str, Array]) -> Figure:
    """-P_min/(pi w R) in colour over mu and q: where it is within a hundredth of JKR's force and of that of a long
    range, and where it lies above both, with its largest excess. What is not known stays white."""
    nus = list(dict.fromkeys(columns["nu"].tolist()))
    low, high = (float(function(columns["minus_P_over_pi_w_R"])) for function in (np.nanmin, np.nanmax))
    levels = STEP * np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1)
    with drawing(max(NARROW * len(nus), MIDDLE), 3.8) as figure:
        panels = np.atleast_1d(figure.subplots(1, len(nus), sharey=True))
        for axes, nu in zip(panels, nus, strict=True):
            drawn = _panel(axes, {name: values[columns["nu"] == nu] for name, values in columns.items()}, levels)
            axes.set_title(f"ν = {nu:g}, {columns['base'][0]}")
            axes.set_xlabel("σ (R / (E*² w))^(1/3)")
        panels[0].set_ylabel("w R² / (E* h³)")
        figure.colorbar(drawn, ax=list(panels), label="pull-off force / (π w R)")
        legend_below(figure, list(panels), 3)
        return figure


def _lines(columns: Mapping[str, Array]) -> Figure:
    """-P_min/(pi w R) over mu, one line per layer, JKR's limit dashed, that of a long range dotted,
    a dot where the force lies above both."""
    with drawing(MIDDLE, 3.4) as figure:
        axes = figure.subplots()
        axes.axhline(2, color="0.6", lw=0.8, ls=":")
        layers = dict.fromkeys(zip(columns["nu"].tolist(), columns["w_R2_over_Estar_h3"].tolist(), strict=True))
        for i, (nu, q) in enumerate(layers):
            rows = (columns["nu"] == nu) & (columns["w_R2_over_Estar_h3"] == q)
            mu, force = columns["mu"][rows], columns["minus_P_over_pi_w_R"][rows]
            short, color = float(columns["jkr_minus_P_over_pi_w_R"][rows][0]), COLORS[i % len(COLORS)]
            axes.semilogx(mu, force, "-", color=color, label=f"ν = {nu:g}, w R²/(E* h³) = {q:g}")
            above = force > max(short, 2)
            axes.semilogx(mu[above], force[above], "o", color=color, ms=4)
            axes.axhline(short, color=color, lw=0.8, ls="--")
        axes.set_xlabel("σ (R / (E*² w))^(1/3)")
        axes.set_ylabel("pull-off force / (π w R)")
        axes.set_title(f"layer on a rigid base, {columns['base'][0]}; dashed: JKR, dotted: long range")
        legend_below(figure, [axes], 3)
        return figure


def _panel(axes: Axes, rows: Mapping[str, Array], levels: Array) -> ContourSet:
    mu, q = np.unique(rows["mu"]), np.unique(rows["w_R2_over_Estar_h3"])
    order = np.lexsort((rows["mu"], rows["w_R2_over_Estar_h3"]))
    force, sharp = (rows[name][order].reshape(q.size, mu.size) for name in ("minus_P_over_pi_w_R",
                                                                            "jkr_minus_P_over_pi_w_R"))  # fmt: skip
    drawn = axes.contourf(mu, q, force, levels=levels, cmap="viridis")
    short, long = (np.abs(np.nan_to_num(force / limit - 1)) for limit in (sharp, 2))
    short = np.maximum.accumulate(short[:, ::-1], axis=1)[:, ::-1]  # from there on, as the force crosses limits
    long = np.maximum.accumulate(long, axis=1)
    for values, style, words in ((short, "--", "JKR to 1 %"), (long, ":", "long range to 1 %")):
        edged = [withStroke(linewidth=2.4, foreground="0.2")]  # white on any ground, that of the legend too
        axes.contour(mu, q, values, levels=[NEAR], colors="white", linestyles=style, linewidths=1.2).set(
            path_effects=edged
        )
        axes.plot([], [], style, color="white", lw=1.2, path_effects=edged, label=words)
    excess = np.nan_to_num(force / np.maximum(sharp, 2) - 1)
    if excess.max() > NEAR / 10:
        axes.contour(mu, q, excess, levels=[NEAR / 10], colors=COLORS[1], linewidths=1.6)
        axes.plot([], [], "-", color=COLORS[1], lw=1.6, label="above both limits")
        ridge = excess.argmax(axis=1)
        there = excess[np.arange(q.size), ridge] > NEAR / 10
        axes.plot(mu[ridge][there], q[there], "o", color=COLORS[1], ms=3, label="largest excess")
    axes.set_xscale("log")
    axes.set_yscale("log")
    return drawn


def adhesion_figure(mus: Array, loads: Array, zone: Array, names: Sequence[str], title: str) -> Figure:
    """The adhesion map: the ``zone`` (loads, mus) of each model in colour, by its name."""
    from matplotlib.colors import ListedColormap

    shades = ("#dddddd", "#9ecae1", "#fff3b0", "#c7e9c0", "#fdd0a2")
    with drawing(MIDDLE, 3.8) as figure:
        axes = figure.subplots()
        axes.pcolormesh(mus, loads, zone, cmap=ListedColormap(shades), vmin=-0.5, vmax=len(names) - 0.5,
                        shading="nearest")  # fmt: skip
        axes.set_xscale("log")
        axes.set_yscale("log")
        for number, name in enumerate(names):
            row, column = np.nonzero(zone == number)
            if row.size:
                middle = int(np.argmin(np.hypot(row - np.median(row), column - np.median(column))))
                axes.annotate(name, (mus[column[middle]], loads[row[middle]]), ha="center", va="center", size=9)
        axes.set_xlabel("σ (R / (E*² w))^(1/3)")
        axes.set_ylabel("load / (π w R)")
        axes.set_title(title)
        return figure

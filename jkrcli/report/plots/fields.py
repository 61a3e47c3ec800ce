"""Figures of a mesh, of one contact state, and of the differences between two results."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...base.units import scale, show
from ...methods.fem.grid import Grid
from ...series import Array
from ...series.differences import Difference
from . import BLACK, BLUE, COLORS, NARROW, ORANGE, STYLE, WIDE, legend_below, pretty

THIN = 0.1  # depth over width of what is drawn
WITHOUT_EDGE = 0.98  # of the radius: pressures up to there set the axis


def differences_figure(found: Sequence[Difference], rtol: float) -> Figure:
    """Relative differences over what they are compared at, in logs, with the limit."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(NARROW, 3.2), layout="constrained")
        axes = figure.subplots()
        for difference, color in zip(found, itertools.cycle(COLORS), strict=False):
            size = np.maximum(np.abs(difference.relative), 1e-17)
            label = f"{difference.column}({_symbol(difference.over)})"
            axes.loglog(difference.x, size, ".-", color=color, ms=4, lw=0.8, label=label)
        axes.axhline(rtol, color="0.4", lw=0.8, ls=":", label=f"rtol {rtol:g}")
        axes.set_xlabel(" or ".join(f"{_symbol(over)} (m)" for over in dict.fromkeys(item.over for item in found)))
        axes.set_ylabel("relative difference")
        legend_below(figure, [axes], 3)
        return figure


def _symbol(column: str) -> str:
    """The symbol of a column: "delta_m" is δ."""
    return column.removesuffix("_m").replace("delta", "δ")


def mesh_figure(grid: Grid, reach: float) -> Figure:
    """The whole body and its contact zone; ``reach`` [m]: radius out to which contact is expected."""
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        zone = min(1.5 * reach, grid.width), min(1.5 * reach, grid.depth)
        tallest = max(grid.depth / grid.width, zone[1] / zone[0])
        figure = Figure(figsize=(WIDE, 1.0 + float(np.clip(0.42 * WIDE * tallest, 0.6, 5.0))), layout="constrained")
        left, right = figure.subplots(1, 2)
        _cells(left, grid, grid.width, grid.depth)
        left.set_title(f"whole body, {len(grid.cells):,} {grid.element}s")
        _cells(right, grid, *zone)
        right.set_title(f"contact zone, quality {np.min(grid.quality()):.2f} to {np.max(grid.quality()):.2f}")
        factor = scale(zone[0], "length")[0]
        right.plot([0, reach / factor], [0, 0], color=ORANGE, lw=2.5, solid_capstyle="butt", clip_on=False,
                   label="contact expected")  # fmt: skip
        legend_below(figure, [right], 1)
        return figure


def _cells(axes: Axes, grid: Grid, width: float, depth: float) -> None:
    """Draw the cells within ``width`` and ``depth`` [m], one colour per layer, thinner lines for many cells."""
    corners = grid.points[grid.cells]
    shown = (corners[..., 0].min(axis=1) <= width) & (corners[..., 1].max(axis=1) >= -depth)
    factor, unit = scale(width, "length")
    colors = [("#DCEAF4", "#FBE3D0", "#D9EFE4", "#F3E1EC", "#F7F3C8", "#E4E4E4")[i % 6] for i in grid.materials[shown]]
    line = float(np.clip(30 / np.sqrt(shown.sum() + 1), 0.03, 0.6))
    axes.add_collection(PolyCollection(corners[shown] / factor, facecolors=colors, edgecolors="0.25", linewidths=line))
    axes.set_xlim(0, width / factor)
    axes.set_ylim(-depth / factor, 0)
    axes.set_aspect("equal")
    if depth < THIN * width:  # no room for two labels
        axes.set_yticks([-depth / factor], [f"\N{MINUS SIGN}{depth / factor:.3g}"])
    else:
        axes.yaxis.set_major_locator(MaxNLocator(int(np.clip(12 * depth / width, 2, 8))))
    axes.set_xlabel(f"r ({pretty(unit)})")
    axes.set_ylabel(f"z ({pretty(unit)})")


def profile_figure(columns: Mapping[str, Array], a: float, w: float) -> Figure:
    """Pressure inside, and the surfaces of specimen and indenter around a contact of radius ``a`` [m]."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDE, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        length, unit = scale(a, "length")
        _pressure(left, columns, a / length, length)
        _surfaces(right, columns, a / length, length)
        for axes in (left, right):
            axes.set_xlabel(f"r ({pretty(unit)})")
        legend_below(figure, [right], 3)
        figure.suptitle(f"a = {pretty(show(a, 'length'))}, w = {pretty(show(w, 'work'))}")
        return figure


def _pressure(axes: Axes, columns: Mapping[str, Array], a: float, length: float) -> None:
    """The pressure, its axis without what lies close to the edge: there it grows without bound under adhesion."""
    r = columns["r_m"] / length
    seen = r <= WITHOUT_EDGE * a
    factor, unit = scale(float(np.max(np.abs(columns["pressure_Pa"][seen]))), "modulus")
    p = columns["pressure_Pa"] / factor
    axes.axhline(0, color="0.7", lw=0.6)
    axes.plot(r[r < a], p[r < a], color=ORANGE)
    _edge(axes, a)
    low, high = min(0.0, float(np.min(p[seen]))), max(0.0, float(np.max(p[seen])))
    axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
    axes.set_ylabel(f"contact pressure ({pretty(unit)})")


def _surfaces(axes: Axes, columns: Mapping[str, Array], a: float, length: float) -> None:
    """Both surfaces, the axis of heights as high as the specimen asks for: the indenter leaves it."""
    r = columns["r_m"] / length
    factor, unit = scale(float(np.max(np.abs(columns["displacement_m"]))), "length")
    height = -columns["displacement_m"] / factor
    axes.plot(r, height, color=BLUE, label="specimen")
    axes.plot(r, height + columns["gap_m"] / factor, "--", color=BLACK, label="indenter")
    _edge(axes, a)
    low, high = float(np.min(height)), float(np.max(height))
    axes.set_ylim(low - 0.1 * (high - low), high + 0.8 * (high - low))
    axes.set_ylabel(f"height ({pretty(unit)})")


def _edge(axes: Axes, a: float) -> None:
    axes.axvline(a, color="0.5", lw=0.8, ls=":", label="edge of the contact")

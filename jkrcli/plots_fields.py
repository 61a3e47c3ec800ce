"""Figures of a mesh, of one contact state, and of the differences between two results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from .differences import Difference
from .fem.grid import Grid
from .plots import BLACK, BLUE, GREEN, ORANGE, STYLE, pretty
from .series import Array
from .units import scale, show


def differences_figure(found: Sequence[Difference], rtol: float) -> Figure:
    """Relative differences over what they are compared at, in logs, with the limit."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.5, 3.2), layout="constrained")
        axes = figure.subplots()
        for difference, color in zip(found, (ORANGE, BLUE, GREEN, BLACK, "#CC79A7", "#56B4E9"), strict=False):
            size = np.maximum(np.abs(difference.relative), 1e-17)
            axes.loglog(
                difference.x, size, ".-", color=color, ms=4, lw=0.8, label=f"{difference.column}({difference.over})"
            )
        axes.axhline(rtol, color="0.4", lw=0.8, ls=":", label=f"rtol {rtol:g}")
        axes.set_xlabel("displacement δ (m) or contact radius a (m)")
        axes.set_ylabel("relative difference")
        axes.legend()
        return figure


def mesh_figure(grid: Grid, reach: float) -> Figure:
    """The whole body and its contact zone; ``reach`` [m]: radius out to which contact is expected."""
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(7.2, 4.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        _cells(left, grid, grid.width, grid.depth)
        left.set_title(f"whole body, {len(grid.cells):,} {grid.element}s")
        _cells(right, grid, min(1.5 * reach, grid.width), min(1.5 * reach, grid.depth))
        right.set_title(f"contact zone, quality {np.min(grid.quality()):.2f} to {np.max(grid.quality()):.2f}")
        factor = scale(min(1.5 * reach, grid.width), "length")[0]
        right.plot([0, reach / factor], [0, 0], color=ORANGE, lw=2.5, solid_capstyle="butt", clip_on=False,
                   label="contact expected")  # fmt: skip
        right.legend(loc="lower right", frameon=True)
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
    axes.set_xlabel(f"r ({pretty(unit)})")
    axes.set_ylabel(f"z ({pretty(unit)})")


def profile_figure(columns: Mapping[str, Array], a: float, w: float) -> Figure:
    """Pressure inside, and the surfaces of specimen and indenter around a contact of radius ``a`` [m]."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        r, p = columns["r_m"], columns["pressure_Pa"]
        length, unit = scale(a, "length")
        inside = r < a
        stress, stress_unit = scale(float(np.max(np.abs(np.median(p[inside])))) or 1.0, "modulus")
        left.axhline(0, color="0.7", lw=0.6)
        left.plot(r[inside] / length, p[inside] / stress, color=ORANGE)
        left.axvline(a / length, color="0.5", lw=0.8, ls=":")
        low, high = np.percentile(p[inside] / stress, [4, 100])
        left.set_ylim(low - 0.15 * (high - low), high + 0.1 * (high - low))
        left.set_xlabel(f"r ({pretty(unit)})")
        left.set_ylabel(f"contact pressure ({pretty(stress_unit)})")
        height, height_unit = scale(float(np.max(np.abs(columns["displacement_m"]))), "length")
        right.plot(r / length, -columns["displacement_m"] / height, color=BLUE, label="specimen")
        right.plot(
            r / length, (columns["gap_m"] - columns["displacement_m"]) / height, "--", color=BLACK, label="indenter"
        )
        right.axvline(a / length, color="0.5", lw=0.8, ls=":")
        right.set_xlabel(f"r ({pretty(unit)})")
        right.set_ylabel(f"height ({pretty(height_unit)})")
        right.legend()
        figure.suptitle(f"a = {pretty(show(a, 'length'))}, w = {pretty(show(w, 'work'))}")
        return figure

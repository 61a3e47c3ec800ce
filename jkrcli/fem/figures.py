"""Figures of the body: the contact zone at one state, and its mesh."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from ..base.numerics import Array
from ..base.units import scale, show
from ..report import plots
from ..report.plots import Axes, Figure, drawing, panelled, pretty

if TYPE_CHECKING:
    from ..bodies.indenters import Indenter
    from .fields import ContactState
    from .mesh import Grid

# Of the contact zone as it is drawn, in contact radii:
ASIDE, DEEP, HIGH = 2.0, 1.6, 0.75  # choice: the window to both sides of the axis, below the surface and above it
SYMBOLS = {
    "rr": r"$\sigma_{rr}$", "tt": r"$\sigma_{\theta\theta}$", "zz": r"$\sigma_{zz}$", "rz": r"$\sigma_{rz}$",
    "mises": "von Mises stress",
}  # fmt: skip


def contact_zone_figure(state: ContactState, indenter: Indenter, w: float, component: str) -> Figure:
    """A stress (``component``: rr, tt, zz, rz, mises) on the deformed body, the mirror image left of the axis."""
    depth = min(DEEP * state.a, state.grid.depth + 0.15 * state.a)
    with drawing(plots.WIDE, 0.8 + 1.4 * (depth / state.a + HIGH), {"axes.grid": False}) as figure:
        axes = figure.subplots()
        length, unit = scale(state.a, "length")
        factor = magnification(state)
        _stress(figure, axes, state, component, factor, length)
        _outlines(axes, state, indenter, factor, length)
        aside, top = ASIDE * state.a / length, HIGH * state.a / length
        axes.set(xlim=(-aside, aside), ylim=(-depth / length, top), aspect="equal")
        axes.set(xlabel=f"$r$ ({pretty(unit)})", ylabel=f"$z$ ({pretty(unit)})")
        drawn = "" if factor == 1 else f", displacements × {factor:g}"
        words = [show(state.a, "length"), show(w, "work"), show(state.P, "load")]
        a, work, P = (pretty(word).replace("-", "\N{MINUS SIGN}") for word in words)
        axes.set_title(f"$a$ = {a}, $w$ = {work}, $P$ = {P}{drawn}")
        return figure


def magnification(state: ContactState) -> float:
    """1, 2 or 5 times a power of ten, at least 1: displacements in the window are then at most 0.3 radii."""
    seen = np.abs(state.displacement[_within(state.grid.points, state.a)]).max()
    if seen == 0:
        return 1.0
    wanted = 0.3 * state.a / float(seen)
    decade = 10.0 ** math.floor(math.log10(wanted))
    return max(1.0, max(step for step in (1, 2, 5) if step * decade <= wanted * (1 + 1e-9)) * decade)


def _within(points: Array, a: float) -> Array:
    return (points[:, 0] <= 1.1 * ASIDE * a) & (points[:, 1] >= -1.2 * DEEP * a)


def _stress(figure: Figure, axes: Axes, state: ContactState, component: str, factor: float, length: float) -> None:
    """Filled contours layer by layer: stresses jump at interfaces."""
    values = state.mises if component == "mises" else state.stress[("rr", "tt", "zz", "rz").index(component)]
    # Stresses that bound 98 % of each layer in the window, so that a thin one is seen beside the others; those at the
    # edge of an adhesive contact are infinite
    grid = state.grid
    corners = grid.points[grid.cells]
    seen = _within(corners.mean(axis=1), state.a)
    bounds = [_bounds(corners, values[grid.cells], seen & (grid.materials == layer))
              for layer in np.unique(grid.materials[seen])]  # fmt: skip
    low, high = min(low for low, _ in bounds), max(high for _, high in bounds)
    stress, unit = scale(max(abs(low), abs(high)) or 1.0, "modulus")
    levels = np.asarray(MaxNLocator(16, symmetric=low < 0 < high).tick_values(low / stress, high / stress))
    colors = mpl.colormaps["RdBu_r" if low < 0 < high else "Blues_r" if high <= 0 else "Reds"]
    extend: Literal["both", "max"] = "max" if component == "mises" else "both"
    norm = BoundaryNorm(levels, colors.N, extend=extend)
    moved = (grid.points + factor * state.displacement) / length
    near = _within(grid.points, state.a)[grid.cells].any(axis=1)
    quarters = [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]  # of a quadratic triangle
    for layer in np.unique(grid.materials[near]):
        cells = state.quadratic[near & (grid.materials == layer)][:, quarters].reshape(-1, 3)
        for side in (1, -1):
            body = Triangulation(side * moved[:, 0], moved[:, 1], cells)
            drawn = axes.tricontourf(body, values / stress, levels=levels, cmap=colors, norm=norm, extend=extend)
    zero = int(np.argmin(np.abs(levels)))
    every = max(1, levels.size // 7)
    beside = axes.inset_axes((1.02, 0, 0.03, 1))  # as high as the body is drawn
    bar = figure.colorbar(drawn, cax=beside, ticks=levels[zero % every :: every])
    bar.set_label(f"{SYMBOLS[component]} ({pretty(unit)})")


def _bounds(corners: Array, values: Array, inside: Array) -> tuple[float, float]:
    """The stresses that bound 98 % of the area of the cells ``inside``."""
    first, second = corners[inside, 1] - corners[inside, 0], corners[inside, 2] - corners[inside, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    middle = values[inside].mean(axis=1)
    order = np.argsort(middle)
    share = np.cumsum(area[order]) / area.sum()
    low, high = np.interp([0.01, 0.99], share, middle[order])
    return float(low), float(high)


def _outlines(axes: Axes, state: ContactState, indenter: Indenter, factor: float, length: float) -> None:
    """Indenter, deformed lines of the body, undeformed surface, and the base where the specimen ends there."""
    # Vertices that stand twice, once for each layer.
    _, first, count = np.unique(state.grid.points, axis=0, return_index=True, return_counts=True)
    depths = np.unique(np.round(-state.grid.points[first[count > 1], 1], 15))
    surface = _moved_line(state, 0.0, factor)
    r = np.linspace(0, min(1.2 * ASIDE * state.a, indenter.r_max * (1 - 1e-9)), 400)
    # drawn displacements are larger than they are: the indenter is drawn where they take the points it touches
    rows = _line(state, 0.0)
    of_surface, moved = state.grid.points[rows, 0], state.displacement[rows, 0]
    across = r + factor * np.interp(np.minimum(r, state.a), of_surface, moved)
    height = factor * (indenter.f(r) - state.delta)
    if indenter.material is not None:  # an elastic one follows the surface it touches, and about a punch's beyond
        follows = np.interp(np.minimum(r, state.a), of_surface, surface[:, 1])
        edge_off = follows[-1] - factor * (float(indenter.f(np.array(state.a))) - state.delta)
        beyond = edge_off * 2 / np.pi * np.arcsin(state.a / np.maximum(r, state.a))
        height = np.where(r <= state.a, follows, height + beyond)
    across, height = np.concatenate([-across[::-1], across]) / length, np.concatenate([height[::-1], height]) / length
    top = np.maximum(HIGH * state.a / length + 1, height)
    axes.fill_between(across, height, top, color="0.88", lw=0, zorder=3)
    axes.plot(across, height, color="0.35", lw=1.0, zorder=3)
    for line in (surface, *(_moved_line(state, depth, factor) for depth in depths)):
        for side in (1, -1):
            axes.plot(side * line[:, 0] / length, line[:, 1] / length, color=plots.BLACK, lw=1.0, zorder=4)
    edge = ASIDE * state.a / length
    axes.plot([-edge, edge], [0, 0], color="0.4", lw=0.8, ls="--", zorder=5)
    if "base" in state.lines:
        base = -state.grid.depth / length
        axes.fill_between([-edge, edge], base - state.a / length, base, color="0.75", lw=0)


def _line(state: ContactState, depth: float) -> Array:
    """Vertices on the horizontal line at ``depth`` [m], by radius."""
    points = state.grid.points
    rows = np.flatnonzero(np.isclose(points[:, 1], -depth, rtol=1e-9, atol=1e-12 * state.grid.depth))
    return rows[np.argsort(points[rows, 0])]


def _moved_line(state: ContactState, depth: float, factor: float) -> Array:
    """The deformed line at ``depth`` [m], (n, 2) [m]."""
    rows = _line(state, depth)
    return state.grid.points[rows] + factor * state.displacement[rows]


def mesh_figure(grid: Grid, reach: float) -> Figure:
    """The whole body and its contact zone; ``reach`` [m]: radius out to which contact is expected."""
    zone = min(1.5 * reach, grid.width), min(1.5 * reach, grid.depth)
    tallest = max(grid.depth / grid.width, zone[1] / zone[0])
    height = 1.0 + float(np.clip(0.42 * plots.WIDE * tallest, 0.6, 5.0))
    with panelled(plots.WIDE, height, 2, legend=1, grid=False) as (figure, [left, right]):
        _cells(left, grid, grid.width, grid.depth)
        left.set_title(f"whole body, {len(grid.cells):,} {grid.element}s")
        _cells(right, grid, *zone)
        right.set_title(f"contact zone, quality {np.min(grid.quality()):.2f} to {np.max(grid.quality()):.2f}")
        factor = scale(zone[0], "length")[0]
        right.plot([0, reach / factor], [0, 0], color=plots.ORANGE, lw=2.5, solid_capstyle="butt", clip_on=False,
                   label="contact expected")  # fmt: skip
        return figure


def _cells(axes: Axes, grid: Grid, width: float, depth: float) -> None:
    """Draw the cells within ``width`` and ``depth`` [m], one colour per layer, thinner lines for many cells."""
    corners = grid.points[grid.cells]
    shown = (corners[..., 0].min(axis=1) <= width) & (corners[..., 1].max(axis=1) >= -depth)
    factor, unit = scale(width, "length")
    colors = [("#DCEAF4", "#FBE3D0", "#D9EFE4", "#F3E1EC", "#F7F3C8", "#E4E4E4")[i % 6] for i in grid.materials[shown]]
    line = float(np.clip(30 / np.sqrt(shown.sum() + 1), 0.03, 0.6))
    axes.add_collection(PolyCollection(corners[shown] / factor, facecolors=colors, edgecolors="0.25", linewidths=line))
    axes.set(xlim=(0, width / factor), ylim=(-depth / factor, 0), aspect="equal")
    if depth < 0.1 * width:  # no room for two labels
        axes.set_yticks([-depth / factor], [f"\N{MINUS SIGN}{depth / factor:.3g}"])
    else:
        axes.yaxis.set_major_locator(MaxNLocator(int(np.clip(12 * depth / width, 2, 8))))
    axes.set(xlabel=f"$r$ ({pretty(unit)})", ylabel=f"$z$ ({pretty(unit)})")

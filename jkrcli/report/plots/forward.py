"""Figures of an adhesive curve, its tension enlarged, and of the trace that a device records along it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from ...adhesion.curve import CriticalPoint, Equilibrium, EquilibriumCurve
from ...adhesion.device_path import GRIPPED, STABLE, UNSTABLE, Jump, branch
from ...base.errors import LEVEL
from ...base.numerics import Array
from ...base.units import scale, show
from ...resolve.analysis import Analysis
from ...series import Difference
from .. import plots
from ..tables import Scales
from . import (
    COLORS,
    NARROW,
    Axes,
    Box,
    Figure,
    axis_of,
    colors,
    drawing,
    ends,
    inset,
    pair,
    panelled,
    pretty,
    unit_of,
    zero_lines,
)

if TYPE_CHECKING:
    from ...bodies.indenters import Indenter
    from ...methods.fem.fields import ContactState
    from ...methods.fem.mesh import Grid


BRANCHES = {STABLE: ("o-", ""), GRIPPED: ("--", "stable under displacement control only"), UNSTABLE: (":", "unstable")}
PHASES = {  # colour, width and words; the last drawn the thinnest
    "approach": (plots.BLUE, 2.4, "approach"),
    "turn": (plots.GREEN, 1.8, "unloading at constant $a$"),
    "retraction": (plots.ORANGE, 1.1, "retraction"),
}
SPACING = 0.06  # between markers, of the diagonal of the axes
PANELS: tuple[tuple[str, str, Box], ...] = (  # x, y, and where no curve passes: P(delta) is convex, a(P) concave
    ("delta", "P", (0.17, 0.53, 0.38, 0.45)),
    ("P", "a", (0.55, 0.13, 0.43, 0.45)),
)


def physical_units(curve: EquilibriumCurve) -> Scales:
    """People's units, chosen by the magnitude of all that is drawn."""
    (delta, of_delta), (P, of_P), (a, of_a) = (
        axis_of(name, getattr(curve.series, name), getattr(curve, name)) for name in ("delta", "P", "a")
    )
    return Scales("SI", P, delta, a, (of_delta, of_P, of_a))


def curve_figure(result: Analysis, units: Scales) -> Figure:
    """The paper's Fig. 5, nonadhesive and adhesive; insets show the tension where it is small against the loads."""
    with pair(3) as (figure, panels):
        for axes, (x, y, empty) in zip(panels, PANELS, strict=True):
            _draw(axes, result, units, x, y)
            axes.set(xlabel=units.label(x), ylabel=units.label(y))
            if _dwarfed(result.curve):
                # An inset with the loads between the largest tension and as much compression.
                curve = result.curve
                near = np.abs(curve.P) <= -np.min(curve.P)
                across, up = _xy(curve, units, x, y)[:, near]
                _draw(inset(axes, empty, across, up, 0.1, 7), result, units, x, y)
        return figure


def curves_figure(results: Sequence[Analysis], scales: Scales | None) -> Figure:
    """The adhesive curves of one body for several works of adhesion over its nonadhesive one: their tension and three
    times as much compression, where the loads of the series dwarf it."""
    units = scales or physical_units(results[-1].curve)
    tension = max(-float(np.min(result.curve.P)) for result in results)
    near = [np.abs(result.curve.P) <= 3 * tension for result in results]
    with pair(4) as (figure, panels):
        for axes, (x, y, _) in zip(panels, PANELS, strict=True):
            zero_lines(axes)
            axes.plot(*_xy(results[0].curve.series, units, x, y), color="0.6", lw=2.4, label="nonadhesive")
            for result, color in zip(results, colors(len(results)), strict=False):
                label = f"$w$ = {pretty(show(result.w, 'work'))}"
                axes.plot(*_xy(result.curve, units, x, y), color=color, lw=1.2, label=label)
                point = result.pull_off["load"]
                if isinstance(point, CriticalPoint):
                    axes.plot(*_xy(point, units, x, y), "o", color=color, ms=4)
            axes.plot([], [], "o", color=plots.BLACK, ms=4, label="pull-off (load control)")
            axes.set(xlabel=units.label(x), ylabel=units.label(y))
            if any(_dwarfed(result.curve) for result in results):
                shown = [_xy(result.curve, units, x, y)[:, rows] for result, rows in zip(results, near, strict=True)]
                across, up = np.hstack(shown)
                axes.set(xlim=ends(across, 0.05), ylim=ends(up, 0.05))
        return figure


def _draw(axes: Axes, result: Analysis, units: Scales, x: str, y: str) -> None:
    """All lines of a panel, with their labels for the legend."""
    curve = result.curve
    zero_lines(axes)
    if result.comparison is not None:
        exact = result.comparison.exact
        shown = exact.a <= curve.a[-1]
        for points, label in ((exact.series, "closed form"), (exact, None)):
            axes.plot(*_xy(points, units, x, y)[:, shown], color="0.75", lw=3.5, label=label)
    axes.plot(*_xy(curve.series, units, x, y), "s-", color=plots.BLUE, ms=3, mfc="none", lw=1.0, markevery=SPACING,
              label=f"nonadhesive ({result.solution.method})")  # fmt: skip
    # The band of P, where its half-width is a hundredth of the axis, enough to be seen
    if curve.errors and np.max(curve.errors["P"]) >= 0.01 * np.ptp(curve.P):
        limits = [(curve.P + sign * curve.errors["P"]) / units.P for sign in (-1, 1)]
        along, fill = (x, axes.fill_between) if y == "P" else (y, axes.fill_betweenx)
        label = f"{100 * LEVEL:g} % band of $P$"
        fill(*_xy(curve, units, along), *limits, color=plots.ORANGE, alpha=0.25, lw=0, label=label)
    # Solid where stable under any control, dashed where only a stiff device holds the contact, dotted where none.
    line, words = _xy(result.curve, units, x, y), branch(result.curve)
    style: dict[str, Any] = {"color": plots.ORANGE, "ms": 3, "mfc": "none", "lw": 1.2}
    for word, (look, label) in BRANCHES.items():
        if word == STABLE or word in words:
            axes.plot([], [], look, label=label or f"adhesive, $w$ = {pretty(show(result.w, 'work'))}", **style)
    changes = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1), len(words)]
    for first, last in itertools.pairwise(changes):  # to the first point of the next part: no gaps
        axes.plot(*line[:, first : last + 1], BRANCHES[str(words[first])][0], markevery=SPACING, **style)
    if curve.places.size > line.shape[1]:  # the full end
        full = [_xy(curve.point(float(place)), units, x, y) for place in (curve.series.rim, curve.places[-1])]
        axes.plot(*np.transpose(full), "-", **style)
    point = result.pull_off["load"]
    if isinstance(point, CriticalPoint):
        axes.plot(*_xy(point, units, x, y), "o", color=plots.BLACK, ms=4, zorder=3, label="pull-off (load control)")


def _xy(points: Any, units: Scales, *names: str) -> Array:
    """The columns ``names`` of a curve or a series, or what a point has of them, in the units of their axes."""
    return np.array([getattr(points, name) / getattr(units, name) for name in names])


def _dwarfed(curve: EquilibriumCurve) -> bool:
    """Whether the largest tension takes less than a fifth of the axis of loads, too little to be read."""
    least, most = float(np.min(curve.P)), float(max(np.max(curve.P), np.max(curve.series.P)))
    return least < 0 and -least < 0.2 * (most - least)


def cycle_figure(columns: Mapping[str, Array], title: str) -> Figure:
    """Load and contact radius over what the device controls (the displacement under load control), jumps dotted.

    ``columns``: as ``device_path.trace`` gives them, with "phase" and "part".
    """
    over = "device_m" if "device_m" in columns else "delta_m"
    soft = not np.allclose(columns[over], columns["delta_m"], rtol=0, atol=1e-9 * np.ptp(columns["delta_m"]))
    name = r"instrument position $\delta + P/k$" if soft else plots.LABELS["delta"]
    with pair(4, pretty(title)) as (figure, panels):
        length, x_unit = unit_of("length", columns[over])
        x = columns[over] / length
        for axes, quantity, column in ((panels[0], "P", "P_N"), (panels[1], "a", "a_m")):
            factor, label = axis_of(quantity, columns[column])
            y = columns[column] / factor
            _phases(axes, x, y, columns)
            axes.axhline(0, color="0.7", lw=0.6, zorder=0)
            axes.set(xlabel=f"{name} ({x_unit})", ylabel=label)
            if quantity == "P" and 0 < -y.min() < 0.2 * np.ptp(y):
                _enlarge_loop(axes, x, y, columns)
        return figure


def _enlarge_loop(axes: Axes, x: Array, y: Array, columns: Mapping[str, Array]) -> None:
    """An inset with the loop in tension, up to as much compression, left of where the loads pass 0.42 of the axis."""
    axes.autoscale_view()
    left, bottom, top = 0.16, 0.52, 0.97
    places = axes.transLimits.transform(np.column_stack([x, y]))
    width = float(np.min(places[places[:, 1] > bottom - 0.1, 0])) - 0.04 - left
    if width < 0.2:
        return
    near = np.abs(y) <= -y.min()
    zoomed = inset(axes, (left, bottom, width, top - bottom), x[near], y[near], 0.08, 7)
    _phases(zoomed, x, y, columns)
    zoomed.axhline(0, color="0.7", lw=0.6, zorder=0)


def _phases(axes: Axes, x: Array, y: Array, columns: Mapping[str, Array]) -> None:
    """One line per part, in the colour of its phase, over a dotted line that shows where the jumps between them lie."""
    axes.plot(x, y, ":", color=plots.BLACK, lw=0.9, label="jump")
    for part in range(1, int(columns["part"][-1]) + 1):
        rows = columns["part"] == part
        colour, width, label = PHASES[str(columns["phase"][rows][0]).removeprefix("free ")]
        axes.plot(x[rows], y[rows], color=colour, lw=width, label=label)


# --------------------------------------------------------------------------------------------------
# Figures of the body: its mesh, the contact zone at one state, pressure and gap along the surface.

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


def profile_figure(columns: Mapping[str, Array], a: float, w: float) -> Figure:
    """Pressure inside, and the surfaces of specimen and indenter around a contact of radius ``a`` [m]."""
    with panelled(plots.WIDE, 3.2, 2) as (figure, [left, right]):
        length, unit = scale(a, "length")
        _pressure(left, columns, a / length, length)
        # Both surfaces, the axis of heights as high as the specimen asks for: the indenter leaves it
        r, (factor, height_unit) = columns["r_m"] / length, unit_of("length", columns["displacement_m"])
        height = -columns["displacement_m"] / factor
        right.plot(r, height, color=plots.BLUE, label="specimen")
        right.plot(r, height + columns["gap_m"] / factor, "--", color=plots.BLACK, label="indenter")
        _edge(right, a / length)
        right.set(ylim=ends(height, 0.1, 0.8), ylabel=f"height ({height_unit})")
        for axes in (left, right):
            axes.set_xlabel(f"$r$ ({pretty(unit)})")
        plots.legend_below(figure, [right], 3)
        figure.suptitle(f"$a$ = {pretty(show(a, 'length'))}, $w$ = {pretty(show(w, 'work'))}")
        return figure


def _pressure(axes: Axes, columns: Mapping[str, Array], a: float, length: float) -> None:
    """The pressure, its axis without what lies close to the edge: there it grows without bound under adhesion."""
    r = columns["r_m"] / length
    seen = r <= 0.98 * a
    factor, unit = unit_of("modulus", columns["pressure_Pa"][seen])
    p = columns["pressure_Pa"] / factor
    axes.axhline(0, color="0.7", lw=0.6)
    axes.plot(r[r < a], p[r < a], color=plots.ORANGE)
    if "shear_Pa" in columns:
        axes.plot(r[r < a], columns["shear_Pa"][r < a] / factor, "--", color=plots.ORANGE, label="shear, outwards")
        axes.legend(frameon=False)
    _edge(axes, a)
    axes.set(ylim=ends(np.append(p[seen], 0.0), 0.1), ylabel=f"contact pressure ({unit})")


def _edge(axes: Axes, a: float) -> None:
    axes.axvline(a, color="0.5", lw=0.8, ls=":", label="edge of the contact")


# --------------------------------------------------------------------------------------------------
# Figures of contacts over time: of a device's history, of adhesion that depends on speed, of viscoelastic bodies.

RATE_PHASES = {
    "advance": (plots.BLUE, "-", "contact line closes"),
    "rest": (plots.GREEN, "--", "contact line pinned"),
    "recede": (plots.ORANGE, "-", "contact line opens"),
    "free": (plots.BLACK, ":", "no contact"),
}
RATE_PANELS = (("delta", "P"), ("t", "P"), ("t", "a"))
LIMIT_MARKERS = ("^", "v", "s")
COLUMNS = {"t": "t_s", "delta": "delta_m", "P": "P_N", "a": "a_m"}


def _runs(columns: Mapping[str, Array]) -> Iterator[tuple[str, slice]]:
    """Rows of one part and phase that follow each other, with the first of the next of the same part: no gaps."""
    phases, parts = columns["phase"], columns["part"]
    changes = np.flatnonzero((phases[1:] != phases[:-1]) | (parts[1:] != parts[:-1])) + 1
    for first, last in itertools.pairwise([0, *changes.tolist(), len(parts)]):
        joined = last < len(parts) and parts[last] == parts[first]
        yield str(phases[first]), slice(first, last + joined)


def history_figure(
    columns: Mapping[str, Array], jumps: Sequence[Jump], title: str, limits: Mapping[str, Equilibrium] | None = None
) -> Figure:
    """Load over displacement, and load and contact radius over time, each phase in its colour and line; where the
    contact ``jumps``, and where it is lost, and the pull-off points of its ``limits`` by their names. ``columns``: as
    ``History.table`` gives them."""
    limits = limits or {}
    with panelled(plots.WIDE, 3.2, len(RATE_PANELS), legend=4 if limits else 6) as (figure, axes):
        for place, names in zip(axes, RATE_PANELS, strict=True):
            (x_unit, x_label), (y_unit, y_label) = (axis_of(name, columns[COLUMNS[name]]) for name in names)
            across, up = (columns[COLUMNS[name]] for name in names)
            for phase, rows in _runs(columns):
                if np.ptp(columns["t_s"][rows]) > 0:
                    rests = phase != "free" and np.ptp(columns["a_m"][rows]) == 0
                    colour, line, words = RATE_PHASES["rest" if rests else phase]
                    place.plot(across[rows] / x_unit, up[rows] / y_unit, line, color=colour, label=words)
            for jump in jumps:
                ends = [jump.start] if jump.end is None else [jump.start, jump.end]
                x, y = (np.array([getattr(end, name) for end in ends]) for name in names)
                lost: dict[str, Any] = {"marker": "x", "ls": "", "label": "contact is lost"}
                look = lost if jump.end is None else {"label": "jump"}
                place.plot(x / x_unit, y / y_unit, color="0.5", **look)
            if "t" not in names:
                for marker, (name, point) in zip(LIMIT_MARKERS, limits.items(), strict=False):
                    x, y = (np.array([getattr(point, quantity)]) for quantity in names)
                    label = f"pull-off {name}"
                    place.plot(x / x_unit, y / y_unit, marker, color=plots.BLACK, mfc="none", label=label)
            place.set(xlabel=x_label, ylabel=y_label)
        figure.suptitle(pretty(title))
        return figure


# --------------------------------------------------------------------------------------------------
# Figures of two results compared.


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

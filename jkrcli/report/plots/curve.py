"""Figures of an adhesive curve, its tension enlarged, and of the trace that a device records along it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...adhesion import CriticalPoint, EquilibriumCurve, branch
from ...adhesion.stability import GRIPPED, STABLE, UNSTABLE
from ...base import Array, show
from ...beside import Analysis
from ..scaling import Scales
from . import Axes, Box, Figure, colors, ends, inset, pair, zero_lines
from .looks import BLACK, BLUE, GREEN, LABELS, ORANGE, axis_of, pretty, unit_of

BRANCHES = {STABLE: ("o-", ""), GRIPPED: ("--", "stable under displacement control only"), UNSTABLE: (":", "unstable")}
PHASES = {  # colour, width and words; the last drawn the thinnest
    "approach": (BLUE, 2.4, "approach"),
    "turn": (GREEN, 1.8, "unloading at constant $a$"),
    "retraction": (ORANGE, 1.1, "retraction"),
}
SPACING = 0.06  # between markers, of the diagonal of the axes
PANELS: tuple[tuple[str, str, Box], ...] = (  # x, y, and where no curve passes: P(delta) is convex, a(P) concave
    ("delta", "P", (0.13, 0.53, 0.42, 0.45)),
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
                _enlarge(axes, result, units, x, y, empty)
        return figure


def curves_figure(results: Sequence[Analysis], units: Scales) -> Figure:
    """The adhesive curves of one body for several works of adhesion over its nonadhesive one: their tension and three
    times as much compression, where the loads of the series dwarf it."""
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
    axes.plot(*_xy(curve.series, units, x, y), "s-", color=BLUE, ms=3, mfc="none", lw=1.0, markevery=SPACING,
              label=f"nonadhesive ({result.solution.method})")  # fmt: skip
    _band(axes, curve, units, x, y)
    _by_stability(axes, result, units, x, y)
    point = result.pull_off["load"]
    if isinstance(point, CriticalPoint):
        axes.plot(*_xy(point, units, x, y), "o", color=BLACK, ms=4, zorder=3, label="pull-off (load control)")


def _xy(points: Any, units: Scales, *names: str) -> Array:
    """The columns ``names`` of a curve or a series, or what a point has of them, in the units of their axes."""
    return np.array([getattr(points, name) / getattr(units, name) for name in names])


def _band(axes: Axes, curve: EquilibriumCurve, units: Scales, x: str, y: str) -> None:
    """The 90 % band of P, where its half-width is a hundredth of the axis, enough to be seen."""
    if not curve.errors or np.max(curve.errors["P"]) < 0.01 * np.ptp(curve.P):
        return
    limits = [(curve.P + sign * curve.errors["P"]) / units.P for sign in (-1, 1)]
    style: dict[str, Any] = {"color": ORANGE, "alpha": 0.25, "lw": 0, "label": "90 % band of $P$"}
    along, fill = (x, axes.fill_between) if y == "P" else (y, axes.fill_betweenx)
    fill(*_xy(curve, units, along), *limits, **style)


def _by_stability(axes: Axes, result: Analysis, units: Scales, x: str, y: str) -> None:
    """Solid where stable under any control, dashed where only a stiff device holds the contact, dotted where none."""
    line, words = _xy(result.curve, units, x, y), branch(result.curve)
    style: dict[str, Any] = {"color": ORANGE, "ms": 3, "mfc": "none", "lw": 1.2}
    for word, (look, label) in BRANCHES.items():
        if word == STABLE or word in words:
            axes.plot([], [], look, label=label or f"adhesive, $w$ = {pretty(show(result.w, 'work'))}", **style)
    changes = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1), len(words)]
    for first, last in itertools.pairwise(changes):  # to the first point of the next part: no gaps
        axes.plot(*line[:, first : last + 1], BRANCHES[str(words[first])][0], markevery=SPACING, **style)


def _dwarfed(curve: EquilibriumCurve) -> bool:
    """Whether the largest tension takes less than a fifth of the axis of loads, too little to be read."""
    least, most = float(np.min(curve.P)), float(max(np.max(curve.P), np.max(curve.series.P)))
    return least < 0 and -least < 0.2 * (most - least)


def _enlarge(axes: Axes, result: Analysis, units: Scales, x: str, y: str, place: Box) -> None:
    """An inset with the loads between the largest tension and as much compression."""
    curve = result.curve
    near = np.abs(curve.P) <= -np.min(curve.P)
    across, up = _xy(curve, units, x, y)[:, near]
    _draw(inset(axes, place, across, up, 0.1, 7), result, units, x, y)


def cycle_figure(columns: Mapping[str, Array], title: str) -> Figure:
    """Load and contact radius over what the device controls (the displacement under load control), jumps dotted.

    ``columns``: as ``stability.trace`` gives them, with "phase" and "part".
    """
    over = "device_m" if "device_m" in columns else "delta_m"
    soft = not np.array_equal(columns[over], columns["delta_m"])
    name = r"device position $\delta + P/k$" if soft else LABELS["delta"]
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
    axes.plot(x, y, ":", color=BLACK, lw=0.9, label="jump")
    for part in range(1, int(columns["part"][-1]) + 1):
        rows = columns["part"] == part
        colour, width, label = PHASES[str(columns["phase"][rows][0]).removeprefix("free ")]
        axes.plot(x[rows], y[rows], color=colour, lw=width, label=label)

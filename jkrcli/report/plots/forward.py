"""Figures of an adhesive curve, its tension enlarged, and of the trace that a device records along it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

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
    ends,
    inset,
    pair,
    panelled,
    pretty,
    unit_of,
    zero_lines,
)

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
# Pressure and gap along the surface at one state.


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

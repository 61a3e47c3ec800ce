"""The one door to matplotlib: figures fit for print, built without pyplot and without global state."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from . import __version__
from .adhesion import AdhesiveCurve, CriticalPoint
from .analysis import Analysis
from .files import atomic
from .scaling import Scales
from .series import Array
from .stability import GRIPPED, STABLE, UNSTABLE, branch
from .units import scale, show

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "svg.hashsalt": "jkr",
    "svg.fonttype": "path",
}
# Okabe and Ito's palette: told apart by colour-blind readers, and by line style in grey.
BLUE, ORANGE, GREEN, BLACK = "#0072B2", "#D55E00", "#009E73", "#000000"
BRANCHES = {STABLE: "o-", GRIPPED: "--", UNSTABLE: ":"}


@dataclass(frozen=True)
class Units:
    """What an axis is divided by, and its labels: delta, P, a."""

    delta: float
    P: float
    a: float
    labels: tuple[str, str, str]


def physical_units(curve: AdhesiveCurve) -> Units:
    """People's units, chosen by the magnitude of the curve."""
    delta, delta_unit = scale(float(np.max(np.abs(curve.delta))), "length")
    P, P_unit = scale(float(np.max(np.abs(curve.P))), "load")
    a, a_unit = scale(float(curve.a[-1]), "length")
    labels = (f"displacement δ ({pretty(delta_unit)})", f"load P ({pretty(P_unit)})",
              f"contact radius a ({pretty(a_unit)})")  # fmt: skip
    return Units(delta, P, a, labels)


def units_of(scales: Scales) -> Units:
    """The axes of a dimensionless curve."""
    return Units(scales.delta, scales.P, scales.a, scales.labels)


def curve_figure(result: Analysis, units: Units) -> Figure:
    """The paper's Fig. 5: load over displacement and contact radius over load, nonadhesive and adhesive."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        _panel_load(left, result, units)
        _panel_radius(right, result, units)
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        return figure


def _panel_load(axes: Axes, result: Analysis, units: Units) -> None:
    curve = result.curve
    _lines(axes, units, (curve.series.delta / units.delta, curve.series.P / units.P),
           (curve.delta / units.delta, curve.P / units.P), result)  # fmt: skip
    if curve.errors:
        low, high = (curve.P - curve.errors["P"]) / units.P, (curve.P + curve.errors["P"]) / units.P
        axes.fill_between(curve.delta / units.delta, low, high, color=ORANGE, alpha=0.2, lw=0, label="90 % band of P")
    if result.comparison is not None:
        exact = result.comparison.exact
        shown = exact.a <= curve.a[-1]
        _exact(axes, exact.series.delta[shown] / units.delta, exact.series.P[shown] / units.P, "closed form")
        _exact(axes, exact.delta[shown] / units.delta, exact.P[shown] / units.P)
    point = result.pull_off["load"]
    if isinstance(point, CriticalPoint):
        axes.plot(point.delta / units.delta, point.P / units.P, "o", color=BLACK, ms=4, label="pull-off (load control)")
    axes.set_xlabel(units.labels[0])
    axes.set_ylabel(units.labels[1])


def _panel_radius(axes: Axes, result: Analysis, units: Units) -> None:
    curve = result.curve
    a = curve.a / units.a
    _lines(axes, units, (curve.series.P / units.P, a), (curve.P / units.P, a), result)
    if result.comparison is not None:
        exact = result.comparison.exact
        shown = exact.a <= curve.a[-1]
        _exact(axes, exact.series.P[shown] / units.P, exact.a[shown] / units.a)
        _exact(axes, exact.P[shown] / units.P, exact.a[shown] / units.a)
    point = result.pull_off["load"]
    if isinstance(point, CriticalPoint):
        axes.plot(point.P / units.P, point.a / units.a, "o", color=BLACK, ms=4)
    axes.set_xlabel(units.labels[1])
    axes.set_ylabel(units.labels[2])


def _lines(axes: Axes, units: Units, nonadhesive: tuple[Array, Array], adhesive: tuple[Array, Array],
           result: Analysis) -> None:  # fmt: skip
    axes.axhline(0, color="0.7", lw=0.6)
    axes.axvline(0, color="0.7", lw=0.6)
    every = max(1, len(nonadhesive[0]) // 40)
    style: dict[str, Any] = {"ms": 3, "markevery": every, "lw": 1.0}
    axes.plot(*nonadhesive, "s--", color=BLUE, mfc="none", label=f"nonadhesive ({result.stored.method})", **style)
    style |= {"color": ORANGE, "mfc": "none"}
    axes.plot([], [], "o-", label=f"adhesive, w = {pretty(show(result.w, 'work'))}", **style)
    _by_stability(axes, adhesive, branch(result.curve), style)


def _by_stability(axes: Axes, line: tuple[Array, Array], words: Array, style: Mapping[str, Any]) -> None:
    """Solid where stable under any control, dashed where only a stiff device holds the contact, dotted where none."""
    labels = {GRIPPED: "stable under displacement control only", UNSTABLE: "unstable"}
    ends = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1), len(words)]
    for first, last in itertools.pairwise(ends):
        part = slice(first, last + 1)  # to the first point of the next part: no gaps
        word = str(words[first])
        axes.plot(line[0][part], line[1][part], BRANCHES[word], label=labels.pop(word, None), **style)


def _exact(axes: Axes, x: Array, y: Array, label: str | None = None) -> None:
    axes.plot(x, y, "-", color=BLACK, lw=0.8, label=label, zorder=1)


def pretty(text: str) -> str:
    """Units as they are typeset."""
    return text.replace("^2", "²").replace("um", "µm").replace("uN", "µN").replace("uJ", "µJ")


def save(figure: Figure, path: Path) -> None:
    """Write a figure atomically; PNG or SVG by the ending, reproducible to the byte, marked as ours."""
    mark = f"jkr {__version__}"
    metadata = {"Software": mark} if path.suffix == ".png" else {"Creator": mark, "Date": None}
    with mpl.rc_context(STYLE), atomic(path) as temporary:
        FigureCanvasAgg(figure)
        figure.savefig(temporary, dpi=200, metadata=metadata)

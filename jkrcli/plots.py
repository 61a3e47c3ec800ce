"""The one door to matplotlib: figures fit for print, built without pyplot and without global state."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from . import __version__
from .adhesion import AdhesiveCurve, CriticalPoint, scales_half_space, scales_thin_layer
from .analysis import Analysis
from .closed_form import foundation_modulus
from .differences import Difference
from .errors import InputError
from .fem.grid import Grid
from .files import atomic
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
    labels = (f"displacement δ ({_pretty(delta_unit)})", f"load P ({_pretty(P_unit)})",
              f"contact radius a ({_pretty(a_unit)})")  # fmt: skip
    return Units(delta, P, a, labels)


def dimensionless_units(result: Analysis, scaling: str) -> Units:
    """The axes of Eq. 15 ("half-space") or Eq. 19 ("thin-layer")."""
    problem, w = result.case.problem, result.w
    R = problem.indenter.tip_radius
    if R is None or w == 0:
        raise InputError("--dimensionless: needs an indenter with a tip radius and w > 0")
    if scaling == "half-space":
        P, delta, a = scales_half_space(R, problem.E_star, w)
        return Units(delta, P, a, ("δ / δ₀  (Eq. 15)", "P / (π w R)", "a / a₀  (Eq. 15)"))
    if not problem.specimen.layers or problem.specimen.surface.nu >= 0.5:
        raise InputError("--dimensionless thin-layer: needs a layer with nu < 0.5 (Eq. 22)")
    top = problem.specimen.layers[0]
    K = foundation_modulus(top.material.E, top.material.nu, top.thickness)
    P, delta, a = scales_thin_layer(R, K, w)
    return Units(delta, P, a, ("δ / √(2w/K)", "P / (2 π w R)", "a / (8 w R²/K)^¼"))


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
    if result.comparison is not None:
        exact = result.comparison.exact
        _exact(axes, exact.series.delta / units.delta, exact.series.P / units.P, "closed form")
        _exact(axes, exact.delta / units.delta, exact.P / units.P)
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
        _exact(axes, exact.series.P / units.P, exact.a / units.a)
        _exact(axes, exact.P / units.P, exact.a / units.a)
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
    axes.plot([], [], "o-", label=f"adhesive, w = {_pretty(show(result.w, 'work'))}", **style)
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


def _pretty(text: str) -> str:
    """Units as they are typeset."""
    return text.replace("^2", "²").replace("um", "µm").replace("uN", "µN").replace("uJ", "µJ")


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
    axes.set_xlabel(f"r ({_pretty(unit)})")
    axes.set_ylabel(f"z ({_pretty(unit)})")


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
        left.set_xlabel(f"r ({_pretty(unit)})")
        left.set_ylabel(f"contact pressure ({_pretty(stress_unit)})")
        height, height_unit = scale(float(np.max(np.abs(columns["displacement_m"]))), "length")
        right.plot(r / length, -columns["displacement_m"] / height, color=BLUE, label="specimen")
        right.plot(
            r / length, (columns["gap_m"] - columns["displacement_m"]) / height, "--", color=BLACK, label="indenter"
        )
        right.axvline(a / length, color="0.5", lw=0.8, ls=":")
        right.set_xlabel(f"r ({_pretty(unit)})")
        right.set_ylabel(f"height ({_pretty(height_unit)})")
        right.legend()
        figure.suptitle(f"a = {_pretty(show(a, 'length'))}, w = {_pretty(show(w, 'work'))}")
        return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure atomically; PNG or SVG by the ending, reproducible to the byte, marked as ours."""
    mark = f"jkr {__version__}"
    metadata = {"Software": mark} if path.suffix == ".png" else {"Creator": mark, "Date": None}
    with mpl.rc_context(STYLE), atomic(path) as temporary:
        FigureCanvasAgg(figure)
        figure.savefig(temporary, dpi=200, metadata=metadata)

"""Figures of a fit: the curve over its data, the residuals along it, the joint confidence region of E* and w."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...base import Array, scale
from ...identification.fit import Fit, rise
from . import (
    BLACK,
    BLUE,
    GREEN,
    LABELS,
    LARGER,
    MIDDLE,
    ORANGE,
    SKY,
    WIDE,
    Axes,
    Figure,
    drawing,
    enlarged,
    legend_below,
    pretty,
    unit_of,
)

DIMENSIONS = {"a": "length", "delta": "length", "P": "load"}
AXES = {"delta,P": ("delta", "P"), "a,P": ("P", "a"), "a,delta": ("delta", "a"), "a,delta,P": ("delta", "P")}
MARKS = {"a": (GREEN, "s"), "delta": (BLUE, "^"), "P": (ORANGE, "o")}


BESIDE = 0.6  # choice: width of the rows out of contact, beside the others, in largest contact radii


def fit_figure(found: Fit) -> Figure:
    """Three panels, or two where the data tell no joint region of E* and w."""
    region = found.covariance is not None and {"modulus", "w"} <= set(found.free)
    with drawing(WIDE if region else MIDDLE, 2.8) as figure:
        panels = figure.subplots(1, 3 if region else 2)
        _curve(panels[0], found)
        _residuals(panels[1], found)
        if region:
            _region(panels[2], found)
        legend_below(figure, panels, 5)
        return figure


def _curve(axes: Axes, found: Fit) -> None:
    x, y = AXES[",".join(found.data)]
    units = {name: unit_of(DIMENSIONS[name], found.data[name]) for name in (x, y)}
    measured = [found.data[name] / units[name][0] for name in (x, y)]
    near = near_rows(found)
    line = [_broken(found.line[name][near] / units[name][0], found.line["a"][near]) for name in (x, y)]
    places = [axes]
    touched = found.a > 0
    if touched.any() and np.ptp(measured[0][touched]) < LARGER * np.ptp(measured[0]):
        across, up = measured
        level = (float(np.median(up[~touched])) - up.min()) / np.ptp(up)
        places.append(enlarged(axes, across[touched], up[touched], 0.05 + 0.9 * level))
    for place in places:
        place.plot(*measured, "o", color=SKY, ms=3, mfc="none", label="measured")
        place.plot(*line, "-", color=BLACK, lw=1.0, label="fitted")
    axes.set_xlabel(f"{LABELS[x]} ({units[x][1]})")
    axes.set_ylabel(f"{LABELS[y]} ({units[y][1]})")


def near_rows(found: Fit) -> Array:
    """Where the fitted line runs along the rows, not far beyond them."""
    return np.asarray(found.line["a"] <= 1.02 * found.a.max())


def _broken(values: Array, a: Array) -> Array:
    """A fitted line without its jumps: a gap wherever contact begins or ends."""
    return np.insert(values, np.flatnonzero(np.diff((a > 0).astype(int))) + 1, np.nan)


def _distance(found: Fit) -> str:
    """What one residual per row is: of raw records all scatter is in the load."""
    return "normal distance" if found.quality is None else LABELS["P"]


def _residuals(axes: Axes, found: Fit) -> None:
    factor, unit = unit_of("length", found.a)
    free, places = found.a == 0, found.a / factor
    places[free] = places.max() * BESIDE * (np.linspace(-1, 0, int(free.sum()) + 1)[:-1])
    names = [_distance(found)] if found.residuals.shape[0] == 1 else [LABELS[name] for name in found.data]
    marks = [MARKS["delta"]] if len(names) == 1 else [MARKS[name] for name in found.data]
    for values, name, (colour, mark) in zip(found.residuals, names, marks, strict=True):
        axes.plot(places, values / (found.scatter or 1.0), mark, color=colour, ms=3, mfc="none", label=name)
    axes.axhline(0, color="0.6", lw=0.8, zorder=0)
    if free.any():
        axes.axvline(0, color="0.6", lw=0.8)
        axes.set_xticks([tick for tick in axes.get_xticks() if 0 <= tick <= places.max() * 1.05])
        middle = BESIDE / (1 + BESIDE) / 2
        axes.annotate("base line", (middle, 1.0), xycoords="axes fraction", ha="center", va="bottom",
                      size=7, color="0.4")  # fmt: skip
    axes.set_xlabel(f"{LABELS['a']} ({unit})")
    axes.set_ylabel("residual / standard deviation")


def _region(axes: Axes, found: Fit) -> None:
    """Border of the joint region of E* and w from the covariance; the bootstrap's values where there are any."""
    rows = [found.free.index(name) for name in ("modulus", "w")]
    assert found.covariance is not None
    covariance = found.covariance[np.ix_(rows, rows)]
    factor = found.value("E_star") / found.value("modulus")
    E_unit, w_unit = scale(found.value("E_star"), "modulus"), scale(found.value("w"), "work")
    if found.samples is not None:
        E, w = found.samples[:, rows[0]] * factor / E_unit[0], found.samples[:, rows[1]] / w_unit[0]
        axes.plot(E, w, ".", color="0.6", ms=2, label="bootstrap")
    radius = np.sqrt(found.dof * rise(found.settings.level, found.dof, 2))
    E, w = _ellipse(covariance, radius)
    E, w = (found.value("modulus") + E) * factor / E_unit[0], (found.value("w") + w) / w_unit[0]
    axes.plot(E, w, "-", color=ORANGE, label=f"{found.settings.level * 100:g} % region")
    axes.plot(found.value("E_star") / E_unit[0], found.value("w") / w_unit[0], "+", color=BLUE, ms=8)
    axes.set_xlabel(f"$E^*$ ({pretty(E_unit[1])})")
    axes.set_ylabel(f"work of adhesion $w$ ({pretty(w_unit[1])})")
    axes.ticklabel_format(useOffset=False)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def _ellipse(covariance: Array, radius: float) -> tuple[Array, Array]:
    """Points of the ellipse that lies ``radius`` standard deviations around zero."""
    angle = np.linspace(0, 2 * np.pi, 200)
    size = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(size, size) + 1e-14 * np.eye(2))
    x, y = radius * size[:, None] * (root @ np.stack([np.cos(angle), np.sin(angle)]))
    return x, y

"""Figures of a fit: the curve over its data, the residuals along it, the joint confidence region of E* and w; and
of records fitted together, all of them from their own zeros, each with the curve that they share."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...base import Array
from ...identification.fit import Fit, JointFit, rise
from . import Axes, Figure, enlarged, panelled
from .looks import BLACK, BLUE, COLORS, GREEN, LABELS, LARGER, MIDDLE, ORANGE, SKY, WIDE, axis_of, pretty

AXES = {"delta,P": ("delta", "P"), "a,P": ("P", "a"), "a,delta": ("delta", "a"), "a,delta,P": ("delta", "P")}
MARKS = {"a": (GREEN, "s"), "delta": (BLUE, "^"), "P": (ORANGE, "o")}


def fit_figure(fit: Fit) -> Figure:
    """Three panels, or two where the data tell no joint region of E* and w."""
    region = fit.covariance is not None and {"modulus", "w"} <= set(fit.free)
    with panelled(WIDE if region else MIDDLE, 2.8, 3 if region else 2, legend=5) as (figure, panels):
        _curve(panels[0], fit)
        _residuals(panels[1], fit)
        if region:
            _region(panels[2], fit)
        return figure


def _curve(axes: Axes, fit: Fit) -> None:
    x, y = AXES[",".join(fit.data)]
    units, labels = zip(*(axis_of(name, fit.data[name]) for name in (x, y)), strict=True)
    measured = [fit.data[name] / unit for name, unit in zip((x, y), units, strict=True)]
    near = _near_rows(fit)
    line = [_broken(fit.line[name][near] / unit, fit.line["a"][near])
            for name, unit in zip((x, y), units, strict=True)]  # fmt: skip
    places = [axes]
    touched = fit.a > 0
    if touched.any() and np.ptp(measured[0][touched]) < LARGER * np.ptp(measured[0]):
        across, up = measured
        level = (float(np.median(up[~touched])) - up.min()) / np.ptp(up)
        places.append(enlarged(axes, across[touched], up[touched], 0.05 + 0.9 * level))
    for place in places:
        place.plot(*measured, "o", color=SKY, ms=3, mfc="none", label="measured")
        place.plot(*line, "-", color=BLACK, lw=1.0, label="fitted")
    axes.set(xlabel=labels[0], ylabel=labels[1])


def _near_rows(fit: Fit) -> Array:
    """Where the fitted line runs along the rows, not far beyond them."""
    return np.asarray(fit.line["a"] <= 1.02 * fit.a.max())


def _broken(values: Array, a: Array) -> Array:
    """A fitted line without its jumps: a gap wherever contact begins or ends."""
    return np.insert(values, np.flatnonzero(np.diff((a > 0).astype(int))) + 1, np.nan)


def _residuals(axes: Axes, fit: Fit) -> None:
    factor, label = axis_of("a", fit.a)
    free, places, beside = fit.a == 0, fit.a / factor, 0.6  # choice: width of the rows out of contact, in largest radii
    places[free] = places.max() * beside * (np.linspace(-1, 0, int(free.sum()) + 1)[:-1])
    alone = "normal distance" if fit.quality is None else LABELS["P"]  # of raw records all scatter is in the load
    names = [alone] if fit.residuals.shape[0] == 1 else [LABELS[name] for name in fit.data]
    marks = [MARKS["delta"]] if len(names) == 1 else [MARKS[name] for name in fit.data]
    for values, name, (colour, mark) in zip(fit.residuals, names, marks, strict=True):
        axes.plot(places, values / (fit.scatter or 1.0), mark, color=colour, ms=3, mfc="none", label=name)
    axes.axhline(0, color="0.6", lw=0.8, zorder=0)
    if free.any():
        axes.axvline(0, color="0.6", lw=0.8)
        axes.set_xticks([tick for tick in axes.get_xticks() if 0 <= tick <= places.max() * 1.05])
        middle = beside / (1 + beside) / 2
        axes.annotate("base line", (middle, 1.0), None, "axes fraction", ha="center", va="bottom", size=7, color="0.4")
    axes.set(xlabel=label, ylabel="residual / standard deviation")


def _region(axes: Axes, fit: Fit) -> None:
    """Border of the joint region of E* and w from the covariance; the bootstrap's values where there are any."""
    rows = [fit.free.index(name) for name in ("modulus", "w")]
    assert fit.covariance is not None
    covariance = fit.covariance[np.ix_(rows, rows)]
    (E_unit, E_label), (w_unit, w_label) = (axis_of(name, fit.value(name)) for name in ("E_star", "w"))
    factor = fit.value("E_star") / fit.value("modulus") / E_unit
    if fit.samples is not None:
        E, w = fit.samples[:, rows[0]] * factor, fit.samples[:, rows[1]] / w_unit
        axes.plot(E, w, ".", color="0.6", ms=2, label="bootstrap")
    radius = np.sqrt(fit.dof * rise(fit.settings.level, fit.dof, 2))
    E, w = _ellipse(covariance, radius)
    E, w = (fit.value("modulus") + E) * factor, (fit.value("w") + w) / w_unit
    axes.plot(E, w, "-", color=ORANGE, label=f"{fit.settings.level * 100:g} % region")
    axes.plot(fit.value("E_star") / E_unit, fit.value("w") / w_unit, "+", color=BLUE, ms=8)
    axes.set(xlabel=E_label, ylabel=w_label)
    axes.ticklabel_format(useOffset=False)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def _ellipse(covariance: Array, radius: float) -> tuple[Array, Array]:
    """Points of the ellipse that lies ``radius`` standard deviations around zero."""
    angle = np.linspace(0, 2 * np.pi, 200)
    size = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(size, size) + 1e-14 * np.eye(2))
    x, y = radius * size[:, None] * (root @ np.stack([np.cos(angle), np.sin(angle)]))
    return x, y


def joint_figure(joint: JointFit) -> Figure:
    """All records over their fitted curves."""
    x, y = AXES[",".join(joint.fits[0].data)]
    together = [one for one in joint.fits if {x, y} <= set(one.data)]
    factors, labels = zip(*(
        axis_of(name, *(np.ptp(one.data[name][one.a > 0]) for one in together)) for name in (x, y)
    ), strict=True)  # fmt: skip
    with panelled(MIDDLE, 2.8, legend=4) as (figure, [axes]):
        for i, one in enumerate(together):
            zeros = [_zero(one, name) for name in (x, y)]
            near = [one.data[name][one.a > 0] for name in (x, y)]
            touching = (one.line["a"] > 0) & _near_rows(one)
            line = [np.where(touching, one.line[name], np.nan) for name in (x, y)]
            read, curve = ([(v - o) / f for v, o, f in zip(p, zeros, factors, strict=True)] for p in (near, line))
            axes.plot(*read, "o", color=COLORS[i % len(COLORS)], ms=3, mfc="none", label=pretty(one.name))
            axes.plot(*curve, "-", color=BLACK, lw=1.0, label="fitted" if one is together[-1] else None)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        return figure


def _zero(one: Fit, name: str) -> float:
    """The zero point of a column [SI]."""
    zeros = [item.value for item in one.estimates if item.name == {"delta": "delta0", "P": "P0"}.get(name)]
    return zeros[0] if zeros else 0.0

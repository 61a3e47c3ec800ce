"""The figure of records fitted together: all of them from their own zeros, each with the curve that they share."""

from __future__ import annotations

import numpy as np

from ...base import scale
from ...identification.fit import Fit, JointFit
from . import BLACK, COLORS, LABELS, MIDDLE, Figure, drawing, legend_below, pretty
from .fit import AXES, DIMENSIONS, near_rows

ZEROS = {"delta": "delta0", "P": "P0"}


def joint_figure(found: JointFit) -> Figure:
    """All records over their fitted curves."""
    x, y = AXES[",".join(found.fits[0].data)]
    together = [one for one in found.fits if {x, y} <= set(one.data)]
    sizes = {name: max(float(np.ptp(one.data[name][one.a > 0])) for one in together) for name in (x, y)}
    units = {name: scale(sizes[name], DIMENSIONS[name]) for name in (x, y)}
    with drawing(MIDDLE, 2.8) as figure:
        axes = figure.subplots()
        for i, one in enumerate(together):
            zeros = [_zero(one, name) for name in (x, y)]
            factors = [units[name][0] for name in (x, y)]
            near = [one.data[name][one.a > 0] for name in (x, y)]
            kept = (one.line["a"] > 0) & near_rows(one)
            line = [np.where(kept, one.line[name], np.nan) for name in (x, y)]
            read, curve = ([(v - o) / f for v, o, f in zip(p, zeros, factors, strict=True)] for p in (near, line))
            axes.plot(*read, "o", color=COLORS[i % len(COLORS)], ms=3, mfc="none", label=pretty(one.name))
            axes.plot(*curve, "-", color=BLACK, lw=1.0, label="fitted" if one is together[-1] else None)
        axes.set_xlabel(f"{LABELS[x]} ({pretty(units[x][1])})")
        axes.set_ylabel(f"{LABELS[y]} ({pretty(units[y][1])})")
        legend_below(figure, [axes], 4)
        return figure


def _zero(one: Fit, name: str) -> float:
    """The zero point of a column [SI]."""
    held = [item.value for item in one.estimates if item.name == ZEROS.get(name)]
    return held[0] if held else 0.0

"""The figure of records fitted together: all of them from their own zeros, each with the curve that they share."""

from __future__ import annotations

import numpy as np

from ...identification.fit import Fit, JointFit
from . import Figure, panelled
from .fit import AXES, near_rows
from .looks import BLACK, COLORS, MIDDLE, axis_of, pretty

ZEROS = {"delta": "delta0", "P": "P0"}


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
            touching = (one.line["a"] > 0) & near_rows(one)
            line = [np.where(touching, one.line[name], np.nan) for name in (x, y)]
            read, curve = ([(v - o) / f for v, o, f in zip(p, zeros, factors, strict=True)] for p in (near, line))
            axes.plot(*read, "o", color=COLORS[i % len(COLORS)], ms=3, mfc="none", label=pretty(one.name))
            axes.plot(*curve, "-", color=BLACK, lw=1.0, label="fitted" if one is together[-1] else None)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        return figure


def _zero(one: Fit, name: str) -> float:
    """The zero point of a column [SI]."""
    zeros = [item.value for item in one.estimates if item.name == ZEROS.get(name)]
    return zeros[0] if zeros else 0.0

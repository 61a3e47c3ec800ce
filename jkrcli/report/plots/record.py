"""Figures of measured records: directions, base lines, touch, jumps and adhesion as they were found."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...base.arrays import Array
from ...base.units import scale
from ...base.unknown import Unknown
from ...data.record import Direction, ForceCurve
from . import BLACK, BLUE, ORANGE, PURPLE, WIDE, Axes, Figure, drawing, legend_below, pretty

MOST_PANELS, MOST_POINTS = 12, 2000  # choice: of a figure, and of a segment in it
COLOURS, GREY = {"approach": BLUE, "retract": ORANGE}, "0.6"


def record_figure(records: Sequence[ForceCurve]) -> Figure:
    """Load over displacement, a panel per curve; of many curves ``MOST_PANELS`` spread evenly."""
    every = np.unique(np.linspace(0, len(records) - 1, min(len(records), MOST_PANELS)).round().astype(int))
    shown = [records[i] for i in every]
    columns = math.ceil(math.sqrt(len(shown)))
    rows = math.ceil(len(shown) / columns)
    with drawing(WIDE, max(3.6, 2.2 * rows + 0.6)) as figure:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, record in zip(panels, shown, strict=False):
            _panel(panel, record)
        for panel in panels[len(shown) :]:
            panel.set_axis_off()
        legend_below(figure, panels[: len(shown)], 4)
        return figure


def _panel(axes: Axes, record: ForceCurve) -> None:
    curve = record.curve
    assert curve.P is not None
    z = curve.device
    (x, length), (y, load) = _unit(z, "length"), _unit(curve.P, "load")
    for segment in record.segments:
        thin = slice(segment.first, segment.last + 1, 1 + len(segment) // MOST_POINTS)
        axes.plot(z[thin] / x, curve.P[thin] / y, lw=1.0, label=segment.kind,
                  color=COLOURS.get(segment.kind, GREY))  # fmt: skip
    for item in record.directions:
        _marks(axes, item, z[item.segment.rows], x, y)
    axes.set_title(": ".join([curve.name, ", ".join(record.flags)]).rstrip(": "), loc="left", fontsize="small")
    what = "displacement" if curve.stiffness is None else "position of the device"
    axes.set_xlabel(f"{what} ({length})")
    axes.set_ylabel(f"load ({load})")


def _unit(values: Array, dimension: str) -> tuple[float, str]:
    """The unit in which the range of ``values`` reads well, in SI and as it is typeset."""
    factor, unit = scale(float(np.max(np.abs(values))), dimension)
    return factor, pretty(unit)


def _marks(axes: Axes, item: Direction, position: Array, x: float, y: float) -> None:
    """Base line, touch, adhesion and jumps of one direction; lengths in ``x`` [m], loads in ``y`` [N]."""
    if not item.based:
        return
    ends = np.array([position.min(), position.max()])
    axes.plot(ends / x, item.base(ends) / y, color=BLACK, ls="--", lw=0.7, label="base line")
    if not isinstance(item.touch, Unknown):
        level = float(item.base(np.array(item.touch)))
        axes.errorbar(item.touch / x, level / y, xerr=item.touch_err / x, fmt="o", ms=4, mfc="none", color=BLACK,
                      label="contact begins or ends")  # fmt: skip
    if not isinstance(item.adhesion, Unknown):
        level = float(item.base(np.array(item.adhesion_at))) - item.adhesion
        axes.plot(item.adhesion_at / x, level / y, "v", ms=5, color=BLACK, mfc="none", label="adhesion force")
    for jump in item.jumps:
        axes.axvline(jump.position / x, color=PURPLE, lw=0.8, ls=":", label="jump")

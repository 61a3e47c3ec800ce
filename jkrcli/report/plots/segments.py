"""Figures of measured records: directions, base lines, touch, jumps and adhesion as they were found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import fill

import numpy as np

from ...base import DRAWN, Array, Unknown
from ...data import Direction, ForceCurve
from . import Axes, Figure, enlarged, panelled
from .looks import BLACK, BLUE, LARGER, ORANGE, PURPLE, WIDE, unit_of

LETTERS = round(WIDE * 72 / 6)  # of a line as wide as the figure; theory: one of 9 points is 6 wide, with its gap
LOOKS, GREY = {"approach": (BLUE, 2.0), "retract": (ORANGE, 0.9)}, "0.6"  # the last drawn the thinnest


def record_figure(records: Sequence[ForceCurve]) -> Figure:
    """Load over displacement, a panel per curve; of many curves twelve spread evenly.

    All panels have the same units, told once along each side of the figure.
    """
    every = np.unique(np.linspace(0, len(records) - 1, min(len(records), 12)).round().astype(int))
    shown = [records[i] for i in every]
    columns = math.ceil(math.sqrt(len(shown)))
    rows = math.ceil(len(shown) / columns)
    (x, length), (y, load) = (
        unit_of(dimension, *(getattr(record.curve, name) for record in shown))
        for name, dimension in (("device", "length"), ("P", "load"))
    )
    with panelled(WIDE, max(3.6, 2.2 * rows + 0.6), len(shown), columns, legend=4) as (figure, panels):
        for i, (panel, record) in enumerate(zip(panels, shown, strict=False)):
            _panel(panel, record, x, y, round(LETTERS / columns))
            what = "displacement" if record.curve.stiffness is None else "position z of the device"
            panel.set_xlabel(fill(f"{what} ({length})", LETTERS // columns) if i + columns >= len(shown) else "")
            panel.set_ylabel(f"load ({load})" if i % columns == 0 else "")
        return figure


def _panel(axes: Axes, record: ForceCurve, x: float, y: float, letters: int) -> None:
    """One record, lengths in ``x`` [m], loads in ``y`` [N], under a title of lines of up to so many ``letters``."""
    curve = record.curve
    assert curve.P is not None
    z = curve.device
    near = _contact(record, z) if letters == LETTERS else None  # there is room in a panel of the whole width
    places = [axes]
    if near is not None:
        level = (float(np.median(curve.P[~near])) - curve.P.min()) / np.ptp(curve.P)
        places.append(enlarged(axes, z[near] / x, curve.P[near] / y, 0.05 + 0.9 * level))
    broken = _broken(record)
    for place in places:
        for segment in record.segments:
            thin = slice(segment.first, segment.last + 1, 1 + len(segment) // DRAWN)
            colour, width = LOOKS.get(segment.kind, (GREY, 1.0))
            place.plot(z[thin] / x, broken[thin] / y, lw=width, label=segment.kind, color=colour)
        for item in record.directions:
            _marks(place, item, z[item.segment.rows], x, y)
    title = ": ".join([curve.name, ", ".join(record.flags)]).rstrip(": ")
    axes.set_title(fill(title, letters, max_lines=3, placeholder=" …"), loc="left", fontsize="small")


def _broken(record: ForceCurve) -> Array:
    """The loads [N] of a record, the line through them broken at its jumps: the row before the steepest step is nan."""
    assert record.curve.P is not None
    P = record.curve.P.copy()
    for row in [jump.row for item in record.directions for jump in (*item.jumps, *item.steps)]:
        first = max(row - 3, 0)
        steps = np.abs(np.diff(record.curve.P[first : row + 3 + 1]))
        P[first + int(np.argmax(steps))] = np.nan
    return P


def _contact(record: ForceCurve, z: Array) -> Array | None:
    """The rows from the outermost touch on, where the free way is so long that they are drawn once more, larger."""
    touches = [item.touch for item in record.directions if isinstance(item.touch, float)]
    if not touches or z.max() - min(touches) >= LARGER * np.ptp(z):
        return None
    return z >= min(touches)


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

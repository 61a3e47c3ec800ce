"""Figures of contacts whose adhesion depends on speed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...adhesion import Jump
from ...base import Array, scale, show
from ...identification.rate.fitting import RateFit
from . import (
    BLACK,
    BLUE,
    COLORS,
    GREEN,
    LABELS,
    ORANGE,
    WIDE,
    Axes,
    Figure,
    drawing,
    legend_below,
    log_ticks,
    pretty,
    unit_of,
)

PHASES = {
    "advance": (BLUE, "-", "edge advances"),
    "rest": (GREEN, "--", "edge rests"),
    "recede": (ORANGE, "-", "edge recedes"),
    "free": (BLACK, ":", "no contact"),
}
PANELS = (("delta_m", "P_N"), ("t_s", "P_N"), ("t_s", "a_m"))


class _Quantity(NamedTuple):
    """What an axis shows: the field of a state, its dimension, and words."""

    field: str
    dimension: str
    words: str


AXES = {
    "t_s": _Quantity("t", "time", "time $t$"),
    "delta_m": _Quantity("delta", "length", LABELS["delta"]),
    "P_N": _Quantity("P", "load", LABELS["P"]),
    "a_m": _Quantity("a", "length", LABELS["a"]),
}


def history_figure(columns: Mapping[str, Array], jumps: Sequence[Jump], title: str) -> Figure:
    """Load over displacement, and load and contact radius over time, each phase in its colour and line; where the
    contact ``jumps``, and where it is lost. ``columns``: as ``History.table`` gives them."""
    with drawing(WIDE, 3.2) as figure:
        axes = figure.subplots(1, len(PANELS))
        for place, (over, column) in zip(axes, PANELS, strict=True):
            (x_factor, x_label), (y_factor, y_label) = (_axis(columns, name) for name in (over, column))
            for phase, rows in _runs(columns):
                if np.ptp(columns["t_s"][rows]) > 0:
                    rests = phase != "free" and np.ptp(columns["a_m"][rows]) == 0
                    colour, line, words = PHASES["rest" if rests else phase]
                    x, y = columns[over][rows] / x_factor, columns[column][rows] / y_factor
                    place.plot(x, y, line, color=colour, label=words)
            for jump in jumps:
                ends = [jump.start] if jump.end is None else [jump.start, jump.end]
                x, y = (np.array([getattr(end, AXES[name].field) for end in ends]) for name in (over, column))
                lost: dict[str, Any] = {"marker": "x", "ls": "", "label": "contact is lost"}
                look = lost if jump.end is None else {"label": "jump"}
                place.plot(x / x_factor, y / y_factor, color="0.5", **look)
            place.set_xlabel(x_label)
            place.set_ylabel(y_label)
        legend_below(figure, axes, 6)
        figure.suptitle(pretty(title))
        return figure


def _runs(columns: Mapping[str, Array]) -> Iterator[tuple[str, slice]]:
    """Rows of one part and phase that follow each other, with the first of the next of the same part: no gaps."""
    phases, parts = columns["phase"], columns["part"]
    changes = np.flatnonzero((phases[1:] != phases[:-1]) | (parts[1:] != parts[:-1])) + 1
    for first, last in itertools.pairwise([0, *changes.tolist(), len(parts)]):
        joined = last < len(parts) and parts[last] == parts[first]
        yield str(phases[first]), slice(first, last + joined)


def _axis(columns: Mapping[str, Array], name: str) -> tuple[float, str]:
    """The unit of a column, SI, and the label of its axis."""
    axis = AXES[name]
    factor, unit = unit_of(axis.dimension, columns[name])
    return factor, f"{axis.words} ({unit})"


def rate_fit_figure(fit: RateFit) -> Figure:
    """Loads over time since each record's begin, in units of its length, with the prediction; the law with its band."""
    with drawing(WIDE, 3.2) as figure:
        left, right = figure.subplots(1, 2)
        factor, unit = unit_of("load", *(record.P for record in fit.records))
        for i, (record, told) in enumerate(zip(fit.records, fit.predictions, strict=True)):
            part = (record.t - record.t[0]) / (record.t[-1] - record.t[0])
            colour = COLORS[i % len(COLORS)]
            left.plot(part, record.P / factor, ".", color=colour, ms=1.5, alpha=0.4)
            left.plot(
                part,
                (told.P + fit.zero) / factor,
                color=colour,
                label=pretty(f"device {show(record.speed, 'speed', 3)}"),
            )
        left.set_xlabel("time over the record's length")
        left.set_ylabel(f"{LABELS['P']} ({unit})")
        low, high = (max(v, 1e-30) for v in fit.speeds)
        v = np.geomspace(low, high, 100)
        law_band(right, v, *fit.band(v), BLACK, f"{fit.settings.law} law, {fit.settings.level:.0%} band")
        legend_below(figure, [left, right], 3)
        return figure


def law_band(axes: Axes, v: Array, w: Array, low: Array, high: Array, colour: str, label: str) -> None:
    """w over the edge's speed with a band, both axes logarithmic."""
    speed, v_unit = scale(float(v[-1]), "speed")
    work, w_unit = scale(float(np.max(w)), "work")
    axes.fill_between(v / speed, low / work, high / work, color=colour, alpha=0.25, lw=0)
    axes.loglog(v / speed, w / work, color=colour, label=label)
    axes.set_xlabel(f"speed of the contact's edge $|da/dt|$ ({pretty(v_unit)})")
    axes.set_ylabel(f"work of adhesion $w$ ({pretty(w_unit)})")
    log_ticks(axes.xaxis, axes.yaxis)

"""Figures of contacts over time: of a device's history, of adhesion that depends on speed, of bodies that relax."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ...adhesion import Jump
from ...base import Array, show
from ...identification.rate.fitting import RateFit
from ...identification.relaxation import RelaxationFit
from . import Axes, Figure, log_ticks, panelled
from .looks import BLACK, BLUE, COLORS, GREEN, ORANGE, WIDE, axis_of, pretty

PHASES = {
    "advance": (BLUE, "-", "edge advances"),
    "rest": (GREEN, "--", "edge rests"),
    "recede": (ORANGE, "-", "edge recedes"),
    "free": (BLACK, ":", "no contact"),
}
PANELS = (("delta", "P"), ("t", "P"), ("t", "a"))
COLUMNS = {"t": "t_s", "delta": "delta_m", "P": "P_N", "a": "a_m"}


def history_figure(columns: Mapping[str, Array], jumps: Sequence[Jump], title: str) -> Figure:
    """Load over displacement, and load and contact radius over time, each phase in its colour and line; where the
    contact ``jumps``, and where it is lost. ``columns``: as ``History.table`` gives them."""
    with panelled(WIDE, 3.2, len(PANELS), legend=6) as (figure, axes):
        for place, names in zip(axes, PANELS, strict=True):
            (x_unit, x_label), (y_unit, y_label) = (axis_of(name, columns[COLUMNS[name]]) for name in names)
            across, up = (columns[COLUMNS[name]] for name in names)
            for phase, rows in _runs(columns):
                if np.ptp(columns["t_s"][rows]) > 0:
                    rests = phase != "free" and np.ptp(columns["a_m"][rows]) == 0
                    colour, line, words = PHASES["rest" if rests else phase]
                    place.plot(across[rows] / x_unit, up[rows] / y_unit, line, color=colour, label=words)
            for jump in jumps:
                ends = [jump.start] if jump.end is None else [jump.start, jump.end]
                x, y = (np.array([getattr(end, name) for end in ends]) for name in names)
                lost: dict[str, Any] = {"marker": "x", "ls": "", "label": "contact is lost"}
                look = lost if jump.end is None else {"label": "jump"}
                place.plot(x / x_unit, y / y_unit, color="0.5", **look)
            place.set(xlabel=x_label, ylabel=y_label)
        figure.suptitle(pretty(title))
        return figure


def _runs(columns: Mapping[str, Array]) -> Iterator[tuple[str, slice]]:
    """Rows of one part and phase that follow each other, with the first of the next of the same part: no gaps."""
    phases, parts = columns["phase"], columns["part"]
    changes = np.flatnonzero((phases[1:] != phases[:-1]) | (parts[1:] != parts[:-1])) + 1
    for first, last in itertools.pairwise([0, *changes.tolist(), len(parts)]):
        joined = last < len(parts) and parts[last] == parts[first]
        yield str(phases[first]), slice(first, last + joined)


def rate_fit_figure(fit: RateFit) -> Figure:
    """Loads over time since each record's begin, in units of its length, with the prediction; the law with its band."""
    with panelled(WIDE, 3.2, 2, legend=3) as (figure, [left, right]):
        factor, label = axis_of("P", *(record.P for record in fit.records))
        for i, (record, prediction) in enumerate(zip(fit.records, fit.predictions, strict=True)):
            part = (record.t - record.t[0]) / (record.t[-1] - record.t[0])
            colour = COLORS[i % len(COLORS)]
            left.plot(part, record.P / factor, ".", color=colour, ms=1.5, alpha=0.4)
            device = pretty(f"device {show(record.speed, 'speed', 3)}")
            left.plot(part, (prediction.P + fit.zero) / factor, color=colour, label=device)
        left.set(xlabel="time over the record's length", ylabel=label)
        low, high = (max(v, 1e-30) for v in fit.speeds)
        v = np.geomspace(low, high, 100)
        law_band(right, v, *fit.band(v), BLACK, f"{fit.settings.law} law, {fit.settings.level:.0%} band")
        return figure


def law_band(axes: Axes, v: Array, w: Array, low: Array, high: Array, colour: str, label: str) -> None:
    """w over the edge's speed with a band, both axes logarithmic."""
    (speed, v_label), (work, w_label) = axis_of("speed", v[-1]), axis_of("w", w)
    axes.fill_between(v / speed, low / work, high / work, color=colour, alpha=0.25, lw=0)
    axes.loglog(v / speed, w / work, color=colour, label=label)
    axes.set(xlabel=v_label, ylabel=w_label)
    log_ticks(axes.xaxis, axes.yaxis)


def relaxation_fit_figure(fits: Sequence[RelaxationFit]) -> Figure:
    """What each of the first records held and what that made, over time, readings and model."""
    shown = fits[:6]
    with panelled(WIDE, 2.8 * len(shown), 2 * len(shown), columns=2, legend=2) as (figure, axes):
        for left, right, fit in zip(axes[::2], axes[1::2], shown, strict=True):
            record, names = fit.record, ("P", "delta") if fit.record.loaded else ("delta", "P")
            pairs = ((left, record.imposed, fit.imposed, names[0]), (right, record.response, fit.response, names[1]))
            for place, read, model, name in pairs:
                (time, t_label), (factor, label) = axis_of("t", record.t), axis_of(name, read)
                place.plot(record.t / time, read / factor, ".", ms=2, color=BLUE, label="readings")
                place.plot(record.t / time, model / factor, color=ORANGE, label="model")
                place.set(xlabel=t_label, ylabel=label)
            left.set_title(pretty(str(fit.relaxation)), fontsize=8)
        return figure

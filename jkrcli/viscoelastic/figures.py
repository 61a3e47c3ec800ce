"""Figures of fits of laws: of w over the speed of the edge, of relaxation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.numerics import Array
from ..base.units import show
from ..measured.figures import MARKERS
from ..report import plots
from ..report.plots import Axes, Figure, axis_of, log_ticks, panelled, pretty
from .rate_fit import RateFit
from .timed_record import RelaxationFit


def rate_fit_figure(fit: RateFit) -> Figure:
    """Loads over time since each record's begin, in units of its length, with the prediction; the law with its band."""
    with panelled(plots.WIDE, 3.2, 2, legend=3) as (figure, [left, right]):
        factor, label = axis_of("P", *(record.P for record in fit.records))
        for i, (record, prediction) in enumerate(zip(fit.records, fit.predictions, strict=True)):
            part = (record.t - record.t[0]) / (record.t[-1] - record.t[0])
            colour = plots.COLORS[i % len(plots.COLORS)]
            left.plot(part, record.P / factor, ".", color=colour, ms=1.5, alpha=0.4)
            speed = pretty(f"at {show(record.speed, 'speed', 3)}")
            left.plot(part, (prediction.P + fit.zero) / factor, color=colour, label=speed)
        left.set(xlabel="time over the record's length", ylabel=label)
        low, high = (max(v, 1e-30) for v in fit.speeds)
        v = np.geomspace(low, high, 100)
        law_band(right, v, *fit.band(v), plots.BLACK, f"{fit.settings.law} law, {fit.settings.level:.0%} band")
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
    with panelled(plots.WIDE, 2.8 * len(shown), 2 * len(shown), columns=2, legend=2) as (figure, axes):
        for left, right, fit in zip(axes[::2], axes[1::2], shown, strict=True):
            record, names = fit.record, ("P", "delta") if fit.record.loaded else ("delta", "P")
            pairs = ((left, record.imposed, fit.imposed, names[0]), (right, record.response, fit.response, names[1]))
            for place, read, model, name in pairs:
                (time, t_label), (factor, label) = axis_of("t", record.t), axis_of(name, read)
                thin = 1 + read.size // MARKERS
                seen: dict[str, Any] = {"ms": 3, "color": plots.SKY, "mfc": "none", "label": "readings"}
                place.plot(record.t[::thin] / time, read[::thin] / factor, "o", **seen)
                place.plot(record.t / time, model / factor, color=plots.ORANGE, lw=1.2, label="model")
                place.set(xlabel=t_label, ylabel=label)
            left.set_title(pretty(str(fit.relaxation)), fontsize=8)
        return figure

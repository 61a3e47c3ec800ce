"""Figures of fits of laws: of w over the speed of the edge, of relaxation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.numerics import Array
from ..base.units import show
from ..measured.figures import MARKERS
from ..report import plots
from ..report.plots import Axes, Figure, axis_of, log_ticks, panelled, pretty, unit_of
from .rate_fit import RateFit, law_of
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


PICTURE_FIRST = 1e-3  # choice: of how long a record lasts, the first time of E*(t) that is drawn
PICTURE_RECORDS = 3  # choice: that are drawn at most


def relaxation_fit_figure(fits: Sequence[RelaxationFit], speeds: Sequence[float] = ()) -> Figure:
    """Of each of the first records the load over time and over the displacement, readings and model, what the model
    leaves of the response, and E*(t) with its band; of a law of w over the ``speeds`` of devices [m/s] that too."""
    shown, last = fits[:PICTURE_RECORDS], len(speeds) > 0
    height, count = 5.0 * len(shown) + 2.5 * last, 4 * len(shown) + last
    with panelled(plots.WIDE, height, count, columns=2, legend=4 if last else 3) as (figure, axes):
        if last:
            # G = w(v) with which the crack opens, with its band, a tenfold beyond the speeds
            v = np.geomspace(min(speeds) / 10, 10 * max(speeds), 60)

            def logs(p: Mapping[str, float]) -> Array:
                law, w0 = law_of(str(fits[0].settings.rate), {**p, "w0": p["w"]})
                return np.log(law.work(w0, v))

            w, low, high = fits[0].intervals(logs).T
            law_band(axes[-1], v, w, low, high, plots.BLACK, "w over the speed of the edge")
        for i, fit in enumerate(shown):
            over_time, over_depth, left, moduli = axes[4 * i : 4 * i + 4]
            record, (delta, P) = fit.record, _delta_and_P(fit.record.imposed, fit.record.response, fit)
            model_delta, model_P = _delta_and_P(fit.imposed, fit.response, fit)
            (time, t_label), (depth, delta_label), (load, P_label) = (
                axis_of(name, values) for name, values in (("t", record.t), ("delta", delta), ("P", P))
            )
            some = slice(None, None, 1 + P.size // MARKERS)
            for place, x, model_x in (
                (over_time, record.t / time, record.t / time), (over_depth, delta / depth, model_delta / depth)
            ):  # fmt: skip
                seen: dict[str, Any] = {"ms": 3, "color": plots.SKY, "mfc": "none", "label": "readings"}
                place.plot(x[some], P[some] / load, "o", **seen)
                place.plot(model_x, model_P / load, color=plots.ORANGE, lw=1.2, label="model")
            over_time.set(xlabel=t_label, ylabel=P_label)
            over_depth.set(xlabel=delta_label, ylabel=P_label)
            over_time.set_title(pretty(str(fit.relaxation)), fontsize=8)
            off = fit.response - record.response
            factor, unit = unit_of("length" if record.loaded else "load", off[np.isfinite(off)])
            left.plot(record.t / time, off / factor, ".", color=plots.BLUE, ms=1.5)
            left.axhline(0, color=plots.BLACK, lw=0.6)
            left.set(xlabel=t_label, ylabel=f"model - readings ({unit})")
            _relaxed_moduli(moduli, fit)
        return figure


def _delta_and_P(imposed: Array, response: Array, fit: RelaxationFit) -> tuple[Array, Array]:
    return (response, imposed) if fit.record.loaded else (imposed, response)


def _relaxed_moduli(axes: Axes, fit: RelaxationFit) -> None:
    """E*(t) after a step of the strain, with its band, over as long as the record lasts."""
    lasting = float(np.ptp(fit.record.t))
    t = np.geomspace(PICTURE_FIRST * lasting, lasting, 60)
    E, low, high = fit.modulus(t).T
    (time, t_label), (unit, E_label) = axis_of("t", t), axis_of("E_star", E)
    axes.fill_between(t / time, low / unit, high / unit, color=plots.GREEN, alpha=0.25, lw=0,
                      label=f"{fit.settings.level:.0%} band")  # fmt: skip
    axes.semilogx(t / time, E / unit, color=plots.GREEN)
    axes.set(xlabel=t_label, ylabel=f"{E_label}, relaxation")
    axes.set_ylim(bottom=0)
    log_ticks(axes.xaxis)

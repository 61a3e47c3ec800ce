"""Figures of bodies that relax."""

from __future__ import annotations

from collections.abc import Sequence

from ...identification.relaxation import RelaxationFit
from . import BLUE, LABELS, ORANGE, WIDE, Figure, drawing, legend_below, pretty, unit_of


def relaxation_fit_figure(fits: Sequence[RelaxationFit]) -> Figure:
    """What each of the first records held and what that made, over time, readings and model."""
    shown = fits[:6]
    with drawing(WIDE, 2.8 * len(shown)) as figure:
        axes = figure.subplots(len(shown), 2, squeeze=False)
        for (left, right), fit in zip(axes, shown, strict=True):
            record, kinds = fit.record, ("load", "length") if fit.record.loaded else ("length", "load")
            pairs = ((left, record.imposed, fit.imposed, kinds[0]), (right, record.response, fit.response, kinds[1]))
            for place, read, model, dimension in pairs:
                (time, t_unit), (factor, unit) = unit_of("time", record.t), unit_of(dimension, read)
                place.plot(record.t / time, read / factor, ".", ms=2, color=BLUE, label="readings")
                place.plot(record.t / time, model / factor, color=ORANGE, label="model")
                name = LABELS[{"load": "P", "length": "delta"}[dimension]]
                place.set_xlabel(f"time $t$ ({t_unit})")
                place.set_ylabel(f"{name} ({unit})")
            left.set_title(pretty(str(fit.relaxation)), fontsize=8)
        legend_below(figure, axes.ravel(), 2)
        return figure

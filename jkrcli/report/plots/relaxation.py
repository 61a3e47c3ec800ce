"""Figures of bodies that relax."""

from __future__ import annotations

from collections.abc import Sequence

from ...identification.relaxation import RelaxationFit
from . import Figure, panelled
from .looks import BLUE, ORANGE, WIDE, axis_of, pretty


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

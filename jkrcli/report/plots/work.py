"""Figures of the work of adhesion along measured curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...base import Array, scale
from ...identification.rate.through import LawThrough
from ...identification.work import WorkAlong, typical
from . import (
    BLACK,
    BLUE,
    GREEN,
    LABELS,
    NARROW,
    ORANGE,
    WIDE,
    Axes,
    Figure,
    drawing,
    legend_below,
    log_ends,
    log_ticks,
    pretty,
)

GROUPS = {"measured": (GREEN, "o"), "advancing": (BLUE, "^"), "receding": (ORANGE, "v")}  # told apart in grey too


def work_figure(found: Sequence[WorkAlong], law: LawThrough | None = None) -> Figure:
    """w over the contact radius; where time was recorded also over the speed of the contact's edge, both logarithmic.

    Points are the rows of all curves, those whose edge advances and recedes told apart; a ``law`` has its 90 % band.
    """
    groups = _groups(found)
    timed = "measured" not in groups
    with drawing(WIDE if timed else NARROW, 3.0) as figure:
        axes = figure.subplots(1, 2 if timed else 1, squeeze=False)[0]
        w, unit = scale(typical(found), "work")
        _over_radius(axes[0], groups, w)
        if timed:
            _over_speed(axes[1], groups, w, law)
        for panel in axes:
            panel.set_ylabel(f"work of adhesion $w$ ({pretty(unit)})")
        if timed:
            legend_below(figure, axes, 3)
        return figure


def _groups(found: Sequence[WorkAlong]) -> dict[str, dict[str, Array]]:
    """The columns of the usable rows of all curves, by the sense of the edge's motion where any is known."""
    rows: dict[str, list[Array]] = {"advancing": [], "receding": []}
    for item in found:
        if item.speed is not None and item.timed is not None:
            for name, sense in (("advancing", item.speed > 0), ("receding", item.speed < 0)):
                rows[name].append(item.timed & sense)
    if not any(mask.any() for masks in rows.values() for mask in masks):
        rows = {"measured": [item.ok for item in found]}
    parts = {name: _columns(found, masks) for name, masks in rows.items()}
    return {name: columns for name, columns in parts.items() if columns["w"].size}


def _columns(found: Sequence[WorkAlong], masks: Sequence[Array], most: int = 3000) -> dict[str, Array]:
    """The chosen rows of all curves, thinned to at most ``most``."""
    every = 1 + sum(int(mask.sum()) for mask in masks) // most
    columns = {}
    for name in ("a", "w", "w_err", "speed"):
        values = [getattr(item, name) for item in found]
        if all(column is not None for column in values):
            columns[name] = np.concatenate([v[mask] for v, mask in zip(values, masks, strict=True)])[::every]
    return columns


def _over_radius(axes: Axes, groups: Mapping[str, Mapping[str, Array]], w: float) -> None:
    a, unit = scale(max(float(held["a"].max()) for held in groups.values()), "length")
    for name, held in groups.items():
        colour, marker = GROUPS[name]
        errors = held["w_err"] / w if "w_err" in held else None
        axes.errorbar(held["a"] / a, held["w"] / w, errors, fmt=marker, color=colour, ms=3, mfc="none", elinewidth=0.5,
                      ecolor="0.75", label=name)  # fmt: skip
    axes.set_xlabel(f"{LABELS['a']} ({pretty(unit)})")
    largest = max(float(np.quantile(held["w"], 0.99)) for held in groups.values())  # outliers may lie above the axis
    axes.set_ylim(0, 1.3 * largest / w)


def _over_speed(axes: Axes, groups: Mapping[str, Mapping[str, Array]], w: float, law: LawThrough | None) -> None:
    speed, unit = scale(max(float(np.abs(held["speed"]).max()) for held in groups.values()), "length")
    for name, held in groups.items():
        colour, marker = GROUPS[name]
        axes.loglog(np.abs(held["speed"]) / speed, held["w"] / w, marker, color=colour, ms=3, mfc="none")
    if law is not None:
        v = np.geomspace(*law.speeds, 100)
        middle, low, high = law.band(v)
        axes.fill_between(v / speed, low / w, high / w, color=BLACK, alpha=0.2, lw=0)
        axes.loglog(v / speed, middle / w, color=BLACK, label="power law")
    columns = list(groups.values())
    axes.set_xlim(*log_ends(np.concatenate([np.abs(held["speed"]) / speed for held in columns])))
    axes.set_ylim(*log_ends(np.concatenate([held["w"] / w for held in columns])))
    log_ticks(axes.xaxis, axes.yaxis)
    axes.set_xlabel(f"speed of the contact's edge $|da/dt|$ ({pretty(unit)}/s)")

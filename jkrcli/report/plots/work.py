"""Figures of the work of adhesion along measured curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...base import Array
from ...identification.rate.through import LawThrough
from ...identification.work import WorkAlong, typical
from . import Axes, Figure, log_ends, log_ticks, panelled
from .looks import BLACK, BLUE, GREEN, LABELS, NARROW, ORANGE, WIDE, axis_of, unit_of

GROUPS = {"measured": (GREEN, "o"), "advancing": (BLUE, "^"), "receding": (ORANGE, "v")}  # told apart in grey too


def work_figure(curves: Sequence[WorkAlong], law: LawThrough | None = None) -> Figure:
    """w over the contact radius; where time was recorded also over the speed of the contact's edge, both logarithmic.

    Points are the rows of all curves, those whose edge advances and recedes told apart; a ``law`` has its 90 % band.
    """
    groups = _groups(curves)
    timed = "measured" not in groups
    width, count, legend = (WIDE, 2, 3) if timed else (NARROW, 1, 0)
    with panelled(width, 3.0, count, legend=legend) as (figure, axes):
        w, label = axis_of("w", typical(curves))
        _over_radius(axes[0], groups, w)
        if timed:
            _over_speed(axes[1], groups, w, law)
        for panel in axes:
            panel.set_ylabel(label)
        return figure


def _groups(curves: Sequence[WorkAlong]) -> dict[str, dict[str, Array]]:
    """The columns of the usable rows of all curves, by the sense of the edge's motion where any is known."""
    rows: dict[str, list[Array]] = {"advancing": [], "receding": []}
    for item in curves:
        if item.speed is not None and item.timed is not None:
            for name, sense in (("advancing", item.speed > 0), ("receding", item.speed < 0)):
                rows[name].append(item.timed & sense)
    if not any(mask.any() for masks in rows.values() for mask in masks):
        rows = {"measured": [item.ok for item in curves]}
    parts = {name: _columns(curves, masks) for name, masks in rows.items()}
    return {name: columns for name, columns in parts.items() if columns["w"].size}


def _columns(curves: Sequence[WorkAlong], masks: Sequence[Array], most: int = 3000) -> dict[str, Array]:
    """The chosen rows of all curves, thinned to at most ``most``."""
    every = 1 + sum(int(mask.sum()) for mask in masks) // most
    columns = {}
    for name in ("a", "w", "w_err", "speed"):
        values = [getattr(item, name) for item in curves]
        if all(column is not None for column in values):
            columns[name] = np.concatenate([v[mask] for v, mask in zip(values, masks, strict=True)])[::every]
    return columns


def _over_radius(axes: Axes, groups: Mapping[str, Mapping[str, Array]], w: float) -> None:
    a, label = axis_of("a", *(rows["a"] for rows in groups.values()))
    for name, rows in groups.items():
        colour, marker = GROUPS[name]
        errors = rows["w_err"] / w if "w_err" in rows else None
        axes.errorbar(rows["a"] / a, rows["w"] / w, errors, fmt=marker, color=colour, ms=3, mfc="none", elinewidth=0.5,
                      ecolor="0.75", label=name)  # fmt: skip
    largest = max(float(np.quantile(rows["w"], 0.99)) for rows in groups.values())  # outliers may lie above the axis
    axes.set(xlabel=label, ylim=(0, 1.3 * largest / w))


def _over_speed(axes: Axes, groups: Mapping[str, Mapping[str, Array]], w: float, law: LawThrough | None) -> None:
    speed, unit = unit_of("length", *(rows["speed"] for rows in groups.values()))
    for name, rows in groups.items():
        colour, marker = GROUPS[name]
        axes.loglog(np.abs(rows["speed"]) / speed, rows["w"] / w, marker, color=colour, ms=3, mfc="none")
    if law is not None:
        v = np.geomspace(*law.speeds, 100)
        middle, low, high = law.band(v)
        axes.fill_between(v / speed, low / w, high / w, color=BLACK, alpha=0.2, lw=0)
        axes.loglog(v / speed, middle / w, color=BLACK, label="power law")
    axes.set_xlim(*log_ends(np.concatenate([np.abs(rows["speed"]) / speed for rows in groups.values()])))
    axes.set_ylim(*log_ends(np.concatenate([rows["w"] / w for rows in groups.values()])))
    log_ticks(axes.xaxis, axes.yaxis)
    axes.set_xlabel(f"{LABELS['speed']} ({unit}/s)")

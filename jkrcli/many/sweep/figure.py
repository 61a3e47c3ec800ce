"""The figure of a sweep: its results over the axis with the most values, a line for each value of the next."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ...base import Array, scale, show
from ...report.plots import Figure, looks, study
from .plan import Plan

PULL_OFF = re.compile(r"pull_off\.(load|displacement)\.(P|delta|a)")
MARKS = "os^Dvx"  # of lines in this order: one that covers another shows it
DIMENSIONS = {"_N": "load", "_J_per_m2": "work", "_Pa": "modulus", "_m": "length"}


def sweep_figure(plan: Plan, table: Mapping[str, Sequence[Any]]) -> Figure | None:
    """Forces where there are some, else the first results, at most two of them; other axes at their first value, which
    the title says. None where no axis or no result is a number."""
    numbers = {name: np.array(values, dtype=float) for name, values in table.items()
               if all(value is None or isinstance(value, int | float) for value in values)}  # fmt: skip
    axes = sorted(_axes(plan, numbers), key=lambda name: -np.unique(numbers[name]).size)
    results = [name for name in plan.recipe.wanted.columns if name in numbers and "err" not in name]
    results = ([name for name in results if name.endswith(".P_N")] or results)[:2]
    if not axes or not results:
        return None
    x, *others = axes
    first = {name: numbers[name][0] for name in others[1:]}
    rows = np.logical_and.reduce([np.isfinite(numbers[x]), *(numbers[name] == at for name, at in first.items())])
    shown = {name: values[rows] for name, values in numbers.items()}
    joint = any(x in plan.key_columns and len(axis.keys) > 1 for axis in plan.axes)
    panels = [_panel(shown, x, others[:1], name, "" if joint else "-") for name in results]
    return study.panels_figure(panels, ", ".join(_value(name, at) for name, at in first.items()))


def _axes(plan: Plan, numbers: Mapping[str, Array]) -> Iterator[str]:
    """The first column of each axis that holds several numbers."""
    columns = iter(plan.key_columns)
    for axis in plan.axes:
        names = [next(columns) for _ in axis.keys]
        yield from [name for name in names if name in numbers and np.unique(numbers[name]).size > 1][:1]


def _panel(columns: Mapping[str, Array], x: str, beside: list[str], y: str, style: str) -> study.Panel:
    (along, x_label), (up, y_label) = (_scaled(columns, name) for name in (x, y))
    groups = np.unique(columns[beside[0]])[: len(looks.COLORS)] if beside else [None]
    lines = []
    for at, color, mark in zip(groups, looks.COLORS, MARKS, strict=False):
        rows = np.flatnonzero(columns[beside[0]] == at) if beside else np.arange(along.size)
        rows = rows[np.argsort(along[rows], kind="stable")]
        lines.append(study.Line(along[rows], up[rows], _value(beside[0], at) if beside else "", mark + style, color))
    wide = 0 < 5 * along.min() < along.max()
    title = f"{match[1]} control" if (match := PULL_OFF.match(y)) else ""
    return study.Panel(x_label, y_label, lines, title, logs="x" if wide else "")


def _scaled(columns: Mapping[str, Array], column: str) -> tuple[Array, str]:
    """A column in the unit that people would use, and the label of its axis."""
    stem, dimension = _split(column)
    factor, unit = scale(float(np.nanmax(np.abs(columns[column]))), dimension)
    return columns[column] / factor, f"{_words(stem)} ({looks.pretty(unit)})" if unit else _words(stem)


def _words(stem: str) -> str:
    """What a result or a key is called on an axis: "pull_off.load.P" the load at pull-off; others as they are."""
    if match := PULL_OFF.fullmatch(stem):
        return f"{looks.LABELS[match[2]]} at pull-off"
    if match := re.fullmatch(r"specimen\.layers\[(\d+)\]\.(\w+)", stem):
        return f"{match[2]} of layer {int(match[1]) + 1}"
    return stem


def _value(column: str, value: float) -> str:
    stem, dimension = _split(column)
    return f"{stem.rpartition('.')[2]} = {looks.pretty(show(value, dimension))}"


def _split(column: str) -> tuple[str, str]:
    """A column's name without its unit, and its dimension."""
    ending = next((ending for ending in DIMENSIONS if column.endswith(ending)), "")
    return column.removesuffix(ending), DIMENSIONS.get(ending, "number")

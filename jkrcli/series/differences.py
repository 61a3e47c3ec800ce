"""How far two results of the same problem lie apart, column by column, with the worst row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..base.numerics import ROUNDED, Array
from . import Series


@dataclass(frozen=True, eq=False)
class Difference:
    """Relative differences of one ``column`` at the values ``x`` of ``over``: second minus first, over the first.

    Adhesive loads and displacements change sign: their differences are over the largest magnitude of the first.
    ``coverage``: the share of the wider of the two ranges that both have.
    """

    column: str
    over: str
    x: Array
    relative: Array
    coverage: float

    @property
    def worst_row(self) -> int:
        return int(np.argmax(np.abs(self.relative)))

    @property
    def worst(self) -> float:
        return float(np.abs(self.relative[self.worst_row]))


def series_differences(first: Series, second: Series) -> list[Difference]:
    """P and a at equal displacement, S and dS at equal radius where both carry them; over the common range."""
    differences = [
        _in_logs("P", "delta_m", first.delta, first.P, second.delta, second.P),
        _in_logs("a", "delta_m", first.delta, first.a, second.delta, second.a),
    ]
    for name in ("S", "dS"):
        y1, y2 = getattr(first, name), getattr(second, name)
        if y1 is not None and y2 is not None:
            differences.append(_in_logs(name, "a_m", first.a, y1, second.a, y2))
    return differences


def curve_differences(first: Mapping[str, Array], second: Mapping[str, Array]) -> list[Difference]:
    """The columns that two adhesive curves share, at equal contact radius, over the common range."""
    from scipy.interpolate import PchipInterpolator

    x, inside = _common(first["a_m"], second["a_m"])
    differences = []
    for name in first:
        if name == "a_m" or name not in second or name.endswith(("_err_N", "_err_m")) or first[name].dtype.kind != "f":
            continue
        scale = float(np.max(np.abs(first[name])))
        other = PchipInterpolator(second["a_m"], second[name])(np.clip(x, second["a_m"][0], second["a_m"][-1]))
        relative = (other - first[name][inside]) / scale
        differences.append(Difference(name, "a_m", x, relative, _coverage(first["a_m"], second["a_m"])))
    return differences


def _in_logs(column: str, over: str, x1: Array, y1: Array, x2: Array, y2: Array) -> Difference:
    """Power laws are straight in logs: few points suffice."""
    from scipy.interpolate import PchipInterpolator

    x, inside = _common(x1, x2)
    if x2.size == 1:
        return Difference(column, over, x, y2 / y1[inside] - 1, _coverage(x1, x2))
    other = np.exp(PchipInterpolator(np.log(x2), np.log(y2))(np.clip(np.log(x), np.log(x2[0]), np.log(x2[-1]))))
    return Difference(column, over, x, other / y1[inside] - 1, _coverage(x1, x2))


def _coverage(x1: Array, x2: Array) -> float:
    """Length that both ranges share, over that of the longer one."""
    shared = min(x1[-1], x2[-1]) - max(x1[0], x2[0])
    longest = max(x1[-1] - x1[0], x2[-1] - x2[0])
    return float(max(shared, 0.0) / longest) if longest > 0 else 1.0


def _common(x1: Array, x2: Array) -> tuple[Array, Array]:
    """The values of ``x1`` within the range of ``x2`` (up to round-off), and where they stand."""
    inside = (x1 >= x2[0] * (1 - ROUNDED)) & (x1 <= x2[-1] * (1 + ROUNDED))
    if not inside.any():
        raise InputError(
            f"nothing to compare: the ranges {x1[0]:.4g} to {x1[-1]:.4g} and {x2[0]:.4g} to {x2[-1]:.4g} do not overlap"
        )
    return x1[inside], inside

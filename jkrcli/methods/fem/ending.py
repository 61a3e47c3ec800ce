"""Series between the events of nested contact: the end of the loading, and values in between, by interpolation."""

from __future__ import annotations

import numpy as np

from ...base.errors import Refusal
from ...bodies.problem import Loading
from .contact import Events

Array = np.ndarray
Columns = tuple[Array, Array, Array]
UNITS = {"depth": "m", "load": "N", "radius": "m"}
CLOSE = 0.05  # of the distance to the next event: an event as close as this to the end is replaced by the end


def power_interpolated(x: Array, y: Array, at: Array) -> Array:
    """y(x) at the positive values ``at``: a monotone cubic in logarithms, a power law outside the table."""
    from scipy.interpolate import PchipInterpolator

    u, v, wanted = np.log(x), np.log(y), np.log(at)
    first, last = (v[1] - v[0]) / (u[1] - u[0]), (v[-1] - v[-2]) / (u[-1] - u[-2])
    inner = PchipInterpolator(u, v)(np.clip(wanted, u[0], u[-1]))
    return np.exp(inner + first * np.minimum(wanted - u[0], 0.0) + last * np.maximum(wanted - u[-1], 0.0))


def nested_columns(loading: Loading, events: Events, a0: float) -> Columns:
    """a [m], delta [m] and P [N] of the series: the events before the loading's end and that end itself, or the
    given values. Refusal: a value below the first event. ``a0``: flat radius [m]."""
    table = {"radius": events.a - a0, "depth": events.delta, "load": events.P}
    x, shift = table[loading.to], a0 if loading.to == "radius" else 0.0
    if loading.spacing == "given":
        values = np.array(loading.values)
        first = float(x[0]) + shift
        if values[0] < first * (1 - 1e-9):
            raise Refusal(
                f"loading: {loading.to} {values[0]:g} {UNITS[loading.to]} lies below the first that the mesh resolves, "
                f"{first:.3g} {UNITS[loading.to]}: take a smaller mesh.smallest (layout zones: mesh.element_size), or "
                "larger values"
            )
        rows = _at(table, x, values - shift)
        return rows[0] + a0, rows[1], rows[2]
    if x.size < 2:
        return events.a, events.delta, events.P
    end = loading.maximum - shift
    ahead = min(max(int(np.searchsorted(x, end)), 1), x.size - 1)
    before = x < end - CLOSE * (x[ahead] - x[ahead - 1])
    columns = (
        np.append(y[before], last) for y, last in zip(table.values(), _at(table, x, np.array([end])), strict=True)
    )
    radius, delta, P = columns
    return radius + a0, delta, P


def _at(table: dict[str, Array], x: Array, values: Array) -> list[Array]:
    """All columns of the table at ``values`` of the column ``x``."""
    return [values if y is x else power_interpolated(x, y, values) for y in table.values()]

"""What a loading asks of the surface: depths of its increments, and series between the events of nested contact."""

from __future__ import annotations

import numpy as np

from ...base import ROUNDED, Array, Refusal
from ...bodies import Loading, Problem
from ...series import PressureTable, RawSeries
from ..radii import graded_radii
from .nested import Events, Increment, SurfaceContact, solve_depths
from .surface import Surface

Columns = tuple[Array, Array, Array]  # a [m], delta [m], P [N]
CLOSE = 0.05  # of the distance to the next event; choice: one as close to the end gives way to it, no two rows alike


def power_interpolated(x: Array, y: Array, at: Array) -> Array:
    """y(x) at the positive values ``at``: a monotone cubic in logarithms, a power law outside the table."""
    from scipy.interpolate import PchipInterpolator

    u, v, wanted = np.log(x), np.log(y), np.log(at)
    first, last = (v[1] - v[0]) / (u[1] - u[0]), (v[-1] - v[-2]) / (u[-1] - u[-2])
    inner = PchipInterpolator(u, v)(np.clip(wanted, u[0], u[-1]))
    return np.exp(inner + first * np.minimum(wanted - u[0], 0.0) + last * np.maximum(wanted - u[-1], 0.0))


def nested_columns(loading: Loading, events: Events, a0: float) -> Columns:
    """The series that a loading asks of the events: those before its end and that end itself, or the given values.
    Refusal: a value below the first event. ``a0``: flat radius [m]."""
    table = {"radius": events.a - a0, "depth": events.delta, "load": events.P}
    x, shift = table[loading.to], a0 if loading.to == "radius" else 0.0
    if loading.spacing == "given":
        _refuse_unresolved(loading, float(x[0]) + shift)
        a, delta, P = _at(table, x, np.array(loading.values) - shift)
    elif x.size < 2:
        return events.a, events.delta, events.P
    else:
        end = loading.maximum - shift
        ahead = min(max(int(np.searchsorted(x, end)), 1), x.size - 1)
        before = x < end - CLOSE * (x[ahead] - x[ahead - 1])
        last = _at(table, x, np.array([end]))
        a, delta, P = (np.append(y[before], value) for y, value in zip(table.values(), last, strict=True))
    return a + a0, delta, P


def _at(table: dict[str, Array], x: Array, values: Array) -> list[Array]:
    """All columns of the table at ``values`` of the column ``x``."""
    return [values if y is x else power_interpolated(x, y, values) for y in table.values()]


def _refuse_unresolved(loading: Loading, first: float) -> None:
    unit = {"depth": "m", "load": "N", "radius": "m"}[loading.to]
    if loading.values[0] < first * (1 - ROUNDED):
        raise Refusal(
            f"loading: {loading.to} {loading.values[0]:g} {unit} lies below the first that the mesh resolves, "
            f"{first:.3g} {unit}: take a smaller mesh.smallest (layout zones: mesh.element_size), or larger values"
        )


def nodal_forces(contact: SurfaceContact, events: Events, delta: Array) -> Array:
    """Forces on the surface [N] at depths ``delta`` [m]: the events', and solved for where a depth is no event's."""
    if contact.surface.sticks:
        return contact.pressed(contact.surface.last[contact.set_at(delta)], delta)[1].T
    near = np.clip(np.searchsorted(events.delta, delta * (1 - 1e-12)), 0, events.delta.size - 1)
    p = events.p[near]
    other = np.flatnonzero(np.abs(events.delta[near] / delta - 1) > 1e-12)
    for i, step in zip(other, solve_depths(contact, delta[other]), strict=True):
        p[i] = step.p
    return p


def needed_radius(problem: Problem, events: Events, reach: float) -> float | None:
    """Contact radius, about, at which the loading ends [m]; None where the events reach it."""
    loading, a0 = problem.loading, problem.indenter.a0
    if not events.a.size:
        return 2 * reach
    last = events.quantity(loading.to)[-1]
    if last >= loading.maximum * (1 - ROUNDED):
        return None
    power = {"depth": 1 / 2, "load": 1 / 3, "radius": 1.0}[loading.to]
    return float(a0 + (events.a[-1] - a0) * 1.05 * (loading.maximum / last) ** power)


def depths_of(problem: Problem, events: Events) -> Array:
    """Displacements of the increments [m]; other quantities are interpolated in the table of events."""
    loading, a0, events = problem.loading, problem.indenter.a0, events.rising
    if loading.to == "depth" and loading.spacing == "given":
        return np.array(loading.values)
    steps = np.arange(1, loading.points + 1) / loading.points
    deepest = loading.maximum
    if loading.to != "depth":
        deepest = float(_depths_at(events, loading.to, np.array([loading.maximum]), a0)[0])
    if loading.spacing == "depth":
        return deepest * steps
    if loading.spacing == "given":
        return _depths_at(events, loading.to, np.array(loading.values), a0)
    largest = a0 + float(power_interpolated(events.delta, events.a - a0, np.array([deepest]))[0])
    radii = graded_radii(a0, largest, loading.points) if loading.spacing == "log" else a0 + (largest - a0) * steps
    depths = _depths_at(events, "radius", radii, a0)
    depths[-1] = deepest
    return depths


def _depths_at(events: Events, quantity: str, values: Array, a0: float) -> Array:
    """Depths [m] at which ``quantity`` ("radius" or "load") has the given values [m or N]."""
    shift = a0 if quantity == "radius" else 0.0
    return power_interpolated(events.quantity(quantity) - shift, events.delta, values - shift)


def raw_series(surface: Surface, increments: list[Increment]) -> RawSeries:
    """Increments with the radius of the outermost active vertex (0 where there is none beyond the axis)."""
    a = [float(np.max(surface.radii[step.active & surface.is_vertex], initial=0.0)) for step in increments]
    return RawSeries(np.array(a), np.array([s.delta for s in increments]), np.array([s.P for s in increments]))


def pressures(surface: Surface, forces: Array) -> PressureTable:
    """Downward nodal force over nodal area; nodes without area (the axis of second-order elements) are left out."""
    forces = forces[:, surface.normal]
    areas, radii = surface.areas, surface.radii
    wide = areas > 1e-6 * areas.max() * (radii / radii[-1]) ** 2
    return PressureTable(radii[wide], forces[:, wide] / areas[wide])

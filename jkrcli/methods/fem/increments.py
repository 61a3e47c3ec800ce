"""What a loading asks of the surface: the depths of its increments, and the series that come out of them."""

from __future__ import annotations

import numpy as np

from ...bodies.problem import Problem
from ...series import PressureTable, RawSeries
from ..radii import graded_radii
from .contact import Events, Increment, SurfaceContact, solve_depths
from .ending import power_interpolated
from .model import Model

Array = np.ndarray


def nodal_forces(contact: SurfaceContact, events: Events, delta: Array) -> Array:
    """Nodal forces [N] at depths ``delta`` [m]: the events', and solved for where a depth is no event's."""
    near = np.clip(np.searchsorted(events.delta, delta * (1 - 1e-12)), 0, events.delta.size - 1)
    p = events.p[near]
    other = np.flatnonzero(np.abs(events.delta[near] / delta - 1) > 1e-12)
    for i, step in zip(other, solve_depths(contact, delta[other]), strict=True):
        p[i] = step.p
    return p


def needed_radius(problem: Problem, events: Events, reach: float) -> float | None:
    """None where the events reach the end of the loading; else about the contact radius that does."""
    loading, a0 = problem.loading, problem.indenter.a0
    if not events.a.size:
        return 2 * reach
    last = {"depth": events.delta, "load": events.P, "radius": events.a}[loading.to][-1]
    if last >= loading.maximum * (1 - 1e-9):
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
        deepest = float(_between(events, loading.to, np.array([loading.maximum]), a0)[0])
    if loading.spacing == "depth":
        return deepest * steps
    if loading.spacing == "given":
        return _between(events, loading.to, np.array(loading.values), a0)
    largest = a0 + float(power_interpolated(events.delta, events.a - a0, np.array([deepest]))[0])
    radii = graded_radii(a0, largest, loading.points) if loading.spacing == "log" else a0 + (largest - a0) * steps
    depths = _between(events, "radius", radii, a0)
    depths[-1] = deepest
    return depths


def _between(events: Events, quantity: str, values: Array, a0: float) -> Array:
    """Depths [m] at which ``quantity`` ("radius" or "load") has the given values [m or N]."""
    if quantity == "radius":
        return power_interpolated(events.a - a0, events.delta, values - a0)
    return power_interpolated(events.P, events.delta, values)


def raw_series(model: Model, increments: list[Increment]) -> RawSeries:
    """Increments with the radius of the outermost active vertex (0 where there is none beyond the axis)."""
    surface = model.surface
    a = [float(np.max(surface.radii[step.active & surface.is_vertex], initial=0.0)) for step in increments]
    return RawSeries(np.array(a), np.array([s.delta for s in increments]), np.array([s.P for s in increments]))


def pressures(model: Model, forces: Array) -> PressureTable:
    """Nodal force over nodal area; nodes without area (the axis of second-order elements) are left out."""
    areas = model.surface.areas
    wide = areas > 1e-6 * areas.max() * (model.surface.radii / model.surface.radii[-1]) ** 2
    return PressureTable(model.surface.radii[wide], forces[:, wide] / areas[wide])

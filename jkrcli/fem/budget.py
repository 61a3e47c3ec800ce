"""Error estimates of a finite-element series: a second mesh with doubled sizes, and what the cut costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..clock import StageClock
from ..problem import Problem
from ..series import ErrorBudget, Estimate
from .contact import Events, SurfaceContact, nested_events
from .edge import radius_factors
from .model import Model, Recipe

Array = np.ndarray
JUDGED_DEPTH = 0.01  # of the largest: below it a series has too few nodes in contact to be judged


def estimate(model: Model, problem: Problem, events: Events, a: Array, delta: Array, P: Array) -> ErrorBudget:
    """Largest relative errors over the series ``a``, ``delta``, ``P`` with edge-corrected or plain radii: of P at equal
    depth (discretisation, truncation) and of a (radius). ``events``: the model's own, their radii as in the series."""
    corrected = not np.isin(events.a, model.surface.radii).all()
    coarse = model.recipe.coarser(2.0).build(StageClock())
    contact = coarse.contact(problem.indenter)
    judged = delta >= JUDGED_DEPTH * delta[-1]
    a, delta, P = a[judged], delta[judged], P[judged]
    change = np.abs(load_at(contact, delta) / P - 1)
    return ErrorBudget(
        discretisation=float(np.max(change)) / 2,  # at least first order: the finer mesh is off by less than half of it
        truncation=_truncation(model, coarse.recipe, problem, events, contact, float(delta[-1])),
        radius=_radius(_coarse_events(coarse, contact, problem, corrected), events, a, delta),
    )


def load_at(contact: SurfaceContact, delta: Array) -> Array:
    """P [N] at depths ``delta`` [m] of a disc that grows node by node: linear between the nodes' touches."""
    k = np.clip(np.searchsorted(np.maximum.accumulate(contact.delta), delta, side="right") - 1, 0, contact.f.size - 1)
    return contact.S[k] * delta - contact.T[k]


def _coarse_events(coarse: Model, contact: SurfaceContact, problem: Problem, corrected: bool) -> Events:
    events = nested_events(contact, problem.indenter.a0, "radius", np.inf)
    if not corrected:
        return events
    return replace(events, a=events.a * radius_factors(coarse, problem.indenter))


def _radius(coarse: Events, events: Events, a: Array, delta: Array) -> Estimate:
    """What doubling the sizes changes at equal depth (a vertex radius is off by a fraction of the spacing), plus where
    the series' radii differ from the events' (increments)."""
    if coarse.a.size < 4 or events.a.size < 4:
        return "fewer than four vertices in contact"
    inside = (delta >= coarse.delta[0]) & (delta <= min(coarse.delta[-1], events.delta[-1]))
    if not inside.any():
        return "no radius common to the mesh and its coarser companion"
    a, delta = a[inside], delta[inside]
    fine = _radius_at(events, delta)
    return float(np.max(np.abs(_radius_at(coarse, delta) / fine - 1) + np.abs(a / fine - 1)))


def _radius_at(events: Events, delta: Array) -> Array:
    from scipy.interpolate import PchipInterpolator

    return np.exp(PchipInterpolator(np.log(events.delta), np.log(events.a))(np.log(delta)))


def _truncation(
    model: Model, coarse: Recipe, problem: Problem, events: Events, contact: SurfaceContact, deepest: float
) -> Estimate:
    """Half-spaces: Betti's theorem, to first order in contact radius over size, which a completed body contains.
    Stacks on a rigid base: a free against a roller side, on the coarse mesh."""
    body = model.body
    if body.cut_below:
        lacking = abs(model.missing) * float(events.S[-1])
        return lacking**2 if body.completed else lacking
    if not body.cut_beside:
        return 0.0
    other = replace(coarse, side="roller").build(StageClock()).contact(problem.indenter)
    depth = np.array([deepest])
    free = load_at(contact, depth)[0]
    return float(abs(load_at(other, depth)[0] / free - 1))

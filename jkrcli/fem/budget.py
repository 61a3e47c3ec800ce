"""Error estimates of a finite-element series: a second mesh with doubled sizes, and what the cut costs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..clock import StageClock
from ..problem import Problem
from ..series import ErrorBudget, Estimate
from .contact import Events, SurfaceContact, nested_events
from .edge import radius_factors
from .ending import power_interpolated
from .model import Model, Recipe

Array = np.ndarray
JUDGED_DEPTH = 0.01  # of the largest: below it few nodes are in contact, and the budget leaves the rows out
SAFETY = 1.5  # on what doubling the sizes changes: half of it for loads (at least first order), all of it for radii
ROUND_OFF = 1e-12  # radii come from a search


@dataclass(frozen=True, eq=False)
class Assessment:
    """The error budget over the judged part of a series, from the depth ``judged_from`` [m] on, and the relative
    errors of ``P`` (at equal depth) and ``a`` row by row, larger where few nodes are in contact; None: unknown."""

    budget: ErrorBudget
    judged_from: float | None = None
    P: Array | None = None
    a: Array | None = None


def estimate(model: Model, problem: Problem, events: Events, a: Array, delta: Array, P: Array) -> Assessment:
    """Relative errors of the series ``a``, ``delta``, ``P`` with edge-corrected or plain radii: of P at equal
    depth (discretisation, truncation) and of a (radius). ``events``: the model's own, their radii as in the series."""
    corrected = not np.isin(events.a, model.surface.radii).all()
    coarse = model.recipe.coarser(2.0).build(StageClock())
    contact = coarse.contact(problem.indenter)
    judged = delta >= JUDGED_DEPTH * delta[-1]
    change = SAFETY / 2 * np.abs(load_at(contact, delta) / P - 1)
    load = _envelope(_at_least_decaying(change, a - problem.indenter.a0), delta)
    radius = _radius(_coarse_events(coarse, contact, problem, corrected), events, a, delta)
    truncation = _truncation(model, coarse.recipe, problem, events, contact, float(delta[-1]))
    budget = ErrorBudget(
        discretisation=float(load[judged].max()),
        truncation=truncation,
        radius=radius if isinstance(radius, str) else float(radius[judged].max()),
    )
    judged_from = float(delta[judged][0])
    if isinstance(radius, str) or isinstance(truncation, str):
        return Assessment(budget, judged_from)
    return Assessment(budget, judged_from, load + truncation, radius)


def _at_least_decaying(errors: Array, width: Array) -> Array:
    """The errors, but nowhere less than any before decayed with the square of the contact's ``width`` [m]: as those of
    a uniform mesh do."""
    return np.maximum.accumulate(errors * width**2) / width**2


def _envelope(errors: Array, delta: Array) -> Array:
    """Largest of the errors from each depth up to the deepest, and at least of those in the deepest decade: the
    changes between two meshes pass through zero here and there, the errors need not."""
    deepest = float(np.max(errors[delta >= 0.1 * delta[-1]]))
    return np.maximum(np.maximum.accumulate(errors[::-1])[::-1], deepest)


def load_at(contact: SurfaceContact, delta: Array) -> Array:
    """P [N] at depths ``delta`` [m] of a disc that grows node by node: linear between the nodes' touches."""
    k = np.clip(np.searchsorted(np.maximum.accumulate(contact.delta), delta, side="right") - 1, 0, contact.f.size - 1)
    return contact.S[k] * delta - contact.T[k]


def _coarse_events(coarse: Model, contact: SurfaceContact, problem: Problem, corrected: bool) -> Events:
    events = nested_events(contact, problem.indenter.a0, "radius", np.inf)
    if not corrected:
        return events
    return replace(events, a=events.a * radius_factors(coarse, problem.indenter))


def _radius(coarse: Events, events: Events, a: Array, delta: Array) -> Array | str:
    """What doubling the sizes changes at equal depth (a vertex radius is off by a fraction of the spacing), plus where
    the series' radii differ from the events' (increments). Below the meshes' first events, where the spacing is
    uniform, the change grows like the inverse radius."""
    if coarse.a.size < 4 or events.a.size < 4:
        return "fewer than four vertices in contact"
    first, last = max(coarse.delta[0], events.delta[0]), min(coarse.delta[-1], events.delta[-1])
    if first >= last or delta[-1] < first:
        return "no radius common to the mesh and its coarser companion"
    fine = _radius_at(events, delta)
    samples = np.unique(np.clip(np.concatenate([delta, coarse.delta, events.delta]), first, last))
    changes = np.abs(_radius_at(coarse, samples) / _radius_at(events, samples) - 1)
    changes = _envelope(np.maximum(SAFETY * changes, ROUND_OFF), samples)
    change = np.interp(delta, samples, changes) * np.maximum(_radius_at(events, np.array([first])) / fine, 1.0)
    return _envelope(change + np.abs(a / fine - 1), delta)


def _radius_at(events: Events, delta: Array) -> Array:
    """Radii [m] at depths ``delta`` [m]: a monotone cubic in logarithms, a power law outside the events."""
    return power_interpolated(events.delta, events.a, delta)


def _truncation(
    model: Model, coarse: Recipe, problem: Problem, events: Events, contact: SurfaceContact, deepest: float
) -> Estimate:
    """Half-spaces: Betti's theorem, to first order in contact radius over size, which a completed body contains.
    Stacks on a rigid base: a free against a roller side, on the coarse mesh."""
    body = model.body
    if body.cut_below:
        last = min(int(np.searchsorted(events.delta, deepest * (1 - 1e-9))), events.S.size - 1)
        lacking = abs(model.missing) * float(events.S[last])
        return lacking**2 if body.completed else lacking
    if not body.cut_beside:
        return 0.0
    other = replace(coarse, side="roller").build(StageClock()).contact(problem.indenter)
    depth = np.array([deepest])
    free = load_at(contact, depth)[0]
    return float(abs(load_at(other, depth)[0] / free - 1))

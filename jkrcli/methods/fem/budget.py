"""Error budget of a finite-element series: against a second mesh with larger elements, and for what the cut costs."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...base import ROUNDED, Array, Estimate, InputError, Unknown
from ...series import Coarser, ErrorBudget, Series
from .model import MeshLevel, Run, power_interpolated, raw_series
from .nested import Events, SurfaceContact, solve_depths


@dataclass(frozen=True)
class BudgetTuning:
    """How errors are concluded from what larger elements change."""

    # of the largest depth: below it few nodes are in contact, and the budget leaves the rows out; tuned on bodies, by
    # `make constants`: says so
    judged_depth: float = 0.01
    # errors in what doubling the sizes changes: first order leaves 1, and meshes differ by luck
    loads: float = 1.4  # tuned on the bodies of `make failures`, by `make failures`
    radii: float = 2.0  # tuned on the bodies of `make failures`, by `make failures`
    fallen: float = 1.5  # of changes over errors, at most; tuned on random bodies, by `make bounds`: 3 is second order
    # Of what doubling changed before over what it changes, at most; where that falls by more, the meshes agree by
    # accident:
    plausible: float = 12.0  # of loads; tuned on random bodies, by `make bounds`
    plausible_radii: float = 4.0  # of radii; tuned on random bodies, by `make bounds`
    tension: float = 2.0  # times that of radii; choice: calibrated radii then err by up to the estimate itself
    round_off: float = 1e-12  # of radii; theory: 1e4 eps, as they come from a search


TUNING = BudgetTuning()
TOO_FEW = Unknown("fewer than four vertices in contact")


@dataclass(frozen=True, eq=False)
class Assessment:
    """The error budget over the judged part of a series, from the depth ``judged_from`` [m] on, and the relative
    ``errors`` row by row of P (at equal depth), a, S and dS where known, larger where few nodes are in contact;
    ``coarser``: what they are concluded from."""

    budget: ErrorBudget
    judged_from: float | None = None
    errors: Mapping[str, Array] = field(default_factory=dict)
    coarser: Coarser | None = None


def assessed(run: Run, larger: Sequence[MeshLevel], ratio: float, truncation: Estimate) -> Assessment:
    """Relative errors of P at equal depth (discretisation) and of a (radius), by comparison with a level whose elements
    are ``ratio`` times as large, the first of the ``larger``, and of that with one of elements as much larger once
    more, where there is such; ``truncation``: as found by ``truncation_of``."""
    coarse = larger[0]
    if coarse.touches.a.size < 4 or run.level.touches.a.size < 4:
        return Assessment(ErrorBudget(TOO_FEW, truncation, TOO_FEW))
    run, rows = _with_events(run)
    fine, (a, delta, P) = run.level, run.columns
    judged = delta >= TUNING.judged_depth * delta[-1]
    loads, radii = TUNING.loads / (ratio - 1), TUNING.radii / (ratio - 1)
    radii *= TUNING.tension if fine.model.body.tension else 1.0
    if not all(level.touches.valid and level.touches.a.size >= 4 for level in larger):
        larger = [coarse]
    there, radius = _on_coarse(run, larger, radii)
    values = [P, there, *(_load_on(level, run) for level in larger[1:])]
    change = loads * _change(values, TUNING.plausible) / _fallen(values, judged)
    width = a - fine.indenter.a0  # errors fall by no more than its square, as those of a uniform mesh do
    load = np.maximum.accumulate(change * width**2) / width**2
    # the many rows of increments cross zero between nodes: what shallower rows leave of it is already that of a row
    load = np.maximum.accumulate(load[::-1])[::-1] if run.raw is not None else _envelope(load, delta)
    worst = radius if isinstance(radius, Unknown) else float(radius[judged].max())
    budget = ErrorBudget(discretisation=float(load[judged].max()), truncation=truncation, radius=worst)
    judged_from = float(delta[rows][judged[rows]][0])
    if isinstance(radius, Unknown) or isinstance(truncation, Unknown):
        return Assessment(budget, judged_from)
    errors = {"P": load + truncation, "a": radius} | _slopes(run, coarse, radii, radius)
    cut = truncation * float(np.sign(np.mean(there - P)))
    other = None if run.raw is not None else _coarser(larger, delta, ratio, cut)
    return Assessment(budget, judged_from, {name: values[rows] for name, values in errors.items()}, other)


def _coarser(levels: Sequence[MeshLevel], delta: Array, ratio: float, cut: float) -> Coarser | None:
    """The series of the ``levels``, each of elements ``ratio`` times as large as those before, as deep as ``delta``
    [m], of a body that is stiffer by the fraction ``cut``; None where the first one's contact is no disc that only
    grows, or too small."""
    if not levels:
        return None
    level, *larger = levels
    events = level.events.rising
    rows = slice(int(np.searchsorted(events.delta, delta[-1])) + 1)
    a, slopes = events.a[rows], level.slopes(events.a[rows])
    if slopes is None:
        return None
    P, S, dS = ((1 + cut) * values for values in (events.P[rows], *slopes))
    beyond = _coarser(larger, delta, ratio, cut)
    try:
        return Coarser(Series(a, events.delta[rows], P, S, dS, a0=level.indenter.a0, coarser=beyond), ratio)
    except InputError:
        return None


def _with_events(run: Run) -> tuple[Run, Array]:
    """The run with all events up to its end among its columns, and the numbers of its own rows: two meshes agree by
    accident at a few given values more easily than at all of them."""
    a, delta, P = run.columns
    events = run.level.events
    if run.raw is not None or run.problem.loading.spacing != "given":
        return run, np.arange(a.size)
    others = events.delta < delta[-1]
    own = np.concatenate([np.ones(a.size, bool), np.zeros(int(others.sum()), bool)])
    columns = zip((a, delta, P), (events.a, events.delta, events.P), strict=True)
    merged = np.stack([np.append(ours, theirs[others]) for ours, theirs in columns])
    order = np.argsort(merged[1], kind="stable")
    return replace(run, columns=tuple(merged[:, order])), np.flatnonzero(own[order])


def _changes(values: Sequence[Array]) -> list[Array]:
    """What larger elements change, relatively, from each mesh to the next."""
    return [np.abs(coarser / finer - 1) for finer, coarser in itertools.pairwise(values)]


def _change(values: Sequence[Array], plausible: float) -> Array:
    """What larger elements change, relatively, and at least a ``plausible`` part of what still larger ones do."""
    change, *before = _changes(values)
    return np.max([change, *(other / plausible for other in before)], axis=0)


def _fallen(values: Sequence[Array], judged: Array) -> float:
    """What larger elements change over the error that is left, by the order that the ``judged`` rows show where it is
    least, in their mean or where they change most: 1 of first order, and where no third mesh tells it."""
    if len(values) < 3:
        return 1.0
    change, before = (changes[judged] for changes in _changes(values))
    if not change.any():
        return TUNING.fallen
    order = min(before.mean() / change.mean(), before[np.argmax(change)] / change.max()) - 1
    return float(np.clip(order, 1.0, TUNING.fallen))


def _on_coarse(run: Run, larger: Sequence[MeshLevel], caution: float) -> tuple[Array, Array | Unknown]:
    """P [N] of the first coarser mesh at the depths of the series, and the relative error of the radius."""
    fine, coarse, (a, delta, _) = run.level, larger[0], run.columns
    if not (fine.touches.valid and coarse.touches.valid):
        return _without_disc(coarse, fine, a, delta, caution)
    return _load_on(coarse, run), _radius([level.events for level in (fine, *larger)], a, delta, caution)


def _load_on(level: MeshLevel, run: Run) -> Array:
    """P [N] of a coarser ``level`` at the depths of the series, where its contact is a disc that only grows."""
    delta, touches = run.columns[1], level.touches
    there = load_at(level.contact, delta)
    if run.raw is not None:
        return there
    # a series of touches interpolates between them
    return np.where(delta < touches.delta[0], there, power_interpolated(touches.delta, touches.P, delta))


def _envelope(errors: Array, delta: Array) -> Array:
    """Largest of the errors from each depth up to the deepest, and at least of those in the deepest decade: the
    changes between two meshes pass through zero here and there, the errors need not."""
    deepest = float(np.max(errors[delta >= 0.1 * delta[-1]]))
    return np.maximum(np.maximum.accumulate(errors[::-1])[::-1], deepest)


def _without_disc(coarse: MeshLevel, fine: MeshLevel, a: Array, delta: Array, caution: float) -> tuple[Array, Array]:
    """P [N] of the coarser mesh at depths ``delta`` [m], and the error of the radius, where the contact is no disc that
    only grows: what larger elements change, at least the distance to the next vertex."""
    there = raw_series(coarse.model.surface, solve_depths(coarse.contact, delta))
    surface = fine.contact.surface
    vertices = surface.radii[surface.is_vertex]
    k = np.clip(np.searchsorted(vertices, a * (1 - ROUNDED)), 0, vertices.size - 2)
    change = np.maximum(caution * np.abs(there.a / a - 1), (vertices[k + 1] - vertices[k]) / a)
    return there.P, _envelope(change, delta)


def load_at(contact: SurfaceContact, delta: Array) -> Array:
    """P [N] at depths ``delta`` [m] of a disc that grows node by node: linear between the nodes' touches."""
    k = contact.set_at(delta)
    return contact.S[k] * delta - contact.T[k]


def _radius(levels: Sequence[Events], a: Array, delta: Array, caution: float) -> Array | Unknown:
    """Relative error of the radius: what larger elements change at equal depth (a vertex radius is off by a fraction of
    the spacing), plus where the series' radii differ from the events' (increments); ``levels``: from the finest on.

    Below the meshes' first events, where the spacing is uniform, the change grows like the inverse radius.
    """
    events, coarse = levels[:2]
    first, last = max(coarse.delta[0], events.delta[0]), min(coarse.delta[-1], events.delta[-1])
    if first >= last or delta[-1] < first:
        return Unknown("no radius common to the mesh and its coarser companion")
    fine = power_interpolated(events.delta, events.a, delta)
    samples = np.unique(np.clip(np.concatenate([delta, coarse.delta, events.delta]), first, last))
    radii = [power_interpolated(level.delta, level.a, samples) for level in levels]
    changes = np.maximum(caution * _change(radii, TUNING.plausible_radii), TUNING.round_off)
    changes = _envelope(changes, samples)
    at_first = power_interpolated(events.delta, events.a, np.array([first]))
    change = np.interp(delta, samples, changes) * np.maximum(at_first / fine, 1.0)
    return _envelope(change + np.abs(a / fine - 1), delta)


def _slopes(run: Run, coarse: MeshLevel, caution: float, radius: Array) -> dict[str, Array]:
    """Relative errors of S and dS: what larger elements change at equal radius, which is most that of the radius, and
    of S what the error of the ``radius`` makes of it, as meshes agree by accident; empty where either level has none.
    """
    a, delta, _ = run.columns
    if run.raw is not None:  # increments have no slopes of their own
        return {}
    ours, theirs = run.level.slopes(a), coarse.slopes(a)
    if ours is None or theirs is None:
        return {}
    S, dS = (_envelope(caution * np.abs(other / own - 1), delta) for own, other in zip(ours, theirs, strict=True))
    return {"S": np.maximum(S, a * ours[1] / ours[0] * radius), "dS": dS}


def truncation_of(run: Run, coarse: MeshLevel) -> Estimate:
    """Relative error of P at the deepest point from where the body is cut. Half-spaces: Betti's theorem, to first order
    in contact radius over size, which a completed body contains. Stacks on a rigid base: a free against a roller side,
    on the mesh of ``coarse``."""
    model, events, body = run.level.model, run.level.touches, run.level.model.body
    if body.cut_below:
        reached = events.delta >= run.deepest * (1 - ROUNDED)
        last = int(np.argmax(reached)) if events.valid and reached.any() else events.S.size - 1
        lacking = abs(model.missing) * float(events.S[last])
        return lacking**2 if body.completed else lacking
    if not body.cut_beside:
        return 0.0
    free = coarse.contact
    roller = replace(free, surface=coarse.model.with_roller().surface)
    depth = np.array([run.deepest])
    if events.valid:
        return float(abs(load_at(roller, depth)[0] / load_at(free, depth)[0] - 1))
    return abs(solve_depths(roller, depth)[0].P / solve_depths(free, depth)[0].P - 1)

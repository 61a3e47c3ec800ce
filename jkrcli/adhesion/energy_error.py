"""Errors of the energies of a cycle: of the energy lost, and of the work of separation.

An energy is W = int P dx along stable states, x the position of the device. Where these err by e_P and e_delta,

    dW = int (e_P d(delta) - e_delta dP) + P e_x at the state in which contact is lost,

where x is stationary, so that its place does not count; nor does a state without load, or one at a given x. What an
approach and a retraction on one curve have in common cancels.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from ..base.errors import Estimate, JkrError, Unknown
from .curve import AdhesiveCurve, EquilibriumCurve, position
from .device_path import Follow, Path, QuasiStatic, shrink
from .pull_off_error import larger_elements
from .stability import Cycle, cycle, separation_work

LEFT = 3.0  # of what doubling elements changes, over (ratio - 1); tuned on random bodies of `make point-bounds`
TABULATED = 1e-10  # theory: share of an energy that cubics between the tabulated functions leave (``interpolation.py``)
Change = Callable[[EquilibriumCurve], EquilibriumCurve]  # to another curve of the same body


def energy_lost_error(whole: Cycle) -> Estimate:
    """90 % half-width of the energy lost per cycle [J], or why it is unknown."""
    advancing, receding, k = whole.contact.advancing, whole.contact.receding, whole.stiffness
    low, high = whole.retraction.last, whole.approach.stretches[0].place
    above = 1 - math.sqrt(advancing.w / receding.w) if receding.w > 0 else 1.0  # of the errors, what does not cancel
    parts = [(low, max(high, low), 1.0), (high, max(whole.turn, high), above)]

    def again(change: Change) -> Estimate:
        turn = None if whole.turn == advancing.places[-1] else whole.turn
        other = cycle(change(advancing), change(receding), k, turn)
        return other if isinstance(other, Unknown) else other.energy_lost

    return _error(whole.energy_lost, receding, again, _by_points(whole.retraction, parts))


def separation_error(retraction: Path) -> Estimate:
    """90 % half-width of the work of separation [J] of a ``retraction``, or why it is unknown."""
    contact, parts = retraction.contact, list[tuple[float, float, float]]()
    assert isinstance(contact, QuasiStatic)
    for piece in reversed(retraction.pieces):
        last = piece.unloaded()
        follow = last or piece
        if isinstance(follow, Follow):
            parts.append((follow.end, follow.place, 1.0))
        if last is not None:
            break

    def again(change: Change) -> Estimate:
        other = QuasiStatic(change(contact.advancing), change(contact.receding), contact.stiffness)
        return separation_work(shrink(other, min(retraction.stretches[0].place, float(other.receding.places[-1]))))

    return _error(separation_work(retraction), contact.receding, again, _by_points(retraction, parts))


def _error(
    energy: Estimate, curve: EquilibriumCurve, again: Callable[[Change], Estimate], by_points: Estimate
) -> Estimate:
    """The half-width of an ``energy`` [J] that ``again`` finds on other curves: what leaving out every second point
    changes, and what larger elements do, else what the errors of the points make of it, ``by_points``."""
    if isinstance(energy, Unknown):
        return energy
    thinned = [_tried(again, lambda one, half=half: one.halves[half]) for half in (0, 1)]  # type: ignore[misc]
    between = [abs(other - energy) for other in thinned if not isinstance(other, Unknown)]
    if not between:
        return Unknown("unknown: with every second row left out contact is not lost in the series")
    by_mesh = _by_mesh(energy, curve, again)
    of_points = by_points if by_mesh is None else by_mesh
    if isinstance(of_points, Unknown):
        return of_points
    return max(between) / curve.thinning + of_points + TABULATED * abs(energy)


def _by_mesh(energy: float, curve: EquilibriumCurve, again: Callable[[Change], Estimate]) -> float | None:
    """What is left of an ``energy`` [J] by the changes to larger and larger elements; None where there are none."""
    coarser = curve.series.coarser
    if not isinstance(curve, AdhesiveCurve) or coarser is None:
        return None

    def on(level: int) -> Change:
        def change(one: EquilibriumCurve) -> EquilibriumCurve:
            assert isinstance(one, AdhesiveCurve)
            return AdhesiveCurve(larger_elements(one.nonadhesive)[level], one.w)

        return change

    others = [_tried(again, on(level)) for level in range(len(larger_elements(curve.nonadhesive)))]
    known = [energy, *itertools.takewhile(lambda other: not isinstance(other, Unknown), others)]
    if len(known) < 2:
        return None
    changes = np.diff(np.array(known, dtype=float)) / coarser.ratio ** (2.0 * np.arange(len(known) - 1))
    return LEFT / (coarser.ratio - 1) * float(np.sqrt(np.mean(changes**2)))


def _tried(again: Callable[[Change], Estimate], change: Change) -> Estimate:
    """The energy [J] on other curves, Unknown where they do not have it."""
    try:
        return again(change)
    except JkrError as error:
        return Unknown(str(error))


def _by_points(retraction: Path, parts: Sequence[tuple[float, float, float]]) -> Estimate:
    """What the errors of the points make of the work [J] on ``parts`` of a curve, each from one place to another [m]
    and counted by a factor, and where contact is lost."""
    contact = retraction.contact
    curve, k = contact.recede.curve, contact.stiffness
    if not curve.errors:
        return Unknown(f"unknown: {curve.slopes.error}")
    total = 0.0
    for low, high, factor in parts:
        if high > low:
            places, weights = curve.path(low, high)
            e, (ddelta, dP) = curve.error_at(places), curve.rates(places)
            total += factor * float(np.sum(weights * (e["P"] * np.abs(ddelta) + e["delta"] * np.abs(dP))))
    last = np.array(retraction.last)
    e = curve.error_at(last)
    return total + abs(float(curve.at(last)[1])) * float(position(e["delta"], e["P"], k))

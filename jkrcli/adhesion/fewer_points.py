"""What the points of a tabulated profile leave open where contact is lost: how far fewer points move that state.

At given contact radius fewer points change delta and P by d(a): the value changes by d, and the place by the slope of
the position made of d over the bend of the curve, and along with it what varies there. Errors of F that cancel in
the loads (a rigid shift of the profile leaves P as it is) cancel here too. Between points d passes through zero,
elsewhere than the table's own error does: its mean square within an interval of the table on either side counts, of two
profiles the larger. The order of the table's own error says what is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import Array
from ..bodies import Indenter
from .curve import Equilibrium, position


@dataclass(frozen=True)
class FewerPointsTuning:
    """Radii at which fewer points are looked at, and what is concluded."""

    left: float = 1.8  # of what the order leaves of a mean; tuned on tables, by `make range-bounds`
    radii: int = 6  # on either side; choice: some to an interval
    # of the radius, how far the outermost lie at least, and over which other panels tell how far a point moves; choice:
    # the contact is still like it
    nearest: float = 0.02
    farthest: float = 1.5  # and the factor by which at most; choice: the contact is still like it
    bend: int = 2  # on either side, through which the bend is that of a parabola; choice: with room for rounding


TUNING = FewerPointsTuning()


def error_by_points(
    indenter: Indenter, columns: Callable[[Array], list[Array]], point: Equilibrium, stiffness: float, end: float
) -> Array:
    """Half-widths (2,) of delta [m] and P [N] at a critical ``point`` under a device of ``stiffness`` [N/m].

    ``columns``: delta and P, (2, n), at contact radii up to ``end`` [m], under the table ``indenter`` and under the
    profiles through fewer of its points.
    """
    a, middle = _around(indenter, point.a, end), TUNING.radii
    values, *others = columns(a)
    changes = np.stack(others) - values
    rates = np.gradient(np.asarray(position(changes[:, 0], changes[:, 1], stiffness)), a, axis=-1)
    near = slice(middle - TUNING.bend, middle + TUNING.bend + 1)
    x = a[near] - a[middle]
    bend = 2 * np.polyfit(x, np.asarray(position(values[0], values[1], stiffness))[near], 2)[0]
    along = np.polyfit(x, values[:, near].T, 2)[1]
    of_F, of_slope, of_mean = indenter.left(np.array([point.a, point.a if point.c is None else point.c])).max(axis=1)
    moved = of_slope * _largest_mean(rates) / abs(bend)
    value = max(of_F, of_mean) * _largest_mean(changes)
    return TUNING.left * np.hypot(value, along * moved)


def _largest_mean(changes: Array) -> Array:
    """Over the profiles, the first axis, the largest of the roots of the mean squares along the radii, the last one."""
    largest: Array = np.sqrt(np.mean(changes**2, axis=-1)).max(axis=0)
    return largest


def _around(indenter: Indenter, a: float, end: float) -> Array:
    """Contact radii [m] from an interval of the table below ``a`` to one above, the middle one ``a`` itself."""
    knots = np.array([0.0, *indenter.joints])
    after = int(np.clip(np.searchsorted(knots, a), 1, knots.size - 1))
    width = max(knots[after] - knots[after - 1], TUNING.nearest * a)
    below, above = max(a - width, a / TUNING.farthest), min(a + width, a * TUNING.farthest, end)
    steps = np.arange(TUNING.radii + 1) / TUNING.radii
    return np.concatenate([below + (a - below) * steps, a + (above - a) * steps[1:]])

"""The contact law that a particle code needs: load and contact radius over the overlap, on the branch that is stable
under displacement control, with the points where contact begins and is lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError, Unknown
from ..base.numerics import MOST_SOLVES, Array, zeros_between
from .curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, CriticalPoint, Equilibrium, EquilibriumCurve
from .stability import stability_under

# How finely the law is tabulated.
DEM_FEWEST = 65  # tuned on contact laws, by `make constants`: rows to begin with, doubled until the law is met
# tuned on contact laws, by `make constants`: of the interpolation, relative to the largest load or radius
DEM_ERROR = 1e-6


@dataclass(frozen=True, eq=False)
class DemLaw:
    """A contact law as a table over x = sqrt(delta - delta_tear), in which P and a are smooth: at the tear-off their
    slopes over delta are infinite.

    ``delta, P, a`` [m, N, m]: rows at equal steps of x, from the tear-off on. ``tear_off``: where contact is lost under
    displacement control; ``load``: under load control, None where the table ends before; ``jump_in``: the state after
    first touch at delta = 0. ``error``: the largest of the cubic interpolation, relative to the largest |P| and a.
    ``vectors`` (12, 3): delta, P, a of the curve itself between the rows, with which an implementation is checked.
    """

    delta: Array
    P: Array
    a: Array
    tear_off: CriticalPoint
    load: CriticalPoint | None
    jump_in: Equilibrium
    error: float
    vectors: Array

    @classmethod
    def of(cls, curve: EquilibriumCurve) -> DemLaw:
        """The law of an adhesive curve; InputError where it is none of one branch."""
        stiff, soft = (stability_under(curve, stiffness) for stiffness in (DISPLACEMENT_CONTROL, LOAD_CONTROL))
        if isinstance(stiff.pull_off, Unknown):
            raise InputError(f"tear-off under displacement control is needed: {stiff.pull_off}")
        if stiff.partial:
            raise InputError(f"contact shrinks by {len(stiff.partial)} jumps before it is lost: no law of one branch")
        if isinstance(stiff.jump_in, Unknown):
            raise InputError(f"the state after first touch is needed: {stiff.jump_in}")
        load = None if isinstance(soft.pull_off, Unknown) else soft.pull_off
        for rows in ((DEM_FEWEST - 1) * 2**step + 1 for step in range(MOST_SOLVES)):
            delta, P, a = _branch(curve, stiff.pull_off, np.linspace(0, 1, rows))
            between = (np.arange(rows - 1) + 0.5) / (rows - 1)
            exact = _branch(curve, stiff.pull_off, between)
            error = max(float(np.abs(interpolated(column, between) - values).max() / np.abs(values).max())
                        for column, values in zip((P, a), exact[1:], strict=True))  # fmt: skip
            if error <= DEM_ERROR:
                break
        else:
            raise InputError(f"{rows} rows meet the law within {error:.1g} only: give a solution of more radii")
        chosen = np.linspace(0, between.size - 1, 12).round().astype(int)
        return cls(delta, P, a, stiff.pull_off, load, stiff.jump_in, error, np.column_stack(exact)[chosen])


def interpolated(column: Array, x: Array) -> Array:
    """The column of rows at equal steps of x in 0 ... 1 at ``x`` (n,), by the cubic through the four next rows."""
    last = column.size - 1
    first = np.clip(np.floor(x * last).astype(int) - 1, 0, last - 3)
    s = x * last - first
    weights: Sequence[Array] = (
        -(s - 1) * (s - 2) * (s - 3) / 6,
        s * (s - 2) * (s - 3) / 2,
        -s * (s - 1) * (s - 3) / 2,
        s * (s - 1) * (s - 2) / 6,
    )
    return np.asarray(sum(weight * column[first + i] for i, weight in enumerate(weights)))


def _branch(curve: EquilibriumCurve, tear_off: CriticalPoint, x: Array) -> tuple[Array, Array, Array]:
    """delta, P and a of the stable branch at fractions ``x`` of sqrt(delta - delta_tear)."""
    first, last = tear_off.place, float(curve.places[-1])
    span = float(curve.at(np.array([last]))[0][0]) - tear_off.delta
    delta = tear_off.delta + span * x**2
    ends = np.full_like(x, first), np.full_like(x, last)
    places = np.where(x == 0, first, zeros_between(lambda place: curve.at(place)[0] - delta, *ends, 0.0))
    return delta, curve.at(places)[1], curve.contact_radii(places)

"""One mesh with the contact problem solved on it, and its answer to a loading."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import Array, StageClock
from ...bodies import Indenter, Problem
from ...series import RawSeries, filter_plateaus
from .edge import edge_correction
from .loading import Columns, power_interpolated, raw_series
from .model import Discretisation, Model
from .nested import Events, Increment, StuckContact, SurfaceContact, nested_events

FEWEST = 4  # events for slopes; theory: S takes two, dS/da three, and its error one more
SPARE = 2  # events beyond the end of the loading; theory: the end lies between two, and dS/da takes one more
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class MeshLevel:
    """One mesh of a sequence, with the contact problem solved on it; every part is computed once, when first needed.

    ``model`` under ``indenter``: the ``contact`` problem and its ``touches`` (events with the radii of vertices);
    ``correct``: whether the edge of the contact is sought between the vertices.
    """

    model: Model
    indenter: Indenter
    contact: SurfaceContact
    touches: Events
    correct: bool

    @classmethod
    def of(cls, recipe: Discretisation, indenter: Indenter, correct: bool, deepest: float) -> MeshLevel:
        """Mesh and solve ``recipe`` out to the depth ``deepest`` [m], or its last candidate."""
        model = recipe.build(StageClock())
        contact = model.contact(indenter)
        return cls(model, indenter, contact, nested_events(contact, indenter.a0, "depth", deepest, SPARE), correct)

    @cached_property
    def events(self) -> Events:
        """The touches with the radii of the contact."""
        if not self.correct:
            return self.touches
        if isinstance(self.contact, StuckContact):
            edges = self.contact.edges[np.searchsorted(self.model.surface.radii, self.touches.a)]
            return replace(self.touches, a=edges)
        factors = edge_correction(self.model, self.indenter)
        return replace(self.touches, a=self.touches.a * factors[: self.touches.a.size])

    def slopes(self, a: Array) -> tuple[Array, Array] | None:
        """S [N/m] and dS/da [N/m^2] at radii ``a`` [m]; None where the contact has too few nodes, or no correction.

        From one touch to the next P(delta) is linear for each contact set, so that the increments of P over delta are
        the mean of those sets' stiffness, and belong to the mean radius on the way; dS/da are their differences.
        """
        events = self.events
        if not (self.correct and events.valid) or events.a.size < FEWEST:
            return None
        S, at = np.diff(events.P) / np.diff(events.delta), self._mean_radii()
        dS, middle = np.diff(S) / np.diff(at), (at[1:] + at[:-1]) / 2
        if not (dS > 0).all():
            return None
        return power_interpolated(at, S, a), power_interpolated(middle, dS, a)

    def _mean_radii(self) -> Array:
        """Mean of the radius over delta from each touch to the next [m]."""
        delta, a0 = self.events.delta, self.indenter.a0
        inner = delta[:-1, None] + np.diff(delta)[:, None] * (1 + GAUSS_X) / 2
        radii = power_interpolated(delta, self.events.a - a0, inner.ravel()).reshape(inner.shape)
        return a0 + radii @ GAUSS_W / 2


@dataclass(frozen=True, eq=False)
class Run:
    """One mesh's answer to the loading of ``problem``: the ``columns`` of the series on ``level``; where the loading
    was followed in ``increments``, these, their ``raw`` series and the number of those ``dropped`` from it."""

    problem: Problem
    level: MeshLevel
    columns: Columns
    increments: tuple[Increment, ...] = ()
    raw: RawSeries | None = None
    dropped: int = 0

    @classmethod
    def of_increments(cls, problem: Problem, level: MeshLevel, increments: list[Increment]) -> Run:
        """The increments with those dropped whose radius is not their own (the paper's filter)."""
        raw = raw_series(level.model.surface, increments)
        series, dropped = filter_plateaus(raw)
        return cls(problem, level, (series.a, series.delta, series.P), tuple(increments), raw, dropped)

    @property
    def deepest(self) -> float:
        """Depth of the last point [m]."""
        return float(self.columns[1][-1])

    def companion(self, ratio: float) -> MeshLevel:
        """A solved mesh whose elements are ``ratio`` times as large."""
        recipe = self.level.model.discretisation.coarser(ratio)
        return MeshLevel.of(recipe, self.problem.indenter, self.level.correct, self.deepest)

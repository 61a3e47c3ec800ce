"""A fitted raw record as hypotheses on it need it: radii, loads and positions of its rows, and what is known besides.

Columns are derivatives of the loads P of all rows at fixed positions z of the device. As delta = z - P/k, a change dP
at fixed displacement delta is dP (1 - P'/k) at fixed position, P' the derivative of the load by the position.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..base.errors import LEVEL
from ..base.numerics import Array, half_width
from .choices import Values
from .curve import APPROACH
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel, base_line
from .forward_model import FittedBody
from .priors import PRIORS, RANGE

# choice: a small amount: below it, and below such a share of the largest w, steps are no smaller; of the largest
# contact radius, the ring of attraction and the length of a surface tension at which columns are taken
CHANGE_SMALL = 1e-2
# rows about a fold, that no fall of chi^2 counts; tuned on right records, by `make record-rivals`
CHANGE_BESIDE = 1.5
CHANGE_FOLD = 0.02  # choice: of the way in contact, rows left out about folds and before the loss of a slow edge


@dataclass(frozen=True)
class Known:
    """What is known before the data: the longest ``range`` of adhesion [m] that is likely, or possible where ``told``
    by the user, and the largest surface ``tension`` [N/m], 0 where nothing is; and the ``level`` of intervals."""

    range: float = field(default_factory=lambda: PRIORS[RANGE].width)
    tension: float = 0.0
    level: float = LEVEL
    told: bool = False

    @property
    def quantile(self) -> float:
        """Half-width of intervals, in standard errors."""
        return half_width(self.level)


@dataclass(frozen=True, eq=False)
class FittedRecord:
    """The ``fit`` of a record of a ``body``, and what is ``known`` besides, as alternatives need them."""

    body: FittedBody
    fit: ForceCurveFit
    known: Known = field(default_factory=Known)

    @property
    def model(self) -> ForceCurveModel:
        return self.fit.model

    @cached_property
    def values(self) -> Values:
        """All unknowns, by name."""
        return self.model.values(self.fit.x)

    @cached_property
    def residuals(self) -> Array:
        """Residuals [N] of all rows."""
        return self.model.residuals(self.fit.x, 0.0)[0]

    @cached_property
    def jacobian(self) -> Array:
        """Their derivatives by the unknowns, (rows, unknowns)."""
        return self.model.residuals(self.fit.x, 0.0)[1]

    @property
    def regular(self) -> Array:
        """Which rows columns are trusted in: none next to a fold or first touch, where they diverge."""
        rows = []
        for part, (a, _) in zip(self.model.stretches, self.radii, strict=True):
            z, touching = part.z, a > 0
            first = z[touching].min() if touching.any() else math.inf
            span = max(CHANGE_FOLD * part.reach, 2 * part.spacing)
            rows.append(~touching | (z > first + span) if part.jumped else np.abs(z - first) > span)
        return np.concatenate(rows)

    @property
    def off_folds(self) -> Array:
        """Which rows are not right at the fold that a stretch jumps at: there the load rises with a root of the
        distance, so that a fold misplaced by less than from row to row leaves many times the noise, in a model that is
        right."""
        rows = []
        for part, (a, _) in zip(self.model.stretches, self.radii, strict=True):
            fold = part.z[a > 0].min() if part.jumped and (a > 0).any() else math.inf
            rows.append(np.abs(part.z - fold) > CHANGE_BESIDE * part.spacing)
        return np.concatenate(rows)

    def by_unknown(self, name: str) -> Array:
        """The column of the Jacobian that belongs to an unknown."""
        return self.jacobian[:, self.fit.names.index(name)]

    @property
    def retraction(self) -> DirectionReadings | None:
        return next((part for part in self.model.stretches if part.kind != APPROACH), None)

    @property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, and which of them rest."""
        return self.fit.radii

    @property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return self.fit.a

    @property
    def a_max(self) -> float:
        """Largest contact radius [m]."""
        return float(self.a.max())

    @property
    def modulus(self) -> float:
        """Factor of the body's moduli."""
        return math.exp(self.values["ln_s"])

    @property
    def E_star(self) -> float:
        """E* of the body as fitted [Pa]."""
        return self.modulus * self.body.problem.E_star

    @property
    def work(self) -> float:
        """The largest w of the directions [J/m^2], 0 where none adheres."""
        return max(0.0, *(self.values[f"q:{part.kind}"] for part in self.model.stretches)) * self.modulus

    @cached_property
    def neck(self) -> float:
        """(w^2 R/E*^2)^(1/3) [m], about how far adhesion deforms the body at pull-off: the range is that over Tabor's
        number."""
        R = self.body.problem.indenter.tip_radius or self.a_max
        return float((self.work**2 * R / self.E_star**2) ** (1 / 3))

    @cached_property
    def narrow_range(self) -> float:
        """The range z0 [m] of which the ring is ``CHANGE_SMALL`` a_max wide there: d = pi E* z0^2/(4 w)."""
        return math.sqrt(4 * CHANGE_SMALL * self.a_max * self.work / (math.pi * self.E_star))

    @property
    def P_H(self) -> Array:
        """Load [N] of all rows at their contact radii without adhesion."""
        load, touching = np.zeros(self.a.size), np.flatnonzero(self.a)
        load[touching] = self.modulus * self.model.family.values(np.log(self.a[touching]))[2]
        return load

    @property
    def loads(self) -> Array:
        """Loads of the contact [N] at all rows, of the model."""
        lines = np.concatenate([base_line(part, self.values)[0] for part in self.model.stretches])
        return np.concatenate([part.P for part in self.model.stretches]) + self.residuals - lines

    @property
    def depth(self) -> Array:
        """Position of the device beyond its zero [m], at all rows."""
        return np.concatenate([self.model.depth(part, self.values) for part in self.model.stretches])

    @cached_property
    def by_position(self) -> Array:
        """P', the derivative of the loads by the position of the device [N/m], its turn where it is."""
        return self.model.by_position(self.fit.x)

    @property
    def at_fixed_position(self) -> Array:
        """1 - P'/k: a change of load at fixed position over that at fixed displacement."""
        return 1 - self.by_position / self.model.k

    @property
    def reach(self) -> float:
        """How far the device moves in contact [m]."""
        return max(part.reach for part in self.model.stretches)

    def rows(self, part: DirectionReadings, chosen: Array | bool = True) -> Array:
        """Which rows of all are those of one stretch that are ``chosen``."""
        return np.concatenate([np.full(one.P.size, chosen if one is part else False) for one in self.model.stretches])

    def time(self, part: DirectionReadings) -> Array:
        """Time since the turn, in units of a whole record; by the number of rows where no column tells it."""
        if all(np.ptp(one.t) > 0 for one in self.model.stretches):
            return np.abs(part.t) / part.lasting
        return np.abs(part.rows - part.rows[-1]) / sum(float(np.ptp(one.rows)) for one in self.model.stretches)

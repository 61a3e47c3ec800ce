"""Changes of the model of a raw record by an amount: types of them, each by one method, and the model with one.

A ``Change`` alone is a column, the derivative of the loads. The others can be fitted, too: of the body's four functions
(``BodyChange``), of the positions (``PositionChange``), of the stiffness of the device (``StiffnessChange``), of the
loads (``LoadsChange``). ``ChangedModel`` is the model of a record with a change, whose search, covariance and result
are those of any record; derivatives by what a change depends on are differences. Each method takes the questions of
many records at once.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from operator import itemgetter
from typing import Any, Literal, NamedTuple

import numpy as np

from ..base.errors import JkrError, SolveError
from ..base.numerics import Array, PiecewiseCubic, cubic_spline
from ..base.process import REMEMBERED
from .branches import Moving, Resting
from .choices import Values
from .fitted_record import CHANGE_FOLD, CHANGE_SMALL, FittedRecord
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel, Loads, offs
from .forward_model import FUNCTIONS, Family, grid, on_grid
from .lockstep import by_groups
from .priors import PRIORS, UNLIKELY, Prior

AMOUNT, ANY = "amount", (-math.inf, math.inf)

# Differences by amounts.
CHANGE_LITTLE = 1e-3  # theory: relative amounts whose squares are below the noise of any record
CHANGE_STEP = 1e-5  # theory: relative, for one-sided differences of loads that are good to 1e-9; of histories more


LITTLE = CHANGE_LITTLE


# --------------------------------------------------------------------------------------------------
# A body whose four functions D = delta_H, T, H = P_H, V of the contact radius differ from another's.


@dataclass(frozen=True, eq=False)
class ChangedFamily(Family):
    """A family whose four logs differ by ``changes`` (4, nodes) from those of a ``body``, on its grid; beyond it they
    differ as at its ends. ``functions``: the four and their derivatives at the nodes, (4, 3, nodes)."""

    body: Family | None = None
    changes: Array = field(default_factory=lambda: np.empty(0))
    functions: Array = field(default_factory=lambda: np.empty(0))

    @cached_property
    def spline(self) -> PiecewiseCubic:
        assert self.body is not None
        return cubic_spline(grid(self.body), self.changes.T)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        near = np.clip(u, self.spline.x[0], self.spline.x[-1])
        g, first, second = (self.spline(near, order).T for order in range(3))
        value, by_u, by_uu = _changed(np.stack(super().at(u)), g, first, second)
        return value, by_u, by_uu

    def values(self, u: Array) -> Array:
        return super().values(u) * np.exp(self.spline(np.clip(u, self.spline.x[0], self.spline.x[-1])).T)

    def at_nodes(self, u: Array) -> Array:
        return self.functions


def changed_families(bodies: Sequence[Family], changes: Sequence[Array]) -> list[ChangedFamily]:
    """The families whose logs of D, T, H, V differ by ``changes`` (4, n) from those of ``bodies`` on their grids."""
    if not bodies:
        return []
    g, functions = np.array(changes), np.array([on_grid(body).swapaxes(0, 1) for body in bodies])
    if not np.isfinite(g).all():
        raise SolveError("no body has curves that differ so much")
    steps = np.array([(u[-1] - u[0]) / (u.size - 1) for u in map(grid, bodies)])
    which = of_family, _ = np.nonzero(g.any(axis=2))  # of each body some functions change
    some = g[which]
    functions[which] = _changed(functions[which].swapaxes(0, 1), some, *_rates(some, steps[of_family, None])).swapaxes(
        0, 1
    )
    return [
        ChangedFamily(body.logs, body.low, body.high, None, body, *own)
        for body, *own in zip(bodies, g, functions, strict=True)
    ]


def _changed(functions: Array, g: Array, first: Array, second: Array) -> Array:
    """Functions f e^g and their two derivatives by u, (3, ...), from those of f and of ``g``."""
    value, by_u, by_uu = functions
    rise = first * value
    changed: Array = np.stack([value, by_u + rise, by_uu + first * (rise + 2 * by_u) + second * value])
    changed *= np.exp(g)
    return changed


def _rates(g: Array, step: Array | float) -> tuple[Array, Array]:
    """Two derivatives of rows at even nodes, of fourth order but at the two of each end."""
    near, far = g[..., 1:-3], g[..., 3:-1]
    first, second = rates = np.empty((2, *g.shape))
    first[..., 2:-2] = (8 * (far - near) - g[..., 4:] + g[..., :-4]) / (12 * step)
    second[..., 2:-2] = (16 * (far + near) - g[..., 4:] - g[..., :-4] - 30 * g[..., 2:-2]) / (12 * step**2)
    rates[..., :2], rates[..., -2:] = rates[..., 2:3], rates[..., -3:-2]
    return first, second


def perturbed_logs(family: Family, D: Array, S: Array) -> Array:
    """Changes of the logs of D, T, H, V (..., 4, n) on the grid of a body whose logs of displacement and stiffness
    change by ``D`` and ``S`` (..., n) there: P_H = int S d(delta_H), and adhesion follows from S'."""
    u = grid(family)
    step = float(u[1] - u[0])
    (d, t, _, v), (dD, dT, _, dV), _ = on_grid(family)
    s, ds = v / t, v / t * (dV / v - dT / t)
    slope_D, slope_S = (np.gradient(rows, step, axis=-1, edge_order=2) for rows in (D, S))
    dS = np.exp(S) * (ds + s * slope_S)
    rate = s * np.exp(S + D) * (dD + d * slope_D)
    T = np.log(ds / dS) / 2
    H = np.log(_integral(u, rate) / _integral(u, s * dD))
    return np.stack([D, T, H, S + T], axis=-2)


def _integral(u: Array, rate: Array) -> Array:
    """The integral of a ``rate`` over even nodes ``u``, a power law's up to the first: by cubics through values and
    derivatives (Euler and Maclaurin)."""
    step, log, integral = float(u[1] - u[0]), np.log(rate[..., :2]), np.empty_like(rate)
    integral[..., 0] = rate[..., 0] * step / (log[..., 1] - log[..., 0])
    integral[..., 1:] = step / 2 * (rate[..., 1:] + rate[..., :-1]) - step**2 / 12 * np.diff(_rates(rate, step)[0])
    return np.cumsum(integral, axis=-1)


# --------------------------------------------------------------------------------------------------
# The types of a change.


class OfStretch(NamedTuple):
    """What a change is asked for: what it makes of a stretch, ``part``, of the ``plain`` model, at all ``values``."""

    change: Any
    plain: ForceCurveModel
    part: DirectionReadings
    values: Values


@dataclass(frozen=True, eq=False, kw_only=True)
class Change:
    """A change of the loads that is known by its ``column`` alone, the derivative [N] of all rows by the amount.

    Of those that can be fitted in full: ``starts``: values of the unknowns ``names`` to begin a search with;
    ``limits``: their least and largest; ``quantities``: what they mean, SI, by name. ``coupled``: whether the change
    depends on the other unknowns too. ``recentred``: the change about a fit that it led to, where it is made about one.
    ``where``: whether stretches change "all" alike, "each" by itself, or the "last" one alone.
    """

    column: Array | None = None
    names: tuple[str, ...] = (AMOUNT,)
    starts: tuple[tuple[float, ...], ...] = ((0.0,),)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    quantities: Callable[[Values], dict[str, float]] = lambda values: {AMOUNT: values[AMOUNT]}
    coupled: bool = False
    recentred: Callable[[ForceCurveFit], Change] | None = None
    where: Literal["all", "each", "last"] = "all"

    @property
    def in_full(self) -> bool:
        """Whether it can be fitted."""
        return type(self) is not Change

    def changes(self, part: DirectionReadings, model: ForceCurveModel) -> bool:
        """Whether it changes a stretch of a model."""
        return self.where != "last" or part is model.stretches[-1]

    @staticmethod
    def columns(asked: Sequence[tuple[FittedRecord, Any]]) -> list[Array | None]:
        """The columns of changes of this type of some records."""
        return [change.column for _, change in asked]

    @staticmethod
    def followed(asked: Sequence[OfStretch]) -> list[ForceCurveModel]:
        """The models that stretches follow."""
        return [one.plain for one in asked]


@dataclass(frozen=True, eq=False, kw_only=True)
class StiffnessChange(Change):
    """The stiffness of the device is 1 + the amount times as large."""

    @staticmethod
    def followed(asked: Sequence[OfStretch]) -> list[ForceCurveModel]:
        return [replace(one.plain, k=one.plain.k * (1 + one.values[AMOUNT])) for one in asked]


@dataclass(frozen=True, eq=False, kw_only=True)
class PositionChange(Change):
    """Rows of a stretch stand deeper than their positions say by the amount times an ``error`` [m]."""

    error: Callable[[DirectionReadings], Array]

    @staticmethod
    def columns(asked: Sequence[tuple[FittedRecord, Any]]) -> list[Array | None]:
        return [
            record.by_position * np.concatenate([change.error(part) for part in record.model.stretches])
            for record, change in asked
        ]


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadsChange(Change):
    """``loads`` of a stretch [N] in place of those of the path: of the "last" one with adhesion, or of "all" without;
    None where they are known to first order only."""

    loads: Loads | None = None

    @property
    def in_full(self) -> bool:
        return self.loads is not None


@dataclass(frozen=True, eq=False, kw_only=True)
class BodyChange(Change):
    """The logs of D, T, H, V on the grid of a family change by ``of`` it and the values, (4, n). ``per_amount``: their
    derivative by the amount, where it is not that at 0."""

    of: Callable[[Family, Values], Any]
    per_amount: Array | None = None

    @staticmethod
    def logs(asked: Sequence[OfStretch]) -> Sequence[Array]:
        """The changes of the logs, (4, n) each."""
        return [one.change.of(one.plain.family, one.values) for one in asked]

    @staticmethod
    def columns(asked: Sequence[tuple[FittedRecord, Any]]) -> list[Array | None]:
        new = [one for one in asked if one[1].column is None]
        numeric = iter(bodies_at([(*one, LITTLE) for one in new if one[1].per_amount is None]))
        bodies = [next(numeric) / LITTLE if change.per_amount is None
                  else np.broadcast_to(change.per_amount, (len(record.model.stretches), *change.per_amount.shape))
                  for record, change in new]  # fmt: skip
        own = [(record, body) for (record, _), body in zip(new, bodies, strict=True)]
        found = iter(by_groups(own, itemgetter(0), lambda record, some: by_bodies(record, [one for _, one in some])))
        return [next(found) if change.column is None else change.column for _, change in asked]

    @staticmethod
    def followed(asked: Sequence[OfStretch]) -> list[ForceCurveModel]:
        own = [one for one in asked if one.change.changes(one.part, one.plain)]
        families = iter(changed_families([one.plain.family for one in own], logs_of(own)))
        return [
            replace(one.plain, family=next(families)) if one.change.changes(one.part, one.plain) else one.plain
            for one in asked
        ]


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapeChange(BodyChange):
    """The same by changes of the logs of displacement and contact stiffness, from which the others follow."""

    @staticmethod
    def logs(asked: Sequence[OfStretch]) -> Sequence[Array]:
        def of_body(family: Family, some: list[OfStretch]) -> Array:
            D, S = zip(*(one.change.of(family, one.values) for one in some), strict=True)
            return perturbed_logs(family, np.array(D), np.array(S))

        return by_groups(asked, lambda one: one.plain.family, of_body)


def logs_of(asked: Sequence[OfStretch]) -> list[Array]:
    """The changes of the logs of bodies by changes of several types."""
    return by_groups(asked, lambda one: type(one.change).logs, lambda logs, some: logs(some))


def bodies_at(asked: Sequence[tuple[FittedRecord, BodyChange, float]]) -> list[Array]:
    """The changes of the logs of the bodies of records (stretches, 4, n) at amounts of changes, the other unknowns as
    they are."""
    each = [
        [OfStretch(change, record.model, part, {**record.values, AMOUNT: amount})
         for part in record.model.stretches if change.changes(part, record.model)]
        for record, change, amount in asked
    ]  # fmt: skip
    found, bodies = iter(logs_of([one for own in each for one in own])), list[Array]()
    for (record, *_), own in zip(asked, each, strict=True):
        body = np.zeros((len(record.model.stretches), FUNCTIONS, grid(record.model.family).size))
        body[-len(own) :] = [next(found) for _ in own]
        bodies.append(body)
    return bodies


def by_bodies(record: FittedRecord, bodies: Sequence[Array]) -> Array:
    """Derivatives of the loads [N] of all rows, (changes, rows), by an amount of each change of ``bodies``, (stretches,
    4, n) each."""
    each, columns, ends = np.array(bodies), np.zeros((len(bodies), record.model.ends[-1])), record.model.ends
    for i, (moving, resting, depth, rows, still) in enumerate(record.model.edges(record.fit.x)):
        changes, own = each[:, i], columns[:, ends[i] : ends[i + 1]]
        own[:, rows] = moving.by_body(depth[rows], record.model.stretches[i].spacing / 2, changes)
        if resting is not None:
            own[:, still] = resting.by_body(depth[still], moving.nodes.u, changes)
    return columns


# --------------------------------------------------------------------------------------------------
# The model of a record with a change.


@dataclass(frozen=True, eq=False)
class ChangedModel(ForceCurveModel):
    """The model of a record with a ``change``."""

    change: Change = Change()

    @classmethod
    def of(cls, plain: ForceCurveModel, change: Change, known: Values | None = None) -> ChangedModel:
        """The ``plain`` model, of an alternative or not, with a change in place of its own, of whose unknowns some may
        be ``known``."""
        inputs = _inputs(plain)
        inputs["known"] = {**plain.known, **(known or {})}
        if isinstance(change, LoadsChange) and change.where == "last":
            last = plain.stretches[-1]
            if last.touching.any():  # a slow edge runs through the rows next to its loss within a few of them
                lost = float(last.z[last.touching].min())
                keep = ~last.touching | (last.z > lost + max(CHANGE_FOLD * last.reach, 2 * last.spacing))
                names = "rows", "z", "P", "touching", "t"
                last = replace(last, **{name: getattr(last, name)[keep] for name in names})
            inputs["stretches"] = (*plain.stretches[:-1], last)
        elif isinstance(change, LoadsChange):  # which knows no adhesion
            inputs["works"] = {part.kind: 0.0 for part in plain.stretches}
        return cls(**inputs, change=change)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return (*super().names, *(name for name in self.change.names if name not in self.known))

    @property
    def limits(self) -> Mapping[str, tuple[float, float]]:
        return {**super().limits, **self.change.limits}

    def further(self, values: Values) -> dict[str, float]:
        return self.change.quantities(values)

    @cached_property
    def plain(self) -> ForceCurveModel:
        """The model without the change."""
        return ForceCurveModel(**_inputs(self))

    @cached_property
    def remembered(self) -> dict[object, ForceCurveModel]:
        """The models that stretches follow, the last ones, by ``key``."""
        return {}

    def key(self, part: DirectionReadings, values: Values) -> object:
        """What the model that a stretch follows depends on."""
        own = values.values() if self.change.coupled else map(values.__getitem__, self.change.names)
        return part.kind if self.change.where != "all" else "", *own

    def followed(self, part: DirectionReadings, values: Values) -> ForceCurveModel:
        """The plain model that a stretch follows."""
        if (key := self.key(part, values)) not in self.remembered:
            follow([(self, part, values)])
        return self.remembered[key]

    def moving(self, part: DirectionReadings, values: Values) -> Moving:
        return self.followed(part, values).moving(part, values)

    def resting(self, part: DirectionReadings, values: Values) -> Resting | None:
        return self.followed(part, values).resting(part, values)

    def depth(self, part: DirectionReadings, values: Values) -> Array:
        depth = super().depth(part, values)
        return depth + values[AMOUNT] * self.change.error(part) if isinstance(self.change, PositionChange) else depth

    def completed(self, x: Array, blunt: float, off: Array, rates: Array) -> Array:
        of_history, moved = isinstance(self.change, LoadsChange) and self.change.where == "all", dict[int, float]()
        for i, name in enumerate(self.names):
            if name in self.change.names or (self.change.coupled and name.startswith(("ln_s", "q:", "r:", "z0"))):
                size = max(abs(float(x[i])), CHANGE_SMALL * (self.most if name.startswith(("q:", "r:")) else 1.0))
                size = max(part.reach for part in self.stretches) if name == "z0" else size
                step = (LITTLE if of_history else CHANGE_STEP) * size
                moved[i] = -step if x[i] + step > self.limits.get(name, (0.0, math.inf))[1] else step
        each = changed_offs([(self, x + step * (np.arange(x.size) == i), blunt) for i, step in moved.items()])
        for (i, step), there in zip(moved.items(), each, strict=True):
            if isinstance(there, Exception):
                raise there
            rates[i] = (there - off) / step
        return rates

    def in_place_of_path(self, part: DirectionReadings) -> Loads | None:
        change = self.change
        return change.loads if isinstance(change, LoadsChange) and change.changes(part, self) else None


def _inputs(model: ForceCurveModel) -> dict[str, Any]:
    """The arguments that make a model without its change."""
    return {item.name: getattr(model, item.name) for item in fields(ForceCurveModel)}


def follow(asked: Iterable[tuple[ChangedModel, DirectionReadings, Values]]) -> None:
    """Find the models that stretches follow, those of all together, each remembered by its model."""
    new = {
        (model, key): OfStretch(model.change, model.plain, part, values)
        for model, part, values in asked if (key := model.key(part, values)) not in model.remembered
    }  # fmt: skip
    models = by_groups([*new.values()], lambda one: type(one.change).followed, lambda of, some: of(some))
    for (model, key), one in zip(new, models, strict=True):
        if len(model.remembered) >= REMEMBERED:
            model.remembered.clear()
        model.remembered[key] = one


@np.errstate(all="ignore")
def changed_offs(asked: Sequence[tuple[ChangedModel, Array, float]]) -> list[Array | Exception]:
    """Model minus reading [N] of all rows of models with changes, whose bodies are found together."""
    each = [(model, model.values(x)) for model, x, _ in asked]
    with contextlib.suppress(JkrError, ArithmeticError):  # of one of them, which tells so itself
        follow((model, part, values) for model, values in each for part in model.stretches)
    return offs(asked)


def root_of(values: Values, kind: str) -> float:
    """r = sqrt(w/s) of a direction."""
    return values.get(f"r:{kind}", math.sqrt(max(values[f"q:{kind}"], 0.0)))


# --------------------------------------------------------------------------------------------------
# Entries of the list of hypotheses.

CHANGE_BEYOND = 1.5  # choice: over the largest depth or contact radius of a record, where changed bodies end
BODY, TIP, ADHESION = "layer or substrate", "shape of the tip", "adhesion"
DEVICE, MEMORY = "instrument", "relaxation or flow"
# What the unknowns of alternatives mean, by dimension:
OF_ALTERNATIVES = {
    AMOUNT: "number", "thickness": "length", "nu": "number", "exponent": "number", "range": "length",
    "surface_tension": "tension", "stiffness": "stiffness", "fall": "number", "relaxation_time": "time", "n": "number",
    "creep": "number", "hysteresis": "number",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class AlternativeModel:
    """Name one thing that the fitted model leaves out: an entry of ``ALTERNATIVES``.

    Parameters
    ----------
    name : str
        As the table of alternatives shows it, and that of ``PRIORS`` calls it.
    family : str
        What cannot be distinguished from it as a rule.
    amount : str
        What a column is the derivative by, in words.
    change : callable
        Of a FittedRecord: the Change of its model; None where it has no meaning for this record.
    likely : callable, optional
        Of a FittedRecord: the amount that is likely, where it is not the width of the prior.
    of_directions : bool, optional
        Whether it sets one direction against the other.
    """

    name: str
    family: str
    amount: str
    change: Callable[[FittedRecord], Change | None]
    likely: Callable[[FittedRecord], float] | None = None
    of_directions: bool = False

    @property
    def prior(self) -> Prior:
        return PRIORS.get(self.name, UNLIKELY)

    def likely_in(self, record: FittedRecord) -> float:
        """The amount in either direction that is likely in a record."""
        return self.prior.width if self.likely is None else self.likely(record)

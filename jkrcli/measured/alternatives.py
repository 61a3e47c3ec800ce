"""The alternatives of a raw record: what the model leaves out, each as the change of all loads that a little of it
makes.

``ALTERNATIVES`` is the list: an entry is a name, its family, what its amount is, its effect, and how much of it is
likely before the data. The effect is a change of the model, or a column alone: the derivative of the loads [N] by the
amount, at fixed positions of the device. The data are asked for each by its score (``alternative_tests.py``).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache, partial
from typing import Any, TypeAlias, cast

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import Program
from ..adhesion.validity import EXCESS, LIMITS, STRAINED
from ..base.errors import InputError, JkrError, SolveError
from ..base.numerics import (
    LEVEL,
    MOST_STEPS,
    REMEMBERED,
    SAME,
    SETTLED,
    UNSEEN,
    Array,
    PiecewiseCubic,
    PiecewisePolynomial,
    cubic_spline,
    half_width,
    median,
)
from ..base.wings import is_offered, offered
from ..bodies.problem import (
    HalfSpace,
    Layer,
    Loading,
    PowerRelaxation,
    Relaxation,
    Rigid,
    Specimen,
    StandardSolid,
    without_side_walls,
)
from ..methods.radii import DENSE
from .branches import Moving, Resting, rest
from .curve import APPROACH
from .force_curve import (
    SLOW_EDGE_WIDEST,
    DirectionReadings,
    Edges,
    ForceCurveFit,
    ForceCurveModel,
    Loads,
    base_line,
    creep,
    hysteresis,
    load_at,
    offs,
    receding,
)
from .forward_model import FAMILY_BELOW_LIMIT, FUNCTIONS, Family, FittedBody, grid, on_grid, solved
from .settings import LONGEST_RANGE

# --------------------------------------------------------------------------------------------------
# An alternative model in full: the model of a raw record with an amount of what it leaves out as one more unknown, or
# two.
#
# A ``Perturbation`` says what an amount does to the body, the device or the positions of a stretch; ``ChangedModel`` is
# the model with it, whose search, covariance and result are those of any record. Derivatives by what a change depends
# on are differences.

AMOUNT, ANY = "amount", (-math.inf, math.inf)
Values = Mapping[str, float]  # of all unknowns, by name
Shape = Callable[[Family, float], tuple[Array, Array]]  # changes of the logs of displacement and stiffness (n,)

# Differences by amounts, and how far alternatives are followed.
CHANGE_LITTLE = 1e-3  # theory: relative amounts whose squares are below the noise of any record
CHANGE_STEP = 1e-5  # theory: relative, for one-sided differences of loads that are good to 1e-9; of histories more
# choice: a small amount: below it, and below such a share of the largest w, steps are no smaller; of the largest
# contact radius, the ring of attraction and the length of a surface tension at which columns are taken
CHANGE_SMALL = 1e-2
CHANGE_LARGEST = 6.0  # choice: amount up to which alternatives are searched where theory sets no limit
CHANGE_BEYOND = 1.5  # choice: over the largest depth or contact radius of a record, where changed bodies end
CHANGE_FOLD = 0.02  # choice: of the way in contact, rows left out about folds and before the loss of a slow edge


LITTLE = CHANGE_LITTLE


@dataclass(frozen=True, eq=False)
class ChangedFamily(Family):
    """A family whose four logs differ by ``changes`` (4, nodes) from those of a ``body``, on its grid; beyond it they
    differ as at its ends."""

    body: Family | None = None
    changes: Array = field(default_factory=lambda: np.empty(0))

    @cached_property
    def spline(self) -> PiecewiseCubic:
        assert self.body is not None
        return cubic_spline(grid(self.body), self.changes.T)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        near = np.clip(u, self.spline.x[0], self.spline.x[-1])
        g, first, second = (self.spline(near, order).T for order in range(3))
        value, by_u, by_uu = _changed(np.stack(super().at(u)), g, first, second, np.empty((3, *g.shape)))
        return value, by_u, by_uu

    def values(self, u: Array) -> Array:
        values: Array = super().values(u) * np.exp(self.spline(np.clip(u, self.spline.x[0], self.spline.x[-1])).T)
        return values

    @cached_property
    def functions(self) -> Array:
        """The four and their derivatives at the nodes of its grid, (4, 3, nodes)."""
        return _changed_functions([self])[0]

    def at_nodes(self, u: Array) -> Array:
        return self.functions


def _changed_functions(families: Sequence[ChangedFamily]) -> Array:
    """The ``functions`` of families: those of their bodies, of which some change."""
    bodies, g = [one.body for one in families if one.body is not None], np.array([one.changes for one in families])
    functions = np.array([on_grid(body).swapaxes(0, 1) for body in bodies])
    steps = np.array([(u[-1] - u[0]) / (u.size - 1) for u in map(grid, bodies)])
    which = of_family, _ = np.nonzero(g.any(axis=2))
    plain, g = functions[which].swapaxes(0, 1), g[which]
    functions[which] = _changed(plain, g, *_rates(g, steps[of_family, None]), np.empty(plain.shape)).swapaxes(0, 1)
    return functions


def _changed(functions: Array, g: Array, first: Array, second: Array, changed: Array) -> Array:
    """Functions f e^g and their two derivatives by u, from those of f and of ``g``, as ``changed`` (3, ...)."""
    value, by_u, by_uu = functions
    rise = first * value
    changed[0] = value
    np.add(by_u, rise, out=changed[1])
    rise += 2 * by_u
    rise *= first
    rise += by_uu
    np.add(rise, second * value, out=changed[2])
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


def changed_family(family: Family, changes: Array) -> Family:
    """The family whose logs of D, T, H, V differ by ``changes`` (4, n) on its grid."""
    if not np.isfinite(changes).all():
        raise SolveError("no body has curves that differ so much")
    return ChangedFamily(family.logs, family.low, family.high, None, family, changes)


def perturbed_logs(family: Family, D: Array, S: Array) -> Array:
    """Changes of the logs of D, T, H, V (..., 4, n) on the grid of a body whose logs of displacement and stiffness
    change by ``D`` and ``S`` (..., n) there: P_H = int S d(delta_H), and adhesion follows from S'."""
    u = grid(family)
    step = float(u[1] - u[0])
    (d, t, _, v), (dD, dT, _, dV), _ = on_grid(family)
    s, ds = v / t, v / t * (dV / v - dT / t)
    dS = np.exp(S) * (ds + s * _slope(S, step))
    rate = s * np.exp(S + D) * (dD + d * _slope(D, step))
    T = np.log(ds / dS) / 2
    return np.stack([D, T, np.log(_integral(u, rate) / _plain_integral(family)), S + T], axis=-2)


def _slope(rows: Array, step: float) -> Array:
    """The derivative at even nodes, of second order."""
    slope = np.empty_like(rows)
    slope[..., 1:-1] = (rows[..., 2:] - rows[..., :-2]) / (2 * step)
    for end, near, far, sign in ((0, 1, 2, 1.0), (-1, -2, -3, -1.0)):
        slope[..., end] = sign * (4 * rows[..., near] - 3 * rows[..., end] - rows[..., far]) / (2 * step)
    return slope


@lru_cache(maxsize=REMEMBERED)
def _plain_integral(family: Family) -> Array:
    """The load without adhesion by the same integral."""
    (_, t, _, v), (dD, _, _, _), _ = on_grid(family)
    return _integral(grid(family), v / t * dD)


def _integral(u: Array, rate: Array) -> Array:
    """The integral of a ``rate`` over even nodes ``u``, a power law's up to the first: by cubics through values and
    derivatives (Euler and Maclaurin)."""
    step, log, integral = float(u[1] - u[0]), np.log(rate[..., :2]), np.empty_like(rate)
    integral[..., 0] = rate[..., 0] * step / (log[..., 1] - log[..., 0])
    integral[..., 1:] = step / 2 * (rate[..., 1:] + rate[..., :-1]) - step**2 / 12 * np.diff(_rates(rate, step)[0])
    return np.cumsum(integral, axis=-1)


@dataclass(frozen=True, eq=False)
class Perturbation:
    """What an amount of an alternative does to the model of a record. One of

    - ``log_changes``: changes of the logs of D, T, H, V of the body of a stretch (4, n) on its grid, None for none;
    - ``model``: the model that a stretch follows, from the plain one, where more changes or bodies are shared;
    - ``shift``: what the positions of a stretch are off [m];
    - ``loads``: loads of a stretch [N] in place of those of the path, without adhesion;
    - ``loads_back``: the same of the last stretch alone, with adhesion;

    as functions of the stretch and of the values of all unknowns. ``starts``: values of the unknowns ``names`` to begin
    a search with; ``limits``: their least and largest; ``quantities``: what they mean, SI, by name. ``coupled``:
    whether the change depends on the other unknowns too. ``recentred``: the change about a fit that it led to, where it
    is made about one. The derivative of all loads [N] by the amount, where it is not that at 0: ``column``, or
    that by ``per_amount``, changes of the logs of the body (4, n) for one of it. ``shape``: changes of the logs of its
    displacement and stiffness, where the others follow from these; ``rings``: the ring of attraction that the changes
    are solved from, by the plain family and all values, where there is one.
    """

    starts: tuple[tuple[float, ...], ...] = ((0.0,),)
    names: tuple[str, ...] = (AMOUNT,)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    model: Callable[[ForceCurveModel, DirectionReadings, Values], ForceCurveModel] | None = None
    log_changes: Callable[[ForceCurveModel, DirectionReadings, Values], Array | None] | None = None
    shift: Callable[[DirectionReadings, Values], Array] | None = None
    loads: Loads | None = None
    loads_back: Loads | None = None
    coupled: bool = False
    quantities: Callable[[Values], dict[str, float]] = lambda values: {AMOUNT: values[AMOUNT]}
    recentred: Callable[[ForceCurveFit], Perturbation] | None = None
    column: Array | None = None
    per_amount: Array | None = None
    shape: Shape | None = None
    rings: Callable[[Family, Values], Ring | None] | None = None

    def followed(self, plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        """The model that a stretch follows in place of the ``plain`` one."""
        if self.model is not None:
            return self.model(plain, part, values)
        changes = None if self.log_changes is None else self.log_changes(plain, part, values)
        return plain if changes is None else replace(plain, family=changed_family(plain.family, changes))


BodyChanges = Callable[[Family, float], Array]  # changes of the logs of a body (4, n) at an amount


def body_perturbation(
    changes: BodyChanges, limits: tuple[float, float] = ANY, *, last: bool = False, **others: Any
) -> Perturbation:
    """The change of the body by ``changes`` of its logs at an amount; of the ``last`` stretch or of all. ``others``:
    further fields."""

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        return None if last and part is not plain.stretches[-1] else _logs_at(changes, plain.family, values[AMOUNT])

    def model(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        if last and part is not plain.stretches[-1]:
            return plain
        return replace(plain, family=_body_at(changes, plain.family, values[AMOUNT]))

    return Perturbation(limits={AMOUNT: limits}, log_changes=log_changes, model=model, **others)


@lru_cache(maxsize=2)
def _logs_at(changes: BodyChanges, family: Family, amount: float) -> Array:
    return changes(family, amount)


@lru_cache(maxsize=2)
def _body_at(changes: BodyChanges, family: Family, amount: float) -> Family:
    return changed_family(family, _logs_at(changes, family, amount))


def shape_perturbation(shape: Shape, limits: tuple[float, float] = ANY, **others: Any) -> Perturbation:
    """The change of the body by that of the logs of its displacement and stiffness, its ``shape`` at an amount."""

    def changes(family: Family, amount: float) -> Array:
        return perturbed_logs(family, *shape(family, amount))

    return body_perturbation(changes, limits, shape=shape, **others)


def _before_loss(part: DirectionReadings) -> DirectionReadings:
    """A stretch without the rows in contact next to its loss, which a slow edge runs through within a few of them."""
    if not part.touching.any():
        return part
    lost = float(part.z[part.touching].min())
    keep = ~part.touching | (part.z > lost + max(CHANGE_FOLD * part.reach, 2 * part.spacing))
    return replace(part, **{name: getattr(part, name)[keep] for name in ("rows", "z", "P", "touching", "t")})


def _inputs(model: ForceCurveModel) -> dict[str, Any]:
    """What a model is made from, without its change."""
    return {item.name: getattr(model, item.name) for item in fields(ForceCurveModel)}


@dataclass(frozen=True, eq=False)
class ChangedModel(ForceCurveModel):
    """The model of a record with a ``change``."""

    change: Perturbation = Perturbation()

    @classmethod
    def of(cls, plain: ForceCurveModel, change: Perturbation, known: Values | None = None) -> ChangedModel:
        """The ``plain`` model, of an alternative or not, with a change in place of its own, of whose unknowns some may
        be ``known``."""
        inputs = _inputs(plain)
        inputs["known"] = {**plain.known, **(known or {})}
        if change.loads is not None:  # which knows no adhesion
            inputs["works"] = {part.kind: 0.0 for part in plain.stretches}
        if change.loads_back is not None:
            inputs["stretches"] = (*plain.stretches[:-1], _before_loss(plain.stretches[-1]))
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
    def _plain(self) -> ForceCurveModel:
        """The model without the change."""
        return ForceCurveModel(**_inputs(self))

    @cached_property
    def _followed(self) -> dict[object, ForceCurveModel]:
        return {}

    def followed(self, part: DirectionReadings, values: Values) -> ForceCurveModel:
        """The plain model that a stretch follows, remembered."""
        key = part.kind, *(values.values() if self.change.coupled else map(values.__getitem__, self.change.names))
        if key not in self._followed:
            if len(self._followed) >= REMEMBERED:
                self._followed.clear()
            self._followed[key] = self.change.followed(self._plain, part, values)
        return self._followed[key]

    def moving(self, part: DirectionReadings, values: Values) -> Moving:
        return self.followed(part, values).moving(part, values)

    def resting(self, part: DirectionReadings, values: Values) -> Resting | None:
        return self.followed(part, values).resting(part, values)

    def depth(self, part: DirectionReadings, values: Values) -> Array:
        depth = super().depth(part, values)
        return depth if self.change.shift is None else depth + self.change.shift(part, values)

    def completed(self, x: Array, blunt: float, off: Array, rates: Array) -> Array:
        moved: dict[int, float] = {}
        for i, name in enumerate(self.names):
            if name in self.change.names or (self.change.coupled and name.startswith(("ln_s", "q:", "r:", "z0"))):
                step = (CHANGE_STEP if self.change.loads is None else LITTLE) * self._unit(name, float(x[i]))
                moved[i] = -step if x[i] + step > self.limits.get(name, (0.0, math.inf))[1] else step
        each = offs([(self, x + step * (np.arange(x.size) == i), blunt) for i, step in moved.items()])
        for (i, step), there in zip(moved.items(), each, strict=True):
            if isinstance(there, Exception):
                raise there
            rates[i] = (there - off) / step
        return rates

    def _unit(self, name: str, x: float) -> float:
        """The size of an unknown that is ``x``."""
        if name == "z0":
            return max(part.reach for part in self.stretches)
        return max(abs(x), CHANGE_SMALL * (self.most if name.startswith(("q:", "r:")) else 1.0))

    def in_place_of_path(self, part: DirectionReadings) -> Loads | None:
        return self.change.loads or (self.change.loads_back if part is self.stretches[-1] else None)


@np.errstate(all="ignore")
def changed_offs(asked: Sequence[tuple[ChangedModel, Array, float]]) -> list[Array | Exception]:
    """Model minus reading [N] of all rows of models with changes, of which rings of attraction and changed bodies are
    made for all together."""
    each = [(model, model.values(x)) for model, x, _ in asked]
    rings = [model.change.rings(model.family, values) for model, values in each if model.change.rings is not None]
    with contextlib.suppress(JkrError, ArithmeticError):  # of one of them, which tells so itself
        ring_changes([ring for ring in rings if ring is not None])
        families = {model.followed(part, values).family for model, values in each for part in model.stretches}
        changed = [one for one in families if isinstance(one, ChangedFamily) and "functions" not in vars(one)]
        for family, functions in zip(changed, _changed_functions(changed) if changed else (), strict=True):
            vars(family)["functions"] = functions  # remembered as if asked for alone
    return offs(asked)


# --------------------------------------------------------------------------------------------------
# A fitted record: radii, loads and positions of its rows, and how a change of the model changes its loads.
#
# Columns are derivatives of the loads P of all rows at fixed positions z of the device. As delta = z - P/k, a change
# dP at fixed displacement delta is dP (1 - P'/k) at fixed position, P' the derivative of the load by the position.


@dataclass(frozen=True)
class Known:
    """What is known before the data: the longest ``range`` of adhesion [m] that is likely, or possible where ``told``
    by the user, and the largest surface ``tension`` [N/m], 0 where nothing is; and the ``level`` of intervals."""

    range: float = LONGEST_RANGE
    tension: float = 0.0
    level: float = LEVEL
    told: bool = False

    @cached_property
    def quantile(self) -> float:
        """Half-width of intervals, in standard errors."""
        return half_width(self.level)


@dataclass(frozen=True, eq=False)
class FittedRecord:
    """The ``fit`` of a record of a ``body``, and what is ``known`` besides, as alternatives need them."""

    body: FittedBody
    fit: ForceCurveFit
    known: Known = Known()

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
    def alternatives(self) -> tuple[AlternativeModel, ...]:
        """Those that mean anything for it."""
        return self.tabled[0]

    @property
    def table(self) -> Array:
        """Residuals, their derivatives by the unknowns and the columns of these alternatives, one after the other:
        (columns, rows)."""
        return self.tabled[1]

    @cached_property
    def tabled(self) -> tuple[tuple[AlternativeModel, ...], Array]:
        """The alternatives that mean anything for this record, and their ``table``."""
        return next(tables([self]))

    def products(self, rows: Array) -> Array:
        """Products of all columns of the ``table`` over some ``rows`` [N^2]: those over all, less those over the
        others, which are few."""
        others = self.table[:, np.flatnonzero(~rows)]
        products: Array = self._products - others @ others.T
        return products

    @cached_property
    def _products(self) -> Array:
        """Those over all rows."""
        products: Array = self.table @ self.table.T
        return products

    @cached_property
    def regular(self) -> Array:
        """Which rows columns are trusted in: none next to a fold or first touch, where they diverge."""
        rows = []
        for part, (a, _) in zip(self.model.stretches, self.radii, strict=True):
            z, touching = part.z, a > 0
            first = z[touching].min() if touching.any() else math.inf
            span = max(CHANGE_FOLD * part.reach, 2 * part.spacing)
            rows.append(~touching | (z > first + span) if part.jumped else np.abs(z - first) > span)
        return np.concatenate(rows)

    def by_unknown(self, name: str) -> Array:
        """The column of the Jacobian that belongs to an unknown."""
        return self.jacobian[:, self.fit.names.index(name)]

    @cached_property
    def retraction(self) -> DirectionReadings | None:
        return next((part for part in self.model.stretches if part.kind != APPROACH), None)

    @cached_property
    def edges(self) -> Sequence[Edges]:
        """The edges of each stretch, as the model gives them."""
        return self.model.edges(self.fit.x)

    @property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, and which of them rest."""
        return self.fit.radii

    def radii_of(self, part: DirectionReadings) -> tuple[Array, Array]:
        """The same of one stretch."""
        return self.radii[self.model.stretches.index(part)]

    @property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return self.fit.a

    @cached_property
    def a_max(self) -> float:
        """Largest contact radius [m]."""
        return float(self.a.max())

    @cached_property
    def modulus(self) -> float:
        """Factor of the body's moduli."""
        return math.exp(self.values["ln_s"])

    @cached_property
    def E_star(self) -> float:
        """E* of the body as fitted [Pa]."""
        return self.modulus * self.body.problem.E_star

    @cached_property
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

    @cached_property
    def P_H(self) -> Array:
        """Load [N] of all rows at their contact radii without adhesion."""
        load, touching = np.zeros(self.a.size), np.flatnonzero(self.a)
        load[touching] = self.modulus * np.exp(_log_load(self.model.family)(np.log(self.a[touching])))
        return load

    @cached_property
    def loads(self) -> Array:
        """Loads of the contact [N] at all rows, of the model."""
        lines = np.concatenate([base_line(part, self.values)[0] for part in self.model.stretches])
        loads: Array = np.concatenate([part.P for part in self.model.stretches]) + self.residuals - lines
        return loads

    @cached_property
    def depth(self) -> Array:
        """Position of the device beyond its zero [m], at all rows."""
        return np.concatenate([self.model.depth(part, self.values) for part in self.model.stretches])

    @cached_property
    def by_position(self) -> Array:
        """P', the derivative of the loads by the position of the device [N/m], its turn where it is."""
        return self.model.by_position(self.fit.x)

    @cached_property
    def at_fixed_position(self) -> Array:
        """1 - P'/k: a change of load at fixed position over that at fixed displacement."""
        return 1 - self.by_position / self.model.k

    def column(self, change: Perturbation) -> Array | None:
        """Derivative of the loads [N] by the amount of a change, at 0 unless the change has a column of its own; None
        of one of the body, which has ``bodies``."""
        if change.column is not None or change.per_amount is not None or change.log_changes is not None:
            return change.column
        model = ChangedModel.of(self.model, change)
        x = np.concatenate([self.fit.x, [LITTLE, *change.starts[0][1:]]])
        return (model.off(x, 0.0) - self.residuals) / LITTLE

    def bodies_at(self, change: Perturbation, amounts: Sequence[float]) -> Array:
        """Changes of the logs of the body (amounts, stretches, 4, n) at some amounts of a change, the other unknowns as
        they are."""
        family, parts, each = self.model.family, self.model.stretches, [{**self.values, AMOUNT: one} for one in amounts]
        bodies = np.zeros((len(amounts), len(parts), FUNCTIONS, grid(family).size))
        if change.rings is not None:
            rings = [change.rings(family, values) for values in each]
            ring_changes([ring for ring in rings if ring is not None])
        for body, values in zip(bodies, each, strict=True):
            for one, part in zip(body, parts, strict=True):
                changed = None if change.log_changes is None else change.log_changes(self.model, part, values)
                one[:] = 0.0 if changed is None else changed
        return bodies

    def by_bodies(self, bodies: Array) -> Array:
        """Derivatives of the loads [N] of all rows, (changes, rows), by an amount of each change of ``bodies``."""
        columns, ends = np.zeros((len(bodies), self.model.ends[-1])), self.model.ends
        for i, (moving, resting, depth, rows, still) in enumerate(self.edges):
            each, own = bodies[:, i], columns[:, ends[i] : ends[i + 1]]
            own[:, rows] = moving.by_body(depth[rows], self.model.stretches[i].spacing / 2, each)
            if resting is not None:
                own[:, still] = resting.by_body(depth[still], moving.nodes.u, each)
        return columns

    @cached_property
    def history(self) -> _History | None:
        """What memories act on; None where there are not two directions or next to no contact."""
        return histories([self])[0]

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m]."""
        return max(part.reach for part in self.model.stretches)

    @cached_property
    def duration(self) -> float:
        """How long the record lasts [s]."""
        return self.model.stretches[0].lasting

    @cached_property
    def tip_turn(self) -> float:
        """Where the tip turns [m], beside z0: at the device's turn less its deflection there."""
        part = self.model.stretches[0]
        i = int(np.argmax(part.z))
        line = base_line(part, self.values)[0][i]
        return part.turn - float(part.P[i] - line) / self.model.k

    def rows(self, part: DirectionReadings, chosen: Array | bool = True) -> Array:
        """Which rows of all are those of one stretch that are ``chosen``."""
        return np.concatenate([np.full(one.P.size, chosen if one is part else False) for one in self.model.stretches])

    def time(self, part: DirectionReadings) -> Array:
        """Time since the turn, in units of a whole record; by the number of rows where no column tells it."""
        if self.timed:
            return np.abs(part.t) / self.duration
        return np.abs(part.rows - part.rows[-1]) / sum(float(np.ptp(one.rows)) for one in self.model.stretches)

    @cached_property
    def timed(self) -> bool:
        """Whether a column tells the time of all rows."""
        return min(float(np.ptp(one.t)) for one in self.model.stretches) > 0


@lru_cache(maxsize=REMEMBERED)
def _log_load(family: Family) -> PiecewisePolynomial:
    """The log of the load without adhesion over that of the contact radius."""
    return PiecewisePolynomial(family.logs.x, np.ascontiguousarray(family.logs.c[..., 2]))


def prepare(records: Sequence[FittedRecord]) -> None:
    """Find what memories of some records act on and their columns together, which are remembered."""
    for record, history in zip(records, histories(records), strict=True):
        vars(record)["history"] = history
    for record, tabled in zip(records, tables(records), strict=True):
        vars(record)["tabled"] = tabled


@lru_cache(maxsize=REMEMBERED)
def _radii(family: Family) -> Array:
    """Contact radii [m] at the nodes of its grid."""
    return np.exp(grid(family))


@lru_cache(maxsize=REMEMBERED)
def log_ratio(other: Family, family: Family) -> Array:
    """Logs (4, n) of D, T, H, V of an ``other`` body over a ``family``'s, on its grid; constant where one ends."""
    inside = np.clip(grid(family), max(family.low, other.low), min(family.high, other.high))
    ratio: Array = np.log(other.at(inside)[0] / family.at(inside)[0])
    return ratio


# --------------------------------------------------------------------------------------------------
# Alternatives of adhesion in a raw record: w over the contact radius or over the speed of the edge, and adhesion of a
# range.
#
# With r = sqrt(w/s) the contact has delta = D - r T and P = s (H - r V): a change of w is one of the logs of T and V.

# Which ranges and laws of w are searched.
# choice: Tabor numbers, to begin with: chi^2 has two valleys over the range, the longer one about a factor 1.4 wide
ADHESION_TABOR = (3.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06, 0.03)
ADHESION_ENDLESS = 400.0  # choice: of how far adhesion deforms the body, a range from which on no longer one differs
ADHESION_NARROW = 0.5  # choice: of the contact radius, a ring between narrow and wide
ADHESION_EVERY = 7  # choice: of the nodes of a grid, at which rings are solved: splines between are good to 1e-5
ADHESION_SETTLED = 1e-6  # theory: such a step by Newton's method, whose errors are squared: the next is round-off
# choice: rise of w at the usual speed of the edge and power of the speed, to begin with
ADHESION_SPEEDS = ((0.3, 0.3), (0.3, 0.8), (1.0, 0.3), (1.0, 0.8))
# choice: of the speed of the edge, that are searched; measured 0.1 to 1
ADHESION_POWERS = (0.1, 1.5)


POWER = "n"


def work_over_radius(record: FittedRecord) -> Perturbation | None:
    """ln w of the last direction rises by the amount times (a_max - a)/(a_max - a_min): T and V by half of it. The w of
    the record is then that at a_min, at pull-off."""
    a = record.radii[-1][0]
    if not record.work or not (a > 0).any():
        return None
    a_max, a_min = record.a_max, float(a[a > 0].min())

    def changes(family: Family, amount: float) -> Array:
        place = (a_max - _radii(family)) / max(a_max - a_min, LITTLE * a_max)
        half, zero = amount / 2 * np.maximum(place, -1.0), np.zeros_like(place)
        return np.stack([zero, half, zero, half])

    name, most = f"q:{record.model.stretches[-1].kind}", CHANGE_LARGEST
    quantities = lambda values: {"w": values[name] * math.exp(values["ln_s"] + values[AMOUNT])}  # noqa: E731
    return body_perturbation(changes, (-most, most), last=True, quantities=quantities)


def work_over_speed(record: FittedRecord) -> Perturbation | None:
    """w of the retraction over the speed v of its edge. The column is that of w (v/v_m)^amount, dP/d(ln w) ln(v/v_m)
    with v_m the median; in full w = w0 (1 + amount (v/v_m)^n)."""
    part = record.retraction
    name = "" if part is None else f"q:{part.kind}"
    if part is None or name not in record.fit.names:
        return None
    a, rests = record.radii_of(part)
    moves = (a > 0) & ~rests
    if (speeds := _log_speeds(part.z[moves], a[moves])) is None:
        return None
    middle, logs = speeds
    log = np.zeros(record.a.size)
    log[record.rows(part, moves)] = logs
    return _gent_schultz(math.exp(middle), record.by_unknown(name) * record.values[name] * log)


def _log_speeds(z: Array, a: Array) -> tuple[float, Array] | None:
    """Logs of the speed of the edge over that of the device, da/dz as the device moves evenly: their median, and those
    of all rows less it; None where no position has a neighbour on either side."""
    steps, positions = np.diff(z), z
    if repeats := not (steps > 0).all():  # readings of a position
        positions, rows = np.unique(z, return_index=True)
        a, steps = a[rows], np.diff(positions)
    if positions.size < 3:
        return None
    # slopes of the parabolas through three neighbours, at the ends of the straight lines through two
    secants = np.diff(a) / steps
    inner = (steps[1:] * secants[:-1] + steps[:-1] * secants[1:]) / (steps[1:] + steps[:-1])
    log = np.log(np.maximum(np.abs(np.concatenate([secants[:1], inner, secants[-1:]])), 1e-9))
    middle = median(log)
    log -= middle
    return middle, np.interp(z, positions, log) if repeats else log


def _gent_schultz(typical: float, column: Array) -> Perturbation:
    """w = w0 (1 + amount (v/v_m)^n) of the retraction, v_m the ``typical`` speed of its edge over the device's; by the
    ``column`` of another law."""

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        s, q = math.exp(values["ln_s"]), max(values[f"q:{part.kind}"], LITTLE**3 * model.most)
        turn, n = part.turn - values["z0"], values[POWER]
        resting = rest(model.family, s, root_of(values, model.stretches[0].kind), math.sqrt(q), model.k, turn)
        law = max(values[AMOUNT], LITTLE**2) * typical**-n, n
        path = receding(model.family, s, q, model.k, law, resting, turn)
        return np.where(part.touching, load_at(path, resting, turn, model.depth(part, values)), 0.0)

    return Perturbation(
        ADHESION_SPEEDS,
        (AMOUNT, POWER),
        {AMOUNT: (0.0, 1e3), POWER: ADHESION_POWERS},
        loads_back=loads,
        coupled=True,
        column=column,
        quantities=lambda values: {name: values[name] for name in (AMOUNT, POWER)},
    )


def root_of(values: Values, kind: str) -> float:
    """r = sqrt(w/s) of a direction."""
    return values.get(f"r:{kind}", math.sqrt(max(values[f"q:{kind}"], 0.0)))


def finite_range(record: FittedRecord) -> Perturbation | None:
    """Adhesion of the range z0: the amount is z0^2 over that of the range whose ring of attraction is narrow (Maugis,
    J. Colloid Interface Sci. 150 (1992) 243, of a half-space; of other bodies near the edge only)."""
    if not record.work:
        return None
    E_star = record.body.problem.E_star

    def rings(family: Family, values: Values) -> Ring | None:
        s, z0 = math.exp(values["ln_s"]), range_of(record, values[AMOUNT])
        works = tuple(w for name in kinds if (w := values[name] * s) > 0)
        return None if z0 in (0, math.inf) or not works else (family, s * E_star, works, z0)

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        ring, own = rings(plain.family, values), values[f"q:{part.kind}"] * math.exp(values["ln_s"])
        if ring is None or own not in ring[2]:
            return None
        (changes,) = ring_changes([ring])
        each: Array = changes[ring[2].index(own)]
        return each

    kinds = [f"q:{part.kind}" for part in record.model.stretches]
    starts = tuple((amount_of_range(record, record.neck / mu),) for mu in ADHESION_TABOR)
    most = amount_of_range(record, ADHESION_ENDLESS * record.neck)
    return Perturbation(
        starts, limits={AMOUNT: (0.0, most)}, log_changes=log_changes, coupled=True, rings=rings,
        quantities=lambda values: {"range": range_of(record, values[AMOUNT])},
    )  # fmt: skip


def likely_range(record: FittedRecord) -> float:
    """The amount of the longest range that is known, or likely."""
    return amount_of_range(record, record.known.range) if record.work else 0.0


def amount_of_range(record: FittedRecord, z0: float) -> float:
    """The amount of a range [m]: in proportion to its square while it is short, and finite where it is endless."""
    size = (z0 / record.narrow_range) ** 2
    return size / (1 + size / (record.neck / record.narrow_range) ** 2)


def range_of(record: FittedRecord, amount: float) -> float:
    """The range [m] of an amount."""
    least = (record.neck / record.narrow_range) ** 2  # of an endless range
    return record.narrow_range * math.sqrt(amount / (1 - amount / least)) if amount < least else math.inf


Ring: TypeAlias = "tuple[Family, float, tuple[float, ...], float]"  # a body, its E* [Pa], w [J/m^2] and range [m]
_SOLVED: dict[Ring, Array] = {}


def ring_changes(wanted: Sequence[Ring]) -> list[Array]:
    """Changes of the logs (works, 4, n) of bodies whose w has a range, each by itself, the last ones remembered."""
    found = [_SOLVED.get(one) for one in wanted]
    if missing := [*dict.fromkeys(one for one, known in zip(wanted, found, strict=True) if known is None)]:
        if len(_SOLVED) >= REMEMBERED:
            _SOLVED.clear()
        changes, first = _maugis(missing), 0
        for one in missing:
            _SOLVED[one] = changes[first : (first := first + len(one[2]))]
    return [_SOLVED[one] if known is None else known for one, known in zip(wanted, found, strict=True)]


def _maugis(rings: Sequence[Ring]) -> Array:
    """Changes of the logs (works of all rings, 4, n) of bodies of E* [Pa] whose w [J/m^2] has the range z0 [m]: the
    stress sigma = w/z0 on a ring from a to m a shifts the displacement by 2 sigma a sqrt(m^2 - 1)/E* and the load by 2
    sigma a^2 (sqrt(m^2 - 1) + m^2 arccos(1/m)), JKR by sqrt(2 pi a w/E*) and sqrt(8 pi w E* a^3)."""
    each = [(*ring, w) for ring in rings for w in ring[2]]
    E, z0, w = (np.array([one[i] for one in each])[:, None] for i in (1, 3, 4))
    a, D = np.stack([_ring_nodes(family) for family, *_ in each], axis=1)
    sigma = w / z0
    m = _rim(a, D, E, w, sigma)
    root, angle = np.sqrt(m**2 - 1), np.arccos(1 / m)
    shift = 2 * sigma * a * root / E / np.sqrt(2 * math.pi * a * w / E)
    pull = 2 * sigma * a**2 * (root + m**2 * angle) / np.sqrt(8 * math.pi * w * E * a**3)
    splines = _splines(grid(each[0][0]).size)
    changes = np.zeros((len(each), FUNCTIONS, splines.shape[1]))
    changes[:, 1::2] = np.stack([np.log(shift), np.log(pull)], axis=1) @ splines  # of T and V
    return changes


@lru_cache(maxsize=REMEMBERED)
def _ring_nodes(family: Family) -> Array:
    """Contact radii and displacements without adhesion at which rings are solved, (2, some)."""
    return np.stack([_radii(family), on_grid(family)[0, 0]])[:, ::ADHESION_EVERY]


@lru_cache
def _splines(size: int) -> Array:
    """Values at ``size`` even nodes of the cubic splines through 1 at one of every ``ADHESION_EVERY`` nodes and 0 at
    the others of these, (some, size)."""
    nodes = np.arange(size)
    some = nodes[::ADHESION_EVERY]
    splines: Array = cubic_spline(some, np.eye(some.size))(nodes).T
    return splines


def _rim(a: Array, D: Array, E: Array, w: Array, sigma: Array) -> Array:
    """Ratio m of outer to inner radius of the ring whose stress ``sigma`` releases ``w``. With t = sqrt(m^2 - 1) and c
    = arccos(1/m), 1 = 4 sigma^2 a/(pi E* w) (t c - m + 1) + sigma D/(pi w) (t + (m^2 - 2) c); by Newton's method for
    the log of the right-hand side over that of m - 1, nearly straight; from its limits, of narrow rings and
    of wide ones."""
    own, pressed = 4 * sigma**2 / (math.pi * E * w) * a, sigma / (math.pi * w) * D
    near = 1 / (own + (math.sqrt(128) / 3 * pressed) ** (2 / 3))
    far = 2 / ((math.pi / 2 - 1) * own + np.sqrt(((math.pi / 2 - 1) * own) ** 2 + 2 * math.pi * pressed))
    x, goes_on = np.where(near < ADHESION_NARROW, near, np.maximum(far, ADHESION_NARROW)), np.ones((len(a), 1))
    for _ in range(MOST_STEPS):
        m = 1 + x
        root = np.sqrt(x * (2 + x))
        angle = np.arctan(root)
        released = own * (root * angle - x) + pressed * (root + (m**2 - 2) * angle)
        rate = own * (m * angle / root + 1 / m - 1) + pressed * (m / root + 2 * m * angle + (m - 2 / m) / root)
        step = -released / (x * rate) * np.log(released) * goes_on
        x *= np.exp(np.clip(step, -SLOW_EDGE_WIDEST, SLOW_EDGE_WIDEST))
        goes_on *= np.abs(step).max(axis=1, keepdims=True) >= ADHESION_SETTLED  # each by itself
        if not goes_on.any():
            break
    return 1 + x


def long_range(record: FittedRecord) -> Array | None:
    """From JKR to adhesion that pulls from so far that it deforms nothing (Derjaguin, Muller and Toporov, J. Colloid
    Interface Sci. 53 (1975) 314), at equal w: P = P_H(delta) - 2 pi w R. In full it is a finite range."""
    R, k = record.body.problem.indenter.tip_radius, record.model.k
    if R is None or not record.work:
        return None
    D, _, H, _ = on_grid(record.model.family)[0]
    qs = [np.full(part.P.size, max(record.values[f"q:{part.kind}"], 0.0)) for part in record.model.stretches]
    P_H = np.interp(record.depth - record.loads / k, D, H, left=0.0)
    change = record.modulus * (P_H - 2 * math.pi * R * np.concatenate(qs)) - record.loads
    column: Array = np.where(record.a > 0, change * record.at_fixed_position, 0.0)
    return column


# --------------------------------------------------------------------------------------------------
# Alternatives of body and tip in a raw record: layers, a modulus over the depth, profiles, slip, surface tension,
# strains.
#
# Each is another body, by how the logs of its functions D = delta_H, T, H = P_H and V of the contact radius change:
# of tips by D, of moduli by the contact stiffness S, as dP_H = S d(delta_H).

# Bodies of which columns are taken, and which are searched.
BODY_THICK = 3.0  # choice: of the largest contact radius, the layer that a half-space is compared with
# of its thickness, radii it is solved at; theory: up to a contact of 0.44
BODY_UNDER = (3e-3, 0.5)
BODY_DECADES = 4  # choice: such layers to a decade of thickness, so that many curves share one solve
BODY_NEIGHBOUR = 0.02  # choice: of thickness and nu, for differences of two bodies
BODY_THIN = 4.0  # choice: contact radii over the thickness up to which a layer is searched
BODY_THICKNESSES = (0.3, 1.0)  # choice: contact radii over it, to begin with
BODY_SOFTEST = -0.6  # theory: S' stays above 0 up to ``CHANGES.beyond``
BODY_BLUNTEST = -1.5  # theory: profiles that rise, exponent 1/2
BODY_FLATTEST = -3.0  # theory: profiles that rise up to a/R = 1
BODY_PROFILES = (-1.0, -0.8, 0.0)  # choice: exponents less that of a paraboloid, to begin with
BODY_FINEST = 4.0  # theory: of kappa, below which the expansion for small kappa is not used


EULER = float(np.euler_gamma)


def layer_below(record: FittedRecord) -> Perturbation | None:
    """A half-space as a layer on a rigid base at the depth a_max/amount."""
    specimen, a_max = record.body.problem.specimen, record.a_max
    if specimen.layers or specimen.radius is not None or not isinstance(specimen.base, HalfSpace):
        return None
    h = 10 ** (round(math.log10(BODY_THICK * a_max) * BODY_DECADES) / BODY_DECADES)
    changes = log_ratio(_on_rigid(record.body, h, BODY_UNDER[1]), record.model.family) * h / a_max
    return _on_base(record.body, a_max, a_max, changes)


@lru_cache(maxsize=REMEMBERED)
def _on_rigid(body: FittedBody, h: float, most: float) -> Family:
    """The body's half-space as a layer of thickness ``h`` [m] on a rigid base, up to ``most`` times that."""
    specimen = body.problem.specimen
    assert isinstance(specimen.base, HalfSpace)
    problem = replace(without_side_walls(body.problem), specimen=Specimen((Layer(specimen.base.material, h),), Rigid()))
    most = min(most, FAMILY_BELOW_LIMIT * problem.indenter.r_max / h)
    radii = tuple((h * np.geomspace(BODY_UNDER[0], most, DENSE)).tolist())
    return solved(replace(problem, loading=Loading.given("radius", radii)), body.tolerance)


def _on_base(body: FittedBody, a_max: float, h: float, per_amount: Array | None = None) -> Perturbation:
    """The same in full, by the curves of one thickness ``h`` [m]: those of others are the same over a/h, but for the
    tip's shape, so that the change is made anew about what it leads to."""

    @lru_cache(maxsize=1)
    def ratios(family: Family) -> PiecewiseCubic:
        """Logs of D, T, H, V over those of the half-space, over ln(a/h)."""
        layer = _on_rigid(body, h, BODY_THIN)
        u = np.linspace(layer.low, layer.high, DENSE)
        return cubic_spline(u - math.log(h), np.log(layer.at(u)[0] / family.at(u)[0]).T)

    def changes(family: Family, amount: float) -> Array:
        spline = ratios(family)
        log = grid(family) + math.log(max(amount, LITTLE**2) / a_max)
        thick = np.exp(np.minimum(log - spline.x[0], 0.0))  # in proportion to a/h below
        return thick * spline(np.clip(log, spline.x[0], spline.x[-1])).T

    def recentred(fit: ForceCurveFit) -> Perturbation:
        return _on_base(body, a_max, a_max / max(fit.value(AMOUNT), LITTLE))

    quantities = lambda values: {"thickness": a_max / max(values[AMOUNT], LITTLE**2)}  # noqa: E731
    starts = tuple((amount,) for amount in BODY_THICKNESSES)
    return body_perturbation(
        changes, (0.0, BODY_THIN), starts=starts, quantities=quantities, recentred=recentred, per_amount=per_amount
    )


def thickness(record: FittedRecord) -> Perturbation | None:
    """h = h0 (1 + amount) of the layer in contact."""
    return _of_layer(record, "h", "thickness")


def poisson(record: FittedRecord) -> Perturbation | None:
    """nu = nu0 (1 + amount) of the layer in contact, towards 1/2 at most."""
    return _of_layer(record, "nu", "nu")


def _of_layer(record: FittedRecord, symbol: str, quantity: str) -> Perturbation | None:
    """The relative change of a quantity of the layer in contact, between bodies that are solved at even steps of it."""
    body, step = record.body, BODY_NEIGHBOUR
    if not body.own_parameters or not body.problem.specimen.layers:
        return None
    name = f"{symbol}:{body.layer_names[0]}"
    nominal = body.nominal(name)
    most = (0.5 - UNSEEN) / nominal - 1 if symbol == "nu" else CHANGE_LARGEST

    def at_node(i: int) -> Family:
        return body.with_values({name: nominal * (1 + min(i * step, most))}).family

    def changes(family: Family, amount: float) -> Array:
        i = math.floor(amount / step)
        part = amount / step - i
        return (1 - part) * log_ratio(at_node(i), family) + part * log_ratio(at_node(i + 1), family)

    return body_perturbation(
        changes, (1 / (1 + CHANGE_LARGEST) - 1, most),
        quantities=lambda values: {quantity: nominal * (1 + values[AMOUNT])},
        per_amount=log_ratio(at_node(-1), record.model.family) / -step,
    )  # fmt: skip


def graded(record: FittedRecord) -> Perturbation:
    """ln S rises by the amount times a/a_max."""
    a_max = record.a_max

    def shape(family: Family, amount: float) -> tuple[Array, Array]:
        place = np.minimum(_radii(family) / a_max, CHANGE_BEYOND)
        return np.zeros_like(place), amount * place

    return shape_perturbation(shape, (BODY_SOFTEST, CHANGE_LARGEST))


def exponent(record: FittedRecord) -> Perturbation:
    """A profile of exponent 2 + amount, as deep as the tip at a_max: ln D rises by the amount times ln(a/a_max)."""
    log = math.log(record.a_max)
    return shape_perturbation(
        lambda family, amount: _of_tip(amount * (grid(family) - log)), (BODY_BLUNTEST, CHANGE_LARGEST),
        starts=tuple((amount,) for amount in BODY_PROFILES),
        quantities=lambda values: {"exponent": 2 + values[AMOUNT]},
        recentred=_exponent_at_turn,
    )  # fmt: skip


def _exponent_at_turn(fit: ForceCurveFit) -> Perturbation:
    """The same about the contact radius at the turn, which follows the unknowns: its error is one of E*."""
    part, values, model = fit.model.stretches[0], fit.model.values(fit.x), cast(ChangedModel, fit.model)
    turn, kind = part.turn, part.kind
    start = np.log(model.branch(part, values).radii(np.array([turn - values["z0"]])))
    (D, T, _, _), _, _ = model.followed(part, values).family.at(start)
    deflection = (turn - values["z0"]) - (D - root_of(values, kind) * T)  # of the device [m]

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        u, root = start, root_of(values, kind)
        for _ in range(MOST_STEPS):
            (D, T, _, _), (dD, dT, _, _), _ = plain.family.at(u)
            step = (D - root * T - (turn - values["z0"] - deflection)) / (dD - root * dT)
            u = u - step
            if abs(float(step[0])) < SETTLED:
                break
        return perturbed_logs(plain.family, *_of_tip(values[AMOUNT] * (grid(plain.family) - u)))

    return replace(model.change, log_changes=log_changes, shape=None, model=None, coupled=True, recentred=None)


def quartic(record: FittedRecord) -> Perturbation | None:
    """From the paraboloid to the sphere of the same radius: ln D rises by the amount times (a/R)^2/3."""
    R = record.body.problem.indenter.tip_radius
    if R is None:
        return None

    return shape_perturbation(
        lambda family, amount: _of_tip(amount * np.minimum(_radii(family) / R, 1.0) ** 2 / 3),
        (BODY_FLATTEST, CHANGE_LARGEST),
    )


def _of_tip(D: Array) -> tuple[Array, Array]:
    """Changes of the logs of displacement and stiffness where the former alone changes, by ``D``."""
    return D, np.zeros_like(D)


def no_slip(record: FittedRecord) -> Perturbation | None:
    """From surfaces that slide to such as do not: the amount times the logs of the latter's functions over the
    former's."""
    problem, sliding = record.body.problem, record.model.family
    if problem.sticks or problem.specimen.radius is not None:
        return None
    stuck = record.body.on_surface("sticking").family
    if np.abs(log_ratio(stuck, sliding)[:, -1]).max() < SAME:
        return None
    return body_perturbation(lambda family, amount: amount * log_ratio(stuck, family))


def tension(record: FittedRecord) -> Perturbation | None:
    """Surface tension Ups of a half-space, kappa = 2 Ups/E* = amount times a_max, to first order in kappa/a: delta_H
    times 1 + 2 x (l - 1), P_H times 1 + 3 x l, S times 1 + x (l + 1), S' times 1 + x with x = kappa/(pi a) and l = ln(2
    a/kappa) + Euler's constant."""
    problem, a_max = record.body.problem, record.a_max
    if problem.layers or problem.specimen.radius is not None:
        return None

    def relative(family: Family, amount: float) -> Array:
        """Changes of delta_H, S', P_H and S, in this order."""
        kappa, changes = max(amount, LITTLE**2) * a_max, np.ones((FUNCTIONS, grid(family).size))
        a = np.maximum(_radii(family), BODY_FINEST * kappa)
        log = np.log(2 / kappa * a) + EULER
        changes[0], changes[2], changes[3] = 2 * (log - 1), 3 * log, log + 1
        changes *= kappa / math.pi / a
        return changes

    def functions(changes: Array) -> Array:
        """Of D, T, H, V, from those of delta_H, S', P_H and S: T^2 goes with 1/S', V with S T."""
        changes[1] /= -2
        changes[3] += changes[1]
        return changes

    small = functions(relative(record.model.family, CHANGE_SMALL) / CHANGE_SMALL)
    unit = record.body.problem.E_star * a_max / 2
    return body_perturbation(
        lambda family, amount: functions(np.log1p(relative(family, amount))), (0.0, 1.0), starts=((CHANGE_SMALL,),),
        quantities=lambda values: {"surface_tension": unit * math.exp(values["ln_s"]) * values[AMOUNT]},
        per_amount=small,
    )  # fmt: skip


def amount_of_tension(record: FittedRecord, tension: float) -> float:
    """The amount of a surface tension [N/m]."""
    return 2 * tension / (record.E_star * record.a_max)


def likely_tension(record: FittedRecord) -> float:
    """The amount of the largest tension that is known."""
    return amount_of_tension(record, record.known.tension)


def strains(record: FittedRecord) -> Array | None:
    """What linear theory leaves out at large strains of half-spaces, as far as it is known: at fixed displacement P_H
    becomes P_H/(1 + excess(a/R))."""
    problem = record.body.problem
    R, known = problem.indenter.tip_radius, EXCESS.get(problem.indenter.noun)
    if known is None or problem.layers or R is None:
        return None
    excess = np.interp(record.a / R, STRAINED, known)
    return -excess / (1 + excess) * record.P_H * record.at_fixed_position


def likely_strains(record: FittedRecord) -> float:
    """All of it, but none where linear theory is taken as good, as everywhere else."""
    R = record.body.problem.indenter.tip_radius
    return 0.0 if R is not None and record.a_max <= LIMITS.a_over_R * R else 1.0


# --------------------------------------------------------------------------------------------------
# Alternatives of the device in a raw record, and of one direction against the other: stiffness, positions, flow.


def stiffness(record: FittedRecord) -> Perturbation | None:
    """k (1 + amount) of the device, its loads as they are: rows and the turn are deeper by amount P/k."""
    model = record.model
    if not math.isfinite(model.k):
        return None
    column, part = record.by_position * record.loads, model.stretches[-1]
    resting = record.edges[-1][1]
    if resting is not None and "z0" in record.fit.names:
        by_turn = -record.by_unknown("z0") - record.by_position
        column = column + by_turn * float(resting.at(np.array([part.turn - record.values["z0"]]))[0, 0])
    return Perturbation(
        limits={AMOUNT: (LITTLE - 1, math.inf)},
        model=lambda plain, part, values: replace(plain, k=plain.k * (1 + values[AMOUNT])),
        quantities=lambda values: {"stiffness": model.k * (1 + values[AMOUNT])},
        column=column / model.k,
    )


def misplaced(
    record: FittedRecord, error: Callable[[DirectionReadings], Array], name: str = AMOUNT
) -> Perturbation | None:
    """Rows that stand deeper than their positions say by the amount times an ``error`` [m], which results call by a
    ``name``: the column is P' error."""
    if len(record.model.stretches) < 2 or name in record.model.positions:
        return None
    return Perturbation(
        shift=lambda part, values: values[AMOUNT] * error(part),
        quantities=lambda values: {name: values[AMOUNT]},
        column=record.by_position * np.concatenate([error(part) for part in record.model.stretches]),
    )


def drift(record: FittedRecord) -> Perturbation | None:
    """Depths that drift by the amount times the way in contact over the time of the record, 0 at the turn."""
    if "drift" in record.model.positions:
        return None
    signs = {part.kind: 1.0 if part.kind == APPROACH else -1.0 for part in record.model.stretches}
    return misplaced(record, lambda part: signs[part.kind] * record.time(part) * record.reach)


def misplaced_back(
    error: Callable[[FittedRecord, DirectionReadings], Array], name: str = AMOUNT
) -> Callable[[FittedRecord], Perturbation | None]:
    """The same of the retraction alone."""

    def effect(record: FittedRecord) -> Perturbation | None:
        return misplaced(
            record, lambda part: error(record, part) if part.kind != APPROACH else np.zeros(part.z.size), name
        )

    return effect


def another_modulus(record: FittedRecord) -> Perturbation | None:
    """E* (1 + amount) on the way back."""
    if len(record.model.stretches) < 2 or "ln_s" not in record.fit.names or record.retraction is None:
        return None

    def changes(family: Family, amount: float) -> Array:
        same = np.zeros_like(grid(family))
        return perturbed_logs(family, same, same + math.log1p(amount))

    column = np.where(record.rows(record.retraction), record.by_unknown("ln_s"), 0.0)
    return body_perturbation(changes, (LITTLE - 1, math.inf), last=True, column=column)


def slope_at_rest(record: FittedRecord) -> Array | None:
    """S (1 + amount) of the line on which the edge rests, about the turn."""
    part = record.retraction
    if part is None:
        return None
    rests = record.radii_of(part)[1]
    if np.count_nonzero(rests) < 3:
        return None
    column, rows = np.zeros(record.a.size), record.rows(part, rests)
    column[rows] = (record.by_position * record.at_fixed_position)[rows] * (part.z[rests] - part.turn)
    return column


# --------------------------------------------------------------------------------------------------
# Alternatives of relaxation in a raw record: moduli that fall over the time since the strain, where the contact was and
# is.
#
# A body whose moduli are r(t) times those at once, under a contact that grows and then shrinks (Ting, J. Appl. Mech.
# 33 (1966) 845): while it grows P = int r(t - t') dP_H, and while it shrinks P = int_0^t1 r(t - t') dP_H + S int_t1^t
# r(t - t') d(delta), t1 the time at which the radius was the same, S the contact stiffness there.

# How finely histories are followed.
RELAXATION_PIECES = 60  # choice: of the way of the tip in each direction, for the history of a body that relaxes
RELAXATION_COARSER = 2  # choice: steps joined in histories, 1e-5 of the loads
RELAXATION_GROWS = 0.02  # choice: of the depth, by which a contact may grow again: noise of the deflection
RELAXATION_TIMES = 50  # choice: instants of each direction at which those loads are solved; splines between them
RELAXATION_SMOOTH = 2 / 3  # theory: power of the load in which they are drawn, at first contact it is delta^1.5
RELAXATION_INSTANTS = 60  # choice: at which hereditary integrals are taken; 400 change columns by 2e-3 (rms)


TIME = "relaxation_time"
Memory = Callable[[Array], Array]  # phi of r = 1 - amount phi, of time over that of the record


def relaxing(
    record: FittedRecord, memory: Memory, law: Callable[[Values, float], Relaxation], search: Perturbation
) -> Perturbation | Array | None:
    """Moduli that fall as r(t) = 1 - amount phi(t), phi the ``memory``. In full, where nothing adheres, by a ``law`` of
    the unknowns and of how long the record lasts, ``search`` their names, starts and limits."""
    column = _first_order(record, memory)
    adheres = any(part.tension for part in record.model.stretches)
    timed = np.ptp(record.model.stretches[0].t) > 0
    if column is None or adheres or not timed or record.model.positions:
        return column
    duration = record.duration
    loads = _loads_of_history(record, lambda values: law(values, duration))
    return replace(search, loads=loads, coupled=True, column=column, quantities=partial(_fall_and_time, duration))


def _fall_and_time(duration: float, values: Values) -> dict[str, float]:
    time = {TIME: duration * values[TIME]} if TIME in values else {}
    return {"fall": values[AMOUNT]} | time


@dataclass(frozen=True, eq=False)
class _History:
    """What memories act on, at some instants of the rows in contact: the instants ``t`` in two directions, over the
    time of the record, ``ages`` of the changes of the strain before each (instants, changes), and what each counts
    [N]. Ting: on the way out what came before t1, when the radius was the same, as load, the rest as displacement.
    ``rows``: those in contact of each direction in order of time, at the times ``at``."""

    t: tuple[Array, Array]
    ages: tuple[Array, Array]
    counts: tuple[Array, Array]
    rows: tuple[Array, Array]
    at: tuple[Array, Array]

    def changed(self, memory: Memory) -> Iterator[tuple[Array, Array]]:
        """Rows in contact, and the changes of their loads [N] per amount of a memory, which is 0 of no age."""
        for rows, at, t, ages, counts in zip(self.rows, self.at, self.t, self.ages, self.counts, strict=True):
            yield rows, np.interp(at, t, -np.einsum("ij,ij->i", memory(ages), counts))


def histories(records: Sequence[FittedRecord]) -> list[_History | None]:
    """Those of some records, None where there are not two directions or next to no contact."""
    found: list[_History | None] = [None] * len(records)
    alike: dict[tuple[Family, int, int], list[int]] = {}  # records of a body with as many instants
    each = {}
    for place, record in enumerate(records):
        if len(record.model.stretches) < 2 or min(np.count_nonzero(a) for a, _ in record.radii) < 4:
            continue
        each[place] = way, back = [_instants(record, *one) for one in enumerate(record.model.stretches)]
        alike.setdefault((record.model.family, way[2].shape[1], back[2].shape[1]), []).append(place)
    for (family, n, _), places in alike.items():
        (t, depth, a, P_H), (t_out, depth_out, a_out, _) = (
            np.stack([each[place][i][2] for place in places], axis=1) for i in (0, 1)
        )
        middle = np.concatenate([t[:, :1], (t[:, 1:] + t[:, :-1]) / 2], axis=1)
        before = np.concatenate([np.zeros((len(places), 1)), t_out[:, :-1]], axis=1)
        times = np.concatenate([middle, (t_out + before) / 2], axis=1)[:, None]
        largest = np.maximum.accumulate(a, axis=1)
        t1 = np.array([np.interp(*columns) for columns in zip(a_out, largest, t, strict=True)])
        _, T, _, V = family.values(np.log(a_out).ravel()).reshape(FUNCTIONS, *a_out.shape)
        S = np.array([[records[place].modulus] for place in places]) * V / T

        # what each change counts: dP_H up to t1, S d(delta) later
        steps = np.diff(np.concatenate([depth, depth_out], axis=1), prepend=depth[:, :1])[:, None]
        dP = np.zeros(steps.shape)
        dP[:, 0, :n] = np.diff(P_H, prepend=0.0)
        counts = np.where(times > t1[..., None], S[..., None] * steps, dP)
        ages = (np.maximum(now[..., None] - past, 0.0) for now, past in ((t, middle[:, None]), (t_out, times)))
        for place, *one in zip(places, t, t_out, *ages, dP, counts, strict=True):
            (rows, at, _), (rows_out, at_out, _) = each[place]
            found[place] = _History((one[0], one[1]), (one[2], one[3]), (one[4][:, :n], one[5]), (rows, rows_out),
                                    (at, at_out))  # fmt: skip
    return found


def _instants(record: FittedRecord, which: int, part: DirectionReadings) -> tuple[Array, Array, Array]:
    """The rows in contact of a stretch in order of time, when they were, and at some of them that time, the depth, the
    contact radius and P_H, (4, instants)."""
    a, rows = record.radii[which][0], slice(record.model.ends[which], record.model.ends[which + 1])
    touching, t = a > 0, record.time(part) * (-1 if part.kind == APPROACH else 1)
    inside = np.flatnonzero(touching)[:: 1 if which == 0 else -1]
    thin = inside[_some_of(inside.size)]
    P = part.P + record.residuals[rows]
    base = P[~touching].mean() if inside.size < a.size else 0.0
    depth = record.depth[rows][thin] - (P[thin] - base) / record.model.k
    return inside + rows.start, t[inside], np.array([t[thin], depth, a[thin], record.P_H[rows][thin]])


@lru_cache(maxsize=REMEMBERED)
def _some_of(count: int) -> Array:
    """Numbers of ``RELAXATION_INSTANTS`` of so many, or all."""
    return np.unique(np.linspace(0, count - 1, RELAXATION_INSTANTS).astype(int))


def _first_order(record: FittedRecord, memory: Memory) -> Array | None:
    """dP/d(amount) of all rows; None where memory has nothing to act on."""
    if record.history is None:
        return None
    column = np.zeros(record.a.size)
    for rows, changes in record.history.changed(memory):
        column[rows] = changes
    return column * record.at_fixed_position


def _loads_of_history(record: FittedRecord, law: Callable[[Values], Relaxation]) -> Loads:
    """Loads [N] of all rows of a stretch of a body that relaxes by a ``law`` of the unknowns, by its whole history."""
    t, x = _program(record)
    body = record.body.to_depth(CHANGE_BEYOND * record.reach)
    nonadhesive, relaxing_contact = Nonadhesive(body.series, body.slopes), offered("relaxing contact")

    @lru_cache(maxsize=REMEMBERED)
    def history(z0: float, moduli: Hashable) -> Sequence[PiecewiseCubic]:
        contact = relaxing_contact(nonadhesive, moduli, coarser=RELAXATION_COARSER, grows=RELAXATION_GROWS)
        try:
            path = contact.history(Program(t, x - z0)).path
            lost = min(path.lost, float(t.max()))
            times = [_dense_at_ends(*ends) for ends in ((path.begin, path.turn), (path.turn, lost))]
            return [cubic_spline(one, path.states(one)[2] ** RELAXATION_SMOOTH) for one in times]
        except InputError:  # there is no such history
            return [cubic_spline(np.array([t.min(), t.max()]), np.zeros(2))] * 2

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        spline = history(values["z0"], cast(Hashable, law(values)))[int(part.kind != APPROACH)]
        first, last = spline.x[[0, -1]]
        P: Array = np.maximum(spline(np.clip(part.t, first, last)), 0.0) ** (1 / RELAXATION_SMOOTH)
        return math.exp(values["ln_s"]) * np.where((part.t >= first) & (part.t <= last), P, 0.0)

    return loads


def _program(record: FittedRecord) -> tuple[Array, Array]:
    """Times since the turn [s] and positions of the tip [m], about ``RELAXATION_PIECES`` of each direction and the
    turn."""
    way, back = record.model.stretches
    tips = [part.z - (part.P - base_line(part, record.values)[0]) / record.model.k for part in (way, back)]
    some = slice(None, None, max(way.P.size // RELAXATION_PIECES, 1))
    t = np.concatenate([way.t[some], [0.0], back.t[::-1][some]])
    x = np.concatenate([tips[0][some], [record.tip_turn], tips[1][::-1][some]])
    order = np.argsort(t, kind="stable")
    return t[order], x[order]


def _dense_at_ends(first: float, last: float) -> Array:
    place: Array = (1 - np.cos(math.pi * np.linspace(0, 1, RELAXATION_TIMES))) / 2
    return first + (last - first) * place


# What is known of alternatives before the data.
ALTERNATIVE_CONE = 3.0  # choice: three times what a cone's exponent differs from a paraboloid's by: one step overshoots
ALTERNATIVE_STRAINS = 2.0  # choice: of the effect of large strains on rubber, that of other materials
ALTERNATIVE_DEVICE = 1.0  # choice: relative, by which a stiffness that someone measured may be off
ALTERNATIVE_SHAPE = 0.003  # choice: exponent of the profile within which a tip is what it is called: by as much its
# radius of curvature changes over a factor e of the contact radius


BODY, TIP, ADHESION, DEVICE, MEMORY = (
    "layer or substrate",
    "shape of the tip",
    "adhesion",
    "instrument",
    "relaxation or flow",
)
# What the unknowns of alternatives mean, by dimension:
OF_ALTERNATIVES = {
    AMOUNT: "number", "thickness": "length", "nu": "number", "exponent": "number", "range": "length",
    "surface_tension": "tension", "stiffness": "stiffness", "fall": "number", TIME: "time", POWER: "number",
    "creep": "number", "hysteresis": "number",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class AlternativeModel:
    """Name one thing that the fitted model leaves out: an entry of ``ALTERNATIVES``.

    Parameters
    ----------
    name : str
        As the table of alternatives shows it.
    family : str
        What cannot be distinguished from it as a rule.
    amount : str
        What a column is the derivative by, in words.
    effect : callable
        Of a FittedRecord: a Perturbation of the model, which can be fitted in full; or a column (n,) [N], the
        derivative of the loads by the amount, of first order; None where the alternative has no meaning for this
        record.
    likely : float or callable, optional
        Amount in either direction that is expected unless the user or the data say otherwise: 0 of what the description
        of the body rules out.
    limits : (float, float), optional
        Least and largest amounts that any body, tip or device has.
    of_directions : bool, optional
        Whether it sets one direction against the other.
    """

    name: str
    family: str
    amount: str
    effect: Callable[[FittedRecord], Perturbation | Array | None]
    likely: float | Callable[[FittedRecord], float] = 0.0
    limits: tuple[float, float] = ANY
    of_directions: bool = False

    def likely_in(self, record: FittedRecord) -> float:
        """The amount in either direction that is likely in a record."""
        return self.likely(record) if callable(self.likely) else self.likely


POSITIVE = (0.0, math.inf)
RANGE = AlternativeModel(
    "adhesion of finite range",
    ADHESION,
    "square of the range over that of a narrow ring",
    finite_range,
    likely_range,
    POSITIVE,
)
LONG = AlternativeModel("adhesion of long range (DMT)", ADHESION, "from JKR to DMT", long_range, limits=(0.0, 1.0))
TENSION = AlternativeModel(
    "surface tension", BODY, "2 tension/E* over the contact radius", tension, likely_tension, POSITIVE
)
RELAXING = (
    AlternativeModel(
        "relaxation over a factor of time",
        MEMORY,
        "fall per factor e",
        partial(
            relaxing,
            memory=lambda t: np.log(1 + 100 * t),
            law=lambda values, duration: PowerRelaxation(duration, values[AMOUNT]),
            search=Perturbation(((0.1,), (0.3,)), limits={AMOUNT: (1e-4, 0.9)}),
        ),
    ),
    AlternativeModel(
        "relaxation of one time",
        MEMORY,
        "fall",
        partial(
            relaxing,
            memory=lambda t: 1 - np.exp(-4 * t),
            law=lambda values, duration: StandardSolid(1 - values[AMOUNT], duration * values[TIME]),
            search=Perturbation(
                ((0.3, 0.03), (0.3, 0.2), (0.6, 0.5)), (AMOUNT, TIME), {AMOUNT: (1e-4, 0.999), TIME: (1e-3, 10.0)}
            ),
        ),
    ),
)
ALTERNATIVES: tuple[AlternativeModel, ...] = (
    AlternativeModel("w over the contact radius", ADHESION, "relative rise towards pull-off", work_over_radius),
    AlternativeModel(
        "w over the speed of the edge", ADHESION, "relative rise per factor e of the speed", work_over_speed),
    RANGE,
    LONG,
    AlternativeModel("a rigid substrate below", BODY, "contact radius over depth", layer_below),
    AlternativeModel("thickness of the layer", BODY, "relative change", thickness),
    AlternativeModel("nu of the layer", BODY, "relative change", poisson),
    AlternativeModel("moduli that change with the contact radius", BODY, "relative rise", graded),
    AlternativeModel("exponent of the tip", TIP, "change of the exponent", exponent, ALTERNATIVE_SHAPE,
          (-ALTERNATIVE_CONE, ALTERNATIVE_CONE)),
    AlternativeModel("sphere or paraboloid", TIP, "share of the sphere's quartic term", quartic, limits=(-1.0, 1.0)),
    AlternativeModel("no slip", BODY, "from none to full", no_slip, 1.0, POSITIVE),
    TENSION,
    AlternativeModel(
        "large strains", BODY, "of what is known of them", strains, likely_strains, (0.0, ALTERNATIVE_STRAINS)),
    *(RELAXING if is_offered("relaxing contact") else ()),
    AlternativeModel("residual depth", MEMORY, "of the depth of contact",
          misplaced_back(lambda record, part: np.full(part.z.size, -record.reach)), of_directions=True),
    AlternativeModel("another modulus on retraction", MEMORY, "relative change", another_modulus, of_directions=True),
    AlternativeModel("another slope at rest", MEMORY, "relative change", slope_at_rest, of_directions=True),
    AlternativeModel("stiffness of the cantilever", DEVICE, "relative change", stiffness,
          limits=(-ALTERNATIVE_DEVICE, ALTERNATIVE_DEVICE)),
    AlternativeModel("creep of the position", DEVICE, "of the travel, per decade of time",
          misplaced_back(lambda record, part: part.travel * creep(record.time(part)), "creep"), of_directions=True),
    AlternativeModel("hysteresis of the position", DEVICE, "of the travel, at most",
          misplaced_back(lambda _, part: part.travel * hysteresis(part.way), "hysteresis"), of_directions=True),
    AlternativeModel("scale of the position", DEVICE, "retraction against approach",
          misplaced_back(lambda record, part: record.reach * part.way), of_directions=True),
    AlternativeModel("drift of the depth", DEVICE, "of the depth over the force curve", drift, of_directions=True),
)  # fmt: skip


def columns(
    record: FittedRecord, alternatives: Sequence[AlternativeModel] = ALTERNATIVES
) -> dict[AlternativeModel, Array]:
    """The columns of all alternatives that mean anything for a record, by alternative."""
    found, table = next(tables([record], alternatives))
    return dict(zip(found, table[1 + record.fit.x.size :], strict=True))


def tables(
    records: Sequence[FittedRecord], alternatives: Sequence[AlternativeModel] = ALTERNATIVES
) -> Iterator[tuple[tuple[AlternativeModel, ...], Array]]:
    """Of some records the alternatives that mean anything and the ``table``; columns of changed bodies are taken
    together, by one look at where the rows lie on their branches."""
    each = list[tuple[list[AlternativeModel], Array]]()
    bodies = list[dict[int, Perturbation]]()  # of each record by their rows of its table
    for record in records:
        own, found, of_body = 1 + record.fit.x.size, list[AlternativeModel](), dict[int, Perturbation]()
        table = np.empty((own + len(alternatives), record.a.size))
        table[0], table[1:own] = record.residuals, record.jacobian.T
        for alternative in alternatives:
            try:
                effect = alternative.effect(record)
                column = record.column(effect) if isinstance(effect, Perturbation) else effect
            except (JkrError, FloatingPointError):
                continue  # a neighbouring body that cannot be solved is no alternative, and takes no fit with it
            row = own + len(found)
            if column is not None:
                table[row] = column
            elif isinstance(effect, Perturbation):
                of_body[row] = effect
            else:
                continue
            found.append(alternative)
        each.append((found, table[: own + len(found)]))
        bodies.append(of_body)

    for record, (found, table), of_body, changes in zip(records, each, bodies, changed_bodies(records, bodies),
                                                        strict=True):  # fmt: skip
        if of_body:
            table[[*of_body]] = record.by_bodies(changes)
        columns = table[1 + record.fit.x.size :]
        sums = np.vecdot(columns, columns)
        means = (0 < sums) & (sums < math.inf)  # of what is 0 throughout or has no meaning, too
        if not means.all():
            table = np.delete(table, 1 + record.fit.x.size + np.flatnonzero(~means), axis=0)
        yield tuple(itertools.compress(found, means.tolist())), table


def changed_bodies(records: Sequence[FittedRecord], changes: Sequence[Mapping[int, Perturbation]]) -> Iterator[Array]:
    """Of each of some records the changes of the logs of its body (changes, stretches, 4, n) per amount of each of the
    ``changes`` of it."""
    rings = (
        one.rings(record.model.family, {**record.values, AMOUNT: LITTLE})
        for record, some in zip(records, changes, strict=True) for one in some.values() if one.rings is not None
    )  # fmt: skip
    ring_changes([ring for ring in rings if ring is not None])  # of all at once, which are remembered

    # changes that follow from those of displacement and stiffness, of each body together
    shapes: dict[Family, list[tuple[Array, Array]]] = {}
    for record, some in zip(records, changes, strict=True):
        family = record.model.family
        of_shape = (one.shape for one in some.values() if one.shape is not None and one.per_amount is None)
        shapes.setdefault(family, []).extend(shape(family, LITTLE) for shape in of_shape)
    shaped = {
        family: iter(perturbed_logs(family, *(np.array(logs) for logs in zip(*some, strict=True))) / LITTLE)
        for family, some in shapes.items()
        if some
    }
    for record, some in zip(records, changes, strict=True):
        family = record.model.family
        bodies = np.empty((len(some), len(record.model.stretches), FUNCTIONS, grid(family).size))
        for body, change in zip(bodies, some.values(), strict=True):
            if change.per_amount is not None:
                body[:] = change.per_amount
            elif change.shape is not None:
                body[:] = next(shaped[family])
            else:
                body[:] = record.bodies_at(change, [LITTLE])[0] / LITTLE
        yield bodies

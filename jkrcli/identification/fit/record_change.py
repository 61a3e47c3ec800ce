"""A rival in full: the model of a raw record with an amount of what it leaves out as one more unknown, or two.

A ``Change`` says what an amount does to the body, the device or the positions of a stretch; ``RivalModel`` is the model
with it, whose search, covariance and result are those of any record. Derivatives by what a change depends on are
differences.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ...base import REMEMBERED, Array, SolveError
from .device_path import Changes, DeviceBranch, Rest, grid, on_grid
from .family import Family
from .force_curve import ForceCurveModel
from .force_curve_fit import ForceCurveFit
from .force_curve_readings import DirectionReadings

AMOUNT, ANY = "amount", (-math.inf, math.inf)
Values = Mapping[str, float]  # of all unknowns, by name
Loads = Callable[[ForceCurveModel, DirectionReadings, Values], Array]  # [N], of all rows of a stretch


@dataclass(frozen=True)
class ChangeTuning:
    """Differences by amounts, and how far rivals are followed."""

    little: float = 1e-3  # theory: relative amounts whose squares are below the noise of any record
    step: float = 1e-5  # theory: relative, for one-sided differences of loads that are good to 1e-9; of histories more
    # choice: a small amount: below it, and below such a share of the largest w, steps are no smaller; of the largest
    # contact radius, the ring of attraction and the length of a surface tension at which columns are taken
    small: float = 1e-2
    largest: float = 6.0  # choice: amount up to which rivals are searched where theory sets no limit
    beyond: float = 1.5  # choice: over the largest depth or contact radius of a record, where changed bodies end
    fold: float = 0.02  # choice: of the way in contact, rows left out about folds and before the loss of a slow edge


TUNING = ChangeTuning()
LITTLE = TUNING.little


@dataclass(frozen=True, eq=False)
class ChangedFamily(Family):
    """A family whose four logs differ by ``changes`` (4, nodes) from those of a ``body``, on its grid; beyond it they
    differ as at its ends."""

    body: Family | None = None
    changes: Array = field(default_factory=lambda: np.empty(0))

    @cached_property
    def spline(self) -> CubicSpline:
        assert self.body is not None
        return CubicSpline(grid(self.body), self.changes.T)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        near = np.clip(u, self.spline.x[0], self.spline.x[-1])
        return _changed(super().at(u), *(self.spline(near, order).T for order in range(3)))

    def at_nodes(self, u: Array) -> tuple[Array, Array, Array]:
        assert self.body is not None
        return _changed(on_grid(self.body), self.changes, *_rates(self.changes, float(u[1] - u[0])))


def _changed(
    functions: tuple[Array, Array, Array], g: Array, first: Array, second: Array
) -> tuple[Array, Array, Array]:
    """Functions f e^g and their two derivatives by u, from those of f and of ``g``."""
    value, by_u, by_uu = functions
    factor = np.exp(g)
    return (
        factor * value, factor * (by_u + first * value),
        factor * (by_uu + 2 * first * by_u + (second + first**2) * value),
    )  # fmt: skip


def _rates(g: Array, step: float) -> tuple[Array, Array]:
    """Two derivatives of rows at even nodes, of fourth order but at the two of each end."""
    near, far = slice(1, -3), slice(3, -1)
    first = (8 * (g[:, far] - g[:, near]) - g[:, 4:] + g[:, :-4]) / (12 * step)
    second = (16 * (g[:, far] + g[:, near]) - g[:, 4:] - g[:, :-4] - 30 * g[:, 2:-2]) / (12 * step**2)
    ends = np.clip(np.arange(-2, g.shape[1] - 2), 0, first.shape[1] - 1)
    return first[:, ends], second[:, ends]


def changed_family(family: Family, changes: Array) -> Family:
    """The family whose logs of D, T, H, V differ by ``changes`` (4, n) on its grid."""
    if not np.isfinite(changes).all():
        raise SolveError("no body has curves that differ so much")
    return ChangedFamily(family.logs, family.low, family.high, None, family, changes)


def interpolated(u: Array, changes: Array) -> Changes:
    """``changes`` (4, n) at logs ``u`` of the radius as a function of it; constant beyond the ends."""
    return lambda at: np.stack([np.interp(at, u, row) for row in changes])


def of_body(family: Family, D: Array, S: Array) -> Array:
    """Changes of the logs of D, T, H, V (4, n) on the grid of a body whose logs of displacement and stiffness change by
    ``D`` and ``S`` there: P_H = int S d(delta_H), and adhesion follows from S'."""
    u = grid(family)
    (d, t, _, v), (dD, dT, _, dV), _ = on_grid(family)
    s, ds = v / t, v / t * (dV / v - dT / t)
    dS = np.exp(S) * (ds + s * np.gradient(S, u, edge_order=2))
    rate = s * np.exp(S + D) * (dD + d * np.gradient(D, u, edge_order=2))
    T = np.log(ds / dS) / 2
    return np.stack([D, T, np.log(_integral(u, rate) / _plain_integral(family)), S + T])


@lru_cache(maxsize=REMEMBERED)
def _plain_integral(family: Family) -> Array:
    """The load without adhesion by the same integral."""
    (_, t, _, v), (dD, _, _, _), _ = on_grid(family)
    return _integral(grid(family), v / t * dD)


def _integral(u: Array, rate: Array) -> Array:
    """The integral of a ``rate`` over even nodes ``u``, a power law's up to the first: by cubics through values and
    derivatives (Euler and Maclaurin)."""
    step, log = float(u[1] - u[0]), np.log(rate[:2])
    by_u = _rates(rate[None], step)[0][0]
    cells = step / 2 * (rate[1:] + rate[:-1]) - step**2 / 12 * np.diff(by_u)
    integral: Array = np.cumsum(np.append(rate[0] * step / (log[1] - log[0]), cells))
    return integral


@dataclass(frozen=True, eq=False)
class Change:
    """What an amount of a rival does to the model of a record. One of

    - ``log_changes``: changes of the logs of D, T, H, V of the body of a stretch (4, n) on its grid, None for none;
    - ``model``: the model that a stretch follows, from the plain one, where more changes or bodies are shared;
    - ``shift``: what the positions of a stretch are off [m];
    - ``loads``: loads of a stretch [N] in place of those of the path, without adhesion;
    - ``loads_back``: the same of the last stretch alone, with adhesion;

    as functions of the stretch and of the values of all unknowns. ``starts``: values of the unknowns ``names`` to begin
    a search with; ``limits``: their least and largest; ``quantities``: what they mean, SI, by name. ``coupled``:
    whether the change depends on the other unknowns too. ``recentred``: the change about a fit that it led to, where it
    is made about one. ``column``: the derivative of all loads [N] by the amount, where it is not that at 0.
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
    recentred: Callable[[ForceCurveFit], Change] | None = None
    column: Array | None = None

    def followed(self, plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        """The model that a stretch follows in place of the ``plain`` one."""
        if self.model is not None:
            return self.model(plain, part, values)
        changes = None if self.log_changes is None else self.log_changes(plain, part, values)
        return plain if changes is None else replace(plain, family=changed_family(plain.family, changes))


def change_of_body(
    changes: Callable[[Family, float], Array], limits: tuple[float, float] = ANY, *, last: bool = False
) -> Change:
    """The change of the body by ``changes`` (4, n) of its logs at an amount; of the ``last`` stretch or of all."""
    changed = lru_cache(maxsize=2)(changes)
    body = lru_cache(maxsize=2)(lambda family, amount: changed_family(family, changed(family, amount)))

    def log_changes(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> Array | None:
        return None if last and part is not plain.stretches[-1] else changed(plain.family, values[AMOUNT])

    def model(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        if last and part is not plain.stretches[-1]:
            return plain
        return replace(plain, family=body(plain.family, values[AMOUNT]))

    return Change(limits={AMOUNT: limits}, log_changes=log_changes, model=model)


def _before_loss(part: DirectionReadings) -> DirectionReadings:
    """A stretch without the rows in contact next to its loss, which a slow edge runs through within a few of them."""
    if not part.touching.any():
        return part
    lost = float(part.z[part.touching].min())
    keep = ~part.touching | (part.z > lost + max(TUNING.fold * part.reach, 2 * part.spacing))
    return replace(part, **{name: getattr(part, name)[keep] for name in ("rows", "z", "P", "touching", "t")})


def _inputs(model: ForceCurveModel) -> dict[str, Any]:
    """What a model is made from, without its change."""
    return {item.name: getattr(model, item.name) for item in fields(ForceCurveModel)}


@dataclass(frozen=True, eq=False)
class RivalModel(ForceCurveModel):
    """The model of a record with a ``change``."""

    change: Change = Change()

    @classmethod
    def of(cls, plain: ForceCurveModel, change: Change) -> RivalModel:
        """The ``plain`` model, of a rival or not, with a change in place of its own."""
        inputs = _inputs(plain)
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
        key = part.kind, *(values[name] for name in (values if self.change.coupled else self.change.names))
        if key not in self._followed:
            if len(self._followed) >= REMEMBERED:
                self._followed.clear()
            self._followed[key] = self.change.followed(self._plain, part, values)
        return self._followed[key]

    def branch(self, part: DirectionReadings, values: Values) -> DeviceBranch:
        return self.followed(part, values).branch(part, values)

    def rest(self, part: DirectionReadings, values: Values) -> Rest | None:
        return self.followed(part, values).rest(part, values)

    def depth(self, part: DirectionReadings, values: Values) -> Array:
        depth = super().depth(part, values)
        return depth if self.change.shift is None else depth + self.change.shift(part, values)

    def evaluated(self, x: Array, blunt: float) -> tuple[Array, Array]:
        off, rates = super().evaluated(x, blunt)
        for i, name in enumerate(self.names):
            if name in self.change.names or (self.change.coupled and name.startswith(("ln_s", "q:", "r:", "z0"))):
                step = (TUNING.step if self.change.loads is None else LITTLE) * self._unit(name, float(x[i]))
                step = -step if x[i] + step > self.limits.get(name, (0.0, math.inf))[1] else step
                rates[:, i] = (self.off(x + step * (np.arange(x.size) == i), blunt) - off) / step
        return off, rates

    def _unit(self, name: str, x: float) -> float:
        """The size of an unknown that is ``x``."""
        if name == "z0":
            return max(part.reach for part in self.stretches)
        return max(abs(x), TUNING.small * (self.most if name.startswith(("q:", "r:")) else 1.0))

    def _load(self, part: DirectionReadings, values: Values, blunt: float) -> Array:
        loads = self._in_place_of_path(part)
        return super()._load(part, values, blunt) if loads is None else loads(self, part, values)

    def _contact(self, part: DirectionReadings, values: Values, blunt: float) -> tuple[Array, dict[str, Array]]:
        loads = self._in_place_of_path(part)
        return super()._contact(part, values, blunt) if loads is None else (loads(self, part, values), {})

    def _in_place_of_path(self, part: DirectionReadings) -> Loads | None:
        return self.change.loads or (self.change.loads_back if part is self.stretches[-1] else None)

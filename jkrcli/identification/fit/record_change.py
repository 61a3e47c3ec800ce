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

from ...base import Array, SolveError
from .device_path import Changes, DeviceBranch, Rest, grid, on_grid
from .family import Family
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel

AMOUNT = "amount"


@dataclass(frozen=True)
class ChangeTuning:
    """Differences by amounts."""

    little: float = 1e-3  # theory: relative amounts whose squares are below the noise of any record
    step: float = 1e-5  # theory: relative, for one-sided differences of loads that are good to 1e-9; of histories more
    small: float = 1e-2  # choice: amounts, and shares of the largest w, below which steps are no smaller
    fold: float = 0.02  # choice: of the way in contact, rows left out about folds and before the loss of a slow edge
    remembered: int = 8  # choice: changed models kept, one for each stretch and set of amounts


TUNING = ChangeTuning()
LITTLE = TUNING.little


@dataclass(frozen=True, eq=False)
class Bent(Family):
    """A family whose four logs differ by ``changes`` (4, nodes) on the grid of that of a ``body``, as at its ends
    beyond them."""

    body: Family | None = None
    changes: Array = field(default_factory=lambda: np.empty(0))

    @cached_property
    def spline(self) -> CubicSpline:
        assert self.body is not None
        return CubicSpline(grid(self.body), self.changes.T)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        near = np.clip(u, self.spline.x[0], self.spline.x[-1])
        return _bent(super().at(u), *(self.spline(near, order).T for order in range(3)))

    def at_nodes(self, u: Array) -> tuple[Array, Array, Array]:
        assert self.body is not None
        return _bent(on_grid(self.body), self.changes, *_rates(self.changes, float(u[1] - u[0])))


def _bent(functions: tuple[Array, Array, Array], g: Array, first: Array, second: Array) -> tuple[Array, Array, Array]:
    """Functions and their derivatives, the logs changed by ``g``."""
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


def bent(family: Family, changes: Array) -> Family:
    """A family whose logs of D, T, H, V differ by ``changes`` (4, n) on its grid."""
    if not np.isfinite(changes).all():
        raise SolveError("no body has curves that differ so much")
    return Bent(family.logs, family.low, family.high, None, family, changes)


def by_log(u: Array, changes: Array) -> Changes:
    """Changes (4, n) at logs ``u`` of the radius, as they are beyond."""
    return lambda at: np.stack([np.interp(at, u, row) for row in changes])


def bending(bends: Callable[[ForceCurveModel, DirectionReadings, Values], Array | None]) -> dict[str, Any]:
    """What a change has that ``bends`` the bodies of stretches."""

    def model(plain: ForceCurveModel, part: DirectionReadings, values: Values) -> ForceCurveModel:
        changes = bends(plain, part, values)
        return plain if changes is None else replace(plain, family=bent(plain.family, changes))

    return {"bends": bends, "model": model}


def of_body(family: Family, D: Array, S: Array) -> Array:
    """Changes of the logs (4, n) on the grid where those of displacement and stiffness change by ``D`` and ``S`` there:
    the load follows by dP = S d(delta), adhesion by S'."""
    u = grid(family)
    (d, t, _, v), (dD, dT, _, dV), _ = on_grid(family)
    s, ds = v / t, v / t * (dV / v - dT / t)
    dS = np.exp(S) * (ds + s * np.gradient(S, u, edge_order=2))
    rate = s * np.exp(S + D) * (dD + d * np.gradient(D, u, edge_order=2))
    T = np.log(ds / dS) / 2
    return np.stack([D, T, np.log(_integral(u, rate) / _plain_integral(family)), S + T])


@lru_cache(maxsize=TUNING.remembered)
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
    found: Array = np.cumsum(np.append(rate[0] * step / (log[1] - log[0]), cells))
    return found


Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Change:
    """What an amount of a rival does. ``model``: the model that a stretch follows at the values of the unknowns, from
    the plain one; ``moved``: what its positions are off [m]; ``load``: its loads [N], all, in place of a path's,
    without adhesion; ``back``: those of the last stretch alone, with it.

    ``bends``: what ``model`` does to the logs of the body of a stretch (4, n) on its grid, where that is all it does.
    ``starts``: values of the unknowns ``names`` to begin with; ``limits``: their least and largest; ``told``: what they
    mean, SI, by name. ``felt``: whether ``model`` or ``load`` depend on the other unknowns too. ``renewed``: the change
    about a fit that it led to, where it is made about one. ``column``: in place of the derivative at the amount 0,
    where another one looks further.
    """

    starts: tuple[tuple[float, ...], ...]
    names: tuple[str, ...] = (AMOUNT,)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    model: Callable[[ForceCurveModel, DirectionReadings, Values], ForceCurveModel] | None = None
    bends: Callable[[ForceCurveModel, DirectionReadings, Values], Array | None] | None = None
    moved: Callable[[DirectionReadings, Values], Array] | None = None
    load: Callable[[ForceCurveModel, DirectionReadings, Values], Array] | None = None
    back: Callable[[ForceCurveModel, DirectionReadings, Values], Array] | None = None
    felt: bool = False
    told: Callable[[Values], dict[str, float]] = lambda values: {AMOUNT: values[AMOUNT]}
    renewed: Callable[[ForceCurveFit], Change] | None = None
    column: Array | None = None


def _before_loss(part: DirectionReadings) -> DirectionReadings:
    """A stretch without the rows in contact next to its loss, which a slow edge runs through within a few of them."""
    if not part.touching.any():
        return part
    lost = float(part.z[part.touching].min())
    keep = ~part.touching | (part.z > lost + max(TUNING.fold * part.reach, 2 * part.spacing))
    held = {name: getattr(part, name)[keep] for name in ("rows", "z", "P", "touching", "t")}
    return replace(part, **held)


@dataclass(frozen=True, eq=False)
class RivalModel(ForceCurveModel):
    """The model of a record with a ``change``."""

    change: Change = Change(())

    @classmethod
    def of(cls, plain: ForceCurveModel, change: Change) -> RivalModel:
        """The ``plain`` model, of a rival or not, with a change in place of its own."""
        held = {item.name: getattr(plain, item.name) for item in fields(ForceCurveModel)}
        if change.load is not None:  # which knows no adhesion
            held["works"] = {part.kind: 0.0 for part in plain.stretches}
        if change.back is not None:
            held["stretches"] = (*plain.stretches[:-1], _before_loss(plain.stretches[-1]))
        return cls(**held, change=change)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return (*super().names, *(name for name in self.change.names if name not in self.known))

    @property
    def limits(self) -> Mapping[str, tuple[float, float]]:
        return {**super().limits, **self.change.limits}

    def further(self, values: Values) -> dict[str, float]:
        return self.change.told(values)

    @cached_property
    def _changed(self) -> dict[object, ForceCurveModel]:
        return {}

    def followed(self, part: DirectionReadings, values: Values) -> ForceCurveModel:
        """The plain model that a stretch follows."""
        key = part.kind, *(values[name] for name in (values if self.change.felt else self.change.names))
        if key not in self._changed:
            if len(self._changed) >= TUNING.remembered:
                self._changed.clear()
            plain = ForceCurveModel(**{item.name: getattr(self, item.name) for item in fields(ForceCurveModel)})
            self._changed[key] = plain if self.change.model is None else self.change.model(plain, part, values)
        return self._changed[key]

    def branch(self, part: DirectionReadings, values: Values) -> DeviceBranch:
        return self.followed(part, values).branch(part, values)

    def rest(self, part: DirectionReadings, values: Values) -> Rest | None:
        return self.followed(part, values).rest(part, values)

    def depth(self, part: DirectionReadings, values: Values) -> Array:
        depth = super().depth(part, values)
        return depth if self.change.moved is None else depth + self.change.moved(part, values)

    def evaluated(self, x: Array, blunt: float) -> tuple[Array, Array]:
        off, rates = super().evaluated(x, blunt)
        for i, name in enumerate(self.names):
            if name in self.change.names or (self.change.felt and name.startswith(("ln_s", "q:", "r:", "z0"))):
                step = (TUNING.step if self.change.load is None else LITTLE) * self._unit(name, float(x[i]))
                step = -step if x[i] + step > self.limits.get(name, (0.0, math.inf))[1] else step
                rates[:, i] = (self.off(x + step * (np.arange(x.size) == i), blunt) - off) / step
        return off, rates

    def _unit(self, name: str, x: float) -> float:
        """The size of an unknown that is ``x``."""
        if name == "z0":
            return max(part.reach for part in self.stretches)
        return max(abs(x), TUNING.small * (self.most if name.startswith(("q:", "r:")) else 1.0))

    def _told(self, part: DirectionReadings) -> Callable[[ForceCurveModel, DirectionReadings, Values], Array] | None:
        """What gives the loads of a stretch in place of a path."""
        return self.change.load or (self.change.back if part is self.stretches[-1] else None)

    def _load(self, part: DirectionReadings, values: Values, blunt: float) -> Array:
        told = self._told(part)
        return super()._load(part, values, blunt) if told is None else told(self, part, values)

    def _contact(self, part: DirectionReadings, values: Values, blunt: float) -> tuple[Array, dict[str, Array]]:
        told = self._told(part)
        return super()._contact(part, values, blunt) if told is None else (told(self, part, values), {})

"""How far a fit rests on its model: the nearest other models, which the data reject or not.

There are three rivals: a work of adhesion that changes along the record, moduli that do, as those of a layer or a
base seem to, and adhesion that has a range (``range_rival``). The first two add one direction each to the residuals,
that of w or of the moduli times a straight line in the contact radius. Where a rival is significant to first order,
this is a warning. What the data leave of it is fitted again at both of its ends: it moves the parameters, a second part
of their uncertainty beside the statistical one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import fdtrc

from ...base import MOST_SOLVES, TINY, Array, SolveError
from ..answer import FittedValue
from .family import Drift
from .range_rival import RangeRival, range_rival_of
from .search import TUNING as SEARCH
from .search import Minimum
from .settings import Settings
from .statistics import rise, t_quantile


@dataclass(frozen=True)
class RivalTuning:
    """What is expected of rivals before the data, and when they are significant."""

    likely: float = 0.5  # choice: standard deviation of the relative change along the record; w of polymers may double
    # choice: the change for which moves are told, and not counted, where the data hold no pull-off that would test it
    unit: float = 0.01
    chance: float = 5e-3  # choice: at which data of the model itself show a rival
    changes: tuple[float, float] = (-0.7, 1.2)  # choice: guard, along the record; w and moduli stay above 0
    close: float = 0.5  # theory: the last step, in standard errors; what remains is its square, a quarter
    fewest: int = 6  # choice: degrees of freedom; two of them go to the rivals
    reached: float = 1.1  # choice: in contact radius, how near to pull-off the data must come
    touching: float = 0.05  # choice: of the largest contact radius, below which pull-off without contact is near


TUNING = RivalTuning()
# What changes along the record, how it is called, and where on the record the fitted value is meant to hold: 0 at the
# smallest contact radius (w there decides pull-off), 1/2 in the middle.
RIVALS = {"w": ("a change of w along the record", 0.0), "modulus": ("a change of E* along the record", 0.5)}
RANGE = "a range of adhesion"


@dataclass(frozen=True, eq=False)
class Rival:
    """A model with one more number, the relative ``change`` of a parameter from the smallest to the largest contact
    radius; ``moves``: how far the changes that the data leave likely move each unknown."""

    name: str
    change: float
    moves: Mapping[str, float]

    @property
    def words(self) -> str:
        """The change with its size, which is of first order and no number where it is beyond ``TUNING``'s guards."""
        clipped = float(np.clip(self.change, *TUNING.changes))
        return f"{RIVALS[self.name][0]} by {'' if clipped == self.change else 'more than '}{clipped:+.0%}"


@dataclass(frozen=True, eq=False)
class Rivals:
    """The rivals of a fit; ``chance``: that data of the model itself speak as much for its ``members``; ``range``: of
    adhesion, None where none was tried. ``untested``: whether the data end before pull-off, so that nothing tests a
    change along the record: the moves of the ``values`` are then those of a change by ``TUNING.unit``, told and not
    counted."""

    members: tuple[Rival, ...]
    chance: float
    range: RangeRival | None = None
    untested: bool = False
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def sensitivity(self) -> str:
        """What a change along the record would move, where it is not counted; empty where it is."""
        names = {"w": "w", "modulus": "E*"}
        parts = [
            f"of {names[rival.name]} moves " + " and ".join(
                f"{names[key]} by {rival.moves[key] / self.values[key]:.1%}" for key in names if rival.moves.get(key)
            )
            for rival in self.members
        ]  # fmt: skip
        return f"a change by {TUNING.unit:.0%} along the record {', '.join(parts)}" if self.untested and parts else ""

    def warnings(self) -> Iterator[str]:
        """A sentence where a rival is significant."""
        if self.chance < TUNING.chance:
            parts = " or ".join(rival.words for rival in self.members)
            yield (
                f"model rejected, p = {self.chance:.1g}, in favour of {parts} with the contact "
                "radius: other bodies (a layer, a base), or adhesion that depends on speed or has a range; the "
                "statistical intervals do not hold it"
            )
        if self.range is not None:
            yield from self.range.warnings()

    def with_parts(self, estimates: Sequence[FittedValue]) -> tuple[FittedValue, ...]:
        """The ``estimates`` with what the rivals may move each by; what follows from the moduli's factor with it."""
        moves = {} if self.untested else {RIVALS[rival.name][0]: rival.moves for rival in self.members}
        moves |= {} if self.range is None else {RANGE: self.range.moves}
        modulus = next((item.value for item in estimates if item.name == "modulus"), 1.0)

        def part(item: FittedValue, by: Mapping[str, float]) -> float:
            follows = item.value * by.get("modulus", 0.0) / modulus if item.dimension == "modulus" else 0.0
            return 0.0 if item.error is None else by.get(item.name, follows)

        parts = [{name: move for name, by in moves.items() if (move := part(item, by))} for item in estimates]
        return tuple(replace(item, model=own or None) for item, own in zip(estimates, parts, strict=True))


def missed_pull_off(a: Array, line: Mapping[str, Array]) -> tuple[float, float] | None:
    """The least radius [m] of the rows ``a`` and that of the least load of their ``line``, where they do not come near
    it; None where they do, or hold no loads."""
    if "P" not in line:
        return None
    radius, least = float(line["a"][int(np.argmin(line["P"]))]), float(np.min(a))
    near = max(TUNING.reached * radius, TUNING.touching * float(np.max(a)))
    return (least, radius) if least > near else None


def rivals_of(minimum: Minimum, variance: float, dof: int, settings: Settings) -> Rivals:
    """The rivals of a ``minimum``; ``variance`` of the residuals and its degrees of freedom. None of few points, and of
    parameters that are 0."""
    objective, residuals = minimum.objective, minimum.distances.residuals.ravel()
    values = objective.values(minimum.x)
    wanted = [name for name in RIVALS if values.get(name, 0.0) > 0]
    if dof < TUNING.fewest or not wanted or not variance > 0:
        return Rivals((), 1.0)
    t, both = t_quantile(settings.level, dof), dof * rise(settings.level, dof, 2)  # w and the range together
    ranged = range_rival_of(minimum, variance, both, settings) if "w" in wanted else None
    jacobian = minimum.distances.jacobian(objective.free)
    directions = np.stack([_direction(minimum, name) for name in wanted], axis=1)
    alone = directions - jacobian @ np.linalg.lstsq(jacobian, directions, rcond=None)[0]
    rivals, close = [], TUNING.close * math.sqrt(variance)
    untested = values.get("w", 0.0) > 0 and missed_pull_off(minimum.distances.a, minimum.distances.line()) is not None
    for name, direction in zip(wanted, alone.T, strict=True):
        precision = float(direction @ direction) / variance
        if precision > 0:
            change = -float(direction @ residuals) / variance / precision
            spread = t / math.sqrt(precision + 1 / TUNING.likely**2)
            centre = change * (spread / t) ** 2 * precision
            changes = (-TUNING.unit, TUNING.unit) if untested else (centre - spread, centre + spread)
            rivals.append(Rival(name, change, _moves(minimum, name, changes, close)))
    return Rivals(tuple(rivals), _chance(alone, residuals, variance, dof), ranged, untested, values)


def _moves(minimum: Minimum, name: str, changes: tuple[float, ...], close: float) -> dict[str, float]:
    """How far the values of the free parameters move, at most, where ``name`` changes along the record by any of
    ``changes``; ``close``: as in ``_followed``."""
    objective, before = minimum.objective, minimum.objective.values(minimum.x)
    moves = dict.fromkeys(objective.unknowns.names, 0.0)
    a = minimum.distances.a
    for change in changes:
        drift = Drift(name, float(np.clip(change, *TUNING.changes)), RIVALS[name][1], float(a.min()), float(a.max()))
        after = _followed(minimum, drift, close)
        moves = {key: max(move, abs(after[key] - before[key])) for key, move in moves.items()}
    return moves


def _followed(minimum: Minimum, drift: Drift, close: float) -> dict[str, float]:
    """The values of the parameters with a ``drift`` that leave the residuals as they are, as nearly as possible: what
    noise and outliers there are stays. Gauss-Newton, until a step changes the residuals by less than ``close``."""
    objective, x = replace(minimum.objective, drift=drift), minimum.x.copy()
    free, target = objective.free, minimum.distances.residuals.ravel()
    logs = np.array([parameter.kind == "log" for parameter in objective.parameters])
    low, high = x - np.where(logs, SEARCH.reach, np.inf), x + np.where(logs, SEARCH.reach, np.inf)
    before = x
    for _ in range(MOST_SOLVES):
        try:
            there = objective.distances(x)
            jacobian = there.jacobian(free)
        except SolveError:  # a step to where no body can be solved
            x = (x + before) / 2
            continue
        before = x.copy()
        step = np.linalg.lstsq(jacobian, there.residuals.ravel() - target, rcond=None)[0]
        x[free] -= step
        x = np.clip(x, low, high)
        if np.linalg.norm(jacobian @ step) < close:
            break
    values = objective.values(x)
    radii = np.array([there.a.min(), there.a.max()])  # the model's own, not those of before
    values[drift.name] *= float(drift.factor(radii) @ (1 - drift.centre, drift.centre))
    return values


def _direction(minimum: Minimum, name: str) -> Array:
    """Derivative of the residuals by the relative change of the parameter ``name`` along the record, (k n,)."""
    index = [parameter.name for parameter in minimum.objective.parameters].index(name)
    parameter, x = minimum.objective.parameters[index], float(minimum.x[index])
    by_log = minimum.distances.jacobian(np.array([index]))[:, 0] * parameter.outer(x) / parameter.derivative(x)
    a = minimum.distances.a
    place = (a - a.min()) / max(float(np.ptp(a)), TINY) - RIVALS[parameter.name][1]
    return by_log * np.tile(place, by_log.size // place.size)


def _chance(alone: Array, residuals: Array, variance: float, dof: int) -> float:
    """Chance of what the rivals together take from the squares of the residuals (F test)."""
    taken = residuals @ alone @ np.linalg.lstsq(alone, residuals, rcond=None)[0]
    k = alone.shape[1]
    return float(fdtrc(k, max(dof - k, 1), max(taken, 0.0) / k / variance))

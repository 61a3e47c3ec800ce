"""The search for the parameters whose curve lies nearest to the points: starts, least squares, bodies solved anew.

A start is a curve of the body, named by the radius at which it is pulled off under load control, which fixes the shape
sqrt(w/s), and by the radius that the largest load reaches, which fixes the factor s of all moduli. Zero points follow
by averages.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ...base import MOST_SOLVES, NOTICEABLE, ROUNDED, SAME, SETTLED, UNSEEN, Array, InputError, JkrError, evenly, show
from ..least_squares import Least, LeastSquares, State
from ..parameters import OF_A_CYCLE
from .body import FittedBody
from .family import ADVANCING, RECEDING, RESTING, Family, RestingMember
from .model import Distances, Objective, Readings, arc
from .points import TUNING as ROWS
from .points import Points, scatter
from .settings import RANGES, Loss, Settings
from .statistics import TURNS, robust_scale


@dataclass(frozen=True)
class FitSearchTuning:
    """Limits of the search: where it starts, which starts it follows, which minimum is the answer."""

    # Least squares
    converged_rough: float = 1e-7  # choice: relative, of a robust loss, whose turn is an estimate, and of samples
    evaluations: int = 200  # choice: guard
    reach: float = 7.0  # choice: guard, how far logs may move from their start
    body_reach: float = 9.0  # choice: guard, the same of layers from their nominal values
    faint: float = 1e-8  # theory: w > 0, in natural units: at 0 the shift by its root has no derivative by w
    # Starts
    nodes: int = 200  # tuned on records by `make tuning`: vertices of a curve that is tried
    beyond: float = 1.2  # choice: of log a, how far beyond a series that can be extended curves are tried
    slightly: float = 0.05  # choice: the same of one that cannot
    shapes: int = 24  # tuned on records by `make tuning`: values of sqrt(w/s) that are tried
    factors: int = 24  # tuned on records by `make tuning`: values of s that are tried
    readings: int = 60  # tuned on records by `make tuning`: rows that starts are compared with
    alternatives: int = 4  # tuned on records by `make tuning`: starts kept for each body
    load_zeros: tuple[float, ...] = (0.0, -0.3, 0.3, -0.8, 0.8)  # choice: zeros of the load, in ranges of the loads
    # Factors of nominal values where one or two parameters of layers are free; of more only the nominal values.
    scanned: Mapping[int, Mapping[str, tuple[float, ...]]] = field(  # choice: factors that least squares bridges
        default_factory=lambda: {
            1: {"E": (0.05, 0.2, 1.0, 4.0, 16.0), "h": (0.2, 0.45, 1.0, 2.2, 5.0)},
            2: {"E": (0.1, 1.0, 10.0), "h": (0.3, 1.0, 3.0)},
        }
    )
    looked_at: int = 8  # tuned on records by `make tuning`: starts whose cost is computed in full
    followed: int = 4  # tuned on records by `make tuning`: starts that are followed to their minimum

    # Ranges over the displacement that adhesion adds at JKR's pull-off; Tabor numbers 0.3, 1, 3, 10:
    ranges: tuple[float, ...] = (1.0, 0.3, 0.1, 0.03)  # choice: least squares bridges what lies between
    halvings: int = 2  # choice: of the steps next to the least, whose valley may be as narrow as one
    followed_ranges: int = 2  # choice: of them that are followed to their minimum

    span: float = 5.0  # choice: of the log of a range from its start: beyond, all is a rigid sphere or JKR
    # Cycles
    shares: tuple[float, ...] = (0.75, 0.5)  # choice: of a way back, what may recede if the rest is at rest
    worth: float = 16.0  # theory: fall of chi^2 by a turn and a choice of rows that chance brings once in 2000
    nearer: float = 16.0  # theory: square of four standard deviations, beyond which 6e-5 of normal noise lies
    # Minima, in sizes of the curve
    least_size: float = 0.05  # choice: of the data's range, the least size of a curve
    near: float = 1e-3  # tuned on records by `make tuning`: residuals so small that no other start is tried
    noise: float = 2.0  # theory: standard deviations of the readings that leave nothing to explain
    far: float = 0.1  # tuned on records by `make tuning`: noise that hides whether a fit is good
    alien: float = 0.5  # choice: residuals that are no fit at all
    # Radii
    past_end: float = 1.02  # choice: how far the data may reach beyond a series, as noise does
    # choice: of the radii that the data reach, where a body is solved anew, and how far starts may reach beyond a
    # series before it is
    room: float = 1.25
    # of the largest radius, to which the series must begin at most; theory: the depth there is 1e-6 of the largest
    smallest: float = 1e-3
    least_used: float = 0.5  # choice: part of the series below which it is solved anew to smaller radii


TUNING = FitSearchTuning()


# ---------------------------------------------------------------------- least squares
@dataclass(frozen=True, eq=False)
class ScaledDistances(State):
    """The ``distances`` at some unknowns as the search takes them."""

    distances: Distances


def _scaled(objective: Objective, begin: Array, y: Array) -> ScaledDistances:
    """The distances at the free unknowns ``y``, the others as in ``begin``."""
    distances = objective.distances(objective.at(begin, y))
    return ScaledDistances(distances.residuals.ravel(), partial(_rates, objective, distances), distances)


def _rates(objective: Objective, distances: Distances) -> Array:
    return distances.jacobian(objective.free) * objective.unknowns.scales


@dataclass(frozen=True, eq=False)
class Minimum:
    """The point of least sum of losses of an ``objective``: ``x`` all unknowns, ``least``: that of the free ones."""

    objective: Objective
    x: Array
    least: Least

    @property
    def distances(self) -> Distances:
        """The distances there."""
        assert isinstance(self.least.state, ScaledDistances)
        return self.least.state.distances

    @property
    def cost(self) -> float:
        """Half the sum of the losses."""
        return self.least.cost

    @property
    def width(self) -> float:
        """At which the robust loss turns, in scaled units."""
        return self.least.problem.width

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Names of parameters that end on a bound."""
        free = zip(self.objective.unknowns.names, self.least.at_bound, strict=True)
        return tuple(name for name, on_bound in free if on_bound)


def minimise(objective: Objective, start: Array, loss: Loss = "linear", width: float = 1.0) -> Minimum:
    """The least sum of squares (or of a robust ``loss`` that turns at ``width``) from the unknowns ``start``.

    Where the data do not determine the unknowns the search may creep along a valley that has no lowest point, and
    whether it stops there is a matter of round-off: it is given up after so many evaluations, and the minimum is marked
    as one whose search did not end.
    """
    begin = np.array(start, dtype=float)
    y = begin[objective.free] / objective.unknowns.scales
    splines = objective.ranged or any(parameter.of_body for parameter in objective.unknowns.free)
    close = ROUNDED if splines else SETTLED  # curves of layers and ranges are good to 1e-8 themselves
    close = close if loss == "linear" else max(close, TUNING.converged_rough)
    model, bounds = partial(_scaled, objective, begin), _bounds(objective, y)
    problem = LeastSquares(model, bounds, close, 0.0, TUNING.evaluations, loss, width)
    least = problem.least(_inside(y, *bounds))
    return Minimum(objective, objective.at(begin, least.x), least)


def _if_any(objective: Objective, start: Array) -> Minimum | None:
    """The same; None where a range takes the surfaces beyond the body."""
    try:
        return minimise(objective, start)
    except JkrError:
        if not objective.ranged:
            raise
    return None


def robust(minimum: Minimum, loss: Loss) -> Minimum:
    """The minimum of a robust loss from that of least squares on; its turn is set twice by the residuals' scatter."""
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * max(robust_scale(minimum.distances.residuals), 1e-12)
        minimum = minimise(minimum.objective, minimum.x, loss, width)
    return minimum


def _bounds(objective: Objective, start: Array) -> tuple[Array, Array]:
    """Bounds of the free unknowns; logs stay near their ``start``, those of layers around their nominal values, as far
    as the user's bounds let them."""
    free, about = objective.unknowns.free, {}
    for p, x in zip(free, start.tolist(), strict=True):
        if p.of_body:
            about[p.name] = p.inner(objective.body.nominal(p.name)), TUNING.body_reach
        elif p.name in RANGES:
            about[p.name] = x, TUNING.span
    low, high = objective.unknowns.bounds(start, TUNING.reach, about)
    faint = np.array([TUNING.faint if p.kind == "positive" else -math.inf for p in free])
    return np.maximum(low, np.minimum(faint, high / 2)), high


def _inside(y: Array, low: Array, high: Array) -> Array:
    """Unknowns strictly between the bounds, as the trust region wants it."""
    room = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(y), 1.0))
    return np.clip(y, low + 1e-8 * room, high - 1e-8 * room)


# ---------------------------------------------------------------------- starts
@dataclass(frozen=True)
class Start:
    """Values of parameters to begin with, SI, by name; ``reach``: the largest contact radius [m] of the data with
    them; ``cost``: mean square distance in units of the data's ranges, for comparison of starts."""

    values: Mapping[str, float]
    reach: float
    cost: float


def starts(family: Family, points: Points, known: Mapping[str, float], beyond: bool) -> list[Start]:
    """The best starting values, best first; InputError where no curve of the series resembles the data.

    ``known``: the values that are fixed, SI. ``beyond``: curves that go beyond the series count too.
    """
    if "a" in points.columns:
        return [_with_radii(family, points, known)]
    delta, P = _stable_rows(points.values["delta"], points.values["P"])
    u = np.linspace(family.low, family.high + (TUNING.beyond if beyond else TUNING.slightly), TUNING.nodes)
    (D, T, H, V), (dD, dT, dH, dV), _ = family.at(u)
    candidates = []
    for P0, shape in itertools.product(_load_zeros(points, known), _shapes(dH / dV)):
        stable = slice(int(np.argmin(H - shape * V)), None)
        delta_P_and_rates = [(X - shape * Y)[stable] for X, Y in ((D, T), (H, V), (dD, dT), (dH, dV))]
        curve = StableBranch(shape, u[stable], *delta_P_and_rates)
        candidates += curve.match(delta, P - P0, {**known, "P0": P0})
    candidates.sort(key=lambda start: start.cost)
    if not candidates:
        raise InputError("no curve of the series resembles the data: check signs, units and the indenter")
    return candidates[: TUNING.alternatives]


def _stable_rows(delta: Array, P: Array) -> tuple[Array, Array]:
    """A few readings spread over those that are stable under load control: not beyond the least load, if enough."""
    rows = np.flatnonzero(delta >= delta[int(np.argmin(P))])
    rows = rows if rows.size >= ROWS.least else np.arange(P.size)
    some = rows[evenly(rows.size, TUNING.readings)]
    return delta[some], P[some]


@dataclass(frozen=True, eq=False)
class StableBranch:
    """The branch of one curve at s = 1 that is stable under load control, by increasing load."""

    shape: float
    u: Array
    delta: Array
    P: Array
    ddelta: Array
    dP: Array

    def match(self, delta: Array, P: Array, known: Mapping[str, float]) -> list[Start]:
        """Starts with this shape, for the few factors that are possible, the best only."""
        if self.P.size < 4:
            return []
        factors = np.array([f for f in self._factors(P, known) if np.isfinite(f) and f > 0])
        if factors.size == 0:
            return []
        compliance = known.get("compliance") or 0.0
        load = P / factors[:, None]
        model = np.interp(load, self.P, self.delta)
        slope = np.interp(load, self.P, self.ddelta / np.maximum(self.dP, 1e-30 * self.dP.max()))
        force, length = np.ptp(P), np.ptp(delta)
        weight = 1 / (length**2 + (slope / factors[:, None] * force) ** 2)
        gap = delta - compliance * P - model
        zero = np.sum(weight * gap, axis=1) / np.sum(weight, axis=1)
        zero = np.full(factors.size, known["delta0"]) if "delta0" in known else zero
        beyond = (load - np.clip(load, self.P[0], self.P[-1])) * factors[:, None] / force
        cost = np.mean(weight * (gap - zero[:, None]) ** 2 + beyond**2, axis=1)
        best = int(np.argmin(cost))
        s = float(factors[best])
        reach = float(np.exp(np.interp(load[best].max(), self.P, self.u)))
        return [Start(_values(s, self.shape**2 * s, zero[best], known["P0"], compliance), reach, float(cost[best]))]

    def _factors(self, P: Array, known: Mapping[str, float]) -> Iterator[float]:
        if "modulus" in known:
            yield known["modulus"]
        elif "w" in known and self.shape > 0:
            yield known["w"] / self.shape**2
        else:
            end = P.max() if P.max() >= -P.min() else P.min()
            loads = self.P[np.linspace(0, self.P.size - 1, TUNING.factors).astype(int)]
            yield from (end / load for load in loads if load * end > 0)


def _values(modulus: float, w: float, delta0: float, P0: float, compliance: float) -> dict[str, float]:
    named = {"modulus": modulus, "w": w, "delta0": delta0, "P0": P0, "compliance": compliance}
    return {name: float(value) for name, value in named.items()}


def _shapes(stationary: Array) -> Array:
    """sqrt(w/s) of curves that are pulled off at radii across the series, and of almost no adhesion."""
    shapes = np.unique(stationary[stationary > 0])
    some = shapes[np.linspace(0, shapes.size - 1, min(TUNING.shapes, shapes.size)).astype(int)]
    return np.concatenate([[0.0], some])


def _load_zeros(points: Points, known: Mapping[str, float]) -> tuple[float, ...]:
    if "P0" in known:
        return (known["P0"],)
    if points.baseline is not None:
        return (points.baseline,)
    return tuple(part * float(np.ptp(points.values["P"])) for part in TUNING.load_zeros)


def _with_radii(family: Family, points: Points, known: Mapping[str, float]) -> Start:
    """The start by measured radii: the load is linear in s, sqrt(w s), P0; the displacement in sqrt(w/s), delta0."""
    (D, T, H, V), _, _ = family.at(np.clip(np.log(points.values["a"]), family.low - 0.5, family.high + 0.5))
    s, w, P0, delta0 = (known.get(name) for name in ("modulus", "w", "P0", "delta0"))
    compliance, one, gaps, off = known.get("compliance") or 0.0, np.ones_like(D), [], np.zeros_like(D)
    if (load := points.values.get("P")) is not None:
        fitted, pull, P0 = _linear_fit([H, -V, one], load, [None, None, P0])
        s = max(fitted, 1e-3 * float(np.ptp(load) / np.ptp(H))) if s is None else s
        w, off = max(pull, 0.0) ** 2 / s if w is None else w, load - P0
        gaps.append((off - s * H + np.sqrt(w * s) * V) / np.ptp(load))
    s = 1.0 if s is None else s
    if (delta := points.values.get("delta")) is not None:
        own = delta - D - compliance * off
        v, delta0 = _linear_fit([-T, one], own, [None if w is None else math.sqrt(w / s), delta0])
        w = max(v, 0.0) ** 2 * s if w is None else w
        gaps.append((own - delta0 + np.sqrt(w / s) * T) / np.ptp(delta))
    assert w is not None
    reach = float(points.values["a"].max())
    return Start(_values(s, w, delta0 or 0.0, P0 or 0.0, compliance), reach, float(np.mean(np.square(gaps))))


def _linear_fit(columns: list[Array], wanted: Array, known: list[float | None]) -> list[float]:
    """Coefficients of the linear least squares by ``columns``, each in units of its size, but for those ``known``."""
    free, coefficients = [value is None for value in known], np.array([value or 0.0 for value in known])
    matrix = np.stack(columns, axis=1)
    size = np.linalg.norm(matrix[:, free], axis=0)
    left = wanted - matrix @ coefficients
    coefficients[free] = np.linalg.lstsq(matrix[:, free] / size, left, rcond=None)[0] / size
    return coefficients.tolist()


# ---------------------------------------------------------------------- cycles
def search(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit to one branch, or to both of a cycle: from that to the approach on.

    InputError where no curve of the body comes near the data, or where they leave the radii of its series.
    """
    if points.edges is None:
        return _of_a_branch(body, points, settings)
    ranges = {name: float(np.ptp(column)) for name, column in points.values.items()}
    settings = replace(settings, noise=scatter(points.values, ranges) | dict(settings.noise))  # in order of recording
    edges = set(points.edges)
    if RECEDING not in edges:
        return _of_a_branch(body, replace(points, edges=None), settings)
    return _there_and_back(body, points, settings) if ADVANCING in edges else _back(body, points, settings)


def _there_and_back(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit to both directions, from that to the approach on."""
    assert points.edges is not None
    forth = replace(points.at(points.edges == ADVANCING), edges=None)
    law = settings.range
    plain = settings.without(RANGES)
    into = _of_a_branch(body, forth, plain.of_the_approach)
    objective = replace(into.objective, parameters=plain.parameters, points=points)
    values = into.objective.values(into.x) | {"a_turn": float(into.distances.a.max())}
    values["w_approach"] = values["w"]
    shifts = np.append(0.0, np.geomspace(math.sqrt(UNSEEN), 1, TUNING.nodes // 8)) ** 2
    natural = objective.body.family.natural_work * values["modulus"]
    tried = [{**values, "w": values["w_approach"] + shift * natural} for shift in shifts]
    values = min(tried, key=lambda values: _assigned(objective, values)[0])
    jkr = _settled(objective, values)
    if law is None:
        return jkr
    values, objective = jkr.objective.values(jkr.x), replace(objective, parameters=settings.parameters)
    tried = list(_ranged(body, values, law.name)) if law.free else [{**values, law.name: float(law.value or 0.0)}]
    tried.sort(key=lambda values: _assigned(objective, values)[0])
    minima = [_settled(objective, values) for values in tried[: TUNING.followed_ranges]]
    return min(minima, key=lambda item: item.cost)


def _back(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit to a way back, whose edge may rest at first: with the turn only where the rows ask for one."""
    minimum = _of_a_branch(body, replace(points, edges=None), settings.without(OF_A_CYCLE))
    objective = replace(minimum.objective, parameters=settings.parameters, points=points)
    variance = minimum.cost / max(len(points) - minimum.objective.free.size, 1)
    order = np.argsort(points.values["P" if "P" in points.columns else "delta"])
    for share in TUNING.shares:
        some = np.sort(order[: round(share * len(points))])
        with contextlib.suppress(JkrError):
            lower = minimise(replace(minimum.objective, points=points.at(some)), minimum.x)
            values = lower.objective.values(lower.x)
            rested = _settled(objective, values | {"a_turn": _turn(objective, values, int(order[-1]))})
            minimum = rested if minimum.cost - rested.cost > TUNING.worth * variance else minimum
    return minimum


def _turn(objective: Objective, values: Mapping[str, float], top: int) -> float:
    """The contact radius [m] at the turn of an edge that rests at the row ``top``: as it was read, or that which its
    load and displacement belong to."""
    read = {name: float(column[top]) for name, column in objective.points.values.items()}
    if "a" in read:
        return read["a"]
    family = objective.body.with_values({name: v for name, v in values.items() if ":" in name}).family
    u = np.linspace(family.low, family.high, TUNING.nodes)
    D, T, H, V = family.at(u)[0]
    P = read["P"] - values["P0"]
    v = (D - read["delta"] + values["delta0"] + values["compliance"] * P) / T
    return float(np.exp(u[np.argmin(np.abs(values["modulus"] * (H - v * V) - P))]))


def _settled(objective: Objective, values: Mapping[str, float]) -> Minimum:
    """The minimum from ``values`` on at which each row lies on the edge that it was fitted with."""
    parameters = objective.parameters
    _, points, x = _assigned(objective, values)
    for _ in range(MOST_SOLVES):
        objective = _without_idle(replace(objective, parameters=parameters, points=points))
        minimum = minimise(objective, x)
        before = points
        _, points, x = _assigned(objective, objective.values(minimum.x))
        if np.all(points.edges == before.edges):
            break
    return minimum


def _assigned(objective: Objective, values: Mapping[str, float]) -> tuple[float, Points, Array]:
    """The cost of these ``values``, the points with each row of the way back at rest, where on the straight line it is
    nearest to G < w and the receding edge is not clearly nearer, else on that, and the unknowns."""
    points, x = objective.points, np.array([p.inner(values[p.name]) for p in objective.parameters])
    assert points.edges is not None
    back = np.flatnonzero(points.edges > ADVANCING)
    each = []
    for edge in (RESTING, RECEDING):
        edges = points.edges.copy()
        edges[back] = edge
        each.append(replace(objective, points=replace(points, edges=edges)).distances(x, rated=False))
    still, (off, moving) = each[0].at(RESTING), (np.sum(distances.residuals**2, axis=0)[back] for distances in each)
    assert isinstance(still.readings.member, RestingMember)
    end = math.sqrt(values["w"] / values["modulus"]) / still.readings.member.unit
    rests = (still.u <= end) & (off < moving + TUNING.nearer)
    edges[back] = np.where(rests, RESTING, RECEDING)
    cost = float(np.sum(each[0].residuals ** 2) - np.sum(off) + np.sum(np.where(rests, off, moving)))
    return cost, replace(points, edges=edges), x


def _without_idle(objective: Objective) -> Objective:
    """The objective with w fixed where no row of a cycle recedes, the turn where none rests."""
    edges = set(objective.points.edges if objective.points.edges is not None else ())
    idle = [name for edge, name in ((RECEDING, "w"), (RESTING, "a_turn")) if edge not in edges]
    return objective.holding(*idle)


# ---------------------------------------------------------------------- bodies and radii
def _of_a_branch(body: FittedBody, points: Points, settings: Settings) -> Minimum:
    """The best fit, on the body solved anew to other radii where the data ask for it and it may be.

    InputError where no curve of the body comes near the data, or where they leave the radii of its series.
    """
    body = _among_radii(body, points)
    for _ in range(MOST_SOLVES):
        tried = _all_starts(body, points, settings)
        high = float(body.series.a[-1])
        if body.extensible and tried[0].reach > high * TUNING.room:
            body = body.to_radius(TUNING.room * tried[0].reach)
            continue
        minimum = _best(body, points, settings, tried)
        reach = float(minimum.distances.a.max())
        least, low = _least(minimum), float(body.series.a[0])
        if body.extensible and not TUNING.least_used * high <= reach <= high * TUNING.past_end:
            body = body.to_radius(TUNING.room * reach)
        elif body.extensible and least < low / TUNING.past_end:
            body = body.down_to(max(least / TUNING.room, body.series.a0 * (1 + SAME)))
        else:
            break
    else:
        minimum = _best(body, points, settings, _all_starts(body, points, settings))
    _check_reach(minimum.objective.body, _least(minimum), float(minimum.distances.a.max()))
    return minimum


def _least(minimum: Minimum) -> float:
    """The least contact radius [m] that the series must hold: of the data, but for what is so small that no row tells
    it. A curve of finite range begins at first touch, whatever the series does."""
    a = minimum.distances.a
    return math.inf if minimum.objective.ranged else max(float(a.min()), TUNING.smallest * float(a.max()))


def _among_radii(body: FittedBody, points: Points) -> FittedBody:
    """The body with a series that reaches the measured radii, where most of them lie far outside it.

    InputError where it may not be solved anew: starts would be sought where the series says nothing.
    """
    if "a" not in points.columns:
        return body
    least, middle, most = (float(a) for a in np.quantile(points.values["a"], (0.0, 0.5, 1.0)))
    low, high = (float(a) for a in body.series.a[[0, -1]])
    if low / TUNING.room <= middle <= high * TUNING.room:
        return body
    if body.extensible:
        return body.to_radius(TUNING.room * most)
    _check_reach(body, least, most)
    return body


def _check_reach(body: FittedBody, least: float, reach: float) -> None:
    """Refuse contact radii of the data outside those of the series, but for noise."""
    low, high = (float(a) for a in body.series.a[[0, -1]])
    above = reach > high * TUNING.past_end
    if low / TUNING.past_end <= least and not above:
        return
    end, remedy = (high, "increase [loading] radius") if above else (low, "begin at smaller radii")
    raise InputError(
        f"the data reach contact radii of {show(least, 'length')} to {show(reach, 'length')}, the series ends at "
        f"{show(end, 'length')}: {remedy}, or fit with the case file; or units or signs are wrong"
    )


def _all_starts(body: FittedBody, points: Points, settings: Settings) -> list[Start]:
    """Starts on every body that is tried, with the values of its own parameters, best first."""
    known = {p.name: p.value for p in settings.parameters if not (p.of_body or p.free) and p.value is not None}
    tried = []
    reason: JkrError | None = None
    for own in _bodies(body, settings):
        try:
            near = starts(body.with_values(own).family, points, known, body.extensible)
            tried += [replace(start, values={**start.values, **own}) for start in near]
        except JkrError as error:
            reason = error
    if not tried:
        assert reason is not None
        raise reason
    tried.sort(key=lambda start: start.cost)
    law = settings.range
    if law is None or not law.free:
        return tried
    return [replace(tried[0], values=values) for values in _ranged(body, tried[0].values, law.name)]


def _ranged(body: FittedBody, values: Mapping[str, float], name: str) -> Iterator[dict[str, float]]:
    """These values with ranges (or tensions, as ``name`` says) from those of a rigid sphere to those of JKR."""
    s = values["modulus"]
    w = max(values["w"], NOTICEABLE * body.family.natural_work * s)
    for part in TUNING.ranges:
        length = part * body.family.neck(s, w)
        yield {**values, "w": w, name: length if name == "range" else w / length}


def _bodies(body: FittedBody, settings: Settings) -> Iterator[dict[str, float]]:
    """Values of the body's own parameters to begin with: fixed ones, and around the nominal values of free ones."""
    own = [p for p in settings.parameters if p.of_body]
    fixed = {p.name: float(p.value) for p in own if not p.free and p.value is not None}
    free = [p for p in own if p.free]
    factors = (TUNING.scanned[len(free)][p.name[0]] if len(free) in TUNING.scanned else (1.0,) for p in free)
    for chosen in itertools.product(*factors):
        values = {p.name: body.nominal(p.name) * factor for p, factor in zip(free, chosen, strict=True)}
        if all(p.low <= values[p.name] <= p.high for p in free) or set(chosen) == {1.0}:
            yield fixed | {p.name: float(np.clip(values[p.name], p.low, p.high)) for p in free}


def _best(body: FittedBody, points: Points, settings: Settings, tried: list[Start]) -> Minimum:
    """The minimum from the nearest start; where it stays far from the data the lowest of those from all starts.

    Starts are those from the data and, if any, the user's. InputError where all stay far.
    """
    unknowns = [_unknowns(settings, start) for start in tried[: TUNING.looked_at]]
    objective = Objective(body, settings.parameters, points, np.ones(len(points.columns)))
    sizes = _sizes(objective.readings(unknowns[0], rated=False), points)
    scales = scatter(points.values, sizes) | dict(settings.noise)
    objective = replace(objective, scales=np.array([scales[name] for name in points.columns]))
    if any(p.value is not None for p in settings.free):
        nearest = zip(settings.parameters, unknowns[0], strict=True)
        unknowns.append(np.array([x if p.value is None else p.inner(p.value) for p, x in nearest]))
    far = max(scales[name] / sizes[name] for name in points.columns)
    minima: list[Minimum] = []
    failed: JkrError | None = None
    for x in _by_cost(objective, unknowns)[: TUNING.followed_ranges if objective.ranged else TUNING.followed]:
        try:
            minima.append(minimise(objective, x))
        except JkrError as error:
            if not objective.ranged:
                raise
            failed = error
            continue
        if not objective.ranged and _is_good(minima[-1], far):  # good without its range is not yet the best with it
            break
    if failed is not None and not minima:
        raise failed
    minimum = min(minima, key=lambda item: item.cost)
    distance = far * robust_scale(minimum.distances.residuals)
    if distance > TUNING.alien:
        raise InputError(
            f"no curve of this body comes within {distance:.2g} of the data's size: "
            "check units, signs, zero points, the indenter and the layers"
        )
    return minimum


def _is_good(minimum: Minimum, far: float) -> bool:
    """Whether the residuals are those of the noise, where that is known, or next to nothing; else others are tried.

    ``far``: the scales in sizes of the curve, 1 where the record did not show the noise.
    """
    distance = robust_scale(minimum.distances.residuals)
    return distance * far < TUNING.near or (distance < TUNING.noise and far < TUNING.far)


def _by_cost(objective: Objective, unknowns: list[Array]) -> list[Array]:
    """Starts sorted by their cost; where layers or a range vary, after a fit of the other parameters alone."""
    own = [p.name for p in objective.parameters if (p.of_body or p.name in RANGES) and p.free]
    others = objective.holding(*own)
    if not own or others.free.size == 0:
        return sorted(unknowns, key=lambda x: _cost(objective, x))
    minima = [minimum for x in unknowns if (minimum := _if_any(others, x)) is not None]
    for _ in range(TUNING.halvings if objective.ranged and minima else 0):
        minima += _between(others, minima, next(i for i, p in enumerate(objective.parameters) if p.name in RANGES))
    return [minima[i].x for i in np.argsort([minimum.cost for minimum in minima])] if minima else unknowns


def _between(objective: Objective, minima: Sequence[Minimum], place: int) -> list[Minimum]:
    """The least costs half way from the lowest of the ``minima`` to its neighbours on both sides, in the logarithm of
    the range, which the ``objective`` holds, at the ``place`` of the unknowns."""
    ordered = sorted(minima, key=lambda minimum: float(minimum.x[place]))
    best = min(range(len(ordered)), key=lambda i: ordered[i].cost)
    tried = []
    for other in (*ordered[max(best - 1, 0) : best], *ordered[best + 1 : best + 2]):
        tried.append(x := ordered[best].x.copy())
        x[place] = (x[place] + other.x[place]) / 2
    return [minimum for x in tried if (minimum := _if_any(objective, x)) is not None]


def _cost(objective: Objective, x: Array) -> float:
    """The sum of squares; infinite where a range takes the surfaces beyond the body."""
    try:
        return float(np.sum(objective.distances(x, rated=False).residuals ** 2))
    except JkrError:
        if not objective.ranged:
            raise
        return math.inf


def _unknowns(settings: Settings, start: Start) -> Array:
    values = (start.values[p.name] if p.free or p.value is None else p.value for p in settings.parameters)
    return np.array([p.inner(value) for p, value in zip(settings.parameters, values, strict=True)])


def _sizes(readings: Readings, points: Points) -> dict[str, float]:
    """The size of a start's curve on each axis: its pull-off, or a part of the data's range where that is larger."""
    offsets = {"delta": readings.values["delta0"], "P": readings.values["P0"]}
    curve = readings.along(arc(readings))[0]
    ranges = {name: float(np.ptp(points.values[name])) for name in points.columns}
    return {  # a radius has no zero of its own: its size is its range
        name: max(offsets[name] - float(np.min(row)), TUNING.least_size * ranges[name])
        if name in offsets
        else ranges[name]
        for name, row in zip(points.columns, curve, strict=True)
    }

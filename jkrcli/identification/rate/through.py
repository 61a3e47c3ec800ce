"""A law through works of adhesion at measured speeds of the edge: what `work` shows, and where a fit begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...adhesion import RATE_LAWS, TWO_SIDED_90, RateLaw, rate_parameters
from ...base import Array, Ranged, Unknown
from ..fit import covariance, larger, robust_scale, t_quantile
from ..least_squares import Least, LeastSquares, State
from ..parameters import Unknowns, parameters_of
from ..work import WorkAlong


@dataclass(frozen=True)
class ThroughTuning:
    """When a law is put through points, and how."""

    least: int = 12  # choice: points
    decade: float = 10.0  # choice: ratio of the speeds below which the points do not separate n and v0
    exponents: tuple[float, ...] = (0.25, 0.5, 1.0)  # choice: starts of n
    laws: tuple[float, float] = (0.1, 3.0)  # choice: exponents that are sought; measured ones are 0.1 to 1
    reach: float = 40.0  # tuned on work along a record, by `make constants`: guard, how far logs move
    # tuned on work along a record, by `make constants`: relative half-width of a speed, beyond which its point says
    # nothing about a law
    sure: float = 0.3
    # tuned on work along a record, by `make constants`: of weights by the errors of the speeds, which ask for the law
    rounds: int = 3
    blocks: int = 8  # choice: of neighbouring points that are left out in turn
    even: float = 0.01  # choice: guard, least weight of a point's error over the median
    # tuned on work along a record, by `make constants`: standard deviations beyond which a point pulls less, as
    # outliers are usual
    turn: float = 1.5


TUNING = ThroughTuning()
ENDS = {"n": TUNING.laws}


@dataclass(frozen=True, eq=False)
class LawThrough:
    """A ``law`` with its ``w0`` [J/m^2] through points of w over speed; ``names`` of what is free of them, and the
    covariance of their logs (None where the points do not separate them); ``speeds``: the range [m/s]; ``dof``: degrees
    of freedom."""

    law: RateLaw
    w0: float
    names: tuple[str, ...]
    inner: Array | None
    speeds: tuple[float, float]
    dof: int

    @property
    def values(self) -> dict[str, float]:
        """w0 and the law's parameters, SI."""
        return {name: self.w0 if name == "w0" else getattr(self.law, name) for name in self.names}

    @property
    def errors(self) -> dict[str, float | None]:
        """Relative standard errors of the same."""
        sigma = [None] * len(self.names) if self.inner is None else np.sqrt(np.diag(self.inner)).tolist()
        return dict(zip(self.names, sigma, strict=True))

    @property
    def narrow(self) -> bool:
        """Whether the speeds span less than the decade that separates n and v0, or n ends on a bound."""
        ends = "n" in self.values and not TUNING.laws[0] * 1.01 < self.values["n"] < TUNING.laws[1] * 0.99
        return ends or self.speeds[1] < TUNING.decade * self.speeds[0]

    def band(self, v: Array, level: float = 0.9) -> tuple[Array, Array, Array]:
        """w [J/m^2] at the speeds ``v`` [m/s], and the ends of its confidence band."""
        w = self.law.work(self.w0, v)
        if self.inner is None:
            return w, w, w
        rates = log_rates(self.law, self.w0, v)[[name in self.names for name in ("w0", *vars(self.law))]]
        variance = np.maximum(np.einsum("pn,pq,qn->n", rates, self.inner, rates), 0.0)  # of exact points: rounding
        spread = t_quantile(level, self.dof) * np.sqrt(variance)
        return w, w * np.exp(-spread), w * np.exp(spread)


def law_ranges(name: str) -> dict[str, Ranged]:
    """The ranges of w0 and of the parameters of the law called ``name``."""
    return {"w0": Ranged("work", above=0)} | rate_parameters(name)


def law_of(name: str, values: Mapping[str, float]) -> tuple[RateLaw, float]:
    """The law called ``name`` and w0 by the ``values`` of its parameters and w0, SI."""
    law: RateLaw = RATE_LAWS[name](**{key: values[key] for key in rate_parameters(name)})
    return law, values["w0"]


def log_rates(law: RateLaw, w0: float, v: Array) -> Array:
    """Derivatives of log w at the speeds ``v`` by the logs of (w0, parameters), shape (parameters, n)."""
    kind, values, step = type(law), vars(law), 1e-6
    rates = [np.log(law.work(w0 * (1 + step), v) / law.work(w0 * (1 - step), v))]
    for name in values:
        high, low = (kind(**(values | {name: values[name] * (1 + sign * step)})) for sign in (1, -1))
        rates.append(np.log(high.work(w0, v) / low.work(w0, v)))
    return np.stack(rates) / (2 * step)


def law_through(name: str, v: Array, w: Array, together: int = 1, v_err: Array | None = None) -> LawThrough | Unknown:
    """The law called ``name`` nearest to works ``w`` [J/m^2] at speeds ``v`` > 0 [m/s], by their logs, robustly.

    ``together``: how many neighbouring points share their noise; ``v_err``: half-widths of the speeds [m/s]. Unknown
    where there are too few points.
    """
    rows = (v > 0) & (w > 0)
    if v_err is not None:
        rows &= v_err < TUNING.sure * v
    v, w = v[rows], w[rows]
    if v.size < TUNING.least * max(1, together // 4):
        return Unknown(f"{v.size} points with a receding edge are too few for a law")
    ranges = law_ranges(name)
    logs = Unknowns(parameters_of(ranges, ranges, {}, ENDS))
    starts, sigma = _starts(logs, v, w), np.ones(v.size)
    for _ in range(1 if v_err is None else TUNING.rounds):
        best = min((_nearest(name, logs, v, w, sigma, start) for start in starts), key=lambda least: least.cost)
        law, w0 = law_of(name, logs.values(best.x))
        residuals, starts = np.log(law.work(w0, v) / w), [best.x]
        if v_err is not None:
            sigma = _uneven(law, w0, v, v_err[rows], residuals)
    dof = max(v.size // together - best.x.size, 1)
    factor = robust_scale(residuals / sigma) ** 2 * together
    ends = np.quantile(v, (0.05, 0.95))
    inner = covariance((log_rates(law, w0, v) / sigma).T, factor)
    if v_err is not None:
        inner = larger(inner, _of_blocks(name, logs, v, w, sigma, best.x))
    return LawThrough(law, w0, logs.names, inner, (float(ends[0]), float(ends[1])), dof)


def _uneven(law: RateLaw, w0: float, v: Array, v_err: Array, residuals: Array) -> Array:
    """How uneven the points are: standard deviations of log w by the half-widths of the speeds and by the scatter
    of the half of the points whose speeds are surest, over their median."""
    step = 1e-4
    by_v = np.log(law.work(w0, v * (1 + step)) / law.work(w0, v * (1 - step))) / (2 * step)
    known = by_v * v_err / (TWO_SIDED_90 * v)
    surest = known <= np.median(known)
    sigma = np.hypot(known, robust_scale(residuals[surest]))
    return np.ones_like(v) if not (middle := float(np.median(sigma))) > 0 else np.maximum(sigma / middle, TUNING.even)


def _of_blocks(name: str, logs: Unknowns, v: Array, w: Array, sigma: Array, x: Array) -> Array:
    """Covariance of the logs of (w0, parameters) by leaving out blocks of neighbouring points in turn: what smoothing
    has done to the speeds of neighbours is no noise that averages out (delete-block jackknife, Kuensch, Ann. Statist.
    17 (1989) 1217)."""
    blocks = np.array_split(np.arange(v.size), TUNING.blocks)
    rest = [np.setdiff1d(np.arange(v.size), block) for block in blocks]
    estimates = np.array([_nearest(name, logs, v[rows], w[rows], sigma[rows], x).x for rows in rest])
    apart = estimates - estimates.mean(axis=0)
    return (TUNING.blocks - 1) / TUNING.blocks * apart.T @ apart


def receding(along: Sequence[WorkAlong]) -> tuple[Array, Array, int, Array]:
    """Speeds [m/s] > 0 of receding edges that stand out of their error and w [J/m^2] there, of all curves that were
    timed; rows of their window, and half-widths of the speeds."""
    parts, window = [np.empty((3, 0))], 1
    for item in along:
        if item.timed is not None and item.speed is not None and item.speed_err is not None:
            rows = item.timed & (item.speed < -item.speed_err)
            parts.append(np.stack([-item.speed, item.w, item.speed_err])[:, rows])
            window = max(window, item.window)
    speeds, works, errors = np.concatenate(parts, axis=1)
    return speeds, works, window, errors


def law_along(along: Sequence[WorkAlong]) -> LawThrough | Unknown | None:
    """The power law through all receding edges ``along`` records; None where no time was recorded."""
    if all(item.timed is None for item in along):
        return None
    return law_through("power", *receding(along))


def _starts(logs: Unknowns, v: Array, w: Array) -> list[Array]:
    """Unknowns to begin with: half of w at the middle speed is due to it."""
    low, middle, speed = float(np.quantile(w, 0.02)), float(np.median(w)), float(np.median(v))
    known = dict.fromkeys(logs.names, 1.0) | {"w0": min(low, middle / 2), "v0": speed, "b": middle / 2}
    return [logs.at(known | {"n": exponent}) for exponent in TUNING.exponents]


def _nearest(name: str, logs: Unknowns, v: Array, w: Array, sigma: Array, start: Array) -> Least:
    def residuals(x: Array) -> Array:
        law, w0 = law_of(name, logs.values(x))
        return np.log(law.work(w0, v) / w) / sigma

    def state(x: Array) -> State:
        return State(residuals(x), lambda: (log_rates(*law_of(name, logs.values(x)), v) / sigma).T)

    scale = max(float(np.median(np.abs(residuals(start)))), 1e-3)
    width, bounds = scale * TUNING.turn / 10, logs.bounds(start, TUNING.reach)
    return LeastSquares(state, bounds, loss="soft_l1", width=width).least(start)

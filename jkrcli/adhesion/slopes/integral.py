"""Slopes by integrating instead of differentiating: S' and d(delta_H)/da fitted through their integrals.

The data meet the model of ``model.py`` in the logs of delta_H and P_H, weighted by their own errors; an error of the
radius counts through the slopes of both columns and correlates them (effective variance). The roughness of
log S' and log d(delta_H)/da over log a is penalised, each by a weight found from the data (``penalised.py``).
Nothing is differentiated, S' > 0 holds by construction, and the fit's covariance gives the band. Residuals that
follow their neighbours show what the splines cannot bend to: they get more knots, and what remains widens the band.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from ...base.arrays import Array
from ...base.errors import InputError, Refusal
from ...series import RawSeries, Series
from .events import has_plateaus, touch_events
from .model import LogSplineModel, OnGrid, interpolate
from .penalised import TUNING as PENALTIES
from .penalised import PenalisedFit, minimise
from .result import TWO_SIDED_90, Slopes, covariance_from_errors, shift_error
from .scatter import correlation_length, estimate, floored, whitener

UNSETTLED = "the fit did not settle: a, delta and P contradict each other somewhere; look for points out of place"


@dataclass(frozen=True)
class IntegralTuning:
    """The rounds of the rule "integral"."""

    fewest: int = 5  # points; theory: two power laws have four parameters
    intervals: int = 24  # of the splines, twice as many if need be; tuned on noisy series, by `make tuning`
    free_scatter: int = 20  # points that tell the errors of a, delta, P apart; tuned on the same, by `make tuning`
    most_bins: int = 400  # of points; choice: more points are fitted no better
    stiff: float = 1e-2  # penalty of the first fit over what the data weigh; tuned on the same, by `make tuning`
    share: float = 1e-2  # least of the variances of a, delta, P in later rounds; tuned on the same, by `make tuning`
    floor: float = 1e-7  # theory: of the scatter, accuracy of the model's own integrals and linear algebra


TUNING = IntegralTuning()


@dataclass(frozen=True, eq=False)
class _Data:
    """Scaled logs of the data, in any order; ``lever``: dx/dlog(a) = a/(a - a0), (n,), which grows without bound at the
    edge of a flat end; ``given``: relative variances of (a, delta, P), (3, n), or None."""

    x: Array
    lever: Array
    log_delta: Array
    log_P: Array
    given: Array | None


def integral(series: Series) -> Slopes:
    """S, S', and the smoothed delta_H and P_H, at the radii of ``series``; refused below 5 points."""
    return _slopes(series.a, series.delta, series.P, series.errors, series.a0, series.S0, series.a)


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, errors: Mapping[str, Array] | None = None
) -> tuple[Series, Slopes]:
    """A series and its slopes from increments, also where they are too noisy to be a series (columns out of order).

    Where radii repeat, as node-based ones do, the moments at which the next node is reached are found first
    (``events.py``). The series holds the fitted columns at the data's radii, sorted and without repeats.
    """
    if errors is None and has_plateaus(raw):
        raw, errors = touch_events(raw)
    a = np.unique(raw.a[raw.a > a0])
    found = _slopes(raw.a, raw.delta, raw.P, errors or {}, a0, S0, a)
    assert found.delta is not None
    assert found.P is not None
    return Series(a, found.delta, found.P, a0=a0, S0=S0), found


def _slopes(
    a: Array, delta: Array, P: Array, errors: Mapping[str, Array], a0: float, S0: float | None, wanted: Array
) -> Slopes:
    """The slopes at the radii ``wanted`` (m,), from a fit of the columns (n,)."""
    data = _prepare(a, delta, P, errors, a0)
    y_scale, delta_scale, P_scale = float(np.max(a) - a0), float(np.max(delta)), float(np.max(P))
    S_scale = P_scale / delta_scale
    model, fit = _fine_enough(data, None if S0 is None else S0 / S_scale)
    x = np.log((wanted - a0) / y_scale)
    scales = np.array([delta_scale, P_scale, S_scale, S_scale / y_scale, delta_scale / y_scale, S_scale / y_scale**2])
    values, joint = _evaluate(model, fit, x, scales)
    delta_H, P_H, S, dS = values
    if errors:
        order = np.argsort(a)
        there = {name: np.interp(wanted, a[order], np.asarray(error)[order]) for name, error in errors.items()}
        given = covariance_from_errors(Series(wanted, delta_H, P_H, errors=there, a0=a0, S0=S0), S, dS)
        assert given is not None
        joint[:, :4, :4] += max(0.0, 1 - fit.phi) * given  # what the scatter does not show is shared by all points
    # an error of a radius is in both columns' residuals: only half of them are independent
    quantile = float(stdtrit(max((fit.residuals.size - fit.spent) / 2, 1.0), 0.95))
    covariance = joint[:, :4, :4]
    return Slopes(
        S,
        dS,
        "integral",
        shift_error(dS, covariance, quantile),
        float(fit.lambdas[1]),
        flags=() if fit.settled else (UNSETTLED,),
        delta=delta_H,
        P=P_H,
        covariance=covariance,
        joint=joint,
        quantile=quantile,
    )


def _evaluate(model: LogSplineModel, fit: PenalisedFit, x: Array, scales: Array) -> tuple[Array, Array]:
    """delta_H, P_H, S, S' in SI at the log radii ``x``, shape (4, m), and the covariance, (m, 6, 6), of these,
    d(delta_H)/da and S'', from that of the coefficients."""
    basis, y = model.design(x), np.exp(x)[:, None]
    columns = model.columns(fit.c, model.interpolation(x), basis)
    values = np.exp(np.stack([columns.log_delta, columns.log_P, columns.log_S, columns.log_dS]))
    jacobian = np.zeros((6, *columns.jacobian.shape[1:]))
    jacobian[:4] = columns.jacobian * values[:, :, None]
    jacobian[4, :, model.v] = np.exp(basis @ fit.c[model.v])[:, None] * basis
    bend = model.slope_design(x)  # S'' = S' u'(x)/y
    jacobian[5, :, model.u] = values[3][:, None] / y * ((bend @ fit.c[model.u])[:, None] * basis + bend)
    jacobian *= scales[:, None, None]
    joint = np.einsum("imp,pq,jmq->mij", jacobian, fit.phi * fit.V, jacobian, optimize=True)
    return values * scales[:4, None], joint


def _prepare(a: Array, delta: Array, P: Array, errors: Mapping[str, Array], a0: float) -> _Data:
    a, delta, P = (np.asarray(values, dtype=float) for values in (a, delta, P))
    usable = (a > a0) & (delta > 0) & (P > 0)
    different = np.unique(a[usable]).size
    if different < TUNING.fewest:
        raise Refusal(
            f"slopes 'integral': needs at least {TUNING.fewest} points with different contact radii, delta > 0 and "
            f"P > 0, got {different}; give more increments, or refine the mesh where radii repeat"
        )
    if not usable.all():
        i = int(np.argmin(usable))
        raise InputError(
            f"slopes 'integral': point {i + 1} has a = {a[i]:g} m, delta = {delta[i]:g} m, P = {P[i]:g} N; all must be "
            "positive: drop it"
        )
    given = None
    if any(np.any(np.asarray(errors[name]) > 0) for name in errors if name in ("a", "delta", "P")):
        columns = (("a", a), ("delta", delta), ("P", P))
        given = np.stack([(np.asarray(errors.get(name, 0 * v)) / v / TWO_SIDED_90) ** 2 for name, v in columns])
    y = a - a0
    return _Data(np.log(y / np.max(y)), a / y, np.log(delta / np.max(delta)), np.log(P / np.max(P)), given)


class _Task:
    """The data as a least-squares problem: residuals of log delta and log P, whitened, over bins of points."""

    def __init__(self, model: LogSplineModel, data: _Data):
        self.model, self.bins = model, _Bins(data.x)
        self.blocks = (model.rough_v, model.rough_u)
        self.at, self.basis = model.interpolation(self.bins.x), model.design(self.bins.x)
        self.everywhere = model.interpolation(self.bins.sorted_x)
        self.measured = np.stack([data.log_delta, data.log_P])[:, self.bins.order]
        self.lever = data.lever[self.bins.order]

    def difference(self, grid: OnGrid) -> Array:
        """Model minus data at every point, shape (2, n)."""
        (log_delta, _), (log_P, _), _ = grid
        return np.stack([interpolate(self.everywhere, *pair) for pair in (log_delta, log_P)]) - self.measured

    def minimise(self, start: Array, variances: Array, lambdas: Array, floor: float, freeze: int) -> PenalisedFit:
        """The fit with given relative variances of (a, delta, P), (3, n), the radius' slopes taken at ``start``."""
        columns = self.model.columns(start, self.at, self.basis)
        lever = self.bins.mean(self.lever)
        k, m = columns.rate_delta * lever, columns.rate_P * lever
        whiten = whitener(self.bins.mean(variances), k, m) * np.sqrt(self.bins.counts)

        def residuals(c: Array) -> tuple[Array, Array]:
            grid = self.model.on_grid(c)
            white = np.einsum("ijn,jn->in", whiten, self.bins.mean(self.difference(grid)))
            jacobian = self.model.columns(c, self.at, self.basis, grid).jacobian[:2]
            return white.ravel(), np.einsum("ijn,jnp->inp", whiten, jacobian).reshape(-1, self.model.parameters)

        return minimise(residuals, start, self.blocks, floor, lambdas, freeze)

    def scatter(self, fit: PenalisedFit) -> Array:
        """Relative variances of (a, delta, P), shape (3, n), as the residuals of ``fit`` show them."""
        grid = self.model.on_grid(fit.c)
        columns = self.model.columns(fit.c, self.at, self.basis, grid)
        k, m = (self.lever * self.bins.spread(rate) for rate in (columns.rate_delta, columns.rate_P))
        return estimate(self.bins.sorted_x, self.difference(grid), k, m, fit.spent, TUNING.floor**2)


def _fine_enough(data: _Data, S0: float | None) -> tuple[LogSplineModel, PenalisedFit]:
    """The fit with the knots that the data need; residuals still correlated count as that many fewer data."""
    for intervals in (TUNING.intervals, 2 * TUNING.intervals):
        model = LogSplineModel(data.x, intervals, S0)
        fit = _fit(_Task(model, data), data)
        explained = fit.floored or (data.given is not None and fit.phi <= 1)  # by round-off, or by the stated errors
        length = 1.0 if explained else correlation_length(fit.residuals.reshape(2, -1))
        if length == 1:
            break
    return model, replace(fit, V=length * fit.V)


def _fit(task: _Task, data: _Data) -> PenalisedFit:
    """The fit with penalties found from the data, in rounds, each with the scatter that the one before has shown."""
    stiff = np.full(len(task.blocks), TUNING.stiff)
    variances = np.ones((3, data.x.size)) if data.given is None else data.given[:, task.bins.order]
    given = variances
    best: PenalisedFit | None = None
    for share in (1.0, TUNING.share, TUNING.share):
        variances = floored(variances, share, TUNING.floor**2)
        floor = TUNING.floor**2 / float(np.mean(variances))
        # a stiff fit first: far from the solution a linearised one takes all for signal
        start = best or task.minimise(_start(task.model, data), variances, stiff, floor, 0)
        found = task.minimise(start.c, variances, start.lambdas, floor, PENALTIES.freeze)
        if best is not None and not found.settled:
            break  # weights too uneven to go on: the last fit stands
        if found.settled:
            best = found
        if data.given is None and (data.x.size < TUNING.free_scatter or found.phi <= floor):
            break
        variances = given if data.given is not None else task.scatter(best or start)
    return best or found


class _Bins:
    """Points in the order of x, many of them put together in bins of equal number; few points stay alone."""

    def __init__(self, x: Array):
        self.order = np.argsort(x, kind="stable")
        self.sorted_x = x[self.order]
        self.starts = np.linspace(0, x.size, min(x.size, TUNING.most_bins), endpoint=False).astype(int)
        self.counts = np.diff(np.append(self.starts, x.size))
        self.x = self.mean(self.sorted_x)

    def mean(self, values: Array) -> Array:
        """Means over the bins, of values (..., n) in the order of x."""
        return np.add.reduceat(values, self.starts, axis=-1) / self.counts

    def spread(self, values: Array) -> Array:
        """Values of the bins, (bins,), for every point, (n,)."""
        return np.repeat(values, self.counts)


def _start(model: LogSplineModel, data: _Data) -> Array:
    """Coefficients of power laws through the logs of the data; the large radii count most, they are surest."""
    k, log_k = np.polyfit(data.x, data.log_delta, 1, w=np.exp(data.x))
    m, log_m = np.polyfit(data.x, data.log_P, 1, w=np.exp(data.x))
    k = max(float(k), 0.2)
    excess = max(float(m) - k, 0.2)
    log_S = float(np.log(1 + excess / k)) + log_m - log_k  # S = P' / delta'
    half = float(np.log(0.5)) if model.S0 is None or model.S0 > 0 else 0.0
    v = (float(np.log(k) + log_k), k - 1)
    u = (float(np.log(excess)) + log_S + half, excess - 1)
    return model.straight(v, u, log_S + half)

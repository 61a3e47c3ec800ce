"""Slopes by integrating instead of differentiating: S' and d(delta_H)/da fitted through their integrals.

The data meet the model of ``model.py`` in the logs of delta_H and P_H, weighted by their own errors; an error of the
radius counts through the slopes of both columns and correlates them (effective variance). The roughness of
log S' and log d(delta_H)/da over log a is penalised, each by a weight found from the data (``penalised.py``).
Nothing is differentiated, S' > 0 holds by construction, and the fit's covariance gives the band.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ..errors import InputError, Refusal
from ..series import Array, RawSeries, Series
from .events import has_plateaus, touch_events
from .model import Grid, LogSplineModel, interpolate
from .penalised import Fit, minimise
from .result import TWO_SIDED_90, Slopes, covariance_from_errors, shift_error
from .scatter import estimate, floored, whitener

MIN_POINTS = 5
MAX_INTERVALS = 24
FREE_SCATTER_FROM = 20  # points, from which the errors of a, delta and P are told apart
MAX_BINS = 400
UNSETTLED = "the fit did not settle: a, delta and P contradict each other somewhere; look for points out of place"
STIFF = 1e-2  # penalty of the first fit, in units of what the data weigh
RELATIVE_FLOOR = 1e-7  # of the scatter: accuracy of the model's own integrals and linear algebra
SMALLEST_SHARES = (1.0, 1e-2, 1e-2)  # of the variances of a, delta and P, round by round


@dataclass(frozen=True, eq=False)
class _Data:
    """Scaled logs of the data, in any order; ``given``: relative variances of (a, delta, P), (3, n), or None."""

    x: Array
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
    y_scale, delta_scale, P_scale = float(np.max(a) - a0), float(np.max(delta)), float(np.max(P))
    S_scale = P_scale / delta_scale
    data = _prepare(a, delta, P, errors, a0)
    model = LogSplineModel(data.x, min(MAX_INTERVALS, max(3, data.x.size // 2)), None if S0 is None else S0 / S_scale)
    fit = _fit(model, data)
    x = np.log((wanted - a0) / y_scale)
    columns = model.columns(fit.c, model.interpolation(x), model.design(x))
    freedom = max(fit.residuals.size - fit.spent, 1.0)
    values = np.stack([columns.log_delta, columns.log_P, columns.log_S, columns.log_dS])
    values = np.exp(values) * np.array([[delta_scale], [P_scale], [S_scale], [S_scale / y_scale]])
    covariance = np.einsum("imp,pq,jmq->mij", columns.jacobian, fit.phi * fit.V, columns.jacobian, optimize=True)
    covariance *= values.T[:, :, None] * values.T[:, None, :]
    delta_H, P_H, S, dS = values
    if errors:
        order = np.argsort(a)
        there = {name: np.interp(wanted, a[order], np.asarray(values)[order]) for name, values in errors.items()}
        given = covariance_from_errors(Series(wanted, delta_H, P_H, errors=there, a0=a0, S0=S0), S, dS)
        assert given is not None
        covariance += max(0.0, 1 - fit.phi) * given  # what the scatter does not show is shared by all points
    quantile = float(stdtrit(freedom, 0.95))
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
        quantile=quantile,
    )


def _prepare(a: Array, delta: Array, P: Array, errors: Mapping[str, Array], a0: float) -> _Data:
    a, delta, P = (np.asarray(values, dtype=float) for values in (a, delta, P))
    usable = (a > a0) & (delta > 0) & (P > 0)
    different = np.unique(a[usable]).size
    if different < MIN_POINTS:
        raise Refusal(
            f"slopes 'integral': needs at least {MIN_POINTS} points with different contact radii, delta > 0 and P > 0, "
            f"got {different}; give more increments, or refine the mesh where radii repeat"
        )
    if not usable.all():
        i = int(np.argmin(usable))
        raise InputError(
            f"slopes 'integral': point {i + 1} has a = {a[i]:g} m, delta = {delta[i]:g} m, P = {P[i]:g} N; all must be "
            "positive: drop it"
        )
    given = None
    if any(np.any(np.asarray(errors[name]) > 0) for name in errors if name in ("a", "delta", "P")):
        columns = (("a", a - a0), ("delta", delta), ("P", P))
        given = np.stack([(np.asarray(errors.get(name, 0 * v)) / v / TWO_SIDED_90) ** 2 for name, v in columns])
    return _Data(np.log((a - a0) / np.max(a - a0)), np.log(delta / np.max(delta)), np.log(P / np.max(P)), given)


def _fit(model: LogSplineModel, data: _Data) -> Fit:
    """Alternate the fit and the estimate of the data's scatter."""
    bins = _Bins(data.x)
    at, basis, everywhere = model.interpolation(bins.x), model.design(bins.x), model.interpolation(bins.sorted_x)
    measured = np.stack([data.log_delta, data.log_P])[:, bins.order]

    def difference(grid: Grid) -> Array:
        (log_delta, _), (log_P, _), _ = grid
        return np.stack([interpolate(everywhere, *log_delta), interpolate(everywhere, *log_P)]) - measured

    start, blocks = _start(model, data), (model.rough_v, model.rough_u)
    variances = np.ones((3, data.x.size)) if data.given is None else data.given[:, bins.order]
    fit: Fit | None = None
    for share in (None, *SMALLEST_SHARES):
        columns = model.columns(start, at, basis)
        variances = floored(variances, share or 1.0, RELATIVE_FLOOR**2)
        whiten = whitener(bins.mean(variances), columns.rate_delta, columns.rate_P) * np.sqrt(bins.counts)

        def residuals(c: Array, whiten: Array = whiten) -> tuple[Array, Array]:
            grid = model.on_grid(c)
            white = np.einsum("ijn,jn->in", whiten, bins.mean(difference(grid)))
            jacobian = np.einsum("ijn,jnp->inp", whiten, model.columns(c, at, basis, grid).jacobian[:2])
            return white.ravel(), jacobian.reshape(-1, model.parameters)

        floor = RELATIVE_FLOOR**2 / float(np.mean(variances))
        if share is None:  # a stiff fit first: far from the solution a linearised one takes all for signal
            start = minimise(residuals, start, blocks, floor, np.full(2, STIFF), freeze=0).c
            continue
        found = minimise(residuals, start, blocks, floor, np.full(2, STIFF) if fit is None else fit.lambdas)
        if found.settled:
            fit, start = found, found.c
        elif fit is not None:
            break  # weights too uneven to go on: the last fit stands
        if data.given is not None:
            variances = data.given[:, bins.order]
            continue
        if data.x.size < FREE_SCATTER_FROM or found.phi <= floor:
            break
        grid = model.on_grid(start)
        columns = model.columns(start, at, basis, grid)
        k, m = bins.spread(columns.rate_delta), bins.spread(columns.rate_P)
        variances = estimate(bins.sorted_x, difference(grid), k, m, found.spent, RELATIVE_FLOOR**2)
    return fit or found


class _Bins:
    """Points in the order of x, many of them put together in bins of equal number; few points stay alone."""

    def __init__(self, x: Array):
        self.order = np.argsort(x, kind="stable")
        self.sorted_x = x[self.order]
        self.starts = np.linspace(0, x.size, min(x.size, MAX_BINS), endpoint=False).astype(int)
        self.counts = np.diff(np.append(self.starts, x.size))
        self.x = self.mean(self.sorted_x)

    def mean(self, values: Array) -> Array:
        """Means over the bins, of values (..., n) in the order of x."""
        return np.add.reduceat(values, self.starts, axis=-1) / self.counts

    def spread(self, values: Array) -> Array:
        """Values of the bins, (bins,), for every point, (n,)."""
        return np.repeat(values, self.counts)


def _start(model: LogSplineModel, data: _Data) -> Array:
    """Power laws through the logs of the data, by least squares; the large radii count most, they are surest."""
    k, log_k = np.polyfit(data.x, data.log_delta, 1, w=np.exp(data.x))
    m, log_m = np.polyfit(data.x, data.log_P, 1, w=np.exp(data.x))
    k = max(float(k), 0.2)
    excess = max(float(m) - k, 0.2)
    log_S = float(np.log(1 + excess / k)) + log_m - log_k  # S = P' / delta'
    half = float(np.log(0.5)) if model.S0 is None or model.S0 > 0 else 0.0
    v = (float(np.log(k) + log_k), k - 1)
    u = (float(np.log(excess)) + log_S + half, excess - 1)
    return model.straight(v, u, log_S + half)

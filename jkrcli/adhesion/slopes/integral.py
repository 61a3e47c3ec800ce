"""Slopes by integrating instead of differentiating: S' and d(delta_H)/da fitted through their integrals.

The data meet the model of ``model.py`` in the logs of delta_H and P_H, weighted by their own errors; an error of the
radius counts through the slopes of both columns and correlates them (effective variance). The roughness of
log S' and log d(delta_H)/da over log a is penalised, each by a weight found from the data (``penalised.py``).
Nothing is differentiated, S' > 0 holds by construction, and the fit's covariance gives the band. Residuals that
follow their neighbours show what the splines cannot bend to: they get more knots, and what remains widens the band.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import stdtrit

from ...base import SHOWN, TINY, Array, Estimate, InputError, Refusal, Unknown
from ...series import RawSeries, Series
from .events import AS_THEY_ARE, Ahead, node_radii
from .model import LogSplineModel, OnGrid, Shape, interpolate
from .penalised import TUNING as PENALTIES
from .penalised import PenalisedFit, Posterior, likeliest_correlation, minimise, posterior
from .result import TUNING as ERRORS
from .result import TWO_SIDED_90, Slopes, covariance_from_errors, shift_error
from .scatter import correlation_length, estimate, floored, whitener

TOO_FEW = "the correlation of neighbouring rows cannot be estimated from so few points"
UNSETTLED = "the fit did not converge: a, delta and P contradict each other; look for outliers"


@dataclass(frozen=True)
class IntegralTuning:
    """The rounds of the rule "integral"."""

    fewest: int = 5  # points; theory: two power laws have four parameters
    decades: float = 12.0  # of a - a0; choice: the grid grows with them, a series over more has a radius out of place
    intervals: int = 24  # of the splines, twice as many if need be; tuned on noisy series, by `make tuning`
    most_bins: int = 400  # of points; choice: more points are fitted no better
    stiff: float = 1e-2  # penalty of the first fit over what the data weigh; tuned on the same, by `make tuning`
    noise: float = 3e-4  # relative scatter above which it is noise; choice: below, splines do not bend
    tell_correlation: int = 20  # points that tell correlations; tuned on the same, by `make noise-study`
    evidence: float = 3.5  # log of a likelihood ratio from which correlation is reported; theory: by chance once in 250
    recorded: float = 0.9  # rank correlation with x of rows in the order of recording; choice: noise leaves more
    share: float = 1e-2  # least of the variances of a, delta, P in later rounds; tuned on the same, by `make tuning`
    beside: int = 4  # choice: rows on either side that tell a radius far off; three outliers among them do no harm
    far: float = 8.0  # choice: standard deviations; the fit itself finds what is nearer
    # Of the errors of the radii, each the largest of many rows, what is left of them in a smooth fit:
    radii: float = 0.1  # tuned on random bodies, by `make bounds`
    rates: float = 1.5  # and of the rates; tuned on random bodies, by `make bounds`
    # Of the variance of loads, what all columns share where each mesh is one stiffness that is too large:
    of_meshes: float = 0.98  # tuned on series of finite elements in increments, by `make node-study`
    floor: float = 1e-7  # theory: of the scatter, accuracy of the model's own integrals and linear algebra


TUNING = IntegralTuning()


@dataclass(frozen=True, eq=False)
class _Data:
    """Scaled logs of the data, many of them put together in bins of equal number; few stay alone.

    ``order``: that of recording where x follows it, as neighbours in it share their errors, else that of x; of all
    else, ``lever``: dx/dlog(a) = a/(a - a0), (n,), which grows without bound at the edge of a flat end; ``measured``
    (2, n): logs of delta and P; ``stated``: relative variances of (a, delta, P), (3, n), or None; ``known``: whether
    these are what rows err by, at least.
    """

    order: Array
    x: Array
    lever: Array
    measured: Array
    stated: Array | None
    known: bool = False

    @cached_property
    def _starts(self) -> Array:
        # bins of one size: where some hold one point and some two, the noise left in them differs as it does not along
        # the record, and correlation is estimated too small
        return np.arange(0, self.x.size, -(-self.x.size // TUNING.most_bins))

    @cached_property
    def counts(self) -> Array:
        """How many points are in each bin."""
        return np.diff(np.append(self._starts, self.x.size))

    def mean(self, values: Array) -> Array:
        """Means over the bins, of values (..., n)."""
        return np.add.reduceat(values, self._starts, axis=-1) / self.counts

    def spread(self, values: Array) -> Array:
        """Values of the bins, (bins,), for every point, (n,)."""
        return np.repeat(values, self.counts)


def integral(series: Series) -> Slopes:
    """S, S', and the smoothed delta_H and P_H, at the radii of ``series``; refused below 5 points."""
    raw = RawSeries(series.a, series.delta, series.P)
    settled = _settle(raw, series.errors, series.a0, series.S0, series.own)
    return _slopes(settled, raw, series.errors, series.a0, series.a)


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, own: Series | None = None, ahead: Ahead = AS_THEY_ARE,
    load_errors: Array | None = None,
) -> tuple[Series, Slopes]:  # fmt: skip
    """A series and its slopes from increments, also where they are too noisy to be a series (columns out of order).

    Where radii are those of nodes, the moments at which the next node is reached are found first (``events.py``), the
    edge being ``ahead`` of it; ``load_errors`` (2, m): relative 90 % half-widths of the loads at equal depth, which
    rows share, over displacements [m]. The series holds the fitted columns at the data's radii, sorted and without
    repeats, but for those of outliers beyond all others.
    """
    nodes, errors, shift = node_radii(raw), dict[str, Array](), None
    raw = raw.touching
    if nodes is not None:
        touches = nodes.touches(ahead.elements)
        raw, errors = touches.rows.only(touches.rows.a > a0), {"a": touches.errors[touches.rows.a > a0]}
        element = touches.element[touches.rows.a > a0]
    settled = _settle(raw, errors, a0, S0, own, known=nodes is not None)
    inliers = np.delete(raw.a, settled.outliers)
    a = np.unique(raw.a[(raw.a >= inliers.min()) & (raw.a <= inliers.max())])
    if nodes is not None:
        shift = ahead.error * np.interp(a, raw.a, element)
    # where nodes are reached is known for each by itself: it is scatter, which the fit has
    of_loads = {} if load_errors is None else {"P": raw.P * np.interp(raw.delta, *load_errors)}
    fitted = _slopes(settled, raw, of_loads, a0, a)
    assert fitted.delta is not None
    assert fitted.P is not None
    return Series(a, fitted.delta, fitted.P, a0=a0, S0=S0, own=own, shift=shift), fitted


def _settle(
    raw: RawSeries, errors: Mapping[str, Array], a0: float, S0: float | None, own: Series | None, known: bool = False
) -> _Settled:
    """The fit of the columns (n,), in units of their largest values; ``known``: whether the ``errors`` are those of
    each row for itself, however little rows scatter about a fit: those of nodes keep in step with the increments."""
    data = replace(_prepare(raw, errors, a0), known=known)
    shape = None if own is None else Shape.of(own, float(np.max(raw.a) - a0))
    return _fine_enough(data, None if S0 is None else S0 * float(np.max(raw.delta)) / float(np.max(raw.P)), shape)


def _slopes(settled: _Settled, raw: RawSeries, errors: Mapping[str, Array], a0: float, wanted: Array) -> Slopes:
    """The slopes at the radii ``wanted`` (m,) from the ``settled`` fit of the columns (n,)."""
    a, fit = raw.a, settled.fit
    y_scale, delta_scale, P_scale = float(np.max(a) - a0), float(np.max(raw.delta)), float(np.max(raw.P))
    S_scale = P_scale / delta_scale
    x = np.log((wanted - a0) / y_scale)
    scales = np.array([delta_scale, P_scale, S_scale, S_scale / y_scale, delta_scale / y_scale, S_scale / y_scale**2])
    values, covariance, joint = _evaluate(settled, x, scales)
    delta_H, P_H, S, dS = values
    if errors:
        order = np.argsort(a)
        there = {name: np.interp(wanted, a[order], errors[name][order]) for name in errors}
        if "P" in there:  # S and S' are those of the fit: P's errors, which vary as slowly, or the series' own if less
            of_P = {"S": there["P"] / P_H * S, "dS": there["P"] / P_H * dS}
            there |= {name: np.minimum(error, there.get(name, error)) for name, error in of_P.items()}
        if "a" in there:
            there["a"] = TUNING.radii * there["a"]
        common = TUNING.of_meshes if settled.of_nodes else ERRORS.common
        stated = covariance_from_errors(wanted, there, dS, ERRORS.at_displacement, common)
        assert stated is not None
        # what the scatter does not show is shared by all points; that of nodes shows nothing of it
        shared = stated if settled.of_nodes else max(0.0, 1 - fit.phi) * stated
        joint[:, :4, :4] += shared
        # rates in their logs err as columns do that err smoothly: d(delta_H)/da as the radius, S'' as S'
        if wanted.size > 1 and "a" in there:
            of_radius = TUNING.rates / TUNING.radii * there["a"] / wanted / TWO_SIDED_90
            joint[:, 4, 4] += (np.gradient(delta_H, wanted) * of_radius) ** 2
            joint[:, 5, 5] += (2 * dS / wanted * of_radius) ** 2
        covariance += shared
    quantile = float(stdtrit(_freedom(fit), 0.95))
    error = Unknown(TOO_FEW) if settled.hidden else shift_error(dS, covariance, quantile)
    known = {} if settled.hidden else {"covariance": covariance, "joint": joint}
    columns = {"delta": delta_H, "P": P_H, **known}
    flags, rho = tuple(_flags(settled, raw)), settled.correlation
    return Slopes(S, dS, "integral", error, float(fit.lambdas[1]), flags, quantile=quantile, correlation=rho, **columns)


def _freedom(fit: PenalisedFit) -> float:
    """Degrees of freedom of the scatter (Satterthwaite, Biometrics Bull. 2 (1946) 110): those of all residuals where
    both columns carry as much of it, of half of them where one does, or where an error of the radius is in both."""
    rows = fit.independent
    carried = np.linalg.eigvalsh(rows @ rows.T)
    share = float(np.sum(carried) ** 2 / max(carried.size * np.sum(carried**2), TINY))
    return max((rows.size - fit.spent) * max(share, 1 / carried.size), 1.0)


def _flags(settled: _Settled, raw: RawSeries) -> Iterator[str]:
    """Sentences on what is wrong with the data."""
    if not settled.fit.settled:
        yield UNSETTLED
    rows = [str(row) for row in np.sort(raw.rows[settled.outliers])]
    if rows:
        some = ", ".join(rows[:SHOWN]) + (", ..." if len(rows) > SHOWN else "")
        yield f"{len(rows)} of {raw.a.size} rows are outliers and have little weight: {some}"
    if settled.hidden:
        yield f"errors of neighbouring rows may be correlated; {TOO_FEW} ({raw.a.size})"
    rho = settled.correlation
    if isinstance(rho, float) and rho > 0 and settled.known.evidence > TUNING.evidence:
        bins = settled.fit.residuals.size / 2
        worth = bins * (1 - rho) / (1 + rho)
        yield (
            f"errors of neighbouring rows are autocorrelated ({rho:.2f}): effective sample size {max(worth, 1):.0f} of "
            f"{raw.a.size} rows, in the stated error"
        )


def _evaluate(settled: _Settled, x: Array, scales: Array) -> tuple[Array, Array, Array]:
    """delta_H, P_H, S, S' in SI at the log radii ``x``, shape (4, m), their covariance, (m, 4, 4), and that, (m, 6, 6),
    of these, d(delta_H)/da and S'' away from the ends, from those of the coefficients."""
    model, fit = settled.model, settled.fit
    basis, y = model.design(x), np.exp(x)[:, None]
    columns = model.columns(fit.c, model.interpolation(x), basis)
    values = np.exp(columns.logs)
    jacobian = np.zeros((6, *columns.jacobian.shape[1:]))
    jacobian[:4] = columns.jacobian * values[:, :, None]
    jacobian[4, :, model.v] = np.exp(model.of_shape(x)[0] + basis @ fit.c[model.v])[:, None] * basis
    bend = model.design(x, 1)  # S'' = S' u'(x)/y
    rate = model.of_shape(x, 1)[1] + bend @ fit.c[model.u]
    jacobian[5, :, model.u] = values[3][:, None] / y * (rate[:, None] * basis + bend)
    jacobian *= scales[:, None, None]
    full = jacobian[:4]
    covariance = np.einsum("imp,pq,jmq->mij", full, fit.phi * settled.known.V, full, optimize=True)
    joint = np.einsum("imp,pq,jmq->mij", jacobian, fit.phi * settled.known.inner, jacobian, optimize=True)
    return values * scales[:4, None], covariance, joint


def _prepare(raw: RawSeries, errors: Mapping[str, Array], a0: float) -> _Data:
    a, delta, P = raw.a, raw.delta, raw.P
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
    stated = None
    columns = {"a": a, "delta": delta, "P": P}
    if any(np.any(errors[name] > 0) for name in columns.keys() & errors):
        stated = np.stack([(errors.get(name, 0 * v) / v / TWO_SIDED_90) ** 2 for name, v in columns.items()])
    y = a - a0
    _refuse_span(a, y)
    x, logs = np.log(y / np.max(y)), np.log([delta / np.max(delta), P / np.max(P)])
    order = _order(x)
    return _Data(order, x[order], (a / y)[order], logs[:, order], None if stated is None else stated[:, order])


def _order(x: Array) -> Array:
    """That of recording where ``x`` follows it, else that of ``x``."""
    recorded = np.arange(x.size)
    ranks = np.argsort(np.argsort(x, kind="stable"), kind="stable")
    follows = float(np.corrcoef(recorded, ranks)[0, 1]) > TUNING.recorded
    return recorded if follows else np.argsort(x, kind="stable")


def _refuse_span(a: Array, y: Array) -> None:
    """Refuse radii over more decades than a series has, by the one that lies farthest off."""
    logs = np.log10(y)
    if np.ptp(logs) > TUNING.decades:
        i = int(np.argmax(np.abs(logs - np.median(logs))))
        raise InputError(
            f"slopes 'integral': point {i + 1} has a = {a[i]:g} m, radii beyond the flat end differ by "
            f"{np.ptp(logs):.0f} decades, at most {TUNING.decades:g} are fitted: drop it"
        )


class _Task:
    """The data as a least-squares problem: residuals of log delta and log P, whitened, over bins of points."""

    def __init__(self, model: LogSplineModel, data: _Data):
        self.model, self.data, x = model, data, data.mean(data.x)
        self.blocks = (model.rough_v, model.rough_u)
        self.at, self.basis = model.interpolation(x), model.design(x)
        self.everywhere = model.interpolation(data.x)

    def difference(self, grid: OnGrid) -> Array:
        """Model minus data at every point, shape (2, n)."""
        (log_delta, _), (log_P, _), _ = grid
        return np.stack([interpolate(self.everywhere, *pair) for pair in (log_delta, log_P)]) - self.data.measured

    def minimise(
        self, start: Array, variances: Array, lambdas: Array, floor: float, freeze: int, rho: float = 0.0
    ) -> PenalisedFit:
        """The fit with given relative variances of (a, delta, P), (3, n), the radius' slopes taken at ``start``."""
        columns = self.model.columns(start, self.at, self.basis)
        data = self.data
        k, m = columns.rates * data.mean(data.lever)
        whiten = whitener(data.mean(variances), k, m) * np.sqrt(data.counts)

        def residuals(c: Array) -> tuple[Array, Array]:
            grid = self.model.on_grid(c)
            white = np.einsum("ijn,jn->in", whiten, data.mean(self.difference(grid)))
            jacobian = self.model.columns(c, self.at, self.basis, grid).jacobian[:2]
            return white, np.einsum("ijn,jnp->inp", whiten, jacobian)

        return minimise(residuals, start, self.blocks, floor, lambdas, freeze, rho)

    def scatter(self, fit: PenalisedFit) -> tuple[Array, Array]:
        """The scatter of a, delta and P as the residuals of ``fit`` show it: variances, outliers."""
        grid = self.model.on_grid(fit.c)
        columns = self.model.columns(fit.c, self.at, self.basis, grid)
        k, m = (self.data.lever * self.data.spread(rate) for rate in columns.rates)
        return estimate(self.data.x, self.difference(grid), k, m, fit.spent, TUNING.floor**2)


@dataclass(frozen=True, eq=False)
class _Settled:
    """A fit with all that was ``known`` in the end: ``outliers``: their points; ``noisy``: whether the residuals are
    noise; ``few``: whether the points are too few to tell its correlation; ``of_nodes``: whether the radii are those of
    nodes."""

    model: LogSplineModel
    fit: PenalisedFit
    known: Posterior
    outliers: Array
    noisy: bool
    few: bool
    of_nodes: bool = False

    @property
    def hidden(self) -> bool:
        """Whether too few points seem to have correlated errors."""
        return self.noisy and self.few and correlation_length(self.fit.residuals) > 1

    @property
    def correlation(self) -> Estimate | None:
        """The correlation of neighbours, or why it is unknown; None where the residuals are no noise."""
        if not self.noisy:
            return None
        return Unknown(TOO_FEW) if self.few else self.known.rho


def _fine_enough(data: _Data, S0: float | None, shape: Shape | None) -> _Settled:
    """The fit with the knots that the data need; residuals still correlated count as that many fewer data."""
    for intervals in (TUNING.intervals, 2 * TUNING.intervals):
        settled = _fit(_Task(LogSplineModel(data.x, intervals, S0, shape), data))
        length = 1.0 if _explained(settled.fit, data) else correlation_length(settled.fit.independent)
        if length == 1 and settled.known.rho < max(PENALTIES.correlations):
            break
    known = replace(settled.known, V=length * settled.known.V, inner=length * settled.known.inner)
    return replace(settled, known=known)


def _explained(fit: PenalisedFit, data: _Data) -> bool:
    """Whether round-off, or the stated errors, explain the residuals."""
    return fit.phi <= fit.phi_floor or (data.stated is not None and fit.phi <= 1)


def _fit(task: _Task) -> _Settled:
    """The fit with penalties found from the data, in rounds, each with the scatter that the one before has shown."""
    stiff = np.full(len(task.blocks), TUNING.stiff)
    data, stated = task.data, task.data.stated
    variances = _far_off(data) * np.ones((3, 1)) if stated is None else stated
    best: PenalisedFit | None = None
    outliers = np.zeros(data.x.size, dtype=bool)
    rho, noisy, many = 0.0, False, data.x.size >= TUNING.tell_correlation
    for share in (1.0, TUNING.share, TUNING.share):
        variances = floored(variances, share, TUNING.floor**2)
        floor = 1.0 if data.known else TUNING.floor**2 / float(np.mean(variances))
        # a stiff fit first: far from the solution a linearised one takes all for signal
        start = best or task.minimise(_start(task), variances, stiff, floor, 0)
        fit = task.minimise(start.c, variances, start.lambdas, floor, PENALTIES.freeze, rho)
        if best is not None and not fit.settled:
            break  # weights too uneven to go on: the last fit stands
        if fit.settled:
            best, noisy = fit, _noisy(fit, data, variances)
        if stated is None and fit.phi <= floor:
            break
        if stated is None:
            variances, outliers = task.scatter(best or start)
        else:
            variances = stated
        rho = likeliest_correlation(best) if best is not None and noisy and many else 0.0
    fit = best or fit
    known = posterior(fit, noisy or data.known, noisy and many)
    return _Settled(task.model, fit, known, data.order[outliers], noisy, not many, data.known)


def _far_off(data: _Data) -> Array:
    """Relative variances (n,) of the first fit, in the order of recording: 1, and more for rows whose radius lies far
    off what their load and displacement, beside those of their neighbours, make of it: a radius beyond all others bends
    any spline to itself."""
    x, load = data.x, np.sum(data.measured, axis=0)
    n, reach = x.size, TUNING.beside
    if n <= 2 * reach + 1:
        return np.ones(n)
    rows = np.arange(n)[:, None] + np.array([j for j in range(-reach, reach + 1) if j])
    rows = np.where((rows >= 0) & (rows < n), rows, rows - np.sign(rows) * (2 * reach + 1))  # at the ends one-sided
    exponent = float(np.median(x[n // 2 :] - x[: -(n // 2)]) / np.median(load[n // 2 :] - load[: -(n // 2)]))
    expected = exponent * (load[:, None] - load[rows])
    gap = np.abs(x - np.median(x[rows] + expected, axis=1))
    usual = float(np.median(gap)) / 0.6745  # theory: the median of the size of a normal number
    # theory: an exponent that changes along the record moves a row by no more than the way to its neighbours
    far = gap > np.maximum(TUNING.far * usual, np.median(np.abs(expected), axis=1))
    return np.where(far, (gap / max(usual, TUNING.floor)) ** 2, 1.0)


def _noisy(fit: PenalisedFit, data: _Data, variances: Array) -> bool:
    """Whether the residuals are noise rather than what the splines cannot bend to."""
    size = math.sqrt(fit.phi * float(np.mean(np.median(variances, axis=1))))
    return data.stated is None and not _explained(fit, data) and size > TUNING.noise


def _start(task: _Task) -> Array:
    """Coefficients of the bodies' own shape, brought to the level of the data; else of power laws through their logs.
    The large radii count most, they are surest."""
    if task.model.shape is None:
        return _power_laws(task.model, task.data)
    gap = task.difference(task.model.on_grid(np.zeros(task.model.parameters)))
    level_delta, level_P = -np.average(gap, axis=1, weights=np.exp(task.data.x))
    return task.model.straight((level_delta, 0.0), (level_P - level_delta, 0.0), level_P - level_delta)


def _power_laws(model: LogSplineModel, data: _Data) -> Array:
    """Coefficients of straight lines through the logs of the data."""
    (k, log_k), (m, log_m) = (np.polyfit(data.x, logs, 1, w=np.exp(data.x)) for logs in data.measured)
    k = max(float(k), 0.2)
    excess = max(float(m) - k, 0.2)
    log_S = float(np.log(1 + excess / k)) + log_m - log_k  # S = P' / delta'
    half = float(np.log(0.5)) if model.S0 is None or model.S0 > 0 else 0.0
    v = (float(np.log(k) + log_k), k - 1)
    u = (float(np.log(excess)) + log_S + half, excess - 1)
    return model.straight(v, u, log_S + half)

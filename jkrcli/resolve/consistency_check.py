"""How a measured or computed series departs from the solution of the bodies that it is claimed to be of.

Whatever is smooth passes for a body: a drift of the load by a few per cent changes S and S' smoothly. Only the bodies
themselves tell. The logs of delta and P over those of their own solution at the same radii, the modulus left free, are
compared with a parabola in the order of recording: generalised least squares with the scatter of a, delta and P as the
residuals have it (``slopes/integral.py``), AR(1) along the rows, and an F test of what the parabola adds. A second one
asks for a straight line in the load alone, the likeliest drift, which one number tells from noise earlier than five.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from ..adhesion.slopes.integral import estimate, whitener
from ..base.numerics import Array
from ..series import RawSeries, Series
from .node_radii import AHEAD_DEEP, Compared

# When a departure is reported.
DEPARTURE_FEWEST = 8  # choice: points; the parabolas take six numbers
DEPARTURE_CHANCE = 2e-3  # probability that independent noise shows as much; choice: rare
DEPARTURE_OF_LINE = 2e-2  # that it shows as straight a line in the load; tuned on drifts, by `make noise-study`
DEPARTURE_LEAST = 5e-3  # choice: of delta or P; meshes of finite elements leave as much
DEPARTURE_OF_NODES = 0.05  # of the load where radii are those of nodes; choice: cut and coarse bodies leave as much
DEPARTURE_FLOOR = 1e-14  # theory: variance below which nothing is known of the scatter
DEPARTURE_LONGEST = 0.99  # choice: correlation of neighbours; more is drift itself


def check_against_solution(beside: Compared) -> tuple[str, ...]:
    """A sentence on how rows depart from the bodies' own solution by more than their scatter explains, if they do.

    Nothing where no exact method represents the bodies, or where points are few. Radii of nodes lie anywhere within an
    element, which says nothing of the bodies: their loads are compared at equal displacement.
    """
    own = beside.own
    if own is None:
        return ()
    if beside.nodes is not None:
        return _at_equal_displacement(beside.nodes.rows, own)
    raw = beside.rows
    usable = (raw.a > own.a[0]) & (raw.a <= own.a[-1]) & (raw.delta > 0) & (raw.P > 0)
    a, delta, P = (values[usable] for values in (raw.a, raw.delta, raw.P))
    if a.size < DEPARTURE_FEWEST:
        return ()
    x, logs = np.log(own.a), np.log(np.stack([own.delta, own.P]))
    at = np.log(a)
    expected = CubicSpline(x, logs, axis=1)
    return _judged(np.log(np.stack([delta, P])) - expected(at), expected(at, 1), at, DEPARTURE_LEAST, "contact radii")


def _at_equal_displacement(rows: RawSeries, own: Series) -> tuple[str, ...]:
    """The sentence on loads beyond the first elements."""
    usable = (rows.delta > max(AHEAD_DEEP * rows.delta.max(), own.delta[0])) & (rows.delta <= own.delta[-1])
    if np.count_nonzero(usable) < DEPARTURE_FEWEST:
        return ()
    x, logs = np.log(own.delta), np.log(np.stack([own.a, own.P]))
    log_a, expected = CubicSpline(x, logs, axis=1)(np.log(rows.delta[usable]))
    gap = np.log(rows.P[usable]) - expected
    rates = CubicSpline(logs[0], np.stack([x, logs[1]]), axis=1)(log_a, 1)
    return _judged(np.stack([0 * gap, gap]), rates, log_a, DEPARTURE_OF_NODES, "displacements")


def _judged(gap: Array, rates: Array, x: Array, least: float, equal: str) -> tuple[str, ...]:
    """The sentence on the ``gap`` (2, n) of the logs of delta and P at log radii ``x`` from the bodies' own solution,
    whose slopes over x are ``rates`` (2, n); none where it is scatter, or below ``least``. ``equal``: at what."""
    smooth = _smooth(gap, rates, x)
    if smooth is None:
        return ()
    displacement, load = smooth
    spans = {
        "displacement": float(displacement[np.argmax(np.abs(displacement))]),
        "load": float(np.ptp(load) * np.sign(load[-1] - load[0])),
    }
    name = max(spans, key=lambda key: abs(spans[key]))
    if abs(spans[name]) < least:
        return ()
    how = "drifts from" if name == "load" else "departs from"
    return (
        f"the {name} {how} the solution of these bodies at the same {equal} by {spans[name]:+.1%}, beyond the "
        "scatter (the modulus left free): drift, a wrong zero point, or other bodies; the stated errors do not "
        "include it",
    )


def _smooth(gap: Array, rates: Array, x: Array) -> tuple[Array, Array] | None:
    """The smooth part (n,) of the ``gap`` in displacement and load, a parabola along the rows in each, or a straight
    line in the load alone; None where chance explains both (F tests against the scatter of independent rows).

    The modulus is free: a constant in the gap of the load is no departure.
    """
    from scipy.special import fdtrc

    n = x.size
    t = np.linspace(-1, 1, n)
    powers = np.stack([np.ones(n), t, t**2])
    columns = np.zeros((6, 2, n))
    columns[:3, 0], columns[3:, 1] = powers, powers
    parabola = np.linalg.lstsq(powers.T, gap.T, rcond=None)[0].T @ powers
    variances, _ = estimate(x - x.max(), gap - parabola, rates[0], rates[1], 6.0, DEPARTURE_FLOOR)
    whiten = whitener(variances, rates[0], rates[1])
    white, basis = (np.einsum("ijn,...jn->...in", whiten, values) for values in (gap, columns))
    rho = _correlation(np.einsum("ijn,jn->in", whiten, gap - parabola))
    target, design = _independent(white, rho).ravel(), _independent(basis, rho).reshape(6, -1)
    parabolas, line, modulus = slice(0, 6), slice(3, 5), slice(3, 4)  # rows of the design
    (both, full), (drift, straight), (_, none) = (_fit(design[rows], target) for rows in (parabolas, line, modulus))
    free = target.size - 6
    chance, of_line = (
        float(fdtrc(more, free, (none - left) / more / max(full / free, 1e-300)))
        for more, left in ((5, full), (1, straight))
    )
    if chance <= DEPARTURE_CHANCE:
        return both[:3] @ powers, both[3:] @ powers
    if of_line <= DEPARTURE_OF_LINE:
        return np.zeros(n), drift @ powers[:2]
    return None


def _fit(design: Array, target: Array) -> tuple[Array, float]:
    """Coefficients and least sum of squares of ``target`` (m,) by the rows of ``design``."""
    coefficients = np.linalg.lstsq(design.T, target, rcond=None)[0]
    return coefficients, float(np.sum((target - coefficients @ design) ** 2))


def _correlation(white: Array) -> float:
    """Correlation of neighbours in the rows (2, n), its bias by the parabola taken out; 0 where chance explains it."""
    n = white.shape[1]
    lag1 = float(np.sum(white[:, 1:] * white[:, :-1]) / max(np.sum(white**2), 1e-300))
    if lag1 < 2 / np.sqrt(2 * n):
        return 0.0
    return min(lag1 + (3 + 4 * lag1) / n, DEPARTURE_LONGEST)


def _independent(rows: Array, rho: float) -> Array:
    """Rows (..., n) with the correlation of neighbours taken out."""
    out = rows.copy()
    out[..., 1:] = (rows[..., 1:] - rho * rows[..., :-1]) / np.sqrt(1 - rho**2)
    return out

"""Starting values from the data: every curve of the family that could fit is tried on a few points.

A curve is named by the radius at which it is pulled off under load control, which fixes the shape sqrt(w/s), and by
the radius that the largest load reaches, which fixes the modulus factor s. Zero points follow by averages.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...base.errors import InputError
from ...series import Array
from .family import Family
from .points import LEAST, Points

NODES = 200  # of the family
BEYOND, SLIGHTLY = 1.2, 0.05  # of log a: how far beyond the series curves are tried, continued by power laws
SHAPES, FACTORS = 24, 24
TRIED = 60  # points of the data
ALTERNATIVES = 4
LOAD_ZEROS = (0.0, -0.3, 0.3, -0.8, 0.8)  # in units of the range of loads, where the zero of the load is free


@dataclass(frozen=True)
class Known:
    """What the user has fixed, SI; None: to be found."""

    modulus: float | None = None
    w: float | None = None
    delta0: float | None = None
    P0: float | None = None
    compliance: float | None = None


@dataclass(frozen=True)
class Start:
    """Values to begin with, SI; ``reach``: the largest contact radius [m] of the data with them; ``cost``: mean square
    distance in units of the data's ranges, for comparison of starts."""

    modulus: float
    w: float
    delta0: float
    P0: float
    compliance: float
    reach: float
    cost: float


def starts(family: Family, points: Points, known: Known, beyond: bool) -> list[Start]:
    """The best starting values found, best first; InputError where no curve of the series resembles the data.

    ``beyond``: curves that go beyond the series count too.
    """
    if "a" in points.columns:
        return [_with_radii(family, points, known)]
    delta, P = _stable_rows(points.values["delta"], points.values["P"])
    u = np.linspace(family.low, family.high + (BEYOND if beyond else SLIGHTLY), NODES)
    (D, T, H, V), (dD, dT, dH, dV), _ = family.at(u)
    found = []
    for P0, shape in itertools.product(_load_zeros(points, known), _shapes(dH / dV)):
        stable = slice(int(np.argmin(H - shape * V)), None)
        delta_P_and_rates = [(X - shape * Y)[stable] for X, Y in ((D, T), (H, V), (dD, dT), (dH, dV))]
        curve = StableBranch(shape, u[stable], *delta_P_and_rates)
        found += curve.match(delta, P - P0, P0, known)
    found.sort(key=lambda start: start.cost)
    if not found:
        raise InputError("no curve of the series resembles the data: check signs, units and the indenter")
    return found[:ALTERNATIVES]


def _stable_rows(delta: Array, P: Array) -> tuple[Array, Array]:
    """A few readings spread over those that are stable under load control: not beyond the least load, if enough."""
    rows = np.flatnonzero(delta >= delta[int(np.argmin(P))])
    rows = rows if rows.size >= LEAST else np.arange(P.size)
    some = rows[np.unique(np.linspace(0, rows.size - 1, TRIED).astype(int))]
    return delta[some], P[some]


@dataclass(frozen=True, eq=False)
class StableBranch:
    """The stable branch of one curve at s = 1, by increasing load."""

    shape: float
    u: Array
    delta: Array
    P: Array
    ddelta: Array
    dP: Array

    def match(self, delta: Array, P: Array, P0: float, known: Known) -> list[Start]:
        """Starts with this shape, for the few factors that are possible, the best only."""
        if self.P.size < 4:
            return []
        factors = np.array([f for f in self._factors(P, known) if np.isfinite(f) and f > 0])
        if factors.size == 0:
            return []
        compliance = known.compliance or 0.0
        load = P / factors[:, None]
        model = np.interp(load, self.P, self.delta)
        slope = np.interp(load, self.P, self.ddelta / np.maximum(self.dP, 1e-30 * self.dP.max()))
        force, length = np.ptp(P), np.ptp(delta)
        weight = 1 / (length**2 + (slope / factors[:, None] * force) ** 2)
        gap = delta - compliance * P - model
        if known.delta0 is None:
            zero = np.sum(weight * gap, axis=1) / np.sum(weight, axis=1)
        else:
            zero = np.full(factors.size, known.delta0)
        beyond = (load - np.clip(load, self.P[0], self.P[-1])) * factors[:, None] / force
        cost = np.mean(weight * (gap - zero[:, None]) ** 2 + beyond**2, axis=1)
        best = int(np.argmin(cost))
        s = float(factors[best])
        reach = float(np.exp(np.interp(load[best].max(), self.P, self.u)))
        return [Start(s, self.shape**2 * s, float(zero[best]), P0, compliance, reach, float(cost[best]))]

    def _factors(self, P: Array, known: Known) -> Iterator[float]:
        if known.modulus is not None:
            yield known.modulus
        elif known.w is not None and self.shape > 0:
            yield known.w / self.shape**2
        else:
            end = P.max() if P.max() >= -P.min() else P.min()
            loads = self.P[np.linspace(0, self.P.size - 1, FACTORS).astype(int)]
            yield from (end / load for load in loads if load * end > 0)


def _shapes(stationary: Array) -> Array:
    """sqrt(w/s) of curves that are pulled off at radii across the series, and of almost no adhesion."""
    shapes = np.unique(stationary[stationary > 0])
    some = shapes[np.linspace(0, shapes.size - 1, min(SHAPES, shapes.size)).astype(int)]
    return np.concatenate([[0.0], some])


def _load_zeros(points: Points, known: Known) -> tuple[float, ...]:
    if known.P0 is not None:
        return (known.P0,)
    if points.baseline is not None:
        return (points.baseline,)
    return tuple(part * float(np.ptp(points.values["P"])) for part in LOAD_ZEROS)


def _with_radii(family: Family, points: Points, known: Known) -> Start:
    """Known radii: the load is linear in s, sqrt(w s), P0; the displacement in sqrt(w/s), delta0."""
    (D, T, H, V), _, _ = family.at(np.clip(np.log(points.values["a"]), family.low - 0.5, family.high + 0.5))
    compliance, P0, load = known.compliance or 0.0, known.P0 or 0.0, None
    s, w = known.modulus, known.w
    if "P" in points.columns:
        load = points.values["P"]
        columns, wanted = [H, -V, np.ones_like(H)], load - P0
        if known.P0 is not None:
            columns.pop()
        found = _least_squares(columns, wanted)
        P0 = found[2] if known.P0 is None else P0
        s = max(found[0], 1e-3 * np.ptp(load) / np.ptp(H)) if s is None else s
        w = max(found[1], 0.0) ** 2 / s if w is None else w
    s = 1.0 if s is None else s
    delta0 = known.delta0 or 0.0
    if "delta" in points.columns:
        delta = points.values["delta"] - D - (0.0 if load is None else compliance * (load - P0))
        if w is None:
            columns = [-T] if known.delta0 is not None else [-T, np.ones_like(T)]
            found = _least_squares(columns, delta - delta0)
            w, delta0 = max(found[0], 0.0) ** 2 * s, (delta0 if known.delta0 is not None else found[1])
        elif known.delta0 is None:
            delta0 = float(np.mean(delta + np.sqrt(w / s) * T))
    assert w is not None
    gaps, reach = [], float(points.values["a"].max())
    if load is not None:
        gaps.append((load - P0 - s * H + np.sqrt(w * s) * V) / np.ptp(load))
    if "delta" in points.columns:
        gaps.append((delta - delta0 + np.sqrt(w / s) * T) / np.ptp(points.values["delta"]))
    return Start(float(s), float(w), float(delta0), float(P0), compliance, reach, float(np.mean(np.square(gaps))))


def _least_squares(columns: list[Array], wanted: Array) -> Array:
    matrix = np.stack(columns, axis=1)
    size = np.linalg.norm(matrix, axis=0)
    return np.linalg.lstsq(matrix / size, wanted, rcond=None)[0] / size

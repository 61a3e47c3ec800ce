"""Surface tension, E*, w and contact points from records by indenters of one or more radii on the same body, together.

One radius separates them poorly: what tension carries goes like a, what elasticity carries like a^2 and more, and E*
and the zero point make up for most of it. Two radii do. The family of curves is tabulated over the length 2 Ups/E* and
the contact radius; residuals are those of the load at the displacement that was read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from ..adhesion.validity import LIMITS
from ..base.errors import LEVEL, NOTICEABLE, InputError, SolveError
from ..base.numerics import SAME, Array
from ..base.units import Named, Ranged, show, texts_of
from ..bodies.problem import RADIUS, Loading, Problem, changed, without_side_walls
from ..formulas import edge_angle, lagging, shift
from ..methods.layered.solver import Layered, largest_radius
from ..methods.radii import DENSE
from .curve import Curve
from .forward_model import for_each
from .least_squares import Intervals, Least, LeastSquares, State, by_differences
from .parameters import (
    ALIAS,
    LINEAR,
    ONE_SIDED,
    Answer,
    FittedValue,
    Nameable,
    Parameter,
    Unknowns,
    parameters_of,
    word,
)
from .rows import ROWS_LEAST

TENSION = "surface_tension"
RANGES = {TENSION: Ranged("tension", above=0), "w": Ranged("work", least=0)}  # beside E_star

# The tabulated family, and the search.
TENSION_FIT_LENGTHS = 14  # of 2 Ups/E*; choice: curves between them err by 1e-4
TENSION_FIT_MOST = 1e2  # of it over the largest contact radius; choice: beyond, tension alone carries
TENSION_FIT_SMALLEST = 0.002  # of the largest, the least of them; choice: where a slight w lets the contact go
TENSION_FIT_BEYOND = 3.0  # times the range of the displacement, to which it reaches; choice: spare for w
TENSION_FIT_POINTS = 800  # of a curve; choice: interpolated to 1e-5
TENSION_FIT_STEP = 1e-4  # of unknowns, for derivatives; choice: the square root of the curves' accuracy is coarser
TENSION_FIT_WORK = 0.05  # of its unit, w to begin with; choice: the search goes far from it
TENSION_FIT_STARTS = 9  # of 2 Ups/E*, over the whole table; choice: two minima may lie a decade apart
TENSION_FIT_FOLLOWED = 2  # choice: of the starts, those from which 2 Ups/E* is searched
TENSION_FIT_FARTHEST = 80.0  # theory: of logs of SI values, far beyond matter and within arithmetic


@dataclass(frozen=True, eq=False, kw_only=True)
class TensionFit(Answer):
    """E_star, surface_tension, w and the contact point, ``covariance`` in the units of their search; ``scatter`` of the
    load [N]; ``loads``: fitted loads [N] of each of the ``records``; ``mixed``: by name what those of one radius do not
    separate from the tension, with the correlation; ``level`` of the intervals."""

    scatter: float
    records: tuple[Curve, ...]
    loads: tuple[Array, ...]
    mixed: Mapping[str, float] = field(default_factory=dict)
    level: float = LEVEL


@dataclass(frozen=True, eq=False)
class TenseFamily:
    """Logs of delta_H, sqrt(4 pi a/S'), P_H and S over the logs of 2 Ups/E* and of the contact radius [m], for the
    moduli of ``problem``."""

    problem: Problem
    splines: tuple[Callable[..., Array], ...]
    lengths: tuple[float, float]
    radii: tuple[float, float]

    @classmethod
    def of(cls, problem: Problem, depth: float) -> TenseFamily:
        """The family of curves as deep as ``depth`` [m] and beyond."""
        rounded = 10 ** (math.ceil(4 * math.log10(depth)) / 4)  # so that records share it
        return _tabulated(replace(without_side_walls(problem), loading=Loading("depth", rounded, 1)))

    def loads(self, delta: Array, s: float, kappa: float, w: float) -> Array:
        """P [N] on the stable branch under a given displacement ``delta`` [m], moduli ``s`` times the problem's; held
        beyond its ends. P is straight in w at first, and goes on so below 0."""
        low, high = np.log(self.radii)
        u = np.linspace(low, high, TENSION_FIT_POINTS)
        D, T, H, S = np.exp([spline(math.log(kappa), u)[0] for spline in self.splines])

        def interpolated(w: float) -> Array:
            depth, load = lagging(D, H, S, math.sqrt(w / s) * T)
            first = int(np.argmin(depth))
            return np.interp(delta, depth[first:], s * load[first:])

        return interpolated(w) if w >= 0 else 2 * interpolated(0.0) - interpolated(-w)


@lru_cache(maxsize=64)
def _tabulated(problem: Problem) -> TenseFamily:
    plain = replace(problem, specimen=replace(problem.specimen, surface_tension=0.0))
    largest = min(largest_radius(plain), 0.95 * problem.indenter.r_max)
    radii = largest * np.geomspace(TENSION_FIT_SMALLEST, 1.0, DENSE)
    lengths = largest * np.geomspace(NOTICEABLE, TENSION_FIT_MOST, TENSION_FIT_LENGTHS)  # less changes loads by less
    at_radii = replace(problem, loading=Loading.given("radius", tuple(radii)))
    columns = []
    for kappa in lengths:
        specimen = replace(problem.specimen, surface_tension=kappa * problem.E_star / 2)
        series = Layered(SAME)(replace(at_radii, specimen=specimen)).series  # far below the noise of any record
        assert series.S is not None and series.dS is not None  # noqa: PT018 - of the method layered
        columns.append(np.log([series.delta, shift(1.0, series.a, series.dS), series.P, series.S]))
    from scipy.interpolate import RectBivariateSpline

    table = np.array(columns).transpose(1, 0, 2)
    splines = tuple(RectBivariateSpline(np.log(lengths), np.log(radii), values, s=0) for values in table)
    return TenseFamily(problem, splines, (lengths[0], lengths[-1]), (radii[0], radii[-1]))


def radii_of(problem: Problem, radii: Sequence[float], count: int) -> Sequence[float]:
    """The tip radius [m] of each file."""
    own = problem.indenter.tip_radius
    if not hasattr(problem.indenter, "R") or own is None:
        raise InputError("fit: surface_tension: needs a sphere or a paraboloid: give indenter.shape one of these")
    return for_each(radii, count) or [own] * count


def known_values(problem: Problem, names: Iterable[str], fix: Named) -> dict[str, float]:
    """Known values by the fit's names; the tension is the body's where it is neither free nor fixed."""
    if problem.specimen.radius is not None:
        raise InputError("fit: surface_tension: a finite cylinder is not solved anew: leave specimen.radius out")
    names, fix = list(names), texts_of(fix)
    if other := [name for name in (*names, *dict(fix)) if name not in (*RANGES, ALIAS, "modulus", "delta0")]:
        raise InputError(f"fit: surface_tension: {other[0]} cannot be free or fixed beside it: leave it out")
    values = Nameable(TENSION, RANGES, 1.0).known(fix)
    return {TENSION: problem.specimen.surface_tension} | values if TENSION not in names else values


def tension_fit(
    problem: Problem, curves: Sequence[Curve], radii: Sequence[float], fixed: Mapping[str, float], level: float = LEVEL
) -> TensionFit:
    """One fit of all ``curves``, each by an indenter of one of the ``radii`` [m]; ``fixed``: values of those
    of ``RANGES`` and the modulus (E* [Pa]) that are known. InputError where a record cannot be used, SolveError."""
    for curve in curves:
        if curve.delta is None or curve.P is None:
            raise InputError(f"{curve.where}: a fit of surface tension needs displacement and load (delta, P)")
        if len(curve) < ROWS_LEAST:
            raise InputError(f"{curve.where}: {len(curve)} rows, a fit of surface tension needs {ROWS_LEAST}")
    families = [
        TenseFamily.of(changed(problem, {RADIUS: R}), TENSION_FIT_BEYOND * _span(curve.depth))
        for R, curve in zip(radii, curves, strict=True)
    ]
    model = _Model(problem.E_star, tuple(curves), families, fixed)
    return _result(model, model.best(), radii, level)


def _span(column: Array) -> float:
    """The range of the readings of a record."""
    return float(np.ptp(column))


@dataclass(frozen=True, eq=False)
class _Model:
    """The unknowns x: logs of E* and of the surface tension and w, as far as they are not ``fixed``, and the zero
    points in units of each record's range. ``length``: 2 Ups/E* [m], where the tension follows from the modulus."""

    E_star: float
    records: tuple[Curve, ...]
    families: list[TenseFamily]
    fixed: Mapping[str, float]
    length: float | None = None

    @cached_property
    def unknowns(self) -> Unknowns:
        """Of all records together: w, which may be below 0, in load over radius of the first; then the zero of each."""
        tension = {TENSION: RANGES[TENSION]} if self.length is None else {}
        ranges = {"modulus": Ranged("modulus", above=0)} | tension | {"w": Ranged("work")}
        units = {f"delta0:{i}": _span(record.depth) for i, record in enumerate(self.records)}
        radius = self.families[0].problem.indenter.tip_radius
        assert radius is not None
        common = parameters_of(ranges, ranges.keys() - self.fixed.keys(), self.fixed)
        zeros = (Parameter(name, True, scale=LINEAR, quantity="length") for name in units)
        return Unknowns((*common, *zeros), {"w": _span(self.records[0].load) / (math.pi * radius), **units})

    def values(self, x: Array) -> dict[str, float]:
        """Modulus and tension and w and the zeros, SI."""
        values = self.unknowns.values(x)
        return values if self.length is None else values | {TENSION: self.length * values["modulus"] / 2}

    def loads(self, x: Array) -> list[Array]:
        """Loads [N] of all records."""
        values, each = self.values(x), zip(self.records, self.families, strict=True)
        kappa, s = 2 * values[TENSION] / values["modulus"], values["modulus"] / self.E_star
        return [
            family.loads(record.depth - values[f"delta0:{i}"], s, np.clip(kappa, *family.lengths), values["w"])
            for i, (record, family) in enumerate(each)
        ]

    def residuals(self, x: Array) -> Array:
        """Loads less those read, in units of each record's largest."""
        parts = zip(self.loads(x), self.records, strict=True)
        return np.concatenate([(load - record.load) / _span(record.load) for load, record in parts])

    def state(self, x: Array) -> State:
        return by_differences(self.residuals, x, np.full(x.size, TENSION_FIT_STEP))

    def best(self) -> Least:
        """The least of all searches: with 2 Ups/E* held at each start first, which leaves one minimum, then from the
        best of these; from all starts where E* or the tension is known."""
        low, high = zip(*(family.lengths for family in self.families), strict=True)  # of 2 Ups/E* [m]
        lengths = np.geomspace(max(low), min(high), TENSION_FIT_STARTS)
        starts: Sequence[tuple[float, Array | None]] = [(x, None) for x in lengths]
        if {"modulus", TENSION} <= set(self.unknowns.names):
            searches = [(replace(self, length=start).search(start), start) for start, _ in starts]
            best = sorted(searches, key=lambda item: item[0].cost)[:TENSION_FIT_FOLLOWED]
            starts = [(start, np.insert(least.x, 1, least.x[0] + math.log(start / 2))) for least, start in best]
        return min((self.search(*start) for start in starts), key=lambda least: least.cost)

    def search(self, start: float, x: Array | None = None) -> Least:
        """Least squares from 2 Ups/E* = ``start`` [m], and from the unknowns ``x`` where they are known."""
        if x is None:  # E* gives the first record its range of loads
            depth, load = _span(self.records[0].depth), _span(self.records[0].load)
            E = self.E_star * load / float(self.families[0].loads(np.array([depth]), 1.0, start, 0.0)[0])
            if TENSION in self.fixed:
                E = 2 * self.fixed[TENSION] / start
            tension, w = start * self.fixed.get("modulus", E) / 2, TENSION_FIT_WORK * self.unknowns.units["w"]
            zeros = {f"delta0:{i}": float(np.min(record.depth)) for i, record in enumerate(self.records)}
            x = self.unknowns.at({"modulus": E, TENSION: tension, "w": w, **zeros})
        try:
            bounds = self.unknowns.bounds(np.zeros(x.size), TENSION_FIT_FARTHEST)
            return LeastSquares(self.state, bounds).least(x)
        except ValueError as error:
            raise SolveError(f"fit of surface tension: {error}") from None


def _result(model: _Model, best: Least, radii: Sequence[float], level: float) -> TensionFit:
    several, unknowns = len(set(radii)) > 1, model.unknowns
    intervals = Intervals.of(unknowns, best, level)
    if (spread := intervals.covariance) is None:
        raise SolveError("fit of surface tension: the force curves do not determine the unknowns: --fix one of them")
    estimates = [_work(intervals, item) if item.name == "w" and item.free else item for item in intervals.estimates()]
    estimates[0] = replace(estimates[0], name=ALIAS)
    if TENSION in unknowns.names and not several:
        estimates[1] = replace(estimates[1], error=None, low=None, high=None)
    zeros = {f"delta0:{i}": f"delta0:{record.name}" for i, record in enumerate(model.records)}
    fit = TensionFit(
        estimates=tuple(replace(item, name=zeros.get(item.name, item.name)) for item in estimates),
        free=tuple(zeros.get(name, name) for name in unknowns.names),
        covariance=spread, dof=best.dof, level=level, records=model.records, loads=tuple(model.loads(best.x)),
        scatter=math.sqrt(best.variance) * float(np.mean([_span(record.load) for record in model.records])),
    )  # fmt: skip

    # The two unknowns that correlate most with the tension, as one radius does not separate them, and how much
    mixed = dict[str, float]()
    warnings = [f"{record.where}: {line}" for record in model.records for line in record.doubts]
    if TENSION in fit.free and fit.correlation is not None and not several:
        i = fit.free.index(TENSION)
        others = sorted((-abs(float(c)), name) for c, name in zip(fit.correlation[i], fit.free, strict=True))[1:3]
        mixed = {word(name): -c for c, name in others}
        worst = " and ".join(f"{name} ({c:.3f})" for name, c in mixed.items())
        warnings.append(
            f"force curves of one radius do not separate surface_tension from {worst} (correlation; "
            f"standard error {math.sqrt(spread[i, i]):.0%} if the model were exact): add force curves of "
            "another radius (--tip-radius), or --fix one of them"
        )
    values = model.values(best.x)
    if (w := values["w"]) > 0 and (theta := edge_angle(w, values[TENSION])) > LIMITS.edge_angle:
        warnings.append(
            f"theta = sqrt(2 w/Ups) = {theta:.3g} rad (w = {show(w, 'work')}) is above {LIMITS.edge_angle:g}: slopes "
            "are not small"
        )
    return replace(fit, mixed=mixed, warnings=tuple(warnings))


def _work(intervals: Intervals, item: FittedValue) -> FittedValue:
    """w by its profile: the load of a row next to the loss of contact changes like a root of w, whose slope would claim
    more than the row shows."""
    w = next(one for one in intervals.quantities if one.name == "w")
    ends = intervals.end(w, -intervals.t), intervals.end(w, intervals.t)
    low, high = (plain if end is None else end for plain, end in zip((item.low, item.high), ends, strict=True))
    assert low is not None
    assert high is not None
    error = (high - low) / (2 * intervals.t)
    if low <= 0:
        low, high = 0.0, intervals.end(w, ONE_SIDED * intervals.t) or high
    return replace(item, value=max(item.value, 0.0), error=error, low=low, high=high)

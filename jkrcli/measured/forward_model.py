"""The adhesive curves of one body for every modulus factor s and every work of adhesion w: D, T, H, V of Eq. 13 over
the contact radius (``formulas``), which give delta and P with v = sqrt(w/s) where the edge moves.

While the contact grows it advances with w_a, while it shrinks it recedes with w_r >= w_a; between the two it rests at
the contact radius a_m of the turn, sqrt(w_a/s) <= v <= sqrt(w_r/s): on (delta, P) a straight line.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.finite_range import AttractedBody, Broken, FiniteRangeBody, RangeRequest, leaps_of
from ..adhesion.slopes import Slopes, slopes
from ..base.errors import InputError, JkrError, Refusal, SolveError
from ..base.numerics import (
    LOOKED_AT,
    MOST_STEPS,
    ROUNDED,
    ROWS,
    SAME,
    UNSEEN,
    Array,
    PiecewiseCubic,
    PiecewisePolynomial,
)
from ..base.process import REMEMBERED
from ..base.units import show
from ..bodies.indenters import Indenter
from ..bodies.problem import RADIUS, Loading, Problem, changed, layer_names, nominal, without_side_walls
from ..case.models import Case, load_case
from ..case.store import read_solution, solve
from ..formulas import adhesive
from ..methods.integral.finite_range import Attraction, Discs, Rims, refuse_narrow
from ..methods.layered.solver import Layered
from ..methods.protocol import Limits
from ..resolve.analysis import JKR, nonadhesive
from ..series import Series, Solution

FUNCTIONS = 4  # theory: D, T, H, V
ADVANCING, RESTING, RECEDING = range(3)  # what the edge does at a row
LOADS = np.array([[0.0], [0.0], [1.0], [1.0]])  # of these the parts of the load


@dataclass(frozen=True, eq=False)
class Family:
    """log D, log T, log H, log V over u = log a (a in m) with two derivatives; power laws beyond the ends.

    ``low, high``: log of the smallest and largest contact radius of the series. ``rates``: derivatives of the same four
    logs by those of the body's own parameters that vary, by name.
    """

    logs: PiecewisePolynomial
    low: float
    high: float
    rates: Mapping[str, PiecewisePolynomial] | None = None

    @classmethod
    def of(cls, series: Series, slopes: Slopes) -> Family:
        """The family of a series, at the nodes of its own evaluator: cubics with a straight line added at each end, far
        enough for any foot point, which give values, first and second derivatives in one evaluation."""
        body = Nonadhesive(series, slopes)
        u = body.logs.slopes.x
        a = np.clip(np.exp(u), series.a[0], series.a[-1])
        here, rate = body.with_rates(a)
        values = np.stack([here.delta_H, here.t, here.P_H, here.S * here.t], axis=1)
        rates = np.stack([rate.delta_H, rate.t, rate.P_H, rate.S * here.t + here.S * rate.t], axis=1)
        inner = PiecewiseCubic(u, np.log(values), a[:, None] * rates / values)
        ends, width = u[[0, -1]], u[-1] - u[0] + 1
        before, after = np.zeros((2, *inner.c.shape[::2]))
        before[2:] = inner(ends[0], 1), inner(ends[0]) - width * inner(ends[0], 1)
        after[2:] = inner(ends[1], 1), inner(ends[1])
        c = np.concatenate([before[:, None], inner.c, after[:, None]], axis=1)
        x, zero = np.concatenate([[ends[0] - width], u, [ends[1] + width]]), np.zeros_like(c[:1])
        first, second = (np.concatenate([*[zero] * n, PiecewisePolynomial(x, c).derivative(n).c]) for n in (1, 2))
        return cls(PiecewisePolynomial(x, np.concatenate([c, first, second], 2)), float(u[0]), float(u[-1]))

    @property
    def plain(self) -> Family:
        return self

    def member(self, values: Mapping[str, float], drift: Drift | None = None) -> JKRMember:
        return JKRMember(self, values["modulus"], values["w"], drift)

    def neck(self, s: float, w: float) -> float:
        """What adhesion adds to the displacement where the load is least [m], for JKR."""
        _, T, H, V = self.at(np.linspace(self.low, self.high, ROWS))[0]
        return float(np.sqrt(w / s) * T[np.argmin(s * H - np.sqrt(w * s) * V)])

    @property
    def natural_work(self) -> float:
        """The w [J/m^2] that shifts the body at half of its largest radius by its own displacement."""
        D, T, _, _ = self.at(np.array([self.high - np.log(2)]))[0][:, 0]
        return float((D / T) ** 2)

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        """(D, T, H, V) and their first and second derivatives by u, each of shape (4, n)."""
        logs = self.logs(u).T
        values = np.exp(logs[:FUNCTIONS])
        first, second = logs[FUNCTIONS : 2 * FUNCTIONS], logs[2 * FUNCTIONS :]
        return values, values * first, values * (second + first**2)

    def values(self, u: Array) -> Array:
        """(D, T, H, V) alone, (4, n)."""
        logs = PiecewisePolynomial(self.logs.x, np.ascontiguousarray(self.logs.c[..., :FUNCTIONS]))
        return np.exp(logs(u).T)

    def at_nodes(self, u: Array) -> Array:
        """The same as ``at`` at evenly spaced nodes, (4, 3, nodes)."""
        return np.stack(self.at(u), axis=1)

    def own_rates(self, u: Array) -> Mapping[str, Array]:
        """Derivatives of log (D, T, H, V) (4, n) by the logs of the body's own parameters."""
        return {name: rate(u).T for name, rate in (self.rates or {}).items()}


@dataclass(frozen=True)
class Drift:
    """w and the moduli times 1 + change times the place on the record: 0 at the contact radius ``low``, 1 at ``high``
    [m], less ``centre``."""

    name: str
    change: float
    centre: float
    low: float
    high: float

    def factor(self, a: Array) -> Array:
        """What w or the moduli are multiplied by at contact radii ``a`` [m]; even beyond the record."""
        return 1 + self.change * (np.clip((a - self.low) / (self.high - self.low), -0.2, 1.2) - self.centre)

    def applied(self, functions: tuple[Array, Array, Array], u: Array) -> tuple[Array, Array, Array]:
        """The family's functions (D, T, H, V) and their derivatives by u = log a with this drift."""
        a, factor = np.exp(u), self.factor(np.exp(u))
        rate = self.change * a / (self.high - self.low) / factor
        power = np.array(DRIFTS[self.name])[:, None]
        first, second = power * rate, power * rate * (1 - rate)
        value, by_u, by_uu = functions
        g = factor**power
        return g * value, g * (by_u + first * value), g * (by_uu + 2 * first * by_u + (second + first**2) * value)


DRIFTS = {"w": (0.0, 0.5, 0.0, 0.5), "modulus": (0.0, -0.5, 1.0, 0.5)}  # theory: powers of w and moduli in the family


def states(a: Array | float, functions: Array, s: float, v: Array | float) -> Array:
    """(a, delta, P) of functions (D, T, H, V), or derivatives of them: v = sqrt(w/s) where the edge moves."""
    delta, P = adhesive(functions, s, v)
    all_three = np.empty((3, *delta.shape))
    all_three[0], all_three[1], all_three[2] = a, delta, P
    return all_three


def of_v(functions: Array, s: float, v: Array | float) -> Array:
    """Derivatives of the ``states`` by the log of v."""
    _, T, _, V = functions
    return states(0.0, np.stack([0 * T, T, 0 * T, V]), s, v)


@dataclass(frozen=True, eq=False)
class JKRMember:
    """The curve of a ``family`` for the modulus factor ``s`` and the work of adhesion ``w`` [J/m^2], over u = log a;
    ``drift``: of w or of the moduli along the record."""

    family: Family
    s: float
    w: float
    drift: Drift | None

    @property
    def v(self) -> float:
        return math.sqrt(self.w / self.s)

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        whole = np.linspace(self.family.low - below_fold, self.family.high, ROWS)
        (D, T, _, _), _, _ = self.family.at(whole)
        fold = whole[np.argmin(D - self.v * T)]
        below = fold - below_fold if least is None else min(fold - below_fold, np.log(least))
        return float(max(below, whole[0])), self.family.high + beyond_last

    def functions(self, u: Array) -> tuple[Array, Array, Array]:
        """(D, T, H, V) and their derivatives by u."""
        functions = self.family.at(u)
        return functions if self.drift is None else self.drift.applied(functions, u)

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        first, second, third = (states(np.exp(u), functions, self.s, self.v) for functions in self.functions(u))
        return first, second, third

    def rates(self, u: Array) -> Mapping[str, Array]:
        here = self.functions(u)[0]
        by_v, own = of_v(here, self.s, self.v), self.family.own_rates(u)
        rates = {name: states(0.0, here * rate, self.s, self.v) for name, rate in own.items()}
        by_w = by_v / (2 * self.w) if self.w > 0 else 0 * by_v  # a free w stays above 0
        return rates | {"modulus": states(0.0, here * LOADS, self.s, self.v) - by_v / 2, "w": by_w}


@dataclass(frozen=True, eq=False)
class RestingMember:
    """The readings of an edge at rest at contact radius ``turn`` [m] for moduli times ``s``, over u = v/``unit``."""

    family: Family
    s: float
    turn: float
    drift: Drift | None

    @cached_property
    def functions(self) -> tuple[Array, Array]:
        """(D, T, H, V) at the turn, and their derivatives by its log, (4, 1)."""
        return JKRMember(self.family, self.s, 0.0, self.drift).functions(np.log([self.turn]))[:2]

    @property
    def unit(self) -> float:
        """The v that shifts the contact by its own displacement."""
        D, T, _, _ = self.functions[0][:, 0]
        return float(D / T)

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        return -1.0, 3.0  # several times what a stable edge holds

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        here = states(self.turn, self.functions[0], self.s, self.unit * u)
        return here, np.broadcast_to(of_v(self.functions[0], self.s, self.unit), here.shape), np.zeros_like(here)

    def rates(self, u: Array) -> Mapping[str, Array]:
        here, by_turn = self.functions
        changes = {name: here * rate for name, rate in self.family.own_rates(np.log([self.turn])).items()}
        changes["modulus"] = here * LOADS
        rates = {name: states(0.0, by, self.s, self.unit * u) for name, by in changes.items()}
        return rates | {"a_turn": states(self.turn, by_turn, self.s, self.unit * u)}


# --------------------------------------------------------------------------------------------------
# The adhesive curves of finite range of one body for every modulus factor, work of adhesion and range.
#
# With all moduli multiplied by s a curve is delta(c; sigma/s, range) and P = s p(c; sigma/s, range). The contact
# radii stand in a fixed row, for which the kernel is inverted once: each pair of tension and range asks for c alone.

# Points of the curves, and steps of their derivatives by tension and range.
FAMILY_BEYOND = 1.4  # choice: of the largest over the end of the series, on the way to a solution
FAMILY_BELOW_LIMIT = 0.9  # choice: of the largest over the end of profile or cylinder
# tuned on fits of tables, by `make constants`: of the radius to which the kernel is known over the largest of
# contact; its growth
FAMILY_REACH = 1.5
FAMILY_BELOW = 8  # choice: radii below the smallest, evenly from 0 on: of a short range c0 is as small
# Radii on either side of a bend of the profile, where splines end, up to a part of its own; theory: there F goes with
# the power 3/2 of the distance
FAMILY_BESIDE = 16  # theory: twice from one to the next
FAMILY_NEAREST = 1e-5  # theory: of the farthest; its power 3/2 is 3e-8
FAMILY_AROUND = 0.2  # choice: two rows beyond
FAMILY_APART = 24  # choice: points without contact
FAMILY_FIRST = 0.03  # theory: c of the first of them over c at first touch: P goes like its square, 1e-3
FAMILY_DEGREE = 5  # theory: of the splines; errors fall with the power 6 of the spacing
FAMILY_NEAR_TOUCH = 1e-4  # theory: of a/c0: nearer the derivatives are those there, to its square
FAMILY_STEP = 1e-5  # theory: of logs, for central differences: the cube root of round-off


@dataclass(frozen=True)
class Resolution:
    """How finely the curves are resolved: the number of contact ``radii`` besides 0, the ``smallest`` of them over the
    largest, and the ``tolerance`` of the kernel."""

    radii: int
    smallest: float
    tolerance: float


FINE = Resolution(90, 3e-4, 1e-10)  # choice: splines through them are good to 1e-6 of the curve
COARSE = Resolution(45, 3e-3, 1e-6)  # choice: good to a thousandth of what a range changes, at a third of the cost


@dataclass(frozen=True, eq=False)
class DugdaleModel:
    """Curves of finite range of the bodies of a ``problem`` whose ``plain`` family has the series' radii."""

    problem: Problem
    plain: Family
    body: AttractedBody
    resolution: Resolution = FINE
    _ready: dict[float, tuple[Attraction, Discs]] = field(default_factory=dict)
    _curves: dict[tuple[float, float], States] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem, plain: Family, resolution: Resolution = FINE) -> DugdaleModel:
        return cls(problem, plain, AttractedBody(problem, resolution.tolerance), resolution)

    def member(self, values: Mapping[str, float], drift: Drift | None = None) -> DugdaleCurve:
        modulus, w = values["modulus"], values["w"]
        length = values["range"] if "range" in values else w / values["stress"]
        s = 2 * w / length / (self.problem.E_star * modulus)
        by_range = "range" in values
        return DugdaleCurve(self, modulus, w, s, length, by_range, self.states(s, length))

    @cached_property
    def radii(self) -> Array:
        """Contact radii of all curves [m], from 0 on."""
        end = math.exp(self.plain.high)
        most = max(end, min(FAMILY_BEYOND * end, FAMILY_BELOW_LIMIT * self.body.limit))
        a = np.geomspace(self.resolution.smallest * most, most, self.resolution.radii)
        a = np.append(np.linspace(0.0, a[0], FAMILY_BELOW, endpoint=False), a)
        steps = np.geomspace(FAMILY_NEAREST, 1, FAMILY_BESIDE)
        for bend in (bend for bend in self.problem.indenter.bends if bend < most):
            around = bend * (1 + FAMILY_AROUND * np.concatenate([-steps, [0.0], steps]))
            a = np.concatenate([a[np.abs(a / bend - 1) > FAMILY_AROUND], around[around < most]])
        return np.unique(a)

    def _reaching(self, s: float, gap: float) -> tuple[Attraction, Discs]:
        """Discs on a body known so far that the tension s = 2 sigma/E* opens the separation ``gap`` [m] at its end, or
        up to where it ends."""
        reach = FAMILY_REACH * float(self.radii[-1])
        for _ in range(MOST_STEPS):
            reach = min(reach, self.body.limit)
            if reach not in self._ready:
                attraction = self.body.attraction(reach)
                self._ready[reach] = attraction, attraction.discs(self.radii)
            attraction, discs = self._ready[reach]
            if reach == self.body.limit or (discs.rims(reach - self.radii, s).gap > gap).all():
                break
            reach *= FAMILY_REACH
        return attraction, discs

    def states(self, s: float, gap: float) -> States:
        """The curve for the tension s = 2 sigma/E* up to the separation ``gap`` [m], of twelve digits; solved once for
        many fits that ask for the same, whoever asks first."""
        key = float(f"{s:.12g}"), float(f"{gap:.12g}")
        if key not in self._curves:
            if len(self._curves) >= REMEMBERED:
                self._curves.clear()
            self._curves[key] = self._solved(*key)
        return self._curves[key]

    def _solved(self, s: float, gap: float) -> States:
        attraction, discs = self._reaching(s, gap)
        rims = discs.equilibria(s, gap, attraction.reach)
        refuse_narrow(rims)
        reached = np.isclose(rims.gap, gap, rtol=SAME, atol=0)  # of nanometres
        count = int(np.argmin(reached)) if not reached.all() else reached.size
        first, c = 0, rims.c[:count]
        if count > 1 and leaps_of(rims.a[:count], c).any():  # the curve begins beyond, from where on c rises
            first = 1 + int(np.max(np.flatnonzero(np.diff(c) <= 0), initial=-1))
        if count - first < 2 * (FAMILY_DEGREE + 1):  # twice as many points as a spline needs
            beyond = f"beyond {show(attraction.reach, 'length')}, where the profile or the specimen ends"
            raise SolveError(f"adhesion of finite range: with a range of {show(gap, 'length')} the surfaces attract "
                             f"each other {beyond}, or jump together: bound the range")  # fmt: skip
        rows, c0 = slice(first, count), float(rims.c[first])
        v = np.arcsinh(rims.a[rows] / c0)
        near = np.abs(rims.a[rows][1:-1, None] / np.array(self.problem.indenter.bends) - 1) < ROUNDED
        bends = np.flatnonzero(near.any(axis=1)) + 1  # of the profile, where splines end
        touching = Broken.through(v, np.stack([rims.a, rims.delta, rims.P], axis=1)[rows], bends)
        own = c0, (float(v[0]), float(v[-1])), touching, math.pi * self.problem.E_star * s / 2, gap
        apart = None
        if first == 0:  # delta without contact, and its part by the tension, over log c
            from scipy.interpolate import make_interp_spline

            edge = np.append(c0 * np.geomspace(FAMILY_FIRST, 1, FAMILY_APART)[:-1], c0)
            delta = np.append(attraction.apart(edge[:-1], s, gap).delta, rims.delta[0])
            pulled = delta + gap - self.problem.indenter.f(edge)
            apart = make_interp_spline(np.log(edge), np.stack([delta, pulled], axis=1), FAMILY_DEGREE)
        return States(*own, apart, partial(_rates, discs, rims, s, v, rows, bends))


def _rates(discs: Discs, rims: Rims, s: float, v: Array, rows: slice, bends: Array) -> Broken:
    """The spline over ``v`` of derivatives of log c, delta, P by the logs of tension and range at equal contact radii,
    (n, 6): those of states with a given width of the annulus, and of the width that keeps the separation at its end."""
    h, b = FAMILY_STEP, rims.c - rims.a

    def by(wider: float, stronger: float) -> Array:
        high, low = (discs.rims(b * math.exp(side * wider), s * math.exp(side * stronger)) for side in (1, -1))
        return np.stack([high.gap - low.gap, high.delta - low.delta, high.P - low.P]) / (2 * h)

    width, tension = by(h, 0.0), by(0.0, h)
    by_tension, by_range = -tension[0] / width[0], rims.gap / width[0]  # of log b
    columns = [by_tension * b / rims.c, *(tension[1:] + width[1:] * by_tension)]
    columns += [by_range * b / rims.c, *(width[1:] * by_range)]
    return Broken.through(v, np.stack(columns, axis=1)[rows], bends)


@dataclass(frozen=True, eq=False)
class States:
    """One curve of the unscaled body over u: log c to first touch at c0, log sqrt(c0^2 + a^2) beyond, as c may fall
    where the contact grows.

    ``touching``: (a, delta, P) over v = arsinh(a/c0), u = log(c0 cosh v), from one of the ``ends`` to the other;
    ``apart``: delta, and its part by the tension, over log c, where P = -``pull`` c^2 [N/m^2]; None where the surfaces
    leap together. ``gap``: the range [m]; ``make_rates``: the spline of the derivatives at equal radii over v."""

    c0: float
    ends: tuple[float, float]
    touching: Broken
    pull: float
    gap: float
    apart: Callable[..., Array] | None
    make_rates: Callable[[], Broken]

    @cached_property
    def _rates(self) -> Broken:
        return self.make_rates()

    @cached_property
    def _derivatives(self) -> tuple[Broken, Broken, Broken]:
        """``touching`` and its first and second derivatives."""
        first = self.touching.derivative()
        return self.touching, first, first.derivative()

    def _places(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Mask of the u in contact; u clipped to the end, u without contact, and v."""
        start, (first, last) = math.log(self.c0), self.ends
        inside = np.minimum(u, start + math.log(math.cosh(last)))
        inside = inside if self.apart is not None else np.maximum(inside, start + math.log(math.cosh(first)))
        v = np.clip(np.arccosh(np.exp(np.maximum(inside - start, 0.0))), first, last)
        touching = (inside > start) | (self.apart is None)
        return touching, inside, np.clip(inside, start + math.log(FAMILY_FIRST), start), v

    def rates(self, u: Array) -> tuple[Array, Array]:
        """Derivatives of (a, delta, P) at equal u by the logs of tension and range, (3, n) each."""
        touching, _, free, v = self._places(u)
        first = self.along(u)[1]
        columns, at_touch = np.moveaxis(self._rates(v), -1, 0), self._rates(np.array(self.ends[:1]))
        at_touch = at_touch / np.cosh(v)[:, None] ** 2
        pulled = np.zeros_like(u) if self.apart is None else self.apart(free)[..., 1]
        zero, P = np.zeros_like(u), -self.pull * np.exp(2 * free)
        outside = np.stack([zero, pulled, P]), np.stack([zero, np.full_like(u, -self.gap), zero])
        each = (at_touch[:, 0], columns[:3]), (at_touch[:, 3], columns[3:])  # of u at equal a: log c0 moves
        inside = (np.stack([zero, delta, load]) - first * moved for moved, (_, delta, load) in each)
        by_tension, by_range = (np.where(touching, a, b) for a, b in zip(inside, outside, strict=True))
        return by_tension, by_range

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """(a, delta, P) and their first and second derivatives by u, (3, n); straight lines beyond the end."""
        touching, inside, free, v = self._places(u)

        # Without contact, over log c
        zero, P = np.zeros_like(free), -self.pull * np.exp(2 * free)
        delta, first, second = (zero if self.apart is None else self.apart(free, order)[..., 0] for order in range(3))
        apart = np.stack([zero, delta, P]), np.stack([zero, first, 2 * P]), np.stack([zero, second, 4 * P])

        # In contact, over v: du/dv = tanh v
        v = np.maximum(v, FAMILY_NEAR_TOUCH)
        value, first, second = (np.moveaxis(spline(v), -1, 0) for spline in self._derivatives)
        rate = 1 / np.tanh(v)
        inner = value, first * rate, second * rate**2 - first * rate / np.sinh(v) ** 2
        value, first, second = (np.where(touching, b, a) for a, b in zip(apart, inner, strict=True))
        return value + first * (u - inside), first, np.where(u == inside, second, 0.0)


@dataclass(frozen=True, eq=False)
class DugdaleCurve:
    """The curve for one modulus factor, w [J/m^2] and law: s = 2 sigma/(E* modulus) up to ``length`` [m], over the u of
    its ``states``; ``by_range``: whether the range stands for the law, else its tension."""

    family: DugdaleModel
    modulus: float
    w: float
    s: float
    length: float
    by_range: bool
    states: States

    def refuse_beyond(self, a: float) -> None:
        """Refusal where the curve ends before the contact radius ``a`` [m]: beyond it attraction leaves the body."""
        if a > float(self.states.touching(np.array(self.states.ends[1:]))[0, 0]) * (1 + SAME):
            beyond = f"beyond {show(self.family.body.limit, 'length')}, where the profile or the specimen ends"
            raise Refusal(f"adhesion of finite range: around a contact of a = {show(a, 'length')} the surfaces attract "
                          f"each other {beyond}, at a range of {show(self.length, 'length')}: bound the range, or "
                          "leave out the largest loads")  # fmt: skip

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        start, (first, last) = math.log(self.states.c0), (math.log(math.cosh(v)) for v in self.states.ends)
        return start + (first if self.states.apart is None else math.log(FAMILY_FIRST)), start + last

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        value, first, second = (np.stack([a, delta, self.modulus * P]) for a, delta, P in self.states.along(u))
        return value, first, second

    def rates(self, u: Array) -> Mapping[str, Array]:
        unit = np.array([1.0, 1.0, self.modulus])[:, None]
        by_tension, by_length = (unit * rate for rate in self.states.rates(u))
        P = self.along(u)[0] * np.array([0.0, 0.0, 1.0])[:, None]
        if self.by_range:
            return {"modulus": P - by_tension, "w": by_tension / self.w, "range": by_length - by_tension}
        return {"modulus": P - by_tension, "w": by_length / self.w, "stress": by_tension - by_length}


# One adhesive curve of a body over u, the log of a place on it [m]. ``along``: its states (a [m], delta [m], P [N]) and
# their first and second derivatives by u, each (3, n). ``rates``: their derivatives (3, n) by the log of the modulus
# factor "modulus", by "w", and by the log of what else it depends on. ``ends``: u between which measured points are
# sought, so far beyond the fold and the end of the series, and down to the least radius that was measured.
Member: TypeAlias = JKRMember | RestingMember | DugdaleCurve
Members: TypeAlias = Family | DugdaleModel  # all curves of one body; ``plain``: its family without a range of adhesion


# --------------------------------------------------------------------------------------------------
# Radii at which the functions of a body are tabulated for the paths of a contact at a device (``branches``).

# How far.
DEVICE_PATH_BELOW = 4.0  # choice: of log a below the series, where its limit by power laws holds
DEVICE_PATH_BEYOND = 0.5  # choice: of log a above the series, tried while starting values are sought


def grid(family: Family) -> Array:
    """Logs of contact radii at which paths are tabulated; loads between them are good to 1e-7 of the largest."""
    return np.linspace(family.low - DEVICE_PATH_BELOW, family.high + DEVICE_PATH_BEYOND, LOOKED_AT)


@lru_cache(maxsize=REMEMBERED)
def on_grid(family: Family) -> Array:
    """The functions of a body there, as ``Family.at`` gives them, (3, 4, nodes)."""
    return family.at_nodes(grid(family)).swapaxes(0, 1)


# --------------------------------------------------------------------------------------------------
# The body whose curves are fitted: one family, or a family for every modulus and thickness of its layers.
#
# It comes from a case, which is solved on the way, or from a series that was solved before.

# How bodies are solved anew with other layers or to other radii.
RESOLVING_STEP = 1e-4  # theory: of logs of parameters, for derivatives: the square root of the solve's 1e-8
RESOLVING_ROUNDED = 0.01  # choice: of the same logs; derivatives at rounded values are remembered
RESOLVING_PER_DECADE = 20  # choice: radii to which a body is solved, so that many curves share one solve
RESOLVING_POINTS = 100  # choice: least radii of a series that is solved to another radius
RESOLVING_ADHERES = 1.2  # choice: of the contact radius without adhesion, what adhesion may make of it
RESOLVING_DEEP = 0.7  # choice: of the tip's radius, to which a body is solved before anything is fitted


@dataclass(frozen=True, eq=False)
class FittedBody:
    """A body whose measured curves are fitted, with its family of adhesive curves.

    ``problem``: bodies and nominal values; ``series``, ``slopes``: its nonadhesive solution, by any method.

    Only bodies that the method ``layered`` represents can be solved anew: ``with_values``. ``extensible``: may also be
    solved to other radii than those of the series. ``moduli_known``: whether the user gave the moduli of the problem;
    else they only stand in for a unit. ``tolerance``: of the solves, far below the noise of any record.
    ``range_of_case``: the range of adhesion of the case; ``no_range``: why the body has no curves of one.
    """

    problem: Problem
    series: Series
    slopes: Slopes
    family: Family
    extensible: bool = False
    moduli_known: bool = True
    tolerance: float = Layered.tolerance
    range_of_case: RangeRequest = JKR
    no_range: str = ""
    resolution: Resolution = FINE

    @classmethod
    def of(cls, problem: Problem, series: Series, slopes: Slopes, extensible: bool = False) -> FittedBody:
        return cls(problem, series, slopes, Family.of(series, slopes), extensible)

    def members(self, ranged: bool) -> Members:
        """The adhesive curves of the body, of finite range or JKR's."""
        return self.attracted if ranged else self.family

    @cached_property
    def nonadhesive(self) -> Nonadhesive:
        """The functions of the body without adhesion."""
        return Nonadhesive(self.series, self.slopes)

    @cached_property
    def attracted(self) -> DugdaleModel:
        """The adhesive curves of finite range; Refusal where the body has none."""
        if self.problem.sticks:
            raise Refusal("fit: adhesion of finite range is for frictionless contact only: give --surface sliding, or "
                          "leave range and stress out")  # fmt: skip
        if self.no_range:
            raise Refusal(self.no_range)
        return DugdaleModel.of(self.problem, self.family, self.resolution)

    @cached_property
    def coarse(self) -> FittedBody:
        """The same body with coarse curves of finite range."""
        return replace(self, resolution=COARSE)

    @property
    def layer_names(self) -> tuple[str, ...]:
        """Names of the layers as in the case, else their numbers from 1 at the contact; "base": the half-space."""
        return layer_names(self.problem.specimen)

    @property
    def own_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that need the body solved anew; none for a finite cylinder."""
        if self.problem.specimen.radius is not None:
            return ()
        layers = self.layer_names[: len(self.problem.specimen.layers)]
        return (*(f"E:{name}" for name in self.layer_names), *(f"h:{name}" for name in layers))

    def moduli(self, s: float) -> dict[str, float]:
        """E* and the moduli of all layers [Pa] by name, those of the problem times ``s``; of an indenter that is
        elastic too, which is scaled with them, E* alone."""
        problem = self.problem
        materials = () if problem.indenter.material is not None else problem.specimen.materials
        own = {f"E:{name}": s * one.surface.E for name, one in zip(self.layer_names, materials, strict=False)}
        return {"E_star": s * problem.E_star, **own}

    def nominal(self, name: str) -> float:
        """The value of "E:layer" [Pa], "h:layer" [m], "nu:layer" or "radius" [m] in the problem."""
        if name == RADIUS:
            return float(cast(Any, self.problem.indenter).R)
        return nominal(self.problem.specimen, name)

    def with_values(self, values: dict[str, float]) -> FittedBody:
        """The body solved anew by ``layered`` at the same radii with other ``values`` ("E:film": 2e6, ...), if any."""
        if not values:
            return self
        problem = changed(self.problem, values)
        return replace(self, problem=problem, family=self._solved(problem))

    def rated(self, values: dict[str, float], varied: Sequence[str]) -> FittedBody:
        """The body of ``with_values`` with the family's derivatives by the logs of the values of ``varied``.

        They are taken at rounded values, so that steps near the solution need no more solves for them.
        """
        logs = {name: RESOLVING_ROUNDED * round(math.log(value) / RESOLVING_ROUNDED) for name, value in values.items()}
        body, near = self.with_values(values), {name: math.exp(log) for name, log in logs.items()}
        base, rates = self._solved(changed(self.problem, near)).logs, {}
        for name in varied:
            moved = self._solved(changed(self.problem, near | {name: near[name] * math.exp(RESOLVING_STEP)})).logs
            rates[name] = PiecewisePolynomial(base.x, (moved.c - base.c)[..., :FUNCTIONS] / RESOLVING_STEP)
        return replace(body, family=replace(body.family, rates=rates))

    def on_surface(self, surface: str) -> FittedBody:
        """The same body whose surfaces are "sliding" or "sticking": solved anew by ``layered`` where they were not."""
        if surface == self.problem.surface:
            return self
        if self.problem.specimen.radius is not None:
            raise InputError("fit: --surface: a finite cylinder is not solved anew: give the solution of a case with "
                             "the other specimen.surface")  # fmt: skip
        other = self._reaching(float(self.series.a[-1]), sticks=surface == "sticking")
        return replace(other, extensible=self.extensible)

    def to_radius(self, a: float) -> FittedBody:
        """The same problem solved by ``layered`` up to contact radius ``a`` [m] or little more, with as many points."""
        if a >= (end := self.problem.indenter.r_max):
            raise InputError(f"the data need a contact radius of {show(a, 'length')}, beyond the indenter, which ends "
                             f"at {show(end, 'length')}: check the units of displacement and load, and the size of the "
                             "indenter")  # fmt: skip
        rounded = 10 ** (math.ceil(math.log10(a) * RESOLVING_PER_DECADE) / RESOLVING_PER_DECADE)
        return self._reaching(rounded if rounded < end else a)

    def down_to(self, a: float) -> FittedBody:
        """The same problem solved from the contact radius ``a`` [m] on, in proportion below the series' own."""
        first, a0 = float(self.series.a[0]), self.series.a0
        steps = math.ceil(math.log10((first - a0) / (a - a0)) * RESOLVING_PER_DECADE)
        below = a0 + (a - a0) * np.geomspace(1.0, (first - a0) / (a - a0), steps, endpoint=False)
        return self.on(Loading.given("radius", (*below.tolist(), *self.series.a.tolist())))

    def under(self, indenter: Indenter, a: float) -> FittedBody:
        """The same specimen under another ``indenter``, solved to the contact radius ``a`` [m] and beyond."""
        return self._reaching(min(max(a, float(self.series.a[-1])), indenter.r_max * (1 - ROUNDED)), indenter=indenter)

    def to_depth(self, depth: float) -> FittedBody:
        """The same problem solved to the contact radius at a ``depth`` [m], where it may be; beyond the series it is
        estimated by continuation, as far as below it."""
        # logs of contact radii, beyond the series too
        u = np.linspace(self.family.low, self.family.high + DEVICE_PATH_BELOW, ROWS)
        reached = np.flatnonzero(self.family.at(u)[0][0] <= depth)
        tip, a = self.problem.indenter, math.exp(u[reached[-1]]) if reached.size else 0.0
        a = RESOLVING_ADHERES * a if RESOLVING_ADHERES * a < tip.r_max else a
        endless = tip.kinks and math.isinf(tip.r_max)  # a rounded cone: R is that of its end alone
        a = a if tip.tip_radius is None or endless else min(a, RESOLVING_DEEP * tip.tip_radius)
        return self.to_radius(a) if self.extensible and a > self.series.a[-1] else self

    def _reaching(self, a: float, **changes: Any) -> FittedBody:
        """The body of a changed problem solved up to contact radius ``a`` [m], as the user describes this one."""
        return _reached(self, a, frozenset(changes.items()))

    def on(self, loading: Loading, **changes: Any) -> FittedBody:
        """The body of a changed problem under another ``loading``, as the user describes this one."""
        other = _exact(replace(without_side_walls(self.problem), loading=loading, **changes), self.tolerance)
        return replace(other, **{name: getattr(self, name) for name in ("moduli_known", "range_of_case", "no_range")})

    def _solved(self, problem: Problem) -> Family:
        at_radii = Loading.given("radius", tuple(self.series.a))
        return solved(replace(without_side_walls(problem), loading=at_radii), self.tolerance)


@lru_cache(maxsize=REMEMBERED)
def _reached(body: FittedBody, a: float, changes: frozenset[tuple[str, Any]]) -> FittedBody:
    """That of ``body`` with ``changes`` of its problem up to contact radius ``a`` [m]: one for all curves of a map."""
    return body.on(Loading("radius", a, max(len(body.series), RESOLVING_POINTS), "radius"), **dict(changes))


@lru_cache(maxsize=REMEMBERED)
def _exact(problem: Problem, tolerance: float) -> FittedBody:
    series = Layered(tolerance)(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"), True)


@lru_cache(maxsize=REMEMBERED)
def solved(problem: Problem, tolerance: float) -> Family:
    """The family of a problem by ``layered``, at a coarser tolerance where it cannot be solved to this one.

    SolveError where it cannot be solved, with the reason.
    """
    for coarser in (tolerance, *(one for one in (SAME, UNSEEN) if one > tolerance)):
        try:
            return _exact(problem, coarser).family
        except JkrError as error:
            reason = str(error)
    raise SolveError(f"the body could not be solved anew: {reason}")


def for_each(radii: Sequence[float], count: int) -> list[float]:
    """The tip radius [m] of each of ``count`` files, where one was given for each, or one for all; none where none
    was."""
    if len(radii) not in (0, 1, count):
        raise InputError(f"fit: --tip-radius: give one for each of the {count} files, or one for all, got {len(radii)}")
    return list(radii) * (count // len(radii)) if radii else []


def refuse_full_end(body: FittedBody) -> FittedBody:
    """The ``body``; InputError where records under its indenter are not fitted."""
    if body.problem.indenter.rim < math.inf:
        raise InputError(
            "fit: records of a flat punch are not fitted: its P/delta is S (jkr show); w follows from the pull-off "
            "force (jkr pull-off --load) or from P and a (jkr work)"
        )
    return body


def body_of(
    source: Case | Problem | Solution | str | Path, rule: str = "auto", limits: Limits | None = None
) -> FittedBody:
    """The body of a case, a problem, a solution, or a file, its slopes by ``rule``. A case may be solved anew to the
    radii that the data need, which has exact slopes; a solution, and what has others, ends where it ends."""
    if isinstance(source, str | Path):
        source = load_case(source) if Path(source).suffix == ".toml" else read_solution(source)
    if isinstance(source, Solution):
        functions, solution, extensible = nonadhesive(source, rule), source, False
        series, own = functions.series, functions.slopes
    else:
        _, solution = solve(source, limits=limits)
        series, own = solution.series, slopes(solution.series, rule)
        extensible = solution.problem.specimen.radius is None and rule in ("auto", "exact")
    refused = ""
    try:
        FiniteRangeBody.of(solution)
    except Refusal as error:  # it has no curves of one
        refused = str(error)
    body = FittedBody.of(solution.problem, series, own, extensible)
    return replace(body, range_of_case=RangeRequest.of(solution.record), no_range=refused)

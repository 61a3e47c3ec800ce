"""The adhesive curves of finite range of one body for every modulus factor, work of adhesion and range.

With all moduli multiplied by s a curve is delta(c; sigma/s, range) and P = s p(c; sigma/s, range). The contact radii
stand in a fixed row, for which the kernel is inverted once: each pair of tension and range asks for c alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from ...base import MOST_STEPS, REMEMBERED, SAME, Array, Refusal, SolveError, show
from ...bodies import Problem
from ...methods import AttractedBody
from ...methods.integral import Attraction, Discs, Rims, refuse_narrow
from .family import Drift, Family


@dataclass(frozen=True)
class AttractedFamilyTuning:
    """Points of the curves, and steps of their derivatives by tension and range."""

    beyond: float = 1.4  # choice: of the largest over the end of the series, on the way to a solution
    below_limit: float = 0.9  # choice: of the largest over the end of profile or cylinder
    # tuned on fits of tables, by `make constants`: of the radius to which the kernel is known over the largest of
    # contact; its growth
    reach: float = 1.5
    apart: int = 24  # choice: points without contact
    first: float = 0.03  # theory: c of the first of them over c at first touch: P goes like its square, 1e-3
    degree: int = 5  # theory: of the splines; errors fall with the power 6 of the spacing
    near_touch: float = 1e-4  # theory: of arcosh sqrt(c/c0): nearer the derivatives are those there, to its square
    step: float = 1e-5  # theory: of logs, for central differences: the cube root of round-off


TUNING = AttractedFamilyTuning()


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
class AttractedFamily:
    """Curves of finite range of the bodies of a ``problem`` whose ``plain`` family has the series' radii."""

    problem: Problem
    plain: Family
    body: AttractedBody
    resolution: Resolution = FINE
    _ready: dict[float, tuple[Attraction, Discs]] = field(default_factory=dict)
    _curves: dict[tuple[str, str], States] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem, plain: Family, resolution: Resolution = FINE) -> AttractedFamily:
        return cls(problem, plain, AttractedBody(problem, resolution.tolerance), resolution)

    def member(self, values: Mapping[str, float], drift: Drift | None = None) -> AttractedMember:
        modulus, w = values["modulus"], values["w"]
        length = values["range"] if "range" in values else w / values["stress"]
        s = 2 * w / length / (self.problem.E_star * modulus)
        by_range = "range" in values
        return AttractedMember(self, modulus, w, s, length, by_range, self.states(s, length))

    @cached_property
    def radii(self) -> Array:
        """Contact radii of all curves [m], from 0 on."""
        end = math.exp(self.plain.high)
        most = max(end, min(TUNING.beyond * end, TUNING.below_limit * self.body.limit))
        return np.append(0.0, np.geomspace(self.resolution.smallest * most, most, self.resolution.radii))

    def _discs(self, reach: float) -> tuple[Attraction, Discs]:
        if reach not in self._ready:
            attraction = self.body.attraction(reach)
            self._ready[reach] = attraction, attraction.discs(self.radii)
        return self._ready[reach]

    def _reaching(self, s: float, gap: float) -> tuple[Attraction, Discs]:
        """Discs on a body known so far that the tension s = 2 sigma/E* opens the separation ``gap`` [m] at its end, or
        up to where it ends."""
        reach = TUNING.reach * float(self.radii[-1])
        for _ in range(MOST_STEPS):
            reach = min(reach, self.body.limit)
            attraction, discs = self._discs(reach)
            if reach == self.body.limit or (discs.rims(reach - self.radii, s).gap > gap).all():
                break
            reach *= TUNING.reach
        return attraction, discs

    def states(self, s: float, gap: float) -> States:
        """The curve for the tension s = 2 sigma/E* up to the separation ``gap`` [m]; solved once for many fits that ask
        for the same."""
        key = f"{s:.12g}", f"{gap:.12g}"
        if key not in self._curves:
            if len(self._curves) >= REMEMBERED:
                self._curves.clear()
            self._curves[key] = self._solved(s, gap)
        return self._curves[key]

    def _solved(self, s: float, gap: float) -> States:
        attraction, discs = self._reaching(s, gap)
        rims = discs.equilibria(s, gap, attraction.reach)
        refuse_narrow(rims)
        reached = np.isclose(rims.gap, gap, rtol=SAME, atol=0)  # of nanometres
        count = int(np.argmin(reached)) if not reached.all() else reached.size
        first = 1 + int(np.max(np.flatnonzero(np.diff(rims.c[:count]) <= 0), initial=-1))
        if count - first < 2 * (TUNING.degree + 1):  # twice as many points as a spline needs
            raise SolveError(
                f"adhesion of finite range: with a range of {show(gap, 'length')} the surfaces attract each other "
                f"beyond {show(attraction.reach, 'length')}, where profile or side end, or jump together: bound the "
                "range"
            )
        rows, c0 = slice(first, count), float(rims.c[first])
        v = np.arccosh(np.sqrt(rims.c[rows] / c0))
        touching = make_interp_spline(v, np.stack([rims.a, rims.delta, rims.P], axis=1)[rows], TUNING.degree)
        own = c0, float(v[-1]), touching, math.pi * self.problem.E_star * s / 2, gap
        apart = self._apart(attraction, rims, s, gap) if first == 0 else None
        return States(*own, apart, partial(_rate_spline, discs, rims, s, v, rows))

    def _apart(self, attraction: Attraction, rims: Rims, s: float, gap: float) -> BSpline:
        """delta without contact, and its part by the tension, over log c."""
        c = np.append(rims.c[0] * np.geomspace(TUNING.first, 1, TUNING.apart)[:-1], rims.c[0])
        delta = np.append(attraction.apart(c[:-1], s, gap).delta, rims.delta[0])
        pulled = delta + gap - self.problem.indenter.f(c)
        return make_interp_spline(np.log(c), np.stack([delta, pulled], axis=1), TUNING.degree)


def _rate_spline(discs: Discs, rims: Rims, s: float, v: Array, rows: slice) -> BSpline:
    return make_interp_spline(v, _rates(discs, rims, s)[rows], TUNING.degree)


def _rates(discs: Discs, rims: Rims, s: float) -> Array:
    """Derivatives of log c, delta, P by the logs of tension and range at equal contact radii, (n, 6): those of states
    with a given width of the annulus, and of the width that keeps the separation at its end."""
    h, b = TUNING.step, rims.c - rims.a

    def by(wider: float, stronger: float) -> Array:
        high, low = (discs.rims(b * math.exp(side * wider), s * math.exp(side * stronger)) for side in (1, -1))
        return np.stack([high.gap - low.gap, high.delta - low.delta, high.P - low.P]) / (2 * h)

    width, tension = by(h, 0.0), by(0.0, h)
    by_tension, by_range = -tension[0] / width[0], rims.gap / width[0]  # of log b
    columns = [by_tension * b / rims.c, *(tension[1:] + width[1:] * by_tension)]
    columns += [by_range * b / rims.c, *(width[1:] * by_range)]
    return np.stack(columns, axis=1)


@dataclass(frozen=True, eq=False)
class States:
    """One curve of the unscaled body: ``touching``: (a, delta, P) over v = arcosh sqrt(c/c0) up to ``end``; ``apart``:
    delta, and its part by the tension, over log c, where P = -``pull`` c^2 [N/m^2]; None where the surfaces leap
    together to c0. ``gap``: the range [m]; ``make_rates``: the spline of the derivatives at equal radii over v."""

    c0: float
    end: float
    touching: BSpline
    pull: float
    gap: float
    apart: BSpline | None
    make_rates: Callable[[], BSpline]

    @cached_property
    def _rates(self) -> BSpline:
        return self.make_rates()

    def _places(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Which u lie in contact; u up to the end, u without contact, and v."""
        start = math.log(self.c0)
        inside = np.minimum(u, start + 2 * math.log(math.cosh(self.end)))
        inside = inside if self.apart is not None else np.maximum(inside, start)
        v = np.minimum(np.arccosh(np.exp(np.maximum(inside - start, 0.0) / 2)), self.end)
        touching = (inside > start) | (self.apart is None)
        return touching, inside, np.clip(inside, start + math.log(TUNING.first), start), v

    def rates(self, u: Array) -> tuple[Array, Array]:
        """Derivatives of (a, delta, P) at equal u by the logs of tension and range, (3, n) each."""
        touching, _, free, v = self._places(u)
        first = self.along(u)[1]
        columns = np.moveaxis(self._rates(v), -1, 0)
        pulled = np.zeros_like(u) if self.apart is None else self.apart(free)[..., 1]
        zero, P = np.zeros_like(u), -self.pull * np.exp(2 * free)
        outside = np.stack([zero, pulled, P]), np.stack([zero, np.full_like(u, -self.gap), zero])
        inside = ((np.stack([zero, delta, load]) - first * log_c) for log_c, delta, load in (columns[:3], columns[3:]))
        by_tension, by_range = (np.where(touching, a, b) for a, b in zip(inside, outside, strict=True))
        return by_tension, by_range

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """(a, delta, P) and their first and second derivatives by u = log c, (3, n); straight lines beyond the end."""
        touching, inside, free, v = self._places(u)
        parts = zip(self._free(free), self._in_contact(np.maximum(v, TUNING.near_touch)), strict=True)
        value, first, second = (np.where(touching, b, a) for a, b in parts)
        return value + first * (u - inside), first, np.where(u == inside, second, 0.0)

    def _in_contact(self, v: Array) -> tuple[Array, Array, Array]:
        value, first, second = (np.moveaxis(self.touching(v, order), -1, 0) for order in range(3))
        rate = 1 / (2 * np.tanh(v))
        return value, first * rate, second * rate**2 - first * rate / (2 * np.sinh(v) ** 2)

    def _free(self, u: Array) -> tuple[Array, Array, Array]:
        zero, P = np.zeros_like(u), -self.pull * np.exp(2 * u)
        delta, first, second = (zero if self.apart is None else self.apart(u, order)[..., 0] for order in range(3))
        return np.stack([zero, delta, P]), np.stack([zero, first, 2 * P]), np.stack([zero, second, 4 * P])


@dataclass(frozen=True, eq=False)
class AttractedMember:
    """The curve for one modulus factor, w [J/m^2] and law: s = 2 sigma/(E* modulus) up to ``length`` [m], over u = log
    c; ``by_range``: whether the range stands for the law, else its tension."""

    family: AttractedFamily
    modulus: float
    w: float
    s: float
    length: float
    by_range: bool
    states: States

    def refuse_beyond(self, a: float) -> None:
        """Refusal where the curve ends before the contact radius ``a`` [m]: beyond it attraction leaves the body."""
        if a > float(self.states.touching(self.states.end)[0]) * (1 + SAME):
            raise Refusal(
                f"adhesion of finite range: around a contact of a = {show(a, 'length')} the surfaces attract each "
                f"other beyond {show(self.family.body.limit, 'length')}, where profile or side end, at a range of "
                f"{show(self.length, 'length')}: bound the range, or leave out the largest loads"
            )

    def ends(self, below_fold: float, beyond_last: float, least: float | None) -> tuple[float, float]:
        start = math.log(self.states.c0)
        first = start if self.states.apart is None else start + math.log(TUNING.first)
        return first, start + 2 * math.log(math.cosh(self.states.end))

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

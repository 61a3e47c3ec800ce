"""Adhesive curves of finite range: a constant tension up to a separation, on any body whose kernel is known.

Between JKR (a short range) and DMT (a long one); Maugis (1992) on a half-space. The curve is complete: from the bodies
that begin to attract each other, over surfaces that are drawn together and do not touch, to the largest contact.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self, TypeAlias

import numpy as np

from ..base.errors import Estimate, InputError, Refusal, Unknown, positive
from ..base.numerics import MOST_STEPS, ROUNDED, SAME, TINY, Array, composite_gauss, zeros_between
from ..base.units import show
from ..base.wings import absent, offered
from ..bodies.problem import NO_FINITE_RANGE, PUNCH_WITHOUT_RANGE, Problem, alone, without_side_walls
from ..formulas import Parts
from ..methods.integral.finite_range import Attraction, Rims, refuse_narrow
from ..methods.integral.logarithm import LogarithmicAttraction, panels_to
from ..methods.layered.contact import LayeredContact, checked
from ..methods.layered.spectrum import MINORS_ACCURACY, spectrum_seconds
from ..methods.protocol import METHODS, by_equation
from ..series import KeptKernel, Record, Series, Solution
from .curve import (
    CONTROLS,
    CURVE_SAMPLES,
    CriticalPoint,
    Equilibrium,
    EquilibriumCurve,
    Nonadhesive,
    controlled,
    position,
)
from .pull_off_error import FEWER_POINTS_NEAREST, decimation_error
from .slopes import Slopes

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

# --------------------------------------------------------------------------------------------------
# A problem's bodies with their kernel as far as adhesion of finite range reaches.
#
# Wide bodies have the exact kernel of ``layered``, cylinders that which a wing finds. It is computed anew for each
# reach that the kernel of the series does not cover: how far the attraction reaches is known only with its range.

# Accuracy of the kernel and how far it is needed.
# of K by its polynomials; tuned on ranges, by `make constants`: far below what is stated, at no cost
ATTRACTED_TOLERANCE = 1e-10
ATTRACTED_CHECKED = 0.01  # of that, of the second panels with which results are compared; choice: two digits more
ATTRACTED_OTHER_ORDER = 20  # Gauss nodes in k on the second panels; choice: shares nothing with the first's 24

# Nodes of the panels of a contact under a kernel with a logarithm, and of those with which results are compared
ATTRACTED_ORDER = 10  # tuned on linear laws of 1:20, by `make range-bounds`: good to 1e-8
ATTRACTED_OTHER_PANELS = 12  # choice: other panels, points and knots throughout

# of a reach over the one expected; tuned on ranges, by `make constants`: what is looked at beyond c
ATTRACTED_ROOM = 1.15
# of the next reach over one that was too short; tuned on ranges, by `make constants`: each is a small solve
ATTRACTED_FURTHER = 1.5
# CPU seconds of a curve, for forecasts, beside those of resolving the stack:
ATTRACTED_CURVE = 0.06  # tuned on half-spaces, by `make bench`
ATTRACTED_POLYNOMIALS = 2.8e-6  # by the square of their number; tuned on 30 to 700 of them, by `make bench`
# Where the kernel has a logarithm, by the nodes of the largest contact and by the waves [rad] over the reach:
ATTRACTED_LOGARITHM = 0.02  # tuned on linear laws of 1:1.05 to 1:20, by `make bench`
ATTRACTED_WAVES = 0.02  # tuned on linear laws of 1:1.05 to 1:20, by `make bench`
ATTRACTED_STACK = 0.25  # of what a solve needs for the spectrum; tuned on 1 to 1000 layers, by `make bench`


Ready: TypeAlias = Callable[[float, float], "Attraction | LogarithmicAttraction"]  # for a reach [m] and a tolerance
# The same of a kernel up to some reach, and the relative errors (columns, n) that it leaves at radii (n,) [m]
KernelReached: TypeAlias = tuple[Callable[[float, float], Attraction], Callable[[Array], Array]]


class CylinderKernel(Protocol):
    """The kernel of bodies with side walls, which a wing knows."""

    @property
    def limit(self) -> float:
        """The radius [m] to which attraction may reach: near the side."""

    def seconds(self, reach: float) -> float:
        """CPU seconds, about, of the kernel up to ``reach`` [m]."""

    def reached(self, reach: float, kept: KeptKernel | None = None) -> KernelReached:
        """The kernel up to ``reach`` [m], that which was ``kept`` where it goes as far; Refusal where none does."""


@dataclass(frozen=True, eq=False)
class AttractedBody:
    """The bodies of a ``problem`` for adhesion of finite range, as far as it reaches; ``tolerance``: of K by its
    polynomials; ``kept``: the kernel of these bodies that their series was found with, where it has one."""

    problem: Problem
    tolerance: float = ATTRACTED_TOLERANCE
    kept: KeptKernel | None = None
    _made: dict[str, tuple[float, Any]] = field(default_factory=dict, init=False)

    @cached_property
    def _wide(self) -> LayeredContact:
        problem = without_side_walls(self.problem)
        return LayeredContact(problem.indenter, problem.specimen)

    @property
    def _half_space(self) -> LayeredContact:
        half_spaces = alone(self.problem)
        return LayeredContact(half_spaces.indenter, half_spaces.specimen)

    @cached_property
    def _cylinder(self) -> CylinderKernel | None:
        if self.problem.specimen.radius is None:
            return None
        if (known := offered("the kernel of a cylinder")) is None:
            raise Refusal(f"adhesion of finite range: the kernel of a cylinder {absent('the kernel of a cylinder')}")
        found: CylinderKernel = known(self.problem)
        return found

    @property
    def limit(self) -> float:
        """The radius [m] to which attraction may reach: the end of the profile, or near the side of a cylinder."""
        end = self.problem.indenter.r_max * (1 - ROUNDED)
        return end if self._cylinder is None else min(end, self._cylinder.limit)

    @property
    def scale(self) -> float:
        """The length over which the kernel varies [m]."""
        return self._wide.scale

    def _latest(self, name: str, reach: float, make: Callable[[], Any]) -> Any:
        """The result of ``make`` for this ``reach``, kept while the reach is the same."""
        if name not in self._made or self._made[name][0] != reach:
            self._made[name] = reach, make()
        return self._made[name][1]

    def attraction(self, reach: float) -> Attraction:
        """The bodies ready for any tension up to ``reach`` [m], on polynomials that all contact radii share."""
        return self._kernel(reach)[0]

    def ready(self, reach: float) -> Attraction | LogarithmicAttraction:
        """The bodies ready for any tension up to ``reach`` [m], as accurate as they are solved."""
        return self._logarithmic(self._wide, reach, ATTRACTED_ORDER) if self.is_logarithmic else self.attraction(reach)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the kernel has a logarithm that polynomials do not follow: wide bodies whose modulus changes right
        below the contact."""
        return self._cylinder is None and self._wide.spectrum.tail is not None

    def _logarithmic(self, wide: LayeredContact, reach: float, order: int) -> LogarithmicAttraction:
        """The same on panels of each contact radius, of ``order`` nodes; the kernel is kept for shorter reaches."""
        name = f"panels of {order}"
        known, made = self._made.get(name, (0.0, None))
        if reach > known:
            known = min(ATTRACTED_ROOM * reach, self.limit)
            made = wide.logarithmic(known, self.tolerance, order)
            self._made[name] = known, made
        assert made is not None
        return replace(made, reach=reach)

    def check(self, reach: float) -> Attraction | LogarithmicAttraction:
        """What is ready up to the radius ``reach`` [m] on other panels than those of ``ready``, for an estimate of the
        error that they leave."""
        if self.is_logarithmic:
            other = replace(self._wide, order=ATTRACTED_OTHER_ORDER)
            return self._logarithmic(other, reach, ATTRACTED_OTHER_PANELS)
        reached, finer = self._kernel(reach)[1], self.tolerance * ATTRACTED_CHECKED
        ready = reached[0] if reached else replace(self._wide, order=ATTRACTED_OTHER_ORDER).attraction
        return self._latest("check", reach, lambda: ready(reach, finer))

    def kernel_error(self, reach: float, radii: Array) -> Array:
        """Relative error that the kernel itself leaves in delta and P up to ``radii`` [m]: that of nonadhesive contact,
        and of the density at its edge, whose square is S'."""
        if self._cylinder is None:  # that of g, of which S is the minimum of a quadratic form
            return np.full(radii.size, MINORS_ACCURACY if self.problem.specimen.is_graded else 0.0)
        reached = self._kernel(reach)[1]
        assert reached is not None
        *columns, dS = reached[1](np.asarray(radii))
        return np.max([*columns, dS / 2], axis=0)

    def _kernel(self, reach: float) -> tuple[Attraction, KernelReached | None]:
        def made() -> tuple[Attraction, KernelReached | None]:
            if self._cylinder is None:
                return self._wide.attraction(reach, self.tolerance), None
            reached = self._cylinder.reached(reach, self.kept)
            return reached[0](reach, self.tolerance), reached

        return self._latest("kernel", reach, made)

    def seconds(self, a: float, s: float, gap: float) -> float:
        """CPU seconds, about, of the states up to the contact radius ``a`` [m] (see ``reach``), from the polynomials
        that a wide body needs; Refusal where they are too many."""
        wide = self._wide
        expected = ATTRACTED_ROOM * self._edge(self._half_space.attraction, 2 * a + math.sqrt(gap * a), a, s, gap)
        reach = min(expected, self.limit)
        if self.is_logarithmic:
            panels = ATTRACTED_ORDER * panels_to(reach, self.problem.top_thickness)
            curve = ATTRACTED_LOGARITHM * (
                panels + ATTRACTED_WAVES * wide.spectrum.bandwidth(wide.spectrum.floor) * reach
            )
        else:
            curve = ATTRACTED_POLYNOMIALS * wide.attraction_panels(reach, ATTRACTED_TOLERANCE).x.size ** 2
        stack = ATTRACTED_STACK * spectrum_seconds(self.problem)
        sides = 0.0 if self._cylinder is None else self._cylinder.seconds(reach)
        return ATTRACTED_CURVE + curve + stack + sides

    def reach(self, a: float, s: float, gap: float) -> float:
        """A radius [m] beyond that to which the tension s = 2 sigma/E* acts around a contact of the radius ``a`` [m],
        where the separation is ``gap`` [m]. Refusal where it lies beyond a side or the profile."""
        expected = self._edge(self._half_space.attraction, 2 * a + math.sqrt(gap * a), a, s, gap)
        by_size = self._wide.attraction
        ready: Ready = (lambda reach, _: self.ready(reach)) if self.is_logarithmic else by_size
        expected = self._edge(ready, ATTRACTED_ROOM * expected, a, s, gap)
        reach = min(ATTRACTED_ROOM * expected, self.limit)
        if self._cylinder is None:
            return reach
        edge = self._edge(lambda reach, _: self.attraction(reach), reach, a, s, gap)
        return max(reach, min(ATTRACTED_ROOM * edge, self.limit)) if edge > reach else reach

    def _edge(self, ready: Ready, start: float, a: float, s: float, gap: float) -> float:
        """The radius c [m] for the contact radius ``a``, by the body that ``ready`` gives for a reach and a tolerance,
        sought beyond ``start`` [m] where need be."""
        reach, radii = start, np.array([a])
        for _ in range(MOST_STEPS):
            reach = min(max(reach, a * (1 + 1e-6)), self.limit)
            discs = ready(reach, ATTRACTED_TOLERANCE).discs(radii)
            if discs.rims(reach - radii, s).gap[0] >= gap:
                return float(discs.equilibria(s, gap, reach).c[0])
            if reach == self.limit:
                raise Refusal(self._too_far(a))
            reach *= ATTRACTED_FURTHER
        raise Refusal(self._too_far(a))

    def _too_far(self, a: float) -> str:
        at_end = self.limit == self.problem.indenter.r_max * (1 - ROUNDED)
        end = "the end of the profile" if at_end else "the side of the cylinder"
        return (
            f"adhesion of finite range: around a contact of a = {show(a, 'length')} the surfaces attract each other "
            f"beyond {end} (at {show(self.limit, 'length')} the separation is still within the range): load less, or "
            "give a larger stress (a shorter range)"
        )


# --------------------------------------------------------------------------------------------------
# The law of attraction of finite range, and the request for one.


@dataclass(frozen=True)
class Range:
    """The law of attraction of finite range: a constant tension ``stress`` [Pa] up to the separation ``length`` [m]
    (Dugdale, as Maugis took it)."""

    stress: float
    length: float

    def __post_init__(self) -> None:
        positive("Pa", stress=self.stress)
        positive("m", range=self.length)

    @classmethod
    def of(cls, w: float, *, stress: float | None = None, length: float | None = None) -> Range:
        """The law of the work of adhesion ``w`` [J/m^2] with one of ``stress`` [Pa] and ``length`` [m]."""
        if (stress is None) == (length is None):
            raise InputError("adhesion of finite range: give either stress or range")
        positive("J/m^2", w=w)
        if stress is not None:
            positive("Pa", stress=stress)
            return cls(stress, w / stress)
        assert length is not None
        positive("m", range=length)
        return cls(w / length, length)

    @property
    def w(self) -> float:
        """Work of adhesion [J/m^2]."""
        return self.stress * self.length


@dataclass(frozen=True)
class RangeRequest:
    """The requested tension ``stress`` [Pa] or range ``length`` [m], for any work of adhesion; neither: JKR."""

    stress: float | None = None
    length: float | None = None

    @classmethod
    def of(
        cls, record: Record, stress: float | None = None, length: float | None = None, names: str = "stress or length"
    ) -> RangeRequest:
        """The ``stress`` [Pa] or the ``length`` [m] if there is one, else those of the case in ``record``; InputError
        where there are both, by what ``names`` they have."""
        if stress is not None and length is not None:
            raise InputError(f"give either {names}, got both")
        if stress is None and length is None:
            return cls(record.stress, record.length)
        return cls(stress, length)

    def __bool__(self) -> bool:
        """Whether adhesion has a range."""
        return self.stress is not None or self.length is not None

    def law(self, w: float) -> Range:
        """The law for the work of adhesion ``w`` [J/m^2]."""
        return Range.of(w, stress=self.stress, length=self.length)

    def refuse_two(self, approach: float, retraction: float) -> None:
        """InputError for a cycle with two works of adhesion [J/m^2]."""
        if self and approach != retraction:
            raise InputError(
                "cycle: adhesion of finite range loses energy in its jumps alone: give one work of adhesion, got "
                f"{show(approach, 'work')} on approach and {show(retraction, 'work')} on retraction"
            )

    @property
    def suffix(self) -> str:
        """What distinguishes names of files: ``-stress1e+08``, ``-range3e-10``."""
        if not self:
            return ""
        return f"-range{self.length:g}" if self.stress is None else f"-stress{self.stress:g}"


def without_range(record: Record, verb: str) -> None:
    """Refusal by a ``verb`` that has no adhesion of finite range, where the case of ``record`` asks for it."""
    if record.stress is not None or record.length is not None:
        raise InputError(
            f"{verb}: has no adhesion of finite range, which the case of {record.path} asks for: leave "
            "adhesion.range, stress and capillary out"
        )


# Points of the curve, and the error of its interpolation.
# points without contact, even in c, to begin with; choice: halved where a spline does not follow the states
FINITE_RANGE_APART = 32
# largest step of arcosh sqrt(c/c0), of half of log c, or of asinh(a/l), l the scale of the body or c0 where that is
# less; tuned on curves, by `make constants`: splines good to 1e-7 of the lowest load
FINITE_RANGE_SPACING = 0.08
# of the splines through the points
FINITE_RANGE_DEGREE = 5  # theory: errors fall with the power degree + 1 of the spacing
FINITE_RANGE_HALVED = 16.0  # theory: halving the spacing divides the error by 64, by a fourth of it where it is uneven
FINITE_RANGE_ROUNDS = 3  # tuned on curves, by `make constants`: of inserting points where they are too far apart
# Radii on either side of a kink, up to a part of its own, the first of that; theory: F bends with the power 3/2
FINITE_RANGE_BESIDE = 24  # theory: 1.8 from one to the next, where splines follow that power to 2e-4 of itself
FINITE_RANGE_AROUND = 0.2  # choice: where the rows of the series are as dense
FINITE_RANGE_ROOM = 1.2  # choice: of that, within which the series' own rows are left out
FINITE_RANGE_FIRST = 1e-6  # theory: its power 3/2 is rounding
# of log c from point to point beyond that of log(a + c0): a curve that leaps; choice: steps are half as long
FINITE_RANGE_LEAP = 0.17
FINITE_RANGE_BEGUN = 8  # choice: halvings of the step below the first state of a curve that leaps: 1/256 of a row
FINITE_RANGE_FEWEST = 12  # theory: points of a curve, every second of which has the 6 of a spline of degree 5
# Steps to both sides of pull-off, fractions of its radius, at which it is solved:
FINITE_RANGE_CLOSE = (0.01, 0.02, 0.03, 0.045, 0.065, 0.1)  # choice: to where rows of a series lie
# theory: of its radius; so near to a state the splines err by 1e-3 of what they do between states, 4e-10: rounding
FINITE_RANGE_SOLVED = 1e-4
# theory: of c, a contact radius below which loads go with its square by less than round-off
FINITE_RANGE_BORN = math.sqrt(ROUNDED)
# on the change of the second panels; tuned on curves, by `make constants`: as for series of `layered`
FINITE_RANGE_SAFETY = 4.0
FINITE_RANGE_LOOKED_AT = 8  # contact radii at which separations are looked at; choice: for a warning
FINITE_RANGE_NO_CLAIM = 1e-12  # theory: smaller errors are rounding
FINITE_RANGE_RELEASED = 4001  # choice: radii at which the last attraction is looked at, four digits of its load


@dataclass(frozen=True, eq=False)
class FiniteRangeCurve(EquilibriumCurve):
    """The adhesive curve of a body for a ``law`` of finite range: along the radius c to which the surfaces attract
    while nothing touches, and beyond c0, that of first touch, along c0 + a: c may fall where the contact grows.

    ``apart``: states without contact, from c = 0 on; ``touching``: those in contact from a = 0 on, both in order. Where
    the contact leaps from one radius to another, the curve begins beyond. ``parts``: columns of the w-free functions at
    the latter. Between the points: splines over asinh(a/c0), in which the curve is smooth from first touch to far from
    it; without contact P = -pi sigma c^2, and delta(c) less the profile f(c) is a spline.
    ``half_widths``: the ``errors``, ``of_profile``: what is part of them by a profile that is
    known at points only; ``moved``: relative errors of the places at which contact is lost, by stiffness, and
    ``by_points``: errors by such a profile there; ``doubts``: what speaks against the states, in sentences; ``body``:
    which computed them. ``below``: states without contact from c = 0 on, where the curve leaves out what is next.
    """

    law: Range
    problem: Problem
    series: Series
    apart: Rims
    touching: Rims
    parts: Parts
    half_widths: Mapping[str, Array] = field(default_factory=dict)
    of_profile: Mapping[str, Array] = field(default_factory=dict)
    moved: Mapping[float, float] = field(default_factory=dict)
    by_points: Mapping[float, Array] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    body: FiniteRangeBody | None = None
    below: Rims = field(default_factory=lambda: Rims(*np.zeros((5, 0))))
    ranged: ClassVar[bool] = True

    @property
    def complete(self) -> bool:
        return self.apart.c.size > 0 and self.apart.c[0] == 0

    @property
    def errors(self) -> Mapping[str, Array]:
        return self.half_widths

    @property
    def w(self) -> float:
        return self.law.w

    @cached_property
    def slopes(self) -> Slopes:
        """S and S' of the series."""
        return Nonadhesive.of(self.series).slopes

    @property
    def columns(self) -> dict[str, Array]:
        without = np.zeros(self.apart.c.size)
        rest = [np.concatenate([without + column[0], column]) for column in self.parts[:4]]
        plain = dict(zip(("delta_H_m", "P_H_N", "S_N_per_m", "dS_da_N_per_m2"), rest, strict=True))
        return {"a_m": self.a, "delta_m": self.delta, "P_N": self.P} | plain | {"c_m": self.c}

    def point_error(self, point: Equilibrium, stiffness: float) -> dict[str, float]:
        """Half-widths of "delta" [m] and "P" [N] at the lowest ``point`` under a device of a ``stiffness`` [N/m]: those
        of the curve there, of the place, by a profile at points, and what every second state changes. Where it is not
        known how far other panels move the place, it errs by about the same fraction as P, and at least by round-off,
        as a zero of a derivative."""
        place, state = np.array(point.place), np.array([point.delta, point.P])
        here = np.stack(list(self.error_at(place).values()))
        by_points = self.by_points.get(stiffness)
        if by_points is not None:
            here = here - [np.interp(place, self.places, values) for values in self.of_profile.values()]
        halves = [[other for other in curve.critical(stiffness) if other.kind == "minimum"] for curve in self.halves]
        nearest = [min(half, key=lambda other: abs(other.place - point.place)) for half in halves if half]
        unseen = 0.0 if stiffness in self.moved else float(here[1]) / max(abs(point.P), TINY)
        if len(nearest) < len(halves):
            assert isinstance(self.interpolation_error, float)
            unseen += FINITE_RANGE_HALVED * self.interpolation_error
        fraction = unseen + self.moved.get(stiffness, 0.0) + ROUNDED
        moved = fraction * point.place * np.abs(self._rates(place))
        changed = np.max([np.abs([other.delta, other.P] - state) for other in nearest], axis=0, initial=0.0)
        errors = here + (0.0 if by_points is None else by_points) + unseen * np.abs(state) + moved
        errors = errors + changed / FINITE_RANGE_HALVED
        return dict(zip(("delta", "P"), errors.tolist(), strict=True))

    def with_solved_points(self, *devices: float) -> FiniteRangeCurve:
        """The curve with states at the pull-off points by ``devices`` of a stiffness [N/m], too."""
        more = set(devices) - {*CONTROLS.values()}
        return self if self.body is None or not more else self.body.curve(self.law, *sorted(more))

    @property
    def onset(self) -> float:
        """The displacement at which the free bodies come within the range: minus the range."""
        return -self.law.length

    @cached_property
    def places(self) -> Array:
        return np.concatenate([self.apart.c, self._c0 + self.touching.a])

    @property
    def c(self) -> Array:
        """Radii to which the surfaces attract each other at the points [m]."""
        return np.concatenate([self.apart.c, self.touching.c])

    @property
    def delta(self) -> Array:
        """Displacement [m] at the points."""
        return np.concatenate([self.apart.delta, self.touching.delta])

    @property
    def P(self) -> Array:
        """Load [N] at the points."""
        return np.concatenate([self.apart.P, self.touching.P])

    @property
    def a(self) -> Array:
        """Contact radii of the points [m], 0 where nothing touches."""
        return np.concatenate([self.apart.a, self.touching.a])

    def critical(self, stiffness: float) -> tuple[CriticalPoint, ...]:
        """The stationary points of delta + P/stiffness [N/m]; the first point of the curve is none, where the surfaces
        only come within the range, or where places go no further."""
        first = 0.0 if self.complete else float(self.places[0]) * (1 + SAME)
        return tuple(point for point in super().critical(stiffness) if point.place > first)

    def pull_off(self, stiffness: float) -> CriticalPoint | Unknown:
        """The last state in contact from which a jump of a device of a ``stiffness`` [N/m] leaves none; where contact
        shrinks to nothing before, the last one in which surfaces attract each other that let go in a jump."""
        lost = super().pull_off(stiffness)
        lowest, last = float(position(self.delta[-1], self.P[-1], stiffness)), None
        for point in reversed(self.critical(stiffness)):  # as retraction meets them
            x = float(position(point.delta, point.P, stiffness))
            if point.kind == "minimum" and x < lowest:
                lowest, last = x, point if point.a > 0 else last
        if last is None:
            return lost
        there = np.array(self.radii_at(float(position(last.delta, last.P, stiffness)), stiffness))
        stable = there[(there < last.place) & (position(*self.rates(there), stiffness) > 0)]
        return lost if stable.size and self.contact_radii(stable[-1]) > 0 else last

    def point(self, place: float) -> Equilibrium:
        delta, P = self.at(np.array(place))
        a, c = (float(radius(np.array(place))) for radius in (self.contact_radii, self.attracted_radii))
        return Equilibrium(a, float(delta), float(P), c, place)

    def surface_displacement(self, point: Equilibrium) -> float | None:
        """Where nothing touches, the surface at c: delta and the range less the profile there."""
        if point.a > 0 or point.c is None:
            return None
        return point.delta + self.law.length - float(self.problem.indenter.f(np.array(point.c)))

    def contact_radii(self, places: Array) -> Array:
        beyond = places - self._c0
        return np.where(beyond > 2 * ROUNDED * self._c0, beyond, 0.0)

    def attracted_radii(self, places: Array) -> Array:
        return np.where(places > self._c0, self._splines[0](self._stretched(places))[..., 0], places)

    def around(self, a: Array) -> Array:
        """The radii c [m] to which the surfaces attract each other around contact radii ``a`` [m], about."""
        return np.interp(a, self.touching.a, self.touching.c)

    @property
    def _c0(self) -> float:
        """The radius c [m] of the first state in contact."""
        return float(self.touching.c[0])

    def _stretched(self, places: Array) -> Array:
        return np.arcsinh(np.maximum(places / self._c0 - 1, self.touching.a[0] / self._c0))

    @property
    def _bends(self) -> Array:
        """Numbers of the states in contact at kinks of the profile, where splines end."""
        radii = np.stack([self.touching.a, self.touching.c])[:, 1:-1, None]
        near = np.abs(radii / np.array(self.problem.indenter.kinks) - 1) < ROUNDED
        return np.flatnonzero(near.any(axis=(0, 2))) + 1

    @cached_property
    def _splines(self) -> tuple[Broken, Broken]:
        """c, delta, P over asinh(a/c0), and their derivatives."""
        columns = np.stack([self.touching.c, self.touching.delta, self.touching.P], axis=1)
        spline = Broken.through(np.arcsinh(self.touching.a / self._c0), columns, self._bends)
        return spline, spline.derivative()

    @cached_property
    def _pulled(self) -> BSpline | None:
        """f(c) - delta [m] without contact, over c; None where all states are in contact."""
        return _drawn(self.problem, _joined(self.apart, _some(self.touching, slice(1)))) if self.apart.c.size else None

    def _at(self, places: Array) -> tuple[Array, Array]:
        c = np.minimum(places, self._c0)
        pulled: Array = np.zeros_like(c) if self._pulled is None else self._pulled(c)
        free = self.problem.indenter.f(c) - pulled, -math.pi * self.law.stress * c**2
        touching = np.moveaxis(self._splines[0](self._stretched(places)), -1, 0)[1:]
        delta, P = (np.where(places > self._c0, b, a) for a, b in zip(free, touching, strict=True))
        return delta, P

    def _rates(self, places: Array) -> tuple[Array, Array]:
        c = np.minimum(places, self._c0)
        safe = np.maximum(c, TINY)
        pulled: Array = np.zeros_like(c) if self._pulled is None else self._pulled(c, 1)
        free = self.problem.indenter.slope(safe) - pulled, -2 * math.pi * self.law.stress * c
        by_a = 1 / np.hypot(self._c0, self.contact_radii(places))
        touching = np.moveaxis(self._splines[1](self._stretched(places)), -1, 0)[1:] * by_a
        inside = places > self._c0 * (1 + ROUNDED)
        delta, P = (np.where(inside, b, a) for a, b in zip(free, touching, strict=True))
        return delta, P

    @cached_property
    def _samples(self) -> Array:
        steps = np.arange(CURVE_SAMPLES) / CURVE_SAMPLES
        rows = (
            np.append(self.apart.c, self._c0) if self.apart.c.size else self.places[:1],
            np.arcsinh(self.touching.a / self._c0),
        )
        free, v = ((some[:-1, None] + np.diff(some)[:, None] * steps).ravel() for some in rows)
        return np.unique(np.concatenate([free, self._c0 * (1 + np.sinh(v)), self.places[-1:]])) / self.places[-1]

    def _place(self, x: Array) -> Array:
        return x * self.places[-1]

    def path(self, low: float, high: float) -> tuple[Array, Array]:
        first = np.unique([min(low, self._c0), *self.apart.c[(self.apart.c > low) & (self.apart.c < high)],
                           min(high, self._c0)])  # fmt: skip
        free, free_weights = composite_gauss(first)
        begins, ends = max(low - self._c0, self.touching.a[0]), max(high - self._c0, self.touching.a[0])
        inner = self.touching.a[(self.touching.a > begins) & (self.touching.a < ends)]
        v, weights = composite_gauss(np.arcsinh(np.concatenate([[begins], inner, [ends]]) / self._c0))
        places = np.clip(self._c0 * (1 + np.sinh(v)), self._c0 + begins, self._c0 + ends)
        weights = weights * self._c0 * np.cosh(v)
        return np.concatenate([free, places]), np.concatenate([free_weights, weights])

    def thinned(self, first: int) -> Self:
        rows, ends = np.arange(1 + first, self.touching.c.size - 1, 2), [0, self.touching.c.size - 1]
        rows = np.unique(np.concatenate([ends, rows, self._bends]))
        free = np.union1d([0], np.arange(1 + first, self.apart.c.size, 2)) if self.apart.c.size else slice(0)
        parts = Parts(*(column[rows] for column in self.parts))
        states = _some(self.apart, free), _some(self.touching, rows)
        return type(self)(self.law, self.problem, self.series, *states, parts)

    @property
    def thinning(self) -> float:
        return FINITE_RANGE_HALVED

    @cached_property
    def interpolation_error(self) -> Estimate:
        """Relative error of delta and P between the points: their change where every second is left out, over 16."""
        changes = []
        for coarser in self.halves:
            left_out = np.setdiff1d(self.places, coarser.places)
            for ours, there in zip(self._at(left_out), coarser.at(left_out), strict=True):
                unit = np.maximum(np.abs(ours), abs(float(np.min(ours))))
                changes.append(float(np.max(np.abs(there - ours) / unit)))
        return max(changes) / FINITE_RANGE_HALVED + FINITE_RANGE_NO_CLAIM

    def _outside(self, stiffness: float, end: str, lowest: Equilibrium) -> str:
        quantity = controlled(stiffness)
        if end == "smallest" and not self.complete:
            if lowest.a > 0:
                return (
                    f"the {quantity} is lowest where the curve begins, at a = {show(lowest.a, 'length')}: below "
                    "this radius the cohesive-zone solution is not unique and is not computed; take load control or a "
                    "softer instrument, or another stress or range"
                )
            first = float(self.touching.P[0]), float(self.touching.delta[0])
            shrunk = f"contact is lost without a jump: its radius falls to zero at {_where(*first)}"
            # Where surfaces that attract each other without contact let go, below what the curve leaves out
            if self.below.c.size > FINITE_RANGE_DEGREE:
                c = np.linspace(0, float(self.below.c[-1]), FINITE_RANGE_RELEASED)
                delta = self.problem.indenter.f(c) - _drawn(self.problem, self.below)(c)
                P = -math.pi * self.law.stress * c**2
                n = int(np.argmin(position(delta, P, stiffness)))
                if 0 < n < c.size - 1:
                    return (
                        f"{shrunk}; attraction without contact ends at {_where(float(P[n]), float(delta[n]))} (renewed "
                        "contact in between is not computed)"
                    )
            return f"{shrunk}; states below are not computed: give another stress or range"
        if end == "smallest":
            return (
                f"contact is not lost in a jump: the {quantity} falls until the surfaces no longer attract each other, "
                f"at delta = {show(lowest.delta, 'length')}"
            )
        return (
            f"the {quantity} is lowest at the largest radius, a = {show(lowest.a, 'length')}: pull-off lies outside "
            "the curve; the solution would have to reach a larger radius: increase [loading] radius"
        )


def _where(P: float, delta: float) -> str:
    return f"P = {show(P, 'load')}, delta = {show(delta, 'length')}"


@dataclass(frozen=True, eq=False)
class Broken:
    """Splines that end at ``breaks``, where the function that they interpolate has kinks."""

    breaks: Array
    splines: tuple[BSpline, ...]

    @classmethod
    def through(cls, x: Array, y: Array, bends: Array) -> Broken:
        """Through the rows of ``y`` at ``x``, with kinks at the rows of the numbers ``bends``."""
        from scipy.interpolate import make_interp_spline

        ends = itertools.pairwise([0, *bends.tolist(), x.size - 1])
        parts = (slice(lo, hi + 1) for lo, hi in ends)
        splines = (make_interp_spline(x[part], y[part], min(FINITE_RANGE_DEGREE, x[part].size - 1)) for part in parts)
        return cls(x[bends], tuple(splines))

    def __call__(self, x: Array) -> Array:
        x = np.asarray(x, dtype=float)
        part = np.searchsorted(self.breaks, x, side="right")
        out: Array = self.splines[0](x)
        for number, spline in enumerate(self.splines[1:], start=1):
            here = part == number
            out[here] = spline(x[here])
        return out

    def derivative(self) -> Broken:
        return Broken(self.breaks, tuple(spline.derivative() for spline in self.splines))


def unable(problem: Problem, method: str) -> str | None:
    """Why a ``problem`` that a ``method`` solves has no curve of finite range, with the remedy; None where it may."""
    if problem.sticks:
        return (
            "adhesion of finite range is implemented for frictionless contact only: solve the case with "
            'specimen.surface = "sliding", or leave range and stress out'
        )
    if problem.specimen.surface_tension:
        return NO_FINITE_RANGE
    if problem.indenter.rim < math.inf:
        return PUNCH_WITHOUT_RANGE
    if method not in METHODS or not METHODS[method].kernel:
        return (
            f"adhesion of finite range needs the kernel of the contact equation, which the method {method} does not "
            f"have: solve the case with the method {by_equation(problem.specimen)}"
        )
    return None


@dataclass(frozen=True, eq=False)
class Pulled:
    """A body under a tension, s = 2 sigma/E* [-], up to the separation ``gap`` [m], on some ``panels``."""

    panels: Attraction | LogarithmicAttraction
    s: float
    gap: float

    def states(self, a: Array, near: Array | None = None) -> Rims:
        """The states at contact radii ``a`` [m]; ``near``: radii c [m] from which they are sought."""
        return self.panels.discs(a).equilibria(self.s, self.gap, self.panels.reach, near)

    def free(self, c: Array) -> Rims:
        """The states without contact in which the surfaces attract each other up to the radii ``c`` [m]."""
        return self.panels.apart(c, self.s, self.gap) if c.size else Rims(*5 * (c,))


@dataclass(frozen=True, eq=False)
class FiniteRangeBody:
    """A solved body as curves of finite range need it: ``series``, and the body with its kernel."""

    problem: Problem
    series: Series
    body: AttractedBody

    @classmethod
    def of(cls, solution: Solution) -> FiniteRangeBody:
        """From a solution whose method knows the kernel, which is computed anew unless it has one that reaches."""
        if reason := unable(solution.problem, solution.method):
            raise Refusal(f"{solution.record.path}: {reason}")
        return cls(solution.problem, solution.series, AttractedBody(solution.problem, kept=solution.kernel))

    def seconds(self, law: Range) -> float:
        """CPU seconds of the curve for a ``law``, about; Refusal where it is known that there is none."""
        return self.body.seconds(*self.pulled(law))

    def pulled(self, law: Range) -> tuple[float, float, float]:
        """The largest contact radius [m], s = 2 sigma/E* and the range [m] of a ``law``."""
        return float(self.series.a[-1]), 2 * law.stress / self.problem.E_star, law.length

    def curve(self, law: Range, *devices: float) -> FiniteRangeCurve:
        """The curve for a ``law``, with its errors, and states at the pull-off points under load and displacement
        control and by ``devices`` of a stiffness [N/m]."""
        controls = (*CONTROLS.values(), *devices)
        largest, s, gap = self.pulled(law)
        reach = self.body.reach(largest, s, gap)
        pulled = Pulled(self.body.ready(reach), s, gap)
        whole = self._touching(pulled)
        refuse_narrow(whole)
        rims = self._begun(pulled, whole)
        apart = below = _some(rims, slice(0))
        if rims.a[0] == 0:
            apart, below = self._apart(pulled, float(rims.c[0]))
        none = Parts(*5 * (rims.a[:0],))  # until the states are settled
        curve = FiniteRangeCurve(law, self.problem, self.series, apart, rims, none, body=self, below=below)
        for _ in range(FINITE_RANGE_ROUNDS):  # every point that is reported is solved where it is
            near, free = _around_critical(curve, controls)
            rims = _merged(curve.touching, pulled.states(near, curve.around(near))) if near.size else curve.touching
            apart = curve.apart
            if free.size:  # states closer to each other would make round-off of both a slope
                beside = np.min(np.abs(apart.c[:, None] - free), axis=1) < FINITE_RANGE_CLOSE[0] / 2 * apart.c
                apart = _merged(_some(apart, ~beside), pulled.free(free))
            if not (near.size or free.size):
                break
            rims = _growing(rims)
            curve = replace(
                curve, touching=rims, apart=apart if rims.a[0] == curve.touching.a[0] else _some(apart, slice(0))
            )

        rims = curve.touching
        parts = Parts(*pulled.panels.discs(rims.a).nonadhesive, np.zeros(rims.a.size))
        doubts = []
        if not curve.complete:
            begin = curve.point(float(curve.places[0]))
            where = f"c = {show(begin.place, 'length')}" if begin.a == 0 else f"a = {show(begin.a, 'length')}"
            doubts.append(
                f"finite range: below {where} the cohesive-zone solution is not unique and is not computed: the curve "
                "begins there"
            )
        # What speaks against some of the states: the first one found, with the contact radius
        for n in np.unique(np.linspace(0, rims.a.size - 1, FINITE_RANGE_LOOKED_AT).astype(int)):
            one = _some(rims, slice(n, n + 1))
            if words := pulled.panels.discs(one.a).doubt(one, pulled.s, pulled.gap, pulled.panels.reach):
                where = show(float(one.a[0]), "length")
                doubts.append(f"finite range: at the contact radius {where} {words}: the curve is doubtful there")
                break
        curve = replace(curve, parts=parts, doubts=tuple(doubts))
        # The curve with its errors, as far as states on other panels tell them
        other = replace(pulled, panels=self.body.check(reach))
        errors, of_profile = self._errors(curve, other), self._of_profile(curve, pulled)
        errors = {name: error + of_profile.get(name, 0.0) for name, error in errors.items()}
        # The points at which contact is lost away from the end of the curve and from kinks
        points, kinks = list[tuple[float, CriticalPoint]](), self.problem.indenter.kinks
        for stiffness in controls:
            point = curve.pull_off(stiffness)
            if not isinstance(point, CriticalPoint) or not point.a < rims.a[-1] / (1 + FEWER_POINTS_NEAREST):
                continue
            radii = (point.a, _reach(point)) if point.a > 0 else (_reach(point),)
            if not any(abs(kink / r - 1) < 2 * FEWER_POINTS_NEAREST for kink in kinks for r in radii):
                points.append((stiffness, point))
        moved = self._moved(curve, pulled, other, points)
        by_points = dict[float, Array]()
        if of_profile:  # errors where contact is lost, by a profile that is known at points only
            indenter, end = self.problem.indenter, float(rims.a[-1])
            fewer = (replace(pulled.panels, indenter=thinned) for thinned in indenter.thinned)
            bodies = [pulled, *(replace(pulled, panels=panels) for panels in fewer)]

            def columns(a: Array) -> list[Array]:
                return [_columns(body.states(a, curve.around(a))) for body in bodies]

            lost = ((k, point) for k, point in points if point.a > 0)
            by_points = {k: decimation_error(indenter, columns, point, k, end) for k, point in lost}
        return replace(curve, half_widths=errors, of_profile=of_profile, moved=moved, by_points=by_points)

    def _begun(self, pulled: Pulled, rims: Rims) -> Rims:
        """The states of ``rims`` that follow each other and, where some below them do not, as far as they can be
        followed towards those: contact is often lost just there."""
        grown = _growing(rims)
        if grown.a.size == rims.a.size:
            return grown
        low, high = rims.a[rims.a.size - grown.a.size - 1], grown.a[0]
        for _ in range(FINITE_RANGE_BEGUN):
            between = pulled.states(np.array([(low + high) / 2]), grown.c[:1])
            if _leaps(_joined(between, _some(grown, slice(2)))).size:
                low = between.a[0]
            else:
                grown, high = _joined(between, grown), between.a[0]
        return grown

    def _apart(self, pulled: Pulled, c0: float) -> tuple[Rims, Rims]:
        """States without contact up to first touch at ``c0`` [m], so many that a spline follows what the tension draws
        up between them: layers have scales of their own, however small against c0. Where surfaces would overlap, those
        beyond, and those below it; else all and none."""
        # The states without contact with the first one, in which the free bodies come within the range `gap` [m].
        free = _joined(
            Rims(*np.array([[0.0], [0.0], [-pulled.gap], [0.0], [pulled.gap]])),
            pulled.free(np.linspace(0, c0, FINITE_RANGE_APART + 1)[1:]),
        )
        for _ in range(MOST_STEPS):
            between = pulled.free((free.c[1:] + free.c[:-1]) / 2)
            pulls, drawn = self.problem.indenter.f(between.c) - between.delta, _drawn(self.problem, free)
            missed = np.abs(drawn(between.c) - pulls) > pulled.panels.rounding * pulls
            if not missed.any():
                break
            free = _merged(free, _some(between, missed))
        # at a = 0 the separation at c would be the range if the middle just touched, and is more where it overlaps
        free = _some(free, slice(-1))
        middle = pulled.panels.discs(np.zeros(free.c.size - 1)).rims(free.c[1:], pulled.s).gap
        overlapping = np.flatnonzero(middle > pulled.gap * (1 + SAME))
        if not overlapping.size:
            return free, _some(free, slice(0))
        return _some(free, slice(int(overlapping[-1]) + 2, None)), _some(free, slice(int(overlapping[0]) + 1))

    def _touching(self, pulled: Pulled) -> Rims:
        """States in contact from a = 0 on: at the radii of the series, and at more of them where they are too far apart
        of each other in a or c."""
        from scipy.interpolate import PchipInterpolator

        rims = pulled.states(np.concatenate([[0.0], self.series.a]))
        if (leaps := _leaps(rims)).size:  # several radii c belong to one a: those next to the contacts beyond
            first = int(leaps[-1]) + 1
            below = pulled.states(rims.a[:first], np.maximum(rims.c[first], rims.a[:first]))
            rims = _joined(below, _some(rims, slice(first, None)))
        if self.problem.indenter.kinks:
            # Contact radii [m] at which the curve has kinks: those of the profile, and where the surfaces attract each
            # other up to one
            kinks = np.array(self.problem.indenter.kinks)
            beyond = np.sign(rims.c - kinks[:, None])
            kink, row = np.nonzero(beyond[:, 1:] * beyond[:, :-1] < 0)
            bends, reached, states = kinks[kinks < rims.a[-1]], kinks[kink], pulled.states
            if reached.size:
                ends = rims.a[row], rims.a[row + 1]
                around = zeros_between(lambda a: states(a, reached).c / reached - 1, *ends, 0.0)
                bends = np.concatenate([bends, around])
            bends = np.unique(bends)
            # Contact radii [m] of the series, and in their place around each of bends the radius itself and
            # others at steps that shrink towards it on both sides, halfway to the next
            a, steps = np.concatenate([[0.0], self.series.a]), np.geomspace(FINITE_RANGE_FIRST, 1, FINITE_RANGE_BESIDE)
            for before, bend, after in zip([0.0, *bends], bends, [*bends[1:], a[-1]], strict=False):
                below, above = (min(FINITE_RANGE_AROUND * bend, abs(bend - other) / 2) for other in (before, after))
                away = (a < bend - FINITE_RANGE_ROOM * below) | (a > bend + FINITE_RANGE_ROOM * above)
                a = np.concatenate([a[away], bend - below * steps, [bend], bend + above * steps])
            rows = np.unique(a)
            rims = pulled.states(rows, np.interp(rows, rims.a, rims.c))
        for _ in range(FINITE_RANGE_ROUNDS):
            over_c = np.diff(np.arccosh(np.sqrt(np.maximum.accumulate(rims.c) / rims.c[0])))
            over_a = np.diff(np.arcsinh(rims.a / min(rims.c[0], self.body.scale)))
            over_log = np.abs(np.diff(np.log(rims.c))) / 2
            v = np.append(0.0, np.cumsum(np.max([over_c, over_a, over_log], axis=0)))
            pieces = np.maximum(np.ceil(np.diff(v) / FINITE_RANGE_SPACING), 1).astype(int)
            if pieces.max() == 1:
                break
            inner = [np.linspace(lo, hi, n + 1)[1:-1] for lo, hi, n in zip(v[:-1], v[1:], pieces, strict=True)]
            more = PchipInterpolator(v, rims.a)(np.concatenate(inner))
            rims = _merged(rims, pulled.states(more, np.interp(more, rims.a, rims.c)))
        return rims

    def _errors(self, curve: FiniteRangeCurve, on_other: Pulled) -> dict[str, Array]:
        """Half-widths of delta and P: the change on other panels at some of the points, and what the kernel leaves."""
        rims, parts = curve.touching, curve.parts
        some = checked(rims.a)
        other = on_other.states(rims.a[some], rims.c[some])
        kernel = self.body.kernel_error(on_other.panels.reach, curve.c)
        f = self.problem.indenter.f(curve.apart.c)
        plain, here = np.stack(parts[:2]), _columns(rims)
        unit = plain + np.abs(plain - here)
        seen = np.max(np.abs(_columns(other) - here[:, some]) / unit[:, some], axis=1, keepdims=True)
        free = curve.apart.delta[curve.apart.c > 0]
        without = np.abs(on_other.free(curve.apart.c[curve.apart.c > 0]).delta - free) / np.abs(free)
        seen[0] = max(seen[0, 0], np.max(without, initial=0.0))
        relative = FINITE_RANGE_SAFETY * seen + FINITE_RANGE_NO_CLAIM + kernel
        free = np.stack([f + np.abs(f - curve.apart.delta), np.abs(curve.apart.P)])
        return dict(zip(("delta", "P"), relative * np.concatenate([free, unit], axis=1), strict=True))

    def _of_profile(self, curve: FiniteRangeCurve, pulled: Pulled) -> dict[str, Array]:
        """Half-widths of delta and P by a profile that is known at points only; none where it is known everywhere."""
        rims, S = curve.touching, curve.parts.S
        # Errors of delta [m] and of its slope at the contact radii: those of F up to the edges, more of what is softer
        # than the surface
        softer = np.divide(2 * self.problem.E_star * rims.a, S, out=np.ones_like(S), where=S > 0)
        resolution = self.problem.indenter.resolution
        shift, slope = np.maximum(softer, 1.0) * np.maximum(resolution(rims.a), resolution(rims.c))
        if not shift.any():
            return {}
        apart, _ = resolution(curve.apart.c)
        gap = np.minimum(slope * (rims.c - rims.a), shift)
        # Derivatives (2, n) of delta [-] and P [N/m] by the separation at the edge of the attraction, at the same
        # contact radii, without their sign.
        discs, step = pulled.panels.discs(rims.a), FINITE_RANGE_SOLVED
        more, less = (discs.rims((rims.c - rims.a) * (1 + side * step), pulled.s) for side in (1, -1))
        touching = (
            np.stack([shift, S * shift]) + np.abs((_columns(more) - _columns(less)) / (more.gap - less.gap)) * gap
        )
        errors = np.concatenate([[apart, np.zeros_like(apart)], touching], axis=1)
        return dict(zip(("delta", "P"), errors, strict=True))

    def _moved(
        self, curve: FiniteRangeCurve, pulled: Pulled, other: Pulled, points: Iterable[tuple[float, CriticalPoint]]
    ) -> dict[float, float]:
        """Relative errors of the places at which contact is lost: other panels add a slope to what is stationary there,
        as states on both sides of each show, and so does what the kernel leaves."""
        moved = {}
        for stiffness, point in points:
            around = 1 + FEWER_POINTS_NEAREST * np.array([-1.0, 0.0, 1.0])
            near = curve.around(point.a * around)
            both = (
                panels.states(point.a * around, near) if point.a > 0 else panels.free(point.place * around)
                for panels in (pulled, other)
            )
            x, off = (np.asarray(position(states.delta, states.P, stiffness)) for states in both)
            bend, added = x[0] - 2 * x[1] + x[2], np.max(np.abs(np.diff(off - x)))
            if bend > 0:
                kernel = float(self.body.kernel_error(pulled.panels.reach, np.array([_reach(point)]))[0])
                moved[stiffness] = FEWER_POINTS_NEAREST * FINITE_RANGE_SAFETY * float(added) / float(bend)
                moved[stiffness] += kernel + FINITE_RANGE_NO_CLAIM
        return moved


def _columns(rims: Rims) -> Array:
    """delta and P, (2, n)."""
    return np.stack([rims.delta, rims.P])


def _around_critical(curve: FiniteRangeCurve, controls: tuple[float, ...]) -> tuple[Array, Array]:
    """Contact radii a, and radii c without contact [m], of all critical points under ``controls`` and close around
    those where contact is lost."""
    kinks = np.array(curve.problem.indenter.kinks)
    touching, apart = [], []
    for stiffness in controls:
        lost = curve.pull_off(stiffness)
        for point in curve.critical(stiffness):
            if point.a == 0:
                apart.append((point.place, math.inf, point == lost))
                continue
            if point.a < FINITE_RANGE_BORN * _reach(point):  # where states side by side differ by round-off alone
                continue
            room = min((abs(kink / r - 1) / 2 for kink in kinks for r in (point.a, _reach(point))), default=math.inf)
            touching.append((point.a, room, point == lost))
    return _not_solved(touching, curve.touching.a), _not_solved(apart, np.append(curve.apart.c, curve.touching.c[0]))


def _not_solved(points: list[tuple[float, float, bool]], known: Array) -> Array:
    """The radii r [m] of critical ``points`` and, where contact is lost there, radii close around them on the same side
    of a kink, which leaves ``room``: but for those that are ``known`` or lie next to one, to a kink, or beyond."""
    new = known[:0]
    for r, room, _ in sorted(points, key=lambda point: point[2], reverse=True):
        if (
            np.min(np.abs(np.append(known, new) / r - 1))
            > FINITE_RANGE_SOLVED
            < room * FINITE_RANGE_CLOSE[0] / FINITE_RANGE_CLOSE[-1]
        ):
            new = np.append(new, r)
    found = new
    for r, room, lost in points:
        if lost and r in found:
            steps = np.array(FINITE_RANGE_CLOSE) * min(room / FINITE_RANGE_CLOSE[-1], 1.0)
            around = r * (1 + np.append(-steps, steps))
            apart = np.min(np.abs(around[:, None] - np.append(known, new)), axis=1) > steps[0] / 2 * r
            new = np.append(new, around[apart & (around < np.max(known))])
    return new


def _reach(point: Equilibrium) -> float:
    """The radius c [m] to which the surfaces attract each other."""
    return point.a if point.c is None else point.c


def _some(rims: Rims, rows: Array | slice) -> Rims:
    return Rims(*(column[rows] for column in vars(rims).values()))


def _joined(first: Rims, second: Rims) -> Rims:
    return Rims(*map(np.concatenate, zip(vars(first).values(), vars(second).values(), strict=True)))


def _merged(first: Rims, second: Rims) -> Rims:
    """The states of both, in contact by increasing contact radius, without by increasing c."""
    both = _joined(first, second)
    return _some(both, np.lexsort([both.c, both.a]))


def _drawn(problem: Problem, free: Rims) -> BSpline:
    """f(c) - delta [m] over c, through the states without contact."""
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(
        free.c, problem.indenter.f(free.c) - free.delta, min(FINITE_RANGE_DEGREE, free.c.size - 1)
    )


def _leaps(rims: Rims) -> Array:
    """Numbers of the states beyond which c leaps, or there is no state."""
    unsolved = np.abs(rims.gap / np.median(rims.gap) - 1) > SAME
    return np.flatnonzero(leaps_of(rims.a, rims.c) | unsolved[1:] | unsolved[:-1])


def leaps_of(a: Array, c: Array) -> Array:
    """Whether c [m] leaps beyond each of the states but the last, whose contact radii are ``a`` [m]."""
    return np.abs(np.diff(np.log(c))) > FINITE_RANGE_LEAP + np.diff(np.log(a + c[0]))


def _growing(rims: Rims) -> Rims:
    """The states from where on they follow each other as the contact grows, all of them on most bodies: the curve has
    no place for what lies below. Refusal where next to nothing is left."""
    leaps = _leaps(rims)
    if not leaps.size:
        return rims
    first = int(leaps[-1]) + 1
    if rims.a.size - first < FINITE_RANGE_FEWEST:
        raise Refusal(
            f"adhesion of finite range: up to the contact radius {show(float(rims.a[first]), 'length')} the contact "
            "leaps from one radius to another: a stiff coating, or a layer so soft that it jumps up to the indenter, "
            "is not touched in a disc that grows; increase [loading] radius, or give another stress or range"
        )
    return _some(rims, slice(first, None))

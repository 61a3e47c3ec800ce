"""Profiles by points, measured or designed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Annotated, ClassVar

import numpy as np

from ...base.arguments import read_fields
from ...base.errors import InputError
from ...base.numerics import AT_ONCE, HALF_WIDTH, LOOKED_AT, ROUNDED, TINY, Array, spline_slopes
from ...base.process import REMEMBERED
from ...base.registry import Key
from ...base.units import AnyLength, Length, show
from ..problem import Indenter, Solid, shape

# --------------------------------------------------------------------------------------------------
# The smooth convex profile within the noise of a measured one.
#
# f'' >= 0 is linear between knots, f' may jump where a worn end or a shoulder begins, and f'' with it. The coefficients
# minimise the squares of the points over the noise plus lambda int (f''')^2 (P-splines with bounds; Pya and Wood, Stat.
# Comput. 25 (2015) 543); lambda and the corners are those of the least Cp (Mallows, Technometrics 15 (1973) 661). What
# the noise leaves open are the modes of the posterior covariance, which holds the bias of smoothing too (Nychka, J. Am.
# Stat. Assoc. 83 (1988) 1134).

# Knots, corners and what is taken for noise.
SMOOTHING_KNOTS = (6, 24)  # choice: at least and at most, f'' is smoothed between them
SMOOTHING_POINTS_PER_KNOT = 3  # choice: at least
# choice: of log10 lambda, in units of noise and length
SMOOTHING_STRENGTHS = (-12.0, 2.0, 15)
# of log10 lambda, where a corner is sought; choice: with the corner the rest may be far smoother than without it
SMOOTHING_COARSE = (-11.0, 2.0, 5)
SMOOTHING_STIFF = (2.0, 2.0, 1)  # theory: parabolas between corners
SMOOTHING_FLAT = 4.0  # chi^2 by which a flat end may be worse; choice: two standard errors
SMOOTHING_CORNERS = 2  # choice: most that are found
SMOOTHING_AXIS = 20  # of a whole profile's length, how far its axis is sought; choice: scans are centred better
SMOOTHING_PLACES = 40  # choice: at which a corner is sought first
SMOOTHING_STEPS = 12  # theory: of the golden section, 1/300 of their distance
SMOOTHING_FEWEST = 12  # choice: points from which their scatter is found
SMOOTHING_RMS = 2.0  # of the noise, the most that points may scatter about the profile; choice: no chance does
SMOOTHING_LARGEST = 6.0  # of the noise, the most that one point may lie off; choice: one of a thousand millions


@dataclass(frozen=True, eq=False)
class SmoothProfile:
    """The profile as ``knots`` [m] and f with its three derivatives at the left of each piece (4, pieces); ``modes``:
    what one standard error of each mode adds, in the same form. ``noise``, ``rms`` of the points about it, ``largest``
    departure of one [m] and the radius [m] ``at`` which."""

    knots: Array
    pieces: Array
    modes: tuple[tuple[Array, Array], ...]
    noise: float
    rms: float
    largest: float
    at: float


def scatter(r: Array, f: Array) -> float:
    """Standard deviation [m] of independent noise of the points: what cubics through the two points on either side of
    each miss it by, of which corners are a few outliers."""
    off = []
    for i in range(2, r.size - 2):
        near = np.array([i - 2, i - 1, i + 1, i + 2])
        x = r[near]
        weights = np.array([np.prod([(r[i] - x[m]) / (x[k] - x[m]) for m in range(4) if m != k]) for k in range(4)])
        off.append((f[i] - weights @ f[near]) / np.sqrt(1 + weights @ weights))
    return float(1.4826 * np.median(np.abs(off)))  # theory: of a normal distribution


def folded(x: Array, f: Array, noise: float) -> tuple[Array, Array]:
    """Distances [m] from the axis of a whole profile, increasing, and the heights [m] there.

    The axis is where one smooth convex profile fits both sides best, sought about the vertex of a parabola.
    """

    def about(axis: float) -> tuple[Array, Array]:
        order = np.argsort(np.abs(x - axis), kind="stable")
        return np.abs(x - axis)[order], f[order]

    def misfit(axis: float) -> float:
        return replace(_Fit.of(*about(axis), noise, ()), strengths=SMOOTHING_COARSE).cp

    quadratic, linear, _ = np.polyfit(x, f, 2)
    middle, reach = (-linear / (2 * quadratic) if quadratic > 0 else 0.0), float(np.ptp(x)) / SMOOTHING_AXIS
    low, high = max(middle - reach, float(x[0]) / 2), min(middle + reach, float(x[-1]) / 2)
    return about(_golden_section(misfit, low, high, 2 * SMOOTHING_STEPS))


def _golden_section(misfit: Callable[[float], float], low: float, high: float, steps: int) -> float:
    """About where a ``misfit`` with one minimum between two places is least."""
    ratio = (math.sqrt(5) - 1) / 2
    for _ in range(steps):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, right) if misfit(left) < misfit(right) else (left, high)
    return (low + high) / 2


@lru_cache(maxsize=REMEMBERED)  # a case is read and built several times, which takes a second each
def smooth_convex(
    radii: tuple[float, ...], heights: tuple[float, ...], noise: float, bends: tuple[float, ...]
) -> SmoothProfile:
    """The smooth convex profile within the ``noise`` [m] of the points, with corners at ``bends`` [m] and where the
    points show them; InputError where they depart from any convex one by more.

    Whether there is a corner the points seldom tell for sure: of the fits with and without that of the least score is
    taken, and what the others differ by is part of what the noise leaves open, with the weights exp(-score/2)
    (Buckland, Burnham and Augustin, Biometrics 53 (1997) 603).
    """
    r, f = np.array(radii), np.array(heights)
    best = _Fit.of(r, f, noise, bends)
    fits = [best]
    for _ in range(SMOOTHING_CORNERS):
        fits += best.with_corner()
        best, before = min(fits, key=lambda fit: fit.score), best
        if best is before:
            break
    fits = [fit.with_flat_end() for fit in fits]
    best = min(fits, key=lambda fit: fit.score)
    residual = f - best.fitted
    rms, worst = float(np.sqrt(np.mean(residual**2))), int(np.argmax(np.abs(residual)))
    largest = float(np.abs(residual[worst]))
    if rms > SMOOTHING_RMS * noise or largest > SMOOTHING_LARGEST * noise:
        raise InputError(
            f"profile table: is not convex within its noise of {show(noise, 'length', 3)}: departs from the nearest "
            f"smooth convex profile by {show(largest, 'length', 3)} at r = {show(float(r[worst]), 'length', 3)} "
            f"(rms {show(rms, 'length', 3)}); JKR needs a contact disc that only grows: leave those points out, or "
            f'accept that profile with noise = "{show(max(rms, largest / 4), "length", 2)}"'
        )
    knots, pieces = best.profile
    weights = np.exp([(best.score - fit.score) / 2 for fit in fits])
    modes = list[tuple[Array, Array]]()
    for fit, weight in zip(fits, np.sqrt(weights / weights.sum()), strict=True):
        both = np.union1d(knots, fit.profile[0])
        if fit is not best:
            modes.append((both, weight * (cut_at(both, *fit.profile) - cut_at(both, knots, pieces))))
        modes += [(places, weight * mode) for places, mode in fit.modes]
    return SmoothProfile(knots, pieces, tuple(modes), noise, rms, largest, float(r[worst]))


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit with given ``corners`` [-], in units of the largest radius and the noise; ``flat``: the profile up to the
    first corner is. ``x`` (n,), ``y`` (n,): the points. ``strengths``: the lambdas that are tried."""

    x: Array
    y: Array
    unit: tuple[float, float]  # of lengths r and f [m]
    corners: tuple[float, ...]
    flat: bool = False
    strengths: tuple[float, float, int] = SMOOTHING_STRENGTHS

    @classmethod
    def of(cls, r: Array, f: Array, noise: float, bends: tuple[float, ...]) -> _Fit:
        length = float(r[-1])
        return cls(r / length, f / noise, (length, noise), tuple(bend / length for bend in bends))

    def tried(self, corner: float, flat: bool, strengths: tuple[float, float, int] = SMOOTHING_COARSE) -> _Fit:
        """The fit with a further corner, ``flat`` up to the first one; by few lambdas."""
        return replace(self, corners=tuple(sorted((*self.corners, corner))), flat=flat, strengths=strengths)

    def with_corner(self) -> list[_Fit]:
        """The best fits with a further corner: a point at the axis, and one in between without and with a flat end up
        to it, which leaves fewer unknowns, so that the points show the two where they do not show a corner alone."""
        places = np.linspace(self.x[2], self.x[-3], min(SMOOTHING_PLACES, self.x.size))
        apart = float(places[1] - places[0])
        places = places[np.all(np.abs(places[:, None] - np.array([-1.0, *self.corners])) > apart, axis=1)]
        found = [self._best_corner(places, apart, False, SMOOTHING_COARSE)]
        if 0.0 not in self.corners:  # beside what is stiff a corner is seen from further away
            found += [self._best_corner(places, apart, True, each) for each in (SMOOTHING_COARSE, SMOOTHING_STIFF)]
            found += [self.tried(0.0, False)]
        return [replace(fit, strengths=SMOOTHING_STRENGTHS) for fit in found]

    def _best_corner(self, places: Array, apart: float, flat: bool, strengths: tuple[float, float, int]) -> _Fit:
        """The fit with a further corner: the best of the ``places``, which are ``apart``, and by a golden section."""
        best = min((self.tried(place, flat, strengths) for place in places.tolist()), key=lambda fit: fit.cp)
        (place,) = set(best.corners) - set(self.corners)
        low, high = max(place - apart, float(self.x[1])), min(place + apart, float(self.x[-2]))
        found = _golden_section(lambda corner: self.tried(corner, flat, strengths).cp, low, high, SMOOTHING_STEPS)
        return min(best, self.tried(found, flat, strengths), key=lambda fit: fit.cp)

    def with_flat_end(self) -> _Fit:
        """The fit with a flat end up to the first corner, where the points allow one."""
        if not self.corners or self.corners[0] == 0 or self.flat:
            return self
        other = replace(self, flat=True)
        return other if other.chi2 < self.chi2 + SMOOTHING_FLAT else self

    # ------------------------------------------------------------------ columns: offset, jumps of slope, f'' at nodes
    @property
    def segments(self) -> list[Array]:
        """The nodes of f'' between corners."""
        least, most = SMOOTHING_KNOTS
        count = int(np.clip(self.x.size // SMOOTHING_POINTS_PER_KNOT, least, most))
        edges = [0.0, *(c for c in self.corners if c > 0), 1.0]
        return [
            np.linspace(low, high, max(round(count * (high - low)), 2) + 1) for low, high in itertools.pairwise(edges)
        ]

    @property
    def knots(self) -> Array:
        return np.concatenate([self.segments[0], *(nodes[1:] for nodes in self.segments[1:])])

    @property
    def curved(self) -> range:
        """Numbers of the segments with a curvature."""
        return range(int(self.flat), len(self.segments))

    def pieces_of(self, values: Array) -> Array:
        """f, f', f'', f''' (4, pieces) by jumps of the slope, then f'' at the nodes of the curved segments."""
        jumps, bent = np.split(values, [len(self.corners)])
        pieces = []
        for i, nodes in enumerate(self.segments):
            own = np.zeros(nodes.size)
            if i in self.curved:
                own, bent = bent[: nodes.size], bent[nodes.size :]
            pieces.append(np.stack([own[:-1], own[1:]]))
        left, right = np.concatenate(pieces, axis=1)
        steps = np.zeros(self.knots.size - 1)
        for place, jump in zip(self.corners, jumps, strict=True):
            steps[np.searchsorted(self.knots, place)] += jump
        # at the left of the pieces, of lengths h, from the steps of the slope there and f'' at both ends
        h = np.diff(self.knots)
        slope = np.cumsum(steps) + np.append(0.0, np.cumsum((left + right) / 2 * h)[:-1])
        f = np.append(0.0, np.cumsum(h * slope + h**2 * (2 * left + right) / 6)[:-1])
        return np.array([f, slope, left, (right - left) / h])

    @cached_property
    def columns(self) -> Array:
        """The points by each coefficient (n, p), the offset first: a jump of the slope at c gives (x - c)+, f'' that
        rises by 1 over a piece of length h from k on ((x - k)+^3 - (x - k - h)+^3)/(6 h)."""
        beyond = np.maximum(self.x[:, None] - np.array(self.corners), 0.0)
        parts = [np.ones((self.x.size, 1)), beyond]
        for i in self.curved:
            nodes = self.segments[i]
            step = np.maximum(self.x[:, None] - nodes, 0.0)
            rises = (step[:, :-1] ** 3 - step[:, 1:] ** 3) / (6 * np.diff(nodes))
            up = np.concatenate([step[:, :1] ** 2 / 2, rises], axis=1)
            down = np.concatenate([rises, step[:, -1:] ** 2 / 2], axis=1)
            parts.append(up - down)
        return np.concatenate(parts, axis=1)

    @cached_property
    def penalty(self) -> Array:
        """Rows whose squares are int (f''')^2."""
        rows, place = [], 1 + len(self.corners)
        for i in self.curved:
            nodes = self.segments[i]
            block = np.zeros((nodes.size - 1, self.columns.shape[1]))
            j = np.arange(nodes.size - 1)
            block[j, place + j + 1] = 1 / np.sqrt(np.diff(nodes))
            block[j, place + j] = -block[j, place + j + 1]
            rows.append(block)
            place += nodes.size
        return np.concatenate(rows)

    # ------------------------------------------------------------------ the fit
    @cached_property
    def best(self) -> tuple[float, float, Array]:
        """Cp, lambda and coefficients of the least Cp."""
        from scipy.optimize import nnls

        q, reduced = np.linalg.qr(self.columns)
        target, rest = q.T @ self.y, float(np.sum((self.y - q @ (q.T @ self.y)) ** 2))
        found = []
        for strength in np.logspace(*self.strengths):
            stacked = np.concatenate([reduced, np.sqrt(strength) * self.penalty])
            goal = np.append(target, np.zeros(self.penalty.shape[0]))
            both = np.concatenate([stacked, -stacked[:, :1]], axis=1)  # the offset has either sign
            solved, _ = nnls(both, goal, maxiter=50 * both.shape[1])
            values = solved[:-1].copy()
            values[0] -= solved[-1]
            chi2 = rest + float(np.sum((reduced @ values - target) ** 2))
            on = np.append(True, values[1:] > 0)
            design = reduced[:, on]
            inverse = np.linalg.pinv(design.T @ design + strength * self.penalty[:, on].T @ self.penalty[:, on])
            freedom = float(np.trace(inverse @ design.T @ design))
            found.append((chi2 + 2 * freedom, float(strength), values))
        return min(found, key=lambda item: item[0])

    @property
    def cp(self) -> float:
        return self.best[0]

    @property
    def score(self) -> float:
        """Cp, the places of the corners as unknowns."""
        return self.cp + 2 * sum(place > 0 for place in self.corners)

    @property
    def values(self) -> Array:
        return self.best[2]

    @property
    def chi2(self) -> float:
        return float(np.sum((self.columns @ self.values - self.y) ** 2))

    @property
    def fitted(self) -> Array:
        """The fit at the points [m], with their offset."""
        return self.unit[1] * (self.columns @ self.values)

    @property
    def profile(self) -> tuple[Array, Array]:
        """Knots [m] and pieces in SI."""
        return self._si(self.knots, self.pieces_of(self.values[1:]))

    @property
    def modes(self) -> tuple[tuple[Array, Array], ...]:
        """One standard error of each mode of the posterior: of the coefficients that are not at their bounds, which Cp
        counts, and of the places of the corners."""
        jumps = {place: self.values[1 + i] for i, place in enumerate(self.corners) if place > 0}
        steps = [np.where(self.x > place, -jump, 0.0) for place, jump in jumps.items()]
        on = np.append(True, self.values[1:] > 0)
        design = np.column_stack([on * self.columns, *steps])
        rough = np.pad(on * self.penalty, ((0, 0), (0, len(jumps))))
        inverse = np.linalg.pinv(design.T @ design + self.best[1] * rough.T @ rough)
        sizes, vectors = np.linalg.eigh((inverse + inverse.T) / 2)
        count = self.columns.shape[1]
        modes = []
        for size, vector in zip(sizes, vectors.T, strict=True):
            knots, pieces = self.knots, self.pieces_of(vector[1:count])
            for place, shift in zip(jumps, vector[count:], strict=True):
                width = min(max(np.sqrt(inverse[count, count]), 1e-3), place / 2, (1 - place) / 2)
                # The pieces with a rise by `height` over `width` on either side of a `place`.
                height = -jumps[place] * shift
                low, high = place - width, place + width
                more = np.union1d(knots, [low, high])
                cut = cut_at(more, knots, pieces)
                cut[0] += height * np.clip((more[:-1] - low) / (2 * width), 0.0, 1.0)
                cut[1] += np.where((more[:-1] >= low) & (more[:-1] < high), height / (2 * width), 0.0)
                knots, pieces = more, cut
            modes.append(self._si(knots, pieces * np.sqrt(max(size, 0.0))))
        return tuple(modes)

    def _si(self, knots: Array, pieces: Array) -> tuple[Array, Array]:
        length, height = self.unit
        return knots * length, pieces * (height / length ** np.arange(4.0))[:, None]


def cut_at(places: Array, knots: Array, pieces: Array) -> Array:
    """f and its three derivatives (4, n - 1) at all ``places`` (n,) but the last."""
    x = places[:-1]
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, knots.size - 2)
    step, (f, slope, curvature, third) = x - knots[i], pieces[:, i]
    return np.array(
        [
            f + step * (slope + step * (curvature / 2 + step * third / 6)),
            slope + step * (curvature + step * third / 2),
            curvature + step * third,
            third,
        ]
    )


# --------------------------------------------------------------------------------------------------

# How points become a profile, and the error of that.
TABLE_POINTS = 5000  # most of a table; choice: the cost grows with their square, so many take ten seconds
TABLE_POINTED = 0.25  # slope at the axis over the first chord above which a tip has a point; choice: a cone has 1
# Times the error that every second point changes: what every fourth changes more shows the order; of F, its slope,
# and the mean of F over the contact at least
TABLE_FLATTEST = (2.0, 1.0, 1.0)  # choice: near first order, of points that scatter
TABLE_STEEPEST = (14.0, 7.0, 14.0)  # theory: 2^4 and 2^3 less 1, of smooth splines
TABLE_SAFETY = 1.25  # theory: on errors by the order of three grids (Roache, J. Fluids Eng. 116 (1994) 405)
TABLE_CORNER = 0.1  # jump of the slope where a straight run ends, over the slope beyond; choice: less is none
TABLE_NEAR = 0.01  # of an interval, to its end: a corner as near is at that point; choice: points are rounded
TABLE_DRAWS = 3  # choice: profiles that the noise leaves, where a state moves with the profile
# of what the largest of so many draws changes, that half-width; 1.96/1.8, which ``fewer_points`` adds
TABLE_OF_DRAWS = 1.1  # theory: over about one standard error
TABLE_FEW = 9  # theory: points of a table, of every fourth of which no spline is left, and then
TABLE_FEW_FACTORS = (1.7, 1.0, 1.7)  # theory: of parabolas, less where a tip is blunt


@shape("table")
@dataclass(frozen=True)
class TableProfile(Indenter):
    """A measured or designed profile given by points (``r``, ``f``) [m], convex, from (0, 0) outwards, or from a
    negative ``r`` through the apex, which then need not be at r = 0: both sides of one profile about its axis.

    Between the points the profile is a cubic spline with continuous second derivative, even about the axis unless the
    points come to a tip there; it breaks at ``bends`` [m], radii of the table at which the user says that the slope
    jumps, and where a straight run of points ends. Where such a spline were not convex, between rough points, it is
    the convex quadratic one of Schumaker (1983). Exact for a paraboloid; its Abel image is a sum of closed forms.

    Points that scatter by a ``noise`` [m], one standard deviation, or that are not convex and whose scatter tells it,
    give the smooth convex profile within it (``smooth_convex``); what that leaves open is in the ``resolution``.
    """

    r: tuple[AnyLength, ...]
    heights: Annotated[tuple[AnyLength, ...], Key("f")]
    bends: tuple[AnyLength, ...] = ()
    material: Solid | None = None
    noise: Length | None = None
    smooth: SmoothProfile | None = field(init=False, repr=False, compare=False)
    knots: Array = field(init=False, repr=False, compare=False)
    pieces: Array = field(init=False, repr=False, compare=False)
    noun: ClassVar[str] = "tabulated profile"

    def __post_init__(self) -> None:
        read_fields(self)
        r, f = np.asarray(self.r, dtype=float), np.asarray(self.heights, dtype=float)
        if r.ndim == 1 and r.shape == f.shape and r.size > 2 and r[0] < 0 < r[-1] and (r == -r[::-1]).all():
            both = (f + f[::-1]) / 2
            if (np.abs(f - both) <= ROUNDED * np.ptp(f)).all():  # a designed one: its right half tells all
                r, f = (column[r >= 0] for column in (r, both))
        smooth = self._check(r, f)
        object.__setattr__(self, "smooth", smooth)
        if smooth is not None:
            knots, pieces = smooth.knots, smooth.pieces
        else:
            # The heights [m] above a flat end, next to the axis up to where the profile rises beyond rounding.
            chord = np.diff(f) / np.diff(r)
            level = np.append(True, np.logical_and.accumulate(chord <= ROUNDED * np.max(chord)))
            above = np.where(level, 0.0, f - f[level][-1])
            knots, pieces = _profile(*_with_corners(r, above, np.searchsorted(r, self.bends)))
        for name, array in (("knots", knots), ("pieces", pieces)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def _check(self, r: Array, f: Array) -> SmoothProfile | None:
        """What is smoothed of the points, None where they are taken as they are; InputError where they are no
        profile."""
        noise = self.noise
        whole = bool(r.size and r[0] < 0)
        _check_table(r, f, noise is None and not whole, whole)
        wrong = [bend for bend in self.bends if bend not in (np.abs(r) if whole else r[1:-1])]
        if wrong or any(not b > a for a, b in itertools.pairwise(self.bends)):
            raise InputError(
                f"profile table: bends must be radii of the table between its ends, increasing, got {list(self.bends)} "
                f"({f'{wrong[0]:g} is none' if wrong else 'not increasing'})"
            )
        if noise is None:
            # Number of the first point at which the slope falls, or the profile from the axis on; None: it is
            # convex
            chord = np.diff(f) / np.diff(r)
            dips = np.diff(chord) < -ROUNDED * max(float(np.max(np.abs(chord))), TINY)
            dip = 0 if chord[0] < 0 else int(np.argmax(dips)) + 1 if dips.any() else None
            if dip is None and not whole:
                return None
            noise = scatter(r, f) if r.size >= SMOOTHING_FEWEST else 0.0
            if not noise > ROUNDED * np.ptp(f):
                if whole or dip is None:
                    raise InputError(
                        "profile table: its two sides differ, and the points do not tell their scatter: say it, "
                        'noise = "0.05 nm", or give one side from the apex, r = 0, on'
                    )
                raise InputError(
                    f"profile table: must be convex, the slope falls at point {dip + 1} (r = {r[dip]:g} m); "
                    "JKR needs a contact disc that only grows: remove that point, or for measured points say how much "
                    'they scatter: noise = "0.05 nm"'
                )
        if whole:
            r, f = folded(r, f, noise)
        return smooth_convex(tuple(r.tolist()), tuple(f.tolist()), noise, self.bends)

    @property
    def a0(self) -> float:
        flat = np.logical_and.accumulate((self.pieces[1:] == 0).all(axis=0))
        return float(self.knots[np.count_nonzero(flat)])

    @property
    def r_max(self) -> float:
        return float(self.knots[-1])

    @property
    def tip_radius(self) -> float | None:
        _, slope, curvature, _ = self.pieces[:, 0]
        round_ = slope == 0 and curvature > ROUNDED * np.max(self.pieces[2])
        return float(1 / curvature) if round_ and self.a0 == 0 else None

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.knots[1:].tolist())

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        before = _ends(self.knots, self.pieces)[:, :-1]
        jumps = np.abs(self.pieces[1:3, 1:] - before[1:3])
        bends = (jumps > ROUNDED * np.max(self.pieces[1:3], axis=1, keepdims=True)).any(axis=0)
        return tuple(self.knots[1:-1][bends].tolist())

    @property
    def words(self) -> str:
        smooth, text = self.smooth, f"profile of {len(self.r)} points"
        if smooth is None:
            return text
        found = "stated" if self.noise is not None else "found from their scatter"
        return (
            f"{text}, smoothed: convex within a noise of {show(smooth.noise, 'length', 2)} ({found}), points off "
            f"by {show(smooth.rms, 'length', 2)} rms and {show(smooth.largest, 'length', 2)} at most, at r = "
            f"{show(smooth.at, 'length', 3)}"
        )

    @property
    def error_name(self) -> str:
        return super().error_name if self.smooth is None else "error from the measured profile"

    @property
    def remark(self) -> str:
        return "" if self.smooth is None else self.words

    def f(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        step, (f, slope, curvature, third) = self._piece(r)
        inside = f + step * (slope + step * (curvature / 2 + step * third / 6))
        return np.where(r <= self.r_max * (1 + 1e-12), inside, np.inf)

    def slope(self, r: Array) -> Array:
        step, (_, slope, curvature, third) = self._piece(np.asarray(r, dtype=float))
        return slope + step * (curvature + step * third / 2)

    def _piece(self, r: Array) -> tuple[Array, Array]:
        """How far each r [m] lies beyond the knot before it, and the derivatives (4, ...) there."""
        i = np.clip(np.searchsorted(self.knots, r, side="right") - 1, 0, self.knots.size - 2)
        return np.minimum(r, self.r_max) - self.knots[i], self.pieces[:, i]

    def abel(self, x: Array) -> Array:
        x = np.asarray(x, dtype=float)
        return np.where(x > 0, _images(self.knots, self.pieces, np.where(x > 0, x, 1.0))[0], 0.0)

    def abel_slope(self, x: Array) -> Array:
        return _images(self.knots, self.pieces, np.asarray(x, dtype=float))[1]

    def resolution(self, a: Array) -> Array:
        """Errors (2, n) of F [m] and of its slope [-] near radii ``a`` [m], as fewer points tell them: the error of the
        mean of F over the contact, which P feels, is part of the first. Next to the axis that of the slope is that of a
        tip."""
        if self.smooth is not None:
            (noisy,) = self._at(self._noise, a)
            return noisy
        changes, shares = self._at(self._resolved, a)
        F, slope, mean = changes * shares
        at_tip = np.where(np.asarray(a) < self._resolved[0][0], self._tip_error, 0.0)
        return np.stack([F + mean, np.maximum(slope, at_tip)])

    def left(self, a: Array) -> Array:
        return np.full((3, a.size), TABLE_OF_DRAWS) if self.smooth is not None else self._at(self._resolved, a)[1]

    def _at(self, columns: tuple[Array, ...], a: Array) -> list[Array]:
        """The ``columns`` after the first, even radii [m], at the next to each of ``a``."""
        x, *rest = columns
        return [values[:, np.clip(np.searchsorted(x, a), 0, x.size - 1)] for values in rest]

    @cached_property
    def _noise(self) -> tuple[Array, Array]:
        """Even radii [m] up to the end, and errors of F [m] and its slope there by what noise leaves open, (2, n): of F
        itself, which delta feels, or of F less its mean over the contact, which P does, the larger."""
        assert self.smooth is not None
        x = np.linspace(0, self.r_max, LOOKED_AT + 1)[1:]
        total = np.zeros((3, x.size))
        for knots, pieces in self.smooth.modes:
            F, slope = _images(knots, pieces, x)
            mean = np.cumsum(F) / np.arange(1.0, x.size + 1)
            total += np.array([F, F - mean, slope]) ** 2
        F, less_mean, slope = HALF_WIDTH * np.sqrt(total)
        return x, np.stack([np.maximum(F, less_mean), slope])

    @cached_property
    def _resolved(self) -> tuple[Array, Array, Array]:
        """Even radii [m] up to the end, what the thinned profiles change near each of F, its slope and the mean of F up
        to there, (3, n), and what is left over that."""
        x = np.linspace(0, self.r_max, LOOKED_AT + 1)[1:]
        halves = self.thinned
        seen, before = _changes(self, halves, x), _changes(halves[0], halves[0].thinned[:1], x)
        points, largest, shares = np.searchsorted(self.r, x).tolist(), np.empty((3, x.size)), np.empty((3, x.size))
        for i, k in enumerate(points):
            if len(self.r) < TABLE_FEW:
                largest[:, i], shares[:, i] = _most(seen, i // 2, i), 1 / np.array(TABLE_FEW_FACTORS)
                continue
            near, wider = np.empty(3), np.empty(3)
            for most, part, steps in ((near, seen, 1), (wider, before, 2)):  # among the points around the radius
                ends = self.r[max(k - 1 - steps, 0)], self.r[min(k + steps, len(self.r) - 1)]
                most[:] = _most(part, *np.clip(np.searchsorted(x, ends), 0, x.size - 1).tolist())
            near[2], wider[2] = seen[2, i], before[2, i]
            orders = np.divide(wider, near, out=np.full(3, np.inf), where=near > 0) - 1
            largest[:, i], shares[:, i] = near, TABLE_SAFETY / np.clip(orders, TABLE_FLATTEST, TABLE_STEEPEST)
        return x, largest, shares

    @cached_property
    def _tip_error(self) -> float:
        """Error of the slope of F [-] next to the axis, where the profile is extrapolated to a tip: where that is r^p,
        1 < p < 2, it falls with the power p - 1 < 1 of the spacing, as fewer points tell; where they tell no power any
        slope from none on is as convex. A cone, pi/2 times as steep in F, has no error."""
        tables: list[TableProfile] = [self]
        while len(tables) < 3 and len(tables[-1].r) >= 5:
            tables.append(tables[-1].thinned[0])
        error, *others = (float(table.pieces[1, 0]) for table in tables)
        if self.pieces[1, 1] - error <= ROUNDED * error:
            return 0.0
        if len(others) == 2:
            near, wider = abs(others[0] - error), abs(others[1] - others[0])
            error = min(TABLE_SAFETY * near**2 / max(wider - near, TINY), error)
        return math.pi / 2 * error

    @cached_property
    def thinned(self) -> tuple[TableProfile, ...]:
        """The profiles through every second point, ends and bends kept; of smoothed points other profiles that the
        noise leaves."""
        if self.smooth is not None:
            return tuple(_Drawn.of(self, self.smooth, number) for number in range(TABLE_DRAWS))
        r, f = np.array(self.r), np.array(self.heights)
        fixed = [0, r.size - 1, *np.searchsorted(r, self.bends)]
        rows = [np.unique([*fixed, *range(first, r.size, 2)]) for first in (0, 1)]
        return tuple(_Thinned(tuple(r[row]), tuple(f[row]), self.bends) for row in rows if row.size < r.size)


def _images(knots: Array, pieces: Array, x: Array) -> tuple[Array, Array]:
    """F(x) [m] and its slope [-] at radii x > 0 of any pieces: the slope alpha + beta r + gamma r^2 of f on one gives
    x [(alpha + gamma x^2/2) arcsin(r/x) - (beta + gamma r/2) sqrt(x^2 - r^2)]."""
    # The sums over all pieces of alpha times the change of arcsin(r/x), of beta times that of sqrt(x^2 - r^2) [m], of
    # gamma times the integral of r^2/sqrt(x^2 - r^2), and over jumps of the slope at knots k of k/sqrt(x^2 - k^2)
    # times them; r no larger than x; some x at a time, in little memory
    _, slope, curvature, gamma = pieces * np.array([[1.0], [1.0], [1.0], [0.5]])
    k = knots[:-1]
    alpha, beta = slope - k * (curvature - k * gamma), curvature - 2 * k * gamma
    jump = slope - np.append(slope[0], _ends(knots, pieces)[1, :-1])
    jump[np.abs(jump) < ROUNDED * np.max(np.abs(slope))] = 0.0
    columns = np.empty((4, x.size))
    step = max(AT_ONCE // knots.size, 1)
    for start in range(0, x.size, step):
        some = x.ravel()[start : start + step, None]
        r = np.minimum(knots[: np.searchsorted(knots, some.max()) + 1], some)
        root = np.sqrt((some - r) * (some + r))
        angle = np.arctan2(r, root)  # arcsin(r/x), also to rounding where x lies just beyond a knot
        last = r.shape[1] - 1
        turns, bent = np.diff(angle), np.diff(some**2 * angle - r * root) / 2
        steps = np.divide(r, root, out=np.zeros_like(r), where=root > 0)[:, :last] @ jump[:last]
        sums = turns @ alpha[:last], np.diff(root) @ beta[:last], bent @ gamma[:last], steps
        columns[:, start : start + step] = sums
    angles, roots, bent, jumps = columns.reshape(4, *x.shape)
    return x * (angles - roots + bent), angles - 2 * roots + 3 * bent + jumps


class _Drawn(TableProfile):
    """A profile that the noise leaves: the smooth one and a draw of its modes."""

    @classmethod
    def of(cls, table: TableProfile, smooth: SmoothProfile, number: int) -> _Drawn:
        rng = np.random.default_rng(number)
        knots = np.unique(np.concatenate([smooth.knots, *(knots for knots, _ in smooth.modes)]))
        pieces = cut_at(knots, smooth.knots, smooth.pieces)
        for own, mode in smooth.modes:
            pieces = pieces + rng.standard_normal() * cut_at(knots, own, mode)
        drawn = object.__new__(cls)
        for name, value in {**vars(table), "smooth": None, "knots": knots, "pieces": pieces}.items():
            if name not in ("_noise", "kinks", "thinned"):
                object.__setattr__(drawn, name, value)
        return drawn


class _Thinned(TableProfile):
    """A profile through some points of one that was checked, two at least."""

    def _check(self, r: Array, f: Array) -> SmoothProfile | None:
        return None


def _changes(of: TableProfile, others: Sequence[TableProfile], x: Array) -> Array:
    """How much the ``others`` differ at most in F [m], its slope [-] and the mean of F [m] up to each of the even radii
    ``x`` [m], (3, n)."""
    largest = np.zeros((3, x.size))
    for other in others:
        F = other.abel(x) - of.abel(x)
        mean = np.cumsum(F) / np.arange(1.0, x.size + 1)
        largest = np.maximum(largest, np.abs([F, other.abel_slope(x) - of.abel_slope(x), mean]))
    return largest


def _most(changes: Array, first: int, last: int) -> Array:
    """The largest of the ``changes`` (3, n) between two radii; of the mean that at the second."""
    return np.append(changes[:2, first : last + 1].max(axis=1), changes[2, last])


def _check_table(r: Array, f: Array, exact: bool, whole: bool) -> None:
    """Refuse what is no profile; ``exact``: heights without noise, of which the first is 0; ``whole``: both sides."""
    if r.size > TABLE_POINTS:
        raise InputError(
            f"profile table: has {r.size:,} points, at most {TABLE_POINTS:,} are taken; leave out points that lie "
            "nearly on the parabolas between their neighbours"
        )
    if r.ndim != 1 or r.shape != f.shape or r.size < 3:
        raise InputError(f"profile table: needs at least 3 points (r, f), got {r.size} and {f.size}")
    if not (np.isfinite(r).all() and np.isfinite(f).all()):
        raise InputError("profile table: holds a value that is not finite")
    if whole and r[-1] <= 0:
        raise InputError(f"profile table: a whole profile must reach beyond r = 0, got {r[0]:g} to {r[-1]:g}")
    if not whole and (r[0] != 0 or (exact and f[0] != 0)):
        raise InputError(f"profile table: must start at r = 0, f = 0, got ({r[0]:g}, {f[0]:g})")
    if (np.diff(r) <= 0).any():
        i = int(np.argmax(np.diff(r) <= 0)) + 1
        raise InputError(f"profile table: radii must increase, point {i + 1} has r = {r[i]:g} after {r[i - 1]:g}")
    if (min(f[0], f[-1]) <= f.min() + ROUNDED * np.ptp(f)) if whole else f[-1] <= f[0]:
        raise InputError("profile table: is flat; a flat end needs a rounded edge")


def _straight(chord: Array, start: float) -> Array:
    """Which intervals belong to a straight run: the ``chord`` on one side at least is the same, or the slope at the
    axis ``start``."""
    tiny = ROUNDED * float(np.max(chord))
    rising = np.diff(chord) > tiny
    return ~(np.append(chord[0] > start + tiny, rising) & np.append(rising, True))


def _with_corners(r: Array, f: Array, bends: Array) -> tuple[Array, Array, Array]:
    """The points with the corners at which a straight run, a worn end say, ends, and the numbers of all ``bends``.

    A run ends where what follows meets its line: the line of another run, else the parabola through the next three
    points. Where these do not meet, or without a jump of the slope, the profile goes on smoothly from the last point.
    """
    h, chord = np.diff(r), np.diff(f) / np.diff(r)
    straight = _straight(chord, _start(r, chord))
    corners = list[tuple[float, float]]()
    for i in (np.flatnonzero(~straight[1:] & straight[:-1]) + 1).tolist():
        if i in bends or i + 1 in bends or i + 2 > chord.size or (i + 3 > chord.size and not straight[i + 1]):
            continue

        # What follows over the line of the run, c + b y + a y^2 at y = r_(i+1) - x
        a = 0.0 if straight[i + 1] else (chord[i + 2] - chord[i + 1]) / (h[i + 1] + h[i + 2])
        b = chord[i - 1] - chord[i + 1] + a * h[i + 1]
        c = f[i + 1] - f[i] - chord[i - 1] * h[i]

        # They meet at its first zero, where the slope jumps by the root of b^2 - 4 a c
        square = max(b**2 - 4 * a * c, 0.0)
        if b >= 0 or square <= (TABLE_CORNER * b) ** 2:
            continue
        y = 2 * c / (math.sqrt(square) - b)
        if abs(y / h[i] - 1) < TABLE_NEAR:
            corners.append((r[i], f[i]))
        elif y < h[i]:
            corners.append((r[i + 1] - y, f[i] + chord[i - 1] * (h[i] - y)))
    if not corners:
        return r, f, bends
    x, height = np.array(corners).T
    new = ~np.isin(x, r)
    at = np.searchsorted(r, x[new])
    points, heights = np.insert(r, at, x[new]), np.insert(f, at, height[new])
    return points, heights, np.searchsorted(points, np.union1d(r[bends], x))


def _profile(r: Array, f: Array, bends: Array) -> tuple[Array, Array]:
    """Knots, and at the left end of each piece between them f and its three derivatives (4, pieces)."""
    chord = np.diff(f) / np.diff(r)
    # Slopes at the left and the right end of every interval, chord between them; one value on both sides but at bends
    start = _start(r, chord)
    straight = _straight(chord, start)
    ends = np.unique(np.concatenate([[0, chord.size], bends, np.flatnonzero(np.diff(straight)) + 1]))
    left, right = chord.copy(), chord.copy()
    for lo, hi in itertools.pairwise(ends.tolist()):
        if not straight[lo]:
            before = start if lo == 0 else chord[lo - 1] if straight[lo - 1] and lo not in bends else None
            after = chord[hi] if hi < chord.size and straight[hi] and hi not in bends else None
            slopes = _slopes(r[lo : hi + 1], f[lo : hi + 1], chord[lo:hi], before, after)
            left[lo:hi], right[lo:hi] = slopes[:-1], slopes[1:]
    middle = (chord[bends - 1] + chord[bends]) / 2
    right[bends - 1], left[bends] = np.minimum(right[bends - 1], middle), np.maximum(left[bends], middle)
    h, second = np.diff(r), 2 * (right - left)
    # curvatures (times h) at both ends of the cubic with these slopes
    first, last = 6 * chord - 4 * left - 2 * right, 2 * left + 4 * right - 6 * chord
    cubic = (np.minimum(first, last) >= -ROUNDED * second) | (second <= ROUNDED * chord)
    broken = np.flatnonzero(~cubic)  # into parabolas that meet where the slope is the chord's
    knots = np.insert(r, broken + 1, (r[:-1] + h * (right - chord) / np.where(cubic, 1.0, right - left))[broken])
    slopes = np.insert(left, broken + 1, chord[broken])
    ends = np.insert(right, broken, chord[broken])
    owner = np.insert(np.arange(h.size), broken, broken)
    bent = np.where(cubic[owner], first[owner] / h[owner], (ends - slopes) / np.diff(knots))
    third = np.where(cubic, (last - first) / h**2, 0.0)[owner]
    pieces = np.array([np.zeros_like(slopes), slopes, bent, third])
    pieces[0, 1:] = np.cumsum(_ends(knots, pieces)[0])[:-1]
    return knots, pieces


def _ends(knots: Array, pieces: Array) -> Array:
    """f, f', f'' (3, pieces) at the right end of every piece."""
    f, slope, curvature, third = pieces
    h = np.diff(knots)
    bent = curvature + h * third
    return np.array([f + h * (slope + h * (curvature / 2 + h * third / 6)), slope + h * (curvature + bent) / 2, bent])


def _start(r: Array, chord: Array) -> float:
    """The slope at the axis: of the parabola through the first points where they come to a tip there, else 0."""
    start = float(2 * chord[0] - _gentle(r, chord)[1])
    return start if start > TABLE_POINTED * chord[0] else 0.0


def _gentle(r: Array, chord: Array) -> Array:
    """Slopes at the points, of the parabola through each and its neighbours: between the chords, and beyond at ends."""
    h = np.diff(r)
    inner = (h[:-1] * chord[1:] + h[1:] * chord[:-1]) / (h[:-1] + h[1:])
    both = np.concatenate([[0.0], inner, [0.0]])
    both[[0, -1]] = 2 * chord[[0, -1]] - (both[[1, -2]] if inner.size else 0.0)
    return both


def _slopes(r: Array, f: Array, chord: Array, before: float | None, after: float | None) -> Array:
    """Slopes at points between which the profile bends everywhere, those at its ends where they are known: of the
    cubic spline, mirrored at a known first slope, or ``_gentle`` ones beside intervals where that is not convex."""
    gentle = _gentle(r, chord)
    if before is None:
        spline = spline_slopes(r, f)
    else:
        x, y = r - r[0], f - f[0] - before * (r - r[0])
        spline = before + spline_slopes(np.append(-x[:0:-1], x), np.append(y[:0:-1], y))[x.size - 1 :]
        spline[0] = gentle[0] = before
    for slopes in (gentle, spline):
        slopes[-1] = max(2 * chord[-1] - slopes[-2], chord[-1]) if slopes is gentle else slopes[-1]
        slopes[-1] = slopes[-1] if after is None else after
    if chord.size == 1 and before is None and after is not None:
        gentle[0] = 2 * chord[0] - after
    bends = np.minimum(3 * chord - 2 * spline[:-1] - spline[1:], spline[:-1] + 2 * spline[1:] - 3 * chord)
    rough = bends < -ROUNDED * chord[-1]
    beside = np.append(rough, False) | np.append(False, rough)
    return np.where(beside, gentle, spline)

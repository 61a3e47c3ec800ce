"""The smooth convex profile within the noise of a measured one.

f'' >= 0 is linear between knots, f' may jump where a worn end or a shoulder begins, and f'' with it. The coefficients
minimise the squares of the points over the noise plus lambda int (f''')^2 (P-splines with bounds; Pya and Wood, Stat.
Comput. 25 (2015) 543); lambda and the corners are those of the least Cp (Mallows, Technometrics 15 (1973) 661). What
the noise leaves open are the modes of the posterior covariance, which holds the bias of smoothing too (Nychka, J. Am.
Stat. Assoc. 83 (1988) 1134).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base.errors import InputError
from ...base.numerics import Array
from ...base.units import show

# Knots, corners and what is taken for noise.
SMOOTHING_KNOTS = (6, 24)  # choice: at least and at most, f'' is smoothed between them
SMOOTHING_POINTS_PER_KNOT = 3  # choice: at least
# choice: of log10 lambda, in units of noise and length
SMOOTHING_STRENGTHS = (-12.0, 2.0, 15)
# of log10 lambda, where a corner is sought; choice: with the corner the rest may be far smoother than without it
SMOOTHING_COARSE = (-11.0, 2.0, 5)
SMOOTHING_CORNER = 12.0  # by which Cp must fall for a corner; choice: two unknowns, and forty places are tried
SMOOTHING_FLAT = 4.0  # chi^2 by which a flat end may be worse; choice: two standard errors
SMOOTHING_CORNERS = 2  # choice: most that are found
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


def smooth_convex(r: Array, f: Array, noise: float, bends: Array) -> SmoothProfile:
    """The smooth convex profile within the ``noise`` [m] of the points, with corners at ``bends`` [m] and where the
    points show them; InputError where they depart from any convex one by more."""
    best = _Fit.of(r, f, noise, tuple(bends.tolist()))
    for _ in range(SMOOTHING_CORNERS):
        other = best.with_corner()
        if other.cp > best.cp - SMOOTHING_CORNER:
            break
        best = other
    best = best.with_flat_end()
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
    return SmoothProfile(knots, pieces, best.modes, noise, rms, largest, float(r[worst]))


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit with given ``corners`` [-], in units of the largest radius and the noise; ``flat``: the profile up to the
    first corner is. ``x`` (n,), ``y`` (n,): the points. ``coarse``: few lambdas are tried."""

    x: Array
    y: Array
    unit: tuple[float, float]  # of lengths r and f [m]
    corners: tuple[float, ...]
    flat: bool = False
    coarse: bool = False

    @classmethod
    def of(cls, r: Array, f: Array, noise: float, bends: tuple[float, ...]) -> _Fit:
        length = float(r[-1])
        return cls(r / length, f / noise, (length, noise), tuple(bend / length for bend in bends))

    def tried(self, corner: float, flat: bool) -> _Fit:
        """The fit with a further corner, ``flat`` up to the first one; by few lambdas."""
        return replace(self, corners=tuple(sorted((*self.corners, corner))), flat=flat, coarse=True)

    def with_corner(self) -> _Fit:
        """The fit with the best further corner: a point at the axis, or one in between by a golden section. A flat end
        is tried along with the corner: it leaves fewer unknowns, so that the points show the two where they do not
        show a corner alone."""
        places = np.linspace(self.x[2], self.x[-3], min(SMOOTHING_PLACES, self.x.size))
        apart = float(places[1] - places[0])
        places = places[np.all(np.abs(places[:, None] - np.array([-1.0, *self.corners])) > apart, axis=1)]
        ends = (False,) if 0.0 in self.corners else (False, True)
        tries = [self.tried(place, flat) for place in places.tolist() for flat in ends]
        best = min(tries, key=lambda fit: fit.cp)
        (place,) = set(best.corners) - set(self.corners)
        low, high = max(place - apart, float(self.x[1])), min(place + apart, float(self.x[-2]))
        ratio = (math.sqrt(5) - 1) / 2
        for _ in range(SMOOTHING_STEPS):
            left, right = high - ratio * (high - low), low + ratio * (high - low)
            closer = self.tried(left, best.flat).cp < self.tried(right, best.flat).cp
            low, high = (low, right) if closer else (left, high)
        last = [self.tried((low + high) / 2, best.flat)]
        last += [] if 0.0 in self.corners else [self.tried(0.0, False)]
        return replace(min([best, *last], key=lambda fit: fit.cp), coarse=False)

    def with_flat_end(self) -> _Fit:
        """The fit with a flat end up to the first corner, where the points allow one."""
        if not self.corners or self.corners[0] == 0 or self.flat:
            return self
        other = replace(self, flat=True)
        return other if other.chi2 < self.chi2 + SMOOTHING_FLAT else self

    # ------------------------------------------------------------------ columns: offset, jumps of slope, f'' at nodes
    @cached_property
    def segments(self) -> list[Array]:
        """The nodes of f'' between corners."""
        least, most = SMOOTHING_KNOTS
        count = int(np.clip(self.x.size // SMOOTHING_POINTS_PER_KNOT, least, most))
        edges = [0.0, *(c for c in self.corners if c > 0), 1.0]
        return [
            np.linspace(low, high, max(round(count * (high - low)), 2) + 1) for low, high in itertools.pairwise(edges)
        ]

    @cached_property
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
        for strength in np.logspace(*(SMOOTHING_COARSE if self.coarse else SMOOTHING_STRENGTHS)):
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
        """One standard error of each mode of the posterior: of the coefficients, and of the places of the corners."""
        moved = [place for place in self.corners if place > 0]
        jumps = {place: self.values[1 + i] for i, place in enumerate(self.corners)}
        steps = [np.where(self.x > place, -jumps[place], 0.0) for place in moved]
        design = np.column_stack([self.columns, *steps])
        rough = np.pad(self.penalty, ((0, 0), (0, len(moved))))
        inverse = np.linalg.pinv(design.T @ design + self.best[1] * rough.T @ rough)
        sizes, vectors = np.linalg.eigh((inverse + inverse.T) / 2)
        count = self.columns.shape[1]
        modes = []
        for size, vector in zip(sizes, vectors.T, strict=True):
            knots, pieces = self.knots, self.pieces_of(vector[1:count])
            for place, shift in zip(moved, vector[count:], strict=True):
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

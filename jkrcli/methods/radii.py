"""Contact radii for a loading by depth, load or radius: root search on delta_H(a) and P_H(a) of any solver.

Both grow like powers of v = sqrt(a^2 - a0^2), so that the search runs in logarithms, without any unit.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError, Refusal, SolveError
from ..base.numerics import MOST_STEPS, SAME, TINY, Array
from ..base.units import show
from ..bodies.indenters import Indenter
from ..bodies.problem import Loading, Quantity

Response = Callable[[Array], Array]  # increasing radii [m] -> delta_H [m] or P_H [N] there
Responses = Callable[[Quantity, float], Response]  # "depth" or "load", relative accuracy -> its response

# theory: radii in a geometric sequence, over four decades splines err by 5/384 (ln 1e4/59)^4 = 8e-6 of f''''
DENSE = 60
ROOM = 1.05  # choice: over a radius, so that it lies within a solution
ROUGH = 1e-5  # accuracy of the first part of every search; choice: what costs least

# How radii are followed to the depths and loads of a loading.
# a second radius beside each trial, for the slope; tuned on loads, by `make constants`: what costs least
SEARCH_PROBE = 0.98
# Largest factor between trials, as a larger contact costs more:
SEARCH_STRIDE = 3.0  # choice: what costs least
SEARCH_TABLE = 48  # radii of the first response to all targets; choice: what costs least
# Times the accuracy, from where a step leads within it; theory: a secant over ``probe`` errs by some 1 - probe of
# the slope, so that 30/50 of the accuracy are left
SEARCH_NEAR = 30.0
SEARCH_ABOVE_KINK = 14  # theory: 1.95 from one to the next, where cubics follow a root to 1e-4
SEARCH_NEAREST = 1e-4  # of the distance to the next row, the first of them; theory: its root is 1e-2
SEARCH_FARTHEST = 0.6  # the last; choice: half way
# Part of a miss left after a step along a tangent, above which none is taken; theory: halving leaves as much
SEARCH_DOUBTFUL = 0.5


@dataclass(frozen=True)
class Search:
    """The contact radii that a ``loading`` asks for of an ``indenter`` on a body with the contact modulus ``E_star``
    [Pa], whose layers act over the length ``scale`` [m].

    ``responses`` of growing ``accuracies``, relative, are followed one after the other.
    """

    loading: Loading
    indenter: Indenter
    E_star: float
    responses: Responses
    accuracies: Sequence[float]
    scale: float = math.inf

    @property
    def radii(self) -> Array:
        """All contact radii [m], increasing."""
        loading = self.loading
        if loading.spacing == "given" and loading.to == "radius":
            for a in loading.values:
                check_radius(self.indenter, a)
            return np.array(loading.values)
        radii = self._spaced(self.largest)
        if loading.spacing == "given":
            return radii
        # The kinks of the profile among them, and rows that crowd above each: F begins there with a power 1/2 or 3/2
        # of the distance, and is smooth below
        for kink in self.indenter.kinks:
            if max(self.indenter.a0, radii[0]) < kink < radii[-1]:
                steps = np.geomspace(SEARCH_NEAREST, SEARCH_FARTHEST, SEARCH_ABOVE_KINK)
                beyond = steps * (radii[np.searchsorted(radii, kink, side="right")] - kink)
                close = np.abs(radii / kink - 1) < SAME
                radii = np.unique(np.concatenate([radii[~close], [kink], kink + beyond]))
        return radii

    @property
    def largest(self) -> float:
        """The contact radius [m] at which the loading ends: a rough search first, then ever more accurate ones."""
        loading = self.loading
        if loading.to == "radius":
            check_radius(self.indenter, loading.maximum)
            return loading.maximum
        if self.indenter.rim < math.inf:
            return self.indenter.rim
        start = self._start
        try:
            for accuracy in self.accuracies:
                response = self.responses(loading.to, accuracy)
                start = radius_for(response, loading.maximum, self.indenter, start, accuracy)
        except (Refusal, SolveError) as error:
            raise Refusal(f"loading: a {loading.to} of {loading.goal} cannot be reached: {error}") from None
        return start

    @property
    def _start(self) -> float:
        """A first radius [m]: that of a half-space, F(a) = delta or about 4/3 E* a F(a) = P, but no more than twice the
        length over which layers act."""
        indenter, target, to = self.indenter, self.loading.maximum, self.loading.to
        lengths = (self.scale, indenter.tip_radius, indenter.a0, indenter.r_max, target if to == "depth" else None)
        start = next(length for length in (*lengths, 1.0) if length and math.isfinite(length))

        def response(a: Array) -> Array:
            return indenter.abel(a) if to == "depth" else 4 / 3 * self.E_star * a * indenter.abel(a)

        try:
            guess = radius_for(response, target, indenter, 1.5 * start, 0.1)
        except Refusal:
            guess = indenter.r_max / 2
        return min(guess, max(2 * self.scale, 1.1 * indenter.a0))

    def _spaced(self, largest: float) -> Array:
        """The radii [m] up to the ``largest``, by the loading's spacing."""
        loading, a0 = self.loading, self.indenter.a0
        if loading.spacing == "radius" or (self.indenter.rim < math.inf and loading.spacing != "log"):
            return np.linspace(a0, largest, loading.points + 1)[1:]
        if loading.spacing == "log":
            return graded_radii(a0, largest, loading.points)
        if loading.spacing in ("depth", "load"):
            end = float(self.responses(loading.spacing, self.accuracies[-1])(np.array([largest]))[0])
            return self._at(loading.spacing, end * np.arange(1, loading.points + 1) / loading.points, largest)
        return self._at(loading.to, np.array(loading.values), largest)

    def _at(self, quantity: Quantity, targets: Array, largest: float) -> Array:
        """Contact radii [m] for the increasing ``targets``, the last of which is reached at ``largest`` [m]."""
        if targets.size == 1:
            return np.array([largest])
        a0, log_target = self.indenter.a0, np.log(targets)
        # v at the targets to begin with, from a table of the response between their ends
        response = self.responses(quantity, self.accuracies[0])
        first = radius_for(response, float(targets[0]), self.indenter, math.hypot(a0, 0.3 * _v(largest, a0)), 0.1)
        v = np.geomspace(0.7 * _v(first, a0), _v(largest, a0), SEARCH_TABLE)
        table = np.log(v), np.log(response(np.hypot(a0, v)))
        low, high, secant, _ = _bracketed(table, log_target)
        log_v = _inverse(*table, log_target)
        log_v = np.where((low < log_v) & (log_v < high), log_v, secant)
        log_v = np.append(np.sort(log_v[:-1]), np.log(v[-1]))
        for accuracy in self.accuracies:
            log_v = _followed(self.responses(quantity, accuracy), log_v, log_target, a0, accuracy)
        return np.hypot(a0, np.exp(log_v))


def graded_radii(a0: float, largest: float, points: int) -> Array:
    """Radii [m] whose sqrt(a^2 - a0^2) is a geometric sequence over four decades up to ``largest``."""
    v = _v(largest, a0)
    radii = np.hypot(a0, np.geomspace(1e-4 * v, v, points)) if points > 1 else np.array([largest])
    radii[-1] = largest
    return radii


def check_radius(indenter: Indenter, a: float) -> None:
    """Refuse a contact radius ``a`` [m] that lies within the flat end or beyond the profile."""
    a0, end = indenter.a0, min(indenter.r_max, indenter.rim)
    if a <= a0:
        raise InputError(f"loading: contact radius {a:g} m must be larger than the flat end of the indenter ({a0:g} m)")
    with np.errstate(divide="ignore", invalid="ignore"):
        if a <= end and np.isfinite(indenter.abel(np.array(a))):
            return
    raise Refusal(
        f"loading: a contact radius of {show(a, 'length')} lies beyond the profile, which ends at "
        f"r = {show(end, 'length')}; use less, or give a larger profile"
    )


def radius_for(response: Response, target: float, indenter: Indenter, start: float, tolerance: float) -> float:
    """The contact radius a [m] at which ``response`` is ``target``, to the relative ``tolerance`` of the response.

    ``start``: a first radius [m]. Newton steps in logarithms within a bracket. Refusal where the contact would reach
    beyond the profile.
    """
    a0, end = indenter.a0, indenter.r_max * (1 - 1e-12)
    low, high = 0.0, _v(end, a0)
    v, tried_end = min(math.sqrt(max(start**2 - a0**2, 0.0)) or start, high / 2), False
    for _ in range(MOST_STEPS):
        values = response(np.hypot(a0, np.array([SEARCH_PROBE * v, v])))
        if not 0 < values.min() < values.max() < math.inf:
            raise SolveError(f"no contact radius beyond {a0:g} m, where contact begins, was found: check the sizes")
        miss = math.log(values[1] / target)
        slope = math.log(values[1] / values[0]) / -math.log(SEARCH_PROBE)
        if abs(miss) <= SEARCH_NEAR * tolerance:
            return math.hypot(a0, min(v * math.exp(-miss / slope), high))
        if tried_end and v == high and miss < 0:
            break
        low, high = (v, high) if miss < 0 else (low, v)
        proposal = v * min(max(math.exp(-miss / slope), 1 / SEARCH_STRIDE), SEARCH_STRIDE)
        if proposal >= high:
            tried_end = miss < 0 and math.isfinite(high)
            proposal = high if tried_end else math.sqrt(v * max(low, v / SEARCH_STRIDE))
        elif proposal <= low:
            proposal = math.sqrt(v * low)
        v = proposal
    else:
        raise SolveError(f"no contact radius was found in {MOST_STEPS} steps, last a = {v:g} m; is the value right?")
    raise Refusal(
        f"it needs a contact radius beyond the profile, which ends at r = {show(indenter.r_max, 'length')}; "
        "use less, or give a larger profile"
    )


def _followed(response: Response, log_v: Array, log_target: Array, a0: float, accuracy: float) -> Array:
    """Newton steps for all targets but the last at once; within brackets, or secants of them, where slopes jump."""
    known: tuple[Array, Array] = np.empty(0), np.empty(0)
    before = np.full(log_target.size, np.inf)
    for _ in range(MOST_STEPS):
        log_values = np.log(response(np.hypot(a0, np.exp(log_v))))
        # Part of a miss that may be left after a step along the tangent: by how much the secants on both sides
        # differ.
        secants = np.diff(log_v) / np.diff(log_values)
        jumps = np.abs(np.diff(secants)) / np.minimum(np.abs(secants[1:]), np.abs(secants[:-1]))
        inner = np.pad(jumps, 1, mode="edge") if jumps.size else np.zeros(log_v.size)
        miss, doubt = np.abs(log_values - log_target), np.clip(np.nan_to_num(inner, nan=1.0), 1 / SEARCH_NEAR, 1.0)
        tangent = _inverse(log_v, log_values, log_target)
        near = miss * doubt <= accuracy
        if near[:-1].all():
            return np.append(np.sort(np.where(doubt < SEARCH_DOUBTFUL, tangent, log_v)[:-1]), log_v[-1])
        # All known points, both coordinates increasing.
        all_v, first = np.unique(np.concatenate([known[0], log_v]), return_index=True)
        known = all_v, np.maximum.accumulate(np.concatenate([known[1], log_values])[first])
        low, high, secant, middle = _bracketed(known, log_target)
        step = np.where(doubt < SEARCH_DOUBTFUL, tangent, secant)
        step = np.where((low < step) & (step < high) & (near | (miss < before / 2)), step, middle)
        log_v = np.append(np.sort(step[:-1]), log_v[-1])  # the response wants them increasing
        before = miss
    count = log_target.size
    raise SolveError(f"loading: the contact radii of {count} increments were not found in {MOST_STEPS} passes")


def _inverse(log_v: Array, log_values: Array, log_target: Array) -> Array:
    """Values of log v at the targets, from the tangents at the nearest known point."""
    slopes = np.gradient(log_v, log_values)
    near = np.clip(np.searchsorted((log_values[1:] + log_values[:-1]) / 2, log_target), 0, log_values.size - 1)
    return log_v[near] + slopes[near] * (log_target - log_values[near])


def _bracketed(known: tuple[Array, Array], log_target: Array) -> tuple[Array, Array, Array, Array]:
    """Of points whose coordinates log v and log response both increase: log v on both sides of each target, infinite
    where there is none; the secant between them, and a point that narrows every bracket, half-way to the secant, so
    that it differs for each target."""
    v, values = known
    above = np.searchsorted(values, log_target)
    low, high = np.append(-np.inf, v)[above], np.append(v, np.inf)[above]
    left, right = np.clip([above - 1, above], 0, v.size - 1)
    rise = np.maximum(values[right] - values[left], TINY)
    part = np.clip((log_target - values[left]) / rise, 0, 1)
    beyond = math.log(SEARCH_STRIDE) * np.isinf(low)
    secant, middle = (v[left] + x * (v[right] - v[left]) - beyond for x in (part, 0.25 + 0.5 * part))
    return low, high, secant, middle


def _v(a: float, a0: float) -> float:
    return math.sqrt((a - a0) * (a + a0))

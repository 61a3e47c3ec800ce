"""What a sum of exponentials remembers of a quantity that is a polynomial of time from step to step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...base import Array
from ...bodies import Modes


@dataclass(frozen=True)
class MomentTuning:
    """How moments of exponentials are computed."""

    large: float = 2.0  # theory: exponent from which the recursion upwards, of up to seven steps, loses one digit
    # theory: terms of the recursion downwards below an exponent, 2^22/22! = 4e-15 of its begin is left at the end
    terms: tuple[tuple[float, int], ...] = ((1e-3, 5), (large, 22))


TUNING = MomentTuning()


def moments(x: Array, count: int) -> Array:
    """int_0^1 exp(-x (1 - y)) y^j dy at ``x`` >= 0 of any shape, for j < ``count``, (count, ...)."""
    if count == 1:
        return np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0)[None]
    values, least = np.empty((count, *x.shape)), -1.0
    for most, terms in TUNING.terms:
        band = (x > least) & (x <= most)
        values[:, band], least = _downwards(x[band], count, terms), most
    large = x > least
    beyond = x[large]
    above = -np.expm1(-beyond) / beyond
    for j in range(count):
        values[j, large] = above
        above = (1 - (j + 1) * above) / beyond
    return values


def _downwards(x: Array, count: int, terms: int) -> Array:
    """The moments by the recursion from so many ``terms`` beyond them."""
    values, below = np.empty((count, x.size)), np.full_like(x, 1.0 / (count + terms + 1))
    for j in range(count + terms, 0, -1):
        below = (1 - x * below) / j
        if j <= count:
            values[j - 1] = below
    return values


def remembered(p: Array, x: Array) -> Array:
    """int_0^1 exp(-x (1 - y)) dp(y) of polynomials, ``p`` (..., n) of rising powers of y, at ``x`` (..., m)."""
    by_power = moments(x, p.shape[-1] - 1)
    return np.asarray(sum((j + 1) * p[..., j + 1, None] * moment for j, moment in enumerate(by_power)))


@dataclass(frozen=True, eq=False)
class Steps:
    """A quantity q over time: in step k, from ``t[k]`` to ``t[k + 1]`` [s], the polynomial ``p[k]`` (n) of its fraction
    y; equal times are a jump. ``modes``: what remembers it, from ``t[0]`` on, where q is 0. A place is k + y."""

    modes: Modes
    t: Array
    p: Array

    @cached_property
    def states(self) -> Array:
        """int exp(-rate (t - s)) dq(s) at all times ``t``, (times, m)."""
        x = np.diff(self.t)[:, None] * self.modes.rates
        states = [np.zeros(x.shape[1])]
        for factor, gain in zip(np.exp(-x), remembered(self.p, x), strict=True):
            states.append(factor * states[-1] + gain)
        return np.array(states)

    def places(self, t: Array) -> Array:
        """The places of times ``t``, behind a jump."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, self.t.size - 2)
        h, since = self.t[k + 1] - self.t[k], t - self.t[k]
        return np.asarray(k + np.clip(np.divide(since, h, out=np.ones_like(since), where=h > 0), 0.0, 1.0))

    def times(self, places: Array) -> Array:
        """The times [s] of ``places`` (n,)."""
        k, since, _ = self.parts(places)
        return self.t[k] + since

    def parts(self, places: Array) -> tuple[Array, Array, Array]:
        """The step of each of the ``places`` (n,), the time since its begin, and the polynomial of that time's
        fractions."""
        k = np.clip(places.astype(int), 0, self.t.size - 2)
        y = places - k
        return k, y * (self.t[k + 1] - self.t[k]), self.p[k] * y[:, None] ** np.arange(self.p.shape[1])

    def values(self, places: Array) -> Array:
        """q at ``places`` (n,)."""
        return np.asarray(self.parts(places)[2].sum(axis=1))

    def rates(self, places: Array) -> Array:
        """Derivative of q by the place, at ``places`` (n,)."""
        k, powers = np.clip(places.astype(int), 0, self.t.size - 2), np.arange(1, self.p.shape[1])
        return np.asarray(((places - k)[:, None] ** (powers - 1) * (powers * self.p[k, 1:])).sum(axis=1))

    def integrals_to_ends(self, now: Array) -> Array:
        """The ``integral`` up to all times ``t`` seen from the times ``now`` [s] behind them, (now, times)."""
        since = np.maximum(now[:, None] - self.t, 0.0)
        values = np.append(self.p[:, 0], self.p[-1].sum())
        integrals = self.modes.relaxed * values + np.zeros_like(since)
        for weight, rate, state in zip(self.modes.weights, self.modes.rates, self.states.T, strict=True):
            integrals += weight * state * np.exp(-rate * since)
        return integrals

    def integral(self, places: Array, now: Array) -> Array:
        """The hereditary integral int r(now - s) dq(s) up to ``places`` (n,), seen from the times ``now`` [s] there or
        later."""
        return self.view(places, now).integral(self)

    def view(self, places: Array, now: Array) -> View:
        """What the ``integral`` needs of ``places`` and times alone."""
        k, since, _ = self.parts(places)
        x, modes = since[:, None] * self.modes.rates, self.modes
        weights = modes.weights * np.exp(-np.maximum(now - self.t[k] - since, 0.0)[:, None] * modes.rates)
        return View(k, places - k, weights, weights * np.exp(-x), moments(x, self.p.shape[1] - 1))


class View(NamedTuple):
    """Places in steps seen from later times: the steps ``k`` (n,) and fractions ``y`` (n,); ``weights`` of the modes,
    those of what was remembered at the steps' begins, (n, m), and the ``moments`` of these modes, (j, n, m)."""

    k: Array
    y: Array
    weights: Array
    of_states: Array
    moments: Array

    def integral(self, of: Steps) -> Array:
        """int r dq of a quantity in the same steps, of the same degree or less."""
        p = of.p[self.k] * self.y[:, None] ** np.arange(of.p.shape[1])
        grown = np.zeros_like(self.weights)
        for j, moment in enumerate(self.moments[: p.shape[1] - 1]):
            grown += (j + 1) * p[:, j + 1, None] * moment
        seen = np.sum(self.of_states * of.states[self.k] + self.weights * grown, axis=1)
        return np.asarray(of.modes.relaxed * p.sum(axis=1) + seen)

"""Least squares under noise whose neighbours follow each other: drift, hum, 1/f, slow steps.

The noise is what the free rows of a record say, without any model of the contact. Its spectrum, S(f) = A + B/(1 +
(f/c)^2)^(b/2), white and of one correlation time (b = 2) or of a power of the frequency (c far below all), follows by
the likelihood of Whittle (Ark. Mat. 2, 423, 1953) from the squares of the cosine transform of their residuals in
octaves, each divided by the share of it that the fit has left; where too few rows are free, from that of all. Spectra
that are nearly as likely have a share in it, as they go on differently below the frequencies that are seen. The cosine
transform takes a series that ends elsewhere than it began for no jump.

With rows weighted by W the covariance of the unknowns is (WJ)^+ W C W^T (WJ)^+T, C the noise (White, Econometrica 48,
817, 1980); where W C W^T = 1, the generalised least squares, it is the least there is.
Noise slower than the free rows are long hides in them (a random walk of a fifth of the white noise, in every fifth
record): where they tell none that is slow, its colour is that of all residuals, if they are as likely with it and it
raises standard errors by no more than ``TUNING.hidden``. Other residuals in contact that are larger or slower are no
noise: an excess reports them. Where noise goes on rising below the frequencies of the free rows (1/f) nothing tells
how far: standard errors are wider there, by the excess too.
An octave stands at the frequency where 1/f has its mean over what the fit has left of it: at that of its middle, the
lowest octave of a run, of which a straight line was taken, would tell two thirds of such noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import dct, idct

from ...base import TINY, Array


@dataclass(frozen=True)
class ColouredTuning:
    """How spectra are estimated."""

    corners: int = 24  # choice: correlation times tried, from a few rows to the whole record
    powers: tuple[float, ...] = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # choice: of 1/f, tried
    rounds: int = 8  # choice: of reweighting; the likelihood is then good to 1e-3
    share: float = 0.25  # choice: of an octave that the fit must have left, below which it joins the next
    least: float = 4.0  # theory: Akaike's criterion, 2 ln of the likelihoods' ratio for two more parameters
    beside: int = 8  # choice: least rows on each side of missing ones, whose means a line goes through
    likely: float = 0.05  # choice: of the likeliest spectrum, likelihood below which one has no share
    free: int = 40  # choice: free rows of a direction that tell its noise
    seen: float = 4.0  # choice: of the lowest frequency of the free rows, the lowest corner that they tell
    # choice: of the lowest frequency of the free rows, the corner of a power of f: below what a record sees, but not so
    # far that its mean says nothing of the offsets
    lowest: float = 0.05
    # of standard errors, where noise goes on rising at frequencies that no free row tells; tuned on cycles with 1/f
    # noise, by `make record-bounds`
    unseen: float = 1.1
    exceeded: float = 2.0  # choice: of the noise there, what the rows in contact say more of it at most
    # choice: of standard errors, by which slow noise that free rows do not tell may raise them; more is misfit
    hidden: float = 3.0
    white: float = 0.5  # theory: before the data nothing speaks for a slow part of the noise or against it
    # choice: of the white part at the lowest frequency that free rows tell, the slow parts that may hide
    heights: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
    singular: float = 1e-12  # theory: of the largest singular value, round-off of some thousand rows, each 2e-16


TUNING = ColouredTuning()


@dataclass(frozen=True)
class Spectrum:
    """A + sum of B/(1 + (f/c)^2)^(b/2) over frequencies f per row, ``slow`` parts (B, c, b)."""

    A: float
    slow: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, f: Array) -> Array:
        density: Array = self.A + sum((B * _slow(f, corner, power) for B, corner, power in self.slow), np.zeros_like(f))
        return density

    def of_level(self, A: float) -> Spectrum:
        """The same colour where the white part is ``A``."""
        return Spectrum(A, tuple((A / self.A * B, corner, power) for B, corner, power in self.slow))

    def beyond(self, f: float) -> bool:
        """Whether most of it goes on rising at frequencies below ``f``, which no run of free rows tells."""
        unseen = Spectrum(0.0, tuple(part for part in self.slow if part[1] < f))
        at = np.array(f)
        return bool(unseen(at) > self(at) / 2)

    def whitened(self, columns: Array) -> Array:
        """Columns of rows in the order of time, (rows, ...), so that this noise has unit variance and no colour."""
        if not self.slow:
            return columns / math.sqrt(self.A)
        return (waves(columns).T / np.sqrt(self(frequencies(len(columns))))).T

    def drawn(self, rng: np.random.Generator, rows: int) -> Array:
        """A series of so many ``rows`` of this noise."""
        series: Array = idct(np.sqrt(self(frequencies(rows))) * rng.normal(size=rows), norm="ortho")
        return series


@dataclass(frozen=True, eq=False)
class Spread:
    """``covariance`` of the unknowns; ``tau``: how many rows count as one, the factor by which the colour of the noise
    raises their variances; ``excess``: the factor by which the residuals of all rows would widen the standard errors
    beyond it (both medians). ``dof``: rows that determine the ``noise``; ``possible``: where it is white, what it may
    be as well, each with its chance."""

    covariance: Array
    tau: float
    excess: float
    dof: int
    noise: Spectrum
    possible: Possible | None = None


@dataclass(frozen=True, eq=False)
class Possible:
    """Spectra that a noise may have, each with its ``chance``: A + B/(1 + (f/c)^2)^(b/2), the white one first, then
    those of each ``corner`` c and ``power`` b, for one height of the slow part after the other."""

    chance: Array
    A: Array
    B: Array
    corner: Array
    power: Array

    def of_waves(self, f: Array, squares: Array) -> Array:
        """The sums of ``squares`` (n, columns) of waves of frequencies ``f`` (n, columns), each by what a spectrum has
        there: (spectra, columns)."""
        slow = np.sum(_slow(f, self.corner[:, None, None], self.power[:, None, None]) * squares, axis=1)
        every = np.tile(slow, ((self.A.size - 1) // len(slow), 1))
        energy: Array = np.outer(self.A, squares.sum(axis=0))
        energy[1:] += self.B[1:, None] * every
        return energy


def _slow(f: Array, corner: Array | float, power: Array | float) -> Array:
    shape: Array = (1 + (f / corner) ** 2) ** (-np.asarray(power) / 2)
    return shape


def waves(columns: Array) -> Array:
    """The orthonormal cosine transform of columns of rows."""
    transform: Array = dct(columns, axis=0, norm="ortho")
    return transform


def in_time(columns: Array, rows: Array, noise: Spectrum) -> Array:
    """Columns of some ``rows`` of a record in the order of time. Over the rows that are missing straight lines through
    the means of as many beside them, as much of them as ``noise`` of that length is slow: it goes on meanwhile."""
    order = np.argsort(rows)
    columns, rows = columns[order], rows[order] - rows.min()
    series = np.zeros((int(rows[-1]) + 1, *columns.shape[1:]))
    series[rows] = columns
    for i in np.flatnonzero(np.diff(rows) > 1) + 1:
        count = int(rows[i] - rows[i - 1]) - 1
        slow = 1 - noise.A / float(noise(np.array(1 / (2 * count))))
        beside = max(count, TUNING.beside)
        first, last = (slow * part.mean(axis=0) for part in (columns[max(i - beside, 0) : i], columns[i : i + beside]))
        share = np.arange(1, count + 1) / (count + 1)
        series[rows[i - 1] + 1 : rows[i]] = first + np.multiply.outer(share, last - first)
    return series


def frequencies(rows: int) -> Array:
    """Those of the cosine transform, per row."""
    return np.arange(rows) / (2 * rows)


def spread(off: Array, J: Array, free: Sequence[Array], weight: Spectrum, rounding: float = 0.0) -> Spread:
    """The covariance of unknowns from residuals ``off`` and their derivatives ``J``, in the order of time, that were
    fitted with the ``weight`` of such noise; very large where the data do not determine an unknown. ``free``:
    residuals of runs of rows out of contact; ``rounding``: variance of readings in steps of a converter, the least."""
    f = frequencies(off.size)
    own = weight(f)
    rows = waves(np.column_stack([J, off])) / np.sqrt(own)[:, None]
    scale = np.linalg.norm(rows[:, :-1], axis=0)
    scale[scale == 0] = 1.0
    U, s, V = np.linalg.svd(rows[:, :-1] / scale, full_matrices=False)
    root = (V / np.maximum(s, TUNING.singular * s[0])[:, None] / scale).T
    all_rows = Octaves.of(f, rows[:, -1] ** 2, np.sum(U**2, axis=1)).spectrum()
    every = all_rows(f) * own
    loose = sum(run.size for run in free)
    seen = _of_base_lines(free, rounding) if loose >= TUNING.free else None
    noise = Spectrum(float(np.mean(every))) if seen is None else seen.spectrum()

    def of(noise: Array | float) -> Array:
        matrix: Array = root @ (U.T * (noise / own)) @ U @ root.T
        return matrix

    beside, covariance = of(every), of(every if seen is None else noise(f))
    if seen is not None and _rise(beside, covariance) < TUNING.hidden**2:
        noise = _hidden(seen, noise, weight if weight.slow else all_rows)
        covariance = of(noise(f))
    tau = _rise(covariance, of(float(np.mean(every if seen is None else noise(f)))))
    excess = math.sqrt(max(_rise(beside, covariance), 1.0))
    if seen is not None and noise.beyond(1 / (2 * max(run.size for run in free))):
        covariance = covariance * (TUNING.unseen * min(excess, TUNING.exceeded)) ** 2
    possible = None if seen is None or noise.slow else seen.possible()
    return Spread(covariance, max(tau, 1.0), excess, off.size if seen is None else loose, noise, possible)


def _rise(one: Array, other: Array) -> float:
    """The median factor between the variances of two covariances."""
    known = np.diag(other) > 0
    return float(np.median((np.diag(one) / np.diag(other))[known])) if known.any() else 1.0


def _hidden(seen: Octaves, noise: Spectrum, every: Spectrum) -> Spectrum:
    """The noise of free rows that were ``seen``; where their own ``noise`` is not slow, of the colour of
    ``every`` row if it is as likely in them: noise slower than they are long shows in the others."""
    if noise.slow or not every.A:
        return noise
    likely = every.of_level(noise.A)
    return likely if seen.unlikely(likely) <= seen.unlikely(noise) else noise


def _of_base_lines(runs: Sequence[Array], rounding: float) -> Octaves:
    """The residuals of runs of free rows, of each of which the fit has taken a straight line, their variance not below
    that of ``rounding``, which a line that stands still does not show."""
    parts = []
    for off in runs:
        line = np.linalg.qr(np.stack([np.ones(off.size), np.arange(off.size)], axis=1))[0]
        left = off - line @ (line.T @ off)
        parts.append((frequencies(off.size), waves(left) ** 2, np.sum(waves(line) ** 2, axis=1)))
    f, power, taken = (np.concatenate(items) for items in zip(*parts, strict=True))
    order = np.argsort(f, kind="stable")
    octaves = Octaves.of(f[order], power[order], taken[order])
    return replace(octaves, mean=np.maximum(octaves.mean, max(rounding, TINY)))


@dataclass(frozen=True, eq=False)
class Octaves:
    """The ``mean`` squares of the waves of a series in octaves about frequencies ``centre``, each from the ``count``
    of them that the fit has left; ``lowest``: the lowest frequency above 0."""

    mean: Array
    count: Array
    centre: Array
    lowest: float

    @classmethod
    def of(cls, f: Array, power: Array, taken: Array) -> Octaves:
        """By the squares of the ``waves`` at frequencies ``f``; ``taken``: how much of each of them the fit has."""
        left, lowest = 1 - np.minimum(taken, 1.0), float(f[f > 0][0])
        edges = _octaves(left)
        count = np.add.reduceat(left, edges)
        centre = count / np.add.reduceat(left / np.maximum(f, lowest / 2), edges)  # where 1/f is its mean
        return cls(np.add.reduceat(power, edges) / count, count, centre, lowest)

    def unlikely(self, noise: Spectrum) -> float:
        """Minus twice the logarithm of Whittle's likelihood of a spectrum."""
        return float(_unlikely(self.mean, noise(self.centre)[None], self.count)[0])

    def spectrum(self) -> Spectrum:
        """The spectrum that is likeliest, with those that are nearly so; white where none that falls gains enough."""
        mean, count, centre, lowest = self.mean, self.count, self.centre, self.lowest
        white = float(np.average(mean, weights=count))
        most = _unlikely(mean, np.stack([np.full(mean.size, white), _falling(mean, count)]), count)
        if most[0] < most[1] + TUNING.least:
            return Spectrum(white)  # no spectrum that falls gains as much
        corner, power = _shapes(lowest)
        slow = _slow(centre, corner[:, None], power[:, None])
        tops = slow[:, 0].copy()
        slow /= tops[:, None]
        A, B = _parts(slow, mean, count)
        deviance = _unlikely(mean, A[:, None] + B[:, None] * slow, count)
        if deviance.min() > most[0] - TUNING.least:
            return Spectrum(white)
        share = np.exp((deviance.min() - deviance) / 2)
        share = np.where(share > TUNING.likely, share, 0.0) / share[share > TUNING.likely].sum()
        parts = zip((share * B / tops).tolist(), corner.tolist(), power.tolist(), strict=True)
        return Spectrum(float(share @ A), tuple(part for part in parts if part[0]))

    def possible(self) -> Possible:
        """Spectra with their chances after the data: white or with one slow part, those of one correlation time and
        those of 1/f being as likely before."""
        (corner, power), heights = _shapes(self.lowest), np.array(TUNING.heights)
        slow = _slow(self.centre, corner[:, None], power[:, None])
        tops = slow[:, 0]
        ratio = np.vstack([np.zeros(self.centre.size), *(heights[:, None, None] * (slow / tops[:, None]))])
        A = np.average(self.mean / (1 + ratio), weights=self.count, axis=1)
        kinds = np.repeat([1 / TUNING.corners, 1 / len(TUNING.powers)], [TUNING.corners, len(TUNING.powers)]) / 2
        before = np.append(TUNING.white, np.tile((1 - TUNING.white) / heights.size * kinds, heights.size))
        unlikely = _unlikely(self.mean, A[:, None] * (1 + ratio), self.count)
        chance = before * np.exp((unlikely.min() - unlikely) / 2)
        B = A * np.append(0.0, np.outer(heights, 1 / tops))
        return Possible(chance / chance.sum(), A, B, corner, power)


def _shapes(lowest: float) -> tuple[Array, Array]:
    """Corners and powers of slow parts, of one correlation time and of 1/f, of runs of a ``lowest`` frequency."""
    corners, powers = np.geomspace(TUNING.seen * lowest, 0.2, TUNING.corners), np.array(TUNING.powers)
    return np.append(corners, 0 * powers + TUNING.lowest * lowest), np.append(0 * corners + 2.0, powers)


def _falling(mean: Array, count: Array) -> Array:
    """The likeliest spectrum of octaves with these ``mean`` squares that rises nowhere: means of those that do pooled
    (Barlow et al., Statistical Inference under Order Restrictions, 1972)."""
    pools: list[tuple[float, float, int]] = []  # mean, weight, octaves
    for one, weight in zip(mean.tolist(), count.tolist(), strict=True):
        pool = one, weight, 1
        while pools and pools[-1][0] < pool[0]:
            before = pools.pop()
            weights = before[1] + pool[1]
            pool = (before[0] * before[1] + pool[0] * pool[1]) / weights, weights, before[2] + pool[2]
        pools.append(pool)
    levels, _, octaves = zip(*pools, strict=True)
    return np.maximum(np.repeat(levels, octaves), TUNING.singular * mean.max())


def _octaves(left: Array) -> Array:
    """First index of each octave of frequencies; one of which too little is ``left`` joins the next."""
    edges, first = [0], 1
    while 2 * first < left.size:
        if left[edges[-1] : first].sum() > max(TUNING.share * (first - edges[-1]), TUNING.share):
            edges.append(first)
        first *= 2
    return np.array(edges)


def _unlikely(mean: Array, S: Array, count: Array) -> Array:
    """Minus twice the logarithm of Whittle's likelihood of spectra ``S``, (spectra, octaves)."""
    likely = np.maximum(S, TUNING.singular * mean.max())
    deviance: Array = np.where((S > 0).all(axis=1), np.sum(count * (np.log(likely) + mean / likely), axis=1), np.inf)
    return deviance


def _parts(slow: Array, mean: Array, count: Array) -> tuple[Array, Array]:
    """A and B, not below 0, that are likeliest for each shape ``slow``, (corners, octaves), by least squares weighted
    with the spectrum so far."""
    items = np.stack([np.ones_like(slow), slow, slow**2, np.broadcast_to(mean, slow.shape), slow * mean])
    S = np.broadcast_to(np.maximum(mean, 1e-3 * mean.max()), slow.shape)
    for _ in range(TUNING.rounds):
        weights = count / np.maximum(S, TINY) ** 2
        aa, ab, bb, a, b = np.einsum("ij,kij->ki", weights, items)
        determinant = aa * bb * (1 + TUNING.singular) - ab * ab
        A, B = (a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant
        A, B = np.where(B < 0, a / aa, np.where(A < 0, 0.0, A)), np.where(B < 0, 0.0, np.where(A < 0, b / bb, B))
        S = A[:, None] + B[:, None] * slow
    return A, B

"""Covariance of least squares under noise whose neighbours follow each other: drift, hum, slow steps.

The noise is what the free rows of a direction say, without any model of the contact. Its spectrum, S(f) = A + B/(1 +
(f/c)^2), white and of one correlation time, is found by the likelihood of Whittle (Ark. Mat. 2, 423, 1953) from the
periodogram of their residuals in octaves, each divided by the share of it that the fit has left; where too few rows are
free, from that of all. The covariance is then that of White (Econometrica 48, 817, 1980),
(J^T J)^-1 J^T C J (J^T J)^-1.
Residuals in contact that are larger or slower are no noise: they are told as an excess.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...base.arrays import Array


@dataclass(frozen=True)
class ColouredTuning:
    """How spectra are found."""

    corners: int = 24  # choice: correlation times tried, from a few rows to the whole record
    rounds: int = 8  # choice: of reweighting; the likelihood is then good to 1e-3
    share: float = 0.25  # choice: of an octave that the fit must have left, below which it joins the next
    least: float = 4.0  # choice: of 2 ln of the likelihoods' ratio that a second part of the spectrum must gain
    free: int = 40  # choice: free rows of a direction that tell its noise
    untold: float = 1e-12  # choice: least singular value over the largest, below which rounding has the word


TUNING = ColouredTuning()


@dataclass(frozen=True, eq=False)
class Spread:
    """``covariance`` of the unknowns; ``tau``: how many rows count as one, the factor by which the colour of the noise
    raises their variances; ``excess``: the factor by which the residuals of all rows would widen the standard errors
    beyond it (both medians). ``dof``: rows that told the noise."""

    covariance: Array
    tau: float
    excess: float
    dof: int


@dataclass(frozen=True)
class Spectrum:
    """A + B/(1 + (f/``corner``)^2) over frequencies f per row."""

    A: float
    B: float
    corner: float

    def __call__(self, f: Array) -> Array:
        return self.A + self.B / (1 + (f / self.corner) ** 2)

    def drawn(self, rng: np.random.Generator, rows: int) -> Array:
        """A series of so many ``rows`` of this noise."""
        f = np.fft.rfftfreq(rows)
        found: Array = np.fft.irfft(np.sqrt(self(f)) * np.fft.rfft(rng.normal(size=rows)), rows)
        return found


def spread(off: Array, J: Array, sizes: Sequence[int], free: Sequence[int]) -> Spread:
    """The covariance of unknowns from residuals ``off`` and their derivatives ``J``, in stretches of ``sizes`` rows, of
    each of which the first ``free`` rows are out of contact; very large where the data do not tell an unknown."""
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    U, s, V = np.linalg.svd(J / scale, full_matrices=False)
    root = (V / np.maximum(s, TUNING.untold * s[0])[:, None] / scale).T
    middle, whole, white, dof = np.zeros((J.shape[1],) * 2), np.zeros((J.shape[1],) * 2), 0.0, 0
    ends = np.cumsum(sizes)[:-1]
    for r, u, loose in zip(np.split(off, ends), np.split(U, ends), free, strict=True):
        waves, f = np.fft.rfft(u, axis=0, norm="ortho"), np.arange(r.size // 2 + 1) / r.size
        twice = np.full(len(waves), 2.0)  # both signs of a frequency
        twice[0] = 1.0
        if r.size % 2 == 0:
            twice[-1] = 1.0
        every = noise = _spectrum(r, np.sum(np.abs(waves) ** 2, axis=1))(f)
        if loose >= TUNING.free:
            noise = _of_base_line(r[:loose])(f)
        middle += np.real((waves.T * (twice * noise)) @ waves.conj())
        whole += np.real((waves.T * (twice * every)) @ waves.conj())
        white += float(np.average(noise, weights=twice)) * r.size / off.size
        dof += loose if loose >= TUNING.free else r.size
    covariance, beside = root @ middle @ root.T, root @ whole @ root.T
    plain = white * np.sum(root**2, axis=1)
    told = plain > 0
    tau, excess = (float(np.median(np.diag(one)[told] / two[told])) if told.any() else 1.0
                   for one, two in ((covariance, plain), (beside, np.diag(covariance))))  # fmt: skip
    return Spread(covariance, max(tau, 1.0), math.sqrt(max(excess, 1.0)), dof)


def noise_of(off: Array, free: int) -> Spectrum:
    """Spectrum of the noise in residuals of which the first ``free`` rows are out of contact: theirs, where they are
    enough, else that of all."""
    off = off[:free] if free >= TUNING.free else off
    return _of_base_line(off)


def _of_base_line(off: Array) -> Spectrum:
    """Spectrum of the residuals of free rows, of which the fit has taken a straight line."""
    line = np.linalg.qr(np.stack([np.ones(off.size), np.arange(off.size)], axis=1))[0]
    left = off - line @ (line.T @ off)
    return _spectrum(left, np.sum(np.abs(np.fft.rfft(line, axis=0, norm="ortho")) ** 2, axis=1))


def _spectrum(off: Array, taken: Array) -> Spectrum:
    """The spectrum of ``off``; ``taken``: how much of each frequency of its transform the fit has taken."""
    power = np.abs(np.fft.rfft(off, norm="ortho")) ** 2
    f = np.arange(power.size) / off.size
    edges = _octaves(1 - np.minimum(taken, 1.0))
    count = np.add.reduceat(1 - np.minimum(taken, 1.0), edges)
    mean = np.add.reduceat(power, edges) / count
    centre = np.add.reduceat(np.maximum(f, f[1] / 2), edges) / np.diff(np.append(edges, f.size))
    white = float(np.average(mean, weights=count))
    corners = np.geomspace(0.3 * f[1], 0.2, TUNING.corners)
    slow = 1 / (1 + (centre / corners[:, None]) ** 2)
    A, B = _parts(slow, mean, count)
    found = _unlikely(mean, A[:, None] + B[:, None] * slow, count)
    i = int(np.argmin(found))
    if found[i] < _unlikely(mean, np.full((1, mean.size), white), count)[0] - TUNING.least:
        return Spectrum(float(A[i]), float(B[i]), float(corners[i]))
    return Spectrum(white, 0.0, 1.0)


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
    likely = np.maximum(S, TUNING.untold * mean.max())
    found: Array = np.where((S > 0).all(axis=1), 2 * np.sum(count * (np.log(likely) + mean / likely), axis=1), np.inf)
    return found


def _parts(slow: Array, mean: Array, count: Array) -> tuple[Array, Array]:
    """A and B, not below 0, that are likeliest for each shape ``slow``, (corners, octaves), by least squares weighted
    with the spectrum found so far."""
    S = np.broadcast_to(np.maximum(mean, 1e-3 * mean.max()), slow.shape)
    for _ in range(TUNING.rounds):
        weights = count / np.maximum(S, 1e-300) ** 2
        aa, ab, bb = (np.sum(weights * item, axis=1) for item in (1.0, slow, slow**2))
        a, b = (np.sum(weights * item, axis=1) for item in (mean, slow * mean))
        determinant = aa * bb * (1 + TUNING.untold) - ab * ab
        A, B = (a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant
        A, B = np.where(B < 0, a / aa, np.where(A < 0, 0.0, A)), np.where(B < 0, 0.0, np.where(A < 0, b / bb, B))
        S = A[:, None] + B[:, None] * slow
    return A, B

"""Covariance of least squares under noise whose neighbours follow each other: drift, hum, slow steps.

The residuals' spectrum per direction, S(f) = A + B/(1 + (f/c)^2), white and of one correlation time, is found by the
likelihood of Whittle (Ark. Mat. 2, 423, 1953) from the periodogram in octaves, each divided by the share of it that the
fit has left. The covariance is then that of White (Econometrica 48, 817, 1980), (J^T J)^-1 J^T C J (J^T J)^-1.
"""

from __future__ import annotations

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
    untold: float = 1e-12  # choice: least singular value over the largest, below which rounding has the word


TUNING = ColouredTuning()


@dataclass(frozen=True, eq=False)
class Spread:
    """``covariance`` of the unknowns; ``tau``: how many rows count as one, the factor by which the colour of the noise
    raises their variances (its median)."""

    covariance: Array
    tau: float


def spread(off: Array, J: Array, sizes: Sequence[int]) -> Spread:
    """The covariance of unknowns from residuals ``off`` and their derivatives ``J``, in stretches of ``sizes`` rows;
    very large where the data do not tell an unknown."""
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    U, s, V = np.linalg.svd(J / scale, full_matrices=False)
    root = (V / np.maximum(s, TUNING.untold * s[0])[:, None] / scale).T
    middle, white = np.zeros((J.shape[1], J.shape[1])), 0.0
    ends = np.cumsum(sizes)[:-1]
    for r, u in zip(np.split(off, ends), np.split(U, ends), strict=True):
        waves = np.fft.rfft(u, axis=0, norm="ortho")
        twice = np.full(len(waves), 2.0)  # both signs of a frequency
        twice[0] = 1.0
        if r.size % 2 == 0:
            twice[-1] = 1.0
        S = _spectrum(r, np.sum(np.abs(waves) ** 2, axis=1))
        middle += np.real((waves.T * (twice * S)) @ waves.conj())
        white += float(np.average(S, weights=twice)) * r.size / off.size
    covariance = root @ middle @ root.T
    plain = white * np.sum(root**2, axis=1)
    told = plain > 0
    ratios = np.diag(covariance)[told] / plain[told]
    return Spread(covariance, max(float(np.median(ratios)), 1.0) if ratios.size else 1.0)


def _spectrum(off: Array, taken: Array) -> Array:
    """S at the frequencies of the transform of ``off``; ``taken``: how much of each the fit has taken."""
    power = np.abs(np.fft.rfft(off, norm="ortho")) ** 2
    f = np.arange(power.size) / off.size
    edges = _octaves(1 - np.minimum(taken, 1.0))
    count = np.add.reduceat(1 - np.minimum(taken, 1.0), edges)
    mean = np.add.reduceat(power, edges) / count
    centre = np.add.reduceat(np.maximum(f, f[1] / 2), edges) / np.diff(np.append(edges, f.size))
    white = np.average(mean, weights=count)
    best, held = _unlikely(mean, np.full(mean.size, white), count) - TUNING.least, np.full(f.size, white)
    for corner in np.geomspace(0.3 * f[1], 0.2, TUNING.corners):
        basis = np.stack([np.ones(mean.size), 1 / (1 + (centre / corner) ** 2)])
        A, B = _parts(basis, mean, count)
        found = _unlikely(mean, A + B * basis[1], count)
        if found < best:
            best, held = found, A + B / (1 + (f / corner) ** 2)
    return held


def _octaves(left: Array) -> Array:
    """First index of each octave of frequencies; one of which too little is ``left`` joins the next."""
    edges, first = [0], 1
    while 2 * first < left.size:
        if left[edges[-1] : first].sum() > max(TUNING.share * (first - edges[-1]), TUNING.share):
            edges.append(first)
        first *= 2
    return np.array(edges)


def _unlikely(mean: Array, S: Array, count: Array) -> float:
    """Minus twice the logarithm of Whittle's likelihood."""
    return 2 * float(np.sum(count * (np.log(S) + mean / S))) if (S > 0).all() else np.inf


def _parts(basis: Array, mean: Array, count: Array) -> tuple[float, float]:
    """A and B, not below 0, that are likeliest, by least squares weighted with the spectrum found so far."""
    S = np.maximum(mean, 1e-3 * mean.max())
    for _ in range(TUNING.rounds):
        weights = count / np.maximum(S, 1e-300) ** 2
        (aa, ab), (_, bb) = ((basis * weights) @ basis.T).tolist()
        a, b = ((basis * weights) @ mean).tolist()
        determinant = aa * bb * (1 + TUNING.untold) - ab * ab
        A, B = (a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant
        if B < 0:
            A, B = a / aa, 0.0
        elif A < 0:
            A, B = 0.0, b / bb
        S = A * basis[0] + B * basis[1]
    return A, B

"""The cosine transform of records, with NumPy alone: importing SciPy's takes longer than most fits."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..base.numerics import TOGETHER, Array
from ..base.process import REMEMBERED


def cosine_transform(rows: Array) -> Array:
    """The orthonormal cosine transform (DCT-II) of real numbers, (..., n), along the last axis."""
    n = rows.shape[-1]
    # even places, then odd ones backwards: the transform is the real part of the turned Fourier transform (Makhoul,
    # IEEE Trans. ASSP 28 (1980) 27), whose upper half is minus the imaginary part of the lower, in reverse
    folded, half = np.empty(rows.shape), n - n // 2
    folded[..., :half], folded[..., half:] = rows[..., ::2], rows[..., 1::2][..., ::-1]
    waves = np.fft.rfft(folded)
    waves *= _turns(n)
    folded[..., : n // 2 + 1] = waves.real
    np.negative(waves.imag[..., 1:half][..., ::-1], out=folded[..., n // 2 + 1 :])
    return folded


@lru_cache(maxsize=TOGETHER)  # of arrays as long as a record
def _turns(n: int) -> Array:
    """sqrt(2/n) exp(-i pi k/(2n)), and 1/sqrt(n) for k = 0: what makes a cosine transform of that of Fourier."""
    turns: Array = math.sqrt(2 / n) * np.exp(-0.5j * np.pi / n * np.arange(n // 2 + 1))
    turns[0] *= math.sqrt(0.5)
    return turns


@lru_cache(maxsize=REMEMBERED)
def fast_length(n: int) -> int:
    """The least number from ``n`` on without a prime factor above 5, whose Fourier transform is fast."""
    powers = [3**i * 5**j for i in range(n.bit_length()) for j in range(n.bit_length())]
    return min(power << max(-(-n // power) - 1, 0).bit_length() for power in powers)

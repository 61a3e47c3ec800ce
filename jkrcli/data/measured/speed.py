"""The rate of a recorded quantity: least-squares parabolas over a moving window of rows."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.special import stdtrit

from ...base.errors import InputError
from ...series import Array

LEAST_WINDOW = 5  # rows: a parabola and two more for its error


def check_window(window: int) -> None:
    """Refuse a window without a middle row, or too short for a parabola with an error."""
    if window < LEAST_WINDOW or window % 2 == 0:
        raise InputError(f"--window: must be an odd number of rows, at least {LEAST_WINDOW}, got {window}")


def rate(t: Array, y: Array, window: int) -> tuple[Array, Array]:
    """dy/dt and its 90 % half-width at each row, from the parabola through the ``window`` rows around it.

    ``t`` strictly increasing, of at least ``window`` (odd) rows, spaced as they are; near the ends the first or last
    window is evaluated off its middle. The half-width is of the scatter about the parabolas: what these smooth away is
    not in it. (Savitzky and Golay's first derivative, Anal. Chem. 36 (1964) 1627, for any spacing.)
    """
    starts = np.clip(np.arange(t.size) - window // 2, 0, t.size - window)
    times, values = (np.lib.stride_tricks.sliding_window_view(column, window)[starts] for column in (t, y))
    half = (times[:, -1] - times[:, 0]) / 2
    x = (times - t[:, None]) / half[:, None]
    powers = np.stack([np.ones_like(x), x, x**2], axis=2)
    normal = np.einsum("nik,nil->nkl", powers, powers)
    middle = values[:, window // 2, None]
    coefficients = np.linalg.solve(normal, np.einsum("nik,ni->nk", powers, values - middle)[..., None])
    residuals = values - middle - (powers @ coefficients)[..., 0]
    variance = np.sum(residuals**2, axis=1) / (window - 3) * np.linalg.inv(normal)[:, 1, 1]
    return coefficients[:, 1, 0] / half, stdtrit(window - 3, 0.95) * np.sqrt(variance) / half


def runs(whole: Array) -> list[slice]:
    """The longest stretches of rows in which every step to the next row is ``whole`` (a mask, one shorter)."""
    ends = [0, *(np.flatnonzero(~whole) + 1), whole.size + 1]
    return [slice(int(first), int(last)) for first, last in itertools.pairwise(ends)]

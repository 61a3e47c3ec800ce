"""Stated widths against the scatter that they are stated for."""

import numpy as np
from numpy.typing import ArrayLike


def mean_squares(off: ArrayLike, width: ArrayLike, quantile: float = 1.0) -> np.ndarray:
    """The means of z^2 over the first axis, z: how far estimates are ``off`` in standard errors, where their ``width``
    is ``quantile`` of these. They are about 1 where widths are right, 1/4 where they are doubled, 4 where halved."""
    return np.mean(np.square(np.asarray(off) * quantile / np.asarray(width)), axis=0)


def assert_neither_doubled_nor_halved(squares: ArrayLike) -> None:
    """That means of z^2 lie within a factor of four about 1: of widths that are doubled or halved none does, whatever
    was drawn."""
    assert np.min(squares) > 0.5, squares
    assert np.max(squares) < 2.0, squares

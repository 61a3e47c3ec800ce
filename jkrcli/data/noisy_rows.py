"""Rows of a growing contact whose columns fall here and there: by noise, or because they are in another order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.arrays import Array


@dataclass(frozen=True)
class NoisyRowsTuning:
    """What noise does not do to the order of rows."""

    fewest: int = 8  # choice: rows; of fewer none can be spared
    ordered: float = 0.85  # rank correlation of a column with the rows; choice: 10 % noise on 15 rows leaves more
    hidden: float = 0.1  # choice: of the rows, at the beginning, whose displacement or load noise may hide


TUNING = NoisyRowsTuning()


def is_noise(size: Array, delta: Array, P: Array) -> bool:
    """Whether rows in contact rise on the whole, so that falls of radius (or area), displacement, load are noise.

    Rows that are unloading at the end, repeat a displacement only, or stand in another order are no noise.
    """
    if size.size < TUNING.fewest or not all(_rises(column) for column in (size, delta, P)):
        return False
    hidden = np.flatnonzero((delta <= 0) | (P <= 0))
    if hidden.size and hidden[-1] >= TUNING.hidden * size.size:
        return False
    falls = np.stack([np.diff(column) < 0 for column in (size, delta, P)])
    return bool(falls.any()) and not _unloads(falls)


def _rises(column: Array) -> bool:
    ranks = np.argsort(np.argsort(column, kind="stable"), kind="stable")
    return float(np.corrcoef(np.arange(column.size), ranks)[0, 1]) > TUNING.ordered


def _unloads(falls: Array) -> bool:
    """Whether all falls (columns, steps) are those of all columns together, at the end."""
    together: Array = np.all(falls, axis=0)
    last = int(np.argmin(together[::-1]))  # steps at the end in which all fall
    return last > 0 and not falls[:, : falls.shape[1] - last].any()

"""Rows of a growing contact whose columns fall here and there: by noise, or because they are in another order.

A radius, displacement or load that is not positive holds no contact: noise does that to the rows near first touch, and
an outlier to a row by itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Array


@dataclass(frozen=True)
class NoisyRowsTuning:
    """What noise does not do to the order of rows."""

    fewest: int = 8  # choice: rows; of fewer none can be spared
    # rank correlation of a column with the rows; tuned on imported tables, by `make constants`: 10 % noise on 15 rows
    # leaves more
    ordered: float = 0.85
    # tuned on imported tables, by `make constants`: of the rows, those near first touch that noise may hide, and those
    # of outliers
    hidden: float = 0.1

    @property
    def window(self) -> int:
        """Rows among which outliers alone hide one."""
        return round(1 / self.hidden)

    @property
    def dense(self) -> float:
        """Share of hidden rows near first touch, two of a window; noise of the load alone leaves 0.3."""
        return 2 / self.window


TUNING = NoisyRowsTuning()


def is_noise(size: Array, delta: Array, P: Array) -> bool:
    """Whether rows in contact rise on the whole, so that falls of radius (or area), displacement, load are noise.

    Rows that are unloading at the end, repeat a displacement only, or stand in another order are no noise.
    """
    if size.size < TUNING.fewest or not all(_rises(column) for column in (size, delta, P)):
        return False
    hidden = (delta <= 0) | (P <= 0)
    first = near_first_touch(hidden)
    if max(first, hidden[first:].sum()) - 1 >= TUNING.hidden * size.size:
        return False
    falls = np.stack([np.diff(column) < 0 for column in (size, delta, P)])
    return bool(falls.any()) and not _unloads(falls)


def near_first_touch(hidden: Array) -> int:
    """Number of rows in contact that lie near first touch: up to the last ``hidden`` one, (n,), that stands among
    enough others, of all rows and of those just before it."""
    n, before = np.arange(1, hidden.size + 1), np.concatenate([[0], np.cumsum(hidden)])
    near = np.maximum(n - TUNING.window, 0)
    share = np.minimum(before[n] / n, (before[n] - before[near]) / (n - near))
    return int(np.max(np.flatnonzero(hidden & (share >= TUNING.dense)), initial=-1)) + 1


def _rises(column: Array) -> bool:
    """Whether the ranks of a column (n,) follow its rows, but for the few that lie farthest off: those of outliers."""
    ranks, rows = np.argsort(np.argsort(column, kind="stable"), kind="stable"), np.arange(column.size)
    most = column.size - int(TUNING.hidden * column.size)
    followed = np.argsort(np.abs(ranks - rows), kind="stable")[:most]
    return float(np.corrcoef(rows[followed], ranks[followed])[0, 1]) > TUNING.ordered


def _unloads(falls: Array) -> bool:
    """Whether all falls (columns, steps) are those of all columns together, at the end."""
    together: Array = np.all(falls, axis=0)
    last = int(np.argmin(together[::-1]))  # steps at the end in which all fall
    return last > 0 and not falls[:, : falls.shape[1] - last].any()

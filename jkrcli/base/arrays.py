"""The array type of all annotations: floats in a NumPy array, docstrings give the shape; rows spread evenly."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray[Any, np.dtype[Any]]


def evenly(rows: int, most: int) -> Array:
    """The numbers of at most ``most`` of so many ``rows``, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, rows - 1, min(rows, most)).astype(int))

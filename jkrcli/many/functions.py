"""What the Python interface offers of many bodies."""

from __future__ import annotations

from typing import Any

from ..base.arguments import checked
from ..base.process import one_thread
from .maps import MapResult, map_of

__all__ = ["study_map"]


@checked
def study_map(name: str, **axes: Any) -> MapResult:
    """Compute a map of results over parameters, as ``jkr study <name>-map`` does.

    Parameters
    ----------
    name : str
        "pull-off", "sticking", "transition", "adhesion" or "rate".
    **axes
        Values of its parameters: ``study_map("pull-off", nu=[0.3], q=[0.1, 1])``.

    Returns
    -------
    MapResult
        ``columns``, ``summary()`` and ``figure()``.

    Raises
    ------
    InputError
        Where an axis is unknown, or a value is out of its range.
    """
    return one_thread()(map_of(name).over)(**axes)

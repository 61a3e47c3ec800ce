"""Contact radii finer than a node spacing, from increments whose radius is that of the outermost contact node.

Between two increments the contact disc reached the next node: at a depth between theirs, with that node's radius.
The increment with the new radius, taken alone (the paper's filter), is late by up to a whole increment; the middle of
the two is late or early by at most half of one, and this is known, so that it can be weighed.
"""

from __future__ import annotations

import numpy as np

from ...base import Array
from ...series import RawSeries, filter_plateaus


def has_plateaus(raw: RawSeries) -> bool:
    """Whether radii repeat while depth and load go on, as node-based radii do: at one increment in five at least."""
    raw = raw.touching
    if raw.a.size < 2 or min(raw.delta[0], raw.P[0]) <= 0:
        return False
    a, delta, P = (np.diff(values) for values in (raw.a, raw.delta, raw.P))
    return bool(np.mean(a == 0) > 0.2 and np.all(a >= 0) and np.all(delta > 0) and np.all(P > 0))


def touch_events(raw: RawSeries) -> tuple[RawSeries, dict[str, Array]]:
    """The events "the next node is reached" of a series with plateaus, and the 90 % half-width of their radii [m].

    Depth: the middle of the two increments around the event; load: at this depth on the line through the increments
    in log P over log delta (they lie on P(delta), whatever the radius). The half-width is that of the depth, read as
    one of the radius by the local slope of log a over log delta.
    """
    risen, _ = filter_plateaus(raw)
    log_delta, log_P = np.log(raw.touching.delta), np.log(raw.touching.P)
    after = risen.delta
    before = np.array([np.max(raw.delta[raw.delta < depth], initial=0.0) for depth in after])
    middle = (before + after) / 2
    slope = np.gradient(np.log(risen.a), np.log(middle)) if risen.a.size > 1 else np.ones(1)
    half_width = 0.9 / 2 * (after - before) / middle * np.abs(slope) * risen.a
    first = (log_P[1] - log_P[0]) / (log_delta[1] - log_delta[0])
    load = np.interp(np.log(middle), log_delta, log_P) + first * np.minimum(np.log(middle) - log_delta[0], 0)
    return RawSeries(risen.a, middle, np.exp(load)), {"a": half_width}

"""Contact radii for a loading by depth, load or radius: root search on delta_H(a) and P_H(a) of any solver.

Both grow like powers of v = sqrt(a^2 - a0^2), so that the search runs in logarithms, without any unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..errors import Refusal, SolveError
from ..indenters import Indenter

Array = np.ndarray
Response = Callable[[Array], Array]  # increasing radii [m] -> delta_H [m] or P_H [N] there

STEPS = 80
PROBE = 0.98  # a second radius beside each trial, for the slope
STRIDE = 3.0  # largest factor from one trial to the next, as a larger contact costs more
TABLE = 48
NEAR = 30.0  # a step from this many times the accuracy leads well within it


def radius_for(response: Response, target: float, indenter: Indenter, start: float, tolerance: float) -> float:
    """The contact radius a [m] at which ``response`` is ``target``, to the relative ``tolerance`` of the response.

    ``start``: a first radius [m]. Newton steps in logarithms within a bracket. Refusal where the contact would reach
    beyond the profile.
    """
    a0, end = indenter.a0, indenter.r_max * (1 - 1e-12)
    low, high = 0.0, math.sqrt((end - a0) * (end + a0)) if math.isfinite(end) else math.inf
    v, tried_end = min(math.sqrt(max(start**2 - a0**2, 0.0)) or start, high / 2), False
    for _ in range(STEPS):
        values = response(np.hypot(a0, np.array([PROBE * v, v])))
        miss = math.log(values[1] / target)
        slope = math.log(values[1] / values[0]) / -math.log(PROBE)
        if abs(miss) <= NEAR * tolerance:
            return math.hypot(a0, min(v * math.exp(-miss / slope), high))
        if tried_end and v == high and miss < 0:
            break
        low, high = (v, high) if miss < 0 else (low, v)
        proposal = v * min(max(math.exp(-miss / slope), 1 / STRIDE), STRIDE)
        if proposal >= high:
            tried_end = miss < 0 and math.isfinite(high)
            proposal = high if tried_end else math.sqrt(v * max(low, v / STRIDE))
        elif proposal <= low:
            proposal = math.sqrt(v * low)
        v = proposal
    else:
        raise SolveError(f"loading: no contact radius found for {target:g} in {STEPS} steps; last a = {v:g} m")
    raise Refusal(
        f"loading: {target:g} needs a contact radius beyond the profile, which ends at r = {indenter.r_max:g} m; "
        "ask for less, or give a larger profile"
    )


def radii_for(stages: Sequence[tuple[Response, float]], targets: Array, indenter: Indenter, largest: float) -> Array:
    """Contact radii [m] for the increasing ``targets``, the last of which is reached at ``largest`` [m].

    ``stages``: the response with growing accuracy, and the relative accuracy to which each is followed.
    """
    a0 = indenter.a0
    if targets.size == 1:
        return np.array([largest])
    log_target = np.log(targets)
    log_v = np.log(_first_radii(stages[0][0], targets, indenter, largest))
    for response, accuracy in stages:
        log_v = _followed(response, log_v, log_target, a0, accuracy)
    return np.hypot(a0, np.exp(log_v))


def _first_radii(response: Response, targets: Array, indenter: Indenter, largest: float) -> Array:
    """v at the targets from a table of the response between their ends."""
    a0 = indenter.a0
    first = radius_for(response, float(targets[0]), indenter, math.hypot(a0, 0.3 * _v(largest, a0)), 0.1)
    v = np.geomspace(0.7 * _v(first, a0), _v(largest, a0), TABLE)
    return np.exp(_inverse(np.log(v), np.log(response(np.hypot(a0, v))), np.log(targets)))


def _followed(response: Response, log_v: Array, log_target: Array, a0: float, accuracy: float) -> Array:
    """Newton steps for all targets at once."""
    for _ in range(STEPS):
        log_values = np.log(response(np.hypot(a0, np.exp(log_v))))
        log_v = _inverse(log_v, log_values, log_target)
        if np.max(np.abs(log_values - log_target)) <= NEAR * accuracy:
            return log_v
    raise SolveError(f"loading: the contact radii of {log_target.size} increments were not found in {STEPS} passes")


def _inverse(log_v: Array, log_values: Array, log_target: Array) -> Array:
    """Values of log v at the targets, from the tangents at the nearest known point."""
    slopes = np.gradient(log_v, log_values)
    near = np.clip(np.searchsorted((log_values[1:] + log_values[:-1]) / 2, log_target), 0, log_values.size - 1)
    return log_v[near] + slopes[near] * (log_target - log_values[near])


def _v(a: float, a0: float) -> float:
    return math.sqrt((a - a0) * (a + a0))

"""Uncertain inputs of the body (nu, thickness, a known modulus) carried through to what is fitted, to first order."""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace

from ...base.errors import InputError
from .confidence import Confidence, values_at
from .result import Estimate
from .settings import Settings
from .solve import Minimum, minimise
from .statistics import t_quantile


def widened(minimum: Minimum, confidence: Confidence, settings: Settings) -> tuple[Estimate, ...]:
    """The estimates with the standard deviations ``settings.uncertain`` of inputs in their errors and intervals.

    Each input is moved by its standard deviation to both sides, where that is possible, the body solved anew and the
    data fitted again: half the change of an estimate is its systematic error. Errors add in quadrature.
    """
    changes = {name: _changes(minimum, settings, name, sigma) for name, sigma in settings.uncertain.items()}
    t = t_quantile(settings.level, confidence.dof)
    return tuple(_wider(item, {name: parts[item.name] for name, parts in changes.items()}, t)
                 for item in confidence.estimates)  # fmt: skip


def _changes(minimum: Minimum, settings: Settings, name: str, sigma: float) -> dict[str, float]:
    """Change of every estimate by a change of the input by one standard deviation."""
    centre = minimum.objective.body.nominal(name)
    ends = [(centre, values_at(minimum, minimum.x))]
    for value in (centre - sigma, centre + sigma):
        with contextlib.suppress(InputError):  # beyond what the quantity can be, as nu > 1/2
            ends.append((value, _values(minimum, settings, name, value)))
    if len(ends) == 1:
        raise InputError(f"{name} cannot be {sigma:g} off its value {centre:g} to either side")
    (one, low), (two, high) = ends[-2:] if len(ends) == 3 else ends
    return {key: (high[key] - low[key]) / (two - one) * sigma for key in low}


def _values(minimum: Minimum, settings: Settings, name: str, value: float) -> dict[str, float]:
    body = minimum.objective.body.with_values({name: value})
    again = minimise(replace(minimum.objective, body=body), minimum.x, settings.loss, minimum.width)
    return values_at(again, again.x)


def _wider(item: Estimate, systematic: dict[str, float], t: float) -> Estimate:
    total = math.hypot(*systematic.values())
    if total == 0:
        return item
    error = None if item.error is None else math.hypot(item.error, total)
    low = None if item.low is None else item.value - math.hypot(item.value - item.low, t * total)
    high = None if item.high is None else item.value + math.hypot(item.high - item.value, t * total)
    if low is not None and item.dimension in ("modulus", "work"):
        low = max(low, 0.0)
    return replace(item, error=error, low=low, high=high, systematic={k: abs(v) for k, v in systematic.items()})

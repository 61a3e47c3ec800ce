"""Whether the surfaces slid or stuck: what it means for a fit, and what the data prefer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ...base import show
from ...beside import sticking_effect, sticking_warnings
from .body import FittedBody
from .fitting import Failure
from .result import Fit


@dataclass(frozen=True)
class PreferenceTuning:
    """When data prefer one assumption."""

    # Difference of Akaike's criterion, whose parameters are as many on both sides:
    clear: float = 10.0  # theory: odds of exp(5) (Burnham and Anderson 2002, Sec. 2.6)
    least: float = 0.02  # of the scatter; choice: smaller differences are those of the series and of the noise's shape


TUNING = PreferenceTuning()


def preferences(results: Sequence[Fit | Failure]) -> Iterator[str]:
    """A sentence on each curve that was fitted under both assumptions: E*, w, and what the data prefer, if they do."""
    fits = [item for item in results if isinstance(item, Fit)]
    sticking = {(item.file, item.name): item for item in fits if item.surface == "sticking"}
    for one in fits:
        other = sticking.get((one.file, one.name))
        if one.surface == "sliding" and other is not None:
            yield f"{_verdict(one, other)}; {_values(one)}; {_values(other)}: {one.where}"


def _values(item: Fit) -> str:
    return f"{item.surface}: E* = {show(item.value('E_star'), 'modulus')}, w = {show(item.value('w'), 'work')}"


def _verdict(sliding: Fit, sticking: Fit) -> str:
    """Which assumption residuals of the same rows prefer; those of the better fit count as fewer where they are
    autocorrelated."""
    first, second = (_spread(item) for item in (sliding, sticking))
    name = list(sliding.scales)[-1]
    spreads = (show(spread, "load" if name == "P" else "length", 3) for spread in (first, second))
    scatter = f"scatter {' and '.join(spreads)} in {name}"
    if sliding.rows.size != sticking.rows.size or not (first > 0 and second > 0):
        return f"the data do not compare them ({scatter})"
    better = sliding if first < second else sticking
    lag = min(max(better.structure.lag1, 0.0), 0.99)
    difference = 2 * better.dof * (1 - lag) / (1 + lag) * math.log(first / second)
    if abs(difference) < TUNING.clear or abs(first / second - 1) < TUNING.least:
        return f"the data do not decide ({scatter})"
    return f"the data prefer {better.surface} ({scatter}; Akaike's criterion lower by {abs(difference):.0f})"


def _spread(item: Fit) -> float:
    """Standard deviation of the residuals in a unit that is the same for both."""
    return item.scatter * float(list(item.scales.values())[-1])


def friction_warnings(body: FittedBody, results: Sequence[Fit | Failure]) -> Iterator[str]:
    """What the assumption on the surfaces matters at the largest radius of the data."""
    fits = [item for item in results if isinstance(item, Fit) and item.a.size]
    if not fits:
        return
    names = {estimate.name for estimate in fits[0].estimates}
    factor = fits[0].value("modulus") if "modulus" in names else 1.0
    works = [fits[0].value("w")] if "w" in names else []
    problem = body.problem.scaled(factor)
    effect = sticking_effect(problem, max(float(item.a.max()) for item in fits), works)
    for warning in sticking_warnings(problem, effect):
        yield f"{warning}; jkr fit --surface both fits either"

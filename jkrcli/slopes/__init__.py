"""S = dP/d(delta) and S' = dS/da of a nonadhesive series, by one of several methods with one result type."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from ..errors import InputError
from ..series import Array, RawSeries, Series
from .result import Slopes

SLOPES = {
    "exact": "jkrcli.slopes.exact:exact",
    "loocv": "jkrcli.slopes.loocv:loocv",
    "integral": "jkrcli.slopes.integral:integral",
}
__all__ = ["SLOPES", "Slopes", "slopes", "slopes_function", "smoothed"]


def slopes_function(name: str) -> Callable[[Series], Slopes]:
    """The function of the method called ``name``; imports its module, and only that."""
    if name not in SLOPES:
        raise InputError(f"slopes: must be one of auto, {', '.join(SLOPES)}, got {name!r}")
    module, attribute = SLOPES[name].split(":")
    return getattr(importlib.import_module(module), attribute)


def slopes(series: Series, name: str = "auto") -> Slopes:
    """S and S' of ``series``; "auto" takes the exact ones where the series carries them, else the surer estimate."""
    if name != "auto":
        return replace(slopes_function(name)(series), reason="asked for")
    if series.S is not None and series.dS is not None:
        return replace(slopes_function("exact")(series), reason="the series carries exact slopes")
    return _surer(series)


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, errors: Mapping[str, Array] | None = None
) -> tuple[Series, Slopes]:
    """Series and slopes straight from increments, noisy or with repeated radii, by the method "integral"."""
    from .integral import smoothed as fitted

    series, found = fitted(raw, a0, S0, errors)
    return series, replace(found, reason="the increments themselves were fitted")


def _surer(series: Series) -> Slopes:
    """Of "integral" and "loocv" the one with the smaller estimate of its own error."""
    fitted = slopes_function("integral")(series)
    try:
        paper = slopes_function("loocv")(series)
    except InputError:
        return replace(fitted, reason="the series carries no exact slopes, and those of 'loocv' are not positive")
    if _number(paper) < _number(fitted):
        fitted, paper = paper, fitted
    others = f"by {paper.method!r} {_words(paper)}"
    return replace(fitted, reason=f"the series carries no exact slopes; estimated error {_words(fitted)}, {others}")


def _number(found: Slopes) -> float:
    return found.error if isinstance(found.error, float) else math.inf


def _words(found: Slopes) -> str:
    return f"{found.error:.1g}" if isinstance(found.error, float) else found.error

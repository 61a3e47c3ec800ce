"""Series in other units, and stated errors of pull-off points beside the true ones."""

import math

from jkrcli.resolve.analysis import Analysis
from jkrcli.series import Series


def in_units(series: Series, length: float, force: float) -> Series:
    """The ``series`` where a metre and a newton are as many units."""
    stiff = force / length
    return Series(
        series.a * length, series.delta * length, series.P * force, series.S * stiff, series.dS * stiff / length
    )


def assert_pull_off_within(found: Analysis, exact: Analysis, most: float, factor: float = math.inf) -> None:
    """P and delta of all pull-off points err by what is stated at most, which is below ``most`` of them and below
    ``factor`` times the error."""
    for control, point in found.pull_off.items():
        truth, stated = exact.pull_off[control], found.pull_off_errors[control]
        for name in ("P", "delta"):
            error = abs(getattr(point, name) - getattr(truth, name))
            assert error <= stated[name] < most * abs(getattr(truth, name))
            assert stated[name] < factor * error

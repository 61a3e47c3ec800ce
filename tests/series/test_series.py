"""The result type: checks on construction, the paper's filter, the error budget, scaling with the moduli."""

import numpy as np
import pytest

from jkrcli.base.errors import InputError, Unknown
from jkrcli.series import ErrorBudget, RawSeries, Series, filter_plateaus, first_of_plateaus

A = np.array([1.0, 2.0, 3.0])


def test_filter_keeps_the_first_increment_of_every_plateau() -> None:
    raw = RawSeries(np.array([0, 1, 1, 2, 2, 2, 1, 3.0]), np.arange(8.0), np.arange(8.0))
    kept, dropped = filter_plateaus(raw)
    np.testing.assert_array_equal(kept.a, [1, 2, 3])
    np.testing.assert_array_equal(kept.delta, [1, 3, 7])
    np.testing.assert_array_equal(kept.rows, [2, 4, 8])
    assert dropped == 5
    assert first_of_plateaus(np.zeros(3)).sum() == 0


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"a": np.array([1.0, 1.0, 3.0])}, "series: contact radii must be positive and increase, point 2 is 1 m"),
        ({"delta": np.array([1.0, 3.0, 2.0])}, "series: delta must be positive and increase, point 3 is 2"),
        ({"P": np.array([-1.0, 2.0, 3.0])}, "series: P must be positive and increase, point 1 is -1"),
        ({"P": np.array([1.0, np.nan, 3.0])}, "series: P[1] is not finite"),
        ({"P": A[:2]}, "series: P must be one-dimensional with 3 values, got shape (2,)"),
        ({"S": A, "dS": -A}, "series: dS must be > 0, point 1 is -1; use --slopes integral"),
        ({"a0": 1.0}, "series: a0 must be >= 0 and below the first radius 1 m, got 1 m"),
        ({"errors": {"x": A}}, "series: errors for unknown columns ['x']"),
    ],
)
def test_wrong_series_are_refused(changes: dict, line: str) -> None:
    with pytest.raises(InputError, check=lambda error: error.lines == (line,)):
        Series(**({"a": A, "delta": A, "P": A} | changes))


def test_arrays_are_copies_and_read_only() -> None:
    a = A.copy()
    series = Series(a, A, A)
    a[0] = 7
    assert series.a[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        series.P[0] = 0


def test_moduli_scale_forces_and_leave_lengths() -> None:
    scaled = Series(A, A, A, A, A, {"a": A, "P": A, "S": A}, a0=0.5, S0=2.0).scaled(3.0)
    for name, factor in {"a": 1, "delta": 1, "P": 3, "S": 3, "dS": 3}.items():
        np.testing.assert_array_equal(getattr(scaled, name), factor * A)
    np.testing.assert_array_equal(scaled.errors["a"], A)
    np.testing.assert_array_equal(scaled.errors["P"], 3 * A)
    assert (scaled.a0, scaled.S0) == (0.5, 6.0)


def test_budget_adds_numbers_and_passes_on_the_reason() -> None:
    assert ErrorBudget(1e-3, 2e-3, 0.0).total == pytest.approx(3e-3)
    assert ErrorBudget(1e-3, 2e-3, 0.0, 4e-3).total == pytest.approx(7e-3)
    assert ErrorBudget(1e-3, 2e-3, 0.0, 4e-3).series == pytest.approx(3e-3)
    assert ErrorBudget(1e-3, Unknown("not known"), 0.0, 4e-3).total == Unknown("not known")
    assert ErrorBudget(0.0, 0.0, 0.0, 0.0).total == 0.0

"""Pressure and surface around a contact of the body itself."""

from typing import Any

import numpy as np
import pytest

from jkrcli.adhesion.curve import transform
from jkrcli.base.errors import InputError
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.hybrid.solver import Hybrid
from jkrcli.resolve.analysis import JKR, profile_columns
from jkrcli.series import Solution

A = 4e-4  # contact radius [m]


def _cylinder(tip: Elastic | None) -> Solution:
    specimen = Specimen((Layer(Elastic(1e6, 0.5), 2e-3),), Rigid(), radius=1e-3, side="clamped")
    return Hybrid(tolerance=1e-4)(Problem(Paraboloid(1e-2, tip), specimen, Loading("radius", A, 5)))


def _carried(columns: dict[str, Array]) -> float:
    """The force [N] of the pressures within A, in an angle in which they are smooth."""
    inside = columns["r_m"] < A
    angle = np.arcsin(columns["r_m"][inside] / A)
    rings = 2 * np.pi * A**2 * np.sin(angle) * np.cos(angle) * columns["pressure_Pa"][inside]
    return float(np.trapezoid(np.append(rings, rings[-1]), np.append(angle, np.pi / 2)))


@pytest.mark.parametrize(("tip", "w"), [(None, 0.02), (Elastic(2e6, 0.5), 0.0)])
def test_the_pressure_on_a_cylinder_carries_its_load(tip: Elastic | None, w: float) -> None:
    solution = _cylinder(tip)
    curve: Any = transform(solution.series, "exact", w)
    columns = profile_columns(solution, A, w, JKR)
    assert abs(_carried(columns) - curve.P[-1]) < 1e-3 * solution.series.P[-1]  # of trapezoids
    outside = columns["r_m"] > A
    assert columns["r_m"][outside][-1] == pytest.approx(7e-4, rel=0.01)  # half-way to the side
    assert (np.diff(columns["gap_m"][outside]) > 0).all()
    if tip is None:
        there = columns["displacement_m"] + columns["r_m"] ** 2 / 2e-2 - columns["gap_m"]
        np.testing.assert_allclose(there, curve.delta[-1], rtol=1e-3)


def test_a_radius_beyond_the_series_of_a_cylinder_is_refused() -> None:
    with pytest.raises(InputError, match=r"between 0 and 400 um, got 2\.5 mm"):
        profile_columns(_cylinder(None), 2.5e-3, 0.0, JKR)

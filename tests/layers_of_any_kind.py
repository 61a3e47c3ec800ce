"""What holds of layers on a body, whatever their moduli: finite elements agree, moduli scale loads, cases read back."""

import numpy as np
import pytest

from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Loading, Problem, Specimen
from jkrcli.case.models import parse_case
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import method_class

PARABOLOID = Paraboloid(100.0)


def assert_finite_elements_agree(specimen: Specimen) -> None:
    """P and a at equal depth, at radii over a factor of ten, within the stated errors."""
    solution = method_class("fem")()(Problem(PARABOLOID, specimen, Loading("radius", 1.0)))
    series = solution.series
    radii = tuple(series.a[series.a > 0.1 * series.a[-1]][::5])
    exact = Layered()(Problem(PARABOLOID, specimen, Loading.given("radius", radii))).series
    P, a = (
        np.exp(np.interp(np.log(exact.delta), np.log(series.delta), np.log(column))) for column in (series.P, series.a)
    )
    assert np.max(np.abs(P / exact.P - 1)) < solution.budget.discretisation
    assert np.max(np.abs(a / exact.a - 1)) < solution.budget.total


def assert_moduli_scale_loads_and_not_depths(specimen: Specimen) -> None:
    loading = Loading.given("radius", (0.7,))
    weak, stiff = (Layered()(Problem(PARABOLOID, body, loading)).series for body in (specimen, specimen.scaled(7.0)))
    assert stiff.P == pytest.approx(7 * weak.P, rel=1e-12)
    assert stiff.delta == pytest.approx(weak.delta, rel=1e-12)


def read_back(content: bytes) -> Problem:
    """The problem of a case, the same when what it resolves to is read."""
    parsed = parse_case(content, "my.toml")
    found = parsed.model.problem()
    again = parse_case(parsed.to_toml().encode(), "again.toml").model.problem()
    assert again == found
    assert again.key == found.key
    return found

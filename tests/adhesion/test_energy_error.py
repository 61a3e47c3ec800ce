"""Stated errors of the energies of pull-off and cycles against those of finer series."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from maugis import finite_range_curve

import jkrcli as jkr
from jkrcli.adhesion.curve import AdhesiveCurve, EquilibriumCurve
from jkrcli.adhesion.device_path import Cycle, cycle, energy_lost_error, separation_error

LAYER = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.45), 10e-6),), jkr.Rigid())
SPHERE = jkr.Paraboloid(100e-6)


def curve(points: int, w: float, method: str = "layered", body: jkr.Specimen = LAYER) -> AdhesiveCurve:
    loading = jkr.Loading("radius", 40e-6, points)
    return jkr.transform(jkr.solve(jkr.Problem(SPHERE, body, loading), method), w).jkr


def judged(coarse: Cycle, fine: Cycle, least: float = 0.0) -> list[float]:
    """Stated over true errors of both energies, which must hold; ``least``: relative, of what stands for the truth."""
    ratios = []
    for name, error in (
        ("energy_lost", energy_lost_error(coarse)),
        ("separation", separation_error(coarse.retraction)),
    ):
        value, true = getattr(coarse, name), getattr(fine, name)
        assert isinstance(error, float), error
        off = max(abs(value - true) - least * abs(true), 0.0)
        assert off <= error, (name, value, true, error)
        ratios.append(error / max(off, least * abs(true), 1e-9 * abs(true)))
    return ratios


def cycled(one: EquilibriumCurve, two: EquilibriumCurve, stiffness: float) -> Cycle:
    found = cycle(one, two, stiffness)
    assert isinstance(found, Cycle)
    return found


@pytest.mark.parametrize("stiffness", [20.0, math.inf])
@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_energies_of_few_rows_state_what_interpolation_leaves(stiffness: float, ratio: float) -> None:
    """25 rows were 4e-6 off and said nothing."""
    coarse, fine = (cycled(curve(n, 0.02), curve(n, 0.02 * ratio), stiffness) for n in (25, 200))
    assert max(judged(coarse, fine)) < 100


def test_energies_of_finite_range_state_their_errors() -> None:
    one, two = (jkr.solve(jkr.Problem(SPHERE, LAYER, jkr.Loading("radius", 40e-6, n)), "layered") for n in (25, 200))
    coarse, fine = (finite_range_curve(each, 0.02, length=1e-7) for each in (one, two))
    for stiffness in (20.0, math.inf):
        judged(cycled(coarse, coarse, stiffness), cycled(fine, fine, stiffness))


@pytest.mark.slow
def test_energies_by_elements_state_those_of_the_mesh() -> None:
    """1e-3 off without a word."""
    ratios = []
    for nu in (0.3, 0.45, 0.49):
        body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, nu), 10e-6),), jkr.Rigid())
        coarse, fine = (curve(60, 0.02, method, body) for method in ("fem", "layered"))
        for stiffness in (20.0, math.inf):
            ratios += judged(cycled(coarse, coarse, stiffness), cycled(fine, fine, stiffness), 1e-6)
    assert np.median(ratios) < 30


def test_a_series_without_errors_has_energies_of_unknown_error() -> None:
    plain = curve(40, 0.02)
    bare = replace(plain, nonadhesive=replace(plain.nonadhesive, slopes=replace(plain.slopes, covariance=None)))
    error = energy_lost_error(cycled(bare, bare, math.inf))
    assert isinstance(error, jkr.Unknown)
    assert error.reason.startswith("unknown")

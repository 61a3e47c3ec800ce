"""Intervals of fits: right at 95 % whatever is measured, and whatever the noise of the columns."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fit_data import coating, half_space, thin_layer, usual

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.least_squares import covariance_of_uneven
from jkrcli.measured.procedure import fit
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered

GLASS = replace(half_space().problem, specimen=Specimen((), HalfSpace(Elastic(1.5e6, 0.5))))
BODIES = {  # body and w; the moduli are those of the data
    "half-space": (GLASS, 0.1),
    "gel": (thin_layer(), 0.04),
    "coating": (coating(), 0.05),
}
COLUMNS = {"delta, P": (1, 2), "a, P": (0, 2), "a, delta, P": (0, 1, 2)}


@cache
def body_and_curve(name: str) -> tuple[FittedBody, np.ndarray]:
    """The body, and a, delta, P (3, 100) from pull-off to three times its force."""
    problem, w = BODIES[name]
    method = Layered(1e-10) if problem.specimen.layers else ClosedForm()
    fine = method(replace(problem, loading=Loading("radius", problem.loading.maximum, 400))).series
    curve = transform(fine, slopes(fine, "exact"), w)
    lost = curve.pull_off(float("inf"))
    a = np.linspace(lost.a, curve.radii(P=3 * abs(lost.P))[-1], 100)
    series = method(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact")), np.stack([a, *curve.at(a)])


def noise_of(exact: np.ndarray, kind: str) -> np.ndarray:
    """Standard deviations: even along the curve, about 1 % of pull-off and of the radius; or 1 % of each reading."""
    size = np.ptp(exact, axis=1, keepdims=True)
    return 0.01 * (np.array([[1.0], [0.1], [0.1]]) * size if kind == "even" else np.abs(exact) + 1e-3 * size)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["even", "relative"])
@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("name", BODIES)
def test_intervals_hold(name: str, columns: str, kind: str) -> None:
    """Of a thousand fits (a few: ``test_interval_widths``). E* used to lie in its interval in 73 to 80 of 100 where
    a is measured: its noise was not told from the curve. 0.942 to 0.974 measured; right fits are seldom warned of."""
    (body, exact), truth = body_and_curve(name), {"modulus": 1.0, "w": BODIES[name][1], "delta0": 0.0}
    names, sigma, held, told = ("a", "delta", "P"), noise_of(exact, kind), [], []
    for seed in range(30000, 31000):
        readings = exact + sigma * np.random.default_rng(seed).standard_normal(exact.shape)
        found = fit(body, Curve(name, **{names[i]: readings[i] for i in COLUMNS[columns]}), usual())
        pairs = [(found.estimate(parameter), truth[parameter]) for parameter in found.free]
        held.append([item.low <= true <= item.high for item, true in pairs])
        told.append(any("model rejected" in text or "are structured" in text for text in found.warnings))
    shares = np.mean(held, axis=0)
    by_name = dict(zip(found.free, shares.tolist(), strict=True))
    print(f"{name}; {columns}; {kind}: {by_name}, warned of {np.mean(told):.3f}")
    assert (shares >= 0.925).all(), shares
    assert (shares <= 0.975).all(), shares
    assert np.mean(told) <= 0.05  # 0.025 measured


def test_covariance_of_uneven_noise_is_that_of_many_draws() -> None:
    """A straight line whose noise grows along it: the covariance against 4000 least-squares fits."""
    random, x = np.random.default_rng(0), np.linspace(0, 1, 80)
    J = np.stack([np.ones_like(x), x], axis=1)
    noise = (0.1 + 3 * x**2) * random.standard_normal((4000, 80))
    solve = np.linalg.pinv(J)
    found = np.array([covariance_of_uneven(J, (row - J @ (solve @ row))[None]) for row in noise])
    np.testing.assert_allclose(found.mean(axis=0), np.cov(solve @ noise.T), rtol=0.1)  # HC3: 0.06 measured

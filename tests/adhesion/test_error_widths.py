"""Widths by which slopes and curves are stated to err: neither doubled nor halved."""

from dataclasses import replace

import numpy as np
import pytest
from widths import assert_neither_doubled_nor_halved, mean_squares

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.pull_off_error import pull_off_error
from jkrcli.adhesion.slopes import slopes
from jkrcli.adhesion.slopes.integral import smoothed
from jkrcli.adhesion.slopes.loocv import loocv
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import RawSeries, Series
from studies.noise_cells import noisy

R, E_STAR, W = 1e-3, 1e6, 0.02
THIN = Specimen((Layer(Elastic(1e6, 0.4), 1e-6),), Rigid())


def half_space(points: int) -> Series:
    a = np.linspace(5e-6, 1e-4, points)
    return Series(a, *hertz(a, E_STAR, R), S=2 * E_STAR * a, dS=np.full(points, 2 * E_STAR))


def test_a_wrong_radius_moves_the_curve_by_what_is_stated() -> None:
    """All radii 1 % too large: S' = dS/da is 1 % too small, t = sqrt(4 pi w a/S') 1 % too large."""
    exact, share = half_space(20), 0.01
    wrong = replace(exact, a=exact.a * (1 + share), dS=exact.dS / (1 + share), errors={"a": share * exact.a})
    moved, right = (transform(series, slopes(series, "exact"), W) for series in (wrong, exact))
    for name in ("delta", "P"):
        off = np.abs(getattr(moved, name) - getattr(right, name))
        assert moved.errors[name] == pytest.approx(off, rel=2 * share)
    assert moved.slopes.error == pytest.approx(share, rel=2 * share)  # of sqrt(a/S')
    assert moved.slopes.dS_err == pytest.approx(2 * share * exact.dS, rel=2 * share)


def test_noise_on_a_coating_by_integration() -> None:
    """1 % on delta and P: S' and the band of P at six radii. 0.9 and 0.8 measured."""
    specimen = Specimen((Layer(Elastic(1e6, 0.4), 1e-6),), HalfSpace(Elastic(2e7, 0.3)))
    exact = Layered()(Problem(Paraboloid(R), specimen, Loading("radius", 5e-6, 80))).series
    truth, some = transform(exact, slopes(exact, "exact"), 2e-5), np.linspace(5, 73, 6).astype(int)
    found = []
    for seed in range(16):
        noise = 1 + 0.01 * np.random.default_rng(seed).standard_normal((2, 80))
        series, fitted = smoothed(RawSeries(exact.a, exact.delta * noise[0], exact.P * noise[1]))
        curve = transform(series, fitted, truth.w)
        pairs = ((fitted.dS - exact.dS, fitted.dS_err), (curve.P - truth.P, curve.errors["P"]))
        found.append([mean_squares(off[some], width[some], fitted.quantile) for off, width in pairs])
        assert 1.96 < fitted.quantile < 2.03  # of Student's distribution with 40 degrees of freedom and more
    assert_neither_doubled_nor_halved(np.mean(found, axis=0))


@pytest.mark.slow
def test_little_noise_on_a_thin_layer_by_the_papers_slopes() -> None:
    """1e-9 and 1e-7 on all columns, where S(a) is interpolated: held, 5.6 and 6.3 times too large measured."""
    exact = Layered()(Problem(Paraboloid(R), THIN, Loading("radius", 1e-5, 100))).series
    true = transform(exact, slopes(exact, "exact"), 2e-4).pull_off(0.0)
    for noise in (1e-9, 1e-7):
        ratios = []
        for seed in range(5):
            raw = noisy(exact, noise, seed)
            curve = transform(series := Series(raw.a, raw.delta, raw.P), loocv(series), 2e-4)
            point = curve.pull_off(0.0)
            error = pull_off_error(curve, point, 0.0)
            ratios.append(error["P"] / abs(point.P - true.P))
        assert np.median(ratios) > 1
        assert np.median(ratios) < 15


def test_noise_on_a_half_space_by_the_papers_slopes() -> None:
    """0.1 % on delta and P: S' at all radii. 0.95 measured."""
    exact, off, widths = half_space(80), [], []
    for seed in range(20):
        noise = 1 + 1e-3 * np.random.default_rng(seed).standard_normal((2, 80))
        found = loocv(replace(exact, delta=exact.delta * noise[0], P=exact.P * noise[1], S=None, dS=None))
        off.append(found.dS - exact.dS)
        widths.append(found.dS_err)
        assert found.error == pytest.approx(np.median(found.dS_err / (2 * found.dS)), rel=1e-12)
    assert_neither_doubled_nor_halved(mean_squares(off, widths, 1.96).mean())

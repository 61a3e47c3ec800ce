"""How noise in a, delta and P reaches the pull-off force, by every way of finding the slopes.

Independent relative Gaussian noise on each column of exact series: Hertz and bonded layers, a stiff coating. A cell of
the study is one body, number of points, noise and method; its figures are over many seeds.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from jkrcli.adhesion.curve import AdhesiveCurve, transform
from jkrcli.adhesion.rules import slopes_function
from jkrcli.adhesion.slopes import slopes, smoothed
from jkrcli.base.errors import InputError, Unknown
from jkrcli.base.executors import Pool, in_order
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.protocol import method_class
from jkrcli.series import RawSeries, Series

POINTS = (15, 60, 300)  # rows of a series
NOISE = (0.0, 1e-5, 1e-4, 1e-3, 1e-2)  # relative, of a, delta and P
METHODS = ("integral", "loocv", "gcv")


@dataclass(frozen=True)
class Body:
    """An exact series maker: ``problem(points)`` with radii evenly spaced, and the work of adhesion ``w`` [J/m^2]."""

    name: str
    method: str
    problem: Callable[[int], Problem]
    w: float

    def series(self, points: int) -> Series:
        """The exact series with S and S', shape (points,)."""
        return method_class(self.method)()(self.problem(points)).series


@dataclass(frozen=True)
class NoiseCell:
    """Figures of one cell; errors of the pull-off force under load control are relative to the exact one.

    ``coverage``: share of runs whose 95 % band of the pull-off force holds the exact one; ``band``: share of points of
    the curve whose band does, over all runs; None for methods that give no band. ``failures``: share without a result.
    """

    body: str
    points: int
    noise: float
    method: str
    median: float
    worst: float
    coverage: float | None
    band: float | None
    failures: float


def _layered(nu: float, h: float, R: float, a_max: float, base: Rigid | HalfSpace, points: int) -> Problem:
    specimen = Specimen((Layer(Elastic(1e6, nu), h),), base)
    return Problem(Paraboloid(R), specimen, Loading("radius", a_max, points))


def _half_space(points: int) -> Problem:
    specimen = Specimen((), HalfSpace(Elastic(5e9, 0.4)))
    return Problem(Paraboloid(1e-4), specimen, Loading("radius", 1.73e-5, points))


BODIES = (
    Body("hertz", "closed-form", _half_space, w=50.0),
    Body("layer-0.4", "layered", partial(_layered, 0.4, 1e-6, 1e-3, 1e-5, Rigid()), w=2e-4),
    Body("layer-0.499", "layered", partial(_layered, 0.499, 1e-6, 1e-3, 1e-5, Rigid()), w=1e-3),
    Body(
        "stiff-coating",
        "layered",
        partial(_layered, 0.4, 1e-6, 1e-4, 3e-6, HalfSpace(Elastic(1e5, 0.4))),
        w=4e-5,
    ),
)


def noise_study(
    bodies: Iterable[Body] = BODIES,
    points: Iterable[int] = POINTS,
    noise: Iterable[float] = NOISE,
    methods: Iterable[str] = METHODS,
    seeds: int = 200,
    pool: Pool | None = None,
) -> list[NoiseCell]:
    """All cells, worked on by ``pool`` (default: this process); a noise-free cell needs one run only."""
    asked = list(itertools.product(bodies, points, noise, methods))
    return in_order(pool, partial(_figures, seeds), asked, "noise study")


def _figures(seeds: int, asked: tuple[Body, int, float, str]) -> NoiseCell:
    body, points, noise, method = asked
    exact = body.series(points)
    truth = transform(exact, slopes(exact, "exact"), body.w)
    return cell(body, truth, noise, method, seeds if noise > 0 else 1)


def cell(body: Body, truth: AdhesiveCurve, noise: float, method: str, seeds: int) -> NoiseCell:
    """The figures of one cell, from seeds 0, 1, ... (the same noise for every method)."""
    runs = [_run(truth, noise, method, body.w, seed) for seed in range(seeds)]
    good = [run for run in runs if run is not None]
    errors = np.abs([error for error, _, _ in good]) if good else np.array([np.inf])
    inside = [hit for _, hit, _ in good if hit is not None]
    shares = [share for _, _, share in good if share is not None]
    return NoiseCell(
        body.name,
        len(truth.series),
        noise,
        method,
        float(np.median(errors)),
        float(np.max(errors)),
        float(np.mean(inside)) if inside else None,
        float(np.mean(shares)) if shares else None,
        1 - len(good) / seeds,
    )


def noisy(series: Series, noise: float, seed: int) -> RawSeries:
    """The columns of ``series`` with independent relative Gaussian noise on each."""
    generator = np.random.default_rng(seed)
    return RawSeries(
        *(v * (1 + noise * generator.standard_normal(len(series))) for v in (series.a, series.delta, series.P))
    )


def _run(
    truth: AdhesiveCurve, noise: float, method: str, w: float, seed: int
) -> tuple[float, bool | None, float | None] | None:
    """Relative error of the pull-off force, whether its band holds, share of the curve's points in the band."""
    try:
        curve = _curve(noisy(truth.series, noise, seed), method, w, truth.series)
    except InputError:
        return None
    found, expected = curve.pull_off(0.0), truth.pull_off(0.0)
    if isinstance(found, Unknown) or isinstance(expected, Unknown):
        return None
    error = found.P / expected.P - 1
    if not curve.errors:
        return error, None, None
    hit = abs(found.P - expected.P) <= float(curve.error_at(np.array(found.a))["P"])
    return error, hit, _share(curve, truth)


def _share(curve: AdhesiveCurve, truth: AdhesiveCurve) -> float:
    """Share of the curve's points whose band of P holds the exact P at the same radius."""
    common = (curve.a >= truth.a[0]) & (curve.a <= truth.a[-1])
    exact: Array = truth.at(curve.a[common])[1]
    return float(np.mean(np.abs(curve.P[common] - exact) <= curve.errors["P"][common]))


def _curve(raw: RawSeries, method: str, w: float, exact: Series) -> AdhesiveCurve:
    if method == "integral":
        series, found = smoothed(raw, exact.a0, exact.S0)
        return transform(series, found, w)
    series = Series(raw.a, raw.delta, raw.P, a0=exact.a0, S0=exact.S0)
    return transform(series, slopes_function(method)(series), w)

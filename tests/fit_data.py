"""Synthetic measurements for the tests of the fit: exact curves and noise, not from the fitted series."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.parameters import Parameter
from jkrcli.measured.settings import Settings
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered

R, E_STAR, W = 10e-6, 1e6, 0.1  # the identification of Perepelkin et al., Nanomaterials 10 (2020) 15
P_C = 1.5 * np.pi * W * R
A_C = (9 * np.pi * W * R**2 / (8 * E_STAR)) ** (1 / 3)


def adhesive(a, E_star=E_STAR, w=W, R=R):
    """delta and P of the paraboloid on a half-space (Eq. 7): independent of every series."""
    lag = np.sqrt(2 * np.pi * w * a / E_star)
    return a**2 / R - lag, 4 * E_star * a**3 / (3 * R) - 2 * E_star * a * lag


DELTA_C = -adhesive(A_C)[0]
A_END = brentq(lambda a: adhesive(a)[1] - 3 * P_C, A_C, 10 * A_C)


def sphere(points: int = 200, noise: float = 0.0, seed: int = 0, shift: float = 0.0, first: float = A_C) -> Curve:
    """From pull-off (radius ``first``) to 3 |P_c|, noise in units of |P_c| and |delta_c|, ``shift`` in |delta_c|."""
    random = np.random.default_rng(seed)
    delta, P = adhesive(np.linspace(first, A_END, points))
    delta = delta + (shift + noise * random.standard_normal(points)) * DELTA_C
    return Curve("sphere", delta=delta, P=P + noise * P_C * random.standard_normal(points))


def half_space(E: float = 1.5e6, reach: float = 1.4 * A_END, points: int = 100, extensible: bool = False) -> FittedBody:
    """A body whose moduli are twice those of the data (E* = 2 MPa)."""
    specimen = Specimen((), HalfSpace(Elastic(E, 0.5)))
    problem = Problem(Paraboloid(R), specimen, Loading("radius", reach, points))
    series = ClosedForm()(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"), extensible)


def thin_layer(nu: float = 0.499) -> Problem:
    layer = Layer(Elastic(15e3, nu), 0.36e-3, "gel")
    return Problem(Paraboloid(6e-3), Specimen((layer,), Rigid()), Loading("radius", 1.4e-3, 100))


def coating(E: float = 20e6) -> Problem:
    layer = Layer(Elastic(E, 0.45), 0.5e-6, "skin")
    return Problem(
        Paraboloid(50e-6), Specimen((layer,), HalfSpace(Elastic(1.5e6, 0.49))), Loading("radius", 12e-6, 100)
    )


@cache
def body_of(problem: Problem) -> FittedBody:
    series = Layered(1e-9)(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"))


def measured(problem: Problem, w: float, factor: float = 1.0, delta0: float = 0.0, top: float = 3.0) -> Curve:
    """Exact readings at radii of their own from pull-off (displacement control) to ``top`` times the pull-off force."""
    fine = replace(problem, loading=Loading("radius", problem.loading.maximum, 400))
    series = Layered(1e-10)(fine).series.scaled(factor)
    curve = transform(series, slopes(series, "exact"), w)
    lost = curve.pull_off(float("inf"))
    keep = (curve.a >= lost.a) & (curve.P <= top * abs(lost.P))
    return Curve("layer", delta=curve.delta[keep] + delta0, P=curve.P[keep])


def free(*names: str, **starts: float) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, True, starts.get(name)) for name in names)


def usual(**options) -> Settings:
    return Settings(free("modulus", "w", "delta0"), **options)

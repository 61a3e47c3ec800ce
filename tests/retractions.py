"""Retractions of a gel and a coating at speed, as an instrument reads them, and the bodies that they are of."""

import math
from functools import cache

import numpy as np
from rate_records import retraction

from jkrcli.adhesion.curve import Nonadhesive
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.methods.layered.solver import Layered

RIGID = math.inf
SPEEDS = (1e-6, 3e-6, 1e-5, 3e-5)
GEL, COATING = (0.04, 2e-6, 0.5), (0.05, 5e-7, 0.4)  # w0, v0, n


@cache
def body(name: str) -> FittedBody:
    if name == "gel":
        specimen, R, radii = Specimen((Layer(Elastic(15e3, 0.499), 0.36e-3),), Rigid(True)), 6e-3, (1e-5, 1.2e-3)
    else:
        specimen, R, radii = (
            Specimen((Layer(Elastic(20e6, 0.4), 5e-6),), HalfSpace(Elastic(1e6, 0.48))),
            1e-3,
            (1e-6, 2e-4),
        )
    problem = Problem(Paraboloid(R), specimen, Loading.given("radius", tuple(np.geomspace(*radii, 80))))
    series = Layered(1e-8)(problem).series
    return FittedBody.of(problem, series, slopes(series))


@cache
def clean(name: str, V: float, rows: int) -> tuple:
    held = body(name)
    truth, a0, stiffness = (GEL, 7e-4, RIGID) if name == "gel" else (COATING, 6e-5, 2e3)
    found = retraction(Nonadhesive(held.series, held.slopes), *truth, V, a0, stiffness, rows)
    return (*found, stiffness)


def record(name: str, V: float, rows: int, rng: np.random.Generator, zero: float, noise: float = 0.01) -> Curve:
    """1 % noise on the device's position and the load; the deflection is subtracted as an instrument does."""
    t, delta, P, _, stiffness = clean(name, V, rows)
    compliance = 0.0 if math.isinf(stiffness) else 1 / stiffness
    device = delta + compliance * P
    P = P + noise * np.ptp(P) * rng.normal(size=rows)
    device = device + zero + noise * np.ptp(device) * rng.normal(size=rows)
    held = None if math.isinf(stiffness) else stiffness
    return Curve(f"{V:g}", delta=device - compliance * P, P=P, t=t, stiffness=held)

"""Retractions of a gel and a coating at speed, as an instrument reads them, made by an integrator of their own:
Runge-Kutta of order 8 in time, event at loss, with the body's functions alone."""

import math
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from jkrcli.adhesion.curve import Nonadhesive
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.numerics import Array
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


def retraction(
    body: Nonadhesive, w0: float, v0: float, n: float, V: float, a0: float, stiffness: float, rows: int
) -> tuple[Array, Array, Array, Array]:
    """t [s], delta [m], P [N], a [m] of a device that moves back at the speed ``V`` from rest at ``a0``, G = w0/2.

    A fifth of the rows lies behind the loss of contact.
    """
    compliance = 0.0 if math.isinf(stiffness) else 1 / stiffness

    def lag(a: Array, x: Array) -> Array:
        here = body.parts(a)
        return (here.delta_H + here.P_H * compliance - x) / (1 + here.S * compliance)

    def released(a: Array, x: Array) -> Array:
        return body.parts(a).dS * lag(a, x) ** 2 / (4 * math.pi * a)

    here = body.parts(np.array(a0))
    behind = math.sqrt(w0 / 2) * float(here.t)
    begin = float(here.delta_H) - behind + compliance * float(here.P_H - here.S * behind)

    def rate(t: float, a: Array) -> Array:
        radius = np.clip(a, body.a[0], body.a[-1])
        return -v0 * np.maximum(released(radius, begin - V * t) / w0 - 1, 0) ** (1 / n)

    def lost(t: float, a: Array) -> float:
        return float(a[0]) - 1.05 * float(body.a[0])

    lost.terminal = True
    far = 1e4 * a0 / V
    found = solve_ivp(rate, (0, far), [a0], "DOP853", rtol=1e-9, atol=1e-9 * a0, events=lost, dense_output=True)
    end = float(found.t[-1])
    t = np.linspace(0, 1.25 * end, rows)
    touching = t < end
    a = np.where(touching, found.sol(np.minimum(t, end))[0], 0.0)
    radius, x = np.where(touching, a, body.a[0]), begin - V * t
    here = body.parts(np.clip(radius, body.a[0], body.a[-1]))
    P = np.where(touching, here.P_H - here.S * lag(radius, x), 0.0)
    return t, x - compliance * P, P, a


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

"""Records of retractions at speed, made by an integrator of their own: Runge-Kutta of order 8 in time, event at loss,
with the body's functions alone."""

import math

import numpy as np
from scipy.integrate import solve_ivp

from jkrcli.adhesion.curve import Nonadhesive
from jkrcli.base.numerics import Array


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

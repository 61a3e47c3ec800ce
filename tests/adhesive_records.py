"""Records of a paraboloid that adheres to a half-space or bonded layer that relaxes: equations in Abel's space at Gauss
points of each contact and of its zone, even steps of time. Shares no code with what is fitted to them.

R = 1 and E* = 1 at t = 0; modes (relaxed, weights, rates). Every step: V = (pi/2) phi + int K phi = G W + H, in contact
W = delta - x^2/R, in the zone phi = -(2/pi) s sqrt(c^2 - x^2), s = 2 stress; phi is continuous at a, and the gap at c
is w/stress.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from layer_contact import compliance
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, root

from jkrcli.measured.curve import Curve

Array = np.ndarray
INSIDE, ZONE = (np.polynomial.legendre.leggauss(n) for n in (24, 24))


@cache
def kernel(nu: float | None, h: float) -> CubicSpline | None:
    """k(s) = int (g - 1) cos(ks) dk of a bonded layer; K(x, t) = [k(x - t) + k(x + t)]/2."""
    if nu is None:
        return None
    edges = np.append(0, np.geomspace(1e-3, 30, 60))
    x, w = np.polynomial.legendre.leggauss(12)
    half = np.diff(edges)[:, None] / 2
    y, dy = (edges[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()
    s = np.linspace(0, 8.0, 1000)
    return CubicSpline(s, np.cos(np.outer(s / h, y)) @ ((compliance(y, nu) - 1) * dy) / h)


class Contact:
    """A contact step by step; ``at``: radii a and c, None where there is none."""

    def __init__(self, w: float, stress: float, modes: tuple[float, Sequence[float], Sequence[float]],
                 nu: float | None, h: float, end: float) -> None:  # fmt: skip
        self.s, self.gap, self.k = 2 * stress, w / stress, kernel(nu, h)
        self.relaxed, self.weights, self.rates = modes[0], np.array(modes[1]), np.array(modes[2])
        self.x = end * np.linspace(0, 1, 2001) ** 1.2
        self.W, self.eta = np.zeros_like(self.x), np.zeros((self.rates.size, self.x.size))
        self.at: tuple[float, float] | None = None

    def K(self, x: Array, t: Array) -> Array:
        return np.zeros((x.size, t.size)) if self.k is None else (
            self.k(np.abs(x[:, None] - t)) + self.k(x[:, None] + t)) / 2  # fmt: skip

    def begin(self, dt: float) -> None:
        z = dt * self.rates
        self.decay, self.gain = np.exp(-z), -np.expm1(-z) / z if dt else np.ones_like(z)
        self.G = self.relaxed + float(self.weights @ self.gain)
        self.H = (self.weights * self.decay) @ self.eta - float(self.weights @ self.gain) * self.W

    def state(self, a: float, c: float) -> tuple[float, float, float, tuple]:
        """delta, P and the gap at c."""
        x, wx = a / 2 * (1 + INSIDE[0]), a / 2 * INSIDE[1]
        # x = c cos(psi) in the zone, whose tension ends like a root
        psi = math.acos(a / c) / 2 * (1 + ZONE[0])
        y, wpsi = c * np.cos(psi), math.acos(a / c) / 2 * ZONE[1]
        pull, wy = -2 / math.pi * self.s * c * np.sin(psi), wpsi * c * np.sin(psi)
        points = np.append(x, a)
        free = self.H_at(points) - self.G * points**2 - self.K(points, y) @ (pull * wy)
        matrix = math.pi / 2 * np.eye(x.size) + self.K(x, x) * wx
        phi0, phi1 = np.linalg.solve(matrix, np.stack([free[:-1], np.full(x.size, self.G)], 1)).T
        edge = self.K(np.array([a]), x)[0] * wx
        at0, at1 = (free[-1] - edge @ phi0) * 2 / math.pi, (self.G - edge @ phi1) * 2 / math.pi
        delta = (-2 / math.pi * self.s * math.sqrt(c * c - a * a) - at0) / at1
        phi = phi0 + delta * phi1
        V = math.pi / 2 * pull + self.K(y, x) @ (wx * phi) + self.K(y, y) @ (wy * pull)
        W = (V - self.H_at(y)) / self.G
        gap = 2 / math.pi * float(wpsi @ (y**2 + W - delta))
        P = math.pi * (float(wx @ phi) + float(wy @ pull))
        return delta, P, gap, (x, wx * phi, y, wy * pull)

    def H_at(self, x: Array) -> Array:
        return np.interp(x, self.x, self.H)

    def closed(self, a: float) -> float:
        """c of a contact radius, where the gap is the range."""
        return brentq(lambda b: self.state(a, a + b)[2] - self.gap, 1e-6, self.x[-1] - a, xtol=1e-12) + a

    def found(self, delta: float) -> tuple[float, float] | None:
        """Near the last state, None where there is none."""
        if self.at is None:
            return None

        def off(u: Array) -> Array:
            a, b = np.exp(u)
            there = self.state(a, a + b)
            return np.array([(there[0] - delta) / self.gap, math.log(max(there[2], 1e-12) / self.gap)])

        solution = root(off, np.log([self.at[0], self.at[1] - self.at[0]]), tol=1e-9)
        a, c = math.exp(solution.x[0]), math.exp(solution.x[0]) + math.exp(solution.x[1])
        if not (np.abs(off(solution.x)).max() < 1e-6 and c < self.x[-1] and abs(math.log(a / self.at[0])) < 0.5):
            return None
        here, by_a, by_b = (np.array(self.state(a + da, c + da + db)[::2][:2])
                            for da, db in ((0, 0), (1e-5 * a, 0), (0, 1e-5 * (c - a))))  # fmt: skip
        (xa, ga), (xb, gb) = by_a - here, by_b - here
        return (a, c) if xa - xb * ga / gb > 0 else None

    def jump_in(self, delta: float) -> tuple[float, float] | None:
        if delta <= -self.gap:
            return None
        radii = np.geomspace(self.x[-1] * 0.6, self.x[-1] * 0.01, 60)
        before = math.inf
        for big, a in itertools.pairwise(radii):
            try:
                now = self.state(a, self.closed(a))[0]
            except ValueError:
                continue
            if now < delta <= before and math.isfinite(before):
                a = brentq(lambda r: self.state(r, self.closed(r))[0] - delta, a, big, xtol=1e-10)
                return a, self.closed(a)
            before = now
        return None

    def step(self, dt: float, delta: float, lost: bool) -> float:
        """The load at ``delta`` a time ``dt`` later."""
        self.begin(dt)
        at = self.found(delta)
        if self.at is None and not lost:
            at = self.jump_in(delta)
        self.at, P, V = at, 0.0, np.zeros_like(self.x)
        if at is not None:
            a, c = at
            d, P, _, (x, inside, y, zone) = self.state(a, c)
            V = self.K(self.x, x) @ inside + self.K(self.x, y) @ zone
            V = np.where(self.x < a, self.G * (d - self.x**2) + self.H,
                         V - self.s * np.sqrt(np.maximum(c**2 - self.x**2, 0.0)))  # fmt: skip
        W = (V - self.H) / self.G
        self.eta = self.decay[:, None] * self.eta + np.multiply.outer(self.gain, W - self.W)
        self.W = W
        return P


@cache
def clean(w: float, stress: float, modes: tuple, corners: tuple, nu: float | None = None, h: float = 1.0,
          end: float = 1.0, steps: int = 1200) -> tuple[Array, Array, Array]:  # fmt: skip
    """t, delta and P of a device that moves between ``corners`` ((t, x), ...)."""
    t = np.unique(np.concatenate([np.linspace(corners[0][0], corners[-1][0], steps), [one[0] for one in corners]]))
    delta = np.interp(t, *np.array(corners).T)
    contact, P, touched = Contact(w, stress, modes, nu, h, end), [], False
    for dt, x in zip(np.diff(t, prepend=t[0]), delta, strict=True):
        P.append(contact.step(float(dt), float(x), touched and contact.at is None))
        touched |= contact.at is not None
    return t, delta, np.array(P)


def record(made: tuple[Array, Array, Array], rows: int = 300, noise: float = 0.02, seed: int = 0,
           zero: float = 0.0, noise_delta: float = 0.0) -> Curve:  # fmt: skip
    """``rows`` of what was ``made``, with ``noise`` over the range of the load, ``noise_delta`` over that of delta."""
    t, delta, P = made
    at, rng = np.linspace(t[0], t[-1], rows), np.random.default_rng(seed)
    columns = [np.interp(at, t, column) for column in (delta, P)]
    delta, P = (c + n * np.ptp(c) * rng.standard_normal(rows)
                for c, n in zip(columns, (noise_delta, noise), strict=True))  # fmt: skip
    return Curve("made", t=at, delta=delta + zero, P=P)

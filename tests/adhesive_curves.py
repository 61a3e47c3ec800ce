"""Force curves of a paraboloid that adheres to a half-space or bonded layer that relaxes: a sum of flat punches
over the contact and its cohesive zone, step by step in time. NumPy and SciPy only.

R = 1 and E* = 1 at t = 0; modes (relaxed, weights, rates). A flat punch of radius x that moves down by W(x) under a
density phi obeys (pi/2) phi + int K phi = V = int r(t - s) dW. In contact W = delta - x^2/R; in the zone phi = -(2/pi)
s sqrt(c^2 - x^2), s = 2 stress; phi is continuous at a, and the gap at c is w/stress. Over a step W moves evenly.

Where w = w0 (1 + (v/v0)^n) at the speed v of an edge c that recedes, a step is solved for a and q = (v/v0)^n, by which
all is smooth: c = c_0 - v0 q^(1/n) dt.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from layer_contact import compliance
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, nnls

Array = np.ndarray
GAUSS = np.polynomial.legendre.leggauss(20)
POINTS = 10.0  # over the narrowest zone
MOVE = 0.25  # of the zone in a step


class Law(NamedTuple):
    """r(t) = relaxed + sum of weights exp(-rates t)."""

    relaxed: float
    weights: Array
    rates: Array

    def __call__(self, t: Array) -> Array:
        return self.relaxed + np.exp(-np.multiply.outer(t, self.rates)) @ self.weights


def solid(ratio: float, time: float) -> Law:
    return Law(ratio, np.array([1 - ratio]), np.array([1 / time]))


def power(exponent: float, onset: float, lasting: float) -> Law:
    """(1 + t/onset)^-exponent up to t = ``lasting``, by exponentials, to 1e-3 of it."""
    t = np.append(0, np.geomspace(0.03 * onset, lasting + onset, 300))
    rates = np.geomspace(0.1 / (lasting + onset), 5 / onset, 2 + int(1.6 * math.log10(50 * (lasting / onset + 1))))
    wanted = (1 + t / onset) ** -exponent
    basis = np.column_stack([np.ones_like(t), np.exp(-np.outer(t, rates))])
    found = nnls(basis / wanted[:, None], np.ones_like(t))[0]
    found, kept = found / found.sum(), found[1:] > 0
    return Law(float(found[0]), found[1:][kept], rates[kept])


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
    """A contact step by step on a device of ``stiffness``; ``at``: radii a and c, None where there is none."""

    def __init__(self, w: float, stress: float, law: Law, nu: float | None, h: float, end: float, points: int,
                 stiffness: float, rate: tuple[float, float] | None = None) -> None:  # fmt: skip
        self.s, self.gap, self.k, self.stiffness = 2 * stress, w / stress, kernel(nu, h), stiffness
        self.law, self.rate = law, rate
        self.x = np.linspace(0, end, points)
        self.d = self.x[1]
        self.W, self.eta = np.zeros_like(self.x), np.zeros((law.rates.size, points))
        self.at: tuple[float, float] | None = None
        self.coarse = end * np.linspace(0, 1, 80) ** 1.2

    def K(self, x: Array, t: Array) -> Array:
        assert self.k is not None
        return (self.k(np.abs(x[:, None] - t)) + self.k(x[:, None] + t)) / 2

    def begin(self, dt: float) -> None:
        z = dt * self.law.rates
        self.decay = np.exp(-z)
        self.gain = -np.expm1(-z) / z if dt else np.ones_like(z)
        self.G = self.law.relaxed + float(self.law.weights @ self.gain)
        self.H = (self.law.weights * self.decay) @ self.eta - float(self.law.weights @ self.gain) * self.W
        self.sum = np.append(0, np.cumsum((self.H[1:] + self.H[:-1]) * self.d / 2))

    def H_at(self, x: Array) -> Array:
        return np.interp(x, self.x, self.H)

    def state(self, a: float, c: float) -> tuple[float, float, float, tuple]:
        """delta, P and the gap at c; the smooth part of phi at nodes."""
        G, s = self.G, self.s
        root = math.sqrt((c - a) * (c + a))
        theta = math.atan2(root, a)
        psi, wpsi = theta / 2 * (1 + GAUSS[0]), theta / 2 * GAUSS[1]
        y = c * np.cos(psi)  # the zone
        pull, wy = -2 / math.pi * s * c * np.sin(psi), wpsi * c * np.sin(psi)
        if self.k is None:
            i = int(a / self.d)
            H_a = float(self.H_at(a))
            inside = self.sum[i] + (a - self.x[i]) * (self.H[i] + H_a) / 2
            delta = a**2 - (H_a + s * root) / G
            V = pull * math.pi / 2
            total = G * (delta * a - a**3 / 3) + inside + float(wy @ V)
            P, nodes = 2 * total, ()
        else:
            cuts = np.array([0, 0.5, 0.85, 1.0]) * a
            x = np.concatenate([(p + q) / 2 + (q - p) / 2 * GAUSS[0] for p, q in itertools.pairwise(cuts)])
            wx = np.concatenate([(q - p) / 2 * GAUSS[1] for p, q in itertools.pairwise(cuts)])
            both = np.append(x, a)
            free = self.H_at(both) - G * both**2 - self.K(both, y) @ (pull * wy)
            matrix = math.pi / 2 * np.eye(x.size) + self.K(x, x) * wx
            phi0, phi1 = np.linalg.solve(matrix, np.stack([free[:-1], np.full(x.size, G)], 1)).T
            edge = self.K(np.array([a]), x)[0] * wx
            at0, at1 = (free[-1] - edge @ phi0) * 2 / math.pi, (G - edge @ phi1) * 2 / math.pi
            delta = float((-2 / math.pi * s * root - at0) / at1)
            phi = phi0 + delta * phi1
            V = math.pi / 2 * pull + self.K(y, x) @ (wx * phi) + self.K(y, y) @ (wy * pull)
            P, nodes = math.pi * (float(wx @ phi) + float(wy @ pull)), (x, wx * phi, y, wy * pull)
        gap = 2 / math.pi * float(wpsi @ (y**2 + (V - self.H_at(y)) / G - delta))
        return delta, P, gap, nodes

    def place(self, a: float, c: float) -> tuple[float, float]:
        """Position of the device and the log of the gap over the range."""
        delta, P, gap, _ = self.state(a, c)
        return delta + P / self.stiffness, math.log(max(gap, 1e-300) / self.gap)

    def newton(self, x: float, a: float, c: float) -> tuple[float, float] | None:
        """The stable state at the device's place ``x`` near a and c."""
        b = c - a
        for _ in range(15):
            if not (0 < a and 0 < b and a + b < self.x[-1]):
                return None
            e = 1e-5 * b
            p0, g0 = self.place(a, a + b)
            pa, ga = ((q - q0) / e for q, q0 in zip(self.place(a + e, a + b + e), (p0, g0), strict=True))
            pb, gb = ((q - q0) / e for q, q0 in zip(self.place(a, a + b + e), (p0, g0), strict=True))
            det = pa * gb - pb * ga
            if not (gb > 0 and det > 0):
                return None
            da, db = ((x - p0) * gb + g0 * pb) / det, (-g0 * pa - (x - p0) * ga) / det
            part = min(1.0, 0.5 * b / max(abs(da), abs(db), 1e-300))
            a, b = a + part * da, b + part * db
            if max(abs(da), abs(db)) < 1e-7 * b:
                return a, a + b
        return None

    def newton_at_speed(self, x: float, a: float, c: float, dt: float) -> tuple[float, float] | None:
        """The same a time ``dt`` later where w depends on the speed of the edge."""
        assert self.rate is not None
        assert self.at is not None
        (v0, n), (a0, c0) = self.rate, self.at

        def edge(q: float) -> float:
            return c0 - dt * v0 * q ** (1 / n) if q > 0 else c0 - q * (c0 - a0)

        def off(a: float, q: float) -> tuple[float, float]:
            place, opens = self.place(a, edge(q))
            return place - x, opens - math.log1p(max(q, 0.0))

        q = ((c0 - c) / dt / v0) ** n if c < c0 else (c0 - c) / (c0 - a0)
        for _ in range(25):
            c = edge(q)
            b = c - a
            if not (0 < a and 0 < b and c < self.x[-1]):
                return None
            e, d = 1e-5 * b, 1e-6 + 1e-5 * abs(q)
            p0, g0 = off(a, q)
            pa, ga = ((one - zero) / e for one, zero in zip(off(a + e, q), (p0, g0), strict=True))
            pq, gq = ((one - zero) / d for one, zero in zip(off(a, q + d), (p0, g0), strict=True))
            det = pa * gq - pq * ga
            if not (gq < 0 and det < 0):
                return None
            da, dq = (g0 * pq - p0 * gq) / det, (p0 * ga - g0 * pa) / det
            part = min(1.0, 0.5 * b / max(abs(da), 1e-300))
            while part > 1e-6 and abs(edge(q + part * dq) - c) > 0.5 * b:
                part /= 2
            a, q = a + part * da, q + part * dq
            if abs(da) < 1e-7 * b and abs(dq) < 1e-6 * (1e-3 + abs(q)):
                return a, edge(q)
        return None

    def open_at_axis(self, x: float, dt: float) -> tuple[float, float] | None:
        """A zone alone, the surfaces being apart at its centre too, a time ``dt`` later."""
        assert self.rate is not None
        (v0, n), c0 = self.rate, self.at[1]

        def off(c: float) -> float:
            delta, P, gap, _ = self.state(0.0, c)
            return delta + gap - self.gap * (1 + ((c0 - c) / dt / v0) ** n) + P / self.stiffness - x

        c = c0
        while c > 0.5 * c0:  # the first from c0 on: beyond it there may be others
            before, c = c, c - 0.02 * c0
            if off(before) > 0 >= off(c) or off(before) < 0 <= off(c):
                return 0.0, brentq(off, c, before, xtol=1e-13)
        return None

    def jump(self, x: float, below: float) -> tuple[float, float] | None:
        """A stable state at ``x`` with a contact radius below a limit, with nothing relaxing meanwhile."""
        before, radii = math.inf, np.geomspace(below, 0.01 * below, 60)

        def zone(a: float) -> float:
            def off(log_b: float) -> float:
                return self.place(a, a + math.exp(log_b))[1]

            return a + math.exp(brentq(off, math.log(1e-7 * a), math.log(self.x[-1] - a), xtol=1e-10))

        for big, a in itertools.pairwise(radii):
            try:
                now = self.place(a, zone(a))[0]
            except ValueError:
                before = math.inf
                continue
            if now < x <= before and math.isfinite(before):
                a = brentq(lambda r: self.place(r, zone(r))[0] - x, a, big, xtol=1e-12)
                return a, zone(a)
            before = now
        return None

    def take(self, at: tuple[float, float] | None) -> tuple[float, float]:
        """Remember a state; delta and P."""
        self.at, delta, P, V = at, 0.0, 0.0, np.zeros_like(self.x)
        if at is not None:
            a, c = at
            delta, P, _, nodes = self.state(a, c)
            V = -self.s * np.sqrt(np.maximum((c - self.x) * (c + self.x), 0.0))
            if nodes:
                x, inside, y, zone = nodes
                smooth = self.K(self.coarse, x) @ inside + self.K(self.coarse, y) @ zone
                V = V + CubicSpline(self.coarse, smooth)(self.x)
            V = np.where(self.x < a, self.G * (delta - self.x**2) + self.H, V)
        W = (V - self.H) / self.G
        self.eta = self.decay[:, None] * self.eta + np.multiply.outer(self.gain, W - self.W)
        self.W = W
        return delta, P


@dataclass(frozen=True)
class Made:
    """One cycle: ``t``, position ``z`` of the device and load ``P``, noise-free; when contact began and was lost."""

    t: Array
    z: Array
    P: Array
    begun: float
    lost: float


def cycle(w: float, stress: float, law: Law, corners: Sequence[tuple[float, float]], stiffness: float,
          nu: float | None = None, h: float = 1.0, fine: float = 1.0,
          rate: tuple[float, float] | None = None) -> Made:  # fmt: skip
    """A device that moves between ``corners`` ((t, z), ...) from apart to apart; ``fine``: steps and points less;
    ``rate``: v0 and n of w over the speed of the edge."""
    times, places = np.array(corners).T
    lasting, top = times[-1] - times[0], places.max()
    left = float(law(np.array([lasting]))[0])
    largest = brentq(lambda c: c**2 - math.sqrt(2 * math.pi * w * c / left) - max(top, 1e-9), 1e-6, 100.0)
    zone = left * math.pi / 4 * w / stress**2
    end = 1.2 * largest + 2 * zone / left
    points = int(min(max(end / zone * POINTS / fine, 1500), 60000))
    contact = Contact(w, stress, law, nu, h, end, points, stiffness, rate)
    rows, t = [(float(times[0]), 0.0)], float(times[0])
    begun = float(np.interp(-contact.gap, places[:2], times[:2])) if places[1] > places[0] else math.nan

    def z(when: float) -> float:
        return float(np.interp(when, times, places))

    contact.begin(0.0)
    found = contact.jump(z(begun), largest)
    if found is None:
        raise ValueError("no jump into contact")
    rows += [(begun, 0.0)]
    t, (_, P) = begun, contact.take(found)
    rows.append((t * (1 + 1e-13) + 1e-13 * lasting, P))
    dt, before = 1e-6 * lasting, None
    inner = times[(times > begun + 1e-9 * lasting)]
    steps = 0
    while t < times[-1] - 1e-12 * lasting:
        steps += 1
        if steps > 30000:
            raise ValueError("too many steps")
        corner = float(inner[np.argmax(inner > t + 1e-12 * lasting)])
        dt = min(dt, corner - t, (times[1] - begun) / 300 * fine)
        if corner - t - dt < 1e-9 * lasting:
            dt = corner - t
        contact.begin(dt)
        a, c = contact.at  # type: ignore[misc]
        b = c - a
        guess = (a, c) if before is None else (a + before[0] * dt, c + before[1] * dt)
        guess = max(guess[0], a / 2), max(guess[1], max(guess[0], a / 2) + b / 3)
        if rate is None:
            found = contact.newton(z(t + dt), *guess)
        else:
            found = contact.newton_at_speed(z(t + dt), *guess, dt) if a > 0 else contact.open_at_axis(z(t + dt), dt)
        y = dt * law.rates
        matters = min(1.0, max(0.1, float(np.max(4 * law.weights * np.minimum(y, 1 / y)))))
        allowed = MOVE * fine * b / matters
        if found is None or max(abs(found[0] - a), abs(found[1] - c)) > 1.5 * allowed:
            dt /= 2.5
            if dt < 1e-7 * lasting:
                if rate is not None and 0 < a < 0.1 * c:
                    contact.at, before, dt = (0.0, c), None, 1e-6 * lasting
                    continue
                contact.begin(0.0)
                found = contact.jump(z(t), 0.97 * a) if a > 0 else None
                if found is None:
                    rows.append((t + 1e-10 * lasting, 0.0))
                    return _made(rows, times, places, begun, t)
                _, P = contact.take(found)
                t += 1e-10 * lasting
                rows.append((t, P))
                dt, before = 1e-6 * lasting, None
            continue
        _, P = contact.take(found)
        before = ((found[0] - a) / dt, (found[1] - c) / dt)
        moved = max(abs(found[0] - a), abs(found[1] - c))
        t += dt
        rows.append((t, P))
        if abs(t - corner) < 1e-9 * lasting:
            t, before, dt = corner, None, 1e-6 * lasting
        else:
            dt *= min(1.6, max(0.5, 0.8 * allowed / max(moved, 1e-300)))
    return _made(rows, times, places, begun, math.inf)


def _made(rows: list[tuple[float, float]], times: Array, places: Array, begun: float, lost: float) -> Made:
    t, P = np.array(rows).T
    return Made(t, np.interp(t, times, places), P, begun, lost)


def sampled(made: Made, t: Array) -> Array:
    """Loads at the times ``t``, none before and behind the contact."""
    return np.where((t < made.begun) | (t > made.lost), 0.0, np.interp(t, made.t, made.P, right=0.0))

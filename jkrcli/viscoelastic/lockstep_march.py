"""Marches of many trial specimens at once through one record: contacts that adhere while their bodies relax.

The equations are those of ``relaxing_adhesion.py``: each step is elastic contact of the modulus G E* under the profile
g = F - H/G, with the radii a of contact and c of the cohesive zone. Here every trial is a row of arrays, has its own
parameters, steps and points, and a kernel K(x, y) = sum of kappa_k u_k(x) u_k(y) of few terms (none: a half-space), so
that with (pi/2) phi = G (delta - g) - u.(kappa mu) in contact, -s sqrt(c^2 - x^2) in the zone,

    mu = int_0^c u (pi/2) phi dx:     (1/kappa + A(a)) kappa mu = G delta beta(a) - G gamma(a) - s rho(a, c)
    continuity at a:                  G delta - u(a).(kappa mu) = G g(a) - s sqrt(c^2 - a^2)

with A = int_0^a u u, beta = int_0^a u, gamma = int_0^a u g, rho = int_a^c u sqrt(c^2 - x^2).

A zone that is narrow beside the contact needs neither be resolved nor followed: it moves through a field that it does
not feel. It is made as wide as a part of the contact by a smaller stress; the work that a steady crack then needs at
the speed v is that of the true zone,

    w/G_0 = J_inf - sum c_i e(q_i b/v),    b = (pi/4) E_0 G_0/sigma^2,

with the creep function J_inf - sum c_i exp(-q_i t), which is 1 at t = 0, and, D being Dawson's function, e(y) = (2/y)
int_0^sqrt(y) D of a crack that opens (after Schapery, Int. J. Fract. 11 (1975) 141). Of one that closes, with d(y) =
D(sqrt(y))/sqrt(y) and e(y) = 2 d(y) - (2/y) int_0^sqrt(y) D,

    w/G = J_inf - sum c_i e(q_i b/v),    G_0 = G [J_inf - sum c_i d(q_i b/v)]^2,    b = (pi/4) E_0 G/sigma^2.

What is left errs like the width over the contact radius, and is extrapolated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.special import dawsn

from ..adhesion.finite_range import AttractedBody
from ..base.numerics import TINY, Array
from ..bodies.problem import Modes, Problem
from .edge_speed import EdgeLaws
from .rate import RateLaw
from .relaxing_adhesion import LEAST_LEFT, ZONE_SLOPE, creep

NODES = 12  # choice: of Gauss, over a zone
INNER = 6  # choice: points of the profile, over the narrowest zone
MOST = 6000  # choice: of them
CLOSE = 5e-3  # choice: of the zone, from which one step of Newton's leaves 1e-4
NEWTON = 12  # choice: steps of Newton's from a prediction, beyond which a shorter step of time is tried
KERNEL_WIDER = 1.5  # choice: from reach to reach of kernels, which are kept
FARTHEST = 4.0  # choice: of the radius as deep as the device goes, that of the largest contact
MOST_ITERATIONS = 2000  # choice: of steps, ten times those of usual records
JUMP_LASTS = 1e-9  # choice: of the program, for rows of one time each
JUMPS_MOST = 5  # choice: of a contact, beyond which it is given up
KERNELS = 8  # choice: that are kept
KERNEL = 1e-5  # theory: of the largest, terms of the kernel that are left out
BENDS = 0.3  # choice: of the largest load, what it is off a straight line, as a zone that its prediction misses
# choice: of a piece of the program, its first step at least and at most; of the shortest time of relaxation
FIRST = 1e-4, 3e-3, 0.1
GROWS = 1.4  # choice: from step to step; of twice as long ones loads have the noise of where they begin
SEARCHED, SECANTS = 32, 5  # choice: radii among which a jump's end is looked for; their zones are then good to 1e-3
RATE_KNOWN = 0.05  # choice: of its speed, what Newton's last step may move an edge whose w depends on it
MOVES = 0.5  # choice: of the zone, by which its edge moves at most while its body relaxes
FEWEST = 4.0  # choice: steps of a piece of the program at least, times the root of the tolerance's inverse
CRACK = np.geomspace(1e-7, 1e9, 260)  # theory: b/v over a time of retardation, beyond which nothing changes


def passing(y: Array) -> tuple[Array, Array, Array]:
    """1 - e(y) of a crack that opens, and of one that closes, and 1 - d(y): how much of exp(-q t) is gone in a zone
    that passes in the time y/q."""
    root, k = np.sqrt(y), np.arange(1, 20)
    # D(x)/x = 1 - 2 x^2/3 + 4 x^4/15 - ..., and (2/x^2) int_0^x D term by term: what is left of 1 counts
    terms = -np.cumprod(-2 * np.minimum(y, 0.5)[..., None] / (2 * k + 1), axis=-1)
    # int_0^x D(q) dq, which rises with the logarithm beyond
    q = np.linspace(0, 1, 4001) ** 2 * 40
    total = np.concatenate([[0], np.cumsum((dawsn(q[1:]) + dawsn(q[:-1])) / 2 * np.diff(q))])
    integral = np.where(root < 40, np.interp(root, q, total), total[-1] + np.log(np.maximum(root, 1) / 40) / 2)
    opening = np.where(y < 0.5, np.sum(terms / (k + 1), axis=-1), 1 - 2 / y * integral)
    edge = np.where(y < 0.5, np.sum(terms, axis=-1), 1 - dawsn(root) / root)
    return opening, 2 * edge - opening, edge


@dataclass(frozen=True, eq=False)
class Kernel:
    """The kernel of a body up to ``reach`` [m] by few terms: ``kappa`` (m,) and the functions at even places up to it,
    ``u`` (places, m)."""

    reach: float
    kappa: Array
    u: Array

    @classmethod
    @lru_cache(maxsize=KERNELS)
    def of(cls, body: AttractedBody, reach: float, places: int = 1000) -> Kernel:
        attraction = body.attraction(reach)
        x = np.linspace(0, attraction.reach, places)
        if attraction.is_half_space:
            return cls(attraction.reach, np.empty(0), np.empty((places, 0)))
        kappa, vectors = np.linalg.eigh(attraction.kernel)
        kept = np.abs(kappa) > KERNEL * np.abs(kappa).max()
        return cls(attraction.reach, kappa[kept], attraction.basis.at(x) @ vectors[:, kept])

    def between(self, rows: Array, x: Array) -> Array:
        """What holds at ``x`` of any shape, by straight lines between the ``rows`` at the places."""
        last = len(rows) - 1
        y = np.minimum(x * (last / self.reach), last)
        i = np.minimum(y.astype(int), last - 1)
        return rows[i] + (y - i).reshape(*x.shape, *[1] * (rows.ndim - 1)) * (rows[i + 1] - rows[i])

    @cached_property
    def discs(self) -> Array:
        """(1/kappa + A)^-1 and, last, beta up to the places, (places, m, m + 1)."""
        products = np.concatenate([self.u[:, :, None] * self.u[:, None, :], self.u[:, :, None]], axis=2)
        width = self.reach / (len(self.u) - 1)
        sums = np.concatenate([0 * products[:1], np.cumsum((products[1:] + products[:-1]) * width / 2, axis=0)])
        sums[..., :-1] = np.linalg.inv(np.diag(1 / self.kappa) + sums[..., :-1])
        return sums

    def disc(self, a: Array) -> tuple[Array, Array]:
        """(1/kappa + A)^-1, (n, m, m), and beta (n, m) of the radii ``a`` [m]."""
        both = self.between(self.discs, a)
        return both[..., :-1], both[..., -1]


@dataclass(frozen=True)
class Trial:
    """A specimen and device with everything over its modulus: ``w`` [m], ``stress`` [-], ``stiffness`` [m], ``modes``
    of relaxation; ``zero``: position of the device [m] of first touch; ``rate``: w over the speed of a receding edge,
    None: the same at all speeds."""

    w: float
    stress: float
    stiffness: float
    modes: Modes
    zero: float = 0.0
    rate: RateLaw | None = None


@dataclass(frozen=True, eq=False)
class Marched:
    """What became of a trial: ``rows`` (n, 5) of t [s], a, c, delta [m] and P over the modulus, when contact began
    and was ``lost`` [s], infinite where it did not, the ``corners`` of the program [s], and whether it was
    ``given_up`` before its end."""

    rows: Array
    begun: float
    lost: float
    corners: Array
    given_up: bool

    def load(self, t: Array) -> Array:
        """P over the modulus [m^2] at the times ``t`` [s], smooth between corners and jumps."""
        at, P = self.rows[:, 0], self.rows[:, 4]
        if at.size < 2:  # the surfaces never came within the range
            return np.where(t < at[0], 0.0, P[0])
        sharp = np.isin(at, self.corners)
        jumps = np.flatnonzero(np.diff(at) < JUMP_LASTS * 1.5 * np.ptp(self.corners))
        sharp[[0, -1]] = sharp[jumps] = sharp[jumps + 1] = True
        h, chord = np.diff(at), np.diff(P) / np.diff(at)
        # as monotone as the rows: harmonic means of chords (Fritsch, Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300)
        w0, w1 = h[:-1] + 2 * h[1:], 2 * h[:-1] + h[1:]
        rising = chord[:-1] * chord[1:] > 0
        c0, c1 = (np.where(rising, one, 1.0) for one in (chord[:-1], chord[1:]))
        slopes = np.concatenate([[0.0], np.where(rising, (w0 + w1) / (w0 / c0 + w1 / c1), 0.0), [0.0]])
        # beside a corner by the parabola of the other end, a straight line between two
        begin, end = slopes[:-1], slopes[1:]
        begin, end = (
            np.where(mine, np.where(others, chord, 2 * chord - other), slope)
            for mine, slope, others, other in ((sharp[:-1], begin, sharp[1:], end), (sharp[1:], end, sharp[:-1], begin))
        )
        i = np.clip(np.searchsorted(at, t, side="right") - 1, 0, at.size - 2)
        x, part = t - at[i], (t - at[i]) / h[i]
        found = P[i] + x * (chord[i] + (1 - part) * ((begin - chord)[i] * (1 - part) - (end - chord)[i] * part))
        return np.where(t < at[0], 0.0, np.where(t > at[-1], P[-1], found))


class March:
    """All ``trials`` through the ``program`` (times [s] and places [m] of its corners) of one device; ``width``: of the
    zone over the contact radius at least, ``tolerance`` of steps in zones; each trial takes
    the next step of that of the ``leaders`` while both took the last, so that what these err by is hardly in their
    differences."""

    def __init__(self, problem: Problem, body: AttractedBody, trials: Sequence[Trial], program: tuple[Array, Array],
                 width: float = 0.004, tolerance: float = 4e-3, steps: int | None = None,
                 leaders: Sequence[int] | None = None) -> None:  # fmt: skip
        self.leader = np.arange(len(trials)) if leaders is None else np.asarray(leaders)
        self.F, self.E, self.tolerance = problem.indenter.abel, problem.E_star, tolerance
        self.steps = steps or MOST_ITERATIONS
        self.t, self.x = program
        most = max(one.modes.rates.size for one in trials)
        self.w, self.stress, self.k, self.zero = (
            np.array([getattr(one, name) for one in trials]) for name in ("w", "stress", "stiffness", "zero")
        )
        self.relaxed = np.array([one.modes.relaxed for one in trials])
        self.weights, self.rates = np.zeros((2, len(trials), most))
        self.rates += 1 / np.ptp(self.t)
        for i, one in enumerate(trials):
            n = one.modes.rates.size
            self.weights[i, :n], self.rates[i, :n] = one.modes.weights, one.modes.rates
        gone = np.exp(-self.rates * np.ptp(self.t))
        self.left = np.maximum(self.relaxed + np.sum(self.weights * gone, axis=1), LEAST_LEFT)
        self.body, self.r_max = body, body.limit
        self.length = self.w / self.stress
        rates, ways = [one.rate for one in trials if one.rate], np.abs(np.diff(self.x))
        self.rate = EdgeLaws.of(rates, self.w, float(np.max(ways / np.diff(self.t)))) if rates else None
        self._prepare(width)

    # ------------------------------------------------------------------ sizes
    def _prepare(self, width: float) -> None:
        """Points and zones: the reach is beyond the largest contact of the moduli that are left in the end."""
        n, top = self.w.size, self.x.max() - self.zero
        # the largest contact of the moduli left, by JKR of the tip in proportion: F(c) = top + sqrt(2 pi w c/E)
        way = min(float(np.abs(top).max()), float(np.ptp(self.x)))
        far = 1e-6 * way
        while self.F(np.array([far]))[0] < way and far < self.r_max / 2:
            far *= 2
        low, high = np.full(n, 1e-4 * far), np.full(n, min(FARTHEST * far, self.r_max))
        for _ in range(60):
            middle = np.sqrt(low * high)
            deep = self.F(middle) - np.sqrt(2 * math.pi * self.w * middle / (self.E * self.left)) > top
            low, high = np.where(deep, low, middle), np.where(deep, middle, high)
        zone = ZONE_SLOPE * self.E * self.w / self.stress**2  # of the instant modulus
        self.kappa = np.minimum(np.sqrt(self.left) * zone / (width * high), 1.0)
        self.sigma = self.stress * np.sqrt(self.kappa)
        zone = zone / self.kappa
        self.reach = np.minimum(1.15 * high + 1.5 * zone, min(2 * FARTHEST * far, self.r_max * (1 - 1e-9)))
        points = int(min(np.max(self.reach / (self.left * zone)) * INNER, MOST)) + 400
        self.d = self.reach / (points - 1)
        self.grid = np.linspace(0, 1, points) * self.reach[:, None]
        self.shape = self.F(self.grid)
        way = float(np.ptp(self.x))
        wider = math.ceil(math.log(float(self.reach.max()) / way, KERNEL_WIDER))
        self.kernel = Kernel.of(self.body, min(way * KERNEL_WIDER**wider, self.r_max))
        self.u = self.kernel.between(self.kernel.u, self.grid)
        self.s0 = 2 * self.sigma / self.E
        self.crack = self._crack() if (self.kappa < 1).any() else None

    def _crack(self) -> tuple[Array, Array, Array]:
        """log v from and its step per trial, and the works of a crack that opens and closes over that of the true zone
        at even steps of log v, logs (2, n, steps)."""
        logs, starts, steps = [], [], []
        for i in range(self.w.size):
            keep, least = self.weights[i] != 0, max(self.relaxed[i], LEAST_LEFT)
            keep[0] = True  # of an elastic body
            weights = self.weights[i, keep] * (1 - least) / max(1 - self.relaxed[i], TINY)
            _, c, q = creep(Modes(least, weights, self.rates[i, keep]))
            T = CRACK / q.max()
            opening, closing, edge = (1 + one @ c for one in passing(np.multiply.outer(T, q)))
            zone = ZONE_SLOPE * self.E * self.w[i] / self.stress[i] ** 2
            own = []
            for eased, needs in ((opening, 1 / opening), (closing, edge**2 / closing)):
                own.append((np.log(zone / eased / T), np.log(needs)))
            even = np.linspace(own[0][0].min() - 1, own[0][0].max() + 1, 400)
            shift = math.log(self.kappa[i])
            both = []
            for log_v, log_G in own:
                order = np.argsort(log_v)
                at = np.interp(even, log_v[order], log_G[order])
                slowed = np.interp(even + shift, log_v[order], log_G[order])
                both.append(at - slowed)
            logs.append(both)
            starts.append(even[0])
            steps.append(even[1] - even[0])
        return np.array(starts), np.array(steps), np.array(logs).transpose(1, 0, 2)

    def _harder(self, rows: Array, v: Array) -> Array:
        """Log of the factor on the range that makes up for a zone wider than the true one, at speeds ``v`` of its end,
        positive outwards [m/s]."""
        if self.crack is None:
            return np.zeros(rows.size)
        start, step, logs = self.crack
        wider = 0.0 if self.rate is None else self.rate.at(rows, -v)[0]  # zones, by w(v)
        y = (np.log(np.maximum(np.abs(v), TINY)) - wider - start[rows]) / step[rows]
        y = np.clip(y, 0, logs.shape[2] - 1.001)
        i, side = y.astype(int), (v > 0).astype(int)
        low = logs[side, rows, i]
        return low + (y - i) * (logs[side, rows, i + 1] - low)

    # ------------------------------------------------------------------ one step
    def _some(self, rows: Array) -> Array | slice:
        """The trials ``rows`` as an index; of all of them one that copies nothing."""
        return slice(None) if rows.size == self.w.size else rows

    def _step(self, rows: Array, h: Array) -> None:
        """Prepare the steps ``h`` of the trials ``rows``."""
        some = self._some(rows)
        z = h[:, None] * self.rates[rows]
        self.decay = np.exp(-z)
        self.gain = np.where(z > 1e-12, -np.expm1(-z) / np.maximum(z, 1e-12), 1.0)
        weights = self.weights[rows]
        eased = np.sum(weights * self.gain, axis=1)
        self.G = self.relaxed[rows] + eased
        remembered = np.einsum("nm,nmx->nx", weights * self.decay, self.eta[some])
        self.H = remembered - eased[:, None] * self.W[some]
        self.g = self.shape[some] - self.H / self.G[:, None]
        self.cum = np.zeros_like(self.g)
        np.cumsum((self.g[:, 1:] + self.g[:, :-1]) * (self.d[rows, None] / 2), axis=1, out=self.cum[:, 1:])

    def _rim(self, at: Array, rows: Array, a: Array, b: Array) -> tuple[Array, Array, Array, Array]:
        """delta, P over the modulus, the gap at c, and kappa mu of states with radii ``a`` and zones ``b``, for the
        prepared steps ``at`` of the trials ``rows``."""
        kernel, G, s0 = self.kernel, self.G[at], self.s0[rows]
        c, d = a + b, self.d[rows]
        root = np.sqrt(b * (2 * a + b))
        theta = np.arctan2(root, a)
        psi = theta[:, None] * GAUSS[0]
        x, line = np.concatenate([c[:, None] * np.cos(psi), a[:, None]], axis=1), self.g.ravel()

        def along(x: Array) -> tuple[Array, Array, Array]:
            # g at radii, the numbers of the cells that these lie in, and the parts of those that are before them
            y = x / d[:, None]
            i = np.minimum(y.astype(int), self.g.shape[1] - 2)
            cell = (at * self.g.shape[1])[:, None] + i
            begin = line[cell]
            return begin + (y - i) * (line[cell + 1] - begin), cell, y - i

        g, cell, part = along(x)
        ga, arc = g[:, -1], theta * (g[:, :-1] @ GAUSS[1])
        inside = self.cum.ravel()[cell[:, -1]] + part[:, -1] * d * (line[cell[:, -1]] + ga) / 2
        sector = (c**2 * theta - a * root) / 2
        if not kernel.kappa.size:
            delta = ga - s0 / G * root
            P = 2 * self.E * (G * (delta * a - inside) - s0 * sector)
            return delta, P, 2 / math.pi * (arc - delta * theta - s0 / G * b), np.empty((a.size, 0))
        u = kernel.between(kernel.u, x)
        ua, uz = u[:, -1], u[:, :-1]
        M, beta = kernel.disc(a)
        # int_0^a u g by Gauss, more nodes near the edge
        x = a[:, None] * INNER_GAUSS[0]
        gamma = a[:, None] * np.matmul((along(x)[0] * INNER_GAUSS[1])[:, None], kernel.between(kernel.u, x))[:, 0]
        rho = (c**2 * theta)[:, None] * np.matmul((GAUSS[1] * np.sin(psi) ** 2)[:, None], uz)[:, 0]
        known = -G[:, None] * gamma - s0[:, None] * rho
        edge = np.matmul(ua[:, None], M)[:, 0]
        delta = (G * ga - s0 * root + np.sum(edge * known, axis=1)) / (G * (1 - np.sum(edge * beta, axis=1)))
        mu = np.matmul(M, ((G * delta)[:, None] * beta + known)[..., None])[..., 0]
        P = 2 * self.E * (G * (delta * a - inside) - np.sum(beta * mu, axis=1) - s0 * sector)
        smooth = theta * (np.matmul(uz, mu[..., None])[..., 0] @ GAUSS[1])
        return delta, P, 2 / math.pi * (arc - delta * theta - s0 / G * b + smooth / G), mu

    def _newton(self, rows: Array, x: Array, a: Array, c: Array, h: Array) -> tuple[Array, ...]:
        """a, c, delta, P, kappa mu and whether these are stable states at the device's places ``x``, near ``a`` and
        ``c``, a time ``h`` later (infinite: in a jump)."""
        n = rows.size
        at, b = np.arange(n), c - a
        good, done = np.ones(n, dtype=bool), np.zeros(n, dtype=bool)
        result = [a.copy(), c.copy(), np.zeros(n), np.zeros(n), np.zeros((n, self.kernel.kappa.size))]
        length = self.w[rows] / self.sigma[rows]
        if np.isfinite(h).all():
            length = length * np.exp(self.harder[rows])
        rate = self.rate if np.isfinite(h).all() else None
        # where the last step left a state within CLOSE, its equations are looked at once more, without slopes
        todo, last, slopes = at, np.zeros(n, dtype=bool), np.zeros((4, n))
        for _ in range(NEWTON):
            r, A, B = rows[todo], a[todo], b[todo]
            touching, wanted = A > 0, length[todo]
            v, lasts, by_v = np.zeros((3, todo.size))
            if rate is not None:
                v, lasts = self._receding(r, A + B, h[todo])
                more, by_v = rate.at(r, v)
                wanted, by_v = wanted * np.exp(more), by_v / lasts
            known = bool(last[todo].all())
            many = 1 if known else 3
            e = 1e-4 * B
            radii = (A, B) if known else (np.concatenate([A, A + e * touching, A]),
                                          np.concatenate([B, B - e * touching, B + e]))  # fmt: skip
            delta, P, gap, mu = self._rim(np.tile(todo, many), np.tile(r, many), *radii)
            delta, P, gap = delta.reshape(many, -1), P.reshape(many, -1), gap.reshape(many, -1)
            place = np.where(touching, delta, delta + gap - wanted) + P / self.k[r]
            opens = np.log(np.maximum(gap / wanted, TINY))
            if not known:
                slopes[:2, todo], slopes[2:, todo] = (place[1:] - place[0]) / e, (opens[1:] - opens[0]) / e
            xa, xc, ga, gc = slopes[:, todo] + np.multiply.outer([0, 0, 0, 1], by_v)
            xc = np.where(touching, xc, xc + wanted * by_v)
            place, opens, off = place[0], opens[0], place[0] - x[todo]
            det = xa * gc - xc * ga
            stable = np.where(touching, (gc > 0) & (det > 0), xc > 0)
            safe = np.where(det != 0, det, 1.0)
            da = np.where(touching, (xc * opens - gc * off) / safe, 0.0)
            dc = np.where(touching, (ga * off - xa * opens) / safe, -off / np.where(xc != 0, xc, 1.0))
            # closed at the axis, or open there
            closing = ~touching & last[todo] & (gap[0] > wanted)
            finished = last[todo] & stable & ~closing
            for target, value in zip(result, (A, A + B, place - P[0] / self.k[r], P[0], mu[: A.size]), strict=True):
                target[todo[finished]] = value[finished]
            good[todo[~stable]] = False
            settled = np.ones(todo.size, dtype=bool)
            if rate is not None:
                to = rate.limited(v, v - dc / lasts)
                dc = (v - to) * lasts
                settled = np.abs(to - v) < RATE_KNOWN * np.maximum(np.abs(v), rate.slow)
            moved = np.maximum(np.abs(da), np.abs(dc - da)) / B
            part = np.minimum(1.0, MOVES / np.maximum(moved, TINY))
            opened = touching & (A + part * da <= 0)
            small = opened & (A < 1e-3 * B)
            part = np.where(opened & ~small, np.minimum(part, (A - 5e-4 * B) / np.where(da < 0, -da, 1.0)), part)
            a[todo] = np.where(small, 0.0, np.where(closing, 1e-3 * B, A + part * da))
            b[todo] = np.where(small, A + B, np.where(closing, (1 - 1e-3) * B, B + part * (dc - da)))
            last[todo] = (moved < CLOSE) & ~small & ~closing & settled
            done[todo[finished]] = True
            outside = ~(a + b < self.reach[rows] * (1 - 1e-6)) | ~(b > 0)
            good &= ~outside
            todo = np.flatnonzero(good & ~done)
            if not todo.size:
                break
        return (*result, good & done)

    def _receding(self, rows: Array, c: Array, h: Array) -> tuple[Array, Array]:
        """The speeds of edges that are at ``c`` a time ``h`` later, at the end of it, and -dc/dv [s] there."""
        mean, known = (self.state[1, rows] - c) / h, self.before[rows]
        on = np.where(known, h / (h + self.lasted[rows]), 0.0)
        return mean + on * (mean + self.speeds[1, rows]), h / (1 + on)

    def _leap(self, rows: Array, x: Array, c: Array, inwards: bool) -> tuple[Array, ...]:
        """The next stable state beyond the radius ``c`` of the prepared steps of no time; as of ``_newton``."""
        n, m = rows.size, SEARCHED
        ends = self.reach[rows, None] * (1 - 1e-5) * np.geomspace(1e-3, 1, m)
        at, r = np.repeat(np.arange(n), m), np.repeat(rows, m)
        end, length = ends.ravel(), (self.w / self.sigma)[r]
        open_ = self._rim(at, r, 0 * end, end)[2] <= length  # the centre is open
        # the wider the zone, the larger the gap: secants in logs from the width of a narrow one
        b = np.minimum(ZONE_SLOPE * self.E * self.G[at] * self.w[r] / self.sigma[r] ** 2, end / 2)
        power, before = np.full(b.size, 1.3), None
        for _ in range(SECANTS):
            off = np.log(np.maximum(self._rim(at, r, end - b, b)[2] / length, 1e-3))
            if before is not None:
                run = np.log(b / before[0])
                slope = (off - before[1]) / np.where(np.abs(run) > 1e-12, run, 1.0)
                power = np.where((np.abs(run) > 1e-9) & (slope > 0.3), slope, power)
            before = b, off
            b = np.minimum(b * np.exp(np.clip(-off / power, -2.0, 2.0)), end * (1 - 1e-9))
        b = np.where(open_, end, b)
        delta, P, gap, _ = self._rim(at, r, end - b, b)
        delta = np.where(open_, delta + gap - length, delta)
        off = (delta + P / self.k[r]).reshape(n, m) - x[:, None]
        rising = (off[:, :-1] < 0) & (off[:, 1:] >= 0)
        inside = ends[:, 1:] > c[:, None] if inwards else ends[:, 1:] < c[:, None]
        rising &= inside
        found = rising.any(axis=1)
        j = np.argmax(rising, axis=1) if inwards else m - 2 - np.argmax(rising[:, ::-1], axis=1)
        i = np.arange(n)
        part = np.where(found, off[i, j] / np.where(found, off[i, j] - off[i, j + 1], 1.0), 0.0)
        end, a = ends, ends - b.reshape(n, m)
        a, c = (one[i, j] + part * (one[i, j + 1] - one[i, j]) for one in (a, end))
        *state, good = self._newton(rows, x, a, c, np.full(n, np.inf))
        return (*state, good & found)

    def _take(self, rows: Array, at: Array, state: tuple[Array, ...]) -> None:
        """Let the bodies of the trials ``rows``, of the prepared steps ``at``, remember their new ``state``."""
        some, taken = self._some(rows), self._some(at)
        a, c, delta, _, mu = (one[at] for one in state)
        x = self.grid[some]
        pulled = -self.s0[rows, None] * np.sqrt(np.maximum((c[:, None] - x) * (c[:, None] + x), 0.0))
        if mu.shape[1]:
            pulled += np.matmul(self.u[some], mu[..., None])[..., 0]
        W = np.where(x < a[:, None], delta[:, None] - self.shape[some], (pulled - self.H[taken]) / self.G[at, None])
        moved = W - self.W[some]
        self.eta[some] = self.decay[at][..., None] * self.eta[some] + self.gain[at][..., None] * moved[:, None]
        self.W[some] = W

    # ------------------------------------------------------------------ the program
    def run(self) -> list[Marched]:
        """Follow all trials to the end, or to the loss of contact."""
        n, points = self.grid.shape
        self.W, self.eta = np.zeros((n, points)), np.zeros((n, self.rates.shape[1], points))
        self.harder, self.jumped = np.zeros(n), np.zeros(n, dtype=int)
        # When the surfaces come within the range [s], and in which piece; infinite where they do not
        self.now, self.piece = np.full(n, np.inf), np.zeros(n, dtype=int)
        for i in range(n):
            off = self.x - self.zero[i] + self.length[i]
            k = int(np.argmax(off > 0))
            if off[k] > 0:
                self.piece[i] = max(k - 1, 0)
                self.now[i] = self.t[0] if k == 0 else self.t[k - 1] + (self.t[k] - self.t[k - 1]) * off[k - 1] / (
                    off[k - 1] - off[k])  # fmt: skip
        self.begun = self.now.copy()
        self.lost, self.given_up = np.full(n, np.inf), np.zeros(n, dtype=bool)
        self.active = np.isfinite(self.now)
        self.state = np.zeros((4, n))  # a, c, delta, P
        # the next step, and what the last one in the same piece tells of the speeds of a and c
        self.h, self.before, self.speeds = np.zeros(n), np.zeros(n, dtype=bool), np.zeros((2, n))
        self.slopes, self.most, self.lasted = np.zeros(n), np.full(n, TINY), np.zeros(n)
        self.history: list[tuple[Array, ...]] = []

        self._note(np.arange(n))
        rows = np.flatnonzero(self.active)
        self._jump(rows, np.ones(rows.size, dtype=bool))
        for _ in range(self.steps):
            rows = np.flatnonzero(self.active)
            if not rows.size:
                break
            self._advance(rows)
        self.given_up |= self.active
        rows = np.concatenate([one[0] for one in self.history])
        columns = np.stack([np.concatenate([one[k] for one in self.history]) for k in range(1, 6)], axis=1)
        return [Marched(columns[rows == i], float(self.begun[i]), float(self.lost[i]), self.t, bool(self.given_up[i]))
                for i in range(n)]  # fmt: skip

    def _advance(self, rows: Array) -> None:
        """A step of time of the trials ``rows``; shorter next time where it is not good, a jump where none is."""
        a0, c0 = self.state[:2, rows]
        zone, span = c0 - a0, np.diff(self.t)[self.piece[rows]]
        rest = self.t[self.piece[rows] + 1] - self.now[rows]
        step = np.minimum(self.h[rows], span * math.sqrt(self.tolerance) / FEWEST)
        step = np.where(step > rest * (1 - 1e-6), rest, np.where(2 * step > rest, rest / 2, step))
        self._step(rows, step)

        # where nothing relaxes, the zone passes in one step
        z = step[:, None] * self.rates[rows]
        matters = np.clip(np.max(4 * self.weights[rows] * np.minimum(z, 1 / np.maximum(z, TINY)), axis=1), 0.05, 1)
        reach = 2 * MOVES * zone / matters
        a, c = self.state[:2, rows] + np.where(self.before[rows], self.speeds[:, rows] * step, 0.0)
        a = np.where(a0 > 0, np.clip(a, np.maximum(a0 - reach, a0 / 2), a0 + reach), 0.0)
        c = a + np.clip(c - a, zone / 2, 2 * zone)
        *there, good = self._newton(rows, self._place(rows, self.now[rows] + step), a.copy(), c.copy(), step)

        moved = np.abs(there[0] - a0) + np.abs(there[1] - c0)
        missed = (np.abs(there[0] - a) + np.abs(there[1] - c)) / zone * matters
        bends = np.abs(there[3] - self.state[3, rows] - self.slopes[rows] * step) / (BENDS * self.most[rows])
        missed = np.maximum(missed, bends)
        missed = np.where(self.before[rows], missed, (moved / 0.1 / zone) ** 2 * self.tolerance * matters)
        taken = good & (missed <= 4 * self.tolerance) & (moved <= 2 * reach)
        self.h[rows] = step * np.where(
            taken, np.clip(0.8 * np.sqrt(self.tolerance / np.maximum(missed, TINY)), 0.4, GROWS), 0.4
        )
        good = np.zeros(self.active.size, dtype=bool)
        good[rows] = taken
        self.h = np.where(good & good[self.leader], self.h[self.leader], self.h)
        if taken.any():
            self._reached(rows[taken], np.flatnonzero(taken), there, step[taken], rest[taken])
        shortest = np.minimum(1e-5 * np.ptp(self.t), 1e-3 / self.rates[rows].max(axis=1))
        stuck = rows[~taken & (self.h[rows] < shortest)]
        if stuck.size:
            self._jump(stuck, self.speeds[1, stuck] > 0)

    def _reached(self, rows: Array, at: Array, there: Sequence[Array], step: Array, rest: Array) -> None:
        """The trials ``rows``, of the prepared steps ``at``, are in the states ``there`` after ``step``, of which
        ``rest`` is left of their piece of the program."""
        self._take(rows, at, tuple(there))
        moves = np.stack([there[0][at], there[1][at]]) - self.state[:2, rows]
        part = -np.expm1(-np.abs(moves[1]) / 2 / (self.state[1, rows] - self.state[0, rows]))
        self.speeds[:, rows], self.lasted[rows] = moves / step, step
        self.slopes[rows] = (there[3][at] - self.state[3, rows]) / step
        self.most[rows] = np.maximum(self.most[rows], np.abs(there[3][at]))
        self.harder[rows] += part * (self._harder(rows, self.speeds[1, rows]) - self.harder[rows])
        self.state[:, rows] = [one[at] for one in there[:4]]

        ended = step == rest
        self.now[rows] = np.where(ended, self.t[self.piece[rows] + 1], self.now[rows] + step)
        self.before[rows] = ~ended
        self.piece[rows] += ended
        self._note(rows)
        over = ended & (self.piece[rows] >= self.t.size - 1)
        self.active[rows[over]] = False
        self._begin_piece(rows[ended & ~over])

    def _jump(self, rows: Array, inwards: Array) -> None:
        """Jumps of the trials ``rows`` in no time, of larger zones where they go ``inwards``; contact that finds no
        state is lost."""
        for way in (True, False):
            some = rows[inwards == way]
            if not some.size:
                continue
            self._step(some, np.zeros(some.size))
            *there, found = self._leap(some, self._place(some, self.now[some]), self.state[1, some], way)
            self.jumped[some] += 1
            self.given_up[some] = found & (self.jumped[some] >= JUMPS_MOST)
            good = found & ~self.given_up[some]
            self._take(some[good], np.flatnonzero(good), tuple(there))
            self.state[:, some] = np.where(good, there[:4], 0.0)
            gone = some[~good]
            self.active[gone] = False
            self.lost[gone] = np.where(np.isfinite(self.begun[gone]), self.now[gone], np.inf)
            self.now[some] += JUMP_LASTS * np.ptp(self.t)
            self._note(some)
        self.harder[rows] = 0.0
        self._begin_piece(rows)

    def _begin_piece(self, rows: Array) -> None:
        """The first step behind a corner or a jump of the trials ``rows``, which nothing foretells."""
        piece = np.diff(self.t)[self.piece[rows]]
        shortest = 1 / np.max(self.rates[rows], axis=1)
        self.h[rows] = np.clip(FIRST[2] * shortest, FIRST[0] * piece, FIRST[1] * piece)
        self.before[rows] = False

    def _note(self, rows: Array) -> None:
        self.history.append((rows, self.now[rows], *self.state[:, rows]))

    def _place(self, rows: Array, t: Array) -> Array:
        """Positions of the device over those of first touch [m]."""
        return np.interp(t, self.t, self.x) - self.zero[rows]


_nodes, _weights = np.polynomial.legendre.leggauss(NODES)
GAUSS = (_nodes + 1) / 2, _weights / 2
INNER_GAUSS = tuple(
    np.concatenate([begin * share + width * part for begin, width in ((0.0, 0.6), (0.6, 0.3), (0.9, 0.1))])
    for part, share in zip(GAUSS, (1.0, 0.0), strict=True)
)

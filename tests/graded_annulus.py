"""Adhesion of finite range on layers whose moduli vary over depth, from the equations of elasticity: one differential
equation per wave number, and integrals by plain quadrature on intervals that shrink towards what is singular.

In Hankel space, z downwards, u_r = U J1, u_z = W J0, sigma_rz = T J1, sigma_zz = Z J0:

    U' = k W + T/mu,  W' = (Z - lambda k U)/M,  T' = k lambda Z/M + 4 mu (lambda + mu) k^2 U/M,  Z' = -k T,
    M = lambda + 2 mu,

so that the compliance C of what lies below, (U, W) = C (T, Z), obeys C' = A11 C + A12 - C A21 C - C A22.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.special import k0, k1, kn, spherical_jn

Array = np.ndarray
Transform = Callable[[Array], Array]
SEEN = 25.0  # over k: the depth from which nothing is felt, exp(-2 * 25)
DEGREE = 20  # of g over each octave
CUTS, FEW = 26, 9  # to a third, of intervals next to a logarithm, and next to what is smoother
NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)


@dataclass(frozen=True)
class Stack:
    """Layers (thickness [m], modulus over the depth in it [Pa], nu) from the top, bonded to a rigid base, or to a
    half-space (modulus, nu)."""

    layers: Sequence[tuple[float, Callable[[Array], Array], float]]
    base: tuple[float, float] | None = None

    @property
    def E_star(self) -> float:
        _, E, nu = self.layers[0]
        return float(E(np.zeros(1))[0]) / (1 - nu**2)

    def compliance_ratio(self, k: Array) -> Array:
        """g(k): surface compliance over that of a half-space of what lies at the surface."""
        depths = np.cumsum([0.0, *(thickness for thickness, _, _ in self.layers)])
        start = np.minimum(SEEN / k, depths[-1])
        C = np.zeros((3, k.size)) if self.base is None else _half_space(*self.base, k)  # rr, rz, zz
        for top, bottom, (_, E, nu) in reversed(list(zip(depths[:-1], depths[1:], self.layers, strict=True))):
            begins = start < bottom
            C = np.where(begins, _half_space(E(np.clip(start - top, 0.0, bottom - top)), nu, k), C)
            low = np.clip(start, top, bottom)

            def rates(part: float, flat: Array, top=top, low=low, E=E, nu=nu) -> Array:
                z = low + part * (top - low)
                return (_riccati(flat.reshape(3, -1), E(z - top), nu, k) * (top - low)).ravel()

            scale = np.abs(C).max(axis=0) + 1e-3 / (float(E(np.zeros(1))[0]) * k)
            C = solve_ivp(
                rates, (0.0, 1.0), C.ravel(), "DOP853", rtol=1e-12, atol=np.tile(scale * 1e-13, 3)
            ).y[:, -1].reshape(3, -1)  # fmt: skip
        return -C[2] * self.E_star * k / 2


def _lame(E: Array | float, nu: float) -> tuple[Array | float, Array | float]:
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def _half_space(E: Array | float, nu: float, k: Array) -> Array:
    mu = np.broadcast_to(_lame(E, nu)[1], k.shape)
    one = (1 - nu) / (mu * k)
    return np.stack([-one, (1 - 2 * nu) / (2 * mu * k), -one])


def _riccati(C: Array, E: Array, nu: float, k: Array) -> Array:
    rr, rz, zz = C
    lam, mu = _lame(E, nu)
    M = lam + 2 * mu
    share, stiff = k * lam / M, 4 * mu * (lam + mu) * k**2 / M
    return np.stack([
        k * rz + 1 / mu - stiff * rr**2 + rz * k,
        k * zz - stiff * rr * rz - rr * share,
        -share * rz + 1 / M - stiff * rz**2 - rz * share,
    ])  # fmt: skip


def kernel_of(stack: Stack, reach: float, finest: float) -> Transform:
    """int_0^inf (g - 1) cos(ks) dk [1/m] over s in (1e-14, 2) ``reach`` [m]; ``finest``: the least length [m] over
    which the body changes."""
    edges = np.append(0.0, 2.0 ** np.arange(-24, 11) / finest)
    nodes, weights = np.polynomial.legendre.leggauss(DEGREE)
    k = ((edges[:-1] + edges[1:])[:, None] + np.diff(edges)[:, None] * nodes) / 2
    rest = stack.compliance_ratio(k.ravel()) - 1
    # What decays like powers of 1/k is fitted, and transformed in closed form
    q, far = 1 / finest, slice(-6 * DEGREE, None)
    root = q / np.hypot(k.ravel(), q)
    powers = root[:, None] ** np.arange(1, 9)
    c = np.linalg.lstsq(powers[far], rest[far], rcond=1e-16)[0]
    rest = (rest - powers[:, :5] @ c[:5]).reshape(k.shape)
    project = np.polynomial.legendre.legvander(nodes, DEGREE - 1) * (np.arange(DEGREE) + 0.5) * weights[:, None]
    coefficients, half, middle = rest @ project, np.diff(edges) / 2, (edges[:-1] + edges[1:]) / 2
    ln_s = np.linspace(math.log(1e-14 * reach), math.log(2 * reach), 3500)
    s = np.exp(ln_s)
    x = q * s
    total = q * (c[0] * k0(x) + c[1] * math.pi / 2 * np.exp(-x) + c[2] * x * k1(x))
    total += q * (c[3] * math.pi / 4 * (1 + x) * np.exp(-x) + c[4] * x**2 / 3 * kn(2, x))
    for each, w, m in zip(coefficients, half, middle, strict=True):
        if np.abs(each).max() * w > 1e-15 / finest:
            series = sum(a * 1j**n * spherical_jn(n, w * s) for n, a in enumerate(each))
            total += 2 * w * np.real(np.exp(1j * m * s) * series)
    spline = make_interp_spline(ln_s, total, 5)
    return lambda s: spline(np.log(np.maximum(s, 1e-14 * reach)))


def _halved(ends: tuple[float, float], at: Sequence[float], cuts: int = CUTS) -> tuple[Array, Array]:
    """Nodes and weights between the ``ends`` on intervals that shrink by thirds towards each of the places ``at``."""
    lo, hi = ends
    steps = 3.0 ** -np.arange(1, cuts)
    edges = [lo, hi, *np.linspace(lo, hi, 7)]
    for place in at:
        if lo <= place <= hi:
            edges += [*(place - (place - lo) * steps), place, *(place + (hi - place) * steps)]
    edges = np.unique(edges)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1] + edges[1:])[:, None] / 2 + half * NODES).ravel(), (half * WEIGHTS).ravel()


@dataclass(frozen=True)
class Contact:
    """A paraboloid of the radius ``R`` [m] in contact up to ``a`` [m] on a body with the kernel ``tau`` of the
    distance; phi is a polynomial of ``degree`` in v, x = a (1 - v^4)."""

    R: float
    E_star: float
    tau: Transform
    a: float
    degree: int = 40

    def __post_init__(self) -> None:
        n = self.degree + 1
        v = (1 + np.cos(np.pi * (np.arange(n) + 0.5) / n)) / 2
        x, T = self.a * (1 - v**4), self._values(v)
        A = np.array([self.moments(each, place) for each, place in zip(x, v, strict=True)]) + math.pi / 2 * T
        edge = self.moments(self.a, 0.0)
        F = x**2 / self.R
        object.__setattr__(self, "solve", lambda right: np.linalg.solve(A, right))
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "edge", edge)
        object.__setattr__(self, "flat", np.linalg.solve(A, np.ones(n)))
        object.__setattr__(self, "shaped", np.linalg.solve(A, F))
        u, w = _halved((0.0, 1.0), [])
        object.__setattr__(self, "sums", (w * 4 * self.a * u**3) @ self._values(u))

    def _values(self, v: Array) -> Array:
        return np.polynomial.chebyshev.chebvander(2 * v - 1, self.degree)

    def K(self, x: Array, t: Array) -> Array:
        return (self.tau(np.abs(x - t)) + self.tau(x + t)) / 2

    def moments(self, x: float, v: float) -> Array:
        """int_0^a K(x, t) T_n(t) dt at a place, x = a (1 - v^4) inside."""
        u, w = _halved((0.0, 1.0), [v, 1.0] if v > 0.8 else [v])
        near = np.abs(self.a * (u - v) * (u + v) * (u**2 + v**2)) + max(x - self.a, 0.0)
        K = (self.tau(near) + self.tau(x + self.a * (1 - u**4))) / 2
        return (w * K * 4 * self.a * u**3) @ self._values(u)

    def state(self, c: float, s: float) -> tuple[float, float, float]:
        """delta [m], P [N] and the gap at c [m] for the tension s = 2 sigma/E*."""
        a, whole = self.a, math.acos(self.a / c)
        theta, w = _halved((0.0, whole), [whole])
        t, tension = c * np.cos(theta), w * (c * np.sin(theta)) ** 2
        R = self.K(self.x[:, None], t) @ tension
        solved, factor = self.solve(R), 2 / math.pi * s
        pulled = float(self.K(np.array(a), t) @ tension) - self.edge @ solved
        edge, z = 1 - self.edge @ self.flat, a**2 / self.R - self.edge @ self.shaped
        root = math.sqrt(c**2 - a**2)
        delta = (z - factor * pulled - s * root) / edge
        phi = delta * self.flat - self.shaped + factor * solved
        P = math.pi * self.E_star * (self.sums @ phi - factor * (c**2 * whole - a * root) / 2)
        theta, w = _halved((0.0, whole), [whole], FEW)
        t = c * np.cos(theta)
        smooth = np.array([self.moments(y, 0.0) @ phi for y in t]) - factor * own_pull(self.tau, c, whole, theta)
        arc = c**2 / self.R * (whole / 2 + math.sin(2 * whole) / 4)
        gap = arc - delta * whole - s * (c - a) + float(w @ smooth)
        return delta, P, 2 / math.pi * gap

    def closed(self, s: float, gap: float, c: float) -> tuple[float, float, float]:
        """c [m], delta [m] and P [N] at the separation ``gap`` [m], by secants from near ``c``."""
        places = [c, self.a + (c - self.a) * 1.0003]
        found = [self.state(each, s) for each in places]
        for _ in range(4):
            step = (places[-1] - places[-2]) / (found[-1][2] - found[-2][2]) * (gap - found[-1][2])
            if abs(step) < 1e-9 * (c - self.a):
                break
            places.append(places[-1] + step)
            found.append(self.state(places[-1], s))
        slope = (np.array(found[-1]) - found[-2]) / (found[-1][2] - found[-2][2])
        delta, P, _ = np.array(found[-1]) + slope * (gap - found[-1][2])
        return places[-1], float(delta), float(P)


def own_pull(tau: Transform, c: float, whole: float, eta: Array) -> Array:
    """int K(y, t) sqrt(c^2 - t^2) dt [m] across the annulus at y = c cos(eta)."""
    total = np.empty_like(eta)
    for i, each in enumerate(eta):
        theta, w = _halved((0.0, whole), [each, whole] if whole > 1.5 else [each])
        near = 2 * c * np.abs(np.sin((each + theta) / 2) * np.sin((each - theta) / 2))
        K = (tau(near) + tau(c * (math.cos(each) + np.cos(theta)))) / 2
        total[i] = (w * K) @ (c * np.sin(theta)) ** 2
    return total


def apart(R: float, E_star: float, tau: Transform, c: float, s: float, gap: float) -> tuple[float, float]:
    """delta [m] and P [N] where nothing touches."""
    theta, w = _halved((0.0, math.pi / 2), [math.pi / 2], FEW)
    pull = 2 / math.pi * s * (c + 2 / math.pi * w @ own_pull(tau, c, math.pi / 2, theta))
    return c**2 / (2 * R) - pull - gap, -math.pi * E_star * s / 2 * c**2

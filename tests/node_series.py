"""Series as finite elements report them, contact radii those of nodes, with the exact pull-off points behind them.

Bodies are solved here by a plain Nystroem solution of their integral equation, one dense solve per radius; the surface
compliance of a stack comes from one linear system per wave number, of Love's function in each layer. Shares no code
with what reads such series.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen

LENGTH, MODULUS = 1e-4, 1e6  # units of the bodies below [m], [Pa]
ONE = (1.0, 0.0)  # E and nu of a stack are given in pairs


# ---------------------------------------------------------------------- surface compliance
def compliance(k: np.ndarray, layers: tuple, base: tuple | str) -> np.ndarray:
    """g(k) = k E*/2 u_z/p of ``layers`` (thickness, E, nu) from the top, on a half-space ``base`` (E, nu), or "bonded"
    or "frictionless" to a rigid one; E* of the uppermost."""
    if not layers:
        return np.ones_like(k)
    half_space = not isinstance(base, str)
    n = 4 * len(layers) + (2 if half_space else 0)
    A, b = np.zeros((k.size, n, n)), np.zeros((k.size, n))
    _, E, nu = layers[0]
    top = _fields(k, layers[0], 0.0)
    A[:, 0, :4], A[:, 1, :4] = top[2], top[3]
    b[:, 0] = -1.0
    row = 2
    for i, layer in enumerate(layers):
        below = _fields(k, layer, layer[0])
        here = slice(4 * i, 4 * i + 4)
        if i + 1 < len(layers):
            other, there = _fields(k, layers[i + 1], 0.0), slice(4 * i + 4, 4 * i + 8)
        elif half_space:
            other, there = [part[:, :2] for part in _fields(k, (1.0, *base), 0.0)], slice(n - 2, n)
        else:
            for part in (below[1], below[0] if base == "bonded" else below[3]):
                A[:, row, here] = part
                row += 1
            break
        for part, next_part in zip(below, other, strict=True):
            A[:, row, here], A[:, row, there] = part, -next_part
            row += 1
    scale = np.abs(A).max(axis=2, keepdims=True)
    c = np.linalg.solve(A / scale, (b / scale[:, :, 0])[:, :, None])[:, :4, 0]
    return k * E / (1 - nu**2) / 2 * np.einsum("ni,ni->n", top[1], c)


def _fields(k: np.ndarray, layer: tuple, z: float) -> list[np.ndarray]:
    """u_r, u_z, sigma_zz, sigma_rz (each (n, 4)) at depth ``z`` by Love's function (A + B kz) e^-kz and
    (C + D k(z - h)) e^k(z - h), times k^-3 for stresses and k^-2 for displacements."""
    h, E, nu = layer
    G, kz = E / 2 / (1 + nu), k * z
    down, up = np.exp(-kz), np.exp(k * (z - h))
    y = k * (z - h)
    zero = [np.stack([down, kz * down, up, y * up], axis=1)]
    one = np.stack([-down, (1 - kz) * down, up, (1 + y) * up], axis=1)
    two = np.stack([down, (kz - 2) * down, up, (2 + y) * up], axis=1)
    three = np.stack([-down, (3 - kz) * down, up, (3 + y) * up], axis=1)
    Z = zero[0]
    inverse = 1 / k[:, None]  # displacements over stresses
    return [
        one / (2 * G) * inverse,
        ((1 - 2 * nu) * two - 2 * (1 - nu) * Z) / (2 * G) * inverse,
        (1 - nu) * three - (2 - nu) * one,
        nu * two + (1 - nu) * Z,
    ]


# ---------------------------------------------------------------------- contact
@dataclass(frozen=True)
class NodeBody:
    """A body in units of ``LENGTH`` and ``MODULUS`` under a tip of radius ``R``; ``a_max``: of its series."""

    name: str
    layers: tuple
    base: tuple | str
    R: float
    a_max: float
    sphere: bool = False

    @property
    def problem(self) -> Problem:
        """What is told to the reader."""
        layers = tuple(Layer(Elastic(E * MODULUS, nu), h * LENGTH) for h, E, nu in self.layers)
        if isinstance(self.base, str):
            base = Rigid(bonded=self.base == "bonded")
        else:
            base = HalfSpace(Elastic(self.base[0] * MODULUS, self.base[1]))
        tip = Sphere(self.R * LENGTH) if self.sphere else Paraboloid(self.R * LENGTH)
        return Problem(tip, Specimen(layers, base), Loading("depth", 1e-6, 10))

    @property
    def E_star(self) -> float:
        E, nu = self.layers[0][1:] if self.layers else self.base
        return E / (1 - nu**2)

    def abel(self, x: np.ndarray) -> np.ndarray:
        """F(x), the displacement at which a half-space is touched out to x."""
        if self.sphere:
            return x / 2 * np.log((self.R + x) / (self.R - x))
        return x**2 / self.R

    @cached_property
    def logs(self) -> CubicSpline:
        """Logs of delta_H, P_H, S, S' over log a."""
        radii = self.a_max * np.geomspace(0.01, 1.1, 56)
        return CubicSpline(np.log(radii), np.log([self._contact(a) for a in radii]))

    def columns(self, a: np.ndarray, order: int = 0) -> np.ndarray:
        """delta_H, P_H, S, S' (4, ...) at radii, or their derivatives by the radius."""
        values = np.exp(np.moveaxis(self.logs(np.log(a)), -1, 0))
        return values if order == 0 else values * np.moveaxis(self.logs(np.log(a), 1), -1, 0) / a

    def _contact(self, a: float) -> tuple[float, ...]:
        nodes = 40
        x, weights = np.polynomial.legendre.leggauss(nodes)
        t, dt = a * (x + 1) / 2, a * weights / 2
        kernel = np.zeros((nodes + 1, nodes + 1))
        if self.layers:
            k, dk, g = self._spectrum
            waves = np.cos(np.outer(np.append(t, a), k))
            kernel = waves * ((g - 1) * dk) @ waves.T * 2 / math.pi
        matrix = np.eye(nodes) + kernel[:-1, :-1] * dt
        right = np.stack([np.ones(nodes), self.abel(t)], axis=1) * 2 / math.pi
        flat, bowl = np.linalg.solve(matrix, right).T
        ends = 2 / math.pi * np.array([1.0, float(self.abel(np.array(a)))])
        edge_flat, edge_bowl = ends - kernel[-1, :-1] * dt @ np.stack([flat, bowl], axis=1)
        delta, unit = edge_bowl / edge_flat, math.pi * self.E_star
        return (delta, unit * dt @ (delta * flat - bowl), unit * dt @ flat, unit * math.pi / 2 * edge_flat**2)

    @cached_property
    def _spectrum(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Wave numbers, weights and g(k), from far below the inverse of the depth to beyond that of the top layer."""
        x, weights = np.polynomial.legendre.leggauss(12)
        deep, top = sum(layer[0] for layer in self.layers), self.layers[0][0]
        width = 3.0 / max(self.a_max, top)
        fine = np.geomspace(1e-4 / deep, width, 24)
        edges = np.concatenate([[0.0], fine, np.arange(2 * width, 22 / top, width)])
        k = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2).ravel()
        return k, (np.diff(edges)[:, None] * weights / 2).ravel(), compliance(k, self.layers, self.base)

    # ------------------------------------------------------------------ adhesion
    def work(self, a: float) -> float:
        """The work of adhesion whose contact is lost at radius ``a`` under load control: dP_H = sqrt(w) d(S t)."""
        _, dP, _, _ = self.columns(np.array(a), 1)
        return float(dP / self._pulled(np.array(a), 1e-4 * a)) ** 2

    def _pulled(self, a: np.ndarray, step: float) -> np.ndarray:
        """d(S t)/da at w = 1."""
        ahead, behind = (self._parts(a + sign * step) for sign in (1, -1))
        return (ahead[1] - behind[1]) / (2 * step)

    def _parts(self, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """t and S t at w = 1."""
        _, _, S, dS = self.columns(a)
        t = np.sqrt(4 * math.pi * a / dS)
        return t, S * t

    def pull_off(self, w: float, control: str) -> tuple[float, float, float]:
        """a, delta, P of the exact pull-off under control of the "load" or the "displacement"; in units."""
        a = self.a_max * np.geomspace(0.012, 1.08, 4000)
        delta, P, _, _ = self.columns(a)
        t, St = self._parts(a)
        delta, P = delta - math.sqrt(w) * t, P - math.sqrt(w) * St
        i = int(np.argmin(P if control == "load" else delta))
        rows = slice(max(i - 2, 0), i + 3)
        bend = np.polyfit(a[rows] - a[i], (P if control == "load" else delta)[rows], 2)
        at = a[i] - bend[1] / (2 * bend[0])
        return at, *(float(np.polyval(np.polyfit(a[rows] - a[i], y[rows], 3), at - a[i])) for y in (delta, P))


BODIES = (
    NodeBody("half-space", (), (1.0, 0.4), 50.0, 5.0),
    NodeBody("sphere on half-space", (), (1.0, 0.3), 30.0, 5.0, sphere=True),
    NodeBody("bonded 0.3", ((1.0, 1.0, 0.3),), "bonded", 60.0, 3.0),
    NodeBody("bonded 0.45", ((1.0, 1.0, 0.45),), "bonded", 100.0, 1.5),
    NodeBody("bonded 0.49 sphere", ((1.0, 1.0, 0.49),), "bonded", 40.0, 2.0, sphere=True),
    NodeBody("bonded 0.499", ((1.0, 1.0, 0.499),), "bonded", 200.0, 4.0),
    NodeBody("sliding 0.4", ((1.0, 1.0, 0.4),), "frictionless", 80.0, 3.0),
    NodeBody("sliding 0.49", ((1.0, 1.0, 0.49),), "frictionless", 50.0, 1.0),
    NodeBody("stiff coating", ((1.0, 10.0, 0.3),), (1.0, 0.4), 60.0, 3.0),
    NodeBody("soft coating", ((1.0, 1.0, 0.45),), (10.0, 0.3), 60.0, 2.5),
    NodeBody("two layers", ((0.5, 1.0, 0.4), (1.0, 5.0, 0.3)), "bonded", 60.0, 2.0),
    NodeBody("stack on half-space", ((0.4, 4.0, 0.3), (0.8, 1.0, 0.45)), (20.0, 0.25), 60.0, 2.0),
)


# ---------------------------------------------------------------------- what elements report
@dataclass(frozen=True)
class NodeSeries:
    """Columns [m, m, N] as elements report them, and what made them.

    ``elements`` under the largest contact; ``ahead``: by what part of one the edge is beyond a node that begins to
    carry; ``node``: whose radius it is, "outermost" that carries, the "next" one or the "nearest" to the edge;
    ``noise``: relative, of displacement and load.
    """

    body: NodeBody
    elements: int
    increments: int
    ahead: float
    node: str
    area: bool
    noise: float
    w: float
    columns: np.ndarray

    @property
    def spacing(self) -> float:
        """Of the nodes [m]."""
        return self.body.a_max * LENGTH / self.elements

    def exact(self, control: str = "load") -> tuple[float, float, float]:
        """a, delta [m], P [N] of the exact pull-off."""
        a, delta, P = self.body.pull_off(self.w / (MODULUS * LENGTH), control)
        return a * LENGTH, delta * LENGTH, P * MODULUS * LENGTH**2

    def write(self, path: Path, load: float = 1.0) -> Path:
        """The table, its loads times ``load``."""
        a, delta, P = self.columns
        size = ("contact area (m^2)", math.pi * a**2) if self.area else ("contact radius (m)", a)
        table = np.stack([delta, P * load, size[1]], axis=1)
        np.savetxt(path, table, delimiter=",", header=f"U2 (m),RF2 (N),{size[0]}", comments="", fmt="%.9g")
        return path


def node_series(
    body: NodeBody, elements: int, increments: int, ahead: float, node: str = "outermost", area: bool = False,
    noise: float = 0.0, po: float = 0.4, rng: np.random.Generator | None = None, spacing: str = "depth",
) -> NodeSeries:  # fmt: skip
    """A series to the radius ``body.a_max`` by increments even in the depth; lost under load at ``po`` of it."""
    even = np.arange(1, increments + 1) / increments
    deepest = float(body.columns(np.array(body.a_max))[0])
    if spacing == "depth":
        inner = np.geomspace(0.0101, 1.0, 2000) * body.a_max
        a = np.interp(even * deepest, np.concatenate([[0.0], body.columns(inner)[0]]), np.concatenate([[0.0], inner]))
        for _ in range(4):  # Newton
            a = np.maximum(a - (body.columns(a)[0] - even * deepest) / body.columns(a, 1)[0], 0.2 * a)
    else:
        a = even * body.a_max
    a = a[a > 0.0101 * body.a_max]
    e = body.a_max / elements
    lowest = {"outermost": 0.0, "next": 1.0, "nearest": 0.5}[node]
    carrying = np.floor(a / e - ahead)  # outermost node that carries, the axis being 0
    radius = np.where(carrying >= 0, carrying, 0.0)
    if node == "next":
        radius = carrying + 1
    elif node == "nearest":
        radius = np.floor(a / e - ahead + lowest)
    delta, P = body.columns(a)[:2]
    if noise:
        delta, P = (values * (1 + noise * rng.standard_normal(a.size)) for values in (delta, P))
    touching = radius > 0
    columns = np.stack([radius * e * LENGTH, delta * LENGTH, P * MODULUS * LENGTH**2])[:, touching]
    w = body.work(po * body.a_max) * MODULUS * LENGTH
    return NodeSeries(body, elements, increments, ahead, node, area, noise, w, columns)


def many(number: int, seed: int = 0, ahead: tuple[float, ...] | None = None) -> Iterator[NodeSeries]:
    """Series of all kinds, drawn; ``ahead``: only these."""
    rng = np.random.default_rng(seed)
    for i in range(number):
        body = BODIES[i % len(BODIES)]
        elements = int(np.exp(rng.uniform(np.log(12), np.log(100))))
        increments = int(np.exp(rng.uniform(np.log(40), np.log(400))))
        choices = ahead or (0.0, 0.15, 0.3, float(rng.uniform(0, 0.3)))
        o = choices[int(rng.integers(len(choices)))]
        node = ("outermost", "outermost", "outermost", "next", "nearest")[int(rng.integers(5))]
        noise = (0.0, 0.0, 1e-4, 1e-3)[int(rng.integers(4))]
        po, spacing = float(rng.uniform(0.25, 0.6)), ("depth", "depth", "radius")[int(rng.integers(3))]
        yield node_series(body, elements, increments, o, node, bool(rng.random() < 0.25), noise, po, rng, spacing)

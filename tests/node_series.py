"""Series as finite elements report them, contact radii those of nodes, with the exact pull-off points behind them.

Bodies are solved by a plain Nystroem solution of their integral equation (``layer_contact``), one dense solve per
radius; the surface compliance of a stack comes from one linear system per wave number (``stack_fields``). Shares no
code with what reads such series.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
from layer_contact import contact
from meshed_series import Exact
from scipy.interpolate import CubicSpline
from stack_fields import surface_displacement

from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen

LENGTH, MODULUS = 1e-4, 1e6  # units of the bodies below [m], [Pa]


@dataclass(frozen=True)
class NodeBody(Exact):
    """A body in units of ``LENGTH`` and ``MODULUS`` under a tip of radius ``R``, layers as (thickness, E, nu) on a
    half-space (E, nu) or "bonded" or "frictionless" to a rigid base; ``a_max``: of its series."""

    beyond: ClassVar[float] = 1.1

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
    def end(self) -> float:
        return self.a_max

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
        radii = self.a_max * np.geomspace(0.01, self.beyond, 56)
        return CubicSpline(np.log(radii), np.log([self._contact(a) for a in radii]))

    def _contact(self, a: float) -> tuple[float, ...]:
        delta, P, S, dS = contact(a, None, 40, self.abel, self._spectrum)
        return delta, self.E_star * P, self.E_star * S, self.E_star * dS

    @cached_property
    def _spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        """k and (g(k) - 1) dk, from far below the inverse of the depth to beyond that of the top layer."""
        if not self.layers:
            return np.zeros(1), np.zeros(1)
        x, weights = np.polynomial.legendre.leggauss(12)
        deep, top = sum(layer[0] for layer in self.layers), self.layers[0][0]
        width = 3.0 / max(self.a_max, top)
        fine = np.geomspace(1e-4 / deep, width, 24)
        edges = np.concatenate([[0.0], fine, np.arange(2 * width, 22 / top, width)])
        k = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2).ravel()
        return k, (np.diff(edges)[:, None] * weights / 2).ravel() * (self.compliance(k) - 1)

    def compliance(self, k: np.ndarray) -> np.ndarray:
        """g(k) = k E*/2 u_z/p, 1 of a half-space."""
        return self.E_star / 2 * MODULUS * surface_displacement(self.problem, k / LENGTH)


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
        a, delta, P = self.body.pull_off(self.w / (MODULUS * LENGTH))[control]
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
    a = body.radius(0, even * deepest) if spacing == "depth" else even * body.a_max
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

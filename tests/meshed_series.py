"""Contact series as elements of any sizes report them, drawn at random, with the exact pull-off points behind them.

The radii of the nodes come first: elements alike, in geometric progression, by a power of the number, in two or three
zones, or in zones whose sizes are whole multiples of the first, as on the paper's mesh. A node touches when the edge
is the part ``ahead`` of the element behind it; from touch to touch the contact does not change, and the load is linear
in the depth. What is written is the outermost node that touches. Exact columns are those of the method "layered",
splines through the logs; nothing is taken from what reads such series.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.layered.solver import Layered

MESHES = ("even", "geometric", "power", "two zones", "three zones", "paper")
INCREMENTS = ("depth", "load", "growing")


# ---------------------------------------------------------------------- meshes
def mesh(kind: str, end: float, elements: int, rng: np.random.Generator) -> np.ndarray:
    """Radii of the nodes off the axis [m], ``elements`` of them up to about ``end`` and some more beyond it."""
    more = elements // 2 + 8
    if kind == "even":
        sizes = np.ones(elements + more)
    elif kind == "geometric":
        sizes = rng.uniform(1.01, 1.1) ** np.arange(elements + more)
    elif kind == "power":
        sizes = np.diff(np.arange(elements + more + 1) ** rng.uniform(0.8, 1.8))
    elif kind == "paper":  # small whole factors
        factors = np.cumprod(rng.choice([2.0, 3.0], 2)) if rng.random() < 0.5 else rng.choice([2.0, 3.0, 4.0], 1)
        sizes = _zones(elements, more, np.append(1.0, factors), rng)
    else:
        zones = {"two zones": 2, "three zones": 3}[kind]
        sizes = _zones(elements, more, np.cumprod(np.append(1.0, rng.uniform(1.5, 4.0, zones - 1))), rng)
    radii = np.cumsum(sizes)
    return radii * end / radii[elements - 1]


def _zones(elements: int, more: int, sizes: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Sizes of elements in zones that begin at random places, the last one open."""
    begins = np.sort(rng.uniform(0.25, 0.85, sizes.size - 1))
    places = np.append((begins * elements).astype(int), elements + more)
    return np.repeat(sizes, np.diff(places, prepend=0))


# ---------------------------------------------------------------------- bodies
class Exact:
    """A body with ``logs`` of delta_H, P_H, S, S' over log a, from a hundredth of the contact radius ``end`` to
    ``beyond`` times it."""

    beyond: ClassVar[float] = 1.3
    end: float
    logs: CubicSpline

    def columns(self, a: np.ndarray) -> np.ndarray:
        """delta_H [m], P_H [N], S [N/m], S' [N/m^2], (4, n), at contact radii [m]."""
        return np.exp(self.logs(np.log(a)).T)

    def radius(self, column: int, value: np.ndarray) -> np.ndarray:
        """Contact radii [m] at which delta_H (0) or P_H (1) has the ``value``."""
        y, low, high = np.log(value), np.log(0.01 * self.end), np.log(self.beyond * self.end)
        ends = self.logs([low, high])[:, column]
        return np.exp([brentq(lambda x, y=y_: self.logs(x)[column] - y, low, high, xtol=1e-14)
                       for y_ in np.clip(y, ends[0] + 1e-12, ends[1] - 1e-12)])  # fmt: skip

    def work(self, a: float) -> float:
        """The work of adhesion [J/m^2] with which contact is lost at radius ``a`` under control of the load."""
        near = a * np.exp(np.linspace(-1e-3, 1e-3, 3))
        _, P, S, dS = self.columns(near)
        pulled = S * np.sqrt(4 * math.pi * near / dS)
        return float((P[2] - P[0]) / (pulled[2] - pulled[0])) ** 2

    def pull_off(self, w: float) -> dict[str, tuple[float, float, float]]:
        """a [m], delta [m], P [N] where contact is lost, by what is controlled."""
        a = self.end * np.geomspace(0.011, 0.96 * self.beyond, 6000)
        delta, P, S, dS = self.columns(a)
        t = np.sqrt(4 * math.pi * w * a / dS)
        curves, found = {"displacement": delta - t, "load": P - S * t}, {}
        for control, values in curves.items():
            i = int(np.clip(np.argmin(values), 2, a.size - 3))
            near = slice(i - 2, i + 3)
            at = CubicSpline(a[near], values[near]).derivative().roots(extrapolate=False)
            place = float(at[np.argmin(np.abs(at - a[i]))]) if at.size else float(a[i])
            delta_there, P_there = (float(CubicSpline(a[near], curves[name][near])(place)) for name in curves)
            found[control] = place, delta_there, P_there
        return found


@dataclass(frozen=True, eq=False)
class Body(Exact):
    """What is pressed on what."""

    name: str
    indenter: Indenter
    specimen: Specimen
    end: float

    @property
    def problem(self) -> Problem:
        """What is told to the reader."""
        return Problem(self.indenter, self.specimen, Loading("depth", 1e-6, 10))

    @cached_property
    def logs(self) -> CubicSpline:
        radii = self.end * np.geomspace(0.01, self.beyond, 70)
        loading = Loading.given("radius", tuple(radii.tolist()))
        series = Layered()(Problem(self.indenter, self.specimen, loading)).series
        return CubicSpline(np.log(radii), np.log(np.stack([series.delta, series.P, series.S, series.dS], axis=1)))


def body(rng: np.random.Generator) -> Body:
    """A body of one of twelve kinds, at random."""
    unit, E = 10 ** rng.uniform(-6, -3.5), 10 ** rng.uniform(4, 10)

    def half_space(stiffer: float = 1.0) -> HalfSpace:
        return HalfSpace(Elastic(stiffer * E, float(rng.uniform(0.0, 0.5))))

    def layer(h: float, nu: float, stiffer: float = 1.0) -> Layer:
        return Layer(Elastic(stiffer * E, nu), h * unit)

    kind = int(rng.integers(12))
    flat_end = 0.5 * unit * float(rng.uniform(0.6, 1.5))
    R = unit * float(np.exp(rng.uniform(np.log(10), np.log(200))))
    tip: Indenter = Paraboloid(R)
    if kind == 0:
        return Body("paraboloid on half-space", tip, Specimen((), half_space()), unit)
    if kind == 1:
        return Body(
            "sphere on half-space", Sphere(unit * float(rng.uniform(2.5, 20))), Specimen((), half_space()), unit
        )
    if kind == 2:
        cone = PowerLaw(float(rng.uniform(0.1, 1.0)), 1.0)
        return Body("cone on half-space", cone, Specimen((), half_space()), unit)
    if kind == 3:
        d = float(rng.uniform(1.3, 4))
        power = PowerLaw(0.05 * unit ** (1 - d), d)
        return Body("power law on half-space", power, Specimen((), half_space()), unit)
    if kind in (4, 5, 6):
        nu = (float(rng.uniform(0.2, 0.4)), 0.45, float(rng.choice([0.49, 0.499])))[kind - 4]
        bonded = bool(rng.random() < 0.7)
        sphere = Sphere(R) if rng.random() < 0.3 else tip
        thin = Specimen((layer(1, nu),), Rigid(bonded=bonded))
        return Body(f"{'bonded' if bonded else 'sliding'} layer {nu:.3g}", sphere, thin, 4 * flat_end)
    if kind in (7, 8):
        stiffer = float(np.exp(rng.uniform(np.log(3), np.log(30))))
        coating = layer(1, float(rng.uniform(0.2, 0.45)), stiffer if kind == 7 else 1 / stiffer)
        return Body(
            "stiff coating" if kind == 7 else "soft coating", tip, Specimen((coating,), half_space()), 3 * flat_end
        )
    if kind == 9:
        two = layer(0.5, 0.4), layer(1.0, 0.3, float(rng.uniform(0.1, 8)))
        return Body("two layers", tip, Specimen(two, Rigid(bonded=True)), 3 * flat_end)
    if kind == 10:
        stack = layer(0.4, 0.3, 4), layer(0.8, 0.45)
        return Body("stack on half-space", tip, Specimen(stack, half_space(20)), 3 * flat_end)
    cone = PowerLaw(float(rng.uniform(0.05, 0.3)), 1.0)
    return Body("cone on layer", cone, Specimen((layer(1, 0.35),), Rigid(bonded=True)), 2 * flat_end)


# ---------------------------------------------------------------------- what is written
@dataclass(frozen=True, eq=False)
class MeshedSeries:
    """A series and what made it: ``columns`` (3, n), a [m], delta [m], P [N]; radii of the ``nodes`` [m]; ``factor`` of
    the loads; relative ``noise`` of displacement and load; whether the bodies are ``known`` to the reader; w [J/m^2].
    """

    body: Body
    kind: str
    nodes: np.ndarray
    ahead: float
    factor: float
    increments: str
    noise: float
    known: bool
    w: float
    columns: np.ndarray

    def write(self, folder: Path) -> Path:
        """The table."""
        path = folder / "series.csv"
        header = "a_m,delta_m,P_N"
        np.savetxt(path, self.columns.T, delimiter=",", header=header, comments="", fmt="%.10g")
        return path

    def write_nodes(self, folder: Path) -> Path:
        """The radii of the nodes, from the axis on."""
        path = folder / "nodes.csv"
        np.savetxt(path, np.append(0.0, self.nodes) * 1e6, header="r_um", comments="", fmt="%.10g")
        return path

    def true(self, control: str) -> tuple[float, float, float]:
        """a [m], delta [m], P [N] of the exact pull-off, of bodies whose moduli have the ``factor``."""
        a, delta, P = self.body.pull_off(self.w / self.factor)[control]
        return a, delta, self.factor * P


def reported(
    body: Body, nodes: np.ndarray, ahead: float, deltas: Callable[[float, float], np.ndarray] | np.ndarray
) -> np.ndarray:
    """a, delta, P (3, n) of increments at the depths ``deltas`` [m]."""
    gaps = np.diff(nodes)
    edges = nodes[:-1] + ahead * gaps  # where the edge is when a node touches
    usable = (edges > 0.0101 * body.end) & (edges < 1.29 * body.end)
    at_touch, loads = body.columns(edges[usable])[:2]
    # before the first touch the axis alone carries; the line from there
    first = np.interp(deltas, np.append(0.0, at_touch), np.append(0.0, loads))
    touched = np.searchsorted(at_touch, deltas, side="right")
    radii = np.append(0.0, nodes[:-1][usable])[touched]
    return np.stack([radii, deltas, first])[:, touched > 0]


def draw(kind: str, rng: np.random.Generator, noisy: bool, known: bool) -> MeshedSeries:
    """One series on a ``kind`` of mesh."""
    of = body(rng)
    elements = int(np.exp(rng.uniform(np.log(18), np.log(90))))
    nodes, number = mesh(kind, of.end, elements, rng), int(np.exp(rng.uniform(np.log(40), np.log(300))))
    ahead, factor = float(rng.uniform(0, 0.3)), float(rng.uniform(0.98, 1.02))
    spacing, even = str(rng.choice(INCREMENTS)), np.arange(1, number + 1) / number
    deepest, largest = of.columns(np.array([of.end]))[:2, 0]
    if spacing == "load":
        deltas = of.columns(of.radius(1, even * largest))[0]
    else:
        power = 1.0 if spacing == "depth" else float(rng.uniform(1.2, 2.2))
        deltas = deepest * even**power
    columns = reported(of, nodes, ahead, deltas)
    noise = 1e-4 if noisy else 0.0
    columns[1:] *= 1 + noise * rng.standard_normal(columns[1:].shape)
    columns[2] *= factor
    w = factor * of.work(float(rng.uniform(0.3, 0.65)) * of.end)
    return MeshedSeries(of, kind, nodes, ahead, factor, spacing, noise, known, w, columns)


def drawn(each: int, seed: int = 0, kinds: tuple[str, ...] = MESHES) -> Iterator[MeshedSeries]:
    """``each`` series on every kind of mesh: a quarter of them noisy, half with the bodies known."""
    for kind in kinds:
        rng = np.random.default_rng([seed, MESHES.index(kind)])
        for i in range(each):
            series = draw(kind, rng, i % 4 == 3, i // 4 % 2 == 0)
            while not _sound(series):
                series = draw(kind, rng, i % 4 == 3, i // 4 % 2 == 0)
            yield series


def _sound(series: MeshedSeries) -> bool:
    """Whether displacements and loads rise, and contact is lost beyond the first three radii."""
    radii = np.unique(series.columns[0])
    rising = np.all(np.diff(series.columns[1:]) > 0)
    return bool(rising and radii.size > 7 and radii[2] < series.true("displacement")[0])

"""Random contact problems over all that can go wrong: the cells of the failure map, and the problem of each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen

SHAPES = ("sphere", "paraboloid", "cone", "power", "flat", "table")
BODIES = ("half-space", "bonded", "sliding", "coating", "two layers")
SUITED = {"closed-form": BODIES[:3], "hybrid": BODIES[1:]}  # what a formula may exist for; what needs a correction
AXES = {  # (least, largest), drawn evenly in the logarithm
    "a_over_h": (1e-3, 1e2),
    "contrast": (1e-4, 1e4),
    "nodes": (3, 300),
    "increments": (3, 1000),
    "points": (4, 1000),
    "noise": (1e-6, 1e-1),
    "length_unit": (1e-12, 1e6),
    "force_unit": (1e-12, 1e6),
}


@dataclass(frozen=True)
class Cell:
    """One problem for one method; lengths in units of the top layer's thickness, E of the top layer is 1.

    ``contrast``: modulus of what lies below over that of the top; ``steepness``: slope of the profile at the largest
    contact radius, a/R of a sphere; ``nodes``: on the surface within that radius, of finite elements;
    ``increments``: of finite elements in increments, 0: nested; ``noise``: relative, on a, delta and P;
    ``length_unit`` [m], ``force_unit`` [N]: what the case is written in; ``seed``: of the noise.
    """

    method: str
    shape: str
    body: str
    nu: float
    a_over_h: float
    contrast: float
    steepness: float
    nodes: int
    increments: int
    points: int
    noise: float
    length_unit: float
    force_unit: float
    seed: int

    @property
    def problem(self) -> Problem:
        """The physics in SI units."""
        length, pressure = self.length_unit, self.force_unit / self.length_unit**2
        a = self.a_over_h * length
        return Problem(
            indenter_of(self.shape, a, self.steepness),
            specimen_of(self.body, self.nu, self.contrast, length, pressure),
            Loading("radius", a, self.points),
        )


def indenter_of(shape: str, a: float, steepness: float) -> Indenter:
    """An indenter whose slope at the radius ``a`` [m] is about ``steepness``."""
    match shape:
        case "sphere":
            return Sphere(a / steepness)
        case "paraboloid":
            return Paraboloid(a / steepness)
        case "cone":
            return PowerLaw(steepness, 1.0)
        case "power":
            return PowerLaw(steepness / (4 * a**3), 4.0)
        case "flat":
            return RoundedFlat(a / 2, a / 2 / steepness)
    r = 1.5 * a * np.linspace(0, 1, 15)
    return TableProfile(tuple(r), tuple(steepness * a * (0.4 * (r / a) ** 2 + 0.05 * (r / a) ** 4)))


def specimen_of(body: str, nu: float, contrast: float, h: float, E: float) -> Specimen:
    """A body whose top layer is ``h`` [m] thick and has the modulus ``E`` [Pa]."""
    material, below = Elastic(E, nu), Elastic(E * contrast, 0.3)
    top = Layer(material, h)
    match body:
        case "half-space":
            return Specimen((), HalfSpace(material))
        case "bonded":
            return Specimen((top,), Rigid())
        case "sliding":
            return Specimen((top,), Rigid(bonded=False))
        case "coating":
            return Specimen((top,), HalfSpace(below))
    return Specimen((top, Layer(below, 2 * h)), Rigid())


def draw(rng: np.random.Generator, method: str) -> Cell:
    """A random cell for ``method``; "slopes" is a noisy series whose slopes are to be found."""
    value = {name: _drawn(rng, *limits) for name, limits in AXES.items()}
    whole = {name: round(value[name]) for name in ("nodes", "increments", "points")}
    noisy = method == "slopes" and rng.random() > 0.3
    return Cell(
        method=method,
        shape=str(rng.choice(SHAPES)),
        body=str(rng.choice(SUITED.get(method, BODIES))),
        nu=_poisson(rng),
        a_over_h=value["a_over_h"],
        contrast=value["contrast"],
        steepness=_drawn(rng, 0.03, 0.3),
        nodes=whole["nodes"],
        increments=whole["increments"] if rng.random() < 0.5 else 0,
        points=whole["points"],
        noise=value["noise"] if noisy else 0.0,
        length_unit=value["length_unit"],
        force_unit=value["force_unit"],
        seed=int(rng.integers(2**31)),
    )


def _drawn(rng: np.random.Generator, least: float, largest: float) -> float:
    return math.exp(rng.uniform(math.log(least), math.log(largest)))


def _poisson(rng: np.random.Generator) -> float:
    """Poisson's ratio, drawn evenly from 0 to 1/2; a third of the draws near 1/2 or on it."""
    kind = rng.random()
    if kind < 0.1:
        return 0.5
    return float(0.5 - 10 ** rng.uniform(-7, -1)) if kind < 0.33 else float(rng.uniform(0, 0.5))

"""Whether stated errors of method layered bound the true ones whatever the thicknesses: random stacks."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.layered.solver import Layered

from .bounds import Bound, study
from .command import call
from .range_judge import SMALL
from .stack_judge import contact

COLUMNS = ("delta", "P", "S", "dS")
DECADES = (2.0, 8.0)  # of the largest over the least thickness
STIFF, POISSON = 5.0, 0.5  # decades of moduli over the top layer's, and the largest |nu|
CONTACT = (0.1, 16.0)  # contact radius over the thickness of the top layer
MOST, ROWS = 12, 4  # layers, and radii
ACCURACY = 2e-11  # of the judge, relative


def main(words: Sequence[str] | None = None) -> int:
    """Solve random stacks of 1 to 12 layers, the thickest 1e2 to 1e8 times the thinnest, moduli 1e-5 to 1e5 times that
    of the top layer, -0.5 <= nu <= 0.5, a third of the layers incompressible, on rigid bases and half-spaces, contact
    radii of 0.1 to 16 times the top layer, and compare every column with an ordinary differential equation for each
    wave number.

    Writes stack-bounds.csv and .json: for each column of each body the worst ratio of true to stated error. The exit
    code is 1 where more than 1 % lie beyond the stated error, any beyond three times it, or the median of stated over
    true errors is above ten (true errors above 1e-8 and three times the reference's own).
    """
    return study(words, main, judged, "stack-bounds", 300)


def judged(number: int) -> tuple[Bound, ...]:
    """Every column of the stack ``number``; none where it is refused."""
    problem = stack(np.random.default_rng(number))
    found = Layered()(problem).series
    exact = contact(problem.specimen, problem.indenter.R, found.a)  # type: ignore[attr-defined]
    bounds = []
    for name, truth in zip(COLUMNS, exact, strict=True):
        stated, off = found.errors[name] / truth, np.abs(getattr(found, name) / truth - 1)
        ratio = np.maximum(off - ACCURACY, 0) / stated
        worst = int(np.argmax(ratio))
        clear = bool(off[worst] > max(SMALL, 3 * ACCURACY))
        bounds.append(Bound(number, "layered", name, float(ratio[worst]), float(stated.max()), clear))
    return tuple(bounds)


def stack(rng: np.random.Generator) -> Problem:
    """A random stack under a paraboloid; half of the top layers are the thinnest."""
    count = int(rng.integers(1, MOST + 1))
    decades = np.append(rng.uniform(0, 1, max(count - 2, 0)), [0.0, 1.0])[-count:] * rng.uniform(*DECADES)
    decades = rng.permutation(decades)
    if rng.random() < 0.5:
        decades = np.roll(decades, -int(np.argmin(decades)))
    unit = 10 ** rng.uniform(-9, -3)
    moduli = 10 ** (rng.uniform(3, 11) + rng.uniform(-STIFF, STIFF, count + 1) * (np.arange(count + 1) > 0))
    nu = np.where(rng.random(count + 1) < 0.3, 0.5, rng.uniform(-POISSON, POISSON, count + 1))
    materials = [Elastic(float(E), float(n)) for E, n in zip(moduli, nu, strict=True)]
    thick = unit * 10.0 ** (decades - decades[0])
    layers = tuple(Layer(material, float(h)) for material, h in zip(materials, thick, strict=False))
    base = (Rigid(), Rigid(bonded=False), HalfSpace(materials[-1]))[int(rng.integers(3))]
    a = unit * np.geomspace(0.3, 1, ROWS) * np.exp(rng.uniform(np.log(CONTACT[0] / 0.3), np.log(CONTACT[1])))
    loading = Loading.given("radius", tuple(a.tolist()))
    return Problem(Paraboloid(100 * float(a[-1])), Specimen(layers, base), loading)


if __name__ == "__main__":
    sys.exit(call(main))

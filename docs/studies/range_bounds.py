"""Whether stated errors of adhesion of finite range bound the true ones and are near them, on random bodies."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from jkrcli.base.errors import JkrError
from jkrcli.methods.protocol import method_class

from .bounds import PATIENCE, Bound, study
from .bounds import body as random_body
from .command import call
from .graded_judge import graded_ranged
from .range_judge import ranged, without_table

METHODS = ("layered", "hybrid", "graded")  # of the last, wide bodies whose moduli vary over depth


def main(words: Sequence[str] | None = None) -> int:
    """Solve random bodies, a third of them cylinders, with adhesion of a random finite range, and compare
    displacements, loads, and the points at which contact is lost under load, displacement and a spring, with panels
    half as wide and twice as many nodes in k; cylinders with a kernel of finer elements. A third are layers whose
    moduli vary over depth by up to 1:20, against one differential equation per wave number; there with two springs,
    and a curve that is refused or takes more than 10 CPU seconds counts as beyond.

    Writes range-bounds.csv and .json: for each quantity of each body the worst ratio of true to stated error. The exit
    code is 1 where more than 1 % lie beyond the stated error, any beyond three times it, or the median of stated over
    true errors is above ten for a quantity and method (true errors above 1e-8 and three times the reference's own).
    """
    return study(words, main, judged, "range-bounds", 200)


def judged(number: int) -> tuple[Bound, ...]:
    """Every quantity of the body ``number`` with adhesion that pulls it off at the middle of its radii; none where it
    is refused, or too costly; a graded body that is refused counts as beyond."""
    rng, method = np.random.default_rng(number), METHODS[number % 3]
    if method == "graded":
        try:
            return tuple(Bound(number, method, *item) for item in graded_ranged(rng))
        except JkrError:
            return (Bound(number, method, "graded refused", 10.0, 1.0),)
    problem = random_body(rng, cylinders=True)
    while (problem.specimen.radius is None) != (method == "layered"):
        problem = random_body(rng, cylinders=True)
    solver = method_class(method)()
    try:
        if solver.refusal(problem) or solver.forecast(problem).seconds > PATIENCE:
            return ()
        found = ranged(problem, without_table(problem), solver(problem).series, rng)
    except JkrError:
        return ()
    return tuple(Bound(number, method, *item) for item in found)


if __name__ == "__main__":
    sys.exit(call(main))

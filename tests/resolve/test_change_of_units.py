"""The same body in other units of length and force, by every method, rule for slopes and law of adhesion: a length or a
force that a solver knows of itself, a tolerance in metres say, is seen by nothing else."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.fem.solver import FEM
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered

UNITS = [(1e-6, 3e-4), (2e4, 7e3)]
DIMENSIONS = {"a": (1, 0), "delta": (1, 0), "P": (0, 1), "S": (-1, 1), "dS": (-2, 1)}  # powers of length and force
W = 2e-3  # of force over length: pull-off within the radii of the bodies


def problem(length: float, force: float, **specimen: Any) -> jkr.Problem:
    """A paraboloid on a layer on another material, and what else the ``specimen`` has, its tension in units too."""
    modulus = force / length**2
    tension = specimen.pop("tension", 0.0) * force / length
    radius = specimen.pop("radius", None)
    layer = jkr.Layer(jkr.Elastic(3 * modulus, specimen.pop("nu", 0.3)), 0.5 * length)
    base = jkr.Rigid() if radius or tension else jkr.HalfSpace(jkr.Elastic(modulus, 0.4))
    sides = {"radius": radius * length, "side": "free"} if radius else {}
    body = jkr.Specimen((layer,), base, surface_tension=tension, **sides)
    return jkr.Problem(jkr.Paraboloid(10 * length), body, jkr.Loading("radius", 0.9 * length, 12), **specimen)


METHODS: dict[str, tuple[Any, Mapping[str, Any]]] = {
    "closed-form": (ClosedForm(), {}),
    "layered": (Layered(1e-6), {}),
    "tension": (Layered(1e-5), {"tension": 0.1}),
    "no slip": (Layered(1e-5), {"sticks": True}),
    "fem": (FEM(spacing=0.15, estimate_error=False), {}),
    "fem, incompressible": (FEM(spacing=0.15, estimate_error=False), {"nu": 0.4999}),
    "hybrid": (Hybrid(1e-4), {"radius": 3.0}),
}


@pytest.mark.parametrize("name", METHODS)
def test_every_method(name: str) -> None:
    method, specimen = METHODS[name]

    def solved(length: float, force: float) -> Any:
        body = problem(length, force, **specimen)
        if name == "closed-form":
            body = jkr.Problem(body.indenter, jkr.Specimen((), body.specimen.base), body.loading)
        return jkr.solve(body, method).series

    one, *others = (solved(*units) for units in [(1.0, 1.0), *UNITS])
    for (length, force), other in zip(UNITS, others, strict=True):
        for column, (of_length, of_force) in DIMENSIONS.items():
            if getattr(one, column) is not None:
                scaled = getattr(one, column) * length**of_length * force**of_force
                np.testing.assert_allclose(getattr(other, column), scaled, rtol=1e-7, err_msg=column)


@pytest.mark.parametrize(("slopes", "range_"), [("exact", 0.0), ("integral", 0.0), ("loocv", 0.0), ("exact", 3e-3)])
def test_adhesion(slopes: str, range_: float) -> None:
    """The curve, and pull-off under each control."""

    def found(length: float, force: float) -> Callable[[str], np.ndarray]:
        body = problem(length, force)
        body = jkr.Problem(body.indenter, body.specimen, jkr.Loading("radius", 0.9 * length, 40))
        reach = {"length": range_ * length} if range_ else {}
        analysis = jkr.transform(jkr.solve(body, Layered(1e-8)), W * force / length, slopes, **reach)
        points = [analysis.pull_off["load"], analysis.pull_off["displacement"]]
        return lambda name: np.append(getattr(analysis.curve, name), [getattr(point, name) for point in points])

    one, *others = (found(*units) for units in [(1.0, 1.0), *UNITS])
    for (length, force), other in zip(UNITS, others, strict=True):
        for name in ("a", "delta", "P"):
            of_length, of_force = DIMENSIONS[name]
            scaled = one(name) * length**of_length * force**of_force
            np.testing.assert_allclose(other(name), scaled, rtol=1e-5, atol=1e-6 * np.max(np.abs(scaled)), err_msg=name)

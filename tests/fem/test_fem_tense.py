"""Surface tension by finite elements: a membrane on the whole top, against the contact equation on ten bodies."""

from dataclasses import replace

import numpy as np
import pytest

from jkrcli.bodies.indenters import Paraboloid, RoundedFlat
from jkrcli.bodies.problem import (
    Elastic,
    Exponential,
    Graded,
    HalfSpace,
    Layer,
    Loading,
    Problem,
    Rigid,
    Specimen,
    TransverselyIsotropic,
)
from jkrcli.fem.solver import FEM
from jkrcli.methods.layered.solver import Layered

SOFT, STIFF, RUBBER = Elastic(0.84, 0.4), Elastic(10.0, 0.25), Elastic(0.75, 0.5)
GRADED = Graded(Exponential(0.84, 8.4, 1.0), 0.4)
LAMELLAR = TransverselyIsotropic(E_p=2.0, E_z=1.0, nu_p=0.3, nu_zp=0.2, G_z=0.5)
TIP = Paraboloid(1.0)
BODIES = {  # kappa = 2 Ups for E* = 1
    "half-space, strong": (Specimen((), HalfSpace(SOFT), surface_tension=1.5), TIP),
    "half-space, flat end": (Specimen((), HalfSpace(SOFT), surface_tension=0.1), RoundedFlat(0.4, 1.0)),
    "layer under a membrane": (Specimen((Layer(SOFT, 1.0),), Rigid(), surface_tension=5.0), TIP),
    "rubber": (Specimen((Layer(RUBBER, 1.0),), Rigid(), surface_tension=0.5), TIP),
    "graded": (Specimen((Layer(GRADED, 1.0),), Rigid(), surface_tension=0.15), TIP),
    "lamellar": (Specimen((Layer(LAMELLAR, 1.0),), Rigid(False), surface_tension=0.15), TIP),
    "wide cylinder": (Specimen((Layer(SOFT, 1.0),), Rigid(), 12.0, "free", surface_tension=0.15), TIP),
}


@pytest.mark.first(1)
@pytest.mark.parametrize("name", BODIES)
def test_elements_agree_within_their_stated_error(name):
    specimen, tip = BODIES[name]
    series = FEM()(Problem(tip, specimen, Loading("radius", 1.0, 10))).series
    wide = Specimen(specimen.layers, specimen.base, surface_tension=specimen.surface_tension)
    a = series.a[2:]
    exact = Layered(1e-6)(Problem(tip, wide, Loading.given("radius", tuple(a)))).series
    steep = np.gradient(exact.P, a), np.gradient(exact.delta, a)
    stated_a = series.errors["a"][2:]
    assert (np.abs(series.P[2:] - exact.P) <= series.errors["P"][2:] + steep[0] * stated_a).all()
    assert (np.abs(series.delta[2:] - exact.delta) <= steep[1] * stated_a + 1e-6 * exact.delta).all()
    for column in ("S", "dS"):
        gap = np.abs(getattr(series, column)[2:] - getattr(exact, column))
        assert (gap <= series.errors[column][2:] + np.gradient(getattr(exact, column), a) * stated_a).all()


@pytest.mark.slow
def test_a_cylinder_that_widens_gives_way_less_until_it_is_the_layer():
    """Its side is free; the membrane on its top ends there without a vertical force."""
    loading = Loading("depth", 0.3, 4)
    wide = Specimen((Layer(SOFT, 1.0),), Rigid(), surface_tension=0.5)
    bodies = [replace(wide, radius=radius, side="free") for radius in (1.5, 3.0, 12.0)]
    loads = [FEM(estimate_error=False)(Problem(TIP, body, loading)).series.P[-1] for body in bodies]
    loads.append(Layered(1e-6)(Problem(TIP, wide, loading)).series.P[-1])
    assert loads[0] < 0.9 * loads[1] < 0.95 * loads[2]
    assert loads[2] == pytest.approx(loads[3], rel=2e-4)

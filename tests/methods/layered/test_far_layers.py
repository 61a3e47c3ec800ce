"""Layers many thousand times deeper than the thinnest one: every kernel sees them, whatever the ratio."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.polynomial import legendre

from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.layered.no_slip import StuckSpectrum
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.layered.spectrum import LayeredSpectrum
from jkrcli.methods.layered.surface_tension import TenseSpectrum
from studies.stack_judge import compliances, contact

RUBBER = HalfSpace(Elastic(1e6, 0.5))


def ratio(decades: float, base: Rigid | HalfSpace) -> Specimen:
    thick, middling = Layer(Elastic(30.0, 0.5), 10**decades), Layer(Elastic(1e-3, 0.3), 10 ** (decades / 2))
    return Specimen((Layer(Elastic(1.0, 0.4), 1.0), thick, middling), base)


STACKS = [ratio(decades, base) for decades in (4.2, 8.0) for base in (Rigid(), HalfSpace(Elastic(0.1, 0.25)))]


@pytest.mark.parametrize("thick", [1e4, 1e7])
def test_ratios_once_refused_are_solved(thick: float) -> None:
    slab = Specimen((Layer(Elastic(3e6, 0.45), 1e-7), Layer(Elastic(2e6, 0.5), thick * 1e-7)), Rigid())
    stiff = Specimen((Layer(Elastic(70e9, 0.2), 1e-7), Layer(Elastic(160e9, 0.25), thick * 1e-7)), RUBBER)
    for specimen in (slab, stiff):
        series = Layered()(Problem(Paraboloid(1e-4), specimen, Loading.given("radius", (5e-7, 1e-6)))).series
        exact = contact(specimen, 1e-4, series.a)
        for name, truth in zip(("delta", "P", "S", "dS"), exact, strict=True):
            assert (np.abs(getattr(series, name) - truth) <= series.errors[name] + 1e-11 * truth).all()


@cache
def judged(specimen: Specimen) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes and weights in k by octaves over 22 decades, and the surface compliances there."""
    x, w = legendre.leggauss(16)
    edges = np.append(0.0, 24.0 * 2.0 ** np.arange(-74, 1))
    half = np.diff(edges)[:, None] / 2
    k = np.ravel(edges[:-1, None] + half * (1 + x))
    return k, np.ravel(half * w), compliances(specimen, k)


@pytest.mark.parametrize("specimen", STACKS)
def test_sliding_and_sticking_kernels_see_every_layer(specimen: Specimen) -> None:
    k, dk, (zz, zr, rr) = judged(specimen)
    nu = specimen.surface.nu
    expected = dk @ (zz / (1 - nu) - 1)
    assert LayeredSpectrum(specimen).kernel(1.0).weights.sum() == pytest.approx(expected, rel=1e-11)
    sticking = StuckSpectrum(specimen)
    own, w, _ = sticking.nodes(1.0, 24)
    found = sticking.deviations(own)
    assert w @ found[0] == pytest.approx(expected, rel=1e-11)
    # shear acts with sin(kx): its spectra with a k each
    assert w @ (own * found[1]) == pytest.approx(dk @ (k * (zr - (nu - 0.5)) / (1 - nu)), rel=2e-10)
    assert w @ (own**2 * found[2]) == pytest.approx(dk @ (k**2 * (rr / (1 - nu) - 1)), rel=2e-10)


@pytest.mark.parametrize("kappa", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("specimen", STACKS)
def test_kernels_under_surface_tension_see_every_layer(specimen: Specimen, kappa: float) -> None:
    k, dk, (zz, _, _) = judged(specimen)
    g = zz / (1 - specimen.surface.nu)
    tense = TenseSpectrum(replace(specimen, surface_tension=kappa * specimen.surface.E_star / 2))
    found = tense.kernel(1.0).weights.sum() - dk @ ((g - 1) / ((1 + kappa * g * k) * (1 + kappa * k)))
    assert abs(found) < 1e-10 * (dk @ (g / (1 + kappa * g * k)))

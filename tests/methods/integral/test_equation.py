"""The nested Fredholm solver: kernel, quadrature, identities."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from jkrcli.base.errors import SolveError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Specimen
from jkrcli.methods.integral.fredholm import Panels, Quadrature, forward_substitution, phase_allowed, solve
from jkrcli.methods.layered.contact import LayeredContact
from jkrcli.methods.layered.spectrum import LayeredSpectrum, deviation, resolved

BONDED = Specimen((Layer(Elastic(1.0, 0.4), 1.0),), Rigid())
INCOMPRESSIBLE = Specimen((Layer(Elastic(1.0, 0.5), 1.0),), Rigid())
COATED = Specimen((Layer(Elastic(1.0, 0.4), 1.0),), HalfSpace(Elastic(10.0, 0.25)))
STIFF_COATING = Specimen((Layer(Elastic(1e4, 0.3), 1.0),), HalfSpace(Elastic(1.0, 0.5)))
THREE = Specimen(
    (Layer(Elastic(1.0, 0.5), 1.0), Layer(Elastic(100.0, 0.3), 2.0), Layer(Elastic(0.1, 0.499), 3.0)), Rigid()
)
BODIES = [BONDED, INCOMPRESSIBLE, COATED, STIFF_COATING, THREE]


@pytest.mark.parametrize("n", [1, 63, 64, 65, 200])
def test_substitution_by_blocks_is_that_of_lapack(n: int) -> None:
    factor = np.linalg.cholesky(np.eye(n) + 1 / (1 + np.add.outer(np.arange(n), np.arange(n))))
    right = np.sin(np.arange(3 * n)).reshape(n, 3)
    for b in (right, right[:, 0]):
        found = forward_substitution(factor, b)
        np.testing.assert_allclose(found, solve_triangular(factor, b, lower=True), rtol=0, atol=1e-14)


@pytest.mark.parametrize("specimen", BODIES)
def test_kernel_is_its_integral(specimen: Specimen) -> None:
    """Against brute force in k: 90 panels in geometric progression with 60 nodes each."""
    spectrum = LayeredSpectrum(specimen)
    kernel = spectrum.kernel(6.0)
    edges = np.concatenate([[0.0], spectrum.bandwidth(1e-12) * 1.4 ** np.arange(-88.0, 3)])
    u, v = np.polynomial.legendre.leggauss(60)
    k = (edges[1:, None] + edges[:-1, None] + np.diff(edges)[:, None] * u).ravel() / 2
    weights = (np.diff(edges)[:, None] * v / 2).ravel() * deviation(specimen, k)
    x = np.array([0.0, 0.3, 2.5, 3.0])
    expected = (np.cos(np.outer(x, k)) * weights) @ np.cos(np.outer(x, k)).T
    rounding = 1e-14 * np.sum(np.abs(weights))  # of some thousand terms
    assert kernel.times(x, x, np.eye(x.size)) == pytest.approx(
        expected, abs=1e-12 + rounding
    )  # |g - 1| < 1e-12 is left out
    assert kernel.square(x) == pytest.approx(expected, abs=1e-12 + rounding)


def test_rough_spectrum_is_reported() -> None:
    with pytest.raises(SolveError, match="not smooth near k"):
        resolved(lambda k: np.sign(k - 1 / 3), np.array([0.0]), np.array([1.0]))


def test_phase_allowed_bounds_the_error_of_gauss_quadrature() -> None:
    for order in (3, 8, 19):
        phase = float(phase_allowed(order, 1e-8))
        x, w = np.polynomial.legendre.leggauss(order)
        error = abs(w @ np.cos(phase * x / 2) / 2 - np.sin(phase / 2) / (phase / 2))
        assert 1e-9 < error <= 1e-8  # the leading term, which bounds an alternating series


@pytest.mark.parametrize("specimen", BODIES)
@pytest.mark.parametrize("a", [0.02, 1.0, 12.0])
def test_derivatives(specimen: Specimen, a: float) -> None:
    """S' equals the central difference of S, and S equals dP/d(delta), to 1e-6: step^2 = 1e-8 relative, times O(10)."""
    contact, step = LayeredContact(Paraboloid(1000.0), specimen), 1e-4
    found, _ = contact.refined(np.array([a * (1 - step), a, a * (1 + step)]), 1e-11)
    assert (found.S[2] - found.S[0]) / (2 * step * a) == pytest.approx(found.dS[1], rel=1e-6)
    assert (found.P[2] - found.P[0]) / (found.delta[2] - found.delta[0]) == pytest.approx(found.S[1], rel=1e-6)


def test_too_coarse_quadrature_is_reported() -> None:
    spectrum = LayeredSpectrum(INCOMPRESSIBLE)
    panels = Panels.through(np.array([20.0]), Quadrature(2, 5.0, 0))
    with pytest.raises(SolveError, match="nodes"):
        solve(spectrum.kernel(40.0).square(panels.places), panels, Paraboloid(100.0), 1.0)


def test_rounding_estimate_bounds_the_scatter() -> None:
    """Quadratures in k that agree but for rounding: thin incompressible layer, where it is amplified 2e4 times."""
    contact, radii = LayeredContact(Paraboloid(1000.0), INCOMPRESSIBLE), np.array([10.0, 50.0])
    runs = [replace(contact, order=order).solved(radii, Quadrature(10, 1.0, 0)) for order in (20, 24, 32)]
    for name in ("delta", "P", "S", "dS"):
        values = np.array([getattr(run, name) for run in runs])
        scatter = np.ptp(values, axis=0) / values[0]
        assert (scatter <= runs[0].rounding).all()
    assert runs[0].rounding[1] < 1e-8  # no more than what is asked for by default

"""Closed forms: energy and derivative identities, published values, limits, change of units."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy.integrate import quad

from jkrcli import formulas
from jkrcli.bodies.indenters import FlatPunch, Paraboloid, PowerLaw, RoundedFlat, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.methods.closed_form import CLOSED_FORM_ROUND_OFF, ClosedForm

E_STAR, R = 7.0e5, 2e-3
SHAPES = [Sphere(R), Paraboloid(R), FlatPunch(R), PowerLaw(0.3, 1.0), PowerLaw(5e6, 4.0), RoundedFlat(0.1 * R, R)]


@pytest.mark.parametrize("indenter", SHAPES, ids=lambda shape: type(shape).__name__)
def test_load_is_the_integral_of_the_abel_image(indenter) -> None:
    """P_H = 2 E* int_0^a (F(a) - F(x)) dx (Sneddon), and delta_H = F(a)."""
    a = 0.4 * R
    delta, P = indenter.half_space(np.array(a), E_STAR)
    b = indenter.a0

    def integrand(t: float) -> float:  # x = b + (a - b) t^2 takes the root at the rounded edge out
        return 2 * t * (a - b) * float(indenter.abel(np.array(a)) - indenter.abel(np.array(b + (a - b) * t**2)))

    value = b * float(indenter.abel(np.array(a))) + quad(integrand, 0, 1, epsrel=1e-12)[0]
    assert float(delta) == pytest.approx(float(indenter.abel(np.array(a))), rel=1e-14)
    assert float(P) == pytest.approx(2 * E_STAR * value, rel=1e-11)


def test_sphere_tends_to_the_paraboloid_and_differs_as_published() -> None:
    a = np.array([1e-6, 1e-4]) * R
    np.testing.assert_allclose(formulas.sneddon_sphere(a, E_STAR, R), formulas.hertz(a, E_STAR, R), rtol=1e-8)
    delta = np.array([0.01, 0.02, 0.03]) * R  # exact sphere against paraboloid at equal depth: -0.10, -0.20, -0.30 %
    a = np.linspace(0.01, 0.2, 4000) * R
    at = np.interp(delta, *formulas.sneddon_sphere(a, E_STAR, R))
    hertz = 4 / 3 * E_STAR * np.sqrt(R) * delta**1.5
    np.testing.assert_allclose(100 * (at / hertz - 1), [-0.10, -0.20, -0.30], atol=0.005)


def test_sphere_series_meets_the_closed_expression() -> None:
    a = np.array([0.2 * (1 - 1e-12), 0.2]) * R
    below, above = formulas.sneddon_sphere(a, E_STAR, R)[1]
    assert below == pytest.approx(above, rel=1e-11)


def exact_rounded_flat(a: float, b: float) -> tuple[float, float]:
    """delta_H and P_H/E* for an edge radius of 1, from the exact value of the floating-point radii; a/b < 1.2."""
    with localcontext() as context:
        context.prec = 60
        s = (Decimal(a) ** 2 - Decimal(b) ** 2).sqrt()
        u = s / Decimal(b)
        difference = sum((-1) ** k * u ** (2 * k + 3) / (2 * k + 3) for k in range(200))  # tan(phi) - phi
        delta = Decimal(a) * Decimal(b) * difference
        load = 2 * Decimal(a) * delta - 2 * (s**3 / 3 - Decimal(b) * (Decimal(a) ** 2 * (u - difference)
                                                                     - Decimal(b) * s) / 2)  # fmt: skip
        return float(delta), float(load)


@pytest.mark.parametrize("beyond", [1e-13, 1e-8, 1e-6, 1e-4, 2e-3, 0.05, 0.11, 0.13])
def test_rounded_flat_is_exact_near_first_touch(beyond: float) -> None:
    b = 1e-6
    a = b * (1 + beyond)
    delta, P = formulas.rounded_flat(np.array(a), 1.0, b, 1.0)
    assert (float(delta), float(P)) == pytest.approx(exact_rounded_flat(a, b), rel=CLOSED_FORM_ROUND_OFF / 2, abs=0)


@pytest.mark.parametrize("quantity", ["depth", "load", "radius"])
@pytest.mark.parametrize("spacing", ["radius", "depth", "load", "given"])
def test_loading_reaches_what_was_asked(quantity: str, spacing: str) -> None:
    if quantity == "radius" and spacing in ("depth", "load"):
        return
    top = {"depth": 1e-2 * R, "load": 1e-2 * E_STAR * R**2, "radius": 0.1 * R}[quantity]
    loading = (
        Loading.given(quantity, (0.2 * top, 0.7 * top, top))
        if spacing == "given"
        else Loading(quantity, top, 10, spacing)
    )
    for indenter in SHAPES:
        if quantity == "radius" and indenter.a0 > 0:
            loading = Loading(quantity, 0.3 * R, 10, "radius")
        series = ClosedForm()(Problem(indenter, Specimen((), HalfSpace(Elastic(E_STAR, 0.0))), loading)).series
        end = dict(zip(("radius", "depth", "load"), series.end, strict=True))
        assert end[quantity] == pytest.approx(loading.maximum, rel=1e-12)
        if indenter.rim < np.inf and quantity != "radius":  # borne by the full end, whatever the spacing
            np.testing.assert_allclose(np.diff(series.a), series.a[0], rtol=1e-9)
            continue
        column = {"depth": series.delta, "load": series.P, "radius": series.a}[quantity]
        if loading.spacing == "given":
            np.testing.assert_allclose(column, loading.values, rtol=1e-11)
        if loading.spacing == "depth":
            np.testing.assert_allclose(np.diff(series.delta), series.delta[0], rtol=1e-9)
        if loading.spacing == "load":
            np.testing.assert_allclose(np.diff(series.P), series.P[0], rtol=1e-9)
        if loading.spacing == "radius":
            np.testing.assert_allclose(np.diff(series.a), series.a[0] - indenter.a0, rtol=1e-9)

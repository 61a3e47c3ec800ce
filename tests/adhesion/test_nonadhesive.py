"""The w-free functions: their derivatives, linear in the root of w, and w = 0 as the limit of small w."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from jkrcli.adhesion.curve import AdhesiveCurve, Nonadhesive
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz, shift
from jkrcli.many.explorer import start_work
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Series
from jkrcli.viscoelastic.course import there_and_back
from jkrcli.viscoelastic.rate import PowerRate, RateContact

E_STAR, R = 5e9 / (1 - 0.4**2), 1e-4
RADII = np.linspace(0, 0.173 * R, 61)[1:]


def noisy_hertz(seed: int, noise: float = 1e-3) -> Series:
    draw = np.random.default_rng(seed)
    a, delta, P = (v * (1 + noise * draw.standard_normal(v.size)) for v in (RADII, *hertz(RADII, E_STAR, R)))
    return Series(a, delta, P)


def test_no_adhesion_is_the_limit_of_little() -> None:
    """On noisy data too: the fitted columns, not those of the data, which lie up to 0.7 % of the load beside them."""
    series = noisy_hertz(0)
    body = Nonadhesive(series, slopes(series, "integral"))
    nothing = AdhesiveCurve(body, 0.0)
    assert np.max(np.abs(nothing.P - series.P)) > 3e-3 * series.P[-1]
    for w in (1e-8, 1e-16, 1e-24):
        little = AdhesiveCurve(body, w)
        for name in ("delta", "P"):
            ours, limit = getattr(little, name), getattr(nothing, name)
            t = shift(w, series.a, body.slopes.dS)
            apart = t if name == "delta" else body.slopes.S * t
            np.testing.assert_allclose(limit - ours, apart, rtol=1e-6, atol=1e-15 * limit[-1])
        for ours, limit in zip(little.at(series.a), nothing.at(series.a), strict=True):
            np.testing.assert_allclose(ours, limit, rtol=0, atol=1e4 * np.sqrt(w) * limit[-1] + 1e-14 * limit[-1])


def test_solved_radii_of_large_errors_leave_the_ends_of_the_series() -> None:
    """What lies beyond the solved radii would be extrapolated over decades, until exp overflows."""
    series = Series(RADII, *hertz(RADII, E_STAR, R), 2 * E_STAR * RADII, 2 * E_STAR * np.ones(60))
    body = Nonadhesive(series, slopes(series))
    few = np.arange(35, 58)
    columns = {name: getattr(body.series, name)[few] for name in ("a", "delta", "P", "S", "dS")}
    unsure = Series(**columns, errors={"delta": 10 * columns["delta"], "dS": columns["dS"]})
    curve = AdhesiveCurve(replace(body, further=Nonadhesive(unsure, slopes(unsure, "exact"))), 1.0)
    left = np.setdiff1d(curve.nonadhesive.knots.a, columns["a"])
    np.testing.assert_array_equal(left, body.a[[*range(23), 59]])
    np.testing.assert_allclose(curve.nonadhesive.parts(body.a).delta_H, body.series.delta, rtol=1e-9)


def test_the_explorer_begins_at_a_third_of_the_series() -> None:
    """37.4 J/m^2 on noisy Hertz data (37.3 without noise), shown with two digits."""
    series = noisy_hertz(3)
    body = Nonadhesive(series, slopes(series, "integral"))
    assert start_work(body) == 37.0
    assert AdhesiveCurve(body, 37.4).pull_off(0.0).a == pytest.approx(body.a[20], rel=1e-3)


GEL = Specimen((Layer(Elastic(15e3, 0.499), 0.36e-3),), Rigid(True))


def gel(radii: Array) -> Nonadhesive:
    problem = Problem(Paraboloid(6e-3), GEL, Loading.given("radius", tuple(radii.tolist())))
    series = Layered(1e-9)(problem).series
    return Nonadhesive(series, slopes(series))


def noisy() -> Nonadhesive:
    """The same as another program gave it: a, delta and P alone, with noise of a thousandth."""
    exact, rng = gel(EVEN).series, np.random.default_rng(1)
    a, delta, P = (getattr(exact, name) * (1 + 1e-3 * rng.normal(size=100)) for name in ("a", "delta", "P"))
    series = Series(a, delta, P)
    return Nonadhesive(series, slopes(series))


EVEN = np.linspace(1.2e-5, 1.2e-3, 100)  # the first gap is a factor of two wide
BODIES = {"few": lambda: gel(np.linspace(6e-5, 1.2e-3, 20)), "noisy": noisy}


@pytest.mark.parametrize("name", BODIES)
def test_the_work_of_the_device_is_stored_or_done_by_the_edge(name: str) -> None:
    contact = RateContact(BODIES[name](), PowerRate(1e-6, 0.5), 0.04, 0.035, 2e3)
    history = contact.history(there_and_back(1e-5, 1e-5, 1e-5, 1.0))
    assert history.ends == "lost"
    assert history.balance < 1e-8  # measured 1e-9, noisy 4e-9; 2e-6 to 3e-5 by cubics through the rows alone


def test_the_rows_stay_and_between_them_loads_and_slopes_are_integrals() -> None:
    body = gel(EVEN)
    for there, here in zip(body.parts(body.a), body.points, strict=True):
        assert there == pytest.approx(here, rel=1e-13)
    ends = body.a[[3, 4]]
    load = quad(lambda a: float(body.parts(np.array(a)).S * body.rates(np.array(a)).delta_H), *ends, epsrel=1e-12)[0]
    stiffness = quad(lambda a: float(body.parts(np.array(a)).dS), *ends, epsrel=1e-12)[0]
    assert load == pytest.approx(np.diff(body.parts(ends).P_H)[0], rel=1e-8)  # measured 1e-10
    assert stiffness == pytest.approx(np.diff(body.parts(ends).S)[0], rel=1e-8)


def test_columns_that_contradict_each_other_are_followed_each_for_itself() -> None:
    a = np.linspace(0.1, 1, 10)
    delta, P = hertz(a, 1.0, 1.0)
    series = Series(a, delta, P, 2 * a * (1 + 0.5 * (-1) ** np.arange(10)), np.full(10, 2.0))
    body = Nonadhesive(series, slopes(series, "exact"))
    assert body.logs.columns.x.size == 10

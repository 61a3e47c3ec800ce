"""Between its rows a series belongs to one energy: dP_H = S d(delta_H), S' the slope of S, the work of a cycle."""

import numpy as np
import pytest
from scipy.integrate import quad

from jkrcli.adhesion.curve import Nonadhesive, Rows
from jkrcli.adhesion.device_path import there_and_back
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid, RoundedFlat
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Series
from jkrcli.viscoelastic.rate import PowerRate, RateContact

GEL = Specimen((Layer(Elastic(15e3, 0.499), 0.36e-3),), Rigid(True))


def gel(radii: Array) -> Nonadhesive:
    """A thin nearly incompressible layer under a paraboloid."""
    problem = Problem(Paraboloid(6e-3), GEL, Loading.given("radius", tuple(radii.tolist())))
    series = Layered(1e-9)(problem).series
    return Nonadhesive(series, slopes(series))


def noisy(size: float) -> Nonadhesive:
    """The same as another program gave it: a, delta and P alone, with noise of relative ``size``."""
    exact, rng = gel(EVEN).series, np.random.default_rng(1)
    a, delta, P = (getattr(exact, name) * (1 + size * rng.normal(size=100)) for name in ("a", "delta", "P"))
    series = Series(a, delta, P)
    return Nonadhesive(series, slopes(series))


EVEN = np.linspace(1.2e-5, 1.2e-3, 100)  # the first gap is a factor of two wide
BODIES = {
    "even": lambda: gel(EVEN),
    "few": lambda: gel(np.linspace(6e-5, 1.2e-3, 20)),
    "logarithmic": lambda: gel(np.geomspace(5e-6, 1.2e-3, 60)),
    "measured": lambda: noisy(1e-6),
    "noisy": lambda: noisy(1e-3),
}


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


def rows_of(body: Nonadhesive) -> Rows:
    return Rows(body.a, body.series.a0, *body.points[:4], np.full((body.a.size, 2), np.nan))


def test_it_is_nearer_to_a_finer_series_than_cubics_through_the_rows() -> None:
    exact, body = gel(np.geomspace(1.2e-5, 1.2e-3, 400)), gel(EVEN)
    a = np.geomspace(1.3e-5, 1.1e-3, 300)
    columns, slopes = rows_of(body).logs
    before = *np.exp(columns(np.log(a))).T, *np.exp(slopes(np.log(a))).T
    for there, here, by_rows in zip(exact.parts(a)[:4], body.parts(a)[:4], before, strict=True):
        assert np.max(np.abs(here / there - 1)) < 1.2 * np.max(np.abs(by_rows / there - 1)) + 1e-9


def test_a_flat_end_and_other_moduli() -> None:
    punch = Problem(
        RoundedFlat(1e-4, 6e-3), GEL, Loading.given("radius", tuple(np.linspace(1.1e-4, 8e-4, 40).tolist()))
    )
    series = Layered(1e-8)(punch).series
    body = Nonadhesive(series, slopes(series))
    assert body.logs.slopes.x.size > 2 * series.a.size
    assert body.scaled(3.0).parts(series.a).P_H == pytest.approx(3 * body.parts(series.a).P_H, rel=1e-12)


def test_columns_that_contradict_each_other_are_followed_each_for_itself() -> None:
    a = np.linspace(0.1, 1, 10)
    delta, P = hertz(a, 1.0, 1.0)
    series = Series(a, delta, P, 2 * a * (1 + 0.5 * (-1) ** np.arange(10)), np.full(10, 2.0))
    body = Nonadhesive(series, slopes(series, "exact"))
    assert body.logs.columns.x.size == 10

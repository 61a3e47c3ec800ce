"""The path of a contact at a device, against closed forms of a paraboloid on a half-space, E* = R = 1."""

import math
from dataclasses import replace

import numpy as np
import pytest

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured.branches import Branches, Rest, branch, rest
from jkrcli.measured.force_curve import load_at, receding
from jkrcli.measured.forward_model import Family
from jkrcli.methods.closed_form import ClosedForm

PROBLEM = Problem(Paraboloid(1.0), Specimen((), HalfSpace(Elastic(0.75, 0.5))), Loading("radius", 0.6, 60))
SERIES = ClosedForm()(PROBLEM).series
FAMILY = Family.of(SERIES, slopes(SERIES))
FAR = ClosedForm()(replace(PROBLEM, loading=Loading("radius", 3.0, 200))).series
WIDE = Family.of(FAR, slopes(FAR))
# k, w on the way in and out, turned at z = 0.15: a and P at the turn, delta and P at the end of the rest, a, z, P at
# the fold; by formulae of Johnson, Kendall and Roberts and a punch of radius a at rest.
PATHS = [
    (math.inf, 0.001, 0.005, (0.450800261, 0.0741653959), (0.0842153802, 0.0148539483),
     (0.12522084, -0.04704078, -0.01308997)),
    (math.inf, 0.0, 0.005, (0.387298335, 0.0774596669), (0.0396943518, -0.0079827208),
     (0.12522084, -0.04704078, -0.01308997)),
    (0.5, 0.001, 0.005, (0.368373010, 0.0312055786), (0.0281218208, -0.0126065132),
     (0.18955679, -0.08158643, -0.02017445)),
]  # fmt: skip


def moving(w: float, k: float, z: np.ndarray, blunt: float) -> np.ndarray:
    """Loads at positions z of an edge that moves, and their derivatives by ln s, w and z."""
    return Branches.of([(FAMILY, 1.0, w, k)]).at(np.zeros(z.size, dtype=int), z, np.array([blunt]))


@pytest.mark.parametrize(("k", "w_in", "w_out", "turn", "end", "fold"), PATHS)
def test_a_cycle_rests_recedes_and_folds(
    k: float, w_in: float, w_out: float, turn: tuple[float, ...], end: tuple[float, ...], fold: tuple[float, ...]
) -> None:
    resting = rest(FAMILY, 1.0, math.sqrt(w_in), math.sqrt(w_out), k, 0.15)
    assert (math.exp(resting.u), resting.at(np.array([0.15]))[0][0]) == pytest.approx(turn, rel=1e-8)
    P = resting.at(np.array([resting.end]))[0][0]
    assert (resting.end - P / k, P) == pytest.approx(end, rel=1e-8)
    assert resting.released(math.sqrt(w_out), resting.end) == pytest.approx(math.sqrt(w_out), rel=1e-12)
    back = branch(FAMILY, 1.0, w_out, k)
    end_of_path = np.array([back.fold])
    lost = (back.radii(end_of_path)[0], back.fold, moving(w_out, k, end_of_path, 1e-20)[0][0])
    assert lost == pytest.approx(fold, rel=1e-6)
    assert moving(w_out, k, np.array([resting.end]), 1e-6)[0][0] == pytest.approx(P, rel=1e-6)


def test_derivatives_are_those_of_the_loads() -> None:
    z, step = np.array([0.1, 0.12, 0.14]), 1e-6

    def load(s: float = 2.0, root: float = 0.03, turn: float = 0.15) -> np.ndarray:
        return rest(FAMILY, s, root, 0.1, 0.5, turn).at(z)[0]

    _, by_s, by_q, by_z, by_root, by_turn = rest(FAMILY, 2.0, 0.03, 0.1, 0.5, 0.15).at(z)
    assert by_s == pytest.approx((load(s=2 * (1 + step)) - load(s=2 * (1 - step))) / (2 * step), rel=1e-6)
    assert by_root == pytest.approx((load(root=0.03 + step) - load(root=0.03 - step)) / (2 * step), rel=1e-6)
    assert by_turn == pytest.approx((load(turn=0.15 + step) - load(turn=0.15 - step)) / (2 * step), rel=1e-6)
    assert by_z == pytest.approx(np.diff(load())[0] / 0.02, rel=1e-9)
    assert not by_q.any()


def test_the_load_is_linear_in_w_through_0() -> None:
    """dP/dw = -2 pi a/(d delta_H/da) = -pi R at constant displacement, for w above 0 and below."""
    z = np.array([0.05, 0.1, 0.2])
    plain, _, by_w, _ = moving(0.0, math.inf, z, 1e-9)
    assert by_w == pytest.approx(-math.pi, rel=1e-4)
    for q in (-1e-5, 1e-7):
        assert (moving(q, math.inf, z, 1e-9)[0] - plain) / q == pytest.approx(-math.pi, rel=5e-3)


def test_no_number_of_a_curve_depends_on_which_others_are_beside_it() -> None:
    """Branches, edges at rest and loads of several curves of two bodies, from their folds on, to the bit those of each
    alone; 1e-6 below 0, one without a stable contact and a turn that is no number among them."""
    blunter = replace(PROBLEM, indenter=Paraboloid(2.0))
    series = ClosedForm()(blunter).series
    other = Family.of(series, slopes(series))
    asked = [
        (FAMILY, 1.0, 0.005, 0.5), (other, 1.3, 0.02, 0.1), (FAMILY, 2.0, 0.0, math.inf), (other, 0.8, 1e-4, 3.0),
        (FAMILY, 0.7, -1e-6, 2.0), (FAMILY, 1.0, 1e3, 1.0),
    ]  # fmt: skip
    both, curves = Branches.of(asked), len(asked)
    assert both.stable.tolist() == [True] * (curves - 1) + [False]
    lone = Branches.of(asked[-1:])  # where no other had a stable contact, there was no cell between two nodes
    assert lone.at(np.zeros(3, dtype=int), np.array([0.05, 0.1, 0.2]), np.array([1e-4])).shape == (4, 3)
    z, blunt = both.fold[:, None] + np.append(np.geomspace(1e-6, 0.01, 30), np.linspace(0.05, 0.2, 7)), np.full(6, 1e-4)
    loads = both.at(np.repeat(np.arange(curves), z.shape[1]), z.ravel(), blunt).reshape(4, *z.shape)
    for i, one in enumerate(asked[:-1]):
        alone = Branches.of([one])
        assert (loads[:, i] == alone.at(np.zeros(z.shape[1], dtype=int), z[i], blunt[:1])).all()
        assert both.one(i).slope.tolist() == alone.one(0).slope.tolist()
    turns = [
        (FAMILY, 1.0, 0.03, 0.1, 0.5, 0.15), (other, 1.0, 0.02, 0.1, 0.5, 0.1),
        (FAMILY, 2.0, -0.01, 0.2, math.inf, 0.3), (FAMILY, 1.0, 0.0, 0.1, 1.0, 9.0),
        (FAMILY, 1.0, 0.03, 0.1, 0.5, math.nan),
    ]  # fmt: skip
    resting, z = Rest.of(turns), np.linspace(0.05, 0.2, 7)
    assert math.isnan(resting.end[-1])
    for i, turn in enumerate(turns[:-1]):
        assert resting.some(i).at(z).tolist() == rest(*turn).at(z).tolist() == resting.at(z, np.full(7, i)).tolist()


@pytest.mark.parametrize("k", [0.5, math.inf])
def test_at_the_fold_loads_rise_as_a_root(k: float) -> None:
    """dP/d zeta, zeta = sqrt(z - fold), at the fold itself: P and z are parabolas of u there, z'' = bend."""
    back = branch(FAMILY, 1.0, 0.005, k)
    _, by_u, by_uu = (column[:, 0] for column in FAMILY.at(back.u[:1]))
    factors = np.array([1.0, -back.r, 1 / k, -back.r / k])
    rise = np.array([0.0, 0.0, 1.0, -back.r]) @ by_u
    assert factors @ by_u == pytest.approx(0.0, abs=1e-8)
    assert back.slope[0] == pytest.approx(rise * math.sqrt(2 / (factors @ by_uu)), rel=1e-6)


# ---------------------------------------------------------------------- a slow edge
# w0 = v0 = 1, the device moved back at the speed V from equilibrium at P = 0: -P_min/pi (Runge and Kutta over time).
@pytest.mark.parametrize(
    ("n", "k", "V", "expected"),
    [(0.6, math.inf, 1e-3, 1.515478), (0.6, math.inf, 0.1, 1.733807), (0.6, math.inf, 10.0, 4.196531),
     (0.6, 1.0, 1e-2, 1.556731), (0.6, 1.0, 1.0, 2.153421), (0.25, math.inf, 1e-2, 1.887319),
     (0.25, math.inf, 1.0, 2.681615)],
)  # fmt: skip
def test_pull_off_at_a_speed(n: float, k: float, V: float, expected: float) -> None:
    a = (4.5 * math.pi) ** (1 / 3)  # JKR at P = 0
    turn = a**2 - math.sqrt(2 * math.pi * a)
    held = rest(WIDE, 1.0, 1.0, 1.0, k, turn)
    assert math.exp(held.u) == pytest.approx(a, rel=1e-7)
    z, P = receding(WIDE, 1.0, 1.0, k, (V**n, n), held, turn)
    i = int(np.argmin(P))
    lowest = np.polynomial.Polynomial.fit(z[i - 2 : i + 3], P[i - 2 : i + 3], 4)
    assert -lowest(lowest.deriv().roots().real).min() / math.pi == pytest.approx(expected, rel=5e-4)
    assert (np.diff(z) > 0).all()


def test_a_very_slow_edge_is_that_of_jkr_and_a_resting_one_rests() -> None:
    advanced, w, k, turn = 0.5, 1.0, 2.0, 6.0
    held = rest(WIDE, 1.0, advanced, math.sqrt(w), k, turn)
    path = receding(WIDE, 1.0, w, k, (1e-9, 0.5), held, turn)
    jkr = branch(WIDE, 1.0, w, k)
    z = np.linspace(jkr.fold + 0.05, held.end - 0.01, 50)
    moving = Branches.of([(WIDE, 1.0, w, k)]).at(np.zeros(z.size, dtype=int), z, np.zeros(1))
    np.testing.assert_allclose(load_at(path, held, turn, z), moving[0], atol=2e-3)
    above = np.linspace(held.end, turn, 5)
    np.testing.assert_allclose(load_at(path, held, turn, above), held.at(above)[0], rtol=1e-12)
    assert load_at(path, held, turn, np.array([path[0][0] - 1.0])) == 0


def test_loads_are_smooth_where_the_edge_begins() -> None:
    """Rows that pass from rest to motion as w grows would make minima where there are none."""
    turn, z = 6.0, np.linspace(0, 6.0, 400)
    works = 1.2 + 0.1 * np.linspace(0, 1, 41)
    held = [rest(WIDE, 1.0, 1.0, math.sqrt(w), 2.0, turn) for w in works]
    loads = [load_at(receding(WIDE, 1.0, w, 2.0, (0.5, 0.4), one, turn), one, turn, z)
             for w, one in zip(works, held, strict=True)]  # fmt: skip
    bends = np.diff(np.sum(np.square(loads), axis=1), 2)
    assert np.abs(np.diff(bends)).max() < 0.05 * np.abs(bends).max()

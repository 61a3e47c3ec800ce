"""One cycle with a resting edge at the turn, against closed forms (half-space) and an independent program (layer)."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from jkrcli.adhesion.device import position
from jkrcli.adhesion.stability import Cycle, cycle, turning_radius
from jkrcli.beside.analysis import adhesive, nonadhesive, with_solved_points
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.materials import Elastic
from jkrcli.bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.closed_form.method import ClosedForm
from jkrcli.methods.layered.layered import Layered
from jkrcli.series import Solution

RIGID = math.inf
# E* = R = 1, turned at the device's position 0.15: w in and out, the turn (a, P), the end of rest (delta, P), the last
# stable state (a, position, P).
HALF_SPACE = [
    (RIGID, 0.001, 0.005, {"depth": 0.15}, (0.450800261, 0.0741653959), (0.0842153802, 0.0148539483),
     (0.12522084, -0.04704078, -0.01308997)),
    (RIGID, 0.0, 0.005, {"depth": 0.15}, (0.387298335, 0.0774596669), (0.0396943518, -0.0079827208),
     (0.12522084, -0.04704078, -0.01308997)),
    (0.5, 0.001, 0.005, {"load": 0.0312055786}, (0.368373010, 0.0312055786), (0.0281218208, -0.0126065132),
     (0.18955679, -0.08158643, -0.02017445)),
    (0.5, 0.002, 0.002, {"load": 0.0296178902}, (0.402328793, 0.0296178902), None,
     (0.13073696, -0.03867797, -0.00761877)),
]  # fmt: skip
# Bonded layer, nu = 1/2, h = E* = 1, R = 10, turned at a = 2.5.
TURN, REST = (0.24633998, 5.709077), (0.22037247, 3.9998946)
LAYER = [(RIGID, (0.27496821, -0.060460206, -0.049059105)), (20.0, (0.3054103, -0.06310452, -0.05714346))]


@cache
def half_space() -> Solution:
    specimen = Specimen((), HalfSpace(Elastic(1 - 0.3**2, 0.3)))
    return ClosedForm()(Problem(Paraboloid(1.0), specimen, radii(1e-3, 0.6)))


@cache
def layer() -> Solution:
    specimen = Specimen((Layer(Elastic(0.75, 0.5), 1.0),), Rigid(True))
    return Layered(1e-9)(Problem(Paraboloid(10.0), specimen, radii(0.05, 3.0)))


def radii(low: float, high: float) -> Loading:
    return Loading.given("radius", tuple(np.geomspace(low, high, 100).tolist()))


def cycled(solution: Solution, k: float, works: tuple[float, float], turn: dict[str, float]) -> Cycle:
    body = nonadhesive(solution)
    inwards, outwards = (with_solved_points(adhesive(solution, body, w), k).jkr for w in works)
    found = cycle(inwards, outwards, k, turning_radius(inwards, k, **turn))
    assert isinstance(found, Cycle)
    return found


def last_stable(found: Cycle) -> tuple[float, float, float]:
    point = found.contact.receding.point(found.retraction.last)
    return point.a, float(position(point.delta, point.P, found.stiffness)), point.P


@pytest.mark.parametrize(("k", "w_in", "w_out", "where", "turn", "rest", "last"), HALF_SPACE)
def test_half_space(k, w_in, w_out, where, turn, rest, last) -> None:
    found = cycled(half_space(), k, (w_in, w_out), where)
    first, end = (curve.point(found.turn) for curve in (found.contact.advancing, found.contact.receding))
    assert (first.a, first.P) == pytest.approx(turn, abs=1e-9)
    assert (end.delta, end.P) == pytest.approx(rest or (first.delta, first.P), abs=1e-9)
    assert last_stable(found) == pytest.approx(last, abs=1e-8)


@pytest.mark.parametrize(("k", "last"), LAYER)
def test_incompressible_layer(k, last) -> None:
    found = cycled(layer(), k, (0.001, 0.005), {"depth": 0.246339984878})
    first, end = (curve.point(found.turn) for curve in (found.contact.advancing, found.contact.receding))
    assert (first.a, first.delta, first.P) == pytest.approx((2.5, *TURN), abs=1e-7)
    assert (end.delta, end.P) == pytest.approx(REST, abs=1e-7)
    assert last_stable(found) == pytest.approx(last, abs=1e-7)

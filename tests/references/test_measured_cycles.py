"""One cycle with a resting edge at the turn, against closed forms (half-space) and an independent program (layer)."""

import math
from functools import cache

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Solution

RIGID = math.inf
# E* = R = 1, turned at the device's position 0.15: w in and out, the turn (a, P), the end of rest (delta, P), the last
# stable state (a, position, P).
HALF_SPACE = [
    (RIGID, 0.001, 0.005, {"to_depth": 0.15}, (0.450800261, 0.0741653959), (0.0842153802, 0.0148539483),
     (0.12522084, -0.04704078, -0.01308997)),
    (RIGID, 0.0, 0.005, {"to_depth": 0.15}, (0.387298335, 0.0774596669), (0.0396943518, -0.0079827208),
     (0.12522084, -0.04704078, -0.01308997)),
    (0.5, 0.001, 0.005, {"to_load": 0.0312055786}, (0.368373010, 0.0312055786), (0.0281218208, -0.0126065132),
     (0.18955679, -0.08158643, -0.02017445)),
    (0.5, 0.002, 0.002, {"to_load": 0.0296178902}, (0.402328793, 0.0296178902), None,
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


def cycled(solution: Solution, k: float, works: tuple[float, float], turn: dict[str, float]) -> dict[str, np.ndarray]:
    """Rows (a, delta, P, position) of the trace: the last of approach, of rest, and of retraction."""
    w_in, w_out = works
    columns = jkr.cycle(solution, w_out, w_approach=w_in, stiffness=k, **turn).columns
    table = np.stack([columns[name] for name in ("a_m", "delta_m", "P_N", "device_m")], axis=1)
    return {phase: table[columns["phase"] == phase][-1:] for phase in ("approach", "turn", "retraction")}


@pytest.mark.parametrize(("k", "w_in", "w_out", "where", "turn", "rest", "last"), HALF_SPACE)
def test_half_space(k, w_in, w_out, where, turn, rest, last) -> None:
    found = cycled(half_space(), k, (w_in, w_out), where)
    assert found["approach"][0, [0, 2]] == pytest.approx(turn, abs=1e-9)
    assert found["turn"][:, [1, 2]].ravel() == pytest.approx(rest or (), abs=1e-9)
    assert found["retraction"][0, [0, 3, 2]] == pytest.approx(last, abs=1e-8)


@pytest.mark.parametrize(("k", "last"), LAYER)
def test_incompressible_layer(k, last) -> None:
    found = cycled(layer(), k, (0.001, 0.005), {"to_depth": 0.246339984878})
    assert found["approach"][0, :3] == pytest.approx((2.5, *TURN), abs=1e-7)
    assert found["turn"][0, [1, 2]] == pytest.approx(REST, abs=1e-7)
    assert found["retraction"][0, [0, 3, 2]] == pytest.approx(last, abs=1e-7)

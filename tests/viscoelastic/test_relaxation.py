"""Contact of bodies that relax: published values, closed forms, identities, and the unilateral problem stepped."""

import math
from functools import cache

import numpy as np
import pytest
from relaxing_rings import stepped

import jkrcli as jkr
from jkrcli.adhesion.device_path import Program
from jkrcli.base.errors import InputError
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Indenter, PowerRelaxation, Prony, Relaxation, StandardSolid
from jkrcli.resolve.analysis import nonadhesive
from jkrcli.viscoelastic.relaxation import Depths, Drive, RelaxedPath, RelaxingContact, depth_controlled, moments

SOLID = StandardSolid(0.25, 1.0)
POWER = PowerRelaxation(1.0, 0.3)
TRIANGLE = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0])
SPHERE, CONE = jkr.Paraboloid(1.0), jkr.PowerLaw(1.0, 1.0)


@cache
def depths(layer: float | None = None, indenter: Indenter = SPHERE) -> Depths:
    """Of E* = 1 and R = 1: on a half-space, or a bonded layer of this thickness and nu = 1/2."""
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
    if layer is not None:
        specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), layer),), jkr.Rigid(True))
    return Depths(nonadhesive(jkr.solve(jkr.Problem(indenter, specimen, jkr.Loading("depth", 1.5)))))


def path(
    law: Relaxation, t: Array, x: Array, body: Depths | None = None, stiffness: float = math.inf
) -> RelaxedPath:  # fmt: skip
    body, modes = body or depths(), law.modes(float(t[-1]))
    return depth_controlled(body, modes, t, x) if math.isinf(stiffness) else Drive(body, modes, stiffness, t, x).path()


def test_values_of_a_half_space() -> None:
    found = path(SOLID, *TRIANGLE)
    a, _, P = found.states(np.array([0.5, 1.0, 1.25, 1.5]))
    np.testing.assert_allclose(P, [0.40976766, 1.02621407, 0.45146169, 0.08167490], rtol=0, atol=1e-8)  # rounded
    assert found.lost == pytest.approx(1.62384979, abs=1e-8)
    np.testing.assert_allclose(a[:2], np.sqrt([0.5, 1.0]), rtol=1e-10)
    a, _, P = path(SOLID, TRIANGLE[0], 0.436692733 * TRIANGLE[1], depths(0.8)).states(np.array([0.5, 1, 1.25, 1.5]))
    np.testing.assert_allclose(P, [0.30357556, 1.19977308, 0.40694176, 0.04468622], rtol=0, atol=2e-8)
    assert a[1] == pytest.approx(0.9, rel=1e-8)
    body, modes = depths().body, StandardSolid(0.25, 1e-3).modes(1.0)
    t, x, rows = 1e-3 * TRIANGLE[0], TRIANGLE[1], np.array([0.5, 1.25])
    P = depth_controlled(Depths(body.scaled(1e6)), modes, t, x).states(1e-3 * rows)[2]
    np.testing.assert_allclose(P, 1e6 * path(SOLID, *TRIANGLE).states(rows)[2], rtol=1e-10)


@pytest.mark.first(1)
@pytest.mark.parametrize("stiffness", [math.inf, 1.0, 0.05, 0.0])
@pytest.mark.parametrize("body", [(None, SPHERE), (0.5, CONE)], ids=["half-space", "cone on a layer"])
def test_the_unilateral_problem_stepped_through_time(stiffness: float, body: tuple[float | None, Indenter]) -> None:
    law, T = Prony((0.4, 0.3), (0.2, 3.0)), np.array([0.5, 1.0, 2.2, 3.0, 3.2, 3.4])
    t, x = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), 0.5 * np.array([0.0, 0.7, 1.0, 1.0, 0.0])
    times = np.linspace(0, 4, 2001)
    modes = 0.3, law.weights, [1 / time for time in law.times]
    deep = depths(*body)
    contact, tip, P = stepped(deep.loads, 1.4, modes, lambda s: np.interp(s, t, x), times, stiffness)
    found = path(law, t, x, deep, stiffness)
    rows, (a, delta, load) = np.round(T / 4 * 2000).astype(int), found.states(T)
    np.testing.assert_allclose(load, P[rows], rtol=0, atol=1e-5 * P.max())  # 4e-6, of the steps and rings
    np.testing.assert_allclose(delta, tip[rows], rtol=0, atol=1e-5 * tip.max())
    np.testing.assert_allclose(a, deep.radii(contact[rows]), rtol=5e-4)  # 2.6e-4, a part of a ring
    lost = times[np.flatnonzero((P <= 0) & (times > 3))[0]]
    assert found.lost == pytest.approx(lost, abs=0.005)  # two steps and more where P goes with a zero slope


def test_a_power_law_over_its_closed_forms() -> None:
    t, x = np.linspace(0.05, 1, 9), POWER.exponent
    _, _, P = path(POWER, *TRIANGLE).states(t)
    beta = math.gamma(1 - x) * math.gamma(1.5) / math.gamma(2.5 - x)
    np.testing.assert_allclose(P, 4 / 3 * 1.5 * beta * t ** (1.5 - x), rtol=1e-8)
    back = np.array([1.05, 1.2, 1.3])
    t1 = back - 2 ** (1 / (1 - x)) * (back - 1)
    np.testing.assert_allclose(path(POWER, *TRIANGLE).states(back)[0], np.sqrt(t1), rtol=1e-8)
    lost = path(POWER, *TRIANGLE).lost
    assert lost == pytest.approx(1 / (1 - 2 ** (-1 / (1 - x))), rel=1e-8)


@pytest.mark.parametrize("law", [SOLID, POWER, StandardSolid(0.0, 0.5), Prony((0.3, 0.2, 0.5), (0.1, 1.0, 20.0))])
def test_a_held_depth_shows_the_law(law: Relaxation) -> None:
    t = np.array([1e-3, 0.1, 1.0, 10.0])
    a, delta, P = path(law, np.array([0.0, 0.0, 10.0]), np.array([0.0, 0.5, 0.5])).states(t)
    np.testing.assert_allclose(P / depths().loads(delta), law.modes(10.0)(t), rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(a, math.sqrt(0.5), rtol=1e-10)


def test_a_held_load_creeps_and_a_step_is_remembered() -> None:
    t, held = np.array([0.01, 0.1, 1.0, 5.0]), (np.array([0.0, 0.0, 5.0]), np.array([0.0, 0.3, 0.3]))
    _, delta, P = path(SOLID, *held, stiffness=0.0).states(t)
    np.testing.assert_allclose(depths().loads(delta), 0.3 * (4 - 3 * np.exp(-t / 4)), rtol=1e-10)
    np.testing.assert_allclose(P, 0.3, rtol=1e-10)
    _, delta, _ = path(POWER, *held, stiffness=0.0).states(t)
    creep = t**0.3 / math.gamma(0.7) / math.gamma(1.3)
    np.testing.assert_allclose(depths().loads(delta), 0.3 * creep, rtol=1e-7)
    # After a step and a long wait the way back is that of a relaxed body: at every moment Hertz at the depth.
    t, x = np.array([0.0, 0.0, 50.0, 50.001]), np.array([0.0, 0.5, 0.5, 0.0])
    rows = np.array([50.0002, 50.0005])
    a, _, P = path(SOLID, t, x).states(rows)
    # instant unloading: r d(delta) over the retraction is that of modulus 1, over the step of 0.25
    depth = 0.5 - (rows - 50) / 0.001 * 0.5 / 0.25
    np.testing.assert_allclose(a[:1] ** 2, depth[:1], rtol=1e-3)
    np.testing.assert_allclose(P[:1], 0.25 * 4 / 3 * depth[:1] ** 1.5, rtol=2e-3)
    assert a[1] == P[1] == 0


def test_a_stiff_spring_holds_the_depth() -> None:
    rows = np.array([0.3, 1.0, 1.4])
    stiff, rigid = path(SOLID, *TRIANGLE, stiffness=1e7), path(SOLID, *TRIANGLE)
    np.testing.assert_allclose(stiff.states(rows)[2], rigid.states(rows)[2], atol=1e-6)  # 1.6e-7, that is P/k
    assert stiff.lost == pytest.approx(rigid.lost, abs=1e-6)


def test_a_soft_spring_lets_go_as_a_load_does() -> None:
    fine, coarse = (Drive(depths(), SOLID.modes(2.0), 0.05, TRIANGLE[0], 10 * TRIANGLE[1], r) for r in (1.3, 1.3**3))
    one, other = fine.path(), coarse.path()
    assert one.lost == pytest.approx(1.97099976, abs=1e-8)
    assert other.lost == pytest.approx(one.lost, abs=1e-8)  # 5e-10
    t = np.append(np.linspace(0.1, 1.9, 7), 1.97)
    np.testing.assert_allclose(other.states(t)[2], one.states(t)[2], rtol=0, atol=1e-6)


@pytest.mark.first(2)
@pytest.mark.parametrize(("law", "t", "x"), [
    (SOLID, [0.0, 0.4, 5.6, 6.0], [0.0, 1.5, 1.5, 0.0]),
    (SOLID, [0.0, 0.4, 5.6, 7.0, 8.0], [0.0, 1.5, 1.5, 1.49, 0.0]),
    (POWER, [0.0, 0.2, 0.4, 5.6, 6.0], [0.0, 0.2, 1.5, 1.5, 0.0]),
    (StandardSolid(0.05, 1.0), [0.0, 0.1, 3.0, 3.1, 4.0], [0.0, 0.1, 0.1, 1.5, 0.0]),
])  # fmt: skip
def test_a_spring_lets_go_however_its_steps_lie(law: Relaxation, t: list[float], x: list[float]) -> None:
    """A step that ended just before the loss of contact left 1e-4."""
    body, program = depths(0.5), (np.array(t), np.array(x))
    found = path(law, *program, body, 1.0)
    finer = Drive(body, law.modes(t[-1]), 1.0, *program, ratio=1.2).path()
    at = np.linspace(0.0, 0.9999 * finer.lost, 2000)[1:]
    for one, other in zip(found.states(at), finer.states(at), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=5e-7 * np.max(other))
    assert found.lost == pytest.approx(finer.lost, rel=1e-8)


@pytest.mark.parametrize("stiffness", [math.inf, 1.0])
def test_the_energy_lost_between_a_quick_press_and_a_quick_retraction(stiffness: float) -> None:
    """Pressed at once, held until all is relaxed, retracted at once: 8/15 d^(5/2) less its recovered square of r."""
    body = depths().body
    x = 1.0 if math.isinf(stiffness) else 1.5
    t = np.array([0.0, 1e-6, 80.0, 80.0 + 1e-6])
    found = RelaxingContact(body, SOLID, stiffness).history(Program(t, np.array([0.0, x, x, 0.0])))
    energy = found.energy_lost
    if math.isinf(stiffness):
        assert energy == pytest.approx(8 / 15 * (1 - 0.25**2), rel=1e-5)  # of the first relaxation within 1e-6
    at = np.unique(np.concatenate([t[1] * np.linspace(0, 1, 4000), np.geomspace(t[1], t[2], 4000),
                                   t[2] + (found.path.lost - t[2]) * np.linspace(0, 1, 4000)]))  # fmt: skip
    _, delta, P = found.states(at)
    assert energy == pytest.approx(np.trapezoid(P, delta), rel=1e-6)


@pytest.mark.parametrize("stiffness", [math.inf, 1.0])
def test_a_second_loading_is_refused(stiffness: float) -> None:
    t, x = np.array([0.0, 1.0, 1.3, 3.0]), np.array([0.0, 1.0, 0.6, 0.6])
    with pytest.raises(InputError, match="is loaded again before its dent recovers, which is not solved: retract"):
        path(SOLID, t, x, stiffness=stiffness).states(np.linspace(0.1, 2.9, 50))
    with pytest.raises(InputError, match=r"at t = 3 s the contact is loaded again"):  # after it was lost
        path(SOLID, np.arange(4.0), np.array([0.0, 1.0, 0.0, 0.9]))


@pytest.mark.parametrize("stiffness", [math.inf, 1.0, 0.0])
def test_a_depth_beyond_the_series_is_refused(stiffness: float) -> None:
    with pytest.raises(InputError, match=r"beyond the largest depth of the solution, 1.5 m: reverse before, or incre"):
        RelaxingContact(depths().body, SOLID, stiffness).history(Program(TRIANGLE[0], 4 * TRIANGLE[1]))


def test_the_energy_lost_and_moments() -> None:
    x, y = np.array([0.0, 1e-6, 0.5, 1.99, 2.01, 30.0]), (np.arange(200_000) + 0.5) / 200_000
    for j, found in enumerate(moments(x, 6)):
        np.testing.assert_allclose(found, [np.mean(np.exp(-z * (1 - y)) * y**j) for z in x], rtol=1e-8)
    held = RelaxingContact(depths().body, SOLID).history(Program(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 1.0])))
    assert str(held.energy_lost) == "contact is not lost"


@pytest.mark.parametrize("exponent", [0.02, 0.5, 0.95])
def test_exponentials_stand_for_a_power_law(exponent: float) -> None:
    t = np.geomspace(1e-7, 30, 40)
    np.testing.assert_allclose(PowerRelaxation(2.0, exponent).modes(30.0)(t), (t / 2) ** -exponent, rtol=5e-10)


@pytest.mark.parametrize(("law", "line"), [
    (lambda: Prony((0.6, 0.6), (1.0, 2.0)), r"the weights must be > 0, their sum at most 1, got \[0.6, 0.6\]"),
    (lambda: Prony((0.6,), (1.0, 2.0)), "needs as many times as weights, got 1 weights, 2 times"),
    (lambda: StandardSolid(1.5, 1.0), r"relaxation.ratio: must be >= 0 and <= 1, got 1.5"),
    (lambda: PowerRelaxation(1.0, 1.0), r"relaxation.exponent: must be > 0 and < 1, got 1"),
])  # fmt: skip
def test_laws_that_are_none(law, line: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=line):
        law()


def test_a_solid_that_keeps_all_of_its_modulus_is_elastic() -> None:
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
    solved = jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), specimen, jkr.Loading("depth", 1.1)))
    history = jkr.cycle_relaxing(solved, StandardSolid(1.0, 0.3), 1.0, to_depth=1.0)
    t = np.array([0.3, 0.7, 1.0, 1.4, 1.9])
    _, delta, P = history.states(t)
    np.testing.assert_allclose(delta, [0.3, 0.7, 1.0, 0.6, 0.1], rtol=1e-9)
    np.testing.assert_allclose(P, 4 / 3 * delta**1.5, rtol=1e-7)
    limits = [jkr.cycle_relaxing(solved, StandardSolid(1.0, time), w=1e-3, stress=0.1, speed=1.0).limits
              for time in (0.3, 9.0)]  # fmt: skip
    assert limits[0]["very fast"].P == limits[0]["very slow"].P == limits[1]["very fast"].P

"""Speed against accuracy: the reference, the measurements, the front, and the study run by make."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from conftest import CASES

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.many.studies import process_cost
from jkrcli.methods.layered.solver import Layered
from studies.chart_points import beside_front, front, read_peers
from studies.chart_reference import reference_of

LAYER = Problem(
    Paraboloid(1e-3), Specimen((Layer(Elastic(5e9, 0.4), 1e-6),), Rigid()), Loading("radius", 1e-5, points=60)
)
HERTZ = Problem(Paraboloid(1e-4), Specimen((), HalfSpace(Elastic(5e9, 0.4))), Loading("depth", 3e-6, points=60))


def test_reference_on_a_half_space_is_the_closed_form() -> None:
    reference = reference_of(HERTZ, 50.0)
    assert reference.name == "closed form"
    delta = np.linspace(1e-7, 3e-6, 50)
    load = 4 / 3 * HERTZ.E_star * np.sqrt(1e-4) * delta**1.5
    # a cubic in logarithms through 400 points: fourth order in a spacing of 1/120 of the radius
    assert reference.load_error(delta, load) < 1e-9
    assert reference.load_error(delta, 1.01 * load) == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize("problem", [HERTZ, LAYER, replace(LAYER, indenter=Sphere(1e-3))])
def test_errors_of_an_exact_series_vanish_and_those_of_a_scaled_one_are_known(problem: Problem) -> None:
    """Moduli larger by a factor s: P at equal depth is s times as large, the pull-off force of Hertz the same."""
    w = 50.0 if problem is HERTZ else 10.0
    series = Layered(1e-9)(problem).series
    reference = reference_of(problem, w)
    errors = reference.errors(transform(series, slopes(series, "exact"), w))
    assert errors.load < 1e-8
    assert errors.curve < 1e-6  # of the interpolated reference
    assert errors.pull_off < 1e-6
    stiffer = series.scaled(1.02)
    scaled = reference.errors(transform(stiffer, slopes(stiffer, "exact"), w))
    assert scaled.load == pytest.approx(0.02, rel=1e-5)
    assert scaled.curve > 1e-3
    if problem is HERTZ:
        assert scaled.pull_off == pytest.approx(0.0, abs=1e-6)


def test_cost_of_a_process_is_its_own() -> None:
    """A tenth of a second of work and 200 MB; the memory of this process is not counted in."""
    work = "import time, sys\nblock = b'x' * 200_000_000\nwhile time.process_time() < 0.3: pass"
    cost = process_cost([sys.executable, "-S", "-c", work])
    assert 0.27 <= cost.cpu_s < 0.8  # of an ended process, counted in ticks of 10 ms
    assert cost.wall_s >= 0.3
    assert 190 < cost.memory_mib < 260
    idle = process_cost([sys.executable, "-S", "-c", ""])
    assert idle.memory_mib < 50


def test_front_holds_what_nothing_beats() -> None:
    points = [(1.0, 1e-2), (2.0, 1e-3), (3.0, 1e-3), (4.0, 1e-5), (5.0, 1e-4)]
    assert front(points) == [0, 1, 3]
    assert beside_front((2.9, 1e-3), points)
    assert not beside_front((3.1, 1e-3), points)  # 1e-3 can be had in 2.0, quicker by more than a half


def test_the_stored_peers_can_be_read() -> None:
    peers = read_peers(CASES.parent / "docs" / "peers" / "timings.json", 1.0)
    assert {peer.body for peer in peers} == {"halfspace", "thin-layer"}
    assert all(peer.whole.cpu_s > 0 and peer.errors.load > 0 for peer in peers)

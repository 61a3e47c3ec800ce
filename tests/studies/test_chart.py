"""Speed against accuracy: the reference, the measurements, the front, and the study run by make."""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.models import load_case, method_of
from jkrcli.many.studies import process_cost
from jkrcli.methods.layered.solver import Layered
from studies.chart_points import DEFAULT, SETTINGS, beside_front, front, read_peers, settings_of
from studies.chart_reference import reference_of

LAYER = Problem(
    Paraboloid(1e-3), Specimen((Layer(Elastic(5e9, 0.4), 1e-6),), Rigid()), Loading("radius", 1e-5, points=60)
)
HERTZ = Problem(Paraboloid(1e-4), Specimen((), HalfSpace(Elastic(5e9, 0.4))), Loading("depth", 3e-6, points=60))


# ---------------------------------------------------------------------- the exact solution
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


# ---------------------------------------------------------------------- measuring
def test_cost_of_a_process_is_its_own() -> None:
    """A tenth of a second of work and 200 MB; the memory of this process is not counted in."""
    work = "import time, sys\nblock = b'x' * 200_000_000\nwhile time.process_time() < 0.3: pass"
    cost = process_cost([sys.executable, "-S", "-c", work])
    assert 0.27 <= cost.cpu_s < 0.8  # of an ended process, counted in ticks of 10 ms
    assert cost.wall_s >= 0.3
    assert 190 < cost.memory_mib < 260
    idle = process_cost([sys.executable, "-S", "-c", ""])
    assert idle.memory_mib < 50


# ---------------------------------------------------------------------- the front
def test_front_holds_what_nothing_beats() -> None:
    points = [(1.0, 1e-2), (2.0, 1e-3), (3.0, 1e-3), (4.0, 1e-5), (5.0, 1e-4)]
    assert front(points) == [0, 1, 3]
    assert beside_front((2.9, 1e-3), points)
    assert not beside_front((3.1, 1e-3), points)  # 1e-3 can be had in 2.0, quicker by more than a half


def test_every_setting_is_a_valid_case_and_fits_its_method() -> None:
    model = load_case(CASES / "thin-layer.toml").model
    settings = settings_of(model, ())
    assert {setting.method for setting in settings} >= {"closed-form", "layered", "fem"}
    for setting in settings:
        assert setting.of(model).method == setting.method
        method_of(setting.of(model), setting.method)
    assert [s.words for s in settings if s.words.startswith("the case")] == ["the case's own mesh"]
    assert all(setting.method == "layered" for setting in settings_of(model, ("layered",)))
    assert len({(setting.method, setting.words) for setting in SETTINGS}) == len(SETTINGS)


# ---------------------------------------------------------------------- peers
def stored(tmp_path: Path, **changes: object) -> Path:
    run = {"peer": "Slow", "version": "1", "body": "thin-layer", "settings": "coarse", "unknowns": 9, "cpu_s": 60.0,
           "wall_s": 70.0, "memory_mib": 100.0, "after_imports_cpu_s": None,
           "errors": {"load": 1e-3, "curve": None, "pull_off": 0.02}}  # fmt: skip
    data = {"format": "jkr-peers", "version": 1, "yardstick_cpu_s": [2.0, 2.5], "runs": [run]} | changes
    path = tmp_path / "peers.json"
    path.write_text(json.dumps(data))
    return path


def test_peers_are_scaled_by_the_yardstick(tmp_path: Path) -> None:
    """On a machine twice as fast as then (yardstick 1 instead of 2 s) the peer would need half of its time."""
    (peer,) = read_peers(stored(tmp_path), 1.0)
    assert peer.whole.cpu_s == 30.0
    assert peer.after_imports_cpu_s is None


def test_the_stored_peers_can_be_read() -> None:
    peers = read_peers(CASES.parent / "docs" / "peers" / "timings.json", 1.0)
    assert {peer.body for peer in peers} == {"halfspace", "thin-layer"}
    assert all(peer.whole.cpu_s > 0 and peer.errors.load > 0 for peer in peers)


# ---------------------------------------------------------------------- the study run by make
@pytest.mark.slow
def test_the_study_writes_table_json_and_picture(study, tmp_path: Path, monkeypatch) -> None:
    two = [
        setting for setting in SETTINGS if setting.method == "layered" and setting.words in (DEFAULT, "tolerance 1e-2")
    ]
    monkeypatch.setattr("studies.chart_points.SETTINGS", two)
    peers = stored(tmp_path)
    outcome = study("chart", CASES / "thin-layer.toml", "--methods", "layered", "--repeat", 1, "--peers", peers,
                  "-o", "out")  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert "against   layered, tolerance 1e-10" in outcome.out
    assert "Slow 1, coarse" in outcome.out
    data = json.loads(Path("out/thin-layer-chart.json").read_text())
    assert data["auto"] == {"method": "layered", "beside_front": True}
    rows = list(csv.DictReader(Path("out/thin-layer-chart.csv").read_text().splitlines()))
    assert len(rows) == len(data["points"]) == 3 * 2  # exact, integral and loocv of two tolerances
    default = [row for row in rows if row["setting"] == DEFAULT and row["slopes"] == "exact"]
    assert float(default[0]["P_error"]) < 1e-8
    assert float(default[0]["whole_cpu_s"]) > float(default[0]["after_imports_cpu_s"]) > 0
    assert Path("out/thin-layer-chart.png").read_bytes()[:4] == b"\x89PNG"

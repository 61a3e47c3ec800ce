"""Fits of cycles that adhere on bodies that relax, to records of another discretisation (``adhesive_records.py``)."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import described_body
import numpy as np
import pytest
from adhesive_records import clean, record

import jkrcli as jkr
from jkrcli.adhesion.device_path import Program
from jkrcli.adhesion.finite_range import RangeRequest
from jkrcli.base.errors import InputError
from jkrcli.bodies.problem import StandardSolid
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic.adhesive_march import AdhesiveMarch, ElasticLimits, Secants
from jkrcli.viscoelastic.relaxation_fit import RelaxationFit, TimedRecord, relaxation_fit, relaxation_settings

W, STRESS, MODES = 0.01, 0.16, (0.3, (0.7,), (1.0,))
CORNERS = ((0.0, -0.15), (0.5, 0.1), (1.5, 0.1), (2.5, -0.4))
CASE = described_body.UNIT.format(depth=0.15)


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(jkr.parse_case(CASE))


def layered(h: float = 0.5) -> FittedBody:
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), h),), jkr.Rigid(True))
    return body_of(jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), specimen, jkr.Loading("depth", 0.15))))


def off(fit: RelaxationFit, **true: float) -> float:
    """The largest distance from the truth in standard errors."""
    return max(abs(fit.value(name) - value) / (fit.estimate(name).error or 0) for name, value in true.items())


def test_the_march_of_a_fit_is_that_of_another_discretisation(body: FittedBody) -> None:
    """Coarse as it is while a minimum is sought, for E* = 2 by its scale: of the pull-off force 0.4 %."""
    t, delta, P = clean(W, STRESS, MODES, CORNERS, steps=150)
    march, (ends, x) = AdhesiveMarch.of(body, 0.0), np.array(CORNERS).T
    values = {"modulus": 2.0, "w": 2 * W, "stress": 2 * STRESS}
    a, found, load, jumps = march.states(StandardSolid(0.3, 1.0), values, np.inf, Program(ends, x), t)
    assert found == pytest.approx(delta)
    apart = np.abs(t[:, None] - jumps).min(axis=1) > 0.03
    assert np.abs(load - P)[apart].max() < 0.01 * -P.min()
    assert (a[P != 0] > 0).mean() > 0.98
    assert jumps.size == 2


def test_works_behind_a_force_on_a_half_space(body: FittedBody) -> None:
    """JKR: 1.5 pi w R, whatever the modulus."""
    elastic = ElasticLimits(body.to_depth(0.4).nonadhesive)
    assert elastic.work(3.0, 1.5 * np.pi * 1e-3) == pytest.approx(1e-3, rel=0.01)


def test_secants_are_derivatives_while_they_foretell() -> None:
    """Of a plane they are kept; of what bends too much they are renewed."""
    calls = []

    def bent(x: np.ndarray) -> np.ndarray:
        calls.append(x)
        return np.array([3 * x[0] + x[1], x[1] ** 2, x[0]]) * 1e3

    secants, steps = Secants(), np.full(2, 1e-4)
    for x, known, more in (([1.0, 1.0], 2.0, 2), ([1.0, 1.001], 2.001, 0), ([1.0, 9.0], 18.0, 2)):
        before = len(calls)
        J = secants.rates(bent, np.array(x), bent(np.array(x)), steps, 2)
        assert len(calls) - before - 1 == more
        np.testing.assert_allclose(J, 1e3 * np.array([[3, 1], [0, known], [1, 0]]), rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize(
    ("fix", "free", "law", "line"),
    [
        ([("stress", "2 Pa")], [], "sls", "stress: of a relaxing body it goes with w"),
        ([], ["w"], "power", "a power law has no instantaneous modulus"),
        ([("stress", "2 Pa"), ("range", "1 um")], ["w"], "sls", "stress and range are one parameter"),
        ([], ["w", "streess"], "sls", 'unknown parameter "streess", did you mean "stress"'),
    ],
)
def test_what_is_not_asked_so(fix: list, free: list, law: str, line: str) -> None:
    with pytest.raises(InputError, match=line):
        relaxation_settings(law, fix, free)


def test_the_range_of_the_case_is_known() -> None:
    settings = relaxation_settings("sls", free=["w"], ranged=RangeRequest(None, 1e-9))
    assert settings.fixed == {"range": 1e-9}
    assert relaxation_settings("sls", free=["w", "stress"], ranged=RangeRequest(None, 1e-9)).fixed == {}


def test_a_record_without_adhesion_is_refused(body: FittedBody) -> None:
    t = np.linspace(0, 3, 120)
    delta = np.interp(t, [0, 1, 2, 3], [-0.1, 0.1, 0.1, -0.1])
    P = np.maximum(delta, 0) ** 1.5 + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    with pytest.raises(InputError, match="w: no adhesion shows"):
        relaxation_fit(body, Curve("made", t=t, delta=delta, P=P), relaxation_settings("sls", free=["w"]))


def test_a_prescribed_load_is_refused(body: FittedBody) -> None:
    t = np.linspace(0, 3, 120)
    P = np.interp(t, [0, 1, 3], [0, 0.05, -0.02])
    delta = 0.1 * np.sin(t) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    with pytest.raises(InputError, match="here the load is prescribed"):
        relaxation_fit(body, Curve("made", t=t, delta=delta, P=P), relaxation_settings("sls", free=["w"]))


@pytest.mark.parametrize(("size", "spread", "uneven"), [(20.0, 0.003, 0.0), (4.0, 0.03, 0.0), (20.0, 0.006, 0.4)])
def test_a_jump_is_where_the_rows_show_it(size: float, spread: float, uneven: float) -> None:
    """Of 20 times the noise between two rows, within which its time is even; of four times it, up to some rows beside.
    The model jumps three rows later; its branches are as steep as a fifth of the noise a row."""
    rng = np.random.default_rng(5)
    t = np.linspace(0, 1, 101) + uneven * 0.01 * np.append(rng.uniform(-1, 1, 100), 0.0)
    beside = int(np.searchsorted(t, 0.503))

    def loads(jump: float) -> np.ndarray:
        return np.where(t < jump, 0.0, 20 * (t - jump) - size)

    offs = []
    for _ in range(40):
        noisy = loads(0.503) + rng.standard_normal(t.size)
        one = TimedRecord(
            Curve("made", t=t, delta=t, P=noisy), t, t, noisy, "displacement", np.inf, (t[[0, -1]], t[[0, -1]]),
            (1.0, 1.0), (1.0, 1.0),
        )  # fmt: skip
        found = one.with_jumps(np.array([0.533]), loads(0.533))
        ((place, error),) = found.jumps
        offs.append((place - 0.503) / error)
        assert np.diff(t).min() / 12**0.5 < 1.001 * error < spread
        assert found.left_out is not None
        assert found.left_out[[beside - 1, beside]].all()
        assert found.left_out.sum() < 12
    assert np.mean(np.square(offs)) < 2.0


@pytest.mark.slow
def test_a_cycle_on_a_half_space(body: FittedBody) -> None:
    made = record(clean(W, STRESS, MODES, CORNERS), seed=1, zero=0.03)
    fit = relaxation_fit(body, made, relaxation_settings("sls", [("stress", f"{STRESS} Pa")], ["w"]))
    assert off(fit, E_star=1.0, ratio=0.3, time=1.0, w=W, delta0=0.03) < 3.5
    errors = {name: fit.estimate(name).error for name in ("E_star", "ratio", "time", "w")}
    assert errors == pytest.approx({"E_star": 0.009, "ratio": 0.034, "time": 0.08, "w": 1e-4}, rel=0.5)
    assert 0.8 < fit.scatter < 1.2
    assert fit.warnings == ()


@pytest.mark.slow
def test_a_cycle_on_a_layer() -> None:
    made = record(clean(W, 0.35, MODES, CORNERS, 0.5, 0.5, 1.2), rows=200, seed=2, zero=0.03)
    fit = relaxation_fit(layered(), made, relaxation_settings("sls", [("stress", "0.35 Pa")], ["w"]))
    assert off(fit, E_star=1.0, ratio=0.3, time=1.0, w=W, delta0=0.03) < 3.5
    assert 0.8 < fit.scatter < 1.2


@pytest.mark.slow
def test_a_range_that_is_not_known_is_a_part_of_the_model(body: FittedBody) -> None:
    """The stated part of w covers the truth, which was made with another stress."""
    made = record(clean(W, STRESS, MODES, CORNERS), seed=1, zero=0.03)
    fit = relaxation_fit(body, made, relaxation_settings("sls", free=["w"]))
    w = fit.estimate("w")
    assert w.model is not None
    assert abs(w.value - W) < w.model["range"] + 3 * (w.error or 0)
    assert any("the cohesive stress is not known" in line for line in fit.warnings)


@pytest.mark.slow
def test_the_command(jkr: Callable, tmp_path: Path) -> None:
    made = record(clean(W, STRESS, MODES, CORNERS), rows=200)
    (tmp_path / "gel.toml").write_text(CASE)
    rows = np.stack([made.t, made.delta, made.P], axis=1)
    np.savetxt(tmp_path / "cycle.csv", rows, delimiter=",", header="t_s,delta_m,P_N", comments="")
    done = jkr("fit", "gel.toml", "cycle.csv", "--relaxation", "sls", "--free", "w", "--fix", "stress=0.16 Pa",
               "--fix", "delta0=0", "--json")  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)["fits"][0]
    assert found["estimates"]["w"]["value"] == pytest.approx(W, rel=0.05)
    assert found["estimates"]["stress"]["free"] is False
    with (tmp_path / "gel-fit.csv").open() as file:
        assert float(next(csv.DictReader(file))["w_J_per_m2"]) == pytest.approx(W, rel=0.05)

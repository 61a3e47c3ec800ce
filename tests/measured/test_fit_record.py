"""Raw force curves: base line, contact point, modulus and w of whole records, made by formulae of their own."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from dirty_records import KINDS
from force_curves import Instrument, back_at, equilibrium, load_at, record
from layer_contact import BondedLayer, half_space
from raw_records import BODY, R, body, inside, read, usual

from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError
from jkrcli.base.executors import executor
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.archive import FITTED, status_of
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.files import read as read_file
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.grade import GOOD, LEFT_OUT, LIMITS, USABLE
from jkrcli.measured.joint import joint_fit
from jkrcli.measured.lockstep import alone
from jkrcli.measured.parameters import ROOT, Parameter
from jkrcli.measured.procedure import Failure, fit, fit_all
from jkrcli.measured.record import raw_force_curve
from jkrcli.measured.report import columns, fit_words, summary
from jkrcli.measured.result import Fit
from jkrcli.measured.rows import noise_from_third_differences
from jkrcli.measured.segmentation import segment_force_curve
from jkrcli.methods.layered.solver import Layered


def made(rng: np.random.Generator) -> tuple[Curve, float, float]:
    """A record of random stiffness, adhesion, spring, dirt and length; its E* [Pa] and w [J/m^2]."""
    E_star, w = 10 ** rng.uniform(2, 7), 10 ** rng.uniform(-5, -2)
    radius = min((9 * math.pi * w * R**2 / (8 * E_star)) ** (1 / 3), 0.3 * R)
    w = 8 * E_star * radius**3 / (9 * math.pi * R**2)
    force, k = 1.5 * math.pi * w * R, 2 * E_star * radius * 10 ** rng.uniform(math.log10(0.03), 2)
    largest = force * rng.uniform(2, 10)
    position = equilibrium(E_star, R, w, k, largest)[0]
    span = float(position[-1] - position.min())
    rows = int(10 ** rng.uniform(math.log10(200), math.log10(20000)))
    device = Instrument(
        k, rows, far=span * rng.uniform(0.3, 3) - float(position.min()), largest=largest,
        noise=force * 10 ** rng.uniform(-3, math.log10(0.03)), offset=force * rng.uniform(-5, 5),
        tilt=force / span * rng.uniform(-0.2, 0.2), drag=force * rng.uniform(0, 0.2),
        drift=force * rng.uniform(-0.1, 0.1), pause=int(rng.choice([0, rows // 10])),
    )  # fmt: skip
    columns = record(E_star, R, 0.0, w, device, int(rng.integers(1 << 30)))
    return read(columns, k, *["segment"] * (rng.random() < 0.5)), E_star, w


@pytest.mark.first(2)
@pytest.mark.parametrize("seed", range(12))
def test_modulus_and_work_of_records_with_all_dirt(seed: int) -> None:
    curve, E_star, w = made(np.random.default_rng(seed))
    found = fit(BODY, curve, usual())
    for name, true in (("E_star", E_star), ("w", w)):
        item = found.estimate(name)
        assert abs(item.value - true) < 4.5 * item.error + 1e-4 * true  # normal: 1e-5 beyond
    assert found.grade.sizes["misfit"] < 0.01


H, NU = 1.5e-6, 0.45
LAYER = BondedLayer(H, NU)


@lru_cache
def case(layered: bool, E_star: float = 1e4) -> FittedBody:
    """The half-space or the layer, with the modulus that a case file may hold."""
    if not layered:
        return body(E_star)
    specimen = Specimen((Layer(Elastic((1 - NU**2) * E_star, NU), H),), Rigid())
    problem = Problem(Paraboloid(R), specimen, Loading("radius", 1e-6, 60))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def test_records_that_determine_no_modulus() -> None:
    curve, _, _ = made(np.random.default_rng(3))
    words = np.where(np.arange(len(curve)) <= int(np.argmax(curve.device)), "approach", "retract")
    turned = replace(curve, delta=-curve.delta, segment=words, stiffness=None)
    with pytest.raises(InputError, match=r"wrong way: the displacement of the retract has the opposite .*--flip delta"):
        alone(raw_force_curve(turned, usual(contact="fitted")))
    # A stiffness of the device that is half as large as it should be leaves no indentation: E* came out at 1e6 TPa,
    # doubtful.
    columns = record(3e5, R, 3e-4, 1e-3, Instrument(0.2, 400, far=2e-6, largest=1e-7, noise=3e-10), 3)
    said = r"E\* is not determined.*: compared with a cantilever of 100 mN/m .* nearly rigid"
    with pytest.raises(InputError, match=said):  # whether with a standard error, and which, is up to round-off
        fit(BODY, read(columns, 0.1), usual())


@pytest.mark.slow
@pytest.mark.parametrize(("size", "of_E", "of_w"), [(0.2, 0.917, 0.95), (1.0, 0.90, 0.933)])
def test_how_often_intervals_hold_beside_a_random_walk(size: float, of_E: float, of_w: float) -> None:
    """Noise slower than the contact passes for contact: what is told of it, of 60 records with a random walk in their
    load whose standard deviation grows to ``size`` of that of the white noise."""
    held = []
    for seed in range(5000, 5060):
        rng = np.random.default_rng(seed)
        curve, E_star, w = made(rng)
        steps = rng.normal(size=len(curve)) * noise_from_third_differences(curve.P) / math.sqrt(len(curve))
        P = curve.P + size * np.cumsum(steps)
        found = fit(BODY, replace(curve, P=P, delta=curve.device - P / curve.stiffness), usual())
        held.append([inside(found, name, true) for name, true in (("E_star", E_star), ("w", w))])
    assert np.mean(held, axis=0) == pytest.approx([of_E, of_w], abs=0.03)  # as measured, rounding may turn a few


def test_the_modulus_of_the_case_does_not_matter_and_what_is_known_is_kept() -> None:
    curve, E_star, w = made(np.random.default_rng(3))
    one, other = fit(BODY, curve, usual()), fit(body(1e6), curve, usual())
    for name in ("E_star", "w", "delta0"):
        assert other.value(name) == pytest.approx(one.value(name), rel=1e-6)
    found = fit(BODY, curve, usual(fix=[("w", f"{w} J/m^2")]))
    assert found.value("w") == pytest.approx(w, rel=1e-12)
    assert not found.estimate("w").free
    assert inside(found, "E_star", E_star)
    bound = fit(BODY, curve, usual(bound=[("E_star", f"{2 * E_star} Pa..")]))
    assert bound.value("E_star") == pytest.approx(2 * E_star, rel=1e-6)
    assert any("E* ends on its bound" in line for line in bound.warnings)


def test_a_drift_that_is_fitted_makes_no_specimen_rigid() -> None:
    """The readings rise faster than beside a rigid body where the depth drifts by a tenth of the speed."""
    E_star, far, stiffer = 1e6, 1e-6, 30
    w = 0.3 * 8 * E_star * (0.5e-6) ** 3 / (9 * math.pi * R**2)
    force, k = 1.5 * math.pi * w * R, 2 * E_star * far / stiffer
    columns = record(E_star, R, w, w, Instrument(k, 600, far, 4 / 3 * E_star * far**3 / R, 3e-4 * force), 1)
    z, rows = columns["z"], np.arange(columns["z"].size)
    turn = int(np.argmax(z))
    shown = z + 0.1 * np.abs(np.diff(z[:turn])).mean() * (rows - turn)
    moved = read(columns | {"z": shown, "t": rows / 1000}, k, "segment", "t")
    found = fit(BODY, moved, usual(free=("drift",)))
    assert found.value("E_star") == pytest.approx(E_star, rel=5e-3)


def drifting(share: float, seed: int = 5) -> tuple[Curve, float, float]:
    """A record whose displacement drifts by a ``share`` of the way meanwhile; its E* [Pa] and the drift [m/s]."""
    E_star, w_in, w_out, k = 20e3, 3e-5, 1e-4, 0.05
    force = 1.5 * math.pi * w_out * R
    device = Instrument(k, 1000, 3e-6, 4 * force, 0.005 * force, force, 0.1 * force / 1e-6, 0.05 * force)
    columns = record(E_star, R, w_in, w_out, device, seed)
    z, t = columns["z"], columns["t"]
    speed = share * float(np.ptp(z) / np.ptp(t))
    return read(columns | {"z": z + speed * t}, k, "t", "segment"), E_star, speed


def test_a_drift_of_the_depth_is_fitted_where_it_is_asked_for_and_said_elsewhere() -> None:
    # A drift of 2 % of the way changes E* of the retraction alone by 3 %, with an interval of half a per cent.
    curve, E_star, speed = drifting(-0.02)
    found = fit(BODY, curve, usual(segment="both", free=["drift"]))
    for name, true in (("E_star", E_star), ("drift", speed)):
        assert found.estimate(name).low < true < found.estimate(name).high
    assert found.estimate("drift").dimension == "speed"
    fixed = fit(BODY, curve, usual(segment="both", fix=[("drift", f"{speed} m/s")]))
    assert fixed.value("E_star") == pytest.approx(E_star, rel=0.005)
    said = {}
    for share in (0.0, -0.02):
        found = fit(BODY, drifting(share)[0], usual(segment="both"))
        said[share] = [line for line in found.warnings if line.startswith("drift")]
    assert said[0.0] == []
    assert re.search(r"drifts by -[\d.]+ nm/s ± .* would change the moduli by \+[\d.]+%: --free drift", said[-0.02][0])


def test_a_drift_needs_both_directions_and_their_time() -> None:
    curve, _, _ = drifting(0.0)
    for held, options, reason in (
        (curve, {"segment": "retract"}, "drift needs approach and retraction together: leave --segment out"),
        (replace(curve, t=None), {}, "drift needs a column of time, there is none: leave drift out"),
        (curve.only("retract"), {}, "drift needs approach and retraction together, only one can be fitted"),
        (curve, {"contact": "as-is"}, "drift is for raw force curves of displacement and load, with --contact fitted"),
    ):
        with pytest.raises(InputError, match=reason):
            fit(BODY, held, usual(free=["drift"], **options))


def test_a_contact_of_few_rows_after_a_long_way_is_kept_to_its_end() -> None:
    columns = record(20e3, R, 0.0, 0.0, Instrument(0.05, 10000, 60e-6, 4e-9, 1e-11), 4)
    found = fit(BODY, read(columns, 0.05), usual(segment="approach"))
    assert np.count_nonzero(found.a) > 35
    assert found.value("E_star") == pytest.approx(20e3, rel=0.015)  # standard error: 0.0034


def without_base_line(chosen: Callable[[np.ndarray, np.ndarray], np.ndarray], offset: float = 0.0) -> Curve:
    """The rows of a record, E* = 20 kPa, w = 0.1 mJ/m^2, whose position and load over the pull-off force are chosen."""
    force, k = 1.5 * math.pi * 1e-4 * R, 0.05
    columns = record(20e3, R, 0.0, 1e-4, Instrument(k, 1500, 3e-6, 4 * force, 0.005 * force), 1)
    rows = chosen(columns["z"], columns["P"] / force)
    return read(columns, k, P=columns["P"] + offset * force).rows(np.flatnonzero(rows))


@pytest.mark.parametrize(
    "chosen",
    [lambda z, P: z > 0.02e-6, lambda z, P: P > 0.3, lambda z, P: (P < -0.05) & (z > -0.2e-6)],
    ids=["no base line", "compression", "tension"],
)
def test_what_there_is_of_a_record_is_fitted(chosen: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
    """Without a base line the zero of the load is that of the file. In compression the edge rests on all the way back:
    w is at least what the last row holds."""
    found = fit(BODY, without_base_line(chosen), usual())
    E, w = found.estimate("E_star"), found.estimate("w")
    assert E.value == pytest.approx(20e3, rel=0.005)
    assert abs(E.value - 20e3) < 4.5 * E.error
    if w.error is None:
        assert 0.7e-4 < w.low < 1e-4
        assert any("the contact line is pinned in all rows" in line for line in found.warnings)
    else:
        assert abs(w.value - 1e-4) < 4.5 * w.error < 0.05e-4
    assert "no base line" in found.flags
    assert any("no base line: the zero of the load is set to 0 (--free P0" in line for line in found.warnings)


def test_a_free_zero_of_a_record_in_tension_leaves_w_open() -> None:
    found = fit(BODY, without_base_line(lambda z, P: (P < -0.05) & (z > -0.2e-6), offset=1.0), usual(free=["P0"]))
    assert found.estimate("w").low == 0
    assert found.estimate("w").high > 1e-4


@pytest.mark.first(1)
@pytest.mark.parametrize("asked", [
    {"bound": [("w", "1 uJ/m^2..")]}, {"branch": "compressive"}, {"noise": {"P": 1e-9}}, {"free": ["compliance"]},
    {"start": [("w", "1 mJ/m^2")]}, {"free": ["E:base"]},
])  # fmt: skip
def test_what_the_model_of_a_record_does_not_know_is_fitted_to_its_rows(asked: dict[str, object]) -> None:
    curve, E_star, _ = made(np.random.default_rng(7))
    found = fit(BODY, curve, usual(**asked))
    assert abs(found.value("E_star") - E_star) < 3.5 * (found.estimate("E_star").error or 0)
    assert found.rows.size < 0.9 * len(curve)
    assert "only rows in contact are fitted" in " ".join(found.warnings)


def test_estimated_zeros_and_a_sine_that_is_not_there_change_nothing() -> None:
    curve, _, _ = made(np.random.default_rng(7))
    plain = fit(BODY, curve, usual()).value("E_star")
    assert fit(BODY, curve, usual(contact="estimate")).value("E_star") == plain
    found = fit(BODY, curve, usual(base_line="sine"))
    assert found.value("E_star") == plain
    assert "base line: no sine beyond its noise, a straight line is used" in found.warnings
    with pytest.raises(InputError, match="--base-line sine is for raw force curves"):
        fit(BODY, curve, usual(base_line="sine", contact="as-is"))


@pytest.mark.parametrize(("loss", "size"), [("linear", 0.1), ("soft_l1", 0.02)])
def test_outliers_among_the_rows_change_nothing(loss: str, size: float) -> None:
    """Three in a hundred rows are off, by 7 or 30 standard deviations: those that stand alone are left out."""
    E_star, w, k, rng = 20e3, 1e-4, 0.05, np.random.default_rng(1)
    force = 1.5 * math.pi * w * R
    columns = record(E_star, R, 0.0, w, Instrument(k, 2000, 3e-6, 4 * force, 0.003 * force), 2)
    P = columns["P"] + size * force * rng.normal(size=4000) * (rng.random(4000) < 0.03)
    found = fit(BODY, read(columns, k, P=P), usual(loss=loss))
    assert found.grade.word == GOOD
    assert any("isolated outliers" in words for words in found.left_out)
    for name, true in (("E_star", E_star), ("w", w)):
        item = found.estimate(name)
        assert abs(item.value - true) < 3 * item.error < 3e-3 * true


def cycled(seed: int, w_in: float = 3e-5, layered: bool = False, noise: float = 0.005) -> Curve:
    """Approach and retraction, E* = 20 kPa, w = 0.1 mJ/m^2 on the way out."""
    k, force = 0.05, 1.5 * math.pi * 1e-4 * R
    device = Instrument(k, 1500, 3e-6, 4 * force, noise * force, force, 0.1 * force / 1e-6, 0.05 * force)
    columns = record(20e3, R, w_in, 1e-4, device, seed, LAYER if layered else half_space)
    return read(columns, k, "t")


TRUE = {"E_star": 20e3, "w": 1e-4, "w_approach": 3e-5}


@pytest.mark.first(1)
@pytest.mark.parametrize("layered", [False, True])
@pytest.mark.parametrize("segment", [None, "retract", "approach"])
def test_the_edge_rests_at_the_turn(segment: str | None, layered: bool) -> None:
    """A model that recedes at once errs in E* by 8 % and by 40 standard errors on the half-space."""
    found = fit(case(layered), cycled(1, layered=layered), usual(segment=segment))
    names = {item.name for item in found.estimates} & set(TRUE)
    assert names == {None: set(TRUE), "retract": {"E_star", "w"}, "approach": {"E_star", "w_approach"}}[segment]
    for name in names:
        item = found.estimate(name)
        assert abs(item.value - TRUE[name]) < min(4 * item.error, 0.1 * TRUE[name])
    asked = {None: "approach and retraction", "retract": "retraction alone", "approach": "approach alone"}
    assert found.directions == asked[segment]
    drawn = found.line["delta"]
    assert np.abs(np.diff(drawn)).max() < 0.1 * np.ptp(drawn)  # in and out in one stroke: the line crosses no picture


def test_one_direction_alone() -> None:
    curve = cycled(1)
    turn = int(np.argmax(curve.device))
    found = fit(BODY, curve.rows(np.arange(turn + 200)), usual())
    assert found.directions == "approach alone (retraction: it has no base line)"
    assert any("approach alone: its w is w_approach" in line for line in found.warnings)
    found = graded(way_back(cycled(1)))
    assert "no approach" in found.flags
    assert found.grade.word in (GOOD, USABLE)
    assert status_of(found) == FITTED
    assert abs(found.value("E_star") / TRUE["E_star"] - 1) < found.grade.sizes["E_star_error"]


def test_directions_of_different_moduli_stand_side_by_side() -> None:
    """A specimen that yields: the way back is that of a contact that is stiffer by a tenth."""
    inwards = cycled(1, w_in=1e-4)
    stiffer = record(22e3, R, 1e-4, 1e-4, Instrument(0.05, 1500, 3e-6, 6 * math.pi * 1e-4 * R, 1e-11), 3)
    rows = np.arange(len(inwards)) >= 1500
    P = np.where(rows, stiffer["P"], inwards.P)
    z = np.where(rows, stiffer["z"] + inwards.device.max() - stiffer["z"].max(), inwards.device)
    found = fit(BODY, read({"z": z, "P": P}, 0.05), usual())
    assert "directions differ" in found.flags
    assert found.value("E_star_approach") == pytest.approx(20e3, rel=0.01)
    assert found.value("E_star") == pytest.approx(22e3, rel=0.01)
    assert any(re.match(r"directions differ: E\* is [\d.]+ kPa on approach and", line) for line in found.warnings)


def test_calibration_is_a_part_of_its_own_and_a_search_may_be_given_up(tuned: Callable[[str, object], None]) -> None:
    # E* and w are as wrong as the stiffness that loads are made with; w goes with 1/R, on a half-space.
    curve = cycled(1)
    found = fit(BODY, curve, usual(uncertain={"stiffness": "10%", "radius": 0.03 * R, "sensitivity": "2%"}))
    parts = {name: found.estimate(name).systematic for name in ("E_star", "w")}
    for name, by_radius in (("E_star", 0.5), ("w", 1.0)):
        told, value = parts[name], found.value(name)
        assert told["stiffness"] == pytest.approx(0.1 * value, rel=1e-3)
        assert told["radius"] == pytest.approx(-0.03 * by_radius * value, rel=0.02)
        assert 0.02 < told["sensitivity"] / value < 0.06  # of the load, and of the depth that a deflection takes
        assert found.estimate(name).error > math.hypot(*told.values())
    tuned("jkrcli.measured.force_curve.FIT_EVALUATIONS", 1)
    found = fit(BODY, cycled(1), usual())
    assert "not determined" in found.flags
    assert found.estimate("E_star").high is None
    assert any("stopped after 1 steps" in line for line in found.warnings)


@pytest.mark.parametrize(
    ("stiffness", "contact", "said"),
    [(None, "fitted", "stiffness: the force curve has no stiffness, so it has no effect"),
     (0.05, "as-is", "stiffness is for raw force curves of an instrument, it has no effect")],
)  # fmt: skip
def test_an_uncertain_input_without_effect_is_refused(stiffness: float | None, contact: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        fit(BODY, replace(cycled(1), stiffness=stiffness), usual(uncertain={"stiffness": "10%"}, contact=contact))


def test_the_noise_is_that_of_the_free_rows() -> None:
    """What a wrong body leaves in contact is misfit: it is flagged, and does not widen the intervals."""
    curve = cycled(1, layered=True)
    right, wrong = fit(case(True), curve, usual()), fit(BODY, curve, usual(segment="retract"))
    assert not right.flags
    assert "misfit" in wrong.flags
    assert wrong.grade.sizes["misfit"] > 0.01
    item = wrong.estimate("E_star")
    assert item.error < 0.02 * item.value


@pytest.mark.parametrize(("w", "flat"), [(0.0, True), (1e-6, True), (1e-4, False)])
def test_w_of_an_approach_is_told_through_0(w: float, flat: bool) -> None:
    columns = record(20e3, R, w, w, Instrument(0.05, 1500, 3e-6, 2e-8, 1e-10), 8)
    found = fit(BODY, read(columns, 0.05), usual(segment="approach"))
    assert "w" not in {item.name for item in found.estimates}
    item = found.estimate("w_approach")
    assert item.low <= w <= item.high
    assert (item.low == 0) == flat
    assert inside(found, "E_star", 20e3)


def test_the_limit_of_a_root_below_0() -> None:
    """What tells w itself comes out at -4 ± 1 of its standard errors where the root is -2 ± 1/4; near 0 the root's own
    limit is the wider one."""
    item = Parameter("w_approach", True, scale=ROOT, quantity="work")
    far, near = (item.estimate(root, error, 1.96) for root, error in ((-2.0, 0.25), (-0.1, 1.0)))
    assert (far.value, far.low, near.low) == (0.0, 0.0, 0.0)
    assert far.high == pytest.approx(1.645, rel=1e-3)
    assert near.high == pytest.approx(1.645**2, rel=1e-3)


@pytest.mark.first(1)
@pytest.mark.parametrize("seed", [0, 2])
def test_an_edge_that_seems_to_rest_throughout_is_compared_with_one_that_recedes(seed: int) -> None:
    """A device fifty times softer than the contact: where the edge never recedes, E* is half too high."""
    E_star, w, w_approach = 151.9e3, 1.595e-3, 0.97e-3
    device = Instrument(6.6e-3, 800, far=18e-6, largest=33e-9, noise=5e-11, offset=-1.35e-9)
    columns = record(E_star, 5e-6, w_approach, w, device, seed)
    found = fit(body(E_star, 3e-6), read(columns, device.k, "segment"), usual())
    assert not found.flags
    for name, true in (("E_star", E_star), ("w", w), ("w_approach", w_approach)):
        item = found.estimate(name)
        assert item.value == pytest.approx(true, abs=3 * item.error)


@pytest.mark.first(2)
@pytest.mark.parametrize(("seed", "number"), [(7, 2), (17, 4), (17, 12), (73, 1)])
def test_noise_that_hides_where_contact_is_lost_excludes_no_truth(tmp_path: Path, seed: int, number: int) -> None:
    """Searches ended at rest: w_approach at most 5.5 of 13 uJ/m^2 (loads go with its root there), 8.4 half-widths of a
    wrong minimum off, a lower limit of w where the edge recedes, or w_approach at most 13 of 63."""
    dirty = KINDS["large noise"](np.random.default_rng((seed, 22, number)))
    dirty.write(file := tmp_path / "noisy.txt")
    found = fit(body(1e4, 0.2 * dirty.at.R, dirty.at.R), read_file(file, Reading())[0], usual())
    assert number == 2 or "w" in found.free
    for name, true in dirty.truth.items():
        if (item := found.estimate(name)).high is not None:
            # 3.2 standard errors: of these draws the farthest is 3.1 off
            more = math.hypot(*(item.model or {}).values()) + 0.3 * (item.high - (item.low or 0.0))
            assert (item.low or 0.0) - more <= true <= item.high + more


@pytest.mark.parametrize(("share", "tether"), [(0.04, 0.0), (0.003, 0.1)])
def test_a_weak_pull_off_is_no_base_line(share: float, tether: float) -> None:
    """Of 0.3 to 4 % of the largest load, as of gels: rows of so small a tension lay in the base line and w came out up
    to 20 % too low; a tether of a tenth of it was not seen."""
    w, widest = 2e-4, 0.3 * R
    pull_off = 1.5 * math.pi * w * R
    E_star = 3 * pull_off / share * R / (4 * widest**3)
    k = 2 * E_star * widest
    z, _, _ = equilibrium(E_star, R, w, k, pull_off / share)
    far = 1.5 * float(np.ptp(z)) - float(z.min())
    device = Instrument(k, 1500, far=far, largest=pull_off / share, noise=0.004 * pull_off)
    columns = record(E_star, R, w / 2, w, device, 5)
    z_free = z.min() - columns["z"]
    held = (columns["segment"] == "retract") & (z_free > 0) & (z_free < 0.5 * z_free.max())
    P = columns["P"] - tether * pull_off * held
    found = fit(body(E_star, 3e-6), read(columns, k, "segment", P=P), usual())
    assert not found.flags
    assert any("tether" in words for words in found.held) == bool(tether)
    for name, true in (("E_star", E_star), ("w", w), ("w_approach", w / 2)):
        item = found.estimate(name)
        assert item.value == pytest.approx(true, abs=max(3 * item.error, 0.02 * true))


def test_the_profile_that_describes_a_record_is_the_answer() -> None:
    """The literature's paraboloid, fitted by the exact sphere of its radius: the model was rejected, with the right
    values in a remark."""
    E_star, w, widest = 1e5, 2e-4, 0.35 * R
    k, largest = 2 * E_star * widest, 4 * E_star * widest**3 / (3 * R)
    z, _, _ = equilibrium(E_star, R, w, k, largest)
    device = Instrument(k, 1500, far=float(np.ptp(z)), largest=largest, noise=1e-4 * largest)
    columns = record(E_star, R, w / 2, w, device, 4)
    found = fit(body(E_star, 0.3 * R).under(Sphere(R), widest), read(columns, k, "segment"), usual())
    assert "model rejected" not in found.flags
    assert "paraboloid of the same radius, which describes the record" in found.tip
    for name, true in (("E_star", E_star), ("w", w), ("w_approach", w / 2)):
        assert found.value(name) == pytest.approx(true, rel=0.02)


def test_the_steps_of_a_converter_are_noise() -> None:
    """Coarser than the noise: a base line that does not scatter left errors of 1e-12 beside a misfit of 1e10; one that
    rests on a level knows the offset to a part of the level, 1.4 % of w here, which is 1.5 % off."""
    E_star, w, step = 20e3, 2.5e-4, 2e-10
    device = Instrument(0.05, 800, far=1e-6, largest=8e-9, noise=1e-12, offset=-3.4 * step)
    columns = record(E_star, R, w, w, device, 3)
    curve = read(columns, device.k, "segment", P=step * np.rint(columns["P"] / step))
    found = fit(body(E_star, 3e-6), curve, usual())
    for name, true in (("E_star", E_star), ("w", w)):
        item = found.estimate(name)
        assert 1e-5 < item.error / item.value < 2e-2
        assert item.value == pytest.approx(true, abs=4 * math.hypot(item.error, *(item.model or {}).values()))
    assert "misfit" not in found.flags


# ---------------------------------------------------------------------- curves of a map know nothing of each other
def cycle(seed: int) -> Curve:
    force, E_star = 1.5 * math.pi * 1e-4 * R, 1e4 * (1 + seed)
    columns = record(E_star, R, 3e-5, 1e-4, Instrument(0.05, 250, 1e-6, 3 * force, 0.01 * force), seed)
    return replace(read(columns, 0.05, "segment"), name=str(seed))


def numbers(found: Fit | Failure) -> list[object]:
    return [(item.name, item.value, item.error, item.low, item.high) for item in found.estimates]


def fitted(curves: list[Curve]) -> dict[str, Fit | Failure]:
    with executor(1) as pool:
        return dict(zip([one.name for one in curves], fit_all(BODY, curves, usual(), pool), strict=True))


def test_neither_order_nor_neighbours_change_a_fit() -> None:
    """Beside curves that are constant, saturated or huge."""
    curves = [cycle(seed) for seed in range(2)]
    P = curves[0].load
    spoilt = [np.full(P.size, P[0]), np.minimum(P, P.min() + 0.01 * np.ptp(P)), 1e150 * P]
    poisoned = [replace(curves[0], name=f"spoilt {i}", P=bad) for i, bad in enumerate(spoilt)]
    forth = fitted(curves)
    with np.errstate(all="ignore"):
        beside = fitted([poisoned[0], curves[1], *poisoned[1:], curves[0]])
    for curve in curves:
        assert numbers(beside[curve.name]) == numbers(forth[curve.name]) == numbers(fit(BODY, curve, usual()))
    assert isinstance(beside["spoilt 0"], Failure)


# ---------------------------------------------------------------------- grades by sizes
def graded(curve: Curve, **options: str) -> Fit:
    return fit(BODY, curve, usual(**options))


def way_back(curve: Curve) -> Curve:
    return curve.rows(np.arange(int(np.argmax(curve.P)), len(curve)))


def test_readings_without_noise_are_no_misfit_and_grade_and_sizes_are_written() -> None:
    found = graded(cycled(1, noise=1e-7))
    assert not {"misfit", "model rejected"} & set(found.flags)
    assert found.value("E_star") == pytest.approx(TRUE["E_star"], rel=1e-3)
    assert found.grade.word == GOOD
    assert columns([found])["grade"] == [GOOD]
    (curve,) = summary([found], "body")["curves"]
    assert curve["grade"] == GOOD
    assert {"misfit", "misfit_of_pull_off", "E_star_error", "w_error"} <= set(curve["sizes"]) & set(LIMITS)
    assert curve["quality"] > 0.9
    assert fit_words(found)[0].endswith(": good")


@pytest.mark.slow
def test_a_direction_that_says_otherwise_is_in_the_error() -> None:
    """Loads of the retraction 1.1 times as large: E* has what leaving a direction out changes."""
    curve = cycled(1)
    back = np.arange(len(curve)) > np.argmax(curve.P)
    found = graded(replace(curve, P=np.where(back, 1.1 * curve.P, curve.P)))
    item = found.estimate("E_star")
    assert found.grade.sizes["E_star_by_direction"] > 0.05
    assert (item.model or {})[LEFT_OUT] > 0.05 * item.value
    assert abs(item.value / TRUE["E_star"] - 1.05) < 2 * found.grade.sizes["E_star_error"]


def test_what_free_rows_hold_beside_a_line() -> None:
    curve = cycled(1)
    noise = 0.2 * np.ptp(curve.P) * np.random.default_rng(3).normal(size=len(curve))
    assert "wavy base line" not in segment_force_curve(replace(curve, P=curve.P + noise)).flags
    # A tooth of 5 % of the load on the free rows: 1 % of it in their root mean square.
    curve = cycled(1)
    place = np.arange(len(curve)) / int(np.argmax(curve.P))
    tooth = 0.05 * float(curve.P.max()) * np.maximum(1 - np.abs(place - 0.25) / 0.05, 0.0)
    sizes = [graded(one, segment="approach").sizes or {} for one in (curve, replace(curve, P=curve.P + tooth))]
    assert sizes[0]["misfit"] < 0.003 < 0.005 < sizes[1]["misfit"]


def test_a_device_whose_stiffness_errs_has_loads_that_err() -> None:
    """A deflection sensitivity 15 % too large: w is as much too large, E* and w are known no better."""
    curve = cycled(1)
    P = 1.15 * curve.P
    found = graded(replace(curve, P=P, delta=curve.device - P / curve.stiffness))
    w = found.estimate("w")
    assert "model rejected" in found.flags
    assert w.model["scale of the loads"] == pytest.approx(0.13 * w.value, rel=0.3)  # 1 - 1/1.15
    assert abs(w.value - TRUE["w"]) < 2 * found.grade.sizes["w_error"] * w.value


def test_a_misfit_that_nothing_explains_names_no_alternative_and_widens_the_error() -> None:
    """Lobes of 1 % of the load along both ways in contact, which no body, tip or device makes: all alternatives take
    some of it, by which E* would move by up to a half."""
    curve = cycled(1)
    touching = np.maximum(curve.P, 0.0) / float(curve.P.max())
    lobes = 0.01 * float(curve.P.max()) * np.sin(9 * math.pi * np.sqrt(touching))
    found = graded(replace(curve, P=curve.P + lobes))
    assert "misfit" in found.flags
    assert "model rejected" not in found.flags
    item = found.estimate("E_star")
    part = (item.model or {})["misfit"]
    assert part > 4 * (item.high - item.low) / 2
    assert abs(item.value / TRUE["E_star"] - 1) < part / item.value


# ---------------------------------------------------------------------- hysteresis and creep of a piezo
E_STAR, W_IN, W_OUT, K, ROWS = 20e3, 3e-5, 1e-4, 0.05, 1000
FORCE = 1.5 * math.pi * W_OUT * R
POSED = {"E_star": E_STAR, "w": W_OUT, "w_approach": W_IN}


def bowed(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """Of the travel, over its share from the turn on: at most ``amount`` in its middle."""
    return lambda share: amount * (1 - (2 * share - 1) ** 2)


def crept(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """Per decade of the time since the last row of the approach, from a hundredth of the record on, which lasts two
    ways less a row."""
    return lambda share: amount * np.log1p((share * (1 - 1 / ROWS) + 1 / ROWS) / (0.02 - 1e-2 / ROWS)) / np.log(10)


def placed(error: Callable[[np.ndarray], np.ndarray], seed: int = 1, noise: float = 0.005, pause: int = 0) -> Curve:
    """A record whose device stands deeper on the way back than it says, by an ``error`` of the travel; the contact
    grows meanwhile, where it waits for a ``pause`` of so many rows."""
    top = float(equilibrium(E_STAR, R, W_IN, K, 4 * FORCE)[0][-1])
    way, rng = np.linspace(-3e-6, top, ROWS), np.random.default_rng(seed)
    moved = error((top - way) / np.ptp(way)) * np.ptp(way)
    deepest = top + (moved[-1] if pause else 0.0)
    out = back_at(way + moved, E_STAR, R, (W_IN, W_OUT), K, 6 * FORCE, deepest)
    into = load_at(way, E_STAR, R, W_IN, K, 6 * FORCE)
    P = np.concatenate([into + 0.05 * FORCE, np.full(pause, into[-1]), out[::-1] - 0.05 * FORCE])
    z = np.concatenate([way, np.full(pause, top), way[::-1]])
    P += FORCE * (1 + 0.1 * z / 1e-6 + noise * rng.normal(size=z.size))
    return Curve("made", delta=z - P / K, P=P, t=np.arange(z.size) / ROWS, stiffness=K)


@pytest.mark.first(2)
@pytest.mark.parametrize(("name", "error"), [("hysteresis", bowed), ("creep", crept)])
@pytest.mark.parametrize("amount", [-0.003, 0.0])
def test_an_error_of_positions_is_fitted_where_it_is_asked_for(name: str, error: Callable, amount: float) -> None:
    """1 % of the travel moves E* by 6 to 8 %, a hundred of its standard errors."""
    curve = placed(error(amount))
    found, plain = (fit(BODY, curve, usual(free=free)) for free in ([name], []))
    for key, true in {**POSED, name: amount}.items():
        item = found.estimate(key)
        assert abs(item.value - true) < 4 * item.error
    assert found.estimate(name).error < 0.1 * max(abs(amount), 0.002)
    assert not found.flags
    if amount:
        item = plain.estimate("E_star")
        assert abs(item.value - E_STAR) > 10 * (item.error or 0.0) or plain.flags
    known = fit(BODY, curve, usual(fix=[(name, str(amount))]))
    assert not known.estimate(name).free
    item = known.estimate("E_star")
    assert abs(item.value - E_STAR) < 4 * item.error
    assert item.error < found.estimate("E_star").error


def test_a_device_creeps_while_it_waits() -> None:
    wait = 500
    last = (2 * ROWS + wait - 1) / 100 / ROWS

    def error(share: np.ndarray) -> np.ndarray:
        return 0.01 * np.log10(1 + (share * (1 - 1 / ROWS) + (wait + 1) / ROWS) / last)

    found = fit(BODY, placed(error, pause=wait), usual(free=["creep"]))
    for key, true in {**POSED, "creep": 0.01}.items():
        item = found.estimate(key)
        assert abs(item.value - true) < 4 * item.error
    assert not found.flags


def test_what_hysteresis_and_creep_need() -> None:
    curve = placed(bowed(0.01))
    one, other = (fit(BODY, each, usual(free=["hysteresis"])) for each in (curve, replace(curve, t=None)))
    assert other.value("hysteresis") == pytest.approx(one.value("hysteresis"))
    curve = placed(bowed(0.0))
    with pytest.raises(InputError, match=r"^made: creep needs a column of time, there is none: leave creep out$"):
        fit(BODY, replace(curve, t=None), usual(free=["creep"]))
    with pytest.raises(InputError, match=r"^made: hysteresis is fitted to whole force curves only, without compliance"):
        fit(BODY, curve, usual(free=["hysteresis"], branch="compressive"))


def test_records_of_one_device_share_it() -> None:
    curves = [placed(bowed(0.01), seed) for seed in range(3)]
    settings = usual(free=["hysteresis"])
    together = joint_fit([BODY] * 3, curves, settings, ("modulus", "hysteresis"))
    alone = fit(BODY, curves[0], settings).estimate("hysteresis")
    item = together.estimate("hysteresis")
    assert abs(item.value - 0.01) < 4 * item.error
    assert item.error == pytest.approx(alone.error / math.sqrt(3), rel=0.3)
    assert together.chance > 1e-3
    own = joint_fit([BODY] * 3, curves, settings, ("modulus",))
    assert [one.value("hysteresis") for one in own.fits] == pytest.approx([0.01] * 3, rel=0.1)


@pytest.mark.parametrize(("name", "value"), [("hysteresis", "1"), ("creep", "-1e9")])
def test_more_than_the_travel_is_refused(name: str, value: str) -> None:
    with pytest.raises(InputError, match=f"^fit: {name} is a fraction of the travel, must be > -1 and < 1, got"):
        usual(fix=[(name, value)])

"""Records are taken apart as they were made: directions, base line, touch, jumps, adhesion; what is wrong is named."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dirty_records import KINDS, Attracted, Dirty, branches
from fit_data import adhesive
from force_curves import Instrument, equilibrium, record

from jkrcli.base.errors import InputError, Unknown
from jkrcli.measured.curve import APPROACH, Curve, Reading
from jkrcli.measured.files import read
from jkrcli.measured.segmentation import ForceCurve, resolution, segment_force_curve, segment_force_curves
from studies.cycle_records import drawn

E_STAR, R, W = 20e3, 5e-6, 1e-4
PULL_OFF = 1.5 * np.pi * W * R
DEVICE = Instrument(k=0.05, rows=2000, far=3e-6, largest=4 * PULL_OFF, noise=0.01 * PULL_OFF, offset=3 * PULL_OFF,
                    tilt=0.1 * PULL_OFF / 1e-6, drag=0.1 * PULL_OFF, pause=200)  # fmt: skip


def curve_of(
    device: Instrument, w_approach: float = 0.0, w_retract: float = W, seed: int = 1, told: bool = False
) -> Curve:
    made = record(E_STAR, R, w_approach, w_retract, device, seed)
    return Curve("made", delta=made["z"], P=made["P"], t=made["t"], segment=made["segment"] if told else None)


def examined(device: Instrument = DEVICE, **more: float) -> ForceCurve:
    return segment_force_curve(curve_of(device, **more))


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("pause", [0, 200])
def test_directions_are_found_without_a_column_as_with_one(told: bool, pause: int) -> None:
    found = segment_force_curve(curve_of(replace(DEVICE, pause=pause), told=told))
    waits = ["pause" if told else "dwell"] if pause else []
    assert [part.kind for part in found.segments] == ["approach", *waits, "retract"]
    made = [DEVICE.rows, pause, DEVICE.rows] if pause else [DEVICE.rows, DEVICE.rows]
    assert [len(part) for part in found.segments] == pytest.approx(made, abs=0 if told else 5)
    assert found.segments[0].first == 0
    assert found.segments[-1].last == len(found.curve) - 1


def test_parts_are_told_by_motion_whatever_they_are_called() -> None:
    # It drew the usual speed to zero, and was a retraction that went the wrong way.
    depth = np.concatenate([np.linspace(0, 6e-5, 80), np.full(400, 6e-5)])
    P = 1e-3 * np.concatenate([depth[:80], np.geomspace(6e-5, 3e-5, 400)])
    found = segment_force_curve(Curve("held", None, depth, P, None))
    assert [(part.kind, len(part)) for part in found.segments] == [("approach", 80), ("dwell", 400)]
    curve = curve_of(DEVICE)
    found = segment_force_curve(replace(curve, segment=np.full(len(curve), "approach")))
    assert [part.kind for part in found.segments] == ["approach", "dwell", "retract"]
    plain = dented(0.0, 200)
    P, rows = plain.load.copy(), np.arange(200)
    P[750:950] *= 0.3 + 0.7 * np.exp(-rows / 30)
    P[950:] *= 0.3
    found = segment_force_curve(replace(plain, P=P))
    assert [part.kind for part in found.segments] == ["approach", "dwell", "retract"]
    assert [len(part) for part in found.segments] == pytest.approx([750, 200, 600], abs=25)


@pytest.mark.parametrize("seed", range(2))
def test_base_line_noise_and_adhesion_are_those_that_were_made(seed: int) -> None:
    found = examined(seed=seed)
    assert found.flags == {}
    for kind, drag in (("approach", DEVICE.drag), ("retract", -DEVICE.drag)):
        side = found.direction(kind)
        assert side.base.noise == pytest.approx(DEVICE.noise, rel=0.15)
        assert side.base.tilt == pytest.approx(DEVICE.tilt, rel=0.03)
        assert float(side.base(np.array(0.0))) == pytest.approx(DEVICE.offset + drag, abs=0.01 * PULL_OFF)
        assert side.base.waviness < 0.01 * PULL_OFF
    approach, retract = found.direction("approach"), found.direction("retract")
    assert isinstance(approach.adhesion, Unknown)
    assert not approach.jumps
    position, _, load = equilibrium(E_STAR, R, W, DEVICE.k, DEVICE.largest)
    fold = int(np.argmin(position))
    assert retract.adhesion == pytest.approx(-load[fold:].min(), abs=5 * DEVICE.noise)
    assert retract.touch == pytest.approx(position[fold], abs=2 * retract.touch_err)
    assert len(retract.jumps) == 1
    assert retract.jumps[0].position == pytest.approx(position[fold], abs=5e-8)
    assert approach.touch == pytest.approx(0.0, abs=2e-7)


def test_jumps_and_what_lets_go_slowly() -> None:
    found = examined(w_approach=W).direction("approach")
    assert len(found.jumps) == 1
    assert found.jumps[0].position == pytest.approx(0.0, abs=1e-8)
    assert found.touch == pytest.approx(0.0, abs=3 * found.touch_err)
    assert isinstance(found.adhesion, float)
    # A pull-off smeared over many rows, as by tethers or drag: contact for sure begins where tension is largest.
    curve = curve_of(replace(DEVICE, pause=0))
    slow = np.convolve(np.pad(curve.P, 150, mode="edge"), np.ones(301) / 301, "valid")
    side = segment_force_curve(replace(curve, P=slow)).direction("retract")
    assert not side.jumps
    first, last = side.border
    inwards = slow[side.segment.rows][::-1]
    assert last == np.argmin(inwards - side.base(curve.device[side.segment.rows][::-1]))
    assert last - first > 100


def test_a_change_of_units_changes_nothing() -> None:
    curve = curve_of(DEVICE)
    one = segment_force_curve(curve)
    other = segment_force_curve(Curve("scaled", delta=curve.delta * 1e3 + 0.0007, P=curve.P * 1e-4 - 1e-13))
    for a, b in zip(one.directions, other.directions, strict=True):
        assert len(a.segment) == len(b.segment)
        assert b.touch == pytest.approx(a.touch * 1e3 + 0.0007, rel=1e-9)
        assert b.largest == pytest.approx(a.largest * 1e-4, rel=1e-6)
        assert b.base.noise == pytest.approx(a.base.noise * 1e-4, rel=1e-4)
    assert one.flags == other.flags


@pytest.mark.parametrize("kind", ["approach", "retract"])
def test_rows_at_a_standstill_are_a_pause_whatever_they_are_called(kind: str) -> None:
    """The load drifts meanwhile, at one position: as rows of a direction they were taken for relaxation."""
    curve = curve_of(DEVICE, told=True)
    found = segment_force_curve(replace(curve, segment=np.where(curve.segment == "pause", kind, curve.segment)))
    assert [part.kind for part in found.segments] == ["approach", "dwell", "retract"]
    assert [len(part) for part in found.segments] == pytest.approx([DEVICE.rows, DEVICE.pause, DEVICE.rows], abs=5)


def test_what_is_wrong_is_named() -> None:
    free = replace(DEVICE, largest=1e-6 * PULL_OFF, drag=0.0)
    assert set(examined(free, w_retract=0.0).flags) == {"no contact"}
    whole = curve_of(DEVICE)
    for load in (0.0, 1.5e-9):  # of which lines leave but round-off
        assert set(segment_force_curve(replace(whole, P=np.full(len(whole), load))).flags) == {"no contact"}
    assert set(segment_force_curve(whole.rows(np.arange(DEVICE.rows))).flags) == {"no retract"}
    assert set(segment_force_curve(whole.rows(np.arange(DEVICE.rows + 200, len(whole)))).flags) == {"no approach"}
    limited = replace(whole, P=np.minimum(whole.P, np.quantile(whole.P, 0.9)))
    assert "rows hold the same largest load" in segment_force_curve(limited).flags["saturated"]
    waves = sum(np.sin(whole.delta / length) for length in (0.8e-7, 1.5e-7, 3.1e-7))
    assert "wavy base line" in segment_force_curve(replace(whole, P=whole.P + 0.4 * PULL_OFF * waves)).flags
    rng = np.random.default_rng(3)
    walk = rng.normal(size=4000)
    assert "no force curve" in segment_force_curve(Curve("walk", delta=walk, P=rng.normal(size=4000))).flags
    deep = whole.rows(np.flatnonzero(whole.delta > 0.1e-6))
    assert "no base line" in segment_force_curve(deep).flags
    curve = curve_of(DEVICE)
    flags = segment_force_curve(replace(curve, delta=-curve.delta)).flags
    assert flags["wrong way"].endswith("has the opposite sign: indentation must be positive (--flip delta)")
    with pytest.raises(InputError, match="has a, P; jkr fit takes contact radius and load"):
        segment_force_curve(Curve("c", a=np.arange(30.0), P=np.arange(30.0)))
    with pytest.raises(InputError, match="c: holds 5 rows, at least 20 are needed to look at"):
        segment_force_curve(Curve("c", delta=np.arange(5.0), P=np.arange(5.0)))


@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-3])
@pytest.mark.parametrize("stiffness", [np.inf, 0.05])
def test_the_curved_end_of_a_prepared_retraction_is_no_base_line(noise: float, stiffness: float) -> None:
    """From the largest depth to pull-off without a free row: a fifth of the rows used to be taken for a base line."""
    a = np.linspace(0.05, 3.0, 20_000) * (9 * np.pi * W * R**2 / (8 * E_STAR)) ** (1 / 3)
    depth, load = adhesive(a, E_STAR, W, R)
    fold = int(np.argmin(depth + load / stiffness))
    delta = np.linspace(depth[-1], depth[fold], 300)
    P = np.interp(delta, depth[fold:], load[fold:])
    P += noise * np.ptp(P) * np.random.default_rng(2).normal(size=P.size)
    found = segment_force_curve(Curve("prepared", delta=delta, P=P))
    assert set(found.flags) == {"no approach", "no base line"}
    assert not found.directions[0].based


@pytest.mark.parametrize("power", [1.0, 1.5, 2.0])
@pytest.mark.parametrize(("free", "noise"), [(0.25, 0.0), (0.5, 0.02), (0.8, 1e-3)])
def test_a_straight_line_before_contact_is_a_base_line(power: float, free: float, noise: float) -> None:
    """Contact that begins with a kink in the slope, in the curvature, or as a parabola."""
    z = np.linspace(-free, 1 - free, 500)
    P = np.maximum(z, 0) ** power / (1 - free) ** power + 0.05 * z + noise * np.random.default_rng(3).normal(size=500)
    found = segment_force_curve(Curve("free", delta=z, P=P))
    assert set(found.flags) == {"no retract"}
    assert found.directions[0].based


@pytest.mark.parametrize(("string", "seed"), [(True, 0), (False, 1), (True, 2)])
def test_a_second_pull_off_is_found_however_straight_the_load_before_it(string: bool, seed: int) -> None:
    """A tether that holds half of the tension, or a string that comes to it, and breaks halfway to the far end."""
    made = record(E_STAR, R, 0.0, W, replace(DEVICE, offset=0.0, tilt=0.0, drag=0.0), seed)
    z, P, back = made["z"], made["P"], made["segment"] == "retract"
    fold = float(z[back & (P < -0.3 * PULL_OFF)].min())
    far = 0.5 * (fold + float(z.min()))
    held = np.where(back & (z < fold) & (z > far), (fold - z) / (fold - far) if string else 1.0, 0.0)
    found = segment_force_curve(Curve("tether", delta=z, P=P - 0.4 * PULL_OFF * held))
    side = found.direction("retract")
    assert "several contacts" in found.flags
    ends = [*(level.far for level in found.held.levels), *(jump.position for jump in side.jumps)]
    assert ends == pytest.approx([far, fold], abs=0.02e-6)


def test_right_contacts_are_not_level() -> None:
    kinds = ("white", "pink", "peak", "steps")
    made = [drawn(np.random.default_rng((5, i)), R, None, kind=kinds[i % 4]) for i in range(12)]
    right = [Curve("right", delta=one.columns["z"], P=one.columns["P"]) for one in made]
    assert not any("several contacts" in segment_force_curve(curve).flags for curve in right)
    # On a stiff device it comes before the pull-off, and noise hides that the load bends there.
    k, w = 0.16, 2.7e-4
    force = 1.5 * np.pi * w * R
    device = Instrument(k, 1500, far=2.8e-7, largest=3 * force, noise=0.03 * force)
    for seed in range(10):
        made = record(1.2e5, R, w / 10, w, device, seed)
        found = segment_force_curve(Curve("made", delta=made["z"] - made["P"] / k, P=made["P"], stiffness=k))
        assert "several contacts" not in found.flags


def test_rows_that_stand_alone_off_the_others_count_for_nothing() -> None:
    """Spikes to both sides, in the free rows and in contact; jumps, folds and the turn are none."""
    clean = curve_of(DEVICE)
    plain = segment_force_curve(clean)
    assert plain.spikes.size == 0
    rows, P = np.array([300, 1700, 2600, 3900]), clean.P.copy()
    P[rows] += PULL_OFF * np.array([-2.0, 1.0, -1.0, 3.0])
    found = segment_force_curve(replace(clean, P=P))
    assert found.spikes.tolist() == rows.tolist()
    assert found.flags == plain.flags
    sides = [one.direction("retract") for one in (found, plain)]
    assert sides[0].adhesion == pytest.approx(sides[1].adhesion)


def test_suction_right_after_the_turn_is_no_wrong_sign() -> None:
    """A gel whose load falls below its base line before the device has gone back by a hundredth of the way."""
    z = np.linspace(-1.0, 2.0, 3001)
    suction = 1.1 * np.exp((z - 2) / 0.005) - 0.1 * np.exp((z - 2) / 0.2)
    P = np.concatenate([np.where(z > 0, 0.25 * z**2, 0.0), suction[::-1]])
    P = P + 1e-3 * np.random.default_rng(5).normal(size=P.size)
    curve = Curve("made", delta=1e-6 * np.concatenate([z, z[::-1]]), P=1e-6 * P)
    side = segment_force_curve(curve).direction("retract")
    assert isinstance(side.adhesion, float)
    assert side.adhesion_at > 1.9e-6
    assert "wrong sign" not in segment_force_curve(curve).flags
    assert "wrong sign" in segment_force_curve(replace(curve, P=-1e-6 * P)).flags


@pytest.mark.parametrize("noise", [0.0, 3e-5, 3e-4])
def test_a_base_line_ends_at_a_jump_far_smaller_than_the_largest_load(noise: float) -> None:
    """Pressed to 300 times its jump into contact; the line went on through it as far as loads were within 0.5 %."""
    z = np.linspace(-1.0, 2.0, 6001)
    P = np.where(z > 0, 0.25 * z**2 - 1 / 300, 0.0) + noise * np.random.default_rng(4).normal(size=z.size)
    side = segment_force_curve(Curve("made", delta=1e-6 * z, P=1e-6 * (P + 0.01 * z))).direction(APPROACH)
    assert 1900 <= side.base.rows <= 2030


def test_the_step_of_readings_is_that_of_their_converter() -> None:
    """In other units, parted by round-off, and none of readings that repeat by chance or not at all."""
    rng = np.random.default_rng(5)
    levels = rng.integers(-40, 40, 500)
    assert resolution(3.2e-10 * levels + 1.7e-9) == pytest.approx(3.2e-10)
    assert resolution(3.2e-10 * np.repeat(levels, 2) * (1 + 1e-15 * rng.normal(size=1000))) == pytest.approx(3.2e-10)
    assert resolution(rng.normal(size=500)) == 0
    assert resolution(np.append(np.zeros(400), rng.normal(size=100))) == 0
    assert resolution(np.zeros(10)) == 0


def dented(rest: float, hold: int) -> Curve:
    """A load-controlled test whose unloading leaves a share ``rest`` of the depth, 160 nm under 3 mN."""
    share, rng = np.linspace(0, 1, 600), np.random.default_rng(1)
    depth, free = 1.6e-7, np.linspace(-2e-8, 0, 150)
    out = depth * (rest + (1 - rest) * share[::-1] ** (2 / 3))
    delta = np.concatenate([free, depth * share ** (2 / 3), np.full(hold, depth), out])
    P = 3e-3 * np.concatenate([0 * free, share, np.ones(hold), share[::-1]]) + 1e-7 * rng.normal(size=delta.size)
    return Curve("dented", delta=delta + 4e-10 * rng.normal(size=delta.size), P=P, t=0.005 * np.arange(delta.size))


@pytest.mark.parametrize("hold", [0, 200])
def test_parts_follow_the_load_where_unloading_leaves_a_dent(hold: int) -> None:
    found = segment_force_curve(dented(0.84, hold))
    kinds = [part.kind for part in found.segments]
    assert kinds == ["approach", *(["dwell"] if hold else []), "retract"]
    assert len(found.segments[-1]) == pytest.approx(600, abs=12)
    assert "dent of 13" in found.flags["permanent set"]


def of_kind(kind: str, seed: int) -> Curve:
    """A record with one kind of dirt."""
    made = KINDS[kind](np.random.default_rng((3, seed)))
    return Curve(kind, delta=1e-9 * made.columns["Z Piezo (nm)"], P=1e-9 * made.at.k * made.columns["Deflection (nm)"])


def parts_of(found: ForceCurve | Exception) -> object:
    """All that was found, to the last bit of every number."""
    if isinstance(found, Exception):
        return type(found), str(found)
    held = None if found.held is None else (found.held.terms, found.held.taken.tobytes())
    rows = found.spikes.tolist(), found.saturated.tolist()
    return repr((found.segments, found.directions, found.flags, rows)), held, found.curve.load.tobytes()


def test_records_examined_together_are_those_examined_alone() -> None:
    """To the last bit, whatever the others are: of equal rows and of others, with words and without, with a tether, a
    second pull-off, a detector at its limit, spikes and no contact; and some in which nothing can be examined."""
    rng, whole = np.random.default_rng(4), curve_of(DEVICE)
    z, P = whole.device, whole.load
    held = P - 0.1 * PULL_OFF * ((np.arange(P.size) > 2600) & (np.arange(P.size) < 3300))
    spiked = P.copy()
    spiked[[300, 2600]] += 3 * PULL_OFF
    right = [
        whole, curve_of(DEVICE, 0.3 * W, seed=2), curve_of(DEVICE, seed=3, told=True),
        curve_of(replace(DEVICE, rows=190), seed=4), curve_of(replace(DEVICE, rows=1999, noise=0.0), seed=5),
        replace(whole, P=held), replace(whole, P=spiked), replace(whole, P=np.minimum(P, 2 * PULL_OFF)),
        replace(whole, stiffness=DEVICE.k), of_kind("second contact", 3), dented(0.84, 200),
        whole.rows(np.arange(DEVICE.rows)), whole.rows(np.arange(17, P.size - 40)),
        Curve("no contact", delta=z, P=rng.normal(size=z.size)), Curve("walk", delta=np.cumsum(P), P=P),
        Curve("turned", delta=-z, P=P), of_kind("attraction", 0), of_kind("tether", 1), of_kind("ringing", 2),
    ]  # fmt: skip
    poisoned = [
        Curve("two rows", delta=z[:2], P=P[:2]), Curve("no load", delta=z, a=z),
        Curve("constant", delta=z, P=np.full(z.size, 2e-9)), Curve("at rest", delta=np.full(z.size, 1e-6), P=P),
        Curve("saturated", delta=z, P=np.minimum(P, P.min() + 1e-12)), Curve("huge", delta=z, P=1e300 * P),
        Curve("tiny", delta=z * 1e-200, P=P * 1e-200),
    ]  # fmt: skip
    curves = [curve for pair in zip(right, poisoned * 3, strict=False) for curve in pair]
    alone = [parts_of(found) for curve in curves for found in segment_force_curves([curve])]
    for order in (np.arange(len(curves)), rng.permutation(len(curves))):
        together = segment_force_curves([curves[i] for i in order])
        assert [parts_of(found) for found in together] == [alone[i] for i in order]
        held = [one.held for one in together if isinstance(one, ForceCurve) and one.held is not None]
        assert any(one.bends for one in held)
        assert any(one.levels for one in held)
    assert [type(found) for found in segment_force_curves(poisoned[:4])] == [InputError] * 2 + [ForceCurve] * 2
    with pytest.raises(InputError, match="2 rows"):
        segment_force_curve(poisoned[0])


@pytest.mark.parametrize(("lost", "risen", "steps"), [(60, 0.0, 0), (0, 0.5, 1)])
def test_a_load_that_rises_at_once_is_a_step_and_rows_far_apart_are_none(lost: int, risen: float, steps: int) -> None:
    """Between rows that lie far apart the load changes by the motion of the device."""
    curve = curve_of(replace(DEVICE, drag=0.0))
    row = int(np.argmax(curve.load > 2 * PULL_OFF + curve.load[:100].mean()))
    rows = np.append(np.arange(row), np.arange(row + lost, len(curve)))
    P = curve.load + risen * PULL_OFF * (np.arange(len(curve)) >= row)
    found = segment_force_curve(Curve("made", delta=curve.device[rows], P=P[rows], t=np.asarray(curve.t)[rows]))
    assert len(found.direction("approach").steps) == steps


# ---------------------------------------------------------------------- records with the dirt of instruments
TRIED = 3


def examined_file(made: Dirty, file: Path) -> ForceCurve:
    made.write(file)
    (curve,) = read(file, Reading(stiffness=math.inf) if made.rigid else Reading())
    return segment_force_curve(curve)


def flags(kind: str, tmp_path: Path) -> list[set[str]]:
    records = (KINDS[kind](np.random.default_rng((3, i))) for i in range(TRIED))
    return [set(examined_file(made, tmp_path / "record.txt").flags) for made in records]


@pytest.mark.parametrize(
    "kind", ["tether", "attraction", "van der Waals tail", "ringing", "coarse converter", "sparse"]
)
def test_dirt_that_can_be_read_raises_no_flag(tmp_path: Path, kind: str) -> None:
    assert not any(flags(kind, tmp_path))


@pytest.mark.parametrize("kind", ["saturated", "saturated tension"])
def test_a_detector_at_its_limit_is_no_second_contact(tmp_path: Path, kind: str) -> None:
    assert flags(kind, tmp_path).count({"saturated"}) == TRIED


def test_a_lever_that_rings_is_told_from_steps(tmp_path: Path) -> None:
    made = KINDS["ringing"](np.random.default_rng((3, 1)))
    found = examined_file(made, tmp_path / "record.txt")
    assert found.directions[1].ringing > 10
    assert not found.directions[1].steps


def test_the_adhesion_force_is_no_extreme_of_noise(tmp_path: Path) -> None:
    """Of noisy rows the least alone is two standard deviations too low in the mean."""
    off, errors = [], []
    for i in range(16):
        made = KINDS["large noise"](np.random.default_rng((3, 22, i)))
        retract = examined_file(made, tmp_path / "noisy.txt").direction("retract")
        if retract is None or not isinstance(retract.adhesion, float):
            continue
        off.append((retract.adhesion + float(branches(made.at, Attracted())[1][1].min())) / made.at.noise)
        errors.append(retract.adhesion_err / made.at.noise)
    assert len(off) >= 10
    assert abs(np.mean(off)) < 0.8
    assert np.mean(np.abs(off) < 2 * np.array(errors)) >= 0.7

"""What free rows hold is found, taken off and told: levels, attraction; saturated rows count for nothing."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dirty_records import KINDS
from force_curves import Instrument, equilibrium, record
from raw_records import BODY, read, usual

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.measured.curve import Curve
from jkrcli.measured.files import read as read_file
from jkrcli.measured.free_rows import (
    DECAY,
    LAWS,
    LEVEL,
    RELAXED,
    VIRTUAL,
    WAVE,
    FreeRows,
    Place,
    Side,
    Term,
    free_rows,
)
from jkrcli.measured.lockstep import alone
from jkrcli.measured.nuisance import Nuisance, with_nuisance
from jkrcli.measured.procedure import fit
from jkrcli.measured.report import estimate_words
from jkrcli.measured.result import Fit
from jkrcli.measured.segmentation import segment_force_curve

E_STAR, R, W = 500e3, 5e-6, 2e-4
PULL_OFF = 1.5 * np.pi * W * R
DEVICE = Instrument(k=0.3, rows=1000, far=2e-7, largest=4 * PULL_OFF, noise=0.004 * PULL_OFF, offset=0.0,
                    tilt=0.0, drag=0.0, pause=0)  # fmt: skip


def made(seed: int = 1, w_approach: float = W / 2) -> dict[str, np.ndarray]:
    return record(E_STAR, R, w_approach, W, DEVICE, seed)


def curve_of(parts: dict[str, np.ndarray], P: np.ndarray) -> Curve:
    return read(parts, DEVICE.k, "t", P=P)


def lost(parts: dict[str, np.ndarray]) -> int:
    """The first row after pull-off."""
    half = parts["P"].size // 2
    return half + int(np.argmax(np.diff(parts["P"][half:]))) + 1


def with_tether(share: float, length: float, seed: int = 1) -> tuple[Curve, float]:
    parts = made(seed)
    first = lost(parts)
    last = first + round(length * (parts["P"].size - first))
    P = parts["P"].copy()
    P[first:last] -= share * PULL_OFF
    return curve_of(parts, P), share * PULL_OFF


@pytest.mark.parametrize(("share", "length"), [(0.02, 0.5), (0.1, 0.3), (0.2, 0.8)])
def test_a_tether_is_a_level_with_its_place_and_size(share: float, length: float) -> None:
    curve, size = with_tether(share, length)
    found = segment_force_curve(curve)
    assert found.flags == {}
    (level,) = found.held.levels
    assert -level.size == pytest.approx(size, abs=4 * level.error)
    assert level.error < 0.1 * size
    plain = segment_force_curve(curve_of(made(), made()["P"]))
    adhesion = [one.direction("retract").adhesion for one in (found, plain)]
    assert adhesion[0] == pytest.approx(adhesion[1], abs=6 * DEVICE.noise)


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_an_attraction_is_told_with_size_and_range(share: float) -> None:
    parts, reach = made(), 6e-8
    P, half = parts["P"].copy(), parts["P"].size // 2
    size, into = share * PULL_OFF, int(np.argmin(np.diff(parts["P"][:half]))) + 1
    free = np.r_[0:into, lost(parts) : P.size]
    drawn = np.full(P.size, -size)
    touch = float(parts["z"][into])
    gap = np.maximum(touch - parts["z"][free], 0.0)
    for _ in range(50):  # the attraction deflects the device
        gap = np.maximum(touch - parts["z"][free] + size * (1 - np.exp(-gap / reach)) / DEVICE.k, 0.0)
    drawn[free] = -size * np.exp(-gap / reach)
    found = (whole := segment_force_curve(curve_of(parts, P + drawn))).held
    (bend,) = found.bends
    assert -bend.size == pytest.approx(size, rel=0.3)
    assert bend.range == pytest.approx(reach, rel=0.5)
    assert whole.curve.load != pytest.approx(P + drawn, abs=0.1 * size)
    assert whole.holding(found.of()).curve.load == pytest.approx(P + drawn, abs=1e-9 * size)


TERMS = [
    Term("exponential", (-2e-9, -16.0)), Term("power", (3e-9, -17.0), stays=False), Term(VIRTUAL, (1e-9,)),
    Term(DECAY, (-4e-9, 3.0)), Term(WAVE, (1e-9, -16.5, -2e-9), (0.0, 0.0, 0.0)), Term(RELAXED, (2e-9,), side=2),
    Term(LEVEL, (-3e-9, 5e-10), stays=False, between=(150, 180), far=0.0, near=3e-7),
    Term(LEVEL, (-3e-9, 2e-9), stays=True, between=(150, 180), far=0.0, near=3e-7),
]  # fmt: skip


@pytest.mark.parametrize("term", TERMS, ids=lambda term: f"{term.law} {term.stays}")
def test_derivatives_of_terms_are_differences(term: Term) -> None:
    x = np.concatenate([np.linspace(-1e-6, 2e-7, 100), np.linspace(2e-7, -1e-6, 100)])
    side = np.repeat([1, 2], 100)
    place = Place(np.arange(200), x, x - 1e-8, side * (x < 0), side * (x >= 0), 0.0, 1e-6, 0.1)

    def both(values: Sequence[float]) -> list[tuple[np.ndarray, list[np.ndarray]]]:
        return [term.at(place, values), *([term.moved(place, values)] if term.moves else [])]

    for i, value in enumerate(term.values):
        step = 1e-6 * abs(value)
        ends = [both([v + sign * step * (j == i) for j, v in enumerate(term.values)]) for sign in (1, -1)]
        for (_, columns), (more, _), (less, _) in zip(both(term.values), *ends, strict=True):
            difference = (more - less) / (2 * step)
            off = np.abs(columns[i] - difference).max()
            assert off <= (0.02 if term.law in LAWS else 1e-6) * np.abs(difference).max() + 1e-30


@pytest.mark.parametrize("by", [1e-6, -1e-6])
def test_an_average_keeps_limits_and_signs(by: float) -> None:
    """An upper limit of w was made a proof of adhesion, or w negative."""
    found = fit(BODY, with_tether(0.1, 0.5)[0], usual())
    assert found.dof
    limit = replace(found.estimate("w"), value=0.0, error=1e-6, low=0.0, high=2e-6)
    fitted = replace(found, estimates=(limit,))
    nuisance = Nuisance(*[None] * 2, (), {"w": by}, {}, ())  # type: ignore[arg-type]
    (item,) = with_nuisance(fitted, nuisance).estimates
    assert item.value >= 0
    assert item.low == 0
    assert item.high >= item.value


def test_terms_of_loads_and_of_directions() -> None:
    x = np.linspace(-1e-6, 2e-7, 100)
    place = Place(np.arange(100), x, x, (x < 0) * 1, (x >= 0) * 1, 0.0, 1e-6, np.inf)
    held = FreeRows(place, tuple(term for term in TERMS if term.law != RELAXED), np.zeros(0, dtype=int))
    assert held.scaled(3.0, np.inf).taken == pytest.approx(3 * held.taken, rel=1e-12)
    # A level of the retraction was told beside the approach alone, with no error.
    found = fit(BODY, with_tether(0.1, 0.5)[0], usual(segment="approach"))
    assert not found.held
    item = found.estimate("w_approach")
    assert item.value == pytest.approx(W / 2, abs=4 * item.error)


@pytest.mark.parametrize(("levels", "rests"), [(0.05, True), (0.008, False)])
def test_an_offset_is_known_to_a_share_of_a_level_where_noise_moves_none(levels: float, rests: bool) -> None:
    parts, step = made(), levels * PULL_OFF  # noise of 0.08 and 0.5 of a level
    held = segment_force_curve(curve_of(parts, np.round(parts["P"] / step) * step)).held
    assert (held is not None) == rests
    if held is not None:
        assert held.rounding == pytest.approx(step / np.sqrt(12), rel=1e-6)
        assert len(held.raised) == 2
        assert any("converter" in words for words in held.words)


def within(found: Fit, name: str, true: float) -> bool:
    """Whether an estimate lies as near to the truth as its interval and its model part say."""
    item = found.estimate(name)
    part = sum((item.model or {}).values())
    return item.low - part <= true <= item.high + part and item.high - item.low + part < 0.2 * true


def assert_near(found: Fit, share: float) -> None:
    for name, true in (("E_star", E_STAR), ("w", W), ("w_approach", W / 2)):
        assert within(found, name, true)
        assert found.value(name) == pytest.approx(true, rel=share)


@pytest.mark.parametrize("stays", [False, True])
def test_an_attraction_in_contact_is_told_from_one_that_ends_at_touch(stays: bool) -> None:
    """One of adhesion's own was taken off in contact, too: w 6 to 19 % too low beside errors of 1 %."""
    stiff = replace(DEVICE, k=30.0)  # which an attraction does not deflect
    parts = record(E_STAR, R, W / 2, W, stiff, 3)
    z, far = parts["z"], 0.15 * PULL_OFF
    back = parts["segment"] == "retract"
    free = z < np.where(back, equilibrium(E_STAR, R, W, stiff.k, stiff.largest)[0].min(), 0.0)
    gap = np.maximum(-z, 0.0)
    P = parts["P"] - far * np.where(free, np.exp(-gap / 3e-8), float(stays))
    found = fit(BODY, read(parts, stiff.k, "t", P=P), usual())
    assert found.flags == ()
    assert any(("stays in contact" if stays else "ends at touch") in words for words in found.held)
    assert_near(found, 0.03)


def test_a_direction_whose_contact_is_saturated_is_left_out(tmp_path: Path) -> None:
    """What the jump into contact rings through is left out as well, and of the approach no row in contact is left."""
    dirty = KINDS["saturated"](np.random.default_rng((73, 5, 0)))
    dirty.write(tmp_path / "ringing.txt")
    (curve,) = read_file(tmp_path / "ringing.txt")
    reason = "approach: all its rows in contact are left out"
    specimen = BODY.under(Paraboloid(dirty.at.R), 0.2 * dirty.at.R)
    found = fit(specimen, curve, usual())
    assert found.directions == f"retraction alone ({reason})"
    assert found.flags == ("saturated",)
    assert any("saturated" in words for words in found.left_out)
    assert within(found, "E_star", dirty.truth["E_star"])
    assert within(found, "w", dirty.truth["w"])
    with pytest.raises(InputError, match=reason):
        fit(specimen, curve, usual(segment="approach"))


def test_a_base_line_of_rounded_zeros_is_not_saturated() -> None:
    z = np.linspace(0, 2e-6, 60)
    P = 1e-3 * np.maximum(z - 1e-6, 0)
    assert "saturated" not in segment_force_curve(Curve("rounded", delta=z, P=P)).flags


def test_what_nobody_asked_for_or_no_row_tells() -> None:
    parts = made()
    curve = curve_of(parts, parts["P"])
    found = fit(BODY, curve, usual())
    for words in ("radius", "R^-1/2", "spring constant", "sensitivity", "--uncertain"):
        assert words in found.not_included
    calibrated = fit(BODY, curve, usual(uncertain={"stiffness": "10%", "sensitivity": "5%"}))
    assert "radius" in calibrated.not_included
    assert "spring" not in calibrated.not_included
    curve = read(made(), DEVICE.k).rows(np.arange(DEVICE.rows))
    assert "no retract" in fit(BODY, curve, usual()).flags
    assert "no retract" not in fit(BODY, curve, usual(segment="approach")).flags


def test_a_contact_much_stiffer_than_its_device_has_a_least_modulus() -> None:
    parts = record(E_STAR, R, W / 2, W, replace(DEVICE, k=0.005, far=4e-6, noise=1e-4 * PULL_OFF), 1)
    found = fit(BODY, read(parts, 0.005), usual())
    assert "too stiff" in found.flags
    item = found.estimate("E_star")
    assert (item.error, item.high, item.low < E_STAR) == (None, None, True)
    assert any("times stiffer than the cantilever" in line for line in found.warnings)
    assert estimate_words(item, 0.95).startswith("more than ")


def test_an_attraction_is_found_where_the_retraction_ends_beside_its_pull_off() -> None:
    rng, size, reach, noise = np.random.default_rng(1), 1e-10, 1e-7, 1e-12
    sides = []
    for kind, x in (("approach", np.linspace(0, 1e-6, 1000)), ("retract", np.linspace(0.99e-6, 0.9999e-6, 60))):
        y = noise * rng.normal(size=x.size) - size * np.exp((x - 1e-6) / reach)
        rows = np.arange(x.size) + 1000 * len(sides)
        sides.append(Side(kind, rows, x, y, rows[:0], 0.0, 0.0, x[:0], x[:0]))
    held = alone(free_rows(sides, 1060, np.inf))
    (bend,) = held.bends
    assert bend.size == pytest.approx(-size, abs=4 * bend.error)
    assert bend.error < 0.02 * size
    assert bend.range == pytest.approx(reach, rel=0.05)

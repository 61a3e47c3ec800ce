"""The records of ``make kinds``: their mechanics hold known identities, and fits of clean ones hold the truth."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from raw_records import BODY

from jkrcli.measured import priors
from jkrcli.measured.free_rows import DECAY, LAWS, LEVEL, RELAXED, VIRTUAL, WAVE
from jkrcli.measured.hypotheses import ALTERNATIVES
from jkrcli.measured.settings import settings_of
from studies.kinds import CLEAN, THIRD, Answer, Told, answer, drawn, line, moved, remarks, totals
from studies.kinds_records import KINDS, identities


@pytest.mark.parametrize("row", identities(), ids=lambda row: str(row[0]))
def test_the_mechanics_hold_identities(row: Sequence[float]) -> None:
    _, found, expected, allowed = row
    assert found == pytest.approx(expected, rel=allowed)


@pytest.mark.parametrize("kind", KINDS)
def test_a_record_of_each_kind_can_be_made(kind: str) -> None:
    made = drawn(kind, 1, 0)
    assert made.z.size == made.F.size
    assert np.isfinite(made.z).all()
    assert np.isfinite(made.F).all()
    assert made.F.min() < np.median(made.F[-20:]) - 3 * made.at.noise or kind in (
        "approach alone",
        "saturated pull-off",
    )


@pytest.mark.first(5)
@pytest.mark.parametrize(
    ("kind", "i", "words"),
    [
        ("three at once", 14, ["decaying drift", "interference", "attraction"]),
        ("three at once", 3, ["second contact", "repulsion", "virtual deflection"]),
        ("several tethers", 10, ["level"]),
        ("second contact", 5, ["stretched in contact"]),
        ("hold", 10, ["relaxation in the dwell"]),
        ("three at once", 4, ["decaying drift", "attraction"]),
        ("interference", 0, ["interference"]),
        ("decaying drift", 14, ["decaying drift"]),
    ],
)  # fmt: skip
def test_what_acts_beside_the_contact_is_named_and_leaves_the_truth(kind: str, i: int, words: Sequence[str]) -> None:
    """Several at once left E* 1 to 40 % off, a second contact w 2 to 4 %, a hold w_approach 23 to 42 %."""
    found = answer(kind, 3, i)
    assert found.status == "fitted"
    assert max(one.off for one in found.told.values()) < 1
    assert all(word in found.words for word in words)


@pytest.mark.parametrize(("kind", "seed", "i"), [(CLEAN, 13, 8), ("charge", 17, 4)])
def test_records_with_two_valleys_or_two_causes_hold_the_truth(kind: str, seed: int, i: int) -> None:
    """Noise hid where contact begins, and w_approach ended at 0; an attraction was no rival of a virtual deflection,
    by which E* was 4.7 % off, 3.1 half-widths."""
    found = answer(kind, seed, i)
    assert set(found.told) == {"E_star", "w", "w_approach"}
    assert max(one.off for one in found.told.values()) < 1


def test_an_answer_far_off_without_a_flag_is_silent() -> None:
    told = {"w": Told(1.0, 0.05, 0.05, 0.02, 0.6)}
    found = {kind: [Answer(status, "", 1.0, "", told)] for kind, status in ((CLEAN, "fitted"), ("drag", "flagged"))}
    assert [one.silent for answers in found.values() for one in answers] == [True, False]
    assert "SILENT" in remarks(found[CLEAN])[0]
    assert "silent 1; model part E*      - w  2.00%" in line(CLEAN, found[CLEAN])
    assert "accused: 0 of 1 clean ones" in totals(found)


# ---------------------------------------------------------------------- what is known before
@pytest.mark.first(2)
@pytest.mark.parametrize(
    ("kind", "widths"),
    [("clean", 0.5), ("tether", 2.0), ("clean", 2.0), ("tether", 0.5), ("charge", 0.5), ("charge", 2.0)],
)
def test_halving_and_doubling_all_widths_moves_no_result(kind: str, widths: float) -> None:
    shares = moved(kind, 3, 1, widths)
    assert shares.keys() >= {"E_star", "w"}
    assert max(shares.values()) < THIRD
    assert priors.WIDTHS == 1


@pytest.mark.first(1)
@pytest.mark.parametrize(("seed", "i"), [(11, 1), (12, 3)])
def test_what_is_nearly_as_likely_is_averaged_over(seed: int, i: int) -> None:
    """Of brushes: by the likeliest hypothesis alone E* moved by 0.86 half-widths, with normal priors by 0.45."""
    assert max(moved("brush", seed, i, 0.5).values()) < THIRD / 2


def test_widths_and_names_are_those_of_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    # Odds are those of 1 to 20 of a longer range; alternatives and loads beside the contact are called as they are.
    assert priors.PRIORS[priors.RANGE].cost == pytest.approx(2 * math.log(20), rel=2e-3)
    assert {*LAWS, LEVEL, VIRTUAL, DECAY, WAVE, RELAXED} < priors.PRIORS.keys()
    assert {priors.RANGE, priors.LONG, priors.TENSION} < {one.name for one in ALTERNATIVES}
    assert all(one.prior.limits[0] < one.prior.limits[1] for one in ALTERNATIVES)
    told = settings_of(BODY, uncertain=[("range", "3 nm")])
    before = [one.width for one in priors.PRIORS.values()]
    assert settings_of(BODY).longest_range == 10e-9
    monkeypatch.setattr(priors, "WIDTHS", 2.0)
    assert [one.width for one in priors.PRIORS.values()] == [2 * one for one in before]
    assert (settings_of(BODY).longest_range, told.longest_range) == (20e-9, 3e-9)

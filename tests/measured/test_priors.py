"""What is known of hypotheses before the data hardly moves a result."""

import math

import pytest
from raw_records import BODY

from jkrcli.measured import priors
from jkrcli.measured.free_rows import DECAY, LAWS, LEVEL, RELAXED, VIRTUAL, WAVE
from jkrcli.measured.hypotheses import ALTERNATIVES
from jkrcli.measured.settings import Settings, settings_of
from studies.kinds import THIRD, moved


@pytest.mark.parametrize("kind", ["clean", "tether", pytest.param("charge", marks=pytest.mark.slow)])
@pytest.mark.parametrize("widths", [0.5, 2.0])
def test_halving_and_doubling_all_widths_moves_no_result(kind: str, widths: float) -> None:
    """By less than a third of its half-width, on made records."""
    shares = moved(kind, 3, 1, widths)
    assert shares.keys() >= {"E_star", "w"}
    assert max(shares.values()) < THIRD
    assert priors.WIDTHS == 1


@pytest.mark.parametrize(("seed", "i"), [(11, 1), (12, 3)])
def test_what_is_nearly_as_likely_is_averaged_over(seed: int, i: int) -> None:
    """Of brushes: by the likeliest hypothesis alone E* moved by 0.86 half-widths, with normal priors by 0.45."""
    assert max(moved("brush", seed, i, 0.5).values()) < THIRD / 2


def test_widths_are_scaled_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """In settings, too: what a user tells is no prior."""
    told = settings_of(BODY, uncertain=[("range", "3 nm")])
    before = [one.width for one in priors.PRIORS.values()]
    assert settings_of(BODY).longest_range == 10e-9
    monkeypatch.setattr(priors, "WIDTHS", 2.0)
    assert [one.width for one in priors.PRIORS.values()] == [2 * one for one in before]
    assert isinstance(told, Settings)
    assert (settings_of(BODY).longest_range, told.longest_range) == (20e-9, 3e-9)


def test_the_table_is_of_what_there_is() -> None:
    """Odds are those of 1 to 20 of a longer range; alternatives and loads beside the contact are called as they are."""
    assert priors.PRIORS[priors.RANGE].cost == pytest.approx(2 * math.log(20), rel=2e-3)
    assert {*LAWS, LEVEL, VIRTUAL, DECAY, WAVE, RELAXED} < priors.PRIORS.keys()
    assert {priors.RANGE, priors.LONG, priors.TENSION} < {one.name for one in ALTERNATIVES}
    assert all(one.prior.limits[0] < one.prior.limits[1] for one in ALTERNATIVES)

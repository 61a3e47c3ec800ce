"""The picture of what wrong models leave."""

import numpy as np
import pytest

from studies import record_rivals, residuals
from studies.wrong_kinds import WRONG


@pytest.fixture(autouse=True)
def judged_once(monkeypatch):
    """What the study puts around the scores is taken off again."""
    monkeypatch.setattr(record_rivals.record, "record_alternatives", record_rivals.record.record_alternatives)
    record_rivals.timed_scores()


@pytest.mark.slow
def test_the_right_model_leaves_the_noise_and_a_layer_tens_of_it():
    right, layer = (residuals.panel(kind) for kind in ("the right model", "layer as half-space"))
    for one in (right, layer):
        assert list(one.rows) == ["approach", "retract"]
    assert right.said.endswith(": not rejected")
    assert layer.said.endswith(": rejected")
    left = np.concatenate([off for _, off in right.rows.values()])
    assert left.std() == pytest.approx(1, abs=0.1)
    assert max(np.abs(off).max() for _, off in layer.rows.values()) > 20
    figure = residuals.residuals_figure([right, layer])
    assert [axes.get_title().split("\n")[0] for axes in figure.axes[:2]] == [right.title, layer.title]


def test_ten_wrong_models_are_shown():
    assert len(set(residuals.SHOWN)) == 10
    assert set(residuals.SHOWN) <= set(WRONG)

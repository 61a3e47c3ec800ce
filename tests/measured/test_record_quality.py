"""Good records against bad ones of a generator that nothing was tuned on: what quality and flags make of them."""

from __future__ import annotations

import numpy as np
import pytest
from messy_records import BAD, Motion, Sample, bad, good
from test_fit_record import BODY, R, usual

from jkrcli.base.errors import InputError, SolveError
from jkrcli.measured.curve import Curve
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit

Record = tuple[Sample, Motion, np.ndarray]


def fitted(rng: np.random.Generator, made: Record) -> Fit | None:
    """The fit of a record with or without words on its segments; None: unusable."""
    held, moved, P = made
    words = np.where(moved.up, "approach", "retract") if rng.random() < 0.5 else None
    try:
        return fit(BODY, Curve("made", delta=moved.z - P / held.k, P=P, stiffness=held.k, segment=words), usual())
    except (InputError, SolveError):
        return None


def judged(seed: int, count: int) -> tuple[list[float], list[float], int, int]:
    """Quality of ``count`` good records and of as many bad ones; how many good ones are flagged, how many bad ones are
    not."""
    rng = np.random.default_rng(seed)
    fine = [fitted(rng, good(rng, R)) for _ in range(count)]
    wrong = [fitted(rng, bad(rng, R, kind)) for kind in BAD for _ in range(count // len(BAD))]
    flagged = sum(item is None or bool(item.flags) for item in fine)
    silent = sum(item is not None and not item.flags for item in wrong)
    return [quality(item) for item in fine], [quality(item) for item in wrong], flagged, silent


def quality(found: Fit | None) -> float:
    """0 of a record that cannot be used, or whose readings could be fitted only as they are: those are flagged."""
    return 0.0 if found is None or found.grade is None else found.grade.quality


def area(good: list[float], bad: list[float]) -> float:
    """The area under the curve: how often a good record has the higher quality."""
    one, other = np.array(good)[:, None], np.array(bad)
    return float(np.mean((one > other) + 0.5 * (one == other)))


@pytest.mark.slow
def test_quality_of_good_and_bad_records() -> None:
    fine, wrong, flagged, silent = judged(11, 5)
    assert area(fine, wrong) >= 0.95
    assert flagged == 0
    assert silent == 0


@pytest.mark.slow
def test_quality_of_two_hundred_good_and_two_hundred_bad_records() -> None:
    fine, wrong, flagged, silent = judged(5, 200)
    assert area(fine, wrong) >= 0.95
    assert flagged <= 10
    assert silent <= 2

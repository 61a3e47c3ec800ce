"""Good records against bad ones of a generator that nothing was tuned on: what quality and grade make of them."""

import math

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


HELD = ("saturation", "several contacts")  # kinds of bad records whose other rows determine E* and w


def judged(seed: int, count: int) -> tuple[list[float], list[float], int, int]:
    """Quality of ``count`` good records and of as many bad ones but ``HELD``; how many good ones are doubted, how many
    are believed with E* or w more than three half-widths and 1 % off."""
    rng = np.random.default_rng(seed)
    made = [("", good(rng, R)) for _ in range(count)]
    made += [(kind, bad(rng, R, kind)) for kind in BAD for _ in range(count // len(BAD))]
    found = [(kind, record, fitted(rng, record)) for kind, record in made]
    silent = sum(item is not None and believed(item) and not held(item, record[0]) for _, record, item in found)
    doubted = sum(not kind and (item is None or not believed(item)) for kind, _, item in found)
    fine, wrong = ([quality(item) for kind, _, item in found if right(kind)] for right in (
        lambda kind: not kind, lambda kind: kind and kind not in HELD))  # fmt: skip
    return fine, wrong, doubted, silent


def believed(found: Fit) -> bool:
    return found.grade is not None and found.grade.believed


def held(found: Fit, sample: Sample) -> bool:
    """Whether E* and w, where they are found, are near those of the ``sample``."""
    near, truths = [], {"E_star": sample.E_star, "w": sample.w}
    for item in (item for item in found.estimates if item.name in truths):
        truth = truths[item.name]
        if item.low is not None and item.high is not None:
            half = (item.high - item.low) / 2 + math.hypot(*(item.model or {}).values())
            near.append(abs(item.value - truth) < max(3 * half, 0.01 * truth))
    return all(near)


def quality(found: Fit | None) -> float:
    """0 of a record that cannot be used, or whose readings could be fitted only as they are: those are flagged."""
    return 0.0 if found is None or found.grade is None else found.grade.quality


def area(good: list[float], bad: list[float]) -> float:
    """The area under the curve: how often a good record has the higher quality."""
    one, other = np.array(good)[:, None], np.array(bad)
    return float(np.mean((one > other) + 0.5 * (one == other)))


@pytest.mark.slow
def test_quality_of_good_and_bad_records() -> None:
    fine, wrong, doubted, silent = judged(11, 5)
    assert area(fine, wrong) >= 0.95
    assert doubted <= 1  # E* of one is known to 48 %
    assert silent == 0


@pytest.mark.slow
def test_quality_of_two_hundred_good_and_two_hundred_bad_records() -> None:
    fine, wrong, doubted, silent = judged(5, 200)
    assert area(fine, wrong) >= 0.95
    assert doubted <= 10
    assert silent <= 2

"""What is no fault of a record raises no flag, and what is one raises its own: by records with dirt."""

import math
from pathlib import Path

import numpy as np
import pytest
from dirty_records import KINDS, Attracted, Dirty, branches

from jkrcli.measured.curve import Reading
from jkrcli.measured.files import read
from jkrcli.measured.segmentation import ForceCurve, segment_force_curve

TRIED = 3


def examined(made: Dirty, file: Path) -> ForceCurve:
    made.write(file)
    (curve,) = read(file, Reading(stiffness=math.inf) if made.rigid else Reading())
    return segment_force_curve(curve)


def flags(kind: str, tmp_path: Path) -> list[set[str]]:
    records = (KINDS[kind](np.random.default_rng((3, i))) for i in range(TRIED))
    return [set(examined(made, tmp_path / "record.txt").flags) for made in records]


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
    found = examined(made, tmp_path / "record.txt")
    assert found.directions[1].ringing > 10
    assert not found.directions[1].steps


def test_the_adhesion_force_is_no_extreme_of_noise(tmp_path: Path) -> None:
    """Of noisy rows the least alone is two standard deviations too low in the mean."""
    off, errors = [], []
    for i in range(16):
        made = KINDS["large noise"](np.random.default_rng((3, 22, i)))
        retract = examined(made, tmp_path / "noisy.txt").direction("retract")
        if retract is None or not isinstance(retract.adhesion, float):
            continue
        off.append((retract.adhesion + float(branches(made.at, Attracted())[1][1].min())) / made.at.noise)
        errors.append(retract.adhesion_err / made.at.noise)
    assert len(off) >= 10
    assert abs(np.mean(off)) < 0.8
    assert np.mean(np.abs(off) < 2 * np.array(errors)) >= 0.7

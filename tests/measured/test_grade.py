"""Grades of fitted force curves by sizes: what has none makes no doubt, what has one is said with it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from raw_records import BODY, usual
from test_fit_record import TRUE, cycled

from jkrcli.measured.archive import FITTED, status_of
from jkrcli.measured.curve import Curve
from jkrcli.measured.grade import GOOD, LEFT_OUT, LIMITS, USABLE
from jkrcli.measured.procedure import fit
from jkrcli.measured.report import columns, fit_words, summary
from jkrcli.measured.result import Fit
from jkrcli.measured.segmentation import segment_force_curve


def fitted(curve: Curve, **options: str) -> Fit:
    return fit(BODY, curve, usual(**options))


def way_back(curve: Curve) -> Curve:
    return curve.rows(np.arange(int(np.argmax(curve.P)), len(curve)))


def test_one_direction_alone_is_no_doubt() -> None:
    found = fitted(way_back(cycled(1)))
    assert "no approach" in found.flags
    assert found.grade.word in (GOOD, USABLE)
    assert status_of(found) == FITTED
    assert abs(found.value("E_star") / TRUE["E_star"] - 1) < found.grade.sizes["E_star_error"]


def test_readings_without_noise_are_no_misfit_and_grade_and_sizes_are_written() -> None:
    found = fitted(cycled(1, noise=1e-7))
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
    found = fitted(replace(curve, P=np.where(back, 1.1 * curve.P, curve.P)))
    item = found.estimate("E_star")
    assert found.grade.sizes["E_star_by_direction"] > 0.05
    assert (item.model or {})[LEFT_OUT] > 0.05 * item.value
    assert abs(item.value / TRUE["E_star"] - 1.05) < 2 * found.grade.sizes["E_star_error"]


def test_noise_is_no_wave() -> None:
    curve = cycled(1)
    noise = 0.2 * np.ptp(curve.P) * np.random.default_rng(3).normal(size=len(curve))
    assert "wavy base line" not in segment_force_curve(replace(curve, P=curve.P + noise)).flags


def test_a_device_whose_stiffness_errs_has_loads_that_err() -> None:
    """A deflection sensitivity 15 % too large: w is as much too large, E* and w are known no better."""
    curve = cycled(1)
    P = 1.15 * curve.P
    found = fitted(replace(curve, P=P, delta=curve.device - P / curve.stiffness))
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
    found = fitted(replace(curve, P=curve.P + lobes))
    assert "misfit" in found.flags
    assert "model rejected" not in found.flags
    item = found.estimate("E_star")
    part = (item.model or {})["misfit"]
    assert part > 4 * (item.high - item.low) / 2
    assert abs(item.value / TRUE["E_star"] - 1) < part / item.value


def test_free_rows_off_their_line_are_misfit_too() -> None:
    """A tooth of 5 % of the load on the free rows: 1 % of it in their root mean square."""
    curve = cycled(1)
    place = np.arange(len(curve)) / int(np.argmax(curve.P))
    tooth = 0.05 * float(curve.P.max()) * np.maximum(1 - np.abs(place - 0.25) / 0.05, 0.0)
    sizes = [fitted(one, segment="approach").sizes or {} for one in (curve, replace(curve, P=curve.P + tooth))]
    assert sizes[0]["misfit"] < 0.003 < 0.005 < sizes[1]["misfit"]

"""The study of chosen numbers: what moves a result is told, what nothing depends on moves none."""

from __future__ import annotations

import csv
import importlib
from pathlib import Path

import pytest

from studies import constants, constants_results
from studies.tuning import Knob

CHEAP = ("half-space by layered", "layer by layered", "gel by layered", "transverse by layered", "table", "loads")
SAMPLE = {
    "jkrcli.methods.layered.spectrum": ("small", "small_transverse"),
    "jkrcli.methods.layered.contact": ("refinements", "most_nodes", "most_flops"),
    "jkrcli.bodies.indenters.table": ("pointed", "few"),
}


@pytest.fixture(autouse=True)
def _cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants, "RESULTS", {name: constants_results.RESULTS[name] for name in CHEAP})
    monkeypatch.setattr(constants, "SHIPPED", None)


def knob(module: str, field: str) -> Knob:
    held = vars(importlib.import_module(module))
    (name,) = (name for name in held if name.endswith("TUNING") and hasattr(held[name], field))
    return Knob(module, name, field, getattr(held[name], field))


def test_no_result_depends_on_a_sample_of_choices() -> None:
    for module, fields in SAMPLE.items():
        for field in fields:
            found = constants.moved(knob(module, field))
            assert (found.verdict, bool(found.read)) == ("nothing moves", True), found


def test_numbers_that_stand_alone_are_varied_wherever_they_are_known() -> None:
    (same,) = (item for item in constants.alone(["base.numerics"], "choice:") if item.name == "SAME")
    radii = importlib.import_module("jkrcli.methods.radii")
    with constants.varied(same, 1e-3):
        assert (radii.SAME, importlib.import_module(same.module).SAME) == (1e-3, 1e-3)
    assert radii.SAME == same.shipped
    assert constants.moved(same).verdict == "nothing moves"


def test_a_number_that_results_depend_on_is_told_with_where() -> None:
    found = constants.moved(knob("jkrcli.methods.integral.fredholm", "most_nodes"))
    assert found.verdict == "moves"
    assert found.where.startswith("loads: P[")
    assert found.cost[0] > 0


def test_numbers_are_as_shipped_after_a_study_and_after_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    held = knob("jkrcli.methods.layered.spectrum", "small")
    tuning = getattr(importlib.import_module(held.module), held.name)
    with constants.varied(held, 7.0):
        assert tuning.small == 7.0
    assert tuning.small == held.shipped
    constants.shipped()
    monkeypatch.setitem(constants.RESULTS, "gel by layered", lambda: 1 / 0)
    found = constants.moved(held)
    assert (tuning.small, type(tuning).__name__) == (held.shipped, "MinorsTuning")
    assert found.verdict == "refuses"


@pytest.mark.slow
def test_the_study_writes_a_row_per_number(study) -> None:
    outcome = study("constants", "layered.contact", "--workers", 1)
    assert (outcome.code, outcome.err) == (0, "")
    with Path("constants.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["field"] for row in rows} == {"refinements", "most_nodes", "most_flops", "narrower"}
    assert outcome.out.splitlines()[-1] == "moves: 0, refuses: 0, nothing moves: 3, not read: 1"

"""The study of chosen numbers: what moves a result is told, what nothing depends on moves none."""

import csv
import importlib
from pathlib import Path

import pytest

from studies import constants, constants_results
from studies.tuning import Knob

CHEAP = ("layer by layered", "table", "loads")
SAMPLE = {
    "jkrcli.methods.layered.spectrum": "MINORS_SMALL",
    "jkrcli.methods.layered.contact": "LAYERED_REFINEMENTS",
    "jkrcli.bodies.indenters.table": "TABLE_POINTED",
}


@pytest.fixture(autouse=True)
def _cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants, "RESULTS", {name: constants_results.RESULTS[name] for name in CHEAP})
    monkeypatch.setattr(constants, "SHIPPED", None)


def knob(module: str, name: str) -> Knob:
    return Knob(module, name, getattr(importlib.import_module(module), name))


@pytest.mark.slow
def test_no_result_depends_on_a_sample_of_choices() -> None:
    for module, name in SAMPLE.items():
        found = constants.moved(knob(module, name))
        assert (found.verdict, bool(found.read)) == ("nothing moves", True), found


def test_a_number_that_results_depend_on_is_told_with_where() -> None:
    found = constants.moved(knob("jkrcli.methods.integral.fredholm", "QUADRATURE_MOST_NODES"))
    assert found.verdict == "moves"
    assert found.where.startswith("loads: P[")
    assert found.cost[0] > 0


@pytest.mark.slow
def test_the_study_writes_a_row_per_number(study) -> None:
    outcome = study("constants", "layered.contact", "--workers", 1)
    assert (outcome.code, outcome.err) == (0, "")
    with Path("constants.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["constant"] for row in rows} >= {"LAYERED_REFINEMENTS", "LAYERED_MOST_NODES", "LAYERED_MOST_FLOPS"}
    assert outcome.out.splitlines()[-1].startswith("moves: 0, refuses: 0, nothing moves: ")

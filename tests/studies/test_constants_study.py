"""The study of chosen numbers: what moves a result is told, what nothing depends on moves none."""

import importlib

import pytest

from studies import constants, constants_results
from studies.tuning import Knob

CHEAP = ("layer by layered", "table", "loads")


@pytest.fixture(autouse=True)
def _cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants, "RESULTS", {name: constants_results.RESULTS[name] for name in CHEAP})
    monkeypatch.setattr(constants, "SHIPPED", None)


def knob(module: str, name: str) -> Knob:
    return Knob(module, name, getattr(importlib.import_module(module), name))


def test_a_number_that_results_depend_on_is_told_with_where() -> None:
    found = constants.moved(knob("jkrcli.methods.integral.fredholm", "QUADRATURE_MOST_NODES"))
    assert found.verdict == "moves"
    assert found.where.startswith("loads: P[")
    assert found.cost[0] > 0

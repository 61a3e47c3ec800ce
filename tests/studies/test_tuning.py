"""The study of tuned numbers: which are found, that varying them reaches the algorithm, and what is written."""

import csv
import sys
from pathlib import Path
from types import ModuleType

import pytest

from jkrcli.methods.integral import fredholm
from jkrcli.methods.layered import solver
from studies import constants, constants_results, tuning

MADE_UP = """
MADE_UP_NODES = 40  # tuned on nothing, by `make tuning`
# A share of it; tuned likewise.
MADE_UP_SHARE = 0.5
MADE_UP_FEW = 3  # tuned likewise
MADE_UP_LIMIT = 9.0  # choice: a guard
MADE_UP_ORDER = 2  # theory: Eq. 13
MADE_UP_NAMES = ("a",)  # tuned, but no number
"""


@pytest.fixture(name="module")
def _module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A module of the package with a tuning set of its own, found where ``layered`` stands."""
    path = tmp_path / "made_up.py"
    path.write_text(MADE_UP)
    monkeypatch.setattr(
        "jkrcli.methods.layered.__path__", [*sys.modules["jkrcli.methods.layered"].__path__, str(tmp_path)]
    )
    monkeypatch.delitem(sys.modules, "jkrcli.methods.layered.made_up", raising=False)
    import jkrcli.methods.layered.made_up as found

    yield found
    del sys.modules["jkrcli.methods.layered.made_up"]


def test_tuned_numbers_are_found_by_their_comments(module: ModuleType) -> None:
    found = tuning.knobs(["layered.made-up"])
    assert {knob.name: knob.values for knob in found} == {
        "MADE_UP_NODES": (20, 80),
        "MADE_UP_SHARE": (0.25, 1.0),
        "MADE_UP_FEW": (2, 4),
    }


def test_a_varied_number_reaches_all_who_hold_it(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver, "MADE_UP_NODES", module.MADE_UP_NODES, raising=False)
    knob = tuning.knobs(["made_up"])[0]
    with tuning.varied(knob, 80):
        assert (module.MADE_UP_NODES, solver.MADE_UP_NODES) == (80, 80)
    assert (module.MADE_UP_NODES, solver.MADE_UP_NODES) == (40, 40)


@pytest.mark.slow
def test_the_study_writes_a_row_per_value_and_body(study, module: ModuleType) -> None:
    outcome = study("tuning", "made_up", "--quick", "--workers", 1)
    assert (outcome.code, outcome.err) == (0, "")
    with Path("tuning.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["constant"] for row in rows] == [
        f"MADE_UP_{name}" for name in ("NODES", "NODES", "SHARE", "SHARE", "FEW", "FEW")
    ]
    assert {(row["algorithm"], row["body"], row["method"]) for row in rows} == {
        ("methods.layered.made_up", "coating", "layered")
    }
    assert all(float(row["error"]) == float(row["shipped_error"]) < 1e-6 for row in rows)  # nothing depends on them
    assert len(outcome.out.splitlines()) == 1 + len(rows)
    assert study("tuning", "made_up", "--quick", "--workers", 1).code == 0  # its own file is replaced


# ---------------------------------------------------------------------- chosen numbers
def test_a_number_that_results_depend_on_is_told_with_where(monkeypatch: pytest.MonkeyPatch) -> None:
    cheap = {name: constants_results.RESULTS[name] for name in ("layer by layered", "table", "loads")}
    monkeypatch.setattr(constants, "RESULTS", cheap)
    monkeypatch.setattr(constants, "SHIPPED", None)
    name = "QUADRATURE_MOST_NODES"
    found = constants.moved(tuning.Knob(fredholm.__name__, name, getattr(fredholm, name)))
    assert found.verdict == "moves"
    assert found.where.startswith("loads: P[")
    assert found.cost[0] > 0

"""The failure map: no cell is silently wrong; contact that is no disc is said so."""

import csv
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stopwatch import takes_less_than

from jkrcli.base.executors import executor
from jkrcli.bodies.indenters import PowerLaw
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Specimen
from jkrcli.methods.integral.density import disc_warnings
from jkrcli.methods.layered.contact import LayeredContact
from jkrcli.methods.layered.solver import Layered, surface_profile
from jkrcli.methods.protocol import Forecast
from jkrcli.series import ErrorBudget, Series, Solution
from studies import failures_judge
from studies.failures_cells import Cell
from studies.failures_judge import BUGS, CRASHED, REFUSED, RIGHT, SAID, SILENT, TOO_SLOW, Verdict, judge
from studies.watchdog import TooSlowError, cpu_limit

PLAIN = Cell("layered", "paraboloid", "bonded", 0.4, 2.0, 1.0, 0.1, 30, 0, 20, 0.0, 1.0, 1.0, 0)


class Wrong:
    def __init__(self, factor: float, stated: float, warnings: tuple[str, ...] = ()):
        self.factor, self.stated, self.warnings = factor, stated, warnings

    def refusal(self, problem: Problem) -> None:
        return None

    def forecast(self, problem: Problem) -> Forecast:
        return Forecast(0.01, 1.0, self.stated)

    def __call__(self, problem: Problem) -> Solution:
        exact = Layered()(problem).series
        P = exact.P * self.factor
        series = Series(exact.a, exact.delta, P, exact.S, exact.dS, errors={"P": P * self.stated})
        return Solution(problem, series, ErrorBudget(self.stated, 0.0, 0.0), "wrong", warnings=self.warnings)


@pytest.mark.parametrize(
    ("factor", "stated", "warnings", "outcome"),
    [
        (1.0, 1e-8, (), RIGHT),
        (1.001, 1e-2, (), RIGHT),  # within what it states
        (1.001, 1e-4, (), SILENT),  # ten times what it states
        (1.001, 1e-4, ("mind the gap",), SAID),
    ],
)
def test_a_wrong_method_is_found_out(monkeypatch, factor: float, stated: float, warnings, outcome: str) -> None:
    monkeypatch.setattr(failures_judge, "method_of", lambda cell: Wrong(factor, stated, warnings))
    verdict = judge(PLAIN)
    assert verdict.outcome == outcome
    assert verdict.error == pytest.approx(factor - 1, abs=1e-6)


def test_an_exception_that_is_not_ours_is_a_crash(monkeypatch) -> None:
    def broken(cell: Cell) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(failures_judge, "method_of", broken)
    verdict = judge(PLAIN)
    assert (verdict.outcome, verdict.words) == (CRASHED, "ZeroDivisionError: by zero")


def endless(cell: Cell) -> None:
    while True:
        pass


def test_a_cell_that_does_not_end_is_too_slow(monkeypatch, tuned) -> None:
    tuned("studies.failures_judge.JUDGE_LIMIT", 0.2)
    monkeypatch.setattr(failures_judge, "method_of", endless)
    with takes_less_than(2):  # the limit, and the exact solution
        verdict = judge(PLAIN)
    assert (verdict.outcome, verdict.words) == (TOO_SLOW, "took more than 0.2 CPU s")


def test_the_limit_counts_work_and_not_waiting() -> None:
    with cpu_limit(0.05):
        time.sleep(0.2)
    with pytest.raises(TooSlowError), cpu_limit(0.05):
        endless(PLAIN)


def verdicts_on(cells: Sequence[Cell]) -> list[Verdict]:
    with executor(1) as pool:
        return failures_judge.failures(cells, pool)


@pytest.mark.slow
def test_no_cell_of_any_method_is_silently_wrong_and_at_most_half_are_refused(seed: int) -> None:
    verdicts = verdicts_on(failures_judge.random_cells(300, seed))
    assert [v for v in verdicts if v.outcome in BUGS] == []
    assert sum(verdict.outcome == REFUSED for verdict in verdicts) <= len(verdicts) / 2


def lifting(largest: float) -> Problem:
    """f = B r^4, flat at its tip, on a coating ten times stiffer than the half-space below it (h = 1 um)."""
    specimen = Specimen((Layer(Elastic(1e9, 0.3), 1e-6),), HalfSpace(Elastic(1e8, 0.3)))
    return Problem(PowerLaw(2.5e15, 4.0), specimen, Loading("radius", largest, 10))


def test_a_contact_that_lifts_off_in_the_middle_is_said_so() -> None:
    """The pressure in the middle is positive at a = h/2 and negative at 2 h: read from the pressure itself."""
    for a, pulls in ((0.5e-6, False), (2e-6, True)):
        middle = surface_profile(lifting(a), a, 0.0, np.array([0.03 * a])).pressure[0]
        assert (middle < 0) == pulls
        warnings = Layered()(lifting(a)).warnings
        assert len(warnings) == pulls
    assert "tension in the middle of the contact," in warnings[0]
    assert "not a full disc" in warnings[0]


def test_bodies_that_grow_stiffer_with_depth_are_not_searched() -> None:
    """Nothing bends like a plate there, and the pressure is positive."""
    problem = lifting(2e-6)
    stiffer = replace(problem, specimen=Specimen(problem.specimen.layers, HalfSpace(Elastic(1e10, 0.3))))
    contact = LayeredContact(stiffer.indenter, stiffer.specimen)
    assert disc_warnings(contact, stiffer.specimen, 2e-6, contact.spectrum.kernel) == ()
    assert surface_profile(stiffer, 2e-6, 0.0).pressure.min() > 0


def test_the_study_writes_table_and_counts(study) -> None:
    words = ("failures", "--cells", 5, "--seed", 3, "--methods", "closed-form", "--no-plots", "--json")
    outcome = study(*words, "-o", "out")
    data = json.loads(outcome.out)
    assert data["format"] == "jkr-failures"
    assert sum(data["counts"]["closed-form"].values()) == 5
    with Path("out/failures.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:4] == ["method", "outcome", "nu", "a_over_h"]
    assert len(rows) == 5
    assert all(len(row) == len(header) for row in rows)
    assert study(*words, "-o", "out").out == outcome.out  # ours are replaced, and a seed gives the same cells


def test_the_study_exits_with_one_where_a_cell_is_silently_wrong(study, monkeypatch) -> None:
    monkeypatch.setattr(failures_judge, "method_of", lambda cell: Wrong(1.1, 1e-6))
    outcome = study("failures", "--cells", 3, "--seed", 3, "--methods", "closed-form", "--no-plots")
    assert outcome.code == 1
    assert "  silent: P errs by 0.1, stated 1.1e-06: Cell(" in outcome.out

"""Cases of a sweep that fail: a row with the reason, and the rest goes on."""

import json
import shlex
from pathlib import Path

import pytest
from sweep_files import AXIS, BAD, HALF_SPACE, TWO_LAYERS, axis, rows

from jkrcli.many import sweep_plan as plan

pytestmark = pytest.mark.usefixtures("no_pictures")


def test_one_bad_case_never_stops_the_rest(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + BAD)
    outcome = jkr("sweep", "s.toml", "-o", "r")
    table = rows(tmp_path / "r" / "table.csv")
    beyond = [row for row in table if float(row["specimen.half_space.nu"]) > 0.5]
    assert outcome.code == 0
    assert 0 < len(beyond) < 40
    assert [row for row in table if row["status"] == "failed"] == beyond
    nu = beyond[0]["specimen.half_space.nu"]
    reason = f"specimen.half_space.nu: must be > -1 and <= 0.5, got {nu}"
    assert beyond[0]["reason"] == reason
    assert beyond[0]["pull_off.load.P_N"] == ""
    assert outcome.err.splitlines()[-1] == (f"jkr: warning: {len(beyond)} cases failed, the first because: {reason}")
    failed = rows(tmp_path / "r" / "failed.csv")
    assert [row["case"] for row in failed] == [row["case"] for row in beyond]
    again = jkr(*shlex.split(failed[0]["command"])[1:], "--json")
    assert json.loads(again.out)["reason"] == reason


def test_a_fault_in_a_library_is_a_reason_too(jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = plan.solved_once

    def faulty(body, method, kept):
        if body.specimen.surface.nu == 0.3:
            raise ZeroDivisionError("by zero")
        return plain(body, method, kept)

    monkeypatch.setattr(plan, "solved_once", faulty)
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    table = rows(tmp_path / "r" / "table.csv")
    assert [row["status"] for row in table] == ["ok", "failed", "ok"]
    assert table[1]["reason"] == "unexpected ZeroDivisionError: by zero"
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")  # what failed is not tried again unasked
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok", "failed", "ok"]
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1", "--retry-failed")
    assert "1 failed cases are tried again\njkr: 2 of 3 cases are there from an earlier run" in outcome.err
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok", "ok", "ok"]
    assert not (tmp_path / "r" / "failed.csv").exists()


def test_every_case_failed_is_an_error(jkr, tmp_path: Path) -> None:
    one = axis("adhesion.w", "values = [1]")
    (tmp_path / "s.toml").write_text(TWO_LAYERS.replace('"layered"', '"closed-form"') + one)
    outcome = jkr("sweep", "s.toml", "-o", "r")
    assert (outcome.code, "s.toml: every case failed, the first because: method closed" in outcome.err) == (1, True)

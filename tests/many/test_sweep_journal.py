"""What a sweep keeps and shares: its journal, solves at unit modulus, rows that depend on their case alone."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from sweep_files import AXIS, HALF_SPACE, SHARED, TWO_LAYERS, rows, samples

from jkrcli.base.errors import JkrError
from jkrcli.case import store
from jkrcli.many.sweep import opened
from jkrcli.many.sweep_plan import at_unit_modulus

pytestmark = pytest.mark.usefixtures("no_pictures")


def test_a_longer_sweep_solves_what_is_new(jkr, tmp_path: Path, solves: list) -> None:
    """Another value on an axis, more Sobol points: the cases that were there stay."""
    sobol = samples('distribution = "uniform", from = 0, to = 0.5', "specimen.half_space.nu")
    for n, new in ((5, 5), (5, 0), (12, 7)):
        (tmp_path / "s.toml").write_text(HALF_SPACE + sobol.replace("count = 3", f"count = {n}"))
        solves.clear()
        assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
        assert len(solves) == new
        assert len(rows(tmp_path / "r" / "table.csv")) == n


def test_nothing_foreign_is_replaced(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "table.csv").write_text("my thesis")
    jkr("sweep", "s.toml", "-o", "r").refused("r/table.csv: exists and was not written by jkr; give --force")
    (tmp_path / "r" / "table.csv").unlink()
    (tmp_path / "r" / "journal.jsonl").write_text('{"my": "diary"}\n')
    assert jkr("sweep", "s.toml", "-o", "r", "--force").code == 2
    assert (tmp_path / "r" / "journal.jsonl").read_text() == '{"my": "diary"}\n'


def test_an_empty_journal_marks_nothing_as_ours(jkr, tmp_path: Path) -> None:
    """Every table beside it that jkr did not write stays, Parquet and the table of failed cases too."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "journal.jsonl").touch()
    for name in ("table.csv", "table.h5", "table.parquet", "failed.csv"):
        foreign = tmp_path / "r" / name
        foreign.write_text("x,y\n1,2\n")
        if name == "table.parquet":
            pyarrow.parquet.write_table(pyarrow.table({"x": [1.0]}), foreign)
        content = foreign.read_bytes()
        jkr("sweep", "s.toml", "-o", "r").refused(f"r/{name}: exists and was not written by jkr")
        assert foreign.read_bytes() == content
        foreign.unlink()
    assert jkr("sweep", "s.toml", "-o", "r").code == 0
    (tmp_path / "r" / "journal.jsonl").unlink()
    assert jkr("sweep", "s.toml", "-o", "r").code == 0, "our own tables carry their own marks"


@pytest.mark.parametrize("kind", ["folder", "pipe", "device", "file of 100 GiB"])
def test_what_is_no_journal_is_not_read(jkr, tmp_path: Path, kind: str) -> None:
    """A link to /dev/zero was read into all memory."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    journal = tmp_path / "r" / "journal.jsonl"
    make = {
        "folder": lambda: journal.mkdir(),
        "pipe": lambda: os.mkfifo(journal),
        "device": lambda: journal.symlink_to("/dev/null"),
        "file of 100 GiB": lambda: (journal.touch(), os.truncate(journal, 100 << 30)),
    }
    (tmp_path / "r").mkdir()
    make[kind]()
    said = "journal is larger than 2048 MiB" if "GiB" in kind else "is a folder, a device or a pipe, not a journal"
    jkr("sweep", "s.toml", "-o", "r").refused(f"r/journal.jsonl: {said}; give another folder")


def test_a_damaged_line_is_said_and_its_case_solved_again(jkr, tmp_path: Path, solves: list) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    journal, table = tmp_path / "r" / "journal.jsonl", tmp_path / "r" / "table.csv"
    wanted, lines = table.read_bytes(), journal.read_bytes().splitlines(keepends=True)
    fewer = json.dumps([*json.loads(lines[2])[:3], [1.0], 0.1, json.loads(lines[2])[5]]).encode()
    deep = b"[" * 100_000
    for line in (lines[2][:30], b"[[[[", deep, fewer, b'["a"]', lines[2].replace(b"ok", b"no")[:-1]):
        journal.write_bytes(b"".join([*lines[:2], line + b"\n", *lines[3:]]))
        solves.clear()
        outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
        assert (outcome.code, len(solves), table.read_bytes()) == (0, 1, wanted)
        assert "jkr: r/journal.jsonl: 1 damaged lines (3): their cases are solved again\n" in outcome.err
    whole = b"".join(lines)
    for size, missing in ((len(lines[0]) + 7, 3), (len(whole) - 9, 1), (len(whole), 0)):  # cut in the middle of a line
        journal.write_bytes(whole[:size])
        solves.clear()
        assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
        assert (len(solves), table.read_bytes()) == (missing, wanted)


def test_two_sweeps_into_one_folder_are_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    with opened(tmp_path / "r" / "journal.jsonl"):
        jkr("sweep", "s.toml", "-o", "r").refused("r/journal.jsonl: another jkr sweep is writing there; wait for it")


@pytest.mark.slow
def test_cases_that_differ_in_w_or_one_modulus_factor_share_a_solve(jkr, tmp_path: Path, solves: list) -> None:
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    assert (outcome.code, len(solves)) == (0, 2)
    table = rows(tmp_path / "r" / "table.csv")
    assert len(table) == 18
    for row in table[3:9:4]:  # against each case solved alone, by the ordinary verbs
        (tmp_path / "one.toml").write_text(jkr("sweep", "s.toml", "--show-case", row["case"]).out)
        assert jkr("run", "one.toml").code == 0
        alone = jkr("transform", "one.h5", "--no-plots", "--json").told["results"][0]
        told = alone["pull_off"]["load"]
        for quantity, unit in (("P", "N"), ("delta", "m")):  # a sweep interpolates to the points, and says its error
            off = abs(float(row[f"pull_off.load.{quantity}_{unit}"]) - told[f"{quantity}_{unit}"])
            stated = float(row[f"pull_off_errors.load.{quantity}_err_{unit}"])
            assert off <= stated < 1e-3 * abs(told[f"{quantity}_{unit}"])
        np.testing.assert_allclose(float(row["validity.tabor"]), alone["tabor"], rtol=1e-12)


@pytest.mark.slow
def test_a_row_depends_on_its_case_alone(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    first, second, third = SHARED.split("[[axes]]")[1:]
    (tmp_path / "t.toml").write_text(TWO_LAYERS + "".join(f"[[axes]]{axis}" for axis in (third, second, first)))
    for name, workers in (("s", 2), ("t", 1)):
        assert jkr("sweep", f"{name}.toml", "-o", name, "--workers", workers).code == 0
    table, other = (rows(tmp_path / name / "table.csv") for name in "st")
    shuffled = sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in other)
    assert sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in table) == shuffled
    alone = jkr("sweep", "s.toml", "--only", "7", "--json").told
    assert {k: "" if v is None else str(v) for k, v in alone.items()} == table[7]


def test_a_solve_that_cannot_be_kept_is_no_failed_case(jkr, tmp_path: Path, tuned, monkeypatch) -> None:
    """A full disk is told by the journal and the table, not by cases that count as done from then on."""

    def full(path: Path, *_: object) -> None:
        raise JkrError(f"{path}: cannot be written (No space left on device)")

    tuned("jkrcli.many.sweep_plan.SHARING_WORTH_KEEPING", -1.0)
    monkeypatch.setattr("jkrcli.many.sweep_plan.write_solution", full)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED.partition("[[axes]]\nzip")[0])
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok"] * 3


def test_unit_modulus_is_the_same_for_every_factor() -> None:
    """1/3 of 3 and 0.7 of 1.4: quotients are rounded alike, and the factor is the surface's E."""
    from jkrcli.bodies.indenters import Sphere
    from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Specimen

    def body(factor: float) -> Problem:
        layers = (Layer(Elastic(1.1 * factor, 0.3), 1e-4),)
        base = HalfSpace(Elastic(0.7 * factor, 0.2))
        return Problem(Sphere(1e-3, Elastic(13 * factor, 0.3)), Specimen(layers, base), Loading("load", 1e-9 * factor))

    bodies = [at_unit_modulus(body(factor)) for factor in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]
    assert len({problem.key for problem, _ in bodies}) == 1
    assert [factor for _, factor in bodies] == [1.1 * f for f in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]


@pytest.mark.slow
def test_expensive_solves_are_kept(jkr, tmp_path: Path, solves: list, tuned: Callable) -> None:
    """Other quantities of the same bodies: new rows, no new solve; a damaged file is solved again, and both whose files
    have exchanged their names."""
    tuned("jkrcli.many.sweep_plan.SHARING_WORTH_KEEPING", -1.0)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    before = rows(tmp_path / "r" / "table.csv")
    kept = sorted((tmp_path / "r" / "solves").iterdir())
    assert [store.read_solution(path).method for path in kept] == ["layered", "layered"]
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED + '[outputs]\nquantities = ["pull_off"]\n')
    kept[0].write_bytes(kept[0].read_bytes()[:-100])
    solves.clear()
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert len(solves) == 1
    assert store.read_solution(kept[0]).method == "layered"
    after = rows(tmp_path / "r" / "table.csv")
    for name in after[0]:
        assert [row[name] for row in after] == [row[name] for row in before]
    (tmp_path / "r" / "journal.jsonl").unlink()
    contents = [path.read_bytes() for path in kept]
    for path, content in zip(kept, contents[::-1], strict=True):
        path.write_bytes(content)
    solves.clear()
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert (len(solves), rows(tmp_path / "r" / "table.csv")) == (2, after)

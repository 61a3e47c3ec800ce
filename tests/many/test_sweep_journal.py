"""The journal of a sweep: where it goes on, what it believes, what it replaces."""

import json
import os
from pathlib import Path

import pyarrow.parquet
import pytest
from sweep_files import AXIS, BAD, HALF_SPACE, rows, samples

from jkrcli.many.sweep import opened

pytestmark = pytest.mark.usefixtures("no_pictures")


@pytest.mark.slow
def test_restart_goes_on_where_it_was_cut(jkr, tmp_path: Path, solves: list) -> None:
    """The journal cut anywhere, in the middle of a line too: only what is missing is solved, the table is the same."""
    (tmp_path / "s.toml").write_text(HALF_SPACE + BAD)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    journal, table = tmp_path / "r" / "journal.jsonl", tmp_path / "r" / "table.csv"
    whole, wanted = journal.read_bytes(), table.read_bytes()
    lines = whole.splitlines(keepends=True)
    for size in (0, len(lines[0]), len(lines[0]) + 7, sum(map(len, lines[:20])), len(whole) - 1, len(whole)):
        journal.write_bytes(whole[:size])
        table.unlink()
        kept = whole[:size].count(b"\n")
        kept_ok = sum(line.split(b'"')[3] == b"ok" for line in lines[1:kept])
        solves.clear()
        assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
        assert len(solves) == sum(b'"ok"' in line for line in lines) - kept_ok
        assert table.read_bytes() == wanted
        assert len({_identity(line) for line in journal.read_bytes().splitlines()[1:]}) == len(lines) - 1


def _identity(line: bytes) -> str:
    return json.loads(line)[0]


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


def test_two_sweeps_into_one_folder_are_refused(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HALF_SPACE + AXIS)
    (tmp_path / "r").mkdir()
    with opened(tmp_path / "r" / "journal.jsonl"):
        jkr("sweep", "s.toml", "-o", "r").refused("r/journal.jsonl: another jkr sweep is writing there; wait for it")

"""Files of one command are put in place together: whatever fails, none is half written and what is new is said."""

from __future__ import annotations

import builtins
import contextlib
import csv
import io
import json
import math
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Outcome

from jkrcli.base import files
from jkrcli.base.errors import InputError, JkrError
from jkrcli.base.files import write_csv

OURS = '{"format": "jkr-test", "made": "%s"}'
NAMES = ("a.json", "b.json", "c.json", "d.json")
CASE = """
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm", points = 20 }
"""


def held(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def write(folder: Path, names: Iterable[str], content: str) -> None:
    with files.together():
        for name in names:
            files.write_text(folder / name, content)


# ---------------------------------------------------------------------- faults
class Fault:
    """Lets the call number ``at`` of one function fail; ``calls`` counts them."""

    def __init__(self, function: Callable[..., Any], at: int, error: BaseException):
        self.function, self.at, self.error, self.calls = function, at, error, 0

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        self.calls += 1
        if self.calls == self.at:
            raise self.error
        return self.function(*arguments, **options)


class Disk:
    """A file open for writing on a disk that is full, by the ``fault``, after half of what is written first."""

    def __init__(self, file: Any, fault: Fault):
        self._file, self._fault, self._is_begun = file, fault, False

    def write(self, content: Any) -> Any:
        if not content or self._is_begun:
            return self._file.write(content)
        self._is_begun, self._fault.function = True, self._file.write
        try:
            return self._fault(content)
        except BaseException:
            self._file.write(content[: len(content) // 2])
            raise

    def __enter__(self) -> Disk:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


@contextlib.contextmanager
def failing(where: str, fault: Fault) -> Iterator[None]:
    """A block in which the calls of ``where`` go through the ``fault``: "write" is the first to each hidden file."""
    with pytest.MonkeyPatch.context() as patch:
        if where != "write":
            fault.function = getattr(os, where)
            patch.setattr(f"os.{where}", fault)
        else:

            def opened(name: Any, mode: str = "r", *more: Any, opener: Callable[..., Any] = io.open, **how: Any) -> Any:
                file = opener(name, mode, *more, **how)
                is_ours = isinstance(name, str | os.PathLike) and Path(name).name.startswith(files.ASIDE)
                return Disk(file, fault) if is_ours and "w" in mode else file

            patch.setattr(io, "open", opened)
            patch.setattr(builtins, "open", opened)
        yield


def named(words: str, names: Iterable[str]) -> set[str]:
    return {name for name in names if re.search(rf"(^|[ /]){re.escape(name)}(,|;|$)", words)}


NO_SPACE = OSError(28, "No space left on device")


@pytest.mark.parametrize("error", [NO_SPACE, KeyboardInterrupt()], ids=["disk full", "interrupt"])
@pytest.mark.parametrize("where", ["write", "fsync", "replace"])
def test_every_fault_is_told_as_it_is(where: str, error: BaseException, tmp_path: Path) -> None:
    """Each call of ``where`` fails in turn: every file is old or new, none a part, and the message says which."""
    for number in range(1, len(NAMES) + 2):
        write(tmp_path, NAMES, OURS % "old")
        told = ""
        try:
            with failing(where, Fault(os.fsync, number, error)):
                write(tmp_path, NAMES, OURS % "new")
        except (JkrError, KeyboardInterrupt) as caught:
            told = str(caught)
        now = held(tmp_path)
        is_new = {name for name, content in now.items() if content == OURS % "new"}
        assert now == {name: OURS % ("new" if name in is_new else "old") for name in NAMES}
        if number > len(NAMES):
            assert (is_new, told) == ({*NAMES}, "")
        elif where == "replace":
            assert len(is_new) == number - 1
            of_new, of_old = told.partition("new: ")[2].split("; as before: ")
            assert (named(of_new, NAMES), named(of_old, NAMES)) == (is_new, {*NAMES} - is_new)
        else:
            assert not is_new
            assert "; nothing was replaced" in told or isinstance(error, KeyboardInterrupt)


@pytest.mark.parametrize(
    ("where", "number", "error", "code", "said", "new"),
    [
        ("fsync", 4, NO_SPACE, 1, "; nothing was replaced", 0),
        ("write", 4, KeyboardInterrupt(), 130, "nothing half-written was left", 0),
        ("replace", 3, KeyboardInterrupt(), 130, "; as before: s-w0.02", 2),
    ],
)
def test_all_files_of_a_command_come_together(
    jkr: Callable[..., Outcome], where: str, number: int, error: BaseException, code: int, said: str, new: int
) -> None:
    Path("s.toml").write_text(CASE)
    assert jkr("run", "s.toml").code == 0
    words = ("transform", "s.h5", "--w", "0.01", "--w", "0.02", "--no-plots", "--force", "-q")
    assert jkr(*words).code == 0
    paths = sorted(Path().glob("s-w*"))
    for path in paths:
        path.write_text("old")
    with failing(where, Fault(os.fsync, number, error)):
        done = jkr(*words)
    assert (len(paths), done.code, done.err.strip().count("\n")) == (4, code, 0)
    assert said in done.err
    assert sum(path.read_text() != "old" for path in paths) == new
    assert not list(Path().glob(f"{files.ASIDE}*"))


def test_a_file_that_cannot_be_removed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, NAMES[:2], OURS % "old")

    def unlink(path: Path, missing_ok: bool = False, unlink: Callable[..., None] = Path.unlink) -> None:
        if path.name == "b.json":
            raise PermissionError(13, "Permission denied")
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", unlink)

    def replace_and_remove() -> None:
        with files.together():
            files.write_text(tmp_path / "a.json", OURS % "new")
            files.remove_file(tmp_path / "b.json")

    said = r"b\.json: cannot be replaced \(Permission denied\); new: .*a\.json; as before: .*b\.json"
    with pytest.raises(JkrError, match=said):
        replace_and_remove()
    assert held(tmp_path) == {"a.json": OURS % "new", "b.json": OURS % "old"}


def test_json_of_many_records_has_a_line_for_each() -> None:
    records = 30
    data = {"format": "jkr-test", "curves": [{"name": "a\nb", "E*": [1.0, {"low": 0.5}]}] * records, "more": {"w": []}}
    text = files.as_json(data)
    assert json.loads(text) == data
    assert text.count("\n") == records + 8
    few = data | {"curves": data["curves"][:3]}
    assert files.as_json(few) == json.dumps(few, indent=2) + "\n"


def test_what_is_written_twice_is_the_last(tmp_path: Path) -> None:
    with files.together():
        files.write_text(tmp_path / "a", "first")
        files.write_text(tmp_path / "a", "last")
    with files.together():
        files.write_text(tmp_path / "b", "new")
        files.remove_file(tmp_path / "b")
    assert held(tmp_path) == {"a": "last"}


# Every system call that the writing of three files makes, one process each dies in front of.
DYING = """
import os, sys
from pathlib import Path
from jkrcli.base import files

PATHS = [Path(name) for name in "abc"]
number, died = 0, True
while died:
    for path in PATHS:
        path.write_text("old")
        files.check_target(path, force=True)
    process = os.fork()
    if not process:
        left = number
        def count(event, arguments):
            global left
            left -= event.startswith(("os.", "open", "shutil.", "tempfile."))
            if left < 0:
                os._exit(9)
        sys.addaudithook(count)
        with files.together():
            for path in PATHS:
                files.write_text(path, "new")
        os._exit(0)
    died = os.waitpid(process, 0)[1] != 0
    held = [path.read_text() for path in PATHS]
    assert sorted(held, key="new old".index) == held and set(held) <= {"old", "new"}, held
    assert died or held == ["new"] * 3
    number += 1
print(number)
"""


def test_who_dies_at_any_system_call_leaves_whole_files(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", DYING], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 9


# ---------------------------------------------------------------------- what appears meanwhile
@pytest.mark.parametrize("force", [False, True])
def test_a_file_that_appears_after_the_check_goes_by_force_alone(force: bool, tmp_path: Path) -> None:
    for name in NAMES:
        files.check_target(tmp_path / name, force)
    (tmp_path / "a.json").write_text(OURS % "old")
    refused = pytest.raises(InputError, match=r"c\.json: exists and was not written by jkr; give --force")
    with contextlib.nullcontext() if force else refused, files.together():
        for name in NAMES:
            files.write_text(tmp_path / name, OURS % "new")
        (tmp_path / "c.json").write_text("mine")
    untouched = {"a.json": OURS % "old", "c.json": "mine"}
    assert held(tmp_path) == (dict.fromkeys(NAMES, OURS % "new") if force else untouched)


def test_new_replaces_no_case_that_appears(jkr: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch) -> None:
    def write(path: Path, content: bytes) -> None:
        path.write_text("mine")
        files.write_bytes(path, content)

    monkeypatch.setattr("jkrcli.cli.case_verbs.write_bytes", write)
    done = jkr("new", "my.toml")
    assert (done.code, done.err.count("\n"), Path("my.toml").read_text()) == (2, 1, "mine")


def test_a_measured_table_is_not_taken_for_one_of_ours(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    for head in ("a_m,delta_m,P_N", "t_s,a_m,delta_m,P_N", "delta_m,P_N,phase", "P_N,a_m,delta_m,delta_H_m"):
        path.write_text(f"{head}\n1,2,3,4\n")
        with pytest.raises(InputError, match="was not written by jkr; give --force"):
            files.check_target(path)


# ---------------------------------------------------------------------- what is left
def test_what_a_killed_process_left_goes_a_day_later(tmp_path: Path) -> None:
    for name, age in (("old", 2 * files.DAY), ("young", 10)):
        (tmp_path / f".jkr-{name}").touch()
        os.utime(tmp_path / f".jkr-{name}", (time.time() - age,) * 2)
    (tmp_path / ".jkr-folder").mkdir()
    os.mkfifo(tmp_path / ".jkr-pipe")
    files.check_target(tmp_path / "x")
    files.write_text(tmp_path / "x", "whole")
    assert {path.name for path in tmp_path.iterdir()} == {".jkr-young", ".jkr-folder", ".jkr-pipe", "x"}


# ---------------------------------------------------------------------- tables
def test_numbers_keep_every_bit_and_words_their_commas(tmp_path: Path) -> None:
    numbers, words = np.array([0.1 + 0.2, 1e-300, -5e22]), ["plain", "with, comma", 'with "quotes", ü and µ']
    write_csv(tmp_path / "t.csv", {"x_m": numbers, "words, all": words, "n": (1, 2, 3)})
    with (tmp_path / "t.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["x_m", "words, all", "n"]
    assert [float(row[0]) for row in rows] == numbers.tolist()
    assert [row[1] for row in rows] == words
    assert [row[2] for row in rows] == ["1", "2", "3"]


def test_cells_without_a_value_are_empty(tmp_path: Path) -> None:
    write_csv(tmp_path / "t.csv", {"a": [None, math.nan, math.inf, 0.0], "b": ["x", "", None, "y"]})
    assert (tmp_path / "t.csv").read_text() == "a,b\n,x\n,\n,\n0.0,y\n"


def test_a_table_without_rows_is_its_header(tmp_path: Path) -> None:
    write_csv(tmp_path / "t.csv", {"a": [], "b": []})
    assert (tmp_path / "t.csv").read_text() == "a,b\n"

"""Files of one result: whoever dies, and whatever appears meanwhile, they are all old, all new, or told apart."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from conftest import Outcome

from jkrcli.base import files
from jkrcli.base.errors import InputError, JkrError

OURS = '{"format": "jkr-test", "made": "%s"}'
NAMES = ("a.json", "b.json", "c.json", "d.json")
# Every system call that the writing of a result makes, one process each dies in front of; the next one looks.
DYING = """
import os, shutil, sys
from pathlib import Path
from jkrcli.base import files
from jkrcli.base.errors import InputError

OURS = '{"format": "jkr-test", "made": "%s"}'
NAMES = ("a.json", "b.json", "c.json", "d.json")
OLD = {"ours": OURS % "old", "forced": "mine", "none": None}[sys.argv[1]]
folder = Path("f")

def held():
    return {path.name: path.read_text() for path in folder.iterdir() if not path.name.startswith(".jkr-")}

def write(made):
    with files.together():
        for name in NAMES[:3]:
            files.write_text(folder / name, OURS % made)
        files.remove_file(folder / NAMES[3])

def begin():
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name in NAMES:
        if OLD is not None:
            (folder / name).write_text(OLD)
        files.check_target(folder / name, force=OLD == "mine")
    return held()

def dies_at(number):
    process = os.fork()
    if process:
        return os.waitpid(process, 0)[1] != 0
    left = number
    def count(event, arguments):
        nonlocal left
        if event.startswith(("os.", "open", "shutil.", "fcntl.")):
            left -= 1
            if left < 0:
                os._exit(9)
    sys.addaudithook(count)
    write("new")
    os._exit(0)

number, ends = 0, {"old": 0, "new": 0, "half": 0}
new = {name: OURS % "new" for name in NAMES[:3]}
while True:
    old = begin()
    died = dies_at(number)
    ends["half"] += held() not in (old, new)
    files._tidy.cache_clear()
    if number % 2:
        try:
            files.read_bytes(folder / "none", "file")
        except InputError:  # who reads carries on, be it there or not
            pass
    else:
        files.check_target(folder / "x")  # and so does who writes
    now = held()
    assert now in (old, new), (number, now)
    files.check_target(folder / "x")
    assert died or now == new
    assert not list(folder.glob(".jkr-*")), number
    ends["new" if now == new else "old"] += 1
    if not died:
        break
    number += 1
print(*ends.values())
"""


@pytest.mark.parametrize("old", ["ours", "forced", "none"])
def test_who_dies_at_any_system_call_leaves_all_files_old_or_all_new(old: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", DYING, old], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    kept, replaced, half = map(int, done.stdout.split())
    assert kept > 15
    assert replaced > 15
    assert half > 2  # so there was something to carry on


def test_files_of_many_writers_are_of_one(tmp_path: Path) -> None:
    """Each puts what another has on its way in place before its own: no mixture, and nobody waits for the dead."""
    code = """
import sys
from pathlib import Path
from jkrcli.base import files
for _ in range(30):
    with files.together():
        for name in "abcd":
            files.write_text(Path(name), '{"format": "jkr-test", "made": "%s"}' % sys.argv[1])
"""
    both = [subprocess.Popen([sys.executable, "-c", code, name], cwd=tmp_path) for name in ("one", "other", "third")]
    assert [process.wait(timeout=100) for process in both] == [0, 0, 0]
    assert len({path.read_text() for path in tmp_path.iterdir()}) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c", "d"]


# ---------------------------------------------------------------------- what appears meanwhile
def write(folder: Path, names: Iterable[str], content: str) -> None:
    with files.together():
        for name in names:
            files.write_text(folder / name, content)


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
    held = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert held == (dict.fromkeys(NAMES, OURS % "new") if force else {"a.json": OURS % "old", "c.json": "mine"})


def test_a_file_that_appears_at_the_last_moment_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is lost, old and new are told apart, and when it is out of the way the next command carries on."""

    def link(new: Path, path: Path, link: Callable[[Path, Path], None] = os.link) -> None:
        if path.name == "b.json" and not path.exists():
            path.write_text("mine")
        link(new, path)

    monkeypatch.setattr("os.link", link)
    (tmp_path / "c.json").write_text(OURS % "old")
    said = (
        f"{tmp_path}/b.json: cannot be replaced (it was not written by jkr), while other files of its result are new; "
        f"move it away and run the command again, or remove {tmp_path}/.jkr-pending with what is left (b.json, c.json)"
    )
    with pytest.raises(InputError) as refused:
        write(tmp_path, NAMES[:3], OURS % "new")
    with pytest.raises(InputError) as told:
        files.read_bytes(tmp_path / "a.json", "file")
    assert str(refused.value) == str(told.value) == said
    assert (tmp_path / "b.json").read_text() == "mine"
    monkeypatch.undo()
    (tmp_path / "b.json").unlink()
    assert files.read_bytes(tmp_path / "c.json", "file").decode() == OURS % "new"
    assert sorted(path.name for path in tmp_path.iterdir()) == list(NAMES[:3])


def test_without_hard_links_a_file_that_is_not_ours_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory sticks have none."""

    def link(new: Path, path: Path) -> None:
        raise PermissionError(1, "Operation not permitted", str(new), None, str(path))

    monkeypatch.setattr("os.link", link)
    files.write_text(tmp_path / "a", "mine")
    with pytest.raises(InputError, match="a: exists and was not written by jkr"):
        files.write_text(tmp_path / "a", "new")
    assert (tmp_path / "a").read_text() == "mine"


def test_new_replaces_no_case_that_appears(jkr: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch) -> None:
    def write(path: Path, text: str) -> None:
        path.write_text("mine")
        files.write_text(path, text)

    monkeypatch.setattr("jkrcli.cli.case_verbs.write_text", write)
    done = jkr("new", "my.toml")
    assert (done.code, done.err.count("\n"), Path("my.toml").read_text()) == (2, 1, "mine")


# ---------------------------------------------------------------------- who lives, and what is to be believed
def test_what_a_living_process_writes_stays_wherever_it_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The numbers of processes in another container mean nothing here."""

    def kill(*_: object) -> None:
        raise ProcessLookupError

    monkeypatch.setattr("os.kill", kill)
    code = (
        "import sys\nfrom pathlib import Path\nfrom jkrcli.base import files\n"
        "with files.atomic(Path('a')) as temporary:\n"
        "    temporary.write_text('whole')\n    print(flush=True)\n    input()"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        files.check_target(tmp_path / "x")
        process.communicate(b"\n")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a", "whole")]


@pytest.mark.parametrize("module", ["fcntl", "none"])
def test_what_was_left_goes(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there are no locks when it is a day old."""
    monkeypatch.setitem(sys.modules, module, None)
    for name, age in (("old", 2 * 86_400), ("young", 10)):
        (tmp_path / f".jkr-{name}").mkdir()
        (tmp_path / f".jkr-{name}" / "part").touch()
        (tmp_path / f".jkr-{name}.lock").touch()
        os.utime(tmp_path / f".jkr-{name}.lock", (time.time() - age,) * 2)
    files.check_target(tmp_path / "x")
    left = [".jkr-young", ".jkr-young.lock"] if module == "fcntl" else []
    assert sorted(path.name for path in tmp_path.iterdir()) == left


def test_odd_names_stop_nobody(tmp_path: Path) -> None:
    """Temporary files were once named by the machine and the number of a process."""
    host = re.sub(r"[^A-Za-z0-9]", "", platform.node())
    for name in (f".jkr-{host}-²-x", ".jkr-²-x.lock", ".jkr-.lock", ".jkr-..lock", ".jkr-pending.lock"):
        (tmp_path / name).touch()
    os.mkfifo(tmp_path / ".jkr-pipe.lock")
    files.check_target(tmp_path / "x")
    files.write_text(tmp_path / "x", "whole")
    assert (tmp_path / "x").read_text() == "whole"


@pytest.mark.parametrize("kind", ["link", "file", "filled"])
def test_what_jkr_did_not_put_there_is_not_carried_on(kind: str, tmp_path: Path) -> None:
    folder, other, pending = tmp_path / "f", tmp_path / "o", tmp_path / "f" / ".jkr-pending"
    folder.mkdir()
    (other / "new").mkdir(parents=True)
    (other / "new" / "a").write_text(OURS % "theirs")
    (folder / "a").write_text(OURS % "old")
    match kind:
        case "link":
            pending.symlink_to(other)
        case "file":
            pending.touch()
        case "filled":
            pending.mkdir()
            (pending / "x").touch()
    assert files.read_bytes(folder / "a", "file").decode() == OURS % "old"
    with pytest.raises(JkrError, match=r"f/\.jkr-pending: is in the way of new files; move it away"):
        files.write_text(folder / "a", OURS % "new")
    assert (folder / "a").read_text() == OURS % "old"
    assert (other / "new" / "a").exists()
    assert len(list(folder.iterdir())) == 2


def test_where_all_write_another_users_files_are_not_believed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".jkr-pending" / "new").mkdir(parents=True)
    (tmp_path / ".jkr-pending" / "new" / "a").write_text(OURS % "theirs")
    (tmp_path / "a").write_text(OURS % "mine")
    tmp_path.chmod(0o1777)
    user = os.geteuid()
    monkeypatch.setattr("os.geteuid", lambda: user + 1)
    assert files.read_bytes(tmp_path / "a", "file").decode() == OURS % "mine"
    monkeypatch.undo()
    assert files.read_bytes(tmp_path / "a", "file").decode() == OURS % "theirs"


def test_a_folder_that_another_process_takes_away_holds_nothing(tmp_path: Path) -> None:
    """Three writers once met so: one listed what another had just put in place."""
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "a").write_text("x")
    assert [path.name for path in files._left(tmp_path)] == ["a"]
    assert files._left(tmp_path / "gone") == []

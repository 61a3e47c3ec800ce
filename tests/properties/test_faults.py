"""Disk full, two at once: every file is as it was or whole, nothing between."""

import contextlib
import os
import resource
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conftest import Outcome
from every_verb import write_inputs
from fuzzing import outcome

from jkrcli.base import files
from jkrcli.case import store
from jkrcli.cli import call

JOBS = {  # a command, and the one that left what was there before
    "run": (("run", "gel.toml", "-o", "x.h5"), ("run", "less.toml", "-o", "x.h5")),
    "transform": (("transform", "gel.h5", "--w", "0.02"), ("transform", "gel.h5", "--w", "0.02", "--points", "30")),
    "fit": (("fit", "gel.toml", "probe.csv"), ("fit", "gel.toml", "probe.csv", "--level", "0.5")),
    "sweep": (("sweep", "sweep.toml", "-o", "t", "--workers", "1"), ("sweep", "few.toml", "-o", "t", "--workers", "1")),
}


@pytest.fixture(name="folder")
def _folder(jkr: Callable[..., Outcome], tmp_path: Path) -> Path:
    (folder := tmp_path / "x").mkdir()
    with contextlib.chdir(folder):
        write_inputs(folder, jkr)
    (folder / "few.toml").write_text((folder / "sweep.toml").read_text().replace(', "0.6 mm"', ""))
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    found = {str(path.relative_to(folder)): path for path in sorted(folder.rglob("*")) if path.is_file()}
    return {name: path.read_bytes() for name, path in found.items() if ".jkr-" not in name}


def temporaries(folder: Path) -> list[Path]:
    return list(folder.rglob(".jkr-*"))


def _whole(name: str, content: bytes, folder: Path) -> bool:
    """Whether a file that is neither the old nor the expected new one (it holds times) is complete all the same."""
    if name.endswith(".jsonl") or "/solves/" in name:
        return True  # a journal is made to be cut off; its restart is tested
    if not name.endswith(".h5"):
        return False
    if content.find(b"jkr-series") < 0:
        return files.is_ours(folder / name)
    return store.read_solution(folder / name).increments.a.size in (60, 100)


def judge(folder: Path, old: dict[str, bytes], new: dict[str, bytes]) -> None:
    """Every file is the old one, or the new one whole; none of the old ones is gone."""
    now = contents(folder)
    assert old.keys() <= now.keys()
    for name, content in now.items():
        assert content in (old.get(name), new.get(name)) or _whole(name, content, folder), name


def start(command: tuple[str, ...], folder: Path) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "jkrcli", *command, "-q"]
    return subprocess.Popen(
        words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


@contextlib.contextmanager
def file_size(most: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


PLOTTED = [pytest.param(name, (), id=f"{name} with plots", marks=pytest.mark.slow) for name in ("transform", "fit")]
UNPLOTTED = [("run", ()), ("transform", ("--no-plots",)), ("fit", ("--no-plots",)), ("sweep", ())]


@pytest.mark.first(1)
@pytest.mark.parametrize(("name", "options"), [*UNPLOTTED, *PLOTTED])
def test_disk_full_at_every_write(name: str, options: tuple[str, ...], folder: Path, tmp_path: Path) -> None:
    command, before = ((*words, *options, "-q") for words in JOBS[name])
    with contextlib.chdir(folder):
        assert call(before) == 0
    shutil.copytree(folder, tmp_path / "whole")
    with contextlib.chdir(tmp_path / "whole"):
        assert call(command) == 0
    old, new = contents(folder), contents(tmp_path / "whole")
    written = {len(content) for path, content in new.items() if content != old.get(path)}
    with contextlib.chdir(folder):
        for most in sorted({0, 1, *(size // 2 for size in written), *(size - 1 for size in written)}):
            with file_size(most):
                code = outcome(*command)
            assert code == (1 if most < max(written) - 200 else code)  # times in a file change its size a little
            assert not temporaries(folder)
            judge(folder, old, new)


@pytest.mark.slow
def test_standard_output_full(folder: Path) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        words = [sys.executable, "-m", "jkrcli", "show", "gel.h5"]
        done = subprocess.run(words, cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "jkr: error: output: No space left on device\n")


def test_unwritable_folder(folder: Path) -> None:
    locked = folder / "locked"
    locked.mkdir()
    shutil.copy(folder / "less.h5", locked / "x.h5")
    old = (locked / "x.h5").read_bytes()
    locked.chmod(0o555)
    root = os.geteuid() == 0
    with contextlib.chdir(folder):
        try:
            if root:
                os.seteuid(65534)
            assert outcome("run", "gel.toml", "-o", "locked/x.h5") == 2
        finally:
            if root:
                os.seteuid(0)
    assert (locked / "x.h5").read_bytes() == old


@pytest.mark.slow
def test_two_processes_with_one_target(folder: Path) -> None:
    both = [start(("run", f"{case}.toml", "-o", "x.h5"), folder) for case in ("less", "gel", "less")]
    for process in both:
        _, err = process.communicate(timeout=300)
        assert process.returncode == 0, err
    assert store.read_solution(folder / "x.h5").increments.a.size in (60, 100)
    assert not temporaries(folder)


def shell(line: str) -> subprocess.CompletedProcess[str]:
    words = f"{shlex.quote(sys.executable)} -m jkrcli {line}"
    return subprocess.run(["sh", "-c", words], capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&- <&-", "2>/dev/full"])
def test_streams_that_take_nothing_stop_no_work(closed: str, tmp_path: Path) -> None:
    """Progress and warnings are lost there, results and exit codes are not."""
    with contextlib.chdir(tmp_path):
        done = shell(f"study sticking-map --nu 0.3 --ratio 1 --workers 1 --no-plots {closed}")
        assert (done.returncode, done.stderr) == (0, "")
        assert Path("sticking-map.csv").exists()
        assert shell(f"run missing.toml {closed}").returncode == 2


def test_no_file_gets_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    """Libraries print their warnings to 2, whatever that is."""
    opens = (
        "from jkrcli.base import process as p; p.begin(); x = open('x', 'w'); print(x.fileno(), file=open('n', 'w'))"
    )
    subprocess.run(["sh", "-c", 'exec "$0" -c "$1" >&- 2>&- <&-', sys.executable, opens], cwd=tmp_path, check=True)
    assert int((tmp_path / "n").read_text()) > 2


def test_without_a_folder_for_temporary_files(jkr: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise FileNotFoundError(2, "No usable temporary directory found in ['/tmp']")

    for name in ("TemporaryFile", "TemporaryDirectory"):
        monkeypatch.setattr(f"tempfile.{name}", none)
    assert jkr("new", "s.toml").code == 0
    done = jkr("bench", "s.toml", "--repeat", "1")
    assert (done.code, done.err) == (
        1, "jkr: error: temporary files: No usable temporary directory found in ['/tmp']\n"
    )  # fmt: skip

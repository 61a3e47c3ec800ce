"""Killed, interrupted, disk full, two at once: every file is as it was or whole, nothing between."""

import contextlib
import os
import resource
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Outcome
from fuzzing import outcome

from jkrcli.base import files
from jkrcli.case import store
from jkrcli.cli import call

LAYER = """
method = "layered"
[indenter]
shape = "paraboloid"
radius = "6 mm"
[[specimen.layers]]
thickness = "0.36 mm"
E = "15 kPa"
nu = 0.45
[loading]
radius = "1.2 mm"
points = {points}
"""
SWEEP = """
base = "new.toml"
[[axes]]
key = "specimen.layers[0].thickness"
from = "0.2 mm"
to = "0.5 mm"
count = 12
[[axes]]
key = "adhesion.w"
values = [0.01, 0.02]
"""


@dataclass(frozen=True)
class Job:
    """A command that writes ``target`` among others, and the one that left what was there before."""

    before: tuple[str, ...]
    command: tuple[str, ...]
    target: str


JOBS = {
    "run": Job(("run", "old.toml", "-o", "x.h5"), ("run", "new.toml", "-o", "x.h5"), "x.h5"),
    "transform": Job(
        ("transform", "old/y.h5", "--w", "0.02", "-o", "."), ("transform", "y.h5", "--w", "0.02"), "y-w0.02.csv"
    ),
    "fit": Job(("fit", "old/y.h5", "m.csv", "-o", "."), ("fit", "y.h5", "m.csv"), "y-fit.h5"),
    "sweep": Job(
        ("sweep", "old.toml.sweep", "-o", "t"), ("sweep", "s.toml", "-o", "t", "--workers", "1"), "t/table.csv"
    ),
}


def prepare(folder: Path) -> Path:
    folder.mkdir()
    (folder / "old").mkdir()
    (folder / "old.toml").write_text(LAYER.format(points=20), encoding="utf-8")
    (folder / "new.toml").write_text(LAYER.format(points=60), encoding="utf-8")
    (folder / "s.toml").write_text(SWEEP, encoding="utf-8")
    (folder / "old.toml.sweep").write_text(SWEEP.replace("count = 12", "count = 2"), encoding="utf-8")
    with contextlib.chdir(folder):
        assert call(["run", "old.toml", "-o", "old/y.h5", "-q"]) == 0
        assert call(["run", "new.toml", "-o", "y.h5", "-q"]) == 0
        assert call(["transform", "y.h5", "--w", "0.02", "-o", "old", "--no-plots", "-q"]) == 0
        measured("old/y-w0.02.csv")
    return folder


def measured(curve: str) -> None:
    a, delta, P = np.loadtxt(curve, delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
    noise = 1e-3 * np.random.default_rng(1).standard_normal((2, a.size))
    columns = np.column_stack([a, delta + noise[0] * np.ptp(delta), P + noise[1] * np.ptp(P)])
    np.savetxt("m.csv", columns[a > 3e-4], delimiter=",", header="a_m,delta_m,P_N", comments="")


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
    return store.read_solution(folder / name).increments.a.size in (20, 60)


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


def call_in(folder: Path, *words: str) -> int:
    with contextlib.chdir(folder):
        return call([*words, "-q"])


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
def test_disk_full_at_every_write(name: str, options: tuple[str, ...], tmp_path: Path) -> None:
    folder, job = prepare(tmp_path / "x"), JOBS[name]
    job = replace(job, before=(*job.before, *options), command=(*job.command, *options))
    with contextlib.chdir(folder):
        assert call([*job.before, "-q"]) == 0
        old = contents(folder)
        shutil.copytree(folder, tmp_path / "whole")
        assert call_in(tmp_path / "whole", *job.command) == 0
        new = contents(tmp_path / "whole")
        written = {len(content) for path, content in new.items() if content != old.get(path)}
        for most in sorted({0, 1, *(size // 2 for size in written), *(size - 1 for size in written)}):
            with file_size(most):
                code = outcome(*job.command, "-q")
            assert code == (1 if most < max(written) - 200 else code)  # times in a file change its size a little
            assert not temporaries(folder)
            judge(folder, old, new)


@pytest.mark.slow
def test_standard_output_full(tmp_path: Path) -> None:
    prepare(tmp_path / "x")
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        words = [sys.executable, "-m", "jkrcli", "show", "y.h5"]
        done = subprocess.run(words, cwd=tmp_path / "x", stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "jkr: error: output: No space left on device\n")


def test_unwritable_folder(tmp_path: Path) -> None:
    folder = prepare(tmp_path / "x")
    locked = folder / "locked"
    locked.mkdir()
    shutil.copy(folder / "old" / "y.h5", locked / "x.h5")
    old = (locked / "x.h5").read_bytes()
    locked.chmod(0o555)
    root = os.geteuid() == 0
    with contextlib.chdir(folder):
        try:
            if root:
                os.seteuid(65534)
            assert outcome("run", "new.toml", "-o", "locked/x.h5") == 2
        finally:
            if root:
                os.seteuid(0)
    assert (locked / "x.h5").read_bytes() == old


@pytest.mark.slow
def test_two_processes_with_one_target(tmp_path: Path) -> None:
    folder = prepare(tmp_path / "x")
    both = [start(("run", f"{case}.toml", "-o", "x.h5"), folder) for case in ("old", "new", "old")]
    for process in both:
        _, err = process.communicate(timeout=300)
        assert process.returncode == 0, err
    assert store.read_solution(folder / "x.h5").increments.a.size in (20, 60)
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
    Path("s.toml").write_text(LAYER.format(points=20))
    done = jkr("bench", "s.toml", "--repeat", "1")
    assert (done.code, done.err) == (
        1, "jkr: error: temporary files: No usable temporary directory found in ['/tmp']\n"
    )  # fmt: skip

"""Sweeps by many processes: killed and restarted, and by a Dask scheduler with workers of its own on loopback."""

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

JKR = (sys.executable, "-m", "jkrcli")
DEADLINE = 120.0  # seconds to wait for processes on a machine that others use too
CASES = 300
STACKS = f"""
[base]
method = "layered"
indenter = {{ shape = "sphere", radius = "1 mm" }}
specimen.layers = [
    {{ E = "10 kPa", nu = 0.3, thickness = "0.1 mm" }},
    {{ E = "20 kPa", nu = 0.4, thickness = "0.1 mm" }},
    {{ E = "30 kPa", nu = 0.45, thickness = "0.1 mm" }},
]
loading = {{ radius = "0.3 mm", points = 40 }}
adhesion = {{ w = "5 mJ/m^2" }}

[samples]
count = {CASES}
[samples.of]
"specimen.layers.count" = {{ distribution = "integer", from = 1, to = 3 }}
"specimen.layers[0].E" = {{ distribution = "loguniform", from = "1 kPa", to = "1 MPa" }}
"specimen.layers[0].nu" = {{ distribution = "normal", mean = 0.4, sd = 0.06 }}
"specimen.layers[1].thickness" = {{ distribution = "loguniform", from = "30 um", to = "300 um" }}
"""


def wait(condition: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end, f"waited {DEADLINE:g} s for {what}"
        time.sleep(0.01)


def sweep(folder: Path, name: str, *words: str) -> list[str]:
    return [*JKR, "sweep", str(folder / "s.toml"), "-o", str(folder / name), *words]


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    (tmp_path / "s.toml").write_text(STACKS)
    subprocess.run(sweep(tmp_path, "whole", "--workers", "1"), check=True, capture_output=True, timeout=DEADLINE)
    return tmp_path


def tables_agree(folder: Path, name: str) -> bool:
    return (folder / name / "table.csv").read_bytes() == (folder / "whole" / "table.csv").read_bytes()


@contextlib.contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process that is ended with the block."""
    env = os.environ | {"DASK_DISTRIBUTED__ADMIN__LOG_LENGTH": "0"}
    running = subprocess.Popen(words, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield running
    finally:
        running.terminate()
        running.wait(DEADLINE)


@pytest.mark.slow
def test_a_scheduler_with_two_workers_gives_the_same_table(folder: Path) -> None:
    pytest.importorskip("distributed")
    told = folder / "scheduler.json"
    dask = (sys.executable, "-m", "dask")
    loopback = ("--host", "127.0.0.1", "--scheduler-file", str(told))
    with contextlib.ExitStack() as stack:
        stack.enter_context(process(*dask, "scheduler", *loopback, "--port", "0", "--no-dashboard"))
        wait(lambda: told.exists() and told.read_text().rstrip().endswith("}"), "the scheduler")
        for _ in range(2):
            stack.enter_context(process(*dask, "worker", *loopback, "--nthreads", "1", "--no-dashboard"))
        address = json.loads(told.read_text())["address"]
        assert address.startswith("tcp://127.0.0.1:")
        done = subprocess.run(
            sweep(folder, "dask", "--scheduler", address), check=True, capture_output=True, text=True, timeout=DEADLINE
        )
    assert "jkr: dashboard http://127.0.0.1:" in done.stderr
    assert tables_agree(folder, "dask")
    assert (folder / "dask" / "table.h5").stat().st_size == (folder / "whole" / "table.h5").stat().st_size

"""On systems that lack what Linux has: nothing that solves, reads or fits needs it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# What Windows lacks, but for what other libraries use here, is taken away before anything is imported, in the
# processes that are started too.
LACKING = """
import os, signal, sys
sys.modules.update(dict.fromkeys(("fcntl", "resource", "pwd", "grp", "syslog")))
for name in (
    "chown", "fork", "getegid", "geteuid", "getgid", "getloadavg", "getpgid", "getuid", "killpg", "mkfifo", "nice",
    "O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "sched_getaffinity", "setsid", "statvfs", "sysconf",
):
    delattr(os, name)
for name in ("alarm", "pthread_kill", "pthread_sigmask", "setitimer", "SIGALRM", "SIGHUP", "SIGKILL", "SIGPIPE",
             "SIG_BLOCK", "SIG_SETMASK"):
    delattr(signal, name)
"""
COMMANDS = """
import os, sys
assert sys.modules["fcntl"] is None and not hasattr(os, "fork")
from jkrcli.base import process
process.begin()
assert process.free_memory() > 0 and process.address_space() == float("inf")
from jkrcli.cli import call
for words in (
    ("new", "n.toml"), ("run", "l.toml"), ("show", "l.h5"), ("transform", "l.h5", "--no-plots"),
    ("fit", "l.toml", "l-w0.05.csv", "--no-plots"), ("sweep", "s.toml", "-o", "swept", "--workers", "2"),
):
    if (code := call([*words])) != 0:
        sys.exit(f"{words}: {code}")
"""
CASE = """
method = "layered"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]
loading = { radius = "0.1 mm", points = 40 }
adhesion = { w = "50 mJ/m^2" }
"""
SWEEP = 'base = "l.toml"\n[[axes]]\nkey = "specimen.layers[0].nu"\nvalues = [0.2, 0.3]\n'


@pytest.mark.slow
def test_without_what_windows_lacks_all_is_read_solved_and_fitted(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(LACKING)
    (tmp_path / "l.toml").write_text(CASE)
    (tmp_path / "s.toml").write_text(SWEEP)
    environment = {"PYTHONPATH": f"{tmp_path}:{ROOT}", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", COMMANDS], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "swept" / "table.csv").read_text().count(",ok,") == 2


@pytest.mark.parametrize("date", ["abc", "", "1e9"])
def test_a_date_of_the_source_that_is_none_is_left_out(date, jkr, monkeypatch) -> None:
    """NumPy's f2py, which comes with scikit-fem, takes it for a number; no result depends on it."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", date)
    done = jkr("new", "n.toml")
    assert (done.code, done.err) == (
        0, f'jkr: warning: SOURCE_DATE_EPOCH must be a whole number, got "{date}": it is left out\n'
    )  # fmt: skip
    assert "SOURCE_DATE_EPOCH" not in os.environ

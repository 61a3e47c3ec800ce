"""The same case gives the same numbers to the last bit, whatever surrounds the process."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jkrcli.case import store
from jkrcli.series import COLUMNS

CASES = Path(__file__).parents[2] / "cases"
FINITE = """
method = "fem"
indenter = { shape = "sphere", radius = "1 mm" }
loading.radius = "0.1 mm"
mesh = { spacing = 0.4, estimate_error = false }
[[specimen.layers]]
thickness = "0.4 mm"
E = "15 kPa"
nu = 0.4
"""
SURROUNDINGS = {
    "OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2", "MKL_NUM_THREADS": "2",
    "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "TZ": "Pacific/Auckland",
    "PYTHONHASHSEED": "12345", "PYTHONUNBUFFERED": "1", "PYTHONIOENCODING": "ascii",
}  # fmt: skip
BOTH = """
import sys
from jkrcli.cli import call
sys.exit(call(["run", sys.argv[1], "-o", "x.h5"]) or call(["transform", "x.h5", "--w", "0.05", "--no-plots"]))
"""


def run(case: Path, folder: Path, **environment: str) -> Path:
    """Solve and transform a case in a process of its own, within ``folder``; returns the folder."""
    folder.mkdir()
    words, env = [sys.executable, "-c", BOTH, str(case)], os.environ | environment
    done = subprocess.run(words, cwd=folder, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def same(one: Path, other: Path) -> None:
    """All numbers of two series files and the text of two tables are equal, bit by bit."""
    a, b = store.read_solution(one / "x.h5"), store.read_solution(other / "x.h5")
    assert a.series.errors.keys() == b.series.errors.keys()
    for name in COLUMNS:
        assert np.array_equal(getattr(a.series, name), getattr(b.series, name)), name
        if name in a.series.errors:
            assert np.array_equal(a.series.errors[name], b.series.errors[name]), name
    assert np.array_equal(a.increments.P, b.increments.P)
    assert (a.record.toml, a.key, a.budget, dict(a.facts)) == (b.record.toml, b.key, b.budget, dict(b.facts))
    for name in ("x-w0.05.csv", "x-w0.05.json"):
        assert (one / name).read_bytes() == (other / name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("method", ["layered", "fem"])
def test_surroundings_change_no_bit(method: str, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(FINITE if method == "fem" else (CASES / "gel.toml").read_text())
    same(run(case, tmp_path / "usual"), run(case, tmp_path / "elsewhere", **SURROUNDINGS))

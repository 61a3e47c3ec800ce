"""A column of the series: a line and a field in ``series/__init__.py``, and the method that gives it; no other file."""

import shutil
import subprocess
import sys
from pathlib import Path

import jkrcli
from jkrcli.base.wings import PACKAGE

LINE = '    "q": Column("mean_pressure", "N/m^2", "load over contact area", 1, 1),\n}\nJUDGED'
CASE = """
indenter = { shape = "sphere", radius = "100 um" }
specimen.half_space = { E = "5 GPa", nu = 0.4 }
loading = { depth = "3 um" }
"""
LOOK = """
import sys; sys.path.insert(0, sys.argv[1])
import numpy as np, jkrcli as jkr
case = sys.argv[2]
solved = jkr.solve(jkr.load_case(case), "closed-form")
read = jkr.read(jkr.save(solved, sys.argv[3]))
same = np.array_equal(read.series.q, solved.series.P / (np.pi * solved.series.a**2))
scaled = np.allclose(solved.scaled(2).series.q, 2 * read.series.q, rtol=1e-15)
print(same, scaled, jkr.transform(read, 50.0).pull_off["load"].P)
from jkrcli.cli import call
call(["show", sys.argv[3]])
"""


def test_a_column_of_the_series_is_added_in_two_files(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "jkrcli", ignore=shutil.ignore_patterns("__pycache__"))
    field = "    shift: Array | None = None"
    for name, old, new in (
        ("series/__init__.py", "}\nJUDGED", LINE),
        ("series/__init__.py", field, f"{field}\n    q: Array | None = None"),
        ("methods/closed_form.py", "Series(a, *columns", "Series(a, *columns, q=columns[1] / (np.pi * a**2)"),
    ):
        path = tmp_path / "jkrcli" / name
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")

    (case := tmp_path / "half-space.toml").write_text(CASE, encoding="utf-8")
    words = [sys.executable, "-c", LOOK, tmp_path, case, tmp_path / "one.h5"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    same, scaled, pulled = done.stdout.splitlines()[0].split()
    before = jkrcli.transform(jkrcli.solve(jkrcli.load_case(case), "closed-form"), 50.0).pull_off["load"]
    assert (same, scaled, float(pulled)) == ("True", "True", before.P)  # rows solved for pull-off take it along
    assert ", q\n" in done.stdout

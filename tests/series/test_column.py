"""A column of the series: a line and a field in ``series/__init__.py``, and the method that gives it; no other file."""

import shutil
import subprocess
import sys
from pathlib import Path

from jkrcli.base.wings import PACKAGE

LINE = '    "p": Column("mean_pressure", "N/m^2", "load over contact area", 1, 1),\n}\nJUDGED'
GIVEN = "series = Series(a, *columns, p=columns[1] / (np.pi * a**2), errors"
LOOK = """
import sys; sys.path.insert(0, sys.argv[1])
import numpy as np, jkrcli as jkr
case = sys.argv[2]
solved = jkr.solve(jkr.load_case(case), "closed-form")
read = jkr.read(jkr.save(solved, sys.argv[3]))
same = np.array_equal(read.series.p, solved.series.P / (np.pi * solved.series.a**2))
scaled = np.allclose(solved.scaled(2).series.p, 2 * read.series.p, rtol=1e-15)
print(same, scaled, jkr.transform(read, 0.05).pull_off["load"].P < 0)
from jkrcli.cli import call
call(["show", sys.argv[3]])
"""


def test_a_column_of_the_series_is_added_in_two_files(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "jkrcli", ignore=shutil.ignore_patterns("__pycache__"))
    field = "    shift: Array | None = None"
    for name, old, new in (
        ("series/__init__.py", "}\nJUDGED", LINE),
        ("series/__init__.py", field, f"{field}\n    p: Array | None = None"),
        ("methods/closed_form.py", "series = Series(a, *columns, errors", GIVEN),
    ):
        path = tmp_path / "jkrcli" / name
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")

    case = PACKAGE.parent / "cases" / "halfspace.toml"
    words = [sys.executable, "-c", LOOK, tmp_path, case, tmp_path / "one.h5"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("True True True\n")
    assert "columns   a, delta, P, S, dS, p\n" in done.stdout

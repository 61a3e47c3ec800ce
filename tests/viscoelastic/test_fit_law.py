"""``jkr fit --law``: records at two speeds together, the files, and one line for what is wrong."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rate_records import retraction

from jkrcli.case import store
from jkrcli.resolve.analysis import nonadhesive

CASE = """
[indenter]
shape = "paraboloid"
radius = "1 mm"
[specimen.half_space]
E = "1 MPa"
nu = 0.5
[loading]
radius = "100 um"
points = 40
spacing = "log"
[adhesion]
w = "50 mJ/m^2"
"""


@pytest.fixture(name="records")
def _records(jkr: Callable, tmp_path: Path) -> list[str]:
    (tmp_path / "lens.toml").write_text(CASE)
    assert jkr("run", "lens.toml", "-q").code == 0
    body, rng = nonadhesive(store.read_solution(tmp_path / "lens.h5")), np.random.default_rng(3)
    names = []
    for V in (2e-7, 2e-6):
        t, delta, P, _ = retraction(body, 0.05, 1e-6, 0.5, V, 8e-5, math.inf, 150)
        P = P + 0.01 * np.ptp(P) * rng.normal(size=t.size)
        delta = delta + 0.01 * np.ptp(delta) * rng.normal(size=t.size)
        table = np.stack([t, delta * 1e6, P * 1e3], axis=1).tolist()
        rows = "\n".join(",".join(map(repr, row)) for row in table)
        names.append(f"v{V:g}.csv")
        (tmp_path / names[-1]).write_text(f"t_s,delta_um,P_mN\n{rows}\n")
    return names


@pytest.mark.slow
def test_two_speeds_are_fitted_together(jkr: Callable, records: list[str]) -> None:
    done = jkr("fit", "lens.h5", *records, "--law", "power", "--free", "w0,v0,n", "--fix", "modulus=1", "--fix",
               "delta0=0", "--json")  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["free"] == ["w0", "v0", "n"]
    for name, truth in (("w0", 0.05), ("v0", 1e-6), ("n", 0.5)):
        item = found["estimates"][name]
        assert abs(item["value"] - truth) < 4 * item["standard_error"]
    with Path("lens-fit.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(record["rows"] for record in found["records"])
    assert Path("lens-fit.svg").exists()


@pytest.mark.slow
def test_what_is_wrong_is_one_line(jkr: Callable, records: list[str]) -> None:
    for words, said in (
        (("--loss", "huber"), "fit: --law does not take --loss huber: leave it out"),
        (("--fix", "n=-1"), "fit: n: must be > 0 and <= 100, got -1"),
        (("--bound", "w=0..1"), "fit: --law does not take --bound: leave it out"),
    ):
        done = jkr("fit", "lens.h5", *records, "--law", "power", *words)
        assert done.code == 2
        assert done.err.splitlines()[-1] == f"jkr: error: {said}"
    Path("no-time.csv").write_text("delta_um,P_mN\n" + "".join(f"{-i},{-i}\n" for i in range(30)))
    done = jkr("fit", "lens.h5", "no-time.csv", "--law", "power")
    assert done.err.splitlines()[-1] == "jkr: error: no-time.csv: a fit over speed needs t, delta and P, it lacks t"

"""``jkr cycle --rate`` and ``jkr fit --law`` on series of every origin: layered, hybrid, finite elements, imported."""

import csv
import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES, write_table
from rate_records import retraction

from jkrcli.case import store
from jkrcli.resolve.analysis import nonadhesive

LAW = (0.04, 2e-6, 0.5)  # w0, v0, n
ORIGINS = ["hybrid", pytest.param("fem", marks=pytest.mark.slow), "imported", "noisy"]
NOISE = {"imported": 1e-6, "noisy": 1e-3}


@pytest.fixture(name="gel", scope="module")
def _gel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The gel's series by its own method, in a folder of its own."""
    from jkrcli.cli import call

    folder = tmp_path_factory.mktemp("gel")
    assert call(["run", str(CASES / "gel.toml"), "-q", "-o", str(folder / "layered.h5")]) == 0
    return folder


def series_of(jkr: Callable, gel: Path, origin: str) -> Path:
    """The same body by another way."""
    path = Path(f"{origin}.h5")
    if origin in NOISE:
        exact, rng = store.read_solution(gel / "layered.h5").series, np.random.default_rng(0)
        columns = [getattr(exact, name) * (1 + NOISE[origin] * rng.normal(size=len(exact))) for name in ("a", "delta")]
        columns.append(exact.P * (1 + NOISE[origin] * rng.normal(size=len(exact))))
        write_table("table.csv", "a_m,delta_m,P_N", *columns)
        done = jkr("import", "table.csv", "--case", CASES / "gel.toml", "-o", path, "-q")
    else:
        done = jkr("run", CASES / "gel.toml", "--method", origin, "-o", path, "-q")
    assert done.code == 0, done.err
    return path


@pytest.mark.slow
@pytest.mark.parametrize("origin", ORIGINS)
def test_a_cycle_at_speed(jkr: Callable, gel: Path, origin: str) -> None:
    shutil.copy(gel / "layered.h5", "layered.h5")
    found = []
    for path in (Path("layered.h5"), series_of(jkr, gel, origin)):
        words = ("--rate", "v0=2 um/s,n=0.5", "--speed", "10 um/s", "--to-load", "0.5 mN", "--json", "--no-plots")
        done = jkr("cycle", path, *words).ok
        found.append(json.loads(done.out))
    exact, other = found
    assert other["contact_lost"]
    assert other["balance_relative_error"] < 1e-8
    near = {"hybrid": 1e-6, "fem": 2e-3, "imported": 1e-4, "noisy": 2e-2}[origin]  # measured 1e-7, 4e-4, 2e-5, 7e-3
    assert other["pull_off"]["P_N"] == pytest.approx(exact["pull_off"]["P_N"], rel=near)
    assert other["pull_off"]["t_s"] == pytest.approx(exact["pull_off"]["t_s"], rel=near)


@pytest.mark.slow
@pytest.mark.parametrize("origin", ["hybrid", "fem", "imported", "noisy"])
def test_a_fit_of_records(jkr: Callable, gel: Path, origin: str) -> None:
    body, rng = nonadhesive(store.read_solution(gel / "layered.h5")), np.random.default_rng(3)
    names = []
    for V in (1e-6, 1e-5, 3e-5):
        t, delta, P, _ = retraction(body, *LAW, V, 7e-4, math.inf, 250)
        P = P + 0.01 * np.ptp(P) * rng.normal(size=t.size)
        delta = delta + 0.01 * np.ptp(delta) * rng.normal(size=t.size)
        names.append(str(write_table(f"v{V:g}.csv", "t_s,delta_um,P_mN", t, delta * 1e6, P * 1e3)))
    words = ("--law", "power", "--free", "w0,v0,n", "--json", "--no-plots")
    told = jkr("fit", series_of(jkr, gel, origin), *names, *words).told
    rows = list(csv.DictReader(Path(f"{origin}-fit.csv").read_text().splitlines()))
    assert len(rows) == sum(one["rows"] for one in told["records"])
    for name, truth in zip(("w0", "v0", "n"), LAW, strict=True):
        item = told["estimates"][name]
        assert abs(math.log(item["value"] / truth)) < 4 * item["standard_error"] / item["value"]


def test_what_is_wrong_is_one_line(jkr: Callable, gel: Path) -> None:
    for columns, words, said in (
        ("t_s,delta_um,P_mN", ("--loss", "huber"), "fit: --law does not take --loss huber: leave it out"),
        ("t_s,delta_um,P_mN", ("--fix", "n=-1"), "fit: n: must be > 0 and <= 100, got -1"),
        ("a_um,delta_um,P_mN", (), "a.csv: a fit over speed needs t, delta and P, it lacks t"),
    ):
        write_table("a.csv", columns, *[np.arange(1.0, 30)] * 3)
        jkr("fit", gel / "layered.h5", "a.csv", "--law", "power", *words, "-o", ".").refused(said)

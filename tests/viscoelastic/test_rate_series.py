"""``jkr cycle --rate`` and ``jkr fit --law`` on series of every origin: layered, hybrid, finite elements, imported."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES
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
        rows = "\n".join(",".join(map(repr, row)) for row in np.stack(columns, 1).tolist())
        Path("table.csv").write_text(f"a_m,delta_m,P_N\n{rows}\n")
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
        done = jkr("cycle", path, *words)
        assert done.code == 0, done.err
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
        rows = "\n".join(",".join(map(repr, row)) for row in np.stack([t, delta * 1e6, P * 1e3], 1).tolist())
        names.append(f"v{V:g}.csv")
        Path(names[-1]).write_text(f"t_s,delta_um,P_mN\n{rows}\n")
    done = jkr(
        "fit", series_of(jkr, gel, origin), *names, "--law", "power", "--free", "w0,v0,n", "--json", "--no-plots"
    )
    assert done.code == 0, done.err
    estimates = json.loads(done.out)["estimates"]
    for name, truth in zip(("w0", "v0", "n"), LAW, strict=True):
        item = estimates[name]
        assert abs(math.log(item["value"] / truth)) < 4 * item["standard_error"] / item["value"]

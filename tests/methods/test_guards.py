"""What would cost too much is refused before it begins, with its estimate; what costs much is announced."""

import math
import os
import resource
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from jkrcli.base import process
from jkrcli.base.errors import Refusal
from jkrcli.base.executors import available_cores
from jkrcli.base.process import duration
from jkrcli.case.models import load_case
from jkrcli.case.store import solve
from jkrcli.methods.protocol import Forecast, Limits, check_cost

CASES = Path(__file__).parents[2] / "cases"
CASE = """
method = "{method}"
indenter = {{ shape = "sphere", radius = "6 mm" }}
specimen.layers = [{{ thickness = "0.36 mm", E = "15 kPa", nu = 0.45 }}]
loading = {{ radius = "1.2 mm", points = {points} }}
mesh.spacing = {spacing}
"""


REMEDY = "use fewer points, larger elements or a cheaper method, or raise the limit by"


@pytest.mark.parametrize(
    ("forecast", "limits", "needs", "limit", "remedy"),
    [
        (Forecast(7200.0, 10.24, 0.0), Limits(1, 1), "0.01 GiB of memory and 2 h", "1 h", "--limit-time 2.6"),
        (Forecast(1.0, 20480.0, 0.0), Limits(8, 1), "20 GiB of memory and 1 s", "8 GiB", "--limit-memory 26"),
        (Forecast(1.0, math.nan, 0.0), Limits(8, 1), "nan GiB of memory and 1 s", "8 GiB", "--limit-memory nan"),
    ],
)
def test_refused_with_its_estimate(forecast: Forecast, limits: Limits, needs: str, limit: str, remedy: str) -> None:
    with pytest.raises(Refusal) as refused:
        check_cost("x", forecast, limits)
    assert str(refused.value) == f"x would need about {needs} of CPU time, the limit is {limit}: {REMEDY} {remedy}"


@pytest.mark.parametrize(
    ("seconds", "mib", "told"),
    [
        (1.0, 100.0, None),
        (3.0, 100.0, "x takes about 3 s of CPU time"),
        (100.0, 100.0, "x takes about 2 min of CPU time"),
        (1.0, 4096.0, "x takes about 1 s of CPU time and 4 GiB of memory"),
    ],
)
def test_told_where_it_is_much(seconds: float, mib: float, told: str | None) -> None:
    assert check_cost("x", Forecast(seconds, mib, 0.0), Limits(64, 1)) == told


def test_the_least_of_all_limits_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "memory.max").write_text(f"{300 << 20}\n", encoding="ascii")
    (tmp_path / "memory.current").write_text(f"{100 << 20}\n", encoding="ascii")
    monkeypatch.setattr(process, "CGROUP", tmp_path)
    assert process.free_memory() == 200
    (tmp_path / "memory.max").write_text("max\n", encoding="ascii")
    free = process.free_memory()
    assert 200 < free < math.inf
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (100 << 20), hard))
    try:
        assert process.free_memory() == pytest.approx(100, abs=20)  # MiB; this test itself may take some
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.5, "0.5 s"), (40.0, "40 s"), (90.0, "2 min"), (5400.0, "1.5 h"), (12240.0, "3.4 h"),
        (2 * 86_400.0, "2 days"), (2.77e4 * 3600, "3.16 years"), (1e12, "more than 1,000 years"),
        (47 * 3600.0, "47 h"),
    ],
)  # fmt: skip
def test_duration(seconds: float, words: str) -> None:
    assert duration(seconds) == words


@pytest.mark.parametrize(
    ("method", "points", "spacing", "verb"),
    [("fem", 100, 2e-4, "run"), ("fem", 100, 2e-4, "mesh"), ("hybrid", 100_000, 0.1, "run")],
)
def test_command_line_refuses_what_is_too_large(
    jkr: Callable, method: str, points: int, spacing: float, verb: str
) -> None:
    # a wide layer is solved by layered
    sides = 'specimen.radius = "10 mm"\nspecimen.side = "free"\n' if method == "hybrid" else ""
    Path("x.toml").write_text(sides + CASE.format(method=method, points=points, spacing=spacing), encoding="utf-8")
    jkr(verb, "x.toml", "--limit-memory", "4").refused(
        "error: method ", " would need about ", "the limit by --limit-memory"
    )
    assert not list(Path().glob("*.h5"))


def test_library_tells_and_refuses_alike() -> None:
    case, told = load_case(CASES / "gel.toml"), []
    solve(case, "layered", announce=told.append)
    assert told == []
    with pytest.raises(Refusal, match=r"method layered would need about .* the limit is 1e-06 GiB"):
        solve(case, "layered", Limits(memory=1e-6))


def test_systems_without_limits_and_affinity(jkr, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python has them on Linux only, or nearly so: what is missing limits nothing."""
    monkeypatch.setitem(sys.modules, "resource", None)
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(process, "CGROUP", Path("none"))
    assert process.free_memory() > 0
    assert available_cores() == (os.cpu_count() or 1)
    Path("x.toml").write_text(CASE.format(method="layered", points=20, spacing=0.1))
    assert jkr("run", "x.toml").code == 0
    assert jkr("transform", "x.h5", "--w", "0.1", "--no-plots").code == 0


@pytest.mark.parametrize("words", [("run", "x.toml"), ("fit", "x.toml", "m.csv")])
def test_layered_refuses_more_nodes_than_it_takes_before_it_begins(jkr: Callable, words: tuple[str, ...]) -> None:
    thin = CASE.format(method="layered", points=100, spacing=0.1).replace("0.36 mm", "100 nm")
    Path("x.toml").write_text(thin, encoding="utf-8")
    Path("m.csv").write_text("delta_m,P_N\n" + "1e-6,1e-6\n" * 9, encoding="utf-8")
    jkr(*words).refused("nodes for 100 radii (limit 4000); use a smaller contact\n")


@pytest.mark.slow
def test_auto_names_no_method_that_the_solve_refuses(jkr: Callable, tmp_path: Path) -> None:
    (tmp_path / "thin.toml").write_text("""
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.layers = [{ thickness = "27.9 nm", E = "1 MPa", nu = 0.3 }]
loading.radius = "50 um"
adhesion.w = "50 mJ/m^2"
""")
    told = jkr("check", "thin.toml", "--json").told
    options = {option["name"]: option for option in told["options"]}
    assert "needs 9000 nodes for 100 radii (limit 4000)" in options["layered"]["refusal"]
    assert told["method"] == "fem"
    assert options["closed-form"]["forecast"]["error"] < 0.03  # of a smaller contact: it falls as h/a


@pytest.mark.parametrize(
    ("mib", "words"), [(12.3, "12 MiB"), (3482.0, "3.4 GiB"), (624_860_593.0, "596 TiB"), (1e13, "more than 1,000 TiB")]
)
def test_memory_in_words(mib: float, words: str) -> None:
    assert process.memory_words(mib) == words


def test_free_memory_is_known_without_a_file_of_the_system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "CGROUP", tmp_path)
    there = process.free_memory()
    monkeypatch.setattr(process, "MEMINFO", tmp_path / "none")
    assert process.free_memory() == pytest.approx(there, rel=0.3)
    import psutil

    def fails(*_: object) -> None:
        raise FileNotFoundError("/proc/meminfo")

    monkeypatch.setattr(psutil, "virtual_memory", fails)  # as without /proc
    assert 0 < process.free_memory() < math.inf
    monkeypatch.setattr(process.os, "sysconf", fails)  # not even by calls of the system: it is said
    assert process.free_memory() == math.inf
    told = check_cost("x", Forecast(1.0, 4096.0, 0.0), Limits())
    assert told.endswith("how much memory is free is not known")


def test_every_curve_counts_in_the_memory(jkr: Callable) -> None:
    assert jkr("run", CASES / "halfspace.toml", "-o", "h.h5").code == 0
    works = [word for i in range(2500) for word in ("--w", f"{1e-3 * (1 + i / 2500):.8f}")]
    jkr("transform", "h.h5", *works, "--no-plots", "--limit-memory", "0.5", "-o", "o").refused("the limit is 0.5 GiB")
    jkr("pull-off", "h.h5", *works, "--limit-memory", "0.5").refused("the limit is 0.5 GiB")


@pytest.mark.slow
def test_pictures_count_in_the_memory(jkr: Callable) -> None:
    assert jkr("run", CASES / "halfspace.toml", "-o", "h.h5").code == 0
    works = [word for i in range(30) for word in ("--w", f"{1e-3 * (1 + i / 30):.8f}")]
    jkr("transform", "h.h5", *works, "--limit-memory", "0.2", "-o", "o").refused("the limit is 0.2 GiB")
    assert jkr("transform", "h.h5", *works, "--no-plots", "--limit-memory", "0.2", "-o", "o").code == 0


def test_check_of_many_layers_is_announced(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    from jkrcli.report.check import Check

    layers = ", ".join(f'{{ thickness = "0.1 um", E = "{i % 5 + 1} MPa", nu = 0.3 }}' for i in range(1000))
    Path("x.toml").write_text(
        f'indenter = {{ shape = "paraboloid", radius = "1 mm" }}\nspecimen.layers = [{layers}]\n'
        "specimen.half_space = { E = '10 MPa', nu = 0.3 }\nloading = { radius = 5e-5, points = 20 }\n"
        "adhesion = { w = 0.05 }\n"
    )
    monkeypatch.setattr(Check, "of", lambda *_: (_ for _ in ()).throw(Refusal("looked at")))
    done = jkr("check", "x.toml")
    assert "jkr: check of 1,000 layers for 1 work of adhesion: about 10 s of CPU time" in done.err

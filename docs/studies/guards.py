"""Forecasts against what is forecast, over all that grows; how soon what is too much is refused or announced."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from jkrcli.base.files import write_csv
from jkrcli.bodies.problem import Problem
from jkrcli.case.models import Case, parse_case
from jkrcli.case.store import solve
from jkrcli.cli import call as jkr
from jkrcli.cli.cycle import TABLE_CYCLE_PER_POINT, TABLE_CYCLE_PER_ROW
from jkrcli.cli.inputs import PER_FILE, TABLE_PER_ROW
from jkrcli.fem.solver import FEM
from jkrcli.hybrid.solver import Hybrid
from jkrcli.many.maps import map_of
from jkrcli.many.sweep import Means, sweep
from jkrcli.many.sweep import forecast as forecast_of_sweep
from jkrcli.many.sweep_plan import load_plan
from jkrcli.measured.afm_formats import estimate_rows
from jkrcli.measured.files import each
from jkrcli.measured.readings import TABLE_FIT_PER_ROW, TABLE_REFIT, TABLE_REFIT_PER_ROW, TABLE_WORK_PER_ROW
from jkrcli.methods.layered.solver import Layered
from jkrcli.report.tables import curve_columns, summary
from jkrcli.resolve.analysis import JKR, analyse, forecast
from jkrcli.series import RawSeries, Solution

from .command import call, parser_of

Pair: TypeAlias = tuple[float, Callable[[], object]]  # a forecast [CPU s], and what it is of
FACTOR, SOON = 3.0, 2.0  # what is demanded: of a forecast over the truth, and of the CPU seconds to the first word
AGAIN = 1.0000001  # times all moduli: a body that no cache knows

CASE = """
method = "{method}"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
{body}
loading = {{ radius = {radius}, {points} }}
adhesion = {{ w = {w} }}
"""
HALF_SPACE = 'specimen.half_space = { E = "1 MPa", nu = 0.3 }'
LAYER = 'specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]'


def text(method: str = "layered", body: str = LAYER, radius: str = "1e-4", points: str = "points = 20") -> str:
    return CASE.format(method=method, body=body, radius=radius, points=points, w="0.05")


def stack(layers: int) -> str:
    each_layer = ('{{ thickness = "{}", E = "{} MPa", nu = 0.3 }}'.format("0.1 um" if i else "100 um", i % 5 + 1)
                  for i in range(layers))  # fmt: skip
    return f"specimen.layers = [{', '.join(each_layer)}]\nspecimen.half_space = {{ E = '10 MPa', nu = 0.3 }}"


def graded(points: int) -> str:
    depths = ", ".join(f"{depth:.12g}" for depth in np.linspace(0, 1e-4, points))
    moduli = ", ".join(f"{1e6 * (2 + i % 7 / 7):.12g}" for i in range(points))
    return f"specimen.layers = [{{ thickness = 1e-4, nu = 0.3, E = {{ depth = [{depths}], E = [{moduli}] }} }}]"


def case(*words: str) -> Case:
    return parse_case(text(*words).encode(), "study")


# ---------------------------------------------------------------------- forecasts
def of_solve(method: Layered | Hybrid | FEM, problem: Problem) -> Pair:
    other = replace(problem, specimen=problem.specimen.scaled(AGAIN))
    return method.forecast(problem).seconds, lambda: method(other)


def layers(count: int) -> Pair:
    return of_solve(Layered(), case("layered", stack(count), "5e-5").model.problem())


def points(count: int) -> Pair:
    return of_solve(Layered(), case("layered", LAYER, "1e-4", f"points = {count}").model.problem())


def points_hybrid(count: int) -> Pair:
    return of_solve(Hybrid(), case("hybrid", LAYER, "1e-4", f"points = {count}").model.problem())


def graded_points(count: int) -> Pair:
    return of_solve(Layered(), case("layered", graded(count), "1e-5").model.problem())


def elements(count: int) -> Pair:
    """Elements go with the inverse square of the spacing."""
    problem = case("fem").model.problem()
    first = FEM()
    cells = first.mesh(problem).cells.shape[0]
    return of_solve(FEM(spacing=first.spacing * (cells / count) ** 0.5), problem)


def values(count: int) -> Pair:
    radii = f"[{', '.join(f'{a:.9g}' for a in np.linspace(1e-6, 1e-4, count))}]"
    return of_solve(FEM(), parse_case(CASE.format(method="fem", body=LAYER, radius=radii, points="", w=0.05)
                                      .replace(",  }", " }").encode(), "study").model.problem())  # fmt: skip


def solution(rows: int) -> Solution:
    return solve(case("closed-form", HALF_SPACE, "1e-4", f"points = {rows}"))[1]


def of_curves(held: Solution, works: Sequence[float]) -> Pair:
    def write() -> None:
        for result in analyse(held, works):
            summary(result)
            write_csv(Path("curve.csv"), curve_columns(result.curve))

    return forecast(held, works, JKR).seconds, write


def rows_of_series(rows: int) -> Pair:
    return of_curves(solution(rows), (0.05,))


def works(count: int) -> Pair:
    return of_curves(solution(100), [0.05 * 0.97**i for i in range(count)])


def rows_of_noisy_series(rows: int) -> Pair:
    held = solution(rows)
    rng, series = np.random.default_rng(1), held.series
    noise = 1 + 1e-3 * rng.standard_normal((3, rows))
    raw = RawSeries(series.a * noise[0], series.delta * noise[1], series.P * noise[2], np.arange(rows))
    bare = replace(series, S=None, dS=None, errors={})
    return of_curves(replace(held, raw=raw, series=bare), (0.05,))


OUT = "[outputs]\nradii = [{}]\n"
SWEEP = """
[base]
{}
[[axes]]
key = "specimen.half_space.nu"
from = 0.1
to = 0.4
count = {}
"""


def cases(count: int) -> Pair:
    Path("many.toml").write_text(SWEEP.format(text("closed-form", HALF_SPACE), count))
    plan = load_plan(Path("many.toml"))
    groups, _ = plan.groups(range(plan.count))
    return forecast_of_sweep(plan, groups), lambda: sweep(plan, Path("swept"), Means(workers=1), False, lambda _: None)


def table(rows: int, decimal: str = ".") -> Path:
    """An adhesive curve with noise, measured."""
    a = np.linspace(9e-5, 1e-5, rows)
    E_star = 1e6 / (1 - 0.3**2)
    root = np.sqrt(2 * np.pi * 0.05 * a / E_star)
    P = (4 * E_star * a**3 / 3e-3 - 2 * E_star * a * root) * (1 + 1e-3 * np.random.default_rng(1).standard_normal(rows))
    buffer = io.StringIO()
    np.savetxt(buffer, np.column_stack([a, a**2 / 1e-3 - root, P]), "%.8g", ";", header="a_m;delta_m;P_N", comments="")
    path = Path(f"table{rows}.csv")
    path.write_text(buffer.getvalue().replace(".", decimal))
    return path


def rows_of_table(rows: int, decimal: str = ".") -> Pair:
    path = table(rows, decimal)
    return TABLE_PER_ROW * estimate_rows(path), lambda: list(each(path))


def rows_of_table_with_commas(rows: int) -> Pair:
    return rows_of_table(rows, ",")


def columns_of_table(count: int) -> Pair:
    """Of tables of as many cells, all of 8 bytes."""
    names = ",".join(["delta_m", "P_N", *(f"c{i}" for i in range(count - 2))])
    rows = (",".join([f"{i % 97:07d}"] * count) for i in range(4_000_000 // count))
    path = Path(f"wide{count}.csv")
    path.write_text("\n".join([names, *rows]))
    return TABLE_PER_ROW * estimate_rows(path), lambda: list(each(path))


def rows_of_compared_curves(rows: int) -> Pair:
    a, path = np.linspace(1e-6, 1e-4, rows), Path("curve.csv")
    write_csv(path, {"a_m": a, "delta_m": a**2 / 1e-3, "P_N": 1e9 * a**3})
    return TABLE_PER_ROW * 2 * estimate_rows(path), lambda: jkr(["compare", str(path), str(path)])


def files_shown(count: int) -> Pair:
    Path("s.toml").write_text(text("closed-form", HALF_SPACE))
    jkr(["run", "s.toml", "-q"])
    return PER_FILE * count, lambda: jkr(["show", *["s.h5"] * count])


def devices_of_pull_off(count: int) -> Pair:
    Path("s.toml").write_text(text("closed-form", HALF_SPACE, "1e-4", "points = 100"))
    words = several("--stiffness", np.geomspace(1.0, 1e6, count))
    seconds = forecast(solution(100), (0.05,), JKR, False, False, count).seconds
    return seconds, lambda: jkr(["pull-off", "s.toml", *words])


def rows_of_program(rows: int) -> Pair:
    """To and fro, each row another speed."""
    Path("s.toml").write_text(text("closed-form", HALF_SPACE, "1.5e-4", "points = 100"))
    x = 3e-6 + 2e-6 * np.sin(np.linspace(0, 60, rows)) * np.linspace(0.5, 1, rows)
    np.savetxt("x.csv", np.column_stack([np.linspace(0, 20, rows), x]), "%.8g", ",", header="t_s,x_m", comments="")
    seconds = (TABLE_PER_ROW + TABLE_CYCLE_PER_ROW + 200 * TABLE_CYCLE_PER_POINT) * rows
    words = ["--rate", "v0=1e-6,n=0.6", "--program", "x.csv", "--no-plots"]
    return seconds, lambda: jkr(["cycle", "s.toml", *words])


def samples_of_bootstrap(count: int) -> Pair:
    Path("s.toml").write_text(text("closed-form", HALF_SPACE))
    path = table(200)
    seconds = (TABLE_PER_ROW + TABLE_FIT_PER_ROW + count * TABLE_REFIT_PER_ROW) * 200 + count * TABLE_REFIT
    words = ["--confidence", "bootstrap", "--samples", str(count), "--workers", "1", "--no-plots", "-q", "--force"]
    return seconds, lambda: jkr(["fit", "s.toml", str(path), *words])


def radii_of_sweep(count: int) -> Pair:
    radii = ", ".join(f"{a:.9g}" for a in np.linspace(1e-5, 1e-4, count))
    Path("many.toml").write_text(
        SWEEP.format(text("closed-form", HALF_SPACE), 20).replace("[[", f"{OUT.format(radii)}[[", 1)
    )
    plan = load_plan(Path("many.toml"))
    groups, _ = plan.groups(range(plan.count))
    return forecast_of_sweep(plan, groups), lambda: sweep(plan, Path("swept"), Means(workers=1), False, lambda _: None)


def rows_of_fit(rows: int) -> Pair:
    Path("s.toml").write_text(text("closed-form", HALF_SPACE))
    path = table(rows)
    seconds = (TABLE_PER_ROW + TABLE_FIT_PER_ROW) * estimate_rows(path)
    return seconds, lambda: jkr(["fit", "s.toml", str(path), "--no-plots", "-q", "--force"])


def rows_of_work(rows: int) -> Pair:
    Path("s.toml").write_text(text("closed-form", HALF_SPACE))
    path = table(rows)
    seconds = (TABLE_PER_ROW + TABLE_WORK_PER_ROW) * estimate_rows(path)
    return seconds, lambda: jkr(["work", "s.toml", str(path), "--no-plots", "-q", "--force"])


# ---------------------------------------------------------------------- forecasts of maps
def several(option: str, values: Iterable[float]) -> list[str]:
    return [word for value in values for word in (option, f"{value:.6g}")]


def mapped(name: str, **axes: Any) -> Pair:
    """A map in this process alone, so that its CPU time is counted."""
    words = [word for key, values in axes.items() for word in several(f"--{key}", values)]
    return map_of(name).forecast(**axes), lambda: jkr(["study", f"{name}-map", "--no-plots", "--workers", "1", *words])


def speeds_of_rate_map(count: int) -> Pair:
    """On a half-space and a layer, of two devices."""
    return mapped("rate", speed=np.geomspace(1e-4, 100, count))


def ranges_of_transition_map(count: int) -> Pair:
    return mapped("transition", q=[1.0], mu=np.geomspace(0.1, 30, count))


def ranges_of_adhesion_map(count: int) -> Pair:
    return mapped("adhesion", mu=np.geomspace(0.02, 50, count))


def ratios_of_poisson_of_sticking_map(count: int) -> Pair:
    return mapped("sticking", nu=np.geomspace(0.1, 0.5, count), ratio=np.geomspace(0.05, 10, 9))


def radii_of_sticking_map(count: int) -> Pair:
    return mapped("sticking", ratio=np.geomspace(0.05, 10, count))


def ratios_of_poisson_of_pull_off_map(count: int) -> Pair:
    return mapped("pull-off", nu=np.geomspace(0.1, 0.5, count), q=[1.0])


def works_of_pull_off_map(count: int) -> Pair:
    return mapped("pull-off", q=np.geomspace(1e-3, 1e4, count))


FORECASTS: dict[Callable[[int], Pair], tuple[int, ...]] = {
    layers: (1, 10, 100, 1000, 2400),
    graded_points: (3, 20, 200),
    points: (100, 1000, 1900),
    points_hybrid: (100, 1000, 1900),
    elements: (2_000, 20_000, 100_000),
    values: (1_000, 100_000),
    rows_of_series: (100, 10_000, 100_000),
    works: (3, 30, 300),
    rows_of_noisy_series: (100, 1_000, 10_000, 100_000),
    cases: (100, 1_000, 3_000),
    rows_of_table: (100_000, 1_000_000),
    rows_of_table_with_commas: (100_000, 1_000_000),
    speeds_of_rate_map: (13, 100),
    ranges_of_transition_map: (17, 100),
    ranges_of_adhesion_map: (29, 200),
    ratios_of_poisson_of_sticking_map: (6, 40),
    radii_of_sticking_map: (9, 1_000),
    ratios_of_poisson_of_pull_off_map: (30, 300),
    works_of_pull_off_map: (30, 1_000),
    columns_of_table: (12, 100, 1_000),
    rows_of_fit: (10_000, 100_000, 1_000_000),
    rows_of_work: (10_000, 100_000, 1_000_000),
    rows_of_compared_curves: (100_000, 1_000_000),
    files_shown: (300, 1_000),
    devices_of_pull_off: (30, 300, 2_000),
    rows_of_program: (100, 1_000),
    samples_of_bootstrap: (100, 1_000),
    radii_of_sweep: (100, 1_000),
}


def measured(grows: Callable[[int], Pair], size: int) -> tuple[float, float]:
    """Forecast and truth [CPU s] in a folder and a process of their own."""
    os.chdir(tempfile.mkdtemp())
    seconds, action = grows(size)
    start = time.process_time()
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        action()
    return seconds, time.process_time() - start


def forecasts() -> Iterator[tuple[str, int, float, float]]:
    """What grows, its size, forecast and truth [CPU s]."""
    for grows, sizes in FORECASTS.items():
        for size in sizes:
            with ProcessPoolExecutor(1, get_context("spawn")) as pool:
                yield (grows.__name__.replace("_", " "), size, *pool.submit(measured, grows, size).result())


# ---------------------------------------------------------------------- the first word
def too_much() -> Iterator[tuple[str, list[str]]]:
    """What is refused or announced, and the command that asks for it; writes what the commands read."""

    def file(name: str, content: str) -> str:
        Path(name).write_text(content)
        return name

    jkr(["run", file("s.toml", text("closed-form", HALF_SPACE)), "-q"])
    yield "20,000 layers", ["check", file("layers.toml", text("auto", stack(20_000)))]
    yield "graded at 20,001 depths", ["check", file("graded.toml", text("auto", graded(20_001)))]
    yield "graded at 900 depths", ["check", file("graded.toml", text("auto", graded(900)))]
    yield "100,000 points", ["run", file("points.toml", text(points="points = 100000"))]
    yield "1.5 million keys", ["check", file("keys.toml", "".join(f"k{i} = 1\n" for i in range(1_500_000)))]
    yield "a mesh beyond counting", ["run", file("fem.toml", text("fem") + "mesh.spacing = 1e-6\n")]
    yield "100,000 rows, 50 w", ["transform", "long.h5", *(word for i in range(50) for word in ("--w", f"{i + 1}e-3"))]
    yield "49,000 works of adhesion", ["transform", "s.h5", *(w for i in range(49_000) for w in ("--w", f"{1 + i}e-6"))]
    more = '[[axes]]\nkey = "loading.radius"\nfrom = 5e-5\nto = 1e-4\ncount = 2000\n'
    many = SWEEP.format(text("fem", HALF_SPACE), 1000) + more
    yield "2 million cases", ["sweep", file("many.toml", many), "-o", "swept"]
    lots = SWEEP.format(text("closed-form", HALF_SPACE), 3) + OUT.format(", ".join(["1e-5"] * 1_000_000))
    yield "1 million radii of a sweep", ["sweep", file("lots.toml", lots)]
    yield "2,000 devices", ["pull-off", "s.h5", *several("--stiffness", np.geomspace(1.0, 1e6, 2_000))]
    yield "3,000 files", ["show", *["s.h5"] * 3_000]
    program = file("x.csv", "t_s,x_m\n" + "".join(f"{i:06d},1e-6\n" for i in range(10_000)))
    yield "a program of 10,000 rows", ["cycle", "s.h5", "--rate", "v0=1e-6,n=0.6", "--program", program]
    samples = ["--confidence", "bootstrap", "--samples", "100000"]
    yield "a bootstrap of 100,000 samples", ["fit", "s.h5", str(table(200)), *samples]
    yield "two curves of 3 million rows", ["compare", str(table(3_000_000)), str(table(3_000_000))]
    with Path("huge.csv").open("wb") as huge:
        huge.truncate(900 << 20)
    yield "a table of 900 MiB", ["look", "huge.csv"]
    yield "a table of 4 million rows", ["look", str(table(4_000_000))]
    yield "a fit of 1 million rows", ["fit", "s.h5", str(table(1_000_000))]


def first_word(words: list[str]) -> tuple[float, str]:
    """CPU seconds of a process of jkr up to its first line on stderr, and that line."""
    process = subprocess.Popen([sys.executable, "-m", "jkrcli", *words], stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True)  # fmt: skip
    assert process.stderr is not None
    line = process.stderr.readline()
    process.kill()
    usage = os.wait4(process.pid, 0)[2]
    process.returncode = 0
    return usage.ru_utime + usage.ru_stime, line.strip()


def main(words: Sequence[str] | None = None) -> int:
    """Compare forecasts with what is forecast, each in a process of its own, and time refusals and announcements.

    Prints two tables. The exit code is 1 where a forecast is wrong by more than a factor of three, or the first word
    comes after more than two CPU seconds.
    """
    parser_of(str(main.__doc__), parallel=False).parse_args(words)
    held = True
    print("| what grows | size | forecast [CPU s] | measured [CPU s] | ratio |\n|---|---|---|---|---|")
    for name, size, seconds, truth in forecasts():
        held &= 1 / FACTOR < seconds / truth < FACTOR
        print(f"| {name} | {size:,} | {seconds:.2g} | {truth:.2g} | {seconds / truth:.2f} |", flush=True)
    print("\n| what is too much | first word after [CPU s] | it |\n|---|---|---|")
    os.chdir(tempfile.mkdtemp())
    for name, line in too_much():
        if "long.h5" in line:
            Path("long.toml").write_text(text("closed-form", HALF_SPACE, points="points = 100000"))
            jkr(["run", "long.toml", "-q"])
        spent, said = first_word(line)
        held &= bool(said) and spent < SOON
        print(f"| {name} | {spent:.2g} | {said[:100]} |", flush=True)
    return int(not held)


if __name__ == "__main__":
    sys.exit(call(main))

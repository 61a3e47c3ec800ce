"""What is wrong with noise: errors that go together, outliers, drift, few points, through import and transform.

A table of an exact series with a kind of error is read as ``jkr import`` reads it and analysed as ``jkr transform``
does.
A cell is one body, kind, size of the noise and number of points; its figures are over many seeds.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from jkrcli.adhesion.curve import CriticalPoint, transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, Unknown
from jkrcli.base.numerics import Array
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import Record, Series

from .noise_cells import BODIES, Body

DRIFT = 0.05  # of the load, over the record
OUTLIERS = 0.05  # share of the readings, of ten times the noise
NOISE = (1e-3, 1e-2, 3e-2)  # relative, of a, delta and P


@dataclass(frozen=True)
class DisturbedCell:
    """Figures of one cell of that many ``seeds``, shares of them.

    ``refused``; ``warned`` of what is wrong with the data; ``unknown``: no error is stated; ``held``: the exact
    pull-off force lies in its 95 % band, of all that state one, and ``unwarned_held``, of those without a warning;
    ``median``: of the error of the force, ``half_width``: of that stated.
    """

    body: str
    points: int
    kind: str
    noise: float
    seeds: int
    refused: float
    warned: float
    unknown: float
    held: float
    unwarned_held: float
    median: float
    half_width: float


def autoregressive(random: np.random.Generator, n: int, rho: float) -> Array:
    """Normal numbers of variance 1 of which neighbours correlate by ``rho``, (n,)."""
    fresh = random.standard_normal(n)
    found = fresh.copy()
    for i in range(1, n):
        found[i] = rho * found[i - 1] + np.sqrt(1 - rho**2) * fresh[i]
    return found


def _independent(random: np.random.Generator, n: int) -> Array:
    return random.standard_normal(n)


def _with_outliers(random: np.random.Generator, n: int) -> Array:
    return random.standard_normal(n) * np.where(random.random(n) < OUTLIERS, 10.0, 1.0)


KINDS: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "independent": _independent,
    "AR(1) 0.5": partial(autoregressive, rho=0.5),
    "AR(1) 0.9": partial(autoregressive, rho=0.9),
    "outliers": _with_outliers,
    "drift": _independent,
}


def disturbed(exact: Series, kind: str, noise: float, seed: int) -> Array:
    """The columns a, delta, P, (3, n), of ``exact`` with relative errors of a ``kind``."""
    random, n = np.random.default_rng(seed), len(exact)
    columns = np.stack([v * (1 + noise * KINDS[kind](random, n)) for v in (exact.a, exact.delta, exact.P)])
    if kind == "drift":
        columns[2] *= 1 + DRIFT * np.linspace(0, 1, n)
    return columns


def cell(body: Body, points: int, kind: str, noise: float, seeds: Iterable[int]) -> DisturbedCell:
    """The figures of one cell."""
    exact = body.series(points)
    truth = transform(exact, slopes(exact, "exact"), body.w).pull_off(0.0)
    assert isinstance(truth, CriticalPoint)
    runs = [_run(body, exact, truth.P, kind, noise, seed) for seed in seeds]
    good = [run for run in runs if run is not None]
    told = [run for run in good if run.half_width is not None]
    quiet = [run for run in told if not run.warned]
    return DisturbedCell(
        body.name,
        points,
        kind,
        noise,
        len(runs),
        1 - len(good) / len(runs),
        _share([run.warned for run in good]),
        1 - len(told) / max(len(good), 1),
        _share([run.held for run in told]),
        _share([run.held for run in quiet]),
        float(np.median([abs(run.error) for run in good])),
        float(np.median([run.half_width for run in told])) if told else np.nan,
    )


def _share(values: Sequence[bool]) -> float:
    return float(np.mean(values)) if values else np.nan


@dataclass(frozen=True)
class Run:
    """One seed: relative error of the pull-off force, its half-width, and what is said of the data."""

    error: float
    half_width: float | None
    words: tuple[str, ...]

    @property
    def warned(self) -> bool:
        return bool(self.words)

    @property
    def held(self) -> bool:
        return self.half_width is not None and abs(self.error) <= self.half_width


def _run(body: Body, exact: Series, truth: float, kind: str, noise: float, seed: int) -> Run | None:
    columns = disturbed(exact, kind, noise, seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        np.savetxt(path, columns.T, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.17g")
        try:
            solution = read_series(path, body.problem(len(exact)), SeriesReading())
            solution = replace(solution, record=Record(z0=1e-15))  # far from where the range of adhesion matters
            (result,) = analyse(solution, [body.w])
        except InputError as error:
            print(f"    refused: {error}")
            return None
    point = result.pull_off["load"]
    if isinstance(point, Unknown):
        return Run(np.inf, None, (str(point),))
    half_widths = result.pull_off_errors["load"]
    told = None if isinstance(half_widths, Unknown) else half_widths["P"] / abs(truth)
    return Run(point.P / truth - 1, told, tuple(result.warnings))


def cells(bodies: Sequence[Body], seeds: int, points: Sequence[int] = (15, 60, 500)) -> Iterable[DisturbedCell]:
    """All cells, each as it is done."""
    for body, n, kind, noise in itertools.product(bodies, points, KINDS, NOISE):
        if not (n == 15 and kind == "drift"):
            yield cell(body, n, kind, noise, range(seeds))


def main(words: Sequence[str] | None = None) -> int:
    """Print the table of all cells; 500 seeds take an hour and a half on one core."""
    parser = argparse.ArgumentParser(description=str(main.__doc__))
    parser.add_argument("--seeds", type=int, default=500)
    parser.add_argument("--body", action="append", choices=[body.name for body in BODIES])
    parser.add_argument("--points", action="append", type=int)
    given = parser.parse_args(words)
    chosen = [body for body in BODIES if body.name in (given.body or ("hertz", "layer-0.499"))]
    print(f"{'body':<14}{'points':>7} {'kind':<12}{'noise':>7}{'seeds':>7}{'refused':>9}{'warned':>8}{'unknown':>9}"
          f"{'held':>7}{'quiet':>7}{'median':>10}{'stated':>10}")  # fmt: skip
    for it in cells(chosen, given.seeds, given.points or (15, 60, 500)):
        print(f"{it.body:<14}{it.points:>7} {it.kind:<12}{it.noise:>7g}{it.seeds:>7}{it.refused:>9.1%}{it.warned:>8.1%}"
              f"{it.unknown:>9.1%}{it.held:>7.1%}{it.unwarned_held:>7.1%}{it.median:>10.2e}{it.half_width:>10.2e}",
              flush=True)  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Whether the bands of series on meshes with elements of any sizes hold: series drawn by the tests' generator.

Each series is imported, beside the exact solution of its bodies where these are known, and transformed by a rule.
Counts by mesh and control at a level: bands that hold, and how many times too large they are stated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from meshed_series import MESHES, MeshedSeries, drawn  # type: ignore[import-not-found]

from jkrcli.base.errors import JkrError, Unknown
from jkrcli.base.numerics import HALF_WIDTH, half_width
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series

from .command import call, parser_of

ABOUT = "Bands of imported series on meshes of six kinds: a table (600 series take four CPU minutes)"
CONTROLS = ("load", "displacement")
FEWEST, FEW = 0.82, 0.87  # of each kind and of all, that are to be held
RATIO, RATIO_OF_NODES = 5.0, 3.0  # stated over true, the median, and with the nodes of the meshes


@dataclass(frozen=True)
class Judged:
    """The relative error of a pull-off force and its stated half-width; NaN where there is none."""

    kind: str
    control: str
    known: bool
    error: float
    stated: float


def judge(series: MeshedSeries, folder: Path, rule: str, nodes: bool) -> Iterator[Judged]:
    """One series, imported and transformed; ``nodes``: with those of its mesh."""
    file = series.write_nodes(folder) if nodes else None
    try:
        reading = SeriesReading(compare=series.known, nodes=file)
        solution = read_series(series.write(folder), series.body.problem, reading)
        result = analyse(solution, [series.w], rule)[0]
    except JkrError:
        yield from (Judged(series.kind, control, series.known, np.nan, np.nan) for control in CONTROLS)
        return
    for control in CONTROLS:
        true, point, half = series.true(control)[2], result.pull_off[control], result.pull_off_errors.get(control)
        if half is None or isinstance(half, Unknown) or isinstance(point, Unknown):
            yield Judged(series.kind, control, series.known, np.nan, np.nan)
        else:
            yield Judged(series.kind, control, series.known, point.P / true - 1, half["P"] / abs(true))


def line(name: str, rows: Sequence[Judged], narrower: float) -> tuple[str, float, float]:
    """A line of the table, the share that is held and the median of stated over true."""
    error, stated = np.array([(abs(row.error), narrower * row.stated) for row in rows]).T
    told = np.isfinite(stated)
    held, ratio = float(np.mean(error <= stated)), float(np.median(stated[told] / error[told]))
    sizes = f"{np.median(error[told]):>9.1e}{np.median(stated[told]):>9.1e}{ratio:>7.1f}"
    return f"  {name:<26}{len(rows):>7}{told.sum():>7}{held:>7.0%}{sizes}", held, ratio


def main(words: Sequence[str] | None = None) -> int:
    """The study; prints its table; 1 where bands hold too seldom, or are too wide."""
    parser = parser_of(ABOUT)
    parser.add_argument("--each", type=int, default=100, help="series on each kind of mesh [default: 100]")
    parser.add_argument("--seed", type=int, default=1, help="of what is drawn [default: 1]")
    parser.add_argument("--rule", default="auto", help="slopes [default: auto]")
    parser.add_argument("--nodes", action="store_true", help="with the nodes of the meshes")
    parser.add_argument("--level", type=float, default=0.9, help="at which bands are counted [default: 0.9]")
    given = parser.parse_args(words)
    with TemporaryDirectory() as folder:
        series = drawn(given.each, given.seed)
        rows = [row for one in series for row in judge(one, Path(folder), given.rule, given.nodes)]
    narrower = half_width(given.level) / HALF_WIDTH
    print(f"  {'':<26}{'series':>7}{'known':>7}{'held':>7}{'error':>9}{'stated':>9}{'ratio':>7}")
    sound = True
    for control in CONTROLS:
        ours = [row for row in rows if row.control == control]
        for kind in MESHES:
            text, held, _ = line(f"{control}, {kind}", [row for row in ours if row.kind == kind], narrower)
            sound &= held >= FEWEST or given.rule != "auto"
            print(text)
        for known, name in ((True, "bodies known"), (False, "bodies not known")):
            print(line(f"{control}, {name}", [row for row in ours if row.known == known], narrower)[0])
        text, held, _ = line(f"{control}, all", ours, narrower)
        sound &= held >= (FEW if given.rule == "auto" else 0.85)
        print(text)
    text, _, ratio = line("all", rows, narrower)
    print(text)
    return int(not (sound and ratio <= (RATIO_OF_NODES if given.nodes else RATIO)))


if __name__ == "__main__":
    sys.exit(call(main))

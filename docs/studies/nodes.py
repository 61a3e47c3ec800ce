"""Whether the bands of series with contact radii of nodes hold: drawn series of twelve bodies by the tests' generator.

Each series is imported beside the exact solution of its bodies and without it, and transformed by a rule. Counts per
part of an element by which the edge runs ahead: bands that hold, errors, and how many times too large they are stated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from node_series import NodeSeries, many  # type: ignore[import-not-found]

from jkrcli.base.errors import JkrError, Unknown
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series

from .command import call, parser_of

ABOUT = "Bands of imported series whose contact radii are those of nodes: a table (400 series take three CPU minutes)"
CONTROLS = ("load", "displacement")


@dataclass(frozen=True)
class Judged:
    """The relative error of a pull-off force and its stated 95 % half-width; NaN where there is none."""

    series: NodeSeries
    control: str
    error: float
    stated: float


def judge(series: NodeSeries, folder: Path, rule: str, compare: bool) -> Iterator[Judged]:
    """One series, imported and transformed."""
    try:
        path = series.write(folder / "series.csv")
        reading = SeriesReading(area="projected" if series.area else "auto", compare=compare)
        solution = read_series(path, series.body.problem, reading)
        result = analyse(solution, [series.w], rule)[0]
    except JkrError:
        yield from (Judged(series, control, np.nan, np.nan) for control in CONTROLS)
        return
    for control in CONTROLS:
        true, point, half = series.exact(control)[2], result.pull_off[control], result.pull_off_errors.get(control)
        if half is None or isinstance(half, Unknown) or isinstance(point, Unknown):
            yield Judged(series, control, np.nan, np.nan)
        else:
            yield Judged(series, control, point.P / true - 1, half["P"] / abs(true))


def table(rows: Sequence[Judged]) -> Iterator[str]:
    """Counts, for all series and for those of one part of an element."""
    yield f"  {'control':<14}{'o':<8}{'series':>7}{'known':>7}{'held':>7}{'error':>9}{'stated':>9}{'ratio':>7}"
    for control in CONTROLS:
        for o in (None, 0.0, 0.15, 0.3):
            chosen = [row for row in rows if row.control == control and o in (None, row.series.ahead)]
            error, stated = np.array([(abs(row.error), row.stated) for row in chosen if row.stated > 0]).T
            held, ratio = np.mean(error <= stated), np.median(stated / error)
            name = "all" if o is None else f"{o:g}"
            yield (
                f"  {control:<14}{name:<8}{len(chosen):>7}{error.size:>7}{held:>7.0%}{np.median(error):>9.1e}"
                f"{np.median(stated):>9.1e}{ratio:>7.1f}"
            )


def main(words: Sequence[str] | None = None) -> int:
    """The study; prints its tables."""
    parser = parser_of(ABOUT)
    parser.add_argument("--series", type=int, default=400, help="how many are drawn [default: 400]")
    parser.add_argument("--seed", type=int, default=0, help="of what is drawn [default: 0]")
    parser.add_argument("--rule", default="auto", help="slopes [default: auto]")
    given = parser.parse_args(words)
    for compare in (True, False):
        with TemporaryDirectory() as folder:
            drawn = many(given.series, given.seed)
            rows = [row for series in drawn for row in judge(series, Path(folder), given.rule, compare)]
        print("beside the exact solution of the bodies" if compare else "without it")
        print("\n".join(table(rows)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

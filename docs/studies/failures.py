"""The failure map, where each method is right, refuses, or errs: its command, table and pictures."""

from __future__ import annotations

import datetime
import itertools
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

import numpy as np

from jkrcli.base.files import as_json
from jkrcli.methods.protocol import METHODS
from jkrcli.report.plots import BLACK, BLUE, GREEN, ORANGE, PURPLE, WIDE, Axes, Figure, drawing
from jkrcli.report.result import PICTURES

from .command import call, output_of, parser_of, pool_of
from .failures_cells import AXES, BODIES, SHAPES, Cell
from .failures_judge import (
    BUGS,
    CRASHED,
    OUTCOMES,
    REFUSED,
    RIGHT,
    SAID,
    SILENT,
    TOO_SLOW,
    UNJUDGED,
    Verdict,
    counts,
    failures,
    random_cells,
)  # fmt: skip

FIRST = ("method", "outcome", "nu", "a_over_h")


def main(words: Sequence[str] | None = None) -> int:
    """Solve random problems, from the ordinary to the absurd, and compare each with the exact solution.

    Poisson's ratio to 1/2, contact from a thousandth to a hundred layer thicknesses, contrasts, indenters, few and many
    points, nodes and increments, noise, any units. A cell is right within its stated error, wrong and said so (refused,
    warned, error unknown), too slow (60 CPU s), or silently wrong: that is a bug, and the exit code is then 1.
    Writes failures.csv, .json, failures-overview.png and per method failures-<method>.png; 2,000 cells take about half
    an hour.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--cells", type=int, default=2000, help="random cells [default: 2000]")
    parser.add_argument("--seed", type=int, help="of the cells [default: today's date as a number]")
    every = [*METHODS, "slopes"]
    parser.add_argument("--methods", action="append", default=[], choices=every, help="only these")
    given = parser.parse_args(words)
    output = output_of(given)
    files = output.files(given.output / "failures", (".csv", ".json"))
    named = given.methods or every
    overview = output.files(given.output / "failures-overview", PICTURES[:1])
    pictures = {name: output.files(given.output / f"failures-{name}", PICTURES[:1]) for name in named}
    seed = int(f"{datetime.date.today():%Y%m%d}") if given.seed is None else given.seed
    with pool_of(given, given.cells) as pool:
        tell = None if output.json else Telling(given.cells)
        verdicts = failures(random_cells(given.cells, seed, given.methods), pool, tell)
    data = as_dict(verdicts, seed)
    files.write(_columns(verdicts), data)
    overview.write(figure=overview.draw(partial(overview_figure, verdicts)))
    for name in {verdict.cell.method for verdict in verdicts}:
        pictures[name].write(figure=pictures[name].draw(partial(failures_figure, verdicts, name)))
    if output.json:
        print(as_json(data), end="")
    else:
        _print(verdicts, seed)
        print(f"  written   {given.output / 'failures'}{{.csv,.json{',-<method>.png' if output.plots else ''}}}")
    return int(any(verdict.outcome in BUGS for verdict in verdicts))


@dataclass
class Telling:
    """Print bugs as they are found, and the counts so far ``every`` so many seconds, of ``total`` cells."""

    total: int
    every: float = 15.0  # choice: a line on progress is not waited for longer
    counts: Counter[str] = field(default_factory=Counter)
    last: float = field(default_factory=time.monotonic)

    def __call__(self, verdict: Verdict, done: int) -> None:
        self.counts[verdict.outcome] += 1
        if verdict.outcome in BUGS:
            print(f"  {verdict.outcome}: {verdict.words}: {verdict.cell}", flush=True)
        if time.monotonic() - self.last > self.every or done == self.total:
            self.last = time.monotonic()
            counted = ", ".join(f"{name} {self.counts[name]}" for name in OUTCOMES if self.counts[name])
            print(f"  {done} of {self.total} cells: {counted}", flush=True)


def as_dict(verdicts: Sequence[Verdict], seed: int) -> dict[str, Any]:
    """The study as JSON: how many of each outcome by method, and every silently wrong cell with all that makes it."""
    return {
        "format": "jkr-failures",
        "version": 1,
        "seed": seed,
        "counts": counts(verdicts),
        "too_slow": [vars(v.cell) for v in verdicts if v.outcome == TOO_SLOW],
        "bugs": [{"outcome": v.outcome, "words": v.words, "cell": vars(v.cell)} for v in verdicts if v.outcome in BUGS],
    }


def _columns(verdicts: Sequence[Verdict]) -> dict[str, list[Any]]:
    names = [*FIRST, *(one.name for one in fields(Cell) if one.name not in FIRST), "error", "stated", "words"]
    return {name: [_value(verdict, name) for verdict in verdicts] for name in names}


def _value(verdict: Verdict, name: str) -> Any:
    return getattr(verdict, name) if hasattr(verdict, name) else getattr(verdict.cell, name)


def _print(verdicts: Sequence[Verdict], seed: int) -> None:
    print(f"{len(verdicts)} random cells, seed {seed}")
    print(f"  {'method':<13}" + "".join(f"{outcome:>10}" for outcome in OUTCOMES))
    for method, found in counts(verdicts).items():
        print(f"  {method:<13}" + "".join(f"{found[outcome]:>10}" for outcome in OUTCOMES))
    for verdict in verdicts:
        if verdict.outcome == TOO_SLOW:
            print(f"  {verdict.outcome}: {verdict.words}: {verdict.cell}")


# ---------------------------------------------------------------------- the pictures
LOOKS = {  # colour, marker, size: the rarer and worse the larger
    RIGHT: (GREEN, ".", 3),
    SAID: (BLUE, "+", 4),
    REFUSED: (ORANGE, "x", 3.5),
    UNJUDGED: ("0.7", ".", 3),
    TOO_SLOW: (PURPLE, "v", 4),
    SILENT: (BLACK, "s", 5),
    CRASHED: (BLACK, "D", 5),
}
WORDS = {
    "shape": "indenter", "body": "body", "nu": "ν", "a_over_h": "a/h", "contrast": "E below / E on top",
    "points": "points", "nodes": "nodes in contact", "increments": "increments (0: nested)", "noise": "noise",
    "length_unit": "unit of length (m)", "force_unit": "unit of force (N)",
}  # fmt: skip
COMMON = ("nu", "a_over_h", "contrast", "points", "shape", "body", "length_unit", "force_unit")
RELEVANT = {"fem": ("nodes", "increments", *COMMON), "slopes": ("noise", *COMMON)}
CATEGORIES = {"shape": SHAPES, "body": BODIES}
SMALL = {"font.size": 7, "xtick.labelsize": 6, "ytick.labelsize": 6, "axes.grid": False}
SPACING = {"left": 0.09, "right": 0.99, "bottom": 0.09, "top": 0.99, "hspace": 0.12, "wspace": 0.12}
LEAST = {"increments": 1.0, "noise": 1e-7}  # where none stands on a logarithmic axis


def overview_figure(verdicts: Sequence[Verdict]) -> Figure:
    """Where each method is right, warns, refuses or errs: a panel per method over a/h and nu, of slopes over rows and
    noise."""
    methods = list(dict.fromkeys(verdict.cell.method for verdict in verdicts))
    with drawing(WIDE, 5.2) as figure:
        axes = figure.subplots(2, -(-len(methods) // 2), squeeze=False).ravel()
        for place, method in zip(axes, methods, strict=False):
            mine = [verdict for verdict in verdicts if verdict.cell.method == method]
            x, y = ("points", "noise") if method == "slopes" else ("a_over_h", "nu")
            _draw(place, mine, x, y)
            place.tick_params(axis="x", rotation=0)
            place.set_title(f"{method}, {len(mine)}")
        for place in axes[len(methods) :]:
            place.remove()
        marks = dict[str, Any]()
        for place in axes[: len(methods)]:
            for handle, label in zip(*place.get_legend_handles_labels(), strict=True):
                marks.setdefault(label.partition(":")[0], handle)
        figure.legend(marks.values(), marks.keys(), loc="outside lower center", ncols=len(marks))
        return figure


def failures_figure(verdicts: Sequence[Verdict], method: str) -> Figure:
    """A triangle of panels, one for every pair of the axes that matter to ``method``."""
    mine = [verdict for verdict in verdicts if verdict.cell.method == method]
    names = RELEVANT.get(method, COMMON)
    n = len(names) - 1
    with drawing(1.25 * n + 0.8, 1.25 * n + 0.8, SMALL, layout=None) as figure:
        axes = figure.subplots(n, n, squeeze=False, gridspec_kw=SPACING)
        for (row, below), (column, beside) in itertools.product(enumerate(names[1:]), enumerate(names[:-1])):
            if column > row:
                axes[row, column].remove()
                continue
            _draw(axes[row, column], mine, beside, below)
            axes[row, column].label_outer()
        figure.align_labels()
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="upper right", fontsize=9, title_fontsize=9, title=f"{method}, {len(mine)} cells"
        )
        return figure


def _draw(axes: Axes, verdicts: Sequence[Verdict], x: str, y: str) -> None:
    for outcome, (color, marker, size) in LOOKS.items():
        cells = [verdict.cell for verdict in verdicts if verdict.outcome == outcome]
        if cells:
            label = f"{outcome}: {len(cells)}"
            axes.plot([_place(cell, x) for cell in cells], [_place(cell, y) for cell in cells], marker, color=color,
                      ms=size, mew=0.8, alpha=0.8, label=label)  # fmt: skip
    axes.set(xlabel=WORDS[x], ylabel=WORDS[y])
    for name, axis, scale in ((x, axes.xaxis, axes.set_xscale), (y, axes.yaxis, axes.set_yscale)):
        if name in CATEGORIES:
            axis.set_ticks(np.arange(len(CATEGORIES[name])), CATEGORIES[name])
        elif name in AXES:
            scale("log")
    axes.tick_params(axis="x", rotation=90)


def _place(cell: object, name: str) -> float:
    value = getattr(cell, name)
    return CATEGORIES[name].index(value) if name in CATEGORIES else max(value, LEAST.get(name, value))


if __name__ == "__main__":
    sys.exit(call(main))

"""What ten wrong models leave of a record, beside the right one: residuals over position, in units of the noise.

The records are those of ``record_rivals``, made by the generator of the tests and fitted by a paraboloid (the exact
sphere where strains are large) on a half-space. Panels: the rows of both directions, and medians of neighbours.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from wrong_records import Drawn, right  # type: ignore[import-not-found]

from jkrcli.base.numerics import Array
from jkrcli.measured.curve import APPROACH
from jkrcli.measured.force_curve import ForceCurveFit
from jkrcli.measured.result import Fit
from jkrcli.report.plots import BLUE, ORANGE, WIDE, Axes, Figure, drawing, few_ticks
from jkrcli.report.result import PICTURES

from .command import call, output_of, parser_of
from .record_rivals import fitted, last, timed_scores
from .wrong_kinds import WRONG

ABOUT = "Residuals of ten wrong models and of the right one: residuals.png, residuals.svg"
SHOWN = ("layer as half-space", "w rising to four times", "Maugis mu 0.3", "surface tension", "cone", "large strains",
         "relaxation", "plastic", "creep", "hysteresis")  # fmt: skip
TITLES = {"layer as half-space": "a layer fitted as a half-space", "w rising to four times": "w that rises",
          "Maugis mu 0.3": "adhesion of range (Tabor 0.3)", "cone": "a cone fitted as a sphere",
          "plastic": "plastic indentation", "creep": "creep of the piezo", "hysteresis": "hysteresis of the piezo",
          "relaxation": "a specimen that relaxes"}  # fmt: skip

# Which record is drawn, and how.
RESIDUALS_SEED = 4  # choice: a record of each kind whose panels are typical
RESIDUALS_NOISE = 5e-4  # choice: of the largest load, the middle of what the generator draws
RESIDUALS_BEFORE = -1.4  # choice: first position shown; free rows look alike
RESIDUALS_COLUMNS = 3  # choice: panels beside each other, on the width of a page
RESIDUALS_HEIGHT = 1.55  # choice: of a panel [inch]
RESIDUALS_TOGETHER = 25  # choice: rows to a median
RESIDUALS_QUIET = 5.0  # choice: standard deviations of the noise that every panel shows at least


@dataclass(frozen=True, eq=False)
class Panel:
    """One record: the positions of its directions over the deepest, their residuals over the noise, what the fit says
    and how far off it is."""

    title: str
    rows: dict[str, tuple[Array, Array]]
    said: str


def panel(kind: str) -> Panel:
    """The record of a wrong model, or of the right one."""
    at = Drawn.of(np.random.default_rng(RESIDUALS_SEED), 1.0)
    at = replace(at, noise=RESIDUALS_NOISE * at.largest)
    made = WRONG.get(kind, right)(at)
    found = fitted(kind, made)
    plain: ForceCurveFit = last[1]
    noise = math.sqrt(plain.spread.noise.A)  # of the free rows
    rows, first = {}, 0
    for part in plain.model.stretches:
        off = plain.off[first : first + part.P.size]
        rows[part.kind], first = (part.z / part.z.max(), off / noise), first + part.P.size
    return Panel(TITLES.get(kind, kind), rows, _said(found, made.truth))


def _said(found: Fit, truth: dict[str, float]) -> str:
    """How far the values are off, and whether the fit rejects its model."""
    assert found.verdict is not None
    symbols = {"E_star": "E*", "w": "w"}
    off = {symbols[name]: round(100 * (found.estimate(name).value / true - 1)) for name, true in truth.items()}
    said = ", ".join(f"{symbol} {percent:+d}%" for symbol, percent in off.items())
    return f"{said}: {'rejected' if found.verdict.alternatives.named else 'not rejected'}"


def residuals_figure(panels: Sequence[Panel]) -> Figure:
    """Small multiples: residuals over position."""
    rows = -(-(len(panels) + 1) // RESIDUALS_COLUMNS)
    with drawing(WIDE, RESIDUALS_HEIGHT * rows, {"axes.titlesize": 8, "font.size": 8}) as figure:
        places = list(figure.subplots(rows, RESIDUALS_COLUMNS, sharex=True).flat)
        for axes, one in zip(places, panels, strict=False):
            _draw(axes, one)
        for axes in places[len(panels) :]:
            axes.set_axis_off()
        handles, labels = places[0].get_legend_handles_labels()
        places[len(panels)].legend(handles, labels, loc="center left", title="residual of the load over the noise")
        figure.supxlabel("position over the deepest one", fontsize=9)
        figure.supylabel("residual / noise", fontsize=9)
        return figure


def _draw(axes: Axes, one: Panel) -> None:
    for kind, (z, off) in one.rows.items():
        way, color = ("approach", BLUE) if kind == APPROACH else ("retraction", ORANGE)
        axes.plot(z, off, ".", color=color, ms=1.5, alpha=0.5, mew=0, rasterized=True)
        pieces = np.array_split(np.argsort(z), max(z.size // RESIDUALS_TOGETHER, 1))
        axes.plot([np.median(z[piece]) for piece in pieces], [np.median(off[piece]) for piece in pieces],
                  color=color, lw=1.1, ls="-" if kind == APPROACH else "--", label=way)  # fmt: skip
    largest = max(RESIDUALS_QUIET, *(float(np.abs(off).max()) for _, off in one.rows.values()))
    axes.set_xlim(RESIDUALS_BEFORE, 1.05)
    axes.set_ylim(-1.05 * largest, 1.05 * largest)
    axes.set_title(f"{one.title}\n{one.said}", linespacing=1.3)
    few_ticks(axes, 4)


def main(words: Sequence[str] | None = None) -> int:
    """Fit eleven records and draw what is left."""
    given = parser_of(ABOUT, parallel=False).parse_args(words)
    files = output_of(given).files(given.output / "residuals", PICTURES)
    timed_scores()
    files.write(figure=files.draw(lambda: residuals_figure([panel(kind) for kind in ("the right model", *SHOWN)])))
    print(f"  written   {files}")
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

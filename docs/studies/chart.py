"""The chart of speed against accuracy, every method on one case: its command, table and picture."""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from jkrcli.base.errors import InputError, known
from jkrcli.base.files import as_json
from jkrcli.case.models import Case, load_case
from jkrcli.methods.protocol import METHODS
from jkrcli.report.plots import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    WIDE,
    Axes,
    Figure,
    drawing,
    legend_below,
    log_ends,
    log_ticks,
    pretty,
)
from jkrcli.report.result import PICTURES

from .chart_measure import machine, yardstick
from .chart_points import (
    RECIPE,
    LeftOut,
    Measured,
    Peer,
    automatic,
    beside_front,
    chart,
    chosen_points,
    front,
    read_peers,
    settings_of,
)  # fmt: skip
from .chart_reference import reference_of
from .command import call, counted, output_of, parser_of, quantity


@dataclass(frozen=True)
class Found:
    """All that the study reports of one case."""

    case: Case
    w: float
    reference: str
    points: Sequence[Measured]
    left_out: Sequence[LeftOut]
    peers: Sequence[Peer]
    yardstick: float
    auto: str

    @property
    def front(self) -> list[int]:
        return front([_pair(point) for point in self.points])

    @property
    def auto_beside_front(self) -> bool | None:
        """Whether the method that "auto" takes lies on the front or next to it; None where it was not measured."""
        mine = chosen_points(self.points, self.auto)
        return any(beside_front(_pair(p), [_pair(q) for q in self.points]) for p in mine) if mine else None


def _pair(point: Measured) -> tuple[float, float]:
    return point.whole.cpu_s, point.errors.load


def main(words: Sequence[str] | None = None) -> int:
    """Solve a case by every method and setting: CPU and wall time, memory, and error against the exact solution.

    Whole process (jkr run) and after imports, medians of several runs; errors of P at equal displacement, of the
    adhesive curve and of the pull-off force. Writes <case>-chart.csv, .json, .png and .svg.
    """
    parser = parser_of(str(main.__doc__), parallel=False)
    parser.add_argument("case", type=Path)
    parser.add_argument("--methods", action="append", default=[], choices=list(METHODS), help="only these")
    parser.add_argument("--w", type=quantity("work"), help="work of adhesion [default: the case's first]")
    parser.add_argument("--repeat", type=int, default=3, help="runs, whose medians are shown [default: 3]")
    parser.add_argument("--patience", type=float, default=30.0, help="leave out what takes longer [CPU s, 30]")
    parser.add_argument("--peers", type=Path, help="stored timings of other programs, drawn open")
    parser.add_argument("--peers-now", type=Path, help="timings of other programs of the same run, drawn filled")
    given = parser.parse_args(words)
    loaded = load_case(given.case)
    w = given.w if given.w is not None else next(iter(loaded.model.adhesion.w), None)
    if not w:
        raise InputError(f"{given.case}: names no work of adhesion > 0: give --w")
    output = output_of(given)
    inputs = [path for path in (given.case, given.peers) if path]
    files = output.files(given.output / f"{given.case.stem}-chart", (".csv", ".json", *PICTURES), inputs)
    measure = yardstick()
    theirs = read_peers(given.peers_now, measure, now=True) if given.peers_now else []
    measured = {(peer.name, peer.body, peer.settings) for peer in theirs}
    stored = read_peers(given.peers, measure) if given.peers else []
    theirs += [peer for peer in stored if (peer.name, peer.body, peer.settings) not in measured]
    theirs = [peer for peer in theirs if peer.body == given.case.stem]
    reference = reference_of(loaded.model.problem(), w)
    settings = settings_of(loaded.model, given.methods)
    results = []
    with counted("chart", len(settings), math.inf) as step:
        for result in chart(loaded, settings, w, reference, given.repeat, given.patience):
            results.append(result)
            step(isinstance(result, LeftOut))
    found = Found(
        loaded,
        w,
        reference.name,
        [point for result in results if not isinstance(result, LeftOut) for point in result],
        [result for result in results if isinstance(result, LeftOut)],
        theirs,
        measure,
        automatic(loaded),
    )
    title = loaded.model.problem().words
    data = as_dict(found)
    table = {name: [cell(point) for point in found.points] for name, cell in CELLS.items()}
    files.write(table, data, files.draw(lambda: chart_figure(found.points, found.peers, title)))
    if output.json:
        print(as_json(data), end="")
    else:
        _print(found)
        print(f"  written   {files}")
    if found.auto_beside_front is False:
        print(f'jkr: warning: "auto" takes {found.auto}, which is not on or next to the Pareto front', file=sys.stderr)
    return 0


def as_dict(found: Found) -> dict[str, Any]:
    """The chart as JSON."""
    best = found.front
    return {
        "format": "jkr-chart",
        "version": 1,
        "problem": found.case.model.problem().words,
        "w_J_per_m2": found.w,
        "reference": found.reference,
        "machine": machine(),
        "yardstick_cpu_s": found.yardstick,
        "auto": {"method": found.auto, "beside_front": found.auto_beside_front},
        "points": [
            {
                "method": point.setting.method,
                "setting": point.setting.words,
                "slopes": point.slopes,
                "unknowns": point.unknowns,
                "whole_process": vars(point.whole),
                "after_imports": vars(point.after_imports),
                "slopes_cpu_s": point.slopes_cpu_s,
                "stated_P_error": point.stated,
                "stated_pull_off_error": point.stated_pull_off,
                "errors": vars(point.errors),
                "on_front": i in best,
            }
            for i, point in enumerate(found.points)
        ],
        "left_out": [
            {"method": out.setting.method, "setting": out.setting.words, "reason": out.reason} for out in found.left_out
        ],
        "peers": [
            {
                "peer": f"{peer.name} {peer.version}",
                "settings": peer.settings,
                "unknowns": peer.unknowns,
                "whole_process": vars(peer.whole),
                "after_imports_cpu_s": peer.after_imports_cpu_s,
                "errors": vars(peer.errors),
            }
            for peer in found.peers
        ],
    }


CELLS: dict[str, Callable[[Measured], Any]] = {
    "method": attrgetter("setting.method"),
    "setting": attrgetter("setting.words"),
    "slopes": attrgetter("slopes"),
    "unknowns": attrgetter("unknowns"),
    "whole_cpu_s": attrgetter("whole.cpu_s"),
    "whole_wall_s": attrgetter("whole.wall_s"),
    "memory_MiB": attrgetter("whole.memory_mib"),
    "after_imports_cpu_s": attrgetter("after_imports.cpu_s"),
    "after_imports_wall_s": attrgetter("after_imports.wall_s"),
    "slopes_cpu_s": attrgetter("slopes_cpu_s"),
    "stated_P_error": lambda point: known(point.stated),
    "stated_pull_off_error": lambda point: known(point.stated_pull_off),
    "P_error": attrgetter("errors.load"),
    "curve_error": attrgetter("errors.curve"),
    "pull_off_error": attrgetter("errors.pull_off"),
}


def _print(found: Found) -> None:
    print(found.case.model.problem().words)
    print(f"  against   {found.reference}; * is on the Pareto front of whole-process CPU and error of P")
    print(f"    {'method':<12}{'setting':<32}{'slopes':<9}{'unknowns':>9}{'process':>9}{'solve':>9}{'MiB':>6}"
               f"{'P':>9}{'curve':>9}{'pull-off':>9}")  # fmt: skip
    best = found.front
    for i, point in enumerate(found.points):
        errors = (point.errors.load, point.errors.curve, point.errors.pull_off)
        cells = "".join(f"{'-' if error is None else f'{error:.1e}':>9}" for error in errors)
        print(f"  {'*' if i in best else ' '} {point.setting.method:<12}{point.setting.words:<32}{point.slopes:<9}"
                   f"{point.unknowns or '-':>9}{point.whole.cpu_s:>9.2f}{point.after_imports.cpu_s:>9.4f}"
                   f"{point.whole.memory_mib or 0:>6.0f}{cells}")  # fmt: skip
    for peer in found.peers:
        after, load = peer.after_imports_cpu_s, peer.errors.load
        solve = "-" if after is None else f"{after:.2f}"
        pull_off = "-" if peer.errors.pull_off is None else f"{peer.errors.pull_off:.1e}"
        name = f"{peer.name} {peer.version}, {peer.settings}"
        print(f"    {name:<53}{peer.unknowns:>9}{peer.whole.cpu_s:>9.1f}"
                   f"{solve:>9}{peer.whole.memory_mib or 0:>6.0f}{load:>9.1e}{'':>9}{pull_off:>9}")  # fmt: skip
    for out in found.left_out:
        print(f"    {out.setting.method}, {out.setting.words}: left out, {out.reason}")
    print(f"  auto      takes {found.auto}")


# ---------------------------------------------------------------------- the picture
GREY = "0.45"
OWN = RECIPE  # a mark of its own among those of fem
LOOKS = {
    "closed-form": (BLACK, "D"), "layered": (GREEN, "s"), "hybrid": (ORANGE, "P"), "fem": (BLUE, "o"),
    OWN: (PURPLE, "*"),
}  # fmt: skip
PEER_MARKERS = "^v<>"
TITLE_WIDTH = 90  # choice: characters of a line of the title
LEAST = 1e-7  # choice: of the errors drawn; smaller ones stand on the axis


@dataclass(frozen=True)
class Spot:
    """A point of a panel: cost, true error and stated error (None: unknown), with the family in the legend."""

    x: float
    y: float
    stated: float | None
    family: str
    filled: bool = True


@dataclass(frozen=True)
class ChartPanel:
    """One pair of axes; ``ours``, ``theirs``: (cost, error, stated error) of a measured point, (cost, error) of a peer,
    None where unknown."""

    title: str
    ylabel: str
    ours: Callable[[Measured], tuple[float, float | None, float | None]]
    theirs: Callable[[Peer], tuple[float | None, float | None]]


PANELS = (
    ChartPanel("whole process", "error of P(δ)", lambda p: (p.whole.cpu_s, p.errors.load, known(p.stated)),
          lambda q: (q.whole.cpu_s, q.errors.load)),
    ChartPanel("after imports", "error of P(δ)", lambda p: (p.after_imports.cpu_s, p.errors.load, known(p.stated)),
          lambda q: (q.after_imports_cpu_s, q.errors.load)),
    ChartPanel("whole process, with slopes", "error of the pull-off force",
          lambda p: (p.whole.cpu_s + p.slopes_cpu_s, p.errors.pull_off, known(p.stated_pull_off)),
          lambda q: (q.whole.cpu_s, q.errors.pull_off)),
    ChartPanel("after imports, with slopes", "error of the pull-off force",
          lambda p: (p.after_imports.cpu_s + p.slopes_cpu_s, p.errors.pull_off, known(p.stated_pull_off)),
          lambda q: (q.after_imports_cpu_s, q.errors.pull_off)),
)  # fmt: skip


def chart_figure(points: Sequence[Measured], peers: Sequence[Peer], title: str) -> Figure:
    """Four panels, P(delta) above and the pull-off force below; a thin line goes from the true to the stated error; the
    grey steps are the Pareto front of this program. Peers of the same run are filled, stored ones open."""
    with drawing(WIDE, 6.0) as figure:
        axes = figure.subplots(2, 2, sharey=True)
        for place, panel in zip(axes.ravel(), PANELS, strict=True):
            _draw(place, panel, points, peers)
        for place, panel in zip(axes[:, 0], PANELS[::2], strict=True):
            place.set_ylabel(panel.ylabel)
        legend_below(figure, axes.ravel(), 4)
        figure.suptitle(pretty(textwrap.fill(title, TITLE_WIDTH)))
        return figure


def _draw(axes: Axes, panel: ChartPanel, points: Sequence[Measured], peers: Sequence[Peer]) -> None:
    ours = [spot for point in points if (spot := _spot(*panel.ours(point), _family(point)))]
    named = [(peer, *panel.theirs(peer)) for peer in peers]
    theirs = [spot for peer, x, y in named if (spot := _spot(x, y, None, f"{peer.name} {peer.version}", peer.now))]
    axes.set(xscale="log", yscale="log", title=panel.title, xlabel="CPU seconds")
    best = [ours[i] for i in front([(spot.x, spot.y) for spot in ours])]
    for name, (color, marker) in LOOKS.items():
        _scatter(axes, [spot for spot in ours if spot.family == name], name, color, marker)
    for name, marker in zip(dict.fromkeys(spot.family for spot in theirs), PEER_MARKERS, strict=False):
        _scatter(axes, [spot for spot in theirs if spot.family == name], name, GREY, marker)
    axes.axhline(1e-3, color=BLACK, lw=0.8, ls=":", zorder=1, label="error of 0.001")  # what auto asks for
    axes.set_ylim(LEAST / 2, 1.0)
    if ours or theirs:
        ends = log_ends(np.array([spot.x for spot in (*ours, *theirs)]), least=10.0, margin=1.3)
        axes.set_xlim(*ends)
        log_ticks(axes.xaxis)
        if best:  # the steps that no result of jkr is left of and below, from the upper edge to the right one
            x, y = [*(s.x for s in best), ends[1]], [1.0, *(s.y for s in best)]
            axes.step([x[0], *x], [*y, y[-1]], "-", where="post", color="0.6", lw=2.5, zorder=1, label="best of jkr")


def _family(point: Measured) -> str:
    return OWN if point.setting.words == OWN else point.setting.method


def _scatter(axes: Axes, spots: Sequence[Spot], name: str, color: str, marker: str) -> None:
    for spot in spots:
        if spot.stated is not None:
            axes.plot([spot.x, spot.x], [spot.y, spot.stated], "-", color=color, lw=0.8, alpha=0.6, zorder=1)
            axes.plot([spot.x], [spot.stated], "_", color=color, ms=5, alpha=0.8)
    label = name
    for filled in (True, False):
        some = [spot for spot in spots if spot.filled == filled]
        if some:
            face, size = (color if filled else "none"), (10 if marker == "*" else 5)
            x, y = [spot.x for spot in some], [spot.y for spot in some]
            axes.plot(x, y, marker, color=color, mfc=face, ms=size, alpha=0.8, label=label)
            label = "_nolegend_"


def _spot(x: float | None, y: float | None, stated: float | None, family: str, filled: bool = True) -> Spot | None:
    if x is None or y is None:
        return None
    return Spot(x, max(y, LEAST), None if stated is None else max(stated, LEAST), family, filled)


if __name__ == "__main__":
    sys.exit(call(main))

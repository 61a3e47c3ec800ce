"""The picture of speed against accuracy: error over CPU seconds, for the whole process and after imports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...report.plots import (
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
from .chart import Measured, front
from .chart_peers import Peer

GREY = "0.45"
LOOKS = {"closed-form": (BLACK, "D"), "layered": (GREEN, "s"), "hybrid": (ORANGE, "P"), "fem": (BLUE, "o")}
PEER_MARKERS = "^v<>"
WANTED = 1e-3  # what auto asks for
NOT_ZERO = 1e-16  # errors below are drawn here


@dataclass(frozen=True)
class Spot:
    """A point of a panel, with the family it belongs to in the legend."""

    x: float
    y: float
    family: str


@dataclass(frozen=True)
class Panel:
    """``ours`` and ``theirs``: (cost, error) of a measured point and of a peer, None where there is none."""

    title: str
    ylabel: str
    ours: Callable[[Measured], tuple[float, float | None]]
    theirs: Callable[[Peer], tuple[float | None, float | None]]


PANELS = (
    Panel("whole process", "error of P(δ)", lambda p: (p.whole.cpu_s, p.errors.load),
          lambda q: (q.whole.cpu_s, q.errors.load)),
    Panel("after imports", "error of P(δ)", lambda p: (p.after_imports.cpu_s, p.errors.load),
          lambda q: (q.after_imports_cpu_s, q.errors.load)),
    Panel("whole process, with slopes", "error of the pull-off force",
          lambda p: (p.whole.cpu_s + p.slopes_cpu_s, p.errors.pull_off), lambda q: (q.whole.cpu_s, q.errors.pull_off)),
    Panel("after imports, with slopes", "error of the pull-off force",
          lambda p: (p.after_imports.cpu_s + p.slopes_cpu_s, p.errors.pull_off),
          lambda q: (q.after_imports_cpu_s, q.errors.pull_off)),
)  # fmt: skip


def chart_figure(points: Sequence[Measured], peers: Sequence[Peer], title: str) -> Figure:
    """Four panels, P(delta) above and the pull-off force below; the line is the Pareto front of this program."""
    with drawing(WIDE, 6.0) as figure:
        axes = figure.subplots(2, 2, sharey="row")
        for place, panel in zip(axes.ravel(), PANELS, strict=True):
            _draw(place, panel, points, peers)
        for place, panel in zip(axes[:, 0], PANELS[::2], strict=True):
            place.set_ylabel(panel.ylabel)
        legend_below(figure, axes.ravel(), 4)
        figure.suptitle(pretty(title))
        return figure


def _draw(axes: Axes, panel: Panel, points: Sequence[Measured], peers: Sequence[Peer]) -> None:
    ours = [spot for point in points if (spot := _spot(*panel.ours(point), point.setting.method))]
    theirs = [spot for peer in peers if (spot := _spot(*panel.theirs(peer), f"{peer.name} {peer.version}"))]
    axes.set(xscale="log", yscale="log", title=panel.title, xlabel="CPU seconds")
    best = [ours[i] for i in front([(spot.x, spot.y) for spot in ours])]
    axes.plot([s.x for s in best], [s.y for s in best], "-", color="0.7", lw=3, zorder=1, label="best of jkr")
    for name, (color, marker) in LOOKS.items():
        _scatter(axes, [spot for spot in ours if spot.family == name], name, color, marker)
    for name, marker in zip(dict.fromkeys(spot.family for spot in theirs), PEER_MARKERS, strict=False):
        _scatter(axes, [spot for spot in theirs if spot.family == name], name, GREY, marker)
    axes.axhline(WANTED, color=PURPLE, lw=1.0, ls="--", zorder=1, label=f"error of {WANTED:g}")
    if ours or theirs:
        axes.set_xlim(*log_ends(np.array([spot.x for spot in (*ours, *theirs)]), least=10.0, margin=1.3))
        log_ticks(axes.xaxis)


def _scatter(axes: Axes, spots: Sequence[Spot], name: str, color: str, marker: str) -> None:
    if spots:
        x, y = [spot.x for spot in spots], [spot.y for spot in spots]
        axes.plot(x, y, marker, color=color, mfc="none" if color == GREY else color, ms=5, alpha=0.8, label=name)


def _spot(x: float | None, y: float | None, family: str) -> Spot | None:
    return None if x is None or y is None else Spot(x, max(y, NOT_ZERO), family)

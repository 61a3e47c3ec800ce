"""The figure of a convergence study: radius, curves, errors and cost over the number of unknowns."""

from __future__ import annotations

import numpy as np

from ...base import Array, InputError, Unknown
from ...report.plots import Figure
from ...report.plots.looks import BLACK, BLUE, GREEN, ORANGE, axis_of
from ...report.plots.study import Line, Panel, panels_figure
from .meshes import Meshes

UNKNOWNS = "unknowns"
COLORS = (ORANGE, BLUE, GREEN, "#CC79A7", "#56B4E9", "#E69F00", "#F0E442")


def convergence_figure(study: Meshes) -> Figure:
    """Contact radius over element size, adhesive curves, errors, and what the meshes cost."""
    return panels_figure([radius_panel(study), curves_panel(study), errors_panel(study), cost_panel(study)])


def radius_panel(study: Meshes) -> Panel:
    """Contact radius at the depth of the study over the number of unknowns."""
    unit, label = axis_of("a", study.levels[-1].state.a)
    unknowns = _unknowns(study)
    lines = [Line(unknowns, np.array(study.values("a"), dtype=float) / unit, "finite elements", "o-", ORANGE)]
    if study.exact is not None:
        lines.append(Line(unknowns, np.full(unknowns.size, study.exact.a / unit), "exact", "--", BLACK))
    return Panel(UNKNOWNS, label, lines, logs="x")


def curves_panel(study: Meshes) -> Panel:
    """Adhesive load over displacement of every mesh."""
    curves = [(level, level.state.curve) for level in study.levels if not isinstance(level.state.curve, Unknown)]
    if not curves:
        raise InputError("convergence: no mesh is fine enough for an adhesive curve: give finer meshes")
    finest = curves[-1][1]
    (delta_unit, delta_label), (P_unit, P_label) = axis_of("delta", finest.delta), axis_of("P", finest.P)
    lines = [
        Line(curve.delta / delta_unit, curve.P / P_unit, f"{level.unknowns} unknowns", "o", color)
        for (level, curve), color in zip(curves, COLORS * len(curves), strict=False)
    ]
    if study.exact is not None and not isinstance(study.exact.curve, Unknown):
        exact = study.exact.curve
        lines.append(Line(exact.delta / delta_unit, exact.P / P_unit, "exact", "-", BLACK))
    return Panel(delta_label, P_label, lines)


def errors_panel(study: Meshes) -> Panel:
    """Relative errors over the number of unknowns."""
    unknowns = _unknowns(study)
    lines = []
    for name, words, color in (("a", "a", ORANGE), ("P", "P", BLUE), ("pull_off", "pull-off force", GREEN)):
        shown = [(n, 100 * abs(error)) for n, error in zip(unknowns, study.errors(name), strict=True) if error]
        if shown:
            x, y = np.array(shown).T
            lines.append(Line(x, y, words, "o-", color))
    against = "the exact value" if study.exact is not None else "the extrapolated value"
    return Panel(UNKNOWNS, f"difference to {against} (%)", lines, logs="xy")


def cost_panel(study: Meshes) -> Panel:
    """Points kept and CPU seconds over the number of unknowns."""
    unknowns = _unknowns(study)
    counts = np.array([level.kept for level in study.levels], dtype=float)
    seconds = np.array([level.seconds for level in study.levels])
    points, time = Line(unknowns, counts, "points kept", "o-", ORANGE), Line(unknowns, seconds, "CPU time", "s--", BLUE)
    return Panel(UNKNOWNS, "points kept", [points], logs="xy", right=("CPU time (s)", time))


def _unknowns(study: Meshes) -> Array:
    """The axis of the study: it grows from mesh to mesh, while coarse meshes may share their largest element."""
    return np.array([level.unknowns for level in study.levels], dtype=float)

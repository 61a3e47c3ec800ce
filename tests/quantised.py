"""How node-based contact radii reach the pull-off force: Hertz with the radius of the outermost node in contact."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.rules import slopes_function
from jkrcli.adhesion.slopes import smoothed
from jkrcli.base.errors import InputError, Unknown
from jkrcli.formulas import hertz
from jkrcli.series import RawSeries, Series, filter_plateaus

WAYS = ("integral from increments", "integral", "loocv")


@dataclass(frozen=True)
class QuantisedCell:
    """Relative errors of the pull-off force over the offsets of the mesh; ``failures``: offsets without a result."""

    way: str
    increments: int
    spacing: str
    median: float
    worst: float
    failures: float


def node_based(
    a_max: float, E_star: float, R: float, nodes: int, increments: int, spacing: str, offset: float
) -> RawSeries:
    """Exact depths and loads [m, N] at increments even in "depth" or "radius", the radius being that of a mesh node.

    ``nodes`` of them lie in [0, ``a_max``], shifted by the fraction ``offset`` of their spacing.
    """
    even = np.linspace(0, 1, increments + 1)[1:]
    a = a_max * (np.sqrt(even) if spacing == "depth" else even)
    step = a_max / nodes
    radii = (np.floor(a / step - offset) + offset) * step
    delta, P = hertz(a, E_star, R)
    return RawSeries(radii[radii > 0], delta[radii > 0], P[radii > 0])


def quantised_study(
    a_max: float = 1.73e-5,
    E_star: float = 5e9 / 0.84,
    R: float = 1e-4,
    w: float = 50.0,
    nodes: int = 20,
    offsets: int = 20,
) -> Iterator[QuantisedCell]:
    """Cells for 100 and 400 increments, even in depth (the paper) and in radius, by three ways of finding the slopes.

    The defaults are the paper's half-space (Sec. 4.1) in SI units. "integral from increments" sees all increments,
    the other two those that the paper's filter keeps.
    """
    for spacing in ("depth", "radius"):
        for increments in (100, 400):
            series = [node_based(a_max, E_star, R, nodes, increments, spacing, k / offsets) for k in range(offsets)]
            for way in WAYS:
                forces = np.array([_pull_off(raw, way, w) for raw in series])
                errors = np.abs(forces[~np.isnan(forces)] / (-1.5 * np.pi * w * R) - 1)
                lost = float(np.mean(np.isnan(forces)))
                yield QuantisedCell(way, increments, spacing, float(np.median(errors)), float(np.max(errors)), lost)


def _pull_off(raw: RawSeries, way: str, w: float) -> float:
    """The pull-off force [N], NaN where there is none: counted as a failure, never shown."""
    try:
        if way == WAYS[0]:
            curve = transform(*smoothed(raw), w)
        else:
            kept, _ = filter_plateaus(raw)
            series = Series(kept.a, kept.delta, kept.P)
            curve = transform(series, slopes_function(way)(series), w)
    except InputError:
        return np.nan
    found = curve.pull_off(0.0)
    return np.nan if isinstance(found, Unknown) else found.P

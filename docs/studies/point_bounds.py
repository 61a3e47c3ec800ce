"""Whether stated errors of pull-off points of finite elements bound the true ones, over the whole of a series."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence

import numpy as np

from jkrcli.adhesion.curve import CONTROLS, AdhesiveCurve, CriticalPoint, Nonadhesive
from jkrcli.adhesion.pull_off_error import pull_off_error
from jkrcli.base.errors import JkrError, Unknown
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Loading
from jkrcli.formulas import shift
from jkrcli.methods.protocol import method_class
from jkrcli.resolve.analysis import nonadhesive
from jkrcli.series import Series

from .bounds import PATIENCE, Bound, body, exact_at, study
from .command import call
from .range_judge import SMALL

# Where points are compared, and with what.
# choice: of pull-off under load, of the series
POINT_PLACES = (0.08, 0.15, 0.3, 0.5, 0.7, 0.9)
# choice: of the largest radius, where a device is as stiff as the contact
POINT_SPRINGS = (0.4, 0.9)
POINT_RADII = 50  # choice: of the exact series, whose curve is interpolated to 1e-6 or better
POINT_LEAST = 0.02  # choice: the smallest of them over the largest
POINT_FIRST = 0.9  # choice: and at least this part of the first row's
POINT_APART = 1.5  # choice: a factor between radii of points beyond which they are two minima


def main(words: Sequence[str] | None = None) -> int:
    """Solve random bodies by fem, and compare their pull-off points under load, displacement and two springs, for six
    works of adhesion that put them anywhere in the series, with those of an exact method.

    Writes point-bounds.csv and .json: for each point of each body the ratio of true to stated error. The exit code is
    1 where more than 1 % lie beyond the stated error, any beyond three times it, or the median of stated over true
    errors is above ten for a quantity.
    """
    return study(words, main, judged, "point-bounds", 200)


def judged(number: int) -> tuple[Bound, ...]:
    """The points of the body ``number``; none where it is refused, or too costly."""
    problem, solver = body(np.random.default_rng(number), cylinders=True), method_class("fem")()
    try:
        if solver.refusal(problem) or solver.forecast(problem).seconds > PATIENCE:
            return ()
        solution = solver(problem)
        series = solution.series
        if not series.errors or solution.facts.get("contact") == "incremental":
            return ()
        wide = series.a[-1] - series.a0
        first = max(POINT_LEAST * wide, POINT_FIRST * (series.a[0] - series.a0))
        radii = series.a0 + np.geomspace(first, wide, POINT_RADII)
        reference = exact_at(problem, Loading.given("radius", tuple(radii.tolist()))).series
        return tuple(_points(number, nonadhesive(solution), reference))
    except JkrError:
        return ()


def _points(number: int, ours: Nonadhesive, reference: Series) -> Iterator[Bound]:
    """Each point that both curves have, against the exact one."""
    assert reference.S is not None
    true, beyond = Nonadhesive.of(reference, "exact"), reference.a - reference.a0
    springs = np.interp(np.array(POINT_SPRINGS) * beyond[-1], beyond, reference.S)
    devices = [*CONTROLS.items(), *(("spring", float(stiffness)) for stiffness in springs)]
    for w in _works(reference):
        curve, exact = AdhesiveCurve(ours, w), AdhesiveCurve(true, w)
        for control, stiffness in devices:
            point, truth = curve.pull_off(stiffness), exact.pull_off(stiffness)
            if not isinstance(point, CriticalPoint) or not isinstance(truth, CriticalPoint):
                continue
            stated, unsure = pull_off_error(curve, point, stiffness), exact.interpolation_at(np.array(truth.a))
            away = abs(math.log((point.a - reference.a0) / (truth.a - reference.a0)))
            if isinstance(stated, Unknown) or isinstance(unsure, Unknown) or away > math.log(POINT_APART):
                continue
            for name in ("delta", "P"):
                size, room = abs(getattr(truth, name)), float(unsure[name])
                off = abs(getattr(point, name) - getattr(truth, name))
                clear = off > max(SMALL * size, 3 * room)
                ratio = max(off - room, 0.0) / stated[name]
                yield Bound(number, "fem", f"{control} {name}", ratio, stated[name] / size, clear)


def _works(series: Series) -> Array:
    """The works of adhesion [J/m^2] that put pull-off under load at the ``places``."""
    assert series.S is not None
    assert series.dS is not None
    rate = np.gradient(series.P, series.a) / np.gradient(series.S * shift(1.0, series.a, series.dS), series.a)
    works: Array = np.interp(np.array(POINT_PLACES) * (series.a[-1] - series.a0), series.a - series.a0, rate**2)
    return works


if __name__ == "__main__":
    sys.exit(call(main))

"""What a case will roughly show, from a coarse exact solution of the laterally unbounded body."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ..adhesion import LOAD_CONTROL, CriticalPoint, Validity, judge, refuse_wetting, resolved, sizes, transform
from ..base import PATIENCE, Refusal, Unknown
from ..bodies import Loading, Problem, unbounded
from ..methods import Layered
from ..series import Series
from .again import again
from .comparison import alone
from .range_effect import effect_of_range

COARSE = Layered(1e-5)


@dataclass(frozen=True)
class Expectation:
    """What a case will reach: largest radius ``a`` [m], displacement [m], load [N]; ``series``: to there.

    ``adhesion``: for each work of adhesion [J/m^2] its pull-off and validity.
    ``half_space_error``: by how much the layers change the load at that depth against a half-space of the top material;
    None where there are no layers.
    """

    a: float
    delta: float
    P: float
    half_space_error: float | None
    adhesion: tuple[tuple[float, CriticalPoint | Unknown, Validity], ...]
    series: Series


def expect(problem: Problem, works: tuple[float, ...], z0: float) -> Expectation:
    """Solve ``problem`` to 1e-5 with its sides left out, and transform it for each work of adhesion.

    Refusal where that is no matter of a moment.
    """
    loading = problem.loading
    if loading.spacing != "radius":
        loading = Loading(loading.to, loading.maximum)
    body = replace(unbounded(problem), loading=replace(loading, points=max(loading.points, 100)))
    series = again(body, method=COARSE, longest=PATIENCE).series
    a, delta, P = (float(column[-1]) for column in (series.a, series.delta, series.P))
    adhesion = []
    for w in works:
        refuse_wetting(w, body.specimen.surface_tension)
        curve = transform(series, "exact", w)
        point = resolved(curve.pull_off(LOAD_CONTROL), curve, LOAD_CONTROL, z0)
        pulled: dict[str, Any] = {"effect_of_range": point}
        if isinstance(point, CriticalPoint):
            pulled = {"a_pull_off": point.a, "effect_of_range": effect_of_range(body, series, w, z0, point)}
        judged = judge(a=a, delta=delta, w=w, **sizes(problem), L=problem.specimen.radius, end_is_cut=False, z0=z0,
                       **pulled)  # fmt: skip
        adhesion.append((w, point, judged))
    return Expectation(a, delta, P, _layers_matter(problem, delta, P), tuple(adhesion), series)


def _layers_matter(problem: Problem, delta: float, P: float) -> float | None:
    """Relative difference of the load to that of a half-space of the top material at the same displacement."""
    if not problem.specimen.layers:
        return None
    half_space = alone(replace(problem, sticks=False, loading=Loading("depth", delta, 1)))
    try:
        reference = again(half_space, method=COARSE).series.P[-1]
    except Refusal:  # a half-space would need more of the profile than there is
        return None
    return float(P / reference - 1)

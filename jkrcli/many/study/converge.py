"""Mesh convergence of a case (Appendix C): the same loading on a sequence of meshes with halved element sizes."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import partial

import numpy as np

from ...adhesion import transform
from ...base import Array, InputError, Pool, Unknown, in_order
from ...bodies import Problem
from ...methods import FEM, Layered
from ...series import RawSeries, Series, Solution
from .convergence import Convergence
from .meshes import TUNING, Level, State


def converge(
    problem: Problem, method: FEM, w: float, count: int, slopes_name: str = "auto", pool: Pool | None = None
) -> Convergence:
    """Solve ``problem`` on ``count`` meshes, the finest being that of ``method``, and transform for ``w`` [J/m^2].

    ``pool``: works on the meshes (default: this process).
    """
    method = replace(method, estimate_error=False, tolerance=None)
    factors = [TUNING.ratio**k for k in reversed(range(count))]
    methods = [coarser(method, problem, factor) for factor in factors]
    meshes = in_order(pool, partial(_timed, problem), methods, "meshes")
    depth = min(float(solution.increments.delta[-1]) for solution, _, _ in meshes)
    largest = float(meshes[-1][0].series.a[-1])
    levels = []
    for solution, radii, seconds in meshes:
        series, facts = solution.series, solution.facts
        state = _state(solution.increments, series, slopes_name, w, depth)
        levels.append(Level(spacing_at(radii, largest), state, facts["elements"], facts["unknowns"], len(series),
                            facts["dropped"], seconds))  # fmt: skip
    return Convergence(problem, w, depth, tuple(levels), _exact(problem, w, depth))


def _timed(problem: Problem, method: FEM) -> tuple[Solution, Array, float]:
    """A solution, its mesh's surface radii [m] and the CPU seconds it took."""
    start = time.thread_time()  # of this mesh alone, whatever else the process works on
    run, solution = method.solve(problem)
    return solution, run.level.model.system.grid.surface_radii(), time.thread_time() - start


def coarser(method: FEM, problem: Problem, factor: float) -> FEM:
    """The method with every element ``factor`` times as large, as far as the mesher's limits let it."""
    if factor == 1:
        return method
    growth = min(factor * method.growth_of_sizes, TUNING.steepest_growth)
    if method.layout == "scaled":
        spacing = factor * method.spacing
        if spacing > TUNING.coarsest_spacing:
            raise InputError(
                f"levels: the coarsest mesh would have mesh.spacing = {spacing:g}, at most "
                f"{TUNING.coarsest_spacing:g} is possible: take fewer levels or a finer mesh in the case"
            )
        return replace(method, spacing=spacing, growth=growth)
    zones = tuple(factor * size for size in method.zone_sizes)
    size = method.element_size if method.element_size is not None else edge_size(method, problem, 0.0)
    return replace(method, element_size=factor * size, zone_sizes=zones, growth=growth)  # type: ignore[arg-type]


def edge_size(method: FEM, problem: Problem, a: float) -> float:
    """Distance between the surface vertices on either side of the radius ``a`` [m] in the method's mesh."""
    return spacing_at(method.mesh(problem).surface_radii(), a)


def spacing_at(radii: Array, a: float) -> float:
    """Distance between the neighbours of ``a`` among ``radii`` [m]."""
    k = int(np.clip(np.searchsorted(radii, a), 1, radii.size - 1))
    return float(radii[k] - radii[k - 1])


def _state(rows: RawSeries | Series, series: Series, slopes_name: str, w: float, depth: float) -> State:
    """The state at ``depth`` [m]: load and radius (of increments that of a node) between ``rows`` in logarithms, and
    the adhesive curve of the ``series``, or why a mesh is too coarse for one."""
    at = math.log(depth * (1 + TUNING.round_off))
    touching = rows.a > 0
    x = np.log(rows.delta[touching])
    load, radius = (math.exp(np.interp(at, x, np.log(column[touching]))) for column in (rows.P, rows.a))
    try:
        return State(radius, load, transform(series, slopes_name, w))
    except InputError as error:
        return State(radius, load, Unknown(error.lines[0]))


def _exact(problem: Problem, w: float, depth: float) -> State | None:
    """The exact solution of the wide body down to ``depth``; None where the body ends sideways."""
    loading = replace(problem.loading, to="depth", maximum=depth, points=200, spacing="radius", values=())
    same_depth = replace(problem, loading=loading)
    method = Layered()
    if method.refusal(same_depth) is not None:
        return None
    series = method(same_depth).series
    return _state(series, series, "exact", w, depth)

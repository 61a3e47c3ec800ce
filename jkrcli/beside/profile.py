"""Contact pressure and surface shape at one state, solved again whatever method made the series."""

from __future__ import annotations

from typing import cast

import numpy as np

from ..adhesion import Range, RangeRequest, stable_radius
from ..base import ROUNDED, ROWS, Array, InputError, show
from ..bodies import Problem, unbounded
from ..case import Case
from ..methods import surface_profile
from ..series import Solution
from .analysis import analyse


def radius_under(solution: Solution, load: float, w: float, request: RangeRequest) -> float:
    """The contact radius [m] under a ``load`` [N] on the stable branch of the curve for ``w`` [J/m^2]."""
    curve = analyse(solution, [w], request=request)[0].curve
    return curve.point(stable_radius(curve, load)).a


def profile_columns(solution: Solution, a: float, w: float, request: RangeRequest) -> dict[str, Array]:
    """Pressure inside, displacement and gap around a contact of radius ``a`` [m]: exact on the laterally unbounded
    body, by finite elements where the surfaces stick, on the body itself with adhesion of finite range."""
    if request:
        return _attracted(solution, a, request.law(w))
    return _stuck(solution, a, w) if solution.problem.sticks else _columns(unbounded(solution.problem), a, w)


def _attracted(solution: Solution, a: float, law: Range) -> dict[str, Array]:
    """Pressure, displacement and gap out to 3 c under a tension of finite range; the tension is a negative pressure."""
    from ..adhesion import FiniteRangeBody
    from ..methods.integral.attraction import attracted_surface

    body = FiniteRangeBody.of(solution).body
    problem, s = body.problem, 2 * law.stress / body.problem.E_star
    if not 0 < a <= solution.series.a[-1] * (1 + ROUNDED):
        end = show(float(solution.series.a[-1]), "length")
        raise InputError(f"profile: the contact radius must lie between 0 and {end}, got {show(a, 'length')}")
    attraction = body.attraction(min(3 * body.reach(a, s, law.length), body.limit))
    inside = _inside(a)
    outside = a + (attraction.reach - a) * np.linspace(0, 1, ROWS + 2)[1:-1] ** 2
    r = np.concatenate([inside, outside])
    surface = attracted_surface(attraction, a, law.stress, law.length, r, body.scale)
    displacement = surface.rims.delta[0] - problem.indenter.f(r) + surface.gap
    if problem.indenter.material is not None:
        displacement -= problem.E_star / problem.indenter.material.E_star * surface.own
    return {"r_m": r, "pressure_Pa": surface.pressure, "displacement_m": displacement, "gap_m": surface.gap}


def _inside(a: float) -> Array:
    """Radii [m] inside the contact that crowd towards its edge."""
    return a * np.sin(np.linspace(0, np.pi / 2, ROWS + 2)[1:-1])


def _stuck(solution: Solution, a: float, w: float) -> dict[str, Array]:
    """Pressure and shear at the nodes inside, displacement and gap at the vertices from the edge out to 3 a; outwards
    positive."""
    from ..case import fem_of
    from ..methods import contact_state

    curve = analyse(solution, [w])[0].curve
    delta, _ = (float(value) for value in curve.at(np.array(a)))
    state = contact_state(fem_of(cast(Case, solution.record.case).model), solution.problem, a, delta)
    points, line = state.grid.points, state.lines["surface"]
    beyond = np.flatnonzero((np.abs(points[:, 1]) <= 1e-12 * a) & (a <= points[:, 0]) & (points[:, 0] <= 3 * a))
    beyond = beyond[np.argsort(points[beyond, 0], kind="stable")]
    inside = line.r < a * (1 - ROUNDED)
    r, none = np.concatenate([line.r[inside], points[beyond, 0]]), np.zeros(beyond.size)
    f, lower = solution.problem.indenter.f(r), -state.displacement[beyond, 1]
    displacement = np.concatenate([(delta - f)[: -none.size], lower])
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([-line.zz[inside], none]),
        "shear_Pa": np.concatenate([line.rz[inside], none]),
        "displacement_m": displacement,
        "gap_m": np.where(r < a, 0.0, f - delta + displacement),
    }


def _columns(problem: Problem, a: float, w: float) -> dict[str, Array]:
    """Pressure, displacement and gap at radii that crowd on both sides of the edge, out to 3 a; none at the edge."""
    inside = _inside(a)
    outside = a * (1 + 2 * np.linspace(0, 1, ROWS + 1)[1:] ** 2)
    outside = outside[outside <= problem.indenter.r_max]
    r = np.concatenate([inside, outside])
    surface = surface_profile(problem, a, w, inside, r)
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([surface.pressure, 0 * outside]),
        "displacement_m": surface.displacement,
        "gap_m": surface.gap,
    }

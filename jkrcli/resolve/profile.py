"""Contact pressure and surface shape at one state, solved again whatever method made the series."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np

from ..adhesion.device_path import stable_radius
from ..adhesion.finite_range import Range, RangeRequest
from ..base.errors import InputError, Refusal
from ..base.numerics import ROUNDED, ROWS, Array
from ..base.units import show
from ..bodies.problem import Loading, Problem
from ..case.models import Case
from ..methods.finite_range import AttractedBody
from ..methods.integral.density import nonsmooth_part
from ..methods.layered.solver import surface_profile
from ..series import Solution
from .analysis import analyse

if TYPE_CHECKING:
    from ..methods.integral.finite_range import AttractedSurface


def radius_under(solution: Solution, load: float, w: float, request: RangeRequest) -> float:
    """The contact radius [m] under a ``load`` [N] on the stable branch of the curve for ``w`` [J/m^2]."""
    curve = analyse(solution, [w], request=request)[0].curve
    return curve.point(stable_radius(curve, load)).a


def profile_columns(solution: Solution, a: float, w: float, request: RangeRequest) -> dict[str, Array]:
    """Pressure inside, displacement and gap around a contact of radius ``a`` [m] on the body itself: by its kernel, or
    by finite elements where the surfaces stick or the kernel of a cylinder does not give them."""
    problem = solution.problem
    if request:
        return _attracted(solution, a, request.law(w))
    if problem.sticks:
        return _meshed(solution, a, w)
    if problem.specimen.radius is None:
        return _columns(problem, a, w)
    _check_within(solution, a)
    # Whether the kernel of a cylinder gives the pressures at the radius a [m]; Refusal where nothing does
    from ..methods.hybrid.method import Hybrid

    reason = nonsmooth_part(problem.specimen)
    if reason is not None and problem.specimen.surface_tension:
        raise Refusal(reason)
    kernel_is_known = (
        reason is None and Hybrid().refusal(replace(problem, loading=Loading.given("radius", (a,)))) is None
    )
    if kernel_is_known:
        # Pressure, displacement and gap on a cylinder out to 3 a, or half-way to its side, where the kernel costs
        # little
        from ..methods.integral.finite_range import adhesive_surface

        problem = solution.problem
        body = AttractedBody(problem, kept=solution.kernel)
        half_way = (a + cast(float, problem.specimen.radius)) / 2
        attraction = body.attraction(min(3 * a, half_way, body.limit))
        r = _around(a, attraction.reach)
        return _of_surface(problem, r, adhesive_surface(attraction, a, w, r, body.scale))
    return _meshed(solution, a, w)


def _check_within(solution: Solution, a: float) -> None:
    if not 0 < a <= solution.series.a[-1] * (1 + ROUNDED):
        end = show(float(solution.series.a[-1]), "length")
        raise InputError(f"profile: the contact radius must lie between 0 and {end}, got {show(a, 'length')}")


def _attracted(solution: Solution, a: float, law: Range) -> dict[str, Array]:
    """Pressure, displacement and gap out to 3 c under a tension of finite range; the tension is a negative pressure."""
    from ..adhesion.finite_range import FiniteRangeBody
    from ..methods.integral.finite_range import attracted_surface

    body = FiniteRangeBody.of(solution).body
    _check_within(solution, a)
    reach = body.reach(a, 2 * law.stress / body.problem.E_star, law.length)
    attraction = body.attraction(min(3 * reach, body.limit))
    r = _around(a, attraction.reach)
    surface = attracted_surface(attraction, a, law.stress, law.length, r, body.scale)
    return _of_surface(body.problem, r, surface)


def _around(a: float, end: float) -> Array:
    """Radii [m] that crowd on both sides of the edge of the contact, up to the ``end`` [m]; none at either."""
    return np.concatenate([_inside(a), a + (end - a) * np.linspace(0, 1, ROWS + 2)[1:-1] ** 2])


def _of_surface(problem: Problem, r: Array, surface: AttractedSurface) -> dict[str, Array]:
    """The columns at the radii ``r`` [m]."""
    displacement = surface.rims.delta[0] - problem.indenter.f(r) + surface.gap
    if problem.indenter.material is not None:
        displacement -= problem.E_star / problem.indenter.material.E_star * surface.own
    return {"r_m": r, "pressure_Pa": surface.pressure, "displacement_m": displacement, "gap_m": surface.gap}


def _inside(a: float) -> Array:
    """Radii [m] inside the contact that crowd towards its edge."""
    return a * np.sin(np.linspace(0, np.pi / 2, ROWS + 2)[1:-1])


def _meshed(solution: Solution, a: float, w: float) -> dict[str, Array]:
    """Pressure at the nodes inside, displacement and gap at the vertices from the edge out to 3 a, by finite elements;
    where the surfaces stick, shear too, outwards positive."""
    from ..case.models import fem_of
    from ..methods.fem.fields import contact_state

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
    shear = {"shear_Pa": np.concatenate([line.rz[inside], none])} if solution.problem.sticks else {}
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([-line.zz[inside], none]),
        **shear,
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

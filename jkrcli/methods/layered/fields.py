"""Contact pressure and surface shape at one contact radius, nonadhesive or adhesive, from the density phi.

Adhesion subtracts a flat punch displaced by sqrt(4 pi w a/S') (Eq. 13), whose phi(a) is not zero: the pressure is then
singular like -K_I/sqrt(2 pi (a - r)), with K_I = -(E*/2) phi(a) sqrt(pi/a) and the energy release rate
K_I^2/(2 E*) = w.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...base import Array, InputError, Refusal
from ...bodies import Problem
from ...formulas.griffith import shift
from ..integral import InaccurateError
from ..integral.density import Density, unsmooth
from .layered import Layered
from .stack import LayeredContact

TOLERANCE = 1e-8  # of delta, P, S, S'; choice: finer than any picture


@dataclass(frozen=True, eq=False)
class Profile:
    """Pressure inside and surface shape inside and outside a contact of radius ``a`` [m]; arrays are read-only.

    ``r, pressure`` [m, Pa]: strictly inside, compression positive; near an adhesive edge the pressure goes like
    ``-stress_intensity/sqrt(2 pi (a - r))``. ``r_surface, displacement, gap`` [m]: the specimen's surface, downwards
    positive, and its distance from the indenter, zero inside. ``delta`` [m], ``P`` [N]: with adhesion, if w > 0.
    ``stress_intensity`` [Pa m^(1/2)]: K_I of the edge, 0 without adhesion.
    """

    a: float
    w: float
    delta: float
    P: float
    r: Array
    pressure: Array
    r_surface: Array
    displacement: Array
    gap: Array
    stress_intensity: float

    def __post_init__(self) -> None:
        for name in ("r", "pressure", "r_surface", "displacement", "gap"):
            getattr(self, name).setflags(write=False)


def surface_profile(
    problem: Problem, a: float, w: float, r: Array | None = None, r_surface: Array | None = None
) -> Profile:
    """Fields at the contact radius ``a`` [m] and work of adhesion ``w`` >= 0 [J/m^2].

    ``r`` [m]: radii 0 < r < a for the pressure, by default 100 that crowd at the edge; ``r_surface`` [m]: any radii for
    the surface, by default up to 3 a. The loading of ``problem`` is not used. Errors: InputError, Refusal.
    """
    reason = Layered().refusal(problem) or unsmooth(problem.specimen)
    if problem.sticks:
        reason = "profile: pressures of contact without slip are not those of one density: use the field of method fem"
    if problem.coatings:
        reason = (
            "profile: how a coated indenter and the specimen share the displacement is not derived: take a homogeneous "
            "indenter (leave indenter.layers out)"
        )
    if reason is not None:
        raise Refusal(reason)
    r, r_surface = _sample(problem, a, w, r, r_surface)
    contact = LayeredContact(problem.indenter, problem.specimen)
    try:
        result, _ = contact.refined(np.array([a]), TOLERANCE)
    except InaccurateError as error:
        raise Refusal(error.fixed) from None
    t = float(shift(w, a, float(result.dS[0])))
    reach = max(a, float(r_surface.max(initial=a)))
    kernel = contact.spectrum.kernel(a + reach)
    phi = Density.of(kernel, result, t, reach)
    if w == 0:
        phi = phi.anchored()
    edge = float(phi(np.array([a]))[0]) if w > 0 else 0.0
    gap = phi.gaps(r_surface)
    return Profile(
        a=a,
        w=w,
        delta=phi.delta,
        P=float(result.P[0]) - t * float(result.S[0]),
        r=r,
        pressure=contact.E_star / 2 * phi.pressures(edge, r),
        r_surface=r_surface,
        displacement=_specimen_surface(phi, problem, r_surface, gap),
        gap=gap,
        stress_intensity=-contact.E_star / 2 * edge * math.sqrt(math.pi / a) if w > 0 else 0.0,
    )


def _sample(problem: Problem, a: float, w: float, r: Array | None, surface: Array | None) -> tuple[Array, Array]:
    a0, r_max = problem.indenter.a0, problem.indenter.r_max
    if not a0 < a <= r_max:
        raise InputError(f"profile: contact radius must be between {a0:g} and {r_max:g} m, got {a:g}")
    if not (math.isfinite(w) and w >= 0):
        raise InputError(f"profile: work of adhesion must be >= 0 J/m^2, got {w:g}")
    inside = a * np.sin(np.linspace(0, np.pi / 2, 102)[1:-1]) if r is None else np.array(r, dtype=float)
    if ((inside <= 0) | (inside >= a)).any():
        raise InputError(f"profile: pressures are given for 0 < r < a = {a:g} m only (a cone's is infinite at r = 0)")
    outside = np.linspace(0, min(3 * a, r_max), 151) if surface is None else np.array(surface, dtype=float)
    if ((outside < 0) | (outside > r_max)).any():
        raise InputError(f"profile: surface radii must lie between 0 and the end of the profile ({r_max:g} m)")
    return inside, outside


def _specimen_surface(phi: Density, problem: Problem, r: Array, gap: Array) -> Array:
    """Displacement of the specimen [m]: delta - f + gap, less the indenter's own as a half-space under the pressure,
    (E*/E*_i) int_0^min(a,r) phi(t)/sqrt(r^2 - t^2) dt."""
    both = phi.delta - problem.indenter.f(r) + gap
    material = problem.indenter.material
    if material is None:
        return both
    on_axis = math.pi / 2 * float(phi(np.zeros(1))[0])  # the limit for r -> 0
    own = np.array([phi.arc(0.0, min(phi.a, float(x)), float(x)) if x > 0 else on_axis for x in r])
    return both - problem.E_star / material.E_star * own

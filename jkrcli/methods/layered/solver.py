"""The exact method for laterally unbounded layered specimens (named ``layered``), and contact radii for any loading."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ...base.errors import InputError, Refusal
from ...base.numerics import Array
from ...base.process import StageClock
from ...bodies.problem import Loading, Problem, stacks, without_side_walls
from ...formulas import shift
from ...series import ErrorBudget, Solution
from ..integral.density import Density, disc_warnings, nonsmooth_part, refuse_shrinking
from ..integral.fredholm import FLOPS_PER_SECOND, InaccurateError, search, series_of
from ..protocol import Forecast, LayeredOptions, by_equation
from .contact import GRADED, LAYERED_MARGIN, LayeredContact, checked
from .no_slip import StuckLayeredContact, why_unsupported
from .spectrum import spectrum_seconds

if TYPE_CHECKING:
    from .surface_tension import SurfaceTensionSolver

SEARCH = 1e-10  # relative accuracy to which a prescribed depth or load is met; choice: finer than any tolerance in use
FIRST = 1e-12  # relative accuracy of S at first touch; choice: one radius costs nothing
QUICK = 20.0  # choice: sqrt(a^2 - a0^2) over the kernel's scale up to which a solve takes a fraction of a second
SEARCHES = 4  # solves in which all radii of prescribed depths or loads are found; choice: for forecasts
SolvedContact: TypeAlias = "LayeredContact | StuckLayeredContact | SurfaceTensionSolver"


@dataclass(frozen=True)
class Layered(LayeredOptions):
    """Fredholm equation of the contact problem, all radii from one Cholesky factor; no mesh, S and S' exact.

    Valid for any stack of bonded layers, isotropic (-1 < nu <= 1/2), graded over depth or transversely isotropic,
    on a rigid base, bonded or frictionless, or on an elastic half-space, wider than the contact by so much that its
    sides do not matter, with surface tension or without; any convex indenter, rigid, elastic or coated.
    ``tolerance``: relative error of delta, P, S and S' at every radius, estimated by a second quadrature; no
    smaller than ``GRADED`` where any layer is graded, or ``TENSE_TOLERANCE`` under surface tension.
    """

    def refusal(self, problem: Problem) -> str | None:
        """Why the problem is none of a laterally unbounded stack, with the remedy; None where it is one."""
        radius = problem.specimen.radius
        if radius is not None:
            by_fem = problem.sticks or problem.specimen.surface_tension
            other = "fem" if by_fem else by_equation(problem.specimen)
            return (
                f"the specimen has a finite radius of {radius:g} m, this method knows only laterally "
                f"unbounded ones; use the method {other}, or leave the radius out"
            )
        if problem.specimen.surface_tension and problem.indenter.material and problem.specimen.is_graded:
            return "surface tension of a graded layer under an elastic indenter is not derived: take a rigid indenter"
        return why_unsupported(problem.indenter, problem.specimen) if problem.sticks else None

    def attainable(self, problem: Problem) -> float:
        """The tolerance that holds for the ``problem``."""
        specimen, tense = problem.specimen, 0.0
        if specimen.surface_tension:
            from .surface_tension import ELASTIC_TIP_TOLERANCE, TENSE_TOLERANCE

            tense = TENSE_TOLERANCE if problem.indenter.material is None else ELASTIC_TIP_TOLERANCE
        return max(self.tolerance, GRADED if specimen.is_graded else 0.0, tense)

    def forecast(self, problem: Problem) -> Forecast:
        """Seconds and memory of the solve, from its node counts; finding the largest radius is part of the forecast.

        Refusal of what takes more nodes than the solve accepts.
        """
        contact: Any = _contact(problem)
        seconds = spectrum_seconds(problem)
        tolerance, loading, largest = self.attainable(problem), problem.loading, largest_radius(problem)
        radii = np.linspace(problem.indenter.a0, largest, max(loading.points, 1) + 1)[1:]
        plan: Any = contact.plan(radii, tolerance / LAYERED_MARGIN)
        contact.guard(radii, plan)
        # Floating-point operations: of the solve, of its check at some of the radii, and of finding them all where
        # depths or loads are prescribed
        groups = getattr(plan, "groups", 1)
        some = radii[checked(radii, groups, problem.specimen.is_graded)]
        other, checking = contact.checking(some, plan, tolerance)
        other.guard(some, checking)
        check = other.flops(some, checking)
        each_is_looked_for = loading.spacing in ("depth", "load") or (loading.to != "radius" and loading.values)
        operations = float(contact.flops(radii, plan)) * (SEARCHES if each_is_looked_for else 1) + float(check)
        memory = 8 * 6 * max(plan.nodes + radii.size / groups, checking.nodes + some.size) ** 2 / 2**20
        return Forecast(seconds + operations / FLOPS_PER_SECOND, 5 + memory, tolerance, f"{plan.nodes} nodes, no mesh")

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal outside the validity, SolveError where the tolerance is not reached."""
        reason = self.refusal(problem)
        if reason is not None:
            raise Refusal(reason)
        clock = StageClock()
        contact = _contact(problem)
        with clock("spectrum"):
            _ = contact.spectrum.panels  # now rather than at the first solve
        tolerance = self.attainable(problem)
        with clock("radii"):
            radii = search(contact, problem.loading, max(SEARCH, 0.01 * tolerance)).radii
        with clock("solve"):
            result, errors = contact.refined(radii, tolerance)
        with clock("full disc"):
            refuse_shrinking(radii, result.delta)
            # What is wrong with the contact as a disc; one that sticks has been refused where it does not grow
            warnings: tuple[str, ...] = ()
            if not isinstance(contact, StuckLayeredContact):
                warnings = disc_warnings(contact, problem.specimen, float(radii[-1]), contact.spectrum.kernel)
        series = series_of(result, errors, contact, FIRST)
        budget = ErrorBudget(discretisation=float(errors.max()), truncation=0.0, radius=0.0)
        panels = result.panels
        facts: dict[str, float | int] = {"nodes": panels.x.size, "panels": panels.edges.size - 1, "order": panels.order}
        if contact.specimen.layers:
            facts["a_over_h"] = float(panels.radii[-1]) / contact.specimen.layers[0].thickness
        if stacks(contact.specimen, contact.indenter.material):
            facts["a_over_scale"] = float(panels.radii[-1]) / contact.spectrum.scale
        told: dict[str, Any] = {"facts": facts, "timings": clock.seconds, "warnings": warnings, "solver": self}
        return Solution(problem, series, budget, "layered", **told).widened()


@lru_cache(maxsize=8)  # several methods forecast by it, and solve
def largest_radius(problem: Problem) -> float:
    """The largest contact radius [m] that the loading reaches, for forecasts; ``specimen.radius`` is not looked at.

    For a finite body this is the forecast that a mesh needs: its sides change it little unless the contact is near.
    Contacts so wide that the search would take long are extrapolated by the power with which they grow.
    """
    body = without_side_walls(problem)
    return expected_radius(_contact(body), body.loading, SEARCH)


def expected_radius(contact: SolvedContact, loading: Loading, accuracy: float) -> float:
    """The contact radius [m] at which ``loading`` ends, extrapolated where it is many times the layers' length."""
    limit = math.hypot(contact.indenter.a0, QUICK * contact.scale)
    return search(replace(contact, limit=limit), loading, accuracy).largest


def _contact(problem: Problem) -> SolvedContact:
    kind: Any = StuckLayeredContact if problem.sticks else LayeredContact
    if problem.specimen.surface_tension:
        from .surface_tension import SurfaceTensionSolver, TenseTipSolver

        kind = SurfaceTensionSolver if problem.indenter.material is None else TenseTipSolver
    return kind(problem.indenter, problem.specimen)


# --------------------------------------------------------------------------------------------------
# Contact pressure and surface shape at one contact radius, nonadhesive or adhesive, from the density phi.
#
# Adhesion subtracts a flat punch displaced by sqrt(4 pi w a/S') (Eq. 13), whose phi(a) is not zero: the pressure is
# then singular like -K_I/sqrt(2 pi (a - r)), with K_I = -(E*/2) phi(a) sqrt(pi/a) and the energy release rate
# K_I^2/(2 E*) = w.

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
    reason = Layered().refusal(problem) or nonsmooth_part(problem.specimen)
    if problem.sticks:
        reason = "profile: pressures without slip are not computed by this method: use the field of method fem"
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
    # Displacement of the specimen [m]: delta - f + gap, less the indenter's own as a half-space under the
    # pressure, (E*/E*_i) int_0^min(a,r) phi(t)/sqrt(r^2 - t^2) dt
    both = phi.delta - problem.indenter.f(r_surface) + gap
    material = problem.indenter.material
    if material is None:
        specimen_surface = both
    else:
        on_axis = math.pi / 2 * float(phi(np.zeros(1))[0])  # the limit for r -> 0
        own = np.array([phi.arc(0.0, min(phi.a, float(x)), float(x)) if x > 0 else on_axis for x in r_surface])
        specimen_surface = both - problem.E_star / material.E_star * own
    return Profile(
        a=a,
        w=w,
        delta=phi.delta,
        P=float(result.P[0]) - t * float(result.S[0]),
        r=r,
        pressure=contact.E_star / 2 * phi.pressures(edge, r),
        r_surface=r_surface,
        displacement=specimen_surface,
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

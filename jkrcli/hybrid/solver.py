"""The method ``hybrid``: exact half-space, finite elements for the smooth rest."""

from dataclasses import dataclass, field, replace
from typing import Any

from threadpoolctl import threadpool_limits

from ..base.errors import JkrError, Refusal
from ..base.numerics import MOST_SOLVES, NO_CLAIM, ROUNDED, Array
from ..base.process import StageClock
from ..base.units import show
from ..bodies.problem import AnyTransverse, Elastic, Graded, HalfSpace, Problem, TransverselyIsotropic
from ..methods.integral.density import disc_warnings, refuse_shrinking
from ..methods.integral.fredholm import FLOPS_PER_SECOND, search, series_of
from ..methods.layered.solver import Layered, expected_radius
from ..methods.protocol import AUTO_PATIENCE, Forecast, without_coating, without_tension
from ..methods.radii import check_radius
from ..series import ErrorBudget, KeptKernel, Solution
from . import kernel
from .kernel import AdaptiveKernel
from .options import HybridOptions

# --------------------------------------------------------------------------------------------------
# The method ``hybrid``: the contact equation with a kernel that finite elements compute.

# How the largest radius is found, for which the kernel must be known before it is.
# Reach of the first one over the radius expected on the unbounded body:
REACH_ROOM = 1.2  # tuned on shipped cases, by `make bench`
# of the last one over the largest radius found; tuned on bodies, by `make constants`: covers the accuracy of the
# search
REACH_SPARE = 1.01
REACH_SEARCHES = 2  # kernels for that; tuned on bodies, by `make guards`: for forecasts


@dataclass(frozen=True)
class Hybrid(HybridOptions):
    """The contact equation with the half-space as exact part and finite elements for what the rest of the body changes.

    Valid for stacks of isotropic layers (-1 < nu <= 1/2) on a rigid base, bonded or frictionless, or a half-space, wide
    or cylinders with free, roller or clamped sides; layers below the uppermost may be graded or transversely isotropic,
    in cylinders the uppermost graded too. Any convex indenter, rigid or elastic. S and S' exact, as in ``layered``,
    which solves wide stacks of isotropic layers where elements would take long; a warning of the solution says so.
    ``tolerance``: relative error of delta, P, S and S' at every radius, estimated from coarser elements, fewer
    parameters and a nearer cut. ``known``: a solution with its kernel, which is not computed anew for other radii on
    the same bodies, as far as it reaches.
    """

    known: Solution | None = field(default=None, repr=False, compare=False)

    def refusal(self, problem: Problem) -> str | None:
        """Why the correction cannot be computed, with the remedy; None where it can."""
        reason = _unable(problem)
        if reason or self._kept(problem):
            return reason
        loading, body = problem.loading, self._body(problem)
        if loading.to == "radius" and loading.maximum > body.limit:
            return _too_much(problem)
        try:
            if loading.to == "radius":
                check_radius(problem.indenter, loading.maximum)
            if self._too_long(problem) is None:
                levels = body.levels(_expected_radius(problem, body))
                body.guard(levels, kernel.HYBRID_LOWEST + kernel.STEP * int(body.expected_steps(levels)))
        except JkrError as error:
            return str(error).removeprefix("hybrid: ")
        return None

    def forecast(self, problem: Problem) -> Forecast:
        """Cost of the levels up to the one that the tolerance is expected to need, of the search, and of the solves."""
        if self._kept(problem) is None and self._too_long(problem):
            forecast = self._layered.forecast(problem)
            return replace(forecast, note=f"{forecast.note}, by method layered")
        return self._of_elements(problem)

    def _of_elements(self, problem: Problem) -> Forecast:
        """Cost by elements, whatever it is."""
        body = self._body(problem)
        nodes = 2 * problem.loading.points  # at least
        equation = nodes**3 / 3 / FLOPS_PER_SECOND
        of_equation = 8 * 6 * nodes**2 / 2**20
        if kept := self._kept(problem):
            seconds = 0.02 + (0.8 if kept.of_side else 0.0) + (1 + len(kept.weights)) * equation
            return Forecast(seconds, 20 + of_equation, self.tolerance, "with the kernel of the solution")
        levels = body.levels(_expected_radius(problem, body))
        solves, last = body.expected_cost(levels)
        seconds = 0.02 + solves
        if problem.loading.to != "radius":
            seconds += REACH_SEARCHES * levels.cost(kernel.HYBRID_LOWEST + kernel.STEP).seconds
        if levels.wide is not None:
            seconds += 0.8  # the kernel of the wide body; measured by `make bench`
        memory = 20 + last.memory_mib + of_equation
        note = f"about {float(f'{last.unknowns:.2g}'):.0f} unknowns"
        return Forecast(seconds + equation, memory, body.attainable, note)

    @property
    def _layered(self) -> Layered:
        return Layered(self.tolerance)

    def _too_long(self, problem: Problem) -> str | None:
        """Why elements would take so long on a wide stack of isotropic layers that ``layered`` solves it; else None."""
        specimen = problem.specimen
        if specimen.radius is not None or not all(isinstance(m, Elastic) for m in specimen.materials):
            return None
        try:
            forecast = self._of_elements(problem)
        except Refusal:  # lines of so many elements that they are not made
            return "could not be made"
        if forecast.seconds <= AUTO_PATIENCE and forecast.memory_mib <= kernel.HYBRID_MOST_MIB:
            return None
        return f"would take {kernel.cost_words(forecast.seconds, forecast.memory_mib)}"

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal outside the validity or the tolerance, SolveError."""
        if reason := self.refusal(problem):
            raise Refusal(reason)
        with threadpool_limits(limits=1):  # the matrices are small
            if self._kept(problem) is None and (long := self._too_long(problem)):
                solution = self._layered(problem)
                told = f"hybrid: elements {long}; solved by method layered, exact for layers without sides"
                return replace(solution, warnings=(told, *solution.warnings))
            return self._solution(problem)

    def _solution(self, problem: Problem) -> Solution:
        clock, kept = StageClock(), self._kept(problem)
        body = self._body(problem)
        facts: dict[str, Any]
        if kept is None:
            contact, errors, radii, facts = self._found(problem, body, clock)
            kept = errors.kept
        else:
            assert self.known is not None
            contact, errors = body.from_kept(kept)
            radii = search(contact, problem.loading, kept.accuracy).radii
            share = float(radii[-1] / self.known.series.a[-1])
            facts = dict(self.known.facts)
            facts["a_over_h"] *= share
        with clock("solve"):
            result, unsettled = contact.settled(radii, kept.accuracy)
        with clock("full disc"):
            refuse_shrinking(radii, result.delta)
            warnings = disc_warnings(contact, problem.specimen, float(radii[-1]), lambda _: contact.kernel)
        series = series_of(result, errors.at(radii) + unsettled, contact, kept.accuracy)
        budget = ErrorBudget(float((errors.elements + errors.parameters).max()), float(errors.cut.max()), radius=0.0)
        facts["nodes"] = result.panels.x.size
        told: dict[str, Any] = {"facts": facts, "timings": clock.seconds, "warnings": warnings}
        known: dict[str, Any] = {"companions": errors.companions, "kernel": kept, "solver": replace(self, known=None)}
        return Solution(problem, series, budget, "hybrid", **told, **known).widened()

    def _found(
        self, problem: Problem, body: AdaptiveKernel, clock: StageClock
    ) -> tuple[kernel.KernelContact, kernel.ErrorEstimates, Array, dict[str, Any]]:
        """The contact with its kernel, the errors, the radii [m], and facts about them."""
        with clock("largest radius"):
            reach = self._reach(problem, body)
        for _ in range(MOST_SOLVES):
            with clock("kernel"):
                contact, errors, levels, degree = body.accurate(reach)
            with clock("radii"):
                radii = search(contact, problem.loading, max(NO_CLAIM * self.tolerance, 1e-12)).radii
            if radii[-1] <= contact.limit * (1 + ROUNDED):
                correction = levels.correction(degree)
                region = levels.region
                facts: dict[str, Any] = {
                    "exact_part": "half-space" if levels.wide is None else "laterally unbounded layers",
                    "degree": degree,
                    "elements": correction.elements,
                    "unknowns": correction.unknowns,
                    "parameters": levels.count,
                    "asymmetry": correction.asymmetry,
                    "formulation": "displacement and pressure" if any(region.mixed) else "displacement",
                    "a_over_h": float(radii[-1]) / (region.unit * region.thicknesses[0]),
                }
                if region.cut_beside:
                    facts["cut_m"] = region.width * region.unit
                return contact, errors, radii, facts
            reach = self._further(problem, body, reach, float(radii[-1]))  # the first kernels had been too rough
        raise Refusal(_no_radius(problem, reach))

    def _kept(self, problem: Problem) -> KeptKernel | None:
        """The kernel of the known solution where it is of the bodies of ``problem`` and reaches as far as its radii."""
        loading = problem.loading
        kept = None if self.known is None else self.known.kernel
        if self.known is None or kept is None or loading.to != "radius" or loading.maximum > kept.reach * (1 + ROUNDED):
            return None
        return kept if replace(self.known.problem, loading=loading).key == problem.key else None

    def _body(self, problem: Problem) -> AdaptiveKernel:
        return AdaptiveKernel(problem.indenter, problem.specimen, self.tolerance)

    def _reach(self, problem: Problem, body: AdaptiveKernel) -> float:
        """The largest radius [m] that the loading asks for, with some room where it had to be found."""
        loading = problem.loading
        expected = _expected_radius(problem, body)
        if loading.to == "radius":
            return expected
        reach = min(REACH_ROOM * expected, _end(problem, body))
        for _ in range(MOST_SOLVES):
            largest = search(body.rough(reach), loading, kernel.HYBRID_ROUGH).largest
            if largest <= reach and (REACH_SPARE * largest <= reach or reach == _end(problem, body)):
                return min(REACH_SPARE * largest, _end(problem, body))
            reach = self._further(problem, body, reach, largest)
        raise Refusal(_no_radius(problem, reach))

    def _further(self, problem: Problem, body: AdaptiveKernel, reach: float, largest: float) -> float:
        """The next reach [m] after one that proved too short for the radius ``largest`` [m]."""
        end = _end(problem, body)
        if reach == end:
            raise Refusal(_too_much(problem))
        return min(REACH_ROOM * largest, end)


def _end(problem: Problem, body: AdaptiveKernel) -> float:
    """The largest contact radius [m] that body and profile allow."""
    return min(body.limit, problem.indenter.r_max * (1 - ROUNDED))


def _expected_radius(problem: Problem, body: AdaptiveKernel) -> float:
    """The largest contact radius [m] as on the laterally unbounded body, about."""
    if problem.loading.to == "radius":
        return problem.loading.maximum
    return min(expected_radius(body.wide, problem.loading, kernel.HYBRID_ROUGH), _end(problem, body))


def _no_radius(problem: Problem, reach: float) -> str:
    return (
        f"hybrid: the largest contact radius was not found within {MOST_SOLVES} solves, the last up to "
        f"{show(reach, 'length')}: prescribe loading.radius, or use method {kernel.fem_for(problem.indenter)}"
    )


def _unable(problem: Problem) -> str | None:
    specimen = problem.specimen
    if reason := without_tension(problem) or (without_coating(problem) if problem.specimen.radius is None else None):
        return reason
    if problem.sticks:
        return f"the correction is for frictionless contact: use method {kernel.instead(problem.indenter, specimen)}"
    if specimen.is_half_space:
        return "a homogeneous half-space needs no correction: use method closed-form or layered"
    if specimen.radius is not None and isinstance(specimen.base, HalfSpace):
        return "a body of finite radius needs a rigid substrate: give the depth as a layer's thickness"
    if isinstance(specimen.base, HalfSpace) and isinstance(specimen.base.material, TransverselyIsotropic):
        return "the far field of a transversely isotropic half-space is not known here: use method layered or fem"
    if isinstance(specimen.materials[0], Graded) and specimen.radius is None:
        return "the correction is not smooth where the modulus changes from the contact on: use method layered"
    if isinstance(specimen.materials[0], AnyTransverse):
        other = kernel.instead(problem.indenter, specimen)
        return f"the exact part needs an isotropic material at the contact: use method {other}"
    return None


def _too_much(problem: Problem) -> str:
    """Reason: the contact would come too near to the side, or to the end of the profile."""
    loading, radius = problem.loading, problem.specimen.radius
    goal = loading.goal
    if radius is None:
        return (
            f"loading: a {loading.to} of {goal} needs a contact beyond the profile: load less, or give a larger profile"
        )
    word = {"depth": "depth", "load": "load", "radius": "contact radius"}[loading.to]
    return (
        f"loading: before a {word} of {goal} the contact comes too near to the side (a at most {kernel.HYBRID_EDGE:g} "
        f"of the body's radius, {show(radius, 'length')}): load less, or use method {kernel.fem_for(problem.indenter)}"
    )

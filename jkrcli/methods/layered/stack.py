"""One indenter on one layered specimen: nonadhesive contact at any radii, with as many nodes as an accuracy needs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np

from ...base import NO_CLAIM, Array, Refusal, SolveError
from ...bodies import Indenter, Solid, Specimen, contact_modulus
from .. import integral
from .product import product_matrix
from .spectrum import LayeredSpectrum


@dataclass(frozen=True)
class LayeredTuning:
    """How a result is refined and checked, and what is refused."""

    # The quadrature is planned for this much less than the tolerance:
    margin: float = 8.0  # tuned on random bodies, by `make failures`
    refinements: int = 4  # at most; choice: each takes about twice the time
    checks: int = 12  # radii of the second quadrature, spread over all; tuned on random bodies, by `make failures`
    graded: int = 20  # under a modulus that varies over depth; tuned on graded layers, by `make failures`
    gaps: int = 6  # more of them, after the widest gaps; tuned on random bodies, by `make failures`
    firsts: int = 4  # and first ones of groups; tuned on random bodies, by `make failures`
    safety: float = 4.0  # on the difference of the two quadratures; tuned on random bodies, by `make failures`
    # radii on each side of one, from which its error is: differences go through zero
    about: int = 2  # tuned on graded layers, by `make failures`
    # of the largest difference of its column, and of its radius, which is stated where less is seen:
    share: float = 0.01  # tuned on graded layers, by `make failures`
    most_nodes: int = 4000  # choice: a matrix of 128 MB
    most_flops: float = 4e11  # choice: minutes
    group: int = 16  # least radii that are solved together; tuned on series of 100 to 10,000 points, by `make guards`
    per_group: float = 2e7  # operations in place of what each group costs beside; tuned on the same, by `make guards`
    narrower: float = 8.0  # panels per length over which a graded modulus changes; choice: some 1e-5 of the load
    # operations per entry of a kernel's logarithmic part; tuned on bodies, by `make guards`: for forecasts
    logarithm: int = 400


TUNING = LayeredTuning()
GRADED = 1e-5  # the least tolerance under a modulus that varies over depth; tuned on graded layers, by `make failures`


@dataclass(frozen=True, eq=False)
class IndenterOnLayers(ABC):
    """An indenter on a layered specimen, whatever their surfaces do to each other; ``what`` is solved in how many
    ``rows``."""

    what: ClassVar[str]
    rows: ClassVar[str] = "rows"
    indenter: Indenter
    specimen: Specimen
    limit: float = math.inf  # the kernel is known at every radius; a search for forecasts need not go so far

    @property
    @abstractmethod
    def spectrum(self) -> LayeredSpectrum:
        """The compliance of both bodies over the wave number."""

    @property
    def E_star(self) -> float:
        """Contact modulus of the materials that touch [Pa]."""
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def scale(self) -> float:
        """The length over which the kernel varies [m]; infinite for a homogeneous half-space."""
        return self.spectrum.scale

    @abstractmethod
    def plan(self, radii: Array, tolerance: float) -> Any:
        """The plan expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""

    @abstractmethod
    def solved(self, radii: Array, plan: Any) -> integral.ContactResult:
        """Contact at the increasing ``radii`` [m]."""

    def checking(self, radii: Array, plan: Any, tolerance: float) -> tuple[IndenterOnLayers, Any]:
        """What solves at ``radii`` [m] by a discretisation that shares nothing with ``plan``, and its plan."""
        return self, plan.finer()

    def finer(self, plan: Any) -> Any:
        """The next plan where ``plan`` was too coarse."""
        return plan.finer()

    def unresolved(self, plan: Any, failure: SolveError) -> Exception:
        """What to raise where all plans up to ``plan`` were too coarse to solve the equation."""
        return failure

    def refined(self, radii: Array, tolerance: float) -> tuple[Any, Array]:
        """The result at ``radii`` and its estimated relative error at each, below ``tolerance``, from a second
        discretisation that differs in every part; it is done at some of the radii. Refusal where refinement does not
        reach the tolerance."""
        plan, best = self.plan(radii, tolerance / TUNING.margin), math.inf
        some = checked(radii, getattr(plan, "groups", 1), self.specimen.is_graded)
        failure = SolveError("contact equation: not solved")
        other, check = self.checking(radii[some], plan, tolerance)
        for _ in range(TUNING.refinements):
            try:
                main = self.solved(radii, plan)
                if (rounding := float(main.rounding.max())) > tolerance:
                    best = rounding
                    break
                errors = _errors(main, other.solved(radii[some], check), some) + tolerance * NO_CLAIM
                best = min(best, float(errors.max()))
                if best <= tolerance:
                    return main, errors
            except SolveError as error:
                failure = error
            except Refusal:
                if math.isinf(best):
                    raise
                break  # refined beyond the limits of the cost
            plan, check = self.finer(plan), self.finer(check)
        if math.isinf(best):
            raise self.unresolved(plan, failure)
        missed = f"layered: the estimated relative error{self.what} is {best:.1e} with {plan.nodes} {self.rows}, above "
        missed, smaller = f"{missed}the tolerance {tolerance:.1e}; ", "ask for a smaller contact radius"
        raise integral.InaccurateError(
            f"{missed}{integral.tolerance_remedy('layered', best)}{smaller}", f"{missed}{smaller}", best
        )


@dataclass(frozen=True, eq=False)
class LayeredContact(IndenterOnLayers):
    """Surfaces that slide, solved at given radii; nothing is kept between calls except the spectrum. ``order``: Gauss
    nodes per panel in k."""

    what = ""
    rows = "nodes"
    order: int = 24

    @cached_property
    def spectrum(self) -> LayeredSpectrum:
        return _spectrum(self.specimen, self.indenter.material)

    def plan(self, radii: Array, tolerance: float) -> integral.Quadrature:
        """The cheapest quadrature expected to be accurate to ``tolerance`` at the increasing ``radii`` [m].

        Radii begin panels, which many radii would make more than the kernel needs: they are dealt out in groups.
        """
        plans = []
        for groups in 2 ** np.arange(int(math.log2(max(radii.size / TUNING.group, 1))) + 1):
            each = self.together(radii[(radii.size - 1) % groups :: groups], tolerance)
            plans.append(replace(each, groups=int(groups)))
        return min(plans, key=lambda plan: self.flops(radii, plan))

    def together(self, radii: Array, tolerance: float) -> integral.Quadrature:
        """The same for all ``radii`` on one set of panels."""
        own = radii, self.indenter.a0, self.scale, tolerance
        tail = self.spectrum.tail
        return integral.Quadrature.cheapest(*own) if tail is None else integral.Quadrature.crowded(*own, tail.strength)

    def flops(self, radii: Array, plan: integral.Quadrature) -> float:
        """Floating-point operations of one solve, about."""
        spectrum, each = self.spectrum, math.ceil(radii.size / plan.groups)
        waves = 200 + 0.7 * spectrum.bandwidth(spectrum.floor) * 2 * radii[-1]
        waves += 0 if spectrum.tail is None else TUNING.logarithm
        group = (plan.nodes + each) ** 2 * waves + plan.nodes**3 / 3 + plan.nodes**2 * each
        return float(plan.groups * group + (plan.groups - 1) * TUNING.per_group)

    def guard(self, radii: Array, plan: integral.Quadrature) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > TUNING.most_nodes or self.flops(radii, plan) > TUNING.most_flops:
            many = plan.groups > 1 and plan.nodes <= TUNING.most_nodes  # each group costs as much
            fewer = ", or fewer points" if many else ""
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.spectrum.scale:.4g} times the length over which "
                f"the layers act ({self.spectrum.scale:.3g} m) and needs {plan.nodes} nodes for {radii.size} radii "
                f"(limit {TUNING.most_nodes}); ask for a smaller contact{fewer}"
            )

    def solved(self, radii: Array, plan: integral.Quadrature) -> integral.ContactResult:
        """Contact at the increasing ``radii`` [m]; of one group with its densities, an ``EquationResult``."""
        self.guard(radii, plan)
        kernel = self.spectrum.kernel(2 * float(radii[-1]), self.order)
        if plan.groups == 1:
            return self._group(radii, plan, kernel)
        columns, rounding = np.empty((4, radii.size)), np.empty(radii.size)
        for start in range(plan.groups):
            dealt = slice(start, None, plan.groups)
            part = self._group(radii[dealt], plan, kernel)
            columns[:, dealt], rounding[dealt] = part.columns, part.rounding
        delta, P, S, dS = columns
        return integral.ContactResult(replace(part.panels, radii=radii), delta, P, S, dS, rounding)

    def _group(self, radii: Array, plan: integral.Quadrature, kernel: integral.CosineKernel) -> integral.EquationResult:
        panels = integral.Panels.through(radii, plan, self.indenter.a0)
        return integral.solve(self.matrix(panels, kernel), panels, self.indenter, self.E_star, plan.inner)

    def matrix(self, panels: integral.Panels, kernel: integral.CosineKernel | None = None) -> Array:
        """K [1/m] at the places of the ``panels``; ``kernel``: its smooth part, where it is known."""
        tail = self.spectrum.tail
        smooth = kernel or self.spectrum.kernel(2 * float(panels.edges[-1]), self.order)
        K = smooth.square(panels.places)
        return K if tail is None else K + product_matrix(tail.transform, panels)

    def attraction(self, reach: float, tolerance: float) -> integral.Attraction:
        """The pair of bodies ready for adhesion of finite range up to ``reach`` [m], K to the relative
        ``tolerance``."""
        panels = self.attraction_panels(reach, tolerance)
        return integral.Attraction.of(self.indenter, self.E_star, panels, self.matrix(panels))

    def attraction_panels(self, reach: float, tolerance: float) -> integral.Panels:
        """The panels of ``attraction``; Refusal where they are too many."""
        crowding = 1.0 if self.spectrum.tail is None else TUNING.narrower * self.scale / self.spectrum.tail.finest
        return integral.panels_for(reach, self.indenter.a0, self.scale, tolerance, crowding)

    def checking(self, radii: Array, plan: Any, tolerance: float) -> tuple[LayeredContact, integral.Quadrature]:
        """Shared is g(k) alone: other panels and nodes in x, few wide ones of high order, other nodes in k, other means
        of F."""
        check = self.plan(radii, tolerance / TUNING.margin**3).finer()
        return replace(self, order=20), replace(check, inner=26)

    def finer(self, plan: integral.Quadrature) -> integral.Quadrature:
        return plan.finer() if self.spectrum.tail is None else plan.narrower()

    def unresolved(self, plan: integral.Quadrature, failure: SolveError) -> integral.InaccurateError:
        missed = f"layered: {plan.nodes} nodes do not resolve the kernel, the error is not known; ask for "
        less = "a smaller contact radius"
        return integral.InaccurateError(f"{missed}more points or {less}", f"{missed}{less}")


@lru_cache(maxsize=8)  # the radii of one body are often solved in several steps
def _spectrum(specimen: Specimen, indenter: Solid | None) -> LayeredSpectrum:
    return LayeredSpectrum(specimen, indenter)


def _errors(main: integral.ContactResult, other: integral.ContactResult, some: Array) -> Array:
    """Relative error of each column at every radius (4, radii): the largest difference at the ``some`` radii about it,
    ``about`` and one on each side, with a safety, and rounding."""
    seen, about = np.abs(other.columns / main.columns[:, some] - 1), TUNING.about
    wide = np.lib.stride_tricks.sliding_window_view(np.pad(seen, ((0, 0), (about, about))), 2 * about + 1, axis=1)
    near = np.maximum(wide.max(axis=-1), TUNING.share * np.maximum(seen.max(axis=0), seen.max(axis=1)[:, None]))
    after = np.minimum(np.searchsorted(some, np.arange(main.delta.size)), some.size - 1)
    return TUNING.safety * np.maximum(near[:, after], near[:, np.maximum(after - 1, 0)]) + main.rounding


def checked(radii: Array, groups: int = 1, graded: bool = False) -> Array:
    """Indices of the radii at which a result is checked: spread over all, more of them under a ``graded`` modulus,
    whose errors change from radius to radius, with the ends of the widest gaps and the first radii of some ``groups``,
    inside which a single panel has to hold what F does next to the axis."""
    spread = np.linspace(0, radii.size - 1, TUNING.graded if graded else TUNING.checks).astype(int)
    widest = np.argsort(np.diff(radii, prepend=0.0))[-TUNING.gaps :]
    firsts = np.geomspace(1, groups, TUNING.firsts).astype(int) - 1
    return np.unique(np.concatenate([spread, widest, firsts]))

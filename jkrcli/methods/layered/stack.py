"""One indenter on one layered specimen: nonadhesive contact at any radii, with as many nodes as an accuracy needs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...base import NO_CLAIM, Array, Refusal, SolveError
from ...bodies import Elastic, Indenter, Specimen, contact_modulus
from ..integral import (
    ContactResult,
    DiscreteEquation,
    EquationResult,
    InaccurateError,
    Panels,
    Quadrature,
    solve,
    tolerance_remedy,
)
from .product import product_matrix
from .spectrum import LayeredSpectrum

if TYPE_CHECKING:
    from ..integral import Attraction


@dataclass(frozen=True)
class LayeredTuning:
    """How a result is refined and checked, and what is refused."""

    # The quadrature is planned for this much less than the tolerance:
    margin: float = 8.0  # tuned on random bodies, by `make failures`
    refinements: int = 4  # at most; choice: each takes about twice the time
    checks: int = 12  # radii of the second quadrature, spread over all; tuned on random bodies, by `make failures`
    gaps: int = 6  # more of them, after the widest gaps; tuned on random bodies, by `make failures`
    safety: float = 4.0  # on the difference of the two quadratures; tuned on random bodies, by `make failures`
    most_nodes: int = 4000  # choice: a matrix of 128 MB
    most_flops: float = 4e11  # choice: minutes
    crowd: int = 8  # nodes per radius, below which a refusal names the points as the cause; choice: for the message
    narrower: float = 8.0  # panels per length over which a graded modulus changes; choice: some 1e-5 of the load
    # operations per entry of a kernel's logarithmic part; tuned on bodies, by `make guards`: for forecasts
    logarithm: int = 400


TUNING = LayeredTuning()


@dataclass(frozen=True, eq=False)
class IndenterOnLayers(ABC):
    """An indenter on a layered specimen, whatever their surfaces do to each other; ``what`` is solved. Errors are found
    from a second discretisation that differs in every part."""

    what: ClassVar[str]
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
    def solved(self, radii: Array, plan: Any) -> ContactResult:
        """Contact at the increasing ``radii`` [m]."""

    def refined(self, radii: Array, tolerance: float) -> tuple[ContactResult, Array]:
        """The result at ``radii`` and its estimated relative error at each, below ``tolerance``, from a second
        discretisation that differs in every part; Refusal where refinement does not reach it."""
        plan, best = self.plan(radii, tolerance / TUNING.margin), math.inf
        some = checked(radii)
        for step in range(1, TUNING.refinements + 1):
            finer = plan.finer()
            try:
                main, other = self.solved(radii, plan), self.solved(radii[some], finer)
            except SolveError:
                if math.isinf(best) and step == TUNING.refinements:
                    raise
            else:
                errors = _errors(main, other, some) + tolerance * NO_CLAIM
                best = min(best, float(errors.max()))
                if best <= tolerance:
                    return main, errors
            plan = finer
        raise self._inaccurate(best, f"{plan.nodes} rows", tolerance)

    def _inaccurate(self, error: float, rows: str, tolerance: float) -> InaccurateError:
        """Refusal that names the least ``error`` found and what may help."""
        smaller = "ask for a smaller contact radius"
        missed = f"layered: the estimated relative error{self.what} is {error:.1e} with {rows}, above the tolerance "
        missed += f"{tolerance:.1e}; "
        return InaccurateError(f"{missed}{tolerance_remedy('layered', error)}{smaller}", f"{missed}{smaller}")


@dataclass(frozen=True, eq=False)
class LayeredContact(IndenterOnLayers):
    """Surfaces that slide, solved at given radii; nothing is kept between calls except the spectrum."""

    what = ""

    @cached_property
    def spectrum(self) -> LayeredSpectrum:
        return _spectrum(self.specimen, self.indenter.material)

    def plan(self, radii: Array, tolerance: float) -> Quadrature:
        """The cheapest quadrature expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        own = radii, self.indenter.a0, self.scale, tolerance
        tail = self.spectrum.tail
        return Quadrature.cheapest(*own) if tail is None else Quadrature.crowded(*own, tail.strength)

    def flops(self, radii: Array, plan: Quadrature) -> float:
        """Floating-point operations of one solve, about."""
        spectrum = self.spectrum
        waves = 200 + 0.7 * spectrum.bandwidth(spectrum.floor) * 2 * radii[-1]
        waves += 0 if spectrum.tail is None else TUNING.logarithm
        return float((plan.nodes + radii.size) ** 2 * waves + plan.nodes**3 / 3 + plan.nodes**2 * radii.size)

    def guard(self, radii: Array, plan: Quadrature) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > TUNING.most_nodes or self.flops(radii, plan) > TUNING.most_flops:
            fewer = ", or fewer points" if TUNING.crowd * radii.size > plan.nodes else ""  # each begins a panel
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.spectrum.scale:.4g} times the length over which "
                f"the layers act ({self.spectrum.scale:.3g} m) and needs {plan.nodes} nodes for {radii.size} radii "
                f"(limit {TUNING.most_nodes}); ask for a smaller contact{fewer}"
            )

    def solved(self, radii: Array, plan: Quadrature, order: int = 24, inner: int = 20) -> EquationResult:
        """Contact at the increasing ``radii`` [m]; ``order``: Gauss nodes per panel in k, ``inner``: per panel in the
        integrals of F."""
        self.guard(radii, plan)
        panels = Panels.through(radii, plan, self.indenter.a0)
        return solve(DiscreteEquation.of(self.matrix(panels, order), panels), self.indenter, self.E_star, inner)

    def matrix(self, panels: Panels, order: int = 24) -> Array:
        """K [1/m] at the places of the ``panels``; ``order``: Gauss nodes per panel in k."""
        spectrum = self.spectrum
        smooth = spectrum.kernel(2 * float(panels.edges[-1]), order).square(panels.places)
        return smooth if spectrum.tail is None else smooth + product_matrix(spectrum.tail.transform, panels)

    def attraction(self, reach: float, tolerance: float, order: int = 24) -> Attraction:
        """The pair of bodies ready for adhesion of finite range up to ``reach`` [m], K to the relative ``tolerance``;
        ``order`` as in ``matrix``."""
        from ..integral import Attraction

        panels = self.attraction_panels(reach, tolerance)
        return Attraction.of(self.indenter, self.E_star, panels, self.matrix(panels, order))

    def attraction_panels(self, reach: float, tolerance: float) -> Panels:
        """The panels of ``attraction``; Refusal where they are too many."""
        from ..integral import panels_for

        crowding = 1.0 if self.spectrum.tail is None else TUNING.narrower * self.scale / self.spectrum.tail.finest
        return panels_for(reach, self.indenter.a0, self.scale, tolerance, crowding)

    def refined(self, radii: Array, tolerance: float) -> tuple[EquationResult, Array]:
        """The result at ``radii`` and its estimated relative error at each, below ``tolerance``.

        The estimate is the difference from a second quadrature that shares nothing with the first but g(k): other
        panels and nodes in x, other nodes in k, other means of F. It is done at some of the radii, where a few wide
        panels of high order are cheap. Refusal where refinement does not reach the tolerance.
        """
        plan = self.plan(radii, tolerance / TUNING.margin)
        some = checked(radii)
        check = self.plan(radii[some], tolerance / TUNING.margin**3).finer()
        best = math.inf
        for step in range(TUNING.refinements):
            try:
                main = self._attempt(radii, plan, order=24, inner=20 + 8 * step)
                if main is not None and (rounding := float(main.rounding.max())) > tolerance:
                    best = rounding
                    break
                other = self._attempt(radii[some], check, order=20, inner=26 + 8 * step)
            except Refusal:
                if math.isinf(best):
                    raise
                break  # refined beyond the limits of the cost
            if main is not None and other is not None:
                errors = _errors(main, other, some) + tolerance * NO_CLAIM
                best = min(best, float(errors.max()))
                if best <= tolerance:
                    return main, errors
            plan, check = (p.finer() if self.spectrum.tail is None else p.narrower() for p in (plan, check))
        if math.isinf(best):
            missed = f"layered: {plan.nodes} nodes do not resolve the kernel, the error is not known; ask for "
            raise InaccurateError(*(f"{missed}{more}a smaller contact radius" for more in ("more points or ", "")))
        raise self._inaccurate(best, f"{plan.nodes} nodes", tolerance)

    def _attempt(self, radii: Array, plan: Quadrature, order: int, inner: int) -> EquationResult | None:
        """Result of ``solved``; None where the quadrature is too coarse for a positive definite matrix."""
        try:
            return self.solved(radii, plan, order, inner)
        except SolveError:
            return None


@lru_cache(maxsize=8)  # the radii of one body are often solved in several steps
def _spectrum(specimen: Specimen, indenter: Elastic | None) -> LayeredSpectrum:
    return LayeredSpectrum(specimen, indenter)


def _errors(main: ContactResult, other: ContactResult, some: Array) -> Array:
    """Relative error of any column at every radius: the largest difference, with a safety, and rounding."""
    seen = np.max(np.abs(other.columns / main.columns[:, some] - 1))
    return TUNING.safety * seen + main.rounding


def checked(radii: Array) -> Array:
    """Indices of the radii at which a result is checked: spread over all, with the ends of the widest gaps."""
    spread = np.linspace(0, radii.size - 1, TUNING.checks).astype(int)
    widest = np.argsort(np.diff(radii, prepend=0.0))[-TUNING.gaps :]
    return np.unique(np.concatenate([spread, widest]))

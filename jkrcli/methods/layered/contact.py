"""One indenter on one layered specimen: nonadhesive contact at any radii, with as many nodes as an accuracy needs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...base.errors import Refusal, SolveError
from ...bodies.indenters import Indenter
from ...bodies.materials import contact_modulus
from ...bodies.problem import Specimen
from .kernel import Kernel, LayeredSpectrum, Sum, phase_allowed
from .product import product_matrix
from .solver import SHRINK, AbelImage, Nested, Panels, solve

Array = np.ndarray

ORDERS = range(1, 11)  # Gauss nodes per panel
UNSMOOTH = 4  # the least order where the solution is not smooth at the edge
EDGE = 0.03  # its error there: the square of this times the panel's width times the strength of the logarithm
CROWDING = 8
NARROWER = 1.5
LOGARITHM = 400  # operations that an entry of the kernel's logarithmic part costs
FREQUENCY = 5.0  # highest wave number that the solution contains noticeably, times the kernel's scale
CROWD = 8  # nodes per radius, below which it is the radii that make them many
MAX_NODES = 4000
MAX_FLOPS = 4e11
MARGIN = 8.0  # the quadrature is planned for this much less than the tolerance
CHECKS, GAPS = 12, 6
SAFETY = 4.0
NO_CLAIM = 1e-3  # errors below this part of the tolerance are not told apart
COLUMNS = ("delta", "P", "S", "dS")
REFINEMENTS = 4
LOOSEST = 1e-2  # of the tolerances


class InaccurateError(Refusal):
    """The tolerance was not reached; ``fixed``: the message where the tolerance is not the user's to choose."""

    def __init__(self, lines: str | Sequence[str], fixed: str):
        super().__init__(lines)
        self.fixed = fixed

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.lines, self.fixed)


@dataclass(frozen=True)
class Plan:
    """A quadrature: ``order`` Gauss nodes on panels no wider than ``widest`` [m], ``nodes`` in all; ``crowding``: cuts
    of the last panel before each radius."""

    order: int
    widest: float
    nodes: int
    crowding: int = 0

    def finer(self) -> Plan:
        """One or two more nodes on the same panels: at least one order of magnitude more accurate."""
        step = 1 if self.order <= 4 else 2
        crowding = self.crowding + 1 if self.crowding else 0
        return Plan(self.order + step, self.widest, self.nodes // self.order * (self.order + step), crowding)

    def narrower(self) -> Plan:
        """Narrower panels of the same order, more crowded: product integration loses accuracy at higher orders."""
        return Plan(self.order, self.widest / NARROWER, math.ceil(self.nodes * NARROWER), self.crowding + 1)

    def crowded(self, radii: Array, strength: float, tolerance: float) -> Plan:
        """The same with panels that crowd before each radius, for a kernel -``strength`` ln |x - t| [1/m]."""
        wide = min(float(np.max(np.diff(radii, prepend=0.0))), self.widest)
        excess = EDGE * strength * wide / math.sqrt(tolerance)
        cuts = min(math.ceil(math.log(max(excess, 1.0)) / -math.log(SHRINK)), CROWDING)
        return Plan(self.order, self.widest, self.nodes + self.order * cuts * radii.size, cuts)


def cheapest(radii: Array, a0: float, scale: float, tolerance: float, orders: Iterable[int] = ORDERS) -> Plan:
    """The cheapest quadrature expected to be accurate to ``tolerance`` at the increasing ``radii`` [m], for a flat end
    of the radius ``a0`` and a kernel that varies over the length ``scale`` [m]."""
    widths = np.diff(np.unique(np.concatenate([[0.0, a0], radii])))
    plans = []
    for order in orders:
        widest = float(phase_allowed(order, tolerance)) * scale / FREQUENCY
        pieces = np.ceil(widths / widest) if math.isfinite(widest) else np.ones(widths.size)
        plans.append(Plan(order, widest, int(order * np.maximum(pieces, 1).sum())))
    return min(plans, key=lambda plan: plan.nodes)


@dataclass(frozen=True, eq=False)
class LayeredContact:
    """The pair of bodies. ``nested`` solves at given radii; nothing is kept between calls except the spectrum."""

    indenter: Indenter
    specimen: Specimen

    @property
    def E_star(self) -> float:
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def scale(self) -> float:
        """The length over which the kernel varies [m]; infinite for a homogeneous half-space."""
        return self.spectrum.scale

    @property
    def limit(self) -> float:
        """The kernel is known at every radius."""
        return math.inf

    @cached_property
    def spectrum(self) -> LayeredSpectrum:
        return LayeredSpectrum(self.specimen, self.indenter.material)

    def prepare(self) -> None:
        """Resolve the spectrum now rather than at the first solve."""
        if self.specimen.layers:
            _ = self.spectrum.panels

    def first_stiffness(self) -> float:
        """S at first touch [N/m]: that of a flat punch of the radius a0, 0 for round and pointed indenters."""
        a0 = self.indenter.a0
        if a0 == 0:
            return 0.0
        radii = np.array([a0])
        return float(self.nested(radii, self.plan(radii, 1e-12)).S[0])

    def plan(self, radii: Array, tolerance: float) -> Plan:
        """The cheapest quadrature expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        tail = self.spectrum.tail
        if tail is None:
            return cheapest(radii, self.indenter.a0, self.scale, tolerance)
        plan = cheapest(radii, self.indenter.a0, self.scale, tolerance, [n for n in ORDERS if n >= UNSMOOTH])
        return plan.crowded(radii, abs(float(tail.coefficients[0])), tolerance)

    def flops(self, radii: Array, plan: Plan) -> float:
        """Floating-point operations of one nested solve, about."""
        spectrum = self.spectrum
        waves = 200 + 0.7 * spectrum.bandwidth(spectrum.floor) * 2 * radii[-1]
        waves += 0 if spectrum.tail is None else LOGARITHM
        return float((plan.nodes + radii.size) ** 2 * waves + plan.nodes**3 / 3 + plan.nodes**2 * radii.size)

    def guard(self, radii: Array, plan: Plan) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > MAX_NODES or self.flops(radii, plan) > MAX_FLOPS:
            fewer = ", or fewer points" if CROWD * radii.size > plan.nodes else ""  # each begins a panel
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.spectrum.scale:.4g} times the length over which "
                f"the layers act ({self.spectrum.scale:.3g} m) and needs {plan.nodes} nodes for {radii.size} radii "
                f"(limit {MAX_NODES}); ask for a smaller contact{fewer}"
            )

    def nested(self, radii: Array, plan: Plan, order: int = 24, inner: int = 20, added: Kernel | None = None) -> Nested:
        """Solve at the increasing ``radii`` [m] with the quadrature ``plan``; ``order``: Gauss nodes per panel in k,
        ``inner``: per panel in the integrals of F; ``added``: what the sides of a finite body add to K."""
        self.guard(radii, plan)
        image = AbelImage.of(self.indenter, inner)
        breaks = (self.indenter.a0,) if self.indenter.a0 > 0 else ()
        panels = Panels.through(radii, plan.order, plan.widest, breaks, plan.crowding)
        tail = self.spectrum.tail
        singular = None if tail is None else product_matrix(tail.transform, panels)
        kernel: Kernel = self.spectrum.kernel(2 * radii[-1], order)
        return solve(kernel if added is None else Sum(kernel, added), panels, image, self.E_star, singular)

    def refined(self, radii: Array, tolerance: float) -> tuple[Nested, Array]:
        """The result at ``radii`` and its estimated relative error at each, below ``tolerance``.

        The estimate is the difference from a second quadrature that shares nothing with the first but g(k): other
        panels and nodes in x, other nodes in k, other means of F. It is done at ``CHECKS`` of the radii, where a few
        wide panels of high order are cheap. Refusal where refinement does not reach the tolerance.
        """
        plan = self.plan(radii, tolerance / MARGIN)
        some = checked(radii)
        check = self.plan(radii[some], tolerance / MARGIN**3).finer()
        best = math.inf
        for step in range(REFINEMENTS):
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
        raise _inaccurate(best, plan.nodes, tolerance)

    def _attempt(self, radii: Array, plan: Plan, order: int, inner: int) -> Nested | None:
        """As ``nested``; None where the quadrature is too coarse for a positive definite matrix."""
        try:
            return self.nested(radii, plan, order, inner)
        except SolveError:
            return None


def _inaccurate(error: float, nodes: int, tolerance: float) -> InaccurateError:
    """The least ``error`` that was found, infinite where none was, and what may help."""
    smaller = "ask for a smaller contact radius"
    if math.isinf(error):
        missed = f"layered: {nodes} nodes do not resolve the kernel, the error is not known; "
        return InaccurateError(f"{missed}ask for more points or a smaller contact radius", f"{missed}{smaller}")
    missed = f"layered: the estimated relative error is {error:.1e} with {nodes} nodes, above the tolerance "
    missed += f"{tolerance:.1e}; "
    enough = f"set layered.tolerance to {2 * error:.0e}, or " if 2 * error <= LOOSEST else ""
    return InaccurateError(f"{missed}{enough}{smaller}", f"{missed}{smaller}")


def _errors(main: Nested, other: Nested, some: Array) -> Array:
    """Relative error of any column at every radius: the largest difference found, ``SAFETY`` times, plus rounding."""
    seen = [np.max(np.abs(getattr(other, name) / getattr(main, name)[some] - 1)) for name in COLUMNS]
    return SAFETY * np.max(seen) + main.rounding


def checked(radii: Array) -> Array:
    """Indices of the radii at which a result is checked: spread over all, with the ends of the widest gaps."""
    spread = np.linspace(0, radii.size - 1, CHECKS).astype(int)
    widest = np.argsort(np.diff(radii, prepend=0.0))[-GAPS:]
    return np.unique(np.concatenate([spread, widest]))

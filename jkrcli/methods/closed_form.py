"""The method ``closed-form``: bodies whose solution is a formula, within the range where the formula holds."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from .. import formulas
from ..base.errors import InputError, Refusal, SolveError
from ..base.numerics import SAME, Array
from ..base.process import PATIENCE, StageClock
from ..base.units import show
from ..bodies.indenters import Paraboloid, Sphere
from ..bodies.problem import Elastic, Layer, Loading, Problem, Rigid, without_side_walls
from ..series import COLUMNS, ErrorBudget, Series, Solution
from .layered.solver import Layered
from .protocol import Forecast, by_equation, without_coating, without_tension
from .radii import ROUGH, Search

# Accuracies, relative.
CLOSED_FORM_ROUND_OFF = 1e-14  # theory: 45 times the machine epsilon, for the dozen operations of a formula
CLOSED_FORM_WORST = 0.05  # choice: largest error at which the leading order of a thin layer is still offered


@dataclass(frozen=True, eq=False)
class Formula:
    """``columns``: radii [m] -> delta_H [m], P_H [N], S [N/m], S' [N/m^2]; ``error``: relative."""

    name: str
    columns: Callable[[Array], tuple[Array, Array, Array, Array]]
    error: float = CLOSED_FORM_ROUND_OFF


@dataclass(frozen=True)
class ClosedForm:
    """Formulae for the homogeneous half-space and for one thin layer, within their validity.

    Half-space under any indenter that has a closed form (sphere, paraboloid, power law, rounded flat): exact to
    round-off. One thin layer under a sphere or paraboloid, leading order for a/h -> infinity: where it errs by less
    than 5 % at all requested radii, checked against the exact layer solution, never assumed.
    """

    name: ClassVar[str] = "closed-form"

    def refusal(self, problem: Problem) -> str | None:
        try:
            _formula(problem)
        except Refusal as refusal:
            return "; ".join(refusal.lines)
        return None

    def forecast(self, problem: Problem) -> Forecast:
        formula = _formula(problem)
        return Forecast(1e-3, 1.0, formula.error, formula.name)

    def __call__(self, problem: Problem) -> Solution:
        formula, clock = _formula(problem), StageClock()
        with clock("solve"):
            indenter = problem.indenter
            a = _radii(problem, formula)
            columns = formula.columns(a)
            S0 = float(formula.columns(np.array([indenter.a0]))[2][0])
            errors = {name: formula.error * values for name, values in zip(COLUMNS, (0 * a, *columns), strict=False)}
            series = Series(a, *columns, errors=errors, a0=indenter.a0, S0=S0)
        budget = ErrorBudget(discretisation=formula.error, truncation=0.0, radius=0.0)
        facts = {"solution": formula.name}
        return Solution(problem, series, budget, self.name, facts=facts, timings=clock.seconds, solver=self)


def _radii(problem: Problem, formula: Formula) -> Array:
    def responses(quantity: str, accuracy: float) -> Callable[[Array], Array]:
        return lambda a: formula.columns(a)[{"depth": 0, "load": 1}[quantity]]

    return Search(problem.loading, problem.indenter, problem.E_star, responses, (ROUGH, CLOSED_FORM_ROUND_OFF)).radii


def _formula(problem: Problem) -> Formula:
    """The formula for this body; Refusal where there is none, with what to use instead."""
    if reason := without_tension(problem) or without_coating(problem):
        raise Refusal(reason)
    # sticking changes nothing on an incompressible half-space under a rigid or incompressible indenter
    tip, ours = problem.indenter.material, problem.specimen.materials[0].surface.nu == 0.5
    same = problem.specimen.is_half_space and ours and (tip is None or tip.surface.nu == 0.5)
    if problem.sticks and not same:
        other = "layered" if problem.specimen.radius is None else "fem"
        raise Refusal(f"no formula is known for no slip: use method {other}")
    if problem.specimen.is_half_space:
        E_star, indenter = problem.E_star, problem.indenter
        if indenter.half_space(np.array([indenter.a0]), 1.0) is None:
            raise Refusal(f"there is no closed form for a {indenter.noun}: use method layered")

        def columns(a: Array) -> tuple[Array, Array, Array, Array]:
            pair = indenter.half_space(a, E_star)
            assert pair is not None
            return *pair, 2 * E_star * a, np.full_like(a, 2 * E_star)

        return Formula("half-space", columns)
    match problem.specimen.layers, problem.specimen.base, problem.specimen.radius:
        case (Layer(material=Elastic()) as layer,), Rigid() as base, None:
            return _thin_layer(problem, layer, base)
    other = by_equation(problem.specimen)
    raise Refusal(f"solves homogeneous half-spaces and thin single isotropic layers only: use method {other} or fem")


def _thin_layer(problem: Problem, layer: Layer, base: Rigid) -> Formula:
    """The leading order for a/h -> infinity, where the exact layer solution confirms it at the requested radii."""
    indenter = problem.indenter
    if not isinstance(indenter, Paraboloid | Sphere) or indenter.material is not None:
        raise Refusal("the thin-layer formulae are for a rigid sphere or paraboloid: use method layered")
    formula = _leading_order(indenter.R, layer, base)
    try:
        radii = _radii(problem, formula)
        error = _leading_order_error(problem, formula, radii[[0, -1]] if radii.size > 1 else radii)
    except (InputError, SolveError) as reason:
        raise Refusal(f"the thin-layer formula could not be checked: {reason}") from None
    if error > CLOSED_FORM_WORST:
        first, last = radii[[0, -1]] / layer.thickness
        # A relative error in words, of a formula that gives too much where it is large
        off = f"errs by {100 * error:.2g} %" if error < 1 else f"gives up to {1 + error:.2g} times the exact values"
        raise Refusal(
            f"the thin-layer formula {off} between a/h = {first:.3g} and {last:.3g}, more than "
            f"{CLOSED_FORM_WORST:.0%}: use method layered"
        )
    return replace(formula, error=error)


def _leading_order(R: float, layer: Layer, base: Rigid) -> Formula:
    material, h = layer.material, layer.thickness
    assert isinstance(material, Elastic)
    if base.bonded and material.nu == 0.5:
        G = material.G

        def squeezed(a: Array) -> tuple[Array, Array, Array, Array]:
            return *formulas.thin_incompressible_layer(a, G, h, R), *formulas.thin_incompressible_slopes(a, G, h)

        return Formula("thin incompressible layer, leading order", squeezed)
    K = formulas.foundation_modulus(material.E, material.nu, h) if base.bonded else material.E_star / h

    def winkler(a: Array) -> tuple[Array, Array, Array, Array]:
        return *formulas.thin_layer(a, K, R), *formulas.thin_layer_slopes(a, K)

    return Formula("thin compressible layer, leading order (Eq. 20)", winkler)


def _leading_order_error(problem: Problem, formula: Formula, radii: Array) -> float:
    """Largest relative difference of delta, P, S and S' to the exact layer solution at the increasing ``radii``, where
    that is no quick matter at the largest one below; SolveError where there is none."""
    layered, wide, worst = Layered(SAME), without_side_walls(problem), 0.0
    for a in radii.tolist():
        while True:
            exactly = replace(wide, loading=Loading.given("radius", (a,)))
            try:
                if (seconds := layered.forecast(exactly).seconds) <= PATIENCE:
                    break
                reason = f"would take about {seconds:.2g} s"
            except Refusal as error:
                reason = f"is refused ({error})"
            if worst > CLOSED_FORM_WORST:
                return worst
            if a <= 2 * radii[0]:
                raise SolveError(f"the exact layer at a = {show(a, 'length')} {reason}")
            a /= 2  # beyond, the error is smaller: it falls as h/a
        exact = layered(exactly).series
        pairs = zip(formula.columns(np.array([a])), (exact.delta, exact.P, exact.S, exact.dS), strict=True)
        worst = max(worst, *(float(np.abs(ours / theirs - 1)[0]) for ours, theirs in pairs if theirs is not None))
    return worst

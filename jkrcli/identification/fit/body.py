"""The body whose curves are fitted: one family, or a family for every modulus and thickness of its layers.

It comes from a case, which is solved on the way, or from a series that was solved before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...adhesion import FiniteRangeBody, Nonadhesive, RangeRequest, Slopes
from ...adhesion.slopes.choice import slopes
from ...base import REMEMBERED, ROUNDED, ROWS, SAME, UNSEEN, InputError, JkrError, Refusal, SolveError, show
from ...beside import JKR, nonadhesive
from ...bodies import RADIUS, Indenter, Loading, Problem, changed, checked_names, layer_names, nominal, unbounded
from ...case import Case, load_case, read_solution, solve
from ...methods import Layered, Limits
from ...series import Series, Solution
from .attracted import COARSE, FINE, AttractedFamily, Resolution
from .device_path import TUNING as PATHS
from .family import Family, Members


@dataclass(frozen=True)
class ResolvingTuning:
    """How bodies are solved anew with other layers or to other radii."""

    step: float = 1e-4  # theory: of logs of parameters, for derivatives: the square root of the solve's 1e-8
    rounded: float = 0.01  # choice: of the same logs; derivatives at rounded values are remembered
    per_decade: int = 20  # choice: radii to which a body is solved, so that many curves share one solve
    points: int = 100  # choice: least radii of a series that is solved to another radius
    adheres: float = 1.2  # choice: of the contact radius without adhesion, what adhesion may make of it
    deep: float = 0.7  # choice: of the tip's radius, to which a body is solved before anything is fitted


TUNING = ResolvingTuning()


@dataclass(frozen=True, eq=False)
class FittedBody:
    """A body whose measured curves are fitted, with its family of adhesive curves.

    ``problem``: bodies and nominal values; ``series``, ``slopes``: its nonadhesive solution, by any method.

    Only bodies that the method ``layered`` represents can be solved anew: ``with_values``. ``extensible``: may also be
    solved to other radii than those of the series. ``moduli_known``: whether the user gave the moduli of the problem;
    else they only stand in for a unit. ``tolerance``: of the solves, far below the noise of any record.
    ``range_of_case``: the range of adhesion of the case; ``no_range``: why the body has no curves of one.
    """

    problem: Problem
    series: Series
    slopes: Slopes
    family: Family
    extensible: bool = False
    moduli_known: bool = True
    tolerance: float = Layered.tolerance
    range_of_case: RangeRequest = JKR
    no_range: str = ""
    resolution: Resolution = FINE

    @classmethod
    def of(cls, problem: Problem, series: Series, slopes: Slopes, extensible: bool = False) -> FittedBody:
        return cls(problem, series, slopes, Family.of(series, slopes), extensible)

    def members(self, ranged: bool) -> Members:
        """The adhesive curves of the body, of finite range or JKR's."""
        return self.attracted if ranged else self.family

    @cached_property
    def nonadhesive(self) -> Nonadhesive:
        """The functions of the body without adhesion."""
        return Nonadhesive(self.series, self.slopes)

    @cached_property
    def attracted(self) -> AttractedFamily:
        """The adhesive curves of finite range; Refusal where the body has none."""
        if self.problem.sticks:
            raise Refusal(
                "fit: adhesion of finite range is for frictionless contact alone: give --surface sliding, or leave "
                "range and stress out"
            )
        if self.no_range:
            raise Refusal(self.no_range)
        return AttractedFamily.of(self.problem, self.family, self.resolution)

    @cached_property
    def coarse(self) -> FittedBody:
        """The same body with coarse curves of finite range."""
        return replace(self, resolution=COARSE)

    @property
    def layer_names(self) -> tuple[str, ...]:
        """Names of the layers as in the case, else their numbers from 1 at the contact; "base": the half-space."""
        return layer_names(self.problem.specimen)

    @property
    def own_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that need the body solved anew; none for a finite cylinder."""
        if self.problem.specimen.radius is not None:
            return ()
        layers = self.layer_names[: len(self.problem.specimen.layers)]
        return (*(f"E:{name}" for name in self.layer_names), *(f"h:{name}" for name in layers))

    def moduli(self, s: float) -> dict[str, float]:
        """E* and the moduli of all layers [Pa] by name, those of the problem times ``s``; of an indenter that is
        elastic too, which is scaled with them, E* alone."""
        problem = self.problem
        materials = () if problem.indenter.material is not None else problem.specimen.materials
        own = {f"E:{name}": s * one.surface.E for name, one in zip(self.layer_names, materials, strict=False)}
        return {"E_star": s * problem.E_star, **own}

    def nominal(self, name: str) -> float:
        """The value of "E:layer" [Pa], "h:layer" [m], "nu:layer" or "radius" [m] in the problem."""
        if name == RADIUS:
            return float(cast(Any, self.problem.indenter).R)
        return nominal(self.problem.specimen, name)

    def with_values(self, values: dict[str, float]) -> FittedBody:
        """The body solved anew by ``layered`` at the same radii with other ``values`` ("E:film": 2e6, ...), if any."""
        if not values:
            return self
        problem = changed(self.problem, values)
        return replace(self, problem=problem, family=self._solved(problem))

    def rated(self, values: dict[str, float], varied: Sequence[str]) -> FittedBody:
        """The body of ``with_values`` with the family's derivatives by the logs of the values of ``varied``.

        They are taken at rounded values, so that steps near the solution need no more solves for them.
        """
        body, near = self.with_values(values), {name: _nearby(value) for name, value in values.items()}
        base = self._solved(changed(self.problem, near))
        moved = {name: changed(self.problem, near | {name: near[name] * math.exp(TUNING.step)}) for name in varied}
        rates = {name: base.rate_to(self._solved(problem), TUNING.step) for name, problem in moved.items()}
        return replace(body, family=replace(body.family, rates=rates))

    def on_surface(self, surface: str) -> FittedBody:
        """The same body whose surfaces are "sliding" or "sticking": solved anew by ``layered`` where they were not."""
        if surface == self.problem.surface:
            return self
        if self.problem.specimen.radius is not None:
            raise InputError(
                "fit: --surface: a finite cylinder is not solved anew: give the series of a case with the other "
                "specimen.surface"
            )
        other = self._reaching(float(self.series.a[-1]), sticks=surface == "sticking")
        return replace(other, extensible=self.extensible)

    def to_radius(self, a: float) -> FittedBody:
        """The same problem solved by ``layered`` up to contact radius ``a`` [m] or little more, with as many points."""
        if a >= (end := self.problem.indenter.r_max):
            raise InputError(
                f"the data ask for a contact radius of {show(a, 'length')}, beyond the indenter, which ends at "
                f"{show(end, 'length')}: check the units of displacement and load, and the size of the indenter"
            )
        rounded = 10 ** (math.ceil(math.log10(a) * TUNING.per_decade) / TUNING.per_decade)
        return self._reaching(rounded if rounded < end else a)

    def down_to(self, a: float) -> FittedBody:
        """The same problem solved from the contact radius ``a`` [m] on, in proportion below the series' own."""
        first, a0 = float(self.series.a[0]), self.series.a0
        steps = math.ceil(math.log10((first - a0) / (a - a0)) * TUNING.per_decade)
        below = a0 + (a - a0) * np.geomspace(1.0, (first - a0) / (a - a0), steps, endpoint=False)
        loading = Loading.given("radius", (*below.tolist(), *self.series.a.tolist()))
        return self._on(loading)

    def under(self, indenter: Indenter, a: float) -> FittedBody:
        """The same specimen under another ``indenter``, solved to the contact radius ``a`` [m] and beyond."""
        return self._reaching(min(max(a, float(self.series.a[-1])), indenter.r_max * (1 - ROUNDED)), indenter=indenter)

    def to_depth(self, depth: float) -> FittedBody:
        """The same problem solved to the contact radius at a ``depth`` [m], where it may be; beyond the series it is
        estimated by continuation, as far as below it."""
        u = np.linspace(self.family.low, self.family.high + PATHS.below, ROWS)
        reached = np.flatnonzero(self.family.at(u)[0][0] <= depth)
        tip, a = self.problem.indenter, math.exp(u[reached[-1]]) if reached.size else 0.0
        a = TUNING.adheres * a if TUNING.adheres * a < tip.r_max else a
        endless = tip.kinks and math.isinf(tip.r_max)  # a rounded cone: R is that of its end alone
        a = a if tip.tip_radius is None or endless else min(a, TUNING.deep * tip.tip_radius)
        return self.to_radius(a) if self.extensible and a > self.series.a[-1] else self

    def _reaching(self, a: float, **changes: Any) -> FittedBody:
        """The body of a changed problem solved up to contact radius ``a`` [m], as the user describes this one."""
        return self._on(Loading("radius", a, max(len(self.series), TUNING.points), "radius"), **changes)

    def _on(self, loading: Loading, **changes: Any) -> FittedBody:
        """The body of a changed problem under another ``loading``, as the user describes this one."""
        other = _exact(replace(unbounded(self.problem), loading=loading, **changes), self.tolerance)
        return replace(other, **{name: getattr(self, name) for name in ("moduli_known", "range_of_case", "no_range")})

    def _solved(self, problem: Problem) -> Family:
        at_radii = Loading.given("radius", tuple(self.series.a))
        return solved(replace(unbounded(problem), loading=at_radii), self.tolerance)


@lru_cache(maxsize=REMEMBERED)
def _exact(problem: Problem, tolerance: float) -> FittedBody:
    series = Layered(tolerance)(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"), True)


def _nearby(value: float) -> float:
    return math.exp(TUNING.rounded * round(math.log(value) / TUNING.rounded))


@lru_cache(maxsize=REMEMBERED)
def solved(problem: Problem, tolerance: float) -> Family:
    """The family of a problem by ``layered``, at a coarser tolerance where it cannot be solved to this one.

    SolveError where it cannot be solved, with the reason.
    """
    for coarser in (tolerance, *(one for one in (SAME, UNSEEN) if one > tolerance)):
        try:
            series = Layered(coarser)(problem).series
            break
        except JkrError as error:
            reason = str(error)
    else:
        raise SolveError(f"the body could not be solved anew: {reason}")
    return Family.of(series, slopes(series, "exact"))


def check_parameters(body: FittedBody, names: Sequence[str]) -> None:
    """Refuse parameters of layers that the body does not have or that cannot be solved anew."""
    own = [name for name in names if ":" in name]
    if own and not body.own_parameters:
        raise InputError(f"fit: {own[0]}: a finite cylinder is not solved anew; fit its modulus, or leave radius out")
    checked_names(own, body.own_parameters)


def for_each(radii: Sequence[float], count: int) -> list[float]:
    """The tip radius [m] of each of ``count`` files, where one was given for each, or one for all; none where none
    was."""
    if len(radii) not in (0, 1, count):
        raise InputError(f"fit: --tip-radius: give one for each of the {count} files, or one for all, got {len(radii)}")
    return list(radii) * (count // len(radii)) if radii else []


def body_of(
    source: Case | Problem | Solution | str | Path, rule: str = "auto", limits: Limits | None = None
) -> FittedBody:
    """The body of a case, a problem, a solution, or a file, its slopes by ``rule``. A case may be solved anew to the
    radii that the data ask for, which has exact slopes; a solution, and what has others, ends where it ends."""
    if isinstance(source, str | Path):
        source = load_case(source) if Path(source).suffix == ".toml" else read_solution(source)
    if isinstance(source, Solution):
        body = nonadhesive(source, rule)
        return _with_range(FittedBody.of(source.problem, body.series, body.slopes), source)
    _, solution = solve(source, limits=limits)
    problem, series = solution.problem, solution.series
    extensible = problem.specimen.radius is None and rule in ("auto", "exact")
    return _with_range(FittedBody.of(problem, series, slopes(series, rule), extensible), solution)


def _with_range(body: FittedBody, solution: Solution) -> FittedBody:
    """The body with the range of adhesion of its case, and whether it has curves of one."""
    refused = ""
    try:
        FiniteRangeBody.of(solution)
    except Refusal as error:
        refused = str(error)
    return replace(body, range_of_case=RangeRequest.of(solution.record), no_range=refused)

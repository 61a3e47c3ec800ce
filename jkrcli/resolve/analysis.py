"""A solution and a work of adhesion to the adhesive curve with its pull-off points, errors, validity and warnings, and
where contact is lost under every control."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..adhesion.contact_shape import DISC, ContactShape, refuse_no_disc
from ..adhesion.curve import (
    CONTROLS,
    DISPLACEMENT_CONTROL,
    LOAD_CONTROL,
    AdhesiveCurve,
    CriticalPoint,
    Equilibrium,
    EquilibriumCurve,
    Nonadhesive,
    columns_at,
    mask_below_atomic_spacing,
)
from ..adhesion.device_path import Stability, behaviours, stable_radius
from ..adhesion.finite_range import AttractedBody, FiniteRangeBody, FiniteRangeCurve, Range, RangeRequest
from ..adhesion.pull_off_error import Errors, error_of_rows, from_reference, pull_off_error
from ..adhesion.roughness import RoughWork
from ..adhesion.rules import RULES
from ..adhesion.slopes import Slopes, exact, slopes, smoothed
from ..adhesion.slopes.nodes import Ahead
from ..adhesion.validity import (
    Strains,
    Validity,
    faces,
    judge_solution,
    large_strains,
    refuse_wetting,
    strain_size,
    unresolved,
    with_large_strains,
    yield_warning,
)
from ..base.errors import Estimate, InputError, JkrError, Refusal, Unknown
from ..base.numerics import HALF_WIDTH, MOST_SOLVES, ROUNDED, ROWS, SAME, UNSEEN, Array, composite_gauss
from ..base.process import PATIENCE
from ..base.registry import Reported
from ..base.units import LARGEST_SI, show
from ..base.wings import absent, offered
from ..bodies.problem import INCOMPRESSIBLE, Loading, Problem, relaxing
from ..methods.integral.density import nonsmooth_part
from ..methods.integral.finite_range import AttractedSurface, adhesive_surface, attracted_surface
from ..methods.layered.solver import surface_profile
from ..methods.protocol import METHODS, Forecast, Method, method_class
from ..series import ErrorBudget, Series, Solution, is_series
from .node_radii import Compared, compared
from .resolve import Comparison, compare_half_space, effect_of_range, own_solution, resolve_with
from .sticking import StickingEffect, effect_on

JKR: RangeRequest = RangeRequest()
EXPLAINED = 0.1  # choice: of what a force is off, the part of the loads from which they are its cause
REFERENCE_BEYOND = 1.2  # choice: of the largest radius, up to which pull-off by the exact solution is looked for
CALIBRATED = Ahead(0.0, 0.02, "calibrated on a half-space of the same surface mesh", 0.02)
TINY = Unknown("it would be one of a contact smaller than atoms")
Lost: TypeAlias = tuple[Stability, Errors | Unknown | None]  # read off under one control; half-widths of its pull-off


@dataclass(frozen=True, eq=False)
class Analysis(Reported):
    """One adhesive curve with its critical points, error budget, validity and, where it exists, the exact solution.

    ``law``: of adhesion of finite range, None for JKR; ``effect``: what it matters whether the surfaces stick, where
    that is known for several curves of one body at once; ``rough``: what its w is by, where the surfaces are rough.
    """

    solution: Solution
    curve: EquilibriumCurve
    budget: ErrorBudget
    modulus_factor: float = 1.0
    law: Range | None = None
    effect: StickingEffect | Unknown | None = None
    rough: RoughWork | None = None

    def __repr__(self) -> str:
        return f"<Analysis of {self.path}: w = {self.w:g} J/m^2, {len(self.curve.series)} points>"

    @property
    def path(self) -> Path:
        """The solution file, as messages name it."""
        return self.solution.record.path

    @property
    def problem(self) -> Problem:
        """What was solved, with the moduli of this curve."""
        return self.solution.problem

    @property
    def dropped(self) -> int:
        """How many increments are not in the series; none where it is between them."""
        between = self.solution.touches is not None and self.curve.slopes.method in ("integral", "exact")
        return 0 if between else self.solution.increments.a.size - len(self.curve.series)

    @property
    def w(self) -> float:
        return self.curve.w

    @property
    def jkr(self) -> AdhesiveCurve:
        """The curve where adhesion has no range; InputError where it has one."""
        if not isinstance(self.curve, AdhesiveCurve):
            raise InputError(f"{self.path}: adhesion of finite range is not used here: leave stress and range out")
        return self.curve

    @cached_property
    def pull_off(self) -> dict[str, CriticalPoint | Unknown]:
        """Where contact is lost under control of the load and of the displacement; of a full end, where each of them
        measures the largest tension."""
        curve, z0 = self.curve, self.solution.record.z0
        controls = {name: curve.series.control_of_force(k) for name, k in CONTROLS.items()}
        return {name: mask_below_atomic_spacing(curve.pull_off(k), curve, k, z0) for name, k in controls.items()}

    @cached_property
    def pull_off_errors(self) -> dict[str, Errors | Unknown]:
        """Half-widths of delta [m] and P [N] of each pull-off point that there is, or why they are unknown."""
        return {
            name: error_of_point(self.curve, point, self.curve.series.control_of_force(CONTROLS[name]))
            for name, point in self.pull_off.items()
            if isinstance(point, CriticalPoint)
        }

    @cached_property
    def validity(self) -> Validity:
        """The numbers by which the result is judged, with pull-off under load control."""
        return self.validity_at(self.pull_off["load"])

    def validity_at(self, *points: CriticalPoint | Unknown) -> Validity:
        """The same with the widest of the pull-off ``points`` that there are."""
        there = [point for point in points if isinstance(point, CriticalPoint)]
        widest, effect = max((point.a for point in there), default=None), self.effect_of_range
        worst = max((self.large_strains(point) for point in there), key=strain_size, default=None)
        z0 = self.solution.record.z0 if self.law is None else self.law.length
        judged = judge_solution(self.problem, self.curve.series, self.solution.facts, w=self.w, z0=z0,
                                a_pull_off=widest, effect_of_range=effect)  # fmt: skip
        if self.law is not None:
            judged = replace(judged, regime="its finite range is included, attraction from a to c")
        return with_large_strains(judged, worst)

    def large_strains(self, point: Equilibrium | Unknown) -> Strains:
        """What large strains change of the pull-off force at the ``point`` if there is one; known of discs alone."""
        if self.shape is not None or not isinstance(point, CriticalPoint):
            return None
        loaded = self.pull_off["load"]
        by_load = isinstance(loaded, CriticalPoint) and loaded.a == point.a
        return large_strains(self.problem, self.w, point, by_load, self.curve.surface_displacement(point))

    @cached_property
    def comparison(self) -> Comparison | None:
        """The distance to the exact solution of the same indenter; None but for a half-space that slides."""
        specimen = self.problem.specimen
        half_space = self.problem.is_half_space and not (self.problem.sticks or specimen.surface_tension)
        if not half_space or self.shape is not None or not isinstance(self.curve, AdhesiveCurve):
            return None
        return compare_half_space(self.curve, self.problem)

    @cached_property
    def sticking(self) -> StickingEffect | Unknown:
        """What it matters whether the surfaces stick."""
        return effect_on(self.solution, [self.w]) if self.effect is None else self.effect

    @cached_property
    def effect_of_range(self) -> Estimate:
        """Relative change of the pull-off force under load control, if adhesion had the range z0; 0 where it has."""
        point = self.pull_off["load"]
        if self.law is not None:
            return 0.0
        if isinstance(point, Unknown):
            return point
        if self.shape is not None:
            return Unknown("the effect of a range is solved for contacts that are discs")
        return effect_of_range(self.problem, self.curve.series, self.w, self.solution.record.z0, point)

    @property
    def warnings(self) -> list[str]:
        """Everything that a reader of the numbers should know, each with its number."""
        judged = self.validity
        outside = [f"pull-off under {name} control: {point.reason}" for name, point in self.pull_off.items()
                   if isinstance(point, Unknown) and self.w > 0]  # fmt: skip
        limits, flags = judged.warnings, self.curve.slopes.flags
        if self.curve.slopes.method != "exact":
            flags += unresolved(self.problem.indenter, self.curve.a)
        flags += faces(self.problem, self.w)
        doubts = getattr(self.curve, "doubts", ())
        relaxes = relaxing(self.problem.specimen.relaxation)
        sentences = [*relaxes, *self.solution.warnings, *flags, *limits, *doubts]
        sentences += [*yield_warning(self.problem, self.curve.series), *outside]
        sentences += [*self._off_the_bodies, *self.rough_warnings]
        return list(dict.fromkeys(sentences))

    @property
    def shape(self) -> ContactShape | None:
        """The shape of a contact that is no disc."""
        return ContactShape.of(self.solution.facts, self.problem.is_half_space)

    @property
    def rough_warnings(self) -> Sequence[str]:
        """What is doubtful of the roughness, where there is one."""
        point = self.pull_off["load"]
        return () if self.rough is None else self.rough.contact.warnings(getattr(point, "a", None))

    @property
    def _off_the_bodies(self) -> list[str]:
        """How far the pull-off force lies off that of the bodies' exact solution, where rows do not explain it, and
        what does: loads at equal displacement do not feel the radii."""
        point, curve = self.pull_off["load"], self.curve
        if not isinstance(point, CriticalPoint) or not isinstance(curve, AdhesiveCurve):
            return []
        own, off = error_of_rows(curve, point, LOAD_CONTROL), from_reference(curve, point, LOAD_CONTROL)[1]
        size = abs(point.P)
        if off <= (UNSEEN * size if isinstance(own, Unknown) else own["P"]):
            return []
        rows = str(own) if isinstance(own, Unknown) else f"rows explain {own['P'] / size:.2g}; the stated error has it"
        factor, error = (self.solution.facts.get(name) for name in ("loads_factor", "loads_factor_error"))
        cause = ""
        if isinstance(factor, float) and isinstance(error, float):
            alike = abs(factor - 1) <= max(error, EXPLAINED * off / size)
            cause = (
                "; loads at equal displacement are those of these bodies, contact radii are not: their unit, or nodes "
                "(import --nodes)?" if alike
                else f"; loads at equal displacement are {factor:.4g} times those of these bodies: a factor, a unit, E?"
            )  # fmt: skip
        return [f"the pull-off force is {off / size:.2g} off that of the exact solution of these bodies; {rows}{cause}"]


def analyse(
    solution: Solution,
    works: Sequence[float],
    slopes_name: str = "auto",
    modulus_factor: float = 1.0,
    request: RangeRequest = JKR,
    devices: Sequence[float] = (),
) -> list[Analysis]:
    """The adhesive curves of a solution for each work of adhesion [J/m^2], with solved pull-off points where the method
    is exact, and rows below the series where contact is lost there; the slopes are found once.

    ``modulus_factor``: of bodies whose moduli are all that many times those of the solution; nothing is solved anew.
    ``request``: adhesion of finite range, where it has a stress or a length. ``devices``: stiffnesses [N/m] of those
    whose pull-off is asked for besides.
    """
    if request:
        if slopes_name not in ("auto", "exact"):
            raise InputError(
                f"slopes: {slopes_name} has no effect with adhesion of finite range, whose kernel is exact: leave it "
                "out"
            )
        scaled, laws = solution.scaled(modulus_factor), [request.law(w) for w in works]
        ranged = FiniteRangeBody.of(scaled)
        curves = [(law, ranged.curve(law)) for law in laws]
        return [
            Analysis(scaled, curve, replace(scaled.budget, smoothing=curve.interpolation_error), modulus_factor, law)
            for law, curve in curves
        ]
    if slopes_name in ("auto", "exact"):
        solution = solved_below(solution, works, modulus_factor, devices)
    body = nonadhesive(solution, slopes_name)
    return [with_solved_points(adhesive(solution, body, w, modulus_factor), *devices) for w in works]


# What curves cost, as measured on series of 100 to 1,000,000 rows.
COST_MIB = 110.0  # memory of any; tuned on series of 100 rows, by `make bench`
COST_MIB_PER_ROW = 3e-3  # of curves; tuned on series of 1e6 rows, by `make bench`
COST_TABLE_MIB_PER_ROW = 6e-3  # and of their tables; tuned on series of 1e6 rows, by `make bench`
COST_MIB_PER_CURVE = 0.6  # and of each beyond the first; tuned on 300 works of 100 rows, by `make guards`
COST_MIB_PER_ROW_OF_CURVE = 1e-3  # and of its rows; tuned on 60 works of 2,000 rows, by `make guards`
COST_FIT = 0.2  # CPU seconds of slopes that are fitted; tuned on noisy series of 100 rows, by `make guards`
COST_FIT_PER_ROW = 2e-5  # and per row; tuned on noisy series of 1e5 rows, by `make guards`
COST_CURVE = 0.03  # CPU seconds of a curve; tuned on series of 100 rows, by `make bench`
COST_PER_ROW = 4e-5  # and per row; tuned on series of 1e5 rows, by `make bench`
COST_TABLE_PER_ROW = 3e-5  # and of its table; tuned on series of 1e5 rows, by `make bench`
COST_DEVICE = 7e-3  # of what is read off it for a device; tuned on 10 to 2,000 devices, by `make guards`
# Memory of pictures that wait for the collector, ten of them; tuned on 5 to 60 works of adhesion, by `make guards`
COST_PICTURES, COST_PICTURES_MIB = 10, 130.0
COST_FIGURE = 0.6  # of its pictures; tuned on series of 100 rows, by `make bench`


def forecast(
    solution: Solution, works: Sequence[float], request: RangeRequest = JKR, tables: bool = True, figures: bool = False,
    devices: int = 0,
) -> Forecast:  # fmt: skip
    """What the curves of a solution for ``works`` of adhesion [J/m^2] cost, with their tables and pictures or without,
    and what is read off for so many ``devices``; ``request``: of finite range."""
    rows = (solution.raw or solution.series).a.size
    fitted = COST_FIT + COST_FIT_PER_ROW * rows if solution.series.S is None else 0.0
    per_row, mib = COST_PER_ROW + tables * COST_TABLE_PER_ROW, COST_MIB_PER_ROW + tables * COST_TABLE_MIB_PER_ROW
    each = COST_CURVE + per_row * rows + figures * COST_FIGURE + devices * COST_DEVICE
    if request:
        body = FiniteRangeBody.of(solution)  # the dearest of its curves: the least or the largest w reaches farthest
        each += max(body.seconds(request.law(w)) for w in {min(works), max(works)})
    else:
        each += seconds_of_points(solution, devices)
    mib = COST_MIB + mib * rows + (len(works) - 1) * (COST_MIB_PER_CURVE + COST_MIB_PER_ROW_OF_CURVE * rows)
    mib += figures * COST_PICTURES_MIB * min((len(works) - 1) / COST_PICTURES, 1.0)
    return Forecast(fitted + len(works) * each, mib, 0.0)


def adhesive(solution: Solution, body: Nonadhesive, w: float, modulus_factor: float = 1.0) -> Analysis:
    """The adhesive curve for the work of adhesion ``w`` [J/m^2] on bodies ``modulus_factor`` times as stiff."""
    if not 0 <= w <= LARGEST_SI:
        raise InputError(f"w: must lie between 0 and {LARGEST_SI:g} J/m^2, got {w:g}")
    refuse_wetting(w, modulus_factor * solution.problem.specimen.surface_tension)
    curve = AdhesiveCurve(body.scaled(modulus_factor), w)
    # the budget is that of the series with the slopes'; what interpolation adds between the rows is no part of it
    budget = replace(solution.budget, smoothing=body.slopes.error)
    return Analysis(solution.scaled(modulus_factor), curve, budget, modulus_factor)


def with_solved_points(result: Analysis, *devices: float) -> Analysis:
    """The same curve with its pull-off points, those by ``devices`` of a stiffness [N/m] included, solved at their own
    radii, where the method is exact and quick."""
    if result.law is not None:
        assert isinstance(result.curve, FiniteRangeCurve)
        return replace(result, curve=result.curve.with_solved_points(*devices))
    curve = result.jkr
    if curve.w == 0 or curve.nonadhesive.slopes.method != "exact":
        return result
    further = solver_of(result.solution)
    return result if further is None else replace(result, curve=solved(curve, further, *devices))


def solved_where(
    solution: Solution, body: Nonadhesive, wanted: Callable[[Nonadhesive], Sequence[float]]
) -> Nonadhesive:
    """The functions ``body`` through what is solved at the radii [m] that are ``wanted`` of them, where the method of
    ``solution`` is exact and quick."""
    further = solver_of(solution) if body.slopes.method == "exact" else None
    return body if further is None else refined(body, further, wanted)


def error_of_point(curve: EquilibriumCurve, point: CriticalPoint, stiffness: float) -> Errors | Unknown:
    """Half-widths of a pull-off ``point`` under a device of ``stiffness`` [N/m], on curves of either kind."""
    if isinstance(curve, AdhesiveCurve):
        return pull_off_error(curve, point, stiffness)

    assert isinstance(curve, FiniteRangeCurve)
    return curve.point_error(point, stiffness)


def where_lost(
    solution: Solution, works: Sequence[float], stiffnesses: Sequence[float], slopes: str, modulus_factor: float,
    request: RangeRequest,
) -> list[tuple[Analysis, list[Lost]]]:  # fmt: skip
    """For each of the ``works`` [J/m^2] the curve, and what is read off under each control: by a device of one of the
    ``stiffnesses`` [N/m], else of load and displacement; with half-widths of its pull-off point, None where there is
    none."""
    controls = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)
    results = [
        with_solved_points(result, *stiffnesses)
        for result in analyse(solution, works, slopes, modulus_factor, request, stiffnesses)
    ]
    told = []
    for result in results:
        lost = list[Lost]()
        for behaviour in behaviours(result.curve, controls):
            k, z0 = behaviour.stiffness, result.solution.record.z0
            point = mask_below_atomic_spacing(behaviour.pull_off, result.curve, k, z0)
            if point is not behaviour.pull_off and isinstance(point, Unknown):  # it would happen at radii below atoms
                behaviour = replace(
                    behaviour, critical=(), pull_off=point, jump_in=TINY, energy_lost=TINY, separation=TINY
                )
            at, held = behaviour.pull_off, result.curve.series.control_of_force(k)
            lost.append((behaviour, None if isinstance(at, Unknown) else error_of_point(result.curve, at, held)))
        told.append((result, lost))
    return told


def nonadhesive(solution: Solution, slopes_name: str = "auto") -> Nonadhesive:
    """The w-free functions of a solution by the slopes called ``slopes_name``; InputError names the file.

    The integral fit takes increments as they are, plateaus and noise included; all else takes the paper's filter first.
    """
    try:
        # The increments beside the bodies that they are of: those of another program beside their own solution,
        # unless it is not to be used
        beside: Compared | None = None
        if solution.raw is not None:
            read = solution.method == "import"
            with_bodies = read and solution.facts.get("compared") != "no"
            disc = solution.facts.get("contact_shape", DISC) == DISC
            beside = compared(solution.problem, solution.raw, with_bodies, disc)
            if not read and solution.facts.get("edge_correction"):
                beside = replace(beside, ahead=CALIBRATED)
        pair = _series_and_slopes(solution, slopes_name, beside)
    except InputError as error:
        path = str(solution.record.path)
        raise InputError([line if line.startswith(path) else f"{path}: {line}" for line in error.lines]) from None
    series, slopes = pair
    unestimated = solution.budget.discretisation
    if isinstance(unestimated, Unknown) and solution.method == "fem":
        # what rows leave of a fit tells nothing of the mesh that all of them share, nor of its edge
        slopes = replace(slopes, error=unestimated, covariance=None, joint=None)
    return Nonadhesive(series, slopes, reference=_reference(solution, series, beside))


def _reference(solution: Solution, series: Series, beside: Compared | None) -> Nonadhesive | None:
    """The functions of the bodies by their exact solution; None where the ``series`` is one itself, or there is none:
    of all bodies only half-spaces have it beside rows that are not to be compared, and beside meshes."""
    own = None if beside is None else beside.own
    if own is None:
        method, problem = solution.method, solution.problem
        specimen, r_max = problem.specimen, problem.indenter.r_max
        closed = problem.is_half_space and not (problem.sticks or specimen.surface_tension)
        disc = solution.facts.get("contact_shape", DISC) == DISC
        if not closed or not disc or (method in METHODS and METHODS[method].exact):
            return None
        own = own_solution(problem, np.append(series.a, min(REFERENCE_BEYOND * series.a[-1], r_max * (1 - ROUNDED))))
    return None if own is None or own.S is None or own.dS is None else Nonadhesive(own, exact(own))


def _series_and_slopes(solution: Solution, name: str, beside: Compared | None) -> tuple[Series, Slopes]:
    of_nodes = beside is not None and beside.nodes is not None
    own = beside.own if beside is not None else None
    touches = solution.at_touches
    if touches is not None and name in ("auto", "integral", "exact"):
        series, found = _series_and_slopes(touches, name, None)
        return series, replace(found, reason=f"at the radii of nodes, between increments; {found.reason}")
    if beside is not None and name in ("auto", "integral") and (of_nodes or not is_series(beside.raw.touching)):
        return _by_rows(solution, beside)
    if name in RULES and RULES[name].quantised and (reason := _uneven(solution)):
        raise Refusal(f"slopes '{name}': {reason}")
    indenter = solution.problem.indenter
    series = replace(solution.filtered, own=own, kinks=indenter.kinks, bends=indenter.bends)
    if series.coarser is not None and indenter.thinned:
        series = replace(series, unresolved=solution.unresolved)
    if name not in ("auto", "exact"):
        series = replace(series, S=None, dS=None)
    if beside is None or not of_nodes or name == "exact":
        return series, slopes(series, name)
    if solution.method == "import":  # the paper's filter takes an increment too late; increments of ``fem`` keep it
        series = _at_touches(series, beside)
    surer = _by_rows(solution, beside) if touches is None else _series_and_slopes(touches, "auto", None)
    return series, slopes(series, name, surer)


def _by_rows(solution: Solution, beside: Compared) -> tuple[Series, Slopes]:
    """Series and slopes by all increments of a solution; of its own loads the error is known."""
    series = solution.series
    of_loads = np.stack([series.delta, series.errors["P"] / series.P]) if "P" in series.errors else None
    return smoothed(beside.raw, series.a0, series.S0, beside.own, beside.ahead, of_loads)


def _uneven(solution: Solution) -> str | None:
    """Why the mesh of increments by finite elements cannot serve a rule that takes radii of nodes as they are."""
    facts = solution.facts
    if solution.method != "fem" or facts.get("contact") != "incremental":
        return None
    if facts.get("layout") == "scaled":
        return (
            'takes the contact radii of increments as they are, those of nodes, and the nodes of the layout "scaled" '
            "stand apart in proportion to the radius: dS/da would be that of the mesh (75 and 143 mN for 63 mN on the "
            'thin layer of cases/paper); set mesh.layout = "zones", the paper\'s uniform mesh, or contact.algorithm = '
            '"nested", or take the slopes "integral"'
        )
    nu = max(material.surface.nu for material in solution.problem.specimen.materials)
    if facts.get("order") == 1 and facts.get("integration", "full") == "full" and nu > INCOMPRESSIBLE:
        quads = ', mesh.integration = "reduced" (as CAX4R)' if facts.get("element") == "quadrilateral" else ""
        return (
            f"these first-order elements lock at nu = {nu:g} > {INCOMPRESSIBLE:g}, where dS/da errs several times more "
            f'than the load; set mesh.order = 2{quads}, or take the slopes "integral"'
        )
    return None


def _at_touches(series: Series, beside: Compared) -> Series:
    """The ``series`` at the moments at which nodes are reached, where these are in order."""
    assert beside.nodes is not None
    touches, ahead = beside.nodes.touches(beside.ahead.elements), beside.ahead
    rows = touches.rows
    if not is_series(rows) or rows.a[0] <= series.a0:
        return series
    return replace(
        series, a=rows.a, delta=rows.delta, P=rows.P, errors={}, shift=ahead.error * touches.element,
        own=beside.own,
    )  # fmt: skip


# --------------------------------------------------------------------------------------------------
# The points where contact is lost, solved anew at their own radii where the method that made the series is exact.
#
# Between its radii a series is interpolated, with a larger error than that of an exact method. The problem is solved
# once more at seven radii close around each pull-off point: the curve then passes through the middle one with the
# slopes of the polynomials through the seven, and the errors of these slopes say how well the place is known.
#
# Over a homogeneous half-space delta_H is F, over others delta_H' = sqrt(2 E*/S') F' + what the kernel adds, which is
# smooth where the profile is not: the first part is integrated, and the polynomials only follow the rest.

POINTS = 14  # choice: radii that are solved at once for a curve: seven around each of two pull-off points
Further = Callable[[Array], Nonadhesive]  # the functions at other radii [m], solved
STEPS = np.arange(-3, 4)
MIDDLE = STEPS.size // 2
# Rows: derivatives of the polynomials through all values at ``STEPS``, the inner five, the inner three, by the step.
WEIGHTS = np.array([[-1, 9, -45, 0, 45, -9, 1], [0, 5, -40, 0, 40, -5, 0], [0, 0, -30, 0, 30, 0, 0]]) / 60

# Where further radii are solved, and how often.
SOLVED_STEP = 0.02  # of log(a - a0) between the seven; tuned on random bodies, by `make bounds`
# Of what is stated of columns, and of S', what is neither a spring in series nor a stiffness: on random bodies at
# most 0.03 of delta, 0.08 of S'
SOLVED_OWN = (0.06, 0.06, 0.06, 0.13)  # tuned on random bodies, by `make bounds`
# of delta where delta' is meant, at least
SOLVED_ROUGH = 0.25  # tuned on random bodies, by `make bounds`
# and of S' where S'' is meant, at least
SOLVED_BENT = 0.45  # tuned on random bodies, by `make bounds`
# Error of a rate, in logs, over that of its column: one kernel errs smoothly
SOLVED_STEEPER = 1.5  # tuned on random bodies, by `make bounds`
# By how much slower changes from order to order fall than those before, at x of (d - x)^p and of its logarithm:
# as h^2/d^2 times (3 - p) (4 - p)/5, then 3 (5 - p) (6 - p)/14
SOLVED_SLOWER = 4.0  # theory: up to p = 1.2; the profile of a sphere is singular at its rim
# Radius up to which such a kernel is made over that of the outermost point, less the flat end, at most:
SOLVED_REACH = 1.6  # tuned on random bodies, by `make bounds`
SOLVED_SCATTER = 1e-11  # of the columns from radius to radius; tuned on random bodies, by `make bounds`
SOLVED_EACH = 0.3  # of that of a solve, the cost of a curve's points; tuned on 1 to 1000 layers, by `make bench`
# Rows below a series, in equal steps of log sqrt(a^2 - a0^2), and how many more below the least pull-off:
SOLVED_DECADE = 15  # choice: a little closer than the 25 of four decades of "log", per decade of a - a0
SOLVED_UNDER = 4  # theory: of which splines and seven points around the point need some
SOLVED_RIM = 2e-6  # theory: of a0, the first sqrt(a^2 - a0^2): a - a0 is 1e4 times the round-off of a


def method_behind(solution: Solution) -> Method | None:
    """The method that made ``solution``, as it was configured, with the kernel that it has found; None for series that
    no method of this program made."""
    if solution.method not in METHODS:
        return None
    method: Any = solution.solver or method_class(solution.method)()
    return method if solution.kernel is None else replace(method, known=solution)


def solver_of(solution: Solution) -> Further | None:
    """How further radii of ``solution`` are solved; None where its radii are not exact. ``seconds_of_points`` forecasts
    what that costs."""
    method, series = method_behind(solution), solution.series
    stated = {"delta", "dS"} <= series.errors.keys() and series.dS is not None
    if method is None or not stated or np.any(series.errors.get("a", 0.0)):
        return None
    problem, kept = replace(solution.problem, loading=Loading.given("radius", (float(series.a[-1]),))), solution.kernel
    if method.refusal(problem):
        return None

    def further(a: Array) -> Nonadhesive:
        beyond = np.outer(a - series.a0, np.exp(SOLVED_STEP * STEPS))
        radii = (series.a0 + beyond).ravel()
        if "parameters" in solution.facts and (kept is None or radii.max() > kept.reach):
            end = min(series.a0 + SOLVED_REACH * float(np.max(a - series.a0)), float(series.a[-1]))
            radii = np.append(radii, max(end, radii.max()))
        radii, order = np.unique(radii, return_inverse=True)
        return _in_the_middle(resolve_with(problem, radii, method), order[: beyond.size].reshape(-1, STEPS.size))

    return further


def seconds_of_points(solution: Solution, devices: int = 0) -> float:
    """CPU seconds of the solved pull-off points of a curve, about, those by so many ``devices`` included; 0 where none
    are, or can be."""
    method, a = method_behind(solution), solution.series.a
    radii = np.unique(np.linspace(max(0.5 * a[-1], a[0]), a[-1], POINTS + STEPS.size * devices))
    problem = replace(solution.problem, loading=Loading.given("radius", tuple(radii.tolist())))
    with contextlib.suppress(Refusal):
        return SOLVED_EACH * method.forecast(problem).seconds if method and solver_of(solution) else 0.0
    return 0.0


def _in_the_middle(solution: Solution, sevens: Array) -> Nonadhesive:
    """The functions at the ``sevens``, rows (n, 7) of ``solution`` at ``STEPS``, with slopes and the joint covariance
    of columns and slopes at the middle of each: those around it say how the slopes change."""
    series, problem = solution.series, solution.problem
    assert series.S is not None
    assert series.dS is not None
    # Rows that lie nearer, in logs, to their own middle than to any other, which all do
    places = np.log(series.a[sevens] - series.a0)
    middles, n = places[:, MIDDLE], np.arange(len(sevens))
    away, own = np.abs(places[:, :, None] - middles), np.abs(places - middles[:, None])
    away[n, :, n] = np.inf
    nearer = np.min(away, axis=2) >= own + SOLVED_STEP / 2
    nearer[:, MIDDLE] = True
    rows = np.unique(sevens[nearer])
    errors = {name: values[rows] for name, values in series.errors.items()}
    inner = replace(series, **columns_at(series, rows), errors=errors, unresolved=solution.unresolved[:, rows])
    middle = sevens[:, MIDDLE]
    beyond, delta, dS = series.a[middle] - series.a0, series.delta[middle], series.dS[middle]
    followed = [_followed(problem, series, seven) for seven in sevens]
    known = np.array([rate for _, rate in followed]) * beyond / delta
    rest = np.stack([rest for rest, _ in followed]) / delta[:, None]
    (rate, by_dS), left = _rates(np.stack([rest, np.log(series.dS[sevens])]))
    log_rates, joint = np.full((rows.size, 2), np.nan), np.zeros((rows.size, 6, 6))
    here = np.searchsorted(rows, middle)
    log_rates[here] = np.stack([known + rate, by_dS * series.a[middle] / beyond], axis=1)
    unit = np.stack([delta, dS]) / beyond
    joint[here] = _joint(solution, sevens, np.stack([known + rate, by_dS]) * unit, left * unit)
    return Nonadhesive(inner, replace(exact(inner), joint=joint), log_rates)


def _joint(solution: Solution, sevens: Array, rates: Array, left: Array) -> Array:
    """Covariance (n, 6, 6) of the columns and of the ``rates`` delta_H', S'' (2, n) at the middle of the ``sevens``, of
    which polynomials leave ``left``.

    A kernel errs smoothly: most of it is the compliance of one spring in series, which leaves P as it is and changes S
    by the relative error e, S' by 2 e, delta_H by e P/S and delta_H' by e delta_H' the other way, S'' as S'; and what
    errs of P is one stiffness that is too large, of S, S' and S'' too. A small share of what is stated goes its own
    way, more of it where rates are meant; and so does the profile's part.

    What is known better are ``companions``: each errs in a way of its own, rates included.
    """
    series, companions = solution.series, solution.companions
    at = sevens[:, MIDDLE]
    values = np.stack([getattr(series, name)[at] for name in ("delta", "P", "S", "dS")])
    stated = np.stack([series.errors[name][at] for name in ("delta", "P", "S", "dS")])
    shift, slope = solution.unresolved[:, at]
    delta, P, S, dS = values
    kernel = stated - shift * np.stack([np.ones_like(S), S, 0 * S, 0 * S])
    kernel = kernel if companions is None else companions.least * values
    by_spring = np.stack([-P / S, 0 * S, S, 2 * dS, -rates[0], 2 * (dS**2 / S + rates[1])]) * kernel[2] / S
    by_stiffness = np.stack([0 * S, P, S, dS, 0 * S, rates[1]]) * kernel[1] / P
    common = np.stack([by_spring, by_stiffness])
    if companions is not None:
        columns = np.stack([getattr(series, name) for name in ("delta", "P", "S", "dS")])
        changes = (companions(series.a) * columns)[:, :, sevens]
        changed_rates = _rates(changes[:, ::3])[0] / (series.a[at] - series.a0)
        common = np.concatenate([common, np.concatenate([changes[..., MIDDLE], changed_rates], axis=1)])
    unit = np.stack([delta, dS]) / (series.a[at] - series.a0)
    steep = np.maximum(np.abs(rates), unit)
    pair = kernel[::3]
    not_of = np.sqrt(np.maximum(pair**2 - by_spring[:4:3] ** 2, 0.0))  # one spring
    rough = np.maximum(not_of, np.array([[SOLVED_ROUGH], [SOLVED_BENT]]) * pair)
    of_rates = SOLVED_STEEPER * steep * rough / values[::3] + left + SOLVED_SCATTER / SOLVED_STEP * unit
    profile = np.stack([shift, S * shift, 0 * S, 0 * S, slope, 0 * S])
    covariance = np.sum(common[:, :, None] * common[:, None], axis=0)
    own = np.array(SOLVED_OWN)[:, None] * kernel
    if companions is None:  # by the quadrature of F, where S is known much better: no spring
        own[0] = np.maximum(own[0], not_of[0])
    own = np.hypot(own, SOLVED_SCATTER * values)  # rounding, which no two columns share
    covariance[np.arange(6), np.arange(6)] += np.concatenate([own, of_rates]) ** 2 + profile**2
    return np.moveaxis(covariance, -1, 0) / HALF_WIDTH**2


def _followed(problem: Problem, series: Series, seven: Array) -> tuple[Array, float]:
    """delta_H [m] at the rows ``seven`` without int sqrt(2 E*/S') F' da, up to a constant, and the integrand [-] at the
    middle one: whatever it is subtracted for, the sum is delta_H'."""
    assert series.dS is not None
    a, a0, indenter = series.a[seven], series.a0, problem.indenter
    log_dS = np.polynomial.Polynomial.fit(STEPS, np.log(series.dS[seven]), STEPS.size - 1)

    def rate(r: Array) -> Array:
        places = np.log((r - a0) / (a[MIDDLE] - a0)) / SOLVED_STEP
        return np.sqrt(2 * problem.E_star) * np.exp(-log_dS(places) / 2) * indenter.abel_slope(r)

    joints = [joint for joint in indenter.joints if a[0] < joint < a[-1]]
    nodes, weights = composite_gauss(np.union1d(a, joints))
    gained = np.sum(weights * rate(nodes.ravel()).reshape(nodes.shape), axis=1)
    through = np.concatenate([[0.0], np.cumsum(gained)])[np.searchsorted(np.union1d(a, joints), a)]
    return series.delta[seven] - through, float(rate(a[MIDDLE : MIDDLE + 1])[0])


def _rates(values: Array) -> tuple[Array, Array]:
    """Slopes (...) over log(a - a0) of ``values`` (..., 7) at ``STEPS``, and what the polynomials leave: their changes
    go on to fall, beside a singularity slower than they have done, and no faster than by the step."""
    sixth, quartic, parabola = np.einsum("...k,wk->w...", values, WEIGHTS) / SOLVED_STEP
    first = np.abs(quartic - parabola)
    second = np.maximum(np.abs(sixth - quartic), SOLVED_STEP**2 * first)
    fall = np.divide(second, first, out=np.ones_like(first), where=first > second)
    return sixth, second * np.maximum(SOLVED_SLOWER * fall, SOLVED_STEP)


def solved(curve: AdhesiveCurve, further: Further, *devices: float) -> AdhesiveCurve:
    """The ``curve`` through what is solved at its pull-off points, those by ``devices`` of a stiffness [N/m] included,
    until they lie there."""
    controls = {*CONTROLS.values(), *devices}

    def wanted(body: Nonadhesive) -> list[float]:
        trial = AdhesiveCurve(body, curve.w)
        trial.find_critical(controls)
        points = [point for k in controls if isinstance(point := trial.pull_off(k), CriticalPoint)]
        return [point.a for point in points if point.a < curve.series.rim]

    return AdhesiveCurve(refined(curve.nonadhesive, further, wanted), curve.w)


def solved_below(
    solution: Solution, works: Sequence[float], modulus_factor: float = 1.0, devices: Sequence[float] = ()
) -> Solution:  # fmt: skip
    """The ``solution`` with rows below its first one, down to the least radius at which contact is lost with the
    ``works`` of adhesion [J/m^2] under either control or by ``devices`` of a stiffness [N/m].

    As it is where that lies within it, or its method is not exact. Down to z0, with a flat end to its rim, where
    nothing is lost more.
    """
    method, series = method_behind(solution), solution.series
    if method is None or not METHODS[solution.method].exact or series.dS is None or len(series) < 2:
        return solution
    controls = [*CONTROLS.values(), *devices]

    def least(rows: Series) -> float:
        """The least radius [m] of pull-off; 0 where one lies below the ``rows``."""
        body, radii = Nonadhesive(rows, exact(rows)).scaled(modulus_factor), [math.inf]
        for curve, k in itertools.product([AdhesiveCurve(body, w) for w in works if w > 0], controls):
            point = curve.pull_off(k)
            if isinstance(point, CriticalPoint) and point.a > rows.a[0]:
                radii.append(point.a)
            elif curve.lowest_end(k) == "smallest":
                return 0.0
        return min(radii)

    first, a0 = float(np.sqrt((series.a[0] - series.a0) * (series.a[0] + series.a0))), series.a0
    floor = SOLVED_RIM * a0 if a0 else solution.record.z0
    # A stiff top alone loses contact at a^3 = pi w R^2/(8 E*) (JKR): below the rows, maybe, at a fold of its own
    R, E_star = solution.problem.indenter.tip_radius, modulus_factor * solution.problem.E_star
    own = [(math.pi * w * R**2 / (8 * E_star)) ** (1 / 3) for w in works if w > 0 and R]
    softer = series.S is not None and series.S[0] < 2 * solution.problem.E_star * series.a[0] * (1 - UNSEEN)
    another = softer and min(own, default=math.inf) < series.a[0]
    if first <= floor or (least(series) > 0 and not another):
        return solution
    steps = math.ceil(SOLVED_DECADE * math.log10(first / floor))
    below = np.hypot(a0, np.geomspace(floor, first, steps + 1)[:-1])
    try:
        rows = resolve_with(solution.problem, np.append(below, series.a), method, PATIENCE)
        lowest = least(rows.series)
        if lowest > series.a[0]:  # nothing is lost below
            return solution
        begin = np.searchsorted(below, lowest) - SOLVED_UNDER
        if begin > 0:
            below = below[begin:]
            rows = resolve_with(solution.problem, np.append(below, series.a), method, PATIENCE)
    except JkrError:
        return solution
    facts = {**solution.facts, "rows_below": below.size}
    return replace(solution, series=rows.series, budget=rows.budget, companions=rows.companions, facts=facts)


def refined(body: Nonadhesive, further: Further, wanted: Callable[[Nonadhesive], Sequence[float]]) -> Nonadhesive:
    """The functions of ``body`` through what is solved at the radii [m] that are ``wanted`` of them, until these lie
    there."""
    before = np.array([])
    for step in range(MOST_SOLVES):
        radii = np.unique(wanted(body))
        if all(is_solved_at(body, a) for a in radii):
            break
        apart = before[:0]
        if step > 1:
            # Those radii of the step before that lie apart from the new radii: where steps go to and fro, the
            # place lies between them
            steps = np.abs(np.log((before[:, None] - body.series.a0) / (radii - body.series.a0)))
            apart = before[np.min(steps, axis=1) > SOLVED_STEP]
        try:
            there = further(np.union1d(apart, radii))  # in place of what was solved further before
            trial = replace(body, further=there)
            trial.logs  # noqa: B018 - refuses points that do not fit in between the rows
        except JkrError:  # nor may body or profile allow it: what is interpolated stands, with its error
            break
        body, before = trial, radii
    return body


def is_solved_at(body: Nonadhesive, a: float) -> bool:
    """Whether ``body`` was solved at the radius ``a`` [m] itself."""
    further = body.further
    nearest = math.inf if further is None else float(np.min(np.abs(further.a - a)))
    return nearest <= SAME * (a - body.series.a0)


# --------------------------------------------------------------------------------------------------
# Contact pressure and surface shape at one state, solved again whatever method made the series.


def radius_under(solution: Solution, load: float, w: float, request: RangeRequest) -> float:
    """The contact radius [m] under a ``load`` [N] on the stable branch of the curve for ``w`` [J/m^2]."""
    curve = analyse(solution, [w], request=request)[0].curve
    point = curve.point(stable_radius(curve, load))
    if point.a == curve.series.rim:
        raise InputError(
            f"load: {show(load, 'load')} is carried by the full end, at whose edge G may be below w: --a "
            f"{show(point.a, 'length')} is the state in which it lets go"
        )
    return point.a


def profile_columns(solution: Solution, a: float, w: float, request: RangeRequest) -> dict[str, Array]:
    """Pressure inside, displacement and gap around a contact of radius ``a`` [m] on the body itself: by its kernel, or
    by finite elements (a wing) where the surfaces stick or the kernel of a cylinder does not give them."""
    problem = solution.problem
    refuse_no_disc(solution.facts, "profile")
    if problem.coatings:  # refused
        return _columns(problem, a, w)
    if request:
        law = request.law(w)
        body = FiniteRangeBody.of(solution).body
        _check_within(solution, a)
        reach = body.reach(a, 2 * law.stress / body.problem.E_star, law.length)
        attraction = body.ready(min(3 * reach, body.limit))
        r = _around(a, attraction.reach)
        surface = attracted_surface(attraction, a, law.stress, law.length, r, body.scale)
        return _of_surface(body.problem, r, surface)
    if problem.sticks:
        return _by_elements(solution, a, w)
    if problem.specimen.radius is None:
        return _columns(problem, a, w)
    _check_within(solution, a)
    # Whether the kernel of a cylinder gives the pressures at the radius a [m]; Refusal where nothing does
    reason = nonsmooth_part(problem.specimen)
    if reason is not None and problem.specimen.surface_tension:
        raise Refusal(reason)
    at_radius = replace(problem, loading=Loading.given("radius", (a,)))
    if reason is None and "hybrid" in METHODS and method_class("hybrid")().refusal(at_radius) is None:
        # Pressure, displacement and gap on a cylinder out to 3 a, or half-way to its side, where the kernel costs
        # little
        body = AttractedBody(problem, kept=solution.kernel)
        half_way = (a + problem.specimen.radius) / 2
        attraction = body.attraction(min(3 * a, half_way, body.limit))
        r = _around(a, attraction.reach)
        return _of_surface(problem, r, adhesive_surface(attraction, a, w, r, body.scale))
    return _by_elements(solution, a, w)


def _check_within(solution: Solution, a: float) -> None:
    if not 0 < a <= solution.series.a[-1] * (1 + ROUNDED):
        end = show(float(solution.series.a[-1]), "length")
        raise InputError(f"profile: the contact radius must lie between 0 and {end}, got {show(a, 'length')}")


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


def _by_elements(solution: Solution, a: float, w: float) -> dict[str, Array]:
    """The columns by finite elements; Refusal where that wing is not there."""
    if (columns := offered("the surface by finite elements")) is None:
        raise Refusal(f"profile: method fem, which alone gives it here, {absent('finite elements')}")
    found: dict[str, Array] = columns(solution, a, w)
    return found


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

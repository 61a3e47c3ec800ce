"""The work of adhesion that a measured pull-off force means, with its errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from ..adhesion.curve import CONTROLS, LOAD_CONTROL, AdhesiveCurve, Nonadhesive, control
from ..adhesion.finite_range import without_range
from ..adhesion.roughness import RoughContact, Roughness
from ..adhesion.validity import Strains
from ..adhesion.work_of_pull_off import FoundWork, Pull
from ..base.errors import AT_LEVEL, LEVEL, Estimate, InputError, Unknown, known
from ..base.numerics import HALF_WIDTH, evenly
from ..base.registry import Result
from ..base.units import parse, show
from ..bodies.problem import RADIUS, Loading, changed, checked_names, layer_names, nominal, relaxing
from ..cli import inputs, options
from ..methods.protocol import Limits
from ..report import tables
from ..report.forward import ByHistory, validity_lines
from ..report.result import Results
from ..resolve.analysis import Analysis, adhesive, method_behind, nonadhesive, solved_where
from ..resolve.sticking import effect_on, sticking_warnings
from ..series import Solution
from .parameters import changes_by, implausible_work, show_within

FORCE, TIP, MODULI = "load", "R", "E"  # uncertain inputs beside "h", "nu" and those of single layers
ELASTIC = Pull()
DIMENSIONS = {FORCE: "load", TIP: "length", MODULI: "modulus", "h": "length", "nu": "number"}


@dataclass(frozen=True, eq=False)
class MeasuredWork:
    """``work``: w and its pull-off; ``result``: the curve of that w, which says where the theory holds.

    ``series``: error of w [J/m^2] from that of the series; ``parts``: of w from those of the inputs, by name; all
    of them half-widths. ``strains``: what large ones change of the pull-off force.
    """

    work: FoundWork
    result: Analysis
    series: Estimate
    parts: Mapping[str, float]
    strains: Strains = None

    @property
    def large_strains(self) -> Strains:
        """Relative change of w that large strains may make, of the sign opposite to that of the pull-off force: w is
        as good as proportional to it."""
        if self.strains is None or isinstance(self.strains, Unknown):
            return self.strains
        low, high = self.strains
        return 1 / (1 + high) - 1, 1 / (1 + low) - 1

    @property
    def error(self) -> Estimate:
        """Half-width of w from all uncertain inputs [J/m^2]; the series' error without any."""
        return math.hypot(*self.parts.values()) if self.parts else self.series

    @property
    def series_words(self) -> str:
        """The error of the series, and what large strains change, in words."""
        series = self.series if isinstance(self.series, Unknown) else self.series / self.work.w
        return tables.error_words(series, self.large_strains)

    def summary(self) -> dict[str, Any]:
        """w and its errors [J/m^2], and where contact is lost with it."""
        data = {
            "w_J_per_m2": self.work.w,
            "w_err_J_per_m2": known(self.error),
            "w_err_by_input_J_per_m2": dict(self.parts),
            "w_err_of_series_J_per_m2": known(self.series),
            "pull_off": tables.point(self.work.point),
            **tables.strains(self.large_strains),
        }
        return data | ({"error": self.error.reason} if isinstance(self.error, Unknown) else {})

    def words(self, digits: int = 4) -> str:
        """w, with its half-width where inputs are uncertain."""
        if isinstance(self.error, Unknown) or not self.parts:
            return show(self.work.w, "work", digits)
        return show_within(self.work.w, self.error, "work", digits)


@dataclass(frozen=True, eq=False)
class _Inverse:
    """What a pull-off force means on one body: ``solution`` with its functions ``body``, control by ``stiffness``,
    where it lets go as a ``pull`` says."""

    solution: Solution
    body: Nonadhesive
    load: float
    stiffness: float
    pull: Pull

    def work(self) -> FoundWork:
        R = self.solution.problem.indenter.tip_radius
        return self.pull.work(self.body, self.load, self.stiffness, R)


def refuse_idle(
    load: float | None, uncertain: Collection[Any], stress: float | None, length: float | None,
    called: Callable[[str], str] = str,
) -> None:  # fmt: skip
    """InputError, options as they are ``called``, where one of a measured pull-off ``load`` [N] has no effect."""
    if load is None and uncertain:
        raise InputError(f"pull-off: {called('uncertain')} says how well a measured force and its body are known: give "
                         f"{called('load')} too")  # fmt: skip
    if load is not None and (stress, length) != (None, None):
        raise InputError(f"pull-off: {called('load')} asks for the w of JKR: give neither {called('stress')} nor "
                         f"{called('range')} with it")  # fmt: skip
    if load == 0:
        raise InputError(f"pull-off: {called('load')} must not be 0; give the measured pull-off force")


def measured_work(
    solution: Solution, load: float, stiffness: float, slopes: str = "auto", modulus_factor: float = 1.0,
    uncertain: Sequence[tuple[str, str]] = (), pull: Pull = ELASTIC,
) -> MeasuredWork:  # fmt: skip
    """The work of adhesion behind the pull-off force ``load`` [N, > 0] measured by a device of ``stiffness`` [N/m].

    ``uncertain``: standard deviations of inputs by name, as text (``uncertain_inputs``); ``pull``: how the
    specimen lets go. InputError names the file.
    """
    inputs = uncertain_inputs(solution, uncertain)
    try:
        unit = nonadhesive(solution, slopes)
        inverse = _Inverse(solution.scaled(modulus_factor), unit.scaled(modulus_factor), load, stiffness, pull)
        w = inverse.work().w
        result = adhesive(solution, unit, w, modulus_factor)
        controls = sorted({*CONTROLS.values(), stiffness})
        body = solved_where(inverse.solution, inverse.body, lambda body: pull.radii(body, w, controls))
        inverse = replace(inverse, body=body)
        work = inverse.work()
        result = replace(result, curve=AdhesiveCurve(inverse.body, work.w))
        held = unit.series.control_of_force(stiffness)
        at_point = pull.error(inverse.body, work.curve, work.point, held)
        by_load = _change(inverse, FORCE, 1e-3 * load) / (1e-3 * load)
        series = at_point if isinstance(at_point, Unknown) else at_point["P"] * abs(by_load)
        parts = {name: HALF_WIDTH * abs(_change(inverse, name, sigma)) for name, sigma in inputs.items()}
    except InputError as error:
        raise InputError([f"{solution.record.path}: {line}" for line in error.lines]) from None
    strains = None  # known of discs alone
    if result.shape is None:
        strains = pull.strains(result.problem, work.w, work.point, stiffness == LOAD_CONTROL)
    return MeasuredWork(work, result, series, parts, strains)


def uncertain_inputs(solution: Solution, pairs: Iterable[tuple[str, str]]) -> dict[str, float]:
    """Standard deviations [SI] of inputs by name, from absolute or relative text ("0.2 uN", "5%").

    "load": the measured force; "R": the tip radius; "E": all moduli in common; "h" and "nu": of the layer at the
    contact; "E:film", "h:film", "nu:film": of the layer of that name or number, "E:base": of the half-space.
    """
    # The names with their layers
    names, sigmas = layer_names(solution.problem.specimen), dict[str, float]()
    layers = names[: len(solution.problem.specimen.layers)]
    own = [f"{quantity}:{layer}" for quantity in ("E", "nu") for layer in names] + [f"h:{layer}" for layer in layers]
    radius = [TIP] if hasattr(solution.problem.indenter, "R") else []
    for name, text in pairs:
        whole = f"{name}:{names[0]}" if name in ("h", "nu") and names else name
        checked_names([whole], [FORCE, *radius, MODULI, *own], "pull-off")
        if whole in sigmas:
            raise InputError(f"pull-off: the uncertainty of {name} is given twice")
        relative = text.endswith("%")
        try:
            value = parse(text.removesuffix("%"), "number" if relative else DIMENSIONS[whole.partition(":")[0]])
        except ValueError as error:
            raise InputError(f"pull-off: --uncertain {name}: {error}") from None
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"pull-off: the uncertainty of {name} must be > 0, got {text}")
        sigmas[whole] = -value / 100 if relative else value  # relative ones wait for the value they belong to
    return sigmas


def seconds_of_inputs(solution: Solution, names: Sequence[str]) -> float:
    """CPU seconds of the bodies that are solved for uncertain inputs of these ``names``, one to either side."""
    method, solved = method_behind(solution), [name for name in names if name not in (FORCE, MODULI)]
    if method is None or not solved:
        return 0.0
    return 2 * len(solved) * method.forecast(replace(solution.problem, loading=_radii(solution))).seconds


def _radii(solution: Solution) -> Loading:
    """A hundred of the radii of the series, at which moved bodies are solved."""
    return Loading.given("radius", tuple(solution.series.a[evenly(len(solution.series), 100)].tolist()))


def _change(inverse: _Inverse, name: str, sigma: float) -> float:
    """Change of w [J/m^2] by a change of the input ``name`` by ``sigma``, from a step to either side; a negative
    ``sigma`` is relative."""
    problem = inverse.solution.problem
    if name == FORCE:
        centre = inverse.load
    elif name == TIP:
        centre = float(cast(Any, problem.indenter).R)
    else:
        centre = problem.E_star if name == MODULI else nominal(problem.specimen, name)
    size = -sigma * abs(centre) if sigma < 0 else sigma

    def outcome(value: float) -> dict[str, float]:
        return {"w": _moved(inverse, name, value).work().w}

    return changes_by(name, centre, size, {"w": inverse.work().w}, outcome)["w"]


def _moved(inverse: _Inverse, name: str, value: float) -> _Inverse:
    """The same with another ``value`` of one input: solved anew where that is no change of units."""
    solution = inverse.solution
    if name in (FORCE, MODULI) and value <= 0:
        raise InputError(f"{name}: must be > 0")
    if name == FORCE:
        return replace(inverse, load=value)
    if name == MODULI:
        return replace(inverse, body=inverse.body.scaled(value / solution.problem.E_star))
    method = method_behind(solution)
    if method is None:
        raise InputError(
            f"pull-off: {name} cannot be uncertain: the solution was not solved here, only its load and E can"
        )
    body = replace(solution.problem, loading=_radii(solution))
    again = method(changed(body, {RADIUS if name == TIP else name: value}))
    return replace(inverse, solution=again, body=nonadhesive(again))


def work_of_force(
    solution: Solution, after: ByHistory | None, load: float, stiffness: float, slopes: str, modulus_factor: float,
    uncertain: Sequence[tuple[str, str]] = (), roughness: Roughness | None = None,
) -> Result:  # fmt: skip
    """What a pull-off force ``load`` [N] by a device of ``stiffness`` [N/m] means, of a specimen that relaxes ``after``
    each history."""
    rough = None if roughness is None else roughness.on(solution.problem.scaled(modulus_factor))
    found = None if after is None else after.work(load, stiffness, slopes, modulus_factor, uncertain)
    if found is not None:
        return found
    return MeasuredPullOff(measured_work(solution, load, stiffness, slopes, modulus_factor, uncertain), rough)


# --------------------------------------------------------------------------------------------------
# What is said of it.

OF_INPUTS = "errors of load, tip and specimen not included: --uncertain load=5%, R=3%, E=10%"
SEARCHED = (0.05,) * 10  # works of adhesion [J/m^2] that are tried for that of a measured force; choice: for forecasts


def works_of_force(
    solutions: Sequence[Solution], by_history: Sequence[ByHistory | None], force: float, stiffnesses: Sequence[float],
    uncertain: Sequence[tuple[str, str]], how: options.CurveOptions, limits: Limits, roughness: Roughness | None = None,
) -> Results:  # fmt: skip
    """The work of adhesion that a measured ``force`` [N] means on each body, of one that relaxes
    ``by_history``, under each control."""
    controls, names = stiffnesses or (LOAD_CONTROL,), [name for name, _ in uncertain]
    for solution in solutions:
        without_range(solution.record, "pull-off: --load")
    seconds = len(controls) * sum(seconds_of_inputs(solution, names) for solution in solutions)
    tried = [SEARCHED * len(controls) * (1 + 2 * len(names))] * len(solutions)
    inputs.begin_curves("pull-off --load", solutions, tried, limits, beside=seconds)
    results, warnings = list[Result](), list[str]()
    for solution, after in zip(solutions, by_history, strict=True):
        settings = how.slopes, how.modulus_factor, uncertain, roughness
        measured = [work_of_force(solution, after, force, one, *settings) for one in controls]
        results += measured
        if not isinstance(measured[0], MeasuredPullOff):
            continue
        warnings += [f"{solution.record.path}: {text}" for text in relaxing(solution.problem.specimen.relaxation)]
        effect = effect_on(solution, [measured[0].means.work.w])
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        warnings += dict.fromkeys(text for one in measured for text in one.warnings)
    return Results(results, warnings)


@dataclass(frozen=True, eq=False)
class MeasuredPullOff(Result):
    """What a measured pull-off force means, between ``rough`` surfaces too."""

    means: MeasuredWork
    rough: RoughContact | None = None

    @property
    def warnings(self) -> list[str]:
        means = self.means
        doubt = implausible_work(means.work.w, means.result.problem.E_star)
        doubts = () if self.rough is None else self.rough.warnings(means.work.point.a)
        return [f"{means.result.path}: {text}" for text in (doubt, *doubts) if text]

    @property
    def _smooth(self) -> tuple[float, Estimate]:
        """w between smooth surfaces [J/m^2], at most, with its half-width."""
        assert self.rough is not None
        rough, error = self.rough, self.means.error
        w = rough.smooth(self.means.work.w)
        return w, error if isinstance(error, Unknown) else math.hypot(error, rough.error_at(w)) / rough.area

    def summary(self) -> dict[str, Any]:
        means, work, rough = self.means, self.means.work, dict[str, Any]()
        if self.rough is not None:
            w, error = self._smooth
            rough = {"w_smooth_J_per_m2": w, "w_smooth_err_J_per_m2": known(error), "w_smooth_bound": "upper",
                     "roughness": self.rough.summary()}  # fmt: skip
        return {
            "file": str(means.result.path),
            "level": LEVEL,
            "load_N": work.load,
            **tables.device(work.stiffness),
            **means.summary(),
            "w_half_space_J_per_m2": work.half_space,
            **tables.law(means.result),
            **rough,
            "validity": tables.validity(means.result, work.point),
        }

    def words(self) -> list[str]:
        means, work = self.means, self.means.work
        w = means.words(tables.digits(work.w, means.large_strains))
        lines = [
            f"w = {w}: the pull-off force {show(work.load, 'load')} of {means.result.path} "
            f"({control(work.stiffness)}, {tables.format_state(work.point, 'a')})"
        ]
        if means.parts:
            parts = (f"{name} {show(part, 'work')}" for name, part in means.parts.items())
            lines.append(f"  error at {AT_LEVEL} from {', '.join(parts)}")
        else:
            lines.append(f"  {OF_INPUTS}")
        lines.append(f"  {means.series_words}")
        if (shape := means.result.shape) is not None:
            lines.append(f"  {shape.words({control(work.stiffness): work.stiffness})}, w the other way (model)")
        if self.rough is not None:
            smooth, error = self._smooth
            shown = show(smooth, "work") if isinstance(error, Unknown) else show_within(smooth, error, "work", 4)
            lines.append(f"  w = {shown} between smooth surfaces, at most: full conformal contact is assumed")
            lines += [f"  {line}" for line in self.rough.words()]
        if work.half_space is not None:
            under = "" if work.stiffness == LOAD_CONTROL else " under load control"
            lines.append(
                f"  1.5 pi w R of a half-space{under} would have given {show(work.half_space, 'work')}, "
                f"{work.half_space / work.w:.3g} times that of this specimen"
            )
        return lines + validity_lines(means.result, work.point)

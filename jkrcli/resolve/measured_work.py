"""The work of adhesion that a measured pull-off force means, with its errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from ..adhesion.curve import CONTROLS, LOAD_CONTROL, AdhesiveCurve, Nonadhesive
from ..adhesion.from_rest import ELASTIC, FoundWork, LoadingHistory, Rest, history_error, work_from_pull_off
from ..adhesion.validity import Strains
from ..base.errors import Estimate, InputError, JkrError, Unknown
from ..base.numerics import HALF_WIDTH, evenly
from ..base.units import parse
from ..bodies.problem import RADIUS, Loading, changed, changes_by, checked_names, layer_names, nominal
from ..series import Solution
from .analysis import Analysis, adhesive, method_behind, nonadhesive
from .histories import checked_histories, solved_on, strains_after, with_history_solved

FORCE, TIP, MODULI = "load", "R", "E"  # uncertain inputs beside "h", "nu" and those of single layers
DIMENSIONS = {FORCE: "load", TIP: "length", MODULI: "modulus", "h": "length", "nu": "number"}


@dataclass(frozen=True, eq=False)
class MeasuredWork:
    """``work``: w and its pull-off after a ``history``; ``result``: the curve of that w, which says where the theory
    holds.

    ``series``: error of w [J/m^2] from that of the series; ``parts``: of w from those of the inputs, by name; all
    of them half-widths.
    """

    work: FoundWork
    result: Analysis
    series: Estimate
    parts: Mapping[str, float]
    history: LoadingHistory = ELASTIC

    @property
    def large_strains(self) -> Strains:
        """Relative change of w that large strains may make, of the sign opposite to that of the pull-off force: w is
        as good as proportional to it."""
        point, loaded = self.work.point, self.work.stiffness == LOAD_CONTROL
        change = strains_after(self.result.problem, self.work.w, self.history, point, loaded)
        if change is None or isinstance(change, Unknown):
            return change
        low, high = change
        return 1 / (1 + high) - 1, 1 / (1 + low) - 1

    @property
    def error(self) -> Estimate:
        """Half-width of w from all uncertain inputs [J/m^2]; the series' error without any."""
        return math.hypot(*self.parts.values()) if self.parts else self.series


@dataclass(frozen=True, eq=False)
class _Inverse:
    """What a pull-off force means on one body: ``solution`` with its functions ``body``, control by ``stiffness``,
    after a ``history``."""

    solution: Solution
    body: Nonadhesive
    load: float
    stiffness: float
    history: LoadingHistory

    def work(self) -> FoundWork:
        R = self.solution.problem.indenter.tip_radius
        return work_from_pull_off(self.body, self.load, self.stiffness, R, self.history)


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
    uncertain: Iterable[tuple[str, str]] = (), history: LoadingHistory = ELASTIC,
) -> MeasuredWork:  # fmt: skip
    """The work of adhesion behind the pull-off force ``load`` [N, > 0] measured by a device of ``stiffness`` [N/m].

    ``uncertain``: standard deviations of inputs by name, as text (``uncertain_inputs``); ``history``: of a viscoelastic
    specimen. InputError names the file.
    """
    inputs = uncertain_inputs(solution, uncertain)
    try:
        unit = nonadhesive(solution, slopes)
        inverse = _Inverse(solution.scaled(modulus_factor), unit.scaled(modulus_factor), load, stiffness, history)
        w = inverse.work().w
        result = adhesive(solution, unit, w, modulus_factor)
        controls = sorted({*CONTROLS.values(), stiffness})
        inverse = replace(inverse, body=with_history_solved(inverse.solution, inverse.body, history, w, controls))
        work = inverse.work()
        result = replace(result, curve=AdhesiveCurve(inverse.body, work.w))
        at_point = history_error(history, inverse.body, work.curve, work.point, stiffness)
        by_load = _change(inverse, FORCE, 1e-3 * load) / (1e-3 * load)
        series = at_point if isinstance(at_point, Unknown) else at_point["P"] * abs(by_load)
        parts = {name: HALF_WIDTH * abs(_change(inverse, name, sigma)) for name, sigma in inputs.items()}
    except InputError as error:
        raise InputError([f"{solution.record.path}: {line}" for line in error.lines]) from None
    return MeasuredWork(work, result, series, parts, history)


def works_by_history(
    solution: Solution, load: float, stiffness: float, rest: Rest | None = None, slopes: str = "auto",
    modulus_factor: float = 1.0, uncertain: Sequence[tuple[str, str]] = (),
) -> list[tuple[LoadingHistory, MeasuredWork | Unknown]] | Unknown | None:  # fmt: skip
    """Which w a pull-off force of a viscoelastic specimen means after each history that is solved, with that from
    ``rest``; None for an elastic one, Unknown where none is solved."""
    known = checked_histories(solution, rest)
    if known is None or isinstance(known, Unknown):
        return known

    def sought(there: Solution, history: LoadingHistory) -> MeasuredWork | Unknown:
        try:
            return measured_work(there, load, stiffness, slopes, modulus_factor, uncertain, history)
        except InputError as error:
            return Unknown(str(error).removeprefix(f"{solution.record.path}: "))

    def too_soon(history: LoadingHistory, unit: Nonadhesive) -> bool:
        try:
            w = work_from_pull_off(unit, load / modulus_factor, stiffness / modulus_factor, None, history).w
        except JkrError:
            return True
        return history.ends_too_soon(unit, w)

    def found(history: LoadingHistory) -> MeasuredWork | Unknown:
        first = sought(solution, history)
        if not isinstance(first, Unknown):
            return first
        unit = nonadhesive(solution, slopes)
        further, _ = solved_on(solution, unit, lambda body: not too_soon(history, body), slopes)
        return first if further is solution else sought(further, history)

    return [(history, found(history)) for history in known]


def uncertain_inputs(solution: Solution, pairs: Iterable[tuple[str, str]]) -> dict[str, float]:
    """Standard deviations [SI] of inputs by name, from absolute or relative text ("0.2 uN", "5%").

    "load": the measured force; "R": the tip radius; "E": all moduli in common; "h" and "nu": of the layer at the
    contact; "E:film", "h:film", "nu:film": of the layer of that name or number, "E:base": of the half-space.
    """
    sigmas = {}
    for name, text in pairs:
        whole = _whole(solution, name)
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


def _whole(solution: Solution, name: str) -> str:
    """The name with its layer; InputError where the body has no such input."""
    names = layer_names(solution.problem.specimen)
    whole = f"{name}:{names[0]}" if name in ("h", "nu") and names else name
    layers = names[: len(solution.problem.specimen.layers)]
    own = [f"{quantity}:{layer}" for quantity in ("E", "nu") for layer in names] + [f"h:{layer}" for layer in layers]
    radius = [TIP] if hasattr(solution.problem.indenter, "R") else []
    checked_names([whole], [FORCE, *radius, MODULI, *own], "pull-off")
    return whole


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
    moved = changed(solution.problem, {RADIUS if name == TIP else name: value})
    again = method(replace(moved, loading=_radii(solution)))
    return replace(inverse, solution=again, body=nonadhesive(again))

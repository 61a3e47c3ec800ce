"""How a specimen that relaxes lets go, by its loading history: the curves of ``from_rest``, solved as far as they reach
and at their pull-off points; pull-off, the w that a measured force means, and cycles as results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..adhesion.curve import (
    LOAD_CONTROL,
    AdhesiveCurve,
    CriticalPoint,
    EquilibriumCurve,
    Nonadhesive,
    control,
    mask_below_atomic_spacing,
)
from ..adhesion.pull_off_error import Errors
from ..adhesion.validity import Strains, strain_words
from ..base.errors import AT_LEVEL, LEVEL, InputError, JkrError, Refusal, Unknown, accuracy
from ..base.numerics import MOST_STEPS
from ..base.process import PATIENCE
from ..base.registry import Result
from ..base.units import show
from ..bodies.problem import Loading, relaxing
from ..report import tables
from ..report.forward import AskedCycle, Cycled, CycledByProgram, PullOff, point_words, validity_lines
from ..report.result import Several
from ..resolve.analysis import Analysis, Lost, analyse, forecast, method_behind, nonadhesive, solved_where
from ..resolve.reach import REACH_INSIDE
from ..resolve.resolve import resolve_with
from ..series import Solution
from .from_rest import AT_MOST, FROM_REST, FromRest, LoadingHistory, Rest, histories

if TYPE_CHECKING:
    from ..measured.pull_off import MeasuredWork

CURVES = 4  # theory: one for each history; choice: of a forecast
FURTHER = 1.5  # choice: the next series over the one that ends too soon; what is solved in vain grows with it


NEVER_AT_REST = Unknown(
    "the relaxed modulus is zero: no contact is in equilibrium, the pull-off force has no upper limit"
)


@dataclass(frozen=True, eq=False)
class LostByHistory:
    """Where contact is lost after one ``history``: its ``curve``, and under each control, by the stiffness of the
    device [N/m], the point with its half-widths. ``solved_to``: radius [m] to which the body was solved on for it."""

    history: LoadingHistory
    curve: AdhesiveCurve | FromRest | Unknown
    lost: Mapping[float, tuple[CriticalPoint | Unknown, Errors | Unknown | None]]
    solved_to: float | None = None


def known_histories(solution: Solution, rest: Rest | None) -> tuple[LoadingHistory, ...] | Unknown:
    """The histories of the viscoelastic specimen of ``solution`` with that from ``rest`` (default: at P = 0)."""
    law = solution.problem.specimen.relaxation
    assert law is not None
    return histories(law, rest or Rest())


def traced_histories(
    solution: Solution, rest: Rest | None, load: float | None = None, depth: float | None = None, rests: bool = True
) -> tuple[LoadingHistory, ...]:  # fmt: skip
    """The histories of a viscoelastic specimen that are traced: at rest at the turn, at a ``load`` [N] or ``depth``
    [m], where there is one, unless ``rest`` says otherwise; not from rest where the trace has no ``rests``."""
    known = known_histories(solution, rest or (Rest(load or 0.0) if depth is None else Rest(depth=depth)))
    if isinstance(known, Unknown):
        raise InputError(f"cycle: {known.reason}, or no adhesion, --w-approach 0")
    return tuple(one for one in known if one.name != AT_MOST and (rests or one.name != FROM_REST))


def lost_by_history(
    result: Analysis, controls: Sequence[float], rest: Rest | None = None, slopes: str = "auto"
) -> Sequence[LostByHistory] | Unknown:
    """Where the viscoelastic specimen of ``result`` loses contact after each history under ``controls`` by devices of a
    stiffness [N/m]."""
    known = known_histories(result.solution, rest)
    if isinstance(known, Unknown):
        return known
    if len(known) == 1:
        return NEVER_AT_REST
    if result.law is not None:
        return Unknown("these histories are solved for JKR's adhesion: leave --stress and --range out")
    if result.w == 0:
        return Unknown("there is no adhesion at w = 0")
    return [_lost(result, one, controls, slopes) for one in known]


def _lost(result: Analysis, history: LoadingHistory, controls: Sequence[float], slopes: str) -> LostByHistory:
    w, z0 = result.w, result.solution.record.z0
    unit = replace(result.jkr.nonadhesive, further=None)
    solution, unit = solved_on(result.solution, unit, lambda body: not history.ends_too_soon(body, w), slopes)
    unit = solved_where(solution, unit, lambda body: history.radii(body, w, controls))
    curve = history.curve(unit, w)
    lost: dict[float, tuple[CriticalPoint | Unknown, Errors | Unknown | None]] = {}
    for stiffness in controls:
        if isinstance(curve, Unknown):
            lost[stiffness] = curve, None
            continue
        point = mask_below_atomic_spacing(curve.pull_off(stiffness), curve, stiffness, z0)
        error = None if isinstance(point, Unknown) else history.error(unit, curve, point, stiffness)
        lost[stiffness] = point, error
    end = float(unit.a[-1])
    return LostByHistory(history, curve, lost, end if end > result.curve.series.a[-1] else None)


def curves_from_rest(
    solution: Solution, works: tuple[float, float], history: LoadingHistory, slopes: str, modulus_factor: float,
    stiffness: float,
) -> tuple[AdhesiveCurve, FromRest, Strains]:  # fmt: skip
    """The curve on which the contact grows while the specimen is relaxed, and the one after the rest of ``history``,
    for the ``works`` of adhesion [J/m^2] of approach and retraction, and what large strains change of the force at
    which a device of ``stiffness`` [N/m] pulls off; InputError where the contact does not rest."""
    assert history.rest is not None
    inwards, outwards = works
    solution, unit = solution.scaled(modulus_factor), nonadhesive(solution, slopes).scaled(modulus_factor)
    solution, unit = solved_on(solution, unit, lambda body: not history.ends_too_soon(body, inwards), slopes)
    unit = solved_where(solution, unit, lambda body: history.radii(body, outwards, [stiffness]))
    relaxed = history.relaxed(unit, inwards)
    state = history.rest.state(relaxed)
    if isinstance(state, Unknown):
        raise InputError(f"{solution.record.path}: {state.reason}")
    pulled = FromRest(AdhesiveCurve(history.body(unit), outwards), history.profile, state)
    lost = pulled.pull_off(stiffness)
    if isinstance(lost, Unknown):
        return relaxed, pulled, None
    return relaxed, pulled, history.strains(solution.problem, outwards, lost, stiffness == LOAD_CONTROL)


def solved_on(
    solution: Solution, unit: Nonadhesive, enough: Callable[[Nonadhesive], bool], slopes: str = "auto"
) -> tuple[Solution, Nonadhesive]:
    """The ``solution`` and its functions ``unit``, solved on to larger radii until they are ``enough``; as they are
    where its method does not go so far, or not soon."""
    method, there, body = method_behind(solution), solution, unit
    problem = solution.problem
    most = REACH_INSIDE * min(problem.indenter.r_max, problem.specimen.radius or problem.indenter.r_max)
    for _ in range(MOST_STEPS):
        end = min(FURTHER * float(body.a[-1]), most)
        if enough(body):
            return there, body
        if method is None or not end > body.a[-1]:
            break
        try:
            loading = Loading("radius", end, len(solution.series), "log")
            wider = resolve_with(replace(problem, loading=loading), None, method, PATIENCE)
            there = replace(wider, record=solution.record)
            body = nonadhesive(there, slopes)
        except (JkrError, Refusal):
            break
    return solution, unit


def no_depth(history: LoadingHistory) -> dict[str, Any]:
    """The displacement of the largest force of any history, which depends on it."""
    return {"delta_m": None, "delta_err_m": None} if history.name == AT_MOST else {}


def history_summary(history: LoadingHistory, curve: EquilibriumCurve | Unknown) -> dict[str, Any]:
    """A history, its share of the moduli and of the profile, and the state at rest."""
    rest = {"rest": tables.point(curve.rest)} if isinstance(curve, FromRest) else {}
    shares = {"moduli": history.moduli, "profile": history.profile}
    return {"history": history.name, "words": history.words, **shares, **rest}


# --------------------------------------------------------------------------------------------------
# Where contact is lost, in words and as JSON.


@dataclass(frozen=True, eq=False)
class PullOffByHistory(PullOff):
    """What is read off the curve of very fast cycles under each control, beside where contact is lost after each of the
    ``histories``; Unknown where none is solved."""

    histories: Sequence[LostByHistory] | Unknown

    def summary(self) -> dict[str, Any]:
        if isinstance(self.histories, Unknown):
            return super().summary() | {"histories": None, "histories_reason": self.histories.reason}
        rows = [
            history_summary(one.history, one.curve)
            | {"controls": [
                tables.device(k) | {"pull_off": tables.point(point) | tables.errors(error) | no_depth(one.history)}
                for k, (point, error) in one.lost.items()
            ]}
            for one in self.histories
        ]  # fmt: skip
        return super().summary() | {"histories": rows}

    @property
    def warnings(self) -> list[str]:
        """What the moduli mean where no history is solved, and doubts of the roughness."""
        law = self.result.problem.specimen.relaxation
        texts = relaxing(law) if isinstance(self.histories, Unknown) else ()
        return [*(f"{self.result.path}: {text}" for text in texts), *super().warnings]

    @property
    def verdict(self) -> list[str]:
        if not isinstance(self.histories, Unknown):
            return _verdict(self.result, self.histories)
        first, *others = super().verdict
        return [first, f"  after other histories: none: {self.histories}", *others]

    @property
    def under_controls(self) -> list[str]:
        told = [] if isinstance(self.histories, Unknown) else [f"  {self.histories[0].history.words}:"]
        return told + super().under_controls


def _verdict(result: Analysis, found: Sequence[LostByHistory]) -> list[str]:
    """The verdict on a viscoelastic specimen by its history, and what is lost after each under every control."""
    controls = list(found[0].lost)
    forces = []
    for one in found:
        point, name = one.lost[controls[0]][0], one.history.name
        if isinstance(point, CriticalPoint):
            force = show(-point.P, "load")
            forces.append(f"at most {force}" if name == AT_MOST else f"{force} ({name})")
    lines = [
        f"pull-off force {', '.join(forces) or 'not in the series'} at w = {show(result.w, 'work')}, "
        f"{control(controls[0])}: {result.path}"
    ]
    errors = []
    for one in found:
        further = "" if one.solved_to is None else f"; solved on to a = {show(one.solved_to, 'length')}"
        words = one.history.words + ": at most" * (one.history.name == AT_MOST)
        rest = f" (there {tables.format_state(one.curve.rest)})" if isinstance(one.curve, FromRest) else ""
        lines.append(f"  {words}{rest}{further}")
        for k, (point, error) in one.lost.items():
            # The largest force of any history, whose displacement depends on it.
            shown = (
                point_words(point)
                if one.history.name != AT_MOST or isinstance(point, Unknown)
                else (f"P = {show(point.P, 'load'):<12} {'':<20} a = {show(point.a, 'length')}")
            )
            lines.append(f"    {control(k):<21} {shown}")
            if isinstance(point, CriticalPoint) and error is not None:
                errors.append(error if isinstance(error, Unknown) else error["P"] / abs(point.P))
    changes = []
    for one in found:
        point = one.lost[controls[0]][0]
        if isinstance(point, CriticalPoint):
            change = one.history.strains(result.problem, result.w, point, controls[0] == LOAD_CONTROL)
            changes += [f"{strain_words(change)} ({one.history.name})"] if change else []
    lines += [f"  model: {'; '.join(changes)}"] if changes else []
    unknown = [error for error in errors if isinstance(error, Unknown)]
    worst = unknown[0] if unknown else max((error for error in errors if isinstance(error, float)), default=0.0)
    told = isinstance(worst, Unknown) or worst >= tables.PRINTED
    return lines + ([f"  pull-off: {accuracy(worst)} ({AT_LEVEL} confidence)"] if told else [])


# --------------------------------------------------------------------------------------------------
# The work of adhesion that a measured pull-off force means.


@dataclass(frozen=True, eq=False)
class MeasuredByHistory(Result):
    """What a measured pull-off force of a viscoelastic specimen means after each history."""

    load: float
    stiffness: float
    result: Analysis
    found: Sequence[tuple[LoadingHistory, MeasuredWork | Unknown]]

    @classmethod
    def of(
        cls, solution: Solution, load: float, stiffness: float,
        found: Sequence[tuple[LoadingHistory, MeasuredWork | Unknown]], slopes: str, modulus_factor: float,
    ) -> MeasuredByHistory:  # fmt: skip
        """What was ``found`` of the pull-off force ``load`` [N] by a device of ``stiffness`` [N/m]; where the theory
        holds is judged with the largest w."""
        works = [one.work.w for _, one in found if not isinstance(one, Unknown)]
        if not works:
            raise InputError([f"{solution.record.path}: {history.words}: {one}" for history, one in found])
        return cls(load, stiffness, analyse(solution, [max(works)], slopes, modulus_factor)[0], found)

    @property
    def _works(self) -> dict[str, float]:
        """w [J/m^2] by the name of the history, of those that have one."""
        return {history.name: one.work.w for history, one in self.found if not isinstance(one, Unknown)}

    @property
    def range(self) -> tuple[float | None, float | None]:
        """The least and the largest w [J/m^2] of these histories; the least only where it is that of any history."""
        works = self._works
        return works.get(AT_MOST), max(works.values(), default=None)

    def summary(self) -> dict[str, Any]:
        rows = []
        for history, one in self.found:
            row = history_summary(history, Unknown("") if isinstance(one, Unknown) else one.work.curve)
            if isinstance(one, Unknown):
                row |= {"w_J_per_m2": None, "reason": one.reason}
            else:
                measured = one.summary()
                row |= measured | {"pull_off": measured["pull_off"] | no_depth(history)}
            rows.append(row)
        return {
            "file": str(self.result.path),
            "level": LEVEL,
            "load_N": self.load,
            **tables.device(self.stiffness),
            "w_J_per_m2": self._works.get(FROM_REST),
            "w_range_J_per_m2": list(self.range),
            "histories": rows,
            "validity": tables.validity(self.result),
        }

    def words(self) -> list[str]:
        from ..measured.pull_off import OF_INPUTS

        low, high = (None if w is None else show(w, "work") for w in self.range)
        span = low if low == high else f"at least {low}" if high is None else f"{low or 'unknown'} to {high}"
        lines = [
            f"w = {span}, by the history of the specimen: the pull-off force {show(self.load, 'load')} of "
            f"{self.result.path} ({control(self.stiffness)})"
        ]
        for history, one in self.found:
            words = history.words + ": at least" * (history.name == AT_MOST)
            if isinstance(one, Unknown):
                lines.append(f"  {words}: none: {one}")
                continue
            state = tables.format_state(one.work.point, "a")
            lines.append(f"  {words}: w = {one.words()}, {state}; {one.series_words}")
        if not any(one.parts for _, one in self.found if not isinstance(one, Unknown)):
            lines.append(f"  {OF_INPUTS}")
        return lines + validity_lines(self.result)


# --------------------------------------------------------------------------------------------------
# Cycles after each history.


@dataclass(frozen=True, eq=False)
class CycledInLimits(Several):
    """The cycles of a viscoelastic specimen with adhesion after each history that is known, by its name."""

    file: Path
    limits: Mapping[str, tuple[LoadingHistory, Result]]

    @classmethod
    def of(cls, file: Path, known: Sequence[LoadingHistory], cycles: Iterable[Result]) -> CycledInLimits:
        """The ``cycles`` after each history that is ``known``."""
        return cls(file, {one.name: (one, cycle) for one, cycle in zip(known, cycles, strict=True)})

    def summary(self) -> dict[str, Any]:
        limits = {
            name: {"history": one.words, "moduli": one.moduli, "profile": one.profile} | result.summary()
            for name, (one, result) in self.limits.items()
        }
        return {"file": str(self.file), "limits": limits}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        found = list[Sequence[str]]()
        for one, result in self.limits.values():
            first, *rest = result.words()
            doubt = strain_words(getattr(result, "large_strains", None))  # of several results first lines are seen
            found.append([f"{one.words}: {first}{f'; {doubt} (model)' if doubt else ''}", *rest])
        return found

    @property
    def warnings(self) -> list[str]:
        return list(dict.fromkeys(line for _, result in self.limits.values() for line in result.warnings))


def cycle_after(asked: AskedCycle, history: LoadingHistory) -> Cycled | CycledByProgram:
    """The cycle that is ``asked`` for, at the moduli after a loading ``history``; at once from where it rested."""
    if history.rest is None:
        traced = replace(asked, modulus_factor=asked.modulus_factor * history.moduli).quasi_static()
        return replace(traced, remark=history.words) if isinstance(traced, Cycled) else traced
    file, k = asked.solution.record.path, asked.stiffness
    relaxed, pulled, change = curves_from_rest(
        asked.solution, asked.works, history, asked.slopes, asked.modulus_factor, k
    )
    try:
        traced = Cycled.on(file, relaxed, pulled, k, pulled.rest.a, asked.points)
    except InputError as error:
        raise InputError([line if line.startswith(str(file)) else f"{file}: {line}" for line in error.lines]) from None
    return replace(traced, remark=history.words, large_strains=change)


# --------------------------------------------------------------------------------------------------
# What is offered to whoever asks how a specimen that relaxes lets go.


@dataclass(frozen=True)
class ByHistory:
    """What is known of the viscoelastic specimen of ``solution``: the ``ByHistory`` of ``report/forward.py``."""

    solution: Solution
    rest: Rest | None = None

    def seconds(self, works: Sequence[float], devices: int) -> float:
        return CURVES * forecast(self.solution, works, devices=devices).seconds

    def pull_off(
        self, result: Analysis, lost: Sequence[Lost], controls: Sequence[float], slopes: str
    ) -> PullOffByHistory:
        return PullOffByHistory(result, lost, lost_by_history(result, controls, self.rest, slopes))

    def cycle(self, asked: AskedCycle) -> CycledInLimits:
        rests = asked.program is None and not asked.ranged
        known = traced_histories(self.solution, self.rest, asked.to_load, asked.to_depth, rests)
        return CycledInLimits.of(self.solution.record.path, known, (cycle_after(asked, one) for one in known))

    def work(
        self, load: float, stiffness: float, slopes: str, modulus_factor: float, uncertain: Sequence[tuple[str, str]]
    ) -> MeasuredByHistory | None:
        from ..measured.pull_off import measured_work

        solution, known = self.solution, known_histories(self.solution, self.rest)
        if isinstance(known, Unknown):
            return None

        def sought(there: Solution, history: LoadingHistory) -> MeasuredWork | Unknown:
            try:
                return measured_work(there, load, stiffness, slopes, modulus_factor, uncertain, history)
            except InputError as error:
                return Unknown(str(error).removeprefix(f"{solution.record.path}: "))

        def enough(history: LoadingHistory, unit: Nonadhesive) -> bool:
            try:
                w = history.work(unit, load / modulus_factor, stiffness / modulus_factor).w
            except JkrError:
                return False
            return not history.ends_too_soon(unit, w)

        def found(history: LoadingHistory) -> MeasuredWork | Unknown:
            first = sought(solution, history)
            if not isinstance(first, Unknown):
                return first
            unit = nonadhesive(solution, slopes)
            further, _ = solved_on(solution, unit, lambda body: enough(history, body), slopes)
            return first if further is solution else sought(further, history)

        works = [(history, found(history)) for history in known]
        return MeasuredByHistory.of(solution, load, stiffness, works, slopes, modulus_factor)


def by_history(solution: Solution, load: float | None, depth: float | None, called: Callable[[str], str]) -> ByHistory:
    """What is known of the specimen of ``solution``, at rest under a ``load`` [N] or at a ``depth`` [m], which are
    ``called`` so; InputError where it is elastic."""
    rest = Rest.of(load, depth, called)
    if solution.problem.specimen.relaxation is None:
        raise InputError(
            f"{solution.record.path}: its specimen is elastic, so that nothing relaxes at rest: leave --rest-load and "
            "--rest-depth out, or give specimen.relaxation"
        )
    return ByHistory(solution, rest)

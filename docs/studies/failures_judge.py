"""Where each method is right, where it says that it is not, and where it errs silently: one verdict per cell.

A result is compared with the exact solution of the same layers, made in other units (layer thickness and modulus 1), so
that a change of units is tested too. Right: within the stated error at every point. Said so: refused, warned, or the
error stated as unknown. Silently wrong, and any exception but the program's own, is a bug.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from jkrcli.adhesion.curve import AdhesiveCurve, CriticalPoint, transform
from jkrcli.adhesion.slopes import Slopes, slopes, smoothed
from jkrcli.adhesion.validity import unresolved
from jkrcli.base.errors import LEVEL, JkrError, Unknown
from jkrcli.base.executors import Pool, completed
from jkrcli.base.numerics import Array
from jkrcli.bodies.problem import Loading, Problem
from jkrcli.formulas import shift
from jkrcli.methods.layered.solver import Layered, surface_profile
from jkrcli.methods.protocol import METHODS, Method, method_class
from jkrcli.series import RawSeries, Series, Solution, first_of_plateaus

from .failures_cells import Cell, draw
from .noise_cells import noisy
from .watchdog import TooSlowError, cpu_limit

RIGHT, SAID, REFUSED, SILENT, CRASHED = "right", "said", "refused", "silent", "crashed"
UNJUDGED, TOO_SLOW = "unjudged", "too slow"
OUTCOMES = (RIGHT, SAID, REFUSED, UNJUDGED, TOO_SLOW, SILENT, CRASHED)
BUGS = (SILENT, CRASHED)
SHARES = {"closed-form": 3, "layered": 6, "hybrid": 2, "fem": 2, "slopes": 6}  # of the cells
WITHIN = {"closed-form": 1.0, "layered": 1.0}  # of the stated error, which is a bound

# What counts as right, where it is looked at, and how long that may take.
JUDGE_ESTIMATED = 2.0  # choice: of the stated error, where that is an estimate
JUDGE_BANDS = 2.5  # theory: half-widths of a 95 % band that are five standard deviations
JUDGE_OF_THE_CURVE = LEVEL  # theory: of its points, what a band promises, whatever its errors have in common
JUDGE_TOLERANCES = (1e-10, 1e-8, 1e-6)  # choice: of the exact solution, the first that is reached
JUDGE_PULLS = 0.01  # choice: of the mean pressure; what pulls less is not told apart
JUDGE_PATIENCE = 20.0  # choice: CPU seconds that a solve may be forecast to take
JUDGE_LIMIT = 60.0  # choice: CPU seconds that a cell may take
JUDGE_JUDGED = 0.01  # choice: of the largest depth; rows below are not judged, as in the error budget
JUDGE_ROWS = 15  # choice: rows of a series that are compared


@dataclass(frozen=True)
class Verdict:
    """The outcome of a cell; ``words``: the message or what is wrong; ``error``, ``stated``: the worst row's."""

    cell: Cell
    outcome: str
    words: str = ""
    error: float | None = None
    stated: float | None = None


@dataclass(frozen=True)
class Off:
    """Relative ``error`` of a quantity and the ``stated`` one, of the row where their ratio is worst."""

    quantity: str
    error: float
    stated: float


def random_cells(count: int, seed: int, methods: Sequence[str] = ()) -> list[Cell]:
    """Random cells of ``methods`` (none: of all), shared out by ``SHARES``."""
    rng = np.random.default_rng(seed)
    names = [name for name in SHARES if (name in METHODS or name == "slopes") and (not methods or name in methods)]
    weights = np.array([SHARES[name] for name in names], dtype=float)
    return [draw(rng, str(rng.choice(names, p=weights / weights.sum()))) for _ in range(count)]


def failures(cells: Sequence[Cell], pool: Pool, tell: Callable[[Verdict, int], None] | None = None) -> list[Verdict]:
    """Judge the cells, in their order; a cell whose process dies counts as a crash. ``tell``: called with each verdict
    and how many there are, as they come."""
    found: dict[int, Verdict] = {}
    for index, verdict in completed(pool, judge, cells, "failures", chunk=4):
        found[index] = verdict if isinstance(verdict, Verdict) else Verdict(cells[index], CRASHED, str(verdict))
        if tell is not None:
            tell(found[index], len(found))
    return [found[index] for index in range(len(cells))]


def judge(cell: Cell) -> Verdict:
    """The verdict on one cell."""
    try:
        with cpu_limit(JUDGE_LIMIT):
            return _judge_slopes(cell) if cell.method == "slopes" else _judge_solve(cell)
    except TooSlowError:
        return Verdict(cell, TOO_SLOW, f"took more than {JUDGE_LIMIT:g} CPU s")
    except JkrError as error:
        return Verdict(cell, REFUSED, "; ".join(str(error).splitlines()))
    except Exception as error:  # any other exception is a bug, and is what is looked for
        return Verdict(cell, CRASHED, f"{type(error).__name__}: {error}")


def method_of(cell: Cell) -> Method:
    """The method of a cell, its options from the cell."""
    cls = method_class(cell.method)
    if cell.method != "fem":
        return cls()
    smallest = 0.3 if cell.nodes < 10 else 0.05
    spacing = min(max((1 - math.log(smallest)) / cell.nodes, 0.01), 0.49)
    return cls(spacing=spacing, smallest=smallest, contact="incremental" if cell.increments else "nested")


def _judge_solve(cell: Cell) -> Verdict:
    problem, method = cell.problem, method_of(cell)
    if cell.increments and cell.method == "fem":
        problem = replace(problem, loading=replace(problem.loading, points=cell.increments, spacing="depth"))
    if reason := method.refusal(problem):
        return Verdict(cell, REFUSED, reason)
    seconds = method.forecast(problem).seconds
    if seconds > JUDGE_PATIENCE:
        return Verdict(cell, UNJUDGED, f"would take {seconds:.0f} s")
    solution = method(problem)
    if not solution.series.errors:
        return Verdict(cell, SAID, f"error unknown: {solution.budget.series}")
    try:
        return _compared(cell, solution)
    except JkrError as error:
        return Verdict(cell, UNJUDGED, f"no exact solution: {error}")


def _compared(cell: Cell, solution: Solution) -> Verdict:
    """The verdict on a solution with stated errors: the columns first, then the conditions of contact."""
    found = _distances(cell, solution.series)
    verdict = _verdict(cell, found, WITHIN.get(cell.method, JUDGE_ESTIMATED), solution.warnings)
    if verdict.outcome == RIGHT and (broken := _not_a_disc(cell)):
        outcome = SAID if solution.warnings else SILENT
        return Verdict(cell, outcome, "; ".join(solution.warnings) or broken, verdict.error, verdict.stated)
    return verdict


def _not_a_disc(cell: Cell) -> str | None:
    """Why the contact is no disc without adhesion: the exact pressure pulls at the largest radius; None: it is one."""
    plain = replace(cell, length_unit=1.0, force_unit=1.0)
    found = surface_profile(plain.problem, cell.a_over_h, 0.0, cell.a_over_h * np.linspace(0.05, 0.9, 10), np.array([]))
    pull = float(found.pressure.min()) * np.pi * found.a**2 / found.P
    return f"the contact pulls with {-pull:.2g} of its mean pressure" if pull < -JUDGE_PULLS else None


def _verdict(cell: Cell, found: Sequence[Off], factor: float, warnings: Sequence[str]) -> Verdict:
    worst = max(found, key=lambda off: off.error / max(off.stated, 1e-300))
    if all(off.error <= factor * off.stated for off in found):
        return Verdict(cell, RIGHT, "", worst.error, worst.stated)
    words = f"{worst.quantity} errs by {worst.error:.2g}, stated {worst.stated:.2g}"
    if warnings:
        return Verdict(cell, SAID, "; ".join(warnings), worst.error, worst.stated)
    return Verdict(cell, SILENT, words, worst.error, worst.stated)


def _exact(cell: Cell, loading: Loading) -> tuple[Series, float]:
    """The exact solution for a ``loading`` in units of the cell, back in SI, and its tolerance."""
    plain = replace(cell, length_unit=1.0, force_unit=1.0)
    problem = Problem(plain.problem.indenter, plain.problem.specimen, loading)
    for tolerance in JUDGE_TOLERANCES:
        try:
            series = Layered(tolerance)(problem).series
            break
        except JkrError as error:
            reason = error
    else:
        raise reason
    length, force = cell.length_unit, cell.force_unit
    assert series.S is not None
    assert series.dS is not None
    return Series(
        series.a * length, series.delta * length, series.P * force, series.S * force / length,
        series.dS * force / length**2, a0=series.a0 * length,
        S0=None if series.S0 is None else series.S0 * force / length,
    ), tolerance  # fmt: skip


def _distances(cell: Cell, series: Series) -> list[Off]:
    """How far the columns lie from the exact ones, each with its stated error; empty where none is stated."""
    judged = np.flatnonzero(series.delta >= JUDGE_JUDGED * series.delta[-1])
    rows = judged[np.unique(np.linspace(0, judged.size - 1, JUDGE_ROWS).round().astype(int))]
    names: tuple[str, ...]
    if not np.any(series.errors.get("a", 0.0)):
        exact, tolerance = _exact(cell, Loading.given("radius", tuple(series.a[rows] / cell.length_unit)))
        names = ("delta", "P", "S", "dS")
    else:  # radii are less sure than displacements: errors of loads are stated at given depth
        exact, tolerance = _exact(cell, Loading.given("depth", tuple(series.delta[rows] / cell.length_unit)))
        names = ("a", "P")
    return [_off(name, series, exact, rows, tolerance) for name in names if name in series.errors]


def _off(name: str, series: Series, exact: Series, rows: Array, tolerance: float) -> Off:
    truth = getattr(exact, name)
    error = np.abs(getattr(series, name)[rows] / truth - 1)
    stated = series.errors[name][rows] / np.abs(truth) + tolerance  # both are known that well only
    worst = int(np.argmax(error / stated))
    return Off(name, float(error[worst]), float(stated[worst]))


def _judge_slopes(cell: Cell) -> Verdict:
    """The adhesive curve of a noisy series with the slopes that "auto" finds, and its pull-off force, against exact."""
    dense = Loading("radius", cell.a_over_h, 200)
    try:
        exact, _ = _exact(cell, dense)
        given, _ = _exact(cell, replace(dense, points=cell.points))
    except JkrError as reason:
        return Verdict(cell, UNJUDGED, f"no exact solution: {reason}")
    w = _work(exact)
    exact_curve = transform(exact, slopes(exact, "exact"), w)
    truth = exact_curve.pull_off(0.0)
    if not isinstance(truth, CriticalPoint):
        return Verdict(cell, UNJUDGED, truth.reason)
    raw = noisy(given, cell.noise, cell.seed)
    series, found = _fitted(raw, given)
    curve = transform(series, found, w)
    point = curve.pull_off(0.0)
    if not isinstance(point, CriticalPoint):
        return Verdict(cell, SAID, point.reason)
    error = abs(point.P / truth.P - 1)
    stated = _stated(curve, point)
    if stated is None:
        return Verdict(cell, SAID, f"error unknown: {found.error}", error)
    flags = found.flags + unresolved(cell.problem.indenter, given.a)
    return _verdict(cell, [Off("pull-off", error, stated), _band(curve, exact_curve, truth)], JUDGE_BANDS, flags)


def _band(curve: AdhesiveCurve, exact: AdhesiveCurve, unit: CriticalPoint) -> Off:
    """The error of P in pull-off forces, and the stated one, where a tenth of the points lie further from theirs."""
    common = (curve.a >= exact.a[0]) & (curve.a <= exact.a[-1])
    error = np.abs(curve.P[common] - exact.at(curve.a[common])[1]) / abs(unit.P)
    assert not isinstance(curve.interpolation_error, Unknown)
    stated = curve.errors["P"][common] / abs(unit.P) + curve.interpolation_error + exact.interpolation_error
    order = np.argsort(error / stated)
    i = order[int(JUDGE_OF_THE_CURVE * (order.size - 1))]
    return Off("the curve", float(error[i]), float(stated[i]))


def _work(exact: Series) -> float:
    """A work of adhesion [J/m^2] whose pull-off lies well within the series: there dP/da = 0 in its middle."""
    middle = len(exact) // 2
    assert exact.S is not None
    assert exact.dS is not None
    rate = np.gradient(exact.P, exact.a)[middle]
    adhesive = exact.S * shift(1.0, exact.a, exact.dS)
    return float((rate / np.gradient(adhesive, exact.a)[middle]) ** 2)


def _fitted(raw: RawSeries, given: Series) -> tuple[Series, Slopes]:
    """Series and slopes as ``jkr transform`` finds them: of a series as it stands, else of increments by "integral"."""
    ordered = first_of_plateaus(raw.a).all() and all((np.diff(column) > 0).all() for column in (raw.delta, raw.P))
    if not ordered:
        return smoothed(raw, given.a0, given.S0)
    series = Series(raw.a, raw.delta, raw.P, a0=given.a0, S0=given.S0)
    return series, slopes(series, "auto")


def _stated(curve: AdhesiveCurve, point: CriticalPoint) -> float | None:
    """Relative error of the pull-off force that the curve states: its band and its interpolation; None: unknown."""
    if not curve.errors or isinstance(curve.interpolation_error, Unknown):
        return None
    band = float(curve.error_at(np.array(point.a))["P"]) / abs(point.P)
    return band + curve.interpolation_error


def counts(verdicts: Sequence[Verdict]) -> Mapping[str, Mapping[str, int]]:
    """How many of each outcome, by method."""
    methods = dict.fromkeys(verdict.cell.method for verdict in verdicts)
    return {
        method: {
            outcome: sum(v.cell.method == method and v.outcome == outcome for v in verdicts) for outcome in OUTCOMES
        }
        for method in methods
    }

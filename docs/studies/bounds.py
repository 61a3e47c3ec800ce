"""Whether stated errors bound the true ones and are near them: random bodies, each by one of the methods."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from jkrcli.adhesion.curve import CONTROLS, CriticalPoint, mask_below_atomic_spacing
from jkrcli.adhesion.pull_off_error import Errors
from jkrcli.base.errors import JkrError, Unknown
from jkrcli.base.executors import completed
from jkrcli.base.files import as_json
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Side, Spacing, Specimen
from jkrcli.formulas import shift
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import method_class
from jkrcli.resolve.analysis import analyse, error_of_point, with_solved_points
from jkrcli.series import Series, Solution

from .command import Main, call, output_of, parser_of, pool_of
from .range_judge import BESIDE, NODES, REFINED, SMALL, Judged, ranged, stationary, without_table, work_within

METHODS = ("layered", "hybrid", "fem")
ACCURACIES = (1e-11, 1e-10, 1e-9)  # of the exact solution, the first that is reached
PATIENCE = 1.0  # CPU seconds that a solve may be forecast to take
ROWS = 6  # of a series that are compared
SIDES: tuple[Side, ...] = ("free", "roller", "clamped")
FEW, FAR = 0.01, 10.0  # of the quantities, that may lie beyond; of stated over true errors, the median at most
# of the largest radius, pull-off under load: meshes are alike in it, what one errs by passes zero at the same places
PLACES = (0.1, 0.9)
RANGED = 0.3  # of the bodies, that get adhesion of finite range too


@dataclass(frozen=True)
class Bound:
    """One quantity of one body, a column at its worst row or what is read off the curve; ``ratio``: true over stated
    error there; ``clear``: whether the true error is above 1e-8 and three times what the reference may err by."""

    number: int
    method: str
    column: str
    ratio: float
    stated: float
    clear: bool = True


Judge: TypeAlias = Callable[[int], tuple[Bound, ...]]  # the quantities of a body by its number, none where refused


def main(words: Sequence[str] | None = None) -> int:
    """Solve random bodies, moduli a million apart, -0.95 < nu <= 1/2, spheres to a/R = 1, cylinders to a/L = 0.97, from
    nm to m, each by one method, and compare every column, and the pull-off points, with the exact solution (of
    cylinders, with one of method hybrid refined). Contacts that are no full disc, which none of these knows, are left
    out.

    Series of 10 to 40 rows, even in radius, its logarithm or depth; tables of 3 to 100 points against the shape behind
    them; flat ends; on some bodies adhesion of finite range. Every printed quantity counts for itself.

    Writes bounds.csv and .json: for each quantity of each body the worst ratio of true to stated error. The exit code
    is 1 where more than 1 % lie beyond the stated error, any beyond three times it, or the median of stated over true
    errors is above ten for a quantity and method (true errors above 1e-8 and three times the reference's own).
    """
    return study(words, main, judged, "bounds", 500)


def study(words: Sequence[str] | None, main: Main, judge: Judge, name: str, bodies: int) -> int:
    """Carry out the study of a ``main``, which says what it does: ``judge`` random ``bodies`` by their numbers, write
    ``name``.csv and .json; 1 where the stated errors do not hold."""
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--bodies", type=int, default=bodies, help=f"how many [default: {bodies}]")
    parser.add_argument("--seed", type=int, default=1, help="of the first body [default: 1]")
    given = parser.parse_args(words)
    files = output_of(given).files(given.output / name, (".csv", ".json"))
    numbers = [given.seed * 1_000_000 + i for i in range(given.bodies)]
    with pool_of(given, given.bodies) as pool:
        judgements = completed(pool, judge, numbers, name.replace("-", " "), chunk=4)
        found = [bound for _, bounds in judgements if isinstance(bounds, tuple) for bound in bounds]
    found.sort(key=lambda item: (item.number, item.column))
    told = summary(found, given.bodies, given.seed) | {"format": f"jkr-{name}"}
    files.write({name: [vars(item)[name] for item in found] for name in Bound.__annotations__}, told)
    print(as_json(told), end="")
    return int(not told["held"])


def summary(found: Sequence[Bound], bodies: int, seed: int) -> dict[str, Any]:
    """How many quantities of how many bodies were compared, how many lie beyond what was stated, and how large that is,
    by method and by quantity."""
    told: dict[str, Any] = {"format": "jkr-bounds", "version": 2, "seed": seed, "bodies": bodies}
    told["solved"] = len({item.number for item in found})
    held = True
    for method in METHODS:
        ours = [item for item in found if item.method == method]
        told[method] = {name: _counts([item for item in ours if item.column == name]) for name in _names(ours)}
        held &= all((counts["stated_over_true"] or 0) <= FAR for counts in told[method].values())
    told["all"] = everything = _counts(found)
    few = everything["beyond"] <= FEW * len(found) and everything["beyond_three_times"] == 0
    return told | {"held": bool(few and held)}


def _names(found: Sequence[Bound]) -> list[str]:
    return sorted({item.column for item in found})


def _counts(found: Sequence[Bound]) -> dict[str, Any]:
    ratios = np.array([item.ratio for item in found])
    large = [item.ratio for item in found if item.clear and item.ratio > 0]
    return {
        "compared": len(found),
        "beyond": int(np.sum(ratios > 1)),
        "beyond_three_times": int(np.sum(ratios > 3)),
        "stated_over_true": float(1 / np.median(large)) if large else None,
        "worst": [vars(item) for item in sorted(found, key=lambda item: -item.ratio)[:5]],
    }


def judged(number: int, place: float | None = None) -> tuple[Bound, ...]:
    """Every quantity of the body ``number`` by its method; none where it is refused, or too costly. ``place``: of the
    largest radius, pull-off under load, where it is not to be drawn; 0: the row in the middle."""
    rng = np.random.default_rng(number)
    method = METHODS[number % len(METHODS)]
    problem = body(rng, cylinders=method != "layered")
    solver = method_class(method)()
    try:
        if solver.refusal(problem) or solver.forecast(problem).seconds > PATIENCE:
            return ()
        solution = solver(problem)
        if not solution.series.errors or solution.facts.get("contact") == "incremental":
            return ()
        found = (
            _columns(solution)
            + _points(solution, float(rng.uniform(*PLACES)) if place is None else place or None)
            + _ranged(solution, rng)
        )
    except JkrError:
        return ()
    return tuple(Bound(number, method, *item) for item in found)


def body(rng: np.random.Generator, cylinders: bool = False) -> Problem:
    """A random body and indenter; on rigid bases half of them are ``cylinders`` where these are asked for."""
    count, length = int(rng.integers(1, 4)), 10 ** rng.uniform(-8, -1)
    span, E = float(rng.choice([1, 3, 6])), 10 ** rng.uniform(2, 11)
    materials = [Elastic(E * 10 ** (span * rng.uniform(-0.5, 0.5)), _poisson(rng)) for _ in range(count + 1)]
    layers = tuple(Layer(material, length * 10 ** rng.uniform(-0.7, 0.7)) for material in materials[:count])
    base = (Rigid(), Rigid(bonded=False), HalfSpace(materials[count]))[int(rng.integers(3))]
    a = layers[0].thickness * 10 ** rng.uniform(-1.3, 1.0)
    specimen = Specimen(layers, base)
    if cylinders and isinstance(base, Rigid) and rng.random() < 0.5:
        side = SIDES[int(rng.integers(len(SIDES)))]
        specimen = Specimen(layers, base, a / (0.97 * 10 ** rng.uniform(-0.7, 0)), side)
    indenter = _indenter(rng, a)
    spacing: Spacing = ("radius", "log", "depth")[int(rng.integers(3))]
    if indenter.a0 > 0:  # rows of a flat end begin at it
        a = indenter.a0 + float(rng.uniform(0.3, 1.0)) * a
        specimen = specimen if specimen.radius is None else replace(specimen, radius=specimen.radius * 2)
    return Problem(indenter, specimen, Loading("radius", a, int(rng.integers(10, 41)), spacing))


def _poisson(rng: np.random.Generator) -> float:
    kind = rng.random()
    if kind < 0.12:
        return 0.5
    if kind < 0.3:
        return float(0.5 - 10 ** rng.uniform(-6, -1))
    return float(rng.uniform(-0.95, 0.5) if kind < 0.6 else rng.uniform(0, 0.5))


def _indenter(rng: np.random.Generator, a: float) -> Indenter:
    """A sphere, paraboloid, power law or flat end with the slope 0.01 to 1 at the radius ``a`` [m], or the table of one
    at 3 to 100 radii up to 1.1 times that."""
    steep, kind = 10 ** rng.uniform(-2, 0), int(rng.integers(6))
    if kind == 3:
        return RoundedFlat(a * 10 ** rng.uniform(-1, 0.5), a / steep)
    d = rng.uniform(1.0, 6.0)
    shape: Indenter = Sphere(1.1 * a / steep) if kind in (0, 4) else Paraboloid(a / steep)
    shape = PowerLaw(steep * a ** (1 - d) / d, d) if kind in (2, 5) else shape
    return Sampled.of(shape, 1.1 * a * min(1.0, 1 / (1.1 * steep)), int(rng.integers(3, 101))) if kind > 3 else shape


@dataclass(frozen=True)
class Sampled(TableProfile):
    """The table of a ``shape``, which the reference knows."""

    shape: Indenter | None = None

    @classmethod
    def of(cls, shape: Indenter, end: float, count: int) -> Sampled:
        r = np.linspace(0, end, count)
        return cls(tuple(r.tolist()), tuple(np.asarray(shape.f(r)).tolist()), shape=shape)


@dataclass(frozen=True, eq=False)
class Reference:
    """The exact solution, its relative ``accuracy``, and what it states of its own columns at equal radius, where that
    is less: relative errors, row by row."""

    series: Series
    accuracy: float

    def unsure(self, name: str) -> Array:
        """Relative errors of the column ``name``."""
        stated = self.series.errors[name] / np.abs(getattr(self.series, name))
        return np.minimum(stated, self.accuracy)


def exact_at(problem: Problem, loading: Loading) -> Reference:
    wide = problem.specimen.radius is None
    problem = without_table(problem)
    for accuracy in ACCURACIES if wide else REFINED:
        method = Layered(accuracy) if wide else Hybrid(accuracy)
        try:
            return Reference(method(replace(problem, loading=loading)).series, accuracy)
        except JkrError as error:
            reason = error
    raise reason


def _columns(solution: Solution) -> list[Judged]:
    """Each column with its worst ratio of true to stated error, and the stated one there, relative; and the budget's
    total against the largest true error of all at equal depth, or radius where that is exact."""
    series = solution.series
    rows = np.flatnonzero(series.delta >= 0.01 * series.delta[-1])
    rows = rows[np.unique(np.linspace(0, rows.size - 1, ROWS).round().astype(int))]
    at_depth = bool(np.any(series.errors.get("a", 0.0)))
    found = []
    exact = exact_at(solution.problem, Loading.given("radius", tuple(series.a[rows].tolist())))
    errors = {**series.errors, **series.errors_at_radius}
    for name in ("delta", "P", "S", "dS"):
        if name in errors:
            found.append(_ratio(f"{name} at equal a", series, exact, name, errors[name], rows, exact.unsure(name)))
    if at_depth:
        exact = exact_at(solution.problem, Loading.given("depth", tuple(series.delta[rows].tolist())))
        found += [
            _ratio(f"{name} at equal delta", series, exact, name, series.errors[name], rows, exact.accuracy)
            for name in ("a", "P")
        ]
    alike = found[-2:] if at_depth else found
    worst, total = max((largest for _, largest in alike), default=0.0), solution.budget.total
    judged = [column for column, _ in found]
    if isinstance(total, float) and total > 0:
        judged.append(("total", worst / total, total, worst > max(SMALL, 3 * exact.accuracy)))
    return judged


def _ratio(
    words: str, series: Series, exact: Reference, name: str, errors: Any, rows: Any, unsure: Array | float
) -> tuple[Judged, float]:
    """A column by its worst row, and its largest true error, relative."""
    truth = getattr(exact.series, name)
    off = np.abs(getattr(series, name)[rows] / truth - 1)
    error, stated = np.maximum(off - unsure, 0.0), errors[rows] / np.abs(truth)
    worst = int(np.argmax(error / stated))
    clear = off[worst] > max(SMALL, 3 * float(np.max(unsure)))
    return (words, float(error[worst] / stated[worst]), float(stated[worst]), bool(clear)), float(error.max())


def _points(solution: Solution, place: float | None) -> list[Judged]:
    """P and delta of the pull-off points under load, displacement and a spring, for the work of adhesion that brings
    load control to this ``place``: against the stationary state of polynomials through nine exact radii."""
    series = solution.series
    if series.S is None or series.dS is None:
        return []
    spring = float(series.S[len(series) // 2])
    first = analyse(solution, [work_within(series, place)])[0]
    result, found = with_solved_points(first, spring), []
    for control, stiffness in {**CONTROLS, "spring": spring}.items():
        point = mask_below_atomic_spacing(result.curve.pull_off(stiffness), result.curve, stiffness, 0.0)
        if isinstance(point, CriticalPoint):
            stated = error_of_point(result.curve, point, stiffness)
            if not isinstance(stated, Unknown):
                found += _against(solution, result.w, control, stiffness, point, stated)
    return found


def _against(
    solution: Solution, w: float, control: str, stiffness: float, point: CriticalPoint, stated: Errors
) -> list[Judged]:
    """The ``stated`` errors of a pull-off ``point`` against what exact radii around it say."""
    beyond = point.a - solution.series.a0
    x = BESIDE * np.cos(np.pi * np.arange(NODES) / (NODES - 1))[::-1]
    radii = solution.series.a0 + beyond * (1 + x)
    reference = exact_at(solution.problem, Loading.given("radius", tuple(radii.tolist())))
    values, unsure = {}, {}
    for name in ("delta", "P"):
        values[name], by = _adhesive(reference, name, w)
        unsure[name] = float(by.max())
    return stationary(control, stiffness, x, values, unsure, point, stated)


def _ranged(solution: Solution, rng: np.random.Generator) -> list[Judged]:
    """P and delta of adhesion of a random finite range, on some of the bodies."""
    series = solution.series
    if solution.method == "fem" or rng.random() > RANGED or series.S is None or series.dS is None:
        return []
    try:
        return ranged(solution.problem, without_table(solution.problem), series, rng)
    except JkrError:
        return []


def _adhesive(exact: Reference, held: str, w: float) -> tuple[Array, Array]:
    """P [N] or delta [m] with the work of adhesion ``w`` at the radii of the ``exact`` solution, and how unsure."""
    series, by_slope = exact.series, exact.unsure("dS") / 2
    t = shift(w, series.a, np.asarray(series.dS))
    if held == "delta":
        return series.delta - t, np.abs(series.delta) * exact.unsure("delta") + t * by_slope
    pulled = np.asarray(series.S) * t
    return series.P - pulled, np.abs(series.P) * exact.unsure("P") + pulled * (exact.unsure("S") + by_slope)


if __name__ == "__main__":
    sys.exit(call(main))

"""Whether stated errors bound the true ones and are near them: random bodies, each by one of the methods."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jkrcli.adhesion.analysis import analyse
from jkrcli.adhesion.curve import CriticalPoint
from jkrcli.adhesion.device import CONTROLS
from jkrcli.base.arrays import Array
from jkrcli.base.errors import JkrError
from jkrcli.base.executors import completed
from jkrcli.base.table import as_json
from jkrcli.base.unknown import Unknown
from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, Sphere
from jkrcli.bodies.materials import Elastic
from jkrcli.bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Side, Specimen
from jkrcli.formulas.griffith import shift
from jkrcli.methods import method_class
from jkrcli.methods.hybrid.method import Hybrid
from jkrcli.methods.layered.layered import Layered
from jkrcli.series import Series, Solution

from .command import call, output_of, parser_of, pool_of

METHODS = ("layered", "hybrid", "fem")
ACCURACIES = (1e-11, 1e-10, 1e-9)  # of the exact solution, the first that is reached
REFINED = (1e-7, 1e-6)  # tolerance of the method hybrid, which is the reference of cylinders
PATIENCE = 6.0  # CPU seconds that a solve may be forecast to take
ROWS = 6  # of a series that are compared
SIDES: tuple[Side, ...] = ("free", "roller", "clamped")
SMALL = 1e-9  # a stated error that need not be near the true one


@dataclass(frozen=True)
class Bound:
    """One body: the worst of its columns and rows; ``ratio``: true over stated error there."""

    number: int
    method: str
    column: str
    ratio: float
    stated: float


def main(words: Sequence[str] | None = None) -> int:
    """Solve random bodies, moduli a million apart, -0.95 < nu <= 1/2, spheres to a/R = 1, cylinders to a/L = 0.97, from
    nm to m, each by one method, and compare every column, and the pull-off points, with the exact solution (of
    cylinders, with one of method hybrid refined). Contacts that are no full disc, which none of these knows, are left
    out.

    Writes bounds.csv and .json: for each body the worst ratio of true to stated error. The exit code is 1 where more
    than 12 in 500 lie beyond the stated error, any beyond three times it, or stated errors are ten times too large.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--bodies", type=int, default=500, help="how many [default: 500]")
    parser.add_argument("--seed", type=int, default=1, help="of the first body [default: 1]")
    given = parser.parse_args(words)
    files = output_of(given).files(given.output / "bounds", (".csv", ".json"))
    numbers = [given.seed * 1_000_000 + i for i in range(given.bodies)]
    with pool_of(given, given.bodies) as pool:
        found = [item for _, item in completed(pool, judged, numbers, "bounds", chunk=4) if isinstance(item, Bound)]
    found.sort(key=lambda item: item.number)
    told = summary(found, given.bodies, given.seed)
    files.write({name: [vars(item)[name] for item in found] for name in Bound.__annotations__}, told)
    print(as_json(told), end="")
    return int(not told["held"])


def summary(found: Sequence[Bound], bodies: int, seed: int) -> dict[str, Any]:
    """How many of the bodies were compared, how many lie beyond what was stated, and how large that is, by method."""
    told: dict[str, Any] = {"format": "jkr-bounds", "version": 1, "seed": seed, "bodies": bodies}
    told |= {method: _counts([item for item in found if item.method == method]) for method in METHODS}
    told["all"] = everything = _counts(found)
    few = everything["beyond"] <= 12 / 500 * len(found) and everything["beyond_three_times"] == 0
    near = everything["stated_over_true"] is None or everything["stated_over_true"] <= 10
    return told | {"held": bool(few and near)}


def _counts(found: Sequence[Bound]) -> dict[str, Any]:
    ratios = np.array([item.ratio for item in found])
    large = [item.ratio for item in found if item.stated > SMALL and item.ratio > 0]
    return {
        "compared": len(found),
        "beyond": int(np.sum(ratios > 1)),
        "beyond_three_times": int(np.sum(ratios > 3)),
        "stated_over_true": float(1 / np.median(large)) if large else None,
        "worst": [vars(item) for item in sorted(found, key=lambda item: -item.ratio)[:5]],
    }


def judged(number: int) -> Bound | None:
    """The worst column of the body ``number`` by its method; None where it is refused, or too costly."""
    rng = np.random.default_rng(number)
    method = METHODS[number % len(METHODS)]
    problem = body(rng, cylinders=method != "layered")
    solver = method_class(method)()
    try:
        if solver.refusal(problem) or solver.forecast(problem).seconds > PATIENCE:
            return None
        solution = solver(problem)
        if not solution.series.errors or solution.facts.get("contact") == "incremental":
            return None
        ratios = _columns(solution) + _points(solution)
    except JkrError:
        return None
    column, ratio, stated = max(ratios, key=lambda item: item[1])
    return Bound(number, method, column, ratio, stated)


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
    return Problem(_indenter(rng, a), specimen, Loading("radius", a, 40))


def _poisson(rng: np.random.Generator) -> float:
    kind = rng.random()
    if kind < 0.12:
        return 0.5
    if kind < 0.3:
        return float(0.5 - 10 ** rng.uniform(-6, -1))
    return float(rng.uniform(-0.95, 0.5) if kind < 0.6 else rng.uniform(0, 0.5))


def _indenter(rng: np.random.Generator, a: float) -> Indenter:
    """A sphere, paraboloid or power law with the slope 0.01 to 1 at the radius ``a`` [m]."""
    steep, kind = 10 ** rng.uniform(-2, 0), int(rng.integers(3))
    if kind == 2:
        d = rng.uniform(1.0, 6.0)
        return PowerLaw(steep * a ** (1 - d) / d, d)
    return Sphere(a / steep) if kind == 0 else Paraboloid(a / steep)


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


def _exact(problem: Problem, loading: Loading) -> Reference:
    wide = problem.specimen.radius is None
    for accuracy in ACCURACIES if wide else REFINED:
        method = Layered(accuracy) if wide else Hybrid(accuracy)
        try:
            return Reference(method(replace(problem, loading=loading)).series, accuracy)
        except JkrError as error:
            reason = error
    raise reason


def _columns(solution: Solution) -> list[tuple[str, float, float]]:
    """Each column with its worst ratio of true to stated error, and the stated one there, relative."""
    series = solution.series
    rows = np.flatnonzero(series.delta >= 0.01 * series.delta[-1])
    rows = rows[np.unique(np.linspace(0, rows.size - 1, ROWS).round().astype(int))]
    at_depth = bool(np.any(series.errors.get("a", 0.0)))
    found = []
    exact = _exact(solution.problem, Loading.given("radius", tuple(series.a[rows].tolist())))
    errors = {**series.errors, **series.errors_at_radius}
    for name in ("delta", "P", "S", "dS"):
        if name in errors:
            found.append(_ratio(f"{name} at equal a", series, exact, name, errors[name], rows, exact.unsure(name)))
    if at_depth:
        exact = _exact(solution.problem, Loading.given("depth", tuple(series.delta[rows].tolist())))
        found += [
            _ratio(f"{name} at equal delta", series, exact, name, series.errors[name], rows, exact.accuracy)
            for name in ("a", "P")
        ]
    return found


def _ratio(
    words: str, series: Series, exact: Reference, name: str, errors: Any, rows: Any, unsure: Array | float
) -> tuple[str, float, float]:
    truth = getattr(exact.series, name)
    error = np.maximum(np.abs(getattr(series, name)[rows] / truth - 1) - unsure, 0.0)
    stated = errors[rows] / np.abs(truth)
    worst = int(np.argmax(error / stated))
    return words, float(error[worst] / stated[worst]), float(stated[worst])


def _points(solution: Solution) -> list[tuple[str, float, float]]:
    """The held quantity of both pull-off points, for a work of adhesion that brings them within the series: against the
    stationary value of a polynomial through nine exact radii."""
    series, middle = solution.series, len(solution.series) // 2
    if series.S is None or series.dS is None:
        return []
    rate = np.gradient(series.P, series.a) / np.gradient(series.S * shift(1.0, series.a, series.dS), series.a)
    result = analyse(solution, [float(rate[middle] ** 2)])[0]
    found = []
    for control, point in result.pull_off.items():
        stated = result.pull_off_errors.get(control)
        if not isinstance(point, CriticalPoint) or stated is None or isinstance(stated, Unknown):
            continue
        x = 0.02 * np.cos(np.pi * np.arange(9) / 8)[::-1]
        reference = _exact(solution.problem, Loading.given("radius", tuple((point.a * (1 + x)).tolist())))
        held = "P" if CONTROLS[control] == 0 else "delta"
        values, unsure = _adhesive(reference, held, result.w)
        fit = np.polynomial.Chebyshev.fit(x, values, 8)
        roots = np.real(fit.deriv().roots())
        truth, said = float(fit(roots[np.argmin(np.abs(roots))])), getattr(point, held)
        error = max(abs(said - truth) - float(unsure.max()), 0.0)
        found.append((f"pull-off {held}", error / stated[held], stated[held] / abs(truth)))
    return found


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

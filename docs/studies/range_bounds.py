"""Whether stated errors of adhesion of finite range bound the true ones: random bodies, against doubled quadrature."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jkrcli.adhesion.curve import CriticalPoint
from jkrcli.adhesion.device import LOAD_CONTROL
from jkrcli.adhesion.finite_range import FiniteRangeBody, FiniteRangeCurve
from jkrcli.adhesion.law import Range
from jkrcli.base.errors import JkrError
from jkrcli.base.executors import completed
from jkrcli.base.table import as_json
from jkrcli.bodies.problem import Problem
from jkrcli.formulas.griffith import shift
from jkrcli.methods.attraction import AttractedBody
from jkrcli.methods.integral.attraction import Attraction
from jkrcli.methods.integral.quadrature import Panels, Quadrature
from jkrcli.methods.layered.layered import Layered, unbounded
from jkrcli.methods.layered.stack import LayeredContact
from jkrcli.series import Series

from .bounds import body as random_body
from .bounds import kinked
from .command import call, output_of, parser_of, pool_of

NARROWEST, WIDEST = 1e-3, 10.0  # of the annulus over the contact radius at pull-off, by JKR
ROUNDING = 1e-13  # of the doubled quadrature itself, relative
ACCURACY, NODES_IN_K = 1e-12, 48  # of the panels that are halved; twice those of the main solution
BEYOND = 1.15  # of c, to which the kernel is known
NODES = 9  # of the polynomial through exact states around pull-off
BESIDE = 0.02  # of its contact radius, how far they lie from it


@dataclass(frozen=True)
class RangeBound:
    """One body: the worst of delta, P and the pull-off force; ``ratio``: true over stated error there, ``stated``:
    relative; ``annulus``: its width over the contact radius."""

    number: int
    column: str
    ratio: float
    stated: float
    annulus: float


def main(words: Sequence[str] | None = None) -> int:
    """Solve random bodies with adhesion of a random finite range and compare displacements, loads and pull-off forces
    with a quadrature of panels half as wide and twice as many nodes in k.

    Writes range-bounds.csv and .json: for each body the worst ratio of true to stated error. The exit code is 1 where
    more than 4 in 200 lie beyond the stated error.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("--bodies", type=int, default=200, help="how many [default: 200]")
    parser.add_argument("--seed", type=int, default=1, help="of the first body [default: 1]")
    given = parser.parse_args(words)
    files = output_of(given).files(given.output / "range-bounds", (".csv", ".json"))
    numbers = [given.seed * 1_000_000 + i for i in range(given.bodies)]
    with pool_of(given, given.bodies) as pool:
        results = completed(pool, judged, numbers, "range bounds", chunk=4)
        found = sorted((item for _, item in results if isinstance(item, RangeBound)), key=lambda item: item.number)
    told = summary(found, given.bodies, given.seed)
    files.write({name: [vars(item)[name] for item in found] for name in RangeBound.__annotations__}, told)
    print(as_json(told), end="")
    return int(not told["held"])


def summary(found: Sequence[RangeBound], bodies: int, seed: int) -> dict[str, Any]:
    """How many of the bodies were compared, and how many lie beyond what was stated."""
    ratios = np.array([item.ratio for item in found])
    beyond = int(np.sum(ratios > 1))
    return {
        "format": "jkr-range-bounds",
        "version": 1,
        "seed": seed,
        "bodies": bodies,
        "compared": len(found),
        "beyond": beyond,
        "stated_over_true": float(1 / np.median(ratios[ratios > 0])) if (ratios > 0).any() else None,
        "worst": [vars(item) for item in sorted(found, key=lambda item: -item.ratio)[:5]],
        "held": beyond <= 4 / 200 * len(found),
    }


def judged(number: int) -> RangeBound | None:
    """The body ``number`` with adhesion that pulls it off at the middle of its radii; None where it is refused."""
    rng = np.random.default_rng(number)
    problem = random_body(rng)
    try:
        series = Layered()(problem).series
        w = _work(series)
        width = 10 ** rng.uniform(math.log10(NARROWEST), math.log10(WIDEST)) * series.a[len(series) // 2]
        law = Range.of(w, stress=math.sqrt(math.pi * problem.E_star * w / (4 * width)))
        curve = FiniteRangeBody(problem, series, AttractedBody(problem)).curve(law)
        doubled = _doubled(problem, curve)
    except JkrError:
        return None
    column, ratio, stated = max([*_columns(curve, doubled), *_pull_off(curve, doubled)], key=lambda item: item[1])
    middle = curve.touching.a.size // 2
    return RangeBound(number, column, ratio, stated, float(curve.touching.c[middle] / curve.touching.a[middle] - 1))


def _work(series: Series) -> float:
    """The w whose JKR pull-off under load control lies at the middle radius."""
    assert series.S is not None
    assert series.dS is not None
    rate = np.gradient(series.P, series.a) / np.gradient(series.S * shift(1.0, series.a, series.dS), series.a)
    return float(rate[len(series) // 2] ** 2)


def _doubled(problem: Problem, curve: FiniteRangeCurve) -> Attraction:
    """The body on panels half as wide, with twice the nodes in k."""
    wide = unbounded(problem)
    contact = LayeredContact(wide.indenter, wide.specimen)
    reach = min(BEYOND * float(curve.touching.c[-1]), AttractedBody(problem).limit)
    panels = contact.attraction(reach, ACCURACY).basis.panels
    half = Quadrature(panels.order, float(np.diff(panels.edges).max()) / 2, 0)
    finer = Panels.through(np.array([reach]), half, contact.indenter.a0)
    return Attraction.of(contact.indenter, contact.E_star, finer, contact.matrix(finer, NODES_IN_K))


def _columns(curve: FiniteRangeCurve, doubled: Attraction) -> list[tuple[str, float, float]]:
    """delta and P at every point, apart and in contact: name, worst ratio, stated relative error there."""
    s, gap = 2 * curve.law.stress / curve.problem.E_star, curve.law.length
    held = doubled.discs(curve.touching.a).equilibria(s, gap, doubled.reach, curve.touching.c)
    free = doubled.apart(curve.apart.c[1:], s, gap) if curve.complete else None
    found = []
    for name in ("delta", "P"):
        begin = [] if free is None else [getattr(curve.apart, name)[:1], getattr(free, name)]
        exact = np.concatenate([*begin, getattr(held, name)])
        off, stated = np.abs(getattr(curve, name) - exact), curve.errors[name]
        off = np.maximum(off - ROUNDING * np.abs(exact).max(), 0)
        ratio = np.divide(off, stated, out=np.zeros_like(off), where=off > 0)
        worst = int(np.argmax(ratio))
        found.append((name, float(ratio[worst]), float(stated[worst] / np.abs(exact).max())))
    return found


def _pull_off(curve: FiniteRangeCurve, doubled: Attraction) -> list[tuple[str, float, float]]:
    """The pull-off force against the least of a polynomial through exact loads around it."""
    point = curve.pull_off(LOAD_CONTROL)
    if not isinstance(point, CriticalPoint) or point.a == 0 or kinked(curve, point, 2 * BESIDE):
        return []
    s, gap = 2 * curve.law.stress / curve.problem.E_star, curve.law.length
    x = np.cos(np.pi * np.arange(NODES) / (NODES - 1))[::-1]
    a = point.a * (1 + BESIDE * x)
    loads = doubled.discs(a).equilibria(s, gap, doubled.reach, np.full(NODES, point.c)).P
    fit = np.polynomial.Chebyshev.fit(x, loads, NODES - 1)
    roots = np.real(fit.deriv().roots())
    truth = float(fit(roots[np.argmin(np.abs(roots))]))
    stated = curve.point_error(point, LOAD_CONTROL)["P"]
    off = max(abs(point.P - truth) - 10 * ROUNDING * float(np.abs(loads).max()), 0.0)
    return [("pull-off P", off / stated, stated / abs(truth))]


if __name__ == "__main__":
    sys.exit(call(main))

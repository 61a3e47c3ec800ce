"""The study of tuned numbers: error and time of reference bodies with each of them halved, as shipped, and doubled.

Every algorithm keeps its numbers as constants of its module; those whose comment says "tuned" are varied here, one at
a time.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import gc
import importlib
import inspect
import pkgutil
import re
import sys
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

import jkrcli
from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import SolveError, Unknown
from jkrcli.base.executors import Pool, completed
from jkrcli.base.wings import wings
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Exponential, Graded, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.parameters import Parameter
from jkrcli.measured.procedure import fit
from jkrcli.measured.settings import Settings
from jkrcli.methods.protocol import METHODS, method_class

from . import noise_cells
from .chart_reference import Reference, reference_of
from .command import call, output_of, parser_of, pool_of
from .watchdog import TooSlowError, cpu_limit

SOFT, STIFF, GEL = Elastic(1e6, 0.4), Elastic(2e7, 0.3), Elastic(1e6, 0.499)
SKIN = Graded(Exponential(2e7, 1e6, 1e-6), 0.4)
# h = 1 um, R = 1 mm, contact to several h; the least body first.
SPECIMENS = {
    "coating": Specimen((Layer(SOFT, 1e-6),), HalfSpace(STIFF)),
    "half-space": Specimen((), HalfSpace(SOFT)),
    "thin layer": Specimen((Layer(SOFT, 1e-6),), Rigid()),
    "gel": Specimen((Layer(GEL, 1e-6),), Rigid()),
    "stiff on soft": Specimen((Layer(STIFF, 2e-7), Layer(GEL, 1e-6)), HalfSpace(SOFT)),
    "graded": Specimen((Layer(SKIN, 1e-6),), HalfSpace(SOFT)),
    "cylinder": Specimen((Layer(SOFT, 1e-5),), Rigid(), radius=2e-5, side="free"),
}
BODIES = {name: Problem(Paraboloid(1e-3), held, Loading("radius", 5e-6, 25)) for name, held in SPECIMENS.items()}
NOISY = ("noisy Hertz", "noisy layer")  # series for slopes, with relative noise of 1e-3
RECORDED = ("half-space", "thin layer")  # bodies of simulated records that are fitted
USERS = {"integral": ("layered", "hybrid")}  # methods that share what stands in a folder; else the folder's own
TUNED = "tuned(?!.*make constants)"  # what comments say of the numbers that this study is of
SHARED: dict[str, Reference] = {}  # exact solutions of this process, by shipped numbers


@dataclass(frozen=True)
class Knob:
    """A number of an algorithm: the constant ``name`` of ``module``, and its ``shipped`` value."""

    module: str
    name: str
    shipped: float

    @property
    def values(self) -> tuple[float, ...]:
        """The values it is varied to: a half and a double, of small whole numbers the neighbours."""
        x = self.shipped
        if isinstance(x, int):
            return (x // 2, 2 * x) if x > 7 else tuple(n for n in (x - 1, x + 1) if n > 0)
        return x / 2, 2 * x


@dataclass(frozen=True)
class Variant:
    """A body solved by a method (or slopes found of a noisy series) with ``value`` at ``knob``; None: all shipped."""

    body: str
    method: str
    knob: Knob | None = None
    value: float | None = None


@dataclass(frozen=True)
class Outcome:
    """Relative ``error`` of P, of the pull-off force where slopes were found, of E* and w where a record was fitted;
    CPU ``seconds``; ``reason``: why there is no error."""

    error: float | None
    seconds: float
    reason: str = ""


def knobs(
    asked: Sequence[str] = (), says: str = TUNED, without: Collection[str] = ("cli", "many", "report", "__main__")
) -> list[Knob]:
    """All numbers of the algorithms ``asked`` for (parts of modules' names; none: of all) whose comment ``says`` so,
    but of the rooms ``without`` a part here."""
    found = []
    for item in pkgutil.walk_packages(jkrcli.__path__, "jkrcli."):
        if item.name.split(".")[1] in without:
            continue
        if asked and not any(word.replace("-", "_") in item.name for word in asked):
            continue
        module = importlib.import_module(item.name)
        told = constants_told(inspect.getsource(module))
        found += [Knob(item.name, name, getattr(module, name)) for name, words in told if re.search(says, words)]
    return [knob for knob in found if type(knob.shipped) in (int, float)]


def constants_told(source: str) -> Iterator[tuple[str, str]]:
    """The constants of a module, each with its comment, which stands beside or right above it."""
    lines = source.splitlines()
    for node in ast.parse(source).body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        for name in [item.id for item in targets if isinstance(item, ast.Name) and item.id.isupper()]:
            first = node.lineno - 1
            while first and lines[first - 1].startswith("#"):
                first -= 1
            yield name, " ".join(line.partition("#")[2] for line in lines[first : node.end_lineno])


def variants_of(knob: Knob, bodies: Sequence[str]) -> list[Variant]:
    """All that the algorithm of ``knob`` has a part in, with each of its values; empty where it has none."""
    _, room, *rest = knob.module.split(".")
    if room == "measured":
        able = [(body, "fit") for body in RECORDED[: len(bodies)]]
    elif room == "adhesion":
        able = [(body, way) for body in NOISY[: len(bodies)] for way in noise_cells.METHODS]
    else:
        folder, of_wings = rest[0] if rest else "", {wing.name: tuple(wing.methods) for wing in wings()}
        names = USERS.get(folder, (folder.replace("_", "-"),)) if room == "methods" else of_wings.get(room, ())
        methods = {name: method_class(name)() for name in names if name in METHODS}
        able = [(body, name) for body in bodies for name, held in methods.items() if not held.refusal(BODIES[body])]
    return [Variant(*pair, knob, value) for pair in able for value in knob.values]


def measure(variant: Variant) -> Outcome:
    """The outcome of a variant that is solved here; SolveError where it takes more than a minute of CPU time."""
    work = _prepared(variant)
    with (
        contextlib.nullcontext()
        if variant.knob is None or variant.value is None
        else varied(variant.knob, variant.value)
    ):
        start = time.process_time()
        try:
            with cpu_limit(60.0):
                error = work()
        except TooSlowError:
            raise SolveError("takes more than 60 CPU s") from None
        return Outcome(error, time.process_time() - start)


def outcomes(variants: Sequence[Variant], pool: Pool) -> dict[Variant, Outcome]:
    """The outcomes of all variants in their order; what fails is told."""
    found = {}
    for index, result in completed(pool, measure, variants, "tuning"):
        if isinstance(result, Exception):
            result = Outcome(None, 0.0, f"{type(result).__name__}: {result}".splitlines()[0])
        found[index] = result
    return {variant: found[index] for index, variant in enumerate(variants)}


def _prepared(variant: Variant) -> partial[float]:
    """What is timed, its exact solution found beforehand with the shipped numbers."""
    if variant.body in NOISY:
        body = noise_cells.BODIES[NOISY.index(variant.body)]
        exact = body.series(60)
        return partial(_slopes_error, variant.method, body, transform(exact, slopes(exact, "exact"), body.w))
    problem = BODIES[variant.body]
    if variant.method == "fit":
        return partial(_fit_error, problem)
    if variant.body not in SHARED:
        SHARED[variant.body] = _reference(problem)
    return partial(_load_error, variant.method, problem, SHARED[variant.body])


def _reference(problem: Problem) -> Reference:
    """The exact solution; of a body that ends sideways by ``hybrid`` to a tolerance a tenth of its default."""
    if problem.specimen.radius is None:
        return reference_of(problem, 1e-3)
    dense = replace(problem, loading=replace(problem.loading, maximum=5.1e-6, points=100))
    series = method_class("hybrid")(tolerance=1e-6)(dense).series
    return Reference("hybrid, tolerance 1e-06", transform(series, slopes(series, "exact"), 1e-3))


def _load_error(method: str, problem: Problem, reference: Reference) -> float:
    series = method_class(method)()(problem).series
    return reference.load_error(series.delta, series.P)


def _slopes_error(way: str, body: noise_cells.Body, truth: Any) -> float:
    return noise_cells.cell(body, truth, 1e-3, way, 5).median


def _fit_error(problem: Problem) -> float:
    """Median over nine records of the larger relative error of E* and w: a retraction under load control with 1 % of
    noise on both axes, its jump, a base line."""
    series = method_class("layered")()(problem).series
    body = FittedBody.of(problem, series, slopes(series, "exact"))
    third = len(series) // 3  # there w shifts the contact by its own displacement
    w = float(series.delta[third] ** 2 * body.slopes.dS[third] / (4 * np.pi * series.a[third]))
    adhesive = transform(series, body.slopes, w)
    lost = adhesive.pull_off(0.0)
    assert not isinstance(lost, Unknown)
    delta, P = adhesive.at(np.linspace(series.a[-1], lost.a, 150))
    delta = np.append(delta, lost.delta - np.linspace(0, np.ptp(delta), 50))
    P = np.append(P, np.zeros(50))
    settings, errors = Settings(tuple(Parameter(name, True) for name in ("modulus", "w", "delta0"))), []
    for seed in range(9):
        noise = 0.01 * np.random.default_rng(seed).standard_normal((2, delta.size))
        record = Curve("record", delta=delta + noise[0] * series.delta[third], P=P + noise[1] * abs(lost.P))
        found = fit(body, record, settings)
        errors.append(max(abs(found.value("modulus") - 1), abs(found.value("w") / w - 1)))
    return float(np.median(errors))


@contextlib.contextmanager
def varied(knob: Knob, value: float) -> Iterator[None]:
    """The constant with ``value`` in all modules that know it; nothing computed before, or with it, is kept."""
    holders = modules_with(knob)
    for module in holders:
        setattr(module, knob.name, value)
    forget()
    try:
        yield
    finally:
        for module in holders:
            setattr(module, knob.name, knob.shipped)
        forget()


def modules_with(knob: Knob) -> list[ModuleType]:
    """The module of a constant, and those that import it."""
    importlib.import_module(knob.module)
    loaded = [module for name, module in list(sys.modules.items()) if name.startswith("jkrcli.")]
    return [module for module in loaded if vars(module).get(knob.name) == knob.shipped]


def forget() -> None:
    """Clear every memory of what was computed."""
    for item in gc.get_objects():
        if isinstance(item, functools._lru_cache_wrapper) and item.__module__ != __name__:
            item.cache_clear()


def table(found: Mapping[Variant, Outcome]) -> dict[str, list[Any]]:
    """A row per varied number, value, body and method, the shipped one beside it."""
    rows = []
    for trial, outcome in found.items():
        if trial.knob is not None:
            usual = found[Variant(trial.body, trial.method)]
            named = {"algorithm": trial.knob.module.removeprefix("jkrcli."), "constant": trial.knob.name}
            told = {"shipped": trial.knob.shipped, "value": trial.value, "body": trial.body, "method": trial.method}
            errors = {"shipped_error": usual.error, "error": outcome.error}
            times = {"shipped_cpu_s": usual.seconds, "cpu_s": outcome.seconds, "reason": outcome.reason}
            rows.append(named | told | errors | times)
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ("algorithm", "constant", "shipped"))}


def words(found: Mapping[Variant, Outcome], every: Sequence[Knob]) -> list[str]:
    """A line per varied number, value and method: worst error and whole time of all bodies, varied and shipped."""
    titles = f"{'error':>10}{'CPU s':>8}"
    lines = [f"{'tuned number':<48}{'method':<10}{'value':>10}{titles}{'shipped':>10}{titles}"]
    for knob, value in [(each, value) for each in every for value in each.values]:
        label = f"{knob.module.removeprefix('jkrcli.')}.{knob.name}"
        mine = {trial: held for trial, held in found.items() if (trial.knob, trial.value) == (knob, value)}
        for method in dict.fromkeys(trial.method for trial in mine):
            changed = {trial: held for trial, held in mine.items() if trial.method == method}
            usual = _summary([found[Variant(trial.body, method)] for trial in changed])
            lines.append(
                f"{label:<48}{method:<10}{value:>10.4g}{_summary(changed.values())}{knob.shipped:>10.4g}{usual}"
            )
        if not mine:
            lines.append(f"{label:<48}no body here depends on it")
    return lines


def _summary(outcomes: Collection[Outcome]) -> str:
    errors = [held.error for held in outcomes]
    worst = f"{max(error for error in errors if error is not None):.1e}" if None not in errors else "failed"
    return f"{worst:>10}{sum(held.seconds for held in outcomes):>8.2f}"


def main(given_words: Sequence[str] | None = None) -> int:
    """Vary every tuned number by a half and a double; errors and times on reference bodies beside the shipped ones.

    P at equal depth against the exact solution; for slopes the pull-off force of noisy series, for fits E* and w of
    simulated records. Writes tuning.csv and
    prints the table; half an hour for all on two cores.
    """
    parser = parser_of(str(main.__doc__))
    parser.add_argument("algorithms", nargs="*", help="parts of modules' names, such as hybrid [default: all]")
    parser.add_argument("--quick", action="store_true", help="one body")
    given = parser.parse_args(given_words)
    files = output_of(given).files(given.output / "tuning", (".csv",))
    bodies = list(BODIES)[: 1 if given.quick else None]
    every = knobs(given.algorithms)
    asked = [trial for knob in every for trial in variants_of(knob, bodies)]
    asked = [*dict.fromkeys(Variant(trial.body, trial.method) for trial in asked), *asked]
    with pool_of(given, 0.5 * len(asked)) as pool:
        found = outcomes(asked, pool)
    files.write(table(found))
    print("\n".join(words(found, every)))
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

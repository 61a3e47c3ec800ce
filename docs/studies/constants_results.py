"""Cheap results of every kind, as numbers with their stated errors, by which the study of chosen numbers judges.

Each is made anew when it is called, from bodies, shipped cases and measured files.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import jkrcli as jkr
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import TableProfile
from jkrcli.measured.curve import Curve
from jkrcli.methods.protocol import method_class
from jkrcli.report.export import Exported
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import Solution

METHODS: tuple[tuple[str, dict[str, float]], ...] = (
    ("layered", {}),
    ("hybrid", {"tolerance": 1e-4}),
    ("closed-form", {}),
)
Numbers: TypeAlias = dict[str, tuple[float, float]]  # by name: the number, its stated error (0: none)
NO_RESULTS = ("errors", "cpu_s", "version", "smoothing_lambda")  # of a summary: what is said elsewhere, or no number
CASES = Path(__file__).parents[2] / "cases"
RECORD, TABLE = CASES / "measured" / "raw-force-curve.txt", CASES / "measured" / "gel-probe.csv"
SOFT, STIFF, GEL = jkr.Elastic(1e6, 0.4), jkr.Elastic(2e7, 0.3), jkr.Elastic(1e6, 0.499)
BALL, W = jkr.Paraboloid(1e-3), 0.01  # contact to 5 um, layers of 1 um
FAR = jkr.Loading("radius", 5e-6, 12)


def _layers(*materials: Any, **options: Any) -> jkr.Specimen:
    return jkr.Specimen(tuple(jkr.Layer(item, 1e-6) for item in materials), jkr.Rigid(), **options)


GRADED = jkr.Graded(jkr.Exponential(2e7, 1e6, 1e-6), 0.4)
SPECIMENS = {
    "half-space": jkr.Specimen((), jkr.HalfSpace(SOFT)),
    "layer": _layers(SOFT),
    "gel": _layers(GEL),
    "coating": jkr.Specimen((jkr.Layer(SOFT, 1e-6),), jkr.HalfSpace(STIFF)),
    "three layers": _layers(STIFF, GEL, SOFT),
    "graded": jkr.Specimen((jkr.Layer(GRADED, 1e-6),), jkr.HalfSpace(SOFT)),
    "transverse": _layers(jkr.TransverselyIsotropic(1e6, 2e6, 0.2, 0.3, 5e5)),
    "tense": _layers(SOFT, surface_tension=0.5),
    "cylinder": jkr.Specimen((jkr.Layer(SOFT, 1e-5),), jkr.Rigid(), radius=2e-5, side="free"),
}


def _problem(specimen: str, indenter: Any = BALL, loading: jkr.Loading = FAR, sticks: bool = False) -> jkr.Problem:
    return jkr.Problem(indenter, SPECIMENS[specimen], loading, sticks)


def _table() -> TableProfile:
    r = np.linspace(0, 1e-5, 60)
    return TableProfile(tuple(r), tuple(r**2 / 2e-3))


def solved(problem: jkr.Problem, method: str, **options: Any) -> Numbers:
    """The series of a body, each load and depth with the share of the stated error."""
    return _series(method_class(method)(**options)(problem))


def _series(solution: Solution) -> Numbers:
    series, total = solution.series, solution.budget.series
    share = 0.0 if isinstance(total, Unknown) else total
    found: Numbers = {}
    for name in ("a", "delta", "P", "S", "dS"):
        values = getattr(series, name)
        stated = series.errors.get(name, share * abs(values)) if values is not None else ()
        found |= {f"{name}[{i}]": (float(values[i]), float(stated[i])) for i in range(len(stated))}
    return found


def summary(make: Callable[[], Any]) -> Numbers:
    """All numbers that a result's summary holds; the error of P_N is what stands beside it as P_err_N. Errors
    themselves have to be good to their own size."""
    return dict(_flat("", make().summary()))


def _flat(path: str, value: Any) -> list[tuple[str, tuple[float, float]]]:
    match value:
        case Mapping():
            return [
                (name, (number, error or _stated(key, value)))
                for key, item in value.items()
                if key not in NO_RESULTS
                for name, (number, error) in _flat(f"{path}.{key}", item)
            ]
        case list() | tuple():
            return [pair for i, item in enumerate(value) for pair in _flat(f"{path}[{i}]", item)]
        case bool() | str() | None:
            return []
        case int() | float():
            return [(path, (float(value), 0.0))]
    return []


def _stated(name: str, told: Mapping[str, Any]) -> float:
    """The error that stands beside a number; of an error itself; infinite where it is known that it is not known."""
    if "_err" in name:
        return _plain(told[name])
    shares = told.get("relative_standard_errors", {})  # of the parameters of a law, whose keys end in their units
    for parameter, share in shares.items():
        if name.startswith(parameter):
            return math.inf if share is None else _plain(share) * abs(told[name])
    return next((_plain(item) for key, item in told.items() if key.replace("_err", "", 1) == name != key), 0.0)


def _plain(error: Any) -> float:
    return abs(float(error)) if isinstance(error, int | float) and math.isfinite(error) else 0.0


def columns(make: Callable[[], Any]) -> Numbers:
    """A tenth of the rows of each column of numbers."""
    found: Numbers = {}
    told = {name: np.asarray(values) for name, values in make().columns.items()}
    for name, array in told.items():
        for i in range(0, array.size if array.dtype.kind == "f" else 0, max(array.size // 10, 1)):
            found[f"{name}[{i}]"] = float(array[i]), _stated(name, {key: item[i].item() for key, item in told.items()})
    return found


def fitted(make: Callable[[], Any]) -> Numbers:
    """The estimates of a fit, each with its standard error, and those themselves, good to a few per cent."""
    found: Numbers = {}
    for item in make().estimates:
        if item.error is not None:
            found |= {item.name: (item.value, item.error), f"{item.name} error": (item.error, item.error)}
    return found


def _noisy(*columns: np.ndarray, share: float = 0.01) -> list[np.ndarray]:
    rng = np.random.default_rng(1)
    return [item + share * np.ptp(item) * rng.standard_normal(item.size) for item in columns]


def _case(name: str) -> Any:
    return jkr.load_case(CASES / f"{name}.toml")


def _slopes(rule: str) -> Numbers:
    """Pull-off of a noisy series, its slopes by a rule."""
    solution = jkr.solve(_problem("layer", loading=replace(FAR, points=40)))
    rng = np.random.default_rng(1)
    held = solution.series
    noisy = [item * (1 + 1e-3 * rng.standard_normal(40)) for item in (held.delta, held.P)]
    series = replace(held, delta=noisy[0], P=noisy[1], S=None, dS=None, errors={})
    return summary(partial(jkr.transform, replace(solution, series=series), W, rule))


def _work(use: Any) -> Any:
    return jkr.work(_case("gel"), TABLE, use=use, noise={"P": 2e-6})


def _at_speed(**options: Any) -> Any:
    law = jkr.PowerRate(v0=1e-6, n=0.5)
    return jkr.cycle_at_speed(_case("gel"), 0.05, law, speed="10 um/s", to_load="1 mN", **options)


def _history(make: Callable[[], Any]) -> Numbers:
    """Columns of a history at 12 instants, with its stated error of the loads."""
    history = make()
    table = {name: np.asarray(values) for name, values in history.table(12).items()}
    share = _plain(history.error)
    return {
        f"{name}[{i}]": (float(x), share * float(np.nanmax(np.abs(values))))
        for name, values in table.items()
        if values.dtype.kind == "f"
        for i, x in enumerate(values)
    }


def _relaxing(**options: Any) -> Any:
    return jkr.cycle_relaxing(_case("relaxing-gel"), speed="20 um/s", to_depth="20 um", hold="5 s", **options)


def _relaxation() -> Any:
    table = {name: np.asarray(values) for name, values in _relaxing().table(120).items()}
    delta, P = _noisy(table["delta_m"], table["P_N"])
    return jkr.identify_relaxation(_case("relaxing-gel"), Curve("made", t=table["t_s"], delta=delta, P=P))


def _imported() -> Numbers:
    """A foreign table of a, delta, P without slopes, to its pull-off."""
    problem = _problem("gel", loading=replace(FAR, points=40))
    series = jkr.solve(problem).series
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "table.csv"
        rows = np.column_stack(_noisy(series.a, series.delta, series.P, share=1e-4))
        np.savetxt(table, rows, delimiter=",", header="a_m,delta_m,P_N", comments="")
        return summary(partial(jkr.transform, read_series(table, problem, SeriesReading()), W))


def _methods() -> dict[str, Callable[[], Numbers]]:
    """Bodies by the methods that can, at tolerances that take a fraction of a second."""
    found: dict[str, Callable[[], Numbers]] = {}
    for name in SPECIMENS:
        for method, options in METHODS:
            if method_class(method)(**options).refusal(_problem(name)) is None:
                found[f"{name} by {method}"] = partial(solved, _problem(name), method, **options)
    few = jkr.Loading("radius", 2e-6, 6)
    for name in ("half-space", "layer", "gel", "tense"):
        found[f"{name} by fem"] = partial(solved, _problem(name, loading=few), "fem", tolerance=3e-2)
    return found | {
        "stuck layer": partial(solved, _problem("layer", sticks=True), "layered"),
        "stuck layer by fem": partial(solved, _problem("layer", loading=few, sticks=True), "fem", tolerance=3e-2),
        "table": partial(solved, _problem("layer", _table()), "layered"),
        "loads": partial(solved, _problem("gel", loading=jkr.Loading("load", 1e-3, 12)), "layered"),
        "depths": partial(
            solved, _problem("coating", loading=jkr.Loading("depth", 1e-8, 12)), "hybrid", tolerance=1e-4
        ),
        "cone": partial(solved, _problem("layer", jkr.RoundedCone(1e-6, 1.2)), "layered"),
        "flat": partial(solved, _problem("layer", jkr.RoundedFlat(1e-6, 1e-6)), "layered"),
    }


def _maps() -> dict[str, Callable[[], Numbers]]:
    one: dict[str, dict[str, Any]] = {
        "pull-off": {"q": [1.0], "nu": [0.499], "beta": [0.0, 0.5]},
        "sticking": {"nu": [0.3], "ratio": [1.0]},
        "transition": {"q": [1.0], "mu": [1.0]},
        "adhesion": {"mu": [1.0], "load": [1.0]},
        "rate": {"speed": [1.0], "stiffness": ["1"]},
    }
    return {f"{name} map": partial(columns, partial(jkr.study_map, name, **axes)) for name, axes in one.items()}


RESULTS: dict[str, Callable[[], Numbers]] = {
    **_methods(),
    "transform": lambda: summary(lambda: jkr.transform(_case("gel"), 0.04)),
    "transform of finite elements": lambda: summary(lambda: jkr.transform(_problem("layer"), W, method="fem")),
    "range": lambda: summary(lambda: jkr.transform(_problem("layer"), W, stress="100 kPa")),
    "range of a gel": lambda: columns(lambda: jkr.transform(_problem("gel"), W, length="50 nm")),
    **{f"slopes by {rule}": partial(_slopes, rule) for rule in ("integral", "loocv", "gcv")},
    "device": lambda: summary(lambda: jkr.pull_off(_case("gel"), 0.04, stiffness=["2 kN/m"])),
    "measured pull-off": lambda: summary(lambda: jkr.pull_off(_problem("gel"), load="1 uN", uncertain={"R": "1%"})),
    "profile": lambda: columns(lambda: jkr.profile(_case("gel"), load="0.5 mN", w=0.04)),
    "profile of a range": lambda: columns(lambda: jkr.profile(_problem("layer"), a=2e-6, w=W, stress="100 kPa")),
    "work": lambda: summary(lambda: _work("a,P")),
    "work over depth": lambda: summary(lambda: _work("delta,P")),
    "check": lambda: summary(lambda: jkr.check(CASES / "gel.toml")),
    "at speed": lambda: _history(_at_speed),
    "at speed by a spring": lambda: _history(lambda: _at_speed(stiffness="1 kN/m")),
    "relaxing": lambda: _history(_relaxing),
    "relaxing by a spring": lambda: _history(lambda: _relaxing(stiffness="1 kN/m")),
    "contact law": lambda: columns(lambda: Exported.of(jkr.transform(_case("gel"), 0.04))),
    "half-space": lambda: summary(lambda: jkr.transform(_problem("half-space"), W)),
    "look": lambda: summary(lambda: jkr.look(RECORD)),
    "import": _imported,
    "fit of a table": lambda: fitted(lambda: jkr.identify(_case("gel"), TABLE)),
    "fit of a record": lambda: fitted(lambda: jkr.identify(_case("gel"), RECORD)),
    "fit of relaxation": lambda: fitted(_relaxation),
    **_maps(),
}

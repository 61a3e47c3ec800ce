"""Intervals of fits of raw records against the truth of made ones: ``make record-bounds SEED=7``.

Records of half-spaces and nine layers by the generator of the tests, which shares no code with the fit. Per kind of
noise: how many of the 95 % intervals of E*, w and w_approach hold, and how many records are off by more than three
intervals without a flag. Then the same of as many approaches alone, with w from 0 to five times what their noise shows:
how often E* and the upper limits of w hold, and the mean error of E* in standard errors. Then of clean records of both
tips, of both directions or one, whose largest load is 0 to 20 times the pull-off force: how many of those above 0.2 are
refused. Then of tables of a lens on a layer with both branches, a fifth as many of each kind.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from dataclasses import replace
from functools import cache
from typing import Any

import lens_tables  # type: ignore[import-not-found]
import numpy as np
from force_curves import Body, Instrument, record  # type: ignore[import-not-found]
from layer_contact import BondedLayer, half_space  # type: ignore[import-not-found]

from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import JkrError
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import APPROACH, RETRACT, Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.procedure import fit
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

from . import shallow_records
from .cycle_records import NOISES, drawn

R = 5e-6  # tip radius [m]
LAYERS = [(h, nu) for h in (0.5e-6, 1.5e-6, 5e-6) for nu in (0.3, 0.45, 0.5)]
TABLES = [(columns, rest) for columns in ("a,P", "delta,P", "a,delta,P") for rest in (True, False)]
OFF = 3.0  # of the interval from the value towards the truth, beyond which an answer without a flag counts as wrong


def body(layer: tuple[float, float] | None) -> FittedBody:
    """The half-space, or a layer of thickness [m] and nu, of E* = 10 kPa."""
    nu = 0.5 if layer is None else layer[1]
    material = Elastic((1 - nu**2) * 1e4, nu)
    specimen = Specimen((), HalfSpace(material)) if layer is None else Specimen((Layer(material, layer[0]),), Rigid())
    problem = Problem(Paraboloid(R), specimen, Loading("radius", 1e-6, 60))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


@cache
def shallow_body(sphere: bool, layer: tuple[float, float] | None) -> FittedBody:
    """The same of either tip."""
    problem = body(layer).problem
    problem = replace(problem, indenter=Sphere(R) if sphere else Paraboloid(R))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def fitted_shallow(made: Any) -> dict[str, float]:
    """As ``judged``, of a record of ``shallow_records``; "refused": 1 where it is."""
    held = shallow_body(made.sphere, made.layer)
    z, P = made.columns["z"], made.columns["P"]
    try:
        return judged(held, Curve("made", delta=z - P / made.k, P=P, stiffness=made.k), made.truth)
    except JkrError as error:
        print(f"{made.presses:.2f} pull-off forces, {' and '.join(made.directions)}, lever {made.lever:.2g}, noise "
              f"{made.noise:.2g}: {error}")  # fmt: skip
        return {"refused": 1.0}


def shallow(seed: int, count: int) -> None:
    """Prints what comes of clean records of 0.2 to 20 pull-off forces, and of those below."""
    told: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for i in range(count):
        made = shallow_records.drawn((seed, i))
        kind = ("shallower" if made.presses <= 0.2 else "shallow") + (" alone" if len(made.directions) == 1 else "")
        for name, value in ({"refused": 0.0, "silent": 0.0} | fitted_shallow(made)).items():
            told[kind][name].append(value)
    _print(told)


@cache
def lens_body() -> FittedBody:
    """The layer under a lens, of half of the modulus that tables are made with."""
    material = Elastic((1 - lens_tables.NU**2) * lens_tables.E_STAR / 2, lens_tables.NU)
    specimen = Specimen((Layer(material, lens_tables.H),), Rigid())
    problem = Problem(Paraboloid(lens_tables.R), specimen, Loading("radius", 1e-3, 80))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def judged(held: FittedBody, curve: Curve, truth: dict[str, float], **options: Any) -> dict[str, float]:
    """By name: 1 where the interval holds the truth; "silent": 1 where an answer is far off without a flag."""
    found = fit(held, curve, settings_of(held, **options))
    told, silent = {}, 0.0
    for item in found.estimates:
        true = truth.get(item.name)
        if true is None or item.low is None:
            continue
        told[item.name] = float(item.low <= true <= (math.inf if item.high is None else item.high))
        if item.high is None:
            continue
        far = abs(item.value - true) > OFF * (item.high - item.value if true > item.value else item.value - item.low)
        silent = max(silent, float(far and not found.flags))
    return told | {"silent": silent}


def approached(
    rng: np.random.Generator, R: float, h: float | None, body: Body = half_space
) -> tuple[Instrument, float, int]:
    """A random device and E* [Pa] of an approach alone, and the seed of its noise; w is to be chosen by what that
    noise shows."""
    widest = 0.3 * R if h is None else min(0.3 * R, 3 * h)
    E_star, a = 10 ** rng.uniform(3, 6), np.array([widest * rng.uniform(0.3, 1)])
    delta, P, S, _ = (float(item[0]) for item in body(a, R))
    k, rows = E_star * S * 10 ** rng.uniform(-1, 1.5), int(10 ** rng.uniform(math.log10(200), math.log10(5000)))
    span = delta + E_star * P / k
    device = Instrument(
        k, rows, far=span * rng.uniform(0.5, 3), largest=E_star * P, noise=E_star * P * 10 ** rng.uniform(-3, -1.7),
        offset=E_star * P * rng.uniform(-1, 1), tilt=E_star * P / span * rng.uniform(-0.1, 0.1),
    )  # fmt: skip
    return device, E_star, int(rng.integers(1 << 30))


def approaches(seed: int, count: int, bodies: dict[Any, FittedBody], exact: dict[Any, Any]) -> None:
    """Prints what intervals of approaches alone hold."""
    told: dict[str, list[float]] = defaultdict(list)
    for i in range(count // 2):
        rng = np.random.default_rng((seed, 1, i))
        layer = None if i % 2 else LAYERS[i // 2 % len(LAYERS)]
        device, E_star, noise = approached(rng, R, None if layer is None else layer[0], exact[layer])
        w, shown = 0.0, 0.0
        for times in (0.0, float(rng.uniform(0, 5))):
            w = times * shown
            columns = record(E_star, R, w, w, device, noise + round(10 * times), exact[layer])
            z, P = (columns[name][: device.rows] for name in "zP")
            try:
                found = fit(bodies[layer], Curve("made", delta=z - P / device.k, P=P, stiffness=device.k),
                            settings_of(bodies[layer], segment=APPROACH))  # fmt: skip
            except JkrError as error:
                told["refused"].append(1.0)
                print(f"approach {i}: {error}")
                break
            E, item = found.estimate("E_star"), found.estimate("w_approach")
            if E.error is None or E.low is None or E.high is None or item.low is None or item.high is None:
                told["not determined"].append(1.0)
                break
            shown = shown or item.high
            told["E_star"].append(float(E.low <= E_star <= E.high))
            told["bias of E_star"].append((E.value - E_star) / E.error)
            told["w_approach"].append(float(item.low <= w <= item.high))
            if item.low == 0:
                told["upper limit"].append(float(w <= item.high))
            told["w of a retraction"].append(float("w" in {one.name for one in found.estimates}))
            far = max(abs(E.value - E_star) / (E.high - E.low), abs(item.value - w) / (item.high - item.low))
            told["silent"].append(float(far > OFF / 2 and not found.flags))
    print(
        "approach alone", ", ".join(f"{name} {np.mean(values):.3f} of {len(values)}" for name, values in told.items())
    )


def main(seed: int, count: int) -> None:
    bodies = {layer: body(layer) for layer in (None, *LAYERS)}
    exact = {layer: half_space if layer is None else BondedLayer(*layer) for layer in bodies}
    found: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for i in range(count):
        rng = np.random.default_rng((seed, i))
        layer = None if i % 2 else LAYERS[i // 2 % len(LAYERS)]
        kind = "white" if rng.random() < 0.5 else str(rng.choice(NOISES[1:]))
        made = drawn(rng, R, None if layer is None else layer[0], exact[layer], kind)
        try:
            z, P = made.columns["z"], made.columns["P"]
            curve = Curve("made", delta=z - P / made.k, P=P, stiffness=made.k)
            told = judged(bodies[layer], curve, made.truth)
        except JkrError as error:
            told = {"refused": 1.0}
            print(f"{i}: {error}")
        for name, value in told.items():
            found[kind][name].append(value)
            found["all"][name].append(value)
    _print(found)
    approaches(seed, count, bodies, exact)
    shallow(seed, count)
    tables: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for i in range(count // 5 * len(TABLES)):
        columns, rest = TABLES[i % len(TABLES)]
        lens = lens_tables.lens(np.random.default_rng((seed, i)), columns, rest, (APPROACH, RETRACT))
        told = judged(lens_body(), lens.curve, lens.truth, bound=[("range", "..1 nm")])  # no range is looked for
        for name, value in told.items():
            tables[f"{columns}{' with rest' * rest}"][name].append(value)
    _print(tables)


def _print(counts: dict[str, dict[str, list[float]]]) -> None:
    """Prints how many intervals hold, by kind of record."""
    for kind, parts in counts.items():
        held = ", ".join(
            f"{name} {np.mean(values):.3f} of {len(values)} (± {math.sqrt(0.05 * 0.95 / len(values)):.3f})"
            for name, values in parts.items() if name != "silent"
        )  # fmt: skip
        print(f"{kind:<6} {held}; silent and far off {np.sum(parts['silent']):.0f}", flush=True)


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3]))

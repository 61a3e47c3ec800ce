"""Whether alternatives of raw records are asked for where they are there, and not where not: ``make record-rivals
SEED=7``.

Records of fourteen wrong models, and of right ones, by the generator of the tests, which shares no code with the fit;
at its noise and at five times that. Per kind: how many are asked for, of which the right family is named, how many hold
E* and w within the intervals widened by the model's part, and how many are *fitted* with E* or w more than three total
errors off; the systematic part over the statistical one; the cost of all scores over that of the fit. Then what
``--model auto`` makes of those whose right alternative it fits in full; and how the systematic part of each alternative
compares with what a fit in full at its bound moves E* and w by.
"""

from __future__ import annotations

import math
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from wrong_records import SPEED, Drawn, Wrong, right  # type: ignore[import-not-found]

from jkrcli.adhesion.slopes import slopes
from jkrcli.adhesion.validity import LIMITS
from jkrcli.base.errors import JkrError
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured import force_curve, record
from jkrcli.measured.alternative_fits import record_alternatives
from jkrcli.measured.curve import Curve
from jkrcli.measured.fitted_record import FittedRecord
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.hypotheses import ALTERNATIVES
from jkrcli.measured.lockstep import Flow, alone
from jkrcli.measured.model_changes import AMOUNT, ChangedModel
from jkrcli.measured.procedure import fit
from jkrcli.measured.result import Fit
from jkrcli.measured.score_tests import RecordAlternatives, relative_errors
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

from .cycle_records import spoilt
from .wrong_kinds import WRONG

# Right records by what disturbs them, and how they are fitted:
RIGHT: dict[str, dict[str, Any]] = {
    "white": {}, "pink": {}, "peak": {}, "steps": {}, "drift": {"free": ["drift"]}, "wave": {"base_line": "sine"},
}  # fmt: skip
CALIBRATED = ("stiffness +10 %", "R +10 %", "nu .3 as .5 on a layer")
# Where the right alternative is among those that are fitted in full:
IN_FULL = ("layer as half-space", "Maugis mu 0.3", "w rising to four times", "w over the speed", "relaxation", "cone",
           "stiffness +10 %", "creep", "hysteresis")  # fmt: skip
# Of which some is likely before the data:
BOUNDED = ("adhesion of finite range", "exponent of the tip", "no slip", "surface tension")
spent = [0.0, 0.0]  # seconds of all fits, of their scores
last: list[Any] = []  # body, fit and alternatives of the record that was fitted last


@lru_cache
def body(R: float, h: float | None, nu: float, sphere: bool) -> FittedBody:
    """What the reader is told, of E* = 10 kPa."""
    material = Elastic((1 - nu**2) * 1e4, nu)
    specimen = Specimen((), HalfSpace(material)) if h is None else Specimen((Layer(material, h),), Rigid())
    tip = Sphere(R) if sphere else Paraboloid(R)
    problem = Problem(tip, specimen, Loading("radius", 0.2 * R if h is None else h, 60))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True)


def fitted(kind: str, made: Wrong, **options: Any) -> Fit:
    held = body(made.R, made.h, made.nu, kind == "large strains")
    known = [("radius", "10%"), ("stiffness", "10%")] + [("nu", "0.2")] * (made.h is not None)
    options = {"model": "jkr", **RIGHT.get(kind, {}), **options}
    settings = settings_of(held, uncertain=known if kind in CALIBRATED else (), **options)
    z, P = made.columns["z"], made.columns["P"]
    curve = Curve("made", delta=z - P / made.k, P=P, t=made.columns["t"], stiffness=made.k)
    last.clear()
    begin = time.process_time()
    found = fit(held, curve, settings)
    spent[0] += time.process_time() - begin
    return found


def timed_scores() -> None:
    """Counts the time of the scores apart, and keeps what was judged first of each fit."""

    def timed(
        at: FittedRecord, weighed: Callable[[RecordAlternatives], RecordAlternatives]
    ) -> Flow[RecordAlternatives]:
        begin = time.process_time()
        found = alone(record_alternatives(at, weighed))
        spent[1] += time.process_time() - begin
        if not last:  # the fit of the tip that was asked for; one by the other profile may follow
            last[:] = [at.body, at.fit, found]
        yield from ()
        return found

    vars(record).update(record_alternatives=timed)


def judged(kind: str, made: Wrong, found: Fit) -> dict[str, float]:
    """By name 1 where it is so."""
    assert found.verdict is not None
    named, told = found.verdict.alternatives, {"asked for": float(bool(found.verdict.alternatives.named))}
    if named.named and made.families:
        told["right family"] = float(bool({*named.families} & {*made.families}))
    inside, far = True, False
    for name, true in made.truth.items():
        item = found.estimate(name)
        if item.error is None or item.low is None or item.high is None:
            continue
        part = math.hypot(*(item.model or {}).values())
        inside &= item.low - part <= true <= item.high + part
        far |= abs(item.value - true) > 3 * math.hypot(item.error, part)
        if name == "E_star":
            strained = "above" if found.a.max() > LIMITS.a_over_R * made.R else "below"
            told |= {f"{strained}, half": 2 * part / (item.high - item.low), f"{strained}, error": part / item.error}
    told |= {"inside, widened": float(inside), "said or inside": float(inside or bool(named.named))}
    return told | {"silent": float(far and not found.flags)}


def in_full(seed: int, count: int) -> None:
    """How often an alternative is taken, of the right family and alone, and the truth is within three total errors."""
    for kind in IN_FULL:
        columns: dict[str, list[float]] = defaultdict(list)
        for i in range(count):
            made = SPEED.get(kind, WRONG.get(kind, right))(Drawn.of(np.random.default_rng((seed, i, 1)), 1.0))
            for name, value in _taken(kind, made).items():
                columns[name].append(value)
        shares = ", ".join(f"{name} {np.sum(values):.0f} of {len(values)}" for name, values in columns.items())
        print(f"{kind:<24} {shares}", flush=True)


def _taken(kind: str, made: Wrong) -> dict[str, float]:
    try:
        found = fitted(kind, made, model="auto")
    except JkrError:
        return {"refused": 1.0}
    assert found.verdict is not None
    if not found.verdict.alternatives.named:
        return {"asked for": 0.0}
    told, tied = {"asked for": 1.0, "taken": float(bool(found.verdict.tied))}, found.verdict.tied
    if not tied:
        return told
    inside, alone = True, True
    for name, true in made.truth.items():
        item = found.estimate(name)
        if item.error is not None:
            off = abs(item.value - true)
            inside &= off < 3 * math.hypot(item.error, *(item.model or {}).values())
            alone &= off < 3 * item.error
    told["right family"] = float(bool({one.family for one in tied} & {*made.families}))
    told["within 3 total errors"] = float(inside)
    if tied[0].family in made.families:
        told["right and best: within 3 standard errors"] = float(alone)
    return told


def at_bounds(seed: int, count: int) -> None:
    """Systematic parts over the largest moves of fits in full at amounts up to the same, where these exceed a tenth of
    the error."""
    for name in BOUNDED:
        ratios: dict[str, list[float]] = {"E_star": [], "w": []}
        for i in range(count):
            made = right(Drawn.of(np.random.default_rng((seed, i, 1)), 1.0))
            fitted("white", replace(made, nu=0.3), bound=[("surface_tension", "..30 mN/m")])
            _add_ratios(name, ratios)
        for quantity, values in ratios.items():
            near = np.mean((np.array(values) > 0.5) & (np.array(values) < 2)) if values else math.nan
            print(f"{name:<26} {quantity:<7} within a factor of two {near:.2f} of {len(values)}", flush=True)


def _add_ratios(name: str, ratios: dict[str, list[float]]) -> None:
    body, plain, alternatives = last
    at = FittedRecord(body, plain)
    score = next((one for one in alternatives.scores if one.name == name), None)
    if score is None or alternatives.named or score.most == 0:
        return
    change = next(one for one in ALTERNATIVES if one.name == name).change(at)
    assert change is not None
    upward = np.linspace(0.4, 1, 4) * score.most  # E* moves most at a range below that which moves w most
    moves = []
    for amount in (*upward, *-upward[upward * score.least < 0]):
        model = replace(ChangedModel.of(plain.model, change), known={**plain.model.known, AMOUNT: amount})
        here = FittedRecord(body, force_curve.fit(model, plain.x, near=True))
        moves.append([math.log(here.modulus / at.modulus), math.log(here.work / at.work) if here.work else 0.0])
    largest = np.abs(moves).max(axis=0)
    for quantity, error, moved in zip(ratios, relative_errors(plain), largest, strict=True):
        stated = score.moved(getattr(score, quantity))
        if stated and moved > 0.1 * error:
            ratios[quantity].append(stated / moved)


def main(seed: int, count: int) -> None:
    timed_scores()
    for louder in (1.0, 5.0):
        print(f"noise times {louder:g}, {count} records of each kind, right ones first")
        for kind in (*RIGHT, *WRONG):
            _line(kind, seed, count, louder)
    print(f"seconds of all fits {spent[0]:.1f}, of which scores {spent[1]:.1f}")
    print(f"--model auto at the generator's noise, {count} records each")
    in_full(seed, count)
    at_bounds(seed, min(count, 20))


def disturbed(rng: np.random.Generator, made: Wrong, noise: float, kind: str) -> Wrong:
    """A record with noise of a ``kind``, as large as the white ``noise`` [N] that it has, or a drift of 0.2 % of its
    way, or a wave of 0.1 to 10 % of the range of the load."""
    z, P = made.columns["z"], made.columns["P"]
    if kind == "drift":
        z = z + 0.002 * np.ptp(z) * made.columns["t"] / 2
    elif kind == "wave":
        wave = np.sin(2 * math.pi * (rng.uniform(3, 40) * z / np.ptp(z) + rng.random()))
        P = P + np.ptp(P) * 10 ** rng.uniform(-3, -1) * wave
    else:
        P = spoilt(rng, P, noise, kind)
    return replace(made, columns={**made.columns, "z": z, "P": P})


def _line(kind: str, seed: int, count: int, louder: float) -> None:
    columns: dict[str, list[float]] = defaultdict(list)
    for i in range(count):
        rng = np.random.default_rng((seed, i, int(louder)))
        at = Drawn.of(rng, louder)
        made = WRONG[kind](at) if kind in WRONG else disturbed(rng, right(at), at.noise, kind)
        try:
            told = judged(kind, made, fitted(kind, made))
        except JkrError as error:
            told = {"refused": 1.0}
            print(f"  {kind} {i}: {error}")
        for name, value in told.items():
            columns[name].append(value)
    parts = {key: [columns.pop(f"{side}, {key}", []) for side in ("below", "above")] for key in ("half", "error")}
    shares = ", ".join(f"{name} {np.mean(values):.2f}" for name, values in columns.items() if name != "silent")
    silent = np.sum(columns["silent"])
    print(f"{kind:<24} {shares}, silent {silent:.0f}", flush=True)
    for key, (below, above) in parts.items():
        medians = [float(np.median(one)) if one else math.nan for one in (below + above, below, above)]
        size = "95 % half-width" if key == "half" else "standard error"
        sides = (
            f"a/R below {LIMITS.a_over_R:g} {medians[1]:.2g} of {len(below)}, above {medians[2]:.2g} of {len(above)}"
        )
        print(f"  part over {size}, median {medians[0]:.2g}; {sides}", flush=True)


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3]))

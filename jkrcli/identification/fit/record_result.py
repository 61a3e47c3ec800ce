"""The fit of a raw record as the result that every fit gives: what the unknowns mean, intervals, columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from ...base import SAME, Array, Pool, known
from ...data import APPROACH, RETRACT, Curve, ForceCurve
from ..answer import FittedValue
from ..intervals import Intervals, bootstrap, changes_by, wider
from ..least_squares import State
from ..parameters import LIMIT, LINEAR, LOG, POSITIONS, ROOT, Parameter, dimension_of
from .body import FittedBody
from .checks import warnings_of
from .force_curve_fit import ForceCurveFit, fit, held_by_last_row
from .interference import Wave
from .record_flags import NAMES, judgement, sentences
from .record_rivals import OF_RIVALS
from .result import Fit
from .settings import CALIBRATED, Settings
from .statistics import structure, t_quantile
from .whole_record import reason_not

WORKS = {APPROACH: "w_approach", RETRACT: "w"}
DIMENSIONS = {
    "modulus": "number", "w": "work", "w_approach": "work", "delta0": "length", "P0": "load",
    "tilt": "stiffness", "wave_period": "length", "wave_amplitude": "load", **OF_RIVALS,
    **{name: dimension_of(name) for name in POSITIONS},
}  # fmt: skip


def contact_radii(best: ForceCurveFit) -> Array:
    """Contact radius [m] of every row, 0 where it is free."""
    values = best.model.values(best.x)
    return np.concatenate([best.model.contact_radii(part, values)[0] for part in best.model.stretches])


def outcome_of(best: ForceCurveFit, x: Array, body: FittedBody) -> dict[str, float]:
    """What the unknowns ``x`` mean, SI."""
    values = best.model.values(x)
    s = math.exp(values["ln_s"])
    last = best.model.stretches[-1]
    quantities = {"modulus": s}
    for part in best.model.stretches:
        quantities[WORKS[part.kind]] = values[f"q:{part.kind}"] * s
    tilt = values[f"tilt:{last.kind}"]
    P0 = values[f"offset:{last.kind}"] + tilt * (values["z0"] - last.z[0])
    if last.wave is not None:
        wave = Wave(math.exp(values["ln_period"]), last.wave.at, values[f"cos:{last.kind}"], values[f"sin:{last.kind}"])
        P0 += float(wave(np.array(values["z0"])))
    quantities |= {"delta0": values["z0"] - P0 / best.model.k, "P0": P0, "tilt": tilt}
    quantities |= {name: values[name] for name in best.model.positions}
    if last.wave is not None:
        quantities |= {"wave_period": wave.period, "wave_amplitude": math.hypot(wave.cos, wave.sin)}
    quantities |= best.model.further(values)
    return quantities | body.moduli(s)


def as_fit(
    body: FittedBody, record: ForceCurve, curve: Curve, settings: Settings, best: ForceCurveFit, pool: Pool | None
) -> Fit:
    """The fit of a ``curve`` as every fit gives it; ``record``: without the waves of its base lines."""
    values = outcome_of(best, best.x, body)
    dof = max(best.off.size - best.x.size, 1)
    t = t_quantile(settings.level, max(round(best.spread.dof / best.spread.tau), 1))
    fixed = {item.name for item in settings.parameters if not item.free and item.name in settings.named}
    intervals = _intervals(body, best, settings, values, fixed, t, pool)
    carried = _carried(body, best, settings, values)
    plain = (_resting(item, best, t) for item in intervals.estimates())
    estimates = tuple(wider(item, {key: change[item.name] for key, change in carried.items()}, t) for item in plain)
    if not best.ended:
        estimates = tuple(replace(item, error=None, low=None, high=None) for item in estimates)
    free = tuple(item.name for item in estimates if item.free and item.name != "E_star" and ":" not in item.name
                 and (item.error is not None or item.name != WORKS[RETRACT]))  # fmt: skip
    rows = np.concatenate([part.rows for part in best.model.stretches])
    a, order = contact_radii(best), np.argsort(rows)
    flags, quality = judgement(record, best, a)
    flags = {**record.flags, **flags}
    result = Fit(
        name=curve.name,
        file="" if curve.origin is None else str(curve.origin),
        where=curve.where,
        estimates=estimates,
        free=free,
        covariance=intervals.covariance_of(free) if best.ended else None,
        samples=intervals.sampled(free),
        data={"delta": curve.depth[rows[order]], "P": curve.load[rows[order]]},
        rows=rows[order],
        left_out=_left_out(record, rows.size),
        a=a[order],
        residuals=best.off[order][None] / best.sigma,
        scales={"P": best.sigma},
        scatter=1.0,
        dof=dof,
        structure=structure(best.off[a > 0]),
        line=_line(best),
        evaluations=best.least.steps,
        settings=settings,
        flags=tuple(flags),
        quality=quality,
        adhesion=_adhesion(record),
        directions=_directions(record, best, settings),
    )
    named = (f"{name}: {sentence}" for name, sentence in flags.items())
    at_bound = ["modulus"] * bool(np.isclose(values["modulus"], best.model.moduli, rtol=SAME).any())
    more = warnings_of(result, body, body.family, at_bound)
    return replace(result, warnings=(*named, *sentences(best, settings), *more))


def _carried(
    body: FittedBody, best: ForceCurveFit, settings: Settings, here: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """Changes of the outcome by the standard deviation of each uncertain input."""

    def outcome(name: str, value: float) -> dict[str, float]:
        if name in CALIBRATED:
            moved, model = body, best.model.calibrated(value, name == "stiffness")
        else:
            moved = body.with_values({name: value})
            model = replace(best.model, family=moved.family)
        refitted = fit(model, best.at_loads(value if name in CALIBRATED else 1.0), near=True, loss=settings.loss)
        return outcome_of(refitted, refitted.x, moved)

    centres = {name: 1.0 if name in CALIBRATED else body.nominal(name) for name in settings.uncertain}
    return {
        name: changes_by(name, centres[name], sigma, here, partial(outcome, name))
        for name, sigma in settings.uncertain.items()
    }


def _intervals(
    body: FittedBody, best: ForceCurveFit, settings: Settings, here: Mapping[str, float], fixed: Container[str],
    t: float, pool: Pool | None,
) -> Intervals:  # fmt: skip
    """What is known of the outcome ``here``, of which some are ``fixed``."""
    quantities = [_quantity(name, best) for name in here]
    fixed_values = {name: value for name, value in here.items() if name in fixed}

    def meaning(x: Array) -> dict[str, float]:
        outcome = outcome_of(best, x, body) | fixed_values
        return {item.name: item.inner(outcome[item.name]) for item in quantities}

    samples = None
    if settings.confidence == "bootstrap" and best.ended:
        cost = best.least.problem.converged
        samples = bootstrap(best.least, partial(_renewed, best), cost, settings.samples, settings.seed, pool)
    profiled = settings.confidence == "profile" and best.ended
    return Intervals(best.least, quantities, meaning, best.covariance, t, settings.level, profiled, samples=samples)


def _quantity(name: str, best: ForceCurveFit) -> Parameter:
    """Moduli by their logs, w as it may come out below 0, an advancing one before a rest by its signed root."""
    dimension, scale = DIMENSIONS.get(name, "modulus"), LINEAR
    if name == "modulus" or dimension == "modulus":
        scale = LOG
    elif dimension == "work":
        scale = ROOT if name == WORKS[APPROACH] and f"r:{APPROACH}" in best.names else LIMIT
    return Parameter(name, True, scale=scale, quantity=dimension, follows=dimension == "modulus")


def _resting(item: FittedValue, best: ForceCurveFit, t: float) -> FittedValue:
    """The estimate; w of an edge that rests throughout is a lower bound: what its last row holds, less ``t`` of its
    standard errors."""
    if item.name != WORKS[RETRACT] or f"q:{RETRACT}" not in best.model.known:
        return item
    low = max(item.value - t * _error_of_held(best), 0.0)
    return FittedValue(item.name, item.value, True, item.dimension, None, low)


def _error_of_held(best: ForceCurveFit) -> float:
    """The standard error of the w that the last row of an edge that rests throughout holds, by those of the others."""

    def held(x: Array) -> float:
        values = best.model.values(x)
        return math.exp(values["ln_s"]) * (held_by_last_row(best.model, values) or 0.0)

    steps = np.diag([best.error(name) for name in best.names])
    rates = np.array([(held(best.x + step) - held(best.x - step)) / (2 * step.sum() or 1.0) for step in steps])
    return math.sqrt(max(float(rates @ best.covariance @ rates), 0.0))


def _renewed(best: ForceCurveFit, rng: np.random.Generator) -> Callable[[State], State]:
    """Records that the model and the noise of the free rows may have made: residuals as they are, with other noise."""
    rows = best.model.rows - best.model.rows.min()
    noise = best.spread.noise.drawn(rng, int(rows.max()) + 1)[rows]
    other = best.model.whitened(noise, best.weight) - best.least.state.residuals
    return lambda state: state.moved(other)


def _line(best: ForceCurveFit) -> dict[str, Array]:
    """The fitted readings in one stroke, in by the first direction and out by the second: a, delta and P."""
    model = np.concatenate([part.P for part in best.model.stretches]) + best.off
    z = np.concatenate([part.z for part in best.model.stretches])
    rows = np.arange(z.size)
    first = best.model.stretches[0].z.size  # each direction goes from its far end inwards
    order = np.concatenate([rows[:first], rows[first:][::-1]])
    columns = {"a": contact_radii(best), "delta": z - model / best.model.k, "P": model}
    return {name: values[order] for name, values in columns.items()}


def _left_out(record: ForceCurve, used: int) -> tuple[str, ...]:
    spikes = record.spikes.size
    rest = len(record.curve) - used - spikes
    return (
        *[f"{rest} rows of other segments, next to the turning point or in jumps"] * (rest > 0),
        *[f"{spikes} {'isolated outliers' if spikes > 1 else 'isolated outlier'}"] * (spikes > 0),
    )


def _directions(record: ForceCurve, best: ForceCurveFit, settings: Settings) -> str:
    """Which directions were fitted, and why another one was not."""
    kinds = [part.kind for part in best.model.stretches]
    if len(kinds) > 1:
        return f"{APPROACH} and {NAMES[RETRACT]}"
    other = RETRACT if kinds[0] == APPROACH else APPROACH
    why = f" ({NAMES[other]}: {reason_not(record, other)})" if settings.segment in (None, "both") else ""
    return f"{NAMES[kinds[0]]} alone{why}"


def _adhesion(record: ForceCurve) -> float | None:
    """The adhesion force of the retraction [N]."""
    side = record.direction(RETRACT)
    return None if side is None else known(side.adhesion)

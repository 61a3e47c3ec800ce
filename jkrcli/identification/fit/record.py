"""Raw force curves: the fit of a whole record as the result that every fit gives."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...base.arrays import Array
from ...base.errors import InputError, SolveError
from ...base.unknown import Unknown, known
from ...data.measured import Curve
from ...data.measured.curve import APPROACH, RETRACT
from ...data.record import ForceCurve, examine
from .body import FittedBody
from .checks import warnings_of
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel, branch, fit, start, stretches
from .result import Fit, FittedValue
from .settings import Settings
from .statistics import structure, t_quantile


@dataclass(frozen=True)
class WholeRecordTuning:
    """When a record is taken as a whole, and how far its body must reach."""

    free_rows: int = 20  # choice: least rows of a base line
    room: float = 1.05  # choice: of the largest contact radius, to which the body is solved anew
    ahead: float = 4.0  # choice: of log a beyond the series, how far it may be continued to find a start
    deep: float = 0.7  # choice: of the tip's radius, to which a body is solved before anything is fitted
    rounds: int = 3  # choice: solves to larger radii before the record is given up
    misfit: float = 0.03  # choice: residual over the range of the load above which the model does not describe it
    noisy: float = 0.1  # choice: noise over the range of the load above which little can be told
    vague: float = 0.1  # choice: error of the contact point over the depth above which it is not determined
    spoilt: float = 0.1  # choice: factor of the quality for each thing that is wrong with the record itself
    dependent: float = 2.0  # choice: rows worth one above which it is said
    untold: float = 10.0  # choice: half-width of the log of a modulus above which it is not told by the data
    step: float = 1e-6  # choice: of unknowns, for central differences; outcomes are smooth in them


TUNING = WholeRecordTuning()
ASKED = frozenset({"modulus", "w", "delta0", "P0"})  # parameters of a whole record; others need prepared readings


def whole_record(curve: Curve, settings: Settings) -> ForceCurve | None:
    """The record taken apart, where base line and contact are to be fitted together; None: the readings as they are.

    By itself that is so for records of a device whose deflection is known, or of both directions with a base line each.
    """
    if settings.contact in ("as-is", "estimate") or curve.a is not None or curve.delta is None or curve.P is None:
        return None
    reason = _in_the_way(settings)
    if settings.contact == "auto" and reason:
        return None
    if reason:
        raise InputError(f"--contact fitted: {reason}: prepare the readings, --contact as-is or estimate")
    try:
        record = examine(curve)
    except InputError:
        if settings.contact == "fitted":
            raise
        return None
    return record if settings.contact == "fitted" or _raw(record) else None


def _raw(record: ForceCurve) -> bool:
    """Whether it is an instrument's record, and no prepared readings: a base line is there, or no contact at all."""
    usable = [kind for kind in (APPROACH, RETRACT) if _usable(record, kind)]
    if len(usable) > 1 or (usable and record.curve.stiffness is not None):
        return True
    return len(record.directions) > 1 and bool({"no contact", "no force curve"} & set(record.flags))


def _in_the_way(settings: Settings) -> str:
    """What a whole record cannot be fitted with; "" where nothing is."""
    if others := {p.name for p in settings.parameters if p.free} - ASKED:
        return f"{sorted(others)[0]} is free"
    if any(p.value for p in settings.parameters if not p.free and p.name != "modulus"):
        return "a zero point, w or the compliance is fixed at a value other than 0"
    if any(math.isfinite(p.low) or math.isfinite(p.high) for p in settings.free):
        return "a parameter has bounds"
    if settings.loss != "linear" or settings.branch != "all" or settings.confidence != "covariance":
        return "it knows no other loss, branch or confidence than the default"
    return "inputs are uncertain" if settings.uncertain or settings.noise else ""


def _usable(record: ForceCurve, kind: str) -> bool:
    side = record.direction(kind)
    if side is None or isinstance(side.touch, Unknown):
        return False
    return side.begins_free and side.base.rows >= TUNING.free_rows


def fit_record(body: FittedBody, record: ForceCurve, settings: Settings) -> Fit:
    """Modulus, w, contact point and base lines of a whole record; InputError where it holds no contact."""
    curve = record.curve
    kinds = _kinds(record, settings)
    k = math.inf if curve.stiffness is None else curve.stiffness
    parts = stretches(record, kinds, k)
    w, modulus = settings.parameter("w"), settings.parameter("modulus")
    told = w is not None and w.free
    adhesive = tuple(told and _adheres(record, part.kind) for part in parts)
    known = {} if modulus is None or modulus.free else {"ln_s": math.log(modulus.value or 1.0)}
    found, body = None, _deep_enough(body, parts, k)
    for _ in range(TUNING.rounds):
        model = ForceCurveModel(body.family, k, parts, adhesive, known)
        found = fit(model, start(model)) if found is None else fit(model, found.x, near=True)
        reach = _contact_radii(found).max()
        if not body.extensible or reach <= body.series.a[-1]:
            break
        body = body.to_radius(TUNING.room * float(reach))
    assert found is not None
    if np.count_nonzero(_contact_radii(found)) <= len(found.names):
        raise SolveError("the curve that fits best has next to no row in contact")
    return _result(body, record, settings, found)


def _deep_enough(body: FittedBody, parts: Sequence[DirectionReadings], k: float) -> FittedBody:
    """The body solved to the contact radius that a record can reach at most, as its tip moves no deeper."""
    ways = ((part.z - part.P / k)[part.touching if part.jumped else slice(None)] for part in parts)
    depth = max(float(np.ptp(way)) for way in ways)
    u = np.linspace(body.family.low, body.family.high + TUNING.ahead, 200)
    reached = np.flatnonzero(body.family.at(u)[0][0] <= depth)
    R, a = body.problem.indenter.tip_radius, math.exp(u[reached[-1]]) if reached.size else 0.0
    a = min(a, TUNING.deep * R) if R is not None else a
    return body.to_radius(a) if body.extensible and a > body.series.a[-1] else body


def _adhesion(record: ForceCurve) -> float | None:
    """The adhesion force of the retraction [N]."""
    side = record.direction(RETRACT)
    return None if side is None else known(side.adhesion)


def _kinds(record: ForceCurve, settings: Settings) -> tuple[str, ...]:
    """The directions to fit: as asked, else the retraction, else the approach."""
    wanted = {None: (RETRACT, APPROACH), "both": (APPROACH, RETRACT)}.get(settings.segment, (str(settings.segment),))
    held = tuple(kind for kind in wanted if _usable(record, kind))
    if not held:
        sides = {side.segment.kind: side.touch for side in record.directions}
        reasons = [f"{kind}: {sides.get(kind, 'not in the record')}" for kind in wanted]
        raise InputError(f"no direction can be fitted ({'; '.join(reasons)})")
    return held if settings.segment == "both" else held[:1]


def _adheres(record: ForceCurve, kind: str) -> bool:
    """Whether adhesion shows in a direction: a jump into contact, or tension on retraction."""
    side = record.direction(kind)
    assert side is not None
    return bool(side.jumps) if kind == APPROACH else not isinstance(side.adhesion, Unknown)


def _contact_radii(found: ForceCurveFit) -> Array:
    """Contact radius [m] of every row, 0 where it is free."""
    values = found.model.values(found.x)
    s, radii = math.exp(values["ln_s"]), []
    for part in found.model.stretches:
        q = values.get(f"q:{part.kind}", 0.0)
        held = branch(found.model.family, s, q, found.model.k)
        z = part.z - values["z0"]
        touching = part.touching if part.jumped else z > held.fold
        a = np.exp(np.interp(np.maximum(z, held.fold), held.z, held.u))
        radii.append(np.where(touching, a, 0.0))
    return np.concatenate(radii)


def _outcome(found: ForceCurveFit, x: Array, E_star: float) -> dict[str, float]:
    """What the unknowns ``x`` mean, SI."""
    values = found.model.values(x)
    s = math.exp(values["ln_s"])
    last = found.model.stretches[-1]
    told = {"modulus": s}
    for part in found.model.stretches:
        name = "w" if part is last else f"w_{part.kind}"
        told[name] = values.get(f"q:{part.kind}", 0.0) * s
    tilt = values[f"tilt:{last.kind}"]
    P0 = values[f"offset:{last.kind}"] + tilt * (values["z0"] - last.z[0])
    told |= {"delta0": values["z0"] - P0 / found.model.k, "P0": P0, "tilt": tilt, "E_star": s * E_star}
    return told


DIMENSIONS = {"modulus": "number", "delta0": "length", "P0": "load", "tilt": "stiffness", "E_star": "modulus"}


def _result(body: FittedBody, record: ForceCurve, settings: Settings, found: ForceCurveFit) -> Fit:
    curve, E_star = record.curve, body.problem.E_star
    values = _outcome(found, found.x, E_star)
    sizes = np.maximum(np.abs(found.x), np.sqrt(np.diag(found.covariance)))
    curved = [name == "ln_s" or name.startswith("q:") for name in found.names]  # all others are linear in the outcome
    steps = TUNING.step * np.where(curved, np.abs(found.x), sizes)
    rates = np.zeros((len(values), found.x.size))
    for i, step in enumerate(steps):
        unit = step * (np.arange(found.x.size) == i)
        high, low = _outcome(found, found.x + unit, E_star), _outcome(found, found.x - unit, E_star)
        rates[:, i] = [(high[name] - low[name]) / (2 * step) for name in values]
    covariance = rates @ found.covariance @ rates.T
    names = list(values)
    dof = max(found.off.size - found.x.size, 1)
    t = t_quantile(settings.level, max(round(dof / found.tau), 1))
    estimates = tuple(
        _estimate(name, values[name], math.sqrt(max(covariance[i, i], 0.0)), t) for i, name in enumerate(names)
    )
    free = tuple(item.name for item in estimates if item.free and item.name != "E_star")
    rows = np.concatenate([part.rows for part in found.model.stretches])
    a = _contact_radii(found)
    order = np.argsort(rows)
    assert curve.delta is not None
    assert curve.P is not None
    held = [names.index(name) for name in free]
    data = {"delta": curve.delta[rows[order]], "P": curve.P[rows[order]]}
    result = Fit(
        name=curve.name,
        file="" if curve.origin is None else str(curve.origin),
        where=curve.where,
        estimates=estimates,
        free=free,
        covariance=covariance[np.ix_(held, held)],
        samples=None,
        data=data,
        rows=rows[order],
        left_out=_left_out(record, rows.size),
        a=a[order],
        residuals=found.off[order][None] / found.sigma,
        scales={"P": found.sigma},
        scatter=1.0,
        dof=dof,
        structure=structure(found.off[a > 0]),
        line=_line(found),
        evaluations=found.evaluations,
        settings=settings,
        warnings=(),
        flags=tuple(record.flags),
    )
    flags, quality = _judged(record, found, a)
    result = replace(
        result, adhesion=_adhesion(record), flags=tuple(dict.fromkeys([*record.flags, *flags])), quality=quality
    )
    said = [f"{name}: {sentence}" for name, sentence in {**record.flags, **flags}.items()]
    return replace(result, warnings=(*said, *_words(found), *warnings_of(result, body, body.family)))


def _estimate(name: str, value: float, error: float, t: float) -> FittedValue:
    """An estimate with its interval: of moduli in the logarithm, of w not below 0."""
    dimension = DIMENSIONS.get(name, "work")
    if error == 0:
        return FittedValue(name, value, False, dimension)
    if name in ("modulus", "E_star") and t * error > TUNING.untold * value:
        return FittedValue(name, value, True, dimension)  # the data do not tell it
    if name in ("modulus", "E_star"):
        spread = math.exp(min(t * error / value, 700.0))
        return FittedValue(name, value, True, dimension, error, value / spread, value * spread)
    low = value - t * error
    return FittedValue(name, value, True, dimension, error, max(low, 0.0) if dimension == "work" else low,
                       value + t * error)  # fmt: skip


def _line(found: ForceCurveFit) -> dict[str, Array]:
    """The fitted readings along each direction, from the far end inwards: a, delta and P."""
    model = np.concatenate([part.P for part in found.model.stretches]) + found.off
    z = np.concatenate([part.z for part in found.model.stretches])
    return {"a": _contact_radii(found), "delta": z - model / found.model.k, "P": model}


def _left_out(record: ForceCurve, used: int) -> tuple[str, ...]:
    rest = len(record.curve) - used
    return (f"{rest} rows of other segments, next to the turning point or in jumps",) if rest else ()


def _judged(record: ForceCurve, found: ForceCurveFit, a: Array) -> tuple[dict[str, str], dict[str, float]]:
    """Flags of the fit itself with a sentence each, and the parts of its quality, each between 0 and 1.

    Each part is exp(-x^2/2) of a number x that is 1 where its flag is raised: misfit (slow residuals in contact over
    the range of the load), noise (over the range), base line (waviness over the range), contact (error of the contact
    point over the depth); "record" is ``spoilt`` for each flag of the record itself but that of a missing direction.
    ``quality`` is their product.
    """
    touching = a > 0
    span = max(float(np.ptp(part.P)) for part in found.model.stretches)
    off = found.off[touching]
    noise = max(record_side.base.noise for record_side in record.directions)
    slow = math.sqrt(max(float(np.mean(off**2)) - noise**2, 0.0)) / span if off.size else 0.0
    depth = max(part.reach for part in found.model.stretches)
    contact = found.error("z0") / depth if "z0" in found.names else 0.0
    wavy = max(side.base.waviness for side in record.directions) / span
    flags = {}
    if slow > TUNING.misfit:
        flags["misfit"] = f"the residuals in contact are {slow:.1%} of the range of the load: another body or indenter"
    if noise / span > TUNING.noisy:
        flags["noisy"] = f"the noise is {noise / span:.0%} of the range of the load"
    if contact > TUNING.vague:
        flags["vague contact point"] = f"known to {contact:.0%} of the depth only"
    ratios = {"misfit": slow / TUNING.misfit, "noise": noise / span / TUNING.noisy, "base line": wavy / TUNING.misfit,
              "contact point": contact / TUNING.vague}  # fmt: skip
    parts = {name: math.exp(-(x**2) / 2) for name, x in ratios.items()}
    parts["record"] = TUNING.spoilt ** sum(not name.endswith((APPROACH, RETRACT)) for name in record.flags)
    return flags, {"quality": math.prod(parts.values()), **parts}


def _words(found: ForceCurveFit) -> Iterator[str]:
    """How the record was taken, and what its residuals did to the intervals."""
    for part, adhesive in zip(found.model.stretches, found.model.adhesive, strict=True):
        if not adhesive:
            what = "no jump into contact" if part.kind == APPROACH else "no tension above the noise"
            yield f"{part.kind}: {what}, w is taken as 0"
    if found.tau > TUNING.dependent:
        yield (
            f"residuals follow their neighbours: {found.tau:.1f} rows count as one, "
            f"which widens the intervals by {math.sqrt(found.tau):.1f}"
        )

"""The fit of a whole raw record, and of its directions alone where one modulus does not describe both."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import MOST_SOLVES, InputError, Pool, SolveError, show
from ...data import APPROACH, RETRACT, Curve, ForceCurve
from ...methods.radii import ROOM
from ..parameters import Parameter
from .body import FittedBody
from .force_curve import ForceCurveModel, base_line
from .force_curve_fit import TUNING as SEARCH
from .force_curve_fit import ForceCurveFit, Neighbour, fit, nearest, windowed
from .force_curve_readings import DirectionReadings, stretches
from .interference import Wave, straightened
from .one_more import another_modulus
from .record_flags import NAMES
from .record_flags import TUNING as FLAGS
from .record_result import as_fit, contact_radii, outcome_of
from .record_verdict import by_rivals, judged
from .result import Fit
from .settings import AUTO, Settings
from .whole_record import directions_of, requested, usable, whole_record


@dataclass(frozen=True)
class RecordTuning:
    """When one modulus does not describe both directions, or the rows determine none."""

    placed_rows: float = 0.05  # choice: of the loads' relative scatter, that of positions which have none
    apart: float = 4.0  # choice: standard errors between the moduli of the two directions from which on they differ
    undetermined: float = 1.0  # theory: of ln E*, a standard error with which 95 % span a factor of fifty
    differs: float = 0.01  # choice: of a modulus, or of the way of a device in contact, a difference that is none


TUNING = RecordTuning()


def fit_record(
    body: FittedBody, record: ForceCurve, settings: Settings, pool: Pool | None = None, before: Neighbour | None = None
) -> Fit:
    """Modulus, w, contact point and base lines of a whole record; InputError where it holds no contact.

    Where one modulus does not describe both directions, the retraction's answer with that of the approach beside it.
    ``pool``: for the samples of its bootstrap; ``before``: the record from whose end its search begins.
    """
    before = before or Neighbour()
    if (reason := record.flags.get("no contact")) is not None:
        raise InputError(f"{record.curve.where}: no contact: {reason}")
    curve = record.curve
    record, waves = straightened(record) if settings.base_line == "sine" else (record, {})
    body = _with_known(body, settings)
    kinds = directions_of(record, settings)

    def of(*kinds: str) -> tuple[FittedBody, ForceCurveFit]:
        return _fitted(body, _model(body, record, settings, waves, kinds), settings, before)

    def result_of(body: FittedBody, best: ForceCurveFit) -> Fit:
        return as_fit(body, record, curve, settings, best, pool)

    whole, joint = of(*kinds)
    if not joint.ended:
        return result_of(whole, joint)
    _refuse_undetermined(curve, joint)
    before.last = joint
    plain = judged(_of_directions(of, result_of, whole, joint), whole, joint)
    if settings.model != AUTO:
        return plain
    fresh = _model(whole, record, settings, waves, kinds)
    return by_rivals(plain, whole, joint, fresh, partial(result_of, whole))


def _refuse_undetermined(curve: Curve, joint: ForceCurveFit) -> None:
    """InputError where the rows determine no modulus."""
    if "ln_s" not in joint.names or (error := joint.error("ln_s")) <= TUNING.undetermined:
        return
    times = f"{error:.2g}" if error < 1000 else "more than 1000"
    other = "fit both directions, or " if len(joint.model.stretches) == 1 else ""
    reason = f"the rows in contact do not tell it from w and the zero: {other}fix w (--fix w=...)"
    model, part = joint.model, joint.model.stretches[-1]
    values = model.values(joint.x)
    reach = model.k * float(model.depth(part, values).max())
    if math.isfinite(model.k) and float((part.P - base_line(part, values)[0]).max()) > (1 - TUNING.differs) * reach:
        reason = (
            f"beside a device of {show(model.k, 'stiffness')} the specimen is rigid: check --stiffness and the units"
        )
    raise InputError(f"{curve.where}: E* is not determined, its standard error is {times} times itself: {reason}")


def _of_directions(
    of: Callable[..., tuple[FittedBody, ForceCurveFit]], result_of: Callable[[FittedBody, ForceCurveFit], Fit],
    whole: FittedBody, joint: ForceCurveFit,
) -> Fit:  # fmt: skip
    """The fit of both directions by one modulus, or each by its own where they differ."""
    result = result_of(whole, joint)
    if len(joint.model.stretches) < 2 or joint.model.positions or not _apart(joint):
        return result  # one direction alone tells no error of positions
    (_, into), (deeper, back) = of(APPROACH), of(RETRACT)
    error = math.hypot(*(one.error("ln_s") * one.spread.excess for one in (into, back)))
    if not differ(math.exp(into.value("ln_s")), math.exp(back.value("ln_s")), error):
        return result
    return beside(result_of(deeper, back), result_of(deeper, into), result)


def whole_fit(body: FittedBody, record: ForceCurve, settings: Settings) -> ForceCurveFit:
    """What leaves least of all directions of a record."""
    record, waves = straightened(record) if settings.base_line == "sine" else (record, {})
    body = _with_known(body, settings)
    return _fitted(body, _model(body, record, settings, waves, directions_of(record, settings)), settings)[1]


def _with_known(body: FittedBody, settings: Settings) -> FittedBody:
    """The body with the known values of its layers."""
    return body.with_values({p.name: float(p.value) for p in settings.parameters if p.of_body and p.value is not None})


def receding(body: FittedBody, curve: Curve, settings: Settings) -> Curve:
    """The rows of a raw record's last direction on which the edge of the contact moves, less the base line and from the
    zero that fit best; a curve that is no raw record, or has no base line, as it is."""
    record = whole_record(curve, settings)
    if record is None or not any(usable(record, kind) for kind in requested(settings)):
        return curve
    _, best = _fitted(body, _model(body, record, settings, {}, directions_of(record, settings)), settings)
    curve = _in_contact(best, curve, best.model.stretches[-1:], still=False)
    return replace(curve, delta=curve.depth - curve.load / best.model.k)


def _in_contact(best: ForceCurveFit, curve: Curve, parts: Sequence[DirectionReadings], still: bool = True) -> Curve:
    """The rows in contact of some stretches, those on which the edge is ``still`` too, in order of recording: net load
    over the position of the device from first touch."""
    values, each = best.model.values(best.x), []
    for part in parts:
        a, rests = best.model.contact_radii(part, values)
        chosen = (a > 0) & (still | ~rests)
        depth, P = best.model.depth(part, values), part.P - base_line(part, values)[0]
        each.append((part.rows[chosen], depth[chosen], P[chosen], np.full(np.count_nonzero(chosen), part.kind)))
    rows, delta, P, words = (np.concatenate(columns) for columns in zip(*each, strict=True))
    order = np.argsort(rows)
    return replace(curve.rows(rows[order]), delta=delta[order], P=P[order], segment=words[order], stiffness=None)


def reduced(body: FittedBody, record: ForceCurve, settings: Settings) -> tuple[Curve, Settings]:
    """The rows of a raw record that are in contact, less the base lines and from the zero that fit best, for what its
    model does not know, and the settings by which they are fitted: the device is a compliance that is known, positions
    have no scatter, what the zeros err by is fitted again."""
    usual = tuple(Parameter(name, True) for name in ("modulus", "w", "delta0"))
    plain = replace(settings, parameters=usual, named=frozenset(), noise={}, branch="all", loss="linear")
    best = whole_fit(body, record, plain)
    curve = _in_contact(best, record.curve, best.model.stretches)
    outcome = outcome_of(best, best.x, body)
    chosen = {p.name: p for p in settings.parameters if p.name in settings.named}
    fixed_zeros = {name for name in ("delta0", "P0") if name in chosen and not chosen[name].free}
    shift = {name: outcome[name] if name in fixed_zeros else 0.0 for name in ("delta0", "P0")}
    stiff = 0.0 if "compliance" in chosen else 1 / best.model.k
    delta = curve.depth - (1 / best.model.k - stiff) * curve.load + shift["delta0"]
    note = (
        f"the rows in contact alone are fitted, less the base lines of the whole record and from its zero, delta0 = "
        f"{show(outcome['delta0'], 'length', 5)} and P0 = {show(outcome['P0'], 'load', 5)}"
    )
    placed = TUNING.placed_rows * best.sigma * float(np.ptp(delta) / np.ptp(curve.load))
    placed = max(placed, best.sigma * (1 / best.model.k - stiff))
    fixed = {"compliance": Parameter("compliance", False, stiff)} | {"P0": Parameter("P0", True)}
    parameters = tuple(fixed.get(p.name, p) if p.name not in chosen else p for p in settings.parameters)
    curve = replace(curve, delta=delta, P=curve.load + shift["P0"], flags=(*curve.flags, note))
    noise = {"delta": placed, "P": best.sigma} | dict(settings.noise)
    return curve, replace(settings, parameters=parameters, noise=noise, contact="as-is", base_line="straight")


def _fitted(
    body: FittedBody, model: ForceCurveModel, settings: Settings, before: Neighbour | None = None
) -> tuple[FittedBody, ForceCurveFit]:
    """The model that fits best, and the body solved as far as it reaches."""
    for part in model.stretches:
        if part.z.size == 0:
            raise InputError(f"the {part.kind} has no row to fit: contact ends where it begins, or its signs are wrong")
        if np.ptp(part.z) == 0:
            raise SolveError(f"the {part.kind} has {part.z.size} rows to fit, all at one piezo position")
    body, best = _deep_enough(body, model), None
    for _ in range(MOST_SOLVES):
        model = replace(model, family=body.family)
        near = None if before is None else before.start(model)
        best = nearest(model, settings.loss, near) if best is None else _again(best, model, settings)
        reach = contact_radii(best).max()
        if not body.extensible or reach <= body.series.a[-1]:
            break
        body = body.to_radius(ROOM * float(reach))
    assert best is not None
    if np.count_nonzero(contact_radii(best)) <= len(best.names):
        raise SolveError("the curve that fits best has next to no row in contact; --flip P, if compression is negative")
    cut = windowed(best)
    best = best if cut is best.model else _again(best, replace(cut, known=model.known), settings)
    model = best.model
    zero_works = {kind: 0.0 for part in model.stretches if _repels(best, kind := part.kind)}
    return body, nearest(replace(model, works={**model.works, **zero_works}), settings.loss) if zero_works else best


def _again(best: ForceCurveFit, model: ForceCurveModel, settings: Settings) -> ForceCurveFit:
    """The fit of a ``model`` that differs a little from that of the ``best`` fit so far."""
    return fit(model, best.unknowns(model), True, settings.loss)


def _repels(best: ForceCurveFit, kind: str) -> bool:
    """Whether w of a direction comes out below 0 by more than noise and misfit explain: another body, w = 0 is as near
    as it can come."""
    name = next((name for name in (f"q:{kind}", f"r:{kind}") if name in best.names), None)
    return name is not None and best.value(name) < -FLAGS.sure * best.error(name) * best.spread.excess


def _apart(best: ForceCurveFit) -> bool:
    """Whether the data ask for another modulus on the way back than on the way in."""
    if "ln_s" not in best.names:
        return False
    if best.sigma > SEARCH.enough * best.model.noise:
        return True
    other = another_modulus(best)
    return differ(1.0, 1 + other.last, 0.0) and differ(1.0, 1 + other.last, other.error)


def beside(back: Fit, into: Fit, both: Fit) -> Fit:
    """The fit of the retraction with the estimates of the approach beside its own; ``both``: that of one modulus."""
    one, other = back.estimate("E_star"), into.estimate("E_star")
    name = "directions differ"
    sentence = (
        f"{name}: E* is {show(other.value, 'modulus', 4)} on approach and {show(one.value, 'modulus', 4)} on "
        "retraction, one value does not fit both: the specimen relaxes or yields, or the device drifts"
    )
    work, drifts = into.estimate("w_approach"), [line for line in both.warnings if line.startswith("drift")]
    quality = back.quality and {**back.quality, "quality": FLAGS.spoilt * back.quality["quality"]}
    return replace(
        back, estimates=(*back.estimates, replace(other, name="E_star_approach"), work), quality=quality,
        flags=(*back.flags, name), warnings=(sentence, *drifts, *back.warnings),
        directions=f"{NAMES[RETRACT]}, the approach beside it",
    )  # fmt: skip


def differ(into: float, back: float, error: float) -> bool:
    """Whether the moduli of two directions exclude each other, by the ``error`` of their relative difference."""
    return abs(back / into - 1) > max(TUNING.apart * error, TUNING.differs)


def _model(
    body: FittedBody, record: ForceCurve, settings: Settings, waves: Mapping[str, Wave], kinds: Sequence[str]
) -> ForceCurveModel:
    """The model of the directions ``kinds`` of a record, by the settings."""
    curve, w, modulus = record.curve, settings.known("w"), settings.known("modulus")
    parts = stretches(record, kinds, waves)
    works = {} if w.free else {part.kind: float(w.value or 0.0) for part in parts if part is parts[-1] or not w.value}
    known = {} if modulus.free else {"ln_s": math.log(modulus.value or 1.0)}
    for part in (part for part in parts if not part.line.rows):
        known |= {f"tilt:{part.kind}": 0.0} | ({} if settings.known("P0").free else {f"offset:{part.kind}": 0.0})
    if settings.positions and len(parts) < 2:
        which = settings.positions[0]
        raise InputError(f"{curve.where}: {which} needs approach and retraction together, only one can be fitted")
    errors = (settings.known(name) for name in settings.positions)
    known |= {item.name: item.value for item in errors if item.value is not None}
    k = math.inf if curve.stiffness is None else curve.stiffness
    moduli = (modulus.low, modulus.high)
    return ForceCurveModel(body.family, k, parts, known, works, moduli, settings.positions)


def _deep_enough(body: FittedBody, model: ForceCurveModel) -> FittedBody:
    """The body solved to the contact radius that a record can reach at most, as its tip moves no deeper."""
    ways = ((part.z - part.P / model.k)[part.touching if part.jumped else slice(None)] for part in model.stretches)
    return body.to_depth(max(float(np.ptp(way)) for way in ways))

"""Which further measurement would narrow E* and w most: another tip radius, largest load or thickness of the layer.

A measurement that is not yet made has a Fisher information already: that of the curve which the fitted values predict,
with as many rows and the noise of the one at hand, at the cost of its own zero points (their Schur complement); scaled
so that the measurement at hand, repeated, has the information that it has now. Added to what is known, it gives the
standard errors that both would have together, to first order.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...base import LOOKED_AT, UNSEEN, Array, InputError, JkrError, show
from ...bodies import RADIUS
from ...methods.radii import ROOM
from .body import FittedBody
from .family import ADVANCING, RECEDING, RESTING
from .model import Distances, FootPoints, Readings
from .points import COLUMNS
from .result import Fit, Further

WANTED = ("modulus", "w")
ZEROS = ("delta0", "P0")


@dataclass(frozen=True)
class PlanTuning:
    """Which measurements are proposed."""

    radii: tuple[float, ...] = (0.25, 0.5, 2.0, 4.0)  # choice: over that at hand
    factors: tuple[float, ...] = (0.3, 3.0)  # choice: loads and thicknesses over those at hand
    widest: float = 0.4  # choice: of a tip's radius, to which it is pressed at most


TUNING = PlanTuning()


def further(body: FittedBody, fit: Fit) -> tuple[Further, ...]:
    """The errors now, and those with the same measurement again and with others; InputError where the data do not
    determine E* and w."""
    if fit.covariance is None or not set(WANTED) <= set(fit.free) or fit.value("w") <= 0:
        raise InputError(f"{fit.where}: --plan: needs E* and w free and determined by the data")
    wanted = [fit.free.index(name) for name in WANTED]
    now = np.linalg.inv(fit.covariance[np.ix_(wanted, wanted)])
    largest = float(np.max(fit.line["P"][fit.line["a"] > 0])) - fit.value("P0")
    scale = np.linalg.cholesky(now) @ np.linalg.inv(np.linalg.cholesky(_information(body, fit, largest)))
    measurements = [_further("now", now, fit), _further("the same again", 2 * now, fit)]
    for words, changes, load in _candidates(body, fit, largest):
        with contextlib.suppress(JkrError):  # a body that cannot be solved is no proposal
            more = scale @ _information(body.with_values(dict(changes)), fit, load) @ scale.T
            measurements.append(_further(words, now + more, fit))
    return tuple(measurements)


def planned(body: FittedBody, fit: Fit) -> Fit:
    """The fit with the errors that further measurements would leave; a warning where they are not known."""
    try:
        return replace(fit, plan=further(body, fit))
    except InputError as error:
        return replace(fit, warnings=(*fit.warnings, str(error)))


def _candidates(body: FittedBody, fit: Fit, largest: float) -> Iterator[tuple[str, Mapping[str, float], float]]:
    """Measurements in words, changes of the body, and their largest load [N]."""
    for factor in TUNING.factors:
        yield f"largest load {show(factor * largest, 'load', 3)}", {}, factor * largest
    if not body.own_parameters:
        return
    if hasattr(body.problem.indenter, "R"):
        for factor in TUNING.radii:
            R = factor * body.nominal(RADIUS)
            yield f"tip radius {show(R, 'length', 3)}", {RADIUS: R}, largest
    for name in [name for name in body.own_parameters if name.startswith("h:")][:1]:
        h = next((item.value for item in fit.estimates if item.name == name), body.nominal(name))
        for factor in TUNING.factors:
            yield f"thickness {show(factor * h, 'length', 3)}", {name: factor * h}, largest


def _further(words: str, information: Array, fit: Fit) -> Further:
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    return Further(words, *(float(e) / fit.value(name) for e, name in zip(errors, WANTED, strict=True)))


def _information(body: FittedBody, fit: Fit, largest: float) -> Array:
    """Fisher information of modulus factor and w [SI] in a measurement on this ``body`` up to a load [N]."""
    columns = tuple(name for name in COLUMNS if name in fit.data)
    values = {item.name: item.value for item in fit.estimates} | dict.fromkeys(ZEROS, 0.0)
    both = "w_approach" in values and "w_approach" in fit.free
    own = [name for name in ZEROS if name in fit.free and not (name == "P0" and fit.quality)]  # of a base line
    body, ways = _ways(body, values, both, largest, int(np.count_nonzero(fit.a > 0)))
    values["a_turn"] = float(np.exp(ways[ADVANCING if both else RECEDING].max()))
    names, values = [*WANTED, *own, *["w_approach", "a_turn"] * both], {"compliance": 0.0} | values
    parts = [(Readings(body.family, names, values, columns, np.ones(len(columns)), None, edge), u)
             for edge, u in ways.items()]  # fmt: skip
    scales = _noise(fit, [part.along(u)[0] for part, u in parts], columns)
    feet = [_on_curve(replace(part, scales=scales), u) for part, u in parts]
    J = np.concatenate([Distances((part,)).jacobian(np.arange(len(names))) for part in feet])
    J[:, 0] /= values["modulus"]  # from its log
    size = np.linalg.norm(J, axis=0)
    whole = (J / size).T @ (J / size)
    cross = whole[:2, 2:]
    left: Array = (whole[:2, :2] - cross @ np.linalg.pinv(whole[2:, 2:]) @ cross.T) * np.outer(size[:2], size[:2])
    return left


def _noise(fit: Fit, rows: list[Array], columns: tuple[str, ...]) -> Array:
    """Standard deviations of the readings [SI]; of positions without scatter next to none."""
    noise = {name: scale * fit.scatter for name, scale in fit.scales.items()}
    spans = dict(zip(columns, np.ptp(np.concatenate(rows, axis=1), axis=1), strict=True))
    least = UNSEEN * max(noise.get(name, 0.0) / spans[name] for name in columns)
    return np.array([noise.get(name, least * spans[name]) for name in columns])


def _on_curve(readings: Readings, u: Array) -> FootPoints:
    """Rows that lie on the curve."""
    first = readings.along(u)[1]
    return FootPoints(readings, np.arange(u.size), u, np.zeros((1, u.size)), first / np.linalg.norm(first, axis=0))


def _ways(
    body: FittedBody, values: Mapping[str, float], both: bool, largest: float, rows: int
) -> tuple[FittedBody, dict[int, Array]]:
    """The body solved as far as it is pressed, and the places of rows even in displacement, for each thing that the
    edge does: in to the largest load and out to the pull-off under load, or out alone."""
    s, w = values["modulus"], values["w"]
    body, into = _branch(body, s, values["w_approach"] if both else w, largest)
    if not both:
        return body, {RECEDING: _even(body, s, w, into, rows)}
    turn, (D, T, _, _) = into[1], body.family.at(into[1:])[0][:, 0]
    unit, ends = float(D / T), [math.sqrt(values[name] / s) for name in ("w_approach", "w")]
    out = (_branch(body, s, w, largest)[1][0], turn)
    spans = [float(T) * abs(ends[1] - ends[0]), float(np.ptp(_delta(body, s, w, np.array(out))))]
    still = max(round(rows / 2 * spans[0] / sum(spans)), 2)
    ways = {ADVANCING: _even(body, s, values["w_approach"], into, rows // 2)}
    ways[RESTING] = np.linspace(ends[0], ends[1], still) / unit
    return body, ways | {RECEDING: _even(body, s, w, out, max(rows // 2 - still, 2))}


def _branch(body: FittedBody, s: float, w: float, largest: float) -> tuple[FittedBody, Array]:
    """The body solved as far as it is pressed, and the logs of the contact radii at pull-off under load and there."""
    R = body.problem.indenter.tip_radius
    for _ in range(2):
        high = math.log(TUNING.widest * R) if R is not None and body.extensible else body.family.high
        u = np.linspace(min(body.family.low, high - 5), high, LOOKED_AT)
        P = body.family.member({"modulus": s, "w": w}).along(u)[0][2]
        low = int(np.argmin(P))
        end = float(np.interp(largest, P[low:], u[low:]))
        if not body.extensible or end <= body.family.high:
            break
        body = body.to_radius(ROOM * math.exp(end))
    return body, np.array([u[low], end])


def _delta(body: FittedBody, s: float, w: float, u: Array) -> Array:
    return body.family.member({"modulus": s, "w": w}).along(u)[0][1]


def _even(body: FittedBody, s: float, w: float, ends: Sequence[float] | Array, rows: int) -> Array:
    """Logs of contact radii of so many rows, even in displacement."""
    u = np.linspace(ends[0], ends[1], LOOKED_AT)
    delta = _delta(body, s, w, u)
    return np.interp(np.linspace(delta[0], delta[-1], rows), delta, u)

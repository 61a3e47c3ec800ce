"""The search for the minimum: starts, bodies whose layers vary, and radii that the data reach."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping

import numpy as np

from ...base.errors import InputError, JkrError
from ...base.units import show
from ...series import Array
from .body import Body
from .distances import arc
from .model import Readings
from .points import Points, scatter
from .settings import Settings
from .solve import Minimum, Objective, fixed_at, minimise
from .start import Known, Start, starts
from .statistics import robust_scale

NEAR, FAR, ALIEN = 1e-3, 0.1, 0.5  # of the size of the curve: next to nothing, much, no fit at all
NOISE = 2.0  # standard deviations of the readings: residuals that leave nothing to explain
BEYOND, FAR_BEYOND = 1.02, 1.3  # how far the data may reach beyond a series, as noise does, and starts may
ROOM, LEAST_USED = 1.25, 0.5  # of the radii that the data reach: how far a body is solved anew, and when
SOLVES = 5
ON_THE_FLOOR, TRIED = 8, 4  # starts that are looked at closely, and followed to the end
# Factors of nominal values, where one or two parameters of layers are free; of more only the nominal values.
SCANNED: dict[int, dict[str, tuple[float, ...]]] = {
    1: {"E": (0.05, 0.2, 1.0, 4.0, 16.0), "h": (0.2, 0.45, 1.0, 2.2, 5.0)},
    2: {"E": (0.1, 1.0, 10.0), "h": (0.3, 1.0, 3.0)},
}
Tried = list[tuple[dict[str, float], Start]]


def search(body: Body, points: Points, settings: Settings) -> Minimum:
    """The best fit, on the body solved anew to other radii where the data ask for it and it may be.

    InputError where no curve of the body comes near the data, or where they leave the radii of its series.
    """
    body = _among_radii(body, points)
    for _ in range(SOLVES):
        tried = _starts(body, points, settings)
        high = float(body.series.a[-1])
        if body.extensible and tried[0][1].reach > high * FAR_BEYOND:
            body = body.to_radius(ROOM * tried[0][1].reach)
            continue
        minimum = _best(body, points, settings, tried)
        reach = float(np.exp(minimum.found.u.max()))
        if not body.extensible or LEAST_USED * high <= reach <= high * BEYOND:
            break
        body = body.to_radius(ROOM * reach)
    else:
        minimum = _best(body, points, settings, _starts(body, points, settings))
    u = minimum.found.u
    _check_reach(minimum.objective.body, float(np.exp(u.min())), float(np.exp(u.max())))
    return minimum


def _among_radii(body: Body, points: Points) -> Body:
    """The body with a series that reaches the measured radii, where most of them lie far outside it.

    InputError where it may not be solved anew: starts would be sought where the series says nothing.
    """
    if "a" not in points.columns:
        return body
    least, middle, most = (float(a) for a in np.quantile(points.values["a"], (0.0, 0.5, 1.0)))
    low, high = (float(a) for a in body.series.a[[0, -1]])
    if low / FAR_BEYOND <= middle <= high * FAR_BEYOND:
        return body
    if body.extensible:
        return body.to_radius(ROOM * most)
    _check_reach(body, least, most)
    return body


def _check_reach(body: Body, least: float, reach: float) -> None:
    """The contact radii of the data lie within those of the series, but for noise."""
    low, high = (float(a) for a in body.series.a[[0, -1]])
    if low / BEYOND <= least and reach <= high * BEYOND:
        return
    end, remedy = (high, "load further") if reach > high * BEYOND else (low, "begin at smaller radii")
    raise InputError(
        f"the data reach contact radii of {show(least, 'length')} to {show(reach, 'length')}, the series ends at "
        f"{show(end, 'length')}: {remedy}, or fit with the case file; or units or signs are wrong"
    )


def _best(body: Body, points: Points, settings: Settings, tried: Tried) -> Minimum:
    """The minimum from the nearest start; where it stays far from the data the lowest of those from all starts.

    Starts are those found in the data and, where given, the user's. InputError where all stay far.
    """
    unknowns = [_unknowns(settings, values, start) for values, start in tried[:ON_THE_FLOOR]]
    sizes = _sizes(body, tried[0][0], points, settings, unknowns[0])
    scales = scatter(points.values, sizes) | dict(settings.noise)
    objective = Objective(body, settings.parameters, points, np.array([scales[name] for name in points.columns]))
    if any(p.value is not None for p in settings.free):
        unknowns.append(_from_user(settings, unknowns[0]))
    far = max(scales[name] / sizes[name] for name in points.columns)
    found: list[Minimum] = []
    for x in _on_the_floor(objective, unknowns)[:TRIED]:
        minimum = minimise(objective, x)
        found.append(minimum)
        if _is_good(minimum, far):
            break
    minimum = min(found, key=lambda item: item.cost)
    distance = far * robust_scale(minimum.found.residuals)
    if distance > ALIEN:
        raise InputError(
            f"no curve of this body comes nearer to the data than {distance:.2g} of its size: "
            "check units, signs, zero points, the indenter and the layers"
        )
    return minimum


def _is_good(minimum: Minimum, far: float) -> bool:
    """Whether the residuals are those of the noise, where that is known, or next to nothing; else others are tried.

    ``far``: the scales in sizes of the curve, 1 where the record did not tell the noise.
    """
    distance = robust_scale(minimum.found.residuals)
    return distance * far < NEAR or (distance < NOISE and far < FAR)


def _from_user(settings: Settings, x: Array) -> Array:
    """Unknowns with the user's starting values, where there are any, in place of those found."""
    pairs = zip(settings.parameters, x, strict=True)
    return np.array([v if p.value is None else p.inner(p.value) for p, v in pairs])


def _on_the_floor(objective: Objective, unknowns: list[Array]) -> list[Array]:
    """Starts sorted by their cost; where layers vary, after the other parameters were fitted with the layers held."""
    own = [p for p in objective.parameters if p.of_body and p.free]
    others = [p for p in objective.parameters if not p.of_body and p.free]
    costs = []
    for i, x in enumerate(unknowns):
        if own and others:
            held = objective
            for p in own:
                held = fixed_at(held, p.name)
            minimum = minimise(held, x)
            unknowns[i] = minimum.x
            costs.append(minimum.cost)
        else:
            costs.append(float(np.sum(objective.distances(x, rated=False).residuals ** 2)))
    return [unknowns[i] for i in np.argsort(costs)]


def _starts(body: Body, points: Points, settings: Settings) -> Tried:
    """Values of the body's own parameters with starts for the others, best first."""
    known = Known(**{p.name: p.value for p in settings.parameters if not p.of_body and not p.free})
    tried = []
    reason: JkrError | None = None
    for values in _bodies(body, settings):
        try:
            family = body.with_values(values).family if values else body.family
            tried += [(values, start) for start in starts(family, points, known, body.extensible)]
        except JkrError as error:
            reason = error
    if not tried:
        assert reason is not None
        raise reason
    return sorted(tried, key=lambda item: item[1].cost)


def _bodies(body: Body, settings: Settings) -> Iterator[dict[str, float]]:
    """Values of the body's own parameters to begin with: the fixed ones, and around the nominal of the free ones."""
    own = [p for p in settings.parameters if p.of_body]
    fixed = {p.name: float(p.value) for p in own if not p.free and p.value is not None}
    free = [p for p in own if p.free]
    factors = (SCANNED[len(free)][p.name[0]] if len(free) in SCANNED else (1.0,) for p in free)
    for chosen in itertools.product(*factors):
        values = {p.name: body.nominal(p.name) * factor for p, factor in zip(free, chosen, strict=True)}
        if all(p.low <= values[p.name] <= p.high for p in free) or set(chosen) == {1.0}:
            yield fixed | {p.name: float(np.clip(values[p.name], p.low, p.high)) for p in free}


def _unknowns(settings: Settings, values: Mapping[str, float], start: Start) -> Array:
    found = {name: getattr(start, name) for name in ("modulus", "w", "delta0", "P0", "compliance")} | dict(values)
    return np.array([
        p.inner(found[p.name] if p.free or p.value is None else p.value) for p in settings.parameters
    ])  # fmt: skip


def _sizes(body: Body, values: Mapping[str, float], points: Points, settings: Settings, x: Array) -> dict[str, float]:
    """The size of the start's curve on each axis: its pull-off, or a part of the data's range where that is larger."""
    family = body.with_values(dict(values)).family if values else body.family
    readings = Readings(family, settings.parameters, x, points.columns, np.ones(len(points.columns)))
    offsets = {"delta": readings.value("delta0"), "P": readings.value("P0")}
    curve = readings.along(arc(readings))[0]
    return {
        name: max(offsets.get(name, 0.0) - float(np.min(row)), 0.05 * float(np.ptp(points.values[name])))
        for name, row in zip(points.columns, curve, strict=True)
    }

"""Many records fitted together: unknowns that all of them share, such as E* and w, and those that each has for itself.

Each record is fitted alone first. Then all are searched at once, the unknowns of each by those of all; each in units of
its own noise as its own covariance states it, so that records of other instruments, kinds and noise weigh as they may.
What a record is fitted with besides, and what is drawn of it, is its own fit with the shared values fixed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..base.errors import LEVEL, InputError, did_you_mean
from ..base.numerics import MOST_STEPS, ROUNDED, Array
from ..bodies.problem import RADIUS
from .curve import Curve
from .forward_model import FittedBody, for_each
from .least_squares import STATISTICS_IMPROBABLE, Intervals, Least, LeastSquares, State, covariance
from .lockstep import alone
from .parameters import ALIAS, LOG, Answer, FittedValue, Parameter, Unknowns, word
from .procedure import fit, preparing, spread_of
from .record import whole_fit
from .result import Fit
from .rows import robust, search
from .segmentation import ForceCurve
from .settings import Settings


def shared_of(names: Iterable[str], own: Iterable[str], settings: Settings) -> tuple[str, ...]:
    """The shared parameters by their own names; InputError where one is not free, or every record's own as well."""
    free = [p.name for p in settings.free]
    shared, unshared = (["modulus" if name == ALIAS else name for name in group] for group in (names, own))
    for option, group in (("shared", shared), ("own", unshared)):
        if unknown := [name for name in group if name not in free]:
            hint = did_you_mean(unknown[0], free)
            raise InputError(f"fit: --{option} {unknown[0]}: is not free{hint} (free: {', '.join(free)})")
    if both := set(shared) & set(unshared):
        raise InputError(f"fit: {min(both)} is both in --shared and in --own: leave it out of one")
    if left := [name for name in free if unshared and name not in (*shared, *unshared)]:
        raise InputError(f"fit: --own: {left[0]} is free too: name it in --shared or in --own")
    return tuple(dict.fromkeys(shared))


def with_radii(body: FittedBody, radii: Sequence[float], count: int) -> list[FittedBody]:
    """The body under the tip radius [m] of each of ``count`` files."""
    each = for_each(radii, count)
    if each and not (hasattr(body.problem.indenter, "R") and body.own_parameters):
        raise InputError("fit: --tip-radius: needs a sphere or a paraboloid on a specimen without an outer radius")
    return [body.with_values({RADIUS: R}) for R in each] or [body] * count


@dataclass(frozen=True, eq=False)
class Part:
    """A record's own ``least``, with the ``names`` of its unknowns, of those that may be shared as all call them, and
    their ``units``; ``noise``: variance of its residuals that its covariance rests on; ``counted``: where works are
    counted in moduli, the factor of these if it is known; 0 where they are not."""

    where: str
    least: Least
    names: tuple[str, ...]
    units: Mapping[str, float]
    noise: float
    counted: float

    def place(self, name: str) -> int:
        """Where the shared parameter is among the unknowns."""
        if name not in self.names:
            raise InputError(f"{self.where}: does not determine {word(name)}: it cannot be shared")
        return self.names.index(name)

    def unknowns(self, values: Mapping[str, float], own: Array) -> tuple[Array, Array]:
        """All unknowns by the shared ``values`` and its ``own``, and their derivatives by the shared ones, (n, m)."""
        x, rates = np.zeros(len(self.names)), np.zeros((len(self.names), len(values)))
        x[self.own(values)] = own
        for k, (name, value) in enumerate(values.items()):
            i, unit = self.place(name), self.units.get(name, 1.0)
            x[i], rates[i, k] = value / unit, 1 / unit
        if self.counted and "w" in values:  # in the modulus
            i, s = self.place("w"), self.modulus(x)
            x[i], rates[i] = x[i] / s, rates[i] / s
            if "modulus" in values:
                rates[i, list(values).index("modulus")] = -x[i]
        return x, rates

    def own(self, shared: Iterable[str]) -> Array:
        """Indices of the unknowns that are not shared."""
        return np.setdiff1d(np.arange(len(self.names)), [self.place(name) for name in shared])

    def value(self, name: str) -> float:
        """The shared unknown by this record alone."""
        x = float(self.least.x[self.place(name)]) * self.units.get(name, 1.0)
        return x * self.modulus(self.least.x) if self.counted and name == "w" else x

    def modulus(self, x: Array) -> float:
        """The factor of all moduli that works are counted in."""
        return math.exp(x[self.names.index("modulus")]) if "modulus" in self.names else self.counted


def part_of(body: FittedBody, curve: Curve, settings: Settings) -> Part:
    """A curve fitted alone, by its points or as a whole record."""
    ready = alone(preparing(body, curve, settings))
    if settings.range is not None and isinstance(ready, ForceCurve):
        raise InputError(f"{curve.where}: {settings.range.name} is fitted to raw force curves each for itself")
    if isinstance(ready, ForceCurve):
        whole = whole_fit(body, ready, settings)
        common = {"ln_s": "modulus", f"q:{whole.model.stretches[-1].kind}": "w"}
        names = tuple(common.get(name, name) for name in whole.names)
        noise, factor = _noise(whole.covariance, whole.least), math.exp(whole.model.known.get("ln_s", 0.0))
        return Part(curve.where, whole.least, names, {}, noise, factor)
    minimum = robust(search(body, ready.points, ready.settings), ready.settings.loss)
    names, units = minimum.objective.unknowns.names, minimum.objective.unknowns.scales
    noise = _noise(spread_of(minimum, ready.settings)[0], minimum.least)
    return Part(curve.where, minimum.least, names, dict(zip(names, units.tolist(), strict=True)), noise, 0.0)


def _noise(stated: Array | None, least: Least) -> float:
    """The variance of residuals that a stated covariance rests on, by that of unit variance."""
    plain = covariance(least.state.jacobian, 1.0)
    if stated is None or plain is None:
        raise InputError("a force curve does not determine its own unknowns: fix one of them (--fix)")
    return float(np.median(np.diag(stated) / np.diag(plain)))


@dataclass(frozen=True, eq=False)
class Joint:
    """All ``parts`` as one model of the ``shared`` unknowns and then those of each."""

    parts: tuple[Part, ...]
    shared: tuple[str, ...]

    @cached_property
    def own(self) -> list[Array]:
        return [part.own(self.shared) for part in self.parts]

    def state(self, x: Array) -> State:
        """Residuals of all records in units of their noise."""
        m, residuals, rates = len(self.shared), [], []
        values, first = dict(zip(self.shared, x[:m].tolist(), strict=True)), m
        for part, own in zip(self.parts, self.own, strict=True):
            y, by = part.unknowns(values, x[first : first + own.size])
            state = part.least.problem.model(y)
            J = np.zeros((state.residuals.size, x.size))
            J[:, :m] = state.jacobian @ by
            J[:, first : first + own.size] = state.jacobian[:, own]
            scale, first = math.sqrt(part.noise), first + own.size
            residuals.append(state.residuals / scale)
            rates.append(J / scale)
        return State(np.concatenate(residuals), lambda: np.concatenate(rates))

    @property
    def bounds(self) -> tuple[Array, Array]:
        each = list(zip([part.least.problem.bounds for part in self.parts], self.own, strict=True))
        low, high = (
            np.concatenate([np.full(len(self.shared), end), *(bounds[i][own] for bounds, own in each)])
            for i, end in enumerate((-np.inf, np.inf))
        )
        for i, name in enumerate(self.shared):
            if name != "modulus" and not any(part.counted for part in self.parts):
                low[i] = max(part.least.problem.bounds[0][part.place(name)] * part.units[name] for part in self.parts)
        return low, high

    def search(self) -> Least:
        """From the mean of the shared unknowns by each record alone, weighted by their inverse variances."""
        weights, values = [], []
        for part in self.parts:
            spread = covariance(part.least.state.jacobian, part.noise)
            assert spread is not None
            places = [part.place(name) for name in self.shared]
            values.append([part.value(name) for name in self.shared])
            weights.append(1 / (np.diag(spread)[places] * [part.units.get(name, 1.0) ** 2 for name in self.shared]))
        start = [np.average(values, axis=0, weights=weights)]
        start += [part.least.x[own] for part, own in zip(self.parts, self.own, strict=True)]
        problem = LeastSquares(self.state, self.bounds, ROUNDED, evaluations=MOST_STEPS)
        return problem.least(np.concatenate(start))


@dataclass(frozen=True, eq=False, kw_only=True)
class JointFit(Answer):
    """Records fitted together: what is ``shared`` (``covariance``: of logs of moduli); ``fits`` of the records with
    these; ``alone``: the values by each record alone; ``chance`` that records which share them differ as much;
    ``level`` of the intervals."""

    fits: tuple[Fit, ...]
    alone: tuple[Mapping[str, float], ...]
    chance: float
    level: float = LEVEL

    @property
    def shared(self) -> tuple[FittedValue, ...]:
        """The estimates of what all have in common."""
        return self.estimates

    @property
    def flags(self) -> tuple[str, ...]:
        """Why the shared values are doubtful: records that do not share them, and flags of those that are doubtful."""
        apart = ["force curves do not share it"] * (self.chance <= STATISTICS_IMPROBABLE)
        doubted = (one for one in self.fits if one.grade is None or not one.grade.believed)
        return tuple(dict.fromkeys([*apart, *(flag for one in doubted for flag in one.flags)]))


def joint_fit(
    bodies: Sequence[FittedBody], curves: Sequence[Curve], settings: Settings, shared: Sequence[str]
) -> JointFit:
    """The fit of all ``curves``, each on its body, that share unknowns; InputError where one does not determine
    them."""
    if len(curves) < 2:
        raise InputError(f"fit: --shared: needs two force curves or more, got {len(curves)}")
    parts = tuple(part_of(body, curve, settings) for body, curve in zip(bodies, curves, strict=True))
    least = Joint(parts, tuple(shared)).search()
    m, E_star = len(shared), bodies[0].problem.E_star
    common = Unknowns(tuple(Parameter(name, True) for name in shared))
    following = E_star if "modulus" in shared else None
    intervals = Intervals.of(common, least, settings.level, settings.confidence, following, 1.0)
    if intervals.covariance is None or not least.ended:
        raise InputError(
            f"fit: the force curves together do not determine {', '.join(shared)}: fix one of them (--fix)"
        )
    estimates = intervals.estimates()
    known = {item.name: item for item in estimates}
    fixed = tuple(Parameter(p.name, False, known[p.name].value) if p.name in known else p for p in settings.parameters)
    sharing = replace(settings, parameters=fixed)
    # The fit of each record with the shared estimates in the place of those that were fixed in it.
    fits = tuple(
        replace(one, estimates=tuple(known.get(item.name, item) for item in one.estimates))
        for one in (fit(body, curve, sharing) for body, curve in zip(bodies, curves, strict=True))
    )
    from scipy.special import chdtrc

    rise = 2 * (least.cost - sum(part.least.cost / part.noise for part in parts))
    chance = float(chdtrc(m * (len(parts) - 1), max(rise, 0.0)))
    singly = []  # the shared values by a record alone, E* for the modulus
    for part in parts:
        values = {name: part.value(name) for name in shared}
        values |= {name: math.exp(x) for name, x in values.items() if Parameter(name, True).kind == LOG}
        singly.append(({ALIAS: values.pop("modulus") * E_star} if "modulus" in values else {}) | values)
    warnings = [f"{one.where}: {line}" for one in fits for line in one.warnings]
    if chance <= STATISTICS_IMPROBABLE:
        names = " and ".join("E*" if item.name == "E_star" else item.name for item in estimates
                             if item.name != "modulus")  # fmt: skip
        differ = f"the force curves differ by more than their noise (p = {chance:.1g}): they do not share {names}"
        warnings.insert(0, f"{differ}; compare the separate fits")
    return JointFit(
        estimates=estimates, free=tuple(shared), covariance=intervals.covariance[:m, :m], dof=least.dof,
        warnings=tuple(warnings), fits=fits, alone=tuple(singly), chance=chance, level=settings.level,
    )  # fmt: skip

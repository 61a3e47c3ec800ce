"""Force curves at several speeds of one specimen fitted together: one law of relaxation, one modulus and cohesive
stress, and w over the speed of the edge.

The bulk and the edge both make a faster cycle stick more. They are told apart by when: the bulk relaxes over its times
wherever the edge is, w depends on the speed of the edge alone. So w(v) acts within each march (``edge_speed.py``), and
all that describes the specimen is common to all records; contact point, offset and tilt are each record's own.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from time import process_time

import numpy as np

from ..base.errors import InputError, SolveError, counted
from ..base.numerics import Array
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import SEARCH_MISFIT, Intervals, Least, LeastSquares, State, covariance
from ..measured.lockstep import together
from ..measured.parameters import Answer, Unknowns
from .adhesive_fit import FARTHEST, FINE, GIVEN_UP, ZONES, ElasticLimits, length_of, misses, prepared, rough
from .adhesive_loads import ZONE, Adhering
from .law_posterior import MARCH_ERROR, law_near
from .lockstep_march import Marched
from .rate import RateLaw
from .rate_fit import law_of
from .relaxation_fit import RANGE, check_body
from .timed_record import BESIDE, MISFIT, UNSETTLED, RelaxationFit, RelaxationSettings
from .whole_record import BASE_FEWEST, MEAN

CONVERGED = 0.1  # choice: of the sum of squares of rows by their noise
DEEPEST = 1e-3  # choice: of the way, what a hold may drift
# choice: where a search begins: ratios, times from the shortest rise to the longest, w0 over w of the slowest pull-off
BULK_RATIOS, BULK_FIRST, BULK_LAST, BULK_TIMES, WORKS = (0.25, 0.6), 0.2, 1.0, 4, (0.4, 0.8)
APPROACHED, SEARCHED, FOLLOWED = 10, 6, 8  # choice: evaluations of these searches
BEST = 3  # choice: parts of the places, one zone width after the other, from the best of which a search begins
ROUNDS = 3  # choice: in which the rows that do not count are settled
LONGER = 8.0  # choice: times the search of approaches, that a fit takes: 5 to 12 of made triples
WORSE = 4.0  # choice: times the least cost, beyond which a search leads nowhere
SPEEDS, EXPONENTS = (0.1, 1.0, 10.0, 100.0), (0.3, 0.6)  # choice: v0 over the device's middle speed, and n


@dataclass(frozen=True, eq=False)
class Records:
    """Residuals of all ``models`` of records as a function of the unknowns: the common ones, then each record's
    own."""

    models: tuple[Adhering, ...]

    @cached_property
    def common(self) -> list[str]:
        """The names of the common unknowns."""
        return [name for name in self.models[0].unknowns.names if name not in self.models[0].settings.own]

    @cached_property
    def places(self) -> list[Array]:
        """Where the unknowns of each record are among all."""
        own = itertools.count(len(self.common))
        return [np.array([self.common.index(name) if name in self.common else next(own)
                          for name in model.unknowns.names]) for model in self.models]  # fmt: skip

    @property
    def each(self) -> list[tuple[Adhering, Array]]:
        """The models of the records with the places of their unknowns."""
        return list(zip(self.models, self.places, strict=True))

    @staticmethod
    def many(asked: Sequence[tuple[Records, Array]]) -> list[State]:
        """The states of several searches, of each record by one march."""
        one = asked[0][0]
        parts = [Adhering.many([(model, x[places]) for _, x in asked]) for model, places in one.each]
        joined = list[State]()
        for (_, x), *states in zip(asked, *parts, strict=True):
            off, rates = list[Array](), list[Array]()
            for i, ((model, places), state) in enumerate(zip(one.each, states, strict=True)):
                J = np.zeros((state.residuals.size, x.size))
                J[:, places] = state.jacobian
                # what is likely of common unknowns before counts once
                rows = slice(0, state.residuals.size - (model.prior(x[places])[0].size if i else 0))
                off.append(state.residuals[rows])
                rates.append(J[rows])
            joined.append(State(np.concatenate(off), partial(np.concatenate, rates)))
        return joined

    def __call__(self, x: Array) -> State:
        (state,) = self.many([(self, x)])
        return state

    def search(self, start: Array, evaluations: int, held: bool = False) -> LeastSquares:
        """What is minimised from ``start`` on, with the cohesive stress ``held``, which takes up what others are off,
        or not."""
        low, high = np.zeros((2, start.size))
        for model, places in self.each:
            low[places], high[places] = model.unknowns.bounds(start[places], FARTHEST)
            still = places[np.isin(model.unknowns.names, ZONE) & held]
            low[still] = high[still] = start[still]
        rows = sum(model.cycle.t.size for model in self.models)
        return LeastSquares(self, (low, high), 1e-6, CONVERGED / rows, evaluations)

    def searched(self, starts: Sequence[Array], evaluations: int) -> list[Least]:
        """The least of searches from several unknowns, side by side, the best first."""
        ends = together([self.search(x, evaluations, held=True).searching(x) for x in starts])
        found = [one for one in ends if not isinstance(one, Exception)]
        if not found:
            raise SolveError("no history of this specimen resembles the force curves together")
        return sorted(found, key=lambda one: one.cost)

    def marched(self, x: Array) -> list[Marched]:
        """A march of each record."""
        return [model.march([model.trial(x[places])])[0] for model, places in self.each]

    def best_of_each(self, starts: Sequence[Array], parts: int) -> list[Array]:
        """The best of each of so many ``parts`` of many unknowns."""
        costs = np.sum([misses(model, [x[places] for x in starts]) for model, places in self.each], axis=0)
        return [starts[part[np.argmin(costs[part])]] for part in np.array_split(np.arange(len(starts)), parts)]

    def at(self, values: Mapping[str, float], zeros: Sequence[Mapping[str, float]]) -> Array:
        """All unknowns from common ``values`` and the ``zeros`` of each record, SI."""
        x = np.zeros(1 + max(int(places.max()) for places in self.places))
        for (model, places), own in zip(self.each, zeros, strict=True):
            x[places] = model.unknowns.at({**values, **own, **model.settings.fixed})
        return x

    # ------------------------------------------------------------------ where a search begins
    def approaches(self) -> Records:
        """The records up to the begin of their retraction, where w is w0."""
        return Records(tuple(map(_approach, self.models)))

    def begins(self, rising: Records) -> list[Array]:
        """The best of some values with each of some zones, ratios and times, for approaches ``rising``: their last
        loads, after other times, tell the modulus, the pull-off of the slowest record w."""
        slowest = min(self.models, key=lambda model: model.cycle.speed)
        settings, fixed, body = slowest.settings, slowest.settings.fixed, slowest.body
        limits, series = ElasticLimits(body.nonadhesive), body.series
        cycles, ends = [model.cycle for model in self.models], [model.cycle.t.size for model in rising.models]
        touches, lasted, depths, loads = np.array(
            [(cycle.touches[0], cycle.t[end - 1] - cycle.t[cycle.contact[0]], np.mean(cycle.tip[end - MEAN : end]),
              np.mean(cycle.load[end - MEAN : end])) for cycle, end in zip(cycles, ends, strict=True)]
        ).T  # fmt: skip
        times = np.geomspace(BULK_FIRST * min(lasted), BULK_LAST * max(lasted), BULK_TIMES).tolist()
        known = (1.0,) if fixed.keys() & {"stress", "range"} else ZONES
        shown = touches, np.full_like(touches, np.median(touches))  # few free rows of a fast record may not show it
        tried = list[Array]()
        for zone, ratio, touch, share, time in itertools.product(known, BULK_RATIOS, shown, WORKS, times):
            radius = float(np.median(np.interp(depths - touch, series.delta, series.a)))
            modulus, zeros = 1.0, touch
            for _ in range(2):
                w = fixed.get("w", share * limits.work(modulus, slowest.cycle.pulled))
                length = length_of(body, fixed, w, modulus, zone * radius)
                zeros = touch + np.minimum(length, depths - touch)

                def work(_: float, w: float = w) -> float:
                    return w

                moduli = [limits.modulus(*one, work) for one in zip(depths - zeros, loads, strict=True)]
                left = ratio + (1 - ratio) * np.exp(-lasted / time / 2)
                modulus = fixed.get("modulus", float(np.exp(np.mean(np.log(moduli / left)))))
            law = {"ratio": ratio, "time": time}
            law |= {} if settings.law == "sls" else law_near(settings, ratio, time, float(max(lasted)))
            law |= {"modulus": modulus * law.get("modulus", 1.0), "w": w, "stress": w / length, "range": length}
            own = [{"delta0": zero, "P0": cycle.base[0], "tilt": cycle.base[1]}
                   for cycle, zero in zip(cycles, zeros.tolist(), strict=True)]  # fmt: skip
            tried.append(rising.at(law, own))
        return rising.best_of_each(tried, BEST)

    def continued(self, rising: Records, found: Sequence[Array]) -> list[Array]:
        """The best of some laws of w with each of what approaches tell."""
        if self.models[0].settings.rate is None:
            return list(found)
        speed, tried = float(np.median([model.cycle.speed for model in self.models])), list[Array]()
        for x, v0, n in itertools.product(found, SPEEDS, EXPONENTS):
            values = [model.unknowns.values(x[places]) for model, places in rising.each]
            tried.append(self.at(values[0] | {"v0": v0 * speed, "n": n, "b": values[0]["w"]}, values))
        return self.best_of_each(tried, len(found))


def _approach(model: Adhering) -> Adhering:
    cycle, (t, z) = model.cycle, model.cycle.program
    deepest = np.flatnonzero(z > z.max() - DEEPEST * np.ptp(z))[-1]
    rows = int(np.searchsorted(cycle.t, t[deepest]))
    if rows < cycle.contact[0] + BASE_FEWEST or cycle.speed <= 0:
        raise InputError(f"{cycle.curve.where}: force curves with approach and retraction are fitted together")
    some = t < cycle.t[rows - 1]
    program = np.append(t[some], cycle.t[rows - 1]), np.append(z[some], cycle.z[rows - 1])
    cut = replace(cycle, t=cycle.t[:rows], z=cycle.z[:rows], P=cycle.P[:rows], behind=slice(rows, rows),
                  program=program)  # fmt: skip
    settings = replace(model.settings, rate=None)
    return replace(
        model, cycle=cut, settings=settings, unknowns=Unknowns(settings.parameters, model.unknowns.units),
        sigma=model.sigma[:rows], left_out=model.left_out[:rows], jumps=np.array([model.jumps[0], [0.0, math.inf]]),
    )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class SharedSpeedsFit(Answer):
    """Records of one specimen fitted together: what they have in common (``estimates``), the ``fits`` of the records
    with it and zeros of their own, the ``law`` of w over the speed of the edge, if any, with its ``w0``, and the
    ``speeds`` of the device."""

    fits: tuple[RelaxationFit, ...]
    law: RateLaw | None
    speeds: tuple[float, ...]
    scatter: float

    @property
    def settings(self) -> RelaxationSettings:
        return self.fits[0].settings


def shared_speeds_fit(
    body: FittedBody, curves: Sequence[Curve], settings: RelaxationSettings,
    announce: Callable[[str, float], None] | None = None,
) -> SharedSpeedsFit:  # fmt: skip
    """The parameters that bring the histories of one ``body`` nearest to all ``curves``; InputError where a record does
    not allow it, SolveError where no history is found. ``announce`` gets what is done and about how many CPU seconds
    are left."""
    check_body(body)
    try:
        with np.errstate(all="ignore"):  # of trials far from any record
            began = process_time()
            fine = Records(tuple(prepared(body, curve, settings) for curve in curves))
            begun = Records(tuple(map(rough, fine.models)))
            rising = begun.approaches()
            ends = rising.searched(begun.begins(rising), APPROACHED)
            if announce is not None:
                announce(f"fit of {counted(len(curves), 'force curve')} together", LONGER * (process_time() - began))
            found = [one.x for one in ends if one.cost < WORSE * ends[0].cost]
            x = begun.searched(begun.continued(rising, found), SEARCHED)[0].x
            x = fine.search(x, FOLLOWED).least(x).x

            # Narrower zones, extrapolated, and the least with what they change, of the same rows throughout: those that
            # come and go with the march change the squares by as much as parameters do within their errors.
            for _ in range(ROUNDS):
                here = fine.marched(x)
                pairs = zip(fine.each, here, strict=True)
                narrower = [model.corrected(x[places], one) for (model, places), one in pairs]
                settled = Records(tuple(replace(model, left_out=model.out(one), settled=True, erring=True)
                                        for model, one in zip(narrower, here, strict=True)))  # fmt: skip
                least = settled.search(x, FINE[2]).least(x)
                wide = Records(tuple(replace(model, correction=0.0, jumps=one.jumps)
                                     for model, one in zip(settled.models, fine.models, strict=True)))  # fmt: skip
                shift = np.linalg.pinv(least.state.jacobian) @ (wide(least.x).residuals - least.state.residuals)
                x, there = least.x, settled.marched(least.x)
                same = not any((model.apart(one, (other.begun, other.lost)) & ~model.left_out).any()
                               for model, one, other in zip(settled.models, here, there, strict=True))  # fmt: skip
                if same:
                    break
            doubts = [BESIDE] if settings.law == "power" else []
            doubts += [] if least.ended and same else [f"{UNSETTLED}: values and intervals are preliminary"]
            lost = any(one.given_up for one in there) or any(map(operator.is_, narrower, fine.models))
            return _answer(settled, least, shift, [*doubts, GIVEN_UP] if lost else doubts)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise SolveError(f"{RANGE} ({error}); are all sizes and units right?") from error


def _answer(records: Records, least: Least, shift: Array, doubts: Sequence[str]) -> SharedSpeedsFit:
    """The fits of all records from the ``least``; ``doubts``: of all of them."""
    models, x = [replace(model, erring=False) for model in records.models], least.x
    states = [model(x[places]) for model, places in zip(models, records.places, strict=True)]
    off = [state.residuals[: model.cycle.t.size] for model, state in zip(models, states, strict=True)]
    count = [int(np.count_nonzero(one)) for one in off]
    scatter = math.sqrt(sum(float(one @ one) for one in off) / max(sum(count) - x.size, 1))
    variance = max(1.0, scatter**2)

    own = covariance(least.state.jacobian, variance)
    own = None if own is None else own + MARCH_ERROR**2 * np.outer(shift, shift)

    fits = []
    for model, places, state, part, rows in zip(models, records.places, states, off, count, strict=True):
        settings, unknowns = model.settings, model.unknowns
        one = replace(least, x=x[places], state=state, at_bound=least.at_bound[places])
        intervals = Intervals.of(unknowns, one, settings.level, "covariance", model.body.problem.E_star, variance)
        intervals = replace(intervals, covariance=None if own is None else own[np.ix_(places, places)])
        misfit = math.sqrt(float(part @ part) / max(rows, 1))
        own_line = f"residuals are {misfit:.2g} times the scatter from row to row: {MISFIT}"
        fits.append(RelaxationFit(
            estimates=intervals.estimates(), free=unknowns.names, dof=least.dof,
            covariance=unknowns.covariance(intervals.covariance),
            relaxation=settings.relaxation(unknowns.values(x[places])), record=model.cycle.record(),
            imposed=model.cycle.z, response=np.where(part != 0, model.cycle.P + part * model.sigma, np.nan),
            settings=settings, scatter=misfit,
            warnings=(
                *doubts, *model.cycle.curve.doubts, *model.cycle.record().flags,
                *([own_line] if misfit > SEARCH_MISFIT else []),
            ),
        ))  # fmt: skip
    first = fits[0]
    values = {item.name: item.value for item in first.estimates}
    rate, common, apart = first.settings.rate, len(records.common), first.settings.own
    fit = SharedSpeedsFit(
        estimates=tuple(item for item in first.estimates if item.name not in apart), free=tuple(records.common),
        covariance=None if own is None else own[:common, :common], dof=least.dof, fits=tuple(fits), scatter=scatter,
        law=law_of(rate, values | {"w0": values["w"]})[0] if rate else None,
        speeds=tuple(model.cycle.speed for model in models),
    )  # fmt: skip
    lines = [f"{one.record.curve.where}: {line}" for one in fits for line in one.warnings[len(doubts) :]]
    if own is None:
        lines.append(f"the force curves do not determine {', '.join(fit.free)} together: fix one of them (--fix)")
    return replace(fit, warnings=(*doubts, *lines, *(line for _, _, line in fit.hardly_apart)))

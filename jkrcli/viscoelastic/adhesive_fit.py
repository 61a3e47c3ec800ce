"""The modulus, a law of relaxation, w and its cohesive stress from one whole force curve, with its free rows.

Every row counts, by P_read = P0 + tilt (z - z_0) + P(t; body, w, stress, law) + noise: where the fitted contact is
not, P = 0, so that free rows say what offset, tilt and noise are and nothing else. The loads are marches of all trial
parameters at once (``lockstep_march.py``), P(E, w, sigma) = E p(w/E, sigma/E). Which side of a jump a row lies on is
not known within some rows of it: they are left out, and the time of the jump is a reading of its own.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.finite_range import AttractedBody
from ..base.errors import InputError, SolveError
from ..base.numerics import Array
from ..formulas import tabor
from ..measured.choices import Values
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.least_squares import SEARCH_MISFIT, Intervals, Least, LeastSquares, covariance
from ..measured.lockstep import together
from ..measured.parameters import Unknowns
from .adhesive_loads import APART, CONVERGED, LIKELY_RANGE, STEEP, ZONE, Adhering
from .law_posterior import MARCH_ERROR, Nearby, Posterior
from .relaxing_adhesion import ZONE_SLOPE
from .timed_record import BESIDE, LONG_RANGE, MISFIT, ROWS_APART, UNSETTLED, ZEROS, RelaxationFit, RelaxationSettings
from .whole_record import BASE_FEWEST, MEAN, NEAR, PARTING_TIME, Cycle

DEEPER = 1.5  # choice: times the depth, to which a body is solved
# Where a search begins.
RATIOS, TIMES, SHARES = (0.25, 0.75), (0.15,), (0.0, 0.5, 1.0)  # choice: shares: from very fast to from rest
ZONES = (0.25, 0.02, 0.0)  # choice: zones over the contact radius, where no range is known; 0: the likely range
MODULI, TRIED = 1e6, 50  # choice: in those of the body, the moduli among which a search begins
FARTHEST, REACH = 4.0, 1.5  # choice: of logs, from what is likely of a record, and from where a search begins
ROUNDS = 3  # choice: modulus and zero in turn, good to a tenth
BEGINS = 2  # choice: searches
# choice: zones over contact radii at least, tolerances of steps, evaluations at most, of a search and of the fit
SEARCH, FINE = (0.03, 2e-2, 3), (0.012, 2e-2, 12)
HELD = 0.05  # choice: of steps of others, those of a stress that is held
# choice: of an alternative, evaluations at most, what a stress is held by, and times what it may leave in the end, up
# to which it is searched on; of 14 records that relax the most were 2.3, 1.0 and 1.0
STAGES = ((4, HELD, 3.0), (FINE[2], HELD, 2.0), (FINE[2], 1.0, 1.5))
# Where else a search begins that ends elsewhere: times and zones; choice: scatter of what another may leave less of
OTHERS, NOISY = (((0.05,), (0.25,)), ((0.15,), (0.25,))), 1.02
TIED = 5.0  # choice: half of chi^2, by which a valley may lie higher and be as likely
QUICK = 3e-3  # choice: tolerance of steps of a power law, which relaxes at once behind each corner of the program
LIKE = 1.1  # choice: of a neighbour's scatter, what a fit may leave that begins there
ROUGH = 0.02  # choice: of the pull-off force, what a search may miss
ROUGH_TIME = 0.003  # choice: of the time in contact, errors of jumps in a search, and of the last one in wide zones
MOVED = 1.0  # theory: of that sum, a standard error: samples about the last place foretell what is left of a step
FAR = 0.9  # choice: of logs, from the likely range, where a power law is searched from that too
CORRECTED = 3  # choice: times that zones are extrapolated
NEARER = (1.0, 0.3, 0.1, 0.03)  # choice: of a distance that led nowhere or near, which are tried
WITHIN = (0.01, 0.3, 1.0)  # choice: steps of logs at least, at first, and at most
SCATTERS = 1e-3, 8e-3  # choice: of that sum, what a step may still gain, or lose by what marches err
# choice: of 50 made records, 5 of 12 below it are off by more than three standard errors, above it none
TABOR_LEAST = 0.75
GIVEN_UP = "the contact of the fitted values could not be followed to its end"


@dataclass(frozen=True, eq=False)
class ElasticLimits:
    """What the adhesive curves of a ``body`` that does not relax say of a record: where a search begins."""

    body: Nonadhesive

    @cached_property
    def _pulls(self) -> tuple[Array, Array]:
        """Logs of w over the modulus, and of the pull-off force over it."""
        a, P, S, dS = self.body.a, self.body.series.P, self.body.slopes.S, self.body.slopes.dS
        least = float(np.min(P**2 / (S**2 * 4 * math.pi * a / dS)))
        w = least * np.geomspace(1, 1e12, 200)
        pulled = np.max(S * np.sqrt(4 * math.pi * w[:, None] * a / dS) - P, axis=1)
        rising = pulled > 0
        return np.log(w[rising]), np.log(pulled[rising])

    def work(self, modulus: float, force: float) -> float:
        """The work of adhesion [J/m^2] behind a pull-off ``force`` [N] with the ``modulus`` in those of the body."""
        return modulus * math.exp(float(np.interp(math.log(force / modulus), self._pulls[1], self._pulls[0])))

    def modulus(self, delta: float, P: float, work: Callable[[float], float]) -> float:
        """The largest modulus, in those of the body, with which the load at ``delta`` [m] is ``P`` [N] under the
        ``work`` [J/m^2] of adhesion of each modulus."""
        a, series, slopes = self.body.a, self.body.series, self.body.slopes
        above, beyond = math.inf, MODULI
        for modulus in np.geomspace(MODULI, 1 / MODULI, TRIED).tolist():
            shift = np.sqrt(4 * math.pi * work(modulus) * a / (modulus * slopes.dS))
            there = series.delta - shift
            i = int(np.argmin(there))
            load = float(np.interp(delta, there[i:], (modulus * (series.P - slopes.S * shift))[i:]))
            if load <= P < above:
                part = (P - load) / (above - load) if math.isfinite(above) else 0.0
                return modulus * (beyond / modulus) ** part
            above, beyond = load, modulus
        return beyond


def adhering_fit(
    body: FittedBody, curve: Curve, settings: RelaxationSettings, like: RelaxationFit | None = None
) -> RelaxationFit:
    """The fit of a force curve with its retraction and free rows, w among the unknowns; ``like``: the fit of one that
    may be alike, as that of a neighbour, where it begins."""
    fine = prepared(body, curve, settings)
    wide, begun = fine, None if like is None else _beside(fine, like)
    if begun is None:
        begun = _searched(fine)
        wide = begun.model
    ends = [Valley.of(begun, wide)]
    if like is None and settings.most is None:
        ends += _other_valleys(fine, ends[0], wide)
    best = max(ends, key=Valley.order)
    found, tied = best.found, [one.found for one in ends if one.found.cost < best.found.cost + TIED]
    rough = min((one.rough for one in ends), key=lambda one: one.cost)
    found = rough if rough.cost < found.cost - TIED else found  # narrower zones and times of jumps contradict the rows

    # what zones of no width change, by the errors of jumps with them; and to those that are as likely
    jumps = np.stack([wide.jumps[:, 0], found.model.jumps[:, 1]], axis=1)
    change = replace(found, model=replace(wide, jumps=jumps)).state.residuals - found.state.residuals
    shifts = [np.linalg.pinv(found.state.jacobian) @ change, *(one.x - found.x for one in tied if one is not found)]
    fit = _result(found, np.array(shifts))
    return fit if best.followed and not found.here.given_up else replace(fit, warnings=(*fit.warnings, GIVEN_UP))


class Valley(NamedTuple):
    """Where a search ends: the ``rough`` end of wide zones, what is ``found`` with what narrower ones, extrapolated,
    change there, and whether these could be ``followed``."""

    rough: Nearby
    found: Nearby
    followed: bool

    @classmethod
    def of(cls, begun: Nearby, wide: Adhering) -> Valley:
        """The least from a place where ``wide`` zones have ``begun``."""
        found, followed = begun, begun.model is not wide
        for _ in range(CORRECTED):
            narrower = replace(found, model=wide.corrected(found.x, found.here))
            change = found.state.residuals - narrower.state.residuals
            if followed and (narrower.model is wide or float(change @ change) < CONVERGED):
                break
            followed = narrower.model is not wide
            found = _least(narrower, FINE[2], (1.0,))
            if found.x is narrower.x:
                break
        return cls(begun, found, followed)

    def order(self) -> tuple[bool, float]:
        """The larger, the better."""
        return self.followed, -self.found.cost

    @property
    def is_noise(self) -> bool:
        """Whether the search has come to an end that leaves no more than noise."""
        return self.followed and self.found.ended and self.found.scatter < NOISY


def _searched(fine: Adhering) -> Nearby:
    """The least of the problem ``fine``, roughly; SolveError where an alternative leaves too much."""
    most, near = fine.settings.most, _begun(fine)
    for evaluations, hold, times in STAGES if most is not None else ((FINE[2], HELD, math.inf),):
        near = _least(near, evaluations, (hold,))
        off = near.state.residuals[: fine.cycle.t.size]
        if float(np.mean(off[off != 0] ** 2)) > times * (most or 1.0):
            raise SolveError("no history of this specimen leaves as little")
    return near


def _other_valleys(fine: Adhering, first: Valley, wide: Adhering) -> Iterator[Valley]:
    """Ends of searches that begin elsewhere than the ``first``, until one leaves no more than noise."""
    begins: list[Callable[[], Nearby | None]] = [partial(_with_likely_range, first.found, wide)]
    begins += [partial(_begun, fine, *one) for one in OTHERS]
    best = first
    for begin in begins:
        if begin is not begins[0] and best.is_noise:
            return
        with contextlib.suppress(SolveError, ArithmeticError, ValueError):  # a LinAlgError is one
            if (near := begin()) is not None:
                other = Valley.of(_least(near, FINE[2], (HELD, 1.0)), wide)
                best = max(best, other, key=Valley.order)
                yield other


def _with_likely_range(found: Nearby, wide: Adhering) -> Nearby | None:
    """The unknowns ``found`` of a power law with the likely range in place of one that is far from it: relaxation at
    short times is like a zone so wide, or narrow, in another valley. None where the range is not far, or known."""
    values, names = found.model.unknowns.values(found.x), found.model.unknowns.names
    length = values["range"] if "range" in values else values["w"] / values["stress"]
    if wide.settings.law != "power" or not set(names) & set(ZONE) or abs(math.log(length / LIKELY_RANGE)) < FAR:
        return None
    changed = {"range": LIKELY_RANGE} if "range" in names else {"stress": values["w"] / LIKELY_RANGE}
    return Nearby.of(wide, found.model.unknowns.at({**values, **changed}))


def prepared(body: FittedBody, curve: Curve, settings: RelaxationSettings) -> Adhering:
    """The residuals of a force curve with its retraction and free rows, with what is free of their zeros."""
    if body.no_range:
        raise InputError(body.no_range.replace("adhesion of finite range", "adhesion on a viscoelastic specimen"))
    cycle = Cycle.of(curve)
    _check(cycle)
    # Free too, unless fixed, are the stress and, where there are free rows, the zeros
    if not settings.ranged:
        settings = replace(settings, adhesion=(*settings.adhesion, "stress"))
    free = cycle.free.sum() >= BASE_FEWEST
    zeros = [name for name in ZEROS if name not in settings.fixed and (name in settings.zeros or free)]
    if "tilt" in zeros and "tilt" not in settings.zeros and np.ptp(cycle.z[cycle.free]) < 0.05 * np.ptp(cycle.z):
        zeros.remove("tilt")
    settings = replace(settings, zeros=tuple(zeros))
    depth = float(cycle.tip.max()) - min(cycle.touches)
    body = body.to_depth(DEEPER * depth)
    z, P = float(np.ptp(cycle.z)), float(np.ptp(cycle.P))
    unknowns = Unknowns(settings.parameters, {"delta0": max(depth, 1e-3 * z), "P0": P, "tilt": P / z})
    # All rows count by their noise, the jumps where the rows show them
    seen, errors = np.array(cycle.jumps), np.array([cycle.jump_error, ROUGH_TIME * cycle.lasting])
    if settings.rate:
        seen = np.array([cycle.jumps[0], cycle.jumps[1] if cycle.held else cycle.recovered])
        errors = np.full(2, math.hypot(cycle.spacing / math.sqrt(12), PARTING_TIME * cycle.lasting))
    jumps = np.where(np.isfinite(seen)[:, None], np.stack([seen, errors], axis=1), [0.0, math.inf])
    tolerance = QUICK if settings.law == "power" else FINE[1]
    fine = Adhering(body, AttractedBody(body.problem), cycle, settings, unknowns, FINE[0], tolerance,
                    np.full(cycle.t.size, cycle.noise), jumps, cycle.near(APART))  # fmt: skip
    return replace(fine, parting=cycle.parting) if settings.rate else fine


def _check(cycle: Cycle) -> None:
    """InputError where no adhesion shows, or a load is prescribed."""
    if cycle.load_is_prescribed:
        raise InputError(
            f"{cycle.curve.where}: w: adhesive cycles are fitted under a prescribed displacement, here the load is "
            "prescribed: leave w out"
        )
    if (
        cycle.pulled < ROWS_APART * cycle.noise / math.sqrt(2 * MEAN + 1)
        or float(-cycle.load.min()) < ROWS_APART * cycle.noise
    ):
        raise InputError(
            f"{cycle.curve.where}: w: no adhesion shows, no load lies below that before contact; leave w out"
        )


def _beside(fine: Adhering, like: RelaxationFit) -> Nearby | None:
    """The likeliest unknowns from the specimen of another fit on, with the record's own begin of contact and what
    narrower zones change there; None where that leads nowhere."""
    values = {item.name: item.value for item in like.estimates} | dict(like.settings.fixed)
    with contextlib.suppress(SolveError, ArithmeticError, ValueError):  # a LinAlgError is one
        length = values["range"] if "range" in values else values["w"] / values["stress"]
        own = {"delta0": fine.cycle.touches[0] + length, "P0": fine.cycle.base[0], "tilt": fine.cycle.base[1]}
        x = fine.unknowns.at({**values, **own, **fine.settings.fixed})
        near = Nearby.of(fine, x)
        found = _least(replace(near, model=fine.corrected(x, near.here)), FINE[2], (1.0,))
        if found.ended and found.scatter <= min(LIKE * like.scatter, SEARCH_MISFIT):
            return found
    return None


def _begun(fine: Adhering, times: Sequence[float] = TIMES, zones: Sequence[float] = ZONES) -> Nearby:
    """Where a search of the problem ``fine`` begins: where a standard solid has come by rough ones, from the best of
    some ``times`` and ``zones``; by another law, where the record is likeliest next to it."""
    asked = settings = fine.settings
    if settings.law != "sls":
        known = {name: value for name, value in settings.fixed.items() if name not in settings.of_law}
        settings = replace(settings, law="sls", fixed=known)
    fine = replace(fine, settings=settings, unknowns=Unknowns(settings.parameters, fine.unknowns.units))
    model, searches = rough(fine), []
    for theta in _starts(model, times, zones):  # side by side, stress or range held
        low, high = model.unknowns.bounds(theta, REACH)
        held = np.isin(model.unknowns.names, ZONE)
        bounds = np.where(held, theta, low), np.where(held, theta, high)
        problem = LeastSquares(model, bounds, 1e-6, CONVERGED / model.cycle.t.size, SEARCH[2])
        searches.append(problem.searching(theta))
    found = [one for one in together(searches) if not isinstance(one, Exception)]
    if not found:
        raise SolveError("no history of this specimen resembles the data")
    near = Nearby.of(fine, min(found, key=lambda one: one.cost).x)
    if asked.law != "sls":  # where the record is likeliest by that law, whatever the solid's cost is
        near = near.by_law(asked)
        near = Nearby.of(near.model, Posterior.of(near, 1.0, WITHIN[1], HELD).likeliest())
    return near


def rough(fine: Adhering) -> Adhering:
    """The same as a search begins: wide zones, few steps, and readings that count for less."""
    cycle, jumps = fine.cycle, fine.jumps.copy()
    errors = np.maximum(ROUGH * (cycle.pulled + np.abs(cycle.load)), cycle.noise)
    jumps[np.isfinite(jumps[:, 1]), 1] = ROUGH_TIME * cycle.lasting
    sigma = np.where(cycle.free, 3 * cycle.noise, errors)
    return replace(fine, width=SEARCH[0], tolerance=SEARCH[1], sigma=sigma, jumps=jumps, left_out=cycle.near(NEAR))


def length_of(body: FittedBody, fixed: Values, w: float, modulus: float, zone: float) -> float:
    """The range of adhesion [m] with which a ``zone`` is so wide [m], unless it, or the stress, is ``fixed``."""
    if "stress" in fixed:
        return fixed.get("range", w / fixed["stress"])
    return fixed.get("range", math.sqrt(zone * w / (ZONE_SLOPE * modulus * body.problem.E_star)) or LIKELY_RANGE)


def _starts(model: Adhering, times: Sequence[float] = TIMES, zones: Sequence[float] = ZONES) -> list[Array]:
    """The best of some values, with each of some ratios, ``times`` and ``zones``: the pull-off force tells w in a very
    fast cycle, where it is elastic, from rest, where it is the ratio times that of the relaxed modulus, and between;
    the load at the reversal tells the modulus."""
    cycle, body, settings = model.cycle, model.body, model.settings
    limits, fixed = ElasticLimits(body.nonadhesive), settings.fixed
    first, end = cycle.contact
    top = first + int(np.argmax(cycle.z[first:end]))  # at the reversal
    depth, load = float(cycle.tip[top]), float(cycle.load[top])
    zones = (1.0,) if fixed.keys() & {"stress", "range"} else zones
    starts = []
    for shows, ratio, time, share, zone in itertools.product(cycle.touches, RATIOS, times, SHARES, zones):
        radius = float(np.interp(depth - shows, body.series.delta, body.series.a))

        def work(modulus: float, ratio: float = ratio, share: float = share) -> float:
            fast, rest = (limits.work(modulus, cycle.pulled), ratio * limits.work(ratio * modulus, cycle.pulled))
            return float(fast ** (1 - share) * rest**share)

        zero = shows
        for _ in range(ROUNDS):
            modulus = fixed.get("modulus", limits.modulus(depth - zero, load, work))
            w = fixed.get("w", work(modulus))
            length = length_of(body, fixed, w, modulus, zone * radius)
            zero = shows + min(length, depth - shows)
        values = {"w": w, "stress": w / length, "range": length, "delta0": zero}
        values |= {"P0": cycle.base[0], "tilt": cycle.base[1]}
        law = {"ratio": ratio, "time": time * cycle.lasting}
        starts.append(model.unknowns.at({**values, **law, "modulus": modulus, **fixed}))
    low, high = zip(*(model.unknowns.bounds(theta, FARTHEST) for theta in starts), strict=True)
    starts = [np.clip(theta, a, b) for theta, a, b in zip(starts, low, high, strict=True)]
    return [starts[i] for i in np.argsort(misses(model, starts))[:BEGINS]]


def misses(model: Adhering, starts: Sequence[Array]) -> list[float]:
    """How far off the record each of some unknowns is."""
    cycle, costs = model.cycle, list[float]()
    for theta, march in zip(starts, model.march([model.trial(theta) for theta in starts]), strict=True):
        off = (model.loads(theta, march) - cycle.P) / model.sigma
        lost = march.lost if math.isfinite(march.lost) else cycle.t[-1] + cycle.lasting / 4
        missed = 0.0 if math.isinf(model.jumps[1, 1]) else (lost - model.jumps[1, 0]) / cycle.lasting
        costs.append(float(np.sum(np.log1p(off**2))) * (1 + abs(missed)))
    return costs


def _least(near: Nearby, evaluations: int, holds: Sequence[float]) -> Nearby:
    """Where the record is likeliest, by steps to where it is by what it says near the last ones, ``ended`` where the
    loads there hardly differ; one search after the other with the stress, which takes up what other unknowns are off,
    within so much of what these may change: ``holds``."""
    for held in holds:
        within, ended, careful = WITHIN[1], False, False
        for _ in range(evaluations):
            foretold = Posterior.of(near, 1.0, within, held).likeliest()
            if ended := near.moves(foretold) < MOVED:
                break
            noise = CONVERGED + SCATTERS[1] * near.cost
            if careful:  # what derivatives foretell ends nearer: the best of several distances
                tried = [Posterior.of(near, 1.0, within * share, held).likeliest() for share in NEARER]
                costs = near.model.costs(tried)
                best = int(np.argmin(costs))
                if costs[best] > near.cost + noise:
                    break
                foretold, within = tried[best], within * NEARER[best] / 3
            new = Nearby.of(near.model, foretold)
            gained = near.cost - new.cost
            near = new if gained > 0 else near
            if ended := -noise < gained < CONVERGED + SCATTERS[0] * near.cost:
                break
            careful, within = careful or gained <= 0, within * 3 if gained > 0 else within / 5
            if gained <= 0 and within < WITHIN[0]:
                break
            within = min(max(within, WITHIN[0]), WITHIN[2])
    return replace(near, ended=ended)


def _result(near: Nearby, shifts: Array) -> RelaxationFit:
    """The answer ``near`` the likeliest unknowns; ``shifts``: of these, by the widths of zones that are extrapolated,
    and to other valleys."""
    model, state = near.model, near.state
    settings, unknowns, cycle = model.settings, model.unknowns, model.cycle
    variance = max(1.0, near.scatter**2)
    own = covariance(state.jacobian, variance)
    own = own if own is None else own + MARCH_ERROR**2 * shifts.T @ shifts
    middle, samples = Posterior.of(near, variance).samples(shifts)
    low, high = unknowns.bounds(middle, FARTHEST)
    problem = LeastSquares(model, (low, high))
    least = Least(problem, middle, state, near.cost, (middle <= low) | (middle >= high), 0, near.ended)
    intervals = Intervals.of(unknowns, least, settings.level, "covariance", model.body.problem.E_star, variance)
    intervals = replace(intervals, covariance=own, samples=samples)
    fit = RelaxationFit(
        estimates=intervals.estimates(), free=unknowns.names, dof=least.dof, covariance=unknowns.covariance(own),
        relaxation=settings.relaxation(unknowns.values(least.x)), record=cycle.record(), imposed=cycle.z,
        response=np.where(replace(model, steep=STEEP[1]).out(near.here), np.nan, model.loads(near.x, near.here)),
        settings=settings, scatter=near.scatter, samples=samples * unknowns.scales,
    )  # fmt: skip
    warnings = [*fit.record.flags, *([BESIDE] if settings.law == "power" else [])]
    values, R = unknowns.values(near.x), model.body.problem.indenter.tip_radius
    length = values["range"] if "range" in values else values["w"] / values["stress"]
    number = math.inf if R is None else tabor(R, values["w"], fit.value("E_star"), length)
    if number < TABOR_LEAST:
        warnings.append(f"Tabor number {number:.2g} of the fitted range is below {TABOR_LEAST:g}, {LONG_RANGE}")
    warnings += [] if least.ended else [f"{UNSETTLED}: values and intervals are preliminary"]
    if fit.scatter > SEARCH_MISFIT:
        warnings.append(f"residuals are {fit.scatter:.2g} times the scatter from row to row: {MISFIT}")
    return replace(fit, warnings=tuple(warnings))

"""The range of adhesion as an alternative of JKR: how far ranges that the data do not exclude move what was fitted.

The curves are those of a constant tension up to the range (Maugis) on the body itself. A sphere's pull-off hardly
changes its shape with the range, but w and the zero of the displacement do: from displacement and load alone w of
JKR may be a fifth too large where the surfaces attract each other over as far as adhesion deforms them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..base.errors import NOTICEABLE, JkrError, SolveError
from ..base.numerics import MOST_SOLVES, TINY, Array, f_tail
from ..base.units import show
from ..methods.layered.spectrum import spectrum_seconds
from .choices import Loss, Values
from .forward_model import Drift
from .least_squares import chi2_increase, influence, t_quantile
from .parameters import FittedValue, Parameter
from .priors import PRIORS
from .rows import SEARCH_HALVINGS, SEARCH_REACH, Minimum
from .settings import Settings

# Which ranges are tried, and when one is significant.
# Over the displacement that adhesion adds at JKR's pull-off; Tabor numbers of a sphere 3 to 0.03:
RANGE_RANGES = (0.1, 0.3, 1.0, 3.0, 10.0)  # choice: what lies between is interpolated

RANGE_SHORT = 0.1  # theory: relative change of w by the last step; what remains is its square, a hundredth
RANGE_HOPELESS = 30.0  # choice: excess over what is possible, from which on there are no more steps
RANGE_ROUNDED = 0.05  # choice: of logs of range and w with which curves are solved, so that fits share them
RANGE_CHANCE = 2e-3  # choice: at which data of JKR itself show a range
RANGE_SLOW = 0.1  # choice: CPU seconds of a body's spectrum, above which no range is tried


WORKS = ("w", "w_approach")


@dataclass(frozen=True, eq=False)
class RangeAlternative:
    """The ranges [m] that the data leave: the ``best`` of those tried, 0 for JKR, and the ``most``; ``moves``: how far
    they move each parameter. ``chance``: that data of JKR itself speak as much for one."""

    best: float
    most: float
    moves: Values
    chance: float

    def warnings(self) -> Iterator[str]:
        """A sentence where a range is significant."""
        if self.best > 0 and self.chance < RANGE_CHANCE:
            words = f"adhesion with a range of about {show(self.best, 'length', 2)}: fit with --free range"
            yield f"model rejected, p = {self.chance:.1g}, in favour of {words}"


@dataclass(frozen=True, eq=False)
class _Rung:
    """A range [m], the sum of squares with it less JKR's, over the variance, and by how much it moves each value."""

    length: float
    excess: float
    moves: Values


def range_alternative_of(
    minimum: Minimum, variance: float, limit: float, settings: Settings
) -> RangeAlternative | None:
    """The ranges that the data leave; None where none can be tried: bodies without such curves, layers that are
    fitted, cylinders and gradients, whose kernels would take longer than the fit.

    ``variance`` of the residuals; ``limit``: rise of the sum of squares over it, up to which a range is possible. None
    is tried that is longer than the ``settings`` allow.
    """
    body = minimum.objective.body
    problem = body.problem
    own, values = any(p.of_body for p in minimum.objective.parameters), minimum.values
    if own or problem.specimen.radius is not None or spectrum_seconds(problem) > RANGE_SLOW:
        return None
    if min(_works(values)) < NOTICEABLE * values["modulus"] * body.family.natural_work:
        return None
    try:
        body.coarse.attracted  # noqa: B018  a Refusal where there is none
    except JkrError:
        return None
    neck = math.log(body.family.neck(values["modulus"], values["w"]))
    neck = math.exp(RANGE_ROUNDED * round(neck / RANGE_ROUNDED))
    lengths = [part * neck for part in RANGE_RANGES if part * neck < settings.range_at_most]
    lengths += [settings.range_at_most] * (len(lengths) < len(RANGE_RANGES))
    rung = partial(_rung, minimum, variance=variance, limit=limit, loss=settings.loss)
    rungs = _climbed(lengths, rung, values, limit)
    # Those within the limit of the best are possible; between the longest of them and the next the root of the excess
    # is a straight line
    best, i = min(rungs, key=lambda rung: rung.excess), _last_possible(rungs, limit)
    possible = [rung for rung in rungs if rung.excess - best.excess <= limit]
    # A short range counts by its square, as the work within the annulus does.
    squares, moves = [rung.length**2 for rung in possible], [[*rung.moves.values()] for rung in possible]
    if i + 1 < len(rungs):
        last, beyond = rungs[i : i + 2]
        low, high = (math.sqrt(rung.excess - best.excess) for rung in (last, beyond))
        part = (math.sqrt(limit) - low) / (high - low) if math.isfinite(high) else 0.0
        squares.append(last.length**2 + part * (beyond.length**2 - last.length**2))
        moves.append([move + part * (beyond.moves[key] - move) for key, move in last.moves.items()])
    within = np.minimum(squares, settings.longest_range**2)
    largest = [float(np.abs(np.interp(within, squares, column)).max()) for column in np.transpose(moves)]
    n = minimum.distances.residuals.size - minimum.least.x.size
    chance = float(f_tail(1, max(n - 1, 1), max(-best.excess, 0.0)))
    return RangeAlternative(best.length, math.sqrt(squares[-1]), dict(zip(best.moves, largest, strict=True)), chance)


def _climbed(
    lengths: Sequence[float], rung_of: Callable[[float], _Rung], values: Iterable[str], limit: float
) -> list[_Rung]:
    """The rungs of JKR and of those ``lengths`` [m] that bracket the longest possible range, by increasing length.

    From the middle on they are climbed while they are possible, else descended until one is; the bracket beyond the
    longest possible one is halved.
    """
    rungs, k = [_Rung(0.0, 0.0, dict.fromkeys(values, 0.0))], min(len(RANGE_RANGES) // 2, len(lengths) - 1)

    def is_possible(length: float) -> bool:
        with contextlib.suppress(JkrError):  # attraction reaches beyond the body, or the step led nowhere
            rungs.append(rung_of(length))
            return rungs[-1].excess - min(rung.excess for rung in rungs) <= limit
        return False

    up = is_possible(lengths[k])
    for length in lengths[k + 1 :] if up else lengths[:k][::-1]:
        if is_possible(length) != up:
            break
    with contextlib.suppress(JkrError):
        for _ in range(SEARCH_HALVINGS):
            rungs.sort(key=lambda rung: rung.length)
            i = _last_possible(rungs, limit)
            # a straight line to the next would not do
            if i not in (0, len(rungs) - 1) and not rungs[i + 1].excess > RANGE_HOPELESS * limit:
                rungs.append(rung_of(math.sqrt(rungs[i].length * rungs[i + 1].length)))
    return sorted(rungs, key=lambda rung: rung.length)


def _last_possible(rungs: Sequence[_Rung], limit: float) -> int:
    """The index of the longest of the ``rungs``, by increasing length, that is within the ``limit`` of the best."""
    best = min(rung.excess for rung in rungs)
    return max(i for i, rung in enumerate(rungs) if rung.excess - best <= limit)


def _rung(minimum: Minimum, length: float, variance: float, limit: float, loss: Loss) -> _Rung:
    """The parameters with a range of ``length`` [m], by Gauss-Newton steps from JKR's minimum."""
    plain, names = minimum.objective, minimum.objective.unknowns.names
    ranged = (*plain.parameters, Parameter("range", False, length))
    objective, before = replace(plain, body=plain.body.coarse, parameters=ranged), minimum.distances.residuals.ravel()
    jacobian, z = minimum.distances.jacobian(names), before / minimum.width
    weights = np.divide(influence(z, loss)[0], z, out=np.ones_like(z), where=z != 0)  # 1 in least squares
    least, x = float(np.sum(weights * before**2)), dict(minimum.x)
    logs = [parameter.name for parameter in plain.parameters if parameter.kind == "log"]
    for _ in range(MOST_SOLVES):
        values = plain.values(x)
        if min(works := _works(values)) <= 0:
            raise SolveError(f"a range of {show(length, 'length')} leaves no work of adhesion")
        for name in [name for name in WORKS if name in names]:  # at a rounded ratio to the moduli
            ratio = round(math.log(values[name] / values["modulus"]) / RANGE_ROUNDED)
            values[name] = values["modulus"] * math.exp(RANGE_ROUNDED * ratio)
            x[name] = plain.scaled(values)[name]
        there = objective.distances({**x, "range": math.log(length)}, rated=False).residuals.ravel()
        step = np.linalg.lstsq(jacobian, there - before, rcond=None)[0]
        x |= {name: x[name] - change for name, change in zip(names, step.tolist(), strict=True)}
        far = any(abs(x[name] - minimum.x[name]) > SEARCH_REACH for name in logs)
        if far or not all(map(math.isfinite, x.values())):
            raise SolveError(f"a step with a range of {show(length, 'length')} led nowhere")
        excess = (float(np.sum(weights * (there - jacobian @ step) ** 2)) - least) / variance
        moved = abs(_works(plain.values(x))[0] / works[0] - 1)
        if not (math.isfinite(excess) and excess < RANGE_HOPELESS * limit) or moved < RANGE_SHORT:
            break
    moves = {name: value - minimum.values[name] for name, value in plain.values(x).items()}
    return _Rung(length, excess if math.isfinite(excess) else math.inf, moves)


def _works(values: Values) -> list[float]:
    """The works of adhesion among ``values`` [J/m^2], that of the retraction first."""
    return [values[name] for name in WORKS if name in values]


# --------------------------------------------------------------------------------------------------
# How far a fit rests on its model: the nearest other models, which the data reject or not.
#
# There are three alternatives: a work of adhesion that changes along the record, moduli that do, as those of a layer or
# a base seem to, and adhesion that has a range (``range_alternative``). The first two add one direction each to the
# residuals, that of w or of the moduli times a straight line in the contact radius. Where an alternative is significant
# to first order, this is a warning. What the data leave of it is fitted again at both of its ends: it moves the
# parameters, a second part of their uncertainty beside the statistical one.

# What is expected of alternatives before the data, and when they are significant.
# choice: the change for which moves are told, and not counted, where the data hold no pull-off that would test it
ALTERNATIVE_UNIT = 0.01
ALTERNATIVE_CHANCE = 5e-3  # choice: at which data of the model itself show an alternative
ALTERNATIVE_CHANGES = (-0.7, 1.2)  # choice: guard, along the record; w and moduli stay above 0
ALTERNATIVE_CLOSE = 0.5  # theory: the last step, in standard errors; what remains is its square, a quarter
ALTERNATIVE_FEWEST = 6  # choice: degrees of freedom; two of them go to the alternatives
ALTERNATIVE_REACHED = 1.1  # choice: in contact radius, how near to pull-off the data must come
ALTERNATIVE_TOUCHING = 0.05  # choice: of the largest contact radius, below which pull-off without contact is near

# What changes along the record, how it is called, and where on the record the fitted value is meant to hold: 0 at the
# smallest contact radius (w there decides pull-off), 1/2 in the middle.
ALTERNATIVES = {"w": ("a change of w along the curve", 0.0), "modulus": ("a change of E* along the curve", 0.5)}
RANGE = "a range of adhesion"


@dataclass(frozen=True, eq=False)
class AddedTerm:
    """A model with one more number, the relative ``change`` of a parameter from the smallest to the largest contact
    radius; ``moves``: how far the changes that the data leave likely move each unknown."""

    name: str
    change: float
    moves: Values

    @property
    def words(self) -> str:
        """The change with its size, which is of first order and no number where it is beyond the guards."""
        clipped = float(np.clip(self.change, *ALTERNATIVE_CHANGES))
        return f"{ALTERNATIVES[self.name][0]} by {'' if clipped == self.change else 'more than '}{clipped:+.0%}"


@dataclass(frozen=True, eq=False)
class TableAlternatives:
    """The alternatives of a fit; ``chance``: that data of the model itself speak as much for its ``members``;
    ``range``: of adhesion, None where none was tried. ``untested``: whether the data end before pull-off, so that
    nothing tests a change along the record: the moves of the ``values`` are then those of a change by
    ``ALTERNATIVE_UNIT``, told and not counted."""

    members: tuple[AddedTerm, ...]
    chance: float
    range: RangeAlternative | None = None
    untested: bool = False
    values: Values = field(default_factory=dict)

    @property
    def sensitivity(self) -> str:
        """What a change along the record would move, where it is not counted; empty where it is."""
        if not (self.untested and self.members):
            return ""
        names, parts = {"w": "w", "modulus": "E*"}, []
        for one in self.members:
            moves = {name: one.moves[key] / self.values[key] for key, name in names.items() if one.moves.get(key)}
            words = " and ".join(f"{name} by {move:.1%}" for name, move in moves.items())
            parts.append(f"of {names[one.name]} moves {words}")
        return f"a change by {ALTERNATIVE_UNIT:.0%} along the curve {', '.join(parts)}"

    def warnings(self) -> Iterator[str]:
        """A sentence where an alternative is significant."""
        if self.chance < ALTERNATIVE_CHANCE:
            parts = " or ".join(alternative.words for alternative in self.members)
            yield (f"model rejected, p = {self.chance:.1g}, in favour of {parts} with the contact radius: other bodies "
                   "(a layer, a base), or adhesion that depends on speed or has a range; the statistical intervals "
                   "do not hold it")  # fmt: skip
        if self.range is not None:
            yield from self.range.warnings()

    def with_parts(self, estimates: Sequence[FittedValue]) -> tuple[FittedValue, ...]:
        """The ``estimates`` with what the alternatives may move each by; what follows from the moduli's factor with
        it."""
        moves = {} if self.untested else {ALTERNATIVES[one.name][0]: one.moves for one in self.members}
        moves |= {} if self.range is None else {RANGE: self.range.moves}
        modulus = next((item.value for item in estimates if item.name == "modulus"), 1.0)

        def part(item: FittedValue, by: Values) -> float:
            follows = item.value * by.get("modulus", 0.0) / modulus if item.dimension == "modulus" else 0.0
            return 0.0 if item.error is None else by.get(item.name, follows)

        parts = [{name: move for name, by in moves.items() if (move := part(item, by))} for item in estimates]
        return tuple(replace(item, model=own or None) for item, own in zip(estimates, parts, strict=True))


def missed_pull_off(a: Array, line: Mapping[str, Array]) -> tuple[float, float] | None:
    """The least radius [m] of the rows ``a`` and that of the least load of their ``line``, where they do not come near
    it; None where they do, or hold no loads."""
    if "P" not in line:
        return None
    radius, least = float(line["a"][int(np.argmin(line["P"]))]), float(np.min(a))
    near = max(ALTERNATIVE_REACHED * radius, ALTERNATIVE_TOUCHING * float(np.max(a)))
    return (least, radius) if least > near else None


def alternatives_of(minimum: Minimum, variance: float, dof: int, settings: Settings) -> TableAlternatives:
    """The alternatives of a ``minimum``; ``variance`` of the residuals and its degrees of freedom. None of few points,
    and of parameters that are 0."""
    residuals, values = minimum.distances.residuals.ravel(), minimum.values
    wanted = [name for name in ALTERNATIVES if values.get(name, 0.0) > 0]
    if dof < ALTERNATIVE_FEWEST or not wanted or not variance > 0:
        return TableAlternatives((), 1.0)
    t, both = t_quantile(settings.level, dof), dof * chi2_increase(settings.level, dof, 2)  # w and the range together
    ranged = range_alternative_of(minimum, variance, both, settings) if "w" in wanted else None
    jacobian = minimum.distances.jacobian(minimum.objective.unknowns.names)

    # Derivatives of the residuals by the relative change of a parameter along the record
    a, scales = minimum.distances.a, {p.name: p for p in minimum.objective.parameters}
    along, columns = (a - a.min()) / max(float(np.ptp(a)), TINY), []
    for name in wanted:
        parameter, x = scales[name], minimum.x[name]
        by_log = minimum.distances.jacobian([name])[:, 0] * parameter.outer(x) / parameter.derivative(x)
        columns.append(by_log * np.tile(along - ALTERNATIVES[name][1], by_log.size // a.size))
    directions = np.stack(columns, axis=1)
    alone = directions - jacobian @ np.linalg.lstsq(jacobian, directions, rcond=None)[0]
    alternatives, close = [], ALTERNATIVE_CLOSE * math.sqrt(variance)
    untested = values.get("w", 0.0) > 0 and missed_pull_off(minimum.distances.a, minimum.distances.line()) is not None
    for name, direction in zip(wanted, alone.T, strict=True):
        precision = float(direction @ direction) / variance
        if precision > 0:
            change = -float(direction @ residuals) / variance / precision
            spread = t / math.sqrt(precision + 1 / PRIORS[ALTERNATIVES[name][0]].width ** 2)
            centre = change * (spread / t) ** 2 * precision
            changes = (-ALTERNATIVE_UNIT, ALTERNATIVE_UNIT) if untested else (centre - spread, centre + spread)
            # How far the values of the free parameters move, at most
            before, radii = minimum.values, minimum.distances.a
            moves = dict.fromkeys(minimum.objective.unknowns.names, 0.0)
            for moved in changes:
                clipped = float(np.clip(moved, *ALTERNATIVE_CHANGES))
                drift = Drift(name, clipped, ALTERNATIVES[name][1], float(radii.min()), float(radii.max()))
                after = _followed(minimum, drift, close)
                moves = {key: max(move, abs(after[key] - before[key])) for key, move in moves.items()}
            alternatives.append(AddedTerm(name, change, moves))
    taken = residuals @ alone @ np.linalg.lstsq(alone, residuals, rcond=None)[0]  # of the squares by all together
    k = alone.shape[1]
    chance = float(f_tail(k, max(dof - k, 1), max(taken, 0.0) / k / variance))  # F test
    return TableAlternatives(tuple(alternatives), chance, ranged, untested, values)


def _followed(minimum: Minimum, drift: Drift, close: float) -> dict[str, float]:
    """The values of the parameters with a ``drift`` that leave the residuals as they are, as nearly as possible: what
    noise and outliers there are stays. Gauss-Newton, until a step changes the residuals by less than ``close``."""
    objective, free = replace(minimum.objective, drift=drift), minimum.objective.unknowns.free
    names, target = [parameter.name for parameter in free], minimum.distances.residuals.ravel()
    reach = np.array([SEARCH_REACH if parameter.kind == "log" else math.inf for parameter in free])
    x = before = start = np.array([minimum.x[name] for name in names])
    for _ in range(MOST_SOLVES):
        try:
            there = objective.distances({**minimum.x, **dict(zip(names, x.tolist(), strict=True))})
            jacobian = there.jacobian(names)
        except SolveError:  # a step to where no body can be solved
            x = (x + before) / 2
            continue
        before, step = x, np.linalg.lstsq(jacobian, there.residuals.ravel() - target, rcond=None)[0]
        x = np.clip(x - step, start - reach, start + reach)
        if np.linalg.norm(jacobian @ step) < close:
            break
    values = objective.values({**minimum.x, **dict(zip(names, x.tolist(), strict=True))})
    radii = np.array([there.a.min(), there.a.max()])  # the model's own, not those of before
    values[drift.name] *= float(drift.factor(radii) @ (1 - drift.centre, drift.centre))
    return values

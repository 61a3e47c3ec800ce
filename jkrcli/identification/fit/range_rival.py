"""The range of adhesion as a rival of JKR: how far ranges that the data do not exclude move what was fitted.

The curves are those of a constant tension up to the range (Maugis) on the body itself. A sphere's pull-off hardly
changes its shape with the range, but w and the zero of the displacement do: from displacement and load alone w of
JKR may be a fifth too large where the surfaces attract each other over as far as adhesion deforms them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import fdtrc

from ...base import MOST_SOLVES, NOTICEABLE, Array, JkrError, SolveError, show
from ...methods.layered.spectrum import spectrum_seconds
from ..parameters import Parameter
from .model import Objective
from .search import TUNING as SEARCH
from .search import Minimum
from .settings import Loss, Settings
from .statistics import influence


@dataclass(frozen=True)
class RangeRivalTuning:
    """Which ranges are tried, and when one is significant."""

    # Over the displacement that adhesion adds at JKR's pull-off; Tabor numbers of a sphere 3 to 0.03:
    ranges: tuple[float, ...] = (0.1, 0.3, 1.0, 3.0, 10.0)  # choice: what lies between is interpolated

    short: float = 0.1  # theory: relative change of w by the last step; what remains is its square, a hundredth
    hopeless: float = 30.0  # choice: excess over what is possible, from which on there are no more steps
    rounded: float = 0.05  # choice: of logs of range and w with which curves are solved, so that fits share them
    chance: float = 2e-3  # choice: at which data of JKR itself show a range
    slow: float = 0.1  # choice: CPU seconds of a body's spectrum, above which no range is tried


TUNING = RangeRivalTuning()
WORKS = ("w", "w_approach")


@dataclass(frozen=True, eq=False)
class RangeRival:
    """The ranges [m] that the data leave: the ``best`` of those tried, 0 for JKR, and the ``most``; ``moves``: how far
    they move each parameter. ``chance``: that data of JKR itself speak as much for one."""

    best: float
    most: float
    moves: Mapping[str, float]
    chance: float

    @property
    def significant(self) -> bool:
        return self.best > 0 and self.chance < TUNING.chance

    def warnings(self) -> Iterator[str]:
        """A sentence where a range is significant."""
        if self.significant:
            yield (
                f"model rejected, p = {self.chance:.1g}, in favour of adhesion with a range of "
                f"about {show(self.best, 'length', 2)}: fit with --free range"
            )


@dataclass(frozen=True, eq=False)
class _Rung:
    """A range [m], the sum of squares with it less JKR's, over the variance, and by how much it moves each value."""

    length: float
    excess: float
    moves: Mapping[str, float]


def range_rival_of(minimum: Minimum, variance: float, limit: float, settings: Settings) -> RangeRival | None:
    """The ranges that the data leave; None where none can be tried: bodies without such curves, layers that are
    fitted, cylinders and gradients, whose kernels would take longer than the fit.

    ``variance`` of the residuals; ``limit``: rise of the sum of squares over it, up to which a range is possible. None
    is tried that is longer than the ``settings`` allow.
    """
    body = minimum.objective.body
    problem = body.problem
    own, values = any(p.of_body for p in minimum.objective.parameters), minimum.objective.values(minimum.x)
    if own or problem.specimen.radius is not None or spectrum_seconds(problem) > TUNING.slow:
        return None
    if min(_works(values)) < NOTICEABLE * values["modulus"] * body.family.natural_work:
        return None
    try:
        body.coarse.attracted  # noqa: B018  a Refusal where there is none
    except JkrError:
        return None
    neck = math.log(body.family.neck(values["modulus"], values["w"]))
    neck = math.exp(TUNING.rounded * round(neck / TUNING.rounded))
    lengths = [part * neck for part in TUNING.ranges if part * neck < settings.range_at_most]
    lengths += [settings.range_at_most] * (len(lengths) < len(TUNING.ranges))
    rungs = _climbed(
        lengths, partial(_rung, minimum, variance=variance, limit=limit, loss=settings.loss), values, limit
    )
    return _judged(rungs, minimum, limit)


def _climbed(
    lengths: Sequence[float], rung_of: Callable[[float], _Rung], values: Iterable[str], limit: float
) -> list[_Rung]:
    """The rungs of JKR and of those ``lengths`` [m] that bracket the longest possible range, by increasing length.

    From the middle on they are climbed while they are possible, else descended until one is; the bracket beyond the
    longest possible one is halved.
    """
    rungs, best = {-1: _Rung(0.0, 0.0, dict.fromkeys(values, 0.0))}, 0.0
    k, step = min(len(TUNING.ranges) // 2, len(lengths) - 1), 0
    while 0 <= k < len(lengths):
        try:
            rungs[k] = rung_of(lengths[k])
        except JkrError:  # attraction reaches beyond the body, or the step led nowhere
            if step > 0:
                break
            step = -1
        else:
            best = min(best, rungs[k].excess)
            possible = rungs[k].excess - best <= limit
            if (step == -1 and possible) or (step == 1 and not possible):
                break
            step = 1 if possible else -1
        k += step
    climbed = [rungs[k] for k in sorted(rungs)]
    with contextlib.suppress(JkrError):
        for _ in range(SEARCH.halvings):
            if (length := _between(climbed, limit)) is not None:
                climbed.append(rung_of(length))
                climbed.sort(key=lambda rung: rung.length)
    return climbed


def _last_possible(rungs: Sequence[_Rung], limit: float) -> int:
    """The index of the longest of the ``rungs``, by increasing length, that is within the ``limit`` of the best."""
    best = min(rung.excess for rung in rungs)
    return max(i for i, rung in enumerate(rungs) if rung.excess - best <= limit)


def _between(rungs: Sequence[_Rung], limit: float) -> float | None:
    """A range [m] between the longest possible one and the next, where a straight line between
    them would not do; None where it does."""
    i = _last_possible(rungs, limit)
    if i == 0 or i + 1 == len(rungs) or rungs[i + 1].excess > TUNING.hopeless * limit:
        return None
    return math.sqrt(rungs[i].length * rungs[i + 1].length)


def _rung(minimum: Minimum, length: float, variance: float, limit: float, loss: Loss) -> _Rung:
    """The parameters with a range of ``length`` [m], by Gauss-Newton steps from JKR's minimum."""
    plain = minimum.objective
    ranged = (*plain.parameters, Parameter("range", False, length))
    objective = replace(plain, body=plain.body.coarse, parameters=ranged)
    free, before = plain.free, minimum.distances.residuals.ravel()
    jacobian, weights = minimum.distances.jacobian(free), _weights(minimum, loss)
    least, x = float(np.sum(weights * before**2)), minimum.x.copy()
    for _ in range(MOST_SOLVES):
        if min(works := _works(plain.values(x))) <= 0:
            raise SolveError(f"a range of {show(length, 'length')} leaves no work of adhesion")
        x = _rounded(plain, x)
        there = objective.distances(np.append(x, math.log(length)), rated=False).residuals.ravel()
        step = np.linalg.lstsq(jacobian, there - before, rcond=None)[0]
        x[free] -= step
        if not _near(plain, x, minimum.x):
            raise SolveError(f"a step with a range of {show(length, 'length')} led nowhere")
        excess = (float(np.sum(weights * (there - jacobian @ step) ** 2)) - least) / variance
        moved = abs(_works(plain.values(x))[0] / works[0] - 1)
        if not (math.isfinite(excess) and excess < TUNING.hopeless * limit) or moved < TUNING.short:
            break
    return _Rung(length, excess if math.isfinite(excess) else math.inf, _moves(plain, minimum.x, x))


def _near(objective: Objective, x: Array, start: Array) -> bool:
    """Whether all unknowns are numbers and their logs are within reach of where they started."""
    logs = [i for i, parameter in enumerate(objective.parameters) if parameter.kind == "log"]
    return bool(np.isfinite(x).all() and (np.abs(x - start)[logs] <= SEARCH.reach).all())


def _rounded(objective: Objective, x: Array) -> Array:
    """The unknowns with w at a rounded ratio to the moduli, where it is free."""
    values, near = objective.values(x), x.copy()
    for i, parameter in enumerate(objective.parameters):
        if parameter.free and parameter.name in WORKS:
            ratio = round(math.log(values[parameter.name] / values["modulus"]) / TUNING.rounded)
            near[i] = parameter.inner(values["modulus"] * math.exp(TUNING.rounded * ratio))
    return near


def _works(values: Mapping[str, float]) -> list[float]:
    """The works of adhesion among ``values`` [J/m^2], that of the retraction first."""
    return [values[name] for name in WORKS if name in values]


def _weights(minimum: Minimum, loss: Loss) -> Array:
    """What each residual counts for in the loss, 1 in least squares."""
    z = minimum.distances.residuals.ravel() / minimum.width
    psi, _ = influence(z, loss)
    return np.divide(psi, z, out=np.ones_like(z), where=z != 0)


def _moves(objective: Objective, before: Array, after: Array) -> dict[str, float]:
    one, other = objective.values(before), objective.values(after)
    return {name: other[name] - value for name, value in one.items()}


def _judged(rungs: Sequence[_Rung], minimum: Minimum, limit: float) -> RangeRival:
    """The rival by its ``rungs``, by increasing length: those within the ``limit`` of the best are possible, and
    between the longest of them and the next the root of the excess is a straight line."""
    best, i = min(rungs, key=lambda rung: rung.excess), _last_possible(rungs, limit)
    last, possible = rungs[i], [rung for rung in rungs if rung.excess - best.excess <= limit]
    most, moves = last.length, {key: max(abs(rung.moves[key]) for rung in possible) for key in last.moves}
    if i + 1 < len(rungs):
        beyond = rungs[i + 1]
        low, high = (math.sqrt(rung.excess - best.excess) for rung in (last, beyond))
        part = (math.sqrt(limit) - low) / (high - low) if math.isfinite(high) else 0.0
        # A short range counts by its square, as the work within the annulus does.
        most = math.sqrt(last.length**2 + part * (beyond.length**2 - last.length**2))
        ends = {key: abs(move + part * (beyond.moves[key] - move)) for key, move in last.moves.items()}
        moves = {key: max(move, ends[key]) for key, move in moves.items()}
    n = minimum.distances.residuals.size - minimum.objective.free.size
    return RangeRival(best.length, most, moves, float(fdtrc(1, max(n - 1, 1), max(-best.excess, 0.0))))

"""The search for the unknowns of a force curve, and its end: estimates, covariance, noise."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import MOST_SOLVES, SAME, Array, SolveError
from ...data import APPROACH
from ..least_squares import Least, LeastSquares, State
from .coloured import Spectrum, Spread
from .coloured import spread as covariance
from .force_curve import ForceCurveModel
from .force_curve_readings import DirectionReadings
from .force_curve_starts import by_base_lines, starts_of
from .settings import Loss
from .statistics import TURNS, influence, robust_scale


@dataclass(frozen=True)
class ForceCurveFitTuning:
    """How starts are tried, and when a search ends."""

    window: float = 4.0  # choice: standard errors of z0 and w that the window about first touch covers
    beside: float = 2.0  # choice: rows on each side of first touch, at least, that belong to the window
    narrow: float = 0.3  # choice: of the depth of contact, that the window covers at most
    above: float = 1.1  # theory: any w above what the last row at rest holds gives the same loads
    recedes: float = 12.0  # theory: fall of chi^2 by one unknown that chance brings once in 2000
    explained: float = 1.05  # choice: of the noise, residuals that the search is not begun anew for
    enough: float = 1.5  # choice: of the noise, residuals that no other start is tried below
    blunt: tuple[float, ...] = (1e-2, 1e-3, 1e-5)  # choice: of the depth of contact, for a blunt fold while searching
    moduli: float = 10.0  # choice: of ln s about its start, where the search may go
    periods: float = 0.3  # choice: the same of the log of a wave's period
    converged: float = 1e-11  # choice: relative change of parameters
    fell: float = 1e-8  # theory: of chi^2 of 1e4 rows, its rise a hundredth of a standard error from the minimum
    unsure: float = 0.1  # choice: of the way in contact, the most that the place of a fold is taken to be uncertain by
    narrower: float = 2.0  # choice: factor between two estimates of it, below which they agree
    corrected: int = 2  # choice: times that a neighbour's moduli are corrected, by a factor of e at most each
    near: float = 0.1  # choice: of chi^2, the fall still to be had a third of a standard error from its minimum
    evaluations: int = 80  # choice: steps after which the search gives up


TUNING = ForceCurveFitTuning()


@dataclass(frozen=True, eq=False)
class ForceCurveFit:
    """The model that fits best: ``values`` and standard errors by name; ``off`` residuals [N] of all rows.

    ``sigma``: standard deviation of a reading about the model [N]; ``weight``: the noise that rows were weighted by;
    ``spread``: covariance of the unknowns, and the noise that it rests on. ``least``: as the search sees it, in units
    of ``weight``. ``ended``: whether it is a minimum, and not where the search was given up.
    """

    model: ForceCurveModel
    x: Array
    weight: Spectrum
    spread: Spread
    off: Array
    sigma: float
    least: Least
    ended: bool

    @property
    def names(self) -> tuple[str, ...]:
        return self.model.names

    @property
    def covariance(self) -> Array:
        return self.spread.covariance

    def value(self, name: str) -> float:
        return float(self.x[self.names.index(name)])

    def error(self, name: str) -> float:
        i = self.names.index(name)
        return math.sqrt(self.covariance[i, i])

    def unknowns(self, model: ForceCurveModel) -> Array:
        """Those of a ``model`` that may know fewer of them."""
        return model.unknowns(self.model.values(self.x))

    def at_loads(self, factor: float) -> Array:
        """The unknowns as they are about where all loads are ``factor`` times as large."""
        loads = np.array([name.startswith(("offset:", "tilt:", "cos:", "sin:")) for name in self.names], dtype=bool)
        ln_s = np.array([name == "ln_s" for name in self.names])
        return np.where(loads, factor * self.x, self.x) + np.where(ln_s, math.log(factor), 0.0)


def _even(model: ForceCurveModel) -> Spectrum:
    """White noise as large as the range of the loads: the weight while nothing is known of it."""
    return Spectrum(max(float(np.ptp(part.P)) for part in model.stretches) ** 2)


def _state(model: ForceCurveModel, weight: Spectrum, blunt: float, x: Array) -> State:
    """The residuals, weighted by noise."""
    off, rates = model.residuals(x, blunt)
    return State(model.whitened(off, weight), partial(model.whitened, rates, weight))


def _problem(
    model: ForceCurveModel, weight: Spectrum, bounds: tuple[Array, Array], blunt: float, enough: float
) -> LeastSquares:
    return LeastSquares(partial(_state, model, weight, blunt), bounds, enough, TUNING.fell, TUNING.evaluations)


def misfit_at(model: ForceCurveModel, x: Array) -> float:
    """Half the sum of squares at the unknowns ``x``, of loads over their range."""
    off = _state(model, _even(model), TUNING.blunt[-1], np.clip(x, *_bounds(model, x))).residuals
    return float(off @ off) / 2


def rough(model: ForceCurveModel, start: Array, steps: int) -> tuple[float, Array]:
    """Half the sum of squares that is left, of loads over their range, and the unknowns that leave about least, by a
    search from ``start`` on of a few ``steps``."""
    problem = _problem(model, _even(model), _bounds(model, start), TUNING.blunt[1], SAME)
    least = replace(problem, evaluations=steps).least(start)
    return least.cost, least.x


def fit(model: ForceCurveModel, start: Array, near: bool = False, loss: Loss = "linear") -> ForceCurveFit:
    """The unknowns that leave least, first of a few rows and with a blunt fold unless ``start`` is ``near``, then of
    all as they are; then weighted by the noise of the free rows where that has a colour. Where the rows do not
    determine them the search creeps along a valley: it is given up, and the fit reports it."""
    bounds, even = _bounds(model, start), _even(model)
    x, sharp = np.clip(start, *bounds), TUNING.blunt[-1]
    few = model
    if "turn" not in model.names:  # of a retraction alone other minima are near
        few = replace(model, stretches=tuple(part.thinned() for part in model.stretches))
    whole = _problem(model, even, bounds, sharp, TUNING.converged)
    slow = TUNING.blunt[: -1 if few is model else None]
    for stages in [()] if near else [slow] if few is model else [TUNING.blunt[1:2], slow]:
        begun = x
        for blunt in stages:
            begun = _problem(few, _even(few), bounds, blunt, SAME).least(begun).x
        least = whole.least(begun)
        if least.ended and 2 * least.cost * even.A < (TUNING.explained * model.noise) ** 2 * least.state.residuals.size:
            break  # no other minimum leaves less than the noise
    about = _problem(model, even, bounds, sharp, SAME)
    if not least.ended:  # of few rows at the fold each makes a kink, between which a search runs to and fro
        least = about.least(least.x)
    for _ in range(2 * (loss != "linear")):
        width = TURNS[loss] * robust_scale(least.state.residuals)
        least = replace(about, loss=loss, width=width).least(least.x)
    best = _fitted(model, least, even)
    noise = best.spread.noise
    if loss != "linear" or not noise.slow:
        return best
    x = best.unknowns(model)  # an edge that rests by white noise need not by this one
    for blunt in (sharp, TUNING.blunt[1]):  # where misfit runs to and fro between the kinks of a sharp fold
        weighted = _fitted(model, _problem(model, noise, _bounds(model, x), blunt, SAME).least(x), noise)
        if weighted.ended:
            break
    return weighted


def _fitted(model: ForceCurveModel, least: Least, weight: Spectrum) -> ForceCurveFit:
    """What the end of a search means."""
    before, sharp, (model, x) = least.problem, TUNING.blunt[-1], _without_idle(model, least.x, weight)
    problem = replace(before, model=partial(_state, model, weight, sharp), bounds=_bounds(model, x))
    off = model.residuals(x, sharp)[0]
    least = replace(least, problem=problem, x=x, state=_state(model, weight, sharp, x))
    size = before.width * math.sqrt(_even(model).A)
    psi, slope = influence(off / size, before.loss)
    pull = psi * size / max(float(np.mean(slope)), 0.1)  # what a row pulls with (Huber 1981, Sec. 7.6)
    dof = max(off.size - x.size, 1)
    J, spread = _spread_at_folds(model, x, off, pull, weight)
    ended = least.ended or _flat(model.whitened(pull, weight), model.whitened(J, weight), TUNING.near / dof)
    return ForceCurveFit(model, x, weight, spread, off, math.sqrt(float(pull @ pull) / dof), least, ended)


def _spread_at_folds(
    model: ForceCurveModel, x: Array, off: Array, pull: Array, weight: Spectrum
) -> tuple[Array, Spread]:
    """Derivatives of all rows, (rows, unknowns), and the covariance by them, residuals ``off`` and what rows ``pull``
    with [N].

    From a fold on loads rise with the root of the distance: their slope there holds no nearer to it than its place is
    known to, nor than half of the way between two rows. White noise leaves it known to about that.
    """
    residuals, free = model.ordered(pull, weight), model.free(off)
    rounding = max(part.line.rounding for part in model.stretches) ** 2

    def spread_by(J: Array) -> Spread:
        return covariance(residuals, model.ordered(J, weight), free, weight, rounding)

    J = model.residuals(x, 0.0)[1]
    spread, first = spread_by(J), 0
    for part in model.stretches if weight.slow and "z0" in model.names else ():
        rows = slice(first, first := first + part.z.size)
        lost, width = rows.start + int(np.argmax(part.touching)), TUNING.unsure * part.reach
        if not part.jumped or _place_error(model, J[lost], spread) <= part.spacing:
            continue
        J = J.copy()
        for _ in range(MOST_SOLVES):
            J[rows] = model.evaluated(x, width / part.reach)[1][rows]
            spread = spread_by(J)
            error = max(_place_error(model, J[lost], spread), part.spacing / 2)
            if TUNING.narrower * error > width:
                break
            width = error
    return J, spread


def _place_error(model: ForceCurveModel, slopes: Array, spread: Spread) -> float:
    """The standard error [m] of the place of a fold, where loads change by ``slopes`` with the unknowns."""
    rise = abs(float(slopes[model.names.index("z0")]))
    return math.sqrt(max(float(slopes @ spread.covariance @ slopes), 0.0)) / rise if rise else 0.0


def _flat(off: Array, J: Array, share: float) -> bool:
    """Whether a step of Gauss and Newton would lower chi^2 by less than a ``share`` of it."""
    step = J @ np.linalg.lstsq(J, off, rcond=None)[0]
    return float(step @ step) < share * float(off @ off)


def _without_idle(model: ForceCurveModel, x: Array, weight: Spectrum) -> tuple[ForceCurveModel, Array]:
    """The model and its unknowns without those that no row depends on, which are known then: the share of an edge that
    never rests, w of an edge that rests throughout, which is at least what its last row holds."""
    idle = ~model.residuals(x, 0.0)[1].any(axis=0)
    idle |= (np.array(model.names) == "turn") & (np.abs(x) == 1)
    values, last = model.values(x), model.stretches[-1]
    own = f"q:{last.kind}"
    adheres = own in model.names and last.touching.any() and (last.tension > 0 or not last.line.rows)
    most = held_by_last_row(model, values) if adheres else None
    if most is not None and _rests_throughout(model, x, own, most, weight):
        idle |= np.array(model.names) == own
        values[own] = most
    known = {name: values[name] for name, no in zip(model.names, idle, strict=True) if no}
    return (replace(model, known={**model.known, **known}), x[~idle]) if known else (model, x)


def held_by_last_row(model: ForceCurveModel, values: Mapping[str, float]) -> float | None:
    """The q that the last row of an edge that rests throughout holds; None where it does not rest."""
    last = model.stretches[-1]
    if (resting := model.rest(last, values)) is None:
        return None
    lost = float(model.depth(last, values)[last.touching].min())
    return resting.released(math.sqrt(max(values[f"q:{last.kind}"], 0.0)), lost) ** 2


def _rests_throughout(model: ForceCurveModel, x: Array, own: str, most: float, weight: Spectrum) -> bool:
    """Whether an edge that never recedes, as of a w above ``most``, describes the rows as well, in units of noise."""
    never = np.where(np.array(model.names) == own, min(TUNING.above * most, model.most), x)
    with contextlib.suppress(SolveError):  # no contact bears that
        recedes, rests = (float(np.sum(model.whitened(model.residuals(at, 0.0)[0], weight) ** 2)) for at in (x, never))
        return (rests / recedes - 1) * sum(part.P.size for part in model.stretches) < TUNING.recedes
    return False


def windowed(best: ForceCurveFit) -> ForceCurveModel:
    """The model without the rows about first touch where no jump shows which of them are in contact: the load is
    not smooth there in z0 and w. The same model where there are none."""
    parts = tuple(part if part.jumped else _windowed(best, part) for part in best.model.stretches)
    return best.model if parts == best.model.stretches else replace(best.model, stretches=parts)


def _windowed(best: ForceCurveFit, part: DirectionReadings) -> DirectionReadings:
    """A stretch whose rows are free up to the window and in contact beyond."""
    values = best.model.values(best.x)
    depth, own = best.model.depth(part, values), f"q:{part.kind}"
    error = best.error(own) if own in best.names else 0.0
    most = values | {own: max(values[own], 0.0) + TUNING.window * error}
    neck = 0.0 if part.kind == APPROACH else -best.model.branch(part, most).fold
    unsure = best.error("z0") if "z0" in best.names else 0.0
    half = neck + max(TUNING.window * unsure, TUNING.beside * part.spacing)
    half = min(half, TUNING.narrow * float(depth.max()))
    if half <= 0:
        return part  # no row of it is in contact
    keep = np.abs(depth) > half
    cut = {name: getattr(part, name)[keep] for name in ("rows", "z", "P", "t")}
    return replace(part, touching=(depth > 0)[keep], jumped=True, **cut)


def _bounds(model: ForceCurveModel, start: Array) -> tuple[Array, Array]:
    """Least and largest unknowns of a search from ``start`` on."""
    names = np.array(model.names, dtype=str)
    reach = np.select([names == "ln_s", names == "ln_period"], [TUNING.moduli, TUNING.periods], np.inf)
    lowest, highest = start - reach, start + reach
    for prefix, high in (("q:", model.most), ("r:", math.sqrt(model.most)), ("turn", 1.0)):
        own = np.char.startswith(names, prefix)
        lowest, highest = np.where(own, -high, lowest), np.where(own, high, highest)
    least, most = np.array([model.limits.get(name, (-np.inf, np.inf)) for name in model.names]).T
    return np.maximum(lowest, least), np.minimum(highest, most)


class Neighbour:
    """Where the search of one record ended, for that of the next one of a map."""

    def __init__(self) -> None:
        self.last: ForceCurveFit | None = None

    def start(self, model: ForceCurveModel) -> Array | None:
        """Unknowns of a ``model`` about as the last record's were: w in proportion to the tension, the contact lost at
        the outermost row that is in contact for sure, moduli as the deepest one asks for; None where it has others."""
        last = self.last
        if last is None or last.names != model.names or model.positions or any(one.wave for one in model.stretches):
            return None
        outermost, part, before = _outermost(model), model.stretches[-1], last.model.stretches[-1]
        if outermost is None:
            return None
        values = {**last.model.values(last.x), **by_base_lines(model)}
        values = _times_q(values, part.tension / before.tension if before.tension > 0 else 1.0)
        with contextlib.suppress(SolveError):  # no contact bears that
            for _ in range(TUNING.corrected):
                values["z0"] = outermost - model.branch(part, values).fold - part.spacing / 2
                rise = _by_deepest_row(model, values) if "ln_s" in model.names else 0.0
                values = {**_times_q(values, math.exp(-rise)), "ln_s": values["ln_s"] + rise}
            return model.unknowns(values)
        return None


def _times_q(values: Mapping[str, float], factor: float) -> dict[str, float]:
    """The unknowns with q of all stretches times a factor, and its roots."""
    powers = {"q": 1.0, "r": 0.5}
    return {name: value * factor ** powers.get(name.partition(":")[0], 0.0) for name, value in values.items()}


def _by_deepest_row(model: ForceCurveModel, values: Mapping[str, float]) -> float:
    """By how much ln s is to rise at equal w, so that the deepest row of the first direction is met, to first order."""
    part, q = model.stretches[0], values[f"q:{model.stretches[0].kind}"]
    deepest = int(np.argmax(part.z))
    P, (by_s, by_q, _) = model.branch(part, values).at(part.z[[deepest]] - values["z0"], part.spacing / 2)
    rate = float(by_s[0] - q * by_q[0])
    rise = float(part.P[deepest] - part.line(part.z[deepest]) - P[0]) / rate if rate > 0 else 0.0
    return min(max(rise, -1.0), 1.0)


def _outermost(model: ForceCurveModel) -> float | None:
    """The position [m] of the outermost row of the last direction that is in contact for sure."""
    part = model.stretches[-1]
    return float(part.z[part.touching].min()) if part.jumped else None


def nearest(model: ForceCurveModel, loss: Loss = "linear", near: Array | None = None) -> ForceCurveFit:
    """The unknowns that leave least, from several starts until one leaves no more than noise, ``near`` being the first
    one; SolveError where no search converges. Of a retraction alone all are tried: only its shape shows how far its
    edge rests."""
    if near is not None and "turn" not in model.names:
        with contextlib.suppress(SolveError):
            fitted = fit(model, near, True, loss)
            if fitted.ended and _explains(fitted, model, TUNING.explained):
                return fitted
    best: ForceCurveFit | SolveError = SolveError("no curve of this body resembles the record")
    for close, x in itertools.chain(((False, x) for x in starts_of(model)), ((True, x) for x in _of_each(model, loss))):
        try:
            fitted = fit(model, x, close, loss)
        except SolveError as error:
            best = error if isinstance(best, SolveError) else best
            continue
        if isinstance(best, SolveError) or (not fitted.ended, fitted.sigma) < (not best.ended, best.sigma):
            best = fitted
        if "turn" not in model.names and _explains(best, model, TUNING.enough):
            break
    if isinstance(best, SolveError):
        raise best
    return best


def _explains(fitted: ForceCurveFit, model: ForceCurveModel, enough: float) -> bool:
    """Whether a fit leaves no more than ``enough`` of the noise, with all unknowns of a ``model``: an edge that rests
    throughout may be a valley beside that of one that recedes."""
    return fitted.sigma <= enough * model.noise and fitted.names == model.names


def _of_each(model: ForceCurveModel, loss: Loss) -> Iterator[Array]:
    """Unknowns of several directions as fits of each alone have them, moduli and the zero as either does."""
    if len(model.stretches) == 1:
        return
    alone: list[dict[str, float]] = []
    for part in model.stretches:
        with contextlib.suppress(SolveError):
            one = nearest(replace(model, stretches=(part,)), loss)
            values = one.model.values(one.x)
            alone.append(values | {f"r:{part.kind}": math.sqrt(max(values[f"q:{part.kind}"], 0.0))})
    if len(alone) == len(model.stretches):
        together = {name: value for values in alone for name, value in values.items()}
        yield from (model.unknowns({**together, **{n: v[n] for n in ("ln_s", "z0")}}) for v in alone)

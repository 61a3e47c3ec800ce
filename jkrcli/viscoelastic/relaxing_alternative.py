"""A viscoelastic specimen that adheres, as an alternative of a raw record: a first look asks, a fit of the whole record
answers.

No column says what memory does to an adhesive contact: w acts at the moduli of the edge's speed, which passes for a
change of w, of the tip or of positions. So whatever rejects a record's model asks for it. In full the body is a
standard solid with w and its cohesive stress, through all rows in their order of time (``adhesive_fit.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base.errors import JkrError
from ..base.numerics import Array, f_chance, half_width
from ..base.units import show
from ..measured.alternative_fits import chi2_of
from ..measured.curve import Curve
from ..measured.fitted_record import FittedRecord
from ..measured.force_curve import ForceCurveFit
from ..measured.grade import UNEXPLAINED, misfits
from ..measured.least_squares import STATISTICS_IMPROBABLE, wider
from ..measured.model_changes import MEMORY
from ..measured.parameters import FittedValue
from ..measured.record import line_of
from ..measured.result import Fit
from ..measured.score_tests import (
    DETECTED,
    SCORE_TIED,
    FittedAlternative,
    RecordAlternatives,
    Score,
    chance_of,
    least_taken,
)

RELAXING = "relaxation under adhesion"
RELAXING_ROWS = 4000  # choice: of even steps, from which the fit is made at most; the others count as these do
# theory: Schwarz's criterion, what an unknown costs of chi^2 is the log of the rows; ratio, time and stress stand for
# w of the approach
RELAXING_MORE = 2


@dataclass(frozen=True, eq=False)
class RelaxingAnswer:
    """The fit of a record by a viscoelastic specimen that adheres: as an ``alternative``, its ``estimates``, and what
    it leaves ``off`` the rows [N] that it is compared on, nan in others."""

    alternative: FittedAlternative
    estimates: tuple[FittedValue, ...]
    off: Array

    def __call__(self, plain: Fit, fit: ForceCurveFit) -> Fit:
        """Return ``plain`` with the estimates of the viscoelastic fit; ``fit``: of the same rows without."""
        own = {item.name: item for item in self.estimates}
        before, t = {item.name: item for item in plain.estimates}, half_width(plain.settings.level)
        for name in own.keys() & before.keys() & {"E_star", "modulus", "w"}:  # errors of inputs, to first order
            share = own[name].value / (before[name].value or math.inf)
            inputs = {key: share * error for key, error in (before[name].systematic or {}).items()}
            own[name] = wider(own[name], inputs, t)
        E_star, elastic, others = own["E_star"], before["E_star"].value, list[FittedValue]()
        for item in (item for item in plain.estimates if item.name not in OF_ONE_MODULUS):
            if item.dimension == "modulus":  # of a part of the body, as many times E* as it was
                ends = E_star.error, E_star.low, E_star.high
                error, low, high = (None if end is None else item.value / elastic * end for end in ends)
                value = item.value / elastic * E_star.value
                item = replace(E_star, name=item.name, value=value, error=error, low=low, high=high)
            others.append(own.pop(item.name, item))
        here = replace(fit, off=np.where(np.isfinite(self.off), self.off, fit.off))
        return replace(
            plain, estimates=(*others, *own.values()), free=tuple(item.name for item in self.estimates if item.free),
            covariance=None, samples=None, line=line_of(here),
            residuals=here.off[np.argsort(fit.model.rows, kind="stable")][None] / fit.sigma,
            flags=tuple(flag for flag in plain.flags if flag != UNEXPLAINED),
            sizes={**(plain.sizes or {}), **misfits(here, fit.model.noise)},
            warnings=tuple(line for line in plain.warnings if line.partition(":")[0] not in (UNEXPLAINED, "drift")),
        )  # fmt: skip


OF_ONE_MODULUS = ("w_approach",)  # estimates that a history has none of


def with_relaxation(
    record: FittedRecord, curve: Curve, found: RecordAlternatives, unexplained: bool
) -> tuple[RecordAlternatives, RelaxingAnswer | None, str]:
    """The alternatives ``found`` by one step with that of a viscoelastic specimen that adheres among the named, the
    first where it leaves no more than noise; its answer, and a sentence. As they are where none is named and no misfit
    is ``unexplained``, the record does not adhere, no time is read, or it leaves as much as they do."""
    most = max((one.taken for one in found.named), default=0.0)
    adheres = len(record.model.stretches) > 1 and record.model.stretches[-1].tension > 0
    told = record.model.positions or record.model.works or "ln_s" in record.model.known  # by the user, or w is 0
    if not (found.named or unexplained) or not adheres or curve.t is None or told:
        return found, None, ""
    from .relaxation_fit import relaxation_fit
    from .timed_record import relaxation_settings

    most_left = max((found.misfit - max(least_taken(most), SCORE_TIED)) / found.dof, 1.0)
    settings = relaxation_settings(
        "sls", [], ["w"], record.body.problem.E_star, level=record.known.level, most=most_left
    )
    step = math.ceil(len(curve) / RELAXING_ROWS)
    few = np.arange(0, len(curve), step)
    try:
        fit = relaxation_fit(record.body, curve.rows(few), settings)
    except JkrError:  # no such history resembles the record
        return found, None, ""
    at_once = fit.estimate("E_star")
    if not (at_once.low and fit.modulus(np.ptp(curve.time, keepdims=True))[0, 2] < at_once.low):
        return found, None, ""  # nothing is certain to relax: a cohesive stress alone takes as much
    off = np.full(len(curve), np.nan)
    off[few] = fit.response - curve.load[few]
    off = off[record.model.rows]
    rows = record.off_folds & np.isfinite(off)
    before, left = (chi2_of(one[rows], record.model.rows[rows], record.fit.spread.noise)
                    for one in (record.residuals, off))  # fmt: skip
    falls = step * (before - left) - RELAXING_MORE * math.log(step * np.count_nonzero(rows))
    if falls < step * SCORE_TIED or falls < least_taken(most):
        return found, None, ""

    # One that leaves no more than noise is the first; beside another misfit it may be a part of it
    amount, error = 1 - fit.value("ratio"), fit.estimate("ratio").error or math.inf
    dof = max(int(np.count_nonzero(rows)) - len(fit.free), 1)
    chance = f_chance(dof, max(found.loose, 1), left / dof)
    alternative = FittedAlternative(
        RELAXING, MEMORY, falls, chance, chance > STATISTICS_IMPROBABLE, at_once.value, fit.value("w"),
        {"fall": amount, "relaxation_time": fit.value("time")},
    )  # fmt: skip
    # The same as a score test would give it: the moduli fall by the amount in the end, E* and w are those at once
    by_E = math.log(alternative.E_star / record.E_star) / amount
    by_w = math.log(alternative.w / record.work) / amount
    score = Score(
        RELAXING, MEMORY, "fall", False, amount, error, chance_of(record.fit, falls), falls,
        min(falls / found.misfit, 1.0), by_E, by_w, 0.0, 1.0, DETECTED, record.known.quantile,
    )  # fmt: skip
    named = (*found.named, score)
    if alternative.taken and falls > most - SCORE_TIED:
        named = (score, *(one for one in found.named if one.taken > least_taken(falls)))
    words = (
        f"{RELAXING}: E* = {show(alternative.E_star, 'modulus', 4)} at once, {fit.value('ratio'):.3g} of it at rest, "
        f"over {show(fit.value('time'), 'time', 3)}, w = {show(alternative.w, 'work', 4)}: --relaxation sls --free w"
    )
    alternatives = replace(found, scores=(score, *found.scores), named=named)
    return alternatives, RelaxingAnswer(alternative, fit.estimates, off), words

"""What a fit of a raw record says of itself: flags, quality, sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...base import Array, show
from ...data import APPROACH, RETRACT, ForceCurve
from .force_curve_fit import ForceCurveFit
from .one_more import drift_left_out
from .settings import Settings


@dataclass(frozen=True)
class RecordFlagsTuning:
    """What raises a flag."""

    misfit: float = 0.03  # choice: residual over the range of the load above which the model does not describe it
    vague: float = 0.1  # choice: noise over the range, error of the contact point over the depth: little is known
    spoilt: float = 0.1  # choice: factor of the quality for each thing that is wrong with the record itself
    dependent: float = 2.0  # choice: rows worth one above which a warning tells
    sure: float = 3.0  # choice: standard errors of w below 0, or of a drift, that are no noise
    excess: float = 4.0  # choice: of the standard errors, what misfit would add to them where its flag is raised


TUNING = RecordFlagsTuning()
RESTS = "w: the edge of the contact rests in all rows of the retraction, w is at least what the last holds"
NAMES = {APPROACH: APPROACH, RETRACT: "retraction"}

GIVEN_UP = "the search stopped after {} steps, the rows do not determine the unknowns: fix one (--fix w=...)"


def judgement(record: ForceCurve, best: ForceCurveFit, a: Array) -> tuple[dict[str, str], dict[str, float]]:
    """Flags of the fit itself with a sentence each, and the parts of its quality, each between 0 and 1.

    Each part is exp(-x^2/2) of a number x that is 1 where its flag is raised: misfit (slow residuals in contact over
    the range of the load), noise (over the range), base line (waviness over the range), contact (error of the contact
    point over the depth); "record" is ``spoilt`` for each flag of the record itself but that of a missing direction.
    ``quality`` is their product.
    """
    touching = a > 0
    span = max(float(np.ptp(part.P)) for part in best.model.stretches)
    off = best.off[touching]
    noise = max(record_side.base.noise for record_side in record.directions)
    slow = math.sqrt(max(float(np.mean(off**2)) - noise**2, 0.0)) / span if off.size else 0.0
    depth = max(part.reach for part in best.model.stretches)
    contact = best.error("z0") / depth if "z0" in best.names else 0.0
    wavy = max(side.base.waviness for side in record.directions) / span
    flags = {} if best.ended else {"not determined": GIVEN_UP.format(best.least.steps)}
    beyond = (best.spread.excess - 1) / TUNING.excess
    if beyond > 1:
        flags["misfit"] = (
            f"the residuals in contact are {best.spread.excess:.0f} times what the noise of the free rows explains: "
            "another body, indenter or adhesion"
        )
    if slow > TUNING.misfit:
        flags["misfit"] = f"the residuals in contact are {slow:.1%} of the range of the load: another body or indenter"
    if noise / span > TUNING.vague:
        flags["noisy"] = f"the noise is {noise / span:.0%} of the range of the load"
    if contact > TUNING.vague:
        flags["vague contact point"] = f"known to {contact:.0%} of the depth only"
    ratios = {"misfit": max(slow / TUNING.misfit, beyond), "noise": noise / span / TUNING.vague,
              "base line": wavy / TUNING.misfit, "contact point": contact / TUNING.vague}  # fmt: skip
    parts = {name: math.exp(-(x**2) / 2) for name, x in ratios.items()}
    parts["record"] = TUNING.spoilt ** sum(not name.endswith((APPROACH, RETRACT)) for name in record.flags)
    return flags, {"quality": math.prod(parts.values()), **parts}


def sentences(best: ForceCurveFit, settings: Settings) -> Iterator[str]:
    """How the record was taken, and what its residuals did to the intervals."""
    if settings.base_line == "sine" and best.model.stretches[0].wave is None:
        yield "base line: no sine beyond its noise, a straight line is used"
    yield from _on_adhesion(best)
    free = [parameter.name for parameter in settings.free]
    for kind in (part.kind for part in best.model.stretches if best.model.works.get(part.kind) == 0 and "w" in free):
        yield f"{NAMES[kind]}: w would be negative and is set to 0: another body"
    if any(name.startswith("offset:") for name in best.model.known):
        yield "no base line: the zero of the load is set to 0 (--free P0, or --zero P=... if known)"
    model = best.model
    timed = all(np.ptp(part.t) > 0 for part in model.stretches)
    if timed and len(model.stretches) > 1 and "drift" not in model.positions:
        drift = drift_left_out(best)
        if drift.size > TUNING.sure and abs(drift.last) > TUNING.sure * drift.error:
            change = float(drift.step[best.names.index("ln_s")]) if "ln_s" in best.names else 0.0
            yield (
                f"drift: the depth drifts by {show(drift.last, 'speed', 3)} ± {show(drift.error, 'speed', 2)}, which "
                f"would change the moduli by {change:+.2%}: --free drift fits it"
            )
    if not all(part.line.rows for part in best.model.stretches):
        yield "no free rows: noise cannot be separated from misfit"
    if best.spread.tau > TUNING.dependent:
        yield (
            f"residuals are autocorrelated (effective sample size n/{best.spread.tau:.1f}), "
            f"which widens the intervals by {math.sqrt(best.spread.tau):.1f}"
        )


def _on_adhesion(best: ForceCurveFit) -> Iterator[str]:
    """What the fitted directions leave open about w."""
    known = best.model.known
    if len(best.model.stretches) == 1 and best.model.stretches[0].kind == APPROACH:
        yield "approach alone: its w is w_approach; w, that of the retraction, stays empty"
    if f"q:{RETRACT}" in known:
        yield RESTS

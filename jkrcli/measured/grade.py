"""How far the fit of a force curve is to be believed: sizes of what stands against it, and the grade that they give.

Thousands of rows reject every model of a real specimen: a p value counts rows. What matters is how far the fitted curve
misses the readings, over the load and over the pull-off force, and how far E* and w may be off: their errors hold what
alternative models would change, and what a direction that is left out does.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.numerics import Array
from .choices import Values
from .curve import APPROACH
from .fitted_record import FittedRecord
from .force_curve import ForceCurveFit, base_line
from .least_squares import SEARCH_DIGITS
from .parameters import FittedValue
from .score_tests import Verdict, by_unknown

GOOD, USABLE, LOOK, UNFIT = "good", "usable with the error stated", "look at it", "not usable"
GRADES = (GOOD, USABLE, LOOK, UNFIT)

# The largest size of each kind that is good, usable, or to be looked at, and its words. Chosen on every second of 164
# curves of real microscopes and on made records of 26 kinds, checked on the others (docs/project/counts.md).
LIMITS = {
    # tuned on these: of the range of the load; beyond 3 % other programs' Hertz describes a curve no more
    "misfit": (0.01, 0.03, 0.1, "misfit {} of the load"),
    "misfit_of_pull_off": (0.05, 0.2, 1.0, "misfit {} of the pull-off force"),  # tuned on these
    # tuned on these: all parts of the half-width over the value; where noise makes it wide the value is usable
    "E_star_error": (0.1, 1.0, 4.0, "E* ± {}"),
    "w_error": (0.25, 1.0, 4.0, "w ± {}"),
    # tuned on these: where directions tell another value each, no error makes one of them usable
    "E_star_by_direction": (0.1, 0.25, 9.0, "a direction left out changes E* by {}"),
    "w_by_direction": (0.25, 0.5, 9.0, "a direction left out changes w by {}"),
}
# Flags of what no size holds, beside those of what alternatives leave undetermined: the fit is to be looked at.
DOUBTS = ("no force curve", "wrong way", "wrong sign", "no base line", "some permanent set", "too stiff")
UNDETERMINED = "not determined"  # the flag of a search that did not end
LEFT_OUT = "a direction left out"  # the part of the model's error
UNEXPLAINED = "misfit"  # another
LEFT_OUT_APART = 4.0  # choice: standard errors, up to which what leaving out a direction changes is noise
LEFT_OUT_DIFFERS = 0.01  # choice: of E* or w, a change that is none
TENFOLD = 9.0  # theory: relative change of a quantity that becomes ten times as large
NO_MISFIT = {"misfit": 0.001, "misfit_of_pull_off": 0.005}  # choice: sizes up to which a misfit is none
NO_CHANGE = 0.001  # choice: of E* or w, what an alternative changes, up to which it is no other answer


@dataclass(frozen=True)
class Grade:
    """One of ``GRADES`` as ``word``, the ``reason`` that set it, and relative ``sizes`` by name."""

    word: str
    reason: str
    sizes: Values

    @property
    def believed(self) -> bool:
        """Whether the values hold within their errors."""
        return self.word in (GOOD, USABLE)

    @property
    def quality(self) -> float:
        """Between 0 and 1, by the worst of the sizes: 1/2 at the limit of what is usable."""
        worst = max((self.sizes[name] / LIMITS[name][1] for name in LIMITS if name in self.sizes), default=math.inf)
        return 1 / (1 + worst**2)


def grade_of(
    sizes: Values, flags: Sequence[str], E_star: FittedValue, w: FittedValue, verdict: Verdict | None
) -> Grade:
    """The grade of a raw record's fit, by ``sizes`` of its misfit, its ``flags``, estimates and ``verdict``."""
    errors = {"E_star_error": _error(E_star), "w_error": _error(w)}
    sizes = {**sizes, **{name: size for name, size in errors.items() if size is not None}}
    if verdict is not None and verdict.alternatives.named:
        best = verdict.alternatives.named[0]
        sizes |= {"E_star_by_alternative": best.change("E_star"), "w_by_alternative": best.change("w")}
    if w.free and "w_error" not in sizes:  # nothing pulls off
        sizes.pop("misfit_of_pull_off", None)
    graded = {name: LIMITS[name] for name in LIMITS if name in sizes}
    ranks = {name: sum(sizes[name] > limit for limit in (good, usable, look))
             for name, (good, usable, look, _) in graded.items()}  # fmt: skip
    worst = max(ranks, key=lambda name: (ranks[name], sizes[name] / graded[name][1]))
    rank, reason = ranks[worst], size_words({worst: sizes[worst]})[0]
    doubt = next((flag for flag in flags if flag in DOUBTS or flag.endswith(UNDETERMINED)), None)
    if UNDETERMINED in flags:
        rank, reason = GRADES.index(UNFIT), UNDETERMINED
    elif doubt and rank < GRADES.index(LOOK):
        rank, reason = GRADES.index(LOOK), doubt
    return Grade(GRADES[rank], reason, sizes)


def size_words(sizes: Values) -> list[str]:
    """Those of the ``sizes`` that are graded, in words."""
    words = {name: "more than tenfold" if size > TENFOLD else f"{100 * size:.{2 + (size > 1)}g} %"
             for name, size in sizes.items() if name in LIMITS}  # fmt: skip
    return [LIMITS[name][3].format(said) for name, said in words.items()]


def kind_of(reason: str) -> str:
    """A reason without its sentence and its numbers, by which curves are counted: "no contact", "E* uncertain"."""
    short = re.sub(" ± .*", " uncertain", re.split("[:,] ", reason)[0])
    return re.sub(r"( by)? (\S+ ?%|more than tenfold)", "", short)


def change_words(change: float) -> str:
    """A relative change in words; of one step, which is of first order, no more than that it is tenfold."""
    return f"{change:+.1%}" if change < TENFOLD else "more than tenfold"


def _error(item: FittedValue) -> float | None:
    """The half-width of all parts of the error over the value, where that is determined and above 0."""
    if not item.free or item.error is None or not item.low or not item.high:
        return None
    return ((item.high - item.low) / 2 + math.hypot(*(item.model or {}).values())) / item.value


def misfits(best: ForceCurveFit, noise: float) -> dict[str, float]:
    """Root mean square of what the fit leaves beyond the ``noise`` [N] of the free rows: over the range of the load in
    contact, or of free rows that a contact pulls the line off; over the largest tension of rows under tension."""
    values, touching = best.model.values(best.x), best.a > 0
    net = np.concatenate([part.P - base_line(part, values)[0] for part in best.model.stretches]) + best.off

    def slow(rows: Array) -> float:
        return math.sqrt(max(float(np.mean(best.off[rows] ** 2)) - noise**2, 0.0)) if rows.any() else 0.0

    span, tense = max(part.span for part in best.model.stretches), touching & (net < 0)
    sizes = {"misfit": max(slow(touching), slow(~touching)) / span}
    if tense.any():
        sizes["misfit_of_pull_off"] = slow(tense) / -float(net[tense].min())
    return sizes


def is_misfit(sizes: Values) -> bool:
    """Whether a misfit is large enough to matter, however little noise there is."""
    return any(sizes.get(name, 0.0) > limit for name, limit in NO_MISFIT.items())


def left_out(record: FittedRecord) -> dict[str, float]:
    """How far E*, and the w of the other direction, move where a direction is left out, relative and to first order;
    nothing of those that move no more than noise moves them."""
    fit, stretches, moves = record.fit, record.model.stretches, dict[str, float]()
    if len(stretches) < 2 or "ln_s" not in fit.names:
        return moves
    scale = np.linalg.norm(record.jacobian, axis=0)
    scale[scale == 0] = 1.0
    J, first = record.jacobian / scale, stretches[0].P.size
    for part, kept in zip(stretches, (slice(first), slice(first, None)), strict=True):
        inverse = np.linalg.pinv(J[kept].T @ J[kept], rcond=SEARCH_DIGITS**2, hermitian=True)
        step = inverse @ (J[kept].T @ record.residuals[kept])
        works = {"w_approach" if part.kind == APPROACH else "w": by_unknown(fit, [part])}
        for quantity, by in ({"E_star": {"ln_s": 1.0}} | works).items():
            rate = np.array([by.get(name, 0.0) for name in fit.names]) / scale
            error = fit.sigma * math.sqrt(max(float(rate @ inverse @ rate), 0.0))
            move = abs(float(rate @ step))
            if move > max(LEFT_OUT_APART * error, LEFT_OUT_DIFFERS):
                moves[quantity] = max(move, moves.get(quantity, 0.0))
    return moves

"""What it matters whether the surfaces stick or slide: the same body solved roughly under both assumptions.

The sides of a finite body are left out. Eq. 13 holds for either: with the S, S', delta_H and P_H of a contact that was
laid down without adhesion and then retracted, the radial displacements with which points were touched do no work.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import Array, Estimate, JkrError, Unknown, show
from ..bodies import Problem, unbounded
from ..methods.layered import layered, stack, stuck
from ..series import Series, Solution


@dataclass(frozen=True)
class StickingEffectTuning:
    """The rough solutions, and when their difference is worth a word."""

    # tuned on bodies, by `make constants`: of ratios that are shown to three digits; most are a hundred times as good
    accuracy: float = 1e-2
    radii: int = 25  # tuned on bodies, by `make constants`: where pull-off is sought
    # of the largest radius, the least of them; tuned on bodies, by `make constants`: below, the contact is a
    # half-space's
    smallest: float = 0.02
    # of it, one more; tuned on bodies, by `make constants`: a stuck contact is wider at equal depth by less
    beyond: float = 1.1
    noticeable: float = 0.05  # relative change from which a reader is warned; choice: as for Tabor numbers


TUNING = StickingEffectTuning()
OUTSIDE = Unknown("pull-off lies outside the series")
NOT_KEPT = Unknown("series files do not keep it")


@dataclass(frozen=True)
class StickingEffect:
    """Sticking over sliding: ``load`` and ``stiffness_at_depth`` S at equal depth, ``stiffness`` S at equal radius, all
    at the radius ``a`` [m]; ``pull_off``: of the pull-off force under load control for each work of adhesion
    [J/m^2]."""

    a: float
    load: float
    stiffness: float
    pull_off: dict[float, Estimate]
    stiffness_at_depth: Estimate = NOT_KEPT

    @property
    def largest(self) -> float:
        """The largest of the relative changes."""
        pulls = (value for value in self.pull_off.values() if not isinstance(value, Unknown))
        return max(abs(ratio - 1) for ratio in (self.load, self.stiffness, *pulls))

    @property
    def words(self) -> str:
        """``1.63 times the load at equal depth, 1.7 times S, 0.956 times the pull-off force``."""
        pulls = [f"{value:.3g}" for value in self.pull_off.values() if not isinstance(value, Unknown)]
        parts = [f"{self.load:.3g} times the load at equal depth", f"{self.stiffness:.3g} times S"]
        return ", ".join(parts + ([f"{' and '.join(dict.fromkeys(pulls))} times the pull-off force"] if pulls else []))

    def as_dict(self) -> dict[str, Any]:
        """The radius [m] and the ratios [-] as they stand in JSON."""
        pulls = [{"w_J_per_m2": w, "ratio": value} for w, value in self.pull_off.items()]
        return {"a_m": self.a, "load": self.load, "S": self.stiffness, "pull_off": pulls}


def sticking_effect(problem: Problem, largest: float, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on ``problem`` at the contact radius ``largest`` [m], or why it is not known."""
    if problem.specimen.surface_tension:
        return Unknown("effect of no slip unknown: it is not derived with surface tension")
    body = unbounded(problem)
    if reason := stuck.unable(body.indenter, body.specimen):
        return Unknown(f"effect of no slip unknown: {reason}")
    pair = stack.LayeredContact(body.indenter, body.specimen), stuck.StuckLayeredContact(body.indenter, body.specimen)
    if largest > layered.QUICK * pair[1].scale:
        return Unknown(f"effect of no slip not computed at a contact radius of {largest:.3g} m")
    a0 = body.indenter.a0
    radii = a0 + (largest - a0) * np.append(np.geomspace(TUNING.smallest, 1.0, TUNING.radii), TUNING.beyond)
    radii = radii[radii < body.indenter.r_max]
    try:
        sliding, sticking = (_series(contact, radii) for contact in pair)
        pull_off = pull_off_ratios(sticking, sliding, [w for w in works if w > 0])
    except JkrError as error:
        return Unknown(f"effect of no slip unknown: {error}")
    last = min(TUNING.radii, radii.size) - 1
    depth = min(sliding.delta[last], sticking.delta[-1])
    assert sliding.S is not None
    assert sticking.S is not None
    load = _at(sticking, sticking.P, depth) / _at(sliding, sliding.P, depth)
    at_depth = _at(sticking, sticking.S, depth) / _at(sliding, sliding.S, depth)
    return StickingEffect(largest, load, float(sticking.S[last] / sliding.S[last]), pull_off, at_depth)


def _series(contact: stack.LayeredContact | stuck.StuckLayeredContact, radii: Array) -> Series:
    result: Any = contact.solved(radii, contact.plan(radii, TUNING.accuracy))  # type: ignore[arg-type]
    return Series(radii, result.delta, result.P, result.S, result.dS, a0=contact.indenter.a0)


def _at(series: Series, column: Array, depth: float) -> float:
    """A ``column`` of the series at a ``depth`` [m], between its rows along a power law."""
    return float(np.exp(np.interp(np.log(depth), np.log(series.delta), np.log(column))))


def pull_off_ratios(
    one: Series, other: Series, works: Sequence[float], outside: Unknown = OUTSIDE
) -> dict[float, Estimate]:
    """The pull-off force under load control of one series with exact slopes over that of the other, for each of the
    ``works`` of adhesion [J/m^2]; what lies between the rows is found once for all of them."""
    from ..adhesion import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Nonadhesive

    pair, ratios = [Nonadhesive.of(each, "exact") for each in (one, other)], dict[float, Estimate]()
    for w in works:
        first, second = (AdhesiveCurve(functions, w).pull_off(LOAD_CONTROL) for functions in pair)
        known = isinstance(first, CriticalPoint) and isinstance(second, CriticalPoint)
        ratios[w] = first.P / second.P if known else outside  # type: ignore[union-attr]
    return ratios


def sticking_warnings(problem: Problem, effect: StickingEffect | Unknown) -> Iterator[str]:
    """Sentences on an assumption that matters by more than ``TUNING.noticeable``."""
    if isinstance(effect, Unknown) or effect.largest <= TUNING.noticeable:
        return
    other = "sliding" if problem.sticks else "sticking"
    assumed = "no slip" if problem.sticks else "no friction"
    yield (
        f"{assumed} is assumed: no slip gives {effect.words} of frictionless contact (a = "
        f'{show(effect.a, "length")}): compare specimen.surface = "{other}"'
    )


def effect_facts(effect: StickingEffect | Unknown) -> dict[str, float | str]:
    """What a series file keeps of it."""
    if isinstance(effect, Unknown):
        return {"sticking_over_sliding": str(effect)}
    return {"sticking_over_sliding_load": effect.load, "sticking_over_sliding_S": effect.stiffness}


def effect_on(solution: Solution, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on a solved body with its pull-off forces; not computed again where its file has it as small."""
    load, stiffness = (solution.facts.get(f"sticking_over_sliding_{name}") for name in ("load", "S"))
    a = float(solution.series.a[-1])
    if isinstance(load, float) and isinstance(stiffness, float):
        small = Unknown("not computed: load and S hardly differ")
        effect = StickingEffect(a, load, stiffness, dict.fromkeys(works, small))
        if effect.largest <= TUNING.noticeable:
            return effect
    return sticking_effect(solution.problem, a, works)


def effect_as_json(effect: StickingEffect | Unknown) -> Any:
    """The effect as it stands in JSON, or why it is not known."""
    return str(effect) if isinstance(effect, Unknown) else effect.as_dict()

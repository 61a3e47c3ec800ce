"""What it matters whether the surfaces stick or slide: the same body solved roughly under both assumptions.

The sides of a finite body are left out. Eq. 13 holds for either: with the S, S', delta_H and P_H of a contact that
was laid down without adhesion and then retracted, the radial displacements with which points were touched do no
work.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import Estimate, JkrError, Unknown
from ..base.numerics import Array
from ..base.units import show
from ..bodies.problem import Problem, without_side_walls
from ..methods.layered import contact as stack
from ..methods.layered import no_slip, solver
from ..series import Series, Solution

# The rough solutions, and when their difference is worth a word.
# tuned on bodies, by `make constants`: of ratios that are shown to three digits; most are a hundred times as good
STICKING_EFFECT_ACCURACY = 1e-2
STICKING_EFFECT_RADII = 25  # tuned on bodies, by `make constants`: where pull-off is sought
# of the largest radius, the least of them; tuned on bodies, by `make constants`: below, the contact is a
# half-space's
STICKING_EFFECT_SMALLEST = 0.02
# of it, one more; tuned on bodies, by `make constants`: a stuck contact is wider at equal depth by less
STICKING_EFFECT_BEYOND = 1.1
STICKING_EFFECT_NOTICEABLE = 0.05  # relative change from which a reader is warned; choice: as for Tabor numbers

NOT_KEPT = Unknown("solution files do not keep it")


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
        """``1.63 times the load at equal depth, 1.7 times S at equal radius, 0.956 times the pull-off force``, the last
        with each w where they differ."""
        pulls = {w: f"{value:.3g}" for w, value in self.pull_off.items() if not isinstance(value, Unknown)}
        alike = len(set(pulls.values())) < 2
        each = dict.fromkeys(value if alike else f"{value} (w = {show(w, 'work')})" for w, value in pulls.items())
        parts = [f"{self.load:.3g} times the load at equal depth", f"{self.stiffness:.3g} times S at equal radius"]
        return ", ".join(parts + ([f"{' and '.join(each)} times the pull-off force"] if pulls else []))


def sticking_effect(problem: Problem, largest: float, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on ``problem`` at the contact radius ``largest`` [m], or why it is not known."""
    if problem.specimen.surface_tension:
        return Unknown("effect of no slip unknown: it is not derived with surface tension")
    body = without_side_walls(problem)
    if reason := no_slip.why_unsupported(body.indenter, body.specimen):
        return Unknown(f"effect of no slip unknown: {reason}")
    pair = stack.LayeredContact(body.indenter, body.specimen), no_slip.StuckLayeredContact(body.indenter, body.specimen)
    if largest > solver.QUICK * pair[1].scale:
        return Unknown(f"effect of no slip not computed at a contact radius of {largest:.3g} m")
    a0 = body.indenter.a0
    radii = a0 + (largest - a0) * np.append(
        np.geomspace(STICKING_EFFECT_SMALLEST, 1.0, STICKING_EFFECT_RADII), STICKING_EFFECT_BEYOND
    )
    radii = radii[(radii < body.indenter.r_max) & (radii <= body.indenter.rim)]
    try:
        solved: list[Series] = []
        for contact in pair:
            result: Any = contact.solved(radii, contact.plan(radii, STICKING_EFFECT_ACCURACY))  # type: ignore[arg-type]
            solved.append(Series(radii, result.delta, result.P, result.S, result.dS, a0=a0, rim=body.indenter.rim))
        sliding, sticking = solved
        pull_off: dict[float, Estimate] = {}
        if pulled := [w for w in works if w > 0]:
            from .resolve import pull_off_ratios

            pull_off = pull_off_ratios(sticking, sliding, pulled)
    except JkrError as error:
        return Unknown(f"effect of no slip unknown: {error}")
    last = min(STICKING_EFFECT_RADII, radii.size) - 1
    stiffness = float(sticking.stiffness[last] / sliding.stiffness[last])
    if body.indenter.rim < math.inf:
        return StickingEffect(largest, stiffness, stiffness, pull_off, stiffness)
    depth = min(sliding.delta[last], sticking.delta[-1])
    load = _punch_at(sticking, sticking.P, depth) / _punch_at(sliding, sliding.P, depth)
    at_depth = _punch_at(sticking, sticking.stiffness, depth) / _punch_at(sliding, sliding.stiffness, depth)
    return StickingEffect(largest, load, stiffness, pull_off, at_depth)


def _punch_at(series: Series, column: Array, depth: float) -> float:
    """A ``column`` of the series at a ``depth`` [m], between its rows along a power law."""
    return float(np.exp(np.interp(np.log(depth), np.log(series.delta), np.log(column))))


def sticking_warnings(problem: Problem, effect: StickingEffect | Unknown) -> Iterator[str]:
    """Sentences on an assumption that matters by more than ``STICKING_EFFECT_NOTICEABLE``."""
    if isinstance(effect, Unknown) or effect.largest <= STICKING_EFFECT_NOTICEABLE:
        return
    other = "sliding" if problem.sticks else "sticking"
    assumed = "no slip" if problem.sticks else "no friction"
    yield (
        f"{assumed} is assumed: no slip gives {effect.words} of frictionless contact (a = "
        f'{show(effect.a, "length")}): compare with specimen.surface = "{other}"'
    )


def sticking(effect: StickingEffect | Unknown) -> dict[str, Any] | str:
    """The radius [m] and the ratios [-] of an effect, or why it is not known."""
    if isinstance(effect, Unknown):
        return str(effect)
    pulls = [{"w_J_per_m2": w, "ratio": value} for w, value in effect.pull_off.items()]
    return {"a_m": effect.a, "load": effect.load, "S": effect.stiffness, "pull_off": pulls}


def effect_facts(effect: StickingEffect | Unknown) -> dict[str, float | str]:
    """What a solution file keeps of it."""
    if isinstance(effect, Unknown):
        return {"sticking_over_sliding": str(effect)}
    return {"sticking_over_sliding_load": effect.load, "sticking_over_sliding_S": effect.stiffness}


def effect_on(solution: Solution, works: Sequence[float]) -> StickingEffect | Unknown:
    """Effect on a solved body with its pull-off forces; not computed again where its file has it as small, and not of a
    contact that is no disc."""
    from ..adhesion.contact_shape import ContactShape

    if ContactShape.of(solution.facts, False):
        return Unknown("effect of no slip unknown: it is solved for contacts that are discs")
    load, stiffness = (solution.facts.get(f"sticking_over_sliding_{name}") for name in ("load", "S"))
    a = float(solution.series.a[-1])
    if isinstance(load, float) and isinstance(stiffness, float):
        small = Unknown("not computed: load and S hardly differ")
        effect = StickingEffect(a, load, stiffness, dict.fromkeys(works, small))
        if effect.largest <= STICKING_EFFECT_NOTICEABLE:
            return effect
    return sticking_effect(solution.problem, a, works)

"""Where the assumptions of JKR theory hold: plain functions of SI numbers, so that a stored file can be judged too.

Limits: Johnson and Greenwood, J. Colloid Interface Sci. 192 (1997) 326 (the adhesion map over the Tabor number);
geometrically linear kinematics and the half-space profile need small a/R and delta/h; an edge whose speed matters is a
line where the zone in which it dissipates is narrow.

The Tabor number is that of a half-space. What a range of the forces changes on any other body is solved for
(``range_effect``) and decides, where it is known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..base.errors import Estimate, InputError, Refusal, Unknown, counted
from ..base.numerics import SAME
from ..base.units import show
from ..bodies.indenters import Indenter
from ..bodies.problem import INCOMPRESSIBLE, Elastic, HalfSpace, Problem
from ..formulas import BY_DISPLACEMENT, BY_LOAD, edge_angle, strained_pull_off, tabor
from ..series import Series

if TYPE_CHECKING:
    from .curve import Equilibrium


@dataclass(frozen=True)
class TheoryLimits:
    """The limits of JKR theory, each with its source; a result beyond one is warned of."""

    tabor_jkr: float = 5.0  # theory: Johnson and Greenwood (1997), JKR within some per cent above it
    tabor_dmt: float = 0.1  # theory: the same, rigid-body (DMT, Bradley) limit below it
    effect: float = 0.01  # choice: of the pull-off force, that a range may change unsaid; no more model than needed
    wrong: float = 0.1  # choice: from where on JKR does not hold, of the same
    a_over_R: float = 0.3  # choice: strains and slopes of order a/R
    edge_angle: float = 0.5  # choice: [rad], small slopes of Young and Dupre's law: tan errs by 9 %
    steepest: float = 2.0  # theory: [rad], theta = 2 at w = 2 Ups, complete wetting: no angle beyond
    # of a/R, delta/h at pull-off, above which large strains of bodies are named of which no number is known
    strained: float = 0.2  # choice: 8 % of the force where it is known
    # choice: of the pull-off force, from which on large strains are said: a tenth of ``effect``, and finer than force
    # sensors and moduli are calibrated
    strains_said: float = 1e-3
    atom: float = 1e-10  # theory: [m], below which there is no zone at the edge
    seen: int = 2  # theory: points per bend of a tabulated profile, with which slopes fitted through them see it


LIMITS = TheoryLimits()
Strains: TypeAlias = "tuple[float, float] | Unknown | None"  # least and largest relative change; None: negligible
LARGEST, EDGE = "at the largest contact radius", "rad at the edge"
STEEP = "theta = sqrt(2 w/Ups)"
SMALL = 0.1  # choice: of what theories take as small: strains, zones at the edge, the contact in its mesh
NO_TIP_RADIUS = Unknown("the tip has no radius of curvature: pointed or flat")
NO_TENSION = Unknown("no surface tension")
# P of small strains over that of a neo-Hookean half-space pressed as deep by a rigid sphere without friction, less 1,
# over a/R: finite elements, nu = 0.49
STRAINED = np.array([0.0, 0.2, 0.3, 0.5, 0.7, 0.8])
EXCESS = {
    "sphere": np.array([0.0, 0.010, 0.016, 0.029, 0.047, 0.061]),
    "paraboloid": np.array([0.0, 0.015, 0.026, 0.056, 0.108, 0.15]),
}
NO_EXCESS = Unknown("large strains are known of spheres on half-spaces and layers as thick, up to a/R = 0.8")
NOT_SOLVED = Unknown("the pull-off force at the range z0 was not computed")
FROM_RIM = Unknown("attraction over the range z0 reaches far in from the rim, its effect is known on half-spaces only")
NO_LAYER = Unknown("no layer: the specimen is a half-space")
NO_RANGE, NO_ADHESION = Unknown("no equilibrium distance z0 given"), Unknown("no adhesion (w = 0)")


@dataclass(frozen=True)
class Validity:
    """The numbers by which a result is judged; each a number or the reason why there is none.

    ``a_over_R``, ``delta_over_h``, ``a_over_h``, ``a_over_L``: at the largest radius of the series, L being the lateral
    or vertical size at which the body or its mesh ends. ``a_over_R_pull_off``: at pull-off, under load
    control where no other is asked for.
    ``end_is_cut``: the specimen goes on where the model ends; the ends of a finite specimen are part of its solution.
    ``edge_angle``: between the surfaces at the edge under surface tension [rad]. ``strained``: the load at the largest
    depth over that of a rubber at large strains, less 1; ``sphere``: that of the exact sphere where it is better.
    ``effect_of_range``: the pull-off force under load control at the range z0 over JKR's, less 1. ``large_strains``:
    the least and the largest relative change of the pull-off force by them.
    """

    tabor: Estimate
    regime: str
    a_over_R: Estimate
    a_over_R_pull_off: Estimate
    delta_over_h: Estimate
    a_over_h: Estimate
    a_over_L: Estimate
    end_is_cut: bool = True
    effect_of_range: Estimate = NOT_SOLVED
    edge_angle: Estimate = NO_TENSION
    strained: Estimate = NO_EXCESS
    sphere: Estimate = NO_EXCESS
    large_strains: Strains = None

    @property
    def verdict(self) -> str:
        """Whether JKR holds, by the Tabor number or, where the tip has none, by what a range changes; "" if unknown."""
        if self.effect_of_range is FROM_RIM:
            return f"whether JKR holds is unknown: {FROM_RIM}"
        if isinstance(self.tabor, Unknown):
            return "" if isinstance(self.effect_of_range, Unknown) else self.regime
        return f"Tabor number {self.tabor:.3g}: {self.regime}"

    @property
    def warnings(self) -> list[str]:
        """What is beyond a limit, each with its number; empty where all is well or nothing is known."""
        # What is lost without a range, solved for; by the Tabor number where that is not known
        number, effect = self.tabor, self.effect_of_range
        by_tabor = "" if isinstance(number, Unknown) else f" (Tabor number {number:.3g})"
        range_warning = []
        if not isinstance(effect, Unknown):
            if abs(effect) >= LIMITS.effect:
                range_warning = [f"{_by_range(effect)}{by_tabor}{f': {REMEDY}' if by_tabor else ''}"]
        elif not isinstance(number, Unknown) and number < LIMITS.tabor_jkr:
            range_warning = [f"Tabor number {number:.3g} is below {LIMITS.tabor_jkr:g}: {self.regime}"]
        # What large strains do to the load, in per cent where that is known
        if isinstance(self.strained, Unknown) or isinstance(self.sphere, Unknown):
            strains = "small-strain theory becomes inaccurate"
        else:
            better = f'; with indenter.shape = "sphere" by {self.sphere:.1%}'
            strains = (
                f"linear elasticity overestimates P by about {self.strained:.1%} at this depth (neo-Hookean)"
                f"{better if self.sphere < self.strained else ''}"
            )
        return [
            *_above(self.a_over_R, LIMITS.a_over_R, "a/R", strains),
            *_above(self.delta_over_h, SMALL, "delta/h", "small strains no longer hold in the layer"),
            *_above(
                self.edge_angle,
                LIMITS.edge_angle,
                STEEP,
                "the pull-off force assumes small slopes of the surface",
                EDGE,
            ),
            *(_above(self.a_over_L, SMALL, "a/L", "the cut of the mesh affects the result") if self.end_is_cut else ()),
            *range_warning,
        ]


def large_strains(
    problem: Problem, w: float, point: Equilibrium, loaded: bool = True, moved: float | None = None
) -> Strains:
    """What large strains change of the pull-off force at the ``point``, under load control or another; None where that
    is negligible, below ``LIMITS.strains_said``. ``moved``: how far the surface has moved [m], where that is not
    delta: surfaces that attract each other over a gap.

    Known of rigid spheres on incompressible half-spaces and layers as thick as R, up to (w/(E* R))^(1/3) = 0.3.
    """
    R, depth = problem.indenter.tip_radius, problem.specimen.yielding_depth
    if R is None or w == 0:
        return None
    if strains_are_known(problem):
        wc = (w / (problem.E_star * R)) ** (1 / 3)
        found = strained_pull_off(wc, BY_LOAD if loaded else BY_DISPLACEMENT, problem.indenter.noun == "sphere")
        if found is None:
            return Unknown(f"beyond the estimate: (w/(E* R))^(1/3) = {wc:.3g} is above 0.3")
        return found if strain_size(found) >= LIMITS.strains_said else None
    name, moved = ("|delta|/h", point.delta) if moved is None else ("surface displacement/h", moved)
    ratios = {"a/R": point.a / R, name: abs(moved) / depth}
    name = max(ratios, key=lambda each: ratios[each])
    if ratios[name] <= LIMITS.strained:
        return None
    return Unknown(f"of unknown effect, {name} = {ratios[name]:.2g} at pull-off")


def strains_are_known(problem: Problem) -> bool:
    """Whether elements have measured what large strains change of the pull-off force from a body."""
    specimen, indenter = problem.specimen, problem.indenter
    R, material = indenter.tip_radius, specimen.materials[0]
    thick = R is not None and min(specimen.top_thickness, specimen.yielding_depth) >= R and specimen.radius is None
    plain = indenter.material is None and not (problem.sticks or specimen.surface_tension)
    soft = isinstance(material, Elastic) and material.nu >= INCOMPRESSIBLE
    return thick and plain and soft and indenter.noun in EXCESS


def strain_words(change: Strains) -> str:
    """``large strains -4.4 to +1.2 %``; empty where they are negligible."""
    if change is None:
        return ""
    if isinstance(change, Unknown):
        return f"large strains {change}"
    low, high = (float(f"{100 * value:.2g}") for value in change)
    return f"large strains {low:+g} to {high:+g} %"


def strain_size(change: Strains) -> float:
    """The size of the change, relative: 1 where it is not estimated."""
    return 0.0 if change is None else 1.0 if isinstance(change, Unknown) else max(map(abs, change))


def with_large_strains(judged: Validity, change: Strains) -> Validity:
    """What was ``judged``, with the ``change`` of the pull-off force by large strains: JKR does not hold where they are
    more than may remain unsaid."""
    regime = judged.regime
    if strain_size(change) > LIMITS.effect:
        small = regime.startswith("JKR holds")
        regime = "short-range adhesion, but large strains" if small else f"{regime}; {strain_words(change)}"
    return replace(judged, regime=regime, large_strains=change)


def sizes(problem: Problem) -> dict[str, Any]:
    """What ``judge`` asks of the bodies themselves."""
    specimen, indenter = problem.specimen, problem.indenter
    of_specimen = {"h": specimen.top_thickness, "depth": specimen.yielding_depth, "tension": specimen.surface_tension}
    return {"E_star": problem.E_star, **of_specimen, "R": indenter.tip_radius, "profile": indenter.noun}


def refuse_wetting(w: float, tension: float) -> None:
    """Refusal of a work of adhesion ``w`` [J/m^2] that a surface ``tension`` [N/m] > 0 leaves no contact angle to."""
    if tension and edge_angle(w, tension) > LIMITS.steepest:
        raise Refusal(
            f"w = {show(w, 'work')} is more than twice the surface tension, {show(tension, 'tension')}: it wets the "
            f"indenter, no angle exists at the edge (Young and Dupre); give w up to {show(2 * tension, 'work')}"
        )


def judge_solution(
    problem: Problem,
    series: Series,
    facts: Mapping[str, Any],
    *,
    w: float = 0.0,
    z0: float | None = None,
    a_pull_off: float | None = None,
    effect_of_range: Estimate = NOT_SOLVED,
) -> Validity:
    """Judge a solved ``problem`` by the end of its ``series``; ``facts``: those of the solution, the rest as of
    ``judge``."""
    # Where the body or its mesh ends sideways, or below where that is a cut through a half-space
    ends = [problem.specimen.radius, facts.get("width_m")]
    if isinstance(problem.specimen.base, HalfSpace):
        ends.append(facts.get("depth_m"))
    L = min((float(end) for end in ends if isinstance(end, int | float) and end > 0), default=None)
    a, delta, _ = series.end
    return judge(a=a, delta=delta, w=w, **sizes(problem), z0=z0, L=L,
                 end_is_cut=problem.specimen.radius is None, a_pull_off=a_pull_off,
                 effect_of_range=effect_of_range)  # fmt: skip


def judge(
    *,
    a: float,
    delta: float,
    E_star: float,
    w: float,
    R: float | None,
    h: float | None,
    L: float | None,
    z0: float | None,
    depth: float | None = None,
    tension: float = 0.0,
    profile: str = "",
    a_pull_off: float | None = None,
    end_is_cut: bool = True,
    effect_of_range: Estimate = NOT_SOLVED,
) -> Validity:
    """Judge a series that ends at contact radius ``a`` [m] and displacement ``delta`` [m].

    ``R``: tip radius [m], None where the indenter has none. ``h``: thickness [m] of the layer that the contact feels,
    None or infinite for a half-space. ``L``: size [m] of the body or mesh, None for an unbounded exact solution.
    ``depth``: that to which the body is squeezed [m], ``h`` if not given (``Specimen.yielding_depth``).
    ``tension``: of the surface [N/m]; ``profile``: noun of the indenter. ``z0``: equilibrium distance of the adhesive
    forces [m]; ``w`` in J/m^2, ``E_star`` in Pa.
    """
    thickness = None if h is None or math.isinf(h) else h
    depth = thickness if depth is None else None if math.isinf(depth) else depth
    number = _tabor(R, w, E_star, z0)
    if not isinstance(effect_of_range, Unknown):
        holds = "JKR holds" if abs(effect_of_range) < LIMITS.effect else _by_range(effect_of_range)
    else:
        holds = f"unknown: {number.reason}" if isinstance(number, Unknown) else regime(number)
    return Validity(
        number,
        holds,
        _ratio(a, R, NO_TIP_RADIUS),
        Unknown("no pull-off radius given") if a_pull_off is None else _ratio(a_pull_off, R, NO_TIP_RADIUS),
        _ratio(delta, depth, NO_LAYER if thickness is None else Unknown("no layer lies on anything stiffer")),
        _ratio(a, thickness, NO_LAYER),
        _ratio(a, L, Unknown("the body is unbounded in this method")),
        end_is_cut,
        effect_of_range,
        edge_angle(w, tension) if tension else NO_TENSION,
        strained=NO_EXCESS if tension else _excess(a, R, depth, profile),
        sphere=NO_EXCESS if tension else _excess(a, R, depth, "sphere"),
    )


def _by_range(effect: float) -> str:
    size = f"{100 * abs(effect):.3g} % {'larger' if effect > 0 else 'smaller'}"
    holds = "is doubtful" if abs(effect) < LIMITS.wrong else "does not hold"
    return f"JKR {holds}: attraction over the range z0 makes the pull-off force {size}"


def _excess(a: float, R: float | None, depth: float | None, profile: str) -> Estimate:
    """P of small strains over that of large ones at equal depth, less 1, at the radius ``a`` [m] under a tip ``R`` [m]
    on a half-space (``depth`` None) or a layer as thick."""
    if R is None or profile not in EXCESS or a > STRAINED[-1] * R or (depth is not None and depth < R):
        return NO_EXCESS
    return float(np.interp(a / R, STRAINED, EXCESS[profile]))


REMEDY = "give --range or --stress, or adhesion.range, for adhesion of finite range (Maugis-Dugdale)"


def regime(number: float) -> str:
    """What a Tabor number means, in words, and which model to use instead of JKR."""
    if number > LIMITS.tabor_jkr:
        return "JKR holds"
    if number >= LIMITS.tabor_dmt:
        return f"JKR is doubtful: {REMEDY}"
    return f"JKR does not hold, DMT is near: {REMEDY}"


def _above(value: Estimate, limit: float, name: str, meaning: str, where: str = LARGEST) -> list[str]:
    if isinstance(value, Unknown) or value <= limit * (1 + SAME):
        return []
    return [f"{name} = {value:.3g} {where} is above {limit:g}: {meaning}"]


def _tabor(R: float | None, w: float, E_star: float, z0: float | None) -> Estimate:
    if R is None:
        return NO_TIP_RADIUS
    if z0 is None:
        return NO_RANGE
    if w == 0:
        return NO_ADHESION
    if min(R, w, E_star, z0) <= 0:
        raise InputError(f"Tabor number: R, w, E* and z0 must be > 0, got {R:g}, {w:g}, {E_star:g}, {z0:g}")
    return tabor(R, w, E_star, z0)


def _ratio(value: float, size: float | None, reason: Unknown) -> Estimate:
    if size is None or math.isinf(size):
        return reason
    if size <= 0:
        raise InputError(f"validity: a size must be > 0 m, got {size:g}")
    return value / size


def unresolved(indenter: Indenter, a: np.ndarray) -> tuple[str, ...]:
    """A warning where slopes fitted through the radii ``a`` [m] cannot see every bend of a tabulated profile."""
    bends = sum(indenter.a0 < kink < a[-1] for kink in indenter.kinks)
    if a.size >= LIMITS.seen * bends:
        return ()
    return (
        f"the {indenter.noun} has {counted(bends, 'kink')} within the contact and the solution has "
        f"{counted(a.size, 'point')}: slopes fitted through the points miss kinks between them; give more "
        "points, or take a method with exact slopes",
    )


def faces(problem: Problem, w: float) -> tuple[str, ...]:
    """A warning where a body of revolution stands for a tip that is none, and more than its load matters."""
    share = problem.indenter.contact_share
    if share == 1 or not (w > 0 or problem.layers):
        return ()
    return (
        f"the {problem.indenter.noun} has {share:.2g} of the contact area of the cone that stands for it: w acts about "
        f"as {share:.2g} w, which changes pull-off from a half-space by {share**2 - 1:.0%}, and layers act as under "
        f"{math.sqrt(share):.2g} of the contact radius; without both its load is right to 1e-4",
    )


SHARP_PRESSURE = 0.1  # theory: of E*, the order of the ideal strength; hardness is less (Johnson 1985, ch. 6)
SHARP_STIFF = 1e8  # choice: Pa; gels and rubbers below it stretch instead of flowing


def yield_warning(problem: Problem, series: Series) -> list[str]:
    """A warning where the mean pressure at the largest radius is one at which stiff bodies yield; confined layers,
    whose pressure is hydrostatic, and gels are left out."""
    a, _, P = series.end
    mean = P / (math.pi * a**2 * problem.E_star)
    confined = a > (problem.specimen.top_thickness or math.inf)
    if mean <= SHARP_PRESSURE or problem.E_star < SHARP_STIFF or confined:
        return []
    return [
        f"mean pressure {mean:.2g} E* at the largest contact radius is above {SHARP_PRESSURE:g} E*: most materials of "
        "that stiffness flow plastically first, and the contact is then larger than an elastic one"
    ]
